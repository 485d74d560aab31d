"""The link budget: the study's figures, closed forms, and the textbook's echo against the simulator's integral."""

from __future__ import annotations

import math
from typing import Any

import numpy as np
import pytest
from numpy.testing import assert_allclose

from seamap_rt.conventions import db, from_db, radar_wavelength
from seamap_rt.radar import link
from seamap_rt.radar.chirp import Chirp
from seamap_rt.radar.receiver import noise_power
from seamap_rt.radar.waveform import RangeResponse, blind_range_m, gates
from seamap_rt.settings import RadarSettings
from validation.analytic import flat_sea_power, flat_sea_power_textbook

STUDY = RadarSettings()  # 10 GHz, 50 MHz, 3 dB, 2 dB of losses, 1 W, 20 ns, 1.8°: the design of 2004
RANGES = np.array([30.0, 50.0, 100.0, 200.0, 400.0])


def radar_of(**keys: Any) -> RadarSettings:
    return RadarSettings.model_validate(keys)


# ------------------------------------------------------------------------------------------ the study's figures


def test_noise() -> None:
    # kTBF by hand: 1.380649e-23 · 290 · 50e6 · 10^0.3 W = −93.985 dBm.
    assert_allclose(db(1e3 * noise_power(STUDY)), -93.98, atol=0.01)


def test_cell() -> None:
    assert_allclose(link.cell_area(STUDY, 100.0), 9.43, atol=0.005)  # two digits are given
    assert_allclose(link.range_cell_m(STUDY), 2.998, atol=5e-4)


@pytest.mark.parametrize(("efficiency", "gain", "weakest"), [(1.0, 31.45, -51.2), (0.6, 29.2, -46.8)])
def test_weakest_sea_of_the_textbook(efficiency: float, gain: float, weakest: float) -> None:
    size = STUDY.antenna.width_m * STUDY.antenna.height_m
    aperture = 4.0 * np.pi * efficiency * size / radar_wavelength(STUDY.frequency_hz) ** 2
    assert_allclose(db(aperture), gain, atol=0.05)  # the digits given
    unity = link.textbook_power(STUDY, 1.0, 100.0, aperture)
    assert_allclose(db(link.minimum_nrcs(STUDY, unity)), weakest, atol=0.05)
    fifty = link.minimum_nrcs(STUDY, unity, link.noncoherent_gain(50))
    assert_allclose(db(fifty), weakest - 8.5, atol=0.05)


def test_footprint() -> None:
    assert_allclose(link.footprint_m(STUDY, [100.0, 200.0]), [np.pi, 2.0 * np.pi], rtol=1e-3)  # 1.8° is π/100 rad


# ------------------------------------------------------------------------------------------------- integration


@pytest.mark.parametrize("pulses", [1, 2, 7, 50])
@pytest.mark.parametrize("memory", [1e-4, 3e-3, 0.01, 1.0])
def test_coherent_gain_is_the_double_sum(pulses: int, memory: float) -> None:
    times = 1e-4 * np.arange(pulses)
    correlation = np.exp(-(((times[:, None] - times) / memory) ** 2))
    expected = correlation.sum() / pulses  # signal power of the sum, N² of it if all agree, over N shares of noise
    assert_allclose(link.coherent_gain(pulses, 1e-4, memory), expected, rtol=1e-12)


def test_coherent_gain_of_still_and_of_forgetful_seas() -> None:
    assert_allclose(link.coherent_gain(50, 1e-4, np.inf), 50.0, rtol=1e-15)
    assert_allclose(link.coherent_gain(50, 1e-4, 1e-6), 1.0, rtol=1e-15)
    # Many pulses: √π τc/T less ((τc/T)² − 1/6)/N, the triangle's slope and, by Euler and Maclaurin, its kink at lag 0;
    # their next term is 2/(120 N (τc/T)²), 1e-11 here.
    rate, pulses = 20.0, 100_000
    expected = np.sqrt(np.pi) * rate - (rate**2 - 1.0 / 6.0) / pulses
    assert_allclose(link.coherent_gain(pulses, 1e-4, rate * 1e-4), expected, rtol=1e-10)
    # A short dwell, x = D/τc long, loses x²/6 (1 − 1/N²) − x⁴/30 + x⁶/168 of N; 1/N² of the second term is left out.
    x = 0.5
    expected = x**2 / 6.0 * (1.0 - 1.0 / 50**2) - x**4 / 30.0 + x**6 / 168.0
    assert_allclose(1.0 - link.coherent_gain(50, 1e-4, 0.01) / 50.0, expected, atol=3e-6)


def test_coherent_gain_of_drawn_echoes() -> None:
    # Correlated Gaussian pulses in white noise, added: the ratio of mean powers. 4000 draws give each of them 1/√4000
    # and the ratio 2.2 %: four standard errors.
    random, pulses, interval, memory = np.random.default_rng(5), 50, 1e-4, 3e-3
    times = interval * np.arange(pulses)
    correlation = np.exp(-(((times[:, None] - times) / memory) ** 2))
    values, vectors = np.linalg.eigh(correlation)
    root = vectors * np.sqrt(np.maximum(values, 0.0))
    drawn = random.standard_normal((2, 4000, pulses, 2)) @ np.array([1.0, 1j]) / np.sqrt(2.0)
    signal, noise = drawn[0] @ root.T, drawn[1]
    gain = np.mean(np.abs(signal.sum(axis=1)) ** 2) / np.mean(np.abs(noise.sum(axis=1)) ** 2)
    assert_allclose(gain, link.coherent_gain(pulses, interval, memory), rtol=4 * 0.022)


@pytest.mark.parametrize(
    ("keys", "pulses", "interval"),
    [
        ({}, 50, 1e-4),
        ({"transmit": "single"}, 50, 1e-4),
        ({"interferogram": "alternating_pulse"}, 25, 2e-4),
        ({"transmit": "single", "interferogram": "alternating_pulse"}, 25, 2e-4),
        ({"rotation_rpm": 30.0}, 100, 1e-4),
        ({"prf_hz": 5e3}, 25, 2e-4),
        ({"antenna": {"azimuth_beamwidth_deg": 3.6}}, 100, 1e-4),
        ({"antenna": {"pattern": "isotropic"}}, 50, 1e-4),  # no beam of its own: the scene's key
        ({"scan": "staring", "stare_s": 0.02}, 200, 1e-4),
    ],
)
def test_dwell(keys: dict[str, Any], pulses: int, interval: float) -> None:
    got = link.dwell(radar_of(**keys))
    assert got.pulses == pulses
    assert_allclose(got.interval_s, interval, rtol=1e-12)
    assert_allclose(got.duration_s, pulses * interval, rtol=1e-6)  # the beam is measured to a root finder's tolerance


# ------------------------------------------------------------------------------------------- power from the sea


def test_the_textbook_stands_twice() -> None:
    # radar/ and analytic/ each write the equation down; only the beam width comes another way (measured, and asked).
    for keys in ({}, {"antenna": {"pattern": "gaussian"}}, {"height_m": 25.0}, {"pulse_width_s": 50e-9}):
        radar = radar_of(**keys)
        expected = flat_sea_power_textbook(radar, 3e-4, RANGES)
        assert_allclose(link.textbook_power(radar, 3e-4, RANGES), expected, rtol=1e-6)


@pytest.mark.parametrize("pattern", ["slotted_waveguide", "gaussian"])
@pytest.mark.parametrize("keys", [{}, {"tilt_deg": 4.0}, {"pulse_width_s": 40e-9}, {"height_m": 3.0}])
def test_losses_add_up_to_the_integral(pattern: str, keys: dict[str, Any]) -> None:
    # Left out of the sum: the slope of R⁻³ and of the elevation pattern within a cell, of second order, and sec ψ: 0.01
    # dB at 50 m for the pulses and heights here.
    radar, ranges = radar_of(antenna={"pattern": pattern}, **keys), RANGES[1:]
    gap = db(link.textbook_power(radar, 1.0, ranges) / flat_sea_power(radar, 1.0, ranges))
    losses = link.losses_to_textbook(radar, ranges)
    assert_allclose(losses.azimuth + losses.elevation + losses.response, gap, atol=0.02)


def test_losses_of_closed_form() -> None:
    # Gaussian beam: ∫ exp(−8 ln2 (α/θ)²) dα = θ √(π/(8 ln2)), −1.234 dB; three beams to either side hold all but 1e-14.
    radar = radar_of(antenna={"pattern": "gaussian"}, height_m=100.0 * np.sin(np.radians(9.0)))
    losses = link.losses_to_textbook(radar, 100.0)
    assert_allclose(losses.azimuth, -db(np.sqrt(np.pi / (8.0 * np.log(2.0)))), atol=1e-6)
    assert_allclose(losses.elevation, 2.0 * db(2.0), atol=1e-9)  # the sea lies half a beam below the boresight
    # Each edge of a pulse, rounded by a Gaussian of σ = 1/(2√π B), costs σ/√π: ∫h² = τ − 1/(πB) for τB ≫ 1.
    long = radar_of(pulse_width_s=200e-9)
    assert_allclose(link.losses_to_textbook(long, 100.0).response, -db(1.0 - 1.0 / (np.pi * 10.0)), atol=1e-7)


def test_gain_towards_the_sea() -> None:
    radar = radar_of(antenna={"pattern": "gaussian"}, height_m=10.0, tilt_deg=9.0)
    ranges = 10.0 / np.sin(np.radians([9.0, 18.0]))
    peak = link.antenna(radar).gain
    assert_allclose(link.gain_towards_sea(radar, ranges), [peak, 0.5 * peak], rtol=1e-9)


@pytest.mark.parametrize(("key", "factor"), [("transmit_power_w", 0.1), ("noise_figure_db", None)])
def test_weakest_sea_follows_power_and_noise(key: str, factor: float | None) -> None:
    ten = radar_of(**{key: 10.0 if factor else 13.0})
    weakest = [link.minimum_nrcs(r, link.textbook_power(r, 1.0, RANGES)) for r in (STUDY, ten)]
    assert_allclose(weakest[1] / weakest[0], factor or 10.0, rtol=1e-12)


def test_weakest_sea_grows_as_the_cube_of_range() -> None:
    flat = radar_of(height_m=0.2)  # sec ψ is 1 to 2e-5
    weakest = link.minimum_nrcs(flat, link.textbook_power(flat, 1.0, RANGES))
    assert_allclose(weakest / weakest[0], (RANGES / RANGES[0]) ** 3, rtol=1e-4)


def test_no_sea_under_the_antenna() -> None:
    with pytest.raises(ValueError, match=r"range_m = 5: must be greater than radar.height_m = 5"):
        link.grazing_angle(STUDY, [100.0, 5.0])


# ------------------------------------------------------------------------------------------------------ chirps


def test_a_chirp_that_fills_the_receiver_is_worth_its_energy() -> None:
    # c/(2B) of range with a gain of T B is cT/2 of range without one, and the noise is the same.
    chirp = radar_of(waveform="chirp", pulse_width_s=1e-6)
    pulse = radar_of(pulse_width_s=1e-6)
    assert_allclose(link.textbook_power(chirp, 1.0, RANGES), link.textbook_power(pulse, 1.0, RANGES), rtol=1e-12)
    assert_allclose(link.cell_area(chirp, RANGES), link.cell_area(STUDY, RANGES), rtol=1e-12)
    assert_allclose(link.compression_gain(chirp), 50.0, rtol=1e-12)


def test_a_chirps_signal_to_noise_is_energy_over_density() -> None:
    # P T/(k T₀ F) of a cell of c/(2 Bc): what the receiver lets through beyond the chirp changes nothing.
    narrow, wide = (radar_of(waveform="chirp", chirp_bandwidth_hz=20e6, bandwidth_hz=b) for b in (20e6, 80e6))
    weakest = [link.minimum_nrcs(r, link.textbook_power(r, 1.0, RANGES)) for r in (narrow, wide)]
    assert_allclose(weakest[1], weakest[0], rtol=1e-12)


@pytest.mark.parametrize("window", ["none", "hamming", "taylor"])
def test_eclipsed_share(window: str) -> None:
    # Energy of the exact path's response to reflectors all around a gate, over that far away. The tail's spectrum has
    # Fresnel ripples at its ends, 1/√(T B) = 0.1 wide, which the share in frequency smooths: 0.004 is seen at TB = 100.
    radar = radar_of(waveform="chirp", pulse_width_s=2e-6, compression_window=window, range_m=(15.0, 500.0))
    chirp, gate = Chirp(radar), gates(radar)
    offset = np.arange(-60.0, 60.0, 0.25)
    whole = np.sum(RangeResponse.of(radar)(offset) ** 2)
    chosen = [40, 90, 150, 180, 220, 280]
    got = [np.sum(np.abs(chirp.response(gate[n] + offset)[:, n]) ** 2) / whole for n in chosen]
    assert gate[chosen[3]] < blind_range_m(radar) < gate[chosen[4]]
    assert_allclose(link.eclipsed_share(radar, gate[chosen]), got, atol=0.01)


def test_a_pulse_is_not_eclipsed() -> None:
    assert np.all(link.eclipsed_share(STUDY, [6.0, 100.0]) == 1.0)


# --------------------------------------------------------------------------------------------------- crossings


def test_furthest() -> None:
    ranges = np.geomspace(10.0, 1000.0, 40)
    assert_allclose(link.furthest(ranges, (123.0 / ranges) ** 3), 123.0, rtol=1e-12)  # a power law is straight
    assert np.isnan(link.furthest(ranges, np.full(40, 0.99)))
    assert np.isinf(link.furthest(ranges, np.full(40, 1.0)))
    notched = np.where((ranges > 20.0) & (ranges < 60.0), 0.0, (123.0 / ranges) ** 3)
    assert_allclose(link.furthest(ranges, notched), 123.0, rtol=1e-12)


def test_budget_of_ratios() -> None:
    ways = link.integrations(STUDY, 0.01)
    unity, nrcs = link.textbook_power(STUDY, 1.0, RANGES), from_db([-30.0, -35.0, -40.0, -45.0, -50.0])
    got = link.budget(STUDY, "textbook", unity, nrcs, ways)
    gains = np.array([way.gain for way in ways])[:, None]
    assert_allclose(got.power, unity * nrcs, rtol=1e-15)
    assert_allclose(got.snr, unity * nrcs / noise_power(STUDY) * gains, rtol=1e-12)
    assert_allclose(got.minimum_nrcs * got.snr, np.broadcast_to(nrcs, (3, 5)), rtol=1e-12)


# ------------------------------------------------------------------------------------------ the window


def test_shadows_grow_with_slope_and_fall_with_the_mast() -> None:
    low, high = (radar_of(range_m=[30.0, 150.0], height_m=height) for height in (3.0, 10.0))
    assert link.shadowed_share(low, 0.0) == 0.0
    shares = [link.shadowed_share(low, variance) for variance in (1e-5, 1e-4, 1e-3, 1e-2)]
    assert shares == sorted(shares)
    assert shares[0] < 1e-3
    assert link.shadowed_share(high, 1e-2) < shares[-1] < 1.0


def test_the_window_outside_a_model_is_counted_by_length() -> None:
    radar = radar_of(range_m=[20.0, 120.0], height_m=10.0)
    # 30° at 20 m, 14.478° at 40 m, 4.780° at 120 m: a fifth of the window is steeper, to one of 400 ranges.
    assert link.share_outside(radar, 0.1, math.degrees(math.asin(0.25))) == pytest.approx(0.2, abs=1.0 / 400.0)
    assert link.share_outside(radar, 0.1, 60.0) == 0.0


def test_an_object_is_told_from_the_sea_of_its_cell() -> None:
    radar = radar_of(range_m=[30.0, 150.0])
    over = [link.signal_to_clutter_db(radar, 20.0, level, 100.0) for level in (1e-4, 1e-3)]
    assert over[0] - over[1] == pytest.approx(10.0)
    # 100 m × 1.8° × 3 m is 9.4 m².
    assert over[0] == pytest.approx(20.0 + 40.0 - 10.0 * math.log10(100.0 * math.radians(1.8) * 2.998), abs=0.02)
