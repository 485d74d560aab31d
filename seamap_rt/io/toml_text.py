"""How keys and values are written in TOML, and shown in a refusal."""

from __future__ import annotations

import re
from typing import Any

LONGEST_VALUE = 60  # characters of a refused value that are shown


def key_text(name: str) -> str:
    return name if re.fullmatch(r"[A-Za-z0-9_-]+", name) else quoted(name)


def toml_value(value: Any) -> str:
    if isinstance(value, bool):
        return "true" if value else "false"
    if isinstance(value, int):
        return int.__repr__(value)
    if isinstance(value, float):
        return float.__repr__(value)  # the shortest digits that read back to the same bits; inf is TOML's too
    if isinstance(value, str):
        return quoted(value)
    if isinstance(value, list | tuple):
        return "[" + ", ".join(toml_value(entry) for entry in value) + "]"
    raise TypeError(f"{type(value).__name__} has no form in a scene file")


def quoted(text: str) -> str:
    """A TOML basic string; characters that would break the line or not print are escaped."""
    return '"' + "".join(_escaped(letter) for letter in text) + '"'


def _escaped(letter: str) -> str:
    if letter in '"\\':
        return f"\\{letter}"
    if letter.isprintable():
        return letter
    return f"\\u{ord(letter):04x}" if ord(letter) <= 0xFFFF else f"\\U{ord(letter):08x}"


def shown(value: Any) -> str:
    """A value as a refusal shows it: a list as one types it for --set, where a shell takes a space for its end."""
    try:
        text = _without_spaces(value) if isinstance(value, list | tuple) else toml_value(value)
    except TypeError:
        text = str(value)
    return text if len(text) <= LONGEST_VALUE else text[: LONGEST_VALUE - 1] + "…"


def number_text(value: float) -> str:
    """A number as one types it: 9.4e9, 2e-8, 15."""
    mantissa, exponent, power = f"{value:.6g}".partition("e")
    return f"{mantissa}e{int(power)}" if exponent else mantissa


def _without_spaces(values: list[Any] | tuple[Any, ...]) -> str:
    entries = (_without_spaces(each) if isinstance(each, list | tuple) else toml_value(each) for each in values)
    return f"[{','.join(entries)}]"
