"""`new`, `keys`: what a newcomer meets first."""

from __future__ import annotations

import io
from pathlib import Path
from typing import Any

import command_line
import pytest
from command_line import assert_refused
from rich.console import Console

from seamap_rt.cli import beginning
from seamap_rt.io.scenefile import read_toml
from seamap_rt.scene import load_scene
from seamap_rt.scene.keys import manual

call, elsewhere = command_line.call, command_line.elsewhere  # fixtures
pytestmark = pytest.mark.usefixtures("elsewhere")


def test_new_writes_a_scene_that_runs_and_keeps_what_is_there(call: Any) -> None:
    answer = call("new", "mine.toml", "--like", "tiny")
    assert (answer.code, answer.err) == (0, "")
    assert "seamap-rt run mine.toml" in answer.out
    assert load_scene("mine.toml").radar == load_scene("tiny").radar
    before = Path("mine.toml").read_text(encoding="utf-8")
    assert_refused(call("new", "mine.toml"), "FILE = 'mine.toml'", "--overwrite")
    assert Path("mine.toml").read_text(encoding="utf-8") == before
    assert call("new", "mine.toml", "--overwrite").code == 0
    assert load_scene("mine.toml").radar == load_scene("choppy_sea").radar
    assert call("simulate", "mine.toml", *command_line.settings(), "--out", "results").code == 0


def test_new_without_a_name_is_the_studys_radar(call: Any) -> None:
    assert call("new").code == 0
    assert read_toml("my_scene.toml")["radar"]["transmit_power_w"] == 1.0
    assert_refused(call("new", "other.toml", "--like", "solid_state_chrip"), "solid_state_chirp")


def test_keys_in_a_pipe_is_a_line_a_key_as_in_the_manual(call: Any) -> None:
    answer = call("keys", "radar.antenna")
    assert (answer.code, answer.err) == (0, "")
    head, *lines = answer.out.splitlines()
    assert head.split() == ["key", "unit", "default", "limit", "|", "meaning"]
    assert all(line.startswith("radar.antenna.") for line in lines)
    (height,) = (line for line in lines if line.startswith("radar.antenna.height_m "))
    assert height.split()[1:3] == ["m", "0.1"]
    every = call("keys").out.splitlines()
    rows = [row for row in manual().split("## Keys")[1].splitlines() if row.startswith("| `") and row.count("|") == 6]
    assert len(every) == 1 + len(rows) + 1  # the head, and which kind a wave system is
    assert "\x1b" not in answer.out


def test_keys_of_what_is_no_section_names_the_nearest(call: Any) -> None:
    assert_refused(call("keys", "rader"), 'KEY = "rader"', "did you mean radar?")
    assert_refused(call("keys", "anntena"), "did you mean radar.antenna")


def test_keys_on_a_terminal_is_a_table_as_wide_as_it(call: Any, monkeypatch: pytest.MonkeyPatch) -> None:
    shown = io.StringIO()
    monkeypatch.setattr(beginning, "console", Console(file=shown, force_terminal=True, width=100, color_system=None))
    assert call("keys", "radar").code == 0
    lines = shown.getvalue().splitlines()
    assert max(map(len, lines)) <= 100
    assert "[radar.antenna]" in shown.getvalue()
    assert "┃ key" in shown.getvalue()
