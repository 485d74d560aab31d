"""What free waves get wrong: the law, its closed form, and what turns tell of it."""

from __future__ import annotations

from concurrent.futures import ThreadPoolExecutor
from dataclasses import replace

import numpy as np
import pytest
from free_waves import FreeWaves, observed
from numpy.typing import NDArray

from seamap_rt.physics.dispersion import Water
from seamap_rt.prediction import Observations, Spectrum, WaveField
from seamap_rt.prediction.ensemble import Ensemble
from seamap_rt.prediction.fit import Fit
from seamap_rt.prediction.innovations import Innovations, weight_of_groups
from seamap_rt.prediction.knowledge import ErrorSample, ModelError, fit_model_error, scatter

Field = NDArray[np.float64]

PEAK, STD = 1.14, 0.35  # rad/s and m
KEPT, TURNS = 6, 14


def wind_sea(std: float = STD) -> Spectrum:
    """At 5.5 s from the west, of some width in frequency and direction."""
    omega = np.linspace(0.3, 4.0, 400)
    shape = np.exp(-(((omega - PEAK) / 0.2) ** 2) / 2.0)
    return Spectrum.of_frequency(omega, std**2 * shape / np.trapezoid(shape, omega), 270.0, 20.0)


def drifting_waves(drift: float, seed: int) -> FreeWaves:
    """Eighty waves of that sea, whose frequencies are `drift` [rad/s], rms, from what free waves' are."""
    stream = np.random.default_rng(seed)
    omega, toward = PEAK + 0.2 * stream.standard_normal(80), np.radians(90.0 + 18.0 * stream.standard_normal(80))
    k = Water().wavenumber(omega)
    omega = omega + drift * stream.standard_normal(80)
    amplitude = STD / np.sqrt(40.0) * np.exp(2j * np.pi * stream.random(80))
    return FreeWaves(k * np.sin(toward), k * np.cos(toward), omega, amplitude)


def turn_of(sea: FreeWaves, number: int) -> Observations:
    return observed(sea, number, 144, np.arange(20.0, 120.0, 4.0))


def last_field(sea: FreeWaves) -> WaveField:
    """The field after some turns of which the fit rests on the last ones."""
    spectrum, innovations = wind_sea(), Innovations()
    fit = Fit.of(spectrum, [turn_of(sea, 0)], 30.0, (0.0, 0.0))
    ensemble, field = Ensemble(fit), None
    with ThreadPoolExecutor(2) as workers:
        for number in range(TURNS):
            fit.keep(set(range(number - KEPT + 1, number + 1)))
            fit.add([turn_of(sea, number)], [number])
            innovations.compare(fit, number)
            ensemble.solve(fit, number + 1.0, workers)
            field = fit.field(number + 1.0, 0.0, ensemble.members, innovations.model_error(fit))
            innovations.remember(field)
    assert field is not None
    return field


def over_stated(sea: FreeWaves, field: WaveField) -> float:
    """Error over stated error, rms, within 60 m and 2 to 8 s ahead: what came from where it was seen."""
    side = np.linspace(-60.0, 60.0, 7)
    x, y, lead = (each.ravel() for each in np.meshgrid(side, side, np.arange(2.0, 9.0, 2.0)))
    mean, std = field.elevation(x, y, field.issued + lead)
    error = mean - sea.elevation(x, y, field.issued + lead)
    return float(np.sqrt(np.mean(error**2) / np.mean(std**2)))


def test_the_stated_error_covers_waves_that_drift() -> None:
    # Of eighty waves the mean square of the drift is known to 1/√40, and its errors over some groups to a fifth.
    # Without the law the error would be twice what is stated.
    sea = drifting_waves(0.03, 1)
    field = last_field(sea)
    assert field.model_error.drift == pytest.approx(0.03, rel=0.2)
    assert over_stated(sea, field) == pytest.approx(1.0, abs=0.3)
    assert over_stated(sea, replace(field, model_error=ModelError())) > 1.6


def test_waves_that_do_not_drift_are_not_said_to() -> None:
    # What turns tell of the error is below what is stated, and that leaves nothing to be wrong: 30 s ahead less than a
    # hundredth, a fifth of what the doubt about slow drift would be.
    field = last_field(drifting_waves(0.0, 1))
    assert field.model_error.share(np.array([field.issued + 30.0]), np.ones(1))[0] < 0.01


def test_a_fit_from_nothing_is_right_where_nothing_was_seen() -> None:
    # Six turns that see 120 m of a square of 390 m. Steps come last to waves that nothing tells: stopped as soon as a
    # fit that goes on may be, the square has more wrong than the sea itself. A hundredth of the right side leaves some.
    seen = [turn_of(drifting_waves(0.0, 1), number) for number in range(KEPT)]
    fit = Fit.of(wind_sea(), seen, 30.0, (0.0, 0.0))
    fit.add(seen, range(KEPT))
    fit.update_weights()
    with ThreadPoolExecutor(1) as workers:
        fit.solve(workers)
        found, fit.unknowns = fit.amplitudes, None
        for _ in range(30):  # each goes on by some steps
            fit.solve(workers)
    off = [np.sum(np.abs(a - b) ** 2) / 2.0 for a, b in zip(found, fit.amplitudes, strict=True)]
    assert sum(off) < 0.5 * STD**2


def test_what_turns_tell_outweighs_what_was_taken_before() -> None:
    # Shares that are as uncertain as large, half of them of short lapses, half of long ones: to a third from twenty
    # turns, whatever the sea's steepness would say, and a gust of one turn counts for one.
    stream = np.random.default_rng(4)
    for still, drift in ((0.03, 0.001), (0.004, 0.01), (0.0, 0.03)):
        told = []
        for number in range(20):
            lapse = (8.0, 19.0)[number % 2]
            right = still + (drift * lapse) ** 2
            told.append(ErrorSample(right * stream.gamma(8.0) / 8.0, 0.002, lapse**2))
        for std in (0.1, 0.6):
            found = fit_model_error(told, wind_sea(std), 0.0)
            lapse = np.array([8.0, 20.0])
            np.testing.assert_allclose(
                found.still + (found.drift * lapse) ** 2, still + (drift * lapse) ** 2, rtol=0.35
            )


def test_before_any_turn_steeper_seas_are_less_sure() -> None:
    gentle, steep = (fit_model_error([], wind_sea(std), 3.0) for std in (0.1, 0.5))
    assert gentle.since == 3.0
    assert steep.drift == pytest.approx(25.0 * gentle.drift, rel=1e-6)
    assert steep.drift == scatter(wind_sea(0.5))


def test_high_groups_are_wrong_most_and_a_gaussian_sea_by_the_drift() -> None:
    # In the mean over groups of a Gaussian sea the square of the phase, (0.01 · 10)², to its first order: 0.2 %. What
    # is lost in the long run is twice a group's energy, of a third twice the mean one's.
    law, height = ModelError(0.0, 0.01, 0.0), np.linspace(0.0, 40.0, 4001)
    mean = np.trapezoid(np.exp(-height) * law.share(np.full(4001, 10.0), height), height)
    assert mean == pytest.approx(0.01, rel=0.03)
    low, high = law.share(np.full(2, 10.0), np.array([0.5, 4.0]))
    assert high > 5.0 * low
    np.testing.assert_allclose(law.share(np.full(2, 1e5), np.array([0.5, 4.0])), [4.0 / 3.0, 6.0])
    assert ModelError(0.02).share(np.zeros(1), np.ones(1))[0] == 0.02


def test_pairs_of_a_gaussian_sea_weigh_one() -> None:
    # Complex sums of a hundred thousand places, in pairs that are alike to 0.8: their products' mean is known to 1 %,
    # and the sixth moment to 5 %.
    stream = np.random.default_rng(1)
    one, more = (0.7 * (stream.standard_normal(10**5) + 1j * stream.standard_normal(10**5)) for _ in range(2))
    other = 0.8 * one + 0.6 * more
    pairs = np.stack((np.arange(10**5), np.arange(10**5) + 10**5), axis=1)
    known = 0.8 * 0.7**2
    assert weight_of_groups(np.concatenate((one, other)), pairs, known) == pytest.approx(1.0, abs=0.05)
    assert weight_of_groups(2.0 * np.concatenate((one, other)), pairs, known) > 2.0


def test_the_scatter_is_that_of_a_gaussian_sea() -> None:
    # ½ k² ω |A|² A, of which the mean over the waves' energy is amplitude dispersion, and the rest scatters: a million
    # draws tell the sixth moment to half a percent.
    sea = wind_sea()
    omega = 2.0 * np.pi / sea.peak_period
    k, stream = float(sea.water.wavenumber(omega)), np.random.default_rng(0)
    envelope = np.sqrt(sea.variance) * (stream.standard_normal(10**6) + 1j * stream.standard_normal(10**6))
    runs = 0.5 * k**2 * omega * np.abs(envelope) ** 2 * envelope
    mean = np.vdot(envelope, runs) / np.vdot(envelope, envelope)
    left = runs - mean * envelope
    assert mean.real == pytest.approx(2.0 * k**2 * omega * sea.variance, rel=0.01)
    assert scatter(sea) == pytest.approx(np.std(left) / np.std(envelope), rel=0.01)
