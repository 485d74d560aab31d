"""Local planes: a plane comes back exactly, wherever its cells lie; what is in sight leans towards the radar."""

from __future__ import annotations

import numpy as np
import pytest
from numpy.typing import NDArray

from seamap_rt.conventions import unit_from_azimuth
from seamap_rt.interferometry.slopes import local_planes, plane_reach, visible_slopes

EAST, NORTH = 0.08, -0.05  # slopes of the plane


def fan(first: float, looks: int = 11, gates: int = 16, jitter: float = 0.3) -> tuple[NDArray[np.float64], ...]:
    """Weights, x, y, and east and north of the looks' directions; 1.8° apart, cells unevenly 1.5 m apart."""
    rng = np.random.default_rng(3)
    ground_range = first + 1.5 * np.arange(gates) + rng.uniform(-jitter, jitter, (looks, gates))
    east, north = (part[:, None] for part in unit_from_azimuth(200.0 + 1.8 * np.arange(looks)))
    return rng.uniform(0.2, 3.0, (looks, gates)), ground_range * east, ground_range * north, east, north


@pytest.mark.parametrize("first", [12.0, 100.0, 3000.0])
@pytest.mark.parametrize("reach", [(2.0, 2.0), (3.5, 2.0), (9.3, 4.7)])
def test_a_plane_comes_back(first: float, reach: tuple[float, float]) -> None:
    # An ulp of 3 km is 5e-13 m, of planes 3 m long. Along straight looks beside each other it would be off by
    # 3000 (1 − cos 1.8°) = 1.5 m of range: 0.08 of the slope across, in planes of one look and gate to either side.
    weight, x, y, east, north = fan(first)
    height = 0.4 + EAST * x + NORTH * y
    height[3, 4:7] = height[8, :2] = np.nan
    found = local_planes(height, weight, (x, y), (east, north), (np.full(16, reach[0]), reach[1]))
    known = np.isfinite(height)
    for got, asked in ((found.outward, EAST * east + NORTH * north), (found.clockwise, EAST * north - NORTH * east)):
        np.testing.assert_allclose(got[known], np.broadcast_to(asked, known.shape)[known], rtol=0, atol=1e-9)
        assert np.isnan(got[~known]).all()


def test_a_plane_seen_from_a_boat_that_moves() -> None:
    # Cells and directions of any kind.
    rng = np.random.default_rng(4)
    weight, x, y, _, _ = fan(60.0)
    x, y = x + rng.uniform(-0.4, 0.4, x.shape), y + 0.3 * np.arange(11)[:, None]
    east, north = unit_from_azimuth(200.0 + rng.uniform(-20.0, 20.0, x.shape))
    found = local_planes(EAST * x + NORTH * y, weight, (x, y), (east, north), (np.full(16, 4.0), np.full(16, 2.0)))
    np.testing.assert_allclose(found.outward, EAST * east + NORTH * north, rtol=0, atol=1e-9)
    np.testing.assert_allclose(found.clockwise, EAST * north - NORTH * east, rtol=0, atol=1e-9)


def test_it_is_the_weighted_least_squares_fit() -> None:
    # Against numpy's own; the reach is another at every gate. Normal equations lose half of the digits at most.
    rng = np.random.default_rng(5)
    weight, x, y, east, north = fan(40.0)
    height = rng.normal(size=x.shape)
    gates, looks = np.linspace(2.2, 6.0, 16), np.linspace(4.0, 2.0, 16)
    found = local_planes(height, weight, (x, y), (east, north), (gates, looks))
    look, gate = np.indices(x.shape)
    for i, j in ((0, 0), (5, 8), (10, 3), (4, 15)):
        along, across = (gate - j) / gates[j], (look - i) / looks[j]
        root = np.sqrt(weight * np.maximum(1.0 - along**2, 0.0) * np.maximum(1.0 - across**2, 0.0)).ravel()
        dx, dy = (x - x[i, j]).ravel(), (y - y[i, j]).ravel()
        e, n = east[i, 0], north[i, 0]
        design = np.stack((np.ones_like(dx), dx * e + dy * n, dx * n - dy * e), axis=1)
        asked = np.linalg.lstsq(design * root[:, None], height.ravel() * root, rcond=None)[0]
        assert (found.outward[i, j], found.clockwise[i, j]) == pytest.approx(tuple(asked[1:]), rel=1e-8)


def test_no_slope_where_no_plane_is_spanned() -> None:
    weight, x, y, east, north = fan(40.0, jitter=0.0)
    whole = EAST * x + NORTH * y
    for part in ((4, 5), (slice(4, 5), slice(None)), (slice(None), slice(5, 6)), (slice(0, 0), slice(None))):
        height = np.full_like(whole, np.nan)
        height[part] = whole[part]  # a cell, a look, a gate (an arc: its bend spans no plane), nothing
        found = local_planes(height, weight, (x, y), (east, north), (4.0, 3.0))
        for got in (found.outward, found.clockwise):
            assert np.isnan(got).all()
    silent = local_planes(whole, np.where(np.indices(x.shape)[1] > 3, weight, 0.0), (x, y), (east, north), (4.0, 3.0))
    assert np.isnan(silent.outward[:, :4]).all()
    assert np.isfinite(silent.outward[:, 4:]).all()


def test_the_ends_of_a_circle_are_no_neighbours() -> None:
    east, north = (part[:, None] for part in unit_from_azimuth(3.6 * np.arange(100)))
    ground_range = 30.0 + 1.5 * np.arange(6)
    height = np.zeros((100, 6))
    height[0] = 1.0
    found = local_planes(
        height, np.ones_like(height), (ground_range * east, ground_range * north), (east, north), (3, 2)
    )
    assert (np.abs(found.clockwise[:2]) > 0.1).all()
    np.testing.assert_allclose(found.clockwise[2:], 0.0, rtol=0, atol=1e-12)


@pytest.mark.parametrize(("mean", "std", "tangent"), [(0.0, 0.05, 0.02), (-0.06, 0.04, 0.03), (0.08, 0.05, 0.3)])
@pytest.mark.parametrize("share", [1.0, 0.6])
def test_what_is_in_sight_leans_away_by_less_than_the_ray(
    mean: float, std: float, tangent: float, share: float
) -> None:
    # 400,000 draws of the slope, those kept that the ray reaches: at worst one in five, of 0.35 % of a deviation.
    drawn = np.random.default_rng(8).normal(mean, std, 400_000)
    seen = drawn[drawn > -tangent]
    one = np.ones((1, 1))
    slope, left = visible_slopes(mean * one, std * one, tangent * one, share * one)
    assert slope[0, 0] == pytest.approx(share * seen.mean() + (1.0 - share) * mean, abs=0.015 * std)
    assert left[0, 0] ** 2 == pytest.approx(share * seen.var() + (1.0 - share) * std**2, rel=0.02)


def test_a_slope_of_which_nothing_is_known_stays_unknown() -> None:
    slope, std = np.array([[0.1, np.nan, 0.1, 0.1]]), np.array([[np.nan, 0.1, 0.0, 0.1]])
    found, left = visible_slopes(slope, std, np.full((1, 4), 0.05), np.array([[1.0, 1.0, 1.0, np.nan]]))
    assert np.isnan(left[0, [0, 3]]).all()
    np.testing.assert_array_equal(found, slope)
    assert left[0, 2] == 0.0


def test_planes_are_as_small_as_the_heights_errors_let_them_be() -> None:
    ranges = np.array((30.0, 100.0, 200.0, 300.0))
    std = np.tile((0.0, 0.15, 0.25, 9.0), (7, 1))
    std[:3, 3] = np.nan
    gates, looks = plane_reach(std, ranges, 1.5, 1.8)
    np.testing.assert_allclose(gates * 1.5, (3.0, 10.0, 0.25 / 0.015, 21.0))
    np.testing.assert_allclose(looks, (2.0, 7.5 / np.pi * 0.02 / (0.27 * 0.075), 2.0, 6.0), rtol=1e-6)
    # Of a sea twice as steep planes are half as long.
    np.testing.assert_allclose(plane_reach(std, ranges, 1.5, 1.8, 0.15)[0][1:3] * 1.5, (5.0, 0.25 / 0.03))
    # Gates further apart than the planes are long still have a neighbour on either side.
    assert (plane_reach(std, ranges, 10.0, 1.8)[0] >= 2.0).all()
    assert np.isfinite(plane_reach(np.full((7, 4), np.nan), ranges, 1.5, 1.8)).all()
