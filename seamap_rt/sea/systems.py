"""A wave system of the scene as functions: its wavenumber spectrum, its spreading, where it travels to."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from functools import partial

import numpy as np
from numpy.typing import NDArray

from ..conventions import GRAVITY, SURFACE_TENSION, WATER_DENSITY, unit_from_azimuth
from ..settings import JonswapWaves, PiersonMoskowitzWaves, SinusoidWaves, SpectralWaves
from . import spectra
from .lattice import Radial, Spreading
from .spreading import cos2s_of_cosine

GRAVITY_CAPILLARY_WAVENUMBER = float(np.sqrt(GRAVITY * WATER_DENSITY / SURFACE_TENSION))  # rad/m, 368.6
_LONGEST, _SHORTEST = 1e-7, 1e5  # rad/m, beyond every sea wave


@dataclass(frozen=True)
class SpectralSystem:
    """One random wave system, ready to be realised."""

    radial: Radial  # S(k) [m³]
    spreading: Spreading | None  # None: long-crested
    toward: tuple[float, float]  # unit vector of travel, east north

    def moment(self, power: int, limit: float = _SHORTEST) -> float:
        """∫ k^power S(k) dk up to `limit` rad/m: variance [m²] for 0, mean square slope for 2. To about 1e-7."""
        log_k = np.linspace(np.log(_LONGEST), np.log(limit), 30_001)
        k = np.exp(log_k)
        return float(np.trapezoid(k ** (power + 1) * self.radial(k), log_k))


def spectral_system(waves: SpectralWaves, depth: float) -> SpectralSystem:
    """The functions of one system of the scene. Raises TypeError for a spectrum that is not known here."""
    spread = None
    if waves.spreading == "cos2s":
        spread = partial(cos2s_of_cosine, exponent=waves.spreading_exponent)
    radial = partial(spectra.wavenumber_spectrum, _frequency_spectrum(waves), depth=depth)
    return SpectralSystem(radial, spread, travel_direction(waves))


def travel_direction(waves: SpectralWaves | SinusoidWaves) -> tuple[float, float]:
    """Unit vector, east north, of where the waves go: opposite to where they come from."""
    east, north = unit_from_azimuth(waves.wave_from_deg + 180.0)
    return float(east), float(north)


def _frequency_spectrum(waves: SpectralWaves) -> Callable[..., NDArray[np.float64]]:
    """S(ω) of a system, by its height and period or by the wind."""
    hs, tp, wind = waves.significant_wave_height_m, waves.peak_period_s, waves.wind_speed_m_s
    match waves:
        case PiersonMoskowitzWaves() if wind is not None:
            return partial(spectra.pierson_moskowitz, wind_speed=wind)
        case PiersonMoskowitzWaves() if hs is not None and tp is not None:
            return partial(spectra.pierson_moskowitz_scaled, hs=hs, tp=tp)
        case JonswapWaves() if wind is not None and waves.fetch_m is not None:
            return partial(spectra.jonswap_fetch, wind_speed=wind, fetch=waves.fetch_m, gamma=waves.peak_enhancement)
        case JonswapWaves() if hs is not None and tp is not None:
            return partial(spectra.jonswap, hs=hs, tp=tp, gamma=waves.peak_enhancement)
    raise TypeError(f"spectrum of {type(waves).__name__}: not known to the sea")


def azimuth_toward(direction: tuple[float, float]) -> float:
    """Azimuth (deg) of a direction of travel."""
    return float(np.degrees(np.arctan2(direction[0], direction[1])) % 360.0)
