"""What is kept of a field's knots: the coefficients that the latest calls used, within a bound of bytes."""

from __future__ import annotations

from collections import OrderedDict, deque
from collections.abc import Hashable, Mapping, Sequence
from threading import Lock
from typing import TYPE_CHECKING, Any, Generic, TypeVar

if TYPE_CHECKING:
    from .moving_field import Strip

Key = TypeVar("Key", bound=Hashable)
_REMEMBERED = 8  # calls, some two turns of them: a knot that none of them used is of a past time


class KeptKnots(OrderedDict[Key, "tuple[Strip, Any]"], Generic[Key]):
    """By knot its strip and the coefficients of that strip's rows, those used last at the end; for several threads."""

    def __init__(self) -> None:
        super().__init__()
        self._recent: deque[frozenset[Key]] = deque(maxlen=_REMEMBERED)
        self._lock = Lock()

    def take(self, wanted: Sequence[Key], strip: Strip, row_bytes: int, most: int) -> dict[Key, tuple[Strip, Any]]:
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

    def keep(self, values: Mapping[Key, tuple[Strip, Any]]) -> None:
        """These, as the latest used."""
        with self._lock:
            self.update(values)
