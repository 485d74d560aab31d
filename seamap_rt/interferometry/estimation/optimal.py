"""Optimal interpolation of a sea's heights: the linear mean of a cell's neighbours whose expected error is least.

Gandin 1963, Bretherton, Davis & Fandry 1976. Of measured heights y with error covariance R and a sea of mean level 0
and covariance C the mean of a cell is kᵀ(C + R)⁻¹y, of variance k₀ − kᵀ(C + R)⁻¹k, k the sea's covariance between the
cell's mean and the points of y. The window thus adapts itself: it is short where the echo is strong and clear, long
where it is weak, and longer along the crests than across.
"""

from __future__ import annotations

from concurrent.futures import ThreadPoolExecutor
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from ...compute.compiled import compiled
from ...compute.machine import threads
from .sea_covariance import SeaCovariance

Map = NDArray[np.float64]

_BLOCK = 3  # gates that share their neighbours, hence a matrix
_GATES = 3  # neighbouring gates to either side
_ACROSS_M = 6.5  # neighbouring looks as far as this, one at least
_MOST_LOOKS = 3
_WORTHLESS = 6.0  # error variance over the sea's: such a height has no weight
_ROUNDING = 1e-3  # of the sea's variance: the table's linear steps, as an error of their own
# Waves shorter than the covariance's shortest lags hold some 2 % of a wind sea's variance (Phillips's tail beyond 8 m,
# of 50 m waves): heights are uncorrelated over a cell, and neighbours do not help.
_SHORT = 0.02
_GAUSS = 1.0 / np.sqrt(3.0)
# Errors of gates so far apart are correlated. A bright spot between two gates shifts both to it, but as seen from them
# to opposite sides: less than the squared correlation of speckle itself, 0.5 at 1.5 m of a 20 ns pulse.
_ERRORS_TOGETHER_M = 1.35
_TASKS = 32  # blocks of looks, each a task of its own: enough for every thread


@dataclass(frozen=True)
class Measured:
    """Heights as measured, all (look, gate); NaN where there is none."""

    height: Map  # m
    variance: Map  # m², of its error
    ground: tuple[Map, Map]  # m east and north, where they lie
    outward: tuple[Map, Map]  # east and north of the direction from the radar


def optimal_heights(
    measured: Measured, sea: SeaCovariance, wanted: NDArray[np.bool_], cell: tuple[float, float], ranges: Map
) -> tuple[Map, Map]:
    """Mean heights [m] of wanted cells and their variances [m²], (look, gate); NaN elsewhere.

    cell: its length along the look [m] and its width [rad]; ranges (gate,) [m].
    """
    spacing = float(ranges[1] - ranges[0]) if ranges.size > 1 else 1.0
    shape = measured.height.shape
    (x, y), (east, north) = measured.ground, (np.broadcast_to(each, shape) for each in measured.outward)
    lying = np.isfinite(x) & np.isfinite(y) & np.isfinite(east) & np.isfinite(north)
    usable = lying & np.isfinite(measured.height) & (measured.variance < _WORTHLESS * sea.variance)
    error = np.where(usable, np.maximum(measured.variance, _ROUNDING * sea.variance), np.nan)
    points = np.stack([np.where(lying, each, 0.0) for each in (x, y, east, north)])
    width = cell[1] * ranges
    looks = np.clip(np.round(_ACROSS_M / np.maximum(width, 1e-9)), 1, _MOST_LOOKS).astype(np.int64)
    together = np.exp(-((spacing * np.arange(_BLOCK + 2 * _GATES) / _ERRORS_TOGETHER_M) ** 2))
    half = 0.5 * _GAUSS * cell[0], 0.5 * _GAUSS * width  # of the cell's four sample points
    estimate = np.full((2, *shape), np.nan)

    def rows(first: int, last: int) -> None:
        cells = measured.height, error, points, wanted & lying
        _interpolate(*cells, sea.table, sea.spacing, *half, looks, together, first, last, estimate)

    edges = np.linspace(0, shape[0], _TASKS + 1).astype(int)
    with ThreadPoolExecutor(threads()) as pool:
        list(pool.map(rows, edges[:-1], edges[1:]))
    return estimate[0], estimate[1] + _SHORT * sea.variance


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
def _factor(matrix, count, near):
    """Cholesky's factor, in place, in the lower half.

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
                matrix[i, i] = np.sqrt(total) if total > 0.5 * near[4, i] ** 2 else np.inf
            else:
                matrix[i, j] = total / matrix[j, j]


@compiled
def _neighbours(height, error, points, looks, look, start, stop, near, known):
    """Fills near (row, gate, east, north, standard error) and their heights; how many there are."""
    rows, gates = height.shape
    count = 0
    for n in range(max(0, look - looks[start]), min(rows, look + looks[start] + 1)):
        for m in range(max(0, start - _GATES), min(gates, stop + _GATES)):
            if error[n, m] > 0.0:
                near[0, count], near[1, count] = n, m
                near[2, count], near[3, count] = points[0, n, m], points[1, n, m]
                near[4, count] = np.sqrt(error[n, m])
                known[count] = height[n, m]
                count += 1
    return count


@compiled
def _interpolate(height, error, points, wanted, table, spacing, along, across, looks, together, first, last, estimate):
    """Looks first … last − 1 of found (mean and variance, look, gate)."""
    gates = height.shape[1]
    middle, per_spacing = table.shape[0] // 2, 1.0 / spacing
    most = (2 * _MOST_LOOKS + 1) * (_BLOCK + 2 * _GATES)
    matrix, near, known, part = np.empty((most, most)), np.empty((5, most)), np.empty(most), np.empty(most)
    for look in range(first, last):
        for start in range(0, gates, _BLOCK):
            stop = min(gates, start + _BLOCK)
            if not wanted[look, start:stop].any():
                continue
            count = _neighbours(height, error, points, looks, look, start, stop, near, known)
            for i in range(count):
                for j in range(i + 1):
                    dx, dy = near[2, i] - near[2, j], near[3, i] - near[3, j]
                    matrix[i, j] = _at(table, middle, per_spacing, dx, dy)
                    if near[0, i] == near[0, j]:
                        matrix[i, j] += together[int(near[1, i] - near[1, j])] * near[4, i] * near[4, j]
            _factor(matrix, count, near)
            for i in range(count):
                for k in range(i):
                    known[i] -= matrix[i, k] * known[k]
                known[i] /= matrix[i, i]
            for gate in range(start, stop):
                if not wanted[look, gate]:
                    continue
                x, y, east, north = points[:, look, gate]
                mean, explained = 0.0, 0.0
                for i in range(count):
                    total = 0.0
                    for u in (-along, along):
                        for v in (-across[gate], across[gate]):
                            dx, dy = near[2, i] - x - u * east - v * north, near[3, i] - y - u * north + v * east
                            total += 0.25 * _at(table, middle, per_spacing, dx, dy)
                    for k in range(i):
                        total -= matrix[i, k] * part[k]
                    part[i] = total / matrix[i, i]
                    mean += part[i] * known[i]
                    explained += part[i] ** 2
                prior = 0.0  # variance of the cell's mean itself
                for u in (-2.0 * along, 0.0, 2.0 * along):
                    for v in (-2.0 * across[gate], 0.0, 2.0 * across[gate]):
                        share = (0.5 if u == 0.0 else 0.25) * (0.5 if v == 0.0 else 0.25)
                        prior += share * _at(table, middle, per_spacing, u * east + v * north, u * north - v * east)
                estimate[0, look, gate] = mean
                estimate[1, look, gate] = max(prior - explained, 0.0)
