"""Quiet windows that were forecast, against the sea that came: hits, false alarms, and what probabilities came to."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from itertools import pairwise
from typing import Any

import numpy as np
import xarray as xr
from numpy.typing import NDArray

from .forecast_errors import Sea, true_elevation, warm

Array = NDArray[np.float64]

_FINE_S = 0.1
_CLASSES = (0.0, 0.1, 0.3, 0.5, 0.7, 0.9, 1.01)  # of stated probability
_DRAWN_AGAIN = 2000


@dataclass(frozen=True)
class Windows:
    """Windows (n,): the stated chance that each is quiet, whether it was, and by name what else tells quiet ones from
    others: the more, the likelier they are quiet."""

    chance: Array
    quiet: NDArray[np.bool_]
    others: Mapping[str, Array] = field(default_factory=dict)


@dataclass(frozen=True)
class Class:
    """Windows of nearly one stated probability."""

    stated: float
    found: float  # share that was quiet
    low: float  # 95 % band of that share
    high: float
    count: int


def observed_windows(sea: Sea, forecasts: xr.Dataset) -> Windows | None:
    """Windows of a run's forecasts (schema `prediction`) that rest on enough turns, all places together.

    Beside their chance stands persistence: how low the water stayed in the time before the forecast that a window
    lasts. None where no windows were forecast, or by limits that the height of the water does not tell.
    """
    limits = {name for name in forecasts.attrs if name.startswith("limit_")}
    if "quiet" not in forecasts or limits != {"limit_elevation"}:
        return None
    forecasts = forecasts.isel(issue=np.flatnonzero(warm(forecasts)))
    chance = forecasts["quiet"].values.astype(np.float64)  # (issue, lead, place)
    complete = np.flatnonzero(np.isfinite(chance).all(axis=(0, 2)))
    if not complete.size:
        return None
    lasts, lead = float(forecasts.attrs["duration_s"]), forecasts["lead"].values[complete]
    fine = np.arange(-lasts, lead[-1] + lasts + 0.5 * _FINE_S, _FINE_S)
    places = {name: forecasts[name].variable for name in ("issued", "east", "north")}
    height = np.abs(true_elevation(sea, xr.Dataset(places, {"lead": fine}, forecasts.attrs)))
    held = [
        height[:, (fine >= begin - 0.5 * _FINE_S) & (fine <= begin + lasts + 0.5 * _FINE_S)].max(axis=1)
        for begin in lead
    ]
    before = -height[:, fine <= 0.5 * _FINE_S].max(axis=1)[:, None]
    highest = np.stack(held, axis=1)
    known = np.isfinite(highest)  # not so beyond a record
    if not known.any():
        return None
    persistence = np.broadcast_to(before, highest.shape)[known]
    quiet = highest[known] < float(forecasts.attrs["limit_elevation"])
    return Windows(chance[:, complete][known], quiet, {"persistence": persistence})


def hits_and_alarms(score: Array, quiet: NDArray[np.bool_]) -> tuple[Array, Array]:
    """Share of quiet windows and of others that score above a threshold as it falls, each from 0 to 1."""
    ends = np.append(np.flatnonzero(np.diff(np.sort(-score))), score.size - 1)  # equal scores fall together
    order = np.argsort(-score, kind="stable")
    hits, alarms = (np.cumsum(each[order])[ends] / max(each.sum(), 1) for each in (quiet, ~quiet))
    return np.append(0.0, hits), np.append(0.0, alarms)


def area(score: Array, quiet: NDArray[np.bool_]) -> float:
    """Under the curve of hits against false alarms: how often a quiet window scores above one that is not. NaN where
    all are alike."""
    if quiet.all() or not quiet.any():
        return float("nan")
    return float(np.trapezoid(*hits_and_alarms(score, quiet)))


def reliability(runs: Sequence[Windows]) -> list[Class]:
    """What stated probabilities came to. Windows of a run overlap: the bands are of runs drawn again."""
    found, stream = [], np.random.default_rng(1)
    again = stream.integers(len(runs), size=(_DRAWN_AGAIN, len(runs)))
    for low, high in pairwise(_CLASSES):
        inside = [(each.chance >= low) & (each.chance < high) for each in runs]
        count = np.array([each.sum() for each in inside])
        total = int(count.sum())
        if not total:
            continue
        stated = sum(float(run.chance[each].sum()) for run, each in zip(runs, inside, strict=True))
        quiet = np.array([run.quiet[each].sum() for run, each in zip(runs, inside, strict=True)])
        counts = count[again].sum(axis=1)
        shares = quiet[again].sum(axis=1)[counts > 0] / counts[counts > 0]
        least, most = np.quantile(shares, (0.025, 0.975))
        found.append(Class(stated / total, float(quiet.sum()) / total, float(least), float(most), total))
    return found


def judge_windows(windows: Windows, confidence: float) -> dict[str, Any]:
    """What metrics.json holds of windows: how many, the share that was quiet, what was called at a confidence, how much
    of that was right and of the quiet ones was called, the area under hits against false alarms, also of persistence,
    and the mean square error of the probabilities (Brier 1950), also of climatology. What is not defined is None."""
    called, share = windows.chance >= confidence, float(windows.quiet.mean())
    values = {
        "quiet_share": share,
        "right": float(windows.quiet[called].mean()) if called.any() else np.nan,
        "found": float(called[windows.quiet].mean()) if windows.quiet.any() else np.nan,
        "area": area(windows.chance, windows.quiet),
        "persistence_area": area(windows.others["persistence"], windows.quiet),
        "brier": float(np.mean((windows.chance - windows.quiet) ** 2)),
        "climatology_brier": share * (1.0 - share),
    }
    scores = {name: value if np.isfinite(value) else None for name, value in values.items()}
    return {"windows": int(windows.quiet.size), "called": int(called.sum()), "confidence": confidence} | scores
