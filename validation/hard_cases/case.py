"""What hard cases share: a row of their table, simple surfaces, light on them, and the frame of a figure."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from typing import Any

import numpy as np
from matplotlib.figure import Figure
from numpy.typing import NDArray

import seamap_rt as sr
from seamap_rt.mesh import SurfaceMesh
from seamap_rt.report import style
from seamap_rt.scene import Scene
from seamap_rt.tracing import tracer

TRACERS = ("facets", "horizon")


@dataclass(frozen=True)
class Effort:
    """Size of the cases: rays, points, facets."""

    rays: int = 10_000_000
    full: bool = False  # with a mesh of 10⁷ facets, which takes 7 GB


@dataclass(frozen=True)
class Finding:
    """One row of the table, and what it has to show."""

    case: str
    expectation: str
    obtained: str
    right: bool | None  # None: nothing is required, a figure for the record
    figure: Figure | None = None


@dataclass(frozen=True)
class RadialSurface:
    """A surface at rest whose height depends on the ground range alone."""

    height: Callable[[NDArray[np.float64]], NDArray[np.float64]]

    def elevation_and_velocity(
        self, x: NDArray[np.float64], y: NDArray[np.float64], t: NDArray[np.float64]
    ) -> tuple[NDArray[np.float64], NDArray[np.float32]]:
        return self.height(np.hypot(x, y)), np.zeros((*x.shape, 3), dtype=np.float32)


def scene(name: str, **keys: Any) -> Scene:
    return sr.load_scene(name, {key.replace("__", "."): value for key, value in keys.items()})


def light(name: str, mesh: SurfaceMesh, made: Scene) -> NDArray[np.bool_]:
    """(antenna, column, facet)"""
    return tracer(name, made.radar, made.scattering)(mesh).lit


def graph(x_label: str, y_label: str, title: str) -> tuple[Figure, Any]:
    figure = style.new_figure(3.0)
    axes = style.place(figure, 0.9, 0.4, style.WIDTH - 1.2, 2.0)
    style.graph(axes, x_label, y_label, title)
    return figure, axes
