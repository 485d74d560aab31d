"""Forecasts along the way of places: the water and a vessel there, with errors and draws of what may come.

To a crew they say how likely the next seconds are quiet, and when the highest wave comes.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence

import numpy as np
import xarray as xr
from numpy.typing import ArrayLike, NDArray
from scipy.interpolate import CubicSpline

from ..conventions import unit_from_azimuth
from ..dataset import build
from ..errors import InputError, must_be
from ..io.text import numbers
from .field import WaveField
from .quantity import MOTIONS, Course
from .vessel import Vessel

_WATER = ("elevation", "slope_x", "slope_y", "velocity_z")
_STEP_S = 0.5  # waves that matter to a boat last seconds: between such leads splines follow them
_LONGEST_S = 30.0
_DRAWS = 100  # a probability of 0.9 is known to 0.03
_HALF = 0.5  # of the sea's standard deviation: of larger errors a forecast tells little


def forecast(
    field: WaveField,
    at: Sequence[tuple[float, float]] | None = None,
    lead_s: ArrayLike | None = None,
    *,
    vessel: Vessel | None = None,
    heading_deg: float = 0.0,
    speed_m_s: float = 0.0,
    draws: int = _DRAWS,
    seed: int = 0,
) -> xr.Dataset:
    """Expected sea at places (east, north) [m] at some leads [s] after the last that was seen (schema `prediction`).

    field: as from `reconstruct`.
    at: where the antennas were then, if left out. lead_s: 0 to 30 s by half seconds if left out. vessel: whose heave,
    roll and pitch are wanted too. heading_deg, speed_m_s: of the places, and the vessel, from lead 0 on, clockwise from
    north and over ground; at rest if left out.
    draws: of what may come, which `quiet_windows` and `highest_wave` read; 0: none. seed: of these draws.
    Raises InputError for places, leads or a course that are not finite, and for a number of draws below 0.
    """
    must_be("field", field, WaveField, "a WaveField, as reconstruct gives")
    lead = np.arange(0.0, _LONGEST_S + _STEP_S, _STEP_S) if lead_s is None else np.atleast_1d(numbers("lead_s", lead_s))
    place = numbers("at", [field.centre] if at is None else at)
    if place.ndim != 2 or place.shape[1] != 2 or not np.isfinite(place).all():
        raise InputError(f"at = {at}: must be pairs of metres east and north; give at least one")
    if lead.ndim != 1 or not lead.size or not np.isfinite(lead).all():
        raise InputError("lead_s: must be finite seconds, one at least")
    for name, value in (("heading_deg", heading_deg), ("speed_m_s", speed_m_s)):
        if not np.isfinite(value):
            raise InputError(f"{name} = {value:g}: must be finite")
    if draws < 0:
        raise InputError(f"draws = {draws}: must be at least 0")
    names = (*_WATER, *(MOTIONS if vessel is not None else ()))
    wanted = field.quantities(names, vessel, Course(heading_deg, speed_m_s))
    values: dict[str, list[np.ndarray]] = {}
    for x, y in place:
        toward = unit_from_azimuth(heading_deg)
        way = x + toward[0] * speed_m_s * lead, y + toward[1] * speed_m_s * lead, field.issued + lead
        for name, (mean, std) in zip(names, field.predict(wanted, *way), strict=True):
            values.setdefault(name, []).append(mean)
            values.setdefault(f"{name}_std", []).append(std)
        if draws:
            for name, drawn in zip(names, field.draws(wanted, *way, draws, seed), strict=True):
                values.setdefault(f"{name}_draw", []).append(drawn)
    stacked = {name: _to_degrees(name, np.stack(each, axis=-1)[None]) for name, each in values.items()}
    stacked["predictable"] = np.clip(1.0 - stacked["elevation_std"] ** 2 / field.spectrum.variance, 0.0, 1.0)
    stacked["maximum_prediction_time"] = maximum_prediction_time(lead, stacked["elevation_std"][0], field.sea_std)[None]
    height, period = 4.0 * field.sea_std, field.spectrum.peak_period
    return build(
        "prediction",
        stacked
        | {"issued": [field.issued], "turns": [field.turns]}
        | {"significant_wave_height": [height], "peak_period": [period]},
        {"issue": [0], "lead": lead, "place": np.arange(place.shape[0])}
        | {"east": place[None, :, 0], "north": place[None, :, 1]},
        {"heading_deg": float(heading_deg), "speed_m_s": float(speed_m_s)},
    )


def maximum_prediction_time(lead_s: ArrayLike, std: ArrayLike, sea_std: float) -> NDArray[np.float64]:
    """Longest lead [s] (place,) up to which standard errors (lead, place) stay below half of the sea's own standard
    deviation, along lines between leads; the last lead where all do, 0 where the first lead's does not."""
    lead, share = np.asarray(lead_s, np.float64), np.asarray(std, np.float64) / max(sea_std, 1e-12)
    order = np.argsort(lead)
    lead, share = lead[order], share[order]
    above = np.vstack((share >= _HALF, np.ones(share.shape[1], bool)))
    first, place = np.argmax(above, axis=0), np.arange(share.shape[1])
    before, after = np.maximum(first - 1, 0), np.minimum(first, lead.size - 1)
    low, high = share[before, place], share[after, place]
    part = np.clip((_HALF - low) / np.maximum(high - low, 1e-12), 0.0, 1.0)
    return np.where(first == 0, 0.0, lead[before] + part * (lead[after] - lead[before]))


def _to_degrees(name: str, values: np.ndarray) -> np.ndarray:
    return np.degrees(values) if name.startswith(("roll", "pitch")) else values


LIMITED = ("elevation", "slope_x", "slope_y", "velocity_z", *MOTIONS)
_COARSEST_S = 0.5  # between leads: waves of two seconds and more are followed by splines
_FINE_S = 0.1
_NEAR_S = 1.0  # a crest at a said time comes no later and no earlier
_OUTER = 5.0, 95.0  # per cent, of crests


def quiet_windows(
    forecast: xr.Dataset, limit: Mapping[str, float], duration_s: float = 5.0, confidence: float = 0.9
) -> xr.Dataset:
    """How likely all limits hold for a time from each lead on, and where that is called a quiet window.

    forecast: as from `forecast`, with draws, by leads half a second apart or less. limit: by magnitude, of elevation
    [m], slope_x, slope_y, velocity_z [m/s], heave [m], roll, pitch [deg]. A probability is the share of draws in which
    all limits hold together for duration_s [s]. Returns probability and called (issue, lead, place), called:
    probability ≥ confidence, of all leads whose window ends within the forecast.
    Raises InputError for an unknown quantity, a limit or duration that is not positive, a confidence not in (0, 1), and
    a forecast that is too coarse, too short, or without draws.
    """
    must_be("forecast", forecast, xr.Dataset, "a Dataset, as forecast gives")
    must_be("limit", limit, Mapping, "a dict of limits, such as {'elevation': 0.5}")
    if not limit:
        raise InputError(f"limit: is empty; give one of {', '.join(LIMITED)}")
    for name in limit:
        if name not in LIMITED:
            raise InputError(f"limit: '{name}' is not known; it must be of {', '.join(LIMITED)}")
    for name, value in (*limit.items(), ("duration_s", duration_s)):
        if not (np.isfinite(value) and value > 0.0):
            raise InputError(f"{name} = {value:g}: must be finite and above 0")
    if not 0.0 < confidence < 1.0:
        raise InputError(f"confidence = {confidence:g}: must lie between 0 and 1")
    fine, inside = np.empty(0), np.ones(1, dtype=bool)
    for name, value in limit.items():
        fine, drawn = _followed(forecast, name)
        inside = inside & (np.abs(drawn) < value)
    lead = forecast["lead"].values
    lead = lead[lead + duration_s <= lead[-1] + 0.5 * _FINE_S]
    if not lead.size:
        raise InputError(f"duration_s = {duration_s:g}: is longer than the forecast; ask for longer leads")
    held = [
        inside[..., (fine >= begin - 0.5 * _FINE_S) & (fine <= begin + duration_s + 0.5 * _FINE_S)].all(axis=-1)
        for begin in lead
    ]
    probability = np.mean(np.stack(held), axis=2).transpose(1, 0, 2)  # lead, issue, draw, place → issue, lead, place
    dims = ("issue", "lead", "place")
    return xr.Dataset(
        {
            "probability": (dims, probability, {"units": "1", "long_name": "that all limits hold for the duration"}),
            "called": (dims, probability >= confidence, {"long_name": "called a quiet window"}),
        },
        _places(forecast) | {"lead": ("lead", lead, {"units": "s", "long_name": "begin of the window"})},
        {"duration_s": duration_s, "confidence": confidence}
        | {f"limit_{name}": float(value) for name, value in limit.items()},
    )


def highest_wave(forecast: xr.Dataset, within_s: float | None = None) -> xr.Dataset:
    """The highest crest of the sea that comes within a time, and when.

    forecast: as from `forecast`, with draws, by leads half a second apart or less. within_s: all leads if left out.
    Returns (issue, place) crest [m], the median of the draws' highest, crest_low and crest_high, between which nine
    draws of ten lie, lead [s], about which most draws have it, and chance, the share of draws that have it within a
    second of then. Raises InputError for a time that no lead lies in, and a forecast too coarse or without draws.
    """
    must_be("forecast", forecast, xr.Dataset, "a Dataset, as forecast gives")
    fine, drawn = _followed(forecast, "elevation")
    inside = fine <= (np.inf if within_s is None else within_s) + 0.5 * _FINE_S
    if not inside.any():
        raise InputError(f"within_s = {within_s:g}: no lead of the forecast lies in it")
    fine, drawn = fine[inside], drawn[..., inside]
    crest, moment = drawn.max(axis=-1), fine[drawn.argmax(axis=-1)]  # (issue, draw, place)
    near = np.mean(np.abs(moment[..., None] - fine) <= _NEAR_S, axis=1)  # (issue, place, moment)
    low, middle, high = np.percentile(crest, (_OUTER[0], 50.0, _OUTER[1]), axis=1)
    most = near == near.max(axis=-1, keepdims=True)
    lead = np.sum(most * fine, axis=-1) / most.sum(axis=-1)  # the middle of what is equally likely
    dims, metres = ("issue", "place"), {"units": "m"}
    return xr.Dataset(
        {
            "crest": (dims, middle, metres | {"long_name": "height of the highest crest"}),
            "crest_low": (dims, low, metres | {"long_name": "that it exceeds in 95 draws of 100"}),
            "crest_high": (dims, high, metres | {"long_name": "that it exceeds in 5 draws of 100"}),
            "lead": (dims, lead, {"units": "s", "long_name": "when it comes, after the last that was seen"}),
            "chance": (dims, near.max(axis=-1), {"units": "1", "long_name": "that it comes within a second of then"}),
        },
        _places(forecast),
    )


def _followed(forecast: xr.Dataset, name: str) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
    """Fine leads [s], and one quantity's draws (issue, draw, place, lead) at them."""
    if f"{name}_draw" not in forecast:
        why = (
            "give the vessel to forecast" if name in MOTIONS and name not in forecast else "forecast with draws above 0"
        )
        raise InputError(f"{name}: the forecast holds no draws of it; {why}")
    lead = np.asarray(forecast["lead"].values, np.float64)
    step = float(np.diff(lead).max()) if lead.size > 1 else np.inf
    if not (lead.size > 1 and np.all(np.diff(lead) > 0.0) and step <= _COARSEST_S + 1e-9):
        raise InputError(f"lead: steps of {step:g} s are too long; forecast by leads {_COARSEST_S:g} s apart or less")
    drawn = forecast[f"{name}_draw"].transpose("issue", "draw", "place", "lead").values.astype(np.float64)
    fine = np.append(np.arange(lead[0], lead[-1], _FINE_S), lead[-1])
    return fine, CubicSpline(lead, drawn, axis=-1)(fine)


def _places(forecast: xr.Dataset) -> dict[str, xr.DataArray]:
    return {name: forecast[name] for name in ("issue", "place", "east", "north", "issued") if name in forecast}
