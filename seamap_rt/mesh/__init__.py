"""The sea's surface as triangles: polar, centred on the antenna, rolling with the beam."""

from .polar import Facets, PolarGrid, SurfaceMesh, mesh_turn, polar_grid, surface_mesh

__all__ = ["Facets", "PolarGrid", "SurfaceMesh", "mesh_turn", "polar_grid", "surface_mesh"]
