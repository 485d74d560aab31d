"""The place where a run is looked at: maps, section, curves, forecast and the sea itself, a turn at a time."""

from __future__ import annotations

import asyncio
import time
from collections.abc import Callable, Coroutine
from functools import partial
from pathlib import Path
from typing import Any

import numpy as np
from nicegui import ui

from ..conventions import turn_name, wrap_degrees
from ..errors import InputError
from . import drawing
from .folders import MAPPED, find_runs, headline_of, kind_of, products_of
from .forecast_view import ForecastPanel, IssuesPanel
from .maps_panel import MapsPanel
from .page import Page, choice, count_on, flat_button, make_stage, round_button, slider
from .panels import RangePanel, SectionPanel, ShadowingPanel, turn_csv, turn_png
from .runs_view import offer_products
from .sea_view import PicturedPanel, SeaPanel
from .source import MAP_VIEWS, Results, Source
from .waves_view import GaugePanel, HelmPanel, StatePanel

VIEWS = {
    **MAP_VIEWS,
    "section": "Section",
    "range": "By range",
    "state": "Sea state",
    "gauges": "Gauges",
    "forecast": "Forecast",
    "helm": "Helm",
    "sea": "3-D",
}
_LOOK_S, _PLAY_S = 0.4, 0.05


class SeeView:
    """One run, its turns and its views."""

    def __init__(self, page: Page) -> None:
        self.page, self.tab = page, page.tab
        self.source: Source | None = None
        self._turns: list[int] = []
        self._looking = self._playing = False
        self._azimuth: float | None = None
        self._shown_key: tuple[Any, ...] = ()
        self._study = ""  # a folder without turns that is shown
        self._products: list[str] = []  # that may be downloaded
        self._kinds: dict[str, str] = {}
        with ui.row().classes("w-full items-center gap-2"):
            self._choice = choice("Run", "run-choice", self._choose)
            with flat_button("Download", icon="download", mark="export"):
                self._menu = ui.menu()
            self._status = ui.label().classes("text-sm").props("role=status")
        self._headline = ui.label().classes("font-bold").mark("verdict")
        with ui.row().classes("w-full items-center gap-2 no-wrap") as self._controls:
            self._button = ui.button(icon="play_arrow", on_click=self._toggle).props('dense round aria-label="Play"')
            self._button.mark("play")
            for icon, step, words in (("skip_previous", -1, "Turn before"), ("skip_next", 1, "Next turn")):
                round_button(words, icon=icon, on_click=partial(self._step, step))
            self._slider = slider("Turn", "turn", lambda: self._go_to_turn(int(self._slider.value or 1) - 1))
            self._clock = ui.label().classes("text-sm figure-value whitespace-nowrap").mark("clock")
        self._views: Any = ui.tabs().props("dense no-caps outside-arrows mobile-arrows align=left")
        with self._views:
            for name, words in VIEWS.items():
                ui.tab(name, words).mark(f"view-{name}")
        self._views.value = self.tab.view
        self._views.classes("w-full").on_value_change(self._choose_view)
        self._empty = ui.label().classes("text-sm p-4")
        stage, self.easel = make_stage()
        with stage:
            with ui.column().classes("w-full min-w-0") as self._maps_place:
                self.maps = MapsPanel(page, self._cut_section)
            self._curves_place = ui.column().classes("w-full min-w-0")
            self._study_place = ui.column().classes("w-full min-w-0")
        ui.timer(_LOOK_S, self._look)
        ui.timer(_PLAY_S, self._play)

    # ------------------------------------------------------------------------------------------------- the run

    async def enter(self) -> None:
        """Look for runs again, and open the one that is wanted."""
        entries = await asyncio.to_thread(find_runs, self.page.server.roots.runs)
        queued = [job.folder for job in self.page.server.queue.jobs() if job.words[0] != "trade"]
        self._kinds = {entry.name: entry.kind for entry in entries}
        names: list[str] = list(dict.fromkeys([*([self.tab.run] if self.tab.run else []), *queued, *self._kinds]))
        mapped = (name for name in names if self._kinds.get(name, "run") in MAPPED)
        self.tab.run = self.tab.run or next(mapped, "") or next(iter(names), "")
        kinds = {name: self._kinds.get(name, "run") for name in names}
        options = {name: name if kind == "run" else f"{name} · {kind}" for name, kind in kinds.items()}
        self._choice.set_options(options, value=self.tab.run or None)
        if not names:
            self._explain("No run yet. Choose a scene in Design and press Run; its maps appear here, turn by turn.")
        self._forget()
        await self._look()

    def _choose(self) -> None:
        name = self._choice.value
        if self._kinds.get(name) == "trade":
            self._choice.value = self.tab.run
            self.tab.trade = name
            self.page.go("Trade")
        elif name != self.tab.run:
            self.tab.run, self.tab.turn, self._azimuth = name, -1, None
            self._forget()

    def _forget(self) -> None:
        """What is shown, so that it is opened anew."""
        self.source, self._study, self._shown_key, self._products = None, "", (), []
        self._headline.set_text("")
        self._clock.set_text("")
        self.easel.drop(f"opening {self.tab.run} …" if self.tab.run else "")

    async def _look(self) -> None:
        """Whether the run has more turns than before; it is opened when the first is there."""
        if self.tab.place != "See" or not self.tab.run or self._looking:
            return
        self._looking = True
        try:
            await self._look_at(self.tab.run)
        finally:
            self._looking = False

    async def _look_at(self, run: str) -> None:
        try:
            if self.source is None:
                folder = self.page.server.roots.run(run)
                if self._is_study(folder):
                    return
                opened = await asyncio.to_thread(_open_source, folder)
                if run != self.tab.run:  # another was chosen meanwhile
                    return
                if opened is None:
                    self._show_waiting()
                    return
                self.source = opened
                self._fill_menu()
            source = self.source
            turns = await asyncio.to_thread(source.results.turns)
            if source is not self.source or self.easel.busy:  # a run that grows waits for what is drawn
                return
        except (InputError, OSError, KeyError, IndexError) as refusal:
            if run == self.tab.run:
                self.source = None
                self._show_waiting(str(refusal))
            return
        products = products_of(self.source.results.folder)
        if products != self._products and not self.source.results.growing:
            self._products = products
            self._headline.set_text(headline_of(self.source.results.folder))
            self._fill_menu()
        if turns != self._turns or not self._shown_key:
            at_end = self.tab.turn < 0 or self.tab.turn >= len(self._turns) - 1
            self._turns = turns
            count_on(self._slider, len(turns))
            self._go_to_turn(len(turns) - 1 if at_end else min(self.tab.turn, len(turns) - 1))

    def _is_study(self, folder: Path) -> bool:
        """Whether a folder has no turns but is shown all the same; then it is."""
        if self._study == self.tab.run:
            return True
        kind, job = kind_of(folder), self.page.server.queue.job_of_folder(self.tab.run)
        if kind not in _STUDIES or (job is not None and not job.is_over):
            return False
        self._study = self.tab.run
        self._fill_menu()
        self._study_place.clear()
        with self._study_place:
            panel = _STUDIES[kind](self)
        self._place_shown(self._study_place)
        self.draw_study(panel.show_folder(folder))
        return True

    def draw_study(self, shown: Coroutine[Any, Any, None]) -> None:
        """A drawing of the folder without turns that is shown."""
        name = self._study
        self.easel.ask(f"drawing {name} …", shown, lambda error: self._explain(f"{name}: cannot be read: {error}"))

    def _place_shown(self, shown: Any) -> None:
        """One of the places, alone; turns and views where there are any."""
        for place in (self._empty, self._maps_place, self._curves_place, self._study_place):
            place.set_visibility(place is shown)
        turns = shown in (self._maps_place, self._curves_place) or (shown is self._empty and self.source is not None)
        for part in (self._controls, self._views):
            part.set_visibility(turns)

    def _show_waiting(self, why: str = "") -> None:
        job = self.page.server.queue.job_of_folder(self.tab.run)
        if job is not None and not job.is_over:
            line = self.page.server.queue.progress(job).line
            turns = job.words[0] in ("run", "retrieve", "simulate")
            when = "Its maps appear here when the first turn is whole." if turns else "It appears here when it is done."
            self._explain(f"{self.tab.run}: {line}. {when}")
        elif job is not None and job.state in ("failed", "cancelled"):
            self._explain(f"{self.tab.run}: {job.state}: {job.reason}")
        else:
            self._explain(why or f"{self.tab.run}: holds no whole turn.")

    def _explain(self, words: str) -> None:
        """Show words instead of a view."""
        self.easel.drop("")
        self._empty.set_text(words)
        self._place_shown(self._empty)

    # ------------------------------------------------------------------------------------------------- drawing

    def _choose_view(self, event: Any) -> None:
        self.tab.view = event.value
        self._shown_key = ()
        self.redraw()

    def redraw(self) -> None:
        """Show the turn that is wanted now; what another one's drawing gives is dropped."""
        source, view, turn = self.source, self.tab.view, self.tab.turn
        name = self._name_turn()
        if source is not None and name:
            drawn = self._draw_turn(source, view, turn)
            self.easel.ask(f"drawing {VIEWS[view]}, {name} …", drawn, self._refuse_turn)

    def _refuse_turn(self, error: Exception) -> None:
        self._explain(f"This turn cannot be read: {error}")

    def _name_turn(self, when: str = "") -> str:
        """Show which turn it is, of as many as there will be; empty where there is none."""
        name = ""
        if self.source is not None and 0 <= self.tab.turn < len(self._turns):
            scene = self.source.scene
            whole = max(scene.turns if scene is not None else 0, len(self._turns))
            name = turn_name(self._turns[self.tab.turn], whole)
        self._clock.set_text(name + when)
        return name

    async def _draw_turn(self, source: Source, view: str, turn: int) -> None:
        when = await asyncio.to_thread(source.results.time, turn)
        key = (self.tab.run, view, self.page.dark)
        fresh = key != self._shown_key
        if view in MAP_VIEWS:
            shown = await drawing.quick(Source.view, source, view, turn)
            self._place_shown(self._maps_place)
            self._shown_key = key
            if fresh:
                self.maps.show(shown, self._look_line(source))
            else:
                self.maps.frame(shown)
        else:
            self._place_shown(self._curves_place)
            if fresh:
                self._shown_key = key
                self._curves_place.clear()
                with self._curves_place:
                    self._panel: Any = _PANELS[view](self)
            await self._panel.show(source, turn)
        self._name_turn(f" · {when:.1f} s")

    # ------------------------------------------------------------------------------------------------- the time

    def _go_to_turn(self, turn: int) -> None:
        self.tab.turn = turn
        self._slider.value = turn + 1
        self.redraw()

    def _step(self, by: int) -> None:
        if self._turns:
            self._go_to_turn((self.tab.turn + by) % len(self._turns))

    def _toggle(self) -> None:
        self._playing = not self._playing and len(self._turns) > 1
        self._button.props('icon=pause aria-label="Pause"' if self._playing else 'icon=play_arrow aria-label="Play"')
        self._next = time.monotonic()

    def _play(self) -> None:
        """Turns follow each other as they did, but at most ten a second."""
        if not self._playing or self.easel.busy or time.monotonic() < self._next:
            return
        scene = self.source.scene if self.source else None
        every = max(0.1, min(scene.turn_duration_s, 1.0) if scene is not None else 0.5)
        self._next = time.monotonic() + every
        self._step(1)

    # ------------------------------------------------------------------------------------------------- the look

    @property
    def azimuth(self) -> float:
        """The azimuth of the look to cut: the one that was clicked, else the one into the waves, else the first."""
        if self._azimuth is None and self.source is not None:
            scene, looks = self.source.scene, self.source.layout.azimuth
            into = scene.sea.waves[0] if scene is not None and scene.sea.waves else None
            wanted = getattr(into, "wave_from_deg", float(looks[looks.size // 2]))
            self._azimuth = float(looks[np.argmin(np.abs(wrap_degrees(looks - wanted)))])
        return self._azimuth or 0.0

    def set_azimuth(self, azimuth_deg: float) -> None:
        """Cut along another look."""
        self._azimuth = azimuth_deg % 360.0
        self.redraw()

    def _cut_section(self, east: float, north: float) -> None:
        self._azimuth = float(np.degrees(np.arctan2(east, north)) % 360.0)
        self._views.value = "section"

    def _look_line(self, source: Source) -> Any:
        far, angle = float(source.ground_m[-1]), np.radians(self.azimuth)
        return (0.0, 0.0), (float(far * np.sin(angle)), float(far * np.cos(angle)))

    # ------------------------------------------------------------------------------------------------- exporting

    def _fill_menu(self) -> None:
        self._menu.clear()
        with self._menu:
            offer_products(self.page.server.roots.run(self.tab.run), self.tab.run)
            if self.source is not None:
                ui.menu_item("this turn's section and curves (CSV)", on_click=self._download_csv)
                ui.menu_item("this turn's height maps (PNG)", on_click=self._download_png)

    def _file_name(self, ending: str) -> str:
        turn = turn_name(self._turns[self.tab.turn]).replace(" ", "")
        return f"{Path(self.tab.run).name}_{turn}.{ending}"

    async def _download_csv(self) -> None:
        if self.source is not None:
            name = self._file_name("csv")
            ui.download.content(await drawing.quick(turn_csv, self.source, self.azimuth, self.tab.turn), name)

    async def _download_png(self) -> None:
        if self.source is not None:
            name = self._file_name("png")
            self._status.set_text("drawing …")
            made = await drawing.slow(turn_png, self.source, self.tab.turn)
            self._status.set_text("" if made else "Only a run's maps, with their truth, are drawn.")
            if made:
                ui.download.content(made, name)


def _open_source(folder: Path) -> Source | None:
    results = Results(folder)
    return Source(results) if results.turns() else None


_PANELS: dict[str, Callable[[SeeView], Any]] = {
    "section": SectionPanel,
    "range": RangePanel,
    "state": StatePanel,
    "gauges": GaugePanel,
    "forecast": ForecastPanel,
    "helm": HelmPanel,
    "sea": SeaPanel,
}
_STUDIES: dict[str | None, Callable[[SeeView], Any]] = {  # kinds of folders without turns
    "shadowing": ShadowingPanel,
    "sea": PicturedPanel,
    "forecast": IssuesPanel,
}
