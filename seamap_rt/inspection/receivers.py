"""The two receivers' samples themselves: whether they are two complex voltages of one echo, gate by gate, and whether
phases go on from pulse to pulse as the transmitter is said to keep them.

Echoes of speckle are circular: ⟨V²⟩ = 0, and ⟨V⟩ = 0 over a turn. Of two receivers of one echo V_l V_u* keeps its phase
from gate to gate while V_l V_u has none; with one of them conjugated it is the other way round.

Between two pulses of one antenna strong echoes turn alike, a little by their velocities, and what the transmitter does
to them is the same in all gates. So the sum of V(n + 1) V*(n) over a few neighbouring gates is as long as their powers
let it be while the echo lasts, and its direction holds still over a dwell if the transmitter is coherent. A magnetron's
points anywhere: of random phases the mean direction of N pairs is 1/√N long.
"""

from __future__ import annotations

from typing import Any

import numpy as np
import xarray as xr
from numpy.typing import NDArray

from ..interferometry.products import rows_apart, sampled
from .findings import Finding

Complex = NDArray[np.complex128]

_MOST_PULSES = 4096  # spread over the turn
_SAME = 0.999  # correlation of all samples: noise of two receivers alone keeps it lower, and so do phases that change
_NOTHING = 1e-4  # of the other receiver's power
_ONE_SIDED = 0.5  # |⟨V²⟩|/⟨|V|²⟩: 0 of speckle, 1 of real numbers
_CONSTANT = 0.5  # of the power, by the mean voltage of each gate
_APART = 3  # gates whose speckle is nearly independent
_CLEARER = 2.0
_LEAST_PHASE = 0.2
_LAGS = 4  # gates
_BETTER = 1.2
_WHAT = "receivers' samples"


def receivers(turn: xr.Dataset) -> Finding:
    """The gravest finding on the receivers by one turn's echoes, voltages loaded; checks run in this order."""
    lower, upper, both = _samples(turn)
    turning = str(turn.attrs.get("scan", "turning")) == "turning"
    return (
        _silent(lower, upper)
        or (_same(lower, upper) if both else None)
        or (_check_conjugated(lower, upper) if both else None)
        or ((_constant("lower", lower) or _constant("upper", upper)) if turning else None)
        or _real("lower", lower)
        or _real("upper", upper)
        or (_displaced(lower, upper) if both else None)
        or Finding(_WHAT, "good", "two complex voltages of the same gates")
    )


def _samples(turn: xr.Dataset) -> tuple[Complex, Complex, bool]:
    """(pulse, gate) of either receiver, of pulses that one transmitter sent; and whether both sampled the same ones."""
    voltage: NDArray[Any] = turn["voltage"].values
    sent = np.asarray(turn["transmitter"].values)
    of_one = np.flatnonzero(sent == sent[0])
    sampled = [of_one[np.isfinite(voltage[of_one, each]).any(axis=1)] for each in (0, 1)]
    together = np.intersect1d(sampled[0], sampled[1])
    both = together.size > 1
    if not both:  # alternating pulses: each receiver has its own
        sampled = [np.flatnonzero(np.isfinite(voltage[:, each]).any(axis=1)) for each in (0, 1)]
    rows = [together, together] if both else sampled
    few = [
        row[np.linspace(0, row.size - 1, min(row.size, _MOST_PULSES)).astype(int)] if row.size else row for row in rows
    ]
    lower, upper = (np.nan_to_num(voltage[row, each]).astype(np.complex128) for each, row in enumerate(few))
    return lower, upper, both


def _power(voltage: Complex) -> float:
    return float(np.mean(np.abs(voltage) ** 2)) if voltage.size else 0.0


def _silent(lower: Complex, upper: Complex) -> Finding | None:
    powers = {"lower": _power(lower), "upper": _power(upper)}
    most = max(powers.values())
    if most == 0.0:
        return Finding(_WHAT, "wrong", "both are zero everywhere", "look what the recorder wrote")
    least = min(powers, key=lambda name: powers[name])
    if powers[least] < _NOTHING * most:
        return Finding(_WHAT, "wrong", f"the {least} receiver holds nothing", "check its cable, and its array's name")
    return None


def _same(lower: Complex, upper: Complex) -> Finding | None:
    scale = float(np.sqrt(_power(lower) * _power(upper)))
    if scale > 0.0 and abs(np.mean(lower * upper.conj())) > _SAME * scale:
        remedy = "give each receiver's own array as lower and upper"
        return Finding(_WHAT, "wrong", "both hold the same signal, so no phase between them tells a height", remedy)
    return None


def _check_conjugated(lower: Complex, upper: Complex) -> Finding | None:
    straight, crossed = (_phase_kept(lower * each) for each in (upper.conj(), upper))
    if crossed > max(_CLEARER * straight, _LEAST_PHASE):
        says = (
            f"one is conjugated: from gate to gate V V keeps its phase ({crossed:.2f}), V V* does not ({straight:.2f})"
        )
        return Finding(_WHAT, "wrong", says, "conjugate one of the two arrays (or exchange its I and Q)")
    return None


def _phase_kept(product: Complex) -> float:
    """How far the phase of a product of voltages is that of the gate beside it: 0 to 1."""
    if product.shape[1] <= _APART:
        return 0.0
    beside = product[:, _APART:] * product[:, :-_APART].conj()
    total = float(np.abs(beside).sum())
    return float(np.abs(beside.sum(axis=0)).sum()) / total if total > 0.0 else 0.0


def _constant(name: str, voltage: Complex) -> Finding | None:
    share = float(np.mean(np.abs(voltage.mean(axis=0)) ** 2)) / _power(voltage)
    says = f"{100.0 * share:.0f} % of the {name} receiver's power is a constant"
    remedy = "take the offsets of I and Q off; what stands still buries the sea"
    return Finding(_WHAT, "doubtful", says, remedy) if share > _CONSTANT else None


def _real(name: str, voltage: Complex) -> Finding | None:
    share = float(np.abs(np.mean(voltage**2))) / _power(voltage)
    says = f"I and Q of the {name} receiver are no quadratures (|⟨V²⟩| = {share:.2f} of the power)"
    remedy = "give complex voltages, or both of I and Q"
    return Finding(_WHAT, "doubtful", says, remedy) if share > _ONE_SIDED else None


def _displaced(lower: Complex, upper: Complex) -> Finding | None:
    """Power of either receiver fluctuates alike where both sample the same gates."""
    one, two = (np.log(np.abs(each) ** 2 + 1e-3 * _power(each)) for each in (lower, upper))
    one, two = (each - each.mean(axis=0) for each in (one, two))
    gates = one.shape[1] - 2 * _LAGS
    if gates < 2 * _LAGS:
        return None
    middle, lags = one[:, _LAGS : _LAGS + gates], range(-_LAGS, _LAGS + 1)
    alike = {lag: float(np.mean(middle * two[:, _LAGS + lag : _LAGS + lag + gates])) for lag in lags}
    best = max(alike, key=lambda lag: alike[lag])
    if best and alike[best] > _BETTER * alike[0]:
        says = f"the upper receiver's gates lie {abs(best)} {'behind' if best > 0 else 'before'} the lower one's"
        return Finding(_WHAT, "doubtful", says, "shift one of the arrays by so many gates")
    return None


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
    """The finding on the transmitter by one turn's echoes, voltages loaded."""
    what = "phase from pulse to pulse"
    runs = _runs(turn)
    if runs is None:
        return Finding(what, "unknown", "too few strong echoes last from one pulse to the next")
    lasting, left = runs
    magnetron = str(turn.attrs.get("transmitter", "coherent")) == "magnetron"
    measured = magnetron and bool(turn.attrs.get("coherent_on_receive", 0))
    says = f"the transmitter leaves {left:.2f} of it, where {lasting:.2f} of the echo lasts"
    if magnetron and not measured:
        if left < _RANDOM:
            return Finding(what, "good", f"{says}: random, as of a magnetron, and not used")
        remedy = "set transmitter = 'coherent' in the header, or coherent_on_receive, to have velocities"
        return Finding(what, "unknown", f"{says}: it could be used", remedy)
    stated = np.radians(float(turn.attrs.get("transmit_phase_error_deg", 0.0))) if measured else 0.0
    if left > _STEADY * np.exp(-(stated**2)):
        return Finding(what, "good", says)
    if left > _RANDOM:
        return Finding(what, "doubtful", f"{says}, as errors of {np.degrees(np.sqrt(-np.log(left))):.0f}° do", _MEASURE)
    remedy = _MEASURE if measured else _MAGNETRON
    return Finding(what, "wrong", f"{says}: each pulse has a phase of its own, and velocities mean nothing", remedy)


def _runs(turn: xr.Dataset) -> tuple[float, float] | None:
    """Median coherence of strong echoes from a pulse to the same antenna's next, and how much of it is left where the
    direction is to hold over a run of pulses, freed of what as many random ones leave. None where there are too few."""
    voltage, sender = turn["voltage"].values, np.asarray(turn["transmitter"].values)
    time, interval = np.asarray(turn["time"].values, dtype=np.float64), 1.0 / float(turn.attrs["prf_hz"])
    received = sampled(voltage)[:, 0]
    early, late = _next_pulses(received, sender, time, interval)
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


def _next_pulses(
    received: NDArray[np.bool_], sender: NDArray[np.integer], time: NDArray[np.float64], interval: float
) -> tuple[NDArray[np.intp], NDArray[np.intp]]:
    """Rows of pulses that the first receiver heard, and of the same antenna's next that it heard."""
    for cycle in range(1, _MOST_CYCLE + 1):
        early, late = rows_apart(time, cycle * interval, interval)
        good = received[early] & received[late] & (sender[early] == sender[late])
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
