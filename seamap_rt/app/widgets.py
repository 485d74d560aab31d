"""What the views of the page are put together from: choices, sliders, figures as images, and a place for one drawing.

A figure of the report is drawn in a process that draws, and shown as the same image with the same words.
"""

from __future__ import annotations

import asyncio
import math
from collections.abc import Callable, Coroutine, Iterable
from typing import Any

from nicegui import background_tasks, ui

from ..conventions import written
from ..errors import InputError
from ..report.page_elements import Image, Picture

_COLUMNS = {  # of images: whether there are several, and whether they are small
    (False, False): "",
    (True, False): "2xl:grid-cols-2",
    (True, True): "md:grid-cols-2 2xl:grid-cols-3 small-figures",
}
_WIDTHS = {"usual": "w-64 max-w-full", "wide": "w-96 max-w-full", "all": "grow min-w-0"}


def choice(
    label: str, mark: str, chosen: Callable[[], Any] | None = None, options: Any = (), width: str = "usual", **more: Any
) -> ui.select:
    """A list to choose from. chosen: called when a person has chosen. more: of `ui.select`."""
    made = ui.select(options if options else {}, label=label, **more).mark(mark)
    if chosen is not None:
        made.on("update:model-value", chosen, [])
    return made.props("dense outlined options-dense").classes(_WIDTHS[width])


def slider(words: str, mark: str, moved: Callable[[], Any], least: int = 1, most: int = 2, at: int = 1) -> ui.slider:
    """Whole numbers; words: for who does not see it. moved: called when a person has moved it."""
    made = ui.slider(min=least, max=most, value=at, step=1).classes("grow min-w-0 mx-2").mark(mark)
    made.on("update:model-value", moved, [], throttle=0.05)  # as its value is
    made.props("label").props["aria-label"] = words
    return made


def count_on(made: ui.slider, count: int) -> None:
    """So many there are, from 1; of one alone nothing can be chosen."""
    made.props["max"] = max(count, 2)
    made.set_enabled(count > 1)
    made.update()


def flat_button(words: str, icon: str, on_click: Callable[..., Any] | None = None, mark: str = "") -> ui.button:
    return ui.button(words, icon=icon, on_click=on_click).props("flat dense no-caps").mark(mark)


def round_button(words: str, icon: str, on_click: Callable[..., Any] | None = None) -> ui.button:
    """An icon; words: for who does not see it."""
    made = ui.button(icon=icon, on_click=on_click).props("flat dense round")
    made.props["aria-label"] = words
    return made


def tile(words: str) -> tuple[ui.label, ui.row]:
    """A figure under its words: these, and the row in which it is to stand."""
    with ui.card().classes("p-2 gap-0 w-full").props("flat bordered"):
        return ui.label(words).classes("text-xs opacity-80"), ui.row().classes("items-baseline gap-1")


def number(value: float, digits: int) -> str:
    """As `written`, with separators from ten thousand on."""
    return f"{value:,.{digits}f}" if 1e4 <= abs(value) < math.inf else written(value, digits)


def draw_images(pictures: Iterable[Picture], dark: bool) -> list[Image]:
    """Draw, for a light or a dark page; some tenths of a second each."""
    return [each.image(dark) for each in pictures]


class Images:
    """A place for figures; one that is drawn anew keeps its element. columns: side by side where the window is wide;
    small: which fit a phone."""

    def __init__(self, *, columns: bool = False, small: bool = False) -> None:
        self._place = ui.element("div").classes("w-full min-w-0 grid gap-2 grid-cols-1")
        self._place.classes(_COLUMNS[small or columns, small])
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


def grey_of(line: Any, stage: Any) -> Callable[[str], None]:
    """For a `Canvas`: a label and the element that all drawings stand in."""

    def grey(words: str) -> None:
        line.set_text(words)
        for each in (line, stage):
            each.classes(add="stale") if words else each.classes(remove="stale")

    return grey


class Canvas:
    """A place for one drawing at a time. From a question to its answer all that stands there is grey, under a line that
    says what is drawn; a question ends the one before it, whose answer is never shown.

    grey: called with that line, and with "" when the answer stands.
    """

    def __init__(self, grey: Callable[[str], None]) -> None:
        self._grey = grey
        self._task: asyncio.Future[None] | None = None

    @property
    def busy(self) -> bool:
        return self._task is not None and not self._task.done()

    def drop(self, words: str) -> None:
        """Nothing that is there, or comes, is asked for any more."""
        if self._task is not None:
            self._task.cancel()
        self._task = None
        self._grey(words)

    def ready(self) -> None:
        """Called by a drawing: what stands is the answer, though more follows."""
        self._grey("")

    def ask(
        self, words: str, drawing: Coroutine[Any, Any, None], refused: Callable[[Exception], None] | None = None
    ) -> None:
        """Draw as `show` does, without waiting for it. refused: is given why what is to be drawn cannot be read."""

        async def answer() -> None:
            try:
                await self.show(words, drawing)
            except (OSError, KeyError, IndexError, InputError) as error:
                if refused is None:
                    raise
                refused(error)

        self.drop(words)
        background_tasks.create(answer(), name=words)

    async def show(self, words: str, drawing: Coroutine[Any, Any, None]) -> None:
        """Draw. drawing: shows what it has made itself; it is cancelled where it waits. Raises what it raises."""
        self.drop(words)
        task = self._task = asyncio.ensure_future(drawing)
        try:
            await task
        except asyncio.CancelledError:
            if task is self._task:  # the page has gone
                raise
        finally:
            if task is self._task:
                self._grey("")
