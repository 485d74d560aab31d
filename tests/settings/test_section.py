"""What all sections of a scene share: limits of their own, a short form, and a remedy where one is set in place."""

from __future__ import annotations

import copy
import pickle
from collections import defaultdict
from typing import Any

import pytest

from seamap_rt.errors import InputError
from seamap_rt.io.scenefile import list_shipped
from seamap_rt.scene import Scene, load_scene
from seamap_rt.settings import Section


def sections(value: Any, path: str = "") -> list[tuple[str, Section]]:
    """Each section of a scene with its path as in overrides."""
    found = [(path, value)] if isinstance(value, Section) else []
    if isinstance(value, Section):
        for name in type(value).model_fields:
            found += sections(getattr(value, name), f"{path}{name}.")
    elif isinstance(value, tuple):
        for number, each in enumerate(value):
            found += sections(each, f"{path}{number}.")
    return found


def test_keys_that_share_limits_for_one_reason_share_the_unit() -> None:
    """A length that has the limits of angles has them by accident."""
    stated = Scene.model_json_schema()
    units: dict[Any, set[str]] = defaultdict(set)
    for section in [stated, *stated["$defs"].values()]:
        for key in section.get("properties", {}).values():
            limits = [key.get(each) for each in ("minimum", "exclusiveMinimum", "maximum", "exclusiveMaximum")]
            if key.get("unit") and key.get("reason") and any(each is not None for each in limits):
                units[key["reason"], *limits].add(key["unit"])
    assert len(units) > 40
    assert not {key: each for key, each in units.items() if len(each) > 1}


@pytest.mark.parametrize("name", list_shipped())
def test_a_scenes_short_form_is_short(name: str) -> None:
    scene = load_scene(name)
    for text in (repr(scene), str(scene)):
        lines = text.splitlines()
        assert len(lines) <= 12
        assert max(map(len, lines)) <= 120
        assert name in lines[0]
        assert f"height {scene.radar.height_m:g} m" in text
        assert f"cell range {scene.retrieval.cell_range_m:g} m" in text
        assert all(str(each.spectrum) in text for each in scene.sea.waves)


@pytest.mark.parametrize("name", ["wind_and_swell", "harbour", "pier"])
def test_a_sections_short_form_has_what_is_set(name: str) -> None:
    for _, section in sections(load_scene(name))[1:]:
        fields = type(section).model_fields
        shown = dict(section.__repr_args__())
        assert shown == {key: getattr(section, key) for key in fields if getattr(section, key) != fields[key].default}
        assert repr(section).startswith(f"{type(section).__name__}(")
        assert all(f"{key}=" in repr(section) for key in shown)


@pytest.mark.parametrize("name", ["wind_and_swell", "harbour", "pier"])
def test_what_is_set_in_place_is_told_how_to_override_it(name: str) -> None:
    scene = load_scene(name)
    for path, section in sections(scene):
        for key in type(section).model_fields:
            before = getattr(section, key)
            with pytest.raises(InputError) as caught:
                setattr(section, key, before)
            (line,) = caught.value.problems
            dotted = ".".join("0" if step.isdecimal() else step for step in f"{path}{key}".split("."))
            assert line.startswith(f"{dotted}: settings are not changed in place")
            assert f"load_scene(…, overrides={{'{dotted}': " in line
            assert "pydantic" not in line
            with pytest.raises(InputError, match="not changed in place"):
                delattr(section, key)
            assert getattr(section, key) is before


def test_a_scene_is_copied_and_sent_as_before() -> None:
    scene = load_scene("wind_and_swell")
    assert pickle.loads(pickle.dumps(scene)) == scene
    assert copy.deepcopy(scene) == scene
    assert scene.model_copy(update={"seed": 2}).seed == 2
