"""The runs in a folder: what each is, which of its files the page gives away; and the place where they are listed."""

from __future__ import annotations

import asyncio
import os
import time
from dataclasses import dataclass
from functools import partial
from pathlib import Path
from typing import TYPE_CHECKING, Any
from urllib.parse import quote

from fastapi import FastAPI
from fastapi.responses import FileResponse, PlainTextResponse, Response
from nicegui import ui

from ..errors import InputError
from ..io.opening import LONG, read_json
from ..io.process import duration
from ..io.scenefile import read_toml
from ..io.turn_files import part_of
from .jobs import Job
from .safety import is_text, unreadable_product
from .uploads import RecordingsPanel
from .widgets import flat_button, round_button

if TYPE_CHECKING:
    from .page import Page, ServerState


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
    """Of a product of a run, by the run's name."""
    return f"/files/{quote(run)}/{name}"


def products_of(folder) -> list[str]:
    """The files of a folder that may be downloaded."""
    return [name for name in PRODUCTS if (folder / name).is_file()]


_LOOK_S = 0.4
_STATES = {
    "queued": ("schedule", "waits"),
    "running": ("sailing", "runs"),
    "done": ("check_circle", "done"),
    "cancelled": ("cancel", "cancelled"),
    "failed": ("error", "failed"),
}


class RunsView:
    """Jobs above, results below. Looks again while something runs."""

    def __init__(self, page: Page) -> None:
        self.page, self.queue = page, page.server.queue
        self._shown: tuple[tuple[str, str], ...] | None = None
        self._rows: dict[str, _Row] = {}
        ui.label("Queue").classes("text-base font-bold")
        self._jobs = ui.column().classes("w-full gap-1").mark("jobs")
        self._recordings: RecordingsPanel | None = None
        self._recorded = ui.expansion("Recorded echoes", on_value_change=self._opened)
        self._recorded.classes("w-full section").props("dense").mark("recordings")
        with ui.row().classes("w-full items-center"):
            ui.label("Results").classes("text-base font-bold")
            ui.label(f"in {page.server.roots.runs}").classes("text-xs opacity-80 break-all")
            round_button("Refresh the list", icon="refresh", on_click=self._find)
        self._results = ui.column().classes("w-full gap-1").mark("results")
        ui.timer(_LOOK_S, self._look)

    def _opened(self, event: Any) -> None:
        """What takes recordings, made when it is first wanted."""
        if event.value and self._recordings is not None:
            self._recordings.fill()
        elif event.value:
            with self._recorded:
                self._recordings = RecordingsPanel(self.page)

    async def enter_async(self) -> None:
        self._look()
        await self._find()

    def enter(self) -> None:
        """MapPanels again."""
        ui.timer(0.01, self.enter_async, once=True)

    def _look(self) -> None:
        """The jobs as they are now; the rows are made anew only where their states have changed."""
        jobs = self.queue.jobs()
        states = tuple((job.name, job.state) for job in jobs)
        if states != self._shown:
            ended = self._shown and any(job.over for job in jobs)
            self._shown = states
            self._jobs.clear()
            with self._jobs:
                self._rows = {job.name: _Row(self.page, job) for job in jobs}
                if not jobs:
                    ui.label("Nothing waits. Choose a scene in Design and press Run.").classes("text-sm opacity-80")
            if ended:
                ui.timer(0.01, self._find, once=True)
        for job in jobs:
            if not job.over:
                self._rows[job.name].update(job)

    async def _find(self) -> None:
        entries = await asyncio.to_thread(find_runs, self.page.server.roots.runs)
        self._results.clear()
        with self._results:
            for entry in entries:
                self._entry(entry)
            if not entries:
                ui.label("No results yet: what runs here, or was run into this folder, is listed.").classes(
                    "text-sm opacity-80"
                )

    def _entry(self, entry: RunEntry) -> None:
        folder = self.page.server.roots.runs / entry.name
        with (
            ui.card().classes("w-full p-2 gap-0").props("flat bordered"),
            ui.row().classes("w-full items-center gap-2"),
        ):
            with ui.column().classes("gap-0 grow min-w-0"):
                ui.label(f"{entry.name} · {entry.kind}").classes("font-bold text-sm break-all")
                ui.label(f"{_when(entry.when)}{f' · {entry.title}' if entry.title else ''}").classes(
                    "text-xs opacity-80"
                )
                if entry.headline:
                    ui.label(entry.headline).classes("text-sm")
            if entry.kind == "simulation":
                again = flat_button("Retrieve", icon="travel_explore", on_click=lambda: self._retrieve(entry.name))
                again.props["aria-label"] = f"Retrieve {entry.name}"
            see = flat_button("See", icon="visibility", on_click=lambda: open_folder(self.page, entry.name, entry.kind))
            see.mark(f"see-{entry.name}").props["aria-label"] = f"See {entry.name}"
            with round_button("Download", icon="download"), ui.menu():
                for name in products_of(folder):
                    ui.menu_item(name, on_click=partial(ui.navigate.to, address(entry.name, name), new_tab=True))

    def _retrieve(self, name: str) -> None:
        """Maps from the echoes of a simulation, in a folder beside it."""
        folder = self.page.server.free_folder(f"{name}-maps")
        echoes = self.page.server.roots.run(name) / "echoes.zarr"
        self.queue.add(f"maps from the echoes of {name}", folder, "", ["retrieve", str(echoes), "--out", "{out}"])


def open_folder(page: Page, name: str, kind: str | None) -> None:
    """A folder of results where it is seen: a trade in its own place, all else in See."""
    if kind == "trade":
        page.tab.trade = name
        page.go("Trade")
    else:
        page.see(name)


class _Row:
    """One job: its name, a bar, a line, a button."""

    def __init__(self, page: Page, job: Job) -> None:
        self.page = page
        icon, words = _STATES[job.state]
        with ui.card().classes("w-full p-2 gap-1").props("flat bordered").mark(f"job-{job.folder}"):
            with ui.row().classes("w-full items-center gap-2 no-wrap"):
                ui.icon(icon).classes("text-xl")
                with ui.column().classes("gap-0 grow min-w-0"):
                    ui.label(f"{job.folder} · {words}").classes("font-bold text-sm break-all")
                    ui.label(job.title).classes("text-xs opacity-80")
                    self._line = ui.label(job.reason).classes("text-sm").props("role=status")
                if not job.over:
                    cancel = ui.button("Cancel", on_click=lambda: page.server.queue.cancel(job.name))
                    cancel.props("flat dense no-caps").mark(f"cancel-{job.folder}")
                else:
                    forget = partial(page.server.queue.forget, job.name)
                    round_button("Remove from the list; results stay", icon="close", on_click=forget)
                if job.state != "queued":
                    kind = "trade" if job.words[0] == "trade" else None
                    see = ui.button("See", icon="visibility", on_click=lambda: open_folder(page, job.folder, kind))
                    see.props("dense no-caps")
            if not job.over:
                self._bar = ui.linear_progress(0.0, show_value=False).props('aria-label="Progress" rounded size=8px')

    def update(self, job: Job) -> None:
        """How far it is."""
        now = self.page.server.queue.progress(job)
        self._bar.value = round(now.share, 3)
        left = "" if now.left_s is None else f" · about {duration(now.left_s)} left"
        stopping = " · stopping: whole turns stay" if job.reason else ""
        self._line.set_text(f"{now.line}{left}{stopping}")


def _when(then: float) -> str:
    return time.strftime("%Y-%m-%d %H:%M", time.localtime(then))
