"""Forecasts without maps beside them, as `seamap-rt predict --out` writes them: one issue after another."""

from __future__ import annotations

import asyncio
from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np
from nicegui import ui

from ..io.growing_file import GrowingFile, read_whole_turns
from .forecast_view import ForecastPanel

if TYPE_CHECKING:
    from .see_view import SeeView


class IssuesPanel:
    """The forecasts of a folder; what came is known only where the run's scene and maps are."""

    def __init__(self, view: SeeView) -> None:
        self._issues: list[int] = []
        self._folder, self._view = Path(), view
        with ui.row().classes("w-full items-center no-wrap gap-2"):
            ui.label("Forecast").classes("text-sm")
            self._slider = ui.slider(min=1, max=2, value=1, step=1, on_change=self._step)
            self._slider.props('label aria-label="Forecast"').classes("grow mx-2").mark("issue")
        self._panel = ForecastPanel(view)

    async def show_folder(self, folder: Path) -> None:
        """Of a folder. OSError, KeyError where it holds no forecasts."""
        self._folder = folder
        self._issues = await asyncio.to_thread(read_whole_turns, folder / "prediction.nc", _issues)
        self._slider.props["max"] = max(len(self._issues), 2)
        self._slider.set_enabled(len(self._issues) > 1)
        self._slider.value = len(self._issues)
        await self._show()

    def _step(self) -> None:
        if self._issues:
            self._view.draw_beside(self._show(), self._folder.name)

    async def _show(self) -> None:
        if self._issues:
            at = min(int(self._slider.value or 1), len(self._issues)) - 1
            await self._panel.show_issue(self._folder, self._issues[at])


def _issues(file: GrowingFile) -> list[int]:
    return [int(each) for each in np.asarray(file.array("issue")[:])]
