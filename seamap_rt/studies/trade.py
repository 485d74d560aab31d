"""A sweep over keys of a scene: every combination of their values, each with several seeds, in one table.

Points are computed apart from each other, each in a file of its own, so that whatever happens to one (a limit of the
scene, an error, a killed worker), the others stay, and a sweep that was interrupted goes on where it stopped.
"""

from __future__ import annotations

import errno
import time
from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from contextlib import closing, contextmanager
from dataclasses import dataclass
from functools import partial
from itertools import product
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np
import xarray as xr

from ..compute.scratch import scratch_folder
from ..errors import InputError
from ..measured import LEVEL
from ..scene import Scene
from .paired import Choice, choose, means
from .point import Outcome, SchedulerLost, Task, compute, keep, kept
from .sweep import PRODUCTS, Sweep
from .trade_figures import layout
from .usable import Criterion

if TYPE_CHECKING:
    from distributed import Client

Progress = Callable[[str], None]
FULLY_MEASURED = (
    "fully measured radius: of a disc of perfect heights that holds as much as all cells' scores; reach: where their "
    f"mean falls below {LEVEL:g}"
)

Answers = Callable[[list[Task]], Iterator[tuple[Task, Outcome]]]


@dataclass(frozen=True)
class TradeProducts:
    """What a sweep left behind: names of files in the folder, the table, and what it comes to in a few lines."""

    folder: Path
    files: tuple[str, ...]
    table: xr.Dataset
    lines: tuple[str, ...]


def trade(
    scene: Scene,
    vary: Mapping[str, Sequence[Any]],
    seeds: int = 1,
    client: Client | None = None,
    out: str | Path | None = None,
    *,
    workers: int | None = None,
    resume: bool = False,
    overwrite: bool = False,
    criterion: Criterion | None = None,
    progress: Progress | None = None,
) -> xr.Dataset:
    """How accurate maps are, and how far they reach, over keys of the scene: a table over these keys and `seed`.

    vary: values by key, as {"radar.height_m": [3, 5, 10]}; any key of a scene file. seeds: so many, from scene.seed on
    (scene.seed, scene.seed + 1, …). Points of one seed have the same random numbers, and the same sea where its
    keys are the same, so that differences between points are more certain than the band over seeds suggests.
    client: of a running dask cluster; else `workers` processes are spawned here (default one per core), or with
    workers=0 all is computed in this process. Results have the same bits whichever it is.
    out: a folder that keeps the points' files, the table and a figure, see `write_trade`; else nothing is kept.
    """
    choice = criterion or Criterion()
    with scratch_folder() as scratch, _answers(client, None, workers) as answers:
        sweep = Sweep.of(scene, vary, seeds, Path(out or scratch).resolve())
        return _swept(sweep, answers, choice, resume, overwrite, progress, keep_table=out is not None)


def write_trade(
    scene: Scene,
    out: str | Path | None,
    vary: Mapping[str, Sequence[Any]],
    seeds: int = 1,
    *,
    scheduler: str | None = None,
    workers: int | None = None,
    resume: bool = False,
    overwrite: bool = False,
    criterion: Criterion | None = None,
    progress: Progress | None = None,
) -> TradeProducts:
    """Sweep a scene into a folder (default `runs/<scene>-trade`): points/*.json, trade.csv, trade.nc and trade.png.

    scheduler: tls://host:port (with certificates in dask's configuration) or tcp://host:port (on a network that is
    trusted) of a dask scheduler, or its file; its workers need this package, and should have one
    thread each. The folder should be one that they see too: each then writes its own points, which remain after this
    process; where it is not, this process writes what they send back. Without it, `workers` processes are spawned here
    (default one per core; 0: none, all in this process).
    resume: compute only what is missing, and what failed by an error or a killed worker; what a limit of the scene
    refused stays so. It has to be the same scene, keys, seeds and version of the package.
    Raises InputError for bad input; KeyboardInterrupt, with what is done and how to go on, when interrupted.
    """
    folder = Path(out) if out is not None else Path("runs") / f"{scene.name}-trade"
    sweep = Sweep.of(scene, vary, seeds, folder.resolve())
    notes = _network_notes(scheduler)
    say = progress or (lambda _: None)
    for note in notes:
        say(note)
    with _answers(None, scheduler, workers) as answers:
        table = _swept(sweep, answers, criterion or Criterion(), resume, overwrite, progress, keep_table=True)
    files = tuple(name for name in PRODUCTS if (folder / name).exists())
    return TradeProducts(folder, files, table, (*notes, *headline(table)))


# ------------------------------------------------------------------------------------------------------- the sweep


def _network_notes(scheduler: str | None) -> tuple[str, ...]:
    if scheduler is None:
        return ()
    from .cluster import network_notes  # takes a second

    return network_notes(scheduler)


@contextmanager
def _answers(client: Client | None, scheduler: str | None, workers: int | None) -> Iterator[Answers]:
    """What computes tasks; a local cluster is started with the first."""
    if workers is not None and (client is not None or scheduler is not None):
        raise InputError(
            f"--workers = {workers}: goes without --scheduler, whose workers run already; leave either out"
        )
    if workers is not None and workers < 0:
        raise InputError(f"--workers = {workers}: must be at least 0 (none: all in this process); raise it")
    if workers == 0:
        yield _here
        return
    from .cluster import answers_from, existing_client, on_local_cluster, refuse_while_spawned  # takes a second

    if client is not None:
        yield partial(answers_from, client)
    elif scheduler is not None:
        with existing_client(scheduler) as result:
            yield partial(answers_from, result)
    else:
        refuse_while_spawned()
        yield partial(on_local_cluster, workers)


def _here(tasks: Iterable[Task]) -> Iterator[tuple[Task, Outcome]]:
    """One after another, in this process."""
    for task in tasks:
        yield task, compute(task)


def _swept(
    sweep: Sweep,
    answers: Answers,
    criterion: Criterion,
    resume: bool,
    overwrite: bool,
    progress: Progress | None,
    keep_table: bool,
) -> xr.Dataset:
    """Compute what is missing, and make the table; when interrupted make it of what is there, and say so."""
    say = progress or (lambda _: None)
    say(f"checking {len(sweep.points)} points")
    _ = sweep.scenes  # refused before anything is written
    with sweep.prepared(resume, overwrite):
        return _computed(sweep, answers, criterion, say, keep_table)


def _computed(sweep: Sweep, answers: Answers, criterion: Criterion, say: Progress, keep_table: bool) -> xr.Dataset:
    try:
        _compute(sweep, answers, say)
        table = sweep.table(criterion)
        if keep_table:
            say("drawing")
            sweep.write(table)
    except (KeyboardInterrupt, SchedulerLost) as stop:
        if keep_table:
            sweep.write(sweep.table(criterion))
        if isinstance(stop, SchedulerLost):
            raise InputError(f"--scheduler: does not answer any more; {_settled(sweep)}, --resume goes on") from None
        raise KeyboardInterrupt(f"{_settled(sweep)}; --resume goes on") from None
    except OSError as error:
        if error.errno not in (errno.ENOSPC, errno.EDQUOT):
            raise
        raise OSError(error.errno, f"{error.strerror}; {_settled(sweep)}, --resume goes on", error.filename) from None
    return table


def _compute(sweep: Sweep, answers: Answers, say: Progress) -> None:
    tasks, start, every = sweep.missing(), time.perf_counter(), len(sweep.points)
    if not tasks:
        return
    say(f"{len(tasks)} of {every} points to compute: starting")
    failed = 0
    with closing(answers(tasks)) as results:  # type: ignore[type-var]
        for number, (task, outcome) in enumerate(results, 1):
            if kept(task.file) is None:  # its worker could not write it
                keep(task, outcome)
            failed += outcome["status"] != "done"
            left = (time.perf_counter() - start) / number * (len(tasks) - number)
            words = f"{every - len(tasks) + number} of {every} points, about {_minutes(left)} left"
            say(words + (f"; {failed} came to nothing, last: {outcome['reason']}" if outcome["reason"] else ""))


def _minutes(seconds: float) -> str:
    return f"{seconds:.0f} s" if seconds < 100.0 else f"{seconds / 60.0:.0f} min"


def _settled(sweep: Sweep) -> str:
    done = sum(outcome["status"] in ("done", "refused") for outcome in sweep.outcomes().values())
    return f"{done} of {len(sweep.points)} points are done and stay"


def headline(table: xr.Dataset) -> Iterator[str]:
    """What a sweep comes to: how its points ended, where the usable range is longest, and what it cost."""
    status = table["status"].values
    counts = {name: int(np.count_nonzero(status == name)) for name in ("done", "refused", "failed", "missing")}
    yield f"{status.size} points: " + ", ".join(f"{count} {name}" for name, count in counts.items() if count)
    for name in ("refused", "failed"):
        reasons = sorted(set(table["reason"].values[status == name]))
        if reasons:
            yield f"{name}, {'all' if len(reasons) == 1 else 'one'} of them: {reasons[0]}"
    radius = table["fully_measured_radius_m"]
    if radius.notnull().any():
        yield from recommendations(table)
        yield FULLY_MEASURED
    seconds, most = table["cost_s"].values, table["peak_memory_bytes"].values
    if np.isfinite(seconds).any():
        memory = f", at most {np.nanmax(most) / 1e9:.2g} GB" if np.isfinite(most).any() else ""
        yield f"{np.nanmean(seconds):.1f} s a point{memory}"


def recommendations(table: xr.Dataset) -> Iterator[str]:
    """What to choose of the antenna's height, or of the key with the most numbers, for each choice of the others, by
    the fully measured radius; the best of all where no key's values are numbers."""
    radius = table["fully_measured_radius_m"]
    key = "radar.height_m" if radius.sizes.get("radar.height_m", 1) > 1 else layout(table).along
    others = [str(dim) for dim in radius.dims if dim not in (key, "seed")]
    if table[key].dtype.kind != "f":
        mean = means(radius)["mean"]
        best = mean.isel(mean.argmax(...))
        where = ", ".join(f"{name} = {_label(best[name].item())}" for name in mean.dims if mean.sizes[name] > 1)
        yield f"greatest fully measured radius {best.item():.0f} m" + (f", at {where}" if where else "")
        return
    for at in product(*(range(radius.sizes[name]) for name in others)):
        here = table.isel(dict(zip(others, at, strict=True)))
        choice = choose(here["fully_measured_radius_m"], key)
        if choice is None:
            continue
        words = [f"{name} = {_label(here[name].item())}" for name in others if radius.sizes[name] > 1]
        yield (", ".join(words) + ": " if words else "") + f"{choice}; {_there(table, here, choice)}"


def _there(table: xr.Dataset, here: xr.Dataset, choice: Choice) -> str:
    """How much is measured at what is chosen; the band is pooled over the whole table."""
    at = here[choice.key].values.tolist().index(choice.value)
    band = means(table["fully_measured_radius_m"])
    same = {name: here[name] for name in band.dims if name != choice.key}
    radius = band.sel(same).isel({choice.key: at})
    half = 0.5 * float(radius["high"] - radius["low"])
    one = here.isel({choice.key: at})
    wide = f" ± {half:.0f}" if np.isfinite(half) else ""
    more = "at least " if float(one["reach_to_the_end"].max()) > 0.0 else ""
    return (
        f"fully measured radius {float(radius['mean']):.0f}{wide} m, reach {more}{float(one['reach_m'].mean()):.0f} m, "
        f"{float(one['gross_share'].mean()):.1%} of the heights wrong by more than half the wave height"
    )


def _label(value: Any) -> str:
    return f"{value:g}" if isinstance(value, float) else str(value)
