"""A shadowing study on the page: visible share against range for each mast, beside the analytic curves."""

from __future__ import annotations

import asyncio
from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np
import xarray as xr
from nicegui import ui

from ..io.opening import load, open_dataset
from . import figures
from .figures import Figure

if TYPE_CHECKING:
    from .see_view import SeeView

_COLOURS = (figures.VERMILION, figures.BLUE, figures.GREEN, figures.ORANGE, figures.SKY, figures.GREY)
_LOOKS = {
    "all looks": "all looks",
    "along": "along the waves, up and down",
    "at 45°": "at 45° to the waves",
    "across": "across the waves",
}
_MARGIN = {"l": 50, "r": 10, "t": 30, "b": 100}


def read_shadowing(folder: Path) -> xr.Dataset:
    """Of a finished study. OSError where there is none."""
    path = folder / "shadowing.nc"
    with open_dataset(path) as opened:
        return load(opened, path.name, path)


class ShadowingPanel:
    """One study; the look is chosen."""

    def __init__(self, view: SeeView) -> None:
        self.view = view
        self._data: xr.Dataset | None = None
        blank = figures.figure([], figures.layout(view.page.dark))
        self._said = ui.label().classes("font-bold").mark("shadowing-words")
        self._look = ui.select(dict(_LOOKS), value="all looks", label="Look", on_change=self._draw)
        self._look.props("dense outlined options-dense").classes("w-72 max-w-full").mark("shadowing-look")
        self._share, self._half = (
            ui.plotly(blank).classes("w-full min-w-0").mark(name) for name in ("shadowing-share", "shadowing-half")
        )
        ui.label(
            "Bands: 95 % of what other seas of the same waves would give. Smith, Wagner: closed forms for a sea of "
            "normally distributed slopes."
        ).classes("text-xs opacity-80")

    async def show_folder(self, folder: Path) -> None:
        """Of a folder. OSError, KeyError where it holds no study."""
        self._data = await asyncio.to_thread(read_shadowing, folder)
        self._draw()

    def _draw(self) -> None:
        if self._data is None:
            return
        data, look, dark = self._data, str(self._look.value), self.view.page.dark
        self._said.set_text(in_words(data, look))
        self._share.update_figure(share_graph(data, look, dark))
        self._half.update_figure(half_graph(data, dark))


def in_words(data: xr.Dataset, look: str) -> str:
    """Where half of the sea is hidden, mast by mast."""
    told = []
    for height in data["height"].values:
        mast = data.sel(height=height, look=look)
        half, smith = float(mast["look_r50"]), float(mast["look_r50_smith"]) if "look_r50_smith" in mast else np.nan
        where = f"beyond {half:.0f} m" if np.isfinite(half) else f"nowhere up to {float(data['range'][-1]):.0f} m"
        told.append(f"{height:g} m: {where}" + (f" (Smith {smith:.0f} m)" if np.isfinite(smith) else ""))
    return f"Half of the sea is hidden, {_LOOKS.get(look, look)}, from a mast of {'; '.join(told)}."


def share_graph(data: xr.Dataset, look: str, dark: bool) -> Figure:
    """Visible share, its band, and the closed forms."""
    distance = data["range"].values
    lines: list[Figure] = []
    for height, colour in zip(data["height"].values, _cycled(data.sizes["height"]), strict=True):
        mast, name = data.sel(height=height, look=look), f"{height:g} m"
        low, high = (100.0 * mast[f"look_visible_fraction_{end}"].values for end in ("low", "high"))
        lines += [{**each, "showlegend": False} for each in figures.band(distance, low, high, name, colour, 0.15)]
        lines.append(figures.line(distance, 100.0 * mast["look_visible_fraction"].values, name, colour))
        for law, words, dash in (("look_smith", "Smith", "dash"), ("look_wagner", "Wagner", "dot")):
            lines.append(figures.line(distance, 100.0 * mast[law].values, f"{name}, {words}", colour, dash=dash))
    look_ = figures.layout(
        dark, "Visible share of the sea", 440, margin=_MARGIN,
        xaxis=figures.axis("Ground range (m)", dark, rangemode="tozero"),
        yaxis=figures.axis("%", dark, range=[0, 103]),
    )  # fmt: skip
    return figures.figure(lines, look_, figures.CONFIG)


def half_graph(data: xr.Dataset, dark: bool) -> Figure:
    """Where half is hidden, by the look from the waves; a look at which half is visible all through has no point."""
    order = np.argsort(data["from_waves"].values)
    angle = data["from_waves"].values[order]
    lines: list[Figure] = []
    for height, colour in zip(data["height"].values, _cycled(data.sizes["height"]), strict=True):
        mast, name = data.sel(height=height), f"{height:g} m"
        look = {"mode": "lines+markers"}
        lines.append(figures.line(angle, mast["r50"].values[order], name, colour, **look))
        lines.append(figures.line(angle, mast["r50_smith"].values[order], f"{name}, Smith", colour, dash="dash"))
    look = figures.layout(
        dark, "Range beyond which half is hidden, by the look", 360, margin=_MARGIN,
        xaxis=figures.axis("Look from where the waves come from (°)", dark),
        yaxis=figures.axis("m", dark, rangemode="tozero"),
    )  # fmt: skip
    return figures.figure(lines, look)


def _cycled(count: int) -> list[str]:
    return [_COLOURS[i % len(_COLOURS)] for i in range(count)]
