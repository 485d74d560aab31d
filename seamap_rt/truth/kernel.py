"""A column's facets into cells, in one pass: every quantity of a facet is added while it is at hand."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from ..compute.compiled import compiled, compiled_step

# What is summed over the facets of a cell, each times the facet's horizontal area, but for the echo.
AREA, SEEN, HEIGHT, HEIGHT_SEEN, SLOPE_LOOK, SLOPE_CROSS, ECHO, LIGHT = range(8)
QUANTITIES = 8


class Surface(NamedTuple):
    """What is summed: (column, facet), or (facet,) where all columns have it alike."""

    distance: NDArray[np.float64]  # (facet,) m
    apart: NDArray[np.float64]  # (part, facet) m along the look, of the parts' points from the facet's own
    area: NDArray[np.float64]  # (facet,) m², of a part
    origin: NDArray[np.float64]  # (column,) m, of the frame above mean sea level
    height: NDArray[np.float64]
    slope_look: NDArray[np.float32]
    slope_cross: NDArray[np.float32]
    lit: NDArray[np.float32]  # share of it that is seen
    arriving: NDArray[np.float32]  # share of the power, out and back
    rcs: NDArray[np.float32]  # m²


class Bins(NamedTuple):
    """Fine bins of slant range [m]: their number, the near edge of the first, and their width."""

    size: int
    start: float
    width: float


class Band(NamedTuple):
    """Weights of the bins in each gate: of `weight.shape[1]` of them, all others being 0."""

    first: NDArray[np.int64]  # (gate,)
    weight: NDArray[np.float64]  # (gate, bin from the first on)


@compiled
def fill_mean_heights(begin, end, slope_look, slope_cross, step, width, height, mean):
    """Fill mean (column from begin on, facet) with the heights less what the water's bend takes off; step, width
    (facet,) m."""
    columns, facets = height.shape
    for column in range(begin, end):
        before, after = max(column - 1, 0), min(column + 1, columns - 1)
        across = 1.0 / max(after - before, 1)
        for facet in range(facets):
            near = facet - 2 if facet >= 2 else facet  # the neighbours of its own kind
            far = facet + 2 if facet + 2 < facets else facet
            along = 2.0 / max(far - near, 1)
            look = along * (slope_look[column, far] - slope_look[column, near])
            turning = across * (slope_look[after, facet] - slope_look[before, facet])
            cross = across * (slope_cross[after, facet] - slope_cross[before, facet])
            bend = step[facet] * (look + turning) + width[facet] * cross
            mean[column - begin, facet] = height[column, facet] - bend / 12.0


@compiled
def fill_cells(begin, end, surface, bins, box, response, cells, weighted):
    """Fill cells (column, gate, quantity) with the sums by the weights of the box, and weighted (column, gate, 2) with
    those of area and height by the gates' response."""
    sums = np.empty((QUANTITIES, bins.size))
    position, level = np.empty(surface.apart.shape), np.empty(surface.apart.shape)
    for column in range(begin, end):
        sums[:] = 0.0
        _place(column, surface, bins, position, level)
        _gather(column, surface, bins, position, level, sums)
        for quantity in range(QUANTITIES):
            _add_bins(sums[quantity], box, cells[column, :, quantity])
        _add_bins(sums[AREA], response, weighted[column, :, 0])
        _add_bins(sums[HEIGHT], response, weighted[column, :, 1])


@compiled_step
def _add_bins(values, band, out):
    """Fill out (gate,) with the sums of values (bin,) by a band's weights."""
    for gate in range(out.size):
        total, first = 0.0, np.uint64(band.first[gate])
        for n in range(np.uint64(band.weight.shape[1])):
            total += band.weight[gate, n] * values[first + n]
        out[gate] = total


@compiled
def _place(column, surface, bins, position, height):
    """Fill (part, facet) of a column: where each lies among the bins' middles, and its height."""
    origin, lean, middle = surface.origin[column], surface.slope_look[column], surface.height[column]
    distance, each = surface.distance, 1.0 / bins.width
    for part in range(position.shape[0]):
        apart, at, level = surface.apart[part], position[part], height[part]
        for facet in range(distance.size):  # one row after another, in the processor's lanes
            level[facet] = middle[facet] + lean[facet] * apart[facet]
            away, rise = distance[facet] + apart[facet], level[facet] - origin
            at[facet] = (np.sqrt(away * away + rise * rise) - bins.start) * each - 0.5


@compiled
def _gather(column, surface, bins, position, height, sums):
    """Add a column's facets to sums (quantity, bin), divided between the two bins whose middles are nearest.

    position, height (part, facet): as `_place` fills them.
    """
    parts, area_of, lit, rcs, light = position.shape[0], surface.area, surface.lit, surface.rcs, surface.arriving
    slope_look, slope_cross, last = surface.slope_look, surface.slope_cross, bins.size - 1
    for facet in range(area_of.size):
        area, arriving = area_of[facet], np.float64(light[column, facet])
        seen, echo = lit[column, facet] * area, rcs[column, facet] * arriving / parts
        look, cross = area * slope_look[column, facet], area * slope_cross[column, facet]
        for part in range(parts):
            at, level = position[part, facet], height[part, facet]
            if not 0.0 <= at < last:
                continue
            number = np.uint64(at)
            value = area, seen, level * area, level * seen, look, cross, echo, area * arriving  # in their order
            _add(sums, number, 1.0 - (at - number), value)
            _add(sums, number + np.uint64(1), at - number, value)


@compiled_step
def _add(sums, number, weight, value):
    """Add a facet's quantities to a bin."""
    for quantity in range(QUANTITIES):
        sums[quantity, number] += weight * value[quantity]


@compiled
def add_columns(begin, end, weight, columns, out):
    """Fill out (look, n) with the sums of columns (column, n) by weight (look, column), of which most are 0."""
    for look in range(begin, end):
        out[look] = 0.0
        for column in range(weight.shape[1]):
            share = weight[look, column]
            if share != 0.0:
                for n in range(out.shape[1]):
                    out[look, n] += share * columns[column, n]
