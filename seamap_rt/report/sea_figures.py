"""Pictures of the sea itself: a moment of its surface and of what the radar sees of it, an animation.

Maps have north up and east right; arrows point where waves go.
"""

from __future__ import annotations

from collections.abc import Iterator
from typing import Any

import numpy as np
import xarray as xr
from matplotlib.axes import Axes
from matplotlib.cm import ScalarMappable
from matplotlib.colors import Normalize, to_rgb
from matplotlib.figure import Figure
from numpy.typing import NDArray
from PIL import Image
from scipy.ndimage import map_coordinates

from ..conventions import unit_from_azimuth
from ..physics import dispersion
from ..scene import Scene
from . import reduce, style
from .reduce import Array
from .style import gif

_SHADOW = "#8f8f8f"
_MAP = 3.02  # inches a side
_WAVES_BESIDE = 4.0  # lengths of the main wave that the section shows to either side of the antenna
_ARROWS = 48
_MOST_FRAMES = 80
_MOST_GIF_PIXELS = 8e6  # of all frames together: about 4 MB
_GIF_SIDE = (260, 560)  # pixels, least and most


# ------------------------------------------------------------------------------------------------------ the surface


@style.styled
def sea_surface(scene: Scene, moment: xr.Dataset) -> Figure:
    """Map of the elevation, map of the radar cross section with its shadows, and a section along the main waves.

    moment: the schema's `sea` at one time.
    """
    figure = style.new_figure(6.45)
    points, t = moment["x"].values, float(moment["time"].values)
    lefts, top = (0.56, style.WIDTH - 0.12 - _MAP), 0.3
    height = moment["sea_surface_height"].values
    limit = _height_limit(height)
    colours = ScalarMappable(Normalize(-limit, limit), style.HEIGHT_COLOURS)
    axes = style.place(figure, lefts[0], top, _MAP, _MAP)
    _map(axes, points, _shaded(scene, moment, colours), f"(a) Height of the sea, shaded, at {t:.4g} s")
    axes.set_ylabel("North of antenna (m)", labelpad=1.0)
    _arrow(axes, scene)
    style.colour_bar(figure, colours, lefts[0] + 0.2, 3.7, _MAP - 0.4, "Height above mean sea level (m)", "both")

    level, visible = moment["nrcs_db"].values, moment["visible"].values
    low, high = (reduce.quantile(level, share) for share in (0.03, 0.995))
    known = np.isfinite(low) and high > low
    colours = ScalarMappable(Normalize(low, high) if known else Normalize(0.0, 1.0), style.POWER_COLOURS)
    picture = colours.to_rgba(np.where(np.isfinite(level), level, low if known else 0.0))[..., :3]
    picture[visible == 0] = to_rgb(_SHADOW)
    picture[visible < 0] = 1.0
    axes = style.place(figure, lefts[1], top, _MAP, _MAP)
    _map(axes, points, picture, "(b) Radar cross section per area; grey: shadow")
    style.colour_bar(figure, colours, lefts[1] + 0.2, 3.7, _MAP - 0.4, "σ⁰ towards the radar (dB)", "both")
    _section(style.place(figure, lefts[0], 4.6, style.WIDTH - lefts[0] - 0.12, 1.35), scene, moment)
    return figure


def _height_limit(height: NDArray[Any]) -> float:
    """Half the span of the height scale, m."""
    limit = reduce.quantile(np.abs(height), 0.999)
    return limit if limit > 1e-3 else 0.05


def _shaded(scene: Scene, moment: xr.Dataset, colours: ScalarMappable) -> Array:
    """Colours of the height (y, x, 3), darker where the sea leans away from a light 30° beside the main waves."""
    waves = reduce.main_waves(scene)
    east, north = (float(part) for part in unit_from_azimuth((waves.from_deg if waves is not None else 270.0) + 30.0))
    towards = -(moment["slope_x"].values * east + moment["slope_y"].values * north)
    spread = float(towards.std())
    shade = np.clip(0.86 + 0.14 * towards / spread, 0.5, 1.0) if spread > 0.0 else np.ones_like(towards)
    return np.asarray(colours.to_rgba(moment["sea_surface_height"].values))[..., :3] * shade[..., None]


def _map(axes: Axes, points: Array, picture: Array, title: str) -> None:
    """A square picture (y, x, 3), its first row the southernmost."""
    borders = reduce.edges(points)
    axes.imshow(
        picture, origin="lower", extent=(borders[0], borders[-1], borders[0], borders[-1]),
        interpolation="antialiased", interpolation_stage="rgba",
    )  # fmt: skip
    axes.set_aspect("equal")
    axes.set_title(title)
    axes.set_xlabel("East of antenna (m)", labelpad=1.0)
    style.mark_antenna(axes)
    style.few_ticks(axes)


def _arrow(axes: Axes, scene: Scene) -> None:
    """Where the main waves go, in the upper left corner; north is up."""
    waves = reduce.main_waves(scene)
    if waves is None:
        return
    east, north = (0.055 * float(part) for part in unit_from_azimuth(waves.from_deg + 180.0))
    axes.annotate(
        "", xy=(0.09 + east, 0.91 + north), xytext=(0.09 - east, 0.91 - north), xycoords="axes fraction",
        textcoords="axes fraction",
        bbox={"boxstyle": "circle"}, arrowprops={"arrowstyle": "-|>", "linewidth": 1.6, "mutation_scale": 11.0},
    )  # fmt: skip


def _section(axes: Axes, scene: Scene, moment: xr.Dataset) -> None:
    """Height and water velocity along the main waves through the antenna; what the radar sees is drawn thick."""
    waves = reduce.main_waves(scene)
    points = moment["x"].values
    toward = (waves.from_deg + 180.0) % 360.0 if waves is not None else 90.0
    east, north = (float(part) for part in unit_from_azimuth(toward))
    reach = 0.98 * float(points[-1])
    if waves is not None:
        k = float(dispersion.wavenumber(2.0 * np.pi / waves.peak_period, scene.sea.depth_m))
        reach = min(reach, _WAVES_BESIDE * 2.0 * np.pi / k)
    along = np.linspace(-reach, reach, 1201)
    index = np.stack((along * north - points[0], along * east - points[0])) / (points[1] - points[0])

    def sample_line(name: str, order: int = 1) -> Array:
        return map_coordinates(moment[name].values.astype(np.float64), index, order=order, mode="nearest")

    height, visible = sample_line("sea_surface_height"), sample_line("visible", order=0)
    style.graph(axes, f"Distance along the main waves, towards {toward:.4g}° (m)", "Height (m)", "")
    axes.plot(along, height, color=_SHADOW, linewidth=0.8, label="sea")
    axes.plot(along, np.where(visible > 0, height, np.nan), color=style.BLUE, linewidth=1.8, label="seen by the radar")
    axes.set_xlim(-reach, reach)
    limit = 1.9 * max(float(np.abs(height).max()), 0.05)
    axes.set_ylim(-limit, limit)
    every = slice(along.size // (2 * _ARROWS), None, along.size // _ARROWS)
    outward, upward = east * sample_line("velocity_x") + north * sample_line("velocity_y"), sample_line("velocity_z")
    fastest = max(float(np.hypot(outward, upward).max()), 1e-6)
    arrows = axes.quiver(
        along[every], height[every], outward[every], upward[every], angles="uv",
        scale=28.0 * fastest, width=0.0016, color=style.VERMILION, zorder=3.0,
    )  # fmt: skip
    key = float(f"{fastest:.1g}")
    axes.quiverkey(
        arrows, 0.95, 1.07, key, f"water: {key:g} m/s", labelpos="W", fontproperties={"size": style.FONT - 0.5}
    )
    box = axes.get_window_extent()
    exaggeration = (box.height / limit) / (box.width / reach)
    axes.set_title(f"(c) Section through the antenna, waves go right; heights drawn {exaggeration:.2g} times too high")
    axes.legend(loc="lower right", ncols=2)


# ------------------------------------------------------------------------------------------------------ animation


@style.styled
def animation(scene: Scene, moments: xr.Dataset) -> bytes:
    """A GIF of the elevation that plays in real time, over and over; of very many times every nth is shown.

    moments: the schema's `sea` with two times or more [s].
    """
    times = moments["time"].values
    chosen = np.arange(0, times.size, int(np.ceil(times.size / _MOST_FRAMES)))
    side = int(np.clip(np.sqrt(_MOST_GIF_PIXELS / chosen.size), *_GIF_SIDE))
    waits = np.diff(times[chosen])
    milliseconds = [round(1e3 * float(wait)) for wait in (*waits, np.median(waits))]
    return gif(list(_frames(scene, moments, chosen, side)), milliseconds)


def _frames(scene: Scene, moments: xr.Dataset, chosen: NDArray[np.intp], side: int) -> Iterator[Image.Image]:
    """The map of the elevation at the chosen times."""
    inches = side / style.DPI
    figure = style.new_figure(inches + 0.12, inches, style.DPI)
    axes = figure.add_axes((0.16, 0.12, 0.81, 0.81 * inches / (inches + 0.12)))
    limit = _height_limit(moments["sea_surface_height"].isel(time=0).values)
    colours = ScalarMappable(Normalize(-limit, limit), style.HEIGHT_COLOURS)
    for number, index in enumerate(chosen):
        moment = moments.isel(time=int(index))
        title = f"t = {float(moment['time'].values):.2f} s; colours ±{limit:.2g} m"
        picture = _shaded(scene, moment, colours)
        if number == 0:
            _map(axes, moments["x"].values, picture, title)
            axes.set_ylabel("North of antenna (m)", labelpad=1.0)
            _arrow(axes, scene)
        axes.images[0].set_data(picture)
        axes.set_title(title)
        figure.canvas.draw()
        yield style.snapshot(figure)
