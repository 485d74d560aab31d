"""How much is measured, and how far, of cells whose errors are known."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import numpy as np
import pytest
import xarray as xr
from numpy.typing import NDArray
from scipy.stats import norm

from seamap_rt.dataset import QUALITY_FLAGS
from seamap_rt.measured import LEVEL, CoverageProfile

Array = NDArray[np.float64]
RANGES = np.arange(20.25, 300.0, 1.5)


def rings(quality: Callable[[Array], Array]) -> CoverageProfile:
    """Of a mean score that depends on range alone."""
    cells = np.full(RANGES.size, 200.0)
    return CoverageProfile(RANGES, cells * quality(RANGES), cells, cells, 0.0 * cells)


def cells(error: Array, sigma: float, **changes: NDArray[Any]) -> CoverageProfile:
    """Errors [m] (turn, azimuth, range) of cells that are all seen, but for what is changed."""
    shape = ("turn", "azimuth", "range")
    true = np.random.default_rng(1).normal(0.0, sigma, error.shape)
    polar = {"height": true + error, "quality": np.zeros(error.shape, np.uint16)}
    truth = {"height": true, "visible_fraction": np.ones(error.shape)}
    for name, values in changes.items():
        (truth if name in truth and name != "height" else polar)[name] = values
    at = {"range": RANGES[: error.shape[-1]]}
    seen, sea = (xr.Dataset({name: (shape, each[name]) for name in each}, at) for each in (polar, truth))
    return CoverageProfile.of(seen, sea, sigma)


def test_radii_of_a_disc_that_is_measured_wholly() -> None:
    # Beyond a blind disc of 19.5 m, to 150 m: √(150² − 19.5²); q falls at once there.
    made = rings(lambda r: np.where(r < 150.0, 1.0, 0.0))
    assert made.fully_measured_radius == pytest.approx(np.sqrt(150.0**2 - 19.5**2), abs=0.1)
    # A line through 60 m of a step passes the level within a sixth of them.
    assert made.reach == (pytest.approx(150.0, abs=10.0), False)


def test_radii_of_a_score_that_falls_evenly() -> None:
    # q = 1 − R/L: R_A² = 2 ∫ q R dR, and q = LEVEL at (1 − LEVEL) L.
    made = rings(lambda r: 1.0 - r / 300.0)
    near, far = 19.5, 300.0
    integral = (far**2 - near**2) - 2.0 / 3.0 / 300.0 * (far**3 - near**3)
    assert made.fully_measured_radius == pytest.approx(np.sqrt(integral), rel=1e-3)
    assert made.reach == (pytest.approx((1.0 - LEVEL) * 300.0, abs=1e-6), False)


def test_reach_has_no_threshold_that_noise_trips() -> None:
    # Rings that scatter by 0.1 about an even fall: 40 of them lie beside the reach, and their line's slope is 1/300.
    stream = np.random.default_rng(4)
    found = [rings(lambda r: 1.0 - r / 300.0 + 0.1 * stream.normal(size=r.size)).reach[0] for _ in range(200)]
    assert np.mean(found) == pytest.approx(216.0, abs=4.0)
    assert np.std(found) < 1.3 * 0.1 * 300.0 / np.sqrt(57.0)


def test_reach_that_ends_nowhere_or_begins_nowhere() -> None:
    assert rings(lambda r: np.full(r.size, 0.5)).reach == (RANGES[-1], True)
    assert rings(lambda r: np.full(r.size, 0.1)).reach == (0.0, False)
    # A tall mast looks over what is near: the nearest q that only falls is 0.6 all the way to 200 m.
    over = rings(lambda r: np.where(r < 60.0, 0.2, np.where(r < 200.0, 0.7, 0.0)))
    assert over.reach[0] == pytest.approx(200.0, abs=15.0)


@pytest.mark.parametrize("share", [0.3, 0.7, 1.5])
def test_scores_of_normal_errors(share: float) -> None:
    # E[1 − min(e², σ²)/σ²] of e = share σ x is (1 − a²)(2Φ(z) − 1) + 2 a² z φ(z), z = 1/a.
    errors = share * 0.4 * np.random.default_rng(2).normal(size=(2, 300, 20))
    z = 1.0 / share
    expected = (1.0 - share**2) * (2.0 * norm.cdf(z) - 1.0) + 2.0 * share**2 * z * norm.pdf(z)
    made = cells(errors, 0.4)
    # 12,000 cells, whose scores spread by at most a half.
    assert np.mean(made.quality) == pytest.approx(expected, abs=4.0 * 0.5 / np.sqrt(12_000))
    assert made.gross_share == pytest.approx(2.0 * norm.sf(2.0 * z), abs=4.0 * 0.5 / np.sqrt(12_000))


def test_cells_without_a_sure_height_score_nothing() -> None:
    none = np.zeros((1, 100, 10))
    dark, unsure, silent = (np.arange(100)[:, None] % 4 == number for number in range(3))
    made = cells(
        np.where(silent, np.nan, none),
        0.4,
        visible_fraction=np.where(dark, 0.4, 1.0) + none,
        quality=(np.where(unsure, QUALITY_FLAGS["ambiguous"], 0) + none).astype(np.uint16),
    )
    np.testing.assert_allclose(made.quality, 0.25)
    assert made.sure.sum() == 250.0


def test_rings_of_turns_add() -> None:
    errors = 0.2 * np.random.default_rng(3).normal(size=(2, 50, 30))
    both, parts = cells(errors, 0.4), [cells(errors[n : n + 1], 0.4) for n in range(2)]
    np.testing.assert_allclose((parts[0] + parts[1]).quality, both.quality)
    assert (parts[0] + parts[1]).gross_share == both.gross_share


def test_without_waves_there_is_no_score() -> None:
    made = cells(0.01 * np.ones((1, 50, 30)), 0.0)
    assert np.isnan(made.fully_measured_radius)
    assert np.isnan(made.reach[0])


def test_rings_count_by_their_area() -> None:
    """q of 0.2 within R/√2 and of 0.34 beyond: half of the disc's area each, so that 0.27 of it is measured, which is
    below the level, with 0.4 beyond 0.3, which is above: by rings alike the nearer ones, more in number, would pull
    both below."""
    edge = RANGES[-1] / np.sqrt(2.0)
    for far, passes in ((0.34, False), (0.4, True)):
        made = rings(lambda r, far=far: np.where(r < edge, 0.2, far))
        assert (made.reach[0] > 0.0) == passes


def test_a_line_through_few_rings_tells_the_reach() -> None:
    """Of seven rings of 8 m that fall evenly: a line through those beside says (1 − LEVEL) L, not a ring's middle."""
    ranges = np.arange(20.0, 150.0, 8.0)
    many = np.full(ranges.size, 200.0)
    for length in (140.0, 147.0, 151.0):
        made = CoverageProfile(ranges, many * (1.0 - ranges / length), many, many, 0.0 * many)
        assert made.reach == (pytest.approx((1.0 - LEVEL) * length, abs=1e-6), False)


def test_missed_cells_are_of_50_to_200_m() -> None:
    """All heights there are beyond: a fourth of the cells within are missed, whatever near and far ones do."""
    inside = (RANGES >= 50.0) & (RANGES <= 200.0)
    cells = np.full(RANGES.size, 200.0)
    for elsewhere in (0.0, 200.0):
        made = CoverageProfile(RANGES, cells, cells, np.where(inside, 150.0, elsewhere), 0.0 * cells)
        assert made.missed_share == pytest.approx(0.25)
