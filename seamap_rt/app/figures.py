"""What all graphs of the page share, as Plotly's plain tables: colours as in the report, fonts, axes, light or dark."""

from __future__ import annotations

import html
from collections.abc import Sequence
from typing import Any

import numpy as np
from numpy.typing import ArrayLike

Figure = dict[str, Any]
CONFIG: Figure = {
    "displaylogo": False,
    "responsive": True,
    "scrollZoom": False,
    "modeBarButtonsToRemove": ["lasso2d", "select2d"],
}
QUIET_CONFIG: Figure = {"displayModeBar": False, "responsive": True}

# Those of `report.style`, which takes a second to load.
BLUE, VERMILION, GREEN, SKY, ORANGE, PURPLE = "#0072b2", "#d55e00", "#009e73", "#56b4e9", "#e69f00", "#cc79a7"
GREY = "#767676"


def ink(dark: bool) -> str:
    """Of text and main lines."""
    return "#e8eaed" if dark else "#1b1f23"


def faint(dark: bool) -> str:
    """Of grids."""
    return "#3a424b" if dark else "#dfe3e7"


def plain(values: ArrayLike, digits: int = 5) -> list[Any]:
    """Numbers as JSON has them: what is not finite is null."""
    array = np.asarray(values, dtype=np.float64)
    if array.ndim > 1:
        return [plain(row, digits) for row in array]
    return [float(f"{each:.{digits}g}") if np.isfinite(each) else None for each in array]


def text(words: str) -> str:
    """Words in which Plotly finds no markup."""
    return html.escape(words, quote=False)


def line(x: ArrayLike, y: ArrayLike, name: str, colour: str, **more: Any) -> Figure:
    """A curve. dash: solid, dash or dot."""
    dash = more.pop("dash", "solid")
    return {
        "type": "scatter",
        "mode": "lines",
        "x": plain(x),
        "y": plain(y),
        "name": text(name),
        "line": {"color": colour, "dash": dash, "width": 2},
        **more,
    }


def band(x: ArrayLike, low: ArrayLike, high: ArrayLike, name: str, colour: str, share: float = 0.25) -> list[Figure]:
    """What lies between two curves, each unbroken piece for itself: where nothing is known there is none."""
    red, green, blue = (int(colour[place : place + 2], 16) for place in (1, 3, 5))
    along, below, above = (np.asarray(each, dtype=np.float64) for each in (x, low, high))
    known = np.concatenate(([False], np.isfinite(below) & np.isfinite(above), [False]))
    begin, end = np.flatnonzero(known[1:] & ~known[:-1]), np.flatnonzero(known[:-1] & ~known[1:])
    outline_x: list[Any] = []
    outline_y: list[Any] = []
    for a, b in zip(begin, end, strict=True):
        outline_x += [*plain(along[a:b]), *plain(along[a:b][::-1]), None]
        outline_y += [*plain(below[a:b]), *plain(above[a:b][::-1]), None]
    return [
        {
            "type": "scatter", "mode": "lines", "x": outline_x, "y": outline_y, "fill": "toself", "hoverinfo": "skip",
            "fillcolor": f"rgba({red},{green},{blue},{share})", "line": {"width": 0}, "name": text(name),
        }
    ]  # fmt: skip


def axis(title: str, dark: bool, **more: Any) -> Figure:
    """One axis."""
    return {
        "title": {"text": text(title), "standoff": 6},
        "gridcolor": faint(dark),
        "zerolinecolor": faint(dark),
        "linecolor": ink(dark),
        "ticks": "outside",
        "ticklen": 3,
        "automargin": True,
        **more,
    }


def layout(dark: bool, title: str = "", height: int = 260, **more: Any) -> Figure:
    """What goes round the axes."""
    return {
        "title": {"text": text(title), "font": {"size": 13}, "x": 0.01, "xanchor": "left", "y": 0.98, "yanchor": "top"},
        "font": {"family": "Roboto, sans-serif", "size": 12, "color": ink(dark)},
        "paper_bgcolor": "rgba(0,0,0,0)",
        "plot_bgcolor": "rgba(0,0,0,0)",
        "margin": {"l": 50, "r": 12, "t": 30, "b": 64},
        "height": height,
        "showlegend": True,
        "legend": {
            "orientation": "h",
            "x": 0,
            "y": 0.0,
            "yref": "container",
            "yanchor": "bottom",
            "font": {"size": 11},
        },
        "hovermode": "x unified",
        "hoverlabel": {"bgcolor": "#1f2933" if dark else "#ffffff", "font": {"color": ink(dark)}},
        **more,
    }


def figure(data: Sequence[Figure], look: Figure, config: Figure = QUIET_CONFIG) -> Figure:
    """A whole graph, as `ui.plotly` takes it."""
    return {"data": list(data), "layout": look, "config": config}
