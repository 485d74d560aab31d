"""The evolving surface: statistics, kinematics, direction of travel, and the fast evaluation against the exact sum."""

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from seamap_rt.physics.dispersion import angular_frequency, wavenumber
from seamap_rt.sea import direct_sum, realize, spectra
from seamap_rt.sea.lattice import Lattice, draw_amplitudes
from seamap_rt.settings import FlatWaves, JonswapWaves, SeaSettings, SinusoidWaves

HALF_DAY = 12.0 * 3600.0


def jonswap(**changes):
    return JonswapWaves(**{"spectrum": "jonswap", "significant_wave_height_m": 1.4, "peak_period_s": 5.5, **changes})


def sinusoid(**changes):
    return SinusoidWaves(**{"spectrum": "sinusoid", "height_m": 1.0, "wavelength_m": 20.0, **changes})


def sea_of(*waves, **changes):
    return SeaSettings(**{"resolution_m": 1.0, "extent_m": 256.0, "waves": waves, **changes})


def scattered(count, seed, extent=400.0, duration=1.0):
    rng = np.random.default_rng(seed)
    return rng.uniform(-extent, extent, count), rng.uniform(-extent, extent, count), rng.uniform(0.0, duration, count)


@pytest.fixture(scope="module")
def wind_sea():
    return realize(sea_of(jonswap()), seed=1)


# ------------------------------------------------------------------------------------------------- statistics


@pytest.mark.parametrize("changes", [{}, {"resolution_m": 0.5}, {"extent_m": 512.0}, {"extent_m": 300.0}])
def test_expected_variance_depends_on_the_resolution_only(changes):
    sea = realize(sea_of(jonswap(), **changes), seed=1)
    spectrum = sea.spectrum
    step = float(spectrum.kx[1] - spectrum.kx[0])
    limit = np.pi / changes.get("resolution_m", 1.0)
    # The same integral in the other variable, to the frequency of k = π/resolution.
    omega = np.linspace(1e-3, float(angular_frequency(limit, np.inf)), 200_001)
    expected = np.trapezoid(spectra.jonswap(omega, 1.4, 5.5, 3.3), omega)
    np.testing.assert_allclose(float(spectrum.variance_density.sum()) * step**2, expected, rtol=1e-5)
    np.testing.assert_allclose(sea.resolved.variance, expected, rtol=1e-5)
    np.testing.assert_allclose(sea.resolved.variance_share, expected / (1.4 / 4.0) ** 2, rtol=1e-5)


def test_two_systems_add_their_variances():
    swell = jonswap(significant_wave_height_m=0.8, peak_period_s=7.0, wave_from_deg=200.0, spreading_exponent=50.0)
    crested = jonswap(significant_wave_height_m=0.5, peak_period_s=4.0, spreading="long_crested")
    regular = sinusoid(height_m=0.4)
    together = realize(sea_of(jonswap(), swell, crested, regular), seed=3)
    alone = [realize(sea_of(one), seed=3).resolved for one in (jonswap(), swell, crested, regular)]
    np.testing.assert_allclose(together.resolved.variance, sum(one.variance for one in alone), rtol=1e-12)


def test_finer_resolution_keeps_the_waves_it_had():
    coarse, fine = (realize(sea_of(jonswap(), resolution_m=r), seed=5).components() for r in (2.0, 1.0))
    kept = {
        (round(a, 9), round(b, 9)): value for a, b, value in zip(fine.east, fine.north, fine.amplitude, strict=True)
    }
    same = np.array([kept[round(a, 9), round(b, 9)] for a, b in zip(coarse.east, coarse.north, strict=True)])
    # Up to the rescaling of sums to integrals, which is common to all waves.
    np.testing.assert_allclose(same / coarse.amplitude, (same / coarse.amplitude)[0], rtol=1e-9)
    np.testing.assert_allclose(np.abs(same / coarse.amplitude), 1.0, atol=1e-2)


@pytest.mark.parametrize("azimuth", [200.0, 285.0])
def test_long_crests_slope_along_their_way_alone(azimuth):
    facts = realize(sea_of(jonswap(spreading="long_crested", wave_from_deg=azimuth)), seed=1).resolved
    slopes = facts.slope_std_east, facts.slope_std_north
    way = np.abs([np.sin(np.radians(azimuth)), np.cos(np.radians(azimuth))])
    np.testing.assert_allclose(slopes, np.sqrt(facts.mean_square_slope) * way, rtol=1e-9)


@pytest.mark.parametrize("line", [False, True])
def test_no_two_waves_share_their_random_numbers(line):
    lattice = Lattice(64.0, 1.0, np.inf, line)
    drawn = draw_amplitudes(lattice, np.ones((lattice.north.size, lattice.east.size)), np.random.SeedSequence(4))
    assert np.unique(drawn).size == drawn.size > 10


# ------------------------------------------------------------------------------------------------- reproducibility


def test_same_seed_same_bits_whatever_is_asked_beside(wind_sea):
    x, y, t = scattered(40_000, seed=2, duration=3.0)  # more than a thread takes at once
    elevation, velocity = wind_sea.elevation_and_velocity(x, y, t)
    again = realize(sea_of(jonswap()), np.random.SeedSequence(1))
    np.testing.assert_array_equal(again.elevation_and_velocity(x, y, t)[0], elevation)
    np.testing.assert_array_equal(again.elevation_and_velocity(x, y, t)[1], velocity)
    np.testing.assert_array_equal(again.velocity(x, y, t)[..., 2], again.elevation_rate(x, y, t))
    np.testing.assert_array_equal(again.elevation(x[17], y[17], t[17]), elevation[17])
    np.testing.assert_array_equal(again.velocity(x[::-7], y[::-7], t[::-7]).astype(np.float32), velocity[::-7])


def test_one_seed_sequence_gives_one_sea_and_another_seed_another():
    seed = np.random.SeedSequence(7)
    first, second = realize(sea_of(jonswap()), seed), realize(sea_of(jonswap()), seed)
    np.testing.assert_array_equal(first.components().amplitude, second.components().amplitude)
    other = realize(sea_of(jonswap()), 8).components().amplitude
    correlation = np.vdot(first.components().amplitude, other) / np.sum(np.abs(other) ** 2)
    assert abs(correlation) < 0.2  # about 300 waves carry the variance: 1/√300 = 0.06


# ------------------------------------------------------------------------------------------------- nothing moves


@pytest.mark.parametrize(
    "waves",
    [(), (FlatWaves(spectrum="flat"),), (jonswap(significant_wave_height_m=0.0),), (sinusoid(height_m=0.0),)],
)
def test_no_waves_are_zeros_of_the_right_shape(waves):
    sea = realize(sea_of(*waves), seed=1)
    x, y = np.zeros((3, 1)), np.zeros(4)
    assert sea.elevation(x, y, 0.0).shape == (3, 4)
    assert sea.slopes(x, y, 0.0).shape == (3, 4, 2)
    assert sea.velocity(x, y, 0.0).shape == (3, 4, 3)
    elevation, velocity = sea.elevation_and_velocity(x, y, 1.0)
    assert (elevation.dtype, velocity.dtype, velocity.shape) == (np.float64, np.float32, (3, 4, 3))
    assert not elevation.any()
    assert not velocity.any()
    assert not sea.slopes(x, y, 2.0).any()
    assert sea.resolved.elevation_std == 0.0
    assert sea.components().amplitude.size == 0
    assert sea.spectrum.sizes["kx"] == 0


def test_a_plane_too_small_for_its_waves_is_refused():
    with pytest.raises(ValueError, match="extent_m"):
        realize(sea_of(jonswap(peak_period_s=15.0), extent_m=20.0), seed=1)
    with pytest.raises(ValueError, match="finite"):
        realize(sea_of(jonswap()), seed=1).elevation(np.nan, 0.0, 0.0)


# ------------------------------------------------------------------------------------------------- the sinusoid


@given(
    st.floats(0.05, 30.0).filter(lambda depth: depth > 0.05),
    st.floats(-360.0, 360.0),
    st.floats(-HALF_DAY, HALF_DAY),
    st.floats(-180.0, 180.0),
)
@settings(max_examples=50)
def test_sinusoid_is_its_closed_form(depth, wave_from, time, phase):
    sea = realize(sea_of(sinusoid(wave_from_deg=wave_from, phase_deg=phase), depth_m=depth), seed=1)
    k = 2.0 * np.pi / 20.0
    omega = float(angular_frequency(k, depth))
    x, y, _ = scattered(20, seed=4)
    east, north = -np.sin(np.radians(wave_from)), -np.cos(np.radians(wave_from))
    angle = k * (east * x + north * y) - omega * time + np.radians(phase)
    # 12 h of phase is 1e5 rad, its rounding 1e-11.
    tolerance = 1e-9
    np.testing.assert_allclose(sea.elevation(x, y, time), 0.5 * np.cos(angle), rtol=0.0, atol=tolerance)
    np.testing.assert_allclose(sea.elevation_rate(x, y, time), 0.5 * omega * np.sin(angle), rtol=0.0, atol=tolerance)
    slope = -0.5 * k * np.sin(angle)
    np.testing.assert_allclose(
        sea.slopes(x, y, time), np.stack((slope * east, slope * north), axis=-1), rtol=0.0, atol=tolerance
    )
    flow = 0.5 * omega / np.tanh(k * depth) * np.cos(angle)
    expected = np.stack((flow * east, flow * north, 0.5 * omega * np.sin(angle)), axis=-1)
    np.testing.assert_allclose(sea.velocity(x, y, time), expected, rtol=1e-12, atol=1e-9)


# ------------------------------------------------------------------------------------------------- travel and laws


@pytest.mark.parametrize(
    ("waves", "agreement"),
    [(sinusoid(), 1.0 - 1e-9), (jonswap(spreading_exponent=100.0), 0.4)],
)
def test_waves_from_the_west_travel_east(waves, agreement):
    sea = realize(sea_of(waves), seed=1)
    length = 20.0 if waves.spectrum == "sinusoid" else 2.0 * np.pi / float(wavenumber(2.0 * np.pi / 5.5, np.inf))
    period = 2.0 * np.pi / float(angular_frequency(2.0 * np.pi / length, np.inf))
    x, y = np.meshgrid(np.arange(0.0, 256.0, 2.0), np.arange(0.0, 256.0, 8.0))
    before = sea.elevation(x, y, 0.0).ravel()

    def correlation(distance):
        return np.corrcoef(before, sea.elevation(x + distance, y, period / 4.0).ravel())[0, 1]

    # A quarter period carries the crests a quarter length: downwind they meet, upwind they are in antiphase. A wind
    # sea is broad and one realisation short: its correlation is less than 1, but of the same sign.
    assert correlation(length / 4.0) > agreement
    assert correlation(-length / 4.0) < -agreement


def test_the_waves_grid_is_as_coarse_as_the_heights_may_err():
    finest, allowed = realize(sea_of(jonswap()), seed=1), 0.02
    coarse = realize(sea_of(jonswap()), seed=1, height_error_m=allowed)
    waves = finest.components()
    np.testing.assert_array_equal(coarse.components().amplitude, waves.amplitude)  # the same sea
    assert 2.0 * finest.resolved.elevation_error < coarse.resolved.elevation_error <= 0.05 * allowed
    assert coarse.resolved.slope_error <= 0.05 * max(coarse.resolved.slope_std_east, coarse.resolved.slope_std_north)
    x, y, t = scattered(400, seed=3)
    exact = direct_sum(waves, x, y, t)
    found = np.sqrt(np.mean((coarse.elevation(x, y, t) - exact.elevation) ** 2))
    # An rms of 400 points, ±4 %, whose images are those of one realisation.
    assert found == pytest.approx(coarse.resolved.elevation_error, rel=0.25)
    assert realize(sea_of(jonswap()), seed=1, height_error_m=0.1 * allowed).resolved == finest.resolved


def test_a_sea_of_waves_as_short_as_its_grid_keeps_their_slopes():
    """However much the heights may err: of waves near two points a length a coarse grid's images are as steep."""
    short = sea_of(jonswap(significant_wave_height_m=0.1, peak_period_s=1.7), resolution_m=2.0)
    finest = realize(short, seed=1)
    assert realize(short, seed=1, height_error_m=10.0).resolved == finest.resolved
