"""The triangle of the interferometer: round trips against 50 digits, and where there is no triangle."""

from __future__ import annotations

import mpmath
import numpy as np
import pytest

from validation.analytic import ground_position_from_range_difference, height_from_range_difference, range_difference

EPS = np.finfo(np.float64).eps


def exact_ranges(*numbers: float):
    """R1 and ΔR by Pythagoras, in mpmath's working precision, from x, z, B, H, tilt."""
    x, z, b, h, tilt = (mpmath.mpf(float(each)) for each in numbers)
    lower = mpmath.sqrt(x**2 + (h - z) ** 2)
    upper = mpmath.sqrt((x - b * mpmath.sin(tilt)) ** 2 + (h + b * mpmath.cos(tilt) - z) ** 2)
    return lower, upper - lower


@pytest.mark.parametrize("tilt", [0.0, 0.2, -0.2])
def test_round_trip_against_50_digits(tilt: float) -> None:
    rng = np.random.default_rng(8)
    with mpmath.workdps(50):
        for _ in range(300):
            x, b = np.exp(rng.uniform(np.log(10.0), np.log(3000.0))), np.exp(rng.uniform(np.log(1e-3), np.log(3.0)))
            z, h = rng.normal(0.0, 1.0), rng.uniform(6.0, 30.0)
            lower, delta = exact_ranges(x, z, b, h, tilt)
            found = range_difference(x, z, b, h, tilt)
            np.testing.assert_allclose(found, float(delta), rtol=0, atol=4 * EPS * b)  # a few ulp of the baseline
            # ΔR in one float64 costs R·eps, rounding R1 and the formula as much again
            for d in (float(delta), found):
                heights = height_from_range_difference(float(lower), d, b, h, tilt)
                np.testing.assert_allclose(heights, z, rtol=0, atol=30 * EPS * float(lower))
                assert abs(heights - z) < 1e-6
            across, _ = ground_position_from_range_difference(float(lower), float(delta), b, h, tilt)
            # the ground range of a point nearly below the antenna is ill-conditioned by R/x
            np.testing.assert_allclose(across, x, rtol=0, atol=30 * EPS * float(lower) ** 2 / x)


def test_ranges_subtracted_in_float64_still_give_a_micrometre_at_a_millimetre() -> None:
    with mpmath.workdps(50):
        for b, limit in ((1e-3, 3e-6), (1.0, 3e-9)):
            lower, delta = exact_ranges(3000.0, 0.4, b, 5.0, 0.0)
            upper = float(lower + delta)
            height = height_from_range_difference(float(lower), upper - float(lower), b, 5.0)
            # ulp(3000 m) = 4.5e-13 m, times R/B = 3e6 at 1 mm and 3e3 at 1 m, and half of it for each range
            np.testing.assert_allclose(height, 0.4, rtol=0, atol=limit)


def test_height_slope_of_the_range_difference() -> None:
    # at fixed range and α = 0: |dz/dΔR| = R/B (to first order in B/R)
    step = 1e-6
    z = height_from_range_difference(200.0, np.array([0.01 - step, 0.01 + step]), 0.2, 5.0)
    np.testing.assert_allclose((z[0] - z[1]) / (2.0 * step), 200.0 / 0.2, rtol=1e-3)


def test_straight_down_straight_up_and_along_the_horizon() -> None:
    np.testing.assert_allclose(range_difference(0.0, 0.0, 0.2, 5.0), 0.2, rtol=1e-15)
    np.testing.assert_allclose(height_from_range_difference(10.0, [0.2, -0.2], 0.2, 5.0), [-5.0, 15.0], rtol=1e-14)
    level = np.hypot(50.0, 0.2) - 50.0  # a point level with the lower antenna
    np.testing.assert_allclose(height_from_range_difference(50.0, level, 0.2, 5.0), 5.0, atol=1e-11)


def test_tilt_turns_the_picture_about_the_lower_antenna() -> None:
    across, up = ground_position_from_range_difference(80.0, 0.03, 0.2, 0.0, 0.0)
    tilted_across, tilted_up = ground_position_from_range_difference(80.0, 0.03, 0.2, 0.0, 0.3)
    turned = (across - 1j * up) * np.exp(-1j * -0.3)  # top towards the look: everything sinks by α
    np.testing.assert_allclose([tilted_across, tilted_up], [turned.real, -turned.imag], rtol=1e-13)


def test_no_triangle_no_height() -> None:
    r = np.array([10.0, 10.0, 10.0, -1.0, 0.0, 1.0, 10.0, np.nan])
    d = np.array([0.1, 0.3, -0.3, 0.1, 0.1, -2.0, np.nan, 0.1])
    b = np.array([0.0, 0.2, 0.2, 0.2, 0.2, 3.0, 0.2, 0.2])
    assert np.all(np.isnan(height_from_range_difference(r, d, b, 5.0)))
    assert np.isnan(height_from_range_difference(10.0, 0.0, 0.0, 5.0))
    assert range_difference(50.0, 0.0, 0.0, 5.0) == 0.0


def test_shapes_broadcast() -> None:
    found = height_from_range_difference(np.full((4, 1), 50.0), np.linspace(-0.1, 0.1, 3), 0.2, 5.0)
    assert found.shape == (4, 3)
    assert np.all(np.isfinite(found))
