"""Virtual wave gauges: a wire's record of the true surface, beside it the radar's map at the same place, judged.

`[[gauges]]` puts them into the sea (`east_m`, `north_m`, or `ground_range_m` and `azimuth_deg`). `gauges.nc` and the
report hold the wire's record, what the map says there once a turn with its error bar, both spectra, and the
correlation. On any maps, recorded ones too, without a wire:

    gauge_series(maps, None, [GaugeSettings(name="pier", east_m=80.0, north_m=0.0)], turn_s=1.0)

Evidence: validation/models/shadowing.md.
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any, NamedTuple

import numpy as np
import xarray as xr
from numpy.typing import ArrayLike, NDArray

from .conventions import wrap_degrees
from .dataset import QUALITY_FLAGS, build, group_of
from .errors import InputError, must_be
from .sea import Sea
from .settings import GaugeSettings

Array = NDArray[np.float64]

LEAST_HEIGHTS = 8  # of a record that is judged at all


def judge(series: xr.Dataset) -> list[dict[str, Any]]:
    """Of each gauge of a series with the true surface, the entries of metrics.json's `gauges`; NaN where not defined,
    and `reason` says why. The true height is that of the surface at the gauge when the radar saw it."""
    return [{"name": str(name), **judge_one(series.sel(gauge=name))} for name in series["gauge"].values]


def judge_one(gauge: xr.Dataset) -> dict[str, Any]:
    """The metrics of one gauge, without its name."""
    true, estimate, spread = (
        np.asarray(gauge[name].values, dtype=np.float64) for name in ("seen_true_height", "height", "height_std")
    )
    cell = gauge["seen_cell_height"].values if "seen_cell_height" in gauge else np.full(true.size, np.nan)
    both = np.isfinite(true) & np.isfinite(estimate)
    enough = int(both.sum()) >= LEAST_HEIGHTS
    true, cell, estimate, spread = (
        values[both] if enough else np.zeros(0) for values in (true, cell, estimate, spread)
    )
    reason = "" if enough else f"{both.sum()} heights in {both.size} turns, and {LEAST_HEIGHTS} are needed to judge"
    wire = gauge["true_height"].values if both.size >= LEAST_HEIGHTS else np.zeros(0)
    error = estimate - true
    return {
        "east_m": float(gauge["east"]),
        "north_m": float(gauge["north"]),
        "turns": int(both.size),
        "answered": float(both.mean()),
        "correlation": _ratio(_covariance(true, estimate), _std(true) * _std(estimate)),
        "rms_error_m": _rms(error),
        "bias_m": _mean(error),
        "regression_slope": _ratio(_covariance(true, estimate), _std(true) ** 2),
        "stated_error_m": _rms(spread),
        "cell_rms_error_m": _rms(estimate - cell),
        "averaging_rms_m": _rms(cell - true),
        "hs_wire_m": 4.0 * _std(wire),
        "hs_true_m": 4.0 * _std(true),
        "hs_retrieved_m": 4.0 * _std(estimate),
        "waves": _up_crossings(wire),
        "reason": reason,
        **_spectral(gauge),
    }


def _spectral(gauge: xr.Dataset) -> dict[str, Any]:
    """The spectra up to half the turn rate, and how much of the wire's variance lies beyond and folds down."""
    result = spectra(gauge)
    if isinstance(result, NoSpectrum):
        unknown = {"nyquist_hz": np.nan, "beyond_nyquist_share": np.nan, "aliasing": None}
        return {**unknown, "spectrum": None, "spectrum_reason": result.reason}
    inside = result.wire_frequency <= result.nyquist
    return {
        "nyquist_hz": result.nyquist,
        "beyond_nyquist_share": result.share_above_nyquist,
        "aliasing": aliasing(result),
        "spectrum": {
            "frequency_hz": result.frequency.tolist(),
            "retrieved_m2_s": result.radar.tolist(),
            "true_once_a_turn_m2_s": result.wire_once_a_turn.tolist(),
            "wire_frequency_hz": result.wire_frequency[inside].tolist(),
            "wire_m2_s": result.wire[inside].tolist(),
            "degrees_of_freedom": result.freedom,
            "bridged_turns": result.bridged,
        },
        "spectrum_reason": result.reason,
    }


def aliasing(result: GaugeSpectra) -> str:
    """What one height a turn does to the spectrum, in words."""
    percent = 100.0 * np.nan_to_num(result.share_above_nyquist)
    share = f"{percent:.0f}" if percent >= 10.0 else f"{percent:.2g}"
    return (
        f"one height a turn tells nothing above {result.nyquist:.3g} Hz, half the turn rate; {share} % of "
        "the wire's variance lies there and folds down into the radar's spectrum"
    )


def _mean(values: Array) -> float:
    return float(values.mean()) if values.size else float("nan")


def _rms(values: Array) -> float:
    return float(np.sqrt(np.mean(values**2))) if values.size else float("nan")


def _std(values: Array) -> float:
    return float(values.std()) if values.size else float("nan")


def _covariance(a: Array, b: Array) -> float:
    return float(np.mean((a - a.mean()) * (b - b.mean()))) if a.size else float("nan")


def _ratio(part: float, whole: float) -> float:
    return part / whole if whole > 0.0 else float("nan")


def _up_crossings(wire: Array) -> int | None:
    """How many waves passed: crossings of the mean level upwards; None without a record."""
    if not wire.size:
        return None
    above = wire > wire.mean()
    return int(np.count_nonzero(above[1:] & ~above[:-1]))


LEAST_SAMPLES_A_TURN = 4  # of the wire, which is to show what one height a turn cannot
LEAST_TURNS = 32  # fewer give no spectrum
MOST_BRIDGED = 0.1  # of the turns may be without a height: so many are bridged linearly
MOST_UNEVEN = 0.1  # of a turn, by which the heights' times may be uneven
_NO_TREND: Any = False  # taken out of each segment: the record's mean is, once
_SEGMENTS = 8  # of a long record, before they overlap; a short one is cut in two


class GaugeSpectra(NamedTuple):
    """One-sided spectra [m² s], all by the same segments' duration and Hann windows. Σ S Δf is the variance but for
    what lies at zero and at the highest frequency itself, which are left out."""

    turn_s: float
    frequency: Array  # Hz, of one height a turn: below half the turn rate
    wire_once_a_turn: Array  # the true surface at the radar's times
    radar: Array  # NaN if too many turns have no height
    wire_frequency: Array  # Hz, below half the wire's rate
    wire: Array
    freedom: float  # degrees of freedom of each estimate
    bridged: int  # turns without a height, interpolated
    reason: str  # why the radar has none; empty if it has one

    @property
    def nyquist(self) -> float:
        """Half the turn rate [Hz]."""
        return 0.5 / self.turn_s

    @property
    def share_above_nyquist(self) -> float:
        """Share of the wire's variance faster than half the turn rate; NaN where nothing moves."""
        whole = float(self.wire.sum())
        return float(self.wire[self.wire_frequency > self.nyquist].sum()) / whole if whole > 0.0 else float("nan")


class NoSpectrum(NamedTuple):
    """Why there is none."""

    reason: str


def spectra(gauge: xr.Dataset) -> GaugeSpectra | NoSpectrum:
    """Spectra of one gauge of a series that has the true surface too, `series.isel(gauge=0)`."""
    height, time = (np.asarray(gauge[name].values, dtype=np.float64) for name in ("height", "seen_time"))
    if height.size < LEAST_TURNS:
        return NoSpectrum(f"{height.size} turns are too short a record for a spectrum, which takes {LEAST_TURNS}")
    steps = np.diff(time)
    if not np.isfinite(time).all() or np.ptp(steps) > MOST_UNEVEN * np.median(steps):
        return NoSpectrum("the beam does not pass here at even times, as a spectrum asks")
    turn_s = float(np.mean(steps))
    segment_s = turn_s * min(height.size // 2, max(LEAST_TURNS, height.size // _SEGMENTS))
    wire_s = float(np.mean(np.diff(gauge["time"].values)))
    if wire_s * LEAST_SAMPLES_A_TURN > turn_s * (1.0 + 1e-6):
        return NoSpectrum(f"the wire is read less than {LEAST_SAMPLES_A_TURN} times a turn")
    frequency, once = _welch(gauge["seen_true_height"].values, turn_s, segment_s)
    radar, known = np.full(frequency.size, np.nan), np.isfinite(height)
    missing, reason = int(np.count_nonzero(~known)), ""
    if missing <= MOST_BRIDGED * height.size:
        radar = _welch(np.interp(time, time[known], height[known]), turn_s, segment_s)[1]
    else:
        most = f"{100.0 * MOST_BRIDGED:.0f} %"
        reason = f"{missing} of {height.size} turns have no height here, and a spectrum bridges {most} at most"
    wire = _welch(gauge["true_height"].values, wire_s, segment_s)
    freedom = _freedom(height.size, turn_s, segment_s)
    return GaugeSpectra(turn_s, frequency, once, radar, *wire, freedom, missing, reason)


def _welch(values: Array, step_s: float, segment_s: float) -> tuple[Array, Array]:
    """Frequencies [Hz] and the spectrum [m² s] there, by segments that overlap by half."""
    from scipy.signal import welch  # takes half a second to import: only where there are gauges

    length = min(values.size, round(segment_s / step_s))
    frequency, density = welch(values - values.mean(), 1.0 / step_s, "hann", length, length // 2, detrend=_NO_TREND)
    inner = slice(1, (length + 1) // 2)
    return frequency[inner], density[inner]


def _freedom(turns: int, turn_s: float, segment_s: float) -> float:
    """Degrees of freedom of a mean of n half-overlapping Hann windows: 2n / (1 + 2 · (1/6)² (n − 1)/n) (Welch 1967)."""
    segments = 2.0 * turns * turn_s / segment_s - 1.0
    return 2.0 * segments / (1.0 + 2.0 / 36.0 * (segments - 1.0) / segments)


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
        values["true_height"] = sea.judge.elevation(points[:, :1], points[:, 1:], coords["time"])
        values["seen_true_height"] = _known_elevation(sea, points, values["seen_time"])
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
            quality[number, n] = flags.flags_at(point)
    return {"height": height, "height_std": spread, "seen_time": time, "quality": quality}


def _known_elevation(sea: Sea, points: Array, time: Array) -> Array:
    """The surface (gauge, turn) at the points at times (gauge, turn), NaN where there is none."""
    known = np.isfinite(time)
    east, north = (np.broadcast_to(points[:, axis, None], time.shape)[known] for axis in (0, 1))
    height = np.full(time.shape, np.nan)
    height[known] = sea.judge.elevation(east, north, time[known])
    return height


class _Cells:
    """The four cells of one turn's ground map around a point, and their bilinear weights (2, 2)."""

    def __init__(self, ground: xr.Dataset, point: Array, period: float) -> None:
        (row, north), (column, east) = (
            _cell_before(ground[name].values, at) for name, at in (("y", point[1]), ("x", point[0]))
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
        """The mean of a field; NaN if the cell in which the point lies has none."""
        values = np.asarray(self._four[name].values, dtype=np.float64)
        weight = np.where(self._together & np.isfinite(values), self._bilinear, 0.0)
        if not self._inside or weight[self._own] == 0.0:
            return float("nan")
        return float(np.sum(weight * np.nan_to_num(values)) / np.sum(weight))


def _cell_before(centres: Array, at: float) -> tuple[int, float]:
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

    def flags_at(self, point: Array) -> int:
        """Flags of the cell that holds a point; no echo where the map has none."""
        east, north = point - self._antenna
        azimuth, ranges = self._polar["azimuth"].values, self._polar["range"].values
        off = np.abs(wrap_degrees(azimuth - np.degrees(np.arctan2(east, north))))
        beside = np.abs(ranges - np.hypot(np.hypot(east, north), self._height))
        look, gate = int(np.argmin(off)), int(np.argmin(beside))
        if off[look] > self._polar.attrs["cell_azimuth_deg"] or beside[gate] > self._polar.attrs["cell_range_m"]:
            return QUALITY_FLAGS["no_echo"]
        return int(self._polar["quality"].values[look, gate])
