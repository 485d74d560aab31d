"""The sensors' columns of a recording: bearing, attitude and position of each pulse."""

from __future__ import annotations

import numpy as np
from numpy.typing import ArrayLike, NDArray

from ..errors import InputError
from ..io.recording_header import RecordingHeader
from ..radar.pose import antenna_axes, bearing, boat_axes, scan_of_bearing

Array = NDArray[np.float64]
Sensed = ArrayLike | tuple[ArrayLike, ArrayLike]  # (pulse, 3), or times (n,) s and readings (n, 3)


def bearing_of(azimuth: Array, attitude: Array, head: RecordingHeader) -> Array:
    """Bearing (pulse,) of the boresight, deg clockwise from north in 0 … 360; NaN where it is not known."""
    angle = azimuth if head.encoder_counts is None else azimuth * (360.0 / head.encoder_counts)
    angle = head.encoder_zero_deg + (angle if head.encoder_clockwise else -angle)
    angle = np.where(np.isfinite(angle), angle, np.nan)
    if head.azimuth_from == "bow":
        return bearing(antenna_axes(attitude, angle, head.tilt_deg))
    return angle % 360.0


def readings_of(name: str, value: Sensed, time: Array, whole: float | None = None) -> Array:
    """Readings (pulse, 3) at the pulses' times, NaN beside and before and after what was read. whole: of an angle."""
    if not isinstance(value, tuple):
        return array_of(name, value, (time.size, 3))
    if len(value) != 2:
        raise InputError(f"{name}: has {len(value)} parts: must be (pulse, 3), or (times, readings); give it so")
    moments = np.asarray(value[0], dtype=np.float64)
    moments = increasing_times(array_of(f"{name}_time", moments, (moments.size,)), f"{name}_time")
    readings = array_of(name, value[1], (moments.size, 3))
    read = np.isfinite(readings).all(axis=1)
    if not read.any() or time[0] > moments[-1] or time[-1] < moments[0]:
        raise InputError(
            f"{name}_time: runs from {moments[0]:.10g} to {moments[-1]:.10g} s: must hold the pulses' times, "
            f"{time[0]:.10g} to {time[-1]:.10g} s, on the same clock; shift it"
        )
    columns = []
    for column in readings.T:
        column = column.copy()
        if whole is not None:
            column[read] = np.unwrap(column[read], period=whole)
        column[~read] = np.nan
        columns.append(np.interp(time, moments, column, left=np.nan, right=np.nan))
    return np.stack(columns, axis=1)


def positions_of(position: Sensed | None, time: Array, look: Array, attitude: Array, head: RecordingHeader) -> Array:
    """Phase centres (pulse, 2, 3), lower and upper, east north up [m] from below the antennas' first position."""
    if position is not None and not isinstance(position, tuple) and np.ndim(position) == 3:
        return array_of("position", position, (time.size, 2, 3))
    boat = np.zeros((1, 3)) if position is None else readings_of("position", position, time)
    known = np.isfinite(boat).all(axis=1)
    if known.any():  # maps count from the first known position, not from a UTM origin
        boat = boat - boat[known][0] * (1.0, 1.0, 0.0)
    lever = np.array((0.0, 0.0, head.height_m) if head.lever_arm_m is None else head.lever_arm_m)
    standing = np.isfinite(attitude).all(axis=1)
    heading = attitude[standing][0, 2] if standing.any() else 0.0
    rest = lever @ boat_axes((0.0, 0.0, heading)) - (0.0, 0.0, head.height_m)
    axes = antenna_axes(attitude, scan_of_bearing(attitude, look, head.tilt_deg), head.tilt_deg)
    offsets = 0.5 * head.baseline_m * np.array([[0.0, 0.0, -1.0], [0.0, 0.0, 1.0]])
    return (boat + lever @ boat_axes(attitude) - rest)[:, None] + offsets @ axes


def array_of(name: str, values: ArrayLike, shape: tuple[int, ...]) -> Array:
    given = np.asarray(values)
    if np.ma.is_masked(values) and given.dtype.kind in "biuf":
        given = np.ma.filled(np.ma.asarray(values, dtype=np.float64), np.nan)
    if given.dtype.kind in "mM":
        raise InputError(f"{name}: holds dates: must be plain numbers, times in seconds; convert it")
    if given.dtype.kind == "c":
        raise InputError(f"{name}: holds complex numbers: must be real ones; correct it")
    if given.shape != shape:
        raise InputError(f"{name}: has the shape {given.shape}: must be {shape}; give one for each")
    try:
        return given.astype(np.float64)
    except (TypeError, ValueError):
        raise InputError(f"{name}: holds what is no number: must be an array of numbers {shape}; correct it") from None


def increasing_times(values: Array, name: str) -> Array:
    if not np.isfinite(values).all():
        worst = int(np.flatnonzero(~np.isfinite(values))[0])
        raise InputError(f"{name}[{worst}] = {values[worst]}: must be finite; correct it or leave it out")
    back = np.flatnonzero(np.diff(values) <= 0.0)
    if back.size:
        here = int(back[0]) + 1
        raise InputError(
            f"{name}[{here}] = {values[here]:.10g}: must be greater than the one before, {values[here - 1]:.10g}; sort "
            "them, and keep one of each"
        )
    return values
