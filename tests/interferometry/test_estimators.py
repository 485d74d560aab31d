"""Heights of seas that are drawn with their speckle: what each estimator makes of them, and of its own errors."""

from __future__ import annotations

from dataclasses import replace
from functools import cache

import numpy as np
import pytest
from numpy.typing import NDArray
from synthetic_seas import MAST, WAVELENGTH, Heard, Waves, heard

from seamap_rt.interferometry.ambiguity import HeightEstimate
from seamap_rt.interferometry.error_covariance import ErrorCovariance
from seamap_rt.interferometry.estimators import (
    ESTIMATORS,
    Estimate,
    adaptive,
    mean_plane,
    single_cell,
    sliding_plane,
)
from seamap_rt.interferometry.estimators import _ground_step as ground_step

Array = NDArray[np.float64]
RMS = 0.35
RADAR = heard(lambda x, y: 0.0 * x, 1, coherence=None, looks=2, gates=9).given.model.radar


@cache
def speckled(seed: int, noise: float) -> Heard:
    return heard(Waves.drawn(seed, RMS, shortest=14.0), seed, coherence=0.99, samples=2, noise=noise)


def errors(estimate: Estimate, sea: Heard) -> Array:
    return np.where(estimate.echoing, estimate.heights.height - sea.height, np.nan)


def inner(field: Array) -> Array:
    """Without what windows at the edges are short of."""
    return field[3:-3, 4:-4]


@pytest.mark.parametrize("noise", [0.0, 0.1])
def test_what_adapts_is_best(noise: float) -> None:
    # Per seed 54 looks by 112 gates, so that rms errors are good to some 2 %: their order is no chance.
    for seed in (1, 2):
        sea = speckled(seed, noise)
        rms = [
            float(np.sqrt(np.nanmean(inner(errors(each(sea.given), sea)) ** 2)))
            for each in (adaptive, sliding_plane, single_cell)
        ]
        # The less an echo is disturbed, the less is there to be weighed.
        assert rms[0] < (0.8 if noise else 0.96) * rms[1]
        assert rms[1] < 0.8 * rms[2]


@pytest.mark.parametrize("told", [False, True])
def test_a_phase_that_turns_within_the_pulse_is_never_sure(told: bool) -> None:
    # Of both ways, or, where one way's heights tell the cycle, of that one: it turns half as fast.
    sea = heard(Waves.drawn(4, RMS), 4, baseline=1.5)
    one_way = HeightEstimate(sea.height, np.full(sea.height.shape, 0.05))
    given = replace(sea.given, others=lambda: (one_way,) if told else ())
    found = sliding_plane(given)
    turn = np.broadcast_to(given.model.turn_within_pulse / (2.0 if told else 1.0), sea.height.shape)
    near = (turn > 1.0) & found.echoing & np.isfinite(found.heights.height)
    assert np.count_nonzero(near) > 100
    assert found.ambiguous[near].all()
    assert found.ambiguous[turn < 0.5].mean() < 0.5


@pytest.mark.parametrize("samples", [1, 3])
@pytest.mark.parametrize("baseline", [0.1, 0.3, 0.9])
def test_single_dwells_err_as_said(baseline: float, samples: int) -> None:
    """From 30 m on, where 0.9 m of baseline turn the phase by 1.9 rad within the pulse's spread."""
    level = heard(lambda x, y: 0.0 * x, 3, coherence=0.999, samples=samples, baseline=baseline)
    found = adaptive(level.given)
    assert found.dwells is not None
    off = inner(np.where(found.ambiguous, np.nan, found.dwells[0] / found.dwells[1]))
    turn = np.broadcast_to(inner(np.broadcast_to(level.given.model.turn_within_pulse, (60, 120))), off.shape)
    for low, high in ((0.0, 0.2), (0.2, 0.6), (0.6, 1.0)):
        those = (turn > low) & (turn <= high) & np.isfinite(off)
        if np.count_nonzero(those) > 200:
            # A window of 10 to 30 samples says its incoherent power to a fifth, and that much is added.
            assert 0.75 < np.sqrt(np.mean(np.clip(off[those], -5.0, 5.0) ** 2)) < 1.1


@pytest.mark.parametrize("noise", [0.0, 0.1])
def test_errors_are_what_it_says(noise: float) -> None:
    for estimator in (adaptive, single_cell):
        ratio = []
        for seed in (1, 2):
            sea = speckled(seed, noise)
            estimate = estimator(sea.given)
            ratio.append(inner(errors(estimate, sea) / estimate.std).ravel())
        ratio = np.concatenate(ratio)
        ratio = ratio[np.isfinite(ratio)]
        # Of waves shorter than 14 m, which there are none of here, it reckons with some.
        assert 0.6 < 1.4826 * np.median(np.abs(ratio)) < 1.15
        assert 0.92 < np.mean(np.abs(ratio) < 1.96) < 0.998
        assert abs(np.mean(ratio)) < 0.1


# --------------------------------------------------------------------------------------------------- mean sea level


@pytest.mark.parametrize("estimator", ESTIMATORS)
@pytest.mark.parametrize(("offset", "slope"), [(0.0, 0.0), (0.7, 0.0), (-0.5, 0.0), (0.2, 0.004)])
def test_a_sea_that_lies_high_or_askew(estimator: str, offset: float, slope: float) -> None:
    # Without speckle. A window's mean of phases along a plane is that in its middle, but for what mean sea level itself
    # bends within three gates at 30 m: φ″ (1.5 m)²/2 = 0.2 rad of 4 rad of it; along the slope's own change 1 cm.
    sea = heard(lambda x, y: offset + slope * x - 0.5 * slope * y, 1, coherence=None)
    estimate = ESTIMATORS[estimator](sea.given)
    off = errors(estimate, sea)
    assert np.isfinite(off).all()
    # Single dwells and gates are not averaged: optimal interpolation is off by what waves it sees in the remainder.
    assert np.abs(off).max() < (2e-5 if estimator == "adaptive" else 0.02)


def white(variance: Array) -> ErrorCovariance:
    """Errors of that variance, each for itself."""
    nothing = np.zeros(variance.shape)
    return ErrorCovariance(np.stack((nothing, nothing, np.sqrt(variance))), np.ones((3, 1)), 0.0)


def test_the_doubt_of_a_mean_plane_is_how_far_it_strays() -> None:
    rng = np.random.default_rng(3)
    x, y = rng.uniform(-200.0, 200.0, (2, 30, 40))
    variance = rng.uniform(0.01, 2.0, x.shape)
    stray = [
        mean_plane(0.1 * rng.normal(size=x.shape) + np.sqrt(variance) * rng.normal(size=x.shape), white(variance), x, y)
        for _ in range(300)
    ]
    # 300 planes give the variance to 8 %; waves of 0.1 m, drawn for each cell alone, add a hundredth.
    got = np.var([each for each, _ in stray], axis=0)
    np.testing.assert_allclose(got.mean(), np.mean([doubt for _, doubt in stray]), rtol=0.25)


def test_a_mean_plane_does_not_follow_the_wave_about_the_boat() -> None:
    # A swell longer than the circle whose near half is known best: a plane of its own cells would lie along it.
    away, bearing = np.meshgrid(np.arange(15.0, 200.0, 3.0), np.radians(np.arange(0.0, 360.0, 2.0)))
    x, y = away * np.sin(bearing), away * np.cos(bearing)
    swell = 0.2 * np.sin(2.0 * np.pi * x / 225.0)
    plane, _ = mean_plane(swell, white((0.01 * (away / 50.0) ** 4) ** 2 + 1e-4), x, y)
    # Laid by the near cells it would be twice as high at the far ones as the swell itself.
    assert np.std(plane) < 0.5 * np.std(swell)


def test_a_mean_plane() -> None:
    rng = np.random.default_rng(2)
    x, y = rng.uniform(-200.0, 200.0, (2, 30, 40))
    plane, variance = 0.3 + 0.01 * x - 0.004 * y, rng.uniform(0.01, 2.0, x.shape)
    height = plane.copy()
    height[3:5] = np.nan
    variance[7, 8] = np.nan
    x[9, 9] = np.nan
    found, _doubt = mean_plane(height, white(variance), x, y)
    known = np.isfinite(x)
    np.testing.assert_allclose(found[known], plane[known], rtol=0, atol=1e-9)  # where heights are unknown as well
    assert np.isfinite(found).all()
    # Weighted: heights that are off by metres, and say so, hardly move it.
    bad = np.where(rng.random(x.shape) < 0.3, 1e6, 0.01)
    moved, _ = mean_plane(plane + np.where(bad > 1.0, 5.0, 0.0), white(bad), x, y)
    np.testing.assert_allclose(moved[known], plane[known], rtol=0, atol=1e-3)
    # Two cells span none, cells on a line no slope across it.
    two = np.full(x.shape, np.nan)
    two[0, :2] = 1.0
    np.testing.assert_array_equal(mean_plane(two, white(variance), x, y)[0], 0.0)
    along = np.broadcast_to(np.arange(40.0), x.shape)
    line, _ = mean_plane(np.full(x.shape, 2.0), white(np.ones(x.shape)), along, 0.0 * y)
    np.testing.assert_allclose(line, 2.0, rtol=0, atol=1e-9)


# -------------------------------------------------------------------------------------------------------- cycles


@cache
def folded(ambiguity: str, seed: int = 4) -> Heard:
    """A sea of 0.6 m rms, whose crests pass half an ambiguity of 2 B = 1.2 m, 0.38 m at 30 m."""
    return heard(
        Waves.drawn(seed, 0.6, shortest=30.0), seed, samples=4, coherence=0.9999, baseline=0.6, ambiguity=ambiguity
    )


def test_phases_follow_their_cycles() -> None:
    sea = folded("resolve")
    wide = np.abs(sea.height) > 0.5 * np.pi * 2.0 * np.broadcast_to(
        single_cell(sea.given).heights.gain, sea.height.shape
    )
    assert wide.mean() > 0.04
    start, found = sliding_plane(sea.given), adaptive(sea.given)
    sure = ~found.ambiguous & found.echoing
    assert sure.mean() > 0.8
    assert np.mean(np.abs(errors(found, sea))[sure] > 0.15) < 0.01
    np.testing.assert_array_equal(found.ambiguous, start.ambiguous)


@pytest.mark.parametrize("estimator", ["single_cell", "sliding_plane"])
def test_folded_phases_stay_folded(estimator: str) -> None:
    sea = folded("fold")
    found = ESTIMATORS[estimator](sea.given)
    assert not found.ambiguous.any()
    residual = found.heights.phase - sea.given.model.flat
    assert (np.abs(residual) <= np.pi + 1e-9).all()
    # By whole ambiguities from what they are.
    turns = (sea.height / (2.0 * np.pi * found.heights.gain))[np.abs(errors(found, sea)) > 0.3]
    assert turns.size > 300
    assert np.mean(np.abs(turns) > 0.4) > 0.95


def test_others_are_asked_only_if_need_be() -> None:
    asked: list[int] = []
    calm = heard(Waves.drawn(6, 0.1), 6)  # 5 times 0.1 m are less than half an ambiguity, 1.1 m at 30 m
    for sea, needed in ((calm, False), (folded("fold"), False), (folded("resolve"), True)):
        asked.clear()

        def others(truth: Array = sea.height) -> tuple[HeightEstimate, ...]:
            asked.append(1)
            return (HeightEstimate(truth, np.full(truth.shape, 0.05)),)

        found = single_cell(replace(sea.given, others=others))
        assert bool(asked) == needed
        if needed:  # what they tell is believed: none is a cycle off
            assert np.mean(np.abs(errors(found, sea)) > 0.3) < 0.002
            assert np.mean(found.ambiguous) < 0.01


# ------------------------------------------------------------------------------------------------------- windows


def test_a_window_that_follows_the_waves_finds_them_coherent() -> None:
    # Waves so steep that in a single dwell and gate nothing is lost, yet along mean sea level much is.
    sea = heard(Waves.drawn(5, 0.5, shortest=25.0), 5, coherence=None, baseline=0.6)
    level, along = single_cell(sea.given), sliding_plane(sea.given)
    assert np.mean(inner(along.incoherent)) < 0.3 * np.mean(inner(level.incoherent))
    off = [np.sqrt(np.mean(inner(errors(each, sea)) ** 2)) for each in (level, along)]
    assert off[1] < 0.05


@pytest.mark.parametrize("slope", [-0.3, 0.0, 0.1, 0.25])
def test_the_step_to_the_next_gate(slope: float) -> None:
    # Along z = slope (x − 30), by finite differences of R² = x² + (H − z)²; of gates that lie close together.
    def distance(x: float) -> float:
        return float(np.hypot(x, MAST - slope * (x - 30.0)))

    radar = replace(RADAR, ranges=distance(30.0) + 1e-6 * np.arange(2.0))
    per_metre = (distance(30.0 + 1e-4) - distance(30.0 - 1e-4)) / 2e-4
    found = ground_step(radar, *(np.full((1, 2), each) for each in (30.0, MAST, slope)))
    np.testing.assert_allclose(found, 1e-6 / per_metre, rtol=1e-6)


def test_the_step_keeps_within_three_gates() -> None:
    # Where the surface faces the radar squarely, at a slope of x/H, and beyond; an unknown slope is none.
    ground = np.sqrt(RADAR.ranges**2 - MAST**2)[None]
    for slope, asked in ((0.99 * ground / MAST, 3.0), (50.0, 3.0), (np.nan, RADAR.ranges / ground)):
        found = ground_step(RADAR, ground, np.full(ground.shape, MAST), np.broadcast_to(slope, ground.shape))
        np.testing.assert_allclose(found, 1.5 * np.broadcast_to(asked, ground.shape), rtol=1e-12)


def test_unheard_cells_stay_unheard() -> None:
    sea = speckled(3, 0.0)
    dwell = sea.given.dwell
    holed = replace(dwell, cross=dwell.cross.copy())
    holed.cross[20:22] = np.nan
    for estimator in ESTIMATORS.values():
        found = estimator(replace(sea.given, dwell=holed, echo=replace(sea.given.echo, pulses=holed)))
        assert not found.echoing[20:22].any()
        assert np.isnan(found.heights.height[20:22]).all()
        assert np.isfinite(found.heights.height[found.echoing]).all()
        assert (found.std[found.echoing] > 0.0).all()


def test_a_wavelength_is_three_centimetres() -> None:
    # The yardstick itself: 2 ways, B = 0.2 m, 60 m off, 0.1 m: 2k ΔR, ΔR = B sin of the angle below the horizon.
    flat, high = (heard(lambda x, y, z=z: z + 0.0 * x, 1, coherence=None).given.dwell.cross[0, 20] for z in (0.0, 0.1))
    turn = 2.0 * 2.0 * np.pi / WAVELENGTH * 0.2 * 0.1 / 60.0
    assert np.angle(flat / high) == pytest.approx(turn, rel=0.02)
