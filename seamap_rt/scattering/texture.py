"""Texture: breakers gather in patches that live for seconds and run before the wind, lognormal and of all sizes.

Of a cell of A m² the mean power is itself random, in compound clutter with the variance 1/ν over its square (Ward,
Tough & Watts 2013, Sea Clutter). For measured seas ν ∝ ψ^(2/3) A^(5/8) (Watts & Wicks 1990): a field whose variance per
ln ℓ falls with the patches' size ℓ as ℓ^(−5/4) has that fall with A. Single breakers (`sea_spikes`) are as large as the
longest wave that breaks, of phase speed U10/1.68; patches begin there. Of the breakers' echo

    T = exp(Σ s g − ½ Σ s²),   Σ s² = ln(1 + 1/ν(ψ, ℓ₀²)),

g unit Gaussians, one an octave of ℓ from ℓ₀ on, and ν the law's of HH, whose echo at grazing is breakers' to 0.98. T
has the mean 1. In VV breakers are a fifth of the echo and T hardly tells: there the resolved waves alone make the law's
texture (validation/README.md, "Texture"). What they do in HH, where it is a fifth of it, comes on top.

A patch lives as long as the period of waves of its length, and runs at their group velocity down-wind: groups and gusts
do so. That is a choice; no published figure tells of it.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
from numpy.typing import ArrayLike, NDArray

from seamap_rt.conventions import GRAVITY
from seamap_rt.physics.dispersion import angular_frequency
from seamap_rt.scattering.sea_spikes import GRAZING_DEG, LEAST_WIND, clutter_shape_watts_wicks90

_OCTAVES = 5  # beyond, 1/75 of the variance is left
_FALL = 1.25  # of the variance with ℓ


class Texture(NamedTuple):
    """Patches of one wind; arrays (octave,)."""

    size_m: NDArray[np.float64]
    share: NDArray[np.float64]  # of the variance of ln T; their sum is 1
    life_s: NDArray[np.float64]
    speed_m_s: NDArray[np.float64]  # down-wind

    @classmethod
    def of(cls, wind_speed: float) -> Texture:
        """The texture of a wind at 10 m [m/s]."""
        longest = 2.0 * np.pi * (wind_speed / LEAST_WIND) ** 2 / GRAVITY
        size = longest * np.exp2(np.arange(_OCTAVES, dtype=np.float64))
        share = size**-_FALL
        omega = angular_frequency(2.0 * np.pi / size)
        return cls(size, share / share.sum(), 2.0 * np.pi / omega, 0.25 * omega * size / np.pi)

    def variance(self, grazing: ArrayLike) -> NDArray[np.float64]:
        """Variance of ln T, at grazing angles [rad], any shape; beyond those of the law as at the nearest."""
        angle = np.clip(np.degrees(grazing), *GRAZING_DEG)
        least = clutter_shape_watts_wicks90(1.0, float(self.size_m[0]) ** 2, "HH")
        return np.log1p(1.0 / (least * angle ** (2.0 / 3.0)))
