"""Speed against error: the seconds of each setup to compute a turn of `choppy_sea`, and the errors of its maps.

    python -m validation.speed.speed_error [--quick | --full] [--repeat 3] [--out validation/figures]

Setups differ in tracer, size of facets, columns a beam, the spline that the sea is taken from, and pulses kept. Each is

* timed: warm whole turns by stage, all setups once a round; medians over the rounds. The tracers light the same mesh
  one after the other, so that they differ in nothing else. Truth and retrieval are not counted.
* judged: the speckle-averaged maps (`expected_look_gates`) of 30° up the waves and 30° along the crests, with the same
  sea and calibration, against those of a fine mesh lit by `horizon`, on a sea of a finer spline. rms over the cells of
  3 m × 1.8° of 15 to 400 m that are more than half visible there.

The reference's own error follows from how the last two halvings of its spacings converge. It is the error bar: by the
triangle inequality no rms is wrong by more. Fewer pulses leave the expectation as it is; what they cost is seen in
retrieved heights, speckle and noise included, of 30° up the waves, over seeds.

Printed: every setup; the Pareto front in seconds, height and power; whether the defaults are on it. The figure: error
against seconds. Four minutes on two cores; --quick, of five meshes, one; --full, of 45 and eight seeds, a quarter of an
hour, and there the reference itself is compared with one of half its spacings (8 GB).
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from seamap_rt.compute.backend import prepare

from .. import FIGURES
from ..options import options
from .speed_error_figure import QUANTITIES, TARGET_S, Drawn, Kept, draw
from .speed_error_setups import (
    FINE_SPLINE,
    OWN_SPLINE,
    STAGES,
    TRACERS,
    Array,
    Bench,
    Errors,
    Mesh,
    Point,
    Reference,
    Spline,
    Timed,
    crossed,
    expected_maps,
    front,
    retrieved_errors,
    rms,
    take_turns,
)

JUDGED_BY = (0, 1)  # height and power
SAME_S = 0.03  # share of the seconds that a second run of this script may be off by


@dataclass(frozen=True)
class Plan:
    """What is tried."""

    meshes: Sequence[Mesh]
    reference: Mesh
    splines: Sequence[Spline]
    kept: Sequence[int]  # one pulse in so many
    seeds: int
    finer: bool = False  # whether the reference is held against a finer one


SPLINES = (Spline(3, 1.25), Spline(7, 1.25), Spline(7, 1.25, 2.0), FINE_SPLINE)  # beside the sea's own
QUICK = Plan(
    [Mesh(0.5, 4), Mesh(0.8, 3), Mesh(0.8, 6), Mesh(1.25, 4)], Mesh(0.25, 12), (SPLINES[0], FINE_SPLINE), (1, 4), 1
)
NORMAL = Plan(
    [*crossed((0.25,), (3, 4, 6)), *crossed((0.5, 0.8, 1.25, 2.0), (3, 4, 6, 12))],
    Mesh(0.125, 24),
    SPLINES,
    (1, 2, 4),
    3,
)
FULL = Plan(
    [
        *crossed((0.25,), (3, 4, 5, 6)),
        *crossed((0.35,), (3, 4, 5, 6, 8)),
        *crossed((0.5, 0.65, 0.8, 1.0, 1.25, 2.0), (3, 4, 5, 6, 8, 12)),
    ],
    Mesh(0.125, 24),
    SPLINES,
    (1, 2, 4, 8),
    8,
    finer=True,
)


def measured(bench: Bench, plan: Plan, rounds: int) -> Drawn:
    """Everything that the tables and the figure show."""
    fine = bench.sea(FINE_SPLINE)
    reference = Reference.of(bench, plan.reference, fine)
    meshes = [bench.default, *(mesh for mesh in plan.meshes if mesh != bench.default)]
    errors = {mesh: expected_maps(bench, mesh) for mesh in meshes}
    seas = {spline: bench.sea(spline) for spline in plan.splines}
    coarse = {spline: expected_maps(bench, bench.default, ("facets",), sea)["facets"] for spline, sea in seas.items()}

    timed = {mesh: Timed(bench.simulator(mesh)) for mesh in meshes}
    splined = {spline: Timed(bench.simulator(bench.default, sea=sea)) for spline, sea in seas.items()}
    thinned = {kept: Timed(bench.simulator(bench.default, kept=kept)) for kept in plan.kept if kept > 1}
    take_turns([*timed.values(), *splined.values(), *thinned.values()], rounds)
    points = [
        Point(tracer, mesh, timed[mesh], Errors.of(errors[mesh][tracer], reference.maps))
        for tracer in TRACERS
        for mesh in meshes
    ]
    exact = coarse.get(FINE_SPLINE)
    splines = {}
    for spline, maps in {OWN_SPLINE: errors[bench.default]["facets"], **coarse}.items():
        turns = splined.get(spline, timed[bench.default])
        alone = np.zeros(len(QUANTITIES)) if exact is None else rms(maps - exact, reference.maps.cells())
        splines[spline] = Point("facets", bench.default, turns, Errors.of(maps, reference.maps)), alone
    return Drawn(points, bench.default, reference, splines, _kept(bench, plan, {1: timed[bench.default], **thinned}))


def _kept(bench: Bench, plan: Plan, timed: dict[int, Timed]) -> list[Kept]:
    """By how many pulses are kept: seconds, and errors of retrieved heights by seed."""
    sector = "up the waves"
    return [
        Kept(
            kept,
            timed[kept],
            np.array([retrieved_errors(seed, kept, bench.default, sector) for seed in range(1, plan.seeds + 1)]),
        )
        for kept in plan.kept
    ]


# ------------------------------------------------------------------------------------------------------- tables


def _shown(errors: Array) -> str:
    return ", ".join(f"{q.name} {q.scale * e:.2g} {q.unit}" for q, e in zip(QUANTITIES, errors, strict=True))


def print_reference(bench: Bench, reference: Reference, plan: Plan) -> None:
    order = ", ".join(f"{q.name} {p:.2f}" for q, p in zip(QUANTITIES, reference.order, strict=True))
    cells = np.count_nonzero(reference.maps.cells())
    print(f"Dr.Jit runs on {prepare().variant}. The reference is {plan.reference}, {FINE_SPLINE}: {cells} cells.")
    print(f"Errors fall as the spacings to the power of: {order}.\n  Its own: {_shown(reference.residual)}")
    if plan.finer:
        mesh = Mesh(0.5 * plan.reference.facet_m, 2 * plan.reference.columns)
        missed = expected_maps(bench, mesh, ("horizon",), bench.sea(FINE_SPLINE))["horizon"]
        print(f"  and it differs from {mesh} by {_shown(rms(reference.maps - missed, missed.cells()))}")


def _numbers(values: Array) -> str:
    return " ".join(f"{q.scale * v:8.3g}" for q, v in zip(QUANTITIES, values, strict=True))


def print_setups(drawn: Drawn) -> None:
    """A line a setup."""
    print(f"\n{'tracer':8} {'mesh':>10} {'facets':>8} " + " ".join(f"{stage:>6}" for stage in STAGES), end="")
    print(
        f" {'s':>7} {'least–most':>11}  " + " ".join(f"{f'{q.name[:7]}':>8}" for q in QUANTITIES) + "  50–200 m:",
        end="",
    )
    print("   mm      dB   predicted:  mm      dB")
    for point in drawn.points:
        stages = " ".join(f"{point.timed.stage(stage, point.tracer):6.3f}" for stage in STAGES)
        rounds = point.timed.totals(point.tracer)
        near, detail = point.errors.headline, point.timed.simulator.scene.detail
        print(
            f"{point.tracer:8} {point.mesh!s:>10} {point.timed.facets:8d} {stages} {point.seconds:7.3f} "
            f"{f'{rounds.min():.2f}–{rounds.max():.2f}':>11}  {_numbers(point.errors.window)}        "
            f"{1e3 * near[0]:8.3g} {near[1]:7.3g}     {1e3 * detail.height_error_m:11.3g} {detail.power_error_db:7.3g}"
        )
    units = ", ".join(f"{q.name} {q.unit}" for q in QUANTITIES)
    print(
        f"rms in {units}: cells more than half visible, 15–400 m; then height and power of those of 50–200 m, "
        "and as predicted (15–400 m, the worst look)"
    )


def print_front(drawn: Drawn, tracer: str) -> None:
    """The setups than which none is better in seconds, height and power, and their errors where little is seen."""
    print(f"\nfront of {tracer}: seconds, height mm, power dB; by look; of all cells of which anything is seen")
    for point in front(drawn.of(tracer), JUDGED_BY):
        errors = point.errors
        looks = ", ".join(f"{name} {1e3 * each[0]:.3g} / {each[1]:.3g}" for name, each in errors.sectors.items())
        mark = "default" if point.mesh == drawn.default else ""
        lit, median = errors.lit, errors.lit_median
        print(
            f"  {point.mesh!s:>10} {mark:7} {point.seconds:6.3f} {1e3 * errors.window[0]:6.3g} {errors.window[1]:6.3g}"
            f"   {looks};   rms {1e3 * lit[0]:.3g} / {lit[1]:.3g}, median {1e3 * median[0]:.2g} / {median[1]:.2g}, "
            f"no height in {errors.dark:.2%}"
        )


def print_splines(drawn: Drawn) -> None:
    print(f"\nthe sea's spline, facets {drawn.default}: seconds of the sea; errors; those of the spline alone")
    for spline, (point, alone) in drawn.splines.items():
        mark = "own" if spline == OWN_SPLINE else ""
        print(
            f"  {spline!s:30} {mark:4} {point.timed.stage('sea', 'facets'):6.3f}  {_numbers(point.errors.window)}   "
            f"{_numbers(alone)}"
        )


def print_kept(drawn: Drawn) -> None:
    print(f"\npulses kept, facets {drawn.default}: seconds; retrieved heights' rms, and more than with all of them")
    whole = drawn.kept[0].errors
    for each in drawn.kept:
        number = len(each.errors)
        mean = 1e3 * each.errors.mean(axis=0)
        more = each.errors / whole - 1.0
        spread = more.std(axis=0, ddof=1) / np.sqrt(number) if number > 1 else np.full(2, np.nan)
        print(
            f"  one in {each.kept}: echoes {each.timed.stage('echoes', 'facets'):.3f} s, turn "
            f"{np.median(each.timed.totals('facets')):.3f} s; {mean[0]:.0f} mm, of 50–200 m {mean[1]:.0f} mm; "
            f"{more.mean(axis=0)[0]:+.1%} ± {spread[0]:.1%}, {more.mean(axis=0)[1]:+.1%} ± {spread[1]:.1%}"
        )
    _beside(drawn)


def _beside(drawn: Drawn) -> None:
    """How much of retrieved heights' errors is the mesh's."""
    (own,) = (point for point in drawn.of("facets") if point.mesh == drawn.default)
    by_mesh = np.array([own.errors.window[0], own.errors.headline[0]])
    more = np.hypot(1.0, by_mesh / drawn.kept[0].errors.mean(axis=0)) - 1.0
    print(f"  of which the mesh's own errors are {more[0]:.2%} and, of 50–200 m, {more[1]:.2%}, if they add as squares")


def print_verdict(drawn: Drawn) -> None:
    """Whether the defaults are on the front, and whether they hit the targets."""
    detail, judged = drawn.detail, [*JUDGED_BY]
    allowed = np.array([QUANTITIES[n].allowed for n in judged])
    predicted = f"{1e3 * detail.height_error_m:.3g} mm, {detail.power_error_db:.2g} dB"
    print(f"\nthe defaults, {drawn.default}, are predicted to err by {predicted} on their worst look")
    for tracer in TRACERS:
        points = drawn.of(tracer)
        (own,) = (point for point in points if point.mesh == drawn.default)
        errors, most = own.errors.window[judged], (1.0 - SAME_S) * own.seconds
        beaten = [p for p in points if p.seconds < most and (p.errors.window[judged] <= errors).all()]
        print(f"{tracer}: defaults on the front: {'no' if beaten else f'yes, to {SAME_S:.0%} of the seconds'}", end="")
        print("".join(f"; {p.mesh} is no worse and takes {1.0 - p.seconds / own.seconds:.0%} less" for p in beaten))
        right = [p for p in points if (p.errors.window[judged] <= allowed).all()]
        for best in sorted(right, key=lambda p: p.seconds)[:1]:
            print(
                f"  the fastest within 20 mm and 0.3 dB: {best.mesh}, {best.seconds / own.seconds:.0%} of their seconds"
            )
        print(
            f"choppy_sea {tracer}: {own.seconds:.2f} s a turn, height error {1e3 * errors[0]:.3g} mm, "
            f"power {errors[1]:.2g} dB (required: {TARGET_S[tracer]:.2g} s, 20 mm, 0.3 dB)"
        )


def main() -> None:
    arguments = options(__doc__, quick=False, full=False, repeat=int, out=FIGURES)
    plan = QUICK if arguments.quick else FULL if arguments.full else NORMAL
    bench = Bench()
    drawn = measured(bench, plan, arguments.repeat or (2 if arguments.quick else 3))
    print_reference(bench, drawn.reference, plan)
    print_setups(drawn)
    for tracer in TRACERS:
        print_front(drawn, tracer)
    print_splines(drawn)
    print_kept(drawn)
    print_verdict(drawn)
    draw(drawn, arguments.out / "speed_error.png")


if __name__ == "__main__":
    main()
