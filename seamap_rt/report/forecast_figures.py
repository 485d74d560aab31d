"""Forecasts beside the sea that came: the last field as maps, errors by lead, quiet windows, and an animation."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
import xarray as xr
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from numpy.typing import NDArray
from PIL import Image

from ..conventions import turn_name
from ..forecast_errors import VerifiedForecasts, prediction_time, warm
from ..scene import Scene
from ..window_errors import Class, Windows, area, hits_and_alarms, reliability
from . import reduce, style
from .maps import draw_ground
from .page_elements import Picture, Table, digits, percent
from .style import gif

Array = NDArray[np.float64]

_LEAD_S = 10.0  # of the forecasts that are drawn in time
_BAND = 1.96
_BACK_S = 15.0  # that the animation looks back
_MOST_FRAMES, _FRAME_MS, _PIXELS, _COLOURS = 60, 400, 760, 64
_HALF_KNOWN = np.sqrt(0.5)  # of σ


def forecast_pictures(scene: Scene, maps: xr.DataTree, verified: VerifiedForecasts | None) -> list[Picture]:
    """The field's maps, the forecasts in lead and time, and how they ran ahead; none of a run that did not forecast."""
    if verified is None:
        return []
    made = [
        Picture(
            "wave_field",
            "The wave field through the shadows",
            "Four maps, north up: the height that the last turn alone gave, the height reconstructed from the last "
            "turns, the true height at the same moment, and the stated error of the reconstruction.",
            "(a) One turn's map, each cell when the beam passed it; grey is where it gave no height. (b) Free waves "
            f"fitted to the last {int(verified.forecasts['turns'].values[-1])} turns, at the end of the last one, "
            "shadows and the water around the mast included. (c) The sea then. (d) The stated standard error over the "
            "sea's standard deviation; white: where half the sea's variance is known.",
            lambda: wave_field(scene, maps, verified.field),
        ),
        Picture(
            "forecast_errors",
            "Forecasts against the sea that came",
            *_error_words(verified, _LEAD_S),
            lambda: forecast_errors(verified),
        ),
    ]
    if verified.forecasts.sizes["issue"] > 1:
        made.append(
            Picture(
                "forecast_ahead",
                "Forecasts run ahead of the sea",
                "Animation of the sea at the boat: what came, and the forecast of each turn with its band.",
                "Height at the boat about the moment of each forecast. Black: the sea that came, grey: that comes. "
                "Orange: the forecast ± 1.96 stated standard errors.",
                lambda: forecast_ahead(verified),
            )
        )
    return made


def _error_words(verified: VerifiedForecasts, lead_s: float) -> tuple[str, str]:
    """What stands for `forecast_errors`, and under it."""
    return (
        "Error of forecasts at the boat against their lead beside the stated error, persistence and climatology; their "
        f"correlation with the sea; and the sea at the boat in time with what was forecast of it {lead_s:g} s ahead.",
        f"(a) Rms over the sea's standard deviation σ, of {int(warm(verified.forecasts).sum())} forecasts. "
        "Persistence: the sea stays as it is now. Climatology: the mean level. Upright: the maximum prediction "
        "time, up to which the stated error stays below half of σ. (b) Of the same forecasts with the sea that came. "
        f"(c) The sea that came, and what was forecast {lead_s:g} s before, ± 1.96 stated standard errors.",
    )


def verified_picture(verified: VerifiedForecasts, lead_s: float, issue: int | None) -> Picture:
    """How past forecasts came out. lead_s: of those that are drawn in time; issue: the place of the marked one."""
    words = _error_words(verified, lead_s)
    title = "What was forecast, and what came"
    return Picture("forecast_errors", title, *words, lambda: forecast_errors(verified, lead_s, issue))


def forecast_table(rows: list[dict[str, object]]) -> list[Table]:
    """What metrics.json says of forecasts; none if the run made none."""
    if not rows:
        return []
    made = []
    for row in rows:
        first, last = reduce.series(row["lead_s"])
        numbers = [digits(row[name], 3) for name in ("correlation", "error_share", "stated_share", "persistence_share")]
        lead = "now" if last == 0.0 else f"{first:g}–{last:g} s"
        made.append([str(row["place"]), lead, *numbers, percent(row["within"])])
    head = ("Place", "Lead", "Correlation", "Error (σ)", "Stated (σ)", "Persistence (σ)", "Within 1.96 stated")
    note = (
        f"Of {rows[0]['forecasts']} forecasts that rest on five turns or more, or of all where none does; σ is the "
        "standard deviation of the sea that came."
    )
    return [Table("Forecasts", head, made, note)]


@style.styled
def wave_field(scene: Scene, maps: xr.DataTree, field: xr.Dataset) -> Figure:
    """One turn's map, the field of the last turns, the truth, and the stated error."""
    x, y = field["x"].values, field["y"].values
    alone = np.asarray(maps["ground"].dataset["height"].isel(turn=-1).values, np.float64)
    sigma = float(np.std(field["true"].values)) or 1.0
    near = np.hypot(*np.meshgrid(x, y)) <= scene.far_ground_range
    shown = [np.where(near | np.isfinite(alone), each, np.nan) for each in (field["reconstructed"], field["true"])]
    stated = np.where(near, field["stated"].values / sigma, np.nan)
    limit = 2.5 * sigma
    heights = "Height above mean sea level (m)", style.HEIGHT_COLOURS, -limit, limit, "both"
    panels = (
        ("(a) One turn's map", alone, *heights),
        ("(b) Reconstructed", shown[0], *heights),
        ("(c) True", shown[1], *heights),
        ("(d) Stated error", stated, "Stated error over σ", style.SPREAD_COLOURS, 0.0, 1.0, "max"),
    )
    panel = 2.85
    figure = style.new_figure(2.0 * (panel + 0.35) + 1.0)
    for number, (title, values, label, colours, low, high, extend) in enumerate(panels):
        row, column = divmod(number, 2)
        left = 0.55 + column * (panel + 0.52)
        axes = style.place(figure, left, 0.3 + row * (panel + 0.42), panel, panel)
        image = draw_ground(axes, (x, y, values), colours, low, high)
        axes.set_facecolor(style.BLANK)
        axes.set_title(title)
        style.mark_antenna(axes, *_boat(scene, maps))
        style.few_ticks(axes, 5)
        axes.tick_params(labelleft=column == 0, labelbottom=row == 1)
        axes.set_ylabel("" if column else "North (m)", labelpad=1.0)
        if row == 1:
            axes.set_xlabel("East (m)", labelpad=1.0)
            style.colour_bar(figure, image, left + 0.2, 1.14 + 2.0 * panel, panel - 0.4, label, extend)
    if np.nanmin(stated) < _HALF_KNOWN < np.nanmax(stated):
        figure.axes[-2].contour(x, y, stated, levels=[_HALF_KNOWN], colors="white", linewidths=0.8)
    return figure


def _boat(scene: Scene, maps: xr.DataTree) -> tuple[float, float]:
    polar = maps["polar"].dataset
    if not scene.platform.speed_m_s or "antenna_x" not in polar:
        return 0.0, 0.0
    x, y = (float(np.asarray(polar[name].isel(turn=-1).values).ravel()[-1]) for name in ("antenna_x", "antenna_y"))
    return x, y


def errors_by_lead(verified: VerifiedForecasts) -> dict[str, Array]:
    """(lead,) of the forecasts at the first place that are judged: rms of the error (`found`), of what was stated
    (`stated`), of `persistence` and of `climatology`, over the standard deviation of the sea that came; and the
    `correlation` with it. NaN where not defined."""
    judged = np.flatnonzero(warm(verified.forecasts))
    truth = verified.truth[judged, :, 0]
    mean, std = _elevation(verified.forecasts.isel(issue=judged, place=0))
    sigma = float(np.std(truth)) or np.nan
    errors = {"found": mean - truth, "stated": std, "persistence": mean[:, :1] - truth, "climatology": truth}
    relative = {name: np.sqrt(np.mean(each**2, axis=0)) / sigma for name, each in errors.items()}
    return relative | {"correlation": _correlation(mean, truth)}


def _elevation(forecasts: xr.Dataset) -> tuple[Array, Array]:
    """What is expected and its standard error, m."""
    mean, std = (forecasts[name].values.astype(np.float64) for name in ("elevation", "elevation_std"))
    return mean, std


def _correlation(a: Array, b: Array) -> Array:
    """Correlation of columns over their rows; NaN for fewer than three rows, or of what never changes."""
    if a.shape[0] < 3:
        return np.full(a.shape[1], np.nan)
    a, b = a - a.mean(axis=0), b - b.mean(axis=0)
    spread = np.sqrt(np.sum(a**2, axis=0) * np.sum(b**2, axis=0))
    return np.divide(np.sum(a * b, axis=0), spread, out=np.full(a.shape[1], np.nan), where=spread > 0.0)


@style.styled
def forecast_errors(verified: VerifiedForecasts, lead_s: float = _LEAD_S, issue: int | None = None) -> Figure:
    """Errors and correlation by lead, and the sea at the first place in time with its forecasts of a lead before.

    issue: the place of a forecast that is marked.
    """
    figure = style.new_figure(4.95)
    left, right = (style.place(figure, start, 0.3, 2.85, 1.7) for start in (0.62, 4.23))
    relative, lead = errors_by_lead(verified), verified.forecasts["lead"].values
    for name, colour, line in (
        ("found", style.BLUE, "-"), ("stated", style.ORANGE, "-"), ("persistence", style.GREY, "--"),
        ("climatology", style.GREY, ":"),
    ):  # fmt: skip
        left.plot(lead, relative[name], color=colour, linestyle=line, label=name)
    _mark_end(left, prediction_time(verified.forecasts.isel(issue=np.flatnonzero(warm(verified.forecasts)))))
    style.graph(left, "Lead (s)", "Rms error over σ", "(a) Error by lead, at the boat")
    left.set_ylim(bottom=0.0)
    left.legend(loc="upper center", bbox_to_anchor=(0.5, -0.19), ncols=4, columnspacing=1.0, handlelength=1.6)
    right.plot(lead, relative["correlation"], color=style.BLUE)
    style.graph(right, "Lead (s)", "Correlation", "(b) Correlation with the sea that came")
    right.set_ylim(min(0.0, float(np.nanmin(relative["correlation"], initial=0.0))) - 0.02, 1.02)
    _draw_in_time(style.place(figure, 0.62, 2.95, style.WIDTH - 0.74, 1.6), verified, lead_s, issue)
    return figure


def _mark_end(axes: Axes, longest_s: float | None) -> None:
    """The maximum prediction time, upright."""
    if longest_s is not None:
        style.upright(axes, longest_s, f"{longest_s:.0f} s ", style.ORANGE, "-.", ha="right")


def _draw_in_time(axes: Axes, verified: VerifiedForecasts, lead_s: float, issue: int | None) -> None:
    forecasts = verified.forecasts.isel(place=0)
    lead = forecasts["lead"].values
    number = int(np.argmin(np.abs(lead - lead_s)))
    time, truth = verified_sea(verified)
    moment = forecasts["issued"].values + lead[number]
    mean, std = _elevation(forecasts.isel(lead=number))
    axes.plot(time, truth, color=style.BLACK, linewidth=0.9, label="the sea that came")
    _draw_forecast(axes, moment, mean, std, f"forecast {lead[number]:g} s before", "o-")
    if issue is not None:
        name = f"made after {turn_name(forecasts['issue'].values[issue])}"
        axes.plot(moment[issue], mean[issue], "D", color=style.VERMILION, markersize=6.0, label=name)
    style.graph(axes, "Time (s)", "Height at the boat (m)", "(c) In time")
    axes.set_xlim(float(time[0]), float(moment[-1]) + 1.0)
    axes.margins(y=0.25)
    axes.legend(loc="upper right", ncols=3)


def _draw_forecast(axes: Axes, time: Array, mean: Array, std: Array, label: str, line: str = "-") -> None:
    """A forecast with its band."""
    style.band(axes, time, mean - _BAND * std, mean + _BAND * std, style.ORANGE, 0.3)
    axes.plot(time, mean, line, color=style.ORANGE, markersize=2.5, label=label)


@dataclass(frozen=True)
class BoatForecast:
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
    longest_s: float | None = None

    @property
    def highest(self) -> int:
        """Index of the lead at which the highest crest is expected."""
        return int(np.argmax(self.elevation_m))

    @property
    def windows(self) -> bool:
        """Whether quiet windows are forecast."""
        return bool(np.isfinite(self.chance).any())


def ahead_picture(ahead: BoatForecast, observed: Array | None = None, quiet: Array | None = None) -> Picture:
    """One forecast; see `next_seconds`."""
    alt = f"Height at the boat in the {ahead.lead_s[-1]:.0f} s after {turn_name(ahead.issue)}, as forecast"
    caption = (
        "Orange: the forecast ± 1.96 stated standard errors; star: the highest crest that is expected. Upright: the "
        "maximum prediction time."
    )
    if ahead.windows:
        what = "and which came" if quiet is not None else "by when they begin"
        alt += f"; quiet windows after {turn_name(ahead.issue)}, {what}"
        caption += " Green dots: the limit of a quiet window. "
        caption += f"(b) A bar over the dotted line is a window that is called: {ahead.confidence:.0%} sure."
    title = f"The next {ahead.lead_s[-1]:.0f} s at the boat, as known after {turn_name(ahead.issue)}"
    return Picture("ahead", title, f"{alt}.", caption, lambda: next_seconds(ahead, observed, quiet))


@style.styled
def next_seconds(ahead: BoatForecast, observed: Array | None = None, quiet: Array | None = None) -> Figure:
    """One forecast at the boat, and the chances of quiet windows by when they begin.

    observed: (lead,) m, the sea then. quiet: (lead,) whether windows were quiet, NaN where it is unknown.
    """
    wide = style.WIDTH - 0.74
    figure = style.new_figure(4.05 if ahead.windows else 2.45)
    axes = style.place(figure, 0.62, 0.28, wide, 1.75)
    lead, at = ahead.lead_s, ahead.highest
    if observed is not None:
        axes.plot(lead, observed, color=style.BLACK, linewidth=0.9, label="the sea that came")
    _draw_forecast(axes, lead, ahead.elevation_m, ahead.std_m, "forecast")
    axes.plot(lead[at], ahead.elevation_m[at], "*", color=style.VERMILION, markersize=9.0, label="highest crest")
    for level in () if ahead.level_m is None else (-ahead.level_m, ahead.level_m):
        axes.axhline(level, color=style.GREEN, linestyle=":", linewidth=0.9)
    _mark_end(axes, ahead.longest_s)
    style.graph(axes, "Time from now (s)", "Height at the boat (m)", "(a) Height at the boat" if ahead.windows else "")
    axes.margins(x=0.0, y=0.25)
    axes.legend(loc="upper right", ncols=3)
    if not ahead.windows:
        return figure
    below = style.place(figure, 0.62, 2.62, wide, 1.0, sharex=axes)
    of = f"{ahead.duration_s:g} s with {ahead.limits}" if ahead.limits else "a quiet window"
    style.graph(below, "Begins in (s)", "Stated chance (%)", f"(b) Chance of {of}")
    called, quiet = (
        np.nan_to_num(ahead.chance) >= ahead.confidence,
        np.full(lead.size, np.nan) if quiet is None else quiet,
    )
    known, was = np.isfinite(quiet), np.nan_to_num(quiet) > 0.5
    bar = 0.8 * float(np.min(np.diff(lead))) if lead.size > 1 else 0.8
    for members, face, edge, label in (
        (~known & called, style.GREEN, style.GREEN, "called"), (~known & ~called, style.GREY, style.GREY, "not called"),
        (known & was, style.GREEN, style.GREEN, "it was quiet"), (known & ~was, "white", style.VERMILION, "it was not"),
    ):  # fmt: skip
        if members.any() and np.isfinite(ahead.chance[members]).any():
            look = {"facecolor": face, "edgecolor": edge, "linewidth": 1.0, "label": label}
            below.bar(lead[members], 100.0 * ahead.chance[members], bar, **look)
    below.axhline(100.0 * ahead.confidence, color=style.BLACK, linestyle=":", linewidth=0.9)
    below.set_ylim(0.0, 130.0)
    below.set_yticks((0, 50, 100))
    below.legend(loc="upper right", ncols=4)
    return figure


def verified_sea(verified: VerifiedForecasts) -> tuple[Array, Array]:
    """True heights at the first place by time, of all forecasts together; of a moving boat as the last one that looked
    at a moment has it."""
    forecasts = verified.forecasts
    time = np.round(forecasts["issued"].values[:, None] + forecasts["lead"].values, 3)
    found, first = np.unique(time.ravel(), return_index=True)
    return found.astype(np.float64), verified.truth[:, :, 0].ravel()[first]


@style.styled
def forecast_ahead(verified: VerifiedForecasts) -> bytes:
    """A GIF: about the moment of each forecast, the sea at the first place and what is forecast of it."""
    return gif(frames := list(_frames(verified)), [_FRAME_MS] * len(frames), _COLOURS)


def _frames(verified: VerifiedForecasts) -> Iterator[Image.Image]:
    forecasts = verified.forecasts.isel(place=0)
    lead, issued = forecasts["lead"].values, forecasts["issued"].values
    time, truth = verified_sea(verified)
    limit = 1.25 * float(np.max(np.abs(truth)))
    figure = style.new_figure(2.2, dpi=_PIXELS / style.WIDTH)
    for number in range(0, issued.size, -(-issued.size // _MOST_FRAMES)):
        figure.clear()
        axes = style.place(figure, 0.55, 0.28, style.WIDTH - 0.7, 1.45)
        now = issued[number]
        past, coming = time <= now, (time >= now) & (time <= now + lead[-1])
        axes.plot(time[past] - now, truth[past], color=style.BLACK)
        axes.plot(time[coming] - now, truth[coming], color=style.GREY, linewidth=0.9)
        _draw_forecast(axes, lead, *_elevation(forecasts.isel(issue=number)), "forecast")
        axes.axvline(0.0, color=style.GREY, linewidth=0.6)
        style.graph(axes, "Time from now (s)", "Height at the boat (m)", turn_name(forecasts["issue"][number]))
        axes.set_xlim(-_BACK_S, float(lead[-1]))
        axes.set_ylim(-limit, limit)
        figure.canvas.draw()
        yield style.snapshot(figure)


_SCORE_COLOURS = {"persistence": style.GREY, "group law": style.ORANGE}


def window_pictures(windows: Windows | None, confidence: float) -> list[Picture]:
    """Pictures of a run's windows; none for a run that had none, or of one kind alone."""
    if windows is None or windows.quiet.all() or not windows.quiet.any():
        return []
    return [window_picture(windows, confidence)]


def window_picture(windows: Windows, confidence: float) -> Picture:
    """Hits, false alarms and what probabilities came to."""
    return Picture(
        "quiet_windows",
        "Quiet windows against the sea that came",
        "Hits against false alarms of forecast quiet windows as the threshold varies, beside persistence; and the "
        "share of windows that were quiet against their stated probability.",
        f"(a) Each of {windows.quiet.size} windows was forecast with a probability; the point is what is called "
        f"from {confidence:.0%} on. Persistence: windows are the likelier quiet the lower the water stayed just "
        "before. (b) By classes of stated probability, with the number of windows. Windows overlap, so that one "
        "run tells little of the middle classes.",
        lambda: quiet_windows([windows], confidence),
    )


def window_table(scores: Mapping[str, Any] | None) -> list[Table]:
    """What metrics.json says of quiet windows; none if the run had none."""
    if not scores:
        return []
    rows = [
        ["Windows", str(scores["windows"])],
        ["Quiet", percent(scores["quiet_share"])],
        [f"Called at {scores['confidence']:.0%}", str(scores["called"])],
        ["Called ones that were quiet", percent(scores["right"])],
        ["Quiet ones that were called", percent(scores["found"])],
        ["Area under hits against false alarms", digits(scores["area"], 3)],
        ["… of persistence", digits(scores["persistence_area"], 3)],
        ["Mean square error of probabilities", digits(scores["brier"], 3)],
        ["… of climatology", digits(scores["climatology_brier"], 3)],
    ]
    return [Table("Quiet windows", ("Figure", "Value"), rows, "Of all windows that end within a forecast's leads.")]


@style.styled
def quiet_windows(runs: Sequence[Windows], confidence: float) -> Figure:
    """The figure of quiet windows of one run or several, whose bands are then drawn too."""
    chance, quiet = (np.concatenate([getattr(run, name) for run in runs]) for name in ("chance", "quiet"))
    scores = {"forecast": chance}
    scores |= {name: np.concatenate([run.others[name] for run in runs]) for name in runs[0].others}
    figure = style.new_figure(2.85)
    curves, stated = (style.place(figure, left, 0.3, 2.7, 2.0) for left in (0.6, 4.2))
    if quiet.all() or not quiet.any():
        style.note(curves, "all windows were quiet" if quiet.any() else "no window was quiet")
    else:
        for name, score in scores.items():
            hits, alarms = hits_and_alarms(score, quiet)
            label = f"{name}, area {area(score, quiet):.3f}"
            curves.plot(alarms, hits, color=_SCORE_COLOURS.get(name, style.BLUE), label=label)
        called = chance >= confidence
        point = float(called[~quiet].mean()), float(called[quiet].mean())
        curves.plot(*point, "o", color=style.BLUE, label=f"called at {confidence:.0%}")
        curves.legend(loc="lower right", fontsize="small")
    style.graph(curves, "Share of other windows called", "Share of quiet windows called", "(a) Hits and false alarms")
    _draw_probabilities(stated, reliability(runs), len(runs) > 1)
    for axes in (curves, stated):
        axes.set_xlim(-0.02, 1.02)
        axes.set_ylim(-0.02, 1.02)
    return figure


def _draw_probabilities(axes: Axes, classes: Sequence[Class], bands: bool) -> None:
    axes.plot([0.0, 1.0], [0.0, 1.0], "--", color=style.GREY)
    stated, found = ([getattr(each, name) for each in classes] for name in ("stated", "found"))
    band = [[each.found - each.low for each in classes], [each.high - each.found for each in classes]]
    axes.errorbar(stated, found, band if bands else None, fmt="o-", color=style.BLUE, capsize=3)
    for each in classes:
        place = (each.stated, each.found)
        axes.annotate(str(each.count), place, textcoords="offset points", xytext=(5, -9), fontsize="small")
    style.graph(axes, "Stated probability", "Share that were quiet", "(b) What probabilities came to")
