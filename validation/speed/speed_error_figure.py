"""The figure of speed_error.py: errors against seconds, the front, and where the seconds go."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import NamedTuple

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.ticker import FuncFormatter, LogLocator, NullLocator

from seamap_rt.mesh.sizing import MeshDetail
from seamap_rt.report import style

from .speed_error_setups import (
    STAGES,
    TRACERS,
    WINDOW_M,
    Array,
    Mesh,
    Point,
    Reference,
    Spline,
    Timed,
    front,
    scene_of,
)

TARGET_S = {"facets": 1.0, "horizon": 0.5}
COLOUR = {"facets": style.BLUE, "horizon": style.VERMILION}
LABELLED = (0, 1)  # quantities whose fronts have their meshes written beside them
STAGE_COLOUR = dict(zip(STAGES, (style.SKY, style.GREY, style.BLUE, style.ORANGE), strict=True))


class Quantity(NamedTuple):
    """An error's name, and how it is shown."""

    name: str
    scale: float
    unit: str
    allowed: float = np.inf


QUANTITIES = (
    Quantity("height", 1e3, "mm", 0.02),
    Quantity("power", 1.0, "dB", 0.3),
    Quantity("visible share", 1e2, "%"),
    Quantity("phase", 1e3, "mrad"),
)


@dataclass(frozen=True)
class Kept:
    """A turn of which one pulse in so many is fired."""

    kept: int
    timed: Timed
    errors: Array  # (seed, 2) m rms of retrieved heights, of the whole window and of 50 to 200 m


@dataclass(frozen=True)
class Drawn:
    """What there is to draw."""

    points: list[Point]
    default: Mesh
    reference: Reference
    splines: dict[Spline, tuple[Point, Array]]  # and (quantity,) the spline's own errors
    kept: list[Kept]

    def of(self, tracer: str) -> list[Point]:
        return [point for point in self.points if point.tracer == tracer]

    @property
    def detail(self) -> MeshDetail:
        return scene_of().detail


def draw(drawn: Drawn, path: Path) -> None:
    path.parent.mkdir(parents=True, exist_ok=True)
    path.write_bytes(style.png(figure_of(drawn)))


@style.styled
def figure_of(drawn: Drawn) -> Figure:
    figure = style.new_figure(8.6)
    for number, quantity in enumerate(QUANTITIES):
        axes = style.place(figure, 0.55 + 3.6 * (number % 2), 0.3 + 2.85 * (number // 2), 2.95, 2.2)
        labels = "; facet m × columns a beam, facets" if number in LABELLED else ""
        title = f"{'abcd'[number]}) {quantity.name}{labels}"
        style.graph(axes, "seconds a turn", f"error, {quantity.unit}, rms", title)
        _target(axes, quantity)
        for tracer in TRACERS:
            _setups(axes, drawn, tracer, number)
        for spline, (point, _) in drawn.splines.items():
            error = quantity.scale * point.errors.window[number]
            axes.plot(point.seconds, error, "D", color=style.GREEN, markersize=3, markerfacecolor="none", zorder=4)
            if spline.order == 3:
                axes.annotate("order 3", (point.seconds, error), (3, -7), textcoords="offset points", fontsize=5)
        residual = quantity.scale * drawn.reference.residual[number]
        axes.axhline(residual, color=style.GREY, linewidth=0.7, linestyle=":")
        axes.annotate("reference's own", (0.99, residual), (0, 2), **_INSIDE)
        _logarithmic(axes, drawn, number)
        if number == 0:
            _legend(axes)
    _stages(style.place(figure, 1.0, 6.1, 2.5, 2.0), drawn)
    _pulses(style.place(figure, 4.15, 6.1, 2.95, 2.0), drawn)
    return figure


_INSIDE = {
    "xycoords": ("axes fraction", "data"),
    "textcoords": "offset points",
    "ha": "right",
    "fontsize": 5.5,
    "color": style.GREY,
}


def _target(axes: Axes, quantity: Quantity) -> None:
    """The target lies towards the lower left."""
    top = quantity.scale * quantity.allowed
    for tracer, seconds in TARGET_S.items():
        if np.isfinite(top):
            axes.fill_between([1e-3, seconds], 1e-6, top, color=COLOUR[tracer], alpha=0.08, linewidth=0.0)
        else:
            axes.axvline(seconds, color=COLOUR[tracer], linewidth=0.5, linestyle="--")


def _setups(axes: Axes, drawn: Drawn, tracer: str, number: int) -> None:
    """A tracer's points with their bars, its front, and the default."""
    points, scale, colour = drawn.of(tracer), QUANTITIES[number].scale, COLOUR[tracer]
    residual = scale * drawn.reference.residual[number]
    for point in points:
        rounds, error = point.timed.totals(tracer), scale * point.errors.window[number]
        across = [[point.seconds - rounds.min()], [rounds.max() - point.seconds]]
        up = [[min(residual, 0.99 * error)], [residual]]
        axes.errorbar(
            point.seconds, error, xerr=across, yerr=up, fmt=_MARK[tracer], color=colour, markersize=3, linewidth=0.5
        )
        if point.mesh == drawn.default:
            axes.plot(point.seconds, error, "*", color=style.BLACK, markersize=8, zorder=5)
    best = front(points, (number,))
    x, y = [p.seconds for p in best], [scale * p.errors.window[number] for p in best]
    axes.plot(x, y, color=colour, linewidth=0.9, zorder=3, drawstyle="steps-post")
    if tracer == "facets" and number in LABELLED:
        before = 0.0
        for point, at in zip(best, zip(x, y, strict=True), strict=True):
            name = f"{point.mesh.facet_m:g} × {point.mesh.columns}"
            if at[0] > _APART * before:
                axes.annotate(name, at, (1, 2), textcoords="offset points", fontsize=5, color=colour, rotation=35)
                before = at[0]


_APART = 1.2  # between the seconds of points that have names
_MARK = {"facets": "o", "horizon": "^"}


def _logarithmic(axes: Axes, drawn: Drawn, number: int) -> None:
    seconds = [point.seconds for point in drawn.points] + list(TARGET_S.values())
    errors = QUANTITIES[number].scale * np.array([point.errors.window[number] for point in drawn.points])
    residual = QUANTITIES[number].scale * drawn.reference.residual[number]
    for axis, name in ((axes.xaxis, "x"), (axes.yaxis, "y")):
        axes.set(**{f"{name}scale": "log"})
        axis.set_major_locator(LogLocator(subs=(1.0, 2.0, 5.0)))
        axis.set_minor_locator(NullLocator())
        axis.set_major_formatter(FuncFormatter(lambda value, _: f"{value:g}"))
    axes.set_xlim(0.8 * min(seconds), 1.7 * max(seconds))
    axes.set_ylim(0.7 * min(residual, errors.min()), 1.9 * max(residual, errors.max()))


def _legend(axes: Axes) -> None:
    for tracer in TRACERS:
        axes.plot(
            [], [], f"{_MARK[tracer]}-", color=COLOUR[tracer], markersize=3, linewidth=0.9, label=f"{tracer}, front"
        )
    axes.plot([], [], "*", color=style.BLACK, markersize=6, label="default")
    axes.fill_between([], [], [], color=style.GREY, alpha=0.15, linewidth=0.0, label="required")
    axes.plot([], [], "D", color=style.GREEN, markersize=3, markerfacecolor="none", label="other splines")
    axes.legend(loc="lower left", fontsize=5.5, handlelength=1.5)


def _stages(axes: Axes, drawn: Drawn) -> None:
    """Where the seconds go along the front of `facets`, and with `horizon`."""
    style.graph(axes, "seconds a turn", "", "e) stages, along the front of height and power")
    shown: list[Point] = front(drawn.of("facets"), (0, 1))
    shown += [point for point in drawn.of("horizon") if point.mesh == drawn.default]
    for row, point in enumerate(shown):
        left = 0.0
        for stage in STAGES:
            width = point.timed.stage(stage, point.tracer)
            axes.barh(row, width, left=left, color=STAGE_COLOUR[stage], height=0.7, label=stage if row == 0 else None)
            left += width
    axes.set_yticks(
        range(len(shown)), [p.label + (" *" if p.mesh == drawn.default else "") for p in shown], fontsize=5.5
    )
    axes.invert_yaxis()
    axes.legend(fontsize=5.5, loc="upper right")


def _pulses(axes: Axes, drawn: Drawn) -> None:
    """Retrieved heights' errors by how many pulses are kept."""
    near, far = WINDOW_M
    style.graph(
        axes, "pulses kept, and the turn's seconds", "error, mm, rms", "f) retrieved heights, speckle and noise in"
    )
    positions = np.arange(len(drawn.kept))
    for column, (label, colour) in enumerate(((f"{near:g}–{far:g} m", style.PURPLE), ("50–200 m", style.BLACK))):
        means, bars = _with_bars([1e3 * each.errors[:, column] for each in drawn.kept])
        axes.errorbar(positions, means, yerr=bars, fmt="o-", color=colour, markersize=3, linewidth=0.9, label=label)
    (own,) = (point for point in drawn.of("facets") if point.mesh == drawn.default)
    axes.axhline(
        1e3 * own.errors.window[0], color=style.BLUE, linewidth=0.8, linestyle="--", label="of these by the mesh"
    )
    names = [f"1 in {each.kept}\n{np.median(each.timed.totals('facets')):.2f} s" for each in drawn.kept]
    axes.set_xticks(positions, names)
    axes.set_ylim(bottom=0.0)
    axes.legend(fontsize=5.5, loc="center right")


def _with_bars(errors: Sequence[Array]) -> tuple[list[float], list[float]]:
    """Means over seeds and their standard errors."""
    bars = [float(each.std(ddof=1) / np.sqrt(each.size)) if each.size > 1 else 0.0 for each in errors]
    return [float(each.mean()) for each in errors], bars
