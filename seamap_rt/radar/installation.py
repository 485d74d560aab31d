"""A radar on the mast of its boat, resolved: its array, and at any time where each antenna is and where it looks.

The array's origin stands at radar.height_m above the water while the boat lies still, at the end of a lever arm from
the point about which the boat turns; the world's origin lies below it then, at time 0. The turntable turns at a
constant rate against the boat, so that it points to the start of the sector at the start of each turn of a boat that
keeps its heading; a boat that rolls or yaws swings the boresight off that.
"""

from __future__ import annotations

from dataclasses import dataclass, fields, replace
from functools import cached_property

import numpy as np
from numpy.typing import ArrayLike, NDArray

from ..conventions import unit_from_azimuth, wrap_degrees
from ..errors import InputError
from ..settings import PlatformSettings, RadarSettings
from .array import Array, antenna_array
from .platform import BoatMotion, boat_motion
from .pose import antenna_axes, bearing, boat_axes
from .waveform import RangeResponse

_STEP = 1e-3  # s, over which positions are differenced: a jerk of 100 m/s³ errs by 0.02 mm/s
_NEWTON_STEPS = 5  # two for a boat in waves; as many as _SLOWEST asks for
_SLOWEST = 0.2  # of the turntable's rate: so fast at least the boresight must turn
_FURTHEST_DEG = 150.0  # off its schedule: at 180 it would not be known in which direction it has turned
_ROUNDING = 1e-9  # deg; a boresight that is so little off its schedule is on it

_AT_REST = PlatformSettings()


@dataclass(frozen=True)
class ArrayPose:
    """Where the antennas are and how they stand at some moments; world axes east, north, up, metres."""

    time: NDArray[np.float64]  # (n,) s
    origin: NDArray[np.float64]  # (n, 3) of the array
    attitude: NDArray[np.float64]  # (n, 3) deg, the boat's roll, pitch, yaw
    axes: NDArray[np.float64]  # (n, 3, 3) rows: across, boresight, up the array
    offsets: NDArray[np.float64]  # (n, antenna, 3) m, of the phase centres, from the origin

    def __getitem__(self, index: slice | NDArray) -> ArrayPose:
        return ArrayPose(*(getattr(self, each.name)[index] for each in fields(self)))

    @property
    def positions(self) -> NDArray[np.float64]:
        """(n, antenna, 3) phase centres in the world."""
        return self.origin[:, None] + self.offsets

    @cached_property
    def bearing(self) -> NDArray[np.float64]:
        """(n,) azimuth of the boresight [deg, 0 … 360)."""
        return bearing(self.axes)


@dataclass(frozen=True, eq=False)
class Installation:
    """A radar on its boat: what rooms that simulate are handed. For any time, also a little before 0.

    Raises ValueError for a boat that follows waves, and no motion: it needs its sea.
    """

    radar: RadarSettings  # as it looks, with the sector that its beam truly scans
    platform: PlatformSettings = _AT_REST
    motion: BoatMotion = None  # type: ignore[assignment]  # of the boat; left out, that of `platform`
    sensors: BoatMotion | None = None  # the motion as it is measured, where it is
    true: Installation | None = None  # where all is, if this is what sensors make of it

    def __post_init__(self) -> None:
        if self.motion is None:
            object.__setattr__(self, "motion", boat_motion(self.platform))

    @property
    def sensed(self) -> Installation:
        """The same as the boat's sensors have it: antennas stand where they are thought to, and the turntable's zero
        stays where it is. Where nothing is measured, itself."""
        return self if self.sensors is None else replace(self, motion=self.sensors, sensors=None, true=self)

    @cached_property
    def array(self) -> Array:
        """Its antennas and their mode."""
        return antenna_array(self.radar) if self.true is None else self.true.array

    @cached_property
    def response(self) -> RangeResponse:
        """The response of its waveform in range."""
        return RangeResponse.of(self.radar)

    @cached_property
    def offsets(self) -> NDArray[np.float64]:
        """(antenna, 3) m, of the phase centres from the array's origin."""
        return self.array.offsets if self.true is None else self.array.known_offsets

    @cached_property
    def heading(self) -> float:
        """deg, against which the turntable is set: a sector lies where the scene says while the boat keeps to it."""
        if self.true is not None:
            return self.true.heading
        if self.platform.motion == "file":
            return float(self.motion(np.zeros(1)).attitude[0, 2])
        return self.platform.heading_deg

    @cached_property
    def _lever(self) -> NDArray[np.float64]:
        lever = self.platform.lever_arm_m
        return np.array((0.0, 0.0, self.radar.height_m) if lever is None else lever)

    @cached_property
    def _foot(self) -> NDArray[np.float64]:
        upright = self._lever @ boat_axes((0.0, 0.0, self.heading))
        return np.array((upright[0], upright[1], upright[2] - self.radar.height_m))

    @property
    def period(self) -> float:
        """Seconds of a turn."""
        return turn_duration(self.radar)

    @property
    def rate(self) -> float:
        """deg/s of the turntable; 0 for a staring antenna."""
        return 0.0 if self.radar.scan == "staring" else 360.0 / self.period

    def schedule(self, time: ArrayLike) -> NDArray[np.float64]:
        """Where the boresight would point [deg, unwrapped] if the boat kept level and on its heading."""
        start, stop = self.radar.sector_deg
        if self.radar.scan == "staring":
            return np.full(np.shape(time), 0.5 * (start + stop))
        return start + 360.0 / self.period * np.asarray(time, dtype=np.float64)

    def pose(self, time: ArrayLike, sweep: ArrayLike | None = None) -> ArrayPose:
        """How the array stands at times (n,). sweep: of the schedule [deg from the sector's start], else the time's."""
        time = np.asarray(time, dtype=np.float64)
        boat = self.motion(time)
        toward = self.schedule(time) if sweep is None else self.radar.sector_deg[0] + np.asarray(sweep)
        steady = time.size > 0 and not np.ptp(boat.attitude, axis=0).any()
        attitude = boat.attitude[:1] if steady else boat.attitude
        axes = antenna_axes(attitude, toward - self.heading, self.radar.tilt_deg)
        origin = boat.position + self._lever @ boat_axes(attitude) - self._foot
        return ArrayPose(time, origin, boat.attitude, axes, self.offsets @ axes)

    def velocity(self, time: ArrayLike) -> NDArray[np.float64]:
        """(n, antenna, 3) m/s of the phase centres, the turntable's turning included."""
        time = np.asarray(time, dtype=np.float64)
        after, before = (self.pose(time + side * _STEP).positions for side in (0.5, -0.5))
        return (after - before) / _STEP

    def swing(self, time: ArrayLike) -> NDArray[np.float64]:
        """(n,) deg by which the boresight points clockwise of its schedule."""
        if not np.any(self.motion(time).attitude - (0.0, 0.0, self.heading)):  # upright and on her heading
            return np.zeros(np.shape(time))
        off = wrap_degrees(self.pose(time).bearing - self.schedule(time))
        return np.where(np.abs(off) < _ROUNDING, 0.0, off)

    def passing(self, sweep: NDArray[np.float64], nominal: NDArray[np.float64]) -> NDArray[np.float64]:
        """Times (n,) at which the boresight passes `sweep` (n,) [deg from the start of the sector, unwrapped].

        nominal (n,) s: when the schedule has it do so.
        """
        if self.rate == 0.0:
            return nominal
        time = nominal
        for _ in range(_NEWTON_STEPS):  # so many for every azimuth: the same bits whatever else is asked for
            ahead, behind = (self.swing(time + side * _STEP) for side in (0.5, -0.5))
            rate = self.rate + wrap_degrees(ahead - behind) / _STEP
            off = self.rate * (time - nominal) + self.swing(time)
            time = time - off / np.maximum(rate, _SLOWEST * self.rate)
        return time

    def check_that_it_sweeps(self, time: NDArray[np.float64]) -> None:
        """Raise InputError where, at times (n,), the boresight does not pass each azimuth once in about a turn: where
        the boat swings it back about as fast as the turntable turns it on, or has turned round."""
        if self.rate == 0.0:
            return
        furthest = float(np.abs(self.swing(time)).max(initial=0.0))
        if furthest > _FURTHEST_DEG:
            raise InputError(
                f"platform: the boat turns {furthest:.4g}° off the heading that it has at time 0, by which the "
                f"turntable is set: must be at most {_FURTHEST_DEG:g}°; keep its course, or take fewer turns"
            )
        change = wrap_degrees(self.swing(time + 0.5 * _STEP) - self.swing(time - 0.5 * _STEP))
        back = -float(change.min(initial=0.0)) / _STEP
        if back > (1.0 - _SLOWEST) * self.rate:
            raise InputError(
                f"platform: the boat swings the boresight back at {back:.3g}°/s, where the turntable turns it on at "
                f"{self.rate:.3g}°/s: must be at most {1.0 - _SLOWEST:.0%} of that; raise radar.rotation_rpm or calm "
                "the boat"
            )

    def lean_deg(self, time: NDArray[np.float64], depression: float) -> float:
        """The largest angle [deg] by which the fan of the beam stands off its own bearing at a depression [rad]."""
        axes = self.pose(time).axes
        upright = np.hypot(axes[:, 0, 0], axes[:, 0, 1])
        sine = np.tan(depression) * np.abs(axes[:, 0, 2]) / np.maximum(upright, 1e-9)
        return float(np.degrees(np.arcsin(np.minimum(sine, 1.0))).max(initial=0.0))


def turn_duration(radar: RadarSettings) -> float:
    """Seconds of one turn of the antenna, or of one map of a staring one."""
    return radar.stare_s if radar.scan == "staring" else 60.0 / radar.rotation_rpm


def column_frame(azimuth_deg: NDArray[np.float64]) -> NDArray[np.float64]:
    """(n, 3, 3) rows: along the azimuth, across it clockwise, up."""
    east, north = unit_from_azimuth(azimuth_deg)
    zero, one = np.zeros_like(east), np.ones_like(east)
    rows = ((east, north, zero), (north, -east, zero), (zero, zero, one))
    return np.stack([np.stack(row, axis=-1) for row in rows], axis=-2)
