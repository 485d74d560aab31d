"""The Zarr store into which a run streams its echoes turn by turn.

Zarr writes each file of it whole, so a kill loses no turn; but it may leave arrays of unlike length. While a store
grows, its attribute `complete_pulses` counts the pulses of the complete turns, and `recover_echoes` cuts off what is
beyond. The store's own description ("consolidated metadata") is brought up to date when a turn is whole: whoever opens
the store with `xr.open_zarr` alone sees whole turns, also while it grows. `check_chunks` finds by the names and lengths
of its files alone whether a store holds all that its arrays promise.
"""

from __future__ import annotations

import contextlib
import errno
import math
import os
import shutil
from collections.abc import Collection, Iterable, Iterator, Mapping
from itertools import product
from pathlib import Path
from typing import Any, Self

import numpy as np
import xarray as xr
import zarr

from ..errors import InputError
from .opening import read_json
from .process import quietly

EVERY_CHUNK = "every_chunk_written"
"""Attribute of a store, 1 where its writer left out no chunk.

Zarr lets a writer leave out a chunk of fill values alone, and a reader takes one that is lost for such a one: zeros.
"""


def check_chunks(
    path: Path, lengths: Mapping[str, int], may_lack: Collection[str], only: Collection[str] | None = None
) -> None:
    """Raise InputError, which names the chunk, for a store in a folder that lacks one or holds a part of one.

    lengths: by dimension, how much of it must be there, where that is not all. may_lack: names of arrays whose chunks
    may be left out, unless the store's attribute EVERY_CHUNK says that none is. only: names of the arrays to look at,
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
        for key in _keys(array, lengths):
            size = held.get(key)
            if size is None and (every or name not in may_lack):
                raise InputError(
                    f"'{path / name / key}': is missing, and would be read as zeros; copy the store whole, or write it "
                    "with write_empty_chunks=True"
                )
            if size is not None and expected is not None and size != expected:
                raise InputError(f"'{path / name / key}': holds {size} bytes: must be {expected}; copy the store whole")


def names_of(array: zarr.Array) -> tuple[str | None, ...]:
    """Of its dimensions; empty where it says none."""
    return tuple(getattr(array.metadata, "dimension_names", None) or ())


def _keys(array: zarr.Array, lengths: Mapping[str, int]) -> Iterator[str]:
    """Names of the files of an array's chunks, or shards, one by one: a damaged shape may promise 10¹⁸ of them."""
    names = names_of(array) or [""] * array.ndim
    lengths_here = [min(size, lengths.get(str(name), size)) for size, name in zip(array.shape, names, strict=True)]
    stored = array.shards or array.chunks
    counts = [math.ceil(length / max(1, chunk)) for length, chunk in zip(lengths_here, stored, strict=True)]
    for place in product(*map(range, counts)):
        yield array.metadata.encode_chunk_key(place)


PULSES_PER_CHUNK, READINGS_PER_CHUNK = 2000, 20000  # of voltages, and of what else a pulse has: a file each takes 1 ms
PULSES = "complete_pulses"
DESCRIPTION = "zarr.json"


class EchoStore:
    """A Zarr group that grows by whole turns; its attribute `complete_turns` counts those that are all there.

    Left as a context without a single one, it leaves nothing behind.
    """

    def __init__(self, path: Path) -> None:
        self.path = path
        self._arrays: dict[str, zarr.Array] = {}  # those that grow
        self._length = self._before = (0, 0)  # turns and pulses that are complete, and were before the last turn

    def append(self, turn: xr.Dataset) -> None:
        """Append one turn's echoes (schema `echoes`), or none of it where the disk has no room: then OSError.

        OSError too where somebody has removed a part of the store.
        """
        if not self._arrays:
            self._create(turn)
        turns, pulses = self._length
        self._check(pulses)
        length = int(turn.attrs["complete_turns"]), pulses + turn.sizes["pulse"]
        try:
            for name, array in self._arrays.items():
                array.append(turn[name].values)
            _describe(self.path, *length)
        except BaseException:  # interrupted, or no space left: arrays of unlike length could not be read any more
            with contextlib.suppress(OSError):
                _cut(self.path, self._arrays.values(), turns, pulses)
            raise
        self._before, self._length = self._length, length

    def rollback(self) -> None:
        """Forget the turn that was appended last."""
        if self._length != self._before:
            self._length = self._before
            _cut(self.path, self._arrays.values(), *self._length)

    def __enter__(self) -> Self:
        return self

    def __exit__(self, *raised: Any) -> None:
        turns, pulses = self._length
        if self._arrays and not turns:
            shutil.rmtree(self.path, ignore_errors=True)
        elif self._arrays:
            try:
                _cut(self.path, self._arrays.values(), turns, pulses, growing=False)
            except OSError:
                if raised[1] is None:  # else that one is reported
                    raise

    def _create(self, turn: xr.Dataset) -> None:
        if self.path.exists():
            shutil.rmtree(self.path)
        first = {"complete_turns": 0, "coordinates": "time azimuth transmitter turn", PULSES: 0, EVERY_CHUNK: 1}
        group = zarr.open_group(self.path, mode="w", zarr_format=3, attributes=turn.attrs | first)
        for name, variable in turn.variables.items():
            rolling = variable.dims[0] == "pulse"
            rows = PULSES_PER_CHUNK if name == "voltage" else READINGS_PER_CHUNK
            array = group.create_array(
                str(name),
                shape=(0, *variable.shape[1:]) if rolling else variable.shape,
                dtype=variable.dtype,
                chunks=(rows, *variable.shape[1:]) if rolling else variable.shape,
                config={"write_empty_chunks": True},  # zeros too: a chunk that is not there is lost
                compressors=None,  # noise does not compress, and a turn must be written in a fraction of a second
                dimension_names=[str(d) for d in variable.dims],
                attributes={k: (v.tolist() if isinstance(v, np.ndarray) else v) for k, v in variable.attrs.items()},
            )
            if rolling:
                self._arrays[str(name)] = array
            else:
                array[...] = variable.values
        _describe(self.path, 0, 0)

    def _check(self, pulses: int) -> None:
        """Zarr makes anew what somebody has removed, with zeros for turns that were there: the last ones must be."""
        for name, array in self._arrays.items():
            last = ((pulses - 1) // array.chunks[0], *(0 for _ in array.shape[1:]))
            needed = [DESCRIPTION, f"{name}/{DESCRIPTION}"]
            if pulses:
                needed.append(f"{name}/{array.metadata.encode_chunk_key(last)}")
            for each in needed:
                if not (self.path / each).exists():
                    raise FileNotFoundError(errno.ENOENT, os.strerror(errno.ENOENT), str(self.path / each))


def _cut(path: Path, arrays: Iterable[zarr.Array], turns: int, pulses: int, growing: bool = True) -> None:
    """Leave so many turns, which have so many pulses. The attributes come first: then what is longer is not read."""
    with quietly():  # of arrays whose files somebody has removed
        zarr.open_group(path, mode="r+", zarr_format=3).update_attributes({"complete_turns": turns, PULSES: pulses})
        for array in arrays:
            if array.shape[0] != pulses:
                array.resize((pulses, *array.shape[1:]))
    _describe(path, turns, pulses, growing)


def _describe(path: Path, turns: int, pulses: int, growing: bool = True) -> None:
    """Say how many turns are complete, and describe all arrays as they are now, in the store's own description."""
    with quietly():  # format 3 does not speak of it yet
        group = zarr.consolidate_metadata(path, zarr_format=3)
    attributes = group.attrs.asdict() | {"complete_turns": turns, PULSES: pulses}
    if not growing:
        del attributes[PULSES]
    group.attrs.put(attributes)


# ------------------------------------------------------------------------------------------------- after a kill


def is_growing(path: Path) -> bool:
    """Whether a store is being written, or was when its run was killed."""
    attributes = _attributes(path)
    return attributes is None or PULSES in attributes or "complete_turns" not in attributes


def recoverable_turns(path: Path) -> int:
    """How many whole turns are in a store."""
    return int((_attributes(path) or {}).get("complete_turns", 0))


def recover_echoes(path: Path, turns: int) -> None:
    """Leave the first so many turns of a store that a kill has left; none: remove it. May be called again."""
    for left in path.rglob("*.partial"):  # as Zarr calls a file that is not whole
        left.unlink(missing_ok=True)
    if not turns:
        shutil.rmtree(path, ignore_errors=True)
        return
    group = zarr.open_group(path, mode="r+", zarr_format=3, use_consolidated=False)
    arrays = {name: array for name, array in group.arrays() if names_of(array)[0] == "pulse"}
    pulses = int(group.attrs[PULSES])  # type: ignore[arg-type]
    if turns < recoverable_turns(path):
        pulses = int(np.searchsorted(np.asarray(arrays["turn"][:pulses]), turns))
    _cut(path, arrays.values(), turns, pulses, growing=False)


def _attributes(path: Path) -> dict[str, Any] | None:
    """What the store says of itself; None where it does not even exist whole."""
    try:
        return dict(read_json(path / DESCRIPTION)["attributes"])
    except (OSError, ValueError, KeyError):
        return None
