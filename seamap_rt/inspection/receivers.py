"""The two receivers' samples themselves: whether they are two complex voltages of one echo, gate by gate.

Echoes of speckle are circular: ⟨V²⟩ = 0, and ⟨V⟩ = 0 over a turn. Of two receivers of one echo V_l V_u* keeps its phase
from gate to gate while V_l V_u has none; with one of them conjugated it is the other way round.
"""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import numpy as np
import xarray as xr
from numpy.typing import NDArray

from .heights import Finding

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
    """Of one turn's echoes, voltages loaded. The gravest of what is found, in this order."""
    lower, upper, both = _samples(turn)
    turning = str(turn.attrs.get("scan", "turning")) == "turning"
    checks: list[Callable[[], Finding | None]] = [lambda: _silent(lower, upper)]
    if both:
        checks += [lambda: _same(lower, upper), lambda: _one_conjugated(lower, upper)]
    if turning:
        checks += [lambda: _constant(lower, upper)]
    checks += [lambda: _real(lower, upper)]
    if both:
        checks += [lambda: _displaced(lower, upper)]
    for check in checks:
        found = check()
        if found is not None:
            return found
    return Finding(_WHAT, "good", "two complex voltages of the same gates")


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
    for name, power in powers.items():
        if power < _NOTHING * most:
            return Finding(
                _WHAT, "wrong", f"the {name} receiver holds nothing", "check its cable, and its array's name"
            )
    return None


def _same(lower: Complex, upper: Complex) -> Finding | None:
    scale = float(np.sqrt(_power(lower) * _power(upper)))
    if scale > 0.0 and abs(np.mean(lower * upper.conj())) > _SAME * scale:
        remedy = "give each receiver's own array as lower and upper"
        return Finding(_WHAT, "wrong", "both hold the same signal, so no phase between them tells a height", remedy)
    return None


def _one_conjugated(lower: Complex, upper: Complex) -> Finding | None:
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


def _constant(lower: Complex, upper: Complex) -> Finding | None:
    for name, voltage in (("lower", lower), ("upper", upper)):
        share = float(np.mean(np.abs(voltage.mean(axis=0)) ** 2)) / _power(voltage)
        if share > _CONSTANT:
            says = f"{100.0 * share:.0f} % of the {name} receiver's power is a constant"
            return Finding(_WHAT, "doubtful", says, "take the offsets of I and Q off; what stands still buries the sea")
    return None


def _real(lower: Complex, upper: Complex) -> Finding | None:
    for name, voltage in (("lower", lower), ("upper", upper)):
        share = float(np.abs(np.mean(voltage**2))) / _power(voltage)
        if share > _ONE_SIDED:
            says = f"I and Q of the {name} receiver are no quadratures (|⟨V²⟩| = {share:.2f} of the power)"
            return Finding(_WHAT, "doubtful", says, "give complex voltages, or both of I and Q")
    return None


def _displaced(lower: Complex, upper: Complex) -> Finding | None:
    """Power of either receiver fluctuates alike where both sample the same gates."""
    one, two = (np.log(np.abs(each) ** 2 + 1e-3 * _power(each)) for each in (lower, upper))
    one, two = (each - each.mean(axis=0) for each in (one, two))
    gates = one.shape[1] - 2 * _LAGS
    if gates < 2 * _LAGS:
        return None
    middle = one[:, _LAGS : _LAGS + gates]
    alike = {
        lag: float(np.mean(middle * two[:, _LAGS + lag : _LAGS + lag + gates])) for lag in range(-_LAGS, _LAGS + 1)
    }
    best = max(alike, key=lambda lag: alike[lag])
    if best and alike[best] > _BETTER * alike[0]:
        says = f"the upper receiver's gates lie {abs(best)} {'behind' if best > 0 else 'before'} the lower one's"
        return Finding(_WHAT, "doubtful", says, "shift one of the arrays by so many gates")
    return None
