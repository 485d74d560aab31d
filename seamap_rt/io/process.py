"""The process while files are written and read: interruptions that wait for a turn, libraries that are kept silent, and
what tells others of a command's steps and of the time left, by what this run itself has measured."""

from __future__ import annotations

import contextlib
import logging
import os
import signal
import sys
import threading
import time
import traceback
import warnings
from collections.abc import Callable, Iterator
from contextlib import contextmanager

from ..errors import one_line


@contextmanager
def hold_interruptions() -> Iterator[None]:
    """Hold Ctrl-C and SIGTERM back while a turn is written, so that every file ends with the same turn."""
    held: list[int] = []
    before = {}
    if threading.current_thread() is threading.main_thread():  # only there do signals interrupt
        before = {each: signal.getsignal(each) for each in (signal.SIGINT, signal.SIGTERM, signal.SIGALRM)}
    for number in before:
        signal.signal(number, lambda number, _: held.append(number))
    try:
        yield
    finally:
        for number, handler in before.items():
            signal.signal(number, signal.SIG_DFL if handler is None else handler)
        for number in held[:1]:
            signal.raise_signal(number)


@contextmanager
def suppress_close_errors() -> Iterator[None]:
    """No line of a file that its library cannot even close: h5netcdf's destructor raises then, and Python prints it."""
    hook = sys.unraisablehook

    def pass_on(lost: sys.UnraisableHookArgs) -> None:
        if issubclass(lost.exc_type, KeyboardInterrupt):  # nor is an interruption lost
            hook(lost)

    sys.unraisablehook = pass_on
    try:
        yield
    finally:
        sys.unraisablehook = hook


@contextmanager
def suppress_log(library: str) -> Iterator[None]:
    """Keep a library from logging."""
    logger = logging.getLogger(library)
    level = logger.level
    logger.setLevel(logging.CRITICAL + 1)
    try:
        yield
    finally:
        logger.setLevel(level)


@contextmanager
def suppress_complaints() -> Iterator[None]:
    """Keep libraries from complaining and warning."""
    with suppress_close_errors(), warnings.catch_warnings():
        warnings.simplefilter("ignore")
        yield


VARIABLE = "SEAMAP_RT_PROGRESS"  # of the environment: names the file


Progress = Callable[[str], None]  # is given a line on each step as it begins


def ignore_progress(line: str) -> None:
    """Progress that nobody sees."""


@contextmanager
def progress() -> Iterator[Callable[[str], None]]:
    """Progress that shows: on a terminal as its status line, in the file that the environment names, else silent.

    with seamap_rt.progress() as say:
        seamap_rt.run("tiny", progress=say)
    """
    from rich.console import Console

    console = Console(stderr=True, soft_wrap=True, highlight=False, markup=False)
    if named := os.environ.get(VARIABLE):

        def note(line: str) -> None:
            with contextlib.suppress(OSError), open(named, "a", encoding="utf-8") as file:  # telling must not end a run
                file.write(f"{time.time():.3f} {one_line(line)}\n")

        yield note
    elif console.is_terminal and console.file.isatty():  # whatever the environment wants coloured
        with console.status("starting") as status:
            yield status.update
    else:
        yield ignore_progress


def filter_asyncio_log() -> None:
    """Filter asyncio's log from here on. These libraries do several things beside each other and raise what goes wrong
    with one of them; asyncio tells of the others when they are forgotten, on standard error, beside the line that says
    it all. So it does of those that are left when the process is interrupted."""
    logging.getLogger("asyncio").addFilter(_is_relevant)


def _is_relevant(record: logging.LogRecord) -> bool:
    text = record.getMessage()
    raised = record.exc_info[1] if record.exc_info else None
    where = traceback.walk_tb(raised.__traceback__ if raised else None)
    libraries = type(raised).__module__, text, *(frame.f_code.co_filename for frame, _ in where)
    left = "never retrieved" in text or "was destroyed but it is pending" in text
    return not (left and any(name in each for each in libraries for name in ("zarr", "distributed")))


# ----------------------------------------------------------------------------------------- how far a command is


_ENOUGH_S = 90.0  # from here on in minutes
STAGES = {  # what a step of the simulation's clock is a part of; sea and mesh take turns, then nothing comes again
    "sea": "sea",
    "mesh": "mesh",
    "calibrate": "calibrate",
    "trace": "trace",
    "objects": "echoes",
    "echoes": "echoes",
    "scattering": "echoes",
    "truth": "truth",
    "retrieve": "retrieve",
}
_LATER = ("trace", "echoes", "truth", "retrieve")


class ProgressEstimate:
    """Lines of progress for parts that are alike, such as turns: which one, its stage, and the time left.

    The first part compiles and builds: until it has ended nothing is known ("…"), then it bounds the others from above,
    and from the second on their mean counts.
    """

    def __init__(
        self, what: str, count: int, say: Callable[[str], None], now: Callable[[], float] = time.perf_counter
    ) -> None:
        self._what, self._count, self._say, self._now = what, count, say, now
        self._began: list[float] = []
        self._stage = ""

    def begin(self) -> None:
        """The next part begins, and so the last one has ended."""
        self._began.append(self._now())
        self._stage = ""

    def stage(self, step: str) -> None:
        """A step of the part begins; it is said where it is another stage than the last, and no earlier one."""
        stage = STAGES.get(step, step)
        if stage != self._stage and _stage_rank(stage) >= _stage_rank(self._stage):
            self._stage = stage
            self._say(f"{self._what} {len(self._began)} of {self._count}: {stage}, {self.time_left()} left")

    def time_left(self) -> str:
        """The time left for all parts, in words."""
        lasted = [end - begin for begin, end in zip(self._began, self._began[1:], strict=False)]
        if not lasted:
            return "…"
        warm = lasted[1:]
        each = sum(warm) / len(warm) if warm else lasted[0]
        spent = self._now() - self._began[-1]
        rest = max(0.0, each - spent) + each * (self._count - len(self._began))
        return f"{'about' if warm else 'at most'} {duration(rest)}"


def _stage_rank(stage: str) -> int:
    return _LATER.index(stage) + 1 if stage in _LATER else 0


def duration(seconds: float) -> str:
    """Seconds, or minutes where they are many."""
    return f"{seconds:.0f} s" if seconds < _ENOUGH_S else f"{seconds / 60.0:.0f} min"
