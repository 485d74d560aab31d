"""How the array stood during each cell's dwell, from the boat's own sensors.

What a phase means: the phase of mean sea level in each gate, and the height of any other.

Where the echo grows or fades along the range, a gate's power does not come from its middle.

Below the beam the elevation pattern rises steeply: a gate at 15 m receives its far side best, and takes its phase for
that of its middle. To first order the power's centre lies d ln P/dR · σ² beyond, σ² the variance of the pulse's power,
and the height found is that of mean sea level so far beyond, H/R times the distance. A single reflector has no such
error, so that it is taken off only where the sea is known to be one (optimal interpolation), and else is counted as
doubt.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, fields
from functools import cached_property
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

from ..conventions import unit_from_azimuth, wrap_phase
from ..radar.pose import antenna_axes, scan_of_bearing
from .description import RadarDescription
from .dwells import Dwells, allot, unwrapped_sweep
from .inversion import Antenna, Fan, Points, azimuth_at_sea, difference_at_height, located, phase_scale
from .windows import Covariance, Level

if TYPE_CHECKING:
    import xarray as xr


_UPRIGHT = 0.1  # of the turn between two pulses: a fan that leans by less changes no dwell to speak of
_STILL = 0.01  # m; antennas that stray less from above the origin are at rest


@dataclass(frozen=True)
class PulsePoses:
    """One pose for each pulse (pulse,): axes by parts right of the bearing, out along it and up, points in metres."""

    time: NDArray[np.float64]  # s
    sweep: NDArray[np.float64]  # deg, bearing of the boresight from the sector's start, not wrapped
    boresight: NDArray[np.float64]  # (pulse, 3) right, out, up; right is 0
    upright: NDArray[np.float64]  # (pulse, 3) right, out, up, of the array's own upright axis
    axes: NDArray[np.float64]  # (pulse, 3 across boresight up, 3 east north up)
    antennas: NDArray[np.float64]  # (pulse, antenna, 3) east, north, up

    @classmethod
    def of(cls, echoes: xr.Dataset, radar: RadarDescription) -> PulsePoses:
        """From the echoes' time [s], azimuth [deg], attitude [deg] and position [m] of each pulse."""
        time, azimuth, attitude, positions = (
            np.asarray(echoes[name].values, dtype=np.float64) for name in ("time", "azimuth", "attitude", "position")
        )
        # A boat that stands still has one attitude for all.
        own = attitude[:1] if not np.ptp(attitude, axis=0).any() else attitude
        axes = antenna_axes(own, scan_of_bearing(own, azimuth, radar.tilt), radar.tilt)
        sweep = unwrapped_sweep(azimuth, time, radar.sector, np.inf if radar.staring else radar.period)
        return cls(
            time, sweep, _rotate_to_look(axes[:, 1], azimuth), _rotate_to_look(axes[:, 2], azimuth), axes, positions
        )

    def __getitem__(self, rows: NDArray[np.intp]) -> PulsePoses:
        """Those of some pulses, in any order and number."""
        return PulsePoses(*(getattr(self, each.name)[rows] for each in fields(self)))

    def dwells(self, radar: RadarDescription, lower: int, centres: NDArray[np.float64], width: float) -> Dwells:
        """Pulses to looks, `width` deg wide and centred on `centres` (look,) deg from the sector's start."""
        height = self.antennas[:, lower, 2]

        def azimuth_offset(ranges: NDArray[np.float64]) -> NDArray[np.float64]:
            rise, out = ((self.boresight[:, n, None], self.upright[:, n, None]) for n in (2, 1))
            return np.degrees(azimuth_at_sea(ranges, height[:, None], rise, out, self.upright[:, 0, None]))

        # From the nearest gate on the sea to the farthest the fan swings one way only: if both are upright all are.
        step = np.median(np.abs(np.diff(self.sweep))) if self.sweep.size > 1 else 0.0
        below = np.nanmax(height / np.hypot(self.boresight[:, 2], self.upright[:, 2]), initial=0.0)
        nearest = min(np.searchsorted(radar.ranges, below * (1.0 + 1e-9)), radar.ranges.size - 1)
        ends = np.abs(azimuth_offset(radar.ranges[[nearest, -1]]))
        leaning = np.nanmax(ends, initial=0.0) > _UPRIGHT * step
        return allot(self.sweep, azimuth_offset(radar.ranges) if leaning else None, centres, width, radar.closed)

    def looks(self, centres: NDArray[np.float64], width: float) -> NDArray[np.intp]:
        """The look (pulse,) of the boresight's own bearing, or −1."""
        number = np.floor((self.sweep - centres[0]) / width + 0.5 + 1e-9).astype(np.intp)
        return np.where((number >= 0) & (number < centres.size), number, -1)


@dataclass(frozen=True)
class LookPoses:
    """Means over each cell's pulses, (look, 1), or (look, gate) where the fan leans; of a boat at rest the fan is one
    for all looks, (1, 1)."""

    fan: Fan
    azimuth: NDArray[np.float64]  # deg, of the boresight
    lower: tuple[NDArray[np.float64], NDArray[np.float64]]  # m east, north, of the lower receiver
    middle: tuple[NDArray[np.float64], NDArray[np.float64]]  # m east, north, of both receivers
    time: NDArray[np.float64]  # s
    at_rest: bool  # upright above the origin all along: each look's cells lie on a straight line from the origin

    @property
    def centre(self) -> tuple[float, float]:
        """m east and north: the mean place of the receivers over the turn; 0 where none is known."""
        known = [each[np.isfinite(each)] for each in self.middle]
        east, north = (float(each.mean()) if each.size else 0.0 for each in known)
        return east, north

    @classmethod
    def of(
        cls,
        poses: PulsePoses,
        dwells: Dwells,
        pair: tuple[int, int],
        senders: Sequence[int],
        start: float,
    ) -> LookPoses:
        """poses and dwells: of the same pulses; pair: lower and upper receiver's antennas; start: of the sector [deg].

        senders: antennas that transmit.
        """
        lower, upper = (poses.antennas[:, antenna] for antenna in pair)
        middle = 0.5 * (lower + upper)
        others = [antenna for antenna in senders if antenna not in pair]
        arms = [poses.antennas[:, antenna] - lower for antenna in (pair[1], *others)]
        columns = [
            poses.sweep,
            poses.time,
            *lower.T,
            *middle.T[:2],
            *poses.boresight.T[1:],
            *poses.upright.T,
        ]
        # The fan's plane stands in the middle between the receivers. An arm that leads across it is as one in the plane
        # whose square is less by twice their product: û·b = b_x x₀/R₁ + what lies in the plane, with û·x̂ = x₀/R₁.
        middle_across = 0.5 * np.einsum("pi,pi->p", arms[0], poses.axes[:, 0])
        for arm in arms:
            across, along, up = np.einsum("pi,pai->ap", arm, poses.axes)
            square = np.einsum("pi,pi->p", arm, arm) - 2.0 * across * middle_across
            columns += [along, up, np.sqrt(np.maximum(square, 0.0))]
        mean = list(dwells.means(np.stack(columns, axis=1)))
        sweep, when, x, y, z, middle_x, middle_y, out, rise, right_up, out_up, rise_up = mean[:12]
        # The mean of axes that swing is a little short.
        length, length_up = np.hypot(out, rise), np.sqrt(right_up**2 + out_up**2 + rise_up**2)
        antennas = [Antenna(*mean[12 + 3 * n : 15 + 3 * n]) for n in range(len(arms))]
        weight = 0.5 / len(senders)
        fan = Fan(
            height=z,
            upper=antennas[0],
            rise=(rise / length, rise_up / length_up),
            out=(out / length, out_up / length_up),
            right=right_up / length_up,
            share=0.25 + weight * (pair[1] in senders),
            others=tuple((weight, antenna) for antenna in antennas[1:]),
        )
        at_rest = not dwells.leaning and not np.nanmax(np.hypot(middle_x, middle_y), initial=0.0) > _STILL
        if at_rest:
            fan = fan.common()
        return cls(fan, start + sweep, (x, y), (middle_x, middle_y), when, at_rest)

    def world(self, points: Points) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
        """East and north [m] of points (look, gate)."""
        east, north = unit_from_azimuth(self.azimuth)
        return (
            self.lower[0] + points.out * east + points.right * north,
            self.lower[1] + points.out * north - points.right * east,
        )

    def ground_range(self, points: Points) -> NDArray[np.float64]:
        """Distance [m] of points (look, gate) from the middle of the two receivers as it stood at their dwell."""
        x, y = self.world(points)
        return np.hypot(x - self.middle[0], y - self.middle[1])


def _rotate_to_look(axis: NDArray[np.float64], azimuth: NDArray[np.float64]) -> NDArray[np.float64]:
    """World vectors (pulse, 3) as parts right of the bearing, out along it, and up."""
    east, north = unit_from_azimuth(azimuth)
    return np.stack(
        (axis[:, 0] * north - axis[:, 1] * east, axis[:, 0] * east + axis[:, 1] * north, axis[:, 2]), axis=1
    )


Map = NDArray[np.float64]


@dataclass(frozen=True)
class Heights:
    """Heights that the phases of averaged cells mean; arrays (look, gate)."""

    cells: Covariance  # the averaged covariance that the phase was taken from
    phase: Map  # rad, its ambiguity resolved as far as is known
    points: Points  # m, height above mean sea level, outward and clockwise of the lower antenna
    ground_range: Map  # m, from the middle of the receivers
    gain: Map  # |dz/dφ| [m/rad]

    @property
    def height(self) -> Map:
        """(look, gate) m above mean sea level."""
        return self.points.height


class PhaseModel:
    """What a phase of p ways means in each gate, from where the antennas stood in each look."""

    def __init__(self, radar: RadarDescription, poses: LookPoses, paths: int) -> None:
        self.radar, self.poses, self.paths = radar, poses, paths
        self._wavenumber = 2.0 * np.pi * paths / radar.wavelength
        self.flat = self.phase_at_height(0.0)
        self._levels: dict[int, Map] = {}  # antennas of a boat that rolls or heaves are not where they were a look ago
        # With the second receiver below the first a rise turns the phase on, not back.
        self.rise_sign = -np.sign(poses.fan.upper.up)

    @cached_property
    def flat_per_gate(self) -> Map:
        """By how much [rad] the phase of mean sea level turns from a gate to the next."""
        spacing = self.radar.spacing
        return 0.5 * (self._flat_phase(spacing) - self._flat_phase(-spacing))

    @property
    def turn_within_pulse(self) -> Map:
        """By how much [rad] the phase of mean sea level turns within the pulse's own spread, of each gate."""
        return np.abs(np.nan_to_num(self.flat_per_gate)) / self.radar.spacing * self.radar.response.spread_m

    def phase_at_height(self, height: Map | float) -> Map:
        """Phase [rad] of points at that height [m] in each gate, by the fan's geometry."""
        return self._wavenumber * difference_at_height(self.radar.ranges, height, self.poses.fan)

    def _flat_phase(self, offset: float) -> Map:
        """Phase of mean sea level `offset` beyond each gate."""
        return self._wavenumber * difference_at_height(self.radar.ranges + offset, 0.0, self.poses.fan)

    @property
    def level(self) -> Level | None:
        """The phase of mean sea level so many gates on; None of a boat at rest."""
        return None if self.poses.at_rest else self._level

    def _level(self, gates: int) -> Map:
        if gates not in self._levels:
            self._levels[gates] = np.nan_to_num(self._flat_phase(gates * self.radar.spacing))
        return self._levels[gates]

    def residual(self, cells: Covariance) -> Map:
        """Wrapped phase [rad] of cells less that of mean sea level."""
        return wrap_phase(np.angle(cells.cross) - self.flat)

    def heights_of(self, cells: Covariance, residual: Map) -> Heights:
        """Heights of cells whose phase is `residual` [rad], (look, gate), beyond that of mean sea level."""
        return self._heights(cells, self.flat + residual)

    def heights_at(self, cells: Covariance, height: Map) -> Heights:
        """The same for heights [m], (look, gate), that are given."""
        return self._heights(cells, self.phase_at_height(height))

    def _heights(self, cells: Covariance, phase: Map) -> Heights:
        radar, fan = self.radar, self.poses.fan
        difference = phase / self._wavenumber
        points, growth = located(radar.ranges, difference, fan)
        gain = phase_scale(radar.ranges, radar.wavelength, self.paths) * growth
        return Heights(cells, phase, points, self.poses.ground_range(points), gain)

    def ground(self, points: Points) -> tuple[Map, Map]:
        """East and north [m] of points (look, gate)."""
        return self.poses.world(points)

    def outward(self, x: Map, y: Map) -> tuple[Map, Map]:
        """East and north of the direction from the antennas, as they stood, to points at x, y [m]."""
        east, north = x - self.poses.middle[0], y - self.poses.middle[1]
        with np.errstate(invalid="ignore", divide="ignore"):
            distance = np.hypot(east, north)
            return east / distance, north / distance


_STEEPEST = 1.0  # 1/m, of ln P: beyond that the first order does not hold


def edge_bias(power: NDArray[np.float64], height: NDArray[np.float64], radar: RadarDescription) -> NDArray[np.float64]:
    """Height [m] (look or 1, gate) by which a distributed sea is found too high, to first order.

    power (look, gate): of the echo, without noise [W]; height: of the antenna above mean sea level [m].
    """
    known = np.isfinite(power)
    counted = np.where(known, np.maximum(power, 0.0), 0.0).sum(axis=0) / np.maximum(known.sum(axis=0), 1)
    if radar.ranges.size < 3:
        return np.zeros((1, radar.ranges.size))
    with np.errstate(divide="ignore", invalid="ignore"):
        growth = np.nan_to_num(np.gradient(np.log(counted), radar.ranges), posinf=0.0, neginf=0.0)
    smooth = np.convolve(np.pad(growth, 1, mode="edge"), np.full(3, 1.0 / 3.0), "valid")
    return height / radar.ranges * radar.response.spread_m**2 * np.clip(smooth, -_STEEPEST, _STEEPEST)
