"""How well a dwell tells phase, height and power: what a radian is worth, thermal noise and speckle in closed form."""

from __future__ import annotations

import numpy as np

from ..conventions import db
from ..physics.phase_noise import cramer_rao_phase_std
from ..settings import RadarSettings
from . import link
from .array import antenna_array


def height_per_radian(radar: RadarSettings, range_m: float) -> float:
    """Height [m] that a radian of interferometric phase is worth at grazing: λR/(2πpB); inf without a baseline."""
    array = antenna_array(radar)
    if array.baseline_m == 0.0:
        return float("inf")
    return link.wavelength(radar) * range_m / (2.0 * np.pi * array.phase_paths * array.baseline_m)


def noise_phase_error(radar: RadarSettings, snr: float) -> float:
    """Rms phase [rad] by thermal noise over the pulses of a dwell: the Cramér–Rao bound, coherence snr/(1 + snr)."""
    return float(cramer_rao_phase_std(snr / (1.0 + snr), link.dwell(radar).pulses))


def noise_height_error(radar: RadarSettings, snr: float, range_m: float) -> float:
    """Rms height [m] by thermal noise over the pulses of a dwell; inf without a baseline."""
    return noise_phase_error(radar, snr) * height_per_radian(radar, range_m)


def looks(radar: RadarSettings, decorrelation_time_s: float) -> float:
    """Independent samples of speckle in a dwell: N²/ΣΣ ρ² of N pulses, ρ = exp(−(τ/τc)²) (Goodman 2007)."""
    dwell = link.dwell(radar)
    return dwell.pulses / link.coherent_gain(dwell.pulses, dwell.interval_s, decorrelation_time_s / np.sqrt(2.0))


def speckle_db(count: float) -> float:
    """Scatter [dB] of a mean of so many independent powers: 1/√looks of it."""
    return float(db(1.0 + 1.0 / np.sqrt(count)))


def doppler_cycles(radar: RadarSettings, speed_m_s: float) -> float:
    """Cycles of phase that a speed along the look makes of a dwell: 2vT/λ."""
    return 2.0 * speed_m_s * link.dwell(radar).duration_s / link.wavelength(radar)
