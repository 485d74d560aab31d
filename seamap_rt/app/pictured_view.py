"""A folder whose results are pictures and lines of text: the sea on file, as `seamap-rt sea` writes it."""

from __future__ import annotations

import asyncio
from pathlib import Path
from typing import TYPE_CHECKING

from nicegui import ui

from ..errors import InputError
from ..io.opening import open_file
from .files import address

if TYPE_CHECKING:
    from .see_view import SeeView

PICTURES = {  # that the sea on file has, with what they show
    "from_mast.png": "The sea from the mast, rendered with the sun's light",
    "sea_surface.png": "The sea from above",
    "sea.gif": "The sea in motion",
    "directional_spectrum.png": "Its spectrum by frequency and direction",
}
_MOST_TEXT = 20_000


class PicturedPanel:
    """Pictures one below the other, then what was counted."""

    def __init__(self, view: SeeView) -> None:
        self.view = view
        self._place = ui.column().classes("w-full min-w-0 gap-3").mark("pictures")

    async def show_folder(self, folder: Path) -> None:
        """Of a folder below the runs."""
        name = folder.relative_to(self.view.page.desk.roots.runs).as_posix()
        there = [each for each in PICTURES if (folder / each).is_file()]
        text = await asyncio.to_thread(_text, folder / "statistics.txt")
        self._place.clear()
        with self._place:
            if not there and not text:
                ui.label("No picture is here yet.").classes("text-sm")
            for each in there:
                ui.label(PICTURES[each]).classes("font-bold")
                stamp = (folder / each).stat().st_mtime_ns  # so that no older picture is shown
                shown = ui.element("img").classes("max-w-full")
                shown.props["src"], shown.props["alt"] = f"{address(name, each)}?at={stamp}", PICTURES[each]
            if text:
                ui.label(text).classes("w-full text-xs font-mono whitespace-pre overflow-x-auto").props("tabindex=0")


def _text(path: Path) -> str:
    try:
        with open_file(path) as file:
            return file.read(_MOST_TEXT).decode("utf-8", "replace")
    except (OSError, InputError):
        return ""
