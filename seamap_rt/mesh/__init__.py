"""The sea's surface as triangles: polar, centred on the antenna, each line at the time when the beam passes it."""

from __future__ import annotations

from typing import TYPE_CHECKING

from ..lazy import lazy_attributes

if TYPE_CHECKING:
    from .facets import Facets
    from .grid import PolarGrid, polar_grid
    from .surface import SurfaceMesh, mesh_turn, surface_mesh

__all__ = ["Facets", "PolarGrid", "SurfaceMesh", "mesh_turn", "polar_grid", "surface_mesh"]

__getattr__ = lazy_attributes(
    __name__, {"facets": "Facets", "grid": "PolarGrid polar_grid", "surface": "SurfaceMesh mesh_turn surface_mesh"}
)
