"""What gauges read: the wire is the true surface, the radar's record is the map."""

from __future__ import annotations

import functools
from typing import Any

import numpy as np
import pytest
import xarray as xr
from made_gauges import a_sea, deep_water, gauge, made_maps, plane
from numpy.testing import assert_allclose, assert_array_equal

from seamap_rt.dataset import QUALITY_FLAGS, check
from seamap_rt.errors import InputError
from seamap_rt.gauges import gauge_series, judge, sample_times
from seamap_rt.interferometry import retrieve
from seamap_rt.settings import GaugeSettings, RadarSettings
from validation import analytic

# --------------------------------------------------------------------------------------------------------- the wire


def test_a_gauge_on_a_flat_sea_reads_nothing() -> None:
    series = gauge_series(made_maps(lambda x, y, t: 0.0 * x), a_sea(), [gauge()], turn_s=1.0)
    for name in ("true_height", "seen_true_height", "height"):
        assert_array_equal(series[name].values, 0.0)
    assert series.sizes == {"gauge": 1, "turn": 1, "sample": 4}


def test_the_wire_in_a_regular_wave_is_its_closed_form() -> None:
    sea = a_sea(spectrum="sinusoid", height_m=1.0, wavelength_m=40.0, phase_deg=30.0, wave_from_deg=300.0)
    places = [gauge("a"), gauge("b", ground_range_m=50.0, azimuth_deg=300.0)]
    series = gauge_series(made_maps(lambda x, y, t: 0.0 * x, turns=7, period=1.3), sea, places, turn_s=1.3)
    k, time = 2.0 * np.pi / 40.0, series["time"].values
    toward = np.radians(120.0)
    for number, (x, y) in enumerate([(-60.0, 4.0), (-50.0 * np.sin(np.pi / 3.0), 50.0 * np.cos(np.pi / 3.0))]):
        angle = k * (x * np.sin(toward) + y * np.cos(toward)) + np.radians(30.0)
        # Rounding alone: a sum of one wave in float64.
        assert_allclose(
            series["true_height"].values[number], 0.5 * np.cos(angle - deep_water(40.0) * time), rtol=0.0, atol=1e-12
        )
        seen = series["seen_time"].values[number]
        assert_allclose(
            series["seen_true_height"].values[number],
            0.5 * np.cos(angle - deep_water(40.0) * seen),
            rtol=0.0,
            atol=1e-12,
        )


def test_the_wire_in_choppy_waves_reads_what_stands_over_its_place() -> None:
    """A trochoid: crest and trough stand at ±h/2 about a mean that is higher by k a²/2 under the crests' sharpness."""
    sea = a_sea("choppy", spectrum="sinusoid", height_m=2.0, wavelength_m=40.0)
    maps = made_maps(lambda x, y, t: 0.0 * x, turns=30)
    wire = gauge_series(maps, sea, [GaugeSettings(name="w", east_m=10.0, north_m=0.0, sample_hz=50.0)], turn_s=1.0)
    elevation = wire["true_height"].values[0]
    set_down = 0.5 * 2.0 * np.pi / 40.0  # k a²/2 with a = 1 m, put back so that the mean is 0
    # 50 samples a second meet crest and trough to within a ω²/8 f² = 0.1 mm.
    assert_allclose(elevation.max(), 1.0 + set_down, atol=1e-3)
    assert_allclose(elevation.min(), -1.0 + set_down, atol=1e-3)


@pytest.mark.parametrize(("period", "rate"), [(1.0, 4.0), (1.25, 3.7), (0.05, 4.0), (2.5, 0.1)])
def test_no_sample_is_taken_twice_or_left_out(period: float, rate: float) -> None:
    joined = np.concatenate([sample_times(turn, period, rate) for turn in range(40)])
    assert_allclose(joined, np.arange(joined.size) / rate, rtol=1e-15)
    assert joined[-1] < 40.0 * period <= joined[-1] + 1.0 / rate + 1e-9


# ---------------------------------------------------------------------------------------------- the map at a gauge


@pytest.mark.parametrize("place", [(-60.0, 4.0), (31.7, -22.2), (0.4, -50.1), (33.0, 33.0)])
def test_a_plane_is_read_exactly_between_cells(place: tuple[float, float]) -> None:
    series = gauge_series(made_maps(plane), None, [gauge(east_m=place[0], north_m=place[1])], turn_s=1.0)
    # The map's heights are float32, of 2 m at most.
    assert_allclose(series["height"].values[0, 0], 0.02 * place[0] - 0.03 * place[1] + 0.5, atol=3e-7)
    assert_allclose(series["height_std"].values, 0.1, rtol=1e-6)


def test_cells_without_a_height_leave_their_part_to_the_others() -> None:
    maps = made_maps(plane)
    wire = gauge(east_m=-59.0, north_m=4.0)  # in the cell at (-60, 3), beside those at -57 and at 6
    height = maps["ground"].dataset["height"].values[0]
    row, column = 31, 10
    ground = maps["ground"].to_dataset()
    assert_array_equal((ground["y"].values[row], ground["x"].values[column]), (3.0, -60.0))
    height[row : row + 2, column + 1] = np.nan
    got = gauge_series(maps, None, [wire], turn_s=1.0)["height"].values[0, 0]
    assert_allclose(got, 0.02 * -60.0 - 0.03 * 4.0 + 0.5, atol=3e-7)  # on the line between the two that are left
    height[row, column] = np.nan
    assert np.isnan(gauge_series(maps, None, [wire], turn_s=1.0)["height"].values).all()


def test_cells_on_the_other_side_of_the_turns_start_do_not_count() -> None:
    """North of the antenna a turn begins: cells to the west were seen a second later."""
    maps = made_maps(lambda x, y, t: t)
    for east, time in ((0.6, 0.0), (-1.8, 1.0)):
        series = gauge_series(maps, None, [gauge(east_m=east, north_m=60.0)], turn_s=1.0)
        assert abs(series["height"].values[0, 0] - time) < 0.02  # 3 m at 60 m are 0.008 of a turn
        assert_allclose(series["seen_time"].values, series["height"].values, atol=1e-6)


def test_a_truth_of_another_instant_is_not_compared() -> None:
    """Maps whose waves' direction is not known stay as they were scanned, while their truth stands at one instant."""
    maps = made_maps(lambda x, y, t: 0.0 * x + 2.0, turns=2)
    for late, expected in ((0.0, 2.0), (0.3, np.nan)):
        ground = maps["ground"].to_dataset()
        truth = xr.DataTree.from_dict({"/ground": ground.assign(time=ground["time"] + late)})
        series = gauge_series(maps, None, [gauge()], truth, turn_s=1.0)
        assert_allclose(series["seen_cell_height"].values, [[expected, expected]], equal_nan=True)


def test_flags_are_those_of_the_polar_cell_at_the_gauge() -> None:
    maps = made_maps(plane)
    wire = gauge(ground_range_m=20.0, azimuth_deg=123.0)
    polar = maps["polar"].to_dataset()
    assert polar["azimuth"].values[61] == 123.0
    assert polar["range"].values[4] == 21.0  # the antenna stands 5 m high: the gauge is 20.6 m off, not 20
    maps["polar"].dataset["quality"].values[0, 61, 4] = QUALITY_FLAGS["partly_shadowed"]
    series = gauge_series(maps, None, [wire, gauge()], turn_s=1.0)
    assert_array_equal(series["quality"].values[:, 0], [QUALITY_FLAGS["partly_shadowed"], 0])


@pytest.mark.parametrize("antenna", [(0.0, 0.0), (12.0, -7.0)])
def test_flags_count_from_where_the_antenna_is(antenna: tuple[float, float]) -> None:
    maps = made_maps(plane)
    maps["polar"].dataset["quality"].values[0, 45, 20] = 2  # azimuth 91°, range 45 m
    ground = np.sqrt(45.0**2 - 25.0)
    east, north = ground * np.sin(np.radians(91.0)), ground * np.cos(np.radians(91.0))
    wire = gauge(east_m=antenna[0] + east, north_m=antenna[1] + north)
    assert gauge_series(maps, None, [wire], turn_s=1.0, antenna_m=antenna)["quality"].values == 2
    assert gauge_series(maps, None, [wire], turn_s=1.0, antenna_m=(-20.0, 0.0))["quality"].values != 2


def test_a_gauge_beyond_the_map_has_no_echo() -> None:
    series = gauge_series(made_maps(plane), a_sea(), [gauge(east_m=140.0, north_m=0.0)], turn_s=1.0)
    assert series["quality"].values == QUALITY_FLAGS["no_echo"]
    for name in ("height", "seen_time", "seen_true_height"):
        assert np.isnan(series[name].values).all()
    assert np.isfinite(series["true_height"].values).all()


def test_recorded_maps_need_no_sea_and_tell_their_own_turns() -> None:
    series = gauge_series(made_maps(plane, turns=3, period=2.5), None, [gauge("a"), gauge("b")])
    check("gauges", series)
    assert not {"true_height", "seen_true_height", "seen_cell_height"} & set(series.variables)
    assert_array_equal(series["gauge"].values, ["a", "b"])
    assert_allclose(np.diff(series["seen_time"].values), 2.5)
    wire = gauge_series(made_maps(plane, turns=3, period=2.5), a_sea(), [gauge()])
    assert_allclose(wire["time"].values, np.arange(30) / 4.0)  # three turns of 2.5 s


@pytest.mark.parametrize(("gauges", "words"), [([], "there are none"), ([gauge()], "turn_s: is missing")])
def test_what_cannot_be_read_is_one_line(gauges: list[GaugeSettings], words: str) -> None:
    with pytest.raises(InputError, match=words):
        gauge_series(made_maps(plane), None, gauges)


@functools.cache
def sinusoid_seen(turns: int = 10) -> tuple[xr.Dataset, float]:
    """A gauge in a travelling regular wave, whose echoes are of closed form, speckled; and the wave's height."""
    radar = RadarSettings(
        sector_deg=(261.0, 279.0), range_m=(15.0, 100.0), prf_hz=3000.0, baseline_m=0.4, rotation_rpm=60.0
    )
    wire = GaugeSettings(name="wire", east_m=-55.0, north_m=1.0)
    size: dict[str, Any] = {"height_m": 0.8, "wavelength_m": 40.0, "wave_from_deg": 270.0}
    omega = deep_water(40.0)
    parts: dict[str, list[xr.Dataset]] = {"polar": [], "ground": []}
    for turn in range(turns):
        # The closed form stands still: as it is when the beam passes the gauge, in the sector's middle.
        passes = turn + (np.degrees(np.arctan2(-55.0, 1.0)) % 360.0 - 261.0) / 360.0
        still = analytic.SinusoidSea(**size, phase_deg=float(-np.degrees(omega * passes)))
        maps = retrieve(analytic.echoes(still, radar, coherence=0.98, looks=6.0, snr_db=25.0, seed=turn))
        for group, found in parts.items():
            each = maps[group].to_dataset()
            found.append(each.assign(time=each["time"] + turn).assign_coords(turn=[turn]))
    whole = xr.DataTree.from_dict({f"/{name}": xr.concat(found, "turn") for name, found in parts.items()})
    sea = a_sea(spectrum="sinusoid", **size)
    return gauge_series(whole, sea, [wire], turn_s=1.0), size["height_m"]


def test_the_radar_follows_a_regular_wave_to_its_stated_error() -> None:
    series, height = sinusoid_seen()
    error = (series["height"] - series["seen_true_height"]).values[0]
    stated = series["height_std"].values[0]
    assert np.isfinite(error).all()
    # Ten heights: χ² of ten degrees of freedom is below 2.3 times its mean with 98.9 %. What 3 m cells and bilinear
    # reading take of a wave of 40 m, 1 − sinc²(3/40)·… = 2 % of 0.4 m, lies far below it.
    assert np.sqrt(np.mean((error / stated) ** 2)) < np.sqrt(2.3)
    assert np.sqrt(np.mean(error**2)) < 0.12 * height  # and the stated error itself is small: the wave is seen
    (entry,) = judge(series)
    assert entry["correlation"] > 0.95
