"""The published models of mean sea clutter by their short names."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike, NDArray

from seamap_rt.conventions import db, from_db
from seamap_rt.scattering.composite import nrcs_level_sea
from seamap_rt.scattering.empirical import (
    GIT,
    HYBRID,
    NRL,
    TSC,
    ModelRange,
    nrcs_gregers_hansen12,
    nrcs_horst78,
    nrcs_reilly90,
    nrcs_tsc90,
    sea_state_from_wind,
    wind_from_sea_state,
)
from seamap_rt.settings import ScatteringSettings


@dataclass(frozen=True)
class MeanModel(ModelRange):
    """A published model, the values that it holds for, and whether it separates upwind from downwind."""

    paper: str
    function: Callable[..., NDArray[np.float64]]  # (grazing_deg, sea_state, frequency_hz, polarization, ...)
    knows_wind_direction: bool = True

    @property
    def range_words(self) -> str:
        """Sea states and frequencies for which it was fitted."""
        (calm, rough), (low, high) = self.sea_state, self.frequency_hz
        return f"sea states {calm:g} to {rough:g} and {1e-9 * low:g} to {1e-9 * high:g} GHz"

    def nearest_wind(self, wind_speed: float) -> float:
        """The wind [m/s] itself where it was fitted to it, else the nearest for which it was."""
        calm, rough = (float(wind_from_sea_state(state)) for state in self.sea_state)
        return min(max(wind_speed, calm), rough)


MEAN_MODELS: dict[str, MeanModel] = {
    "nrl": MeanModel(
        **vars(NRL), paper="Gregers-Hansen & Mittal 2012", function=nrcs_gregers_hansen12, knows_wind_direction=False
    ),
    "git": MeanModel(**vars(GIT), paper="Horst, Dyer & Tuley 1978", function=nrcs_horst78),
    "tsc": MeanModel(**vars(TSC), paper="Technology Service Corporation 1990", function=nrcs_tsc90),
    "hybrid": MeanModel(**vars(HYBRID), paper="Reilly & Dockery 1990", function=nrcs_reilly90),
}


def mean_nrcs(
    name: str,
    grazing_deg: ArrayLike,
    wind_speed: ArrayLike,
    frequency_hz: ArrayLike,
    polarization: str,
    wind_angle: ArrayLike | None = None,
    extrapolate: bool = False,
    clipped: bool = False,
) -> NDArray[np.float64]:
    """Mean σ0 [linear, per horizontal area] by the model `name` of `MEAN_MODELS`; the arguments broadcast.

    grazing_deg: °. wind_speed: U10, m/s, of a fully developed sea. wind_angle [rad]: the look's azimuth less the one
    that the wind comes from, 0 looks into the wind; None, and any model that does not know it, gives the mean over
    all directions. Nothing but the direction's factor is worked out at the full shape, so a row of grazing
    angles and a column of wind angles are cheap. ValueError for an unknown name and outside the model's range, unless
    `extrapolate` lets the formula run on; `clipped` brings the grazing angle, and only it, into the range first.
    """
    if name not in MEAN_MODELS:
        raise ValueError(f"name = {name!r}: must be one of {', '.join(MEAN_MODELS)}; name one of them")
    model = MEAN_MODELS[name]
    direction = {"wind_angle": wind_angle} if model.knows_wind_direction else {}
    state = sea_state_from_wind(wind_speed)
    return model.function(
        grazing_deg, state, frequency_hz, polarization, extrapolate=extrapolate, clipped=clipped, **direction
    )


def mean_level(
    settings: ScatteringSettings,
    grazing_deg: ArrayLike,
    frequency_hz: float,
    name: str | None = None,
    wind_angle: ArrayLike | None = None,
) -> NDArray[np.float64]:
    """Mean σ0 [linear] of a scene's scattering at grazing angles [°] and wind angles [rad], which broadcast.

    name: of another model than the scene's own. wind_angle: as in `mean_nrcs`. Theory that is calibrated to nothing
    has a mean only facet by facet: NRL 2012 stands in for it. Beyond its model's winds the mean is the model's at the
    nearest wind that it holds for, times theory's growth from there (`nrcs_level_sea`). Frequencies, and with
    `extrapolate` winds, let the formula run on; grazing angles keep its edge value.
    """
    if name is None and settings.nrcs == "constant":
        return np.full(np.shape(grazing_deg), from_db(settings.nrcs_db))
    name = name or settings.mean_model or "nrl"
    wind = settings.wind_speed_m_s
    held = wind if settings.extrapolate else MEAN_MODELS[name].nearest_wind(wind)
    level = mean_nrcs(
        name, grazing_deg, held, frequency_hz, settings.polarization, wind_angle, extrapolate=True, clipped=True
    )
    if held == wind:
        return level
    grazing = np.radians(np.clip(grazing_deg, *MEAN_MODELS[name].grazing_deg))
    here, there = (
        nrcs_level_sea(settings.model_copy(update={"wind_speed_m_s": speed}), frequency_hz, grazing)
        for speed in (wind, held)
    )
    return level * (here / there)


def models_spread_db(settings: ScatteringSettings, grazing_deg: float, frequency_hz: float) -> float:
    """Standard deviation [dB] of the published means among each other, for a scene's wind and polarization."""
    return float(np.std([db(mean_level(settings, grazing_deg, frequency_hz, name)) for name in MEAN_MODELS], ddof=1))


def wind_contrast_db(settings: ScatteringSettings, grazing_deg: float, frequency_hz: float) -> float:
    """Mean σ0 up-wind over that down-wind [dB], the mean of the models that know it."""
    directed = [name for name, model in MEAN_MODELS.items() if model.knows_wind_direction]
    up, down = (
        np.array([float(mean_level(settings, grazing_deg, frequency_hz, name, angle)) for name in directed])
        for angle in (0.0, np.pi)
    )
    return float(np.mean(db(up / down)))
