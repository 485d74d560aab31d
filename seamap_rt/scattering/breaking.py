"""Breaking waves: how much of the sea they cover, what they return, and how fast they run.

Kudryavtsev, Hauser, Caudal & Chapron, J. Geophys. Res. 108(C3), 8054 (2003), with the limits and the growth rate of
Kudryavtsev, Akimov, Johannessen & Chapron, J. Geophys. Res. 110, C07016 (2005). None of their constants is tuned here.
The fraction counts waves too short to make foam, so that it is not the whitecaps'.
"""

from __future__ import annotations

from functools import lru_cache
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from seamap_rt.conventions import GRAVITY, SPEED_OF_LIGHT, WATER_DENSITY
from seamap_rt.physics.dispersion import angular_frequency
from seamap_rt.sea.spectra import elfouhaily97_peak_wavenumber, friction_velocity

COVERAGE = 10.5  # c_q, a zone's length along its way times the breaking wave's k
FRONT_POWER = 6.0  # n + 1: the fronts' length is proportional to that power of the breaking waves' spectrum, n = 5
ROUGHNESS = 0.19  # s², the mean square slope of a breaking zone
WALL = 0.005  # ε, thickness of a breaking zone over its length: what its side returns at any incidence

_LEAN = 0.05  # rad, mean tilt of the breaking zones towards where they run
_MOST = 0.9  # of the sea may break; only hurricanes come there
_SHORTEST = 2.0 * np.pi / 0.3  # rad/m; shorter waves ripple instead of breaking
_AIR_DENSITY = 1.225  # kg/m³ at 15 °C
_AIR_VISCOSITY = 1.47e-5  # m²/s
_WATER_VISCOSITY = 1.15e-6  # m²/s
_KARMAN = 0.4


class Breakers(NamedTuple):
    """The breaking waves of one wind, as one radar sees them."""

    fraction: float  # q, of the sea's area
    direction: float  # mean cosine between the fronts' way and the wind's
    speed: float  # m/s, mean of their phase velocity down-wind, by area
    spread: float  # m/s, its standard deviation


@lru_cache(maxsize=32)
def breakers(wind_speed: float, inverse_wave_age: float, frequency_hz: float) -> Breakers:
    """Breaking waves from the spectrum's peak up to a tenth of the radar's wavenumber or 0.3 m, whichever is longer.

    Λ = (B/α)^(n+1)/2k is the fronts' length per area, wavenumber and angle, and q = c_q ∫∫ Λ dk dφ. In equilibrium
    with the wind's growth rate β (per radian, less 4νk²/ω of viscosity) the waves have B = α β^(1/n), so that
    q = ½ c_q ∫∫ β^(1+1/n) dφ dln k whatever spectrum the scattering takes. By area most breakers are the shortest, with
    k near the upper limit. Raises ValueError as `elfouhaily97`.
    """
    k, angle, front = breaking_fronts(wind_speed, inverse_wave_age, frequency_hz)
    downwind = (angular_frequency(k) / k)[:, None] * np.cos(angle)

    def total(values: NDArray[np.float64]) -> float:
        return float(np.trapezoid(np.asarray(np.trapezoid(front * values, angle, axis=1)), np.log(k)))

    area = total(np.ones(()))
    if area == 0.0:
        return Breakers(0.0, 0.0, 0.0, 0.0)
    speed, square = total(downwind) / area, total(downwind**2) / area
    spread = float(np.sqrt(square - speed**2))
    return Breakers(min(0.5 * COVERAGE * area, _MOST), total(np.cos(angle)) / area, speed, spread)


def breaking_fronts(
    wind_speed: float, inverse_wave_age: float, frequency_hz: float
) -> tuple[NDArray[np.float64], NDArray[np.float64], NDArray[np.float64]]:
    """Wavenumbers k (n,) rad/m, angles φ from the wind's way (m,) rad, and (B/α)^(n+1) (n, m), twice the fronts' Λ k.

    Times ½ c_q it is the breaking share of the sea's area per ln k and φ. 0 where no wave that is long enough breaks.
    """
    peak = elfouhaily97_peak_wavenumber(wind_speed, inverse_wave_age)
    limit = min(_SHORTEST, 0.2 * np.pi * frequency_hz / SPEED_OF_LIGHT)
    k = np.geomspace(min(peak, limit), limit, 400)
    angle = np.linspace(-0.5 * np.pi, 0.5 * np.pi, 181)  # no wave grows against the wind
    if limit <= peak:
        return k, angle, np.zeros((k.size, angle.size))
    growth = _growth(k[:, None], angle[None, :], friction_velocity(wind_speed))
    return k, angle, growth ** (FRONT_POWER / (FRONT_POWER - 1.0))


def breaker_motion(wind_speed: float, inverse_wave_age: float, frequency_hz: float) -> tuple[float, float]:
    """Mean down-wind phase velocity of the breaking waves and its standard deviation [m/s], weighted by their area.

    The water's own motion, by current and longer waves, comes on top. (0, 0) where nothing breaks.
    """
    result = breakers(float(wind_speed), float(inverse_wave_age), float(frequency_hz))
    return result.speed, result.spread


def nrcs_breaker(
    cos_local: NDArray[np.floating], upwind: NDArray[np.floating], direction: float
) -> NDArray[np.floating]:
    """σ0 [linear] of a breaking zone on a facet, the same for HH and VV: sec⁴θ exp(−tan²θ/s²)/s² + ε/s².

    cos_local: cos θi of the facet. upwind: sin θi cos(w − χ), of `FacetView.upwind`. direction: `Breakers.direction`.
    θ is the incidence on the zone, which leans 0.05 rad forwards, less for fronts that run aside: it returns more seen
    up-wind, from its front, than from behind. The paper expands that to first order, 1 + ∂ln σ/∂θ · 0.05 · direction ·
    cos; here the zone is turned. The second term is its side, a wall of height ε per length. The paper gives it no
    direction, so that at grazing the zone's front and back return the same.
    """
    lean = float(np.tan(_LEAN * direction))  # slope in the mean, of fronts of that direction
    cosine = (cos_local + lean * upwind) * float(1.0 / np.sqrt(1.0 + lean * lean))
    secant2 = 1.0 / np.square(np.maximum(cosine, 0.05))  # beyond, the exponential is nothing
    return secant2 * secant2 * (1.0 / ROUGHNESS) * np.exp((1.0 - secant2) * (1.0 / ROUGHNESS)) + WALL / ROUGHNESS


def _growth(k: NDArray[np.float64], angle: NDArray[np.float64], u_star: float) -> NDArray[np.float64]:
    """β, the energy that the wind adds to a wave within a radian of phase, less viscosity's; at least 0."""
    omega = angular_frequency(k)
    cosine = np.maximum(np.cos(angle), 0.0)
    length = 0.018 * u_star**2 / GRAVITY + 0.1 * _AIR_VISCOSITY / u_star  # the wind profile's roughness length
    speed = omega / k / u_star
    coefficient = np.maximum(np.log(np.pi / (k * length)) / _KARMAN - speed, 0.0)
    growth = 1.5 * _AIR_DENSITY / WATER_DENSITY * coefficient * (cosine / speed) ** 2
    return np.maximum(growth - 4.0 * _WATER_VISCOSITY * k**2 / omega, 0.0)
