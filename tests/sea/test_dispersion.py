"""The dispersion relation against published numbers, its own inverse and its limits."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from seamap_rt.conventions import GRAVITY, SURFACE_TENSION, WATER_DENSITY
from seamap_rt.physics.dispersion import Water, angular_frequency, group_speed, wavenumber


@pytest.mark.parametrize(
    ("depth", "printed", "last_digit"),
    [
        (np.inf, (0.1019368, 0.4077472, 0.91743119), (1e-7, 1e-7, 1e-8)),
        (20.0, (0.10503601, 0.40774726, 0.91743119), (1e-8, 1e-8, 1e-8)),
    ],
)
def test_gravity_waves_agree_with_the_table_to_its_printed_digits(depth, printed, last_digit):
    k = wavenumber([1.0, 2.0, 3.0], depth, surface_tension=0.0)
    assert np.all(np.abs(k - printed) <= 0.51 * np.array(last_digit))


@given(st.floats(-8.0, 5.0), st.one_of(st.floats(0.05, 1e4), st.just(np.inf)), st.sampled_from([0.0, SURFACE_TENSION]))
def test_wavenumber_inverts_angular_frequency(log_omega, depth, tension):
    omega = 10.0**log_omega
    k = wavenumber(omega, depth, surface_tension=tension)
    # ω depends on k with an exponent between ½ and 2: an error of 1e-14 in k shows as at most 2e-14 in ω.
    np.testing.assert_allclose(angular_frequency(k, depth, surface_tension=tension), omega, rtol=2e-14)


@given(st.floats(-9.0, 4.0), st.floats(0.05, 1e4))
def test_group_speed_is_the_derivative(log_k, depth):
    k = 10.0**log_k
    step = 1e-3
    ahead, behind = angular_frequency(k * (1.0 + step), depth), angular_frequency(k * (1.0 - step), depth)
    # Central difference: relative error of order step² times the third logarithmic derivative, at most a few units.
    np.testing.assert_allclose(group_speed(k, depth), (ahead - behind) / (2.0 * step * k), rtol=1e-5)


def test_slowest_wave_is_where_gravity_and_tension_meet():
    k_m = np.sqrt(GRAVITY * WATER_DENSITY / SURFACE_TENSION)
    np.testing.assert_allclose(k_m, 368.6, atol=0.05)
    k = k_m * np.array([0.99, 1.0, 1.01])
    speed = angular_frequency(k, np.inf) / k
    np.testing.assert_allclose(speed[1], 0.2307, atol=5e-5)
    assert speed[1] < speed[0]
    assert speed[1] < speed[2]


def test_limits_keep_their_digits():
    # Shallow water: ω = k √(gh) (1 − (kh)²/6): at kh = 1e-9 exact to float64.
    np.testing.assert_allclose(angular_frequency(1e-9, 1.0, surface_tension=0.0), 1e-9 * np.sqrt(GRAVITY), rtol=1e-15)
    np.testing.assert_allclose(group_speed([0.0, 1e-12], 4.0), np.sqrt(4.0 * GRAVITY), rtol=1e-14)
    assert group_speed(0.0, np.inf) == np.inf
    # tanh(kh) is 1 to the last digit: no overflow, deep and finite depth agree in every bit.
    np.testing.assert_array_equal(angular_frequency([10.0, 1e6], 1e4), angular_frequency([10.0, 1e6], np.inf))
    np.testing.assert_array_equal(wavenumber([0.0], [[0.05], [np.inf]]), np.zeros((2, 1)))
    for function in (angular_frequency, wavenumber, group_speed):
        assert function(1.0, 1e308) == function(1.0, np.inf)


def test_a_current_shifts_frequencies_by_its_part_along_the_waves():
    # k·U: all of it for waves that run with the current, its opposite against it, nothing across, for any current.
    for toward in (0.0, 0.7, 2.4, -1.9):
        water = Water(current=(1.5 * np.sin(toward), 1.5 * np.cos(toward)))
        ways = toward + np.array([0.0, np.pi, 0.5 * np.pi, np.pi / 3.0])
        shift = water.doppler_shift(0.2 * np.sin(ways), 0.2 * np.cos(ways))
        np.testing.assert_allclose(shift, [0.3, -0.3, 0.0, 0.15], atol=1e-15)


@pytest.mark.parametrize(("k", "depth"), [(-1.0, 1.0), (1.0, 0.0), (np.nan, 1.0), (1.0, np.nan)])
def test_impossible_waves_raise(k, depth):
    for function in (angular_frequency, wavenumber, group_speed):
        with pytest.raises(ValueError, match="must"):
            function(k, depth)
