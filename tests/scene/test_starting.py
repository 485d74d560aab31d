"""A scene to begin with loads to the scene that it is like, bit for bit, and explains its keys."""

from __future__ import annotations

import re
import tomllib
from pathlib import Path
from typing import Any

import pytest

from seamap_rt.errors import InputError
from seamap_rt.io.scenefile import list_shipped, read_toml
from seamap_rt.scene import load_scene
from seamap_rt.scene.keys import key_sections, keys_about
from seamap_rt.scene.starting import write_scene


@pytest.mark.parametrize("like", sorted(list_shipped()))
def test_it_is_the_scene_that_it_is_like_under_its_own_name(like: str, tmp_path: Path) -> None:
    """From another folder: its patterns and meshes are found, and are the same files."""
    pattern = load_scene(like)
    begun = load_scene(write_scene(tmp_path / "mine.toml", like))
    assert begun.name == "mine"
    assert begun.model_copy(update={"name": pattern.name}).to_toml() == pattern.to_toml()
    again = load_scene(write_scene(tmp_path / "again.toml", tmp_path / "mine.toml"))
    assert again.model_copy(update={"name": "mine"}) == begun


def lines_of(tree: dict[str, Any], above: str = "") -> set[str]:
    """The dotted keys of a tree, entries of lists without their numbers."""
    found: set[str] = set()
    for name, value in tree.items():
        tables = value if isinstance(value, list) and value and isinstance(value[0], dict) else [value]
        for table in tables:
            key = f"{above}{name}"
            found |= lines_of(table, f"{key}.") if isinstance(table, dict) else {key}
    return found


@pytest.mark.parametrize("like", ["choppy_sea", "pier", "wide_baseline"])
def test_what_the_pattern_writes_out_is_written_out_with_its_values(like: str, tmp_path: Path) -> None:
    file = write_scene(tmp_path / "mine.toml", like)
    assert lines_of(read_toml(list_shipped()[like])) <= lines_of(tomllib.loads(file.read_text(encoding="utf-8")))


def test_a_key_has_its_unit_default_and_meaning_beside_it(tmp_path: Path) -> None:
    text = write_scene(tmp_path / "mine.toml", "solid_state_chirp").read_text(encoding="utf-8")
    lines = text.splitlines()
    assert "height_m = 6.0                      # m; default 5. Mean height of the phase centres over mean sea" in text
    assert "pulse_width_s = 400e-9              # s; default 2e-08. Length of the transmitted pulse." in lines
    assert "# tilt_deg = 0.0                    # °; default 0. Tilt of the antennas, top towards the look." in lines
    assert max(map(len, lines)) <= 120
    # Every key and section of the usual sections is there, written or behind a #, once.
    for section in key_sections():
        if section.path in ("sea", "radar", "platform", "retrieval"):
            for row in section.rows:
                assert len(re.findall(rf"^(?:# )?{row.name}(?: =|  )", text, flags=re.MULTILINE)) >= 1, row.name


def test_a_default_behind_its_sign_may_be_taken_out_of_it(tmp_path: Path) -> None:
    """What is shown as the default is: with all these lines made keys the scene stays the same."""
    file = write_scene(tmp_path / "mine.toml", "tiny")
    before = load_scene(file)
    shown = re.sub(r"^# (\w+ = )", r"\1", file.read_text(encoding="utf-8"), flags=re.MULTILINE)
    assert shown.count("\nprf_hz = ") == 1
    file.write_text(shown, encoding="utf-8")
    assert load_scene(file) == before


def test_what_cannot_be_begun_is_refused(tmp_path: Path) -> None:
    kept = tmp_path / "kept.toml"
    kept.write_text("mine")
    for file, like, words in (
        (kept, "tiny", "--overwrite"),
        (tmp_path, "tiny", "is a folder"),
        (tmp_path / "none" / "mine.toml", "tiny", "no folder"),
        (tmp_path / "my scene.toml", "tiny", "names the scene"),
        (tmp_path / "mine.toml", "chopy_sea", "choppy_sea"),
    ):
        with pytest.raises(InputError, match=re.escape(words)) as caught:
            write_scene(file, like)
        assert len(caught.value.problems) == 1
    assert kept.read_text() == "mine"
    assert [path.name for path in tmp_path.iterdir()] == ["kept.toml"]
    assert load_scene(write_scene(kept, "tiny", overwrite=True)).name == "kept"


def test_a_section_is_found_by_its_path_with_those_within_it() -> None:
    assert [each.path for each in keys_about("radar.antenna")] == ["radar.antenna"]
    assert "radar.receiver" in [each.path for each in keys_about("[radar]")]
    for wrong, words in (("rader", "radar"), ("anntena", "radar.antenna"), ("pfr_hz", "radar.prf_hz")):
        with pytest.raises(InputError, match=f"did you mean {words}"):
            keys_about(wrong)


def test_a_number_keeps_its_bits(tmp_path: Path) -> None:
    """Also one that has more digits than one writes by hand."""
    scene = load_scene("tiny", {"radar.frequency_hz": 9.41e9 + 1.0 / 3.0, "radar.pulse_width_s": 2e-8 / 3.0 * 2.0})
    (tmp_path / "odd.toml").write_text(scene.to_toml(), encoding="utf-8")
    begun = load_scene(write_scene(tmp_path / "mine.toml", tmp_path / "odd.toml"))
    assert begun.radar == scene.radar
