"""A recorded sea is the sea that was recorded: at any place and time, whatever the file's layout, or one line says why
not."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path

import numpy as np
import pytest
import xarray as xr
from recorded_files import BEFORE, FRAMES, SIDE_M, STEP_S, dataset_of, drawn, drawn_settings, write

from seamap_rt.conventions import GRAVITY
from seamap_rt.errors import InputError
from seamap_rt.io.recorded_sea import recorded_sea
from seamap_rt.io.sea_grid import fill_gaps, half_width
from seamap_rt.scene import Scene
from seamap_rt.scene.model import scene_of
from seamap_rt.sea import Sea, realize, wave_facts
from seamap_rt.sea.recorded import duration_s, first_frame, gap_error, lagrange_error, recorded_spectrum
from seamap_rt.sea.wave_trains import PlaneTrain
from seamap_rt.settings import FileWaves, SeaSettings
from seamap_rt.simulation import Simulator

_SECONDS = STEP_S * (FRAMES - 1 - BEFORE - 5)


@pytest.fixture(scope="module")
def sea() -> Sea:
    return drawn()


@pytest.fixture(scope="module")
def data(sea: Sea) -> xr.Dataset:
    return dataset_of(sea)


def scene_like(file: str, **sea: object) -> Scene:
    radar = {"range_m": [15.0, 30.0], "height_m": 4.0}
    return scene_of({"name": "recorded", "sea": {"model": "recorded", "file": file, **sea}, "radar": radar})


def read(data: xr.Dataset, path: Path) -> Sea:
    return realize(scene_like(write(data, path)).sea, 1)


def somewhere(reach: float = 60.0) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    random = np.random.default_rng(1)
    return (*random.uniform(-reach, reach, (2, 500)), random.uniform(0.0, _SECONDS, 500))


def rms(values: np.ndarray) -> float:
    return float(np.sqrt(np.mean(np.square(values))))


# ---------------------------------------------------------------------------------------------------- the surface


def test_a_recorded_sea_is_the_one_that_was_drawn(sea: Sea, data: xr.Dataset, tmp_path: Path) -> None:
    """At 0.1 s of 4 s waves the polynomial through six frames errs by 1e-6 of the height: what is left is the drawn
    sea's own spline, of which the frames are made."""
    again, places = read(data, tmp_path / "sea.nc"), somewhere()
    stated = sea.resolved
    assert rms(again.elevation(*places) - sea.elevation(*places)) < stated.elevation_error
    assert rms(again.slopes(*places) - sea.slopes(*places)) < stated.slope_error
    assert rms(again.elevation_rate(*places) - sea.elevation_rate(*places)) < stated.velocity_error
    assert rms(again.velocity(*places) - sea.velocity(*places)) < 2.0 * stated.velocity_error
    for rate in (0.0, 0.5):
        made, was = (each.elevation_velocity_and_relaxed_shift(*places, rate)[2] for each in (again, sea))
        assert rms(made - was) < 2e-3 * rms(was)


def test_in_water_of_a_depth_the_flow_is_that_depths(tmp_path: Path) -> None:
    shallow = drawn(3.0)
    data = dataset_of(shallow).assign_attrs(periodic=1, depth_m=3.0)
    again, places = read(data, tmp_path / "sea.nc"), somewhere()
    assert rms(again.velocity(*places) - shallow.velocity(*places)) < 5e-3 * rms(shallow.velocity(*places))


def test_between_few_frames_it_errs_by_what_is_stated(sea: Sea, data: xr.Dataset, tmp_path: Path) -> None:
    rare = data.isel(time=slice(None, None, 4))
    again = read(rare, tmp_path / "sea.nc")
    start = STEP_S * (4 * first_frame(recorded_sea(str(tmp_path / "sea.nc"))) - BEFORE)
    x, y, _ = somewhere()
    t = np.random.default_rng(2).uniform(0.0, again.ends_s, x.size)
    apart = rms(again.elevation(x, y, t) - sea.elevation(x, y, t + start))
    assert apart == pytest.approx(again.resolved.elevation_error, rel=0.35)  # 500 places, one realisation of some waves
    assert apart > 3e-4


def test_lagranges_error_is_that_of_a_wave_between_six_frames() -> None:
    """The remainder of the polynomial through nodes −2 … 3: |Π(f − j)| (ωτ)⁶/6!, as long as ωτ is small."""
    cycles = np.array([0.01, 0.02])
    place = (np.arange(16) + 0.5) / 16
    product = np.prod([place - node for node in range(-2, 4)], axis=0)
    remainder = rms(product) * (2.0 * np.pi * cycles) ** 6 / 720.0
    np.testing.assert_allclose(lagrange_error(cycles), remainder, rtol=0.05)


def test_before_and_beyond_the_record_nothing_is_known(data: xr.Dataset, tmp_path: Path) -> None:
    path = write(data, tmp_path / "sea.nc")
    again = realize(scene_like(path).sea, 1)
    file = recorded_sea(path)
    assert first_frame(file) == BEFORE
    assert again.ends_s == pytest.approx(duration_s(file))
    times = np.array([-STEP_S * BEFORE, 0.0, again.ends_s - 1e-6, again.ends_s + STEP_S])
    known = np.isfinite(again.elevation(0.0, 0.0, times))
    assert known.tolist() == [False, True, True, False]


def test_the_surface_potential_is_used_where_it_is_there(data: xr.Dataset, tmp_path: Path) -> None:
    """A potential Φ = −3 x, of one row: the water flows by its gradient, whatever the elevation says; periodic, so by a
    wave of the patch's side."""
    k = 2.0 * np.pi / SIDE_M
    potential = np.broadcast_to(np.sin(k * data["x"].values), data["elevation"].shape).astype(np.float32)
    given = data.assign(surface_potential=(("time", "y", "x"), potential, {"units": "m2 s-1"}))
    again, (x, y, t) = read(given, tmp_path / "sea.nc"), somewhere()
    velocity = again.velocity(x, y, t)
    np.testing.assert_allclose(velocity[:, 0], k * np.cos(k * x), atol=1e-5)
    np.testing.assert_allclose(velocity[:, 1], 0.0, atol=1e-5)


# ---------------------------------------------------------------------------------------------------- the file


def _reversed(data: xr.Dataset) -> xr.Dataset:
    return data.isel(y=slice(None, None, -1))


def _axes_swapped(data: xr.Dataset) -> xr.Dataset:
    return data.transpose("x", "time", "y").rename(x="easting", y="northing", elevation="eta")


def _dated(data: xr.Dataset) -> xr.Dataset:
    seconds = (data["time"].values * 1e9).round().astype("timedelta64[ns]")
    return data.assign_coords(time=np.datetime64("2024-05-01T12:00", "ns") + seconds)


def _in_centimetres(data: xr.Dataset) -> xr.Dataset:
    scaled = data.assign(elevation=100.0 * data["elevation"])
    scaled["elevation"].attrs["units"] = "cm"
    return scaled


def _by_standard_name(data: xr.Dataset) -> xr.Dataset:
    named = data.rename(elevation="w2")
    named["w2"].attrs["standard_name"] = "sea_surface_height_above_mean_sea_level"
    return named


@pytest.mark.parametrize("laid", [(_reversed, _dated, _axes_swapped), (_in_centimetres, _by_standard_name)])
def test_the_layout_of_the_file_changes_nothing(
    laid: tuple[Callable[[xr.Dataset], xr.Dataset], ...], sea: Sea, data: xr.Dataset, tmp_path: Path
) -> None:
    """What a file says in another way is independent of what else it does: several at once are read at once."""
    for change in laid:
        data = change(data.copy(deep=True))
    again, places = read(data, tmp_path / "sea.nc"), somewhere()
    assert rms(again.elevation(*places) - sea.elevation(*places)) < sea.resolved.elevation_error


def test_a_zarr_store_is_read_too(sea: Sea, data: xr.Dataset, tmp_path: Path) -> None:
    data.to_zarr(tmp_path / "sea.zarr", consolidated=False, zarr_format=3)
    again, places = realize(scene_like(str(tmp_path / "sea.zarr")).sea, 1), somewhere()
    assert rms(again.elevation(*places) - sea.elevation(*places)) < sea.resolved.elevation_error


def _hos_ocean(data: xr.Dataset, path: Path, zones: int) -> str:
    """As its output routine writes it: x fastest, places in the first zone alone, times to a hundredth."""
    eta, (columns, rows) = data["elevation"].values, (data["x"].size, data["y"].size)
    east, north = np.meshgrid(data["x"].values + 64.0, data["y"].values + 64.0)
    with path.open("w") as file:
        file.write('#Restart previous computation :: 0\nTITLE=" 3D free surface elevation "\n')
        file.write('VARIABLES="x","y","eta","phis"\n')
        for zone in range(zones):
            shared = "" if zone == 0 else ", D=(1,2)"
            file.write(f"ZONE SOLUTIONTIME = {STEP_S * zone:9.2f}{shared}, I={columns:5d}, J={rows:5d}\n")
            row = [eta[zone].ravel(), np.zeros(eta[zone].size)]
            np.savetxt(
                file, np.stack(([east.ravel(), north.ravel(), *row] if zone == 0 else row), axis=1), fmt="%12.5E"
            )
    return str(path)


def test_hos_oceans_own_file_is_read(sea: Sea, data: xr.Dataset, tmp_path: Path) -> None:
    """Places from 0: the antenna stands at its corner, and the patch repeats. Six digits of the height are written."""
    path = _hos_ocean(data, tmp_path / "3d.dat", 24)
    file = recorded_sea(path)
    assert (file.frames, file.points, file.periodic, file.step_s) == (24, 128, True, pytest.approx(STEP_S))
    again = realize(scene_like(path).sea, 1)
    x, y, _ = somewhere(30.0)
    t = np.random.default_rng(3).uniform(0.0, again.ends_s - 0.01, x.size)
    assert rms(again.elevation(x, y, t) - sea.elevation(x - 64.0, y - 64.0, t)) < 2.0 * sea.resolved.elevation_error
    np.testing.assert_allclose(again.velocity(x, y, t)[:, :2], 0.0, atol=1e-9)  # its potential was written as 0


def test_hos_oceans_file_that_is_cut_off_ends_with_its_last_whole_zone(data: xr.Dataset, tmp_path: Path) -> None:
    path = tmp_path / "3d.dat"
    _hos_ocean(data, path, 16)
    path.write_bytes(path.read_bytes()[:-1000])
    assert recorded_sea(str(path)).frames == 15


def test_a_stereo_cameras_grid_is_read(sea: Sea, data: xr.Dataset, tmp_path: Path) -> None:
    """As WASS has it: places of all points and heights in mm, frames by number, times beside them."""
    east, north = np.meshgrid(1000.0 * data["x"].values, 1000.0 * data["y"].values)
    grid = xr.Dataset(
        {
            "X_grid": (("X", "Y"), east, {"units": "millimeter"}),
            "Y_grid": (("X", "Y"), north, {"units": "millimeter"}),
            "Z": (("count", "X", "Y"), 1000.0 * data["elevation"].values, {"units": "millimeter"}),
            "time": ("count", data["time"].values),
        }
    )
    path = write(grid, tmp_path / "wass.nc")
    file = recorded_sea(path)
    assert (file.periodic, file.reach_m) == (False, pytest.approx(63.5 - 7.0))
    waves = FileWaves(spectrum="file", kind="recorded", file=path)
    again = realize(SeaSettings(model="recorded", file=path, extent_m=115.0, resolution_m=1.0, waves=(waves,)), 1)
    places = somewhere(55.0)
    assert rms(again.elevation(*places) - sea.elevation(*places)) < 0.02 * sea.resolved.elevation_std


def test_the_antenna_stands_in_the_middle_of_a_patch_that_does_not_hold_it(sea: Sea, tmp_path: Path) -> None:
    again, (x, y, t) = read(dataset_of(sea, west_m=1000.0), tmp_path / "sea.nc"), somewhere()
    middle = 1000.0 + 0.5 * (SIDE_M - 1.0)
    assert rms(again.elevation(x, y, t) - sea.elevation(x + middle, y + middle, t)) < sea.resolved.elevation_error


def test_a_patch_that_does_not_repeat_is_known_within_its_rim(sea: Sea, tmp_path: Path) -> None:
    cut = dataset_of(sea, west_m=-50.0, side_m=100.0).assign_attrs(periodic=0)
    path = write(cut, tmp_path / "sea.nc")
    file = recorded_sea(path)
    assert file.reach_m == pytest.approx(43.5)
    waves = FileWaves(spectrum="file", kind="recorded", file=path)
    settings = SeaSettings(model="recorded", file=path, extent_m=90.0, resolution_m=1.0, waves=(waves,))
    again, (x, y, t) = realize(settings, 1), somewhere(44.0)
    # A rim that is not band-limited rings by 1e-3 of the height.
    assert rms(again.elevation(x, y, t) - sea.elevation(x, y, t)) < 0.02 * sea.resolved.elevation_std
    with pytest.raises(InputError, match=r"sea\.file reaches 43.5 m from the antenna: must reach 90"):
        scene_of(
            {
                "name": "far",
                "sea": {"model": "recorded", "file": path},
                "radar": {"range_m": [15.0, 60.0], "height_m": 4.0},
            }
        )


def test_its_spectrum_is_that_of_the_waves_that_were_drawn(sea: Sea, data: xr.Dataset, tmp_path: Path) -> None:
    path = write(data, tmp_path / "sea.nc")
    scene = scene_like(path)
    (facts,) = (wave_facts(each, scene.sea.depth_m) for each in scene.sea.waves)
    assert facts is not None
    variance = float(np.mean(np.square(data["elevation"].values[BEFORE:], dtype=np.float64)))
    assert facts.height == pytest.approx(4.0 * np.sqrt(variance), rel=0.03)  # twelve frames of sixty, a tail beyond
    assert facts.peak_period == pytest.approx(drawn_settings().waves[0].peak_period_s, rel=0.15)  # type: ignore[union-attr]
    assert abs((facts.from_deg - 300.0 + 180.0) % 360.0 - 180.0) < 12.0  # of some thirty waves, spread by 30°
    table = recorded_spectrum(path, np.inf)
    assert table.hs == pytest.approx(facts.height, rel=0.02)


@pytest.mark.parametrize(  # a long one, and up to the shortest that metres tell, in the last ring that holds any
    ("waves", "side"), [(2, 32), (9, 32), (14, 32), (15, 32), (21, 44)]
)
def test_the_spectrum_of_a_single_wave_has_its_frequency_and_its_variance(
    waves: int, side: int, tmp_path: Path
) -> None:
    """The peak to half of a ring, 8 % of the wavenumber or a step of it: 2 % of the frequency."""
    number, axis, times = 2.0 * np.pi * waves / side, np.arange(float(side)), STEP_S * np.arange(40)
    omega = np.sqrt(GRAVITY * number)
    heights = 0.2 * np.cos(number * axis - omega * times[:, None, None]) * np.ones((1, side, 1))
    metres = {name: (name, axis, {"units": "m"}) for name in ("y", "x")}
    data = xr.Dataset({"elevation": (("time", "y", "x"), heights, {"units": "m"})}, metres, {"periodic": 1})
    data = data.assign_coords(time=("time", times, {"units": "s"}))
    table = recorded_spectrum(write(data, tmp_path / "wave.nc"), np.inf)
    assert table.peak_frequency_hz == pytest.approx(omega / (2.0 * np.pi), rel=0.02)
    assert (0.25 * table.hs) ** 2 == pytest.approx(0.5 * 0.2**2, rel=1e-6)


def test_a_scene_keeps_what_it_says_of_a_recorded_sea(data: xr.Dataset, tmp_path: Path) -> None:
    path = write(data, tmp_path / "sea.nc")
    scene = scene_like(path)
    assert (scene.sea.extent_m, scene.sea.resolution_m) == (SIDE_M, 1.0)
    assert scene_like(path, resolution_m=2.5).sea.resolution_m == 2.5
    written = tmp_path / "scene.toml"
    written.write_text(scene.to_toml())
    from seamap_rt.scene import load_scene

    assert load_scene(written) == scene


# ---------------------------------------------------------------------------------------------------- gaps


def test_what_is_filled_in_errs_as_stated(data: xr.Dataset, tmp_path: Path) -> None:
    """At the middle of strips by what is stated, less what runs along them; of round gaps by less."""
    train = read(data, tmp_path / "sea.nc").trains[0]
    assert isinstance(train, PlaneTrain)
    north, east = np.mgrid[:128, :128] % 32 - 16.0
    for radius in (2, 3, 4):
        strip, disc = (np.abs(east) < radius) & (np.abs(north) < 12), np.hypot(east, north) < radius
        stated = gap_error(train.lattice, train.variance, half_width(strip))
        middles = (slice(16, None, 32), slice(16, None, 32))
        errors: dict[str, list[np.ndarray]] = {"strip": [], "disc": []}
        for frame in data["elevation"].values[5::12].astype(float):
            for name, gap in (("strip", strip), ("disc", disc)):
                errors[name].append((fill_gaps(np.where(gap, np.nan, frame), gap) - frame)[middles])
        of_strip, of_disc = (rms(np.array(each)) for each in errors.values())
        assert 0.7 * stated < of_strip < 1.2 * stated  # eighty middles
        assert of_disc < of_strip


def test_a_sea_says_how_wide_its_gaps_are_and_what_that_costs(sea: Sea, data: xr.Dataset, tmp_path: Path) -> None:
    """Single points of each frame are missing: 1.5 m to known water and half on, of waves from 6 m on."""
    values = data["elevation"].values.copy()
    holes = np.zeros(values.shape, dtype=bool)
    holes[:, 5::13, 7::11] = True
    again = read(data.assign(elevation=(("time", "y", "x"), np.where(holes, np.nan, values))), tmp_path / "holes.nc")
    assert again.resolved.filled_m == pytest.approx(3.0)
    t = np.array([STEP_S * 20])
    x, y = np.meshgrid(data["x"].values[7::11], data["y"].values[5::13])
    error = rms(again.elevation(x, y, t) - sea.elevation(x, y, t))
    assert 0.2 * again.resolved.filled_error < error < again.resolved.filled_error
    assert again.resolved.filled_error < 0.1 * sea.resolved.elevation_std


# ---------------------------------------------------------------------------------------------------- refusals


def test_a_patch_that_repeats_and_is_not_square_is_refused_in_a_line(data: xr.Dataset, tmp_path: Path) -> None:
    """What else is wrong with a file: `test_a_hostile_file_is_refused_in_a_line`."""
    with pytest.raises(InputError, match="100 × 128 points: a patch that repeats must be square") as refused:
        read(data.isel(x=slice(100)), tmp_path / "sea.nc")
    assert "\n" not in str(refused.value)


@pytest.mark.parametrize("content", [b"", b"not a sea", b"\x89HDF\r\n\x1a\n" + bytes(64), b"CDF\x01" + bytes(9)])
def test_what_is_no_file_of_a_sea_is_refused_in_a_line(content: bytes, tmp_path: Path) -> None:
    (tmp_path / "sea.nc").write_bytes(content)
    with pytest.raises(InputError, match=r"sea\.file = .*cannot be read as NetCDF or Zarr") as refused:
        scene_like(str(tmp_path / "sea.nc"))
    assert "\n" not in str(refused.value)


def test_a_run_that_outlasts_the_record_is_refused(data: xr.Dataset, tmp_path: Path) -> None:
    path = write(data, tmp_path / "sea.nc")
    scene = scene_like(path).model_copy(update={"turns": 9})
    held = r"the record of sea\.file goes on for 4\.4 s; lower turns to 4"
    with pytest.raises(InputError, match=r"turns = 9: last 9 s, and 0\.1 s more are heard; " + held):
        Simulator(scene)


def test_a_scene_without_waves_takes_the_records_and_one_with_others_alone_is_refused(
    data: xr.Dataset, tmp_path: Path
) -> None:
    path = write(data, tmp_path / "sea.nc")
    assert scene_like(path, waves=[]) == scene_like(path)
    with pytest.raises(InputError, match="must hold the spectrum of the recorded sea"):
        scene_like(path, waves=[{"spectrum": "flat"}])


def test_a_boat_does_not_follow_waves_of_a_record(data: xr.Dataset, tmp_path: Path) -> None:
    path = write(data, tmp_path / "sea.nc")
    with pytest.raises(InputError, match=r"must be fixed, sinusoidal or file where sea\.model = 'recorded'"):
        scene_of(
            {
                "name": "boat",
                "sea": {"model": "recorded", "file": path},
                "radar": {"range_m": [15.0, 30.0], "height_m": 4.0},
                "platform": {"motion": "wave_following"},
            }
        )
