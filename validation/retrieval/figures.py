"""Figures of validation/retrieval/maps.py: errors by range beside their floor, and how reliable the error bars are."""

from __future__ import annotations

from collections.abc import Mapping
from pathlib import Path

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from scipy.special import ndtri

from seamap_rt.report.style import (
    BLACK,
    BLUE,
    GREEN,
    GREY,
    ORANGE,
    SKY,
    VERMILION,
    graph,
    new_figure,
    place,
    png,
    styled,
)

from .cells import (
    BINS_M,
    CASES,
    LEAST_CELLS,
    Case,
    Cells,
    by_range,
    classes,
    held,
    name_of,
    rms,
    robust,
)

COLOUR = dict(zip(CASES, (SKY, BLUE, ORANGE, VERMILION), strict=True))
MIDDLES = 0.5 * np.add(BINS_M[:-1], BINS_M[1:])
REQUIRED_SPREAD, REQUIRED_SHARE = (0.9, 1.1), (93.0, 97.0)  # of errors over stated ones


def accuracy(cells: Mapping[Case, Cells], path: Path) -> None:
    path.write_bytes(png(_accuracy(cells)))


@styled
def _accuracy(cells: Mapping[Case, Cells]) -> Figure:
    """Heights of either polarization with noise beside their floors; slopes beside the sea's own."""
    figure = new_figure(2.95)
    for n, case in enumerate(case for case in CASES if case[1]):
        axes = place(figure, 0.55 + 2.25 * n, 0.3, 1.75, 1.8)
        graph(axes, "range, m", "height error, m" if n == 0 else "", f"{'ab'[n]}) heights, {case[0]}, 1 W radar")
        for name, label, style, colour in (
            ("error", "map", "-", BLUE),
            ("known", "with the truth's statistics", "--", BLACK),
            ("drawn", "drawn from them", ":", GREY),
        ):
            axes.plot(MIDDLES, by_range(cells[case], robust, name), style, color=colour, label=label)
        axes.plot(MIDDLES, by_range(cells[case], rms), color=VERMILION, linewidth=0.7, label="map, rms")
        _from_zero(axes, 0.25)
        _legend_below(axes)
    axes = place(figure, 5.2, 0.3, 1.75, 1.8)
    graph(axes, "range, m", "", "c) outward slopes, rms")
    for case in CASES:
        axes.plot(MIDDLES, by_range(cells[case], rms, "outward_error"), color=COLOUR[case], label=name_of(case))
    axes.plot(MIDDLES, by_range(cells[CASES[0]], rms, "outward"), "--", color=GREY, label="of the sea itself")
    _from_zero(axes, 0.07)
    _legend_below(axes)
    return figure


def _legend_below(axes: Axes) -> None:
    axes.legend(loc="upper center", bbox_to_anchor=(0.5, -0.18), ncols=2, fontsize=5.5, columnspacing=1.0)


def _from_zero(axes: Axes, most: float) -> None:
    axes.set_xlim(BINS_M[0], BINS_M[-1])
    axes.set_ylim(0.0, most)


def errorbars(cells: Mapping[Case, Cells], path: Path) -> None:
    path.write_bytes(png(_errorbars(cells)))


@styled
def _errorbars(cells: Mapping[Case, Cells]) -> Figure:
    """Normal quantiles of error over stated error; its spread, and the share within ±1.96, class by class."""
    figure = new_figure(3.6)
    axes = place(figure, 0.5, 0.3, 2.3, 2.9)
    graph(axes, "quantile of a normal distribution", "quantile of error / stated error", "a) unflagged cells")
    tables = {case: dict(classes(each)) for case, each in cells.items()}
    share = np.linspace(0.0005, 0.9995, 400)
    axes.plot([-4.0, 4.0], [-4.0, 4.0], color=GREY, linewidth=0.7)
    for case, each in cells.items():
        ratio = (each["error"] / each["std"])[tables[case]["all"]]
        axes.plot(ndtri(share), np.quantile(ratio, share), color=COLOUR[case], linewidth=1.0, label=name_of(case))
    axes.set_xlim(-3.5, 3.5)
    axes.set_ylim(-5.0, 5.0)
    axes.legend(loc="upper left")
    names = list(tables[CASES[0]])
    spread = place(figure, 4.15, 0.3, 1.2, 2.9)
    graph(spread, "1.4826 MAD", "", "b) spread")
    inside = place(figure, 5.65, 0.3, 1.2, 2.9)
    graph(inside, "% within ±1.96", "", "c) share")
    for panel, required in ((spread, REQUIRED_SPREAD), (inside, REQUIRED_SHARE)):
        panel.axvspan(*required, color=GREEN, alpha=0.2, linewidth=0.0)
    for number, name in enumerate(names):
        for shift, (case, each) in zip((-0.24, -0.08, 0.08, 0.24), cells.items(), strict=True):
            chosen = tables[case][name]
            if np.count_nonzero(chosen) >= LEAST_CELLS:
                estimate = held((each["error"] / each["std"])[chosen])
                for panel, value in ((spread, estimate[0]), (inside, 100.0 * estimate[1])):
                    panel.plot(value, number + shift, "o", color=COLOUR[case], markersize=2.5)
    for panel in (spread, inside):
        panel.set_ylim(len(names) - 0.5, -0.5)
        panel.set_yticks(range(len(names)), names if panel is spread else [""] * len(names))
    return figure
