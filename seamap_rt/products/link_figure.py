"""A link budget against range: echo and noise, what integration makes of them, and the weakest sea that stands out."""

from __future__ import annotations

import textwrap

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.ticker import FuncFormatter, LogLocator, NullFormatter
from numpy.typing import NDArray

from ..conventions import db
from ..radar import link
from ..radar.antenna import antenna
from ..radar.link import LinkBudget, nrcs_words
from ..radar.waveform import blind_range_m
from ..report import style
from ..scene import Scene

_DASHES = {"textbook": "--", "simulator": "-"}
_COLOURS = (style.BLACK, style.BLUE, style.VERMILION)  # one pulse, non-coherent, coherent
_LINE = 118  # letters across the figure
_MARGIN = 6.0  # dB beyond the textbook's own levels: a null of the elevation pattern may leave the frame


@style.styled
def draw(scene: Scene, curve: LinkBudget) -> Figure:
    """Four panels over the ranges of the curve, which are close enough to be drawn as lines."""
    height, left, wide, high = 5.6, 0.62, 2.72, 1.95
    figure = style.new_figure(height)
    right = style.WIDTH - wide - 0.14
    panels = [style.place(figure, x, y, wide, high) for y in (0.58, 3.18) for x in (left, right)]
    near, far = float(curve.range[0]), float(curve.range[-1])
    for axes, panel in zip(panels, (_draw_gain, _draw_power, _draw_ratio, _draw_weakest), strict=True):
        panel(axes, scene, curve)
        _set_range_axis(axes, near, far)
        if (blind := blind_range_m(scene.radar)) > near:
            axes.axvspan(near, min(blind, far), color=style.GRID, alpha=0.45, linewidth=0.0, zorder=0.5)
    figure.text(left / style.WIDTH, 1.0 - 0.2 / height, _heading(scene, curve), fontsize=style.FONT, va="center")
    return figure


def _draw_gain(axes: Axes, scene: Scene, curve: LinkBudget) -> None:
    style.graph(axes, "", "One-way gain (dBi)", "(a) Gain towards mean sea level, mid-beam")
    peak = float(db(antenna(scene.radar).gain))
    axes.axhline(peak, color=style.GREY, linestyle=":", linewidth=1.0, label=f"boresight, {peak:.1f} dBi")
    axes.plot(curve.range, db(curve.gain), color=style.BLACK, label="towards the sea")
    if blind_range_m(scene.radar) > curve.range[0]:
        axes.plot([], [], color=style.GRID, linewidth=6.0, label="pulse still being sent")
    axes.set_ylim(max(float(db(curve.gain).min()) - 1.0, peak - 30.0), peak + 1.5)
    axes.legend(loc="lower right")


def _draw_power(axes: Axes, scene: Scene, curve: LinkBudget) -> None:
    style.graph(axes, "", "Power (dBm)", "(b) Echo of one pulse, and noise")
    for budget in curve.budgets:
        level = db(1e3 * budget.power)
        axes.plot(curve.range, level, color=style.BLACK, linestyle=_DASHES[budget.name], label=budget.name)
    noise = float(db(1e3 * curve.noise))
    label = f"noise, {noise:.1f} dBm".replace("-", "−")
    axes.axhline(noise, color=style.GREY, linestyle=":", linewidth=1.0, label=label)
    _set_limits(axes, [*(db(1e3 * budget.power) for budget in curve.budgets), np.array([noise])])
    axes.legend(loc="upper right")


def _draw_ratio(axes: Axes, scene: Scene, curve: LinkBudget) -> None:
    style.graph(axes, "Slant range (m)", "Signal to noise (dB)", "(c) Signal to noise, ranges of the simulator")
    axes.axhline(0.0, color=style.GREY, linestyle=":", linewidth=1.0)
    for budget in curve.budgets:
        for integration, colour, row in zip(curve.integrations, _COLOURS, budget.snr, strict=True):
            reach = link.furthest(curve.range, row)
            words = f"{integration.name}: 0 dB at {reach:.0f} m" if np.isfinite(reach) else integration.name
            axes.plot(
                curve.range, db(row), color=colour, linestyle=_DASHES[budget.name],
                label=words if budget.name == "simulator" else None,
            )  # fmt: skip
    _set_limits(axes, [*(db(row) for budget in curve.budgets for row in budget.snr), np.zeros(1)])
    axes.legend(loc="upper right")


def _draw_weakest(axes: Axes, scene: Scene, curve: LinkBudget) -> None:
    style.graph(axes, "Slant range (m)", "σ0 (dB)", "(d) Weakest σ0 at 0 dB, and the mean sea")
    for budget in curve.budgets:
        for colour, row in zip(_COLOURS, budget.minimum_nrcs, strict=True):
            axes.plot(curve.range, db(row), color=colour, linestyle=_DASHES[budget.name])
    axes.plot(curve.range, db(curve.nrcs), color=style.GREEN, linewidth=2.0, label="mean σ0 of the scene")
    levels = [db(row) for budget in curve.budgets for row in budget.minimum_nrcs]
    _set_limits(axes, [*levels, db(curve.nrcs)])
    axes.legend(loc="lower right")


def _set_limits(axes: Axes, levels: list[NDArray[np.float64]]) -> None:
    """Limits [dB] that hold the levels; of a deep null only the upper part."""
    finite = np.concatenate([level[np.isfinite(level)] for level in levels])
    low, high = np.percentile(finite, 1.0), np.percentile(finite, 99.0)
    axes.set_ylim(float(low) - _MARGIN, float(high) + _MARGIN)


def _set_range_axis(axes: Axes, near: float, far: float) -> None:
    """Logarithmic, labelled in metres."""
    axes.set_xscale("log")
    axes.set_xlim(near, far)
    axes.xaxis.set_major_locator(LogLocator(10.0, (1.0, 2.0, 5.0)))
    axes.xaxis.set_major_formatter(FuncFormatter(lambda metres, _: f"{metres:g}"))
    axes.xaxis.set_minor_formatter(NullFormatter())


def _heading(scene: Scene, curve: LinkBudget) -> str:
    radar = scene.radar
    width, height = link.beam_widths_deg(radar)
    pulses = link.dwell(radar).pulses
    chirp = f" chirp of {radar.chirp_bandwidth_hz / 1e6:g} MHz" if radar.waveform == "chirp" else ""
    sent = f"{radar.transmit_power_w:g} W, {1e9 * radar.pulse_width_s:g} ns{chirp}"
    sea = textwrap.fill(nrcs_words(curve), _LINE)
    return (
        f"{scene.name}: {sent}, beam {width:.3g}° × {height:.3g}°, antenna at {radar.height_m:g} m, {pulses} pulses a "
        f"dwell\n{sea[:1].upper()}{sea[1:]}"
    )
