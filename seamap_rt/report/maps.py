"""Maps: north up, east right, equal aspect, metres from the antenna."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any, NamedTuple

import numpy as np
import xarray as xr
from matplotlib import patheffects
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.image import AxesImage
from matplotlib.patches import Rectangle, Wedge

from ..conventions import ground_range, unit_from_azimuth
from ..scene import Scene
from ..sea import wave_facts
from . import reduce, style
from .reduce import Array

LEAST_HEIGHT_SCALE_M = 0.05
LEAST_SLOPE_SCALE = 0.01
_LEFT, _GAP, _RIGHT = 0.58, 0.26, 0.12  # inches
_TOP, _TO_BAR, _LINE = 0.28, 0.37, 0.24  # above a panel, from it to its colour bar, and of a line of the key


class _Panel(NamedTuple):
    title: str
    values: Array  # (y, x)
    colours: str
    low: float
    high: float


@dataclass(frozen=True)
class _Frame:
    """What part of the ground is drawn, and how large a panel is (inches)."""

    west: float
    east: float
    south: float
    north: float
    width: float
    height: float

    def draw_bar(
        self, figure: Figure, image: Any, row_top: float, column: int | None, label: str, extend: str = "both"
    ) -> None:
        """Under the panels of a row: under one column, or None for the middle of both."""
        top, inset = row_top + self.height + _TO_BAR, 0.06 * self.width
        left, width = _LEFT + 0.5 * self.width, self.width + _GAP
        if column is not None:
            left, width = _LEFT + column * width + inset, self.width - 2 * inset
        style.colour_bar(figure, image, left, top, width, label, extend)


@style.styled
def height_maps(scene: Scene, maps: xr.DataTree, truth: xr.DataTree, turn: int = -1) -> Figure:
    """True and retrieved height on one scale, their difference, and the retrieval's own standard error."""
    x, y, true = _ground(truth, "height", turn)
    retrieved, spread = (_ground(maps, name, turn)[2] for name in ("height", "height_std"))
    true = _within_range(scene, x, y, true)
    error = retrieved - true
    frame = _frame(scene, x, y, (true, retrieved), panels=2)
    limit = height_limit(true, retrieved)
    of_error, of_spread = (
        _round_up(max(LEAST_HEIGHT_SCALE_M, _finite_or(reduce.quantile(values, share), 0.0)))
        for values, share in ((np.abs(error), 0.98), (spread, 0.95))
    )
    both = style.HEIGHT_COLOURS, -limit, limit
    panels = (
        _Panel("(a) True height", true, *both),
        _Panel("(b) Retrieved height", retrieved, *both),
        _Panel("(c) Error: retrieved − true height", error, style.HEIGHT_COLOURS, -of_error, of_error),
        _Panel("(d) Standard error that the retrieval states", spread, style.SPREAD_COLOURS, 0.0, of_spread),
    )
    pitch = frame.height + 1.06
    figure, drawn = _draw_maps(scene, frame, (x, y), panels, pitch, 0.2)
    frame.draw_bar(figure, drawn[0], _TOP, None, "Height above mean sea level (m), same scale in (a) and (b)")
    frame.draw_bar(figure, drawn[2], _TOP + pitch, 0, "Height error (m)")
    frame.draw_bar(figure, drawn[3], _TOP + pitch, 1, "Standard error (m)", "max")
    return figure


@style.styled
def slope_maps(scene: Scene, maps: xr.DataTree, truth: xr.DataTree, turn: int = -1) -> Figure:
    """True slope, retrieved slope and their difference, towards east and towards north, all on one scale."""
    names = {"slope_x": "east, ∂z/∂x", "slope_y": "north, ∂z/∂y"}
    x, y, _ = _ground(truth, "slope_x", turn)
    true = [_within_range(scene, x, y, _ground(truth, name, turn)[2]) for name in names]
    retrieved = [_ground(maps, name, turn)[2] for name in names]
    error = [map_ - truth_ for map_, truth_ in zip(retrieved, true, strict=True)]
    frame = _frame(scene, x, y, (*true, *retrieved), panels=2)
    limit = slope_limit(np.stack(true), np.stack(retrieved))
    panels = [
        _Panel(f"({letter}) {what} slope towards {towards}", values, style.SLOPE_COLOURS, -limit, limit)
        for letters, what, pair in (("ab", "True", true), ("cd", "Retrieved", retrieved), ("ef", "Error of", error))
        for letter, towards, values in zip(letters, names.values(), pair, strict=True)
    ]
    pitch = frame.height + 0.62
    figure, drawn = _draw_maps(scene, frame, (x, y), panels, pitch, 0.65)
    label = "Slope (m/m), same scale in all panels; positive: the sea rises towards east or north"
    frame.draw_bar(figure, drawn[-1], _TOP + 2.0 * pitch, None, label)
    return figure


def _draw_maps(
    scene: Scene, frame: _Frame, ground: tuple[Array, Array], panels: Sequence[_Panel], pitch: float, foot: float
) -> tuple[Figure, list[AxesImage]]:
    """Maps of ground cells, two and two, over the key; cells without a value let the grey of what the radar looked at
    show. pitch, foot: inches from row to row, and left for colour bars under the last."""
    key = _key_of(scene)
    high = (len(panels) + 1) // 2 * pitch + foot + _LINE * (key[-1].row + 1)
    figure, (x, y), drawn = style.new_figure(high), ground, []
    pixels = frame.width * style.DPI * (x[-1] - x[0] + scene.retrieval.ground_m) / (frame.east - frame.west)
    how = "nearest" if x.size <= pixels else "antialiased"
    for number, (title, values, colours, low, high) in enumerate(panels):
        row, column = divmod(number, 2)
        left = _LEFT + column * (frame.width + _GAP)
        axes = style.place(figure, left, _TOP + row * pitch, frame.width, frame.height)
        cells = {"side": scene.retrieval.ground_m, "interpolation": how}
        drawn.append(draw_ground(axes, (x, y, values), colours, low, high, **cells))
        _furnish(axes, frame, scene, title, blank=style.BLANK)
        if column:
            axes.set_ylabel("")
            axes.tick_params(labelleft=False)
    _draw_key(figure, key, blank=True)
    return figure, drawn


@style.styled
def echo_power(scene: Scene, echoes: xr.Dataset, azimuth_deg: Array, turn: int) -> Figure:
    """Plan position indicator of one turn's mean echo power, and its profile against range."""
    power, borders = reduce.mean_power(echoes, azimuth_deg, turn, scene.retrieval.cell_azimuth_deg)
    noise = reduce.number(echoes.attrs.get("noise_power_w", 0.0))
    unit = "dB over thermal noise" if noise > 0.0 else "dB over 1 W"
    level = reduce.power_db(power, noise)
    gates = np.asarray(echoes["range"].values, dtype=np.float64)
    ground = ground_range(reduce.edges(gates, scene.radar.range_sampling_m), scene.radar.height_m)
    x, y = (each[:, None] * ground for each in unit_from_azimuth(borders))

    frame, key = _frame(scene, np.array([0.0]), np.array([0.0]), (), panels=1.75), _key_of(scene)
    figure = style.new_figure(_TOP + frame.height + 0.94 + _LINE * (key[-1].row + 1))
    axes = style.place(figure, _LEFT, _TOP, frame.width, frame.height)
    low, high = reduce.quantile(level, 0.02), reduce.quantile(level, 0.97)
    if not np.isfinite(low):
        low, high = 0.0, 1.0
    if noise > 0.0:
        low = min(0.0, low)
    drawn = axes.pcolormesh(
        x, y, style.masked(level), cmap=style.colours(style.POWER_COLOURS),
        vmin=low, vmax=max(high, low + 1.0), shading="flat", rasterized=True,
    )  # fmt: skip
    _furnish(axes, frame, scene, "(a) Mean echo power", lines="#f0f0f0")
    frame.draw_bar(figure, drawn, _TOP, 0, f"Mean power ({unit})")

    left = _LEFT + frame.width + 0.62
    profile = style.place(figure, left, _TOP, style.WIDTH - left - _RIGHT, frame.height)
    style.graph(profile, "Range (m)", f"Power ({unit})", "(b) Mean power against range")
    if np.isfinite(level).any():
        low, high = ([reduce.quantile(column, share) for column in level.T] for share in (0.1, 0.9))
        style.band(profile, gates, low, high, style.SKY, 0.45, label="10–90 % of the looks")
        average = reduce.power_db(reduce.mean(power, axis=0), noise)
        profile.plot(gates, average, color=style.BLUE, label="mean over the looks")
        if noise > 0.0:
            profile.axhline(0.0, color=style.BLACK, linewidth=0.8, linestyle="--", label="thermal noise")
            bottom, top = profile.get_ylim()
            profile.set_ylim(min(bottom, -2.0), top)
        profile.legend(loc="upper right")
    else:
        style.note(profile, "no echoes of this turn")
    _draw_key(figure, key, blank=False)
    return figure


# ------------------------------------------------------------------------------------------------ colour scales


def height_limit(true: Array, retrieved: Array) -> float:
    """Half the span of the shared height scale [m]: what the truth needs, a little more if the retrieval needs it."""
    return _limit(true, retrieved, LEAST_HEIGHT_SCALE_M)


def slope_limit(true: Array, retrieved: Array) -> float:
    """Half the span of the shared slope scale."""
    return _limit(true, retrieved, LEAST_SLOPE_SCALE)


def _limit(true: Array, retrieved: Array, least: float) -> float:
    of_truth = _finite_or(reduce.quantile(np.abs(true), 0.995), 0.0)
    of_map = _finite_or(reduce.quantile(np.abs(retrieved), 0.9), 0.0)
    # A noisy map may widen the scale, but only twofold: outliers must not make the true waves invisible.
    if of_truth >= least:
        of_map = min(of_map, 2.0 * of_truth)
    return _round_up(max(of_truth, of_map, least))


def _finite_or(value: float, default: float) -> float:
    return value if np.isfinite(value) else default


def _round_up(value: float) -> float:
    """The next number of two digits."""
    unit = 10.0 ** (np.floor(np.log10(value)) - 1.0)
    return float(f"{np.ceil(value / unit - 1e-9) * unit:.3g}")


# ----------------------------------------------------------------------------------------------------- the ground


def draw_ground(
    axes: Axes, grid: tuple[Array, Array, Array], cmap: str, vmin: float, vmax: float, side: float = 1.0, **more: Any
) -> AxesImage:
    """A field (y, x) over x and y [m], north up; what is not known is see-through. side: of a cell that stands alone;
    more: of `imshow`."""
    x, y, values = reduce.edges(grid[0], side), reduce.edges(grid[1], side), style.masked(grid[2])
    how = {"interpolation": "nearest", "interpolation_stage": "rgba", "zorder": 2.0, **more}
    extent = x[0], x[-1], y[0], y[-1]
    image = axes.imshow(
        values, origin="lower", extent=extent, cmap=style.colours(cmap), vmin=vmin, vmax=vmax, **how
    )  # fmt: skip
    axes.set_aspect("equal")
    style.few_ticks(axes)
    return image


def _ground(tree: xr.DataTree, name: str, turn: int) -> tuple[Array, Array, Array]:
    """x and y, rising, and the variable (y, x) of one turn."""
    variable = tree["ground"].dataset[name].isel(turn=turn).sortby(["y", "x"])
    x, y, values = (np.asarray(each.values, dtype=np.float64) for each in (variable["x"], variable["y"], variable))
    return x, y, values


def _within_range(scene: Scene, x: Array, y: Array, values: Array) -> Array:
    return np.where(np.hypot(x[None, :], y[:, None]) <= scene.far_ground_range, values, np.nan)


def _frame(scene: Scene, x: Array, y: Array, values: tuple[Array, ...], panels: float) -> _Frame:
    """The sector that the radar looks at and every cell that has a value, with a margin; `panels` beside each other."""
    far, near = scene.far_ground_range, _near_ground_range(scene)
    xs, ys = ([0.0, *far * each, *near * each] for each in unit_from_azimuth(np.linspace(*scene.radar.sector_deg, 181)))
    if values:
        some = np.any([np.isfinite(value) for value in values], axis=0)
        xs.extend(x[some.any(axis=0)])
        ys.extend(y[some.any(axis=1)])
    margin = 0.03 * far
    west, east, south, north = min(xs) - margin, max(xs) + margin, min(ys) - margin, max(ys) + margin
    width = (style.WIDTH - _LEFT - _RIGHT - _GAP) / panels
    height = width * (north - south) / (east - west)
    if height > 1.25 * width:  # a narrow sector to the north or south: widen the ground, keep the panel
        grow = 0.5 * ((north - south) / 1.25 - (east - west))
        west, east, height = west - grow, east + grow, 1.25 * width
    elif height < 0.5 * width:
        grow = 0.5 * ((east - west) * 0.5 - (north - south))
        south, north, height = south - grow, north + grow, 0.5 * width
    return _Frame(*map(float, (west, east, south, north, width, height)))


def _near_ground_range(scene: Scene) -> float:
    return float(ground_range(scene.radar.range_m[0], scene.radar.height_m))


def looked_at(scene: Scene, colour: str) -> Wedge:
    """The sector between the nearest and the farthest range, filled."""
    start, stop = scene.radar.sector_deg  # Wedge counts degrees anticlockwise from east
    far, near = scene.far_ground_range, _near_ground_range(scene)
    return Wedge(
        (0.0, 0.0), far, 90.0 - stop, 90.0 - start, width=far - near, facecolor=colour, edgecolor="none", zorder=1.0
    )


def _furnish(axes: Axes, frame: _Frame, scene: Scene, title: str, blank: str = "none", lines: str = "#404040") -> None:
    """Frame, labels, range circles and the antenna."""
    axes.set_aspect("equal")
    axes.set_xlim(frame.west, frame.east)
    axes.set_ylim(frame.south, frame.north)
    axes.set_xlabel("East of antenna (m)", labelpad=1.0)
    axes.set_ylabel("North of antenna (m)", labelpad=1.0)
    axes.set_title(title)
    style.few_ticks(axes)
    axes.tick_params(labelsize=style.FONT - 0.5)
    axes.add_patch(looked_at(scene, blank))
    (start, stop), far = scene.radar.sector_deg, scene.far_ground_range
    east, north = unit_from_azimuth(np.linspace(start, stop, max(16, int(stop - start))))
    middle = 45.0 if stop - start > 350.0 else 0.5 * (start + stop)
    label_east, label_north = (float(part) for part in unit_from_azimuth(middle))
    decade = 10.0 ** np.floor(np.log10(far))  # of a round distance that fits three to six times into the range
    step = next(each for each in decade * np.array([0.2, 0.25, 0.5, 1.0, 2.0]) if far / each <= 6.0)
    for radius in (*np.arange(step, far, step), far):
        outer = radius == far
        line = ("#404040", 0.6, "-") if outer else (lines, 0.4, (0, (4, 3)))
        axes.plot(radius * east, radius * north, color=line[0], linewidth=line[1], linestyle=line[2], zorder=3.0)
        if not outer and radius < far - 0.3 * step:
            axes.text(
                radius * label_east, radius * label_north, f"{radius:g} m", ha="center", va="center", zorder=4.0,
                fontsize=style.FONT - 2.0, path_effects=[patheffects.withStroke(linewidth=1.6, foreground="white")],
            )  # fmt: skip
    style.mark_antenna(axes)


# ------------------------------------------------------------------------------------------- the key below a map


class _Entry(NamedTuple):
    """Of the key: words, an arrow's azimuth or a symbol's name, inches from the left, and line."""

    text: str
    symbol: float | str
    left: float
    row: int


def _key_of(scene: Scene) -> list[_Entry]:
    items: list[tuple[str, float | str]] = [("north", 0.0)]
    for waves in scene.sea.waves:
        facts = wave_facts(waves, scene.sea.depth_m)
        if facts is not None:
            items.append((reduce.describe_waves(waves, scene.sea.depth_m), facts.from_deg + 180.0))
    wind = scene.scattering
    text = f"wind {wind.wind_speed_m_s:.3g} m/s from {wind.wind_from_deg % 360.0:.4g}°"
    items += [(text, wind.wind_from_deg + 180.0), ("antenna", "antenna"), ("shadow or no echo", "blank")]
    placed, left, row = [], 0.3, 0
    for text, symbol in items:
        width = 0.46 + 0.05 * len(text)
        if left + width > style.WIDTH and left > 0.3:
            left, row = 0.3, row + 1
        placed.append(_Entry(text, symbol, left, row))
        left += width
    return placed


def _draw_key(figure: Figure, key: Sequence[_Entry], blank: bool) -> None:
    """A strip along the foot of the figure: arrows point where waves and wind go."""
    high = _LINE * (key[-1].row + 1)
    axes = style.place(figure, 0.0, float(figure.get_size_inches()[1]) - high - 0.04, style.WIDTH, high)
    axes.set_xlim(0.0, style.WIDTH)
    axes.set_ylim(-high, 0.0)
    axes.set_axis_off()
    for text, symbol, left, row in key:
        x, y = left + 0.12, -0.12 - _LINE * row
        if symbol == "blank":
            if not blank:
                continue
            axes.add_patch(Rectangle((x - 0.1, y - 0.055), 0.2, 0.11, facecolor=style.BLANK, edgecolor="none"))
        elif symbol == "antenna":
            axes.plot(x, y, marker="^", color="black", markersize=3.5, linestyle="none")
        else:
            east, north = (0.1 * float(part) for part in unit_from_azimuth(symbol))
            colour = style.GREEN if text.startswith("wind") else style.BLUE if text.startswith("waves") else style.BLACK
            axes.annotate(
                "", xy=(x + east, y + north), xytext=(x - east, y - north),
                arrowprops={"arrowstyle": "-|>", "color": colour, "linewidth": 1.1, "mutation_scale": 7.0,
                            "shrinkA": 0.0, "shrinkB": 0.0},
            )  # fmt: skip
        axes.text(x + 0.17, y, text, ha="left", va="center", fontsize=style.FONT - 0.5)
