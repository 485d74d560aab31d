"""What a magnetron puts to the voltages of each pulse: its starting phase, and its carrier's wavenumber.

Of `radar.transmitter`'s phase 2πδ(t − τ), with τ the delay of each facet, that of mean sea level in the middle of the
gate is taken, for each path of its own. Between receivers it errs by (δ/f) k ΔR(z) of heights z, 1e-5 of the phase that
they make. What differs between the facets of a gate, `stray_within_pulse`, is left out, and kept below 0.1 rad.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from .. import random_streams
from ..compute.compiled import compiled
from ..compute.machine import pool
from ..conventions import SPEED_OF_LIGHT
from ..radar.array import antenna_array
from ..radar.scan import Pulses, phase_centres
from ..radar.transmitter import measures_phase, transmit_phase_error
from ..random_streams import Stream
from ..settings import RadarSettings
from .summation.gaussian import draw, key_of

_PHASE, _CARRIER, _ERROR = range(3)  # members of the stream
_CHUNK = 1000  # pulses


@dataclass(frozen=True)
class Magnetron:
    """What the pulses of a turn are sent with; arrays (pulse,), of pulses' numbers and the scene's seed alone."""

    phase: NDArray[np.float64]  # rad, in which each starts
    carrier: NDArray[np.float64]  # Hz, off the mean
    measured: NDArray[np.float64] | None  # rad, the phase as the receiver has it; None where it does not measure

    @classmethod
    def of(cls, radar: RadarSettings, pulses: Pulses, seed: int) -> Magnetron | None:
        """None of a coherent transmitter."""
        if radar.transmitter == "coherent":
            return None
        keys = [random_streams.key(seed, Stream.TRANSMITTER, member) for member in (_PHASE, _CARRIER, _ERROR)]
        turns, carrier, error = _drawn(np.array(keys), pulses.number)
        phase = 2.0 * np.pi * turns
        measured = phase + transmit_phase_error(radar) * error if measures_phase(radar) else None
        return cls(phase, radar.frequency_jitter_hz * carrier, measured)

    def send(
        self,
        voltages: NDArray[np.complex64],
        radar: RadarSettings,
        pulses: Pulses,
        range_m: NDArray[np.float64],
    ) -> None:
        """Turn voltages (pulse, receiver, sample) of echoes alone, in place; range_m (sample,)."""
        array, excess = antenna_array(radar), excess_m(radar, range_m)
        senders = np.array([slot.transmitter for slot in array.cycle])
        longer = excess[senders][:, None] + excess[list(array.receivers)][None]  # (slot, receiver, sample) m
        rate = -2.0 * np.pi * self.carrier / SPEED_OF_LIGHT  # rad per metre
        slot = pulses.slot.astype(np.intp)

        def work(start: int) -> None:
            rows = slice(start, start + _CHUNK)
            _turn(voltages[rows], self.phase[rows], rate[rows], slot[rows], longer)

        with pool() as workers:
            list(workers.map(work, range(0, len(voltages), _CHUNK)))

    def take_off(self, voltages: NDArray[np.complex64]) -> None:
        """Turn voltages (pulse, receiver, gate), noise and all, back by the measured phase, in place."""
        if self.measured is not None:
            voltages *= np.exp(-1j * self.measured).astype(np.complex64)[:, None, None]


def excess_m(radar: RadarSettings, range_m: NDArray[np.float64]) -> NDArray[np.float64]:
    """By how much (antenna, range) [m] each antenna is farther than the array's middle from mean sea level at ranges
    (range,) from that middle: by which a carrier's wavenumber counts between receivers."""
    antennas = phase_centres(radar, np.zeros(1))[0]
    ahead = np.sqrt(np.maximum(range_m**2 - radar.height_m**2, 0.0))
    sea = np.stack((0.0 * ahead, ahead, 0.0 * ahead), axis=-1)
    middle = antennas.mean(axis=0)
    return np.linalg.norm(sea - antennas[:, None], axis=-1) - np.linalg.norm(sea - middle, axis=-1)


@compiled
def _drawn(keys, number):
    """(3, pulse): uniform numbers in [0, 1), and two normal ones of unit variance, each of its key and the number."""
    out = np.empty((3, number.size))
    bits, real, imag = np.empty(1, np.uint64), np.empty(1, np.float32), np.empty(1, np.float32)
    for n in range(number.size):
        out[0, n] = np.float64(key_of(keys[0], number[n]) >> np.uint64(11)) * 2.0**-53
        for member in range(1, 3):
            draw(key_of(keys[member], number[n]), bits, real, imag)
            out[member, n] = np.sqrt(2.0) * real[0]
    return out


@compiled
def _turn(voltages, phase, rate, slot, longer):
    for pulse in range(voltages.shape[0]):
        for receiver in range(voltages.shape[1]):
            metres = longer[slot[pulse], receiver]
            if rate[pulse] == 0.0:
                whole = np.complex64(complex(np.cos(phase[pulse]), np.sin(phase[pulse])))
                for n in range(voltages.shape[2]):
                    voltages[pulse, receiver, n] *= whole
            else:
                for n in range(voltages.shape[2]):
                    angle = phase[pulse] + rate[pulse] * metres[n]
                    voltages[pulse, receiver, n] *= np.complex64(complex(np.cos(angle), np.sin(angle)))
