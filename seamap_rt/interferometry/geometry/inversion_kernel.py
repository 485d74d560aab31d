"""The inner loops between phase and point, compiled: a row of gates at a time, all its gates together.

What a look's fan is described by lies in one array (part, look or 1, gate or 1), its first parts named here; three more
follow for each further transmitter. Where the gate's range asks for a fixed point, each row settles by itself.
"""

from __future__ import annotations

import numpy as np

from ...compute.compiled import compiled, compiled_step

HEIGHT, ALONG, UP, LENGTH, RISE_ALONG, RISE_UP, OUT_ALONG, OUT_UP, RIGHT, OTHERS = range(10)

_STEPS = 40  # of the fixed point at most; each gains a factor of about B/R
_PRECISION = 4.0 * np.finfo(np.float64).eps


@compiled
def locate_rows(begin, end, gate, difference, fan, share, weights, points, gain):
    """Fill rows begin … end of points (3, look, gate), height, out and right [m], and of gain (look, gate): |dz/dη| of
    the fan over |dΔR/dη|, the elevation η in it, at the range R₁.

    gate and difference ΔR [m] (look or 1, gate or 1); share of ΔR in a gate's range, and weights (other,) of that by
    which other transmitters are farther.
    """
    row, (axis, (lower, after, along, up)) = _row(fan, gain), np.empty((2, 4, gain.shape[1]))
    for i in range(begin, end):
        _fill(row, fan, gate, difference, i, i == begin)
        if i == begin or fan.shape[1] > 1:
            _axis(row[ALONG], row[UP], axis)
        ranges, delta = row[-2], row[-1]
        for j in range(np.uint64(lower.size)):
            lower[j] = ranges[j] - share * delta[j]
        _sight(row[LENGTH], axis, lower, delta, along, up)
        if weights.size:
            for _ in range(_STEPS):
                _without_more(row, lower, delta, share, weights, along, up, after)
                settled = _settled(lower, after, ranges)
                _copy(after, lower)
                _sight(row[LENGTH], axis, lower, delta, along, up)
                if settled:
                    break
        for j in range(np.uint64(lower.size)):
            rise = row[RISE_ALONG, j] * along[j] + row[RISE_UP, j] * up[j]
            points[0, i, j] = row[HEIGHT, j] + lower[j] * rise
            points[1, i, j] = lower[j] * (row[OUT_ALONG, j] * along[j] + row[OUT_UP, j] * up[j])
            points[2, i, j] = lower[j] * (row[RIGHT, j] * up[j])
            climb = row[RISE_UP, j] * along[j] - row[RISE_ALONG, j] * up[j]
            gain[i, j] = abs(climb / (row[UP, j] * along[j] - row[ALONG, j] * up[j]))


@compiled
def difference_rows(begin, end, gate, height, fan, share, weights, difference):
    """Fill rows begin … end of ΔR [m] (look, gate) of the fan's points at `height` [m]; arguments as above."""
    row, (axis, (lower, after, along, up)) = _row(fan, difference), np.empty((2, 4, difference.shape[1]))
    for i in range(begin, end):
        _fill(row, fan, gate, height, i, i == begin)
        if i == begin or fan.shape[1] > 1:
            _axis(row[RISE_ALONG], row[RISE_UP], axis)
        ranges, drop, delta = row[-2], row[-1], difference[i]
        for j in range(np.uint64(lower.size)):
            drop[j] = row[HEIGHT, j] - drop[j]
            lower[j] = ranges[j]
        for _ in range(_STEPS):
            for j in range(np.uint64(lower.size)):
                cosine = -drop[j] * axis[3, j] / lower[j]
                cosine = -1.0 if cosine < -1.0 else cosine  # straight below, where the fan does not reach so far up
                along[j], up[j] = _direction(axis, j, cosine)
                delta[j] = _farther(row[ALONG, j], row[UP, j], row[LENGTH, j], lower[j], along[j], up[j])
            _without_more(row, lower, delta, share, weights, along, up, after)
            settled = _settled(lower, after, ranges)
            _copy(after, lower)
            if settled:
                break


@compiled_step
def _row(fan, like):
    """Room for a look's fan, its gates' ranges and one more field."""
    return np.empty((fan.shape[0] + 2, like.shape[1]))


@compiled_step
def _fill(row, fan, gate, field, look, first):
    if first or fan.shape[1] > 1:
        for part in range(fan.shape[0]):
            _spread(row[part], fan[part], look)
    if first or gate.shape[0] > 1:
        _spread(row[-2], gate, look)
    _spread(row[-1], field, look)


@compiled_step
def _spread(row, field, look):
    """One row of a field (look or 1, gate or 1)."""
    own = field[min(look, field.shape[0] - 1)]
    if own.size == 1:
        for j in range(np.uint64(row.size)):  # a loop: to assign slices takes the compiler a second each
            row[j] = own[0]
    else:
        _copy(own, row)


@compiled_step
def _copy(given, row):
    for j in range(np.uint64(row.size)):
        row[j] = given[j]


@compiled_step
def _axis(along, up, axis):
    """Of vectors in the plane: their direction, on which side of it lies the one in front, or, of a vector that points
    ahead, the one below; and one over their length."""
    for j in range(np.uint64(along.size)):
        inverse = 1.0 / np.sqrt(along[j] * along[j] + up[j] * up[j])
        ahead = 1.0 if along[j] > 0.0 else (-1.0 if along[j] < 0.0 else 0.0)
        axis[0, j], axis[1, j], axis[3, j] = along[j] * inverse, up[j] * inverse, inverse
        axis[2, j] = 1.0 if up[j] > 0.0 else (-1.0 if up[j] < 0.0 else ahead)


@compiled_step
def _sight(length, axis, lower, delta, along, up):
    """The line of sight in the plane of the fan: û·b = −ΔR + (|b|² − ΔR²)/(2R₁)."""
    for j in range(np.uint64(lower.size)):
        projection = (length[j] ** 2 - delta[j] ** 2) * 0.5 / lower[j] - delta[j]
        along[j], up[j] = _direction(axis, j, projection * axis[3, j])


@compiled_step
def _without_more(row, lower, delta, share, weights, along, up, after):
    """R₁ of a gate's range by what this has more than that, at the R₁ so far."""
    for j in range(np.uint64(lower.size)):
        after[j] = row[-2, j] - share * delta[j]
    for n in range(weights.size):
        at = OTHERS + 3 * n
        for j in range(np.uint64(lower.size)):
            more = _farther(row[at, j], row[at + 1, j], row[at + 2, j], lower[j], along[j], up[j])
            after[j] -= weights[n] * more


@compiled_step
def _settled(lower, after, ranges):
    most = 0.0
    for j in range(np.uint64(lower.size)):
        beyond = abs(after[j] - lower[j]) - _PRECISION * ranges[j]
        most = beyond if beyond > most else most
    return most == 0.0


@compiled_step
def _direction(axis, j, cosine):
    """(cos η, sin η) of the direction in the plane at an angle of this cosine to the axis; NaN where there is none."""
    sine = np.sqrt((1.0 - cosine) * (1.0 + cosine)) * axis[2, j]
    return cosine * axis[0, j] + sine * axis[1, j], cosine * axis[1, j] - sine * axis[0, j]


@compiled_step
def _farther(along, up, length, lower, sight_along, sight_up):
    """By how much [m] a point at range `lower` in that direction is farther from an antenna than from the lower one."""
    square = length * length - 2.0 * lower * (along * sight_along + up * sight_up)
    rest = lower * lower + square
    return square / (lower + np.sqrt(rest if rest > 0.0 else 0.0))
