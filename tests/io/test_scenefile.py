"""TOML ↔ settings: what is written reads back to the same bits, and what is wrong is refused in one line."""

from __future__ import annotations

import math
import pickle
import struct
import tomllib
from pathlib import Path
from typing import Any, Literal

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from seamap_rt.errors import InputError
from seamap_rt.io.scenefile import apply_overrides, find_scene, list_shipped, read_toml, tree_to_toml
from seamap_rt.io.validation import validate
from seamap_rt.settings import (
    JonswapWaves,
    RadarSettings,
    RetrievalSettings,
    SeaSettings,
    Section,
    SinusoidWaves,
    TracingSettings,
)


class Sample(Section):
    """Plain types without limits, to test the writer alone."""

    number: float = 0.0
    whole: int = 0
    text: str = ""
    yes: bool = False
    pair: tuple[float, ...] = ()
    absent: float | None = None
    only: Literal["this"] = "this"


class Outer(Section):
    """Two sections, for overrides and for keys looked for in the wrong one."""

    sea: SeaSettings = SeaSettings()
    radar: RadarSettings = RadarSettings()


JONSWAP = {"spectrum": "jonswap", "significant_wave_height_m": 1.4, "peak_period_s": 5.5}
SINUSOID = {"spectrum": "sinusoid", "height_m": 1.0, "wavelength_m": 40.0}


def refusal(model: type[Section], tree: dict[str, Any]) -> str:
    with pytest.raises(InputError) as caught:
        validate(model, tree)
    return one_line(caught.value)


def one_line(error: InputError) -> str:
    line = str(error)
    assert line.isprintable(), line
    assert "pydantic" not in line
    assert "Input should" not in line
    return line


def all_lines(error: InputError) -> None:
    assert str(error).splitlines() == list(error.problems)
    assert all(one_line(InputError(line)) == line for line in error.problems)


def bits(value: float) -> bytes:
    return struct.pack("<d", value)


def read_back(tmp_path: Path, model: Section) -> Any:
    file = tmp_path / "model.toml"
    file.write_text(tree_to_toml(model.model_dump()), encoding="utf-8")
    return validate(type(model), read_toml(file))


# --------------------------------------------------------------------------------------------------- writing


@given(
    number=st.floats(allow_nan=False),
    whole=st.integers(-(2**63), 2**63 - 1),
    text=st.text(st.characters(exclude_categories=["Cs"])),
    yes=st.booleans(),
    pair=st.lists(st.floats(allow_nan=False), max_size=3),
    absent=st.none() | st.floats(allow_nan=False),
)
def test_any_value_reads_back_to_the_same_bits(
    tmp_path_factory: pytest.TempPathFactory,
    number: float,
    whole: int,
    text: str,
    yes: bool,
    pair: list[float],
    absent: float | None,
) -> None:
    model = Sample(number=number, whole=whole, text=text, yes=yes, pair=tuple(pair), absent=absent)
    folder = tmp_path_factory.getbasetemp()
    # `tuple` is read by settings from a list with a validator of its own, which Sample does without.
    file = folder / "sample.toml"
    file.write_text(tree_to_toml(model.model_dump()), encoding="utf-8")
    tree = read_toml(file)
    again = Sample(**{**tree, "pair": tuple(tree["pair"])})
    assert again == model
    assert bits(again.number) == bits(number)
    assert [bits(value) for value in again.pair] == [bits(value) for value in pair]
    assert ("absent" in tree) == (absent is not None)


@given(st.floats(1e-6, 1e5), st.floats(0.3, 40.0), st.floats(-360.0, 360.0))
def test_floats_of_a_wave_keep_their_bits(wavelength: float, period: float, direction: float) -> None:
    sea = SeaSettings(
        waves=(
            SinusoidWaves(spectrum="sinusoid", height_m=0.0, wavelength_m=wavelength, wave_from_deg=direction),
            JonswapWaves(spectrum="jonswap", significant_wave_height_m=1.0, peak_period_s=period),
        )
    )
    again = validate(SeaSettings, tomllib.loads(tree_to_toml(sea.model_dump())))
    assert again == sea
    first, second = again.waves
    assert isinstance(first, SinusoidWaves)
    assert isinstance(second, JonswapWaves)
    assert second.peak_period_s is not None
    assert (bits(first.wavelength_m), bits(first.wave_from_deg)) == (bits(wavelength), bits(direction))
    assert bits(second.peak_period_s) == bits(period)


def test_sections_of_every_kind_read_back(tmp_path: Path) -> None:
    for model in (
        SeaSettings(),  # no waves, infinite depth
        SeaSettings(depth_m=8.0, waves=(SinusoidWaves.model_validate(SINUSOID),)),
        RadarSettings(height_m=0.1 + 0.2, range_m=(1.0 / 3.0, 150.0)),
        TracingSettings(),
        RetrievalSettings(),
    ):
        assert read_back(tmp_path, model) == model


def test_toml_has_one_key_per_line_and_tables_for_waves() -> None:
    text = tree_to_toml(Outer(sea=SeaSettings(waves=(JonswapWaves.model_validate(JONSWAP),) * 2)).model_dump())
    assert text.count("[[sea.waves]]\n") == 2
    assert "depth_m = inf\n" in text
    assert "range_m = [15.0, 400.0]\n" in text
    assert "\n[radar.antenna]\n" in text
    assert "gain_dbi" not in text  # None: left out
    assert all(line == "" or line[0] == "[" or line.count(" = ") == 1 for line in text.splitlines())


def test_numpy_numbers_are_written_as_plain_ones() -> None:
    # Sweeps make their values with numpy, whose repr is not TOML.
    text = tree_to_toml(Sample.model_construct(number=np.float64(0.1), pair=(np.float64(0.5),)).model_dump())
    assert "number = 0.1\n" in text
    assert "pair = [0.5]\n" in text


# --------------------------------------------------------------------------------------------------- reading


def test_a_file_that_cannot_be_read_is_one_line(tmp_path: Path) -> None:
    cases: list[tuple[str, bytes | None, str]] = [
        ("none.toml", None, "no such file"),
        ("broken.toml", b"[radar\nheight_m = 5", "is not TOML"),
        ("twice.toml", b"seed = 1\nseed = 2", "is not TOML"),
        ("long.toml", b"seed = " + b"9" * 5000, "is not TOML"),
        ("deep.toml", b"seed = " + b"[" * 100_000, "nested too deeply"),
        ("latin.toml", 'title = "Gewässer"'.encode("latin-1"), "is not UTF-8"),
        ("utf16.toml", 'title = "a"'.encode("utf-16"), "is text in UTF-16; save it as UTF-8"),
    ]
    for name, data, words in cases:
        file = tmp_path / name
        if data is not None:
            file.write_bytes(data)
        with pytest.raises(InputError, match=words) as caught:
            read_toml(file)
        assert name in one_line(caught.value)
    with pytest.raises(InputError, match="is a folder"):
        read_toml(tmp_path)
    with pytest.raises(InputError, match="is not a path"):
        read_toml("a\0b")
    with pytest.raises(InputError, match="cannot be read"):
        read_toml("a" * 5000)


def test_a_byte_order_mark_is_no_obstacle(tmp_path: Path) -> None:
    file = tmp_path / "marked.toml"
    file.write_bytes(b"\xef\xbb\xbfseed = 3\r\n")
    assert read_toml(file) == {"seed": 3}


def test_an_input_error_is_one_line_and_survives_a_process_border() -> None:
    error = InputError("a\nb\r\n  c\u2028d")
    assert str(error) == "a b c d"
    assert str(pickle.loads(pickle.dumps(error))) == "a b c d"


# ------------------------------------------------------------------------------------------------- overrides


def test_overrides_reach_defaults_lists_and_whole_tables() -> None:
    tree = {"sea": {"waves": [dict(JONSWAP)]}}
    changed = apply_overrides(
        tree,
        {
            "radar.height_m": 10,
            "radar.antenna.width_m": "2.5",
            "radar.range_m": "[15, 150]",
            "radar.range_m.1": "200.0",
            "radar.transmit": "single",
            "radar.noise": "false",
            "sea.depth_m": "inf",
            "sea.waves.0.peak_period_s": "6",
            "sea.waves.0.spectrum": "pierson_moskowitz",
        },
    )
    assert tree == {"sea": {"waves": [JONSWAP]}}  # untouched
    model = validate(Outer, changed)
    assert model.radar.height_m == 10.0
    assert model.radar.antenna.width_m == 2.5
    assert model.radar.range_m == (15.0, 200.0)
    assert model.radar.transmit == "single"
    assert model.radar.noise is False
    assert model.sea.depth_m == math.inf
    assert model.sea.waves[0].spectrum == "pierson_moskowitz"
    assert tree_to_toml(model.model_dump()).count("peak_period_s = 6.0\n") == 1


def test_overrides_from_python_may_be_numpy_tuples_or_none() -> None:
    tree = {"sea": {"waves": [dict(JONSWAP)]}}
    changes = {
        "radar.height_m": np.float32(2.5),
        "radar.sector_deg": np.array([0.0, 90.0]),
        "radar.range_m": (np.int64(15), 150.0),
        "sea.waves.0.significant_wave_height_m": None,
        "sea.waves.0.peak_period_s": None,
        "sea.waves.0.wind_speed_m_s": np.arange(3)[2],
        "sea.waves.0.fetch_m": 1e5,
    }
    model = validate(Outer, apply_overrides(tree, changes))
    assert (model.radar.height_m, model.radar.sector_deg, model.radar.range_m) == (
        2.5,
        (0.0, 90.0),
        (15.0, 150.0),
    )
    waves = model.sea.waves[0]
    assert isinstance(waves, JonswapWaves)
    assert (waves.wind_speed_m_s, waves.peak_period_s) == (2.0, None)


@pytest.mark.parametrize(
    ("text", "value"),
    [
        ("5", 5),
        ("-2e-3", -2e-3),
        ("true", True),
        ("VV", "VV"),
        ('"5"', "5"),
        ("a = b", "a = b"),
        ("", ""),
        ("1\nother = 2", "1\nother = 2"),
        ("1\n[table]", "1\n[table]"),
    ],
)
def test_a_string_is_a_toml_value_or_itself(text: str, value: object) -> None:
    assert apply_overrides({}, {"key": text}) == {"key": value}


@pytest.mark.parametrize(
    ("key", "words"),
    [
        ("sea.waves.3.peak_period_s", ["no entry 3", "sea.waves has one entry"]),
        ("sea.waves." + "9" * 5000, ["sea.waves has one entry"]),
        ("sea.waves.first.peak_period_s", ["sea.waves is a list", "sea.waves.0"]),
        ("sea.waves.-1.peak_period_s", ["sea.waves is a list"]),
        ("radar.range_m.2", ["no entry 2", "entries 0 to 1"]),
        ("radar.sector_deg.0", ["no entry 0", "radar.sector_deg is not a list in the scene file"]),
        ("radar.height_m.deep.deeper", ["radar.height_m = 5.0 has no keys below it"]),
        ("radar..height_m", ["is not a key", "radar.height_m"]),
        ("radar. height_m", ["is not a key"]),
        ("", ["is not a key"]),
    ],
)
def test_an_override_that_leads_nowhere_is_one_line(key: str, words: list[str]) -> None:
    tree = {"sea": {"waves": [dict(JONSWAP)]}, "radar": {"height_m": 5.0, "range_m": [15.0, 400.0]}}
    with pytest.raises(InputError) as caught:
        apply_overrides(tree, {key: 1.0})
    line = one_line(caught.value)
    for word in words:
        assert word in line


# ------------------------------------------------------------------------------------------------ validation


def test_a_choice_of_one_is_called_so() -> None:
    line = refusal(Sample, {"only": "that"})
    assert line.startswith('only = "that": must be "this"')
    assert "the only choice so far" in line


def test_whole_numbers_and_texts_are_named_in_plain_words() -> None:
    line = refusal(TracingSettings, {"columns_per_beam": 4.0})
    assert line == "columns_per_beam = 4.0: must be a whole number; write 4"
    assert refusal(Sample, {"text": 5}) == 'text = 5: must be text in quotes; write "5"'


def test_all_errors_are_told_unknown_keys_first_a_line_each() -> None:
    tree = {"sea": {"depth_m": -1.0}, "radar": {"height_m": "five", "losses_db": -1.0, "hight_m": 3.0}}
    with pytest.raises(InputError) as caught:
        validate(Outer, tree)
    keys = [line.split(" = ")[0] for line in caught.value.problems]
    assert keys == ["radar.hight_m", "sea.depth_m", "radar.losses_db", "radar.height_m"]
    assert str(caught.value).splitlines() == list(caught.value.problems)
    assert pickle.loads(pickle.dumps(caught.value)).problems == caught.value.problems


def test_overrides_that_cannot_be_set_are_all_told() -> None:
    with pytest.raises(InputError) as caught:
        apply_overrides({"sea": {"waves": []}}, {"sea..depth_m": 1, "sea.waves.0.height_m": 2, "seed": 3})
    first, second = caught.value.problems
    assert "is not a key" in first
    assert "no entry" in second


def test_a_long_value_is_cut() -> None:
    line = refusal(Outer, {"radar": {"height_m": "x" * 10_000}})
    assert line.startswith('radar.height_m = "xxx')
    assert len(line) < 120


junk = st.recursive(
    st.none() | st.booleans() | st.integers() | st.floats() | st.text(max_size=5),
    lambda inner: st.lists(inner, max_size=3) | st.dictionaries(st.text(max_size=5), inner, max_size=3),
    max_leaves=6,
)


@given(
    key=st.sampled_from(["sea", "radar", "sea.waves", "sea.waves.0", "radar.range_m", "radar.antenna", "sea.depth_m"])
    | st.sampled_from(["radar.noise", "radar.transmit", "sea.waves.0.spectrum", "sea.waves.0.peak_period_s"]),
    value=junk,
)
def test_no_tree_gives_anything_but_a_model_or_one_line(key: str, value: object) -> None:
    try:
        tree = apply_overrides({"sea": {"waves": [dict(JONSWAP)]}}, {key: value})
        model = validate(Outer, tree)
    except InputError as error:
        all_lines(error)
    else:
        assert isinstance(model, Outer)


# -------------------------------------------------------------------------------------------- shipped scenes


def test_a_scene_is_found_by_name_or_path(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    shipped = list_shipped()
    assert "choppy_sea" in shipped
    assert "tiny" in shipped
    assert find_scene("choppy_sea") == shipped["choppy_sea"]
    assert shipped["choppy_sea"].is_file()
    monkeypatch.chdir(tmp_path)
    (tmp_path / "choppy_sea").mkdir()  # a folder of results does not hide the shipped scene
    assert find_scene("choppy_sea") == shipped["choppy_sea"]
    (tmp_path / "mine.toml").write_text("seed = 1")
    assert find_scene("mine.toml") == Path("mine.toml")
    assert find_scene(tmp_path / "mine.toml") == tmp_path / "mine.toml"


@pytest.mark.parametrize(
    ("name", "words"),
    [
        ("chopy_sea", "did you mean the shipped choppy_sea?"),
        ("elsewhere/tiny.toml", "did you mean the shipped tiny?"),
        ("qqqq", "shipped are calm, choppy_sea, "),
        ("a\0b", "neither a file nor the name of a shipped scene"),
        ("", "neither a file nor the name of a shipped scene"),
    ],
)
def test_an_unknown_scene_names_the_nearest_shipped_ones(name: str, words: str) -> None:
    with pytest.raises(InputError) as caught:
        find_scene(name)
    assert words in one_line(caught.value)
