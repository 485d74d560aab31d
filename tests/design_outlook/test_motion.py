"""What a boat's motion and her sensors cost an outlook: closed forms, the sensors themselves, and simulated turns."""

from __future__ import annotations

import operator
from dataclasses import replace
from functools import reduce
from typing import Any

import numpy as np
import pytest
import xarray as xr

import seamap_rt as sr
from seamap_rt.cli import main
from seamap_rt.design_outlook.error import Design
from seamap_rt.design_outlook.motion import Motion
from seamap_rt.design_outlook.strips import snr_of_unity, waves_of
from seamap_rt.measured import CoverageProfile
from seamap_rt.metrics import counted_cells
from seamap_rt.radar.platform import BoatState, Sensors
from seamap_rt.radar.wave_following import wave_tilt_std
from seamap_rt.scene import Scene
from seamap_rt.sea.facts import ResolvedWaves
from seamap_rt.settings import SensorSettings
from seamap_rt.simulation import Simulator

SENSORS = "platform.sensors."
STILL: dict[str, Any] = {
    "tracing.tracer": "horizon", "platform.motion": "fixed", "platform.speed_m_s": 0.0,
    **{SENSORS + name: 0.0 for name in SensorSettings.model_fields if name != "rate_hz"}, SENSORS + "rate_hz": "inf",
}  # fmt: skip
ROLLING = {
    "platform.motion": "sinusoidal",
    "platform.roll_deg": 8.0,
    "platform.pitch_deg": 4.0,
    "platform.heave_m": 0.3,
}
CASES: dict[str, dict[str, Any]] = {
    "rides the waves, sensors err": {"tracing.tracer": "horizon"},
    "rolls": {**STILL, **ROLLING},
    "rolls, sensor stands askew": {**STILL, **ROLLING, SENSORS + "roll_bias_deg": 0.1},
    "rolls, sensors are late": {**STILL, **ROLLING, SENSORS + "latency_s": 0.01},
    "lists": {**STILL, "platform.list_deg": 12.0},
    "noisy attitude": {**STILL, SENSORS + "attitude_noise_deg": 0.1, SENSORS + "rate_hz": 100.0},
    "heading askew": {**STILL, SENSORS + "heading_bias_deg": 2.0},
    "noisy place": {**STILL, SENSORS + "position_noise_m": 0.2, SENSORS + "rate_hz": 20.0},
}
BINS = [(25.0 * n, 25.0 * n + 25.0) for n in range(2, 6)]


def scene(**keys: Any) -> Scene:
    return sr.load_scene("rough_ride", overrides=keys)


def motion_of(made: Scene) -> tuple[Motion, Design, Any]:
    waves = waves_of(made.sea, np.pi / 0.8)
    found = Motion.of(made, made.radar, waves)
    assert found is not None
    return found, Design.of(made.radar, made.resolved_retrieval, made.scattering.decorrelation_time_s), waves


@pytest.mark.parametrize("case", CASES)
@pytest.mark.slow
def test_a_run_on_a_moving_boat_measures_as_much_as_the_outlook_says(case: str) -> None:
    """Height errors by range to 20 % (four turns of other seas: 96 waves to a bin, 7 %), the radius to 8 %."""
    made, squares, number, rings = scene(**CASES[case]), np.zeros(len(BINS)), np.zeros(len(BINS)), []
    for seed in (101, 102, 103, 104):
        simulator = Simulator(scene(**CASES[case], seed=seed))
        turn = next(iter(sr.iterate(simulator.scene, simulator=simulator)))
        assert turn.maps is not None
        polar, truth = turn.maps["polar"].to_dataset(), turn.truth["polar"].to_dataset()
        rings.append(CoverageProfile.of(polar, truth, simulator.sea.resolved.elevation_std))
        error = np.where(counted_cells(polar, truth), polar["height"].values - truth["height"].values, np.nan)
        for at, (near, far) in enumerate(BINS):
            inside = error[..., (polar["range"].values >= near) & (polar["range"].values < far)]
            squares[at] += np.nansum(inside**2)
            number[at] += np.isfinite(inside).sum()
    found = sr.outlook(made)
    told = [float(np.sqrt((found["height_error"].sel(range=slice(*each)) ** 2).mean())) for each in BINS]
    np.testing.assert_allclose(told, np.sqrt(squares / number), rtol=0.2)
    radius = reduce(operator.add, rings).fully_measured_radius
    assert found.attrs["fully_measured_radius_m"] == pytest.approx(radius, rel=0.08)


def test_a_boat_that_follows_the_waves_leans_as_its_closed_form_says() -> None:
    made = scene()
    found, *_ = motion_of(made)
    waves = ResolvedWaves.of(made.sea, np.pi / 0.8)
    # 320 s of waves of 5.5 s are 60 of them: 10 %; headings are one, not all.
    assert found.tilt_rms == pytest.approx(wave_tilt_std(waves, 7.0, 2.5), rel=0.2)
    assert found.lean.std() == pytest.approx(found.tilt_rms, rel=0.1)


@pytest.mark.parametrize("rate_hz", [5.0, 20.0, 100.0, 1000.0])
def test_noise_of_readings_averages_as_that_of_the_sensors_does(rate_hz: float) -> None:
    """Of the sensors' own readings, over windows of two looks at any moments: 4 % of scatter."""
    noisy = {SENSORS + "attitude_noise_deg": 0.1, SENSORS + "rate_hz": rate_hz}
    found, design, waves = motion_of(scene(**{**STILL, **noisy}))
    told = found.height_variance(design, waves)[0, -1] / design.ground[-1] ** 2
    sensors = Sensors(
        SensorSettings(attitude_noise_deg=0.1, rate_hz=rate_hz),
        lambda time: BoatState(np.zeros((np.size(time), 3)), np.zeros((np.size(time), 3))),
        1,
    )
    start = np.random.default_rng(2).uniform(0.0, 2000.0, 3000)
    each = start[:, None] + 2.0 * found.dwell_s * (np.arange(40) + 0.5) / 40.0
    mean = sensors(each.ravel()).attitude[:, 0].reshape(each.shape).mean(axis=1)
    assert told == pytest.approx(np.radians(mean).var(), rel=0.12)


@pytest.mark.parametrize(
    "key",
    [
        name
        for name in SensorSettings.model_fields
        if name not in ("rate_hz", "heading_noise_deg") and "accuracy" not in name
    ],
)
def test_every_error_of_the_sensors_costs_something(key: str) -> None:
    keys = {**STILL, **ROLLING}
    value = {"latency_s": 0.05, "height_bias_m": 0.2, "position_noise_m": 0.5, "heading_bias_deg": 2.0}.get(key, 0.3)
    perfect, wrong = sr.outlook(scene(**keys)), sr.outlook(scene(**{**keys, SENSORS + key: value}))
    assert wrong["height_error"].mean() > 1.1 * perfect["height_error"].mean()
    assert wrong.attrs["fully_measured_radius_m"] < perfect.attrs["fully_measured_radius_m"]


def test_a_boat_at_rest_costs_nothing_and_a_moving_one_its_difference() -> None:
    still, moving = sr.outlook(scene(**STILL)), sr.outlook("rough_ride")
    assert (still.attrs["motion"], moving.attrs["left_out"]) == ("", still.attrs["left_out"])
    assert still.attrs["radius_at_rest_m"] == still.attrs["fully_measured_radius_m"]
    assert moving.attrs["radius_at_rest_m"] == pytest.approx(still.attrs["fully_measured_radius_m"])
    assert "rms of lean" in moving.attrs["motion"]


def test_the_command_tells_what_motion_takes_of_each_mast(capsys: pytest.CaptureFixture[str]) -> None:
    with pytest.raises(SystemExit):
        main(["outlook", "rough_ride"])
    assert "\nthe boat's motion costs " in capsys.readouterr().out
    with pytest.raises(SystemExit):
        main(["outlook", "rough_ride", "--vary", "radar.height_m=4,8", "--at-most", "6"])
    said = capsys.readouterr().out
    assert "The motion costs (m)" in said.splitlines()[0]
    assert "taken as given" in said
    assert "of at most 6 m: 4 m" in said
    with pytest.raises(SystemExit):
        main(["outlook", "choppy_sea", "--vary", "radar.height_m=4,8"])
    assert "motion" not in capsys.readouterr().out


def test_a_recorded_motion_is_looked_at_all_through(tmp_path: Any) -> None:
    time = np.arange(0.0, 60.0, 0.1)
    rows = ["time_s,roll_deg", *(f"{t:.2f},{8.0 * np.sin(2.0 * np.pi * t / 4.0):.6f}" for t in time)]
    (tmp_path / "motion.csv").write_text("\n".join(rows))
    told = {"platform.motion": "file", "platform.file": str(tmp_path / "motion.csv")}
    swings = {"platform.motion": "sinusoidal", "platform.roll_deg": 8.0, "platform.roll_period_s": 4.0}
    recorded, sinusoidal = (sr.outlook(scene(**{**STILL, **each})) for each in (told, swings))
    assert isinstance(recorded, xr.Dataset)
    radii = [each.attrs["fully_measured_radius_m"] for each in (recorded, sinusoidal)]
    assert radii[0] == pytest.approx(radii[1], rel=0.01)


def test_a_lean_lifts_a_gaussian_beam_off_the_sea() -> None:
    """Of a beam of B at −3 dB an echo at the grazing angle ψ is met at −ψ − τ: against the beam's middle its two-way
    power loses twice 3.01 dB (2θ/B)²."""
    radar = sr.load_scene("choppy_sea", {"radar.antenna.pattern": "gaussian"}).radar
    ranges, lean = np.array([40.0, 100.0, 300.0]), np.radians([-4.0, -1.0, 2.0, 5.0])
    level = snr_of_unity(radar, ranges, lean)
    width, grazing = np.radians(radar.antenna.elevation_beamwidth_deg), np.arcsin(radar.height_m / ranges)
    lost = 80.0 * np.log10(2.0) * ((grazing + lean[:, None]) ** 2 - (grazing + lean[0]) ** 2) / width**2
    np.testing.assert_allclose(10.0 * np.log10(level / level[0]), -lost, atol=0.02)


def test_a_map_set_aside_is_wrong_by_what_the_sea_differs_by() -> None:
    """Waves of one length from all sides, looked up d aside: 2 σ² (1 − ⟨cos(k d cos θ)⟩). A heading turned by δψ sets a
    place R δψ aside, across the look; a place that is wrong in both directions lies aside by both; what attitude and
    height have wrong adds as R² δα² and δz²."""
    found, radar, waves = motion_of(scene(**{**STILL, **ROLLING}))
    radar, middle, share = replace(radar, cell_m=1e-6), waves.wavenumber.size // 2, 0.2 / waves.variance.shape[1]
    k, one = waves.wavenumber[middle], 0.0 * waves.variance
    one[middle] = share
    sea = waves._replace(variance=one)
    quiet = replace(found, attitude=0.0 * found.attitude, heading=0.0, up=0.0, aside=0.0, noise=(0.0,) * 4)
    np.testing.assert_allclose(quiet.height_variance(radar, sea), 0.0, atol=1e-12)
    theta = 2.0 * np.pi * (np.arange(720) + 0.5) / 720.0
    turned, off = np.radians(0.5), 0.03
    both = off * np.sqrt(2.0) * np.ones(radar.ranges.size)  # east and north
    for changed, away in (
        (replace(quiet, heading=turned**2), turned * radar.ground),
        (replace(quiet, aside=off**2), both),
    ):
        differs = 2.0 * 0.2 * (1.0 - np.cos(k * np.outer(away, np.cos(theta))).mean(axis=1))
        np.testing.assert_allclose(changed.height_variance(radar, sea)[0], differs, rtol=1e-6)
    noisy = replace(quiet, noise=(0.0, 0.0, 0.0, off**2)).height_variance(radar, sea)
    assert np.all(noisy[0] <= changed.height_variance(radar, sea)[0])  # a look averages it
    tilted = replace(quiet, attitude=np.full(quiet.attitude.shape, 1e-4), up=0.01).height_variance(radar, sea)
    np.testing.assert_allclose(tilted[0], radar.ground**2 * 1e-4 + 0.01, rtol=1e-9)


def test_sensors_that_are_late_on_a_boat_under_way_are_wrong_along_her_way() -> None:
    """By v τ, of whose square either direction has a half."""
    heaving = {**STILL, **ROLLING, "platform.roll_deg": 0.0, "platform.pitch_deg": 0.0}
    found, *_ = motion_of(scene(**{**heaving, "platform.speed_m_s": 5.0, SENSORS + "latency_s": 0.2}))
    assert 2.0 * found.aside == pytest.approx((5.0 * 0.2) ** 2, rel=1e-6)
