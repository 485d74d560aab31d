"""What the retrieval's options do, from echoes to maps."""

from __future__ import annotations

from functools import cache

import numpy as np
import pytest
import xarray as xr

from seamap_rt.dataset import QUALITY_FLAGS
from seamap_rt.interferometry import retrieve
from seamap_rt.interferometry.description import RadarDescription
from seamap_rt.interferometry.poses import edge_bias
from seamap_rt.radar.waveform import RangeResponse
from seamap_rt.scene import load_scene
from seamap_rt.settings import RetrievalSettings
from seamap_rt.simulation import Simulator, Turn
from seamap_rt.wavefield import sea_state
from seamap_rt.wavefield.sea_state import in_words


@cache
def turn() -> Turn:
    keys = {"radar.sector_deg": [200.0, 340.0], "radar.range_m": [15.0, 110.0], "tracing.tracer": "horizon"}
    keys |= {"tracing.diffraction": "none"}
    return Simulator(load_scene("choppy_sea", keys)).turn(0)


@cache
def maps(**asked: object) -> xr.DataTree:
    return retrieve(turn().echoes, RetrievalSettings.model_validate(asked))


def polar(**asked: object) -> xr.Dataset:
    return maps(**asked)["polar"].to_dataset().isel(turn=0)


def test_a_map_of_one_instant_is_nearer_to_the_sea_of_that_instant() -> None:
    scanned, at_once = (maps(**asked)["ground"].to_dataset().isel(turn=0) for asked in ({}, {"map_time_s": 0.75}))
    known = np.isfinite(at_once["height"].values)
    np.testing.assert_array_equal(at_once["time"].values[known], 0.75)
    assert at_once.attrs["map_time_s"] == 0.75
    x, y = np.meshgrid(at_once["x"].values, at_once["y"].values)
    sea = Simulator(load_scene("choppy_sea", {"tracing.tracer": "horizon"})).sea.elevation(x, y, np.full(x.shape, 0.75))
    late = known & np.isfinite(scanned["height"].values) & (np.abs(scanned["time"].values - 0.75) > 0.12)
    late &= np.hypot(x, y) < 80.0
    before, after = (np.sqrt(np.mean((each["height"].values - sea)[late] ** 2)) for each in (scanned, at_once))
    assert late.sum() > 200
    assert after < 0.8 * before


@pytest.mark.parametrize("estimator", ["adaptive", "sliding_plane", "single_cell"])
def test_slopes_have_errors_where_the_sea_is_known(estimator: str) -> None:
    # By `adaptive`, which knows the sea's covariance, each slope has one, and no cell without a height has any.
    found, ground = polar(estimator=estimator), maps(estimator=estimator)["ground"].to_dataset()
    known = np.isfinite(found["slope_range"].values)
    assert known.sum() > 1000
    assert not (known & np.isnan(found["height"].values)).any()
    for name in ("slope_range_std", "slope_azimuth_std", "slope_correlation"):
        stated = found[name].values
        np.testing.assert_array_equal(np.isfinite(stated), known & (estimator == "adaptive"))
        assert not (np.abs(stated) > 1.0).any()
    for name in ("slope_x", "slope_y"):
        tilted = np.isfinite(ground[name].values) & (estimator == "adaptive")
        np.testing.assert_array_equal(np.isfinite(ground[f"{name}_std"].values), tilted)
    least, most = found.attrs["slope_planes_m"]
    assert 6.0 <= least <= most <= 42.0  # m: twice the half-lengths' limits


def test_slopes_err_as_much_as_they_state() -> None:
    # 25 to 110 m. Of 8000 cells one in some dozens is independent: √(1/400) = 5 % of a spread.
    found, true = polar(), turn().truth["polar"].to_dataset().isel(turn=0)
    clear = (found["quality"].values == 0) & (found["range"].values > 25.0)
    for name in ("slope_range", "slope_azimuth"):
        ratio = ((found[name] - true[name]) / found[f"{name}_std"]).values[clear]
        ratio = ratio[np.isfinite(ratio)]
        assert 0.8 < 1.4826 * np.median(np.abs(ratio - np.median(ratio))) < 1.2
        assert 0.9 < np.mean(np.abs(ratio) < 1.96) < 0.99


def test_the_crest_bias_is_taken_off_on_request() -> None:
    reported, removed = polar(), polar(crest_bias="remove")
    known = np.isfinite(reported["height"].values)
    taken = (reported["height"] - removed["height"]).values[known]
    np.testing.assert_allclose(taken, reported["crest_bias"].values[known], atol=1e-6)
    assert taken.min() >= 0.0
    assert taken.max() > 0.01
    # What is reported and left is an error too.
    assert (removed["height_std"].values[known] <= reported["height_std"].values[known]).all()


def test_both_ways_and_one_tell_of_the_same_sea_and_both_err_less() -> None:
    both, one = polar(), polar(paths="one_way")
    assert (both.attrs["paths"], one.attrs["paths"]) == (2, 1)
    true = turn().truth["polar"].to_dataset().isel(turn=0)
    counted = (true["visible_fraction"].values > 0.5) & (both["range"].values > 75.0)
    counted &= np.isfinite(both["height"].values) & np.isfinite(one["height"].values)
    error = [np.sqrt(np.mean((each["height"] - true["height"]).values[counted] ** 2)) for each in (both, one)]
    assert error[0] < error[1]
    median = [np.median(each["height_std"].values[counted]) for each in (both, one)]
    assert median[0] < median[1]


def test_phases_lie_on_the_cycle_of_their_heights() -> None:
    found = polar()
    known = np.isfinite(found["height"].values) & ((found["quality"].values & QUALITY_FLAGS["ambiguous"]) == 0)
    assert known.mean() > 0.7
    # Optimal interpolation moves a phase within its own error, not by cycles.
    turned = (found["phase_unwrapped"] - found["phase"]).values[known] / (2.0 * np.pi)
    assert np.mean(np.abs(turned - np.round(turned)) < 0.25) > 0.97


def test_pulses_may_be_added_before_receivers_are_compared() -> None:
    apart, added = polar(), polar(coherent_s=1e-3)
    known = np.isfinite(apart["height"].values) & np.isfinite(added["height"].values)
    difference = (apart["height"] - added["height"]).values[known]
    assert 0.0 < np.std(difference) < 0.5 * np.median(apart["height_std"].values[known])


def test_sea_state_follows_from_the_maps() -> None:
    state = sea_state(maps())
    # A sector of 140° to 110 m holds some eight waves: 20 % of its height is chance.
    assert float(state["significant_wave_height"][0]) == pytest.approx(1.4, rel=0.35)
    assert in_words(state).startswith("Hs 1.")


def test_a_sea_state_in_words_is_that_of_the_last_turn_that_shows_one() -> None:
    one = sea_state(maps()).assign_attrs(depth_given=1)
    names = ("significant_wave_height", "peak_period", "mean_direction", "directional_spread", "noise_height")
    errors = {
        f"{name}_std": (one[f"{name}_std"].dims, [error]) for name, error in zip(names, (0.08, 0.2, 3.0), strict=False)
    }
    told = ((1.0, 5.0, 350.0, 20.0, 0.1), (1.5, 6.0, 20.0, 30.0, 0.1))
    turns = [
        one.assign({name: (one[name].dims, [value]) for name, value in zip(names, each, strict=True)} | errors)
        for each in told
    ]
    state = xr.concat(turns, "turn", data_vars="all")
    assert in_words(state) == "Hs 1.50 ± 0.08 m, Tp 6.0 ± 0.2 s, from 20° ± 3°, spread 30°"
    few = state.assign(
        significant_wave_height=("turn", [np.nan, np.nan]), significant_wave_height_least=("turn", [np.nan, 0.8])
    )
    assert in_words(few).startswith("Hs at least 0.80 m")
    dark = state.assign(noise_height=("turn", [np.nan, np.nan]))
    assert in_words(dark).startswith("sea state unknown")


def test_where_the_echo_grows_a_gate_hears_its_far_side() -> None:
    ranges = np.arange(30.0, 60.0, 1.5)
    response = RangeResponse(20e-9, 50e6)
    radar = RadarDescription(0.03, 0.0, "single", (0.0, 90.0), 1.0, 5.0, response, ranges)
    height = np.full((1, 1), 5.0)
    # A power that grows as exp(R/10 m) lies, in each gate, a tenth of the pulse's variance beyond its middle.
    grows = np.tile(np.exp(0.1 * ranges), (4, 1))
    np.testing.assert_allclose(
        edge_bias(grows, height, radar), 5.0 / ranges[None] * 0.1 * response.spread_m**2, rtol=1e-6
    )
    np.testing.assert_array_equal(edge_bias(np.ones((4, 20)), height, radar), 0.0)
    np.testing.assert_array_equal(edge_bias(np.full((4, 20), np.nan), height, radar), 0.0)
    # Looks that are not heard do not count.
    grows[1, ::2] = np.nan
    np.testing.assert_allclose(
        edge_bias(grows, height, radar), 5.0 / ranges[None] * 0.1 * response.spread_m**2, rtol=1e-6
    )


def test_a_boat_far_from_the_origin_sees_the_same() -> None:
    here, echoes = polar(), turn().echoes
    there = retrieve(echoes.assign(position=echoes["position"] + np.array([800.0, -300.0, 0.0])), RetrievalSettings())
    found = there["polar"].to_dataset().isel(turn=0)
    for name in ("height", "height_std"):
        known = np.isfinite(here[name].values) & np.isfinite(found[name].values)
        assert known.mean() > 0.99 * np.isfinite(here[name].values).mean()
        # A moving boat's windows are turned by what the level differs from gate to gate, not by its tangent.
        assert np.median(np.abs(found[name].values - here[name].values)[known]) < 2e-3
        assert np.mean(np.abs(found[name].values - here[name].values)[known] < 0.05) > 0.98


@pytest.mark.parametrize("channels", ["as_given", "from_cross_paths"])
def test_a_channel_that_is_known_or_found_changes_nothing(channels: str) -> None:
    # The upper receiver 10 dB louder, its noise as well: the noise that is told is the mean of both.
    echoes = turn().echoes
    voltage = echoes["voltage"].values.copy()
    voltage[:, 1] *= np.float32(np.sqrt(10.0))
    loud = echoes.assign(voltage=(echoes["voltage"].dims, voltage))
    loud.attrs["noise_power_w"] = echoes.attrs["noise_power_w"] * 5.5
    given = {"channel_gain_db": 10.0} if channels == "as_given" else {"channels": channels}
    found = retrieve(loud, RetrievalSettings.model_validate(given))["polar"].to_dataset().isel(turn=0)
    same = np.isfinite(found["height"].values) == np.isfinite(polar()["height"].values)
    assert same.mean() > 0.995
    both = np.isfinite(found["height"].values) & np.isfinite(polar()["height"].values)
    assert np.median(np.abs(found["height"].values - polar()["height"].values)[both]) < 2e-3
    np.testing.assert_allclose(np.nanmedian(found["snr_db"]), np.nanmedian(polar()["snr_db"]), atol=0.1)


def test_a_sea_too_small_to_be_seen_is_not_claimed_to_be_known() -> None:
    keys = {"radar.sector_deg": [200.0, 300.0], "radar.range_m": [15.0, 150.0], "tracing.tracer": "horizon"}
    calm = Simulator(load_scene("calm", keys)).turn(0)
    found, true = (each["polar"].to_dataset().isel(turn=0) for each in (retrieve(calm.echoes), calm.truth))
    counted = np.isfinite(found["height"].values) & (found["quality"].values == 0) & (found["range"].values > 30.0)
    error = ((found["height"] - true["height"]) / found["height_std"]).values[counted]
    assert counted.sum() > 1000
    assert np.mean(np.abs(error) < 1.96) > 0.9
