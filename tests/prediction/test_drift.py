"""A current that nobody told, found by what it does to forecasts."""

from __future__ import annotations

from concurrent.futures import ThreadPoolExecutor
from copy import copy
from dataclasses import replace
from types import SimpleNamespace
from typing import cast

import numpy as np
import pytest

from seamap_rt.physics.dispersion import Water
from seamap_rt.prediction import Observations, Spectrum
from seamap_rt.prediction.fit import Fit
from seamap_rt.prediction.innovations import Drift
from seamap_rt.prediction.knowledge import Groups

DEEP = Water()


def wind_sea() -> Spectrum:
    """Hs 1.4 m at 5.5 s from the west, of some width in frequency and direction."""
    omega = np.linspace(0.3, 4.0, 400)
    shape = np.exp(-(((omega - 1.14) / 0.2) ** 2) / 2.0)
    return Spectrum.of_frequency(omega, 0.35**2 * shape / np.trapezoid(shape, omega), 270.0, 20.0)


def turns_of(current: tuple[float, float], count: int) -> list[Observations]:
    """What turns of a second see within 100 m, 1500 places each, of forty waves that a current carries."""
    stream = np.random.default_rng(3)
    omega, toward = 1.14 + 0.15 * stream.standard_normal(40), np.radians(90.0 + 25.0 * stream.standard_normal(40))
    k = DEEP.wavenumber(omega)
    kx, ky = k * np.sin(toward), k * np.cos(toward)
    waves = 0.35 / np.sqrt(20.0) * np.exp(2j * np.pi * stream.random(40))
    made = []
    for number in range(count):
        x, y = 100.0 * stream.uniform(-1.0, 1.0, (2, 1500))
        time = number + stream.random(1500)
        phase = np.multiply.outer(x, kx) + np.multiply.outer(y, ky)
        phase -= np.multiply.outer(time, omega + kx * current[0] + ky * current[1])
        value = (np.exp(1j * phase) @ waves).real + 0.05 * stream.standard_normal(1500)
        made.append(Observations(x, y, time, value, np.array([0.05]), np.array(["elevation"])))
    return made


def test_a_current_carries_groups_of_waves() -> None:
    """They run at their own speed through the water, and the water runs: north and east, and whichever way they go."""
    still, moving = (Groups.of(replace(wind_sea(), water=Water(8.0, current))) for current in ((0.0, 0.0), (0.7, -0.4)))
    np.testing.assert_allclose(moving.east - still.east, 0.7, rtol=1e-9)
    np.testing.assert_allclose(moving.north - still.north, -0.4, rtol=1e-9)
    np.testing.assert_allclose(np.hypot(still.east, still.north), Water(8.0).group_speed(still.k), rtol=1e-9)


@pytest.mark.parametrize("current", [(0.0, 0.0), (0.25, 0.0), (-0.2, 0.15)])
def test_residuals_tell_the_current(current: tuple[float, float]) -> None:
    # To a fifth of it: forecasts of still water are wrong in the phases of short waves too, of which the regression
    # takes the first order. The current across is told by the few waves that run there.
    seen = turns_of(current, 8)
    fit = Fit.of(wind_sea(), seen, 20.0, (0.0, 0.0))
    fit.add(seen[:7], range(7))
    with ThreadPoolExecutor(1) as workers:
        fit.solve(workers)
    fit.add(seen[7:], [7])
    drift = Drift(amplitude_dispersion=0.0)
    assert drift.learn(fit, 7) == any(current)
    assert drift.amplitude_dispersion == 0.0
    np.testing.assert_allclose(drift.current, current, atol=0.05)
    np.testing.assert_allclose(drift.water(Water(current=(1.0, 2.0))).current, drift.current + np.array([1.0, 2.0]))


def test_few_turns_tell_nothing() -> None:
    seen = turns_of((0.3, 0.0), 4)
    fit = Fit.of(wind_sea(), seen, 20.0, (0.0, 0.0))
    fit.add(seen[:3], range(3))
    with ThreadPoolExecutor(1) as workers:
        fit.solve(workers)
    fit.add(seen[3:], [3])
    assert not Drift().learn(fit, 3)


@pytest.mark.parametrize(("error", "believed"), [(0.03, False), (0.01, True)])
def test_a_current_within_some_of_its_errors_is_not_believed(error: float, believed: bool) -> None:
    # 0.1 m/s told to 0.03 m/s by residuals as if they erred independently: they do not. Told to 0.01 m/s it is there.
    matrix = np.eye(3) / error**2
    fit = SimpleNamespace(turns=10, drift_evidence=lambda _, amplitudes: (matrix, matrix @ np.array([0.1, 0.0, 0.0])))
    assert Drift().learn(cast("Fit", fit), 9) == believed


def steep_sea() -> Spectrum:
    """Hs 2.2 m at 5.5 s from the west, with short waves on it that tell a current from amplitude dispersion."""
    omega = np.linspace(0.3, 4.0, 400)
    shape = np.exp(-(((omega - 1.14) / 0.22) ** 2) / 2.0) + 0.15 * np.exp(-(((omega - 1.9) / 0.22) ** 2) / 2.0)
    return Spectrum.of_frequency(omega, 0.55**2 * shape / np.trapezoid(shape, omega), 270.0, 20.0)


def steep_turns(sea: Spectrum, current: tuple[float, float], share: float, count: int) -> list[Observations]:
    """What turns of a second see within 100 m, 1000 places each, of such a sea on a current, of waves that run by a
    share of its amplitude dispersion."""
    stream = np.random.default_rng(3)
    omega = np.concatenate([at + 0.15 * stream.standard_normal(40) for at in (1.14, 1.9)])
    toward, k = np.radians(90.0 + 25.0 * stream.standard_normal(80)), DEEP.wavenumber(omega)
    kx, ky = k * np.sin(toward), k * np.cos(toward)
    waves = np.repeat(np.array((0.115, 0.045)), 40) * np.exp(2j * np.pi * stream.random(80))
    runs = omega + kx * current[0] + ky * current[1] + share * sea.amplitude_shift(kx, ky)
    made = []
    for number in range(count):
        x, y = 100.0 * stream.uniform(-1.0, 1.0, (2, 1000))
        time = number + stream.random(1000)
        phase = np.multiply.outer(x, kx) + np.multiply.outer(y, ky) - np.multiply.outer(time, runs)
        value = np.real(np.exp(1j * phase) @ waves) + 0.05 * stream.standard_normal(1000)
        made.append(Observations(x, y, time, value, np.array([0.05]), np.array(["elevation"])))
    return made


@pytest.mark.parametrize(("current", "share"), [((0.0, 0.0), 0.0), ((0.25, 0.0), 0.0), ((0.1, 0.05), 1.0)])
@pytest.mark.slow
def test_a_current_and_amplitude_dispersion_are_told_apart(current: tuple[float, float], share: float) -> None:
    # What both do to the waves of the peak is told to a fifth, as a current alone is. They differ by what short waves
    # have more of amplitude dispersion, half as much again: where there is none none is believed, and of all of it a
    # fourth at least.
    sea, drift, seen = steep_sea(), Drift(), steep_turns(steep_sea(), current, share, 12)
    with ThreadPoolExecutor(1) as workers:
        for last in range(7, 12):
            now = replace(sea, water=drift.water(DEEP), amplitude_dispersion=drift.amplitude_dispersion)
            fit = Fit.of(now, seen, 20.0, (0.0, 0.0))
            fit.add(seen[last - 7 : last], range(last - 7, last))
            fit.solve(workers)
            fit.add([seen[last]], [last])
            drift.learn(fit, last)
    k = np.array([0.1325])
    of_amplitudes = float(sea.amplitude_shift(k, np.zeros(1))[0] / k[0])
    found = drift.current[0] + drift.amplitude_dispersion * of_amplitudes
    right = current[0] + share * of_amplitudes
    assert abs(found - right) < 0.05
    assert drift.amplitude_dispersion > 0.25 if share else drift.amplitude_dispersion < 0.1


def test_waves_run_by_their_amplitudes_on_deep_water_alone() -> None:
    sea, k = steep_sea(), np.array([0.1325])
    told = replace(sea, amplitude_dispersion=0.5)
    shift = sea.amplitude_shift(k, np.zeros(1))
    assert shift[0] > 0.0
    np.testing.assert_allclose(told.omega(k, np.zeros(1), k) - sea.omega(k, np.zeros(1), k), 0.5 * shift, rtol=1e-12)
    np.testing.assert_array_equal(replace(sea, water=Water(depth=8.0)).amplitude_shift(k, np.zeros(1)), 0.0)


def test_shallow_water_tells_of_a_current_alone() -> None:
    # Amplitudes change nothing there: the regression has two unknowns left, and finds what it finds of them alone.
    matrix = np.diag([1e4, 1e4, 0.0])
    fit = SimpleNamespace(turns=10, drift_evidence=lambda _, amplitudes: (matrix, matrix @ np.array([0.1, 0.0, 0.0])))
    free, told = Drift(), Drift(amplitude_dispersion=0.0)
    assert free.learn(cast("Fit", fit), 9)
    assert told.learn(cast("Fit", fit), 9)
    np.testing.assert_array_equal(free.current, told.current)
    assert free.amplitude_dispersion == 0.0


def test_a_share_is_one_of_the_spectrum_that_the_waves_were_made_by() -> None:
    # A later spectrum, of four times the variance here, does not change how the waves of the fit run: what a turn says
    # of the share that they run by is the same. On other water, or by another share, the waves must be made anew.
    sea, seen = steep_sea(), steep_turns(steep_sea(), (0.0, 0.0), 0.0, 3)
    fit = Fit.of(sea, seen, 20.0, (0.0, 0.0))
    fit.add(seen, range(3))
    with ThreadPoolExecutor(1) as workers:
        fit.solve(workers)
    later, higher = copy(fit), replace(sea, table=4.0 * sea.table)
    later.renew(higher, (0.0, 0.0))
    for mine, other in zip(fit.drift_evidence(2, True), later.drift_evidence(2, True), strict=True):
        np.testing.assert_allclose(mine, other, rtol=1e-3)
    assert fit.suits(higher, (0.0, 0.0))
    assert not fit.suits(replace(sea, water=Water(current=(1.0, 0.0))), (0.0, 0.0))
    assert not fit.suits(replace(sea, amplitude_dispersion=0.5), (0.0, 0.0))
