"""Light by the running maximum of the elevation angle, exact on the triangulated surface, in float64.

Along a plane through the antenna's axis the surface is a chain of straight segments: a facet's point is lit when it is
seen under a steeper angle than every corner of the chain before it. That includes the facet's own near corner, so
facets seen from behind come out dark.
"""

from __future__ import annotations

from dataclasses import replace

import numpy as np
from numpy.typing import NDArray

from ..mesh.polar import FAR_FRACTION, NEAR_FRACTION, Facets, Profile, SurfaceMesh, profile


def trace_horizon(mesh: SurfaceMesh) -> Facets:
    """The mesh's facets with `lit` (antenna, column, facet)."""
    facets = mesh.facets
    lit = np.empty((2, *facets.height.shape), dtype=bool)
    planes = (
        (profile(mesh.elevation, mesh.grid, NEAR_FRACTION), slice(0, None, 2), 0),
        (profile(mesh.elevation, mesh.grid, FAR_FRACTION), slice(1, None, 2), 1),
    )
    for antenna, (along, above) in enumerate(mesh.antennas()):
        height = mesh.height_m + above
        for plane, members, corner in planes:
            horizon = _horizon(plane, along, height)
            slope = _tangent(facets.distance[members], facets.height[:, members], along, height)
            # Corners alternate rung, diagonal, rung …: the last one before a near facet is its rung, before a far
            # facet its diagonal.
            lit[antenna, :, members] = slope > horizon[:, corner::2][:, : slope.shape[1]]
    return replace(facets, lit=lit)


def _tangent(
    distance: NDArray[np.float64], height: NDArray[np.float64], along: float, above: float
) -> NDArray[np.float64]:
    """Tangent of the elevation angle (…) under which the antenna sees points; −inf for what is not in front of it."""
    reach = distance - along
    with np.errstate(divide="ignore", invalid="ignore"):
        return np.where(reach > 0.0, (height - above) / reach, -np.inf)


def _horizon(plane: Profile, along: float, above: float) -> NDArray[np.float64]:
    """Running maximum (column, corner) of the corners' tangents, outward."""
    rungs = plane.rung_distance.size
    tangents = np.empty((plane.rung_height.shape[0], 2 * rungs - 1))
    tangents[:, 0::2] = _tangent(plane.rung_distance, plane.rung_height, along, above)
    tangents[:, 1::2] = _tangent(plane.diagonal_distance, plane.diagonal_height, along, above)
    return np.maximum.accumulate(tangents, axis=1, out=tangents)
