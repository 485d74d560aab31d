"""What the page has done in processes of its own: runs one by one, and drawings, so that it answers meanwhile.

A run is the command line, and leaves its story in files.

A job's files lie in `.jobs` below the runs: `NAME.toml` the scene, `NAME.json` what it is, `NAME.progress` a line for
each step with its time, `NAME.errors` what the process said. So a page that is opened again finds them, and so does a
server that is started again, whose runs went on without it. A number of a process in a file proves nothing: another one
may have it by now. A run is known as this server's child, or by the file of progress that its own environment names.
"""

from __future__ import annotations

import asyncio
import contextlib
import json
import multiprocessing
import os
import pickle
import re
import signal
import subprocess
import sys
import threading
import time
from collections.abc import Callable, Sequence
from concurrent.futures import BrokenExecutor, ProcessPoolExecutor
from dataclasses import asdict, dataclass, field
from pathlib import Path
from typing import Annotated, Any, Literal, TypeVar

import numpy as np
from annotated_types import MinLen
from pydantic import TypeAdapter

from ..compute.machine import cores
from ..errors import InputError, one_line
from ..io.opening import open_file, read_bytes
from ..io.process import VARIABLE
from ..io.results_folder import write_whole

FOLDER = ".jobs"
_ENDED = ("done", "cancelled", "failed")
State = Literal["queued", "running", "done", "cancelled", "failed"]
_LAST = 4096  # bytes of what a process said that are read
_POLL_S = 0.2
_MEASURED, _NICE = 3, 5


@dataclass
class Job:
    """One run, trade or other command.

    state: queued, running, done, cancelled or failed. words: the command's arguments, without the program. reason: why
    it ended, if not by itself. started, ended: Unix time, 0 before.
    """

    name: str
    title: str
    folder: str  # of its results, relative to the runs
    words: Annotated[tuple[str, ...], MinLen(1)]
    state: State = "queued"
    reason: str = ""
    pid: int = 0
    asked: float = field(default_factory=time.time)
    started: float = 0.0
    ended: float = 0.0
    guess_s: float = 0.0  # how long it was expected to take, on the machine that the guess was made for
    crowd: float = 1.0  # how many wanted each core when it ended, this job's own threads among them

    @property
    def over(self) -> bool:
        return self.state in _ENDED


_JOB = TypeAdapter(Job)


class Queue:
    """Runs jobs one after another. runs: the folder below which all of them write. program: what runs the command."""

    def __init__(self, runs: Path, program: Sequence[str] = (sys.executable, "-P", "-m", "seamap_rt.cli")) -> None:
        runs = runs.resolve()
        self._runs, self._folder, self._program = runs, runs / FOLDER, tuple(program)
        self._folder.mkdir(parents=True, exist_ok=True)
        self._jobs: dict[str, Job] = {}
        self._processes: dict[str, subprocess.Popen[bytes]] = {}
        self._change = threading.Condition()
        self._closing = False
        self._find()
        self._worker = threading.Thread(target=self._work, daemon=True, name="runs")
        self._worker.start()

    # -------------------------------------------------------------------------------------------------- asking

    def add(self, title: str, folder: str, scene_toml: str, words: Sequence[str], guess_s: float = 0.0) -> Job:
        """Queue a command: `words` with "{scene}" for the scene's file and "{out}" for the results' folder."""
        with self._change:
            name = self._new_name(folder)
            scene = self._folder / f"{name}.toml"
            write_whole(scene, scene_toml)
            out = str(self._runs / folder)
            filled = tuple(word.replace("{scene}", str(scene)).replace("{out}", out) for word in words)
            job = Job(name, title, folder, filled, guess_s=guess_s)
            self._jobs[name] = job
            self._note(job)
            self._change.notify_all()
            return job

    def jobs(self) -> list[Job]:
        """All, the one asked for last first."""
        with self._change:
            return sorted(self._jobs.values(), key=lambda job: job.asked, reverse=True)

    def job(self, name: str) -> Job | None:
        """By its name."""
        with self._change:
            return self._jobs.get(name)

    def of_folder(self, folder: str) -> Job | None:
        """The last one that writes, or wrote, into a folder."""
        return next((job for job in self.jobs() if job.folder == folder), None)

    def progress(self, job: Job) -> Progress:
        """How far a job is."""
        return read_progress(Path(self._progress_path(job)), job, pace=self.pace(job.words[0]))

    def pace(self, kind: str) -> float | None:
        """What a command takes now over what is guessed, by the last three of its kind that were done here and by how
        many want each core now and wanted it then; None where none was done."""
        done = [job for job in self.jobs() if job.state == "done" and job.words[0] == kind and job.guess_s > 0.0]
        took = [(job.ended - job.started) / (job.guess_s * job.crowd) for job in done[:_MEASURED]]
        return float(np.median(took)) * _crowd() if took else None

    # ------------------------------------------------------------------------------------------------ stopping

    def cancel(self, name: str) -> None:
        """End a job: a queued one is not begun; a running one keeps its whole turns. Asked again, it is killed."""
        with self._change:
            job = self._jobs.get(name)
            if job is None or job.over:
                return
            if job.state == "queued":
                job.state, job.reason, job.ended = "cancelled", "cancelled before it began", time.time()
                self._note(job)
                return
            again = job.reason != ""
            job.reason = "asked to end"
        with contextlib.suppress(ProcessLookupError, PermissionError):
            if not self._lives(job):
                return
            if again:
                os.killpg(job.pid, signal.SIGKILL)
            else:
                os.kill(job.pid, signal.SIGTERM)

    def forget(self, name: str) -> None:
        """Take a job that is over off the list; what it wrote stays."""
        with self._change:
            job = self._jobs.get(name)
            if job is not None and job.over:
                del self._jobs[name]
                for ending in ("json", "toml", "progress", "errors"):
                    (self._folder / f"{name}.{ending}").unlink(missing_ok=True)

    def close(self, wait_s: float = 15.0) -> None:
        """End what this queue began, so that whole turns stay, and begin nothing more."""
        with self._change:
            self._closing = True
            running = list(self._processes)
            self._change.notify_all()
        for name in running:
            self.cancel(name)
        self._worker.join(wait_s)

    # ------------------------------------------------------------------------------------------------- working

    def _work(self) -> None:
        while True:
            with self._change:
                waiting = [job for job in self._jobs.values() if job.state in ("queued", "running")]
                if self._closing and not self._processes:
                    return
                waiting.sort(key=lambda job: (job.state != "running", job.asked))
                if not waiting:
                    self._change.wait()
                    continue
                job = waiting[0]
                if job.state == "queued":
                    self._begin(job)
            self._attend(job)

    def _begin(self, job: Job) -> None:
        environment = {**os.environ, VARIABLE: self._progress_path(job), "COLUMNS": "200"}
        for ending in ("progress", "errors"):
            (self._folder / f"{job.name}.{ending}").unlink(missing_ok=True)
        job.state, job.started = "running", time.time()
        try:
            with (self._folder / f"{job.name}.errors").open("wb") as errors:
                process = subprocess.Popen(
                    [*self._program, *job.words],
                    stdin=subprocess.DEVNULL,
                    stdout=errors,
                    stderr=subprocess.STDOUT,
                    env=environment,
                    start_new_session=True,
                )
                with contextlib.suppress(OSError):
                    os.setpriority(os.PRIO_PROCESS, process.pid, _NICE)  # the page answers first
        except OSError as error:
            job.state, job.reason, job.ended = "failed", one_line(f"cannot be started: {error}"), time.time()
        else:
            self._processes[job.name] = process
            job.pid = process.pid
        self._note(job)

    def _attend(self, job: Job) -> None:
        """Wait until a running job has ended, and say how."""
        process = self._processes.get(job.name)
        if process is not None:
            code: int | None = process.wait()
        else:  # of a server that ended before this one was started: not this one's child
            while self._lives(job):
                if self._closing:
                    return
                time.sleep(_POLL_S)
            code = None
        if job.over:
            return
        state, reason = self._ending(job, code)
        with self._change:
            self._processes.pop(job.name, None)
            job.state, job.reason, job.ended, job.crowd = state, reason, time.time(), _crowd()
            self._note(job)

    def _lives(self, job: Job) -> bool:
        """Whether the process of a job's number is its run, and has not ended."""
        process = self._processes.get(job.name)
        if process is not None:
            return process.poll() is None
        try:
            environment = Path(f"/proc/{job.pid}/environ").read_bytes()
        except OSError:
            return False
        return os.fsencode(f"{VARIABLE}={self._progress_path(job)}") in environment.split(b"\0")

    def _ending(self, job: Job, code: int | None) -> tuple[State, str]:
        last = _last_line(self._folder / f"{job.name}.errors")
        if code == 0 or (code is None and (self._runs / job.folder / "report.html").exists()):
            return "done", ""
        if code == 130:
            return "cancelled", last
        if code is None or code < 0:
            name = signal.Signals(-code).name if code is not None else "the system"
            what = f"killed by {name}"
            if code in (-signal.SIGKILL, -signal.SIGABRT) and job.reason == "":
                what += " (that happens where memory runs out)"
            return "failed", f"{what}; {self._saved(job)}"
        return "failed", last or f"ended with exit code {code}"

    def _saved(self, job: Job) -> str:
        """Put the whole part of a killed run under its own name."""
        from ..io.recovery import recover  # takes half a second

        try:
            found = recover(self._runs / job.folder)
        except (InputError, OSError) as refusal:
            return str(refusal)
        if found is None or not found.complete:
            return "no whole turn was left"
        return f"{found.complete} whole {found.unit} stay readable"

    # --------------------------------------------------------------------------------------------------- files

    def _new_name(self, folder: str) -> str:
        base = folder.replace("/", "_")
        number = 1
        while f"{base}.{number}" in self._jobs or (self._folder / f"{base}.{number}.json").exists():
            number += 1
        return f"{base}.{number}"

    def _progress_path(self, job: Job) -> str:
        """The file of a job's progress."""
        return str(self._folder / f"{job.name}.progress")

    def _note(self, job: Job) -> None:
        with contextlib.suppress(OSError):
            write_whole(self._folder / f"{job.name}.json", json.dumps(asdict(job)))

    def _find(self) -> None:
        """Jobs of an earlier server: one whose process lives is attended, any other has ended."""
        for path in self._folder.glob("*.json"):
            try:
                job = _JOB.validate_json(read_bytes(path, below=self._folder))
                if job.name != path.stem or not (self._runs / job.folder).resolve().is_relative_to(self._runs):
                    continue
            except (OSError, ValueError):  # ValidationError is one
                continue
            if job.state == "running" and not self._lives(job):
                job.state, job.reason = self._ending(job, None)
                job.ended = job.ended or time.time()
            elif job.state == "queued":
                job.state, job.reason = "cancelled", "the page ended before it began"
            self._jobs[job.name] = job


def _crowd() -> float:
    """How many want each core, in the mean of the last minute; 1 where none need wait."""
    return max(1.0, os.getloadavg()[0] / len(cores()))


def _last_line(path: Path) -> str:
    """The last line that a process said, without the program's name."""
    try:
        with open_file(path) as file:
            file.seek(0, os.SEEK_END)
            file.seek(max(0, file.tell() - _LAST))
            lines = file.read(_LAST).decode("utf-8", "replace").split("\n")
    except (OSError, InputError):
        return ""
    said = [line.strip() for line in lines if line.strip()]
    return one_line(said[-1]).removeprefix("seamap-rt: ") if said else ""


_TURN = re.compile(r"turn (\d+) of (\d+): (\w+)")
_POINTS = re.compile(r"(\d+) of (\d+) points?")
_LEFT = re.compile(r", (?:…|(?:about |at most )?([\d.]+) (s|min|h)) left$")  # as the command itself tells it
_SECONDS = {"s": 1.0, "min": 60.0, "h": 3600.0}
_AFTER_S = 5.0  # comparing and drawing, where nothing better is known
_MOST_BYTES = 2**20


@dataclass(frozen=True)
class Progress:
    """line: what the command says. share: done of all, 0 to 1. turns: whole ones. left_s: None where nobody knows."""

    line: str
    share: float
    turns: int
    of: int
    left_s: float | None


def read_progress(path: Path, job: Job, now: float | None = None, pace: float | None = 1.0) -> Progress:
    """Of a job, from the file of its progress. pace: of this machine over the guesses'; None where nobody knows."""
    guess = None if pace is None else job.guess_s * pace or None
    now = time.time() if now is None else now
    if job.state == "queued":
        return Progress("waits", 0.0, 0, 0, None)
    lines = _lines(path)
    if job.over:
        whole = [number for number, _ in _starts(lines)]
        of = _of(lines)
        return Progress(job.reason or "done", 1.0, of if job.state == "done" else max(0, len(whole) - 1), of, 0.0)
    if not lines:
        return Progress("starting", 0.0, 0, 0, guess)
    line = lines[-1][1]
    points = _POINTS.match(line)
    if points:
        done, of = int(points[1]), int(points[2])
        spent = now - job.started
        left = spent / done * (of - done) if done else None
        return Progress(line, done / max(of, 1), done, of, left)
    line, left_s = _without_left(line)
    starts, of = _starts(lines), _of(lines)
    if left_s is not None:
        done = max(0, len(starts) - 1)
        return Progress(line, 0.05 + 0.9 * done / max(of, 1), done, of, left_s)
    if not starts:
        return Progress(line, 0.02, 0, of, guess)
    if not _TURN.match(line):  # comparing and drawing
        after = None if pace is None else max(0.0, _AFTER_S * pace - (now - lines[-1][0]))
        return Progress(line, 0.97, of, of, after)
    done = len(starts) - 1
    if len(starts) > 2:  # the first turn compiles and builds
        each = (starts[-1][1] - starts[1][1]) / (len(starts) - 2)
    elif done:
        each = starts[1][1] - starts[0][1]
    else:
        return Progress(line, 0.05, 0, of, max(0.0, guess - (now - job.started)) or None if guess else None)
    left = max(0.0, each * (of - done) - (now - starts[-1][1])) + _AFTER_S * (pace or 1.0)
    return Progress(line, 0.05 + 0.9 * done / of, done, of, left)


def _without_left(line: str) -> tuple[str, float | None]:
    """A line without the time left, and that time [s] where it is given."""
    found = _LEFT.search(line)
    if not found:
        return line, None
    return line[: found.start()], float(found[1]) * _SECONDS[found[2]] if found[1] else None


def _lines(path: Path) -> list[tuple[float, str]]:
    try:
        with open_file(path) as file:
            text = file.read(_MOST_BYTES).decode("utf-8", "replace")
    except (OSError, InputError):
        return []
    found = []
    for line in text.split("\n"):
        when, _, words = line.partition(" ")
        try:
            found.append((float(when), words))
        except ValueError:
            continue
    return found


def _starts(lines: list[tuple[float, str]]) -> list[tuple[int, float]]:
    """When each turn began."""
    seen: dict[int, float] = {}
    for when, words in lines:
        turn = _TURN.match(words)
        if turn:
            seen.setdefault(int(turn[1]), when)
    return sorted(seen.items())


def _of(lines: list[tuple[float, str]]) -> int:
    return next((int(turn[2]) for _, words in reversed(lines) if (turn := _TURN.match(words))), 0)


Result = TypeVar("Result")


class DrawingProcess:
    """A process that draws one thing after another; it starts with the first. most: after so many another follows."""

    def __init__(self, most: int | None = None) -> None:
        self._most = most
        self._pool: ProcessPoolExecutor | None = None
        self._free = asyncio.Lock()

    async def __call__(self, make: Callable[..., Result], *given: Any) -> Result:
        """What a function of a module gives. Cancelled while it waits, it is never begun.

        Raises OSError where the process ended, and what the function raises.
        """
        packed = pickle.dumps((make, given))
        await self._free.acquire()
        loop = asyncio.get_running_loop()
        spawn = multiprocessing.get_context("spawn")
        pool = self._pool = self._pool or ProcessPoolExecutor(1, spawn, _begin, max_tasks_per_child=self._most)
        try:
            future = pool.submit(_call, packed)
        except BrokenExecutor as error:
            self._pool = None
            self._free.release()
            raise OSError(_LOST) from error

        def release(_: object) -> None:
            with contextlib.suppress(RuntimeError):  # the page has ended, and its loop with it
                loop.call_soon_threadsafe(self._free.release)

        future.add_done_callback(release)
        try:
            return await asyncio.wrap_future(future)
        except BrokenExecutor as error:
            self._pool = None
            raise OSError(_LOST) from error


_LOST = "the process that draws has ended, as it does where memory runs out; choose the view again"

quick, slow = DrawingProcess(), DrawingProcess()  # maps, sections, curves; what may take seconds
alone = DrawingProcess(1)  # what takes much memory


def close() -> None:
    """End what is drawn."""
    for child in multiprocessing.active_children():
        child.terminate()


def _call(packed: bytes) -> Any:
    make, given = pickle.loads(packed)  # here, so that what cannot be opened is an answer
    return make(*given)


def _begin() -> None:
    """In a process that draws: Ctrl-C is for the page, and the process ends with the page, however that ends."""
    signal.signal(signal.SIGINT, signal.SIG_IGN)
    page = multiprocessing.parent_process()
    assert page is not None

    def follow() -> None:
        page.join()
        os._exit(0)

    threading.Thread(target=follow, daemon=True, name="follow").start()
