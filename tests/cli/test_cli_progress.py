"""Progress shows on a terminal, with its stage and the time left, and leaves no trace anywhere else."""

from __future__ import annotations

import os
import pty
import subprocess
import sys
import threading
from pathlib import Path
from typing import Any

import command_line
import pytest
from command_line import settings

call = command_line.call  # a fixture

SCENE = ["tiny", *settings(), "--turns", "6"]


def on_a_terminal(*arguments: str) -> str:
    """What the program shows on a terminal of its own."""
    ours, theirs = pty.openpty()
    shown: list[bytes] = []

    def read() -> None:
        try:
            while part := os.read(ours, 4096):
                shown.append(part)
        except OSError:  # the terminal has gone
            return

    reader = threading.Thread(target=read)
    reader.start()
    code = subprocess.run(
        [sys.executable, "-m", "seamap_rt.cli", *arguments],
        stdout=theirs,
        stderr=theirs,
        timeout=120,
        env=os.environ | {"TERM": "xterm"},
        check=False,
    ).returncode
    os.close(theirs)
    reader.join()
    os.close(ours)
    text = b"".join(shown).decode()
    assert code == 0, text
    return text


def test_a_terminal_sees_stage_and_time_left(tmp_path: Path) -> None:
    text = on_a_terminal("simulate", *SCENE, "--out", str(tmp_path / "results"))
    assert "\x1b[" in text  # a line that is drawn again
    assert "of 6: " in text
    assert " left" in text


def test_what_is_no_terminal_sees_none_of_it_whatever_is_forced(
    call: Any, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """Without the variable too: what an interrupted run says on a pipe is one line (`test_cli_interrupted`)."""
    monkeypatch.setenv("FORCE_COLOR", "1")
    answer = call("simulate", *SCENE, "--out", tmp_path / "results")
    assert answer.code == 0, answer.err
    assert answer.err == ""
    assert answer.out.count("\n") == 1
    assert "\x1b" not in answer.out
    assert "left" not in answer.out
