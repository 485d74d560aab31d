"""All cases of a plan, in worker processes that are watched, and the table of what came of them."""

from __future__ import annotations

import multiprocessing
import shutil
import tempfile
import time
from collections import Counter
from collections.abc import Callable, Iterator
from dataclasses import dataclass
from multiprocessing.connection import Connection, wait
from pathlib import Path

from .cases import MOST_SECONDS, Case, Result, judge, limit_memory
from .originals import make
from .readers import READERS, THEIRS

_GRACE = 20  # seconds beyond a case's own limit: then a loop within a library holds it
_BATCH = 200
_CASE = "case"  # folder of the case at hand


@dataclass(frozen=True)
class Plan:
    """How many cases of scenes, and of files of all other kinds together; or a single case, KIND/NUMBER."""

    seed: int
    scenes: int
    files: int
    only: str | None = None

    def cases(self) -> list[Case]:
        if self.only:
            kind, _, number = self.only.rpartition("/")
            return [Case(self.seed, kind, int(number))]
        kinds = [kind for kind in READERS if kind != "scene"]
        files = [Case(self.seed, kinds[n % len(kinds)], n // len(kinds)) for n in range(self.files)]
        return files + [Case(self.seed, "scene", n) for n in range(self.scenes)]


def run(plan: Plan, kept: Path, workers: int, say: Callable[[str], None]) -> list[Result]:
    """The failures; a table and each of them is said."""
    begun, counts, failures = time.monotonic(), Counter[tuple[str, str]](), []
    with tempfile.TemporaryDirectory(prefix="fuzz-") as temporary:
        originals = make(Path(temporary) / "originals")
        for result in _results(plan.cases(), originals, Path(temporary), kept, workers):
            counts[result.case.kind, result.what] += 1
            if result.wrong:
                failures.append(result)
                case = result.case
                say(f"FAILED --seed {case.seed} --case '{case.kind}/{case.number}': {result.wrong}")
    columns = ("accepted", "refused", "not ours", "failed")
    say("".join(f"{name:>16}" for name in ("kind", *columns)))
    for kind in READERS:
        if any(counts[kind, name] for name in columns):
            say(f"{kind:>16}" + "".join(f"{counts[kind, name]:16d}" for name in columns))
    total = sum(counts.values())
    say(f"{total} cases in {time.monotonic() - begun:.0f} s, {len(failures)} failed; files of failures in {kept}")
    return failures


def _results(
    cases: list[Case], originals: dict[str, list[Path]], folder: Path, kept: Path, workers: int
) -> Iterator[Result]:
    """Results as they come. A worker that dies or hangs is replaced, and its case has failed."""
    context = multiprocessing.get_context("spawn")  # Zarr has threads, of which a fork would have but the locks
    batches = [cases[n : n + _BATCH] for n in range(0, len(cases), _BATCH)][::-1]
    alive: dict[Connection, _Worker] = {}
    try:
        while batches or alive:
            while batches and len(alive) < workers:
                worker = _Worker(context, batches.pop(), originals, folder, kept)
                alive[worker.heard] = worker
            ready = wait(list(alive), timeout=1.0)
            for connection, worker in list(alive.items()):
                if connection in ready:
                    result = worker.hear()
                    if result is not None:
                        yield result
                        continue
                elif time.monotonic() - worker.last < MOST_SECONDS + _GRACE:
                    continue
                del alive[connection]
                if rest := worker.end():
                    if (worker.place / _CASE / THEIRS).exists():  # HDF5 may loop for ever over a damaged file
                        yield Result(rest[0], "not ours")
                    else:
                        yield Result(rest[0], "failed", "the process crashed, or did not end")
                    batches.append(rest[1:])
    finally:
        for worker in alive.values():
            worker.end()


class _Worker:
    """A process that judges cases one after the other and tells each result."""

    def __init__(self, context, cases: list[Case], originals: dict[str, list[Path]], folder: Path, kept: Path) -> None:
        self.heard, told = context.Pipe(duplex=False)
        self.rest, self.last = cases, time.monotonic()
        self.place = Path(tempfile.mkdtemp(dir=folder))
        self.process = context.Process(target=_work, args=(told, cases, originals, self.place, kept), daemon=True)
        self.process.start()
        told.close()

    def hear(self) -> Result | None:
        try:
            result = self.heard.recv()
        except (EOFError, OSError):
            return None
        self.rest, self.last = self.rest[1:], time.monotonic()
        return result

    def end(self) -> list[Case]:
        """The cases that it has not done."""
        self.process.kill()
        self.process.join()
        self.heard.close()
        return self.rest


def _work(told: Connection, cases: list[Case], originals: dict[str, list[Path]], place: Path, kept: Path) -> None:
    limit_memory()
    for case in cases:
        result = judge(case, originals[case.kind], place / _CASE)
        if result.wrong:
            kept.mkdir(parents=True, exist_ok=True)
            shutil.copytree(
                place / _CASE, kept / f"{case.kind.replace(' ', '-')}-{case.number}", dirs_exist_ok=True, symlinks=True
            )
        told.send(result)
    told.close()
