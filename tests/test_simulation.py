"""The forward half as a whole: in memory or on the disk, turn after turn, and when the water covers the antenna."""

from __future__ import annotations

import shutil
from pathlib import Path
from typing import Any

import numpy as np
import pytest
import xarray as xr
import zarr
from numpy.testing import assert_allclose, assert_array_equal

from seamap_rt.conventions import unit_from_azimuth
from seamap_rt.dataset import QUALITY_FLAGS, check
from seamap_rt.errors import InputError
from seamap_rt.interferometry import retrieve
from seamap_rt.radar.installation import Installation
from seamap_rt.radar.scan import pulses
from seamap_rt.report.headline import fold_warning, ground_warning, run_facts
from seamap_rt.scene import Scene, load_scene
from seamap_rt.session import Simulation, run, simulate
from seamap_rt.simulation import Simulator, expected

GRAVITY, TENSION = 9.81, 0.074 / 1025.0


def scene(name: str = "tiny", **keys: Any) -> Scene:
    """A dozen degrees of sea out to 60 m, by the horizon tracer."""
    small: dict[str, Any] = {
        "radar__range_m": [15.0, 60.0],
        "radar__sector_deg": [260.0, 272.0],
        "tracing__tracer": "horizon",
    }
    if name == "tiny":
        small["sea__extent_m"] = 180.0
    return load_scene(name, overrides={key.replace("__", "."): value for key, value in (small | keys).items()})


def wave(x: np.ndarray, y: np.ndarray, t: np.ndarray, made: Scene) -> np.ndarray:
    """The regular wave of a scene in closed form, travelling east in deep water."""
    (regular,) = made.sea.waves
    assert regular.spectrum == "sinusoid"
    k = 2.0 * np.pi / regular.wavelength_m
    omega = np.sqrt(GRAVITY * k + TENSION * k**3)
    return 0.5 * regular.height_m * np.cos(k * x - omega * t + np.radians(regular.phase_deg))


# ------------------------------------------------------------------------------------------ memory and disk


@pytest.fixture(scope="module")
def two_turns() -> Simulation:
    return simulate(scene(turns=2))


def test_memory_and_disk_hold_the_same(two_turns: Simulation, tmp_path: Path) -> None:
    stored = simulate(scene(turns=2), tmp_path / "new" / "folder")
    assert sorted(path.name for path in (tmp_path / "new" / "folder").iterdir()) == ["run.zarr", "truth.nc"]
    assert set(stored.echoes.variables) == set(two_turns.echoes.variables)
    assert set(stored.echoes.coords) == set(two_turns.echoes.coords)
    assert stored.echoes.attrs.items() >= two_turns.echoes.attrs.items()
    for name, variable in two_turns.echoes.variables.items():
        assert stored.echoes[name].dims == variable.dims
        assert stored.echoes[name].values.tobytes() == variable.values.tobytes()
    for group in ("polar", "ground"):
        here, there = two_turns.truth[group].to_dataset(), stored.truth[group].to_dataset().load()
        xr.testing.assert_equal(here, there)
        assert here.attrs == there.attrs
    assert stored.facts == two_turns.facts
    stored.truth.close()


def test_nothing_of_the_sea_is_in_the_echoes(two_turns: Simulation) -> None:
    """The retrieval must not see the truth: neither names nor attributes speak of waves, wind or the scene."""
    said = " ".join([*map(str, two_turns.echoes.attrs), *map(str, two_turns.echoes.variables)]).lower()
    for word in ("wave_", "wind", "scene", "seed", "hs", "truth", "elevation_m", "nrcs"):
        assert word not in said


def test_maps_have_the_same_bits_without_truth_and_scene(tmp_path: Path) -> None:
    """Truth and scene beside the echoes: as they are, the truth full of NaN, and both taken away; in the store too."""
    folder = tmp_path / "run"
    simulate(scene(turns=1), folder).truth.close()
    (folder / "scene.toml").write_text(scene(turns=1).to_toml(), encoding="utf-8")

    def maps() -> dict[str, bytes]:
        tree = retrieve(folder)
        groups = {group: tree[group].to_dataset() for group in ("polar", "ground")}
        return {f"{group}/{name}": data[name].values.tobytes() for group, data in groups.items() for name in data}

    first = maps()
    with xr.open_datatree(folder / "truth.nc") as truth:
        hidden = truth.load().map_over_datasets(lambda data: data * np.nan)
    hidden.to_netcdf(folder / "truth.nc", engine="h5netcdf")
    for name in ("polar", "ground"):
        height = zarr.open_group(folder / "run.zarr", mode="r+")[f"truth/{name}/height"]
        assert isinstance(height, zarr.Array)
        height[...] = np.nan
    assert maps() == first
    shutil.rmtree(folder / "run.zarr" / "truth")
    (folder / "truth.nc").unlink()
    (folder / "scene.toml").unlink()
    assert maps() == first


def test_turns_are_what_a_simulator_makes_of_them_one_by_one(two_turns: Simulation) -> None:
    """Turn 1 alone, without turn 0 before it, has the same bits: nothing is carried over."""
    alone = Simulator(scene(turns=2)).turn(1)
    members = two_turns.echoes["turn"].values == 1
    assert alone.echoes["voltage"].values.tobytes() == two_turns.echoes["voltage"].values[members].tobytes()
    xr.testing.assert_equal(
        alone.truth["polar"].to_dataset(), two_turns.truth["polar"].to_dataset().isel(turn=slice(1, 2))
    )


def test_same_seed_same_bits_another_seed_another_sea(two_turns: Simulation) -> None:
    again, other = simulate(scene(turns=2)), simulate(scene(turns=2, seed=2))
    assert again.echoes["voltage"].values.tobytes() == two_turns.echoes["voltage"].values.tobytes()
    assert again.truth.equals(two_turns.truth)
    height = [one.truth["polar"].to_dataset()["height"].values for one in (two_turns, other)]
    assert np.abs(height[0] - height[1]).max() > 0.3


# ------------------------------------------------------------------------------------------------ expectation


def test_expected_keeps_its_schema() -> None:
    made = scene()
    found = expected(made)
    check("expected", found)
    assert found["power"].dims == ("transmitter", "receiver", "azimuth", "range")
    looks = simulate(made).truth["polar"]
    assert_array_equal(found["azimuth"].values, looks["azimuth"].values)
    assert_array_equal(found["range"].values, looks["range"].values)
    power, covariance = found["power"].values, found["covariance"].values
    assert (power >= 0.0).all()
    assert (power[..., 5:20] > 0.0).all()
    # Cauchy–Schwarz, for the mean over the transmitters; no noise is in either.
    mean = power.mean(axis=0)
    assert np.all(np.abs(covariance) <= np.sqrt(mean[0] * mean[1]) * (1.0 + 1e-6))


def test_expected_of_a_later_turn_is_another() -> None:
    made = scene(turns=2)
    first, second = expected(made), expected(made, turn=1)
    assert np.abs(first["power"] - second["power"]).max() > 0.0
    assert_array_equal(expected(made, turn=1)["covariance"].values, second["covariance"].values)


# ------------------------------------------------------------------------------------------------------- time


def test_time_rolls_on_over_turns() -> None:
    """The third turn of a regular wave, cell by cell, against the wave at that cell's own time in closed form."""
    made = scene("sinusoid", turns=3, radar__sector_deg=[80.0, 100.0], radar__rotation_rpm=48.0)
    run = simulate(made)
    period = 60.0 / 48.0
    cells = run.truth["polar"].to_dataset()
    assert_allclose(np.diff(cells["time"].values, axis=0), period, rtol=0.0, atol=1e-12)
    east, north = unit_from_azimuth(cells["azimuth"].values)
    offsets = 3.0 * ((np.arange(60) + 0.5) / 60 - 0.5)  # metres of slant range within a cell
    errors = {}
    for seen, told in ((2, 2), (2, 0)):
        time = cells["time"].values[told][:, None, None]
        slant = cells["range"].values[:, None] + offsets
        ground, eta = np.sqrt(slant**2 - made.radar.height_m**2), np.zeros((east.size, *slant.shape))
        for _ in range(30):  # where the slant range meets the water: near the mast that is not where it meets z = 0
            eta = wave(east[:, None, None] * ground, north[:, None, None] * ground, time, made)
            ground = np.sqrt(slant**2 - (made.radar.height_m - eta) ** 2)
        fraction = np.gradient(ground, axis=-1) * ground  # equal steps of slant range hold unequal areas
        mean = np.sum(eta * fraction, axis=-1) / np.sum(fraction, axis=-1)
        errors[seen, told] = float(np.abs(cells["height"].values[seen] - mean)[:, 5:].max())
    # 0.1 rad of slope times the 0.1 m by which bins of 0.25 m misplace a cell's ends, and the wave's own way during
    # half a look (±0.04 m): a centimetre. At the time of turn 0 the wave would have been 14 m further back.
    assert errors[2, 2] < 0.01
    assert errors[2, 0] > 0.5

    ground_cells = run.truth["ground"].to_dataset()
    x, y = np.meshgrid(ground_cells["x"].values, ground_cells["y"].values)
    inside = np.isfinite(ground_cells["time"].values[2])
    assert inside.sum() > 50
    k = 2.0 * np.pi / 40.0
    mean = wave(x, y, ground_cells["time"].values[2], made) * np.sinc(k * 3.0 / (2.0 * np.pi))
    # two-point Gauss quadrature: (k s)⁴/4320 of the amplitude; and float32
    assert_allclose(
        ground_cells["height"].values[2][inside], mean[inside], rtol=0.0, atol=0.67 * (3.0 * k) ** 4 / 4320 + 1e-6
    )
    assert ground_cells["time"].values[2][inside].min() >= 2.0 * period

    fired = run.echoes["time"].values[run.echoes["turn"].values == 2]
    assert 2.0 * period <= fired[0] < 2.0 * period + 1e-4
    assert_array_equal(fired, pulses(Installation(made.radar), 2).time)


# ------------------------------------------------------------------------------------------------- submerged


def drowning(**keys: Any) -> Scene:
    """A 3 m wave of 4 s under a 1.2 m mast: in its trough at time 0, over the antenna from 1.5 to 2.5 s."""
    return scene(
        "sinusoid",
        **{
            "sea__waves__0__height_m": 3.0,
            "sea__waves__0__wavelength_m": 25.0,
            "sea__waves__0__phase_deg": 180.0,
            "radar__height_m": 1.2,
            "radar__rotation_rpm": 10.0,
            "radar__prf_hz": 1000.0,
            "radar__sector_deg": [0.0, 180.0],
            "radar__range_m": [10.0, 40.0],
        }
        | keys,
    )


@pytest.mark.parametrize("tracer", ["facets", "horizon"])
def test_submerged_columns_are_silent_and_flagged(tracer: str) -> None:
    made = drowning(tracing__tracer=tracer)
    run = simulate(made)
    echoes = run.echoes
    time = echoes["time"].values
    level = wave(np.zeros_like(time), np.zeros_like(time), time, made)
    lower = made.radar.height_m - 0.5 * made.radar.baseline_m
    under = level >= lower
    assert not under[0]
    assert 0.2 < under.mean() < 0.5
    flagged = echoes["flag"].values == QUALITY_FLAGS["submerged"]
    silent = np.isnan(echoes["voltage"].values)
    assert_array_equal(silent.all(axis=(1, 2)), flagged)
    assert_array_equal(silent.any(axis=(1, 2)), flagged)
    # The sea is asked at the lines, 0.45° apart: a pulse may be taken for its neighbour half a spacing away.
    changes = time[np.flatnonzero(np.diff(under.astype(int)))]
    half_column = 0.5 * 0.45 / 360.0 * 6.0 + 1e-3
    sure = np.abs(time[:, None] - changes).min(axis=1) > half_column
    assert_array_equal(flagged[sure], under[sure])
    assert sure.mean() > 0.98

    maps = retrieve(echoes)
    polar = maps["polar"].to_dataset().isel(turn=0)
    check("maps/polar", maps["polar"].to_dataset())
    look_time = polar["time"].values
    half_look = 0.5 * 1.8 / 360.0 * 6.0
    wholly = np.array([under[np.abs(time - t) <= half_look].all() for t in look_time])
    partly = np.array([flagged[np.abs(time - t) <= half_look + half_column].any() for t in look_time])
    assert wholly.sum() > 20
    said = (polar["quality"].values & QUALITY_FLAGS["submerged"]) != 0
    assert said[wholly].all()
    assert not said[~partly].any()
    # The default estimator's window reaches one look further: beyond it no height may be made up.
    core = wholly & np.roll(wholly, 1) & np.roll(wholly, -1)
    for name in ("height", "height_std", "slope_range"):
        assert np.isnan(polar[name].values[core]).all()
    assert (polar["quality"].values[core] & QUALITY_FLAGS["no_echo"] != 0).all()
    dry = ~partly
    assert np.isfinite(polar["height"].values[dry]).mean() > 0.3
    # Truth has no antenna: it knows the sea there all the same.
    assert np.isfinite(run.truth["polar"].to_dataset()["height"].values[0][wholly]).mean() > 0.9

    ground = maps["ground"].to_dataset().isel(turn=0)
    x, y = np.meshgrid(ground["x"].values, ground["y"].values)
    look = (np.degrees(np.arctan2(x, y)) % 360.0) / 60.0  # s at 10 rpm
    deep = (look > look_time[core].min()) & (look < look_time[core].max())
    assert deep.sum() > 20
    assert np.isnan(ground["height"].values[deep]).all()


def test_single_cell_estimator_keeps_wholly_submerged_looks_empty() -> None:
    made = drowning()
    echoes = simulate(made).echoes
    settings = made.retrieval.model_copy(update={"estimator": "single_cell"})
    polar = retrieve(echoes, settings)["polar"].to_dataset().isel(turn=0)
    said = (polar["quality"].values & QUALITY_FLAGS["submerged"]) != 0
    drowned = echoes["flag"].values != 0
    edges = polar["time"].values[said.all(axis=1)]
    inside = (polar["time"].values > edges.min()) & (polar["time"].values < edges.max())
    assert drowned.any()
    assert inside.sum() > 20
    assert np.isnan(polar["height"].values[inside]).all()


def test_higher_crest_further_off_is_no_reason_to_refuse() -> None:
    """At time 0 the antenna stands in the trough, and 12 m away the water is 0.3 m above it."""
    made = drowning(radar__sector_deg=[80.0, 100.0], radar__rotation_rpm=60.0, radar__prf_hz=10e3)
    run = simulate(made)
    assert np.isfinite(run.echoes["voltage"].values).all()
    polar = run.truth["polar"].to_dataset()
    assert polar["height"].max() > made.radar.height_m
    assert polar["visible_fraction"].values[..., -10:].max() == 0.0


def test_isotropic_antenna_is_refused_for_a_sea() -> None:
    with pytest.raises(InputError, match="isotropic") as refusal:
        Simulator(scene(radar__antenna__pattern="isotropic"))
    assert "\n" not in str(refusal.value)


def test_earlier_results_are_replaced_only_when_told(tmp_path: Path) -> None:
    simulate(scene(), tmp_path)
    with pytest.raises(InputError, match=r"holds another run's run\.zarr"):
        simulate(scene(seed=2), tmp_path)
    again = simulate(scene(seed=2), tmp_path, overwrite=True)
    assert_array_equal(again.echoes["voltage"].values, simulate(scene(seed=2)).echoes["voltage"].values)


def test_a_choppy_sea_that_folds_is_flagged() -> None:
    waves = {
        "spectrum": "jonswap",
        "significant_wave_height_m": 2.8,
        "peak_period_s": 4.0,
        "spreading": "long_crested",
        "wave_from_deg": 265.0,
    }
    steep = {"sea__waves": [waves], "sea__resolution_m": 0.4, "sea__model": "choppy", "tracing__facet_m": 0.1}
    turn = (simulator := Simulator(scene(**steep))).turn(0)
    facts = run_facts(simulator.scene, simulator.sea, simulator.surface)
    assert 0.0 < facts["sea"]["choppy"]["folded_share"] < 0.02
    assert 0.0 < turn.folded_share < 0.02
    warning = fold_warning({**facts, "folded_share": turn.folded_share})
    assert warning is not None
    assert "fold" in warning
    assert np.isfinite(turn.echoes["voltage"].values).all()
    assert Simulator(scene(sea__model="choppy")).turn(0).folded_share == 0.0
    assert fold_warning({"sea": {"choppy": {"folded_share": 0.0}}, "folded_share": 0.0}) is None
    assert fold_warning({"sea": {"choppy": None}}) is None


@pytest.mark.usefixtures("no_pictures")
@pytest.mark.parametrize(("speed", "covered"), [(0.0, 1.0), (8.0, 0.55), (30.0, 0.0)])
def test_a_boat_that_runs_off_the_ground_maps_is_told(tmp_path: Path, speed: float, covered: float) -> None:
    """They end 60.5 m from its start. After 2 s at 8 m/s a fan of 60 m that looks ahead has 44.5 m left, and areas are
    as squares: 0.55 (of 380 cells, of which edges cut one in ten). At 30 m/s none is left."""
    keys = {"turns": 3, "platform__speed_m_s": speed, "platform__heading_deg": 266.0, "retrieval__ground_m": 1.0}
    found = run(scene(**keys), tmp_path / "out").metrics
    assert found["ground_covered"] == pytest.approx(covered, rel=0.05)
    assert (ground_warning(found) is None) == (covered == 1.0)


def test_a_choppy_run_differs_from_a_linear_one_by_sharper_crests_only() -> None:
    linear, choppy = (Simulator(scene(sea__model=model)).turn(0) for model in ("linear", "choppy"))
    heights = [turn.truth["polar"].to_dataset()["height"].values for turn in (linear, choppy)]
    # −D·∇η: of the order of the rms slope, 0.1, of the height.
    assert 0.01 < np.std(heights[1] - heights[0]) / np.std(heights[0]) < 0.3
    assert np.corrcoef(heights[0].ravel(), heights[1].ravel())[0, 1] > 0.95
