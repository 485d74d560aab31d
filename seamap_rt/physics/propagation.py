"""How straight rays and sharp shadows differ from real ones: the Earth's curvature, and the light behind an edge."""

from __future__ import annotations

import numpy as np

from ..conventions import EARTH_RADIUS

REFRACTED_RADIUS = 4.0 / 3.0 * EARTH_RADIUS  # m, of standard refraction


def earth_drop_m(ground_range_m: float) -> float:
    """By how much [m] the Earth falls away beneath the tangent plane, √(R² + d²) − R with 4/3 of its radius."""
    return ground_range_m**2 / (REFRACTED_RADIUS + float(np.hypot(REFRACTED_RADIUS, ground_range_m)))


def edge_blur_m(wavelength_m: float, to_edge_m: float, beyond_m: float) -> float:
    """Height [m] over which a knife edge's shadow fades, v = 1: √(λ d₁d₂/(2 (d₁ + d₂))) (ITU-R P.526, section 4.1)."""
    return float(np.sqrt(0.5 * wavelength_m * to_edge_m * beyond_m / (to_edge_m + beyond_m)))
