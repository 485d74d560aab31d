"""The spectrum of buoys is that of the sea on which they ride."""

from __future__ import annotations

import numpy as np
import pytest

from seamap_rt.errors import InputError
from seamap_rt.prediction import spectrum_of_buoys

_RATE_HZ, _SAMPLES, _WAVES = 4.0, 2**14, 300


def _velocities(wave_from_deg: float) -> tuple[np.ndarray, np.ndarray, np.ndarray, float]:
    """Up, east, north of water that rides on free waves of 8 s ± 0.6 s or so, ± 20° about a direction, and Hs²/16."""
    chance = np.random.default_rng(5)
    omega = chance.normal(2.0 * np.pi / 8.0, 0.06, _WAVES)
    toward = np.radians(wave_from_deg + 180.0) + np.radians(20.0) * chance.standard_normal(_WAVES)
    amplitude = np.full(_WAVES, 0.02)
    time = np.arange(_SAMPLES) / _RATE_HZ
    phase = np.multiply.outer(omega, time) + chance.uniform(0.0, 2.0 * np.pi, _WAVES)[:, None]
    # At one place η = a cos(ωt + p): water rises by dη/dt, and runs with the wave by aω on the crest.
    speed = amplitude * omega
    up, along = -speed @ np.sin(phase), speed[:, None] * np.cos(phase)
    return up, np.sin(toward) @ along, np.cos(toward) @ along, float(np.sum(amplitude**2) / 2.0)


@pytest.mark.parametrize("wave_from_deg", [0.0, 70.0, 200.0, 315.0])
def test_variance_period_and_direction_are_the_seas(wave_from_deg: float) -> None:
    """4096 s hold some 500 waves: the variance to 2/√500 or so, the direction to 20°/√500; the window of 64 s is wider
    than the peak, hence the period to 1/(64 s) of frequency."""
    up, east, north, variance = _velocities(wave_from_deg)
    found = spectrum_of_buoys(up, east, north, _RATE_HZ)
    assert found.variance == pytest.approx(variance, rel=0.1)
    assert 1.0 / found.peak_period == pytest.approx(1.0 / 8.0, abs=1.0 / 64.0)
    vector = np.sum(found.variances.sum(axis=0) * np.exp(1j * found.toward))
    came_from = np.degrees(np.angle(vector)) + 180.0
    assert (came_from - wave_from_deg + 180.0) % 360.0 - 180.0 == pytest.approx(0.0, abs=3.0)


def test_several_buoys_are_one_sea() -> None:
    up, east, north, _ = _velocities(70.0)
    one = spectrum_of_buoys(up, east, north, _RATE_HZ)
    both = [np.stack((each, each)) for each in (up, east, north)]
    twice = spectrum_of_buoys(both[0], both[1], both[2], _RATE_HZ)
    np.testing.assert_allclose(twice.table, one.table, rtol=1e-9)


def test_records_that_tell_no_spectrum_are_refused() -> None:
    good = np.zeros(300)
    for wrong in (np.zeros(200), np.full(300, np.nan), np.zeros((2, 300))):
        with pytest.raises(InputError, match="up, east, north"):
            spectrum_of_buoys(good, wrong, good, 4.0)
    with pytest.raises(InputError, match="band_hz"):
        spectrum_of_buoys(good, good, good, 0.8)
