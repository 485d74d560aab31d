"""The Hybrid mean sea clutter: a reference level in decibels and a correction for each circumstance."""

from __future__ import annotations

import numpy as np
from numpy.typing import ArrayLike, NDArray

from seamap_rt.conventions import SPEED_OF_LIGHT
from seamap_rt.scattering.model_range import ModelRange, wind_factor

RANGE = ModelRange("the Hybrid 1990 sea clutter model", (0.1, 30.0), (0.5e9, 35e9), (1.0, 5.0))
_CALM = 1e-9  # the least sea state: log 0 has no value, its limit has
_REFERENCE_DEG = 0.1


def nrcs_reilly90(
    grazing_deg: ArrayLike,
    sea_state: ArrayLike,
    frequency_hz: ArrayLike,
    polarization: str,
    wind_angle: ArrayLike | None = None,
    extrapolate: bool = False,
    clipped: bool = False,
) -> NDArray[np.float64]:
    """Mean σ0 [linear] of the sea, "HH" or "VV"; the arguments broadcast.

    Reilly & Dockery, Influence of evaporation ducts on radar sea return, IEE Proc. F 137(2), 80–88 (1990), whose
    appendix builds it from Barton's and Nathanson's data and parts of GIT's: grazing 0.1–30°, 0.5–35 GHz, sea
    states 1–5. wind_angle [rad]: the look's azimuth less the one that the wind comes from; None: the mean power
    over all directions. ValueError outside the range, unless `extrapolate` lets the formula run on; `clipped`
    brings the grazing angle, and only it, into 0.1–30° first.

    HH jumps where its bands meet, at 3 GHz by −2 to 7 dB, at 10 GHz by −2 to 0 dB. It lies 3–5 dB above
    Nathanson's table at 9.3 GHz, 17 dB at worst (sea state 1, 10°): beyond the transition it falls as the wind rises,
    up to sea state 1.7. Listings differ in the transition's 0.066 (0.0632: 0.1 dB less; 0.66, a slip: 4 dB more) and
    in the logarithm of the wind's term (natural instead of decimal: 0.7 dB less).
    """
    psi, state, frequency = RANGE.checked(grazing_deg, sea_state, frequency_hz, polarization, extrapolate, clipped)
    state, wavelength = np.maximum(state, _CALM), SPEED_OF_LIGHT / frequency
    log_ghz = np.log10(frequency / 1e9)
    level_db = np.where(frequency <= 12.5e9, 24.4 * log_ghz - 65.2, 3.25 * log_ghz - 42.0)
    level_db = level_db + _grazing_db(psi, state, wavelength) + 5.0 * (state - 5.0)
    if polarization == "HH":
        level_db = level_db + _hh_over_vv_db(np.radians(psi), wavelength, 0.08 * state**2, frequency)
    fall = (2.0 + 1.7 * np.log10(0.1 / wavelength)) * np.log(10.0) / 10.0  # from upwind to crosswind
    return np.asarray(10.0 ** (level_db / 10.0) * np.exp(-fall) * wind_factor(fall, wind_angle))


def _grazing_db(
    psi: NDArray[np.float64], state: NDArray[np.float64], wavelength: NDArray[np.float64]
) -> NDArray[np.float64]:
    """Rises as ψ² up to the transition, as ψ beyond it; psi in degrees."""
    height = 0.031 * state**2  # m, root mean square
    transition = np.degrees(np.arcsin(np.minimum(0.066 * wavelength / height, 1.0)))
    transition = np.maximum(transition, _REFERENCE_DEG)
    square = np.clip(psi, _REFERENCE_DEG, transition) / _REFERENCE_DEG
    return 20.0 * np.log10(square) + 10.0 * np.log10(np.maximum(psi, transition) / transition)


def _hh_over_vv_db(
    psi: NDArray[np.float64],
    wavelength: NDArray[np.float64],
    height: NDArray[np.float64],
    frequency: NDArray[np.float64],
) -> NDArray[np.float64]:
    """By band; psi in radians, lengths in metres, the height the average one."""
    log_height, log_psi, log_wavelength = np.log(height + 0.015), np.log(psi + 1e-4), np.log(wavelength)
    below_3 = 1.7 * log_height - 3.8 * log_wavelength - 2.5 * log_psi - 22.2
    to_10 = 1.1 * log_height - 1.1 * log_wavelength - 1.3 * log_psi - 9.7
    above_10 = 1.4 * np.log(height) - 3.4 * log_wavelength - 1.3 * np.log(psi) - 18.6
    return np.where(frequency < 3e9, below_3, np.where(frequency <= 10e9, to_10, above_10))
