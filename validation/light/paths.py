"""Sionna's PathSolver on `choppy_sea`: its light and power against facets, and what a second bounce adds.

    python -m validation.light.paths [--samples 200000] [--launches 4]

Printed: on how many facets of a turn, and where, the tracers `paths`, `facets` and `horizon` differ, and what each
costs (seconds of one core); the power of a flat Lambertian sea over the closed form; that of a choppy one over the sum
of the radar equation over lit facets, by range, for two widths of columns; the share of two bounces, by range and look,
for a white Lambertian sea and for two with a mirror's share. Errors are standard errors by the launches' spread. The
figure goes into validation/figures.

Shares are of powers, path by path. At one antenna a path and its reverse add in phase: twice the share for two diffuse
bounces. Paths that meet the mirror last, which PathSolver does not compute, are as strong as those that meet it first:
four times.
"""

from __future__ import annotations

import time
from dataclasses import dataclass

import matplotlib.pyplot as plt
import numpy as np
from numpy.typing import NDArray

import seamap_rt as sr
from seamap_rt.conventions import SPEED_OF_LIGHT, db
from seamap_rt.mesh import SurfaceMesh
from seamap_rt.mesh.surface import mesh_turn
from seamap_rt.scattering.permittivity import PERMITTIVITIES
from seamap_rt.scene import Scene
from seamap_rt.tracing import tracer
from seamap_rt.tracing.horizon import trace_horizon

from .. import FIGURES
from ..options import options
from .path_echo import DIFFUSE, MIRRORED, Body, PathEcho, lambertian_power, path_echo

Array = NDArray[np.float64]
FIGURE = FIGURES / "paths.png"
GATES_M = np.array([20.0, 50.0, 100.0, 150.0, 200.0, 250.0, 300.0, 350.0, 400.0])
LOOKS_DEG = {"up-wave": 270.0, "cross-wave": 0.0, "down-wave": 90.0}
ASIDE_DEG = 10.0  # of the sea to either side of the columns looked at, for a second bounce
BEAMS = 2  # looked at, to either side


def scene_of(name: str, look_deg: float | None = None, columns: int | None = None) -> Scene:
    keys: dict[str, object] = {"tracing.columns_per_beam": columns or 4, "tracing.facet_m": 0.5}
    if look_deg is not None:
        keys |= {"radar.sector_deg": [look_deg - ASIDE_DEG, look_deg + ASIDE_DEG], "radar.range_m": [15.0, 400.0]}
    return sr.load_scene(name, keys)


def mesh_of(scene: Scene) -> SurfaceMesh:
    return mesh_turn(sr.sea.realize(scene.sea, seed=3), scene.radar, scene.meshing, 0)


def middle(mesh: SurfaceMesh, columns: int = 4) -> slice:
    half = BEAMS * columns
    return slice(mesh.grid.columns // 2 - half, mesh.grid.columns // 2 + half)


# ------------------------------------------------------------------------------------------------------- light


def beside_an_edge(lit: NDArray[np.bool_]) -> NDArray[np.bool_]:
    """The facet and its neighbours on its own plane, two facets on in the column, are not all lit or all dark."""
    some, every = lit.copy(), lit.copy()
    some[..., 2:] |= lit[..., :-2]
    some[..., :-2] |= lit[..., 2:]
    every[..., 2:] &= lit[..., :-2]
    every[..., :-2] &= lit[..., 2:]
    return some & ~every


def compare_light() -> None:
    scene = scene_of("choppy_sea")
    mesh = mesh_of(scene)
    number = 2 * mesh.facets.height.size
    light, costs = {}, {}
    for name in ("facets", "horizon", "paths"):
        trace = tracer(name, scene.radar, scene.scattering)
        trace(mesh)  # compiles
        start = time.process_time()
        lit = trace(mesh).lit
        costs[name] = time.process_time() - start
        assert lit is not None
        light[name] = lit
    print(f"light on a turn: {number} facets and antennas, {100.0 * light['horizon'].mean():.1f} % of them lit")
    for name, cost in costs.items():
        print(f"  {name:8} {1e6 * cost / number:6.2f} s of one core a million")
    for one, other in (("paths", "horizon"), ("paths", "facets"), ("facets", "horizon")):
        differ = light[one] != light[other]
        away = differ & ~(beside_an_edge(light[one]) | beside_an_edge(light[other]))
        print(f"  {one} and {other} differ on {differ.sum()} ({differ.mean():.1e}), {away.sum()} of them off an edge")


# ------------------------------------------------------------------------------------------------------- power


def flat_sea(samples: int, launches: int) -> None:
    scene = scene_of("flat", 90.0)
    mesh = mesh_of(scene)
    columns, grid = middle(mesh), mesh.grid
    echo = path_echo(mesh, columns, scene.radar.frequency_hz, Body(), samples=samples, launches=launches)
    power, error = echo.in_gates(GATES_M, echo.bounces == 1)
    height = float(grid.column_height[0, 0] + grid.antenna_positions[0, 0, 2])
    width = np.radians(grid.azimuth[columns.stop] - grid.azimuth[columns.start])
    wavelength = SPEED_OF_LIGHT / scene.radar.frequency_hz
    closed = (wavelength * height) ** 2 / (4.0 * np.pi) ** 3 * width * (GATES_M[:-1] ** -4 - GATES_M[1:] ** -4)
    print("\nflat Lambertian sea: one bounce over the closed form, less 1, in %")
    for near, far, ratio, spread in zip(GATES_M, GATES_M[1:], power / closed, error / closed, strict=False):
        print(f"  {near:4.0f}–{far:3.0f} m {100.0 * (ratio - 1.0):8.3f} ± {100.0 * spread:.3f}")


@dataclass(frozen=True)
class Power:
    """By gate: paths over facets less 1, its error, the same off shadows' edges; the error of as many loose rays."""

    miss: Array
    error: Array
    clear_miss: Array
    clear_error: Array
    loose: Array


def choppy_power(per_beam: int, samples: int, launches: int) -> Power:
    scene = scene_of("choppy_sea", LOOKS_DEG["up-wave"], per_beam)
    mesh = mesh_of(scene)
    columns, lit = middle(mesh, per_beam), trace_horizon(mesh)
    frequency = scene.radar.frequency_hz
    echo = path_echo(mesh, columns, frequency, Body(), samples=samples, launches=launches)
    slant, own = lambertian_power(lit, columns, 0, frequency)
    clear = lit.lit[0] & ~beside_an_edge(lit.lit[0])
    ranges = np.zeros(clear.shape)
    ranges[columns] = slant
    at, once = ranges.ravel()[echo.facet], echo.bounces == 1

    def against(weight: NDArray[np.bool_], chosen: NDArray[np.bool_]) -> tuple[Array, Array]:
        facets = np.histogram(slant, GATES_M, weights=own * weight)[0]
        power, error = echo.in_gates(GATES_M, chosen, at)
        return power / facets - 1.0, error / facets

    total, square = (np.histogram(at[once], GATES_M, weights=echo.power[once] ** n)[0] for n in (1, 2))
    every = against(np.ones_like(clear[columns]), once)
    return Power(*every, *against(clear[columns], once & clear.ravel()[echo.facet]), np.sqrt(square) / total)


def compare_power(samples: int, launches: int) -> dict[int, Power]:
    powers = {per_beam: choppy_power(per_beam, samples, launches) for per_beam in (4, 16)}
    print("\nchoppy Lambertian sea, up-wave: one bounce over the sum over lit facets, less 1, in %")
    print("  (all facets; those off shadows' edges; the error that as many independent rays would have)")
    for per_beam, power in powers.items():
        for n, near in enumerate(GATES_M[:-1]):
            print(
                f"  {per_beam:2d} columns a beam {near:4.0f}–{GATES_M[n + 1]:3.0f} m "
                f"{100.0 * power.miss[n]:7.2f} ± {100.0 * power.error[n]:.2f} "
                f"{100.0 * power.clear_miss[n]:7.2f} ± {100.0 * power.clear_error[n]:.2f} "
                f"{100.0 * power.loose[n]:7.2f}"
            )
        print(f"  {per_beam:2d} columns a beam, mean of the gates {100.0 * power.miss.mean():7.2f}")
    return powers


# ---------------------------------------------------------------------------------------------- second bounces


def share(echo: PathEcho, chosen: NDArray[np.bool_]) -> tuple[Array, Array]:
    """Of the chosen paths' power in that of one bounce, by gate, and its error."""
    once, once_error = echo.in_gates(GATES_M, echo.bounces == 1)
    power, error = echo.in_gates(GATES_M, chosen)
    with np.errstate(divide="ignore", invalid="ignore"):
        ratio = power / once
        return ratio, np.hypot(error / once, ratio * once_error / once)


def second_bounces(samples: int, launches: int) -> dict[str, dict[str, tuple[Array, Array]]]:
    """Shares and errors by name of the sea's body, and look."""
    shares: dict[str, dict[str, tuple[Array, Array]]] = {}
    for look, azimuth in LOOKS_DEG.items():
        scene = scene_of("choppy_sea", azimuth)
        mesh, water, frequency = mesh_of(scene), scene.scattering, scene.radar.frequency_hz
        permittivity = PERMITTIVITIES[water.permittivity](frequency, water.temperature_c, water.salinity_psu)
        for name, body, kinds in (
            ("white, diffuse twice", Body(), (DIFFUSE, DIFFUSE)),
            ("sea water, S² = ½: mirror, then diffuse", Body(np.sqrt(0.5), complex(permittivity)), (MIRRORED, DIFFUSE)),
            ("conductor, S² = ½: mirror, then diffuse", Body(np.sqrt(0.5)), (MIRRORED, DIFFUSE)),
        ):
            echo = path_echo(mesh, middle(mesh), frequency, body, bounces=2, samples=samples, launches=launches)
            chosen = (echo.kind[0] == kinds[0]) & (echo.kind[1] == kinds[1])
            shares.setdefault(name, {})[look] = share(echo, chosen)
    print("\ntwo bounces over one, in %, path by path; gates from", *(f"{near:.0f}" for near in GATES_M[:-1]), "m on")
    for name, looks in shares.items():
        for look, (ratio, error) in looks.items():
            row = "  ".join(f"{100.0 * r:5.2f} ± {100.0 * e:.2f}" for r, e in zip(ratio, error, strict=True))
            print(f"  {name:40} {look:10} {row}")
    return shares


def draw(power: dict[int, Power], bounces: dict[str, dict[str, tuple[Array, Array]]]) -> None:
    figure, (left, right) = plt.subplots(1, 2, figsize=(11.0, 4.2), layout="constrained")
    at = 0.5 * (GATES_M[1:] + GATES_M[:-1])
    for shift, (per_beam, errors) in zip((-3.0, 3.0), power.items(), strict=True):
        left.errorbar(
            at + shift, 100.0 * errors.miss, 200.0 * errors.error, fmt="o", label=f"{per_beam} columns a beam"
        )
    left.axhline(0.0, color="0.6", linewidth=0.8)
    left.set(xlabel="range (m)", ylabel="paths over facets, less 1 (%)", title="power of one bounce")
    left.legend()
    for colour, (name, looks) in enumerate(bounces.items()):
        for style, (look, (ratio, _)) in zip(("-", "--", ":"), looks.items(), strict=True):
            label = name if look == "up-wave" else None
            right.plot(at, db(ratio), style, color=f"C{colour}", label=label)
    right.set(xlabel="range (m)", ylabel="two bounces over one (dB)", title="up-wave –, cross-wave --, down-wave ···")
    right.legend(fontsize="small")
    figure.savefig(FIGURE, dpi=120)
    print(f"\n{FIGURE}")


def main() -> None:
    arguments = options(__doc__, samples=200_000, launches=4)
    compare_light()
    flat_sea(arguments.samples, arguments.launches)
    power = compare_power(arguments.samples, arguments.launches)
    draw(power, second_bounces(arguments.samples, arguments.launches))


if __name__ == "__main__":
    main()
