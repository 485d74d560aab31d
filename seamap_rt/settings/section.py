"""A section of a scene file, and what the sections share."""

from __future__ import annotations

import math
from typing import Annotated

from annotated_types import Ge, Le
from pydantic import BaseModel, ConfigDict, GetJsonSchemaHandler
from pydantic.json_schema import JsonSchemaValue
from pydantic_core import CoreSchema

from .limits import INFINITE, Meaning


class Section(BaseModel):
    """A section of a scene file: frozen, strict about types, and closed to unknown keys."""

    model_config = ConfigDict(frozen=True, extra="forbid", strict=True, validate_default=False)

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


def as_tuple(value: object) -> object:
    """A list, as TOML gives it, as the tuple that frozen settings hold."""
    return tuple(value) if isinstance(value, list) else value


Direction = Annotated[float, Ge(-360.0), Le(360.0)]
Phase = Annotated[float, Ge(-3600.0), Le(3600.0)]


def compass(text: str, left_out: str = "") -> Meaning:
    """The meaning of a Direction."""
    return Meaning(f"{text}, clockwise from north.", unit="°", reason="a compass direction", left_out=left_out)
