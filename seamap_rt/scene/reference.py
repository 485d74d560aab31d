"""The manual of all keys, scenes/README.md, written from the JSON schema of `Scene` and the shipped scenes' titles.

python -m seamap_rt.scene.reference > scenes/README.md
"""

from __future__ import annotations

from collections.abc import Iterator

from ..io.scenefile import list_shipped, read_toml
from .keys import KeyRow, KeySection, key_sections

_INTRODUCTION = """\
# Scene files

A scene file holds all that a run depends on: sea, radar, boat, objects, how finely to trace and how to retrieve. It is
[TOML](https://toml.io): tables in brackets, a key and a value a line. Only `name` is needed; a key that is left out has
the default below. Unknown keys, values beyond their limits and keys that contradict each other are refused all at once,
in a line each that names key, value, limit and remedy.

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
reason stands in brackets. This page is written from the settings by `python -m seamap_rt.scene.reference`.
"""


def manual() -> str:
    """The whole page, in Markdown."""
    shipped = [f"| `{name}` | {read_toml(path).get('title', '')} |" for name, path in list_shipped().items()]
    lines = [_INTRODUCTION, "## Shipped scenes\n", "| scene | shows |", "|---|---|", *shipped, ""]
    lines += ["## Keys\n", _KEYS]
    lines += [line for section in key_sections() for line in _section(section)]
    return "\n".join(lines).rstrip("\n") + "\n"


def _section(section: KeySection) -> Iterator[str]:
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
        yield from (_row(row) for row in section.rows)
        yield ""


def _row(row: KeyRow) -> str:
    of = f" Of {', '.join(f'`{kind}`' for kind in row.kinds)}." if row.kinds else ""
    return f"| `{row.name}` | {row.unit} | {row.default} | {row.limit} | {row.meaning}{of} |"


if __name__ == "__main__":
    print(manual(), end="")
