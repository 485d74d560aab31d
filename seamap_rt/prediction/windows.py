"""What a forecast says to a crew: how likely the next seconds are quiet, and when the highest wave comes."""

from __future__ import annotations

from collections.abc import Mapping

import numpy as np
import xarray as xr
from numpy.typing import NDArray
from scipy.interpolate import CubicSpline

from ..errors import InputError, must_be
from .quantity import MOTIONS

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
