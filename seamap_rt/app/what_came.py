"""What came of a run's forecasts: the sea of its scene at the moments and places that they were made for.

A sea of a million waves takes memory that a page should not hold: it is drawn again from the scene and its seed in a
process of its own, which ends with that.
"""

from __future__ import annotations

import asyncio
from collections import OrderedDict
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from ..errors import InputError
from . import drawing

Array = NDArray[np.float64]

_MOST_KEPT = 8
_KEPT: OrderedDict[tuple[str, int], asyncio.Future[Came]] = OrderedDict()


@dataclass(frozen=True)
class Class:
    """Windows of nearly one stated chance: stated, and share that was quiet."""

    stated: float
    found: float
    count: int


@dataclass(frozen=True)
class CameWindows:
    """Quiet windows that were forecast at the boat, and which came.

    lead: s, (lead,), at which windows are told. judged: places of the issues that are judged. chance, quiet: of those,
    (issue, lead). curves: by name, share of the other windows and of the quiet ones that score above a falling
    threshold, and the area under that. classes: by stated chance. figures: as metrics.json has them.
    """

    lead: Array
    judged: NDArray[np.intp]
    chance: Array
    quiet: Array
    curves: dict[str, tuple[Array, Array, float]]
    classes: tuple[Class, ...]
    figures: dict[str, Any]


@dataclass(frozen=True)
class Came:
    """Forecasts at the boat beside the sea that came; arrays (issue, lead) in m, issues by their turns from 0.

    warm: (issue,) which rest on turns enough to be judged.
    """

    issue: NDArray[np.intp]
    issued: Array
    lead: Array
    mean: Array
    std: Array
    true: Array
    warm: NDArray[np.bool_]
    windows: CameWindows | None

    def nearest(self, lead_s: float) -> int:
        """Of the leads, the place of the one that is nearest."""
        return int(np.argmin(np.abs(self.lead - lead_s)))

    def at(self, turn: int) -> int | None:
        """Of the issues, the place of the last one up to a turn."""
        held = np.flatnonzero(self.issue <= turn)
        return int(held[-1]) if held.size else None

    def sea(self) -> tuple[Array, Array]:
        """Times [s] and the height that came, of all forecasts together."""
        time, first = np.unique(np.round(self.issued[:, None] + self.lead, 3).ravel(), return_index=True)
        return time, self.true.ravel()[first]

    def by_lead(self) -> dict[str, Array]:
        """(lead,) of the forecasts that are judged: rms of the error (`found`), of what was stated and of persistence,
        over the standard deviation of the sea that came, and the correlation with it. NaN where not defined."""
        mean, std, true = (each[self.warm] for each in (self.mean, self.std, self.true))
        sigma = float(np.std(true)) or np.nan
        rms = {
            name: np.sqrt(np.mean(values**2, axis=0)) / sigma
            for name, values in (("found", mean - true), ("stated", std), ("persistence", mean[:, :1] - true))
        }
        return rms | {"correlation": _correlation(mean, true)}


def _correlation(a: Array, b: Array) -> Array:
    """Of columns, about their means over the rows; NaN of fewer than three rows, or of what never changes."""
    if a.shape[0] < 3:
        return np.full(a.shape[1], np.nan)
    a, b = a - a.mean(axis=0), b - b.mean(axis=0)
    spread = np.sqrt(np.sum(a**2, axis=0) * np.sum(b**2, axis=0))
    return np.divide(np.sum(a * b, axis=0), spread, out=np.full(a.shape[1], np.nan), where=spread > 0.0)


async def what_came(folder: Path) -> Came:
    """Of a finished run that forecast; some seconds the first time, then kept. However many ask, it is drawn once.

    Raises InputError where there is nothing to tell of, or the sea cannot be drawn again; OSError where no memory is.
    """
    try:
        key = str(folder), (folder / "prediction.nc").stat().st_mtime_ns
    except OSError:
        raise InputError("no finished forecasts are here") from None
    if key not in _KEPT or (_KEPT[key].done() and (_KEPT[key].cancelled() or _KEPT[key].exception())):
        _KEPT[key] = asyncio.ensure_future(drawing.alone(came_of, folder))
        while len(_KEPT) > _MOST_KEPT:
            _KEPT.popitem(last=False)
    return await asyncio.shield(_KEPT[key])


def came_of(folder: Path) -> Came:
    """Of a folder, in this process. InputError where there is nothing to tell of, or a file is damaged."""
    from ..forecast_errors import came, warm
    from ..io.opening import load, open_dataset
    from ..io.scenefile import read_toml
    from ..resolved_scene import run_sea
    from ..scene import scene_of

    if not (folder / "scene.toml").is_file():
        raise InputError("the scene is not known, and so nobody knows what came")
    scene = scene_of(read_toml(folder / "scene.toml"))
    path = folder / "prediction.nc"
    try:
        with open_dataset(path) as opened:
            forecasts = load(opened.isel(place=[0]), path.name, path, dense=False)
    except (OSError, KeyError) as error:
        raise InputError(str(error)) from None
    if not forecasts.sizes["issue"]:
        raise InputError("no turn showed a sea, so that nothing was forecast")
    sea = run_sea(scene)
    here = forecasts.isel(place=0)
    issued, lead, mean, std = (
        here[name].values.astype(np.float64) for name in ("issued", "lead", "elevation", "elevation_std")
    )
    return Came(
        issue=here["issue"].values.astype(np.intp),
        issued=issued,
        lead=lead,
        mean=mean,
        std=std,
        true=came(sea.judge, forecasts)[:, :, 0],
        warm=warm(forecasts),
        windows=_windows(sea, forecasts, scene.prediction.quiet.confidence),
    )


def _windows(sea: Any, forecasts: Any, confidence: float) -> CameWindows | None:
    from ..forecast_errors import warm
    from ..window_errors import area, hits_and_alarms, judge_windows, observed_windows, reliability

    windows = observed_windows(sea, forecasts)
    if windows is None:
        return None
    judged = np.flatnonzero(warm(forecasts))
    stated = forecasts["quiet"].values[judged]
    told = np.isfinite(stated).all(axis=(0, 2))
    scores = {"forecast": windows.chance, **windows.others}
    both = bool(windows.quiet.any() and not windows.quiet.all())
    curves = {}
    for name, score in scores.items() if both else ():
        hits, alarms = hits_and_alarms(score, windows.quiet)
        curves[name] = alarms, hits, float(area(score, windows.quiet))
    return CameWindows(
        lead=forecasts["lead"].values[told].astype(np.float64),
        judged=judged,
        chance=windows.chance.reshape(judged.size, -1),
        quiet=windows.quiet.reshape(judged.size, -1).astype(np.float64),
        curves=curves,
        classes=tuple(Class(each.stated, each.found, each.count) for each in reliability([windows])),
        figures=judge_windows(windows, confidence),
    )
