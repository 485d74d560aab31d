"""Wave gauges: the wire is the surface, the radar's record is the map, and what is said of the two is true."""

from __future__ import annotations

import functools
import json
from pathlib import Path
from typing import Any

import numpy as np
import pytest
import xarray as xr
from numpy.testing import assert_allclose, assert_array_equal

from seamap_rt import analytic
from seamap_rt.conventions import GRAVITY, SURFACE_TENSION, WATER_DENSITY
from seamap_rt.dataset import QUALITY_FLAGS, build, check
from seamap_rt.errors import InputError
from seamap_rt.gauges import GaugeFile, GaugeSpectra, NoSpectrum, gauge_series, judge, judge_one, spectra
from seamap_rt.gauges.reading import sample_times
from seamap_rt.interferometry import retrieve
from seamap_rt.report import style
from seamap_rt.scene import load_scene
from seamap_rt.sea import Sea, realize
from seamap_rt.session import RunResult, run
from seamap_rt.settings import GaugeSettings, RadarSettings, SeaSettings


def deep_water(wavelength: float) -> float:
    """Angular frequency [rad/s] of gravity–capillary waves."""
    k = 2.0 * np.pi / wavelength
    return float(np.sqrt(GRAVITY * k + SURFACE_TENSION / WATER_DENSITY * k**3))


def gauge(name: str = "wire", **place: float) -> GaugeSettings:
    return GaugeSettings(name=name, **(place or {"east_m": -60.0, "north_m": 4.0}))


def made_maps(height: Any, turns: int = 1, period: float = 1.0, quality: int = 0) -> xr.DataTree:
    """Maps of a full turn whose heights are height(x, y, t), known everywhere; azimuth is time."""
    places = 3.0 * np.arange(-30.0, 31.0)
    x, y = np.meshgrid(places, places)
    number = np.arange(turns)
    time = period * (number[:, None, None] + np.degrees(np.arctan2(x, y)) % 360.0 / 360.0)
    values = np.broadcast_to(height(x, y, time), time.shape)
    ground = {"height": values, "height_std": 0.0 * values + 0.1, "slope_x": values, "slope_y": values, "time": time}
    azimuth, ranges = np.arange(1.0, 360.0, 2.0), np.arange(15.0, 90.0, 1.5)
    shape = (turns, azimuth.size, ranges.size)
    names = (
        "height", "height_std", "slope_range", "slope_azimuth", "coherence", "phase", "phase_unwrapped", "snr_db",
    )  # fmt: skip
    polar: dict[str, Any] = {name: np.zeros(shape) for name in names}
    polar["ground_range"] = np.broadcast_to(np.sqrt(ranges**2 - 25.0), shape)
    polar["time"] = period * (number[:, None] + azimuth / 360.0)
    polar["quality"] = np.full(shape, quality)
    cells = {"cell_range_m": 3.0, "cell_azimuth_deg": 2.0}
    return xr.DataTree.from_dict(
        {
            "/polar": build("maps/polar", polar, {"turn": number, "azimuth": azimuth, "range": ranges}, cells),
            "/ground": build("maps/ground", ground, {"turn": number, "y": places, "x": places}),
        }
    )


def a_sea(model: str = "linear", **waves: Any) -> Sea:
    settings = {"model": model, "waves": [waves or {"spectrum": "flat"}], "extent_m": 64.0, "resolution_m": 1.0}
    return realize(SeaSettings.model_validate(settings), 1)


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


def plane(x: np.ndarray, y: np.ndarray, t: np.ndarray) -> np.ndarray:
    return 0.02 * x - 0.03 * y + 0.5 + 0.0 * t


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


# ------------------------------------------------------------------------------------------------------ what is said


def record(wire: Any, turns: int = 120, period: float = 1.0, error: Any = None) -> xr.Dataset:
    """A gauge whose wire is wire(t), and whose radar errs by error (turn,)."""
    time = np.concatenate([sample_times(turn, period, 8.0) for turn in range(turns)])
    seen = period * (np.arange(turns) + 0.25)
    true = wire(seen)
    return build(
        "gauges",
        {
            "east": [1.0], "north": [2.0], "true_height": wire(time)[None], "seen_time": seen[None],
            "height": (true + (0.0 if error is None else error))[None], "height_std": np.full((1, turns), 0.1),
            "quality": np.zeros((1, turns)), "seen_true_height": true[None], "seen_cell_height": 0.9 * true[None],
        },
        {"turn": np.arange(turns), "time": time},
    ).assign_coords(gauge=["made"])  # fmt: skip


def test_figures_are_those_of_the_record() -> None:
    random = np.random.default_rng(3)
    error = random.normal(size=400)
    series = record(lambda t: np.sin(2.0 * np.pi * 0.13 * t), 400, error=0.0 * error)
    true = series["seen_true_height"].values[0]
    found = 0.8 * true + 0.05 + 0.1 * error
    series["height"].values[0] = found
    (entry,) = judge(series)
    assert entry["name"] == "made"
    difference = found - true
    assert_allclose(entry["rms_error_m"], np.sqrt(np.mean(difference**2)), rtol=1e-6)
    assert_allclose(entry["bias_m"], difference.mean(), rtol=1e-5)
    assert_allclose(entry["correlation"], np.corrcoef(true, found)[0, 1], rtol=1e-6)
    assert_allclose(entry["regression_slope"], np.polyfit(true, found, 1)[0], rtol=1e-6)
    assert abs(entry["regression_slope"] - 0.8) < 3.0 * 0.1 / np.sqrt(400 * 0.5)  # three standard errors
    assert_allclose(entry["averaging_rms_m"], 0.1 * np.sqrt(0.5), rtol=0.01)  # whole waves but for a hundredth
    assert_allclose(entry["hs_wire_m"], 4.0 * np.sqrt(0.5), rtol=0.01)
    assert entry["waves"] in (51, 52)  # 0.13 Hz for 400 s
    assert entry["answered"] == 1.0


def test_spectra_hold_the_variance() -> None:
    random = np.random.default_rng(5)
    noise = random.normal(size=4096)
    found = spectra(record(lambda t: np.interp(t, np.arange(4096.0), noise), 4096).isel(gauge=0))
    assert isinstance(found, GaugeSpectra)
    series = np.interp(np.arange(4096) + 0.25, np.arange(4096.0), noise)
    width = found.frequency[1] - found.frequency[0]
    # Two of 256 frequencies are left out; the windows weigh the record unevenly: some per cent.
    assert_allclose(found.radar.sum() * width, series.var(), rtol=0.05)
    assert_allclose(found.radar, found.wire_once_a_turn, rtol=1e-5)  # float32 heights


@pytest.mark.parametrize(("frequency", "seen", "share"), [(0.21, 0.21, 0.0), (0.71, 0.29, 1.0)])
def test_what_is_faster_than_half_the_turn_rate_folds_and_is_said_to(
    frequency: float, seen: float, share: float
) -> None:
    series = record(lambda t: np.sin(2.0 * np.pi * frequency * t))
    found = spectra(series.isel(gauge=0))
    assert isinstance(found, GaugeSpectra)
    assert found.frequency.max() < 0.5
    step = found.frequency[1]
    for density in (found.radar, found.wire_once_a_turn):
        assert abs(found.frequency[np.argmax(density)] - seen) <= step
    assert abs(found.wire_frequency[np.argmax(found.wire)] - frequency) <= step
    (entry,) = judge(series)
    assert_allclose(entry["nyquist_hz"], 0.5)
    assert_allclose(entry["beyond_nyquist_share"], share, atol=1e-3)  # Hann's sidelobes, 31 dB down and falling
    assert "above 0.5 Hz, half the turn rate" in entry["aliasing"]
    assert "; 100 % of the wire's variance" in entry["aliasing"] or share == 0.0


def test_a_slow_wire_shows_no_spectrum() -> None:
    """A wire read less often than four times a turn folds itself, and could not tell what folds down."""
    series = record(lambda t: np.sin(2.0 * np.pi * 0.8 * t))
    slow = series.isel(gauge=0).sel(sample=series["time"] % 0.5 < 1e-6)  # twice a turn
    found = spectra(slow)
    assert isinstance(found, NoSpectrum)
    assert "less than 4 times a turn" in found.reason


def test_the_bar_of_a_spectrum_holds() -> None:
    """Estimates of white noise scatter as χ² of the stated degrees of freedom: variance over mean² = 2/ν."""
    random = np.random.default_rng(11)
    estimates, freedom = [], 0.0
    for _ in range(60):
        noise = random.normal(size=128)
        found = spectra(record(lambda t, n=noise: np.interp(t, 0.25 + np.arange(128), n), 128).isel(gauge=0))
        assert isinstance(found, GaugeSpectra)
        estimates.append(found.radar[2:-1])  # away from the ends, whose bins the record's mean touches
        freedom = found.freedom
    spread = np.var(estimates) / np.mean(estimates) ** 2
    # 60 records of some 12 frequencies, neighbours tied by the window: the ratio is known to about 10 %.
    assert_allclose(spread, 2.0 / freedom, rtol=0.25)


def test_short_records_are_told_apart_from_wrong_ones() -> None:
    (entry,) = judge(record(np.sin, turns=5))
    for name in ("correlation", "rms_error_m", "bias_m", "regression_slope", "hs_wire_m", "hs_true_m"):
        assert np.isnan(entry[name]), name
    assert "5 heights in 5 turns, and 8 are needed" in entry["reason"]
    assert "5 turns are too short a record" in entry["spectrum_reason"]
    assert entry["spectrum"] is None
    (longer,) = judge(record(np.sin, turns=20))
    assert longer["reason"] == ""
    assert_allclose(longer["correlation"], 1.0)
    assert "20 turns are too short" in longer["spectrum_reason"]


@pytest.mark.parametrize(("missing", "told"), [(12, False), (13, True)])
def test_few_holes_are_bridged_and_many_are_said(missing: int, told: bool) -> None:
    series = record(lambda t: np.sin(2.0 * np.pi * 0.1 * t))
    series["height"].values[0, 3 : 3 + 9 * missing : 9] = np.nan
    found = spectra(series.isel(gauge=0))
    assert isinstance(found, GaugeSpectra)
    assert np.isnan(found.radar).all() == told
    assert ("13 of 120 turns have no height" in found.reason) == told
    entry = judge_one(series.isel(gauge=0))
    assert np.isfinite(entry["beyond_nyquist_share"])  # of the wire, which has no holes
    assert np.isfinite(entry["correlation"])


def test_uneven_passes_give_no_spectrum() -> None:
    series = record(np.sin)
    series["seen_time"].values[0, 60:] += 0.3
    found = spectra(series.isel(gauge=0))
    assert isinstance(found, NoSpectrum)
    assert "even times" in found.reason


# --------------------------------------------------------------------------------------------------------- the file


def test_turn_by_turn_is_all_at_once(tmp_path: Path) -> None:
    sea = a_sea(spectrum="sinusoid", height_m=1.0, wavelength_m=40.0)
    maps, wires = made_maps(plane, turns=5, period=1.3), [gauge("a b"), gauge("c")]
    whole = gauge_series(maps, sea, wires, maps, turn_s=1.3)
    with GaugeFile(tmp_path / "gauges.nc") as file:
        for turn in range(5):
            one = xr.DataTree.from_dict(
                {f"/{group}": maps[group].to_dataset().isel(turn=[turn]) for group in ("polar", "ground")}
            )
            file.append(gauge_series(one, sea, wires, one, turn_s=1.3))
            assert not (tmp_path / "gauges.nc").exists()
    with xr.open_dataset(tmp_path / "gauges.nc") as read:
        check("gauges", read)
        assert set(read.variables) == set(whole.variables)
        assert dict(read.sizes) == dict(whole.sizes)
        for name, variable in whole.variables.items():
            assert_array_equal(read[name].values, variable.values, err_msg=str(name))
            assert read[name].attrs.keys() == variable.attrs.keys()
    assert [path.name for path in tmp_path.iterdir()] == ["gauges.nc"]


def test_a_file_without_turns_does_not_appear(tmp_path: Path) -> None:
    with GaugeFile(tmp_path / "gauges.nc"):
        pass
    assert not list(tmp_path.iterdir())


# ---------------------------------------------------------------------------------------------------------- the run

SMALL: dict[str, Any] = {
    "radar.sector_deg": [264.0, 276.0],
    "radar.range_m": [15.0, 65.0],
    "radar.height_m": 8.0,
    "radar.prf_hz": 4000.0,
    "sea.extent_m": 256.0,
    "tracing.tracer": "horizon",
}


def with_gauges(folder: Path, turns: int, *tables: str) -> Path:
    """`tiny` made smaller, with gauges, as a scene file."""
    scene = load_scene("tiny", SMALL | {"turns": turns})
    file = folder / "scene.toml"
    text = "\n".join(line for line in scene.to_toml().splitlines() if line != "gauges = []")
    file.write_text("\n".join((text, *(f"[[gauges]]\n{table}" for table in tables))), encoding="utf-8")
    return file


@pytest.fixture(scope="module")
def long_run(tmp_path_factory: pytest.TempPathFactory) -> RunResult:
    """Thirty-six turns with two gauges."""
    folder = tmp_path_factory.mktemp("long")
    tables = (
        'name = "wire"\neast_m = -50.0\nnorth_m = 1.0',
        'name = "near"\nground_range_m = 30.0\nazimuth_deg = 268.0',
    )
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(style, "DPI", 40)  # nothing here looks at pixels
        return run(load_scene(with_gauges(folder, 36, *tables)), folder / "out")


def test_the_radar_follows_the_wires_of_a_long_run(long_run: RunResult) -> None:
    metrics = json.loads((long_run.folder / "metrics.json").read_text(encoding="utf-8"))
    assert [entry["name"] for entry in metrics["gauges"]] == ["wire", "near"]
    for entry in metrics["gauges"]:
        # Cells of 3 m lose 4–5 cm of this sea, the retrieval errs by 6–8 cm, and the sea has 35 cm rms: r = 0.96
        # expected of it, and 36 turns of seven waves tell r to ±0.02.
        assert entry["correlation"] > 0.9
        assert entry["rms_error_m"] < 0.15
        assert entry["answered"] > 0.9
        assert entry["averaging_rms_m"] < entry["rms_error_m"]
        assert entry["spectrum"]["frequency_hz"][-1] < entry["nyquist_hz"] == pytest.approx(0.5)
        assert "half the turn rate" in entry["aliasing"]


def test_gauges_nc_holds_what_maps_and_truth_hold(long_run: RunResult) -> None:
    with (
        xr.open_dataset(long_run.folder / "gauges.nc") as gauges,
        xr.open_datatree(long_run.folder / "maps.nc") as maps,
        xr.open_datatree(long_run.folder / "truth.nc") as truth,
    ):
        check("gauges", gauges)
        assert gauges.sizes == {"gauge": 2, "turn": 36, "sample": 144}
        first = [
            xr.DataTree.from_dict({f"/{group}": tree[group].to_dataset().isel(turn=slice(0, 8)) for group in tree})
            for tree in (maps, truth)
        ]
        again = gauge_series(first[0], None, load_scene(long_run.folder / "scene.toml").gauges, first[1])
        for name in ("height", "height_std", "seen_time", "quality", "seen_cell_height"):
            assert_array_equal(again[name].values, gauges[name].values[:, :8])
        # The wire passes through the surface at the radar's times: a wave of 1 s between samples of ¼ s is missed by
        # (ωΔt)²/8 of its amplitude, a third; this sea has 2 cm rms of waves so short.
        for number in range(2):
            between = np.interp(gauges["seen_time"][number], gauges["time"], gauges["true_height"][number])
            assert np.sqrt(np.mean((between - gauges["seen_true_height"].values[number]) ** 2)) < 0.03


def test_the_report_shows_the_gauges(long_run: RunResult) -> None:
    page = (long_run.folder / "report.html").read_text(encoding="utf-8")
    for name in ("gauge_0", "gauge_1", "evolution"):
        assert f'<figure id="{name}">' in page
    assert "Wave gauge: near" in page
    assert "<h3>Wave gauges</h3>" in page
    assert (long_run.folder / "gauge_1.png").exists()


def test_an_interrupted_run_leaves_whole_turns(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    from seamap_rt.simulation import Simulator

    simulate = Simulator.turn

    def stop(self: Simulator, number: int) -> Any:
        if number == 2:
            raise KeyboardInterrupt
        return simulate(self, number)

    monkeypatch.setattr(Simulator, "turn", stop)
    file = with_gauges(tmp_path, 9, 'name = "wire"\neast_m = -50.0\nnorth_m = 1.0')
    with pytest.raises(KeyboardInterrupt, match="2 of 9 turns are complete"):
        run(load_scene(file), tmp_path / "cut")
    with xr.open_dataset(tmp_path / "cut" / "gauges.nc") as gauges:
        assert gauges.sizes == {"gauge": 1, "turn": 2, "sample": 8}
        assert np.isfinite(gauges["height"].values).all()
    assert not list((tmp_path / "cut").glob(".*"))


# --------------------------------------------------------------------------------------------------------- refusals


@pytest.mark.parametrize(
    ("tables", "parts"),
    [
        (['name = "a"'], ["gauges.0: ", "east_m and north_m", "ground_range_m and azimuth_deg", "nothing"]),
        (['name = "a"\neast_m = 1.0'], ["gauges.0: ", "a mixture"]),
        (
            ['name = "a"\neast_m = -50.0\nnorth_m = 0.0\nazimuth_deg = 270.0\nground_range_m = 50.0'],
            ["gauges.0: ", "a mixture"],
        ),
        (["east_m = -50.0\nnorth_m = 0.0"], ["gauges.0.name: is missing"]),
        (['name = "$x"\neast_m = -50.0\nnorth_m = 0.0'], ['gauges.0.name = "$x"', "letters"]),
        (['name = "a"\neast_m = -50.0\nnorth_m = nan'], ["gauges.0.north_m = nan", "not a number"]),
        (
            ['name = "a"\neast_m = -50.0\nnorth_m = 0.0', 'name = "a"\neast_m = -40.0\nnorth_m = 0.0'],
            ["gauges.1.name = 'a'", "name of gauges.0", "its own"],
        ),
        (
            ['name = "a"\neast_m = -50.0\nnorth_m = 0.0', 'name = "b"\neast_m = -4.0\nnorth_m = 0.0\nsample_hz = 8.0'],
            ["gauges.1.sample_hz = 8: must be 4", "one rate"],
        ),
        (
            ['name = "a"\neast_m = -80.0\nnorth_m = 0.0'],
            ["gauges.0: 'a' stands 80 m from the antenna, and must stand 12.69 to 64.5 m", "radar.range_m"],
        ),
        (['name = "a"\neast_m = -12.0\nnorth_m = 0.0'], ["'a' stands 12 m", "12.69"]),
        (
            ['name = "a"\neast_m = 50.0\nnorth_m = 0.0'],
            ["gauges.0: 'a' stands at azimuth 90°, outside of radar.sector_deg (264° to 276°)", "move it"],
        ),
        (['name = "a"\neast_m = -50.0\nnorth_m = 0.0\nsample_hz = 0.0'], ["gauges.0.sample_hz = 0", "at least 0.1"]),
        (['name = "a"\neast_m = -50.0\nnorth_m = 0.0\nheight_m = 0.0'], ["gauges.0.height_m", "unknown key"]),
    ],
)
def test_a_gauge_that_cannot_be_is_refused_in_one_line(tmp_path: Path, tables: list[str], parts: list[str]) -> None:
    file = with_gauges(tmp_path, 1, *tables)
    with pytest.raises(InputError) as caught:
        load_scene(file)
    line = str(caught.value)
    assert "\n" not in line
    for part in parts:
        assert part in line, line


@pytest.mark.parametrize(("away", "azimuth"), [(12.69, 264.0), (64.5, -84.0)])
def test_limits_that_a_refusal_names_pass(tmp_path: Path, away: float, azimuth: float) -> None:
    load_scene(with_gauges(tmp_path, 1, f'name = "a"\nground_range_m = {away}\nazimuth_deg = {azimuth}'))


def test_a_boat_under_way_may_come_to_its_gauges(tmp_path: Path) -> None:
    file = with_gauges(tmp_path, 1, 'name = "a"\neast_m = 50.0\nnorth_m = 0.0')
    assert load_scene(file, {"platform.speed_m_s": 3.0}).gauges[0].place == (50.0, 0.0)


def test_a_staring_radar_has_one_look(tmp_path: Path) -> None:
    table = 'name = "a"\nground_range_m = 50.0\nazimuth_deg = '
    load_scene(with_gauges(tmp_path, 1, f"{table}270.5"), {"radar.scan": "staring"})
    with pytest.raises(InputError, match=r"the one look of radar\.sector_deg"):
        load_scene(with_gauges(tmp_path, 1, f"{table}272.0"), {"radar.scan": "staring"})
