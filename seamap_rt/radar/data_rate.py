"""Bytes per second of what the radar hears: the converters' samples, and the gates made of them."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from ..conventions import SPEED_OF_LIGHT
from ..settings import RadarSettings
from .array import antenna_array
from .waveform import gate_spacing_m

CLAIM = 32e6  # B/s, printed by the design study of 2004 for 10 kHz over 400 m
_CLAIM_TOLERANCE = 0.03  # one gate or sample more or less, and a rounded figure
_CLAIM_WINDOW_M, _CLAIM_PRF_HZ = 400.0, 10e3


class DataRate(NamedTuple):
    """Mean bytes per second, all receivers that a pulse samples together, bits packed without gaps."""

    raw: float  # the converters' real samples of adc_bits
    complex_12: float  # gates, I and Q of so many bits each
    complex_16: float
    complex_24: float
    complex_32: float  # complex64


class Reading(NamedTuple):
    """One way to read the study's figure."""

    receivers: int
    sampling: str
    bits: int  # of one sample, I and Q together
    bytes_per_second: float

    @property
    def fits(self) -> bool:
        """Whether it gives what the study printed, within 3 %."""
        return abs(self.bytes_per_second / CLAIM - 1.0) <= _CLAIM_TOLERANCE


def data_rate(radar: RadarSettings, near_m: float | None = None) -> DataRate:
    """Rates over the range window at the PRF; near_m [m] moves the window's near end (0: from the antenna on)."""
    near = radar.range_m[0] if near_m is None else near_m
    window, receivers = radar.range_m[1] - near, sampled_receivers(radar)
    raw = _bytes(window, _spacing(radar.receiver.adc_rate_hz), radar.receiver.adc_bits)
    gates = [_bytes(window, gate_spacing_m(radar), 2 * bits) for bits in (12, 16, 24, 32)]
    return DataRate(*(radar.prf_hz * receivers * each for each in (raw, *gates)))


def sampled_receivers(radar: RadarSettings) -> int:
    """How many receivers each pulse samples: one in turn with alternating pulses, else every antenna that receives."""
    return len(antenna_array(radar).cycle[0].receivers)


def claim_data_rate() -> list[Reading]:
    """The readings of the study's 32 MB/s: which samples, of how many bits, of one receiver or both, 0 to 400 m.

    Among them is the converter's full rate as complex samples, which holds nothing that real ones do not.
    """
    kinds = [("real 200 MS/s", 200e6, bits) for bits in (12, 16)]
    kinds += [(f"complex {rate} MS/s", 1e6 * rate, 2 * bits) for rate in (50, 100, 200) for bits in (12, 16, 24, 32)]
    return [
        Reading(receivers, sampling, bits, receivers * _CLAIM_PRF_HZ * _bytes(_CLAIM_WINDOW_M, _spacing(rate), bits))
        for receivers in (1, 2)
        for sampling, rate, bits in kinds
    ]


def _spacing(rate_hz: float) -> float:
    return 0.5 * SPEED_OF_LIGHT / rate_hz


def _bytes(window_m: float, spacing_m: float, bits: int) -> float:
    """Bytes of one pulse of one receiver: samples at both ends of the window and between."""
    return (int(np.floor(window_m / spacing_m + 1e-9)) + 1) * bits / 8.0
