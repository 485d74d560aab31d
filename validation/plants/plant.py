"""One planted error, and the tree into which it is planted."""

from __future__ import annotations

import shutil
from pathlib import Path
from typing import NamedTuple

ROOT = Path(__file__).resolve().parents[2]
_PARTS = "seamap_rt", "tests", "validation", "scenes", "pyproject.toml"
CASE = "case "  # begins a judge that is a validation case


class Plant(NamedTuple):
    """`old` stands in `file` once; with `new` in its place, `judge` must fail.

    judge: a pytest node from the root of the repository, or "case NAME", a case of `seamap-rt validate --only`.
    """

    name: str
    file: str
    old: str
    new: str
    judge: str


def fault_of(plant: Plant, root: Path = ROOT) -> str:
    """What is wrong with the row itself, in words; empty if it can be planted."""
    path = root / plant.file
    if not path.is_file():
        return f"{plant.file}: there is no such file"
    count = path.read_text(encoding="utf-8").count(plant.old)
    if count != 1:
        return f"{plant.file}: old text is there {count} times, must be once"
    if plant.old == plant.new:
        return "old and new text are the same"
    return ""


def copy_tree(folder: Path, root: Path = ROOT) -> Path:
    """Copies what a judge needs into a folder, without caches and figures; returns the copy's root."""
    copy = folder / "tree"
    ignored = shutil.ignore_patterns("__pycache__", ".*", "figures")
    for part in _PARTS:
        source = root / part
        if source.is_dir():
            shutil.copytree(source, copy / part, ignore=ignored)
        else:
            shutil.copy2(source, copy / part)
    return copy
