"""Optimal interpolation against means that numpy solves for, and against seas drawn from its own covariance."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
import pytest
from numpy.typing import NDArray
from synthetic_seas import Waves, evenly, polar

from seamap_rt.compute import machine
from seamap_rt.interferometry.error_covariance import ErrorCovariance
from seamap_rt.interferometry.optimal import MeasuredHeights, optimal_heights
from seamap_rt.interferometry.sea_covariance import SeaCovariance
from seamap_rt.interferometry.slopes import local_planes

Array = NDArray[np.float64]
RANGES = evenly(30.0, 1.5, 40)
CELL = 3.0, np.radians(1.8)
RMS, FINE = 0.35, 0.25


def table_of(waves: Waves, turned: float = 0.0) -> SeaCovariance:
    """The waves' covariance, turned clockwise by an angle [rad], faded as the retrieval's own."""
    lag = FINE * np.arange(-160, 161)
    east, north = np.meshgrid(lag, lag, indexing="ij")
    dx, dy = east * np.cos(turned) - north * np.sin(turned), east * np.sin(turned) + north * np.cos(turned)
    return SeaCovariance(waves.covariance(dx, dy), FINE)


# Of errors by tilt, roughness and noise, between gates 0, 1, 2 … apart; of speckle's between looks.
ALONG = np.stack((np.array([1.0, -0.24, -0.25]), np.array([1.0, 0.49, 0.05]), np.array([1.0, 0.32, 0.01])))
BESIDE = 0.2
SHARES = 0.3, 0.2, 0.5  # of the errors' variance


def errors_of(std: Array) -> ErrorCovariance:
    return ErrorCovariance(np.sqrt(np.array(SHARES))[:, None, None] * std, ALONG, BESIDE)


def errors_drawn(rng: np.random.Generator, std: Array) -> Array:
    """Errors of that covariance, of each part along the gates, speckle's across the looks as well."""
    looks, gates = std.shape
    total = np.zeros(std.shape)
    for part, (share, along) in enumerate(zip(SHARES, ALONG, strict=True)):
        apart = np.abs(np.subtract.outer(np.arange(gates), np.arange(gates)))
        by_range = np.where(apart < along.size, along[np.minimum(apart, along.size - 1)], 0.0)
        lag = np.abs(np.subtract.outer(np.arange(looks), np.arange(looks)))
        across = np.eye(looks) + (BESIDE * (lag == 1) if part < 2 else 0.0)
        roots = (np.linalg.cholesky(each + 1e-9 * np.eye(len(each))) for each in (across, by_range))
        left, right = roots
        total += np.sqrt(share) * std * (left @ rng.normal(size=std.shape) @ right.T)
    return total


class Case(NamedTuple):
    measured: MeasuredHeights
    sea: SeaCovariance
    mean: Array  # true means over cells


def case(
    seed: int, noise: float, looks: int = 30, turned: float = 0.0, gaps: float = 0.1, ranges: Array = RANGES
) -> Case:
    """Errors of neighbouring gates go together as optimal interpolation has it; each has a variance of its own."""
    rng = np.random.default_rng(seed)
    waves = Waves.drawn(seed, RMS)
    x, y, east, north = polar(ranges, looks)
    std = noise * np.exp(rng.normal(size=x.shape))
    height = waves(x, y) + errors_drawn(rng, std)
    height[rng.random(x.shape) < gaps] = np.nan
    mean = np.zeros(x.shape)
    for u in (-0.75, 0.0, 0.75):  # Gauss's three points of both sides: exact to the fifth order
        for v in (-0.75, 0.0, 0.75):
            along, across = u * np.sqrt(0.6) / 0.75 * 0.5 * CELL[0], v * np.sqrt(0.6) / 0.75 * 0.5 * CELL[1] * ranges
            weight = (8.0 if u == 0.0 else 5.0) * (8.0 if v == 0.0 else 5.0) / 324.0
            mean += weight * waves(x + along * east + across * north, y + along * north - across * east)
    sine, cosine = np.sin(turned), np.cos(turned)

    def turn(a: Array, b: Array) -> tuple[Array, Array]:
        return a * cosine + b * sine, b * cosine - a * sine

    measured = MeasuredHeights(height, errors_of(std), turn(x, y), turn(east, north), np.zeros(ranges.size))
    return Case(measured, table_of(waves, turned), mean)


def everywhere(measured: MeasuredHeights) -> NDArray[np.bool_]:
    return np.ones(measured.height.shape, dtype=bool)


def interpolated(sea: SeaCovariance, dx: Array, dy: Array) -> Array:
    """The table, linear between its entries."""
    middle = sea.table.shape[0] // 2
    east, north = dx / sea.spacing + middle, dy / sea.spacing + middle
    inside = (east >= 0.0) & (north >= 0.0) & (east < 2 * middle) & (north < 2 * middle)
    i, j = (np.clip(each.astype(int), 0, 2 * middle - 1) for each in (east, north))
    u, v = east - i, north - j
    value = (
        sea.table[i, j] * (1 - u) * (1 - v)
        + sea.table[i + 1, j] * u * (1 - v)
        + sea.table[i, j + 1] * (1 - u) * v
        + sea.table[i + 1, j + 1] * u * v
    )
    return np.where(inside, value, 0.0)


def rounding(sea: SeaCovariance) -> float:
    """Of an arc of curvature κ the middle of a chord of length h lies κ h²/8 away, of that of ½ κ h² over h."""
    middle = sea.table.shape[0] // 2
    return 0.25 * float(sea.variance - min(sea.table[middle + 1, middle], sea.table[middle, middle + 1]))


def neighbours(given: Case, look: int, gate: int, most_looks: int) -> tuple[Array, ...]:
    """Of the cell's block of three gates: y, x and y [m], C + R and R."""
    measured, sea = given.measured, given.sea
    rows, gates = measured.height.shape
    start = gate - gate % 3
    n, m = np.meshgrid(
        np.arange(max(0, look - most_looks), min(rows, look + most_looks + 1)),
        np.arange(max(0, start - 3), min(gates, min(gates, start + 3) + 3)),
        indexing="ij",
    )
    variance = measured.errors.variance
    with np.errstate(invalid="ignore"):
        good = np.isfinite(measured.height[n, m]) & (variance[n, m] < 6.0 * sea.variance)
    n, m = n[good], m[good]
    x, y = (each[n, m] for each in measured.ground)
    errors = rounding(sea) * np.eye(n.size)
    lag, beside = np.abs(m[:, None] - m), np.abs(n[:, None] - n)
    for part, (along, std) in enumerate(zip(ALONG, measured.errors.parts, strict=True)):
        alike = np.where(lag < along.size, along[np.minimum(lag, along.size - 1)], 0.0)
        alike *= (beside == 0) + (BESIDE * (beside == 1) if part < 2 else 0.0)
        errors += alike * std[n, m][:, None] * std[n, m]
    return measured.height[n, m], x, y, interpolated(sea, x[:, None] - x, y[:, None] - y) + errors, errors


def dense(given: Case, look: int, gate: int, most_looks: int) -> tuple[float, float]:
    """kᵀ(C + R)⁻¹y and k₀ − kᵀ(C + R)⁻¹k of the neighbours."""
    measured, sea = given.measured, given.sea
    heights, x, y, matrix, _ = neighbours(given, look, gate, most_looks)
    east, north = (np.broadcast_to(each, measured.height.shape)[look, gate] for each in measured.outward)
    along, across = 0.5 * CELL[0] / np.sqrt(3.0), 0.5 * CELL[1] * RANGES[gate] / np.sqrt(3.0)
    points = [
        (
            measured.ground[0][look, gate] + u * along * east + v * across * north,
            measured.ground[1][look, gate] + u * along * north - v * across * east,
        )
        for u in (-1, 1)
        for v in (-1, 1)
    ]
    px, py = (np.array(each) for each in zip(*points, strict=True))
    towards = interpolated(sea, x - px[:, None], y - py[:, None]).mean(axis=0)
    prior = interpolated(sea, px[:, None] - px, py[:, None] - py).mean()
    solved = np.linalg.solve(matrix, np.stack((heights, towards), axis=1))
    return float(towards @ solved[:, 0]), float(prior - towards @ solved[:, 1])


def test_it_is_what_numpy_solves() -> None:
    given = case(1, 0.2)
    given.measured.errors.parts[:, 5, 8:12] = 10.0  # worthless
    height, variance, _ = optimal_heights(given.measured, given.sea, everywhere(given.measured), CELL, RANGES)
    # Looks of 1.8° lie 0.94 m apart at 30 m, 2.8 m at 88 m: of 6.5 m three to either side are taken there, two here.
    looks = np.clip(np.round(6.5 / (CELL[1] * RANGES)), 1, 3).astype(int)
    assert set(looks) == {2, 3}
    for look in (0, 1, 6, 17, 28, 29):
        for gate in (0, 1, 2, 7, 10, 20, 37, 38, 39):
            asked = dense(given, look, gate, looks[gate - gate % 3])
            assert (height[look, gate], variance[look, gate]) == pytest.approx(asked, rel=1e-9, abs=1e-11)


def edges(given: Case, look: int, gate: int, parts: Array) -> list[tuple[Array, Array, Array]]:
    """x, y and weights of points whose weighted heights are a cell's mean slopes outward and clockwise: its edges, at
    parts of them from −½ to ½."""
    east, north = (np.broadcast_to(each, given.measured.height.shape)[look, gate] for each in given.measured.outward)
    sides = CELL[0], CELL[1] * RANGES[gate]
    made = []
    for axis in (0, 1):
        end, part = (each.ravel() for each in np.meshgrid([-0.5, 0.5], parts, indexing="ij"))
        u, v = (sides[0] * end, sides[1] * part) if axis == 0 else (sides[0] * part, sides[1] * end)
        x, y = (each[look, gate] for each in given.measured.ground)
        made.append((x + u * east + v * north, y + u * north - v * east, 2.0 * end / (parts.size * sides[axis])))
    return made


def test_errors_of_slopes_are_what_numpy_solves() -> None:
    # Stated errors twice as large as they are: no innovation is larger than expected. The last look is worked out
    # first, in its block's middle; the other gates of its block share what it has.
    given = case(1, 0.2, gaps=0.0)
    given.measured.errors.parts[:] *= 2.0
    found = optimal_heights(given.measured, given.sea, everywhere(given.measured), CELL, RANGES)[2]
    for gate in (1, 10, 37):
        _, x, y, matrix, _ = neighbours(given, 29, gate, 3 if gate < 30 else 2)
        towards = [
            weight @ interpolated(given.sea, x - px[:, None], y - py[:, None])
            for px, py, weight in edges(given, 29, gate, np.array([-0.5, 0.5]) / np.sqrt(3.0))
        ]
        # The kernel takes the breadth of its block's first gate.
        sides = edges(given, 29, gate, (np.arange(4) + 0.5) / 4 - 0.5)
        for n, (one, other) in enumerate(((0, 0), (1, 1), (0, 1))):
            (px, py, pw), (qx, qy, qw) = sides[one], sides[other]
            prior = pw @ interpolated(given.sea, px[:, None] - qx, py[:, None] - qy) @ qw
            asked = prior - towards[one] @ np.linalg.solve(matrix, towards[other])
            assert found[n, 29, gate] == pytest.approx(asked, rel=0.05, abs=2e-3 * float(prior) if n < 2 else 1e-5)
            assert (found[n, 29, gate - 1 : gate + 2] == found[n, 29, gate]).all()


def slope_errors(seed: int, noise: float, stated: float = 1.0) -> Array:
    """Squared errors (2, look, gate) of planes through a sea's interpolated heights, over what is stated of them."""
    given = case(seed, noise)
    given.measured.errors.parts[:] *= stated
    height, _, of_slopes = optimal_heights(given.measured, given.sea, everywhere(given.measured), CELL, RANGES)
    found = local_planes(height, np.ones(height.shape), given.measured.ground, given.measured.outward, (2.0, 2.0))
    waves, (x, y), (east, north) = Waves.drawn(seed, RMS), given.measured.ground, given.measured.outward
    ratio = []
    for axis, slope in enumerate((found.outward, found.clockwise)):
        side = CELL[0] if axis == 0 else CELL[1] * RANGES
        u, v = (0.5 * side, 0.0) if axis == 0 else (0.0, 0.5 * side)
        rise = [waves(x + s * (u * east + v * north), y + s * (u * north - v * east)) for s in (1.0, -1.0)]
        ratio.append((slope - (rise[0] - rise[1]) / side) ** 2 / of_slopes[axis])
    return np.array(ratio)


@pytest.mark.parametrize("noise", [0.1, 0.3, 0.6])
def test_slopes_err_as_much_as_it_says(noise: float) -> None:
    # Eight seas of 1200 cells, of which one in some dozens is independent: 9600/30 know a mean square to 8 %. Planes
    # are less than optimal by a few per cent.
    ratio = np.mean([slope_errors(seed, noise) for seed in range(30, 38)], axis=(0, 2, 3))
    assert ((ratio > 0.85) & (ratio < 1.2)).all()


def test_innovations_tell_of_errors_that_are_not_stated() -> None:
    # Stated at half of their size, errors leave four times the variance that is said; what the innovations add brings
    # most of it back. Stated at twice of it they are as stated: a map is not trusted more than its echoes.
    low, true, high = (np.mean([slope_errors(seed, 0.3, s) for seed in range(30, 34)]) for s in (0.5, 1.0, 2.0))
    assert low < 1.5 * true
    assert high < 0.6 * true


def test_without_errors_what_is_measured_comes_back() -> None:
    # Of cells that are points; the table's straight lines are reckoned with as an error.
    given = case(2, 0.0, gaps=0.0)
    height, variance, _ = optimal_heights(given.measured, given.sea, everywhere(given.measured), (1e-6, 1e-9), RANGES)
    assert np.sqrt(np.mean((height - given.measured.height) ** 2)) < 0.02 * RMS
    assert (variance < rounding(given.sea) + 1e-3 * RMS**2).all()
    # And of cells as they are, their means.
    height, _, _ = optimal_heights(given.measured, given.sea, everywhere(given.measured), CELL, RANGES)
    assert np.sqrt(np.mean((height - given.mean) ** 2)) < 0.03 * RMS


@pytest.mark.parametrize("silent", [False, True])
def test_without_a_word_it_is_mean_sea_level(silent: bool) -> None:
    given = case(3, 0.1)
    measured = given.measured
    if silent:
        measured.height[:] = np.nan
    else:
        measured.errors.parts[:] = np.sqrt(6.1 * given.sea.variance / 3.0)
    height, variance, _ = optimal_heights(measured, given.sea, everywhere(measured), CELL, RANGES)
    np.testing.assert_array_equal(height, 0.0)
    # That of the cell's mean, a little below the sea's own.
    assert (variance <= (1.0 + 1e-9) * given.sea.variance).all()
    assert (variance > 0.9 * given.sea.variance).all()
    narrow = optimal_heights(measured, given.sea, everywhere(measured), (1e-6, 1e-9), RANGES)[1]
    np.testing.assert_allclose(narrow, given.sea.variance, rtol=1e-6)


@pytest.mark.parametrize("noise", [0.05, 0.2, 0.6])
def test_errors_are_as_large_as_it_says(noise: float) -> None:
    # Eight seas of 1200 cells, of which one in some dozens is independent: 9600/30 know a mean square to 8 %.
    ratio, size = [], []
    for seed in range(10, 18):
        given = case(seed, noise)
        height, variance, _ = optimal_heights(given.measured, given.sea, everywhere(given.measured), CELL, RANGES)
        off = height - given.mean
        ratio.append(np.mean(off**2 / variance))
        size.append(np.mean(off) / np.sqrt(np.mean(off**2)))
    # Beside errors of a seventh of the sea's height, the 0.1 % that is reckoned with for rounding shows.
    assert (0.7 if noise < 0.1 else 0.88) < np.mean(ratio) < 1.12
    # A weighted mean of errors without a mean has none: eight times 1200 cells.
    assert abs(np.mean(size)) < 4.0 * np.std(size) / np.sqrt(7.0)


def test_it_is_better_than_what_was_measured() -> None:
    given = case(20, 0.3)
    height, _, _ = optimal_heights(given.measured, given.sea, everywhere(given.measured), CELL, RANGES)
    known = np.isfinite(given.measured.height)
    raw = np.sqrt(np.mean((given.measured.height - given.mean)[known] ** 2))
    assert np.sqrt(np.mean((height - given.mean) ** 2)) < 0.25 * raw


def test_only_what_is_wanted_is_given() -> None:
    given = case(4, 0.1)
    wanted = np.random.default_rng(5).random(given.measured.height.shape) < 0.4
    whole = optimal_heights(given.measured, given.sea, everywhere(given.measured), CELL, RANGES)
    some = optimal_heights(given.measured, given.sea, wanted, CELL, RANGES)
    for got, asked in zip(some[:2], whole[:2], strict=True):
        np.testing.assert_array_equal(got, np.where(wanted, asked, np.nan))
    np.testing.assert_array_equal(np.isfinite(some[2]), np.broadcast_to(wanted, some[2].shape))
    # Nor is there any where a place is not known; gaps in the heights are filled.
    given.measured.ground[0][3, 4] = np.nan
    height, variance, _ = optimal_heights(given.measured, given.sea, everywhere(given.measured), CELL, RANGES)
    lost = np.zeros(height.shape, dtype=bool)
    lost[3, 4] = True
    np.testing.assert_array_equal(np.isnan(height), lost)
    np.testing.assert_array_equal(np.isnan(variance), lost)


def test_parts_and_threads_change_no_bit(monkeypatch: pytest.MonkeyPatch) -> None:
    given = case(6, 0.2)
    found = []
    for tasks, threads in ((8, 2), (1, 1), (3, 3), (30, 2), (32, 16)):
        monkeypatch.setattr(machine, "threads", lambda number=threads: number)
        found.append(optimal_heights(given.measured, given.sea, everywhere(given.measured), CELL, RANGES, tasks))
    for other in found[1:]:
        for got, asked in zip(other, found[0], strict=True):
            np.testing.assert_array_equal(got, asked)


@pytest.mark.parametrize("turned", [90.0, 33.0])
def test_a_turned_scene_has_the_same_heights(turned: float) -> None:
    found = []
    for angle in (0.0, np.radians(turned)):
        given = case(7, 0.2, turned=angle)
        found.append(optimal_heights(given.measured, given.sea, everywhere(given.measured), CELL, RANGES))
    # A quarter turn leaves the table's grid as it is. At any other angle its straight lines lie elsewhere: they are off
    # by ⅛ (0.25 · 0.35)² = 0.1 % of the variance of the shortest waves, as much as the error that stands in for it.
    bound = 1e-9 if turned == 90.0 else 0.02 * RMS
    np.testing.assert_allclose(found[1][0], found[0][0], rtol=0, atol=bound)
    np.testing.assert_allclose(found[1][1], found[0][1], rtol=0, atol=bound * RMS)


def test_a_flat_sea_and_a_single_gate() -> None:
    given = case(8, 0.1)
    flat = SeaCovariance(np.zeros((3, 3)), 0.5)
    height, variance, _ = optimal_heights(given.measured, flat, everywhere(given.measured), CELL, RANGES)
    np.testing.assert_array_equal(height, 0.0)
    np.testing.assert_array_equal(variance, 0.0)
    one = case(9, 0.1, ranges=RANGES[:1])
    height, variance, _ = optimal_heights(one.measured, one.sea, everywhere(one.measured), CELL, RANGES[:1])
    assert np.isfinite(height).all()
    assert (variance < one.sea.variance).all()
