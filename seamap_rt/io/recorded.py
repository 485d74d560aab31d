"""A radar's own recording, as it lies in a file: voltages of two receivers, when and whereto each pulse went, a header.

Arrays are found by their names: `lower` and `upper` (pulse, gate), complex or pairs of real numbers (…, 2); `time` [s]
and `azimuth` (pulse,); and, where there are any, `ranges` (gate,), `attitude`, `position`, `transmitter`, `turn` and
`quality`. Sensors slower than the pulses have times of their own, `attitude_time` and `position_time`. Files are .npz
(NumPy), and HDF5 or NetCDF-4 (.h5, .hdf5, .nc); what has other names in them is found by saying which.

The header, a TOML or JSON file or a dict, says what the arrays do not: RecordingHeader. Whatever is wrong becomes an
InputError of one line.
"""

from __future__ import annotations

import difflib
import json
import math
import os
from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Annotated, Any, Literal, Self

import h5py
import numpy as np
from annotated_types import Ge, Gt, Le
from numpy.typing import NDArray
from pydantic import BeforeValidator, model_validator

from ..errors import InputError
from ..settings import Meaning, Section, as_tuple
from .plain_json import plain
from .scenefile import read_toml, validate

Header = Mapping[str, Any] | str | os.PathLike[str]
NEEDED = ("lower", "upper", "time", "azimuth")
ARRAYS = (*NEEDED, "ranges", "attitude", "attitude_time", "position", "position_time", "transmitter", "turn", "quality")
HDF5_ENDINGS = (".h5", ".hdf5", ".nc")
RECORDING_ENDINGS = (".npz", *HDF5_ENDINGS)
MAY_LACK = ("transmitter", "turn", "attitude", "quality")  # where zeros, and nothing else, are usual
_MOST_UNWRITTEN = 1e8  # bytes of an array of which nothing is in the file
_MOST_BYTES = 64e9  # of an array: more than an hour
_PIECES = (("real", "imag"), ("r", "i"), ("re", "im"), ("i", "q"))  # names of a pair's two numbers


class RecordingHeader(Section):
    """What the arrays of a recording do not say.

    Left out, `prf_hz` and `rotation_rpm` follow from the times and azimuths, `noise_power_w` from pulses without
    transmission or the farthest gates, and `sector_deg` is the full circle from where the recording begins.
    `conjugate`: the recorder's time factor is exp(−jωt), its phases grow with distance. `azimuth` is in degrees, or in
    counts of an encoder with `encoder_counts` a turn; it counts from north or from the bow. `range_offset_m` is what
    cables and trigger add to every range. `lever_arm_m` leads from the point whose motion the sensors measure to the
    middle of the antennas: starboard, forward, up. `partial_turns`: of a first and a last turn that are not whole.
    """

    frequency_hz: Annotated[float, Gt(0.0), Le(1e12), Meaning("Carrier frequency.", unit="Hz", reason="a carrier")]
    pulse_width_s: Annotated[
        float,
        Gt(0.0),
        Le(1e-2),
        Meaning("Length of the transmitted pulse.", unit="s", reason="as long as the transmitter is on"),
    ]
    bandwidth_hz: Annotated[
        float,
        Gt(0.0),
        Le(1e11),
        Meaning("Noise bandwidth of the receiver.", unit="Hz", reason="noise bandwidth of the receiver"),
    ]
    height_m: Annotated[
        float,
        Gt(0.0),
        Le(1e4),
        Meaning(
            "Mean height of the antennas over mean sea level.", unit="m", reason="of the antennas' middle over the sea"
        ),
    ]
    baseline_m: Annotated[
        float,
        Gt(0.0),
        Le(100.0),
        Meaning("Distance between the phase centres.", unit="m", reason="distance between the phase centres"),
    ]
    azimuth_beamwidth_deg: Annotated[
        float,
        Gt(0.0),
        Le(180.0),
        Meaning("Beam width in azimuth, one-way at −3 dB.", unit="°", reason="one-way, −3 dB"),
    ]
    elevation_beamwidth_deg: Annotated[
        float,
        Gt(0.0),
        Le(180.0),
        Meaning("Beam width in elevation, one-way at −3 dB.", unit="°", reason="one-way, −3 dB"),
    ]
    first_gate_m: Annotated[
        float | None,
        Ge(-1e6),
        Le(1e6),
        Meaning(
            "Range of the first gate.", unit="m", reason="range of the first gate, c t/2", left_out="the array `ranges`"
        ),
    ] = None
    gate_m: Annotated[
        float | None,
        Gt(0.0),
        Le(1e4),
        Meaning("Spacing of the gates.", unit="m", reason="spacing of the gates", left_out="the array `ranges`"),
    ] = None
    range_offset_m: Annotated[
        float,
        Ge(-1e6),
        Le(1e6),
        Meaning("What cables and trigger add to every range.", unit="m", reason="what is taken off every range"),
    ] = 0.0
    tilt_deg: Annotated[
        float,
        Ge(-60.0),
        Le(60.0),
        Meaning("Tilt of the antennas, top towards the look.", unit="°", reason="top towards the look"),
    ] = 0.0
    lever_arm_m: Annotated[tuple[float, float, float], BeforeValidator(as_tuple)] | None = None
    heading_deg: Annotated[
        float,
        Ge(-360.0),
        Le(360.0),
        Meaning(
            "Heading of the boat, where the recording has no attitude.", unit="°", reason="if no attitude is given"
        ),
    ] = 0.0
    polarization: Literal["VV", "HH"] = "VV"
    transmit: Literal["single", "switched"] = "single"
    interferogram: Literal["single_pulse", "alternating_pulse"] = "single_pulse"
    waveform: Literal["pulse", "chirp"] = "pulse"
    chirp_bandwidth_hz: Annotated[
        float, Ge(0.0), Le(1e11), Meaning("Bandwidth that a chirp sweeps.", unit="Hz", reason="swept by a chirp")
    ] = 0.0
    compression_weighting: Literal["none", "hann", "hamming", "taylor"] = "none"
    prf_hz: Annotated[
        float | None,
        Gt(0.0),
        Le(1e7),
        Meaning("Pulse repetition frequency.", unit="Hz", reason="pulses per second", left_out="by the times"),
    ] = None
    rotation_rpm: Annotated[
        float | None,
        Gt(0.0),
        Le(1e4),
        Meaning(
            "Rotation of the antenna.", unit="1/min", reason="the antenna turns clockwise", left_out="by the azimuths"
        ),
    ] = None
    sector_deg: Annotated[tuple[float, float], BeforeValidator(as_tuple)] | None = None
    noise_power_w: Annotated[
        float | None,
        Ge(0.0),
        Meaning(
            "Noise power of a gate and receiver.",
            unit="W",
            reason="of a gate and receiver",
            left_out="by pulses without transmission or the farthest gates",
        ),
    ] = None
    conjugate: bool = False
    voltage_scale: Annotated[
        float, Gt(0.0), Meaning("√W of one unit of the recording.", unit="√W", reason="√W of one unit of the recording")
    ] = 1.0
    dc_offset: Literal["keep", "remove"] = "keep"
    full_scale: Annotated[
        float | None,
        Gt(0.0),
        Meaning(
            "Full scale of I and Q, in the recording's units.",
            unit="1",
            reason="of I and Q, in the recording's units",
            left_out="no pulse is flagged as saturated",
        ),
    ] = None
    encoder_counts: Annotated[
        int | None,
        Ge(2),
        Meaning(
            "Counts of the encoder in a turn.", unit="1", reason="of a turn", left_out="the azimuths are in degrees"
        ),
    ] = None
    encoder_zero_deg: Annotated[
        float,
        Ge(-360.0),
        Le(360.0),
        Meaning("Azimuth at which the encoder reads 0.", unit="°", reason="where the encoder reads 0"),
    ] = 0.0
    encoder_clockwise: bool = True
    azimuth_from: Literal["north", "bow"] = "north"
    partial_turns: Literal["drop", "keep"] = "drop"

    @model_validator(mode="after")
    def _hangs_together(self) -> Self:
        if (self.first_gate_m is None) != (self.gate_m is None):
            raise ValueError("give first_gate_m and gate_m together, or neither and the array ranges")
        if self.waveform == "chirp" and not self.chirp_bandwidth_hz:
            raise ValueError("chirp_bandwidth_hz = 0: must be greater than 0 with waveform = 'chirp'; give the sweep")
        for name in ("sector_deg", "lever_arm_m"):
            if not all(math.isfinite(each) for each in getattr(self, name) or ()):
                raise ValueError(f"{name} = {list(getattr(self, name))}: must be finite; correct it")
        if self.sector_deg is not None and not 0.0 < self.sector_deg[1] - self.sector_deg[0] <= 360.0:
            raise ValueError(
                f"sector_deg = {list(self.sector_deg)}: must run clockwise by at most 360; give start, stop with "
                "start < stop, as [350, 370]"
            )
        return self


@dataclass(frozen=True)
class Recording:
    """The arrays of a recording by their names in ARRAYS, and its header."""

    arrays: dict[str, NDArray]
    header: RecordingHeader


def read_header(header: Header | RecordingHeader) -> RecordingHeader:
    """A header from a dict, a TOML or a JSON file. Raises InputError."""
    if isinstance(header, RecordingHeader):
        return header
    if isinstance(header, Mapping):
        return validate(RecordingHeader, {str(key): _as_in_toml(value) for key, value in header.items()})
    if not isinstance(header, str | os.PathLike):
        raise InputError(f"header = {header!r}: must be a dict, or the path of a TOML or JSON file; give one of these")
    tree = _json(Path(header)) if Path(header).suffix == ".json" else read_toml(header)
    return _validated(str(header), tree)


def read_recording(
    path: str | os.PathLike[str], header: Header | None = None, names: Mapping[str, str] | None = None
) -> Recording:
    """A recording from a file. names: of arrays in ARRAYS that the file calls otherwise (HDF5: their paths).

    Without `header` it is the text (JSON) or the attributes that the file itself holds under the name `header`, else
    the .toml or .json file of the same name beside it. Raises InputError.
    """
    path, names = Path(path), dict(names or {})
    if unknown := [name for name in names if name not in ARRAYS]:
        raise InputError(f"names: '{unknown[0]}' is no array of a recording; it has {', '.join(ARRAYS)}")
    read = {".npz": _npz, **dict.fromkeys(HDF5_ENDINGS, _hdf5)}.get(path.suffix.lower())
    if read is None:
        raise InputError(f"{path}: must be a file of the kinds .npz, {', '.join(HDF5_ENDINGS)}; save it as one of them")
    try:
        arrays, held = read(path, names)
    except FileNotFoundError:
        raise InputError(f"{path}: no such file; give the path of a recording") from None
    except InputError:
        raise
    except Exception as error:  # NumPy, zip and HDF5 raise exceptions of many types where a file is damaged
        damage = f"{type(error).__name__}: {error}"
        raise InputError(f"{path}: cannot be read ({damage}); give a whole recording") from None
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
    return Recording(arrays, _validated(str(path), held) if header is None else read_header(header))  # type: ignore[arg-type]


def _npz(path: Path, names: Mapping[str, str]) -> tuple[dict[str, NDArray], Mapping[str, Any] | None]:
    with path.open("rb") as opened, np.load(opened, allow_pickle=False) as file:
        _refuse_slips(path, file.files, names)
        arrays = {name: pairs_of(file[inside], inside) for name, inside in _inside(names).items() if inside in file}
        held = str(file["header"]) if "header" in file else None
    return arrays, None if held is None else _object(json.loads(held), f"{path}: header")


def _hdf5(path: Path, names: Mapping[str, str]) -> tuple[dict[str, NDArray], Mapping[str, Any] | None]:
    with h5py.File(path) as file:
        _refuse_slips(path, list(file), names)
        arrays = {
            name: _dataset(_of_three(file[inside], name, inside), inside, name in MAY_LACK)
            for name, inside in _inside(names).items()
            if inside in file
        }
        held: Any = file.get("header")
        if isinstance(held, h5py.Dataset):
            return arrays, _object(json.loads(str(held.asstr()[()])), f"{path}: header")
        return arrays, None if held is None else {key: _as_in_toml(value) for key, value in held.attrs.items()}


def _inside(names: Mapping[str, str]) -> dict[str, str]:
    return {name: names.get(name, name) for name in ARRAYS}


def _of_three(node: Any, name: str, inside: str) -> Any:
    """The same, if its shape is right: a wrong one may be too large to be read first."""
    if name in ("attitude", "position") and isinstance(node, h5py.Dataset) and node.shape[1:] != (3,):
        raise InputError(f"{inside}: has the shape {node.shape}: must be (·, 3); give three numbers for each")
    return node


def _dataset(node: Any, name: str, may_lack: bool) -> NDArray:
    if isinstance(node, h5py.Group):
        pieces = [node[piece] for piece in _pieces(list(node), name)]
        return np.stack(
            [_values(piece, f"{name}{str(piece.name).removeprefix(str(node.name))}", may_lack) for piece in pieces], -1
        )
    return pairs_of(_values(node, name, may_lack), name)


def _values(node: Any, name: str, may_lack: bool) -> NDArray:
    """All of an HDF5 dataset. What was never written HDF5 reads as fill values, zeros mostly."""
    if not isinstance(node, h5py.Dataset) or node.dtype.kind not in "biufcV":
        raise InputError(f"{name}: holds no numbers: must be an array of numbers; save it so")
    if node.nbytes > _MOST_BYTES:
        raise InputError(
            f"{name}: has the shape {node.shape} and takes {node.nbytes / 1e9:.3g} GB: must take at most "
            f"{_MOST_BYTES / 1e9:g}; split the recording"
        )
    stored = node.id.get_num_chunks() if node.chunks else int(node.id.get_storage_size() > 0 or node.is_virtual)
    promised = 1
    if node.chunks:
        promised = math.prod(-(-size // chunk) for size, chunk in zip(node.shape, node.chunks, strict=True))
    if node.size and stored < promised and not may_lack and node.external is None:
        raise InputError(
            f"{name}: holds {stored} of {promised} chunks, and the others would be read as zeros; copy the file whole, "
            "or cut it to what was recorded"
        )
    if not stored and node.nbytes > _MOST_UNWRITTEN:
        raise InputError(f"{name}: has the shape {node.shape} and was never written; leave it out, or write it")
    return node[()]


def pairs_of(values: NDArray, name: str) -> NDArray:
    """Records of two numbers as pairs (…, 2); all else as it is."""
    if values.dtype.names is None:
        return values
    real, imag = _pieces(list(values.dtype.names), name)
    return np.stack([values[real], values[imag]], axis=-1)


def _pieces(held: list[str], name: str) -> tuple[str, str]:
    """What a group or a record calls the real and the imaginary part."""
    result = {key.lower(): key for key in held}
    for real, imag in _PIECES:
        if real in result and imag in result:
            return result[real], result[imag]
    raise InputError(f"{name}: holds {', '.join(held)}: must be complex, or hold real and imag; name them so")


def _refuse_slips(path: Path, held: list[str], names: Mapping[str, str]) -> None:
    """What is nearly named like an array would be left out without a message."""
    meant = set(_inside(names).values())
    for name in held:
        near = difflib.get_close_matches(name, [each for each in meant - set(held) if "/" not in each], 1, 0.8)
        if name not in meant and near:
            raise InputError(f"{path}: '{name}' is no array of a recording; did you mean {near[0]}?")


def _validated(source: str, tree: Mapping[str, Any]) -> RecordingHeader:
    try:
        return validate(RecordingHeader, tree)
    except InputError as error:
        raise InputError(f"{source}: header: {error}") from None


def _json(path: Path) -> Mapping[str, Any]:
    try:
        tree = json.loads(path.read_text(encoding="utf-8"))
    except FileNotFoundError:
        raise InputError(f"{path}: no such file; give the path of a header") from None
    except (OSError, ValueError, RecursionError) as error:
        raise InputError(f"{path}: is not JSON ({error}); mend the header") from None
    return _object(tree, str(path))


def _object(tree: Any, what: str) -> dict[str, Any]:
    if not isinstance(tree, dict):
        raise InputError(f"{what}: is a {type(tree).__name__}: must be an object of keys and values; write it so")
    return tree


def _as_in_toml(value: Any) -> Any:
    """An attribute of a recording, numpy's or bytes, as TOML would give it."""
    return value.decode() if isinstance(value, bytes) else plain(value)
