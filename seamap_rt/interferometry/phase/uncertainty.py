"""How many independent samples a window of dwells and gates holds, of the echo's speckle and of the noise."""

from __future__ import annotations

from dataclasses import dataclass
from functools import lru_cache

import numpy as np
from numpy.typing import NDArray

from ...radar.waveform import RangeResponse
from ..covariance.windows import independent_looks
from ..input.description import RadarDescription

Weights = tuple[NDArray[np.float64], NDArray[np.float64]]  # of a window: along range, across looks
ONE_CELL: Weights = (np.ones(1), np.ones(1))


@dataclass(frozen=True)
class Dwelt:
    """What one look's dwell holds in a gate: pulses, and the speckle's correlation from pulse to pulse."""

    pulses: int
    correlation: NDArray[np.float64]  # |ρ| at lags of 0, 1, 2 … pulses
    looks: int = 1_000_000  # that there are: a window is no wider

    def every(self, step: float) -> Dwelt:
        """The same dwell where one pulse in 1/step is compared; step: a ratio, above 1 for more."""
        if not step > 0.0:  # a receiver that heard nothing
            return self
        count = max(1, round(self.pulses * step))
        lags = np.arange(count) / step
        return Dwelt(count, np.interp(lags, np.arange(self.correlation.size), self.correlation), self.looks)

    def samples(self, window: Weights, radar: RadarDescription) -> Samples:
        """Of a window of such dwells; its looks are taken to be independent, its gates overlap by the pulse."""
        range_weights, look_weights = window
        beyond = max(0, look_weights.size // 2 - (self.looks - 1))
        look_weights = look_weights[beyond : look_weights.size - beyond]
        echo, noise = echo_correlations(radar.response, radar.spacing, range_weights.size)
        across = independent_looks(look_weights, np.eye(1, look_weights.size).ravel())
        speckle = max(1.0, independent_looks(np.ones(self.pulses), self.correlation))
        return Samples(
            speckle * independent_looks(range_weights, echo) * across,
            self.pulses * independent_looks(range_weights, noise) * across,
        )


@lru_cache(maxsize=8)
def echo_correlations(
    response: RangeResponse, spacing: float, gates: int
) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
    """Of the echo and of the noise between gates 0, 1, 2 … apart."""
    lags = spacing * np.arange(gates)
    fine = np.linspace(-2.0 * response.support_m, 2.0 * response.support_m, 801)
    pulse = response(fine)
    return np.array([pulse @ response(fine + lag) for lag in lags]) / (pulse @ pulse), response.noise_correlation(lags)


@dataclass(frozen=True)
class Samples:
    """Independent samples in a window."""

    speckle: float
    noise: float
