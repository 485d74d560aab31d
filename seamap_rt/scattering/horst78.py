"""Georgia Tech's (GIT) mean sea clutter: interference near grazing, wind speed and wind direction."""

from __future__ import annotations

import numpy as np
from numpy.typing import ArrayLike, NDArray

from seamap_rt.conventions import SPEED_OF_LIGHT
from seamap_rt.scattering.model_range import ModelRange, wind_factor, wind_from_sea_state

RANGE = ModelRange("the GIT 1978 sea clutter model", (0.1, 10.0), (1e9, 100e9), (0.4, 7.0))
_CALM = 1e-9  # the least sea state: log 0 has no value, its limit has


def nrcs_horst78(
    grazing_deg: ArrayLike,
    sea_state: ArrayLike,
    frequency_hz: ArrayLike,
    polarization: str,
    wind_angle: ArrayLike | None = None,
    extrapolate: bool = False,
    clipped: bool = False,
) -> NDArray[np.float64]:
    """Mean σ0 [linear] of the sea, "HH" or "VV"; the arguments broadcast.

    Horst, Dyer & Tuley, Radar Sea Clutter Model, Int. IEEE AP/S–URSI Symposium, 6–10 (1978): grazing 0.1–10°,
    1–100 GHz, winds of 1.5–15 m/s, given here by their sea states 0.4–7. The paper takes the wind and the average
    wave height: `wind_from_sea_state` gives V, and its fully developed sea is h = 4.52e-3 V^2.5. wind_angle [rad]:
    the look's azimuth less the one that the wind comes from; None: the mean power over all directions. ValueError
    outside the range, unless `extrapolate` lets the formula run on; `clipped` brings the grazing angle, and only
    it, into 0.1–10° first.

    The paper's bands do not meet: at 10 GHz σ0 jumps by −6 to 12 dB, most on a calm sea, and VV at 3 GHz by −7 to
    2 dB. Below a critical angle σ0 falls as ψ^4.4 (sea state 1, 9.3 GHz: below 4°), tens of dB under Nathanson's
    table at 0.1°.
    """
    psi, state, frequency = RANGE.checked(grazing_deg, sea_state, frequency_hz, polarization, extrapolate, clipped)
    psi, wavelength = np.radians(psi), SPEED_OF_LIGHT / frequency
    wind = wind_from_sea_state(np.maximum(state, _CALM))
    height = 4.52e-3 * wind**2.5  # m, average

    roughness = ((14.4 * wavelength + 5.5) * psi * height / wavelength) ** 4
    interference = roughness / (1.0 + roughness)
    wide = wavelength + 0.015
    low_band = frequency <= 10e9
    growth = (1.94 * wind / (1.0 + wind / 15.4)) ** np.where(low_band, 1.1 * wide**-0.4, 1.93 * wavelength**-0.04)
    upwind = (1.0 - 2.8 * psi) * np.where(low_band, 0.2 * wide**-0.4, 0.25 * wavelength**-0.33)
    level = np.where(low_band, 3.9e-6 * wavelength * psi**0.4, 5.78e-6 * psi**0.547) * interference * growth
    if polarization == "VV":
        level = level * 10.0 ** (_vv_over_hh_db(psi, wavelength, height, frequency) / 10.0)
    return np.asarray(level * wind_factor(upwind, wind_angle))


def _vv_over_hh_db(
    psi: NDArray[np.float64],
    wavelength: NDArray[np.float64],
    height: NDArray[np.float64],
    frequency: NDArray[np.float64],
) -> NDArray[np.float64]:
    """By band; psi in radians, lengths in metres."""
    log_height, log_psi, log_wavelength = np.log(height + 0.015), np.log(psi + 1e-4), np.log(wavelength)
    below_3 = -1.73 * log_height + 3.76 * log_wavelength + 2.46 * log_psi + 22.2
    to_10 = -1.05 * log_height + 1.09 * log_wavelength + 1.27 * log_psi + 9.7
    above_10 = -1.38 * np.log(height) + 3.43 * log_wavelength + 1.31 * np.log(psi) + 18.55
    return np.where(frequency < 3e9, below_3, np.where(frequency <= 10e9, to_10, above_10))
