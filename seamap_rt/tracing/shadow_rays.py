"""Shadow rays of a sheet of columns: which facets get one, where each starts and ends, and what its answer means.

A facet is lit if it shows the antenna its upper side and nothing lies between. The first is settled here, in float64;
the second is asked of the rays, which are float32 in a frame centred on the antennas: 0.03 mm at 400 m. A ray stops
short of its facet's point inside the facet itself, so that no facet shadows itself and no neighbour's shadow is lost.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from ..compiled import compiled
from ..conventions import unit_from_azimuth
from ..mesh import Facets, SurfaceMesh
from ..mesh.facet_kernel import in_blocks
from ..mesh.polar import FAR_FRACTION, NEAR_FRACTION, Plane, PolarGrid

_STOP_SHORT = 0.9  # of the way back from a facet's point to where its plane enters the facet
_EDGE_ON = 1e-3  # rad: float32 corners tilt a facet by less, 1e-5 at 400 m and 0.5 m between rungs


@dataclass(frozen=True)
class ShadowRays:
    """The rays of a sheet, column by column, outward, the antennas' rays to one facet side by side."""

    columns: NDArray[np.intp]  # (n,) of the sheet
    front: NDArray[np.bool_]  # (antenna, n, facet): the facet shows the antenna its upper side
    turned_away: NDArray[np.bool_]  # (n, facet): no antenna sees its upper side, wherever in this turn it stands
    first: NDArray[np.intp]  # (n + 1,) number of each column's first ray
    starts: NDArray[np.float32]  # (antenna × n, 3) m, east north up, antennas of a column side by side
    start: NDArray[np.uint32]  # (ray,) its row in starts
    direction: NDArray[np.float32]  # (3, ray) unit vectors
    length: NDArray[np.float32]  # (ray,) m

    def lit(self, hit: NDArray[np.bool_]) -> NDArray[np.bool_]:
        """(antenna, n, facet) light, from what the rays (ray,) hit."""
        lit = self.front.copy()
        in_blocks(lambda *block: _shade(*block, self.first, hit, lit), self.columns.size)
        return lit


def shadow_rays(mesh: SurfaceMesh, facets: Facets, sheet: tuple[slice, ...]) -> ShadowRays:
    """The rays from every antenna, where it is when the beam passes a column, to the column's facets."""
    grid = mesh.grid
    columns = np.concatenate([np.arange(each.start, each.stop) for each in sheet])
    look = np.stack(unit_from_azimuth(grid.column_azimuth), axis=1)
    # Clockwise of the look (east, north) is (north, −east).
    turned = np.stack((look, look[:, ::-1] * (1.0, -1.0)), axis=1)
    starts = np.concatenate((grid.places[..., :2] @ turned, grid.places[..., 2:]), axis=2)

    shape = grid.places.shape[1], columns.size, facets.distance.size
    front, turned_away = np.empty(shape, dtype=bool), np.empty(shape[1:], dtype=bool)
    count = np.empty(columns.size, dtype=np.intp)
    bearing = np.sin(facets.angle), np.cos(facets.angle)
    slopes = facets.slope_look, facets.slope_cross
    level = grid.column_height[:, 0]
    reach = float(np.hypot(grid.places[..., 0], grid.places[..., 1]).max()), float(grid.places[..., 2].max())
    known = columns, facets.distance, *bearing, facets.height, level
    in_blocks(
        lambda *block: _find_fronts(*block, *known, *slopes, grid.places, *reach, front, turned_away, count),
        columns.size,
    )

    first = np.concatenate(([0], np.cumsum(count)))
    start = np.empty(first[-1], dtype=np.uint32)
    direction, length = np.empty((3, first[-1]), dtype=np.float32), np.empty(first[-1], dtype=np.float32)
    short = _STOP_SHORT * (facets.distance - _entries(grid))
    in_blocks(
        lambda *block: _aim(*block, *known, look, starts, short, front, first, start, direction, length), columns.size
    )
    table = starts[columns].reshape(-1, 3).astype(np.float32)
    return ShadowRays(columns, front, turned_away, first, table, start, direction, length)


def _entries(grid: PolarGrid) -> NDArray[np.float64]:
    """(facet,) m, where its plane enters each facet: a near one at its rung, a far one at its diagonal."""
    near, far = Plane.of(grid, NEAR_FRACTION).rung_distance, Plane.of(grid, FAR_FRACTION).diagonal_distance
    return np.stack((near[:-1], far), axis=1).ravel()


@compiled
def _find_fronts(
    begin, end, columns, distance, sine, cosine, height, level, slope_look, slope_cross, places, aside, top,
    front, turned_away, count,
):  # fmt: skip
    """Fill front, turned_away and the number of rays of each column.

    An antenna lies above a facet's plane by slope · reach − rise. For turned_away it is taken to stand wherever that is
    most, within `aside` of the axis and at `top`: a ray may cross facets of other columns than its own.
    """
    for n in range(begin, end):
        column, rays = columns[n], 0
        for facet in range(distance.size):
            look, cross = float(slope_look[column, facet]), float(slope_cross[column, facet])
            slope = look * cosine[facet] + cross * sine[facet]
            rise = height[column, facet] - level[column]
            for antenna in range(places.shape[1]):
                reach = distance[facet] - places[column, antenna, 0]
                faces = reach > 0.0 and slope * reach - (rise - places[column, antenna, 2]) > 0.0
                front[antenna, n, facet] = faces
                rays += faces
            most = (slope + _EDGE_ON) * distance[facet] + (abs(look) + abs(cross)) * aside - (rise - top)
            turned_away[n, facet] = most < 0.0
        count[n] = rays


@compiled
def _aim(
    begin, end, columns, distance, sine, cosine, height, level, look, starts, short, front, first,
    start, direction, length,
):  # fmt: skip
    """Fill start, direction and length of the columns' rays."""
    antennas = front.shape[0]
    for n in range(begin, end):
        column, ray = columns[n], first[n]
        for facet in range(distance.size):
            # The facet's point: its angle is reckoned clockwise from the look.
            east = (look[column, 0] * cosine[facet] + look[column, 1] * sine[facet]) * distance[facet]
            north = (look[column, 1] * cosine[facet] - look[column, 0] * sine[facet]) * distance[facet]
            rise = height[column, facet] - level[column]
            for antenna in range(antennas):
                if front[antenna, n, facet]:
                    x, y = east - starts[column, antenna, 0], north - starts[column, antenna, 1]
                    z = rise - starts[column, antenna, 2]
                    away = np.sqrt(x * x + y * y)
                    slant = np.sqrt(away * away + z * z)
                    start[ray] = n * antennas + antenna
                    direction[0, ray], direction[1, ray], direction[2, ray] = x / slant, y / slant, z / slant
                    length[ray] = slant * (1.0 - short[facet] / max(away, 3.0 * short[facet]))
                    ray += 1


@compiled
def _shade(begin, end, first, hit, lit):
    """Put out the facets whose rays hit something."""
    for n in range(begin, end):
        ray = first[n]
        for facet in range(lit.shape[2]):
            for antenna in range(lit.shape[0]):
                if lit[antenna, n, facet]:
                    lit[antenna, n, facet] = not hit[ray]
                    ray += 1
