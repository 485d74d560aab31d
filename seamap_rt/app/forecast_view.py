"""The forecast of a run: the water at the boat in the next seconds with its band, quiet windows, the highest wave."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np
from nicegui import ui

from ..conventions import turn_name
from ..io.growing_file import GrowingFile, read_whole_turns
from ..io.turn_files import part_of
from ..settings import QuietSettings
from . import drawing, figures
from .verified_view import VerifiedPanel
from .what_came import Came
from .words import label_of

if TYPE_CHECKING:
    from .see_view import SeeView
    from .views import Source


@dataclass(frozen=True)
class Ahead:
    """One forecast at the boat. Arrays (lead,): lead [s], elevation and its standard error [m], chance that a quiet
    window begins, NaN where none is forecast. limits: what a window stays below, in words; empty where none is asked
    for."""

    issue: int
    lead_s: np.ndarray
    elevation_m: np.ndarray
    std_m: np.ndarray
    chance: np.ndarray
    limits: str
    level_m: float | None
    duration_s: float
    confidence: float
    hs_m: float
    longest_s: float | None = None

    @property
    def highest(self) -> int:
        """Of the leads, where the highest crest is expected."""
        return int(np.argmax(self.elevation_m))


def read_ahead(folder: Path, last: int, quiet: QuietSettings) -> Ahead | None:
    """The last forecast that was issued up to a turn by its number; None where there is none. quiet: as was asked."""
    path = folder / "prediction.nc"
    if not path.exists() and not part_of(path).exists():
        return None

    def read(file: GrowingFile) -> tuple[int, dict[str, np.ndarray]] | None:
        issues = np.asarray(file.array("issue")[:])
        held = np.flatnonzero(issues <= last)
        if not held.size:
            return None
        at = int(held[-1])
        found = {"lead": np.asarray(file.array("lead")[:])}
        for name in ("elevation", "elevation_std", "quiet", "significant_wave_height", "maximum_prediction_time"):
            if name in file:
                found[name] = np.asarray(file.array(name)[at])
        return int(issues[at]), found

    told = read_whole_turns(path, read)
    return None if told is None else _ahead(*told, quiet)


def _ahead(issue: int, told: dict[str, np.ndarray], quiet: QuietSettings) -> Ahead:
    lead = told["lead"].astype(float)
    limits = [f"{words_of(f'prediction.quiet.{key}')} {value:g} {unit}" for key, value, unit in _given(quiet)]
    return Ahead(
        issue=issue,
        lead_s=lead,
        elevation_m=told["elevation"][:, 0],
        std_m=told["elevation_std"][:, 0],
        chance=told["quiet"][:, 0] if "quiet" in told else np.full(lead.size, np.nan),
        limits=", ".join(limits),
        level_m=quiet.elevation_m,
        duration_s=quiet.duration_s,
        confidence=quiet.confidence,
        hs_m=float(told["significant_wave_height"]),
        longest_s=float(told["maximum_prediction_time"][0]) if "maximum_prediction_time" in told else None,
    )


def _given(quiet: QuietSettings) -> list[tuple[str, float, str]]:
    units = {"elevation_m": "m", "velocity_z_m_s": "m/s", "heave_m": "m", "roll_deg": "°", "pitch_deg": "°"}
    return [(name, float(value), unit) for name, unit in units.items() if (value := getattr(quiet, name)) is not None]


def words_of(key: str) -> str:
    """A limit's name, as in "water height below"."""
    label = label_of(key)
    return label[:1].lower() + label[1:].replace("stays below", "below")


class ForecastPanel:
    """Shows `Ahead`, and how past forecasts of the run came out."""

    def __init__(self, view: SeeView) -> None:
        self.view = view
        self.said = ui.label().classes("font-bold").mark("forecast-words")
        blank = figures.figure([], figures.layout(view.page.dark))
        self.ahead = ui.plotly(blank).classes("w-full").mark("forecast")
        self.windows = ui.plotly(blank).classes("w-full")
        with ui.column().classes("w-full min-w-0 gap-2") as self.past:
            self.verified = VerifiedPanel(view)

    async def show(self, source: Source, turn: int) -> None:
        """The last forecast up to a turn."""
        quiet = source.scene.prediction.quiet if source.scene is not None else QuietSettings()
        number = source.results.turns()[turn]
        found = await self._show(source.results.folder, number, quiet)
        self.past.set_visibility(found is not None)
        if found is None:
            return
        self.view.easel.ready()  # what came may take long
        came = await self.verified.show(source, turn)
        if came is not None:
            self.ahead.update_figure(_curve(found, self.view.page.dark, came))

    async def show_issue(self, folder: Path, number: int) -> None:
        """Of a folder that has no maps, and so nothing that came."""
        self.past.set_visibility(False)
        await self._show(folder, number, QuietSettings())

    async def _show(self, folder: Path, number: int, quiet: QuietSettings) -> Ahead | None:
        found = await drawing.slow(read_ahead, folder, number, quiet)
        self.ahead.set_visibility(found is not None)
        self.windows.set_visibility(found is not None and bool(np.isfinite(found.chance).any()))
        if found is None:
            self.said.set_text(
                "This run made no forecast yet. Tick “forecast too” beside Run; the first comes when maps show a sea."
            )
            return None
        self.said.set_text(_words(found))
        self.ahead.update_figure(_curve(found, self.view.page.dark))
        self.windows.update_figure(_chances(found, self.view.page.dark))
        return found


def _words(ahead: Ahead) -> str:
    at = ahead.highest
    wide = 1.96 * ahead.std_m[at]
    crest = (
        f"The highest crest that is expected: {ahead.elevation_m[at]:.2f} ± {wide:.2f} m in {ahead.lead_s[at]:.0f} s."
    )
    if not np.isfinite(ahead.chance).any():
        return f"{crest} Quiet windows are forecast where Forecast, Quiet windows in the design names a limit."
    sure = np.nan_to_num(ahead.chance, nan=0.0)
    called = np.flatnonzero(sure >= ahead.confidence)
    best = int(called[0]) if called.size else int(np.argmax(sure))
    opens = f"opens in {ahead.lead_s[best]:.0f} s ({sure[best]:.0%} sure)"
    window = (
        f"A quiet window of {ahead.duration_s:g} s {opens}" if called.size else f"The likeliest quiet window {opens}"
    )
    return f"{window}. {crest}"


def _curve(ahead: Ahead, dark: bool, came: Came | None = None) -> figures.Figure:
    """came: what came of it, where that is known."""
    wide = 1.96 * ahead.std_m
    data = [
        *figures.band(
            ahead.lead_s, ahead.elevation_m - wide, ahead.elevation_m + wide, "± 1.96 stated errors", figures.BLUE
        ),
        figures.line(ahead.lead_s, ahead.elevation_m, "water at the boat", figures.BLUE),
    ]
    held = came.at(ahead.issue) if came is not None else None
    if came is not None and held is not None:
        data.append(figures.line(came.lead, came.true[held], "what came", figures.ink(dark), dash="dot"))
    at = ahead.highest
    data.append({
        "type": "scatter", "mode": "markers", "x": [float(ahead.lead_s[at])], "y": [float(ahead.elevation_m[at])],
        "name": "highest crest", "marker": {"symbol": "star", "size": 12, "color": figures.VERMILION},
    })  # fmt: skip
    ends = [] if ahead.longest_s is None else [
        {"type": "line", "x0": ahead.longest_s, "x1": ahead.longest_s, "y0": 0, "y1": 1, "yref": "paper",
         "line": {"color": figures.BLUE, "width": 1, "dash": "dashdot"},
         "label": {"text": f"maximum prediction time {ahead.longest_s:.0f} s", "textposition": "end"}}
    ]  # fmt: skip
    levels = () if ahead.level_m is None else (-ahead.level_m, ahead.level_m)
    quiet = [
        {"type": "line", "x0": 0, "x1": 1, "xref": "paper", "y0": level, "y1": level,
         "line": {"color": figures.GREEN, "width": 1, "dash": "dot"}}
        for level in levels
    ]  # fmt: skip
    look = figures.layout(
        dark, f"The next {ahead.lead_s[-1]:.0f} s at the boat, as known after {turn_name(ahead.issue)}",
        340, shapes=[*quiet, *ends], margin={"l": 50, "r": 10, "t": 30, "b": 66},
        xaxis=figures.axis("Seconds ahead", dark), yaxis=figures.axis("Height (m)", dark),
    )  # fmt: skip
    return figures.figure(data, look)


def _chances(ahead: Ahead, dark: bool) -> figures.Figure:
    colours = [
        figures.GREEN if np.isfinite(each) and each >= ahead.confidence else figures.GREY for each in ahead.chance
    ]
    bars = {
        "type": "bar", "x": figures.plain(ahead.lead_s), "y": figures.plain(100.0 * ahead.chance),
        "marker": {"color": colours}, "name": "chance",
    }  # fmt: skip
    of = f"{ahead.duration_s:g} s with {ahead.limits}" if ahead.limits else "a quiet window"
    look = figures.layout(
        dark, f"Chance of {of}; green: called",
        220, showlegend=False, bargap=0.1, xaxis=figures.axis("Begins in (s)", dark),
        yaxis=figures.axis("%", dark, range=[0, 102]),
    )  # fmt: skip
    return figures.figure([bars], look)
