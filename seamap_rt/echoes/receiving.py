"""From the voltages at the antennas' ports to what the receivers give: a magnetron's phases, channels, noise, and the
converter.

Of `radar.transmitter`'s phase 2πδ(t − τ), with τ the delay of each facet, that of mean sea level in the middle of the
gate is taken, for each path of its own. Between receivers it errs by (δ/f) k ΔR(z) of heights z, 1e-5 of the phase that
they make. What differs between the facets of a gate, `phase_drift_in_pulse`, is left out, and kept below 0.1 rad.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from .. import random_streams
from ..compute.compiled import compiled
from ..compute.machine import pool
from ..conventions import db, ground_range, radar_wavenumber
from ..radar.digital import DigitalReceiver
from ..radar.installation import Installation
from ..radar.receiver import measures_phase, noise_power, noise_taps, thermal_noise, transmit_phase_error
from ..radar.scan import Pulses, phase_centres
from ..radar.waveform import gate_spacing_m
from ..random_streams import Stream
from ..settings import RadarSettings
from .response import received_samples
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
        """The magnetron of a radar; None for a coherent transmitter."""
        if radar.transmitter == "coherent":
            return None
        keys = [random_streams.key(seed, Stream.TRANSMITTER, member) for member in (_PHASE, _CARRIER, _ERROR)]
        turns, carrier, error = _draw_transmitter_errors(np.array(keys), pulses.number)
        phase = 2.0 * np.pi * turns
        measured = phase + transmit_phase_error(radar) * error if measures_phase(radar) else None
        return cls(phase, radar.frequency_jitter_hz * carrier, measured)

    def send(
        self,
        voltages: NDArray[np.complex64],
        installation: Installation,
        pulses: Pulses,
        range_m: NDArray[np.float64],
    ) -> None:
        """Turn voltages (pulse, receiver, sample) of echoes alone, in place; range_m (sample,)."""
        array, excess = installation.array, excess_m(installation.radar, range_m)
        senders = np.array([slot.transmitter for slot in array.cycle])
        longer = excess[senders][:, None] + excess[list(array.receivers)][None]  # (slot, receiver, sample) m
        rate = -radar_wavenumber(self.carrier)  # rad per metre
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
    ahead = ground_range(range_m, radar.height_m)
    sea = np.stack((0.0 * ahead, ahead, 0.0 * ahead), axis=-1)
    middle = antennas.mean(axis=0)
    return np.linalg.norm(sea - antennas[:, None], axis=-1) - np.linalg.norm(sea - middle, axis=-1)


@compiled
def _draw_transmitter_errors(keys, number):
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


_NOISE_CHUNK = 1000  # pulses
_NOISE_SAMPLE_SEED = 3  # of the sample by which a receiver's own noise is measured, the same for every run


class ReceivedTurn(NamedTuple):
    """What is recorded of a turn."""

    voltage: NDArray[np.complex64]  # (pulse, receiver, gate) √W
    saturated: NDArray[np.bool_] | None  # (pulse, gate) of any receiver; None where nothing can saturate
    full_scale_w: float | None = None  # W of a sine, the median over the pulses; None without a converter


def receive(
    voltages: NDArray[np.complex64],
    installation: Installation,
    pulses: Pulses,
    seed: int,
    objects: NDArray[np.complex64] | None = None,
) -> ReceivedTurn:
    """Pass voltages (pulse, receiver, sample) [√W] at the antennas' ports through the receivers: the phases that a
    magnetron sent them with, thermal noise, channels, and the converter of a digital one. They are changed in place.

    seed: the scene's, of the noise and of the magnetron; objects: voltages of the scene's objects, of the same shape,
    added first.
    """
    if objects is not None:
        voltages += objects
    sent = Magnetron.of(installation.radar, pulses, seed)
    if sent is not None:
        sent.send(voltages, installation, pulses, received_samples(installation.radar).range)
    received = _received(voltages, installation, pulses, seed)
    if sent is not None:
        sent.take_off(received.voltage)
    return received


def _received(voltages: NDArray[np.complex64], installation: Installation, pulses: Pulses, seed: int) -> ReceivedTurn:
    radar, array = installation.radar, installation.array
    digital = DigitalReceiver(radar) if radar.receiver.chain == "digital" else None
    if radar.noise:
        spacing = None if digital is None else float(np.diff(digital.sample_range[:2])[0])
        add_noise(voltages, radar, pulses, seed, spacing)
    for receiver, antenna in enumerate(array.receivers):  # a channel's gain is its own noise's too
        if array.elements[antenna].channel != 1.0:
            voltages[:, receiver] *= np.complex64(array.elements[antenna].channel)
    if digital is None:
        return ReceivedTurn(voltages, None)
    silent = np.isnan(voltages[..., 0].real)  # receivers that the mode does not sample on a pulse
    voltages[silent] = 0.0
    digitised = digital(voltages)
    digitised.voltage[silent] = np.nan
    saturated = np.asarray(digitised.saturated.any(axis=1))
    return ReceivedTurn(digitised.voltage, saturated, float(np.median(digitised.full_scale)))


def gate_noise_power(installation: Installation, full_scale_w: float | None = None) -> float:
    """Mean noise power [W] of one gate as it is recorded: thermal, and the converter's own at the full scale [W] that
    automatic gain has set (left out, the scene's).

    The converter's is measured on noise alone: where its steps are coarse no formula holds (with one bit noise comes
    out as strong as the full scale).
    """
    radar, array = installation.radar, installation.array
    if not radar.noise:
        return 0.0
    channels = float(np.mean([abs(array.elements[antenna].channel) ** 2 for antenna in array.receivers[:2]]))
    if radar.receiver.chain != "digital":
        return channels * noise_power(radar)
    if full_scale_w is not None:
        level = {"full_scale_dbm": float(db(1e3 * full_scale_w)), "gain": "fixed"}
        radar = radar.model_copy(update={"receiver": radar.receiver.model_copy(update=level)})
    return channels * _measured_noise(radar)


def _measured_noise(radar: RadarSettings) -> float:
    digital, pulses = DigitalReceiver(radar), 1000
    spacing = float(np.diff(digital.sample_range[:2])[0])
    count = digital.sample_range.size
    noise = thermal_noise(radar, pulses, count, np.random.default_rng(_NOISE_SAMPLE_SEED), 1, spacing)
    voltage = digital(noise).voltage
    return float(np.mean(np.square(np.abs(voltage), dtype=np.float64)))


def add_noise(
    voltages: NDArray[np.complex64],
    radar: RadarSettings,
    pulses: Pulses,
    seed: int,
    spacing_m: float | None = None,
) -> None:
    """Add thermal noise in place; every pulse and receiver has random numbers of its own.

    spacing_m: between the samples; left out, that of the gates.
    """
    first = int(pulses.number[0])
    if radar.waveform == "chirp":  # noise goes through the compression too
        _add_compressed_noise(voltages, radar, first, seed)
        return
    key = random_streams.key(seed, Stream.NOISE)
    taps = noise_taps(radar, spacing_m or gate_spacing_m(radar), voltages.shape[2]).astype(np.float32)

    def add(start: int) -> None:
        _add_filtered_noise(voltages[start : start + _NOISE_CHUNK], taps, key, first + start)

    with pool() as workers:
        list(workers.map(add, range(0, voltages.shape[0], _NOISE_CHUNK)))


def _add_compressed_noise(voltages: NDArray[np.complex64], radar: RadarSettings, first: int, seed: int) -> None:
    def add(start: int) -> None:
        chunk = voltages[start : start + _NOISE_CHUNK]
        random = np.random.default_rng(random_streams.branch(seed, Stream.NOISE, first + start))
        chunk += thermal_noise(radar, chunk.shape[0], chunk.shape[2], random, chunk.shape[1])

    with pool() as workers:
        list(workers.map(add, range(0, voltages.shape[0], _NOISE_CHUNK)))


@compiled
def _add_filtered_noise(voltages, taps, key, first):
    """Add noise to voltages (pulse, receiver, sample), the first of them that of pulse `first`; taps (2n + 1,) √W."""
    samples = voltages.shape[2]
    whole = samples + taps.size - 1
    bits, real, imag = np.empty(whole, np.uint64), np.empty(whole, np.float32), np.empty(whole, np.float32)
    x, y = np.empty(samples, np.float32), np.empty(samples, np.float32)
    for pulse in range(voltages.shape[0]):
        for receiver in range(voltages.shape[1]):
            draw(key_of(key_of(key, first + pulse), receiver), bits, real, imag)
            x[:], y[:] = np.float32(0.0), np.float32(0.0)
            for tap in range(taps.size):
                for n in range(samples):
                    x[n] += taps[tap] * real[n + tap]
                    y[n] += taps[tap] * imag[n + tap]
            for n in range(samples):
                voltages[pulse, receiver, n] += complex(x[n], y[n])
