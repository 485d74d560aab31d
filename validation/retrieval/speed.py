"""Seconds and memory of a turn's retrieval: stages, estimators, a boat that moves, and the first call of a process.

    python -m validation.retrieval.maps --only speed

Times are the best of several, wall clock and processor. The machine must be idle.
"""

from __future__ import annotations

import os
import pickle
import subprocess
import sys
import tempfile
import time
from collections.abc import Callable
from pathlib import Path

import xarray as xr

import seamap_rt as sr
from seamap_rt.interferometry import retrieve_one
from seamap_rt.interferometry.estimation.estimators import ESTIMATORS
from seamap_rt.interferometry.input.description import RadarDescription
from seamap_rt.interferometry.looks import Looks, interferogram
from seamap_rt.interferometry.retrieval import retrieve_turn
from seamap_rt.scene import Scene
from seamap_rt.settings import RetrievalSettings
from seamap_rt.simulation import Simulator
from validation.retrieval.cells import heading, row

TIMES = 9
REQUIRED_S = 0.3
FIRST_CALL = """
import pathlib, pickle, re, sys, time
start = time.perf_counter()
import xarray
from seamap_rt.interferometry import retrieve_one
moments = [start, time.perf_counter()]
echoes = pickle.loads(pathlib.Path(sys.argv[1]).read_bytes())
held = time.perf_counter() - moments[1]
for _ in range(2):
    retrieve_one(echoes)
    moments.append(time.perf_counter())
peak = re.search(r"VmHWM:\\s+(\\d+)", pathlib.Path("/proc/self/status").read_text())
imports, first, second = (b - a for a, b in zip(moments[:-1], moments[1:]))
print(f"{imports:.2f} {first - held:.2f} {second:.3f} {int(peak[1]) / 1024:.0f}")
"""


def best(work: Callable[[], object]) -> tuple[float, float]:
    """Least wall clock and processor seconds of several calls."""
    taken = []
    for _ in range(TIMES):
        start = time.perf_counter(), time.process_time()
        work()
        taken.append((time.perf_counter() - start[0], time.process_time() - start[1]))
    return min(wall for wall, _ in taken), min(cpu for _, cpu in taken)


def stages(echoes: xr.Dataset, settings: RetrievalSettings) -> list[tuple[float, float]]:
    """Of the looks, their interferogram, the estimator, all polar maps, and those with the ground map."""
    radar = RadarDescription.of(echoes)
    looks = Looks.of(echoes, radar, settings)
    return [
        best(lambda: Looks.of(echoes, radar, settings)),
        best(lambda: interferogram(looks)),
        best(lambda: ESTIMATORS[settings.estimator](interferogram(looks)[0])),
        best(lambda: retrieve_turn(echoes, radar, settings, 0)),
        best(lambda: retrieve_one(echoes, settings)),
    ]


def turn_of(name: str) -> tuple[Scene, xr.Dataset]:
    scene = sr.load_scene(name, {"tracing.tracer": "horizon"})
    return scene, Simulator(scene).turn(0).echoes.load()


def first_call(echoes: Path, cache: Path) -> list[str]:
    """Of a new process: seconds of its imports, of the first turn and of the next one, and its peak memory in MiB."""
    environment = {**os.environ, "NUMBA_CACHE_DIR": str(cache)}
    command = [sys.executable, "-c", FIRST_CALL, str(echoes)]
    return subprocess.run(command, env=environment, check=True, capture_output=True, text=True).stdout.split()


def main() -> None:
    names = ("looks", "+ interferogram", "+ estimator (less looks)", "polar maps", "whole turn")
    title = f"Seconds of a warm turn, wall (processor), each stage with those before it; required: {REQUIRED_S} s"
    heading(title, "scene", "estimator", *names)
    with tempfile.TemporaryDirectory() as folder:
        stored = Path(folder) / "echoes.pickle"
        for name in ("choppy_sea", "rough_ride"):
            scene, echoes = turn_of(name)
            for estimator in ESTIMATORS if name == "choppy_sea" else (scene.retrieval.estimator,):
                settings = scene.retrieval.model_copy(update={"estimator": estimator})
                retrieve_one(echoes, settings)
                shown = [f"{wall:.3f} ({cpu:.3f})" for wall, cpu in stages(echoes, settings)]
                row(name, estimator, *shown)
            if name == "choppy_sea":
                stored.write_bytes(pickle.dumps(echoes))
        heading("A new process", "compiled code", "imports s", "first turn s", "second turn s", "peak MiB")
        for kept in ("none yet", "kept from before"):
            row(kept, *first_call(stored, Path(folder) / "compiled"))
