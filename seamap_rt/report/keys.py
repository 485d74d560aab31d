"""What people call the keys of a scene: labels and units with their factors; and which keys a run heeds."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from decimal import Decimal, InvalidOperation
from functools import cache
from typing import Any, NamedTuple, get_args

from pydantic import BaseModel

from ..io.text import parse_number
from ..scene import Scene
from ..settings import Meaning, meaning_of

_ENDINGS = ("_m_s", "_dbsm", "_dbm", "_dbi", "_deg", "_rpm", "_psu", "_hz", "_db", "_m", "_s", "_w", "_c")

_PREFIXES = {"": 0, "G": 9, "M": 6, "k": 3, "m": -3, "n": -9}  # of a shown unit before the key's own


class KeyWords(NamedTuple):
    """name: lower case; unit: empty where there is none; meaning: a sentence, empty where the schema has none."""

    name: str
    unit: str
    meaning: str

    @property
    def label(self) -> str:
        """The label of an axis, or of the head of a column."""
        return f"{self.name[0].upper()}{self.name[1:]}" + (f" ({self.unit})" if self.unit else "")

    def value(self, value: Any) -> str:
        """A value with its unit."""
        text = f"{value:g}" if _is_number(value) else str(value)
        return f"{text} {self.unit}" if self.unit and _is_number(value) else text


def _is_number(value: Any) -> bool:
    return isinstance(value, int | float) and not isinstance(value, bool)


def words_of(key: str) -> KeyWords:
    """Words for any key of a scene, as `radar.height_m` or `sea.waves.0.hs_m`."""
    meaning, label = _meaning(key), label_of(key, alone=True)
    unit = meaning.unit if meaning.unit and meaning.unit != "1" else ""
    return KeyWords(label[:1].lower() + label[1:], unit, meaning.text)


def label_of(key: str, alone: bool = False) -> str:
    """Of a key, as "radar.height_m" or "sea.waves.0.peak_period_s": words without unit. alone: not under its section's
    title."""
    if label := _meaning(key).label:
        return label.split(" (")[0] if alone else label.replace("(", "").replace(")", "")
    *sections, leaf = (part for part in key.split(".") if not part.isdigit())
    ending = next((each for each in _ENDINGS if leaf.endswith(each)), "")
    words = " ".join([*(sections[-1:] if alone else ()), leaf.removesuffix(ending)]).replace("_", " ")
    return words[:1].upper() + words[1:]


def section_label(path: str) -> str:
    """The label of a section, as "Waves 2" of "sea.waves.1"."""
    number = path.rsplit(".", 1)[-1]
    return (label_of(path) if path else "Run") + (f" {int(number) + 1}" if number.isdigit() else "")


def shown_unit(key: str, unit: str | None) -> str:
    """The unit in which a key is shown; empty for a plain number or a name."""
    return _meaning(key).shown or (unit if unit and unit != "1" else "")


def shown_value(key: str, value: Any) -> str:
    """A value as it stands in a field: without unit, in the shown one."""
    if value is None:
        return ""
    if isinstance(value, bool):
        return "true" if value else "false"
    if isinstance(value, list | tuple):
        return ", ".join(shown_value(key, each) for each in value)
    if not isinstance(value, int | float):
        return str(value)
    scaled = Decimal(str(value)) / _factor(key)
    if not scaled.is_finite():
        return repr(value)
    text = f"{scaled.normalize():f}"
    return text if len(text) <= 20 else repr(float(scaled))


def read_value(key: str, text: str) -> Any:
    """What was typed into a field as the key's value in its own unit: a number where it is one, else the text itself,
    which the scene refuses where it wants a number; None for an empty field."""
    text = text.strip()
    if not text:
        return None
    if "," in text:
        return [read_value(key, part) for part in text.strip("[]").split(",")]
    try:
        number = parse_number(text)
    except ValueError:
        return text
    try:
        return float(Decimal(text) * _factor(key)) if _factor(key) != 1 else int(text)
    except (InvalidOperation, ValueError):
        return number


def _factor(key: str) -> Decimal:
    """How many of its own unit a key's shown one is."""
    meaning = _meaning(key)
    return Decimal(1).scaleb(_PREFIXES[meaning.shown.removesuffix(meaning.unit or "")])


def heeded(key: str) -> list[tuple[list[str], list[str]]]:
    """What must hold for a run to heed a key, each of them: that one of some switches, dotted keys, has one of some
    values. A placed antenna's are all heeded: what one leaves out is the common antenna's."""
    if key.startswith("radar.antennas."):
        return []
    section = key.rpartition(".")[0]
    return [
        ([name if "." in name else f"{section}.{name}" for name in names.split()], values.split())
        for names, values in _meaning(key).when
    ]


def matters(key: str, value: Callable[[str], Any]) -> bool:
    """Whether a run heeds a key of a scene. value: of a dotted key, the default where the scene leaves it out."""
    return all(any(value(switch) in values for switch in switches) for switches, values in heeded(key))


def is_switch(key: str) -> bool:
    """Whether others are heeded by its value: where it changes, the form changes."""
    return _plain(key) in {switch for each in _meanings() for switches, _ in heeded(each) for switch in switches}


def _meaning(key: str) -> Meaning:
    """What the schema says of a key or section; a list's number is passed over, of a union the first that has the key.
    Nothing of a key that is none."""
    return _meanings().get(_plain(key), Meaning())


def _plain(key: str) -> str:
    return ".".join(part for part in key.split(".") if not part.isdigit())


@cache
def _meanings() -> dict[str, Meaning]:
    return dict(reversed(list(_walk("", Scene))))


def _walk(above: str, section: type[BaseModel]) -> Iterator[tuple[str, Meaning]]:
    for name, field in section.model_fields.items():
        yield f"{above}{name}", meaning_of(field)
        for inner in _models(field.annotation):
            yield from _walk(f"{above}{name}.", inner)


def _models(annotation: Any) -> list[type[BaseModel]]:
    if isinstance(annotation, type) and issubclass(annotation, BaseModel):
        return [annotation]
    return [model for part in get_args(annotation) for model in _models(part)]
