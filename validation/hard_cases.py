"""Numerical stability: cases whose right answer is known, at full size. A table, figures and a page of their own.

    python validation/hard_cases.py [--out validation/figures/hard_cases] [--rays 10000000] [--full]

Each row says what must come out, what did, and whether that is right. --full adds a mesh of 10⁷ facets (7 GB).
"""

from __future__ import annotations

import argparse
import base64
import time
from collections.abc import Callable
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any

import jinja2
import numpy as np
from matplotlib.figure import Figure
from numpy.typing import ArrayLike, NDArray
from scipy.ndimage import binary_erosion

import seamap_rt as sr
from seamap_rt import analytic
from seamap_rt.analytic.shadowing import sinusoid_visible_intervals
from seamap_rt.conventions import SPEED_OF_LIGHT
from seamap_rt.echoes.riding import run_sea
from seamap_rt.io.scenefile import InputError
from seamap_rt.mesh import SurfaceMesh, polar_grid
from seamap_rt.mesh.polar import mesh_turn, sea_on_grid
from seamap_rt.radar.mast import Mast
from seamap_rt.radar.platform import BoatState
from seamap_rt.report import style
from seamap_rt.scene import MOST_TRIANGLES, Scene
from seamap_rt.settings import RadarSettings, RetrievalSettings
from seamap_rt.simulation import Simulator
from seamap_rt.tracing import tracer
from seamap_rt.tracing.rays import SeaScene

TRACERS = ("facets", "horizon")
KINDS = ("facet", "diagonal", "rung", "radial", "vertex")
GRAZING_DEG = (1.0, 0.7, 0.5, 0.3, 0.2, 0.14, 0.1)
BASELINES_M = (0.001, 0.003, 0.01, 0.03, 0.1, 0.3, 1.0, 3.0)
RANGES_M = (50.0, 200.0, 1000.0, 5000.0, 12_000.0, 19_990.0)
AT_ONCE = 1_000_000  # rays


@dataclass(frozen=True)
class Finding:
    """One row of the table, and what it has to show."""

    case: str
    expectation: str
    found: str
    right: bool | None  # None: nothing was asked, a figure for the record
    figure: Figure | None = None
    seconds: float = 0.0


@dataclass(frozen=True)
class Rings:
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
    lit = tracer(name, made.radar, made.scattering)(mesh).lit
    assert lit is not None
    return lit


# ------------------------------------------------------------------------------------------------------- shadows


def terminator(_: argparse.Namespace) -> list[Finding]:
    """Edges of light on a sinusoid under 1° to 0.1° against where it has them."""
    facet, height, length = 0.5, 4.0 / 3.0, 40.0
    worst: dict[str, list[float]] = {name: [] for name in TRACERS}
    for grazing in GRAZING_DEG:
        middle = 5.0 / np.tan(np.radians(grazing))
        near, far = middle - 60.0, middle + 60.0
        made = scene(
            "flat",
            radar__sector_deg=[90.0, 91.8],
            radar__range_m=[near, far],
            scattering__extrapolate=True,
            tracing__facet_m=facet,
        )
        errors = dict.fromkeys(TRACERS, 0.0)
        for phase in np.arange(0.0, 2.0 * np.pi, 0.5):
            ring = Rings(lambda r, phase=phase: 0.5 * height * np.cos(2.0 * np.pi * r / length + phase))
            mesh = mesh_turn(ring, made.radar, made.meshing, 0)
            for name in TRACERS:
                lit = light(name, mesh, made)
                for antenna, mast in ((0, 4.9), (1, 5.1)):
                    exact, _share = sinusoid_visible_intervals(height, length, mast, near - length, far + length, phase)
                    found = edges(lit[antenna], mesh.facets.distance, near, far)
                    errors[name] = max(errors[name], np.abs(found - exact.reshape(-1, 1)).min(axis=0).max())
        for name in TRACERS:
            worst[name].append(errors[name])
    figure, axes = graph("Grazing angle (°)", "Worst error of an edge of light (m)", "Terminators of a sinusoid")
    for name, line, colour in zip(TRACERS, ("o-", "x--"), (style.BLUE, style.ORANGE), strict=True):
        axes.semilogx(GRAZING_DEG, worst[name], line, color=colour, label=name)
    axes.set_ylim(0.0, 1.2 * facet)
    axes.axhline(facet, color=style.GREY, linestyle=":", label="one facet")
    axes.legend()
    return [
        Finding(
            f"shadow terminator at 0.1–1°, {name}",
            "every edge of light of the exact sinusoid to a facet, 0.5 m",
            f"worst {max(worst[name]):.2f} m",
            max(worst[name]) <= facet,
            figure if name == TRACERS[0] else None,
        )
        for name in TRACERS
    ]


def edges(lit: NDArray[np.bool_], distance: NDArray[np.float64], near: float, far: float) -> NDArray[np.float64]:
    """Distances within the window between facets of which one is lit and the next is not, of every column."""
    column, facet = np.nonzero(lit[:, 1:] != lit[:, :-1])
    place = 0.5 * (distance[facet] + distance[facet + 1])
    return place[(place > near) & (place < far) & (column >= 0)]


def rays_against_horizon(_: argparse.Namespace) -> list[Finding]:
    """Facets of whole turns of choppy_sea on which the tracers disagree, and how far from a shadow's edge."""
    made = scene("choppy_sea", tracing__facet_m=0.5, tracing__columns_per_beam=4)
    mesh = mesh_turn(sr.sea.realize(made.sea, 3), made.radar, made.meshing, 0)
    rays, horizon = (light(name, mesh, made) for name in TRACERS)
    differ = rays != horizon
    stray = int(np.count_nonzero(differ & ~(beside_an_edge(rays) | beside_an_edge(horizon))))
    share = differ.mean()
    return [
        Finding(
            "rays against the float64 horizon, a turn of choppy_sea",
            "disagree on less than 0.02 % of the facets, all beside an edge of shadow",
            f"{np.count_nonzero(differ)} of {differ.size}: {share:.4%}, {stray} of them away from an edge",
            bool(share < 2e-4 and stray == 0),
        )
    ]


def beside_an_edge(lit: NDArray[np.bool_]) -> NDArray[np.bool_]:
    """(…, column, facet): the facet and its neighbours on its own plane, two places on, are not all lit or all dark."""
    some, every = lit.copy(), lit.copy()
    for here, there in ((slice(2, None), slice(None, -2)), (slice(None, -2), slice(2, None))):
        some[..., here] |= lit[..., there]
        every[..., here] &= lit[..., there]
    return some & ~every


# ---------------------------------------------------------------------------------------------------------- leaks


class Targets:
    """Points on vertices, edges and facets of a sea, all facets about which face a place (3,): no ray can pass them."""

    def __init__(self, mesh: SurfaceMesh, place: NDArray[np.float64]) -> None:
        vertices = mesh.triangles(mesh.sheets()[0])[0]
        c = vertices.astype(np.float32).astype(np.float64).reshape(mesh.grid.sweep.size, -1, 3)
        self.place, self.corners = place, (c[:-1, :-1], c[1:, :-1], c[1:, 1:], c[:-1, 1:])
        start, across, both, out = self.corners
        facing = self._faces(start, across, both) & self._faces(start, both, out)
        self._inner = np.argwhere(binary_erosion(facing, np.ones((3, 3))))

    def points(self, kind: str, count: int, rng: np.random.Generator) -> NDArray[np.float64]:
        """(count, 3) points of a kind, drawn at random."""
        i, j = rng.choice(self._inner, count).T
        start, across, both, out = (corner[i, j] for corner in self.corners)
        s, u = rng.uniform(0.01, 0.99, (2, count, 1))  # the ends of an edge are vertices
        end = {"vertex": start, "radial": out, "rung": across, "diagonal": both, "facet": u * across + (1.0 - u) * both}
        return (1.0 - s) * start + s * end[kind]

    def _faces(self, a: NDArray[np.float64], b: NDArray[np.float64], c: NDArray[np.float64]) -> NDArray[np.bool_]:
        normal, towards = np.cross(b - a, c - a), self.place - a
        cosine = np.sum(normal * towards, axis=-1)
        return cosine > 1e-3 * np.linalg.norm(normal, axis=-1) * np.linalg.norm(towards, axis=-1)


def leaks(traced: Any, place: NDArray[np.float64], points: NDArray[np.float64], late: float) -> int:
    """Rays from a place to points (n, 3) that hit nothing, or not until they are `late` metres beyond their point."""
    import mitsuba as mi

    away = points - place
    length = np.linalg.norm(away, axis=1)
    axes = [np.ascontiguousarray(axis, dtype=np.float32) for axis in (away / length[:, None]).T]
    start = [mi.Float(np.full(length.size, part, dtype=np.float32)) for part in place]
    ray = mi.Ray3f(o=mi.Point3f(*start), d=mi.Vector3f(*(mi.Float(axis) for axis in axes)))
    return int(np.count_nonzero(~(np.array(traced.ray_intersect_preliminary(ray).t) < length + late)))


def watertight(arguments: argparse.Namespace) -> list[Finding]:
    """Rays at facets, edges and vertices that get below the sea: as the package traces, and by Mitsuba's default."""
    made = scene("choppy_sea", tracing__facet_m=0.5, tracing__columns_per_beam=4, radar__sector_deg=[60.0, 120.0])
    mesh = mesh_turn(sr.sea.realize(made.sea, 3), made.radar, made.meshing, 0)
    held = SeaScene(mesh, mesh.sheets()[0], made.radar.frequency_hz, 55.0 - 37.5j)
    import mitsuba as mi

    shape = held.scene.objects["sea"].mi_mesh
    plain: Any = mi.load_dict({"type": "scene", "embree_use_robust_intersections": False, "sea": shape})
    each = max(1, arguments.rays // (2 * len(KINDS)))
    rng, counts = np.random.default_rng(1), {kind: [0, 0] for kind in KINDS}
    for antenna in (0, 1):
        place = np.array([0.0, 0.0, float(np.float32(mesh.grid.places[0, antenna, 2]))])
        targets = Targets(mesh, place)
        for kind in KINDS:
            left = each
            while left > 0:
                points = targets.points(kind, min(left, AT_ONCE), rng)
                left -= len(points)
                for number, traced in enumerate((held.scene.mi_scene, plain)):
                    counts[kind][number] += leaks(traced, place, points, late=0.5)
    total = 2 * each
    figure, axes = graph("Rays aimed at", "Share that leaks", "Watertightness, by where rays are aimed")
    for number, label in enumerate(("as the package traces", "Mitsuba's default")):
        shares = [max(counts[kind][number] / total, 0.3 / total) for kind in KINDS]
        axes.bar(
            np.arange(len(KINDS)) + 0.4 * number - 0.2,
            shares,
            width=0.38,
            label=label,
            color=(style.BLUE, style.ORANGE)[number],
        )
    axes.set_yscale("log")
    axes.set_xticks(range(len(KINDS)), KINDS)
    axes.legend()
    rows = []
    for kind in KINDS:
        package, default = counts[kind]
        found = f"{package} of {total:.3g} as the package traces, {default} by Mitsuba's default"
        expectation, right = "0 leaks", package == 0
        if kind == "facet":
            expectation, right = (
                "at most 1 in 10⁵: what passes an edge within float32's rounding",
                package <= 1e-5 * total,
            )
        elif kind == "vertex":
            expectation, right = "for the record: six edges meet, and each side is rounded for itself", None
        rows.append(Finding(f"rays at a {kind}", expectation, found, right, figure if kind == "facet" else None))
    return rows


# --------------------------------------------------------------------------------------------------- odd facets


def along_the_ray(_: argparse.Namespace) -> list[Finding]:
    """A slope that falls along the lower antenna's own ray, tipped by ulps and more: all about it stays right."""
    made = scene("flat", radar__sector_deg=[90.0, 92.0], radar__range_m=[15.0, 60.0], tracing__facet_m=0.5)
    top, start, wrong, lit_there = 2.0, 20.0, 0, {}
    tips = [sign * size for size in (1e-2, 1e-3, 1e-6, 1e-9, 2.2e-16) for sign in (-1.0, 1.0)] + [0.0]
    for tip in tips:
        slope = (4.9 - top) / start * (1.0 + tip)
        foot = start + top / slope
        ring = Rings(lambda r, slope=slope: np.where(r < start - 1e-9, 0.0, np.maximum(top - slope * (r - start), 0.0)))
        mesh = mesh_turn(ring, made.radar, made.meshing, 0)
        distance = mesh.facets.distance
        ramp = (distance > start + 0.5) & (distance < foot - 0.5)
        beside = (distance < start - 0.5) | (distance > foot + 0.5)
        for name in TRACERS:
            lower = light(name, mesh, made)[0]
            wrong += int(np.count_nonzero(~lower[:, beside]))
            lit_there[name, tip] = lower[:, ramp].mean()
            if abs(tip) >= {"facets": 1e-3, "horizon": 1e-9}[name]:
                wrong += int(np.count_nonzero(lower[:, ramp] != (tip < 0.0)))
    exact = ", ".join(f"{name} {lit_there[name, 0.0]:.0%}" for name in TRACERS)
    return [
        Finding(
            "facets parallel to the ray, tipped by 0, ±1 ulp … ±1e-2",
            "all before and behind it lit; the slope itself by the sign of its tip, from 1e-3 (rays), 1e-9 (horizon)",
            f"{wrong} wrong facets; of those exactly parallel lit: {exact}",
            wrong == 0,
        )
    ]


def slivers(_: argparse.Namespace) -> list[Finding]:
    """Columns of 0.14 mm at the mast's foot, antennas that lean out over them."""
    wrong = total = 0
    for tilt in (-30.0, 0.0, 30.0):
        made = scene(
            "flat",
            radar__sector_deg=[90.0, 92.0],
            radar__range_m=[5.0, 100.0],
            radar__baseline_m=4.0,
            radar__tilt_deg=tilt,
            radar__antenna__azimuth_beamwidth_deg=0.5,
            radar__antenna__width_m=6.0,
            retrieval__cell_azimuth_deg=0.5,
            tracing__facet_m=0.25,
            tracing__columns_per_beam=64,
        )
        mesh = mesh_turn(sr.sea.realize(made.sea, 1), made.radar, made.meshing, 0)
        for name in TRACERS:
            lit = light(name, mesh, made)
            for antenna in (0, 1):
                expected = mesh.facets.distance > mesh.grid.places[0, antenna, 0]
                wrong += int(np.count_nonzero(lit[antenna] != expected))
                total += lit[antenna].size
    return [
        Finding(
            "degenerate triangles at the mast's foot (0.14 mm × 0.25 m), B = 4 m, tilt ±30°",
            "of a flat sea all that is in front of the antenna is lit",
            f"{wrong} of {total} facets wrong",
            wrong == 0,
        )
    ]


def one_facet(_: argparse.Namespace) -> list[Finding]:
    """The smallest mesh: one column between two rungs."""
    made = scene("flat", radar__sector_deg=[90.0, 92.0], radar__range_m=[5.0, 20.0], tracing__facet_m=2.0)
    wrong = []
    for slope in (-3.0, 0.0, 3.0):
        whole = mesh_turn(Rings(lambda r, slope=slope: slope * (r - 2.0)), made.radar, made.meshing, 0)
        mesh = one_column(whole)
        wrong += [name for name in TRACERS if (light(name, mesh, made) != (slope >= 0.0)).any()]
    return [
        Finding("one column of two facets", "lit from the front, dark from behind", f"{len(wrong)} wrong", not wrong)
    ]


def one_column(mesh: SurfaceMesh) -> SurfaceMesh:
    grid, lines, column = mesh.grid, slice(0, 2), slice(0, 1)
    part = replace(
        grid,
        sweep=grid.sweep[lines],
        azimuth=grid.azimuth[lines],
        time=grid.time[lines],
        ground_range=grid.ground_range[:2],
        stance=grid.stance[lines],
        column_stance=grid.column_stance[column],
        drift=grid.drift[column],
    )
    return SurfaceMesh(part, mesh.elevation[lines, :2], mesh.velocity_look[lines, :2], mesh.velocity_up[lines, :2])


# ------------------------------------------------------------------------------------------------- far and long


def far_from_origin(_: argparse.Namespace) -> list[Finding]:
    """The same water 20 patches of 512 m away from the origin: voltages, light and map."""
    away, turn = 20 * 512.0, 2000
    made = scene(
        "tiny",
        platform__speed_m_s=5.12,
        platform__heading_deg=90.0,
        radar__sector_deg=[250.0, 290.0],
        platform__list_deg=5.0,
    )
    far, near = Simulator(made), Simulator(made)
    motion = near.mast.motion

    def nearer(times: ArrayLike) -> BoatState:
        state = motion(times)
        return BoatState(state.position - np.array((away, 0.0, 0.0)), state.attitude)

    near.mast = near.sensed = Mast(made.radar, made.platform, nearer)
    meshes = [each.mesh(turn) for each in (far, near)]
    lit = [light("facets", mesh, made) for mesh in meshes]
    turns = [each.turn(turn) for each in (far, near)]
    volts = [each.echoes["voltage"].values for each in turns]
    error = np.abs(volts[0] - volts[1]).max() / np.sqrt(np.mean(np.abs(volts[1]) ** 2))
    maps = [sr.retrieve(each.echoes, made.retrieval)["polar"].to_dataset()["height"].values for each in turns]
    height = np.nanquantile(np.abs(maps[0] - maps[1]), 0.99)
    same = np.array_equal(np.isfinite(maps[0]), np.isfinite(maps[1]))
    differ = int(np.count_nonzero(lit[0] != lit[1]))
    return [
        Finding(
            "10.24 km from the origin",
            "the light, voltages (1e-4 of rms) and heights (10 µm) of the same water at the origin",
            f"{differ} of {lit[0].size} facets, voltages {error:.1e} of rms, heights {1e6 * height:.2f} µm (99 %)",
            bool(error < 1e-4 and same and height < 1e-5 and differ < 1e-4 * lit[0].size),
        )
    ]


def half_a_day(_: argparse.Namespace) -> list[Finding]:
    """Turn 43 200: the meshed sea against the sum of its waves, and the scan's lines."""
    made, turn = scene("tiny", tracing__facet_m=0.8, tracing__columns_per_beam=4), 43_200
    water, rng, errors, lines = sr.sea.realize(made.sea, 5), np.random.default_rng(3), [], []
    for number in (0, turn):
        grid = polar_grid(made.radar, made.meshing, number)
        elevation = sea_on_grid(water, grid)[0]
        line, rung = rng.integers(0, grid.sweep.size, 100), rng.integers(0, grid.ground_range.size, 100)
        azimuth, away = np.radians(grid.azimuth[line]), grid.ground_range[rung]
        exact = sr.sea.direct_sum(water.components(), away * np.sin(azimuth), away * np.cos(azimuth), grid.time[line])
        errors.append(np.abs(elevation[line, rung] - exact.elevation).max())
        lines.append(grid.sweep.size)
    return [
        Finding(
            "t = 12 h: the sea",
            "interpolated waves are their direct sum as closely as at time 0",
            f"worst {1e3 * errors[1]:.3f} mm, at time 0 {1e3 * errors[0]:.3f} mm",
            bool(errors[1] < 2.0 * errors[0]),
        ),
        Finding("t = 12 h: the scan", "as many lines as at time 0", f"{lines[1]} and {lines[0]}", lines[0] == lines[1]),
    ]


# ---------------------------------------------------------------------------------------------------------- phases


def baselines(_: argparse.Namespace) -> list[Finding]:
    """A flat sea of closed form over baselines of 1 mm to 3 m."""
    settings = RetrievalSettings(estimator="single_cell", cell_range_m=1.5, paths="one_way", ground_m=20.0)
    worst, bounds = [], []
    for baseline in BASELINES_M:
        radar = RadarSettings(baseline_m=baseline, noise=False, sector_deg=(80.0, 98.0), range_m=(15.0, 400.0))
        found = sr.retrieve(analytic.echoes(analytic.FlatSea(), radar), settings)["polar"].to_dataset()
        per_radian = SPEED_OF_LIGHT / radar.frequency_hz * found["range"].values / (2.0 * np.pi * baseline)
        worst.append(float(np.abs(found["height"].values).max()))
        bounds.append(float(1e-7 * per_radian.max()))
    figure, axes = graph("Baseline (m)", "Worst height of a flat sea to 400 m (m)", "Baselines from 1 mm to 3 m")
    axes.loglog(BASELINES_M, worst, "o-", color=style.BLUE, label="found")
    axes.loglog(BASELINES_M, bounds, ":", color=style.GREY, label="1e-7 rad × λR/2πB")
    axes.legend()
    return [
        Finding(
            "B from 1 mm to 3 m",
            "a flat sea of closed form is level to 1e-7 rad of phase",
            f"{1e6 * worst[0]:.0f} µm at 1 mm, {1e6 * worst[-1]:.3f} µm at 3 m",
            bool(np.all(np.array(worst) < bounds)),
            figure,
        )
    ]


def far_phases(_: argparse.Namespace) -> list[Finding]:
    """Phases of point scatterers out to 20 km against extended precision."""
    exact = np.longdouble
    pi = np.arctan2(exact(0.0), exact(-1.0))
    k, worst = 2 * pi * exact(10e9) / exact(SPEED_OF_LIGHT), []
    for ground in RANGES_M:
        settings = {
            "name": "far",
            "radar": {
                "noise": False,
                "baseline_m": 3.0,
                "prf_hz": 7000.0,
                "sector_deg": (37.0, 37.9),
                "range_m": (ground - 6.0, ground + 9.0),
            },
            "sea": {"extent_m": 20_000.0, "resolution_m": 10.0},
            "retrieval": {"cell_azimuth_deg": 0.45, "ground_m": 20.0},
            "scattering": {"extrapolate": True},
        }
        place = np.array([ground * np.sin(0.6535), ground * np.cos(0.6535), 0.37])
        echoes = sr.echoes.from_scatterers(Scene.model_validate(settings), place[None], [1e6])
        paths = [
            np.sqrt(np.sum((place.astype(exact) - np.array((0.0, 0.0, 5.0 + side), dtype=exact)) ** 2))
            for side in (-1.5, 1.5)
        ]
        errors = []
        for pulse in range(echoes.sizes["pulse"]):
            one = echoes.isel(pulse=pulse)
            volts = one["voltage"].values[:, int(np.abs(one["voltage"].values[0]).argmax())]
            for voltage, path in zip(volts, paths, strict=True):
                off = np.angle(complex(voltage)) + k * (paths[int(one["transmitter"])] + path)
                errors.append(abs(float(np.remainder(off + pi, 2 * pi) - pi)))
        worst.append(max(errors))
    figure, axes = graph("Ground range (m)", "Worst phase error (rad)", "Phases of a point scatterer, B = 3 m")
    axes.loglog(RANGES_M, worst, "o-", color=style.BLUE)
    axes.axhline(1e-3, color=style.GREY, linestyle=":", label="asked")
    axes.legend()
    return [
        Finding(
            "phases at 20 km",
            "within 1e-3 rad of extended precision",
            f"{worst[-1]:.1e} rad at 20 km, {worst[0]:.1e} rad at 50 m",
            max(worst) < 1e-3,
            figure,
        )
    ]


# -------------------------------------------------------------------------------------------------- extreme scenes


def on_the_crest(above: float, **keys: Any) -> Scene:
    """Antennas so far above the crest of a steep wave, looking down its back."""
    return scene(
        "sinusoid",
        **{
            "sea__waves__0__height_m": 3.0,
            "sea__waves__0__wavelength_m": 22.0,
            "radar__height_m": 1.505 + above,
            "radar__baseline_m": 0.01,
            "radar__sector_deg": [88.0, 92.0],
            "radar__range_m": [4.0, 11.5],
            "scattering__nrcs": "constant",
            "tracing__facet_m": 0.25,
            **keys,
        },
    )


def crest(_: argparse.Namespace) -> list[Finding]:
    """1 cm above a crest nothing of its back is seen; just below it is refused."""
    rows = []
    for name in TRACERS:
        made = on_the_crest(0.01, radar__noise=False, tracing__tracer=name)
        turn = Simulator(made).turn(0)
        heard = bool(turn.echoes["voltage"].values.any())
        found = sr.retrieve(turn.echoes, made.retrieval)["polar"].to_dataset()
        known = int(np.isfinite(found["height"].values).sum())
        flagged = bool((found["quality"].values & 1).all())
        rows.append(
            Finding(
                f"no facet lit: antenna 1 cm above a crest, {name}",
                "no echo at all without noise, every cell NaN and flagged no_echo",
                f"{'an' if heard else 'no'} echo, {known} heights, {'all' if flagged else 'not all'} flagged",
                not heard and known == 0 and flagged,
            )
        )
    for above, right in ((0.001, "taken"), (0.0, "refused"), (-0.01, "refused")):
        try:
            Simulator(on_the_crest(above))
            found = "taken"
        except InputError as error:
            found = f"refused: {error}"
        rows.append(
            Finding(
                f"antenna {1e3 * above:+.0f} mm from a crest",
                right,
                found,
                found.startswith(right) and "\n" not in found,
            )
        )
    return rows


def storm(_: argparse.Namespace) -> list[Finding]:
    """Hs 15 m under a 5 m mast, 20 s each of three seas that come up over it."""
    keys = {
        "sea__resolution_m": 4.0,
        "sea__waves__0__significant_wave_height_m": 15.0,
        "sea__waves__0__peak_period_s": 17.0,
        "sea__extent_m": 1024.0,
        "radar__sector_deg": [262.0, 267.4],
        "scattering__nrcs": "constant",
        "tracing__facet_m": 1.0,
        "turns": 20,
    }
    drowned, bad = [], 0
    for seed in range(1, 100):
        made = scene("tiny", **keys, seed=seed)
        waves = run_sea(made).components()
        level = sr.sea.direct_sum(waves, 0.0, 0.0, np.arange(20.0)).elevation
        if level[0] > 4.0 or np.count_nonzero(level > 5.0) < 4:
            continue
        simulation = sr.simulate(made)
        volts = simulation.echoes["voltage"].values
        silent = np.all(np.isnan(volts), axis=(1, 2))
        found = sr.retrieve(simulation.echoes, made.retrieval)["polar"].to_dataset()
        unknown = np.isnan(found["height"].values)
        bad += int(np.count_nonzero(~np.isfinite(volts[~silent])))
        bad += int(np.count_nonzero(silent != (simulation.echoes["flag"].values == 64)))
        bad += int(np.count_nonzero(found["quality"].values[unknown] == 0))
        drowned.append(float(silent.mean()))
        if len(drowned) == 3:
            break
    return [
        Finding(
            "Hs 15 m under a 5 m mast",
            "whole pulses NaN and flagged while under water, all else finite, no cell without a height or a reason",
            f"drowned {', '.join(f'{share:.0%}' for share in drowned)} of the pulses; {bad} bad values",
            len(drowned) == 3 and min(drowned) > 0.0 and bad == 0,
        )
    ]


def choppy_wall(_: argparse.Namespace) -> list[Finding]:
    """Choppy waves near the folding limit, and a step of 30 m within 2 cm."""
    made = scene(
        "tiny",
        sea__model="choppy",
        sea__waves__0__significant_wave_height_m=3.0,
        sea__waves__0__peak_period_s=3.6,
        sea__resolution_m=0.5,
        sea__extent_m=360.0,
        scattering__nrcs="constant",
        tracing__facet_m=0.25,
    )
    water = sr.sea.realize(made.sea, 2)
    facts = water.resolved.choppy
    mesh = mesh_turn(water, made.radar, made.meshing, 0)
    rays, horizon = (light(name, mesh, made) for name in TRACERS)
    steepest, share = np.abs(mesh.facets.slope_look).max(), float(np.mean(rays != horizon))
    rows = [
        Finding(
            f"a wall of water: choppy, {facts.folded_share if facts else 0.0:.1%} folded",
            "rays and horizon differ on less than 0.02 % of the facets",
            f"{share:.4%} of {rays.size}; steepest slope {steepest:.1f}",
            share < 2e-4,
        )
    ]
    made = scene("flat", radar__sector_deg=[90.0, 91.8], radar__range_m=[15.0, 60.0], tracing__facet_m=0.02)
    for top in (4.0, 30.0):
        ring = Rings(lambda r, top=top: np.where(np.abs(r - 20.0) < 0.011, top, 0.0))
        mesh = mesh_turn(ring, made.radar, made.meshing, 0)
        distance, wrong = mesh.facets.distance, 0
        for name in TRACERS:
            for antenna, (lit, mast) in enumerate(zip(light(name, mesh, made), (4.9, 5.1), strict=True)):
                lands = 20.0 * mast / (mast - top) if top < mast else np.inf
                expected = (distance < 20.0) | (distance > lands)
                sure = (np.abs(distance - 20.0) > 1e-6) & ~(np.abs(distance - lands) < 0.04)
                wrong += int(np.count_nonzero(lit[:, sure] != expected[sure])) * (antenna >= 0)
        rows.append(
            Finding(
                f"a step of {top:g} m within 2 cm", "dark from it to where the ray lands", f"{wrong} wrong", wrong == 0
            )
        )
    return rows


def level(_: argparse.Namespace) -> list[Finding]:
    """Hs of 1 µm: all lit, and heights as of a flat sea."""
    maps, lit = [], 1.0
    for height in (1e-6, 0.0):
        made = scene("tiny", sea__waves__0__significant_wave_height_m=height, radar__noise=False)
        turn = Simulator(made).turn(0)
        lit = min(lit, float(turn.truth["polar"].to_dataset()["visible_fraction"].values.min()))
        maps.append(sr.retrieve(turn.echoes, made.retrieval)["polar"].to_dataset()["height"].values)
    error = np.abs(maps[0] - maps[1])
    return [
        Finding(
            "a sea of 1 µm",
            "nothing shadowed, no NaN, heights of a flat sea with the same speckle to 1 µm",
            f"visible {lit:.0%}, {np.isnan(maps[0]).sum()} NaN, heights differ by {1e6 * np.nanmax(error):.2f} µm",
            bool(lit == 1.0 and np.isfinite(maps[0]).all() and np.nanmax(error) < 1e-6),
        )
    ]


def ten_million(arguments: argparse.Namespace) -> list[Finding]:
    """A refusal that says what is needed; and, with --full, 10⁷ facets traced."""
    keys = {
        "radar__range_m": [15.0, 3000.0],
        "radar__prf_hz": 2000.0,
        "retrieval__ground_m": 10.0,
        "scattering__extrapolate": True,
        "tracing__columns_per_beam": 4,
        "sea__extent_m": 6200.0,
        "sea__resolution_m": 3.0,
    }
    columns = 4.0 * (360.0 + 6.0 * 1.8) / 1.8
    least = 2.0 * columns * 3005.0 / MOST_TRIANGLES
    try:
        scene("flat", **keys, tracing__facet_m=0.98 * least)
        found = "taken"
    except InputError as error:
        found = str(error)
    right = "GB" in found and "raise tracing.facet_m" in found and "\n" not in found
    rows = [Finding("2 % more facets than may be", "refused in one line, with the memory they need", found, right)]
    if not arguments.full:
        return rows
    made = scene("flat", **keys, tracing__facet_m=2.0 * columns * 3005.0 / 1e7)
    mesh = mesh_turn(Rings(lambda r: 0.3 * np.cos(r / 5.0)), made.radar, made.meshing, 0)
    seconds, lit = [], []
    for name in TRACERS:
        start = time.perf_counter()
        lit.append(light(name, mesh, made))
        seconds.append(time.perf_counter() - start)
    share = float(np.mean(lit[0] != lit[1]))
    found = f"{lit[0][0].size:.3g} facets, {seconds[0]:.0f} s and {seconds[1]:.0f} s, differ on {share:.4%}"
    return [*rows, Finding("10⁷ facets, rays and horizon", "traced; differ on less than 0.02 %", found, share < 2e-4)]


# --------------------------------------------------------------------------------------------------------- the page

CASES: tuple[Callable[[argparse.Namespace], list[Finding]], ...] = (
    terminator,
    rays_against_horizon,
    watertight,
    along_the_ray,
    slivers,
    far_from_origin,
    crest,
    choppy_wall,
    level,
    baselines,
    far_phases,
    half_a_day,
    storm,
    one_facet,
    ten_million,
)

PAGE = """<!DOCTYPE html>
<html lang="en"><head><meta charset="utf-8"><title>Hard cases – seamap_rt</title><link rel="icon" href="data:,">
<style>
body { margin: 0 auto; padding: 1.5rem 1rem 4rem; max-width: 62rem; background: #fff; color: #1b1b1b;
  font: 16px/1.5 system-ui, -apple-system, "Segoe UI", Roboto, "DejaVu Sans", sans-serif; }
h1 { font-size: 1.6rem; }
table { border-collapse: collapse; font-size: .85rem; }
th, td { padding: .2rem .7rem; text-align: left; border-bottom: 1px solid #e2e2e2; vertical-align: top; }
td.wrong { color: #d55e00; font-weight: 600; }
figure { margin: 2rem 0; } img { width: 100%; max-width: 936px; }
</style></head><body>
<h1>Numerical stability: hard cases</h1>
<p>{{ right }} of {{ asked }} cases come out as they must. Each has an answer that is known: a closed form, extended
precision, or the same scene where it is easy.</p>
<table><thead><tr><th>Case</th><th>What must come out</th><th>What did</th><th>Verdict</th></tr></thead><tbody>
{% for row in rows %}
<tr><td>{{ row.case }}</td><td>{{ row.expectation }}</td><td>{{ row.found }}</td>
<td{% if row.right == False %} class="wrong"{% endif %}>{{ verdict(row) }}</td></tr>
{% endfor %}
</tbody></table>
{% for data, row in shown %}
<figure><img src="data:image/png;base64,{{ data }}" alt="{{ row.case }}: {{ row.found }}">
<figcaption><b>Figure {{ loop.index }}.</b> {{ row.case }}: {{ row.expectation }}. Found: {{ row.found }}.</figcaption>
</figure>
{% endfor %}
</body></html>
"""


def verdict(row: Finding) -> str:
    return {True: "right", False: "WRONG", None: "–"}[row.right]


def graph(x_label: str, y_label: str, title: str) -> tuple[Figure, Any]:
    figure = style.new_figure(3.0)
    axes = style.place(figure, 0.9, 0.4, style.WIDTH - 1.2, 2.0)
    style.graph(axes, x_label, y_label, title)
    return figure, axes


def write_page(out: Path, rows: list[Finding]) -> Path:
    """Figures as PNGs and in a page that needs no other file; its path."""
    out.mkdir(parents=True, exist_ok=True)
    shown = []
    for number, row in enumerate([row for row in rows if row.figure is not None], 1):
        assert row.figure is not None
        data = style.png(row.figure)
        (out / f"hard_cases_{number}.png").write_bytes(data)
        shown.append((base64.b64encode(data).decode("ascii"), row))
    template = jinja2.Environment(autoescape=True, undefined=jinja2.StrictUndefined).from_string(PAGE)
    judged = [row.right for row in rows if row.right is not None]
    page = template.render(rows=rows, shown=shown, verdict=verdict, right=sum(judged), asked=len(judged))
    path = out / "hard_cases.html"
    path.write_text(page, encoding="utf-8")
    return path


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--out", type=Path, default=Path(__file__).parent / "figures" / "hard_cases")
    parser.add_argument("--rays", type=int, default=10_000_000)
    parser.add_argument("--only", default="", help="part of the name of the functions to run")
    parser.add_argument("--full", action="store_true")
    arguments = parser.parse_args()
    rows: list[Finding] = []
    for case in CASES:
        if arguments.only not in case.__name__:
            continue
        start = time.perf_counter()
        found = style.styled(case)(arguments)
        rows += found
        for row in found:
            print(f"{verdict(row):6}{row.case} | {row.expectation} | {row.found}", flush=True)
        print(f"      ({case.__name__}: {time.perf_counter() - start:.1f} s)", flush=True)
    print(f"written: {write_page(arguments.out, rows)}")
    if any(row.right is False for row in rows):
        raise SystemExit(1)


if __name__ == "__main__":
    main()
