"""Gaps in heights are filled by the surface that is bent least: planes go on exactly, waves by closed forms of the
gap's width, and no gap errs by more than is stated of it."""

from __future__ import annotations

import numpy as np
import pytest

from seamap_rt.io.sea_grid import fill_error, fill_gaps, half_width, largest_square, unseen_edges

Y, X = np.mgrid[:80, :80].astype(float) - 40.0


def disc(radius: float) -> np.ndarray:
    return np.hypot(X, Y) < radius


def strip(radius: float) -> np.ndarray:
    return (np.abs(X) < radius) & (np.abs(Y) < 35.0)


def through(values: np.ndarray, gap: np.ndarray) -> np.ndarray:
    return fill_gaps(np.where(gap, np.nan, values), gap)


def test_a_plane_goes_on_across_any_gap_and_over_an_edge() -> None:
    """A plane is not bent at all; nor is it where the gap reaches the grid's edge. What is known stays as it is."""
    plane = 0.3 * X - 0.7 * Y + 2.0
    for gap in (disc(9.0), strip(4.0), X > 30.0, disc(5.0) | (Y < -36.0)):
        made = through(plane, gap)
        np.testing.assert_allclose(made, plane, atol=1e-7)
        np.testing.assert_array_equal(made[~gap], plane[~gap])


@pytest.mark.parametrize("wavenumber", [0.05, 0.1, 0.2])
@pytest.mark.parametrize("radius", [3.0, 5.0, 8.0])
def test_a_wave_across_a_strip_errs_as_stated_and_across_a_disc_by_less(radius: float, wavenumber: float) -> None:
    """|cos kd + ½ kd sin kd − 1| at the middle of a strip. Its half-width is known to a quarter of a point or so: to
    the fourth power a tenth at 8 points, a third at 3."""
    wave = np.cos(wavenumber * X)
    gap = strip(radius)
    stated = float(fill_error(wavenumber, half_width(gap)))
    error = np.abs(through(wave, gap) - wave)
    assert error[40, 40] == pytest.approx(stated, rel=1.0 / radius)
    for angle in np.radians([0.0, 30.0, 45.0, 80.0]):
        for phase in (0.0, 0.5 * np.pi):
            turned = np.cos(wavenumber * (X * np.cos(angle) + Y * np.sin(angle)) + phase)
            round_gap = disc(radius)
            assert np.abs(through(turned, round_gap) - turned).max() < float(
                fill_error(wavenumber, half_width(round_gap))
            )


def test_the_stated_error_is_a_24th_of_the_fourth_power() -> None:
    np.testing.assert_allclose(fill_error([0.01, 0.02], 10.0), np.array([0.1, 0.2]) ** 4 / 24.0, rtol=0.02)


def test_half_a_width_is_counted_to_the_known_water() -> None:
    gap = np.zeros((20, 30), dtype=bool)
    assert half_width(gap) == 0.0
    gap[10, 10] = True
    assert half_width(gap) == 1.5
    gap[8:13, 5:25] = True  # five rows: the middle one lies 3 points from known ones
    assert half_width(gap) == 3.5
    assert half_width(np.ones((4, 4), dtype=bool)) == np.inf


def test_what_is_missing_at_the_edges_is_told_from_holes() -> None:
    gap = disc(5.0) | (X > 30.0)
    np.testing.assert_array_equal(unseen_edges(gap), X > 30.0)


def test_the_largest_square_is_found_nearest_to_a_middle() -> None:
    """Beside a strip on the right of 9 columns a square of 71 fits; above or below it is free to lie: by the middle."""
    free = ~(X > 30.0)
    assert largest_square(free, (0.0, 0.0)) == ((0, 0), 71)
    assert largest_square(free, (79.0, 0.0)) == ((9, 0), 71)
    cut = free & ~((Y < -30.0) & (X < 0.0))  # a corner besides
    (row, column), side = largest_square(cut, (40.0, 40.0))
    assert side == 70
    assert cut[row : row + side, column : column + side].all()
    assert largest_square(np.zeros((5, 5), dtype=bool), (2.0, 2.0)) == ((0, 0), 0)
