"""Watts: the radar equation's constant factor and the receiver's thermal noise; bytes per second of its samples; and
what a magnetron does to the phases of pulses, and what a receiver that measures them leaves of it.

A magnetron starts each pulse with a random phase θ, on a carrier that is δ off its mean f. The receiver mixes the echo,
which comes τ later, with an oscillator that keeps f. In the gate at r, t = 2r/c after the pulse began,

    V ∝ exp(j[θ + 2πδ(t − τ) − 2πfτ]).

θ is common to all receivers and gates. δ turns phases across the length of a pulse alone and not with range: for the
way there and back it is the oscillator's frequency that counts (Shrader & Gregers-Hansen, in Skolnik's Radar Handbook,
2008, on instabilities of transmitter and oscillator). Between two receivers of one pulse t drops out: they see the
wavenumber of the pulse's own carrier, 2π(f + δ)/c.

A receiver that is coherent on receive measures θ as the pulse goes out, and takes it off, with an error ε that is new
at each pulse (such a marine radar: Horstmann et al., Sensors 21(23), 7828, 2021).
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from ..conventions import BOLTZMANN, REFERENCE_TEMPERATURE, SPEED_OF_LIGHT, from_db, radar_wavelength
from ..settings import RadarSettings, RetrievalSettings
from .antenna import antenna
from .array import antenna_array
from .chirp import Chirp
from .waveform import RangeResponse, gate_spacing_m, sample_spacing_m

MOST_STRAY = 0.1  # rad rms across a pulse: it costs a hundredth of the coherence between pulses, which is left out


def measures_phase(radar: RadarSettings) -> bool:
    """Whether there is a random phase, and the receiver takes it off."""
    return radar.transmitter == "magnetron" and radar.coherent_on_receive


def transmit_phase_error(radar: RadarSettings) -> float:
    """Rms error [rad] of the phase that is taken off each pulse; 0 where none is."""
    return float(np.radians(radar.transmit_phase_error_deg)) if measures_phase(radar) else 0.0


def pulse_coherence(radar: RadarSettings) -> float:
    """|⟨exp j(φ − φ′)⟩| of the phases that the transmitter leaves on two pulses: 1 of a coherent one, 0 of a magnetron,
    exp(−σ²) where its phases are taken off with normal errors of σ."""
    if radar.transmitter == "coherent":
        return 1.0
    return float(np.exp(-(transmit_phase_error(radar) ** 2))) if measures_phase(radar) else 0.0


def phase_drift_in_pulse(radar: RadarSettings) -> float:
    """Rms phase [rad] by which the carrier's jitter turns the echo across a pulse, 2πδ(t − τ), τ spread as the echo's
    power is; 0 of a coherent transmitter."""
    if radar.transmitter == "coherent":
        return 0.0
    return 4.0 * np.pi * radar.frequency_jitter_hz / SPEED_OF_LIGHT * RangeResponse.of(radar).spread_m


def comparing_pulses(interferogram: str, retrieval: RetrievalSettings) -> tuple[str, str, str] | None:
    """What is asked for that rests on phases from pulse to pulse: key and value, why, and what to choose instead; None
    if nothing is. interferogram: of the radar."""
    if interferogram == "alternating_pulse":
        return (
            "interferogram = 'alternating_pulse'",
            "its receivers hear different pulses",
            "choose single_pulse",
        )
    if retrieval.coherent_s > 0.0:
        return f"retrieval.coherent_s = {retrieval.coherent_s:g}", "it adds pulses", "set it to 0"
    if retrieval.channels == "from_cross_paths":
        return "retrieval.channels = 'from_cross_paths'", "it compares pulses of two antennas", "choose as_given"
    if retrieval.map_time_s is not None:
        return (
            f"retrieval.map_time_s = {retrieval.map_time_s:g}",
            "velocities tell it which way waves run on",
            "leave it out",
        )
    return None


def amplitude_constant(radar: RadarSettings, gain: float | None = None) -> float:
    """√(Pt G² λ² / ((4π)³ L)) [√W m]: times √(rcs)/(R_tx R_rx) and the patterns it is the echo's voltage.

    gain: geometric mean of the two antennas' gains; left out, that of [radar.antenna].
    """
    wavelength = radar_wavelength(radar.frequency_hz)
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
        return chirp.compress_noise(raw).astype(np.complex64, copy=False)
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


def bytes_of_a_pulse(window_m: float, spacing_m: float, bits: int) -> float:
    """Bytes of one pulse of one receiver: samples of `bits` bits at both ends of the window [m] and between."""
    return (int(np.floor(window_m / spacing_m + 1e-9)) + 1) * bits / 8.0
