"""The manual of all keys, scenes/README.md, written from the JSON schema of `Scene` and the shipped scenes' titles.

python -m seamap_rt.scene.reference > scenes/README.md
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from typing import Any

from ..io.scenefile import list_shipped, read_toml
from .model import Scene

Schema = Mapping[str, Any]

_INTRODUCTION = """\
# Scene files

A scene file holds all that a run depends on: sea, radar, boat, objects, how finely to trace and how to retrieve. It is
[TOML](https://toml.io): tables in brackets, a key and a value a line. Only `name` is needed; a key that is left out has
the default below. An unknown key, a value beyond its limit or keys that contradict each other are refused in one line
that names key, value, limit and remedy. To make a scene of your own, copy `choppy_sea.toml`, which writes nearly every
key out.

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
reason stands in brackets. This page is written from the settings by `python -m seamap_rt.scene.reference`.
"""


def manual() -> str:
    """The whole page, in Markdown."""
    schema = Scene.model_json_schema()
    shipped = [f"| `{name}` | {read_toml(path).get('title', '')} |" for name, path in list_shipped().items()]
    lines = [_INTRODUCTION, "## Shipped scenes\n", "| scene | shows |", "|---|---|", *shipped, ""]
    lines += ["## Keys\n", _KEYS]
    lines += _section("top of the file", schema, schema)
    return "\n".join(lines).rstrip("\n") + "\n"


def _section(title: str, section: Schema, schema: Schema) -> Iterator[str]:
    """A section's tables, then those of the sections in it."""
    yield f"### {title}\n"
    yield _paragraphs(section)
    inner = {name: key for name, key in section["properties"].items() if _sections(key, schema)}
    if plain := {name: key for name, key in section["properties"].items() if name not in inner}:
        yield from _table(_row(name, key, name in section.get("required", ())) for name, key in plain.items())
    above = "" if title == "top of the file" else title.strip("[]") + "."
    for name, key in inner.items():
        sections, many = _sections(key, schema), key.get("type") == "array"
        heading = f"[[{above}{name}]]" if many else f"[{above}{name}]"
        if len(sections) > 1:
            yield from _kinds(heading, key, sections)
        else:
            yield from _section(heading, _own(sections[0]), schema)


def _own(section: Schema) -> Schema:
    """Without keys that stand in another section, whose values they take when left out."""
    keys = {name: key for name, key in section["properties"].items() if not _is_that_of_another(key)}
    return {**section, "properties": keys}


def _is_that_of_another(key: Schema) -> bool:
    return key.get("left_out", "").startswith("that of ")


def _kinds(title: str, key: Schema, sections: list[Schema]) -> Iterator[str]:
    """Sections of which one key says which it is: what each is and which keys it has, and one table of them all."""
    tag = key["items"]["discriminator"]["propertyName"]
    yield f"### {title}\n"
    yield f"{key['description']}\n"
    yield f"| `{tag}` | is | keys |\n|---|---|---|"
    rows: dict[str, dict[str, list[str]]] = {}
    for section in sections:
        kind, keys = section["properties"][tag]["const"], [name for name in section["properties"] if name != tag]
        names = ", ".join(f"`{name}`" for name in keys) or "—"
        yield f"| `{kind}` | {' '.join(section['description'].split())} | {names} |"
        for name in keys:
            row = _row(name, section["properties"][name], name in section.get("required", ()))
            rows.setdefault(name, {}).setdefault(row, []).append(kind)
    yield ""
    yield from _table(
        row if len(variants) == 1 else f"{row.removesuffix(' |')} Of {', '.join(f'`{kind}`' for kind in kinds)}. |"
        for variants in rows.values()
        for row, kinds in variants.items()
    )


def _table(rows: Iterator[str]) -> Iterator[str]:
    yield "| key | unit | default | limit | meaning |\n|---|---|---|---|---|"
    yield from rows
    yield ""


def _row(name: str, key: Schema, needed: bool) -> str:
    default = "needed" if needed else _default(key)
    return f"| `{name}` | {_unit(key['unit'])} | {default} | {_limit(key)} | {key['description']} |"


def _unit(unit: str | None) -> str:
    return "" if unit is None else unit


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
        return f"[{', '.join(_value(each) for each in value)}]"
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


if __name__ == "__main__":
    print(manual(), end="")
