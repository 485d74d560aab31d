"""The radar's record against the wire's: how well they agree, their spectra, and what one height a turn misses."""

from __future__ import annotations

from typing import Any, NamedTuple

import numpy as np
import xarray as xr
from numpy.typing import NDArray

Array = NDArray[np.float64]

LEAST_HEIGHTS = 8  # of a record that is judged at all


def judge(series: xr.Dataset) -> list[dict[str, Any]]:
    """Of each gauge of a series with the true surface, the entries of metrics.json's `gauges`; NaN where not defined,
    and `reason` says why. The true height is that of the surface at the gauge when the radar saw it."""
    return [{"name": str(name), **judge_one(series.sel(gauge=name))} for name in series["gauge"].values]


def judge_one(gauge: xr.Dataset) -> dict[str, Any]:
    """Of one gauge, without its name."""
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
        "beyond_nyquist_share": result.beyond,
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
    percent = 100.0 * np.nan_to_num(result.beyond)
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
    def beyond(self) -> float:
        """Share of the wire's variance faster than half the turn rate; NaN where nothing moves."""
        whole = float(self.wire.sum())
        return float(self.wire[self.wire_frequency > self.nyquist].sum()) / whole if whole > 0.0 else float("nan")


class NoSpectrum(NamedTuple):
    """Why there is none."""

    reason: str


def spectra(gauge: xr.Dataset) -> GaugeSpectra | NoSpectrum:
    """Of one gauge of a series that has the true surface too, `series.isel(gauge=0)`."""
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
    """Of a mean over n Hann windows that overlap by half: 2n / (1 + 2 · (1/6)² (n − 1)/n) (Welch 1967)."""
    segments = 2.0 * turns * turn_s / segment_s - 1.0
    return 2.0 * segments / (1.0 + 2.0 / 36.0 * (segments - 1.0) / segments)
