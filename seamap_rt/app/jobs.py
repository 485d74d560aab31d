"""The queue of runs, each the command line in a process of its own, which leaves its story in files; and how far it is.

A job's files lie in `.jobs` below the runs: `NAME.toml` the scene, `NAME.json` what it is, `NAME.progress` a line for
each step with its time, `NAME.errors` what the process said. So a page that is opened again finds them, and so does a
server that is started again, whose runs went on without it. A number of a process in a file proves nothing: another one
may have it by now. A run is known as this server's child, or by the file of progress that its own environment names.
"""

from __future__ import annotations

import contextlib
import json
import os
import re
import signal
import subprocess
import sys
import threading
import time
from collections.abc import Sequence
from dataclasses import asdict, dataclass, field
from itertools import count
from pathlib import Path
from typing import Annotated, Literal

import numpy as np
from annotated_types import MinLen
from pydantic import TypeAdapter

from ..compute.machine import cores
from ..errors import InputError, one_line
from ..io.opening import open_file, read_bytes
from ..io.process import VARIABLE
from ..io.results_folder import write_whole

FOLDER = ".jobs"
_NOT_BEGUN = "cancelled before it began"
_LAST = 4096  # bytes of what a process said that are read
_POLL_S = 0.2
_MEASURED, _NICE = 3, 5

State = Literal["queued", "running", "done", "cancelled", "failed"]
_TURN = re.compile(r"turn (\d+) of (\d+): (\w+)")
_POINTS = re.compile(r"(\d+) of (\d+) points?")
_LEFT = re.compile(r", (?:…|(?:about |at most )?([\d.]+) (s|min|h)) left$")  # as the command itself tells it
_SECONDS = {"s": 1.0, "min": 60.0, "h": 3600.0}
_AFTER_S = 5.0  # comparing and drawing, where nothing better is known
_MOST_BYTES = 2**20


@dataclass
class Job:
    """One run, trade or other command.

    words: the command's arguments, without the program. reason: why it ended, if not by itself. started, ended: Unix
    time, 0 before.
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
    def is_over(self) -> bool:
        return self.state not in ("queued", "running")


_JOB = TypeAdapter(Job)


class Queue:
    """Runs jobs one after another. runs: the folder below which all of them write. program: what runs the command."""

    def __init__(self, runs: Path, program: Sequence[str] = (sys.executable, "-P", "-m", "seamap_rt.cli")) -> None:
        self._runs, self._program = runs.resolve(), tuple(program)
        (self._runs / FOLDER).mkdir(parents=True, exist_ok=True)
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
            names = (f"{folder.replace('/', '_')}.{number}" for number in count(1))
            name = next(each for each in names if each not in self._jobs and not self._file(each, "json").exists())
            scene = self._file(name, "toml")
            write_whole(scene, scene_toml)
            out = str(self._runs / folder)
            filled = tuple(word.replace("{scene}", str(scene)).replace("{out}", out) for word in words)
            job = self._jobs[name] = Job(name, title, folder, filled, guess_s=guess_s)
            self._note(job)
            self._change.notify_all()
            return job

    def jobs(self) -> list[Job]:
        """All, the one asked for last first."""
        with self._change:
            return sorted(self._jobs.values(), key=lambda job: job.asked, reverse=True)

    def job_of_folder(self, folder: str) -> Job | None:
        """The last job that writes, or wrote, into a folder."""
        return next((job for job in self.jobs() if job.folder == folder), None)

    def progress(self, job: Job) -> Progress:
        """How far a job is."""
        return read_progress(self._file(job.name, "progress"), job, pace=self.pace(job.words[0]))

    def pace(self, kind: str) -> float | None:
        """What a command takes now over what is guessed, by the last three of its kind that were done here and by how
        many want each core now and wanted it then; None where none was done."""
        done = [job for job in self.jobs() if job.state == "done" and job.words[0] == kind and job.guess_s > 0.0]
        took = [(job.ended - job.started) / (job.guess_s * job.crowd) for job in done[:_MEASURED]]
        return float(np.median(took)) * _load_per_core() if took else None

    # ------------------------------------------------------------------------------------------------ stopping

    def cancel(self, name: str) -> None:
        """End a job: a queued one is not begun; a running one keeps its whole turns. Asked again, it is killed."""
        with self._change:
            job = self._jobs.get(name)
            if job is None or job.is_over:
                return
            if job.state == "queued":
                job.state, job.reason, job.ended = "cancelled", _NOT_BEGUN, time.time()
                self._note(job)
                return
            again = job.reason != ""
            job.reason = "stopped by the user"
        with contextlib.suppress(ProcessLookupError, PermissionError):
            if not self._owns_process(job):
                return
            if again:
                os.killpg(job.pid, signal.SIGKILL)
            else:
                os.kill(job.pid, signal.SIGTERM)

    def forget(self, name: str) -> None:
        """Take a job that is over off the list; what it wrote stays."""
        with self._change:
            job = self._jobs.get(name)
            if job is not None and job.is_over:
                del self._jobs[name]
                for ending in ("json", "toml", "progress", "errors"):
                    self._file(name, ending).unlink(missing_ok=True)

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
                if self._closing and not self._processes:
                    return
                waiting = [job for job in self._jobs.values() if not job.is_over]
                if not waiting:
                    self._change.wait()
                    continue
                job = min(waiting, key=lambda each: (each.state != "running", each.asked))
                if job.state == "queued":
                    self._begin(job)
            self._await_end(job)

    def _begin(self, job: Job) -> None:
        environment = {**os.environ, VARIABLE: str(self._file(job.name, "progress")), "COLUMNS": "200"}
        self._file(job.name, "progress").unlink(missing_ok=True)
        job.state, job.started = "running", time.time()
        try:
            with self._file(job.name, "errors").open("wb") as errors:
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

    def _await_end(self, job: Job) -> None:
        """Wait until a running job has ended, and say how."""
        process, code = self._processes.get(job.name), None
        if process is not None:
            code = process.wait()
        else:  # of a server that ended before this one was started: not this one's child
            while self._owns_process(job):
                if self._closing:
                    return
                time.sleep(_POLL_S)
        if job.is_over:
            return
        state, reason = self._ending(job, code)
        with self._change:
            self._processes.pop(job.name, None)
            job.state, job.reason, job.ended, job.crowd = state, reason, time.time(), _load_per_core()
            self._note(job)

    def _owns_process(self, job: Job) -> bool:
        """Whether the process of a job's number is its run, and has not ended."""
        process = self._processes.get(job.name)
        if process is not None:
            return process.poll() is None
        try:
            environment = Path(f"/proc/{job.pid}/environ").read_bytes()
        except OSError:
            return False
        return os.fsencode(f"{VARIABLE}={self._file(job.name, 'progress')}") in environment.split(b"\0")

    def _ending(self, job: Job, code: int | None) -> tuple[State, str]:
        last = _last_line(self._file(job.name, "errors"))
        if code == 0 or (code is None and (self._runs / job.folder / "report.html").exists()):
            return "done", ""
        if code == 130:
            return "cancelled", last
        if job.reason and code in (-signal.SIGTERM, -signal.SIGINT):  # stopped before it could answer
            return "cancelled", self._save_whole_part(job) if (self._runs / job.folder).exists() else _NOT_BEGUN
        if code is None or code < 0:
            what = f"killed by {signal.Signals(-code).name if code is not None else 'the system'}"
            if code in (-signal.SIGKILL, -signal.SIGABRT) and job.reason == "":
                what += " (that happens where memory runs out)"
            return "failed", f"{what}; {self._save_whole_part(job)}"
        return "failed", last or f"ended with exit code {code}"

    def _save_whole_part(self, job: Job) -> str:
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

    def _file(self, name: str, ending: str) -> Path:
        return self._runs / FOLDER / f"{name}.{ending}"

    def _note(self, job: Job) -> None:
        with contextlib.suppress(OSError):
            write_whole(self._file(job.name, "json"), json.dumps(asdict(job)))

    def _find(self) -> None:
        """Jobs of an earlier server: one whose process lives is attended, any other has ended."""
        folder = self._runs / FOLDER
        for path in folder.glob("*.json"):
            try:
                job = _JOB.validate_json(read_bytes(path, below=folder))
                if job.name != path.stem or not (self._runs / job.folder).resolve().is_relative_to(self._runs):
                    continue
            except (OSError, ValueError):  # ValidationError is one
                continue
            if job.state == "running" and not self._owns_process(job):
                job.state, job.reason = self._ending(job, None)
                job.ended = job.ended or time.time()
            elif job.state == "queued":
                job.state, job.reason = "cancelled", "the page ended before it began"
            self._jobs[job.name] = job


def _load_per_core() -> float:
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
    words = [line.strip() for line in lines if line.strip()]
    return one_line(words[-1]).removeprefix("seamap-rt: ") if words else ""


@dataclass(frozen=True)
class Progress:
    """line: what the command says. share: done of all, 0 to 1. turns: whole ones. left_s: None where it is unknown."""

    line: str
    share: float
    turns: int
    of: int
    left_s: float | None


def read_progress(path: Path, job: Job, now: float | None = None, pace: float | None = 1.0) -> Progress:
    """How far a job is, by its progress file. pace: of this machine over the guesses'; None where it is unknown."""
    if job.state == "queued":
        return Progress("waits", 0.0, 0, 0, None)
    now = time.time() if now is None else now
    lines, guess = _lines(path), None if pace is None else job.guess_s * pace or None
    begun: dict[int, float] = {}  # when each turn began
    of = 0
    for when, words in lines:
        if turn := _TURN.match(words):
            begun.setdefault(int(turn[1]), when)
            of = int(turn[2])
    whole, starts = max(0, len(begun) - 1), [begun[number] for number in sorted(begun)]
    share = 0.05 + 0.9 * whole / max(of, 1)
    if job.is_over:
        return Progress(job.reason or "done", 1.0, of if job.state == "done" else whole, of, 0.0)
    if not lines:
        return Progress("starting", 0.0, 0, 0, guess)
    began, line = lines[-1]
    if points := _POINTS.match(line):
        done, of = int(points[1]), int(points[2])
        left = (now - job.started) / done * (of - done) if done else None
        return Progress(line, done / max(of, 1), done, of, left)
    if time_left := _LEFT.search(line):
        line = line[: time_left.start()]
        if time_left[1]:
            return Progress(line, share, whole, of, float(time_left[1]) * _SECONDS[time_left[2]])
    if not starts:
        return Progress(line, 0.02, 0, of, guess)
    if not _TURN.match(line):  # comparing and drawing
        return Progress(line, 0.97, of, of, None if pace is None else max(0.0, _AFTER_S * pace - (now - began)))
    if not whole:
        return Progress(line, share, 0, of, None if guess is None else max(0.0, guess - (now - job.started)) or None)
    warm = starts[1:] if whole > 1 else starts  # the first turn compiles and builds
    each = (warm[-1] - warm[0]) / (len(warm) - 1)
    left = max(0.0, each * (of - whole) - (now - starts[-1])) + _AFTER_S * (pace or 1.0)
    return Progress(line, share, whole, of, left)


def _lines(path: Path) -> list[tuple[float, str]]:
    """When each step began, and its words."""
    try:
        with open_file(path) as file:
            text = file.read(_MOST_BYTES).decode("utf-8", "replace")
    except (OSError, InputError):
        return []
    found = []
    for line in text.split("\n"):
        when, _, words = line.partition(" ")
        with contextlib.suppress(ValueError):
            found.append((float(when), words))
    return found
