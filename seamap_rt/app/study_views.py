"""Folders without turns: a shadowing study, as its own figure, and the sea on file, in the pictures that it has."""

from __future__ import annotations

import asyncio
from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np
import xarray as xr
from nicegui import ui

from ..errors import InputError
from ..io.opening import load, open_dataset, open_file
from ..report.page_elements import Picture
from ..studies.shadowing import RADAR_LEVEL_DB
from ..studies.shadowing_figures import LOOK_WORDS, draw_shadowing
from . import drawing
from .runs import address
from .widgets import Image, Images, drawn

if TYPE_CHECKING:
    from .see_view import SeeView

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
        self._look = ui.select(LOOK_WORDS, value="all looks", label="Look", on_change=self._chosen)
        self._look.props("dense outlined options-dense").classes("w-72 max-w-full").mark("shadowing-look")
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
    return in_words(data, look), drawn([picture], dark)


def in_words(data: xr.Dataset, look: str) -> str:
    """Where half of the sea is hidden, mast by mast."""
    told = []
    for height in data["height"].values:
        mast = data.sel(height=height, look=look)
        half, smith = float(mast["look_r50"]), float(mast["look_r50_smith"]) if "look_r50_smith" in mast else np.nan
        where = f"beyond {half:.0f} m" if np.isfinite(half) else f"nowhere up to {float(data['range'][-1]):.0f} m"
        beside = [("Smith", smith)]
        if "look_radar_r50" in mast:
            radar = mast["look_radar_r50"].sel(level=RADAR_LEVEL_DB)
            beside = [
                (str(each), float(radar.sel(polarization=each))) for each in radar["polarization"].values
            ] + beside
        known = ", ".join(f"{name} {to:.0f} m" for name, to in beside if np.isfinite(to))
        told.append(f"{height:g} m: {where}" + (f" ({known})" if known else ""))
    level = f" VV and HH: where {RADAR_LEVEL_DB:g} dB are left of its power." if "level" in data else ""
    return f"Half of the sea is hidden, {LOOK_WORDS.get(look, look)}, from a mast of {'; '.join(told)}.{level}"


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
