"""What one meets first: refusals that load nothing heavy, help with examples, completion, and keys that are found."""

from __future__ import annotations

import json
import os
import re
import shlex
import shutil
import subprocess
import sys
from pathlib import Path
from typing import Any, get_args

import command_line
import pytest
from command_line import assert_refused

from seamap_rt.cli.application import app
from seamap_rt.cli.beginning import Shell
from seamap_rt.scene.keys import key_sections, keys_about

call, elsewhere = command_line.call, command_line.elsewhere  # fixtures
pytestmark = pytest.mark.usefixtures("elsewhere")

COMMANDS = sorted(name for name in app if not name.startswith("-"))
SECTIONS = key_sections()
EVERY = [(each.path, row.name) for each in SECTIONS for row in each.rows]

# ------------------------------------------------------------------------------------------- what is not loaded

ASKED_FOR = {  # by what computes or draws alone
    *("drjit", "mitsuba", "sionna", "matplotlib", "numba", "dask", "distributed", "nicegui", "xarray", "pandas"),
    *("trimesh", "zarr", "h5py", "h5netcdf", "finufft", "jinja2", "PIL", "scipy.optimize", "scipy.interpolate"),
    *("scipy.ndimage", "scipy.fft"),
}
TYPED = [  # what is wrong with these is seen before a scene or a file is read
    "--help",
    "--version",
    *(f"{name} --help" for name in COMMANDS),
    "sial",
    "run tiny --bogus 3",
    "run tiny --turns many",
    "sea tiny --out sea --side x",
    "trade tiny --vary radar.height_m=3,5 --until x",
    "app --port 99999",
    "recover nosuch",
]
REFUSED = [
    "run chopy_sea",
    "run tiny --set radar.height_m=-5",
    "run tiny --set radar.heigth_m=3",
    "run tiny --set platform.speed=3",
    "run tiny --set radar.frequency_hz=9.4",
    "run tiny --set radar.range_m=[15,400]",
    "simulate tiny --out results --set turns=0",
    "sea tiny --out sea --times a",
    "link tiny --ranges a",
    "link tiny --set radar.prf_hz=fast",
    "shadowing tiny --heights a",
    "shadowing tiny --seeds 0",
    "outlook tiny --vary radar.height_m=3:1:1",
    "outlook tiny --set sea.extend_m=3",
    "trade tiny --vary radar.heigth_m=3,5",
    "trade tiny --vary radar.height_m=3,5 --budget x",
    "retrieve nosuch.npz",
    "retrieve nosuch --set retrieval.cell_m=3",
    "predict nosuch.nc",
    "predict nosuch.nc --lead a",
    "new --like nosuch",
    "keys nosuch",
]
_TELL = """
import json, sys
from seamap_rt.cli import main
told, before = [], set()
for line in json.loads(sys.argv[1]):
    try:
        main(line)
    except SystemExit as end:
        told.append([end.code, sorted(sys.modules.keys() - before)])
    before = set(sys.modules)
sys.__stderr__.write("\\n" + json.dumps(told))
"""


def loaded_by(*lines: str) -> dict[str, tuple[int, set[str]]]:
    """Exit codes of commands, one after another in a process of their own, and the modules that each of them loads, of
    the first with those of the program itself."""
    told = json.dumps([shlex.split(line) for line in lines])
    arguments = [sys.executable, "-W", "error", "-c", _TELL, told]
    done = subprocess.run(arguments, capture_output=True, text=True, check=False)
    found = json.loads(done.stderr.splitlines()[-1])
    return {line: (code, set(modules)) for line, (code, modules) in zip(lines, found, strict=True)}


@pytest.fixture(scope="module")
def lightly() -> dict[str, tuple[int, set[str]]]:
    """What is mistyped comes first: it may load least."""
    return loaded_by(*TYPED, *REFUSED)


@pytest.mark.parametrize("line", TYPED)
def test_what_is_mistyped_loads_neither_libraries_nor_settings(line: str, lightly: Any) -> None:
    code, modules = lightly[line]
    assert code == (0 if line.endswith(("--help", "--version")) else 2)
    assert not modules & (ASKED_FOR | {"numpy", "scipy", "pydantic"})


@pytest.mark.parametrize("line", REFUSED)
def test_a_refusal_loads_nothing_that_computes_or_draws(line: str, lightly: Any) -> None:
    code, modules = lightly[line]
    assert code == 2
    assert not modules & ASKED_FOR


def test_an_outlook_loads_no_tables_and_nothing_that_draws_or_meshes() -> None:
    ((code, modules),) = loaded_by("outlook tiny").values()
    assert code == 0
    unneeded = {"xarray", "pandas", "matplotlib", "trimesh", "zarr", "h5py", "dask", "distributed", "drjit", "mitsuba"}
    assert not modules & unneeded


def test_the_package_itself_loads_nothing() -> None:
    told = "import json, sys, seamap_rt; print(json.dumps(sorted(sys.modules)))"
    modules = json.loads(
        subprocess.run([sys.executable, "-c", told], capture_output=True, text=True, check=True).stdout
    )
    assert not set(modules) & (ASKED_FOR | {"numpy", "scipy", "pydantic"})
    assert {each for each in modules if each.startswith("seamap_rt.")} <= {"seamap_rt.lazy"}


# ------------------------------------------------------------------------------------------------ help and examples


@pytest.mark.parametrize("name", COMMANDS)
def test_help_ends_with_two_examples_that_are_understood(call: Any, name: str) -> None:
    answer = call(name, "--help")
    assert answer.code == 0
    _, _, examples = answer.out.partition("Examples:\n")
    lines = [line.strip() for line in examples.strip().splitlines()]
    assert len(lines) >= 2
    assert lines[0].split()[:2] == ["seamap-rt", name]
    for line in lines:
        app.parse_args(shlex.split(line)[1:], exit_on_error=False, print_error=False)  # raises for what it knows not


@pytest.mark.parametrize("wrong", ["sial", "sae", "runn", "Keys"])
def test_an_unknown_command_is_told_all_there_are(call: Any, wrong: str) -> None:
    answer = call(wrong)
    assert_refused(answer, f'"{wrong}"', "no such command", "the commands are" if wrong == "sial" else "did you mean")
    assert all(re.search(rf"\b{name}\b", answer.err) for name in COMMANDS)


def test_a_misspelt_command_is_told_the_nearest(call: Any) -> None:
    for wrong, right in (("sae", "sea"), ("runn", "run"), ("outlok", "outlook"), ("validat", "validate")):
        assert_refused(call(wrong), f"did you mean {right}?")


def number_options() -> list[tuple[str, str, str]]:
    """Command, option and what it wants, of every option that is a number."""
    found: list[tuple[str, str, str]] = []
    for name in COMMANDS:
        for argument in app[name].assemble_argument_collection():
            kinds = {argument.hint, *get_args(argument.hint)} & {int, float}
            if argument.name.startswith("--") and kinds:
                found.append((name, argument.name, "a whole number, " if int in kinds else "a number"))
    return found


def test_the_options_of_numbers_are_found() -> None:
    assert {("run", "--turns"), ("trade", "--until"), ("app", "--port")} <= {each[:2] for each in number_options()}


@pytest.mark.parametrize(("name", "option", "wanted"), number_options())
def test_every_option_of_a_number_says_what_it_wants(call: Any, name: str, option: str, wanted: str) -> None:
    example = call(name, "--help").out.split("Examples:\n")[1].splitlines()[0]
    given = re.sub(rf" {option} \S+", "", example)
    answer = call(*shlex.split(given)[1:], f"{option}=three")
    assert_refused(answer, option, f"three must be {wanted}")


# ------------------------------------------------------------------------------------------------------- completion


@pytest.mark.parametrize("kind", get_args(Shell))
def test_completion_is_installed_where_the_shell_looks(kind: str, tmp_path: Path) -> None:
    program = "from seamap_rt.cli import main; main(['--install-completion', '--shell', '" + kind + "'])"
    environment = os.environ | {"HOME": str(tmp_path), "XDG_DATA_HOME": "", "XDG_CONFIG_HOME": "", "ZDOTDIR": ""}
    done = subprocess.run([sys.executable, "-c", program], capture_output=True, text=True, env=environment, check=False)
    assert (done.returncode, done.stderr) == (0, "")
    script = Path(done.stdout.split(": completes")[0])
    assert script.is_relative_to(tmp_path)
    text = script.read_text(encoding="utf-8")
    assert all(name in text for name in COMMANDS)
    if kind != "bash" or shutil.which("bash") is None:
        return
    asked = f"""
        source {shlex.quote(str(script))}
        made=$(complete -p seamap-rt | sed 's/.*-F \\([^ ]*\\).*/\\1/')
        COMP_WORDS=(seamap-rt outl); COMP_CWORD=1; $made seamap-rt outl seamap-rt; echo "${{COMPREPLY[@]}}"
        COMP_WORDS=(seamap-rt run --tu); COMP_CWORD=2; $made seamap-rt --tu run; echo "${{COMPREPLY[@]}}"
    """
    said = subprocess.run(["bash", "--norc", "-c", asked], capture_output=True, text=True, check=True).stdout
    assert said.split() == ["outlook", "--turns"]


# ------------------------------------------------------------------------------------------------------------- keys


@pytest.mark.parametrize(("section", "name"), sorted(set(EVERY)))
def test_every_key_is_found_by_its_name_alone(section: str, name: str, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr("seamap_rt.scene.keys.key_sections", lambda: SECTIONS)  # made once, not for each key
    (found,) = keys_about(f"{section}.{name}" if section else name)
    assert found.path == section
    assert {row.name for row in found.rows} == {name}
    assert any(row.name == name for each in keys_about(name) for row in each.rows)


def test_a_key_of_a_lists_entry_is_found(call: Any) -> None:
    assert call("keys", "sea.waves.0.peak_period_s").out == call("keys", "sea.waves.peak_period_s").out


def test_a_word_is_looked_for_in_names_and_meanings(call: Any) -> None:
    lines = call("keys", "Boresight").out.splitlines()[1:]
    assert lines
    assert all("boresight" in line.casefold() for line in lines)
    names = [line.split()[0] for line in call("keys", "height").out.splitlines()[1:]]
    assert {"radar.height_m", "sea.waves.significant_wave_height_m"} <= set(names)
    assert "sea.extent_m" not in names


@pytest.mark.parametrize(
    ("wrong", "near"), [("rader", "radar"), ("radar.heigth_m", "radar.height_m"), ("heigth_m", "radar.height_m")]
)
def test_what_is_no_key_names_the_nearest(call: Any, wrong: str, near: str) -> None:
    assert_refused(call("keys", wrong), f'KEY = "{wrong}"', f"did you mean {near}")


# --------------------------------------------------------------------------------------------------------- remedies


@pytest.mark.parametrize(
    ("there", "wanted"), [("nosuch.npz", "a recording"), ("nosuch.mat", "a recording"), ("a.zarr", "a run.zarr")]
)
def test_a_file_that_is_missing_is_asked_for_by_its_own_kind(call: Any, there: str, wanted: str) -> None:
    answer = call("retrieve", there)
    assert_refused(answer, there, f"give the path of {wanted}\n")
    assert ("run.zarr" in answer.err) == there.endswith(".zarr")
