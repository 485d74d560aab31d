"""A sweep over keys of a scene: every combination of their values, each with several seeds, in one table.

Points are computed apart from each other, each in a file of its own, so that whatever happens to one (a limit of the
scene, an error, a killed worker), the others stay, and a sweep that was interrupted goes on where it stopped.
Those of one sea follow each other in one process, which keeps the sea.
"""

from __future__ import annotations

import errno
import time
from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from contextlib import closing, contextmanager
from dataclasses import dataclass
from functools import partial
from pathlib import Path
from typing import TYPE_CHECKING, Any

from ..compute.locks import scratch_folder
from ..errors import InputError, is_interruption
from ..io.process import Progress, duration, silent
from ..scene import SceneLike, as_scene
from .choices import headline, least_confidence
from .paired import Goal
from .point import CACHE, BySea, Outcome, SchedulerLost, Task, compute, keep, load_point
from .sweep import PRODUCTS, Sweep
from .trade_table import Criterion
from .vary import chosen_key, refuse_limit

if TYPE_CHECKING:
    import xarray as xr
    from distributed import Client


Answers = Callable[[list[Task]], Iterator[tuple[Task, Outcome]]]


@dataclass(frozen=True)
class TradeProducts:
    """What a sweep left behind: names of files in the folder, the table, and what it comes to in a few lines."""

    folder: Path
    files: tuple[str, ...]
    table: xr.Dataset
    lines: tuple[str, ...]


@dataclass(frozen=True)
class TradeOptions(Goal):
    """How a trade is run and when it ends.

    workers: processes that are spawned here (default one per core; 0: none, all in this process). until, budget_s:
    seeds are added until every choice (see `recommendations`) has this confidence, 0.5 to 1, or so many seconds are
    over; at most 64 seeds. at_most: of the varied height (or the key with the most numbers), the greatest value that is
    recommended. resume: compute only what is missing, and what failed by an error or a killed worker; what a limit of
    the scene refused stays so. It has to be the same scene, keys and version of the package; the seeds may be more or
    fewer.
    """

    workers: int | None = None
    resume: bool = False
    overwrite: bool = False
    criterion: Criterion | None = None
    progress: Progress | None = None


def trade(
    scene: SceneLike,
    vary: Mapping[str, Sequence[Any]],
    seeds: int = 1,
    client: Client | None = None,
    out: str | Path | None = None,
    **options: Any,
) -> xr.Dataset:
    """How accurate maps are, and how far they reach, over keys of the scene: a table over these keys and `seed`.

    vary: values by key, as {"radar.height_m": [3, 5, 10]}; any key of a scene file. seeds: so many, from scene.seed on
    (scene.seed, scene.seed + 1, …). Points of one seed have the same random numbers, and the same sea where its
    keys are the same, so that differences between points are more certain than the band over seeds suggests.
    client: of a running dask cluster; without it the work is done by processes of this machine. Results have the same
    bits whichever it is. out: a folder that keeps the points' files, the table and a figure, see `write_trade`; else
    nothing is kept. options: of `TradeOptions`.
    """
    with scratch_folder() as scratch:
        sweep = Sweep.of(as_scene(scene), vary, seeds, Path(out or scratch).resolve())
        return _swept(sweep, TradeOptions(**options), client, keep_table=out is not None)


def write_trade(
    scene: SceneLike,
    out: str | Path | None,
    vary: Mapping[str, Sequence[Any]],
    seeds: int = 1,
    *,
    scheduler: str | None = None,
    **options: Any,
) -> TradeProducts:
    """Sweep a scene into a folder (default `runs/<scene>-trade`): points/*.json, trade.csv, trade.nc, trade.png
    and trade.html, the page that says what to choose.

    scheduler: tls://host:port (with certificates in dask's configuration) or tcp://host:port (on a network that is
    trusted) of a dask scheduler, or its file; its workers need this package, and should have one
    thread each. The folder should be one that they see too: each then writes its own points, which remain after this
    process; where it is not, this process writes what they send back. options: of `TradeOptions`.
    Raises InputError for bad input; KeyboardInterrupt, with what is done and how to go on, when interrupted.
    """
    scene = as_scene(scene)
    folder = Path(out) if out is not None else Path("runs") / f"{scene.name}-trade"
    sweep = Sweep.of(scene, vary, seeds, folder.resolve())
    how = TradeOptions(**options)
    table = _swept(sweep, how, scheduler=scheduler)
    files = tuple(name for name in PRODUCTS if (folder / name).exists())
    ended = how.reason(table.sizes["seed"], least_confidence(table))
    lines = (*sweep.notes, *((ended,) if ended else ()), *headline(table))
    return TradeProducts(folder, files, table, lines)


# ------------------------------------------------------------------------------------------------------- the sweep


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
        with on_local_cluster(workers) as result:
            yield result


def _here(tasks: Iterable[Task]) -> Iterator[tuple[Task, Outcome]]:
    """One after another, in this process."""
    waiting = BySea(tasks)
    try:
        while (task := waiting.take("here")) is not None:
            yield task, compute(task)
    finally:
        CACHE.forget()


def _swept(
    sweep: Sweep,
    options: TradeOptions,
    client: Client | None = None,
    scheduler: str | None = None,
    keep_table: bool = True,
) -> xr.Dataset:
    """Compute what is missing, and make the table; when interrupted make it of what is there, and say so."""
    say = options.progress or silent
    say(f"checking {len(sweep.points)} points")
    _ = sweep.scenes  # refused before anything is written, and before the libraries of a cluster are loaded
    if options.until is not None and not chosen_key(sweep.vary):
        raise InputError(
            "--until: no varied key is a number that a design chooses (the sea, the scattering and the boat are "
            "given), so there is nothing to be sure of; leave it out"
        )
    refuse_limit(sweep.vary, options.at_most)
    if scheduler is not None:
        from .cluster import network_notes  # takes a second

        sweep.notes.extend(network_notes(scheduler))
    with _answers(client, scheduler, options.workers) as answers, sweep.prepared(options.resume, options.overwrite):
        return _computed(sweep, answers, options.criterion or Criterion(), options, say, keep_table)


def _computed(
    sweep: Sweep, answers: Answers, criterion: Criterion, goal: Goal, say: Progress, keep_table: bool
) -> xr.Dataset:
    start, computed = time.perf_counter(), 0.0
    try:
        while True:
            computed += _compute(sweep, answers, say) * len(sweep.seeds) / len(sweep.points)
            table = _table(sweep, criterion, goal)
            have, sure = len(sweep.seeds), least_confidence(table)
            seeds = goal.seeds(have, computed, sure, time.perf_counter() - start)
            if seeds == have:
                break
            least = f"least sure of the choices {sure:.0%}; " if sure >= 0.0 else ""
            say(f"{have} seed{'s' * (have > 1)}: {least}{seeds - have} more")
            sweep = sweep.with_seeds(seeds)
        if keep_table:
            say("drawing")
            sweep.write(table)
    except BaseException as error:
        interrupted = is_interruption(error)
        if keep_table and (interrupted or isinstance(error, SchedulerLost)):
            sweep.write(_table(sweep, criterion, goal))
        if interrupted:
            raise KeyboardInterrupt(f"{_status(sweep)}; --resume goes on") from None
        if isinstance(error, SchedulerLost):
            raise InputError(f"--scheduler: does not answer any more; {_status(sweep)}, --resume goes on") from None
        if isinstance(error, OSError) and error.errno in (errno.ENOSPC, errno.EDQUOT):
            message = f"{error.strerror}; {_status(sweep)}, --resume goes on"
            raise OSError(error.errno, message, error.filename) from None
        raise
    return table


def _table(sweep: Sweep, criterion: Criterion, goal: Goal) -> xr.Dataset:
    table = sweep.table(criterion)
    return table if goal.at_most is None else table.assign_attrs(at_most=goal.at_most)


def _compute(sweep: Sweep, answers: Answers, say: Progress) -> int:
    """How many points were missing, and are no more."""
    tasks, start, every = sweep.missing(), time.perf_counter(), len(sweep.points)
    for note in sweep.notes:
        say(note)
    if not tasks:
        return 0
    say(f"{every - len(tasks)} of {every} points, … left: starting")
    failed = 0
    with closing(answers(tasks)) as results:  # type: ignore[type-var]
        for number, (task, outcome) in enumerate(results, 1):
            if load_point(task)[0] is None:  # its worker could not write it
                keep(task, outcome)
            failed += outcome["status"] != "done"
            left = (time.perf_counter() - start) / number * (len(tasks) - number)
            words = f"{every - len(tasks) + number} of {every} points, about {duration(left)} left"
            say(words + (f"; {failed} came to nothing, last: {outcome['reason']}" if outcome["reason"] else ""))
    return len(tasks)


def _status(sweep: Sweep) -> str:
    done = sum(outcome["status"] in ("done", "refused") for outcome in sweep.outcomes().values())
    return f"{done} of {len(sweep.points)} points are done and stay"
