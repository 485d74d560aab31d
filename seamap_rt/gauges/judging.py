"""The radar's record against the wire's: how well they agree, and what one height a turn cannot tell."""

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
    true, found, spread = (
        np.asarray(gauge[name].values, dtype=np.float64) for name in ("seen_true_height", "height", "height_std")
    )
    cell = gauge["seen_cell_height"].values if "seen_cell_height" in gauge else np.full(true.size, np.nan)
    both = np.isfinite(true) & np.isfinite(found)
    enough = int(both.sum()) >= LEAST_HEIGHTS
    true, cell, found, spread = (values[both] if enough else np.zeros(0) for values in (true, cell, found, spread))
    reason = "" if enough else f"{both.sum()} heights in {both.size} turns, and {LEAST_HEIGHTS} are needed to judge"
    wire = gauge["true_height"].values if both.size >= LEAST_HEIGHTS else np.zeros(0)
    error = found - true
    return {
        "east_m": float(gauge["east"]),
        "north_m": float(gauge["north"]),
        "turns": int(both.size),
        "answered": float(both.mean()),
        "correlation": _ratio(_covariance(true, found), _std(true) * _std(found)),
        "rms_error_m": _rms(error),
        "bias_m": _mean(error),
        "regression_slope": _ratio(_covariance(true, found), _std(true) ** 2),
        "stated_error_m": _rms(spread),
        "cell_rms_error_m": _rms(found - cell),
        "averaging_rms_m": _rms(cell - true),
        "hs_wire_m": 4.0 * _std(wire),
        "hs_true_m": 4.0 * _std(true),
        "hs_retrieved_m": 4.0 * _std(found),
        "waves": _up_crossings(wire),
        "reason": reason,
        **_spectral(gauge),
    }


def _spectral(gauge: xr.Dataset) -> dict[str, Any]:
    """The spectra up to half the turn rate, and how much of the wire's variance lies beyond and folds down."""
    found = spectra(gauge)
    if isinstance(found, NoSpectrum):
        unknown = {"nyquist_hz": np.nan, "beyond_nyquist_share": np.nan, "aliasing": None}
        return {**unknown, "spectrum": None, "spectrum_reason": found.reason}
    inside = found.wire_frequency <= found.nyquist
    return {
        "nyquist_hz": found.nyquist,
        "beyond_nyquist_share": found.beyond,
        "aliasing": aliasing(found),
        "spectrum": {
            "frequency_hz": found.frequency.tolist(),
            "retrieved_m2_s": found.radar.tolist(),
            "true_once_a_turn_m2_s": found.wire_once_a_turn.tolist(),
            "wire_frequency_hz": found.wire_frequency[inside].tolist(),
            "wire_m2_s": found.wire[inside].tolist(),
            "degrees_of_freedom": found.freedom,
            "bridged_turns": found.bridged,
        },
        "spectrum_reason": found.reason,
    }


def aliasing(found: GaugeSpectra) -> str:
    """What one height a turn does to the spectrum, in words."""
    percent = 100.0 * np.nan_to_num(found.beyond)
    said = f"{percent:.0f}" if percent >= 10.0 else f"{percent:.2g}"
    return (
        f"one height a turn tells nothing above {found.nyquist:.3g} Hz, half the turn rate; {said} % of "
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
