"""The form and the scene say the same: every key that a scene has stands in it, and goes there and back."""

from __future__ import annotations

import re
import shlex
import tomllib
from pathlib import Path
from typing import Any

import pytest
from hypothesis import given
from hypothesis import strategies as st

from seamap_rt.app.draft import Draft, list_sections, parts_of, scene_schema
from seamap_rt.app.folders import Roots
from seamap_rt.errors import InputError
from seamap_rt.io.scenefile import list_shipped
from seamap_rt.report import keys
from seamap_rt.report.keys import heeded, matters, words_of
from seamap_rt.scene import Scene, load_scene
from seamap_rt.scene.keys import key_sections

_SHIPPED = sorted(list_shipped())


@pytest.fixture
def roots(tmp_path: Path) -> Roots:
    return Roots(tmp_path, (next(iter(list_shipped().values())).parent,))


def scene_of_command(line: str) -> Scene:
    """The scene that a line of `Draft.command` runs."""
    words = shlex.split(line)
    pairs = [words[index + 1] for index, word in enumerate(words) if word == "--set"]
    return load_scene(words[2], overrides={k: v for k, _, v in (pair.partition("=") for pair in pairs)})


@pytest.mark.parametrize("name", _SHIPPED)
def test_a_shipped_scene_is_the_same_in_the_form_as_its_toml_and_by_its_command(name: str, roots: Roots) -> None:
    draft = Draft.shipped(name, roots)
    assert draft.scene == load_scene(name), draft.refused
    assert Draft.of_toml(draft.toml(), roots).scene == draft.scene
    assert draft.command() == f"seamap-rt run {name}"
    draft.set("radar.height_m", 6.5)
    draft.set("title", 'a "title", of 7')
    assert draft.scene is not None, draft.refused
    assert scene_of_command(draft.command()) == draft.scene


@pytest.mark.parametrize("name", _SHIPPED)
def test_what_a_field_shows_is_read_back_to_the_same_value(name: str, roots: Roots) -> None:
    draft = Draft.shipped(name, roots)
    assert draft.scene is not None
    for part in parts_of(draft.tree):
        for field in part.fields:
            value = draft.value(field.key)
            if field.kind in ("number", "list") and value is not None:
                again = keys.read_value(field.key, keys.shown_value(field.key, value))
                wanted = list(value) if isinstance(value, tuple) else value
                assert again == pytest.approx(wanted, rel=1e-12), field.key


def test_people_read_and_write_frequencies_in_gigahertz() -> None:
    assert keys.shown_value("radar.frequency_hz", 9.41e9) == "9.41"
    assert keys.read_value("radar.frequency_hz", "9.41") == 9.41e9
    assert keys.shown_unit("radar.frequency_hz", "Hz") == "GHz"
    assert keys.read_value("radar.pulse_width_s", "20") == 20e-9
    assert keys.read_value("sea.depth_m", "inf") == float("inf")
    assert keys.read_value("radar.range_m", "15, 150") == [15, 150]


def test_a_fields_limits_are_in_the_unit_that_it_shows(roots: Roots) -> None:
    """Both ends of a range of numbers, typed as the line of help has them, are those of the manual of all keys."""
    manual = {
        f"{section.path}.{row.name}": row.limit for section in key_sections() for row in section.rows if not row.kinds
    }
    ranged = 0
    for field in (each for part in parts_of(Draft.shipped("choppy_sea", roots).tree) for each in part.fields):
        told = manual.get(_without_numbers(field.key), "")
        ends, typed = (re.match(r"(?:.*: )?([-\d.e+]+) to ([-\d.e+]+)", text) for text in (told, field.help))
        if field.kind == "number" and ends is not None:
            assert typed is not None, field.help
            read = [keys.read_value(field.key, each) for each in typed.groups()]
            assert read == pytest.approx([float(each) for each in ends.groups()], rel=1e-9), field.help
            assert f"Limits ({field.unit}): " in field.help or not field.unit
            ranged += 1
    assert ranged > 20


def test_every_key_of_a_scene_has_a_field(roots: Roots) -> None:
    draft = Draft.shipped("choppy_sea", roots)
    for each in list_sections():
        for kind in each.kinds or ("",):
            draft.add(each.path, each.tag, kind)
    shown = {_without_numbers(field.key) for part in parts_of(draft.tree) for field in part.fields}
    assert shown == set(_keys(scene_schema(), ""))


def _keys(section: Any, path: str) -> list[str]:
    found = []
    for name, key in section["properties"].items():
        holder = key.get("items", key) if key.get("type") == "array" else key
        references = [each["$ref"] for each in holder.get("oneOf", [holder]) if "$ref" in each]
        below = f"{path}.{name}" if path else name
        if references:
            for reference in references:
                found += _keys(scene_schema()["$defs"][reference.rsplit("/", 1)[1]], below)
        elif name == "spectrum" or "const" not in key:  # one choice is none
            found.append(below)
    return found


def _without_numbers(key: str) -> str:
    return ".".join(part for part in key.split(".") if not part.isdigit())


def test_a_refusal_stands_at_its_field_in_the_words_of_the_command_line(roots: Roots) -> None:
    draft = Draft.shipped("tiny", roots)
    for key, value in (("radar.height_m", 500.0), ("radar.prf_hz", "fast"), ("sea.waves.0.peak_period_s", -1.0)):
        draft.set(key, value)
        with pytest.raises(InputError) as refused:
            load_scene("tiny", {key: value})
        assert draft.scene is None
        assert tuple(draft.refused.values()) == refused.value.problems
        assert draft.undo()
        assert draft.scene is not None


def test_several_refusals_stand_at_their_fields(roots: Roots) -> None:
    draft = Draft.shipped("tiny", roots)
    draft.set("radar.noise_figure_db", 99.0)
    draft.set("sea.depth_m", "deep")
    assert set(draft.refused) == {"radar.noise_figure_db", "sea.depth_m"}


def test_a_file_elsewhere_is_refused_at_its_field(roots: Roots) -> None:
    draft = Draft.shipped("tiny", roots)
    draft.kind("sea.waves.0", "spectrum", "file")
    draft.set("sea.waves.0.file", "/etc/passwd")
    assert "lies outside" in draft.refused["sea.waves.0.file"]


def test_changes_are_counted_and_taken_back(roots: Roots) -> None:
    draft = Draft.shipped("choppy_sea", roots)
    draft.set("radar.height_m", 8)
    draft.set("radar.baseline_m", 0.4)
    draft.set("radar.baseline_m", 0.2)  # as it was
    assert draft.changes == {"radar.height_m": 8}
    assert [draft.undo() for _ in range(4)] == [True, True, True, False]
    assert draft.changes == {}


def test_a_wave_system_of_another_kind_keeps_what_both_have_and_stands(roots: Roots) -> None:
    draft = Draft.shipped("choppy_sea", roots)
    for kind in ("tma", "pierson_moskowitz", "elfouhaily", "sinusoid", "flat", "jonswap"):
        draft.kind("sea.waves.0", "spectrum", kind)
        assert draft.refused == {}, kind
    draft.add("sea.waves", "spectrum", "jonswap")
    assert draft.command() == "seamap-rt run scene.toml"  # --set adds no system
    draft.remove("sea.waves.0")
    assert draft.scene is not None
    assert len(draft.scene.sea.waves) == 1


@pytest.mark.parametrize(
    "text", ["a = [", "x" * 2_000_000, "\xff\xfe", "a = 1\n" * 3 + "a = 2", "k" + "." * 9000 + "=1"]
)
def test_what_is_no_toml_is_refused_in_a_line(text: str, roots: Roots) -> None:
    with pytest.raises(InputError) as refused:
        Draft.of_toml(text.encode("latin-1"), roots)
    assert "\n" not in str(refused.value)


@given(
    st.recursive(
        st.none() | st.booleans() | st.integers() | st.floats() | st.text(max_size=5),
        lambda inner: st.lists(inner, max_size=3) | st.dictionaries(st.text(max_size=8), inner, max_size=3),
        max_leaves=8,
    ),
    st.sampled_from(
        ["sea", "sea.waves", "radar", "radar.range_m", "radar.antennas", "objects", "prediction.quiet", "name"]
    ),
)
def test_any_value_anywhere_is_a_scene_or_a_refusal(value: Any, key: str) -> None:
    draft = Draft.shipped("tiny", Roots(Path("/nowhere"), (next(iter(list_shipped().values())).parent,)))
    draft.set(key, value)
    assert (draft.scene is None) == bool(draft.refused)
    assert parts_of(draft.tree)


@given(st.text(max_size=30))
def test_any_text_in_a_field_is_read(text: str) -> None:
    for key in ("radar.height_m", "radar.frequency_hz", "radar.range_m"):
        found = keys.read_value(key, text)
        assert (found is None) == (not text.strip())
        assert isinstance(found, int | float | str | list | None)


def test_the_written_tree_reads_back(roots: Roots) -> None:
    draft = Draft.shipped("choppy_sea", roots)
    draft.set("radar.height_m", "wrong")
    assert draft.scene is None
    assert tomllib.loads(draft.toml()) == draft.tree


def test_what_a_keys_declaration_calls_it_stands_in_the_form_and_at_the_axes_of_a_trade(roots: Roots) -> None:
    fields = [each for part in parts_of(Draft.shipped("choppy_sea", roots).tree) for each in part.fields]
    baseline = next(field for field in fields if field.key == "radar.baseline_m")
    assert (baseline.label, words_of(baseline.key).label) == ("Baseline between the antennas", "Baseline (m)")
    assert next(field.unit for field in fields if field.key == "radar.pulse_width_s") == "ns"
    assert not any("|" in field.label + field.help for field in fields)


def test_keys_that_decide_whether_others_matter_are_choices_of_a_scene(roots: Roots) -> None:
    fields = {field.key: field for part in parts_of(Draft.shipped("choppy_sea", roots).tree) for field in part.fields}
    assert sum(bool(heeded(key)) for key in fields) > 50
    for key in fields:
        for switches, allowed in heeded(key):  # some choice leaves it out
            assert set(allowed) < {choice for switch in switches for choice in fields[switch].choices}, key


def test_a_key_that_does_not_matter_changes_no_scene_that_stands(roots: Roots) -> None:
    draft = Draft.shipped("choppy_sea", roots)
    assert not matters("radar.receiver.adc_bits", draft.value)
    draft.set("radar.receiver.chain", "digital")
    assert matters("radar.receiver.adc_bits", draft.value)
    assert not matters("radar.receiver.agc_headroom_db", draft.value)


def test_a_key_that_may_be_left_out_has_a_third_choice(roots: Roots) -> None:
    """Sea spikes are on, off, or as the polarization wants: neither is shown as the other."""
    draft = Draft.shipped("choppy_sea", roots)
    fields = {field.key: field for part in parts_of(draft.tree) for field in part.fields}
    spikes = fields["scattering.sea_spikes"]
    assert (spikes.kind, spikes.optional, set(spikes.choices)) == ("choice", True, {True, False})
    assert not any(field.optional for field in fields.values() if field.kind == "switch")
    for choice in spikes.choices:
        draft.set(spikes.key, choice)
        assert draft.scene is not None
        assert draft.scene.scattering.sea_spikes is choice
    draft.set(spikes.key, None)
    assert draft.scene is not None
    assert draft.scene.scattering.sea_spikes is None
