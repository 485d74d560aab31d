"""Uniform B-splines as interpolants of waves (Unser 1999, "Splines: a perfect fit for signal and image processing").

A wave e^{iκx} on grid points i becomes the spline Σ c_i β(x − i) with c_i = e^{iκi}/β̂(κ): dividing by the B-spline's
Fourier transform makes the wave's own line exact and leaves only its images, which fall as (κ/(2π − κ))^(order + 1).
"""

from __future__ import annotations

from math import comb, factorial

import numpy as np
from numpy.polynomial import polynomial
from numpy.typing import ArrayLike, NDArray


def bspline_transform(order: int, cycles: ArrayLike) -> NDArray[np.float64]:
    """Fourier transform β̂ of the B-spline, sinc^(order+1); cycles = κ/2π per grid step, |cycles| ≤ ½."""
    return np.sinc(np.asarray(cycles, dtype=np.float64)) ** (order + 1)


def bspline_image_error(order: int, cycles: ArrayLike, derivative: int = 0) -> NDArray[np.float64]:
    """Root of the summed squares of a unit wave's images, relative to the wave, or of their derivatives to its own.

    Averaged over positions, the spline's squared error is the sum of the squares of its images.
    """
    cycles = np.asarray(cycles, dtype=np.float64)
    squared = np.zeros_like(cycles)
    for image in (-3, -2, -1, 1, 2, 3):
        square = np.square(cycles / (cycles + image))
        power = square.copy()
        for _ in range(order - derivative):  # five times as fast as a power of floats
            power *= square
        squared += power
    return np.sqrt(squared)


def bspline_polynomials(order: int, derivatives: int = 2) -> NDArray[np.float64]:
    """Weights of the order + 1 grid points around x = floor(x) + f as polynomials of f: (derivative, power of f, tap).

    Taps run from floor(x) − (order − 1)/2 upward; order: odd, or 0 for the one point of an axis without extent.
    derivatives: 0 … this many, per grid step. The sum is Schoenberg's (1946) of truncated powers, written out in f.
    """
    value = np.zeros((order + 1, order + 1))
    for tap in range(order + 1):
        for k in range(order + 1 - tap):
            value[:, tap] += (-1) ** k * comb(order + 1, k) * polynomial.polypow([order - tap - k, 1], order)
    value /= factorial(order)  # last: up to here all numbers are whole
    result = np.zeros((derivatives + 1, order + 1, order + 1))
    for derivative in range(min(derivatives, order) + 1):
        result[derivative, : order + 1 - derivative] = polynomial.polyder(value, derivative)
    return result
