"""What waves do to each other's frequencies, against the papers' laws and our own nonlinear sea."""

from __future__ import annotations

import numpy as np
from numpy.testing import assert_allclose

from seamap_rt.conventions import GRAVITY
from seamap_rt.physics.dispersion import mutual_shift, sea_shift
from seamap_rt.sea.high_order import Band, Evolution, State

K = np.geomspace(0.02, 6.0, 40)


def test_waves_that_run_alike_are_those_of_longuet_higgins_and_phillips() -> None:
    # A long wave carries a short one as its Stokes drift at the surface does; k₁ = k₂: twice Stokes' own ½ (k a)² ω.
    one, other = np.meshgrid(K, K, indexing="ij")
    expected = one * other * np.minimum(one, other) * np.sqrt(GRAVITY / other)
    assert_allclose(mutual_shift(one, other, 0.0), expected, rtol=1e-9)
    assert_allclose(mutual_shift(one, other, np.pi), -expected, rtol=1e-9)


def test_the_kernel_is_that_of_an_energy() -> None:
    # Zakharov's T₁₂₁₂ is symmetric, and of the third power of a length.
    one, other = np.meshgrid(K, K, indexing="ij")
    for angle in (0.3, 1.2, 2.5):
        kernel = mutual_shift(one, other, angle) * np.sqrt(other)
        assert_allclose(kernel, kernel.T, rtol=1e-9, atol=1e-12)
        assert_allclose(mutual_shift(2.0 * one, 2.0 * other, angle) * np.sqrt(2.0 * other), 8.0 * kernel, rtol=1e-9)


def test_a_strong_wave_shifts_weak_ones_as_in_the_nonlinear_sea() -> None:
    """Third order, k a = 0.05, eight periods: fifth orders are (k a)² of it, the slow beginning's tail 1e-3."""
    length, strong, weak = 100.0, (3, 0), ((2, 2), (3, 3), (-3, 1), (5, -1))
    band, step = Band(length, length, 8, 8, np.inf), 2.0 * np.pi / length
    steep = 0.05 / (3.0 * step)
    elevation, potential = np.zeros(band.shape, complex), np.zeros(band.shape, complex)
    places = [((line, column), 1.0) if column > 0 else ((-line, -column), -1.0) for column, line in (strong, *weak)]
    for number, (place, way) in enumerate(places):  # a wave that runs west is the conjugate of its mode
        elevation[place] = 0.5 * (1e-5 * steep if number else steep)
        potential[place] = -1j * way * elevation[place] * np.sqrt(GRAVITY / band.rise[place])
    period = 2.0 * np.pi / float(band.omega[0, 3])
    evolution = Evolution(band, 3, period / 16, relaxed_from=0.0, relaxing=1.5 * period)
    state = evolution.advanced(State(0.0, elevation, potential), 4 * 16)
    times, phases = [], []
    for _ in range(8 * 4):
        state = evolution.advanced(state, 4)
        times.append(state.time)
        waves = [
            state.elevation[place] + 1j * way * np.sqrt(band.rise[place] / GRAVITY) * state.potential[place]
            for place, way in places[1:]
        ]
        phases.append(
            [
                -way * np.angle(wave) - band.omega[place] * state.time
                for wave, (place, way) in zip(waves, places[1:], strict=True)
            ]
        )
    found = np.polyfit(times, np.unwrap(phases, axis=0), 1)[0]
    column, line = np.transpose(weak)
    k, angle = step * np.hypot(column, line), np.arctan2(line, column)
    assert_allclose(found, mutual_shift(k, 3.0 * step, angle) * steep**2, rtol=4e-3)


def test_a_sea_shifts_each_wave_as_all_of_its_waves_together() -> None:
    # By the sum written out; a narrow sea by twice Stokes' shift, a short wave on a long one by its surface drift.
    ways = 24
    toward = 2.0 * np.pi * np.arange(ways) / ways
    variance = np.random.default_rng(1).random((K.size, ways)) * (K[:, None] / 0.1) ** -4.0
    shift = sea_shift(K, variance)
    for ring, way in ((3, 2), (20, 17), (39, 0)):
        each = 2.0 * variance * mutual_shift(K[ring], K[:, None], toward - toward[way])
        assert_allclose(shift[ring, way], each.sum(), rtol=1e-9)
    narrow = np.where((np.arange(K.size) == 10)[:, None] & (toward == toward[5]), 0.1, 0.0)
    shift, omega = sea_shift(K, narrow), np.sqrt(GRAVITY * K[10])
    assert_allclose(shift[10, 5], 2.0 * 0.1 * K[10] ** 2 * omega, rtol=1e-9)
    assert_allclose(shift[10:, 5], K[10:] * 2.0 * 0.1 * K[10] * omega, rtol=1e-9)
