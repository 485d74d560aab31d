"""The waves that the mesh does not carry: where the resolved sea ends, the wind's short waves begin.

The sea resolves wavenumbers below a limit (`Sea.resolved.wavenumber_limit`); the scattering's spectrum, that of
Elfouhaily et al. (1997) for the scene's wind, counts from that limit on. So no wave is missing and none counts twice,
as a slope of the mesh and once more as roughness of a facet. Where the sea itself is Elfouhaily's, for the same wind
and fully developed, the two make up the whole spectrum; any other sea may meet it with a step, which `level_step_db`
tells.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from functools import cached_property

import numpy as np
import scipy
from numpy.typing import ArrayLike, NDArray

from ..sea.spectra import (
    DEVELOPED_INVERSE_WAVE_AGE,
    elfouhaily97,
    elfouhaily97_peak_wavenumber,
    elfouhaily97_spreading,
)
from ..settings import ScatteringSettings

_SHORTEST = 1e5  # rad/m, beyond every ripple
_TAPER = 0.35  # width of the divide between tilts and roughness, in ln k: it is crossed within half an octave each way
_CLEAR = 4.0  # the divide stays so far above the limit that 4e-5 of the taper is left there


@dataclass(frozen=True)
class ShortWaves:
    """The wind's waves from the wavenumber `above` [rad/m] on; 0 is the whole sea."""

    wind_speed: float  # m/s at 10 m
    above: float = 0.0
    inverse_wave_age: float = DEVELOPED_INVERSE_WAVE_AGE

    @classmethod
    def of(cls, settings: ScatteringSettings, above: float) -> ShortWaves:
        """The short waves of a scene's wind."""
        return cls(settings.wind_speed_m_s, above, settings.inverse_wave_age)

    def spectrum(self, k: ArrayLike) -> NDArray[np.float64]:
        """S(k) [m³], 0 below the limit."""
        k = np.asarray(k, dtype=np.float64)
        return np.where(k >= self.above, elfouhaily97(k, self.wind_speed, self.inverse_wave_age), 0.0)

    def contrast(self, k: ArrayLike) -> NDArray[np.float64]:
        """Δ(k) of the symmetric plane spectrum S/k (1 + Δ cos 2φ)/2π."""
        return elfouhaily97_spreading(k, self.wind_speed, self.inverse_wave_age)

    @property
    def longest(self) -> float:
        """Smallest wavenumber that counts [rad/m]: the limit, or the peak where the whole sea counts."""
        return max(self.above, elfouhaily97_peak_wavenumber(self.wind_speed, self.inverse_wave_age))

    def divide(self, radar_wavenumber: float) -> float:
        """Wavenumber k_d [rad/m] between the waves that tilt and the roughness that scatters: a quarter of the radar's.

        So Thompson (J. Geophys. Res. 93, 12371–12380, 1988) and Kudryavtsev et al. (2005). A mesh that resolves almost
        as much pushes it up.
        """
        return max(0.25 * radar_wavenumber, _CLEAR * self.above)

    def roughness(self, k: ArrayLike, divide: float) -> NDArray[np.float64]:
        """The part S T of S(k) [m³] that is roughness; the rest, S (1 − T), tilts it. T(k/k_d) rises from 0 to 1."""
        return self.spectrum(k) * _taper(np.asarray(k, dtype=np.float64), divide)

    def roughness_variance(self, divide: float) -> float:
        """Of the elevation, m²."""
        return self._integral(lambda k: self.roughness(k, divide))

    def tilt_variances(self, divide: float) -> tuple[float, float]:
        """Slope variances, along and across the wind, of the waves that tilt the roughness."""
        return self._split(lambda k: self.spectrum(k) - self.roughness(k, divide))

    def tilt_height(self, divide: float) -> float:
        """Rms elevation [m] of the waves that tilt the roughness."""
        return float(np.sqrt(max(self.variance - self.roughness_variance(divide), 0.0)))

    @cached_property
    def variance(self) -> float:
        """Of the elevation, m²."""
        return self._integral(lambda k: self.spectrum(k))

    @cached_property
    def mean_square_slope(self) -> float:
        """Mean square slope of both directions together."""
        return self._integral(lambda k: k**2 * self.spectrum(k))

    @cached_property
    def slope_variances(self) -> tuple[float, float]:
        """Along and across the wind."""
        return self._split(self.spectrum)

    def level_step_db(self, resolved: Callable[[NDArray[np.float64]], NDArray[np.float64]]) -> float:
        """How much higher the short waves' S(k) begins than the resolved sea's ends [dB]; nan where there is none."""
        k = np.array([self.above])
        ends, begins = float(resolved(k)[0]), float(self.spectrum(k)[0])
        return 10.0 * float(np.log10(begins / ends)) if ends > 0.0 and begins > 0.0 else float("nan")

    def _split(self, spectrum: Callable[[NDArray[np.float64]], NDArray[np.float64]]) -> tuple[float, float]:
        """Slope variances of a spectrum along and across the wind."""
        both = self._integral(lambda k: k**2 * spectrum(k))
        split = self._integral(lambda k: k**2 * spectrum(k) * 0.5 * self.contrast(k))
        return 0.5 * (both + split), 0.5 * (both - split)

    def _integral(self, function: Callable[[NDArray[np.float64]], NDArray[np.float64]]) -> float:
        """∫ function dk from the limit on."""
        log_k = np.linspace(np.log(max(self.above, 1e-6)), np.log(_SHORTEST), 20_001)
        k = np.exp(log_k)
        return float(np.trapezoid(k * function(k), log_k))


def _taper(k: NDArray[np.float64], divide: float) -> NDArray[np.float64]:
    """The normal distribution of ln k about the divide: it falls faster than any power, so that k⁻⁴ T stays finite."""
    with np.errstate(divide="ignore"):
        return scipy.special.ndtr(np.log(k / divide) / _TAPER)
