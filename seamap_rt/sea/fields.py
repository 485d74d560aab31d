"""The functions that hold first-order waves (Airy 1845), and how they follow from each other by derivatives in time.

The elevation η = Re Σ a e^{iθ}, θ = k·x − ωt; χ = Re Σ a coth(kh)/k e^{iθ}, whose gradient is the horizontal
displacement of the water at the surface; Φ = ∂χ/∂t, the velocity potential there, whose gradient is the horizontal
flow; and ψ with ∂ψ/∂t + μ ψ = Φ, the shift that acts on waves which relax at the rate μ.

At the surface ∂Φ/∂t = −g η, at any depth (Bernoulli). So one spline of ψ, Φ or χ holds the heights and the flow too:
that is a third of the FFTs. Surface tension would add (T/ρ) ∇²η. It is left out of the flow, not of the heights:
what a field is made from is scaled so that its heights are those of the waves.

`sums_of` says what is taken from the knots of each field: terms that follow from a field's base are sums of the base's
derivatives in time, so that one spline gives them all.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from functools import cached_property
from typing import Literal

import numpy as np
from numpy.polynomial import polynomial
from numpy.typing import ArrayLike, NDArray

from ..conventions import GRAVITY, SURFACE_TENSION, WATER_DENSITY
from ..physics.dispersion import orbital_ratio
from .lattice import Lattice


@dataclass(frozen=True)
class RelaxedShift:
    """The field ψ [m²] with ∂ψ/∂t + rate ψ = Φ; its gradient is what short waves that the flow carries along, and that
    relax at the rate [1/s], have been moved by (Alpers & Hasselmann 1978). At rate 0 it is χ."""

    rate: float


Kind = Literal["elevation", "potential", "shift"] | RelaxedShift  # η [m], Φ [m²/s], χ [m²], ψ [m²]
InTime = tuple[float, ...]
"""A sum of derivatives in time: the factor [s^n] of each derivative n = 0, 1, …"""

ITSELF: InTime = (1.0,)


def from_base(kind: Kind, base: Kind | None) -> InTime | None:
    """The sum of a base's derivatives in time that is a field; None where the field does not follow from it."""
    if base is None or base == "elevation":
        return None
    if kind == base:
        return ITSELF
    potential: InTime = {"potential": ITSELF, "shift": (0.0, 1.0)}[base] if isinstance(base, str) else (base.rate, 1.0)
    if kind == "potential":
        return potential
    return (0.0, *(-factor / GRAVITY for factor in potential)) if kind == "elevation" else None


def harmonic_factors(factors: InTime, omega: NDArray[np.float64]) -> NDArray[np.complex128]:
    """Factors by which a sum of derivatives in time multiplies e^{−iωt}, ω [rad/s]."""
    return np.asarray(polynomial.polyval(-1j * omega, factors), dtype=np.complex128)


def per_elevation(kind: Kind, lattice: Lattice, base: Kind | None = None) -> NDArray[np.complex128]:
    """A field's amplitude per elevation on the quadrant, of waves that run along +k; of the `base` as its derivatives
    make the elevation."""
    omega = np.where(lattice.omega > 0.0, lattice.omega, 1.0)  # no wave, and no shift, at k = 0
    if kind == base and (heights := from_base("elevation", base)) is not None:
        return np.where(lattice.omega > 0.0, 1.0 / harmonic_factors(heights, omega), 0.0)
    k = lattice.quadrant(lambda k: np.where(k > 0.0, k, np.inf))
    shift = (orbital_ratio(k, lattice.depth) / k).astype(np.complex128)
    if kind == "shift":
        return shift
    if kind == "potential":  # ∂χ/∂t
        return -1j * lattice.omega * shift
    if isinstance(kind, RelaxedShift):
        return omega / (omega + 1j * kind.rate) * shift
    return np.ones_like(shift)


def flow_missed(k: ArrayLike) -> NDArray[np.float64]:
    """The share of waves' flow that is missed where it is made from their heights without surface tension."""
    return SURFACE_TENSION / (WATER_DENSITY * GRAVITY) * np.square(k)


DERIVATIVES = ((0, 0), (1, 0), (0, 1), (2, 0), (1, 1), (0, 2))
"""How often each value of a sum is differentiated along rows and columns."""


@dataclass(frozen=True)
class Term:
    """What to evaluate: a field, and how often it is differentiated along rows (y), columns (x) and time."""

    kind: Kind
    row: int = 0
    column: int = 0
    time: int = 0


@dataclass(frozen=True)
class Sums:
    """What is taken from the knots of one field."""

    kind: Kind
    in_time: NDArray[np.float64]  # (sum, power, tap), weights of the knots around a time
    output_row: NDArray[np.int64]  # (sum, derivative in space), −1 for none

    @cached_property
    def lane_weights(self) -> NDArray[np.float32]:
        """The weights as the kernel takes them."""
        from .spline_kernel import pad_to_lanes  # numba takes half a second to import: only where it is used

        return pad_to_lanes(self.in_time)


def sums_of(terms: Sequence[Term], base: Kind | None, weights: NDArray[np.float64], time_step: float) -> list[Sums]:
    """The sums for terms, by the field that has the knots. weights: (derivative, power, tap) of knots a time step [s]
    apart, as `spline.bspline_polynomials` gives them; output rows are the terms' numbers."""
    wanted: dict[Kind, dict[InTime, NDArray[np.int64]]] = {}
    for index, term in enumerate(terms):
        follows = from_base(term.kind, base)
        kind, factors = (term.kind, ITSELF) if base is None or follows is None else (base, follows)
        sums = wanted.setdefault(kind, {})
        output_row = sums.setdefault((0.0,) * term.time + factors, np.full(len(DERIVATIVES), -1))
        output_row[DERIVATIVES.index((term.row, term.column))] = index

    def time_weights(factors: InTime) -> NDArray[np.float64]:
        per_step = np.array(factors) / time_step ** np.arange(len(factors))
        return np.tensordot(per_step, weights[: len(factors)], axes=1)

    return [
        Sums(kind, np.stack([time_weights(factors) for factors in sums]), np.stack(list(sums.values())))
        for kind, sums in wanted.items()
    ]
