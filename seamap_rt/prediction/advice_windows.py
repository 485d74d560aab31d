"""When to act: the next time in which a boat may turn across the seas, and how long until a quiet window begins."""

from __future__ import annotations

from collections.abc import Mapping

import numpy as np
import xarray as xr

from ..conventions import unit_from_azimuth, wrap_degrees
from ..errors import InputError, must_be
from .field import WaveField
from .quantity import MOTIONS, Course
from .vessel import Vessel

_STEP_S, _BEGINS_S, _LONGEST_S = 0.25, 0.5, 30.0
_SECTOR_DEG = 20.0  # of a turn, in which one heading stands for all
_DRAWS = 100
_SEED = 0  # one sea for all headings


def turn_windows(
    field: WaveField,
    vessel: Vessel,
    from_deg: float,
    to_deg: float,
    speed_m_s: float,
    limits: Mapping[str, float],
    turn_rate_deg_s: float = 6.0,
    confidence: float = 0.9,
) -> xr.Dataset:
    """How likely all limits hold while a boat turns from one heading to another, the shorter way, from each lead on.

    Until it turns, the boat keeps its heading and speed over ground; in the turn its way is taken to go on as before,
    and its motions are those of the headings that it passes, steady from one to the next. limits: by magnitude, of
    heave [m], roll, pitch [deg]. Returns probability and called (issue, lead, place), as `quiet_windows` does.
    Raises InputError for courses, limits or a rate that cannot be, and a turn longer than 30 s.
    """
    must_be("field", field, WaveField, "a WaveField, as reconstruct gives")
    for name, value in (("from_deg", from_deg), ("to_deg", to_deg), ("speed_m_s", speed_m_s)):
        if not np.isfinite(value):
            raise InputError(f"{name} = {value:g}: must be finite")
    if not limits:
        raise InputError(f"limits: is empty; give one of {', '.join(MOTIONS)}")
    for name in set(limits) - set(MOTIONS):
        raise InputError(f"limits: '{name}' is not known; it must be of {', '.join(MOTIONS)}")
    for name, value in (*limits.items(), ("turn_rate_deg_s", turn_rate_deg_s)):
        if not (np.isfinite(value) and value > 0.0):
            raise InputError(f"{name} = {value:g}: must be finite and above 0")
    if not 0.0 < confidence < 1.0:
        raise InputError(f"confidence = {confidence:g}: must lie between 0 and 1")
    turn = float(wrap_degrees(to_deg - from_deg))
    duration = abs(turn) / turn_rate_deg_s
    if duration > _LONGEST_S - _BEGINS_S:
        raise InputError(f"turn_rate_deg_s = {turn_rate_deg_s:g}: the turn takes {duration:.0f} s; turn faster")
    moment = np.arange(0.0, _LONGEST_S + 0.5 * _STEP_S, _STEP_S)
    begin = np.arange(0.0, _LONGEST_S - duration + 1e-9, _BEGINS_S)
    east, north = unit_from_azimuth(from_deg)
    way = (
        field.centre[0] + east * speed_m_s * moment,
        field.centre[1] + north * speed_m_s * moment,
        field.issued + moment,
    )
    count = max(1, int(np.ceil(abs(turn) / _SECTOR_DEG)))
    held = np.ones((_DRAWS, begin.size), bool)
    for number in range(count):
        wanted = field.quantities(list(limits), vessel, Course(from_deg + turn * (number + 0.5) / count, speed_m_s))
        inside = np.ones((_DRAWS, moment.size), bool)
        for (name, limit), drawn in zip(limits.items(), field.draws(wanted, *way, _DRAWS, _SEED), strict=True):
            inside &= np.abs(drawn) < (limit if name == "heave" else np.radians(limit))
        for each, start in enumerate(begin):
            first, last = (start + duration * part / count for part in (number, number + 1))
            part = (moment >= first - 0.5 * _STEP_S) & (moment <= last + 0.5 * _STEP_S)
            held[:, each] &= inside[:, part].all(axis=1)
    chance = held.mean(axis=0)[None, :, None]
    dims = ("issue", "lead", "place")
    return xr.Dataset(
        {
            "probability": (dims, chance, {"units": "1", "long_name": "that all limits hold in the turn"}),
            "called": (dims, chance >= confidence, {"long_name": "called a window to turn"}),
        },
        {"issue": [0], "place": [0], "lead": ("lead", begin, {"units": "s", "long_name": "begin of the turn"})},
        {"duration_s": duration, "confidence": confidence, "from_deg": float(from_deg), "to_deg": float(to_deg)}
        | {f"limit_{name}": float(value) for name, value in limits.items()},
    )


def countdown(windows: xr.Dataset) -> xr.Dataset:
    """How long until the first window that is called, of `quiet_windows` or `turn_windows`: lead [s] (issue, place),
    NaN where none is, and its probability; of none the highest that there is."""
    must_be("windows", windows, xr.Dataset, "a Dataset, as quiet_windows gives")
    called, chance = (windows[name].transpose("issue", "place", "lead") for name in ("called", "probability"))
    any_called = called.any("lead")
    first = called.argmax("lead")
    lead = windows["lead"].isel(lead=first).where(any_called)
    found = chance.isel(lead=first).where(any_called, chance.max("lead"))
    return xr.Dataset(
        {
            "lead": (lead.dims, lead.values, {"units": "s", "long_name": "until the first window that is called"}),
            "probability": (found.dims, found.values, {"units": "1", "long_name": "of that window"}),
        },
        attrs={"duration_s": windows.attrs["duration_s"], "confidence": windows.attrs["confidence"]},
    )


__all__ = ["countdown", "turn_windows"]
