"""The manual of scene files is what the settings say today, and what it shows works."""

from __future__ import annotations

import re
import shlex
import tomllib
from pathlib import Path

from seamap_rt.io.scenefile import list_shipped
from seamap_rt.scene import Scene, load_scene
from seamap_rt.scene.keys import manual

PAGE = (Path(__file__).parents[2] / "scenes" / "README.md").read_text(encoding="utf-8")


def blocks(language: str) -> list[str]:
    return re.findall(rf"^```{language}\n(.*?)^```$", PAGE, flags=re.MULTILINE | re.DOTALL)


def test_the_page_is_up_to_date() -> None:
    assert manual() == PAGE, "run python -m seamap_rt.scene.keys > scenes/README.md"


def test_the_scene_that_it_shows_is_one(tmp_path: Path) -> None:
    (shown,) = blocks("toml")
    file = tmp_path / "mine.toml"
    file.write_text(shown, encoding="utf-8")
    assert load_scene(file).radar.height_m == tomllib.loads(shown)["radar"]["height_m"]


def test_the_overrides_that_it_shows_are_taken() -> None:
    (line,) = blocks("sh")
    words = shlex.split(line)
    assert words[:2] == ["seamap-rt", "run"]
    given = dict(word.split("=", 1) for word in words[4::2])
    assert len(given) == words.count("--set") == 3
    scene = load_scene(words[2], given)
    assert scene.radar.range_m == (15.0, 200.0)


def test_every_shipped_scene_and_every_key_has_its_row() -> None:
    rows = re.findall(r"^\| `(\w+)` \|", PAGE, flags=re.MULTILINE)
    assert set(list_shipped()) <= set(rows)
    schema = Scene.model_json_schema()
    for section in (schema, *schema["$defs"].values()):
        for name, key in section["properties"].items():
            if "$ref" not in key and not {"$ref", "oneOf"} & set(key.get("items", {})) and name != "spectrum":
                assert name in rows, name


def test_a_row_holds_key_unit_default_limit_and_meaning() -> None:
    mean = "mean height of the phase centres over the sea"
    for row in (
        f"| `height_m` | m | `5` | > 0, ≤ 1000 ({mean}) | Mean height of the phase centres over mean sea level. |",
        "| `prf_hz` | Hz | `10000` | 10 to 100000 (pulses per second) | Pulse repetition frequency. |",
        "| `frequency_hz` | Hz | `1e10` | 3e9 to 3.5e10 (range of the scattering models) | Carrier frequency. |",
    ):
        assert row in PAGE.splitlines()
    assert "| `depth_m` | m | `inf` | ≥ 0.05 or `inf` (water has a depth; inf is deep) |" in PAGE
