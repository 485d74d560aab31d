"""Folders of results: which the page may touch, what each is, and which of its files are given away."""

from __future__ import annotations

import os
import re
from collections.abc import Callable, Mapping
from contextlib import suppress
from dataclasses import dataclass
from functools import cached_property
from itertools import islice
from pathlib import Path
from typing import TYPE_CHECKING, Any
from urllib.parse import quote

from starlette.responses import FileResponse, PlainTextResponse, Response

from ..errors import InputError
from ..io.opening import LONG, check_file, read_json
from ..io.reading import results_exist
from ..io.scenefile import read_toml

if TYPE_CHECKING:
    from fastapi import FastAPI

    from .page import ServerState

_NO_TEXT = re.compile(r"[\x00-\x1f\x7f-\x9f\ud800-\udfff]")  # controls, and bytes that are no UTF-8
_FILE_KEYS = ("file", "mesh")  # of scenes, at any depth
_PRODUCTS = (".nc", ".json", ".toml", ".part", ".npz", ".txt")


@dataclass(frozen=True)
class Roots:
    """The folders below which the page may touch files: the first is that of the runs, into which it writes."""

    runs: Path
    others: tuple[Path, ...] = ()

    @cached_property
    def _resolved(self) -> tuple[Path, ...]:
        return tuple(each.resolve() for each in (self.runs, *self.others))

    @property
    def uploads(self) -> Path:
        """Where what is dropped onto the page goes."""
        return self.runs / ".uploads"

    def holds(self, path: str | Path) -> bool:
        """Whether a path, links followed, lies below one of the folders."""
        try:
            real = Path(path).resolve()
        except (OSError, ValueError, RuntimeError):
            return False
        return any(real.is_relative_to(root) for root in self._resolved)

    def run(self, name: str) -> Path:
        """The folder of a run by its name, relative to the runs. InputError for one that is not there."""
        folder = self.runs / name
        try:
            found = folder.is_dir() and folder.resolve().is_relative_to(self._resolved[0])
        except (OSError, ValueError, RuntimeError):
            found = False
        if not found:
            raise InputError(f"run = '{name}': no such folder in {self.runs}; choose one from the list")
        if odd := unreadable_product(folder, self.holds):
            raise InputError(f"run = '{name}': {odd}")
        return folder

    def check_files(self, tree: Any, key: str = "") -> None:
        """InputError for a scene that names a file elsewhere. Paths in it are absolute."""
        if isinstance(tree, Mapping):
            for name, value in tree.items():
                below = f"{key}.{name}" if key else str(name)
                if name in _FILE_KEYS and isinstance(value, str) and value and not self.holds(value):
                    raise InputError(
                        f"{below} = {value}: lies outside of the folders that this page may read; upload the file, or "
                        f"copy it below {self.runs}"
                    )
                self.check_files(value, below)
        elif isinstance(tree, list | tuple):
            for index, entry in enumerate(tree):
                self.check_files(entry, f"{key}.{index}")


def is_text(name: str) -> bool:
    """False for a name with letters that do not print, or in bytes that are no text: no browser can be given it."""
    return not _NO_TEXT.search(name)


def unreadable_product(folder: Path, holds: Callable[[Path], bool]) -> str:
    """Which of a folder's products nobody may read, in words: it is no regular file, or a link to a place that `holds`
    denies. Empty where all are as they should be."""
    with os.scandir(folder) as found:
        entries = list(found)
    for entry in entries:
        if entry.name.endswith(".zarr") and not holds(Path(entry.path)):
            return f"{entry.name}: links to a place that this page may not read; copy the folder"
        if entry.name.endswith(_PRODUCTS) and not entry.is_file(follow_symlinks=False):
            try:
                check_file(entry.path, "a result", named=entry.name)
            except InputError as refusal:
                return str(refusal)
            if not holds(Path(entry.path)):
                return f"{entry.name}: links to a place that this page may not read; copy the file"
    return ""


def safe_name(name: str, fallback: str = "upload") -> str:
    """The last part of a name that a browser gave, with letters that any file system takes."""
    last = name.replace("\\", "/").rsplit("/", 1)[-1]
    kept = "".join(letter if letter.isascii() and (letter.isalnum() or letter in "._+-") else "_" for letter in last)
    kept = kept.lstrip(".")[-100:]
    return kept or fallback


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
    found = []
    for place, folders, files in islice(os.walk(runs), _MOST):
        folder = Path(place)
        found.append(_entry(runs, folder, {*files, *folders}))
        deep = len(folder.relative_to(runs).parts) >= _DEEPEST
        folders[:] = [] if deep else sorted(filter(_may_hold_results, folders))
    return sorted(filter(None, found), key=lambda each: each.when, reverse=True)


def _may_hold_results(name: str) -> bool:
    return is_text(name) and name != "points" and not name.startswith(".") and not name.endswith(".zarr")


def kind_of(folder: Path, files: set[str] | None = None) -> str | None:
    """What wrote a folder; None for one that holds no results."""
    there = files if files is not None else {path.name for path in folder.iterdir()}
    for kind, products in KINDS.items():
        if all(product in there or results_exist(folder / product) for product in products):
            return kind
    return None


def _entry(runs: Path, folder: Path, files: set[str]) -> RunEntry | None:
    kind, name = kind_of(folder, files), str(folder.relative_to(runs))
    if kind is None or folder == runs:
        return None
    if odd := unreadable_product(folder, lambda path: path.resolve().is_relative_to(runs.resolve())):
        return RunEntry(name, kind, "", folder.lstat().st_mtime, f"not read: {odd}")
    title = ""
    if "scene.toml" in files:
        with suppress(InputError):
            title = str(read_toml(folder / "scene.toml").get("title", ""))
    try:
        when = max((folder / each).stat().st_mtime for each in files)
    except OSError:
        return None
    return RunEntry(name, kind, title, when, headline_of(folder))


def headline_of(folder: Path) -> str:
    """A run's verdict, of its metrics; empty before they are there."""
    from ..report.headline import verdict  # takes a second

    try:
        return verdict(read_json(folder / "metrics.json", most=LONG))
    except (OSError, ValueError, KeyError, TypeError, AttributeError):
        return ""


PRODUCTS = (  # that may be downloaded
    "report.html", "retrieval.html", "trade.html", "shadowing.html", "maps.nc", "truth.nc", "prediction.nc",
    "gauges.nc", "trade.nc", "shadowing.nc", "trade.csv", "shadowing.csv", "metrics.json", "scene.toml", "sea.nc",
    "statistics.txt", "from_mast.png", "sea_surface.png", "directional_spectrum.png", "sea.gif",
)  # fmt: skip


_OF_PAGES = (
    "sandbox allow-scripts; default-src 'none'; img-src data:; style-src 'unsafe-inline'; script-src 'unsafe-inline'"
)


def give_files(app: FastAPI, server: ServerState) -> None:
    """Adds the address `/files/RUN/NAME`."""

    @app.get("/files/{path:path}")
    def give(path: str) -> Response:
        run, _, name = path.rpartition("/")
        if name not in PRODUCTS or not run:
            return PlainTextResponse(f"no such product; there are {', '.join(PRODUCTS)}\n", 404)
        try:
            file = server.roots.run(run) / name
        except InputError as refusal:
            return PlainTextResponse(f"{refusal}\n", 404)
        if not file.is_file() or not server.roots.holds(file):
            return PlainTextResponse(f"{name}: not there yet\n", 404)
        shown = file.suffix == ".html"  # a page of ours; the others are saved
        headers = {"content-security-policy": _OF_PAGES} if shown else {}
        disposition = "inline" if shown else "attachment"
        saved = f"{run.replace('/', '_')}_{name}"
        return FileResponse(file, filename=saved, content_disposition_type=disposition, headers=headers)


def address(run: str, name: str) -> str:
    """The address of a product of a run, by the run's name."""
    return f"/files/{quote(run)}/{name}"


def products_of(folder: Path) -> list[str]:
    """The files of a folder that may be downloaded."""
    return [name for name in PRODUCTS if (folder / name).is_file()]
