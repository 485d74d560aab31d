"""Bands over seeds that share their seas, and how often a recommendation is the right one."""

from __future__ import annotations

import numpy as np
import pytest
import xarray as xr
from numpy.typing import NDArray

from seamap_rt.studies.choices import choice_in_words
from seamap_rt.studies.paired import choose, means

HEIGHTS = [3.0, 5.0, 7.0, 10.0, 14.0, 20.0]
RADII = np.array([110.0, 138.0, 155.0, 168.0, 173.0, 175.0])  # 10 m: the lowest within 5 % of the best


def table(
    radii: NDArray[np.float64], seeds: int, common: float, own: float, stream: np.random.Generator
) -> xr.DataArray:
    """Of masts that meet the same seas, each of which moves all of them by `common`, and each alone by `own` [m]."""
    shape = len(radii), seeds
    values = radii[:, None] + common * stream.normal(size=seeds) + own * stream.normal(size=shape)
    return xr.DataArray(values, {"radar.height_m": HEIGHTS, "seed": range(seeds)}, ("radar.height_m", "seed"))


@pytest.mark.parametrize(("common", "own"), [(0.0, 4.0), (3.0, 2.0), (4.0, 0.1)])
@pytest.mark.parametrize("seeds", [2, 3, 6])
def test_bands_cover_the_mean_as_often_as_they_say(common: float, own: float, seeds: int) -> None:
    # Over 100 sweeps of six masts, 0.9 % of standard error and more, as masts share seeds. The degrees of freedom are
    # themselves estimated.
    stream, covered = np.random.default_rng(5), []
    for _ in range(100):
        band = means(table(RADII, seeds, common, own, stream))
        covered.append((band["low"].values < RADII) & (band["high"].values > RADII))
    assert 0.90 < np.mean(covered) < 0.99


def test_neighbours_narrow_a_band() -> None:
    # Of two independent seeds t has one degree of freedom alone (12.7), with its neighbours two or three (4.3, 3.2).
    stream = np.random.default_rng(6)
    wide = [means(table(RADII, 2, 0.0, 4.0, stream)) for _ in range(40)]
    alone = [means(table(RADII, 2, 0.0, 4.0, stream).isel({"radar.height_m": [2]})) for _ in range(40)]
    half = [np.median([(each["high"] - each["low"]).values.mean() for each in bands]) for bands in (wide, alone)]
    assert half[0] < 0.6 * half[1]


def test_the_lowest_mast_that_is_nearly_the_best_is_chosen() -> None:
    chosen = choose(table(RADII, 3, 2.0, 0.5, np.random.default_rng(7)), "radar.height_m")
    assert chosen is not None
    assert (chosen.value, chosen.best) == (10.0, 20.0)
    assert chosen.confidence > 0.95
    assert chosen.at_edge  # 20 m is the tallest: a taller one may be better
    assert "lowest antenna height within 5% of the best: 10 m (confidence" in choice_in_words(chosen)


def test_confidence_is_how_often_the_choice_is_right() -> None:
    # Where masts scatter, the choice is right about as often as it says, in the mean over sweeps.
    stream, said, right = np.random.default_rng(8), [], []
    for _ in range(300):
        chosen = choose(table(RADII, 3, 5.0, 4.0, stream), "radar.height_m")
        assert chosen is not None
        said.append(chosen.confidence)
        right.append(chosen.value == 10.0)
    assert 0.5 < np.mean(right) < 0.97
    assert np.mean(said) == pytest.approx(np.mean(right), abs=0.08)


def test_what_a_seed_does_to_all_masts_is_no_doubt_about_the_choice() -> None:
    stream = np.random.default_rng(9)
    chosen = choose(table(RADII, 3, 30.0, 0.5, stream), "radar.height_m")
    assert chosen is not None
    assert chosen.confidence > 0.9


def test_one_seed_has_a_choice_and_no_confidence() -> None:
    values = table(RADII, 1, 0.0, 0.0, np.random.default_rng(1))
    chosen = choose(values, "radar.height_m")
    assert chosen is not None
    assert chosen.value == 10.0
    assert np.isnan(chosen.confidence)
    assert "confidence" not in choice_in_words(chosen)
    assert np.isnan(means(values)["low"]).all()
    assert choose(values * np.nan, "radar.height_m") is None


def test_points_that_failed_leave_their_seed_out_of_the_comparison() -> None:
    values = table(RADII, 4, 0.0, 0.1, np.random.default_rng(2))
    values[3, 0] = np.nan
    values[1] = np.nan
    chosen = choose(values, "radar.height_m")
    assert chosen is not None
    assert chosen.value == 10.0
    assert np.isfinite(means(values)["low"].values[3])
