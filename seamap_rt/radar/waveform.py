"""What a point reflector's echo looks like along the gates: the waveform through the receiver.

The receiver's filter is Gaussian with a *noise* bandwidth of exactly B, |H(f)|² = exp(−π f²/B²), so that kTBF holds.
(An ideal brick wall would ring as 1/t: the echo at 15 m, 57 dB above that at 400 m, would then leak into every gate.)
A rectangular pulse through it is closed: a difference of two error functions.

A chirp s(t) = exp(jπ (Bc/T) t²), |t| < T/2, is compressed after that filter by S*(f) W(f). Its windows are short
cosine series over the sweep, W(f) = a₀ + 2 Σ aₘ cos(2πm f/Bc), for all frequencies: the tapped delay line of Klauder,
Price, Darlington & Albersheim (1960). They only add copies m/Bc apart, so that the response ends c T/2 away as it does
without a window; one cut off at ±Bc/2 would ring for ever.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from functools import lru_cache

import numpy as np
import scipy
from numpy.typing import ArrayLike, NDArray

from ..compute.quadrature import bisect, gauss_legendre
from ..conventions import SPEED_OF_LIGHT, db
from ..settings import RadarSettings

_NULL = 1e-3  # of the peak: −60 dB
_POINTS = 32  # entries of a chirp's table per 1/B: the spline between them errs by some 1e-6 of the peak


def _taylor(sidelobe_db: float, nbar: int) -> tuple[float, ...]:
    """The cosine series of Taylor's weighting: sidelobes level to the nbar-th, then falling (Taylor 1955)."""
    level = np.arccosh(10.0 ** (sidelobe_db / 20.0)) / np.pi
    stretch = nbar**2 / (level**2 + (nbar - 0.5) ** 2)
    order = np.arange(1, nbar)
    series = [1.0]
    for m in order:
        zeros = np.prod(1.0 - m**2 / stretch / (level**2 + (order - 0.5) ** 2))
        series.append(-0.5 * (-1.0) ** m * float(zeros / np.prod(1.0 - m**2 / order[order != m] ** 2)))
    return tuple(series)


WINDOWS = {"none": (1.0,), "hann": (0.5, 0.25), "hamming": (0.54, 0.23), "taylor": _taylor(35.0, 4)}


def next_fast_len(least: int) -> int:
    """The least length of a transform from `least` on that has no prime factor above 11."""
    return int(scipy.fft.next_fast_len(least))  # type: ignore[arg-type]


def receiver_filter(frequency_hz: NDArray[np.float64], bandwidth_hz: float) -> NDArray[np.float64]:
    """H(f) of the receiver, f from its middle: 1 there, of noise bandwidth `bandwidth_hz`."""
    return np.exp(-0.5 * np.pi * (frequency_hz / bandwidth_hz) ** 2)


def window_weight(frequency_hz: NDArray[np.float64], bandwidth_hz: float, window: str) -> NDArray[np.float64]:
    """W(f) of a window over a sweep of `bandwidth_hz`."""
    first, *others = WINDOWS[window]
    turn = 2.0 * np.pi * frequency_hz / bandwidth_hz
    return first + 2.0 * sum((a * np.cos(m * turn) for m, a in enumerate(others, 1)), np.zeros_like(turn))


def chirp_spectrum(frequency_hz: NDArray[np.float64], width_s: float, bandwidth_hz: float) -> NDArray[np.complex128]:
    """S(f) [s] of a chirp of unit height, its middle at time 0: Fresnel integrals (Klauder et al. 1960)."""
    rate = bandwidth_hz / width_s
    steepness = np.sqrt(2.0 * rate)
    centre = frequency_hz / rate
    (sine_stop, cosine_stop), (sine_start, cosine_start) = (
        scipy.special.fresnel(steepness * (0.5 * side * width_s - centre)) for side in (1.0, -1.0)
    )
    carrier = np.exp(-1j * np.pi * frequency_hz * centre)
    return carrier * (cosine_stop - cosine_start + 1j * (sine_stop - sine_start)) / steepness


@dataclass(frozen=True)
class RangeResponse:
    """Voltage response h(r − R) of a gate at r to a reflector at R; 1 for a pulse that the filter leaves alone.

    A chirp's is that after compression, far enough off not to be eclipsed, and scaled so that the noise of a gate is
    still kTBF: h(0) is the root of the compression's gain. ValueError: a chirp that sweeps less than 1/T.
    """

    pulse_width_s: float
    bandwidth_hz: float
    waveform: str = "pulse"
    chirp_bandwidth_hz: float = 0.0
    window: str = "none"

    def __post_init__(self) -> None:
        if self.waveform not in ("pulse", "chirp"):
            raise ValueError(f"waveform = {self.waveform!r}: must be 'pulse' or 'chirp'; give one of them")
        if self.window not in WINDOWS:
            raise ValueError(f"window = {self.window!r}: must be one of {', '.join(WINDOWS)}; give one of them")
        if self.waveform == "chirp" and self.pulse_width_s * self.chirp_bandwidth_hz < 1.0 - 1e-9:
            raise ValueError(
                f"radar.chirp_bandwidth_hz = {self.chirp_bandwidth_hz:g}: must be at least 1/radar.pulse_width_s = "
                f"{1.0 / self.pulse_width_s:g} (a shorter sweep compresses nothing); raise it, lengthen "
                "radar.pulse_width_s or set radar.waveform = 'pulse'"
            )

    @classmethod
    def of(cls, radar: RadarSettings) -> RangeResponse:
        """The response of a radar's waveform. Raises ValueError for settings that contradict each other."""
        if radar.waveform == "pulse":
            return cls(radar.pulse_width_s, radar.bandwidth_hz)
        swept, window = radar.chirp_bandwidth_hz, radar.compression_window
        return cls(radar.pulse_width_s, radar.bandwidth_hz, "chirp", swept, window)

    def __call__(self, offset_m: ArrayLike) -> NDArray[np.float64]:
        """h at a range offset r − R [m], any shape; real and even."""
        time = 2.0 * np.asarray(offset_m, dtype=np.float64) / SPEED_OF_LIGHT
        if self.waveform == "chirp":
            return _compressed(self).response(time)
        steepness = np.sqrt(2.0 * np.pi) * self.bandwidth_hz
        half = 0.5 * self.pulse_width_s
        return 0.5 * (scipy.special.erf(steepness * (time + half)) - scipy.special.erf(steepness * (time - half)))

    @property
    def support_m(self) -> float:
        """Half-width of the main lobe, which the mesh beyond the window and a gate's neighbours must reach.

        A pulse has nothing else: beyond it h is below 1e-5 of its peak (−100 dB in power). A chirp's ends where h first
        falls below 1e-3 of its peak (−60 dB): at its first null, to a thousandth of the lobe's height.
        """
        return self.reach_m if self.waveform == "pulse" else self._falls_to(_NULL)

    @property
    def spread_m(self) -> float:
        """Standard deviation of the main lobe's power in range."""
        fine = np.linspace(-self.support_m, self.support_m, 1601)
        power = self(fine) ** 2
        return float(np.sqrt(power @ fine**2 / power.sum()))

    @property
    def reach_m(self) -> float:
        """Half-width of all of h, a chirp's sidelobes included: c T/2, the window's delays and the filter's edge."""
        edge = 3.02 / (np.sqrt(2.0 * np.pi) * self.bandwidth_hz)  # ½ erfc(3.02) ≈ 1e-5
        if self.waveform == "pulse":
            return 0.5 * SPEED_OF_LIGHT * (0.5 * self.pulse_width_s + edge)
        delay = (len(WINDOWS[self.window]) - 1) / self.chirp_bandwidth_hz
        return 0.5 * SPEED_OF_LIGHT * (self.pulse_width_s + delay + edge)

    @property
    def resolution_m(self) -> float:
        """Full width of |h|² at half its peak: the −3 dB width in slant range."""
        return 2.0 * self._falls_to(np.sqrt(0.5))

    @property
    def gain(self) -> float:
        """h(0)²: signal to noise at the peak over that of one raw sample of an echo that the filter leaves alone.

        A chirp's is T B less what window and filter take; a pulse's is what the filter leaves of it, at most 1.
        """
        return float(self(0.0)) ** 2

    def noise_correlation(self, offset_m: ArrayLike) -> NDArray[np.float64]:
        """Correlation of two gates' noise, `offset_m` apart: exp(−π B² τ²); a chirp's has the spectrum |H W S|²."""
        time = 2.0 * np.asarray(offset_m, dtype=np.float64) / SPEED_OF_LIGHT
        if self.waveform == "chirp":
            return _compressed(self).correlation(time)
        return np.exp(-np.pi * (self.bandwidth_hz * time) ** 2)

    def compressor(self, frequency_hz: NDArray[np.float64]) -> NDArray[np.complex128]:
        """The matched filter S*(f) W(f) of a chirp centred on time 0, with the scale that keeps the noise kTBF."""
        return _compressed(self).scale * self._matched(frequency_hz)

    def _matched(self, frequency_hz: NDArray[np.float64]) -> NDArray[np.complex128]:
        weight = window_weight(frequency_hz, self.chirp_bandwidth_hz, self.window)
        return weight * chirp_spectrum(frequency_hz, self.pulse_width_s, self.chirp_bandwidth_hz).conj()

    def _falls_to(self, share: float) -> float:
        """Where [m] h first falls to a share of its peak."""
        step = 0.5 * SPEED_OF_LIGHT / (_POINTS * self.bandwidth_hz)
        offset, peak = np.arange(0.0, self.reach_m + step, step), float(self(0.0))
        first = int(np.argmax(self(offset) <= share * peak))
        return bisect(lambda r: float(self(r)) - share * peak, float(offset[first - 1]), float(offset[first]))


@dataclass(frozen=True)
class _CompressedPulse:
    """What compression makes of a chirp and of noise, as functions of a delay [s], and the matched filter's scale."""

    response: Callable[[ArrayLike], NDArray[np.float64]]
    correlation: Callable[[ArrayLike], NDArray[np.float64]]
    scale: float


@lru_cache(maxsize=16)
def _compressed(response: RangeResponse) -> _CompressedPulse:
    """Transforms of H |S|² W and of |H S W|²: sums over a comb of frequencies, exact but for echoes a period apart."""
    width, bandwidth, swept = response.pulse_width_s, response.bandwidth_hz, response.chirp_bandwidth_hz
    # The noise's correlation reaches twice as far beyond T as the response, 6/Bc; at 3/B the filter's has vanished.
    period = 2.0 * (width + 6.0 / swept + 3.0 / bandwidth)
    count = next_fast_len(int(np.ceil(_POINTS * bandwidth * period)))
    frequency = np.arange(int(4.0 * bandwidth * period)) / period  # H(4B) = 1e-11
    passed = receiver_filter(frequency, bandwidth) * response._matched(frequency)
    echo = (passed * chirp_spectrum(frequency, width, swept)).real
    noise = np.abs(passed) ** 2

    density = (2.0 * noise.sum() - noise[0]) / period  # ∫|H S W|² df
    scale = float(np.sqrt(bandwidth / density))
    delay = np.arange(count // 2) * (period / count)

    def even(spectrum: NDArray[np.float64]) -> Callable[[ArrayLike], NDArray[np.float64]]:
        values = np.fft.irfft(spectrum, count)[: delay.size] * (count / period)
        spline = scipy.interpolate.CubicSpline(delay, values, bc_type="clamped")
        return lambda time: np.where(np.abs(time) < delay[-1], spline(np.minimum(np.abs(time), delay[-1])), 0.0)

    return _CompressedPulse(even(scale * echo), even(noise / density), scale)


def sample_spacing_m(rate_hz: float) -> float:
    """Metres of range between samples at a rate [Hz]."""
    return 0.5 * SPEED_OF_LIGHT / rate_hz


def gate_spacing_m(radar: RadarSettings) -> float:
    """Spacing of the gates [m]: range_sampling_m, or the nearest to it that a digital receiver's decimation gives."""
    if radar.receiver.chain != "digital":
        return radar.range_sampling_m
    sample = sample_spacing_m(radar.receiver.adc_rate_hz)
    return sample * max(1, round(radar.range_sampling_m / sample))


def gates(radar: RadarSettings) -> NDArray[np.float64]:
    """Slant ranges of the gates [m], from the near end of the window to the far one."""
    near, far = radar.range_m
    spacing = gate_spacing_m(radar)
    count = int(np.floor((far - near) / spacing + 1e-9)) + 1
    return near + spacing * np.arange(count, dtype=np.float64)


def range_cell(radar: RadarSettings) -> float:
    """The radar's resolution in range [m]: c/2 over the lesser of the receiver's and the waveform's bandwidth."""
    swept = radar.chirp_bandwidth_hz if radar.waveform == "chirp" else 1.0 / radar.pulse_width_s
    return SPEED_OF_LIGHT / (2.0 * min(radar.bandwidth_hz, swept))


def straddling_loss_db(radar: RadarSettings) -> tuple[float, float]:
    """Loss [dB] of a reflector between two gates, against one on a gate: (worst, midway; mean of the power)."""
    response, half = RangeResponse.of(radar), 0.5 * gate_spacing_m(radar)
    nodes, weights = gauss_legendre(64)
    worst = (response(half) / response(0.0)) ** 2
    mean = 0.5 * weights @ (response(half * nodes) / response(0.0)) ** 2
    return -float(db(worst)), -float(db(mean))


def blind_range_m(radar: RadarSettings) -> float:
    """c T/2 [m]: nearer by, an echo begins while the transmitter is on and the receiver is off."""
    return 0.5 * SPEED_OF_LIGHT * radar.pulse_width_s


def unambiguous_range_m(radar: RadarSettings) -> float:
    """c/(2 prf) [m]: an echo from beyond comes after the next pulse."""
    return SPEED_OF_LIGHT / (2.0 * radar.prf_hz)
