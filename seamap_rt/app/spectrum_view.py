"""The wave spectrum of the maps beside the true one: by frequency, and by frequency and direction on one scale."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

import numpy as np
from nicegui import ui
from numpy.typing import NDArray

from ..errors import SchemaError
from . import drawing, figures
from .figures import Figure
from .map_spectrum import Density, MapSpectra, map_spectra
from .views import Source

if TYPE_CHECKING:
    from .prospects import Prospects
    from .see_view import SeeView

_POINTS = 81  # a side of a directional spectrum
_MARGIN = {"l": 50, "r": 10, "t": 30, "b": 66}


class SpectrumPanel:
    """Spectra of the last turns up to the one that is shown."""

    def __init__(self, view: SeeView) -> None:
        self.view = view
        blank = figures.figure([], figures.layout(view.page.dark))
        ui.label("Wave spectrum").classes("text-base font-bold")
        self._said = ui.label().classes("text-sm").props("role=status").mark("spectrum-words")
        with ui.column().classes("w-full min-w-0 gap-2") as self._body:
            self._density = ui.plotly(blank).classes("w-full min-w-0").mark("spectrum")
            with ui.element("div").classes("w-full grid gap-2 grid-cols-1 lg:grid-cols-2") as self._both:
                self._true = ui.plotly(blank).classes("w-full min-w-0").mark("spectrum-true")
                self._retrieved = ui.plotly(blank).classes("w-full min-w-0").mark("spectrum-retrieved")
        self._body.set_visibility(False)

    async def show(self, source: Source, turn: int) -> None:
        """Of the turns up to one."""
        try:
            said, density, roses = await drawing.slow(spectrum_of, source, turn, self.view.page.dark)
        except (SchemaError, KeyError, ValueError) as error:  # maps of another program
            self._said.set_text(f"No spectrum: {error}")
            self._body.set_visibility(False)
            return
        self._said.set_text(said)
        self._body.set_visibility(density is not None)
        if density is None:
            return
        self._density.update_figure(density)
        for plot, rose in zip((self._true, self._retrieved), roses, strict=True):
            plot.set_visibility(rose is not None)
            if rose is not None:
                plot.update_figure(rose)


def spectrum_of(source: Source, turn: int, dark: bool) -> tuple[str, Figure | None, tuple[Figure | None, ...]]:
    """What is said of the spectra up to a turn; graphs by frequency, and by direction of the true and the mapped."""
    found = map_spectra(source, turn)
    if found.retrieved is None and found.true is None:
        return found.why, None, ()
    turns = f"the last {found.turns} turns" if found.turns > 1 else "this turn"
    both = ((found.true, "True sea"), (found.retrieved, "By the maps"))
    tops = [float(each.directional.max()) for each, _ in both if each is not None and each.directional is not None]
    top = max(tops, default=0.0)
    roses = tuple(
        _by_direction(each, top, title, dark)
        if each is not None and each.directional is not None and top > 0.0
        else None
        for each, title in both
    )
    said = f"Of {turns}, in the frame of the water. {found.why}"
    return said, _by_frequency(found, source.expected(), dark), roses


def _by_frequency(found: MapSpectra, law: Prospects | None, dark: bool) -> Figure:
    data: list[Figure] = []
    if law is not None and law.spectrum.density.any():
        step = 360.0 / law.spectrum.direction.size
        whole = law.spectrum.density.sum(axis=1) * step
        data.append(figures.line(law.spectrum.frequency, whole, "of the design", figures.GREY, dash="dot"))
    if found.true is not None:
        data.append(
            figures.line(
                found.true.frequency,
                found.true.density,
                "true sea, mean over the map's cells",
                figures.ink(dark),
                dash="dash",
            )
        )
    if found.retrieved is not None:
        data.append(figures.line(found.retrieved.frequency, found.retrieved.density, "by the maps", figures.VERMILION))
    look = figures.layout(
        dark, "Wave spectrum by frequency", 340, margin=_MARGIN,
        xaxis=figures.axis("Frequency (Hz)", dark, rangemode="tozero"),
        yaxis=figures.axis("m²/Hz", dark, rangemode="tozero"),
    )  # fmt: skip
    return figures.figure(data, look, figures.CONFIG)


def _by_direction(density: Density, top: float, title: str, dark: bool) -> Figure:
    """Over the directions that waves come from, north up; frequency grows outwards."""
    side, values = _rose(density)
    frequency = float(side[-1])
    picture: dict[str, Any] = {
        "type": "heatmap", "x": figures.plain(side, 3), "y": figures.plain(side, 3), "z": figures.plain(values, 3),
        "colorscale": "Viridis", "zmin": 0.0, "zmax": top,
        "colorbar": {"title": {"text": "m²/Hz/°", "side": "right"}, "thickness": 10, "len": 0.9},
        "hovertemplate": "%{x:.2f} Hz east, %{y:.2f} Hz north: %{z:.4f}<extra></extra>",
    }  # fmt: skip
    look = figures.layout(
        dark, f"{title}: directions they come from", 360, showlegend=False, hovermode="closest",
        xaxis=figures.axis("Hz, east", dark, range=[-frequency, frequency], constrain="domain", zeroline=False),
        yaxis=figures.axis(
            "Hz, north", dark, range=[-frequency, frequency], scaleanchor="x", constrain="domain", zeroline=False
        ),
        margin={"l": 46, "r": 8, "t": 30, "b": 42},
    )  # fmt: skip
    return figures.figure([picture], look)


def _rose(density: Density) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
    """A square of frequencies [Hz] towards east and north (p,), and the density there (p, p)."""
    assert density.directional is not None
    step = float(density.bins[1] - density.bins[0])
    top = float(density.bins[-1] + 0.5 * step)
    side = np.linspace(-top, top, _POINTS)
    east, north = np.meshgrid(side, side)
    radius, bearing = np.hypot(east, north), np.degrees(np.arctan2(east, north)) % 360.0
    row = np.minimum((radius / step).astype(int), density.bins.size - 1)
    column = (bearing * density.direction.size / 360.0).astype(int) % density.direction.size
    return side, np.where(radius < top, density.directional[row, column], np.nan)
