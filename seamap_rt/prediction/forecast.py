"""Forecasts at places: elevation, slopes and vertical velocity with their errors, and the quiet windows in them."""

from __future__ import annotations

from collections.abc import Mapping, Sequence

import numpy as np
import xarray as xr
from numpy.typing import ArrayLike

from ..dataset import build
from ..errors import InputError
from .field import WaveField

_QUANTITIES = ("elevation", "slope_x", "slope_y", "velocity_z")
_DRAWS = 200  # a probability of 0.9 is known to 0.02
_STEPS_A_SECOND = 4  # in a window: waves that matter to a boat last seconds


def forecast(
    field: WaveField, at: Sequence[tuple[float, float]] = ((0.0, 0.0),), lead_s: ArrayLike | None = None
) -> xr.Dataset:
    """Expected sea at places (east, north) [m] at some leads [s] after the last that was seen (schema `prediction`).

    lead_s: 0 to 30 s by seconds if left out. Raises InputError for places or leads that are not finite.
    """
    lead = np.arange(0.0, 31.0) if lead_s is None else np.atleast_1d(np.asarray(lead_s, dtype=np.float64))
    place = np.asarray(at, dtype=np.float64)
    if place.ndim != 2 or place.shape[1] != 2 or not np.isfinite(place).all():
        raise InputError(f"at = {at}: must be pairs of metres east and north; give at least one")
    if lead.ndim != 1 or not lead.size or not np.isfinite(lead).all():
        raise InputError("lead_s: must be finite seconds, one at least")
    time = field.issued + lead[:, None]
    values: dict[str, np.ndarray] = {}
    for kind in _QUANTITIES:
        mean, std = field.values(kind, place[:, 0], place[:, 1], time)
        values |= {kind: mean[None], f"{kind}_std": std[None]}
    values["predictable"] = np.clip(1.0 - values["elevation_std"] ** 2 / field.spectrum.variance, 0.0, 1.0)
    return build(
        "prediction",
        values | {"issued": [field.issued], "significant_wave_height": [4.0 * field.sea_std], "turns": [field.turns]},
        {"issue": [0], "lead": lead, "place": np.arange(place.shape[0]), "east": place[:, 0], "north": place[:, 1]},
    )


def quiet_windows(
    field: WaveField,
    limit: Mapping[str, float],
    duration_s: float = 5.0,
    confidence: float = 0.9,
    *,
    at: tuple[float, float] = (0.0, 0.0),
    lead_s: ArrayLike | None = None,
    seed: int = 0,
) -> xr.Dataset:
    """How likely all limits hold for a time from each lead on, and where that is called a quiet window.

    limit: of quantities (elevation [m], slope_x, slope_y, velocity_z [m/s]) by magnitude. lead_s: when windows begin
    [s], 0 to 25 s by seconds if left out. Probabilities are shares of draws from the field's own doubt, whose moments
    hang together; each limit's draws are its own, so that several limits are taken as independent of one another given
    the forecast. Returns probability (lead,) and called (lead,), which is probability ≥ confidence.
    Raises InputError for an unknown quantity, a limit or duration that is not positive, a confidence not in (0, 1).
    """
    unknown = sorted(set(limit) - set(_QUANTITIES))
    if unknown or not limit:
        raise InputError(f"limit: '{(unknown or ['none'])[0]}' is not known; it must be of {', '.join(_QUANTITIES)}")
    for name, value in (*limit.items(), ("duration_s", duration_s)):
        if not (np.isfinite(value) and value > 0.0):
            raise InputError(f"{name} = {value:g}: must be finite and above 0")
    if not 0.0 < confidence < 1.0:
        raise InputError(f"confidence = {confidence:g}: must lie between 0 and 1")
    lead = np.arange(0.0, 26.0) if lead_s is None else np.atleast_1d(np.asarray(lead_s, dtype=np.float64))
    step = 1.0 / _STEPS_A_SECOND
    fine = np.arange(lead.min(), lead.max() + duration_s + 0.5 * step, step)
    probability = np.ones(lead.size)
    for name, value in limit.items():
        inside = np.abs(field.draws(name, *at, field.issued + fine, _DRAWS, seed)) < value
        for n, begin in enumerate(lead):
            held = (fine >= begin - 0.5 * step) & (fine <= begin + duration_s + 0.5 * step)
            probability[n] *= float(np.mean(inside[:, held].all(axis=1)))
    return xr.Dataset(
        {
            "probability": ("lead", probability, {"units": "1", "long_name": "that all limits hold for the duration"}),
            "called": ("lead", probability >= confidence, {"long_name": "called a quiet window"}),
        },
        {"lead": ("lead", lead, {"units": "s", "long_name": "begin of the window after the last that was seen"})},
        {"issued": field.issued, "duration_s": duration_s, "confidence": confidence}
        | {f"limit_{name}": float(value) for name, value in limit.items()},
    )
