"""How waves spread about their mean direction: densities over the angle, whose integral over a circle is 1."""

from __future__ import annotations

import math

import numpy as np
from numpy.typing import ArrayLike, NDArray
from scipy.special import gammaln


def cos2s(angle: ArrayLike, exponent: float) -> NDArray[np.float64]:
    """Density D(θ) = N cos^2s(θ/2) [1/rad] (Longuet-Higgins, Cartwright & Smith 1963).

    angle: θ from the mean direction [rad], any shape and any turn; exponent: s ≥ 0. Raises ValueError for s < 0.
    """
    return cos2s_of_cosine(np.cos(np.asarray(angle, dtype=np.float64)), exponent)


def cos2s_of_cosine(cosine: ArrayLike, exponent: float) -> NDArray[np.float64]:
    """`cos2s` from cos θ, with cos²(θ/2) = (1 + cos θ)/2: a dot product is all that it takes."""
    if not exponent >= 0.0:
        raise ValueError(f"exponent = {exponent}: must not be negative")
    half_angle = np.clip(0.5 * (1.0 + np.asarray(cosine, dtype=np.float64)), 0.0, 1.0)
    return cos2s_peak(exponent) * half_angle**exponent


def cos2s_peak(exponent: float) -> float:
    """N = 2^(2s−1) Γ²(s+1)/(π Γ(2s+1)) [1/rad], from logarithms: Γ(2s+1) leaves float64 at s = 85."""
    s = exponent
    return (
        math.exp((2.0 * s - 1.0) * math.log(2.0) + 2.0 * float(gammaln(s + 1.0)) - float(gammaln(2.0 * s + 1.0)))
        / math.pi
    )
