"""How time and memory grow with range, facets, sector and turns; and how a scene that is too large is refused.

    python -m validation.speed.scaling [--quick] [--turns 600] [--repeat 3] [--out validation/figures]

Each point is `choppy_sea` with one thing changed, in a process of its own: the median seconds of its warm turns by
stage, and the most memory the process held beyond what its imports take. Ranges run from 200 m to 3 km over a sector of
20° (waves are resolved to 1.6 m there, for a patch that covers 3 km), facets from 10⁴ to 10⁷ in a sector of 30°,
sectors from 10° to the whole circle. Slopes are of log over log between the larger half of the points; memory beyond
the smallest point's is also given per facet. Then a small scene turns on for 600 turns: streamed into a folder by
`simulate` (facets), and through `run`, which also retrieves and writes maps (horizon). Held against turns 20 to 120 are
the memory and the seconds of the last 100; a turn that is slower or a process that grows is a failed verdict. Last come
the refusals, one after the other, that 3 km round the circle meet until the scene fits.

The whole takes some four minutes of two idle cores and 8 GB; --quick, three points a sweep and 60 turns, one minute. On
a CUDA machine it runs as it is; the table's head says which of Dr.Jit's variants traced. The figure is scaling.png.
"""

from __future__ import annotations

import argparse
import gc
import json
import os
import statistics
import subprocess
import sys
import tempfile
import time
from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

import seamap_rt as sr
from seamap_rt.compute.backend import prepare
from seamap_rt.compute.machine import peak_memory
from seamap_rt.errors import InputError
from seamap_rt.report import style
from seamap_rt.scene.water_checks import BYTES_PER_TRIANGLE
from seamap_rt.session import run, simulate
from seamap_rt.simulation import Simulator

from .. import FIGURES, ROOT

STAGES = {
    "sea": style.SKY,
    "mesh": style.GREEN,
    "trace": style.VERMILION,
    "echoes": style.BLUE,
    "truth": style.PURPLE,
    "turn": style.BLACK,
}
EXTENTS_M = {200.0: 512.0, 400.0: 1024.0, 800.0: 2048.0, 1500.0: 3072.0, 3000.0: 6144.0}
MESHES = ((5.0, 3), (1.5, 3), (0.8, 4), (0.4, 6), (0.2, 10), (0.1, 16), (0.06, 32))  # 10⁴ to 10⁷ facets in 30°
SECTORS_DEG = (10.0, 30.0, 90.0, 180.0, 360.0)
SMALL = {"radar.sector_deg": [255.0, 285.0], "radar.range_m": [15.0, 60.0], "sea.extent_m": 192.0}
EARLY, LATE = slice(20, 120), 100  # turns that are warm; how many of the last are held against them
FLAT = 1.05  # of memory; of seconds too, whose medians over 100 turns a busy machine moves as much
CELLS = 12  # characters

Keys = dict[str, Any]
Array = NDArray[np.float64]


@dataclass(frozen=True)
class Sweep:
    """Points that differ in one thing."""

    name: str  # what it is called in the table
    label: str
    changes: dict[float, Keys]  # by the value of that thing
    tracer: str = "facets"


@dataclass(frozen=True)
class Point:
    """What one process measured."""

    value: float
    facets: int
    pulses: int
    seconds: dict[str, float]  # of a warm turn, by stage
    first: float  # s, of the first turn with all that is made and compiled once
    memory: float  # bytes beyond the imports, at most
    imports: float  # bytes
    variant: str


def sweeps(quick: bool) -> tuple[Sweep, ...]:
    mesh = {"tracing.facet_m": 0.8, "tracing.columns_per_beam": 4}
    ranges = {
        far: {
            "radar.range_m": [15.0, far],
            "sea.extent_m": extent,
            "sea.resolution_m": 1.6,
            "radar.sector_deg": [260.0, 280.0],
            **mesh,
        }
        for far, extent in EXTENTS_M.items()
    }
    by_columns = {"radar.sector_deg": [255.0, 285.0]}
    facets = {1.0 / f: {**by_columns, "tracing.facet_m": f, "tracing.columns_per_beam": c} for f, c in MESHES}
    sectors = {
        width: {"radar.sector_deg": [270.0 - width / 2.0, 270.0 + width / 2.0] if width < 360.0 else [0.0, 360.0]}
        | mesh
        for width in SECTORS_DEG
    }
    chosen: Callable[[dict], dict] = (lambda each: dict(list(each.items())[:3])) if quick else (lambda each: each)
    return (
        Sweep("range", "range, m", chosen(ranges)),
        Sweep("facets", "facets", chosen(facets)),
        Sweep("facets", "facets", chosen(facets), "horizon"),
        Sweep("sector", "sector, °", chosen(sectors)),
    )


# ------------------------------------------------------------------------------------------- in a process of its own


def resident() -> float:
    """Bytes of memory that this process holds; where there is no /proc, the most that it has held."""
    try:
        return int(Path("/proc/self/statm").read_text().split()[1]) * os.sysconf("SC_PAGE_SIZE")
    except OSError:
        return peak_memory()


def measure(keys: Keys, repeat: int) -> Keys:
    """The fields of a Point but its value; runs in the child."""
    scene = sr.load_scene("choppy_sea", keys)
    backend = prepare()
    if scene.tracing.tracer == "facets":
        import sionna.rt  # noqa: F401  # what importing takes is no part of the scene's memory
    imports = resident()
    start = time.perf_counter()
    simulator = Simulator(scene)
    turn = simulator.turn(0)
    first = time.perf_counter() - start
    rows = []
    for number in range(1, repeat + 1):
        turn = simulator.turn(number)
        rows.append({**turn.timing, "turn": turn.timing["total"]})
    return {
        "facets": turn.facets,
        "pulses": int(turn.echoes.sizes["pulse"]),
        "seconds": {stage: statistics.median(row[stage] for row in rows) for stage in STAGES},
        "first": first,
        "memory": peak_memory() - imports,
        "imports": imports,
        "variant": backend.variant if scene.tracing.tracer == "facets" else "none",
    }


def march(tracer: str, turns: int, through: str) -> Keys:
    """Bytes held, wall and processor seconds at the start of each turn of the small scene; runs in the child."""
    scene = sr.load_scene("choppy_sea", {**SMALL, "tracing.tracer": tracer, "turns": turns})
    seen: list[tuple[float, float, float]] = []
    turn = Simulator.turn

    def watched(self: Simulator, number: int, on_stage: Any = None) -> Any:
        seen.append((resident(), time.perf_counter(), time.process_time()))
        return turn(self, number, on_stage)

    Simulator.turn = watched
    with tempfile.TemporaryDirectory() as folder:
        (simulate if through == "simulate" else run)(scene, folder, overwrite=True)
        gc.collect()
    return {"seen": seen}


def in_a_process(call: str, *arguments: Any) -> Keys:
    """What a function of this file returns when a new process calls it. RuntimeError with its output if it failed."""
    command = [sys.executable, "-m", "validation.speed.scaling", "--call", json.dumps([call, *arguments])]
    done = subprocess.run(command, cwd=ROOT, capture_output=True, text=True, check=False)
    if done.returncode:
        said = done.stderr.strip().splitlines()[-1:] or [f"ended by signal {-done.returncode}, for want of memory?"]
        raise RuntimeError(f"{call} {arguments}: {said[0]}")
    return json.loads(done.stdout.splitlines()[-1])


# ------------------------------------------------------------------------------------------------------ the tables


def slope(x: Array, y: Array) -> float:
    """d log y / d log x over the larger half of the points, where constant costs matter less."""
    half = slice(x.size // 2 if x.size > 3 else 0, None)
    return float(np.polyfit(np.log(x[half]), np.log(np.maximum(y[half], 1e-6)), 1)[0])


def axis_of(sweep: Sweep, points: Sequence[Point]) -> Array:
    return np.array([point.facets if sweep.name == "facets" else point.value for point in points], dtype=float)


def measure_sweep(sweep: Sweep, repeat: int) -> list[Point]:
    """The points of a sweep, each printed as it comes; then the slopes."""
    print(f"\nby {sweep.name}, {sweep.tracer}")
    heads = (sweep.name, "facets", "pulses", *STAGES, "first turn", "memory GB")
    print("".join(f"{head:>{CELLS}}" for head in heads))
    points = []
    for value, keys in sweep.changes.items():
        point = Point(value=value, **in_a_process("measure", {**keys, "tracing.tracer": sweep.tracer}, repeat))
        points.append(point)
        seconds = "".join(f"{point.seconds[stage]:{CELLS}.4f}" for stage in STAGES)
        shown = f"{axis_of(sweep, [point])[0]:{CELLS}.5g}{point.facets:{CELLS}d}{point.pulses:{CELLS}d}{seconds}"
        print(f"{shown}{point.first:{CELLS}.2f}{1e-9 * point.memory:{CELLS}.3f}", flush=True)
    x = axis_of(sweep, points)
    slopes = [slope(x, np.array([point.seconds[stage] for point in points])) for stage in STAGES]
    slopes += [
        slope(x, np.array([each.first for each in points])),
        slope(x, np.array([each.memory for each in points])),
    ]
    print(f"{'slope':>{3 * CELLS}}" + "".join(f"{each:{CELLS}.2f}" for each in slopes))
    if sweep.name == "facets":
        grown = (points[-1].memory - points[0].memory) / (points[-1].facets - points[0].facets)
        print(f"{grown:.0f} bytes a facet at most; the scene's own check counts on {BYTES_PER_TRIANGLE:.0f}")
    return points


@dataclass(frozen=True)
class March:
    """Of each turn but the last."""

    label: str
    memory: Array  # (turn,) bytes at its start
    wall: Array  # (turn,) s, with all that is done between turns
    processor: Array

    @classmethod
    def of(cls, label: str, seen: list[list[float]]) -> March:
        memory, wall, processor = np.array(seen).T
        return cls(label, memory[1:], np.diff(wall), np.diff(processor))  # after each turn

    def late_over_early(self, values: Array) -> float:
        """Median of the last turns over that of the first warm ones."""
        early, late = (EARLY, LATE) if values.size >= EARLY.stop + LATE else (slice(20, 40), 20)
        return float(np.median(values[-late:]) / np.median(values[early]))

    def verdicts(self) -> Iterator[tuple[str, float, bool]]:
        """What, its ratio, and whether it is flat."""
        memory, wall, processor = map(self.late_over_early, (self.memory, self.wall, self.processor))
        yield "memory", memory, 1.0 / FLAT < memory < FLAT
        yield "wall seconds", wall, wall < FLAT
        yield "processor seconds", processor, processor < FLAT


def measure_marches(turns: int) -> list[March]:
    print(f"\n{turns} turns of a small scene: medians of the last over those of turns {EARLY.start} to {EARLY.stop}")
    marches = []
    for tracer, through in (("facets", "simulate"), ("horizon", "run")):
        each = March.of(f"{through}, {tracer}", in_a_process("march", tracer, turns, through)["seen"])
        marches.append(each)
        held = " ".join(f"{each.memory[n] / 1e6:.0f}" for n in np.linspace(0, each.memory.size - 1, 9).astype(int))
        print(f"{each.label:>18}: {np.median(each.wall):.3f} s a turn, {np.median(each.processor):.3f} of a processor")
        print(f"{'MB along the way':>18}: {held}")
        for what, ratio, flat in each.verdicts():
            print(f"{what:>18}: {ratio:.3f} {'flat' if flat else 'NOT FLAT'}")
    return marches


def show_refusals() -> None:
    """The refusals of `choppy_sea` to 3 km round the circle, each remedy taken in turn."""
    print("\nchoppy_sea, 360°, 3 km")
    keys: Keys = {"radar.range_m": [15.0, 3000.0]}
    for remedy in ({"sea.extent_m": 6144.0}, {"sea.resolution_m": 1.5}, {"tracing.facet_m": 0.1}, {}):
        settings = "\n  ".join(f"{key} = {value}" for key, value in keys.items())
        print(f"  {settings}")
        try:
            scene = sr.load_scene("choppy_sea", keys)
            detail = scene.detail
            memory = detail.facets * BYTES_PER_TRIANGLE / 1e9
            print(f"    fits: {detail.facets:.3g} facets, about {memory:.2g} GB; {detail.words()}")
        except InputError as error:
            print(f"    refused: {error}")
        keys |= remedy


# ------------------------------------------------------------------------------------------------------ the figure


@style.styled
def draw(swept: list[tuple[Sweep, list[Point]]], marches: list[March], path: Path) -> None:
    figure = style.new_figure(7.35)
    shown = [(sweep, points) for sweep, points in swept if sweep.tracer == "facets"]
    for column, (sweep, points) in enumerate(shown):
        left, x = 0.55 + 2.3 * column, axis_of(sweep, points)
        _seconds(style.place(figure, left, 0.3, 1.75, 1.9), sweep, points, swept, "abc"[column])
        axes = style.place(figure, left, 2.85, 1.75, 1.5)
        style.graph(
            axes, sweep.label, "memory beyond imports, GB" if column == 0 else "", f"{'def'[column]}) peak memory"
        )
        axes.loglog(
            x, [1e-9 * point.memory for point in points], "o-", color=style.BLACK, markersize=2.5, label="facets"
        )
        for other, measured in swept:
            if other.name == sweep.name and other.tracer == "horizon":
                memory = [1e-9 * point.memory for point in measured]
                axes.loglog(
                    axis_of(other, measured), memory, "o--", color=style.ORANGE, markersize=2.5, label="horizon"
                )
        if sweep.name == "facets":
            axes.loglog(
                x, 1e-9 * BYTES_PER_TRIANGLE * x, ":", color=style.GREY, label=f"{BYTES_PER_TRIANGLE:.0f} B a facet"
            )
            axes.legend()
        _plain_ticks(axes, x)
        axes.set_ylim(0.05, 20.0)
    _marches(style.place(figure, 0.55, 5.05, 2.9, 1.9), style.place(figure, 4.15, 5.05, 2.9, 1.9), marches)
    path.parent.mkdir(parents=True, exist_ok=True)
    path.write_bytes(style.png(figure))


def _seconds(axes: Any, sweep: Sweep, points: list[Point], swept: list[tuple[Sweep, list[Point]]], letter: str) -> None:
    x = axis_of(sweep, points)
    style.graph(axes, sweep.label, "seconds of a warm turn" if letter == "a" else "", f"{letter}) by {sweep.name}")
    for stage, colour in STAGES.items():
        y = np.array([point.seconds[stage] for point in points])
        axes.loglog(x, y, "o-", color=colour, markersize=2.5, label=f"{stage} {slope(x, y):+.2f}")
    for other, measured in swept:
        if other.name == sweep.name and other.tracer == "horizon":
            y = np.array([point.seconds["trace"] for point in measured])
            at = axis_of(other, measured)
            axes.loglog(at, y, "o--", color=style.ORANGE, markersize=2.5, label=f"horizon {slope(at, y):+.2f}")
    if sweep.name == "sector":
        axes.loglog(x, x / 360.0, ":", color=style.GREY, label="real time")
    _plain_ticks(axes, x)
    axes.set_ylim(3e-4, 300.0)
    axes.legend(fontsize=5.5, ncols=2, columnspacing=0.8, handlelength=1.2, loc="upper left")


def _plain_ticks(axes: Any, x: Array) -> None:
    """The points themselves as ticks, where they are few."""
    if x.max() < 1e4:
        axes.set_xticks(x, [f"{value:g}" for value in x])
        axes.set_xticks([], minor=True)


def _marches(memory: Any, seconds: Any, marches: list[March]) -> None:
    style.graph(memory, "turn", "memory held, MB", "g) memory over turns")
    style.graph(seconds, "turn", "seconds a turn, median of 20", "h) time over turns")
    for each, colour in zip(marches, (style.BLUE, style.ORANGE), strict=True):
        label = f"{each.label}: last/early {each.late_over_early(each.memory):.3f}"
        memory.plot(1e-6 * each.memory, color=colour, label=label)
        blocks = each.processor.size // 20
        middle = np.median(each.processor[: 20 * blocks].reshape(blocks, 20), axis=1)
        label = f"{each.label}: {each.late_over_early(each.processor):.3f}"
        seconds.plot(20 * np.arange(blocks) + 10, middle, color=colour, label=f"{label}, of a processor")
        middle = np.median(each.wall[: 20 * blocks].reshape(blocks, 20), axis=1)
        label = f"{each.late_over_early(each.wall):.3f}, of the clock"
        seconds.plot(20 * np.arange(blocks) + 10, middle, "--", color=colour, label=label)
    memory.set_ylim(0.0, 1.25 * max(1e-6 * each.memory.max() for each in marches))
    seconds.set_ylim(0.0, 1.8 * seconds.get_ylim()[1])
    memory.legend(loc="lower right")
    seconds.legend(loc="upper right")


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--quick", action="store_true", help="three points a sweep, 60 turns")
    parser.add_argument("--turns", type=int, help="of the small scene; 600, or 60")
    parser.add_argument("--repeat", type=int, default=3, help="warm turns a point")
    parser.add_argument("--out", type=Path, default=FIGURES)
    parser.add_argument("--call", help=argparse.SUPPRESS)
    arguments = parser.parse_args()
    if arguments.call:
        name, *given = json.loads(arguments.call)
        print(json.dumps({"measure": measure, "march": march}[name](*given)))
        return
    turns = arguments.turns or (60 if arguments.quick else 600)
    if turns < 50:
        parser.error(f"--turns {turns}: must be at least 50, of which 20 warm up; give 600")
    swept = [(sweep, measure_sweep(sweep, arguments.repeat)) for sweep in sweeps(arguments.quick)]
    imports = 1e-6 * statistics.median(point.imports for _, points in swept for point in points)
    print(f"\nDr.Jit: {swept[0][1][0].variant}; {os.cpu_count()} cores; imports alone hold {imports:.0f} MB")
    marches = measure_marches(turns)
    show_refusals()
    draw(swept, marches, arguments.out / "scaling.png")


if __name__ == "__main__":
    main()
