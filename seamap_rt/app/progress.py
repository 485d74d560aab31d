"""A job, and how far it is by the file of its progress."""

from __future__ import annotations

import re
import time
from dataclasses import dataclass, field
from pathlib import Path
from typing import Annotated, Literal

from annotated_types import MinLen

from ..errors import InputError
from ..io.opening import open_file

State = Literal["queued", "running", "done", "cancelled", "failed"]
_ENDED = ("done", "cancelled", "failed")
_TURN = re.compile(r"turn (\d+) of (\d+): (\w+)")
_POINTS = re.compile(r"(\d+) of (\d+) points?")
_LEFT = re.compile(r", (?:…|(?:about |at most )?([\d.]+) (s|min|h)) left$")  # as the command itself tells it
_SECONDS = {"s": 1.0, "min": 60.0, "h": 3600.0}
_AFTER_S = 5.0  # comparing and drawing, where nothing better is known
_MOST_BYTES = 2**20


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
