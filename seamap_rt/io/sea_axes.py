"""The axes of a recorded sea: which they are, their units, and whether their steps are even."""

from __future__ import annotations

import numpy as np
import xarray as xr
from numpy.typing import NDArray

from ..errors import InputError
from .declared import to_unit

_AXES = {
    "time": ("time", "t"),
    "y": ("y", "north", "northing", "lat", "latitude"),
    "x": ("x", "east", "easting", "lon", "longitude"),
}
_CF_AXES = {"time": ("T", "time"), "y": ("Y", "projection_y_coordinate"), "x": ("X", "projection_x_coordinate")}
UNEVEN = 1e-3  # of a step, by which the points of an axis may stray; and the rounding of how they are stored
_ROUNDED = 0.1  # of a step, at most that rounding


def axes_of(values: xr.DataArray) -> dict[str, str]:
    """Which dimension is which."""
    found = {}
    for axis, names in _AXES.items():
        for dimension in values.dims:
            if dimension not in values.coords:
                continue
            attributes = values[dimension].attrs
            by_cf = {str(attributes.get("axis", "")), str(attributes.get("standard_name", ""))}
            if str(dimension).lower() in names or by_cf & set(_CF_AXES[axis]):
                found[axis] = str(dimension)
    return found


def unit_scale(values: xr.DataArray, unit: str, wrong: str) -> float:
    """What makes a variable's numbers those in a unit. Raises InputError for one in a unit of another kind."""
    return float(to_unit(np.ones(1), values.attrs.get("units"), unit, f"{wrong}{values.name}")[0])


def places_of(axis: xr.DataArray, what: str) -> NDArray[np.float64]:
    """The points of an axis in m, in as many digits as the file has."""
    return to_unit(_as_stored(axis.values), axis.attrs.get("units"), "m", what)


def _as_stored(values: NDArray) -> NDArray:
    return np.asarray(values, dtype=np.float64 if values.dtype.kind in "iu" else None)


def check_step(step: float, limits: tuple[float, float], unit: str, what: str) -> None:
    if not limits[0] <= step <= limits[1]:
        raise InputError(
            f"{what} are {step:.3g} {unit} apart: must be {limits[0]:g} to {limits[1]:g}; check the units of the axis "
            "(degrees go to local metres)"
        )


def seconds_of(times: xr.DataArray, wrong: str) -> tuple[NDArray[np.float64], np.datetime64 | None]:
    """Times, of dates from the first one on, which comes with them."""
    values = times.values
    if values.dtype.kind == "M":
        return (values - values[0]) / np.timedelta64(1, "ns") * 1e-9, values[0]
    if values.dtype.kind == "m":
        return values / np.timedelta64(1, "ns") * 1e-9, None
    if values.dtype == object:  # dates of a model's calendar, as cftime decodes them where it is installed
        raise InputError(
            f"{wrong}{times.name} holds dates of a calendar without real dates ('noleap', '360_day'); give seconds or "
            "dates of the standard one"
        )
    return to_unit(_as_stored(values), times.attrs.get("units"), "s", f"{wrong}{times.name}"), None


def even_step(values: NDArray, fewest: int, what: str) -> float:
    """The spacing of an axis. Raises InputError where it is not even, or too short."""
    if values.size < fewest:
        raise InputError(f"{what}: has {values.size} points: must have at least {fewest}; give more of it")
    rounding = 2.0 * float(np.finfo(values.dtype).eps) * float(np.abs(values).max())
    steps = np.diff(values.astype(np.float64))
    step = float(np.median(steps))
    stray = max(UNEVEN * abs(step), min(rounding, _ROUNDED * abs(step)))
    if not np.isfinite(steps).all() or step == 0.0 or np.abs(steps - step).max() > stray:
        raise InputError(f"{what}: is not evenly spaced (median {step:.4g}, {steps.min():.4g} to {steps.max():.4g}); "
                         "resample it")  # fmt: skip
    return abs(float(values[-1]) - float(values[0])) / (values.size - 1)
