"""What the READMEs show is true: code runs as it stands, and files, commands, modules, options and links exist."""

from __future__ import annotations

import ast
import importlib.util
import re
import shlex
import tomllib
from itertools import pairwise
from pathlib import Path

import numpy as np
import pytest

from seamap_rt.cli.application import app
from seamap_rt.interferometry import echoes_from_recording
from seamap_rt.io.recording_header import read_header
from seamap_rt.scene import load_scene

ROOT = Path(__file__).parents[1]
READMES = [
    readme
    for readme in ("README.md", "scenes/README.md", "seamap_rt/README.md", "validation/README.md")
    if (ROOT / readme).exists()
] + [f"validation/models/{page.name}" for page in sorted((ROOT / "validation/models").glob("*.md"))]
INSTALL = (
    "python3 -m venv .venv && .venv/bin/pip install -e '.[llvm]' && .venv/bin/seamap-rt run scenes/choppy_sea.toml",
    ".venv/bin/pip install -e '.[llvm,test]' && .venv/bin/pytest",
)
QUICK = {"sector_deg": "[264.0, 276.0]", "resolution_m": "1.6", "height_error_m": "0.2"}  # takes seconds
MOST_LINES = 200  # of README.md: what a newcomer reads in five minutes
OUTSIDE = {"python3", "pip", "pytest", "ruff", "pyright", "lint-imports"}  # commands of other programs


def text_of(readme: str) -> str:
    return (ROOT / readme).read_text(encoding="utf-8")


def blocks(readme: str, language: str) -> list[str]:
    """The blocks of code of a README in a language, in their order."""
    return re.findall(rf"^```{language}\n(.*?)^```$", text_of(readme), flags=re.MULTILINE | re.DOTALL)


def prose(readme: str) -> str:
    """The README without its blocks of code."""
    return re.sub(r"^```.*?^```$", "", text_of(readme), flags=re.MULTILINE | re.DOTALL)


def inline_code(readme: str) -> list[str]:
    """What stands between backticks, each on one line."""
    return [" ".join(code.split()) for code in re.findall(r"`([^`]+)`", prose(readme))]


def command_lines(readme: str) -> list[list[str]]:
    """The words of every command that a README shows, in blocks of sh and in the text."""
    shown = [line for block in blocks(readme, "sh") for line in block.splitlines() if not line.startswith("#")]
    shown += [code for code in inline_code(readme) if code.startswith(("seamap-rt ", "python -m "))]
    return [shlex.split(part) for line in shown for part in line.split("&&") if part.strip()]


def anchors(path: Path) -> set[str]:
    """The anchors that GitHub gives to the headings of a Markdown file."""
    body = re.sub(r"^```.*?^```$", "", path.read_text(encoding="utf-8"), flags=re.MULTILINE | re.DOTALL)
    headings = re.findall(r"^#+ (.*)$", body, flags=re.MULTILINE)
    return {re.sub(r"[^\w\- ]", "", heading.lower()).strip().replace(" ", "-") for heading in headings}


@pytest.mark.parametrize("readme", READMES)
def test_code_runs(readme: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """Python blocks one after the other, as a reader would; TOML blocks are read as the scene or header they are."""
    scenes = tmp_path / "scenes"
    scenes.mkdir()
    scene = text_of("scenes/choppy_sea.toml")
    for key, value in QUICK.items():
        scene, count = re.subn(rf"^{key} = [^#\n]*", f"{key} = {value} ", scene, flags=re.MULTILINE)
        assert count == 1, key
    (scenes / "choppy_sea.toml").write_text(scene, encoding="utf-8")
    monkeypatch.chdir(tmp_path)
    names: dict[str, object] = {}
    for number, block in enumerate(blocks(readme, "python")):
        exec(compile(block, f"{readme}, Python block {number + 1}", "exec"), names)

    for number, block in enumerate(blocks(readme, "toml")):
        path, given = Path(f"{number}.toml"), tomllib.loads(block)
        path.write_text(block, encoding="utf-8")
        if "first_gate_m" in given:
            assert read_header(path).transmit == given["transmit"]
            pulses, sea = np.arange(2000), np.ones((2000, 40), dtype=complex)
            echoes = echoes_from_recording(sea, sea, path, time=pulses / 1e3, azimuth=0.36 * pulses % 360.0)
            assert echoes.attrs["complete_turns"] == 2  # two arrays, time and azimuth are enough, as it says
        else:
            assert [waves.spectrum for waves in load_scene(path).sea.waves] == [
                waves["spectrum"] for waves in given["sea"]["waves"]
            ]


@pytest.mark.parametrize("readme", READMES)
def test_commands_exist_with_their_options(readme: str) -> None:
    for words in command_lines(readme):
        program, options = Path(words[0]).name, {word.split("=")[0] for word in words if word.startswith("--")}
        if program == "seamap-rt":
            known = {name for argument in app[words[1]].assemble_argument_collection() for name in argument.names}
        elif words[:2] == ["python", "-m"]:
            known = options_of(words[2])
        else:
            assert program in OUTSIDE, " ".join(words)
            continue
        assert options <= known | {"--help"}, " ".join(words)


def options_of(module: str) -> set[str]:
    """Options that the source of a module gives to its command line; the module is not imported."""
    spec = importlib.util.find_spec(module)
    assert spec is not None, f"python -m {module}: no such module"
    assert spec.origin is not None
    source = Path(spec.origin).read_text(encoding="utf-8")
    calls = [node for node in ast.walk(ast.parse(source)) if isinstance(node, ast.Call)]
    named = [each.arg or "" for call in calls if ast.unparse(call.func) == "options" for each in call.keywords]
    return set(re.findall(r'add_argument\(\s*"(--[\w-]+)"', source)) | {f"--{each.replace('_', '-')}" for each in named}


def test_table_of_commands_is_whole() -> None:
    table = re.findall(r"^\| `seamap-rt (\w+)([^`]*)` \|", text_of("README.md"), flags=re.MULTILINE)
    assert {name for name, _ in table} == {name for name in app if not name.startswith("-")}
    for name, usage in table:
        known = {option for argument in app[name].assemble_argument_collection() for option in argument.names}
        assert set(re.findall(r"--[a-z-]+", usage)) <= known, name


@pytest.mark.parametrize("readme", READMES)
def test_overrides_are_taken(readme: str) -> None:
    """`--set KEY=VALUE` of a command that names a shipped scene is a key and a value of it."""
    for words in command_lines(readme):
        pairs = [word for before, word in pairwise(words) if before == "--set" and "KEY" not in word]
        if pairs:
            scene = words[2] if words[0] == "seamap-rt" else "choppy_sea"
            load_scene(scene, overrides=dict(pair.split("=", 1) for pair in pairs))


@pytest.mark.parametrize("readme", READMES)
def test_files_and_modules_that_are_named_exist(readme: str) -> None:
    for code in inline_code(readme):
        if re.fullmatch(r"(seamap_rt|validation|tests|scenes)/[\w./]*", code):
            assert (ROOT / code).exists(), f"{readme} names {code}"
        file = code.endswith((".toml", ".md", ".html"))
        if re.fullmatch(r"(seamap_rt|validation)(\.[a-z_]+)+", code) and not file:
            assert named(code), f"{readme} names {code}"


def named(dotted: str) -> bool:
    """Whether this is a module, or a name that the source of its module holds; nothing but packages is imported."""
    home, _, name = dotted.rpartition(".")
    spec = importlib.util.find_spec(home)
    if spec is None:
        return False
    if spec.submodule_search_locations is not None and importlib.util.find_spec(dotted) is not None:
        return True
    source = Path(spec.origin).read_text(encoding="utf-8") if spec.origin is not None else ""
    return re.search(rf"\b{name}\b", source) is not None


@pytest.mark.parametrize("readme", READMES)
def test_links_and_figures_resolve(readme: str) -> None:
    here = ROOT / readme
    for target in re.findall(r"\]\(([^)\s]+)\)", prose(readme)):
        if target.startswith("https://"):
            continue
        file, _, anchor = target.partition("#")
        path = here.parent / file if file else here
        assert path.exists(), f"{readme} links to {target}"
        assert not anchor or anchor in anchors(path), f"{readme} links to {target}"


def test_map_names_the_layers_in_their_order() -> None:
    """The table of packages in seamap_rt/README.md is that of the contract which lint-imports keeps."""
    contracts = tomllib.loads(text_of("pyproject.toml"))["tool"]["importlinter"]["contracts"]
    layers = [set(layer.split(" | ")) for layer in contracts[0]["layers"]]
    section = text_of("seamap_rt/README.md").split("## The packages")[1].split("`interferometry` works")[0]
    rooms = re.findall(r"^\| `(\w+)` \|", section, flags=re.MULTILINE)
    layer_of = {room: number for number, layer in enumerate(layers) for room in layer}
    assert set(rooms) == set(layer_of)
    numbers = [layer_of[room] for room in rooms if room in layer_of]
    assert numbers == sorted(numbers)


def test_readme_is_short_and_holds_the_two_lines() -> None:
    lines = text_of("README.md").splitlines()
    shown = re.sub(r"\s*<!--.*?-->", "", text_of("README.md"), flags=re.DOTALL).splitlines()
    assert len(shown) <= MOST_LINES
    assert all(line in lines for line in INSTALL)


@pytest.mark.parametrize("readme", READMES)
def test_no_placeholder_is_left(readme: str) -> None:
    assert not re.search(r"^[A-Z]+_[A-Z]+$", text_of(readme), flags=re.MULTILINE)
