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

import numpy as np
from numpy.typing import ArrayLike, NDArray

Field = NDArray[np.float64]

_STEPS = 40  # of the fixed point at most; each gains a factor of about B/R
_PRECISION = 4.0 * np.finfo(np.float64).eps
_ALIKE = 64.0 * np.finfo(np.float64).eps  # m, or of directions: what means over a dwell's pulses round


@dataclass(frozen=True)
class Antenna:
    """One antenna as seen from the lower receiver: along the boresight, up the array, and how far in all [m]."""

    along: Field
    up: Field
    length: Field

    def mapped(self, each: Callable[[Field], Field]) -> Antenna:
        """The same antenna with a function applied to each of its arrays."""
        return Antenna(each(self.along), each(self.up), each(self.length))

    def farther(self, lower: Field, sight: tuple[Field, Field]) -> Field:
        """By how much [m] a point at range `lower` in direction `sight` is farther from it than from the lower one."""
        square = self.length**2 - 2.0 * lower * (self.along * sight[0] + self.up * sight[1])
        return square / (lower + np.sqrt(np.maximum(lower**2 + square, 0.0)))


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

    def beyond(self, lower: Field, difference: Field, sight: tuple[Field, Field]) -> Field:
        """What the gate's range has more than R₁."""
        more = self.share * difference
        for weight, antenna in self.others:
            more = more + weight * antenna.farther(lower, sight)
        return more


@dataclass(frozen=True)
class Points:
    """Where echoes come from: height above mean sea level, and outward and clockwise of the lower antenna [m]."""

    height: Field
    out: Field
    right: Field


def locate(gate_range: ArrayLike, difference: ArrayLike, fan: Fan) -> Points:
    """The point with that ΔR [m] in each gate [m], arrays that broadcast to (look, gate).

    NaN where there is no triangle, or the baseline is zero."""
    lower, sight = _sight(gate_range, difference, fan)
    rise, out = (each[0] * sight[0] + each[1] * sight[1] for each in (fan.rise, fan.out))
    return Points(fan.height + lower * rise, lower * out, lower * (fan.right * sight[1]))


def height_per_phase(
    gate_range: ArrayLike, difference: ArrayLike, fan: Fan, wavelength: float, paths: int = 1
) -> Field:
    """|dz/dφ| at fixed range [m/rad]: λR/(2πpB) for an upright array, larger when it leans. paths: p.

    dz/dη over dΔR/dη, ΔR ≈ −û·b: B/R of itself is left out.
    """
    _, sight = _sight(gate_range, difference, fan)
    with np.errstate(invalid="ignore", divide="ignore"):
        climb = fan.rise[1] * sight[0] - fan.rise[0] * sight[1]
        turn = fan.upper.up * sight[0] - fan.upper.along * sight[1]
        return wavelength * np.asarray(gate_range) / (2.0 * np.pi * paths) * np.abs(climb / turn)


def difference_at_height(gate_range: ArrayLike, height: ArrayLike, fan: Fan) -> Field:
    """ΔR [m] of the fan's point at `height` in each gate: the exact inverse of `locate`, by the fixed point.

    Straight below, where the fan does not reach so far up.
    """
    gate = np.asarray(gate_range, dtype=np.float64)
    drop = fan.height - np.asarray(height, dtype=np.float64)
    lower, difference = gate, np.zeros(())
    for _ in range(_STEPS):
        with np.errstate(divide="ignore"):  # a recording may begin at the antenna itself
            steepest = np.maximum(-drop / lower, -np.hypot(*fan.rise))
        sight = plane_direction(*fan.rise, steepest)
        difference = fan.upper.farther(lower, sight)
        after = gate - fan.beyond(lower, difference, sight)
        settled = not np.any(np.abs(after - lower) > _PRECISION * gate)
        lower = after
        if settled:
            break
    return difference


def azimuth_at_sea(
    gate_range: Field, height: Field, rise: tuple[Field, Field], out: tuple[Field, Field], right: Field
) -> Field:
    """How far [rad] clockwise of the boresight's bearing the fan meets mean sea level at a range; all broadcast."""
    along, up = plane_direction(*rise, np.maximum(-height / gate_range, -np.hypot(*rise)))
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
    if field.ndim < 2 or field.shape[1] > 1 or not known.size or np.ptp(known) > _ALIKE * max(1.0, np.abs(known).max()):
        return field
    return np.full((1, 1), known.mean())


def _sight(gate_range: ArrayLike, difference: ArrayLike, fan: Fan) -> tuple[Field, tuple[Field, Field]]:
    """R₁ and the line of sight in the plane of the fan, of a ΔR in each gate."""
    gate, difference = np.asarray(gate_range, dtype=np.float64), np.asarray(difference, dtype=np.float64)
    upper = fan.upper

    def sight(lower: Field) -> tuple[Field, Field]:
        with np.errstate(invalid="ignore", divide="ignore"):
            projection = (upper.length**2 - difference**2) / (2.0 * lower) - difference
        return plane_direction(upper.along, upper.up, projection)

    lower = gate - fan.share * difference
    for _ in range(_STEPS if fan.others else 0):
        after = gate - fan.beyond(lower, difference, sight(lower))
        settled = not np.any(np.abs(after - lower) > _PRECISION * gate)
        lower = after
        if settled:
            break
    return lower, sight(lower)
