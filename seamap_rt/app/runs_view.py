"""The place where runs are listed: what waits and what runs, recorded echoes to be retrieved, and all results."""

from __future__ import annotations

import asyncio
import time
from functools import partial
from pathlib import Path
from typing import Any

from nicegui import ui

from ..errors import InputError
from ..io.process import duration
from .folders import RunEntry, address, find_runs, products_of, safe_name
from .jobs import Job
from .page import Page, choice, flat_button, round_button
from .uploads import KINDS, MB, list_uploads, upload_button

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
        with ui.expansion("Recorded echoes").classes("w-full section").props("dense").mark("recordings"):
            self._recordings = RecordingsPanel(page)
        with ui.row().classes("w-full items-center"):
            ui.label("Results").classes("text-base font-bold")
            ui.label(f"in {page.server.roots.runs}").classes("text-xs opacity-80 break-all")
            round_button("Refresh the list", icon="refresh", on_click=self._find)
        self._results = ui.column().classes("w-full gap-1").mark("results")
        ui.timer(_LOOK_S, self._look)

    async def enter(self) -> None:
        """Look at the queue and the folders again."""
        self._recordings.fill()
        await self._look()
        await self._find()

    async def _look(self) -> None:
        """The jobs as they are now; the rows are made anew only where their states have changed."""
        jobs = self.queue.jobs()
        states = tuple((job.name, job.state) for job in jobs)
        if states != self._shown:
            ended = self._shown and any(job.is_over for job in jobs)
            self._shown = states
            self._jobs.clear()
            with self._jobs:
                self._rows = {job.name: _Row(self.page, job) for job in jobs}
                if not jobs:
                    ui.label("Nothing waits. Choose a scene in Design and press Run.").classes("text-sm opacity-80")
            if ended:
                await self._find()
        for job in jobs:
            if job.name in self._rows and not job.is_over:
                self._rows[job.name].update(job)

    async def _find(self) -> None:
        entries = await asyncio.to_thread(find_runs, self.page.server.roots.runs)
        self._results.clear()
        with self._results:
            for entry in entries:
                self._add_entry(entry)
            if not entries:
                nothing = ui.label("No results yet: what runs here, or was run into this folder, is listed.")
                nothing.classes("text-sm opacity-80")

    def _add_entry(self, entry: RunEntry) -> None:
        with (
            ui.card().classes("w-full p-2 gap-0").props("flat bordered"),
            ui.row().classes("w-full items-center gap-2"),
        ):
            with ui.column().classes("gap-0 grow min-w-0"):
                ui.label(f"{entry.name} · {entry.kind}").classes("font-bold text-sm break-all")
                when = time.strftime("%Y-%m-%d %H:%M", time.localtime(entry.when))
                ui.label(f"{when}{f' · {entry.title}' if entry.title else ''}").classes("text-xs opacity-80")
                if entry.headline:
                    ui.label(entry.headline).classes("text-sm")
            if entry.kind == "simulation":
                again = flat_button("Retrieve", icon="travel_explore", on_click=lambda: self._retrieve(entry.name))
                again.props["aria-label"] = f"Retrieve {entry.name}"
            see = flat_button("See", icon="visibility", on_click=lambda: open_folder(self.page, entry.name, entry.kind))
            see.mark(f"see-{entry.name}").props["aria-label"] = f"See {entry.name}"
            with round_button("Download", icon="download"), ui.menu():
                offer_products(self.page.server.roots.runs / entry.name, entry.name)

    def _retrieve(self, name: str) -> None:
        """Maps from the echoes of a simulation, in a folder beside it."""
        folder = self.page.server.free_folder(f"{name}-maps")
        echoes = self.page.server.roots.run(name)
        self.queue.add(f"maps from the echoes of {name}", folder, "", ["retrieve", str(echoes), "--out", "{out}"])


def offer_products(folder: Path, name: str) -> None:
    """Fill a menu with what may be downloaded of a folder, whose name among the runs is given."""
    for product in products_of(folder):
        ui.menu_item(product, on_click=partial(ui.navigate.to, address(name, product), new_tab=True))


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
        self._queue = page.server.queue
        icon, words = _STATES[job.state]
        with ui.card().classes("w-full p-2 gap-1").props("flat bordered").mark(f"job-{job.folder}"):
            with ui.row().classes("w-full items-center gap-2 no-wrap"):
                ui.icon(icon).classes("text-xl")
                with ui.column().classes("gap-0 grow min-w-0"):
                    ui.label(f"{job.folder} · {words}").classes("font-bold text-sm break-all")
                    ui.label(job.title).classes("text-xs opacity-80")
                    self._line = ui.label(job.reason).classes("text-sm").props("role=status")
                if not job.is_over:
                    cancel = ui.button("Cancel", on_click=partial(self._queue.cancel, job.name))
                    cancel.props("flat dense no-caps").mark(f"cancel-{job.folder}")
                else:
                    forget = partial(self._queue.forget, job.name)
                    round_button("Remove from the list; results stay", icon="close", on_click=forget)
                if job.state != "queued":
                    kind = "trade" if job.words[0] == "trade" else None
                    see = ui.button("See", icon="visibility", on_click=lambda: open_folder(page, job.folder, kind))
                    see.props("dense no-caps")
            if not job.is_over:
                self._bar = ui.linear_progress(0.0, show_value=False).props('aria-label="Progress" rounded size=8px')

    def update(self, job: Job) -> None:
        """How far it is."""
        now = self._queue.progress(job)
        self._bar.value = round(now.share, 3)
        left = "" if now.left_s is None else f" · about {duration(now.left_s)} left"
        stopping = " · stopping: whole turns stay" if job.reason else ""
        self._line.set_text(f"{now.line}{left}{stopping}")


class RecordingsPanel:
    """Two files, and what is wanted of them."""

    def __init__(self, page: Page) -> None:
        self.page = page
        roots = page.server.roots
        with ui.column().classes("w-full gap-2 pb-2"):
            most = f"{KINDS['recording'].most / MB:.0f} MB"
            ui.label(
                "Two complex arrays, lower and upper (pulse, gate), with time and azimuth, and a header that says what "
                f"radar it was. Files of more than {most}: copy them into {roots.uploads}, and open this place again."
            ).classes("text-sm break-words")
            with ui.element("div").classes("w-full grid gap-2 grid-cols-1 md:grid-cols-2"):
                self._recording = self._choice("recording", "Recording")
                self._header = self._choice("header", "Header, where the recording has none")
            self._names = ui.input("Arrays under other names", placeholder="lower=rx/1, upper=rx/2")
            self._names.props("dense outlined stack-label").classes("w-full")
            self._names.tooltip(
                "Arrays are lower, upper, time, azimuth, and others that the program's own README names"
            )
            with ui.row().classes("w-full items-center gap-2"):
                ui.button("Retrieve", icon="travel_explore", on_click=self._retrieve).props(
                    'no-caps aria-label="Retrieve the recording"'
                ).mark("retrieve")
                self._wrong = ui.checkbox("even if the inspection finds it surely wrong").props("dense")
                flat_button("Download a header to fill in", icon="download", on_click=_download_header)
            self._status = ui.label().classes("text-sm").props("role=status").mark("recording-status")

    def _choice(self, kind: str, label: str) -> Any:
        """A list of what is there, and a button for more."""
        with ui.row().classes("w-full items-center no-wrap gap-1"):
            made = choice(label, f"choose-{kind}", width="all", clearable=kind == "header")

            def take_upload(path: Path) -> None:
                self.fill()
                made.value = str(path)

            names = self._other_names if kind == "recording" else dict
            upload_button(self.page.server.roots, kind, lambda line: self._status.set_text(line), take_upload, names)
        return made

    def fill(self) -> None:
        """What is there to be chosen."""
        for kind, made in (("recording", self._recording), ("header", self._header)):
            there = {str(each): each.name for each in list_uploads(self.page.server.roots, kind)}
            made.set_options(there, value=made.value if made.value in there else None)

    def _other_names(self) -> dict[str, str]:
        """InputError for what is no name of an array."""
        from ..io.recorded import ARRAYS

        chosen: dict[str, str] = {}
        for each in filter(None, (part.strip() for part in (self._names.value or "").split(","))):
            array, equals, name = (part.strip() for part in each.partition("="))
            if array not in ARRAYS or not equals or not name:
                raise InputError(f"{each}: must be ARRAY=NAME, where ARRAY is one of {', '.join(ARRAYS)}")
            chosen[array] = name
        return chosen

    def _retrieve(self) -> None:
        """Queue it, and go where it is seen."""
        server, recording = self.page.server, self._recording.value
        if not recording:
            self._status.set_text("Choose a recording, or upload one.")
            return
        words = ["retrieve", str(recording)]
        words += ["--header", str(self._header.value)] if self._header.value else []
        try:
            words += [word for array, name in self._other_names().items() for word in ("--name", f"{array}={name}")]
        except InputError as refusal:
            self._status.set_text(str(refusal))
            return
        words += ["--even-if-wrong"] if self._wrong.value else []
        folder = server.free_folder(safe_name(Path(recording).stem, "recording"))
        server.queue.add(f"maps from {Path(recording).name}", folder, "", [*words, "--out", "{out}"])
        self.page.see(folder)


def _download_header() -> None:
    ui.download.content(blank_header(), "header.toml")


def blank_header() -> str:
    """The keys that a header must have, each with its meaning, and those that it may have, as remarks."""
    from ..io.recording_header import RecordingHeader

    schema = RecordingHeader.model_json_schema()
    needed = schema["required"]
    lines = ["# What a recording's arrays do not say. Fill in what is needed; the other keys may stay remarks.", ""]
    for name in (*needed, *(each for each in schema["properties"] if each not in needed)):
        key = schema["properties"][name]
        unit, left = key.get("unit") or "", key.get("left_out")
        if "description" in key:
            comment = f"{key['description']}{f' [{unit}]' if unit not in ('', '1') else ''}"
            lines.append(f"# {comment}{f' Left out: {left}.' if left else ''}")
        lines.append(f"{'' if name in needed else '# '}{name} = ")
    return "\n".join(lines) + "\n"
