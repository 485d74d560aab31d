"""MATLAB files: numbers, structs and texts of versions 4 to 7 (SciPy) and 7.3 (HDF5), in the shapes that MATLAB shows.

HDF5 counts dimensions from the other end, so arrays of version 7.3 are transposed. Fields of structs are reached by
paths, as `rx/lower`.
"""

from __future__ import annotations

import os
import struct
import zlib
from collections.abc import Callable, Collection
from pathlib import Path
from typing import Any, BinaryIO

import h5py
import numpy as np
import scipy.io
from numpy.typing import NDArray

from .opening import bytes_held, open_file, open_hdf5, weigh, weigh_arrays

_PACKED = 15  # type of a packed variable


def read_matlab(
    path: Path, wanted: Collection[str], read: Callable[[h5py.Dataset, str], NDArray]
) -> tuple[list[str], dict[str, Any]]:
    """Names of all variables, and those of `wanted` that are there: arrays, texts, and structs as dicts.

    read: how an array of an HDF5 dataset is read; it may refuse one. Raises what SciPy and h5py raise for damage."""
    with open_file(path, "a recording") as opened:
        if not h5py.is_hdf5(path):
            _weigh(opened, path)
            held = [name for name, _, _ in scipy.io.whosmat(opened) if not name.startswith("__")]
            names = {name.split("/")[0] for name in wanted}
            tree = scipy.io.loadmat(opened, chars_as_strings=True, variable_names=names)
            found = {name: _at(tree, name.split("/")) for name in wanted}
            return held, {name: _value(node) for name, node in found.items() if node is not None}
    with open_hdf5(path, "a recording") as file:
        weigh_arrays(file, wanted, str(path))
        held = [str(name) for name in file if not str(name).startswith("#")]
        return held, {name: _hdf5_value(file[name], name, read) for name in wanted if name in file}


def _weigh(opened: BinaryIO, path: Path) -> None:
    """Raise InputError for a file whose variables are too large, those of version 5 once they are unpacked: it is done,
    piece by piece, since what they say of their length may be wrong."""
    held, mark = bytes_held(path), opened.read(128)[126:]
    total = float(os.fstat(opened.fileno()).st_size)
    while mark in (b"IM", b"MI") and len(tag := opened.read(8)) == 8:
        kind, left = struct.unpack("<II" if mark == b"IM" else ">II", tag)
        after, unpack = opened.tell() + left, zlib.decompressobj()
        while kind == _PACKED and left and (piece := opened.read(min(left, 1 << 20))):
            left -= len(piece)
            while piece:
                total += len(unpack.decompress(piece, 1 << 20))
                piece = unpack.unconsumed_tail
                weigh(str(path), total, held)
        opened.seek(after)
    weigh(str(path), total, held)
    opened.seek(0)


def _at(node: Any, way: list[str]) -> Any:
    """What lies at a path of structs' fields; None where there is nothing."""
    for field in way:
        if isinstance(node, dict):
            node = node.get(field)
        elif isinstance(node, np.ndarray) and node.dtype.names and field in node.dtype.names and node.size == 1:
            node = node[field].flat[0]
        else:
            return None
    return node


def _value(node: Any) -> Any:
    if isinstance(node, np.ndarray) and node.dtype.names and node.size == 1:
        return {name: _value(node[name].flat[0]) for name in node.dtype.names}
    if isinstance(node, np.ndarray) and node.dtype.kind in "US":
        return str(node.flat[0]) if node.size else ""
    return node


def _hdf5_value(node: Any, name: str, read: Callable[[h5py.Dataset, str], NDArray]) -> Any:
    if isinstance(node, h5py.Group):
        return {field: _hdf5_value(node[field], f"{name}/{field}", read) for field in node}
    values = read(node, name)
    kind = node.attrs.get("MATLAB_class", b"")
    if kind in (b"char", "char"):
        return "".join(chr(each) for each in values.T.ravel(order="C"))
    return values.T


def plain_value(value: Any) -> Any:
    """A field of a struct as a text, a number or a list of numbers."""
    if isinstance(value, np.ndarray):
        return value.flat[0].item() if value.size == 1 else [each.item() for each in value.ravel(order="F")]
    return value
