"""The resolved waves by wavenumber: their moments, and what a still sea, strain and lost slopes come to."""

from __future__ import annotations

import math
from dataclasses import replace
from typing import Any

import numpy as np
import pytest

from seamap_rt.conventions import GRAVITY
from seamap_rt.scene import Scene, load_scene
from seamap_rt.sea import ResolvedSea, ResolvedWaves, realize

SMALL = {"sea.extent_m": 420.0, "sea.resolution_m": 2.0, "radar.range_m": [30.0, 150.0]}
ONE_WAVE = {"sea.waves": [{"spectrum": "sinusoid", "height_m": 1.0, "wavelength_m": 40.0, "wave_from_deg": 270.0}]}


def small(**keys: Any) -> tuple[Scene, ResolvedSea]:
    """A small scene with other keys, and its sea."""
    scene = load_scene("tiny", SMALL | {key.replace("__", "."): value for key, value in keys.items()})
    return scene, realize(scene.sea, 1).resolved


def resolved_waves(**keys: Any) -> ResolvedWaves:
    scene, resolved = small(**keys)
    return ResolvedWaves.of(scene.sea, resolved.wavenumber_limit)


def test_waves_have_the_sea_s_variance_and_slope() -> None:
    scene, resolved = small()
    waves = ResolvedWaves.of(scene.sea, resolved.wavenumber_limit)
    # The trapezoid rule over 4001 steps of ln k, and for slopes the lattice's own samples (1 % for so small a patch).
    assert waves.variance.sum() == pytest.approx(resolved.variance, rel=1e-4)
    assert np.sum(waves.variance * waves.wavenumber**2) == pytest.approx(resolved.mean_square_slope, rel=0.01)


def test_a_still_sea_errs_by_nothing_at_once_and_by_root_two_in_the_end() -> None:
    waves = resolved_waves()
    assert waves.still_sea_error(0.0) == 0.0
    # 1 − sinc is 1 to 2/(ωT), of waves with ω > 0.8 rad/s.
    limit = math.sqrt(2.0) * waves.elevation_std
    assert waves.still_sea_error(4000.0) == pytest.approx(limit, rel=1e-3)
    # To the first order it moves on by its vertical speed, the rms time from half-way being T/√12.
    speed = math.sqrt(float(np.sum(waves.variance * waves.frequency**2)))
    assert waves.still_sea_error(0.01) == pytest.approx(speed * 0.01 / math.sqrt(12.0), rel=1e-3)


def test_a_still_sea_errs_as_a_regular_wave_does() -> None:
    waves = resolved_waves(**ONE_WAVE)
    duration, omega = 3.0, math.sqrt(GRAVITY * 2.0 * math.pi / 40.0)
    time = (np.arange(2000) + 0.5) / 2000 * duration - 0.5 * duration
    phase = 2.0 * np.pi * np.arange(64)[:, None] / 64
    moved = 0.5 * (np.cos(phase - omega * time) - np.cos(phase))
    # Surface tension is not in ω here: 2e-6 of it.
    assert waves.still_sea_error(duration) == pytest.approx(float(np.sqrt(np.mean(moved**2))), rel=1e-4)


def test_waves_on_a_current_as_fast_against_them_stand_still() -> None:
    speed = math.sqrt(GRAVITY * 40.0 / (2.0 * math.pi))  # 7.9 m/s towards the east, where the waves go
    waves = resolved_waves(**ONE_WAVE, sea__current_m_s=speed, sea__current_toward_deg=270.0)
    # What surface tension adds to the phase speed: 2e-6 of ω, 5e-5 rad over the time.
    assert waves.still_sea_error(20.0) < 1e-4 * waves.elevation_std


def test_half_the_water_s_speed_lies_along_the_look() -> None:
    waves = resolved_waves(**ONE_WAVE)
    omega = math.sqrt(GRAVITY * 2.0 * math.pi / 40.0)
    # aω/√2 along the waves, nothing across them; surface tension as above.
    assert waves.orbital_speed() == pytest.approx(0.5 * omega / 2.0, rel=1e-5)


def test_half_of_the_slopes_square_lies_along_the_look() -> None:
    # Amplitude a, look at φ from the way of the wave: slope a k cos φ, whose mean square is (a k)²/2 · cos² φ.
    _, resolved = small(**ONE_WAVE)
    looks = np.arange(16) * (2.0 * np.pi / 16)
    expected = np.mean(0.5 * (0.5 * 2.0 * np.pi / 40.0 * np.cos(looks)) ** 2)
    assert resolved.look_slope_variance == pytest.approx(expected, rel=1e-12)  # both are closed forms


def test_slopes_are_lost_below_the_spacing_only() -> None:
    scene, resolved = small()
    waves = ResolvedWaves.of(scene.sea, resolved.wavenumber_limit)
    assert waves.slopes_lost(scene.sea.resolution_m or 0.0) == 0.0
    # All of them in the end, to the lattice's own samples.
    assert waves.slopes_lost(1e4) == pytest.approx(math.sqrt(0.5 * resolved.mean_square_slope), rel=0.01)


def test_second_order_waves_have_the_height_that_is_said() -> None:
    rng = np.random.default_rng(1)
    std, k = 0.3, 0.13
    elevation, transform = std * rng.standard_normal((2, 400_000))
    bound = 0.5 * k * (elevation**2 - transform**2)
    # Of so many draws the standard deviation is good to 0.3 %.
    resolved = replace(small()[1], elevation_std=std, significant_steepness=4.0 * std * k / (2.0 * np.pi))
    assert resolved.second_order_std == pytest.approx(float(np.std(bound)), rel=0.01)
    assert resolved.peak_length == pytest.approx(2.0 * np.pi / k)


def test_strain_of_a_regular_wave_and_its_relaxation() -> None:
    waves = resolved_waves(**ONE_WAVE)
    # Without relaxation the strain is ak cos²: rms √(3/8) ak/√2.
    assert waves.strain_std(0.0) == pytest.approx(math.sqrt(0.375) * 0.5 * 2.0 * math.pi / 40.0 / math.sqrt(2.0))
    assert waves.strain_std(100.0) < 0.02 * waves.strain_std(0.0)
