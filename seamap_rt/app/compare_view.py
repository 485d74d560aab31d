"""The place where two runs are held against each other: figures, maps on one scale, whose errors are less by more than
chance."""

from __future__ import annotations

import asyncio
from typing import TYPE_CHECKING, Any

from nicegui import ui

from ..conventions import turn_name
from ..errors import InputError
from . import drawing
from .comparison import Figure, RangeVerdict, chance_in_words, drawing_of, in_words
from .folders import find_runs
from .maps_panel import MapsPanel
from .results import Results
from .source import Source
from .widgets import Canvas, Images, choice, count_on, flat_button, grey_of, number, slider, tile

if TYPE_CHECKING:
    from .page import Page


_COLUMNS = [
    {"name": name, "label": label, "field": name, "align": "left"}
    for name, label in (
        ("range", "Range (m)"),
        ("a", "A: rms error (m)"),
        ("b", "B: rms error (m)"),
        ("verdict", "B against A"),
        ("chance", "Chance alone makes"),
    )
]


class CompareView:
    """Two runs, A and B: figures, maps on one scale, curves in one graph."""

    def __init__(self, page: Page) -> None:
        self.page, self.tab = page, page.tab
        self._sources: dict[str, Source] = {}
        self._filling = False
        self._shown: tuple[Any, ...] = ()
        with ui.row().classes("w-full items-center gap-2"):
            self._choices = [
                choice(label, f"compare-{label}", on_change=lambda e, i=i: self._chosen(i, e.value))
                for i, label in enumerate("AB")
            ]
            flat_button("Swap A and B", icon="swap_horiz", on_click=self._swap)
        self._said = ui.label().classes("text-sm").props("role=status")
        drawn = ui.label().classes("text-sm waits").props("role=status")
        self._body = ui.column().classes("w-full gap-2 min-w-0")
        self._easel = Canvas(grey_of(drawn, self._body))
        with self._body:
            self._verdict = ui.label().classes("font-bold").mark("compared")
            self._table = ui.element("div").classes("w-full grid gap-2 grid-cols-2 md:grid-cols-4").mark("figures")
            self._ranges = ui.table(rows=[], columns=_COLUMNS, row_key="range").props("dense flat bordered")
            self._ranges.classes("w-full").mark("compared-ranges")
            with ui.row().classes("w-full items-center no-wrap gap-2"):
                self._turn = ui.label("Turn").classes("text-sm figure-value whitespace-nowrap")
                self._slider = slider("Turn", "compared-turn", self._redraw)
            self._maps = MapsPanel(page, lambda *_: None)
            self._images = Images(columns=True)
        self._body.set_visibility(False)

    async def enter(self) -> None:
        """Look for runs again, and draw those that are chosen."""
        self._shown = ()
        entries = await asyncio.to_thread(find_runs, self.page.server.roots.runs)
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
        for each, value in zip(self._choices, (self.tab.run, self.tab.other), strict=True):
            each.set_options({name: name for name in names}, value=value)
        self._filling = False
        await self._draw()

    def _chosen(self, index: int, name: str | None) -> None:
        if not name or self._filling:
            return
        if name == (self.tab.other, self.tab.run)[index]:  # the other one: they change places
            self._swap()
            return
        if index == 0:
            self.tab.run = name
        else:
            self.tab.other = name
        self._redraw()

    def _swap(self) -> None:
        self.tab.run, self.tab.other = self.tab.other, self.tab.run
        ui.timer(0.0, self.enter, once=True)

    def _source(self, name: str) -> Source:
        if name not in self._sources or self._sources[name].results.growing:
            self._sources[name] = Source(Results(self.page.server.roots.run(name)))
        return self._sources[name]

    def _redraw(self) -> None:
        self._easel.drop(f"drawing {self.tab.run} and {self.tab.other} …")
        with self._body:
            ui.timer(0.0, self._draw, once=True)

    async def _draw(self) -> None:
        try:
            await self._easel.show(f"drawing {self.tab.run} and {self.tab.other} …", self._draw_both())
        except (InputError, OSError, KeyError, IndexError) as refusal:
            self._said.set_text(f"These two cannot be held against each other: {refusal}")
            self._body.set_visibility(False)

    async def _draw_both(self) -> None:
        names = (self.tab.run, self.tab.other)
        first, second = [await asyncio.to_thread(self._source, name) for name in names]
        count = min([len(await asyncio.to_thread(each.results.turns)) for each in (first, second)])
        turn = min(int(self._slider.value or 1), count) - 1
        key = (*names, self.page.dark)
        whole = key != self._shown
        made = await drawing.quick(drawing_of, first, second, turn, names, self.page.dark, whole)
        self._said.set_text(made.differ)
        self._body.set_visibility(True)
        count_on(self._slider, count)
        self._turn.set_text(turn_name(turn, count))
        if not whole:
            self._maps.frame(made.shown)
        else:
            self._shown = key
            self._maps.show(made.shown)
            self._fill_table(made.figures)
            self._fill_ranges(made.judged)
        self._images.show(made.images)

    def _fill_table(self, rows: list[Figure]) -> None:
        self._table.clear()
        with self._table:
            if not rows:
                ui.label("Figures follow when both runs have ended.").classes("text-sm")
            for row in rows:
                with tile(f"{row.words}{f' ({row.unit})' if row.unit else ''}")[1]:
                    first, second = (
                        "—" if each is None else number(each, row.digits) for each in (row.first, row.second)
                    )
                    ui.label(f"A {first} · B {second}").classes("font-bold figure-value")

    def _fill_ranges(self, judged: list[RangeVerdict]) -> None:
        """Whose heights err less, range by range."""
        self._verdict.set_text(in_words(judged) if judged else "Whose heights err less is not known: a true sea lacks.")
        self._ranges.set_visibility(bool(judged))
        self._ranges.rows = [
            {
                "range": f"{each.range_m[0]:.0f}–{each.range_m[1]:.0f}",
                "a": number(each.first, 3), "b": number(each.second, 3), "verdict": each.verdict,
                "chance": chance_in_words(each.chance),
            }
            for each in judged
        ]  # fmt: skip
