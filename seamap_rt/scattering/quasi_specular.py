"""What a facet mirrors: quasi-specular returns of its unresolved tilts, HH and VV alike.

Barrick, IEEE Trans. Antennas Propag. 16, 449–454 (1968); Valenzuela, Boundary-Layer Meteorol. 13, 61–85 (1978).
"""

from __future__ import annotations

from functools import lru_cache
from typing import NamedTuple

import numpy as np
from scipy.special import ndtr

from seamap_rt.scattering.bragg import radar_wavenumber
from seamap_rt.scattering.facet_view import Array
from seamap_rt.scattering.permittivity import fresnel
from seamap_rt.scattering.short_waves import ShortWaves

LEAST_COSINE = 0.05  # beyond, exp(−½ tan² θi/variance) is nothing


class Mirror(NamedTuple):
    """σ = reflection/(2 √(along · across)) · sec⁴θi exp(−½ tan²θi (cos²φ/along + sin²φ/across))."""

    reflection: float  # |R(0)|² of the roughened surface
    along: float  # variances of the slopes along and across the wind
    across: float

    @property
    def peak(self) -> float:
        """σ0 seen squarely."""
        return float(np.float32(0.5 * self.reflection / np.sqrt(self.along * self.across)))

    @property
    def steepness(self) -> float:
        """One over the tilts' slope, rms of the directions."""
        return float(np.float32(1.0 / np.sqrt(0.5 * (self.along + self.across))))

    def nrcs(self, cos_local: Array, wind_cosine: Array) -> Array:
        """σ0 per unit true area of the facet, for cos θi and cos 2φ in float32; 0 from behind."""
        secant2 = 1.0 / np.square(np.maximum(cos_local, LEAST_COSINE))
        mean = float(np.float32(0.25 / self.along + 0.25 / self.across))
        split = float(np.float32(0.25 / self.along - 0.25 / self.across))
        return self.peak * secant2 * secant2 * np.exp((1.0 - secant2) * (mean + split * wind_cosine))

    def facing(self, cos_local: Array) -> Array:
        """Share of the tilts that face the ray, 1 seen squarely and ½ at a facet's own grazing."""
        return ndtr(cos_local * self.steepness / np.sqrt(np.maximum(1.0 - cos_local * cos_local, 1e-6)))


@lru_cache(maxsize=32)
def mirror(frequency_hz: float, permittivity: complex, waves: ShortWaves) -> Mirror:
    """The mirror that the waves between the mesh's limit and the roughness make of a facet.

    That is π |R|² sec⁴θi p, p the Gaussian density of the tilt that turns the facet towards the ray. Roughness of
    variance h² takes exp(−4 k² h²) of the coherent power away (Kudryavtsev et al., J. Geophys. Res. 110, C07016, 2005);
    Bragg scattering has it. To the tilts comes the lobe that a flat square of the mesh's shortest half wave L = π/k_m
    diffracts, a peak of 4π L²/λ² or slope variance λ²/(8π L²) [1.8e-4 of slope² at 3 cm and k_m = 7 rad/m]: it counts
    where the mesh leaves no tilts, and keeps σ finite there.
    """
    k = radar_wavenumber(frequency_hz)
    divide = waves.divide(k)
    lobe = waves.above**2 / (2.0 * np.pi * k**2)
    along, across = (each + lobe for each in waves.tilt_variances(divide))
    smooth = abs(complex(fresnel(0.0, permittivity)[0])) ** 2
    return Mirror(smooth * float(np.exp(-4.0 * k**2 * waves.roughness_variance(divide))), along, across)
