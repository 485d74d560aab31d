"""Uniform B-splines as interpolants of waves (Unser 1999, "Splines: a perfect fit for signal and image processing").

A wave e^{iκx} on grid points i becomes the spline Σ c_i β(x − i) with c_i = e^{iκi}/β̂(κ): dividing by the B-spline's
Fourier transform makes the wave's own line exact and leaves only its images, which fall as (κ/(2π − κ))^(order + 1).

In time an image of a wave at ω is a wave at ω + 2πm/step, (ω/(ω + 2πm/step))^(order + 1) as large. What follows from a
field by derivatives in time multiplies it by what they make of its own frequency, so that high derivatives need a high
order in time: `longest_time_step` keeps what that costs within a budget.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from math import comb, factorial

import numpy as np
from numpy.polynomial import polynomial
from numpy.typing import ArrayLike, NDArray

from ..physics.dispersion import orbital_ratio
from .fields import ITSELF, InTime, Kind, flow_missed, from_base, harmonic_factors, per_elevation
from .lattice import Lattice


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


ImageError = Callable[[NDArray[np.float64], int], NDArray[np.float64]]

TIME_ORDER = 7  # the third derivative of a base is the water's rise, and falls with the fifth power of the step
TIME_STEP_CYCLES = 0.375  # of the fastest wave, at most: beyond ½ a wave and its image agree at the knots
ELEVATION_BUDGET = 3e-4  # m rms, what interpolation in time may cost
VELOCITY_BUDGET = 1.2e-3  # m/s rms
RELATIVE_BUDGETS = 1e-3, 2e-2  # of the rms elevation and of the rms vertical velocity, for small seas
_IMAGES = (-3, -2, -1, 1, 2, 3)
_UNSEEN = 0.1  # of a budget: what adds no more than half a percent to errors of that size
_PLACES = 16  # between two knots, over which rounding is averaged
_ROUNDED = 2e-7  # of a field's rms: what single precision and FFTs leave of coefficients (1.9e-7 of 1440² points)


@dataclass(frozen=True)
class InterpolationError:
    """Expected rms error of the spline against the exact sum of waves; along x or y, the larger."""

    elevation: float  # m
    vertical_velocity: float  # m/s
    slope: float
    horizontal_velocity: float  # m/s
    shift: float  # m, horizontal displacement
    shift_gradient: float


def interpolation_error(
    lattice: Lattice,
    folded: NDArray[np.float64],
    shape: tuple[int, int],
    order: int,
    time_step: float,
    in_time: ImageError | None = None,
    base: Kind | None = None,
) -> InterpolationError:
    """Expected errors of a spline on a grid of the given shape. Images in x, y and t are independent waves.

    folded: variance on the lattice's quadrant, as `Lattice.fold` gives it. in_time: what interpolation in time costs a
    unit wave of some cycles a step, and its derivatives; the spline's where it is left out. base: the field that others
    follow from, as `exact_base` allows it.
    """
    rows, columns = lattice.reach
    east, north = lattice.east[columns:], lattice.north[rows:, None]
    omega, _ = _frequency_bands(lattice.omega, folded)
    # Squared images relative to their wave, of its derivatives 0, 1 and 2.
    in_x, in_y = (
        [bspline_image_error(order, np.arange(most + 1.0) / points, derivative) ** 2 for derivative in (0, 1, 2)]
        for most, points in ((columns, shape[1]), (rows, shape[0]))
    )

    def image_error(kind: Kind, derivative: int) -> NDArray[np.float64]:
        if in_time is not None:
            return in_time(omega * time_step / (2.0 * np.pi), derivative) ** 2
        return _images(omega, time_step, _time_sum(kind, derivative, base))

    def rms(variance: NDArray[np.float64], x: int = 0, y: int = 0, t: int = 0, of: Kind = "elevation") -> float:
        """Error of a quantity with this variance of each wave: the derivative of order x, y, t of a field."""
        _, by_frequency = _frequency_bands(lattice.omega, variance)
        square = variance.sum(axis=0) @ in_x[x] + variance.sum(axis=1) @ in_y[y] + by_frequency @ image_error(of, t)
        return float(np.sqrt(square))

    k = lattice.quadrant(lambda k: np.where(k > 0.0, k, np.inf))
    shift = folded * (orbital_ratio(k, lattice.depth) / k) ** 2
    flow = shift * lattice.omega**2
    return InterpolationError(
        elevation=rms(folded),
        vertical_velocity=rms(folded * lattice.omega**2, t=1),
        slope=max(rms(folded * east**2, x=1), rms(folded * north**2, y=1)),
        horizontal_velocity=max(rms(flow * east**2, x=1, of="potential"), rms(flow * north**2, y=1, of="potential")),
        shift=max(rms(shift * east**2, x=1, of="shift"), rms(shift * north**2, y=1, of="shift")),
        shift_gradient=max(rms(shift * east**4, x=2, of="shift"), rms(shift * north**4, y=2, of="shift")),
    )


def longest_time_step(lattice: Lattice, folded: NDArray[np.float64], base: Kind | None = None) -> float:
    """The longest step 1/n second between knots that keeps the spline in time within its budgets.

    folded: variance on the lattice's quadrant, as `Lattice.fold` gives it. base: the field that others follow from.
    """
    omega, variance = _frequency_bands(lattice.omega, folded)
    carries = variance > 0.0
    if not carries.any():
        return 1.0
    omega, variance = omega[carries], variance[carries]
    elevation, velocity = _budgets(omega, variance)
    count = max(1, int(np.ceil(omega[-1] / (2.0 * np.pi * TIME_STEP_CYCLES))))
    while True:
        height, rise = (_images(omega, 1.0 / count, _time_sum("elevation", derivative, base)) for derivative in (0, 1))
        if variance @ height <= elevation**2 and (variance * omega**2) @ rise <= velocity**2:
            return 1.0 / count
        count += 1


def exact_base(lattice: Lattice, folded: NDArray[np.float64], base: Kind | None) -> Kind | None:
    """The base, if what follows from it is as exact as the budgets of interpolation in time ask; else None.

    Derivatives enlarge what single precision rounds, the more the shorter the step, and without surface tension the
    flow of waves of some centimetres is too slow.
    """
    if base is None or not folded.any():
        return None
    omega, variance = _frequency_bands(lattice.omega, folded)
    elevation, velocity = _budgets(omega, variance)
    step = longest_time_step(lattice, folded, base)
    size = float(np.sqrt(np.sum(folded * np.abs(per_elevation(base, lattice, base)) ** 2)))
    k = lattice.quadrant(lambda k: np.where(k > 0.0, k, np.inf))
    flow = folded * (lattice.omega * orbital_ratio(k, lattice.depth)) ** 2
    missed = np.sum(flow * flow_missed(np.where(k < np.inf, k, 0.0)) ** 2)
    noise = [_ROUNDED * size * _gain(_time_sum("elevation", derivative, base), step) for derivative in (0, 1)]
    worst = max(noise[0] / elevation, noise[1] / velocity, np.sqrt(missed) / velocity)
    return base if worst <= _UNSEEN else None


def _time_sum(kind: Kind, derivative: int, base: Kind | None) -> InTime:
    """The sum of derivatives in time of the field that has knots which is a derivative of this one."""
    return (0.0,) * derivative + (from_base(kind, base) or ITSELF)


def _images(omega: NDArray[np.float64], step: float, factors: InTime) -> NDArray[np.float64]:
    """Squared images in time of waves at ω [rad/s], relative to the wave, of a sum of derivatives of its spline."""
    own = np.abs(harmonic_factors(factors, omega))
    squared = np.zeros_like(omega)
    for image in _IMAGES:
        there = omega + 2.0 * np.pi * image / step
        squared += ((omega / there) ** (TIME_ORDER + 1) * np.abs(harmonic_factors(factors, there)) / own) ** 2
    return squared


def _gain(factors: InTime, step: float) -> float:
    """The factor by which a sum of derivatives multiplies the rms of errors that are independent from knot to knot."""
    polynomials = bspline_polynomials(TIME_ORDER, len(factors) - 1)
    weights = np.tensordot(np.array(factors) / step ** np.arange(len(factors)), polynomials, axes=1)
    place = (np.arange(_PLACES) + 0.5) / _PLACES
    return float(np.sqrt(np.mean(np.sum(polynomial.polyval(place, weights) ** 2, axis=0))))


def _budgets(omega: NDArray[np.float64], variance: NDArray[np.float64]) -> tuple[float, float]:
    """What interpolation in time may cost waves at ω [rad/s] with these variances: elevation (m), velocity (m/s)."""
    return (
        min(ELEVATION_BUDGET, RELATIVE_BUDGETS[0] * float(np.sqrt(variance.sum()))),
        min(VELOCITY_BUDGET, RELATIVE_BUDGETS[1] * float(np.sqrt(np.sum(variance * omega**2)))),
    )


def _frequency_bands(
    omega: NDArray[np.float64], variance: NDArray[np.float64]
) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
    """Variance summed over narrow bands of frequency: upper edges (rad/s), variances."""
    bands = 4096
    edges = float(omega.max()) * np.arange(1, bands + 1) / bands
    number = np.minimum((omega * (bands / omega.max())).astype(np.int64), bands - 1)
    return edges, np.bincount(number.ravel(), variance.ravel(), minlength=bands).astype(np.float64)
