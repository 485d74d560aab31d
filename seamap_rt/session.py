"""One run: simulate, retrieve, compare, draw, into a folder that no other run's results are lost in."""

from __future__ import annotations

import errno
import json
import math
import os
import shutil
import time
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
import xarray as xr

from .account import costed
from .compute.machine import peak_memory
from .echoes.files import EchoStore
from .errors import InputError
from .gauges import GaugeFile, gauge_series, judge
from .interferometry import open_echoes, retrieve_one
from .io.growing import all_or_none
from .io.interrupts import uninterrupted
from .io.turnfile import TurnFile
from .metrics import compare
from .radar.scan import sector_width, turn_duration
from .report import write_report
from .scene import Scene
from .simulation import Simulator, Stopwatch
from .wavefield import sea_state
from .wavefield.sea_state import in_words

_PRODUCTS = (
    "scene.toml",
    "echoes.zarr",
    "maps.nc",
    "truth.nc",
    "gauges.nc",
    "metrics.json",
    "report.html",
    "evolution.gif",
)
Progress = Callable[[str], None]


@dataclass(frozen=True)
class RunResult:
    """What a run left behind."""

    folder: Path
    metrics: dict[str, Any]


def prepare_folder(folder: Path, overwrite: bool, products: tuple[str, ...] = _PRODUCTS) -> None:
    """Make the folder, or say in one line why not: unwritable, a file, or another run's results without overwrite."""
    try:
        folder.mkdir(parents=True, exist_ok=True)
    except OSError as error:
        raise InputError(
            f"--out = '{folder}': cannot be made ({error.strerror or error}); choose a folder that you can write to"
        ) from None
    if not os.access(folder, os.W_OK | os.X_OK):
        raise InputError(f"--out = '{folder}': cannot be written to; choose a folder that you can write to")
    found = [name for name in products if (folder / name).exists()]
    if found and not overwrite:
        raise InputError(
            f"--out = '{folder}': holds another run's {found[0]}; choose another folder, or give --overwrite"
        )


def clear_folder(folder: Path, products: tuple[str, ...] = _PRODUCTS) -> None:
    """Remove an earlier run's products, figures too, so that an interrupted run never stands beside an older report.

    Call it only when nothing can be refused any more.
    """
    figures = [path.name for path in folder.glob("*.png")] if "report.html" in products else []
    for name in (*products, *figures):
        path = folder / name
        if path.is_dir():
            shutil.rmtree(path)
        else:
            path.unlink(missing_ok=True)


def write_whole(path: Path, content: str | bytes) -> None:
    """Write a file that appears whole or not at all."""
    part = path.with_name(f".{path.name}.part")
    try:
        part.write_bytes(content if isinstance(content, bytes) else content.encode("utf-8"))
        os.replace(part, path)
    finally:
        part.unlink(missing_ok=True)


def run(
    scene: Scene, out: str | Path | None = None, *, overwrite: bool = False, progress: Progress | None = None
) -> RunResult:
    """Simulate, retrieve, compare and draw all turns of a scene into a folder (default `runs/<scene>-<seed>`).

    Results stream turn by turn, so memory holds one turn. Interrupted, complete turns stay readable.
    Raises InputError for bad input, NoBackend if rays cannot be traced.
    """
    say = progress or (lambda _: None)
    start = time.perf_counter()
    folder = Path(out) if out is not None else Path("runs") / f"{scene.name}-{scene.seed}"
    prepare_folder(folder, overwrite)
    say("preparing the sea and the tracer")
    simulator = Simulator(scene)
    clear_folder(folder)
    write_whole(folder / "scene.toml", scene.to_toml())
    retrieval = scene.resolved_retrieval
    timings: list[dict[str, float]] = []
    store = EchoStore(folder / "echoes.zarr")
    counts: dict[str, float] = {}
    seen: list[int] = []  # ground cells that the turns' beams passed
    truth_file, maps_file = TurnFile(folder / "truth.nc"), TurnFile(folder / "maps.nc")
    gauge_file = GaugeFile(folder / "gauges.nc")
    with store, truth_file, maps_file, gauge_file, _told(truth_file, scene.turns):
        for number in range(scene.turns):
            say(f"turn {number + 1} of {scene.turns}: simulating")
            turn = simulator.turn(number)
            clock = Stopwatch()
            say(f"turn {number + 1} of {scene.turns}: retrieving")
            with clock("retrieve"):
                maps = retrieve_one(turn.echoes, retrieval)
            with clock("truth"):
                gauges = _gauges(simulator, maps, turn.truth, number)
            with clock("write"), uninterrupted(), all_or_none(truth_file, maps_file, gauge_file):
                truth_file.append(turn.truth)
                maps_file.append(maps)
                if gauges is not None:
                    gauge_file.append(gauges)
                store.append(turn.echoes)
            timings.append(_added(turn.timing, clock.seconds))
            seen.append(int(np.isfinite(maps["ground"].to_dataset()["time"].values).sum()))
            counts = {
                "facets": turn.facets,
                "rays": turn.rays,
                "slope_rms_look": turn.slope_rms_look,
                "folded_share": max(turn.folded_share, counts.get("folded_share", 0.0)),
            }
    say("comparing and drawing")
    gauges = _read_gauges(folder) if scene.gauges else None
    with xr.open_datatree(folder / "maps.nc") as maps, xr.open_datatree(folder / "truth.nc") as truth:
        metrics = {
            "scene": scene.name,
            "seed": scene.seed,
            **compare(maps, truth),
            **_sea_state(maps),
            "gauges": judge(gauges) if gauges is not None else [],
            "timing_s": _timing(timings),
            "real_time_factor": _real_time_factor(scene, timings),
            "ground_covered": seen[-1] / max(seen[0], 1),
            **counts,
            "peak_memory_bytes": peak_memory(),
            **simulator.facts(),
        }
        metrics["modelled"] = costed(metrics["modelled"], metrics["timing_s"])
        metrics["run_s"] = time.perf_counter() - start
        write_report(folder, scene, maps, truth, metrics, open_echoes(folder / "echoes.zarr"), gauges)
    metrics["run_s"] = time.perf_counter() - start
    metrics["peak_memory_bytes"] = peak_memory()
    write_whole(folder / "metrics.json", json.dumps(_json(metrics), indent=1, allow_nan=False))
    return RunResult(folder, metrics)


def _gauges(simulator: Simulator, maps: xr.DataTree, truth: xr.DataTree, number: int) -> xr.Dataset | None:
    """What the scene's gauges read in a turn; None without any."""
    scene, period = simulator.scene, turn_duration(simulator.radar)
    if not scene.gauges:
        return None
    middle = simulator.sensed.pose(np.array([(number + 0.5) * period])).origin[0, :2]
    return gauge_series(maps, simulator.sea, scene.gauges, truth, turn_s=period, antenna_m=middle)


def _read_gauges(folder: Path) -> xr.Dataset:
    """The gauges' whole record: some hundred bytes a turn."""
    with xr.open_dataset(folder / "gauges.nc") as gauges:
        return gauges.load()


def _sea_state(maps: xr.DataTree) -> dict[str, Any]:
    """What the maps say of the sea, turn by turn, and in words."""
    state = sea_state(maps)
    return {
        "sea_state": {str(name): values.values.tolist() for name, values in state.data_vars.items()},
        "sea_state_in_words": in_words(state),
    }


@contextmanager
def _told(file: TurnFile, turns: int) -> Iterator[None]:
    """An interruption, or a full disk, that says what is left."""
    try:
        yield
    except BaseException as error:
        whole = f"{file.complete} of {turns} turns are complete"
        rest = "and stay readable; metrics.json and report.html are missing"
        if not file.complete:  # a scene without results would look like another run's folder
            file.path.with_name("scene.toml").unlink(missing_ok=True)
            rest = "no results are left"
        if isinstance(error, KeyboardInterrupt):
            raise KeyboardInterrupt(f"{whole}, {rest}") from None
        if isinstance(error, OSError) and error.errno in (errno.ENOSPC, errno.EDQUOT):
            raise OSError(error.errno, f"{error.strerror}; {whole}, {rest}", error.filename) from None
        raise


def _added(first: dict[str, float], then: dict[str, float]) -> dict[str, float]:
    """Seconds per step of a turn's two halves; the total grows by the second."""
    steps = {step: first.get(step, 0.0) + then.get(step, 0.0) for step in (*first, *then)}
    return {**steps, "total": first["total"] + sum(then.values())}


def _timing(timings: list[dict[str, float]]) -> dict[str, Any]:
    """The first turn (which compiles and builds), and the mean of the warm ones if there are any."""
    warm = timings[1:]
    mean = {step: sum(t.get(step, 0.0) for t in warm) / len(warm) for step in timings[0]} if warm else None
    return {"first": timings[0], "warm": mean}


def _real_time_factor(scene: Scene, timings: list[dict[str, float]]) -> float | None:
    """The turn's own duration over the wall time of sea, mesh, trace and echoes of a warm turn; None without one."""
    warm = _timing(timings)["warm"]
    if warm is None:
        return None
    busy = sum(warm[step] for step in ("sea", "mesh", "trace", "echoes"))
    return turn_duration(scene.radar) * sector_width(scene.radar) / 360.0 / busy


def _json(value: Any) -> Any:
    """Plain JSON values; what is not finite becomes null."""
    if isinstance(value, dict):
        return {str(k): _json(v) for k, v in value.items()}
    if isinstance(value, list | tuple):
        return [_json(v) for v in value]
    if hasattr(value, "item"):
        value = value.item()
    if isinstance(value, float) and not math.isfinite(value):
        return None
    return value
