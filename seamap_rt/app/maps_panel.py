"""Maps side by side: pictures in one graph, zoomed together, with the values under the pointer in a line below."""

from __future__ import annotations

import base64
from collections.abc import Callable, Sequence
from typing import TYPE_CHECKING, Any

import numpy as np
from nicegui import events, ui
from numpy.typing import NDArray

from . import drawing
from .drawing import MapPanels, Panel, Raster

if TYPE_CHECKING:
    from .page import Page

Array = NDArray[np.floating]

_BAR, _BETWEEN, _TITLE = 62.0, 30.0, 40.0  # pixels: bar of colours, between panels, above one
_ELSE, _LEAST = 330.0, 180.0  # pixels of the window beside maps, and a map's least height
PHONE = 640  # pixels: a window so wide has maps one below the other
_SEEN = 0.95  # of the cells that all panels know lie in the part that is shown first


class MapsPanel:
    """Panels on one raster, as large as the window shows them together, on the part of the sea that is seen.

    picked: called with east and north [m] of a point that is clicked.
    """

    def __init__(self, page: Page, picked: Callable[[float, float], None]) -> None:
        self._width, self._height, self._dark, self._picked = page.width, page.height, page.dark, picked
        self._panels: Sequence[Panel] = ()
        self._raster: Raster | None = None
        self._values: Sequence[Array] = ()
        self._pictures: Sequence[str] = ()
        self._drawn = False  # by the browser, which loads the graphs' code first
        self.plot = ui.plotly(drawing.nothing(page.dark)).classes("w-full").mark("maps")
        self.readout = ui.label("Point at a map for its values; click to cut along that look.")
        self.readout.classes("text-sm figure-value").props("aria-live=polite").mark("readout")
        self.plot.on("plotly_hover", self._hover, args=["points"], throttle=0.06)
        self.plot.on("plotly_click", self._click, args=["points"])
        self.plot.on("plotly_afterplot", self._was_drawn, args=[], throttle=5.0)

    def show(self, shown: MapPanels, line: Any = None) -> None:
        """New panels."""
        self._panels, self._raster, self._values, self._pictures = shown
        self.plot.update_figure(self._figure(line))

    def frame(self, shown: MapPanels) -> None:
        """Another turn on the panels that are shown."""
        self._values, self._pictures = shown.values, shown.pictures
        for image, source in zip(self.plot.figure["layout"]["images"], shown.pictures, strict=True):  # type: ignore[index]
            image["source"] = source
        if self._drawn:
            sources = {f"images[{i}].source": source for i, source in enumerate(shown.pictures)}
            self.plot.run_plot_method("relayout", sources)
        else:
            self.plot.update()

    def _was_drawn(self) -> None:
        self._drawn = True

    # ------------------------------------------------------------------------------------------------ the graph

    def _seen(self) -> tuple[float, float, float, float]:
        """West, east, south and north of the part that is shown first: where all panels have values."""
        assert self._raster is not None
        raster, (west, east, south, north) = self._raster, self._raster.box
        rows, columns = np.nonzero(np.all([np.isfinite(each) for each in self._values], axis=0))
        if not rows.size:
            return west, east, south, north
        reach = 1.1 * float(np.quantile(np.hypot(raster.x[columns], raster.y[rows]), _SEEN)) + raster.step
        return max(west, -reach), min(east, reach), max(south, -reach), min(north, reach)

    def _images(self) -> list[drawing.Figure]:
        assert self._raster is not None
        west, east, south, north = self._raster.box
        return [
            {
                "source": source, "xref": _axis("x", i), "yref": _axis("y", i), "x": west, "y": north,
                "sizex": east - west, "sizey": north - south, "sizing": "stretch", "layer": "below",
            }
            for i, source in enumerate(self._pictures)
        ]  # fmt: skip

    def _shapes(self, line: Any) -> list[drawing.Figure]:
        if line is None:
            return []
        (x0, y0), (x1, y1) = line
        look = {"color": drawing.ink(self._dark), "width": 1, "dash": "dot"}
        ends = {"type": "line", "x0": x0, "y0": y0, "x1": x1, "y1": y1, "line": look}
        return [{**ends, "xref": _axis("x", i), "yref": _axis("y", i)} for i in range(len(self._panels))]

    def _figure(self, line: Any) -> drawing.Figure:
        assert self._raster is not None
        count = len(self._panels)
        west, east, south, north = self._seen()
        inner = max(min(self._width, 1900) - 92, 240)  # without the margins of the page and of the graph

        def size(columns: int) -> tuple[float, int, int, float]:
            """High, then what else is better: fewer rows, and fewer columns; and wide."""
            wide, rows = inner / columns - (_BAR if columns == 1 else _BAR + _BETWEEN), -(-count // columns)
            highest = np.inf if self._width < PHONE else max((self._height - _ELSE) / rows - _TITLE, _LEAST)
            return min(wide * (north - south) / (east - west), highest), -rows, -columns, wide

        columns = 1 if self._width < PHONE else max(range(1, count + 1), key=size)
        rows, (high, *_, wide) = -(-count // columns), size(columns)
        drawn = min(wide, high * (east - west) / (north - south))
        row_high = high + _TITLE
        whole = rows * row_high
        look = drawing.layout(
            self._dark, "", int(whole + 44), showlegend=False, hovermode="closest",
            margin={"l": 48, "r": 8, "t": 4, "b": 40},
        )  # fmt: skip
        data: list[drawing.Figure] = []
        notes = []
        for i, panel in enumerate(self._panels):
            column, row = i % columns, i // columns
            left = column * (drawn + _BAR + _BETWEEN) / inner
            right = left + drawn / inner
            top = 1.0 - (row * row_high + _TITLE) / whole
            bottom = 1.0 - (row + 1) * row_high / whole
            linked = {} if i == 0 else {"matches": "x"}
            look[_axis("xaxis", i)] = drawing.axis(
                "East (m)" if row == rows - 1 else "", self._dark, domain=[left, right], anchor=_axis("y", i),
                range=[west, east], constrain="domain", showgrid=False, zeroline=False, **linked,
            )  # fmt: skip
            look[_axis("yaxis", i)] = drawing.axis(
                "North (m)" if column == 0 else "", self._dark, domain=[max(bottom, 0.0), top], anchor=_axis("x", i),
                range=[south, north], scaleanchor=_axis("x", i), constrain="domain", showgrid=False, zeroline=False,
                **({} if i == 0 else {"matches": "y"}),
            )  # fmt: skip
            unit = f" ({panel.unit})" if panel.unit else ""
            notes.append({
                "text": drawing.text(panel.title + unit), "xref": "paper", "yref": "paper", "x": left, "y": top,
                "xanchor": "left", "yanchor": "bottom", "showarrow": False, "font": {"size": 13},
            })  # fmt: skip
            data += self._traces(i, panel, right, max(bottom, 0.0), top)
        look.update(images=self._images(), annotations=notes, shapes=self._shapes(line), uirevision="maps")
        return drawing.figure(data, look, drawing.CONFIG)

    def _traces(self, i: int, panel: Panel, right: float, bottom: float, top: float) -> list[drawing.Figure]:
        """What the pointer meets (one cell a point, see-through), the bar of colours, and the antenna."""
        assert self._raster is not None
        raster, axes = self._raster, {"xaxis": _axis("x", i), "yaxis": _axis("y", i)}
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
                "line": {"width": 1, "color": drawing.ink(self._dark)},
                "colorbar": {
                    "x": right + 0.005, "xanchor": "left", "y": 0.5 * (bottom + top), "len": top - bottom,
                    "thickness": 10, "tickfont": {"size": 10},
                },
            },
        }  # fmt: skip
        return [met, bar]

    # ---------------------------------------------------------------------------------------------- the pointer

    def _place(self, event: events.GenericEventArguments) -> tuple[float, float] | None:
        try:
            point = event.args["points"][0]
            return float(point["x"]), float(point["y"])
        except (KeyError, IndexError, TypeError, ValueError):
            return None

    def _hover(self, event: events.GenericEventArguments) -> None:
        place = self._place(event)
        if place is not None:
            self.readout.set_text(self.describe(*place))

    def _click(self, event: events.GenericEventArguments) -> None:
        place = self._place(event)
        if place is not None:
            self._picked(*place)

    def describe(self, east: float, north: float) -> str:
        """The values at a place, in words."""
        raster = self._raster
        if raster is None:
            return ""
        column = int(np.clip(np.rint((east - raster.x[0]) / raster.step), 0, raster.x.size - 1))
        row = int(np.clip(np.rint((north - raster.y[0]) / raster.step), 0, raster.y.size - 1))
        distance, bearing = np.hypot(east, north), np.degrees(np.arctan2(east, north)) % 360.0
        words = [f"{distance:.0f} m at {bearing:.0f}°"]
        for panel, values in zip(self._panels, self._values, strict=True):
            value = float(values[row, column])
            sign = "+" if panel.scale.low < 0.0 else ""
            shown = f"{value:{sign}.{panel.digits}f} {panel.unit}".strip() if np.isfinite(value) else "not known"
            words.append(f"{panel.title.lower()} {shown}")
        return " · ".join(words)


def _axis(name: str, index: int) -> str:
    return name if index == 0 else f"{name}{index + 1}"
