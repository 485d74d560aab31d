"""One point of a sweep: a scene simulated, retrieved and compared in memory, and a small file of what came of it.

A point never raises for what is wrong with it: a refusal or an error is a result with a sentence. It leaves its sea and
its traced scenes to the next one in the same process, on which results do not depend.
"""

from __future__ import annotations

import contextlib
import hashlib
import json
import os
import socket
import threading
import tomllib
from collections import deque
from collections.abc import Iterable, Mapping
from dataclasses import dataclass
from pathlib import Path
from threading import Lock, Timer
from typing import TYPE_CHECKING, Any, Literal

import numpy as np

from .. import __version__
from ..compute.machine import forget_peak_memory, one_blas_thread, peak_memory
from ..errors import InputError
from ..io.opening import read_json
from ..io.results_folder import write_whole
from ..io.validation import validate
from ..measured import CoverageProfile
from ..metrics import BIN_M, error_figures
from ..scene import Scene

if TYPE_CHECKING:
    import xarray as xr

    from ..simulation import Simulator, Stopwatch


_REMEMBERED_BYTES = 100e6  # of a sea's values: a turn of `choppy_sea` and its calibration are 50
IDLE_S = 60.0  # after which a process that is given no other point frees what it has kept


class SimulatorCache:
    """The last point's simulator, from which the next one takes over what is alike."""

    def __init__(self) -> None:
        self._before: Simulator | None = None
        self._lock, self._timer = Lock(), Timer(IDLE_S, self.forget)  # not started

    def simulator(self, scene: Scene) -> Simulator:
        """The scene's own. It is kept once it is `finished`, and so never one that failed."""
        from ..simulation import Simulator  # takes half a second

        before = self._pop_simulator()
        sea = before.sea if before is not None and before.shares_sea_with(scene) else None
        rays = before.ray_scenes if before is not None else None
        del before  # before the next sea takes memory
        simulator = Simulator(scene, sea, rays)
        if sea is None:
            simulator.sea.remember(_REMEMBERED_BYTES)
        return simulator

    def finished(self, simulator: Simulator) -> None:
        """Keep it for the next point, if that comes soon."""
        with self._lock:
            self._before, self._timer = simulator, Timer(IDLE_S, self.forget)
            self._timer.daemon = True
            self._timer.start()

    def forget(self) -> None:
        """Free it now."""
        self._pop_simulator()

    def _pop_simulator(self) -> Simulator | None:
        with self._lock:
            self._timer.cancel()
            before, self._before = self._before, None
        return before


MANIFEST, POINTS = "trade.json", "points"

Status = Literal["done", "refused", "failed"]
Outcome = dict[str, Any]


class SchedulerLost(RuntimeError):
    """The scheduler does not answer any more."""


# Dr.Jit is not safe for several simulations in the threads of one process: a worker with more waits.
_ONE_AT_A_TIME = threading.Lock()
CACHE = SimulatorCache()  # of this process
_LONGEST_REASON = 400


@dataclass(frozen=True)
class Task:
    """All that a worker needs of a point, as plain data."""

    name: str
    scene: str  # resolved, as TOML
    keys: dict[str, Any]
    seed: int
    folder: str  # of the sweep
    sea: str = ""  # the same for tasks whose seas are the same
    version: str = __version__

    @property
    def file(self) -> Path:
        """The file of the point's result."""
        return Path(self.folder) / POINTS / f"{self.name}.json"

    @property
    def identity(self) -> dict[str, Any]:
        """What the point's result depends on, as its file states it."""
        keys = {key: _writable(value) for key, value in self.keys.items()}
        scene = hashlib.sha256(self.scene.encode()).hexdigest()
        return {"name": self.name, "keys": keys, "seed": self.seed, "scene_sha256": scene, "version": self.version}


def compute(task: Task) -> Outcome:
    """What came of a point; its file too, where the sweep's folder can be seen from here.

    `status` done, with `metrics`, `by_range` and `facts`; refused, by a limit of the scene; or failed, by an error.
    These have the same bits on every run; `cost` (seconds by stage, peak memory, worker) has not.
    """
    from ..simulation import Stopwatch

    with _ONE_AT_A_TIME, one_blas_thread():
        clock = Stopwatch()
        forget_peak_memory()
        with clock("total"):
            outcome = _outcome(task, clock)
    worker = f"{socket.gethostname()}:{os.getpid()}"
    outcome["cost"] = {"seconds": clock.seconds, "peak_memory_bytes": peak_memory(), "worker": worker}
    if (Path(task.folder) / MANIFEST).is_file():
        with contextlib.suppress(OSError):  # the client has the result too, and says why it cannot be written
            keep(task, outcome)
    return outcome


def _outcome(task: Task, clock: Stopwatch) -> Outcome:
    if task.version != __version__:
        return ended(task, "failed", f"the worker has seamap_rt {__version__}, the sweep is of {task.version}")
    try:
        return ended(task, "done", "") | judged(validate(Scene, tomllib.loads(task.scene)), clock)
    except InputError as refusal:
        return ended(task, "refused", "; ".join(refusal.problems))
    except MemoryError as error:
        return ended(task, "failed", f"out of memory ({error}); fewer workers leave each of them more")
    except Exception as error:
        return ended(task, "failed", f"{type(error).__name__}: {error}")


def ended(task: Task, status: Status, reason: str) -> Outcome:
    """How a point ended, without figures."""
    line = " ".join(reason.split())[:_LONGEST_REASON]
    keys = {key: _writable(value) for key, value in task.keys.items()}
    return {"keys": keys, "seed": task.seed, "status": status, "reason": line}


def keep(task: Task, outcome: Outcome) -> None:
    """Write a point's file, whole or not at all, with the point's identity and a checksum of all of it."""
    content = outcome | {"point": task.identity}
    task.file.parent.mkdir(exist_ok=True)
    write_whole(task.file, json.dumps(content | {"sha256": _checksum(content)}, indent=1, allow_nan=False))


def load_outcome(file: Path) -> Outcome | None:
    """What a point's file holds; None where there is none, or not what `keep` wrote."""
    try:
        outcome = read_json(file)
        intact = isinstance(outcome, dict) and outcome.pop("sha256", None) == _checksum(outcome)
    except (OSError, ValueError, RecursionError):
        return None
    return outcome if intact else None


def load_point(task: Task) -> tuple[Outcome | None, str]:
    """What is kept of a point, and why its file is not believed: "" where it is, or where there is none."""
    outcome = load_outcome(task.file)
    if outcome is None:
        return None, "is damaged or was edited" if task.file.exists() else ""
    stored, identity = outcome.pop("point", {}), task.identity
    other = [name for name in identity if not isinstance(stored, dict) or stored.get(name) != identity[name]]
    return (None, f"holds another point (its {other[0]} differs)") if other else (outcome, "")


def _checksum(content: Mapping[str, Any]) -> str:
    return hashlib.sha256(json.dumps(content, sort_keys=True).encode()).hexdigest()


def judged(scene: Scene, clock: Stopwatch) -> dict[str, Any]:
    """`metrics` (50 to 200 m), `by_range` and `facts` of a scene, all its turns together; memory holds one turn."""
    from ..session import iterate  # takes half a second

    with clock("sea"):
        simulator = CACHE.simulator(scene)
    maps, truths, facets, folded = [], [], 0.0, 0.0
    sigma, rings = float(simulator.sea.resolved.elevation_std), None
    for turn in iterate(scene, simulator=simulator):
        assert turn.maps is not None
        for stage, seconds in turn.timing.items():
            if stage != "total":
                clock.seconds[stage] = clock.seconds.get(stage, 0.0) + seconds
        maps.append(turn.maps["polar"].to_dataset())
        truths.append(turn.truth["polar"].to_dataset())
        seen = CoverageProfile.of(maps[-1], truths[-1], sigma)
        rings = seen if rings is None else rings + seen
        facets, folded = turn.counts["facets"], max(folded, turn.counts["folded_share"])
    with clock("compare"):
        metrics = error_figures(_join_turns(maps), _join_turns(truths))
    CACHE.finished(simulator)
    overall, (near, far) = metrics.pop("overall"), scene.radar.range_m
    gates = np.unique(np.floor(truths[0]["range"].values / BIN_M), return_counts=True)[1]  # of bins that hold any
    edges = np.asarray(metrics["range_m"]) - 0.5 * BIN_M
    whole = (edges >= near) & (edges + BIN_M <= far)
    share = np.asarray(metrics["cells"]) / (gates * truths[0].sizes["azimuth"] * scene.turns)
    known = [float(each) if all_of_it else None for each, all_of_it in zip(share, whole, strict=True)]
    facts = {"significant_height_m": 4.0 * sigma, "range_m": [near, far], "facets": facets, "folded_share": folded}
    assert rings is not None
    by_range = {**metrics, "known_share": known, "quality": _bin_scores(rings)}
    assert simulator.visible is not None
    del overall["range_m"]
    figures = overall | rings.figures | simulator.visible.figures
    return {"metrics": figures, "by_range": by_range, "facts": facts}


def _bin_scores(rings: CoverageProfile) -> list[float | None]:
    """Mean score of the cells of each of the metrics' bins that hold any."""
    number = np.unique(np.floor(rings.range_m / BIN_M), return_inverse=True)[1]
    score, cells = (np.bincount(number, each) for each in (rings.score, rings.cells))
    return [float(each) if np.isfinite(each) else None for each in score / cells]


def _join_turns(turns: list[xr.Dataset]) -> xr.DataTree:
    import xarray as xr

    joined = turns[0] if len(turns) == 1 else xr.concat(turns, "turn", data_vars="all")
    return xr.DataTree.from_dict({"/polar": joined})


def _writable(value: Any) -> Any:
    """Infinity, which JSON has not, in TOML's word for it."""
    return value if not isinstance(value, float) or np.isfinite(value) else str(value)


class BySea:
    """Tasks in groups of one sea each, for workers that keep the sea of their last task."""

    def __init__(self, tasks: Iterable[Task]) -> None:
        self._groups: dict[str, deque[Task]] = {}
        for task in tasks:
            self._groups.setdefault(task.sea, deque()).append(task)
        self._last: dict[str, str] = {}  # sea of each worker

    def take(self, worker: str) -> Task | None:
        """The next task for a worker: of its own sea, else of one that nobody works on, else of the one with the most
        tasks left. None if there is none."""
        if not self._groups:
            return None
        sea = self._last.get(worker, "")
        if sea not in self._groups:
            taken = set(self._last.values())
            free = (each for each in self._groups if each not in taken)
            sea = next(free, max(self._groups, key=lambda each: len(self._groups[each])))
        self._last[worker] = sea
        task = self._groups[sea].popleft()
        if not self._groups[sea]:
            del self._groups[sea]
        return task
