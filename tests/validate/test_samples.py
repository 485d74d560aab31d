"""A sample of the long tests of files: a few damaged ones, some that declare their units, and a run that is killed."""

from __future__ import annotations

from pathlib import Path

import pytest

from validation.fuzz import declarations
from validation.fuzz.running import Plan, run
from validation.kills import KILL, commands, kills


def test_damaged_scenes_and_files_are_one_line_each(tmp_path: Path) -> None:
    told: list[str] = []
    assert run(Plan(seed=7, scenes=8, files=20), tmp_path, 1, told.append) == [], told
    assert "28 cases" in told[-1]


def test_files_mean_what_they_declare() -> None:
    told: list[str] = []
    assert declarations.run(35, 11, told.append) == [], told


@pytest.mark.slow
def test_a_killed_run_is_mended_and_done_again_to_the_same_bits(tmp_path: Path) -> None:
    (fate,) = kills([commands(tmp_path, turns=2)["run, horizon"]], 1, 11, tmp_path, (KILL,))
    assert fate.wrong == []
