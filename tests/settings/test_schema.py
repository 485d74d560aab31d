"""The JSON schema of a scene states every key whole, and every limit that it states is the one that is checked."""

from __future__ import annotations

import json
import math
import re
from collections.abc import Iterator
from types import UnionType
from typing import Annotated, Any, NamedTuple, Union, get_args, get_origin

import annotated_types
import pytest
from annotated_types import Ge
from pydantic import TypeAdapter

from seamap_rt import settings
from seamap_rt.errors import InputError
from seamap_rt.io.scenefile import apply_overrides
from seamap_rt.io.validation import validate
from seamap_rt.scene import Scene
from seamap_rt.settings import Meaning, Section

UNITS = {"_m_s": "m/s", "_m": "m", "_s": "s", "_deg": "°", "_hz": "Hz", "_rpm": "1/min", "_w": "W", "_c": "°C"}
UNITS |= {"_db": "dB", "_dbi": "dBi", "_dbm": "dBm", "_dbsm": "dBsm", "_psu": "psu", "_mrad": "mrad"}
BOUNDS = {
    "exclusiveMinimum": ("must be greater than", "gt"),
    "minimum": ("must be at least", "ge"),
    "exclusiveMaximum": ("must be less than", "lt"),
    "maximum": ("must be at most", "le"),
}
NEEDED: dict[str, dict[str, Any]] = {
    "Scene": {"name": "mine"},
    "FlatWaves": {"spectrum": "flat"},
    "SinusoidWaves": {"spectrum": "sinusoid", "height_m": 1.0, "wavelength_m": 40.0},
    "PiersonMoskowitzWaves": {"spectrum": "pierson_moskowitz", "wind_speed_m_s": 8.0},
    "JonswapWaves": {"spectrum": "jonswap", "significant_wave_height_m": 1.0, "peak_period_s": 5.0},
    "TmaWaves": {"spectrum": "tma", "significant_wave_height_m": 1.0, "peak_period_s": 5.0},
    "ElfouhailyWaves": {"spectrum": "elfouhaily", "wind_speed_m_s": 8.0},
    "FileWaves": {"spectrum": "file", "file": "waves.nc"},
    "PlatformSettings": {"motion": "sinusoidal"},
    "PlacedAntenna": {"offset_m": [0.0, 0.0, 0.0]},
    "ObjectSettings": {"mesh": "buoy.stl", "position_m": [0.0, 0.0, 0.0]},
    "GaugeSettings": {"name": "wire", "east_m": 0.0, "north_m": 50.0},
}

SCHEMA = Scene.model_json_schema()
SECTIONS = ["Scene", *SCHEMA["$defs"]]


def sections(schema: dict[str, Any]) -> dict[str, dict[str, Any]]:
    """Every section by the name of its model, the outermost too."""
    return {schema.get("title", "Scene"): schema} | schema.get("$defs", {})


def kinds(key: dict[str, Any]) -> list[dict[str, Any]]:
    """What a key may be, null left out."""
    return [kind for kind in key.get("anyOf", [key]) if kind.get("type") != "null"]


def leaves(schema: dict[str, Any]) -> Iterator[tuple[str, str, dict[str, Any]]]:
    """(model, key, schema) of every key that holds no section."""
    for model, section in sections(schema).items():
        for name, key in section["properties"].items():
            if "$ref" not in key and not {"$ref", "oneOf"} & set(key.get("items", {})):
                yield model, name, key


def is_number(key: dict[str, Any]) -> bool:
    plain = [entry for kind in kinds(key) for entry in kind.get("prefixItems", [kind])]
    return any(kind.get("type") in ("number", "integer") for kind in plain)


def complaints(schema: dict[str, Any]) -> list[str]:
    """What a form could not be built from."""
    missing = []
    for model, name, key in leaves(schema):
        about = f"{model}.{name}"
        if not all("type" in kind for kind in kinds(key)):
            missing.append(f"{about}: has no type")
        if not key.get("description", "").rstrip("`").endswith("."):
            missing.append(f"{about}: has no description, a sentence")
        suffix = max((each for each in UNITS if name.endswith(each)), key=len, default="")
        unit = UNITS.get(suffix, "1") if is_number(key) else None
        if key.get("unit", "") != unit:
            missing.append(f"{about}: has the unit {key.get('unit', 'that is not given')}, and its name says {unit}")
        needed = name in sections(schema)[model].get("required", ())
        if not needed and key.get("default") is None and not key.get("left_out"):
            missing.append(f"{about}: has neither a default nor what holds where it is left out")
        if is_number(key) and bounds(key) and not key.get("reason"):
            missing.append(f"{about}: has limits without a reason")
    return missing


def bounds(key: dict[str, Any]) -> dict[str, float]:
    return {name: value for kind in kinds(key) for name, value in kind.items() if name in BOUNDS}


def model(name: str) -> type[Section]:
    return Scene if name == "Scene" else getattr(settings, name)


def keys(where: str) -> list[tuple[str, dict[str, Any]]]:
    return [(name, key) for section, name, key in leaves(SCHEMA) if section == where]


def check_alone(where: str, name: str, value: object) -> None:
    """Raise pydantic's error unless the key by itself takes the value."""
    TypeAdapter(model(where).model_fields[name].rebuild_annotation()).validate_python(value, strict=True)


def refusal(where: str, name: str, value: object) -> str:
    """The line that refuses a section with this key, else nothing."""
    try:
        validate(model(where), {**NEEDED.get(where, {}), name: value})
    except InputError as error:
        return str(error)
    return ""


# ----------------------------------------------------------------------------------------------- whole and valid


def test_every_key_of_every_section_has_type_unit_description_and_default() -> None:
    assert complaints(SCHEMA) == []
    assert len(list(leaves(SCHEMA))) > 190


def test_the_sections_are_all_there() -> None:
    names = {name for name, each in vars(settings).items() if isinstance(each, type)}
    bases = {
        "Section",
        "Meaning",
        "When",
        "SensorErrors",
        "RandomWaves",
        "SpreadWaves",
        "SpectralWaves",
        "GrowingWaves",
    }
    assert set(sections(SCHEMA)) == names - bases | {"Scene"}


class Planted(Section):
    """Keys that state too little."""

    bare_m: float = 0.0
    unitless_m: float = 0.0
    """A length."""
    wrong_m: Annotated[float, Meaning("s")] = 0.0
    """A length."""
    unset_m: Annotated[float | None, Meaning("m")] = None
    """A length."""
    unreasoned_m: Annotated[float, Ge(0.0), Meaning("m")] = 0.0
    """A length."""
    undescribed_m: Annotated[float, Ge(0.0), Meaning("m", "a length")] = 0.0
    whole_m: Annotated[float, Ge(0.0), Meaning("m", "a length")] = 0.0
    """A length."""


def test_a_key_that_states_too_little_is_reported() -> None:
    missing = complaints(Planted.model_json_schema())
    assert {line.split(":")[0].split(".")[1] for line in missing} == set(Planted.model_fields) - {"whole_m"}


def test_the_schema_is_plain_json_where_infinity_is_a_text() -> None:
    again = json.loads(json.dumps(SCHEMA, allow_nan=False))
    assert again == SCHEMA
    infinite = [
        (where, name) for where, name, key in leaves(SCHEMA) if {"const": "inf", "type": "string"} in kinds(key)
    ]
    assert set(infinite) == {
        ("SeaSettings", "depth_m"),
        ("ScatteringSettings", "decorrelation_time_s"),
        ("RetrievalSettings", "depth_m"),
        ("SensorSettings", "rate_hz"),
    }
    for where, name, key in leaves(SCHEMA):
        assert key.get("default") != "inf" or (where, name) in infinite
    # What a form gives back is read as an override is: a text that is a TOML value.
    for where, name in infinite:
        assert math.isinf(getattr(validate(model(where), apply_overrides({}, {name: "inf"})), name))


def test_a_section_in_a_section_has_no_default_of_its_own_keys() -> None:
    for where, section in sections(SCHEMA).items():
        for name, key in section["properties"].items():
            if "$ref" in key:
                assert key["default"] == {}, f"{where}.{name}"


@pytest.mark.parametrize("where", SECTIONS)
def test_a_default_is_the_settings_own_and_within_its_limits(where: str) -> None:
    for name, key in keys(where):
        field = model(where).model_fields[name]
        if key.get("default") is None:
            another = key.get("left_out", "").startswith("that of ")
            assert field.is_required() or field.default is None or another, name
            continue
        stated = math.inf if key["default"] == "inf" else key["default"]
        assert stated == (list(field.default) if isinstance(field.default, tuple) else field.default), name
        check_alone(where, name, stated)


# ------------------------------------------------------------------------------------------------------- limits


class Limit(NamedTuple):
    """A bound of a key, or of an entry of its list."""

    where: str
    name: str
    entry: int | None
    bound: str
    value: float
    whole: bool
    reason: str

    def beyond(self) -> float:
        return self._step(outward=True) if self.bound in ("minimum", "maximum") else self.value

    def within(self) -> float:
        return self.value if self.bound in ("minimum", "maximum") else self._step(outward=False)

    def _step(self, outward: bool) -> float:
        side = 1.0 if "aximum" in self.bound else -1.0
        towards = side if outward else -side
        return int(self.value + towards) if self.whole else math.nextafter(self.value, towards * math.inf)

    def written(self, number: float) -> Any:
        """The key's value with the number in its place."""
        if self.entry is None:
            return number
        entries = list(dict(keys(self.where))[self.name].get("default") or (0.0, 0.0, 0.0))
        if self.name == "sector_deg":
            entries[1] = number + 90.0
        entries[self.entry] = number
        return entries


def limits() -> Iterator[Limit]:
    for where, name, key in leaves(SCHEMA):
        for kind in kinds(key):
            for number, entry in enumerate(kind.get("prefixItems", [kind])):
                for bound in BOUNDS:
                    if bound in entry:
                        place = number if "prefixItems" in kind else None
                        reason = entry.get("reason", "") if place is not None else key["reason"]
                        whole = entry["type"] == "integer"
                        yield Limit(where, name, place, bound, entry[bound], whole, reason)


def annotated_limits(kind: Any) -> Iterator[annotated_types.BaseMetadata]:
    """The limits in a type, those of a list's entries left out."""
    if isinstance(kind, annotated_types.BaseMetadata):
        yield kind
    elif get_origin(kind) in (Annotated, Union, UnionType):
        for inner in get_args(kind):
            yield from annotated_limits(inner)


LIMITS = list(limits())


def test_limits_are_stated_as_they_are_annotated() -> None:
    stated = {(each.where, each.name, each.bound): each.value for each in LIMITS if each.entry is None}
    annotated = {
        (where, name, bound): getattr(each, attribute)
        for where in SECTIONS
        for name, field in model(where).model_fields.items()
        for each in annotated_limits(field.rebuild_annotation())
        for bound, (_, attribute) in BOUNDS.items()
        if hasattr(each, attribute)
    }
    assert stated == annotated
    assert len(LIMITS) > 250


@pytest.mark.parametrize("where", SECTIONS)
def test_a_stated_limit_is_refused_just_beyond(where: str) -> None:
    """In one line: key, value, limit, reason."""
    for limit in LIMITS:
        if limit.where != where:
            continue
        line = refusal(where, limit.name, limit.written(limit.beyond()))
        if limit.name in ("range_m", "sector_deg"):  # refused as a pair, in words of its own
            assert line.startswith(f"{limit.name} = ["), limit
            assert f"{abs(limit.value):g}" in line
            continue
        key = limit.name if limit.entry is None else f"{limit.name}.{limit.entry}"
        assert line.startswith(f"{key} = {limit.beyond()!r}: "), limit
        assert f"{BOUNDS[limit.bound][0]} {limit.value:g} ({limit.reason})" in line
        assert limit.reason, limit


@pytest.mark.parametrize("where", SECTIONS)
def test_a_stated_limit_is_taken_just_within(where: str) -> None:
    """By the key itself; a rule of its section may want more, and then names what."""
    for limit in LIMITS:
        if limit.where != where:
            continue
        value = limit.written(limit.within())
        if limit.name == "range_m" and (limit.entry == 0) == (limit.bound == "maximum"):
            continue  # near < far: this limit of the one end follows from the other end's
        check_alone(where, limit.name, value)
        assert not refusal(where, limit.name, value).startswith(f"{limit.name} = "), limit


@pytest.mark.parametrize("number", [math.nan, math.inf, -math.inf])
def test_what_is_not_finite_is_refused_unless_the_schema_names_inf(number: float) -> None:
    for where, name, key in leaves(SCHEMA):
        if not is_number(key) or ("type" in key and key["type"] in ("array", "integer")):
            continue
        line = refusal(where, name, number)
        if number == math.inf and any(kind.get("const") == "inf" for kind in kinds(key)):
            assert line == "", name
        elif kinds(key)[0]["type"] == "number":
            words = "is not a number" if math.isnan(number) else "must be"
            assert line.startswith(f"{name} = {number}: {words}"), (where, name)


def test_a_name_follows_the_pattern_that_is_stated() -> None:
    patterns = {(where, name): key["pattern"] for where, name, key in leaves(SCHEMA) if "pattern" in key}
    assert set(patterns) == {("Scene", "name"), ("GaugeSettings", "name")}
    for (where, name), pattern in patterns.items():
        longest = int(re.findall(r"1 to (\d+) letters", refusal(where, name, ""))[0])
        assert refusal(where, name, "x" * longest) == ""
        assert refusal(where, name, "x" * (longest + 1))
        for text in ("A1._+-", "", "../up", "-a", "x" * longest, "x" * (longest + 1), "a b"):
            assert (refusal(where, name, text) == "") == bool(re.search(pattern, text)), text
