"""One Zarr store for what grows by whole turns, and the NetCDF files that are made of it.

A turn's chunks come first; Zarr writes each file whole. Then the description of the root ("consolidated metadata") is
written, which says how long all arrays are and how many turns are complete (`complete_turns`): that one file is the
mark. So a kill at any instant leaves the turns before, of all groups the same; and whoever opens the store with
`zarr.open_group` or `xr.open_zarr` sees these alone, also while it grows. An array's own description gives it room for
turns to come until the store is finished. `check_chunks` finds by the names and lengths of its files alone whether a
group holds all that its arrays promise.
"""

from __future__ import annotations

import asyncio
import contextlib
import errno
import math
import os
from collections.abc import Callable, Collection, Coroutine, Iterable, Iterator, Mapping
from itertools import product
from pathlib import Path
from typing import Any, NamedTuple, Self, cast

import h5netcdf
import h5py
import numpy as np
import xarray as xr
import zarr
from zarr.core.sync import sync

from ..errors import InputError
from .process import hold_interruptions, suppress_complaints
from .results_folder import DESCRIPTION, FINISHED, remove_tree, whole_file

EVERY_CHUNK = "every_chunk_written"
"""Attribute of a group, 1 where its writer left out no chunk.

Zarr lets a writer leave out a chunk of fill values alone, and a reader takes one that is lost for such a one: zeros.
"""
COMPLETE, ORDER = "complete_turns", "in_order"
OWN_ATTRIBUTES = (EVERY_CHUNK, ORDER, "coordinates")  # of a group, which its NetCDF file does not have
_DIMENSIONS, _PACKS = "growing", "packed"
_OF_ITS_TYPE = ("flag_masks", "flag_values")  # attributes of an array, by the conventions
ROOM = 16  # turns for which an array has room at first, and each time that it gets more
_SMALL, _LARGE = 2**14, 2**23  # bytes: turns share a chunk as far as they are smaller, and have several beyond
_CHUNK = 1024  # points a side of a packed chunk of NetCDF, and turns or samples of one that is no field
_PACKED = {"zlib": True, "complevel": 4, "shuffle": True}  # higher levels gain a few per cent
_GROWTH, _INDEX_BYTES = 1.01, 2**20  # of a file beside its values: what zlib cannot compress grows; trees of chunks


class _GrowingArray(NamedTuple):
    """An array that grows along an axis, by rows of which so many are whole. It has room for more."""

    array: zarr.Array
    axis: int
    whole: int = 0

    def shape(self, rows: int, of: tuple[int, ...] | None = None) -> tuple[int, ...]:
        """The array's shape, or another one, with so many rows."""
        shape = of or self.array.shape
        return *shape[: self.axis], rows, *shape[self.axis + 1 :]

    async def write(self, values: np.ndarray[Any, Any]) -> None:
        """Rows behind those that are whole."""
        rows = values.shape[self.axis]
        end = self.whole + rows
        if end > self.array.shape[self.axis]:
            await self.array.async_array.resize(self.shape(self.whole + ROOM * rows))
        await self.array.async_array.setitem((slice(None),) * self.axis + (slice(self.whole, end),), values)


class ClosedOnExit(contextlib.AbstractContextManager[Any]):
    """A file, or a store, that is closed when its context is left, by an exception too."""

    close: Callable[[], None]

    def __exit__(self, *raised: Any) -> None:
        try:
            self.close()
        except OSError:
            if raised[1] is None:  # else that one is reported
                raise


class GrowingStore(ClosedOnExit):
    """A Zarr store whose groups grow by whole turns, all or none of them.

    path: of the store. growing: names of the dimensions that grow; an array has one of them at most, and one that has
    none is written with the first turn. files: NetCDF files by the groups of which they are made when it is closed.
    packed: their fields (a growing first dimension and others) are packed by zlib.

    Without a single turn it leaves nothing behind. Where the disk has no room for the files the store stays unfinished,
    and `reopen` makes them. `complete` counts the whole turns.
    """

    def __init__(
        self,
        path: Path,
        growing: Collection[str] = ("turn",),
        files: Mapping[str, Path] | None = None,
        packed: bool = False,
    ) -> None:
        self.path, self.complete = path, 0
        self._dimensions, self._packed, self._files = tuple(growing), packed, files or {}
        self._root: zarr.Group | None = None
        self._growing: dict[str, _GrowingArray] = {}  # by the paths of the arrays

    @classmethod
    def reopen(cls, path: Path, files: Mapping[str, Path] | None = None, most: int | None = None) -> Self:
        """What a kill, or a full disk, has left of a store, to be closed or gone on with after at most so many turns.

        OSError, ValueError, KeyError where it is damaged.
        """
        if not any(each.is_dir() for each in path.iterdir()):  # killed before there was anything
            return cls(path, (), files)
        for left in path.rglob("*.partial"):  # as Zarr calls a file that is not whole
            left.unlink(missing_ok=True)
        root = zarr.open_group(path, mode="r+", zarr_format=3)
        store = cls(path, cast(list[str], root.attrs[_DIMENSIONS]), files, bool(root.attrs[_PACKS]))
        store._root, store.complete = root, int(cast(int, root.attrs[COMPLETE]))
        own = zarr.open_group(path, mode="r+", zarr_format=3, use_consolidated=False)
        for name, member in root.members(max_depth=None) if store.complete else ():
            if isinstance(member, zarr.Array) and (axis := store._axis(dims_of(member))) is not None:
                store._growing[name] = _GrowingArray(cast(zarr.Array, own[name]), axis, member.shape[axis])
        if most is not None and most < store.complete:
            store._mark({name: each._replace(whole=most) for name, each in store._growing.items()}, most)
        return store

    def append(self, turn: Mapping[str, xr.Dataset | xr.DataTree | None], turns: int = 1) -> None:
        """Append a turn, or several at once: datasets by the names of their groups, or trees of such.

        A group may begin with a later turn, and has nothing of a turn in which it is None. Ctrl-C and SIGTERM wait.
        Raises OSError, and stays as it was, where the disk has no room for it, or somebody has removed a part of it.
        """
        data = {name: _datasets_of(value) for name, value in turn.items() if value is not None}
        with hold_interruptions(), name_in_errors(self.path):
            self._check()
            for name, leaves in data.items():
                self._create_group(name, leaves)
            after, writing = dict(self._growing), []
            for path, growing in self._growing.items():
                top, _, below = path.partition("/")
                leaf, _, name = below.rpartition("/")
                if top in data:
                    values = data[top][leaf].variables[name].values
                    if growing.shape(0) != growing.shape(0, values.shape):
                        raise ValueError(f"{path}: {values.shape}, after others of {growing.array.shape}")
                    writing.append((growing, values))
                    after[path] = growing._replace(whole=growing.whole + values.shape[growing.axis])
            _await_all(growing.write(values) for growing, values in writing)
            self._mark(after, self.complete + turns)

    def write_files(self, attributes: Mapping[str, Any] | None = None) -> None:
        """Make the NetCDF files of what is whole. attributes: of the files, beside those of the first turn.

        OSError where the disk is full, InputError where a chunk is lost.
        """
        groups = zarr.open_group(self.path, mode="r", zarr_format=3)
        for name in self._files.keys() & set(groups):
            write_netcdf(groups, name, self._files[name], attributes)

    def close(self) -> None:
        """Make the files, and leave of the store what is whole. Ctrl-C and SIGTERM wait. Raises as `write_files`."""
        with hold_interruptions():
            if self.complete:
                self.write_files()
                self._finish()
            elif self._root is not None:
                remove_tree(self.path)

    def _axis(self, names: Iterable[Any]) -> int | None:
        return next((axis for axis, name in enumerate(names) if name in self._dimensions), None)

    def _create_group(self, top: str, leaves: Mapping[str, xr.Dataset]) -> None:
        """A group with all that does not grow."""
        if self._root is None:
            remove_tree(self.path)
            first = {COMPLETE: 0, FINISHED: 0, _DIMENSIONS: list(self._dimensions), _PACKS: self._packed}
            zarr.open_group(self.path, mode="w", zarr_format=3, attributes=first)
            self._root = _consolidate(self.path)
        if top in (described := _members_of(self._root)):
            return
        group, below = zarr.open_group(self.path, path=top, mode="w", zarr_format=3), [name for name in leaves if name]
        group.attrs[ORDER], made = list(below), dict[str, _GrowingArray]()
        for leaf, dataset in leaves.items():
            node = group.create_group(leaf) if leaf else group
            beside = " ".join(str(name) for name in dataset.coords if name not in dataset.dims)
            own = {EVERY_CHUNK: 1, ORDER: [*map(str, dataset.variables), *(() if leaf else below)]}
            own |= ({"coordinates": beside} if beside else {}) | ({COMPLETE: 0} if COMPLETE in dataset.attrs else {})
            node.update_attributes(_json_attributes(dataset.attrs) | own)
            for name, variable in dataset.variables.items():
                array, axis = self._create_array(node, str(name), variable), self._axis(variable.dims)
                if axis is not None:
                    made[array.path] = _GrowingArray(array, axis)
        described[top] = _consolidate(self.path, top).metadata
        self._growing |= made

    def _create_array(self, node: zarr.Group, name: str, variable: xr.Variable) -> zarr.Array:
        axis, text = self._axis(variable.dims), variable.dtype.kind in "OUT"
        shape, chunks = list(variable.shape), [max(1, size) for size in variable.shape]
        if axis is not None:
            size, bytes_each = shape[axis], max(1, variable.nbytes)
            large, shape[axis] = bytes_each > _LARGE, 0
            chunks[axis] = -(-size // -(-bytes_each // _LARGE)) if large else size * max(1, _SMALL // bytes_each)
        array = node.create_array(
            name,
            shape=tuple(shape),
            dtype=cast(Any, str if text else variable.dtype),
            chunks=tuple(chunks),
            fill_value=np.nan if variable.dtype.kind == "f" else None,
            config={"write_empty_chunks": True},  # zeros too: a chunk that is not there is lost
            compressors=None,  # noise does not compress, and a turn must be written in a fraction of a second
            dimension_names=[str(each) for each in variable.dims],
            attributes=_json_attributes(variable.attrs),
        )
        if axis is None:
            array[...] = variable.values.astype(object) if text else variable.values
        return array

    def _mark(self, after: dict[str, _GrowingArray], complete: int) -> None:
        """Say in the description of the root, at once, how long all arrays are and how many turns are complete."""
        assert self._root is not None
        for path, growing in after.items():
            *groups, name = path.split("/")
            held = _members_of(self._root)
            for each in groups:
                held = _members_of(held[each])
            held[name] = growing.array.metadata.update_shape(growing.shape(growing.whole))
        for group in _members_of(self._root).values():
            if COMPLETE in group.attributes:
                group.attributes[COMPLETE] = complete
        self._root = self._root.update_attributes({COMPLETE: complete, FINISHED: 0})
        self._growing, self.complete = after, complete

    def _finish(self) -> None:
        """Cut off what is not whole, and describe what is left: each group by itself, and all."""
        groups = zarr.open_group(self.path, mode="r", zarr_format=3)
        wanted = ((each.array, each.shape(each.whole)) for each in self._growing.values())
        _await_all(array.async_array.resize(shape) for array, shape in wanted if array.shape != shape)
        for path in self.path.iterdir():
            if path.is_dir() and path.name not in groups:  # of a turn that was not marked
                remove_tree(path)
        for name, group in groups.groups():
            if COMPLETE in group.attrs:
                zarr.open_group(self.path, path=name, mode="r+", use_consolidated=False).attrs[COMPLETE] = self.complete
            _consolidate(self.path, name)
        _consolidate(self.path).update_attributes({FINISHED: 1})

    def _check(self) -> None:
        """Zarr makes anew what somebody has removed, with zeros for turns that were there: the last ones must be."""
        needed = [] if self._root is None else [DESCRIPTION]
        for path, growing in self._growing.items():
            sizes = zip(growing.shape(growing.whole), growing.array.chunks, strict=True)
            last = growing.array.metadata.encode_chunk_key(tuple(max(size - 1, 0) // chunk for size, chunk in sizes))
            needed += [f"{path}/{DESCRIPTION}", *([f"{path}/{last}"] if growing.whole else [])]
        for each in needed:
            if not (self.path / each).exists():
                raise FileNotFoundError(errno.ENOENT, os.strerror(errno.ENOENT), str(self.path / each))


def _await_all(awaited: Iterable[Coroutine[Any, Any, None]]) -> None:
    """Run what Zarr does to many arrays in one call of its loop: a call for each takes half as long again."""

    async def ended() -> list[BaseException | None]:
        return await asyncio.gather(*awaited, return_exceptions=True)

    for error in sync(ended()):
        if error is not None:
            raise error


def _datasets_of(value: xr.Dataset | xr.DataTree) -> dict[str, xr.Dataset]:
    """Datasets by their names below the group; the group's own has an empty name."""
    if isinstance(value, xr.Dataset):
        return {"": value}
    own = {"": value.to_dataset()} if value.variables else {}
    return own | {str(node.name): node.to_dataset(inherit=False) for node in value.children.values()}


def _json_attributes(attributes: Mapping[Any, Any]) -> dict[str, Any]:
    """Attributes as JSON has them."""
    return {str(k): v.tolist() if isinstance(v, np.ndarray | np.generic) else v for k, v in attributes.items()}


def _consolidate(path: Path, group: str | None = None) -> zarr.Group:
    with suppress_complaints():  # format 3 does not speak of it yet
        return zarr.consolidate_metadata(path, path=group, zarr_format=3)


def _members_of(group: Any) -> dict[str, Any]:
    """What the description of a group, or of its metadata, says of its members."""
    held = getattr(group, "metadata", group).consolidated_metadata
    return cast(dict[str, Any], held.metadata)


@contextlib.contextmanager
def name_in_errors(path: Path) -> Iterator[None]:
    """An error of the disk names the file, or the store, as the user knows it."""
    try:
        yield
    except OSError as error:
        if error.errno is None:
            raise
        raise OSError(error.errno, os.strerror(error.errno), str(path)) from None


# ------------------------------------------------------------------------------------------------------ the chunks


def check_chunks(
    path: Path, lengths: Mapping[str, int], may_lack: Collection[str], only: Collection[str] | None = None
) -> None:
    """Raise InputError, which names the chunk, for a group in a folder that lacks one or holds a part of one.

    lengths: by dimension, how much of it must be there, where that is not all. may_lack: names of arrays whose chunks
    may be left out, unless the group's attribute EVERY_CHUNK says that none is. only: names of the arrays to look at,
    where not all. Only whole uncompressed chunks have a length that is known; others show damage when they are read.
    """
    group = zarr.open_group(path, mode="r", zarr_format=3, use_consolidated=False)
    every = bool(group.attrs.get(EVERY_CHUNK, False))
    for name, array in group.arrays():
        if only is not None and name not in only:
            continue
        files = [Path(root, each) for root, _, names in os.walk(path / name) for each in names]
        held = {each.relative_to(path / name).as_posix(): each.stat().st_size for each in files}
        codecs = getattr(array.metadata, "codecs", ())
        plain = len(codecs) == 1 and type(codecs[0]).__name__ == "BytesCodec"  # stored as it is in memory, not packed
        expected = math.prod(array.chunks) * array.dtype.itemsize if plain else None
        for key in _chunk_keys(array, lengths):
            size = held.get(key)
            if size is None and (every or name not in may_lack):
                raise InputError(
                    f"'{path / name / key}': is missing, and would be read as zeros; copy the store whole, or write it "
                    "with write_empty_chunks=True"
                )
            if size is not None and expected is not None and size != expected:
                raise InputError(f"'{path / name / key}': holds {size} bytes: must be {expected}; copy the store whole")


def dims_of(array: zarr.Array) -> tuple[str | None, ...]:
    """Names of an array's dimensions; empty where it gives none."""
    return tuple(getattr(array.metadata, "dimension_names", None) or ())


def _chunk_keys(array: zarr.Array, lengths: Mapping[str, int]) -> Iterator[str]:
    """Names of the files of an array's chunks, or shards, one by one: a damaged shape may promise 10¹⁸ of them."""
    names = dims_of(array) or [""] * array.ndim
    lengths_here = [min(size, lengths.get(str(name), size)) for size, name in zip(array.shape, names, strict=True)]
    stored = array.shards or array.chunks
    counts = [math.ceil(length / max(1, chunk)) for length, chunk in zip(lengths_here, stored, strict=True)]
    for place in product(*map(range, counts)):
        yield array.metadata.encode_chunk_key(place)


# ------------------------------------------------------------------------------------------------- the NetCDF files


def write_netcdf(root: zarr.Group, name: str, path: Path, attributes: Mapping[str, Any] | None = None) -> None:
    """Make a NetCDF file of a group of a store, whole or not at all. Memory holds about a turn of it.

    Raises OSError where the disk has no room for it, InputError where a chunk is lost.
    """
    growing, packed = set(cast(list[str], root.attrs[_DIMENSIONS])), bool(root.attrs[_PACKS])
    top = cast(zarr.Group, root[name])
    below = {each: top[each] for each in cast(list[str], top.attrs[ORDER])}
    groups = {"": top} | {each: found for each, found in below.items() if isinstance(found, zarr.Group)}
    further: dict[str, zarr.Array] = {}
    for leaf, group in groups.items():
        lengths = {str(d): n for _, each in group.arrays() for d, n in zip(dims_of(each), each.shape, strict=True)}
        check_chunks(Path(str(cast(Any, root.store).root), name, leaf), lengths, ())
        further |= {f"{leaf}/{n}": each for n, each in group.arrays() if not growing.isdisjoint(dims_of(each))}
    first = {f"/{leaf}": _first_rows(group, growing) for leaf, group in groups.items()}
    unlimited = {leaf: [d for d in dataset.dims if d in growing] for leaf, dataset in first.items()}
    encoding = {leaf: _chunk_layout(dataset, growing, packed) for leaf, dataset in first.items()}
    # In memory, as HDF5 itself may crash if it cannot write.
    made = xr.DataTree.from_dict(first).to_netcdf(engine="h5netcdf", encoding=encoding, unlimited_dims=unlimited)
    with whole_file(path) as part:
        part.write_bytes(made)
        _reserve(part, sum(each.nbytes for each in further.values()))
        with h5py.File(part, "r+") as hdf5:
            for each, array in further.items():
                axis = next(axis for axis, dim in enumerate(dims_of(array)) if dim in growing)
                length, step, made = array.shape[axis], array.chunks[axis], cast(Any, hdf5[each])
                made.resize(length, axis)
                for start in range(0, length, step):
                    rows = (slice(None),) * axis + (slice(start, min(start + step, length)),)
                    made[rows] = array[rows]
        with h5netcdf.File(part, "r+") as file:
            for node in (file, *file.groups.values()):
                for dim, dimension in node.dimensions.items():
                    if dimension.isunlimited():
                        node.resize_dimension(dim, dimension.size)  # as long as its arrays
            file.attrs.update(attributes or {})


def _first_rows(group: zarr.Group, growing: Collection[str]) -> xr.Dataset:
    """All that does not grow, and the first row of what does."""
    variables = {}
    for name in cast(list[str], group.attrs[ORDER]):
        if isinstance(array := group[name], zarr.Array):
            values = np.asarray(array[tuple(slice(0, 1 if dim in growing else None) for dim in dims_of(array))])
            of_its_type = {k: np.array(array.attrs[k], array.dtype) for k in _OF_ITS_TYPE if k in array.attrs}
            values = values.astype(object).astype(str) if values.dtype.kind == "T" else values
            variables[name] = dims_of(array), values, array.attrs.asdict() | of_its_type
    attributes = {k: v for k, v in group.attrs.items() if k not in OWN_ATTRIBUTES}
    beside = str(group.attrs.get("coordinates", "")).split()
    return xr.Dataset(variables, attrs=attributes).set_coords(beside)


def is_field(dims: tuple[Any, ...], growing: Collection[str]) -> bool:
    """Whether an array of such dimensions grows along the first of several."""
    return len(dims) > 1 and dims[0] in growing


def _chunk_layout(dataset: xr.Dataset, growing: Collection[str], packed: bool) -> dict[Any, dict[str, Any]]:
    """Chunks of what grows: one turn of a field, and many of what is short."""
    layout: dict[Any, dict[str, Any]] = {}
    for name, variable in dataset.variables.items():
        if set(growing).isdisjoint(variable.dims):
            continue
        field = is_field(variable.dims, growing)
        most, ahead = _CHUNK if packed and field else max(variable.shape), 1 if field else _CHUNK
        sizes = zip(variable.dims, variable.shape, strict=True)
        chunks = tuple(ahead if dim in growing else min(size, most) for dim, size in sizes)
        layout[name] = {"chunksizes": chunks} | (_PACKED if packed and field else {})
    return layout


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
