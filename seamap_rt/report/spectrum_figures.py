"""Wave spectra over frequency and over the compass: of a scene, and of maps beside the true sea.

Directions are those the waves come from.
"""

from __future__ import annotations

import textwrap
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Any, NamedTuple

import numpy as np
import xarray as xr
from matplotlib.axes import Axes
from matplotlib.collections import QuadMesh
from matplotlib.colors import PowerNorm
from matplotlib.figure import Figure
from matplotlib.ticker import MaxNLocator

from ..scene import Scene
from ..sea import ResolvedSea
from . import reduce, style
from .page_elements import Picture
from .reduce import Array

_COLOURS = (style.BLUE, style.VERMILION, style.GREEN, style.ORANGE, style.PURPLE, style.SKY)  # of wave systems
_MARKERS = ("o", "s", "D")  # short-crested, long-crested, regular
_DECADES = 5.0  # of a spectrum that are drawn
_DENSITY = "Density, m²/(Hz·degree), square-root scale"


class _System(NamedTuple):
    """One wave system as the figures draw it."""

    words: str
    colour: str
    marker: str
    regular: bool
    from_deg: float
    peak_hz: float
    density: Array  # (frequency,) m² s


def _systems(scene: Scene, spectrum: xr.Dataset) -> list[_System]:
    result = []
    for row, number in enumerate(spectrum["system"].values):
        values = {name: spectrum[f"system_{name}"].values[row] for name in ("kind", "direction", "period", "spectrum")}
        words, kind = reduce.describe_waves(scene.sea.waves[number], scene.sea.depth_m), values["kind"]
        look = words, _COLOURS[row % len(_COLOURS)], _MARKERS[kind], kind == len(_MARKERS) - 1
        result.append(_System(*look, float(values["direction"]), 1.0 / float(values["period"]), values["spectrum"]))
    return result


@style.styled
def directional_spectrum(scene: Scene, spectrum: xr.Dataset, resolved: ResolvedSea) -> Figure:
    """The directional spectrum over the compass, and the spectrum of each system over frequency.

    spectrum: the schema's `sea/spectrum`, with its attribute `resolved_up_to_hz`.
    """
    systems = _systems(scene, spectrum)
    figure = style.new_figure(4.3)
    rose = style.place(figure, 0.38, 0.62, 2.7, 2.7, projection="polar")
    _rose(figure, rose, spectrum, systems)
    axes = style.place(figure, 4.0, 0.3, style.WIDTH - 4.0 - 0.12, 2.5)
    _spectra(axes, spectrum, systems)
    words = (
        f"Dashed: the shortest resolved waves, {2.0 * resolved.resolution_m:.3g} m long. Resolved are "
        f"{resolved.variance_share:.2%} of the variance and {resolved.mean_square_slope_share:.0%} of these spectra's "
        f"mean square slope, {resolved.mean_square_slope:.3g}. Shorter waves are left to the scattering model."
    )
    if scene.sea.current_m_s > 0.0:
        words += " The sea rides on a current; frequencies are those in the water's frame."
    top = 1.0 - 3.35 / float(figure.get_size_inches()[1])
    figure.text(3.6 / style.WIDTH, top, textwrap.fill(words, 60), va="top", fontsize=style.FONT, linespacing=1.4)
    return figure


def _rose(figure: Figure, axes: Any, spectrum: xr.Dataset, systems: list[_System]) -> None:
    """E(f, θ) with the systems' peaks."""
    density, frequency = spectrum["directional_spectrum"].values, spectrum["frequency"].values
    reach = _reach(spectrum, systems)
    shown, most = frequency <= 1.1 * reach, float(density.max())
    drawn = draw_compass(axes, frequency[shown], spectrum["direction"].values, density[shown], most, reach)
    axes.set_title("(a) Where the waves come from", x=-0.08, y=1.12)
    if drawn is not None:
        style.colour_bar(figure, drawn, 0.75, 3.72, 1.96, _DENSITY, "neither")
    for system in systems:
        axes.plot(
            np.radians(system.from_deg), system.peak_hz, marker=system.marker, markersize=4.0, linestyle="none",
            markerfacecolor=system.colour, markeredgecolor="white", markeredgewidth=0.7, clip_on=False, zorder=5.0,
        )  # fmt: skip
    axes.set_rlabel_position((systems[0].from_deg if systems else 0.0) + 157.5)


def draw_compass(
    axes: Any, frequency: Array, from_deg: Array, density: Array, most: float, reach_hz: float
) -> QuadMesh | None:
    """A density (frequency, direction) on polar axes: the radius is the frequency, the angle the azimuth the waves come
    from. most: of the colours; None where nothing is drawn."""
    axes.set_theta_zero_location("N")
    axes.set_theta_direction(-1)
    axes.set_thetagrids(np.arange(0, 360, 45), ["N", "45°", "E", "135°", "S", "225°", "W", "315°"])
    axes.tick_params(pad=-1.0)
    colours = style.colours(style.SPREAD_COLOURS)
    axes.set_facecolor(colours(0.0))  # below the lowest frequency
    drawn = None
    if most > 0.0:
        drawn = axes.pcolormesh(
            np.radians(reduce.edges(from_deg)), reduce.edges(frequency), density, cmap=colours,
            norm=PowerNorm(0.5, 0.0, most), shading="flat", rasterized=True,
        )  # fmt: skip
    axes.set_ylim(0.0, reach_hz)
    axes.yaxis.set_major_locator(MaxNLocator(4, steps=[1, 2, 2.5, 5, 10]))
    axes.yaxis.set_major_formatter(lambda hertz, _: f"{hertz:g} Hz" if 0.0 < hertz < 0.75 * reach_hz else "")
    axes.tick_params(axis="y", labelsize=style.FONT - 1.0, colors=style.ON_COLOURS)
    axes.grid(True, color=style.ON_COLOURS, alpha=0.85, linewidth=0.35)
    return drawn


@style.styled
def draw_rose(
    frequency: Array, from_deg: Array, density: Array, lines: Sequence[tuple[float, float, float]], wide: float
) -> Figure:
    """A density (frequency, direction) over the compass. lines: regular or long-crested systems, as frequency [Hz],
    direction and height [m]. wide: inches."""
    figure = style.new_figure(3.2, wide)
    axes: Any = style.place(figure, 0.5 * wide - 1.1, 0.25, 2.2, 2.2, projection="polar")
    drawn = draw_compass(axes, frequency, from_deg, density, float(density.max(initial=0.0)), float(frequency[-1]))
    for at, direction, height in lines:
        axes.plot(np.radians(direction), at, "o", color=style.VERMILION, markeredgecolor="white", markersize=5.0)
        axes.annotate(f" {height:.2g} m", (np.radians(direction), at), color=style.ON_COLOURS)
    axes.set_rlabel_position(from_deg[np.argmax(density.max(axis=0))] + 157.5)
    if drawn is not None:
        style.colour_bar(figure, drawn, 0.5 * wide - 1.0, 2.72, 2.0, _DENSITY, "neither")
    return figure


def _reach(spectrum: xr.Dataset, systems: list[_System]) -> float:
    """Frequency [Hz] up to which the compass goes: most of the variance and every peak."""
    frequency, total = spectrum["frequency"].values, spectrum["frequency_spectrum"].values
    below = np.cumsum(total * np.gradient(frequency))
    most = frequency[np.searchsorted(below, 0.97 * below[-1])] if below[-1] > 0.0 else 0.0
    peaks = [1.3 * system.peak_hz for system in systems]
    return float(max([most, *peaks], default=0.0)) or float(frequency[-1])


def _spectra(axes: Axes, spectrum: xr.Dataset, systems: list[_System]) -> None:
    """S(f) of each random system and of all, a line for each regular wave, and the resolved limit."""
    frequency, total = spectrum["frequency"].values, spectrum["frequency_spectrum"].values
    style.graph(axes, "Frequency (Hz)", "Density (m²/Hz)", "(b) Spectrum over frequency")
    top = 1.5 * float(total.max()) if total.max() > 0.0 else 1.0
    random = [system for system in systems if not system.regular]
    for system in systems:
        words = f"{system.words} (a line)" if system.regular else system.words
        ends = {"color": system.colour, "linewidth": 1.3, "label": words, "marker": system.marker}
        if system.regular:
            axes.plot([system.peak_hz, system.peak_hz], [1e-30, top], markevery=[1], markersize=4.0, **ends)
        else:
            peak = int(np.argmin(np.abs(frequency - system.peak_hz)))
            axes.plot(frequency, system.density, markevery=[peak], markersize=4.0, **ends)
    if len(random) > 1:
        axes.plot(frequency, total, color=style.BLACK, linewidth=0.8, linestyle="-", label="random systems together")
    axes.axvline(float(spectrum.attrs["resolved_up_to_hz"]), color=style.BLACK, linestyle="--", linewidth=0.9)
    axes.set_xscale("log")
    axes.set_yscale("log")
    axes.set_xlim(float(frequency[0]), float(frequency[-1]))
    axes.set_ylim(top / 10.0**_DECADES, top * 10.0 ** (0.1 + 0.55 * (len(systems) + 1)))  # room for the legend
    ticks = [tick for tick in (0.02, 0.05, 0.1, 0.2, 0.5, 1.0, 2.0, 5.0) if frequency[0] <= tick <= frequency[-1]]
    axes.set_xticks(ticks, [f"{tick:g}" for tick in ticks])
    axes.minorticks_off()
    if systems:
        axes.legend(loc="upper right", handlelength=1.6, frameon=True, framealpha=0.9, edgecolor="none")
    else:
        style.note(axes, "no waves")


# --------------------------------------------------------------------------------------------------- by the maps


@dataclass(frozen=True)
class Density:
    """Mean spectrum of some turns: frequency (f,) Hz, density (f,) m²/Hz; over direction bins (d,) of degrees that the
    waves come from `directional` (f, d) m²/Hz/°, over `bins` (f,) Hz; None where directions are unknown."""

    frequency: Array
    density: Array
    bins: Array
    direction: Array
    directional: Array | None


def map_spectra_picture(
    retrieved: Density | None, true: Density | None, of_scene: tuple[Array, Array] | None, words: str
) -> Picture:
    """See `map_spectra`. words: of which turns, and what is missing."""
    return Picture(
        "map_spectra",
        "By frequency and direction",
        "Wave spectrum by the maps beside that of the true sea: by frequency, and by frequency and direction.",
        f"{words} (a) Of the true sea: the mean over the map's cells. Directions are those the waves come from.",
        lambda: map_spectra(retrieved, true, of_scene),
    )


@style.styled
def map_spectra(retrieved: Density | None, true: Density | None, of_scene: tuple[Array, Array] | None = None) -> Figure:
    """The spectrum by the maps beside the true one: over frequency, and over the compass on one scale.

    of_scene: frequency [Hz] and density [m²/Hz] that the scene asks for.
    """
    given = [(name, each) for name, each in (("True sea", true), ("By the maps", retrieved)) if each is not None]
    roses = [(name, each, each.directional) for name, each in given if each.directional is not None]
    most = max((float(directional.max()) for *_, directional in roses), default=0.0)
    figure = style.new_figure(6.5 if most > 0.0 else 2.7)
    axes = style.place(figure, 0.62, 0.28, style.WIDTH - 0.74, 1.95)
    style.graph(axes, "Frequency (Hz)", "Density (m²/Hz)", "(a) Spectrum over frequency")
    if of_scene is not None:
        axes.plot(*of_scene, color=style.GREY, linestyle=":", label="of the design")
    for (name, each), colour in zip(given, (style.BLACK, style.VERMILION)[-len(given) :], strict=True):
        axes.plot(each.frequency, each.density, color=colour, label=name)
    axes.set_xlim(left=0.0)
    axes.set_ylim(bottom=0.0)
    axes.legend(loc="upper right")
    for number, (name, each, directional) in enumerate(roses if most > 0.0 else ()):
        left = 0.55 + 3.55 * number
        rose = style.place(figure, left, 3.15, 2.6, 2.6, projection="polar")
        drawn = draw_compass(rose, each.bins, each.direction, directional, most, float(each.bins[-1]))
        rose.set_title(f"({'bc'[number]}) {name}", x=-0.08, y=1.1)
        peak = int(np.argmax(directional.max(axis=0)))
        rose.set_rlabel_position(float(each.direction[peak]) + 157.5)  # pyright: ignore[reportAttributeAccessIssue]
        if number == 0:
            style.colour_bar(figure, drawn, 2.62, 6.05, 1.96, _DENSITY, "neither")
    return figure


def wave_height_pictures(metrics: Mapping[str, Any]) -> list[Picture]:
    """The wave height by the maps, turn by turn; none where no turn shows a sea."""
    state = metrics.get("sea_state")
    if not isinstance(state, Mapping) or not np.isfinite(reduce.series(state.get("significant_wave_height"))).any():
        return []
    return [
        Picture(
            "wave_height",
            "Significant wave height, turn by turn",
            "Graph of the significant wave height by all maps up to each turn, with its stated error, beside the "
            "scene's.",
            "Hs by the maps up to each turn, their noise, gaps and cells allowed for, ± 1.96 stated standard errors. "
            "Dashed: of the scene.",
            lambda: wave_height(metrics),
        )
    ]


@style.styled
def wave_height(metrics: Mapping[str, Any]) -> Figure:
    """By the maps up to each turn with its error, beside the scene's."""
    state = metrics["sea_state"]
    height = reduce.series(state["significant_wave_height"])
    spread = reduce.series(state.get("significant_wave_height_std"), height.size)
    turn, true = np.arange(1, height.size + 1), reduce.number(metrics.get("hs_scene_m"))
    figure = style.new_figure(2.3)
    axes = style.place(figure, 0.62, 0.28, style.WIDTH - 0.74, 1.55)
    style.graph(axes, "Turn", "Hs (m)", "")
    high = height + 1.96 * spread
    style.band(axes, turn, height - 1.96 * spread, high, style.VERMILION, 0.2)
    axes.plot(turn, height, "o-", color=style.VERMILION, markersize=2.5, label="by the maps, ± 1.96 stated errors")
    if np.isfinite(true):
        axes.axhline(true, color=style.BLACK, linestyle="--", linewidth=0.9, label="of the scene")
    axes.set_ylim(0.0, 1.25 * float(np.nanmax(np.concatenate([height, high, [true]]))))
    axes.xaxis.set_major_locator(MaxNLocator(10, integer=True))
    axes.legend(loc="lower right", ncols=2)
    return figure
