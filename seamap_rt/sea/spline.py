"""Uniform B-splines as interpolants of waves (Unser 1999, "Splines: a perfect fit for signal and image processing").

A wave e^{iκx} on grid points i becomes the spline Σ c_i β(x − i) with c_i = e^{iκi}/β̂(κ): dividing by the B-spline's
Fourier transform makes the wave's own line exact and leaves only its images, which fall as (κ/(2π − κ))^(order + 1).
"""

from __future__ import annotations

from itertools import pairwise

import numpy as np
from numpy.typing import ArrayLike, NDArray
from scipy import sparse


def bspline_transform(order: int, cycles: ArrayLike) -> NDArray[np.float64]:
    """Fourier transform β̂ of the B-spline, sinc^(order+1); cycles = κ/2π per grid step, |cycles| ≤ ½."""
    return np.sinc(np.asarray(cycles, dtype=np.float64)) ** (order + 1)


def bspline_image_error(order: int, cycles: ArrayLike, derivative: int = 0) -> NDArray[np.float64]:
    """Root of the summed squares of a unit wave's images, relative to the wave (its derivative with `derivative` = 1).

    Averaged over positions, the spline's squared error is the sum of the squares of its images.
    """
    cycles = np.asarray(cycles, dtype=np.float64)
    squared = np.zeros_like(cycles)
    for image in (-3, -2, -1, 1, 2, 3):
        squared += (cycles / (cycles + image)) ** (2 * (order + 1 - derivative))
    return np.sqrt(squared)


def bspline_weights(order: int, fraction: NDArray, derivative: int = 0) -> list[NDArray]:
    """Weights of the order + 1 grid points around x = floor(x) + fraction, from floor(x) − (order − 1)/2 upward.

    order: odd. derivative: 0, or 1 for d/dx per grid step. Each has the fraction's shape and dtype (de Boor 1972).
    """
    weights = [1.0 - fraction, fraction]
    for degree in range(2, order + 1):
        if derivative and degree == order:
            inner = [a - b for a, b in pairwise(weights)]
            return [-weights[0], *inner, weights[-1]]
        weights = [w * (1.0 / degree) for w in weights]
        inner = [
            (fraction + (degree - j)) * weights[j - 1] + ((j + 1) - fraction) * weights[j] for j in range(1, degree)
        ]
        weights = [(1.0 - fraction) * weights[0], *inner, fraction * weights[-1]]
    return weights


def interpolation_matrix(
    order: int,
    rows: NDArray[np.float64],
    columns: NDArray[np.float64],
    shape: tuple[int, int],
    derivative: tuple[int, int] = (0, 0),
) -> sparse.csr_array:
    """Matrix (point, grid point) of a periodic grid's B-spline at points given in grid steps; float32 weights.

    A grid of one row has no first axis: its rows are ignored. Apply it to a flattened (row, column) grid.
    """
    column_index, column_weight = _taps(order, columns, shape[1], derivative[1])
    if shape[0] == 1:
        index, weight = column_index, column_weight
    else:
        row_index, row_weight = _taps(order, rows, shape[0], derivative[0])
        index = (row_index[:, :, None] * np.int32(shape[1]) + column_index[:, None, :]).reshape(rows.size, -1)
        weight = (row_weight[:, :, None] * column_weight[:, None, :]).reshape(rows.size, -1)
    taps = index.shape[1]
    start = np.arange(0, index.size + 1, taps, dtype=np.int32)
    return sparse.csr_array((weight.ravel(), index.ravel(), start), shape=(columns.size, shape[0] * shape[1]))


def _taps(
    order: int, position: NDArray[np.float64], count: int, derivative: int
) -> tuple[NDArray[np.int32], NDArray[np.float32]]:
    """Grid points (n, order + 1) and their weights, on a periodic axis of `count` points."""
    whole = np.floor(position)
    weights = bspline_weights(order, (position - whole).astype(np.float32), derivative)
    first = (np.mod(whole, count) - (order - 1) // 2).astype(np.int32)
    index = first[:, None] + np.arange(order + 1, dtype=np.int32)
    index += np.where(index < 0, np.int32(count), np.int32(0))
    index -= np.where(index >= count, np.int32(count), np.int32(0))
    return index, np.stack(weights, axis=-1)
