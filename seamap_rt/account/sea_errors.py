"""What leaving a part of the sea out costs: closed forms of the spectrum that a scene resolves.

They are means over all looks, to which waves that run any way contribute alike.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray
from scipy.special import spherical_jn

from ..conventions import unit_from_azimuth
from ..physics.dispersion import angular_frequency, orbital_ratio
from ..sea import spectral_system, wave_facts
from ..settings import RandomWaves, SeaSettings, SinusoidWaves

_LONGEST = 1e-5  # rad/m, beyond every sea wave
_STEPS = 4001  # of a spectrum, in ln k: its moments are good to 1e-4
_LOOKS = np.pi * (np.arange(32) + 0.5) / 64.0  # rad between a wave and the look, a quarter of the circle


class ResolvedWaves(NamedTuple):
    """Waves of the mesh by wavenumber; all arrays (wave,)."""

    wavenumber: NDArray[np.float64]  # rad/m
    frequency: NDArray[np.float64]  # rad/s, to one who drifts with the current
    seen: NDArray[np.float64]  # rad/s, at a fixed place: a current carries them past
    variance: NDArray[np.float64]  # m²
    depth: float  # m

    @property
    def elevation_std(self) -> float:
        return float(np.sqrt(self.variance.sum()))


def resolved_waves(sea: SeaSettings, limit: float) -> ResolvedWaves:
    """The waves of a sea below a wavenumber `limit` [rad/m], and its regular waves of any length."""
    log_k = np.linspace(np.log(_LONGEST), np.log(limit), _STEPS)
    weight = np.full(_STEPS, log_k[1] - log_k[0])
    weight[[0, -1]] *= 0.5
    east, north = unit_from_azimuth(sea.current_toward_deg)
    wavenumber, current, variance = [np.empty(0)], [np.empty(0)], [np.empty(0)]
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
        toward = unit_from_azimuth(facts.from_deg + 180.0)
        wavenumber.append(k)
        variance.append(power)
        current.append(np.full(k.size, sea.current_m_s * float(toward[0] * east + toward[1] * north)))
    k = np.concatenate(wavenumber)
    frequency = angular_frequency(k, sea.depth_m)
    return ResolvedWaves(k, frequency, frequency + k * np.concatenate(current), np.concatenate(variance), sea.depth_m)


def still_sea_error(waves: ResolvedWaves, duration_s: float) -> float:
    """Rms height [m] between the sea as a beam meets it within `duration_s` and the sea as it is half-way.

    √2 σ √(1 − ρ(τ)) at the time τ from half-way, with the elevation's correlation ρ(τ) = Σ S cos ωτ/σ² (Longuet-Higgins
    1957); its mean square over the time is 2 Σ S (1 − sinc ωT/2). 0 for no time, √2 σ for a long one.
    """
    kept = np.sinc(waves.seen * duration_s / (2.0 * np.pi))
    return float(np.sqrt(2.0 * np.sum(waves.variance * (1.0 - kept))))


def orbital_speed(waves: ResolvedWaves) -> float:
    """Rms speed [m/s] of the water along the look at grazing: ½ Σ ω² S coth² kh (Airy 1845), the mean over looks."""
    reach = orbital_ratio(waves.wavenumber, waves.depth)
    return float(np.sqrt(0.5 * np.sum(waves.variance * (waves.frequency * reach) ** 2)))


def strain_std(waves: ResolvedWaves, relaxation_rate: float) -> float:
    """Rms strain of the short waves by the resolved ones at a relaxation rate μ [1/s]: Σ S k²ω²/(μ² + ω²) ⟨cos⁴⟩.

    Alpers & Hasselmann (1978), see `scattering.modulation`; over all looks cos⁴ is 3/8 in the mean.
    """
    omega2 = waves.frequency**2
    squeezed = waves.variance * waves.wavenumber**2 * omega2 / (relaxation_rate**2 + omega2)
    return float(np.sqrt(0.375 * squeezed.sum()))


def mesh_error(waves: ResolvedWaves, along_m: float, across_m: float) -> float:
    """Rms height [m] between the waves and a mesh that is straight between points so far apart along and across looks.

    A straight line between points kd apart misses 2/3 + ⅓ cos kd + 1 − 4 (1 − cos kd)/(kd)² of a wave's variance, which
    is (kd)⁴/120 where they are close; the means over looks along and across the look are added.
    """
    missed = np.zeros(waves.wavenumber.size)
    for angle in _LOOKS:
        for step in (along_m * np.cos(angle), across_m * np.sin(angle)):
            missed += straight_line_error(waves.wavenumber * step) / _LOOKS.size
    return float(np.sqrt(np.sum(waves.variance * missed)))


def straight_line_error(phase: NDArray[np.float64]) -> NDArray[np.float64]:
    """Share of a sine's variance that straight lines between points miss which lie `phase` [rad] apart."""
    close = np.abs(phase) < 0.1  # there the terms cancel, and the series is good to 1e-5 of itself
    apart = np.where(close, 1.0, phase)
    whole = 5.0 / 3.0 + np.cos(apart) / 3.0 - 4.0 * (1.0 - np.cos(apart)) / apart**2
    return np.where(close, phase**4 / 120.0 * (1.0 - 11.0 / 252.0 * phase**2), whole)


def slopes_lost(waves: ResolvedWaves, spacing_m: float) -> float:
    """Rms slope along the look of the waves shorter than twice `spacing_m`; half their mean square slope."""
    lost = waves.wavenumber > np.pi / spacing_m
    return float(np.sqrt(0.5 * np.sum(waves.variance[lost] * waves.wavenumber[lost] ** 2)))


def second_order_error(elevation_std: float, steepness: float) -> float:
    """Rms height [m] of the bound waves that sharpen the crests of a narrow-banded sea: kσ² (Longuet-Higgins 1963).

    steepness: 4σ over the length of the peak. The second order is ½ k (η² − η̂²), whose terms vary by 2σ² together.
    """
    return 0.5 * np.pi * steepness * elevation_std


def boat_tilt(waves: ResolvedWaves, length_m: float, beam_m: float) -> float:
    """Rms tilt [rad] along the look of a boat that lies in the plane that fits the waves within its waterline.

    By the responses of `radar.wave_following`, with 3 j₁(p)/p for the line's; the mean over its headings and the looks.
    """
    square = 0.0
    for angle in _LOOKS:
        ahead, aside = waves.wavenumber * np.cos(angle), waves.wavenumber * np.sin(angle)
        p, q = 0.5 * length_m * ahead, 0.5 * beam_m * aside
        level_p, level_q = spherical_jn(0, p), spherical_jn(0, q)
        pitch = 3.0 * spherical_jn(1, p) / p * level_q * ahead
        roll = 3.0 * spherical_jn(1, q) / q * level_p * aside
        square += 0.5 * float(np.sum(waves.variance * (pitch**2 + roll**2))) / _LOOKS.size
    return float(np.sqrt(square))
