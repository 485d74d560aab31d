"""The turn that the ray stage and its peers trace, and how they are timed: see `peers.py`."""

from __future__ import annotations

import importlib
import statistics
import time
from collections.abc import Callable
from dataclasses import dataclass, replace
from typing import Any

import numpy as np
from numpy.typing import NDArray
from trimesh import Trimesh

import seamap_rt as sr
from seamap_rt.mesh import Facets, SurfaceMesh
from seamap_rt.simulation import Simulator
from seamap_rt.tracing.illumination import mitsuba_mesh
from seamap_rt.tracing.rays import RayTracer, SeaScene, occluding_surface
from seamap_rt.tracing.shadow_rays import ShadowRays, shadow_rays

Array = NDArray[np.float64]
POSES = "pose", "column_pose"


@dataclass(frozen=True)
class Case:
    """The scene's turn, as all engines get it: its first sheet, the whole circle."""

    simulator: Simulator
    mesh: SurfaceMesh
    sheet: tuple[slice, ...]
    frequency_hz: float

    @property
    def columns(self) -> slice:
        (columns,) = self.sheet
        return columns

    @property
    def facets(self) -> Facets:
        return self.mesh.facets


def case(changes: dict[str, str]) -> Case:
    simulator = Simulator(sr.load_scene("choppy_sea", overrides=changes))
    mesh = simulator.mesh(0)
    return Case(simulator, mesh, mesh.sheets()[0], simulator.installation.radar.frequency_hz)


def one_antenna(case: Case) -> Case:
    """The case with its first antenna alone."""
    grid = case.mesh.grid
    poses = {name: replace(getattr(grid, name), offsets=getattr(grid, name).offsets[:, :1]) for name in POSES}
    alone = replace(case.mesh, grid=replace(grid, drift=grid.drift[:, :1], **poses))
    _ = alone.facets  # now: what the mesh costs is no part of the comparison
    return replace(case, mesh=alone)


def seconds(work: Callable[[], Any]) -> float:
    """Wall time, until the device has finished."""
    dr: Any = importlib.import_module("drjit")
    dr.sync_thread()
    start = time.perf_counter()
    work()
    dr.sync_thread()
    return time.perf_counter() - start


def interleaved(works: dict[str, Callable[[], Any]], repeat: int) -> dict[str, list[float]]:
    """Seconds of each, one after the other in every round, after a round that compiles."""
    taken: dict[str, list[float]] = {name: [] for name in works}
    for number in range(repeat + 1):
        for name, work in works.items():
            spent = seconds(work)
            if number:
                taken[name].append(spent)
    return taken


def ratio(one: list[float], other: list[float]) -> float:
    """Of medians of rounds that ran side by side."""
    return statistics.median(a / b for a, b in zip(one, other, strict=True))


class Floor:
    """Mitsuba alone: a bare scene of triangles, and rays whose arrays the device already has."""

    def __init__(self, surface: Trimesh) -> None:
        self._mi: Any = importlib.import_module("mitsuba")
        self._dr: Any = importlib.import_module("drjit")
        self._shape = mitsuba_mesh("sea", surface)
        self.scene = self.build()

    def build(self) -> Any:
        """Mitsuba's scene and its tree, rebuilt."""
        return self._mi.load_dict({"type": "scene", "sea": self._shape})

    def rays(self, starts: NDArray[Any], directions: NDArray[Any], length: NDArray[Any]) -> Any:
        """starts: (3,) or (3, ray)."""
        mi = self._mi
        if starts.ndim == 1:
            start = mi.Point3f(*map(float, starts))
        else:
            start = mi.Point3f(*(mi.Float(axis.astype(np.float32)) for axis in starts))
        direction = mi.Vector3f(*(mi.Float(axis.astype(np.float32)) for axis in directions))
        ray = mi.Ray3f(
            o=start, d=direction, maxt=mi.Float(length.astype(np.float32)), time=mi.Float(0.0), wavelengths=[]
        )
        self._dr.make_opaque(ray)
        return ray

    def test(self, ray: Any, scene: Any = None) -> Any:
        hit = (scene or self.scene).ray_test(ray, coherent=True)
        self._dr.eval(hit)
        return hit


class OneSheet:
    """The package's ray stage on the case's sheet, step by step."""

    def __init__(self, case: Case) -> None:
        self.case = case
        water = RayTracer(case.simulator.installation.radar, case.simulator.scene.scattering).permittivity
        self.rays = self.make()
        surface = occluding_surface(case.mesh, case.sheet, self.rays)
        self.scene = SeaScene(surface, case.mesh.grid.antenna_positions[case.sheet[0].start], case.frequency_hz, water)

    def make(self) -> ShadowRays:
        return shadow_rays(self.case.mesh, self.case.facets, self.case.sheet)

    def stage(self) -> NDArray[np.bool_]:
        """(antenna, column, facet) light: rays made, traced, and their answers scattered back."""
        rays = self.make()
        return rays.lit_facets(self.scene.hits(rays))

    def tree(self) -> None:
        """What can be hit, and the scene's tree of it."""
        if not self.scene.update(occluding_surface(self.case.mesh, self.case.sheet, self.rays)):
            raise AssertionError("the scene's triangles must be replaced in place; a new scene would be timed instead")

    def of_rays(self, values: NDArray[Any]) -> NDArray[Any]:
        """Values (antenna, column, facet) of the facets that have a ray, in the rays' order."""
        return np.moveaxis(values, 0, -1)[np.moveaxis(self.rays.front, 0, -1)]

    def light(self, free: NDArray[np.bool_]) -> NDArray[np.bool_]:
        """(antenna, column, facet), from whether rays (ray,) are free."""
        lit = np.zeros(self.rays.front.shape, dtype=bool)
        np.moveaxis(lit, 0, -1)[np.moveaxis(self.rays.front, 0, -1)] = free
        return lit

    def own(self) -> NDArray[np.int64]:
        """(ray,) the triangle to whose point it goes."""
        number = np.arange(self.rays.front[0].size).reshape(self.rays.front[0].shape)
        return self.of_rays(np.broadcast_to(number, self.rays.front.shape))
