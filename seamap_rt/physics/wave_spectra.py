"""Shapes of wave spectra that both the sea and those who look for it in maps need: JONSWAP and cos^2s(θ/2)."""

from __future__ import annotations

import math
from functools import lru_cache

import numpy as np
import scipy
from numpy.typing import ArrayLike, NDArray

from ..compute.quadrature import gauss_legendre

SHARPEST_EXPONENT = 1e15  # rms angle 4e-8 rad: a long-crested sea, as far as float64 can tell


def jonswap_shape(ratio: NDArray[np.float64], gamma: float) -> NDArray[np.float64]:
    """(f/fp)⁻⁵ exp(−1.25 (fp/f)⁴) γ^r of ratios f/fp > 0 (Hasselmann et al. 1973), without a unit."""
    inverse4 = ratio**-4
    return inverse4 / ratio * np.exp(-1.25 * inverse4) * _enhancement(ratio, gamma)


def _enhancement(ratio: NDArray[np.float64], gamma: float) -> NDArray[np.float64]:
    """γ^r: the peak's enhancement, 7 % wide below the peak and 9 % above."""
    width = np.where(ratio <= 1.0, 0.07, 0.09)
    return np.exp(math.log(gamma) * np.exp(-0.5 * ((ratio - 1.0) / width) ** 2))


@lru_cache(maxsize=256)
def jonswap_integral(gamma: float) -> float:
    """∫ of the shape over ω/ωp, to 1e-12: with u = (ωp/ω)⁴ it is ¼ ∫ exp(−1.25 u) γ^r du over u > 0.

    Gauss–Legendre panels; u = 1, where the peak's width jumps, is an edge. γ = 1 gives 1/5.
    """
    nodes, weights = gauss_legendre(40)
    edges = np.array([0.0, 0.25, 0.5, 0.75, 1.0, 1.25, 1.5, 2.0, 3.0, 6.0, 12.0, 30.0])
    half = 0.5 * np.diff(edges)[:, None]
    u = edges[:-1, None] + half * (1.0 + nodes)
    return float(np.sum(half * weights * 0.25 * np.exp(-1.25 * u) * _enhancement(u**-0.25, gamma)))


def cos2s(angle: ArrayLike, exponent: ArrayLike) -> NDArray[np.float64]:
    """Density D(θ) = N cos^2s(θ/2) [1/rad] (Longuet-Higgins, Cartwright & Smith 1963).

    angle: θ from the mean direction [rad], any shape and any turn; exponent: s ≥ 0, 0 being an even circle. Raises
    ValueError for s < 0 or nan.
    """
    return cos2s_of_cosine(np.cos(np.asarray(angle, dtype=np.float64)), exponent)


def cos2s_of_cosine(cosine: ArrayLike, exponent: ArrayLike) -> NDArray[np.float64]:
    """`cos2s` from cos θ, with cos²(θ/2) = (1 + cos θ)/2: a dot product is all that it takes."""
    exponent = np.asarray(exponent, dtype=np.float64)
    if np.any(~(exponent >= 0.0)):
        raise ValueError(f"exponent = {np.min(exponent)}: must not be negative; 0 is an even circle")
    exponent = np.minimum(exponent, SHARPEST_EXPONENT)
    half_angle = np.clip(0.5 * (1.0 + np.asarray(cosine, dtype=np.float64)), 0.0, 1.0)
    return cos2s_peak(exponent) * half_angle**exponent


def cos2s_peak(exponent: ArrayLike) -> NDArray[np.float64]:
    """N = 2^(2s−1) Γ²(s+1)/(π Γ(2s+1)) [1/rad], which Legendre's duplication makes Γ(s+1)/(2√π Γ(s+½)).

    From logarithms, since Γ leaves float64 at s = 170. They lose digits as s grows: from 1000 the ratio's expansion for
    large s, √w (1 + 1/(64 w²)) with w = s + ¼ (Tricomi & Erdélyi 1951), keeps them all.
    """
    s = np.asarray(exponent, dtype=np.float64)
    moderate, w = np.minimum(s, 1e3), s + 0.25
    series = np.sqrt(w) * (1.0 + (0.125 / w) ** 2)
    ratio = np.where(
        s < 1e3, np.exp(scipy.special.gammaln(moderate + 1.0) - scipy.special.gammaln(moderate + 0.5)), series
    )
    return ratio / (2.0 * math.sqrt(math.pi))
