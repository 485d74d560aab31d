"""What motion sensors that err add to error bars: closed forms by key, and nothing where they do not err."""

from __future__ import annotations

from dataclasses import replace
from functools import cache

import numpy as np
import pytest
import xarray as xr
from numpy.typing import NDArray

import seamap_rt as sr
from seamap_rt.errors import SchemaError
from seamap_rt.interferometry.description import RadarDescription
from seamap_rt.interferometry.error_covariance import sensor_variance, variance_kept
from seamap_rt.settings import SensorErrors, SensorSettings
from seamap_rt.simulation import Simulator

KEYS = {"radar.sector_deg": [200.0, 260.0], "radar.range_m": [15.0, 80.0], "tracing.tracer": "horizon"}
SENSORS = "platform.sensors."
NOISY = {
    "attitude_noise_deg": 0.3,
    "heading_noise_deg": 1.0,
    "position_noise_m": 0.05,
    "rate_hz": 20.0,
    "latency_s": 0.02,
}


@cache
def echoes(**sensors: float) -> xr.Dataset:
    keys = {f"{SENSORS}{name}": value for name, value in sensors.items()}
    return Simulator(sr.load_scene("choppy_sea", {**KEYS, **keys})).turn(0).echoes


def polar(of: xr.Dataset) -> xr.Dataset:
    return sr.retrieve(of)["polar"].to_dataset().isel(turn=0)


def added(rolling: float = 0.0, **sensors: float) -> NDArray[np.float64]:
    """Error [m] (look, gate) at 50 and 100 m of a boat whose roll grows by that rate [deg/s]; slopes are 0.1."""
    of = echoes()
    moved = of.assign(
        attitude=(("pulse", "axis"), of["attitude"].values + np.outer(of["time"].values, (rolling, 0, 0)))
    )
    radar = replace(RadarDescription.of(of), sensors=SensorErrors(**sensors))
    reach = np.array([[50.0, 100.0]] * 3)
    return np.sqrt(sensor_variance(moved.rename(axis=of["attitude"].dims[1]), radar, 0.9, reach, np.full((3, 2), 0.1)))


def test_each_key_has_its_closed_form() -> None:
    reach, still = np.array([[50.0, 100.0]] * 3), np.sqrt(2.0 / 3.0)
    tilt = reach * np.radians(0.1)
    np.testing.assert_allclose(added(attitude_accuracy_deg=0.1), tilt, rtol=1e-9)
    np.testing.assert_allclose(added(heading_accuracy_deg=0.1), 0.1 * tilt, rtol=1e-9)  # slope times the way aside
    np.testing.assert_allclose(added(height_accuracy_m=0.2), 0.2, rtol=1e-9)
    # One reading a second: in two looks of 2.5 ms two thirds of its variance, less x²/6 of x = 0.005.
    np.testing.assert_allclose(added(attitude_noise_deg=0.1, rate_hz=1.0), still * tilt, rtol=1e-4)
    np.testing.assert_allclose(added(position_noise_m=0.2, rate_hz=1.0), still * 0.2, rtol=1e-4)
    # A roll of 5°/s, 0.02 s late, is wrong by 0.1°: along a look by 1/√2 of that in the mean over all looks; the roll
    # itself, to 0.83°, turns the axes by the square of that.
    np.testing.assert_allclose(added(5.0, latency_s=0.02), tilt / np.sqrt(2.0), rtol=2e-3)


def test_a_sensor_is_read_once_a_pulse_at_most() -> None:
    pulses_s = 1.0 / RadarDescription.of(echoes()).interval
    noise = {"attitude_noise_deg": 0.1, "heading_noise_deg": 1.0, "position_noise_m": 0.2}
    fastest = added(rate_hz=pulses_s, **noise)
    np.testing.assert_allclose(added(rate_hz=10.0 * pulses_s, **noise), fastest, rtol=1e-12)
    # A mean over half as many readings keeps nearly twice the variance, 1.4 times the error.
    assert np.all(added(rate_hz=0.5 * pulses_s, **noise) > 1.1 * fastest)


def test_noise_is_kept_as_by_means_over_straight_lines() -> None:
    rng = np.random.default_rng(1)
    for x in (0.1, 0.5, 2.0, 10.0):  # readings to a look; two looks
        start = rng.uniform(0.0, 4e4, 20_000)
        at = start[:, None] + 2.0 * x * (np.arange(64) + 0.5) / 64.0
        mean = np.interp(at, np.arange(40_050), rng.standard_normal(40_050)).mean(axis=1)
        assert variance_kept(x) == pytest.approx(mean.var(), rel=0.05)  # 20,000 means: 1 %, of longer ones 4 %


def test_sensors_that_do_not_err_change_no_bit() -> None:
    told = echoes()
    untold = told.drop_attrs(deep=False).assign_attrs({k: v for k, v in told.attrs.items() if "sensors_" not in k})
    one, other = polar(told), polar(untold)
    xr.testing.assert_identical(one.drop_attrs(), other.drop_attrs())
    assert "sensor_std" not in one
    assert "not the motion sensors" in other.attrs["height_std_holds"]


def test_what_the_sensors_add_is_all_that_an_error_bar_gains() -> None:
    err = echoes(**NOISY)
    told = polar(err)
    quiet = polar(err.drop_attrs(deep=False).assign_attrs({k: v for k, v in err.attrs.items() if "sensors_" not in k}))
    np.testing.assert_array_equal(told["height"].values, quiet["height"].values)
    for name in ("height_std", "dwell_height_std"):
        known = np.isfinite(told[name].values)
        before, after, put = (each.values[known] ** 2 for each in (quiet[name], told[name], told["sensor_std"]))
        np.testing.assert_allclose(after - before, put, rtol=1e-3, atol=1e-6)  # float32
    assert "their biases" in told.attrs["height_std_holds"]
    assert "not their" in told.attrs["height_std_holds"]


def test_echoes_do_not_tell_an_error_itself() -> None:
    biases = [each for each in SensorSettings.model_fields if "_bias_" in each]
    assert len(biases) > 1
    assert echoes(**dict.fromkeys(biases, 0.7)).attrs == echoes().attrs


def test_echoes_tell_each_size_and_refuse_what_is_none() -> None:
    sizes = {key: 0.5 + 0.01 * number for number, key in enumerate(SensorErrors.model_fields)}
    of = echoes(**sizes)
    for key, size in sizes.items():
        assert of.attrs[f"sensors_{key}"] == size
        with pytest.raises(SchemaError, match=f"sensors_{key} = -1"):
            sr.retrieve(of.assign_attrs({f"sensors_{key}": -1.0}))
