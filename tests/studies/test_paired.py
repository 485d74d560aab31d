"""Bands over seeds that share their seas, and how often a recommendation is the right one."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest
import xarray as xr
from numpy.typing import NDArray

from seamap_rt.studies.choices import choice_in_words
from seamap_rt.studies.paired import FEWEST_SEEDS, choose, means, significant_difference, value_with_band

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
@pytest.mark.parametrize("seeds", [3, 6])
@pytest.mark.slow
def test_bands_cover_the_mean_as_often_as_they_say(common: float, own: float, seeds: int) -> None:
    # Over 100 sweeps of six masts, 0.9 % of standard error and more, as masts share seeds. The degrees of freedom are
    # themselves estimated.
    stream, covered = np.random.default_rng(5), []
    for _ in range(100):
        band = means(table(RADII, seeds, common, own, stream))
        covered.append((band["low"].values < RADII) & (band["high"].values > RADII))
    assert 0.90 < np.mean(covered) < 0.99


def test_neighbours_narrow_a_band() -> None:
    # Of three independent seeds t has two degrees of freedom alone (4.3), with its neighbours four or six (2.8, 2.4).
    stream = np.random.default_rng(6)
    wide = [means(table(RADII, 3, 0.0, 4.0, stream)) for _ in range(40)]
    alone = [means(table(RADII, 3, 0.0, 4.0, stream).isel({"radar.height_m": [2]})) for _ in range(40)]
    half = [np.median([(each["high"] - each["low"]).values.mean() for each in bands]) for bands in (wide, alone)]
    assert half[0] < 0.75 * half[1]


def test_the_lowest_mast_that_is_nearly_the_best_is_chosen() -> None:
    chosen = choose(table(RADII, 3, 2.0, 0.3, np.random.default_rng(7)), "radar.height_m")
    assert chosen is not None
    assert (chosen.value, chosen.best) == (10.0, 20.0)
    assert chosen.confidence > 0.95
    assert "lowest antenna height within 5% of the best: 10 m (confidence" in choice_in_words(chosen)


# Radii of one to four heights, and where the best one lies: at an end, inside, all alike, alone, beside a refused one.
ENDS = [
    ([100.0, 140.0, 160.0], "last", "the best is 7 m, the last of the grid; widen it"),
    ([160.0, 140.0, 100.0], "first", "the best is 3 m, the first of the grid; widen it"),
    ([100.0, 160.0, 140.0], "", "the best is 5 m"),
    ([159.0, 160.0, 140.0], "", "good enough (the first of the grid; a lower one may be, too); the best is 5 m"),
    ([150.0, 150.0, 150.0], "", "the best is 3 m"),
    ([150.0], "", "the best is 3 m"),
    ([100.0, 140.0, np.nan], "", "the best is 5 m"),  # a taller one was refused: that is no end of what was asked for
    ([np.nan, 140.0, 120.0, 100.0], "", "the best is 5 m"),
]


@pytest.mark.parametrize("turned", [False, True])
@pytest.mark.parametrize(("radii", "end", "said"), ENDS)
def test_the_grid_is_to_be_widened_exactly_where_the_best_is_at_its_end(
    radii: list[float], end: str, said: str, turned: bool
) -> None:
    heights = HEIGHTS[: len(radii)]
    values = xr.DataArray(np.array(radii)[:, None], {"radar.height_m": heights}, ("radar.height_m", "seed"))
    chosen = choose(values.isel({"radar.height_m": slice(None, None, -1)}) if turned else values, "radar.height_m")
    assert chosen is not None
    text = choice_in_words(chosen)
    assert (chosen.best_end, text.endswith(said), "widen it" in text) == (end, True, bool(end))


@pytest.mark.parametrize("at_most", [*HEIGHTS, 12.0, 30.0])
def test_a_limit_is_kept_and_what_it_costs_is_told(at_most: float) -> None:
    chosen = choose(table(RADII, 1, 0.0, 0.0, np.random.default_rng(1)), "radar.height_m", at_most=at_most)
    assert chosen is not None
    allowed = np.array(HEIGHTS) <= at_most
    best = RADII[allowed].max()
    assert max(chosen.value, chosen.best) <= at_most
    assert chosen.value == np.array(HEIGHTS)[0.95 * best <= RADII][0]
    text = choice_in_words(chosen)
    if at_most < HEIGHTS[-1]:
        assert chosen.lost == pytest.approx(1.0 - best / RADII.max())
        assert "the limit costs" in text
        assert "without it the best is 20 m" in text
        assert "widen" not in text
    else:
        assert "the last of the grid; widen it to see what the limit costs" in text


def test_a_limit_below_the_grid_chooses_nothing() -> None:
    assert choose(table(RADII, 1, 0.0, 0.0, np.random.default_rng(1)), "radar.height_m", at_most=2.0) is None


def test_confidence_is_how_often_the_choice_is_right() -> None:
    # Where masts scatter, the choice is right about as often as it says, in the mean over sweeps.
    stream, said, right = np.random.default_rng(8), [], []
    for _ in range(300):
        chosen = choose(table(RADII, 5, 5.0, 4.0, stream), "radar.height_m")
        assert chosen is not None
        said.append(chosen.confidence)
        right.append(chosen.value == 10.0)
    assert 0.5 < np.mean(right) < 0.97
    assert np.mean(said) == pytest.approx(np.mean(right), abs=0.08)


def test_what_a_seed_does_to_all_masts_is_no_doubt_about_the_choice() -> None:
    """But for that a twentieth of it is in no difference of one mast's radius with 95 % of another's."""
    stream = np.random.default_rng(9)
    chosen = choose(table(RADII, 5, 15.0, 0.5, stream), "radar.height_m")
    assert chosen is not None
    assert chosen.confidence > 0.9


def normal(stream: np.random.Generator, shape: tuple[int, ...]) -> NDArray[np.float64]:
    return stream.standard_normal(shape)


def heavy(stream: np.random.Generator, shape: tuple[int, ...]) -> NDArray[np.float64]:
    """Student's t of three degrees of freedom, of variance 1."""
    return stream.standard_t(3, shape) / np.sqrt(3.0)


def lopsided(stream: np.random.Generator, shape: tuple[int, ...]) -> NDArray[np.float64]:
    return stream.standard_exponential(shape) - 1.0


# Radii of six masts by what is hard about them: well apart; one just good enough, just not; many alike; the best alone
# scatters from sea to sea. With the masts' own scatter [m].
HARD = {
    "apart": ([110.0, 138.0, 155.0, 168.0, 173.0, 175.0], [4.0] * 6),
    "just good enough": ([110.0, 138.0, 155.0, 166.26, 173.0, 175.0], [4.0] * 6),
    "just not": ([110.0, 138.0, 166.24, 172.0, 173.0, 175.0], [4.0] * 6),
    "alike": ([110.0, 166.24, 166.24, 166.24, 175.0, 175.0], [4.0] * 6),
    "unequal": ([110.0, 120.0, 130.0, 140.0, 166.26, 175.0], [0.5, 0.5, 0.5, 0.5, 0.5, 12.0]),
}


@pytest.mark.parametrize("kind", HARD)
@pytest.mark.parametrize("drawn", [normal, heavy, lopsided])
@pytest.mark.parametrize("seeds", [2, 3, 5, 10])
@pytest.mark.slow
def test_a_wrong_choice_is_called_sure_in_one_sweep_of_twenty_at_most(kind: str, drawn: Any, seeds: int) -> None:
    """Whatever the truth is: 5 %, and of 200 sweeps three standard errors of that (1.54 %). Of two seeds never."""
    radii, own = (np.array(each) for each in HARD[kind])
    right = HEIGHTS[int(np.argmax(radii >= 0.95 * radii.max()))]
    stream, wrong = np.random.default_rng([seeds, list(HARD).index(kind)]), 0
    for _ in range(200):
        shared = 5.0 * drawn(stream, (seeds,))
        values = radii[:, None] + shared + own[:, None] * drawn(stream, (len(radii), seeds))
        chosen = choose(xr.DataArray(values, {"radar.height_m": HEIGHTS}, ("radar.height_m", "seed")), "radar.height_m")
        assert chosen is not None
        assert np.isfinite(chosen.confidence) == (seeds >= FEWEST_SEEDS)
        wrong += chosen.confidence >= 0.95 and chosen.value != right
    assert wrong / 200.0 <= 0.05 + 3.0 * 0.0154


@pytest.mark.parametrize("drawn", [normal, heavy, lopsided])
@pytest.mark.parametrize("seeds", [3, 5, 10])
@pytest.mark.slow
def test_choices_said_to_be_sure_are_right_in_nineteen_of_twenty(drawn: Any, seeds: int) -> None:
    """Over sweeps whose masts differ by known amounts of any size: of those called 95 % sure, three standard errors."""
    stream, right = np.random.default_rng(seeds), []
    for _ in range(400):
        radii = 175.0 * np.sort(stream.uniform(0.7, 1.0, 4))
        own = np.exp(stream.uniform(-1.0, 1.5, 4))
        values = radii[:, None] + 5.0 * drawn(stream, (seeds,)) + own[:, None] * drawn(stream, (4, seeds))
        table = xr.DataArray(values, {"radar.height_m": HEIGHTS[:4]}, ("radar.height_m", "seed"))
        chosen = choose(table, "radar.height_m")
        assert chosen is not None
        if chosen.confidence >= 0.95:
            right.append(chosen.value == HEIGHTS[int(np.argmax(radii >= 0.95 * radii.max()))])
    assert len(right) > 20
    assert np.mean(right) >= 0.95 - 3.0 * np.sqrt(0.95 * 0.05 / len(right))


@pytest.mark.parametrize(
    ("band", "said"),
    [((80.0, 60.0, 100.0), "80 ± 20 m"), ((81.0, 0.0, 271.0), "81 m (0 to 271 m)"), ((80.0, np.nan, np.nan), "80 m")],
)
def test_a_band_is_said_as_it_is(band: tuple[float, float, float], said: str) -> None:
    assert value_with_band(*band, " m") == said


@pytest.mark.parametrize("seeds", [1, 2, 3, 4])
def test_bands_begin_with_three_seeds_and_never_below_nothing(seeds: int) -> None:
    band = means(table(np.full(6, 10.0), seeds, 0.0, 20.0, np.random.default_rng(3)).clip(0.0))
    assert np.isfinite(band["low"]).all() == np.isfinite(band["high"]).all() == (seeds >= FEWEST_SEEDS)
    assert not (band["low"] < 0.0).any()
    assert np.isnan(significant_difference(table(RADII, seeds, 1.0, 1.0, np.random.default_rng(3)))) == (seeds < 3)


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
