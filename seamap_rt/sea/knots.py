"""The knots of a moving field: of which field, at which time step, which rows; and what is kept of them."""

from __future__ import annotations

from collections import OrderedDict, deque
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from threading import Lock
from typing import Any

from .fields import Kind

Knot = tuple[int, Kind]  # number of the time step, field

_REMEMBERED = 8  # calls, some two turns of them: a knot that none of them used is of a past time


@dataclass(frozen=True)
class Strip:
    """Rows of a periodic grid from `first` on, over its end where there are more: those that points lie between.

    Strips begin and end where the FFT's rows are parted (`moving_field._ROWS`), so that a row's bits are the same in
    all of them.
    """

    first: int
    count: int

    def place_in(self, other: Strip, period: int) -> slice | None:
        """Where these rows lie among another strip's, if they do."""
        start = (self.first - other.first) % period
        return slice(start, start + self.count) if start + self.count <= other.count else None


class KnotCache(OrderedDict[Knot, tuple[Strip, Any]]):
    """By knot its strip and the coefficients of that strip's rows, what the latest calls used, those used last at the
    end; for several threads."""

    def __init__(self) -> None:
        super().__init__()
        self._recent: deque[frozenset[Knot]] = deque(maxlen=_REMEMBERED)
        self._lock = Lock()

    def take(self, wanted: Sequence[Knot], strip: Strip, row_bytes: int, most: int) -> dict[Knot, tuple[Strip, Any]]:
        """What is kept of the wanted, which `keep` takes back. The rest makes room for them: they are to be rows of
        that strip, of so many bytes each, and all that is kept is to have at most so many."""
        with self._lock:
            known = {key: self.pop(key) for key in wanted if key in self}
            self._recent.append(frozenset(wanted))
            for key in self.keys() - set().union(*self._recent):
                del self[key]
            held = sum(has.count for has, _ in self.values()) + len(wanted) * strip.count
            while self and held * row_bytes > most:  # before the new ones take memory, not after
                held -= self.popitem(last=False)[1][0].count
        return known

    def keep(self, values: Mapping[Knot, tuple[Strip, Any]]) -> None:
        """Keep these strips, as those used last."""
        with self._lock:
            self.update(values)

    def add(self, values: Mapping[Knot, tuple[Strip, Any]]) -> None:
        """Add those of these strips that are not there."""
        with self._lock:
            for key, value in values.items():
                self.setdefault(key, value)
