"""The transmitter: what a magnetron does to the phases of pulses, and what a receiver that measures them leaves of it.

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

import numpy as np

from ..conventions import SPEED_OF_LIGHT
from ..settings import RadarSettings, RetrievalSettings
from .waveform import RangeResponse

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


def stray_within_pulse(radar: RadarSettings) -> float:
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
