"""Gauss–Legendre quadrature, worked out once for each number of nodes, which NumPy finds as eigenvalues, in O(n³); and
roots by bisection, for those that stand in the way of a scene's first check: to load `scipy.optimize` takes 0.1 s."""

from __future__ import annotations

from collections.abc import Callable
from functools import lru_cache

import numpy as np
from numpy.typing import NDArray


@lru_cache(maxsize=32)
def gauss_legendre(nodes: int) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
    """Nodes and weights (nodes,) for the interval −1 to 1, both read-only; exact for polynomials of degree 2n − 1."""
    points, weights = np.polynomial.legendre.leggauss(nodes)
    points.flags.writeable = weights.flags.writeable = False
    return points, weights


def bisect(function: Callable[[float], float], low: float, high: float) -> float:
    """Where a function changes its sign between two places, to the last bits of it."""
    below = function(low) < 0.0
    for _ in range(60):
        middle = 0.5 * (low + high)
        low, high = (middle, high) if (function(middle) < 0.0) == below else (low, middle)
    return 0.5 * (low + high)
