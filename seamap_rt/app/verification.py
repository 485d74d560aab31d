"""What came of a run's forecasts: the sea of its scene at their moments and places.

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
from ..forecast_errors import VerifiedForecasts, true_elevation, warm
from ..window_errors import Windows, judge_windows, observed_windows
from . import drawing

_MOST_KEPT = 8


@dataclass(frozen=True)
class Verification:
    """Forecasts at the boat beside the sea that came (without a field), and their quiet windows beside those that came.

    scores: as metrics.json has the windows.
    """

    verified: VerifiedForecasts
    windows: Windows | None
    scores: dict[str, Any]

    def issue_before(self, turn: int) -> int | None:
        """Index of the last issue up to a turn, by the turn's number from 0."""
        held = np.flatnonzero(self.verified.forecasts["issue"].values <= turn)
        return int(held[-1]) if held.size else None

    def quiet_windows(self, at: int) -> NDArray[np.float64] | None:
        """(lead,) of an issue by its place: 1 where a window was quiet, 0 where not, NaN where none is judged."""
        forecasts = self.verified.forecasts
        judged = np.flatnonzero(warm(forecasts))
        row = np.flatnonzero(judged == at)
        if self.windows is None or not row.size:
            return None
        found = np.full(forecasts.sizes["lead"], np.nan)
        complete = np.isfinite(forecasts["quiet"].values[judged]).all(axis=(0, 2))
        if self.windows.quiet.size != judged.size * complete.sum():  # some lie beyond a record
            return None
        found[complete] = self.windows.quiet.reshape(judged.size, -1)[row[0]]
        return found


class Verifications:
    """Of a few folders: the last ones that were read."""

    def __init__(self) -> None:
        self._kept: OrderedDict[tuple[str, int], asyncio.Future[Verification]] = OrderedDict()

    async def ask(self, folder: Path) -> Verification:
        """Verify a finished run that forecast; some seconds the first time, then kept: it is drawn once.

        Raises InputError where there is nothing to tell of, or the sea cannot be drawn again; OSError where no memory
        is.
        """
        key = _key(folder)
        if not key[1]:
            raise InputError("no finished forecasts are here")
        if key not in self._kept or (self._kept[key].done() and self.find_finished(folder) is None):
            self._kept[key] = asyncio.ensure_future(drawing.alone(verify_folder, folder))
            while len(self._kept) > _MOST_KEPT:
                self._kept.popitem(last=False)
        return await asyncio.shield(self._kept[key])

    def find_finished(self, folder: Path) -> Verification | None:
        """The finished verification of a folder; None where there is none yet."""
        held = self._kept.get(_key(folder))
        known = held is not None and held.done() and not held.cancelled() and held.exception() is None
        return held.result() if held is not None and known else None


def _key(folder: Path) -> tuple[str, int]:
    """The folder, and when its forecasts were finished: 0 where they are not."""
    path = folder / "prediction.nc"
    return str(folder), path.stat().st_mtime_ns if path.exists() else 0


def verify_folder(folder: Path) -> Verification:
    """Verify a folder's forecasts in this process. InputError where they cannot be verified."""
    from ..io.opening import load, open_dataset
    from ..io.scenefile import read_toml
    from ..resolved_scene import run_sea
    from ..scene import scene_of

    if not (folder / "scene.toml").is_file():
        raise InputError("the scene is not known, and so neither is the sea that the forecasts were of")
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
    scores = judge_windows(windows, scene.prediction.quiet.confidence) if windows is not None else {}
    verified = VerifiedForecasts(forecasts, true_elevation(sea.judge, forecasts), xr.Dataset())
    return Verification(verified, windows, scores)
