"""The page: its head and its places, the state of the browser tab that it is shown in, and what all open pages share;
and what its places are put together from: choices, sliders, figures as images, and a canvas for one drawing.

A figure of the report is drawn in a process that draws, and shown as the same image with the same words.
"""

from __future__ import annotations

import asyncio
import math
from collections.abc import Callable, Coroutine, Iterable
from dataclasses import dataclass
from functools import cached_property
from importlib import import_module
from itertools import count
from pathlib import Path
from typing import TYPE_CHECKING, Any

from nicegui import background_tasks, ui

from ..conventions import written
from ..errors import InputError
from ..io.scenefile import list_shipped
from ..report.page_elements import Image
from . import drawing
from .folders import Roots, kind_of
from .jobs import Queue

if TYPE_CHECKING:
    from ..scene import Scene
    from .draft import Draft
    from .verification import Verifications

_MOST_TABS = 50


@dataclass
class Tab:
    """What one browser tab is at; it survives a reload."""

    draft: Draft
    pinned: tuple[str, Scene] | None = None  # a design to hold the draft against, with its name
    run: str = ""  # that is looked at
    other: str = ""  # that it is compared with
    trade: str = ""  # that is looked at
    turn: int = 0
    view: str = "heights"
    place: str = "Design"  # of the page


class ServerState:
    """The page's own state, one a server. runs: a folder that is there."""

    def __init__(self, runs: Path) -> None:
        self.roots = Roots(runs.resolve(), (next(iter(list_shipped().values())).parent,))
        self.queue = Queue(self.roots.runs)
        self._tabs: dict[str, Tab] = {}

    @cached_property
    def verifications(self) -> Verifications:
        from .verification import Verifications  # a page without forecasts does without

        return Verifications()

    def is_awaited(self, folder: str) -> bool:
        """Whether results of a folder's name are there, or come; not those of a job that came to nothing."""
        job, path = self.queue.job_of_folder(folder), self.roots.runs / folder
        return (job is not None and not job.is_over) or (path.is_dir() and kind_of(path) is not None)

    def free_folder(self, wanted: str) -> str:
        """A name for results that no folder and no job has: the wanted one, or with a number."""
        taken = {job.folder for job in self.queue.jobs() if not job.is_over}
        names = (wanted if number == 1 else f"{wanted}-{number}" for number in count(1))
        return next(name for name in names if name not in taken and not (self.roots.runs / name).exists())

    def tab(self, name: str) -> Tab:
        """The state of a browser tab by the name that it gives itself; a new one begins with choppy_sea."""
        from .draft import Draft

        tab = self._tabs.pop(name, None) or Tab(Draft.shipped("choppy_sea", self.roots))
        self._tabs[name] = tab  # the one used last is the last
        while len(self._tabs) > _MOST_TABS:
            self._tabs.pop(next(iter(self._tabs)))
        return tab


def load(module: str) -> None:
    """Import a module in a process that draws, which cannot hand the module itself back."""
    import_module(module)


PLACES = {  # and what shows them: loaded when it is first gone to, which takes a second
    "Design": ("design_view", "DesignView"),
    "Runs": ("runs_view", "RunsView"),
    "See": ("see_view", "SeeView"),
    "Compare": ("compare_view", "CompareView"),
    "Trade": ("trade_view", "TradeView"),
}
_STYLE = """
.changed .q-field__control:before { border-color: var(--q-accent) !important; border-width: 2px; }
.changed .q-field__label { font-weight: 700; }
.help-line { background: var(--q-help, #f3f6f9); padding: 6px 10px; border-top: 1px solid #c8d2dc; }
.body--dark .help-line { background: #1f2933; border-color: #3a4653; }
@layer theme {  /* what is important in the first layer is so before all others */
  .body--dark .text-primary { color: #7cc4f0 !important; }
  .body--dark .text-negative, .body--dark .q-field--error .q-field__bottom { color: #ff9a85 !important; }
  .body--dark .q-field--highlighted .q-field__label { color: #7cc4f0 !important; }
}
.q-loading-bar { display: none; }
.section > .q-expansion-item__container > .q-item { font-weight: 600; }
.figure-value { font-variant-numeric: tabular-nums; }
.nicegui-content { padding: 0; }
.waits { opacity: 0; min-height: 1.25rem; margin-bottom: -1.25rem; position: relative; z-index: 2; }
.stale { opacity: 0.25; filter: grayscale(1); pointer-events: none; transition: all 0.1s 0.15s; }  /* no flicker */
.waits.stale, .titled.stale { opacity: 1; filter: none; }
.titled.stale img { opacity: 0.25; filter: grayscale(1); }
.js-plotly-plot { min-height: 200px; }
.drawn-figure { width: 100%; min-width: 34rem; max-width: 60rem; height: auto; }
.small-figures .drawn-figure { min-width: 0; }
.js-plotly-plot .imagelayer image { image-rendering: pixelated; }
@media (prefers-reduced-motion: reduce) { * { transition: none !important; } }
"""


# NiceGUI asks a plot for its size also while it is hidden, and Plotly refuses.
_SCRIPT = """
document.documentElement.lang = "en";
window.addEventListener("unhandledrejection", (event) => {
  if (/displayed plot div/.test(String(event.reason))) event.preventDefault();
});
"""


class Page:
    """One open page. The views ask it to go elsewhere, and it asks them to look again while something runs."""

    def __init__(self, server: ServerState, tab: Tab, width: int, height: int, dark: bool) -> None:
        self.server, self.tab = server, tab
        self.width, self.height = width, height  # of the window, pixels
        self._holders: dict[str, ui.column] = {}
        self._made: dict[str, Any] = {}
        ui.add_css(_STYLE)
        ui.run_javascript(_SCRIPT)
        ui.colors(primary="#00588a", accent="#b34700", positive="#00664a", negative="#a8321a")
        with ui.header().classes("items-center py-0 px-3 gap-2 no-wrap").props("elevated"):
            ui.label("seamap_rt").classes("text-base font-bold gt-xs").props("role=heading aria-level=1")
            place: Any = tab.place  # which is given by its name
            self._tabs = ui.tabs(value=place, on_change=self.enter).classes("grow min-w-0")
            self._tabs.props('dense no-caps inline-label outside-arrows mobile-arrows align="left"')
            with self._tabs:
                for name in PLACES:
                    ui.tab(name).mark(f"place-{name}")
            ui.button(icon="dark_mode", on_click=self._turn_dark).props(
                'flat dense round color=white aria-label="Light or dark"'
            )
        self._dark = ui.dark_mode(dark)
        with ui.tab_panels(self._tabs, value=tab.place, animated=False, keep_alive=True).classes("w-full"):
            for name in PLACES:
                with ui.tab_panel(name).classes("p-2 sm:p-3"):
                    self._holders[name] = ui.column().classes("w-full")

    @property
    def dark(self) -> bool:
        return bool(self._dark.value)

    async def enter(self) -> None:
        """Show the place that is chosen; its view is made when it is first gone to."""
        name = self.tab.place = str(self._tabs.value)
        if name not in self._made:
            module, view = PLACES[name]
            loaded = await asyncio.to_thread(import_module, f"seamap_rt.app.{module}")
            if name in self._made:
                return
            with self._holders[name]:
                self._made[name] = getattr(loaded, view)(self)
        await self._made[name].enter()

    def go(self, place: str) -> None:
        """Show another place."""
        if self._tabs.value == place:
            background_tasks.create(self.enter(), context=self._holders[place])
        else:
            self._tabs.value = place

    async def prepare(self) -> None:
        """Load the other places' views while the first one is read."""
        for module, _ in PLACES.values():
            await asyncio.to_thread(import_module, f"seamap_rt.app.{module}")
        await drawing.slow(load, "seamap_rt.app.panels")  # and begin what draws

    def redraw_design(self) -> None:
        """The draft was changed from elsewhere."""
        if "Design" in self._made:
            self._made["Design"].take_over()

    def see(self, run: str) -> None:
        """Show a run."""
        self.tab.run, self.tab.turn = run, -1
        self.go("See")

    async def _turn_dark(self) -> None:
        self._dark.toggle()
        await self.enter()


async def show(server: ServerState) -> None:
    """Build the page for a browser that has just opened it."""
    client = ui.context.client
    with ui.column().classes("absolute-center items-center") as waiting:
        ui.spinner(size="lg")
        ui.label("seamap_rt")
    await client.connected(timeout=20)
    await asyncio.to_thread(import_module, "seamap_rt.app.design_view")
    width, height, dark = await ui.run_javascript(
        "[window.innerWidth, window.innerHeight, window.matchMedia('(prefers-color-scheme: dark)').matches]", timeout=10
    )
    waiting.delete()
    await Page(server, server.tab(client.tab_id or client.id), int(width), int(height), bool(dark)).enter()


# ----------------------------------------------------------------------------------- what places are made of

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


class Images:
    """A place for figures; one that is drawn anew keeps its element. columns: side by side where the window is wide;
    small: which fit a phone."""

    def __init__(self, *, columns: bool = False, small: bool = False) -> None:
        self._place = ui.element("div").classes("w-full min-w-0 grid gap-2 grid-cols-1")
        self._place.classes(_COLUMNS[small or columns, small])
        self._shown: dict[str, tuple[ui.label, ui.element, ui.label]] = {}

    def show(self, images: Iterable[Image]) -> None:
        """Show these images and no others."""
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
        """Drop the drawing that is shown, and the one that is on its way."""
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


def make_stage() -> tuple[ui.column, Canvas]:
    """A place for drawings, under the line that says what is drawn, and the canvas of it."""
    line = ui.label().classes("text-sm waits").props("role=status").mark("drawing")
    stage = ui.column().classes("w-full min-w-0")

    def grey(words: str) -> None:
        line.set_text(words)
        for each in (line, stage):
            each.classes(add="stale") if words else each.classes(remove="stale")

    return stage, Canvas(grey)
