"""A scene to begin with: one that there is, written with every key explained, to be changed and run."""

from __future__ import annotations

import math
import os
import textwrap
from collections.abc import Iterator, Mapping, Sequence
from pathlib import Path
from typing import Any

from pydantic import BaseModel

from ..errors import InputError
from ..io.results_folder import write_whole
from ..io.scenefile import find_scene, read_toml
from ..io.text import key_text, toml_string, toml_value
from .keys import KeyRow, KeySection, key_sections
from .model import Scene, is_name, load_scene

STUDY = "choppy_sea"  # the radar of the study: two X-band antennas, 1 W, 20 ns, 60 turns a minute
_COLUMN, _WIDTH = 36, 120  # where comments begin and end
_ALWAYS = ("", "sea", "scattering", "radar", "radar.antenna", "platform", "tracing", "retrieval")


def write_scene(file: str | os.PathLike[str], like: str | os.PathLike[str] = STUDY, *, overwrite: bool = False) -> Path:
    """Write a scene file that runs as it stands: the scene `like`, a shipped one's name or a file, under a new name.

    It loads to the same scene, but for its name, which is the file's. Files that it names are named by their absolute
    paths. Raises InputError for a scene that there is not, for a file's name that is none for a scene, and for a file
    that is there already, without `overwrite`.
    """
    path, scene = Path(file), load_scene(like)
    if not is_name(path.stem):
        raise InputError(
            f"FILE = '{path}': names the scene, which takes 1 to 100 letters, digits and . _ + -; choose such a name"
        )
    if path.is_dir() or (os.path.lexists(path) and not overwrite):
        what = "is a folder; add the file's name" if path.is_dir() else "is there; choose another, or give --overwrite"
        raise InputError(f"FILE = '{path}': {what}")
    if not path.parent.is_dir():
        raise InputError(f"FILE = '{path}': there is no folder '{path.parent}'; make it, or choose another")
    given = read_toml(find_scene(like))
    head = [
        f"# A scene to begin with, like {like}; seamap-rt run {path.name} runs it as it stands.",
        "# What stands behind a # is the default. seamap-rt keys [SECTION] tells of all keys and their limits.",
    ]
    write_whole(path, "\n".join([*head, *_lines(scene.model_copy(update={"name": path.stem}), given)]) + "\n")
    return path


def _lines(scene: Scene, given: Mapping[str, Any]) -> Iterator[str]:
    sections = key_sections()
    by_name = {row.name: row for section in sections for row in section.rows}
    for section in sections:
        held = _value_at(scene, section.path)
        tables = list(held) if section.many else [held]
        written = _value_at(given, section.path)
        stated = list(written or ()) if section.many else [written or {}]
        if not tables or not (section.path in _ALWAYS or any(stated) or any(map(_changed, tables))):
            comment = f"{section.heading}: {_plain(section.meaning)} See seamap-rt keys {section.path}."
            yield from ("", *(f"# {line}" for line in textwrap.wrap(comment, _WIDTH - 2)))
            continue
        for number, table in enumerate(tables):
            if section.path:
                yield from ("", *_commented(section.heading, _plain(section.meaning)))
            yield from _table(section, table, stated[number] if number < len(stated) else {}, by_name)


def _table(
    section: KeySection, table: BaseModel, given: Mapping[str, Any], by_name: Mapping[str, KeyRow]
) -> Iterator[str]:
    """The keys of a table: as they are, or behind a # where the default was not even written out."""
    kind = getattr(table, section.tag) if section.tag else ""
    if section.tag:
        others = ", ".join(each.name for each in section.kinds if each.name != kind)
        (meaning,) = (each.meaning for each in section.kinds if each.name == kind)
        yield from _commented(f"{section.tag} = {toml_string(kind)}", f"{_plain(meaning)} Or {others}.")
    rows = {row.name: row for row in section.rows if not row.kinds or kind in row.kinds}
    for name, field in type(table).model_fields.items():
        value = getattr(table, name)
        if name == section.tag or _holds_tables(value):
            continue
        stands = value is not None and (name in given or field.is_required() or value != field.default)
        row = rows.get(name) or by_name.get(name)
        if row is None or not (stands or name in rows):
            continue
        code = key_text(name) if value is None else f"{key_text(name)} = {_written(value)}"
        yield from _explained(code if stands else f"# {code}", row)


def _explained(code: str, row: KeyRow) -> Iterator[str]:
    """A key, and behind it its unit, default, choices and meaning."""
    unit = "" if row.unit == "1" else row.unit
    default = "" if row.default == "needed" else f"default {row.default}" if "`" in row.default else row.default
    if default and "`" not in row.default:
        default = f"left out: {default}"
    choices = row.limit if row.limit.startswith("`") and "," in row.limit and "true" not in row.limit else ""
    facts = "; ".join(filter(None, (unit, default, choices and f"of {choices}")))
    yield from _commented(code, _plain(f"{facts}. {row.meaning}" if facts else row.meaning))


def _commented(code: str, comment: str) -> Iterator[str]:
    """A line with a comment behind it, which goes on below itself; above a line that is too long for that."""
    if len(code) + 2 > 2 * _COLUMN:
        yield from (f"# {line}" for line in textwrap.wrap(comment, _WIDTH - 2))
        yield code
        return
    start = max(_COLUMN, len(code) + 2)
    first, *rest = textwrap.wrap(comment, _WIDTH - start - 2)
    yield f"{code:<{start}}# {first}"
    yield from (f"{'':<{start}}# {line}" for line in rest)


def _plain(text: str) -> str:
    return " ".join(text.replace("`", "").split())


def _written(value: Any) -> str:
    """A value as one writes it by hand, 20e-9, if it reads back to the same bits."""
    if isinstance(value, tuple | list):
        return "[" + ", ".join(_written(each) for each in value) + "]"
    if isinstance(value, float) and math.isfinite(value) and value != 0.0 and not 1e-3 <= abs(value) < 1e6:
        power = 3 * math.floor(math.log10(abs(value)) / 3.0)
        text = f"{value / 10.0**power:.12g}e{power}"
        if float(text) == value:
            return text
    return toml_value(value)


def _value_at(holder: Any, path: str) -> Any:
    """What stands at a path; None where there is nothing."""
    for step in filter(None, path.split(".")):
        holder = holder.get(step) if isinstance(holder, Mapping) else getattr(holder, step, None)
    return holder


def _changed(table: BaseModel) -> bool:
    return any(
        getattr(table, name) != field.default
        for name, field in type(table).model_fields.items()
        if not _holds_tables(getattr(table, name))
    )


def _holds_tables(value: Any) -> bool:
    several = isinstance(value, Sequence) and not isinstance(value, str)
    return isinstance(value, BaseModel) or (several and any(isinstance(each, BaseModel) for each in value))
