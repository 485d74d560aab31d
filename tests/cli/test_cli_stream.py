"""A run's line of JSON for each turn, read from its port as any program would."""

from __future__ import annotations

import json
import socket
import threading
import time
from pathlib import Path
from typing import Any

import command_line
import pytest
from command_line import settings

call, elsewhere = command_line.call, command_line.elsewhere  # fixtures
pytestmark = pytest.mark.usefixtures("elsewhere", "no_pictures")

TURNS = 4


def streamed(call: Any, *more: str) -> list[dict[str, Any]]:
    """The lines of a run of `tiny`, made smaller still."""
    with socket.create_server(("127.0.0.1", 0)) as free:
        address = free.getsockname()
    read: list[str] = []

    def follow() -> None:
        limit = time.monotonic() + 120.0
        while True:
            try:
                reader = socket.create_connection(address, timeout=300.0)
            except ConnectionRefusedError:  # the run has not begun
                assert time.monotonic() < limit
                time.sleep(0.01)
            else:
                break
        with reader, reader.makefile() as lines:
            read.extend(lines)

    reader = threading.Thread(target=follow)
    reader.start()
    stream = ("--predict", "--stream", f"tcp://127.0.0.1:{address[1]}", *more)
    answer = call("run", "tiny", *settings(), "--turns", TURNS, "--out", "run", *stream)
    reader.join()
    assert answer.code == 0, answer.err
    assert Path("run/report.html").exists()
    return [json.loads(line) for line in read]


def test_each_turn_is_a_line_in_order(call: Any) -> None:
    lines = streamed(call)
    assert [each["turn"] for each in lines] == list(range(1, TURNS + 1))
    times = [each["time_s"] for each in lines]
    assert times == pytest.approx([times[0] + number for number in range(TURNS)], abs=1e-6)  # the antenna's second
    assert {each["version"] for each in lines} == {1}


def test_signal_k_lines_are_deltas(call: Any) -> None:
    lines = streamed(call, "--stream-format", "signalk")
    assert len(lines) == TURNS
    assert all(set(each) <= {"context", "updates"} and each["updates"] for each in lines)
