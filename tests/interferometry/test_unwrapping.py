"""Cycles of wrapped phases: known seas in the polar grid, with noise, gaps and patches apart, by their laws."""

from __future__ import annotations

import numpy as np
import pytest
from numpy.typing import NDArray

from seamap_rt.conventions import wrap_phase
from seamap_rt.interferometry.ambiguity import (
    CycleEstimate,
    HeightEstimate,
    Neighbourhood,
    ambiguous_gates,
    doubtful_cycle,
    resolve,
    sea_size,
    unwrap,
)

SPACING, LOOKS = 1.5, 200
RANGES = 30.0 + SPACING * np.arange(140.0)  # to 240 m
AZIMUTH = 2.0 * np.pi / LOOKS * np.arange(LOOKS)
ACROSS = RANGES * (AZIMUTH[1] - AZIMUTH[0])
AMBIGUITY = 0.03 * RANGES / 1.8  # of 1.8 m of effective baseline: 0.5 m at 30 m, 4 m at the end
GAIN: NDArray[np.float64] = np.tile(AMBIGUITY / (2.0 * np.pi), (LOOKS, 1)).astype(np.float64)
RNG = np.random.default_rng(5)


def sea(size: float, turned: float = 0.0) -> NDArray[np.float64]:
    """Heights of five plane waves of 25 to 60 m from about the west, of that rms in all."""
    east, north = RANGES * np.sin(AZIMUTH[:, None] + turned), RANGES * np.cos(AZIMUTH[:, None] + turned)
    height = np.zeros(east.shape)
    for n, (length, toward) in enumerate(zip((25.0, 33.0, 40.0, 47.0, 60.0), (0.5, -0.4, 0.2, 0.0, -0.2), strict=True)):
        along = east * np.cos(toward) + north * np.sin(toward)
        height += size * np.sqrt(0.4) * np.cos(2.0 * np.pi / length * along + 2.1 * n)
    return height


def solve(
    height: NDArray[np.float64], noise: float = 0.2, known: NDArray[np.bool_] | None = None, *expected: HeightEstimate
) -> tuple[CycleEstimate, NDArray[np.float64]]:
    """Resolve noisy phases of those heights, of phase slope 1/GAIN; also how many cycles each cell is off."""
    known = np.ones(height.shape, bool) if known is None else known
    phase = height / GAIN + noise * RNG.normal(size=height.shape)
    residual = np.where(known, wrap_phase(phase), np.nan)
    found = resolve(residual, np.full(height.shape, noise), GAIN, known, SPACING, ACROSS, *expected)
    off = np.where(known, residual + 2.0 * np.pi * found.cycles - phase, 0.0) / (2.0 * np.pi)
    np.testing.assert_allclose(off, np.round(off), atol=1e-9)  # rounding of a phase of some 10 rad: 1e-15
    return found, np.round(off)


def shadow(height: NDArray[np.float64]) -> NDArray[np.bool_]:
    """What a mast of 5 m sees of those heights, as far as cells go."""
    tangent = (height - 5.0) / RANGES
    return tangent >= np.maximum.accumulate(tangent, axis=1)


def test_a_sea_beyond_the_ambiguity() -> None:
    height = sea(0.35)
    folded = np.abs(height) > 0.5 * AMBIGUITY
    assert np.mean(folded) > 0.05
    found, off = solve(height)
    # 0.2 rad of noise never reaches half a cycle (16 σ), and the map has no gaps: what is wrong is a wrong path.
    assert not off.any()
    assert np.mean(found.ambiguous) < 0.005


def test_over_shadow() -> None:
    height = sea(0.35)
    seen = shadow(height)
    assert 0.3 < seen.mean() < 0.95
    found, off = solve(height, 0.3, seen)
    # Crests apart are decided by the mean level and the nearest neighbours: some few cells may fail, as many in flags.
    assert np.mean(off[seen] != 0.0) < 0.005
    assert not found.cycles[~seen].any()
    assert not found.ambiguous[~seen].any()


def test_own_cycles_do_not_matter() -> None:
    height, rng = sea(0.35), np.random.default_rng(1)
    residual = wrap_phase(height / GAIN + 0.3 * rng.normal(size=height.shape))
    std, known = np.full(height.shape, 0.3), rng.random(height.shape) < 0.8
    plain = resolve(residual, std, GAIN, known, SPACING, ACROSS)
    moved = resolve(residual + 2.0 * np.pi * 3.0, std, GAIN, known, SPACING, ACROSS)
    np.testing.assert_array_equal(moved.cycles[known], plain.cycles[known] - 3)
    np.testing.assert_array_equal(moved.ambiguous, plain.ambiguous)


def test_a_negative_gain_is_the_same_sea_upside_down() -> None:
    height = sea(0.35)
    residual, std = wrap_phase(height / GAIN), np.full(height.shape, 0.3)
    known = shadow(height)
    up = resolve(residual, std, GAIN, known, SPACING, ACROSS)
    down = resolve(residual, std, -GAIN, known, SPACING, ACROSS)
    np.testing.assert_array_equal(down.cycles, up.cycles)
    before = HeightEstimate(height, np.full(height.shape, 0.1))
    with_turn = resolve(residual, std, -GAIN, known, SPACING, ACROSS, HeightEstimate(-height, before.std))
    np.testing.assert_array_equal(with_turn.cycles, resolve(residual, std, GAIN, known, SPACING, ACROSS, before).cycles)


@pytest.mark.parametrize("by", [50, 117])
def test_looks_in_another_order(by: int) -> None:
    height = sea(0.35)
    residual = wrap_phase(height / GAIN + 0.2 * np.random.default_rng(2).normal(size=height.shape))
    std, known = np.full(height.shape, 0.2), shadow(height)
    plain = resolve(residual, std, GAIN, known, SPACING, ACROSS)
    rolled = [np.roll(field, by, axis=0) for field in (residual, std, GAIN)]
    turned = resolve(rolled[0], rolled[1], rolled[2], np.roll(known, by, axis=0), SPACING, ACROSS)
    away = np.ones(LOOKS, bool)
    for seam in (0, LOOKS - by):  # a patch that a seam cuts in two may be decided otherwise
        away[np.abs((np.arange(LOOKS) - seam + LOOKS // 2) % LOOKS - LOOKS // 2) < 12] = False
    np.testing.assert_array_equal(np.roll(turned.cycles, -by, axis=0)[away], plain.cycles[away])


def test_a_patch_apart_goes_to_mean_level() -> None:
    # Alone in its gates, 14 m from the rest: 0.1 m high where the ambiguity is 1 m: the level alone decides.
    height = np.full(GAIN.shape, 0.1) + sea(0.25)
    near = (RANGES > 58.0) & (RANGES < 66.0)
    known = np.broadcast_to(RANGES > 80.0, height.shape).copy()
    known[40:46, near] = True
    height[40:46, near] = 0.1
    _, off = solve(height, 0.1, known)
    assert not off[40:46, near].any()


def test_what_is_expected_decides() -> None:
    # The same patch a whole ambiguity above the level: another turn or one way's interferogram tells.
    height, known = sea(0.25), np.broadcast_to(RANGES > 80.0, GAIN.shape).copy()
    patch = np.zeros(GAIN.shape, bool)
    patch[40:46, (RANGES > 58.0) & (RANGES < 66.0)] = True
    height[patch] = 1.0
    known |= patch
    _, off = solve(height, 0.1, known)
    assert off[patch].all()
    expected = np.where(patch, height + 0.15 * RNG.normal(size=height.shape), np.nan)
    _, off = solve(height, 0.1, known, HeightEstimate(expected, np.full(height.shape, 0.15)))
    assert not off[patch].any()


def test_noise_alone_is_flagged() -> None:
    residual = RNG.uniform(-np.pi, np.pi, GAIN.shape)
    found = resolve(
        residual, np.full(GAIN.shape, np.pi / np.sqrt(3.0)), GAIN, np.ones(GAIN.shape, bool), SPACING, ACROSS
    )
    assert found.ambiguous.mean() > 0.99


def test_flat_sea_needs_nothing() -> None:
    found, off = solve(np.zeros(GAIN.shape), 0.1)
    assert not off.any()
    assert not found.ambiguous.any()
    assert not ambiguous_gates(GAIN, np.ones(GAIN.shape, bool), 0.01).any()


def test_gates_that_need_it() -> None:
    # ± 5 × 0.1 m leave an ambiguity of 1 m out.
    gates = ambiguous_gates(GAIN, np.ones(GAIN.shape, bool), 0.1)
    np.testing.assert_array_equal(gates, AMBIGUITY < 1.0)
    assert not ambiguous_gates(GAIN, np.zeros(GAIN.shape, bool), 0.1).any()


@pytest.mark.parametrize("shape", [(1, 1), (1, 140), (200, 1), (3, 2)])
def test_small_maps(shape: tuple[int, int]) -> None:
    part = np.s_[: shape[0], : shape[1]]
    height = 0.1 + 0.05 * sea(1.0)[part]
    phase = height / GAIN[part]
    for known in (np.ones(shape, bool), np.zeros(shape, bool)):
        std = np.full(shape, 0.1)
        found = resolve(wrap_phase(phase), std, GAIN[part], known, SPACING, ACROSS[part[1]])
        assert found.cycles.shape == found.ambiguous.shape == shape
        assert not found.ambiguous[~known].any()
        # 0.25 m at most, half an ambiguity at 30 m: nothing to add
        assert not found.cycles.any()


def test_one_look_alone() -> None:
    # As a radar that stares has it: folded near by, gates further out lead in. 1e-9: rounding.
    height, gain = sea(0.35)[20:21], GAIN[20:21]
    residual, known = wrap_phase(height / gain), np.ones(height.shape, bool)
    assert np.count_nonzero(np.abs(height) > 0.5 * AMBIGUITY) > 10
    found = resolve(residual, np.full(height.shape, 0.1), gain, known, SPACING, ACROSS)
    np.testing.assert_allclose((residual + 2.0 * np.pi * found.cycles) * gain, height, atol=1e-9)


@pytest.mark.parametrize("size", [0.2, 0.35, 0.7])
def test_size_of_the_sea(size: float) -> None:
    height = sea(size)
    residual = wrap_phase(height / GAIN)
    # A gate's circle holds some ten waves, neighbouring gates the same ones: ⟨cos⟩, and with it the size, strays by a
    # fifth; half of the gates are spread too widely to count where the sea is 0.7 m.
    assert sea_size(residual, GAIN, np.ones(GAIN.shape, bool)) == pytest.approx(size, rel=0.25)


def swell(length: float = 220.0) -> NDArray[np.float64]:
    """One wave of rms 0.8 m, of which two lie in the circle: within a ring its heights are nothing like Gaussian."""
    return 0.8 * np.sqrt(2.0) * np.sin(2.0 * np.pi / length * RANGES * np.sin(AZIMUTH[:, None]) + 0.7)


def test_a_swell_is_not_taken_for_a_small_sea() -> None:
    residual = wrap_phase(swell() / GAIN)
    assert sea_size(residual, GAIN, np.ones(GAIN.shape, bool)) == pytest.approx(0.8, rel=0.25)


def test_what_is_expected_says_how_high_the_sea_is() -> None:
    """Phases of both ways, all turned: alone they look like a small sea, those of one way know better."""
    height, gain = swell(), 0.25 * GAIN
    known = HeightEstimate(height + 0.03 * RNG.normal(size=height.shape), np.full(height.shape, 0.05))
    phase = wrap_phase(height / gain)
    found = resolve(phase, np.full(gain.shape, 0.2), gain, np.ones(gain.shape, bool), SPACING, ACROSS, known)
    off = np.abs(gain * (phase + 2.0 * np.pi * found.cycles) - height) > 1e-9
    # A step is 0.13 m at 30 m, where 0.03 m leave a cell in forty a cycle off.
    assert np.mean(off & ~found.ambiguous) < 0.01
    assert not off[:, RANGES > 60.0].any()


@pytest.mark.parametrize("across", [0.4, 0.9, 1.1, 2.5])
@pytest.mark.parametrize("looks", [1, 4, 10, 12, 24])
def test_neighbours_are_those_within_the_radius(across: float, looks: int) -> None:
    """10 m, however far apart looks are: a cell 5 m high, which is sure of it, decides another's cycle of 5 m."""
    around = Neighbourhood(SPACING, radius=10.0, most_looks=30, stray=1e-4, slope_precision=1e4)
    wanted = np.zeros((looks + 1, 1), bool)
    wanted[[0, looks]] = True
    folded, noise = np.where(np.arange(looks + 1)[:, None] == 0, 5.0, 0.0), np.full((looks + 1, 1), 1e-4)
    step = np.where(folded > 0.0, 1000.0, 5.0)
    mean, loose = np.zeros(folded.shape), np.full(folded.shape, 1e-2)
    cycles, _ = unwrap(folded, step, noise, mean, loose, wanted, np.array([across]), around)
    assert cycles[0, 0] == 0.0
    assert cycles[looks, 0] == (1.0 if looks * across <= 10.0 else 0.0)


def test_where_a_neighbourhood_does_not_tell_the_cycle() -> None:
    # The sea strays 0.42 m from a mean over 6 m: ½ s² (1 − 2 off)/0.42² is the log odds, 3.0 is twenty to one.
    step = np.array([[1.33, 1.33, 3.5, 3.5, 0.5, 1.33, 1.33]])
    off = np.array([[0.17, 0.21, 0.45, 0.49, 0.0, 1.17, np.nan]])
    np.testing.assert_array_equal(doubtful_cycle(off, step), [[False, True, False, True, True, False, True]])


@pytest.mark.parametrize("baseline", [0.2, 0.35, 0.9, 1.8])
def test_an_echo_that_stands_alone_is_not_called_sure(baseline: float) -> None:
    """Some hundred single echoes, 30–84 m, within 2 m of mean sea level, of both ways: no neighbour tells their cycle,
    nor do they tell how high the sea is. Of those that are called sure none is wrong (a third and more were)."""
    ranges = RANGES[:37]
    gain = np.tile(0.032 * ranges / (4.0 * np.pi * baseline), (LOOKS, 1))
    for seed in range(3):
        rng = np.random.default_rng(seed)
        known = np.zeros(gain.shape, bool)
        known[5 * rng.integers(0, 40, 120), 6 * rng.integers(0, 6, 120)] = True
        height = rng.uniform(-2.0, 2.0, gain.shape)
        phase = wrap_phase(height / gain)
        found = resolve(phase, np.full(gain.shape, 0.05), gain, known, SPACING, ACROSS[:37])
        wrong = np.abs(gain * (phase + 2.0 * np.pi * found.cycles) - height) > 1e-9
        assert (known & wrong).sum() > 5
        assert not (known & wrong & ~found.ambiguous).any()
        calm = 0.05 * height  # within 0.1 m, where a cycle is 0.13 m and more: many together say how small the sea is
        found = resolve(wrap_phase(calm / gain), np.full(gain.shape, 0.05), gain, known, SPACING, ACROSS[:37])
        assert np.mean(found.ambiguous[known]) < (0.05 if baseline < 1.0 else 1.0)
