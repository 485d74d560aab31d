"""The inner loop of the sea's evaluation, compiled: a spline's value and derivatives in y, x and t at scattered points.

The weights of the grid points around a point are polynomials of its place between them, so any local interpolation on a
periodic grid can be given as its polynomials. Each point is summed by itself, always in the same order.
"""

from __future__ import annotations

from collections.abc import Callable

import numpy as np
from numba import njit
from numpy.typing import NDArray

DERIVATIVES = ((0, 0, 0), (0, 0, 1), (1, 0, 0), (0, 1, 0), (2, 0, 0), (1, 1, 0), (0, 2, 0))
"""How often each value of the kernel is differentiated along rows, columns and time."""


def spline_kernel(
    row_weights: NDArray[np.float32], column_weights: NDArray[np.float32], time_weights: NDArray[np.float32], most: int
) -> Callable[..., None]:
    """The kernel of one interpolation. Weights: (derivative, power, tap), as `spline.bspline_polynomials` gives them.

    most: the highest derivative in space that is summed, 0 to 2; the values of higher ones are zero.
    """
    rows, columns = row_weights.shape[2], column_weights.shape[2]

    # The loops have constant lengths and keep their sums in scalars: that is what makes the compiled code fast.
    def kernel(grids, x, y, knot_time, per_metre, points, scale, place, result):
        """Write the values of `points` times `scale` into the rows `place` of the result; −1 leaves one out.

        grids: one (row, column) for each knot around the points' time interval. x, y in metres, per_metre: grid points
        along rows and columns; knot_time: t in time steps. scale and place: one for each of DERIVATIVES.
        """
        row_weight = np.empty((most + 1, rows), np.float32)
        column_weight = np.empty((most + 1, columns), np.float32)
        time_weight = np.empty((2, len(grids)), np.float32)
        row, column = np.empty(rows, np.int64), np.empty(columns, np.int64)
        row_count, column_count = grids[0].shape
        for n in points:
            _taps(y[n] * per_metre[0], row_count, row_weights, row, row_weight)
            _taps(x[n] * per_metre[1], column_count, column_weights, column, column_weight)
            _weigh(np.float32(knot_time[n] - np.floor(knot_time[n])), time_weights, time_weight)
            v = v_t = v_y = v_x = v_yy = v_yx = v_xx = np.float32(0.0)
            for tap in range(len(grids)):
                grid = grids[tap]
                q = q_y = q_x = q_yy = q_yx = q_xx = np.float32(0.0)
                for i in range(rows):
                    s = s_x = s_xx = np.float32(0.0)
                    for j in range(columns):
                        coefficient = grid[row[i], column[j]]
                        s += column_weight[0, j] * coefficient
                        if most > 0:
                            s_x += column_weight[1, j] * coefficient
                        if most > 1:
                            s_xx += column_weight[2, j] * coefficient
                    q += row_weight[0, i] * s
                    if most > 0:
                        q_y += row_weight[1, i] * s
                        q_x += row_weight[0, i] * s_x
                    if most > 1:
                        q_yy += row_weight[2, i] * s
                        q_yx += row_weight[1, i] * s_x
                        q_xx += row_weight[0, i] * s_xx
                v += time_weight[0, tap] * q
                v_t += time_weight[1, tap] * q
                v_y += time_weight[0, tap] * q_y
                v_x += time_weight[0, tap] * q_x
                v_yy += time_weight[0, tap] * q_yy
                v_yx += time_weight[0, tap] * q_yx
                v_xx += time_weight[0, tap] * q_xx
            values = (v, v_t, v_y, v_x, v_yy, v_yx, v_xx)
            for m in range(len(values)):
                if place[m] >= 0:
                    result[place[m], n] = scale[m] * values[m]

    return _compiled(kernel)


def _compiled(kernel: Callable[..., None]) -> Callable[..., None]:
    options = {"nogil": True, "fastmath": {"contract"}}  # sums keep their order, so that bits stay the same
    try:
        return njit(cache=True, **options)(kernel)
    except RuntimeError:  # no folder to keep the compiled code in: each process compiles it again
        return njit(**options)(kernel)


@njit(inline="always")
def _taps(position, count, polynomials, index, weight):
    """Grid points around a position on a periodic axis, and their weights."""
    whole = np.floor(position)
    _weigh(np.float32(position - whole), polynomials, weight)
    at = (np.int64(whole) - (index.size // 2 - 1)) % count
    for tap in range(index.size):
        index[tap] = at
        at = at + 1 if at + 1 < count else 0


@njit(inline="always")
def _weigh(fraction, polynomials, weight):
    """The polynomials of each derivative and tap at a fraction of a step, by Horner's rule."""
    powers = polynomials.shape[1]
    for derivative in range(weight.shape[0]):
        for tap in range(polynomials.shape[2]):
            value = polynomials[derivative, powers - 1, tap]
            for power in range(powers - 2, -1, -1):
                value = value * fraction + polynomials[derivative, power, tap]
            weight[derivative, tap] = value
