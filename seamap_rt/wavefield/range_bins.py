"""A polar map by distance: what share of each range bin is in sight, how high its waves are, and the error of that."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
import xarray as xr
from numpy.typing import NDArray

from ..conventions import unit_from_azimuth, wrap_degrees
from ..dataset import QUALITY_FLAGS
from .wave_spectrum import Cells, Field

BIN_M = 15.0  # width of the range bins that are judged as one
STEEPEST = 5.5  # mast heights: nearer by, points above one another share a gate, and errors are larger than said
_SEEN = 0.5  # share of a range bin in sight: of less, the mean square of what is seen falls short of the sea's
_GLIMPSED = 0.35  # the same for the waves' lengths and directions, which hardly depend on which half is seen
_BREADTH_M = 250.0  # of the belt whose waves are sorted: enough of them, and no longer to do
_NOISE = 0.3  # of the waves' variance: more noise in a range bin would have to be known better than it is
_BARRED = ~QUALITY_FLAGS["partly_shadowed"]  # flags of cells left out; without half hidden ones steep sides would lack


@dataclass(frozen=True)
class PolarMap:
    """A polar map of one turn; arrays (look, gate) but for azimuth and time (look,) and ranges (gate,)."""

    height: Field  # m
    noise: Field  # m², error variance of the height
    distance: Field  # m
    seen: Field  # share of the cell in sight
    known: NDArray[np.bool_]
    azimuth: Field  # deg
    time: Field  # s
    place: Field  # m, (look, 2): of the antennas, east and north
    ranges: Field  # m
    width: float  # rad, of a look
    conditional: bool  # heights are conditional means: they fall short of the sea by their errors' variance
    sensed: Field  # m², the errors' part that the motion sensors add to the heights
    excess: Field  # m², error variance beyond the analysis error: heights vary by all of it

    @classmethod
    def of(cls, polar: xr.Dataset) -> PolarMap:
        """Of the polar map of one turn, arrays (look, gate)."""

        def field(name: str) -> Field:
            return polar[name].values.astype(np.float64)

        height, distance = field("height"), field("ground_range")
        noise = field("height_std") ** 2
        sensed = field("sensor_std") ** 2 if "sensor_std" in polar else np.zeros(noise.shape)
        excess = np.maximum(noise - field("analysis_std") ** 2, 0.0) if "analysis_std" in polar else sensed
        known = np.isfinite(height) & np.isfinite(noise) & np.isfinite(distance)
        known &= (polar["quality"].values & _BARRED) == 0
        seen = known * 1.0
        if "visible_share" in polar:
            seen = np.where(known, np.nan_to_num(field("visible_share"), nan=1.0), 0.0)
        azimuth = field("azimuth")
        width = np.radians(abs(wrap_degrees(azimuth[1] - azimuth[0])) if azimuth.size > 1 else 360.0)
        conditional = polar.attrs.get("estimator") == "adaptive"
        time, ranges = field("time"), field("range")
        place = np.zeros((azimuth.size, 2))
        if "antenna_x" in polar:
            place = np.nan_to_num(np.stack((field("antenna_x"), field("antenna_y")), axis=1))
        fields = height, noise, distance, seen, known, azimuth, time, place, ranges, float(width)
        return cls(*fields, conditional, sensed, excess)

    @property
    def step(self) -> float:
        """m, between gates; 1 where there is one gate."""
        return float(self.ranges[1] - self.ranges[0]) if self.ranges.size > 1 else 1.0

    @property
    def span(self) -> float:
        """deg, that the looks cover."""
        return float(np.degrees(self.azimuth.size * self.width))

    def cells(self, chosen: NDArray[np.bool_]) -> Cells:
        """The chosen ones (look, gate) of the known cells."""
        look = np.nonzero(chosen)[0]
        out = self.distance[chosen]
        east, north = unit_from_azimuth(self.azimuth[look])
        area = out * self.step * self.width
        return Cells(out * east, out * north, self.time[look], look, self.height[chosen], area)


@dataclass(frozen=True)
class RangeBins:
    """Heights by distance; arrays (bin,)."""

    middle: Field  # m
    waves: Field  # m², mean square of heights, freed of errors
    noise: Field  # m², of their errors
    sensed: Field  # m², of those by the motion sensors
    seen: Field  # share in sight
    area: Field  # m²
    used: NDArray[np.bool_]  # for the waves' height
    glimpsed: NDArray[np.bool_]  # for their lengths and directions

    @classmethod
    def of(cls, polar_map: PolarMap) -> RangeBins | None:
        """Of the polar map of one turn, arrays (bin,); None without any cell."""
        if not polar_map.known.any():
            return None
        fields = (polar_map.distance, polar_map.height, polar_map.noise, polar_map.sensed, polar_map.excess)
        out, height, noise, sensed, excess = (field[polar_map.known] for field in fields)
        gate = np.nonzero(polar_map.known)[1]
        mast = float(np.median(np.sqrt(np.maximum(polar_map.ranges[gate] ** 2 - out**2, 0.0)) + height))
        number = (out / BIN_M).astype(np.intp)
        count = int(max(polar_map.ranges[-1], out.max()) / BIN_M) + 1
        middle = (np.arange(count, dtype=np.float64) + 0.5) * BIN_M
        held = np.maximum(np.bincount(number, out, count), 1e-300)
        gates = np.histogram(polar_map.ranges, np.arange(count + 1) * BIN_M)[0]
        area = polar_map.azimuth.size * polar_map.width * gates * polar_map.step * middle
        # A conditional mean falls short of the sea by its analysis error: E[h²] = σ² − analysis + excess.
        doubled = 2.0 * excess if polar_map.conditional else 0.0  # once in h², once in the noise that is added below
        fields = (height**2 - doubled, noise, sensed)
        square, errors, common = (np.bincount(number, out * each, count) / held for each in fields)
        in_sight = np.bincount(number, out * polar_map.seen[polar_map.known], count) * polar_map.step * polar_map.width
        seen = np.minimum(in_sight / np.maximum(area, 1e-300), 1.0)
        waves = square + errors if polar_map.conditional else square - errors
        far_enough = middle - 0.5 * BIN_M >= STEEPEST * mast
        lit = far_enough & (seen >= _SEEN)
        best = lit & (errors <= np.median(errors[lit]) if lit.any() else False)
        typical = max(float(np.average(waves[best], weights=area[best])), 0.0) if best.any() else 0.0
        least = errors[lit].min() if lit.any() else 0.0
        # Of a calm sea nothing but noise is seen: that of the best range bins.
        clear = errors <= max(_NOISE * typical, 2.0 * least)
        glimpsed = far_enough & clear & (seen >= _GLIMPSED)
        glimpsed &= middle < middle[glimpsed].min(initial=np.inf) + _BREADTH_M
        return cls(middle, waves, errors, common, seen, area, lit & clear, glimpsed)

    def weight(self, chosen: NDArray[np.bool_]) -> Field:
        """(bin,) share of the area of those chosen; the sum is 1."""
        return np.where(chosen, self.area, 0.0) / self.area[chosen].sum()

    def edges(self, chosen: NDArray[np.bool_]) -> tuple[float, float]:
        """Where the first of those chosen begins and the last one ends [m]."""
        middles = self.middle[chosen]
        return float(middles.min()) - 0.5 * BIN_M, float(middles.max()) + 0.5 * BIN_M

    def covers(self, chosen: NDArray[np.bool_], distance: Field) -> NDArray[np.bool_]:
        """Which distances [m] lie between those edges."""
        first, last = self.edges(chosen)
        return (distance > first) & (distance < last)
