"""Error against time of the moving sea on a mesh that turns with the beam.

    python -m validation.sea.sea_speed [--points 60]

One turn of the default scene (JONSWAP, Hs 1.4 m, Tp 5.5 s, 0.8 m, 1024 m) on a polar mesh of 636,000 points, each of
its 825 columns at its own time: elevation, both slopes and the water's velocity, by B-splines on FFTs in space and time
(the default is marked). Errors are rms against the exact sum of waves, in float64, at points drawn from the mesh; its
seconds are extrapolated. Times are medians in the steady state: a turn makes the knots of one second and has the others
from the turn before.
"""

from __future__ import annotations

import itertools
import os
import time
from collections.abc import Callable, Iterator
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from seamap_rt.sea import direct_sum, realize
from seamap_rt.sea.moving_field import MovingField
from seamap_rt.sea.wave_trains import PlaneTrain, Quantity
from seamap_rt.settings import JonswapWaves, SeaSettings, TracingSettings

from ..options import options

QUANTITIES: tuple[Quantity, ...] = ("elevation", "slope_east", "slope_north", "flow_east", "flow_north", "rate")
TURNS = 5
THREADS = len(os.sched_getaffinity(0))


@dataclass(frozen=True)
class Method:
    """A method, its time (s) for a turn and its errors: elevation (mm), slopes (1e-3), velocity (mm/s)."""

    family: str
    name: str
    seconds: float
    errors: tuple[float, float, float]
    default: bool = False


@dataclass(frozen=True)
class Mesh:
    """The points of one turn, and those of them where the exact values (quantity, point) are known."""

    x: NDArray[np.float64]
    y: NDArray[np.float64]
    t: NDArray[np.float64]
    picked: NDArray[np.int64]
    exact: NDArray[np.float64]

    def errors(self, values: NDArray[np.float64], among: slice = slice(None)) -> tuple[float, float, float]:
        """Rms errors of values at the picked points, each group of quantities in thousandths of its unit."""
        square = 1e6 * np.mean((values - self.exact[:, among]) ** 2, axis=1)
        elevation, slope, velocity = np.sqrt((square[0], square[1:3].mean(), square[3:].mean())).tolist()
        return elevation, slope, velocity


def polar_mesh() -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """x, y, t of one turn at 60 rpm: a column each 0.45°, three beams beyond both ends, a rung each 0.5 m."""
    sweep = 0.45 * np.arange(-12, 813)
    ground_range = np.linspace(15.0, 400.0, 771)
    x = np.sin(np.radians(sweep))[:, None] * ground_range
    y = np.cos(np.radians(sweep))[:, None] * ground_range
    return x, y, np.broadcast_to((sweep / 360.0)[:, None], x.shape)


def median_seconds(work: Callable[[], object], times: int = 3) -> float:
    """Median time of several calls."""
    taken = []
    for _ in range(times):
        start = time.perf_counter()
        work()
        taken.append(time.perf_counter() - start)
    return float(np.median(taken))


# ------------------------------------------------------------------------------------------------- this package


def spline_methods(plane: PlaneTrain, mesh: Mesh) -> Iterator[Method]:
    """The package's own method: orders × oversampling × knots a second, and the sea's own choice."""
    choices = [(order, over, steps) for order in (3, 5, 7) for over in (1.125, 1.25, 1.5) for steps in (3, 4, 5, 6)]
    chosen = plane.field
    for order, oversampling, steps in choices:
        field = MovingField(
            plane.lattice,
            plane.amplitude,
            plane.variance,
            order=order,
            oversampling=oversampling,
            time_step=1.0 / steps,
            base=chosen.base,
        )
        default = (field.order, field.shape, field.time_step) == (chosen.order, chosen.shape, chosen.time_step)
        yield _spline_method(plane, field, mesh, f"order {order}, {oversampling:.2f} ×, {steps} knots/s", default)


def _spline_method(plane: PlaneTrain, field: MovingField, mesh: Mesh, name: str, default: bool) -> Method:
    tried = PlaneTrain(plane.lattice, plane.variance, plane.amplitude, field)
    values = tried.sample(mesh.x, mesh.y, mesh.t, QUANTITIES)[:, mesh.picked]
    turn = itertools.count(1.0)
    taken = median_seconds(lambda: tried.sample(mesh.x, mesh.y, mesh.t + next(turn), QUANTITIES), TURNS)
    return Method("spline", name, taken, mesh.errors(values), default)


def print_table(methods: list[Method]) -> None:
    print(f"{'method':<16} {'':<30} {'s/turn':>10} {'elevation mm':>13} {'slope 1e-3':>11} {'velocity mm/s':>14}")
    for method in methods:
        elevation, slope, velocity = method.errors
        print(
            f"{method.family:<16} {method.name:<30} {method.seconds:10.3g} "
            f"{elevation:13.4f} {slope:11.4f} {velocity:14.4f}"
            f"{' <- default' if method.default else ''}"
        )


def main() -> None:
    chosen = options(__doc__, points=60)

    waves = JonswapWaves(spectrum="jonswap", significant_wave_height_m=1.4, peak_period_s=5.5)
    sea = realize(SeaSettings(waves=(waves,)), seed=1, height_error_m=TracingSettings().height_error_m)
    (plane,) = (part for part in sea.trains if isinstance(part, PlaneTrain))
    x, y, t = (np.ravel(value) for value in polar_mesh())
    picked = np.random.default_rng(1).choice(x.size, chosen.points, replace=False)
    start = time.perf_counter()
    state = direct_sum(sea.components(), x[picked], y[picked], t[picked])
    exact_seconds = (time.perf_counter() - start) / chosen.points * x.size
    mesh = Mesh(x, y, t, picked, np.vstack((state.elevation, state.slopes.T, state.velocity.T)))
    print(f"{x.size} points, {THREADS} cores; the sea expects of its default {plane.field.error}", flush=True)

    methods = list(spline_methods(plane, mesh))
    methods.append(Method("exact", "float64, extrapolated", exact_seconds, (0.0, 0.0, 0.0)))
    print_table(methods)


if __name__ == "__main__":
    main()
