"""Frequency spectra of the sea's elevation, S(ω) [m² s], with ∫ S dω the variance; and their wavenumber form S(k) [m³].

ω in rad/s, any shape; S = 0 where ω ≤ 0. Speeds in m/s at 10 m height, lengths in metres, periods in seconds.
"""

from __future__ import annotations

import math
from collections.abc import Callable

import numpy as np
from numpy.typing import ArrayLike, NDArray

from ..conventions import GRAVITY
from ..physics.dispersion import angular_frequency, group_speed, wavenumber
from ..physics.wave_spectra import jonswap_integral, jonswap_shape
from .elfouhaily import elfouhaily97

__all__ = [
    "elfouhaily97",
    "jonswap",
    "jonswap_fetch",
    "peak_frequency_jonswap",
    "peak_frequency_pierson_moskowitz",
    "pierson_moskowitz",
    "pierson_moskowitz_scaled",
    "tma",
    "tma_depth_factor",
    "tma_height_ratio",
    "wavenumber_spectrum",
]

_PM_LEVEL, _PM_DECAY = 8.1e-3, 0.74  # α, β
_PM_WIND_HEIGHT_RATIO = 1.026  # U19.5/U10


def pierson_moskowitz(omega: ArrayLike, *, wind_speed: float) -> NDArray[np.float64]:
    """Fully developed sea: α g² ω⁻⁵ exp(−β (g/(U ω))⁴), U at 19.5 m height (Pierson & Moskowitz 1964)."""
    _require_positive(wind_speed=wind_speed)
    omega, waves = _positive(omega)
    cut = _PM_DECAY * (GRAVITY / (_PM_WIND_HEIGHT_RATIO * wind_speed * omega)) ** 4
    return np.where(waves, _PM_LEVEL * GRAVITY**2 * omega**-5 * np.exp(-cut), 0.0)


def peak_frequency_pierson_moskowitz(wind_speed: float) -> float:
    """ω [rad/s] of the peak of `pierson_moskowitz`, (4β/5)^¼ g/U19.5."""
    return (0.8 * _PM_DECAY) ** 0.25 * GRAVITY / (_PM_WIND_HEIGHT_RATIO * wind_speed)


def pierson_moskowitz_scaled(omega: ArrayLike, hs: float, tp: float) -> NDArray[np.float64]:
    """Pierson–Moskowitz shape scaled to Hs and Tp (Bretschneider 1959; also ITTC's two-parameter form)."""
    return jonswap(omega, hs, tp, 1.0)


def jonswap(omega: ArrayLike, hs: float, tp: float, gamma: float = 3.3) -> NDArray[np.float64]:
    """Growing sea (Hasselmann et al. 1973) scaled so that 4 √m0 = Hs, the integral running over all ω."""
    _require_positive(tp=tp, gamma=gamma)
    if not hs >= 0.0:
        raise ValueError(f"hs = {hs}: must not be negative")
    peak = 2.0 * math.pi / tp
    variance = (hs / 4.0) ** 2
    return variance / (peak * jonswap_integral(gamma)) * _jonswap_shape(omega, peak, gamma)


def jonswap_fetch(omega: ArrayLike, wind_speed: float, fetch: float, gamma: float = 3.3) -> NDArray[np.float64]:
    """Growing sea by wind and fetch: α = 0.076 ξ^−0.22, fp U/g = 3.5 ξ^−0.33, ξ = gF/U² (Hasselmann et al. 1973)."""
    _require_positive(wind_speed=wind_speed, fetch=fetch, gamma=gamma)
    level = 0.076 * (GRAVITY * fetch / wind_speed**2) ** -0.22
    peak = peak_frequency_jonswap(wind_speed, fetch)
    return level * GRAVITY**2 * peak**-5 * _jonswap_shape(omega, peak, gamma)


def peak_frequency_jonswap(wind_speed: float, fetch: float) -> float:
    """ω [rad/s] of the peak of `jonswap_fetch`."""
    return 2.0 * math.pi * 3.5 * (GRAVITY * fetch / wind_speed**2) ** -0.33 * GRAVITY / wind_speed


def tma(omega: ArrayLike, hs: float, tp: float, gamma: float, depth: float) -> NDArray[np.float64]:
    """Sea in water of finite depth: JONSWAP × Φ (Bouws, Günther, Rosenthal & Vincent 1985).

    hs, tp and gamma are those of the deep-water JONSWAP spectrum; the product's own height is lower.
    """
    return jonswap(omega, hs, tp, gamma) * tma_depth_factor(omega, depth)


def tma_depth_factor(omega: ArrayLike, depth: float) -> NDArray[np.float64]:
    """Φ = tanh²(kh)/(1 + 2kh/sinh 2kh), k by gravity alone (Kitaigorodskii, Krasitskii & Zaslavskii 1975)."""
    omega, waves = _positive(omega)
    x = np.minimum(wavenumber(omega, depth, surface_tension=0.0) * depth, 300.0)
    return np.where(waves, np.tanh(x) ** 2 / (1.0 + 2.0 * x / np.sinh(2.0 * x)), 0.0)


def tma_height_ratio(tp: float, gamma: float, depth: float) -> float:
    """Height of the TMA spectrum over that of its JONSWAP parent, √(∫ S Φ dω/∫ S dω); 1 in deep water."""
    _require_positive(tp=tp, gamma=gamma)
    log_omega = np.linspace(math.log(0.05), math.log(200.0), 20_001) + math.log(2.0 * math.pi / tp)
    omega = np.exp(log_omega)
    parent = jonswap(omega, 1.0, tp, gamma) * omega
    kept = np.trapezoid(parent * tma_depth_factor(omega, depth), log_omega)
    return math.sqrt(float(kept / np.trapezoid(parent, log_omega)))


def wavenumber_spectrum(
    frequency_spectrum: Callable[[NDArray[np.float64]], NDArray[np.float64]], k: ArrayLike, depth: float
) -> NDArray[np.float64]:
    """S(k) = S(ω) dω/dk [m³] with the dispersion of the depth; 0 where k ≤ 0."""
    k, waves = _positive(k)
    return np.where(waves, frequency_spectrum(angular_frequency(k, depth)) * group_speed(k, depth), 0.0)


# ------------------------------------------------------------------------------------------------- JONSWAP's shape


def _jonswap_shape(omega: ArrayLike, peak: float, gamma: float) -> NDArray[np.float64]:
    """`jonswap_shape` of ω/ωp; 0 where there are no waves."""
    omega, waves = _positive(omega)
    return np.where(waves, jonswap_shape(omega / peak, gamma), 0.0)


def _positive(value: ArrayLike) -> tuple[NDArray[np.float64], NDArray[np.bool_]]:
    """Where waves are, and values that are safe to divide by everywhere; below 1e-30 every spectrum here is 0."""
    value = np.asarray(value, dtype=np.float64)
    waves = value > 1e-30
    return np.where(waves, value, 1.0), waves


def _require_positive(**values: float) -> None:
    for name, value in values.items():
        if not (value > 0.0 and math.isfinite(value)):
            raise ValueError(f"{name} = {value}: must be positive and finite")
