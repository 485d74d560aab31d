"""The inner loop of the sea's evaluation, compiled: a spline's value and derivatives in y, x and t at scattered points.

The weights of the grid points around a point are polynomials of its position between them, so any local
interpolation on a periodic grid can be given as its polynomials. A grid carries a *halo*: its first rows and columns
once more behind its last, so that what a point takes lies in rows of `LANES` neighbours, which are summed together.

The knots are summed first, then rows and columns. Points that follow each other at the same time, as those of a mesh's
column do, share the first sum where they take from the same grid points, a *tile* of them: it is most of the work.
Each sum is formed in the same order, whichever points share it.

`phasor` and `half_plane` move waves that run along +k and along −k in time, and make them ready for a real FFT.
"""

from __future__ import annotations

from collections.abc import Callable

import numpy as np
from numba import njit
from numpy.typing import NDArray

from ..compute.compiled import compiled
from ..compute.lanes import add, dot, load, prefetch, store, zeros

LANES = 8  # neighbours that are summed together
_TILE = 2 * LANES  # rows and columns: more are too far from a diagonal column's points, fewer are shared by too few


def spline_kernel(
    row_weights: NDArray[np.float32], column_weights: NDArray[np.float32], time_taps: int
) -> Callable[..., None]:
    """The kernel of one interpolation. Weights: (derivative, power, tap), as `spline.bspline_polynomials` gives them.

    Raises ValueError for more taps along an axis than LANES.
    """
    rows, columns = row_weights.shape[2], column_weights.shape[2]
    if max(rows, columns, time_taps) > LANES:
        raise ValueError(f"taps = {max(rows, columns, time_taps)}: must be at most {LANES}; lower the spline's order")
    row_polynomials, column_polynomials = pad_to_lanes(row_weights), pad_to_lanes(column_weights)

    # The loops have constant lengths and keep their sums in registers: that is what makes the compiled code fast.
    def kernel(grids, places, per_metre, periodic_rows, points, in_time, scale, output_row, result):
        """Write the values of `points` times `scale` into the rows `output_row` of the result; −1 leaves one out.

        grids: one (row, column) with its halo for each knot around the points' time interval. places: x and y in
        metres, t in time steps. per_metre: grid points along rows and columns; periodic_rows: the number of the grids'
        first row, and how many there are until they come again. in_time: weights of the knots (sum, power, tap in
        LANES), of each sum over them that is wanted. scale: one for each of `sums.DERIVATIVES`, and output_row (sum,
        derivative).
        """
        x, y, knot_time = places
        sums, stride = in_time.shape[0], grids[0].shape[1]
        row_weight, time_weight = np.empty((3, LANES), np.float32), np.zeros((sums + 1, LANES), np.float32)
        most = np.array([_highest(output_row, n) for n in range(sums)])
        highest = most.max()
        tile = np.empty((sums + 1, _TILE, _TILE), np.float32)
        row, column = np.empty(points.size, np.int64), np.empty(points.size, np.int64)
        for number, n in enumerate(points):
            row[number] = _first(y[n] * per_metre[0], rows, periodic_rows[0], periodic_rows[1])
            column[number] = _first(x[n] * per_metre[1], columns, 0, stride - (LANES - 1))
        if points.size == 0:
            return
        begin = 0
        coming = _shared(row, column, knot_time, points, begin, rows)
        while begin < points.size:
            end, top, height, left, width = coming
            coming = _shared(row, column, knot_time, points, min(end, points.size - 1), rows)
            for i in range(coming[2]):
                start = (coming[1] + i) * stride + coming[3]
                for tap in range(time_taps):
                    prefetch(grids[tap], start)
                    prefetch(grids[tap], start + coming[4] - 1)
            fraction = _fraction(knot_time[points[begin]])
            for n in range(sums):
                store(time_weight, n * LANES, _weights(in_time, n, fraction))
            # Two rows of two sums at a time: coefficients and weights are loaded for two uses each.
            for i in range(0, height, 2):
                for j in range(0, width, LANES):
                    # At a row's end the last lanes are those before them once more, and so is an odd last row.
                    beside = min(left + j, stride - LANES)
                    start, to = (top + i) * stride + beside, i * _TILE + beside - left
                    start_next = start + stride if i + 1 < height else start
                    for n in range(0, sums, 2):
                        first = second = first_next = second_next = zeros(LANES)
                        for tap in range(time_taps):
                            near, next_ = load(grids[tap], start, LANES), load(grids[tap], start_next, LANES)
                            first = add(first, time_weight[n, tap], near)
                            second = add(second, time_weight[n + 1, tap], near)
                            first_next = add(first_next, time_weight[n, tap], next_)
                            second_next = add(second_next, time_weight[n + 1, tap], next_)
                        store(tile, n * _TILE * _TILE + to, first)
                        store(tile, (n + 1) * _TILE * _TILE + to, second)
                        store(tile, n * _TILE * _TILE + to + _TILE, first_next)
                        store(tile, (n + 1) * _TILE * _TILE + to + _TILE, second_next)
            for number in range(begin, end):
                n = points[number]
                north, east = _fraction(y[n] * per_metre[0]), _fraction(x[n] * per_metre[1])
                for derivative in range(highest + 1):
                    store(row_weight, derivative * LANES, _weights(row_polynomials, derivative, north))
                of_columns = _weights(column_polynomials, 0, east)
                of_columns_x = _weights(column_polynomials, 1, east)
                start = (row[number] - top) * _TILE + column[number] - left
                for each in range(sums):
                    s = s_y = s_yy = zeros(LANES)
                    for i in range(rows):
                        coefficients = load(tile, each * _TILE * _TILE + start + i * _TILE, LANES)
                        s = add(s, row_weight[0, i], coefficients)
                        if most[each] > 0:
                            s_y = add(s_y, row_weight[1, i], coefficients)
                        if most[each] > 1:
                            s_yy = add(s_yy, row_weight[2, i], coefficients)
                    if output_row[each, 0] >= 0:
                        result[output_row[each, 0], n] = scale[0] * dot(of_columns, s)
                    if output_row[each, 1] >= 0:
                        result[output_row[each, 1], n] = scale[1] * dot(of_columns, s_y)
                    if output_row[each, 2] >= 0:
                        result[output_row[each, 2], n] = scale[2] * dot(of_columns_x, s)
                    if output_row[each, 3] >= 0:
                        result[output_row[each, 3], n] = scale[3] * dot(of_columns, s_yy)
                    if output_row[each, 4] >= 0:
                        result[output_row[each, 4], n] = scale[4] * dot(of_columns_x, s_y)
                    if output_row[each, 5] >= 0:
                        result[output_row[each, 5], n] = scale[5] * dot(_weights(column_polynomials, 2, east), s)
            begin = end

    return compiled(kernel)


def pad_to_lanes(weights: NDArray) -> NDArray[np.float32]:
    """Weights (…, tap) with zeros behind the taps, as many as there are LANES."""
    return np.pad(weights.astype(np.float32), ((0, 0), (0, 0), (0, LANES - weights.shape[2])))


@njit(inline="always")
def _shared(row, column, knot_time, points, begin, rows):
    """The end of the points from `begin` on that share a tile, and the tile: first row, rows, first column, columns."""
    top = bottom = row[begin]
    left = right = column[begin]
    end = begin + 1
    while end < points.size and knot_time[points[end]] == knot_time[points[begin]]:
        low, high = min(top, row[end]), max(bottom, row[end])
        west, east = min(left, column[end]), max(right, column[end])
        if high - low + rows > _TILE or east - west + LANES > _TILE:
            break
        top, bottom, left, right = low, high, west, east
        end += 1
    return end, top, bottom - top + rows, left, right - left + LANES


@njit(inline="always")
def _highest(output_row, n):
    """The highest derivative along rows that is wanted."""
    if output_row[n, 3] >= 0:
        return 2
    return 1 if output_row[n, 1] >= 0 or output_row[n, 4] >= 0 else 0


@njit(inline="always")
def _first(position, taps, origin, count):
    """First of the grid points around a position on a periodic axis, counted from `origin`."""
    return (np.int64(np.floor(position)) - (taps - 1) // 2 - origin) % count


@njit(inline="always")
def _fraction(position):
    """How far a position lies beyond a grid point, of a step."""
    return np.float32(position - np.floor(position))


@njit(inline="always")
def _weights(polynomials, derivative, fraction):
    """The polynomials of a derivative's taps at a fraction of a step, by Horner's rule."""
    powers = polynomials.shape[1]
    start = derivative * powers * LANES
    value = load(polynomials, start + (powers - 1) * LANES, LANES)
    for power in range(powers - 2, -1, -1):
        value = add(load(polynomials, start + power * LANES, LANES), fraction, value)
    return value


def phasor(omega: NDArray[np.float64], time: float) -> NDArray[np.complex64]:
    """exp(−iωt), in the shape of omega [rad/s]; time: s.

    The phase is reduced in float64: 12 hours lose nothing.
    """
    turns = omega * (time / (2.0 * np.pi))
    turns -= np.rint(turns)
    phase = (turns * (-2.0 * np.pi)).astype(np.float32)
    made = np.empty(phase.shape, dtype=np.complex64)
    np.cos(phase, out=made.real)
    np.sin(phase, out=made.imag)
    return made


@compiled
def half_plane(ahead, behind, factor, out):
    """Write ahead·f + behind·f* into the rows of an FFT, with zeros between its positive and its negative waves.

    ahead, behind: complex64 amplitudes of the waves along k and along −k, (2m + 1, column), rows 0 … m, −m … −1;
    factor f: what is the same for all directions, (m + 1, column); out: complex64 (2m + 1 or more, column).
    """
    most, rows = factor.shape[0] - 1, ahead.shape[0]
    for row in range(rows):
        folded, to = (row, row) if row <= most else (rows - row, out.shape[0] - rows + row)
        for column in range(factor.shape[1]):
            f = factor[folded, column]
            out[to, column] = ahead[row, column] * f + behind[row, column] * np.conj(f)
    out[most + 1 : out.shape[0] - most] = 0.0
