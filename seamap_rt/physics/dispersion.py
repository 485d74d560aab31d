"""Linear dispersion of gravity–capillary waves on water of any depth: ω² = (g k + (T/ρ) k³) tanh(k h).

Airy (1845) for gravity, Kelvin (1871) for surface tension. Wavenumbers in rad/m, angular frequencies in rad/s, depths
in metres (`inf` is deep water); every function broadcasts its arguments and returns float64. `Water` holds one depth
and one current, for what follows waves across a map.

Amplitude dispersion (`mutual_shift`, `sea_shift`): waves on deep water run faster because of the waves beside them. To
third order in steepness each train changes the frequency of every other (Longuet-Higgins & Phillips 1962). Of two that
run alike and have wavenumbers k₁, k₂ the one of amplitude a₁ adds a₁² k₁ k₂ min(k₁, k₂) g/ω₁ to the frequency of the
other: a long wave carries a short one as a current of its Stokes drift at the surface, a₁² k₁ ω₁, and a wave adds to
its like twice what it adds to itself, ½ (k a)² ω (Stokes 1847). Opposite ways it takes as much off. At an angle it is
the diagonal of Zakharov's (1968) kernel, here as Krasitskii (1994) has it, in whose deep-water form what divides by the
frequency of equal waves' difference vanishes. In a sea each wave of variance E' counts with a₁² = 2 E'. Where the water
is not deep, groups drive a return flow and the sign may change (Hasimoto & Ono 1972): not from here.
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import lru_cache

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
