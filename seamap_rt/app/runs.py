"""The runs in a folder: what kind each is, what it says in a line, and which of its files the page gives away."""

from __future__ import annotations

import os
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Any
from urllib.parse import quote

from fastapi import FastAPI
from fastapi.responses import FileResponse, PlainTextResponse, Response

from ..errors import InputError
from ..io.opening import LONG, read_json
from ..io.scenefile import read_toml
from ..io.turn_files import part_of
from .safety import is_text, unreadable_product

if TYPE_CHECKING:
    from .page import ServerState


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


PRODUCTS = {  # that may be downloaded, with their types; a page of ours is shown, the others are saved
    "report.html": "text/html; charset=utf-8",
    "retrieval.html": "text/html; charset=utf-8",
    "trade.html": "text/html; charset=utf-8",
    "shadowing.html": "text/html; charset=utf-8",
    "maps.nc": "application/x-netcdf",
    "truth.nc": "application/x-netcdf",
    "prediction.nc": "application/x-netcdf",
    "gauges.nc": "application/x-netcdf",
    "trade.nc": "application/x-netcdf",
    "shadowing.nc": "application/x-netcdf",
    "trade.csv": "text/csv; charset=utf-8",
    "shadowing.csv": "text/csv; charset=utf-8",
    "metrics.json": "application/json",
    "scene.toml": "text/plain; charset=utf-8",
    "sea.nc": "application/x-netcdf",
    "statistics.txt": "text/plain; charset=utf-8",
    "from_mast.png": "image/png",
    "sea_surface.png": "image/png",
    "directional_spectrum.png": "image/png",
    "sea.gif": "image/gif",
}


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
        kind = PRODUCTS[name]
        shown = kind.startswith("text/html")
        headers = (
            {
                "content-security-policy": "sandbox allow-scripts; default-src 'none'; img-src data:; "
                "style-src 'unsafe-inline'; script-src 'unsafe-inline'"
            }
            if shown
            else {}
        )
        disposition = "inline" if shown else "attachment"
        saved = f"{run.replace('/', '_')}_{name}"
        return FileResponse(
            file, media_type=kind, filename=saved, content_disposition_type=disposition, headers=headers
        )


def address(run: str, name: str) -> str:
    """Of a product of a run, by the run's name."""
    return f"/files/{quote(run)}/{name}"


def products_of(folder) -> list[str]:
    """What of a folder may be downloaded."""
    return [name for name in PRODUCTS if (folder / name).is_file()]
