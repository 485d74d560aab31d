"""The sea itself in three dimensions, lit where the radar sees it and dark where crests hide it."""

from __future__ import annotations

import asyncio
from typing import TYPE_CHECKING

import matplotlib as mpl
import numpy as np
from nicegui import ui
from numpy.typing import NDArray

from ..report import style
from . import figures
from .views import Source

if TYPE_CHECKING:
    from .see_view import SeeView

_MOST = 101  # points a side
_DARKENED = 0.45  # of a colour in the shadow
_VIEWS = {"above": "From above", "side": "From the side", "mast": "From the mast"}


def sea_surface(source: Source, turn: int, retrieved: bool) -> tuple[NDArray, NDArray, NDArray, NDArray, float]:
    """East (x,), north (y,), height (y, x) [m], whether in sight (y, x), and the half span of the heights."""
    step = max(1, -(-max(source.layout.x.size, source.layout.y.size) // _MOST))
    x, y = source.layout.x[::step], source.layout.y[::step]
    mapped = source.results.has_maps
    name = "maps/ground/height" if mapped and (retrieved or not source.results.has_truth) else "truth/ground/height"
    height = source.results.field(name, turn)[::step, ::step].astype(np.float64)
    seen = source.seen(turn)[::step, ::step]
    height = np.where(seen, height, np.nan)
    rows, columns = np.flatnonzero(seen.any(axis=1)), np.flatnonzero(seen.any(axis=0))
    down, along = slice(rows[0], rows[-1] + 1), slice(columns[0], columns[-1] + 1)
    x, y, height = x[along], y[down], height[down, along]
    lit = np.ones(height.shape, dtype=bool)
    if source.results.has_truth:
        lit = _in_sight(source, turn, x, y)
    limit = float(np.nanquantile(np.abs(height), 0.995)) if np.isfinite(height).any() else 1.0
    return x, y, height, lit, max(limit, 0.05)


def _in_sight(source: Source, turn: int, x: NDArray, y: NDArray) -> NDArray[np.bool_]:
    visible = source.results.field("truth/polar/visible_fraction", turn)
    east, north = np.meshgrid(x, y)
    bearing = np.degrees(np.arctan2(east, north))
    looks = source.layout.azimuth
    order = np.argsort(looks % 360.0)
    ring = (looks % 360.0)[order]
    look = order[np.searchsorted(ring, bearing % 360.0) % ring.size]
    gate = np.clip(np.searchsorted(source.ground_m, np.hypot(east, north)), 0, source.ground_m.size - 1)
    return visible[look, gate] > 0.5


class SeaPanel:
    """A surface that is turned by the pointer, or looked at from three places."""

    def __init__(self, view: SeeView) -> None:
        self.view = view
        self._camera = "above"
        self._source: tuple[Source, int] | None = None
        with ui.row().classes("w-full items-center gap-3"):
            ui.toggle(_VIEWS, value="above", on_change=self._turned).props("dense no-caps").mark("camera")
            self._retrieved = ui.checkbox("as retrieved", on_change=self._again).props("dense")
        self.plot = ui.plotly(figures.figure([], figures.layout(view.page.dark))).classes("w-full").mark("sea-3d")
        ui.label(
            "Bright: in sight of both antennas. Dark: hidden behind crests. Heights are drawn three times too large."
        ).classes("text-xs opacity-80")

    async def show(self, source: Source, turn: int) -> None:
        """The sea of a turn."""
        self._source = source, turn
        self._retrieved.set_visibility(source.results.has_maps and source.results.has_truth)
        made = await asyncio.to_thread(sea_surface, source, turn, bool(self._retrieved.value))
        self.plot.update_figure(self._figure(*made, source.height_m))

    async def _turned(self, event) -> None:
        self._camera = event.value
        await self._again()

    async def _again(self) -> None:
        if self._source is not None:
            await self.show(*self._source)

    def _figure(self, x, y, height, lit, limit: float, mast_m: float) -> figures.Figure:
        dark = self.view.page.dark
        surface = _mesh(x, y, height, lit, limit)
        mast = {
            "type": "scatter3d", "x": [0, 0], "y": [0, 0], "z": [0, mast_m], "mode": "lines+markers",
            "line": {"color": figures.ORANGE, "width": 6}, "marker": {"size": 3, "color": figures.ORANGE},
            "hoverinfo": "skip", "showlegend": False,
        }  # fmt: skip
        wide = max(float(np.ptp(x)), float(np.ptp(y)), 1.0)
        axes = {
            name: {"title": {"text": words}, "gridcolor": figures.faint(dark), "color": figures.ink(dark)}
            for name, words in (("xaxis", "East (m)"), ("yaxis", "North (m)"), ("zaxis", "Height (m)"))
        }  # fmt: skip
        top = max(limit, mast_m)
        axes["zaxis"]["range"] = [-1.2 * limit, 1.1 * top]
        ratio = {
            "x": float(np.ptp(x)) / wide * 1.6,
            "y": float(np.ptp(y)) / wide * 1.6,
            "z": 3.0 * 1.6 * (1.2 * limit + 1.1 * top) / wide,
        }
        scene = {**axes, "aspectmode": "manual", "aspectratio": ratio, "camera": self._eye(x, y, ratio)}
        look = figures.layout(
            dark, "", 560, scene=scene, margin={"l": 0, "r": 0, "t": 0, "b": 0}, uirevision=self._camera
        )
        return figures.figure([surface, mast], look, figures.CONFIG)

    def _eye(self, x, y, ratio) -> figures.Figure:
        """Where one looks from, in units of the box that is drawn, whose middle is 0."""
        if self._camera == "above":
            return {"eye": {"x": 0.0, "y": -0.75, "z": 1.95}, "up": {"x": 0, "y": 0, "z": 1}}
        if self._camera == "side":
            return {"eye": {"x": 0.9, "y": -0.95, "z": 0.35}, "up": {"x": 0, "y": 0, "z": 1}}
        east = -float(np.mean([x[0], x[-1]])) / max(float(np.ptp(x)), 1.0) * ratio["x"]
        north = -float(np.mean([y[0], y[-1]])) / max(float(np.ptp(y)), 1.0) * ratio["y"]
        ahead = np.radians(self.view.azimuth)
        eye = {"x": east, "y": north, "z": 0.5 * ratio["z"]}
        centre = {
            "x": east + 0.5 * float(np.sin(ahead)),
            "y": north + 0.5 * float(np.cos(ahead)),
            "z": 0.5 * ratio["z"] - 0.12,
        }
        return {"eye": eye, "center": centre, "up": {"x": 0, "y": 0, "z": 1}}


def _mesh(x: NDArray, y: NDArray, height: NDArray, lit: NDArray[np.bool_], limit: float) -> figures.Figure:
    """Two triangles a cell, each in the colour of its height, darkened where it is hidden."""
    rows, columns = height.shape
    number = np.arange(rows * columns).reshape(rows, columns)
    a, b, c, d = number[:-1, :-1], number[:-1, 1:], number[1:, :-1], number[1:, 1:]
    corners = np.concatenate([np.stack(each, axis=-1).reshape(-1, 3) for each in ((a, b, c), (b, d, c))])
    flat = height.ravel()
    whole = np.isfinite(flat[corners]).all(axis=1)
    quad = 0.25 * (height[:-1, :-1] + height[:-1, 1:] + height[1:, :-1] + height[1:, 1:]).ravel()
    light = (lit[:-1, :-1] + 1.0 * lit[:-1, 1:] + lit[1:, :-1] + lit[1:, 1:]).ravel()
    level, shone = np.tile(quad, 2)[whole], np.tile(light, 2)[whole]
    corners = corners[whole]
    share = np.clip(np.where(np.isfinite(level), level, flat[corners].mean(axis=1)) / (2.0 * limit) + 0.5, 0.0, 1.0)
    seen = shone > 2.0
    colour = mpl.colormaps[style.HEIGHT_COLOURS](share)[:, :3] * np.where(seen, 1.0, _DARKENED)[:, None]
    levels = np.rint(255.0 * colour).astype(int)
    east, north = np.meshgrid(x, y)
    return {
        "type": "mesh3d", "x": figures.plain(east.ravel(), 4), "y": figures.plain(north.ravel(), 4),
        "z": figures.plain(np.nan_to_num(flat), 3), "i": corners[:, 0].tolist(), "j": corners[:, 1].tolist(),
        "k": corners[:, 2].tolist(), "facecolor": [f"#{r:02x}{g:02x}{b:02x}" for r, g, b in levels],
        "lighting": {"ambient": 0.75, "diffuse": 0.6, "specular": 0.1, "roughness": 0.7}, "flatshading": False,
        "hovertemplate": "%{x:.0f} m east, %{y:.0f} m north: %{z:.2f} m<extra></extra>",
    }  # fmt: skip
