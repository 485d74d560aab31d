"""The wave gauges of a run: what their wires recorded beside what the maps say of the same places."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

from nicegui import ui

from . import drawing, figures, gauge_graphs
from .prospects_view import number

if TYPE_CHECKING:
    from .see_view import SeeView
    from .views import Source

_FIGURES = (  # of `judge_one`: words, unit, digits
    ("correlation", "Correlation with the wire", "", 3),
    ("rms_error_m", "Error, rms", "m", 3),
    ("stated_error_m", "Error that is stated", "m", 3),
    ("bias_m", "Bias", "m", 3),
    ("averaging_rms_m", "Of that by averaging over cells", "m", 3),
    ("hs_wire_m", "Wave height by the wire", "m", 2),
    ("hs_retrieved_m", "Wave height by the map", "m", 2),
    ("answered", "Turns with a height", "%", 0),
)


class GaugePanel:
    """One gauge at a time."""

    def __init__(self, view: SeeView) -> None:
        self.view = view
        self._filling = False
        blank = figures.figure([], figures.layout(view.page.dark))
        self._said = ui.label().classes("text-sm").props("role=status").mark("gauge-words")
        with ui.column().classes("w-full min-w-0 gap-2") as self._body:
            self._choice = ui.select({}, label="Wave gauge", on_change=self._chosen)
            self._choice.props("dense outlined options-dense").classes("w-64 max-w-full").mark("gauge")
            self._record = ui.plotly(blank).classes("w-full min-w-0").mark("gauge-record")
            self._why = ui.label().classes("text-sm").mark("gauge-spectrum-words")
            with ui.element("div").classes("w-full grid gap-2 grid-cols-1 lg:grid-cols-2"):
                self._spectrum, self._pairs = (
                    ui.plotly(blank).classes("w-full min-w-0").mark(name) for name in ("gauge-spectrum", "gauge-pairs")
                )
            self._tiles = ui.element("div").classes("w-full grid gap-2 grid-cols-2 md:grid-cols-4").mark("gauge-tiles")
        self._body.set_visibility(False)

    async def show(self, source: Source, turn: int) -> None:
        """What there is up to now, with the turn marked."""
        chosen = self._choice.value
        told = await drawing.slow(gauge_graphs.told_of, source, turn, chosen, self.view.page.dark)
        self._body.set_visibility(told is not None)
        if told is None:
            self._said.set_text(
                "This run has no wave gauge. Press “Add wave gauge” at the end of the form in Design, say where it "
                "stands, and run the design: its record of the surface is held against the map there."
            )
            return
        self._filling = True
        self._choice.set_options({each: each for each in told.names}, value=told.name)
        self._filling = False
        self._said.set_text(told.place)
        self._why.set_text(told.why)
        for plot, made in ((self._record, told.record), (self._spectrum, told.spectrum), (self._pairs, told.pairs)):
            plot.set_visibility(made is not None)
            if made is not None:
                plot.update_figure(made)
        self._fill(told.judged)

    def _chosen(self) -> None:
        if not self._filling:
            self.view.redraw()

    def _fill(self, told: dict[str, Any]) -> None:
        self._tiles.clear()
        with self._tiles:
            for key, words, unit, digits in _FIGURES:
                value = float(told[key]) * (100.0 if unit == "%" else 1.0)
                with ui.card().classes("p-2 gap-0 w-full").props("flat bordered"):
                    ui.label(words).classes("text-xs opacity-80")
                    ui.label(f"{number(value, digits)} {unit}".strip()).classes("font-bold figure-value")
