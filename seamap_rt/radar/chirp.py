"""A chirp's raw echo along fast time, and its compression: what eclipsing does, exactly.

While the transmitter is on nothing is received. A long pulse from nearby therefore comes in without its head: what
is left of it is weaker, and of less bandwidth. Compressed gates do not show it; the raw samples before compression can.

The raw axis is r = c t/2 with t counted from the pulse's leading edge: a reflector at R occupies R … R + c T/2, and all
that comes before c T/2 is lost. Point reflectors are first gathered onto that axis by a short kernel whose own spectrum
is divided out again, as in a non-uniform FFT (Jackson, Meyer, Nishimura & Macovski 1991). Samples hold what lies within
half their rate; of skirts that reach further (none but those of the chirp's sharp ends) the rest is lost.
"""

from __future__ import annotations

import numpy as np
import scipy
from numpy.typing import ArrayLike, NDArray

from ..conventions import SPEED_OF_LIGHT
from ..settings import RadarSettings
from .waveform import (
    RangeResponse,
    blind_range_m,
    chirp_spectrum,
    gate_spacing_m,
    gates,
    next_fast_len,
    receiver_filter,
)

_TAPS = 6  # samples that a reflector is gathered into
_LEAST_RATE = 1.25  # samples per 1/Bc: nearer to 1 no short kernel separates the band from its image
_BLOCK = 1 << 21  # samples of `response` at a time


class Chirp:
    """The processing of a chirp's echoes, from point reflectors to compressed gates.

    raw_range: (sample,) m, uniform, the gates among them; from and to where a reflector can reach a gate.
    raw_range may begin below 0, where a reflector at the mast's foot spreads to. kernel_support_m: half-width of the
    kernel, m. ValueError: no chirp, one that sweeps less than 1/T, or gates too far apart for its bandwidth.

    complex64 holds 1e-6 of the strongest peak. The gates agree with `RangeResponse` as far as the samples hold the
    chirp's skirts, an error that falls as 1/(T Bc): at T Bc = 50 it is 1e-5 of the peak with 3 samples per 1/Bc, 1e-4
    with 2, 1e-3 with 1.5 and 3e-3 with 1.25 (`response`, which no image fills up again, errs up to three times that).
    The phase at the peak of a reflector that is not eclipsed is exact to 1e-5 rad throughout.
    """

    def __init__(self, radar: RadarSettings) -> None:
        if radar.waveform != "chirp":
            raise ValueError(f"radar.waveform = {radar.waveform!r}: must be 'chirp'; a plain pulse is not compressed")
        self._spacing = gate_spacing_m(radar)
        rate = SPEED_OF_LIGHT / (2.0 * self._spacing)
        if rate < _LEAST_RATE * radar.chirp_bandwidth_hz * (1.0 - 1e-9):
            most = SPEED_OF_LIGHT / (2.0 * _LEAST_RATE * radar.chirp_bandwidth_hz)
            raise ValueError(
                f"radar.range_sampling_m = {radar.range_sampling_m:g}: must give gates at most {most:.4g} m apart, not "
                f"{self._spacing:.4g} m (c/2 over {_LEAST_RATE:g} radar.chirp_bandwidth_hz: Nyquist's limit, and room "
                "to interpolate); lower it, or radar.chirp_bandwidth_hz"
            )
        self.kernel_support_m = 0.5 * _TAPS * self._spacing
        # Images fall within the band of kernel and chirp less than exp(−π taps √(1 − 1/excess)) (Beatty et al. 2005).
        excess = float(np.clip(rate / (1.2 * radar.chirp_bandwidth_hz), 1.25, 2.0))
        self._shape = np.pi * np.sqrt((_TAPS / excess * (excess - 0.5)) ** 2 - 0.8)

        response, length, gate = RangeResponse.of(radar), blind_range_m(radar), gates(radar)
        reach = response.reach_m
        self._reach = max(gate[0] - reach, 0.0), gate[-1] + reach
        before, after = (
            int(np.ceil((side + self.kernel_support_m) / self._spacing))
            for side in (gate[0] - self._reach[0], self._reach[1] - gate[-1])
        )
        self._gates = slice(before, before + gate.size)
        self.raw_range = gate[0] + self._spacing * np.arange(-before, gate.size + after)
        self._first = int(np.searchsorted(self.raw_range, length - 1e-9 * self._spacing))  # sample that is received

        # Room for the last reflector's whole pulse, and for the filter's edge that comes round from the first sample.
        self._last = self.raw_range.size + int(np.ceil(reach / self._spacing))
        count = next_fast_len(self._last + int(np.ceil((reach - length) / self._spacing)))
        self._frequency = np.asarray(np.fft.fftfreq(count, 1.0 / rate), dtype=np.float64)
        delay = np.exp(-1j * np.pi * self._frequency * radar.pulse_width_s)  # from the middle to the leading edge
        sent = delay * chirp_spectrum(self._frequency, radar.pulse_width_s, radar.chirp_bandwidth_hz)
        self._sent = rate * sent * receiver_filter(self._frequency, radar.bandwidth_hz)
        self._compressor = delay.conj() * response.compressor(self._frequency)
        root = np.sqrt(self._shape**2 - (np.pi * _TAPS * self._frequency / rate) ** 2)
        self._gathered = _TAPS * np.sinh(root) / (root * scipy.special.i0(self._shape))

    def kernel(self, offset_m: ArrayLike) -> NDArray[np.float64]:
        """Weight with which a reflector is gathered into a raw sample offset_m [m] away, any shape.

        Kaiser–Bessel window, 1 at 0 and 0 beyond kernel_support_m.
        """
        across = 1.0 - (np.asarray(offset_m, dtype=np.float64) / self.kernel_support_m) ** 2
        rising = scipy.special.i0(self._shape * np.sqrt(np.maximum(across, 0.0)))
        return np.where(across >= 0.0, rising / scipy.special.i0(self._shape), 0.0)

    def __call__(self, points: NDArray[np.complexfloating]) -> NDArray[np.complex64]:
        """Compressed gates (…, gate) of reflectors that `kernel` has gathered onto raw_range, (…, sample)."""
        spectrum = np.asarray(scipy.fft.fft(points, self._frequency.size, axis=-1))
        spectrum *= (self._sent / self._gathered).astype(spectrum.dtype)
        return self.compress(self._received(spectrum)).astype(np.complex64, copy=False)

    def response(self, range_m: ArrayLike) -> NDArray[np.complex128]:
        """Gates (n, gate) of unit reflectors at ranges (n,) m: as above, without the gathering's small error."""
        ranges = np.atleast_1d(np.asarray(range_m, dtype=np.float64))
        near = np.flatnonzero((ranges >= self._reach[0]) & (ranges <= self._reach[1]))
        voltage = np.zeros((ranges.size, self._gates.stop - self._gates.start), dtype=np.complex128)
        size = max(1, _BLOCK // self._frequency.size)
        for some in (near[first : first + size] for first in range(0, near.size, size)):
            time = 2.0 * (ranges[some, None] - self.raw_range[0]) / SPEED_OF_LIGHT
            voltage[some] = self.compress(self._received(self._sent * np.exp(-2j * np.pi * self._frequency * time)))
        return voltage

    @property
    def samples(self) -> int:
        """How many raw samples go into the gates, the last reflector's whole pulse included."""
        return self._last

    def compress_noise(self, raw: NDArray[np.complexfloating]) -> NDArray[np.complexfloating]:
        """Compressed gates (…, gate) of noise in all `samples` (…, sample), changed in place: an eclipsed receiver
        samples none, and gates that overlap with the pulse have less."""
        raw[..., : self._first] = 0.0
        return self.compress(raw)

    def _received(self, spectrum: NDArray[np.complexfloating]) -> NDArray[np.complexfloating]:
        """Raw samples (…, sample) of a spectrum, on to the last pulse's end: nothing until the transmitter is off."""
        raw = np.asarray(scipy.fft.ifft(spectrum, axis=-1, overwrite_x=True))[..., : self._last]
        raw[..., : self._first] = 0.0
        return raw

    def compress(self, raw: NDArray[np.complexfloating]) -> NDArray[np.complexfloating]:
        """Compressed gates (…, gate) of raw samples (…, sample) behind the receiver's filter, in their precision."""
        spectrum = np.asarray(scipy.fft.fft(raw, self._frequency.size, axis=-1))
        spectrum *= self._compressor.astype(spectrum.dtype)
        return np.asarray(scipy.fft.ifft(spectrum, axis=-1, overwrite_x=True))[..., self._gates]
