"""How fast a turn is: seconds of wall and of the processor per stage of warm turns of a scene, medians over turns, each
tracer in turn, and how far each stage is from its floor: the time of the unavoidable work alone.

python -m validation.speed.speed [--scene choppy_sea] [--turns 5] [--set sea.model=choppy] [--sweep] [--peers]

Floors, measured in the same run: the sea's FFTs alone; shadow rays and tree as `validation/speed/peers.py` has them (a
bare tree of the triangles that can be hit, and ray_test on arrays that lie ready); of the echoes the multiply-adds
at the rate at which BLAS does them, and the random numbers that the lit facets and the noise need.

Then a run's warm turns, retrieved beside the next one's simulation, and echoes, maps and truth written: real time is
their simulated time over their wall time, as in a run's metrics.json. `--sweep` adds the points of a trade
(`validation.speed.sweep`), `--peers` other engines on the same triangles (`validation.speed.peers`, some minutes), each
in a process of its own in the same minutes.
"""

from __future__ import annotations

import argparse
import statistics
import subprocess
import sys
import tempfile
import time
from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np
import scipy.fft

import seamap_rt as sr
from seamap_rt import random_streams
from seamap_rt.compute.machine import peak_memory
from seamap_rt.echoes.summation.gaussian import gaussians
from seamap_rt.interferometry import retrieve_one
from seamap_rt.random_streams import Stream
from seamap_rt.session import FileSink, TurnFigures, deliver, iterate
from seamap_rt.session.driver import real_time_factor, warm_wall
from seamap_rt.session.simulating import run_store
from seamap_rt.simulation import Simulator

from .. import ROOT

STAGES = ("sea", "mesh", "trace", "echoes", "truth", "retrieve", "total")
BESIDE = {"sweep": (), "peers": ("--repeat", "5")}  # scripts, and what they are told
MODES, NODES, GATES, TAPS = 7, 15, 5, 10  # of choppy_sea: speckle's modes, nodes a column is heard at, gates a facet


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--scene", default="choppy_sea")
    parser.add_argument("--turns", type=int, default=5)
    parser.add_argument("--set", action="append", default=[], metavar="KEY=VALUE", help="any key of the scene")
    for name in BESIDE:
        parser.add_argument(f"--{name}", action="store_true")
    arguments = parser.parse_args()
    changes = dict(pair.split("=", 1) for pair in arguments.set)
    medians = []
    for tracer in ("facets", "horizon"):
        scene = sr.load_scene(arguments.scene, overrides={**changes, "tracing.tracer": tracer})
        simulator = Simulator(scene)
        rows = turn_times(simulator, arguments.turns + 1)
        warm = {
            stage: statistics.median(row[stage] for row in rows[1:]) for stage in (*STAGES, *map(of_processor, STAGES))
        }
        floors = _floors(simulator) if tracer == "facets" else {}
        print(f"\n{tracer:10} {'wall':>8} {'processor':>10} {'floor':>8} {'ratio':>6}   first turn")
        for stage in STAGES:
            floor = f"{floors[stage]:8.3f} {warm[stage] / floors[stage]:6.1f}" if stage in floors else f"{'':8} {'':6}"
            print(f"{stage:10} {warm[stage]:8.3f} {warm[of_processor(stage)]:10.3f} {floor} {rows[0][stage]:12.3f}")
        figures = run_figures(simulator, arguments.turns + 1)
        factor, wall = real_time_factor(scene.turn_duration_s, figures), warm_wall(figures)
        assert wall is not None
        print(f"a run with files: {wall / arguments.turns:.3f} s a warm turn, real time {factor:.2f}")
        seconds = [*(f"{warm[stage]:.2f}" for stage in STAGES), f"{wall / arguments.turns:.2f}", f"{factor:.1f}"]
        medians.append(" | ".join((tracer, *seconds)))
    print(f"peak memory {peak_memory() / 2**30:.2f} GiB\n\n**seconds of a warm turn, medians**\n")
    print(f"| tracer | {' | '.join(STAGES)} | a run's turn | real time |\n" + "|---" * (len(STAGES) + 3) + "|")
    print("\n".join(f"| {row} |" for row in medians))
    for name in BESIDE:
        if getattr(arguments, name):
            print(f"\n{name}", flush=True)
            subprocess.run([sys.executable, "-m", f"validation.speed.{name}", *BESIDE[name]], cwd=ROOT, check=True)


def of_processor(stage: str) -> str:
    """The name of a stage's processor seconds among the times of a turn."""
    return f"{stage}, processor"


def turn_times(simulator: Simulator, turns: int) -> list[dict[str, float]]:
    """Seconds by stage of turns and their retrievals, of wall and of the processor; the first is not warm."""
    rows = []
    for number in range(turns):
        meter = _Meter()
        turn = simulator.turn(number, meter)
        meter("retrieve")
        start = time.perf_counter()
        retrieve_one(turn.echoes, simulator.scene.resolved_retrieval)
        timing = {**turn.timing, "retrieve": time.perf_counter() - start}
        timing["total"] += timing["retrieve"]
        rows.append({**timing, **meter.read()})
    return rows


class _Meter:
    """Processor seconds from each step that is told to the next."""

    def __init__(self) -> None:
        self._began = self._last = time.process_time()
        self._step = ""
        self._seconds: dict[str, float] = dict.fromkeys(STAGES, 0.0)

    def __call__(self, step: str) -> None:
        now, stage = time.process_time(), "echoes" if self._step == "scattering" else self._step
        self._seconds[stage] = self._seconds.get(stage, 0.0) + now - self._last
        self._step, self._last = step, now

    def read(self) -> dict[str, float]:
        self("")
        self._seconds["total"] = self._last - self._began
        return {of_processor(stage): seconds for stage, seconds in self._seconds.items()}


def run_figures(simulator: Simulator, turns: int) -> list[TurnFigures]:
    """Of a run of several turns that writes its files, as `seamap-rt run` does."""
    with tempfile.TemporaryDirectory() as folder:
        store = run_store(Path(folder), ["truth.nc", "maps.nc"])
        parts = ("echoes", "truth", "maps")
        sinks = [FileSink(store, lambda turn: {name: getattr(turn, name) for name in parts})]
        simulator.scene = simulator.scene.model_copy(update={"turns": turns})
        return deliver(iterate(simulator.scene, simulator=simulator, ahead=True), sinks)


def _floors(simulator: Simulator) -> dict[str, float]:
    """Seconds, by stage."""
    returns = simulator.light(0)[1]
    heard = int(np.count_nonzero(returns.rcs))
    pulses = round(simulator.scene.radar.prf_hz * simulator.scene.turn_duration_s)
    samples = 2 * pulses * 257
    sums = heard * (8 * MODES * NODES + 3 * NODES * (8 + 4 * GATES)) + samples * 4 * TAPS
    matrix = np.ones((2000, 2000), dtype=np.float32)
    rate = 2.0 * 2000**3 / _least(lambda: matrix @ matrix)
    draws = _least(lambda: gaussians(random_streams.key(1, Stream.SPECKLE), 100_000, MODES)) / (100_000 * MODES)
    # Two threads draw at once.
    return {
        "sea": _ffts(simulator),
        "trace": _bare_rays(simulator),
        "echoes": sums / rate + 0.5 * draws * (heard * MODES + samples),
    }


def _ffts(simulator: Simulator) -> float:
    """Those of a turn's new knots, of each field that has any, on two threads."""
    field: Any = simulator.sea.trains[0]
    field = field.field
    rows, columns = field.shape
    half = np.zeros((rows, columns // 2 + 1), dtype=np.complex64)
    new = simulator.scene.turn_duration_s / field.time_step

    def once() -> None:
        scipy.fft.irfft2(half, s=(rows, columns), workers=2)

    return len({kind for _, kind in field._cache}) * new * _least(once)


def _bare_rays(simulator: Simulator) -> float:
    """A tree of the triangles that can be hit, and all shadow rays of a turn's own sheet, on arrays that lie ready."""
    from seamap_rt.tracing.rays import RayTracer, SeaScene, occluding_surface
    from seamap_rt.tracing.shadow_rays import shadow_rays

    mesh = simulator.mesh(0)
    sheet, facets = mesh.sheets()[0], mesh.facets
    rays = shadow_rays(mesh, facets, sheet)
    tracer = RayTracer(simulator.scene.radar, simulator.scene.scattering)
    surface = occluding_surface(mesh, sheet, rays)
    scene = SeaScene(
        surface, mesh.grid.antenna_positions[sheet[0].start], simulator.scene.radar.frequency_hz, tracer.permittivity
    )
    return _least(lambda: scene.update(surface)) + _least(lambda: scene.hits(rays))


def _least(work: Callable[[], object], rounds: int = 5) -> float:
    """Seconds, the least of some rounds."""
    work()
    taken = []
    for _ in range(rounds):
        start = time.perf_counter()
        work()
        taken.append(time.perf_counter() - start)
    return min(taken)


if __name__ == "__main__":
    main()
