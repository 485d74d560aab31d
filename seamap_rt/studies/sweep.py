"""A sweep over keys of a scene: every combination of their values, each with several seeds, in one table.

Points are computed apart from each other, each in a file of its own, so that whatever happens to one (a limit of the
scene, an error, a killed worker), the others stay, and a sweep that was interrupted goes on where it stopped.
Those of one sea follow each other in one process, which keeps the sea. Of a sweep's folder:

trade.json    what is swept: scene, keys and values, seeds, version of the package
points/*.json what came of each point
trade.csv, trade.nc, trade.png, trade.html
"""

from __future__ import annotations

import errno
import hashlib
import json
import time
import tomllib
from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from contextlib import closing, contextmanager
from dataclasses import dataclass, field
from functools import cached_property, partial
from pathlib import Path
from typing import TYPE_CHECKING, Any

from .. import __version__
from ..compute.locks import scratch_folder
from ..errors import InputError, is_interruption
from ..io.opening import open_file, read_json
from ..io.process import Progress, duration, hold_interruptions, ignore_progress
from ..io.results_folder import clear_folder, remove_hidden, results_folder, write_whole
from ..scene import Scene, SceneLike, as_scene
from .choices import headline, least_confidence, outlook_columns
from .paired import Goal
from .point import CACHE, MANIFEST, POINTS, BySea, Outcome, SchedulerLost, Task, compute, ended, keep, load_point
from .trade_table import Criterion, rows, trade_page, trade_table
from .vary import Grid, chosen_key, refuse_limit, seeds_of

if TYPE_CHECKING:
    import xarray as xr
    from distributed import Client


Answers = Callable[[list[Task]], Iterator[tuple[Task, Outcome]]]
_POINT_FILES = "[0-9][0-9][0-9][0-9][0-9]_*.json"  # what a user keeps there has other names
PRODUCTS = ("trade.html", MANIFEST, "trade.csv", "trade.nc", "trade.png")


@dataclass(frozen=True)
class Sweep(Grid):
    """A grid of points and the folder that they are kept in. Raises InputError where no point can be run."""

    folder: Path
    notes: list[str] = field(default_factory=list, compare=False)  # which files of points were not believed

    def with_seeds(self, seeds: int) -> Sweep:
        """The same with so many seeds; the manifest, where there is one, says so."""
        result = Sweep(self.scene, self.vary, seeds_of(self.scene, seeds), self.folder, self.notes)
        write_whole(self.folder / MANIFEST, json.dumps(result.manifest, indent=1))
        return result

    @cached_property
    def manifest(self) -> dict[str, Any]:
        """What the results depend on."""
        return {
            "version": __version__,
            "scene": self.scene.to_toml(),
            "vary": [[key, values] for key, values in self.vary.items()],
            "seeds": self.seeds,
            "files": self._files(),
        }

    def _files(self) -> dict[str, str]:
        """Fingerprints of the files that the scenes name: spectra, patterns, motions, objects."""
        trees = [tomllib.loads(scene.to_toml()) for scene in self.scenes if isinstance(scene, Scene)]
        paths = sorted({path for tree in trees for path in _named_files(tree)})
        return {path: _hash(path) for path in paths if Path(path).is_file()}

    # ----------------------------------------------------------------------------------------------- the folder

    @contextmanager
    def prepared(self, resume: bool, overwrite: bool) -> Iterator[None]:
        """The folder, held by this process and ready for the missing points.

        Raises InputError for a folder that holds something else, or which another process holds.
        """
        if resume and overwrite:
            raise InputError("--resume and --overwrite: one goes on with what is there, the other removes it; give one")
        file = self.folder / MANIFEST
        if resume:
            self._refuse_another(file)
        elif file.exists() and not overwrite:
            raise InputError(
                f"--out = '{self.folder}': holds a sweep already; give --resume to go on with it or --overwrite to "
                "begin anew, or choose another folder"
            )
        with results_folder(self.folder, resume or overwrite, PRODUCTS):
            if resume:
                remove_hidden(self.folder, PRODUCTS)
            else:
                clear_folder(self.folder, PRODUCTS)
            points = self.folder / POINTS
            points.mkdir(exist_ok=True)
            for left in (*points.glob(".*.part"), *(() if resume else points.glob(_POINT_FILES))):
                left.unlink()
            write_whole(file, json.dumps(self.manifest, indent=1))
            yield

    def _refuse_another(self, file: Path) -> None:
        try:
            stored = dict(read_json(file))
        except (OSError, ValueError, TypeError, RecursionError):
            raise InputError(
                f"--resume: '{file.parent}' holds no sweep; leave --resume out, or name its folder"
            ) from None
        words = {
            "version": f"version of seamap_rt ({stored.get('version')}, this is {__version__})",
            "scene": "scene",
            "vary": "grid of --vary",
            "files": "content of the files that the scene names",
        }
        for key, what in words.items():
            if stored.get(key) != self.manifest[key]:
                raise InputError(f"--resume: '{file.parent}' holds a sweep of another {what}; choose another folder")

    # ----------------------------------------------------------------------------------------------- the points

    @cached_property
    def tasks(self) -> list[Task]:
        """What a worker computes at each point; without a scene where it has none."""
        result = []
        for point, scene in zip(self.points, self.scenes, strict=True):
            text, sea = "", ""
            if isinstance(scene, Scene):
                text = scene.to_toml()
                sea = hashlib.sha256(f"{scene.seed} {scene.sea.model_dump_json()}".encode()).hexdigest()
            result.append(Task(point.name, text, point.keys, point.seed, str(self.folder), sea))
        return result

    def missing(self) -> list[Task]:
        """Points to compute: those without a result, and those that failed. What the scene refuses is noted at once."""
        wanted: list[Task] = []
        for task, scene in zip(self.tasks, self.scenes, strict=True):
            outcome, why_not = load_point(task)
            if why_not:
                self.notes.append(f"{POINTS}/{task.file.name}: {why_not}; the point is run again")
            if outcome is not None and outcome["status"] in ("done", "refused"):
                continue
            task.file.unlink(missing_ok=True)
            if isinstance(scene, InputError):
                keep(task, ended(task, "refused", "; ".join(scene.problems)))
            else:
                wanted.append(task)
        return wanted

    def outcomes(self) -> dict[tuple[int, ...], Outcome]:
        """What is there, by the point's place in the grid."""
        found = ((point.index, load_point(task)[0]) for point, task in zip(self.points, self.tasks, strict=True))
        return {index: outcome for index, outcome in found if outcome is not None}

    def table(self, options: TradeOptions) -> xr.Dataset:
        """The results so far over the varied keys and seeds."""
        about: dict[str, Any] = {"title": f"{self.scene.name}: {' × '.join(self.vary)}", "scene": self.scene.to_toml()}
        about["polarization"] = self.scene.scattering.polarization
        if options.at_most is not None:
            about["at_most"] = options.at_most
        criterion = options.criterion or Criterion()
        table = trade_table(self.vary, self.seeds, self.outcomes(), criterion, about)
        return table.merge(outlook_columns(self, table["range"].values), join="left")

    def write(self, table: xr.Dataset) -> None:
        """The table and its figure, as files."""
        # Matplotlib takes its time to load, and workers draw nothing.
        from ..report import style
        from .trade_figures import draw_trade, trade_images

        with hold_interruptions():
            write_whole(self.folder / "trade.csv", rows(table))
            # By way of memory: HDF5 itself may crash on a full disk.
            write_whole(self.folder / "trade.nc", bytes(table.to_netcdf(engine="h5netcdf")))
        figure = style.png(draw_trade(table))
        write_whole(self.folder / "trade.png", figure)
        write_whole(self.folder / "trade.html", trade_page(table, trade_images(table, figure)))


def _named_files(tree: Any) -> Iterator[str]:
    """What stands under the keys `file` and `mesh`, anywhere in a scene."""
    if isinstance(tree, Mapping):
        yield from (tree[key] for key in ("file", "mesh") if isinstance(tree.get(key), str))
    if isinstance(tree, Mapping | list):
        for each in tree.values() if isinstance(tree, Mapping) else tree:
            yield from _named_files(each)


def _hash(path: str) -> str:
    with open_file(path) as file:
        return hashlib.file_digest(file, "sha256").hexdigest()


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
        yield _compute_serially
        return
    from .cluster import existing_client, gather_results, open_local_cluster, refuse_while_spawned  # takes a second

    if client is not None:
        yield partial(gather_results, client)
    elif scheduler is not None:
        with existing_client(scheduler) as result:
            yield partial(gather_results, result)
    else:
        refuse_while_spawned()
        with open_local_cluster(workers) as result:
            yield result


def _compute_serially(tasks: Iterable[Task]) -> Iterator[tuple[Task, Outcome]]:
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
    say = options.progress or ignore_progress
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
        return _computed(sweep, answers, options, say, keep_table)


def _computed(sweep: Sweep, answers: Answers, options: TradeOptions, say: Progress, keep_table: bool) -> xr.Dataset:
    start, computed = time.perf_counter(), 0.0
    try:
        while True:
            computed += _compute(sweep, answers, say) * len(sweep.seeds) / len(sweep.points)
            table = sweep.table(options)
            have, sure = len(sweep.seeds), least_confidence(table)
            seeds = options.seeds(have, computed, sure, time.perf_counter() - start)
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
            sweep.write(sweep.table(options))
        if interrupted:
            raise KeyboardInterrupt(f"{_status(sweep)}; --resume goes on") from None
        if isinstance(error, SchedulerLost):
            raise InputError(f"--scheduler: does not answer any more; {_status(sweep)}, --resume goes on") from None
        if isinstance(error, OSError) and error.errno in (errno.ENOSPC, errno.EDQUOT):
            message = f"{error.strerror}; {_status(sweep)}, --resume goes on"
            raise OSError(error.errno, message, error.filename) from None
        raise
    return table


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
