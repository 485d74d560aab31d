"""Points of a traced sea that no ray towards them can pass: on its vertices and edges, where rays may slip through
between two triangles, and within its facets.

All facets about a point face the antenna, so that no point lies on a silhouette that a ray may just clear.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray
from scipy.ndimage import binary_erosion

from seamap_rt.mesh import SurfaceMesh

KINDS = ("facet", "diagonal", "rung", "radial", "vertex")
_INSIDE = 0.01  # of an edge's length, from its ends: a vertex is another kind
_EDGE_ON = 1e-3  # cosine: 400 m away float32 corners are good to 15 µm, along such a facet to 15 mm


class Targets:
    """A mesh of one sheet, its corners (line, rung, 3) as float32 has them, seen from a place (3,) in its frame."""

    def __init__(self, mesh: SurfaceMesh, place: NDArray[np.float64]) -> None:
        (sheet,) = mesh.sheets()
        vertices = mesh.trimesh(sheet).vertices
        self.place = place
        self.corner = vertices.astype(np.float32).astype(np.float64).reshape(mesh.grid.sweep.size, -1, 3)
        start, across, both, out = self._quads()
        facing = self._faces(start, across, both) & self._faces(start, both, out)
        self._inner = binary_erosion(facing, np.ones((3, 3)))

    def points(self, kind: str, count: int, rng: np.random.Generator, line: int | None = None) -> NDArray[np.float64]:
        """(count, 3) points of a kind, drawn at random; on one line of the mesh, if it is given."""
        inner = self._inner.copy()
        if line is not None:
            inner[:line], inner[line + 1 :] = False, False
        i, j = rng.choice(np.argwhere(inner), count).T
        start, across, both, out = (corner[i, j] for corner in self._quads())
        s, u = rng.uniform(_INSIDE, 1.0 - _INSIDE, (2, count, 1))
        end = {"vertex": start, "radial": out, "rung": across, "diagonal": both, "facet": u * across + (1.0 - u) * both}
        return (1.0 - s) * start + s * end[kind]

    def _quads(self) -> tuple[NDArray[np.float64], ...]:
        """Corners (column, rung, 3): the near one on the first line, those across, opposite and further out."""
        c = self.corner
        return c[:-1, :-1], c[1:, :-1], c[1:, 1:], c[:-1, 1:]

    def _faces(self, a: NDArray[np.float64], b: NDArray[np.float64], c: NDArray[np.float64]) -> NDArray[np.bool_]:
        normal, towards = np.cross(b - a, c - a), self.place - a
        cosine = np.sum(normal * towards, axis=-1)
        return cosine > _EDGE_ON * np.linalg.norm(normal, axis=-1) * np.linalg.norm(towards, axis=-1)
