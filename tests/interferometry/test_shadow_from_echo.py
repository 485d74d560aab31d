"""What is in sight, told by the echo alone: nothing is hidden on a flat sea, a sinusoid's shadows lie where they do."""

from __future__ import annotations

import numpy as np
import pytest
from numpy.typing import NDArray

from seamap_rt.interferometry import slopes
from seamap_rt.radar.waveform import RangeResponse
from validation.analytic import sinusoid_visible_intervals, visible_share

SPACING, CELL, HEIGHT = 1.5, 3.0, 5.0
RANGES = np.arange(60.0, 300.0, SPACING)
GRAZING = HEIGHT / RANGES[None]
LIT = RANGES[None] ** -3.5
WIDTH = RANGES[None] * np.radians(1.8)
LOOKS = 60
SLOPE_RMS = 0.09
RESPONSE = RangeResponse(20e-9, 50e6)


def heard(share: NDArray[np.float64]) -> NDArray[np.float64]:
    """Power (look, gate) of a sea of which that share (gate,) is lit, its echoes as wide as the pulse's response."""
    skirts = RESPONSE(SPACING * np.arange(-3, 4)) ** 2
    padded = np.pad(share, 3, mode="edge")
    smeared = np.asarray(np.convolve(padded, skirts / skirts.sum(), "valid"), dtype=np.float64)
    return np.broadcast_to(smeared, (LOOKS, share.size)) * LIT


@pytest.mark.parametrize("speckled", [False, True])
def test_a_flat_sea_hides_nothing(speckled: bool) -> None:
    rng = np.random.default_rng(1)
    power = LIT * (rng.exponential(size=(LOOKS, RANGES.size)) if speckled else np.ones((LOOKS, 1)))
    slope, spread = np.zeros(power.shape), np.full(power.shape, 0.02)
    still = slopes.shadow(power, LIT, slope, slopes.rms_slope(slope, spread), GRAZING, (CELL, WIDTH))
    np.testing.assert_array_equal(still.visible_share, 1.0)
    np.testing.assert_array_equal(still.crest_bias, 0.0)
    # Slopes of a flat sea come out as their noise, 0.001: the grazing angle, 0.017 at the least, is 6 times what that
    # makes of the sea's slopes. A cell must fade by 30 dB with all its neighbours to be taken for hidden.
    slope = rng.normal(scale=1e-3, size=power.shape)
    found = slopes.shadow(power, LIT, slope, slopes.rms_slope(slope, spread), GRAZING, (CELL, WIDTH))
    assert found.visible_share.min() > 0.99
    assert found.crest_bias.max() < 1e-4


@pytest.mark.parametrize(("wave_height", "wavelength"), [(1.4, 30.0), (2.5, 47.0), (4.0, 80.0)])
def test_a_sinusoid_casts_its_shadows_where_they_are(wave_height: float, wavelength: float) -> None:
    intervals, _ = sinusoid_visible_intervals(wave_height, wavelength, HEIGHT, 1.0, 400.0)
    exact = np.array([visible_share(intervals, (r - 0.5 * CELL, r + 0.5 * CELL))[0] for r in RANGES])
    k = 2.0 * np.pi / wavelength
    slope = np.broadcast_to(-0.5 * wave_height * k * np.sin(k * RANGES), (LOOKS, RANGES.size))
    # A sinusoid has no shorter waves, so that its rms slope is its own.
    found = slopes.visible_share(heard(exact), LIT, slope, wave_height * k / np.sqrt(8.0), GRAZING)
    # A cell that is cut by an edge is told to some 0.2, and its neighbours' skirts reach a gate into the dark.
    assert np.abs(found - exact).mean() < 0.1
    assert abs(found.mean() - exact.mean()) < 0.05
    edges, seen = (np.flatnonzero(np.diff(share > 0.5)) for share in (exact, found[LOOKS // 2]))
    assert edges.size == seen.size > 4
    np.testing.assert_allclose(SPACING * seen, SPACING * edges, atol=CELL)


def test_shadow_is_told_from_faded_speckle() -> None:
    # Stretches of 12 m and five looks, half of them hidden, where Smith lets nearly nine in ten be lit: v = 0.7.
    rng = np.random.default_rng(2)
    lit = np.repeat(np.repeat(rng.random((LOOKS // 5, RANGES.size // 8)) < 0.5, 8, axis=1), 5, axis=0)
    middle = np.arange(lit.shape[1]) % 8
    inside = (middle > 1) & (middle < 6)
    power = lit * rng.exponential(size=lit.shape)
    level = np.full((1, lit.shape[1]), 1.18)  # what `lit_power` gives for exponential speckle
    share = slopes.visible_share(power, level, np.zeros(power.shape), SLOPE_RMS, np.full(level.shape, SLOPE_RMS))
    # 0.86 and 0.03 here; some 700 independent cells of either kind, which scatter by 0.2, leave 0.01.
    assert share[:, inside][lit[:, inside]].mean() > 0.82
    assert share[:, inside][~lit[:, inside]].mean() < 0.07


def test_a_lower_antenna_sees_less() -> None:
    rng = np.random.default_rng(3)
    power = LIT * rng.exponential(size=(LOOKS, RANGES.size))
    slope = rng.normal(scale=0.05, size=power.shape)
    shares = [slopes.visible_share(power, LIT, slope, SLOPE_RMS, h / RANGES[None]) for h in (2.0, 5.0, 10.0)]
    assert (shares[0] < shares[1]).all()
    assert (shares[1] < shares[2]).all()


def test_the_odds_are_smiths_own() -> None:
    # The mean over all slopes of the sea is Smith's S = (1 + erf v)/2(1 + Λ) but for the step in place of erf: with
    # planes that show next to no slope the odds are those of S itself. v = 0.5: S = 0.633731 (Smith 1967).
    grazing = np.full((1, 1), 0.5 * np.sqrt(2.0) * SLOPE_RMS)
    odds = slopes.smith_odds(np.zeros((1, 1)), SLOPE_RMS, grazing)
    np.testing.assert_allclose(odds / (1.0 + odds), 0.633731, rtol=1e-6)


def test_the_looks_have_no_first_one() -> None:
    rng = np.random.default_rng(4)
    power = LIT * rng.exponential(size=(LOOKS, RANGES.size))
    slope = rng.normal(scale=0.05, size=power.shape)
    share = slopes.visible_share(power, LIT, slope, SLOPE_RMS, GRAZING)
    moved = slopes.visible_share(power[5:], LIT, slope[5:], SLOPE_RMS, GRAZING)
    np.testing.assert_allclose(moved[1:], share[6:], rtol=1e-12)
    turned = slopes.visible_share(power[::-1], LIT, slope[::-1], SLOPE_RMS, GRAZING)  # nor a sense of their own
    np.testing.assert_allclose(turned[::-1], share, rtol=1e-12)


@pytest.mark.parametrize("share", [0.1, 0.4, 0.7, 0.95])
def test_crest_bias_is_the_mean_of_what_it_says(share: float) -> None:
    rng = np.random.default_rng(5)
    depth = slopes._DEPTH * SLOPE_RMS * np.sqrt(CELL * np.hypot(CELL, 5.0))
    draws = rng.beta(3.0 * share, 3.0 * (1.0 - share), 200_000)
    excess = depth * rng.exponential(size=draws.size) * (1.0 - draws) ** 2
    bias, spread = slopes.crest_bias(np.array(share), SLOPE_RMS, CELL, 5.0)
    # 200,000 draws of which one in seven is not next to 0, at 0.95, scatter by 5 times their mean: 1.2 %, three times.
    np.testing.assert_allclose(bias, excess.mean(), rtol=0.04)
    np.testing.assert_allclose(spread, excess.std(), rtol=0.04)


def test_crest_bias_grows_with_what_is_hidden() -> None:
    share = np.linspace(0.0, 1.0, 101)
    bias, spread = slopes.crest_bias(share, SLOPE_RMS, CELL, 5.0)
    assert bias[-1] == spread[-1] == 0.0
    assert (np.diff(bias) < 0.0).all()
    assert (slopes.crest_bias(share[:-1], SLOPE_RMS, CELL, 10.0)[0] > bias[:-1]).all()


def test_outliers_do_not_make_the_sea_steep() -> None:
    rng = np.random.default_rng(6)
    slope, spread = rng.normal(scale=0.04, size=(200, 250)), np.full((200, 250), 0.1)
    slope[::40, 3], spread[::40, 3] = 30.0, 1e-4
    # Five planes of 50,000, cut at 0.5 and no heavier than the rest, add 1 % to the rms slope.
    np.testing.assert_allclose(slopes.rms_slope(slope, spread), slopes._STEEPER * 0.04, rtol=0.03)
    assert slopes.rms_slope(np.full((2, 2), np.nan), np.ones((2, 2))) == 0.0


def test_nothing_is_said_of_cells_without_power() -> None:
    power = np.broadcast_to(LIT, (3, RANGES.size)).copy()
    power[1, 7] = np.nan
    found = slopes.shadow(power, LIT, np.zeros(power.shape), SLOPE_RMS, GRAZING, (CELL, WIDTH))
    for field in (found.visible_share, found.crest_bias, found.hidden_std):
        assert np.isnan(field[1, 7])
        assert np.isfinite(np.delete(field, 7, axis=1)).all()


@pytest.mark.parametrize("grazing", [0.01, 0.05, 0.1, 0.2])
def test_what_answers_hides_a_part_of_what_smith_hides(grazing: float) -> None:
    slope, angle = np.linspace(-0.2, 0.2, 9)[None], np.full((1, 9), grazing)
    odds = slopes.smith_odds(slope, SLOPE_RMS, angle)
    hidden = 1.0 / (1.0 + odds)
    share = slopes.visible_share(np.full((1, 9), 1e9), np.ones((1, 9)), slope, SLOPE_RMS, angle)
    # Odds of 10³ squared, times Smith's, are left that so bright a cell is dark: 0.4 % where Smith hides all but 10⁻⁶.
    np.testing.assert_allclose(1.0 - share, slopes._STILL_HIDDEN * hidden, atol=5e-3)
    dark = slopes.visible_share(np.zeros((1, 9)), np.ones((1, 9)), slope, SLOPE_RMS, angle)
    assert (dark < 0.5 * share).all()


def test_noise_in_the_dark_is_no_light() -> None:
    rng = np.random.default_rng(8)
    noise, angle = 0.5, np.full((1, 200), SLOPE_RMS)
    power = noise * rng.standard_normal((LOOKS, 200))  # all dark: what noise leaves of a dwell's power
    slope, lit = np.zeros(power.shape), np.ones((1, 200))
    told, untold = (slopes.visible_share(power, lit, slope, SLOPE_RMS, angle, rms) for rms in (noise, 0.0))
    assert (told <= untold).all()
    assert told.mean() < 0.5 * untold.mean()
