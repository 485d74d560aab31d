"""What reports show, in one line of a notebook: each returns a Matplotlib figure, which a notebook draws."""

from __future__ import annotations

import numpy as np
import xarray as xr
from matplotlib.figure import Figure

from .errors import InputError, must_be
from .metrics import error_figures
from .prediction import WaveField
from .report.advice_figure import advice_polar
from .report.curves import error_against_range
from .report.forecast_figures import BoatForecast, next_seconds
from .report.retrieved_page import draw_heights, map_of_turn


def height_map(maps: xr.DataTree, turn: int = -1) -> Figure:
    """Retrieved heights and their standard errors on the ground of one of the maps' turns, by its place among them.

    Raises InputError for a turn that maps do not hold.
    """
    must_be("maps", maps, xr.DataTree, "a DataTree, as retrieve gives")
    _refuse_place("turn", turn, maps["ground"].sizes["turn"])
    return map_of_turn(maps, turn)


def error_by_range(maps: xr.DataTree, truth: xr.DataTree) -> Figure:
    """Height error with the stated one, bias and slope error against range. Raises as `compare` does."""
    return error_against_range(maps, truth, error_figures(maps, truth))


def wave_field(field: WaveField, time: float | None = None, spacing_m: float = 3.0) -> Figure:
    """Expected heights and their standard errors about the antennas, as far out as the sea was seen.

    field: as from `reconstruct`. time: s; when the last turn ended, if left out. spacing_m: of the points [m]. Raises
    InputError for one that is not greater than 0, or gives more than a million points.
    """
    must_be("field", field, WaveField, "a WaveField, as reconstruct gives")
    least = 2e-3 * field.reach
    if not least <= spacing_m <= field.reach:
        raise InputError(f"spacing_m = {spacing_m:g}: must be {least:.2g} to {field.reach:g} m, the reach; correct it")
    away = np.arange(-field.reach, field.reach + 0.5 * spacing_m, spacing_m)
    x, y = (middle + away for middle in field.centre)
    inside = np.hypot(away, away[:, None]) <= field.reach
    both = field.elevation(*np.meshgrid(x, y), field.issued if time is None else time)
    values = {
        name: (("y", "x"), np.where(inside, v, np.nan)) for name, v in zip(("height", "height_std"), both, strict=True)
    }
    return draw_heights(xr.Dataset(values, {"x": x, "y": y}))


def forecast(coming: xr.Dataset, place: int = 0, issue: int = -1) -> Figure:
    """Height that is expected at a place in the next seconds, ± 1.96 standard errors, and the highest crest.

    coming: as from `seamap_rt.forecast`, or a run's prediction.nc. place, issue: by their places in it.
    Raises InputError for others.
    """
    must_be("coming", coming, xr.Dataset, "a Dataset, as forecast gives")
    for name, at in (("issue", issue), ("place", place)):
        _refuse_place(name, at, coming.sizes[name])
    one = coming.isel(issue=issue, place=place)
    lead = np.asarray(one["lead"].values, dtype=np.float64)
    chance = one["quiet"].values if "quiet" in one else np.full(lead.size, np.nan)
    height, std, chance = (
        np.asarray(each, dtype=np.float64) for each in (one["elevation"], one["elevation_std"], chance)
    )
    longest = float(one["maximum_prediction_time"]) if "maximum_prediction_time" in one else None
    return next_seconds(BoatForecast(int(one["issue"]), lead, height, std, chance, "", None, np.nan, np.nan, longest))


def advice(advised: xr.Dataset) -> Figure:
    """Roll that is expected by heading and speed, north up, the best course and the present one.

    advised: as from `advise`. Raises InputError unless its headings go evenly all round and two speeds or more rise.
    """
    must_be("advised", advised, xr.Dataset, "a Dataset, as advise gives")
    heading, speed = advised["heading"].values, advised["speed"].values
    if speed.size < 2 or (np.diff(speed) <= 0.0).any() or not np.allclose(np.diff(heading), 360.0 / heading.size):
        raise InputError("advised: must be of headings evenly all round and of two rising speeds; ask for such advice")
    return advice_polar(advised)


def _refuse_place(name: str, at: int, held: int) -> None:
    if not -held <= at < held:
        raise InputError(f"{name} = {at}: must be from {-held} to {held - 1}, for there are {held}; correct it")
