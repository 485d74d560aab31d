"""The command line: what it says, and what a whole run writes."""

from __future__ import annotations

import shutil
from pathlib import Path
from typing import Any, NamedTuple

import command_line
import numpy as np
import pytest
import xarray as xr
from command_line import PRODUCTS, SMALL, Answer, assert_refused, ended, settings, start, strict_json
from numpy.testing import assert_array_equal

import seamap_rt
from seamap_rt.app.source import Results, Source
from seamap_rt.dataset import check
from seamap_rt.interferometry import open_echoes
from seamap_rt.io.scenefile import list_shipped
from seamap_rt.scene import load_scene

call, elsewhere = command_line.call, command_line.elsewhere  # fixtures
pytestmark = pytest.mark.usefixtures("elsewhere")


# --------------------------------------------------------------------------------------------- what is told


def test_scenes_are_listed_a_line_each(call: Any) -> None:
    answer = call("scenes")
    assert answer.code == 0
    assert [line.split()[0] for line in answer.out.splitlines()] == list(list_shipped())
    assert {"choppy_sea", "calm", "long_crested_swell", "flat", "sinusoid", "wide_baseline", "tiny"} <= set(
        list_shipped()
    )
    for line in answer.out.splitlines():
        assert len(line.split(maxsplit=1)[1]) > 10  # its title
    assert answer.err == ""


def test_doctor_tells_backend_and_versions(call: Any) -> None:
    answer = call("doctor")
    assert answer.code == 0
    for item in ("backend", "library", "found by", "sionna-rt", "mitsuba", "drjit", "trimesh", "numpy", "python"):
        assert f"  {item}" in answer.out
    assert np.__version__ in answer.out
    assert "MISSING" not in answer.out


def test_version_and_help(call: Any) -> None:
    assert call("--version").out.strip() == seamap_rt.__version__
    told = call("--help")
    assert told.code == 0
    for command in ("run", "simulate", "retrieve", "scenes", "doctor"):
        assert command in told.out
    told = call("run", "--help")
    assert told.code == 0
    for option in ("--out", "--turns", "--seed", "--tracer", "--set", "--overwrite"):
        assert option in told.out


# ------------------------------------------------------------------------------------------------- a whole run


class Made(NamedTuple):
    folder: Path
    answer: Answer


@pytest.fixture(scope="module")
def two_turns(tmp_path_factory: pytest.TempPathFactory) -> Made:
    """`run` with two turns, in a process of its own with warnings as errors."""
    folder = tmp_path_factory.mktemp("two") / "results"
    answer = ended(start("run", "tiny", *settings(), "--turns", 2, "--account", "--out", folder))
    assert answer.code == 0, answer.err
    return Made(folder, answer)


def test_run_writes_every_file_of_the_contract(two_turns: Made) -> None:
    for name in PRODUCTS:
        assert (two_turns.folder / name).exists()
    assert list(two_turns.folder.glob("*.png"))
    assert not list(two_turns.folder.glob(".*"))  # nothing half made is left
    assert two_turns.answer.err == ""
    told = two_turns.answer.out.splitlines()
    assert told[0].startswith("Sees the waves out to ")  # results come first, then how they were made
    assert told[1].startswith("50–60 m, cells more than half visible: ")
    assert told[2].startswith("sea state from the maps: ")
    assert str(two_turns.folder / "report.html") in told[-1]


def test_run_tells_what_was_modelled_and_what_was_left_out(two_turns: Made) -> None:
    told = two_turns.answer.out.splitlines()
    assert len(told) <= 25
    metrics, account = strict_json(two_turns.folder / "metrics.json"), told[3:-1]
    for key, kind in (("modelled", "modelled: "), ("left_out", "left out: ")):
        lines = [line for line in account if line.startswith(kind)]
        for row in metrics[key]:
            assert any(row["what"] in line for line in lines)
    shadowing = next(row for row in metrics["modelled"] if row["what"] == "shadowing")
    assert shadowing["cost_s"] == metrics["timing_s"]["warm"]["trace"]
    assert f"modelled: shadowing ({shadowing['cost']}; without it {shadowing['error']})" in account
    page = (two_turns.folder / "report.html").read_text(encoding="utf-8")
    assert shadowing["cost"] in page
    assert shadowing["error"] in page


def test_metrics_are_strict_json_with_the_contracts_keys(two_turns: Made) -> None:
    metrics = strict_json(two_turns.folder / "metrics.json")
    by_range = ("height_rmse_m", "height_robust_m", "height_bias_m", "slope_rmse", "visible_fraction")
    for key in by_range:
        assert len(metrics[key]) == len(metrics["range_m"]) > 0
    assert metrics["overall"].keys() >= {
        "height_rmse_m",
        "height_robust_m",
        "height_bias_m",
        "height_correlation",
        "hs_true_m",
        "hs_retrieved_m",
    }
    steps = {"sea", "mesh", "trace", "echoes", "retrieve", "write", "total"}
    for which in ("first", "warm"):
        timing = metrics["timing_s"][which]
        assert timing.keys() >= steps
        assert timing["total"] >= sum(timing[step] for step in steps - {"total"}) - 1e-6
    simulated = (2 - 1) * load_scene(two_turns.folder / "scene.toml").turn_duration_s  # of the warm turn
    assert metrics["real_time_factor"] * metrics["timing_s"]["warm_wall"] == pytest.approx(simulated)
    assert 0.0 < metrics["timing_s"]["warm_wall"] < metrics["run_s"]
    assert metrics["facets"] > 1000
    assert metrics["rays"] == 0  # the horizon tracer shoots none
    assert 5e7 < metrics["peak_memory_bytes"] < 4e9
    for key in ("modelled", "left_out"):
        assert all(row.keys() >= {"what", "why", "error", "source"} for row in metrics[key])
    assert all(row["cost"] for row in metrics["modelled"])


def test_products_keep_the_schema_and_hold_both_turns(two_turns: Made) -> None:
    echoes = open_echoes(two_turns.folder / "run.zarr")
    check("echoes", echoes)
    assert echoes.attrs["complete_turns"] == 2
    assert_array_equal(np.unique(echoes["turn"].values), [0, 1])
    for product in ("maps", "truth"):
        with xr.open_datatree(two_turns.folder / f"{product}.nc") as tree:
            for group in ("polar", "ground"):
                check(f"{product}/{group}", tree[group].to_dataset())
                assert_array_equal(tree[group]["turn"].values, [0, 1])
    first, second = (echoes["voltage"].values[echoes["turn"].values == turn] for turn in (0, 1))
    assert first.shape == second.shape
    assert np.abs(first - second).max() > 0.0


@pytest.mark.usefixtures("no_pictures")
def test_rays_are_counted_and_named(call: Any) -> None:
    """By default the light is ray traced: a shadow ray per facet and antenna, and the metrics say so."""
    assert call("run", "tiny", *settings(tracing__tracer="facets"), "--out", "rays").code == 0
    metrics = strict_json(Path("rays/metrics.json"))
    # One to each facet that faces the antenna, for each antenna: most, but not the backs of the waves.
    assert metrics["facets"] < metrics["rays"] < 2 * metrics["facets"]
    assert any("ray" in row["why"] and "Sionna" in row["why"] for row in metrics["modelled"])


def test_report_is_one_file(two_turns: Made) -> None:
    page = (two_turns.folder / "report.html").read_text(encoding="utf-8")
    assert "<html" in page
    assert 'src="http' not in page
    assert "data:image/png;base64," in page


def test_resolved_scene_runs_again_to_the_same_bits(two_turns: Made, call: Any) -> None:
    path = two_turns.folder / "scene.toml"
    assert call("simulate", path, "--out", "again").code == 0
    first, second = open_echoes(two_turns.folder), open_echoes("again")
    assert first["voltage"].values.tobytes() == second["voltage"].values.tobytes()
    overrides: dict[str, Any] = {**SMALL, "turns": 2}
    assert load_scene(path) == load_scene("tiny", overrides=overrides)


def test_simulate_and_retrieve_make_the_maps_of_run(two_turns: Made, call: Any) -> None:
    assert call("simulate", "tiny", *settings(turns=2), "--out", "apart").code == 0
    assert sorted(path.name for path in Path("apart").iterdir()) == ["run.zarr", "truth.nc"]
    assert call("retrieve", "apart").code == 0
    assert_refused(call("retrieve", "apart/run.zarr"), "maps.nc", "--overwrite")
    for product in ("maps", "truth"):
        with (
            xr.open_datatree(f"apart/{product}.nc") as apart,
            xr.open_datatree(two_turns.folder / f"{product}.nc") as together,
        ):
            for group in ("polar", "ground"):
                here, there = apart[group].to_dataset(), together[group].to_dataset()
                xr.testing.assert_identical(here, there)
                for name, variable in there.variables.items():
                    assert here[name].values.tobytes() == variable.values.tobytes()


def test_folders_of_earlier_versions_still_open(two_turns: Made, call: Any) -> None:
    """Where the echoes are a store of their own: by the page and `retrieve`; a new run is told what is there."""
    shutil.copytree(two_turns.folder, "old", ignore=shutil.ignore_patterns("run.zarr"))
    shutil.copytree(two_turns.folder / "run.zarr" / "echoes", "old/echoes.zarr")
    results = [Results(folder) for folder in (Path("old"), two_turns.folder)]
    old, new = (Source(each) for each in results)
    for one, other in zip(old.view("echo", 1).panels, new.view("echo", 1).panels, strict=True):
        assert one == other
    assert results[0].turns() == [0, 1]
    assert open_echoes("old").identical(open_echoes(two_turns.folder))
    for echoes in ("old", "old/echoes.zarr"):
        assert call("retrieve", echoes, "--out", "maps", "--overwrite").code == 0
        with xr.open_datatree("maps/maps.nc") as anew, xr.open_datatree(two_turns.folder / "maps.nc") as maps:
            xr.testing.assert_identical(anew["polar"].to_dataset(), maps["polar"].to_dataset())
    assert_refused(call("retrieve", "old"), "maps.nc", "--overwrite")
    assert_refused(call("run", two_turns.folder / "scene.toml", "--out", "old"), "scene.toml", "--overwrite")
    for each in results:
        each.close()


def test_retrieve_takes_other_settings_and_another_folder(two_turns: Made, call: Any) -> None:
    answer = call(
        "retrieve",
        two_turns.folder / "run.zarr",
        "--out",
        "coarse",
        "--set",
        "retrieval.cell_azimuth_deg=3.6",
        "--set",
        "retrieval.estimator=single_cell",
    )
    assert answer.code == 0
    *_, answered, state, written, page = answer.out.strip().splitlines()
    assert "of the cells answered, median error bar 0." in answered
    assert state.startswith("sea state: ")
    assert (written, page) == ("coarse/maps.nc", "coarse/retrieval.html")
    assert "The radar as it is described" in Path(page).read_text(encoding="utf-8")
    with xr.open_datatree("coarse/maps.nc") as maps:
        polar = maps["polar"].to_dataset()
        assert polar.sizes["azimuth"] == 4
        assert polar.attrs["estimator"] == "single_cell"


@pytest.mark.usefixtures("no_pictures")
def test_default_folder_is_named_after_scene_and_seed(call: Any) -> None:
    answer = call("run", "tiny", *settings(), "--seed", 7)
    assert answer.code == 0
    assert len(answer.out.splitlines()) <= 15  # verdict, figures, where the files are
    assert {path.name for path in Path("runs/tiny-7").iterdir()} >= set(PRODUCTS)
    assert load_scene("runs/tiny-7/scene.toml").seed == 7
    # one turn: no warm one to speak of
    metrics = strict_json(Path("runs/tiny-7/metrics.json"))
    assert metrics["timing_s"]["warm"] is None
    assert metrics["real_time_factor"] is None
    # and the same again, only where it is allowed to
    assert_refused(call("run", "tiny", *settings(), "--seed", 7), "runs/tiny-7", "--overwrite")


def test_options_stand_for_their_keys(call: Any) -> None:
    answer = call("run", "tiny", *settings(), "--tracer", "photons", "--set", "turns=3")
    assert_refused(answer, "tracing.tracer")  # the option wins over the key that was set
    assert_refused(call("run", "tiny", *settings(), "--turns", -1, "--set", "turns=3"), "turns = -1")


def test_everything_dark_still_ends_with_a_report(call: Any) -> None:
    """An antenna just above the trough between high waves hardly sees a cell: NaN and null, not a crash."""
    keys = {
        "sea.waves.0.height_m": 4.0,
        "sea.waves.0.wavelength_m": 30.0,
        "sea.waves.0.phase_deg": 180.0,
        "radar.height_m": 0.5,
        "radar.range_m": "[30,60]",
        "radar.sector_deg": "[80,90]",
        "tracing.tracer": "horizon",
    }
    pairs = [part for key, value in keys.items() for part in ("--set", f"{key}={value}")]
    answer = call("run", "sinusoid", "--out", "dark", *pairs)
    assert answer.code == 0, answer.err
    metrics = strict_json(Path("dark/metrics.json"))
    assert metrics["overall"]["height_rmse_m"] is None
    assert "nan" not in answer.out
    with xr.open_datatree("dark/truth.nc") as truth:
        polar = truth["polar"].to_dataset()
        assert polar["visible_fraction"].values.max() == 0.0
        assert np.isfinite(polar["height"].values).any()
