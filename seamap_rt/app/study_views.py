"""Views of the report's figures: a run's wave gauges, a shadowing study, and the sea on file in its pictures."""

from __future__ import annotations

import asyncio
from dataclasses import replace
from pathlib import Path
from typing import TYPE_CHECKING, Any, NamedTuple

import numpy as np
import xarray as xr
from nicegui import ui

from ..errors import InputError
from ..gauges import judge_one
from ..io.opening import load, open_dataset, open_file
from ..io.turn_files import GrowingFile, read_whole_turns
from ..report.gauge_figures import gauge_picture
from ..report.page_elements import Picture
from ..studies.shadowing_figures import LOOK_WORDS, draw_shadowing
from ..tracing.visibility import SEEN_DB
from . import drawing
from .results import Results
from .runs import address
from .widgets import Image, Images, choice, draw_images, number, tile

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


class GaugeView(NamedTuple):
    """Of one gauge up to a turn, and what gauges there are."""

    names: list[str]
    name: str
    place: str
    images: list[Image]
    judged: dict[str, Any]


def view_gauge(source: Source, turn: int, chosen: str | None, dark: bool) -> GaugeView | None:
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
    return GaugeView(names, name, place, draw_images([replace(picture, name="gauge")], dark), judge_one(gauge))


class GaugePanel:
    """One gauge at a time."""

    def __init__(self, view: SeeView) -> None:
        self.view = view
        self._filling = False
        self._said = ui.label().classes("text-sm").props("role=status").mark("gauge-words")
        with ui.column().classes("w-full min-w-0 gap-2") as self._body:
            self._choice = choice("Wave gauge", "gauge", on_change=self._chosen)
            self._images = Images()
            self._tiles = ui.element("div").classes("w-full grid gap-2 grid-cols-2 md:grid-cols-4").mark("gauge-tiles")
        self._body.set_visibility(False)

    async def show(self, source: Source, turn: int) -> None:
        """What there is up to now, with the turn marked."""
        told = await drawing.slow(view_gauge, source, turn, self._choice.value, self.view.page.dark)
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
                with tile(words)[1]:
                    ui.label(f"{number(value, digits)} {unit}".strip()).classes("font-bold figure-value")


PICTURES = {  # that the sea on file has, with what they show
    "from_mast.png": "The sea from the mast, rendered with the sun's light",
    "sea_surface.png": "The sea from above",
    "sea.gif": "The sea in motion",
    "directional_spectrum.png": "Its spectrum by frequency and direction",
}
_MOST_TEXT = 20_000


def read_shadowing(folder: Path) -> xr.Dataset:
    """Of a finished study. OSError where there is none."""
    path = folder / "shadowing.nc"
    with open_dataset(path) as opened:
        return load(opened, path.name, path)


class ShadowingPanel:
    """One study; the look is chosen."""

    def __init__(self, view: SeeView) -> None:
        self.view = view
        self._folder = Path()
        self._said = ui.label().classes("font-bold").mark("shadowing-words")
        self._look = choice("Look", "shadowing-look", LOOK_WORDS, value="all looks", on_change=self._chosen)
        self._images = Images()

    async def show_folder(self, folder: Path) -> None:
        """Of a folder. OSError, KeyError where it holds no study."""
        self._folder = folder
        said, images = await drawing.slow(shadowing_of, folder, str(self._look.value), self.view.page.dark)
        self._said.set_text(said)
        self._images.show(images)

    def _chosen(self) -> None:
        self.view.draw_beside(self.show_folder(self._folder), self._folder.name)


def shadowing_of(folder: Path, look: str, dark: bool) -> tuple[str, list[Image]]:
    """A study in words, and its figure for a look."""
    data = read_shadowing(folder)
    picture = Picture(
        "shadowing",
        "Visible share of the sea",
        f"Visible share of the sea against ground range for each mast, {LOOK_WORDS[look]}, beside the curves of Smith "
        "and Wagner; and the range beyond which half is hidden, by the look.",
        "Smith, Wagner: closed forms for a sea of normally distributed slopes.",
        lambda: draw_shadowing(data, (look,)),
    )
    return in_words(data, look), draw_images([picture], dark)


def in_words(data: xr.Dataset, look: str) -> str:
    """Where half of the sea is hidden, mast by mast."""
    told = []
    for height in data["height"].values:
        mast = data.sel(height=height, look=look)
        half, smith = float(mast["look_r50"]), float(mast["look_r50_smith"]) if "look_r50_smith" in mast else np.nan
        where = f"beyond {half:.0f} m" if np.isfinite(half) else f"nowhere up to {float(data['range'][-1]):.0f} m"
        beside = [("Smith", smith)]
        if "look_radar_r50" in mast:
            radar = mast["look_radar_r50"].sel(level=SEEN_DB)
            beside = [
                (str(each), float(radar.sel(polarization=each))) for each in radar["polarization"].values
            ] + beside
        known = ", ".join(f"{name} {to:.0f} m" for name, to in beside if np.isfinite(to))
        told.append(f"{height:g} m: {where}" + (f" ({known})" if known else ""))
    level = f" VV and HH: where {SEEN_DB:g} dB are left of its power." if "level" in data else ""
    return f"Half of the sea is hidden, {LOOK_WORDS.get(look, look)}, from a mast of {'; '.join(told)}.{level}"


class PicturedPanel:
    """Pictures one below the other, then what was counted."""

    def __init__(self, view: SeeView) -> None:
        self.view = view
        self._place = ui.column().classes("w-full min-w-0 gap-3").mark("pictures")

    async def show_folder(self, folder: Path) -> None:
        """Of a folder below the runs."""
        name = folder.relative_to(self.view.page.server.roots.runs).as_posix()
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
