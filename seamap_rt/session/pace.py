"""How far a run is, and how long the rest may take: by what this run itself has measured, and by nothing else."""

from __future__ import annotations

import time
from collections.abc import Callable

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


class Pace:
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
        if stage != self._stage and _rank(stage) >= _rank(self._stage):
            self._stage = stage
            self._say(f"{self._what} {len(self._began)} of {self._count}: {stage}, {self.left()} left")

    def left(self) -> str:
        """The time left for all parts, in words."""
        lasted = [end - begin for begin, end in zip(self._began, self._began[1:], strict=False)]
        if not lasted:
            return "…"
        warm = lasted[1:]
        each = sum(warm) / len(warm) if warm else lasted[0]
        spent = self._now() - self._began[-1]
        rest = max(0.0, each - spent) + each * (self._count - len(self._began))
        return f"{'about' if warm else 'at most'} {duration(rest)}"


def _rank(stage: str) -> int:
    return _LATER.index(stage) + 1 if stage in _LATER else 0


def duration(seconds: float) -> str:
    """Seconds, or minutes where they are many."""
    return f"{seconds:.0f} s" if seconds < _ENOUGH_S else f"{seconds / 60.0:.0f} min"
