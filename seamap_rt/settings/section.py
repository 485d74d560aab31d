"""A section of a scene file, and how its keys state what they are.

A key is one declaration: its type, its limits (`annotated_types`, which pydantic checks and writes into the JSON
schema), its `Meaning` (unit, and the reason of its limits), its default, and below it what it is:

    width_m: Annotated[float, Gt(0.0), Le(20.0), Meaning("m", "aperture width")] = 1.0
    # and a docstring: Aperture [mm] | Width of the aperture.

Before the bar stands what people call the key, and the unit that they use, where these do not follow from its name and
its unit; what is in (round brackets) is left out where the label stands alone.

The form, the manual, `seamap-rt keys`, refusals and units are made of these.
"""

from __future__ import annotations

import math
from collections.abc import Iterator, Mapping
from dataclasses import dataclass, replace
from typing import Annotated, Any, NamedTuple, get_args

from annotated_types import Ge, Le
from pydantic import (
    BaseModel,
    ConfigDict,
    GetCoreSchemaHandler,
    GetJsonSchemaHandler,
    ValidationError,
    ValidatorFunctionWrapHandler,
)
from pydantic.fields import FieldInfo
from pydantic.json_schema import JsonSchemaValue
from pydantic_core import CoreSchema, core_schema

from ..errors import InputError

INFINITE = "inf"  # an infinite number in JSON, which has none: TOML's own word, which overrides read as a number
_WITHOUT_END = 1e9  # m, s or Hz: what is more is infinite, and products with it do not overflow
_WORDS = {
    "greater_than": ("must be greater than", "gt"),
    "greater_than_equal": ("must be at least", "ge"),
    "less_than": ("must be less than", "lt"),
    "less_than_equal": ("must be at most", "le"),
}


class When(NamedTuple):
    """What must hold for a run to heed a key: that `key`, of its section or dotted of the scene, is one of the `values`
    between blanks; of several keys between blanks one is enough."""

    key: str
    values: str


@dataclass(frozen=True, slots=True, eq=False)
class Meaning:
    """What a key's type and limits do not say.

    unit: of a number, "1" if it has none; None for names, switches and tables.
    reason: why the limits are there; the refusal gives it in brackets.
    left_out: what holds where an optional key is not given.
    infinite: whether inf is taken, as what numbers above 1e9 stand for. In the schema it is the text "inf".
    items, pattern: what a validator of the key's own checks, of a list's entries and of a text, as JSON Schema puts it.
    text: a sentence or two, of keys that share them; else they stand below the key.
    label, shown, when: as `meaning_of` finds them.
    """

    unit: str | None = None
    reason: str = ""
    left_out: str = ""
    infinite: bool = False
    items: tuple[Mapping[str, float], ...] = ()
    pattern: str = ""
    text: str = ""
    label: str = ""
    shown: str = ""
    when: tuple[When, ...] = ()

    def __get_pydantic_core_schema__(self, source: Any, handler: GetCoreSchemaHandler) -> CoreSchema:
        schema = handler(source)
        if schema["type"] == "nullable":
            return {**schema, "schema": self._worded(schema["schema"])}
        return self._worded(schema)

    def _worded(self, schema: CoreSchema) -> CoreSchema:
        if schema["type"] == "int":
            return core_schema.no_info_wrap_validator_function(self._check, schema)
        if schema["type"] == "float":
            schema = {**schema, "allow_inf_nan": self.infinite}
            return core_schema.no_info_wrap_validator_function(self._check_number, schema)
        return schema

    def _check_number(self, value: Any, check: ValidatorFunctionWrapHandler) -> Any:
        if isinstance(value, float) and math.isnan(value):  # which no comparison refuses
            raise ValueError("is not a number; give a finite value")
        checked = self._check(value, check)
        return math.inf if self.infinite and checked > _WITHOUT_END else checked

    def _check(self, value: Any, check: ValidatorFunctionWrapHandler) -> Any:
        try:
            return check(value)
        except ValidationError as refusal:
            (error,) = refusal.errors(include_url=False)
            if error["type"] == "finite_number":
                raise ValueError("must be finite") from None
            if error["type"] not in _WORDS:
                raise
        words, name = _WORDS[error["type"]]
        limit = error.get("ctx", {})[name]
        raise ValueError(f"{words} {limit:g}" + (f" ({self.reason})" if self.reason else ""))

    def __get_pydantic_json_schema__(self, schema: CoreSchema, handler: GetJsonSchemaHandler) -> JsonSchemaValue:
        stated = handler(schema)
        for entry, bounds in zip(stated.get("prefixItems", ()), self.items, strict=False):
            entry.update(bounds)
        if self.infinite:
            stated = {"anyOf": [*stated.get("anyOf", [stated]), {"const": INFINITE, "type": "string"}]}
        said = {"description": self.text, "pattern": self.pattern, "reason": self.reason, "left_out": self.left_out}
        return {**stated, "unit": self.unit, **{name: words for name, words in said.items() if words}}


def meaning_of(field: FieldInfo) -> Meaning:
    """Of a key, with what its docstring says: label, shown unit, and its sentences on one line."""
    meaning = next((each for each in field.metadata if isinstance(each, Meaning)), Meaning())
    named, _, text = " ".join((meaning.text or field.description or "").split()).rpartition(" | ")
    label, _, shown = named.partition("[")
    when = tuple(each for each in field.metadata if isinstance(each, When))
    return replace(meaning, text=text, label=label.strip(), shown=shown.rstrip("]"), when=when)


class Section(BaseModel):
    """A section of a scene file: frozen, strict about types, and closed to unknown keys."""

    model_config = ConfigDict(
        frozen=True, extra="forbid", strict=True, validate_default=False, use_attribute_docstrings=True
    )

    def __setattr__(self, name: str, value: Any) -> None:
        """InputError: what has been checked together stays so."""
        key = f"{_path(type(self))}{name}"
        raise InputError(
            f"{key}: settings are not changed in place; make a scene of others by load_scene(…, overrides={{{key!r}: "
            f"{value!r}}})"
        )

    def __delattr__(self, name: str) -> None:
        self.__setattr__(name, None)

    def __repr_args__(self) -> Iterator[tuple[str | None, Any]]:
        """The keys that are not left at their defaults."""
        for name, field in type(self).model_fields.items():
            value = getattr(self, name, field.default)
            if value != field.default:
                yield name, value

    @classmethod
    def __get_pydantic_json_schema__(cls, schema: CoreSchema, handler: GetJsonSchemaHandler) -> JsonSchemaValue:
        """Plain JSON: no infinite default, and none for a section in a section, whose keys have their own."""
        stated = handler(schema)
        body = handler.resolve_ref_schema(stated)
        body.pop("title", None)
        for name, field in cls.model_fields.items():
            key = body["properties"][name]
            key.pop("title", None)
            key.setdefault("unit", None)
            if text := meaning_of(field).text:
                key["description"] = text
            if isinstance(field.default, BaseModel):
                key["default"] = {}
            elif isinstance(field.default, float) and math.isinf(field.default):
                key["default"] = INFINITE
        return stated


def _path(section: type[BaseModel]) -> str:
    """Where a section stands in a scene, as "radar.antenna."; of a list the first entry. Empty for the scene itself."""
    for holder in _subclasses(Section):
        for name, field in holder.model_fields.items():
            kinds = list(_kinds(field.annotation))
            if section in kinds:
                return f"{_path(holder)}{name}." + ("0." if len(kinds) > 1 or kinds[0] is not field.annotation else "")
    return ""


def _subclasses(section: type[BaseModel]) -> Iterator[type[BaseModel]]:
    for each in section.__subclasses__():
        yield each
        yield from _subclasses(each)


def _kinds(annotation: Any) -> Iterator[Any]:
    """The classes that an annotation names."""
    parts = get_args(annotation)
    yield from (kind for part in parts for kind in _kinds(part)) if parts else (annotation,)


def as_tuple(value: object) -> object:
    """A list, as TOML gives it, as the tuple that frozen settings hold."""
    return tuple(value) if isinstance(value, list) else value


Direction = Annotated[float, Ge(-360.0), Le(360.0)]
Phase = Annotated[float, Ge(-3600.0), Le(3600.0)]


def compass(text: str, left_out: str = "") -> Meaning:
    """The meaning of a Direction."""
    return Meaning("°", "a compass direction", left_out=left_out, text=f"{text}, clockwise from north.")
