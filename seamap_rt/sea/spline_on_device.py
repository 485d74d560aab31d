"""The sea's splines on the device: what `spline_kernel` does, a lane a point.

The coefficients of all knots of a batch lie there one after another, wherever they were made; a point says at which
knot its own begin. Positions are float64, of which each point has three, and the fractions of a step float32, as in
`spline_kernel`: the sums differ by the order in which they are formed, some 1e-7 of their terms.
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from ..compute.device import Device, device

Derivative = tuple[int, int, int]  # along rows, columns and time


class CoefficientsThere(NamedTuple):
    """Flat coefficients (knot, row, column), each knot's with its halo."""

    values: Any
    rows: int  # that lie there of each knot
    columns: int
    origin: tuple[int, int]  # the number of the first row, and how many there are until they come again
    period: int  # of the columns

    @classmethod
    def of(
        cls, knots: Sequence[Any], shape: tuple[int, int], origin: tuple[int, int], period: int
    ) -> CoefficientsThere:
        """Of each knot's, there (row, column) of that shape."""
        return cls(device().dr.concat(tuple(knots)), *shape, origin, period)


class PointsThere(NamedTuple):
    """Arrays (point,)."""

    x: Any  # m, float64
    y: Any
    knot: Any  # UInt32, which of the knots is the first that it takes from
    beyond: Any  # of a time step, how far it lies beyond its interval's beginning

    @classmethod
    def of(
        cls, x: NDArray[np.float64], y: NDArray[np.float64], knot: NDArray[np.int64], beyond: NDArray[np.float64]
    ) -> PointsThere:
        """Those of the host, placed there."""
        of = device()
        return cls(of.place(x), of.place(y), of.place(knot.astype(np.uint32)), of.place_single(beyond))


def splines_on_device(
    coefficients: CoefficientsThere,
    points: PointsThere,
    per_metre: tuple[float, float],
    weights: tuple[NDArray[np.float64], NDArray[np.float64], NDArray[np.float64]],
    derivatives: Sequence[Derivative],
) -> list[Any]:
    """Float arrays (point,) of each derivative, per grid step and time step, evaluated there.

    per_metre: grid points along rows and columns; weights: polynomials (derivative, power, tap) of rows, columns and
    time, as `spline.bspline_polynomials` gives them.
    """
    of = device()
    dr, (rows, columns, times) = of.dr, (each.shape[2] for each in weights)
    row, north = _beside(of, points.y, per_metre[0], rows, *coefficients.origin)
    column, east = _beside(of, points.x, per_metre[1], columns, 0, coefficients.period)
    along_rows = {r: _weights(weights[0][r], north) for r in {r for r, _, _ in derivatives}}
    along_columns = {c: _weights(weights[1][c], east) for c in {c for _, c, _ in derivatives}}
    in_time = {t: of.place_single(weights[2][t]) for t in {t for _, _, t in derivatives}}  # (power, tap)
    partial = sorted({(r, t) for r, _, t in derivatives})
    start = (points.knot * coefficients.rows + row) * coefficients.columns + column
    apart = coefficients.rows * coefficients.columns  # from knot to knot

    def add(tap: Any, *sums: Any) -> tuple[Any, ...]:
        at = start + tap * apart
        grid = [
            [dr.gather(of.Float, coefficients.values, at + (i * coefficients.columns + j)) for j in range(columns)]
            for i in range(rows)
        ]
        of_rows = {
            r: [_sum([each[i] * grid[i][j] for i in range(rows)]) for j in range(columns)]
            for r, each in along_rows.items()
        }
        weight = {t: _weight_of(of, table, tap, times, points.beyond) for t, table in in_time.items()}
        more = [weight[t] * of_rows[r][j] for r, t in partial for j in range(columns)]
        return tap + 1, *(s + m for s, m in zip(sums, more, strict=True))

    lanes = dr.width(points.x)
    state = dr.zeros(of.UInt32, lanes), *(dr.zeros(of.Float, lanes) for _ in range(len(partial) * columns))
    sums = dr.while_loop(state, lambda tap, *_: tap < times, add)[1:]
    made = []
    for r, c, t in derivatives:
        first = partial.index((r, t)) * columns
        made.append(_sum([along_columns[c][j] * sums[first + j] for j in range(columns)]))
    dr.eval(made)
    return made


def _beside(of: Device, position: Any, per_metre: float, taps: int, origin: int, count: int) -> tuple[Any, Any]:
    """The first of the grid points around a position, counted from `origin` on an axis of period `count`, and how far
    the position lies beyond a grid point."""
    steps = position * per_metre
    whole = of.dr.floor(steps)
    first = whole - ((taps - 1) // 2 + origin)
    return of.UInt32(first - of.dr.floor(first / count) * count), of.Float(steps - whole)


def _weights(polynomials: NDArray[np.float64], fraction: Any) -> list[Any]:
    """The polynomials (power, tap) of each tap at a fraction of a step, by Horner's rule."""
    made = []
    for tap in polynomials.T.tolist():
        value = tap[-1]
        for power in tap[-2::-1]:
            value = power + fraction * value
        made.append(value)
    return made


def _weight_of(of: Device, table: Any, tap: Any, taps: int, fraction: Any) -> Any:
    """The same of one tap, of a table (power, tap) there."""
    powers = of.dr.width(table) // taps
    value = of.dr.gather(of.Float, table, tap + (powers - 1) * taps)
    for power in range(powers - 2, -1, -1):
        value = of.dr.gather(of.Float, table, tap + power * taps) + fraction * value
    return value


def _sum(terms: list[Any]) -> Any:
    total = terms[0]
    for term in terms[1:]:
        total = total + term
    return total
