"""Curves of a turn on the page: the section along a look, errors and visibility against range, the sea state."""

from __future__ import annotations

import asyncio
from typing import TYPE_CHECKING

from nicegui import ui

from . import curves, drawing
from .spectrum_view import SpectrumPanel

if TYPE_CHECKING:
    from .see_view import SeeView
    from .views import Source


class SectionPanel:
    """The section, with the look to be chosen."""

    def __init__(self, view: SeeView) -> None:
        self.view = view
        with ui.row().classes("w-full items-center gap-2 no-wrap"):
            ui.label("Look").classes("text-sm")
            self.slider = ui.slider(min=0, max=359, step=1, value=round(view.azimuth) % 360)
            self.slider.props('label aria-label="Azimuth of the look"').classes("grow").mark("azimuth")
            self.slider.on_value_change(lambda e: view.set_azimuth(float(e.value or 0.0)))
        self.plot = ui.plotly(curves.figures.figure([], curves.figures.layout(view.page.dark))).classes("w-full")
        self.plot.mark("section")

    async def show(self, source: Source, turn: int) -> None:
        made = await drawing.quick(curves.section_of, source, self.view.azimuth, turn, self.view.page.dark)
        self.plot.update_figure(made)


class RangePanel:
    """Error and visibility against range."""

    def __init__(self, view: SeeView) -> None:
        self.view = view
        with ui.element("div").classes("w-full grid gap-2 grid-cols-1 lg:grid-cols-2"):
            self.error, self.visible = (
                ui.plotly(curves.figures.figure([], curves.figures.layout(view.page.dark))).classes("w-full").mark(name)
                for name in ("error-by-range", "visible-by-range")
            )

    async def show(self, source: Source, turn: int) -> None:
        error, visible = await drawing.quick(curves.by_range_of, source, turn, self.view.page.dark)
        self.error.set_visibility(error is not None)
        if error is not None:
            self.error.update_figure(error)
        self.visible.update_figure(visible)


class StatePanel:
    """The sea state by the maps, and their spectrum."""

    def __init__(self, view: SeeView) -> None:
        self.view, self._place = view, ui.column().classes("w-full")
        self._spectrum = SpectrumPanel(view)

    async def show(self, source: Source, turn: int) -> None:
        metrics = await asyncio.to_thread(source.results.metrics)
        self._place.clear()
        with self._place:
            graph = curves.sea_state_graph(metrics, self.view.page.dark)
            if graph is None:
                ui.label(_why_no_state(source)).classes("text-sm")
            else:
                ui.label(str(metrics.get("sea_state_in_words", ""))).classes("font-bold").mark("sea-state")
                ui.plotly(graph).classes("w-full")
        await self._spectrum.show(source, turn)


def _why_no_state(source: Source) -> str:
    if not source.results.has_maps:
        return "Nothing was retrieved of these echoes yet: press Retrieve beside them in Runs."
    if source.results.growing or source.scene is not None:
        return "The wave height, turn by turn, is worked out when a run has ended."
    return "The wave height of these echoes stands in their own page: Download, retrieval.html."
