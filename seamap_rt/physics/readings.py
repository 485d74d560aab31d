"""What is left of the noise of a sensor's readings in the mean over a time."""

from __future__ import annotations

import numpy as np

_SHARES = (np.arange(64) + 0.5) / 64.0  # of that time


def variance_kept(readings: float) -> float:
    """Of independent readings, joined by straight lines, over one reading's variance: A(x) = 2 ∫₀¹ (1 − u) B(x u) du.

    readings: x, how many fall into the time. Linear interpolation has the cubic B-spline B for its correlation,
    B(0) = 2/3: a mean over less than a reading keeps two thirds, one over many 1/x.
    """
    apart = readings * _SHARES
    beside = np.where(apart < 1.0, 2.0 / 3.0 - apart**2 + 0.5 * apart**3, np.clip(2.0 - apart, 0.0, 1.0) ** 3 / 6.0)
    return 2.0 * float(np.mean((1.0 - _SHARES) * beside))
