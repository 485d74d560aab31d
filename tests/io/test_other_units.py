"""Values in another unit's prefix are told what they may be meant as; lists are shown as one types them."""

from __future__ import annotations

import math
from collections.abc import Sequence
from typing import Any, Literal, NamedTuple, get_origin

import numpy as np
import pytest
from annotated_types import Ge, Gt, Le, Lt

from seamap_rt.errors import InputError
from seamap_rt.io.recording_header import RecordingHeader
from seamap_rt.io.text import number_text, shown
from seamap_rt.io.validation import validate
from seamap_rt.scene import load_scene
from seamap_rt.settings import (
    AntennaSettings,
    JonswapWaves,
    Meaning,
    PlacedAntenna,
    PlatformSettings,
    PredictionSettings,
    RadarSettings,
    ReceiverSettings,
    RetrievalSettings,
    ScatteringSettings,
    SeaSettings,
    Section,
    SensorSettings,
    SinusoidWaves,
    TracingSettings,
)

# How many of a key's own unit one of the other is: written here again, by hand.
PREFIXES = {
    "Hz": [1e9, 1e6, 1e3],
    "s": [1e-3, 1e-6, 1e-9],
    "m": [1e3, 1e-2, 1e-3],
    "W": [1e3, 1e-3],
    "m/s": [1 / 3.6, 1852 / 3600],
    "1/min": [60.0],
    "°": [180.0 / math.pi],
    "1": [0.01],
}
SECTIONS = [
    *(RadarSettings, AntennaSettings, PlacedAntenna, ReceiverSettings, PlatformSettings, SensorSettings, SeaSettings),
    *(JonswapWaves, SinusoidWaves, ScatteringSettings, RetrievalSettings, PredictionSettings, TracingSettings),
]


class Bounded(NamedTuple):
    """A key of one number with limits."""

    section: type[Section]
    name: str
    unit: str
    low: float
    high: float
    default: float | None


def bounded(sections: Sequence[type[Section]] = SECTIONS) -> list[Bounded]:
    found: list[Bounded] = []
    for section in sections:
        for name, field in section.model_fields.items():
            notes: dict[type, Any] = {type(each): each for each in field.metadata}
            meaning = notes.get(Meaning)
            if meaning is None or meaning.unit is None or field.annotation not in (float, float | None):
                continue
            low = notes[Ge].ge if Ge in notes else notes[Gt].gt if Gt in notes else -math.inf
            high = notes[Le].le if Le in notes else notes[Lt].lt if Lt in notes else math.inf
            default = field.default if isinstance(field.default, float) and math.isfinite(field.default) else None
            found.append(Bounded(section, name, meaning.unit, low, high, default))
    return found


def refusal(section: type[Section], name: str, value: Any) -> str:
    with pytest.raises(InputError) as caught:
        validate(section, {name: value})
    return next(line for line in caught.value.problems if line.startswith(f"{name} ="))


def proposed(line: str) -> list[str]:
    _, _, words = line.partition("did you mean ")
    return words.split(" (")[0].removesuffix("?").split(" or ") if words else []


def decades(low: float, high: float) -> list[float]:
    """Numbers within limits, over all their decades."""
    least = max(low, 1e-9 * high if math.isfinite(high) else 1e-3)
    return [float(f"{each:.3g}") for each in np.geomspace(least * 1.01 + 1e-12, min(high, 1e12) * 0.99, 7)]


@pytest.mark.parametrize("key", bounded(), ids=lambda key: f"{key.section.__name__}.{key.name}")
def test_a_value_in_another_prefix_is_told_the_right_one(key: Bounded) -> None:
    """What is meant is among what is proposed, and the default is first."""
    meant = [each for each in decades(key.low, key.high) if key.low < each < key.high]
    looked_at = 0
    for value in [*meant, *([key.default] if key.default else [])]:
        for factor in PREFIXES.get(key.unit, []):
            written = float(f"{value / factor:.12g}")
            if key.low <= written <= key.high:
                continue
            numbers = [float(each) for each in proposed(refusal(key.section, key.name, written))]
            assert any(math.isclose(each, value, rel_tol=1e-5) for each in numbers), (value, written, numbers)
            if value == key.default:
                assert math.isclose(numbers[0], value, rel_tol=1e-5)
            assert all(key.low <= each <= key.high for each in numbers)
            looked_at += 1
    if key.unit.startswith("dB") and key.high < 100.0:
        level = 0.9 * key.high
        numbers = [float(each) for each in proposed(refusal(key.section, key.name, 10.0 ** (0.1 * level)))]
        assert any(math.isclose(each, level, rel_tol=1e-4) for each in numbers)
    if key.unit in ("Hz", "s") and key.low > 0.0 and math.isfinite(key.high):
        assert looked_at


def test_a_recordings_header_has_the_units_the_choices_and_no_tighter_limits_of_the_radars_keys() -> None:
    sections = (ScatteringSettings, AntennaSettings, RadarSettings)
    keys, held = {each.name: each for each in bounded(sections)}, bounded([RecordingHeader])
    pairs = [(each, keys[each.name]) for each in held if each.name in keys]
    assert len(pairs) == 12
    for header, key in pairs:
        assert (header.unit, header.low <= key.low, header.high >= key.high) == (key.unit, True, True), key.name
    types = {name: field.annotation for each in sections for name, field in each.model_fields.items()}
    choices = {n: f.annotation for n, f in RecordingHeader.model_fields.items() if get_origin(f.annotation) is Literal}
    assert len(shared := choices.keys() & types) == 5
    assert {name: choices[name] for name in shared} == {name: types[name] for name in shared}


def test_the_carrier_in_gigahertz() -> None:
    with pytest.raises(InputError, match=r"radar\.frequency_hz = 9\.4: .*did you mean 9\.4e9 \(Hz\)\?"):
        load_scene("tiny", {"radar.frequency_hz": 9.4})
    with pytest.raises(InputError, match=r"write 9\.4e9, in Hz"):
        load_scene("tiny", {"radar.frequency_hz": "9.4GHz"})


@pytest.mark.parametrize("wrong", [-1.0, math.nan, math.inf, True, "abc", "9.4 parsecs", "GHz", [1.0], {}])
def test_what_no_unit_mends_is_told_no_unit(wrong: Any) -> None:
    with pytest.raises(InputError) as caught:
        load_scene("tiny", {"radar.frequency_hz": wrong})
    assert "did you mean" not in str(caught.value)
    assert "write" not in str(caught.value)


@pytest.mark.parametrize("written", ["15,200", "15, 200", "[15, 200", "15 200"])
def test_a_list_is_told_as_one_types_it(written: str) -> None:
    with pytest.raises(InputError, match=r"write \[15,200\]"):
        load_scene("tiny", {"radar.range_m": written})


@pytest.mark.parametrize("value", [[15.0, 200.0], (1, 2, 3), [[1, 2], [3]], ["a", "b"]])
def test_a_list_is_shown_without_spaces(value: Any) -> None:
    assert " " not in shown(value)
    assert shown(value).startswith("[")


def test_a_list_in_kilometres() -> None:
    with pytest.raises(InputError, match=r"did you mean \[15,400\] or"):
        load_scene("tiny", {"radar.range_m": [15000.0, 400000.0]})


@pytest.mark.parametrize("value", [9.4e9, 2e-8, 15.0, 0.1, -3.5, 1e-6, 20000.0])
def test_a_number_is_written_as_one_types_it(value: float) -> None:
    text = number_text(value)
    assert float(text) == value
    assert "+" not in text
    assert "e0" not in text.replace("e-0", "e0")
