"""Wave fields from maps of several turns, from observations of any kind, or from both; and from turn to turn."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from concurrent.futures import Future
from dataclasses import dataclass, replace

import numpy as np
import xarray as xr
from numpy.typing import ArrayLike

from ..compute.machine import pool
from ..dataset import attributed, group_of
from ..errors import InputError, must_be
from ..physics.dispersion import Water
from ..settings import PredictionSettings, VesselSettings
from ..wavefield.sea_state import TurnSpectrum, systems_of, water_of
from ..wavefield.wave_systems import WaveSystems
from .capytaine import read_capytaine
from .ensemble import Ensemble
from .field import WaveField
from .fit import Fit
from .forecast import forecast, quiet_windows
from .innovations import Drift, Innovations
from .knowledge import ModelError, scatter
from .observations import Observations, turn_observations
from .spectrum import Spectrum, spectrum_of_turns
from .vessel import Box, Disc, Follower, Vessel

_SHARP, _SURE = 1.0, 0.5  # of a real sea, and how far seas may be from it
_OTHERS = -1  # in place of a turn's number, of observations by other instruments
_FORGOTTEN = 0.9  # of the evidence, from turn to turn


@dataclass
class _Turn:
    """What is kept of a turn."""

    number: int
    seen: Observations
    spectrum: TurnSpectrum | None


class Predictor:
    """Keeps what was seen in the last turns, and the waves that fit it.

    turns: how many; lead_s: how far ahead [s] forecasts are wanted. sharpness: see WaveField; amplitude_dispersion: see
    Spectrum; None: as the maps show.
    """

    def __init__(
        self,
        turns: int = 10,
        lead_s: float = 30.0,
        sharpness: float | None = None,
        amplitude_dispersion: float | None = None,
    ) -> None:
        self._most, self._lead = turns, lead_s
        self._turns: list[_Turn] = []
        self._fit: Fit | None = None
        self._ensemble: Ensemble | None = None
        self._sharpness, self._issued = sharpness, 0.0
        self._drift = Drift(amplitude_dispersion)
        self._count, self._systems = 0, None
        self._innovations = Innovations()
        self._evidence = _SURE**-2 * np.array([_SHARP, 1.0])

    def turn(self, polar: xr.Dataset) -> WaveField | None:
        """The field after one more turn's polar map; None while no turn of the last ones shows a sea."""
        water = self._drift.water(water_of(polar.attrs))
        number = int(polar["turn"])
        shown = TurnSpectrum.of(polar, water)
        self._turns = [turn for turn in self._turns if number - self._most < turn.number < number]
        known = [turn.spectrum for turn in self._turns if turn.spectrum] + ([shown] if shown else [])
        spectrum = spectrum_of_turns(known, water, self._find_systems(known, water))
        if spectrum is None:
            self._fit, self._turns = None, []
            return None
        spectrum = replace(spectrum, amplitude_dispersion=self._drift.amplitude_dispersion)
        seen = turn_observations(polar, np.sqrt(spectrum.variance))
        self._turns.append(_Turn(number, seen, shown))
        if not any(len(turn.seen) for turn in self._turns):
            self._fit = None
            return None
        centre = _centre(polar)
        weighed: Future[None] | None = None
        with pool() as workers:
            if self._fit is not None and self._fit.suits(spectrum, centre):
                self._fit.keep({t.number for t in self._turns})
                self._fit.add([seen], [number])
                if self._drift.learn(self._fit, number):
                    water, share = self._drift.water(water_of(polar.attrs)), self._drift.amplitude_dispersion
                    spectrum = replace(spectrum, water=water, amplitude_dispersion=share)
                    self._fit, self._innovations = None, Innovations()  # older ones are of waves that ran wrong
            if self._fit is None or self._ensemble is None or not self._fit.suits(spectrum, centre):
                seconds = self._lead + self._most * float(np.ptp(polar["time"].values))
                self._fit = Fit.of(spectrum, [t.seen for t in self._turns], seconds, centre)
                self._fit.add([t.seen for t in self._turns], [t.number for t in self._turns])
                self._fit.solve(workers)
                self._learn(self._fit, None)
                self._fit.relabel(self.sharpness)
                self._ensemble = Ensemble(self._fit)
            else:
                self._fit.renew(spectrum, centre)
                self._learn(self._fit, number)
                self._fit.relabel(self.sharpness, number)
                weighed = workers.submit(self._innovations.compare, self._fit, number)
            self._issued = float(polar["time"].max())
            self._ensemble.solve(self._fit, self._issued, workers)
            if weighed:
                weighed.result()
        made = self._field(self._fit, self._ensemble)
        self._innovations.remember(made)
        return made

    def _find_systems(self, known: list[TurnSpectrum], water: Water) -> WaveSystems | None:
        """The wave systems in the last turns, looked for again with each second, fourth … turn, then each fourth."""
        self._count += 1
        shown = [each for each in known if each.has_waves]
        if shown and (self._systems is None or len(shown) & (len(shown) - 1) == 0 or self._count % 4 == 0):
            self._systems = systems_of(shown, water, self._systems)
        return self._systems

    def _field(self, fit: Fit, ensemble: Ensemble) -> WaveField:
        return fit.field(self._issued, self.sharpness, ensemble.members, self._innovations.model_error(fit))

    def add_observations(self, seen: Observations) -> WaveField:
        """The field with observations of other instruments taken up too; the last turn's end stays its time.

        Raises ValueError before the first turn that shows a sea.
        """
        if self._fit is None or self._ensemble is None:
            raise ValueError("no turn has shown a sea yet")
        self._fit.add([seen], [_OTHERS])
        with pool() as workers:
            self._fit.update_weights()
            self._fit.solve(workers)
            self._fit.relabel(self.sharpness, _OTHERS)
            self._ensemble.solve(self._fit, self._issued, workers)
        return self._field(self._fit, self._ensemble)

    @property
    def sharpness(self) -> float:
        """How far water is moved by its own waves, see WaveField."""
        if self._sharpness is not None:
            return self._sharpness
        return float(np.clip(self._evidence[0] / self._evidence[1], 0.0, 1.0))

    def _learn(self, fit: Fit, number: int | None) -> None:
        """Takes up what the observations of one turn, or of all, say of the sharpness."""
        self._evidence = _FORGOTTEN * self._evidence + (1.0 - _FORGOTTEN) * _SURE**-2 * np.array([_SHARP, 1.0])
        self._evidence = self._evidence + fit.shift_evidence(number)


def _centre(polar: xr.Dataset) -> tuple[float, float]:
    """Where the antennas were at the end of a turn, m."""
    if "antenna_x" not in polar:
        return 0.0, 0.0
    last = int(np.argmax(polar["time"].values))
    x, y = (float(np.nan_to_num(polar[name].values[last])) for name in ("antenna_x", "antenna_y"))
    return x, y


_NEEDED = ("turn", "azimuth", "range", "height", "height_std", "ground_range", "quality", "time")
_REAL = 1.0  # sharpness of a real sea
_FINE_S = 0.5  # between leads that windows are found by
_SAMPLES = 12  # of what is open: of one fit all are drawn at once


def reconstruct(
    maps: xr.DataTree | None = None,
    settings: PredictionSettings | None = None,
    *,
    observations: Observations | None = None,
    spectrum: Spectrum | None = None,
) -> WaveField:
    """The sea as the last turns of some maps, or other observations, or both show it.

    maps: as from `retrieve`. settings: of a scene's section `prediction`; its defaults if left out.
    observations: of buoys, gauges or other instruments. spectrum: the expected one, needed
    where there are no maps.
    Raises InputError where neither shows a sea, SchemaError for maps that do not keep the schema.
    """
    settings = PredictionSettings() if settings is None else settings
    must_be("settings", settings, PredictionSettings, "PredictionSettings, as scene.prediction")
    if observations is not None:
        must_be("observations", observations, Observations, "prediction.Observations")
    if maps is None:
        if observations is None or spectrum is None:
            raise InputError("reconstruct: give maps, or observations and the spectrum that is expected")
        return _fit_observations(observations, spectrum, settings)
    polar = group_of(maps, "maps/polar", _NEEDED)
    predictor = predictor_of(settings)
    field = None
    for turn in range(max(0, polar.sizes["turn"] - settings.turns), polar.sizes["turn"]):
        field = predictor.turn(polar.isel(turn=turn))
    if field is None:
        raise InputError("maps: no turn of the last ones shows a sea; retrieve more turns, or another range")
    return field if observations is None else predictor.add_observations(observations)


def forecasts(
    maps: xr.DataTree,
    at: Sequence[tuple[float, float]] | None = None,
    lead_s: ArrayLike | None = None,
    settings: PredictionSettings | None = None,
) -> Iterator[xr.Dataset]:
    """A forecast for each turn of some maps, from what was seen up to then (schema `prediction`, one issue each).

    at: places, m east and north; the antennas' if left out. Turns after which no sea is known give none. Raises as
    `reconstruct`, `forecast` and `read_capytaine` do.
    """
    settings = settings or PredictionSettings()
    polar = group_of(maps, "maps/polar", _NEEDED)
    predictor, vessel = predictor_of(settings), vessel_of(settings.vessel)
    for turn in range(polar.sizes["turn"]):
        field = predictor.turn(polar.isel(turn=turn))
        if field is not None:
            yield issue(field, int(polar["turn"][turn]), settings, vessel, at, lead_s)


def issue(
    field: WaveField,
    number: int,
    settings: PredictionSettings,
    vessel: Vessel | None = None,
    at: Sequence[tuple[float, float]] | None = None,
    lead_s: ArrayLike | None = None,
) -> xr.Dataset:
    """A numbered forecast by settings: of the sea, of a vessel, and of quiet windows if the settings have limits."""
    lead = np.arange(0.0, settings.lead_s + _FINE_S, _FINE_S) if lead_s is None else np.asarray(lead_s, np.float64)
    heading, speed = settings.heading_deg or 0.0, settings.speed_m_s or 0.0
    made = forecast(field, at, lead, vessel=vessel, heading_deg=heading, speed_m_s=speed, draws=0)
    if notes := vessel_notes(vessel):
        made.attrs["vessel_notes"] = "; ".join(notes)
    limits = settings.quiet.limits
    if limits:
        last = max(settings.lead_s, settings.quiet.duration_s)
        fine = np.arange(0.0, last + _FINE_S, _FINE_S)
        drawn = forecast(field, at, fine, vessel=vessel, heading_deg=heading, speed_m_s=speed)
        windows = quiet_windows(drawn, limits, settings.quiet.duration_s, settings.quiet.confidence)
        chance = windows["probability"].interp(lead=lead).values  # NaN where the window ends beyond the last lead
        made["quiet"] = attributed("prediction", "quiet", chance)
        made.attrs |= windows.attrs
    return made.assign_coords(issue=np.array([number], np.int32))


def predictor_of(settings: PredictionSettings) -> Predictor:
    """What follows maps from turn to turn by some settings."""
    return Predictor(settings.turns, settings.lead_s, settings.sharpness, settings.amplitude_dispersion)


def vessel_of(settings: VesselSettings) -> Vessel | None:
    """The vessel of some settings, if there is one. Raises InputError for sizes and files that are of none."""
    try:
        match settings.shape:
            case "raft":
                return Follower()
            case "disc":
                return Disc(settings.beam_m or 0.0, settings.draught_m or 0.0)
            case "box":
                sizes = settings.length_m or 0.0, settings.beam_m or 0.0, settings.draught_m or 0.0
                return Box(*sizes, roll_period_s=settings.roll_period_s)
            case "file":
                return read_capytaine(settings.file or "", settings.body, settings.symmetry)
    except ValueError as error:
        raise InputError(f"prediction.vessel: {error}") from None
    return None


def vessel_notes(vessel: Vessel | None) -> tuple[str, ...]:
    """Notes on a vessel's file, one line each: which parts were left out, or look odd."""
    return getattr(vessel, "notes", ())


def _fit_observations(seen: Observations, spectrum: Spectrum, settings: PredictionSettings) -> WaveField:
    if not len(seen):
        raise InputError("observations: there are none; give one at least")
    centre = float(seen.x.mean()), float(seen.y.mean())
    sharpness = _REAL if settings.sharpness is None else settings.sharpness
    if settings.amplitude_dispersion is not None:
        spectrum = replace(spectrum, amplitude_dispersion=settings.amplitude_dispersion)
    # Forecasts may be asked for as far beyond the instruments as waves run from them.
    fit = Fit.of(spectrum, [seen], float(np.ptp(seen.time)) + 2.0 * settings.lead_s, centre)
    fit.add([seen], [0])
    with pool() as workers:
        fit.solve(workers)
        fit.relabel(sharpness)
        ensemble, issued = Ensemble(fit, chains=_SAMPLES), float(seen.time.max())
        ensemble.solve(fit, issued, workers)
    wrong = ModelError(drift=scatter(spectrum), since=fit.middle)
    return fit.field(issued, sharpness, ensemble.members, wrong)
