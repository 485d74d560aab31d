"""What a turn costs: errors of its mesh, peers on the same triangles, seconds, memory.

Seconds depend on the machine and on what else runs there: they are recorded, and nothing is required of them.
"""

from __future__ import annotations

import json
import os
import statistics
import subprocess
import sys

import numpy as np
from matplotlib.figure import Figure
from numpy.typing import NDArray

import seamap_rt as sr
from seamap_rt.report import style
from seamap_rt.session.driver import real_time_factor
from seamap_rt.simulation import Simulator

from .. import ROOT
from ..light.share import SEAS, shares
from ..report import Case, Check, Outcome
from ..report.checks import at_most, between, recorded
from ..speed import peers, speed_error
from ..speed.peers_power import RANGE_M, compare_power, rays_needed, seconds_of
from ..speed.peers_rays import PACKAGE, compare_rays
from ..speed.peers_turn import case as peers_turn
from ..speed.peers_turn import one_antenna
from ..speed.speed import run_figures, turn_times
from ..speed.speed_error_figure import QUANTITIES, figure_of
from ..speed.speed_error_setups import FINE_SPLINE, Bench, Errors, Mesh, Reference, expected_maps

Array = NDArray[np.float64]
HEIGHT, POWER = QUANTITIES[:2]
BESIDE = (Mesh(0.5, 4), Mesh(0.8, 6), Mesh(1.25, 4), Mesh(2.0, 3))
REFERENCE = speed_error.QUICK.reference
MOST_DIFFER, MOST_POWER = 0.02, 2.0  # percent
TRACERS = ("facets", "horizon")
TURNS = {False: 80, True: 600}  # by full
QUICK_SEAS = ("0.7 m 4 s, 3 m mast", "4 m 10 s, 20 m mast")  # on which the mesh was not set
FLAT = 5.0  # percent


# ------------------------------------------------------------------------------------------------- the mesh


def default_mesh(full: bool) -> Outcome:
    bench = Bench()
    seen = _share_checks(full)
    if full:
        drawn = speed_error.measured(bench, speed_error.NORMAL, rounds=3)
        own = next(point.errors for point in drawn.of("facets") if point.mesh == bench.default)
        checks = _mesh_checks(bench, own, drawn.reference)
        return Outcome((*checks, *seen), figure_of(drawn), "Errors against seconds.")
    reference = Reference.of(bench, REFERENCE, bench.sea(FINE_SPLINE))
    errors = {
        mesh: Errors.of(expected_maps(bench, mesh, ("facets",))["facets"], reference.maps)
        for mesh in (bench.default, *BESIDE)
    }
    caption = f"Errors of meshes against {REFERENCE}, whose own error is the dotted line; required: the shaded part."
    checks = _mesh_checks(bench, errors[bench.default], reference)
    return Outcome((*checks, *seen), draw_meshes(errors, bench.default, reference), caption)


def _share_checks(full: bool) -> list[Check]:
    """The visible share, with its sign: of one that is always too large nothing averages out."""
    checks = []
    for name in SEAS if full else QUICK_SEAS:
        off = 100.0 * shares(name, 2 if full else 1).off
        least, most = float(np.nanmin(off)), float(np.nanmax(off))
        checks.append(
            between(f"visible share, {name}: least of all rings, over that of a fine mesh", least, -2.0, 2.0, "%")
        )
        checks.append(between("the same, most", most, -2.0, 2.0, "%"))
    return checks


def _mesh_checks(bench: Bench, own: Errors, reference: Reference) -> tuple[Check, ...]:
    detail = bench.whole.scene.detail
    looks = ", ".join(f"{name} {1e3 * each[0]:.1f} mm and {each[1]:.2f} dB" for name, each in own.sectors.items())
    return (
        at_most("rms error of expected heights, 15–400 m", 1e3 * own.window[0], 1e3 * HEIGHT.allowed, "mm"),
        at_most("rms error of echo power", own.window[1], POWER.allowed, "dB"),
        at_most("the reference's own error", 1e3 * reference.residual[0], 0.25e3 * HEIGHT.allowed, "mm"),
        at_most("the reference's own error", reference.residual[1], 0.25 * POWER.allowed, "dB"),
        recorded("by look", looks),
        recorded(
            "predicted for the worst look", f"{1e3 * detail.height_error_m:.1f} mm, {detail.power_error_db:.2f} dB"
        ),
    )


@style.styled
def draw_meshes(errors: dict[Mesh, Errors], default: Mesh, reference: Reference) -> Figure:
    figure = style.new_figure(2.9)
    for number, quantity in enumerate((HEIGHT, POWER)):
        axes = style.place(figure, 0.6 + 3.6 * number, 0.35, 2.9, 2.1)
        style.graph(axes, "triangles a m² at 100 m", f"rms error, {quantity.unit}", f"{'ab'[number]}) {quantity.name}")
        for mesh, each in errors.items():
            density = 2.0 * mesh.columns / (mesh.facet_m * 100.0 * np.radians(1.8))
            error = quantity.scale * each.window[number]
            mark, ink = ("*", style.BLACK) if mesh == default else ("o", style.BLUE)
            axes.loglog(density, error, mark, color=ink, markersize=8 if mesh == default else 4)
            axes.annotate(str(mesh), (density, error), (4, 4), textcoords="offset points", fontsize=6, rotation=30)
        axes.axhspan(1e-9, quantity.scale * quantity.allowed, color=style.BLUE, alpha=0.08, linewidth=0.0)
        residual = quantity.scale * reference.residual[number]
        axes.axhline(residual, color=style.GREY, linestyle=":", linewidth=0.9)
        axes.set_xlim(0.5, 12.0)
        axes.set_xticks([0.5, 1, 2, 5, 10], ["0.5", "1", "2", "5", "10"])
        steps = [1, 2, 3, 5, 10, 20, 30] if quantity is HEIGHT else [0.03, 0.05, 0.1, 0.2, 0.3, 0.5]
        axes.set_yticks(steps, [f"{step:g}" for step in steps])
        axes.set_ylim(0.7 * residual, 2.5 * quantity.scale * quantity.allowed)
        axes.minorticks_off()
    return figure


# ---------------------------------------------------------------------------------------------------- peers


def beside_peers(full: bool) -> Outcome:
    turn, repeat, most = peers_turn({}), 7 if full else 1, 30_000_000 if full else 3_000_000
    rays = compare_rays(turn, repeat)
    samples = [most // 10, 3 * most // 10, most]
    power = compare_power(one_antenna(turn), samples, repeat, cut=8 if full else 4)
    checks: list[Check] = []
    for row in rays.rows:
        if row.off_edge >= 0 and row.name != PACKAGE:
            name = row.name.strip()
            checks.append(at_most(f"{name}: answers unlike the package's rays", 100.0 * row.differ, MOST_DIFFER, "%"))
            checks.append(at_most(f"{name}: of them off an edge of shadow", row.off_edge, 0))
    off = 100.0 * power.bias
    checks.append(
        between(f"PathSolver's power at {RANGE_M} m over the points' sum, less 1", off, -MOST_POWER, MOST_POWER, "%")
    )
    error = power.error[RANGE_M]
    words = ", ".join(f"{each.rays:.0e}: {miss:.0%}" for each, miss in zip(power.samples, error, strict=True))
    checks.append(recorded("PathSolver's rms error of a cell by its rays", words))
    for name, (miss, spent) in power.tracers.items():
        times = seconds_of(power, rays_needed(power, miss)) / spent
        checks.append(
            recorded(f"{name}: its error, and PathSolver's seconds for that over its own", f"{miss:.1%}, {times:.0f} ×")
        )
    checks.append(recorded("the ray stage's speed over ray_test's in the same scene", f"{rays.of_own_floor:.2f}"))
    checks.append(recorded("and over ray_test's with all triangles, not watertight", f"{rays.of_floor:.2f}"))
    return Outcome(
        tuple(checks), peers.drawn(power, rays), "Engines on the same triangles; seconds are this machine's."
    )


# -------------------------------------------------------------------------------------------- seconds, memory


def real_time(full: bool) -> Outcome:
    checks = []
    for tracer in TRACERS:
        simulator = Simulator(sr.load_scene("choppy_sea", {"tracing.tracer": tracer}))
        warm = turn_times(simulator, 6 if full else 3)[1:]
        middle = {stage: statistics.median(row[stage] for row in warm) for stage in warm[0]}
        stages = ", ".join(f"{stage} {middle[stage]:.2f}" for stage in ("sea", "mesh", "trace", "echoes", "retrieve"))
        factor = real_time_factor(simulator.scene.turn_duration_s, run_figures(simulator, 6 if full else 3))
        checks.append(recorded(f"choppy_sea, {tracer}", f"{factor:.2f} of real time (s: {stages})"))
    return Outcome(tuple(checks))


def flat_memory(full: bool) -> Outcome:
    checks, held = [], {}
    for tracer, through in (("facets", "simulate"), ("horizon", "run")):
        each = held[f"{through}, {tracer}"] = _march(tracer, TURNS[full], through)
        part = each.size // 5
        grown = 100.0 * float(np.median(each[-part:]) / np.median(each[2 * part : 3 * part]) - 1.0)
        words = f"{through}, {tracer}: memory of the last {part} turns over that of the {part} in the middle, less 1"
        checks.append(at_most(words, grown, FLAT, "%"))
    return Outcome(tuple(checks), draw_memory(held), "Memory that the process holds at the start of each turn.")


def _march(tracer: str, turns: int, through: str) -> Array:
    """(turn,) bytes, in a process of its own with one arena: otherwise memory depends on the order of threads."""
    command = [
        sys.executable,
        "-m",
        f"{__name__.rpartition('.cases')[0]}.speed.scaling",
        "--call",
        json.dumps(["march", tracer, turns, through]),
    ]
    alone = {**os.environ, "MALLOC_ARENA_MAX": "1"}
    done = subprocess.run(command, cwd=ROOT, env=alone, capture_output=True, text=True, check=False)
    if done.returncode:
        raise RuntimeError(f"{through}, {tracer}: {(done.stderr.strip().splitlines() or ['killed'])[-1]}")
    return np.array(json.loads(done.stdout.splitlines()[-1])["seen"])[:, 0]


@style.styled
def draw_memory(held: dict[str, Array]) -> Figure:
    figure = style.new_figure(2.6)
    axes = style.place(figure, 0.7, 0.35, 6.0, 1.8)
    style.graph(axes, "turn", "MB", "Memory held")
    for ink, (name, each) in zip((style.BLUE, style.VERMILION), held.items(), strict=True):
        axes.plot(np.arange(each.size), each / 1e6, color=ink, label=name)
    axes.set_ylim(bottom=0.0)
    axes.legend()
    return figure


CASES: list[Case] = [
    Case(
        name="default_mesh",
        group="speed",
        title="The default mesh against a converged one",
        rationale="Facets as large as errors allow are what makes a turn fast; this is what they cost.",
        setup=f"choppy_sea, expected maps of 30° up the waves and 30° along the crests, against {REFERENCE} lit by the "
        f"horizon on a finer spline (with --full {speed_error.NORMAL.reference}, 14 more meshes and their seconds)",
        expectation=f"rms of cells more than half visible: {1e3 * HEIGHT.allowed:g} mm and {POWER.allowed:g} dB, a "
        "third of what speckle and noise leave at their least. The reference's own error a quarter of that at most. "
        "The visible share of each ring, 25–400 m, to 2 % of it with its sign: 16 times as many facets see that.",
        run=default_mesh,
    ),
    Case(
        name="peers",
        group="speed",
        title="Peers on the same triangles",
        rationale="Others' engines must find the same light and power, and say what speed there is to be had.",
        setup="A turn of choppy_sea: this package, Mitsuba's ray_test, Sionna's line of sight and PathSolver with up "
        "to 3 million rays, with --full 30 million",
        expectation=f"Answers differ on less than {MOST_DIFFER:g} % and beside edges of shadow. PathSolver's power in "
        f"the range bin agrees with many points a facet to {MOST_POWER:g} %: 2000 cells of 25 % each leave 0.6 %. "
        "Ratios of seconds are for the record.",
        run=beside_peers,
    ),
    Case(
        name="real_time",
        group="speed",
        title="Turns beside their own duration",
        rationale="A study of many turns wants them in real time.",
        setup="choppy_sea: the simulated time of a run's warm turns over their wall time, maps and files included",
        expectation="For the record: seconds are this machine's.",
        run=real_time,
    ),
    Case(
        name="flat_memory",
        group="speed",
        title="Memory over turns",
        rationale="An hour of turns must fit where one turn does.",
        setup=f"A small scene over {TURNS[False]} turns, with --full {TURNS[True]}, simulated alone and run whole",
        expectation=f"Flat to {FLAT:g} %: what leaks 0.7 MB a turn exceeds it.",
        run=flat_memory,
    ),
]
