"""Whether echoes can be retrieved at all: what cannot is refused in one line, what is not known is left out.

A pulse whose time, azimuth, attitude or place is not known belongs to no cell. Attributes that no radar has, and
gates that are not evenly spaced, would make heights that look right.
"""

from __future__ import annotations

import math
from collections.abc import Callable
from typing import Any

import numpy as np
import xarray as xr

from ...dataset import ECHO_ATTRIBUTES
from ...errors import SchemaError
from ...settings.radar import FARTHEST_M

_EVEN = 1e-3  # of a gate's spacing
_PRF_ERROR = 0.25  # of the interval between pulses, by which they may come too early

# attribute → what its number must be, in words and as a test; all must be finite
_NUMBERS: dict[str, tuple[str, Callable[[float], bool]]] = {
    **dict.fromkeys(
        ("frequency_hz", "pulse_width_s", "bandwidth_hz", "prf_hz", "rotation_rpm", "azimuth_beamwidth_deg"),
        ("be greater than 0", lambda value: value > 0.0),
    ),
    **dict.fromkeys(("noise_power_w", "baseline_m", "complete_turns"), ("be at least 0", lambda value: value >= 0.0)),
    "height_m": ("be finite", math.isfinite),
    "tilt_deg": ("lie within ±90", lambda value: abs(value) < 90.0),
}
_FURTHER_CHOICES = {"waveform": ("pulse", "chirp"), "scan": ("turning", "staring")}
_CHOICES = {
    "polarization": ("VV", "HH"),
    "transmit": ("single", "switched"),
    "interferogram": ("single_pulse", "alternating_pulse"),
}


def checked_echoes(echoes: xr.Dataset) -> xr.Dataset:
    """Echoes whose pulses are all known and in the order of time. Raises SchemaError for those of no use."""
    _check_attributes(echoes.attrs)
    _check_gates(np.asarray(echoes["range"].values, dtype=np.float64))
    senders = np.asarray(echoes["transmitter"].values)
    antennas = echoes.sizes["antenna"]
    if senders.size and not 0 <= senders.min() <= senders.max() < antennas:
        wrong = senders[(senders < 0) | (senders >= antennas)][0]
        raise SchemaError(f"echoes: transmitter = {wrong}: must be 0 … {antennas - 1}, an antenna; correct it")
    known = np.ones(senders.size, dtype=bool)
    for name in ("time", "azimuth", "attitude", "position"):
        finite = np.isfinite(np.asarray(echoes[name].values))
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


def _check_attributes(attrs: dict[Any, Any]) -> None:
    for name, (must, holds) in _NUMBERS.items():
        number = _number(attrs[name])
        if not (math.isfinite(number) and holds(number)):
            raise _refusal(name, attrs[name], must)
    for name, choices in _CHOICES.items():
        if attrs[name] not in choices:
            raise _refusal(name, attrs[name], f"be {' or '.join(choices)}")
    for name, choices in _FURTHER_CHOICES.items():
        if attrs.get(name, choices[0]) not in choices:
            raise SchemaError(f"echoes: {name} = {attrs[name]}: must be {' or '.join(choices)}; correct it")
    sector = [_number(each) for each in np.atleast_1d(attrs["sector_deg"])]
    if (
        len(sector) != 2
        or not all(math.isfinite(each) for each in sector)
        or not 0 < sector[1] - sector[0] <= 360 + 1e-9
    ):
        raise _refusal("sector_deg", attrs["sector_deg"], "be start and stop, clockwise by at most 360")


def _check_gates(gates: np.ndarray) -> None:
    if not gates.size:
        raise SchemaError("echoes: range: holds no gate: must hold one at least; record some")
    if not (np.isfinite(gates).all() and gates[0] > 0.0):
        raise SchemaError(
            f"echoes: range[0] = {gates[0]:g}: ranges must be finite and greater than 0; leave others out"
        )
    if not gates.max() <= FARTHEST_M:
        raise SchemaError(
            f"echoes: range[{int(gates.argmax())}] = {gates.max():g}: must be at most {FARTHEST_M:g} m, as far as any "
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


def _number(value: Any) -> float:
    try:
        return float(value)
    except (TypeError, ValueError):
        return math.nan


def _refusal(name: str, value: Any, must: str) -> SchemaError:
    return SchemaError(f"echoes: {name} = {value}: must {must}; correct it ({ECHO_ATTRIBUTES[name]})")
