"""The one way to open what a user, a scene, a header, a browser or a folder of runs names.

Only a regular file is opened: a FIFO would wait for ever, a device never ends. Text is read up to a limit. Arrays are
checked by what their file declares before one is read (`check_declared_size`), packed bytes are counted as they are
unpacked, and a file of HDF5 that would have others read with it is refused. What is wrong becomes an InputError of one
line.

In all functions `wanted` is what the file is to be, in words; `named` is how messages call it, else by its path;
`below` is a folder in which it must lie, links followed.
"""

from __future__ import annotations

import bz2
import contextlib
import errno
import gzip
import lzma
import math
import os
import stat
import zlib
from collections.abc import Collection, Iterable, Iterator
from contextlib import closing
from io import BufferedReader
from pathlib import Path
from typing import IO, TYPE_CHECKING, Any, cast

from ..errors import InputError, MachineLimitError
from .text import decode_text

if TYPE_CHECKING:  # each takes a part of a second to load
    import h5py
    import xarray as xr
    from numpy.typing import NDArray

PathLike = str | os.PathLike[str]

SHORT = 4_000_000  # bytes of text that a person writes: a scene, a header
LONG = 256_000_000  # bytes of a table as text, unpacked
_FREELY = 64 * 2**20  # bytes that anything may take
_DENSEST = 100.0  # times that more may unpack to: measured numbers pack to a tenth, nothing but zeros to a thousandth
_OF_FREE = 0.8  # of the memory that is free
_DESCRIPTIONS = ("zarr.json", ".zarray", ".zattrs", ".zgroup", ".zmetadata")
_DESCRIBED = 16_000_000  # bytes of one
_A_CHUNK = 200  # bytes that reading one more chunk takes
_MOST_OBJECTS = 10_000  # in a file of HDF5
_KINDS = {stat.S_IFIFO: "a FIFO", stat.S_IFSOCK: "a socket", stat.S_IFCHR: "a device", stat.S_IFBLK: "a device"}


# ------------------------------------------------------------------------------------------------------- any file


def open_file(
    path: PathLike,
    wanted: str = "a file",
    *,
    named: str | None = None,
    most: float | None = None,
    below: PathLike | None = None,
) -> BufferedReader:
    """A regular file, open for reading bytes; it neither waits nor reads. most: bytes that it may have.

    Raises InputError for one that is missing, no regular file, not readable, longer than `most`, or not `below`.
    """
    called = named or os.fspath(path)
    handle = -1
    try:
        handle = os.open(path, os.O_RDONLY | os.O_NONBLOCK | os.O_NOCTTY | os.O_CLOEXEC)
        found = os.fstat(handle)
        _check(path, found, called, wanted, most, below)
        return os.fdopen(handle, "rb")
    except BaseException as error:
        if handle >= 0:
            os.close(handle)
        if isinstance(error, FileNotFoundError | NotADirectoryError):
            raise InputError(f"{called}: no such file; give the path of {wanted}") from None
        if isinstance(error, OSError):
            if error.errno == errno.ENXIO:
                raise InputError(f"{called}: is a socket or a device, not a regular file; give {wanted}") from None
            raise InputError(f"{called}: cannot be read ({error.strerror}); give a readable file") from None
        if isinstance(error, ValueError) and not isinstance(error, InputError):  # a path with a null byte
            raise InputError(f"{called}: is not a path ({error}); give the path of {wanted}") from None
        raise


def _check(
    path: PathLike, found: os.stat_result, called: str, wanted: str, most: float | None, below: PathLike | None
) -> None:
    if stat.S_ISDIR(found.st_mode):
        raise InputError(f"{called}: is a folder, not a file; give {wanted} in it")
    if not stat.S_ISREG(found.st_mode):
        kind = _KINDS.get(stat.S_IFMT(found.st_mode), "something else")
        raise InputError(f"{called}: is {kind}, not a regular file; give {wanted}")
    if most is not None and found.st_size > most:
        raise InputError(f"{called}: has {size(found.st_size)}: must have at most {size(most)}; make it smaller")
    if below is not None:
        real = Path(path).resolve()
        if not (real.is_relative_to(Path(below).resolve()) and os.path.samestat(found, os.stat(real))):
            raise InputError(f"{called}: lies outside of {os.fspath(below)}; copy it there")


def check_file(path: PathLike, wanted: str = "a file", **rules: Any) -> None:
    """Raise InputError where `open_file` would: before a library opens the file by its path."""
    open_file(path, wanted, **rules).close()


def read_bytes(path: PathLike, wanted: str = "a file", *, most: float = SHORT, **rules: Any) -> bytes:
    """All of a regular file of at most `most` bytes. Raises InputError."""
    called = rules.get("named") or os.fspath(path)
    with open_file(path, wanted, most=most, **rules) as file:
        return b"".join(_pieces(file, called, most))


def read_json(path: PathLike, wanted: str = "a JSON file", **rules: Any) -> Any:
    """What a JSON file holds. Raises InputError."""
    from pydantic_core import from_json  # bounded in depth and in digits, and text that no one can write is refused

    called = rules.get("named") or os.fspath(path)
    text = decode_text(read_bytes(path, wanted, **rules), called)
    try:
        return from_json(text)
    except ValueError as error:
        raise InputError(f"{called}: is not JSON ({error}); mend it") from None


def read_unpacked(path: PathLike, wanted: str = "a file", *, most: float = LONG, **rules: Any) -> bytes:
    """All of a file, unpacked where it ends in .gz, .bz2, .xz or .zst; at most `most` bytes. Raises InputError."""
    import zstandard

    called = rules.get("named") or os.fspath(path)
    openers: dict[str, Any] = {".gz": gzip.open, ".bz2": bz2.open, ".xz": lzma.open, ".zst": zstandard.open}
    with open_file(path, wanted, most=most, **rules) as packed:
        opener = openers.get(Path(path).suffix.lower())
        try:
            with packed if opener is None else closing(opener(packed, "rb")) as file:
                return b"".join(_pieces(file, called, most))
        except (OSError, EOFError, lzma.LZMAError, zlib.error, zstandard.ZstdError) as error:
            raise InputError(f"{called}: cannot be read ({error}); give a whole file") from None


def _pieces(file: IO[bytes], called: str, most: float) -> Iterator[bytes]:
    total = 0
    while piece := file.read(1 << 20):
        total += len(piece)
        if total > most:
            raise InputError(f"{called}: holds more than {size(most)}, the most it may; make it smaller")
        yield piece


# --------------------------------------------------------------------------------------------------------- memory


def check_declared_size(called: str, need: float, packed: float | None = None) -> None:
    """Raise InputError where `need` bytes of arrays are so many more than the `packed` bytes of their file that these
    can hold hardly anything but zeros, and MachineLimitError where they are more than the free memory holds."""
    if need <= _FREELY:
        return
    from ..compute.machine import free_memory

    if packed is not None and need > _DENSEST * packed:
        raise InputError(
            f"{called}: declares {size(need)} of numbers in {size(packed)}: must be at most {_DENSEST:g} times as "
            "much; write what was measured alone"
        )
    free = _OF_FREE * free_memory()
    if need > free:
        raise MachineLimitError(
            f"{called}: declares {size(need)} of numbers: must fit into {size(free)} of free memory; give fewer"
        )


def bytes_held(path: PathLike) -> int:
    """Bytes on the disk of a file, or of all files of a folder: holes of a file hold none."""
    if os.path.isdir(path):
        return sum(bytes_held(os.path.join(at, name)) for at, _, names in os.walk(path) for name in names)
    found = os.stat(path)
    return min(found.st_size, 512 * getattr(found, "st_blocks", found.st_size))


def size(count: float) -> str:
    """Bytes in words."""
    for unit, factor in (("GB", 1e9), ("MB", 1e6), ("kB", 1e3)):
        if count >= factor:
            return f"{count / factor:.3g} {unit}"
    return f"{count:.0f} bytes"


# ----------------------------------------------------------------------------------------- files that hold arrays


def read_npz(
    path: PathLike, names: Collection[str], wanted: str = "a .npz file", **rules: Any
) -> tuple[list[str], dict[str, NDArray]]:
    """Names of all arrays of a NumPy archive, and those of `names` that it has, if their declared size fits.

    Raises InputError, and what NumPy and zipfile raise for damage.
    """
    from numpy.lib import format as npy
    from numpy.lib.npyio import NpzFile

    with open_file(path, wanted, **rules) as opened, NpzFile(opened, allow_pickle=False) as file:
        found, need, archive = [name for name in names if name in file.files], 0, cast(Any, file.zip)
        for name in found:
            with archive.open(name if name in archive.namelist() else f"{name}.npy") as array:
                read = npy.read_array_header_1_0 if npy.read_magic(array) == (1, 0) else npy.read_array_header_2_0
                shape, _, kind = read(array)
            need += math.prod(shape) * kind.itemsize
        check_declared_size(rules.get("named") or os.fspath(path), need, bytes_held(path))
        return list(file.files), {name: file[name] for name in found}


def open_hdf5(path: PathLike, wanted: str = "a file of HDF5", *, rows: bool = False, **rules: Any) -> h5py.File:
    """A file of HDF5, to be closed, that reads no other file. Raises InputError, and OSError for what is no HDF5.

    Arrays that are read whole must pass `check_declared_arrays` first; so must rows, unless they are asked for: see
    `check_hdf5`.
    """
    import h5py

    check_file(path, wanted, **rules)
    file = h5py.File(path, "r")
    try:
        check_hdf5(file, rules.get("named") or os.fspath(path), rows)
    except BaseException:
        file.close()
        raise
    return file


def check_hdf5(file: h5py.File, called: str, rows: bool = False) -> None:
    """Raise InputError for a file with external links, external storage or virtual arrays, which are others' files; or
    with a chunk of more than there is room for, which the least access reads. rows: or with such vectors, which xarray
    reads where they are axes, or rows, turns and frames mostly."""
    from h5py import h5d, h5l, h5o  # type: ignore[attr-defined]

    problems, seen, need, stored = list[str](), 0, 0, 0

    def look(link: bytes, facts: Any) -> bool | None:
        nonlocal seen, need, stored
        name, seen = link.decode("utf-8", "replace"), seen + 1
        if facts.type not in (h5l.TYPE_HARD, h5l.TYPE_SOFT):
            problems.append(f"'{name}' is a link to another file")
        elif seen > _MOST_OBJECTS:
            problems.append(f"there are more than {_MOST_OBJECTS} groups and arrays in it")
        elif facts.type == h5l.TYPE_HARD and isinstance(found := h5o.open(file.id, link), h5d.DatasetID):
            made = found.get_create_plist()
            if made.get_external_count():
                problems.append(f"'{name}' lies in another file (external storage)")
            elif made.get_layout() == h5d.VIRTUAL:
                problems.append(f"'{name}' is made of other arrays (a virtual dataset)")
            else:
                chunk = math.prod(made.get_chunk()) if made.get_layout() == h5d.CHUNKED else 0
                row = math.prod(found.shape[1:] or found.shape) if rows else 0
                need += max(chunk, row) * found.get_type().get_size()
                stored += found.get_storage_size()
        return True if problems else None  # ends the visit

    file.id.links.visit(look, info=True)
    if problems:
        raise InputError(f"{called}: {problems[0]}, which is not read; save one file that holds all of it")
    check_declared_size(called, need, min(stored, _stored_bytes(file)))


def _stored_bytes(file: h5py.File) -> float:
    try:
        return bytes_held(os.fsdecode(file.filename))
    except (OSError, ValueError, TypeError):  # an open file, or memory
        return float("inf")


def check_declared_arrays(file: h5py.File, names: Iterable[str], called: str) -> None:
    """Raise InputError where the arrays of these names, or in the groups of these names, do not fit together."""
    check_declared_size(called, sum(_declared_bytes(file[name]) for name in names if name in file), _stored_bytes(file))


def _declared_bytes(node: Any) -> int:
    """Bytes that an array of HDF5 declares, or all arrays of a group."""
    import h5py

    if isinstance(node, h5py.Dataset):
        return node.nbytes
    found = list[int]()
    if isinstance(node, h5py.Group):
        node.visititems(lambda _, each: found.append(each.nbytes) if isinstance(each, h5py.Dataset) else None)
    return sum(found)


def open_dataset(path: PathLike, wanted: str = "a NetCDF file", **options: Any) -> xr.Dataset:
    """A NetCDF file, version 3 or 4, as `xarray.open_dataset` opens it with these options, not yet read.

    named, below: as everywhere. Raises InputError, OSError for what is no NetCDF, and what xarray raises for damage.
    """
    import xarray as xr

    return xr.open_dataset(path, engine=_netcdf_engine(path, wanted, options), **options)


def open_tree(path: PathLike, wanted: str = "a NetCDF file", **options: Any) -> xr.DataTree:
    """Open a file as `open_dataset` does, with all groups."""
    import xarray as xr

    return xr.open_datatree(path, engine=_netcdf_engine(path, wanted, options), **options)


def load(opened: Any, called: str, path: PathLike, dense: bool = True) -> Any:
    """A dataset or a tree in memory, if its declared size fits. path: its file. dense: it does not consist of what is
    missing."""
    import h5py

    need = opened.nbytes
    if h5py.is_hdf5(path):  # whose arrays may be longer than the dimensions that h5netcdf tells, and are read whole
        with h5py.File(path, "r") as file:
            need = max(need, _declared_bytes(file))
    check_declared_size(called, need, bytes_held(path) if dense else None)
    return opened.load()


def _netcdf_engine(path: PathLike, wanted: str, options: dict[str, Any]) -> Any:
    """The library that reads a file, which was looked through; takes `named` and `below` out of the options, and
    leaves out what no library decodes (`drop_variables`)."""
    rules = {key: options.pop(key) for key in ("named", "below") if key in options}
    called = rules.get("named") or os.fspath(path)
    with open_file(path, wanted, **rules) as file:
        start = file.read(8)
    if start[:3] == b"CDF":
        from scipy.io import netcdf_file

        with netcdf_file(os.fspath(path), mmap=True) as opened:
            vectors = [each for each in opened.variables.values() if len(each.dimensions) < 2]
            need = sum(math.prod(each.shape) * each.itemsize() for each in vectors)
            del vectors
        check_declared_size(called, need, bytes_held(path))
        return "scipy"
    import h5py

    if not h5py.is_hdf5(path):
        raise OSError("neither NetCDF-3 nor NetCDF-4")
    # Of arrays whose elements are arrays of any length, as images are kept: no sea's, and xarray cannot decode them
    # where cftime is installed.
    ragged = list[str]()

    def look(name: str, node: Any) -> None:
        if isinstance(node, h5py.Dataset) and h5py.check_vlen_dtype(node.dtype) not in (None, str, bytes):
            ragged.append(name.rpartition("/")[2])

    with h5py.File(path, "r") as opened:
        check_hdf5(opened, called, rows=True)
        opened.visititems(look)
    if ragged:
        options["drop_variables"] = [*options.get("drop_variables", ()), *ragged]
    return "h5netcdf"


def check_store(path: PathLike, wanted: str = "a Zarr store", *, named: str | None = None, group: str = "") -> None:
    """Raise InputError for a folder that is no Zarr store of regular files, links followed to such below it, or whose
    vectors and chunks do not fit: before Zarr reads one. group: all but the root's description that is read of it."""
    called, root, need, held = named or os.fspath(path), Path(path), 0, 0
    if not any((root / name).exists() for name in _DESCRIPTIONS):
        raise OSError("no Zarr store")
    own = [(root, [], [name for name in _DESCRIPTIONS if (root / name).exists()])] if group else []
    for at, _, names in (*own, *os.walk(root / group)):
        for name in names:
            file = os.path.join(at, name)
            if name in _DESCRIPTIONS:
                rules = {"most": _DESCRIBED, "below": root, "named": f"{called}: {os.path.relpath(file, root)}"}
                content = read_json(file, f"{wanted} of regular files", **rules)
                need += _least_access_bytes(content)
                continue
            with contextlib.suppress(FileNotFoundError):  # of a store that grows
                if not stat.S_ISREG(os.lstat(file).st_mode):
                    check_file(file, f"{wanted} of regular files", below=root)
                held += bytes_held(file)
    check_declared_size(called, need, held)


def _least_access_bytes(content: dict[str, Any]) -> int:
    """Bytes that the least access to an array of Zarr reads, by its description: a vector, or a chunk. Of a group that
    describes its arrays ("consolidated metadata"), to all of them."""
    import numpy as np

    try:
        if "shape" not in content:
            return sum(map(_least_access_bytes, content["consolidated_metadata"]["metadata"].values()))
        grid = [
            content.get("chunk_grid", {}),
            *(each for each in content.get("codecs") or () if "shard" in each["name"]),
        ]
        chunk = grid[-1].get("configuration", content).get("chunk_shape") or content["chunks"]
        kind, shape = content.get("data_type") or content["dtype"], content["shape"]
        width = np.dtype(kind).itemsize if isinstance(kind, str) else 8
        chunks = math.prod(-(-size // each) for size, each in zip(shape, chunk, strict=True))
    except (KeyError, TypeError, ValueError, ZeroDivisionError, AttributeError):
        return 0  # of another kind, or damaged: Zarr says so
    return math.prod(shape) * width + chunks * _A_CHUNK if len(shape) < 2 else math.prod(chunk) * width
