"""What a gate's neighbours tell of where its echo comes from, against drawn scatterers and Tweedie's formula."""

from __future__ import annotations

from typing import cast

import numpy as np
import pytest
from gaussian_pulse import GaussianPulse
from numpy.typing import NDArray

from seamap_rt.interferometry.error_covariance import BrightSpots, Offsets
from seamap_rt.radar.waveform import RangeResponse
from seamap_rt.scene import load_scene

Array = NDArray[np.float64]
RESPONSE = RangeResponse.of(load_scene("choppy_sea").radar)
SPACING = 1.5
STEP = 0.1  # m, of scatterers
REACH = np.arange(-60, 61) * STEP


def gates(scatterers: NDArray[np.complex128], moved: bool = False) -> NDArray[np.complex128]:
    """Voltages of gates, of a mean power of 1 if the scatterers' is; moved: of each times its distance."""
    pulse = RESPONSE(REACH) * (REACH if moved else 1.0) / np.sqrt(np.sum(RESPONSE(REACH) ** 2))
    return np.convolve(scatterers, pulse[::-1], "valid")[:: round(SPACING / STEP)]


def drawn(seed: int, count: int) -> NDArray[np.complex128]:
    rng = np.random.default_rng(seed)
    return (rng.normal(size=count) + 1j * rng.normal(size=count)) * np.sqrt(0.5)


def differences(power: Array, spots: BrightSpots) -> Array:
    """D (pair, gate) of the gates that have all neighbours."""
    near, far = spots.neighbours
    ends = power.size - far
    return np.stack(
        (power[far + near : ends + near] - power[far - near : ends - near], power[2 * far :] - power[: -2 * far])
    )


def test_of_a_gaussian_pulse_the_power_tells_all() -> None:
    # Tweedie: δ = σ² d ln P/dR, whatever scatters. An even growth g gives D = 2 sinh(g n d): c M⁻¹ D = σ² g.
    spots = BrightSpots.of(cast(RangeResponse, GaussianPulse()), 0.1)
    weights, left = spots.weights(np.ones(()), np.zeros(()), np.zeros(()))
    growth = 0.05
    told = weights @ (2.0 * np.sinh(growth * spots.spacing * spots.neighbours))
    # Neighbours 0.8 and 1.6 σ away stand in for a derivative: to their third order.
    assert told == pytest.approx(GaussianPulse.spread_m**2 * growth, rel=0.05)
    assert left < 0.05


def test_drawn_speckle_errs_as_said() -> None:
    """By the power of the gate itself: of a strong one the neighbours tell most, of a faded one next to nothing."""
    spots = BrightSpots.of(RESPONSE, SPACING)
    scatterers = drawn(1, 1_500_000)
    voltage, moved = gates(scatterers), gates(scatterers, moved=True)
    power, far = np.abs(voltage) ** 2, spots.neighbours[1]
    own, asked = power[far:-far], (moved * voltage.conj()).real[far:-far]
    weights, left = spots.weights(own, np.zeros(own.shape), np.zeros(own.shape))
    off = asked - np.sum(weights * differences(power, spots), axis=0)
    whole = 0.5 * float(spots.moments.both_moved(np.zeros(()))) * own
    # 1e5 gates, half of them independent, in four classes: a mean square is known to 1.3 %, three times that.
    for low, high in ((0.0, 0.2), (0.2, 0.7), (0.7, 1.5), (1.5, 20.0)):
        those = (own > low) & (own < high)
        assert np.mean(off[those] ** 2) == pytest.approx(np.mean((left * whole)[those]), rel=0.04)
    assert left[own > 1.5].max() < 0.25
    assert left[own < 0.01].min() > 0.8
    # Of the same weights for all gates, as the covariance of what is left has them.
    mean = spots.weights(np.ones(()), np.zeros(()), np.zeros(()))[0]
    rest = asked - mean @ differences(power, spots)
    got = [np.mean(rest[: rest.size - n] * rest[n:]) for n in range(5)]
    said = spots.covariance(SPACING * np.arange(5.0))
    np.testing.assert_allclose(got, said, rtol=0, atol=0.04 * said[0])


def test_noise_makes_the_neighbours_tell_less() -> None:
    spots = BrightSpots.of(RESPONSE, SPACING)
    scatterers, noisy, signal = drawn(2, 1_500_000), drawn(3, 1_500_000), 4.0
    voltage, moved = gates(scatterers), gates(scatterers, moved=True)
    # The noise's own correlation is that of a Gaussian filter, √(π) B τ: white gates pass it here.
    kernel = np.exp(-2.0 * np.pi * (2.0 * REACH / 299_792_458.0 * 50e6) ** 2)
    hiss = np.convolve(noisy, kernel / np.sqrt(np.sum(kernel**2)), "valid")[:: round(SPACING / STEP)]
    heard = np.abs(voltage + hiss / np.sqrt(signal)) ** 2 - 1.0 / signal
    far, power = spots.neighbours[1], np.abs(voltage) ** 2
    own, asked = power[far:-far], (moved * voltage.conj()).real[far:-far]
    each = np.full(own.shape, 1.0 / signal)
    weights, left = spots.weights(own, each, each**2)
    off = asked - np.sum(weights * differences(heard, spots), axis=0)
    whole = 0.5 * float(spots.moments.both_moved(np.zeros(()))) * own
    without = spots.weights(own, 0.0 * each, 0.0 * each)[1]
    for low, high in ((0.2, 0.7), (0.7, 1.5), (1.5, 20.0)):
        those = (own > low) & (own < high)
        assert np.mean(off[those] ** 2) == pytest.approx(np.mean((left * whole)[those]), rel=0.04)
        assert (left > without)[those].all()


@pytest.mark.parametrize("turn", [0.3, -0.3, 0.6])
def test_phases_of_an_uneven_slope_are_set_right(turn: float) -> None:
    """Bright spots that stay, speckle that changes from dwell to dwell, on a surface that turns the phase evenly."""
    rng = np.random.default_rng(4)
    looks, count = 40, 1500
    lying = STEP * np.arange(count)
    bright = np.convolve(rng.gamma(0.3, 1.0 / 0.3, count + 9), np.full(10, 0.1), "valid")
    cross, power = [], []
    for look in range(looks):
        lower = drawn(100 + look, count) * np.sqrt(bright)
        one, other = gates(lower), gates(lower * np.exp(1j * turn * lying))
        cross.append(other * one.conj())
        power.append(np.abs(one) ** 2)
    middle = lying[60 : 60 + len(cross[0]) * round(SPACING / STEP) : round(SPACING / STEP)]
    phase = np.angle(np.array(cross) * np.exp(-1j * turn * middle))
    shape = phase.shape
    spots = BrightSpots.of(RESPONSE, SPACING)
    heard = np.ones(shape, dtype=bool)
    # What all looks share counts as growth along the range: here a look has spots of its own.
    shuffled = np.stack([np.roll(each, 7 * n) for n, each in enumerate(power)])
    offsets = spots.offsets(shuffled, np.ones(shape), heard, 0.0, 1.0, np.full(shape, turn))
    phase = np.stack([np.roll(each, 7 * n) for n, each in enumerate(phase)])
    inner = np.zeros(shape, dtype=bool)
    inner[:, 2:-2] = True
    strong = inner & (shuffled > 0.5)
    off = phase, phase - offsets.phase, phase + offsets.phase
    before, after, wrong = (float(np.sqrt(np.mean(each[strong] ** 2))) for each in off)
    assert after**2 < 0.56 * before**2  # nearly half of the variance, of single pulses that may have faded
    assert wrong > 1.3 * before


@pytest.mark.parametrize("looks", [1, 2])
@pytest.mark.parametrize("turned", [0.2, 0.5, 0.8, 1.1, 1.4])
def test_large_phases_err_as_said(turned: float, looks: int) -> None:
    """Of a level that turns the phase by so many radians within the pulse's spread, faint echoes and strong ones."""
    spots, turn = BrightSpots.of(RESPONSE, SPACING), turned / RESPONSE.spread_m
    count = 200_000
    lying = STEP * np.arange(count)
    drawings = [drawn(20 + look, count) for look in range(looks)]
    pairs = [(gates(each), gates(each * np.exp(1j * turn * lying))) for each in drawings]
    cross = np.mean([other * one.conj() for one, other in pairs], axis=0)[None]
    mean = np.mean([np.abs(np.stack(pair)) ** 2 for pair in pairs], axis=(0, 1))[None]
    middle = lying[60 : 60 + cross.size * round(SPACING / STEP) : round(SPACING / STEP)]
    phase = np.angle(cross * np.exp(-1j * turn * middle))
    coherence = float(np.sum(RESPONSE(REACH) ** 2 * np.cos(turn * REACH)) / np.sum(RESPONSE(REACH) ** 2))
    shape = 64, cross.size // 64  # of one look alone all growth along the range is shared
    cross, phase, mean = (each.flat[: shape[0] * shape[1]].reshape(shape) for each in (cross, phase, mean))
    variance = (1.0 - coherence**2) / (2.0 * coherence) / np.abs(cross) / looks
    heard = np.ones(shape, dtype=bool)
    first = spots.offsets(mean, np.ones(shape), heard, 0.0, 1.0, np.full(shape, turn))
    said = first.shrink_for_speckle(variance, looks)
    inner = np.s_[:, 8:-8]

    def over(offsets: Offsets) -> float:
        off = np.angle(np.exp(1j * (phase - offsets.phase))) / np.sqrt(variance * offsets.left)
        return float(np.sqrt(np.mean(np.clip(off[inner], -5.0, 5.0) ** 2)))

    # Before anything is taken off, phases that may wrap err by up to 1.17 of a variance that cannot.
    assert 0.95 < over(said) < 1.25
    if turned > 0.6:
        assert over(first) > 1.25


def test_beside_what_is_not_heard_nothing_is_told() -> None:
    spots = BrightSpots.of(RESPONSE, SPACING)
    rng = np.random.default_rng(5)
    power, heard, turn = rng.exponential(size=(30, 40)), np.ones((30, 40), dtype=bool), np.full((30, 40), 0.5)
    heard[7, 20] = False
    power[7, 20] = np.nan
    offsets = spots.offsets(power, np.ones((30, 40)), heard, 0.01, 3.0, turn)
    assert (offsets.phase[7, 18:23] == 0.0).all()
    assert (offsets.left[7, 18:23] == 1.0).all()
    assert (offsets.phase[:, :2] == 0.0).all()
    assert (offsets.left[:, -2:] == 1.0).all()
    assert np.isfinite(offsets.phase).all()
    assert (offsets.phase[8, 2:-2] != 0.0).all()
    # The same echo in all looks is growth along the range, of which the gates' edge is made.
    even = spots.offsets(np.tile(power[:1], (30, 1)), np.ones((30, 40)), np.ones_like(heard), 0.01, 3.0, turn)
    np.testing.assert_allclose(even.phase, 0.0, atol=1e-12)
    few = spots.offsets(power[:, :4], np.ones((30, 4)), heard[:, :4], 0.01, 3.0, turn[:, :4])
    assert (few.phase == 0.0).all()
    assert (few.left == 1.0).all()
    silent = spots.offsets(0.0 * power, 0.0 * power, np.zeros_like(heard), 0.0, 3.0, turn)
    assert (silent.phase == 0.0).all()
    assert (silent.left == 1.0).all()


@pytest.mark.parametrize("waveform", ["pulse", "chirp"])
def test_what_is_left_is_some_error(waveform: str) -> None:
    # Of a chirp, whose main lobe is cut off where its sidelobes begin, no less: matrices of errors need an inverse.
    radar = load_scene("choppy_sea", {"radar.waveform": waveform, "radar.pulse_width_s": 1e-7}).radar
    for spacing in (0.5, 1.5, 3.0):
        lags = spacing * np.arange(30)
        left = BrightSpots.of(RangeResponse.of(radar), spacing).covariance(np.asarray(lags, dtype=np.float64))
        gate = np.arange(30)
        values = np.linalg.eigvalsh(left[np.abs(gate[:, None] - gate)])
        assert values.min() > -1e-3 * values.max()  # sums over 401 points


def test_a_dark_neighbour_tells_as_much_as_a_bright_one() -> None:
    """What is too faint for a height of its own still tells where its neighbour's echo lies; the unknown does not."""
    spots = BrightSpots.of(RESPONSE, SPACING)
    power = np.random.default_rng(8).exponential(size=(40, 60))
    heard = power > 0.3
    turn, mean = np.full(power.shape, 0.3), np.ones(power.shape)
    reach = spots.neighbours[1]
    inner = np.zeros(power.shape, dtype=bool)
    inner[:, reach:-reach] = True
    found = spots.offsets(power, mean, heard, 0.0, 1.0, turn)
    assert (found.left[heard & inner] < 1.0).all()
    assert (found.left[~heard] == 1.0).all()
    lost = np.where(heard, power, np.nan)
    alone = spots.offsets(lost, mean, heard, 0.0, 1.0, turn)
    beside = np.logical_or.reduce([np.roll(~heard, n, axis=1) for n in (*spots.neighbours, *-spots.neighbours)])
    np.testing.assert_array_equal(alone.left[heard & inner & beside], 1.0)
    np.testing.assert_array_equal(alone.phase[heard & inner & beside], 0.0)
