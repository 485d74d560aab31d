"""Hard cases of light and shadow: terminators, leaks between triangles, odd facets."""

from __future__ import annotations

from dataclasses import replace
from typing import Any

import numpy as np
from numpy.typing import NDArray
from scipy.ndimage import binary_erosion

import seamap_rt as sr
from seamap_rt.mesh import SurfaceMesh
from seamap_rt.mesh.surface import mesh_turn
from seamap_rt.report import style
from seamap_rt.tracing.rays import SeaScene

from ..analytic.shadowing import sinusoid_visible_intervals
from .case import TRACERS, Effort, Finding, RadialSurface, graph, light, scene

KINDS = ("facet", "diagonal", "rung", "radial", "vertex")
GRAZING_DEG = (1.0, 0.7, 0.5, 0.3, 0.2, 0.14, 0.1)
AT_ONCE = 1_000_000  # rays

# ------------------------------------------------------------------------------------------------------- shadows


def terminator(_: Effort) -> list[Finding]:
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
            surface = RadialSurface(lambda r, phase=phase: 0.5 * height * np.cos(2.0 * np.pi * r / length + phase))
            mesh = mesh_turn(surface, made.radar, made.meshing, 0)
            for name in TRACERS:
                lit = light(name, mesh, made)
                for antenna, mast in ((0, 4.9), (1, 5.1)):
                    exact, _share = sinusoid_visible_intervals(height, length, mast, near - length, far + length, phase)
                    computed = edges(lit[antenna], mesh.facets.distance, near, far)
                    errors[name] = max(errors[name], np.abs(computed - exact.reshape(-1, 1)).min(axis=0).max())
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
    edge = 0.5 * (distance[facet] + distance[facet + 1])
    return edge[(edge > near) & (edge < far) & (column >= 0)]


def rays_against_horizon(_: Effort) -> list[Finding]:
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
    """(…, column, facet): the facet and its neighbours on its own plane, two facets on, are not all lit or all dark."""
    some, every = lit.copy(), lit.copy()
    for here, there in ((slice(2, None), slice(None, -2)), (slice(None, -2), slice(2, None))):
        some[..., here] |= lit[..., there]
        every[..., here] &= lit[..., there]
    return some & ~every


# ---------------------------------------------------------------------------------------------------------- leaks


class Targets:
    """Points on vertices, edges and facets of a sea, whose facets all face a position (3,): no ray can pass."""

    def __init__(self, mesh: SurfaceMesh, position: NDArray[np.float64]) -> None:
        vertices = mesh.trimesh(mesh.sheets()[0]).vertices
        c = vertices.astype(np.float32).astype(np.float64).reshape(mesh.grid.sweep.size, -1, 3)
        self.position, self.corners = position, (c[:-1, :-1], c[1:, :-1], c[1:, 1:], c[:-1, 1:])
        start, across, both, out = self.corners
        facing = self._faces(start, across, both) & self._faces(start, both, out)
        self._inner = binary_erosion(facing, np.ones((3, 3)))

    def points(self, kind: str, count: int, rng: np.random.Generator, line: int | None = None) -> NDArray[np.float64]:
        """(count, 3) points of a kind, drawn at random; on one line of the mesh, if it is given."""
        inner = self._inner.copy()
        if line is not None:
            inner[:line], inner[line + 1 :] = False, False
        i, j = rng.choice(np.argwhere(inner), count).T
        start, across, both, out = (corner[i, j] for corner in self.corners)
        s, u = rng.uniform(0.01, 0.99, (2, count, 1))  # the ends of an edge are vertices
        end = {"vertex": start, "radial": out, "rung": across, "diagonal": both, "facet": u * across + (1.0 - u) * both}
        return (1.0 - s) * start + s * end[kind]

    def _faces(self, a: NDArray[np.float64], b: NDArray[np.float64], c: NDArray[np.float64]) -> NDArray[np.bool_]:
        normal, towards = np.cross(b - a, c - a), self.position - a
        cosine = np.sum(normal * towards, axis=-1)
        return cosine > 1e-3 * np.linalg.norm(normal, axis=-1) * np.linalg.norm(towards, axis=-1)


def leaks(traced: Any, position: NDArray[np.float64], points: NDArray[np.float64], late: float) -> int:
    """Rays from a position to points (n, 3) that hit nothing, or only `late` metres beyond their point."""
    import mitsuba as mi

    away = points - position
    length = np.linalg.norm(away, axis=1)
    axes = [np.ascontiguousarray(axis, dtype=np.float32) for axis in (away / length[:, None]).T]
    start = [mi.Float(np.full(length.size, part, dtype=np.float32)) for part in position]
    ray = mi.Ray3f(o=mi.Point3f(*start), d=mi.Vector3f(*(mi.Float(axis) for axis in axes)))
    return int(np.count_nonzero(~(np.array(traced.ray_intersect_preliminary(ray).t) < length + late)))


def watertight(effort: Effort) -> list[Finding]:
    """Rays at facets, edges and vertices that get below the sea: as the package traces, and by Mitsuba's default."""
    made = scene("choppy_sea", tracing__facet_m=0.5, tracing__columns_per_beam=4, radar__sector_deg=[60.0, 120.0])
    mesh = mesh_turn(sr.sea.realize(made.sea, 3), made.radar, made.meshing, 0)
    (sheet,) = mesh.sheets()
    held = SeaScene(
        mesh.trimesh(sheet), mesh.grid.antenna_positions[sheet[0].start], made.radar.frequency_hz, 55.0 - 37.5j
    )
    import mitsuba as mi

    shape = held.scene.objects["sea"].mi_mesh
    plain: Any = mi.load_dict({"type": "scene", "embree_use_robust_intersections": False, "sea": shape})
    each = max(1, effort.rays // (2 * len(KINDS)))
    rng, counts = np.random.default_rng(1), {kind: [0, 0] for kind in KINDS}
    for antenna in (0, 1):
        position = np.array([0.0, 0.0, float(np.float32(mesh.grid.antenna_positions[0, antenna, 2]))])
        targets = Targets(mesh, position)
        for kind in KINDS:
            left = each
            while left > 0:
                points = targets.points(kind, min(left, AT_ONCE), rng)
                left -= len(points)
                for number, traced in enumerate((held.mi_scene, plain)):
                    counts[kind][number] += leaks(traced, position, points, late=0.5)
    total = 2 * each
    figure, axes = graph("Rays aimed at", "Share that leaks", "Watertightness, by where rays are aimed; no bar: none")
    for number, label in enumerate(("as the package traces", "Mitsuba's default")):
        shares = [counts[kind][number] / total for kind in KINDS]
        axes.bar(
            np.arange(len(KINDS)) + 0.4 * number - 0.2,
            shares,
            width=0.38,
            label=label,
            color=(style.BLUE, style.ORANGE)[number],
        )
    axes.set_yscale("log")
    axes.set_ylim(0.3 / total, 1.0)
    axes.set_xticks(range(len(KINDS)), KINDS)
    axes.legend()
    rows = []
    for kind in KINDS:
        package, default = counts[kind]
        obtained = f"{package} of {total:.3g} as the package traces, {default} by Mitsuba's default"
        expectation, right = "0 leaks", package == 0
        if kind == "facet":
            expectation, right = (
                "at most 1 in 10⁵: what passes an edge within float32's rounding",
                package <= 1e-5 * total,
            )
        elif kind == "vertex":
            expectation, right = "for the record: six edges meet, and each side is rounded for itself", None
        rows.append(Finding(f"rays at a {kind}", expectation, obtained, right, figure if kind == "facet" else None))
    return rows


# --------------------------------------------------------------------------------------------------- odd facets


def along_the_ray(_: Effort) -> list[Finding]:
    """A slope that falls along the lower antenna's own ray, tipped by ulps and more: all about it stays right."""
    made = scene("flat", radar__sector_deg=[90.0, 92.0], radar__range_m=[15.0, 60.0], tracing__facet_m=0.5)
    top, start, wrong, lit_there = 2.0, 20.0, 0, {}
    tips = [sign * size for size in (1e-2, 1e-3, 1e-6, 1e-9, 2.2e-16) for sign in (-1.0, 1.0)] + [0.0]
    for tip in tips:
        slope = (4.9 - top) / start * (1.0 + tip)
        foot = start + top / slope
        surface = RadialSurface(
            lambda r, slope=slope: np.where(r < start - 1e-9, 0.0, np.maximum(top - slope * (r - start), 0.0))
        )
        mesh = mesh_turn(surface, made.radar, made.meshing, 0)
        distance = mesh.facets.distance
        ramp = (distance > start + 0.5) & (distance < foot - 0.5)
        beside = (distance < start - 0.5) | (distance > foot + 0.5)
        for name in TRACERS:
            lower, upper = light(name, mesh, made)
            wrong += int(np.count_nonzero(~lower[:, beside])) + int(np.count_nonzero(~upper[:, ramp]))
            lit_there[name, tip] = lower[:, ramp].mean()
            # A ray to a facet's middle clears the facet before it by 0.15 × 0.35 m × tip: 50 µm at 1e-3, where float32
            # corners and rays are good to 1 µm. The horizon compares tangents, float64.
            if abs(tip) >= {"facets": 1e-3, "horizon": 1e-9}[name]:
                wrong += int(np.count_nonzero(lower[:, ramp] != (tip < 0.0)))
    exact = ", ".join(f"{name} {lit_there[name, 0.0]:.0%}" for name in TRACERS)
    return [
        Finding(
            "facets parallel to the ray, tipped by 0, ±1 ulp … ±1e-2",
            "before and behind it all lit, to the upper antenna the slope too; to the lower the slope by the sign of "
            "its tip, from 1e-3 (rays), 1e-9 (horizon)",
            f"{wrong} wrong facets; of those exactly parallel lit: {exact}",
            wrong == 0,
        )
    ]


def slivers(_: Effort) -> list[Finding]:
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
                expected = mesh.facets.distance > mesh.grid.antenna_positions[0, antenna, 0]
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


def one_facet(_: Effort) -> list[Finding]:
    """The smallest mesh: one column between two rungs."""
    made = scene("flat", radar__sector_deg=[90.0, 92.0], radar__range_m=[5.0, 20.0], tracing__facet_m=2.0)
    wrong = []
    for slope in (-3.0, 0.0, 3.0):
        whole = mesh_turn(RadialSurface(lambda r, slope=slope: slope * (r - 2.0)), made.radar, made.meshing, 0)
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
        pose=grid.pose[lines],
        column_pose=grid.column_pose[column],
        drift=grid.drift[column],
    )
    return SurfaceMesh(part, mesh.elevation[lines, :2], mesh.velocity_look[lines, :2], mesh.velocity_up[lines, :2])
