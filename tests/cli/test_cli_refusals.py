"""What the command line refuses, in one line each, and that nothing is lost by it."""

from __future__ import annotations

import os
from pathlib import Path
from typing import Any

import command_line
import pytest
from command_line import DROWNED, PRODUCTS, assert_refused, ended, settings, start

from seamap_rt.interferometry import open_echoes
from seamap_rt.io.results_folder import KINDS
from seamap_rt.products import link, recorded_sea, writing
from seamap_rt.session import simulating, whole_run
from seamap_rt.studies import sweep
from seamap_rt.studies.shadowing import PRODUCTS as OF_SHADOWING
from validation.report import runner

call, elsewhere = command_line.call, command_line.elsewhere  # fixtures
pytestmark = pytest.mark.usefixtures("elsewhere")


# ----------------------------------------------------------------------------------------- what is refused


@pytest.mark.parametrize("command", ["run", "simulate"])
@pytest.mark.parametrize(
    ("pair", "words"),
    [
        ("radar.heigth_m=3", ("radar.heigth_m", "unknown key", "height_m")),
        ("radar.range_m=[15,400]", ("sea.extent_m = 512", "at least 860", "range circle")),
        ("radar.height_m", ("--set radar.height_m", "KEY=VALUE")),
        ("=5", ("--set =5", "KEY=VALUE")),
    ],
)
def test_bad_settings_are_one_line(call: Any, command: str, pair: str, words: tuple[str, ...]) -> None:
    assert_refused(call(command, "tiny", "--out", "results", "--set", pair), *words)
    assert not Path("results").exists()


@pytest.mark.parametrize("command", ["run", "shadowing", "outlook"])
def test_a_key_without_its_option_is_told_where_it_belongs(call: Any, command: str) -> None:
    assert_refused(call(command, "tiny", "seed=3", "turns=2"), "seed=3 turns=2", "--set seed=3 --set turns=2")
    assert_refused(call(command, "tiny", "more"), "more", "--help")


@pytest.mark.parametrize("command", ["run", "simulate"])
@pytest.mark.parametrize("option", [("--turns", "1.5"), ("--seed", "1.7"), ("--turns", "two")])
def test_no_half_turns(call: Any, command: str, option: tuple[str, str]) -> None:
    assert_refused(call(command, "tiny", "--out", "results", *option), *option, "must be a whole number")
    assert not Path("results").exists()


@pytest.mark.parametrize(
    ("varied", "words"),
    [
        ("radar.height_m=3,abc", ("--vary radar.height_m", "abc is text")),
        ("radar.heigth_m=3,5", ("radar.heigth_m", "unknown key", "height_m")),
        ("radar.height_m=", ("--vary radar.height_m=", "KEY=A,B,C")),
    ],
)
def test_a_trade_of_nonsense_is_refused_before_anything_runs(call: Any, varied: str, words: tuple[str, ...]) -> None:
    assert_refused(call("trade", "tiny", "--vary", varied, "--out", "results"), *words)
    assert not Path("results").exists()


def test_simulate_takes_turns_and_seed_as_run_does(call: Any) -> None:
    answer = call("simulate", "tiny", *settings(), "--turns", "2", "--seed", "7", "--out", "results")
    assert answer.code == 0, answer.err
    echoes = open_echoes("results/run.zarr")
    assert echoes.attrs["complete_turns"] == 2
    call("simulate", "tiny", *settings(), "--set", "turns=2", "--set", "seed=7", "--out", "same")
    assert echoes.identical(open_echoes("same/run.zarr"))


@pytest.mark.parametrize("command", ["run", "simulate"])
def test_antenna_under_water_at_time_0_is_one_line(call: Any, command: str) -> None:
    pairs = [part for key, value in DROWNED.items() for part in ("--set", f"{key}={value}")]
    answer = call(command, "sinusoid", "--out", "results", *pairs)
    assert_refused(answer, "radar.height_m = 2.4", "lower antenna, at 2.30 m", "under water at time 0", "2.50 m")
    assert not any(Path("results").glob("*"))


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


def test_tables_in_tables_without_end_are_one_line(call: Any) -> None:
    """490 deep TOML is read, and Python's recursion would end in a copy of it."""
    Path("deep.toml").write_text("[" + ".".join(["a"] * 490) + "]\nx = 1\n")
    assert_refused(call("run", "deep.toml"), "deep.toml", "nested too deeply")
    assert_refused(call("run", "tiny", "--set", ".".join(["a"] * 490) + "=1"), "nested too deeply")


def test_a_null_byte_is_one_line(call: Any) -> None:
    """No command line can hold one, but TOML can write it."""
    answer = call("run", "tiny", "--set", 'platform.motion="file"', "--set", 'platform.file="a\\u0000b"')
    assert_refused(answer, "platform.file", "null byte")


def test_a_path_that_is_too_long_is_one_line(call: Any) -> None:
    assert_refused(call("retrieve", "a" * 300), "too long", "shorter path")
    assert_refused(call("run", "tiny", "--out", "a" * 300), "too long", "choose a folder")


def test_a_terminal_that_knows_ascii_alone_is_served() -> None:
    answer = ended(start("link", "tiny", PYTHONIOENCODING="ascii", PYTHONUTF8="0"))
    assert answer.code == 0, answer.err
    assert answer.err == ""
    assert "?" in answer.out
    assert answer.out.isascii()
    assert_refused(ended(start("run", "tiny", "--turns", "½", PYTHONIOENCODING="ascii")), "--turns")


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
    assert_refused(call("simulate", "tiny", *settings(), "--out", "results"), "run.zarr", "--overwrite")
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


# ------------------------------------------------------------------------------------------- refused, nothing lost


def test_a_refused_overwrite_loses_nothing(call: Any) -> None:
    Path("kept").mkdir()
    for product in PRODUCTS:
        Path("kept", product).write_text("of another run")
    before = sorted(path.name for path in Path("kept").iterdir())
    long_waves = ("--set", "sea.waves.0.peak_period_s=40")
    assert_refused(call("run", "tiny", *settings(), *long_waves, "--out", "kept", "--overwrite"), "sea")
    assert sorted(path.name for path in Path("kept").iterdir()) == before


# ----------------------------------------------------------------------------------------------- all in one go


def test_all_errors_of_a_scene_are_told_a_line_each(call: Any) -> None:
    Path("mine.toml").write_text(
        'name = "mine"\n[sea]\nextend_m = 1024.0\n[radar]\nheight_m = -5.0\nprf_hz = "fast"\n[platform]\nspeed = 3.0\n'
        "[[sea.waves]]\nspectrum = 'jonswap'\nsignificant_wave_height_m = 30.0\npeak_period_s = 5.0\n"
    )
    answer = call("run", "mine.toml", "--out", "results")
    assert (answer.code, answer.out) == (2, "")
    lines = answer.err.splitlines()
    assert all(line.startswith("seamap-rt: ") for line in lines), answer.err
    words = ("did you mean extent_m", "did you mean speed_m_s", "radar.prf_hz", "radar.height_m", "waves break")
    assert len(lines) == len(words), answer.err
    for line, word in zip(lines, words, strict=True):
        assert word in line
    assert not Path("results").exists()


# ------------------------------------------------------------------------------------------ results of another kind


def test_the_kinds_of_folders_know_all_products() -> None:
    """What is written stands under its kind, but for names that several kinds use."""
    shared = {"scene.toml", "metrics.json"}
    written = {
        "a run's": {*whole_run.PRODUCTS, *simulating.PRODUCTS},
        "a trade's": {*sweep.PRODUCTS},
        "a shadowing study's": {*OF_SHADOWING},
        "a sea's": {*writing.PRODUCTS, *recorded_sea.PRODUCTS},
        "a link budget's": {*link.PRODUCTS},
        "a validation's": {*runner.PRODUCTS},
    }
    assert written.keys() == KINDS.keys()
    for kind, names in written.items():
        assert names - shared == set(KINDS[kind])
    assert len(set().union(*KINDS.values())) == sum(map(len, KINDS.values()))


@pytest.mark.parametrize("option", [(), ("--overwrite",)])
@pytest.mark.parametrize(
    ("there", "command", "words"),
    [
        ("run.zarr", ("trade", "tiny", "--vary", "radar.height_m=5,6", "--workers", "0"), "holds a run's"),
        ("report.html", ("shadowing", "tiny", "--heights", "5"), "holds a run's"),
        ("trade.json", ("run", "tiny", *settings()), "holds a trade's"),
        ("trade.csv", ("simulate", "tiny", *settings()), "holds a trade's"),
        ("sea.nc", ("run", "tiny", *settings()), "holds a sea's"),
        ("shadowing.nc", ("trade", "tiny", "--vary", "radar.height_m=5,6", "--workers", "0"), "holds a shadowing"),
        ("maps.nc", ("link", "tiny"), "holds a run's"),
    ],
)
def test_results_of_different_kinds_do_not_mix(
    call: Any, there: str, command: tuple[str, ...], words: str, option: tuple[str, ...]
) -> None:
    Path("results").mkdir()
    Path("results", there).write_text("kept")
    assert_refused(call(*command, *option, "--out", "results"), "results': ", words, there, "choose another")
    assert [path.name for path in Path("results").iterdir()] == [there]
    assert Path("results", there).read_text() == "kept"
