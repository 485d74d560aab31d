"""Phase → range difference → height and ground range, in the plane of the look.

With R₁ the lower antenna's range, ΔR = R₂ − R₁ and θ′ the angle between the baseline's foot and the line of sight,
cos θ′ = ΔR/B + (ΔR² − B²)/(2 B R₁), θ = θ′ − α, z = H₁ − R₁ cos θ, ground range R₁ sin θ.
A gate's range is c t/2 of whole paths: for the mean of both receivers (and of both transmitters, when they alternate)
r = R₁ + share · ΔR, share = ½ (switched) or ¼ (single).
"""

from __future__ import annotations

import numpy as np
from numpy.typing import ArrayLike, NDArray


def path_share(transmit: str) -> float:
    """How far the gate's range lies from R₁ towards R₂, averaged over the interferograms of the mode."""
    return 0.5 if transmit == "switched" else 0.25


def height_and_ground_range(
    gate_range: ArrayLike,
    difference: ArrayLike,
    baseline: ArrayLike,
    lower_height: ArrayLike,
    tilt: ArrayLike,
    share: float,
) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
    """Height above mean sea level and ground range from the lower antenna [m]; NaN where ΔR is outside the triangle,
    or where the baseline is zero. All arguments broadcast; tilt in rad."""
    difference = np.asarray(difference, dtype=np.float64)
    lower = np.asarray(gate_range, dtype=np.float64) - share * difference
    base = np.asarray(baseline, dtype=np.float64)
    with np.errstate(invalid="ignore", divide="ignore"):
        cosine = difference / base + (difference**2 - base**2) / (2.0 * base * lower)
        cosine = np.where((np.abs(cosine) <= 1.0) & (base > 0.0), cosine, np.nan)
        sine = np.sqrt((1.0 - cosine) * (1.0 + cosine))
        down = lower * (cosine * np.cos(tilt) + sine * np.sin(tilt))
        out = lower * (sine * np.cos(tilt) - cosine * np.sin(tilt))
    return np.asarray(lower_height) - down, out


def difference_at_height(
    gate_range: ArrayLike,
    height: ArrayLike,
    baseline: ArrayLike,
    lower_height: ArrayLike,
    tilt: ArrayLike,
    share: float,
) -> NDArray[np.float64]:
    """ΔR [m] of a surface point at `height` in the gate: the exact inverse, by a few steps of the fixed point.

    ΔR enters R₁ only through share · ΔR, so each step gains a factor of about B/R.
    """
    gate_range, base = np.asarray(gate_range, dtype=np.float64), np.asarray(baseline, dtype=np.float64)
    drop = np.asarray(lower_height, dtype=np.float64) - np.asarray(height, dtype=np.float64)
    difference = np.zeros(np.broadcast_shapes(gate_range.shape, base.shape, drop.shape, np.shape(tilt)))
    for _ in range(8):
        lower = gate_range - share * difference
        level = np.sqrt(np.maximum(lower**2 - drop**2, 0.0))
        # Upper antenna relative to the lower one: B sin α outward, B cos α up.
        square = base**2 + 2.0 * base * (drop * np.cos(tilt) - level * np.sin(tilt))
        upper = np.sqrt(np.maximum(lower**2 + square, 0.0))
        difference = square / (lower + upper)
    return difference


def height_per_phase(
    gate_range: ArrayLike, difference: ArrayLike, baseline: ArrayLike, tilt: ArrayLike, wavelength: float
) -> NDArray[np.float64]:
    """|dz/dφ| at fixed range [m/rad]: λR/(2πB) for an upright baseline, larger when it leans (p = 1)."""
    base = np.asarray(baseline, dtype=np.float64)
    with np.errstate(invalid="ignore", divide="ignore"):
        cosine = np.clip(np.asarray(difference, dtype=np.float64) / base, -1.0, 1.0)
        sine = np.sqrt(1.0 - cosine**2)
        lean = np.abs(np.sin(np.arccos(cosine) - tilt) / np.maximum(sine, 1e-9))
        return wavelength * np.asarray(gate_range) / (2.0 * np.pi * base) * lean
