"""Linear dispersion of gravity–capillary waves on water of any depth: ω² = (g k + (T/ρ) k³) tanh(k h).

Airy (1845) for gravity, Kelvin (1871) for surface tension. Wavenumbers in rad/m, angular frequencies in rad/s, depths
in metres (`inf` is deep water); every function broadcasts its arguments and returns float64. `Water` holds one depth
and one current, for what follows waves across a map.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike, NDArray

from ..conventions import GRAVITY, SURFACE_TENSION, WATER_DENSITY

_DEEP_FOR_ALL_M = 1e8  # farther down no wave reaches, and products with it could overflow
_NEWTON_STEPS = 12  # 7 suffice from 0.05 m to deep water and from swell to millimetre ripples; more cost nothing


def angular_frequency(
    k: ArrayLike, depth: ArrayLike = np.inf, *, surface_tension: float = SURFACE_TENSION
) -> NDArray[np.float64]:
    """Angular frequency ω [rad/s] of wavenumber k ≥ 0 [rad/m]. Raises ValueError for k < 0 or depth ≤ 0."""
    k, depth = _checked(k, "k", depth)
    tension = surface_tension / WATER_DENSITY
    # Two roots, not the root of the product: the product underflows long before its root does.
    return np.sqrt(k * (GRAVITY + tension * k**2)) * np.sqrt(np.tanh(_relative_depth(k, depth)))


def wavenumber(
    omega: ArrayLike, depth: ArrayLike = np.inf, *, surface_tension: float = SURFACE_TENSION
) -> NDArray[np.float64]:
    """Wavenumber k [rad/m] of angular frequency ω ≥ 0 [rad/s], to about 1e-14 of itself.

    Newton's method on ln ω as a function of ln k: its slope lies between ½ (deep gravity waves) and 2 (shallow
    capillary ones), so it converges from any start. Raises ValueError for ω < 0 or depth ≤ 0.
    """
    omega, depth = _checked(omega, "omega", depth)
    moving = omega > 1e-150  # below, k is 0 to the last digit, and the shallow limit would divide 0 by 0
    target = np.where(moving, omega, 1.0)
    deep = target**2 / GRAVITY
    k = np.maximum(deep, target / np.sqrt(GRAVITY * depth))  # exact in the deep and in the shallow limit
    for _ in range(_NEWTON_STEPS):
        miss = target / angular_frequency(k, depth, surface_tension=surface_tension)
        k = k * miss ** (1.0 / _log_slope(k, depth, surface_tension))
    return np.where(moving, k, 0.0)


def group_speed(
    k: ArrayLike, depth: ArrayLike = np.inf, *, surface_tension: float = SURFACE_TENSION
) -> NDArray[np.float64]:
    """Group speed dω/dk [m/s]; √(g h) at k = 0 (infinite in deep water). Raises as `angular_frequency`."""
    k, depth = _checked(k, "k", depth)
    tension = surface_tension / WATER_DENSITY
    x = _relative_depth(k, depth)
    with np.errstate(divide="ignore", invalid="ignore"):
        finite = depth * np.where(x > 0.0, np.tanh(x) / x, 1.0)
        tanh_over_k = np.where(np.isinf(depth), 1.0 / k, finite)
    return np.sqrt((GRAVITY + tension * k**2) * tanh_over_k) * _log_slope(k, depth, surface_tension)


@dataclass(frozen=True)
class Water:
    """The water under waves of gravity: its depth [m] (`inf` is deep) and a uniform current (east, north) [m/s].

    Intrinsic frequencies are those that one meets who drifts with the current; a map fixed to the ground sees them
    shifted by k·U (Doppler). Surface tension is left out: it changes the frequency of waves longer than 7 m, the
    shortest that a map shows, by less than 3e-6. Raises ValueError for a depth that is not positive and a current that
    is not finite.
    """

    depth: float = np.inf
    current: tuple[float, float] = (0.0, 0.0)

    def __post_init__(self) -> None:
        if not self.depth > 0.0:
            raise ValueError(
                f"depth = {self.depth:g}: must be positive; give the water's depth in metres, inf for deep water"
            )
        if not np.isfinite(self.current).all():
            raise ValueError(f"current = {self.current}: must be finite; give its speed east and north in m/s")

    def frequency(self, k: ArrayLike) -> NDArray[np.float64]:
        """Intrinsic angular frequency σ = √(g k tanh kh) [rad/s] of wavenumbers k ≥ 0 [rad/m]."""
        return angular_frequency(k, self.depth, surface_tension=0.0)

    def wavenumber(self, frequency: ArrayLike) -> NDArray[np.float64]:
        """Wavenumber [rad/m] of an intrinsic angular frequency [rad/s]."""
        return wavenumber(frequency, self.depth, surface_tension=0.0)

    def group_speed(self, k: ArrayLike) -> NDArray[np.float64]:
        """Speed of the groups through the water [m/s] of wavenumbers k > 0 [rad/m]."""
        k = np.asarray(k, dtype=np.float64)
        return self.frequency(k) / k * _log_slope(k, np.asarray(self.depth, dtype=np.float64), 0.0)

    def doppler_shift(self, kx: NDArray[np.float64], ky: NDArray[np.float64]) -> NDArray[np.float64]:
        """k·U [rad/s] of wavevectors (kx east, ky north) [rad/m]: what the current adds to a wave's frequency."""
        return kx * self.current[0] + ky * self.current[1]


DEEP_WATER = Water()


def orbital_ratio(k: ArrayLike, depth: ArrayLike) -> NDArray[np.float64]:
    """Horizontal over vertical amplitude of the water's orbit at the surface, coth kh (Airy 1845); for k > 0."""
    return 1.0 / np.tanh(np.asarray(k, dtype=np.float64) * np.asarray(depth, dtype=np.float64))


def _log_slope(k: NDArray[np.float64], depth: NDArray[np.float64], surface_tension: float) -> NDArray[np.float64]:
    """d ln ω / d ln k, the ratio of group to phase speed."""
    tension = surface_tension / WATER_DENSITY
    double = 2.0 * np.clip(_relative_depth(k, depth), 1e-100, 300.0)  # beyond, x/sinh x is 1 or 0 to the last digit
    capillary = tension * k**2
    return 0.5 * ((GRAVITY + 3.0 * capillary) / (GRAVITY + capillary) + double / np.sinh(double))


def _relative_depth(k: NDArray[np.float64], depth: NDArray[np.float64]) -> NDArray[np.float64]:
    """k h, with 0 · ∞ = ∞: deep water stays deep for the longest wave."""
    return np.where(np.isinf(depth), np.inf, k * np.where(np.isinf(depth), 1.0, depth))


def _checked(value: ArrayLike, name: str, depth: ArrayLike) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
    value, depth = np.asarray(value, dtype=np.float64), np.asarray(depth, dtype=np.float64)
    if np.any(~(value >= 0.0)):
        raise ValueError(f"{name}: must not be negative or nan")
    if np.any(~(depth > 0.0)):
        raise ValueError("depth: must be positive, in metres; inf is deep water")
    return value, np.where(depth > _DEEP_FOR_ALL_M, np.inf, depth)
