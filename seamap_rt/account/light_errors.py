"""What leaving a part of light and scattering out costs, in the middle of a scene's range window or over all of it."""

from __future__ import annotations

from collections.abc import Callable
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from ..analytic import shadowing_smith67
from ..conventions import db, from_db
from ..physics.dispersion import angular_frequency
from ..radar.link import grazing_angle
from ..scattering import MEAN_MODELS, PERMITTIVITIES, ShortWaves, mean_nrcs, nrcs_composite
from ..scattering.bragg import radar_wavenumber
from ..scattering.modulation import ACTION_POWER
from ..scene import Scene
from ..sea import Resolved
from ..settings import RadarSettings

_RANGES = 400  # of the window, at which a share is asked for
_SLOPES = np.linspace(-4.0, 4.0, 41)  # standard deviations
_WINDS = 2.0 * np.pi * (np.arange(8) + 0.5) / 8.0  # rad, of the look against the wind
_GAUSS = np.exp(-0.5 * _SLOPES**2) / np.exp(-0.5 * _SLOPES**2).sum()


def middle_m(radar: RadarSettings) -> float:
    """Slant range [m] in the middle of the window, or of its part beyond the sea's nearest point."""
    near, far = radar.range_m
    return 0.5 * (max(near, radar.height_m) + far)


def window(radar: RadarSettings) -> NDArray[np.float64]:
    """Slant ranges [m] that fill the window evenly, where there is sea."""
    near, far = max(radar.range_m[0], radar.height_m), radar.range_m[1]
    return near + (far - near) * (np.arange(_RANGES) + 0.5) / _RANGES


def shadowed_share(radar: RadarSettings, slope_variance: float) -> float:
    """Share of the window that lies in shadow; slope_variance: along the look. Smith (1967)."""
    if slope_variance <= 0.0:
        return 0.0
    slope = np.tan(grazing_angle(radar, window(radar)))
    return float(np.mean(1.0 - shadowing_smith67(slope / np.sqrt(2.0 * slope_variance))))


def short_waves(scene: Scene, resolved: Resolved) -> ShortWaves:
    """The waves on the facets."""
    return ShortWaves(scene.scattering.wind_speed_m_s, resolved.wavenumber_limit, scene.scattering.inverse_wave_age)


def shadows_of_short_waves(scene: Scene, resolved: Resolved) -> float:
    """How much more of the window would lie in shadow if the waves that tilt the facets cast one too. Smith (1967)."""
    waves = short_waves(scene, resolved)
    tilts = sum(waves.tilt_variances(waves.divide(radar_wavenumber(scene.radar.frequency_hz))))
    carried = 0.5 * resolved.mean_square_slope
    return shadowed_share(scene.radar, carried + 0.5 * tilts) - shadowed_share(scene.radar, carried)


class Facing(NamedTuple):
    """What facets that face the radar return in the middle of the window, by slope and wind; shares of them."""

    weight: NDArray[np.float64]
    level: NDArray[np.float64]  # σ0 per horizontal area
    breaking: NDArray[np.float64]  # of it

    @property
    def modulation_db(self) -> float:
        """Rms of the level about its mean, dB."""
        level = db(self.level)
        return float(np.sqrt(np.sum(self.weight * (level - np.sum(self.weight * level)) ** 2)))

    @property
    def breaking_db(self) -> float:
        """What breakers add to the mean, dB."""
        breakers, whole = np.sum(self.weight * self.breaking), np.sum(self.weight * self.level)
        return -float(db(1.0 - breakers / whole))


def facing(scene: Scene, resolved: Resolved) -> Facing:
    """Facets by the theory of `scattering.composite`, over Gaussian slopes and all directions of the wind."""
    scattering, frequency = scene.scattering, scene.radar.frequency_hz
    grazing = float(grazing_angle(scene.radar, middle_m(scene.radar)))
    deviation = np.sqrt(0.5 * resolved.mean_square_slope)
    along, across, wind = np.meshgrid(deviation * _SLOPES, deviation * _SLOPES, _WINDS, indexing="ij")
    weight = np.broadcast_to((_GAUSS[:, None] * _GAUSS)[..., None], along.shape)
    faces = along > -np.tan(grazing)
    permittivity = PERMITTIVITIES[scattering.permittivity](frequency, scattering.temperature_c, scattering.salinity_psu)
    terms = nrcs_composite(
        0.5 * np.pi - grazing,
        along[faces],
        across[faces],
        wind[faces],
        frequency_hz=frequency,
        permittivity=complex(permittivity),
        polarization=scattering.polarization,
        waves=short_waves(scene, resolved),
    )
    area = np.sqrt(1.0 + along**2 + across**2)[faces]
    level = area * (terms.bragg + terms.specular + terms.breaking)
    return Facing(weight[faces] / weight[faces].sum(), level, area * terms.breaking)


def hydrodynamic_db(strain: float) -> float:
    """Rms modulation [dB] of Bragg scattering by a strain: 4.5 of it, in ln (Alpers & Hasselmann 1978)."""
    return float(10.0 / np.log(10.0) * ACTION_POWER * strain)


def bragg_speed(frequency_hz: float) -> float:
    """Phase speed [m/s] of the waves of half the radar's length, that scatter at grazing."""
    k = 2.0 * radar_wavenumber(frequency_hz)
    return float(angular_frequency(k)) / k


def mean_level(scene: Scene, range_m: float) -> float:
    """Mean σ0 (a ratio) at a slant range [m]; NRL 2012 stands in for theory that is calibrated to nothing."""
    scattering = scene.scattering
    if scattering.nrcs == "constant":
        return float(from_db(scattering.nrcs_db))
    return _model_level(scene, scattering.mean_model or "nrl", range_m)


def _model_level(scene: Scene, name: str, range_m: float, wind_angle: float | None = None) -> float:
    scattering, grazing = scene.scattering, np.degrees(grazing_angle(scene.radar, range_m))
    found = mean_nrcs(
        name,
        grazing,
        scattering.wind_speed_m_s,
        scene.radar.frequency_hz,
        scattering.polarization,
        wind_angle,
        extrapolate=True,
        clipped=True,
    )
    return float(found)


def _of_models(scene: Scene, measure: Callable[[str], float], directional: bool = False) -> list[float]:
    names = [name for name, model in MEAN_MODELS.items() if model.knows_wind_direction or not directional]
    return [measure(name) for name in names]


def models_spread_db(scene: Scene) -> float:
    """Standard deviation [dB] of the published mean models among each other in the middle of the window."""
    middle = middle_m(scene.radar)
    return float(np.std(_of_models(scene, lambda name: float(db(_model_level(scene, name, middle)))), ddof=1))


def wind_contrast_db(scene: Scene) -> float:
    """Mean σ0 up-wind over that down-wind [dB] in the middle of the window, by the models that know it."""
    middle = middle_m(scene.radar)

    def contrast(name: str) -> float:
        return float(db(_model_level(scene, name, middle, 0.0) / _model_level(scene, name, middle, np.pi)))

    return float(np.mean(_of_models(scene, contrast, directional=True)))


def outside_share(radar: RadarSettings, low_deg: float, high_deg: float) -> float:
    """Share of the window that is seen under a grazing angle outside a model's."""
    grazing = np.degrees(grazing_angle(radar, window(radar)))
    return float(np.mean((grazing < low_deg) | (grazing > high_deg)))
