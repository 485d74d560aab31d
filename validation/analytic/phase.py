"""Statistics of the interferometric phase of speckle: phase in rad, coherence γ, N independent looks."""

from __future__ import annotations

import numpy as np
from numpy.typing import ArrayLike, NDArray
from scipy.special import gammaln, hyp2f1

from seamap_rt.compute.quadrature import gauss_legendre

_QUADRATURE = 256  # Gauss–Legendre nodes: the deviation is good to 1e-8 up to 200 looks


def phase_pdf_lee94(
    phase: ArrayLike, coherence: ArrayLike, looks: ArrayLike, phase0: ArrayLike = 0.0
) -> NDArray[np.float64]:
    """Density [1/rad] of the N-look phase over (−π, π]; the arguments broadcast.

    Lee, Hoppel, Mango & Miller, IEEE Trans. Geosci. Remote Sens. 32(5), 1017–1028 (1994). With β = γ cos(φ −
    φ0), its ₂F₁(N, 1; ½; β²) is taken as (1 − β²)^−(N+½) ₂F₁(½−N, −½; ½; β²) (Euler), of which the second
    factor stays bounded up to β = 1. ValueError unless 0 ≤ γ < 1 and N ≥ 1: at γ = 1 the phase is certain and
    has no density.
    """
    gamma, n = _checked(coherence, looks)
    if np.any(gamma >= 1.0):
        raise ValueError("coherence = 1: the phase is certain and has no density; give a coherence below 1")
    beta = gamma * np.cos(np.asarray(phase, dtype=np.float64) - np.asarray(phase0, dtype=np.float64))
    remainder = 1.0 - beta**2
    odd = np.exp(gammaln(n + 0.5) - gammaln(n)) * beta / (2.0 * np.sqrt(np.pi))
    even = hyp2f1(0.5 - n, -0.5, 0.5, beta**2) / (2.0 * np.pi)
    scale = ((1.0 - gamma**2) / remainder) ** n / np.sqrt(remainder)
    return np.maximum(scale * (odd + even), 0.0)  # odd and even cancel opposite to the peak


def phase_std_lee94(coherence: ArrayLike, looks: ArrayLike) -> NDArray[np.float64]:
    """Standard deviation [rad] of the N-look phase: π/√3 at γ = 0, 0 at γ = 1; the arguments broadcast.

    The variance of `phase_pdf_lee94`, integrated in t with tan(φ/2) = √(1 − γ²) tan(t/2), which spreads the
    peak.
    """
    gamma, n = np.broadcast_arrays(*_checked(coherence, looks))
    noiseless = gamma == 1.0
    gamma = np.where(noiseless, 0.0, gamma)[..., None]
    node, weight = gauss_legendre(_QUADRATURE)
    t, weight = 0.5 * np.pi * (node + 1.0), 0.5 * np.pi * weight
    width = np.sqrt((1.0 - gamma) * (1.0 + gamma))
    phase = 2.0 * np.arctan2(width * np.sin(0.5 * t), np.cos(0.5 * t))
    stretch = width / (np.cos(0.5 * t) ** 2 + (width * np.sin(0.5 * t)) ** 2)  # dφ/dt
    density = phase_pdf_lee94(phase, gamma, n[..., None])
    variance = 2.0 * np.sum(weight * stretch * density * phase**2, axis=-1)
    return np.where(noiseless, 0.0, np.sqrt(variance))


def cramer_rao_phase_std(coherence: ArrayLike, looks: ArrayLike) -> NDArray[np.float64]:
    """The Cramér–Rao bound √((1 − γ²)/(2Nγ²)) [rad], which many looks approach; inf at γ = 0.

    Rodríguez & Martin, IEE Proc. F 139(2), 147–159 (1992). At one look it is far too low: by a factor of 2.6 at
    γ = 0.99.
    """
    gamma, n = _checked(coherence, looks)
    with np.errstate(divide="ignore"):
        return np.sqrt((1.0 - gamma) * (1.0 + gamma) / (2.0 * n)) / gamma


def _checked(coherence: ArrayLike, looks: ArrayLike) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
    gamma, n = np.asarray(coherence, dtype=np.float64), np.asarray(looks, dtype=np.float64)
    if not np.all((gamma >= 0.0) & (gamma <= 1.0)):
        raise ValueError("coherence must lie within 0 to 1")
    if not np.all(n >= 1.0):
        raise ValueError("looks must be at least 1")
    return gamma, n
