"""The order of a sweep's points: those of one sea follow each other in one process, which keeps the sea."""

from __future__ import annotations

from collections import deque
from collections.abc import Iterable

from .point import Task


class BySea:
    """Tasks in groups of one sea each, for workers that keep the sea of their last task."""

    def __init__(self, tasks: Iterable[Task]) -> None:
        self._groups: dict[str, deque[Task]] = {}
        for task in tasks:
            self._groups.setdefault(task.sea, deque()).append(task)
        self._last: dict[str, str] = {}  # sea of each worker

    def take(self, worker: str) -> Task | None:
        """The next task for a worker: of its own sea, else of one that nobody works on, else of the one with the most
        tasks left. None if there is none."""
        if not self._groups:
            return None
        sea = self._last.get(worker, "")
        if sea not in self._groups:
            taken = set(self._last.values())
            free = (each for each in self._groups if each not in taken)
            sea = next(free, max(self._groups, key=lambda each: len(self._groups[each])))
        self._last[worker] = sea
        task = self._groups[sea].popleft()
        if not self._groups[sea]:
            del self._groups[sea]
        return task
