"""A recorded motion of the boat: a CSV file of times, angles and places.

Its first line names the columns, in any order: time_s, and any of roll_deg, pitch_deg, heading_deg (or yaw_deg),
heave_m (or z_m), x_m (east), y_m (north). Lines that are empty or begin with # do not count.

    time_s,roll_deg,pitch_deg,heading_deg,heave_m
    0.00,1.25,-0.40,359.8,0.113
    0.02,1.31,-0.38,0.1,0.117

Whatever is wrong with a file becomes an InputError of one line.
"""

from __future__ import annotations

import csv
import io
import os
from collections.abc import Iterator
from dataclasses import dataclass, replace
from functools import cached_property
from pathlib import Path

import numpy as np
import scipy
from numpy.typing import ArrayLike, NDArray

from ..errors import InputError, say_of
from .opening import LONG, read_bytes
from .text import bad_line, decode_text, finite_number, refuse_semicolons

OTHER_NAMES = {"yaw_deg": "heading_deg", "z_m": "heave_m"}
COLUMNS = ("time_s", "roll_deg", "pitch_deg", "heading_deg", "heave_m", "x_m", "y_m")
STEEPEST_DEG = 60.0  # of roll and pitch: beyond it a boat is capsizing, or the unit is another
_MOST = {  # of a reading, and its unit
    **dict.fromkeys(("roll_deg", "pitch_deg"), (STEEPEST_DEG, "degrees")),
    "heading_deg": (1e5, "degrees"),
    "heave_m": (100.0, "metres"),
    **dict.fromkeys(("x_m", "y_m"), (1e8, "metres")),
}
SLOWEST_STEP_S = 10.0  # between readings: a boat swings once in a few seconds; or the times are not in seconds
LONGEST_GAP = 5.0, 0.5  # of the median step, s; a gap is refused where it is longer than both
_BEYOND_S = 0.5  # a turn's beam reaches a little beyond it, before time 0 too: over that time the boat keeps its rates


@dataclass(frozen=True)
class MotionRecord:
    """A motion as recorded, and its cubic spline (twice continuously differentiable) between the readings."""

    name: str  # of the file
    time: NDArray[np.float64]  # (reading,) s, increasing
    position: NDArray[np.float64]  # (reading, 3) m east north up
    attitude: NDArray[np.float64]  # (reading, 3) deg roll pitch heading, which does not jump at 360°

    @cached_property
    def _spline(self) -> scipy.interpolate.CubicSpline:
        return scipy.interpolate.CubicSpline(self.time, np.concatenate((self.position, self.attitude), axis=1))

    def pose_at(self, times: ArrayLike) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
        """Positions (n, 3) and attitudes (n, 3) at times (n,) s. Raises InputError for a time beyond the record."""
        time = np.asarray(times, dtype=np.float64)
        beyond = ~((time >= self.time[0] - _BEYOND_S) & (time <= self.time[-1] + _BEYOND_S))
        if beyond.any():
            raise InputError(
                f"file '{self.name}': time {time[beyond][0]:.10g} s was asked for: must lie within the record, "
                f"{self.time[0]:.10g} to {self.time[-1]:.10g} s; give a longer record, or shift its times"
            )
        known = np.clip(time, self.time[0], self.time[-1])
        values = self._spline(known) + (time - known)[..., None] * self._spline(known, 1)
        return values[..., :3], values[..., 3:]


def read_motion(path: str | os.PathLike[str], heading_deg: float = 0.0) -> MotionRecord:
    """The motion in a file. Columns that it has not are 0, the heading `heading_deg`.

    Places count from the record's at time 0 (its first, if time 0 is not in it), heights from mean level. Raises
    InputError for a file that cannot be read, without times, with times that do not increase or leave a gap, with less
    than two readings, with what is no number, with a roll or pitch beyond ±60°, and with places where no boat is.
    """
    path, called = Path(path), f"file '{path}'"
    text = decode_text(read_bytes(path, "a motion file", named=called, most=LONG), called)
    with say_of(f"{called}, "):
        try:
            lines, table = _table(text)
        except csv.Error as error:
            raise InputError(f"{called}: is not CSV ({error}); give a CSV file") from None
        time = table.get("time_s", np.zeros(0))
        _check_times(lines, time)
        for name, (most, unit) in _MOST.items():
            beyond = np.flatnonzero(np.abs(table.get(name, time * 0.0)) > most)
            if beyond.size:
                value = table[name][beyond[0]]
                raise bad_line(lines[beyond[0]], f"{name} = {value:g}: must lie within ±{most:g}; correct it; {unit}")
    zero = np.zeros_like(time)
    position = np.stack([table.get(name, zero) for name in ("x_m", "y_m", "heave_m")], axis=-1)
    heading = np.unwrap(table.get("heading_deg", zero + heading_deg), period=360.0)
    attitude = np.stack((table.get("roll_deg", zero), table.get("pitch_deg", zero), heading), axis=-1)
    record = MotionRecord(str(path), time, position, attitude)
    start = record.pose_at([0.0])[0][0] if time[0] <= 0.0 <= time[-1] else position[0]
    return replace(record, position=position - start * (1.0, 1.0, 0.0))


def _table(text: str) -> tuple[list[int], dict[str, NDArray[np.float64]]]:
    """Line numbers (reading,) and columns (reading,) by their names in COLUMNS."""
    rows = _rows(text)
    names = _names(*next(rows, (1, [])))
    lines, values = [], []
    for number, cells in rows:
        if len(cells) != len(names):
            raise bad_line(number, f"{len(cells)} values: must be {len(names)}, one a column; mend the line")
        lines.append(number)
        values.append([finite_number(number, name, cell) for name, cell in zip(names, cells, strict=True)])
    table = np.array(values, dtype=np.float64).reshape(len(values), len(names))
    return lines, dict(zip(names, table.T, strict=True))


def _rows(text: str) -> Iterator[tuple[int, list[str]]]:
    """Line number and cells of every line that counts."""
    reader = csv.reader(io.StringIO(text, newline=""), skipinitialspace=True)
    for cells in reader:
        stripped = [cell.strip() for cell in cells]
        if any(stripped) and not stripped[0].startswith("#"):
            yield reader.line_num, stripped


def _names(line: int, header: list[str]) -> list[str]:
    """The columns' names in COLUMNS."""
    refuse_semicolons(line, ",".join(header))
    names = [OTHER_NAMES.get(name.lower(), name.lower()) for name in header]
    known = f"{', '.join(COLUMNS)} (or {', '.join(OTHER_NAMES)})"
    if "time_s" not in names:
        raise bad_line(line, f"no column time_s: must be there; name the columns, by commas, of {known}")
    for written, name in zip(header, names, strict=True):
        if name not in COLUMNS:
            raise bad_line(line, f"column '{written}': must be one of {known}; rename it or take it out")
        if names.count(name) > 1:
            raise bad_line(line, f"column {name}: must be there once, under one name; take the other out")
    return names


def _check_times(lines: list[int], time: NDArray[np.float64]) -> None:
    """Raise Refusal unless there are two readings or more, one after the other and without a gap."""
    if time.size < 2:
        last = lines[-1] if lines else 1
        raise bad_line(last, f"the file holds {time.size} readings: must be at least 2; give a longer record")
    step = np.diff(time)
    usual = float(np.median(step))
    most, shortest = LONGEST_GAP
    longest = max(most * usual, shortest)
    for after in (np.flatnonzero(step <= 0.0) + 1)[:1]:
        words = f"time_s = {time[after]:.10g}: must be later than {time[after - 1]:.10g}, the time before it; sort the "
        raise bad_line(lines[after], f"{words}lines, and keep one of each time")
    if usual > SLOWEST_STEP_S:
        words = f"a reading every {usual:.4g} s: must come at least every {SLOWEST_STEP_S:g} s; give a denser record"
        raise bad_line(lines[1], f"{words}; times are in seconds")
    for after in (np.flatnonzero(step > longest * (1.0 + 1e-9)) + 1)[:1]:
        words = f"a gap of {step[after - 1]:.4g} s from {time[after - 1]:.10g} to {time[after]:.10g} s: must be at"
        raise bad_line(lines[after], f"{words} most {longest:.4g} s; fill it, or cut the record there")
