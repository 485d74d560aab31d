"""How past forecasts of a run came out: at a chosen lead beside the sea that came, by lead, and their quiet windows."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

import numpy as np
from nicegui import ui

from ..conventions import turn_name, written
from ..errors import InputError
from . import figures, verified_graphs
from .what_came import Came, what_came

if TYPE_CHECKING:
    from .see_view import SeeView
    from .views import Source

_LEAD_S = 10.0  # of the forecasts that are drawn first, as in the report
_TWO = "w-full grid gap-2 grid-cols-1 lg:grid-cols-2"
_PLOTS = ("time", "errors", "correlation", "issue", "reliability", "hits")


class VerifiedPanel:
    """Past forecasts, step by step with the turns. What came is drawn again in a process of its own, once a run."""

    def __init__(self, view: SeeView) -> None:
        self.view = view
        self._came: Came | None = None
        self._of: Any = None
        self._turn = 0
        self._filling = False
        ui.label("How past forecasts came out").classes("text-base font-bold")
        self._said = ui.label().classes("text-sm").props("role=status").mark("verified-words")
        with ui.column().classes("w-full min-w-0 gap-2") as self._body:
            self._lead = ui.select({}, label="Forecast so long before", on_change=self._chosen)
            self._lead.props("dense outlined options-dense").classes("w-56 max-w-full").mark("verified-lead")
            self._plots = {"time": self._plot("time")}
            with ui.element("div").classes(_TWO):
                self._plots |= {name: self._plot(name) for name in ("errors", "correlation")}
            with ui.column().classes("w-full min-w-0 gap-2") as self._windows:
                self._called = ui.label().classes("text-sm").mark("windows-words")
                self._plots["issue"] = self._plot("issue")
                with ui.element("div").classes(_TWO):
                    self._plots |= {name: self._plot(name) for name in ("reliability", "hits")}
        self._body.set_visibility(False)

    def _plot(self, name: str) -> Any:
        blank = figures.figure([], figures.layout(self.view.page.dark))
        return ui.plotly(blank).classes("w-full min-w-0").mark(f"verified-{name}")

    async def show(self, source: Source, turn: int) -> Came | None:
        """Of a run up to a turn's place; gives what came, None where nobody knows."""
        folder, self._turn = source.results.folder, source.results.turns()[turn]
        if source.results.growing:
            self._tell("Past forecasts are held against the sea that came when the run has ended.")
            return None
        if source.scene is None:
            self._tell("Nobody knows what came: these maps have no true sea. A run of a design has one.")
            return None
        if self._of != folder:
            self._tell("Drawing the sea that came …")
            try:
                came = await what_came(folder)
            except (InputError, OSError) as refusal:
                self._tell(f"What came is not known: {refusal}")
                return None
            self._of, self._came = folder, came
            self._begin(came)
        assert self._came is not None
        self._step(self._came)
        return self._came

    def _tell(self, words: str) -> None:
        self._said.set_text(words)
        self._body.set_visibility(False)

    def _begin(self, came: Came) -> None:
        """What does not change from turn to turn."""
        self._filling = True
        options = {i: f"{lead:g} s before" for i, lead in enumerate(came.lead) if float(lead).is_integer()}
        options = options or {i: f"{lead:g} s before" for i, lead in enumerate(came.lead)}
        wanted = min(options, key=lambda i: abs(came.lead[i] - _LEAD_S))
        self._lead.set_options(options, value=wanted)
        self._filling = False
        dark = self.view.page.dark
        self._plots["errors"].update_figure(verified_graphs.errors_by_lead(came, dark))
        self._plots["correlation"].update_figure(verified_graphs.correlation_by_lead(came, dark))
        windows = came.windows
        self._windows.set_visibility(windows is not None)
        if windows is not None:
            confidence = float(windows.figures["confidence"])
            self._called.set_text(_windows_in_words(windows.figures))
            self._plots["reliability"].update_figure(verified_graphs.reliability(windows, dark))
            self._plots["hits"].update_figure(verified_graphs.hits(windows, confidence, dark))
            self._plots["hits"].set_visibility(bool(windows.curves))

    def _step(self, came: Came) -> None:
        """What goes with the turn and the lead."""
        dark, lead = self.view.page.dark, int(self._lead.value or 0)
        self._said.set_text(_in_words(came, lead))
        self._body.set_visibility(True)
        self._plots["time"].update_figure(verified_graphs.in_time(came, lead, self._turn, dark))
        windows, at = came.windows, came.at(self._turn)
        held = np.flatnonzero(windows.judged == at) if windows is not None and at is not None else np.array([])
        self._plots["issue"].set_visibility(bool(held.size))
        if windows is not None and held.size:
            title = f"Quiet windows after {turn_name(came.issue[at])}, and which came"
            graph = verified_graphs.windows_of_issue(
                windows, int(held[0]), float(windows.figures["confidence"]), title, dark
            )
            self._plots["issue"].update_figure(graph)

    def _chosen(self) -> None:
        if self._came is not None and not self._filling:
            self._step(self._came)


def _in_words(came: Came, lead: int) -> str:
    """How well the forecasts of one lead did."""
    told = came.by_lead()
    mean, std, true = (each[came.warm, lead] for each in (came.mean, came.std, came.true))
    rms, within = float(np.sqrt(np.mean((mean - true) ** 2))), float(np.mean(np.abs(mean - true) < 1.96 * std))
    words = (
        f"Of {int(came.warm.sum())} forecasts, {came.lead[lead]:g} s ahead: error {written(rms, 2)} m rms "
        f"({told['found'][lead]:.2f} of the sea's standard deviation), {within:.0%} within the stated band"
    )
    correlation = told["correlation"][lead]
    return words + (f", correlation {correlation:.2f}." if np.isfinite(correlation) else ".")


def _windows_in_words(told: dict[str, Any]) -> str:
    """What was called, and what came of it."""
    words = f"Of {told['windows']} windows {told['quiet_share']:.0%} were quiet. "
    if told["right"] is None:
        return f"{words}None was called: none was {told['confidence']:.0%} sure."
    found = "" if told["found"] is None else f"; of the quiet ones {told['found']:.0%} were called"
    return f"{words}{told['called']} were called at {told['confidence']:.0%}: {told['right']:.0%} of them quiet{found}."
