"""The turns of a NetCDF file that is not whole yet: files of a hidden folder beside it, one a turn.

`N.nc` of such a folder holds the first N turns, and all that does not grow; each further turn is an archive of NumPy:
`N.npz` and so on. Each appears whole, so a kill leaves whole turns, and they are read while the file grows.
"""

from __future__ import annotations

import errno
import os
import shutil
from collections.abc import Callable, Iterator, Mapping
from contextlib import closing
from functools import lru_cache
from itertools import count, takewhile
from pathlib import Path
from typing import Any, TypeVar

import h5netcdf
import h5py
import numpy as np
from numpy.typing import NDArray

from .opening import open_hdf5, read_npz
from .results_folder import whole_file

_GROWTH, _INDEX_BYTES = 1.01, 2**20  # of a file beside its values: what zlib cannot compress grows; trees of chunks


def part_of(path: Path) -> Path:
    """The folder of a file's turns."""
    return path.with_name(f".{path.name}.part")


def turn_files(folder: Path) -> list[Path]:
    """The file of the first turns and those of one turn after it, in order, as far as none is missing.

    ValueError for what an earlier version left: a file.
    """
    if folder.is_file():
        raise ValueError(f"{folder.name} is of an earlier version, which recovers it")
    begun = max(folder.glob("[0-9]*.nc"), key=turns_in, default=None)
    if begun is None:
        return []
    return [begun, *takewhile(Path.exists, (folder / f"{turn}.npz" for turn in count(turns_in(begun))))]


def turns_in(begun: Path) -> int:
    """Of a file of the first turns, how many it holds."""
    return int(begun.stem)


def whole_turns(folder: Path) -> int:
    """How many turns a folder holds."""
    files = turn_files(folder)
    return turns_in(files[0]) + len(files) - 1 if files else 0


def write_turn(folder: Path, number: int, arrays: Mapping[str, Any]) -> None:
    """Add a turn, before which there are so many. arrays: all that grow, by group and name."""
    with whole_file(folder / f"{number}.npz") as part, part.open("wb") as file:
        np.savez(file, **arrays)


def join_turns(folder: Path, turns: int, path: Path, attributes: Mapping[str, Any] | None = None) -> None:
    """Make a NetCDF file of the first so many turns, whole or not at all. Memory holds one of them.

    Raises OSError where the disk has no room for it, and where there are fewer turns.
    """
    if not 0 < turns <= whole_turns(folder):
        raise FileNotFoundError(errno.ENOENT, f"no {turns} whole turns", str(folder))
    begun, *further = turn_files(folder)
    further = further[: max(0, turns - turns_in(begun))]
    made = folder / "whole"
    try:
        shutil.copyfile(begun, made)
        _reserve(made, sum(each.stat().st_size for each in further))
        with h5py.File(made, "r+") as hdf5:
            for each in further:
                with np.load(each, allow_pickle=False) as arrays:
                    _lengthen(hdf5, arrays)
        shorter = turns if turns < turns_in(begun) else None  # of a file that grows along one dimension
        with h5netcdf.File(made, "r+") as file:
            for group in (file, *file.groups.values()):
                for name, dimension in group.dimensions.items():
                    if dimension.isunlimited():
                        group.resize_dimension(name, shorter or dimension.size)  # as long as its arrays
            file.attrs.update(attributes or {})
        os.replace(made, path)
    finally:
        made.unlink(missing_ok=True)


def _reserve(path: Path, size: int) -> None:
    """Ask for room for so many bytes of turns behind a file. OSError where there is none: HDF5 may crash, even later,
    if it cannot write. It cuts off what it does not need.

    Where the system (macOS) or the file system has no such question, none is asked.
    """
    if not hasattr(os, "posix_fallocate"):
        return
    with path.open("r+b") as file:
        try:
            os.posix_fallocate(file.fileno(), path.stat().st_size, int(_GROWTH * size) + _INDEX_BYTES)
        except OSError as error:
            if error.errno not in (errno.EINVAL, errno.EOPNOTSUPP):
                raise


def _lengthen(file: h5py.File, arrays: Mapping[str, np.ndarray[Any, Any]]) -> None:
    """By a turn, whose arrays have the names that they have in the file."""
    for name, values in arrays.items():
        array: Any = file[name]
        axis = array.maxshape.index(None)
        start = array.shape[axis]
        array.resize(start + values.shape[axis], axis)
        array[(slice(None),) * axis + (slice(start, None),)] = values


Result = TypeVar("Result")
_TRIES = 3
_KEPT = 2**14  # arrays of single turns, which are small: numbers of turns, what gauges read


class GrowingFile:
    """What is whole of a file, to be read as the file itself, and closed. OSError, InputError where there is none."""

    def __init__(self, path: Path) -> None:
        files = [] if path.exists() else turn_files(part_of(path))
        if path.exists():  # and of one that was finished meanwhile some turns may have gone already
            files = [path]
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
    message = ""
    for _ in range(_TRIES):
        try:
            with closing(GrowingFile(path)) as file:
                return read(file)
        except Exception as error:  # a damaged file raises exceptions of many types
            message = str(error)
    raise OSError(f"{path}: {message}")
