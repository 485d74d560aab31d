"""Which facets can be the first that a shadow ray meets: for shadow rays the others can be left out of the sea.

A ray that goes under water does so first through a facet that

1. shows the antenna its upper side,
2. is not itself below the line of sight over what lies before it,
3. has a ray's end beyond it that is seen no steeper: else the ray would not come up again to reach it.

Each is judged by bounds that hold for every ray that may pass: of angles over a whole facet, over as many columns to
either side as the ray from an antenna beside the axis may stray, and with room for float32. So a facet that is left out
stops no ray, or none that another does not stop before it, and what is traced stays the rays' own answer. A facet may
be kept in vain. Beyond the last crest that hides anything nothing is kept: at grazing angles half of what faces the
antenna, near the mast and on low waves nearly all of it goes, and the tree with it.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray
from scipy.ndimage import maximum_filter1d, minimum_filter1d

from ..compute.compiled import compiled, compiled_step
from ..compute.machine import run_blocks
from ..mesh import SurfaceMesh
from ..mesh.grid import PolarGrid
from .shadow_rays import ShadowRays

_MOST_ASIDE = 4  # columns that a ray may stray: nearer to the mast every facet that shows its upper side is kept
_ROUNDING = 4.0 * float(np.finfo(np.float32).eps)  # of the furthest range: three times what float32 puts rays off


@dataclass(frozen=True)
class _Reach:
    """Where a turn's antennas stand beside the axis, and how far their rays stray for that."""

    aside: float  # m, at most
    start: int  # the first rung from which on rays stray by few columns
    straying: NDArray[np.intp]  # how many rungs lie so near that a ray strays by one column at least, by two …
    around: int  # columns among which a ray may have started

    @classmethod
    def of(cls, grid: PolarGrid) -> _Reach:
        aside = float(np.hypot(grid.antenna_positions[..., 0], grid.antenna_positions[..., 1]).max())
        ranges, half = grid.ground_range, 0.5 * np.radians(grid.spacing_deg)
        strays = np.ceil(np.arcsin(np.minimum(1.0, aside / ranges)) / (2.0 * half)).astype(np.intp)
        known = (ranges * np.cos(half) > aside) & (strays <= _MOST_ASIDE)
        start = int(np.argmax(known)) if known.any() else ranges.size
        straying = np.array([np.count_nonzero(strays >= steps) for steps in range(1, _MOST_ASIDE + 1)])
        return cls(aside, start, straying, 2 * int(strays[known].max(initial=0)) + 1)


def hiding_facets(mesh: SurfaceMesh, sheet: tuple[slice, ...], rays: ShadowRays) -> NDArray[np.bool_]:
    """(n, facet) of the sheet's columns: the facet can be the first to stop one of the rays."""
    hiding, reach, begin = np.empty(rays.facing_away.shape, dtype=bool), _Reach.of(mesh.grid), 0
    for columns in sheet:
        end = begin + columns.stop - columns.start
        _fill_slice(mesh, columns, rays, slice(begin, end), reach, hiding[begin:end])
        begin = end
    return hiding


def _fill_slice(
    mesh: SurfaceMesh, columns: slice, rays: ShadowRays, own: slice, reach: _Reach, hiding: NDArray[np.bool_]
) -> None:
    """Fill hiding (column, facet) of a slice of the mesh's columns. own: the slice among the rays' columns."""
    grid, lines = mesh.grid, slice(columns.start, columns.stop + 1)
    ranges, half = grid.ground_range, 0.5 * np.radians(grid.spacing_deg)
    wedge = np.cos(half), half, reach.aside  # a column's half width, and how far beside its axis an antenna stands
    margin = _ROUNDING * float(np.hypot(ranges[-1], rays.rise.min(initial=0.0)))
    antennas = grid.antenna_positions[columns][..., ::2]  # along the column, and up
    least, most = (each(antennas, reach.around, axis=0) for each in (minimum_filter1d, maximum_filter1d))
    lowest = np.empty((antennas.shape[1], antennas.shape[0], ranges.size), dtype=np.float32)
    ends = rays.front[:, own], rays.rise[:, own], mesh.facets.distance, antennas
    run_blocks(lambda *block: _fill_lowest(*block, *ends, wedge, margin, lowest), antennas.shape[0])
    height = mesh.elevation[lines] - grid.pose.origin[lines, 2:]
    sheet = _Sheet(ranges, height, rays.facing[own], rays.facing_away[own], lowest)
    passing = _PassingRays(least, most, wedge, margin, reach.start, reach.straying)
    run_blocks(lambda *block: _fill_hiding(*block, sheet, passing, hiding), antennas.shape[0])


@compiled_step
def _closest(distance, most, wedge):
    """How near an antenna is at least to points of a column that far out: a chord bulges inward.

    most: how far along the column the antenna stands. Beside it, no more than the last of wedge.
    """
    return distance * wedge[0] - most


@compiled_step
def _furthest(distance, least, wedge):
    """How far it is at most."""
    ahead, beside = distance - least, distance * wedge[1] + wedge[2]
    return ahead + beside * beside / (2.0 * ahead)


@compiled_step
def _steepest(above, closest, furthest):
    """The steepest tangent under which an antenna may see what is so much higher; closest, furthest: 1/m."""
    return above * (furthest if above < 0.0 else closest)


@compiled_step
def _flattest(above, closest, furthest):
    """The least steep one."""
    return above * (closest if above < 0.0 else furthest)


@compiled
def _fill_lowest(begin, end, front, rise, distance, antennas, wedge, margin, lowest):
    """Fill lowest (antenna, column, rung): the least tangent under which a ray's end may be seen, there or beyond."""
    seen = np.empty(distance.size, dtype=np.float32)
    for n in range(begin, end):
        for antenna in range(front.shape[0]):
            ends, up, low = front[antenna, n], rise[antenna, n], lowest[antenna, n]
            along = antennas[n, antenna, 0]
            for facet in range(seen.size):
                closest, furthest = _closest(distance[facet], along, wedge), _furthest(distance[facet], along, wedge)
                tangent = _flattest(up[facet] - margin, 1.0 / closest, 1.0 / furthest)
                seen[facet] = tangent if ends[facet] else np.inf
            low[-1] = np.inf
            for rung in range(low.size - 2, -1, -1):
                low[rung] = min(low[rung + 1], min(seen[2 * rung], seen[2 * rung + 1]))


class _Sheet(NamedTuple):
    ranges: NDArray[np.float64]  # (rung,) m
    height: NDArray[np.float64]  # (line, rung) m above the frames' origins
    facing: NDArray[np.bool_]  # (column, facet)
    facing_away: NDArray[np.bool_]  # (column, facet)
    lowest: NDArray[np.float32]  # (antenna, column, rung) of `_fill_lowest`


class _PassingRays(NamedTuple):
    """The rays that may pass a column."""

    least: NDArray[np.float64]  # (column, antenna, 2) m, of their antennas' places along the column and up
    most: NDArray[np.float64]
    wedge: tuple[float, float, float]  # cosine and angle of a column's half width, m beside its axis
    margin: float  # m
    start: int  # see `_Reach`
    straying: NDArray[np.intp]


@compiled
def _fill_hiding(begin, end, sheet, passing, hiding):
    """Fill hiding (column, facet)."""
    ranges, height, facing, facing_away, lowest = sheet
    least, most, wedge, margin, start, straying = passing
    rungs = ranges.size
    low, before, beyond, closest, furthest, first, second = np.empty((7, rungs))
    turned, near, far = np.empty((3, rungs), dtype=np.bool_)
    for n in range(begin, end):
        _find_horizon(n, height, facing, start, straying, low, turned)
        for rung in range(rungs):
            near[rung] = far[rung] = rung < start
        for antenna in range(lowest.shape[0]):
            back, ahead = least[n, antenna, 0], most[n, antenna, 0]
            for rung in range(start, rungs):
                closest[rung] = 1.0 / _closest(ranges[rung], ahead, wedge)
                furthest[rung] = 1.0 / _furthest(ranges[rung], back, wedge)
            bottom, top = least[n, antenna, 1] - margin, most[n, antenna, 1] + margin
            one, other = height[n], height[n + 1]
            for rung in range(start, rungs):
                first[rung] = _steepest(one[rung] - bottom, closest[rung], furthest[rung])
                second[rung] = _steepest(other[rung] - bottom, closest[rung], furthest[rung])
                before[rung] = _flattest(low[rung] - top, closest[rung], furthest[rung])
            highest = -np.inf
            for rung in range(start, rungs):
                highest = max(highest, before[rung])
                before[rung] = highest
            _end_beyond(n, start, straying, lowest[antenna], turned, beyond)
            for rung in range(start, rungs - 1):
                corners, limit = max(first[rung], second[rung + 1]), max(before[rung], beyond[rung])
                near[rung] |= max(corners, second[rung]) >= limit
                far[rung] |= max(corners, first[rung + 1]) >= limit
        for rung in range(rungs - 1):
            hiding[n, 2 * rung] = near[rung] & (not facing_away[n, 2 * rung])
            hiding[n, 2 * rung + 1] = far[rung] & (not facing_away[n, 2 * rung + 1])


@compiled
def _find_horizon(n, height, facing, start, straying, low, turned):
    """Fill low (rung), the lowest line that a ray may cross there, −∞ beside the sheet, and turned (rung): some facet
    that it may cross may turn away."""
    columns, rungs = facing.shape[0], low.size
    for rung in range(rungs):
        low[rung] = min(height[n, rung], height[n + 1, rung])
    for rung in range(rungs - 1):
        turned[rung] = not (facing[n, 2 * rung] & facing[n, 2 * rung + 1])
    for step in range(1, straying.size + 1):
        for line in (n - step, n + 1 + step):
            inside = 0 <= line <= columns
            for rung in range(start, straying[step - 1]):
                low[rung] = min(low[rung], height[line, rung]) if inside else -np.inf
        for column in (n - step, n + step):
            if 0 <= column < columns:
                for rung in range(start, min(straying[step - 1], rungs - 1)):
                    turned[rung] |= not (facing[column, 2 * rung] & facing[column, 2 * rung + 1])


@compiled
def _end_beyond(n, start, straying, lowest, turned, beyond):
    """Fill beyond (rung): the least tangent of a ray's end that a facet there can hide.

    Within its own rung it can hide one only if the water there turns away somewhere between, where a ray would come up.
    """
    columns, last = lowest.shape[0], beyond.size - 1
    for rung in range(start, last):
        beyond[rung] = lowest[n, rung] if turned[rung] else lowest[n, rung + 1]
    for step in range(1, straying.size + 1):
        for column in (n - step, n + step):
            if 0 <= column < columns:
                for rung in range(start, min(straying[step - 1], last)):
                    other = lowest[column, rung] if turned[rung] else lowest[column, rung + 1]
                    beyond[rung] = min(beyond[rung], other)
