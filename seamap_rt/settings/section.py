"""A section of a scene file, and what the sections share."""

from __future__ import annotations

import math
from collections.abc import Iterator
from typing import Annotated, Any, get_args

from annotated_types import Ge, Le
from pydantic import BaseModel, ConfigDict, GetJsonSchemaHandler
from pydantic.json_schema import JsonSchemaValue
from pydantic_core import CoreSchema

from ..errors import InputError
from .limits import INFINITE, Meaning


class Section(BaseModel):
    """A section of a scene file: frozen, strict about types, and closed to unknown keys."""

    model_config = ConfigDict(frozen=True, extra="forbid", strict=True, validate_default=False)

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
    return Meaning(f"{text}, clockwise from north.", unit="°", reason="a compass direction", left_out=left_out)
