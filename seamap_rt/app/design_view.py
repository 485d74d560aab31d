"""The place where a scene is chosen and changed: the form, what it is likely to do, and the way to run it."""

from __future__ import annotations

import asyncio
from importlib import import_module
from typing import TYPE_CHECKING

import numpy as np
from nicegui import events, ui

from ..errors import InputError
from ..io.scenefile import list_shipped, read_toml
from ..report.headline import radius_in_words
from . import drawing
from .draft import MOST_TOML, Draft
from .folders import safe_name
from .form import Form
from .page import Images, Page, choice, flat_button, make_stage, number, round_button, tile
from .uploads import save_upload

if TYPE_CHECKING:
    from ..scene import Scene
    from .prospects import Prospects


_GRID = "w-full grid gap-4 grid-cols-1 lg:grid-cols-[minmax(340px,27rem)_1fr] lg:grid-rows-[auto_1fr]"
_AFTER_S = 0.06  # so that figures are painted before graphs are drawn
_MOST_FILE = 32 * 2**20  # of a spectrum, a pattern, a motion or a mesh


class DesignView:
    """The form at the left, its consequences at the right; on a phone figures, form and graphs one below the other."""

    def __init__(self, page: Page) -> None:
        self.page, self.tab = page, page.tab
        self._models = False  # loaded, of what a design is likely to do
        starts = {name: f"{name}: {read_toml(path).get('title', '')}" for name, path in list_shipped().items()}
        with ui.row().classes("w-full items-center gap-2"):
            self._choice = choice("Begin with", "start", self._start, starts, value=None)
            ui.button("Run", icon="play_arrow", on_click=self._run).props("no-caps").mark("run")
            self._predict = ui.checkbox("forecast too").props("dense").mark("predict")
            flat_button("Undo", icon="undo", on_click=self._undo, mark="undo")
            flat_button("Keep to compare", icon="push_pin", on_click=self._pin, mark="pin")
            self._status = ui.label().classes("text-sm").props("role=status")
        self._answer = ui.label().classes("font-bold").mark("answer").props("aria-live=polite")
        with ui.element("div").classes(_GRID):
            tiles = ui.column().classes("w-full min-w-0 lg:col-start-2")
            with ui.column().classes("w-full gap-1 lg:col-start-1 lg:row-start-1 lg:row-span-2"):
                self._form_place = ui.column().classes("w-full gap-1")
                self._file = ui.expansion("Scene file and command line", on_value_change=self._show_file)
                self._file.classes("w-full section").props("dense").mark("file")
            graphs = ui.column().classes("w-full min-w-0 lg:col-start-2")
        self.prospects = ProspectsView(page, self._answer, tiles, graphs)
        self._new_form()

    async def enter(self) -> None:
        """Work out the consequences anew."""
        self._show_consequences()

    def take_over(self) -> None:
        """The draft was changed from elsewhere."""
        self.form.rebuild()
        self._show_consequences()

    # ------------------------------------------------------------------------------------------------- the scene

    def _start(self) -> None:
        if self._choice.value != self.tab.draft.name:
            self._take_draft(Draft.shipped(self._choice.value, self.page.server.roots))

    def _take_draft(self, draft: Draft) -> None:
        self.tab.draft = draft
        self._new_form()

    def _new_form(self) -> None:
        self._form_place.clear()
        with self._form_place:
            self.form = Form(self.tab.draft, self._show_consequences)
        name = self.tab.draft.name
        self._choice.value = name if name in list_shipped() else None
        self._show_consequences()

    def _undo(self) -> None:
        if self.tab.draft.undo():
            self.take_over()

    def _pin(self) -> None:
        draft = self.tab.draft
        if draft.scene is None:
            self._status.set_text("This design does not stand yet: mend what is marked first.")
            return
        changed = ", ".join(draft.changes) or "as shipped"
        self.tab.pinned = (f"{draft.name} ({changed})", draft.scene)
        self._status.set_text("Kept: the differences of what you change now are shown beside it.")
        self._show_consequences()

    def _show_consequences(self, _: str = "") -> None:
        """What it is likely to do now; what was asked of an older change is dropped."""
        self._show_file()
        scene = self.tab.draft.scene
        if scene is None:
            self.prospects.easel.drop("")
            self.prospects.refuse("This design is refused: mend what is marked, and its consequences follow.")
        else:
            self.prospects.easel.ask("drawing the graphs …", self._look_ahead(scene))

    def _show_file(self) -> None:
        """Update the file only while it is open: its colours take a tenth of a second."""
        if self._file.value:
            if not self._file.default_slot.children:
                with self._file:
                    self._make_file()
            self._command.set_text(self.tab.draft.command())
            self._toml.set_content(self.tab.draft.toml())

    async def _look_ahead(self, scene: Scene) -> None:
        """Consequences in a thread, graphs in a process."""
        if not self._models:  # the form first: while they load, nothing else is quick
            self._answer.set_text("Loading the models: what this design is likely to do follows in some seconds …")
            await self._answer.client.run_javascript("0", timeout=20.0)
            self._models = True
        models = await asyncio.to_thread(import_module, "seamap_rt.app.prospects")
        name, pinned = self.tab.pinned or ("", None)
        try:
            found = await asyncio.to_thread(models.prospects, scene)
            beside = await asyncio.to_thread(models.prospects, pinned) if pinned is not None else None
        except (ValueError, ArithmeticError, OSError) as error:
            self.prospects.refuse(f"No forecast of this design: {error}")
            return
        self.prospects.show(found, scene, beside, name)
        await asyncio.sleep(_AFTER_S)
        self.prospects.graphs.show(await drawing.quick(models.design_images, found, beside, scene, self.page.dark))
        self.prospects.easel.ready()
        await self.page.prepare()

    # ------------------------------------------------------------------------------------------------- as a file

    def _copy_command(self) -> None:
        ui.clipboard.write(self._command.text)

    def _make_file(self) -> None:
        ui.label("The same run on a command line:").classes("text-sm")
        with ui.row().classes("w-full no-wrap items-center"):
            self._command = ui.label().classes("font-mono text-xs break-all grow").mark("command")
            round_button("Copy the command", icon="content_copy", on_click=self._copy_command)
        with ui.row().classes("gap-2"):
            flat_button("Download", icon="download", on_click=self._save, mark="save")
            ui.upload(
                label="Load a scene (TOML), or a file that another needs beside it",
                auto_upload=True,
                max_file_size=_MOST_FILE,
                on_upload=self._take_upload,
                on_rejected=lambda: self._status.set_text("That file is too large: 32 MB at most."),
            ).classes("w-full").props("flat bordered").mark("upload")
        self._toml = ui.code("", language="toml").classes("w-full text-xs").mark("toml")

    def _save(self) -> None:
        name = f"{safe_name(str(self.tab.draft.tree_value('name') or 'scene'))}.toml"
        ui.download.content(self.tab.draft.toml(), name)

    async def _take_upload(self, event: events.UploadEventArguments) -> None:
        """A scene becomes the draft; any other file is kept, and its path said, to be named in a field."""
        name = safe_name(event.file.name)
        if event.file.size() > (MOST_TOML if name.endswith(".toml") else _MOST_FILE):
            self._status.set_text(f"{name}: is too large")
            return
        content = await event.file.read()
        try:
            if name.endswith(".toml"):
                self._take_draft(Draft.of_toml(content, self.page.server.roots, name))
                self._status.set_text(f"{name} is loaded.")
                return
            path = await asyncio.to_thread(save_upload, self.page.server.roots, "beside", name, content)
            self._status.set_text(f"Kept as {path}: name it in a field, or leave it beside the file that needs it.")
        except (InputError, OSError) as refusal:
            self._status.set_text(str(refusal))

    # -------------------------------------------------------------------------------------------------- running

    def _run(self) -> None:
        draft, server = self.tab.draft, self.page.server
        if draft.scene is None:
            self._status.set_text("This design does not stand yet: mend what is marked first.")
            return
        from .prospects import run_seconds

        scene = draft.scene
        folder = server.free_folder(f"{scene.name}-{scene.seed}")
        words: list[str] = ["run", "{scene}", "--out", "{out}", *(["--predict"] if self._predict.value else [])]
        changes = ", ".join(f"{key} = {value}" for key, value in list(draft.changes.items())[:4])
        title = (scene.title or scene.name) + (f" ({changes})" if changes else "")
        server.queue.add(title, folder, scene.to_toml(), words, run_seconds(scene))
        self.tab.run, self.tab.turn = folder, -1
        self._status.set_text(f"Queued as {folder}.")
        self.page.go("Runs")


_FIRST = ("reach", "radius", "error", "half_visible", "hs", "steepness", "across_100", "seconds")
COLOURS = {0: "", 1: "text-positive", -1: "text-negative"}  # of neither, better and worse


class ProspectsView:
    """Tiles and graphs of the design at hand; made once, and filled anew with each change. status: for the answer."""

    def __init__(self, page: Page, status: ui.label, tiles: ui.column, graphs: ui.column) -> None:
        self.page, self._status, self._places = page, status, (tiles, graphs)
        self._shown: dict[str, _Tile] = {}
        with tiles:
            self._tiles = ui.element("div").classes("w-full grid gap-2 grid-cols-2 sm:grid-cols-3 xl:grid-cols-4")
        with graphs:
            stage, self.easel = make_stage()
            with stage.classes("titled"):
                self.graphs = Images(small=True)
            self._more = ui.expansion("All figures").classes("w-full section").props("dense").mark("all-figures")

    def refuse(self, words: str) -> None:
        """Say why nothing is known of a design; the last one's figures stay, pale."""
        self._status.set_text(words)
        for each in self._places:
            each.classes(add="opacity-50")

    def show(self, found: Prospects, scene: Scene, beside: Prospects | None, name: str) -> None:
        """Fill all; beside: of the kept design, with its name."""
        for each in self._places:
            each.classes(remove="opacity-50")
        self._status.set_text(_sentence(found, scene) + (f" Beside it, dashed: {name}." if beside else ""))
        then = beside.values if beside else {}
        if set(self._shown) != {key for key, *_ in found.figures}:
            self._make_tiles(found)
        pace = self.page.server.queue.pace("run")
        self._shown["seconds"].words.set_text("A run takes about" if pace else "A run takes (guessed)")
        for key, _, value, _, digits, better in found.figures:
            scale = pace or 1.0 if key == "seconds" else 1.0
            before = then.get(key)
            self._shown[key].fill(scale * value, digits, None if before is None else scale * before, better)

    def _make_tiles(self, found: Prospects) -> None:
        self._shown.clear()
        self._tiles.clear()
        self._more.clear()
        with self._more:
            others = ui.element("div").classes("w-full grid gap-2 grid-cols-2 md:grid-cols-3")
        for key, words, _, unit, _, _ in found.figures:
            with self._tiles if key in _FIRST else others:
                self._shown[key] = _Tile(key, words, unit)


class _Tile:
    """One figure, and how far it is from the kept design's."""

    def __init__(self, key: str, words: str, unit: str) -> None:
        self.words, row = tile(words)
        with row:
            self._value = ui.label().classes("text-lg font-bold figure-value").mark(f"figure-{key}")
            ui.label(unit).classes("text-xs")
            self._change = ui.label().classes("text-xs figure-value").mark(f"change-{key}")

    def fill(self, value: float, digits: int, before: float | None, better: int) -> None:
        """better: 1 where more is, −1 where less is, 0 of neither."""
        self._value.set_text(number(value, digits))
        change = 0.0 if before is None else value - before
        if not abs(change) > 0.5 * 10.0**-digits:
            self._change.set_text("")
            return
        good = int(np.sign(change * better))
        sign = {0: "", 1: "▲ better ", -1: "▼ worse "}[good]
        self._change.set_text(f"{sign}{change:+.{digits}f}")
        self._change.classes(replace="text-xs figure-value").classes(COLOURS[good])


def _sentence(found: Prospects, scene: Scene) -> str:
    """What a boss reads."""
    values = found.values
    if not scene.sea.waves or values["hs"] <= 0.0:
        return "A flat sea: nothing hides, and nothing is there to be measured."
    if "reach" not in values:
        return found.why_not or "Nothing is known of this design before it is run."
    if values["reach"] <= 0.0:
        return "This radar would hardly measure this sea: its heights are no better than the mean level at any range."
    more = "more than " if found.ahead is not None and found.ahead.figures["reach_to_the_end"] else ""
    left = found.ahead.left_out if found.ahead is not None else ""
    error = f", their height to about ± {100.0 * values['error']:.0f} cm" if values.get("error", 0.0) > 0.0 else ""
    return (
        f"Likely to measure waves out to {more}{values['reach']:.0f} m{error}: {radius_in_words(values['radius'])}."
        + (f" Not counted: {left}." if left else "")
    )
