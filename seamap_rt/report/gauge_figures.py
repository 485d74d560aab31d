"""The radar's map at the wave gauges beside what their wires recorded: in time, by frequency, point by point."""

from __future__ import annotations

import textwrap
from collections.abc import Mapping
from typing import Any

import numpy as np
import xarray as xr
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from scipy.special import chdtri

from ..gauges import GaugeSpectra, NoSpectrum, aliasing, judge_one, spectra
from . import reduce, style
from .page_elements import Picture, Table, columns_table, decimals, digits, percent

MOST_DRAWN = 6  # gauges
_LONGEST = 90  # turns that are drawn in time
_DECADES = 4.0  # of a spectrum that are drawn
_BAND = 0.95  # confidence of the spectra's bar


def gauge_pictures(gauges: xr.Dataset | None) -> list[Picture]:
    """A picture of each of the first gauges; none of a single turn."""
    if gauges is None or gauges.sizes["turn"] < 2:
        return []
    names = [str(name) for name in gauges["gauge"].values[:MOST_DRAWN]]
    return [gauge_picture(number, name, gauges.sel(gauge=name)) for number, name in enumerate(names)]


def gauge_picture(number: int, name: str, gauge: xr.Dataset, turn: int | None = None) -> Picture:
    """One gauge. turn: by its number, which is marked, and the last of those that are drawn in time."""
    turns = gauge.sizes["turn"]
    which = "first" if turn is None else "last"
    part = f" The {which} {_LONGEST} of {turns} turns are drawn." if turns > _LONGEST else ""
    return Picture(
        f"gauge_{number}",
        f"Wave gauge: {name}",
        f"Height at the gauge {name} against time, as its wire and as the radar have it; their spectra; one against "
        "the other.",
        f"At {_metres(gauge['east'])} east, {_metres(gauge['north'])} north. (a) The wire's record, and the "
        "radar's map there once a turn with ± 1.96 stated standard errors; hollow: flagged by the retrieval. Nothing "
        f"is drawn where the map has no height.{part} (b) Spectra of the wire, of the wire read when the radar sees "
        "the gauge, and of the radar, which folds in the same way; drawn for the radar up to half the turn rate alone."
        f"{_caption_of(spectra(gauge))} (c) Radar against wire at the same moments; dashed: "
        "equal, solid: regression of the radar's height on the wire's.",
        lambda: gauge_figure(gauge, turn),
    )


def _metres(coordinate: xr.DataArray) -> str:
    """Metres to the centimetre, without needless zeros or a −0."""
    return f"{round(float(coordinate), 2) + 0.0:g} m"


def _caption_of(result: GaugeSpectra | NoSpectrum) -> str:
    """What the spectra do not show, in sentences that each begin with a blank."""
    words = [result.reason]
    if isinstance(result, GaugeSpectra):
        bar = f"the bar is a {100.0 * _BAND:.0f} % interval, of {result.freedom:.0f} degrees of freedom"
        words = [aliasing(result), result.reason, bar]
    return "".join(f" {word[0].upper()}{word[1:]}." for word in words if word)


@style.styled
def gauge_figure(gauge: xr.Dataset, turn: int | None = None) -> Figure:
    """One gauge: its record in time, its spectra, and the radar's heights against the wire's.

    turn: by its number, which is marked; of many the last ones up to it are drawn.
    """
    figure = style.new_figure(4.75)
    wide = style.WIDTH - 0.62 - 0.12
    _draw_record(style.place(figure, 0.62, 0.28, wide, 1.55), gauge, turn)
    _draw_spectra(style.place(figure, 0.62, 2.42, wide - 2.75, 1.9), spectra(gauge))
    _draw_pairs(style.place(figure, style.WIDTH - 0.12 - 1.9, 2.42, 1.9, 1.9), gauge)
    return figure


def _draw_record(axes: Axes, gauge: xr.Dataset, turn: int | None) -> None:
    style.graph(axes, "Time (s)", "Height (m)", "(a) Height at the gauge")
    last = 0 if turn is None else int(np.searchsorted(gauge["turn"].values, turn, side="right"))
    part = gauge.isel(turn=slice(max(0, last - _LONGEST), max(last, min(_LONGEST, gauge.sizes["turn"]))))
    seen, height, spread, time = (
        each.values for each in (part["seen_time"], part["height"], part["height_std"], gauge["time"])
    )
    known = seen[np.isfinite(seen)]
    begin = float(known.min()) - 1.0 if known.size and last > _LONGEST else float(time[0])
    end = float(known.max()) + 1.0 if known.size else float(time[-1])
    drawn = (time >= begin) & (time <= end)
    axes.axhline(0.0, color=style.GREY, linewidth=0.5)
    axes.plot(time[drawn], gauge["true_height"].values[drawn], color=style.BLACK, linewidth=0.9, label="wire")
    for at in seen[part["turn"].values == turn] if turn is not None else ():
        axes.axvline(at, color=style.GREY, linestyle=":", linewidth=0.9)
    unflagged = part["quality"].values == 0
    for members, face, label in ((unflagged, style.VERMILION, "radar"), (~unflagged, "white", "radar, flagged")):
        shown = members & np.isfinite(height)
        if shown.any():
            axes.errorbar(
                seen[shown], height[shown], 1.96 * spread[shown], linestyle="none", marker="o", markersize=2.8,
                markerfacecolor=face, markeredgecolor=style.VERMILION, markeredgewidth=0.6, ecolor=style.VERMILION,
                elinewidth=0.7, label=label,
            )  # fmt: skip
    axes.set_xlim(begin, end)
    low, high = axes.get_ylim()
    axes.set_ylim(low, high + 0.18 * (high - low))
    axes.legend(loc="upper right", ncols=3)
    if not np.isfinite(height).any():
        axes.text(0.01, 0.96, "the map has no height here", transform=axes.transAxes, va="top", color=style.GREY)


def _draw_spectra(axes: Axes, result: GaugeSpectra | NoSpectrum) -> None:
    style.graph(axes, "Frequency (Hz)", "Spectrum (m² s)", "(b) Spectra")
    if isinstance(result, NoSpectrum):
        style.note(axes, textwrap.fill(result.reason, 44))
        return
    axes.set_yscale("log")
    inside = result.wire_frequency <= 2.0 * result.nyquist
    axes.plot(result.wire_frequency[inside], result.wire[inside], color=style.BLACK, linewidth=0.9, label="wire")
    axes.plot(
        result.frequency, result.wire_once_a_turn, color=style.BLUE, linestyle="--", linewidth=1.0,
        label="wire, once a turn",
    )  # fmt: skip
    if not result.reason:
        axes.plot(result.frequency, result.radar, color=style.VERMILION, label="radar")
    style.upright(axes, result.nyquist, " half the turn rate", va="bottom")
    everything = np.concatenate((result.wire[inside], result.wire_once_a_turn, result.radar))
    top = 3.0 * float(np.nanmax(everything)) if np.nanmax(everything) > 0.0 else 1.0
    axes.set_ylim(top * 10.0**-_DECADES, top)
    axes.set_xlim(0.0, float(result.wire_frequency[inside][-1]))
    low, high = (result.freedom / float(chdtri(result.freedom, 0.5 - 0.5 * side * _BAND)) for side in (1.0, -1.0))
    right, middle = 0.93 * axes.get_xlim()[1], top * 10.0 ** (-0.45 * _DECADES)
    axes.errorbar(
        right, middle, [[middle * (1.0 - low)], [middle * (high - 1.0)]], color=style.GREY, capsize=2.5, linewidth=0.8
    )
    axes.text(0.96 * right, middle, f"{100.0 * _BAND:.0f} % ", color=style.GREY, ha="right", va="center")
    axes.legend(loc="upper right")


def _draw_pairs(axes: Axes, gauge: xr.Dataset) -> None:
    style.graph(axes, "Wire (m)", "Radar (m)", "(c) At the same moments")
    true, result = gauge["seen_true_height"].values, gauge["height"].values.astype(np.float64)
    both = np.isfinite(true) & np.isfinite(result)
    axes.set_aspect("equal")
    if not both.any():
        style.note(axes, "no heights")
        return
    true, result = true[both], result[both]
    reach = 1.08 * max(0.05, float(np.abs(np.concatenate((true, result))).max()))
    ends = np.array([-reach, reach])
    axes.plot(ends, ends, color=style.GREY, linestyle="--", linewidth=0.8)
    axes.plot(true, result, color=style.VERMILION, marker="o", markersize=2.2, linestyle="none", alpha=0.7)
    entry = judge_one(gauge)
    slope = entry["regression_slope"]
    if np.isfinite(slope):
        axes.plot(ends, result.mean() + slope * (ends - true.mean()), color=style.BLACK, linewidth=0.9)
        words = [f"correlation {digits(entry['correlation'], 2)}", f"slope {digits(slope, 2)}"]
        style.corner(axes, [*words, f"error {digits(entry['rms_error_m'], 3)} m rms"])
    axes.set_xlim(-reach, reach)
    axes.set_ylim(-reach, reach)
    style.few_ticks(axes, 5)


def gauge_table(metrics: Mapping[str, Any]) -> list[Table]:
    """All gauges, judged; none without any."""
    entries = metrics.get("gauges")
    if not isinstance(entries, list) or not entries:
        return []
    columns = {
        "name": ("Gauge", str),
        "answered": ("Answered", percent),
        "correlation": ("Correlation", decimals(3)),
        "rms_error_m": ("Error, rms (m)", decimals(3)),
        "bias_m": ("Bias (m)", decimals(3, signed=True)),
        "regression_slope": ("Slope", decimals(2)),
        "stated_error_m": ("Stated error (m)", decimals(3)),
        "cell_rms_error_m": ("Error to the cells' mean (m)", decimals(3)),
        "averaging_rms_m": ("Averaging (m)", decimals(3)),
        "hs_wire_m": ("Hs wire (m)", decimals(2)),
        "hs_true_m": ("Hs at the radar's times (m)", decimals(2)),
        "hs_retrieved_m": ("Hs radar (m)", decimals(2)),
    }
    return [columns_table("Wave gauges", columns, lambda key: [entry[key] for entry in entries], _note(entries))]


def _note(entries: list[Mapping[str, Any]]) -> str:
    """What the columns mean, how few waves it is, and what is missing of which gauge."""
    waves = [reduce.number(entry["waves"]) for entry in entries]
    known = [wave for wave in waves if np.isfinite(wave)]
    count = f" In all {min(known):.0f} to {max(known):.0f} waves passed: few, if Hs is to be known." if known else ""
    reasons = [
        f" {entry['name']}: {entry[key]}." for entry in entries for key in ("reason", "spectrum_reason") if entry[key]
    ]
    hidden = f" Figures show the first {MOST_DRAWN} gauges." if len(entries) > MOST_DRAWN else ""
    return (
        "The radar's heights against the surface at the gauge at the same moments: slope of the radar's on the wire's; "
        "averaging is what the mean over the map's cells differs from the surface at the point by, rms, and no error "
        "of the radar. Hs = 4 std; the radar's has its noise in it." + count + hidden + "".join(reasons)
    )
