"""The inner loop of the sea's evaluation, compiled: a spline's value and derivatives in y, x and t at scattered points.

The weights of the grid points around a point are polynomials of its position between them, so any local
interpolation on a periodic grid can be given as its polynomials. A grid carries a *halo*: its first rows and columns
once more behind its last, so that what a point takes lies in rows of `LANES` neighbours, which are summed together.
Each point is summed by itself, always in the same order.
"""

from __future__ import annotations

from collections.abc import Callable

import numpy as np
from numba import njit
from numpy.typing import NDArray

from ..compute.compiled import compiled
from ..compute.lanes import LANES, add, dot, load, prefetch, store, zeros

DERIVATIVES = ((0, 0, 0), (0, 0, 1), (1, 0, 0), (0, 1, 0), (2, 0, 0), (1, 1, 0), (0, 2, 0))
"""How often each value of the kernel is differentiated along rows, columns and time."""
_AHEAD = 4  # points by which memory is prefetched: a grid is larger than the cache


def spline_kernel(
    row_weights: NDArray[np.float32], column_weights: NDArray[np.float32], time_weights: NDArray[np.float32], most: int
) -> Callable[..., None]:
    """The kernel of one interpolation. Weights: (derivative, power, tap), as `spline.bspline_polynomials` gives them.

    most: the highest derivative in space that is summed, 0 to 2; the values of higher ones are zero. Raises ValueError
    for more taps along an axis than LANES.
    """
    rows, columns, time_taps = (weights.shape[2] for weights in (row_weights, column_weights, time_weights))
    if max(rows, columns, time_taps) > LANES:
        raise ValueError(f"taps = {max(rows, columns, time_taps)}: must be at most {LANES}; lower the spline's order")
    row_polynomials, column_polynomials, time_polynomials = (
        np.pad(weights, ((0, 0), (0, 0), (0, LANES - weights.shape[2])))
        for weights in (row_weights, column_weights, time_weights)
    )

    # The loops have constant lengths and keep their sums in registers: that is what makes the compiled code fast.
    def kernel(grids, x, y, knot_time, per_metre, periodic_rows, points, scale, output_row, result):
        """Write the values of `points` times `scale` into the rows `output_row` of the result; −1 leaves one out.

        grids: one (row, column) with its halo for each knot around the points' time interval. x, y in metres,
        per_metre: grid points along rows and columns; periodic_rows: the number of the grids' first row, and how many
        there are until they come again; knot_time: t in time steps. scale and output_row: one for each of
        DERIVATIVES.
        """
        row_weight = np.empty((most + 1, LANES), np.float32)
        time_weight = np.empty((2, LANES), np.float32)
        stride = grids[0].shape[1]
        column_count = stride - (LANES - 1)
        starts = np.empty(points.size, np.int64)
        for number, n in enumerate(points):
            row = _first(y[n] * per_metre[0], rows, periodic_rows[0], periodic_rows[1])
            starts[number] = row * stride + _first(x[n] * per_metre[1], columns, 0, column_count)
        for number, n in enumerate(points):
            start, later = starts[number], starts[min(number + _AHEAD, points.size - 1)]
            for tap in range(time_taps):
                for i in range(rows):
                    prefetch(grids[tap], later + i * stride)
            north, east = _fraction(y[n] * per_metre[0]), _fraction(x[n] * per_metre[1])
            for derivative in range(most + 1):
                store(row_weight, derivative * LANES, _weights(row_polynomials, derivative, north))
            for derivative in range(2):
                weights = _weights(time_polynomials, derivative, _fraction(knot_time[n]))
                store(time_weight, derivative * LANES, weights)
            s = s_t = s_y = s_yy = zeros()
            for tap in range(time_taps):
                grid = grids[tap]
                q = q_y = q_yy = zeros()
                for i in range(rows):
                    coefficients = load(grid, start + i * stride)
                    q = add(q, row_weight[0, i], coefficients)
                    if most > 0:
                        q_y = add(q_y, row_weight[1, i], coefficients)
                    if most > 1:
                        q_yy = add(q_yy, row_weight[2, i], coefficients)
                s = add(s, time_weight[0, tap], q)
                s_t = add(s_t, time_weight[1, tap], q)
                s_y = add(s_y, time_weight[0, tap], q_y)
                s_yy = add(s_yy, time_weight[0, tap], q_yy)
            v = v_t = v_y = v_x = v_yy = v_yx = v_xx = np.float32(0.0)
            column, column_x = _weights(column_polynomials, 0, east), zeros()
            v, v_t = dot(column, s), dot(column, s_t)
            if most > 0:
                column_x = _weights(column_polynomials, 1, east)
                v_y, v_x = dot(column, s_y), dot(column_x, s)
            if most > 1:
                column_xx = _weights(column_polynomials, 2, east)
                v_yy, v_yx, v_xx = dot(column, s_yy), dot(column_x, s_y), dot(column_xx, s)
            values = (v, v_t, v_y, v_x, v_yy, v_yx, v_xx)
            for m in range(len(values)):
                if output_row[m] >= 0:
                    result[output_row[m], n] = scale[m] * values[m]

    return compiled(kernel)


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
    value = load(polynomials, start + (powers - 1) * LANES)
    for power in range(powers - 2, -1, -1):
        value = add(load(polynomials, start + power * LANES), fraction, value)
    return value
