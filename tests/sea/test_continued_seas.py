"""A recorded patch that ends within the radar's circle: inside it the sea is that of the file, beyond it level or
mirrored, and nothing there is judged."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np
import pytest
import xarray as xr
from known_waves import STEP_S, WAVE, WEST_M, KnownWave, dataset_of, frames_of, rms, write

from seamap_rt.errors import InputError
from seamap_rt.forecast_errors import true_elevation
from seamap_rt.gauges import gauge_series
from seamap_rt.interferometry import retrieve
from seamap_rt.io.recorded_sea import RecordedSea, recorded_sea
from seamap_rt.measured import CoverageProfile
from seamap_rt.metrics import error_figures
from seamap_rt.scene import Scene
from seamap_rt.scene.model import scene_of
from seamap_rt.scene.radar_checks import record_notes
from seamap_rt.sea import Sea, realize
from seamap_rt.sea.recorded import first_frame
from seamap_rt.session import simulate
from seamap_rt.settings import GaugeSettings

EDGE_M, REACH_M = 59.5, 52.5  # the cells' eastern edge; less a rim of 6 points, and a point


@pytest.fixture(scope="module")
def path(tmp_path_factory: pytest.TempPathFactory) -> str:
    return write(dataset_of(), tmp_path_factory.mktemp("known") / "wave.nc")


def scene_with(path: str, beyond: str, **sections: Any) -> Scene:
    radar = {"range_m": [15.0, 70.0], "height_m": 4.0, "sector_deg": [60.0, 120.0]}
    tree = {"name": "known", "sea": {"model": "recorded", "file": path, "beyond": beyond}, "radar": radar}
    return scene_of(tree | {"tracing": {"tracer": "horizon"}} | sections)


def sea_of(path: str, beyond: str) -> Sea:
    return realize(scene_with(path, beyond).sea, 1)


def places(sea: Sea, reach: float) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    random = np.random.default_rng(3)
    return (*random.uniform(-reach, reach, (2, 600)), random.uniform(0.0, sea.ends_s - 0.01, 600))


def start(file: RecordedSea) -> float:
    return first_frame(file) * STEP_S


@pytest.mark.parametrize("beyond", ["level", "mirrored"])
def test_a_known_wave_comes_back(beyond: str, path: str) -> None:
    """In all that is judged the elevation within 1e-3 of the amplitude (frames in single precision 3e-8; the rim is no
    polynomial of order 7), slopes within 1 %. The flow of a place depends on the elevation some wavelengths around:
    within a wavelength (26 m) of the edge by 5 %, in the middle by 1 %."""
    sea, file = sea_of(path, beyond), recorded_sea(path)
    for reach, of_flow in ((REACH_M, 0.05), (0.4 * REACH_M, 0.01)):
        x, y, t = places(sea, reach)
        elevation, slopes, velocity = sea.elevation_slopes_and_velocity(x, y, t)
        t = t + start(file)
        assert rms(elevation - WAVE.elevation(x, y, t)) < 1e-3 * WAVE.amplitude
        assert rms(slopes - WAVE.slopes(x, y, t)) < 1e-2 * WAVE.amplitude * WAVE.k
        assert rms(velocity - WAVE.velocity(x, y, t)) < of_flow * WAVE.amplitude * WAVE.omega
    # a²/2, though the rim fades: what fades is counted; 12 frames of a wave that fills the patch unevenly
    assert sea.resolved.elevation_std == pytest.approx(WAVE.amplitude / np.sqrt(2.0), rel=0.01)


@pytest.mark.parametrize(("beyond", "named"), [("level", ("u", "v")), ("mirrored", ("a", "b"))])
def test_velocities_of_the_file_are_used_where_it_has_them(beyond: str, named: tuple[str, str], tmp_path: Path) -> None:
    """Twice those of linear waves, to tell them from what the elevation says; by name, or by CF's."""
    data = dataset_of()
    t, y, x = np.meshgrid(data["time"], data["y"], data["x"], indexing="ij")
    flow = 2.0 * WAVE.velocity(x, y, t)[..., :2].astype(np.float32)
    for axis, name, way in ((0, named[0], "eastward"), (1, named[1], "northward")):
        attributes = {"units": "m s-1", "standard_name": f"{way}_sea_water_velocity"}
        data[name] = (("time", "y", "x"), flow[..., axis], attributes)
    path = write(data, tmp_path / "flow.nc")
    sea = sea_of(path, beyond)
    x, y, t = places(sea, 0.4 * REACH_M)
    made, true = sea.velocity(x, y, t), WAVE.velocity(x, y, t + start(recorded_sea(path)))
    assert rms(made[:, :2] - 2.0 * true[:, :2]) < 0.02 * 2.0 * WAVE.amplitude * WAVE.omega
    assert rms(made[:, 2] - true[:, 2]) < 1e-3 * WAVE.amplitude * WAVE.omega
    if beyond == "mirrored":
        near, far = (sea.velocity(EDGE_M + side * 20.0, y, t) for side in (-1.0, 1.0))
        np.testing.assert_allclose(far * [-1.0, 1.0, 1.0], near, atol=1e-3 * WAVE.amplitude * WAVE.omega)


def test_a_mirrored_sea_goes_on_without_a_step_and_its_slopes_change_sign(path: str) -> None:
    """η(2e − x) = η(x): slopes and flow across the edge change sign, those along it do not; in single precision."""
    sea = sea_of(path, "mirrored")
    _, y, t = places(sea, 55.0)
    for away in (0.01, 0.5, 3.0, 17.0):
        near, far = (sea.elevation_slopes_and_velocity(EDGE_M + side * away, y, t) for side in (-1.0, 1.0))
        np.testing.assert_allclose(far[0], near[0], atol=1e-4 * WAVE.amplitude)
        np.testing.assert_allclose(far[1] * [-1.0, 1.0], near[1], atol=2e-3 * WAVE.amplitude * WAVE.k)
        np.testing.assert_allclose(far[2] * [-1.0, 1.0, 1.0], near[2], atol=1e-3 * WAVE.amplitude * WAVE.omega)


def test_a_level_sea_is_level_and_begins_without_a_step(path: str) -> None:
    sea = sea_of(path, "level")
    _, y, t = places(sea, 200.0)
    for values in sea.elevation_slopes_and_velocity(EDGE_M + 0.5, y, t):
        assert not values.any()
    edge = sea.elevation(EDGE_M - 0.01, y, t)
    assert np.abs(edge).max() < 1e-2 * WAVE.amplitude  # the rim's cosine ends at the last point, and rings half on


def test_it_is_known_within_its_rim_alone(path: str) -> None:
    sea, file = sea_of(path, "mirrored"), recorded_sea(path)
    assert file.reach_m == pytest.approx(REACH_M)
    x = np.array([0.0, REACH_M - 0.01, REACH_M + 0.01, 0.0, -REACH_M - 1.01])
    y = np.array([0.0, 0.0, 0.0, REACH_M + 0.01, 0.0])
    assert sea.is_known(x, y).tolist() == [True, True, False, False, False]
    height = sea.judge.elevation(x, y, np.zeros(5))
    assert np.isfinite(height).tolist() == [True, True, False, False, False]
    assert np.isfinite(sea.elevation(x, y, np.zeros(5))).all()


def test_how_far_it_reaches_is_told_before_anything_runs(path: str) -> None:
    scene = scene_with(path, "level")
    begins, line = record_notes(scene.sea, scene.radar)
    assert begins.endswith("runs from 0 s to 4.9 s; time 0 of the run is its 1 s (sea.start_s)")
    assert line.endswith(
        "reaches 52.5 m from the antenna, radar.range_m to 70 m: beyond the sea is level, and nothing there is judged"
    )
    with pytest.raises(InputError, match=r"reaches 52\.5 m from the antenna: must reach 100 .* 'level' or 'mirrored'"):
        scene_with(path, "refused")


def test_waves_too_long_for_the_patch_are_told(tmp_path: Path) -> None:
    """Of a wave of four sides, seen for one and a half periods (17.5 s), the frames' means hold (2 √2/π)² = 0.81 of the
    variance; the sea is as high as the wave all the same."""
    long = KnownWave(0.5, 2.0 * np.pi / 480.0, 0.0)
    axis, times = WEST_M + np.arange(120.0), 0.5 * np.arange(53)
    data = dataset_of().isel(time=np.arange(53) % 50).assign_coords(time=("time", times, {"units": "s"}))
    data["elevation"] = (("time", "y", "x"), frames_of(long, axis, axis, times), {"units": "m"})
    path = write(data, tmp_path / "long.nc")
    assert recorded_sea(path).long_share == pytest.approx(0.81, abs=0.05)
    scene = scene_with(path, "level")
    assert any("longer than its patch of 120 m" in line for line in record_notes(scene.sea, scene.radar))
    sea = realize(scene.sea, 1)
    assert sea.resolved.elevation_std == pytest.approx(0.5 / np.sqrt(2.0), rel=0.2)
    x, y, t = places(sea, REACH_M)
    at = t + 0.5 * first_frame(recorded_sea(path)) + 0.0
    assert rms(sea.elevation(x, y, t) - (long.elevation(x, y, at) - recorded_sea(path).level_m)) < 2e-3 * 0.5


def test_a_patch_that_repeats_has_no_beyond(tmp_path: Path) -> None:
    path = write(dataset_of().assign_attrs(periodic=1), tmp_path / "round.nc")
    with pytest.raises(
        InputError, match=r"sea\.beyond = 'level': must be 'refused', for the patch of sea\.file repeats"
    ):
        scene_with(path, "level", radar={"range_m": [15.0, 25.0], "height_m": 4.0})
    with pytest.raises(InputError, match=r"beyond = 'level': must be 'refused' where model = 'linear'"):
        scene_of({"name": "drawn", "sea": {"beyond": "level"}})


# ---------------------------------------------------------------------------------------------------- judgement


@pytest.fixture(scope="module", params=["level", "mirrored"])
def run(request: pytest.FixtureRequest, path: str) -> tuple[Scene, xr.DataTree, xr.DataTree]:
    """A scene, its maps and its truth, looking east."""
    scene = scene_with(path, request.param)
    made = simulate(scene)
    return scene, retrieve(made.echoes), made.truth


def test_nothing_beyond_is_judged(run: tuple[Scene, xr.DataTree, xr.DataTree]) -> None:
    """Truth, metrics and rings are of the cells that lie within the record, and of no other."""
    scene, maps, truth = run
    polar = truth["polar"].to_dataset().isel(turn=0)
    azimuth, slant = np.meshgrid(np.radians(polar["azimuth"].values), polar["range"].values, indexing="ij")
    aside = 0.5 * np.radians(scene.retrieval.cell_azimuth_deg)
    near, far = (
        np.sqrt((slant + half * scene.retrieval.cell_range_m) ** 2 - scene.radar.height_m**2) for half in (-0.5, 0.5)
    )
    # East of all is a cell's far side, at the azimuth of it that is nearest to east.
    turned = np.clip(np.pi / 2.0 - azimuth, -aside, aside)
    reached = far * np.sin(azimuth + turned)
    known = np.isfinite(polar["height"].values)
    first = near > 15.5  # nearer, the window begins
    assert known[(reached < REACH_M - 0.01) & first].all()
    assert not known[reached > REACH_M + 0.01].any()
    assert np.isfinite(polar["time"].values).all()
    ground = truth["ground"].to_dataset().isel(turn=0)
    east = np.broadcast_to(ground["x"].values, ground["height"].shape)
    assert not np.isfinite(ground["height"].values)[east > REACH_M - 0.5 * scene.retrieval.ground_m + 0.01].any()
    figures = error_figures(maps, truth)
    assert 0 < sum(figures["cells"]) <= known.sum()
    assert figures["overall"]["hs_true_m"] == pytest.approx(4.0 * np.sqrt(0.5) * WAVE.amplitude, rel=0.2)
    assert CoverageProfile.of(maps["polar"].to_dataset(), truth["polar"].to_dataset(), 0.2).cells.sum() == known.sum()


def test_gauges_take_nothing_beyond(run: tuple[Scene, xr.DataTree, xr.DataTree], path: str) -> None:
    scene, maps, truth = run
    wire = {"name": "wire", "east_m": 56.0, "north_m": 0.0}
    with pytest.raises(
        InputError, match=r"gauges\.0: 'wire' stands where sea\.file is not known.*-53\.5 to 52\.5 m east"
    ):
        scene_with(path, "level", gauges=[wire])
    series = gauge_series(maps, realize(scene.sea, 1), [GaugeSettings(**wire)], truth, turn_s=1.0)
    assert np.isfinite(series["height"]).all()  # the radar has one there
    for name in ("true_height", "seen_true_height", "seen_cell_height"):
        assert not np.isfinite(series[name]).any()


def test_forecasts_take_nothing_beyond(path: str) -> None:
    forecast = xr.Dataset(
        {"issued": ("issue", [0.0]), "east": (("issue", "place"), [[0.0, 56.0]]),
         "north": (("issue", "place"), [[0.0, 0.0]])},
        {"lead": [0.0, 1.0]},
        {"heading_deg": 0.0, "speed_m_s": 0.0},
    )  # fmt: skip
    known = np.isfinite(true_elevation(sea_of(path, "level").judge, forecast))
    assert known.tolist() == [[[True, False], [True, False]]]


def test_the_run_says_what_is_not_known(path: str) -> None:
    from seamap_rt.report.limits import not_modelled

    scene = scene_with(path, "mirrored")
    resolved = realize(scene.sea, 1).resolved
    rows = {row["what"]: row for row in not_modelled(scene, resolved)}
    # the square of 106 m in a circle of 140 m: by places at random
    random = np.random.default_rng(1).uniform(-70.0, 70.0, (2, 200_000))
    inside = random[:, np.hypot(*random) < 70.0]
    share = 100.0 * np.mean(~recorded_sea(path).holds(*inside))
    assert rows["the sea beyond the record"]["value"] == pytest.approx(share, abs=1.0)
    assert "mirrored beyond 52.5 m" in rows["the sea beyond the record"]["why"]
    assert rows["the sea between a record's frames"]["value"] == resolved.elevation_error
