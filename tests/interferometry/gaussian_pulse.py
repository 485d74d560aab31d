"""A pulse of which all moments are closed forms."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float64]


class GaussianPulse:
    """A response exp(−s²/4σ²), whose power has the standard deviation σ; its noise is white beyond a metre."""

    spread_m = 0.9
    support_m = 6.0

    def __call__(self, s: Array) -> Array:
        return np.exp(-np.square(s) / (4.0 * self.spread_m**2))

    def noise_correlation(self, lag: Array) -> Array:
        return np.exp(-np.square(lag))
