"""The helm: what to steer, when it is quiet, and when the highest wave comes, to be read at arm's length; below it the
forecast and how past ones came out.

The advice is worked out from a run's own maps, of its last turns, for the vessel that its scene names; live as from a
folder.
"""

from __future__ import annotations

from typing import TYPE_CHECKING, NamedTuple

import numpy as np
import xarray as xr
from matplotlib.figure import Figure
from matplotlib.projections.polar import PolarAxes
from nicegui import ui

from ..prediction import Follower, advise, predictor_of, vessel_of
from ..report import style
from ..report.forecast_figures import Ahead
from ..report.page_elements import Picture
from ..settings import PredictionSettings
from . import drawing
from .forecast_view import ForecastPanel, read_ahead
from .widgets import Image, Images, draw_images

if TYPE_CHECKING:
    from .see_view import SeeView
    from .source import Source

_LEAST_SPEED = 4.0
_SPEEDS, _ROUND, _DRAWS = 3, 24, 30
_MARK = "text-3xl md:text-5xl font-bold leading-tight"  # readable from a metre


class Helm(NamedTuple):
    """What the helm shows: three lines of words, and the polar of advice."""

    quiet: str
    wave: str
    verdict: str
    polar: list[Image]


def view_helm(source: Source, turn: int, dark: bool) -> Helm | None:
    """After a turn by its place; None where no forecast is. In a process that draws."""
    settings = source.scene.resolved_prediction if source.scene is not None else PredictionSettings()
    ahead = read_ahead(source.results.folder, source.results.turns()[turn], settings.quiet)
    if ahead is None:
        return None
    advice = advice_of(source, turn, settings)
    if advice is None:
        return Helm(quiet_words(ahead), wave_words(ahead), "No sea is known from these maps.", [])
    verdict = str(advice.attrs["verdict"])
    verdict = verdict[:1].upper() + verdict[1:]
    if settings.vessel.shape == "none":
        verdict += " (no vessel is named: of a small raft)"
    return Helm(quiet_words(ahead), wave_words(ahead), verdict, draw_images([advice_picture(advice)], dark))


def advice_of(source: Source, turn: int, settings: PredictionSettings) -> xr.Dataset | None:
    """Advice after a turn by its place, from the maps of the last turns; None where they show no sea."""
    predictor, field = predictor_of(settings), None
    for place in range(max(0, turn - settings.turns + 1), turn + 1):
        field = predictor.turn(source.polar(place))
    if field is None:
        return None
    heading, speed = settings.heading_deg or 0.0, settings.speed_m_s or 0.0
    speeds = np.linspace(0.0, max(1.5 * speed, _LEAST_SPEED), _SPEEDS)
    around = 360.0 / _ROUND * np.arange(_ROUND)
    vessel = vessel_of(settings.vessel) or Follower()
    return advise(field, vessel, around, speeds, hold=(heading, speed), draws=_DRAWS)


def quiet_words(ahead: Ahead) -> str:
    """The countdown to the next quiet window."""
    if not ahead.windows:
        return "Quiet: no limit is named"
    called = np.flatnonzero(np.nan_to_num(ahead.chance) >= ahead.confidence)
    if not called.size:
        return f"Quiet: none in {ahead.lead_s[-1]:.0f} s"
    begin = ahead.lead_s[called[0]]
    return "Quiet: now" if begin <= 0.0 else f"Quiet: in {begin:.0f} s"


def wave_words(ahead: Ahead) -> str:
    """The highest crest to come."""
    at = ahead.highest
    height, wide = ahead.elevation_m[at], 1.96 * ahead.std_m[at]
    return f"Highest: {height:.1f} ± {wide:.1f} m in {ahead.lead_s[at]:.0f} s"


def advice_picture(advice: xr.Dataset) -> Picture:
    """Expected roll by heading and speed."""
    low, high = (float(each) for each in (advice["speed"].min(), advice["speed"].max()))
    return Picture(
        "advice",
        "Expected roll by heading and speed",
        f"Polar chart, north up: rms roll of the next {advice.attrs['horizon_s']:.0f} s by heading, at speeds of "
        f"{low:g} to {high:g} m/s outward; the best and the present course are marked.",
        "Dark is little roll, bright is much. Star: the best course; circle: the present one; outward: speed in m/s.",
        lambda: advice_polar(advice),
    )


@style.styled
def advice_polar(advice: xr.Dataset) -> Figure:
    """Rms roll (heading, speed) of the seen part, north up and clockwise."""
    figure = style.new_figure(3.2, 3.9)
    axes = figure.add_axes((0.12, 0.1, 0.64, 0.78), projection="polar")
    assert isinstance(axes, PolarAxes)
    axes.set_theta_zero_location("N")
    axes.set_theta_direction(-1)
    roll = advice["roll_rms"].sel(part="seen").transpose("speed", "heading").values
    heading, speed = advice["heading"].values, advice["speed"].values
    edges = np.radians(np.append(heading, heading[0] + 360.0) - 0.5 * 360.0 / heading.size)
    half = 0.5 * float(speed[1] - speed[0])
    rings = np.concatenate(([0.0], speed[:-1] + half, [speed[-1] + half]))
    image = axes.pcolormesh(edges, rings, roll, cmap="cividis")
    held, best = ((np.radians(advice.attrs[f"{n}heading_deg"]), advice.attrs[f"{n}speed_m_s"]) for n in ("", "best_"))
    axes.plot(*held, "o", markersize=13.0, markerfacecolor="none", markeredgecolor="white", markeredgewidth=2.0)
    axes.plot(*best, "*", markersize=16.0, color=style.VERMILION, markeredgecolor="white")
    axes.set_yticks(speed)
    axes.tick_params(labelsize=12.0)
    axes.grid(alpha=0.3)
    bar = figure.colorbar(image, cax=figure.add_axes((0.83, 0.12, 0.04, 0.74)))
    bar.set_label("Roll, rms (°)", fontsize=12.0)
    bar.ax.tick_params(labelsize=12.0)
    return figure


class HelmPanel:
    """Three lines that are read at arm's length, the polar, and the forecast below."""

    def __init__(self, view: SeeView) -> None:
        self.view = view
        with ui.column().classes("w-full min-w-0 gap-1").props("role=status"):
            self._verdict = ui.label().classes("text-2xl md:text-4xl font-bold leading-tight").mark("helm-verdict")
            self._quiet = ui.label().classes(_MARK).mark("helm-quiet")
            self._wave = ui.label().classes(_MARK).mark("helm-wave")
        with ui.column().classes("w-full min-w-0 small-figures"):  # a phone shows all of it
            self._polar = Images()
        self._forecast = ForecastPanel(view)

    async def show(self, source: Source, turn: int) -> None:
        """After a turn by its place."""
        shown = await drawing.slow(view_helm, source, turn, self.view.page.dark)
        self._verdict.set_text(shown.verdict if shown is not None else "")
        self._quiet.set_text(shown.quiet if shown is not None else "")
        self._wave.set_text(shown.wave if shown is not None else "")
        self._polar.show(shown.polar if shown is not None else [])
        await self._forecast.show(source, turn)
