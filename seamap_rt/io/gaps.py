"""Gaps in a grid of heights, filled by the smoothest surface: what lies between is bent as little as a thin plate.

The bending energy ∫ η_xx² + 2 η_xy² + η_yy² is least over the gap's points (Duchon 1977), so heights and slopes go on
across the gap's rim. Across a strip of half-width d a wave of wavenumber k that runs over it is a cubic, which errs at
the middle by |cos kd + ½ kd sin kd − 1|, (kd)⁴/24 where that is small; over a round gap of that radius the share is
(kd)⁴/64. `fill_error` is that of the strip: no gap whose points all lie within d of known ones errs by more in the mean
over directions.
"""

from __future__ import annotations

import numpy as np
import scipy.ndimage
import scipy.sparse
import scipy.sparse.linalg
from numpy.typing import ArrayLike, NDArray

# Second differences of a plate: rows of (row offset, column offset, weight).
_BENDING = (
    ((0, -1, 1.0), (0, 0, -2.0), (0, 1, 1.0)),
    ((-1, 0, 1.0), (0, 0, -2.0), (1, 0, 1.0)),
    ((0, 0, np.sqrt(2.0)), (0, 1, -np.sqrt(2.0)), (1, 0, -np.sqrt(2.0)), (1, 1, np.sqrt(2.0))),
)


def half_width(gap: NDArray[np.bool_]) -> float:
    """Greatest distance, in points, from a point (row, column) of a gap to one that is known, and half a point: heights
    are known at the rim, and slopes between it and the next points. 0 without gaps, infinite where nothing is known."""
    if not gap.any():
        return 0.0
    if gap.all():
        return float("inf")
    return float(np.asarray(scipy.ndimage.distance_transform_edt(gap)).max()) + 0.5


def filled(values: NDArray[np.float64], gap: NDArray[np.bool_]) -> NDArray[np.float64]:
    """The heights (row, column), those of the gaps put in. The gaps must leave three points that are known."""
    number = np.full(gap.shape, -1)
    number[gap] = np.arange(np.count_nonzero(gap))
    known = np.where(gap, 0.0, values)
    near = np.asarray(scipy.ndimage.binary_dilation(gap, np.ones((3, 3))))
    rows, columns = np.nonzero(near)
    entries, energies, right, count = [], [], [], 0
    for stencil in _BENDING:
        at = [(rows + down, columns + right_) for down, right_, _ in stencil]
        fits = np.logical_and.reduce([(r >= 0) & (r < gap.shape[0]) & (c >= 0) & (c < gap.shape[1]) for r, c in at])
        at = [(r[fits], c[fits]) for r, c in at]
        touches = np.logical_or.reduce([gap[each] for each in at])
        at = [(r[touches], c[touches]) for r, c in at]
        size = at[0][0].size
        row = count + np.arange(size)
        right.append(-sum(weight * known[each] for each, (*_, weight) in zip(at, stencil, strict=True)))
        for each, (*_, weight) in zip(at, stencil, strict=True):
            asked = gap[each]
            entries.append((row[asked], number[each][asked]))
            energies.append(np.full(np.count_nonzero(asked), weight))
        count += size
    places = np.concatenate([np.stack(each) for each in entries], axis=1)
    bending = scipy.sparse.csc_array(
        (np.concatenate(energies), (places[0], places[1])), shape=(count, int(number.max()) + 1)
    )
    sought = scipy.sparse.linalg.spsolve((bending.T @ bending).tocsc(), bending.T @ np.concatenate(right))
    whole = known.copy()
    whole[gap] = sought
    return whole


def fill_error(wavenumber: ArrayLike, distance: float) -> NDArray[np.float64]:
    """Error at the middle of a strip of half-width `distance` [m], over the amplitude of a wave [rad/m] across it.
    Where nothing of the wave is left to go by it errs by itself and by what is put there: at most 2."""
    turn = np.asarray(wavenumber, dtype=np.float64) * distance
    return np.minimum(np.abs(np.cos(turn) + 0.5 * turn * np.sin(turn) - 1.0), 2.0)


def unseen_edges(gap: NDArray[np.bool_]) -> NDArray[np.bool_]:
    """The gaps (row, column) that reach the grid's edge."""
    labels, _ = scipy.ndimage.label(gap)  # type: ignore[misc]
    rim = np.concatenate((labels[0], labels[-1], labels[:, 0], labels[:, -1]))
    return gap & np.isin(labels, np.unique(rim[rim > 0]))


def largest_square(free: NDArray[np.bool_], middle: tuple[float, float]) -> tuple[tuple[int, int], int]:
    """First row and column, and points a side, of the largest square of free points (row, column); of several the one
    whose middle is nearest to `middle` (row, column)."""
    total = np.pad(np.cumsum(np.cumsum(~free, axis=0), axis=1), ((1, 0), (1, 0)))

    def fitting(side: int) -> NDArray[np.intp]:
        taken = total[side:, side:] - total[:-side, side:] - total[side:, :-side] + total[:-side, :-side]
        return np.argwhere(taken == 0)

    low, high = 0, min(free.shape)
    while low < high:
        side = (low + high + 1) // 2
        low, high = (side, high) if fitting(side).size else (low, side - 1)
    if not low:
        return (0, 0), 0
    starts = fitting(low)
    away = np.hypot(*(starts + 0.5 * (low - 1) - np.asarray(middle)).T)
    row, column = starts[int(np.argmin(away))]
    return (int(row), int(column)), low
