"""A point of a trade by itself: its scene, as the trade ran it, and the folder of a run of it.

A trade keeps the figures of its points, not their maps. The same scene with the same seed gives the same maps again.
"""

from __future__ import annotations

import tomllib
from pathlib import Path
from typing import Any

from ..errors import InputError
from ..io.opening import read_json
from ..io.scenefile import apply_overrides
from ..scene import Scene, scene_of
from ..studies.point import MANIFEST
from .safety import Roots, safe_name
from .trading import Point, shown_unit_of
from .words import label_of


def scene_of_point(folder: Path, point: Point, roots: Roots) -> Scene:
    """That the trade ran at a point. InputError where the trade's own scene cannot be read, or is refused."""
    try:
        told: Any = read_json(folder / MANIFEST, below=folder)
        tree = tomllib.loads(str(told["scene"]))
    except (OSError, ValueError, KeyError, TypeError, RecursionError):
        raise InputError(f"{folder.name}: its {MANIFEST} cannot be read; the point cannot be run again") from None
    whole = apply_overrides(tree, {**point.keys, "seed": point.seed})
    roots.check_files(whole)
    return scene_of(whole)


def folder_of_point(trade: str, point: Point) -> str:
    """Where a run of a point goes: beside the trade, by its values and its seed."""
    values = "_".join(f"{key.rsplit('.', 1)[-1]}={value}" for key, value in point.keys.items())
    return f"{trade}_{safe_name(values, 'point')}_seed={point.seed}"


def words_of_point(point: Point) -> str:
    """A point in words: its values with their units, and its seed."""
    told = ", ".join(
        f"{label_of(key)[:1].lower()}{label_of(key)[1:]} {value} {shown_unit_of(key)}".strip()
        for key, value in point.keys.items()
    )
    return f"{told}, seed {point.seed}"
