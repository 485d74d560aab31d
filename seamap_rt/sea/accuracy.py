"""What interpolation costs: the expected error of a spline in space and time, and the time step that keeps it small."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from .lattice import Lattice
from .spline import bspline_image_error

TIME_ORDER = 3
TIME_STEP_CYCLES = 0.375  # of the fastest wave, at most: beyond ½ a knot no longer tells a wave from its image
ELEVATION_BUDGET = 3e-4  # m rms, what interpolation in time may cost
VELOCITY_BUDGET = 5e-3  # m/s rms
RELATIVE_BUDGETS = 1e-3, 2e-2  # of the rms elevation and of the rms vertical velocity, for small seas


@dataclass(frozen=True)
class InterpolationError:
    """Expected rms error of the spline against the exact sum of waves."""

    elevation: float  # m
    vertical_velocity: float  # m/s
    slope: float  # along x or y, the larger


def interpolation_error(
    lattice: Lattice, folded: NDArray[np.float64], shape: tuple[int, int], order: int, time_step: float
) -> InterpolationError:
    """Expected errors of a spline on a grid of the given shape. Images in x, y and t are independent waves.

    folded: variance on the lattice's quadrant, as `Lattice.fold` gives it.
    """
    rows, columns = lattice.reach
    k_east, k_north = lattice.east[columns:], lattice.north[rows:]
    cycles_east, cycles_north = (
        k * lattice.length / (2.0 * np.pi * points) for k, points in ((k_east, shape[1]), (k_north, shape[0]))
    )
    omega, by_frequency = _by_frequency(lattice.omega, folded)
    cycles_time = omega * time_step / (2.0 * np.pi)
    time, rate = (bspline_image_error(TIME_ORDER, cycles_time, d) ** 2 for d in (0, 1))
    east, east_slope = (bspline_image_error(order, cycles_east, d) ** 2 for d in (0, 1))
    north, north_slope = (bspline_image_error(order, cycles_north, d) ** 2 for d in (0, 1))

    by_east, by_north = folded.sum(axis=0), folded.sum(axis=1)
    speed = folded * lattice.omega**2
    elevation = by_frequency @ time + by_east @ east + by_north @ north
    velocity = by_frequency @ (omega**2 * rate) + speed.sum(axis=0) @ east + speed.sum(axis=1) @ north
    slope = max(by_east @ (k_east**2 * east_slope), by_north @ (k_north**2 * north_slope))
    return InterpolationError(*(float(np.sqrt(square)) for square in (elevation, velocity, slope)))


def longest_time_step(lattice: Lattice, folded: NDArray[np.float64]) -> float:
    """The longest step 1/n second between knots that keeps the spline in time within its budgets.

    folded: variance on the lattice's quadrant, as `Lattice.fold` gives it.
    """
    omega, variance = _by_frequency(lattice.omega, folded)
    carries = variance > 0.0
    if not carries.any():
        return 1.0
    omega, variance = omega[carries], variance[carries]
    elevation = min(ELEVATION_BUDGET, RELATIVE_BUDGETS[0] * np.sqrt(variance.sum()))
    velocity = min(VELOCITY_BUDGET, RELATIVE_BUDGETS[1] * np.sqrt(np.sum(variance * omega**2)))
    count = max(1, int(np.ceil(omega[-1] / (2.0 * np.pi * TIME_STEP_CYCLES))))
    while True:
        cycles = omega / (2.0 * np.pi * count)
        misses = np.sum(variance * bspline_image_error(TIME_ORDER, cycles) ** 2) > elevation**2
        blurs = np.sum(variance * (omega * bspline_image_error(TIME_ORDER, cycles, 1)) ** 2) > velocity**2
        if not (misses or blurs):
            return 1.0 / count
        count += 1


def _by_frequency(
    omega: NDArray[np.float64], variance: NDArray[np.float64]
) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
    """Variance summed over narrow bands of frequency: upper edges (rad/s), variances."""
    bands = 4096
    edges = float(omega.max()) * np.arange(1, bands + 1) / bands
    number = np.minimum((omega * (bands / omega.max())).astype(np.int64), bands - 1)
    return edges, np.bincount(number.ravel(), variance.ravel(), minlength=bands).astype(np.float64)
