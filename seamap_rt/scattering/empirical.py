"""Mean sea clutter as measured: σ0 per unit HORIZONTAL area, shadowing included."""

from __future__ import annotations

import numpy as np
from numpy.typing import ArrayLike, NDArray

from seamap_rt.conventions import POLARIZATIONS

_GRAZING_DEG = (0.1, 60.0)
_FREQUENCY_HZ = (0.5e9, 35e9)
_SEA_STATE = (0.0, 6.0)
_COEFFICIENTS = {
    "HH": (-73.0, 20.781, 7.351, 25.65, 0.00540),
    "VV": (-50.796, 25.93, 0.7093, 21.588, 0.00211),
}


def sea_state_from_wind(wind_speed: ArrayLike) -> NDArray[np.float64]:
    """Douglas sea state (a real number) of a fully developed sea under a wind [m/s]: (U10/3.16)^1.25."""
    return np.asarray((np.asarray(wind_speed, dtype=np.float64) / 3.16) ** 1.25)


def nrcs_gregers_hansen12(
    grazing_deg: ArrayLike,
    sea_state: ArrayLike,
    frequency_hz: ArrayLike,
    polarization: str,
    extrapolate: bool = False,
    clipped: bool = False,
) -> NDArray[np.float64]:
    """Mean σ0 [linear] of the sea over all wind directions, "HH" or "VV"; the arguments broadcast.

    Gregers-Hansen & Mittal, An Improved Empirical Model for Radar Sea Clutter Reflectivity,
    NRL/MR/5310–12-9346 (2012): grazing 0.1–60°, 0.5–35 GHz, sea states 0–6. Raises ValueError outside, unless
    `extrapolate` lets the formula run on (grazing must still be positive). `clipped` brings the grazing
    angle, and only it, into 0.1–60° first: facets at the mast's foot or on the horizon then take the value at
    the model's edge, and whoever asks for it says so. σ0 is steep at the lower edge: VV rises 5.7 dB from
    0.1° to 0.2°.
    """
    if polarization not in _COEFFICIENTS:
        raise ValueError(f"polarization = {polarization!r}: must be one of {', '.join(POLARIZATIONS)}")
    psi = np.asarray(grazing_deg, dtype=np.float64)
    state = np.asarray(sea_state, dtype=np.float64)
    frequency = np.asarray(frequency_hz, dtype=np.float64)
    if clipped:
        psi = np.clip(psi, *_GRAZING_DEG)
    if extrapolate:
        _check("grazing_deg", psi, (np.nextafter(0.0, 1.0), 90.0), "give a grazing angle above 0")
        _check("sea_state", state, (0.0, np.inf), "give a sea state of 0 or more")
        _check("frequency_hz", frequency, (np.nextafter(0.0, 1.0), np.inf), "give a positive frequency")
    else:
        _check("grazing_deg", psi, _GRAZING_DEG, "pass clipped=True to use the value at the model's edge")
        _check("sea_state", state, _SEA_STATE, "lower the wind, or pass extrapolate=True")
        _check("frequency_hz", frequency, _FREQUENCY_HZ, "use another model, or pass extrapolate=True")

    c1, c2, c3, c4, c5 = _COEFFICIENTS[polarization]
    level_db = (
        c1
        + c2 * np.log10(np.sin(np.radians(psi)))
        + (27.5 + c3 * psi) * np.log10(frequency / 1e9) / (1.0 + 0.95 * psi)
        + c4 * (state + 1.0) ** (1.0 / (2.0 + 0.085 * psi + 0.033 * state))
        + c5 * psi**2
    )
    return np.asarray(10.0 ** (level_db / 10.0))


def _check(name: str, value: NDArray[np.float64], limits: tuple[float, float], remedy: str) -> None:
    low, high = limits
    outside = ~((value >= low) & (value <= high))
    if np.any(outside):
        raise ValueError(
            f"{name} = {value[outside].flat[0]:g}: the NRL 2012 sea clutter model holds for "
            f"{low:g} to {high:g}; {remedy}"
        )
