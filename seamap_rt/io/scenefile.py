"""Scene files: TOML to settings and back, overrides of keys, and the shipped scenes.

Faults of a scene file raise InputError. It has one line for each fault: key, value, limit or reason, and what to do.
"""

from __future__ import annotations

import copy
import difflib
import importlib.resources
import os
import tomllib
from collections.abc import Mapping
from pathlib import Path
from typing import Any

from ..errors import InputError, must_be
from .opening import read_bytes
from .text import decode_text, is_underscored, key_text, shown, to_builtin, toml_string, toml_value

_DEEPEST = 16  # tables in tables: a scene has three
_TOO_DEEP = "is nested too deeply; a scene file has tables two or three deep"


# --------------------------------------------------------------------------------------------------- reading


def read_toml(path: str | os.PathLike[str], wanted: str = "a scene file") -> dict[str, Any]:
    """The tree of a TOML file. wanted: what it is to be. Raises InputError if it cannot be read or is no TOML."""
    data = read_bytes(path, wanted)
    try:
        tree = tomllib.loads(decode_text(data, str(path)))
    except InputError:
        raise
    except RecursionError:
        raise InputError(f"{path}: {_TOO_DEEP}") from None
    except ValueError as error:  # TOMLDecodeError, or an integer of thousands of digits
        raise InputError(f"{path}: is not TOML: {error}; mend that line of {wanted.removeprefix('a ')}") from None
    level: list[Any] = [tree]
    for _ in range(_DEEPEST):  # beyond it what copies and checks could not follow
        within = [part for each in level for part in (each.values() if isinstance(each, dict) else each)]
        level = [part for part in within if isinstance(part, dict | list)]
    if level:
        raise InputError(f"{path}: {_TOO_DEEP}")
    return tree


def apply_overrides(tree: Mapping[str, Any], overrides: Mapping[str, Any]) -> dict[str, Any]:
    """A copy of a tree with keys replaced, as {"radar.height_m": 10, "sea.waves.0.peak_period_s": "6"}.

    A string is read as a TOML value where it is one ("6" is a number, "[15, 150]" a list), else it is text;
    None takes a key out. Keys that the file leaves at their defaults may be given, and `validation.validate` finds
    those that no section has. Raises InputError, with a line for each override that cannot be set.
    """
    result, problems = copy.deepcopy(dict(tree)), list[str]()
    for dotted, value in overrides.items():
        try:
            _set(result, dotted, to_builtin(_read_value(value) if isinstance(value, str) else value))
        except InputError as refusal:
            problems += refusal.problems
    if problems:
        raise InputError(*problems)
    return result


def _set(tree: dict[str, Any], dotted: str, value: Any) -> None:
    steps = dotted.split(".")
    if not all(step.strip() == step and step for step in steps):
        raise InputError(f"{toml_string(dotted)}: is not a key; write it as section.key, such as radar.height_m")
    if len(steps) > _DEEPEST:
        raise InputError(f"{toml_string(dotted)}: {_TOO_DEEP}")
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
            raise InputError(f"{dotted}: {above} = {shown(node)} has no keys below it; set {above} itself")


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
    return tree["value"] if len(tree) == 1 and not is_underscored(text) else text


# --------------------------------------------------------------------------------------------------- writing


def tree_to_toml(tree: Mapping[str, Any]) -> str:
    """A tree of tables as TOML, as `read_toml` gives it back, with the same bits."""
    lines: list[str] = []
    _write_tree(tree, "", lines)
    return "\n".join(lines).lstrip("\n") + "\n"


def _write_tree(tree: Mapping[str, Any], prefix: str, lines: list[str]) -> None:
    tables: list[tuple[str, str, Mapping[str, Any]]] = []
    for name, value in tree.items():
        key = f"{prefix}{key_text(name)}"
        if isinstance(value, Mapping):
            tables.append((f"[{key}]", key, value))
        elif isinstance(value, list | tuple) and value and all(isinstance(entry, Mapping) for entry in value):
            tables += [(f"[[{key}]]", key, entry) for entry in value]
        elif value is not None:
            lines.append(f"{key_text(name)} = {toml_value(value)}")
    for header, key, table in tables:  # after the plain keys, which would else belong to the table
        lines += ["", header]
        _write_tree(table, f"{key}.", lines)


# -------------------------------------------------------------------------------------------- shipped scenes


def list_shipped() -> dict[str, Path]:
    """The shipped scenes by name: those inside the installed wheel, or the repository's own."""
    packaged = Path(str(importlib.resources.files("seamap_rt").joinpath("_scenes")))
    folder = packaged if packaged.is_dir() else packaged.parent.parent / "scenes"
    return {path.stem: path for path in sorted(folder.glob("*.toml"))}


def find_scene(name_or_path: str | os.PathLike[str]) -> Path:
    """The file of a scene: the name of a shipped one (write ./name for a file called like it) or a path."""
    must_be("scene", name_or_path, (str, os.PathLike), "a shipped scene's name, or the path of a scene file")
    shipped, text = list_shipped(), os.fspath(name_or_path)
    if text in shipped:
        return shipped[text]
    path = Path(text)
    if text and os.path.lexists(path):
        return path
    name = path.stem if path.suffix == ".toml" else path.name
    near = [name] if name in shipped else difflib.get_close_matches(name, shipped, 3, 0.5)
    hint = f"did you mean the shipped {' or '.join(near)}?" if near else f"shipped are {', '.join(shipped)}"
    raise InputError(f"{shown(text)}: neither a file nor the name of a shipped scene; {hint}")
