"""A NetCDF file that grows turn by turn and appears under its own name, whole, even where the disk fills.

Until then its whole turns survive a kill in a file beside it, from which `recover_netcdf` takes them.
"""

from __future__ import annotations

import contextlib
import errno
import os
from collections.abc import Iterable, Iterator, Mapping
from pathlib import Path
from types import TracebackType
from typing import Any, NamedTuple, Self

import h5netcdf
import h5py
import numpy as np
import xarray as xr

from .committed_file import CommittedFile, journal_of, mend, part_of
from .interrupts import uninterrupted

# Room that HDF5 takes beside the values, at most:
_INDEX_BYTES = 16384  # of a variable in a turn: its header at first, then the trees of its chunks
_CHUNK_BYTES = 16384  # of a variable whose last dimension grows: HDF5 takes whole chunks, of some kilobytes
_INCOMPRESSIBLE = 1.01  # zlib lets what it cannot compress grow by less than this

_LONGEST_CHUNK = 1024  # points a side of a compressed chunk
_COMPRESSION = 4  # of zlib's levels; higher ones gain a few per cent


class _Axis(NamedTuple):
    """An axis of an array that is as long as a dimension which grows."""

    array: h5py.Dataset
    place: int
    dimension: str


class _Array(NamedTuple):
    """An array of the file. turn: shape of one turn where that is a chunk, stored as it lies in memory; else None."""

    hdf5: h5py.Dataset
    turn: tuple[int, ...] | None


class AppendableNetCDF:
    """A NetCDF file that is written beside its own name, and takes that name when it is closed.

    Leaving the context by an exception closes it too: whole turns stay readable. Nothing appears if there are none.
    `length` counts what is complete of each dimension that grows; what is beyond it goes when the file is closed.

    path: the file's own name. growing: names of the dimensions that grow; a variable has one of them at most, and one
    that has none is written with the first turn. constant: groups that do not grow, by name. compressed: fields (a
    growing first dimension and others) are packed by zlib. rounding: by unit, the step to whose multiples fields are
    rounded, and say so in their `comment`. whole: go on after so many turns of what a kill or an interruption has left
    of the file (one dimension grows); OSError, ValueError, KeyError where they are not there. Else it begins anew.
    """

    def __init__(
        self,
        path: Path,
        growing: tuple[str, ...] = ("turn",),
        *,
        constant: Mapping[str, xr.Dataset] | None = None,
        compressed: bool = False,
        rounding: Mapping[str, float] | None = None,
        whole: int = 0,
    ) -> None:
        self.path = path
        self.length = self._before = dict.fromkeys(growing, 0)
        self._constant, self._compressed, self._rounding = constant or {}, compressed, rounding or {}
        self._part = part_of(path)
        if not whole:
            remove_parts(path)
        self._disk: CommittedFile | None = None
        self._hdf5: h5py.File | None = None
        self._file: h5netcdf.File | None = None
        self._axes: list[_Axis] = []  # looking them up takes as long as writing a turn, and so do the arrays
        self._arrays: dict[tuple[str, str], _Array] = {}  # by group and name
        if whole:
            self._reopen(whole)

    @property
    def complete(self) -> int:
        """How many turns are whole: the length of the first dimension that grows."""
        return next(iter(self.length.values()))

    def append(self, data: xr.Dataset | xr.DataTree) -> None:
        """Append one turn or more: a dataset, or a tree with a group for each of its children.

        Ctrl-C and SIGTERM wait. Raises OSError, and stays as it was, where the disk has no room for it.
        """
        with uninterrupted(), self._naming():
            self._append({"": data} if isinstance(data, xr.Dataset) else _groups(data))

    def _append(self, groups: dict[str, xr.Dataset]) -> None:
        new = not self._axes
        file = self._opened([*groups.values(), *(self._constant.values() if new else ())])
        if new:
            for name, dataset in (groups | dict(self._constant)).items():
                self._create(file.create_group(name) if name else file, dataset)
                self._find_arrays(name, dataset.variables)
            file.flush()  # ties dimensions to variables
            assert self._hdf5 is not None
            self._axes = _axes(self._hdf5, self.length)
        sizes = {name: next((d.sizes[name] for d in groups.values() if name in d.sizes), 0) for name in self.length}
        end = {name: length + sizes[name] for name, length in self.length.items()}
        _resize(self._axes, end)
        for group_name, dataset in groups.items():
            for name, variable in dataset.variables.items():
                dimension = self._growing(variable)
                if dimension is not None:
                    beyond = slice(self.length[dimension], end[dimension])
                    at = tuple(beyond if dim == dimension else slice(None) for dim in variable.dims)
                    self._write(self._arrays[group_name, str(name)], at, self._rounded(variable))
        self._count(end)

    def _write(self, array: _Array, at: tuple[slice, ...], values: np.ndarray[Any, Any]) -> None:
        """Turns that are chunks go past HDF5's own memory, which would take as long again as the disk.

        The first turn does not: HDF5 then puts all trees of chunks in one place, before the values.
        """
        first = at[0].start
        if not first or values.shape[1:] != array.turn:
            array.hdf5[at] = values
            return
        for number, turn in enumerate(np.ascontiguousarray(values, dtype=array.hdf5.dtype), first):
            array.hdf5.id.write_direct_chunk((number, *(0 for _ in turn.shape)), turn)

    def annotate(self, attributes: Mapping[str, Any]) -> None:
        """Set attributes of the file, which has a turn; whole with the next turn, or when it is closed."""
        assert self._file is not None
        self._file.attrs.update(dict(attributes))

    def take_back(self) -> None:
        """Forget what was appended last."""
        self.length = self._before

    def close(self) -> None:
        """Finish the file; a turn that failed halfway, or was taken back, goes. Ctrl-C and SIGTERM wait."""
        with uninterrupted(), self._naming():
            try:
                self._finish()
            finally:
                if self._disk is not None:
                    self._disk.close()
                    self._disk = None
            remove_parts(self.path)

    def _finish(self) -> None:
        if self._disk is None or self._hdf5 is None or self._file is None:
            return
        if self.complete:
            _resize(self._axes, self.length)
        self._file.close()
        self._hdf5.close()
        self._file = self._hdf5 = None
        if self.complete:
            note = {"length": self.length, "before": self.length}
            try:
                self._disk.commit(note)
            except OSError:  # no room for a journal: without one, since what is written is there already
                self._disk.commit(note, journal=False)
            os.replace(self._part, self.path)

    @contextlib.contextmanager
    def _naming(self) -> Iterator[None]:
        """An error of the disk names the file as the user knows it."""
        try:
            yield
        except OSError as error:
            if error.errno is None:
                raise
            raise OSError(error.errno, os.strerror(error.errno), str(self.path)) from None

    def __enter__(self) -> Self:
        return self

    def __exit__(
        self, kind: type[BaseException] | None, error: BaseException | None, trace: TracebackType | None
    ) -> None:
        self.close()

    # --------------------------------------------------------------------------------------------- room on the disk

    def _opened(self, datasets: list[xr.Dataset]) -> h5netcdf.File:
        """The file, with so much space reserved by the file system. OSError if it gives none.

        Where the system (macOS) or the file system has no such reservation, the file is written without it.
        """
        if self._disk is None or self._file is None:
            self._disk = CommittedFile(self._part)
            self._hdf5 = h5py.File(self._disk, "w", track_order=True)
            self._file = h5netcdf.File(self._hdf5, "w")
        try:
            self._disk.reserve(self._room(datasets))
        except OSError as error:
            if error.errno not in (errno.EINVAL, errno.EOPNOTSUPP):
                raise
        return self._file

    def _room(self, datasets: list[xr.Dataset]) -> int:
        """The most bytes that the datasets can take."""
        variables = [variable for dataset in datasets for variable in dataset.variables.values()]
        values = sum(variable.nbytes for variable in variables) * (_INCOMPRESSIBLE if self._compressed else 1.0)
        chunks = sum(_CHUNK_BYTES for each in variables if each.ndim > 1 and each.dims[-1] in self.length)
        return int(values) + chunks + _INDEX_BYTES * (16 + len(variables))

    def _count(self, length: dict[str, int]) -> None:
        """What was written is complete, and room that it did not need is given back."""
        assert self._disk is not None
        assert self._hdf5 is not None
        self._hdf5.flush()
        self._disk.commit({"length": length, "before": self.length})
        self._before, self.length = self.length, length

    # ------------------------------------------------------------------------------------------------- the variables

    def _create(self, group: h5netcdf.Group, dataset: xr.Dataset) -> None:
        """Dimensions, attributes and variables of a group; the values of those that do not grow."""
        group.dimensions = {str(d): (None if d in self.length else int(n)) for d, n in dataset.sizes.items()}
        group.attrs.update({str(k): v for k, v in dataset.attrs.items()})
        for key, variable in dataset.variables.items():
            text = variable.dtype.kind in "UO"
            kind = h5py.string_dtype() if text else variable.dtype
            fill = np.nan if variable.dtype.kind == "f" else None
            dims = tuple(str(d) for d in variable.dims)
            made = group.create_variable(str(key), dims, kind, fillvalue=fill, **self._layout(variable))
            made.attrs.update(self._attributes(variable))
            if self._growing(variable) is None:
                made[...] = variable.values.astype(object) if text else variable.values
        coordinates = [str(name) for name in dataset.coords if name not in dataset.dims]
        if coordinates:
            group.attrs["coordinates"] = " ".join(coordinates)

    def _reopen(self, whole: int) -> None:
        """Go on with what is there; turns beyond `whole` go. It is given up as it is found where it is damaged."""
        if self._part.exists():
            mend(self._part)
        else:
            os.replace(self.path, self._part)
        self._disk = CommittedFile(self._part, existing=True)
        try:
            self._hdf5 = h5py.File(self._disk, "r+")
            self._file = h5netcdf.File(self._hdf5, "r+")
            self._axes = _axes(self._hdf5, self.length)
            if not self._axes or min(axis.array.shape[axis.place] for axis in self._axes) < whole:
                raise ValueError(f"{self._part} does not hold {whole} whole turns")
        except BaseException:
            self._disk.close()
            raise
        for name, group in {"": self._file, **self._file.groups}.items():
            self._find_arrays(name, group.variables)
        self._before = self.length = dict.fromkeys(self.length, whole)
        _resize(self._axes, self.length)
        self._count(self.length)

    def _find_arrays(self, group: str, variables: Iterable[Any]) -> None:
        assert self._hdf5 is not None
        for name in map(str, variables):
            array = self._hdf5[f"{group}/{name}"]
            assert isinstance(array, h5py.Dataset)
            turn = array.shape[1:]
            plain = array.dtype.kind in "iuf" and array.compression is None and array.chunks == (1, *turn)
            self._arrays[group, name] = _Array(array, turn if plain else None)

    def _growing(self, variable: xr.Variable) -> str | None:
        return next((name for name in self.length if name in variable.dims), None)

    def _is_field(self, variable: xr.Variable) -> bool:
        return variable.ndim > 1 and variable.dims[0] in self.length

    def _layout(self, variable: xr.Variable) -> dict[str, Any]:
        """Chunks: one turn of a field, so that a turn takes as much of the disk as it holds; else HDF5's own choice."""
        if not self._is_field(variable):
            return {}
        if not self._compressed:
            return {"chunks": (1, *variable.shape[1:])}
        chunks = (1, *(min(size, _LONGEST_CHUNK) for size in variable.shape[1:]))
        return {"chunks": chunks, "compression": "gzip", "compression_opts": _COMPRESSION, "shuffle": True}

    def _step(self, variable: xr.Variable) -> float | None:
        """To whose multiples a variable is rounded; None where it is kept as it is."""
        field = self._is_field(variable) and variable.dtype.kind == "f"
        return self._rounding.get(variable.attrs.get("units", "")) if field else None

    def _rounded(self, variable: xr.Variable) -> np.ndarray[Any, Any]:
        step = self._step(variable)
        return variable.values if step is None else step * np.round(variable.values / step)

    def _attributes(self, variable: xr.Variable) -> dict[str, Any]:
        attributes = {str(k): v for k, v in variable.attrs.items()}
        step = self._step(variable)
        if step is not None:
            before = f"{attributes['comment']}; " if "comment" in attributes else ""
            attributes["comment"] = f"{before}rounded to multiples of {step:.3g}"
        return attributes


def _groups(tree: xr.DataTree) -> dict[str, xr.Dataset]:
    return {str(node.name): node.to_dataset() for node in tree.children.values()}


def _axes(file: h5py.File, growing: Iterable[str]) -> list[_Axis]:
    """All axes that grow: of a dimension's own array, and of those that NetCDF ties to it."""
    found: list[tuple[Any, int, str]] = []
    for group in (file, *(each for each in file.values() if isinstance(each, h5py.Group))):
        for name in growing:
            if name in group:
                own = group[name]
                tied = own.attrs.get("REFERENCE_LIST", ())
                found += [(own, 0, name), *((file[array], int(place), name) for array, place in tied)]
    return [_Axis(*each) for each in found]


def _resize(axes: Iterable[_Axis], length: Mapping[str, int]) -> None:
    """Bring axes to the length of their dimensions."""
    for array, place, dimension in axes:
        shape = list(array.shape)
        shape[place] = length[dimension]
        array.id.set_extent(tuple(shape))


# ------------------------------------------------------------------------------------------------- after a kill


def remove_parts(path: Path) -> None:
    """Remove what a file leaves beside its own name."""
    part = part_of(path)
    for left in (part, journal_of(part), journal_of(part).with_name(f"{journal_of(part).name}.part")):
        left.unlink(missing_ok=True)


def recoverable(path: Path) -> int:
    """How many whole turns of a file a kill has left in the file beside it. OSError, ValueError if it is damaged."""
    part = part_of(path)
    note = mend(part) if part.exists() else None
    return next(iter(note["length"].values())) if note else 0


def recover_netcdf(path: Path, turns: int) -> None:
    """Give the first so many of the turns that a kill has left the file's own name; none: remove what is left.

    turns: as `recoverable` counts them, or one less. May itself be killed and called again.
    Raises OSError, ValueError for more or fewer turns.
    """
    part = part_of(path)
    note = mend(part) if part.exists() else None
    if note and turns:
        lengths = [length for length in (note["length"], note["before"]) if next(iter(length.values())) == turns]
        if not lengths:
            raise ValueError(f"{part} cannot be brought to {turns} turns")
        if lengths[0] != note["length"]:
            _cut(part, lengths[0])
        os.replace(part, path)
    remove_parts(path)


def _cut(part: Path, length: Mapping[str, int]) -> None:
    """Shorten a mended file."""
    disk = CommittedFile(part, existing=True)
    try:
        with h5py.File(disk, "r+") as file:
            _resize(_axes(file, length), length)
        disk.commit({"length": dict(length), "before": dict(length)})
    finally:
        disk.close()
