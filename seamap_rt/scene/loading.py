"""Scene files and shipped scenes, with keys overridden and the paths of their files made absolute."""

from __future__ import annotations

import os
import tomllib
from collections.abc import Mapping
from pathlib import Path
from typing import Any

from ..errors import must_be
from ..io import scenefile
from ..io.validation import Key, validate, without
from .model import Scene

SceneLike = Scene | str | os.PathLike[str]  # a scene, the path of its file, or a shipped one's name


def load_scene(path_or_name: str | os.PathLike[str], overrides: Mapping[str, Any] | None = None) -> Scene:
    """The scene of a file, or a shipped one by its name, with keys overridden.

    path_or_name: "mine.toml" or "choppy_sea". overrides: as {"radar.height_m": 10.0}.

    Files that a scene names count from the scene file's folder, those of overrides from the working folder. Raises
    InputError with whatever is wrong with the file or the scene: its `problems`, and its message, have a line for each.
    """
    if overrides is not None:
        must_be("overrides", overrides, Mapping, 'a dict of keys, such as {"radar.height_m": 10.0}')
    path = scenefile.find_scene(path_or_name)
    return _overridden(anchored(scenefile.read_toml(path), path.parent), overrides or {})


def with_keys(scene: Scene, overrides: Mapping[str, Any]) -> Scene:
    """The scene with keys overridden, as `load_scene` overrides those of its file; raises as it does."""
    return _overridden(tomllib.loads(scene.to_toml()), overrides)


def _overridden(tree: dict[str, Any], overrides: Mapping[str, Any]) -> Scene:
    for key, other in (("energy_fraction", "resolution_m"), ("resolution_m", "energy_fraction")):
        # Either sets the resolution: the one that is overridden takes the other's place in the file.
        replaces = overrides.get(f"sea.{key}") is not None and f"sea.{other}" not in overrides
        if replaces and isinstance(tree.get("sea"), dict):
            tree["sea"].pop(other, None)
    tree = anchored(scenefile.apply_overrides(tree, overrides), Path.cwd())
    return scene_of(tree)


def scene_of(tree: Mapping[str, Any]) -> Scene:
    """The scene of a tree whose paths are absolute (`anchored`). InputError as `load_scene` raises it."""
    return validate(Scene, _with_recorded(tree), _further)


def _with_recorded(tree: Mapping[str, Any]) -> Mapping[str, Any]:
    """The tree with what it leaves out of a recorded sea, by its file."""
    sea = tree.get("sea")
    if not isinstance(sea, Mapping) or sea.get("model") != "recorded":
        return tree
    if not isinstance(sea.get("file"), str) or not sea["file"]:
        return tree
    from ..io.recorded_sea import recorded_sea

    file = recorded_sea(sea["file"])
    known: dict[str, Any] = {
        "extent_m": max(round(2.0 * file.reach_m, 3), 10.0),
        "waves": [{"spectrum": "file", "kind": "recorded", "file": sea["file"]}],
    }
    if sea.get("energy_fraction") is None:
        known["resolution_m"] = file.spacing_m
    if file.depth_m is not None:
        known["depth_m"] = file.depth_m
    given = {name: value for name, value in sea.items() if name != "waves" or value}  # none is left out
    return {**tree, "sea": {**known, **given}}


def _further(tree: Mapping[str, Any], wrong: frozenset[Key]) -> list[str]:
    """What is wrong between the sections of a scene with wrong keys, as far as it can be found without them."""
    from .agreement import disagreements  # loads what computes

    return disagreements(without(Scene, tree, wrong), whole=False)


def as_scene(scene: SceneLike) -> Scene:
    """A scene as it is, or that of a file or of a shipped scene's name. Raises InputError as `load_scene` does."""
    if isinstance(scene, Scene):
        return scene
    must_be("scene", scene, (str, os.PathLike), "a Scene, the name of a shipped one, or the path of a scene file")
    return load_scene(scene)


def anchored(tree: dict[str, Any], folder: Path) -> dict[str, Any]:
    """The tree with the paths of its files (`file`, `mesh`) made absolute, so that it means the same everywhere."""
    for key, value in tree.items():
        for table in value if isinstance(value, list | tuple) else [value]:
            if isinstance(table, dict):
                anchored(table, folder)
        if key in ("file", "mesh") and isinstance(value, str) and value and "\0" not in value:  # that is refused later
            tree[key] = str((folder / value).resolve())
    return tree
