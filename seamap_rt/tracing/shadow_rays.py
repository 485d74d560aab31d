"""Shadow rays of a sheet of columns: which facets get one, where each starts and ends, and what its answer means.

A facet is lit if it shows the antenna its upper side and nothing lies between. The first is decided here, in float64;
the second is traced by the rays, which are float32 in a frame centred on the antennas: at 400 m they are aimed to
within 0.06 mm. A ray stops short of its facet's point inside the facet itself, so that no facet shadows itself and no
neighbour's shadow is lost.

A ray is carried as one number, from which the kernel that traces it computes its start and end: nothing else goes
through memory. The work before and after is short, and one thread does it: those of Dr.Jit spin for some 20 ms after
a kernel, and more threads would have to share the cores with them.
"""

from __future__ import annotations

import importlib
from dataclasses import dataclass
from functools import cached_property
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from ..compute.compiled import compiled
from ..conventions import unit_from_azimuth
from ..mesh import Facets, SurfaceMesh
from ..mesh.facets import FAR_FRACTION, NEAR_FRACTION, Plane
from ..mesh.grid import PolarGrid
from .illumination import copied, mitsuba

_STOP_SHORT = 0.9  # of the way back from a facet's point to where its plane enters the facet
_EDGE_ON = 1e-3  # rad: float32 corners tilt a facet by less, 1e-5 at 400 m and 0.5 m between rungs


@dataclass(frozen=True)
class ShadowRays:
    """The rays of a sheet, column by column, outward, the antennas' rays to one facet side by side.

    Rows are the antennas at the columns: all columns of the first antenna, then those of the next.
    """

    columns: NDArray[np.intp]  # (n,) of the sheet
    front: NDArray[np.bool_]  # (antenna, n, facet): the facet shows the antenna its upper side
    facing: NDArray[np.bool_]  # (n, facet): every antenna sees its upper side, wherever in this turn it stands
    facing_away: NDArray[np.bool_]  # (n, facet): none does
    number: NDArray[np.uint32]  # (ray,) of its antenna and facet: the flat index in front
    starts: NDArray[np.float32]  # (row, 3) m, east north up
    look: NDArray[np.float32]  # (row, 2) unit vector, east north
    points: NDArray[np.float32]  # (3, facet) m ahead along the look and to its right, and how far before it rays stop
    rise: NDArray[np.float32]  # (antenna, n, facet) m, of a facet's point above the antenna

    @property
    def start(self) -> NDArray[np.uint32]:
        """(ray,) its row in starts."""
        return self.number // np.uint32(self.front.shape[2])

    @property
    def first(self) -> NDArray[np.intp]:
        """(n + 1,) number of each column's first ray."""
        return np.concatenate(([0], np.cumsum(np.count_nonzero(self.front, axis=(0, 2)))))

    @cached_property
    def direction(self) -> NDArray[np.float32]:
        """(3, ray) unit vectors."""
        return np.array(self.traced.d)

    @cached_property
    def length(self) -> NDArray[np.float32]:
        """(ray,) m"""
        return np.array(self.traced.maxt)

    @property
    def traced(self) -> Any:
        """Mitsuba's rays, not yet evaluated. Unit vectors: with others Embree's packets of rays take 7 % longer."""
        mi, dr, facets = mitsuba(), importlib.import_module("drjit"), self.front.shape[2]
        number = copied(mi.UInt32, self.number)
        row = number // facets
        start = dr.gather(mi.Point3f, mi.Point3f(*_axes(mi, self.starts.T)), row)
        look = dr.gather(mi.Vector2f, mi.Vector2f(*_axes(mi, self.look.T)), row)
        ahead, right, short = dr.gather(mi.Vector3f, mi.Vector3f(*_axes(mi, self.points)), number - row * facets)
        east = look.x * ahead + look.y * right - start.x
        north = look.y * ahead - look.x * right - start.y
        up = dr.gather(mi.Float, copied(mi.Float, self.rise.reshape(-1)), number)
        away = dr.sqrt(east * east + north * north)
        slant = dr.sqrt(away * away + up * up)
        return mi.Ray3f(
            o=start,
            d=mi.Vector3f(east, north, up) / slant,
            maxt=slant * (1.0 - short / dr.maximum(away, 3.0 * short)),
            time=mi.Float(0.0),
            wavelengths=[],
        )

    def lit_facets(self, hit: NDArray[np.bool_]) -> NDArray[np.bool_]:
        """(antenna, n, facet) light, from what the rays (ray,) hit."""
        lit = np.zeros(self.front.shape, dtype=bool)
        _light_up(self.number, hit, lit.reshape(-1))
        return lit


def _axes(mi: Any, table: NDArray[np.float32]) -> list[Any]:
    return [copied(mi.Float, np.ascontiguousarray(axis)) for axis in table]


def shadow_rays(mesh: SurfaceMesh, facets: Facets, sheet: tuple[slice, ...]) -> ShadowRays:
    """The rays from every antenna, where it is when the beam passes a column, to the column's facets."""
    grid = mesh.grid
    columns = np.concatenate([np.arange(each.start, each.stop) for each in sheet])
    look, positions = np.stack(unit_from_azimuth(grid.column_azimuth[columns]), axis=1), grid.antenna_positions[columns]
    # Clockwise of the look (east, north) is (north, −east).
    axes = np.stack((look, look[:, ::-1] * (1.0, -1.0)), axis=1)
    starts = np.concatenate((positions[..., :2] @ axes, positions[..., 2:]), axis=2)

    shape = positions.shape[1], columns.size, facets.distance.size
    front, facing, facing_away = (np.empty(each, dtype=bool) for each in (shape, shape[1:], shape[1:]))
    rise, number = np.empty(shape, dtype=np.float32), np.empty(front.size + 1, dtype=np.uint32)
    bearing = np.cos(facets.angle), np.sin(facets.angle)
    along, across, up = np.moveaxis(grid.antenna_positions, -1, 0)
    reach = float(np.hypot(along, across).max()), float(up.min()), float(up.max())
    surface = facets.height, grid.column_height[:, 0], facets.slope_look, facets.slope_cross
    sea, antennas = _Facets(facets.distance, *bearing, *surface), _Antennas(positions, *reach)
    rays = _find_fronts(columns, sea, antennas, front, facing, facing_away, rise, number)
    return ShadowRays(
        columns,
        front,
        facing,
        facing_away,
        number[:rays],
        starts.swapaxes(0, 1).reshape(-1, 3).astype(np.float32),
        np.tile(look.astype(np.float32), (shape[0], 1)),
        np.stack((*(facets.distance * part for part in bearing), _stop_distances(facets, grid))).astype(np.float32),
        rise,
    )


def _stop_distances(facets: Facets, grid: PolarGrid) -> NDArray[np.float64]:
    """(facet,) m, how far before a facet's point its rays stop: its plane enters a near facet at the rung, a far one at
    the diagonal."""
    near, far = Plane.of(grid, NEAR_FRACTION).rung_distance, Plane.of(grid, FAR_FRACTION).diagonal_distance
    return _STOP_SHORT * (facets.distance - np.stack((near[:-1], far), axis=1).ravel())


class _Facets(NamedTuple):
    distance: NDArray[np.float64]  # (facet,) m
    cosine: NDArray[np.float64]  # (facet,) of the angle between the look and the facet's point
    sine: NDArray[np.float64]
    height: NDArray[np.float64]  # (column, facet) m
    level: NDArray[np.float64]  # (column,) m, of the frame's origin
    slope_look: NDArray[np.float32]  # (column, facet)
    slope_cross: NDArray[np.float32]


class _Antennas(NamedTuple):
    positions: NDArray[np.float64]  # (n, antenna, 3) m from the frame's origin
    aside: float  # m, furthest from the axis
    lowest: float  # m
    highest: float  # m


@compiled
def _find_fronts(columns, facets, antennas, front, facing, facing_away, rise, number):
    """Fill front, facing, facing_away, rise and number, which has room for one more; give the number of rays.

    An antenna lies above a facet's plane by slope · reach − rise. For facing it is taken to stand wherever that is
    least, for facing_away wherever it is most, within `aside` of the axis and between the lowest and the highest: a ray
    may cross facets of other columns than its own.
    Short loops that fill one row each, because these run in the processor's lanes.
    """
    distance, cosine, sine, height, level, slope_look, slope_cross = facets
    positions, aside, lowest, highest = antennas
    count, cells = front.shape[0], facing_away.size
    slope, faced, rays = np.empty(distance.size), front.reshape(count, cells), 0
    for n in range(columns.size):
        column = columns[n]
        look, cross, point = slope_look[column], slope_cross[column], height[column]
        shown, away = facing[n], facing_away[n]
        for facet in range(distance.size):
            slope[facet] = look[facet] * cosine[facet] + cross[facet] * sine[facet]
        for facet in range(distance.size):
            doubt = _EDGE_ON * distance[facet] + (abs(look[facet]) + abs(cross[facet])) * aside
            over = slope[facet] * distance[facet] - (point[facet] - level[column])
            shown[facet] = over - doubt + lowest > 0.0
            away[facet] = over + doubt + highest < 0.0
        for antenna in range(count):
            along, origin = positions[n, antenna, 0], level[column] + positions[n, antenna, 2]
            above, faces = rise[antenna, n], front[antenna, n]
            for facet in range(distance.size):
                above[facet] = point[facet] - origin
            for facet in range(distance.size):
                reach = distance[facet] - along
                faces[facet] = (reach > 0.0) & (slope[facet] * reach - (point[facet] - origin) > 0.0)
        # Every facet is written down, and written over if it has no ray: to leave it out would be a branch.
        for facet in range(n * distance.size, (n + 1) * distance.size):
            for antenna in range(count):
                number[rays] = antenna * cells + facet
                rays += faced[antenna, facet]
    return rays


@compiled
def _light_up(number, hit, lit):
    """Fill in the facets that have a ray, by their flat index."""
    for ray in range(number.size):
        lit[number[ray]] = not hit[ray]
