"""Forecasts, quiet windows and the command line, on a sea that is known wave by wave."""

from __future__ import annotations

import contextlib
import json
from dataclasses import replace
from typing import Any

import numpy as np
import pytest
import xarray as xr

from seamap_rt.cli import main as command
from seamap_rt.errors import InputError
from seamap_rt.physics.dispersion import Water
from seamap_rt.prediction import (
    Follower,
    Observations,
    Spectrum,
    WaveField,
    forecast,
    highest_wave,
    quiet_windows,
    reconstruct,
)
from seamap_rt.prediction.quantity import Course
from seamap_rt.report.page import write_report
from seamap_rt.settings import PredictionSettings

WATER = Water()
PEAK = 2.0 * np.pi / 5.5  # rad/s


def narrow_spectrum() -> Spectrum:
    """Hs 1.4 m at 5.5 s from the west."""
    omega = np.linspace(0.3, 4.0, 400)
    shape = np.exp(-(((omega - PEAK) / 0.15) ** 2) / 2.0)
    variance = (1.4 / 4.0) ** 2 * shape / np.trapezoid(shape, omega)
    return Spectrum.of_frequency(omega, variance, 270.0, 30.0)


def main(arguments: list[str]) -> int:
    """The exit code of a command."""
    with pytest.raises(SystemExit) as ended:
        command(arguments)
    return int(ended.value.code or 0)


class KnownSea:
    """A few free waves of Airy on deep water, from the west or so."""

    def __init__(self, seed: int = 5) -> None:
        stream = np.random.default_rng(seed)
        omega = PEAK + 0.1 * stream.standard_normal(12)
        toward = np.radians(90.0 + 15.0 * stream.standard_normal(12))
        k = WATER.wavenumber(omega)
        self.kx, self.ky, self.omega = k * np.sin(toward), k * np.cos(toward), omega
        self.amplitude = 0.35 / np.sqrt(6.0) * np.exp(2j * np.pi * stream.random(12))

    def elevation(self, x: np.ndarray, y: np.ndarray, time: np.ndarray) -> np.ndarray:
        turns = np.multiply.outer(x, self.kx) + np.multiply.outer(y, self.ky) - np.multiply.outer(time, self.omega)
        return (np.exp(1j * turns) @ self.amplitude).real


def seen(sea: KnownSea, count: int = 12_000, std: float = 0.02, start: float = 0.0) -> Observations:
    """Elevations at random places within 120 m over ten seconds."""
    stream = np.random.default_rng(1)
    away, azimuth = 120.0 * np.sqrt(stream.random(count)), 2.0 * np.pi * stream.random(count)
    x, y, time = away * np.sin(azimuth), away * np.cos(azimuth), start + 10.0 * stream.random(count)
    value = sea.elevation(x, y, time - start) + std * stream.standard_normal(count)
    return Observations(x, y, time, value, np.array([std]), np.array(["elevation"]))


@pytest.fixture(scope="module")
def field() -> WaveField:
    settings = PredictionSettings(sharpness=0.0, lead_s=30.0)
    return reconstruct(settings=settings, observations=seen(KnownSea()), spectrum=narrow_spectrum())


def test_waves_that_were_seen_run_on(field: WaveField) -> None:
    # Within reach of the slowest groups (4 m/s) ten seconds ahead, waves are known to a few hundredths of the sea.
    lead = np.arange(0.0, 11.0)
    truth = KnownSea().elevation(np.zeros(11), np.zeros(11), field.issued + lead)
    mean, _ = field.elevation(0.0, 0.0, field.issued + lead)
    assert np.sqrt(np.mean((mean - truth) ** 2)) < 0.1 * 0.35


def test_slopes_and_velocity_are_derivatives_of_elevation(field: WaveField) -> None:
    x, y, time, step = 11.0, -7.0, field.issued + 3.0, 0.05
    slopes, _ = field.slopes(x, y, time)
    velocity, _ = field.velocity(x, y, time)
    east, north, later = (
        (field.elevation(*up)[0] - field.elevation(*down)[0]) / (2.0 * step)
        for up, down in (
            ((x + step, y, time), (x - step, y, time)),
            ((x, y + step, time), (x, y - step, time)),
            ((x, y, time + step), (x, y, time - step)),
        )
    )
    # Central differences of waves longer than 10 m over 10 cm: 2e-4 of the derivative.
    np.testing.assert_allclose([slopes[0], slopes[1], velocity[2]], [east, north, later], atol=2e-3)


def test_a_map_and_a_series_of_the_same_place_agree(field: WaveField) -> None:
    x = np.linspace(-50.0, 50.0, 80)
    by_transform, _ = field.elevation(x, 3.0, field.issued + 2.0)
    one_by_one = [float(field.elevation(each, 3.0, field.issued + 2.0)[0]) for each in x[::16]]
    # Waves of less than a thousandth of the variance are left out of plain sums.
    np.testing.assert_allclose(by_transform[::16], one_by_one, atol=0.05 * 0.35)


def test_what_is_far_ahead_is_not_known(field: WaveField) -> None:
    _, std = field.elevation(0.0, 0.0, field.issued + np.array([5.0, 300.0]))
    assert std[0] < 0.3 * field.sea_std
    assert std[1] == pytest.approx(field.sea_std, rel=0.02)
    assert field.predictable(0.0, 0.0, field.issued + 300.0) < 0.04


def test_hours_make_no_difference() -> None:
    settings, spectrum = PredictionSettings(sharpness=0.0), narrow_spectrum()
    few = [
        reconstruct(settings=settings, observations=seen(KnownSea(), 3000, 0.05, start), spectrum=spectrum)
        for start in (0.0, 36_000.0)
    ]
    at = [each.elevation(5.0, 5.0, each.issued + np.arange(8.0))[0] for each in few]
    # The fit stops at 4e-2 of its right side, from other phases.
    np.testing.assert_allclose(at[0], at[1], atol=0.05 * 0.35)


def on_the_spot(
    field: WaveField, names: list[str], lead: np.ndarray, **vessel: Any
) -> tuple[list[Any], tuple[Any, Any, Any]]:
    """Quantities, and the way of a place that stays where it is."""
    nowhere = np.zeros(lead.size)
    return field.quantities(names, **vessel), (nowhere, nowhere, field.issued + lead)


def test_a_raft_goes_with_the_water(field: WaveField) -> None:
    names = ["elevation", "slope_x", "heave", "pitch"]
    wanted, way = on_the_spot(field, names, np.arange(0.0, 8.0), vessel=Follower(), course=Course(90.0, 0.0))
    elevation, slope, heave, pitch = field.predict(wanted, *way)
    np.testing.assert_allclose(heave[0], elevation[0], atol=1e-6)
    np.testing.assert_allclose(heave[1], elevation[1], rtol=1e-6)
    np.testing.assert_allclose(np.tan(pitch[0]), slope[0], atol=0.02)  # bow east: up where it rises
    np.testing.assert_allclose(pitch[1], slope[1], rtol=1e-6)


def test_draws_have_the_stated_error_and_hang_together(field: WaveField) -> None:
    wanted, way = on_the_spot(field, ["elevation"], np.arange(20.0, 60.0, 0.25))
    ((mean, std),), (draws,) = field.predict(wanted, *way), field.draws(wanted, *way, 400)
    spread = np.sqrt(np.mean((draws - mean) ** 2))
    assert spread == pytest.approx(np.sqrt(np.mean(std**2)), rel=0.06)  # 400 draws of some ten periods each
    error = (draws - mean)[:, -80:]
    near = np.mean(error[:, 1:] * error[:, :-1]) / np.mean(error**2)
    half = round(0.5 * 5.5 / 0.25)
    opposite = np.mean(error[:, half:] * error[:, :-half]) / np.mean(error**2)
    assert near > 0.9  # a quarter of a second of waves of 5.5 s: cos 16° = 0.96
    assert opposite < -0.6  # half a period on


def test_draws_of_a_raft_are_those_of_its_water(field: WaveField) -> None:
    wanted, way = on_the_spot(field, ["elevation", "heave"], np.arange(0.0, 50.0, 5.0), vessel=Follower())
    elevation, heave = field.draws(wanted, *way, 30)
    np.testing.assert_allclose(heave, elevation, atol=1e-5)


FINE = np.arange(0.0, 30.01, 0.25)


def test_quiet_windows_follow_limit_and_duration(field: WaveField) -> None:
    made = forecast(field, lead_s=FINE, draws=200)

    def chance(limit: dict[str, float], duration: float = 5.0) -> np.ndarray:
        return quiet_windows(made, limit, duration)["probability"].values

    assert np.all(chance({"elevation": 10.0}) == 1.0)
    assert np.all(chance({"elevation": 1e-3}) == 0.0)
    assert np.all(chance({"elevation": 0.3}) >= chance({"elevation": 0.2}))
    assert np.all(chance({"elevation": 0.4}, 6.0) <= chance({"elevation": 0.4}, 2.0)[:, :97])
    both = chance({"elevation": 0.3, "velocity_z": 0.3})
    assert np.all(both <= np.minimum(chance({"elevation": 0.3}), chance({"velocity_z": 0.3})))


def test_windows_count_the_draws_in_which_all_limits_hold_throughout() -> None:
    # Ten draws of constant height 0, 0.1 … 0.9 m, of which the second has a wave of 1 m 5 s from now, and of constant
    # velocity −0.9 … 0 m/s.
    lead, steps = np.arange(0.0, 10.5, 0.5), np.arange(10.0)[None, :, None, None] / 10.0
    height, velocity = steps + np.zeros((1, 10, lead.size, 1)), steps - 0.9 + np.zeros((1, 10, lead.size, 1))
    height[0, 1, lead == 5.0, 0] = 1.0
    dims = ("issue", "draw", "lead", "place")
    drawn = xr.Dataset({"elevation_draw": (dims, height), "velocity_z_draw": (dims, velocity)}, {"lead": lead})
    found = quiet_windows(drawn, {"elevation": 0.45}, 2.0, confidence=0.5)
    chance = found["probability"].values[0, :, 0]
    met = (found["lead"].values >= 3.0) & (found["lead"].values <= 5.0)
    assert chance[met].tolist() == [0.4] * int(met.sum())
    assert chance[found["lead"].values <= 2.0].tolist() == [0.5] * 5
    assert found["called"].values[0, :5, 0].all()
    assert not found["called"].values[0, met, 0].any()
    both = quiet_windows(drawn, {"elevation": 0.45, "velocity_z": 0.65}, 2.0)["probability"].values[0, :5, 0]
    assert both.tolist() == [0.2] * 5  # those of 0.3 and 0.4 m alone


@pytest.mark.parametrize("sign", [1.0, -1.0])
@pytest.mark.parametrize("passes", [4.03, 4.07])
def test_a_window_ends_when_its_duration_does(sign: float, passes: float) -> None:
    """Water that rises by 0.1 m a second passes the limit at a known moment, on the way up and, falling, down: windows
    of 2 s hold that end before it, or begin after it, to a tenth of a second. Splines follow a line exactly."""
    lead = np.arange(0.0, 10.25, 0.25)
    height = sign * 0.1 * np.stack((lead, lead[-1] - lead))[None, :, :, None]
    drawn = xr.Dataset({"elevation_draw": (("issue", "draw", "lead", "place"), height)}, {"lead": lead})
    found = quiet_windows(drawn, {"elevation": 0.1 * passes}, 2.0, confidence=0.5)
    begin = found["lead"].values
    np.testing.assert_allclose(begin, lead[lead <= 8.0])
    holds = np.stack((begin + 2.0 < passes, lead[-1] - begin < passes))
    np.testing.assert_array_equal(found["probability"].values[0, :, 0], holds.mean(axis=0))
    np.testing.assert_array_equal(found["called"].values[0, :, 0], holds.any(axis=0))
    surer = quiet_windows(drawn, {"elevation": 0.1 * passes}, 2.0, confidence=0.51)
    assert not surer["called"].values[0, ~holds.all(axis=0), 0].any()


def test_a_window_is_called_where_the_sea_is_known_to_be_quiet(field: WaveField) -> None:
    truth = KnownSea().elevation(np.zeros(49), np.zeros(49), field.issued + 0.25 * np.arange(49))
    limit = 1.15 * np.abs(truth[:9]).max()  # two seconds from now on hold it
    found = quiet_windows(forecast(field, lead_s=FINE), {"elevation": float(limit)}, 2.0)
    assert bool(found["called"][0, 0, 0])
    chance = found["probability"].values[0, :36:4, 0]
    held = np.array([np.abs(truth[4 * n : 4 * n + 9]).max() < limit for n in range(9)])
    sure = np.abs(chance - 0.5) > 0.45
    np.testing.assert_array_equal(chance[sure] > 0.5, held[sure])


def test_the_highest_wave_is_told_with_its_time(field: WaveField) -> None:
    # Over ten seconds, in which this sea is known to a tenth of σ: to a period's crest, and to half a second.
    lead = np.arange(0.0, 10.01, 0.1)
    truth = KnownSea().elevation(np.zeros(lead.size), np.zeros(lead.size), field.issued + lead)
    found = highest_wave(forecast(field), within_s=10.0)
    assert float(found["crest"][0, 0]) == pytest.approx(truth.max(), abs=0.15 * 0.35)
    assert float(found["lead"][0, 0]) == pytest.approx(lead[truth.argmax()], abs=0.5)
    assert float(found["chance"][0, 0]) > 0.5
    assert float(found["crest_low"][0, 0]) < float(found["crest"][0, 0]) < float(found["crest_high"][0, 0])


def test_the_highest_crest_is_told_by_the_order_of_its_draws() -> None:
    """101 draws of one crest each, of skewed heights: the median is the 51st, and 5 and 95 % lie at the 6th and 96th.
    Forty crests come at 6 s, thirty at 7.5 s, twenty at 9 s: within a second of any moment between 6.5 and 7 s come
    seventy of them. A trough is no crest, however deep, and what comes later than was asked does not count."""
    count, lead = 101, np.arange(0.0, 20.25, 0.25)
    heights = np.random.default_rng(3).permutation(np.exp(np.linspace(-2.0, 1.0, count)))
    moments = np.repeat((6.0, 7.5, 9.0, 14.0), (40, 30, 20, 11))
    bumps = heights[:, None] * np.exp(-0.5 * ((lead - moments[:, None]) / 0.5) ** 2)
    drawn = bumps - 5.0 * np.exp(-0.5 * ((lead - 17.0) / 0.5) ** 2)
    made = xr.Dataset({"elevation_draw": (("issue", "draw", "lead", "place"), drawn[None, :, :, None])}, {"lead": lead})
    found = highest_wave(made)
    ordered = np.sort(heights)
    for name, place in (("crest_low", 5), ("crest", 50), ("crest_high", 95)):
        assert float(found[name][0, 0]) == pytest.approx(ordered[place], rel=1e-3)  # of the spline
    assert float(found["lead"][0, 0]) == pytest.approx(6.75, abs=1e-6)
    assert float(found["chance"][0, 0]) == pytest.approx(70.0 / count)
    early = highest_wave(made.isel(draw=moments == 9.0), within_s=8.5)
    share = np.exp(-0.5)  # of a crest half a second before it
    assert float(early["crest"][0, 0]) == pytest.approx(share * np.median(heights[moments == 9.0]), rel=1e-2)


def test_a_boat_under_way_meets_the_waves_where_it_then_is(field: WaveField) -> None:
    made = forecast(field, [(10.0, 0.0)], [0.0, 4.0], heading_deg=270.0, speed_m_s=5.0, vessel=Follower(), draws=0)
    mean, _ = field.elevation(-10.0, 0.0, field.issued + 4.0)
    assert float(made["elevation"][0, 1, 0]) == pytest.approx(float(mean), abs=1e-5)
    assert float(made["heave"][0, 1, 0]) == pytest.approx(float(mean), abs=1e-5)
    _, slopes = field.slopes(-10.0, 0.0, field.issued + 4.0)
    # Roll, not pitch, is of the slope across: on a western course the bow is up where the sea falls towards east.
    assert float(made["pitch_std"][0, 1, 0]) == pytest.approx(np.degrees(slopes[0]), rel=1e-3)


def test_a_forecast_keeps_the_schema_and_says_what_is_known(field: WaveField) -> None:
    made = forecast(field, [(0.0, 0.0), (30.0, -20.0)], [0.0, 10.0, 200.0])
    assert made["elevation"].shape == (1, 3, 2)
    mean, std = field.elevation(30.0, -20.0, field.issued + 10.0)
    assert float(made["elevation"][0, 1, 1]) == pytest.approx(float(mean), abs=1e-5)
    assert float(made["elevation_std"][0, 1, 1]) == pytest.approx(float(std), rel=1e-5)
    assert np.all(made["predictable"][0, 2] < 0.05)


def test_sinking_water_is_put_back() -> None:
    # Where nothing is known, nothing is added either; the mean level over many places is zero to a hundredth of σ.
    settings = PredictionSettings(sharpness=1.0)
    sharp = reconstruct(settings=settings, observations=seen(KnownSea(), 4000), spectrum=narrow_spectrum())
    stream = np.random.default_rng(2)
    x, y = 90.0 * (stream.random((2, 4000)) - 0.5)
    mean, _ = sharp.elevation(x, y, np.repeat(sharp.issued + np.arange(-4.0, 4.0), 500))
    plain, _ = replace(sharp, sharpness=0.0).elevation(x, y, np.repeat(sharp.issued + np.arange(-4.0, 4.0), 500))
    lower = sharp.spectrum.variance * WATER.wavenumber(PEAK)  # k σ² of a narrow sea, which is what sharp crests lack
    assert np.mean(mean - plain) == pytest.approx(0.0, abs=0.6 * float(lower))  # a dozen waves on a square


@pytest.mark.parametrize(
    ("asked", "said"),
    [
        ({"limit": {"height": 1.0}}, "'height' is not known"),
        ({"limit": {}}, "limit: is empty"),
        ({"limit": {"heave": 1.0}}, "heave: the forecast holds no draws of it; give the vessel"),
        ({"limit": {"elevation": 1.0}, "duration_s": 40.0}, "duration_s = 40: is longer than the forecast"),
        ({"limit": {"elevation": 0.0}}, "elevation = 0: must be finite and above 0"),
        ({"limit": {"elevation": 1.0}, "duration_s": -1.0}, "duration_s = -1"),
        ({"limit": {"elevation": 1.0}, "confidence": 1.0}, "confidence = 1: must lie between 0 and 1"),
    ],
)
def test_windows_that_cannot_be_asked_for(field: WaveField, asked: dict, said: str) -> None:
    with pytest.raises(InputError, match=said):
        quiet_windows(forecast(field, draws=2), **asked)


def test_windows_need_draws_close_in_time(field: WaveField) -> None:
    with pytest.raises(InputError, match="steps of 1 s are too long"):
        quiet_windows(forecast(field, lead_s=np.arange(10.0), draws=2), {"elevation": 1.0})
    with pytest.raises(InputError, match="forecast with draws above 0"):
        highest_wave(forecast(field, draws=0))
    with pytest.raises(InputError, match="within_s = -1: no lead"):
        highest_wave(forecast(field, draws=2), within_s=-1.0)


def test_forecasts_that_cannot_be_asked_for(field: WaveField) -> None:
    with pytest.raises(InputError, match="pairs of metres"):
        forecast(field, [(0.0, np.nan)])
    with pytest.raises(InputError, match="finite seconds"):
        forecast(field, lead_s=[np.inf])
    with pytest.raises(InputError, match="speed_m_s = nan: must be finite"):
        forecast(field, speed_m_s=np.nan)
    with pytest.raises(InputError, match="draws = -1: must be at least 0"):
        forecast(field, draws=-1)
    with pytest.raises(InputError, match="give maps, or observations and the spectrum"):
        reconstruct(observations=seen(KnownSea(), 10))


@pytest.fixture(scope="module")
def maps_file(tmp_path_factory: pytest.TempPathFactory):
    """Maps of two turns of the tiny scene, and the forecasts made beside the run."""
    folder = tmp_path_factory.mktemp("predict")
    settings = ["turns=2", "tracing.tracer=horizon", "prediction.vessel.shape=raft", "prediction.quiet.elevation_m=0.4"]
    given = [word for each in settings for word in ("--set", each)]
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr("seamap_rt.report.style.DPI", 40)  # nothing here looks at pixels
        patch.setattr("seamap_rt.session.report_process.ReportProcess", lambda: contextlib.nullcontext(write_report))
        assert main(["run", "tiny", "--predict", "--out", str(folder), *given]) == 0
    return folder / "maps.nc"


def test_forecasts_beside_a_run_are_those_of_its_maps(maps_file, tmp_path) -> None:
    asked = ["--lead", "0:30:0.5", "--set", "prediction.vessel.shape=raft", "--set", "prediction.quiet.elevation_m=0.4"]
    assert main(["predict", str(maps_file), *asked, "--out", str(tmp_path)]) == 0
    with (
        xr.open_dataset(tmp_path / "prediction.nc") as after,
        xr.open_dataset(maps_file.parent / "prediction.nc") as made,
    ):
        xr.testing.assert_allclose(after, made, atol=2e-3)  # maps on file hold heights as float32
        assert np.all((made["quiet"] >= 0.0) & (made["quiet"] <= 1.0) | (made["lead"] > 25.0))
        np.testing.assert_allclose(made["heave"], made["elevation"], atol=0.05)  # sharp crests ride on their own waves


def test_a_run_judges_its_forecasts(maps_file) -> None:
    rows = json.loads((maps_file.parent / "metrics.json").read_text())["prediction"]
    assert [row["lead_s"] for row in rows] == [[0.0, 0.0], [1.0, 4.0], [5.0, 10.0], [11.0, 20.0], [21.0, 30.0]]
    assert rows[0]["forecasts"] == 2
    assert all(row["stated_share"] > 0.0 and 0.0 <= row["within"] <= 1.0 for row in rows)
    page = (maps_file.parent / "report.html").read_text()
    assert all(title in page for title in ("The wave field through the shadows", "Forecasts run ahead of the sea"))


def test_a_run_judges_its_quiet_windows(maps_file) -> None:
    told = json.loads((maps_file.parent / "metrics.json").read_text())["quiet_windows"]
    with xr.open_dataset(maps_file.parent / "prediction.nc") as made:
        chance = made["quiet"].values[np.isfinite(made["quiet"].values)]
    assert told["windows"] == chance.size
    assert told["called"] == np.sum(chance >= told["confidence"])
    page = (maps_file.parent / "report.html").read_text()
    assert ("Quiet windows against the sea that came" in page) == (told["area"] is not None)
    assert "Called at 90%" in page


def test_predict_writes_a_forecast_for_each_turn(maps_file, tmp_path, capsys) -> None:
    asked = ["--lead", "0:20:5", "--at=0,0", "--at=-20,5", "--out", str(tmp_path)]
    assert main(["predict", str(maps_file), *asked]) == 0
    assert "2 forecasts from 2 turns" in capsys.readouterr().out
    with xr.open_dataset(tmp_path / "prediction.nc") as made:
        assert dict(made.sizes) == {"issue": 2, "lead": 5, "place": 2}
        assert np.isfinite(made["elevation"]).all()
        assert np.all(made["elevation_std"] > 0.0)
        np.testing.assert_allclose(made["east"], [[0.0, -20.0]] * 2)
        assert np.all(np.diff(made["issued"]) > 0.0)
    assert main(["predict", str(maps_file), *asked]) == 2  # never overwritten unasked
    assert "--overwrite" in capsys.readouterr().err


@pytest.mark.parametrize(
    ("asked", "said"),
    [
        (["--lead", "0:90:1"], "--lead 0:90:1: must run from 0 s"),
        (["--lead", "5"], "must be START:STOP:STEP"),
        (["--lead", "0:30:0.0001"], "widen STEP"),
        (["--at", "here"], "must be EAST,NORTH"),
        (["--at", "nan,0"], "must be within 10000 m"),
        (["--at", "-20000,0"], "must be within 10000 m"),  # west is no option of the command
        (["--set", "radar.height_m=3"], "takes only prediction.KEY"),
        (["--set", "prediction.turns=0"], "prediction.turns = 0"),
        (["--set", "prediction.quiet.heave_m=1"], "there is no vessel; give vessel.shape"),
        (["--set", "prediction.vessel.shape=box"], 'length_m is missing; shape = "box" needs it'),
        (["--set", "prediction.vessel.beam_m=2"], 'beam_m is given, but shape = "none" has none'),
        (["--set", "prediction.vessel.shape=file", "--set", "prediction.vessel.file=no.nc"], "no.nc: no such file"),
        (["--lead", "0:2:1", "--set", "prediction.quiet.elevation_m=1"], "is longer than lead_s = 2; shorten it"),
    ],
)
def test_predict_refuses_in_one_line(maps_file, capsys, asked: list[str], said: str) -> None:
    earlier = (maps_file.parent / "prediction.nc").read_bytes()
    assert main(["predict", str(maps_file), "--overwrite", *asked]) == 2
    told = capsys.readouterr().err
    assert said in told
    assert told.count("\n") == 1
    assert (maps_file.parent / "prediction.nc").read_bytes() == earlier


def test_predict_refuses_what_is_no_map(tmp_path, capsys) -> None:
    wrong = tmp_path / "maps.nc"
    assert main(["predict", str(wrong)]) == 2
    assert "no such file" in capsys.readouterr().err
    xr.Dataset({"height": ("x", [1.0])}).to_netcdf(wrong, engine="h5netcdf")
    assert main(["predict", str(wrong)]) == 2
    assert "the group 'polar' is missing" in capsys.readouterr().err
    wrong.write_bytes(wrong.read_bytes()[:-100])
    assert main(["predict", str(wrong)]) == 2
    assert "cannot be read as NetCDF" in capsys.readouterr().err
    wrong.write_text("no file of this kind")
    assert main(["predict", str(wrong)]) == 2
    assert "cannot be read as NetCDF" in capsys.readouterr().err
