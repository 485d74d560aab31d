"""Mean sea level of a turn as the boat's sensors have it, which may lie high or askew: a plane through the heights.

A cell's weight is the inverse of two variances: that of the sea, which neighbours on a wave share, and that of its
errors, which they do not share and which counts for so much less. Weighted by the errors of single cells, the near ones
would lay the plane along the wave on which the boat lies, and the far ones would be off by more than the wave is high.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from .error_covariance import ErrorCovariance

Map = NDArray[np.float64]

_TOGETHER = 100.0  # cells of a few metres that lie on the same part of a wave: 30 m a side


def mean_plane(height: Map, errors: ErrorCovariance, x: Map, y: Map) -> tuple[Map, Map]:
    """The plane [m] through a turn's heights [m] at x, y [m], and the variance [m²] that their errors leave it; all
    (look, gate). 0 where there are too few for a plane."""
    variance = errors.variance
    known = np.isfinite(height) & np.isfinite(variance) & np.isfinite(x) & np.isfinite(y)
    if np.count_nonzero(known) < 3:
        return np.zeros(height.shape), np.zeros(height.shape)
    sea = float(np.median(height[known] ** 2)) + 1e-9
    root = 1.0 / np.sqrt(sea + variance[known] / _TOGETHER)
    terms = np.stack((np.ones(root.size), x[known], y[known]), axis=1)
    scale = np.maximum(np.abs(terms).max(axis=0), 1e-9)
    inverse = np.linalg.pinv(terms / scale * root[:, None], rcond=1e-9)
    plane = inverse @ (height[known] * root) / scale
    doubt = (inverse * (errors.of_means[known] * root**2)) @ inverse.T / np.outer(scale, scale)
    places = np.stack((np.ones(x.shape), np.nan_to_num(x), np.nan_to_num(y)))
    level = np.einsum("i,i...->...", plane, places)
    return level, np.einsum("i...,ij,j...->...", places, doubt, places)
