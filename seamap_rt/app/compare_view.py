"""The place where two runs are held against each other."""

from __future__ import annotations

import asyncio
from typing import TYPE_CHECKING, Any

from nicegui import ui

from ..errors import InputError
from . import curves, figures
from .comparing import Figure, figures_of, side_by_side
from .maps_panel import MapsPanel
from .prospects_view import COLOURS, number
from .results import Results
from .runs import find_runs
from .views import Source

if TYPE_CHECKING:
    from .page import Page

_LOOK_S = 1.0


class CompareView:
    """Two runs, A and B: figures, maps on one scale, curves in one graph."""

    def __init__(self, page: Page) -> None:
        self.page, self.tab = page, page.tab
        self._sources: dict[str, Source] = {}
        self._filling = False
        self._shown: tuple[Any, ...] = ()
        with ui.row().classes("w-full items-center gap-2"):
            self._choices = [
                ui.select({}, label=label, on_change=lambda e, i=i: self._chosen(i, e.value))
                .props("dense outlined options-dense")
                .classes("w-64 max-w-full")
                .mark(f"compare-{label}")
                for i, label in enumerate("AB")
            ]
            ui.button("Swap", icon="swap_horiz", on_click=self._swap).props("flat dense no-caps")
        self._said = ui.label().classes("text-sm").props("role=status")
        self._body = ui.column().classes("w-full gap-2 min-w-0")
        with self._body:
            self._table = ui.element("div").classes("w-full grid gap-2 grid-cols-2 md:grid-cols-4").mark("figures")
            with ui.row().classes("w-full items-center no-wrap gap-2"):
                ui.label("Turn").classes("text-sm")
                self._slider = ui.slider(min=0, max=1, value=0, step=1).props('label aria-label="Turn"')
                self._slider.classes("grow mx-2").on_value_change(lambda: ui.timer(0.0, self._draw, once=True))
            self._maps = MapsPanel(page.width, page.dark, lambda *_: None)
            with ui.element("div").classes("w-full grid gap-2 grid-cols-1 lg:grid-cols-2"):
                blank = figures.figure([], figures.layout(page.dark))
                self._error, self._visible = (ui.plotly(blank).classes("w-full") for _ in range(2))
        self._body.set_visibility(False)

    def enter(self) -> None:
        """Shown again."""
        self._shown = ()
        ui.timer(0.01, self._enter, once=True)

    async def _enter(self) -> None:
        entries = await asyncio.to_thread(find_runs, self.page.desk.roots.runs)
        names = [entry.name for entry in entries if entry.kind in ("run", "retrieval")]
        if len(names) < 2:
            self._said.set_text("Two runs are needed: run a design, change it, and run it again.")
            self._body.set_visibility(False)
            return
        if self.tab.run not in names:
            self.tab.run = names[0]
        if self.tab.other not in names or self.tab.other == self.tab.run:
            self.tab.other = next(name for name in names if name != self.tab.run)
        self._filling = True
        for choice, value in zip(self._choices, (self.tab.run, self.tab.other), strict=True):
            choice.set_options({name: name for name in names}, value=value)
        self._filling = False
        await self._draw()

    def _chosen(self, index: int, name: str | None) -> None:
        if name and not self._filling:
            if index == 0:
                self.tab.run = name
            else:
                self.tab.other = name
            ui.timer(0.0, self._draw, once=True)

    def _swap(self) -> None:
        self.tab.run, self.tab.other = self.tab.other, self.tab.run
        ui.timer(0.0, self._enter, once=True)

    def _source(self, name: str) -> Source:
        if name not in self._sources or self._sources[name].results.growing:
            self._sources[name] = Source(Results(self.page.desk.roots.run(name)))
        return self._sources[name]

    async def _draw(self) -> None:
        names = (self.tab.run, self.tab.other)
        try:
            first, second = [await asyncio.to_thread(self._source, name) for name in names]
            counts = [len(await asyncio.to_thread(each.results.turns)) for each in (first, second)]
            turn = min(int(self._slider.value or 0), min(counts) - 1)
            shown = await asyncio.to_thread(side_by_side, first, second, turn, names)
            told = {
                name: await asyncio.to_thread(each.by_range, turn)
                for name, each in ((names[0], first), (names[1], second))
            }
            metrics = [await asyncio.to_thread(each.results.metrics) for each in (first, second)]
        except (InputError, OSError, KeyError, IndexError) as refusal:
            self._said.set_text(f"These two cannot be held against each other: {refusal}")
            self._body.set_visibility(False)
            return
        self._said.set_text("" if names[0] != names[1] else "Choose two different runs.")
        self._body.set_visibility(True)
        self._slider.props["max"] = max(min(counts) - 1, 1)
        self._slider.set_enabled(min(counts) > 1)
        self._slider.update()
        key = (*names, self.page.dark)
        if key == self._shown:
            self._maps.frame(shown[2])
        else:
            self._shown = key
            self._maps.show(*shown)
            self._fill_table(figures_of(*metrics))
        self._error.update_figure(curves.error_graph(told, None, self.page.dark))
        self._visible.update_figure(curves.visible_graph(told, None, self.page.dark))

    def _fill_table(self, rows: list[Figure]) -> None:
        self._table.clear()
        with self._table:
            if not rows:
                ui.label("Figures follow when both runs have ended.").classes("text-sm")
            for row in rows:
                with ui.card().classes("p-2 gap-0 w-full").props("flat bordered"):
                    ui.label(f"{row.words}{f' ({row.unit})' if row.unit else ''}").classes("text-xs opacity-80")
                    first, second = (
                        "—" if each is None else number(each, row.digits) for each in (row.first, row.second)
                    )
                    sign = {1: "▲ B better", -1: "▼ B worse", 0: ""}[row.verdict]
                    ui.label(f"A {first} · B {second}").classes("font-bold figure-value")
                    ui.label(sign).classes("text-xs").classes(COLOURS[row.verdict])
