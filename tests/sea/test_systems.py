"""Wave systems of a scene as functions: heights, peaks and spreadings are those that were asked for, in any depth."""

from pathlib import Path

import numpy as np
import pytest

from seamap_rt.physics.dispersion import wavenumber
from seamap_rt.sea import directional_density, realize, spectral_system, wave_facts
from seamap_rt.sea.spectra import elfouhaily97_spreading
from seamap_rt.settings import ElfouhailyWaves, FileWaves, JonswapWaves, SeaSettings, SinusoidWaves, TmaWaves

WW3 = Path(__file__).parent.parent / "io" / "spectra" / "ww3.nc"


@pytest.mark.parametrize("depth", [np.inf, 20.0, 6.0, 3.0])
def test_tma_has_the_height_that_was_asked_for_in_any_depth(depth):
    waves = TmaWaves(spectrum="tma", significant_wave_height_m=0.8, peak_period_s=6.0)
    system = spectral_system(waves, depth)
    # 1e-4: of the integrals over the depth factor and over the spectrum's tail.
    np.testing.assert_allclose(4.0 * np.sqrt(system.variance), 0.8, rtol=1e-4)
    jonswap = JonswapWaves(spectrum="jonswap", significant_wave_height_m=0.8, peak_period_s=6.0)
    long, short = wavenumber(2.0 * np.pi / np.array([7.0, 3.0]), depth)
    left = [float(system.radial(k) / spectral_system(jonswap, depth).radial(k)) for k in (long, short)]
    if np.isinf(depth):
        np.testing.assert_allclose(left, 1.0, rtol=1e-4)
    else:
        assert left[0] < left[1]  # long waves lose most to the bed


def test_tma_by_wind_and_fetch_is_jonswap_times_the_depth_factor():
    tma = spectral_system(TmaWaves(spectrum="tma", wind_speed_m_s=10.0, fetch_m=2e4), 4.0)
    jonswap = spectral_system(JonswapWaves(spectrum="jonswap", wind_speed_m_s=10.0, fetch_m=2e4), 4.0)
    omega = np.array([1.2, 2.0, 3.0])
    k = wavenumber(omega, 4.0)
    x = k * 4.0
    factor = np.tanh(x) ** 2 / (1.0 + 2.0 * x / np.sinh(2.0 * x))
    np.testing.assert_allclose(tma.radial(k), jonswap.radial(k) * factor, rtol=1e-4)  # Φ is of gravity alone


def test_steepness_and_stokes_skewness_are_those_of_the_main_peak():
    sea = realize(
        SeaSettings(waves=(JonswapWaves(spectrum="jonswap", significant_wave_height_m=1.4, peak_period_s=5.5),)), 1
    )
    k = float(wavenumber(2.0 * np.pi / 5.5, np.inf))
    np.testing.assert_allclose(sea.resolved.skewness_stokes, 3.0 * k * 1.4 / 4.0, rtol=4e-3)  # peak on a grid of 1e-3
    np.testing.assert_allclose(sea.resolved.significant_steepness, 1.4 * k / (2.0 * np.pi), rtol=4e-3)


@pytest.mark.parametrize("depth", [20.0, 5.0])
def test_a_files_periods_are_kept_in_any_depth(depth):
    waves = FileWaves(spectrum="file", file=str(WW3))
    deep, shallow = wave_facts(waves, np.inf), wave_facts(waves, depth)
    assert deep is not None
    assert shallow is not None
    # The peak is found on a grid of 1e-3 in k.
    np.testing.assert_allclose(shallow.peak_period, deep.peak_period, rtol=3e-3)
    np.testing.assert_allclose(shallow.height, deep.height, rtol=1e-4)
    assert spectral_system(waves, depth).peak_wavenumber > spectral_system(waves, np.inf).peak_wavenumber


@pytest.mark.parametrize("age", [0.84, 2.0, 4.0])
def test_an_elfouhaily_sea_spreads_by_its_own_age(age):
    waves = ElfouhailyWaves(spectrum="elfouhaily", wind_speed_m_s=8.0, inverse_wave_age=age, wave_from_deg=40.0)
    frequency = np.array([0.3, 0.6, 2.0])
    ahead, oblique = directional_density(spectral_system(waves, np.inf), frequency, [40.0, 100.0], np.inf).T
    k = (2.0 * np.pi * frequency) ** 2 / 9.81
    contrast = elfouhaily97_spreading(k, 8.0, age)
    # Surface tension moves k by 4e-4 at 2 Hz.
    np.testing.assert_allclose(oblique / ahead, (1.0 - 0.5 * contrast) / (1.0 + contrast), rtol=1e-3)
    behind = directional_density(spectral_system(waves, np.inf), frequency, [220.0], np.inf)
    assert not behind.any()


@pytest.mark.parametrize("wave_from", [0.0, 90.0, 180.0, 270.0])
def test_waves_exactly_across_an_elfouhaily_sea_are_alike_to_both_sides(wave_from):
    waves = ElfouhailyWaves(spectrum="elfouhaily", wind_speed_m_s=8.0, wave_from_deg=wave_from)
    sea = realize(SeaSettings(waves=(waves,), extent_m=256.0, resolution_m=1.0), 1)
    density = sea.spectrum.variance_density
    line = density.sel(ky=0.0) if wave_from in (0.0, 180.0) else density.sel(kx=0.0)
    np.testing.assert_allclose(line, line[::-1], rtol=1e-9)
    assert np.count_nonzero(line) == line.size - 1


def test_skewness_of_a_regular_stokes_wave():
    wave = SinusoidWaves(spectrum="sinusoid", height_m=0.6, wavelength_m=40.0)
    told = realize(SeaSettings(waves=(wave,)), 1).resolved.skewness_stokes
    k, a = 2.0 * np.pi / 40.0, 0.3
    angle = 2.0 * np.pi * np.arange(1000) / 1000
    eta = a * np.cos(angle) + 0.5 * k * a**2 * np.cos(2.0 * angle)
    # To second order: the next is (ka)² = 2e-3 of it.
    np.testing.assert_allclose(told, np.mean(eta**3) / np.mean(eta**2) ** 1.5, rtol=4e-3)


def test_a_patch_that_samples_its_waves_badly_says_so():
    swell = JonswapWaves(spectrum="jonswap", significant_wave_height_m=1.0, peak_period_s=15.0)
    small, large = (realize(SeaSettings(waves=(swell,), extent_m=e, resolution_m=4.0), 1) for e in (256.0, 4096.0))
    assert small.resolved.carried_share < 0.95
    np.testing.assert_allclose(large.resolved.carried_share, 1.0, atol=2e-3)


def test_shares_stay_within_one_beyond_the_capillaries():
    ripples = JonswapWaves(spectrum="jonswap", significant_wave_height_m=0.02, peak_period_s=0.6)
    resolved = realize(SeaSettings(waves=(ripples,), extent_m=10.0, resolution_m=0.006), 1).resolved
    assert 0.5 < resolved.mean_square_slope_share < 1.0 + 1e-3  # the lattice's ragged rim
    assert resolved.variance_share <= 1.0
