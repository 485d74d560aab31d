"""Spectra and spreading against published numbers and their own integrals."""

import numpy as np
import pytest

from seamap_rt.conventions import GRAVITY
from seamap_rt.physics.dispersion import angular_frequency, wavenumber
from seamap_rt.sea import spectra
from seamap_rt.sea.spreading import cos2s

OMEGA = np.geomspace(1e-2, 2e3, 400_001)


def height(spectrum):
    """4 √m0 by the trapezoidal rule in ln ω; the tail beyond 2000 rad/s holds (ωp/ω)⁴ of it."""
    return 4.0 * np.sqrt(np.trapezoid(spectrum * OMEGA, np.log(OMEGA)))


def test_pierson_moskowitz_height_at_10_m_s():
    np.testing.assert_allclose(height(spectra.pierson_moskowitz(OMEGA, wind_speed=10.0)), 2.245, atol=5e-4)


def test_bretschneider_agrees_with_wafo():
    found = spectra.pierson_moskowitz_scaled([1.0, 2.0, 3.0], 6.5, 10.0)
    np.testing.assert_allclose(found, [1.69350993, 0.06352698, 0.00844783], rtol=0.0, atol=5.1e-9)


@pytest.mark.parametrize("gamma", [1.0, 1.5, 3.3, 7.0, 20.0])
@pytest.mark.parametrize(("hs", "tp"), [(1.4, 5.5), (10.0, 15.0), (0.05, 0.5)])
def test_jonswap_has_the_height_that_was_asked(gamma, hs, tp):
    # The rule of sums, 3e-5 apart in ln ω, misses the jump of the peak's curvature by less than 1e-8.
    np.testing.assert_allclose(height(spectra.jonswap(OMEGA, hs, tp, gamma)), hs, rtol=1e-7)
    peak = OMEGA[np.argmax(spectra.jonswap(OMEGA, hs, tp, gamma))]
    np.testing.assert_allclose(peak, 2.0 * np.pi / tp, rtol=1e-4)


def test_jonswap_by_fetch_has_its_peak_and_its_tail():
    wind, fetch = 10.0, 50e3
    relative = GRAVITY * fetch / wind**2
    spectrum = spectra.jonswap_fetch(OMEGA, wind, fetch)
    peak = 2.0 * np.pi * 3.5 * relative**-0.33 * GRAVITY / wind
    np.testing.assert_allclose(OMEGA[np.argmax(spectrum)], peak, rtol=1e-4)
    # Far above the peak only α g² ω⁻⁵ is left; exp(−1.25 (ωp/ω)⁴) is 1 to 1e-9 at 200 times the peak.
    tail = 0.076 * relative**-0.22 * GRAVITY**2 * (200.0 * peak) ** -5
    np.testing.assert_allclose(spectra.jonswap_fetch(200.0 * peak, wind, fetch), tail, rtol=1e-8)


def test_tma_factor():
    k = wavenumber(1.0, 5.0, surface_tension=0.0)
    np.testing.assert_allclose(k, 0.156104, atol=5.1e-7)
    np.testing.assert_allclose(spectra.tma_depth_factor(1.0, 5.0), 0.252977, atol=5.1e-7)
    ratio = spectra.tma(1.0, 2.0, 8.0, 3.3, 5.0) / spectra.jonswap(1.0, 2.0, 8.0, 3.3)
    np.testing.assert_allclose(ratio, 0.252977, atol=5.1e-7)
    # Deep and shallow limits: Φ = 1 and Φ = ω²h/(2g), the next term being (kh)² smaller.
    np.testing.assert_allclose(spectra.tma_depth_factor([5.0, 50.0], 1e4), 1.0, rtol=1e-14)
    np.testing.assert_allclose(spectra.tma_depth_factor([5.0, 50.0], np.inf), 1.0, rtol=1e-14)
    np.testing.assert_allclose(spectra.tma_depth_factor(1e-3, 1.0), 1e-6 / (2.0 * GRAVITY), rtol=1e-6)


@pytest.mark.parametrize("depth", [0.5, 10.0, np.inf])
def test_wavenumber_form_keeps_the_variance(depth):
    k = wavenumber(OMEGA, depth)
    spectrum = spectra.wavenumber_spectrum(lambda omega: spectra.jonswap(omega, 1.4, 5.5), k, depth)
    np.testing.assert_allclose(4.0 * np.sqrt(np.trapezoid(spectrum * k, np.log(k))), 1.4, rtol=1e-7)
    np.testing.assert_allclose(angular_frequency(k, depth), OMEGA, rtol=2e-14)


def test_spectra_are_zero_where_no_wave_is():
    still = np.array([-1.0, 0.0, 1e-300])
    for spectrum in (
        spectra.pierson_moskowitz(still, wind_speed=10.0),
        spectra.jonswap(still, 1.0, 5.0),
        spectra.jonswap_fetch(still, 10.0, 1e4),
        spectra.tma(still, 1.0, 5.0, 3.3, 5.0),
        spectra.jonswap(OMEGA, 0.0, 5.0),
    ):
        np.testing.assert_array_equal(spectrum, 0.0)


def test_impossible_seas_raise():
    with pytest.raises(ValueError, match="wind_speed"):
        spectra.pierson_moskowitz(1.0, wind_speed=0.0)
    with pytest.raises(ValueError, match="hs"):
        spectra.jonswap(1.0, -1.0, 5.0)
    with pytest.raises(ValueError, match="tp"):
        spectra.jonswap(1.0, 1.0, 0.0)
    with pytest.raises(ValueError, match="exponent"):
        cos2s(0.0, -1.0)


@pytest.mark.parametrize("exponent", [0.0, 0.5, 1.0, 10.0, 85.5, 500.0])
def test_cos2s_integrates_to_one_about_its_mean_direction(exponent):
    # A periodic rule of 4096 points is exact for whole s up to 4095; s = 0.5 has a kink of slope at π: error n⁻².
    angle = 2.0 * np.pi * np.arange(4096) / 4096 - np.pi
    weight = cos2s(angle - 0.7, exponent) * (2.0 * np.pi / 4096)
    np.testing.assert_allclose(weight.sum(), 1.0, rtol=1e-6 if exponent == 0.5 else 1e-11)
    mean = np.sum(weight * np.exp(1j * angle))
    # First trigonometric moment of cos^2s(θ/2): s/(s + 1).
    np.testing.assert_allclose(np.abs(mean), exponent / (exponent + 1.0), atol=1e-6 if exponent == 0.5 else 1e-11)
    if exponent:
        np.testing.assert_allclose(np.angle(mean), 0.7, atol=1e-6)
