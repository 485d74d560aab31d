"""The ray stage and its peers on the same triangles: Sionna's PathSolver as shipped, trimesh's engines, raw Mitsuba.

    python -m validation.speed.peers [--quick] [--repeat 7] [--samples 30000000] [--out validation/figures]

One turn of `choppy_sea`, meshed as by default; all engines in one run, interleaved, medians of wall seconds. Shown:

1. Power. PathSolver launches its rays over the whole sphere. How many does it need until the echo power of a Lambertian
   sea has 10 % error (rms) in cells of 3 m and 1.8° at 200 m that are more than half lit, and how many for the error
   that the tracers have? And how many seconds are that, beside tracers `facets` and `horizon`, and a march of the
   profiles in plain NumPy, with the sum of the radar
   equation over what they light: the power in every cell of the turn at one antenna. Errors are against 64 points a
   facet, each with a shadow ray of its own, and so are those of the tracers' one point a facet. PathSolver's seconds
   are without the scene's tree; those of `facets` without it (its ray stage) and with it.
2. Rays a second, and by how many answers engines differ: the package's rays traced by the package, of Mitsuba's
   `ray_test` with all arrays on the device (the floor), of Embree by trimesh (`pip install embreex`), of trimesh's own
   engine on a few rays of a narrow sector (`pip install rtree`); and the horizon in float64, compiled and in NumPy.
3. The tree (BVH): the package's update compared with a bare Mitsuba scene of all triangles.

Whoever knows a faster way for a rival is asked to mend it: `peers_rays.py` and `peers_power.py` hold a few lines each.
RadarSimPy is not on the package index, and so has no row.
"""

from __future__ import annotations

import argparse
import importlib
import importlib.util
import statistics
from pathlib import Path

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.ticker import LogLocator, NullFormatter

from seamap_rt.compute.machine import peak_memory
from seamap_rt.report.style import BLACK, BLUE, GREEN, GREY, SKY, VERMILION, graph, new_figure, place, png, styled

from .. import FIGURES
from .peers_power import (
    CELL_DEG,
    CELL_M,
    RANGE_M,
    RANGES_M,
    Power,
    compare_power,
    rays_needed,
    seconds_of,
    slope_of,
)
from .peers_rays import Rays, compare_rays
from .peers_turn import case, one_antenna

REQUIRED = 0.10
FASTER, OF_FLOOR = 100.0, 0.8  # what is claimed


def yes(held: bool) -> str:
    return "yes" if held else "NO"


def print_power(power: Power, turn: float) -> None:
    kept, every = power.kept
    print(f"\nEcho power of a Lambertian sea in cells of {CELL_M:g} m × {CELL_DEG:g}° at {RANGE_M} m, at one antenna;")
    print(f"rms error of the {kept} of {every} cells that are more than half lit; PathSolver as shipped")
    print(f"{'rays':>10} {'s':>8} {'paths a cell':>13} {'error':>8} {'1/√paths':>9} {'against lit facets':>19}")
    for each, error, loose, other in zip(
        power.samples, power.error[RANGE_M], power.loose[RANGE_M], power.against_sum, strict=True
    ):
        row = f"{each.rays:10.2g} {each.seconds:8.2f} {loose**-2:13.3g} {error:8.1%} {loose:9.1%} {other:19.1%}"
        print(row, flush=True)
    print(f"all power of the range bin by the most rays: {power.bias:+.2%} of the points' sum")
    print(f"the last errors fall as rays^{slope_of(power):.2f}: its lattice is better than loose rays (−0.50)")
    for name, (error, spent) in power.tracers.items():
        required, own = (seconds_of(power, rays_needed(power, aim)) / spent for aim in (REQUIRED, error))
        by_root = seconds_of(power, rays_needed(power, REQUIRED, slope=-0.5)) / spent
        print(
            f"{name:22} {error:6.1%} error, {spent:.4f} s: PathSolver takes {required:.0f} × for {REQUIRED:.0%} "
            "(by 1/√N from"
        )
        print(f"{'':22} the last {by_root:.0f} ×), {own:.0f} × for the same error; ≥ {FASTER:g} ×: "
              f"{yes(required >= FASTER)}, {yes(own >= FASTER)}")  # fmt: skip
    rays = rays_needed(power, REQUIRED)
    known = "measured" if rays <= power.samples[-1].rays else "extrapolated"
    print(f"{REQUIRED:.0%} takes {rays:.2g} rays and {seconds_of(power, rays):.1f} s ({known})")
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


def draw(power: Power, rays: Rays, path: Path) -> None:
    path.parent.mkdir(parents=True, exist_ok=True)
    path.write_bytes(png(drawn(power, rays)))
    print(f"\n{path}")


@styled
def drawn(power: Power, rays: Rays) -> Figure:
    figure = new_figure(3.3)
    _draw_error(place(figure, 0.55, 0.3, 1.85, 2.4), power)
    _draw_seconds(place(figure, 2.8, 0.3, 1.75, 2.4), power)
    _draw_rates(place(figure, 6.05, 0.3, 1.05, 2.4), rays)
    return figure


def _draw_error(axes: Axes, power: Power) -> None:
    graph(axes, "rays over the sphere", "rms error of a cell's power, %", "a) PathSolver as shipped")
    count = [each.rays for each in power.samples]
    for middle, colour in RANGES_M.items():
        axes.loglog(count, 100.0 * power.error[middle], "o-", color=colour, markersize=2.5, label=f"{middle} m")
        axes.loglog(count, 100.0 * power.loose[middle], ":", color=colour, linewidth=0.8)
    axes.axhline(100.0 * REQUIRED, color=GREY, linewidth=0.8)
    axes.plot([], [], ":", color=GREY, linewidth=0.8, label="1/√paths")
    axes.set_xticks(count, [f"{each / 1e6:.2g} M" for each in count])
    axes.xaxis.set_minor_formatter(NullFormatter())
    _plain(axes)
    axes.legend(fontsize=6, loc="lower left", handlelength=1.5)


def _plain(axes: Axes) -> None:
    """Percentages in plain digits; where the axis is short its 2, 3 and 5 are named too."""
    low, high = axes.get_ylim()
    between = "{x:g}" if high < 30.0 * low else ""
    axes.yaxis.set_major_formatter("{x:g}")
    axes.yaxis.set_minor_locator(LogLocator(subs=(2.0, 3.0, 5.0)))
    axes.yaxis.set_minor_formatter(between)
    axes.tick_params(axis="y", which="minor", labelsize=6)


def _draw_seconds(axes: Axes, power: Power) -> None:
    graph(axes, "seconds for all cells of the turn", "", f"b) at {RANGE_M} m")
    spent, error = np.array([each.seconds for each in power.samples]), 100.0 * power.error[RANGE_M]
    axes.loglog(spent, error, "o-", color=VERMILION, markersize=2.5, label="PathSolver")
    least = min(error for error, _ in power.tracers.values())
    at = seconds_of(power, rays_needed(power, least))
    axes.loglog([spent[-1], at], [error[-1], 100.0 * least], "--", color=VERMILION, linewidth=0.8)
    for (name, (miss, takes)), colour in zip(power.tracers.items(), (SKY, BLUE, GREEN, BLACK), strict=True):
        faster = seconds_of(power, rays_needed(power, miss)) / takes
        axes.loglog(takes, 100.0 * miss, "s", color=colour, markersize=4, label=f"{name}, {faster:.0f} ×")
    axes.axhline(100.0 * REQUIRED, color=GREY, linewidth=0.8)
    axes.set_ylim(bottom=60.0 * least)
    axes.set_xlim(left=0.02 * min(takes for _, takes in power.tracers.values()))  # room for what the marks are
    _plain(axes)
    axes.legend(loc="center left", fontsize=5.5, title="how many times as fast\nfor the same error", title_fontsize=5.5)


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

    for name, what in (("embreex", "Embree by trimesh"), ("rtree", "trimesh's own engine")):
        if importlib.util.find_spec(name) is None:
            print(f"no {name} here: `pip install {name}` to see {what}")
    made = case(dict(pair.split("=", 1) for pair in arguments.set))
    grid = made.facets.grid
    rays = compare_rays(made, repeat)
    variant = importlib.import_module("mitsuba").variant()
    print(f"choppy_sea, {grid.columns} columns × {made.facets.distance.size} facets; Dr.Jit runs {variant}")
    print_rays(rays)
    power = compare_power(one_antenna(made), samples, repeat, cut=4 if quick else 8)
    turns = [made.simulator.turn(number).timing for number in range(2 if quick else 4)][1:]
    print_power(power, statistics.median(timing["trace"] + timing["echoes"] for timing in turns))
    print(f"peak memory {peak_memory() / 2**30:.1f} GiB")
    draw(power, rays, arguments.out / "peers.png")


if __name__ == "__main__":
    main()
