"""The resolved waves of a sea by wavenumber, and what follows from their spectrum without drawing a sea.

Means over looks and headings count all directions alike.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from ..physics.dispersion import angular_frequency, orbital_ratio
from ..settings import RandomWaves, SeaSettings, SinusoidWaves
from .systems import spectral_system, wave_facts

_LONGEST = 1e-5  # rad/m, beyond every sea wave
_STEPS = 4001  # in ln k: moments are good to 1e-4


class ResolvedWaves(NamedTuple):
    """Waves of the mesh by wavenumber; all arrays (wave,)."""

    wavenumber: NDArray[np.float64]  # rad/m
    frequency: NDArray[np.float64]  # rad/s, for an observer who drifts with the current
    encounter: NDArray[np.float64]  # rad/s, at a fixed point: a current carries the waves past
    variance: NDArray[np.float64]  # m²
    depth: float  # m

    @classmethod
    def of(cls, sea: SeaSettings, limit: float) -> ResolvedWaves:
        """The waves of a sea below a wavenumber `limit` [rad/m], and its regular waves of any length."""
        log_k = np.linspace(np.log(_LONGEST), np.log(limit), _STEPS)
        weight = np.full(_STEPS, log_k[1] - log_k[0])
        weight[[0, -1]] *= 0.5
        systems = [np.empty((3, 0))]  # of wavenumber, variance and current along the waves
        for waves in sea.waves:
            facts = wave_facts(waves, sea.depth_m)
            if facts is None:
                continue
            if isinstance(waves, SinusoidWaves):
                k, power = np.array([2.0 * np.pi / waves.wavelength_m]), np.array([0.125 * waves.height_m**2])
            elif isinstance(waves, RandomWaves):
                k = np.exp(log_k)
                power = k * spectral_system(waves, sea.depth_m).radial(k) * weight
            else:
                continue
            current = sea.current_m_s * np.cos(np.radians(facts.from_deg + 180.0 - sea.current_toward_deg))
            systems.append(np.stack((k, power, np.full(k.size, current))))
        k, variance, current = np.concatenate(systems, axis=1)
        frequency = angular_frequency(k, sea.depth_m)
        return cls(k, frequency, frequency + k * current, variance, sea.depth_m)

    @property
    def elevation_std(self) -> float:
        """Rms elevation, m."""
        return float(np.sqrt(self.variance.sum()))

    def still_sea_error(self, duration_s: float) -> float:
        """Rms height [m] between the sea as a beam meets it within `duration_s` and the sea as it is half-way.

        √2 σ √(1 − ρ(τ)) at the time τ from half-way, with the elevation's correlation ρ(τ) = Σ S cos ωτ/σ² (Longuet-
        Higgins 1957); its mean square over the time is 2 Σ S (1 − sinc ωT/2). 0 for no time, √2 σ for a long one.
        """
        kept = np.sinc(self.encounter * duration_s / (2.0 * np.pi))
        return float(np.sqrt(2.0 * np.sum(self.variance * (1.0 - kept))))

    def orbital_speed(self) -> float:
        """Rms speed [m/s] of the water along the look at grazing, ½ Σ ω² S coth² kh (Airy 1845), over all looks."""
        ratio = orbital_ratio(self.wavenumber, self.depth)
        return float(np.sqrt(0.5 * np.sum(self.variance * (self.frequency * ratio) ** 2)))

    def strain_std(self, relaxation_rate: float) -> float:
        """Rms strain of the short waves by these at a relaxation rate μ [1/s]: Σ S k²ω²/(μ² + ω²) ⟨cos⁴⟩.

        Alpers & Hasselmann (1978), see `scattering.modulation`; over all looks cos⁴ is 3/8 in the mean.
        """
        omega2 = self.frequency**2
        kept = self.wavenumber**2 * omega2 / (relaxation_rate**2 + omega2)
        return float(np.sqrt(0.375 * np.sum(self.variance * kept)))

    def slopes_lost(self, spacing_m: float) -> float:
        """Rms slope along the look of the waves shorter than twice `spacing_m`; half their mean square slope."""
        lost = self.wavenumber > np.pi / spacing_m
        return float(np.sqrt(0.5 * np.sum(self.variance[lost] * self.wavenumber[lost] ** 2)))
