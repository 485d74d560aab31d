"""The one driver: a scene is simulated and retrieved turn by turn, and each finished turn goes to all sinks."""

from __future__ import annotations

import time
from collections.abc import Callable, Iterable, Iterator, Sequence
from concurrent.futures import ThreadPoolExecutor, wait
from contextlib import AbstractContextManager, ExitStack
from dataclasses import dataclass
from types import TracebackType
from typing import Any, NamedTuple, Protocol

import numpy as np
import xarray as xr

from ..compute.machine import one_blas_thread
from ..interferometry import retrieve_one
from ..io.process import Progress, ProgressEstimate, hold_interruptions, ignore_progress
from ..scene import SceneLike, as_scene
from ..simulation import Simulator, Stopwatch, Turn

_TimedMaps = tuple[xr.DataTree, dict[str, float]]  # maps, and seconds by stage
_COUNTS = ("facets", "rays", "slope_rms_look", "folded_share")


@dataclass(frozen=True)
class FinishedTurn:
    """One turn of the antenna, simulated and, where that was wanted, retrieved.

    number: from 0. echoes: schema `echoes`. truth: groups `polar` and `ground` (schemas `truth/…`), each with `turn` of
    length 1. maps: the same groups of `maps/…`; None where the turn was not retrieved. timing: seconds by stage, and
    `total`. counts: `facets`, `rays`, `slope_rms_look` (of the facets, along the look), `folded_share` (of the mesh's
    points under a crest that folds over) and, with maps, `ground_cells` (that the beam passed). begun: s, by
    time.perf_counter, when its simulation began.
    """

    number: int
    echoes: xr.Dataset
    truth: xr.DataTree
    maps: xr.DataTree | None
    timing: dict[str, float]
    counts: dict[str, float]
    begun: float = np.nan


class TurnFigures(NamedTuple):
    """What is kept of a turn when its arrays have gone; `timing` holds the sinks' stages too. begun, done: s, by
    time.perf_counter, when its simulation began and when all sinks had taken it."""

    timing: dict[str, float]
    counts: dict[str, float]
    begun: float
    done: float


def warm_wall(figures: Sequence[TurnFigures]) -> float | None:
    """Wall seconds of a run's turns but the first, which compiles: from when the second begins until all have taken the
    last. The first one's retrieval, beside them, is in it. None of a single turn."""
    return figures[-1].done - figures[1].begun if len(figures) > 1 else None


def real_time_factor(turn_s: float, figures: Sequence[TurnFigures]) -> float | None:
    """Simulated seconds over wall seconds of a run's warm turns, of turns of turn_s [s]; None of a single turn."""
    wall = warm_wall(figures)
    return None if wall is None else (len(figures) - 1) * turn_s / wall


class Sink(AbstractContextManager[Any], Protocol):
    """What takes finished turns: a context manager, entered before the first turn and left after the last.

    `stage` names what it does in the run's timing. Left by an exception it keeps the turns that it has taken.
    """

    stage: str = "write"

    def turn(self, turn: FinishedTurn) -> None:
        """Take a turn, or raise and be as before it."""
        ...

    def __exit__(
        self, kind: type[BaseException] | None, error: BaseException | None, trace: TracebackType | None, /
    ) -> bool | None:
        """What it has taken stays."""


def iterate(
    scene: SceneLike,
    *,
    simulator: Simulator | None = None,
    retrieved: bool = True,
    ahead: bool = False,
    progress: Progress | None = None,
) -> Iterator[FinishedTurn]:
    """Simulate and retrieve a scene, and yield its turns one by one, as they are finished.

        for turn in iterate(scene):
            print(turn.number, float(turn.maps["polar"]["height"].std()))

    Memory holds one turn, if the caller keeps none. The maps never see the truth.

    simulator: the scene's, where the caller wants its sea and its mast too; made here if left out. retrieved: False
    leaves the maps out. ahead: a turn is retrieved while the next one is simulated, and yielded after both; the maps
    are the same, all turns together take a sixth less time on two cores, and memory holds two. progress: called with a
    line on each stage as it begins: the turn, the stage, and the time left by what the turns before have taken.
    Raises, before the first turn, InputError for a scene that cannot be simulated, and NoBackendError if rays are
    requested and cannot be traced.
    """
    simulator = simulator or Simulator(as_scene(scene))
    pace = ProgressEstimate("turn", simulator.scene.turns, progress or ignore_progress)
    numbers = range(simulator.scene.turns)
    if ahead and retrieved and len(numbers) > 1:
        yield from _iterate_ahead(simulator, pace)
        return
    for number in numbers:
        pace.begin()
        turn = simulator.turn(number, pace.stage)
        yield _finish_turn(turn, _retrieve_turn(simulator, turn, pace.stage) if retrieved else None)


def _iterate_ahead(simulator: Simulator, pace: ProgressEstimate) -> Iterator[FinishedTurn]:
    """Each turn is retrieved by a thread beside the simulation of the next.

    The main thread simulates, and signals reach it at once; a turn that then is whole is yielded before the error goes
    on.
    """
    last: Turn | None = None
    with ThreadPoolExecutor(1) as beside:
        for number in range(simulator.scene.turns):
            pace.begin()
            turn, coming, stopped = None, None, None
            # BLAS has one thread throughout: either side asks for that, and gives it back, as if it were alone.
            with one_blas_thread():
                try:
                    coming = beside.submit(_retrieve_turn, simulator, last) if last is not None else None
                    turn = simulator.turn(number, pace.stage)
                    wait([] if coming is None else [coming])
                except BaseException as error:
                    stopped = error
                    wait([] if coming is None else [coming])
            if last is not None and coming is not None:
                done = _finish_turn(last, coming.result())
                last = coming = None
                yield done
                del done
            if stopped is not None:
                raise stopped
            last = turn
            del turn
    if last is not None:
        yield _finish_turn(last, _retrieve_turn(simulator, last, pace.stage))


def _retrieve_turn(simulator: Simulator, turn: Turn, on_stage: Callable[[str], object] | None = None) -> _TimedMaps:
    clock = Stopwatch(on_stage=on_stage)
    with clock("retrieve"):
        maps = retrieve_one(turn.echoes, simulator.scene.resolved_retrieval)
    return maps, clock.seconds


def _finish_turn(turn: Turn, retrieved: _TimedMaps | None) -> FinishedTurn:
    maps, seconds = retrieved or (None, {})
    counts: dict[str, float] = {name: getattr(turn, name) for name in _COUNTS}
    if maps is not None:
        counts["ground_cells"] = int(np.isfinite(maps["ground"].to_dataset()["time"].values).sum())
    timing = _add_timings(turn.timing, seconds)
    return FinishedTurn(turn.number, turn.echoes, turn.truth, maps, timing, counts, turn.begun)


def deliver(turns: Iterable[FinishedTurn], sinks: Sequence[Sink]) -> list[TurnFigures]:
    """Give each turn to all sinks, in their order, and return the turns' figures.

    Where a sink cannot take a turn, those behind it do not get it, and the error is raised: what must end with the same
    turn is kept by one of them. Ctrl-C and SIGTERM wait until all have taken the turn.
    """
    figures: list[TurnFigures] = []
    with ExitStack() as entered:
        for sink in sinks:
            entered.enter_context(sink)
        for turn in turns:
            clock = Stopwatch()
            with hold_interruptions():
                for sink in sinks:
                    with clock(sink.stage):
                        sink.turn(turn)
            timing = _add_timings(turn.timing, clock.seconds)
            figures.append(TurnFigures(timing, turn.counts, turn.begun, time.perf_counter()))
            del turn  # so that memory does not hold it beside the next one
    return figures


def _add_timings(first: dict[str, float], then: dict[str, float]) -> dict[str, float]:
    """Seconds by stage of a turn, those of a further step added; the total grows by them."""
    stages = {stage: first.get(stage, 0.0) + then.get(stage, 0.0) for stage in (*first, *then)}
    return {**stages, "total": first["total"] + sum(then.values())}
