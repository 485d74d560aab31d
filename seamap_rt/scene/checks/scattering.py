"""Scattering: that models are used within the ranges of their papers."""

from __future__ import annotations

import math

from ...io.text import rounded_down, rounded_up
from ...scattering import MEAN_MODELS, wind_from_sea_state
from ...scattering.permittivity import permittivity_of
from ...settings import RadarSettings, ScatteringSettings

LEAST_WIND = 0.5  # m/s, of scattering.wind_speed_m_s
STEEPEST = math.sin(math.radians(59.9))  # sine of the grazing angle beyond which no clutter model is used


def check_permittivity(scattering: ScatteringSettings, radar: RadarSettings) -> None:
    """The permittivity model holds for frequency and water."""
    try:
        permittivity_of(scattering, radar.frequency_hz)
    except ValueError as error:
        raise ValueError(
            f"scattering.permittivity = '{scattering.permittivity}': {error}, or choose another scattering.permittivity"
        ) from None


def check_mean_model(scattering: ScatteringSettings, radar: RadarSettings) -> None:
    """The measured model that sets the mean holds for frequency and grazing angles, unless it is extrapolated; and for
    the wind where it is all that echoes: theory's mean goes on from the model's nearest wind by theory (`mean_level`).
    """
    name = scattering.mean_model
    if name is None or scattering.extrapolate:
        return
    model = MEAN_MODELS[name]
    key = "scattering.nrcs" if scattering.nrcs == name else "scattering.calibrated_to"
    other = f"or choose another {key}" + (" ('none' leaves theory alone)" if key.endswith("to") else "")
    remedy = f"{other}, or set scattering.extrapolate = true to let its formula run on"
    least, most = model.sea_state
    wind = scattering.wind_speed_m_s
    if scattering.nrcs == name and model.nearest_wind(wind) != wind:
        limits = [max(LEAST_WIND, float(wind_from_sea_state(state))) for state in (least, most)]
        raise ValueError(
            f"scattering.wind_speed_m_s = {wind:.10g}: must be {rounded_up(limits[0])} to {rounded_down(limits[1])} "
            f"(sea state {least:g} to {most:g}, where {key} = '{name}' holds: {model.paper}); change it, {remedy}, or "
            "set scattering.nrcs = 'two_scale', whose mean goes on from there by theory"
        )
    low, high = model.frequency_hz
    frequency = radar.frequency_hz
    if not low <= frequency <= high:
        raise ValueError(
            f"radar.frequency_hz = {frequency:.10g}: must be {low:g} to {high:g}, where {key} = '{name}' holds "
            f"({model.paper}); change it, {remedy}"
        )
    if name != "nrl":
        _check_grazing(radar, key, name, f"{other}, or set scattering.extrapolate = true to keep its edge value")


def _check_grazing(radar: RadarSettings, key: str, name: str, remedy: str) -> None:
    """NRL 2012 reaches from 0.1° to 60°, and what little lies beyond takes its edge value; the others end sooner.
    Steeper than 60°, about the mast's foot, no clutter model is used."""
    (near, far), height = radar.range_m, radar.height_m
    model = MEAN_MODELS[name]
    least, most = (math.sin(math.radians(angle)) for angle in model.grazing_deg)
    if far > height / least:
        raise ValueError(
            f"radar.range_m = [{near:.10g},{far:.10g}]: its far end must be at most {rounded_down(height / least)} "
            f"(there the sea is seen under {model.grazing_deg[0]:g}°, the least for which {key} = '{name}' holds: "
            f"{model.paper}); lower it, {remedy}"
        )
    if near < height / most and most < STEEPEST:
        if far <= height / most:
            raise ValueError(
                f"radar.range_m = [{near:.10g},{far:.10g}]: lies wholly nearer than {rounded_up(height / most)} "
                f"(there the sea is seen under {model.grazing_deg[1]:g}°, the most for which {key} = '{name}' holds: "
                f"{model.paper}); move it out, lower radar.height_m, {remedy}"
            )
        raise ValueError(
            f"radar.range_m = [{near:.10g},{far:.10g}]: its near end must be at least {rounded_up(height / most)} "
            f"(there the sea is seen under {model.grazing_deg[1]:g}°, the most for which {key} = '{name}' holds: "
            f"{model.paper}); raise it, {remedy}"
        )
