"""What a phase means: the phase of mean sea level in each gate, and the height of any other.

Where the echo grows or fades along the range, a gate's power does not come from its middle.

Below the beam the elevation pattern rises steeply: a gate at 15 m receives its far side best, and takes its phase for
that of its middle. To first order the power's centre lies d ln P/dR · σ² beyond, σ² the variance of the pulse's power,
and the height found is that of mean sea level so far beyond, H/R times the distance. A single reflector has no such
error, so that it is taken off only where the sea is known to be one (optimal interpolation), and else is counted as
doubt.
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property

import numpy as np
from numpy.typing import NDArray

from ...conventions import wrap_phase
from ..covariance.windows import Covariance, Level
from ..input.description import RadarDescription
from .inversion import Points, difference_at_height, located, phase_scale
from .poses import LookPoses

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
        self.flat = self.of_height(0.0)
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

    def of_height(self, height: Map | float) -> Map:
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
        return self._heights(cells, self.of_height(height))

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
