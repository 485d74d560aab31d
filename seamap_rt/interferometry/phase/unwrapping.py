"""Which of the heights that a wrapped phase allows each cell has: grown from cell to cell, the surest first, compiled.

A cell's cycles are those that bring it nearest to what its resolved neighbours let expect: a plane through them, by
least squares, held to a height known beforehand (of the sea: its mean level, within its own size). How much more likely
these cycles are than the next best ones decides which cell is next: the growth avoids what is noisy or in shadow
before it crosses it (quality-guided path following, Ghiglia & Pritt 1998), and comes to cells that are sure by
themselves, far out, first of all. Then each cell is tested again, now with neighbours on all sides, until none changes
(iterated conditional modes, Besag 1986).
"""

from __future__ import annotations

import numpy as np

from ...compute.compiled import compiled

_LEVELS = 128  # of the queue,
_PER_NAT = 8.0  # each an eighth of the odds' natural logarithm: above e^16 they are not ordered any more
_BESIDE = 2  # looks and gates within which a new neighbour changes a cell's place in the queue
_SWEEPS = 6  # of correction at most; most maps converge after two or three


@compiled
def unwrap(folded, step, noise, expected, precision, wanted, across, layout):
    """Cycles (look, gate) to add, and the log odds of these over the next best ones.

    folded: heights [m], one cycle is `step` m; noise: their variance [m²]; expected, precision: the height known
    beforehand [m] and one over its variance; wanted: cells to resolve; across (gate,): metres between looks. layout:
    metres between gates, radius [m] and most looks of a neighbourhood, how far [m² per m²] heights stray from a plane,
    one over the variance of slopes.
    """
    cycles = np.zeros(folded.shape)
    sums = _grow(folded, step, noise, expected, precision, wanted, across, layout, cycles)
    odds = np.zeros(folded.shape)
    looks, gates = folded.shape
    for _ in range(_SWEEPS):
        converged = True
        for i in range(looks):
            for j in range(gates):
                if not wanted[i, j]:
                    continue
                mean, variance = _predict(sums[i, j], expected[i, j], precision[i, j], layout[4])
                now = folded[i, j] + cycles[i, j] * step[i, j]
                more = np.round((mean - now) / step[i, j])
                odds[i, j] = _odds(now, step[i, j], mean, variance + noise[i, j])
                if more != 0.0:
                    converged = False
                    cycles[i, j] += more
                    _tell(sums, wanted, i, j, more * step[i, j], 0.0, noise[i, j], across[j], layout)
        if converged:
            break
    return cycles, odds


@compiled
def _grow(folded, step, noise, expected, precision, wanted, across, layout, cycles):
    """Fill cycles; return the sums (look, gate, 9) over each cell's neighbours that its plane is fitted from."""
    looks, gates = folded.shape
    sums = np.zeros((looks, gates, 9))
    # The queue: cells of one level are a chain.
    first = np.full(_LEVELS, -1, np.int64)
    after, before = np.full(looks * gates, -1, np.int64), np.full(looks * gates, -1, np.int64)
    level = np.full(looks * gates, -1, np.int64)
    top = -1
    for i in range(looks):
        for j in range(gates):
            if wanted[i, j]:
                sure = _odds(folded[i, j], step[i, j], expected[i, j], 1.0 / precision[i, j] + noise[i, j])
                top = max(top, _queue(first, after, before, level, i * gates + j, sure))
    while top >= 0:
        if first[top] < 0:
            top -= 1
            continue
        cell = first[top]
        _leave(first, after, before, level, cell)
        level[cell] = -2  # resolved
        i, j = cell // gates, cell % gates
        mean, _ = _predict(sums[i, j], expected[i, j], precision[i, j], layout[4])
        cycles[i, j] = np.round((mean - folded[i, j]) / step[i, j])
        height = folded[i, j] + cycles[i, j] * step[i, j]
        _tell(sums, wanted, i, j, height, 1.0, noise[i, j], across[j], layout)
        for ii in range(max(0, i - _BESIDE), min(looks, i + _BESIDE + 1)):
            for jj in range(max(0, j - _BESIDE), min(gates, j + _BESIDE + 1)):
                beside = ii * gates + jj
                if level[beside] >= 0:
                    mean, variance = _predict(sums[ii, jj], expected[ii, jj], precision[ii, jj], layout[4])
                    sure = _odds(folded[ii, jj], step[ii, jj], mean, variance + noise[ii, jj])
                    top = max(top, _queue(first, after, before, level, beside, sure))
    return sums


@compiled
def _predict(sums, expected, precision, slope_precision):
    """Mean and variance of a height, from its neighbours and from what was known beforehand."""
    a, b, c = sums[0] + precision, sums[1], sums[2]
    d, e, f = sums[3] + slope_precision, sums[4], sums[5] + slope_precision
    aa, bb, cc = d * f - e * e, c * e - b * f, b * e - c * d
    determinant = a * aa + b * bb + c * cc
    mean = (aa * (sums[6] + precision * expected) + bb * sums[7] + cc * sums[8]) / determinant
    return mean, aa / determinant


@compiled
def _odds(height, step, mean, variance):
    """Log odds of the cycle that comes nearest to the mean over the second nearest."""
    off = (height - mean) / step
    off = abs(off - np.round(off))
    return 0.5 * step * step * (1.0 - 2.0 * off) / variance


@compiled
def _tell(sums, wanted, i, j, height, count, noise, across, layout):
    """Add a cell's height to its neighbours' sums; count = 0: a change of a height that they have already."""
    spacing, radius, most, stray = layout[0], layout[1], int(layout[2]), layout[3]
    looks, gates = wanted.shape
    aside, out = min(most, int(radius / across + 0.5)), int(radius / spacing)
    for ii in range(max(0, i - aside), min(looks, i + aside + 1)):
        for jj in range(max(0, j - out), min(gates, j + out + 1)):
            x, y = (j - jj) * spacing, (i - ii) * across
            square = x * x + y * y
            if not wanted[ii, jj] or square > radius * radius or (ii == i and jj == j):
                continue
            weight = 1.0 / (noise + stray * square)
            there, counted = sums[ii, jj], count * weight
            there[0] += counted
            there[1] += counted * x
            there[2] += counted * y
            there[3] += counted * x * x
            there[4] += counted * x * y
            there[5] += counted * y * y
            there[6] += weight * height
            there[7] += weight * height * x
            there[8] += weight * height * y


@compiled
def _queue(first, after, before, level, cell, sure):
    """Put a cell where its log odds belong; return that level."""
    new = int(min(_LEVELS - 1.0, max(0.0, sure * _PER_NAT)))
    if new != level[cell]:
        if level[cell] >= 0:
            _leave(first, after, before, level, cell)
        level[cell], before[cell], after[cell] = new, -1, first[new]
        if first[new] >= 0:
            before[first[new]] = cell
        first[new] = cell
    return new


@compiled
def _leave(first, after, before, level, cell):
    if before[cell] >= 0:
        after[before[cell]] = after[cell]
    else:
        first[level[cell]] = after[cell]
    if after[cell] >= 0:
        before[after[cell]] = before[cell]
