"""The mesh's waves gather short waves and breakers, and leave their mean."""

from __future__ import annotations

import numpy as np
import pytest
from scipy.special import ndtri

from seamap_rt.conventions import db
from seamap_rt.scattering.breaking import (
    action_modulation,
    breaking_level,
    breaking_share,
    mean_action_modulation,
    modulation_db,
    relaxation_rate,
)

QUANTILES = ndtri((np.arange(400_000) + 0.5) / 400_000)  # a Gaussian population without chance


def test_relaxation_is_the_bragg_waves_growth():
    # by hand, 10 GHz and 10 m/s: k = 419.2 rad/m, c = 0.2315 m/s, u* = 0.381 m/s: 0.04 (u*/c)² c k = 10.5 per second
    np.testing.assert_allclose(relaxation_rate(10e9, 10.0), 10.5, rtol=0.01)  # as printed
    np.testing.assert_allclose(relaxation_rate(10e9, 5.0) / relaxation_rate(10e9, 10.0), 0.25 * 1.125 / 1.45, rtol=1e-9)
    for wind in (0.0, -1.0, np.inf, np.nan):
        with pytest.raises(ValueError, match="wind_speed"):
            relaxation_rate(10e9, wind)


def test_small_strain_gathers_action_as_alpers_and_hasselmann_and_large_strain_is_bounded():
    np.testing.assert_allclose(np.log(action_modulation(np.array([-1e-4, 1e-4]))), [-4.5e-4, 4.5e-4], rtol=1e-6)
    strain = np.linspace(-5.0, 5.0, 1001)
    assert np.all(np.diff(action_modulation(strain)) >= 0.0)
    np.testing.assert_allclose(action_modulation(strain)[[0, -1]], np.exp([-2.25, 2.25]), rtol=1e-6)


@pytest.mark.parametrize("variance", [0.0, 1e-4, 0.01, 0.04, 0.2])
def test_the_mean_over_a_gaussian_strain_stays(variance):
    strain = np.sqrt(variance) * QUANTILES
    # 1e-4: the population ends at 4.7σ
    np.testing.assert_allclose(np.mean(action_modulation(strain)), mean_action_modulation(variance), rtol=1e-4)
    for fraction in (1e-6, 1e-3, 0.02, 0.3, 0.9):
        share = breaking_share(action_modulation(strain), breaking_level(fraction, variance))
        # tails: at 1e-6 and 0.01 most of the mean comes from beyond 3σ
        np.testing.assert_allclose(np.mean(share), fraction, rtol=2e-3)
        assert np.all((share >= 0.0) & (share <= 1.0))
        assert np.all(np.diff(share) >= 0.0)


def test_breaking_goes_like_the_sixth_power_of_the_spectrum_where_little_breaks():
    level = breaking_level(1e-6, 0.0)
    ratio = breaking_share(action_modulation(np.array([0.01])), level) / breaking_share(
        action_modulation(np.array([0.0])), level
    )
    np.testing.assert_allclose(ratio, np.exp(6.0 * 4.5 * 0.01), rtol=2e-4)  # the bend of the strain: (0.02)²/3


def test_nonsense_is_refused():
    with pytest.raises(ValueError, match="strain_variance"):
        mean_action_modulation(-0.1)
    with pytest.raises(ValueError, match="fraction"):
        breaking_level(1.0, 0.01)
    assert breaking_level(0.0, 0.01) == 0.0


def test_strain_modulates_by_its_power():
    # A change of N by exp(4.5 strain): e in 10/ln 10 dB.
    assert modulation_db(1.0 / 4.5) == pytest.approx(float(db(np.e)))
