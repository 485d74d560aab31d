"""Forecasts against the sea that came: errors by lead beside what was stated, persistence and climatology."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any, Protocol

import numpy as np
import xarray as xr
from numpy.typing import NDArray

from .conventions import unit_from_azimuth

Array = NDArray[np.float64]

LEADS_S = ((0.0, 0.0), (1.0, 4.0), (5.0, 10.0), (11.0, 20.0), (21.0, 30.0))
_WARM = 5  # turns that a forecast rests on, before which the sea is hardly known
_BAND = 1.96  # standard errors, within which 95 % of normal errors lie


class Sea(Protocol):
    """What can be compared with: the true elevation [m] at places [m] and times [s], arrays (n,); NaN: not known."""

    def elevation(self, x: Array, y: Array, t: Array) -> Array: ...


@dataclass(frozen=True)
class VerifiedForecasts:
    """Forecasts of a run (schema `prediction`), the sea that came, and the last turn's whole field.

    truth: m, (issue, lead, place). field: on the ground's cells (y, x), at the time of the last issue: `reconstructed`
    [m], `stated` [m], its standard error, and `true` [m].
    """

    forecasts: xr.Dataset
    truth: Array
    field: xr.Dataset


def true_elevation(sea: Sea, forecast: xr.Dataset) -> Array:
    """True elevation [m] (issue, lead, place) at the places, times and course of forecasts."""
    toward = unit_from_azimuth(forecast.attrs["heading_deg"])
    lead = forecast["lead"].values[:, None]
    run = forecast.attrs["speed_m_s"] * lead
    east, north = (
        forecast[name].values[:, None, :] + run * part for name, part in zip(("east", "north"), toward, strict=True)
    )
    time = np.broadcast_to(forecast["issued"].values[:, None, None] + lead, east.shape)
    return sea.elevation(east.ravel(), north.ravel(), time.ravel()).reshape(east.shape)


def warm(forecasts: xr.Dataset) -> NDArray[np.bool_]:
    """Which (issue,) rest on enough turns to be judged; all, where none does."""
    enough = forecasts["turns"].values >= _WARM
    return enough if enough.any() else np.ones_like(enough)


def prediction_time(forecasts: xr.Dataset, place: int = 0) -> float | None:
    """s, median of maximum prediction times at a place; None of forecasts that hold none."""
    if "maximum_prediction_time" not in forecasts:
        return None
    return float(np.median(forecasts["maximum_prediction_time"].values[:, place]))


def judge_forecasts(verified: VerifiedForecasts) -> list[dict[str, Any]]:
    """A row for each place and span of leads: what metrics.json holds of forecasts.

    Of the forecasts that rest on five turns or more: correlation with the sea that came, rms of the error, of what was
    stated and of persistence (the sea stays as it is now), all over the standard deviation of the sea that came; and
    the share of errors within 1.96 stated ones; the median maximum prediction time. What is not defined is None.
    """
    judged = warm(verified.forecasts)
    forecasts, truth = verified.forecasts.isel(issue=np.flatnonzero(judged)), verified.truth[judged]
    lead, mean, std = (forecasts[name].values.astype(np.float64) for name in ("lead", "elevation", "elevation_std"))
    rows = []
    for place in range(forecasts.sizes["place"]):
        sigma = float(np.std(truth[:, :, place]))
        longest = prediction_time(forecasts, place)
        for first, last in LEADS_S:
            inside = (lead >= first) & (lead <= last)
            if not inside.any() or not sigma > 0.0:
                continue
            was, forecast, stated = (each[:, inside, place] for each in (truth, mean, std))
            kept_on = mean[:, :1, place] - was
            both = np.std(was) > 0.0 and np.std(forecast) > 0.0 and was.size > 2
            rows.append(
                {
                    "place": int(forecasts["place"][place]),
                    "lead_s": [first, last],
                    "forecasts": int(judged.sum()),
                    "correlation": float(np.corrcoef(was.ravel(), forecast.ravel())[0, 1]) if both else None,
                    "error_share": float(np.sqrt(np.mean((forecast - was) ** 2))) / sigma,
                    "stated_share": float(np.sqrt(np.mean(stated**2))) / sigma,
                    "persistence_share": float(np.sqrt(np.mean(kept_on**2))) / sigma,
                    "within": float(np.mean(np.abs(forecast - was) < _BAND * stated)),
                    "maximum_prediction_time_s": longest,
                }
            )
    return rows
