"""Recorded voltages → echoes that keep the schema: signs, ranges, turns, and where the antennas stood.

    echoes = open_recording("night.h5", "night.toml")
    maps = retrieve(echoes)

What a recorder writes is a pair of complex range-gate arrays in its own conventions. Here they are brought to those of
`conventions`: time factor exp(+jωt), azimuths clockwise from north, antenna 0 the lower one, ranges c t/2 from the
antennas. Whatever is wrong becomes an InputError of one line.
"""

from __future__ import annotations

import os
from collections.abc import Mapping
from typing import Any

import numpy as np
import xarray as xr
from numpy.typing import ArrayLike, NDArray
from scipy.special import gammaincinv

from ..conventions import SPEED_OF_LIGHT, radar_wavelength
from ..dataset import QUALITY_FLAGS, build
from ..errors import InputError
from ..io.recorded import pairs_of, read_recording
from ..io.recording_header import PRF_HZ, Header, RecordingHeader, read_header
from ..physics.shadowing import arrival_error_mrad
from ..settings import RetrievalSettings
from .recorded_sensors import Array, Sensed, array_of, bearing_of, increasing_times, positions_of, readings_of
from .recorded_turns import Turns, turns_of

_EVEN = 1e-3  # of a gate's spacing; ranges that are written to the millimetre are even
_PRF_ERROR = 0.05
_SPARSE = 20.0  # range resolutions between gates, at most: a recorder that keeps every tenth gate still passes
_FAR_SHARE = 0.25  # of the gates, the farthest, which hold least beside noise
_DARKEST = 0.02  # of their stretches
_STRETCH = 16  # pulses


def open_recording(
    path: str | os.PathLike[str], header: Header | None = None, names: Mapping[str, str] | None = None
) -> xr.Dataset:
    """Echoes from a file of recorded voltages (io.recorded.read_recording).

    path: .npz, .mat, .h5, .hdf5 or .nc. header: what the file does not say of the radar, as a mapping or the path of a
    TOML file. names: of the file's arrays, by what they hold, as {"lower": "ch0"}. Raises InputError."""
    recording = read_recording(path, header, names)
    arrays: dict[str, Any] = dict(recording.arrays)
    for name in ("attitude", "position"):
        times = arrays.pop(f"{name}_time", None)
        if times is not None:
            if name not in arrays:
                raise InputError(f"{path}: '{name}_time' stands alone; must go with '{name}'; add it")
            arrays[name] = (times, arrays[name])
    return echoes_from_recording(arrays.pop("lower"), arrays.pop("upper"), recording.header, **arrays)


def echoes_from_recording(
    lower: ArrayLike,
    upper: ArrayLike,
    header: Header | RecordingHeader,
    *,
    time: ArrayLike,
    azimuth: ArrayLike,
    ranges: ArrayLike | None = None,
    attitude: Sensed | None = None,
    position: Sensed | None = None,
    transmitter: ArrayLike | None = None,
    turn: ArrayLike | None = None,
    quality: ArrayLike | None = None,
) -> xr.Dataset:
    """The schema's `echoes` from the voltages of the lower and of the upper receiver.

    lower, upper: (pulse, gate), complex, or pairs (pulse, gate, 2) of I and Q of any real type; NaN where not heard.
    time (pulse,) s, increasing, from any zero, or dates; azimuth (pulse,) of the boresight, deg or an encoder's counts;
    ranges (gate,) m unless the header gives first_gate_m and gate_m. attitude: roll, pitch, heading [deg] as
    (pulse, 3), or (times, readings) of a slower sensor, drawn straight between readings. position: the boat's way from
    its rest, east north up [m], in the same two forms, or the phase centres (pulse, 2, 3) themselves. transmitter
    (pulse,): 0 the lower antenna, 1 the upper, −1 none; turn, quality (pulse,): the number of the turn, the schema's
    flags.

    Echoes' times count from the start of the first turn. Pulses of unknown azimuth and those without transmission are
    left out, as are gates before the antennas. Masked values are missing, as NaN is. Raises InputError for what does
    not fit together.
    """
    head = read_header(header)
    zero = np.asarray(time).ravel()[:1]  # of dates, from which all times count
    time = _seconds_since(zero, time, "time")
    if isinstance(attitude, tuple) and len(attitude) == 2:
        attitude = _seconds_since(zero, attitude[0], "attitude_time"), attitude[1]
    if isinstance(position, tuple) and len(position) == 2:
        position = _seconds_since(zero, position[0], "position_time"), position[1]
    voltage, overdriven = _voltages(lower, upper, head)
    count = voltage.shape[0]
    times = increasing_times(array_of("time", time, (count,)), "time")
    gates = _gates(head, ranges, voltage.shape[2])
    prf = _prf(head, times)
    angles = (
        np.array((0.0, 0.0, head.heading_deg)) if attitude is None else readings_of("attitude", attitude, times, 360.0)
    )
    angles = np.broadcast_to(angles, (count, 3))
    look = bearing_of(array_of("azimuth", azimuth, (count,)), angles, head)
    sender = _senders(transmitter, voltage, head)
    noise = head.noise_power_w
    if noise is None:
        noise = _noise_power(voltage, sender < 0)
    known = np.flatnonzero(np.isfinite(look) & (sender >= 0))
    numbers = None if turn is None else array_of("turn", turn, (count,))[known]
    turns = turns_of(look[known], times[known], head, numbers)
    rows = known[turns.kept]
    values = {
        "voltage": voltage[rows][:, :, gates > 0.0],
        "position": positions_of(position, times, look, angles, head)[rows],
        "attitude": angles[rows],
    }
    if quality is not None:
        values["flag"] = _flags(array_of("quality", quality, (count,)))[rows]
    if overdriven is not None:
        values["saturated"] = overdriven[rows][:, gates > 0.0]
    since = times[rows] - turns.start
    return build(
        "echoes",
        values,
        {
            "pulse": _pulse_numbers(since, prf),
            "range": gates[gates > 0.0],
            "time": since,
            "azimuth": look[rows],
            "transmitter": sender[rows],
            "turn": turns.number,
        },
        _attributes(head, turns, prf, noise) | _sensors(head, attitude) | _date(zero, turns.start),
    )


def _seconds_since(zero: NDArray, times: ArrayLike, name: str) -> ArrayLike:
    """Times in s: of dates, since the first pulse's `zero`; durations; and numbers as they are."""
    kind = np.asarray(times).dtype.kind
    if (kind == "M") != (zero.dtype.kind == "M"):
        raise InputError(f"{name}: holds {'dates' if kind == 'M' else 'no dates'}, unlike time; give all on one clock")
    if kind not in "mM":
        return times
    step = np.asarray(times) - zero if kind == "M" else np.asarray(times)
    return step / np.timedelta64(1, "ns") * 1e-9


def _sensors(head: RecordingHeader, attitude: Sensed | None) -> dict[str, float]:
    """Attributes of the motion sensors by the header; readings with times of their own give their rate."""
    attributes = head.sensors.attributes if head.sensors.model_fields_set else {}
    if attributes and isinstance(attitude, tuple) and np.size(attitude[0]) > 1:
        attributes.setdefault("sensors_rate_hz", 1.0 / float(np.median(np.diff(np.asarray(attitude[0])))))
    return attributes


def _date(zero: NDArray, start: float) -> dict[str, str]:
    """The date of the echoes' time 0, where the recording has dates."""
    if zero.dtype.kind != "M":
        return {}
    return {"time_zero": str(zero[0].astype("datetime64[ns]") + np.timedelta64(round(1e9 * start), "ns"))}


def _flags(quality: Array) -> NDArray[np.int16]:
    """The schema's flags (pulse,); whole numbers that its bits can hold."""
    most = sum(QUALITY_FLAGS.values())
    wrong = ~(np.isfinite(quality) & (quality >= 0) & (quality <= most) & (quality == np.round(quality)))
    if wrong.any():
        raise InputError(
            f"quality = {quality[wrong][0]:g}: must be a whole number 0 … {most}, sum of flags; correct it"
        )
    return quality.astype(np.int16)


def _attributes(head: RecordingHeader, turns: Turns, prf: float, noise: float) -> dict[str, Any]:
    same = (
        "frequency_hz", "pulse_width_s", "bandwidth_hz", "height_m", "baseline_m", "tilt_deg", "azimuth_beamwidth_deg",
        "elevation_beamwidth_deg", "polarization", "transmit", "interferogram", "waveform", "chirp_bandwidth_hz",
        "compression_weighting", "transmitter", "transmit_phase_error_deg",
    )  # fmt: skip
    bent = arrival_error_mrad(head.polarization, radar_wavelength(head.frequency_hz))
    return {
        **{name: getattr(head, name) for name in same},
        "retrieval": RetrievalSettings(diffraction_mrad=bent).carried,
        "coherent_on_receive": int(head.coherent_on_receive),
        "prf_hz": prf,
        "rotation_rpm": turns.rate / 6.0,
        "sector_deg": list(turns.sector),
        "noise_power_w": noise,
        "complete_turns": int(turns.number[-1]) + 1,
        "scan": "turning",
        "receiver_antennas": [0, 1],
        "time_zero_s": turns.start,  # of the recording's own clock
    }


def _pulse_numbers(time: Array, prf: float) -> NDArray[np.int64]:
    """(pulse,) with gaps where pulses are missing."""
    number = np.asarray(np.rint(time * prf), dtype=np.int64)
    return number if (np.diff(number) > 0).all() else np.arange(time.size)


# ------------------------------------------------------------------------------------------------- voltages


def _voltages(
    lower: ArrayLike, upper: ArrayLike, head: RecordingHeader
) -> tuple[NDArray[np.complex64], NDArray[np.bool_] | None]:
    """Voltages (pulse, 2, gate) [√W], NaN where not finite or not sampled; where a converter was at its limit."""
    pairs = [_pairs(name, np.ma.getdata(each)) for name, each in (("lower", lower), ("upper", upper))]
    shapes = [pair[0].shape for pair in pairs]
    missing = [_missing(each, shape) for each, shape in zip((lower, upper), shapes, strict=True)]
    if shapes[0] != shapes[1]:
        raise InputError(
            f"upper: has the shape {shapes[1]}: must be that of lower, {shapes[0]}; give them pulse by pulse"
        )
    if 0 in shapes[0]:
        raise InputError(
            f"lower: has the shape {shapes[0]}: must hold a pulse and a gate at least; give a longer record"
        )
    voltage = np.empty((shapes[0][0], 2, shapes[0][1]), dtype=np.complex64)
    with np.errstate(over="ignore", invalid="ignore"):
        for receiver, (real, imag) in enumerate(pairs):
            voltage[:, receiver].real, voltage[:, receiver].imag = real, imag
            if (gone := missing[receiver]) is not None:
                voltage[:, receiver][gone] = np.nan
        if head.interferogram == "alternating_pulse":  # converters that wait write zeros
            voltage[~voltage.any(axis=2)] = np.nan
        if head.dc_offset == "remove":
            far = voltage[:, :, -max(1, round(_FAR_SHARE * voltage.shape[2])) :]
            known = np.isfinite(far)
            total = np.where(known, far, 0.0).sum(axis=(0, 2), dtype=np.complex128)
            voltage -= (total / np.maximum(known.sum(axis=(0, 2)), 1))[:, None].astype(np.complex64)
        voltage *= np.float32(head.voltage_scale)
    if head.conjugate:
        np.conjugate(voltage, out=voltage)
    if head.phase_offset_deg:
        voltage[:, 1] *= np.complex64(np.exp(1j * np.radians(head.phase_offset_deg)))
    voltage[~np.isfinite(voltage)] = np.nan
    limits = [_full_scale(real, head) for real, _ in pairs]
    if limits[0] is None or limits[1] is None:
        return voltage, None
    over = [
        (np.abs(each.astype(np.float64)) >= limit) & (True if gone is None else ~gone)
        for pair, limit, gone in zip(pairs, limits, missing, strict=True)
        for each in pair
    ]
    overdriven = np.logical_or.reduce(over)
    return voltage, overdriven if overdriven.any() else None


def _missing(values: ArrayLike, shape: tuple[int, ...]) -> NDArray[np.bool_] | None:
    """Where (pulse, gate) a masked array lacks a number of a pair."""
    if not np.ma.is_masked(values):
        return None
    mask = np.ma.getmaskarray(values)  # type: ignore[arg-type]
    mask = np.logical_or.reduce([mask[name] for name in mask.dtype.names]) if mask.dtype.names else mask
    return mask.reshape(*shape, -1).any(axis=-1)


def _pairs(name: str, values: NDArray) -> tuple[NDArray, NDArray]:
    """I and Q (pulse, gate) of complex numbers, or of pairs or records of two numbers."""
    values = pairs_of(values, name)
    if np.iscomplexobj(values) and values.ndim == 2:
        return np.real(values), np.imag(values)
    if values.dtype.kind in "iuf" and values.ndim == 3 and values.shape[2] == 2:
        return values[..., 0], values[..., 1]
    raise InputError(
        f"{name}: has the shape {values.shape} and the type {values.dtype}: must be complex (pulse, gate) or pairs of "
        "I and Q (pulse, gate, 2); give it so"
    )


def _full_scale(part: NDArray, head: RecordingHeader) -> float | None:
    if head.full_scale is not None:
        return head.full_scale
    return float(np.iinfo(part.dtype).max) if part.dtype.kind in "iu" else None


def _noise_power(voltage: NDArray[np.complex64], silent: NDArray[np.bool_]) -> float:
    """W, of a gate: from pulses without transmission, else from the darkest stretches of the farthest gates.

    Far out much of the sea lies in shadow. The mean of n pulses of noise alone is a gamma variable of shape n, whose
    quantile gives its mean; where the sea echoes everywhere, that mean is too high.
    """
    far = slice(-max(1, round(_FAR_SHARE * voltage.shape[2])), None)
    heard = voltage[silent] if silent.any() else voltage[:, :, far]
    power = heard.real.astype(np.float64) ** 2 + heard.imag.astype(np.float64) ** 2
    if silent.any():
        return float(np.nanmean(power)) if np.isfinite(power).any() else 0.0
    means = []
    for receiver in np.swapaxes(power, 0, 1):
        sampled = receiver[np.isfinite(receiver).all(axis=1)]
        count = min(_STRETCH, sampled.shape[0])
        if count:
            stretches = sampled[: sampled.shape[0] // count * count].reshape(-1, count, sampled.shape[1]).mean(axis=1)
            means.append(np.quantile(stretches, _DARKEST) * count / gammaincinv(count, _DARKEST))
    return float(np.mean(means)) if means else 0.0


def _senders(transmitter: ArrayLike | None, voltage: NDArray[np.complex64], head: RecordingHeader) -> NDArray[np.int8]:
    """(pulse,) the antenna that transmits, −1 none."""
    if transmitter is not None:
        sender = array_of("transmitter", transmitter, (voltage.shape[0],))
        if not np.isin(sender, (-1, 0, 1)).all():
            bad = sender[~np.isin(sender, (-1, 0, 1))][0]
            raise InputError(f"transmitter = {bad:g}: must be 0 (lower), 1 (upper) or -1 (none); correct it")
        return np.asarray(sender, dtype=np.int8)
    if head.transmit == "single":
        return np.zeros(voltage.shape[0], dtype=np.int8)
    if head.interferogram == "alternating_pulse":  # each antenna receives its own pulses
        return np.asarray(np.isfinite(voltage[:, 1]).any(axis=1), dtype=np.int8)
    raise InputError("transmitter: is missing: must tell each pulse's antenna with transmit = 'switched'; add it")


# ------------------------------------------------------------------------------------- time, range and direction


def _gates(head: RecordingHeader, ranges: ArrayLike | None, count: int) -> Array:
    """Ranges (gate,) m from the antennas."""
    if ranges is not None:
        gates = increasing_times(array_of("ranges", ranges, (count,)), "ranges")
        even = np.linspace(gates[0], gates[-1], count)
        off = np.abs(gates - even).max()
        if count > 1 and off > _EVEN * (even[1] - even[0]):
            worst = int(np.argmax(np.abs(gates - even)))
            raise InputError(
                f"ranges[{worst}] = {gates[worst]:.10g}: must be {even[worst]:.10g}, as gates are equally spaced; "
                "resample the voltages"
            )
        gates = even
    elif head.first_gate_m is not None and head.gate_m is not None:
        gates = head.first_gate_m + head.gate_m * np.arange(count)
    else:
        raise InputError("ranges: are missing: must be given, or first_gate_m and gate_m in the header; add them")
    gates = np.asarray(gates - head.range_offset_m, dtype=np.float64)
    if gates[-1] > 0.0 and gates[-1] <= head.height_m:
        raise InputError(
            f"ranges: end at {gates[-1]:.4g} m: must go beyond height_m = {head.height_m:g}, for the sea is no nearer; "
            "give metres, or say their units in the file"
        )
    resolution = 0.5 * SPEED_OF_LIGHT * max(1.0 / head.bandwidth_hz, _compressed_s(head))
    if count > 1 and (spacing := float(gates[1] - gates[0])) > _SPARSE * resolution:
        raise InputError(
            f"ranges: gates are {spacing:.4g} m apart, and resolve {resolution:.3g} m: must be at most {_SPARSE:g} "
            "times that; give metres, or correct bandwidth_hz and pulse_width_s"
        )
    if not (gates > 0.0).any():
        raise InputError(
            f"range_offset_m = {head.range_offset_m:g}: leaves the last gate at {gates[-1]:g} m: must leave gates "
            "beyond the antennas; correct it or the ranges"
        )
    return gates


def _compressed_s(head: RecordingHeader) -> float:
    """Length of a pulse, s, of a chirp when it is compressed."""
    return 1.0 / head.chirp_bandwidth_hz if head.waveform == "chirp" else head.pulse_width_s


def _prf(head: RecordingHeader, time: Array) -> float:
    if time.size < 2:
        if head.prf_hz is None:
            raise InputError("prf_hz: is missing: must be given with a single pulse; add it to the header")
        return head.prf_hz
    heights = 1.0 / float(np.median(np.diff(time)))
    least, most = PRF_HZ
    if not least <= heights <= most:
        raise InputError(
            f"time: pulses are {1.0 / heights:.4g} s apart, a PRF of {heights:.4g} Hz: must be {least:g} to {most:g}; "
            "give times in seconds, or say their units in the file"
        )
    if head.prf_hz is not None and abs(heights / head.prf_hz - 1.0) > _PRF_ERROR:
        raise InputError(
            f"prf_hz = {head.prf_hz:g}: must agree with the times, of which most are 1/{heights:.6g} s apart; correct "
            "either, or leave prf_hz out"
        )
    return heights if head.prf_hz is None else head.prf_hz


# ----------------------------------------------------------------------------------------------------- sensors


# ------------------------------------------------------------------------------------------------------ shapes


__all__ = ["echoes_from_recording", "open_recording"]
