"""Scene files: TOML to settings and back, overrides of keys, and the shipped scenes.

Whatever is wrong with a scene file becomes an InputError of one line: key, value, limit or reason, what to do.
"""

from __future__ import annotations

import copy
import difflib
import importlib.resources
import os
import re
import tomllib
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from types import NoneType, UnionType
from typing import Annotated, Any, Literal, TypeVar, Union, get_args, get_origin

from pydantic import BaseModel, Discriminator, ValidationError
from pydantic_core import ErrorDetails

from ..errors import InputError
from .plain_json import plain

Model = TypeVar("Model", bound=BaseModel)
Key = tuple[str | int, ...]

_LONGEST_VALUE = 60  # characters of a refused value that are shown
_DEEPEST = 16  # tables in tables: a scene has three
_TOO_DEEP = "is nested too deeply; a scene file has tables two or three deep"


# --------------------------------------------------------------------------------------------------- reading


def read_toml(path: str | os.PathLike[str]) -> dict[str, Any]:
    """The tree of a TOML file. Raises InputError if it cannot be read or is no TOML."""
    try:
        data = Path(path).read_bytes()
    except FileNotFoundError:
        raise InputError(f"{path}: no such file; give the path of a scene file") from None
    except IsADirectoryError:
        raise InputError(f"{path}: is a folder, not a file; give the scene file in it") from None
    except OSError as error:
        raise InputError(f"{path}: cannot be read ({error.strerror}); give a readable file") from None
    except ValueError as error:  # a path with a null byte
        raise InputError(f"{path!r}: is not a path ({error}); give the path of a scene file") from None
    try:
        tree = tomllib.loads(data.decode("utf-8-sig"))
    except UnicodeDecodeError as error:
        raise InputError(
            f"{path}: is not UTF-8 text (byte {data[error.start]:#04x} at position {error.start}); "
            "save the scene file as UTF-8"
        ) from None
    except RecursionError:
        raise InputError(f"{path}: {_TOO_DEEP}") from None
    except ValueError as error:  # TOMLDecodeError, or an integer of thousands of digits
        raise InputError(f"{path}: is not TOML: {error}; mend that line of the scene file") from None
    if _is_deep(tree):
        raise InputError(f"{path}: {_TOO_DEEP}")
    return tree


def _is_deep(tree: dict[str, Any]) -> bool:
    """Whether tables and lists lie deeper in each other than what copies and checks them could follow."""
    level: list[Any] = [tree]
    for _ in range(_DEEPEST):
        within = [part for each in level for part in (each.values() if isinstance(each, dict) else each)]
        level = [part for part in within if isinstance(part, dict | list)]
    return bool(level)


def apply_overrides(tree: Mapping[str, Any], overrides: Mapping[str, Any]) -> dict[str, Any]:
    """A copy of a tree with keys replaced, as {"radar.height_m": 10, "sea.waves.0.peak_period_s": "6"}.

    A string is read as a TOML value where it is one ("6" is a number, "[15, 150]" a list), else it is text;
    None takes a key out. Keys that the file leaves at their defaults may be given, and `validate` finds those
    that no section has.
    """
    result = copy.deepcopy(dict(tree))
    for dotted, value in overrides.items():
        _set(result, dotted, plain(_read_value(value) if isinstance(value, str) else value))
    return result


def _set(tree: dict[str, Any], dotted: str, value: Any) -> None:
    steps = dotted.split(".")
    if not all(step.strip() == step and step for step in steps):
        raise InputError(f"{_quoted(dotted)}: is not a key; write it as section.key, such as radar.height_m")
    if len(steps) > _DEEPEST:
        raise InputError(f"{_quoted(dotted)}: {_TOO_DEEP}")
    node: Any = tree
    for depth, step in enumerate(steps):
        above, last = ".".join(steps[:depth]), depth == len(steps) - 1
        if isinstance(node, list):
            index = _index(node, step, above, dotted)
            if last:
                node[index] = value
            else:
                node = node[index]
        elif isinstance(node, dict):
            if step.isdecimal() and step not in node:
                raise InputError(
                    f"{dotted}: no entry {step}: {above or 'the scene'} is not a list in the scene file; "
                    "put the entry in the file first"
                )
            if last and value is None:
                node.pop(step, None)
            elif last:
                node[step] = value
            else:
                node = node.setdefault(step, {})
        else:
            raise InputError(f"{dotted}: {above} = {_shown(node)} has no keys below it; set {above} itself")


def _index(entries: list[Any], step: str, above: str, dotted: str) -> int:
    if not step.isdecimal():
        raise InputError(f"{dotted}: {above} is a list; follow it with an entry's number, such as {above}.0")
    if len(step) > 9 or int(step) >= len(entries):
        held = f"entries 0 to {len(entries) - 1}" if len(entries) > 1 else f"{'one' if entries else 'no'} entry"
        raise InputError(f"{dotted}: no entry {step}: {above} has {held}; put it in the file first")
    return int(step)


def _read_value(text: str) -> Any:
    """A string from the command line as a TOML value, or itself."""
    try:
        tree = tomllib.loads(f"value = {text}")
    except (ValueError, RecursionError):
        return text
    return tree["value"] if len(tree) == 1 else text


# ------------------------------------------------------------------------------------------------ validation


def validate(model_class: type[Model], tree: Mapping[str, Any]) -> Model:
    """The model of a tree. Raises InputError: the first of several errors (unknown keys first), the others counted."""
    _refuse_unwritable(tree, ())
    try:
        return model_class.model_validate(dict(tree))
    except ValidationError as refusal:
        # An unknown key comes first: a misspelt key is also missing under its right name.
        errors = sorted(refusal.errors(), key=lambda error: error["type"] != "extra_forbidden")
    more = len(errors) - 1
    tail = f" (and {more} more error{'s' if more > 1 else ''})" if more else ""
    raise InputError(_sentence(model_class, errors[0]) + tail)


def _refuse_unwritable(value: Any, key: Key) -> None:
    """What Python holds and TOML or a path does not: it could not be written to the resolved scene, or opened."""
    if isinstance(value, Mapping):
        for name, entry in value.items():
            _refuse_unwritable(entry, (*key, name))
    elif isinstance(value, list | tuple):
        for index, entry in enumerate(value):
            _refuse_unwritable(entry, (*key, index))
    elif isinstance(value, int) and not -(2**63) <= value < 2**63:
        raise InputError(
            f"{_dotted(key)}: an integer of {value.bit_length()} bits: must fit in 64 bits, as TOML's "
            "integers do; give a smaller one"
        )
    elif isinstance(value, str) and any("\ud800" <= letter <= "\udfff" for letter in value):
        raise InputError(_about(key, value, "is not valid Unicode; write the text as UTF-8"))
    elif isinstance(value, str) and "\0" in value:
        raise InputError(_about(key, value, "holds a null byte, which no name or path has; take it out"))


@dataclass(frozen=True)
class _Location:
    """The place in a model to which an error's location leads."""

    key: Key  # without the tags of unions
    section: type[BaseModel] | None  # that holds the last key
    kind: Any  # the type expected there
    condition: str  # which member of a union the section is, in words


def _bare(kind: Any) -> tuple[Any, str | None]:
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
        kind, discriminator = _bare(kind)
        if discriminator is not None and not _is_model(kind):
            condition = f" with {discriminator} = {_quoted(str(step))}"
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
    return _Location(tuple(key), section, _bare(kind)[0], condition)


def _tags(member: Any, discriminator: str) -> tuple[Any, ...]:
    member, _ = _bare(member)
    return get_args(_bare(member.model_fields[discriminator].annotation)[0]) if _is_model(member) else ()


def _sentence(model: type[BaseModel], error: ErrorDetails) -> str:
    location, value, kind = _locate(model, error["loc"]), error["input"], error["type"]
    key, context = location.key, error.get("ctx", {})
    if kind in ("value_error", "assertion_error"):
        return _about(key, value, str(context.get("error", error["msg"])))
    if kind == "extra_forbidden":
        known = list(location.section.model_fields) if location.section else []
        return _about(key, value, f"unknown key{location.condition}; {_nearest(str(key[-1]), known, model)}")
    if kind in ("union_tag_invalid", "union_tag_not_found"):
        tag_key = str(context["discriminator"]).strip("'")
        union, _ = _bare(_locate(model, error["loc"]).kind)
        choices = [tag for member in get_args(union) for tag in _tags(member, tag_key)]
        written = value.get(tag_key) if isinstance(value, Mapping) else None
        if written is None:
            return f"{_dotted((*key, tag_key))}: is missing; add it, {_one_of(choices)}"
        return _about((*key, tag_key), written, _choose(written, choices))
    if kind == "literal_error":
        return _about(key, value, _choose(value, list(get_args(location.kind))))
    if kind in ("missing", "too_long", "too_short") and isinstance(value, list | tuple):
        if isinstance(key[-1], int):  # an entry of a list of fixed length
            location = _locate(model, error["loc"][:-1])
            key = location.key
        return _about(key, list(value), f"must be {_wanted(location.kind, key)}")
    if kind == "missing":
        return f"{_dotted(key)}: is missing; it must be {_wanted(location.kind, key)}"
    if kind.endswith("_type"):
        return _about(key, value, f"must be {_wanted(location.kind, key)}{_rewritten(location.kind, value)}")
    return _about(key, value, error["msg"][:1].lower() + error["msg"][1:])


def _about(key: Key, value: Any, words: str) -> str:
    shown = "" if isinstance(value, Mapping | BaseModel) or value is None else f" = {_shown(value)}"
    return f"{_dotted(key)}{shown}: {words}" if key else words


def _wanted(kind: Any, key: Key) -> str:
    """A type in plain words."""
    if get_origin(kind) is Literal:
        return _one_of(list(get_args(kind)))
    if get_origin(kind) is tuple:
        entries = get_args(kind)
        if entries[-1] is Ellipsis:
            inner, _ = _bare(entries[0])
            if _is_model(inner) or get_origin(inner) in (Union, UnionType):
                return f"a list of tables: write each as [[{_dotted(key)}]]"
            return "a list"
        numbers = all(_bare(entry)[0] in (float, int) for entry in entries)
        return f"a list of {len(entries)} {'numbers' if numbers else 'entries'}"
    if _is_model(kind) or get_origin(kind) in (Union, UnionType):
        inside_list = bool(key) and isinstance(key[-1], int)
        return f"a table: write it as {f'[[{_dotted(key[:-1])}]]' if inside_list else f'[{_dotted(key)}]'}"
    words = {float: "a number", int: "a whole number", bool: "true or false", str: "text in quotes"}
    return words.get(kind, "of another type")


def _rewritten(kind: Any, value: Any) -> str:
    """How a value of the wrong type should be written, where that is evident."""
    if kind is int and isinstance(value, float) and value.is_integer():
        return f"; write {int(value)}" if abs(value) < 2**63 else ""
    if kind is str and not isinstance(value, Mapping | list | tuple | str):
        return f"; write {_quoted(_shown(value))}"
    if isinstance(value, str) and kind in (float, int):
        try:
            number = kind(value)
        except ValueError:
            return ""
        return f"; write {_toml_value(number)} without quotes"
    if kind is bool and value in ("true", "false", "True", "False"):
        return f"; write {str(value).lower()} without quotes"
    return ""


def _one_of(choices: Sequence[Any]) -> str:
    return ("one of " if len(choices) > 1 else "") + ", ".join(_shown(choice) for choice in choices)


def _choose(written: Any, choices: list[Any]) -> str:
    near = difflib.get_close_matches(str(written), [str(choice) for choice in choices], 1)
    hint = f"; did you mean {_quoted(near[0])}?" if near and len(choices) > 1 else ""
    only = " (the only choice so far)" if len(choices) == 1 else ""
    return f"must be {_one_of(choices)}{only}{hint}"


def _nearest(name: str, known: Sequence[str], model: type[BaseModel]) -> str:
    """The nearest key of the section, or the same key elsewhere if that is likelier; else all its keys."""
    slip = difflib.get_close_matches(name, known, 1, 0.8)
    near = slip or list(_elsewhere(name, model, "")) or difflib.get_close_matches(name, known, 1)
    return f"did you mean {' or '.join(near)}?" if near else f"the keys here are {', '.join(known)}"


def _elsewhere(name: str, model: type[BaseModel], prefix: str) -> Iterator[str]:
    for key, field in model.model_fields.items():
        kind, _ = _bare(field.annotation)
        if key == name:
            yield prefix + key
        if _is_model(kind):
            yield from _elsewhere(name, kind, f"{prefix}{key}.")


def _dotted(key: Key) -> str:
    return ".".join(_key_text(str(step)) for step in key)


def _shown(value: Any) -> str:
    try:
        text = _toml_value(value)
    except TypeError:
        text = str(value)
    return text if len(text) <= _LONGEST_VALUE else text[: _LONGEST_VALUE - 1] + "…"


# --------------------------------------------------------------------------------------------------- writing


def to_toml(model: BaseModel) -> str:
    """Every key of a model, defaults too, as TOML that reads back to an equal model with the same bits."""
    lines: list[str] = []
    _write_table(model, "", lines)
    return "\n".join(lines) + "\n"


def _write_table(model: BaseModel, prefix: str, lines: list[str]) -> None:
    tables: list[tuple[str, str, BaseModel]] = []
    for name in type(model).model_fields:
        value = getattr(model, name)
        key = f"{prefix}{_key_text(name)}"
        if isinstance(value, BaseModel):
            tables.append((f"[{key}]", key, value))
        elif isinstance(value, list | tuple) and any(isinstance(entry, BaseModel) for entry in value):
            tables += [(f"[[{key}]]", key, entry) for entry in value]
        elif value is not None:
            lines.append(f"{_key_text(name)} = {_toml_value(value)}")
    for header, key, table in tables:  # after the plain keys, which would else belong to the table
        lines += ["", header]
        _write_table(table, f"{key}.", lines)


def _key_text(name: str) -> str:
    return name if re.fullmatch(r"[A-Za-z0-9_-]+", name) else _quoted(name)


def _toml_value(value: Any) -> str:
    if isinstance(value, bool):
        return "true" if value else "false"
    if isinstance(value, int):
        return int.__repr__(value)
    if isinstance(value, float):
        return float.__repr__(value)  # the shortest digits that read back to the same bits; inf is TOML's too
    if isinstance(value, str):
        return _quoted(value)
    if isinstance(value, list | tuple):
        return "[" + ", ".join(_toml_value(entry) for entry in value) + "]"
    raise TypeError(f"{type(value).__name__} has no form in a scene file")


def _quoted(text: str) -> str:
    """A TOML basic string; characters that would break the line or not print are escaped."""
    return '"' + "".join(_escaped(letter) for letter in text) + '"'


def _escaped(letter: str) -> str:
    if letter in '"\\':
        return f"\\{letter}"
    if letter.isprintable():
        return letter
    return f"\\u{ord(letter):04x}" if ord(letter) <= 0xFFFF else f"\\U{ord(letter):08x}"


# -------------------------------------------------------------------------------------------- shipped scenes


def list_shipped() -> dict[str, Path]:
    """The shipped scenes by name: those inside the installed wheel, or the repository's own."""
    packaged = Path(str(importlib.resources.files("seamap_rt").joinpath("_scenes")))
    folder = packaged if packaged.is_dir() else packaged.parent.parent / "scenes"
    return {path.stem: path for path in sorted(folder.glob("*.toml"))}


def find_scene(name_or_path: str | os.PathLike[str]) -> Path:
    """The file of a scene: the name of a shipped one (write ./name for a file called like it) or a path."""
    shipped, text = list_shipped(), os.fspath(name_or_path)
    if text in shipped:
        return shipped[text]
    path = Path(text)
    if text and os.path.lexists(path):
        return path
    name = path.stem if path.suffix == ".toml" else path.name
    near = [name] if name in shipped else difflib.get_close_matches(name, shipped, 3, 0.5)
    hint = f"did you mean the shipped {' or '.join(near)}?" if near else f"shipped are {', '.join(shipped)}"
    raise InputError(f"{_shown(text)}: neither a file nor the name of a shipped scene; {hint}")
