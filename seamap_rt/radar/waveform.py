"""What a point reflector's echo looks like along the gates: the pulse through the receiver's filter.

The transmitted pulse is rectangular. The receiver's filter is Gaussian with a *noise* bandwidth of exactly B,
|H(f)|² = exp(−π f²/B²), so that kTBF holds and the response is closed: a difference of two error functions.
(An ideal brick wall would ring as 1/t: the echo at 15 m, 57 dB above that at 400 m, would then leak into every gate.)
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike, NDArray
from scipy.special import erf

from ..conventions import SPEED_OF_LIGHT
from ..settings import RadarSettings


@dataclass(frozen=True)
class RangeResponse:
    """Voltage response h(r − R) of a gate at r to a reflector at R; 1 for a pulse that the filter leaves alone."""

    pulse_width_s: float
    bandwidth_hz: float

    @classmethod
    def of(cls, radar: RadarSettings) -> RangeResponse:
        return cls(radar.pulse_width_s, radar.bandwidth_hz)

    def __call__(self, offset_m: ArrayLike) -> NDArray[np.float64]:
        """h at a range offset r − R [m], any shape."""
        time = 2.0 * np.asarray(offset_m, dtype=np.float64) / SPEED_OF_LIGHT
        steepness = np.sqrt(2.0 * np.pi) * self.bandwidth_hz
        half = 0.5 * self.pulse_width_s
        return 0.5 * (erf(steepness * (time + half)) - erf(steepness * (time - half)))

    @property
    def support_m(self) -> float:
        """Half-width beyond which h is below 1e-5 of its peak (−100 dB in power)."""
        edge = 3.02 / (np.sqrt(2.0 * np.pi) * self.bandwidth_hz)  # ½ erfc(3.02) ≈ 1e-5
        return 0.5 * SPEED_OF_LIGHT * (0.5 * self.pulse_width_s + edge)

    def noise_correlation(self, offset_m: ArrayLike) -> NDArray[np.float64]:
        """Correlation of the noise of two gates `offset_m` apart, exp(−π B² τ²)."""
        time = 2.0 * np.asarray(offset_m, dtype=np.float64) / SPEED_OF_LIGHT
        return np.exp(-np.pi * (self.bandwidth_hz * time) ** 2)


def gates(radar: RadarSettings) -> NDArray[np.float64]:
    """Slant ranges of the gates [m], from the near end of the window to the far one."""
    near, far = radar.range_m
    count = int(np.floor((far - near) / radar.range_sampling_m + 1e-9)) + 1
    return near + radar.range_sampling_m * np.arange(count, dtype=np.float64)
