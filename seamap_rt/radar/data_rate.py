"""Bytes per second of what the radar hears: the converters' samples, and the gates made of them."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from ..conventions import SPEED_OF_LIGHT
from ..settings import RadarSettings
from .array import antenna_array
from .waveform import gate_spacing_m


class DataRate(NamedTuple):
    """Mean bytes per second, all receivers that a pulse samples together, bits packed without gaps."""

    raw: float  # the converters' real samples of adc_bits
    complex_12: float  # gates, I and Q of so many bits each
    complex_16: float
    complex_24: float
    complex_32: float  # complex64


def data_rate(radar: RadarSettings, near_m: float | None = None) -> DataRate:
    """Rates over the range window at the PRF; near_m [m] moves the window's near end (0: from the antenna on)."""
    near = radar.range_m[0] if near_m is None else near_m
    window, receivers = radar.range_m[1] - near, sampled_receivers(radar)
    raw = bytes_of_a_pulse(window, sample_spacing_m(radar.receiver.adc_rate_hz), radar.receiver.adc_bits)
    gates = [bytes_of_a_pulse(window, gate_spacing_m(radar), 2 * bits) for bits in (12, 16, 24, 32)]
    return DataRate(*(radar.prf_hz * receivers * each for each in (raw, *gates)))


def sampled_receivers(radar: RadarSettings) -> int:
    """How many receivers each pulse samples: one in turn with alternating pulses, else every antenna that receives."""
    return len(antenna_array(radar).cycle[0].receivers)


def sample_spacing_m(rate_hz: float) -> float:
    """Metres of range between samples at a rate [Hz]."""
    return 0.5 * SPEED_OF_LIGHT / rate_hz


def bytes_of_a_pulse(window_m: float, spacing_m: float, bits: int) -> float:
    """Bytes of one pulse of one receiver: samples of `bits` bits at both ends of the window [m] and between."""
    return (int(np.floor(window_m / spacing_m + 1e-9)) + 1) * bits / 8.0
