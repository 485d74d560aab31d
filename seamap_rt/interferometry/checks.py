"""Whether echoes can be retrieved at all: what cannot is refused in one line, what is not known is left out.

A pulse whose time, azimuth, attitude or place is not known belongs to no cell. Attributes that no radar has, and
gates that are not evenly spaced, would make heights that look right.

Echoes from a Zarr store: whole turns, or refused in one line.
"""

from __future__ import annotations

import json
import math
import warnings
from collections.abc import Callable, Mapping
from pathlib import Path
from typing import Any

import numpy as np
import xarray as xr
import zarr

from ..conventions import turn_name
from ..dataset import ECHO_ATTRIBUTES, FURTHER_ECHO_ATTRIBUTES, check
from ..errors import InputError, SchemaError, must_be
from ..io.growing_store import EVERY_CHUNK, ORDER, check_chunks
from ..io.opening import bytes_held, check_declared_size, check_store
from ..io.process import filter_asyncio_log
from ..io.results_folder import RUN
from ..io.text import plain_attribute, rounded_up
from ..io.validation import validate
from ..radar.grid import BYTES_PER_VOLTAGE, MOST_ECHO_BYTES, MOST_GROUND_CELLS, ground_cells, least_ground_side
from ..radar.receiver import comparing_pulses
from ..settings import RetrievalSettings
from ..settings.radar import FARTHEST_M
from .description import RadarDescription

_BULK = ("voltage", "saturated")  # read turn by turn, all else at once
_MAY_LACK = ("transmitter", "turn", "attitude", "flag", "saturated")  # where zeros, and nothing else, are usual
_INDEXES = ("pulse", "range", "receiver", "antenna", "xyz")
_GROUP = "echoes"  # of a run's store
_UNFINISHED = "complete_pulses"  # attribute of an echoes.zarr that an earlier version writes, or has left
_MOST_PULSES = 1e9  # a day at 10 kHz


def open_echoes(path: str | Path) -> xr.Dataset:
    """Echoes from a Zarr store, complete turns only, also while it grows.

    path: of the store, of a run's `run.zarr`, whose group `echoes` alone is opened, or of the folder of either.
    Raises SchemaError for a store that does not keep the schema, InputError for what is no store, or lacks a chunk.
    """
    try:
        with warnings.catch_warnings():
            warnings.simplefilter("ignore")  # of what else lies in the folder: what matters is checked after
            store, group = store_of_echoes(Path(path))
            _require_group(store, group)
            check_store(store, "a store of echoes", named=f"ECHOES = '{path}'", group=group)
            dataset = _opened(store, group)
            dataset = dataset.set_coords([n for n in ("time", "azimuth", "transmitter", "turn") if n in dataset])
            return _whole_turns(dataset, store / group)
    except (InputError, SchemaError):
        raise
    except Exception as error:  # a damaged store raises exceptions of many types
        what = f"{type(error).__name__}: {error}"
        filter_asyncio_log()
    raise InputError(f"ECHOES = '{path}': is not an echo store, or damaged ({what}); give a whole run.zarr")


def store_of_echoes(path: Path) -> tuple[Path, str]:
    """The store that is meant by its path, or its folder's; and its group of echoes, "" where they are all of it."""
    if path.name in ("", _GROUP):  # given from within the store
        path = path.absolute()
    if path.name == _GROUP and path.parent.name == RUN:
        return path.parent, _GROUP
    for name in (RUN, "echoes.zarr"):
        path = path / name if (path / name).is_dir() else path
    return (path, _GROUP) if (path / _GROUP).is_dir() else (path, "")


def _require_group(store: Path, group: str) -> None:
    """Raise InputError for a run's store without its echoes."""
    if not group and store.name == RUN and store.is_dir() and not (store / "voltage").is_dir():
        raise InputError(f"ECHOES = '{store}': has no group {_GROUP}; wait for the run's first turn, or copy it whole")


def _opened(store: Path, group: str) -> xr.Dataset:
    """As long as a run's store says that it is whole."""
    lengths = dict[str, int]()
    if group:
        root: Any = zarr.open_group(store, mode="r", zarr_format=3, use_consolidated=True)
        lengths["pulse"] = root[group]["turn"].shape[0]
    check_chunks(store / group, lengths, _MAY_LACK, [*_INDEXES, "turn"])  # what xarray reads at once
    return xr.open_zarr(store, group=group or None, consolidated=bool(group), zarr_format=3)


def read_turn(echoes: xr.Dataset) -> xr.Dataset:
    """Echoes with their voltages in memory. Raises SchemaError where the file that holds them is damaged."""
    check_declared_size("echoes", echoes.nbytes)
    try:
        return echoes.load()
    except Exception as error:
        what = f"{type(error).__name__}: {error}"
        filter_asyncio_log()
    raise SchemaError(f"echoes: cannot be read ({what}); give whole files")


def _whole_turns(dataset: xr.Dataset, path: Path) -> xr.Dataset:
    check("echoes", dataset)
    check_attributes(dataset.attrs)
    if dataset.sizes["pulse"] > _MOST_PULSES:
        raise SchemaError(
            f"echoes: hold {dataset.sizes['pulse']:.3g} pulses: must be at most {_MOST_PULSES:.3g}; split the record"
        )
    if _UNFINISHED in dataset.attrs:
        raise InputError(f"ECHOES = '{path}': an earlier version left it unfinished, and recovers it")
    whole = int(np.count_nonzero(dataset["turn"].values < float(dataset.attrs["complete_turns"])))
    check_chunks(path, {"pulse": whole}, _MAY_LACK)
    dataset = dataset.isel(pulse=slice(0, whole))
    once = [name for name in dataset.variables if name not in _BULK]
    check_declared_size(f"ECHOES = '{path}'", sum(dataset[name].nbytes for name in once), bytes_held(path))
    for name in once:
        dataset[name].load()
    for name in (EVERY_CHUNK, ORDER):  # of the store: who writes these echoes elsewhere may leave chunks out
        dataset.attrs.pop(name, None)
    return dataset


_EVEN = 1e-3  # of a gate's spacing
_PRF_ERROR = 0.25  # of the interval between pulses, by which they may come too early
_MOST_POLAR_CELLS = 1e7  # of a turn; a map takes about as much memory for one as for one of the ground


def _positive(most: float) -> tuple[str, Callable[[float], bool]]:
    return f"be greater than 0 and at most {most:g}", lambda value: 0.0 < value <= most


_NOT_NEGATIVE = ("be at least 0", lambda value: value >= 0.0)
# attribute → what its number must be, in words and as a test; all must be finite
_NUMBERS: dict[str, tuple[str, Callable[[float], bool]]] = {
    "frequency_hz": _positive(1e12),
    "pulse_width_s": _positive(1e-2),
    "bandwidth_hz": _positive(1e11),
    "prf_hz": _positive(1e7),
    "rotation_rpm": _positive(1e4),
    "azimuth_beamwidth_deg": ("be greater than 0", lambda value: value > 0.0),
    **dict.fromkeys(("noise_power_w", "complete_turns"), _NOT_NEGATIVE),
    **{name: _NOT_NEGATIVE for name in FURTHER_ECHO_ATTRIBUTES if name.startswith("sensors_")},
    "sensors_rate_hz": _positive(1e9),
    "baseline_m": ("be 0 to 100", lambda value: 0.0 <= value <= 100.0),
    "height_m": ("lie within ±10000", lambda value: abs(value) <= 1e4),
    "tilt_deg": ("lie within ±90", lambda value: abs(value) < 90.0),
    "chirp_bandwidth_hz": ("be 0 to 1e+11", lambda value: 0.0 <= value <= 1e11),
    "stare_s": _positive(1e3),
    "coherent_on_receive": ("be 0 or 1", lambda value: value in (0.0, 1.0)),
    "transmit_phase_error_deg": ("be 0 to 180", lambda value: 0.0 <= value <= 180.0),
}
_CHOICES = {
    "polarization": ("VV", "HH"),
    "transmit": ("single", "switched"),
    "interferogram": ("single_pulse", "alternating_pulse"),
    "waveform": ("pulse", "chirp"),
    "scan": ("turning", "staring"),
    "compression_weighting": ("none", "hann", "hamming", "taylor"),
    "transmitter": ("coherent", "magnetron"),
}
_WITHIN = {"time": 1e12, "azimuth": 1e6, "attitude": 1e6, "position": 1e8}  # s, deg, deg, m: larger ones are damage


def checked_echoes(echoes: xr.Dataset) -> xr.Dataset:
    """Echoes whose pulses are all known and in the order of time. Raises SchemaError for those of no use."""
    echoes = echoes.assign_attrs({name: plain_attribute(value) for name, value in echoes.attrs.items()})
    check_attributes(echoes.attrs)
    _check_gates(np.asarray(echoes["range"].values, dtype=np.float64))
    senders = np.asarray(echoes["transmitter"].values)
    antennas = echoes.sizes["antenna"]
    if senders.size and not 0 <= senders.min() <= senders.max() < antennas:
        wrong = senders[(senders < 0) | (senders >= antennas)][0]
        raise SchemaError(f"echoes: transmitter = {wrong}: must be 0 … {antennas - 1}, an antenna; correct it")
    known = np.ones(senders.size, dtype=bool)
    for name, most in _WITHIN.items():
        values = np.asarray(echoes[name].values)
        finite = np.isfinite(values)
        if (beyond := finite & (np.abs(values) > most)).any():
            raise SchemaError(f"echoes: {name} = {values[beyond][0]:g}: must lie within ±{most:g}; correct it")
        known &= finite.all(axis=tuple(range(1, finite.ndim)))
    if senders.size and not known.any():
        raise SchemaError("echoes: time, azimuth, attitude, position: must all be known of some pulse; correct them")
    time = np.asarray(echoes["time"].values)
    rows = np.flatnonzero(known)
    rows = rows[np.argsort(time[rows], kind="stable")]
    turn = np.asarray(echoes["turn"].values)[rows]
    if (np.diff(turn) < 0).any():
        raise SchemaError("echoes: turn: must not decrease as time goes on; number turns in the order of their times")
    _check_interval(time[rows], float(echoes.attrs["prf_hz"]))
    return echoes if np.array_equal(rows, np.arange(senders.size)) else echoes.isel(pulse=rows)


def check_maps(echoes: xr.Dataset, settings: RetrievalSettings) -> None:
    """Raise SchemaError for a turn of echoes, or maps of it, that no memory holds. echoes: of one turn."""
    gates = echoes["range"].values
    pulses, receivers = echoes.sizes["pulse"], echoes.sizes["receiver"]
    needed = BYTES_PER_VOLTAGE * pulses * receivers * gates.size
    if needed > 1.01 * MOST_ECHO_BYTES:  # a turn may hold a pulse more than the mean, which limits a scene
        raise SchemaError(
            f"echoes: {turn_name(echoes['turn'].values[0])} holds {pulses:.3g} pulses of {gates.size} gates and takes "
            f"{needed / 1e9:.3g} GB, and may take {MOST_ECHO_BYTES / 1e9:.3g}; leave out gates or pulses"
        )
    far, side = float(gates[-1]), settings.ground_m
    cells = ground_cells(far, side)
    if cells > MOST_GROUND_CELLS:
        raise SchemaError(
            f"retrieval.ground_m = {side:.10g}: must be at least {rounded_up(least_ground_side(far))} (the ground map "
            f"of the echoes' gates, to {far:.4g} m, would have {cells:.3g} cells, and may have "
            f"{MOST_GROUND_CELLS:.3g}); raise retrieval.ground_m, or correct the gates' ranges"
        )
    start, stop = np.ravel(echoes.attrs["sector_deg"])
    cells = gates.size * max(1.0, (stop - start) / settings.cell_azimuth_deg)
    if cells > _MOST_POLAR_CELLS and echoes.attrs.get("scan", "turning") == "turning":
        least = (stop - start) * gates.size / _MOST_POLAR_CELLS
        raise SchemaError(
            f"retrieval.cell_azimuth_deg = {settings.cell_azimuth_deg:.10g}: must be at least {rounded_up(least)} (the "
            f"polar map would have {cells:.3g} cells, and may have {_MOST_POLAR_CELLS:.3g}); raise "
            "retrieval.cell_azimuth_deg"
        )


def check_pulses_compare(radar: RadarDescription, settings: RetrievalSettings) -> None:
    """Raise SchemaError for what would compare pulses that each start with a phase of their own, which nobody knows."""
    asked = comparing_pulses(radar.interferogram, settings)
    if radar.coherent or asked is None:
        return
    key, why, instead = asked
    raise SchemaError(
        f"echoes: {key}: cannot be with transmitter = 'magnetron', which starts each pulse with a random phase "
        f"({why}); {instead}, or set coherent_on_receive if that phase has been taken off"
    )


def check_attributes(attrs: dict[Any, Any]) -> None:
    """Raise SchemaError unless the attributes of echoes, all of which are there, describe a radar."""
    for name, (must, holds) in _NUMBERS.items():
        value = _given(attrs, name)
        number = _number(value)
        if not (math.isfinite(number) and holds(number)):
            raise _refusal(name, value, must)
    for name, choices in _CHOICES.items():
        if not any(np.array_equal(_given(attrs, name), choice) for choice in choices):
            raise _refusal(name, _given(attrs, name), f"be {' or '.join(choices)}")
    if attrs.get("waveform") == "chirp" and not _number(_given(attrs, "chirp_bandwidth_hz")) > 0.0:
        raise _refusal("chirp_bandwidth_hz", _given(attrs, "chirp_bandwidth_hz"), "be greater than 0 of a chirp")
    receivers = np.atleast_1d(np.asarray(_given(attrs, "receiver_antennas")))
    if receivers.dtype.kind not in "iu" or receivers.ndim != 1 or (receivers < 0).any():
        raise _refusal("receiver_antennas", attrs["receiver_antennas"], "be whole numbers, 0 or more")
    sector = [_number(each) for each in np.ravel(attrs["sector_deg"])]
    if (
        len(sector) != 2
        or not all(math.isfinite(each) for each in sector)
        or max(map(abs, sector)) > 1e4
        or not 0 < sector[1] - sector[0] <= 360 + 1e-9
    ):
        raise _refusal("sector_deg", attrs["sector_deg"], "be start and stop, clockwise by at most 360")


def settings_of(echoes: xr.Dataset, changes: RetrievalSettings | Mapping[str, Any] | None = None) -> RetrievalSettings:
    """What these echoes are retrieved by: settings as given, or what the echoes carry, the keys of `changes` replaced.

    Raises SchemaError for carried ones that cannot be read, InputError for keys that cannot be.
    """
    if isinstance(changes, RetrievalSettings):
        return changes
    must_be("settings", changes, (Mapping, type(None)), "RetrievalSettings, as scene.retrieval, or a dict of its keys")
    try:
        carried = json.loads(_given(echoes.attrs, "retrieval"))
        validate(RetrievalSettings, carried)
    except (TypeError, ValueError) as error:
        why = f"holds no settings of this version ({error}); give all settings, or remove it"
        raise SchemaError(f"echoes: attribute 'retrieval': {why}") from None
    return validate(RetrievalSettings, carried | dict(changes or {}))


def _check_gates(gates: np.ndarray) -> None:
    if not gates.size:
        raise SchemaError("echoes: range: holds no gate: must hold one at least; record some")
    if not (np.isfinite(gates).all() and gates[0] > 0.0):
        raise SchemaError(
            f"echoes: range[0] = {gates[0]:g}: ranges must be finite and greater than 0; leave others out"
        )
    if gates.max() > FARTHEST_M:
        raise SchemaError(
            f"echoes: range[{np.argmax(gates)}] = {gates.max():g}: must be at most {FARTHEST_M:g} m, as far as any "
            "mast sees the sea; leave farther gates out, or correct their unit"
        )
    even = np.linspace(gates[0], gates[-1], gates.size)
    if gates.size > 1 and not (even[1] > even[0] and np.abs(gates - even).max() <= _EVEN * (even[1] - even[0])):
        worst = int(np.argmax(np.abs(gates - even)))
        raise SchemaError(
            f"echoes: range[{worst}] = {gates[worst]:g}: ranges must increase in equal steps; sort or resample them"
        )


def _check_interval(time: np.ndarray, prf: float) -> None:
    steps = np.diff(time)
    steps = steps[steps > 0.0]
    if steps.size and np.median(steps) < (1.0 - _PRF_ERROR) / prf:
        raise SchemaError(
            f"echoes: prf_hz = {prf:g}: must agree with the times, of which most are {np.median(steps):.4g} s apart; "
            "correct either"
        )


def _given(attrs: dict[Any, Any], name: str) -> Any:
    """An attribute, or what it is where it may be left out."""
    return attrs[name] if name in ECHO_ATTRIBUTES else attrs.get(name, FURTHER_ECHO_ATTRIBUTES[name][0])


def _number(value: Any) -> float:
    try:
        return float(value)
    except (TypeError, ValueError, OverflowError):
        return math.nan


def _refusal(name: str, value: Any, must: str) -> SchemaError:
    meaning = ECHO_ATTRIBUTES.get(name) or FURTHER_ECHO_ATTRIBUTES[name][1]
    return SchemaError(f"echoes: {name} = {value}: must {must}; correct it ({meaning})")
