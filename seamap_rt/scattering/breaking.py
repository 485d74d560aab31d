"""Breaking waves: how much of the sea they cover, what they return, and how fast they run.

Kudryavtsev, Hauser, Caudal & Chapron, J. Geophys. Res. 108(C3), 8054 (2003), with the limits and the growth rate of
Kudryavtsev, Akimov, Johannessen & Chapron, J. Geophys. Res. 110, C07016 (2005). None of their constants is tuned here.
The fraction counts waves too short to make foam, so that it is not the whitecaps'.

The mesh's waves gather the short ones, and with them the breakers. Short waves conserve their action on a water that
long waves squeeze and stretch, and relax to what the wind sustains: d ln N/dt = −4.5 ∂u/∂r − μ ln(N/N0) along the look
(Alpers & Hasselmann, Boundary-Layer Meteorol. 13, 215–230, 1978). With D the water's velocity passed through
1/(μ + d/dt) and the strain −∂D/∂r, ln(N/N0) = 4.5 · strain.
"""

from __future__ import annotations

from collections.abc import Callable
from functools import lru_cache
from typing import NamedTuple

import numpy as np
import scipy
from numpy.typing import ArrayLike, NDArray

from seamap_rt.conventions import GRAVITY, WATER_DENSITY, radar_wavenumber
from seamap_rt.physics.dispersion import angular_frequency
from seamap_rt.sea.spectra import elfouhaily97_peak_wavenumber, friction_velocity
from seamap_rt.settings import ScatteringSettings

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
    limit = min(_SHORTEST, 0.1 * radar_wavenumber(frequency_hz))
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


ACTION_POWER = 4.5  # N ∝ k^−4.5 of gravity waves with a spectrum k⁻⁴; ripples of 1 to 2 cm would have about 4
MOST_STRAIN = 0.5  # a wave that squeezes the water more than this breaks; the first-order theory ends before

_GRID = np.linspace(-8.0, 8.0, 801)  # standard deviations of a Gaussian strain
_GAUSS = np.exp(-0.5 * _GRID**2) / np.exp(-0.5 * _GRID**2).sum()


def memory_rate(scattering: ScatteringSettings, frequency_hz: float) -> float | None:
    """Rate [1/s] at which the short waves relax from the long ones' strain; None where it does not matter."""
    if scattering.nrcs != "two_scale" or not scattering.hydrodynamic_modulation:
        return None
    return relaxation_rate(frequency_hz, scattering.wind_speed_m_s)


def relaxation_rate(frequency_hz: float, wind_speed: float) -> float:
    """Rate μ [1/s] at which Bragg waves of grazing incidence return to what the wind at 10 m [m/s] sustains.

    Their growth rate 0.04 (u*/c)² ω (Plant, J. Geophys. Res. 87, 1961–1967, 1982), at k = 2 k_radar: what is missing
    grows back, and what is too much is lost, at that rate. ValueError for a wind that is not positive.
    """
    if not (wind_speed > 0.0 and np.isfinite(wind_speed)):
        raise ValueError(f"wind_speed = {wind_speed}: must be positive and finite; give m/s at 10 m height")
    k = 2.0 * radar_wavenumber(frequency_hz)
    omega = float(angular_frequency(k))
    return 0.04 * (friction_velocity(wind_speed) * k / omega) ** 2 * omega


def approaching_share(wind_angle: ArrayLike) -> NDArray[np.float64]:
    """Share of the Bragg power that waves running towards the radar carry: 1 looking into the wind, ½ across, 0 along.

    wind_angle: look azimuth − azimuth where the wind comes from [rad]. Short waves' energy is ∝ cos⁴(φ/2) about
    the wind (Longuet-Higgins, Cartwright & Smith 1963, s = 2). Bragg scattering sees both senses, ∝ 1 + ⅓ cos 2φ;
    for X-band Bragg waves Elfouhaily's own spreading Δ is 0.26, 0.33 and 0.41 at 5, 8.5 and 12 m/s.
    """
    cosine = np.cos(np.asarray(wind_angle, dtype=np.float64))
    towards, away = (1.0 + cosine) ** 2, (1.0 - cosine) ** 2  # 4 cos⁴(φ/2), 4 sin⁴(φ/2)
    return towards / (towards + away)


def action_modulation(strain: NDArray[np.floating]) -> NDArray[np.floating]:
    """N/N0 of the short waves, exp(4.5 strain), with the strain bent smoothly below ±½: 0.105 to 9.5."""
    return np.exp(ACTION_POWER * MOST_STRAIN * np.tanh(strain * (1.0 / MOST_STRAIN)))


def modulation_db(strain_std: float) -> float:
    """Rms modulation [dB] of Bragg scattering by a small strain of that rms: 4.5 of it, in ln."""
    return float(10.0 / np.log(10.0) * ACTION_POWER * strain_std)


@lru_cache(maxsize=64)
def mean_action_modulation(strain_variance: float) -> float:
    """Mean of `action_modulation` over a Gaussian strain of that variance; 1 without one."""
    return _mean(action_modulation, strain_variance)


def breaking_share(crowded: NDArray[np.floating], level: float) -> NDArray[np.floating]:
    """Share of a facet that breaks, 0 to 1: level · crowded⁶/(1 + level · crowded⁶), and `level` from `breaking_level`.

    Where few waves break it is ∝ the spectrum to the power n + 1 = 6 (Kudryavtsev et al. 2003), so that crests and
    forward faces carry the breakers.
    """
    cube = crowded * crowded * crowded
    often = level * (cube * cube)
    return often / (1.0 + often)


@lru_cache(maxsize=64)
def breaking_level(fraction: float, strain_variance: float) -> float:
    """The level for which the mean of `breaking_share` over a Gaussian strain is the fraction [0 to 1] of the sea."""
    if not 0.0 <= fraction < 1.0:
        raise ValueError(
            f"fraction = {fraction}: must be at least 0 and below 1; give the share of the sea that breaks"
        )
    if fraction == 0.0:
        return 0.0

    def miss(log_level: float) -> float:
        return (
            _mean(lambda strain: breaking_share(action_modulation(strain), float(np.exp(log_level))), strain_variance)
            - fraction
        )

    start = np.log(fraction / (1.0 - fraction))
    widest = FRONT_POWER * ACTION_POWER * MOST_STRAIN  # ln of the strongest modulation to its power
    return float(np.exp(scipy.optimize.root_scalar(miss, bracket=(start - widest, start + widest)).root))


def _mean(function: Callable[[NDArray[np.float64]], NDArray[np.floating]], variance: float) -> float:
    if not (variance >= 0.0 and np.isfinite(variance)):
        raise ValueError(f"strain_variance = {variance}: must be finite and not negative; give 0 where none is known")
    return float(np.sum(_GAUSS * function(np.sqrt(variance) * _GRID)))
