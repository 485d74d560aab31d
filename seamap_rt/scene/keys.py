"""What the keys of a scene are: name, unit, default, limit and meaning of each, by section, from the JSON schema.

The manual (`reference`), the command `keys` and the scene that `starting` writes say what stands here.
"""

from __future__ import annotations

import difflib
from collections.abc import Callable, Iterable, Iterator, Mapping
from dataclasses import dataclass, replace
from typing import Any, NamedTuple

from ..errors import InputError
from ..io.text import quoted
from .model import Scene

Schema = Mapping[str, Any]
TOP = "top of the file"


class KeyRow(NamedTuple):
    """A key in words, code between `backticks`. kinds: of tables of several kinds, those that have the key so."""

    name: str
    unit: str
    default: str
    limit: str
    meaning: str
    kinds: tuple[str, ...] = ()


class Kind(NamedTuple):
    """One of the kinds of table that a list may hold."""

    name: str
    meaning: str
    keys: tuple[str, ...]


@dataclass(frozen=True)
class KeySection:
    """A section's keys. path: "radar.antenna", empty for the top of the file. many: a list of tables. meaning: what the
    key that holds it means. about: its paragraphs. tag: the key that says which of `kinds` a table is."""

    path: str
    many: bool
    meaning: str
    about: str
    rows: tuple[KeyRow, ...]
    tag: str = ""
    kinds: tuple[Kind, ...] = ()

    @property
    def heading(self) -> str:
        if not self.path:
            return TOP
        return f"[[{self.path}]]" if self.many else f"[{self.path}]"


def key_sections() -> list[KeySection]:
    """All sections, in the order of a scene file."""
    schema = Scene.model_json_schema()
    return list(_section("", False, "All that a run depends on.", schema, schema))


def keys_about(text: str) -> list[KeySection]:
    """The keys that a text means: one, as radar.height_m; a section and those within it, as radar.antenna; or those of
    whose names or meanings it is a part, as height. InputError, with the nearest, where there are none."""
    wanted = ".".join(step for step in text.strip("[] ").split(".") if not step.isdecimal())  # of a list's entry
    every = key_sections()
    if found := [each for each in every if each.path == wanted or each.path.startswith(f"{wanted}.")]:
        return found
    if found := _with_keys(every, lambda key, _: key == wanted):
        return found
    word = wanted.casefold()
    if word and (found := _with_keys(every, lambda key, meaning: word in key or word in meaning.casefold())):
        return found
    names = [each.path for each in every if each.path]
    names += [_key(each, name) for each in every for name in (each.tag, *(row.name for row in each.rows)) if name]
    near = difflib.get_close_matches(wanted, names, 3)
    near = near or [each for each in names if difflib.get_close_matches(wanted, [each.rsplit(".", 1)[-1]], 1, 0.75)][:3]
    hint = f"did you mean {' or '.join(near)}?" if near else f"the sections are {', '.join(s.path for s in every[1:])}"
    raise InputError(f"KEY = {quoted(text)}: no key, section or word of them; {hint}")


def _with_keys(sections: Iterable[KeySection], wanted: Callable[[str, str], bool]) -> list[KeySection]:
    """The sections with those of their keys alone that are wanted, by name and meaning; none without any."""
    result: list[KeySection] = []
    for each in sections:
        rows = tuple(row for row in each.rows if wanted(_key(each, row.name), row.meaning))
        tag = each.tag if each.tag and wanted(_key(each, each.tag), each.meaning) else ""
        if rows or tag:
            result.append(replace(each, rows=rows, tag=tag))
    return result


def _key(section: KeySection, name: str) -> str:
    return f"{section.path}.{name}" if section.path else name


# ---------------------------------------------------------------------------------------------------- from the schema


def _section(path: str, many: bool, meaning: str, section: Schema, schema: Schema) -> Iterator[KeySection]:
    """A section, then those in it; without keys that stand in another one, whose values they take when left out."""
    keys = {n: key for n, key in section["properties"].items() if not key.get("left_out", "").startswith("that of ")}
    inner = {name: key for name, key in keys.items() if _sections(key, schema)}
    plain = {name: key for name, key in keys.items() if name not in inner}
    rows = tuple(_row(name, key, name in section.get("required", ())) for name, key in plain.items())
    yield KeySection(path, many, meaning, _paragraphs(section), rows)
    for name, key in inner.items():
        sections, listed = _sections(key, schema), key.get("type") == "array"
        below = f"{path}.{name}" if path else name
        if len(sections) > 1:
            yield _kinds(below, key, sections)
        else:
            yield from _section(below, listed, key.get("description", ""), sections[0], schema)


def _kinds(path: str, key: Schema, sections: list[Schema]) -> KeySection:
    """Sections of which one key says which it is, as one: what each is and which keys it has, and the keys of all."""
    tag = key["items"]["discriminator"]["propertyName"]
    rows: dict[str, dict[KeyRow, list[str]]] = {}
    kinds: list[Kind] = []
    for section in sections:
        kind, keys = section["properties"][tag]["const"], [name for name in section["properties"] if name != tag]
        kinds.append(Kind(kind, " ".join(section["description"].split()), tuple(keys)))
        for name in keys:
            row = _row(name, section["properties"][name], name in section.get("required", ()))
            rows.setdefault(name, {}).setdefault(row, []).append(kind)
    each = [(row, of, len(variants) > 1) for variants in rows.values() for row, of in variants.items()]
    all_rows = tuple(row._replace(kinds=tuple(of)) if differ else row for row, of, differ in each)
    return KeySection(path, True, key["description"], "", all_rows, tag, tuple(kinds))


def _row(name: str, key: Schema, needed: bool) -> KeyRow:
    default = "needed" if needed else _default(key)
    return KeyRow(name, key["unit"] or "", default, _limit(key), key["description"])


def _default(key: Schema) -> str:
    if key.get("default") is None:
        return key.get("left_out", "")
    return f"`{_value(key['default'])}`"


def _value(value: Any) -> str:
    if isinstance(value, bool):
        return str(value).lower()
    if isinstance(value, int | float):
        return f"{value:.12g}" if abs(value) < 1e6 else f"{value:g}".replace("e+", "e").replace("e0", "e")
    if isinstance(value, list):
        return f"[{','.join(_value(each) for each in value)}]"
    return value if value == "inf" else f'"{value}"'


def _limit(key: Schema) -> str:
    """Choices or bounds, and in brackets the reason of the bounds."""
    kinds = [kind for kind in key.get("anyOf", [key]) if kind.get("type") != "null"]
    bounds = " or ".join(filter(None, (_bounds(kind) for kind in kinds)))
    reason = key.get("reason", "")
    return f"{bounds} ({reason})" if bounds and reason else bounds or reason


def _bounds(kind: Schema) -> str:
    if "enum" in kind:
        return ", ".join(f"`{choice}`" for choice in kind["enum"])
    if "const" in kind:
        return f"`{kind['const']}`"
    if kind.get("type") == "boolean":
        return "`true`, `false`"
    if entries := kind.get("prefixItems"):
        each = [_bounds(entry) for entry in entries]
        return each[0] and (f"each {each[0]}" if len(set(each)) == 1 else f"the first {each[0]}")
    if "minimum" in kind and "maximum" in kind:
        return f"{_value(kind['minimum'])} to {_value(kind['maximum'])}"
    signs = (("exclusiveMinimum", ">"), ("minimum", "≥"), ("exclusiveMaximum", "<"), ("maximum", "≤"))
    return ", ".join(f"{sign} {_value(kind[name])}" for name, sign in signs if name in kind)


def _paragraphs(section: Schema) -> str:
    return "\n\n".join(" ".join(block.split()) for block in section["description"].split("\n\n")) + "\n"


def _sections(key: Schema, schema: Schema) -> list[Schema]:
    """The sections that a key holds: one, one an entry, or one of several kinds an entry; none of a plain key."""
    holder = key.get("items", key) if key.get("type") == "array" else key
    references = [each["$ref"] for each in holder.get("oneOf", [holder]) if "$ref" in each]
    return [schema["$defs"][reference.rsplit("/", 1)[1]] for reference in references]
