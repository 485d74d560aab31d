"""A radar's own recording, as it lies in a file: voltages of two receivers, when and whereto each pulse went, a header.

Arrays are found by their names: `lower` and `upper` (pulse, gate), complex or pairs of real numbers (…, 2); `time` [s]
and `azimuth` (pulse,); and, where there are any, `ranges` (gate,), `attitude`, `position`, `transmitter`, `turn` and
`quality`. Sensors slower than the pulses have times of their own, `attitude_time` and `position_time`. Files are .npz
(NumPy), .mat (MATLAB), and HDF5 or NetCDF (.h5, .hdf5, .nc); what has other names in them is found by saying which.
What attributes there say of packing, missing values and units is obeyed.

MATLAB's files are read in the shapes that MATLAB shows: versions 4 to 7 (SciPy) and 7.3 (HDF5, which counts dimensions
from the other end, so its arrays are transposed). Fields of structs are reached by paths, as `rx/lower`.

The header, a TOML or JSON file or a dict, says what the arrays do not: RecordingHeader (recording_header.py). Whatever
is wrong becomes an InputError of one line.
"""

from __future__ import annotations

import difflib
import json
import math
import os
import zipfile
from collections.abc import Callable, Collection, Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import h5py
import numpy as np
import scipy.io
from numpy.typing import NDArray

from ..errors import InputError, must_be
from .declared import convert_by_attributes, decode
from .matlab_elements import check_version_5
from .opening import (
    check_declared_arrays,
    load,
    open_dataset,
    open_file,
    open_hdf5,
    read_npz,
)
from .recording_header import Header, RecordingHeader, header_object, read_header, toml_counterpart, validate_header
from .text import plain_attribute

NEEDED = ("lower", "upper", "time", "azimuth")
ARRAYS = (*NEEDED, "ranges", "attitude", "attitude_time", "position", "position_time", "transmitter", "turn", "quality")
HDF5_ENDINGS = (".h5", ".hdf5", ".nc")
RECORDING_ENDINGS = (".npz", *HDF5_ENDINGS, ".mat")
MAY_LACK = ("transmitter", "turn", "attitude", "quality")  # where zeros, and nothing else, are usual
_VECTORS = ("time", "azimuth", "ranges", "attitude_time", "position_time", "transmitter", "turn", "quality")
_UNITS = {"attitude": "degree", "position": "m", "ranges": "m", "azimuth": "degree"} | dict.fromkeys(
    ("time", "attitude_time", "position_time"), "s"
)
_COUNTS = ("count", "counts", "1", "")  # units of an encoder's azimuths
_WANTED = "a recording"
_MOST_UNWRITTEN = 1e8  # bytes of an array of which nothing is in the file
_MOST_BYTES = 64e9  # of an array: more than an hour
_PIECES = (("real", "imag"), ("r", "i"), ("re", "im"), ("i", "q"))  # names of a pair's two numbers


@dataclass(frozen=True)
class Recording:
    """The arrays of a recording by their names in ARRAYS, and its header."""

    arrays: dict[str, NDArray]
    header: RecordingHeader


def read_recording(
    path: str | os.PathLike[str], header: Header | None = None, names: Mapping[str, str] | None = None
) -> Recording:
    """A recording from a file. names: of arrays in ARRAYS that the file calls otherwise (HDF5: their paths).

    Without `header` it is the text (JSON) or the attributes that the file itself holds under the name `header`, else
    the .toml or .json file of the same name beside it. Raises InputError.
    """
    must_be("path", path, (str, os.PathLike), f"the path of a recording, a file {', '.join(RECORDING_ENDINGS)}")
    path, names = Path(path), dict(names or {})
    if unknown := [name for name in names if name not in ARRAYS]:
        raise InputError(f"names: '{unknown[0]}' is no array of a recording; it has {', '.join(ARRAYS)}")
    read = {".npz": _load_npz, ".mat": _load_matlab, **dict.fromkeys(HDF5_ENDINGS, _load_hdf5)}.get(path.suffix.lower())
    if read is None:
        raise InputError(f"{path}: must be a file of the kinds {', '.join(RECORDING_ENDINGS)}; save it as one of them")
    try:
        arrays, held = read(path, {name: names.get(name, name) for name in ARRAYS})
    except InputError:
        raise
    except Exception as error:  # NumPy, zip and HDF5 raise exceptions of many types where a file is damaged
        damage = f" ({error})" if isinstance(error, OSError | ValueError | zipfile.BadZipFile) else ""
        raise InputError(f"{path}: cannot be read{damage}; give a whole recording, or save it anew") from None
    for name in NEEDED:
        if name not in arrays:
            raise InputError(f"{path}: holds no '{names.get(name, name)}'; add it, or say by names what it is called")
    if header is None and held is None:
        beside = [path.with_suffix(ending) for ending in (".toml", ".json") if path.with_suffix(ending).exists()]
        if not beside:
            raise InputError(
                f"{path}: has no header; give one, or put it beside it as {path.with_suffix('.toml').name}"
            )
        header = beside[0]
    return Recording(arrays, validate_header(str(path), held) if header is None else read_header(header))  # type: ignore[arg-type]


def _load_npz(path: Path, inside: Mapping[str, str]) -> tuple[dict[str, NDArray], Mapping[str, Any] | None]:
    held, found = read_npz(path, {*inside.values(), "header"}, _WANTED)
    _refuse_slips(path, held, inside)
    arrays = {name: pairs_of(found[stored], stored) for name, stored in inside.items() if stored in found}
    return arrays, _header_text(found.get("header"), path)


def _load_hdf5(path: Path, inside: Mapping[str, str]) -> tuple[dict[str, NDArray], Mapping[str, Any] | None]:
    with open_file(path, _WANTED) as opened:
        if opened.read(3) == b"CDF":
            return _load_netcdf3(path, inside)
    with open_hdf5(path, _WANTED) as file:
        _refuse_slips(path, list(file), inside)
        check_declared_arrays(file, (*inside.values(), "header"), str(path))
        arrays = {name: _hdf5_array(file[stored], name, stored) for name, stored in inside.items() if stored in file}
        held: Any = file.get("header", file.attrs.get("header"))
        if isinstance(held, h5py.Group):
            return arrays, {key: _matlab_number(key, toml_counterpart(value)) for key, value in held.attrs.items()}
        return arrays, _header_text(held.asstr()[()] if isinstance(held, h5py.Dataset) else held, path)


def _load_netcdf3(path: Path, inside: Mapping[str, str]) -> tuple[dict[str, NDArray], Mapping[str, Any] | None]:
    with open_dataset(path, _WANTED, decode_cf=False) as file:
        _refuse_slips(path, [str(name) for name in file.variables], inside)
        held = load(
            file[[stored for stored in (*inside.values(), "header") if stored in file.variables]], str(path), path
        )
        there = {name: held[stored] for name, stored in inside.items() if stored in held.variables}
        arrays = {
            name: _convert_unit(decode(each.to_numpy(), each.attrs, inside[name]), each.attrs, name, inside[name])
            for name, each in there.items()
        }
        text = b"".join(held["header"].values.ravel()) if "header" in held.variables else file.attrs.get("header")
        return arrays, _header_text(text, path)


def _header_text(text: Any, path: Path) -> Mapping[str, Any] | None:
    """The header in a file's text (JSON), if there is one."""
    text = plain_attribute(text)
    return None if text is None else header_object(json.loads(str(text)), f"{path}: header")


def _convert_unit(values: NDArray, attributes: Mapping[str, Any], name: str, stored: str) -> NDArray:
    """An array in the unit of its name, if it tells another."""
    unit = _UNITS.get(name)
    counts = name == "azimuth" and str(plain_attribute(attributes.get("units", ""))).lower() in _COUNTS
    return values if unit is None or counts else convert_by_attributes(values, attributes, unit, stored)


def _load_matlab(path: Path, inside: Mapping[str, str]) -> tuple[dict[str, NDArray], Mapping[str, Any] | None]:
    held, found = read_matlab(
        path, {*inside.values(), "header"}, lambda node, name: _read_all(node, name, may_lack=True)
    )
    _refuse_slips(path, held, inside)
    arrays = {name: _matlab_array(found[stored], name, stored) for name, stored in inside.items() if stored in found}
    header = found.get("header")
    if header is None or isinstance(header, str):
        return arrays, _header_text(header, path)
    entries = header_object(header, str(path)).items()
    return arrays, {
        key: _matlab_number(key, plain_attribute(value.ravel(order="F")) if isinstance(value, np.ndarray) else value)
        for key, value in entries
    }


def _matlab_number(key: str, value: Any) -> Any:
    """MATLAB's numbers are all real: 0 and 1 of a key that is true or false, 8192.0 of one that counts."""
    field = RecordingHeader.model_fields.get(key)
    if field is not None and field.annotation is bool and value in (0, 1):
        return bool(value)
    if field is not None and field.annotation == (int | None) and isinstance(value, float) and value.is_integer():
        return int(value)
    return value


def _matlab_array(value: Any, name: str, stored: str) -> NDArray:
    """MATLAB has no vectors: one of the two dimensions of what should be one is 1."""
    if isinstance(value, Mapping):
        real, imag = (np.asarray(value[piece]) for piece in _complex_parts(list(value), stored))
        value = np.stack((real, imag), -1)
    if not isinstance(value, np.ndarray) or (value.dtype.names is None and value.dtype.kind not in "biufc"):
        raise InputError(f"{stored}: holds no numbers: must be an array of numbers; save it so")
    value = pairs_of(value, stored)
    return value.ravel() if name in _VECTORS and 1 in value.shape else value


def _hdf5_array(node: Any, name: str, inside: str) -> NDArray:
    """An array of HDF5. A wrong shape may be too large to be read first."""
    may_lack = name in MAY_LACK
    if name in ("attitude", "position") and isinstance(node, h5py.Dataset) and node.shape[1:] != (3,):
        raise InputError(f"{inside}: has the shape {node.shape}: must be (·, 3); give three numbers for each")
    if isinstance(node, h5py.Group):
        pieces = {f"{inside}/{piece}": node[piece] for piece in _complex_parts(list(node), inside)}
        values = np.stack([_read_all(piece, called, may_lack) for called, piece in pieces.items()], -1)
    else:
        values = pairs_of(_read_all(node, inside, may_lack), inside)
    return _convert_unit(values, node.attrs, name, inside)


def _read_all(node: Any, name: str, may_lack: bool) -> NDArray:
    """All of an HDF5 dataset. What was never written HDF5 reads as fill values, zeros mostly."""
    if not isinstance(node, h5py.Dataset) or node.dtype.kind not in "biufcV":
        raise InputError(f"{name}: holds no numbers: must be an array of numbers; save it so")
    if node.nbytes > _MOST_BYTES:
        raise InputError(
            f"{name}: has the shape {node.shape} and takes {node.nbytes / 1e9:.3g} GB: must take at most "
            f"{_MOST_BYTES / 1e9:g}; split the recording"
        )
    stored = node.id.get_num_chunks() if node.chunks else int(node.id.get_storage_size() > 0)
    promised = 1
    if node.chunks:
        promised = math.prod(-(-size // chunk) for size, chunk in zip(node.shape, node.chunks, strict=True))
    if node.size and stored < promised and not may_lack:
        raise InputError(
            f"{name}: holds {stored} of {promised} chunks, and the others would be read as zeros; copy the file whole, "
            "or cut it to what was recorded"
        )
    if not stored and node.nbytes > _MOST_UNWRITTEN:
        raise InputError(f"{name}: has the shape {node.shape} and was never written; leave it out, or write it")
    return decode(node[()], node.attrs, name)


def pairs_of(values: NDArray, name: str) -> NDArray:
    """Records of two numbers as pairs (…, 2); all else as it is."""
    if values.dtype.names is None:
        return values
    real, imag = _complex_parts(list(values.dtype.names), name)
    return np.stack([values[real], values[imag]], axis=-1)


def _complex_parts(held: list[str], name: str) -> tuple[str, str]:
    """What a group or a record calls the real and the imaginary part."""
    result = {key.lower(): key for key in held}
    for real, imag in _PIECES:
        if real in result and imag in result:
            return result[real], result[imag]
    raise InputError(f"{name}: holds {', '.join(held)}: must be complex, or hold real and imag; name them so")


def _refuse_slips(path: Path, held: list[str], inside: Mapping[str, str]) -> None:
    """What is nearly named like an array would be left out without a message."""
    meant = set(inside.values())
    for name in held:
        near = difflib.get_close_matches(name, [each for each in meant - set(held) if "/" not in each], 1, 0.8)
        if name not in meant and near:
            raise InputError(f"{path}: '{name}' is no array of a recording; did you mean {near[0]}?")


def read_matlab(
    path: Path, wanted: Collection[str], read: Callable[[h5py.Dataset, str], NDArray]
) -> tuple[list[str], dict[str, Any]]:
    """Names of all variables, and those of `wanted` that are there: arrays, texts, and structs as dicts.

    read: how an array of an HDF5 dataset is read; it may refuse one. Raises what SciPy and h5py raise for damage."""
    with open_file(path, "a recording") as opened:
        if not h5py.is_hdf5(path):
            check_version_5(opened, path)
            held = [name for name, _, _ in scipy.io.whosmat(opened) if not name.startswith("__")]
            names = {name.split("/")[0] for name in wanted}
            tree = scipy.io.loadmat(opened, chars_as_strings=True, variable_names=names)
            found = {name: _find_field(tree, name.split("/")) for name in wanted}
            return held, {name: _matlab_value(node) for name, node in found.items() if node is not None}
    with open_hdf5(path, "a recording") as file:
        check_declared_arrays(file, wanted, str(path))
        held = [str(name) for name in file if not str(name).startswith("#")]
        return held, {name: _hdf5_value(file[name], name, read) for name in wanted if name in file}


def _find_field(node: Any, way: list[str]) -> Any:
    """What lies at a path of structs' fields; None where there is nothing."""
    for field in way:
        if isinstance(node, dict):
            node = node.get(field)
        elif isinstance(node, np.ndarray) and node.dtype.names and field in node.dtype.names and node.size == 1:
            node = node[field].flat[0]
        else:
            return None
    return node


def _matlab_value(node: Any) -> Any:
    if isinstance(node, np.ndarray) and node.dtype.names and node.size == 1:
        return {name: _matlab_value(node[name].flat[0]) for name in node.dtype.names}
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
