"""Whatever opens a file refuses one that waits, never ends, swells or leads elsewhere: in one line, soon, and before it
is read."""

from __future__ import annotations

import json
import subprocess
import sys

import hostile_files
import pytest
from hostile_files import CASES, LONGEST_S, MOST_GROWTH

Told = tuple[str, str, float, float]


@pytest.fixture(scope="module")
def told(tmp_path_factory: pytest.TempPathFactory) -> dict[tuple[str, str], Told]:
    """What came of each case, all of them read by a process of their own."""
    folder = tmp_path_factory.mktemp("hostile")
    results = folder / "results"
    program = [sys.executable, hostile_files.__file__, str(folder / "files"), str(results)]
    subprocess.run(program, check=False)  # each case has its own alarm
    found: list[list] = [json.loads(line) for line in results.read_text().splitlines()]
    return {(reader, kind): tuple(rest) for reader, kind, *rest in found}  # type: ignore[misc]


@pytest.mark.parametrize("case", CASES, ids=" · ".join)
def test_it_is_refused_in_a_line_soon_and_unread(case: tuple[str, str], told: dict[tuple[str, str], Told]) -> None:
    """Two seconds of processor are a refusal's; 300 MB are less than any of the files would take."""
    raised, message, seconds, growth = told[case]
    assert raised == "InputError", message
    assert message.isprintable()
    if case[1].startswith("others'"):
        assert "save one file that holds all of it" in message
    assert seconds < LONGEST_S
    assert growth < MOST_GROWTH
