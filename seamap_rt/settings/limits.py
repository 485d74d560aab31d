"""How a setting states its limits, its unit and its meaning.

Limits are `annotated_types` (Gt, Ge, Lt, Le), which pydantic checks and writes into the JSON schema. `Meaning` stands
last among a key's annotations: it adds description, unit and reason to the schema, and words what pydantic refuses as
this program words it: limit, then reason.

    width_m: Annotated[float, Gt(0.0), Le(20.0), Meaning("Width of the aperture.", unit="m", reason="it has one")]
"""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass, field
from typing import Any

from pydantic import GetCoreSchemaHandler, GetJsonSchemaHandler, ValidationError, ValidatorFunctionWrapHandler
from pydantic.json_schema import JsonSchemaValue
from pydantic_core import CoreSchema, core_schema

INFINITE = "inf"  # an infinite number in JSON, which has none: TOML's own word, which overrides read as a number
_WITHOUT_END = 1e9  # m, s or Hz: what is more is infinite, and products with it do not overflow
_WORDS = {
    "greater_than": ("must be greater than", "gt"),
    "greater_than_equal": ("must be at least", "ge"),
    "less_than": ("must be less than", "lt"),
    "less_than_equal": ("must be at most", "le"),
}


@dataclass(frozen=True, slots=True)
class Meaning:
    """What a key means.

    text: a sentence or two.
    unit: of a number, "1" if it has none; None for names, switches and tables.
    reason: why the limits are there; the refusal gives it in brackets.
    left_out: what holds where an optional key is not given.
    infinite: whether inf is taken, as what numbers above 1e9 stand for. In the schema it is the text "inf".
    items, pattern: what a validator of the key's own checks, of a list's entries and of a text, as JSON Schema puts it.
    """

    text: str
    unit: str | None = None
    reason: str = ""
    left_out: str = ""
    infinite: bool = False
    items: tuple[Mapping[str, float], ...] = field(default=(), hash=False)
    pattern: str = ""

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
        return {
            **stated,
            "description": self.text,
            "unit": self.unit,
            **({"pattern": self.pattern} if self.pattern else {}),
            **({"reason": self.reason} if self.reason else {}),
            **({"left_out": self.left_out} if self.left_out else {}),
        }
