"""The NRL's mean sea clutter: one formula for all bands, without the wind's direction."""

from __future__ import annotations

import numpy as np
from numpy.typing import ArrayLike, NDArray

from seamap_rt.scattering.model_range import ModelRange

RANGE = ModelRange("the NRL 2012 sea clutter model", (0.1, 60.0), (0.5e9, 35e9), (0.0, 6.0))
_COEFFICIENTS = {
    "HH": (-73.0, 20.781, 7.351, 25.65, 0.00540),
    "VV": (-50.796, 25.93, 0.7093, 21.588, 0.00211),
}


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
    the model's edge, and it must be requested. σ0 is steep at the lower edge: VV rises 5.7 dB from
    0.1° to 0.2°.
    """
    psi, state, frequency = RANGE.checked(grazing_deg, sea_state, frequency_hz, polarization, extrapolate, clipped)
    c1, c2, c3, c4, c5 = _COEFFICIENTS[polarization]
    level_db = (
        c1
        + c2 * np.log10(np.sin(np.radians(psi)))
        + (27.5 + c3 * psi) * np.log10(frequency / 1e9) / (1.0 + 0.95 * psi)
        + c4 * (state + 1.0) ** (1.0 / (2.0 + 0.085 * psi + 0.033 * state))
        + c5 * psi**2
    )
    return np.asarray(10.0 ** (level_db / 10.0))
