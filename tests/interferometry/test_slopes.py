"""Local planes: a plane comes back exactly, wherever its cells lie; their errors are what noise makes of them."""

from __future__ import annotations

import numpy as np
import pytest
from numpy.typing import NDArray

from seamap_rt.conventions import unit_from_azimuth
from seamap_rt.interferometry.estimation.slopes import local_planes, plane_reach

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
        found = local_planes(height, weight, (x, y), (east, north), (4.0, 3.0), height_std=np.ones_like(x))
        assert found.outward_std is not None
        for got in (found.outward, found.clockwise, found.outward_std):
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


def test_errors_of_heights_that_err_each_for_itself() -> None:
    # A slope is a sum of heights, so that its variance is exact, whatever their weights and own errors. 4000 draws
    # leave √(1/8000) = 1.1 % of a standard deviation; the largest of 352 lies within 4.5 of those.
    rng = np.random.default_rng(6)
    weight, x, y, east, north = fan(40.0)
    std = rng.uniform(0.05, 0.4, x.shape)
    arrays = weight, (x, y), (east, north), (4.0, 2.5)
    found = local_planes(np.zeros_like(x), *arrays, height_std=std)
    draws = [local_planes(std * rng.normal(size=x.shape), *arrays) for _ in range(4000)]
    for name in ("outward", "clockwise"):
        seen = np.std([getattr(draw, name) for draw in draws], axis=0)
        np.testing.assert_allclose(seen, getattr(found, f"{name}_std"), rtol=0.05)


def test_errors_of_heights_that_err_alike() -> None:
    # Windows of three gates and 1.5 looks, as the retrieval slides them. Where all weigh alike, and the neighbourhood
    # is whole, the growth is exact but for places that fan out: 1 % at 100 m. As many cells as 1500 draws give 2 %.
    rng = np.random.default_rng(7)
    along, across = np.ones(3), np.array((0.25, 1.0, 0.25))
    of_gates, of_looks = (np.correlate(each, each, "full")[2:] / (each @ each) for each in (along, across))
    _, x, y, east, north = fan(100.0, looks=15, gates=24, jitter=0.0)
    one, reach = np.ones_like(x), (5.0, 3.0)
    found = local_planes(0.0 * x, one, (x, y), (east, north), reach, 0.3 * one, (of_gates, of_looks))
    alone = local_planes(0.0 * x, one, (x, y), (east, north), reach, 0.3 * one)
    kernel = np.outer(across, along) / np.sqrt(np.sum(across**2) * np.sum(along**2))
    draws = []
    for _ in range(1500):
        white = 0.3 * rng.normal(size=(17, 26))
        height = sum(kernel[m, n] * white[m : m + 15, n : n + 24] for m in range(3) for n in range(3))
        draws.append(local_planes(np.asarray(height), one, (x, y), (east, north), reach))
    inner = slice(3, -3), slice(5, -5)
    for name in ("outward", "clockwise"):
        seen = np.sqrt(np.mean([getattr(draw, name)[inner] ** 2 for draw in draws]))
        asked = np.sqrt(np.mean(getattr(found, f"{name}_std")[inner] ** 2))
        assert seen == pytest.approx(asked, rel=0.02)
        assert asked > 1.2 * np.sqrt(np.mean(getattr(alone, f"{name}_std")[inner] ** 2))


def test_planes_are_as_small_as_the_heights_errors_let_them_be() -> None:
    ranges = np.array((30.0, 100.0, 200.0, 300.0))
    std = np.tile((0.0, 0.15, 0.25, 9.0), (7, 1))
    std[:3, 3] = np.nan
    gates, looks = plane_reach(std, ranges, 1.5, 1.8)
    np.testing.assert_allclose(gates * 1.5, (4.5, 10.0, 0.25 / 0.015, 21.0))
    np.testing.assert_allclose(looks, (2.0, 7.5 / np.pi, 2.0, 6.0))
    # Gates further apart than the planes are long still have a neighbour on either side.
    assert (plane_reach(std, ranges, 10.0, 1.8)[0] >= 2.0).all()
    assert np.isfinite(plane_reach(np.full((7, 4), np.nan), ranges, 1.5, 1.8)).all()
