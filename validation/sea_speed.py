"""Time and error of the sea's fast evaluation, for the choices that it rests on.

    python validation/sea_speed.py [--points 40] [--orders 3 5] [--oversampling 1.25 1.5 2] [--steps 3 4 6]

A turn of the default scene (JONSWAP, Hs 1.4 m, Tp 5.5 s, 0.8 m, 1024 m) on a polar mesh of about 640,000 points. `cold`
is the first turn of a sea, `warm` a turn after it, which shares knots with the one before. Errors are rms against the
exact sum of waves at points drawn from the mesh; `said` is what the sea expects its elevation's error to be.
"""

from __future__ import annotations

import argparse
import resource
import time

import numpy as np

from seamap_rt.sea import direct_sum, realize
from seamap_rt.sea.moving_field import MovingField
from seamap_rt.sea.parts import PlanePart
from seamap_rt.sea.surface import OVERSAMPLING, SPLINE_ORDER, Sea
from seamap_rt.settings import JonswapWaves, SeaSettings


def polar_mesh() -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """x, y, t of one turn at 60 rpm: a column each 0.45°, three beams beyond both ends, a rung each 0.5 m."""
    sweep = 0.45 * np.arange(-12, 813)
    ground_range = np.linspace(15.0, 400.0, 771)
    x = np.sin(np.radians(sweep))[:, None] * ground_range
    y = np.cos(np.radians(sweep))[:, None] * ground_range
    return x, y, np.broadcast_to((sweep / 360.0)[:, None], x.shape)


def main() -> None:
    options = argparse.ArgumentParser(description=__doc__.splitlines()[0] if __doc__ else None)
    options.add_argument("--points", type=int, default=40, help="points held against the exact sum (0.1 s each)")
    options.add_argument("--orders", type=int, nargs="+", default=[3, 5])
    options.add_argument("--oversampling", type=float, nargs="+", default=[1.25, 1.5, 2.0])
    options.add_argument("--steps", type=int, nargs="+", default=[3, 4, 6], help="knots a second")
    chosen = options.parse_args()

    waves = JonswapWaves(spectrum="jonswap", significant_wave_height_m=1.4, peak_period_s=5.5)
    start = time.perf_counter()
    sea = realize(SeaSettings(waves=(waves,)), seed=1)
    print(f"realize: {time.perf_counter() - start:.2f} s; its own choice: {sea.resolved}")
    (plane,) = (part for part in sea.parts if isinstance(part, PlanePart))

    x, y, t = polar_mesh()
    picked = np.random.default_rng(1).choice(x.size, chosen.points, replace=False)
    points = [np.ravel(value)[picked] for value in (x, y, t)]
    exact = direct_sum(sea.components(), *points)

    print("order  oversampling  knots/s   cold    warm   elevation  (said)   east    north     up     slope")
    print("                                s       s        mm        mm     cm/s    cm/s    cm/s    1e-3")
    for order in chosen.orders:
        for oversampling in chosen.oversampling:
            for steps in chosen.steps:
                field = MovingField(
                    plane.lattice,
                    plane.amplitude,
                    plane.variance,
                    order=order,
                    oversampling=oversampling,
                    time_step=1.0 / steps,
                )
                tried = Sea([PlanePart(plane.lattice, plane.variance, plane.amplitude, field)], sea.resolved)
                taken = []
                for turn in range(3):
                    start = time.perf_counter()
                    tried.elevation_and_velocity(x, y, t + turn)
                    taken.append(time.perf_counter() - start)
                elevation, velocity = tried.elevation_and_velocity(*points)
                height = 1e3 * np.sqrt(np.mean((elevation - exact.elevation) ** 2))
                speed = 1e2 * np.sqrt(np.mean((velocity - exact.velocity) ** 2, axis=0))
                slope = 1e3 * np.sqrt(np.mean((tried.slopes(*points) - exact.slopes) ** 2))
                default = (order, oversampling, 1.0 / steps) == (SPLINE_ORDER, OVERSAMPLING, plane.field.time_step)
                print(
                    f"{order:5d}  {oversampling:12.2f}  {steps:7d}  {taken[0]:6.2f}  {min(taken[1:]):6.2f}  "
                    f"{height:9.3f}  {1e3 * field.error.elevation:7.3f}  {speed[0]:6.3f}  {speed[1]:6.3f}  "
                    f"{speed[2]:6.3f}  {slope:7.2f}{' <- default' if default else ''}",
                    flush=True,
                )
    print(f"peak memory {resource.getrusage(resource.RUSAGE_SELF).ru_maxrss / 1e3:.0f} MB, the exact sum's included")


if __name__ == "__main__":
    main()
