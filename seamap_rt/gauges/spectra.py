"""Spectra of a gauge: of the wire, sampled many times a second, and of the radar's record, sampled once a turn.

Waves faster than half the turn rate look slower in a record of one height a turn: they fold down into its spectrum. The
wire read at the radar's own times folds in the same way, so that the two differ by the radar alone.
"""

from __future__ import annotations

from typing import Any, NamedTuple

import numpy as np
import xarray as xr
from numpy.typing import NDArray

Array = NDArray[np.float64]

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
