"""The digital receiver: converters sample the intermediate frequency, and arithmetic makes complex gates of it.

The converter takes fewer samples than the carrier has cycles. Sampling folds the spectrum at every multiple of half the
rate: in an odd Nyquist zone the band comes down as it is, in an even one mirrored, every phase with its sign turned
(Vaughan, Scott & White 1991). A numerically controlled oscillator brings the alias to zero, a conjugation turns the
phases back, a low-pass filter removes the image, and every D-th sample is a gate.

The sensitivity-time control is taken back sample by sample, before the low-pass: what is left of the signal then is
that of the linear chain, `ideal`, and to it come the converter's noise and the image: the conjugate of what the
receiver's Gaussian skirts let through from beyond the zone's edge.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass
from typing import NamedTuple

import numpy as np
from numpy.typing import ArrayLike, NDArray

from ..compute.machine import one_blas_thread, pool
from ..conventions import SPEED_OF_LIGHT, db, from_db
from ..settings import RadarSettings
from .array import antenna_array
from .receiver import noise_power
from .waveform import sample_spacing_m

_STOP_BAND_DB = 60.0  # the image of an echo's middle then turns its phase by 1e-3 rad at most
_PASS_SHARE = 2.0 / 3.0  # of the stop band's edge
_MAIN_WEIGHT = 0.1  # of the largest: a gate whose weights above this meet a clipped sample is saturated
_GATES = 32  # worked on at a time: enough for the matrix product, few enough for its zeros not to cost more
_PULSES = 128  # likewise: a chunk's samples stay near the cache


class DigitalGates(NamedTuple):
    """What the digital receiver hands on."""

    voltage: NDArray[np.complex64]  # (pulse, receiver, gate) √W, referred to the antenna
    saturated: NDArray[np.bool_]  # (pulse, receiver, gate)
    full_scale: NDArray[np.float64]  # (pulse,) W of a full-scale sine, both receivers alike


@dataclass(frozen=True)
class NyquistZone:
    """Where sampling brings the intermediate frequency. Zone n reaches from (n − 1)/2 to n/2 of the sampling rate."""

    number: int
    alias_hz: float  # between 0 and half the converter's rate
    room_hz: float  # from the intermediate frequency to the nearer edge of its zone

    @property
    def mirrored(self) -> bool:
        """Whether frequencies run backwards: then phases have the wrong sign."""
        return self.number % 2 == 0

    @classmethod
    def of(cls, radar: RadarSettings) -> NyquistZone:
        """Raises ValueError if if_hz ± bandwidth_hz/2 does not lie within one zone."""
        settings, half = radar.receiver, 0.5 * radar.receiver.adc_rate_hz
        number = int(settings.if_hz // half) + 1
        low, high, band = (number - 1) * half, number * half, 0.5 * radar.bandwidth_hz
        room = min(settings.if_hz - low, high - settings.if_hz)
        if room < band * (1.0 - 1e-9):
            remedy = f"choose {_mhz(low + band)} to {_mhz(high - band)}"
            if half < radar.bandwidth_hz:
                remedy = f"raise adc_rate_hz to at least {_mhz(2.0 * radar.bandwidth_hz)}"
            raise ValueError(
                f"radar.receiver.if_hz = {settings.if_hz:g}: must be at least half of bandwidth_hz, {_mhz(band)}, "
                f"inside its Nyquist zone, {_mhz(low)} to {_mhz(high)}, or the band folds onto itself; {remedy}"
            )
        alias = settings.if_hz - low if number % 2 else high - settings.if_hz
        return cls(number, alias, room)


def decimation(radar: RadarSettings) -> int:
    """D: every D-th of the converter's samples is a gate, which brings gates nearest to range_sampling_m apart."""
    return max(1, round(2.0 * radar.range_sampling_m * radar.receiver.adc_rate_hz / SPEED_OF_LIGHT))


def low_pass(radar: RadarSettings) -> NDArray[np.float64]:
    """Taps (an odd number) of the filter before decimation: a sinc in the window of Kaiser (1974), 1 at zero frequency.

    What decimation folds comes from beyond 0.6 of the gates' rate into no more than the transition: the pass band is as
    wide as that allows. The zone's edge is a limit too: the band's image begins there, and the converter's offset lies
    on it. Raises ValueError as NyquistZone.of does.
    """
    rate = radar.receiver.adc_rate_hz
    stop = min(0.6 * rate / decimation(radar), NyquistZone.of(radar).room_hz)
    transition = (1.0 - _PASS_SHARE) * stop / rate  # cycles a sample
    cut = 0.5 * (1.0 + _PASS_SHARE) * stop / rate
    half = int(np.ceil(0.5 * (_STOP_BAND_DB - 7.95) / (2.285 * 2.0 * np.pi * transition)))
    number = np.arange(-half, half + 1)
    taps = np.sinc(2.0 * cut * number) * np.kaiser(number.size, 0.1102 * (_STOP_BAND_DB - 8.7))
    return taps / taps.sum()


def sensitivity_time_control(radar: RadarSettings, range_m: ArrayLike) -> NDArray[np.float64]:
    """Voltage gain, at most 1, by slant range [m], any shape. From the near end of the window inwards it stays."""
    settings = radar.receiver
    share = np.maximum(np.asarray(range_m, dtype=np.float64), radar.range_m[0]) / settings.stc_range_m
    return np.minimum(share, 1.0) ** (0.5 * settings.stc_exponent)


def quantise(
    samples: NDArray[np.float32], full_scale: NDArray[np.float64], bits: int
) -> tuple[NDArray[np.float32], NDArray[np.bool_]]:
    """Samples (pulse, …) √W as the converter gives them, and which of them it clipped; full_scale (pulse,) W.

    Full scale is a sine's: its amplitude is √2 times the root of its power. Mid-rise: 2^bits levels, alike to either
    side of zero, thresholds at whole steps. So one bit is a comparator, which keeps phases, and an echo below one step
    is not lost. What it gives for no input, half a step, is an offset, and lies in the low-pass's stop band.
    """
    shape = (-1,) + (1,) * (samples.ndim - 1)
    step = quantisation_step(full_scale, bits).astype(np.float32).reshape(shape)
    top = np.float32(2 ** (bits - 1))
    code = samples / step
    np.floor(code, out=code)
    clipped = (code < -top) | (code >= top)
    np.clip(code, -top, top - 1, out=code)
    code += np.float32(0.5)
    code *= step
    return code, clipped


def quantisation_step(full_scale: ArrayLike, bits: int) -> NDArray[np.float64]:
    """The converter's step [√W] for a full-scale sine of `full_scale` W."""
    return 2.0 * np.sqrt(2.0 * np.asarray(full_scale, dtype=np.float64)) / 2.0**bits


def full_scale_w(radar: RadarSettings, strongest_w: ArrayLike) -> NDArray[np.float64]:
    """Full scale of a sine [W], of strongest_w's shape: as given, or agc_headroom_db above the strongest echo [W].

    A gain has an end: nothing counts less than kTBF.
    """
    settings, strongest = radar.receiver, np.asarray(strongest_w, dtype=np.float64)
    if settings.gain == "fixed":
        return np.full(strongest.shape, 1e-3 * float(from_db(settings.full_scale_dbm)))
    return np.fmax(strongest, noise_power(radar)) * float(from_db(settings.agc_headroom_db))


def quantisation_db(radar: RadarSettings, full_scale: float) -> float:
    """The converter's noise in a gate over the thermal one [dB]: q²/12 (Bennett 1948), as much as the low-pass leaves.

    full_scale: of a sine [W]; −6.02 dB with each bit. A sensitivity-time control raises it near by, as
    `DigitalReceiver.quantisation_noise_power` tells. Raises ValueError as NyquistZone.of does.
    """
    step = float(quantisation_step(full_scale, radar.receiver.adc_bits))
    # A real sample's noise is white, of which an envelope of twice its power keeps what passes the filter.
    noise_gain = 2.0 * float(np.sum(low_pass(radar) ** 2))
    return float(db(noise_gain * step**2 / 12.0 / noise_power(radar)))


class DigitalReceiver:
    """From the complex envelope at the converter's instants to gates, as the converter sees it.

    `range_m` (gate,) m: slant ranges of the gates, gates(radar); `sample_range` (sample,) m: those of the converter's
    samples, c/2 over its rate apart, as far beyond the gates as the low-pass reaches (below 0: before the pulse was
    sent). Gate n is centred on range_m[n], without delay. The local oscillator's phase counts from the first gate.
    Raises ValueError as NyquistZone.of does.
    """

    def __init__(self, radar: RadarSettings) -> None:
        self.radar = radar
        self.zone = NyquistZone.of(radar)
        self.decimation = decimation(radar)
        self.taps = low_pass(radar)
        spacing = sample_spacing_m(radar.receiver.adc_rate_hz)
        near, far = radar.range_m
        count = int(np.floor((far - near) / (self.decimation * spacing) + 1e-9)) + 1
        half = self.taps.size // 2
        instants = np.arange(-half, (count - 1) * self.decimation + half + 1)
        self.sample_range = near + spacing * instants
        self.range_m = self.sample_range[half : instants.size - half : self.decimation]
        attenuation = sensitivity_time_control(radar, self.sample_range)
        self._up = np.sqrt(2.0) * attenuation * _phasor(radar.receiver.if_hz / radar.receiver.adc_rate_hz, instants)
        self._up = self._up.astype(np.complex64)
        self._attenuation = attenuation.astype(np.float32)
        self._down = np.sqrt(2.0) * self.oscillator(instants) / attenuation
        self._blocks = [
            _Block(gates, samples, (weights * self._down[samples, None]).astype(np.complex64))
            for gates, samples, weights in self._bands()
        ]

    def __call__(self, baseband: NDArray[np.complex64]) -> DigitalGates:
        """The gates of consecutive pulses from their envelope, (pulse, receiver, sample) √W at `sample_range`.

        baseband: through the receiver's Gaussian filter, thermal noise included. Automatic gain begins anew with each
        call: its first dwell takes its own level, having none before it. Any number of threads gives the same bits.
        Raises ValueError if baseband does not have the samples of sample_range.
        """
        self._check(baseband)
        pulses, receivers = baseband.shape[:2]
        full_scale = self.full_scale(baseband)
        voltage = np.empty((pulses, receivers, self.range_m.size), dtype=np.complex64)
        saturated = np.zeros(voltage.shape, dtype=bool)

        def convert(start: int) -> None:
            chunk = slice(start, start + _PULSES)
            samples, clipped = quantise(self.up(baseband[chunk]), full_scale[chunk], self.radar.receiver.adc_bits)
            voltage[chunk] = self.down(samples)
            if clipped.any():
                saturated[chunk] = self._meets(clipped)

        with one_blas_thread(), pool() as workers:
            list(workers.map(convert, range(0, pulses, _PULSES)))
        return DigitalGates(voltage, saturated, full_scale)

    def ideal(self, baseband: NDArray[np.complexfloating]) -> NDArray[np.complex128]:
        """Gates (…, gate) from an envelope (…, sample) by low-pass and decimation alone: no carrier, no converter."""
        self._check(baseband)
        voltage = np.empty((*baseband.shape[:-1], self.range_m.size), dtype=np.complex128)
        for gates, samples, weights in self._bands():
            voltage[..., gates] = baseband[..., samples] @ weights
        return voltage

    def up(self, baseband: NDArray[np.complex64]) -> NDArray[np.float32]:
        """Real samples (…, sample) √W at the intermediate frequency, √2 Re{V exp(j2πft)}, of the same mean power."""
        samples = baseband.real * self._up.real
        samples -= baseband.imag * self._up.imag
        return samples

    def down(self, samples: NDArray[np.float32]) -> NDArray[np.complex64]:
        """Complex gates (…, gate) √W from real samples (…, sample): oscillator, conjugation, low-pass, decimation and
        the control's attenuation taken back, all in one banded matrix."""
        rows = samples.reshape(-1, samples.shape[-1])
        voltage = np.empty((rows.shape[0], self.range_m.size), dtype=np.complex64)
        for block in self._blocks:
            product = rows[:, block.samples] @ block.weights.view(np.float32)
            voltage[:, block.gates] = product.view(np.complex64)
        return voltage.reshape(*samples.shape[:-1], -1)

    def oscillator(self, instants: NDArray[np.int_]) -> NDArray[np.complex128]:
        """The numerically controlled oscillator at the band's alias. In a mirrored zone it is conjugate: to conjugate
        afterwards what a real filter made of real samples is the same."""
        phasor = _phasor(-self.zone.alias_hz / self.radar.receiver.adc_rate_hz, instants)
        return phasor.conj() if self.zone.mirrored else phasor

    def full_scale(self, baseband: NDArray[np.complex64]) -> NDArray[np.float64]:
        """Power [W] of a full-scale sine for each pulse, (pulse,): fixed, or agc_headroom_db above the strongest that
        any receiver had in the dwell before (as the converter has it: weakened by the sensitivity-time control).

        A dwell is the time in which the beam turns by its width. See `full_scale_w`.
        """
        pulses = baseband.shape[0]
        if self.radar.receiver.gain == "fixed":
            return full_scale_w(self.radar, np.zeros(pulses))
        seconds = antenna_array(self.radar).narrowest_beam_deg / (6.0 * self.radar.rotation_rpm)
        dwell = max(1, round(seconds * self.radar.prf_hz))
        starts = range(0, pulses, dwell)
        strongest = np.array([self._strongest(baseband[start : start + dwell]) for start in starts])
        before = np.concatenate((strongest[:1], strongest[:-1]))
        return np.repeat(full_scale_w(self.radar, before), dwell)[:pulses]

    def quantisation_noise_power(self, full_scale: float) -> NDArray[np.float64]:
        """Mean noise power [W at the antenna] that the converter adds to each gate, (gate,), at a full scale [W].

        q²/12 a sample, white, through the low-pass; more where the control's attenuation is taken back. It holds while
        the samples cover some steps (Bennett 1948): thermal noise of less than half a step no longer smooths them.
        """
        weight = np.empty(self.range_m.size)
        for block in self._blocks:
            weight[block.gates] = np.sum(np.abs(block.weights) ** 2, axis=0)
        return weight * float(quantisation_step(full_scale, self.radar.receiver.adc_bits)) ** 2 / 12.0

    def _strongest(self, baseband: NDArray[np.complex64]) -> float:
        weakened = baseband * self._attenuation
        power = weakened.real**2 + weakened.imag**2
        return float(np.fmax.reduce(power, axis=None))  # a receiver that did not sample may hold NaN

    def _meets(self, clipped: NDArray[np.bool_]) -> NDArray[np.bool_]:
        """Gates (…, gate) whose main weights meet a clipped sample (…, sample)."""
        gates = np.zeros((*clipped.shape[:-1], self.range_m.size), dtype=bool)
        last = (self.range_m.size - 1) * self.decimation + 1
        for tap in np.flatnonzero(np.abs(self.taps) >= _MAIN_WEIGHT * self.taps.max()):
            gates |= clipped[..., tap : tap + last : self.decimation]
        return gates

    def _bands(self) -> Iterator[tuple[slice, slice, NDArray[np.float64]]]:
        """Blocks of gates, the samples that they need, and the low-pass's weights (sample, gate)."""
        for first in range(0, self.range_m.size, _GATES):
            count = min(_GATES, self.range_m.size - first)
            start, length = first * self.decimation, (count - 1) * self.decimation + self.taps.size
            weights = np.zeros((length, count))
            for gate in range(count):
                weights[gate * self.decimation :][: self.taps.size, gate] = self.taps
            yield slice(first, first + count), slice(start, start + length), weights

    def _check(self, baseband: NDArray[np.complexfloating]) -> None:
        if baseband.shape[-1] != self.sample_range.size:
            raise ValueError(
                f"baseband.shape = {baseband.shape}: must end in {self.sample_range.size} samples; "
                "take the envelope at sample_range"
            )


class _Block(NamedTuple):
    gates: slice
    samples: slice
    weights: NDArray[np.complex64]  # (sample, gate)


def _phasor(cycles_a_sample: float, instants: NDArray[np.int_]) -> NDArray[np.complex128]:
    return np.exp(2j * np.pi * np.remainder(cycles_a_sample * instants, 1.0))


def _mhz(frequency_hz: float) -> str:
    return f"{1e-6 * frequency_hz:g} MHz"
