"""The sea's surface as triangles: polar, centred on the antenna, each line at the time when the beam passes it."""

from .facets import Facets
from .grid import PolarGrid, polar_grid
from .surface import SurfaceMesh, mesh_turn, surface_mesh

__all__ = ["Facets", "PolarGrid", "SurfaceMesh", "mesh_turn", "polar_grid", "surface_mesh"]
