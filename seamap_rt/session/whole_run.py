"""One whole run: simulate, retrieve, forecast, compare, draw, into a folder, over no other run's results."""

from __future__ import annotations

import os
import time
from collections.abc import Callable, Iterable, Iterator, Sequence
from contextlib import contextmanager
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Any, NamedTuple

import numpy as np
import xarray as xr

from ..compute.machine import peak_memory
from ..errors import is_interruption, must_be
from ..forecast_errors import judge_forecasts
from ..gauges import judge
from ..interferometry import open_echoes
from ..io.growing_store import GrowingStore
from ..io.process import Progress, ignore_progress
from ..io.results_folder import FULL, KINDS, RUN, clear_folder, note_growing, results_folder, write_whole
from ..io.text import to_json
from ..measured import CoverageProfile
from ..metrics import error_figures
from ..report.headline import run_facts
from ..scene import SceneLike, as_scene
from ..simulation import Simulator
from ..wavefield import sea_state
from ..wavefield.sea_state import in_words
from ..window_errors import judge_windows
from .driver import FinishedTurn, Sink, TurnFigures, deliver, iterate, real_time_factor, warm_wall
from .simulating import FileSink, GaugeSink, concatenate_turns, image_sinks, run_store

if TYPE_CHECKING:
    from ..io.stream import Broadcast
    from .forecasting import ForecastSink
    from .streaming import Format

PRODUCTS = ("scene.toml", *KINDS["a run's"], "metrics.json")


class Stream(NamedTuple):
    """Who listens, and the form of the messages: "json" or "signalk"."""

    broadcast: Broadcast
    form: Format = "json"


@dataclass(frozen=True)
class RunResult:
    """What a run left behind: its folder, and the content of metrics.json."""

    folder: Path
    metrics: dict[str, Any]


def run(
    scene: SceneLike,
    out: str | Path | None = None,
    *,
    predict: bool = False,
    overwrite: bool = False,
    progress: Progress | None = None,
    draw: Callable[..., Path] | None = None,
    stream: Stream | None = None,
) -> RunResult:
    """Simulate, retrieve, compare and draw all turns of a scene into a folder (default `runs/<scene>-<seed>`).

    out: the folder; an earlier run in it is replaced only with `overwrite`.
    Results stream turn by turn: memory holds one turn, and all maps and truths while they are at most 25 MB.
    Interrupted, complete turns stay readable.
    predict: forecast beside the run, from its maps, as the scene's section `prediction` says.
    progress: called with a line on what begins. draw: draws the report in place of `report.write_report`. stream: where
    each turn's message goes as soon as the turn is whole, and as what; turns then are retrieved one by one, not beside
    the next one's simulation. It needs `predict`.
    Raises InputError for bad input, NoBackendError if rays cannot be traced, OSError where the disk is full.
    """
    scene, say = as_scene(scene), progress or ignore_progress
    start = time.perf_counter()
    if out is not None:
        must_be("out", out, (str, os.PathLike), "the path of a folder")
    folder = Path(out) if out is not None else Path("runs") / f"{scene.name}-{scene.seed}"
    with results_folder(folder, overwrite, PRODUCTS):
        say("sea: drawing it, and preparing the tracer")
        simulator = Simulator(scene)
        ahead = None
        if predict:
            from .forecasting import ForecastSink  # takes a third of a second

            ahead = ForecastSink(simulator)
        clear_folder(folder, PRODUCTS)
        also = (*(["gauges.nc"] if scene.gauges else []), *(["prediction.nc"] if predict else []))
        files = ("truth.nc", "maps.nc", *also)
        store = run_store(folder, files)
        with _report_remaining(store, scene.turns), note_growing(folder, (RUN, *files)):
            write_whole(folder / "scene.toml", scene.to_toml())
            sinks = _sinks(folder, simulator, store, ahead, stream)
            made = TurnMemory(iterate(scene, simulator=simulator, ahead=stream is None, progress=progress))
            figures = deliver(made, sinks)
        say("compare: maps with the truth")
        gauges = xr.load_dataset(folder / "gauges.nc") if scene.gauges else None  # some hundred bytes a turn
        with made.maps_and_truth(folder) as (maps, truth):
            metrics = _metrics(simulator, maps, truth, gauges, figures)
            verified = ahead.verified_forecasts() if ahead else None
            windows = ahead.windows() if ahead else None
            metrics["prediction"] = judge_forecasts(verified) if verified else []
            metrics["vessel_notes"] = list(ahead.vessel_notes) if ahead else []
            metrics["quiet_windows"] = judge_windows(windows, scene.prediction.quiet.confidence) if windows else None
            metrics["run_s"] = time.perf_counter() - start
            say("report: drawing")
            echoes = open_echoes(folder / RUN)
            if draw is None:
                from ..report.page import write_report as draw  # loads matplotlib

            draw(folder, scene, maps, truth, metrics, echoes, gauges, verified, windows)
        metrics["run_s"] = time.perf_counter() - start
        metrics["peak_memory_bytes"] = peak_memory()
        write_whole(folder / "metrics.json", to_json(metrics))
        return RunResult(folder, metrics)


class TurnMemory:
    """Passes turns on, and keeps their maps and truths in memory while they are at most so many bytes: read from their
    files, each array takes ten milliseconds."""

    def __init__(self, turns: Iterable[FinishedTurn], most_bytes: float = 2.5e7) -> None:
        self._turns, self._most_bytes = turns, most_bytes
        self._kept: list[tuple[xr.DataTree, xr.DataTree]] = []

    def __iter__(self) -> Iterator[FinishedTurn]:
        size = 0
        for turn in self._turns:
            assert turn.maps is not None
            size += turn.maps.nbytes + turn.truth.nbytes
            if size <= self._most_bytes:
                self._kept.append((turn.maps, turn.truth))
            else:
                self._kept.clear()
            yield turn
            del turn  # so that memory does not hold it beside the next one

    @contextmanager
    def maps_and_truth(self, folder: Path) -> Iterator[tuple[xr.DataTree, xr.DataTree]]:
        """Maps and truth of all turns, each with the groups `polar` and `ground`. folder: where their files are."""
        if self._kept:
            maps, truth = (concatenate_turns(turns) for turns in zip(*self._kept, strict=True))
            yield maps, truth
        else:
            with xr.open_datatree(folder / "maps.nc") as maps, xr.open_datatree(folder / "truth.nc") as truth:
                yield maps, truth


def _sinks(
    folder: Path, simulator: Simulator, store: GrowingStore, ahead: ForecastSink | None, stream: Stream | None
) -> list[Sink]:
    """What takes the turns of a run: all that a turn is worked out to goes into the store at once."""
    gauges = GaugeSink(simulator) if simulator.scene.gauges else None
    sinks: list[Sink] = [sink for sink in (ahead, gauges) if sink is not None]
    if ahead is not None and stream is not None:
        from .streaming import StreamSink

        sinks.insert(1, StreamSink(stream.broadcast, ahead, ahead.vessel, stream.form))

    def turn_of(turn: FinishedTurn) -> dict[str, xr.Dataset | xr.DataTree | None]:
        parts = {"echoes": turn.echoes, "truth": turn.truth, "maps": turn.maps}
        forecast = ahead.latest[1] if ahead is not None and ahead.latest is not None else None
        return parts | {"gauges": None if gauges is None else gauges.latest, "forecast": forecast}

    return [*sinks, FileSink(store, turn_of), *image_sinks(folder, simulator)]


@contextmanager
def _report_remaining(store: GrowingStore, turns: int) -> Iterator[None]:
    """Give an interruption, or a full disk, a message that says which turns are left."""
    try:
        yield
    except BaseException as error:
        whole = f"{store.complete} of {turns} turns are complete"
        rest = "and stay readable; metrics.json and report.html are missing"
        if not store.complete:  # a scene without results would look like another run's folder
            store.path.with_name("scene.toml").unlink(missing_ok=True)
            rest = "no results are left"
        if is_interruption(error):
            raise KeyboardInterrupt(f"{whole}, {rest}") from None
        if isinstance(error, OSError) and error.errno in FULL:
            raise OSError(error.errno, f"{error.strerror}; {whole}, {rest}", error.filename) from None
        raise


# ---------------------------------------------------------------------------------------------------- the metrics


def _metrics(
    simulator: Simulator,
    maps: xr.DataTree,
    truth: xr.DataTree,
    gauges: xr.Dataset | None,
    figures: Sequence[TurnFigures],
) -> dict[str, Any]:
    """The content of metrics.json, but for `run_s`."""
    scene, timing, sigma = simulator.scene, _timing(figures), float(simulator.sea.resolved.elevation_std)
    own, visible = {"polarization": scene.scattering.polarization}, simulator.visible  # to light and to radars
    return {
        "scene": scene.name,
        "seed": scene.seed,
        **error_figures(maps, truth),
        "measured": CoverageProfile.of(maps["polar"].to_dataset(), truth["polar"].to_dataset(), sigma).figures,
        **_sea_state(maps if simulator.sea.patch is None else _mask_unknown(maps, truth)),
        "visible": None if visible is None else own | visible.facts,
        "hs_scene_m": 4.0 * sigma,
        "gauges": judge(gauges) if gauges is not None else [],
        "timing_s": timing,
        "real_time_factor": real_time_factor(scene.turn_duration_s, figures),
        **_counts([turn.counts for turn in figures]),
        "peak_memory_bytes": peak_memory(),
        **run_facts(scene, simulator.sea, simulator.surface, timing),
    }


def _counts(counts: Sequence[dict[str, float]]) -> dict[str, float]:
    """Counts of the last turn, but for folded waves, of which the worst turn counts; and the share of the ground cells
    that the first turn's beam passed which the last one's passes still."""
    last, first_cells = dict(counts[-1]), counts[0]["ground_cells"]
    covered = last.pop("ground_cells") / max(first_cells, 1)
    return {"ground_covered": covered, **last, "folded_share": max(turn["folded_share"] for turn in counts)}


def _sea_state(maps: xr.DataTree) -> dict[str, Any]:
    """The sea state by the maps, turn by turn, and in words; a scene always gives its depth, be it infinite."""
    state = sea_state(maps)
    return {
        "sea_state": {str(name): values.values.tolist() for name, values in state.data_vars.items()},
        "sea_state_in_words": in_words(state.assign_attrs(depth_given=1)),
    }


def _mask_unknown(maps: xr.DataTree, truth: xr.DataTree) -> xr.DataTree:
    """The polar map with heights where there is a truth: not beyond a record that was continued."""
    polar, known = maps["polar"].to_dataset(), np.isfinite(truth["polar"].to_dataset()["height"].values)
    return xr.DataTree.from_dict({"/polar": polar.assign(height=polar["height"].where(known))})


def _timing(figures: Sequence[TurnFigures]) -> dict[str, Any]:
    """The first turn (which compiles and builds), the mean of the warm ones if there are any, whose stages overlap, and
    the wall time of them all."""
    timings = [turn.timing for turn in figures]
    warm = timings[1:]
    mean = {stage: sum(t.get(stage, 0.0) for t in warm) / len(warm) for stage in timings[0]} if warm else None
    return {"first": timings[0], "warm": mean, "warm_wall": warm_wall(figures)}
