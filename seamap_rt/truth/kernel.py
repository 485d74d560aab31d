"""A column's facets into cells, in one pass: every quantity of a facet is added while it is at hand."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from ..compute.compiled import compiled

# What is summed over the facets of a cell, each times the facet's horizontal area, but for the echo.
AREA, SEEN, HEIGHT, HEIGHT_SEEN, SLOPE_LOOK, SLOPE_CROSS, ECHO, LIGHT = range(8)
QUANTITIES = 8


class Surface(NamedTuple):
    """What is summed: (column, facet), or (facet,) where all columns have it alike."""

    distance: NDArray[np.float64]  # (facet,) m
    apart: NDArray[np.float64]  # (facet, part) m along the look, of its parts' points from its own
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
    """Fill mean (column, facet) with the heights less what the water's bend takes off; step, width (facet,) m."""
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
            mean[column, facet] = height[column, facet] - bend / 12.0


@compiled
def fill_cells(begin, end, surface, bins, box, response, cells, weighted):
    """Fill cells (column, gate, quantity) with the sums by the weights of the box, and weighted (column, gate, 2) with
    those of area and height by the gates' response."""
    sums = np.empty((bins.size, QUANTITIES))
    area, height = np.empty(bins.size), np.empty(bins.size)
    for column in range(begin, end):
        sums[:] = 0.0
        _gather(column, surface, bins, sums)
        for number in range(bins.size):
            area[number], height[number] = sums[number, AREA], sums[number, HEIGHT]
        for gate in range(cells.shape[1]):
            first = box.first[gate]
            for quantity in range(QUANTITIES):
                cells[column, gate, quantity] = 0.0
            for n in range(box.weight.shape[1]):
                for quantity in range(QUANTITIES):
                    cells[column, gate, quantity] += box.weight[gate, n] * sums[first + n, quantity]
            first, of_area, of_height = response.first[gate], 0.0, 0.0
            for n in range(response.weight.shape[1]):
                of_area += response.weight[gate, n] * area[first + n]
                of_height += response.weight[gate, n] * height[first + n]
            weighted[column, gate, 0], weighted[column, gate, 1] = of_area, of_height


@compiled
def _gather(column, surface, bins, sums):
    """Add a column's facets to sums (bin, quantity), divided between the two bins whose middles are nearest."""
    value = np.empty(QUANTITIES)
    origin = surface.origin[column]
    for facet in range(surface.distance.size):
        area, lean = surface.area[facet], surface.slope_look[column, facet]
        lit = surface.lit[column, facet]
        value[AREA], value[SEEN] = area, lit * area
        value[SLOPE_LOOK], value[SLOPE_CROSS] = area * lean, area * surface.slope_cross[column, facet]
        arriving = surface.arriving[column, facet]
        value[ECHO] = surface.rcs[column, facet] * arriving / surface.apart.shape[1]
        value[LIGHT] = area * arriving
        for part in range(surface.apart.shape[1]):
            apart = surface.apart[facet, part]
            height = surface.height[column, facet] + lean * apart
            distance, rise = surface.distance[facet] + apart, height - origin
            position = (np.sqrt(distance * distance + rise * rise) - bins.start) / bins.width - 0.5
            if not 0.0 <= position < bins.size - 1:
                continue
            value[HEIGHT], value[HEIGHT_SEEN] = area * height, lit * area * height
            number = int(position)
            share = position - number
            for quantity in range(QUANTITIES):
                sums[number, quantity] += (1.0 - share) * value[quantity]
                sums[number + 1, quantity] += share * value[quantity]


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
