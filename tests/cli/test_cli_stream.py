"""A run's line of JSON for each turn, read from its port as any program would."""

from __future__ import annotations

import json
import socket
from pathlib import Path
from typing import Any

import pytest
from command_line import ended, settings, start

TURNS = 4


def streamed(tmp_path: Path, *more: str) -> list[dict[str, Any]]:
    """The lines of a run of `tiny`, made smaller still."""
    run = start(
        "run", "tiny", *settings(), "--turns", TURNS, "--out", tmp_path / "run", "--predict",
        "--stream", "tcp://127.0.0.1:0", *more, PYTHONUNBUFFERED="1",
    )  # fmt: skip
    assert run.stdout is not None
    said = run.stdout.readline()
    host, port = said.rsplit("/", 1)[-1].split(":")
    with socket.create_connection((host, int(port)), timeout=300.0) as reader, reader.makefile() as lines:
        read = list(lines)
    answer = ended(run)
    assert answer.code == 0, answer.err
    assert (tmp_path / "run" / "report.html").exists()
    return [json.loads(line) for line in read]


def test_each_turn_is_a_line_in_order(tmp_path: Path) -> None:
    lines = streamed(tmp_path)
    assert [each["turn"] for each in lines] == list(range(1, TURNS + 1))
    times = [each["time_s"] for each in lines]
    assert times == pytest.approx([times[0] + number for number in range(TURNS)], abs=1e-6)  # the antenna's second
    assert {each["version"] for each in lines} == {1}


def test_signal_k_lines_are_deltas(tmp_path: Path) -> None:
    lines = streamed(tmp_path, "--stream-format", "signalk")
    assert len(lines) == TURNS
    assert all(set(each) <= {"context", "updates"} and each["updates"] for each in lines)
