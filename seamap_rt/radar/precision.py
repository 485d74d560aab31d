"""How well a dwell tells phase, height and power: what a radian is worth, thermal noise and speckle in closed form."""

from __future__ import annotations

import numpy as np
from numpy.typing import ArrayLike, NDArray

from ..conventions import db, radar_wavelength
from ..settings import RadarSettings
from . import link
from .array import antenna_array


def cramer_rao_phase_std(coherence: ArrayLike, looks: ArrayLike) -> NDArray[np.float64]:
    """Least standard deviation [rad] of a phase of coherence γ over N independent looks: √((1 − γ²)/(2N))/γ.

    Rodríguez & Martin, IEE Proc. F 139(2), 147–159 (1992). The arguments broadcast; infinite at γ = 0. ValueError for
    coherences outside of 0 to 1 and fewer looks than 1.
    """
    gamma, count = np.asarray(coherence, dtype=np.float64), np.asarray(looks, dtype=np.float64)
    if not (np.all((gamma >= 0.0) & (gamma <= 1.0)) and np.all(count >= 1.0)):
        raise ValueError("coherence must lie within 0 to 1, and looks must be at least 1")
    with np.errstate(divide="ignore"):
        return np.sqrt((1.0 - gamma) * (1.0 + gamma) / (2.0 * count)) / gamma


def height_per_radian(radar: RadarSettings, range_m: float) -> float:
    """Height [m] that a radian of interferometric phase is worth at grazing: λR/(2πpB); inf without a baseline."""
    array = antenna_array(radar)
    if array.baseline_m == 0.0:
        return float("inf")
    return radar_wavelength(radar.frequency_hz) * range_m / (2.0 * np.pi * array.phase_paths * array.baseline_m)


def noise_phase_error(radar: RadarSettings, snr: float) -> float:
    """Rms phase [rad] by thermal noise over the pulses of a dwell: the Cramér–Rao bound, coherence snr/(1 + snr)."""
    return float(cramer_rao_phase_std(snr / (1.0 + snr), link.dwell(radar).pulses))


def noise_height_error(radar: RadarSettings, snr: float, range_m: float) -> float:
    """Rms height [m] by thermal noise over the pulses of a dwell; inf without a baseline."""
    return noise_phase_error(radar, snr) * height_per_radian(radar, range_m)


def pair_height_error(radar: RadarSettings, phase_error: float, range_m: float) -> float:
    """Rms height [m] of a look as a whole, by pulses that are compared and were sent with phases that err by
    phase_error [rad], new at each: √(2/N) of it for N pulses of either receiver in a dwell; inf without a baseline.

    Where both receivers hear all and each antenna is compared on itself, half of the pulses count, of twice the phase.
    """
    both_ways = np.sqrt(0.5) if antenna_array(radar).whole else 1.0
    return both_ways * phase_error * np.sqrt(2.0 / link.dwell(radar).pulses) * height_per_radian(radar, range_m)


def carrier_height_error(radar: RadarSettings) -> float:
    """Rms height [m] by a magnetron's carrier, whose wavelength the retrieval takes for the mean one: h δ/f of the
    antenna's height over the sea, over the root of the pulses of a dwell, whatever the range and the baseline."""
    jitter = radar.frequency_jitter_hz if radar.transmitter == "magnetron" else 0.0
    return radar.height_m * jitter / radar.frequency_hz / np.sqrt(link.dwell(radar).pulses)


def looks(radar: RadarSettings, decorrelation_time_s: float) -> float:
    """Independent samples of speckle in a dwell: N²/ΣΣ ρ² of N pulses, ρ = exp(−(τ/τc)²) (Goodman 2007)."""
    dwell = link.dwell(radar)
    return dwell.pulses / link.coherent_gain(dwell.pulses, dwell.interval_s, decorrelation_time_s / np.sqrt(2.0))


def speckle_db(count: float) -> float:
    """Scatter [dB] of a mean of so many independent powers: 1/√looks of it."""
    return float(db(1.0 + 1.0 / np.sqrt(count)))


def doppler_cycles(radar: RadarSettings, speed_m_s: float) -> float:
    """Cycles of phase that a speed along the look makes of a dwell: 2vT/λ."""
    return 2.0 * speed_m_s * link.dwell(radar).duration_s / radar_wavelength(radar.frequency_hz)
