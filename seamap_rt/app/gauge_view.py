"""The wave gauges of a run: what their wires recorded beside what the maps say of the same places."""

from __future__ import annotations

import asyncio
from typing import TYPE_CHECKING, Any

import numpy as np
import xarray as xr
from nicegui import ui

from ..gauges import NoSpectrum, aliasing, judge_one
from . import figures, gauge_graphs
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
        self._now: tuple[Source, int] | None = None
        self._read: tuple[Any, xr.Dataset] | None = None
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
        if not gauge_graphs.has_gauges(source.results):
            self._said.set_text(
                "This run has no wave gauge. Press “Add wave gauge” at the end of the form in Design, say where it "
                "stands, and run the design: its record of the surface is held against the map there."
            )
            self._body.set_visibility(False)
            return
        self._now = source, turn
        key = source.results.folder, len(source.results.turns())
        if self._read is None or self._read[0] != key:
            self._read = key, await asyncio.to_thread(gauge_graphs.read_gauges, source.results)
            names = [str(each) for each in self._read[1]["gauge"].values]
            self._filling = True
            self._choice.set_options(
                {each: each for each in names}, value=self._choice.value if self._choice.value in names else names[0]
            )
            self._filling = False
        await self._draw()

    async def _chosen(self) -> None:
        if not self._filling and self._read is not None:
            await self._draw()

    async def _draw(self) -> None:
        assert self._read is not None
        assert self._now is not None
        gauge, dark = self._read[1].sel(gauge=str(self._choice.value)), self.view.page.dark
        source, turn = self._now
        self._body.set_visibility(True)
        east, north = (float(gauge[name]) for name in ("east", "north"))
        self._said.set_text(f"At {np.hypot(east, north):.0f} m, {np.degrees(np.arctan2(east, north)) % 360.0:.0f}°.")
        self._record.update_figure(gauge_graphs.record(gauge, source.results.turns()[turn], dark))
        result = await asyncio.to_thread(gauge_graphs.spectra_of, gauge)
        self._spectrum.set_visibility(not isinstance(result, NoSpectrum))
        if isinstance(result, NoSpectrum):
            self._why.set_text(f"No spectrum: {result.reason}.")
        else:
            self._why.set_text(
                " ".join(f"{each[:1].upper()}{each[1:]}." for each in (aliasing(result), result.reason) if each)
            )
            self._spectrum.update_figure(gauge_graphs.spectrum(result, dark))
        made = gauge_graphs.pairs(gauge, dark)
        self._pairs.set_visibility(made is not None)
        if made is not None:
            self._pairs.update_figure(made)
        self._fill(await asyncio.to_thread(judge_one, gauge))

    def _fill(self, told: dict[str, Any]) -> None:
        self._tiles.clear()
        with self._tiles:
            for key, words, unit, digits in _FIGURES:
                value = float(told[key]) * (100.0 if unit == "%" else 1.0)
                with ui.card().classes("p-2 gap-0 w-full").props("flat bordered"):
                    ui.label(words).classes("text-xs opacity-80")
                    ui.label(f"{number(value, digits)} {unit}".strip()).classes("font-bold figure-value")
