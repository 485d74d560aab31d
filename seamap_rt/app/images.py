"""Figures of the report on the page: drawn in a process that draws, shown as the same images with the same words."""

from __future__ import annotations

import base64
from collections.abc import Iterable
from typing import NamedTuple

from nicegui import ui

from ..report import style
from ..report.page_elements import Picture


class Image(NamedTuple):
    """A figure that is drawn. source: the address of a PNG."""

    name: str
    title: str
    alt: str
    caption: str
    source: str


def drawn(pictures: Iterable[Picture], dark: bool) -> list[Image]:
    """Draw, for a light or a dark page; some tenths of a second each."""
    made = []
    for each in pictures:
        figure = each.draw()
        assert not isinstance(figure, bytes)
        source = f"data:image/png;base64,{base64.b64encode(style.png(figure, dark)).decode('ascii')}"
        made.append(Image(each.name, each.title, each.alt, each.caption, source))
    return made


class Images:
    """A place for figures; one that is drawn anew keeps its element. columns: side by side where the window is wide."""

    def __init__(self, *, columns: bool = False) -> None:
        self._place = ui.element("div").classes("w-full min-w-0 grid gap-2 grid-cols-1")
        if columns:
            self._place.classes("2xl:grid-cols-2")
        self._shown: dict[str, tuple[ui.label, ui.element, ui.label]] = {}

    def show(self, images: Iterable[Image]) -> None:
        """These and no others."""
        images = list(images)
        if [each.name for each in images] != list(self._shown):
            self._place.clear()
            with self._place:
                self._shown = {each.name: _parts(each.name) for each in images}
        for each in images:
            title, image, caption = self._shown[each.name]
            title.set_text(each.title)
            image.props["src"], image.props["alt"] = each.source, each.alt
            caption.set_text(each.caption)


def _parts(name: str) -> tuple[ui.label, ui.element, ui.label]:
    with ui.column().classes("w-full min-w-0 gap-1"):
        title = ui.label().classes("font-bold")
        with ui.element("div").classes("w-full overflow-x-auto").props("tabindex=0"):  # a phone moves what is too wide
            image = ui.element("img").classes("drawn-figure").mark(f"figure-{name}")
        return title, image, ui.label().classes("text-xs opacity-80 max-w-5xl")
