"""Where the echo grows or fades along the range, a gate's power does not come from its middle.

Below the beam the elevation pattern rises steeply: a gate at 15 m receives its far side best, and takes its phase for
that of its middle. To first order the power's centre lies d ln P/dR · σ² beyond, σ² the variance of the pulse's power,
and the height found is that of mean sea level so far beyond, H/R times the distance. A single reflector has no such
error, so that it is taken off only where the sea is known to be one (optimal interpolation), and else is counted as
doubt.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from ..input.description import RadarDescription

_STEEPEST = 1.0  # 1/m, of ln P: beyond that the first order does not hold


def edge_bias(power: NDArray[np.float64], height: NDArray[np.float64], radar: RadarDescription) -> NDArray[np.float64]:
    """Height [m] (look or 1, gate) by which a distributed sea is found too high, to first order.

    power (look, gate): of the echo, without noise [W]; height: of the antenna above mean sea level [m].
    """
    known = np.isfinite(power)
    counted = np.where(known, np.maximum(power, 0.0), 0.0).sum(axis=0) / np.maximum(known.sum(axis=0), 1)
    if radar.ranges.size < 3:
        return np.zeros((1, radar.ranges.size))
    with np.errstate(divide="ignore", invalid="ignore"):
        growth = np.nan_to_num(np.gradient(np.log(counted), radar.ranges), posinf=0.0, neginf=0.0)
    smooth = np.convolve(np.pad(growth, 1, mode="edge"), np.full(3, 1.0 / 3.0), "valid")
    return height / radar.ranges * radar.response.spread_m**2 * np.clip(smooth, -_STEEPEST, _STEEPEST)
