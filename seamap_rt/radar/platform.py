"""How the boat moves, at any time: where the point about which it turns is, and its attitude; and as sensors have it.

A motion is a smooth function of time, so that its rates are differences over a millisecond. Axes, signs and the order
of the angles are those of `pose`.

Sensors are biased, noisy, infrequent, and late. Reading k is taken at the time k/rate, of the motion `latency_s`
before, and the retrieval interpolates linearly between readings. The noise of a reading depends on the seed and on k
alone: any times in any order give the same readings. Where every time has a reading of its own (rate_hz = inf), k is
the time in whole microseconds. It comes from SplitMix64 (Steele, Lea & Flood 2014), whose nth number is a function of
n: a reading's own numbers are found without drawing those of all before it.
"""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass
from typing import Protocol

import numpy as np
import scipy
from numpy.typing import ArrayLike, NDArray

from .. import random_streams
from ..conventions import unit_from_azimuth
from ..io.motionfile import read_motion
from ..random_streams import Stream
from ..sea import Components, ResolvedWaves
from ..settings import PlatformSettings, SensorSettings
from .pose import boat_axes
from .wave_following import WaveFollowing, wave_tilt_std


@dataclass(frozen=True)
class BoatState:
    """The boat at n times."""

    position: NDArray[np.float64]  # (n, 3) m east north up, of the point about which it turns, from its rest at time 0
    attitude: NDArray[np.float64]  # (n, 3) deg roll pitch yaw; yaw is the heading, and does not jump at 360°


class SurfaceWaves(Protocol):
    """Waves that a boat can follow; current: m/s east, north."""

    @property
    def current(self) -> tuple[float, float]: ...

    def components(self) -> Components: ...


BoatMotion = Callable[[ArrayLike], BoatState]
"""The boat at times (n,) s."""


def boat_motion(platform: PlatformSettings, sea: SurfaceWaves | None = None) -> BoatMotion:
    """The motion that the settings ask for; `wave_following` needs the sea that the radar sees.

    Any time may be given, before 0 too, but of a recorded motion only those of its record. Raises ValueError for
    wave_following without a sea and InputError for a file of no use.
    """
    if platform.motion == "file":
        return _recorded(platform)
    if platform.motion == "sinusoidal":
        return _sinusoidal(platform)
    if platform.motion == "wave_following":
        if sea is None:
            raise ValueError("platform.motion = 'wave_following': must have a sea to follow; give the run's own sea")
        return _wave_following(platform, sea)
    return _fixed(platform)


def tilt_std(platform: PlatformSettings, duration_s: float, waves: ResolvedWaves) -> float:
    """Rms tilt [rad] along the look, the mean over looks: within duration_s, or of all time for a boat that follows
    the waves. Raises InputError for a file of no use."""
    if platform.motion == "wave_following":
        return wave_tilt_std(waves, platform.length_m, platform.beam_m)
    times = np.linspace(0.0, duration_s, _TILT_TIMES)
    attitude = np.radians(boat_motion(platform)(times).attitude[:, :2])
    return float(np.sqrt(0.5 * np.mean(np.sum(attitude**2, axis=1))))


def _fixed(platform: PlatformSettings) -> BoatMotion:
    """A steady attitude on a steady course."""

    def motion(times: ArrayLike) -> BoatState:
        time = np.asarray(times, dtype=np.float64)
        zero = np.zeros_like(time)
        return BoatState(_course_positions(platform, time, zero), _attitudes(platform, zero, zero, zero))

    return motion


def _sinusoidal(platform: PlatformSettings) -> BoatMotion:
    """Roll, pitch, yaw and heave swing about the steady attitude, each with its own period; the course is steady."""

    def swing(time: NDArray[np.float64], amplitude: float, period: float, phase: float) -> NDArray[np.float64]:
        return amplitude * np.sin(2.0 * np.pi * time / period + np.radians(phase))

    def motion(times: ArrayLike) -> BoatState:
        time, p = np.asarray(times, dtype=np.float64), platform
        roll = swing(time, p.roll_deg, p.roll_period_s, p.roll_phase_deg)
        pitch = swing(time, p.pitch_deg, p.pitch_period_s, p.pitch_phase_deg)
        yaw = swing(time, p.yaw_deg, p.yaw_period_s, p.yaw_phase_deg)
        heave = swing(time, p.heave_m, p.heave_period_s, p.heave_phase_deg)
        return BoatState(_course_positions(p, time, heave), _attitudes(p, roll, pitch, yaw))

    return motion


def _wave_following(platform: PlatformSettings, sea: SurfaceWaves) -> BoatMotion:
    """The deck lies along the plane that fits the waves best within the waterline, list and trim added to its angles.

    The middle of the waterline is the point about which the boat turns. On a current the boat's speed is still that
    over the ground, and the waves are carried past it.
    """
    east, north = unit_from_azimuth(platform.heading_deg)
    over_ground = platform.speed_m_s * np.array([east, north])
    through_water = over_ground - np.array(sea.current)
    riding = WaveFollowing(
        sea.components(),
        length_m=platform.length_m,
        beam_m=platform.beam_m,
        heading_deg=platform.heading_deg,
        velocity=(float(through_water[0]), float(through_water[1])),
        start=_rest_position(platform),
    )

    def motion(times: ArrayLike) -> BoatState:
        time = np.asarray(times, dtype=np.float64)
        heave, ahead, starboard = riding(time).T
        pitch = np.arctan(ahead)
        roll = -np.arctan(starboard * np.cos(pitch))  # about the keel, which is pitched already
        attitude = _attitudes(platform, np.degrees(roll), np.degrees(pitch), np.zeros_like(time))
        return BoatState(_course_positions(platform, time, heave), attitude)

    return motion


def _recorded(platform: PlatformSettings) -> BoatMotion:
    """A motion that was measured, or came from a seakeeping program."""
    assert platform.file is not None
    record = read_motion(platform.file, platform.heading_deg)

    def motion(times: ArrayLike) -> BoatState:
        return BoatState(*record.pose_at(times))

    return motion


def _course_positions(
    platform: PlatformSettings, time: NDArray[np.float64], heave: NDArray[np.float64]
) -> NDArray[np.float64]:
    """(n, 3) positions on the steady course, `heave` (n,) m above rest."""
    east, north = unit_from_azimuth(platform.heading_deg)
    run = platform.speed_m_s * time
    return np.stack((run * east, run * north, heave), axis=-1)


def _attitudes(
    platform: PlatformSettings, roll: NDArray[np.float64], pitch: NDArray[np.float64], yaw: NDArray[np.float64]
) -> NDArray[np.float64]:
    """(n, 3) attitudes, deg, of angles beside those at rest."""
    return np.stack((platform.list_deg + roll, platform.trim_deg + pitch, platform.heading_deg + yaw), axis=-1)


def _rest_position(platform: PlatformSettings) -> tuple[float, float]:
    """Where the boat's middle rests at time 0, m east north: upright, its antennas are above the origin."""
    if platform.lever_arm_m is None:
        return 0.0, 0.0
    lever = np.array(platform.lever_arm_m) @ boat_axes((0.0, 0.0, platform.heading_deg))
    return -float(lever[0]), -float(lever[1])


_TILT_TIMES = 512
_CHANNELS = 6  # east, north, up, roll, pitch, heading


class Sensors:
    """A motion as it is measured. Perfect sensors give the motion itself, bit by bit.

    The motion is evaluated at most `latency_s` and a reading before the first time, and a reading after the last.
    """

    def __init__(self, settings: SensorSettings, motion: BoatMotion, seed: int) -> None:
        """seed: the scene's."""
        self.settings = settings
        self.motion = motion
        self._key = random_streams.key(seed, Stream.SENSORS)
        s = settings
        self._bias = np.array([0.0, 0.0, s.height_bias_m, s.roll_bias_deg, s.pitch_bias_deg, s.heading_bias_deg])
        self._rms = np.array([s.position_noise_m] * 3 + [s.attitude_noise_deg] * 2 + [s.heading_noise_deg])

    def __call__(self, times: ArrayLike) -> BoatState:
        """The boat at times (n,) s, as measured."""
        if self.settings == SensorSettings():
            return self.motion(times)
        time = np.asarray(times, dtype=np.float64)
        rate = self.settings.rate_hz
        if math.isinf(rate):
            return _state(self._readings(time, np.round(1e6 * time).astype(np.int64)))
        before = np.floor(rate * time).astype(np.int64)
        number, entry = np.unique(np.concatenate((before, before + 1)), return_inverse=True)
        readings = self._readings(number / rate, number)
        first, second = readings[entry[: time.size]], readings[entry[time.size :]]
        return _state(first + (rate * time - before)[:, None] * (second - first))

    def _readings(self, time: NDArray[np.float64], number: NDArray[np.int64]) -> NDArray[np.float64]:
        """Readings (n, 6) with these numbers (n,), taken at these times (n,)."""
        state = self.motion(time - self.settings.latency_s)
        values = np.concatenate((state.position, state.attitude), axis=1) + self._bias
        return values + self._rms * white_noise(self._key, number, _CHANNELS) if self._rms.any() else values


def white_noise(key: np.uint64, number: NDArray[np.int64], channels: int) -> NDArray[np.float64]:
    """Independent normal numbers (n, channels) of variance 1, a function of the key and of each number (n,)."""
    # SplitMix64's state steps by a constant, and its output is the state well mixed; whole numbers wrap at 2^64.
    count = number.astype(np.uint64)[:, None] * np.uint64(channels) + np.arange(1, channels + 1, dtype=np.uint64)
    z = key + count * np.uint64(0x9E3779B97F4A7C15)
    z = (z ^ (z >> np.uint64(30))) * np.uint64(0xBF58476D1CE4E5B9)
    z = (z ^ (z >> np.uint64(27))) * np.uint64(0x94D049BB133111EB)
    z = z ^ (z >> np.uint64(31))
    return scipy.special.ndtri(((z >> np.uint64(12)).astype(np.float64) + 0.5) * 2.0**-52)  # 52 bits: neither 0 nor 1


def _state(values: NDArray[np.float64]) -> BoatState:
    return BoatState(values[:, :3], values[:, 3:])
