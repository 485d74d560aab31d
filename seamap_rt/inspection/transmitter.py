"""The transmitter: whether phases go on from pulse to pulse as they are said to.

Between two pulses of one antenna strong echoes turn alike, a little by their velocities, and what the transmitter does
to them is the same in all gates. So the sum of V(n + 1) V*(n) over a few neighbouring gates is as long as their powers
let it be while the echo lasts, and its direction holds still over a dwell if the transmitter is coherent. A magnetron's
points anywhere: of random phases the mean direction of N pairs is 1/√N long.
"""

from __future__ import annotations

import numpy as np
import xarray as xr
from numpy.typing import NDArray

from ..interferometry.covariance.pairs import rows_apart, sampled
from .heights import Finding

_GATES = 8  # neighbours whose echoes are summed: they turn by about the same velocity
_STRONG_DB = 10.0
_LASTING = 0.7  # of a coherence of 1 that echoes keep from pulse to pulse: where it is less nothing can be said
_PULSES = 16  # in a row, over which the direction must hold
_RANDOM, _STEADY = 0.5, 0.8  # coherence that the transmitter leaves: below, and above which it is sure what it is
_FEWEST = 50  # runs of pulses
_MOST_CYCLE = 16  # pulses after which an antenna sends again
_MOST_PAIRS = 20_000
_MEASURE = "mend how each pulse's phase is measured, or state its error by transmit_phase_error_deg"
_MAGNETRON = (
    "set transmitter = 'magnetron' in the header, and coherent_on_receive where each pulse's phase has been taken off"
)


def transmitter(turn: xr.Dataset) -> Finding:
    """Of one turn's echoes, voltages loaded."""
    what = "phase from pulse to pulse"
    runs = _runs(turn)
    if runs is None:
        return Finding(what, "unknown", "too few strong echoes last from one pulse to the next")
    lasting, kept = runs
    magnetron = str(turn.attrs.get("transmitter", "coherent")) == "magnetron"
    measured = magnetron and bool(turn.attrs.get("coherent_on_receive", 0))
    says = f"the transmitter leaves {kept:.2f} of it, where {lasting:.2f} of the echo lasts"
    if magnetron and not measured:
        if kept < _RANDOM:
            return Finding(what, "good", f"{says}: random, as of a magnetron, and not used")
        remedy = "set transmitter = 'coherent' in the header, or coherent_on_receive, to have velocities"
        return Finding(what, "unknown", f"{says}: it could be used", remedy)
    stated = np.radians(float(turn.attrs.get("transmit_phase_error_deg", 0.0))) if measured else 0.0
    if kept > _STEADY * np.exp(-(stated**2)):
        return Finding(what, "good", says)
    if kept > _RANDOM:
        return Finding(what, "doubtful", f"{says}, as errors of {np.degrees(np.sqrt(-np.log(kept))):.0f}° do", _MEASURE)
    remedy = _MEASURE if measured else _MAGNETRON
    return Finding(what, "wrong", f"{says}: each pulse has a phase of its own, and velocities mean nothing", remedy)


def _runs(turn: xr.Dataset) -> tuple[float, float] | None:
    """Median coherence of strong echoes from a pulse to the same antenna's next, and how much of it is left where the
    direction is to hold over a run of pulses, freed of what as many random ones leave. None where there are too few."""
    voltage, sender = turn["voltage"].values, np.asarray(turn["transmitter"].values)
    time, interval = np.asarray(turn["time"].values, dtype=np.float64), 1.0 / float(turn.attrs["prf_hz"])
    heard = sampled(voltage)[:, 0]
    early, late = _next_of_the_same(heard, sender, time, interval)
    early, late = early[:_MOST_PAIRS], late[:_MOST_PAIRS]
    if early.size < _PULSES * _FEWEST:
        return None
    cross, power = _blocks(voltage[:, 0], early, late)
    count = early.size // _PULSES
    runs = [each[: count * _PULSES].reshape(count, _PULSES, -1) for each in (cross, power)]
    noise = float(turn.attrs["noise_power_w"]) * _GATES
    strong = runs[1].mean(axis=1) > max(noise * 10.0 ** (0.1 * _STRONG_DB), 0.0)
    with np.errstate(invalid="ignore", divide="ignore"):
        lasts = np.abs(runs[0]).sum(axis=1) / runs[1].sum(axis=1)
        steady = np.abs(np.mean(runs[0] / np.abs(runs[0]), axis=1)) ** 2
    known = strong & np.isfinite(lasts) & np.isfinite(steady) & (lasts > _LASTING)
    if np.count_nonzero(known) < _FEWEST:
        return None
    # The squared mean of N unit phasors of coherence c is c² + (1 − c²)/N.
    square = (float(np.mean(steady[known])) - 1.0 / _PULSES) / (1.0 - 1.0 / _PULSES)
    return float(np.median(lasts[known])), float(np.sqrt(max(square, 0.0)))


def _next_of_the_same(
    heard: NDArray[np.bool_], sender: NDArray[np.integer], time: NDArray[np.float64], interval: float
) -> tuple[NDArray[np.intp], NDArray[np.intp]]:
    """Rows of pulses that the first receiver heard, and of the same antenna's next that it heard."""
    for cycle in range(1, _MOST_CYCLE + 1):
        early, late = rows_apart(time, cycle * interval, interval)
        good = heard[early] & heard[late] & (sender[early] == sender[late])
        if 2 * np.count_nonzero(good) > time.size // cycle:
            return early[good], late[good]
    return np.zeros(0, dtype=np.intp), np.zeros(0, dtype=np.intp)


def _blocks(
    voltage: NDArray[np.complex64], early: NDArray[np.intp], late: NDArray[np.intp]
) -> tuple[NDArray[np.complex128], NDArray[np.float64]]:
    """Sums (pair, block of gates) of later times earlier conjugate, and geometric means of both powers."""
    gates = voltage.shape[1] // _GATES * _GATES
    shape = early.size, -1, _GATES
    one, other = (np.nan_to_num(voltage[rows, :gates]).reshape(shape) for rows in (early, late))
    cross = np.asarray(np.sum(other * one.conj(), axis=2, dtype=np.complex128))
    powers = [np.sum(np.square(each.real) + np.square(each.imag), axis=2, dtype=np.float64) for each in (one, other)]
    return cross, np.sqrt(np.asarray(powers[0] * powers[1]))
