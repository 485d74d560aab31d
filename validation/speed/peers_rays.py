"""Rays a second and answers of the package, of raw Mitsuba, of Sionna's line of sight and of Embree: see `peers.py`."""

from __future__ import annotations

import importlib
import importlib.util
import statistics
import time
from collections.abc import Callable
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from seamap_rt.mesh.facets import FAR_FRACTION, NEAR_FRACTION
from seamap_rt.tracing import tracer
from seamap_rt.tracing.horizon import trace_horizon

from ..hard_cases.light import beside_an_edge
from ..light.profile import profile
from .peers_turn import Case, Floor, OneSheet, interleaved, ratio

RTREE_DEG, RTREE_RAYS = 6.0, 100
FLOOR, PACKAGE = "mitsuba ray_test, all triangles", "package: facets' ray stage"


@dataclass(frozen=True)
class Engine:
    """One engine that traces the package's rays, and how to read its result as (antenna, column, facet) light."""

    name: str
    work: Callable[[], Any]
    light: Callable[[Any], NDArray[np.bool_]]
    rays: int


@dataclass(frozen=True)
class Row:
    """An engine's line of the table; shares and counts are of rays that it answers otherwise than the package."""

    name: str
    rays: int
    seconds: float
    of_floor: float  # its speed, ray by ray, over the floor's
    differ: float
    off_edge: int  # of them further than one facet from a shadow's edge


def numpy_march(case: Case) -> NDArray[np.bool_]:
    """(antenna, column, facet) light by plain NumPy: all profiles of the mesh are marched outward side by side, and a
    facet is lit that stands steeper than all before it, as by the package's horizon."""
    grid, facets = case.mesh.grid, case.facets
    lit = np.zeros((grid.antenna_positions.shape[1], *facets.height.shape), dtype=bool)
    for first, fraction in enumerate((NEAR_FRACTION, FAR_FRACTION)):
        plane = profile(case.mesh.elevation, grid, fraction)
        for antenna in range(len(lit)):
            along = grid.antenna_positions[:, antenna, 0]
            above = grid.column_height[:, 0] + grid.antenna_positions[:, antenna, 2]
            highest = np.full(grid.columns, -np.inf)
            for rung in range(plane.diagonal_distance.size):
                corner = (plane.rung_height[:, rung] - above) / (plane.rung_distance[rung] - along)
                diagonal = (plane.diagonal_height[:, rung] - above) / (plane.diagonal_distance[rung] - along)
                highest = np.maximum(highest, corner)
                beyond, facet = np.maximum(highest, diagonal), 2 * rung + first
                own = (facets.height[:, facet] - above) / (facets.distance[facet] - along)
                lit[antenna, :, facet] = own > (beyond if first else highest)
                highest = beyond
    return lit


def device_engines(sheet: OneSheet, floor: Floor) -> list[Engine]:
    """The package, the floor and the horizon."""
    case, rays = sheet.case, sheet.rays
    on_device = floor.rays(rays.starts[rays.start].T, rays.direction, rays.length)
    count = rays.length.size

    def free(hit: Any) -> NDArray[np.bool_]:
        return sheet.light(~np.array(hit))

    def whole(lit: NDArray[np.bool_]) -> NDArray[np.bool_]:
        return lit[:, case.columns]

    return [
        Engine(FLOOR, lambda: floor.test(on_device), free, count),
        Engine("  in the package's scene", lambda: floor.test(on_device, sheet.scene.mi_scene), free, count),
        Engine(PACKAGE, sheet.stage, lambda lit: lit, count),
        Engine("package: horizon, float64", lambda: trace_horizon(case.mesh).lit, whole, count),
        Engine("NumPy, marching outward", lambda: numpy_march(case), whole, count),
    ]


def slow_engines(sheet: OneSheet) -> list[Engine]:
    """PathSolver's line of sight, and Embree where it is installed, by trimesh and called directly."""
    case, rays, own = sheet.case, sheet.rays, sheet.own()
    paths = tracer("paths", case.simulator.installation.radar, case.simulator.scene.scattering)
    every = case.facets.height.size * len(rays.front)
    engines = [Engine("Sionna, line of sight", lambda: paths(case.mesh).lit, lambda lit: lit[:, case.columns], every)]
    if importlib.util.find_spec("embreex") is None:
        return engines
    embree: Any = importlib.import_module("trimesh.ray.ray_pyembree")
    mesh = case.mesh.trimesh(case.sheet)
    intersector, starts = embree.RayMeshIntersector(mesh), rays.starts[rays.start]
    directions, wrap = np.ascontiguousarray(rays.direction.T), intersector._scene
    scaled = ((starts - wrap.origin) * wrap.scale).astype(np.float32)
    ends = (rays.length * wrap.scale).astype(np.float32)
    return [
        *engines,
        Engine(
            "trimesh with embreex, first hit",
            lambda: intersector.intersects_first(starts, directions),
            lambda first: sheet.light(first == own),
            rays.length.size,
        ),
        Engine(
            "embreex alone, occlusion",
            lambda: wrap.scene.run(scaled, directions, dists=ends.copy(), query="OCCLUDED"),
            lambda first: sheet.light(first == -1),
            rays.length.size,
        ),
    ]


def trimesh_alone(sheet: OneSheet, package: NDArray[np.bool_], floor_seconds: float) -> list[Row]:
    """trimesh's own engine, on few rays and the few columns that they stay in; none without its rtree."""
    if importlib.util.find_spec("rtree") is None:
        return []
    engine: Any = importlib.import_module("trimesh.ray.ray_triangle")
    case, rays = sheet.case, sheet.rays
    columns = int(RTREE_DEG / case.mesh.grid.spacing_deg)
    sector = (slice(case.columns.start, case.columns.start + columns),)
    mesh = case.mesh.trimesh(sector)
    chosen = np.random.default_rng(1).choice(rays.first[columns], RTREE_RAYS, replace=False)
    intersector = engine.RayMeshIntersector(mesh)
    intersector.intersects_first(rays.starts[rays.start[chosen[:2]]], rays.direction.T[chosen[:2]])  # builds its tree
    start = time.perf_counter()
    first = intersector.intersects_first(rays.starts[rays.start[chosen]], rays.direction.T[chosen])
    spent = time.perf_counter() - start
    differ = (first == sheet.own()[chosen]) != sheet.of_rays(package)[chosen]
    speed = RTREE_RAYS / spent * floor_seconds / rays.length.size
    return [Row(f"trimesh alone, {RTREE_DEG:g}° of it", RTREE_RAYS, spent, speed, float(differ.mean()), -1)]


@dataclass(frozen=True)
class Rays:
    """What the table of rays holds."""

    rows: list[Row]
    steps: dict[str, float]  # s, of the package's stage
    of_floor: float  # the stage's speed over the floor's: triangles all, and not watertight
    of_own_floor: float  # over ray_test's in the package's own scene
    trees: tuple[float, float, float]  # s of the package's and of the bare one, and the bare one's over the package's


def compare_rays(case: Case, repeat: int) -> Rays:
    sheet, floor = OneSheet(case), Floor(case.mesh.trimesh(case.sheet))
    rays, hit = sheet.rays, sheet.scene.hits(sheet.rays)
    engines, slow = device_engines(sheet, floor), slow_engines(sheet)
    steps = {
        "rays made": sheet.make,
        "hits, arrays to the device and back": lambda: sheet.scene.hits(rays),
        "light scattered back": lambda: rays.lit_facets(hit),
    }
    trees = {"package": sheet.tree, "bare": floor.build}
    works = {each.name: each.work for each in engines} | steps | trees
    taken = interleaved(works, repeat) | interleaved({each.name: each.work for each in slow}, min(repeat, 2))
    package = sheet.stage()
    per_ray = statistics.median(taken[FLOOR]) / rays.length.size
    rows = []
    for each in (*engines, *slow):
        spent, light = statistics.median(taken[each.name]), each.light(each.work())
        differ = light != package
        off = differ & ~(beside_an_edge(light) | beside_an_edge(package))
        share = float(differ.sum() / rays.length.size)
        rows.append(Row(each.name, each.rays, spent, per_ray * each.rays / spent, share, int(off.sum())))
    return Rays(
        rows + trimesh_alone(sheet, package, statistics.median(taken[FLOOR])),
        {name: statistics.median(taken[name]) for name in steps},
        ratio(taken[FLOOR], taken[PACKAGE]),
        ratio(taken["  in the package's scene"], taken[PACKAGE]),
        (statistics.median(taken["package"]), statistics.median(taken["bare"]), ratio(taken["bare"], taken["package"])),
    )
