"""What gauges read: the true surface many times a second, and the ground map where they stand once a turn."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import numpy as np
import xarray as xr
from numpy.typing import ArrayLike, NDArray

from ..conventions import wrap_degrees
from ..dataset import QUALITY_FLAGS, build, group_of
from ..errors import InputError, must_be
from ..sea import Sea
from ..settings import GaugeSettings

Array = NDArray[np.float64]
_SAME_TIME_S = 1e-3  # in which the sea moves by a millimetre


def gauge_series(
    maps: xr.DataTree,
    sea: Sea | None,
    gauges: Sequence[GaugeSettings],
    truth: xr.DataTree | None = None,
    *,
    turn_s: float | None = None,
    antenna_m: ArrayLike = (0.0, 0.0),
) -> xr.Dataset:
    """The schema's `gauges`: of each turn of the maps the height at the gauges' points, by name along `gauge`.

        series = gauge_series(maps, None, [GaugeSettings(name="wire", east_m=40.0, north_m=0.0)])  # recorded maps
        series.sel(gauge="wire")["height"]

    The height is bilinear between the ground cells around the point; a cell without a height leaves its part to the
    others, and if it is the one in which the gauge stands there is none. `quality` is the polar cell's.
    sea: the true one, as Simulator(scene).sea; adds the wire's record over the turns and the surface at the time of
    each height. On choppy waves it is the surface that stands over the point. truth: adds the cells' true mean.
    turn_s: how long a turn lasts; left out, as far as the maps' turns are apart. antenna_m: east and north of the
    antennas, for all turns (2,) or each (turn, 2); only `quality` asks for it. Raises InputError without gauges, and
    for a single turn whose duration is not given.
    """
    must_be("gauges", gauges, Sequence, "a list of GaugeSettings, as scene.gauges")
    if not gauges:
        raise InputError("gauges: there are none; give at least one point")
    for gauge in gauges:
        must_be("gauges", gauge, GaugeSettings, "a list of GaugeSettings, as scene.gauges")
    for group, needed in (("polar", ("turn", "time", "quality")), ("ground", ("height", "time"))):
        group_of(maps, f"maps/{group}", needed)
    if truth is not None:
        group_of(truth, "truth/ground", ("height", "time"))
    if sea is not None:
        must_be("sea", sea, Sea, "a Sea, as Simulator(scene).sea or sea.realize gives")
    turns = np.asarray(maps["polar"]["turn"].values, dtype=np.int64)
    period = turn_s if turn_s is not None else _turn_duration(maps, turns)
    points = np.array([gauge.position for gauge in gauges])
    antennas = np.broadcast_to(np.asarray(antenna_m, dtype=np.float64), (turns.size, 2))
    values: dict[str, Any] = {"east": points[:, 0], "north": points[:, 1]}
    values |= _mapped(maps, points, period, antennas)
    coords: dict[str, Any] = {"turn": turns}
    if sea is not None:
        rate = gauges[0].sample_hz
        coords["time"] = np.concatenate([sample_times(int(turn), period, rate) for turn in turns])
        values["true_height"] = sea.known_elevation(points[:, :1], points[:, 1:], coords["time"])
        values["seen_true_height"] = _where_known(sea, points, values["seen_time"])
    if truth is not None:
        ground = truth["ground"].to_dataset()
        cells = [[_Cells(ground.isel(turn=n), point, period) for n in range(turns.size)] for point in points]
        mean, time = (np.array([[each.mean(name) for each in row] for row in cells]) for name in ("height", "time"))
        # A map that could not be brought to one instant, as its truth was, is of another time: nothing to compare.
        apart = np.abs(time - values["seen_time"]) > _SAME_TIME_S
        values["seen_cell_height"] = np.where(apart, np.nan, mean)
    named = xr.Variable(("gauge",), [gauge.name for gauge in gauges], {"long_name": "name of the gauge"})
    return build("gauges", values, coords).assign_coords(gauge=named)


def sample_times(turn: int, period: float, rate: float) -> Array:
    """Times [s] of a turn's samples: multiples of 1/rate since the start of the run, so that none is taken twice."""
    first, last = (int(np.ceil(number * period * rate - 1e-9)) for number in (turn, turn + 1))
    return np.arange(first, last) / rate


def _turn_duration(maps: xr.DataTree, turns: NDArray[np.int64]) -> float:
    if turns.size < 2:
        raise InputError("turn_s: is missing; a single turn does not tell how long it lasts, give its seconds")
    time = maps["polar"].to_dataset()["time"].isel(azimuth=0).values
    return float(time[-1] - time[0]) / float(turns[-1] - turns[0])


def _mapped(maps: xr.DataTree, points: Array, period: float, antennas: Array) -> dict[str, Any]:
    """What the maps hold at the points, each (gauge, turn)."""
    height, spread, time = (np.full((len(points), len(antennas)), np.nan) for _ in range(3))
    quality = np.zeros(height.shape, dtype=np.int16)
    whole = {name: maps[name].to_dataset() for name in ("polar", "ground")}
    for n, antenna in enumerate(antennas):
        flags = _PolarFlags(whole["polar"].isel(turn=n), antenna)
        for number, point in enumerate(points):
            cells = _Cells(whole["ground"].isel(turn=n), point, period)
            height[number, n], spread[number, n] = cells.mean("height"), cells.mean("height_std")
            time[number, n] = cells.mean("time")
            quality[number, n] = flags.at(point)
    return {"height": height, "height_std": spread, "seen_time": time, "quality": quality}


def _where_known(sea: Sea, points: Array, time: Array) -> Array:
    """The surface (gauge, turn) at the points at times (gauge, turn), NaN where there is none."""
    known = np.isfinite(time)
    east, north = (np.broadcast_to(points[:, axis, None], time.shape)[known] for axis in (0, 1))
    height = np.full(time.shape, np.nan)
    height[known] = sea.known_elevation(east, north, time[known])
    return height


class _Cells:
    """The four cells of one turn's ground map around a point, and their bilinear weights (2, 2)."""

    def __init__(self, ground: xr.Dataset, point: Array, period: float) -> None:
        (row, north), (column, east) = (
            _beside(ground[name].values, at) for name, at in (("y", point[1]), ("x", point[0]))
        )
        self._four = ground.isel(y=slice(row, row + 2), x=slice(column, column + 2))
        self._bilinear = np.outer((1.0 - north, north), (1.0 - east, east))
        own = np.unravel_index(np.argmax(self._bilinear), (2, 2))
        time = self._four["time"].values
        # Beside the start of a turn cells lie a turn apart in time: those of the gauge's own side count.
        with np.errstate(invalid="ignore"):
            self._together = np.abs(time - time[own]) < 0.5 * period
        self._inside = 0.0 <= north <= 1.0 and 0.0 <= east <= 1.0
        self._own = own

    def mean(self, name: str) -> float:
        """Of a field, NaN if the cell in which the point lies has none."""
        values = np.asarray(self._four[name].values, dtype=np.float64)
        weight = np.where(self._together & np.isfinite(values), self._bilinear, 0.0)
        if not self._inside or weight[self._own] == 0.0:
            return float("nan")
        return float(np.sum(weight * np.nan_to_num(values)) / np.sum(weight))


def _beside(centres: Array, at: float) -> tuple[int, float]:
    """The cell before a point on an axis, and how far on towards the next one it lies; not 0 … 1 off the grid."""
    before = int(np.clip(np.searchsorted(centres, at, side="right") - 1, 0, centres.size - 2))
    return before, float((at - centres[before]) / (centres[before + 1] - centres[before]))


class _PolarFlags:
    """Quality flags of one turn's polar cells, by point on the ground."""

    def __init__(self, polar: xr.Dataset, antenna: Array) -> None:
        self._polar, self._antenna = polar, antenna
        slant, ground = polar["range"].values, polar["ground_range"].values.astype(np.float64)
        # The antenna's height over mean sea level, as the map's own cells have it.
        known = np.isfinite(ground)
        fall = np.sqrt(np.maximum(np.broadcast_to(slant, ground.shape)[known] ** 2 - ground[known] ** 2, 0.0))
        self._height = float(np.median(fall + polar["height"].values[known])) if known.any() else 0.0

    def at(self, point: Array) -> int:
        """Flags of the cell that holds a point; no echo where the map has none."""
        east, north = point - self._antenna
        azimuth, ranges = self._polar["azimuth"].values, self._polar["range"].values
        off = np.abs(wrap_degrees(azimuth - np.degrees(np.arctan2(east, north))))
        beside = np.abs(ranges - np.hypot(np.hypot(east, north), self._height))
        look, gate = int(np.argmin(off)), int(np.argmin(beside))
        if off[look] > self._polar.attrs["cell_azimuth_deg"] or beside[gate] > self._polar.attrs["cell_range_m"]:
            return QUALITY_FLAGS["no_echo"]
        return int(self._polar["quality"].values[look, gate])
