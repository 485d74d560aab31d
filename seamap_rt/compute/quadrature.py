"""Gauss–Legendre quadrature, worked out once for each number of nodes: NumPy finds them as eigenvalues, in O(n³)."""

from __future__ import annotations

from functools import lru_cache

import numpy as np
from numpy.typing import NDArray


@lru_cache(maxsize=32)
def gauss_legendre(nodes: int) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
    """Nodes and weights (nodes,) for the interval −1 to 1, both read-only; exact for polynomials of degree 2n − 1."""
    points, weights = np.polynomial.legendre.leggauss(nodes)
    points.flags.writeable = weights.flags.writeable = False
    return points, weights
