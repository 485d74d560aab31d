"""How waves spread about their mean direction: densities over the angle, whose integral over a circle is 1.

Angles in radians from the mean direction; frequencies as f/fp, the ratio to that of the spectrum's peak; inverse wave
age U/cp, wind speed at 10 m height over the peak's phase speed. All arguments broadcast and float64 comes back.
"""

from __future__ import annotations

import math

import numpy as np
from numpy.typing import ArrayLike, NDArray

from ..physics.wave_spectra import SHARPEST_EXPONENT
from ..physics.wave_spectra import cos2s as cos2s
from ..physics.wave_spectra import cos2s_of_cosine as cos2s_of_cosine
from ..physics.wave_spectra import cos2s_peak as cos2s_peak

_HASSELMANN_EDGE = 1.05  # f/fp, where one fit hands over to the other
_EVEN = 1e-300  # sech² of a β this small is an even circle, and β/tanh βπ is still a number


def mitsuyasu_exponent(frequency_ratio: ArrayLike, inverse_wave_age: float) -> NDArray[np.float64]:
    """Exponent s of `cos2s`: smax (f/fp)^5 up to the peak, smax (f/fp)^−2.5 above, smax = 11.5 (cp/U)^2.5.

    Mitsuyasu et al. (1975), from a cloverleaf buoy in wind seas, U/cp near 1. Far from there and from the peak the same
    powers go on, down to s = 0. frequency_ratio: f/fp ≥ 0, any shape. Raises ValueError for a negative ratio or an
    inverse wave age that is not positive.
    """
    ratio = _ratio(frequency_ratio)
    age = _check_age(inverse_wave_age)
    sharpest = np.minimum(11.5 * np.float64(max(age, 1e-6)) ** -2.5, SHARPEST_EXPONENT)
    return sharpest * np.minimum(ratio, 1.0) ** 5 * np.maximum(ratio, 1.0) ** -2.5


def hasselmann_exponent(frequency_ratio: ArrayLike, inverse_wave_age: float) -> NDArray[np.float64]:
    """Exponent s of `cos2s`: 6.97 (f/fp)^4.06 below 1.05 fp, 9.77 (f/fp)^(−2.33 − 1.45 (U/cp − 1.17)) from there.

    Hasselmann, Dunckel & Ewing (1980), from a pitch–roll buoy in JONSWAP 1973, U/cp about 1.17. Elsewhere the same
    powers go on, down to s = 0. The two fits do not quite meet: 8.50 and 8.72 at U/cp = 1.17. Arguments and errors as
    `mitsuyasu_exponent`.
    """
    ratio = _ratio(frequency_ratio)
    fall = -2.33 - 1.45 * (_check_age(inverse_wave_age) - 1.17)  # below −0.6 for every age: s falls from the peak on
    below = 6.97 * np.minimum(ratio, _HASSELMANN_EDGE) ** 4.06
    above = 9.77 * np.maximum(ratio, _HASSELMANN_EDGE) ** fall
    return np.where(ratio < _HASSELMANN_EDGE, below, above)


# ------------------------------------------------------------------------------------------------------------- sech²


def donelan_banner(angle: ArrayLike, beta: ArrayLike) -> NDArray[np.float64]:
    """Density ½ β sech²(βθ)/tanh(βπ) [1/rad], θ wrapped to ±π (Donelan, Hamilton & Hui 1985).

    The paper's ½ β sech²(βθ) integrates to 1 over an endless line; tanh(βπ) is what the circle holds of it (0.1 % are
    missing at β = 1.2, 15 % at 0.4). angle: θ from the mean direction [rad], any turn; beta: β ≥ 0, 0 being an even
    circle. Raises ValueError for β < 0 or nan.
    """
    beta = np.asarray(beta, dtype=np.float64)
    if np.any(~(beta >= 0.0)):
        raise ValueError(f"beta = {np.min(beta)}: must not be negative; 0 is an even circle")
    beta = np.clip(beta, _EVEN, 1.0 / _EVEN)
    angle = np.abs(np.remainder(np.asarray(angle, dtype=np.float64) + np.pi, 2.0 * np.pi) - np.pi)
    fading = np.exp(-2.0 * beta * angle)  # sech x = 2 exp(−x)/(1 + exp(−2x)): no cosh to overflow
    return 2.0 * beta / np.tanh(beta * np.pi) * fading / (1.0 + fading) ** 2


def donelan_banner_beta(frequency_ratio: ArrayLike) -> NDArray[np.float64]:
    """β of `donelan_banner`: 2.61 (f/fp)^1.3 from 0.56 to 0.95, 2.28 (f/fp)^−1.3 to 1.6 and Banner's tail above.

    Donelan, Hamilton & Hui (1985) to f/fp = 1.6, U/cp from about 0.8 to 5; Banner (1990) from there: 10^(−0.4 + 0.8393
    exp(−0.567 ln (f/fp)²)), towards 0.40. Below 0.56, where nothing was measured, β stays what it is there, 1.23. At
    0.95 the two fits differ by 0.2 %. frequency_ratio: f/fp ≥ 0, any shape. Raises ValueError for a negative ratio.
    """
    ratio = _ratio(frequency_ratio)
    rising = 2.61 * np.clip(ratio, 0.56, 0.95) ** 1.3
    falling = 2.28 * np.clip(ratio, 0.95, 1.6) ** -1.3
    tail = 10.0 ** (-0.4 + 0.8393 * np.maximum(ratio, 1.6) ** -1.134)  # exp(−0.567 ln r²) = r^−1.134
    return np.where(ratio < 0.95, rising, np.where(ratio < 1.6, falling, tail))


# ------------------------------------------------------------------------------------------------------- half planes


def half_plane_elfouhaily(cosine: ArrayLike, contrast: ArrayLike) -> NDArray[np.float64]:
    """Density (1 + Δ cos 2θ)/π [1/rad] of a sea that travels, for |θ| < π/2; nothing runs back.

    Elfouhaily et al. (1997) give (1 + Δ cos 2θ)/2π over the whole circle, which does not separate to from fro: this is
    its forward half, doubled. Exactly across the wind, at cos θ = 0, it is not doubled.

    cosine: cos θ, θ from the mean direction; contrast: Δ, 0 to 1. Raises ValueError outside.
    """
    contrast = np.asarray(contrast, dtype=np.float64)
    if np.any(~((contrast >= 0.0) & (contrast <= 1.0))):
        worst = contrast.flat[np.argmax(np.abs(contrast - 0.5))]
        raise ValueError(f"contrast = {worst}: must lie within 0–1; take elfouhaily97_spreading's")
    cosine = np.asarray(cosine, dtype=np.float64)
    share = np.heaviside(cosine, 0.5) / np.pi
    return share * (1.0 + contrast * (2.0 * cosine**2 - 1.0))


# -------------------------------------------------------------------------------------------------------- arguments


def _ratio(frequency_ratio: ArrayLike) -> NDArray[np.float64]:
    ratio = np.asarray(frequency_ratio, dtype=np.float64)
    if np.any(~(ratio >= 0.0)):
        raise ValueError(f"frequency_ratio = {np.min(ratio)}: must not be negative; give f over the peak's f")
    return ratio


def _check_age(inverse_wave_age: float) -> float:
    if not 0.0 < inverse_wave_age < math.inf:
        raise ValueError(
            f"inverse_wave_age = {inverse_wave_age}: must be positive and finite; 0.84 is a fully developed sea"
        )
    return float(inverse_wave_age)
