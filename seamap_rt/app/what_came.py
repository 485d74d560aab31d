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
import xarray as xr
from numpy.typing import NDArray

from ..errors import InputError
from ..forecast_errors import Verified, came, warm
from ..window_errors import Windows, judge_windows, observed_windows
from . import drawing

_MOST_KEPT = 8
_KEPT: OrderedDict[tuple[str, int], asyncio.Future[Came]] = OrderedDict()


@dataclass(frozen=True)
class Came:
    """Forecasts at the boat beside the sea that came (without a field), and their quiet windows beside those that came.

    told: as metrics.json has the windows.
    """

    verified: Verified
    windows: Windows | None
    told: dict[str, Any]

    def at(self, turn: int) -> int | None:
        """Of the issues, the place of the last one up to a turn by its number from 0."""
        held = np.flatnonzero(self.verified.forecasts["issue"].values <= turn)
        return int(held[-1]) if held.size else None

    def quiet(self, at: int) -> NDArray[np.float64] | None:
        """(lead,) of an issue by its place: 1 where a window was quiet, 0 where not, NaN where none is judged."""
        forecasts = self.verified.forecasts
        judged = np.flatnonzero(warm(forecasts))
        row = np.flatnonzero(judged == at)
        if self.windows is None or not row.size:
            return None
        found = np.full(forecasts.sizes["lead"], np.nan)
        told = np.isfinite(forecasts["quiet"].values[judged]).all(axis=(0, 2))
        if self.windows.quiet.size != judged.size * told.sum():  # some lie beyond a record
            return None
        found[told] = self.windows.quiet.reshape(judged.size, -1)[row[0]]
        return found


async def what_came(folder: Path) -> Came:
    """Of a finished run that forecast; some seconds the first time, then kept. However many ask, it is drawn once.

    Raises InputError where there is nothing to tell of, or the sea cannot be drawn again; OSError where no memory is.
    """
    key = _key(folder)
    if key is None:
        raise InputError("no finished forecasts are here")
    if key not in _KEPT or (_KEPT[key].done() and kept(folder) is None):
        _KEPT[key] = asyncio.ensure_future(drawing.alone(came_of, folder))
        while len(_KEPT) > _MOST_KEPT:
            _KEPT.popitem(last=False)
    return await asyncio.shield(_KEPT[key])


def kept(folder: Path) -> Came | None:
    """What is known of a folder already."""
    held = _KEPT.get(_key(folder) or ("", 0))
    known = held is not None and held.done() and not held.cancelled() and held.exception() is None
    return held.result() if held is not None and known else None


def _key(folder: Path) -> tuple[str, int] | None:
    try:
        return str(folder), (folder / "prediction.nc").stat().st_mtime_ns
    except OSError:
        return None


def came_of(folder: Path) -> Came:
    """Of a folder, in this process. InputError where there is nothing to tell of, or a file is damaged."""
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
    windows = observed_windows(sea, forecasts)
    told = judge_windows(windows, scene.prediction.quiet.confidence) if windows is not None else {}
    return Came(Verified(forecasts, came(sea.judge, forecasts), xr.Dataset()), windows, told)
