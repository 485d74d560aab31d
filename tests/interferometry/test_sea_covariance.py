"""The covariance of a sea from a map of it, against that of the waves it was drawn from."""

from __future__ import annotations

import numpy as np
import pytest
from numpy.typing import NDArray
from synthetic_seas import Waves, evenly, polar

from seamap_rt.interferometry import sea_covariance
from seamap_rt.interferometry.sea_covariance import SeaCovariance

Array = NDArray[np.float64]
RMS = 0.35
RANGES = evenly(20.0, 1.5, 120)


def noisy_map(seed: int, noise: float, gaps: float = 0.3, ranges: Array = RANGES) -> tuple[Array, Array, Array, Array]:
    """Heights of a turn, their errors' variance, x and y. Errors of neighbouring gates go together, by half; patches of
    four gates are missing."""
    rng = np.random.default_rng(seed)
    x, y, _, _ = polar(ranges)
    std = noise * rng.uniform(0.3, 1.5, x.shape)
    white = rng.normal(size=(200, ranges.size + 1))
    height = Waves.drawn(seed, RMS)(x, y) + std * np.sqrt(0.5) * (white[:, 1:] + white[:, :-1])
    missing = np.repeat(rng.random((200, -(-ranges.size // 4))) < gaps, 4, axis=1)[:, : ranges.size]
    return np.where(missing, np.nan, height), std**2, x, y


def lags(sea: SeaCovariance) -> tuple[Array, Array, Array]:
    lag = sea.spacing * (np.arange(sea.table.shape[0]) - sea.table.shape[0] // 2)
    east, north = np.meshgrid(lag, lag, indexing="ij")
    return east, north, np.hypot(east, north)


@pytest.mark.parametrize("noise", [0.0, 0.25])
def test_the_covariance_is_the_seas(noise: float) -> None:
    # Six turns; of each the products of 40 waves with each other, which vanish over an area of 300 m, leave 1 % or so.
    # Places are known to squares of 1.5 m; the fade of long lags leaves nothing on short ones.
    found = [SeaCovariance.of(*noisy_map(seed, noise)) for seed in range(6)]
    east, north, distance = lags(found[0])
    asked = Waves.drawn(0, RMS).covariance(east, north, 1.5)
    mean = np.mean([each.table for each in found], axis=0)
    inside = (distance >= 3.0) & (distance <= 20.0)
    off = (mean - asked) / RMS**2
    assert np.sqrt(np.mean(off[inside] ** 2)) < 0.02
    assert np.abs(off[inside]).max() < 0.05
    # The variance is that of the sea alone, without the errors', which would add half of it; negative powers that are
    # let be none add some.
    assert -0.03 < float(off[distance == 0.0][0]) < 0.1
    assert found[0].variance == pytest.approx(found[0].table.max())


def test_it_is_a_covariance() -> None:
    # Even, and of no negative eigenvalue beyond what is cut off where lags fade out.
    rng = np.random.default_rng(1)
    for seed, noise in ((1, 0.0), (2, 0.3)):
        sea = SeaCovariance.of(*noisy_map(seed, noise))
        np.testing.assert_allclose(sea.table, sea.table[::-1, ::-1], rtol=0, atol=1e-12)
        middle = sea.table.shape[0] // 2
        for spread in (6.0, 20.0, 60.0):
            number = np.round(rng.uniform(0.0, spread, (120, 2)) / sea.spacing).astype(int)
            apart = number[:, None] - number[None]
            inside = (np.abs(apart) <= middle).all(axis=-1)
            i, j = (np.clip(apart[..., n] + middle, 0, 2 * middle) for n in (0, 1))
            matrix = np.where(inside, sea.table[i, j], 0.0)
            # Points farther apart than lags reach are no neighbours; each has an error of 0.1 % of the variance.
            assert np.linalg.eigvalsh(matrix)[0] > (-1e-6 if spread < 48.0 else -1e-3) * sea.variance


def test_a_quarter_turn_turns_it() -> None:
    height, variance, x, y = noisy_map(3, 0.2)
    table, turned = SeaCovariance.of(height, variance, x, y).table, SeaCovariance.of(height, variance, -y, x).table
    # Lag (i, j) has become (−j, i).
    np.testing.assert_allclose(turned, table.T[::-1], rtol=0, atol=1e-12)


def test_of_a_sector_little_is_known() -> None:
    # Of 5 looks, 9°, lags across the look are known badly. What is not known counts as some sea, never as none.
    height, variance, x, y = noisy_map(4, 0.1)
    height[5:] = np.nan
    sea = SeaCovariance.of(height, variance, x, y)
    assert np.isfinite(sea.table).all()
    assert 0.3 * RMS**2 < sea.variance < 6.0 * RMS**2
    assert (np.abs(sea.table) <= sea.variance * (1.0 + 1e-9)).all()


@pytest.mark.parametrize("first", [300.0, 700.0, 2000.0])
def test_far_out_the_sea_is_the_same(first: float) -> None:
    # The nearest cells 300 m away and more, where looks lie 9 to 63 m apart: what is known is known along them, of as
    # many waves as pass in 768 m. Lags across the looks are not, and what is not known adds to the variance, as above.
    found = [SeaCovariance.of(*noisy_map(seed, 0.1, ranges=evenly(first, 1.5, 120))).variance for seed in range(6)]
    assert 0.8 * RMS**2 < np.mean(found) < 4.0 * RMS**2


def test_little_is_known_of_a_sea_of_few_cells() -> None:
    height, variance, x, y = noisy_map(5, 0.1, gaps=0.0)
    nothing = np.full(height.shape, np.nan)
    empty = SeaCovariance.of(nothing, variance, x, y)
    assert empty.variance == 0.0
    for cells in (1, 2, 3, 10):
        few = nothing.copy()
        few[40:, 30].flat[:cells] = height[40:, 30].flat[:cells]
        few[7, 3] = np.inf
        sea = SeaCovariance.of(few, variance, x, y)
        assert np.isfinite(sea.table).all()
        assert 0.0 < sea.variance < 4.0 * np.nanmax(few[40:, 30] ** 2) + 1e-6
    for lost in range(3):
        variance_, x_, y_ = (nothing if n == lost else each for n, each in enumerate((variance, x, y)))
        assert SeaCovariance.of(height, variance_, x_, y_).variance == 0.0


def test_a_flat_sea_has_next_to_none() -> None:
    _, variance, x, y = noisy_map(6, 0.1)
    sea = SeaCovariance.of(np.zeros(x.shape), variance, x, y)
    # 0.1 mm squared is left, that matrices have an inverse.
    assert 0.0 < sea.variance < 2e-8
    assert np.abs(sea.table).sum() == pytest.approx(sea.variance, rel=1e-6)


def test_cells_count_by_their_errors() -> None:
    # Half of the looks have errors three times as large as the sea itself, and say so.
    height, variance, x, y = noisy_map(7, 0.05, gaps=0.0)
    rng = np.random.default_rng(8)
    bad = height + 3.0 * RMS * rng.normal(size=height.shape) * (np.arange(200) % 2)[:, None]
    worse = variance + (3.0 * RMS) ** 2 * (np.arange(200) % 2)[:, None]
    clean = SeaCovariance.of(height, variance, x, y)
    told, untold = (SeaCovariance.of(bad, each, x, y) for each in (worse, variance))
    inside = (lags(clean)[2] > 3.0) & (lags(clean)[2] < 20.0)
    off = [np.sqrt(np.mean((each.table - clean.table)[inside] ** 2)) for each in (told, untold)]
    assert off[0] < 0.5 * off[1]


def test_squares_beyond_the_nearest_cells_do_not_count() -> None:
    # Beyond 150 m of the nearest cell the beam is wide: what is found there changes nothing.
    height, variance, x, y = noisy_map(9, 0.1)
    away = np.hypot(x, y) > 20.0 + sea_covariance._NEAR_M + 1e-9
    assert away.any()
    other = np.where(away, 10.0, height)
    np.testing.assert_array_equal(
        SeaCovariance.of(other, variance, x, y).table, SeaCovariance.of(height, variance, x, y).table
    )


def wind_sea(seed: int, longest: float, footprint: float) -> tuple[Array, Array, Array, Array, Array]:
    """A turn's heights of a sea whose power is ∝ k⁻⁴ (1 + ½ cos 2θ) from a longest wave on, rms 0.35 m; each is a mean
    over a Gaussian area, with an error that it shares with its neighbours. With that sea's structure function."""
    rng = np.random.default_rng(seed)
    side, step = 1024, 0.5
    wave = 2.0 * np.pi * np.fft.fftfreq(side, step)
    east, north = np.meshgrid(wave, wave, indexing="ij")
    k = np.hypot(east, north)
    power = np.where(k > 2.0 * np.pi / longest, (1.0 + 0.5 * np.cos(2.0 * np.arctan2(north, east))), 0.0)
    power *= np.maximum(k, 1e-9) ** -4.0
    power *= RMS**2 / power.mean() / side**2
    white = np.fft.fft2(rng.normal(size=(side, side)))
    surface = np.fft.ifft2(white * np.sqrt(power * side**2) * np.exp(-0.5 * (k * footprint) ** 2)).real
    x, y, _, _ = polar(RANGES)
    i, j = (np.round(each / step).astype(int) % side for each in (x, y))
    shared = rng.normal(size=(200, RANGES.size + 1))
    height = surface[i, j] + 0.1 * np.sqrt(0.5) * (shared[:, 1:] + shared[:, :-1])
    lag = np.fft.ifft2(power).real * side**2
    return height, np.full(x.shape, 0.01), x, y, lag[0, 0] - lag[[2, 4, 8, 12], 0]


@pytest.mark.parametrize("longest", [25.0, 60.0, 150.0])
def test_slopes_are_those_of_all_waves_down_to_decimetres(longest: float) -> None:
    # Of power ∝ k⁻⁴ from k₀ on the slopes' variance in one direction is σ² k₀² ln(k/k₀); the map has none below 10 m.
    first = 2.0 * np.pi / longest
    asked = RMS * first * np.sqrt(np.log(2.0 * np.pi / sea_covariance._FINEST / first))
    turns = [wind_sea(seed, longest, 1.1) for seed in range(3)]
    found = [np.sqrt(SeaCovariance.of(*turn[:4], (1.1, 0.0)).slope_variance) for turn in turns]
    np.testing.assert_allclose(np.mean(found), asked, rtol=0.1)  # a fifth of the power, as above


def test_the_fade_of_long_lags_leaves_a_swell_no_steeper() -> None:
    # A swell 120 m long: over 6 m it loses what a cosine does, 5 % of its variance; faded lags alone would have 12 %.
    x, y, _, _ = polar(RANGES)
    rng = np.random.default_rng(11)
    height = 0.5 * np.sin(2.0 * np.pi * x / 120.0 + 1.0) + 0.05 * rng.normal(size=x.shape)
    sea = SeaCovariance.of(height, np.full(x.shape, 0.0025), x, y)
    middle, lag = sea.table.shape[0] // 2, round(6.0 / sea.spacing)
    along = 1.0 - sea.table[middle + lag, middle] / sea.variance
    across = 1.0 - sea.table[middle, middle + lag] / sea.variance
    assert along == pytest.approx(1.0 - np.cos(2.0 * np.pi * 6.0 / 120.0), abs=0.02)
    assert abs(across) < 0.02


@pytest.mark.parametrize("longest", [25.0, 60.0, 150.0])
def test_waves_shorter_than_the_footprint_are_those_of_a_wind_sea(longest: float) -> None:
    """What the sea loses over 1 to 6 m, most of which no height shows: found to a fifth, as a turn of one sea has it.

    An even surface through the lags beyond 3 m would find a half or less of it for 25 m waves.
    """
    found = []
    for seed in range(3):
        height, variance, x, y, lost = wind_sea(seed, longest, 1.1)
        sea = SeaCovariance.of(height, variance, x, y, (1.1, 0.0))
        middle = sea.table.shape[0] // 2
        found.append((sea.variance - sea.table[middle + np.array([2, 4, 8, 12]), middle]) / lost)
    assert 0.8 < np.mean(found) < 1.2
    assert 0.65 < np.min(np.mean(found, axis=0)) < np.max(np.mean(found, axis=0)) < 1.35


@pytest.mark.parametrize(("ripples", "waves"), [(0.0, 0.0), (0.06, 0.0), (0.06, RMS)])
def test_ripples_that_no_lag_shows_are_unresolved(ripples: float, waves: float) -> None:
    """What heights vary by beyond their errors is known of many cells, though no lag shows it, and though large errors
    are stated half too large; not beside a sea whose own height is uncertain by more."""
    x, y, _, _ = polar(RANGES)
    rng = np.random.default_rng(5)
    std = 0.1 * rng.uniform(0.3, 1.5, x.shape)
    height = rng.normal(size=x.shape) * np.hypot(std, ripples) + (Waves.drawn(5, RMS)(x, y) if waves else 0.0)
    stated = np.where(std > 0.08, 1.5, 1.0) * std
    found = SeaCovariance.of(height, stated**2, x, y, (1.0, 0.01))
    # The footprint damps waves of that length by exp(−k² blur). Of 24,000 cells a variance is known to a hundredth; a
    # twentieth of the errors' is left out, and large errors stated too large take some more.
    measured = ripples**2 if not waves else 0.0
    blur = 0.5 * (1.0 + 0.01**2 * float(np.mean(x**2 + y**2))) + 1.5**2 / 12.0
    assert np.exp(-(found.shortest**2) * blur) * found.unresolved == pytest.approx(measured, rel=0.4, abs=1e-4)
    assert not found.unresolved or found.unresolved_mean(3.0, np.array(0.0)) < found.unresolved


def test_a_blurred_gaussian_is_a_wider_one() -> None:
    # exp(−d²/2L²) blurred by a variance b a side is L²/(L² + b) exp(−d²/2(L² + b)). The blur ends at three standard
    # deviations: what it leaves out of each side has 2.9 % of its variance.
    spacing, length, variance = 0.5, 6.0, 7.0
    lag = spacing * np.arange(-60, 61)
    square = lag[:, None] ** 2 + lag**2
    table = SeaCovariance(np.exp(-0.5 * square / length**2), spacing)
    for kept in (variance, 1e-12):
        wider = length**2 + kept
        asked = length**2 / wider * np.exp(-0.5 * square / wider)
        np.testing.assert_allclose(table.blurred(kept), asked, rtol=0, atol=max(0.029 * kept / length**2, 1e-12))
    np.testing.assert_allclose(SeaCovariance(np.ones((9, 9)), spacing).blurred(variance), 1.0, rtol=1e-14)  # nor edges
