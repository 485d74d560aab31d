"""The forecast of a run: the water at the boat in the next seconds with its band, quiet windows, the highest wave; and
how past forecasts came out.
"""

from __future__ import annotations

import asyncio
from collections.abc import Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Any, NamedTuple

import numpy as np
from nicegui import ui
from numpy.typing import NDArray

from ..conventions import written
from ..errors import InputError
from ..forecast_errors import warm
from ..io.reading import read_whole_turns, results_exist
from ..report.forecast_figures import BoatForecast, ahead_picture, errors_by_lead, verified_picture, window_picture
from ..report.keys import words_of
from ..report.page_elements import draw_images
from ..settings import QuietSettings
from . import drawing
from .page import Image, Images, choice, count_on, slider
from .verification import Verification

if TYPE_CHECKING:
    from .see_view import SeeView
    from .source import Source


_LEAD_S = 10.0  # of the forecasts that are drawn first, as in the report


def read_ahead(folder: Path, last: int, quiet: QuietSettings) -> BoatForecast | None:
    """The last forecast that was issued up to a turn by its number; None where there is none. quiet: as requested."""
    path = folder / "prediction.nc"
    if not results_exist(path):
        return None

    def read(file: Any) -> tuple[int, NDArray[Any], dict[str, NDArray[Any]]] | None:
        issues = np.asarray(file["issue"][:])
        held = np.flatnonzero(issues <= last)
        if not held.size:
            return None
        names = ("elevation", "elevation_std", "quiet", "maximum_prediction_time")
        found = {name: np.asarray(file[name][int(held[-1])])[..., 0] for name in names if name in file}
        return int(issues[held[-1]]), np.asarray(file["lead"][:], dtype=np.float64), found

    whole = read_whole_turns(path, read)
    if whole is None:
        return None
    issue, lead, found = whole
    longest = found.get("maximum_prediction_time")
    return BoatForecast(
        issue=issue,
        lead_s=lead,
        elevation_m=found["elevation"],
        std_m=found["elevation_std"],
        chance=found.get("quiet", np.full(lead.size, np.nan)),
        limits=_limits_in_words(quiet),
        level_m=quiet.elevation_m,
        duration_s=quiet.duration_s,
        confidence=quiet.confidence,
        longest_s=None if longest is None else float(longest),
    )


def _limits_in_words(quiet: QuietSettings) -> str:
    """The requested limits, as in "water height below 0.5 m"."""
    limits = []
    for name in ("elevation_m", "velocity_z_m_s", "heave_m", "roll_deg", "pitch_deg"):
        words, value = words_of(f"prediction.quiet.{name}"), getattr(quiet, name)
        if value is not None:
            limits.append(f"{words.name.replace('stays below', 'below')} {value:g} {words.unit}")
    return ", ".join(limits)


class ForecastView(NamedTuple):
    """A forecast in words and drawn; and how past ones came out."""

    words: str
    ahead: list[Image]
    past_words: str = ""
    past: Sequence[Image] = ()


def view_forecast(
    folder: Path, number: int, quiet: QuietSettings, verification: Verification | None, lead: int, dark: bool
) -> ForecastView | None:
    """The last forecast up to a turn by its number, beside what came of it and of those before where that is known.

    lead: the place of the one at which past forecasts are drawn in time.
    """
    ahead = read_ahead(folder, number, quiet)
    if ahead is None:
        return None
    if verification is None:
        return ForecastView(_forecast_in_words(ahead), draw_images([ahead_picture(ahead)], dark))
    at, verified = verification.issue_before(ahead.issue), verification.verified
    beside = () if at is None else (verified.truth[at, :, 0], verification.quiet_windows(at))
    past = [verified_picture(verified, float(verified.forecasts["lead"][lead]), at)]
    words = _errors_in_words(verification, lead)
    if verification.windows is not None:
        past.append(window_picture(verification.windows, verification.scores["confidence"]))
        words += f" {_windows_in_words(verification.scores)}"
    return ForecastView(
        _forecast_in_words(ahead), draw_images([ahead_picture(ahead, *beside)], dark), words, draw_images(past, dark)
    )


class ForecastPanel:
    """The last forecast, and how past forecasts of the run came out, step by step with the turns."""

    def __init__(self, view: SeeView) -> None:
        self.view = view
        self._words = ui.label().classes("font-bold").mark("forecast-words")
        self._ahead = Images()
        with ui.column().classes("w-full min-w-0 gap-2") as self._past:
            ui.label("How past forecasts came out").classes("text-base font-bold")
            self._status = ui.label().classes("text-sm").props("role=status").mark("verified-words")
            with ui.column().classes("w-full min-w-0 gap-2") as self._body:
                self._lead = choice("Forecast so long before", "verified-lead", view.redraw)
                self._images = Images()
            self._body.set_visibility(False)

    async def show(self, source: Source, turn: int) -> None:
        """The last forecast up to a turn, and what came of it and of those before."""
        quiet = source.scene.prediction.quiet if source.scene is not None else QuietSettings()
        folder, number = source.results.folder, source.results.turns()[turn]
        verification = self.view.page.server.verifications.find_finished(folder)
        if not await self._show(folder, number, quiet, verification) or verification is not None:
            return
        self.view.easel.ready()  # what came may take long
        verification = await self._fetch_verification(source)
        if verification is not None:
            await self._show(folder, number, quiet, verification)

    async def show_issue(self, folder: Path, number: int) -> None:
        """Show a forecast of a folder that has no maps: what came is not known."""
        await self._show(folder, number, QuietSettings(), None)
        self._past.set_visibility(False)

    async def _show(self, folder: Path, number: int, quiet: QuietSettings, verification: Verification | None) -> bool:
        """Draw the forecast; whether there is one."""
        if verification is not None and self._lead.value is None:
            leads = verification.verified.forecasts["lead"].values
            whole = [i for i, lead in enumerate(leads) if float(lead).is_integer()] or range(leads.size)
            first = min(whole, key=lambda i: abs(leads[i] - _LEAD_S))
            self._lead.set_options({i: f"{leads[i]:g} s before" for i in whole}, value=first)
        lead = int(self._lead.value or 0)
        shown = await drawing.slow(view_forecast, folder, number, quiet, verification, lead, self.view.page.dark)
        self._past.set_visibility(shown is not None)
        if shown is None:
            self._words.set_text(
                "This run made no forecast yet. Tick “forecast too” beside Run; the first comes when maps show a sea."
            )
            self._ahead.show([])
            return False
        self._words.set_text(shown.words)
        self._ahead.show(shown.ahead)
        self._body.set_visibility(verification is not None)
        if verification is not None:
            self._status.set_text(shown.past_words)
            self._images.show(shown.past)
        return True

    async def _fetch_verification(self, source: Source) -> Verification | None:
        """Verify a run's forecasts once, in a process of its own; None where the true sea is not known."""
        if source.results.growing:
            self._status.set_text("Past forecasts are held against the sea that came when the run has ended.")
        elif source.scene is None:
            self._status.set_text("Not verified: these maps have no true sea beside them. A run of a design has one.")
        else:
            self._status.set_text("Drawing the sea that came …")
            try:
                return await self.view.page.server.verifications.ask(source.results.folder)
            except (InputError, OSError) as refusal:
                self._status.set_text(f"What came is not known: {refusal}")
        return None


def _forecast_in_words(ahead: BoatForecast) -> str:
    at = ahead.highest
    wide = 1.96 * ahead.std_m[at]
    crest = (
        f"The highest crest that is expected: {ahead.elevation_m[at]:.2f} ± {wide:.2f} m in {ahead.lead_s[at]:.0f} s."
    )
    if not ahead.windows:
        return f"{crest} Quiet windows are forecast where Forecast, Quiet windows in the design names a limit."
    sure = np.nan_to_num(ahead.chance, nan=0.0)
    called = np.flatnonzero(sure >= ahead.confidence)
    best = int(called[0]) if called.size else int(np.argmax(sure))
    opens = f"opens in {ahead.lead_s[best]:.0f} s ({sure[best]:.0%} sure)"
    window = (
        f"A quiet window of {ahead.duration_s:g} s {opens}" if called.size else f"The likeliest quiet window {opens}"
    )
    return f"{window}. {crest}"


def _errors_in_words(verification: Verification, lead: int) -> str:
    """How well the forecasts of one lead did."""
    forecasts, errors = verification.verified.forecasts, errors_by_lead(verification.verified)
    judged = warm(forecasts)
    mean, std = (forecasts[name].values[judged, lead, 0].astype(np.float64) for name in ("elevation", "elevation_std"))
    error = mean - verification.verified.truth[judged, lead, 0]
    words = (
        f"Of {int(judged.sum())} forecasts, {float(forecasts['lead'][lead]):g} s ahead: error "
        f"{written(float(np.sqrt(np.mean(error**2))), 2)} m rms ({errors['found'][lead]:.2f} of the sea's standard "
        f"deviation), {np.mean(np.abs(error) < 1.96 * std):.0%} within the stated band"
    )
    correlation = errors["correlation"][lead]
    return words + (f", correlation {correlation:.2f}." if np.isfinite(correlation) else ".")


def _windows_in_words(scores: dict[str, Any]) -> str:
    """How many quiet windows were called, and how many of them were quiet."""
    words = f"Of {scores['windows']} windows {scores['quiet_share']:.0%} were quiet. "
    if scores["right"] is None:
        return f"{words}None was called: none was {scores['confidence']:.0%} sure."
    found = "" if scores["found"] is None else f"; of the quiet ones {scores['found']:.0%} were called"
    return f"{words}{scores['called']} were called at {scores['confidence']:.0%}: " + (
        f"{scores['right']:.0%} of them quiet{found}."
    )


class IssuesPanel:
    """The forecasts of a folder; what came is known only where the run's scene and maps are."""

    def __init__(self, view: SeeView) -> None:
        self._issues: list[int] = []
        self._folder, self._view = Path(), view
        with ui.row().classes("w-full items-center no-wrap gap-2"):
            ui.label("Forecast").classes("text-sm")
            self._slider = slider("Forecast", "issue", self._step)
        self._panel = ForecastPanel(view)

    async def show_folder(self, folder: Path) -> None:
        """Show the forecasts of a folder. OSError, KeyError where it holds none."""
        self._folder = folder
        self._issues = await asyncio.to_thread(read_whole_turns, folder / "prediction.nc", _read_issues)
        count_on(self._slider, len(self._issues))
        self._slider.value = len(self._issues)
        await self._show()

    def _step(self) -> None:
        self._view.draw_study(self._show())

    async def _show(self) -> None:
        if self._issues:
            at = min(int(self._slider.value or 1), len(self._issues)) - 1
            await self._panel.show_issue(self._folder, self._issues[at])


def _read_issues(file: Any) -> list[int]:
    return [int(each) for each in np.asarray(file["issue"][:])]
