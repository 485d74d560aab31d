"""Published figures of the high-order spectral method: how far W of exact steady deep-water waves is off.

Dommermuth & Yue (1987) took the surface and the potential of exact waves of half height a and gave the greatest error
of the vertical velocity of the water there, over √(g/k), by the order M and the modes N kept. Their table, and what
HOS-ocean finds with products wholly de-aliased, stand in HOS-ocean's own benchmark (Ducrozet, Bonnefoy, Le Touzé &
Ferrant, Comput. Phys. Commun. 2016; github.com/LHEEA/HOS-ocean, sources/Benchmark/check_W_DYue.f90), from which they
are taken: the entries of orders 2 and 4, the even ones that this program has. Two digits are given of each. Their last
rows, of ka = 0.4, are left out: `steady_wave` finds no wave so steep to rounding.
"""

from __future__ import annotations

from functools import cache

import numpy as np

from seamap_rt.conventions import GRAVITY
from seamap_rt.sea.high_order import Band, Rates

from .steady_waves import SteadyWave, steady_wave

# By (ka, N): at M = 2 and at M = 4.
DOMMERMUTH_YUE = {
    (0.1, 8): (7.5e-4, 6.8e-6),
    (0.1, 16): (7.5e-4, 6.8e-6),
    (0.2, 8): (5.9e-3, 2.2e-4),
    (0.2, 16): (6.0e-3, 2.2e-4),
    (0.2, 32): (6.0e-3, 2.2e-4),  # the benchmark has 6.0e-4 at M = 2, a zero too many: every other row has 6e-3
    (0.3, 8): (1.9e-2, 2.2e-3),
    (0.3, 16): (2.0e-2, 1.8e-3),
    (0.3, 32): (2.0e-2, 1.8e-3),
    (0.3, 64): (2.0e-2, 1.8e-3),
    (0.35, 8): (3.1e-2, 6.4e-3),
    (0.35, 16): (3.1e-2, 4.1e-3),
    (0.35, 32): (3.1e-2, 4.0e-3),
    (0.35, 64): (3.1e-2, 4.0e-3),
}
HOS_OCEAN = {
    (0.1, 8): (7.2e-4, 6.4e-6),
    (0.1, 16): (7.4e-4, 6.8e-6),
    (0.2, 8): (5.9e-3, 2.3e-4),
    (0.2, 16): (5.9e-3, 2.2e-4),
    (0.2, 32): (6.0e-3, 2.2e-4),
    (0.3, 8): (1.9e-2, 1.8e-3),
    (0.3, 16): (2.0e-2, 1.8e-3),
    (0.3, 32): (2.0e-2, 1.8e-3),
    (0.3, 64): (2.0e-2, 1.8e-3),
    (0.35, 8): (3.1e-2, 3.8e-3),
    (0.35, 16): (3.1e-2, 3.9e-3),
    (0.35, 32): (3.1e-2, 4.0e-3),
    (0.35, 64): (3.1e-2, 4.0e-3),
}
_LENGTH = 100.0  # m: surface tension is 3e-8 of gravity


def velocity_error(steepness: float, modes: int, order: int) -> float:
    """Greatest |W − exact|/√(g/k) at 2N places, of the waves that N modes hold."""
    k = 2.0 * np.pi / _LENGTH
    speed = float(np.sqrt(GRAVITY / k))
    wave = _wave(steepness)
    theta = 2.0 * np.pi * np.arange(max(512, 4 * modes)) / max(512, 4 * modes)
    surface = wave.elevation(theta)
    flow = wave.flow(theta, surface)
    band = Band(_LENGTH, _LENGTH, modes - 1, 0, np.inf)
    elevation, potential, exact = (
        band.to_waves(each[None]) for each in (surface / k, flow["potential"] * speed / k, flow["w"] * speed)
    )
    found = Rates(band, order).vertical_velocity(elevation, potential)
    return float(np.abs(band.to_points(found - exact, (1, 2 * modes))).max()) / speed


@cache
def _wave(steepness: float) -> SteadyWave:
    return steady_wave(steepness, harmonics=20 if steepness <= 0.2 else 30)
