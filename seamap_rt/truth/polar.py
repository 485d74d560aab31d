"""The true sea in the cells of the polar maps: means of the traced facets over each cell.

Facets are summed into fine bins of slant range, column by column; a cell is a sum of bins and columns, each weighted
by its overlap with the cell.
"""

from __future__ import annotations

from collections.abc import Callable

import numpy as np
import xarray as xr
from numpy.typing import NDArray

from ..compute.machine import run_blocks
from ..conventions import db
from ..dataset import build
from ..echoes.radar_cross_section import two_way_power
from ..mesh import Facets, PolarGrid
from ..radar.grid import look_sweeps
from ..radar.installation import Installation
from ..radar.scan import dwell_power
from ..radar.waveform import RangeResponse, gates
from ..settings import RadarSettings, RetrievalSettings
from ..tracing import Illumination
from .kernel import (
    AREA,
    ECHO,
    HEIGHT,
    HEIGHT_SEEN,
    LIGHT,
    QUANTITIES,
    SEEN,
    SLOPE_CROSS,
    SLOPE_LOOK,
    Band,
    Bins,
    Surface,
    add_columns,
    fill_cells,
    fill_mean_heights,
)

FAINTEST = 1e-15  # NRCS below which a cell is dark: smaller values are rounding errors
_BINS_PER_GATE = 6
_POINTS_A_CELL = 6  # along the look, at least
_LEAST_RESPONSE = 1e-16  # of the greatest: what is less does not change a sum


def polar_truth(
    facets: Illumination, rcs: NDArray[np.float32], installation: Installation, retrieval: RetrievalSettings, turn: int
) -> xr.Dataset:
    """The schema's `truth/polar` (turn, azimuth, range) of one turn, from the traced facets.

    rcs: (column, facet) radar cross-sections [m²], 0 where no ray arrives. NaN in cells without facets. The same bits
    for any number of threads.
    """
    radar = installation.radar
    sweeps = _sweeps(radar, retrieval)
    looks = _look_columns(facets, sweeps, retrieval.cell_azimuth_deg)
    beam = _beam(facets, sweeps, installation, retrieval)
    cells, weighted = _column_cells(facets, rcs, installation, retrieval)
    bent = facets.field is not None
    return _truth(facets.grid, _added(looks, cells), _added(beam, weighted), radar, retrieval, turn, bent)


def _truth(
    grid: PolarGrid,
    sums: NDArray[np.float64],
    weighted: NDArray[np.float64],
    radar: RadarSettings,
    retrieval: RetrievalSettings,
    turn: int,
    bent: bool,
) -> xr.Dataset:
    """From sums (look, gate, quantity) over cells, and (look, gate, 2) of area and height by response and beam."""
    sweeps = _sweeps(radar, retrieval)
    whole, echo = sums[..., AREA], sums[..., ECHO]
    with np.errstate(invalid="ignore", divide="ignore"):
        values = {
            "height": sums[..., HEIGHT] / whole,
            "height_visible": sums[..., HEIGHT_SEEN] / sums[..., SEEN],
            "visible_fraction": sums[..., SEEN] / whole,
            "slope_range": sums[..., SLOPE_LOOK] / whole,
            "slope_azimuth": sums[..., SLOPE_CROSS] / whole,
            "nrcs_db": db(np.where(echo > FAINTEST * whole, echo, 0.0) / whole),
        }
        if bent:
            values["illumination"] = sums[..., LIGHT] / whole
        values["height_weighted"] = weighted[..., 1] / weighted[..., 0]
    empty = whole <= 0.0
    fields = {name: np.where(empty | ~np.isfinite(field), np.nan, field)[None] for name, field in values.items()}
    times = np.interp(sweeps, grid.sweep, grid.time)
    fields["time"] = times[None]
    azimuth = (radar.sector_deg[0] + sweeps) % 360.0
    return build("truth/polar", fields, {"turn": [turn], "azimuth": azimuth, "range": gates(radar)})


def _column_cells(
    facets: Illumination, rcs: NDArray[np.float32], installation: Installation, retrieval: RetrievalSettings
) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
    """Each column's sums (column, gate, quantity) over the gates' cells, and (column, gate, 2) of area and height by
    the gates' response."""
    apart, *bands = _bands(facets, installation, retrieval)
    shape = facets.grid.columns, gates(installation.radar).size
    cells, weighted = np.empty((*shape, QUANTITIES)), np.empty((*shape, 2))
    for columns in facets.grid.parts:
        given = _surface(facets, rcs, columns, apart), *bands, cells[columns], weighted[columns]
        run_blocks(lambda *block, given=given: fill_cells(*block, *given), columns.stop - columns.start)
    return cells, weighted


def _surface(facets: Illumination, rcs: NDArray[np.float32], columns: slice, apart: NDArray[np.float64]) -> Surface:
    """What is summed of some columns; apart: as `_bands` gives it."""
    part = facets.part(columns)
    return Surface(
        distance=facets.distance,
        apart=np.ascontiguousarray(apart.T),
        area=facets.horizontal_area / apart.shape[1],
        origin=np.ascontiguousarray(part.grid.column_height[:, 0]),
        height=_mean_heights(facets, columns),
        slope_look=np.ascontiguousarray(part.slope_look),
        slope_cross=np.ascontiguousarray(part.slope_cross),
        lit=_visible_share(part),
        arriving=np.ascontiguousarray(two_way_power(part)),
        rcs=np.ascontiguousarray(rcs[columns]),
    )


def _bands(
    facets: Facets, installation: Installation, retrieval: RetrievalSettings
) -> tuple[NDArray[np.float64], Bins, Band, Band]:
    """Where (facet, part) [m] a facet's parts lie from its point, the bins, and how they make the gates' cells and what
    the gates hear."""
    rungs = float(np.diff(facets.grid.ground_range).max())
    divided = rungs > retrieval.cell_range_m / _POINTS_A_CELL
    apart = _halves(facets.grid) if divided else np.zeros((facets.distance.size, 1))
    radar, pulse = installation.radar, installation.response
    ranges = gates(radar)
    reach = max(pulse.support_m, 0.5 * retrieval.cell_range_m)
    # Bins narrower than half the facets' spacing would be empty in places.
    bins = _bins(ranges, max(radar.range_sampling_m / _BINS_PER_GATE, 0.5 * rungs), reach)
    return apart, bins, _box(ranges, retrieval.cell_range_m, bins), _response(ranges, pulse, bins)


def _sweeps(radar: RadarSettings, retrieval: RetrievalSettings) -> NDArray[np.float64]:
    """(look,) deg"""
    return look_sweeps(radar.sector_deg, retrieval.cell_azimuth_deg, radar.scan == "staring")


def _beam(
    facets: Facets, sweeps: NDArray[np.float64], installation: Installation, retrieval: RetrievalSettings
) -> NDArray[np.float64]:
    """(look, column): power of the beam over the look's dwell."""
    width = 0.0 if installation.radar.scan == "staring" else retrieval.cell_azimuth_deg
    return dwell_power(installation.array, sweeps[:, None] - facets.grid.column_sweep, width)


def _visible_share(facets: Illumination) -> NDArray[np.float32]:
    """Share (column, facet) of a facet's water that both antennas see."""
    lit = facets.visible_to_both.astype(np.float32, order="C")
    return lit if facets.in_sight is None else lit * facets.in_sight


def _added(weight: NDArray[np.float64], columns: NDArray[np.float64]) -> NDArray[np.float64]:
    """(look, gate, quantity) sums of columns (column, gate, quantity) by weight (look, column)."""
    out = np.empty((weight.shape[0], *columns.shape[1:]))
    rows, flat = out.reshape(len(out), -1), columns.reshape(len(columns), -1)
    run_blocks(lambda *block: add_columns(*block, weight, flat, rows), len(out))
    return out


def _mean_heights(facets: Facets, columns: slice) -> NDArray[np.float64]:
    """Mean heights (column, facet) [m] of the water over each facet of some columns: it is flat, the water curved.

    Over a triangle with edges e the mean of a surface with the second derivatives H lies Σ eᵀHe/24 below the plane
    through its corners. H is the difference of the slopes of facets of one kind (near or far), from rung to
    rung and from column to column.
    """
    step = np.repeat(np.diff(facets.grid.ground_range), 2)
    width = facets.distance * np.radians(facets.grid.spacing_deg)
    slopes = (np.ascontiguousarray(each) for each in (facets.slope_look, facets.slope_cross))
    given, first = (*slopes, step, width, np.ascontiguousarray(facets.height)), columns.start
    mean = np.empty((columns.stop - first, facets.distance.size))
    run_blocks(lambda begin, end: fill_mean_heights(first + begin, first + end, *given, mean[begin:end]), len(mean))
    return mean


def _halves(grid: PolarGrid) -> NDArray[np.float64]:
    """Where (facet, half) [m] from a facet's point, along the look, two of half its area stand for it, so that a cell's
    edge can divide it.

    Their distance gives the pair the second moment of the triangle, 1/18 of its length squared.
    """
    apart = np.sqrt(1.0 / 18.0) * np.repeat(np.diff(grid.ground_range), 2)
    return np.stack((-apart, apart), axis=-1)


def _bins(ranges: NDArray[np.float64], width: float, reach: float) -> Bins:
    """Bins of slant range, beyond the gates by `reach`.

    A facet is divided between the two bins whose middles are nearest to its point, so that a cell's mean changes
    smoothly as the sea rises and not by whole facets (steps of 9 mm become 2 mm).
    """
    start = float(ranges[0]) - reach - 2.0 * width
    return Bins(int(np.ceil((float(ranges[-1]) + reach + 2.0 * width - start) / width)), start, width)


def _box(ranges: NDArray[np.float64], length: float, bins: Bins) -> Band:
    """Share of each bin within `length` [m] centred on the gate."""
    half = 0.5 * bins.width

    def share(offset: NDArray[np.float64]) -> NDArray[np.float64]:
        high, low = np.minimum(offset + half, 0.5 * length), np.maximum(offset - half, -0.5 * length)
        return np.maximum(high - low, 0.0) / bins.width

    return _band(ranges, bins, 0.5 * length + half, share)


def _response(ranges: NDArray[np.float64], pulse: RangeResponse, bins: Bins) -> Band:
    """|h|², the power response of the gate at the bin's middle."""
    offset = 0.5 * bins.width * np.arange(2 * bins.size + 2)
    power = pulse(offset) ** 2
    return _band(ranges, bins, offset[power > _LEAST_RESPONSE * power.max()][-1] + bins.width, lambda x: pulse(x) ** 2)


def _band(
    ranges: NDArray[np.float64], bins: Bins, reach: float, weight: Callable[[NDArray[np.float64]], NDArray[np.float64]]
) -> Band:
    """The weights of bins within `reach` [m] of each gate, by how far their middles lie beyond it [m]."""
    most = min(bins.size, int(np.ceil(2.0 * reach / bins.width)) + 2)
    first = np.floor((ranges - reach - bins.start) / bins.width).astype(np.int64)
    first = np.clip(first, 0, bins.size - most)
    middle = bins.start + bins.width * (first[:, None] + np.arange(most) + 0.5)
    return Band(first, weight(middle - ranges[:, None]))


def _look_columns(facets: Facets, sweeps: NDArray[np.float64], cell_deg: float) -> NDArray[np.float64]:
    """(look, column): share of each column within the look."""
    width, middle = facets.grid.spacing_deg, facets.grid.column_sweep
    low = np.maximum(middle - 0.5 * width, sweeps[:, None] - 0.5 * cell_deg)
    high = np.minimum(middle + 0.5 * width, sweeps[:, None] + 0.5 * cell_deg)
    return np.maximum(high - low, 0.0) / width
