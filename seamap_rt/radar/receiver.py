"""Watts: the radar equation's constant factor and the receiver's thermal noise; and bytes per second of its samples."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from ..conventions import BOLTZMANN, REFERENCE_TEMPERATURE, SPEED_OF_LIGHT, from_db
from ..settings import RadarSettings
from .antenna import antenna
from .array import antenna_array
from .chirp import Chirp
from .waveform import RangeResponse, gate_spacing_m


def amplitude_constant(radar: RadarSettings, gain: float | None = None) -> float:
    """√(Pt G² λ² / ((4π)³ L)) [√W m]: times √(rcs)/(R_tx R_rx) and the patterns it is the echo's voltage.

    gain: geometric mean of the two antennas' gains; left out, that of [radar.antenna].
    """
    wavelength = SPEED_OF_LIGHT / radar.frequency_hz
    loss = float(from_db(radar.losses_db))
    gain = antenna(radar).gain if gain is None else gain
    return float(np.sqrt(radar.transmit_power_w * gain**2 * wavelength**2 / ((4.0 * np.pi) ** 3 * loss)))


def noise_power(radar: RadarSettings) -> float:
    """kTBF [W], the mean thermal noise power of one gate of one receiver."""
    return BOLTZMANN * REFERENCE_TEMPERATURE * radar.bandwidth_hz * float(from_db(radar.noise_figure_db))


def thermal_noise(
    radar: RadarSettings,
    pulses: int,
    gates: int,
    random: np.random.Generator,
    receivers: int = 2,
    spacing_m: float | None = None,
) -> NDArray[np.complex64]:
    """Noise voltages (pulses, receivers, gates): complex Gaussian, independent from pulse to pulse and receiver to
    receiver, correlated along the gates as the receiver's filter makes it when they lie closer than its resolution.

    spacing_m: of the gates, if it is another than the radar's.
    """
    if radar.waveform == "chirp":
        chirp = Chirp(radar)
        raw = _filtered_noise(radar, (pulses, receivers, chirp.samples), gate_spacing_m(radar), random)
        return chirp.of_noise(raw).astype(np.complex64, copy=False)
    return _filtered_noise(radar, (pulses, receivers, gates), spacing_m or gate_spacing_m(radar), random)


def _filtered_noise(
    radar: RadarSettings, shape: tuple[int, int, int], spacing_m: float, random: np.random.Generator
) -> NDArray[np.complex64]:
    """Noise behind the receiver's own filter, whose samples are `spacing_m` apart."""
    gates = shape[-1]
    white = random.standard_normal((*shape, 2), dtype=np.float32).view(np.complex64)[..., 0] * np.float32(np.sqrt(0.5))
    taps = noise_taps(radar, spacing_m, gates)
    reach = taps.size // 2
    padded = np.concatenate((white[..., gates - reach :], white, white[..., :reach]), axis=-1)
    mixed = np.zeros_like(white)
    for shift, tap in enumerate(taps):
        mixed += np.float32(tap) * padded[..., shift : shift + gates]
    return mixed


def noise_taps(radar: RadarSettings, spacing_m: float, gates: int) -> NDArray[np.float64]:
    """Taps (2n + 1,) [√W] of the filter, along gates `spacing_m` apart, that makes a receiver's noise of white complex
    noise of unit power."""
    plain = RangeResponse(radar.pulse_width_s, radar.bandwidth_hz)
    correlation = plain.noise_correlation(spacing_m * np.arange(gates))
    reach = int(np.count_nonzero(correlation > 1e-7))
    taps = _colouring_taps(correlation[:reach]) if reach > 1 else np.ones(1)
    return taps * np.sqrt(noise_power(radar))


def _colouring_taps(correlation: NDArray[np.float64]) -> NDArray[np.float64]:
    """Symmetric taps whose autocorrelation is the given one: the square root of its spectrum, back in lags."""
    reach = correlation.size
    lags = np.zeros(64 * reach)
    lags[:reach] = correlation
    lags[-(reach - 1) :] = correlation[1:][::-1]
    root = np.sqrt(np.maximum(np.fft.fft(lags).real, 0.0))
    taps = np.fft.ifft(root).real
    taps = np.concatenate((taps[-(reach - 1) :], taps[:reach]))
    return taps / np.sqrt(np.sum(taps**2))


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
