"""Maps: north up, east right, equal aspect, metres from the antenna."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np
import xarray as xr
from matplotlib import patheffects
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.image import AxesImage
from matplotlib.patches import Rectangle, Wedge

from ..conventions import unit_from_azimuth
from ..scene import Scene
from ..sea import wave_facts
from . import reduce, style
from .reduce import Array

LEAST_HEIGHT_SCALE_M = 0.05
LEAST_SLOPE_SCALE = 0.01
_LEFT, _GAP, _RIGHT = 0.58, 0.26, 0.12  # inches


@dataclass(frozen=True)
class _Frame:
    """What part of the ground is drawn, and how large a panel is (inches)."""

    west: float
    east: float
    south: float
    north: float
    width: float
    height: float


@style.styled
def height_maps(scene: Scene, maps: xr.DataTree, truth: xr.DataTree, turn: int = -1) -> Figure:
    """True and retrieved height on one scale, their difference, and the retrieval's own standard error."""
    x, y, true = _ground(truth, "height", turn)
    _, _, retrieved = _ground(maps, "height", turn)
    _, _, spread = _ground(maps, "height_std", turn)
    true = _within_range(scene, x, y, true)
    error = retrieved - true
    frame = _frame(scene, x, y, (true, retrieved), panels=2)
    limit = height_limit(true, retrieved)
    error_limit = _round_up(max(LEAST_HEIGHT_SCALE_M, _or(reduce.quantile(np.abs(error), 0.98), 0.0)))
    spread_limit = _round_up(max(LEAST_HEIGHT_SCALE_M, _or(reduce.quantile(spread, 0.95), 0.0)))

    key_rows = _key_rows(scene)
    row = 0.2 + frame.height + 0.36 + 0.5
    figure = style.new_figure(0.08 + 2.0 * row + 0.12 + 0.24 * key_rows)
    top, second = 0.28, _LEFT + frame.width + _GAP
    both = {"vmin": -limit, "vmax": limit, "cmap": style.HEIGHT_COLOURS}
    drawn = _panel(figure, frame, scene, 0, top, (x, y, true), "(a) True height", **both)
    _panel(figure, frame, scene, 1, top, (x, y, retrieved), "(b) Retrieved height", **both)
    bar = top + frame.height + 0.37
    style.colour_bar(figure, drawn, _LEFT + 0.5 * frame.width, bar, frame.width + _GAP, _HEIGHT_LABEL, "both")

    top += row
    bar += row
    drawn = _panel(
        figure, frame, scene, 0, top, (x, y, error), "(c) Error: retrieved − true height",
        vmin=-error_limit, vmax=error_limit, cmap=style.HEIGHT_COLOURS,
    )  # fmt: skip
    inset = 0.06 * frame.width
    style.colour_bar(figure, drawn, _LEFT + inset, bar, frame.width - 2 * inset, "Height error (m)", "both")
    drawn = _panel(
        figure, frame, scene, 1, top, (x, y, spread), "(d) Standard error that the retrieval states",
        vmin=0.0, vmax=spread_limit, cmap=style.SPREAD_COLOURS,
    )  # fmt: skip
    style.colour_bar(figure, drawn, second + inset, bar, frame.width - 2 * inset, "Standard error (m)", "max")
    _key(figure, scene, key_rows, blank=True)
    return figure


_HEIGHT_LABEL = "Height above mean sea level (m), same scale in (a) and (b)"


@style.styled
def slope_maps(scene: Scene, maps: xr.DataTree, truth: xr.DataTree, turn: int = -1) -> Figure:
    """True and retrieved slope towards east and towards north, all four on one scale."""
    names = ("slope_x", "slope_y")
    x, y, _ = _ground(truth, "slope_x", turn)
    true = [_within_range(scene, x, y, _ground(truth, name, turn)[2]) for name in names]
    retrieved = [_ground(maps, name, turn)[2] for name in names]
    frame = _frame(scene, x, y, (*true, *retrieved), panels=2)
    limit = slope_limit(np.stack(true), np.stack(retrieved))

    key_rows = _key_rows(scene)
    row = 0.2 + frame.height + 0.42
    figure = style.new_figure(0.08 + 2.0 * row + 0.45 + 0.12 + 0.24 * key_rows)
    scale = {"vmin": -limit, "vmax": limit, "cmap": style.SLOPE_COLOURS}
    drawn = None
    for index, towards in enumerate(("east, ∂z/∂x", "north, ∂z/∂y")):
        top, letters = 0.28 + index * row, "abcd"[2 * index :]
        title = f"({letters[0]}) True slope towards {towards}"
        drawn = _panel(figure, frame, scene, 0, top, (x, y, true[index]), title, **scale)
        title = f"({letters[1]}) Retrieved slope towards {towards}"
        _panel(figure, frame, scene, 1, top, (x, y, retrieved[index]), title, **scale)
    style.colour_bar(
        figure, drawn, _LEFT + 0.5 * frame.width, 0.28 + row + frame.height + 0.37, frame.width + _GAP,
        "Slope (m/m), same scale in all panels; positive: the sea rises towards east or north", "both",
    )  # fmt: skip
    _key(figure, scene, key_rows, blank=True)
    return figure


@style.styled
def echo_power(scene: Scene, echoes: xr.Dataset, azimuth_deg: Array, turn: int) -> Figure:
    """Plan position indicator of one turn's mean echo power, and its profile against range."""
    power, borders = reduce.mean_power(echoes, azimuth_deg, turn, scene.retrieval.cell_azimuth_deg)
    noise = reduce.number(echoes.attrs.get("noise_power_w", 0.0))
    unit = "dB over thermal noise" if noise > 0.0 else "dB over 1 W"
    level = reduce.power_db(power, noise)
    gates = np.asarray(echoes["range"].values, dtype=np.float64)
    height = scene.radar.height_m
    ground = reduce.ground_range(reduce.edges(gates, scene.radar.range_sampling_m), height)
    east, north = unit_from_azimuth(borders)
    x, y = east[:, None] * ground, north[:, None] * ground

    frame = _frame(scene, np.array([0.0]), np.array([0.0]), (), panels=1.75)
    key_rows = _key_rows(scene)
    figure = style.new_figure(0.28 + frame.height + 0.37 + 0.45 + 0.12 + 0.24 * key_rows)
    axes = style.place(figure, _LEFT, 0.28, frame.width, frame.height)
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
    axes.set_ylabel("North of antenna (m)", labelpad=1.0)
    inset = 0.06 * frame.width
    bar_top = 0.28 + frame.height + 0.37
    style.colour_bar(figure, drawn, _LEFT + inset, bar_top, frame.width - 2 * inset, f"Mean power ({unit})", "both")

    left = _LEFT + frame.width + 0.62
    profile = style.place(figure, left, 0.28, style.WIDTH - left - 0.12, frame.height)
    style.graph(profile, "Range (m)", f"Power ({unit})", "(b) Mean power against range")
    if np.isfinite(level).any():
        average = reduce.power_db(reduce.mean(power, axis=0), noise)
        tenth = np.array([reduce.quantile(column, 0.1) for column in level.T])
        nine_tenths = np.array([reduce.quantile(column, 0.9) for column in level.T])
        profile.fill_between(
            gates, tenth, nine_tenths, color=style.SKY, alpha=0.45, linewidth=0.0, label="10–90 % of the looks"
        )
        profile.plot(gates, average, color=style.BLUE, label="mean over the looks")
        if noise > 0.0:
            profile.axhline(0.0, color=style.BLACK, linewidth=0.8, linestyle="--", label="thermal noise")
            bottom, top = profile.get_ylim()
            profile.set_ylim(min(bottom, -2.0), top)
        profile.legend(loc="upper right")
    else:
        style.note(profile, "no echoes of this turn")
    _key(figure, scene, key_rows, blank=False)
    return figure


# ------------------------------------------------------------------------------------------------ colour scales


def height_limit(true: Array, retrieved: Array) -> float:
    """Half the span of the shared height scale [m]: what the truth needs, a little more if the retrieval needs it."""
    return _limit(true, retrieved, LEAST_HEIGHT_SCALE_M)


def slope_limit(true: Array, retrieved: Array) -> float:
    """Half the span of the shared slope scale."""
    return _limit(true, retrieved, LEAST_SLOPE_SCALE)


def _limit(true: Array, retrieved: Array, least: float) -> float:
    of_truth = _or(reduce.quantile(np.abs(true), 0.995), 0.0)
    of_map = _or(reduce.quantile(np.abs(retrieved), 0.9), 0.0)
    # A noisy map may widen the scale, but only twofold: outliers must not make the true waves invisible.
    if of_truth >= least:
        of_map = min(of_map, 2.0 * of_truth)
    return _round_up(max(of_truth, of_map, least))


def _or(value: float, default: float) -> float:
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
    return (
        np.asarray(variable["x"].values, dtype=np.float64),
        np.asarray(variable["y"].values, dtype=np.float64),
        np.asarray(variable.values, dtype=np.float64),
    )


def _within_range(scene: Scene, x: Array, y: Array, values: Array) -> Array:
    return np.where(np.hypot(x[None, :], y[:, None]) <= scene.far_ground_range, values, np.nan)


def _frame(scene: Scene, x: Array, y: Array, values: tuple[Array, ...], panels: float) -> _Frame:
    """The sector that the radar looks at and every cell that has a value, with a margin; `panels` beside each other."""
    far, near = scene.far_ground_range, _near_ground_range(scene)
    azimuth = np.linspace(*scene.radar.sector_deg, 181)
    east, north = unit_from_azimuth(azimuth)
    xs = [np.array([0.0]), far * east, near * east]
    ys = [np.array([0.0]), far * north, near * north]
    if values:
        some = np.any([np.isfinite(value) for value in values], axis=0)
        xs.append(x[some.any(axis=0)])
        ys.append(y[some.any(axis=1)])
    x_all, y_all = np.concatenate(xs), np.concatenate(ys)
    margin = 0.03 * far
    west, east_, south, north_ = x_all.min() - margin, x_all.max() + margin, y_all.min() - margin, y_all.max() + margin
    ratio = (north_ - south) / (east_ - west)
    width = (style.WIDTH - _LEFT - _RIGHT - _GAP) / panels
    height = width * ratio
    if height > 1.25 * width:  # a narrow sector to the north or south: widen the ground, keep the panel
        grow = 0.5 * ((north_ - south) / 1.25 - (east_ - west))
        west, east_, height = west - grow, east_ + grow, 1.25 * width
    elif height < 0.5 * width:
        grow = 0.5 * ((east_ - west) * 0.5 - (north_ - south))
        south, north_, height = south - grow, north_ + grow, 0.5 * width
    return _Frame(float(west), float(east_), float(south), float(north_), float(width), float(height))


def _near_ground_range(scene: Scene) -> float:
    return float(reduce.ground_range(scene.radar.range_m[0], scene.radar.height_m))


def _panel(
    figure: Figure,
    frame: _Frame,
    scene: Scene,
    column: int,
    top: float,
    grid: tuple[Array, Array, Array],
    title: str,
    **scale: Any,
) -> AxesImage:
    """One map of ground cells. Cells without a value let the grey of the looked-at area show."""
    x = grid[0]
    axes = style.place(figure, _LEFT + column * (frame.width + _GAP), top, frame.width, frame.height)
    pixels = frame.width * style.DPI * (x[-1] - x[0] + scene.retrieval.ground_m) / (frame.east - frame.west)
    how = "nearest" if x.size <= pixels else "antialiased"
    image = draw_ground(axes, grid, side=scene.retrieval.ground_m, interpolation=how, **scale)
    _furnish(axes, frame, scene, title, blank=style.BLANK)
    if column == 0:
        axes.set_ylabel("North of antenna (m)", labelpad=1.0)
    else:
        axes.tick_params(labelleft=False)
    return image


def _furnish(axes: Axes, frame: _Frame, scene: Scene, title: str, blank: str = "none", lines: str = "#404040") -> None:
    """Frame, labels, range circles and the antenna."""
    axes.set_aspect("equal")
    axes.set_xlim(frame.west, frame.east)
    axes.set_ylim(frame.south, frame.north)
    axes.set_xlabel("East of antenna (m)", labelpad=1.0)
    axes.set_title(title)
    style.few_ticks(axes)
    axes.tick_params(labelsize=style.FONT - 0.5)
    start, stop = scene.radar.sector_deg
    far, near = scene.far_ground_range, _near_ground_range(scene)
    # Wedge counts degrees anticlockwise from east.
    wedge = Wedge(
        (0.0, 0.0), far, 90.0 - stop, 90.0 - start, width=far - near, facecolor=blank, edgecolor="none", zorder=1.0
    )
    axes.add_patch(wedge)
    east, north = unit_from_azimuth(np.linspace(start, stop, max(16, int(stop - start))))
    middle = 45.0 if stop - start > 350.0 else 0.5 * (start + stop)
    label_east, label_north = (float(part) for part in unit_from_azimuth(middle))
    step = _circle_step(far)
    for radius in (*np.arange(step, far, step), far):
        outer = radius == far
        line = ("#404040", 0.6, "-") if outer else (lines, 0.4, (0, (4, 3)))
        axes.plot(radius * east, radius * north, color=line[0], linewidth=line[1], linestyle=line[2], zorder=3.0)
        if not outer and radius < far - 0.3 * step:
            axes.text(
                radius * label_east, radius * label_north, f"{radius:g} m", ha="center", va="center", zorder=4.0,
                fontsize=style.FONT - 2.0, path_effects=[patheffects.withStroke(linewidth=1.6, foreground="white")],
            )  # fmt: skip
    axes.plot(0.0, 0.0, marker="^", color="black", markersize=3.5, zorder=4.0, linestyle="none")


def _circle_step(far: float) -> float:
    """A round distance that fits three to six times into the range."""
    decade = 10.0 ** np.floor(np.log10(far))
    return float(
        next(step for step in (decade / 5.0, decade / 4.0, decade / 2.0, decade, 2.0 * decade) if far / step <= 6.0)
    )


# ------------------------------------------------------------------------------------------- the key below a map


def _key_items(scene: Scene) -> list[tuple[str, float | str]]:
    """Texts of the key, each with its arrow's azimuth or its symbol's name."""
    items: list[tuple[str, float | str]] = [("north", 0.0)]
    for waves in scene.sea.waves:
        facts = wave_facts(waves, scene.sea.depth_m)
        if facts is not None:
            items.append((reduce.describe_waves(waves, scene.sea.depth_m), facts.from_deg + 180.0))
    wind = scene.scattering
    text = f"wind {wind.wind_speed_m_s:.3g} m/s from {wind.wind_from_deg % 360.0:.4g}°"
    items.append((text, wind.wind_from_deg + 180.0))
    items.append(("antenna", "antenna"))
    items.append(("shadow or no echo", "blank"))
    return items


def _key_layout(scene: Scene) -> list[tuple[str, float | str, float, int]]:
    """Items of the key with their distance from the left [inches] and their row."""
    placed, left, row = [], 0.3, 0
    for text, symbol in _key_items(scene):
        width = 0.46 + 0.05 * len(text)
        if left + width > style.WIDTH and left > 0.3:
            left, row = 0.3, row + 1
        placed.append((text, symbol, left, row))
        left += width
    return placed


def _key_rows(scene: Scene) -> int:
    return _key_layout(scene)[-1][3] + 1


def _key(figure: Figure, scene: Scene, rows: int, blank: bool) -> None:
    """A strip along the foot of the figure: arrows point where waves and wind go."""
    high = 0.24 * rows
    axes = style.place(figure, 0.0, float(figure.get_size_inches()[1]) - high - 0.04, style.WIDTH, high)
    axes.set_xlim(0.0, style.WIDTH)
    axes.set_ylim(-high, 0.0)
    axes.set_axis_off()
    for text, symbol, left, row in _key_layout(scene):
        x, y = left + 0.12, -0.12 - 0.24 * row
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
