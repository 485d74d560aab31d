"""The table of planted errors: functions and judges are there, and the runner tells red from green."""

from __future__ import annotations

import importlib
from functools import reduce

import pytest

from validation.plants import PLANTS, ROOT, Plant, ask
from validation.report.discovery import cases_folder, names_in

WAVES, BOAT = "wavenumbers 2 % too large", "a boat that rolls to port"
OF = {plant.name: plant for plant in PLANTS}


@pytest.mark.parametrize("plant", PLANTS, ids=lambda plant: plant.name)
def test_each_plant_replaces_a_public_function_and_names_a_judge_that_is_there(plant: Plant) -> None:
    module, _, path = plant.at.partition(":")
    *owners, name = path.split(".")
    assert name in vars(reduce(getattr, owners, importlib.import_module(f"seamap_rt.{module}")))
    assert not any(part.startswith("_") for part in (*module.split("."), *owners, name.removeprefix("__call__")))
    file, _, test = plant.judge.partition("::")
    if file.startswith("case "):
        assert file.removeprefix("case ") in {each for path in cases_folder().glob("*.py") for each in names_in(path)}
    else:
        assert f"def {test.rpartition('::')[2]}(" in (ROOT / "tests" / file).read_text(encoding="utf-8")


def test_plants_have_names_of_their_own() -> None:
    assert len(OF) == len(PLANTS)


@pytest.mark.parametrize(
    ("planted", "judge", "word"),
    [
        (WAVES, OF[WAVES].judge, "red"),
        (BOAT, OF[BOAT].judge, "red"),
        (WAVES, OF[BOAT].judge, "GREEN"),  # that boat's axes know no waves
        (WAVES, f"{OF[WAVES].judge}_that_is_not_there", "ERROR (code 4)"),
    ],
)
def test_plants_turn_red_and_what_harms_nothing_stays_green(planted: str, judge: str, word: str) -> None:
    found, output = ask([judge], planted)
    assert found == word, output
