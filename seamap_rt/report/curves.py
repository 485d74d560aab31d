"""Graphs: error and visibility against range, true against retrieved height, and where the time went."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Any, Literal, NamedTuple

import numpy as np
import xarray as xr
from matplotlib.axes import Axes
from matplotlib.colors import LogNorm
from matplotlib.figure import Figure
from matplotlib.image import AxesImage
from matplotlib.ticker import MaxNLocator, StrMethodFormatter

from ..conventions import ground_range
from ..metrics import counted_cells
from ..physics.shadowing import shadowing_smith67, shadowing_wagner67
from ..scene import Scene
from . import reduce, style
from .reduce import Array

STAGES = ("calibrate", "sea", "mesh", "trace", "echoes", "truth", "retrieve", "write")
SECTOR_BINS = 60
_FEWEST_CELLS = 30  # of a bin whose errors are drawn
_OF_RUNS = (style.BLUE, style.VERMILION, style.GREEN)
_STATED = "standard error stated by the retrieval, median"
_BOXED: dict[str, Any] = {"bbox": {"facecolor": "white", "edgecolor": "none", "alpha": 0.8, "pad": 1.5}, "zorder": 5.0}


@dataclass(frozen=True)
class ByRange:
    """Cells by range: arrays (bin,), NaN where not known. centre_m: middle of a bin. Of cells more than half visible:
    rms, robust (1.4826 MAD) and mean error of height, median of the stated one [m], rms error of the slope along the
    look and median of the stated one. Shares of all cells: in sight, and with a height."""

    centre_m: Array
    rms: Array
    robust: Array
    bias: Array
    stated: Array
    slope: Array
    slope_stated: Array
    visible: Array
    answered: Array


class Curve(NamedTuple):
    """A curve of a graph: label, x and y, and how it is drawn."""

    label: str
    x: Array
    y: Array
    colour: str = style.BLACK
    dash: str = "-"
    width: float = 1.3


@dataclass(frozen=True)
class Graph:
    """Curves over one pair of axes. x_span, y_span: their limits, None where the curves set them. log: the ordinate.
    marks: abscissae that are marked upright, with words. place: of the legend."""

    x_label: str
    y_label: str
    curves: Sequence[Curve]
    title: str = ""
    x_span: tuple[float, float] | None = None
    y_span: tuple[float, float] | None = None
    log: bool = False
    marks: Sequence[tuple[float, str]] = ()
    place: Literal["best", "upper right", "lower left"] = "best"


@style.styled
def draw_graph(graph: Graph, wide: float = style.WIDTH, high: float = 2.6) -> Figure:
    """wide: of the figure, high: of its axes; inches."""
    top = 0.28 if graph.title else 0.1
    figure = style.new_figure(top + high + 0.47, wide)
    axes = style.place(figure, 0.62, top, wide - 0.62 - 0.12, high)
    style.graph(axes, graph.x_label, graph.y_label, graph.title)
    if graph.log:
        axes.set_yscale("log")
    for each in graph.curves:
        axes.plot(each.x, each.y, color=each.colour, linestyle=each.dash, linewidth=each.width, label=each.label)
    axes.set_xlim(graph.x_span)
    axes.set_ylim(graph.y_span)
    for at, words in graph.marks:
        style.upright(axes, at, f" {words}", rotation=90.0)
    if axes.get_legend_handles_labels()[1]:
        axes.legend(loc=graph.place)
    if not any(np.isfinite(each.y).any() for each in graph.curves):
        style.note(axes, "not known")
    return figure


def error_against_range(maps: xr.DataTree, truth: xr.DataTree, metrics: Mapping[str, Any]) -> Figure:
    """Height error, bias and slope error per range bin, beside the standard error that the retrieval states."""
    centres = reduce.series(metrics.get("range_m"))
    names = ("height_rmse_m", "height_robust_m", "height_bias_m", "slope_rmse", "visible_fraction", "answered", "cells")
    rms, robust, bias, slope, visible, answered, cells = (
        reduce.series(metrics.get(name), centres.size) for name in names
    )
    few = cells < _FEWEST_CELLS
    stated, slope_stated = (stated_error(maps, truth, centres, name) for name in ("height_std", "slope_range_std"))
    rms, robust, bias, stated, slope, slope_stated = (
        np.where(few, np.nan, each) for each in (rms, robust, bias, stated, slope, slope_stated)
    )
    return draw_errors({"": ByRange(centres, rms, robust, bias, stated, slope, slope_stated, visible, answered)})


@style.styled
def draw_errors(by_run: Mapping[str, ByRange], floors: Sequence[Curve] = (), range_name: str = "Range (m)") -> Figure:
    """Height error with what is stated of it, bias and slope error against range, of one run or of several by name.

    floors: what the error was to be expected to be.
    """
    several, runs = len(by_run) > 1, [each for each in by_run.values() if each.centre_m.size]
    slopes = any(np.isfinite(each.slope).any() for each in runs)
    spots = [(0.28, 1.75, "Height error (m)", "(a) Height error")]
    spots.append((2.4, 0.72, "Bias (m)", "(b) Mean height error, retrieved − true"))
    if slopes:
        spots.append((3.49, 0.82, "Slope error (m/m)", "(c) Slope error along the look: rms –, stated - -"))
    figure, panels = style.new_figure(4.75 if slopes else 3.66), list[Axes]()
    for number, (top, high, label, title) in enumerate(spots):
        above = panels[0] if panels else None
        panels.append(style.place(figure, 0.62, top, style.WIDTH - 0.62 - 0.12, high, sharex=above))
        last = number == len(spots) - 1
        style.graph(panels[-1], range_name if last else "", label, title)
        panels[-1].tick_params(labelbottom=last)
        panels[-1].yaxis.set_label_coords(-0.065, 0.5)
        panels[-1].yaxis.set_major_locator(MaxNLocator(4 if number else 7, steps=[1, 2, 2.5, 5, 10]))
    first, second = panels[:2]
    if not any(np.isfinite(value).any() for each in runs for value in (each.rms, each.stated)):
        for axes in panels[: None if not runs else 1]:
            style.note(axes, "no cells more than half visible")
        if not runs:
            return figure
    second.axhline(0.0, color=style.BLACK, linewidth=0.6)
    for (name, each), colour in zip(by_run.items(), _OF_RUNS if several else (style.BLACK,), strict=False):
        tail = f", {style.plain(name)}" if several else ""
        of_stated, stated = (colour, "stated") if several else (style.VERMILION, _STATED)
        drawn = [(each.rms, colour, "-", "o", "rms"), (each.stated, of_stated, "--", "", stated)]
        if not several:
            drawn.insert(1, (each.robust, style.BLUE, "-", "s", "robust, 1.4826 × median absolute deviation"))
        for values, hue, dash, marker, label in drawn:
            if np.isfinite(values).any():
                first.plot(
                    each.centre_m, values, color=hue, linestyle=dash, marker=marker, markersize=2.5, label=label + tail
                )
        for axes, values in zip(panels[1:], (each.bias, each.slope), strict=False):
            axes.plot(each.centre_m, values, color=colour, marker="o", markersize=2.5)
        for axes in panels[2:]:
            axes.plot(each.centre_m, each.slope_stated, color=of_stated, linestyle="--")
    for floor, colour, dash in zip(floors, (style.ORANGE, style.GREY), ("-.", ":"), strict=False):
        first.plot(floor.x, floor.y, color=colour, linestyle=dash, label=floor.label)
    first.set_ylim(0.0, _top(0.01, *(value for each in runs for value in (each.rms, each.robust, each.stated))))
    if first.lines:
        first.legend(loc="best")
    reach = _top(0.01, *(np.abs(each.bias) for each in runs))
    second.set_ylim(-reach, reach)
    for axes in panels[2:]:
        axes.set_ylim(0.0, _top(0.001, *(value for each in runs for value in (each.slope, each.slope_stated))))
    borders = [reduce.edges(each.centre_m) for each in runs]
    first.set_xlim(max(0.0, min(float(each[0]) for each in borders)), max(float(each[-1]) for each in borders))
    return figure


def stated_error(maps: xr.DataTree, truth: xr.DataTree, centres: Array, name: str = "height_std") -> Array:
    """Median of one of the retrieval's standard errors per range bin, over `counted_cells`; NaN of maps without it."""
    if name not in maps["polar"].dataset:
        return np.full(centres.size, np.nan)
    if centres.size == 0:
        return centres
    gates = reduce.coordinate(maps, "polar", "range")
    spread = np.where(counted_cells(maps["polar"].dataset, truth["polar"].dataset), reduce.polar(maps, name), np.nan)
    borders = reduce.edges(centres, only=float(np.ptp(gates)) + 1.0)
    index = np.searchsorted(borders, gates, side="right") - 1
    return np.array([reduce.quantile(spread[:, :, index == bin_], 0.5) for bin_ in range(centres.size)])


def visible_share(scene: Scene, truth: xr.DataTree, metrics: Mapping[str, Any]) -> Figure:
    """Visible share of the sea against ground range, over all looks and by direction, with Smith and Wagner."""
    azimuth = reduce.coordinate(truth, "polar", "azimuth")
    height = scene.radar.height_m
    ground = ground_range(reduce.coordinate(truth, "polar", "range"), height)
    visible = reduce.polar(truth, "visible_fraction")
    drawn = [
        Curve(f"{name} ±22.5°", *_binned(ground, reduce.mean(visible[:, looks, :], axis=(0, 1))), colour, "-", 1.0)
        for name, colour, looks in _sectors(scene, azimuth)
    ]
    drawn.append(Curve("all looks", ground, reduce.mean(visible, axis=(0, 1)), style.BLACK, "-", 1.5))
    range_m, known = reduce.visible(metrics)
    seen = metrics["visible"]["seen_db"] if known else None
    shown = [each for each in known if each["level_db"] == seen]
    drawn += [
        Curve(f"to a radar, {each['sees']} {seen:g} dB", range_m, reduce.series(each["by_range"]), hue, ":", 1.2)
        for each, hue in zip(shown, (style.BLACK, style.GREY), strict=False)
    ]
    if "illumination" in truth["polar"]:
        lit = reduce.mean(reduce.polar(truth, "illumination"), axis=(0, 1))
        drawn.append(Curve("power, with diffraction", ground, lit, style.SKY, ":", 1.5))
    slope = reduce.number(metrics.get("slope_rms_look"))
    beyond = ground[ground > 0.0]
    if np.isfinite(slope) and beyond.size:
        drawn += analytic_shares(beyond, *analytic_share(beyond, height, slope), f" (rms slope {slope:.3f})")
    return draw_shares(drawn, low=np.nan_to_num(visible[..., -1]).mean() <= 0.6)


def analytic_shares(ground_m: Array, smith: Array, wagner: Array, slope: str = "") -> list[Curve]:
    """The closed forms, as all figures draw them."""
    return [
        Curve(f"Wagner 1967{slope}", ground_m, wagner, style.PURPLE, "-.", 1.0),
        Curve(f"Smith 1967{slope}", ground_m, smith, style.ORANGE, "--", 1.0),
    ]


def run_shares(by_run: Mapping[str, ByRange]) -> list[Curve]:
    """What is in sight and which cells have a height, of one run or of several by name."""
    made = []
    for (name, each), colour in zip(by_run.items(), _OF_RUNS if len(by_run) > 1 else (style.BLACK,), strict=False):
        tail = f", {style.plain(name)}" if len(by_run) > 1 else ""
        made.append(Curve(f"in sight of both antennas{tail}", each.centre_m, each.visible, colour, "-", 1.5))
        heights = colour if len(by_run) > 1 else style.BLUE
        made.append(Curve(f"cells with a height{tail}", each.centre_m, each.answered, heights, ":", 1.5))
    return [each for each in made if np.nansum(each.y) > 0.0]


def draw_shares(shares: Sequence[Curve], low: bool = True) -> Figure:
    """Shares of the sea or of the cells against ground range. low: whether they end low: the legend stands above."""
    far = max((float(each.x.max()) for each in shares if each.x.size), default=0.0)
    return draw_graph(
        Graph(
            "Ground range (m)", "Share (%)", [each._replace(y=100.0 * each.y) for each in shares],
            "Share of the sea's horizontal area that both antennas see", (0.0, 1.01 * far if far > 0.0 else 1.0),
            (0.0, 104.0), place="upper right" if low else "lower left",
        )
    )  # fmt: skip


def analytic_share(ground_m: Array, height_m: float, slope_rms: float) -> tuple[Array, Array]:
    """Smith's and Wagner's visible share at ground ranges, for grazing angles atan(height/ground range)."""
    if slope_rms <= 0.0:
        return np.ones_like(ground_m), np.ones_like(ground_m)
    v = height_m / ground_m / (np.sqrt(2.0) * slope_rms)
    return shadowing_smith67(v), shadowing_wagner67(v)


def _sectors(scene: Scene, azimuth: Array) -> list[tuple[str, str, Any]]:
    """Name, colour and looks of the directions that the scene covers, relative to the highest waves."""
    waves = reduce.main_waves(scene)
    if waves is None:
        return []
    cross = reduce.near_azimuth(azimuth, waves.from_deg + 90.0)
    cross |= reduce.near_azimuth(azimuth, waves.from_deg - 90.0)
    sectors = (
        ("looking up-wave", style.BLUE, reduce.near_azimuth(azimuth, waves.from_deg)),
        ("looking down-wave", style.VERMILION, reduce.near_azimuth(azimuth, waves.from_deg + 180.0)),
        ("looking across", style.GREEN, cross),
    )
    return [sector for sector in sectors if sector[2].any()]


def _binned(x: Array, y: Array) -> tuple[Array, Array]:
    """Means of x and y over neighbouring samples, about SECTOR_BINS of them."""
    starts = np.arange(0, x.size, max(1, x.size // SECTOR_BINS))[1:]
    x, y = (np.array([reduce.mean(part) for part in np.split(each, starts)]) for each in (x, y))
    return x, y


@style.styled
def height_scatter(maps: xr.DataTree, truth: xr.DataTree) -> Figure:
    """Retrieved against true height, and the error over its stated standard error beside the normal distribution.

    Cells at 50–200 m that are more than half visible, and not flagged as ambiguous.
    """
    cells = counted_cells(maps["polar"].dataset, truth["polar"].dataset) & reduce.judged_gates(maps)
    true, retrieved, spread = (
        reduce.polar(tree, name)[cells] for tree, name in ((truth, "height"), (maps, "height"), (maps, "height_std"))
    )
    figure = style.new_figure(3.4)
    left = style.place(figure, 0.62, 0.28, 2.65, 2.65)
    right = style.place(figure, 4.75, 0.28, style.WIDTH - 4.75 - 0.12, 2.65)
    left.set_aspect("equal")
    style.graph(left, "True height (m)", "Retrieved height (m)", "(a) Retrieved against true height")
    style.graph(right, "Error / stated standard error", "Density", "(b) Is the stated error right?")
    if true.size == 0:
        for axes in (left, right):
            style.note(axes, "no cells more than half visible\nbetween 50 and 200 m")
        return figure
    bar_axes = style.place(figure, 3.4, 0.28, 0.1, 2.65)
    bar = figure.colorbar(_draw_one_to_one(left, true, retrieved), cax=bar_axes, format=StrMethodFormatter("{x:g}"))
    bar.set_label("Cells per square")
    bar_axes.tick_params(labelsize=style.FONT - 0.5)
    known = np.isfinite(true) & (spread > 0.0)
    _stated_error_panel(right, (retrieved[known] - true[known]) / spread[known])
    return figure


def _draw_one_to_one(axes: Axes, true: Array, retrieved: Array) -> AxesImage:
    """Cells counted in squares of true and retrieved height [m], and what they say in a corner."""
    correlation = _correlation(true, retrieved)
    of_truth = max(0.05, reduce.quantile(np.abs(true), 0.999))
    limit = 1.15 * max(of_truth, min(reduce.quantile(np.abs(retrieved), 0.98), 2.0 * of_truth))
    count, _, _ = np.histogram2d(retrieved, true, bins=np.linspace(-limit, limit, 71))
    image = axes.imshow(
        np.ma.masked_less(count, 0.5), origin="lower", extent=(-limit, limit, -limit, limit), zorder=1.5,
        cmap=style.colours(style.COUNT_COLOURS), norm=LogNorm(1.0, max(10.0, float(count.max()))),
        interpolation="nearest",
    )  # fmt: skip
    axes.plot(
        (-limit, limit), (-limit, limit), color=style.VERMILION, linewidth=0.9, linestyle="--", label="one to one"
    )
    axes.legend(loc="lower right")
    style.few_ticks(axes)
    lines = [f"{true.size} cells"]
    if np.isfinite(correlation):
        lines.append(f"correlation {correlation:.3f}")
    if true.size > count.sum():
        lines.append(f"{true.size - count.sum():.0f} outside the frame")
    style.corner(axes, lines, **_BOXED)
    return image


def _correlation(true: Array, retrieved: Array) -> float:
    """Correlation of the heights that both have; NaN where one of them does not vary."""
    both = np.isfinite(true) & np.isfinite(retrieved)
    t, r = true[both], retrieved[both]
    return float(np.corrcoef(t, r)[0, 1]) if t.size > 1 and t.std() > 0.0 and r.std() > 0.0 else float("nan")


def _stated_error_panel(axes: Axes, ratio: Array) -> None:
    """Errors over their stated standard errors, beside the normal distribution."""
    if ratio.size == 0:
        style.note(axes, "no standard error was stated")
        return
    borders = np.linspace(-5.0, 5.0, 51)
    inside, _ = np.histogram(ratio, bins=borders)
    axes.stairs(inside / (ratio.size * np.diff(borders)), borders, fill=True, color=style.SKY, label="cells")
    axes.plot(
        borders, np.exp(-0.5 * borders**2) / np.sqrt(2.0 * np.pi), color=style.BLACK, linewidth=1.0, label="normal"
    )
    axes.set_xlim(-5.0, 5.0)
    axes.set_ylim(0.0, 1.3 * axes.get_ylim()[1])
    axes.legend(loc="upper right")
    one, two, five = (100.0 * np.mean(np.abs(ratio) <= most) for most in (1.0, 2.0, 5.0))
    lines = [f"within ±1: {one:.0f} %", f"within ±2: {two:.0f} %", f"beyond ±5: {100.0 - five:.1f} %"]
    style.corner(axes, lines, **_BOXED)


@style.styled
def timing(scene: Scene, metrics: Mapping[str, Any]) -> Figure:
    """Wall time of each stage, first turn and warm turns apart."""
    runs = timing_runs(metrics)
    stages = [stage for stage in STAGES if any(np.isfinite(reduce.number(run.get(stage))) for _, run in runs)]
    figure = style.new_figure(0.28 + max(1.0, 0.3 * len(stages)) + 0.5)
    axes = style.place(figure, 0.95, 0.28, style.WIDTH - 0.95 - 0.12, max(1.0, 0.3 * len(stages)))
    factor = reduce.number(metrics.get("real_time_factor"))
    title = "Wall time of a turn"
    if np.isfinite(factor):
        title += f"; real-time factor {factor:.3g} (a turn lasts {scene.turn_duration_s:.3g} s)"
    style.graph(axes, "Wall time (s)", "", title)
    if not stages:
        axes.set_yticks([])
        style.note(axes, "no times were recorded")
        return figure
    thick = 0.76 / len(runs)
    seconds = np.array([[reduce.number(run.get(stage)) for stage in stages] for _, run in runs])
    for index, (name, run) in enumerate(runs):
        y = np.arange(len(stages)) - 0.38 + (index + 0.5) * thick
        total = reduce.number(run.get("total"))
        label = name + (f", {total:.3g} s in all" if np.isfinite(total) else "")
        bars = np.nan_to_num(seconds[index])
        axes.barh(y, bars, height=0.92 * thick, color=(style.SKY, style.BLUE)[index % 2], label=label)
        for level, value in zip(y, seconds[index], strict=True):
            if np.isfinite(value):
                axes.text(value, level, f" {value:.3g}", va="center", ha="left", fontsize=style.FONT - 1.0)
    axes.set_yticks(range(len(stages)), stages)
    axes.set_ylim(len(stages) - 0.5, -0.5)
    axes.set_xlim(0.0, 1.1 * float(np.nanmax(seconds)) or 1.0)
    axes.grid(False, axis="y")
    axes.legend(loc="best")
    return figure


def timing_runs(metrics: Mapping[str, Any]) -> list[tuple[str, Mapping[str, Any]]]:
    """The recorded times by kind of turn: first and warm, or one kind if they are not distinguished."""
    times = metrics.get("timing_s")
    if not isinstance(times, Mapping):
        return [("turn", {})]
    nested = [(f"{name} turn", run) for name, run in times.items() if isinstance(run, Mapping)]
    return nested or [("turn", times)]


def _top(least: float, *values: Array) -> float:
    """The upper end of an axis from 0 that holds all values."""
    highest = max((float(np.nanmax(v)) for v in values if np.isfinite(v).any()), default=0.0)
    return 1.12 * max(highest, least)
