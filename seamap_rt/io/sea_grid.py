"""The grid of a recorded sea: which its axes are, their units, whether their steps are even; and its gaps.

Gaps are filled by the smoothest surface: what lies between is bent as little as a thin plate.
The bending energy ∫ η_xx² + 2 η_xy² + η_yy² is least over the gap's points (Duchon 1977), so heights and slopes go on
across the gap's rim. Across a strip of half-width d a wave of wavenumber k that runs over it is a cubic, which errs at
the middle by |cos kd + ½ kd sin kd − 1|, (kd)⁴/24 where that is small; over a round gap of that radius the share is
(kd)⁴/64. `fill_error` is that of the strip: no gap whose points all lie within d of known ones errs by more in the mean
over directions.
"""

from __future__ import annotations

import numpy as np
import scipy.ndimage
import scipy.sparse
import scipy.sparse.linalg
import xarray as xr
from numpy.typing import ArrayLike, NDArray

from ..errors import Refusal
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


def unit_scale(values: xr.DataArray, unit: str) -> float:
    """What makes a variable's numbers those in a unit. Raises Refusal for one in a unit of another kind."""
    return float(to_unit(np.ones(1), values.attrs.get("units"), unit, str(values.name))[0])


def places_of(axis: xr.DataArray, unit: str = "m") -> NDArray[np.float64]:
    """The points of an axis in a unit, in as many digits as the file has."""
    stored = np.asarray(axis.values, dtype=np.float64 if axis.dtype.kind in "iu" else None)
    return to_unit(stored, axis.attrs.get("units"), unit, str(axis.name))


def check_step(step: float, limits: tuple[float, float], unit: str, what: str) -> None:
    if not limits[0] <= step <= limits[1]:
        raise Refusal(
            f"{what} are {step:.3g} {unit} apart: must be {limits[0]:g} to {limits[1]:g}; check the units of the axis "
            "(degrees go to local metres)"
        )


def seconds_of(times: xr.DataArray) -> tuple[NDArray[np.float64], np.datetime64 | None]:
    """Times, of dates from the first one on, which comes with them."""
    values = times.values
    if values.dtype.kind == "M":
        return (values - values[0]) / np.timedelta64(1, "ns") * 1e-9, values[0]
    if values.dtype.kind == "m":
        return values / np.timedelta64(1, "ns") * 1e-9, None
    if values.dtype == object:  # dates of a model's calendar, as cftime decodes them where it is installed
        raise Refusal(
            f"{times.name} holds dates of a calendar without real dates ('noleap', '360_day'); give seconds or "
            "dates of the standard one"
        )
    return places_of(times, "s"), None


def even_step(values: NDArray, fewest: int, what: str) -> float:
    """The spacing of an axis. Raises Refusal where it is not even, or too short."""
    if values.size < fewest:
        raise Refusal(f"{what}: has {values.size} points: must have at least {fewest}; give more of it")
    rounding = 2.0 * float(np.finfo(values.dtype).eps) * float(np.abs(values).max())
    steps = np.diff(values.astype(np.float64))
    step = float(np.median(steps))
    stray = max(UNEVEN * abs(step), min(rounding, _ROUNDED * abs(step)))
    if not np.isfinite(steps).all() or step == 0.0 or np.abs(steps - step).max() > stray:
        around = f"median {step:.4g}, {steps.min():.4g} to {steps.max():.4g}"
        raise Refusal(f"{what}: is not evenly spaced ({around}); resample it")
    return abs(float(values[-1]) - float(values[0])) / (values.size - 1)


# ---------------------------------------------------------------------------------------------------------- the gaps


# Second differences of a plate: rows of (row offset, column offset, weight).
_BENDING = (
    ((0, -1, 1.0), (0, 0, -2.0), (0, 1, 1.0)),
    ((-1, 0, 1.0), (0, 0, -2.0), (1, 0, 1.0)),
    ((0, 0, np.sqrt(2.0)), (0, 1, -np.sqrt(2.0)), (1, 0, -np.sqrt(2.0)), (1, 1, np.sqrt(2.0))),
)


def half_width(gap: NDArray[np.bool_]) -> float:
    """Greatest distance, in points, from a point (row, column) of a gap to one that is known, and half a point: heights
    are known at the rim, and slopes between it and the next points. 0 without gaps, infinite where nothing is known."""
    if not gap.any():
        return 0.0
    if gap.all():
        return float("inf")
    return float(np.asarray(scipy.ndimage.distance_transform_edt(gap)).max()) + 0.5


def fill_gaps(values: NDArray[np.float64], gap: NDArray[np.bool_]) -> NDArray[np.float64]:
    """The heights (row, column), those of the gaps put in. The gaps must leave three points that are known."""
    number = np.full(gap.shape, -1)
    number[gap] = np.arange(np.count_nonzero(gap))
    known = np.where(gap, 0.0, values)
    near = np.asarray(scipy.ndimage.binary_dilation(gap, np.ones((3, 3))))
    rows, columns = np.nonzero(near)
    entries, energies, right, count = [], [], [], 0
    for stencil in _BENDING:
        at = [(rows + down, columns + right_) for down, right_, _ in stencil]
        fits = np.logical_and.reduce([(r >= 0) & (r < gap.shape[0]) & (c >= 0) & (c < gap.shape[1]) for r, c in at])
        at = [(r[fits], c[fits]) for r, c in at]
        touches = np.logical_or.reduce([gap[each] for each in at])
        at = [(r[touches], c[touches]) for r, c in at]
        size = at[0][0].size
        row = count + np.arange(size)
        right.append(-sum(weight * known[each] for each, (*_, weight) in zip(at, stencil, strict=True)))
        for each, (*_, weight) in zip(at, stencil, strict=True):
            unknown = gap[each]
            entries.append((row[unknown], number[each][unknown]))
            energies.append(np.full(np.count_nonzero(unknown), weight))
        count += size
    places = np.concatenate([np.stack(each) for each in entries], axis=1)
    bending = scipy.sparse.csc_array(
        (np.concatenate(energies), (places[0], places[1])), shape=(count, int(number.max()) + 1)
    )
    sought = scipy.sparse.linalg.spsolve((bending.T @ bending).tocsc(), bending.T @ np.concatenate(right))
    whole = known.copy()
    whole[gap] = sought
    return whole


def fill_error(wavenumber: ArrayLike, distance: float) -> NDArray[np.float64]:
    """Error at the middle of a strip of half-width `distance` [m], over the amplitude of a wave [rad/m] across it.
    Where nothing of the wave is left to go by it errs by itself and by what is put there: at most 2."""
    turn = np.asarray(wavenumber, dtype=np.float64) * distance
    return np.minimum(np.abs(np.cos(turn) + 0.5 * turn * np.sin(turn) - 1.0), 2.0)


def unseen_edges(gap: NDArray[np.bool_]) -> NDArray[np.bool_]:
    """The gaps (row, column) that reach the grid's edge."""
    labels, _ = scipy.ndimage.label(gap)  # type: ignore[misc]
    rim = np.concatenate((labels[0], labels[-1], labels[:, 0], labels[:, -1]))
    return gap & np.isin(labels, np.unique(rim[rim > 0]))


def largest_square(free: NDArray[np.bool_], middle: tuple[float, float]) -> tuple[tuple[int, int], int]:
    """First row and column, and points a side, of the largest square of free points (row, column); of several the one
    whose middle is nearest to `middle` (row, column)."""
    total = np.pad(np.cumsum(np.cumsum(~free, axis=0), axis=1), ((1, 0), (1, 0)))

    def fitting(side: int) -> NDArray[np.intp]:
        taken = total[side:, side:] - total[:-side, side:] - total[side:, :-side] + total[:-side, :-side]
        return np.argwhere(taken == 0)

    low, high = 0, min(free.shape)
    while low < high:
        side = (low + high + 1) // 2
        low, high = (side, high) if fitting(side).size else (low, side - 1)
    if not low:
        return (0, 0), 0
    starts = fitting(low)
    away = np.hypot(*(starts + 0.5 * (low - 1) - np.asarray(middle)).T)
    row, column = starts[int(np.argmin(away))]
    return (int(row), int(column)), low
