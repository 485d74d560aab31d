"""What is taken from the knots of each field: sums over them in time, each with its derivatives in space.

Terms that follow from a field's base are sums of the base's derivatives in time, so that one spline gives them all.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from functools import cached_property

import numpy as np
from numpy.typing import NDArray

from .fields import ITSELF, InTime, Kind, from_base

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
    def in_lanes(self) -> NDArray[np.float32]:
        """The weights as the kernel takes them."""
        from .spline_kernel import in_lanes  # numba takes half a second to import: only where it is used

        return in_lanes(self.in_time)


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

    def in_time(factors: InTime) -> NDArray[np.float64]:
        per_step = np.array(factors) / time_step ** np.arange(len(factors))
        return np.tensordot(per_step, weights[: len(factors)], axes=1)

    return [
        Sums(kind, np.stack([in_time(factors) for factors in sums]), np.stack(list(sums.values())))
        for kind, sums in wanted.items()
    ]
