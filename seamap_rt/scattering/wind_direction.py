"""How mean clutter falls from upwind to downwind, and its mean over all directions."""

from __future__ import annotations

import numpy as np
import scipy
from numpy.typing import ArrayLike, NDArray


def wind_factor(strength: ArrayLike, wind_angle: ArrayLike | None) -> NDArray[np.float64]:
    """exp(strength · cos φ), φ [rad] the look's azimuth less the one that the wind comes from; they broadcast.

    φ = 0 looks into the wind. None is the mean over all φ, the modified Bessel function I0(strength): a mean of
    powers, not of decibels.
    """
    if wind_angle is None:
        return np.asarray(scipy.special.i0(np.asarray(strength, dtype=np.float64)))
    return np.exp(np.asarray(strength, dtype=np.float64) * np.cos(np.asarray(wind_angle, dtype=np.float64)))
