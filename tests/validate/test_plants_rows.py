"""The table of planted errors: every row can be planted, and the runner tells red from green."""

from __future__ import annotations

from pathlib import Path

from validation.plants.plant import CASE, ROOT, Plant, fault_of
from validation.plants.rows import PLANTS
from validation.plants.running import Tree, planted

CHEAP = "the Earth's radius", "a shadow edge's blur"


def test_every_row_can_be_planted() -> None:
    assert [f"{plant.name}: {fault_of(plant)}" for plant in PLANTS if fault_of(plant)] == []
    assert len({plant.name for plant in PLANTS}) == len(PLANTS) >= 60
    for plant in PLANTS:
        if not plant.judge.startswith(CASE):
            file, *_, name = plant.judge.split("::")
            assert f"def {name}(" in (ROOT / file).read_text(encoding="utf-8"), plant.judge


def test_plants_turn_red_and_what_harms_nothing_stays_green(tmp_path: Path) -> None:
    sown = [plant for plant in PLANTS if plant.name in CHEAP]
    harmless = sown[0]._replace(old='"""How straight', new='"""How very straight')
    unheard = sown[0]._replace(judge=f"{sown[0].judge}_that_is_not_there")
    twice = Plant("twice", sown[0].file, "def ", "def  ", sown[0].judge)
    tree = Tree(tmp_path, libraries=False)
    try:
        before = (tree.root / sown[0].file).read_bytes()
        seen = [planted(plant, tree) for plant in (*sown, harmless, unheard, twice)]
        assert (tree.root / sown[0].file).read_bytes() == before
    finally:
        tree.close()
    assert [verdict.right for verdict in seen] == [True, True, False, False, False]
    assert [verdict.word for verdict in seen[:4]] == ["red", "red", "GREEN", "ERROR (code 4)"]
