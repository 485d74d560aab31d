"""What the stated error is made of: the speckle's correlation, and a coherence that the waves' slope does not spoil."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from numpy.typing import NDArray
from synthetic_seas import heard

from seamap_rt.conventions import SPEED_OF_LIGHT
from seamap_rt.interferometry.description import RadarDescription
from seamap_rt.interferometry.poses import edge_bias
from seamap_rt.interferometry.speckle import ONE_CELL, DwellPulses, incoherent_power
from seamap_rt.interferometry.windows import (
    Covariance,
    PhaseSlopes,
    independent_looks,
    pulse_correlation,
    window_weights,
)
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


def radar_of(ranges: NDArray[np.float64]) -> RadarDescription:
    response = RangeResponse.of(load_scene("tiny").radar)
    return RadarDescription(0.03, 0.0, "switched", (0.0, 36.0), 1.0, 5.0, response, ranges)


def test_the_slope_of_a_wave_is_not_a_lack_of_coherence() -> None:
    # A perfect mirror whose phase climbs by 0.5 rad from gate to gate and 0.3 rad from look to look: along those slopes
    # nothing is uncertain; across a window of five gates and three looks the same echo looks incoherent.
    gate, look = np.arange(60), np.arange(20)[:, None]
    one = np.ones((20, 60))
    dwell = Covariance(np.exp(1j * (0.5 * gate + 0.3 * look)), one, one)
    missing = {
        slopes: incoherent_power(
            dwell.windowed_along(np.ones(5), np.ones(3), PhaseSlopes(np.full(1, slopes[0]), np.full(1, slopes[1]))),
            0.0,
            10.0,
        )
        for slopes in ((0.5, 0.3), (0.0, 0.0))
    }
    # The latter is 1 − (1 + 2 cos 0.5 + 2 cos 1)/5 · (1 + 2 cos 0.3)/3 where the window is whole.
    asked = 1.0 - (1.0 + 2.0 * np.cos(0.5) + 2.0 * np.cos(1.0)) / 5.0 * (1.0 + 2.0 * np.cos(0.3)) / 3.0
    np.testing.assert_allclose(missing[0.5, 0.3], 0.0, rtol=0, atol=64 * np.finfo(float).eps)
    np.testing.assert_allclose(missing[0.0, 0.0][1:-1, 2:-2], asked, rtol=1e-12)


# ------------------------------------------------------------------------------------------- samples of a window

GATE = 1.5  # m
RANGES: NDArray[np.float64] = np.asarray(20.0 + GATE * np.arange(60), dtype=np.float64)


@pytest.mark.parametrize(("time_constant", "worth"), [(0.3, 20.0), (1e6, 1.0)])
def test_a_dwell_is_worth_its_speckles_changes(time_constant: float, worth: float) -> None:
    # Speckle that is new at each pulse counts all of them; one that stands still counts once. Noise is new always.
    correlation = np.exp(-((np.arange(20) / time_constant) ** 2))
    found = DwellPulses(20, correlation).samples(ONE_CELL, radar_of(RANGES))
    assert found.speckle == pytest.approx(worth, rel=1e-4)  # exp(−2/0.09) and 400/1e12 are what is left
    assert found.noise == pytest.approx(20.0)


def test_overlapping_gates_are_fewer_samples() -> None:
    # Against drawn noise and speckle: Gaussian, white along the range, through the receiver's pulse. The mean power of
    # a window of 5 gates and 3 looks scatters by one over the root of its samples: 4000 draws know the square of that
    # to √(2/4000) = 2.2 %; 3 σ. Of the noise the filter is Gaussian, exp(−π f²/B²) in power.
    radar = radar_of(RANGES)
    window = window_weights(7.5, GATE), np.array([0.5, 1.0, 0.5])
    found = DwellPulses(1, np.ones(1)).samples(window, radar)
    rng, fine = np.random.default_rng(12), 0.05
    offset = fine * np.arange(-200, 201)
    points = GATE * np.arange(-2, 3)[:, None]
    # White noise of power spectrum exp(−π f²/B²): its filter's impulse response is exp(−2π B² t²).
    echo = radar.response(offset - points)
    noise = np.exp(-2.0 * np.pi * (radar.response.bandwidth_hz * 2.0 / SPEED_OF_LIGHT * (offset - points)) ** 2)
    for name, shape in (("speckle", echo), ("noise", noise)):
        shape /= np.sqrt(np.sum(shape**2, axis=1, keepdims=True))
        draws = rng.normal(size=(4000, 3, offset.size)) + 1j * rng.normal(size=(4000, 3, offset.size))
        power = np.abs(draws @ shape.T) ** 2 / 2.0
        mean = np.einsum("dlg,l,g->d", power, window[1], window[0]) / (window[0].sum() * window[1].sum())
        assert 1.0 / np.var(mean) == pytest.approx(getattr(found, name), rel=0.066), name
    assert found.speckle < found.noise < 5.0 * 4.0 / 1.5


@pytest.mark.parametrize("step", [0.25, 0.5, 1.0, 2.0])
def test_comparing_pulses_more_seldom(step: float) -> None:
    # Half as many pulses, twice as far apart, of the same speckle: as long a dwell.
    correlation = np.exp(-((np.arange(40) / 15.0) ** 2))
    other = DwellPulses(40, correlation).resample(step)
    assert other.pulses == 40 * step
    lag = np.arange(other.pulses)
    # Between pulses a straight line: off by ⅛ of its bend, (2/15²)/8 = 0.0011. Beyond the last it stays as it was.
    np.testing.assert_allclose(other.correlation, np.exp(-((lag / step / 15.0) ** 2)), rtol=0, atol=1.2e-3)


def test_a_dwell_that_is_never_compared() -> None:
    never = DwellPulses(40, np.ones(40)).resample(0.0)  # where a receiver hears nothing; warnings are errors
    assert np.isfinite(never.correlation).all()
    assert np.isfinite(never.samples(ONE_CELL, radar_of(RANGES)).noise)


# ------------------------------------------------------------------------------------------- the middle of the gates


@pytest.mark.parametrize("growth", [0.2, -0.1])
def test_a_steep_echo_is_heard_from_beside_the_middle(growth: float) -> None:
    # Scatterers whose power grows as exp(growth · R), under the pulse's own power: the mean of their places lies
    # beside the gate's middle by growth · σ² (exactly so under a Gaussian; a 20 ns pulse's next cumulant is −0.1 m⁴:
    # growth³/6 of it, 1e-4 m). Mean sea level is H/R times as much lower there, and so much too high is the height.
    radar = radar_of(RANGES)
    power = np.tile(np.exp(growth * RANGES), (4, 1))
    found = edge_bias(power, np.full((1, 1), 5.0), radar)
    fine = np.linspace(-12.0, 12.0, 4001)
    weight = radar.response(fine) ** 2 * np.exp(growth * fine)
    beside = float(weight @ fine / weight.sum())
    np.testing.assert_allclose(found[0], 5.0 / RANGES * beside, rtol=0.03)


def test_no_slope_no_bias() -> None:
    radar = radar_of(RANGES)
    flat = np.ones((3, 60))
    np.testing.assert_allclose(edge_bias(flat, np.full((1, 1), 5.0), radar), 0.0, rtol=0, atol=1e-15)
    flat[:, 9] = 0.0  # a gate that hears nothing says nothing, and no warning is given
    np.testing.assert_array_equal(edge_bias(flat, np.full((1, 1), 5.0), radar), np.zeros((1, 60)))
    step = np.where(RANGES < 60.0, 1e-12, 1.0) * np.ones((3, 1))  # steeper than the first order can say
    assert np.abs(edge_bias(step, np.full((1, 1), 5.0), radar)).max() < 5.0 / 20.0
    two = radar_of(RANGES[:2])
    np.testing.assert_array_equal(edge_bias(np.ones((3, 2)), np.full((1, 1), 5.0), two), np.zeros((1, 2)))


@pytest.mark.parametrize("samples", [1, 3])
@pytest.mark.parametrize("variance", [0.0, 0.3, 1.0])
def test_the_echos_contrast_is_what_speckle_leaves(variance: float, samples: int) -> None:
    # Of textures of that variance V two gates' differ by 2V, beside the square of their mean, 1 + V/2.
    sea = heard(lambda x, y: 0.0 * x, 3, samples=samples, looks=240).given
    rng, shape = np.random.default_rng(11), sea.dwell.cross.shape
    texture = rng.gamma(1.0 / variance, variance, shape) if variance else np.ones(shape)

    def told(unit: float) -> float:
        power = texture * unit
        uneven = Covariance(sea.dwell.cross * power, sea.dwell.lower * power, sea.dwell.upper * power)
        given = replace(sea, dwell=uneven, echo=replace(sea.echo, pulses=uneven))
        return float(np.median(given.texture(given.echo.neighbourhood_mean)))

    # The same whatever the unit of power is. 240 looks by 21 gates, of which a third are independent: fourth moments
    # of exponential speckle and texture leave some hundredths.
    found = told(1.0)
    assert told(1e-12) == pytest.approx(found, rel=1e-9, abs=1e-12)
    assert found == pytest.approx(variance / (1.0 + 0.5 * variance), abs=0.08)
