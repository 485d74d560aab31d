"""The wave gauges of a run: what their wires recorded beside what the maps say of the same places."""

from __future__ import annotations

from dataclasses import replace
from typing import TYPE_CHECKING, Any, NamedTuple

import numpy as np
import xarray as xr
from nicegui import ui

from ..gauges import judge_one
from ..io.growing_file import GrowingFile, read_whole_turns
from ..report.gauge_figures import gauge_picture
from . import drawing
from .prospects_view import number
from .results import Results
from .widgets import Image, Images, drawn

if TYPE_CHECKING:
    from .see_view import SeeView
    from .views import Source

_TURN = ("height", "height_std", "seen_time", "quality", "seen_true_height", "seen_cell_height")
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


def has_gauges(results: Results) -> bool:
    """Whether a run writes, or wrote, what gauges read."""
    path = results.folder / "gauges.nc"
    return path.exists() or any(results.folder.glob(f".{path.name}*"))


def read_gauges(results: Results) -> xr.Dataset:
    """All whole turns (schema `gauges`), also while they grow. OSError where there are none yet."""
    return read_whole_turns(results.folder / "gauges.nc", _read)


def _read(file: GrowingFile) -> xr.Dataset:
    def values(name: str) -> np.ndarray[Any, Any]:
        return np.asarray(file.array(name)[:])

    names = [each.decode("utf-8", "replace") if isinstance(each, bytes) else str(each) for each in values("gauge")]
    variables: dict[str, Any] = {name: (("gauge", "turn"), values(name)) for name in _TURN if name in file}
    variables |= {name: (("gauge",), values(name)) for name in ("east", "north")}
    if "true_height" in file:
        variables["true_height"] = ("gauge", "sample"), values("true_height")
    coordinates = {"gauge": names, "turn": values("turn"), "time": (("sample",), values("time"))}
    return xr.Dataset(variables, coordinates)


class Told(NamedTuple):
    """Of one gauge up to a turn, and what gauges there are."""

    names: list[str]
    name: str
    place: str
    images: list[Image]
    judged: dict[str, Any]


def told_of(source: Source, turn: int, chosen: str | None, dark: bool) -> Told | None:
    """What there is up to a turn of the gauge that is chosen, else of the first; None of a run without gauges."""
    if not has_gauges(source.results):
        return None
    read = read_gauges(source.results)
    names = [str(each) for each in read["gauge"].values]
    name = chosen if chosen in names else names[0]
    gauge = read.sel(gauge=name)
    east, north = (float(gauge[each]) for each in ("east", "north"))
    place = f"At {np.hypot(east, north):.0f} m, {np.degrees(np.arctan2(east, north)) % 360.0:.0f}°."
    picture = gauge_picture(names.index(name), name, gauge, source.results.turns()[turn])
    return Told(names, name, place, drawn([replace(picture, name="gauge")], dark), judge_one(gauge))


class GaugePanel:
    """One gauge at a time."""

    def __init__(self, view: SeeView) -> None:
        self.view = view
        self._filling = False
        self._said = ui.label().classes("text-sm").props("role=status").mark("gauge-words")
        with ui.column().classes("w-full min-w-0 gap-2") as self._body:
            self._choice = ui.select({}, label="Wave gauge", on_change=self._chosen)
            self._choice.props("dense outlined options-dense").classes("w-64 max-w-full").mark("gauge")
            self._images = Images()
            self._tiles = ui.element("div").classes("w-full grid gap-2 grid-cols-2 md:grid-cols-4").mark("gauge-tiles")
        self._body.set_visibility(False)

    async def show(self, source: Source, turn: int) -> None:
        """What there is up to now, with the turn marked."""
        told = await drawing.slow(told_of, source, turn, self._choice.value, self.view.page.dark)
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
        self._images.show(told.images)
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
