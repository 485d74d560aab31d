"""What the stated error is made of: the speckle's correlation, and a coherence that the waves' slope does not spoil."""

from __future__ import annotations

import numpy as np
import pytest
from numpy.typing import NDArray

from seamap_rt.interferometry.covariance import Covariance, independent_looks, pulse_correlation
from seamap_rt.interferometry.description import RadarDescription
from seamap_rt.interferometry.heights import Heights
from seamap_rt.interferometry.inversion import Places
from seamap_rt.interferometry.uncertainty import height_std
from seamap_rt.radar.waveform import RangeResponse
from seamap_rt.scene import load_scene

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


def test_the_slope_of_a_wave_is_not_a_lack_of_coherence() -> None:
    # A perfect mirror whose phase climbs by 0.5 rad from gate to gate and 0.3 rad from look to look: along those slopes
    # nothing is uncertain; across a window of seven gates the same echo looks incoherent.
    scene = load_scene("tiny", {"radar.noise": False})
    shape, pulses = (20, 60), 10
    ramp = 0.5 * np.arange(shape[1]) + 0.3 * np.arange(shape[0])[:, None]
    one = np.ones(shape)
    dwell = Covariance(np.exp(1j * ramp), one, one)
    voltage = np.ones((shape[0] * pulses, 2, shape[1]), dtype=np.complex64)
    ranges = np.asarray(20.0 + 1.5 * np.arange(shape[1]), dtype=np.float64)
    response = RangeResponse.of(scene.radar)
    radar = RadarDescription(0.03, 0.0, "switched", (0.0, 36.0), 1.0, 5.0, response, ranges)
    spread = {}
    for name, slopes in (("along", (0.5, 0.3)), ("level", (0.0, 0.0))):
        window = (np.array([1.0, 1.0, 1.0]), np.array([0.5, 1.0, 0.5]))
        along = (np.full(1, slopes[0]), np.full(1, slopes[1]), None)
        found = Heights(dwell, window, ramp, Places(0.0 * one, one, 0.0 * one), one, one, along)
        look = np.repeat(np.arange(shape[0]), pulses)
        spread[name] = np.median(height_std(voltage, look, dwell, one, found, radar))
    assert spread["along"] < 0.01
    assert spread["level"] > 0.3
