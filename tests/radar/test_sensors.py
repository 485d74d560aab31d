"""What the boat's sensors say: bias, noise, rate and latency, each by itself against its law."""

from typing import Any

import numpy as np
import pytest

from seamap_rt.radar.platform import BoatMotion, BoatState, Sensors, boat_motion, white_noise
from seamap_rt.settings import PlatformSettings, SensorSettings

TIMES = np.arange(20_000) / 10e3  # pulses of 2 s
OMEGA = 2.0 * np.pi / 4.0  # of the roll
SWINGING = boat_motion(
    PlatformSettings(motion="sinusoidal", roll_deg=10.0, roll_period_s=4.0, heading_deg=350.0, speed_m_s=5.0)
)
STILL = boat_motion(PlatformSettings())


def sensed(motion: BoatMotion = SWINGING, seed: int = 1, **settings: Any) -> Sensors:
    return Sensors(SensorSettings(**settings), motion, seed)


def columns(state: BoatState) -> np.ndarray:
    return np.concatenate((state.position, state.attitude), axis=1)


def test_perfect_sensors_tell_the_motion_itself():
    for found, true in zip(columns(sensed()(TIMES)), columns(SWINGING(TIMES)), strict=True):
        assert found.tobytes() == true.tobytes()


def test_biases_are_added_each_to_its_own():
    biases: dict[str, Any] = {
        "height_bias_m": 0.3,
        "roll_bias_deg": 0.1,
        "pitch_bias_deg": -0.2,
        "heading_bias_deg": 2.0,
    }
    error = columns(sensed(**biases)(TIMES)) - columns(SWINGING(TIMES))
    np.testing.assert_allclose(error, np.tile((0.0, 0.0, 0.3, 0.1, -0.2, 2.0), (TIMES.size, 1)), atol=1e-12)  # rounding


# ------------------------------------------------------------------------------------------------------------ noise

NOISE: dict[str, Any] = {"position_noise_m": 0.05, "attitude_noise_deg": 0.2, "heading_noise_deg": 1.5}
RMS = np.array((0.05, 0.05, 0.05, 0.2, 0.2, 1.5))


@pytest.mark.parametrize("rate", [np.inf, 100.0])
def test_noise_is_white_and_as_large_as_it_is_said_to_be(rate):
    times = TIMES if np.isinf(rate) else np.arange(20_000) / rate  # a reading each
    noise = columns(sensed(rate_hz=rate, **NOISE)(times)) - columns(SWINGING(times))
    n = times.size
    # Five standard errors of n readings, of the mean, the rms and a correlation of 6 × 6 × 21 of them.
    np.testing.assert_allclose(noise.mean(axis=0) / RMS, 0.0, atol=5.0 / np.sqrt(n))
    np.testing.assert_allclose(noise.std(axis=0) / RMS, 1.0, atol=5.0 / np.sqrt(2.0 * n))
    white = noise / RMS
    for lag in (*range(20), 1000):
        correlation = white[: n - lag].T @ white[lag:] / (n - lag)
        np.testing.assert_allclose(
            correlation, np.eye(6) * (lag == 0), atol=5.0 * np.sqrt(1.0 + (lag == 0)) / np.sqrt(n)
        )


def test_noise_is_normal():
    white = np.sort(white_noise(np.uint64(7), np.arange(-100_000, 100_000), 6).ravel())
    assert np.mean(white**4) == pytest.approx(3.0, abs=5.0 * np.sqrt(96.0 / white.size))  # five standard errors
    for level, share in ((1.0, 0.841345), (2.0, 0.977250), (3.0, 0.998650)):
        found = np.searchsorted(white, level) / white.size
        assert found == pytest.approx(share, abs=5.0 * np.sqrt(share * (1.0 - share) / white.size))


def test_between_readings_the_noise_is_between_theirs():
    # Interpolated noise has (1 − f)² + f² of the variance: ⅔ of it on average.
    times = np.arange(400_000) / 10e3
    noise = sensed(STILL, rate_hz=500.0, attitude_noise_deg=0.2)(times).attitude[:, 0]
    # Five standard errors of its 20 000 readings.
    assert np.var(noise) / 0.04 == pytest.approx(2.0 / 3.0, rel=5.0 * np.sqrt(2.0 / 20_000))


@pytest.mark.parametrize("rate", [np.inf, 37.0])
def test_whoever_asks_meets_the_same_readings(rate):
    sensors = sensed(rate_hz=rate, latency_s=0.02, **NOISE)
    times = np.concatenate((np.linspace(-0.5, 0.0, 100), TIMES[::10]))
    whole = columns(sensors(times))
    order = np.random.default_rng(1).permutation(times.size)
    pieces = [columns(sensed(rate_hz=rate, latency_s=0.02, **NOISE)(times[part])) for part in np.array_split(order, 9)]
    np.testing.assert_array_equal(np.concatenate(pieces), whole[order])
    other = columns(sensed(seed=2, rate_hz=rate, latency_s=0.02, **NOISE)(times))
    assert not np.any(np.all(other == whole, axis=1))


# ------------------------------------------------------------------------------------------------- latency and rate


def test_a_late_reading_is_of_the_motion_before():
    np.testing.assert_array_equal(columns(sensed(latency_s=0.25)(TIMES)), columns(SWINGING(TIMES - 0.25)))
    roll = sensed(latency_s=0.25)(np.arange(0.0, 8.0, 0.01)).attitude[:, 0]
    phase = np.angle(np.sum(roll * np.exp(1j * OMEGA * np.arange(0.0, 8.0, 0.01))))  # two periods
    assert phase == pytest.approx(np.pi / 2.0 + 0.25 * OMEGA, abs=1e-9)  # sin ω(t − τ)


@pytest.mark.parametrize("latency", [0.0, 0.03])
@pytest.mark.parametrize("rate", [5.0, 20.0, 100.0])
def test_a_slow_rate_cuts_the_corners(rate, latency):
    times = np.linspace(0.0, 8.0, 80_001)
    found = sensed(rate_hz=rate, latency_s=latency)(times)
    error = np.max(np.abs(found.attitude[:, 0] - SWINGING(times - latency).attitude[:, 0]))
    step = OMEGA / rate
    # Where the roll turns, half a step between two readings that straddle it: (ωΔ)²/8 of the amplitude, less (ωΔ)⁴/384;
    # readings that do not straddle it so come near it, within (ωΔ)²/8 of that again.
    assert error == pytest.approx(10.0 * (1.0 - np.cos(0.5 * step)), rel=0.2 * step**2 + 2e-3)
    # A course in a straight line is met.
    np.testing.assert_allclose(found.position, SWINGING(times - latency).position, atol=1e-12)


def test_at_a_reading_it_is_the_reading():
    number = np.arange(-5, 60)
    found = sensed(rate_hz=8.0, latency_s=0.125)(number / 8.0)
    np.testing.assert_array_equal(columns(found), columns(SWINGING((number - 1) / 8.0)))
