"""Breakers as single events: what they add up to, and how spiky the closed form says they are."""

from __future__ import annotations

import numpy as np
import pytest

from seamap_rt.scattering import clutter_shape_watts_wicks90
from seamap_rt.scattering.breaking import breaker_motion, breakers
from seamap_rt.scattering.sea_spikes import SeaSpikes, sea_spikes

X_BAND = 10e9


def spikes(wind: float = 8.0, age: float = 0.84) -> SeaSpikes:
    found = sea_spikes(wind, age, X_BAND)
    assert found is not None
    return found


@pytest.mark.parametrize("wind", [4.0, 8.0, 15.0])
def test_they_are_the_breaking_sea_cut_into_pieces(wind: float) -> None:
    """Area, mean speed and direction are those of the breaking share; 2 % is the width of a class of half an octave."""
    found, whole = spikes(wind), breakers(wind, 0.84, X_BAND)
    assert found.fraction == pytest.approx(whole.fraction, rel=1e-12)
    np.testing.assert_allclose(found.density * found.zone_m2, found.fraction * found.share, rtol=1e-12)
    assert 0.1 < found.remaining_share < 0.7
    downwind = np.mean(np.cos(found.angle), axis=1)
    speed = found.remaining_share * found.left_speed + np.sum(found.share * found.speed * downwind)
    assert speed == pytest.approx(breaker_motion(wind, 0.84, X_BAND)[0], rel=0.02)
    assert np.median(found.angle) == pytest.approx(0.0, abs=1e-6)


def test_lengths_lives_and_speeds_are_those_of_their_waves() -> None:
    """Lives of 0.3 periods: 0.1 to 1 s, as spikes are reported to have. The fastest run at half the peak's speed, as
    Korinenko et al. (2018) saw on developed seas, and at all of it on young ones."""
    found = spikes()
    np.testing.assert_allclose(found.speed**2, 9.81 * found.wavelength / (2.0 * np.pi), rtol=0.01)
    np.testing.assert_allclose(found.life_s, 0.3 * found.wavelength / found.speed, rtol=0.01)
    assert 0.1 < found.life_s.min() < 0.2
    assert 0.8 < found.life_s.max() < 1.0
    peak = 8.0 / 0.84
    assert 0.44 * peak < found.speed.max() <= 0.5 * peak
    assert spikes(8.0, 1.68).speed.max() > 0.85 * 8.0 / 1.68


def test_the_closed_form_gives_the_law_of_watts_and_wicks() -> None:
    """At 200 m from 5 m, where the wave texture matters least: within the law's own factor of three, and what the
    choice of a crest's length is good to. The shape is ∝ the cell."""
    found = spikes()
    area = np.radians(1.8) * 200.0 * 3.0
    law = clutter_shape_watts_wicks90(np.degrees(np.arcsin(5.0 / 200.0)), area, "HH")
    assert 1.0 < float(found.shape(area)) / law < 3.0
    assert float(found.shape(2.0 * area)) == pytest.approx(2.0 * float(found.shape(area)))


def test_no_wind_no_spikes() -> None:
    assert sea_spikes(1.0, 0.84, X_BAND) is None
