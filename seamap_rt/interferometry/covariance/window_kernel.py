"""Means over windows of neighbouring cells, whose phases may first be brought to the cell's own."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from ...compute.compiled import compiled, compiled_step


class Cells(NamedTuple):
    """A covariance (look, gate) whose unknown cells are 0."""

    cross: NDArray[np.complex128]
    lower: NDArray[np.float64]
    upper: NDArray[np.float64]
    known: NDArray[np.float64]  # 1 or 0


class Phasors(NamedTuple):
    """What turns a neighbour's phase on to the cell's."""

    per_gate: NDArray[np.complex128]  # (look or 1, gate)
    per_look: NDArray[np.complex128]  # (look or 1, gate)
    level: NDArray[np.complex128]  # (offset, look, gate) of the sea so many gates on, as seen from the cell; or none


@compiled
def window_means(begin, end, cells, range_weights, look_weights, phasors, cross, lower, upper):
    """Fill looks begin … end of the means cross, lower, upper (look, gate), NaN of unknown cells; of a window that
    shrinks on both sides alike at edges and beside unknown cells."""
    looks, gates = cells.known.shape
    half_range, half_look = range_weights.size // 2, look_weights.size // 2
    phasor, total = np.empty(gates, np.complex128), np.empty(gates)
    for look in range(begin, end):
        _clear(look, cross, lower, upper, total)
        per_gate = phasors.per_gate[look % len(phasors.per_gate)]
        per_look = phasors.per_look[look % len(phasors.per_look)]
        reach = min(half_look, look, looks - 1 - look)
        for n in range(-reach, reach + 1):
            phasor[:] = 1.0
            for _ in range(abs(n)):
                _rotate(phasor, per_look, n > 0)
            for m in range(half_range):
                _rotate(phasor, per_gate, False)
            for m in range(-half_range, half_range + 1):
                weight = range_weights[m + half_range] * look_weights[n + half_look]
                inside = max(0, gates - 2 * abs(m))
                here, there, opposite = abs(m), abs(m) + m, abs(m) - m
                known, back = cells.known[look + n, there:], cells.known[look - n, opposite:]
                value, low, up = (
                    cells.cross[look + n, there:],
                    cells.lower[look + n, there:],
                    cells.upper[look + n, there:],
                )
                turn, sums = phasor[here:], (cross[look, here:], lower[look, here:], upper[look, here:], total[here:])
                if phasors.level.shape[0] > 0:
                    level = phasors.level[m + half_range, look, here:]
                    for gate in range(inside):
                        share = weight * (known[gate] * back[gate])
                        sums[0][gate] += share * (value[gate] * level[gate] * turn[gate])
                else:
                    for gate in range(inside):
                        share = weight * (known[gate] * back[gate])
                        sums[0][gate] += share * (value[gate] * turn[gate])
                for gate in range(inside):
                    share = weight * (known[gate] * back[gate])
                    sums[1][gate] += share * low[gate]
                    sums[2][gate] += share * up[gate]
                    sums[3][gate] += share
                _rotate(phasor, per_gate, True)
        _divide(look, cells.known[look], total, cross, lower, upper)


@compiled
def window_means_as_they_are(begin, end, cells, range_weights, look_weights, cross, lower, upper):
    """The same without turning any phase, over all cells of the window that are known, whatever lies opposite."""
    looks, gates = cells.known.shape
    half_range, half_look = range_weights.size // 2, look_weights.size // 2
    total = np.empty(gates)
    for look in range(begin, end):
        _clear(look, cross, lower, upper, total)
        for n in range(max(-half_look, -look), min(half_look, looks - 1 - look) + 1):
            for m in range(-half_range, half_range + 1):
                weight = range_weights[m + half_range] * look_weights[n + half_look]
                here, there, inside = max(0, -m), max(0, m), gates - abs(m)
                known, value = cells.known[look + n, there:], cells.cross[look + n, there:]
                low, up = cells.lower[look + n, there:], cells.upper[look + n, there:]
                sums = cross[look, here:], lower[look, here:], upper[look, here:], total[here:]
                for gate in range(inside):
                    sums[0][gate] += weight * value[gate]
                for gate in range(inside):
                    sums[1][gate] += weight * low[gate]
                    sums[2][gate] += weight * up[gate]
                    sums[3][gate] += weight * known[gate]
        _divide(look, cells.known[look], total, cross, lower, upper)


@compiled
def window_powers(begin, end, power, known, range_weights, look_weights, means):
    """Fill looks begin … end of means (look, gate) of a power, 0 where it is not known, over such a window as
    `window_means` has."""
    looks, gates = known.shape
    half_range, half_look = range_weights.size // 2, look_weights.size // 2
    total = np.empty(gates)
    for look in range(begin, end):
        means[look, :], total[:] = 0.0, 0.0
        reach = min(half_look, look, looks - 1 - look)
        for n in range(-reach, reach + 1):
            for m in range(-half_range, half_range + 1):
                weight = range_weights[m + half_range] * look_weights[n + half_look]
                here, there, opposite = abs(m), abs(m) + m, abs(m) - m
                mine, back, value = known[look + n, there:], known[look - n, opposite:], power[look + n, there:]
                mean, sums = means[look, here:], total[here:]
                for gate in range(max(0, gates - 2 * abs(m))):
                    share = weight * (mine[gate] * back[gate])
                    mean[gate] += share * value[gate]
                    sums[gate] += share
        for gate in range(gates):
            means[look, gate] *= known[look, gate] / (known[look, gate] * total[gate])


@compiled_step
def _clear(look, cross, lower, upper, total):
    cross[look, :], lower[look, :], upper[look, :], total[:] = 0.0, 0.0, 0.0, 0.0


@compiled_step
def _divide(look, known, total, cross, lower, upper):
    """Sums of a look into means; NaN of unknown cells."""
    for gate in range(total.size):
        share = known[gate] / (known[gate] * total[gate])
        cross[look, gate] *= share
        lower[look, gate] *= share
        upper[look, gate] *= share


@compiled_step
def _rotate(phasor, by, forward):
    """Multiply phasors by others, or by their conjugates."""
    if forward:
        for n in range(phasor.size):
            phasor[n] *= by[n]
    else:
        for n in range(phasor.size):
            phasor[n] *= np.conj(by[n])
