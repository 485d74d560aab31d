"""The judge of marine radar images: waves that are planted come out where, and as fast, as they run."""

from __future__ import annotations

import numpy as np
import pytest
from scipy.special import polygamma

from validation.radar.images import Images, Waves, box, fastest, fitted_current, peaks, rings, share, standing

TURNS, PERIOD = 6, 1.4
LENGTH, COMES_FROM = 75.0, 160.0  # m, deg


def images(current: tuple[float, float] = (0.0, 0.0), faster: float = 1.0, drift: tuple[float, float] = (0.0, 0.0)):
    """One deep-water wave on a current, and what stands still, as a drifting radar sees them radial by radial."""
    looks, ranges = np.arange(100.0, 240.0, 0.9), np.arange(180.0, 1250.0, 7.5)
    azimuth = np.tile(looks, TURNS)
    turn = np.repeat(np.arange(TURNS), looks.size)
    time = turn * PERIOD + azimuth / 360.0 * PERIOD
    east, north = (
        ranges * part(np.radians(azimuth))[:, None] + speed * time[:, None]
        for part, speed in zip((np.sin, np.cos), drift, strict=True)
    )
    towards = np.radians(COMES_FROM + 180.0)
    kx, ky = 2.0 * np.pi / LENGTH * np.sin(towards), 2.0 * np.pi / LENGTH * np.cos(towards)
    omega = faster * np.sqrt(9.81 * 2.0 * np.pi / LENGTH) + kx * current[0] + ky * current[1]
    level = np.cos(kx * east + ky * north - omega * time[:, None]) + 0.5 * np.cos(0.1 * east)
    noise = np.random.default_rng(1).normal(size=level.shape)
    return Images(level + 0.2 * noise, azimuth, time, turn, ranges, drift, np.full(100, -9.0))


def boxes(seen: Images) -> list[Waves]:
    return [box(seen, azimuth, 700.0) for azimuth in (150.0, 180.0)]


@pytest.mark.parametrize("drift", [(0.0, 0.0), (-0.8, -1.3)])
def test_a_wave_is_found_where_it_runs(drift: tuple[float, float]) -> None:
    """Half of the energy keeps to the shell (k and −k hold the same); bins of 600 m tell 75 m to a tenth."""
    found = [each.moving for each in boxes(images(drift=drift))]
    assert share(found) == pytest.approx(0.5, abs=0.08)
    assert fastest(found, (0.0, 0.0)) == pytest.approx(1.0, abs=0.05)
    (length, direction), *_ = peaks(found, (0.0, 0.0))
    assert length == pytest.approx(LENGTH, rel=0.1)
    assert direction == pytest.approx(COMES_FROM, abs=6.0)
    assert standing(boxes(images(drift=drift))) > 0.1


def test_a_current_along_the_waves_is_found() -> None:
    """One wave tells the current along it alone."""
    east, north = fitted_current([each.moving for each in boxes(images(current=(0.0, 1.2)))], most=1.8, step=0.6)
    towards = np.radians(COMES_FROM + 180.0)
    along = east * np.sin(towards) + north * np.cos(towards)
    assert along == pytest.approx(1.2 * np.cos(towards), abs=0.3)


def test_what_is_no_deep_water_wave_leaves_the_shell() -> None:
    assert fastest([each.moving for each in boxes(images(faster=1.4))], (0.0, 0.0)) == pytest.approx(1.4, abs=0.06)


def test_shares_near_the_noise_and_lengths_are_those_that_were_drawn() -> None:
    """A third of the cells hold noise alone; patches are 8 gates long, whose triangle falls to a half at 4."""
    generator = np.random.default_rng(2)
    ranges, looks = np.linspace(200.0, 1392.5, 160), 400
    bright = np.repeat(generator.random((looks, 20)) < 2.0 / 3.0, 8, axis=1)
    noise = generator.normal(size=(looks, 160))
    azimuth = np.linspace(0.0, 119.7, looks)
    level = np.where(bright, 30.0, noise)
    seen = Images(level, azimuth, azimuth, np.zeros(looks, int), ranges, (0.0, 0.0), noise)
    (ring,) = rings(seen, np.array((190.0, 2000.0)))
    assert ring.near_noise == pytest.approx(1.0 / 3.0, abs=0.02)
    assert ring.range_length == pytest.approx(4.0 * 7.5, rel=0.06)


@pytest.mark.parametrize(("length", "looks"), [(1, 5), (3, 1), (6, 5)])
def test_what_smoothing_leaves_is_what_was_drawn(length: int, looks: int) -> None:
    """Logarithms of `looks` exponentials (skewness ψ″(n)/ψ′(n)^1.5), running means of `length` gates: correlation
    is a triangle; smoothing over 7 radials × 5 gates leaves of variance and skewness what the sum's weights say."""
    radials, gates = 3000, 120
    drawn = np.log(np.random.default_rng(3).gamma(looks, size=(radials, gates + length - 1)))
    level = np.lib.stride_tricks.sliding_window_view(drawn, length, axis=1).mean(axis=-1)
    azimuth = np.linspace(0.0, 119.0, radials)
    seen = Images(
        level,
        azimuth,
        azimuth,
        np.zeros(radials, int),
        200.0 + 3.75 * np.arange(gates, dtype=np.float64),
        (0.0, 0.0),
        level,
    )
    (ring,) = rings(seen, np.array((190.0, 2000.0)))
    wanted = [max(0.0, 1.0 - lag / length) for lag in range(1, 5)]
    np.testing.assert_allclose(ring.range_correlation, wanted, atol=0.02)
    weights = np.convolve(np.ones(length) / length, np.ones(5) / 5.0)  # of one radial's drawn numbers
    left = np.sum(weights**2) * length / 7.0
    assert ring.smoothed_share == pytest.approx(left, rel=0.05)
    one = polygamma(2, looks) / polygamma(1, looks) ** 1.5
    wanted_skewness = one * np.sum(weights**3) / np.sum(weights**2) ** 1.5 / np.sqrt(7.0)
    # Some 10⁴ independent means: ± 0.025 of skewness.
    assert ring.smoothed_skewness == pytest.approx(wanted_skewness, abs=0.08)
