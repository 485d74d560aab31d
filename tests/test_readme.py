"""What the README shows is true: its Python runs as it stands, its files are read, its commands are there."""

from __future__ import annotations

import re
from pathlib import Path

import pytest

from seamap_rt.cli.shell import app
from seamap_rt.io.recorded import read_header
from seamap_rt.scene import load_scene

ROOT = Path(__file__).parents[1]
README = (ROOT / "README.md").read_text(encoding="utf-8")


def blocks(language: str) -> list[str]:
    """The README's blocks of code in a language, in their order."""
    found = re.findall(rf"^```{language}\n(.*?)^```$", README, flags=re.MULTILINE | re.DOTALL)
    assert found
    return found


def test_python_runs_and_what_it_writes_is_read(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    # One after the other, as a reader would: later blocks use the names of earlier ones. The sector is narrow, so that
    # it takes seconds.
    (tmp_path / "scenes").mkdir()
    text = (ROOT / "scenes" / "choppy_sea.toml").read_text(encoding="utf-8")
    narrow = text.replace("sector_deg = [0.0, 360.0]", "sector_deg = [260.0, 280.0]")
    assert narrow != text
    (tmp_path / "scenes" / "choppy_sea.toml").write_text(narrow, encoding="utf-8")
    monkeypatch.chdir(tmp_path)
    names: dict[str, object] = {}
    for block in blocks("python"):
        exec(block, names)

    recipe, header = sorted(blocks("toml"), key=lambda block: "name = " not in block)
    Path("mine.toml").write_text(recipe, encoding="utf-8")
    mine = load_scene("mine.toml")
    assert mine.sea.waves[0].spectrum == "file"
    Path("header.toml").write_text(header, encoding="utf-8")
    assert read_header("header.toml").transmit == "switched"


def test_commands_and_options_are_there() -> None:
    table = re.findall(r"^\| `seamap-rt (\w+)([^`]*)` \|", README, flags=re.MULTILINE)
    assert {name for name, _ in table} == {name for name in app if not name.startswith("-")}
    for name, usage in table:
        known = {option for argument in app[name].assemble_argument_collection() for option in argument.names}
        assert set(re.findall(r"--[a-z]+", usage)) <= known, name


def test_files_that_are_named_exist() -> None:
    named = re.findall(r"\((validation/figures/[\w.]+)\)|`(?:python )?(validation/\w+\.py|scenes/\w+\.toml)", README)
    for path in (part for parts in named for part in parts if part):
        assert (ROOT / path).is_file(), path


def test_no_placeholder_is_left() -> None:
    assert not re.search(r"^[A-Z]+_[A-Z]+$", README, flags=re.MULTILINE)
