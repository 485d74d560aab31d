"""Closed forms behind `limits`: what leaving a part of the simulation out costs, for one scene and its resolved sea.

Means over looks and headings count all directions alike. σ0 is the ratio of cross-section to horizontal area.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray
from scipy.special import erfcx, spherical_jn

from ..conventions import EARTH_RADIUS, SPEED_OF_LIGHT, db, from_db
from ..physics.dispersion import angular_frequency, orbital_ratio
from ..physics.phase_noise import cramer_rao_phase_std
from ..physics.shadowing import shadowing_smith67
from ..radar import link
from ..radar.antenna import Antenna
from ..radar.array import antenna_array
from ..radar.digital import low_pass, quantisation_step
from ..radar.platform import boat_motion
from ..radar.receiver import noise_power
from ..scattering import MEAN_MODELS, PERMITTIVITIES, ShortWaves, mean_nrcs, nrcs_composite
from ..scattering.bragg import radar_wavenumber
from ..scattering.modulation import ACTION_POWER
from ..scene import Scene
from ..sea import Resolved, spectral_system, wave_facts
from ..settings import RadarSettings, RandomWaves, SeaSettings, SinusoidWaves

Array = NDArray[np.float64]

_REFRACTED_RADIUS = 4.0 / 3.0 * EARTH_RADIUS  # m, of standard refraction
_LONGEST = 1e-5  # rad/m, beyond every sea wave
_SPECTRUM_STEPS = 4001  # in ln k: moments are good to 1e-4
_LOOKS = np.pi * (np.arange(32) + 0.5) / 64.0  # rad between a wave and the look, a quarter of the circle
_RANGES = 400  # of the window, over which a share is taken
_SLOPES = np.linspace(-4.0, 4.0, 41)  # standard deviations
_GAUSS = np.exp(-0.5 * _SLOPES**2) / np.exp(-0.5 * _SLOPES**2).sum()
_WINDS = 2.0 * np.pi * (np.arange(8) + 0.5) / 8.0  # rad, of the look against the wind
_MOTION_TIMES = 512
_PATTERN_ANGLES = 20_001
_CLUTTER_SHAPE_LOSS = {"VV": 1.0, "HH": 1.7}  # of log10 ν (Watts & Wicks 1990)

# ------------------------------------------------------------------------------------------------------- the sea


class ResolvedWaves(NamedTuple):
    """Waves of the mesh by wavenumber; all arrays (wave,)."""

    wavenumber: Array  # rad/m
    frequency: Array  # rad/s, for an observer who drifts with the current
    encounter: Array  # rad/s, at a fixed point: a current carries the waves past
    variance: Array  # m²
    depth: float  # m

    @property
    def elevation_std(self) -> float:
        return float(np.sqrt(self.variance.sum()))


def resolved_waves(sea: SeaSettings, limit: float) -> ResolvedWaves:
    """The waves of a sea below a wavenumber `limit` [rad/m], and its regular waves of any length."""
    log_k = np.linspace(np.log(_LONGEST), np.log(limit), _SPECTRUM_STEPS)
    weight = np.full(_SPECTRUM_STEPS, log_k[1] - log_k[0])
    weight[[0, -1]] *= 0.5
    systems = [np.empty((3, 0))]  # of wavenumber, variance and current along the waves
    for waves in sea.waves:
        facts = wave_facts(waves, sea.depth_m)
        if facts is None:
            continue
        if isinstance(waves, SinusoidWaves):
            k, power = np.array([2.0 * np.pi / waves.wavelength_m]), np.array([0.125 * waves.height_m**2])
        elif isinstance(waves, RandomWaves):
            k = np.exp(log_k)
            power = k * spectral_system(waves, sea.depth_m).radial(k) * weight
        else:
            continue
        current = sea.current_m_s * np.cos(np.radians(facts.from_deg + 180.0 - sea.current_toward_deg))
        systems.append(np.stack((k, power, np.full(k.size, current))))
    k, variance, current = np.concatenate(systems, axis=1)
    frequency = angular_frequency(k, sea.depth_m)
    return ResolvedWaves(k, frequency, frequency + k * current, variance, sea.depth_m)


def still_sea_error(waves: ResolvedWaves, duration_s: float) -> float:
    """Rms height [m] between the sea as a beam meets it within `duration_s` and the sea as it is half-way.

    √2 σ √(1 − ρ(τ)) at the time τ from half-way, with the elevation's correlation ρ(τ) = Σ S cos ωτ/σ² (Longuet-Higgins
    1957); its mean square over the time is 2 Σ S (1 − sinc ωT/2). 0 for no time, √2 σ for a long one.
    """
    kept = np.sinc(waves.encounter * duration_s / (2.0 * np.pi))
    return float(np.sqrt(2.0 * np.sum(waves.variance * (1.0 - kept))))


def orbital_speed(waves: ResolvedWaves) -> float:
    """Rms speed [m/s] of the water along the look at grazing: ½ Σ ω² S coth² kh (Airy 1845), the mean over looks."""
    ratio = orbital_ratio(waves.wavenumber, waves.depth)
    return float(np.sqrt(0.5 * np.sum(waves.variance * (waves.frequency * ratio) ** 2)))


def strain_std(waves: ResolvedWaves, relaxation_rate: float) -> float:
    """Rms strain of the short waves by the resolved ones at a relaxation rate μ [1/s]: Σ S k²ω²/(μ² + ω²) ⟨cos⁴⟩.

    Alpers & Hasselmann (1978), see `scattering.modulation`; over all looks cos⁴ is 3/8 in the mean.
    """
    omega2 = waves.frequency**2
    return float(np.sqrt(0.375 * np.sum(waves.variance * waves.wavenumber**2 * omega2 / (relaxation_rate**2 + omega2))))


def slopes_lost(waves: ResolvedWaves, spacing_m: float) -> float:
    """Rms slope along the look of the waves shorter than twice `spacing_m`; half their mean square slope."""
    lost = waves.wavenumber > np.pi / spacing_m
    return float(np.sqrt(0.5 * np.sum(waves.variance[lost] * waves.wavenumber[lost] ** 2)))


def second_order_error(elevation_std: float, steepness: float) -> float:
    """Rms height [m] of the bound waves that sharpen the crests of a narrow-banded sea: kσ² (Longuet-Higgins 1963).

    steepness: 4σ over the length of the peak. The second order is ½ k (η² − η̂²), whose terms vary by 2σ² together.
    """
    return 0.5 * np.pi * steepness * elevation_std


def drop_m(ground_range_m: float) -> float:
    """By how much [m] the Earth falls away beneath the tangent plane, √(R² + d²) − R with 4/3 of its radius."""
    return ground_range_m**2 / (_REFRACTED_RADIUS + float(np.hypot(_REFRACTED_RADIUS, ground_range_m)))


# ----------------------------------------------------------------------------------------------- light and scattering


def middle_m(radar: RadarSettings) -> float:
    """Slant range [m] in the middle of the window, or of its part beyond the sea's nearest point."""
    return 0.5 * (max(radar.range_m[0], radar.height_m) + radar.range_m[1])


def window(radar: RadarSettings) -> Array:
    """(400,) slant ranges [m] that fill the window evenly, where there is sea."""
    near, far = max(radar.range_m[0], radar.height_m), radar.range_m[1]
    return near + (far - near) * (np.arange(_RANGES) + 0.5) / _RANGES


def shadowed_share(radar: RadarSettings, slope_variance: float) -> float:
    """Share of the window that lies in shadow; slope_variance: along the look. Smith (1967)."""
    if slope_variance <= 0.0:
        return 0.0
    slope = np.tan(link.grazing_angle(radar, window(radar)))
    return float(np.mean(1.0 - shadowing_smith67(slope / np.sqrt(2.0 * slope_variance))))


def shadows_of_short_waves(scene: Scene, resolved: Resolved) -> float:
    """How much more of the window would lie in shadow if the waves that tilt the facets cast one too. Smith (1967)."""
    waves = _short_waves(scene, resolved)
    tilts = sum(waves.tilt_variances(waves.divide(radar_wavenumber(scene.radar.frequency_hz))))
    carried = 0.5 * resolved.mean_square_slope
    return shadowed_share(scene.radar, carried + 0.5 * tilts) - shadowed_share(scene.radar, carried)


def second_bounce_share(mean_square_slope: float) -> float:
    """Share of the power sent out evenly (Lambert) by a Gaussian surface that meets the surface again: 1 − A/A′.

    A′/A = ⟨√(1 + s²)⟩ is its area over the plane's, s² of isotropic slopes being exponentially distributed; what leaves
    crosses the plane, and by the reciprocity of view factors that is A/A′ of it (Howell et al. 2010, chapter 4). For
    the resolved waves of `choppy_sea` 0.6 %, where traced paths give 0.5 % of the echo.
    """
    if mean_square_slope <= 0.0:
        return 0.0
    grown = 0.5 * np.sqrt(np.pi * mean_square_slope) * float(erfcx(1.0 / np.sqrt(mean_square_slope)))
    return float(grown / (1.0 + grown))


def edge_blur_m(wavelength_m: float, to_edge_m: float, beyond_m: float) -> float:
    """Height [m] over which a knife edge's shadow fades, v = 1: √(λ d₁d₂/(2 (d₁ + d₂))) (ITU-R P.526, section 4.1)."""
    return float(np.sqrt(0.5 * wavelength_m * to_edge_m * beyond_m / (to_edge_m + beyond_m)))


def clutter_shape(radar: RadarSettings, polarization: str, range_m: float) -> float:
    """Shape ν of the K-distribution that measured seas' echoes have, the mean over looks of log ν; NaN beyond the law.

    log₁₀ ν = 2/3 log₁₀ ψ° + 5/8 log₁₀ A − K for grazing angles ψ of 0.1–10° and cells of A m² (Watts & Wicks 1990),
    good to a factor of two or three.
    """
    grazing_deg = float(np.degrees(link.grazing_angle(radar, range_m)))
    if not 0.1 <= grazing_deg <= 10.0:
        return float("nan")
    area = float(link.cell_area(radar, range_m))
    return grazing_deg ** (2.0 / 3.0) * area**0.625 * 10.0 ** -_CLUTTER_SHAPE_LOSS[polarization]


class Facing(NamedTuple):
    """What facets that face the radar return in the middle of the window, by slope and wind; all arrays (case,)."""

    weight: Array  # their sum is 1
    level: Array  # σ0 per horizontal area
    breaking: Array  # of it

    @property
    def modulation_db(self) -> float:
        """Rms of the level about its mean, dB."""
        level = db(self.level)
        return float(np.sqrt(np.sum(self.weight * (level - np.sum(self.weight * level)) ** 2)))

    @property
    def breaking_db(self) -> float:
        """What breakers add to the mean, dB."""
        return -float(db(1.0 - np.sum(self.weight * self.breaking) / np.sum(self.weight * self.level)))


def facing(scene: Scene, resolved: Resolved) -> Facing:
    """Facets by the theory of `scattering.composite`, over Gaussian slopes and all directions of the wind."""
    scattering, frequency = scene.scattering, scene.radar.frequency_hz
    grazing = float(link.grazing_angle(scene.radar, middle_m(scene.radar)))
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
        waves=_short_waves(scene, resolved),
    )
    area = np.sqrt(1.0 + along**2 + across**2)[faces]
    level = area * (terms.bragg + terms.specular + terms.breaking)
    return Facing(weight[faces] / weight[faces].sum(), level, area * terms.breaking)


def _short_waves(scene: Scene, resolved: Resolved) -> ShortWaves:
    """The waves on the facets."""
    return ShortWaves(scene.scattering.wind_speed_m_s, resolved.wavenumber_limit, scene.scattering.inverse_wave_age)


def hydrodynamic_db(strain: float) -> float:
    """Rms modulation [dB] of Bragg scattering by a strain: 4.5 of it, in ln (Alpers & Hasselmann 1978)."""
    return float(10.0 / np.log(10.0) * ACTION_POWER * strain)


def bragg_speed(frequency_hz: float) -> float:
    """Phase speed [m/s] of the waves of half the radar's length, which scatter at grazing."""
    k = 2.0 * radar_wavenumber(frequency_hz)
    return float(angular_frequency(k)) / k


def mean_level(scene: Scene, range_m: float) -> float:
    """Mean σ0 (a ratio) at a slant range [m]; NRL 2012 stands in for theory that is calibrated to nothing."""
    if scene.scattering.nrcs == "constant":
        return float(from_db(scene.scattering.nrcs_db))
    return _model_level(scene, scene.scattering.mean_model or "nrl", range_m)


def _model_level(scene: Scene, name: str, range_m: float, wind_angle: float | None = None) -> float:
    scattering, grazing = scene.scattering, np.degrees(link.grazing_angle(scene.radar, range_m))
    wind, frequency = scattering.wind_speed_m_s, scene.radar.frequency_hz
    clipped = {"extrapolate": True, "clipped": True}
    return float(mean_nrcs(name, grazing, wind, frequency, scattering.polarization, wind_angle, **clipped))


def models_spread_db(scene: Scene) -> float:
    """Standard deviation [dB] of the published mean models among each other in the middle of the window."""
    middle = middle_m(scene.radar)
    return float(np.std([float(db(_model_level(scene, name, middle))) for name in MEAN_MODELS], ddof=1))


def wind_contrast_db(scene: Scene) -> float:
    """Mean σ0 up-wind over that down-wind [dB] in the middle of the window, by the models that know it."""
    middle = middle_m(scene.radar)
    levels = [
        [_model_level(scene, name, middle, angle) for angle in (0.0, np.pi)]
        for name, model in MEAN_MODELS.items()
        if model.knows_wind_direction
    ]
    return float(np.mean([float(db(up / down)) for up, down in levels]))


def outside_share(radar: RadarSettings, low_deg: float, high_deg: float) -> float:
    """Share of the window that is seen under a grazing angle outside a model's."""
    grazing = np.degrees(link.grazing_angle(radar, window(radar)))
    return float(np.mean((grazing < low_deg) | (grazing > high_deg)))


# ------------------------------------------------------------------------------------------------ radar and boat


def phase_paths(radar: RadarSettings) -> int:
    """p: 2 where the antennas that are compared transmit for themselves, else 1."""
    return 2 if not antenna_array(radar).whole and radar.transmit == "switched" else 1


def height_per_radian(radar: RadarSettings, range_m: float) -> float:
    """Height [m] that a radian of interferometric phase is worth at grazing: λR/(2πpB); inf without a baseline."""
    baseline = antenna_array(radar).baseline_m
    if baseline == 0.0:
        return float("inf")
    return link.wavelength(radar) * range_m / (2.0 * np.pi * phase_paths(radar) * baseline)


def looks(radar: RadarSettings, decorrelation_time_s: float) -> float:
    """Independent samples of speckle in a dwell: N²/ΣΣ ρ² of N pulses, ρ = exp(−(τ/τc)²) (Goodman 2007)."""
    dwell = link.dwell(radar)
    return dwell.pulses / link.coherent_gain(dwell.pulses, dwell.interval_s, decorrelation_time_s / np.sqrt(2.0))


def speckle_db(count: float) -> float:
    """Scatter [dB] of a mean of so many independent powers: 1/√looks of it."""
    return float(db(1.0 + 1.0 / np.sqrt(count)))


def signal_to_noise(radar: RadarSettings, level: float, range_m: float) -> float:
    """Of one pulse off a sea of σ0 = `level` by the textbook's equation, with the antenna's gain towards that sea."""
    towards = float(link.gain_towards_sea(radar, range_m))
    return float(link.textbook_power(radar, level, range_m, towards)) / noise_power(radar)


def noise_phase_error(radar: RadarSettings, snr: float) -> float:
    """Rms phase [rad] by thermal noise over the pulses of a dwell: the Cramér–Rao bound, coherence snr/(1 + snr)."""
    return float(cramer_rao_phase_std(snr / (1.0 + snr), link.dwell(radar).pulses))


def noise_height_error(radar: RadarSettings, snr: float, range_m: float) -> float:
    """Rms height [m] by thermal noise over the pulses of a dwell."""
    return noise_phase_error(radar, snr) * height_per_radian(radar, range_m)


def quantisation_db(radar: RadarSettings, full_scale_w: float) -> float:
    """The converter's noise in a gate over the thermal one [dB]: q²/12 (Bennett 1948), as much as the low-pass leaves.

    full_scale_w: of a sine; −6.02 dB with each bit. A sensitivity-time control raises it near by. ValueError where the
    intermediate frequency does not lie within one Nyquist zone.
    """
    step = float(quantisation_step(full_scale_w, radar.receiver.adc_bits))
    # A real sample's noise is white, of which an envelope of twice its power keeps what passes the filter.
    kept = 2.0 * float(np.sum(low_pass(radar) ** 2))
    return float(db(kept * step**2 / 12.0 / noise_power(radar)))


def full_scale_w(radar: RadarSettings, strongest_w: float) -> float:
    """Full scale [W]: as given, or by automatic gain from the strongest echo [W]."""
    receiver = radar.receiver
    if receiver.gain == "fixed":
        return 1e-3 * float(from_db(receiver.full_scale_dbm))
    return max(strongest_w, noise_power(radar)) * float(from_db(receiver.agc_headroom_db))


def share_beyond(antenna: Antenna, beam_deg: float, beams: float) -> float:
    """Share of a two-way azimuth pattern's power that comes from more than so many beam widths off the boresight."""
    angle = np.linspace(-0.5 * np.pi, 0.5 * np.pi, _PATTERN_ANGLES)
    power = antenna.azimuth(np.sin(angle)) ** 4
    return float(power[np.abs(angle) > np.radians(beams * beam_deg)].sum() / power.sum())


def first_antenna(radar: RadarSettings) -> Antenna:
    """That of the first receiver."""
    array = antenna_array(radar)
    return array.elements[array.receivers[0]].antenna


def object_over_sea_db(radar: RadarSettings, rcs_dbsm: float, level: float, range_m: float) -> float:
    """An object's cross-section over that of the sea in its cell, dB."""
    return rcs_dbsm - float(db(level * link.cell_area(radar, range_m)))


def doppler_cycles(radar: RadarSettings, speed_m_s: float) -> float:
    """Cycles of phase that a speed along the look makes of a dwell: 2vT/λ."""
    return 2.0 * speed_m_s * link.dwell(radar).duration_s * radar.frequency_hz / SPEED_OF_LIGHT


def boat_tilt_at_rest(scene: Scene) -> float:
    """Rms tilt [rad] along the look, the mean over looks, of a boat whose motion does not depend on the sea."""
    times = np.linspace(0.0, scene.turns * scene.turn_duration_s, _MOTION_TIMES)
    attitude = np.radians(boat_motion(scene.platform)(times).attitude[:, :2])
    return float(np.sqrt(0.5 * np.mean(np.sum(attitude**2, axis=1))))


def boat_tilt(waves: ResolvedWaves, length_m: float, beam_m: float) -> float:
    """Rms tilt [rad] along the look of a boat that lies in the plane that fits the waves within its waterline.

    By the responses of `radar.wave_following`, with 3 j₁(p)/p for the line's; the mean over its headings and the looks.
    """
    square = 0.0
    for angle in _LOOKS:
        ahead, aside = waves.wavenumber * np.cos(angle), waves.wavenumber * np.sin(angle)
        p, q = 0.5 * length_m * ahead, 0.5 * beam_m * aside
        pitch = 3.0 * spherical_jn(1, p) / p * spherical_jn(0, q) * ahead
        roll = 3.0 * spherical_jn(1, q) / q * spherical_jn(0, p) * aside
        square += 0.5 * float(np.sum(waves.variance * (pitch**2 + roll**2))) / _LOOKS.size
    return float(np.sqrt(square))
