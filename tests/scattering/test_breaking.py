"""Breakers: how much of the sea they cover, what a zone returns, and how fast they run."""

from __future__ import annotations

import numpy as np
import pytest
from scipy.integrate import dblquad

from seamap_rt.scattering.breaking import breaker_motion, breakers, nrcs_breaker

F = 10e9


def zone(theta, side=0.0, direction=0.87):
    """σ0 on a level sea; side: the cosine of the look against the wind, 1 up-wind."""
    return nrcs_breaker(np.cos(theta), np.sin(theta) * side, direction)


def growth(k, angle, u_star):
    """β of Kudryavtsev et al. (2005), eq. 17, of gravity waves."""
    c = np.sqrt(9.81 / k)
    length = 0.018 * u_star**2 / 9.81 + 0.1 * 1.47e-5 / u_star
    coefficient = 1.5 * 1.225 / 1025.0 * (np.log(np.pi / (k * length)) / 0.4 - c / u_star)
    viscous = 4.0 * 1.15e-6 * k**2 / np.sqrt(9.81 * k)
    return max(max(coefficient, 0.0) * (u_star / c * np.cos(angle)) ** 2 - viscous, 0.0)


def test_the_fraction_is_the_integral_of_the_fronts():
    wind_speed = 10.0
    u_star = wind_speed * np.sqrt(1e-3 * (0.8 + 0.065 * wind_speed))
    peak, limit = 9.81 * (0.84 / wind_speed) ** 2, 0.1 * 2.0 * np.pi * F / 299_792_458.0
    moments = [
        dblquad(
            lambda log_k, angle, n=n: growth(np.exp(log_k), angle, u_star) ** 1.2
            * (np.sqrt(9.81 / np.exp(log_k)) * np.cos(angle)) ** n,
            -np.pi / 2.0, np.pi / 2.0, np.log(peak), np.log(min(limit, 2.0 * np.pi / 0.3)), epsabs=1e-9,
        )[0]
        for n in (0, 1, 2)
    ]  # fmt: skip
    found = breakers(wind_speed, 0.84, F)
    # 5e-3: surface tension, which the sum here leaves out (at 0.3 m 0.3 % of ω²), and the grid
    np.testing.assert_allclose(found.fraction, 10.5 / 2.0 * moments[0], rtol=5e-3)
    mean = moments[1] / moments[0]
    np.testing.assert_allclose(
        breaker_motion(wind_speed, 0.84, F), (mean, np.sqrt(moments[2] / moments[0] - mean**2)), rtol=5e-3
    )


def test_breakers_outnumber_whitecaps_by_a_little():
    # Monahan & O'Muircheartaigh 1980: whitecaps cover 3.84e-6 U^3.41. q counts waves that break without foam too.
    for wind_speed in (5.0, 7.0, 10.0, 15.0, 20.0):
        whitecaps = 3.84e-6 * wind_speed**3.41
        assert whitecaps < breakers(wind_speed, 0.84, F).fraction < 3.0 * whitecaps


def test_more_wind_breaks_more_and_a_long_radar_wave_sees_less_of_it():
    fractions = [breakers(wind_speed, 0.84, F).fraction for wind_speed in np.geomspace(0.5, 60.0, 100)]
    assert fractions[0] == 0.0  # viscosity: no wave that long grows
    assert np.all(np.diff(fractions) >= 0.0)
    assert fractions[-1] <= 0.9
    by_radar = [breakers(10.0, 0.84, frequency) for frequency in (1e9, 3e9, 10e9, 35e9)]
    assert np.all(np.diff([each.fraction for each in by_radar]) >= 0.0)
    assert np.all(np.diff([each.speed for each in by_radar]) <= 0.0)
    np.testing.assert_allclose(
        by_radar[3].fraction, by_radar[2].fraction, rtol=5e-3
    )  # both end at 0.3 m, 10 GHz 0.1 % above


def test_breakers_run_downwind_at_their_waves_speed():
    speed, spread = breaker_motion(10.0, 0.84, F)
    slowest = np.sqrt(9.81 / (2.0 * np.pi / 0.3))
    assert slowest < speed < 2.0 * slowest
    assert 0.0 < spread < speed
    assert breaker_motion(0.5, 0.84, F) == (0.0, 0.0)


def test_a_breaking_zone_as_published():
    # Kudryavtsev et al. 2003, eq. 60, by hand: 1/0.19 (1 + 0.005) squarely; at 45° 4/0.19 e^(−1/0.19) + 0.005/0.19
    np.testing.assert_allclose(zone(0.0, direction=0.0), 5.289474, rtol=1e-6)
    np.testing.assert_allclose(zone(np.pi / 4.0, direction=0.0), 0.135346, rtol=1e-5)
    np.testing.assert_allclose(zone(np.radians(89.0)), 0.005 / 0.19, rtol=1e-9)  # only its wall


@pytest.mark.parametrize("theta_deg", [20.0, 40.0, 50.0])
def test_the_front_returns_more_than_the_back_as_the_paper_expands_it(theta_deg):
    theta, step = np.radians(theta_deg), 1e-6
    up, cross, down = (zone(theta, side) for side in (1.0, 0.0, -1.0))
    assert up > cross > down
    slope = (np.log(zone(theta + step, direction=0.0)) - np.log(zone(theta - step, direction=0.0))) / (2.0 * step)
    # 1 + M · 0.05 · A either way, M = ∂ln σ/∂θ. The first order in 0.05 is theirs; 0.05 of it may be the third order
    np.testing.assert_allclose(0.5 * np.log(up / down), -slope * 0.05 * 0.87, rtol=0.05)
