"""How errors of neighbouring gates and looks go together, against speckle that is drawn and against closed forms."""

from __future__ import annotations

from typing import cast

import numpy as np
import pytest
from gaussian_pulse import GaussianPulse
from numpy.typing import NDArray

from seamap_rt.interferometry.error_covariance import (
    ErrorCovariance,
    correlation_beside,
    correlation_by_range,
)
from seamap_rt.interferometry.speckle import DwellPulses
from seamap_rt.radar.waveform import RangeResponse
from seamap_rt.scene import load_scene

Array = NDArray[np.float64]
RESPONSE = RangeResponse.of(load_scene("choppy_sea").radar)
LAGS = 1.5 * np.arange(4)


def test_of_a_gaussian_pulse_they_are_closed_forms() -> None:
    # R = exp(−d²/8σ²); tilt −½ (R²)'' over its value at 0, which is (1 − d²/2σ²) R².
    response = GaussianPulse()
    lags = np.linspace(0.0, 3.5, 8)
    tilt, rough, noise = correlation_by_range(cast(RangeResponse, response), lags)
    echo = np.exp(-(lags[: tilt.size] ** 2) / (8.0 * response.spread_m**2))
    # Integrals over 6 m, 6.7 standard deviations of the pulse's power.
    np.testing.assert_allclose(rough, echo**2, atol=1e-6)
    np.testing.assert_allclose(tilt, (1.0 - lags[: tilt.size] ** 2 / (2.0 * response.spread_m**2)) * echo**2, atol=1e-6)
    np.testing.assert_allclose(noise, np.exp(-(lags[: tilt.size] ** 2)) * echo, atol=1e-6)


def test_drawn_speckle_has_them() -> None:
    """Im(y'y*) of scatterers drawn, for the three causes of y'; Gaussian moments, so no small-error limit is needed."""
    rng = np.random.default_rng(1)
    count, step = 200_000, 0.1
    scatterers = rng.normal(size=count) + 1j * rng.normal(size=count)
    s = np.arange(-6.0, 6.0 + 0.5 * step, step)

    def received(source: NDArray[np.complex128], response: Array) -> NDArray[np.complex128]:
        return np.convolve(source, response[::-1], "valid")

    pulse = RESPONSE(s)
    voltage = received(scatterers, pulse)
    causes = (received(scatterers, s * pulse), received(rng.normal(size=count) * scatterers, pulse))
    expected = correlation_by_range(RESPONSE, LAGS)
    for cause, asked in zip(causes, expected[:2], strict=True):
        error = (1j * cause * voltage.conj()).imag
        got = [np.mean(error[: error.size - n] * error[n:]) / np.mean(error**2) for n in (0, 15, 30)]
        # 20 km of range hold some 7000 pulse lengths: a correlation is known to 1.2 %, three of that.
        np.testing.assert_allclose(got, asked[:3], atol=0.04)


def test_errors_by_tilt_vanish_from_means() -> None:
    # A bright spot moves the gates to both of its sides, in opposite directions: their sum over all gates is nothing.
    fine = 0.1 * np.arange(120)
    tilt = correlation_by_range(RESPONSE, fine)[0]
    assert abs(tilt[0] + 2.0 * tilt[1:].sum()) < 0.02 * np.abs(tilt).sum()


def test_pulses_of_the_next_look() -> None:
    # The same speckle in all pulses: half at most. New in each: none. Triangular over n pulses: what a sum says.
    assert correlation_beside(DwellPulses(20, np.ones(20))) == pytest.approx(0.5, abs=0.03)
    assert correlation_beside(DwellPulses(20, np.eye(1, 20).ravel())) == 0.0
    correlation = np.clip(1.0 - np.arange(20) / 6.0, 0.0, None)
    pulses = np.arange(40)
    square = np.clip(1.0 - np.abs(np.subtract.outer(pulses, pulses)) / 6.0, 0.0, None) ** 2
    expected = square[:20, 20:].sum() / square[:20, :20].sum()
    assert correlation_beside(DwellPulses(20, correlation)) == pytest.approx(expected, rel=1e-12)


def test_means_of_many_err_by_what_neighbours_share() -> None:
    # 400 gates of three looks: of noise that neighbouring gates share by half, and speckle that looks share by a fifth.
    parts = np.broadcast_to(np.array([0.3, 0.2, 0.5])[:, None, None], (3, 3, 400))
    along = np.array([[1.0, -0.5, 0.0], [1.0, 0.2, 0.0], [1.0, 0.5, 0.1]])
    errors = ErrorCovariance(parts, along, 0.2)
    # Tilt vanishes from means; roughness 0.04 (1 + 0.4)(1 + 0.4), noise 0.25 (1 + 1.2).
    np.testing.assert_allclose(errors.mean_variance, 0.04 * 1.4 * 1.4 + 0.25 * 2.2)


def test_parts_add_up() -> None:
    parts = np.array([[[3.0]], [[4.0]], [[np.inf]]])
    assert ErrorCovariance(parts, np.ones((3, 1)), 0.0).variance[0, 0] == np.inf
    assert ErrorCovariance(np.minimum(parts, 12.0), np.ones((3, 1)), 0.0).variance[0, 0] == pytest.approx(169.0)
