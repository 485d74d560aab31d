"""Amplitude dispersion: how much faster waves run on deep water because of the waves beside them.

To third order in steepness each train of waves changes the frequency of every other (Longuet-Higgins & Phillips 1962).
Of two that run alike and have wavenumbers k₁, k₂ the one of amplitude a₁ adds a₁² k₁ k₂ min(k₁, k₂) g/ω₁ to the
frequency of the other: a long wave carries a short one as a current of its Stokes drift at the surface, a₁² k₁ ω₁, and
a wave adds to its like twice what it adds to itself, ½ (k a)² ω (Stokes 1847). Opposite ways it takes as much off. At
an angle it is the diagonal of Zakharov's (1968) kernel, here as Krasitskii (1994) has it, in whose deep-water form what
divides by the frequency of equal waves' difference vanishes. In a sea each wave of variance E' counts with a₁² = 2 E'.

Wavenumbers in rad/m, frequencies in rad/s, amplitudes in m; every function broadcasts its arguments and gives float64.
Where the water is not deep, groups drive a return flow and the sign may change (Hasimoto & Ono 1972): not from here.
"""

from __future__ import annotations

from functools import lru_cache

import numpy as np
from numpy.typing import ArrayLike, NDArray

from ..conventions import GRAVITY

Field = NDArray[np.float64]

DEEP_ENOUGH = 2.0  # k h of the peak: there Stokes' wave runs by 1.08 times its deep-water correction, at 3 by 1.01


def mutual_shift(k: ArrayLike, other: ArrayLike, angle: ArrayLike) -> Field:
    """What waves of wavenumber `other` and amplitude a, at an angle [rad], add to the frequency of waves of wavenumber
    k, over a² [rad/s/m²]. Both wavenumbers above 0."""
    a, b, angle = np.broadcast_arrays(*(np.asarray(each, np.float64) for each in (k, other, angle)))
    kernel = _kernel(a, b, a * b * np.cos(angle))
    return kernel * np.sqrt(GRAVITY / b)


def sea_shift(k: Field, variance: Field) -> Field:
    """What all waves of a sea together add to the frequency of each, (ring, direction) [rad/s].

    k: (ring,) evenly spaced in its logarithm; variance: m², (ring, direction), of waves that run in directions even
    over the circle.
    """
    rings, ways = variance.shape
    table = _table(rings, float(np.log(k[-1] / k[0])) / (rings - 1), ways)
    # Of ring i by ring j: k_j^(5/2) times what the ratio k_i/k_j makes of it.
    pairs = table[np.subtract.outer(np.arange(rings), np.arange(rings)) + rings - 1]
    caused = np.fft.rfft(2.0 * variance * k[:, None] ** 2.5, axis=1)
    return np.fft.irfft(np.einsum("ijn,jn->in", pairs, caused), ways, axis=1)


@lru_cache(maxsize=4)
def _table(rings: int, step: float, ways: int) -> NDArray[np.complex128]:
    """`mutual_shift` of waves of 1 rad/m upon others, (ratio of these, harmonic of the angle)."""
    ratio = np.exp(step * np.arange(1 - rings, rings))
    angle = 2.0 * np.pi * np.arange(ways) / ways
    return np.fft.rfft(mutual_shift(ratio[:, None], 1.0, angle), axis=1)


def _kernel(a: Field, b: Field, dot: Field) -> Field:
    """4π² T(k₁, k₂, k₁, k₂) [rad³/m³] of wavenumbers a, b and k₁·k₂, in units of g = 1, which T does not hold."""
    together = np.sqrt(np.maximum(a * a + b * b + 2.0 * dot, 0.0))  # of k₁ + k₂
    apart = np.sqrt(np.maximum(a * a + b * b - 2.0 * dot, 0.0))  # of k₂ − k₁
    root = np.sqrt(a * b)
    quartic = 4.0 * root**2 * (together - apart) - root * (4.0 * (a * a + b * b) - 2.0 * (a + b) * (together + apart))
    # Each bound wave by its three wavenumbers and scalar products, and the frequency by which it is off resonance.
    plus, minus = np.sqrt(together), np.sqrt(apart)
    sum_wave = _bound(together, a, b, a * a + dot - together * a, b * b + dot - together * b, dot + a * b)
    counter = _bound(together, a, b, together * a - a * a - dot, together * b - b * b - dot, dot + a * b)
    longer = _bound(b, a, apart, dot - a * b, b * b - dot - b * apart, dot - a * a + a * apart)
    shorter = _bound(a, b, apart, dot - a * b, a * a - dot - a * apart, dot - b * b + b * apart)
    slow, fast = np.sqrt(a), np.sqrt(b)
    cubic = (
        _over(sum_wave, plus - slow - fast)
        + _over(counter, plus + slow + fast)
        + _over(longer, slow + minus - fast)
        + _over(shorter, fast + minus - slow)
    )
    return (quartic - cubic) / 16.0


def _bound(a: Field, b: Field, c: Field, by_c: Field, by_b: Field, by_a: Field) -> Field:
    """(8π√2 V)² of three waves, by what scalar products make of each pair; 0 where one has no length."""
    least = np.minimum(np.minimum(a, b), c)
    there = least > 1e-12 * np.maximum(np.maximum(a, b), c)
    a, b, c = (np.where(there, each, 1.0) for each in (a, b, c))
    whole = by_c * (c / (a * b)) ** 0.25 + by_b * (b / (a * c)) ** 0.25 + by_a * (a / (b * c)) ** 0.25
    return np.where(there, whole**2, 0.0)


def _over(square: Field, off: Field) -> Field:
    return square / np.where(square > 0.0, off, 1.0)
