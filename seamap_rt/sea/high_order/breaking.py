"""Breaking, as the energy that steepening waves drive into waves too short for the model."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from .basin import Band

CUT_OFF = 8.0  # of the filter, in wave numbers of the peak
SHARPNESS = 30.0
PER_PERIOD = 64.0  # how often in a peak period the filter of the paper acts in full


@dataclass(frozen=True)
class LowPass:
    """The low-pass filter exp(−(k/k_c)³⁰) of Xiao et al. (2013, J. Fluid Mech. 720, 357–392).

    Theirs acts after each of their time steps, with k_c = 8 wave numbers of the peak, tuned to the energy that breaking
    waves lost in a tank. Here it acts at a rate, so that a shorter step does not damp more.
    """

    cut_off: float  # k_c, rad/m
    rate: float  # 1/s, how often it acts in full

    def share_left(self, band: Band, step: float) -> NDArray[np.float64]:
        """Of each wave's amplitude after a step of so many seconds."""
        with np.errstate(over="ignore", under="ignore"):
            steep = (np.sqrt(band.square) / self.cut_off) ** SHARPNESS
            return np.exp(-self.rate * step * np.minimum(steep, 1e3))
