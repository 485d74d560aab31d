"""The Technology Service Corporation's (TSC) mean sea clutter: one formula from 2 GHz up, with the wind's direction."""

from __future__ import annotations

import numpy as np
from numpy.typing import ArrayLike, NDArray

from seamap_rt.conventions import SPEED_OF_LIGHT
from seamap_rt.scattering.model_range import ModelRange, wind_factor

RANGE = ModelRange("the TSC 1990 sea clutter model", (0.1, 90.0), (0.5e9, 35e9), (0.0, 5.0))
_FOOT = 0.3048  # m


def nrcs_tsc90(
    grazing_deg: ArrayLike,
    sea_state: ArrayLike,
    frequency_hz: ArrayLike,
    polarization: str,
    wind_angle: ArrayLike | None = None,
    extrapolate: bool = False,
    clipped: bool = False,
) -> NDArray[np.float64]:
    """Mean σ0 [linear] of the sea, "HH" or "VV"; the arguments broadcast.

    Technology Service Corporation, Backscatter from Sea, Radar Workstation, vol. 2, 177–186 (1990), as printed by
    Antipov, Simulation of Sea Clutter Returns, DSTO-TR-0679 (1998): grazing 0.1–90°, 0.5–35 GHz, sea states 0–5.
    wind_angle [rad]: the look's azimuth less the one that the wind comes from; None: the mean power over all
    directions. ValueError outside the range, unless `extrapolate` lets the formula run on; `clipped` brings the
    grazing angle, and only it, into 0.1–90° first.

    Its lengths are feet and its wind is in knots, which printed listings miss: read in metres it lies 7–9 dB above
    Nathanson's table at 9.3 GHz, in feet 1–3 dB. VV jumps at 2 GHz, by −10 to 1 dB.
    """
    psi, state, frequency = RANGE.checked(grazing_deg, sea_state, frequency_hz, polarization, extrapolate, clipped)
    psi, wavelength = np.radians(psi), SPEED_OF_LIGHT / frequency / _FOOT
    height = 0.115 * state**1.95  # feet, standard deviation

    roughness = (14.9 * psi * (height + 0.25) / wavelength) ** 1.5
    level = 1.7e-5 * np.sqrt(psi) * roughness / (1.0 + roughness) / (wavelength + 0.05) ** 1.8
    level = level * ((6.2 * state**0.8 + 4.0) / 15.0) ** _wind_exponent(psi, wavelength)
    if polarization == "VV":
        log_height, log_sine, log_wavelength = (
            np.log(2.507 * height + 0.05),
            np.log(np.sin(psi) + 1e-4),
            np.log(wavelength),
        )
        below_2 = -1.73 * log_height + 3.76 * log_wavelength + 2.46 * log_sine + 19.8
        above_2 = -1.05 * log_height + 1.09 * log_wavelength + 1.27 * log_sine + 9.65
        level = level * 10.0 ** (np.where(frequency < 2e9, below_2, above_2) / 10.0)
    upwind = 0.3 * np.exp(-psi / 0.17) / (wavelength**2 + 0.005) ** 0.2
    return np.asarray(level * wind_factor(upwind, wind_angle))


def _wind_exponent(psi: NDArray[np.float64], wavelength: NDArray[np.float64]) -> NDArray[np.float64]:
    """The power of the wind that clutter follows; psi in radians, wavelength in feet."""
    q = psi**0.6
    a1, a2, a3 = ((1.0 + (wavelength / each) ** 3) for each in (0.03, 0.1, 0.3))
    return 2.63 * a1**0.1 / (a2**0.1 * a3 ** (q / 3.0) * (1.0 + 0.35 * q))
