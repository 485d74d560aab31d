"""Drawings: in processes of their own, so that the page answers meanwhile; what graphs of the browser are made of, as
Plotly's plain tables; and fields as small pictures.

A picture is an indexed PNG whose palette holds the colours, made in a millisecond for scrubbing.
"""

from __future__ import annotations

import asyncio
import base64
import contextlib
import html
import io
import multiprocessing
import os
import pickle
import signal
import threading
from collections.abc import Callable, Sequence
from concurrent.futures import BrokenExecutor, ProcessPoolExecutor
from dataclasses import dataclass
from functools import lru_cache
from typing import Any, NamedTuple, TypeVar

import matplotlib as mpl
import numpy as np
from matplotlib import colors
from numpy.typing import ArrayLike, NDArray
from PIL import Image

from ..conventions import ground_range
from ..report import reduce, style

Result = TypeVar("Result")
Array = NDArray[np.floating]
_LOST = "the process that draws has ended, as it does where memory runs out; choose the view again"


class DrawingProcess:
    """A process that draws one thing after another; it starts with the first. most: after so many another follows."""

    def __init__(self, most: int | None = None) -> None:
        self._most = most
        self._pool: ProcessPoolExecutor | None = None
        self._free = asyncio.Lock()

    async def __call__(self, make: Callable[..., Result], *given: Any) -> Result:
        """What a function of a module gives. Cancelled while it waits, it is never begun.

        Raises OSError where the process ended, and what the function raises.
        """
        packed = pickle.dumps((make, given))
        await self._free.acquire()
        loop = asyncio.get_running_loop()
        spawn = multiprocessing.get_context("spawn")
        pool = self._pool = self._pool or ProcessPoolExecutor(1, spawn, _begin, max_tasks_per_child=self._most)
        try:
            future = pool.submit(_call, packed)
        except BrokenExecutor as error:
            self._pool = None
            self._free.release()
            raise OSError(_LOST) from error

        def release(_: object) -> None:
            with contextlib.suppress(RuntimeError):  # the page has ended, and its loop with it
                loop.call_soon_threadsafe(self._free.release)

        future.add_done_callback(release)
        try:
            return await asyncio.wrap_future(future)
        except BrokenExecutor as error:
            self._pool = None
            raise OSError(_LOST) from error


quick, slow = DrawingProcess(), DrawingProcess()  # maps, sections, curves; what may take seconds
alone = DrawingProcess(1)  # what takes much memory


def close() -> None:
    """End what is drawn."""
    for child in multiprocessing.active_children():
        child.terminate()


def _call(packed: bytes) -> Any:
    make, given = pickle.loads(packed)  # here, so that what cannot be opened is an answer
    return make(*given)


def _begin() -> None:
    """Prepare a process that draws: it ignores Ctrl-C, and ends with the page, however that ends."""
    signal.signal(signal.SIGINT, signal.SIG_IGN)
    page = multiprocessing.parent_process()
    assert page is not None

    def follow() -> None:
        page.join()
        os._exit(0)

    threading.Thread(target=follow, daemon=True, name="follow").start()


# --------------------------------------------------------------------------------------------------------- graphs

Figure = dict[str, Any]
CONFIG: Figure = {
    "displaylogo": False,
    "responsive": True,
    "scrollZoom": False,
    "modeBarButtonsToRemove": ["lasso2d", "select2d"],
}
QUIET_CONFIG: Figure = {"displayModeBar": False, "responsive": True}


def ink(dark: bool) -> str:
    """The colour of text and main lines."""
    return "#e8eaed" if dark else "#1b1f23"


def grid_colour(dark: bool) -> str:
    """The colour of grids."""
    return "#3a424b" if dark else "#dfe3e7"


def json_numbers(values: ArrayLike, digits: int = 5) -> list[Any]:
    """Numbers as JSON has them: what is not finite is null."""
    return [float(f"{each:.{digits}g}") if np.isfinite(each) else None for each in np.asarray(values, np.float64)]


def text(words: str) -> str:
    """Words in which Plotly finds no markup."""
    return html.escape(words, quote=False)


def line(x: ArrayLike, y: ArrayLike, name: str, colour: str) -> Figure:
    """A curve."""
    return {
        "type": "scatter", "mode": "lines", "x": json_numbers(x), "y": json_numbers(y), "name": text(name),
        "line": {"color": colour, "width": 2},
    }  # fmt: skip


def band(x: ArrayLike, low: ArrayLike, high: ArrayLike, name: str, colour: str) -> Figure:
    """What lies between two curves, each unbroken piece for itself: where nothing is known there is none."""
    along, below, above = (np.asarray(each, dtype=np.float64) for each in (x, low, high))
    outline_x: list[Any] = []
    outline_y: list[Any] = []
    for a, b in pieces(np.isfinite(below) & np.isfinite(above)):
        outline_x += [*json_numbers(along[a:b]), *json_numbers(along[a:b][::-1]), None]
        outline_y += [*json_numbers(below[a:b]), *json_numbers(above[a:b][::-1]), None]
    return {
        "type": "scatter", "mode": "lines", "x": outline_x, "y": outline_y, "fill": "toself", "hoverinfo": "skip",
        "fillcolor": colors.to_hex((*colors.to_rgb(colour), 0.2), keep_alpha=True), "line": {"width": 0},
        "name": text(name),
    }  # fmt: skip


def pieces(true: NDArray[np.bool_]) -> list[tuple[int, int]]:
    """Where each unbroken piece begins, and where it has ended."""
    step = np.diff(true.astype(np.int8), prepend=0, append=0)
    return list(zip(np.flatnonzero(step == 1).tolist(), np.flatnonzero(step == -1).tolist(), strict=True))


def axis(title: str, dark: bool, **more: Any) -> Figure:
    """One axis."""
    return {
        "title": {"text": text(title), "standoff": 6},
        "gridcolor": grid_colour(dark),
        "zerolinecolor": grid_colour(dark),
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


def empty_figure(dark: bool) -> Figure:
    """The figure that stands before anything is drawn."""
    return figure([], layout(dark, xaxis={"visible": False}, yaxis={"visible": False}), CONFIG)


def figure(data: Sequence[Figure], look: Figure, config: Figure = QUIET_CONFIG) -> Figure:
    """A whole graph, as `ui.plotly` takes it."""
    return {"data": list(data), "layout": look, "config": config}


_COLOURS = 254  # of the scale; then the blank, and what is outside of all
_BLANK, _OUTSIDE = 254, 255
_RASTER = 301  # points a side of a polar map on its raster


@dataclass(frozen=True)
class Scale:
    """What colours mean: from low to high, a colour map of matplotlib's, words with the unit."""

    low: float
    high: float
    colours: str
    words: str

    def stops(self, count: int = 33) -> list[list[float | str]]:
        """The scale's colours, as Plotly takes a colour scale."""
        palette = mpl.colormaps[self.colours](np.linspace(0.0, 1.0, count))
        return [[i / (count - 1), colors.to_hex(colour)] for i, colour in enumerate(palette)]


def picture(values: Array, area: NDArray[np.bool_], scale: Scale) -> str:
    """Values (row, column), rows from south to north, as the address of a PNG with north up.

    Not finite inside of the area is grey, all outside of it is see-through.
    """
    span = max(scale.high - scale.low, 1e-12)
    finite = np.isfinite(values)
    step = np.clip((np.where(finite, values, scale.low) - scale.low) * ((_COLOURS - 1) / span), 0, _COLOURS - 1)
    index = np.where(finite, (step + 0.5).astype(np.uint8), np.uint8(_BLANK))
    index = np.where(area | finite, index, np.uint8(_OUTSIDE))
    image, file = Image.fromarray(index[::-1]), io.BytesIO()
    image.putpalette(_palette(scale.colours))
    image.save(file, "PNG", compress_level=1, transparency=_OUTSIDE)
    return f"data:image/png;base64,{base64.b64encode(file.getvalue()).decode('ascii')}"


@lru_cache(maxsize=16)
def _palette(name: str) -> bytes:
    scale = mpl.colormaps[name](np.linspace(0.0, 1.0, _COLOURS))[:, :3]
    table = np.vstack([scale, colors.to_rgb(style.BLANK), (1.0, 1.0, 1.0)])
    return np.rint(255.0 * table).astype(np.uint8).tobytes()


@dataclass(frozen=True)
class Raster:
    """Where the cells of a map lie on a grid of square picture points.

    x, y: centres of the points [m], rising. area: what the radar looks at. at: of the map's cells those at the points:
    slices of a ground map, whose own cells the points are; of a polar map the look and the gate of each point.
    """

    x: NDArray[np.float64]
    y: NDArray[np.float64]
    area: NDArray[np.bool_]
    at: tuple[Any, Any]

    def rasterize(self, values: Array) -> Array:
        """A field of the map on the raster."""
        found = values[self.at]
        return found if isinstance(self.at[0], slice) else np.where(self.area, found, np.nan)

    @property
    def step(self) -> float:
        return float(self.x[1] - self.x[0]) if self.x.size > 1 else 1.0

    @property
    def box(self) -> tuple[float, float, float, float]:
        """West, east, south and north edges."""
        half = 0.5 * self.step
        return self.x[0] - half, self.x[-1] + half, self.y[0] - half, self.y[-1] + half


def ground_raster(x: Array, y: Array, seen: NDArray[np.bool_]) -> Raster:
    """The raster of a ground map. seen (row, column): cells that have ever had a value. Cropped to them."""
    rows, columns = np.flatnonzero(seen.any(axis=1)), np.flatnonzero(seen.any(axis=0))
    if not rows.size:
        rows, columns = np.arange(y.size), np.arange(x.size)
    down = slice(max(0, int(rows[0]) - 1), int(rows[-1]) + 2)
    along = slice(max(0, int(columns[0]) - 1), int(columns[-1]) + 2)
    return Raster(x[along].astype(np.float64), y[down].astype(np.float64), seen[down, along], (down, along))


def polar_raster(azimuth_deg: Array, slant_m: Array, height_m: float) -> Raster:
    """The raster of a polar map, seen from above."""
    ground = ground_range(slant_m, height_m)
    order, borders = reduce.look_edges(azimuth_deg, 1.0)
    far, near = float(ground[-1]), float(ground[0])
    angle = np.radians(np.linspace(borders[0], borders[-1], 361))
    east, north = far * np.sin(angle), far * np.cos(angle)
    west_edge, east_edge = min(0.0, float(east.min())), max(0.0, float(east.max()))
    south_edge, north_edge = min(0.0, float(north.min())), max(0.0, float(north.max()))
    side = max(east_edge - west_edge, north_edge - south_edge) / (_RASTER - 1)
    x = np.arange(west_edge, east_edge + side, side)
    y = np.arange(south_edge, north_edge + side, side)
    over, up = np.meshgrid(x, y)
    distance = np.hypot(over, up)
    sweep = (np.degrees(np.arctan2(over, up)) - borders[0]) % 360.0
    place = np.clip(np.searchsorted(borders - borders[0], sweep, side="right") - 1, 0, order.size - 1)
    edges = reduce.edges(ground)
    gate = np.clip(np.searchsorted(edges, distance, side="right") - 1, 0, ground.size - 1)
    area = (sweep <= borders[-1] - borders[0]) & (distance >= min(near, edges[0])) & (distance <= edges[-1])
    return Raster(x, y, area, (order[place], gate))


@dataclass(frozen=True)
class Panel:
    """One map. digits: of its values, in the line below."""

    title: str
    scale: Scale
    digits: int = 2

    @property
    def unit(self) -> str:
        """The unit, which stands in brackets in the scale's words."""
        words = self.scale.words
        return words.rsplit("(", 1)[-1].rstrip(")") if "(" in words else ""


class MapPanels(NamedTuple):
    """A view of one turn. values (row, column) of each panel, on the raster; pictures: of them, as addresses."""

    panels: Sequence[Panel]
    raster: Raster
    values: Sequence[Array]
    pictures: Sequence[str]

    @classmethod
    def of(cls, panels: Sequence[Panel], raster: Raster, fields: Sequence[Array]) -> MapPanels:
        """fields: of each panel, on the cells of its map."""
        values = [raster.rasterize(each) for each in fields]
        drawn = [picture(each, raster.area, panel.scale) for panel, each in zip(panels, values, strict=True)]
        return cls(panels, raster, values, drawn)
