"""A chirp's raw echoes and their compression: far off as the range response says, nearby with the pulse's head lost."""

from __future__ import annotations

import numpy as np
import pytest
from numpy.typing import NDArray

from seamap_rt.conventions import SPEED_OF_LIGHT
from seamap_rt.radar.chirp import Chirp
from seamap_rt.radar.waveform import RangeResponse, blind_range_m, gates
from seamap_rt.settings import RadarSettings, ReceiverSettings

SWEPT = 50e6  # Hz
CELL = SPEED_OF_LIGHT / (2.0 * SWEPT)  # m, c/2B
WIDE = 3.0 * SWEPT  # a filter that takes 4 % from the sweep's ends


def radar_of(cycles: float, samples: float, near: float, far: float, **changes: object) -> RadarSettings:
    """A chirp of `cycles` = T Bc; `samples` gates per c/2B; the window from near to far in units of c T/2."""
    width = cycles / SWEPT
    length = 0.5 * SPEED_OF_LIGHT * width
    tree: dict[str, object] = {
        "waveform": "chirp",
        "pulse_width_s": width,
        "chirp_bandwidth_hz": SWEPT,
        "compression_window": "none",
        "bandwidth_hz": SWEPT,
        "range_sampling_m": CELL / samples,
        "range_m": (near * length, far * length),
    }
    return RadarSettings.model_validate({**tree, **changes})


def gathered(chirp: Chirp, range_m: NDArray[np.float64]) -> NDArray[np.complex64]:
    """(n, sample) of unit reflectors at (n,) ranges, gathered as a mesh's facets are."""
    return chirp.kernel(chirp.raw_range - range_m[:, None]).astype(np.complex64)


# ---------------------------------------------------------------------------------------------------------- far off


@pytest.mark.parametrize("window", ["none", "hann", "hamming", "taylor"])
@pytest.mark.parametrize(
    # Samples hold what lies within half their rate. Of the skirts of H|S|², (1/2π²)(f² + Bc²/4)/(f² − Bc²/4)² a hertz
    # against T/Bc in the band, the rest is lost: it is as 1/(T Bc), and falls steeply with the samples per 1/Bc.
    ("cycles", "samples", "slack"),
    [(50, 2.0, 1e-4), (50, 3.0, 1e-5), (300, 4.0, 1e-5), (300, 2.0, 3e-5), (50, 1.5, 2e-3), (50, 1.25, 4e-3)],
)
def test_a_far_reflector_is_the_range_response(window: str, cycles: float, samples: float, slack: float) -> None:
    radar = radar_of(cycles, samples, 2.5, 4.0, compression_window=window)
    chirp, response, ranges = Chirp(radar), RangeResponse.of(radar), gates(radar)
    reflectors = ranges[ranges.size // 2] + CELL / samples * np.array([0.0, 0.25, 0.5, 0.77, -3.4])
    law, peak = response(ranges - reflectors[:, None]), float(response(0.0))
    got = chirp(gathered(chirp, reflectors))
    assert got.dtype == np.complex64
    assert got.shape == (5, ranges.size)
    np.testing.assert_allclose(got, law, rtol=0, atol=slack * peak)
    np.testing.assert_allclose(chirp.response(reflectors), law, rtol=0, atol=2.5 * slack * peak)
    # No phase depends on where between the gates it lies: 1e-5 rad would be 2e-8 m at 10 GHz.
    at = np.argmax(np.abs(got), axis=1)
    assert np.all(np.abs(np.angle(got[np.arange(5), at])) < 1e-5)


@pytest.mark.parametrize(("near", "far"), [(2.5, 3.0), (0.3, 0.9)])
def test_sidelobes_reach_gates_from_outside_the_window(near: float, far: float) -> None:
    # Reflectors a fraction of a pulse before and beyond the window; a window that is itself eclipsed has only
    # the latter. Slack: images of the kernel, half of it, and what the samples lose.
    radar = radar_of(50, 4.0, near, far)
    chirp, response, ranges = Chirp(radar), RangeResponse.of(radar), gates(radar)
    length, reach = blind_range_m(radar), response.reach_m
    reflectors = np.array([ranges[0] - 0.99 * length, ranges[0] - 0.4 * length, ranges[-1] + 0.6 * length])
    reflectors = reflectors[reflectors > 1.1 * length]
    law = response(ranges - reflectors[:, None])
    assert np.all(np.abs(law).max(axis=1) > 1e-3)
    np.testing.assert_allclose(chirp(gathered(chirp, reflectors)), law, rtol=0, atol=1e-5 * float(response(0.0)))
    np.testing.assert_allclose(chirp.response(reflectors), law, rtol=0, atol=1e-5 * float(response(0.0)))
    if near < 1.0:
        return
    assert chirp.raw_range[0] + chirp.kernel_support_m <= ranges[0] - reach
    assert chirp.raw_range[-1] - chirp.kernel_support_m >= ranges[-1] + reach
    # Further off nothing is heard, and nothing comes round.
    nowhere = chirp.response([ranges[0] - 1.01 * reach, ranges[-1] + 1.01 * reach, 20.0 * ranges[-1]])
    np.testing.assert_array_equal(nowhere, np.zeros_like(nowhere))


def test_the_gates_are_samples_of_the_raw_axis() -> None:
    for receiver in (ReceiverSettings(), ReceiverSettings(chain="digital", adc_rate_hz=100e6)):
        radar = radar_of(20, 2.0, 0.1, 3.0, receiver=receiver)
        ranges, raw = gates(radar), Chirp(radar).raw_range
        first = int(np.argmin(np.abs(raw - ranges[0])))
        np.testing.assert_allclose(raw[first : first + ranges.size], ranges, rtol=0, atol=1e-9)
        np.testing.assert_allclose(np.diff(raw), ranges[1] - ranges[0], rtol=1e-9)


# ---------------------------------------------------------------------------------------------------------- eclipsed


@pytest.mark.parametrize("filter_hz", [WIDE, SWEPT])
def test_an_eclipsed_reflector_keeps_the_tail_of_its_pulse(filter_hz: float) -> None:
    # At R < cT/2 the matched filter's peak is the share R/(cT/2) of the pulse that comes after the transmitter is off,
    # weighed by the filter at the frequency that the sweep has got to by then. Half a sample at the cut, 1/(8 T Bc),
    # and the ripple of the cut end, as much again (more where the filter is narrow), are left.
    cycles, shares = 200, np.array([0.05, 0.1, 0.25, 0.5, 0.75, 0.9, 1.0, 1.2])
    radar = radar_of(cycles, 4.0, 0.02, 1.4, bandwidth_hz=filter_hz)
    chirp, ranges, length = Chirp(radar), gates(radar), blind_range_m(radar)
    at = np.rint((shares * length - ranges[0]) / (ranges[1] - ranges[0])).astype(int)
    heard = np.linspace(0.0, 1.0, 20001)
    weight = np.exp(-0.5 * np.pi * ((heard - 0.5) * SWEPT / filter_hz) ** 2)
    law = [weight[heard > 1.0 - share].sum() / weight.sum() for share in ranges[at] / length]
    got = chirp.response(ranges[at])[np.arange(at.size), at] / float(RangeResponse.of(radar)(0.0))
    np.testing.assert_allclose(got.real, law, rtol=0, atol=0.5 / cycles)
    assert np.abs(got.imag).max() < 0.5 / cycles
    if filter_hz == WIDE:
        np.testing.assert_allclose(np.abs(got), np.minimum(ranges[at] / length, 1.0), rtol=0, atol=0.5 / cycles + 3e-3)


def test_an_eclipsed_reflector_is_wider() -> None:
    # The share of the sweep that is left is the bandwidth that is left: sinc(share Bc τ) at gates beyond R, 0.443 to
    # half power; gates before R lose more of the pulse, as at the end of a chirp of T Bc share² cycles. Chords between
    # gates 1/(4 Bc) apart, half a sample at the cut and the filter's slope over the tail: 1 %.
    cycles = 400
    radar = radar_of(cycles, 4.0, 0.02, 1.4, bandwidth_hz=WIDE)
    chirp, ranges, length = Chirp(radar), gates(radar), blind_range_m(radar)
    for wanted in (0.1, 0.2, 0.3):
        at = int(np.argmin(np.abs(ranges - wanted * length)))
        share = ranges[at] / length
        power = np.abs(chirp.response(ranges[at])[0]) ** 2
        power /= power[at]
        high, low = at + np.argmax(power[at:] < 0.5), at - np.argmax(power[at::-1] < 0.5)
        right = np.interp(-0.5, -power[[high - 1, high]], ranges[[high - 1, high]]) - ranges[at]
        left = ranges[at] - np.interp(0.5, power[[low, low + 1]], ranges[[low, low + 1]])
        offset = np.linspace(0.0, 0.5, 5001)
        rest = 1.0 - offset / (cycles * share**2)
        law = float(offset[np.argmax(rest * np.sinc(offset * rest) < np.sqrt(0.5))])
        assert right * share / CELL == pytest.approx(0.443, rel=0.01)
        assert left * share / CELL == pytest.approx(law, rel=0.01)


def test_a_reflector_at_the_antenna_vanishes() -> None:
    # All that is left is what the filter smears past the end of the pulse, ∫ of its step ≈ 0.28/B, and half a sample.
    for cycles in (50, 500):
        radar = radar_of(cycles, 4.0, 0.02, 1.4, bandwidth_hz=WIDE)
        left = np.abs(Chirp(radar).response([0.0])).max() / float(RangeResponse.of(radar)(0.0))
        assert left < 0.2 / cycles


@pytest.mark.parametrize("share", [0.03, 0.2, 0.6, 0.95])
def test_gathered_and_exact_agree_when_eclipsed(share: float) -> None:
    radar = radar_of(100, 3.0, 0.02, 1.4, compression_window="hamming")
    chirp = Chirp(radar)
    reflectors = share * blind_range_m(radar) + CELL * np.array([0.0, 0.13, 0.19])
    exact = chirp.response(reflectors)
    # As far off: 1e-5 of the whole peak is the skirts' and the kernel's.
    slack = 1e-5 * float(RangeResponse.of(radar)(0.0))
    np.testing.assert_allclose(chirp(gathered(chirp, reflectors)), exact, rtol=0, atol=slack)


# ---------------------------------------------------------------------------------------------------------- numbers


def test_linear_and_as_precise_as_single_precision_allows() -> None:
    radar = radar_of(50, 2.0, 0.1, 3.0, compression_window="hamming")
    chirp, random = Chirp(radar), np.random.default_rng(7)
    shape = (3, 2, chirp.raw_range.size)
    one, two = ((random.standard_normal((*shape, 2)) @ [1.0, 1j]).astype(np.complex64) for _ in range(2))
    both = chirp(one + (2.0 - 1.0j) * two)
    apart = chirp(one) + (2.0 - 1.0j) * chirp(two)
    assert both.shape == (3, 2, gates(radar).size)
    # Rounding to 24 bits, 6e-8, grows as the root of the stages of the transforms.
    np.testing.assert_allclose(both, apart, rtol=0, atol=1e-6 * np.abs(both).max())

    # A strong echo's rounding at gates far from it: 1e-6 of its peak, 120 dB down.
    reflector = np.array([0.9 * blind_range_m(radar)])
    single = gathered(chirp, reflector)
    double = chirp(single.astype(np.complex128))
    peak = np.abs(double).max()
    assert np.abs(chirp(single) - double).max() < 1e-6 * peak


def test_noise_stays_that_of_a_raw_sample() -> None:
    # White noise of density 1 through the receiver's filter has power B; so has the compressed gate, and the
    # correlation along the gates that RangeResponse says. 3000 × some 100 independent gates: 0.2 %, five times that.
    radar = radar_of(30, 3.0, 1.2, 3.0, compression_window="hamming", bandwidth_hz=40e6)
    chirp, response, random = Chirp(radar), RangeResponse.of(radar), np.random.default_rng(3)
    rate = 3.0 * SWEPT
    count = chirp.raw_range.size
    white = random.standard_normal((3000, count, 2)) @ [1.0, 1j] * np.sqrt(0.5 * rate)
    frequency = np.fft.fftfreq(count, 1.0 / rate)
    raw = np.fft.ifft(np.fft.fft(white) * np.exp(-0.5 * np.pi * (frequency / 40e6) ** 2))
    assert np.mean(np.abs(raw) ** 2) == pytest.approx(40e6, rel=0.01)
    noise = chirp.compress(raw)
    assert np.mean(np.abs(noise) ** 2) == pytest.approx(40e6, rel=0.01)
    for lag in range(1, 8):
        found = np.mean(noise[:, lag:] * noise[:, :-lag].conj()) / 40e6
        assert abs(found - response.noise_correlation(lag * CELL / 3.0)) < 0.01


# ---------------------------------------------------------------------------------------------------------- hard cases


def test_windows_that_are_short_or_wholly_eclipsed() -> None:
    # A single gate, nearer than the pulse is long: its reflector still has the share of its tail.
    radar = radar_of(100, 4.0, 0.5, 0.501, bandwidth_hz=WIDE)
    chirp, ranges = Chirp(radar), gates(radar)
    assert ranges.size == 1
    got = chirp.response(ranges) / float(RangeResponse.of(radar)(0.0))
    assert abs(got[0, 0]) == pytest.approx(0.5, abs=0.01)
    # A window at the antenna's foot: next to nothing comes in.
    radar = radar_of(100, 4.0, 0.01, 0.03, bandwidth_hz=WIDE)
    chirp, ranges = Chirp(radar), gates(radar)
    assert np.abs(chirp.response(ranges)).max() < 0.04 * float(RangeResponse.of(radar)(0.0))
    np.testing.assert_array_equal(chirp(np.zeros((2, chirp.raw_range.size), np.complex64)), 0.0)


def test_refusals() -> None:
    # CELL/1.25 = 2.398 m.
    with pytest.raises(ValueError, match=r"radar.range_sampling_m = 2.5: must give gates at most 2.398 m apart"):
        Chirp(radar_of(100, 2.0, 1.0, 2.0, range_sampling_m=2.5))
    receiver = ReceiverSettings(chain="digital", adc_rate_hz=50e6)
    with pytest.raises(ValueError, match=r"range_sampling_m = 1.5: must give gates at most 2.398 m apart, not 2.998 m"):
        Chirp(radar_of(100, 2.0, 1.0, 2.0, range_sampling_m=1.5, receiver=receiver))
    with pytest.raises(ValueError, match=r"radar.chirp_bandwidth_hz = 5e\+07: must be at least"):
        Chirp(radar_of(0.9, 2.0, 10.0, 20.0))
    with pytest.raises(ValueError, match=r"radar.waveform = 'pulse': must be 'chirp'"):
        Chirp(RadarSettings())
