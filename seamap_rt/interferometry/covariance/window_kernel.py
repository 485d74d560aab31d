"""Means over windows of neighbouring cells, whose phases may first be brought to the cell's own.

Complex numbers are real and imaginary parts (part, look, gate): loops over gates then fill a processor's registers.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from ...compute.compiled import compiled, compiled_step


class Cells(NamedTuple):
    """A covariance whose unknown cells are 0."""

    fields: NDArray[np.float64]  # (4, look, gate) real and imaginary part of the cross product, both powers
    known: NDArray[np.float64]  # (look, gate) 1 or 0


class Phasors(NamedTuple):
    """What turns a neighbour's phase on to the cell's; real and imaginary parts."""

    per_gate: NDArray[np.float64]  # (part, look or 1, gate)
    per_look: NDArray[np.float64]  # (part, look or 1, gate)
    level: NDArray[np.float64]  # (part, offset, look, gate) of the sea so many gates on, as seen from the cell; or none


@compiled
def window_means(begin, end, cells, range_weights, look_weights, phasors, means):
    """Fill looks begin … end of the means (4, look, gate) of the fields, NaN of unknown cells; of a window that shrinks
    on both sides alike at edges and beside unknown cells."""
    (fields, known), (looks, gates) = cells, cells.known.shape
    half_range, half_look = range_weights.size // 2, look_weights.size // 2
    phasor, total, level = np.empty((2, gates)), np.empty(gates), phasors.level
    for look in range(begin, end):
        means[:, look], total[:] = 0.0, 0.0
        per_gate = phasors.per_gate[:, look % phasors.per_gate.shape[1]]
        per_look = phasors.per_look[:, look % phasors.per_look.shape[1]]
        reach = min(half_look, look, looks - 1 - look)
        for n in range(-reach, reach + 1):
            row, opposite = look + n, look - n
            phasor[0], phasor[1] = 1.0, 0.0
            for _ in range(abs(n)):
                _rotate(phasor, per_look, 1.0 if n > 0 else -1.0)
            for _ in range(half_range):
                _rotate(phasor, per_gate, -1.0)
            for m in range(-half_range, half_range + 1):
                weight, offset = range_weights[m + half_range] * look_weights[n + half_look], m + half_range
                away, shift = np.uint64(abs(m)), np.uint64(abs(m) + m)  # unsigned: what may be negative is slow
                for gate in range(np.uint64(max(0, gates - 2 * abs(m)))):
                    here, there, back = gate + away, gate + shift, gate + away + away - shift
                    share = weight * (known[row, there] * known[opposite, back])
                    cosine, sine = phasor[0, here], phasor[1, here]
                    if level.shape[1] > 0:
                        real, imaginary = level[0, offset, look, here], level[1, offset, look, here]
                        cosine, sine = cosine * real - sine * imaginary, cosine * imaginary + sine * real
                    real, imaginary = fields[0, row, there], fields[1, row, there]
                    means[0, look, here] += share * (real * cosine - imaginary * sine)
                    means[1, look, here] += share * (real * sine + imaginary * cosine)
                    means[2, look, here] += share * fields[2, row, there]
                    means[3, look, here] += share * fields[3, row, there]
                    total[here] += share
                _rotate(phasor, per_gate, 1.0)
        _divide(known[look], total, means[:, look])


@compiled
def window_means_as_they_are(begin, end, cells, range_weights, look_weights, means):
    """The same without turning any phase, over all cells of the window that are known, whatever lies opposite."""
    (fields, known), (looks, gates) = cells, cells.known.shape
    half_range, half_look = range_weights.size // 2, look_weights.size // 2
    total = np.empty(gates)
    for look in range(begin, end):
        means[:, look], total[:] = 0.0, 0.0
        for n in range(max(-half_look, -look), min(half_look, looks - 1 - look) + 1):
            for m in range(-half_range, half_range + 1):
                weight = range_weights[m + half_range] * look_weights[n + half_look]
                first, shift, row = np.uint64(max(0, -m)), np.uint64(max(0, m)), look + n
                inside = np.uint64(max(0, gates - abs(m)))
                for field in range(4):
                    for gate in range(inside):
                        means[field, look, gate + first] += weight * fields[field, row, gate + shift]
                for gate in range(inside):
                    total[gate + first] += weight * known[row, gate + shift]
        _divide(known[look], total, means[:, look])


@compiled
def window_powers(begin, end, power, known, range_weights, look_weights, means):
    """Fill looks begin … end of means (look, gate) of a power, 0 where it is not known, over such a window as
    `window_means` has."""
    looks, gates = known.shape
    half_range, half_look = range_weights.size // 2, look_weights.size // 2
    total = np.empty(gates)
    for look in range(begin, end):
        means[look], total[:] = 0.0, 0.0
        reach = min(half_look, look, looks - 1 - look)
        for n in range(-reach, reach + 1):
            row, opposite = look + n, look - n
            for m in range(-half_range, half_range + 1):
                weight = range_weights[m + half_range] * look_weights[n + half_look]
                away, shift = np.uint64(abs(m)), np.uint64(abs(m) + m)
                for gate in range(np.uint64(max(0, gates - 2 * abs(m)))):
                    there, back = gate + shift, gate + away + away - shift
                    share = weight * (known[row, there] * known[opposite, back])
                    means[look, gate + away] += share * power[row, there]
                    total[gate + away] += share
        _divide(known[look], total, means[look : look + 1])


@compiled_step
def _divide(known, total, sums):
    """Sums (field, gate) into means; NaN of unknown cells."""
    for gate in range(total.size):
        share = known[gate] / (known[gate] * total[gate])
        for field in range(len(sums)):
            sums[field, gate] *= share


@compiled_step
def _rotate(phasor, by, sense):
    """Turn phasors (part, gate) on by others, or back."""
    for n in range(phasor.shape[1]):
        cosine, sine = by[0, n], sense * by[1, n]
        real, imaginary = phasor[0, n], phasor[1, n]
        phasor[0, n], phasor[1, n] = real * cosine - imaginary * sine, real * sine + imaginary * cosine
