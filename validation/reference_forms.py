"""What the judges know of the radar without the code that they judge: the gain of a pattern, the echo of a point.

Both by sums of their own over what is set: the aperture's pattern over the half sphere ahead, and the transform of the
transmitted pulse through the receiver's Gaussian filter of noise bandwidth B, |H(f)|² = exp(−πf²/B²).
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from seamap_rt.conventions import SPEED_OF_LIGHT
from seamap_rt.radar.antenna import Antenna
from seamap_rt.settings import RadarSettings

Array = NDArray[np.float64]

_AZIMUTHS, _ELEVATIONS = 6001, 601  # a lobe of the azimuth pattern is some 1.7° wide
_SHARE = 1 / 256  # of the shorter of the pulse and 1/B: the step in time


def directivity(antenna: Antenna) -> float:
    """4π over ∬ |V/V₀|² cos ε dε dα of the half sphere ahead, a ratio; V₀ the voltage on boresight."""
    azimuth = np.linspace(-0.5 * np.pi, 0.5 * np.pi, _AZIMUTHS)
    elevation = np.linspace(-0.5 * np.pi, 0.5 * np.pi, _ELEVATIONS)
    peak = float(antenna.voltage(np.zeros(1), np.zeros(1))[0])
    across = np.array(
        [np.trapezoid((antenna.voltage(azimuth, np.full(azimuth.shape, up)) / peak) ** 2, azimuth) for up in elevation]
    )
    return float(4.0 * np.pi / np.trapezoid(across * np.cos(elevation), elevation))


def pulse_response(radar: RadarSettings, offset_m: Array) -> Array:
    """Voltage of a gate by a point `offset_m` [m] away in range, 1 for a pulse that the filter leaves alone."""
    step = _SHARE * min(radar.pulse_width_s, 1.0 / radar.bandwidth_hz)
    count = int(2 ** np.ceil(np.log2((2.0 * radar.pulse_width_s + 8.0 / radar.bandwidth_hz) / step)))
    time = step * (np.arange(count) - count // 2)
    # Each sample stands for its step: those on the edges count as far as the pulse fills them.
    sent = np.clip((0.5 * radar.pulse_width_s - np.abs(time)) / step + 0.5, 0.0, 1.0)
    frequency = np.fft.rfftfreq(count, step)
    passed = np.fft.irfft(np.fft.rfft(sent) * np.exp(-0.5 * np.pi * (frequency / radar.bandwidth_hz) ** 2), count)
    return np.interp(2.0 * np.asarray(offset_m) / SPEED_OF_LIGHT, time, passed)


def half_power_width(radar: RadarSettings) -> float:
    """m, between the points at which the power of `pulse_response` has fallen to half its peak."""
    reach = 0.5 * SPEED_OF_LIGHT * (0.5 * radar.pulse_width_s + 2.0 / radar.bandwidth_hz)
    offset = np.linspace(0.0, reach, 20_001)
    power = pulse_response(radar, offset) ** 2
    below = int(np.argmax(power < 0.5 * power[0]))
    return float(2.0 * np.interp(0.5 * power[0], power[below : below - 2 : -1], offset[below : below - 2 : -1]))
