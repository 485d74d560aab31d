"""Whole turns of a NetCDF file that is finished, or of the files beside it while it grows or after a kill."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from contextlib import closing
from functools import lru_cache
from pathlib import Path
from typing import Any, TypeVar

import h5py
import numpy as np
from numpy.typing import NDArray

from .opening import open_hdf5, read_npz
from .turn_files import part_of, turn_files

Result = TypeVar("Result")
_TRIES = 3
_KEPT = 2**14  # arrays of single turns, which are small: numbers of turns, what gauges read


class GrowingFile:
    """What is whole of a file, to be read as the file itself, and closed. OSError, InputError where there is none."""

    def __init__(self, path: Path) -> None:
        files = [path] if path.exists() else turn_files(part_of(path))
        if not files:
            raise FileNotFoundError("holds no whole turn yet")
        self._begun, self._further = open_hdf5(files[0], rows=True), files[1:]

    def __contains__(self, name: str) -> bool:
        return name in self._begun

    def __iter__(self) -> Iterator[str]:
        yield from map(str, self._begun)

    def array(self, name: str) -> Any:
        """An array, of which `[:]` is all, and `[number]` a turn of one of turns. KeyError where there is none."""
        found: Any = self._begun[name]
        if isinstance(found, h5py.Group):
            raise KeyError(name)
        return GrowingArray(found, name, self._further) if self._further and None in found.maxshape else found

    def attributes(self, group: str = "/") -> dict[str, Any]:
        return dict(self._begun[group].attrs)

    def close(self) -> None:
        self._begun.close()


class GrowingArray:
    """An array of which some turns are in the file of the first ones, and each further one in a file of its own."""

    def __init__(self, begun: Any, name: str, further: list[Path]) -> None:
        self._begun, self._name, self._further = begun, name, further

    def __len__(self) -> int:
        """Turns, of an array of turns."""
        return len(self._begun) + len(self._further)

    def __getitem__(self, key: int | slice) -> NDArray[Any]:
        """A turn of an array of turns; or all of an array, or a part."""
        if isinstance(key, slice):
            kept = (_kept(each, each.stat().st_mtime_ns, self._name) for each in self._further)
            return np.concatenate([self._begun[()], *kept], self._begun.maxshape.index(None))[key]
        turn, first = range(len(self))[key], len(self._begun)
        return self._begun[turn] if turn < first else _read(self._further[turn - first], self._name)[0]


def _read(file: Path, name: str) -> NDArray[Any]:
    _, arrays = read_npz(file, (name,))
    return arrays[name]


@lru_cache(_KEPT)
def _kept(file: Path, written_ns: int, name: str) -> NDArray[Any]:
    """written_ns: of this file, as another run may write one of its name."""
    return _read(file, name)


def read_whole_turns(path: Path, read: Callable[[GrowingFile], Result]) -> Result:
    """What `read` makes of a file that is finished, or of the whole turns of one that grows or was left by a kill.

    path: the file's own name. read: is given the open file, and may be called several times: while it reads, a file
    that grew may be finished. Raises OSError where there is none, or a damaged one.
    """
    told = ""
    for _ in range(_TRIES):
        try:
            with closing(GrowingFile(path)) as file:
                return read(file)
        except Exception as error:  # a damaged file raises exceptions of many types
            told = str(error)
    raise OSError(f"{path}: {told}")
