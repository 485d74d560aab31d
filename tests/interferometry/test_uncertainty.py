"""What the stated error is made of: the speckle's correlation, and a coherence that the waves' slope does not spoil."""

from __future__ import annotations

import numpy as np
import pytest
from numpy.typing import NDArray

from seamap_rt.interferometry.covariance import independent_looks, pulse_correlation

PULSES, LOOKS, GATES = 50, 400, 40


def speckle(seed: int, time_constant: float, texture: NDArray[np.float64], doppler: float = 0.0) -> NDArray:
    """(pulse, receiver, gate): looks of Gaussian speckle with covariance exp(−(lag/time_constant)²), both receivers
    alike, each cell with its own mean power and, up to `doppler`, its own turn per pulse [rad]."""
    rng = np.random.default_rng(seed)
    lag = np.arange(PULSES)
    root = np.linalg.cholesky(np.exp(-(((lag[:, None] - lag) / time_constant) ** 2)) + 1e-6 * np.eye(PULSES))
    draws = rng.normal(size=(LOOKS, PULSES, GATES)) + 1j * rng.normal(size=(LOOKS, PULSES, GATES))
    turned = np.exp(1j * lag[:, None] * rng.uniform(-doppler, doppler, (LOOKS, 1, GATES)))
    voltage = (root @ draws) * turned * np.sqrt(0.5 * texture)[:, None, :]
    return np.repeat(voltage.reshape(-1, 1, GATES), 2, axis=1).astype(np.complex64)


@pytest.mark.parametrize("doppler", [0.0, 0.3])
@pytest.mark.parametrize("time_constant", [15.0, 40.0, 1e3])
def test_the_correlation_is_the_speckles_own(time_constant: float, doppler: float) -> None:
    # Texture, and a Doppler frequency that differs from cell to cell, must not matter.
    texture = np.random.default_rng(1).gamma(2.0, 0.5, (LOOKS, GATES))
    voltage = speckle(2, time_constant, texture, doppler)
    look = np.repeat(np.arange(LOOKS), PULSES)
    found = pulse_correlation(voltage, look, 0.0, PULSES - 1)
    lag = np.arange(PULSES)
    # 1600 cells in the strongest gates: |ρ|² is known to some 5 %, |ρ| to 3 % where it is large; where it is small the
    # root of that same 0.05 remains.
    asked = np.exp(-((lag / time_constant) ** 2))
    np.testing.assert_allclose(found**2, asked**2, atol=0.15)
    looks = [independent_looks(np.ones(PULSES), each) for each in (found, asked)]
    np.testing.assert_allclose(looks[0], looks[1], rtol=0.12)


def test_noise_is_not_taken_for_decorrelation() -> None:
    texture, noise = np.ones((LOOKS, GATES)), 0.5
    look = np.repeat(np.arange(LOOKS), PULSES)
    rng = np.random.default_rng(3)
    voltage = speckle(4, 1e3, texture)
    added = rng.normal(size=voltage.shape) + 1j * rng.normal(size=voltage.shape)
    found = pulse_correlation((voltage + np.sqrt(0.5 * noise) * added).astype(np.complex64), look, noise, PULSES - 1)
    # The echo stands still: 1 at every lag. A tenth of 40 gates times 400 looks knows |ρ|² to 0.1.
    np.testing.assert_allclose(found**2, 1.0, atol=0.2)


def test_odd_dwells_have_an_answer() -> None:
    quiet = np.zeros((10, 2, 5), dtype=np.complex64)
    np.testing.assert_array_equal(pulse_correlation(quiet, np.zeros(10, dtype=int), 1.0, 4), np.ones(5))
    np.testing.assert_array_equal(pulse_correlation(quiet, np.full(10, -1), 1.0, 4), np.ones(5))
    np.testing.assert_array_equal(pulse_correlation(quiet, np.arange(10), 1.0, 0), np.ones(1))
    loud = speckle(5, 15.0, np.ones((LOOKS, GATES)))
    loud[3:7] = np.nan  # a receiver that was not sampled
    assert np.isfinite(pulse_correlation(loud, np.repeat(np.arange(LOOKS), PULSES), 0.0, 49)).all()
    singles = pulse_correlation(loud[:LOOKS], np.arange(LOOKS), 0.0, 3)  # one pulse a look: nothing to compare
    assert np.isfinite(singles).all()
