"""The true heights, slopes and visible fractions of the maps' cells: means of the simulated sea over each cell.

Facets are summed into fine bins of slant range, column by column; a cell is a sum of bins and columns, each weighted
by its overlap with the cell.
"""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import xarray as xr
from numpy.typing import NDArray

from .conventions import db, wrap_degrees
from .dataset import build
from .echoes.radar_cross_section import two_way_power
from .mesh import Facets
from .radar.array import antenna_array
from .radar.dwell import dwell_power
from .radar.grid import ground_grid, look_sweeps
from .radar.mast import Mast
from .radar.scan import sector_width
from .radar.waveform import RangeResponse, gates
from .sea import Sea
from .settings import RadarSettings, RetrievalSettings
from .tracing import Illumination

FAINTEST = 1e-15  # NRCS below which a cell is dark: smaller values are rounding errors
_BINS_PER_GATE = 6
_POINTS_A_CELL = 6  # along the look, at least
_GAUSS = 0.5 / np.sqrt(3.0)  # of a cell's side: two-point Gauss quadrature, exact for cubics


def polar_truth(
    facets: Illumination, rcs: NDArray[np.float32], radar: RadarSettings, retrieval: RetrievalSettings, turn: int
) -> xr.Dataset:
    """The schema's `truth/polar` (turn, azimuth, range) of one turn, from the traced facets.

    rcs: (column, facet) radar cross-sections [m²], 0 where no ray arrives. NaN in cells without facets.
    """
    ranges = gates(radar)
    facets = replace(facets, height=_mean_heights(facets))
    if float(np.diff(facets.grid.ground_range).max()) > retrieval.cell_range_m / _POINTS_A_CELL:
        facets, rcs = _halved(facets, rcs)
    staring = radar.scan == "staring"
    sweeps = look_sweeps(radar.sector_deg, retrieval.cell_azimuth_deg, staring)
    lit = facets.lit_both
    area = np.broadcast_to(facets.horizontal_area, facets.height.shape)
    slant = np.hypot(facets.distance, facets.rise)
    reach = max(RangeResponse.of(radar).support_m, 0.5 * retrieval.cell_range_m)
    # Bins narrower than half the facets' spacing would be empty in places.
    width = max(radar.range_sampling_m / _BINS_PER_GATE, 0.5 * float(np.diff(facets.grid.ground_range).max()))
    bins = _Bins(ranges, width, reach, slant)

    box = bins.box(ranges, retrieval.cell_range_m)
    looks = _look_columns(facets, sweeps, retrieval.cell_azimuth_deg)

    def cells(values: NDArray) -> NDArray[np.float64]:
        return looks @ (bins.gather(values) @ box)

    whole = cells(area)
    seen = cells(area * lit)
    arriving = two_way_power(facets)
    echo = cells(rcs * arriving)
    with np.errstate(invalid="ignore", divide="ignore"):
        values = {
            "height": cells(area * facets.height) / whole,
            "height_visible": cells(area * lit * facets.height) / seen,
            "visible_fraction": seen / whole,
            "slope_range": cells(area * facets.slope_look) / whole,
            "slope_azimuth": cells(area * facets.slope_cross) / whole,
            "nrcs_db": db(np.where(echo > FAINTEST * whole, echo, 0.0) / whole),
        }
        if facets.field is not None:
            values["illumination"] = cells(area * arriving) / whole
        gate = bins.response(ranges, RangeResponse.of(radar))
        offset = sweeps[:, None] - facets.grid.column_sweep
        beam = dwell_power(antenna_array(radar), offset, 0.0 if staring else retrieval.cell_azimuth_deg)
        weight = beam @ (bins.gather(area) @ gate)
        values["height_weighted"] = (beam @ (bins.gather(area * facets.height) @ gate)) / weight
    empty = whole <= 0.0
    fields = {name: np.where(empty | ~np.isfinite(field), np.nan, field)[None] for name, field in values.items()}
    times = np.interp(sweeps, facets.grid.sweep, facets.grid.time)
    fields["time"] = times[None]
    azimuth = (radar.sector_deg[0] + sweeps) % 360.0
    return build("truth/polar", fields, {"turn": [turn], "azimuth": azimuth, "range": ranges})


def _mean_heights(facets: Illumination) -> NDArray[np.float64]:
    """Mean heights (column, facet) [m] of the water over each facet, which is flat where the water is curved.

    Over a triangle with edges e the mean of a surface with the second derivatives H lies Σ eᵀHe/24 below the plane
    through its corners. H is the difference of the slopes of facets of one kind (near or far), from rung to
    rung and from column to column.
    """
    step = np.repeat(np.diff(facets.grid.ground_range), 2)
    width = facets.distance * np.radians(facets.grid.spacing_deg)
    height = facets.height.copy()
    for kind in (slice(0, None, 2), slice(1, None, 2)):  # near facets, far facets
        look, cross = facets.slope_look[:, kind], facets.slope_cross[:, kind]
        bend = step[kind] * (_differences(look, 1) + _differences(look, 0)) + width[kind] * _differences(cross, 0)
        height[:, kind] -= bend / 12.0
    return height


def _differences(values: NDArray[np.float32], axis: int) -> NDArray[np.float32]:
    """Centred differences of neighbours along an axis; 0 where there is one value only."""
    return np.gradient(values, axis=axis) if values.shape[axis] > 1 else np.zeros_like(values)


def _halved(facets: Illumination, rcs: NDArray[np.float32]) -> tuple[Illumination, NDArray[np.float32]]:
    """Each facet as two of half its area, one behind the other along the look, so that a cell's edge can divide it.

    Their distance gives the pair the second moment of the triangle, 1/18 of its length squared.
    """
    apart = np.sqrt(1.0 / 18.0) * np.repeat(np.diff(facets.grid.ground_range), 2)
    step = np.stack((-apart, apart), axis=-1)  # (facet, half)

    def twice(values: NDArray) -> NDArray:
        return np.repeat(values, 2, axis=-1)

    halves = replace(
        facets,
        distance=(facets.distance[:, None] + step).ravel(),
        horizontal_area=0.5 * twice(facets.horizontal_area),
        angle=twice(facets.angle),
        height=(facets.height[..., None] + facets.slope_look[..., None] * step).reshape(len(facets.height), -1),
        slope_look=twice(facets.slope_look),
        slope_cross=twice(facets.slope_cross),
        lit=twice(facets.lit),
        field=None if facets.field is None else twice(facets.field),
    )
    return halves, np.float32(0.5) * twice(rcs)


def ground_truth(
    sea: Sea, radar: RadarSettings, retrieval: RetrievalSettings, turn: int, mast: Mast | None = None
) -> xr.Dataset:
    """The schema's `truth/ground` (turn, y, x) of one turn: means of square cells, NaN where the beam does not pass.

    Each cell is taken at the time when the beam passes its centre, or all at retrieval.map_time_s. mast: the antennas'
    motion; without it a boat at rest.
    """
    far = float(gates(radar)[-1])  # of the maps: the last gate, not the end of the window
    grid = ground_grid(far, retrieval.ground_m)
    x, y = np.meshgrid(grid.x, grid.y)
    antennas = mast or Mast(radar)
    inside, time = _passing(antennas, x, y, far, turn, retrieval.cell_azimuth_deg)
    if retrieval.map_time_s is not None:
        time = np.where(inside, turn * antennas.period + retrieval.map_time_s, np.nan)
    step = _GAUSS * retrieval.ground_m
    signs = np.array([[-1.0, -1.0], [1.0, -1.0], [-1.0, 1.0], [1.0, 1.0]])  # west–east, south–north
    corners = (x[inside][:, None] + step * signs[:, 0], y[inside][:, None] + step * signs[:, 1], time[inside][:, None])
    height, slopes = (values.mean(axis=1) for values in sea.elevation_and_slopes(*corners))

    def field(values: NDArray[np.float64]) -> NDArray[np.float64]:
        out = np.full(inside.shape, np.nan)
        out[inside] = values
        return out[None]

    return build(
        "truth/ground",
        {
            "height": field(height),
            "slope_x": field(slopes[:, 0]),
            "slope_y": field(slopes[:, 1]),
            "time": time[None],
        },
        {"turn": [turn], "y": grid.y, "x": grid.x},
    )


def _passing(
    mast: Mast, x: NDArray[np.float64], y: NDArray[np.float64], far: float, turn: int, cell_deg: float
) -> tuple[NDArray[np.bool_], NDArray[np.float64]]:
    """Which points (x, y) [m] the boresight passes in a turn, and when [s], NaN for the others."""
    radar, width = mast.radar, sector_width(mast.radar)
    times = (turn + np.linspace(0.0, 1.0, 721)) * mast.period
    pose = mast.pose(times)
    swept = (times - times[0]) * mast.rate + mast.swing(times)
    resting = np.ptp(pose.origin, axis=0).max() == 0.0
    time = np.full(x.shape, times[0])
    inside, east, north = np.zeros(x.shape, dtype=bool), np.zeros(x.shape), np.zeros(x.shape)
    for _ in range(1 if resting else 12):  # a moving mast: its position at the time of passing, by iteration
        east, north = (np.interp(time, times, pose.origin[:, axis]) for axis in (0, 1))
        sweep = (np.degrees(np.arctan2(x - east, y - north)) - radar.sector_deg[0]) % 360.0
        if radar.scan == "staring":
            inside, time = np.abs(sweep - 0.5 * width) <= 0.5 * cell_deg, np.full(x.shape, times[360])
            continue
        inside = np.isclose(width, 360.0) | (sweep <= width)
        if resting and not mast.swing(times).any():
            time = (turn + sweep / 360.0) * mast.period  # the same bits as the map's
        else:
            sweep = np.where((sweep < swept[0]) & (sweep + 360.0 <= swept[-1]), sweep + 360.0, sweep)
            time = np.interp(sweep, swept, times)
    inside &= np.hypot(x - east, y - north) <= far
    if not resting and radar.scan != "staring":  # points close to the boat's own path may not be passed at all
        east, north = (np.interp(time, times, pose.origin[:, axis]) for axis in (0, 1))
        bearing = np.degrees(np.arctan2(x - east, y - north)) - radar.sector_deg[0]
        inside &= np.abs(wrap_degrees(bearing - np.interp(time, times, swept))) <= 0.5 * cell_deg
    return inside, np.where(inside, time, np.nan)


class _Bins:
    """Fine bins of slant range, (column, bin).

    A facet is divided between the two bins whose middles are nearest to its point, so that a cell's mean changes
    smoothly as the sea rises and not by whole facets (steps of 9 mm become 2 mm).
    """

    def __init__(self, ranges: NDArray[np.float64], width: float, reach: float, slant: NDArray[np.float64]) -> None:
        self.width = width
        self.start = ranges[0] - reach - 2.0 * width
        self.count = int(np.ceil((ranges[-1] + reach + 2.0 * width - self.start) / width))
        self.columns = slant.shape[0]
        position = np.clip((slant - self.start) / width - 0.5, -1.0, self.count)
        number = position.astype(np.int32)
        self._kept = (position >= 0.0) & (number < self.count - 1)
        self._share = (position - number)[self._kept]  # of the farther bin
        self._index = (number + np.arange(self.columns)[:, None] * self.count)[self._kept]
        self.centre = self.start + width * (np.arange(self.count) + 0.5)

    def gather(self, values: NDArray) -> NDArray[np.float64]:
        """Sums (column, bin) of values (column, facet)."""
        near, length = values[self._kept], self.columns * self.count
        far = near * self._share
        total = np.bincount(self._index, weights=near - far, minlength=length).astype(np.float64)
        total[1:] += np.bincount(self._index, weights=far, minlength=length)[:-1]
        return total.reshape(self.columns, self.count)

    def box(self, ranges: NDArray[np.float64], length: float) -> NDArray[np.float64]:
        """(bin, gate): share of each bin within `length` centred on the gate."""
        low = np.maximum(self.centre[:, None] - 0.5 * self.width, ranges - 0.5 * length)
        high = np.minimum(self.centre[:, None] + 0.5 * self.width, ranges + 0.5 * length)
        return np.maximum(high - low, 0.0) / self.width

    def response(self, ranges: NDArray[np.float64], pulse: RangeResponse) -> NDArray[np.float64]:
        """(bin, gate): |h|², the power response of the gate at the bin's middle."""
        return pulse(ranges - self.centre[:, None]) ** 2


def _look_columns(facets: Facets, sweeps: NDArray[np.float64], cell_deg: float) -> NDArray[np.float64]:
    """(look, column): share of each column within the look."""
    width, middle = facets.grid.spacing_deg, facets.grid.column_sweep
    low = np.maximum(middle - 0.5 * width, sweeps[:, None] - 0.5 * cell_deg)
    high = np.minimum(middle + 0.5 * width, sweeps[:, None] + 0.5 * cell_deg)
    return np.maximum(high - low, 0.0) / width
