"""A wave field from maps of several turns, from observations of any kind, or from both."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import replace

import numpy as np
import xarray as xr
from numpy.typing import ArrayLike

from ..compute.machine import pool
from ..dataset import attributed, group_of
from ..errors import InputError, must_be
from ..settings import PredictionSettings, VesselSettings
from .capytaine import read_capytaine
from .ensemble import Ensemble
from .field import WaveField
from .fit import Fit
from .forecast import forecast
from .model_error import ModelError, scatter
from .observations import Observations
from .predictor import Predictor
from .spectrum import Spectrum
from .vessel import Box, Disc, Follower, Vessel
from .windows import quiet_windows

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
        return _of_observations(observations, spectrum, settings)
    polar = group_of(maps, "maps/polar", _NEEDED)
    predictor = predictor_of(settings)
    field = None
    for turn in range(max(0, polar.sizes["turn"] - settings.turns), polar.sizes["turn"]):
        field = predictor.turn(polar.isel(turn=turn))
    if field is None:
        raise InputError("maps: no turn of the last ones shows a sea; retrieve more turns, or another range")
    return field if observations is None else predictor.also(observations)


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
    if told := vessel_notes(vessel):
        made.attrs["vessel_notes"] = "; ".join(told)
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
    """What one should know of a vessel's file: what of it was left out, or is odd; a line each."""
    return getattr(vessel, "notes", ())


def _of_observations(seen: Observations, spectrum: Spectrum, settings: PredictionSettings) -> WaveField:
    if not len(seen):
        raise InputError("observations: there are none; give one at least")
    centre = float(seen.x.mean()), float(seen.y.mean())
    sharpness = _REAL if settings.sharpness is None else settings.sharpness
    if settings.amplitude_dispersion is not None:
        spectrum = replace(spectrum, amplitude_dispersion=settings.amplitude_dispersion)
    # Forecasts may be asked for as far beyond the instruments as waves run from them.
    fit = Fit.anew(spectrum, [seen], float(np.ptp(seen.time)) + 2.0 * settings.lead_s, centre)
    fit.add([seen], [0])
    with pool() as workers:
        fit.settle(workers)
        fit.relabel(sharpness)
        ensemble, issued = Ensemble(fit, chains=_SAMPLES), float(seen.time.max())
        ensemble.settle(fit, issued, workers)
    wrong = ModelError(drift=scatter(spectrum), since=fit.middle)
    return fit.field(issued, sharpness, ensemble.members, wrong)
