"""Forecasts along the way of places: the water and a vessel there, with errors and draws of what may come."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
import xarray as xr
from numpy.typing import ArrayLike, NDArray

from ..conventions import unit_from_azimuth
from ..dataset import build
from ..errors import InputError, must_be
from ..io.numbers import numbers
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
        for name, (mean, std) in zip(names, field.told(wanted, *way), strict=True):
            values.setdefault(name, []).append(mean)
            values.setdefault(f"{name}_std", []).append(std)
        if draws:
            for name, drawn in zip(names, field.draws(wanted, *way, draws, seed), strict=True):
                values.setdefault(f"{name}_draw", []).append(drawn)
    stacked = {name: _in_degrees(name, np.stack(each, axis=-1)[None]) for name, each in values.items()}
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


def _in_degrees(name: str, values: np.ndarray) -> np.ndarray:
    return np.degrees(values) if name.startswith(("roll", "pitch")) else values
