"""Progress shows on a terminal, with its stage and the time left, and leaves no trace anywhere else."""

from __future__ import annotations

import os
import pty
import subprocess
import sys
import threading
from pathlib import Path

from command_line import ended, settings, start

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


def test_a_pipe_sees_none_of_it_whatever_is_forced(tmp_path: Path) -> None:
    """Without the variable too: what an interrupted run says on a pipe is one line (`test_cli_interrupted`)."""
    answer = ended(start("simulate", *SCENE, "--out", str(tmp_path / "results"), FORCE_COLOR="1"))
    assert answer.code == 0, answer.err
    assert answer.err == ""
    assert answer.out.count("\n") == 1
    assert "\x1b" not in answer.out
    assert "left" not in answer.out
