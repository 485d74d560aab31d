"""What the keys of a scene are: name, unit, default, limit and meaning of each, by section, from the JSON schema.

The command `keys`, the scene that `starting` writes and the manual of all keys say what stands here. The manual, with
the shipped scenes' titles:

    python -m seamap_rt.scene.keys > scenes/README.md
"""

from __future__ import annotations

import difflib
from collections.abc import Callable, Iterable, Iterator, Mapping
from dataclasses import dataclass, replace
from typing import Any, NamedTuple

from ..errors import InputError
from ..io.scenefile import list_shipped, read_toml
from ..io.text import toml_string
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
    if found := _select_keys(every, lambda key, _: key == wanted):
        return found
    word = wanted.casefold()
    if word and (found := _select_keys(every, lambda key, meaning: word in key or word in meaning.casefold())):
        return found
    names = [each.path for each in every if each.path]
    names += [_key(each, name) for each in every for name in (each.tag, *(row.name for row in each.rows)) if name]
    near = difflib.get_close_matches(wanted, names, 3)
    near = near or [each for each in names if difflib.get_close_matches(wanted, [each.rsplit(".", 1)[-1]], 1, 0.75)][:3]
    hint = f"did you mean {' or '.join(near)}?" if near else f"the sections are {', '.join(s.path for s in every[1:])}"
    raise InputError(f"KEY = {toml_string(text)}: no key, section or word of them; {hint}")


def _select_keys(sections: Iterable[KeySection], wanted: Callable[[str, str], bool]) -> list[KeySection]:
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
    inner = {name: key for name, key in keys.items() if sections_of(key, schema)}
    plain = {name: key for name, key in keys.items() if name not in inner}
    rows = tuple(_row(name, key, name in section.get("required", ())) for name, key in plain.items())
    about = "\n\n".join(" ".join(block.split()) for block in section["description"].split("\n\n")) + "\n"
    yield KeySection(path, many, meaning, about, rows)
    for name, key in inner.items():
        sections, listed = sections_of(key, schema), key.get("type") == "array"
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
    return KeyRow(name, key["unit"] or "", default, limit_of(key), key["description"])


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


def limit_of(key: Schema, write: Callable[[Any], str] = _value) -> str:
    """Choices or bounds, and in brackets the reason of the bounds. write: how a number is written."""
    kinds = [kind for kind in key.get("anyOf", [key]) if kind.get("type") != "null"]
    bounds = " or ".join(filter(None, (_bounds(kind, write) for kind in kinds)))
    reason = key.get("reason", "")
    return f"{bounds} ({reason})" if bounds and reason else bounds or reason


def _bounds(kind: Schema, write: Callable[[Any], str]) -> str:
    if "enum" in kind:
        return ", ".join(f"`{choice}`" for choice in kind["enum"])
    if "const" in kind:
        return f"`{kind['const']}`"
    if kind.get("type") == "boolean":
        return "`true`, `false`"
    if entries := kind.get("prefixItems"):
        each = [_bounds(entry, write) for entry in entries]
        return each[0] and (f"each {each[0]}" if len(set(each)) == 1 else f"the first {each[0]}")
    if "minimum" in kind and "maximum" in kind:
        return f"{write(kind['minimum'])} to {write(kind['maximum'])}"
    signs = (("exclusiveMinimum", ">"), ("minimum", "≥"), ("exclusiveMaximum", "<"), ("maximum", "≤"))
    return ", ".join(f"{sign} {write(kind[name])}" for name, sign in signs if name in kind)


def sections_of(key: Schema, schema: Schema) -> list[Schema]:
    """The sections that a key holds: one, one an entry, or one of several kinds an entry; none of a plain key."""
    holder = key.get("items", key) if key.get("type") == "array" else key
    references = [each["$ref"] for each in holder.get("oneOf", [holder]) if "$ref" in each]
    return [schema["$defs"][reference.rsplit("/", 1)[1]] for reference in references]


_INTRODUCTION = """\
# Scene files

A scene file holds all that a run depends on: sea, radar, boat, objects, how finely to trace and how to retrieve. It is
[TOML](https://toml.io): tables in brackets, a key and a value a line. Only `name` is needed; a key that is left out has
the default below. Unknown keys, values beyond their limits and keys that contradict each other are refused all at once,
each in one line that names key, value, limit and remedy.

`seamap-rt new mine.toml` writes a scene to begin with, its keys explained; `--like NAME` takes any shipped one as the
pattern, so `--like solid_state_chirp`. `seamap-rt keys` prints the tables below, `keys radar.antenna` one section of
them, `keys radar.height_m` one key, and `keys height` all keys in whose names or meanings the word stands.
A scene may be as short as this:

```toml
name = "mine"

[sea]
extent_m = 512.0

[[sea.waves]]                    # a wave system; two of these tables are a wind sea and a swell
spectrum = "jonswap"
significant_wave_height_m = 1.0
peak_period_s = 5.0
wave_from_deg = 240.0

[radar]
height_m = 8.0
range_m = [20.0, 200.0]
```

`seamap-rt run mine.toml` runs it, `seamap-rt run choppy_sea` a shipped one by its name. `--set` changes keys:

```sh
seamap-rt run choppy_sea --set radar.height_m=10 --set 'radar.range_m=[15,200]' --set sea.waves.0.peak_period_s=6
```

- A key of `--set` is its section and name with dots; entries of a list of tables are numbered from 0. The value is read
  as TOML (`6`, `true`, `[15,200]`, `inf`), else as text, so `--set radar.transmit=single` needs no quotes. Python takes
  the same by `load_scene("choppy_sea", {"radar.height_m": 10.0})`.
- Paths of files count from the scene file's folder, those of `--set` from the working folder.
- Keys that belong to a switch which is off (`adc_bits` with `chain = "baseband"`, `roll_period_s` with
  `motion = "fixed"`) are ignored.
- Keys end with their unit (`_m`, `_s`, `_deg`, `_hz`, `_db` …). Directions are in degrees clockwise from north.
- A run writes the scene with every key resolved, `scene.toml`; run again, it gives the same bits.
- `Scene.model_json_schema()` holds all that the tables below hold, for forms and editors. JSON has no infinity: there
  `inf` is a text.
"""

_KEYS = """\
Units are SI or as given; 1 is a plain number. A default in words says what holds where the key is left out. The limit's
reason stands in brackets. This page is written from the settings by `python -m seamap_rt.scene.keys`.
"""


def manual() -> str:
    """The whole page, in Markdown."""
    shipped = [f"| `{name}` | {read_toml(path).get('title', '')} |" for name, path in list_shipped().items()]
    lines = [_INTRODUCTION, "## Shipped scenes\n", "| scene | shows |", "|---|---|", *shipped, ""]
    lines += ["## Keys\n", _KEYS]
    lines += [line for section in key_sections() for line in _section_lines(section)]
    return "\n".join(lines).rstrip("\n") + "\n"


def _section_lines(section: KeySection) -> Iterator[str]:
    """A section's heading, what it is, and the table of its keys."""
    yield f"### {section.heading}\n"
    if section.kinds:
        yield f"{section.meaning}\n"
        yield f"| `{section.tag}` | is | keys |\n|---|---|---|"
        for kind in section.kinds:
            names = ", ".join(f"`{name}`" for name in kind.keys) or "—"
            yield f"| `{kind.name}` | {kind.meaning} | {names} |"
        yield ""
    else:
        yield section.about
    if section.rows:
        yield "| key | unit | default | limit | meaning |\n|---|---|---|---|---|"
        for row in section.rows:
            of = f" Of {', '.join(f'`{kind}`' for kind in row.kinds)}." if row.kinds else ""
            yield f"| `{row.name}` | {row.unit} | {row.default} | {row.limit} | {row.meaning}{of} |"
        yield ""


if __name__ == "__main__":
    print(manual(), end="")
