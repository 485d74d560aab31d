"""Surfaces of known shape through the mesher and the tracers."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from seamap_rt.mesh import SurfaceMesh
from seamap_rt.mesh.surface import mesh_turn
from seamap_rt.scene import Scene, load_scene
from seamap_rt.tracing import Illumination, tracer

TRACERS = ("facets", "horizon")
Height = Callable[[NDArray[np.float64]], NDArray[np.float64]]


@dataclass(frozen=True)
class Rings:
    """A surface at rest whose height depends on the ground range alone."""

    height: Height

    def elevation_and_velocity(
        self, x: NDArray[np.float64], y: NDArray[np.float64], t: NDArray[np.float64]
    ) -> tuple[NDArray[np.float64], NDArray[np.float32]]:
        return self.height(np.hypot(x, y)), np.zeros((*x.shape, 3), dtype=np.float32)


def scene(name: str = "flat", **keys: Any) -> Scene:
    """A shipped scene with keys changed: `radar__height_m=3.0` for `radar.height_m`."""
    return load_scene(name, overrides={key.replace("__", "."): value for key, value in keys.items()})


def rings(height: Height, made: Scene) -> SurfaceMesh:
    """The mesh of a surface of rings."""
    return mesh_turn(Rings(height), made.radar, made.meshing, 0)


def trace(name: str, mesh: SurfaceMesh, made: Scene) -> Illumination:
    """The mesh's facets, lit by the tracer of that name."""
    return tracer(name, made.radar, made.scattering)(mesh)


def light(name: str, mesh: SurfaceMesh, made: Scene) -> NDArray[np.bool_]:
    """(antenna, column, facet): lit by the tracer of that name."""
    return trace(name, mesh, made).lit
