"""What leaving a part of the radar, the boat or the Earth out costs."""

from __future__ import annotations

import numpy as np

from ..analytic import cramer_rao_phase_std
from ..conventions import EARTH_RADIUS, SPEED_OF_LIGHT, db, from_db
from ..radar import link
from ..radar.antenna import Antenna
from ..radar.array import antenna_array
from ..radar.digital import low_pass, quantisation_step
from ..radar.platform import boat_motion
from ..radar.receiver import noise_power
from ..scene import Scene
from ..settings import RadarSettings

_EARTH = 4.0 / 3.0 * EARTH_RADIUS  # m, of standard refraction
_TIMES = 512  # at which a boat's motion is asked for
_ANGLES = 20_001  # of a pattern


def drop_m(ground_range_m: float) -> float:
    """By how much [m] the Earth falls away beneath the tangent plane, √(R² + d²) − R with 4/3 of its radius."""
    return ground_range_m**2 / (_EARTH + float(np.hypot(_EARTH, ground_range_m)))


def ways(radar: RadarSettings) -> int:
    """p: 2 where the antennas that are compared send for themselves, else 1."""
    return 2 if not antenna_array(radar).whole and radar.transmit == "switched" else 1


def height_per_radian(radar: RadarSettings, range_m: float) -> float:
    """Height [m] that a radian of interferometric phase is worth at grazing: λR/(2πpB); inf without a baseline."""
    baseline = antenna_array(radar).baseline_m
    if baseline == 0.0:
        return float("inf")
    return link.wavelength(radar) * range_m / (2.0 * np.pi * ways(radar) * baseline)


def looks(radar: RadarSettings, decorrelation_time_s: float) -> float:
    """Independent samples of speckle in a dwell: N²/ΣΣ ρ² of N pulses, ρ = exp(−(τ/τc)²) (Goodman 2007)."""
    dwell = link.dwell(radar)
    lag = np.arange(1, dwell.pulses)
    square = np.exp(-2.0 * (lag * dwell.interval_s / decorrelation_time_s) ** 2)
    return dwell.pulses / (1.0 + 2.0 * float(np.sum((1.0 - lag / dwell.pulses) * square)))


def speckle_db(count: float) -> float:
    """Scatter [dB] of a mean of so many independent powers: 1/√looks of it."""
    return float(db(1.0 + 1.0 / np.sqrt(count)))


def signal_to_noise(radar: RadarSettings, level: float, range_m: float) -> float:
    """Of one pulse off a sea of σ0 = `level` by the textbook's equation, with the antenna's gain towards that sea."""
    towards = float(link.gain_towards_sea(radar, range_m))
    return float(link.textbook_power(radar, level, range_m, towards)) / noise_power(radar)


def noise_height_error(radar: RadarSettings, snr: float, range_m: float) -> float:
    """Rms height [m] by thermal noise over the pulses of a dwell: the Cramér–Rao bound of the phase, in metres."""
    coherence, pulses = snr / (1.0 + snr), link.dwell(radar).pulses
    return float(cramer_rao_phase_std(coherence, pulses)) * height_per_radian(radar, range_m)


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
    """Full scale [W]: as given, or what automatic gain makes of the strongest echo [W]."""
    receiver = radar.receiver
    if receiver.gain == "fixed":
        return 1e-3 * float(from_db(receiver.full_scale_dbm))
    return max(strongest_w, noise_power(radar)) * float(from_db(receiver.agc_headroom_db))


def share_beyond(antenna: Antenna, beam_deg: float, beams: float) -> float:
    """Share of a two-way azimuth pattern's power that comes from more than so many beam widths off the boresight."""
    angle = np.linspace(-0.5 * np.pi, 0.5 * np.pi, _ANGLES)
    power = antenna.azimuth(np.sin(angle)) ** 4
    return float(power[np.abs(angle) > np.radians(beams * beam_deg)].sum() / power.sum())


def boat_tilt_at_rest(scene: Scene) -> float:
    """Rms tilt [rad] along the look, the mean over looks, of a boat whose motion does not ask the sea."""
    times = np.linspace(0.0, scene.turns * scene.turn_duration_s, _TIMES)
    attitude = np.radians(boat_motion(scene.platform)(times).attitude[:, :2])
    return float(np.sqrt(0.5 * np.mean(np.sum(attitude**2, axis=1))))


def object_over_sea_db(radar: RadarSettings, rcs_dbsm: float, level: float, range_m: float) -> float:
    """An object's cross-section over that of the sea in its cell, dB."""
    return rcs_dbsm - float(db(level * link.cell_area(radar, range_m)))


def doppler_cycles(radar: RadarSettings, speed_m_s: float) -> float:
    """Cycles by which a speed along the look turns an echo's phase while the beam dwells on it: 2vT/λ."""
    return 2.0 * speed_m_s * link.dwell(radar).duration_s * radar.frequency_hz / SPEED_OF_LIGHT


def speckle_kept(decorrelation_time_s: float, apart_s: float) -> float:
    """Correlation exp(−(τ/τc)²) of speckle so long after."""
    return float(np.exp(-((apart_s / decorrelation_time_s) ** 2)))


def first_antenna(radar: RadarSettings) -> Antenna:
    """That of the first receiver."""
    array = antenna_array(radar)
    return array.elements[array.receivers[0]].antenna
