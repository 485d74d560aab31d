"""A scene while it is edited, and its form without the page: sections and fields from `Scene.model_json_schema()`."""

from __future__ import annotations

import copy
import re
import shlex
import tomllib
from collections.abc import Iterator, Mapping
from dataclasses import dataclass
from functools import cache, partial
from typing import Any

from ..errors import InputError, one_line
from ..io.scenefile import find_scene, list_shipped, read_toml, tree_to_toml
from ..io.text import toml_value
from ..io.validation import without
from ..report.keys import label_of, section_label, shown_unit, shown_value
from ..scene import Scene, anchored, scene_of
from ..scene.keys import limit_of, sections_of
from .folders import Roots

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
    choices: tuple[str | bool, ...]
    default: str
    optional: bool
    help: str


@dataclass(frozen=True)
class Part:
    """A section of the form. many: it is an entry of a list, and may be deleted."""

    path: str
    label: str
    fields: tuple[Field, ...]
    many: bool = False


@dataclass(frozen=True)
class ListSection:
    """A list of sections to which one may be added. tag, kinds: the key that says which of several kinds it is."""

    path: str
    label: str
    tag: str
    kinds: tuple[str, ...]


@cache
def scene_schema() -> Schema:
    """The JSON schema of `Scene`."""
    return Scene.model_json_schema()


def parts_of(tree: Mapping[str, Any]) -> list[Part]:
    """All sections of the form, in the scene file's order; a list of tables has a part for each entry of the tree."""
    return list(_parts(scene_schema(), "", tree))


@cache
def list_sections() -> list[ListSection]:
    """The lists of tables that a scene has."""
    return list(_array_sections(scene_schema(), ""))


def _array_sections(section: Schema, path: str) -> Iterator[ListSection]:
    for name, key in section["properties"].items():
        below = _join(path, name)
        inner = sections_of(key, scene_schema())
        if not inner:
            continue
        if key.get("type") == "array":
            tag = _tag_of(key)
            kinds = tuple(each["properties"][tag]["const"] for each in inner) if tag else ()
            yield ListSection(below, section_label(below), tag, kinds)
        else:
            yield from _array_sections(inner[0], below)


def _tag_of(key: Schema) -> str:
    """The key that says which of several kinds an entry of a list is; empty where there is one kind."""
    return key["items"].get("discriminator", {}).get("propertyName", "")


def _parts(section: Schema, path: str, tree: Any, many: bool = False) -> Iterator[Part]:
    held = tree if isinstance(tree, Mapping) else {}
    inner = {name: key for name, key in section["properties"].items() if sections_of(key, scene_schema())}
    fields = tuple(
        _field(_join(path, name), key, name in section.get("required", ()))
        for name, key in section["properties"].items()
        if name not in inner and not ("const" in key and name != "spectrum")
    )
    yield Part(path, section_label(path), fields, many)
    for name, key in inner.items():
        below = _join(path, name)
        if key.get("type") != "array":
            yield from _parts(sections_of(key, scene_schema())[0], below, held.get(name))
            continue
        entries = held.get(name)
        for index, entry in enumerate(entries if isinstance(entries, list | tuple) else ()):
            yield from _parts(_kind_of(key, entry), f"{below}.{index}", entry, many=True)


def _kind_of(key: Schema, entry: Any) -> Schema:
    """The section of a list's entry: of several kinds the one that its tag names, the first where it names none."""
    kinds, tag = sections_of(key, scene_schema()), _tag_of(key)
    named = entry.get(tag) if tag and isinstance(entry, Mapping) else None
    return next((each for each in kinds if named and each["properties"][tag]["const"] == named), kinds[0])


def _field(path: str, key: Schema, required: bool) -> Field:
    kinds = [kind for kind in key.get("anyOf", [key]) if kind.get("type") != "null"]
    types = {kind.get("type") for kind in kinds}
    choices: tuple[str | bool, ...] = ()
    default = key.get("default")
    optional = not required and default is None
    leaf = path.rsplit(".", 1)[-1]
    if leaf in ("file", "mesh"):
        kind = "file"
    elif leaf == "spectrum":
        kind, choices = "choice", next(each.kinds for each in list_sections() if each.tag == "spectrum")
    elif any("enum" in each for each in kinds):
        kind, choices = "choice", tuple(kinds[0]["enum"])
    elif "boolean" in types:
        kind, choices = ("choice", (True, False)) if optional else ("switch", ())
    elif "array" in types:
        kind = "list"
    elif types & {"number", "integer"}:
        kind = "number"
    else:
        kind = "text"
    unit = shown_unit(path, key.get("unit"))
    placeholder = "needed" if required else (key.get("left_out", "") if default is None else shown_value(path, default))
    return Field(path, kind, label_of(path), unit, choices, placeholder, optional, _help(path, key, kind))


def _help(path: str, key: Schema, kind: str) -> str:
    """Limits are in the unit that the form shows."""
    limit = limit_of(key, partial(shown_value, path)) if kind in ("number", "list") else key.get("reason", "")
    unit = shown_unit(path, key.get("unit"))
    limits = f" Limits{f' ({unit})' if unit else ''}: {limit}." if limit else ""
    return f"{key.get('description', '')}{limits} Key: {path}".replace("`", "")


def _join(path: str, name: str) -> str:
    return f"{path}.{name}" if path else name


MOST_TOML = 2**20  # bytes of a scene file that is taken
_MOST_UNDO = 200
_REFUSED = re.compile(r"^([A-Za-z_][\w.-]*?)(?: = .*?)?: ", re.DOTALL)
_WORD = re.compile(r"[A-Za-z_]\w*", re.ASCII)
Tree = dict[str, Any]


class Draft:
    """A scene that is being edited. It may be wrong: then `scene` is None and `refused` says where and why.

    name: of the shipped scene or the file where it began.
    """

    def __init__(self, tree: Mapping[str, Any], name: str, roots: Roots, known: Scene | None = None) -> None:
        """known: the scene of the tree, where it is known to stand."""
        self.name, self.roots = name, roots
        self._base: Tree = copy.deepcopy(dict(tree))
        self.tree: Tree = copy.deepcopy(self._base)
        self._before: list[Tree] = []
        self.scene: Scene | None = known
        self.refused: dict[str, str] = {}  # by key, "" of none: the command line's own words
        if known is None:
            self._check()

    @classmethod
    def shipped(cls, name: str, roots: Roots) -> Draft:
        """A shipped scene. InputError for a name that is none."""
        if name not in list_shipped():
            raise InputError(f"{name}: not a shipped scene; shipped are {', '.join(list_shipped())}")
        path = find_scene(name)
        tree = anchored(read_toml(path), path.parent)
        # That its sections agree is tested; to ask again loads the models, a second in which nobody could type.
        return cls(tree, name, roots, without(Scene, tree, frozenset()))

    @classmethod
    def of_toml(cls, text: str | bytes, roots: Roots, name: str = "scene.toml") -> Draft:
        """A scene from TOML; files that it names count from the uploads. InputError for what is no TOML; a scene that
        is refused may be mended in the form."""
        raw = text if isinstance(text, bytes) else text.encode("utf-8", "replace")
        if len(raw) > MOST_TOML:
            raise InputError(f"{name}: has more than {MOST_TOML / 2**20:.0f} MB; a scene file has a few kilobytes")
        try:
            tree = tomllib.loads(raw.decode("utf-8-sig"))
        except (ValueError, RecursionError) as error:
            raise InputError(f"{name}: is not TOML: {error}; mend that line of the scene file") from None
        return cls(anchored(tree, roots.uploads), name, roots)

    # ------------------------------------------------------------------------------------------------- reading

    def value(self, key: str) -> Any:
        """What holds of a key: of the whole scene where it stands, else as it is written; None where it is left out."""
        if self.scene is not None:
            node: Any = self.scene
            for step in key.split("."):
                node = _entry(node, int(step)) if step.isdecimal() else getattr(node, step, None)
            if node is not None:
                return node
        return self.tree_value(key)

    def tree_value(self, key: str) -> Any:
        """The value that the scene's tree has for a key; None where it leaves the key out."""
        return _node_at(self.tree, key)

    @property
    def changes(self) -> dict[str, Any]:
        """Keys that differ from where the scene began, with their new values; None for one that was taken out."""
        now, then = dict(flatten(self.tree)), dict(flatten(self._base))
        return {key: now.get(key) for key in {**now, **then} if now.get(key) != then.get(key)}

    # ------------------------------------------------------------------------------------------------- editing

    def set(self, key: str, value: Any) -> None:
        """Change a key, or leave it out with None."""
        tree = copy.deepcopy(self.tree)
        above, _, leaf = key.rpartition(".")
        node = _make_table(tree, above)
        if value is None:
            node.pop(leaf, None)
        else:
            node[leaf] = value
        self._take_tree(tree)

    def add(self, path: str, tag: str = "", kind: str = "") -> None:
        """Add a table to a list of tables, with what each must have."""
        tree = copy.deepcopy(self.tree)
        above, _, leaf = path.rpartition(".")
        entries = _make_table(tree, above).setdefault(leaf, [])
        entry = ({tag: kind} if tag else {}) | copy.deepcopy(_NEW.get(kind if tag else path, {}))
        if "name" in entry:
            entry["name"] = f"{entry['name']}{len(entries) + 1}"
        entries.append(entry)
        self._take_tree(tree)

    def remove(self, path: str) -> None:
        """Take an entry out of a list of tables."""
        tree = copy.deepcopy(self.tree)
        above, index = path.rsplit(".", 1)
        del _node_at(tree, above)[int(index)]
        self._take_tree(tree)

    def kind(self, path: str, tag: str, kind: str) -> None:
        """Make an entry another of several kinds: it keeps the keys that both have."""
        tree = copy.deepcopy(self.tree)
        entry = _node_at(tree, path)
        before, trial = dict(entry), {tag: kind, **_NEW.get(kind, {})}
        entry.clear()
        entry.update(trial)
        allowed = {each.key.rsplit(".", 1)[-1] for part in parts_of(tree) if part.path == path for each in part.fields}
        kept = {name: value for name, value in before.items() if name in allowed and name != tag}
        if set(kept) & {"significant_wave_height_m", "wind_speed_m_s"}:  # its size is given already
            for name in _SIZES:
                entry.pop(name, None)
            if kind == "elfouhaily":
                entry["wind_speed_m_s"] = 8.0
        entry.update(kept)
        self._take_tree(tree)

    def undo(self) -> bool:
        """Take the last change back; whether there was one."""
        if not self._before:
            return False
        self.tree = self._before.pop()
        self._check()
        return True

    def _take_tree(self, tree: Tree) -> None:
        if tree != self.tree:
            self._before = [*self._before[-_MOST_UNDO:], self.tree]
            self.tree = tree
            self._check()

    def _check(self) -> None:
        try:
            self.roots.check_files(self.tree)
            self.scene, lines = scene_of(self.tree), ()
        except InputError as refusal:
            self.scene, lines = None, refusal.problems
        except (TypeError, AttributeError, RecursionError) as error:
            self.scene, lines = None, (one_line(f"the scene: {error}"),)
        self.refused = {}
        for line in lines:
            found = _REFUSED.match(line)
            self.refused.setdefault(found[1] if found else "", line)

    # ------------------------------------------------------------------------------------------------- elsewhere

    def toml(self) -> str:
        """The whole scene with every key, or where it is refused what is written of it."""
        return self.scene.to_toml() if self.scene is not None else tree_to_toml(self.tree)

    def command(self) -> str:
        """The line that runs the same scene in a shell: a shipped one with its changes, else a saved file."""
        lists, then = ([part.path for part in parts_of(tree) if part.many] for tree in (self.tree, self._base))
        gone = any(value is None for value in self.changes.values())
        if self.name not in list_shipped() or gone or lists != then:  # `--set` adds no entry, and takes nothing out
            return "seamap-rt run scene.toml"
        settings = [f"--set {shlex.quote(f'{key}={_set_value(value)}')}" for key, value in self.changes.items()]
        return " ".join(["seamap-rt run", self.name, *settings])


_SIZES = ("significant_wave_height_m", "peak_period_s", "wind_speed_m_s", "fetch_m")
_SEA = {"significant_wave_height_m": 1.0, "peak_period_s": 6.0}
_NEW: dict[str, Tree] = {
    "jonswap": _SEA,
    "tma": _SEA,
    "pierson_moskowitz": _SEA,
    "sinusoid": {"height_m": 1.0, "wavelength_m": 50.0},
    "elfouhaily": {"wind_speed_m_s": 8.0},
    "file": {"file": ""},
    "gauges": {"name": "gauge", "ground_range_m": 80.0, "azimuth_deg": 270.0},
    "objects": {"mesh": "", "position_m": [0.0, 100.0, 0.0]},
    "radar.antennas": {"offset_m": [0.0, 0.0, 0.0]},
}


def _make_table(tree: Tree, path: str) -> Any:
    """The table at a path, made where there is none."""
    node: Any = tree
    for step in path.split(".") if path else ():
        node = node[int(step)] if isinstance(node, list) else node.setdefault(step, {})
    return node


def _node_at(tree: Any, key: str) -> Any:
    node = tree
    for step in key.split("."):
        if isinstance(node, list | tuple) and step.isdecimal():
            node = _entry(node, int(step))
        elif isinstance(node, Mapping):
            node = node.get(step)
        else:
            return None
    return node


def _entry(node: Any, index: int) -> Any:
    return node[index] if isinstance(node, list | tuple) and index < len(node) else None


def flatten(tree: Any, key: str = "") -> list[tuple[str, Any]]:
    if isinstance(tree, Mapping):
        return [pair for name, value in tree.items() for pair in flatten(value, f"{key}.{name}" if key else str(name))]
    if isinstance(tree, list) and any(isinstance(each, Mapping) for each in tree):
        return [pair for index, value in enumerate(tree) for pair in flatten(value, f"{key}.{index}")]
    return [(key, tree)]


def _set_value(value: Any) -> str:
    """A value as `--set` reads it: text that is a plain word needs no quotes."""
    word = isinstance(value, str) and _WORD.fullmatch(value) and value not in ("true", "false", "inf", "nan")
    return str(value) if word else toml_value(value)
