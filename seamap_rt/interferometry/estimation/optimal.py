"""Optimal interpolation of a sea's heights: the linear mean of a cell's neighbours whose expected error is least.

Gandin 1963, Bretherton, Davis & Fandry 1976. Of measured heights y with error covariance R and a sea of mean level 0
and covariance C the mean of a cell is kᵀ(C + R)⁻¹y, of variance k₀ − kᵀ(C + R)⁻¹k, k the sea's covariance between the
cell's mean and the points of y. The window thus adapts itself: it is short where the echo is strong and clear, long
where it is weak, and longer along the crests than across. A measured height is the mean over the pulse's and the beam's
footprint, so that its covariances are those of the sea blurred by it, once towards a point and twice between two of
them; what it flattens is restored as far as errors allow, and what they do not is part of the variance.
"""

from __future__ import annotations

from concurrent.futures import ThreadPoolExecutor
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from ...compute.compiled import compiled
from ...compute.machine import threads
from .error_covariance import ErrorCovariance
from .sea_covariance import SeaCovariance

Map = NDArray[np.float64]

_BLOCK = 3  # gates that share their neighbours, hence a matrix
_GATES = 3  # neighbouring gates to either side
ACROSS_M = 6.5  # neighbouring looks as far as this, one at least
MOST_LOOKS = 3
_WORTHLESS = 6.0  # error variance over the sea's: such a height has no weight
_GAUSS = 1.0 / np.sqrt(3.0)
_BLURS = 4  # tables of the covariance, of means over areas as large as the beam's footprint from near to far
_TASKS = 32  # blocks of looks, each a task of its own: enough for every thread


@dataclass(frozen=True)
class Measured:
    """Heights as measured, all (look, gate); NaN where there is none."""

    height: Map  # m
    errors: ErrorCovariance
    ground: tuple[Map, Map]  # m east and north, where they lie
    outward: tuple[Map, Map]  # east and north of the direction from the radar
    blur: Map  # (gate,) m², variance a side of the area that a height is the mean of


def optimal_heights(
    measured: Measured, sea: SeaCovariance, wanted: NDArray[np.bool_], cell: tuple[float, float], ranges: Map
) -> tuple[Map, Map]:
    """Mean heights [m] of wanted cells and their variances [m²], (look, gate); NaN elsewhere.

    cell: its length along the look [m] and its width [rad]; ranges (gate,) [m].
    """
    shape = measured.height.shape
    (x, y), (east, north) = measured.ground, (np.broadcast_to(each, shape) for each in measured.outward)
    lying = np.isfinite(x) & np.isfinite(y) & np.isfinite(east) & np.isfinite(north)
    variance = measured.errors.variance
    usable = lying & np.isfinite(measured.height) & (variance < _WORTHLESS * sea.variance)
    parts = np.where(usable, measured.errors.parts, np.nan)
    points = np.stack([np.where(lying, each, 0.0) for each in (x, y, east, north)])
    width = cell[1] * ranges
    looks = np.clip(np.round(ACROSS_M / np.maximum(width, 1e-9)), 1, MOST_LOOKS).astype(np.int64)
    along = np.ascontiguousarray(measured.errors.along)
    half = 0.5 * _GAUSS * cell[0], 0.5 * _GAUSS * width  # of the cell's four sample points
    blurs = np.linspace(measured.blur.min(), measured.blur.max(), _BLURS)
    level = np.abs(measured.blur[:, None] - blurs).argmin(axis=1)
    tables = np.stack([np.stack((sea.table, sea.blurred(blur), sea.blurred(2.0 * blur))) for blur in blurs])
    estimate = np.full((2, *shape), np.nan)

    def rows(first: int, last: int) -> None:
        cells = measured.height, parts, points, wanted & lying
        _interpolate(
            *cells, tables, level, sea.spacing, *half, looks, along, measured.errors.beside, first, last, estimate
        )

    edges = np.linspace(0, shape[0], _TASKS + 1).astype(int)
    with ThreadPoolExecutor(threads()) as pool:
        list(pool.map(rows, edges[:-1], edges[1:]))
    return estimate[0], estimate[1]


@compiled
def _at(table, middle, per_spacing, dx, dy):
    """The table at a lag [m], linear between its entries; 0 beyond."""
    east, north = dx * per_spacing + middle, dy * per_spacing + middle
    if east < 0.0 or north < 0.0 or east >= 2 * middle or north >= 2 * middle:
        return 0.0
    i, j = int(east), int(north)
    u, v = east - i, north - j
    return (table[i, j] * (1.0 - v) + table[i, j + 1] * v) * (1.0 - u) + (
        table[i + 1, j] * (1.0 - v) + table[i + 1, j + 1] * v
    ) * u


@compiled
def _factor(matrix, count, error, inverse):
    """Cholesky's factor, in place, in the lower half, and one over its diagonal: divisions take long.

    What is left of a height's variance when all before it are known is at least its own error's, less what goes
    together with its neighbours' errors. A height of which less than half of that is left, by the table's steps and its
    end at long lags, is left out: of infinite variance.
    """
    for i in range(count):
        for j in range(i + 1):
            total = matrix[i, j]
            for k in range(j):
                total -= matrix[i, k] * matrix[j, k]
            if i == j:
                matrix[i, i] = np.sqrt(total) if total > 0.5 * error[i] ** 2 else np.inf
                inverse[i] = 1.0 / matrix[i, i]
            else:
                matrix[i, j] = total * inverse[j]


@compiled
def _neighbours(height, parts, points, looks, look, start, stop, rounding, near, index, known):
    """Fills near (east, north, standard error and its parts), index (row, gate) and known heights; how many."""
    rows, gates = height.shape
    count = 0
    for n in range(max(0, look - looks[start]), min(rows, look + looks[start] + 1)):
        for m in range(max(0, start - _GATES), min(gates, stop + _GATES)):
            if parts[2, n, m] >= 0.0:
                index[0, count], index[1, count] = n, m
                near[0, count], near[1, count] = points[0, n, m], points[1, n, m]
                square = rounding
                for part in range(3):
                    near[3 + part, count] = parts[part, n, m]
                    square += parts[part, n, m] ** 2
                near[2, count] = np.sqrt(square)
                known[count] = height[n, m]
                count += 1
    return count


@compiled
def _covariances(matrix, near, index, count, table, spacing, along, beside, rounding):
    """Fills the lower half of the matrix of the measured heights' covariances: of the sea, and of their errors."""
    middle, per_spacing = table.shape[0] // 2, 1.0 / spacing
    for i in range(count):
        x, y, row, gate = near[0, i], near[1, i], index[0, i], index[1, i]
        tilt, rough, noise = near[3, i], near[4, i], near[5, i]
        for j in range(i + 1):
            total = _at(table, middle, per_spacing, x - near[0, j], y - near[1, j])
            lag = abs(gate - index[1, j])
            if lag < along.shape[1] and row - index[0, j] <= 1:
                speckle = along[0, lag] * tilt * near[3, j] + along[1, lag] * rough * near[4, j]
                total += speckle + along[2, lag] * noise * near[5, j] if row == index[0, j] else beside * speckle
            matrix[i, j] = total
        matrix[i, i] += rounding


@compiled
def _interpolate(
    height, parts, points, wanted, tables, level, spacing, along, across, looks, together, beside, first, last, estimate
):
    """Looks first … last − 1 of found (mean and variance, look, gate)."""
    gates = height.shape[1]
    middle, per_spacing = tables.shape[2] // 2, 1.0 / spacing
    most = (2 * MOST_LOOKS + 1) * (_BLOCK + 2 * _GATES)
    matrix, near, known, part = np.empty((most, most)), np.empty((6, most)), np.empty(most), np.empty(most)
    inverse, index = np.empty(most), np.empty((2, most), np.int64)
    sea = tables[0, 0]
    # Between its entries the table is linear: of an arc of curvature κ the middle of a chord of length h lies κ h²/8
    # away, a quarter of what the covariance loses over h.
    rounding = 0.25 * (sea[middle, middle] - min(sea[middle + 1, middle], sea[middle, middle + 1]))
    for look in range(first, last):
        for start in range(0, gates, _BLOCK):
            stop = min(gates, start + _BLOCK)
            if not wanted[look, start:stop].any():
                continue
            towards, pairs = tables[level[start], 1], tables[level[start], 2]
            count = _neighbours(height, parts, points, looks, look, start, stop, rounding, near, index, known)
            _covariances(matrix, near, index, count, pairs, spacing, together, beside, rounding)
            _factor(matrix, count, near[2], inverse)
            for i in range(count):
                for k in range(i):
                    known[i] -= matrix[i, k] * known[k]
                known[i] *= inverse[i]
            for gate in range(start, stop):
                if not wanted[look, gate]:
                    continue
                x, y, east, north = points[:, look, gate]
                mean, explained = 0.0, 0.0
                for i in range(count):
                    total = 0.0
                    for u in (-along, along):
                        for v in (-across[gate], across[gate]):
                            dx, dy = near[0, i] - x - u * east - v * north, near[1, i] - y - u * north + v * east
                            total += 0.25 * _at(towards, middle, per_spacing, dx, dy)
                    for k in range(i):
                        total -= matrix[i, k] * part[k]
                    part[i] = total * inverse[i]
                    mean += part[i] * known[i]
                    explained += part[i] ** 2
                prior = 0.0  # variance of the cell's mean itself
                for u in (-2.0 * along, 0.0, 2.0 * along):
                    for v in (-2.0 * across[gate], 0.0, 2.0 * across[gate]):
                        share = (0.5 if u == 0.0 else 0.25) * (0.5 if v == 0.0 else 0.25)
                        prior += share * _at(sea, middle, per_spacing, u * east + v * north, u * north - v * east)
                estimate[0, look, gate] = mean
                estimate[1, look, gate] = max(prior - explained, 0.0)
