"""Elfouhaily et al. 1997: check values, recomputed from its formulas, and what a spectrum must be."""

from __future__ import annotations

import numpy as np
import pytest

from seamap_rt.sea.spectra import (
    elfouhaily97,
    elfouhaily97_inverse_wave_age,
    elfouhaily97_peak_wavenumber,
    elfouhaily97_spreading,
)

LOG_K = np.linspace(np.log(1e-3), np.log(2e4), 20_001)  # 0.1 % steps: the trapezoid's error is below 1e-5
K = np.exp(LOG_K)


def over_k(density: np.ndarray) -> float:
    return float(np.trapezoid(density * K, LOG_K))


@pytest.mark.parametrize(("wind", "hs", "mss", "up"), [(5.0, 0.648, 0.03167, 0.01894), (10.0, 2.634, 0.06047, 0.03560)])
def test_moments_meet_the_check_values(wind: float, hs: float, mss: float, up: float) -> None:
    s, spread = elfouhaily97(K, wind), elfouhaily97_spreading(K, wind)
    # tolerances: half a unit of the last printed digit
    np.testing.assert_allclose(4.0 * np.sqrt(over_k(s)), hs, rtol=0, atol=5e-4)
    np.testing.assert_allclose(over_k(K**2 * s), mss, rtol=0, atol=5e-6)
    np.testing.assert_allclose(over_k(K**2 * s * (1.0 + spread / 2.0) / 2.0), up, rtol=0, atol=5.5e-6)


def test_spreading_is_a_contrast_and_has_its_two_lobes() -> None:
    spread = elfouhaily97_spreading(K, 10.0)
    assert np.all((spread > 0.0) & (spread <= 1.0))
    peak = elfouhaily97_peak_wavenumber(10.0)
    np.testing.assert_allclose(elfouhaily97_spreading(peak, 10.0), np.tanh(np.log(2.0) / 4.0 + 4.0), atol=1e-6)
    # at U10 = 10 and k = 30, by hand: c = 0.5737, cp = 11.905; a0 = ln2/2 would give 0.34
    by_hand = np.log(2.0) / 4.0 + 4.0 * (0.5737 / 11.905) ** 2.5 + 0.13 * 0.38079 / 0.23 * (0.23 / 0.5737) ** 2.5
    np.testing.assert_allclose(elfouhaily97_spreading(30.0, 10.0), np.tanh(by_hand), atol=1e-4)


def test_peak_enhancement_uses_the_common_logarithm() -> None:
    # by hand at Ωc = 2, U10 = 10, k = kp: (½ · 6e-3 √Ω + Bh) · exp(−1.25) · γ, with γ = 1.7 + 6 log10 2
    kp = 9.81 * 4.0 / 100.0
    c = np.sqrt(9.81 / kp * (1.0 + (kp / 370.0) ** 2))
    u_star = 10.0 * np.sqrt((0.8 + 0.65) * 1e-3)
    level_short = 0.01 * (1.0 + 3.0 * np.log(u_star / 0.23))
    b = 0.5 * 6e-3 * np.sqrt(10.0 / c) + 0.5 * level_short * 0.23 / c * np.exp(-0.25 * (kp / 370.0 - 1.0) ** 2)
    expected = b * np.exp(-1.25) * (1.7 + 6.0 * np.log10(2.0)) / kp**3
    np.testing.assert_allclose(elfouhaily97(kp, 10.0, 2.0), expected, rtol=1e-12)


def test_short_waves_grow_with_the_wind_and_young_seas_are_shorter() -> None:
    bragg = [float(elfouhaily97(400.0, wind)) for wind in (3.0, 5.0, 10.0, 20.0, 40.0)]
    assert np.all(np.diff(bragg) > 0.0)
    assert over_k(elfouhaily97(K, 10.0, 2.0)) < over_k(elfouhaily97(K, 10.0))


def test_fetch_gives_the_wave_age() -> None:
    np.testing.assert_allclose(elfouhaily97_inverse_wave_age(10.0, 1e9), 0.84, rtol=1e-6)
    ages = [elfouhaily97_inverse_wave_age(10.0, fetch) for fetch in (1e4, 1e5, 1e6)]
    assert ages[0] > ages[1] > ages[2] > 0.84


def test_ends_of_the_scale_are_quiet_and_zero() -> None:
    far = np.array([-1.0, 0.0, 1e-300, 1e-100, 1e-6, 1e6, 1e12, np.inf])
    np.testing.assert_array_equal(elfouhaily97(far, 10.0), 0.0)


@pytest.mark.parametrize(("wind", "age"), [(0.0, 0.84), (-1.0, 0.84), (np.nan, 0.84), (10.0, 0.5), (10.0, 6.0)])
def test_refuses_what_the_paper_does_not_cover(wind: float, age: float) -> None:
    with pytest.raises(ValueError, match=r"wind_speed|inverse_wave_age"):
        elfouhaily97(1.0, wind, age)
