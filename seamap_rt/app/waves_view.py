"""What a run's maps tell of the waves: the sea state turn by turn with its spectra, its heights beside the record of a
gauge, and the helm.

Spectra of maps and of the true sea in the same cells come through one estimator: what the retrieval's cells blur is
taken back of the maps; the true sea is the plain mean over the cells. The helm, to be read at arm's length, says what
to steer, when it is quiet, and when the highest wave comes: by the maps of the last turns, for the scene's vessel.
"""

from __future__ import annotations

import asyncio
from dataclasses import dataclass, replace
from functools import partial
from typing import TYPE_CHECKING, Any

import numpy as np
import xarray as xr
from nicegui import ui
from numpy.typing import NDArray

from ..errors import SchemaError
from ..gauges import judge_one
from ..io.reading import read_whole_turns, results_exist
from ..prediction import Follower, advise, predictor_of, vessel_of
from ..report.advice_figure import advice_picture
from ..report.forecast_figures import BoatForecast
from ..report.gauge_figures import gauge_picture
from ..report.page_elements import draw_images
from ..report.spectrum_figures import Density, map_spectra_picture, wave_height_pictures
from ..settings import PredictionSettings
from ..wavefield.sea_state import TurnSpectrum, water_of
from . import drawing
from .forecast_view import ForecastPanel, read_ahead
from .page import Image, Images, number
from .panels import Content, FiguresPanel
from .prospects import prospects
from .source import Results, Source

if TYPE_CHECKING:
    from .see_view import SeeView

Array = NDArray[np.float64]
MOST_TURNS = 6  # whose spectra are averaged: one turn's is ragged
_LEAST_SPAN = 80.0  # degrees of looks, as for the sea state: fewer do not tell directions
LEAST_TRANSFER = 0.25  # of the variance, that cells keep: shorter waves the sea state leaves out as well
_SECTOR_DEG, _LEAST_STEP_HZ = 15.0, 0.015
_LEAST_SPEED = 4.0  # of those that are advised, m/s
_SPEEDS, _ROUND, _DRAWS = 3, 24, 30
_MARK = "text-3xl md:text-5xl font-bold leading-tight"  # readable from a metre


@dataclass(frozen=True)
class MapSpectra:
    """By the maps, and by the true sea in their cells where there is one; of how many turns up to the one shown. why:
    what is missing, in words."""

    retrieved: Density | None
    true: Density | None
    turns: int
    why: str


def map_spectra(source: Source, turn: int) -> MapSpectra:
    """Spectra of the last turns up to one, by its place. OSError where a turn is not there."""
    results, turns = source.results, range(max(0, turn + 1 - MOST_TURNS), turn + 1)
    retrieved = _mean_density([source.polar(each) for each in turns]) if results.has_maps else None
    true = _mean_density([_true_polar(source, each) for each in turns], uncorrected=True) if results.has_truth else None
    why, shown = "", retrieved if results.has_maps else true
    if shown is None:
        why = "Too little of the sea is in sight for a spectrum."
    elif shown.directional is None:
        why = (
            f"The looks span less than {_LEAST_SPAN:.0f}°, or nothing tells which way the waves run: directions are "
            "left out."
        )
    return MapSpectra(retrieved, true, len(turns), why)


def _true_polar(source: Source, turn: int) -> xr.Dataset:
    """A turn with the true heights of all cells."""
    shape = source.layout.azimuth.size, source.layout.range.size
    values = {
        "height": source.results.field("truth/polar/height", turn),
        "ground_range": np.broadcast_to(source.ground_m, shape),
        "height_std": np.full(shape, 1e-3),
        "quality": np.zeros(shape, np.int16),
    }
    polar = source.polar(turn).drop_vars("visible_share", errors="ignore")
    return polar.assign({name: (("azimuth", "range"), each) for name, each in values.items()})


def _mean_density(polars: list[xr.Dataset], *, uncorrected: bool = False) -> Density | None:
    """The mean spectrum of turns that show a sea. uncorrected: without taking back what a retrieval's cells blur."""
    water = water_of(polars[0].attrs)
    found = [each for each in (TurnSpectrum.of(polar, water) for polar in polars) if each is not None]
    if not found:
        return None
    if uncorrected:
        found = [replace(each, spectrum=each.spectrum.corrected(1.0 / each.transfer, 0.0)) for each in found]
    first = found[0].spectrum
    frequency = first.ring_frequency
    densities = [_density_on_rings(each, frequency) for each in found]
    step = max(_LEAST_STEP_HZ, float(np.median(np.diff(frequency))))
    edges = np.arange(0.0, frequency[-1] + step, step)
    directed = [each for each in found if each.direction_known and each.polar_map.span > _LEAST_SPAN]
    directional = np.mean([_directional_density(each, edges) for each in directed], axis=0) if directed else None
    return Density(
        frequency,
        np.mean(densities, axis=0),
        0.5 * (edges[1:] + edges[:-1]),
        np.arange(0.5 * _SECTOR_DEG, 360.0, _SECTOR_DEG),
        directional,
    )


def _density_on_rings(turn: TurnSpectrum, frequency: Array) -> Array:
    """Density [m²/Hz] at the frequencies of the first turn's rings, which hardly differ from turn to turn; NaN of waves
    too short for the cells."""
    own = turn.spectrum.ring_frequency
    density = np.interp(
        frequency, own, turn.spectrum.ring_power / (_modes_per_wave(turn) * np.gradient(own)), right=0.0
    )
    return np.where(np.interp(frequency, own, turn.transfer) > LEAST_TRANSFER, density, np.nan)


def _directional_density(turn: TurnSpectrum, edges: Array) -> Array:
    """Density [m²/Hz/°] (f, d): the modes' power, gathered; what lies below the floor is 0."""
    spectrum = turn.spectrum
    frequency = spectrum.water.frequency(spectrum.wavenumber) / (2.0 * np.pi)
    comes_from = (np.degrees(spectrum.toward) + 180.0) % 360.0
    sectors = np.arange(0.0, 360.0 + _SECTOR_DEG, _SECTOR_DEG)
    power = np.histogram2d(frequency, comes_from, (edges, sectors), weights=spectrum.power)[0]
    return np.maximum(power, 0.0) / (_modes_per_wave(turn) * np.diff(edges)[:, None] * _SECTOR_DEG)


def _modes_per_wave(turn: TurnSpectrum) -> float:
    """How many modes of the lattice, which is finer than a sea of area A asks, hold one wave: (2π/Δk)²/A."""
    polar_map, bins = turn.polar_map, turn.bins
    inside = polar_map.known & bins.covers(bins.glimpsed, polar_map.distance)
    step = float(np.median(np.diff(turn.spectrum.ring_wavenumber)))  # rings are one step wide
    return (2.0 * np.pi / step) ** 2 / float(polar_map.cells(inside).weight.sum())


class StatePanel:
    """The sea state by the maps, and their spectrum."""

    def __init__(self, view: SeeView) -> None:
        self.view = view
        self._words = ui.label().mark("sea-state")
        self._images = Images()
        ui.label("Wave spectrum").classes("text-base font-bold")
        self._status = ui.label().classes("text-sm").props("role=status").mark("spectrum-words")
        self._spectra = Images()

    async def show(self, source: Source, turn: int) -> None:
        metrics = await asyncio.to_thread(source.results.metrics)
        known = bool((metrics.get("sea_state") or {}).get("significant_wave_height"))
        self._words.set_text(str(metrics.get("sea_state_in_words", "")) if known else _missing_state(source))
        self._words.classes(replace="font-bold" if known else "text-sm")
        try:
            heights, words, spectra = await drawing.slow(state_of, source, turn, self.view.page.dark)
        except (SchemaError, KeyError, ValueError) as error:  # maps of another program
            heights, words, spectra = [], f"No spectrum: {error}", []
        self._images.show(heights)
        self._status.set_text(words)
        self._status.set_visibility(bool(words))
        self._spectra.show(spectra)


def state_of(source: Source, turn: int, dark: bool) -> tuple[list[Image], str, list[Image]]:
    """The wave height turn by turn; of the spectra of the turns up to one what is missing, and their figure."""
    heights, found = draw_images(wave_height_pictures(source.results.metrics()), dark), map_spectra(source, turn)
    if found.retrieved is None and found.true is None:
        return heights, found.why, []
    of_scene = None
    if source.scene is not None:
        law = prospects(source.scene).spectrum
        if law.density.any():
            of_scene = law.frequency, law.density.sum(axis=1) * 360.0 / law.direction.size
    turns = f"the last {found.turns} turns" if found.turns > 1 else "this turn"
    words = f"Of {turns}, in the frame of the water."
    return heights, found.why, draw_images([map_spectra_picture(found.retrieved, found.true, of_scene, words)], dark)


def _missing_state(source: Source) -> str:
    if not source.results.has_maps:
        return "Nothing was retrieved of these echoes yet: press Retrieve beside them in Runs."
    if source.results.growing or source.scene is not None:
        return "The wave height, turn by turn, is worked out when a run has ended."
    return "The wave height of these echoes stands in their own page: Download, retrieval.html."


_TURN = ("height", "height_std", "seen_time", "quality", "seen_true_height", "seen_cell_height")
_FIGURES = (  # of `judge_one`: words, unit, digits
    ("correlation", "Correlation with the wire", "", 3),
    ("rms_error_m", "Error, rms", "m", 3),
    ("stated_error_m", "Error that is stated", "m", 3),
    ("bias_m", "Bias", "m", 3),
    ("averaging_rms_m", "Of that by averaging over cells", "m", 3),
    ("hs_wire_m", "Wave height by the wire", "m", 2),
    ("hs_retrieved_m", "Wave height by the map", "m", 2),
    ("answered", "Turns with a height", "%", 0),
)


def has_gauges(results: Results) -> bool:
    """Whether a run writes, or wrote, what gauges read."""
    return results_exist(results.folder / "gauges.nc")


def read_gauges(results: Results) -> xr.Dataset:
    """All whole turns (schema `gauges`), also while they grow. OSError where there are none yet."""
    return read_whole_turns(results.folder / "gauges.nc", _read)


def _read(file: Any) -> xr.Dataset:
    def values(name: str) -> np.ndarray[Any, Any]:
        return np.asarray(file[name][:])

    names = [each.decode("utf-8", "replace") if isinstance(each, bytes) else str(each) for each in values("gauge")]
    variables: dict[str, Any] = {name: (("gauge", "turn"), values(name)) for name in _TURN if name in file}
    variables |= {name: (("gauge",), values(name)) for name in ("east", "north")}
    if "true_height" in file:
        variables["true_height"] = ("gauge", "sample"), values("true_height")
    coordinates = {"gauge": names, "turn": values("turn"), "time": (("sample",), values("time"))}
    return xr.Dataset(variables, coordinates)


def view_gauge(source: Source, turn: int, chosen: str | None, dark: bool) -> Content:
    """What there is up to a turn of the gauge that is chosen, else of the first."""
    if not has_gauges(source.results):
        return Content(
            "This run has no wave gauge. Press “Add wave gauge” at the end of the form in Design, say where it stands, "
            "and run the design: its record of the surface is held against the map there."
        )
    read = read_gauges(source.results)
    names = [str(each) for each in read["gauge"].values]
    name = chosen if chosen in names else names[0]
    gauge = read.sel(gauge=name)
    east, north = (float(gauge[each]) for each in ("east", "north"))
    place = f"At {np.hypot(east, north):.0f} m, {np.degrees(np.arctan2(east, north)) % 360.0:.0f}°."
    picture = gauge_picture(names.index(name), name, gauge, source.results.turns()[turn])
    judged, figures = judge_one(gauge), []
    for key, words, unit, digits in _FIGURES:
        value = float(judged[key]) * (100.0 if unit == "%" else 1.0)
        figures.append((words, f"{number(value, digits)} {unit}".strip()))
    return Content(
        place, draw_images([replace(picture, name="gauge")], dark), figures, {each: each for each in names}, name
    )


GaugePanel = partial(FiguresPanel, draw=view_gauge, label="Wave gauge")


def view_helm(source: Source, turn: int, dark: bool) -> tuple[str, str, str, list[Image]]:
    """After a turn by its place: what to steer, when it is quiet, the highest crest, and the polar of advice; all empty
    where no forecast is."""
    settings = source.scene.resolved_prediction if source.scene is not None else PredictionSettings()
    ahead = read_ahead(source.results.folder, source.results.turns()[turn], settings.quiet)
    if ahead is None:
        return "", "", "", []
    advice = advice_of(source, turn, settings)
    if advice is None:
        return "No sea is known from these maps.", quiet_words(ahead), wave_words(ahead), []
    verdict = str(advice.attrs["verdict"])
    verdict = verdict[:1].upper() + verdict[1:]
    if settings.vessel.shape == "none":
        verdict += " (no vessel is named: of a small raft)"
    return verdict, quiet_words(ahead), wave_words(ahead), draw_images([advice_picture(advice)], dark)


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


def quiet_words(ahead: BoatForecast) -> str:
    """The countdown to the next quiet window."""
    if not ahead.windows:
        return "Quiet: no limit is named"
    called = np.flatnonzero(np.nan_to_num(ahead.chance) >= ahead.confidence)
    if not called.size:
        return f"Quiet: none in {ahead.lead_s[-1]:.0f} s"
    begin = ahead.lead_s[called[0]]
    return "Quiet: now" if begin <= 0.0 else f"Quiet: in {begin:.0f} s"


def wave_words(ahead: BoatForecast) -> str:
    """The highest crest to come."""
    at = ahead.highest
    height, wide = ahead.elevation_m[at], 1.96 * ahead.std_m[at]
    return f"Highest: {height:.1f} ± {wide:.1f} m in {ahead.lead_s[at]:.0f} s"


class HelmPanel:
    """Three lines that are read at arm's length, the polar, and the forecast below."""

    def __init__(self, view: SeeView) -> None:
        self.view = view
        with ui.column().classes("w-full min-w-0 gap-1").props("role=status"):
            self._lines = [
                ui.label().classes("text-2xl md:text-4xl font-bold leading-tight").mark("helm-verdict"),
                ui.label().classes(_MARK).mark("helm-quiet"),
                ui.label().classes(_MARK).mark("helm-wave"),
            ]
        with ui.column().classes("w-full min-w-0 small-figures"):  # a phone shows all of it
            self._polar = Images()
        self._forecast = ForecastPanel(view)

    async def show(self, source: Source, turn: int) -> None:
        """Show the advice after a turn, by its place."""
        *lines, polar = await drawing.slow(view_helm, source, turn, self.view.page.dark)
        for label, words in zip(self._lines, lines, strict=True):
            label.set_text(words)
        self._polar.show(polar)
        await self._forecast.show(source, turn)
