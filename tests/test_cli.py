"""The command line: what it refuses and how, what it writes, what it leaves when it is stopped."""

from __future__ import annotations

import json
import os
import signal
import subprocess
import sys
import time
from collections.abc import Iterator
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np
import pytest
import xarray as xr
from numpy.testing import assert_array_equal

import seamap_rt
from seamap_rt.cli import main
from seamap_rt.dataset import check
from seamap_rt.interferometry import open_echoes, retrieve
from seamap_rt.io.scenefile import list_shipped
from seamap_rt.scene import load_scene

SMALL = {
    "radar.sector_deg": "[260,275]",
    "radar.range_m": "[15,60]",
    "sea.extent_m": "180",
    "tracing.tracer": "horizon",
}
PRODUCTS = ("scene.toml", "echoes.zarr", "maps.nc", "truth.nc", "metrics.json", "report.html")
DROWNED = {"sea.waves.0.height_m": 5.0, "sea.waves.0.wavelength_m": 40.0, "radar.height_m": 2.4}


def settings(**changed: Any) -> list[str]:
    """The options that make `tiny` smaller still."""
    pairs = SMALL | {key.replace("__", "."): value for key, value in changed.items()}
    return [part for key, value in pairs.items() for part in ("--set", f"{key}={value}")]


class Answer(NamedTuple):
    code: int
    out: str
    err: str


@pytest.fixture(autouse=True)
def elsewhere(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Iterator[None]:
    """Work in an empty folder, and give SIGTERM back as it was."""
    monkeypatch.chdir(tmp_path)
    before = signal.getsignal(signal.SIGTERM)
    yield
    signal.signal(signal.SIGTERM, before)


@pytest.fixture
def call(capsys: pytest.CaptureFixture[str]) -> Any:
    """`seamap-rt` in this process."""

    def run(*arguments: Any) -> Answer:
        with pytest.raises(SystemExit) as end:
            main([str(argument) for argument in arguments])
        said = capsys.readouterr()
        code = end.value.code
        assert isinstance(code, int)
        return Answer(code, said.out, said.err)

    return run


def start(*arguments: Any, **environment: str) -> subprocess.Popen[str]:
    """`seamap-rt` in a process of its own, which minds Ctrl-C even where the tests run in the background."""
    program = (
        "import signal; signal.signal(signal.SIGINT, signal.default_int_handler); "
        "from seamap_rt.cli import main; main()"
    )
    return subprocess.Popen(
        [sys.executable, "-W", "error", "-c", program, *map(str, arguments)],
        stdout=subprocess.PIPE,
        stderr=subprocess.PIPE,
        text=True,
        env=os.environ | environment,
    )


def ended(process: subprocess.Popen[str]) -> Answer:
    out, err = process.communicate(timeout=120)
    return Answer(process.returncode, out, err)


def assert_refused(answer: Answer, *words: str, code: int = 2) -> None:
    """One line on stderr that holds the words, nothing on stdout, no traceback."""
    assert answer.code == code, answer.err
    assert answer.out == ""
    assert answer.err.count("\n") == 1, answer.err
    assert answer.err.startswith("seamap-rt: ")
    for word in words:
        assert word in answer.err
    for word in ("Traceback", "None", "\x1b"):
        assert word not in answer.err


def strict_json(path: Path) -> dict[str, Any]:
    def refuse(constant: str) -> None:
        raise ValueError(f"{constant} is not JSON")

    return json.loads(path.read_text(encoding="utf-8"), parse_constant=refuse)


# ----------------------------------------------------------------------------------------- what is refused


@pytest.mark.parametrize("command", ["run", "simulate"])
@pytest.mark.parametrize(
    ("pair", "words"),
    [
        ("radar.heigth_m=3", ("radar.heigth_m", "unknown key", "height_m")),
        ("sea.waves.0.peak_periode_s=3", ("sea.waves.0.peak_periode_s", "unknown key", "peak_period_s")),
        ("radar.range_m=[15,400]", ("sea.extent_m = 512", "at least 860", "range circle")),
        ("radar.height_m=nan", ("radar.height_m = nan", "not a number")),
        ("radar.range_m=[15,nan]", ("radar.range_m", "0 < near < far")),
        ("radar.height_m=-5", ("radar.height_m = -5", "greater than 0")),
        ("radar.height_m=high", ("radar.height_m", "number")),
        ("radar.height_m", ("--set radar.height_m", "KEY=VALUE")),
        ("=5", ("--set =5", "KEY=VALUE")),
        ("tracing.tracer=photons", ("tracing.tracer", "facets", "horizon", "paths")),
        ("turns=0", ("turns = 0", "at least 1")),
    ],
)
def test_bad_settings_are_one_line(call: Any, command: str, pair: str, words: tuple[str, ...]) -> None:
    assert_refused(call(command, "tiny", "--out", "results", "--set", pair), *words)
    assert not Path("results").exists()


def test_negative_wavelength_is_one_line(call: Any) -> None:
    answer = call("run", "sinusoid", "--set", "sea.waves.0.wavelength_m=-40")
    assert_refused(answer, "sea.waves.0.wavelength_m = -40", "greater than 0")


@pytest.mark.parametrize("command", ["run", "simulate"])
def test_antenna_under_water_at_time_0_is_one_line(call: Any, command: str) -> None:
    pairs = [part for key, value in DROWNED.items() for part in ("--set", f"{key}={value}")]
    answer = call(command, "sinusoid", "--out", "results", *pairs)
    assert_refused(answer, "radar.height_m = 2.4", "lower antenna, at 2.30 m", "under water at time 0", "2.50 m")
    assert not any(Path("results").glob("*"))


def test_higher_crest_further_off_is_not_refused(call: Any) -> None:
    """The same wave with its trough at the antenna and its crest, above it, half a wavelength away."""
    pairs = DROWNED | {"sea.waves.0.phase_deg": 180.0, "radar.sector_deg": "[80,90]", "radar.range_m": "[15,60]"}
    chosen = [part for key, value in pairs.items() for part in ("--set", f"{key}={value}")]
    answer = call("simulate", "sinusoid", "--out", "results", "--set", "tracing.tracer=horizon", *chosen)
    assert answer.code == 0, answer.err


@pytest.mark.parametrize("command", ["run", "simulate"])
@pytest.mark.parametrize("place", ["file/below", "file", "/proc/results", "/dev/null/results"])
def test_unwritable_out_is_one_line(call: Any, command: str, place: str) -> None:
    Path("file").write_text("in the way")
    assert_refused(call(command, "tiny", *settings(), "--out", place), f"--out = '{place}'", "choose a folder")
    assert Path("file").read_text() == "in the way"


@pytest.mark.skipif(os.geteuid() == 0, reason="permissions do not bind root")
def test_read_only_out_is_one_line(call: Any) -> None:
    Path("locked").mkdir(mode=0o500)
    assert_refused(call("run", "tiny", *settings(), "--out", "locked"), "--out = 'locked'", "written")


@pytest.mark.parametrize("text", ["a = = b", "[radar\n", "\x00\x01", "not toml at all"])
def test_scene_that_is_not_toml_is_one_line(call: Any, text: str) -> None:
    Path("bad.toml").write_text(text)
    assert_refused(call("run", "bad.toml"), "bad.toml", "is not TOML")


def test_missing_scene_is_one_line(call: Any) -> None:
    assert_refused(call("run", "chopy_sea"), "chopy_sea", "choppy_sea")
    assert_refused(call("run", "none.toml"), "none.toml")


@pytest.mark.parametrize("product", PRODUCTS)
def test_earlier_results_are_not_overwritten(call: Any, product: str) -> None:
    Path("results").mkdir()
    kept = Path("results", product)
    kept.write_text("of another run")
    answer = call("run", "tiny", *settings(), "--out", "results")
    assert_refused(answer, "--out = 'results'", product, "--overwrite")
    assert [path.name for path in Path("results").iterdir()] == [product]
    assert kept.read_text() == "of another run"


def test_simulate_minds_only_what_it_writes(call: Any) -> None:
    Path("results").mkdir()
    Path("results", "report.html").write_text("of another run")
    assert call("simulate", "tiny", *settings(), "--out", "results").code == 0
    assert_refused(call("simulate", "tiny", *settings(), "--out", "results"), "echoes.zarr", "--overwrite")
    assert call("simulate", "tiny", *settings(), "--out", "results", "--overwrite").code == 0
    assert Path("results", "report.html").read_text() == "of another run"


@pytest.mark.parametrize(
    ("arguments", "words"),
    [
        (("run", "tiny", "--bogus", "3"), ("--bogus",)),
        (("run", "tiny", "--set"), ("--set",)),
        (("run", "tiny", "--turns", "many"), ("--turns", "many")),
        (("run", "tiny", "--tracer", "photons"), ("tracing.tracer", "facets")),
        (("run", "tiny", "--seed", "-1"), ("seed = -1",)),
        (("run",), ("scene",)),
        (("simulate", "tiny"), ("--out",)),
        (("sail",), ("sail",)),
        (("run", "tiny", "two"), ("two",)),
    ],
)
def test_wrong_options_are_one_line(call: Any, arguments: tuple[str, ...], words: tuple[str, ...]) -> None:
    assert_refused(call(*arguments), *words)


def test_retrieve_refuses_what_holds_no_echoes(call: Any, tmp_path: Path) -> None:
    Path("file").write_text("no store")
    Path("empty").mkdir()
    Path("broken").mkdir()
    Path("broken", "zarr.json").write_text("{")
    for name in ("file", "empty", "broken"):
        assert_refused(call("retrieve", name, "--out", "maps"), f"ECHOES = '{name}'")
    assert_refused(call("retrieve", "none"), "ECHOES = 'none'", "no such")
    assert_refused(call("retrieve", "empty", "--set", "radar.height_m=3"), "radar.height_m", "retrieval.")
    assert_refused(call("retrieve", "empty", "--set", "retrieval.cell_m=3"), "retrieval.cell_m", "unknown key")


def test_refusals_reach_the_shell() -> None:
    """As a process: exit code 2 and one line, nothing more on either stream."""
    assert_refused(ended(start("run", "tiny", "--set", "radar.height_m=nan")), "radar.height_m = nan")


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
    answer = ended(start("run", "tiny", *settings(), "--turns", 2, "--out", folder))
    assert answer.code == 0, answer.err
    return Made(folder, answer)


def test_run_writes_every_file_of_the_contract(two_turns: Made) -> None:
    for name in PRODUCTS:
        assert (two_turns.folder / name).exists()
    assert list(two_turns.folder.glob("*.png"))
    assert not list(two_turns.folder.glob(".*"))  # nothing half made is left
    assert two_turns.answer.err == ""
    told = two_turns.answer.out.splitlines()
    assert "50–200 m" in told[-3]
    assert told[-2].startswith("sea state from the maps: ")
    assert str(two_turns.folder / "report.html") in told[-1]


def test_run_tells_what_was_modelled_and_what_was_left_out(two_turns: Made) -> None:
    told = two_turns.answer.out.splitlines()
    assert len(told) <= 25
    metrics, account = strict_json(two_turns.folder / "metrics.json"), told[:-3]
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
    assert metrics["real_time_factor"] > 0.0
    assert metrics["facets"] > 1000
    assert metrics["rays"] == 0  # the horizon tracer shoots none
    assert 5e7 < metrics["peak_memory_bytes"] < 4e9
    for key in ("modelled", "left_out"):
        assert all(row.keys() >= {"what", "why", "error", "source"} for row in metrics[key])
    assert all(row["cost"] for row in metrics["modelled"])


def test_products_keep_the_schema_and_hold_both_turns(two_turns: Made) -> None:
    echoes = open_echoes(two_turns.folder / "echoes.zarr")
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


def test_one_turn_of_two_is_the_run_of_one(two_turns: Made, call: Any) -> None:
    """--turns appends: the first turn's bits do not depend on how many follow."""
    assert call("simulate", "tiny", *settings(), "--out", "one").code == 0
    one, two = open_echoes("one/echoes.zarr"), open_echoes(two_turns.folder / "echoes.zarr")
    members = two["turn"].values == 0
    assert one["voltage"].values.tobytes() == two["voltage"].values[members].tobytes()


def test_resolved_scene_runs_again_to_the_same_bits(two_turns: Made, call: Any) -> None:
    path = two_turns.folder / "scene.toml"
    assert call("simulate", path, "--out", "again").code == 0
    first, second = open_echoes(two_turns.folder / "echoes.zarr"), open_echoes("again/echoes.zarr")
    assert first["voltage"].values.tobytes() == second["voltage"].values.tobytes()
    overrides: dict[str, Any] = {**SMALL, "turns": 2}
    assert load_scene(path) == load_scene("tiny", overrides=overrides)


def test_simulate_and_retrieve_make_the_maps_of_run(two_turns: Made, call: Any) -> None:
    assert call("simulate", "tiny", *settings(turns=2), "--out", "apart").code == 0
    assert sorted(path.name for path in Path("apart").iterdir()) == ["echoes.zarr", "truth.nc"]
    assert call("retrieve", "apart/echoes.zarr").code == 0
    assert_refused(call("retrieve", "apart/echoes.zarr"), "maps.nc", "--overwrite")
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


def test_retrieve_takes_other_settings_and_another_folder(two_turns: Made, call: Any) -> None:
    answer = call(
        "retrieve",
        two_turns.folder / "echoes.zarr",
        "--out",
        "coarse",
        "--set",
        "retrieval.cell_azimuth_deg=3.6",
        "--set",
        "retrieval.estimator=single_cell",
    )
    assert answer.code == 0
    answered, state, written = answer.out.strip().splitlines()
    assert "of the cells answered, median error bar 0." in answered
    assert state.startswith("sea state: ")
    assert written == "coarse/maps.nc"
    with xr.open_datatree("coarse/maps.nc") as maps:
        polar = maps["polar"].to_dataset()
        assert polar.sizes["azimuth"] == 4
        assert polar.attrs["estimator"] == "single_cell"


def test_default_folder_is_named_after_scene_and_seed(call: Any) -> None:
    assert call("run", "tiny", *settings(), "--seed", 7).code == 0
    assert {path.name for path in Path("runs/tiny-7").iterdir()} >= set(PRODUCTS)
    assert load_scene("runs/tiny-7/scene.toml").seed == 7
    # one turn: no warm one to speak of
    metrics = strict_json(Path("runs/tiny-7/metrics.json"))
    assert metrics["timing_s"]["warm"] is None
    assert metrics["real_time_factor"] is None
    # and the same again, only where it is allowed to
    assert_refused(call("run", "tiny", *settings(), "--seed", 7), "runs/tiny-7", "--overwrite")
    voltage = open_echoes("runs/tiny-7/echoes.zarr")["voltage"].values.tobytes()
    assert call("run", "tiny", *settings(), "--seed", 7, "--overwrite").code == 0
    assert open_echoes("runs/tiny-7/echoes.zarr")["voltage"].values.tobytes() == voltage


def test_same_seed_same_bits_another_seed_another_sea(two_turns: Made, call: Any) -> None:
    for seed, folder in ((1, "one"), (2, "two")):
        pairs = settings(seed=seed, turns=2)
        assert call("simulate", "tiny", *pairs, "--out", folder).code == 0
    same, other = open_echoes("one/echoes.zarr"), open_echoes("two/echoes.zarr")
    reference = open_echoes(two_turns.folder / "echoes.zarr")["voltage"].values
    assert same["voltage"].values.tobytes() == reference.tobytes()
    assert other["voltage"].values.tobytes() != reference.tobytes()
    with xr.open_datatree("one/truth.nc") as one, xr.open_datatree("two/truth.nc") as two:
        assert np.abs(one["polar"]["height"] - two["polar"]["height"]).max() > 0.3


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


# ------------------------------------------------------------------------------------------------ no backend


def test_no_backend_is_one_line_and_exit_3_for_rays_only() -> None:
    nowhere = {"DRJIT_LIBLLVM_PATH": "/nonexistent/libLLVM.so", "CUDA_VISIBLE_DEVICES": ""}
    arguments = ("run", "tiny", *settings(tracing__tracer="facets"), "--out")
    rays = start(*arguments, "rays", **nowhere)
    horizon = start(*arguments, "horizon", "--tracer", "horizon", **nowhere)
    told = start("doctor", **nowhere)
    answer = ended(rays)
    if answer.code == 0:
        pytest.skip("a CUDA device serves, whatever the variable says")
    assert_refused(answer, "no usable", "/nonexistent/libLLVM.so", "DRJIT_LIBLLVM_PATH", code=3)
    assert not list(Path("rays").iterdir())  # refused before anything was made, or an earlier run's results removed
    answer = ended(horizon)
    assert answer.code == 0, answer.err
    assert {path.name for path in Path("horizon").iterdir()} >= set(PRODUCTS)
    answer = ended(told)
    assert answer.code == 3
    assert "MISSING" in answer.out
    assert "Traceback" not in answer.err


# ----------------------------------------------------------------------------------------------- interrupted


def complete_turns(store: Path) -> int:
    try:
        return int(json.loads((store / "zarr.json").read_text())["attributes"]["complete_turns"])
    except (OSError, ValueError, KeyError):
        return 0


def stopped(process: subprocess.Popen[str], store: Path, number: signal.Signals, after: int) -> Answer:
    """Send a signal once so many turns are complete, and wait for the end."""
    try:
        limit = time.monotonic() + 60.0
        while complete_turns(store) < after:
            assert process.poll() is None, process.communicate()
            assert time.monotonic() < limit
            time.sleep(0.01)
        process.send_signal(number)
        return ended(process)
    finally:
        process.kill()


@pytest.mark.parametrize("number", [signal.SIGINT, signal.SIGTERM])
def test_interrupted_run_leaves_whole_turns(call: Any, number: signal.Signals) -> None:
    process = start("run", "tiny", *settings(), "--turns", 5000, "--out", "cut")
    answer = stopped(process, Path("cut/echoes.zarr"), number, after=2)
    assert_refused(answer, "interrupted", "turns are complete", "missing", code=130)

    echoes = open_echoes("cut/echoes.zarr")
    turns = echoes.attrs["complete_turns"]
    assert 2 <= turns < 5000
    assert_array_equal(np.unique(echoes["turn"].values), np.arange(turns))
    voltage = echoes["voltage"].values
    assert np.isfinite(voltage).all()
    assert (np.abs(voltage).max(axis=(1, 2)) > 0.0).all()  # noise on every pulse: none is a fill value
    counts = np.bincount(echoes["turn"].values)
    assert np.ptp(counts) <= 1  # 15° hold 416⅔ pulses
    for product in ("maps", "truth"):
        with xr.open_datatree(f"cut/{product}.nc") as tree:
            for group in ("polar", "ground"):
                assert_array_equal(tree[group]["turn"].values, np.arange(turns))
    assert not Path("cut/metrics.json").exists()
    assert not Path("cut/report.html").exists()
    assert {path.name for path in Path("cut").iterdir()} == {"echoes.zarr", "maps.nc", "scene.toml", "truth.nc"}

    # What is left can be retrieved anew, to the same bits.
    assert call("retrieve", "cut/echoes.zarr", "--out", "anew").code == 0
    with xr.open_datatree("cut/maps.nc") as before, xr.open_datatree("anew/maps.nc") as anew:
        for group in ("polar", "ground"):
            xr.testing.assert_identical(before[group].to_dataset(), anew[group].to_dataset())


def test_interrupted_simulation_leaves_whole_turns() -> None:
    process = start("simulate", "tiny", *settings(turns=5000), "--out", "cut")
    answer = stopped(process, Path("cut/echoes.zarr"), signal.SIGTERM, after=1)
    assert_refused(answer, "interrupted", code=130)
    echoes = open_echoes("cut/echoes.zarr")
    turns = echoes.attrs["complete_turns"]
    with xr.open_datatree("cut/truth.nc") as truth:
        assert truth["polar"].sizes["turn"] == turns
    maps = retrieve(echoes)
    assert maps["polar"].sizes["turn"] == turns


def test_run_that_is_stopped_before_its_first_turn_leaves_no_half_file(call: Any, monkeypatch: Any) -> None:
    """Ctrl-C while the first turn is simulated: a line, exit 130, and a store that says that it holds nothing."""

    def stop(*_: Any) -> None:
        raise KeyboardInterrupt

    monkeypatch.setattr("seamap_rt.simulation.Simulator.turn", stop)
    assert_refused(call("run", "tiny", *settings(), "--out", "cut"), "interrupted", code=130)
    assert {path.name for path in Path("cut").iterdir()} <= {"scene.toml", "echoes.zarr"}


@pytest.mark.parametrize(
    "error",
    [
        OSError(28, "No space left on device", "results/truth.nc"),
        OSError("results/truth.nc: write failed\n(No space left on device)"),  # as HDF5 raises it
    ],
)
def test_full_disk_is_one_line(call: Any, monkeypatch: Any, error: OSError) -> None:
    def full(*_: Any) -> None:
        raise error

    monkeypatch.setattr("seamap_rt.echoes.files.EchoStore.append", full)
    answer = call("simulate", "tiny", *settings(), "--out", "results")
    assert_refused(answer, "results/truth.nc", "No space left on device")


# ------------------------------------------------------------------------------------------- refused, nothing lost


def test_waves_that_do_not_fit_the_patch_are_one_line(call: Any) -> None:
    answer = call("run", "tiny", *settings(), "--set", "sea.waves.0.peak_period_s=40", "--out", "long")
    assert_refused(answer, "sea", "extent_m")


def test_a_refused_overwrite_loses_nothing(call: Any) -> None:
    assert call("run", "tiny", *settings(), "--out", "kept").code == 0
    before = sorted(path.name for path in Path("kept").iterdir())
    long_waves = ("--set", "sea.waves.0.peak_period_s=40")
    assert_refused(call("run", "tiny", *settings(), *long_waves, "--out", "kept", "--overwrite"), "sea")
    assert sorted(path.name for path in Path("kept").iterdir()) == before
