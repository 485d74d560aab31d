"""The boat's motion as its sensors measure it: biased, noisy, infrequent, and late.

Reading k is taken at the time k/rate, of the motion `latency_s` before, and the retrieval interpolates linearly between
readings. The noise of a reading depends on the seed and on k alone: any times in any order give the same readings.
Where every time has a reading of its own (rate_hz = inf), k is the time in whole microseconds.

Noise comes from SplitMix64 (Steele, Lea & Flood 2014), whose nth number is a function of n: a reading's own numbers are
found without drawing those of all before it.
"""

from __future__ import annotations

import math

import numpy as np
import scipy
from numpy.typing import ArrayLike, NDArray

from .. import random_streams
from ..random_streams import Stream
from ..settings import SensorSettings
from .platform import BoatMotion, BoatState

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
