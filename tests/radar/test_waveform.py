"""The range response of a pulse and of a compressed chirp, and what follows from the gates' spacing and the prf."""

from __future__ import annotations

import numpy as np
import pytest
from numpy.typing import NDArray
from scipy.signal import windows

from seamap_rt.conventions import SPEED_OF_LIGHT, db
from seamap_rt.radar.waveform import (
    WINDOWS,
    RangeResponse,
    blind_range_m,
    gate_spacing_m,
    gates,
    straddling_loss_db,
    unambiguous_range_m,
    window_weight,
)
from seamap_rt.settings import RadarSettings, ReceiverSettings

SWEPT = 50e6  # Hz
CELL = SPEED_OF_LIGHT / (2.0 * SWEPT)  # m, c/2B


def chirp(cycles: float, window: str = "none", filter_hz: float = 20.0 * SWEPT) -> RangeResponse:
    """A chirp of a time–bandwidth product, by default through a filter that leaves it alone."""
    return RangeResponse(cycles / SWEPT, filter_hz, "chirp", SWEPT, window)


def brute_force(
    response: RangeResponse, offset_m: NDArray[np.float64]
) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
    """h and the noise's correlation of a chirp by the FFT of its samples, 200 per 1/Bc, ends counted half."""
    rate = 200.0 * response.chirp_bandwidth_hz
    samples = round(response.pulse_width_s * rate) + 1
    time = (np.arange(samples) - 0.5 * (samples - 1)) / rate
    sent = np.exp(1j * np.pi * response.chirp_bandwidth_hz / response.pulse_width_s * time**2)
    sent[[0, -1]] *= 0.5
    count = 8 * samples
    frequency = np.fft.fftfreq(count, 1.0 / rate)
    spectrum = np.abs(np.fft.fft(sent, count) / rate)
    passed = np.exp(-np.pi * frequency**2 / (2.0 * response.bandwidth_hz**2))
    weight = WINDOWS[response.window][0] + sum(
        2.0 * a * np.cos(2.0 * np.pi * m * frequency / response.chirp_bandwidth_hz)
        for m, a in enumerate(WINDOWS[response.window][1:], 1)
    )
    noise = (passed * spectrum * weight) ** 2
    echo = passed * spectrum**2 * weight * np.sqrt(response.bandwidth_hz / (noise.sum() * rate / count))
    turn = np.exp(2j * np.pi * np.outer(2.0 * offset_m / SPEED_OF_LIGHT, frequency))
    return (turn @ echo).real * rate / count, (turn @ noise).real / noise.sum()


# --------------------------------------------------------------------------------------------- rectangular pulse


def test_pulse_is_the_convolution_of_a_rectangle_with_the_filter() -> None:
    # 20 ns through 50 MHz, midpoints 0.01 ns apart: the rule errs by (dt B)² ~ 1e-6.
    response = RangeResponse(20e-9, 50e6)
    step = 1e-11
    within = step * (np.arange(2000) - 999.5)
    impulse = np.sqrt(2.0) * 50e6  # the filter's, exp(−2π B² t²) times this
    offset = np.linspace(-6.0, 6.0, 241)
    delay = 2.0 * offset[:, None] / SPEED_OF_LIGHT - within
    seen = impulse * np.exp(-2.0 * np.pi * (50e6 * delay) ** 2).sum(axis=1) * step
    np.testing.assert_allclose(response(offset), seen, rtol=0, atol=3e-6)

    # Full width at half power from the same sum: "20 ns are 3 m" is the length, the rounded pulse's half power 2.33 m.
    half = np.abs(offset[seen >= seen.max() * np.sqrt(0.5)]).max()
    beyond = np.interp(-np.sqrt(0.5), -seen[offset >= half][:2] / seen.max(), offset[offset >= half][:2])
    assert response.resolution_m == pytest.approx(2.0 * beyond, abs=2e-3)  # chords of 5 cm
    assert response.resolution_m == pytest.approx(2.328, abs=2e-3)
    assert response.gain == pytest.approx(seen.max() ** 2, rel=1e-5)
    assert response.reach_m == response.support_m


def test_resolution_of_a_pulse_that_the_filter_leaves_alone_is_its_length() -> None:
    # |h|² = ½ at h = √½, 0.22/B inside the edge on either side.
    assert RangeResponse(20e-9, 5e9).resolution_m == pytest.approx(0.5 * SPEED_OF_LIGHT * 20e-9, rel=5e-3)


def test_two_numbers_make_a_pulse() -> None:
    assert RangeResponse(20e-9, 50e6) == RangeResponse.of(RadarSettings())


# ---------------------------------------------------------------------------------------------------------- chirp


@pytest.mark.parametrize("cycles", [20, 100, 1000])
def test_bare_chirp_is_the_textbook_form_at_any_length(cycles: int) -> None:
    # (1 − |τ|/T) sinc(Bτ (1 − |τ|/T)) (Klauder et al. 1960; Cook & Bernfeld 1967). The filter, 40 times as wide, smears
    # it with σ = 0.28/B: of the peak, half its curvature, (π²/6)(σ Bc)² = 8e-5, and its cusp, 0.8 σ/T = 5.6e-3/(T Bc).
    response = chirp(cycles, filter_hz=40.0 * SWEPT)
    offset = np.linspace(-1.3, 1.3, 20001) * 0.5 * SPEED_OF_LIGHT * response.pulse_width_s
    left = np.maximum(1.0 - np.abs(offset) / (0.5 * SPEED_OF_LIGHT * response.pulse_width_s), 0.0)
    law = left * np.sinc(offset / CELL * left)
    np.testing.assert_allclose(response(offset) / response(0.0), law, rtol=0, atol=1e-4 + 6e-3 / cycles)
    # Gain over a raw sample is T times the noise's bandwidth.
    assert response.gain == pytest.approx(cycles * 40.0, rel=1e-5 + 6e-3 / cycles)


def test_sidelobes_of_a_bare_chirp() -> None:
    # sinc's −13.26 dB for long chirps; a finite one's differ by some 2/(T Bc) of their height (0.15 dB at 100).
    for cycles, slack in ((100, 0.2), (1000, 0.03)):
        response = chirp(cycles)
        beyond = np.linspace(response.support_m, 2.0 * CELL, 4001)
        level = 2.0 * db(np.abs(response(beyond) / response(0.0)).max())
        assert level == pytest.approx(-13.26, abs=slack)


@pytest.mark.parametrize(
    ("window", "width", "sidelobe_db"),
    [("none", 0.886, -13.26), ("hann", 1.441, -31.47), ("hamming", 1.303, -42.68), ("taylor", 1.184, -35.1)],
)
def test_windows(window: str, width: float, sidelobe_db: float) -> None:
    # Harris (1978); Taylor (1955) for nbar = 4 and −35 dB, whose first sidelobe lies 0.17 dB below that. T Bc = 2000:
    # the ripples of the spectrum's edges leave 1e-3 of the width, 2e-3 dB of the loss and 0.1 dB of a low sidelobe.
    response = chirp(2000, window)
    assert response.resolution_m / CELL == pytest.approx(width, rel=2e-3)
    first, *others = WINDOWS[window]
    loss_db = float(db(1.0 + 2.0 * sum(a**2 for a in others) / first**2))  # ⟨W²⟩/⟨W⟩²
    assert float(db(2000 * 20.0 / response.gain)) == pytest.approx(loss_db, abs=4e-3)
    beyond = np.linspace(response.support_m, response.reach_m, 200_001)
    highest = 2.0 * db(np.abs(response(beyond) / response(0.0)).max())
    assert highest == pytest.approx(sidelobe_db, abs=0.15)


def test_loss_of_hamming_is_as_in_the_handbooks() -> None:
    assert float(db(2000 * 20.0 / chirp(2000, "hamming").gain)) == pytest.approx(1.34, abs=0.01)


def test_short_chirps_keep_less_of_the_window() -> None:
    # Fresnel ripples: at T Bc = 50 Hamming's highest sidelobe is −31 dB, not −43; at 500 it is where it should be.
    for cycles, highest in ((50, -31.4), (100, -37.4), (500, -42.6)):
        response = chirp(cycles, "hamming")
        beyond = np.linspace(response.support_m, response.reach_m, 100_001)
        assert 2.0 * db(np.abs(response(beyond) / response(0.0)).max()) == pytest.approx(highest, abs=0.15)


def test_taylor_weights_are_those_of_scipy() -> None:
    count = 64
    frequency = (np.arange(count) - 0.5 * (count - 1)) / count * SWEPT
    weight = window_weight(frequency, SWEPT, "taylor")
    np.testing.assert_allclose(weight, windows.taylor(count, nbar=4, sll=35, norm=False), rtol=0, atol=1e-12)


@pytest.mark.parametrize("window", list(WINDOWS))
@pytest.mark.parametrize(("cycles", "filter_hz"), [(2, 50e6), (20, 50e6), (20, 20e6), (20, 200e6)])
def test_chirp_through_a_filter_is_its_spectrum_squared(window: str, cycles: int, filter_hz: float) -> None:
    # The samples' FFT errs by (1/200)² of the skirts; the table's spline by 1e-6.
    response = chirp(cycles, window, filter_hz)
    offset = np.linspace(0.0, 1.1 * response.reach_m, 60)
    h, noise = brute_force(response, offset)
    np.testing.assert_allclose(response(offset), h, rtol=0, atol=2e-5 * h[0])
    np.testing.assert_allclose(response.noise_correlation(offset), noise, rtol=0, atol=2e-5)
    np.testing.assert_array_equal(response(offset), response(-offset))
    assert response.noise_correlation(0.0) == pytest.approx(1.0, abs=1e-12)
    # Nothing reaches further than reach_m, and the main lobe ends within it.
    assert np.all(np.abs(h[offset > response.reach_m]) < 1e-5 * h[0])
    assert abs(response(response.support_m)) <= 1.001e-3 * response(0.0)
    assert np.all(response(np.linspace(0.0, 0.999 * response.support_m, 500)) > 1e-3 * response(0.0))


def test_refusals() -> None:
    with pytest.raises(ValueError, match=r"radar.chirp_bandwidth_hz = 4e\+07: must be at least .* = 5e\+07"):
        RangeResponse(20e-9, 50e6, "chirp", 40e6)
    assert RangeResponse(20e-9, 50e6, "chirp", 50e6).gain > 0.5  # just one cycle is one
    with pytest.raises(ValueError, match="window = 'kaiser': must be one of none, hann"):
        RangeResponse(1e-6, 50e6, "chirp", 50e6, "kaiser")
    with pytest.raises(ValueError, match="waveform = 'noise': must be"):
        RangeResponse(1e-6, 50e6, "noise")


# ---------------------------------------------------------------------------------------------------------- gates


@pytest.mark.parametrize(
    ("adc_rate_hz", "wanted", "spacing"),
    [(50e6, 1.5, 2.99792458), (100e6, 1.5, 1.49896229), (200e6, 1.4, 1.49896229), (200e6, 0.1, 0.749481145)],
)
def test_a_digital_receiver_sets_the_spacing(adc_rate_hz: float, wanted: float, spacing: float) -> None:
    receiver = ReceiverSettings(chain="digital", adc_rate_hz=adc_rate_hz)
    radar = RadarSettings(receiver=receiver, range_sampling_m=wanted)
    assert gate_spacing_m(radar) == pytest.approx(spacing, rel=1e-12)
    ranges = gates(radar)
    np.testing.assert_allclose(np.diff(ranges), spacing, rtol=1e-9)
    assert ranges[0] == radar.range_m[0]
    assert radar.range_m[1] - spacing < ranges[-1] <= radar.range_m[1]
    assert gate_spacing_m(RadarSettings(range_sampling_m=wanted)) == wanted


def test_straddling_loss() -> None:
    # A long bare chirp at two gates per c/2B: sinc(¼), 0.912 dB at worst; on average ∫₀¹ sinc²(x/4) dx, by its series
    # 1 − y²/3 + 2y⁴/45 − y⁶/315 with ⟨yⁿ⟩ = (π/4)ⁿ/(n + 1). The wide filter and T Bc = 500 leave 0.003 dB.
    radar = RadarSettings(
        waveform="chirp",
        pulse_width_s=10e-6,
        compression_window="none",
        bandwidth_hz=1e9,
        range_sampling_m=0.5 * CELL,
    )
    worst, mean = straddling_loss_db(radar)
    y = np.pi / 4.0
    assert worst == pytest.approx(-20.0 * np.log10(np.sinc(0.25)), abs=0.005)
    series = 1.0 - y**2 / 9.0 + 2.0 * y**4 / 225.0 - y**6 / 2205.0
    assert mean == pytest.approx(-10.0 * np.log10(series), abs=0.005)
    # The plain 20 ns pulse at 1.5 m, from its error functions.
    worst, mean = straddling_loss_db(RadarSettings())
    response = RangeResponse(20e-9, 50e6)
    between = np.linspace(-0.75, 0.75, 2001)
    assert worst == pytest.approx(-float(2.0 * db(response(0.75) / response(0.0))), abs=1e-12)
    assert mean == pytest.approx(-float(db(np.mean((response(between) / response(0.0)) ** 2))), abs=1e-3)
    assert 0.0 < mean < worst


def test_blind_and_unambiguous_ranges() -> None:
    radar = RadarSettings(pulse_width_s=1e-6, prf_hz=10e3)
    assert blind_range_m(radar) == pytest.approx(149.896229, rel=1e-12)
    assert unambiguous_range_m(radar) == pytest.approx(14_989.6229, rel=1e-12)
