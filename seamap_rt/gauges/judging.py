"""The radar's record against the wire's: how well they agree, and what one height a turn cannot resolve."""

from __future__ import annotations

from typing import Any

import numpy as np
import xarray as xr
from numpy.typing import NDArray

from .spectra import GaugeSpectra, NoSpectrum, spectra

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
