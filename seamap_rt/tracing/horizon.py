"""Light by the running maximum of the elevation angle, exact on the triangulated surface, in float64.

Along a plane through the antenna's axis the surface is a chain of straight segments: a facet's point is lit when it is
seen under a steeper angle than every corner of the chain before it. That includes the facet's own near corner, so
facets seen from behind come out dark. An antenna that stands a little beside the plane is taken to stand in it.
"""

from __future__ import annotations

from dataclasses import replace

import numpy as np
from numpy.typing import NDArray

from ..mesh.polar import FAR_FRACTION, NEAR_FRACTION, Facets, Profile, SurfaceMesh, profile


def trace_horizon(mesh: SurfaceMesh) -> Facets:
    """The mesh's facets with `lit` (antenna, column, facet)."""
    facets = mesh.facets
    lit = np.empty((mesh.grid.places.shape[1], *facets.height.shape), dtype=bool)
    planes = (
        (profile(mesh.elevation, mesh.grid, NEAR_FRACTION), slice(0, None, 2), 0),
        (profile(mesh.elevation, mesh.grid, FAR_FRACTION), slice(1, None, 2), 1),
    )
    for antenna in range(lit.shape[0]):
        along, above = mesh.grid.places[:, antenna, 0], mesh.grid.places[:, antenna, 2]
        # The same for all columns of a boat at rest, and then much is reckoned once.
        along = along[:1] if np.ptp(along) == 0.0 else along[:, None]
        height = mesh.grid.column_height + above[:, None]
        for plane, members, corner in planes:
            horizon = _horizon(plane, along, height)
            slope = _tangent(facets.distance[members], facets.height[:, members], along, height)
            # Corners alternate rung, diagonal, rung …: the last one before a near facet is its rung, before a far
            # facet its diagonal.
            lit[antenna, :, members] = slope > horizon[:, corner::2][:, : slope.shape[1]]
    return replace(facets, lit=lit)


class Skyline:
    """What the sea hides of things that stand in it or beyond it: the horizon along the line nearest to each."""

    def __init__(self, mesh: SurfaceMesh) -> None:
        self._grid, self._elevation = mesh.grid, mesh.elevation

    def sees(self, eyes: NDArray[np.float64], places: NDArray[np.float64]) -> NDArray[np.bool_]:
        """(n,) whether eyes (n, 3) near the mast see places (n, 3) of the world over the crests.

        False beside the mesh, where no beam looks.
        """
        grid = self._grid
        away = places[:, :2] - eyes[:, :2]
        distance = np.maximum(np.hypot(*away.T), 1e-9)
        azimuth = np.degrees(np.arctan2(away[:, 0], away[:, 1]))
        # Of a turn that overlaps its own start, the line within the turn; of a sector, those before its start too.
        number = np.rint((azimuth - grid.azimuth[0] + grid.sweep[0]) % 360.0 / grid.spacing_deg).astype(np.intp)
        line = np.where(number - grid.first < grid.sweep.size, number, number - grid.per_circle) - grid.first
        known = line >= 0
        tangent = (self._elevation[np.where(known, line, 0)] - eyes[:, 2:]) / grid.ground_range
        nearer = grid.ground_range < distance[:, None]
        highest = np.where(nearer, tangent, -np.inf).max(axis=1)
        return known & ((places[:, 2] - eyes[:, 2]) / distance > highest)


def _tangent(
    distance: NDArray[np.float64],
    height: NDArray[np.float64],
    along: NDArray[np.float64],
    above: NDArray[np.float64],
) -> NDArray[np.float64]:
    """Tangent of the elevation angle (…) under which the antenna sees points; −inf for what is not in front of it."""
    reach = distance - along
    with np.errstate(divide="ignore", invalid="ignore"):
        return np.where(reach > 0.0, (height - above) / reach, -np.inf)


def _horizon(plane: Profile, along: NDArray[np.float64], above: NDArray[np.float64]) -> NDArray[np.float64]:
    """Running maximum (column, corner) of the corners' tangents, outward."""
    rungs = plane.rung_distance.size
    tangents = np.empty((plane.rung_height.shape[0], 2 * rungs - 1))
    tangents[:, 0::2] = _tangent(plane.rung_distance, plane.rung_height, along, above)
    tangents[:, 1::2] = _tangent(plane.diagonal_distance, plane.diagonal_height, along, above)
    return np.maximum.accumulate(tangents, axis=1, out=tangents)
