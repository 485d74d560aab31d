"""Speckle: unit complex Gaussian per facet, correlated in slow time as exp(−(τ/τc)²).

Over the few milliseconds for which the beam dwells on a column the process has few degrees of freedom: it is drawn in
the basis of its own covariance matrix, truncated where the discarded variance is below 1e-4.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

_STAGE = 2  # of the scene's random source; 1 is the sea, 3 the receiver's noise


def speckle_basis(knots: int, spacing_s: float, decorrelation_time_s: float) -> NDArray[np.float32]:
    """(mode, knot): real rows whose products with unit complex Gaussians have the asked-for covariance."""
    lag = spacing_s * np.arange(knots)
    covariance = np.exp(-(((lag[:, None] - lag[None, :]) / decorrelation_time_s) ** 2))
    variance, modes = np.linalg.eigh(covariance)
    kept = np.cumsum(variance) > 1e-4 * knots  # ascending: drop the smallest until 1e-4 of the variance is gone
    kept[-1] = True
    basis = (modes[:, kept] * np.sqrt(np.maximum(variance[kept], 0.0))).T
    basis /= np.sqrt(np.sum(basis**2, axis=0))  # unit variance at every knot, exactly
    return basis.astype(np.float32)


def speckle_weights(seed: int, column_number: int, modes: int, facets: int) -> NDArray[np.complex64]:
    """(mode, facet) unit complex Gaussians of one column; a column keeps its numbers however the work is cut up."""
    random = np.random.Generator(np.random.SFC64(np.random.SeedSequence(seed, spawn_key=(_STAGE, column_number))))
    draws = random.standard_normal((modes, facets, 2), dtype=np.float32)
    draws *= np.float32(np.sqrt(0.5))
    return draws.view(np.complex64)[..., 0]
