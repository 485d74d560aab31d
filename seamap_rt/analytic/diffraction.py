"""The field behind a knife edge, by Fresnel's integrals."""

from __future__ import annotations

import numpy as np
from numpy.typing import ArrayLike, NDArray
from scipy.special import fresnel


def knife_edge(v: ArrayLike) -> NDArray[np.complex128]:
    """F = (1 + j)/2 ∫_v^∞ exp(−jπt²/2) dt: field behind a half plane over that without it, for time exp(+jωt).

    v = h √(2(d₁ + d₂)/(λ d₁ d₂)), the edge's height h over the straight ray in Fresnel's measure, positive in shadow:
    F → 1 for v → −∞, F(0) = ½. The half plane is black and the angles are small. Born & Wolf, Principles of Optics
    (7th ed., 1999), section 8.7.3; −20 log₁₀|F| is J(ν) of ITU-R P.526. Good to 1e-16 absolutely, so that in shadow its
    relative error grows as v.
    """
    sine, cosine = fresnel(np.asarray(v, dtype=np.float64))
    return 0.5 * (1.0 + 1.0j) * ((0.5 - cosine) - 1.0j * (0.5 - sine))
