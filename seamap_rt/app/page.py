"""The page: its head, its places, what all open pages share, and the state of the browser tab that it is shown in."""

from __future__ import annotations

import asyncio
from dataclasses import dataclass
from importlib import import_module
from itertools import count
from pathlib import Path
from typing import TYPE_CHECKING, Any

from nicegui import ui

from ..io.scenefile import list_shipped
from . import drawing
from .folders import Roots, kind_of
from .jobs import Queue

if TYPE_CHECKING:
    from ..scene import Scene
    from .draft import Draft


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

    def awaited(self, folder: str) -> bool:
        """Whether results of a folder's name are there, or come; not those of a job that came to nothing."""
        job, path = self.queue.of_folder(folder), self.roots.runs / folder
        return (job is not None and not job.over) or (path.is_dir() and kind_of(path) is not None)

    def free_folder(self, wanted: str) -> str:
        """A name for results that no folder and no job has: the wanted one, or with a number."""
        taken = {job.folder for job in self.queue.jobs() if not job.over}
        names = (wanted if number == 1 else f"{wanted}-{number}" for number in count(1))
        return next(name for name in names if name not in taken and not (self.roots.runs / name).exists())

    def tab(self, name: str) -> Tab:
        """Of a browser tab by the name that it gives itself; a new one begins with choppy_sea."""
        from .draft import Draft

        tab = self._tabs.pop(name, None) or Tab(Draft.shipped("choppy_sea", self.roots))
        self._tabs[name] = tab  # the one used last is the last
        while len(self._tabs) > _MOST_TABS:
            self._tabs.pop(next(iter(self._tabs)))
        return tab


def load(module: str) -> None:
    """In a process that draws: a module itself cannot be handed back."""
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
            self.tabs: Any = ui.tabs().props("dense no-caps inline-label outside-arrows mobile-arrows")
            self.tabs.classes("grow min-w-0").props('align="left"')
            with self.tabs:
                for name in PLACES:
                    ui.tab(name).mark(f"place-{name}")
            ui.button(icon="dark_mode", on_click=self._turn_dark).props(
                'flat dense round color=white aria-label="Light or dark"'
            )
        self.tabs.value = tab.place
        self._dark = ui.dark_mode(dark)
        with ui.tab_panels(self.tabs, value=tab.place, animated=False, keep_alive=True).classes("w-full"):
            for name in PLACES:
                with ui.tab_panel(name).classes("p-2 sm:p-3"):
                    self._holders[name] = ui.column().classes("w-full")
        self.tabs.on_value_change(lambda e: self._went(e.value))
        self._went(tab.place)

    @property
    def dark(self) -> bool:
        return bool(self._dark.value)

    def _went(self, name: str) -> None:
        self.tab.place = name
        ui.timer(0.0, self._enter, once=True)

    async def _enter(self) -> None:
        """The view of the place that is shown is made when it is first gone to."""
        name = self.tab.place
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
        if self.tabs.value == place:
            self._went(place)
        else:
            self.tabs.value = place

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

    def _turn_dark(self) -> None:
        self._dark.toggle()
        self._went(self.tab.place)


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
    Page(server, server.tab(client.tab_id or client.id), int(width), int(height), bool(dark))
