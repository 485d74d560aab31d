"""The sea itself in three dimensions, in the sun's light and the radar's shadow, or as one sees it from the mast.

From the mast a column of the picture is a vertical plane: along it, the first point that rises over all nearer ones is
what is seen. Water mirrors the sky by Fresnel's law (Schlick 1994), and the sun about the direction in which it would
be seen in a mirror; the rest is the light that comes back from within, lit as Lambert's law has it.
"""

from __future__ import annotations

import asyncio
import base64
import io
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Any

import matplotlib as mpl
import numpy as np
from nicegui import ui
from numpy.typing import NDArray
from PIL import Image
from scipy.ndimage import gaussian_filter, map_coordinates

from ..conventions import turn_name
from ..errors import InputError
from ..io.opening import open_file
from ..report import style
from . import drawing
from .folders import address
from .maps_panel import PHONE
from .page import flat_button, slider
from .source import Source

if TYPE_CHECKING:
    from .see_view import SeeView


Array = NDArray[np.float64]

SUN_ELEVATION_DEG = 25.0
_WIDE_DEG, _PIXELS, _LINES = 70.0, 960, 400
_SKY_SHARE = 0.2  # of the picture above the horizon
_STEPS = 700
_MIRROR = 0.02  # of light that falls straight down
_ROUGH = 0.15  # rms slope of waves that no map resolves
_FALLS, _LEFT = 5.0 * np.exp(-2.69 * _ROUGH), 1.0 + 22.7 * _ROUGH**1.5  # of a rough sea's mirror
_GLINT_DEG = 9.0  # half width of the sun's image: slopes of waves that no map resolves
_LOW_SKY, _HIGH_SKY = np.array([0.93, 0.91, 0.84]), np.array([0.42, 0.62, 0.83])
_WATER, _SUN, _UNKNOWN = np.array([0.04, 0.16, 0.25]), np.array([1.0, 0.93, 0.78]), np.array([0.62, 0.61, 0.58])
_GROUND_SHADE = 0.45  # of the light that comes from all the sky


def sun(azimuth_deg: float, elevation_deg: float = SUN_ELEVATION_DEG) -> Array:
    """Unit vector to the sun, east north up."""
    high, angle = np.radians(elevation_deg), np.radians(azimuth_deg)
    return np.array([np.cos(high) * np.sin(angle), np.cos(high) * np.cos(angle), np.sin(high)])


def lambert(height: Array, x: Array, y: Array, to_sun: Array, exaggerated: float = 1.0) -> Array:
    """Brightness (y, x) from 0 to 1 of a surface over x and y: the sky's share, and the sun's by the cosine of its
    angle to the normal. exaggerated: how many times too high it is drawn."""
    rise_y, rise_x = np.gradient(exaggerated * np.nan_to_num(height), y, x)
    cosine = (to_sun[2] - rise_x * to_sun[0] - rise_y * to_sun[1]) / np.sqrt(1.0 + rise_x**2 + rise_y**2)
    return _GROUND_SHADE + (1.0 - _GROUND_SHADE) * np.clip(cosine, 0.0, 1.0)


@dataclass(frozen=True)
class SightLines:
    """What each point (line, pixel) of a picture from the mast shows: distance ahead [m], infinite where it is the flat
    sea beyond the map, NaN in the sky; its place east and north [m]."""

    ahead: Array
    east: Array
    north: Array


def sight_lines(height: Array, x: Array, y: Array, mast_m: float, look_deg: float) -> SightLines:
    """height (y, x) [m]; what is not known counts as mean sea level. mast_m: of the eye. look_deg: of the picture's
    middle."""
    along, aside, rows = _rays(look_deg)
    first, last = 0.6 * mast_m / abs(rows[-1]), float(np.hypot(np.abs(x).max(), np.abs(y).max()))
    steps = np.geomspace(max(first, 0.5), max(last, 2.0 * first), _STEPS)
    east, north = (steps[:, None] * (along[i] + aside[i]) for i in (0, 1))
    rising = (_interpolate(np.nan_to_num(height), x, y, east, north) - mast_m) / steps[:, None]
    horizon = np.maximum.accumulate(rising, axis=0)
    below = rows < 0.0
    number = np.full((_LINES, _PIXELS), -1)
    for column in range(_PIXELS):
        number[below, column] = np.searchsorted(horizon[:, column], rows[below])
    known = (number >= 0) & (number < _STEPS)
    ahead = np.where(known, steps[np.clip(number, 0, _STEPS - 1)], np.where(number >= _STEPS, np.inf, np.nan))
    reach = np.where(np.isfinite(ahead), ahead, 0.0)
    return SightLines(ahead, *(reach * (along[i] + aside[i]) for i in (0, 1)))


def mast_picture(height: Array, x: Array, y: Array, known: NDArray[np.bool_], mast_m: float, look_deg: float) -> bytes:
    """A JPEG. known (y, x): where there is a height; in the looked-at area the others are grey."""
    seen = sight_lines(height, x, y, mast_m, look_deg)
    along, aside, rows = _rays(look_deg)
    sun_high = sun(look_deg + 20.0)
    sight = np.stack([
        np.broadcast_to(along[0] + aside[0], seen.ahead.shape), np.broadcast_to(along[1] + aside[1], seen.ahead.shape),
        np.broadcast_to(rows[:, None], seen.ahead.shape),
    ], axis=-1)  # fmt: skip
    sight = sight / np.linalg.norm(sight, axis=-1, keepdims=True)
    rise_y, rise_x = np.gradient(np.nan_to_num(height), y, x)
    slopes = [_interpolate(each, x, y, seen.east, seen.north) for each in (rise_x, rise_y)]
    flat = ~np.isfinite(seen.ahead)
    slopes = [np.where(flat, 0.0, each) for each in slopes]
    colour = _water_colour(sight, slopes[0], slopes[1], sun_high)
    colour = np.where(np.isnan(seen.ahead)[..., None], _sky_colour(sight, sun_high), colour)
    gaps = (_interpolate(1.0 * known, x, y, seen.east, seen.north) < 0.5) & ~flat
    gaps &= (np.abs(seen.east) <= np.abs(x).max()) & (np.abs(seen.north) <= np.abs(y).max())
    colour = np.where(gaps[..., None], 0.5 * (_UNKNOWN + colour), colour)
    file = io.BytesIO()
    Image.fromarray(np.rint(255.0 * np.clip(colour, 0.0, 1.0)).astype(np.uint8)).save(file, "JPEG", quality=82)
    return file.getvalue()


def _rays(look_deg: float) -> tuple[Array, Array, Array]:
    """Ahead (2,), aside (2, pixel), east and north for each metre ahead; and how far lines rise (line,) for each."""
    angle, half = np.radians(look_deg), np.tan(np.radians(0.5 * _WIDE_DEG))
    across = np.linspace(-half, half, _PIXELS)
    pixel = across[1] - across[0]
    rows = pixel * (_SKY_SHARE * _LINES - np.arange(_LINES) - 0.5)
    aside = np.stack([across * np.cos(angle), -across * np.sin(angle)])
    return np.array([np.sin(angle), np.cos(angle)]), aside, rows


def _interpolate(values: Any, x: Array, y: Array, east: Array, north: Array) -> Array:
    """Values of a field (y, x) on even cells, interpolated bilinearly; 0 outside."""
    place = np.stack([(north - y[0]) / (y[1] - y[0]), (east - x[0]) / (x[1] - x[0])])
    return map_coordinates(np.asarray(values, dtype=np.float64), place, order=1)


def _water_colour(sight: Array, rise_x: Array, rise_y: Array, to_sun: Array) -> Array:
    """Colour (line, pixel, 3) of water of some slopes."""
    normal = np.stack([-rise_x, -rise_y, np.ones_like(rise_x)], axis=-1)
    normal /= np.linalg.norm(normal, axis=-1, keepdims=True)
    facing = np.clip(-np.sum(normal * sight, axis=-1), 0.0, 1.0)[..., None]
    mirrored = sight + 2.0 * facing * normal
    mirrored[..., 2] = np.abs(mirrored[..., 2])  # once more off the water, if it goes down
    share = _MIRROR + (1.0 - _MIRROR) * (1.0 - facing) ** _FALLS / _LEFT
    lit = _GROUND_SHADE + (1.0 - _GROUND_SHADE) * np.clip(normal @ to_sun, 0.0, 1.0)[..., None]
    apart = np.degrees(np.arccos(np.clip(mirrored @ to_sun, -1.0, 1.0)))[..., None]
    glint = 1.1 * np.exp(-0.5 * (apart / _GLINT_DEG) ** 2)
    return share * _sky_colour(mirrored, to_sun) + (1.0 - share) * _WATER * (1.6 * lit) + glint * share**0.5 * _SUN


def _sky_colour(toward: Array, to_sun: Array) -> Array:
    """Colour of the sky in some directions (…, 3)."""
    high = np.clip(toward[..., 2:], 0.0, 1.0) ** 0.5
    about = np.clip(toward @ to_sun, 0.0, 1.0)[..., None] ** 24
    return _LOW_SKY + (_HIGH_SKY - _LOW_SKY) * high + 0.12 * about * _SUN


_MOST = 141  # points a side
_AROUND = 1.3  # of the distance up to which nearly all heights lie
_DARKENED = 0.45  # of a colour in the shadow
_SOFT = 0.7  # points: of the shadow's edge
_EXAGGERATED = 3.0  # heights, but for those that are seen from the mast
_SUN_FROM_DEG = 225.0
_FURTHER = 1.7
_VIEWS = {"above": "From above", "side": "From the side", "mast": "From the mast"}


def sea_surface(source: Source, turn: int, retrieved: bool) -> tuple[NDArray, NDArray, NDArray, NDArray, float]:
    """East (x,), north (y,), height (y, x) [m], share in sight (y, x), and the half span of the heights.

    Of the sea about the part that was measured.
    """
    distance = np.hypot(*np.meshgrid(source.layout.x, source.layout.y))
    seen = source.covered_cells(turn)
    if source.results.has_maps:
        known = np.isfinite(source.results.field("maps/ground/height", turn))
        seen &= distance <= (_AROUND * np.quantile(distance[known], 0.95) if known.any() else np.inf)
    step = max(1, -(-int(max(seen.any(axis=0).sum(), seen.any(axis=1).sum())) // _MOST))
    x, y, seen = source.layout.x[::step], source.layout.y[::step], seen[::step, ::step]
    height = _heights(source, turn, retrieved)[::step, ::step]
    height = np.where(seen, height, np.nan)
    rows, columns = np.flatnonzero(seen.any(axis=1)), np.flatnonzero(seen.any(axis=0))
    down, along = slice(rows[0], rows[-1] + 1), slice(columns[0], columns[-1] + 1)
    x, y, height = x[along], y[down], height[down, along]
    lit = _visible_fraction(source, turn, x, y) if source.results.has_truth else np.ones(height.shape)
    limit = float(np.nanquantile(np.abs(height), 0.995)) if np.isfinite(height).any() else 1.0
    return x, y, height, lit, max(limit, 0.05)


def _heights(source: Source, turn: int, retrieved: bool) -> Array:
    """(y, x): as they are, or as they were retrieved where that is asked for or all there is."""
    results = source.results
    true = results.has_truth and not (retrieved and results.has_maps)
    return results.field("truth/ground/height" if true else "maps/ground/height", turn).astype(np.float64)


def _visible_fraction(source: Source, turn: int, x: NDArray, y: NDArray) -> Array:
    visible = source.results.field("truth/polar/visible_fraction", turn)
    east, north = np.meshgrid(x, y)
    bearing = np.degrees(np.arctan2(east, north))
    looks = source.layout.azimuth
    order = np.argsort(looks % 360.0)
    ring = (looks % 360.0)[order]
    look = order[np.searchsorted(ring, bearing % 360.0) % ring.size]
    gate = np.clip(np.searchsorted(source.ground_m, np.hypot(east, north)), 0, source.ground_m.size - 1)
    return gaussian_filter(np.nan_to_num(visible[look, gate]).astype(np.float64), _SOFT)


class SeaPanel:
    """A surface that is turned by the pointer, or what one sees from the mast."""

    def __init__(self, view: SeeView) -> None:
        self.view = view
        with ui.row().classes("w-full items-center gap-3"):
            self._camera = ui.toggle(_VIEWS, value="above", on_change=view.redraw).props("dense no-caps").mark("camera")
            self._camera.props('aria-label="Where one looks from"')
            self._retrieved = ui.checkbox("as retrieved", on_change=view.redraw).props("dense")
        self.plot = ui.plotly(drawing.empty_figure(view.page.dark)).classes("w-full").mark("sea-3d")
        with ui.column().classes("w-full gap-1") as self._mast:
            self._picture = ui.element("img").classes("w-full max-w-5xl rounded").mark("from-mast")
            self._picture.props('alt="The sea as one sees it from the mast"')
            with ui.row().classes("w-full max-w-5xl items-center no-wrap gap-2"):
                ui.label("Look").classes("text-sm")
                at = round(view.azimuth) % 360
                self._look = slider("Azimuth of the look", "mast-look", view.redraw, 0, 359, at)
        self._mast.set_visibility(False)
        self._status = ui.label().classes("text-xs opacity-80").mark("sea-words")
        with ui.row().classes("w-full items-center gap-2") as self._render:
            flat_button("Render from the mast", icon="photo_camera", on_click=self._queue_shown, mark="render")
            ui.label(
                "Some seconds: the run's own sea at this moment, with waves that no map resolves, by a ray tracer."
            ).classes("text-xs opacity-80")

    async def show(self, source: Source, turn: int) -> None:
        """The sea of a turn."""
        self._shown = source, turn
        self._retrieved.set_visibility(source.results.has_maps and source.results.has_truth)
        self._render.set_visibility(source.scene is not None)
        camera, mast = str(self._camera.value), self._camera.value == "mast"
        self.plot.set_visibility(not mast)
        self._mast.set_visibility(mast)
        retrieved = bool(self._retrieved.value)
        if mast:
            azimuth = float(self._look.value or 0.0)
            made = await drawing.slow(draw_from_mast, source, turn, retrieved, azimuth)
            self._picture.props["src"] = f"data:image/jpeg;base64,{base64.b64encode(made).decode('ascii')}"
            self._status.set_text(
                f"From {source.height_m:.1f} m, towards {azimuth:.0f}°, the sun {SUN_ELEVATION_DEG:.0f}° high. "
                "Heights are true; waves shorter than the map's cells are left out, and beyond it the sea is flat."
                + (" Grey: no height was retrieved." if retrieved or not source.results.has_truth else "")
            )
            return
        page = self.view.page
        self.plot.update_figure(
            await drawing.slow(sea_figure, source, turn, retrieved, camera, page.dark, page.width < PHONE)
        )
        self._status.set_text(
            "Lit by a sun that stands low in the south-west. "
            + ("Dark: hidden from the antennas behind crests. " if source.results.has_truth else "")
            + "Heights are drawn three times too large."
        )

    def _queue_shown(self) -> None:
        """The sea on file at this moment, by the command line in a process of its own; seen when it is done."""
        source, turn = self._shown
        scene, server = source.scene, self.view.page.server
        name = source.results.folder.relative_to(server.roots.runs).as_posix()
        folder = f"{name}_sea_{turn_name(source.results.turns()[turn]).replace(' ', '')}"
        if scene is not None and not server.is_awaited(folder):
            words = ["sea", "{scene}", "--out", "{out}", f"--times={source.results.time(turn):.3f}"]
            server.queue.add(f"the sea of {name} from the mast", folder, scene.to_toml(), words, 15.0)
        self.view.page.see(folder)


def sea_figure(source: Source, turn: int, retrieved: bool, camera: str, dark: bool, narrow: bool) -> drawing.Figure:
    """The surface with the mast. camera: above or side. narrow: for a phone, from further away."""
    x, y, height, lit, limit = sea_surface(source, turn, retrieved)
    mast_m = source.height_m
    surface = _mesh(x, y, height, lit, limit)
    mast = {
        "type": "scatter3d", "x": [0, 0], "y": [0, 0], "z": [0, mast_m], "mode": "lines+markers",
        "line": {"color": style.ORANGE, "width": 6}, "marker": {"size": 3, "color": style.ORANGE},
        "hoverinfo": "skip", "showlegend": False,
    }  # fmt: skip
    wide = max(float(np.ptp(x)), float(np.ptp(y)), 1.0)
    axes = {
        name: {"title": {"text": words}, "gridcolor": drawing.grid_colour(dark), "color": drawing.ink(dark)}
        for name, words in (("xaxis", "East (m)"), ("yaxis", "North (m)"), ("zaxis", "Height (m)"))
    }  # fmt: skip
    top = max(limit, mast_m)
    axes["zaxis"]["range"] = [-1.2 * limit, 1.1 * top]
    ratio = {
        "x": float(np.ptp(x)) / wide * 1.6,
        "y": float(np.ptp(y)) / wide * 1.6,
        "z": _EXAGGERATED * 1.6 * (1.2 * limit + 1.1 * top) / wide,
    }
    scene = {**axes, "aspectmode": "manual", "aspectratio": ratio, "camera": _eye(camera, _FURTHER if narrow else 1.0)}
    look = drawing.layout(dark, "", 560, scene=scene, margin={"l": 0, "r": 0, "t": 0, "b": 0}, uirevision=camera)
    return drawing.figure([surface, mast], look, drawing.CONFIG)


def _eye(camera: str, apart: float) -> drawing.Figure:
    """Where one looks from, in units of the box that is drawn, whose middle is 0. apart: how many times as far."""
    eye = (0.0, -0.75, 1.95) if camera == "above" else (0.9, -0.95, 0.35)
    return {"eye": {name: apart * at for name, at in zip("xyz", eye, strict=True)}, "up": {"x": 0, "y": 0, "z": 1}}


def draw_from_mast(source: Source, turn: int, retrieved: bool, azimuth_deg: float) -> bytes:
    """What one sees at the antennas' height, a JPEG: of all cells, not of every second one."""
    height = _heights(source, turn, retrieved)
    known = np.isfinite(height) | ~source.covered_cells(turn)
    return mast_picture(height, source.layout.x, source.layout.y, known, max(source.height_m, 1.0), azimuth_deg)


def _mesh(x: NDArray, y: NDArray, height: NDArray, lit: Array, limit: float) -> drawing.Figure:
    """Two triangles a cell. Each point has the colour of its height, as bright as the sun makes it, and dark where it
    is hidden from the antennas."""
    rows, columns = height.shape
    number = np.arange(rows * columns).reshape(rows, columns)
    a, b, c, d = number[:-1, :-1], number[:-1, 1:], number[1:, :-1], number[1:, 1:]
    corners = np.concatenate([np.stack(each, axis=-1).reshape(-1, 3) for each in ((a, b, c), (b, d, c))])
    flat = height.ravel()
    corners = corners[np.isfinite(flat[corners]).all(axis=1)]
    share = np.clip(np.nan_to_num(flat) / (2.0 * limit) + 0.5, 0.0, 1.0)
    bright = lambert(height, x, y, sun(_SUN_FROM_DEG), _EXAGGERATED) * (_DARKENED + (1.0 - _DARKENED) * lit)
    bright = np.clip(bright / lambert(np.zeros((2, 2)), x[:2], y[:2], sun(_SUN_FROM_DEG))[0, 0], 0.0, 1.35)
    colour = np.clip(mpl.colormaps[style.HEIGHT_COLOURS](share)[:, :3] * bright.reshape(-1, 1), 0.0, 1.0)
    levels = np.rint(255.0 * colour).astype(int)
    east, north = np.meshgrid(x, y)
    return {
        "type": "mesh3d", "x": drawing.json_numbers(east.ravel(), 4), "y": drawing.json_numbers(north.ravel(), 4),
        "z": drawing.json_numbers(np.nan_to_num(flat), 3), "i": corners[:, 0].tolist(), "j": corners[:, 1].tolist(),
        "k": corners[:, 2].tolist(), "vertexcolor": [f"#{r:02x}{g:02x}{b:02x}" for r, g, b in levels],
        "lighting": {"ambient": 1.0, "diffuse": 0.0, "specular": 0.0, "fresnel": 0.0}, "flatshading": False,
        "hovertemplate": "%{x:.0f} m east, %{y:.0f} m north: %{z:.2f} m<extra></extra>",
    }  # fmt: skip


PICTURES = {  # that the sea on file has, with what they show
    "from_mast.png": "The sea from the mast, rendered with the sun's light",
    "sea_surface.png": "The sea from above",
    "sea.gif": "The sea in motion",
    "directional_spectrum.png": "Its spectrum by frequency and direction",
}
_MOST_TEXT = 20_000


class PicturedPanel:
    """Pictures one below the other, then what was counted."""

    def __init__(self, view: SeeView) -> None:
        self.view = view
        self._place = ui.column().classes("w-full min-w-0 gap-3").mark("pictures")

    async def show_folder(self, folder: Path) -> None:
        """Show the pictures of a folder below the runs."""
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
