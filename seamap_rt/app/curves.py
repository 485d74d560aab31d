"""Graphs of a turn: the section along a look, errors and visibility against range, the sea state turn by turn."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

import numpy as np
from numpy.typing import NDArray

from . import figures
from .figures import Figure
from .prospects import Prospects
from .views import ByRange, Section, Source

_MARGIN = {"l": 50, "r": 10, "t": 30, "b": 66}


def section_of(source: Source, azimuth_deg: float, turn: int, dark: bool) -> Figure:
    """The section of a turn along a look."""
    section = source.section(azimuth_deg, turn)
    heights = np.abs(np.concatenate([section.true, section.retrieved]))
    limit = max(float(np.nanmax(heights)) if np.isfinite(heights).any() else 1.0, 0.2)
    return section_graph(section, limit, dark)


def by_range_of(source: Source, turn: int, dark: bool) -> tuple[Figure | None, Figure]:
    """Errors of a turn against range, None where there is neither a true nor a stated one; and what is in sight."""
    told, law = source.by_range(turn), source.expected()
    known = bool(np.isfinite(told.rms).any() or np.isfinite(told.stated).any())
    return error_graph({"": told}, law, dark) if known else None, visible_graph({"": told}, law, dark)


def section_graph(section: Section, limit_m: float, dark: bool) -> Figure:
    """True and retrieved height along a look, shadows in grey, the antenna and its rays over the crests."""
    ground = section.ground_m
    order = np.argsort(section.placed_m)
    placed = section.placed_m[order]
    data: list[Figure] = []
    if np.isfinite(section.retrieved).any():
        low, high = section.low[order], section.high[order]
        data = [
            *figures.band(placed, low, high, "± 1.96 stated errors", figures.VERMILION, 0.2),
            figures.line(placed, section.retrieved[order], "retrieved", figures.VERMILION),
        ]
    if np.isfinite(section.true).any():
        data.insert(0, figures.line(ground, section.true, "true", figures.ink(dark)))
    top = max(limit_m, section.antenna_m) * 1.1
    for x, y in section.rays():
        data.append({
            "type": "scatter", "mode": "lines", "x": [0.0, x], "y": [section.antenna_m, y], "hoverinfo": "skip",
            "showlegend": False, "line": {"color": figures.ORANGE, "width": 0.7},
        })  # fmt: skip
    data.append({
        "type": "scatter", "mode": "markers", "x": [0.0], "y": [section.antenna_m], "name": "antenna and its rays",
        "marker": {"symbol": "triangle-up", "size": 11, "color": figures.ORANGE},
    })  # fmt: skip
    shadows = [
        {
            "type": "rect", "x0": a, "x1": b, "y0": 0, "y1": 1, "yref": "paper", "line": {"width": 0},
            "fillcolor": "#808890", "opacity": 0.25, "layer": "below",
        }
        for a, b in section.shadows()
    ]  # fmt: skip
    title = f"Along {section.azimuth_deg:.0f}°; grey: less than half in sight"
    look = figures.layout(
        dark, title, 420, shapes=shadows, margin=_MARGIN,
        xaxis=figures.axis("Ground range (m)", dark, range=[0, float(ground[-1])]),
        yaxis=figures.axis("Height (m)", dark, range=[-1.3 * limit_m, top]),
    )  # fmt: skip
    return figures.figure(data, look, figures.CONFIG)


def error_graph(told: Mapping[str, ByRange], floor: Prospects | None, dark: bool) -> Figure:
    """Height error against range: what it is, what is stated, and what the receivers' noise alone would make of it.

    told: one run's, or several by name.
    """
    data: list[Figure] = []
    for (name, each), colour in zip(told.items(), (figures.BLUE, figures.VERMILION, figures.GREEN), strict=False):
        tail = f", {name}" if len(told) > 1 else ""
        if np.isfinite(each.rms).any():
            data.append(figures.line(each.centre_m, each.rms, f"rms error{tail}", colour))
        if np.isfinite(each.stated).any():
            data.append(figures.line(each.centre_m, each.stated, f"stated error{tail}", colour, dash="dash"))
    if floor is not None and floor.ahead is not None:
        expected = floor.ahead.profile["height_error"]
        data.append(
            figures.line(floor.ahead_ground_m, expected, "expected before the run", figures.ORANGE, dash="dash")
        )
    if floor is not None:
        data.append(
            figures.line(floor.ground_m, floor.noise_error_m, "noise of one dwell alone", figures.GREY, dash="dot")
        )
    tops = [float(np.nanmax(v)) for each in told.values() for v in (each.rms, each.stated) if np.isfinite(v).any()]
    top = 1.15 * max(tops, default=0.1)
    look = figures.layout(
        dark, "Height error, cells more than half in sight", 330, margin=_MARGIN,
        xaxis=figures.axis("Ground range (m)", dark, rangemode="tozero"),
        yaxis=figures.axis("m", dark, range=[0, top]),
    )  # fmt: skip
    return figures.figure(data, look)


def visible_graph(told: Mapping[str, ByRange], law: Prospects | None, dark: bool) -> Figure:
    """Share of the sea in sight and share of cells that are answered, beside the closed forms."""
    data: list[Figure] = []
    for (name, each), colour in zip(told.items(), (figures.BLUE, figures.VERMILION, figures.GREEN), strict=False):
        tail = f", {name}" if len(told) > 1 else ""
        if np.isfinite(each.visible).any():
            data.append(figures.line(each.centre_m, 100.0 * each.visible, f"in sight{tail}", colour))
        if np.nansum(each.answered) > 0.0:
            data.append(figures.line(each.centre_m, 100.0 * each.answered, f"answered{tail}", colour, dash="dot"))
    if law is not None:
        data.append(figures.line(law.ground_m, 100.0 * law.smith, "Smith 1967", figures.GREY, dash="dash"))
    look = figures.layout(
        dark, "Share of the sea in sight", 330, margin=_MARGIN,
        xaxis=figures.axis("Ground range (m)", dark, rangemode="tozero"), yaxis=figures.axis("%", dark, range=[0, 103]),
    )  # fmt: skip
    return figures.figure(data, look)


def sea_state_graph(metrics: Mapping[str, Any], dark: bool) -> Figure | None:
    """Wave height by the maps up to each turn with its error, beside the scene's; None where nothing is known."""
    state = metrics.get("sea_state") or {}
    height = _numbers(state.get("significant_wave_height"))
    if not height.size:
        return None
    turn = np.arange(1, height.size + 1)
    data = [figures.line(turn, height, "by the maps", figures.VERMILION, mode="lines+markers")]
    spread = _numbers(state.get("significant_wave_height_std"))
    if spread.size == height.size:
        wide = 1.96 * spread
        data = [
            *figures.band(turn, height - wide, height + wide, "± 1.96 stated errors", figures.VERMILION, 0.2),
            *data,
        ]
    true = metrics.get("hs_scene_m")
    if true is not None:
        data.append(figures.line(turn[[0, -1]], [true, true], "of the scene", figures.ink(dark), dash="dash"))
    look = figures.layout(
        dark, "Significant wave height", 300, margin=_MARGIN, xaxis=figures.axis("Turn", dark),
        yaxis=figures.axis("m", dark, rangemode="tozero"),
    )  # fmt: skip
    return figures.figure(data, look)


def _numbers(values: Any) -> NDArray[np.float64]:
    if not isinstance(values, list):
        return np.array([])
    return np.array([np.nan if each is None else float(each) for each in values])
