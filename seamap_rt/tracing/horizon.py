"""Light by the running maximum of the elevation angle, exact on the triangulated surface, in float64.

Along a plane through the antenna's axis the surface is a chain of straight segments: a facet's point is lit when it is
seen under a steeper angle than every corner of the chain before it. That includes the facet's own near corner, so
facets seen from behind come out dark. An antenna that stands a little beside the plane is taken to stand in it.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from ..compute.compiled import compiled_strict
from ..compute.machine import run_blocks
from ..mesh.facets import FAR_FRACTION, NEAR_FRACTION, Plane
from ..mesh.surface import SurfaceMesh
from .illumination import Illumination


def trace_horizon(mesh: SurfaceMesh) -> Illumination:
    """The mesh's facets, lit geometrically."""
    facets, grid = mesh.facets, mesh.grid
    lit = np.empty((grid.antenna_positions.shape[1], *facets.height.shape), dtype=bool)
    along, above = grid.antenna_positions[..., 0], grid.column_height + grid.antenna_positions[..., 2]
    planes = [Plane.of(grid, fraction) for fraction in (NEAR_FRACTION, FAR_FRACTION)]

    def work(begin: int, end: int) -> None:
        for first, plane in enumerate(planes):
            _light(begin, end, first, mesh.elevation, plane, facets.distance, facets.height, along, above, lit)

    run_blocks(work, grid.columns)
    return Illumination.of(facets, lit)


class Skyline:
    """What the sea hides of things that stand in it or beyond it: the horizon along the line nearest to each."""

    def __init__(self, mesh: SurfaceMesh) -> None:
        self._grid, self._elevation = mesh.grid, mesh.elevation

    def sees(self, eyes: NDArray[np.float64], points: NDArray[np.float64]) -> NDArray[np.bool_]:
        """(n,) whether eyes (n, 3) near the mast see points (n, 3) of the world over the crests.

        False beside the mesh, where no beam looks.
        """
        grid = self._grid
        away = points[:, :2] - eyes[:, :2]
        distance = np.maximum(np.hypot(*away.T), 1e-9)
        azimuth = np.degrees(np.arctan2(away[:, 0], away[:, 1]))
        # Of a turn that overlaps its own start, the line within the turn; of a sector, those before its start too.
        number = np.rint((azimuth - grid.azimuth[0] + grid.sweep[0]) % 360.0 / grid.spacing_deg).astype(np.intp)
        line = np.where(number - grid.first < grid.sweep.size, number, number - grid.per_circle) - grid.first
        known = line >= 0
        tangent = (self._elevation[np.where(known, line, 0)] - eyes[:, 2:]) / grid.ground_range
        nearer = grid.ground_range < distance[:, None]
        highest = np.where(nearer, tangent, -np.inf).max(axis=1)
        return known & ((points[:, 2] - eyes[:, 2]) / distance > highest)


@compiled_strict
def _light(begin, end, first, elevation, plane, distance, height, along, above, lit):
    """Fill lit (antenna, column, facet) of the facets first, first + 2 …, which lie on the plane.

    Corners alternate rung, diagonal, rung …: the last one before a near facet (first = 0) is its rung, before a far
    facet (first = 1) its diagonal. along, above: (column, antenna) of the antennas.
    """
    fraction, rung_distance, diagonal_distance, share = plane
    for column in range(begin, end):
        here, there = elevation[column], elevation[column + 1]
        for antenna in range(lit.shape[0]):
            ahead, top = along[column, antenna], above[column, antenna]
            highest = -np.inf
            for rung in range(share.size):
                facet = 2 * rung + first
                corner = (1.0 - fraction) * here[rung] + fraction * there[rung]
                highest = max(highest, _tangent(rung_distance[rung] - ahead, corner - top))
                diagonal = (1.0 - share[rung]) * here[rung] + share[rung] * there[rung + 1]
                beyond = max(highest, _tangent(diagonal_distance[rung] - ahead, diagonal - top))
                edge = beyond if first else highest
                lit[antenna, column, facet] = _tangent(distance[facet] - ahead, height[column, facet] - top) > edge
                highest = beyond


@compiled_strict
def _tangent(reach, rise):
    """Of the elevation angle under which the antenna sees a point; −inf for what is not in front of it."""
    return rise / reach if reach > 0.0 else -np.inf
