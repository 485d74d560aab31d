"""Phase → range difference → a point on the sea, in the plane of the fan-shaped beam.

The beam is narrow across and broad along the array, so that an echo comes from the plane of the boresight ŷ and the
array's own upright ẑ, which a rolling boat leans. In it the line of sight is û = ŷ cos η + ẑ sin η. With b from the
lower antenna to the upper one, R₁ the lower one's range and ΔR = R₂ − R₁,
û·b = −ΔR + (|b|² − ΔR²)/(2R₁), which holds exactly; the point is the lower antenna + R₁ û.
A gate's range is c t/2 of whole paths: for the mean over both receivers and over the transmitters T
r = R₁ + ΔR/4 + ½ ⟨R_T − R₁⟩, that is R₁ + ¼ ΔR if the lower one alone transmits, R₁ + ½ ΔR if both do in turn.
(Rosen et al. 2000 review the upright case.)
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from functools import cached_property

import numpy as np
from numpy.typing import ArrayLike, NDArray

from ..compute.compiled import compiled, compiled_step
from ..compute.machine import run_blocks

HEIGHT, ALONG, UP, LENGTH, RISE_ALONG, RISE_UP, OUT_ALONG, OUT_UP, RIGHT, OTHERS = range(10)

_ITERATIONS = 40  # of the fixed point at most; each gains a factor of about B/R
_RELATIVE_TOLERANCE = 4.0 * np.finfo(np.float64).eps


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
            for _ in range(_ITERATIONS):
                _refine_range(row, lower, delta, share, weights, along, up, after)
                converged = _converged(lower, after, ranges)
                _copy(after, lower)
                _sight(row[LENGTH], axis, lower, delta, along, up)
                if converged:
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
        for _ in range(_ITERATIONS):
            for j in range(np.uint64(lower.size)):
                cosine = -drop[j] * axis[3, j] / lower[j]
                cosine = -1.0 if cosine < -1.0 else cosine  # straight below, where the fan does not reach so far up
                along[j], up[j] = _direction(axis, j, cosine)
                delta[j] = _path_difference(row[ALONG, j], row[UP, j], row[LENGTH, j], lower[j], along[j], up[j])
            _refine_range(row, lower, delta, share, weights, along, up, after)
            converged = _converged(lower, after, ranges)
            _copy(after, lower)
            if converged:
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
def _refine_range(row, lower, delta, share, weights, along, up, after):
    """R₁ of a gate's range by what this has more than that, at the R₁ so far."""
    for j in range(np.uint64(lower.size)):
        after[j] = row[-2, j] - share * delta[j]
    for n in range(weights.size):
        at = OTHERS + 3 * n
        for j in range(np.uint64(lower.size)):
            more = _path_difference(row[at, j], row[at + 1, j], row[at + 2, j], lower[j], along[j], up[j])
            after[j] -= weights[n] * more


@compiled_step
def _converged(lower, after, ranges):
    most = 0.0
    for j in range(np.uint64(lower.size)):
        beyond = abs(after[j] - lower[j]) - _RELATIVE_TOLERANCE * ranges[j]
        most = beyond if beyond > most else most
    return most == 0.0


@compiled_step
def _direction(axis, j, cosine):
    """(cos η, sin η) of the direction in the plane at an angle of this cosine to the axis; NaN where there is none."""
    sine = np.sqrt((1.0 - cosine) * (1.0 + cosine)) * axis[2, j]
    return cosine * axis[0, j] + sine * axis[1, j], cosine * axis[1, j] - sine * axis[0, j]


@compiled_step
def _path_difference(along, up, length, lower, sight_along, sight_up):
    """By how much [m] a point at range `lower` in that direction is farther from an antenna than from the lower one."""
    square = length * length - 2.0 * lower * (along * sight_along + up * sight_up)
    rest = lower * lower + square
    return square / (lower + np.sqrt(rest if rest > 0.0 else 0.0))


Field = NDArray[np.float64]

_ROUNDING = 64.0 * np.finfo(np.float64).eps  # m, or of directions: what means over a dwell's pulses round


@dataclass(frozen=True)
class Antenna:
    """One antenna as seen from the lower receiver: along the boresight, up the array, and how far in all [m]."""

    along: Field
    up: Field
    length: Field

    @property
    def parts(self) -> tuple[Field, Field, Field]:
        """All three."""
        return self.along, self.up, self.length

    def mapped(self, each: Callable[[Field], Field]) -> Antenna:
        """The same antenna with a function applied to each of its arrays."""
        return Antenna(each(self.along), each(self.up), each(self.length))


@dataclass(frozen=True)
class Fan:
    """The plane of the beam, and the receivers in it; arrays that broadcast to (look, gate).

    Components of the boresight ŷ and of the array's upright ẑ: `rise` is up, `out` along the bearing, `right` of ẑ
    clockwise of it (ŷ has none). `others` are transmitters that are neither of the two, each with its share.
    """

    height: Field  # m, of the lower receiver above mean sea level
    upper: Antenna
    rise: tuple[Field, Field]
    out: tuple[Field, Field]
    right: Field
    share: float = 0.5  # of ΔR in the gate's range
    others: tuple[tuple[float, Antenna], ...] = ()

    @classmethod
    def upright(cls, baseline: ArrayLike, lower_height: ArrayLike, tilt: ArrayLike = 0.0, share: float = 0.5) -> Fan:
        """A boat at rest; tilt [rad] leans the array in the plane, its top towards the look."""
        base, height, lean = (np.asarray(each, dtype=np.float64) for each in (baseline, lower_height, tilt))
        sine, cosine = np.sin(lean), np.cos(lean)
        upper = Antenna(np.zeros_like(base), base, base)
        return cls(height, upper, (-sine, cosine), (cosine, sine), np.zeros_like(base), share)

    def common(self) -> Fan:
        """The same with one number where all looks agree to rounding: then what depends on nothing else is worked out
        once, (1, gate), not for each look."""
        return Fan(
            _common(self.height),
            self.upper.mapped(_common),
            (_common(self.rise[0]), _common(self.rise[1])),
            (_common(self.out[0]), _common(self.out[1])),
            _common(self.right),
            self.share,
            tuple((weight, antenna.mapped(_common)) for weight, antenna in self.others),
        )

    @cached_property
    def parts(self) -> Field:
        """All of it as the compiled loops take it, (part, look or 1, gate or 1)."""
        return np.stack(np.broadcast_arrays(*map(np.atleast_2d, self._parts)))

    @cached_property
    def shape(self) -> tuple[int, ...]:
        """What all its arrays broadcast to."""
        return np.broadcast_shapes(*map(np.shape, self._parts))

    @property
    def _parts(self) -> list[Field]:
        others = [part for _, other in self.others for part in other.parts]
        return [self.height, *self.upper.parts, *self.rise, *self.out, self.right, *others]

    @cached_property
    def weights(self) -> Field:
        """Shares (other,) of `others`."""
        return np.array([weight for weight, _ in self.others], dtype=np.float64)


@dataclass(frozen=True)
class Points:
    """Where echoes come from: height above mean sea level, and outward and clockwise of the lower antenna [m]."""

    height: Field
    out: Field
    right: Field


def locate(gate_range: ArrayLike, difference: ArrayLike, fan: Fan) -> Points:
    """The point with that ΔR [m] in each gate [m], arrays that broadcast to (look, gate).

    NaN where there is no triangle, or the baseline is zero."""
    return located(gate_range, difference, fan)[0]


def located(gate_range: ArrayLike, difference: ArrayLike, fan: Fan) -> tuple[Points, Field]:
    """`locate`'s point, and how its height grows with −ΔR/R₁ at fixed range: |dz/dη| / |dΔR/dη|, ΔR ≈ −û·b: B/R of
    itself is left out."""
    gate, delta, shape, looks = _rows(fan, gate_range, difference)
    points, gain = np.empty((3, *looks)), np.empty(looks)
    run_blocks(lambda *rows: locate_rows(*rows, gate, delta, fan.parts, fan.share, fan.weights, points, gain), looks[0])
    height, out, right = (each.reshape(shape) for each in points)
    return Points(height, out, right), gain.reshape(shape)


def height_per_phase(
    gate_range: ArrayLike, difference: ArrayLike, fan: Fan, wavelength: float, paths: int = 1
) -> Field:
    """|dz/dφ| at fixed range [m/rad]: λR/(2πpB) for an upright array, larger when it leans. paths: p."""
    return phase_scale(gate_range, wavelength, paths) * located(gate_range, difference, fan)[1]


def phase_scale(gate_range: ArrayLike, wavelength: float, paths: int) -> Field:
    """R dΔR/dφ [m²/rad] of p paths: what turns `located`'s growth into that with the phase."""
    return wavelength * np.asarray(gate_range, dtype=np.float64) / (2.0 * np.pi * paths)


def difference_at_height(gate_range: ArrayLike, height: ArrayLike, fan: Fan) -> Field:
    """ΔR [m] of the fan's point at `height` in each gate: the exact inverse of `locate`, by the fixed point.

    Straight below, where the fan does not reach so far up.
    """
    gate, height, shape, looks = _rows(fan, gate_range, height)
    difference = np.empty(looks)
    run_blocks(
        lambda *rows: difference_rows(*rows, gate, height, fan.parts, fan.share, fan.weights, difference), looks[0]
    )
    return difference.reshape(shape)


def _rows(fan: Fan, *fields: ArrayLike) -> tuple[Field, Field, tuple[int, ...], tuple[int, int]]:
    """Two fields as rows (look or 1, gate or 1), the shape that they and the fan broadcast to, and that in rows."""
    first, second = (np.require(each, np.float64, ("C", "W")) for each in fields)
    shape = np.broadcast_shapes(first.shape, second.shape, fan.shape)
    looks, gates = (1, 1, *shape)[-2:]
    return np.atleast_2d(first), np.atleast_2d(second), shape, (looks, gates)


def azimuth_at_sea(
    gate_range: Field, height: Field, rise: tuple[Field, Field], out: tuple[Field, Field], right: Field
) -> Field:
    """How far [rad] clockwise of the boresight's bearing the fan meets mean sea level at a range; all broadcast.

    NaN where the range ends above the sea, or on it straight below: there rounding alone would tell.
    """
    reached = gate_range * np.hypot(*rise) > (1.0 + _ROUNDING) * height
    along, up = plane_direction(*rise, np.where(reached, -height / gate_range, np.nan))
    return np.arctan2(right * up, out[0] * along + out[1] * up)


def plane_direction(along: Field, up: Field, projection: Field) -> tuple[Field, Field]:
    """(cos η, sin η) of the direction in the plane that has this projection on the vector (along, up).

    Of the two the one in front, or, on a vector that points ahead, the one below; NaN where there is none.
    """
    with np.errstate(invalid="ignore", divide="ignore"):
        length = np.hypot(along, up)
        cosine = projection / length
        sine = np.sqrt((1.0 - cosine) * (1.0 + cosine)) * np.where(up != 0.0, np.sign(up), np.sign(along))
        return (cosine * along + sine * up) / length, (cosine * up - sine * along) / length


def _common(field: Field) -> Field:
    """(1, 1) in place of numbers (look, 1) that are alike; looks without any agree with all."""
    known = field[np.isfinite(field)]
    if (
        field.ndim < 2
        or field.shape[1] > 1
        or not known.size
        or np.ptp(known) > _ROUNDING * max(1.0, np.abs(known).max())
    ):
        return field
    return np.full((1, 1), known.mean())
