"""Surfaces of known shape through the mesher and the tracers."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import numpy as np
from numpy.typing import NDArray

from seamap_rt.mesh import SurfaceMesh
from seamap_rt.mesh.surface import mesh_turn
from seamap_rt.scene import Scene
from seamap_rt.tracing import Illumination, tracer
from validation.hard_cases import case
from validation.hard_cases.case import TRACERS, light

Height = Callable[[NDArray[np.float64]], NDArray[np.float64]]
__all__ = ["TRACERS", "Height", "light", "rings", "scene", "trace"]


def scene(name: str = "flat", **keys: Any) -> Scene:
    """A shipped scene with keys changed: `radar__height_m=3.0` for `radar.height_m`."""
    return case.scene(name, **keys)


def rings(height: Height, made: Scene) -> SurfaceMesh:
    """The mesh of a surface of rings."""
    return mesh_turn(case.RadialSurface(height), made.radar, made.meshing, 0)


def trace(name: str, mesh: SurfaceMesh, made: Scene) -> Illumination:
    """The mesh's facets, lit by the tracer of that name."""
    return tracer(name, made.radar, made.scattering)(mesh)
