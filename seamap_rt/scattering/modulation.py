"""How the mesh's waves gather the short ones: hydrodynamic modulation of Bragg scattering and of breaking.

Short waves conserve their action on a water that long waves squeeze and stretch, and relax to what the wind sustains:
d ln N/dt = −4.5 ∂u/∂r − μ ln(N/N0) along the look (Alpers & Hasselmann, Boundary-Layer Meteorol. 13, 215–230, 1978).
With D the water's velocity passed through 1/(μ + d/dt) and the strain −∂D/∂r, ln(N/N0) = 4.5 · strain.
"""

from __future__ import annotations

from collections.abc import Callable
from functools import lru_cache

import numpy as np
import scipy
from numpy.typing import ArrayLike, NDArray

from seamap_rt.physics.dispersion import angular_frequency
from seamap_rt.scattering.bragg import radar_wavenumber
from seamap_rt.scattering.breaking import FRONT_POWER
from seamap_rt.sea.spectra import friction_velocity
from seamap_rt.settings import ScatteringSettings

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
