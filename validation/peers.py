"""The ray stage beside its peers on the same triangles: Sionna's PathSolver as shipped, trimesh's engines, raw Mitsuba.

    python validation/peers.py [--quick] [--repeat 7] [--samples 30000000] [--out validation/figures]

One turn of `choppy_sea`, meshed as by default; all engines in one run, interleaved, medians of wall seconds. Shown:

1. Power. PathSolver launches its rays over the whole sphere. How many does it need until the echo power of a Lambertian
   sea has 10 % error (rms) in cells of 3 m and 1.8° at 200 m that are more than half lit, and how many for the error
   that the tracers have? And how many seconds are that, beside tracers `facets` and `horizon` with the sum of the radar
   equation over what they light: the power in every cell of the turn at one antenna. Errors are against 64 points a
   facet, each with a shadow ray of its own, and so are those of the tracers' one point a facet. PathSolver's seconds
   are without the scene's tree; those of `facets` without it (its ray stage) and with it.
2. Rays a second, and by how many answers engines differ: the package's rays asked of the package, of Mitsuba's
   `ray_test` with all arrays on the device (the floor), of Embree by trimesh (`pip install embreex`), of trimesh's own
   engine on a few rays of a narrow sector (`pip install rtree`); and the horizon in float64.
3. The tree (BVH): the package's update beside a bare Mitsuba scene of all triangles.
"""

from __future__ import annotations

import argparse
import importlib
import importlib.util
import resource
import statistics
import time
from collections.abc import Callable
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any

import numpy as np
import trimesh
from matplotlib.axes import Axes
from numpy.typing import NDArray
from paths import beside_an_edge

import seamap_rt as sr
from seamap_rt.conventions import SPEED_OF_LIGHT
from seamap_rt.mesh import Facets, SurfaceMesh
from seamap_rt.report.style import (
    BLACK,
    BLUE,
    GREEN,
    GREY,
    ORANGE,
    SKY,
    VERMILION,
    graph,
    new_figure,
    place,
    png,
    styled,
)
from seamap_rt.simulation import Simulator
from seamap_rt.tracing import tracer
from seamap_rt.tracing.bounces import Body, lambertian_power
from seamap_rt.tracing.horizon import trace_horizon
from seamap_rt.tracing.paths import antenna_places, sea_scene
from seamap_rt.tracing.rays import RayTracer, SeaScene, what_can_be_hit
from seamap_rt.tracing.shadow_rays import ShadowRays, shadow_rays

Array = NDArray[np.float64]
FIGURES = Path(__file__).parent / "figures"
CELL_M, CELL_DEG = 3.0, 1.8
RINGS_M = {50: BLACK, 100: BLUE, 200: VERMILION, 300: ORANGE}  # middles of rings of cells, ± 15 m, and their colours
RING_M, HALF_RING_M = 200, 15.0
ASKED = 0.10
FASTER, OF_FLOOR = 100.0, 0.8  # what is claimed
STOP_SHORT_M = 0.02  # of the ground before a point within a facet: float32 errs by far less
RTREE_DEG, RTREE_RAYS = 6.0, 100
ONCE_FROM = 2_000_000  # rays of PathSolver, whose seconds are then long enough
STANCES = "stance", "column_stance"
FLOOR, PACKAGE = "mitsuba ray_test, all triangles", "package: facets' ray stage"


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
    return Case(simulator, mesh, mesh.sheets()[0], simulator.radar.frequency_hz)


def one_antenna(case: Case) -> Case:
    """The case with its first antenna alone."""
    grid = case.mesh.grid
    stances = {name: replace(getattr(grid, name), places=getattr(grid, name).places[:, :1]) for name in STANCES}
    alone = replace(case.mesh, grid=replace(grid, drift=grid.drift[:, :1], **stances))
    _ = alone.facets  # now: what the mesh costs is no part of the comparison
    return replace(case, mesh=alone)


def seconds(work: Callable[[], Any]) -> float:
    """Of wall, with all that the device still has to do."""
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


# ------------------------------------------------------------------------------------------------------- power


class Cells:
    """Cells of the turn, 3 m × 1.8°, by the slant range of a facet's point and by its column."""

    def __init__(self, case: Case) -> None:
        facets, columns, grid = case.facets, case.columns, case.mesh.grid
        lit = np.ones((1, *facets.height.shape), dtype=bool)
        slant, _ = lambertian_power(replace(facets, lit=lit), columns, 0, case.frequency_hz)
        self.ranges = int(case.simulator.radar.range_m[1] / CELL_M)
        sweep = np.floor((grid.column_sweep[columns] - grid.column_sweep[columns.start]) / CELL_DEG + 1e-6)
        gate = np.minimum(slant / CELL_M, self.ranges).astype(np.int64)  # the last one takes what lies beyond
        self.of_facet = sweep.astype(np.int64)[:, None] * (self.ranges + 1) + gate
        self.count = (int(sweep[-1]) + 1) * (self.ranges + 1)
        self.middle = CELL_M * (np.arange(self.count) % (self.ranges + 1) + 0.5)
        self.area = self.sum(np.broadcast_to(facets.horizontal_area, slant.shape))

    def sum(self, values: Array) -> Array:
        """(cell,) of values (column, facet)."""
        return np.bincount(self.of_facet.ravel(), values.ravel(), self.count).astype(np.float64, copy=False)

    def ring(self, middle: float) -> NDArray[np.bool_]:
        """(cell,)"""
        return np.abs(self.middle - middle) < HALF_RING_M


@dataclass(frozen=True)
class Sample:
    """What PathSolver found with so many rays."""

    rays: int
    seconds: float
    power: Array  # (cell,)
    paths: Array  # (cell,)


def path_solver(case: Case, cells: Cells, samples: list[int], repeat: int) -> list[Sample]:
    """PathSolver as shipped, from one antenna back to itself, one diffuse bounce off the whole turn's mesh."""
    scene = sea_scene(case.mesh, case.sheet, case.frequency_hz, **Body().properties(case.frequency_hz))
    rt: Any = importlib.import_module("sionna.rt")
    antenna = antenna_places(case.mesh.grid)[case.columns.start, 0].tolist()
    scene.add(rt.Transmitter("transmitter", position=antenna))
    scene.add(rt.Receiver("receiver", position=antenna))
    solver, of_facet = rt.PathSolver(), cells.of_facet.ravel()

    def solve(rays: int) -> Sample:
        start = time.perf_counter()
        found = solver(
            scene,
            max_depth=1,
            max_num_paths_per_src=int(0.6 * rays),  # those that leave upward meet nothing
            samples_per_src=rays,
            los=False,
            specular_reflection=False,
            diffuse_reflection=True,
            refraction=False,
        )
        real, imaginary = (np.array(part).ravel() for part in found.a)
        spent = time.perf_counter() - start
        valid = np.array(found.valid, dtype=bool).ravel()
        cell = of_facet[np.array(found.primitives).ravel()[valid]]
        power = np.square(real[valid], dtype=np.float64) + np.square(imaginary[valid], dtype=np.float64)
        paths = np.bincount(cell, minlength=cells.count).astype(np.float64)
        total = np.bincount(cell, power, cells.count).astype(np.float64, copy=False)
        return Sample(rays, spent, total, paths)

    solve(samples[0])  # compiles
    every = []
    for rays in samples:
        again = [solve(rays) for _ in range(repeat if rays < ONCE_FROM else 1)]
        every.append(replace(again[0], seconds=statistics.median(each.seconds for each in again)))
    return every


def finely(case: Case, cells: Cells, ring: NDArray[np.bool_], cut: int) -> Array:
    """Power (cell,) in a ring of cells by cut² points a facet, each with a ray of its own through all triangles."""
    place = antenna_places(case.mesh.grid)[case.columns.start, 0]
    vertices, faces = case.mesh.triangles(case.sheet)
    chosen = np.flatnonzero(ring[cells.of_facet.ravel()])
    corners = vertices[faces[chosen]] - place
    normal = np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0])
    front = np.einsum("fi,fi->f", normal, corners[:, 0]) < 0.0
    chosen, corners, normal = chosen[front], corners[front], normal[front]
    floor, total = Floor(vertices, faces), np.zeros(len(chosen))
    area = 0.5 * np.linalg.norm(normal, axis=1)
    wavelength = SPEED_OF_LIGHT / case.frequency_hz
    for weights in _middles(cut):
        points = np.einsum("c,fci->fi", weights, corners)
        slant = np.linalg.norm(points, axis=1)
        stop = slant * (1.0 - STOP_SHORT_M / np.hypot(points[:, 0], points[:, 1]))
        lit = ~np.array(floor.test(floor.rays(place, (points / slant[:, None]).T, stop)))
        cosine = -np.einsum("fi,fi->f", normal, points) / (2.0 * area * slant)
        total += lit * 4.0 * cosine**2 / slant**4
    power = wavelength**2 * area * total / ((4.0 * np.pi) ** 3 * cut**2)
    return np.bincount(cells.of_facet.ravel()[chosen], power, cells.count).astype(np.float64, copy=False)


def _middles(cut: int) -> Array:
    """Barycentric weights (cut², 3) of the middles of a triangle's equal parts."""
    first, second = np.meshgrid(np.arange(cut), np.arange(cut), indexing="ij")
    upright = np.stack((first, second), axis=-1)[first + second < cut] + 1.0 / 3.0
    turned = np.stack((first, second), axis=-1)[first + second < cut - 1] + 2.0 / 3.0
    both = np.concatenate((upright, turned)) / cut
    return np.column_stack((1.0 - both.sum(axis=1), both))


@dataclass(frozen=True)
class Power:
    """Errors of a ring's cells, more than half lit, and who needs how many seconds for the whole turn."""

    samples: list[Sample]
    error: dict[int, Array]  # by ring, (sample,)
    loose: dict[int, Array]  # by ring, (sample,): of as many independent rays as there were paths in the cells
    against_sum: Array  # (sample,) in the ring, against the sum over lit facets instead of the fine one
    bias: float  # of the largest sample's power in all the ring, over the fine one
    tracers: dict[str, tuple[float, float]]  # error in the ring, and seconds
    kept: tuple[int, int]  # cells that count in the ring, and all


def rms(values: Array) -> float:
    return float(np.sqrt(np.mean(values**2)))


def tracers_of(case: Case, cells: Cells) -> dict[str, Callable[[], Array]]:
    """The package's ways to the power of every cell."""
    radar, water = case.simulator.radar, case.simulator.scene.scattering
    sheet, facets, horizon = OneSheet(case), tracer("facets", radar, water), tracer("horizon", radar, water)

    def power(lit: NDArray[np.bool_] | None) -> Array:
        assert lit is not None
        return cells.sum(lambertian_power(replace(case.facets, lit=lit), case.columns, 0, case.frequency_hz)[1])

    def stage() -> Array:
        lit = np.zeros((1, *case.facets.height.shape), dtype=bool)
        lit[:, case.columns] = sheet.stage()
        return power(lit)

    return {
        "facets' ray stage": stage,
        "facets, tree and rays": lambda: power(facets(case.mesh).lit),
        "horizon": lambda: power(horizon(case.mesh).lit),
    }


def compare_power(case: Case, samples: list[int], repeat: int, cut: int) -> Power:
    cells = Cells(case)
    works = tracers_of(case, cells)
    taken, sums = interleaved(works, repeat), {name: work() for name, work in works.items()}
    found = path_solver(case, cells, samples, min(repeat, 3))
    lit = trace_horizon(case.mesh).lit
    assert lit is not None
    share = cells.sum(lit[0, case.columns] * case.facets.horizontal_area) / np.maximum(cells.area, 1e-9)
    fine = finely(case, cells, np.any([cells.ring(middle) for middle in RINGS_M], axis=0), cut)
    rings = {middle: cells.ring(middle) & (share > 0.5) for middle in RINGS_M}

    def error(power: Array, middle: int = RING_M) -> float:
        return rms(power[rings[middle]] / fine[rings[middle]] - 1.0)

    def loose(each: Sample, middle: int) -> float:
        return float(1.0 / np.sqrt(found[-1].paths[rings[middle]].mean() / found[-1].rays * each.rays))

    at, ring = rings[RING_M], cells.ring(RING_M)
    return Power(
        found,
        {middle: np.array([error(each.power, middle) for each in found]) for middle in RINGS_M},
        {middle: np.array([loose(each, middle) for each in found]) for middle in RINGS_M},
        np.array([rms(each.power[at] / sums["horizon"][at] - 1.0) for each in found]),
        float(found[-1].power[ring].sum() / fine[ring].sum() - 1.0),
        {name: (error(sums[name]), statistics.median(taken[name])) for name in works},
        (int(at.sum()), int(ring.sum())),
    )


def slope_of(power: Power) -> float:
    """By which power of the number of rays PathSolver's error falls, over its last three samples."""
    rays, error = [each.rays for each in power.samples[-3:]], power.error[RING_M][-3:]
    return float(np.polyfit(np.log(rays), np.log(error), 1)[0])


def rays_needed(power: Power, error: float, slope: float | None = None) -> float:
    """Of PathSolver for an error in the ring, between its samples; beyond the last, or if a slope is given, by that."""
    rays, errors = np.log([each.rays for each in power.samples]), np.log(power.error[RING_M])
    if slope is None and np.log(error) >= errors[-1]:
        return float(np.exp(np.interp(-np.log(error), -errors, rays)))
    return float(np.exp(rays[-1] + (np.log(error) - errors[-1]) / (slope or slope_of(power))))


def seconds_of(power: Power, rays: float) -> float:
    """Of PathSolver: between its samples, and beyond the last one in proportion."""
    last = power.samples[-1]
    if rays > last.rays:
        return last.seconds * rays / last.rays
    return float(np.interp(rays, [each.rays for each in power.samples], [each.seconds for each in power.samples]))


# -------------------------------------------------------------------------------------------------------- rays


class Floor:
    """Mitsuba without this package: a bare scene of triangles, and rays whose arrays the device already has."""

    def __init__(self, vertices: Array, faces: NDArray[np.int32]) -> None:
        self._mi: Any = importlib.import_module("mitsuba")
        self._dr: Any = importlib.import_module("drjit")
        mi = self._mi
        self._shape = mi.Mesh("sea", len(vertices), len(faces), has_vertex_normals=False, has_vertex_texcoords=False)
        parameters = mi.traverse(self._shape)
        parameters["vertex_positions"] = mi.Float(vertices.astype(np.float32).ravel())
        parameters["faces"] = mi.UInt32(faces.astype(np.uint32).ravel())
        parameters.update()
        self.scene = self.build()

    def build(self) -> Any:
        """Mitsuba's scene, and so its tree, anew."""
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
        water = RayTracer(case.simulator.radar, case.simulator.scene.scattering).permittivity
        self.rays = self.make()
        triangles = what_can_be_hit(case.mesh, case.sheet, self.rays.turned_away)
        self.scene = SeaScene(case.mesh, case.sheet, case.frequency_hz, water, triangles)

    def make(self) -> ShadowRays:
        return shadow_rays(self.case.mesh, self.case.facets, self.case.sheet)

    def stage(self) -> NDArray[np.bool_]:
        """(antenna, column, facet) light: rays made, traced, and their answers scattered back."""
        rays = self.make()
        return rays.lit(self.scene.hits(rays))

    def tree(self) -> None:
        """What can be hit, and the scene's tree of it."""
        if not self.scene.update(what_can_be_hit(self.case.mesh, self.case.sheet, self.rays.turned_away)):
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


@dataclass(frozen=True)
class Engine:
    """One way to answer the package's rays, and how to read its answer as (antenna, column, facet) light."""

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
        Engine("  in the package's scene", lambda: floor.test(on_device, sheet.scene.scene.mi_scene), free, count),
        Engine(PACKAGE, sheet.stage, lambda lit: lit, count),
        Engine("package: horizon, float64", lambda: trace_horizon(case.mesh).lit, whole, count),
    ]


def slow_engines(sheet: OneSheet) -> list[Engine]:
    """PathSolver's line of sight, and Embree, by trimesh and as bare as Python gets at it."""
    case, rays, own = sheet.case, sheet.rays, sheet.own()
    paths = tracer("paths", case.simulator.radar, case.simulator.scene.scattering)
    every = case.facets.height.size * len(rays.front)
    engines = [Engine("Sionna, line of sight", lambda: paths(case.mesh).lit, lambda lit: lit[:, case.columns], every)]
    if importlib.util.find_spec("embreex") is None:
        print("no embreex here: `pip install embreex` to see Embree by trimesh")
        return engines
    embree: Any = importlib.import_module("trimesh.ray.ray_pyembree")
    mesh = trimesh.Trimesh(*case.mesh.triangles(case.sheet), process=False, validate=False)
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
    """trimesh's own engine, on few rays and the few columns that they stay in: it is there for other work."""
    if importlib.util.find_spec("rtree") is None:
        print("no rtree here: `pip install rtree` to see trimesh's own engine")
        return []
    engine: Any = importlib.import_module("trimesh.ray.ray_triangle")
    case, rays = sheet.case, sheet.rays
    columns = int(RTREE_DEG / case.mesh.grid.spacing_deg)
    sector = (slice(case.columns.start, case.columns.start + columns),)
    mesh = trimesh.Trimesh(*case.mesh.triangles(sector), process=False, validate=False)
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
    sheet, floor = OneSheet(case), Floor(*case.mesh.triangles(case.sheet))
    rays, hit = sheet.rays, sheet.scene.hits(sheet.rays)
    engines, slow = device_engines(sheet, floor), slow_engines(sheet)
    steps = {
        "rays made": sheet.make,
        "hits, arrays to the device and back": lambda: sheet.scene.hits(rays),
        "light scattered back": lambda: rays.lit(hit),
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


# ---------------------------------------------------------------------------------------------------- the report


def yes(held: bool) -> str:
    return "yes" if held else "NO"


def print_power(power: Power, turn: float) -> None:
    kept, every = power.kept
    print(f"\nEcho power of a Lambertian sea in cells of {CELL_M:g} m × {CELL_DEG:g}° at {RING_M} m, at one antenna;")
    print(f"rms error of the {kept} of {every} cells that are more than half lit; PathSolver as shipped")
    print(f"{'rays':>10} {'s':>8} {'paths a cell':>13} {'error':>8} {'1/√paths':>9} {'against lit facets':>19}")
    for each, error, loose, other in zip(
        power.samples, power.error[RING_M], power.loose[RING_M], power.against_sum, strict=True
    ):
        row = f"{each.rays:10.2g} {each.seconds:8.2f} {loose**-2:13.3g} {error:8.1%} {loose:9.1%} {other:19.1%}"
        print(row, flush=True)
    print(f"all power of the ring by the most rays: {power.bias:+.2%} of the points' sum")
    print(f"the last errors fall as rays^{slope_of(power):.2f}: its lattice is better than loose rays (−0.50)")
    for name, (error, spent) in power.tracers.items():
        asked, own = (seconds_of(power, rays_needed(power, aim)) / spent for aim in (ASKED, error))
        by_root = seconds_of(power, rays_needed(power, ASKED, slope=-0.5)) / spent
        print(
            f"{name:22} {error:6.1%} error, {spent:.4f} s: PathSolver takes {asked:.0f} × for {ASKED:.0%} (by 1/√N from"
        )
        print(f"{'':22} the last {by_root:.0f} ×), {own:.0f} × for the same error; ≥ {FASTER:g} ×: "
              f"{yes(asked >= FASTER)}, {yes(own >= FASTER)}")  # fmt: skip
    rays = rays_needed(power, ASKED)
    known = "measured" if rays <= power.samples[-1].rays else "extrapolated"
    print(f"{ASKED:.0%} takes {rays:.2g} rays and {seconds_of(power, rays):.1f} s ({known})")
    print(f"a whole turn of pulses, light and echoes of both antennas, takes {turn:.2f} s")


def print_rays(rays: Rays) -> None:
    print(f"\n{'engine':34} {'rays':>9} {'s':>9} {'million/s':>10} {'of floor':>9} {'differ':>9} {'off an edge':>12}")
    for row in rays.rows:
        off = f"{row.off_edge:d}" if row.off_edge >= 0 else "–"
        print(
            f"{row.name:34} {row.rays:9d} {row.seconds:9.4f} {1e-6 * row.rays / row.seconds:10.3g} "
            f"{row.of_floor:9.3g} {row.differ:9.1e} {off:>12}"
        )
    print("of the package's stage:", ", ".join(f"{name} {spent:.4f} s" for name, spent in rays.steps.items()))
    print(
        f"the stage runs at {rays.of_own_floor:.2f} of ray_test's speed in the same scene "
        f"(≥ {OF_FLOOR:g}: {yes(rays.of_own_floor >= OF_FLOOR)}), "
        f"at {rays.of_floor:.2f} of that with all triangles and Mitsuba's usual tests, which may leak at edges "
        f"(≥ {OF_FLOOR:g}: {yes(rays.of_floor >= OF_FLOOR)})"
    )
    package, bare, times = rays.trees
    print(f"tree: package {package:.3f} s, bare scene of all triangles {bare:.3f} s, {times:.2f} × as long")


@styled
def draw(power: Power, rays: Rays, path: Path) -> None:
    figure = new_figure(3.3)
    _draw_error(place(figure, 0.55, 0.3, 1.85, 2.4), power)
    _draw_seconds(place(figure, 2.8, 0.3, 1.75, 2.4), power)
    _draw_rates(place(figure, 6.05, 0.3, 1.05, 2.4), rays)
    path.parent.mkdir(parents=True, exist_ok=True)
    path.write_bytes(png(figure))
    print(f"\n{path}")


def _draw_error(axes: Axes, power: Power) -> None:
    graph(axes, "rays over the sphere", "rms error of a cell's power, %", "a) PathSolver as shipped")
    count = [each.rays for each in power.samples]
    for middle, colour in RINGS_M.items():
        axes.loglog(count, 100.0 * power.error[middle], "o-", color=colour, markersize=2.5, label=f"{middle} m")
        axes.loglog(count, 100.0 * power.loose[middle], ":", color=colour, linewidth=0.8)
    axes.axhline(100.0 * ASKED, color=GREY, linewidth=0.8)
    axes.plot([], [], ":", color=GREY, linewidth=0.8, label="1/√paths")
    axes.legend(fontsize=6, loc="lower left", handlelength=1.5)


def _draw_seconds(axes: Axes, power: Power) -> None:
    graph(axes, "seconds for all cells of the turn", "", f"b) at {RING_M} m")
    spent, error = np.array([each.seconds for each in power.samples]), 100.0 * power.error[RING_M]
    axes.loglog(spent, error, "o-", color=VERMILION, markersize=2.5, label="PathSolver")
    least = min(error for error, _ in power.tracers.values())
    at = seconds_of(power, rays_needed(power, least))
    axes.loglog([spent[-1], at], [error[-1], 100.0 * least], "--", color=VERMILION, linewidth=0.8)
    for n, ((name, (miss, takes)), colour) in enumerate(zip(power.tracers.items(), (SKY, BLUE, GREEN), strict=True)):
        axes.loglog(takes, 100.0 * miss, "s", color=colour, markersize=4, label=name)
        times = f"{seconds_of(power, rays_needed(power, miss)) / takes:.0f} ×"
        axes.annotate(times, (takes, 100.0 * miss), (-4, 13 if n == 0 else 5), textcoords="offset points", fontsize=6)
    axes.axhline(100.0 * ASKED, color=GREY, linewidth=0.8)
    axes.set_ylim(bottom=60.0 * least)
    axes.legend(loc="center left", fontsize=5.5)


def _draw_rates(axes: Axes, rays: Rays) -> None:
    graph(axes, "million/s", "", "c) shadow rays")
    names = [row.name.strip() for row in rays.rows]
    rates = [1e-6 * row.rays / row.seconds for row in rays.rows]
    colours = [GREY if "ray_test" in row.name or row.name.startswith(" ") else SKY for row in rays.rows]
    axes.barh(range(len(rates)), rates, color=colours, height=0.7)
    axes.set_xscale("log")
    axes.set_yticks(range(len(names)), names, fontsize=5.5)
    axes.invert_yaxis()


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--quick", action="store_true", help="fewer rays and rounds")
    parser.add_argument("--repeat", type=int, help="rounds of which medians are taken (7; quick: 3)")
    parser.add_argument("--samples", type=int, help="most rays of PathSolver (30 million; quick: 3 million)")
    parser.add_argument("--out", type=Path, default=FIGURES, help="folder of the figure")
    parser.add_argument("--set", action="append", default=[], metavar="KEY=VALUE", help="any key of the scene")
    arguments = parser.parse_args()
    quick = arguments.quick
    repeat = arguments.repeat or (3 if quick else 7)
    most = arguments.samples or (3_000_000 if quick else 30_000_000)
    samples = [10**n * m for n in range(3, 10) for m in (1, 3) if 10**n * m <= most][-3 if quick else -5 :]

    made = case(dict(pair.split("=", 1) for pair in arguments.set))
    grid = made.facets.grid
    rays = compare_rays(made, repeat)
    variant = importlib.import_module("mitsuba").variant()
    print(f"choppy_sea, {grid.columns} columns × {made.facets.distance.size} facets; Dr.Jit runs {variant}")
    print_rays(rays)
    power = compare_power(one_antenna(made), samples, repeat, cut=4 if quick else 8)
    turns = [made.simulator.turn(number).timing for number in range(2 if quick else 4)][1:]
    print_power(power, statistics.median(timing["trace"] + timing["echoes"] for timing in turns))
    print(f"peak memory {resource.getrusage(resource.RUSAGE_SELF).ru_maxrss / 2**20:.1f} GiB")
    draw(power, rays, arguments.out / "peers.png")


if __name__ == "__main__":
    main()
