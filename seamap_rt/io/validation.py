"""From the tree of a scene file to its settings. Each fault of the tree is described in one line, in the user's words.

A line names the key, its value, the limit or the nearest known key, and what to do.
"""

from __future__ import annotations

import difflib
import math
import re
from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass
from types import NoneType, UnionType
from typing import Annotated, Any, Literal, TypeVar, Union, get_args, get_origin

from pydantic import BaseModel, Discriminator, TypeAdapter, ValidationError
from pydantic_core import ErrorDetails

from ..errors import InputError
from ..settings import Meaning
from .text import key_text, number_text, shown, toml_string, toml_value

_NUMBER = r"[-+]?(?:\d+\.?\d*|\.\d+)(?:[eE][-+]?\d+)?"
Model = TypeVar("Model", bound=BaseModel)
Key = tuple[str | int, ...]
Further = Callable[[Mapping[str, Any], frozenset[Key]], Iterable[str]]


def validate(model_class: type[Model], tree: Mapping[str, Any], further: Further | None = None) -> Model:
    """The model of a tree. Raises InputError with one line for each fault, unknown keys first.

    further: asked where single keys are wrong, with the tree and these keys, for what else is wrong with the rest: the
    model's own checks are not made then.
    """
    if unwritable := list(_find_unwritable(tree, ())):
        raise InputError(*unwritable)
    try:
        return model_class.model_validate(dict(tree))
    except ValidationError as refusal:
        # An unknown key comes first: a misspelt key is also missing under its right name.
        errors = sorted(refusal.errors(), key=lambda error: error["type"] != "extra_forbidden")
    located = [(_locate(model_class, error["loc"]), error) for error in errors]
    meant = frozenset(
        key for location, error in located if error["type"] == "extra_forbidden" for key in location.similar_keys
    )
    located = [(at, error) for at, error in located if not (error["type"] == "missing" and at.key in meant)]
    lines = [line for location, error in located for line in _problems(model_class, location, error)]
    wrong = meant | {location.key for location, _ in located}
    if further is not None and () not in wrong:  # () is what the model's own checks say
        lines += further(tree, wrong)
    raise InputError(*lines)


def without(model_class: type[Model], tree: Mapping[str, Any], wrong: frozenset[Key]) -> Model:
    """The model of a tree whose wrong keys are not there: to ask for one raises AttributeError. What the keys stand in
    is missing whole if it is a list, or cannot be without them."""
    parts: dict[str, Any] = {}
    for name, field in model_class.model_fields.items():
        lost = {key[1:2] for key in wrong if key[0] == name}
        section = _strip_type(field.annotation)[0]
        if () in lost or (lost and not _is_model(section)):
            continue
        try:
            if _is_model(section):
                left = {key: value for key, value in tree.get(name, {}).items() if (key,) not in lost}
                part = section.model_validate(left).model_copy()
                for (key,) in lost:
                    vars(part).pop(str(key), None)  # pydantic knows no model that lacks a field
            elif name in tree:
                part = TypeAdapter(field.rebuild_annotation()).validate_python(tree[name])
            elif not field.is_required():
                part = field.get_default(call_default_factory=True)
            else:
                continue
        except ValidationError:
            continue
        parts[name] = part
    result = model_class.model_construct(**parts)
    for name in set(model_class.model_fields) - set(parts):
        vars(result).pop(name, None)  # which was filled with its default
    return result


def _find_unwritable(value: Any, key: Key) -> Iterator[str]:
    """What Python holds and TOML or a path does not: it could not be written to the resolved scene, or opened."""
    if isinstance(value, Mapping):
        for name, entry in value.items():
            yield from _find_unwritable(entry, (*key, name))
    elif isinstance(value, list | tuple):
        for index, entry in enumerate(value):
            yield from _find_unwritable(entry, (*key, index))
    elif isinstance(value, int) and not -(2**63) <= value < 2**63:
        yield (
            f"{_dotted_key(key)}: an integer of {value.bit_length()} bits: must fit in 64 bits, as TOML's "
            "integers do; give a smaller one"
        )
    elif isinstance(value, str) and any("\ud800" <= letter <= "\udfff" for letter in value):
        yield _problem(key, value, "is not valid Unicode; write the text as UTF-8")
    elif isinstance(value, str) and "\0" in value:
        yield _problem(key, value, "holds a null byte, which no name or path has; take it out")


# ---------------------------------------------------------------------------------------------- where an error is


@dataclass(frozen=True)
class _Location:
    """The place in a model to which an error's location leads."""

    key: Key  # without the tags of unions
    section: type[BaseModel] | None  # that holds the last key
    kind: Any  # the type expected there
    condition: str  # which member of a union the section is, in words
    stated: Any  # the type with its limits and its meaning

    @property
    def known_keys(self) -> list[str]:
        """Keys that may stand there."""
        return list(self.section.model_fields) if self.section else []

    @property
    def similar_keys(self) -> list[Key]:
        """The key for which an unknown one probably stands: what it was to be is not known."""
        return [(*self.key[:-1], each) for each in difflib.get_close_matches(str(self.key[-1]), self.known_keys, 1)]


def _strip_type(kind: Any) -> tuple[Any, str | None]:
    """A type stripped of Annotated and None, and the discriminator if it is a tagged union."""
    discriminator = None
    while True:
        if get_origin(kind) is Annotated:
            kind, *notes = get_args(kind)
            for note in notes:
                if isinstance(note, Discriminator) and isinstance(note.discriminator, str):
                    discriminator = note.discriminator
        elif get_origin(kind) in (Union, UnionType) and NoneType in get_args(kind):
            rest = tuple(member for member in get_args(kind) if member is not NoneType)
            kind = Union[rest]  # noqa: UP007 - the members are only known here
        else:
            return kind, discriminator


def _is_model(kind: Any) -> bool:
    return isinstance(kind, type) and issubclass(kind, BaseModel)


def _locate(model: type[BaseModel], location: Sequence[str | int]) -> _Location:
    key: list[str | int] = []
    section: type[BaseModel] | None = None
    kind: Any = model
    condition = ""
    for step in location:
        kind, discriminator = _strip_type(kind)
        if discriminator is not None and not _is_model(kind):
            condition = f" with {discriminator} = {toml_string(str(step))}"
            members = [member for member in get_args(kind) if step in _tags(member, discriminator)]
            kind = members[0] if members else None
            continue
        key.append(step)
        if _is_model(kind):
            section = kind
            field = kind.model_fields.get(step)
            kind = None if field is None else field.rebuild_annotation()
        elif get_origin(kind) is tuple and isinstance(step, int):
            entries = get_args(kind)
            kind = entries[0] if entries[-1] is Ellipsis else entries[min(step, len(entries) - 1)]
        else:
            kind = None
    return _Location(tuple(key), section, _strip_type(kind)[0], condition, kind)


def _tags(member: Any, discriminator: str) -> tuple[Any, ...]:
    member, _ = _strip_type(member)
    return get_args(_strip_type(member.model_fields[discriminator].annotation)[0]) if _is_model(member) else ()


# -------------------------------------------------------------------------------------------------- what it says


def _problems(model: type[BaseModel], location: _Location, error: ErrorDetails) -> Iterator[str]:
    inner = error.get("ctx", {}).get("error")
    if isinstance(inner, InputError):  # it may tell of several
        yield from (_problem(location.key, error["input"], line) for line in inner.problems)
    else:
        yield _describe_error(model, location, error)


def _describe_error(model: type[BaseModel], location: _Location, error: ErrorDetails) -> str:
    value, kind = error["input"], error["type"]
    key, context = location.key, error.get("ctx", {})
    if kind in ("value_error", "assertion_error"):
        return _problem(key, value, str(context.get("error", error["msg"])) + _suggest_units(location, value))
    if kind == "extra_forbidden":
        return _problem(
            key, value, f"unknown key{location.condition}; {_suggest_key(str(key[-1]), location.known_keys, model)}"
        )
    if kind in ("union_tag_invalid", "union_tag_not_found"):
        tag_key = str(context["discriminator"]).strip("'")
        choices = [tag for member in get_args(location.kind) for tag in _tags(member, tag_key)]
        written = value.get(tag_key) if isinstance(value, Mapping) else None
        if written is None:
            return f"{_dotted_key((*key, tag_key))}: is missing; add it, {_list_choices(choices)}"
        return _problem((*key, tag_key), written, _suggest_choice(written, choices))
    if kind == "literal_error":
        return _problem(key, value, _suggest_choice(value, list(get_args(location.kind))))
    if kind in ("missing", "too_long", "too_short") and isinstance(value, list | tuple):
        if isinstance(key[-1], int):  # an entry of a list of fixed length
            location = _locate(model, error["loc"][:-1])
            key = location.key
        return _problem(key, list(value), f"must be {_type_in_words(location.kind, key)}")
    if kind == "missing":
        return f"{_dotted_key(key)}: is missing; it must be {_type_in_words(location.kind, key)}"
    if kind.endswith("_type"):
        return _problem(key, value, f"must be {_type_in_words(location.kind, key)}{_suggest_spelling(location, value)}")
    return _problem(key, value, error["msg"][:1].lower() + error["msg"][1:])


def _problem(key: Key, value: Any, words: str) -> str:
    given = "" if isinstance(value, Mapping | BaseModel) or value is None else f" = {shown(value)}"
    return f"{_dotted_key(key)}{given}: {words}" if key else words


def _type_in_words(kind: Any, key: Key) -> str:
    """A type in plain words."""
    if get_origin(kind) is Literal:
        return _list_choices(list(get_args(kind)))
    if get_origin(kind) is tuple:
        entries = get_args(kind)
        if entries[-1] is Ellipsis:
            inner, _ = _strip_type(entries[0])
            if _is_model(inner) or get_origin(inner) in (Union, UnionType):
                return f"a list of tables: write each as [[{_dotted_key(key)}]]"
            return "a list"
        numbers = all(_strip_type(entry)[0] in (float, int) for entry in entries)
        return f"a list of {len(entries)} {'numbers' if numbers else 'entries'}"
    if _is_model(kind) or get_origin(kind) in (Union, UnionType):
        inside_list = bool(key) and isinstance(key[-1], int)
        return f"a table: write it as {f'[[{_dotted_key(key[:-1])}]]' if inside_list else f'[{_dotted_key(key)}]'}"
    words = {float: "a number", int: "a whole number", bool: "true or false", str: "text in quotes"}
    return words.get(kind, "of another type")


def _suggest_spelling(location: _Location, value: Any) -> str:
    """How a value of the wrong type should be written, where that is evident."""
    kind = location.kind
    if kind is int and isinstance(value, float) and value.is_integer():
        return f"; write {int(value)}" if abs(value) < 2**63 else ""
    if kind is str and not isinstance(value, Mapping | list | tuple | str):
        return f"; write {toml_string(shown(value))}"
    if isinstance(value, str) and kind in (float, int):
        try:
            number = kind(value)
        except ValueError:
            return _suggest_number(location, value)
        return f"; write {toml_value(number)} without quotes"
    if get_origin(kind) is tuple and isinstance(value, str):
        entries = [float(each) for each in re.findall(_NUMBER, value)]
        return f"; write [{','.join(map(number_text, entries))}]" if _is_valid(location, entries) else ""
    if kind is bool and value in ("true", "false", "True", "False"):
        return f"; write {str(value).lower()} without quotes"
    return ""


_OTHER_UNITS = {  # in which people think, by the key's own: how many of it one is
    "Hz": {"GHz": 1e9, "MHz": 1e6, "kHz": 1e3},
    "s": {"ms": 1e-3, "µs": 1e-6, "us": 1e-6, "ns": 1e-9},
    "m": {"km": 1e3, "cm": 1e-2, "mm": 1e-3},
    "W": {"kW": 1e3, "mW": 1e-3},
    "m/s": {"km/h": 1.0 / 3.6, "kn": 1852.0 / 3600.0, "cm/s": 1e-2},
    "1/min": {"1/s": 60.0},
    "°": {"rad": math.degrees(1.0)},
    "1": {"%": 1e-2},
}


def _suggest_units(location: _Location, value: Any) -> str:
    """What a number that is refused may be meant as, of another unit's prefix, or a ratio for decibels: nearest to the
    default first."""
    numbers = list(value) if isinstance(value, list | tuple) else [value]
    meaning = _meaning(location)
    if meaning is None or not all(type(each) in (int, float) and math.isfinite(each) for each in numbers):
        return ""
    unit, default = meaning.unit or "", _default(location)
    meant = [[each * factor for each in numbers] for factor in _OTHER_UNITS.get(unit, {}).values()]
    if unit.startswith("dB") and all(each > 0.0 for each in numbers):
        meant = [[10.0 * math.log10(each) for each in numbers]]
    proposals: dict[str, float] = {}
    for each in meant:
        each = [float(f"{number:.12g}") for number in each]
        if _is_valid(location, each if isinstance(value, list | tuple) else each[0]):
            text = ",".join(map(number_text, each))
            far = abs(math.log(abs(each[-1] / default))) if default and each[-1] else math.inf
            proposals[f"[{text}]" if isinstance(value, list | tuple) else text] = far
    words = " or ".join(sorted(proposals, key=lambda text: proposals[text]))
    return words and f"; did you mean {words}{f' ({unit})' if unit != '1' else ''}?"


def _suggest_number(location: _Location, text: str) -> str:
    """A number that is written with a unit, as the key's own."""
    meaning, found = _meaning(location), re.fullmatch(rf"\s*({_NUMBER})\s*(\S+)\s*", text)
    if meaning is None or not meaning.unit or found is None:
        return ""
    factor = ({meaning.unit: 1.0} | _OTHER_UNITS.get(meaning.unit, {})).get(found[2])
    return f"; write {number_text(float(found[1]) * factor)}, in {meaning.unit}" if factor else ""


def _meaning(location: _Location) -> Meaning | None:
    notes = get_args(location.stated)[1:] if get_origin(location.stated) is Annotated else ()
    return next((note for note in notes if isinstance(note, Meaning)), None)


def _default(location: _Location) -> float | None:
    """The number that a key has when it is left out, of a list the last; None without any."""
    field = location.section.model_fields.get(str(location.key[-1])) if location.section else None
    default = field.default if field else None
    last = default[-1] if isinstance(default, tuple) and default else default
    return float(last) if isinstance(last, int | float) and math.isfinite(last) else None


def _is_valid(location: _Location, value: Any) -> bool:
    """Whether a value keeps the key's own limits."""
    try:
        TypeAdapter(location.stated, config={"strict": True}).validate_python(value)
    except ValidationError:
        return False
    return True


def _list_choices(choices: Sequence[Any]) -> str:
    return ("one of " if len(choices) > 1 else "") + ", ".join(shown(choice) for choice in choices)


def _suggest_choice(written: Any, choices: list[Any]) -> str:
    near = difflib.get_close_matches(str(written), [str(choice) for choice in choices], 1)
    hint = f"; did you mean {toml_string(near[0])}?" if near and len(choices) > 1 else ""
    only = " (the only choice so far)" if len(choices) == 1 else ""
    return f"must be {_list_choices(choices)}{only}{hint}"


def _suggest_key(name: str, known: Sequence[str], model: type[BaseModel]) -> str:
    """The nearest key of the section, or the same key elsewhere if that is likelier; else all its keys."""
    slip = difflib.get_close_matches(name, known, 1, 0.8)
    near = slip or list(_find_key(name, model, "")) or difflib.get_close_matches(name, known, 1)
    return f"did you mean {' or '.join(near)}?" if near else f"the keys here are {', '.join(known)}"


def _find_key(name: str, model: type[BaseModel], prefix: str) -> Iterator[str]:
    for key, field in model.model_fields.items():
        kind, _ = _strip_type(field.annotation)
        if key == name:
            yield prefix + key
        if _is_model(kind):
            yield from _find_key(name, kind, f"{prefix}{key}.")


def _dotted_key(key: Key) -> str:
    return ".".join(key_text(str(step)) for step in key)
