"""Graphs of past forecasts beside the sea that came, as the report draws them: in time, by lead, and quiet windows."""

from __future__ import annotations

import numpy as np

from ..conventions import turn_name
from . import figures
from .figures import Figure
from .what_came import Came, CameWindows

_WIDE = 1.96  # standard errors
_MARGIN = {"l": 50, "r": 10, "t": 30, "b": 66}


def in_time(came: Came, lead: int, turn: int, dark: bool) -> Figure:
    """The sea at the boat, and what was forecast of it one lead before, with its band. lead: its place. turn: whose
    forecast is marked."""
    time, true = came.sea()
    moment = came.issued + came.lead[lead]
    mean, wide = came.mean[:, lead], _WIDE * came.std[:, lead]
    name = f"forecast {came.lead[lead]:g} s before"
    data = [
        *figures.band(moment, mean - wide, mean + wide, "± 1.96 stated errors", figures.ORANGE),
        figures.line(time, true, "the sea that came", figures.ink(dark)),
        figures.line(
            moment, mean, name, figures.ORANGE, mode="lines+markers", marker={"size": 6, "color": figures.ORANGE}
        ),
    ]
    at = came.at(turn)
    if at is not None:
        data.append({
            "type": "scatter", "mode": "markers", "x": [float(moment[at])], "y": [float(mean[at])],
            "name": f"made after {turn_name(came.issue[at])}",
            "marker": {"symbol": "diamond", "size": 13, "color": figures.VERMILION},
        })  # fmt: skip
    look = figures.layout(
        dark, "What was forecast, and what came", 340, margin=_MARGIN,
        xaxis=figures.axis("Time (s)", dark, range=[float(time[0]), float(moment[-1])]),
        yaxis=figures.axis("Height at the boat (m)", dark),
    )  # fmt: skip
    return figures.figure(data, look)


def errors_by_lead(came: Came, dark: bool) -> Figure:
    """Rms over σ: found, stated, persistence and climatology."""
    told, lead = came.by_lead(), came.lead
    data = [
        figures.line(lead, told["found"], "found", figures.BLUE),
        figures.line(lead, told["stated"], "stated", figures.ORANGE),
        figures.line(lead, told["persistence"], "persistence: the sea stays as it is", figures.GREY, dash="dash"),
        figures.line(lead[[0, -1]], [1.0, 1.0], "climatology: the mean level", figures.GREY, dash="dot"),
    ]
    look = figures.layout(
        dark, "Error over the sea's standard deviation", 320, margin={**_MARGIN, "b": 84},
        xaxis=figures.axis("Seconds ahead", dark), yaxis=figures.axis("Rms error over σ", dark, rangemode="tozero"),
    )  # fmt: skip
    return figures.figure(data, look)


def correlation_by_lead(came: Came, dark: bool) -> Figure:
    """Of forecasts with the sea that came."""
    told = came.by_lead()["correlation"]
    low = float(np.nanmin(told)) if np.isfinite(told).any() else 0.0
    look = figures.layout(
        dark, "Correlation with the sea that came", 320, showlegend=False, margin={**_MARGIN, "b": 84},
        xaxis=figures.axis("Seconds ahead", dark),
        yaxis=figures.axis("Correlation", dark, range=[min(0.0, low) - 0.02, 1.02]),
    )  # fmt: skip
    return figures.figure([figures.line(came.lead, told, "correlation", figures.BLUE)], look)


def windows_of_issue(windows: CameWindows, at: int, confidence: float, title: str, dark: bool) -> Figure:
    """The chances of one forecast's windows, filled where a quiet one came. at: of the issues that are judged."""
    chance, quiet = windows.chance[at], windows.quiet[at] > 0.5
    data = [
        {
            "type": "bar", "x": figures.plain(windows.lead[which]), "y": figures.plain(100.0 * chance[which]),
            "name": name,
            "marker": {
                "color": colour if filled else "rgba(0,0,0,0)", "line": {"color": colour, "width": 1.5},
            },
        }
        for which, name, colour, filled in (
            (quiet, "it was quiet", figures.GREEN, True), (~quiet, "it was not", figures.VERMILION, False),
        )
    ]  # fmt: skip
    level = {
        "type": "line", "xref": "paper", "x0": 0, "x1": 1, "y0": 100.0 * confidence, "y1": 100.0 * confidence,
        "line": {"color": figures.ink(dark), "width": 1, "dash": "dot"},
    }  # fmt: skip
    look = figures.layout(
        dark, title, 260, bargap=0.1, barmode="overlay", shapes=[level], margin=_MARGIN,
        xaxis=figures.axis("Begins in (s)", dark), yaxis=figures.axis("Stated chance (%)", dark, range=[0, 102]),
    )  # fmt: skip
    return figures.figure(data, look)


def reliability(windows: CameWindows, dark: bool) -> Figure:
    """What stated chances came to, by classes with their counts."""
    stated, found = ([100.0 * getattr(each, name) for each in windows.classes] for name in ("stated", "found"))
    data = [
        figures.line([0, 100], [0, 100], "as stated", figures.GREY, dash="dash"),
        figures.line(
            stated, found, "found", figures.BLUE, mode="lines+markers+text", textposition="top left",
            text=[str(each.count) for each in windows.classes], marker={"size": 8, "color": figures.BLUE},
            hovertemplate="stated %{x:.0f} %, found %{y:.0f} % of %{text}<extra></extra>",
        ),
    ]  # fmt: skip
    look = figures.layout(
        dark, "What stated chances came to, with the number of windows", 320, hovermode="closest", margin=_MARGIN,
        xaxis=figures.axis("Stated chance (%)", dark, range=[-3, 103]),
        yaxis=figures.axis("Were quiet (%)", dark, range=[-3, 108]),
    )  # fmt: skip
    return figures.figure(data, look)


def hits(windows: CameWindows, confidence: float, dark: bool) -> Figure:
    """Share of quiet windows that are called against that of the others, as the threshold falls."""
    colours = {"forecast": (figures.BLUE, "solid"), "persistence": (figures.GREY, "dash")}
    data = [
        figures.line(100.0 * alarms, 100.0 * hit, f"{name}, area {area:.2f}", colours[name][0], dash=colours[name][1])
        for name, (alarms, hit, area) in windows.curves.items()
        if name in colours
    ]
    called, quiet = windows.chance >= confidence, windows.quiet > 0.5
    if quiet.any() and not quiet.all():
        data.append({
            "type": "scatter", "mode": "markers", "x": [100.0 * float(called[~quiet].mean())],
            "y": [100.0 * float(called[quiet].mean())], "name": f"called at {confidence:.0%}",
            "marker": {"size": 10, "color": figures.VERMILION, "symbol": "diamond"},
        })  # fmt: skip
    look = figures.layout(
        dark, "Hits and false alarms", 320, hovermode="closest", margin=_MARGIN,
        xaxis=figures.axis("Of the other windows, called (%)", dark, range=[-3, 103]),
        yaxis=figures.axis("Of the quiet ones, called (%)", dark, range=[-3, 103]),
    )  # fmt: skip
    return figures.figure(data, look)
