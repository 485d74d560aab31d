"""Optimal interpolation of a sea's heights: the linear mean of a cell's neighbours whose expected error is least.

Gandin 1963, Bretherton, Davis & Fandry 1976. Of measured heights y with error covariance R and a sea of mean level 0
and covariance C the mean of a cell is kᵀ(C + R)⁻¹y, of variance k₀ − kᵀ(C + R)⁻¹k, k the sea's covariance between the
cell's mean and the points of y. The window thus adapts itself: it is short where the echo is strong and clear, long
where it is weak, and longer along the crests than across. A measured height is the mean over the pulse's and the beam's
footprint, so that its covariances are those of the sea blurred by it, once towards a point and twice between two of
them; what it flattens is restored as far as errors allow, and what they do not is part of the variance.

A cell's mean slope errs alike, by s₀ − cᵀ(C + R)⁻¹c: s₀ the sea's variance of it, c its covariance with the points
of y. Of this wᵀRw, w = (C + R)⁻¹c, is due to the errors of y. Where y differs from what its neighbours make it expected
to be by more than C + R say (innovations, Kalman 1960), they are as much larger.

A few gates share their neighbours, hence a matrix. From one look to the next most neighbours stay, and their
covariances with them: only those with new ones are worked out. Looks are gone through from the last to the first, and
neighbours are kept in that order.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from ..compute.compiled import compiled, compiled_fused, compiled_step
from ..compute.machine import pool
from .error_covariance import ErrorCovariance
from .sea_covariance import SeaCovariance

BLOCK = 3  # gates that share their neighbours
_GATES = 3  # neighbouring gates to either side
MOST_LOOKS = 3  # neighbouring looks to either side, at most
_MOST = (2 * MOST_LOOKS + 1) * (BLOCK + 2 * _GATES)  # neighbours
_MEASURED = 2  # right-hand sides: the covariances with one cell's slopes, what was measured,
_SIDES = _MEASURED + 1 + BLOCK  # and the covariances with each gate's cell
_SAME_DIRECTION = math.cos(math.radians(8.0))  # of the angle between looks whose slopes err alike
_GAUSS = 0.5 / math.sqrt(3.0)  # of a cell's side, from its middle to its sample points
_STRIPS = 4  # of a cell, of which its slopes are means
_WIDE = _SIDES + _MOST


class Cells(NamedTuple):
    """What is known of each cell; points in the plane."""

    height: NDArray[np.float64]  # (look, gate) m
    parts: NDArray[np.float64]  # (3, look, gate) roots of its error's variance, by kind; NaN of one that has no weight
    points: NDArray[np.float64]  # (4, look, gate) m east and north, and the direction outward
    wanted: NDArray[np.bool_]  # (look, gate)
    looks: NDArray[np.int64]  # (gate,) neighbouring looks to either side


class SeaTables(NamedTuple):
    """Covariance of the sea's height by lag."""

    tables: NDArray[np.float64]  # (blur, 3, lag north, lag east) of points, of a point and a mean, of two means
    level: NDArray[np.int64]  # (gate,) which blur
    spacing: float  # m


class HalfCell(NamedTuple):
    """Half the distance between a cell's sample points."""

    along: float  # m
    across: NDArray[np.float64]  # (gate,) m


class Neighbours(NamedTuple):
    """Measured heights around a cell, room for all that there may be."""

    east: NDArray[np.float64]  # m
    north: NDArray[np.float64]  # m
    variance: NDArray[np.float64]  # m², of the error
    parts: NDArray[np.float64]  # (3, neighbour) roots of it, by kind
    look: NDArray[np.int64]
    gate: NDArray[np.int64]


class Point(NamedTuple):
    """A cell's middle, and the direction outward there."""

    x: float  # m
    y: float  # m
    east: float
    north: float


class ErrorTables(NamedTuple):
    """Covariance of neighbours' errors over the product of their roots."""

    along: NDArray[np.float64]  # (kind, lag in gates) of one look
    beside: float  # of the same gate's neighbouring looks


@compiled
def interpolate(cells, sea_tables, half, errors, first, last, estimate):
    """Blocks of gates first … last − 1 of estimate (look, gate): mean, its variance, those of the mean slopes outward
    and clockwise, and their covariance, which a few looks of a block have of one cell."""
    height, points, wanted, looks = cells.height, cells.points, cells.wanted, cells.looks
    tables, level, spacing = sea_tables
    (along, across), (together, beside) = half, errors
    rows, gates = height.shape
    per_spacing = 1.0 / spacing
    sea, middle = tables[0, 0], tables.shape[2] // 2
    # Between its entries the table is linear: of an arc of curvature κ the middle of a chord of length h lies κ h²/8
    # away, a quarter of what the covariance loses over h.
    rounding = 0.25 * (sea[middle, middle] - min(sea[middle + 1, middle], sea[middle, middle + 1]))
    given, left = np.zeros((_MOST + 4, _WIDE)), np.zeros((_MOST + 4, _WIDE))
    east, north, error, inverse = np.empty(_MOST), np.empty(_MOST), np.empty(_MOST), np.empty(_MOST + 4)
    parts, look_of, gate_of = np.empty((3, _MOST)), np.empty(_MOST, np.int64), np.empty(_MOST, np.int64)
    near = Neighbours(east, north, error, parts, look_of, gate_of)
    row, corner, shares = np.empty(_MOST), np.empty(_MOST, np.uint32), np.empty((3, _MOST))
    slope, of_slopes, weights = np.empty((2, 3)), np.empty((2, 3, rows)), np.empty((2, _MOST))
    for block in range(first, last):
        start, stop = block * BLOCK, min(gates, (block + 1) * BLOCK)
        towards, pairs = tables[level[start], 1], tables[level[start], 2]
        cell = along / _GAUSS, across[start] / _GAUSS
        count, lowest, facing = 0, rows, (0.0, 0.0)
        innovation, innovations = 0.0, 0
        for look in range(rows - 1, -1, -1):
            if not wanted[look, start:stop].any():
                facing = 0.0, 0.0
                continue
            low, high = max(0, look - looks[start]), min(rows, look + looks[start] + 1)
            kept = _remove_looks(given, near, count, high)
            gates_near = max(0, start - _GATES), min(gates, stop + _GATES)
            count = _append_looks(cells, (low, min(high, lowest)), gates_near, rounding, given, near, kept)
            lowest = low
            for i in range(kept, count):
                row[: i + 1] = 0.0
                _add_sea(row, i + 1, near, near.east[i], near.north[i], pairs, per_spacing, 1.0, corner, shares)
                _add_errors(row, i, near, together, beside)
                row[i] += rounding
                for j in range(i + 1):
                    given[i, _SIDES + j] = row[j]
            for gate in range(start, stop):
                if not wanted[look, gate]:
                    continue
                point = _point(points, look, gate)
                row[:count] = 0.0
                for u in (-along, along):
                    for v in (-across[gate], across[gate]):
                        at_x, at_y = _offset(point, u, v)
                        _add_sea(row, count, near, at_x, at_y, towards, per_spacing, 0.25, corner, shares)
                for i in range(count):
                    given[i, _MEASURED + 1 + gate - start] = row[i]
            chosen = start + 1 if start + 1 < stop and wanted[look, start + 1] else start
            point = _point(points, look, chosen if wanted[look, chosen] else stop - 1)
            turned = facing[0] * point.east + facing[1] * point.north < _SAME_DIRECTION
            if turned:
                facing = point.east, point.north
                _set_slopes(given, row, count, near, point, cell, towards, per_spacing, corner, shares)
            _eliminate(given, count, near.variance, left, inverse, 0 if turned else _MEASURED)
            if turned:
                _set_errors(left, count, inverse, near.variance, sea, per_spacing, point, cell, weights, slope)
                for i in range(count):
                    innovation += left[i, _MEASURED] ** 2 * inverse[i]
                    innovations += inverse[i] > 0.0
            for n in range(3):
                of_slopes[0, n, look], of_slopes[1, n, look] = slope[0, n], slope[1, n]
            for gate in range(start, stop):
                if not wanted[look, gate]:
                    continue
                mean, explained = 0.0, 0.0
                for i in range(count):
                    part = left[i, _MEASURED + 1 + gate - start]
                    mean += part * left[i, _MEASURED] * inverse[i]
                    explained += part * part * inverse[i]
                prior = _mean_variance(sea, per_spacing, _point(points, look, gate), along, across[gate])
                estimate[0, look, gate] = mean
                estimate[1, look, gate] = max(prior - explained, 0.0)
        # Heights that differ from what their neighbours make them expected to be by more than is stated err by more.
        excess = max(innovation / max(innovations, 1) - 1.0, 0.0)
        for look in range(rows):
            for gate in range(start, stop):
                if wanted[look, gate]:
                    for n in range(3):
                        estimate[2 + n, look, gate] = of_slopes[0, n, look] + excess * of_slopes[1, n, look]


@compiled_step
def _point(points, look, gate):
    return Point(points[0, look, gate], points[1, look, gate], points[2, look, gate], points[3, look, gate])


@compiled_step
def _offset(point, outward, clockwise):
    """East and north of what lies so far outward and clockwise of a point [m]."""
    return (
        point.x + outward * point.east + clockwise * point.north,
        point.y + outward * point.north - clockwise * point.east,
    )


@compiled_step
def _remove_looks(given, near, count, high):
    """Leave out the first neighbours, of looks from `high` on; how many are left."""
    out = 0
    while out < count and near.look[out] >= high:
        out += 1
    kept = count - out
    if out > 0:
        for i in range(kept):
            given[i, _MEASURED] = given[i + out, _MEASURED]
            for j in range(_SIDES, _SIDES + i + 1):
                given[i, j] = given[i + out, out + j]
        for i in range(kept):  # loops, as everywhere here: to assign parts of arrays takes the compiler seconds
            was = i + out
            near.east[i], near.north[i], near.variance[i] = near.east[was], near.north[was], near.variance[was]
            near.look[i], near.gate[i] = near.look[was], near.gate[was]
            for n in range(3):
                near.parts[n, i] = near.parts[n, was]
    return kept


@compiled_step
def _append_looks(cells, looks, gates, rounding, given, near, count):
    """Append the neighbours of looks and gates (first, end), from the last, and what was measured; how many there are
    now."""
    height, parts, points = cells.height, cells.parts, cells.points
    for n in range(looks[1] - 1, looks[0] - 1, -1):
        for m in range(gates[1] - 1, gates[0] - 1, -1):
            if parts[2, n, m] >= 0.0:
                near.look[count], near.gate[count] = n, m
                near.east[count], near.north[count] = points[0, n, m], points[1, n, m]
                square = rounding
                for part in range(3):
                    near.parts[part, count] = parts[part, n, m]
                    square += parts[part, n, m] ** 2
                near.variance[count] = square
                given[count, _MEASURED] = height[n, m]
                count += 1
    return count


@compiled_step
def _add_sea(row, count, near, x, y, table, per_spacing, weight, corner, shares):
    """Add to row, times a weight, the table at the lags of the first neighbours from x, y [m]: linear between its
    entries, 0 beyond."""
    flat, middle, wide = table.ravel(), table.shape[0] // 2, table.shape[1]
    last = 2.0 * middle - 1e-9
    east, north = middle - x * per_spacing, middle - y * per_spacing
    for j in range(np.uint64(count)):  # first all that a processor's lanes do together, then what is looked up
        u, v = near.east[j] * per_spacing + east, near.north[j] * per_spacing + north
        i, k = min(max(u, 0.0), last), min(max(v, 0.0), last)
        inside = weight if (i == u) & (k == v) else 0.0
        u, v = i - np.floor(i), k - np.floor(k)
        corner[j] = np.uint32(np.floor(i) * wide + np.floor(k))
        shares[0, j], shares[1, j], shares[2, j] = inside * (1.0 - u), inside * u, v
    for j in range(np.uint64(count)):
        here, v = np.uint64(corner[j]), shares[2, j]
        beyond = here + np.uint64(wide)
        low = flat[here] + v * (flat[here + np.uint64(1)] - flat[here])
        high = flat[beyond] + v * (flat[beyond + np.uint64(1)] - flat[beyond])
        row[j] += shares[0, j] * low + shares[1, j] * high


@compiled_step
def _set_slopes(given, row, count, near, point, cell, table, per_spacing, corner, shares):
    """Set the covariances of the first neighbours with a cell's mean slopes, outward and clockwise: by how much its far
    edge is higher than its near one, over its length, each edge by two points."""
    for axis in range(2):
        row[:count] = 0.0
        for n in range(4):
            end, beside = cell[axis] * (n // 2 - 0.5), _GAUSS * cell[1 - axis] * (n % 2 * 2 - 1)
            u, v = (beside, end) if axis else (end, beside)
            at_x, at_y = _offset(point, u, v)
            _add_sea(row, count, near, at_x, at_y, table, per_spacing, 0.25 / end, corner, shares)
        for i in range(count):
            given[i, axis] = row[i]


@compiled_step
def _set_errors(left, count, inverse, error, table, per_spacing, point, cell, weights, slope):
    """Set slope (2, 3): what of the variances of a cell's slopes and of their covariance is not explained, and what
    the heights' own errors make of it. weights (axis, neighbour): those of the heights in the slopes, filled in."""
    for axis in range(2):
        for i in range(count):
            rest = left[i, axis]
            for j in range(i):
                rest -= left[i, _SIDES + j] * weights[axis, j]
            weights[axis, i] = rest * inverse[i]
    for n in range(3):
        one, other = n % 2, (n + 1) // 2 % 2
        explained = slope[1, n] = 0.0
        for i in range(count):
            explained += left[i, one] * left[i, other] * inverse[i]
            slope[1, n] += weights[one, i] * weights[other, i] * error[i]
        slope[0, n] = _slopes_covariance(table, per_spacing, point, cell, one, other) - explained
        if one == other:
            slope[0, n] = max(slope[0, n], 0.0)


@compiled_step
def _add_errors(row, i, near, along, beside):
    """Add to row the covariances of neighbour i's error with those of itself and of the ones before it."""
    look, gate, parts = near.look[i], near.gate[i], near.parts
    tilt, rough, noise = parts[0, i], parts[1, i], parts[2, i]
    j = i
    while j >= 0 and near.look[j] <= look + 1:
        lag = abs(gate - near.gate[j])
        if lag < along.shape[1]:
            speckle = along[0, lag] * tilt * parts[0, j] + along[1, lag] * rough * parts[1, j]
            row[j] += speckle + along[2, lag] * noise * parts[2, j] if look == near.look[j] else beside * speckle
        j -= 1


@compiled_fused
def _eliminate(given, count, error, left, inverse, first):
    """Gauss's elimination of the covariances `given` (row, right-hand sides from `first` on and columns up to its own),
    from the last row to the first: what is left of each, and one over what is left of its own variance.

    With all that are eliminated before it known, a height's variance is at least its own error's, less what goes
    together with its neighbours' errors. A height of which less than half of that is left, by the table's steps and its
    end at long lags, is left out.
    """
    inverse[count : count + 4] = 0.0
    flat, begin = left.ravel(), np.uint64(first)
    for i in range(count - 1, -1, -1):
        end, own, own_column = np.uint64(_SIDES + i + 1), np.uint64(i * _WIDE), np.uint64(_SIDES + i)
        for j in range(begin, end):
            flat[own + j] = given[i, j]
        for k in range(i + 1, count, 4):  # four at a time: what is left of a row is loaded and stored less often
            one = np.uint64(k * _WIDE)
            two, three, four = one + np.uint64(_WIDE), one + np.uint64(2 * _WIDE), one + np.uint64(3 * _WIDE)
            a, b = inverse[k] * flat[one + own_column], inverse[k + 1] * flat[two + own_column]
            c, d = inverse[k + 2] * flat[three + own_column], inverse[k + 3] * flat[four + own_column]
            for j in range(begin, end):
                known = a * flat[one + j] + b * flat[two + j] + c * flat[three + j] + d * flat[four + j]
                flat[own + j] -= known
        mine = left[i, _SIDES + i]
        inverse[i] = 1.0 / mine if mine > 0.5 * error[i] else 0.0


@compiled_step
def _mean_variance(table, per_spacing, point, along, across):
    """Variance of a cell's mean, of four points. To opposite lags the covariance is the same."""
    middle = table.shape[0] // 2
    total = 0.25 * table[middle, middle]
    for u, v, share in ((0.0, 2.0, 0.25), (2.0, 0.0, 0.25), (2.0, 2.0, 0.125), (2.0, -2.0, 0.125)):
        u, v = u * along, v * across
        total += share * _interpolate_table(table, middle, per_spacing, point, u, v)
    return total


@compiled_step
def _slopes_covariance(table, per_spacing, point, cell, one, other):
    """Covariance of two mean slopes of a cell, outward (0) or clockwise (1), each edge by a point a strip; of opposite
    lags once."""
    middle, total = table.shape[0] // 2, 0.0
    if one == other:
        for apart in range(1 - _STRIPS, _STRIPS):
            for end in range(2):
                u, v = cell[0] * (apart / _STRIPS if one else end), cell[1] * (end if one else apart / _STRIPS)
                share = 0.5 * (_STRIPS - abs(apart)) * (1 - 2 * end)
                total += share * _interpolate_table(table, middle, per_spacing, point, u, v)
    else:
        for n in range(_STRIPS):
            for m in range(2 * _STRIPS):
                to, strip, aside = m % 2 - 0.5, (n + 0.5) / _STRIPS - 0.5, (m // 2 + 0.5) / _STRIPS - 0.5
                u, v = cell[0] * (0.5 - aside), cell[1] * (strip - to)
                total += to * _interpolate_table(table, middle, per_spacing, point, u, v)
    return 4.0 * total / (_STRIPS**2 * cell[one] * cell[other])


@compiled_step
def _interpolate_table(table, middle, per_spacing, point, outward, clockwise):
    """The table at a lag [m] outward and clockwise of a point, linear between its entries; 0 beyond."""
    east = (outward * point.east + clockwise * point.north) * per_spacing + middle
    north = (outward * point.north - clockwise * point.east) * per_spacing + middle
    if east < 0.0 or north < 0.0 or east >= 2 * middle or north >= 2 * middle:
        return 0.0
    i, j = int(east), int(north)
    u, v = east - i, north - j
    return (table[i, j] * (1.0 - v) + table[i, j + 1] * v) * (1.0 - u) + (
        table[i + 1, j] * (1.0 - v) + table[i + 1, j + 1] * v
    ) * u


Map = NDArray[np.float64]

ACROSS_M = 6.5  # neighbouring looks as far as this, one at least
_MOST_VARIANCE = 6.0  # error variance over the sea's: such a height has no weight
_BLURS = 4  # tables of the covariance, of means over areas as large as the beam's footprint from near to far


@dataclass(frozen=True)
class MeasuredHeights:
    """Heights as measured, all (look, gate); NaN where there is none."""

    height: Map  # m
    errors: ErrorCovariance
    ground: tuple[Map, Map]  # m east and north, where they lie
    outward: tuple[Map, Map]  # east and north of the direction from the radar
    blur: Map  # (gate,) m², variance a side of the area that a height is the mean of


def optimal_heights(
    measured: MeasuredHeights,
    sea: SeaCovariance,
    wanted: NDArray[np.bool_],
    cell: tuple[float, float],
    ranges: Map,
    tasks: int = 32,
) -> tuple[Map, Map, Map]:
    """Mean heights [m] of wanted cells, their variances [m²], both (look, gate), and the variances of the cells' mean
    slopes outward and clockwise and their covariance (3, look, gate); NaN elsewhere.

    cell: its length along the look [m] and its width [rad]; ranges (gate,) [m]. tasks: blocks of gates that threads
    take; no bit depends on them.
    """
    shape = measured.height.shape
    (x, y), (east, north) = measured.ground, (np.broadcast_to(each, shape) for each in measured.outward)
    lying = np.isfinite(x) & np.isfinite(y) & np.isfinite(east) & np.isfinite(north)
    variance = measured.errors.variance
    usable = lying & np.isfinite(measured.height) & (variance < _MOST_VARIANCE * sea.variance)
    parts = np.where(usable, measured.errors.parts, np.nan)
    points = np.stack([np.where(lying, each, 0.0) for each in (x, y, east, north)])
    width = cell[1] * ranges
    looks = np.clip(np.round(ACROSS_M / np.maximum(width, 1e-9)), 1, MOST_LOOKS).astype(np.int64)
    half = HalfCell(_GAUSS * cell[0], _GAUSS * width)
    blurs = np.linspace(measured.blur.min(), measured.blur.max(), _BLURS)
    level = np.abs(measured.blur[:, None] - blurs).argmin(axis=1)
    tables = np.stack([np.stack((sea.table, sea.blurred(blur), sea.blurred(2.0 * blur))) for blur in blurs])
    estimate = np.full((5, *shape), np.nan)

    given = (
        Cells(measured.height, parts, points, wanted & lying, looks),
        SeaTables(tables, level, sea.spacing),
        half,
        ErrorTables(np.ascontiguousarray(measured.errors.along), measured.errors.beside),
    )

    def blocks(first: int, last: int) -> None:
        interpolate(*given, first, last, estimate)

    edges = np.linspace(0, -(-shape[1] // BLOCK), tasks + 1).astype(int)
    with pool() as workers:
        list(workers.map(blocks, edges[:-1], edges[1:]))
    return estimate[0], estimate[1], estimate[2:]
