"""Maps side by side: pictures in one graph, zoomed together, with the values under the pointer in a line below."""

from __future__ import annotations

import base64
from collections.abc import Callable
from typing import Any

import numpy as np
from nicegui import events, ui

from . import drawing
from .drawing import MapPanels, Panel, Raster
from .page import Page

_BAR, _BETWEEN, _TITLE = 62.0, 30.0, 40.0  # pixels: bar of colours, between panels, above one
_ELSE, _LEAST = 330.0, 180.0  # pixels of the window beside maps, and a map's least height
PHONE = 640  # pixels: a window so wide has maps one below the other
_SEEN = 0.95  # of the cells that all panels know lie in the part that is shown first


class MapsPanel:
    """Panels on one raster, as large as the window shows them together, on the part of the sea that is seen.

    picked: called with east and north [m] of a point that is clicked.
    """

    def __init__(self, page: Page, picked: Callable[[float, float], None]) -> None:
        self._page, self._picked = page, picked
        self._shown: MapPanels | None = None
        self._drawn = False  # by the browser, which loads the graphs' code first
        self.plot = ui.plotly(drawing.empty_figure(page.dark)).classes("w-full").mark("maps")
        self.readout = ui.label("Point at a map for its values; click to cut along that look.")
        self.readout.classes("text-sm figure-value").props("aria-live=polite").mark("readout")
        self.plot.on("plotly_hover", self._hover, args=["points"], throttle=0.06)
        self.plot.on("plotly_click", self._click, args=["points"])
        self.plot.on("plotly_afterplot", self._note_drawn, args=[], throttle=5.0)

    def show(self, shown: MapPanels, line: Any = None) -> None:
        """New panels. line: from where to where one is drawn on each, as pairs of east and north [m]."""
        self._shown = shown
        self.plot.update_figure(maps_graph(shown, self._page.width, self._page.height, self._page.dark, line))

    def frame(self, shown: MapPanels) -> None:
        """Another turn on the panels that are shown."""
        self._shown = shown
        for image, source in zip(self.plot.figure["layout"]["images"], shown.pictures, strict=True):  # type: ignore[index]
            image["source"] = source
        if self._drawn:
            sources = {f"images[{i}].source": source for i, source in enumerate(shown.pictures)}
            self.plot.run_plot_method("relayout", sources)
        else:
            self.plot.update()

    def _note_drawn(self) -> None:
        self._drawn = True

    def _hover(self, event: events.GenericEventArguments) -> None:
        place = point_of(event)
        if place is not None and self._shown is not None:
            self.readout.set_text(describe(self._shown, *place))

    def _click(self, event: events.GenericEventArguments) -> None:
        place = point_of(event)
        if place is not None:
            self._picked(*place)


def point_of(event: events.GenericEventArguments) -> tuple[Any, float] | None:
    """Where a person points in a graph: x, which may be words, and y."""
    try:
        point = event.args["points"][0]
        return point["x"], float(point["y"])
    except (KeyError, IndexError, TypeError, ValueError):
        return None


def describe(shown: MapPanels, east: float, north: float) -> str:
    """The values at a place, in words."""
    raster = shown.raster
    column = int(np.clip(np.rint((east - raster.x[0]) / raster.step), 0, raster.x.size - 1))
    row = int(np.clip(np.rint((north - raster.y[0]) / raster.step), 0, raster.y.size - 1))
    distance, bearing = np.hypot(east, north), np.degrees(np.arctan2(east, north)) % 360.0
    words = [f"{distance:.0f} m at {bearing:.0f}°"]
    for panel, values in zip(shown.panels, shown.values, strict=True):
        value, sign = float(values[row, column]), "+" if panel.scale.low < 0.0 else ""
        value_words = f"{value:{sign}.{panel.digits}f} {panel.unit}".strip() if np.isfinite(value) else "not known"
        words.append(f"{panel.title.lower()} {value_words}")
    return " · ".join(words)


def maps_graph(shown: MapPanels, width: int, height: int, dark: bool, line: Any = None) -> drawing.Figure:
    """Panels in as many columns as make them largest in a window [pixels]; on a phone one below the other. line: from
    where to where one is drawn on each, as pairs of east and north [m]."""
    count = len(shown.panels)
    west, east, south, north = _first_view(shown)
    inner = max(min(width, 1900) - 92, 240)  # without the margins of the page and of the graph

    def size(columns: int) -> tuple[float, int, int, float]:
        """High, then what else is better: fewer rows, and fewer columns; and wide."""
        wide, rows = inner / columns - (_BAR if columns == 1 else _BAR + _BETWEEN), -(-count // columns)
        highest = np.inf if width < PHONE else max((height - _ELSE) / rows - _TITLE, _LEAST)
        return min(wide * (north - south) / (east - west), highest), -rows, -columns, wide

    columns = 1 if width < PHONE else max(range(1, count + 1), key=size)
    rows, (high, *_, wide) = -(-count // columns), size(columns)
    drawn = min(wide, high * (east - west) / (north - south))
    row_high = high + _TITLE
    whole = rows * row_high
    box_west, box_east, box_south, box_north = shown.raster.box
    look = drawing.layout(
        dark, "", int(whole + 44), showlegend=False, hovermode="closest", uirevision="maps",
        margin={"l": 48, "r": 8, "t": 4, "b": 40}, images=[], annotations=[], shapes=[],
    )  # fmt: skip
    data: list[drawing.Figure] = []
    for i, (panel, source) in enumerate(zip(shown.panels, shown.pictures, strict=True)):
        axes = {"xref": _axis("x", i), "yref": _axis("y", i)}
        column, row = i % columns, i // columns
        left = column * (drawn + _BAR + _BETWEEN) / inner
        right = left + drawn / inner
        top = 1.0 - (row * row_high + _TITLE) / whole
        bottom = max(1.0 - (row + 1) * row_high / whole, 0.0)
        kept = {"constrain": "domain", "showgrid": False, "zeroline": False}
        look[_axis("xaxis", i)] = drawing.axis(
            "East (m)" if row == rows - 1 else "", dark, domain=[left, right], anchor=axes["yref"],
            range=[west, east], **kept, **({"matches": "x"} if i else {}),
        )  # fmt: skip
        look[_axis("yaxis", i)] = drawing.axis(
            "North (m)" if column == 0 else "", dark, domain=[bottom, top], anchor=axes["xref"],
            range=[south, north], scaleanchor=axes["xref"], **kept, **({"matches": "y"} if i else {}),
        )  # fmt: skip
        look["images"].append({
            "source": source, **axes, "x": box_west, "y": box_north, "sizex": box_east - box_west,
            "sizey": box_north - box_south, "sizing": "stretch", "layer": "below",
        })  # fmt: skip
        look["annotations"].append({
            "text": drawing.text(panel.title + (f" ({panel.unit})" if panel.unit else "")), "xref": "paper",
            "yref": "paper", "x": left, "y": top, "xanchor": "left", "yanchor": "bottom", "showarrow": False,
            "font": {"size": 13},
        })  # fmt: skip
        if line is not None:
            (x0, y0), (x1, y1) = line
            dotted = {"color": drawing.ink(dark), "width": 1, "dash": "dot"}
            look["shapes"].append({"type": "line", **axes, "x0": x0, "y0": y0, "x1": x1, "y1": y1, "line": dotted})
        data += _traces(i, panel, shown.raster, dark, right, bottom, top)
    return drawing.figure(data, look, drawing.CONFIG)


def _first_view(shown: MapPanels) -> tuple[float, float, float, float]:
    """West, east, south and north of the part that is shown first: where all panels have values."""
    raster, (west, east, south, north) = shown.raster, shown.raster.box
    rows, columns = np.nonzero(np.all([np.isfinite(each) for each in shown.values], axis=0))
    if not rows.size:
        return west, east, south, north
    reach = 1.1 * float(np.quantile(np.hypot(raster.x[columns], raster.y[rows]), _SEEN)) + raster.step
    return max(west, -reach), min(east, reach), max(south, -reach), min(north, reach)


def _traces(
    i: int, panel: Panel, raster: Raster, dark: bool, right: float, bottom: float, top: float
) -> list[drawing.Figure]:
    """What the pointer meets (one cell a point, see-through), the bar of colours, and the antenna."""
    axes = {"xaxis": _axis("x", i), "yaxis": _axis("y", i)}
    zeros = base64.b64encode(bytes(raster.y.size * raster.x.size)).decode("ascii")
    met = {
        "type": "heatmap", **axes, "x0": float(raster.x[0]), "dx": raster.step, "y0": float(raster.y[0]),
        "dy": raster.step, "z": {"dtype": "u1", "bdata": zeros, "shape": f"{raster.y.size}, {raster.x.size}"},
        "opacity": 0.0, "showscale": False, "hoverinfo": "none",
    }  # fmt: skip
    bar = {
        "type": "scatter", **axes, "x": [0], "y": [0], "mode": "markers", "hoverinfo": "skip",
        "marker": {
            "symbol": "triangle-up", "size": 9, "color": [panel.scale.low], "cmin": panel.scale.low,
            "cmax": panel.scale.high, "colorscale": panel.scale.stops(), "showscale": True,
            "line": {"width": 1, "color": drawing.ink(dark)},
            "colorbar": {
                "x": right + 0.005, "xanchor": "left", "y": 0.5 * (bottom + top), "len": top - bottom,
                "thickness": 10, "tickfont": {"size": 10},
            },
        },
    }  # fmt: skip
    return [met, bar]


def _axis(name: str, index: int) -> str:
    return name if index == 0 else f"{name}{index + 1}"
