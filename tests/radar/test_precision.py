"""What a dwell tells: independent looks, and heights by thermal noise."""

from __future__ import annotations

import math
from typing import Any

import pytest

from seamap_rt.conventions import db, radar_wavelength
from seamap_rt.radar import link, precision
from seamap_rt.scene import load_scene
from seamap_rt.settings import RadarSettings


def small(**keys: Any) -> RadarSettings:
    """A small scene's radar with other keys."""
    scene = {"sea.extent_m": 420.0, "sea.resolution_m": 2.0, "radar.range_m": [30.0, 150.0]}
    return load_scene("tiny", scene | {key.replace("__", "."): value for key, value in keys.items()}).radar


def test_looks_reach_from_one_to_the_pulses() -> None:
    radar = small()
    pulses = link.dwell(radar).pulses
    assert precision.looks(radar, math.inf) == pytest.approx(1.0)
    assert precision.looks(radar, 1e-9) == pytest.approx(pulses)
    slow = small(radar__rotation_rpm=1.0)
    # Over a dwell of 0.3 s speckle is new every ∫ ρ² dτ = τc √(π/2); the dwell's ends give another 0.3 %.
    expected = link.dwell(slow).duration_s / (1e-3 * math.sqrt(0.5 * math.pi))
    assert precision.looks(slow, 1e-3) == pytest.approx(expected, rel=0.01)
    assert precision.speckle_db(1.0) == pytest.approx(float(db(2.0)))
    assert precision.speckle_db(1e6) < 0.005


def test_noise_costs_heights_by_the_bound() -> None:
    single = small(radar__transmit="single")
    both = small(radar__interferogram="alternating_pulse", radar__prf_hz=20e3)
    # As many pulses of each receiver, and twice the phase.
    ratio = precision.noise_height_error(single, 10.0, 100.0) / precision.noise_height_error(both, 10.0, 100.0)
    assert ratio == pytest.approx(2.0)
    # √2-fold noise for half the signal, where that is strong.
    weak, strong = (precision.noise_height_error(single, snr, 100.0) for snr in (1e4, 2e4))
    assert weak / strong == pytest.approx(math.sqrt(2.0), rel=1e-4)


def test_a_radian_is_worth_half_with_twice_the_paths_or_the_baseline() -> None:
    both = small(radar__interferogram="alternating_pulse", radar__prf_hz=20e3)
    one = small(radar__transmit="single")
    height = precision.height_per_radian(one, 100.0)
    # λR/(2πB)
    assert height == pytest.approx(radar_wavelength(one.frequency_hz) * 100.0 / (2.0 * math.pi * one.baseline_m))
    assert precision.height_per_radian(both, 100.0) == pytest.approx(0.5 * height)
    assert precision.height_per_radian(small(radar__baseline_m=2.0 * one.baseline_m), 100.0) == pytest.approx(
        0.5 * height
    )
    assert math.isinf(precision.height_per_radian(small(radar__baseline_m=0.0), 100.0))


def test_a_wavelength_there_and_back_is_two_cycles() -> None:
    radar = small()
    speed = radar_wavelength(radar.frequency_hz) / link.dwell(radar).duration_s
    assert precision.doppler_cycles(radar, speed) == pytest.approx(2.0)
