"""One whole run: simulate, retrieve, compare, draw, into a folder without overwriting another run's results."""

from __future__ import annotations

import os
import time
from collections.abc import Iterator, Sequence
from contextlib import contextmanager
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
import xarray as xr

from ..compute.machine import peak_memory
from ..errors import is_interruption, must_be
from ..forecast_errors import judge_forecasts
from ..gauges import judge
from ..interferometry import open_echoes
from ..io.appendable import AppendableNetCDF
from ..io.echo_store import EchoStore
from ..io.plain_json import to_json
from ..io.results_folder import FULL, clear_folder, growing, results_folder, write_whole
from ..measured import CoverageProfile
from ..metrics import error_figures
from ..report.headline import run_facts
from ..scene import Scene, SceneLike, as_scene
from ..simulation import Simulator
from ..wavefield import sea_state
from ..wavefield.sea_state import in_words
from ..window_errors import judge_windows
from .driver import Progress, Sink, TurnFigures, deliver, iterate, real_time_factor, warm_wall
from .forecasting import ForecastSink
from .sinks import FileSink, gauge_sink

PRODUCTS = (
    "scene.toml",
    "echoes.zarr",
    "maps.nc",
    "truth.nc",
    "gauges.nc",
    "prediction.nc",
    "metrics.json",
    "report.html",
    "evolution.gif",
)
_AT_ONCE = 2e8  # bytes of a file that is read whole


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
) -> RunResult:
    """Simulate, retrieve, compare and draw all turns of a scene into a folder (default `runs/<scene>-<seed>`).

    out: the folder; an earlier run in it is replaced only with `overwrite`.
    Results stream turn by turn, so memory holds one turn. Interrupted, complete turns stay readable.
    predict: forecast beside the run, from its maps, as the scene's section `prediction` says.
    progress: called with a line on what begins.
    Raises InputError for bad input, NoBackend if rays cannot be traced, OSError where the disk is full.
    """
    scene, say = as_scene(scene), progress or (lambda _: None)
    start = time.perf_counter()
    if out is not None:
        must_be("out", out, (str, os.PathLike), "the path of a folder")
    folder = Path(out) if out is not None else Path("runs") / f"{scene.name}-{scene.seed}"
    with results_folder(folder, overwrite, PRODUCTS):
        say("sea: drawing it, and preparing the tracer")
        simulator = Simulator(scene)
        ahead = ForecastSink(AppendableNetCDF(folder / "prediction.nc", ("issue",)), simulator) if predict else None
        clear_folder(folder, PRODUCTS)
        truth_file = AppendableNetCDF(folder / "truth.nc")
        with _stating_what_is_left(truth_file, scene.turns), growing(folder, _growing_files(scene, predict)):
            write_whole(folder / "scene.toml", scene.to_toml())
            sinks = _file_sinks(folder, simulator, truth_file, ahead)
            figures = deliver(iterate(scene, simulator=simulator, ahead=True, progress=progress), sinks)
        say("compare: maps with the truth")
        gauges = _read_gauges(folder) if scene.gauges else None
        with _read(folder / "maps.nc") as maps, _read(folder / "truth.nc") as truth:
            metrics = _metrics(simulator, maps, truth, gauges, figures)
            verified = ahead.verified() if ahead else None
            windows = ahead.windows() if ahead else None
            metrics["prediction"] = judge_forecasts(verified) if verified else []
            metrics["vessel_notes"] = list(ahead.vessel_notes) if ahead else []
            metrics["quiet_windows"] = judge_windows(windows, scene.prediction.quiet.confidence) if windows else None
            metrics["run_s"] = time.perf_counter() - start
            say("report: drawing")
            echoes = open_echoes(folder / "echoes.zarr")
            from ..report import write_report  # loads matplotlib

            write_report(folder, scene, maps, truth, metrics, echoes, gauges, verified, windows)
        metrics["run_s"] = time.perf_counter() - start
        metrics["peak_memory_bytes"] = peak_memory()
        write_whole(folder / "metrics.json", to_json(metrics))
        return RunResult(folder, metrics)


@contextmanager
def _read(path: Path) -> Iterator[xr.DataTree]:
    """A tree from its file: in memory, if it is small, as each array that is read by itself takes ten milliseconds."""
    with xr.open_datatree(path) as tree:
        if sum(node.to_dataset(inherit=False).nbytes for node in tree.subtree) <= _AT_ONCE:
            tree.load()
        yield tree


def _growing_files(scene: Scene, predict: bool) -> tuple[str, ...]:
    also = (("gauges.nc",) if scene.gauges else ()) + (("prediction.nc",) if predict else ())
    return ("truth.nc", "maps.nc", *also, "echoes.zarr")


def _file_sinks(
    folder: Path, simulator: Simulator, truth_file: AppendableNetCDF, ahead: ForecastSink | None
) -> list[Sink]:
    """The files of a run that grow with its turns. The echoes come last: it costs most to take them back."""
    sinks: list[Sink] = [
        FileSink(truth_file, lambda turn: turn.truth),
        FileSink(AppendableNetCDF(folder / "maps.nc"), lambda turn: turn.maps),
    ]
    if simulator.scene.gauges:
        sinks.append(gauge_sink(AppendableNetCDF(folder / "gauges.nc", ("turn", "sample")), simulator))
    if ahead is not None:
        sinks.append(ahead)
    return [*sinks, FileSink(EchoStore(folder / "echoes.zarr"), lambda turn: turn.echoes)]


@contextmanager
def _stating_what_is_left(file: AppendableNetCDF, turns: int) -> Iterator[None]:
    """An interruption, or a full disk, with a message of what is left."""
    try:
        yield
    except BaseException as error:
        whole = f"{file.complete} of {turns} turns are complete"
        rest = "and stay readable; metrics.json and report.html are missing"
        if not file.complete:  # a scene without results would look like another run's folder
            file.path.with_name("scene.toml").unlink(missing_ok=True)
            rest = "no results are left"
        if is_interruption(error):
            raise KeyboardInterrupt(f"{whole}, {rest}") from None
        if isinstance(error, OSError) and error.errno in FULL:
            raise OSError(error.errno, f"{error.strerror}; {whole}, {rest}", error.filename) from None
        raise


def _read_gauges(folder: Path) -> xr.Dataset:
    """The gauges' whole record: some hundred bytes a turn."""
    with xr.open_dataset(folder / "gauges.nc") as gauges:
        return gauges.load()


# ---------------------------------------------------------------------------------------------------- the metrics


def _metrics(
    simulator: Simulator,
    maps: xr.DataTree,
    truth: xr.DataTree,
    gauges: xr.Dataset | None,
    figures: Sequence[TurnFigures],
) -> dict[str, Any]:
    """The content of metrics.json, but for `run_s`."""
    scene, timing = simulator.scene, _timing(figures)
    return {
        "scene": scene.name,
        "seed": scene.seed,
        **error_figures(maps, truth),
        "measured": _measured(simulator, maps, truth),
        **_sea_state(maps if simulator.sea.patch is None else _where_true(maps, truth)),
        "hs_scene_m": 4.0 * float(simulator.sea.resolved.elevation_std),
        "gauges": judge(gauges) if gauges is not None else [],
        "timing_s": timing,
        "real_time_factor": real_time_factor(scene.turn_duration_s, figures),
        **_counts([turn.counts for turn in figures]),
        "peak_memory_bytes": peak_memory(),
        **run_facts(scene, simulator.sea, simulator.surface, timing),
    }


def _measured(simulator: Simulator, maps: xr.DataTree, truth: xr.DataTree) -> dict[str, float | None]:
    """How much is measured, how far, how much of it wrongly, and how much is missed."""
    sigma = float(simulator.sea.resolved.elevation_std)
    return CoverageProfile.of(maps["polar"].to_dataset(), truth["polar"].to_dataset(), sigma).figures


def _counts(counts: Sequence[dict[str, float]]) -> dict[str, float]:
    """Of the last turn, but for folded waves, of which the worst turn counts; and the share of the ground cells that
    the first turn's beam passed which the last one's passes still."""
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


def _where_true(maps: xr.DataTree, truth: xr.DataTree) -> xr.DataTree:
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
