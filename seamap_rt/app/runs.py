"""The runs in a folder: what kind each is, how far it came, and what it says in a line."""

from __future__ import annotations

import os
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from ..errors import InputError
from ..io.opening import LONG, read_json
from ..io.scenefile import read_toml
from ..io.turn_files import part_of
from .safety import is_text, unreadable_product

_DEEPEST = 3
_MOST = 2000  # folders that are looked into
KINDS = {  # what wrote a folder: products of which all are there; the first that fits counts
    "trade": ("trade.json",),
    "shadowing": ("shadowing.nc",),
    "run": ("truth.nc", "maps.nc"),
    "retrieval": ("maps.nc",),
    "simulation": ("truth.nc",),
    "sea": ("sea.nc",),
    "forecast": ("prediction.nc",),
}
MAPPED = ("run", "retrieval", "simulation")  # kinds that are seen turn by turn


@dataclass(frozen=True)
class RunEntry:
    """A folder of results. name: relative to the runs. kind: of KINDS. when: Unix time."""

    name: str
    kind: str
    title: str
    when: float
    headline: str


def find_runs(runs: Path) -> list[RunEntry]:
    """All folders of results below the runs, the newest first."""
    found: list[RunEntry] = []
    for looked, (place, folders, files) in enumerate(os.walk(runs, followlinks=False), 1):
        there = {*files, *folders}
        depth = len(Path(place).relative_to(runs).parts)
        folders[:] = (
            []
            if depth >= _DEEPEST
            else sorted(
                each
                for each in folders
                if not each.startswith(".") and not each.endswith(".zarr") and each != "points" and is_text(each)
            )
        )
        entry = _entry(runs, Path(place), there)
        if entry is not None:
            found.append(entry)
        if looked >= _MOST:
            break
    return sorted(found, key=lambda each: each.when, reverse=True)


def kind_of(folder: Path, files: set[str] | None = None) -> str | None:
    """What wrote a folder; None for one that holds no results."""
    there = files if files is not None else {path.name for path in folder.iterdir()}
    for kind, products in KINDS.items():
        if all(product in there or part_of(folder / product).name in there for product in products):
            return kind
    return None


def _entry(runs: Path, folder: Path, files: set[str]) -> RunEntry | None:
    kind = kind_of(folder, files)
    if kind is None or folder == runs:
        return None
    if odd := unreadable_product(folder, lambda path: path.resolve().is_relative_to(runs.resolve())):
        return RunEntry(str(folder.relative_to(runs)), kind, "", folder.lstat().st_mtime, f"not read: {odd}")
    title = ""
    if "scene.toml" in files:
        try:
            title = str(read_toml(folder / "scene.toml").get("title", ""))
        except InputError:
            title = ""
    try:
        when = max((folder / name).stat().st_mtime for name in files)
    except OSError:
        return None
    return RunEntry(str(folder.relative_to(runs)), kind, title, when, headline_of(folder))


def headline_of(folder: Path) -> str:
    """A run's verdict, of its metrics; empty before they are there."""
    from ..report.headline import verdict  # takes a second

    try:
        metrics: Any = read_json(folder / "metrics.json", most=LONG)
        return verdict(metrics)
    except (OSError, ValueError, KeyError, TypeError, AttributeError):
        return ""


def free_name(runs: Path, wanted: str, taken: set[str]) -> str:
    """A folder's name that nobody has: the wanted one, or with a number."""
    number, name = 2, wanted
    while (runs / name).exists() or name in taken:
        name = f"{wanted}-{number}"
        number += 1
    return name
