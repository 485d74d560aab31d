"""Whether a Zarr store holds all that its arrays promise, by the names and lengths of its files alone."""

from __future__ import annotations

import math
import os
from collections.abc import Collection, Iterator, Mapping
from itertools import product
from pathlib import Path

import zarr

from ..errors import InputError

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
    where not all. Only whole uncompressed chunks have a
    length that is known; others show damage when they are read.
    """
    group = zarr.open_group(path, mode="r", zarr_format=3, use_consolidated=False)
    every = bool(group.attrs.get(EVERY_CHUNK, False))
    for name, array in group.arrays():
        if only is not None and name not in only:
            continue
        held = _files(path / name)
        expected = _plain_bytes(array)
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


def _files(folder: Path) -> dict[str, int]:
    """Bytes of each file below a folder, by its path from there."""
    found = {}
    for root, _, names in os.walk(folder):
        below = Path(root)
        found |= {(below / name).relative_to(folder).as_posix(): (below / name).stat().st_size for name in names}
    return found


def _keys(array: zarr.Array, lengths: Mapping[str, int]) -> Iterator[str]:
    """Names of the files of an array's chunks, or shards, one by one: a damaged shape may promise 10¹⁸ of them."""
    names = names_of(array) or [""] * array.ndim
    lengths_here = [min(size, lengths.get(str(name), size)) for size, name in zip(array.shape, names, strict=True)]
    counts = [math.ceil(length / max(1, chunk)) for length, chunk in zip(lengths_here, _stored(array), strict=True)]
    for place in product(*map(range, counts)):
        yield array.metadata.encode_chunk_key(place)


def _stored(array: zarr.Array) -> tuple[int, ...]:
    return array.shards or array.chunks


def _plain_bytes(array: zarr.Array) -> int | None:
    """Bytes of a chunk that is stored as it is in memory; None where it is packed."""
    codecs = getattr(array.metadata, "codecs", ())
    plain = len(codecs) == 1 and type(codecs[0]).__name__ == "BytesCodec"
    return math.prod(array.chunks) * array.dtype.itemsize if plain else None
