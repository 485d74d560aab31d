"""The form of a scene, made from `Scene.model_json_schema()`: its sections, their fields, which of them matter."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from dataclasses import dataclass
from functools import cache
from typing import Any

from ..report.keys import label_of, section_label, shown_unit, shown_value
from ..scene import Scene

Schema = Mapping[str, Any]


@dataclass(frozen=True)
class Field:
    """One key of a scene as a form shows it.

    key: dotted, as `--set` takes it. kind: number, list (of numbers), choice, switch, text or file. default: as it is
    shown, or in words what holds where the key is left out. help: meaning, limits, reason and the key itself.
    """

    key: str
    kind: str
    label: str
    unit: str
    choices: tuple[str, ...]
    default: str
    optional: bool
    help: str


@dataclass(frozen=True)
class Part:
    """A section of the form. many: it is an entry of a list, and may be deleted."""

    path: str
    label: str
    help: str
    fields: tuple[Field, ...]
    many: bool = False


@dataclass(frozen=True)
class Growing:
    """A list of sections to which one may be added. tag, kinds: the key that says which of several kinds it is."""

    path: str
    label: str
    tag: str
    kinds: tuple[str, ...]


@cache
def scene_schema() -> Schema:
    """Of `Scene`."""
    return Scene.model_json_schema()


def parts_of(tree: Mapping[str, Any]) -> list[Part]:
    """All sections of the form, in the scene file's order; a list of tables has a part for each entry of the tree."""
    schema = scene_schema()
    return list(_parts(schema, schema, "", tree, many=False))


def growing_lists() -> list[Growing]:
    """The lists of tables that a scene has."""
    return list(_growing(scene_schema(), ""))


def _growing(section: Schema, path: str) -> Iterator[Growing]:
    for name, key in section["properties"].items():
        below = _join(path, name)
        inner = _sections(key)
        if not inner:
            continue
        if key.get("type") == "array":
            tag = key["items"].get("discriminator", {}).get("propertyName", "")
            kinds = tuple(each["properties"][tag]["const"] for each in inner) if tag else ()
            yield Growing(below, section_label(below), tag, kinds)
        else:
            yield from _growing(inner[0], below)


def _parts(section: Schema, schema: Schema, path: str, tree: Any, many: bool) -> Iterator[Part]:
    held = tree if isinstance(tree, Mapping) else {}
    inner = {name: key for name, key in section["properties"].items() if _sections(key)}
    fields = tuple(
        _field(_join(path, name), key, name in section.get("required", ()))
        for name, key in section["properties"].items()
        if name not in inner and not ("const" in key and name != "spectrum")
    )
    yield Part(path, section_label(path), _first_paragraph(section.get("description", "")), fields, many)
    for name, key in inner.items():
        below = _join(path, name)
        if key.get("type") != "array":
            yield from _parts(_sections(key)[0], schema, below, held.get(name), many=False)
            continue
        entries = held.get(name)
        for index, entry in enumerate(entries if isinstance(entries, list | tuple) else ()):
            yield from _parts(_kind_of(key, entry), schema, f"{below}.{index}", entry, many=True)


def _kind_of(key: Schema, entry: Any) -> Schema:
    """The section of a list's entry: of several kinds the one that its tag names, the first where it names none."""
    kinds = _sections(key)
    tag = key["items"].get("discriminator", {}).get("propertyName")
    if tag is None or not isinstance(entry, Mapping):
        return kinds[0]
    return next((each for each in kinds if each["properties"][tag]["const"] == entry.get(tag)), kinds[0])


def _sections(key: Schema) -> list[Schema]:
    """The sections that a key holds: one, one an entry, or one of several kinds an entry; none of a plain key."""
    holder = key.get("items", key) if key.get("type") == "array" else key
    references = [each["$ref"] for each in holder.get("oneOf", [holder]) if "$ref" in each]
    return [scene_schema()["$defs"][reference.rsplit("/", 1)[1]] for reference in references]


def _field(path: str, key: Schema, required: bool) -> Field:
    kinds = [kind for kind in key.get("anyOf", [key]) if kind.get("type") != "null"]
    choices: tuple[str, ...] = ()
    leaf = path.rsplit(".", 1)[-1]
    if leaf in ("file", "mesh"):
        kind = "file"
    elif leaf == "spectrum":
        kind, choices = "choice", next(each.kinds for each in growing_lists() if each.tag == "spectrum")
    elif any("enum" in each for each in kinds):
        kind, choices = "choice", tuple(kinds[0]["enum"])
    elif any(each.get("type") == "boolean" for each in kinds):
        kind = "switch"
    elif any(each.get("type") == "array" for each in kinds):
        kind = "list"
    elif any(each.get("type") in ("number", "integer") for each in kinds):
        kind = "number"
    else:
        kind = "text"
    default = key.get("default")
    unit = shown_unit(path, key.get("unit"))
    told = "needed" if required else (key.get("left_out", "") if default is None else shown_value(path, default))
    optional = not required and default is None
    return Field(path, kind, label_of(path), unit, choices, told, optional, _help(path, key, kinds))


def _help(path: str, key: Schema, kinds: list[Schema]) -> str:
    words = [key.get("description", "").replace("`", "")]
    bounds = " or ".join(filter(None, map(_bounds, kinds)))
    reason = key.get("reason", "")
    unit = key.get("unit") or ""
    if bounds:
        words.append(
            f"Limits: {bounds}{f' {unit}' if unit not in ('', '1') else ''}{f' ({reason})' if reason else ''}."
        )
    return " ".join([*words, f"Key: {path}"])


def _bounds(kind: Schema) -> str:
    if entries := kind.get("prefixItems"):
        return _bounds(entries[0])
    signs = (("exclusiveMinimum", ">"), ("minimum", "≥"), ("exclusiveMaximum", "<"), ("maximum", "≤"))
    return ", ".join(f"{sign} {kind[name]:g}" for name, sign in signs if name in kind)


def _first_paragraph(text: str) -> str:
    return " ".join(text.split("\n\n", 1)[0].split()).replace("`", "")


def _join(path: str, name: str) -> str:
    return f"{path}.{name}" if path else name
