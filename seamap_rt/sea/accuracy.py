"""What interpolation costs: the expected error of a spline in space and time, and the time step that keeps it small."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from functools import partial

import numpy as np
from numpy.typing import NDArray

from ..physics.dispersion import orbital_ratio
from .lattice import Lattice
from .spline import bspline_image_error

ImageError = Callable[[NDArray[np.float64], int], NDArray[np.float64]]

TIME_ORDER = 5
TIME_STEP_CYCLES = 0.375  # of the fastest wave, at most: beyond ½ a wave and its image agree at the knots
ELEVATION_BUDGET = 3e-4  # m rms, what interpolation in time may cost
VELOCITY_BUDGET = 1.2e-3  # m/s rms
RELATIVE_BUDGETS = 1e-3, 2e-2  # of the rms elevation and of the rms vertical velocity, for small seas


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
) -> InterpolationError:
    """Expected errors of a spline on a grid of the given shape. Images in x, y and t are independent waves.

    folded: variance on the lattice's quadrant, as `Lattice.fold` gives it. in_time: what interpolation in time costs a
    unit wave of some cycles a step, and its derivatives; the spline's where it is left out.
    """
    rows, columns = lattice.reach
    along_time = in_time or partial(bspline_image_error, TIME_ORDER)
    east, north = lattice.east[columns:], lattice.north[rows:, None]
    omega, _ = _by_frequency(lattice.omega, folded)
    # Squared images relative to their wave, of its derivatives 0, 1 and 2.
    in_x, in_y = (
        [bspline_image_error(order, np.arange(most + 1.0) / points, derivative) ** 2 for derivative in (0, 1, 2)]
        for most, points in ((columns, shape[1]), (rows, shape[0]))
    )
    in_t = [along_time(omega * time_step / (2.0 * np.pi), derivative) ** 2 for derivative in (0, 1, 2)]

    def rms(variance: NDArray[np.float64], x: int = 0, y: int = 0, t: int = 0) -> float:
        """Error of a quantity with this variance of each wave: the spline's derivative of order x, y, t."""
        _, by_frequency = _by_frequency(lattice.omega, variance)
        square = variance.sum(axis=0) @ in_x[x] + variance.sum(axis=1) @ in_y[y] + by_frequency @ in_t[t]
        return float(np.sqrt(square))

    k = lattice.quadrant(lambda k: np.where(k > 0.0, k, np.inf))
    shift = folded * (orbital_ratio(k, lattice.depth) / k) ** 2
    flow = shift * lattice.omega**2
    return InterpolationError(
        elevation=rms(folded),
        vertical_velocity=rms(folded * lattice.omega**2, t=1),
        slope=max(rms(folded * east**2, x=1), rms(folded * north**2, y=1)),
        horizontal_velocity=max(rms(flow * east**2, x=1), rms(flow * north**2, y=1)),
        shift=max(rms(shift * east**2, x=1), rms(shift * north**2, y=1)),
        shift_gradient=max(rms(shift * east**4, x=2), rms(shift * north**4, y=2)),
    )


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
