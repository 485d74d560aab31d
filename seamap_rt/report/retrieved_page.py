"""The page of a retrieval and its figures: what maps show without a truth, and what is doubtful about their echoes."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Any

import numpy as np
import xarray as xr
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.image import AxesImage
from numpy.typing import NDArray

from ..inspection import Finding, Level
from . import reduce, style
from .maps import draw_ground
from .page_elements import Cell, Fold, Image, Table, html_page

RETRIEVED = "retrieval.html"
_VERDICTS = {"wrong": "1 surely wrong", "doubtful": "2 doubtful", "good": "3 good", "unknown": "4 cannot be told"}
_MAPS = "The last turn. Grey: no echo, shadow, or not looked at."
_RANGES = (
    "The sea's mean level is 0 at every range: a staircase of metres is a wrong sign of the phase, a shift a wrong "
    "mast height, a straight trend a phase offset between the receivers."
)


def retrieved_page(
    maps: xr.DataTree, findings: Sequence[Finding], summary: Sequence[str], radar: Mapping[Any, Any], source: str
) -> str:
    """One HTML file that needs no other. summary: sentences on top; radar: the echoes' attributes; source: file."""
    grave = [finding.line for finding in findings if finding.verdict in ("wrong", "doubtful")]
    table = Table(
        "What the echoes say of themselves",
        ("Verdict", "What", "Found", "What to do"),
        [[Cell(_VERDICTS[verdict]), *map(Cell, (what, says, remedy))] for what, verdict, says, remedy in findings],
        "Nothing here knows the sea.",
        files=["maps.nc"],
    )
    described = "\n".join(f"{name} = {value}" for name, value in sorted(radar.items()))
    return html_page(
        f"Heights retrieved from {source}",
        [f"{_sentence(line)}." for line in summary],
        [
            Image.of("Map", style.png(map_of_turn(maps)), _MAPS),
            Image.of("By range", style.png(draw_by_range(maps)), _RANGES),
        ],
        [Fold("The radar as it is described", text=described)],
        notes=[f"{_sentence(line)}." for line in grave] or ["Nothing about the echoes was found to be doubtful."],
        table=table,
    )


def _sentence(line: str) -> str:
    return line[0].upper() + line[1:]


Array = NDArray[np.float64]

_PANEL, _LEFT, _GAP = 3.1, 0.55, 0.35  # inches
_BINS = 40


def map_of_turn(maps: xr.DataTree, turn: int = -1) -> Figure:
    """Height and standard error of one turn's ground map; grey where there is no height."""
    return draw_heights(maps["ground"].to_dataset().isel(turn=turn).sortby(["y", "x"]))


@style.styled
def draw_heights(ground: xr.Dataset) -> Figure:
    """height and height_std [m] over y and x [m], both ascending; grey where there is no height."""
    height, error = (np.asarray(ground[name].values, dtype=np.float64) for name in ("height", "height_std"))
    figure = style.new_figure(_PANEL + 1.15)
    limit = max(0.05, np.nan_to_num(reduce.quantile(np.abs(height), 0.99)))
    top = np.nan_to_num(reduce.quantile(error, 0.95), nan=0.05)
    panels = (
        (height, "(a) Height above mean sea level", "Height (m)", style.HEIGHT_COLOURS, (-limit, limit), "both"),
        (error, "(b) Its standard error", "Standard error (m)", style.SPREAD_COLOURS, (0.0, max(top, 0.01)), "max"),
    )
    for column, (values, title, label, colours, (least, most), extend) in enumerate(panels):
        left = _LEFT + column * (_PANEL + _GAP)
        axes = style.place(figure, left, 0.28, _PANEL, _PANEL)
        image = _ground_image(axes, ground, values, colours, (least, most))
        axes.set_title(title)
        axes.set_xlabel("East (m)", labelpad=1.0)
        if column == 0:
            axes.set_ylabel("North (m)", labelpad=1.0)
        style.colour_bar(figure, image, left + 0.2, 0.28 + _PANEL + 0.4, _PANEL - 0.4, label, extend)
    return figure


def _ground_image(axes: Axes, ground: xr.Dataset, values: Array, colours: str, scale: tuple[float, float]) -> AxesImage:
    """The field, framed by what is known of it: a narrow sector fills the frame as well."""
    x, y = (np.asarray(ground[name].values, dtype=np.float64) for name in ("x", "y"))
    axes.set_facecolor(style.BLANK)
    image = draw_ground(axes, (x, y, values), colours, *scale)
    seen = np.isfinite(values)
    if seen.any():
        ends = [each[np.flatnonzero(some)[[0, -1]]] for each, some in ((x, seen.any(axis=0)), (y, seen.any(axis=1)))]
        half = 0.52 * max(*(float(np.ptp(each)) for each in ends), 10.0 * float(np.diff(x[:2]).max(initial=0.0)) or 1.0)
        axes.set_xlim(ends[0].mean() - half, ends[0].mean() + half)
        axes.set_ylim(ends[1].mean() - half, ends[1].mean() + half)
    return image


@style.styled
def draw_by_range(maps: xr.DataTree) -> Figure:
    """Mean level, signal to noise, coherence and the share of cells that answer, against range."""
    polar = maps["polar"].to_dataset()
    distance = np.asarray(polar["range"].values, dtype=np.float64)
    bins = np.array_split(np.arange(distance.size), min(_BINS, distance.size))
    figure = style.new_figure(4.6)
    spots = [(_LEFT + column * 3.6, 0.3 + row * 2.2) for row in (0, 1) for column in (0, 1)]
    axes = [style.place(figure, left, top, 3.0, 1.55) for left, top in spots]
    level = Level.of(polar)
    style.graph(axes[0], "Range (m)", "Level (m)", "(a) Median height of rings, ± standard error")
    axes[0].axhline(0.0, color=style.GREY, linewidth=0.8)
    if level is None:
        style.note(axes[0], "too few heights")
    else:
        axes[0].errorbar(level.distance, level.height, np.nan_to_num(level.error), fmt="o-", color=style.BLUE, ms=3)
    for panel, name, label, title in (
        (axes[1], "snr_db", "SNR (dB)", "(b) Signal to noise of a pulse, median"),
        (axes[2], "coherence", "Coherence", "(c) Coherence of the receivers, median"),
    ):
        style.graph(panel, "Range (m)", label, title)
        y = np.array([reduce.quantile(polar[name].values[..., gates].astype(np.float64), 0.5) for gates in bins])
        if np.isfinite(y).any():
            panel.plot([distance[gates].mean() for gates in bins], y, color=style.BLUE)
        else:
            style.note(panel, "not known")
    style.graph(axes[3], "Range (m)", "Share", "(d) Cells with a height")
    axes[3].plot(distance, np.isfinite(polar["height"].values).mean(axis=(0, 1)), color=style.BLUE)
    axes[3].set_ylim(0.0, 1.02)
    return figure
