"""The queue of runs, each the command line in a process of its own, which leaves its story in files.

A job's files lie in `.jobs` below the runs: `NAME.toml` the scene, `NAME.json` what it is, `NAME.progress` a line for
each step with its time, `NAME.errors` what the process said. So a page that is opened again finds them, and so does a
server that is started again, whose runs went on without it. A number of a process in a file proves nothing: another one
may have it by now. A run is known as this server's child, or by the file of progress that its own environment names.
"""

from __future__ import annotations

import contextlib
import json
import os
import signal
import subprocess
import sys
import threading
import time
from collections.abc import Sequence
from dataclasses import asdict
from pathlib import Path

import numpy as np
from pydantic import TypeAdapter

from ..compute.machine import cores
from ..errors import InputError, one_line
from ..io.opening import open_file, read_bytes
from ..io.process import VARIABLE
from ..io.results_folder import write_whole
from .progress import Job, Progress, State, read_progress

FOLDER = ".jobs"
_NOT_BEGUN = "cancelled before it began"
_LAST = 4096  # bytes of what a process said that are read
_POLL_S = 0.2
_MEASURED, _NICE = 3, 5


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
                job.state, job.reason, job.ended = "cancelled", _NOT_BEGUN, time.time()
                self._note(job)
                return
            again = job.reason != ""
            job.reason = "stopped by the user"
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
        if job.reason and code in (-signal.SIGTERM, -signal.SIGINT):  # stopped before it could answer
            return "cancelled", self._saved(job) if (self._runs / job.folder).exists() else _NOT_BEGUN
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
