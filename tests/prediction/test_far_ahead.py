"""Far ahead: a forecast is worth no less than none, and says how far ahead it tells anything."""

from __future__ import annotations

from concurrent.futures import ThreadPoolExecutor

import numpy as np
from free_waves import FreeWaves, observed
from numpy.typing import NDArray

from seamap_rt.physics.dispersion import Water
from seamap_rt.prediction import Observations, Spectrum, WaveField
from seamap_rt.prediction.ensemble import Ensemble
from seamap_rt.prediction.fit import Fit
from seamap_rt.prediction.forecast import maximum_prediction_time
from seamap_rt.prediction.innovations import Innovations
from seamap_rt.prediction.knowledge import ModelError

Field = NDArray[np.float64]

STD, PERIOD, TURNS, SEAS = 0.5, 12.0, 6, 4
PLACES = np.array([(0.0, 0.0), (40.0, 0.0), (-40.0, 0.0), (0.0, 40.0), (0.0, -40.0)])
LEAD = np.arange(0.0, 31.0, 2.0)


def swell(period: float) -> Spectrum:
    """From the south-west, of a tenth of its frequency's width."""
    peak, omega = 2.0 * np.pi / period, np.linspace(0.2, 2.0, 600)
    shape = np.exp(-0.5 * ((omega / peak - 1.0) / 0.1) ** 2)
    return Spectrum.of_frequency(omega, STD**2 * shape / np.trapezoid(shape, omega), 225.0, 30.0)


def swell_waves(seed: int) -> FreeWaves:
    """Two hundred waves of a swell."""
    stream = np.random.default_rng(seed)
    omega = 2.0 * np.pi / PERIOD * (1.0 + 0.1 * stream.standard_normal(200))
    toward = np.radians(45.0 + 14.0 * stream.standard_normal(200))
    k = Water().wavenumber(omega)
    amplitude = STD / np.sqrt(100.0) * np.exp(2j * np.pi * stream.random(200))
    return FreeWaves(k * np.sin(toward), k * np.cos(toward), omega, amplitude)


def turn_of(sea: FreeWaves, number: int) -> Observations:
    return observed(sea, number, 90, np.arange(20.0, 200.0, 6.0))


def last_field(sea: FreeWaves, spectrum: Spectrum) -> WaveField:
    """The field after some turns, by a spectrum."""
    fit = Fit.of(spectrum, [turn_of(sea, 0)], 30.0 + TURNS, (0.0, 0.0))
    ensemble, innovations = Ensemble(fit), Innovations()
    field = None
    with ThreadPoolExecutor(2) as workers:
        for number in range(TURNS):
            fit.add([turn_of(sea, number)], [number])
            innovations.compare(fit, number)
            ensemble.solve(fit, number + 1.0, workers)
            field = fit.field(number + 1.0, 0.0, ensemble.members, innovations.model_error(fit))
            innovations.remember(field)
    assert field is not None
    return field


def test_a_swell_longer_than_the_circle_is_forecast_no_higher_than_it_is() -> None:
    # ErrorSample ten thousand times over inside 200 m and not at all outside: what comes
    # from outside is the prior's, of mean 0. Four seas at five places know mean squares of groups to a half.
    error, stated, told, came = [], [], [], []
    for seed in range(SEAS):
        sea = swell_waves(seed)
        field = last_field(sea, swell(PERIOD))
        x, y, time = (each.ravel() for each in np.broadcast_arrays(*PLACES.T[:, :, None], field.issued + LEAD))
        mean, std = field.elevation(x, y, time)
        true = sea.elevation(x, y, time)
        for rows, values in ((error, mean - true), (stated, std), (told, mean), (came, true)):
            rows.append(values.reshape(len(PLACES), LEAD.size))
        assert np.all(std <= 1.01 * field.sea_std)
    error, stated, told, came = (np.sqrt(np.mean(np.square(each), axis=(0, 1))) for each in (error, stated, told, came))
    assert np.all(error < 1.1 * came)
    assert np.all(told < 1.2 * came)
    assert np.all(stated > 0.75 * error)


def test_what_is_wrong_is_taken_back_and_leaves_no_more_than_the_sea() -> None:
    time, height = np.linspace(0.0, 200.0, 81), np.ones(81)
    for law in (ModelError(0.02, 0.0), ModelError(0.0, 0.02), ModelError(0.5, 0.1)):
        kept, wrong = law.kept_share(time, height), law.share(time, height)
        assert np.all((kept >= 0.0) & (kept <= 1.0))
        assert np.all(np.diff(kept) <= 1e-12)
        # A forecast β m of the sea, of which m has w wrong: β² − 2 β (1 − w/2) + 1 of it is left, least at 1 − w/2.
        left = 1.0 - kept**2
        for share in (kept - 0.05, kept + 0.05, np.zeros(81), np.ones(81)):
            inside = (share >= 0.0) & (wrong <= 2.0)
            assert np.all((left <= share**2 - 2.0 * share * (1.0 - 0.5 * wrong) + 1.0 + 1e-9)[inside])
    np.testing.assert_allclose(ModelError(0.0, 0.1).kept_share(np.array([1e4]), np.array([4.0])), 0.0)


def test_the_maximum_prediction_time_is_where_the_error_meets_half_of_the_sea() -> None:
    lead = np.arange(0.0, 31.0)
    slope, begin = np.array([0.01, 0.02, 0.05]), 0.1
    error = begin + slope * lead[:, None]  # m, of a sea of 0.8 m
    found = maximum_prediction_time(lead, error, 0.8)
    np.testing.assert_allclose(found, np.minimum((0.4 - begin) / slope, 30.0), rtol=1e-9)
    # Steps and the order of leads are nothing to a line; a larger error is never good for longer, a higher sea is.
    stream = np.random.default_rng(2)
    np.testing.assert_allclose(maximum_prediction_time(lead[::-5], error[::-5], 0.8), found)
    rough = np.abs(np.cumsum(stream.standard_normal((31, 50)), axis=0)) * 0.1
    some = maximum_prediction_time(lead, rough, 0.8)
    assert np.all(maximum_prediction_time(lead, rough * stream.uniform(1.0, 1.5, rough.shape), 0.8) <= some)
    assert np.all(maximum_prediction_time(lead, rough, 1.6) >= some)
    np.testing.assert_array_equal(maximum_prediction_time(lead, np.full((31, 1), 0.39), 0.8), 30.0)
    np.testing.assert_array_equal(maximum_prediction_time(lead, np.full((31, 1), 0.41), 0.8), 0.0)
    late = np.where(lead[:, None] == 0.0, 0.5, 0.1)  # in the blind disc nothing is known now
    np.testing.assert_array_equal(maximum_prediction_time(lead, late, 0.8), 0.0)
