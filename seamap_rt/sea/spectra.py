"""Frequency spectra of the sea's elevation, S(ω) [m² s], with ∫ S dω the variance; and their wavenumber form S(k) [m³].

ω in rad/s, any shape; S = 0 where ω ≤ 0. Speeds in m/s at 10 m height, lengths in metres, periods in seconds.

The wind sea from metres to millimetres is the unified spectrum of Elfouhaily, Chapron, Katsaros & Vandemark, J.
Geophys. Res. 102(C7), 15781–15796 (1997), of wavenumbers k in rad/m. The inverse wave age Ωc = U10/cp is 0.84 for a
fully developed sea and up to 5 for a very young one. Its spreading Δ is that of the *symmetric* plane spectrum, which
does not tell where waves go: a sea that travels takes the doubled down-wind half of it; Bragg scattering takes it as it
stands, ½(F(k) + F(−k)).
"""

from __future__ import annotations

import math
from collections.abc import Callable

import numpy as np
from numpy.typing import ArrayLike, NDArray

from ..conventions import GRAVITY
from ..physics.dispersion import angular_frequency, group_speed, wavenumber
from ..physics.wave_spectra import jonswap_integral, jonswap_shape

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
    limited = np.trapezoid(parent * tma_depth_factor(omega, depth), log_omega)
    return math.sqrt(float(limited / np.trapezoid(parent, log_omega)))


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


CAPILLARY_WAVENUMBER = 370.0  # rad/m, where gravity and surface tension share the phase speed's minimum
CAPILLARY_SPEED = 0.23  # m/s, that minimum
DEVELOPED_INVERSE_WAVE_AGE = 0.84
_INVERSE_WAVE_AGES = (0.8, 5.0)


def elfouhaily97(
    k: ArrayLike, wind_speed: float, inverse_wave_age: float = DEVELOPED_INVERSE_WAVE_AGE
) -> NDArray[np.float64]:
    """Omnidirectional elevation spectrum S(k) [m³], whose integral over k is the height variance.

    k: any shape, rad/m; 0 where k ≤ 0. Raises ValueError for a wind that is not positive or an inverse wave
    age outside 0.8–5. Where the paper's short-wave level αm turns negative (winds below 2.9 m/s) it is taken
    as 0.
    """
    omega_c, k_peak, u_star = _scales(wind_speed, inverse_wave_age)
    k = np.asarray(k, dtype=np.float64)
    carries = (k > 0.01 * k_peak) & (k < 1e9)  # outside, exp(−1.25 (kp/k)²) or the roll-off is 0 in float64
    k_safe = np.where(carries, k, k_peak)
    speed = _phase_speed(k_safe)
    speed_peak = float(_phase_speed(np.float64(k_peak)))
    root_ratio = np.sqrt(k_safe / k_peak)

    gamma = 1.7 if omega_c < 1.0 else 1.7 + 6.0 * math.log10(omega_c)
    width = 0.08 * (1.0 + 4.0 * omega_c**-3)
    low_cut = np.exp(-1.25 * (k_peak / k_safe) ** 2)
    peak_shape = low_cut * gamma ** np.exp(-((root_ratio - 1.0) ** 2) / (2.0 * width**2))

    age = wind_speed / speed_peak
    long_level = 6e-3 * math.sqrt(age)
    long_roll_off = np.exp(-age / math.sqrt(10.0) * (root_ratio - 1.0))
    long_waves = 0.5 * long_level * (speed_peak / speed) * long_roll_off

    friction = math.log(u_star / CAPILLARY_SPEED)
    short_level = max(0.0, 0.01 * (1.0 + (friction if friction < 0.0 else 3.0 * friction)))
    short_roll_off = np.exp(-0.25 * (k_safe / CAPILLARY_WAVENUMBER - 1.0) ** 2)
    short_waves = 0.5 * short_level * (CAPILLARY_SPEED / speed) * short_roll_off

    curvature = (long_waves + short_waves) * peak_shape
    return np.where(carries, curvature / k_safe**3, 0.0)


def elfouhaily97_spreading(
    k: ArrayLike, wind_speed: float, inverse_wave_age: float = DEVELOPED_INVERSE_WAVE_AGE
) -> NDArray[np.float64]:
    """Spreading Δ(k), 0 to 1: the plane spectrum's contrast (up-wind − cross-wind)/(up-wind + cross-wind).

    k: any shape, rad/m; 1 outside the waves' range. Raises as `elfouhaily97`.
    """
    return elfouhaily97_contrast(k, wind_speed, elfouhaily97_peak_wavenumber(wind_speed, inverse_wave_age))


def elfouhaily97_contrast(k: ArrayLike, wind_speed: float, peak_wavenumber: float) -> NDArray[np.float64]:
    """Δ(k) of `elfouhaily97_spreading` for a sea whose peak lies at `peak_wavenumber` [rad/m], whatever its age."""
    k = np.asarray(k, dtype=np.float64)
    carries = (k > 0.01 * peak_wavenumber) & (k < 1e9)
    speed = _phase_speed(np.where(carries, k, peak_wavenumber))
    speed_peak = _phase_speed(np.float64(peak_wavenumber))
    short = 0.13 * friction_velocity(wind_speed) / CAPILLARY_SPEED
    contrast = np.tanh(
        math.log(2.0) / 4.0 + 4.0 * (speed / speed_peak) ** 2.5 + short * (CAPILLARY_SPEED / speed) ** 2.5
    )
    return np.where(carries, contrast, 1.0)


def elfouhaily97_inverse_wave_age(wind_speed: float, fetch_m: float) -> float:
    """Inverse wave age Ωc at a distance fetch_m [m] from the windward shore: 0.84 for a very long one."""
    if not (wind_speed > 0.0 and fetch_m > 0.0):
        raise ValueError(f"wind_speed = {wind_speed}, fetch_m = {fetch_m}: both must be positive")
    fetch = GRAVITY * fetch_m / wind_speed**2
    return 0.84 * math.tanh((fetch / 2.2e4) ** 0.4) ** -0.75


def elfouhaily97_peak_wavenumber(wind_speed: float, inverse_wave_age: float = DEVELOPED_INVERSE_WAVE_AGE) -> float:
    """Wave number kp = g Ωc²/U10² [rad/m] of the spectrum's peak. Raises as `elfouhaily97`."""
    return _scales(wind_speed, inverse_wave_age)[1]


def _scales(wind_speed: float, inverse_wave_age: float) -> tuple[float, float, float]:
    """Ωc, the peak's wave number [rad/m] and the friction velocity u* [m/s]."""
    low, high = _INVERSE_WAVE_AGES
    if not (wind_speed > 0.0 and math.isfinite(wind_speed)):
        raise ValueError(f"wind_speed = {wind_speed}: must be positive and finite, in m/s at 10 m height")
    if not low <= inverse_wave_age <= high:
        raise ValueError(
            f"inverse_wave_age = {inverse_wave_age}: must lie within {low}–{high} (Elfouhaily 1997); "
            "0.84 is a fully developed sea"
        )
    return inverse_wave_age, GRAVITY * (inverse_wave_age / wind_speed) ** 2, friction_velocity(wind_speed)


def friction_velocity(wind_speed: float) -> float:
    """u* [m/s] of a wind at 10 m."""
    return wind_speed * math.sqrt(1e-3 * (0.8 + 0.065 * wind_speed))


def _phase_speed(k: NDArray[np.float64] | np.float64) -> NDArray[np.float64]:
    return np.asarray(np.sqrt(GRAVITY / k * (1.0 + (k / CAPILLARY_WAVENUMBER) ** 2)))
