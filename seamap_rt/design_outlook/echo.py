"""Echo of the strips' cells over the noise: by facets' slopes, a measured mean, and the link budget."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from ..conventions import from_db
from ..radar import link
from ..radar.antenna import antenna
from ..radar.receiver import noise_power
from ..scattering import MEAN_MODELS, ShortWaves, mean_level, nrcs_composite
from ..scattering.calibration import fit_scale
from ..scattering.permittivity import permittivity_of
from ..settings import RadarSettings, ScatteringSettings
from .sight import TABLE, table_grazing

Array = NDArray[np.float64]

_ACROSS = np.array([-1.5, -0.5, 0.5, 1.5])  # standard deviations of the slope across a look


def echo_by_grazing(
    settings: ScatteringSettings, frequency_hz: float, limit: float, slope_rms: float, look_deg: Array
) -> Array:
    """σ0 per ground (look, TABLE) of facets by the grazing angle at which they are met, before calibration.

    limit: rad/m, up to which waves are on the surface; slope_rms: of the surface in one direction.
    """
    if settings.nrcs != "two_scale":
        return np.ones((look_deg.size, TABLE))
    grazing = table_grazing()[None, :, None]
    wind = np.radians(look_deg - settings.wind_from_deg)[:, None, None]
    across = slope_rms * _ACROSS
    weight = np.exp(-0.5 * _ACROSS**2)
    terms = nrcs_composite(
        0.5 * np.pi - grazing,
        0.0,
        across,
        wind,
        frequency_hz=frequency_hz,
        permittivity=permittivity_of(settings, frequency_hz),
        polarization=settings.polarization,
        waves=ShortWaves.of(settings, limit),
        breaking=settings.breaking,
    )
    area = np.sqrt(1.0 + across**2)
    return np.sum((terms.bragg + terms.specular + terms.breaking) * area * weight, axis=-1) / weight.sum()


def calibrated(
    settings: ScatteringSettings, frequency_hz: float, raw: NDArray[np.float32], grazing: Array, look_deg: Array
) -> NDArray[np.float32]:
    """σ0 per ground (look, row, gate) with the measured model's mean; raw: before; grazing (gate,) [rad]."""
    if settings.nrcs == "constant":
        return raw * np.float32(from_db(settings.nrcs_db))
    if settings.mean_model is None:
        return raw
    wind, mean = np.radians(look_deg - settings.wind_from_deg)[:, None], raw.mean(axis=1)
    target = np.broadcast_to(mean_level(settings, np.degrees(grazing), frequency_hz, wind_angle=wind), mean.shape)
    known = wind if MEAN_MODELS[settings.mean_model].knows_wind_direction else None
    scale = fit_scale(mean, np.ones(mean.shape), target, grazing[None], known, degree=3)
    return raw * scale(grazing[None], wind)[:, None].astype(np.float32)


def snr_of_unity(radar: RadarSettings, ranges: Array, lean: Array | None = None) -> Array:
    """Signal to noise ratio (gate,) of one pulse of a sea of σ0 = 1; of antennas that lean up (n,) [rad]: (n, gate)."""
    losses = link.losses_to_textbook(radar, ranges)
    power = link.textbook_power(radar, 1.0, ranges)
    lost = from_db(losses.azimuth + (losses.elevation if lean is None else 0.0) + losses.response)
    level = power / lost * link.eclipsed_share(radar, ranges) / noise_power(radar)
    if lean is None:
        return level
    return level * antenna(radar).voltage(0.0, -link.grazing_angle(radar, ranges) - lean[:, None]) ** 4
