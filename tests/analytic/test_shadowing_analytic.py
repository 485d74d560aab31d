"""Shadowing functions against their check values; the sinusoid against a running maximum over a millimetre grid."""

from __future__ import annotations

from typing import Literal

import numpy as np
import pytest
from scipy.special import erfc

from validation.analytic import (
    shadowing_smith67,
    shadowing_wagner67,
    sinusoid_shadowed_fraction,
    sinusoid_visible_intervals,
    visible_share,
)

STEP = 1e-3


def running_maximum(
    height: float, wavelength: float, antenna: float, far: float, phase: float, direction: int
) -> tuple[np.ndarray, np.ndarray]:
    """Ground ranges on a 1 mm grid, and whether each is seen: by brute force."""
    x = np.arange(STEP, far, STEP)
    rise = (0.5 * height * np.cos(2.0 * np.pi / wavelength * direction * x + phase) - antenna) / x
    return x, rise >= np.maximum.accumulate(rise)


@pytest.mark.parametrize(
    ("v", "smith", "wagner"),
    [(0.1, 0.166083, 0.214182), (0.5, 0.633731, 0.689169), (1.0, 0.898767, 0.909871)],
)
def test_shadowing_functions_meet_the_check_values(v: float, smith: float, wagner: float) -> None:
    np.testing.assert_allclose([shadowing_smith67(v), shadowing_wagner67(v)], [smith, wagner], atol=6e-7)


def test_half_is_visible_where_the_sheet_says() -> None:
    halves = [shadowing_smith67(0.357835), shadowing_wagner67(0.284432)]
    np.testing.assert_allclose(halves, 0.5, atol=1e-6)  # the sheet's sixth digit times a slope of about 1.4


def test_shadowing_functions_are_shares_and_rise() -> None:
    v = np.concatenate(([0.0], np.geomspace(1e-9, 100.0, 2000)))
    smith, wagner = shadowing_smith67(v), shadowing_wagner67(v)
    for share in (smith, wagner):
        assert share[0] == 0.0
        assert np.all((share >= 0.0) & (share <= 1.0))
        assert np.all(np.diff(share) >= 0.0)
        np.testing.assert_allclose(share[-1], 1.0, rtol=1e-12)
    assert np.all(wagner >= smith)
    by_hand = 0.5 * (np.exp(-0.09) / (0.3 * np.sqrt(np.pi)) - erfc(0.3))
    np.testing.assert_allclose(shadowing_smith67(0.3), 0.5 * (2.0 - erfc(0.3)) / (1.0 + by_hand), rtol=1e-13)


@pytest.mark.parametrize("function", [shadowing_smith67, shadowing_wagner67, sinusoid_shadowed_fraction])
def test_a_ray_from_below_is_refused(function) -> None:
    with pytest.raises(ValueError, match="0 or more"):
        function([0.5, -0.1])


def test_sinusoid_under_parallel_rays_meets_the_check_values() -> None:
    m = np.array([0.1, 0.5, 0.9, 2.0 / np.sqrt(np.pi**2 + 4.0)])
    np.testing.assert_allclose(sinusoid_shadowed_fraction(m), [0.814343, 0.524130, 0.216875, 0.5], atol=5e-7)
    np.testing.assert_array_equal(sinusoid_shadowed_fraction([0.0, 1.0, 1.5, np.inf]), [1.0, 0.0, 0.0, 0.0])
    assert np.all(np.diff(sinusoid_shadowed_fraction(np.linspace(0.0, 1.0, 500))) < 0.0)


@pytest.mark.parametrize("direction", [1, -1])
@pytest.mark.parametrize("wavelength", [20.0, 40.0])
@pytest.mark.parametrize("steepness", [1.0 / 50.0, 1.0 / 30.0, 1.0 / 12.0])
@pytest.mark.parametrize("phase", [0.0, 1.3, 4.0])
def test_visible_intervals_agree_with_brute_force(
    steepness: float, wavelength: float, phase: float, direction: Literal[1, -1]
) -> None:
    height = steepness * wavelength
    intervals, share = sinusoid_visible_intervals(height, wavelength, 5.0, 40.0, 400.0, phase, direction)
    x, seen = running_maximum(height, wavelength, 5.0, 400.0, phase, direction)
    window = x >= 40.0
    tolerance = 2.0 * STEP * (len(intervals) + 1)  # each end falls between two points of the grid
    np.testing.assert_allclose(share * 360.0, np.mean(seen[window]) * 360.0, atol=tolerance)
    inside = np.searchsorted(intervals.ravel(), x) % 2 == 1
    assert np.sum(inside[window] != seen[window]) <= 2 * (len(intervals) + 1)


def test_crests_hidden_by_nearer_ones_from_an_antenna_below_the_crests() -> None:
    # an antenna in a trough, below the crests: the first crest hides everything behind it
    intervals, share = sinusoid_visible_intervals(4.0, 40.0, 1.0, 0.0, 400.0, np.pi)
    assert intervals.shape == (1, 2)
    x, seen = running_maximum(4.0, 40.0, 1.0, 400.0, np.pi, 1)
    np.testing.assert_allclose(share * 400.0, np.sum(seen) * STEP, atol=2 * STEP)
    # and level with them: random cases, some of whose crests are hidden whole
    rng = np.random.default_rng(11)
    for _ in range(20):
        height, phase = rng.uniform(0.5, 2.8), rng.uniform(-7.0, 7.0)
        antenna = height / 2.0 + rng.uniform(0.01, 0.5)
        intervals, share = sinusoid_visible_intervals(height, 20.0, antenna, 5.0, 200.0, phase)
        x, seen = running_maximum(height, 20.0, antenna, 200.0, phase, 1)
        tolerance = 2.0 * STEP * (len(intervals) + 1)
        np.testing.assert_allclose(share * 195.0, np.sum(seen[x >= 5.0]) * STEP, atol=tolerance)


def test_far_away_the_finite_antenna_becomes_parallel_rays() -> None:
    # one wave at 100 km from 500 m: the grazing angle changes by λ/r = 2e-4 over it
    height, wavelength = 0.2, 20.0
    m = (500.0 / 1e5) / (0.5 * height * 2.0 * np.pi / wavelength)
    _, share = sinusoid_visible_intervals(height, wavelength, 500.0, 1e5 - 100.0, 1e5 + 100.0)
    np.testing.assert_allclose(1.0 - share, sinusoid_shadowed_fraction(m), rtol=1e-3)


def test_intervals_touch_the_surface_as_tangents() -> None:
    height, wavelength, antenna = 1.0, 20.0, 5.0
    a, k = 0.5 * height, 2.0 * np.pi / wavelength
    intervals, _ = sinusoid_visible_intervals(height, wavelength, antenna, 0.0, 390.0)
    ends = intervals[:-1, 1]
    slope = -a * k * np.sin(k * ends)
    np.testing.assert_allclose((a * np.cos(k * ends) - antenna) / ends, slope, atol=1e-14)
    starts = intervals[1:, 0]  # on the ray that left the last tangent point
    np.testing.assert_allclose((a * np.cos(k * starts) - antenna) / starts, slope, atol=1e-14)


def test_flat_and_gentle_seas_are_all_visible_and_share_sums_up() -> None:
    for height in (0.0, 1e-3):
        intervals, share = sinusoid_visible_intervals(height, 40.0, 5.0, 40.0, 400.0)
        np.testing.assert_array_equal(intervals, [[40.0, 400.0]])
        assert share == 1.0
    intervals, share = sinusoid_visible_intervals(1.4, 40.0, 5.0, 40.0, 400.0, 0.5)
    bins = visible_share(intervals, np.linspace(40.0, 400.0, 10))
    np.testing.assert_allclose(np.mean(bins), share, rtol=1e-12)
    assert np.all((bins >= 0.0) & (bins <= 1.0))
    assert visible_share(np.zeros((0, 2)), [0.0, 1.0]) == 0.0


def test_directions_mirror_the_phase() -> None:
    there, _ = sinusoid_visible_intervals(1.0, 20.0, 5.0, 40.0, 400.0, 0.7, -1)
    back, _ = sinusoid_visible_intervals(1.0, 20.0, 5.0, 40.0, 400.0, -0.7, 1)
    np.testing.assert_allclose(there, back, rtol=1e-13)


def test_impossible_questions_are_refused() -> None:
    with pytest.raises(ValueError, match="above the water"):
        sinusoid_visible_intervals(2.0, 20.0, 0.9, 40.0, 400.0, 0.0)
    with pytest.raises(ValueError, match="range_min"):
        sinusoid_visible_intervals(1.0, 20.0, 5.0, 400.0, 40.0)
    with pytest.raises(ValueError, match="wavelength_m"):
        sinusoid_visible_intervals(1.0, 0.0, 5.0, 40.0, 400.0)


@pytest.mark.parametrize("antenna_height", [3.0, 10.0])
def test_what_is_seen_does_not_depend_on_where_one_stops_looking(antenna_height: float) -> None:
    # A crest beyond the end may show its face before it.
    edges = np.array([90.0, 100.0])
    for phase in np.arange(0.0, 2.0 * np.pi, 0.1):
        near, far = (
            sinusoid_visible_intervals(2.0, 40.0, antenna_height, 15.0, end, phase)[0] for end in (100.0, 180.0)
        )
        np.testing.assert_allclose(visible_share(near, edges), visible_share(far, edges), atol=1e-9)
