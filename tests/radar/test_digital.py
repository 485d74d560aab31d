"""The digital receiver against its linear chain: folding, quantisation, saturation, and the gain's two controls."""

from __future__ import annotations

import numpy as np
import pytest
from numpy.typing import NDArray

from seamap_rt.compute import machine
from seamap_rt.conventions import SPEED_OF_LIGHT, db, from_db
from seamap_rt.radar.digital import (
    DigitalReceiver,
    NyquistZone,
    decimation,
    full_scale_w,
    low_pass,
    quantisation_db,
    quantise,
    sensitivity_time_control,
)
from seamap_rt.radar.receiver import noise_power, thermal_noise
from seamap_rt.radar.waveform import RangeResponse, gates
from seamap_rt.settings import RadarSettings
from validation.radar.digital import noise_gains

ZONES = {1: 60e6, 2: 160e6, 3: 240e6, 4: 340e6, 7: 655e6}  # Hz at 200 MS/s; 4 and 7 lie 40 and 45 MHz off an edge


def radar_of(receiver: dict | None = None, **others) -> RadarSettings:
    return RadarSettings.model_validate({"receiver": {"chain": "digital", **(receiver or {})}, **others})


def full_scale_dbm(watts: float) -> float:
    return float(db(1e3 * watts))


def noise(radar: RadarSettings, receiver: DigitalReceiver, pulses: int, watts: float, seed: int = 1) -> NDArray:
    """Thermal noise (pulse, 2, sample) at the converter's instants, of the given mean power."""
    step = float(receiver.sample_range[1] - receiver.sample_range[0])
    volts = thermal_noise(radar, pulses, receiver.sample_range.size, np.random.default_rng(seed), spacing_m=step)
    return volts * np.float32(np.sqrt(watts / noise_power(radar)))


def echo(radar: RadarSettings, receiver: DigitalReceiver, range_m: float, volts: NDArray) -> NDArray:
    """A point reflector's envelope (pulse, 2, sample); volts (pulse, 2)."""
    shape = RangeResponse.of(radar)(receiver.sample_range - range_m)
    return (volts[..., None] * shape).astype(np.complex64)


def turning(pulses: int, seed: int = 2) -> NDArray:
    """Unit phasors (pulse, 2) of random phase."""
    return np.exp(2j * np.pi * np.random.default_rng(seed).random((pulses, 2)))


def with_image(radar: RadarSettings, receiver: DigitalReceiver, baseband: NDArray) -> NDArray:
    """What a real carrier leaves of an envelope: V + V* exp(−2jθ), θ the intermediate frequency's phase, which counts
    from the first gate. From the true frequency, so that the fold into a zone is not assumed."""
    step = SPEED_OF_LIGHT / (2.0 * radar.receiver.adc_rate_hz)
    instants = np.round((receiver.sample_range - receiver.range_m[0]) / step)
    cycles = np.remainder(instants * (radar.receiver.if_hz / radar.receiver.adc_rate_hz), 1.0)
    return baseband + baseband.conj() * np.exp(-4j * np.pi * cycles)


# ------------------------------------------------------------------------------------------ samples, gates, filter


@pytest.mark.parametrize("sampling", [0.3, 0.75, 1.3, 1.5, 3.0, 10.0])
def test_gates_fall_on_samples_as_near_to_the_asked_spacing_as_decimation_allows(sampling: float) -> None:
    radar = radar_of(range_sampling_m=sampling)
    receiver = DigitalReceiver(radar)
    step = SPEED_OF_LIGHT / 400e6
    np.testing.assert_allclose(np.diff(receiver.sample_range), step, rtol=1e-9)
    spacing = receiver.decimation * step
    assert abs(spacing - sampling) <= 0.5 * step or receiver.decimation == 1
    np.testing.assert_allclose(receiver.range_m, 15.0 + spacing * np.arange(receiver.range_m.size), atol=1e-9)
    np.testing.assert_allclose(receiver.range_m, gates(radar), rtol=1e-12)
    assert 400.0 - spacing < receiver.range_m[-1] <= 400.0
    # Half the filter to either side, and no more.
    half = low_pass(radar).size // 2
    np.testing.assert_allclose(receiver.sample_range[[half, -1 - half]], receiver.range_m[[0, -1]], atol=1e-9)


@pytest.mark.parametrize("others", [{}, {"range_sampling_m": 0.75}, {"range_sampling_m": 6.0}])
def test_the_low_pass_keeps_its_band_and_stops_what_folds_into_it(others: dict) -> None:
    radar = radar_of(**others)
    taps, zone = low_pass(radar), NyquistZone.of(radar)
    assert taps.size % 2 == 1
    assert taps.sum() == pytest.approx(1.0, abs=1e-12)
    np.testing.assert_array_equal(taps, taps[::-1])
    frequency = np.linspace(0.0, 100e6, 4001)
    level = np.abs(np.exp(-2j * np.pi * np.outer(frequency, np.arange(taps.size)) / 200e6) @ taps)
    rate = 200e6 / decimation(radar)
    stop = min(0.6 * rate, zone.room_hz)
    # Kaiser's formulas are fits, and meet the 60 dB asked for within 2 dB; the pass band's ripple is the same, 1e-3.
    assert db(level[frequency >= stop] ** 2).max() < -58.0
    assert np.abs(level[frequency <= 2.0 / 3.0 * stop] - 1.0).max() < 1.26e-3
    # What folds onto the pass band at the gates' rate lies in the stop band, and so does the converter's offset.
    assert rate - 2.0 / 3.0 * stop >= stop * (1.0 - 1e-12)
    assert zone.alias_hz >= stop


def test_the_linear_chain_is_the_filter_without_delay() -> None:
    radar = radar_of()
    receiver = DigitalReceiver(radar)
    envelope = noise(radar, receiver, 3, 1.0).astype(np.complex128)
    slow = np.array(
        [[np.convolve(row, receiver.taps, mode="valid")[:: receiver.decimation] for row in p] for p in envelope]
    )
    np.testing.assert_allclose(receiver.ideal(envelope), slow, atol=1e-12)
    gate = 100
    response = receiver.ideal(echo(radar, receiver, receiver.range_m[gate], np.ones((1, 2))))[0, 0].real
    np.testing.assert_allclose(response[gate - 20 : gate], response[gate + 20 : gate : -1], atol=1e-7)  # float32 in
    assert np.argmax(response) == gate


# --------------------------------------------------------------------------------------------------- Nyquist zones


@pytest.mark.parametrize("number", ZONES)
def test_zone_and_alias(number: int) -> None:
    zone = NyquistZone.of(radar_of({"if_hz": ZONES[number]}))
    assert zone.number == number
    assert zone.mirrored == (number % 2 == 0)
    # The alias is where a sampled cosine's line stands.
    line = np.abs(np.fft.rfft(np.cos(2.0 * np.pi * ZONES[number] / 200e6 * np.arange(1000))))
    assert zone.alias_hz == pytest.approx(200e3 * np.argmax(line))


@pytest.mark.parametrize("number", ZONES)
def test_phases_keep_their_sign_in_every_zone(number: int) -> None:
    radar = radar_of({"if_hz": ZONES[number], "adc_bits": 24})
    receiver = DigitalReceiver(radar)
    volts = 1e-4 * turning(200)
    volts[:, 1] = volts[:, 0] * np.exp(-0.8j)
    envelope = echo(radar, receiver, receiver.range_m[50], volts)
    digital, ideal = receiver(envelope).voltage[..., 50], receiver.ideal(envelope)[..., 50]
    # The image of a point reflector lies 40 dB below it (validation/radar/digital.py): 0.01 of its voltage. A wrong
    # sign of the phases would make the difference as large as the echo.
    assert np.abs(digital - ideal).max() < 0.02 * np.abs(ideal).min()
    assert np.angle(np.sum(digital[:, 0] * digital[:, 1].conj())) == pytest.approx(0.8, abs=1e-3)


@pytest.mark.parametrize("number", ZONES)
@pytest.mark.parametrize("stc", [0.0, 4.0])
def test_with_24_bits_only_the_image_is_added(number: int, stc: float) -> None:
    radar = radar_of({"if_hz": ZONES[number], "adc_bits": 24, "stc_exponent": stc}, range_m=(50.0, 400.0))
    receiver = DigitalReceiver(radar)
    envelope = noise(radar, receiver, 20, 0.02e-6) + echo(radar, receiver, 60.3, 0.7e-3 * turning(20))
    exact = receiver.ideal(with_image(radar, receiver, envelope))
    # Of the full scale of 1e-3 √W; float32 holds 24 bits, so samples are good to 6e-8 of it.
    assert np.abs(receiver(envelope).voltage - exact).max() < 1e-6 * 1e-3


def test_a_carrier_keeps_the_power() -> None:
    radar = radar_of()
    receiver = DigitalReceiver(radar)
    envelope = noise(radar, receiver, 400, 3e-9)
    # Some 2e5 independent samples of an exponential power: 0.2 % rms.
    assert np.mean(receiver.up(envelope) ** 2.0) == pytest.approx(np.mean(np.abs(envelope) ** 2.0), rel=0.01)


@pytest.mark.parametrize(
    ("receiver", "others", "words"),
    [
        ({"if_hz": 180e6}, {}, "choose 125 MHz to 175 MHz"),
        ({"if_hz": 200e6}, {}, "choose 225 MHz to 275 MHz"),
        ({"if_hz": 20e6}, {}, "choose 25 MHz to 75 MHz"),
        ({"adc_rate_hz": 80e6}, {}, "raise adc_rate_hz to at least 100 MHz"),
        ({}, {"bandwidth_hz": 90e6}, "choose 145 MHz to 155 MHz"),
    ],
)
def test_a_band_across_an_edge_is_refused(receiver: dict, others: dict, words: str) -> None:
    with pytest.raises(ValueError, match=words) as caught:
        DigitalReceiver(radar_of(receiver, **others))
    assert str(caught.value).startswith("radar.receiver.if_hz = ")
    assert "\n" not in str(caught.value)


def test_a_band_that_touches_an_edge_is_taken() -> None:
    assert NyquistZone.of(radar_of({"if_hz": 175e6})).room_hz == pytest.approx(25e6)


@pytest.mark.parametrize("if_hz", [150e6, 160e6, 170e6])
def test_thermal_noise_of_gates_is_that_of_band_and_image(if_hz: float) -> None:
    radar = radar_of({"if_hz": if_hz, "adc_bits": 24})
    receiver = DigitalReceiver(radar)
    envelope = noise(radar, receiver, 800, 1e-9)
    band, image = noise_gains(receiver)
    # 800 × 2 × 257 gates 1.5 times oversampled: 0.2 % rms of the mean power.
    assert np.mean(np.abs(receiver(envelope).voltage) ** 2) == pytest.approx(1e-9 * (band + image), rel=0.01)
    assert np.mean(np.abs(receiver.ideal(envelope)) ** 2) == pytest.approx(1e-9 * band, rel=0.01)
    # Independently: the Gaussian skirt that the fold brings into the band that the filter leaves.
    frequency = np.linspace(-60e6, 60e6, 2401)
    passed = np.abs(np.exp(-2j * np.pi * np.outer(frequency, np.arange(receiver.taps.size)) / 200e6) @ receiver.taps)
    apart = 2.0 * min(if_hz - 100e6, 200e6 - if_hz)
    skirt = np.exp(-np.pi * ((frequency + apart) / 50e6) ** 2) + np.exp(
        -np.pi * ((frequency + apart - 200e6) / 50e6) ** 2
    )
    # The converter folds once more beyond ±100 MHz (4e-6 of the power): left out here.
    assert image == pytest.approx(np.sum(passed**2 * skirt) * 50e3 / 50e6, rel=1e-3)


# ---------------------------------------------------------------------------------------------------- quantisation


@pytest.mark.parametrize("bits", range(6, 17))
def test_a_full_scale_sine_has_6_02_b_plus_1_76_db(bits: int) -> None:
    power = 1e-6
    phase = 2.0 * np.pi * np.remainder(np.arange(200_000) * (np.sqrt(5.0) - 1.0) / 2.0, 1.0)
    # A hair below full scale, so that float32 does not clip the crest.
    sine = (0.99999 * np.sqrt(2.0 * power) * np.cos(phase)).astype(np.float32)[None]
    found, clipped = quantise(sine, np.array([power]), bits)
    assert not clipped.any()
    # A sine dwells at its crests, where the error is not uniform: 2^(−b/2) of the power or so, 0.3 dB at 6 bits.
    sqnr = db(power / np.mean((found - sine).astype(float) ** 2))
    assert sqnr == pytest.approx(6.02 * bits + 1.76, abs=0.5 * 2.0 ** (0.5 * (6 - bits)) + 0.02)


@pytest.mark.parametrize("bits", [1, 2, 5, 12])
def test_levels_are_alike_to_either_side_of_zero_and_so_many(bits: int) -> None:
    samples = np.linspace(-2.0, 2.0, 100_001, dtype=np.float32)[None]
    found, clipped = quantise(samples, np.array([0.5]), bits)  # full scale ±1
    levels = np.unique(found)
    assert levels.size == 2**bits
    np.testing.assert_array_equal(levels, -levels[::-1])
    inside = np.abs(samples) < 1.0
    np.testing.assert_array_equal(clipped, ~inside & (samples != -1.0))
    assert np.abs(found - samples)[inside].max() <= 2.0**-bits * 1.0001  # half a step; float32
    assert np.abs(found).max() == pytest.approx(1.0 - 2.0**-bits)


def test_quantisation_noise_of_gates_falls_by_6_02_db_a_bit() -> None:
    # Thermal noise fills the converter to a sixth of its range: 5 steps at 6 bits, and one sample in 10⁹ clips.
    levels, predicted = [], []
    for bits in range(6, 17):
        radar = radar_of({"adc_bits": bits, "full_scale_dbm": full_scale_dbm(1e-6)})
        receiver = DigitalReceiver(radar)
        envelope = noise(radar, receiver, 200, 1e-6 / 18.0, seed=bits)
        envelope += echo(radar, receiver, 100.0, 2e-4 * turning(200))
        found = receiver(envelope)
        assert not found.saturated.any()
        error = found.voltage - receiver.ideal(with_image(radar, receiver, envelope))
        levels.append(float(db(np.mean(np.abs(error) ** 2))))
        # q²/12 = ⅔ P/4^b a real sample; the oscillator's √2 doubles it, the filter leaves Σ h².
        predicted.append(float(db(2.0 * 2.0 / 3.0 * 1e-6 / 4.0**bits * np.sum(receiver.taps**2))))
        np.testing.assert_allclose(db(receiver.quantisation_noise_power(1e-6)), predicted[-1], atol=1e-3)
    # 200 × 2 × 257 gates 1.5 times oversampled: 0.4 % rms, 0.02 dB.
    np.testing.assert_allclose(levels, predicted, atol=0.1)
    assert np.polyfit(np.arange(6, 17), levels, 1)[0] == pytest.approx(-6.02, abs=0.02)


def test_the_interferometric_phase_errs_as_quantisation_noise_makes_it() -> None:
    radar = radar_of({"adc_bits": 12, "full_scale_dbm": full_scale_dbm(1e-6)})
    receiver = DigitalReceiver(radar)
    pulses, chosen = 2000, np.arange(20, 250, 30)
    envelope = noise(radar, receiver, pulses, 4.0 * 1e-6 / 4.0**12)  # some steps: silence would not be busy
    for gate in chosen:
        envelope += echo(radar, receiver, receiver.range_m[gate], 2e-4 * turning(pulses, int(gate)))
    found = receiver(envelope).voltage[..., chosen]
    exact = receiver.ideal(with_image(radar, receiver, envelope))[..., chosen]
    products = [v[:, 0] * v[:, 1].conj() for v in (found, exact)]
    error = np.angle(products[0] * products[1].conj())
    snr = np.mean(np.abs(exact) ** 2) / receiver.quantisation_noise_power(1e-6)[0]
    # √(1/(2 SNR)) a channel, two channels. 16 000 phases: 0.6 % rms.
    assert np.sqrt(np.mean(error**2)) == pytest.approx(np.sqrt(1.0 / snr), rel=0.03)
    assert abs(np.mean(error)) < 5.0 * np.sqrt(1.0 / snr / error.size)


def test_one_bit_still_tells_the_phase() -> None:
    # Two receivers share half of their power. Each part of a comparator's correlation goes as the arc sine (Van Vleck
    # & Middleton 1966), which bends a phase of 0.5 rad at a coherence of ½ by 0.02 rad.
    radar = radar_of({"adc_bits": 1})
    receiver = DigitalReceiver(radar)
    envelope, common = noise(radar, receiver, 300, 1e-12), noise(radar, receiver, 300, 1e-12, seed=9)[:, 0]
    envelope[:, 0] += common * np.complex64(np.exp(0.5j))
    envelope[:, 1] += common
    voltage = receiver(envelope).voltage
    found = np.angle(np.sum(voltage[:, 0] * voltage[:, 1].conj()))
    assert found == pytest.approx(0.5, abs=0.04)  # 5e4 looks: 0.007 rad rms


def test_silence_stays_silent() -> None:
    radar = radar_of()
    receiver = DigitalReceiver(radar)
    silent = receiver(np.zeros((2, 2, receiver.sample_range.size), np.complex64))
    # The converter's offset of half a step, √2 of it after the oscillator, 60 dB down: far below its noise.
    step = 2.0 * np.sqrt(2.0 * 1e-6) / 2.0**12
    assert np.abs(silent.voltage).max() < 1e-3 * step
    assert not silent.saturated.any()


# ---------------------------------------------------------------------------------------- saturation and its cures

NEAR_M, FAR_M = 30.0, 300.0


def near_and_far(radar: RadarSettings, receiver: DigitalReceiver, near: NDArray, watts: float = 1e-12) -> NDArray:
    """Noise, an echo at 300 m 40 dB below full scale, and one at 30 m of the given voltages (pulse,) of full scale."""
    pulses = near.size
    volts = 1e-3 * turning(pulses)
    envelope = noise(radar, receiver, pulses, watts) + echo(radar, receiver, FAR_M, 0.01 * volts)
    return envelope + echo(radar, receiver, NEAR_M, near[:, None] * volts)


def nearest(receiver: DigitalReceiver, range_m: float) -> int:
    return int(np.argmin(np.abs(receiver.range_m - range_m)))


def test_a_strong_near_echo_clips_is_flagged_and_leaves_far_gates_alone() -> None:
    radar = radar_of()
    receiver = DigitalReceiver(radar)
    strong = near_and_far(radar, receiver, np.full(100, 5.0))
    found, quiet = receiver(strong), receiver(near_and_far(radar, receiver, np.zeros(100)))
    reach = 0.5 * receiver.taps.size * SPEED_OF_LIGHT / 400e6 + RangeResponse.of(radar).support_m
    far = receiver.range_m > NEAR_M + reach
    gate = nearest(receiver, NEAR_M)
    exact = receiver.ideal(strong)
    assert found.saturated[..., gate].all()
    assert np.abs(found.voltage[..., gate]).mean() < 0.5 * np.abs(exact[..., gate]).mean()
    assert not found.saturated[..., far].any()
    np.testing.assert_array_equal(found.voltage[..., far], quiet.voltage[..., far])
    # A flag's reach is the filter's main weights: the flagged gates lie about the echo, within a few gates of it.
    flagged = receiver.range_m[found.saturated.any(axis=(0, 1))]
    assert np.abs(flagged - NEAR_M).max() < 9.0
    # What is not flagged is right: but for clipped samples under small weights, each below a tenth of the largest.
    clear = ~found.saturated
    worst = np.abs(found.voltage - receiver.ideal(with_image(radar, receiver, strong)))[clear].max()
    assert worst < 0.07 * 5e-3
    assert not quiet.saturated.any()


def test_automatic_gain_follows_the_dwell_before() -> None:
    radar = radar_of({"gain": "agc", "agc_headroom_db": 6.0})
    receiver = DigitalReceiver(radar)
    near = np.ones(250)  # five dwells of 50 pulses: the echo is strong in the third alone
    near[100:150] = 10.0
    envelope = near_and_far(radar, receiver, near)
    found = receiver(envelope)
    level = (np.abs(envelope) ** 2).reshape(5, -1).max(axis=1) * float(from_db(6.0))
    np.testing.assert_allclose(found.full_scale, np.repeat(level[[0, 0, 1, 2, 3]], 50), rtol=1e-5)
    gate = nearest(receiver, NEAR_M)
    assert found.saturated[100:150, :, gate].all()
    found.saturated[100:150] = False
    assert not found.saturated.any()


def test_automatic_gain_cures_saturation() -> None:
    settings = {"full_scale_dbm": -60.0, "adc_bits": 14}
    fixed, agc = (DigitalReceiver(radar_of({**settings, "gain": gain})) for gain in ("fixed", "agc"))
    radar = fixed.radar
    envelope = near_and_far(radar, fixed, np.ones(150))
    assert fixed(envelope).saturated.any(axis=-1).all()
    found = agc(envelope)
    assert not found.saturated.any()
    error = np.abs(found.voltage - agc.ideal(with_image(radar, agc, envelope))) ** 2
    expected = agc.quantisation_noise_power(float(found.full_scale[0]))[0]
    # Gates are mostly quiet noise of a few steps; 7e4 of them: 0.5 % rms.
    assert np.mean(error) == pytest.approx(expected, rel=0.05)


def test_automatic_gain_counts_what_the_time_control_leaves() -> None:
    radar = radar_of({"gain": "agc", "agc_headroom_db": 0.0, "stc_exponent": 4.0})
    receiver = DigitalReceiver(radar)
    envelope = echo(radar, receiver, 50.0, 1e-3 * turning(10))
    weakened = np.abs(envelope) * np.minimum(receiver.sample_range / 100.0, 1.0) ** 2
    np.testing.assert_allclose(receiver(envelope).full_scale, weakened.max() ** 2, rtol=1e-5)  # float32


def test_automatic_gain_has_an_end() -> None:
    radar = radar_of({"gain": "agc", "agc_headroom_db": 10.0})
    receiver = DigitalReceiver(radar)
    found = receiver(np.zeros((60, 2, receiver.sample_range.size), np.complex64))
    np.testing.assert_allclose(found.full_scale, 10.0 * noise_power(radar))
    assert np.isfinite(found.voltage).all()


def test_time_control_saves_the_near_echo_and_costs_nothing_far() -> None:
    plain = DigitalReceiver(radar_of())
    radar = radar_of({"stc_exponent": 4.0, "stc_range_m": 100.0})
    receiver = DigitalReceiver(radar)
    # (30 m/100 m)^4 is 21 dB; the echo lies 14 dB above full scale. The noise covers a few steps even where weakened.
    envelope = near_and_far(radar, receiver, np.full(300, 5.0), 4e-9)
    found, without = receiver(envelope), plain(envelope)
    gate = nearest(receiver, NEAR_M)
    assert without.saturated[..., gate].all()
    assert not found.saturated.any()
    error = np.abs(found.voltage - receiver.ideal(with_image(radar, receiver, envelope))) ** 2
    predicted = receiver.quantisation_noise_power(1e-6)
    far = receiver.range_m > 100.0 + 0.5 * receiver.taps.size * SPEED_OF_LIGHT / 400e6
    np.testing.assert_array_equal(found.voltage[..., far], without.voltage[..., far])
    np.testing.assert_allclose(predicted[far], plain.quantisation_noise_power(1e-6)[far], rtol=1e-6)
    # Nearer, the noise is what the attenuation that was taken back makes it: 300 × 2 values a gate, 4 % rms each;
    # the far half of the filter weighs less than the near one.
    near = (receiver.range_m > 20.0) & (receiver.range_m < 90.0)
    assert np.mean(error[..., near] / predicted[near]) == pytest.approx(1.0, rel=0.05)
    gain = sensitivity_time_control(radar, receiver.range_m)
    np.testing.assert_allclose(predicted[near] * gain[near] ** 2 / predicted[-1], 1.0, atol=0.1)


def test_time_control_is_a_power_of_range_and_ends_at_the_window() -> None:
    radar = radar_of({"stc_exponent": 3.0, "stc_range_m": 200.0})
    gain = sensitivity_time_control(radar, [-5.0, 0.0, 15.0, 50.0, 200.0, 300.0])
    np.testing.assert_allclose(gain**2, [0.075**3, 0.075**3, 0.075**3, 0.25**3, 1.0, 1.0])
    np.testing.assert_array_equal(sensitivity_time_control(radar_of(), [1.0, 10.0, 500.0]), 1.0)


# ------------------------------------------------------------------------------------------------------------ manners


def test_the_bits_do_not_depend_on_threads_or_on_the_other_pulses(monkeypatch: pytest.MonkeyPatch) -> None:
    radar = radar_of()
    receiver = DigitalReceiver(radar)
    envelope = near_and_far(radar, receiver, np.full(300, 2.0))
    heard = []
    for count in (1, 2, 16):
        monkeypatch.setattr(machine, "threads", lambda count=count: count)
        heard.append(receiver(envelope))
    one = heard[0]
    for other in heard[1:]:
        np.testing.assert_array_equal(one.voltage, other.voltage)
        np.testing.assert_array_equal(one.saturated, other.saturated)
        np.testing.assert_array_equal(one.full_scale, other.full_scale)
    assert one.voltage.dtype == np.complex64
    assert one.saturated.dtype == bool


def test_a_receiver_that_did_not_sample_stays_nan() -> None:
    radar = radar_of({"gain": "agc"})
    receiver = DigitalReceiver(radar)
    envelope = near_and_far(radar, receiver, np.ones(60))
    envelope[::2, 0] = np.nan
    found = receiver(envelope)
    assert np.isnan(found.voltage[::2, 0]).all()
    assert np.isfinite(found.voltage[1::2]).all()
    assert np.isfinite(found.voltage[:, 1]).all()
    # The gain follows those that did.
    strongest = [np.nanmax(np.abs(dwell) ** 2) for dwell in (envelope[:50], envelope[:50])]
    np.testing.assert_allclose(found.full_scale, np.repeat(strongest, (50, 10)) * float(from_db(6.0)), rtol=1e-5)


def test_an_envelope_at_other_instants_is_refused() -> None:
    receiver = DigitalReceiver(radar_of())
    for chain in (receiver, receiver.ideal):
        with pytest.raises(ValueError, match="take the envelope at sample_range"):
            chain(np.zeros((1, 2, 100), np.complex64))


def test_each_bit_takes_six_decibels_off_the_converter_s_noise() -> None:
    levels = [quantisation_db(radar_of({"adc_bits": bits}), 1e-6) for bits in (8, 9, 12)]
    assert levels[0] - levels[1] == pytest.approx(20.0 * np.log10(2.0))
    assert levels[0] - levels[2] == pytest.approx(80.0 * np.log10(2.0))


@pytest.mark.parametrize("keys", [{}, {"receiver": {"adc_bits": 8}, "bandwidth_hz": 30e6}])
def test_the_converter_s_noise_is_the_digital_receiver_s(keys: dict) -> None:
    radar = radar_of(**{"range_m": [30.0, 150.0], **keys})
    full_scale = float(full_scale_w(radar, 0.0))
    there = DigitalReceiver(radar).quantisation_noise_power(full_scale).mean() / noise_power(radar)
    # The receiver's weights are float32.
    assert quantisation_db(radar, full_scale) == pytest.approx(float(db(there)), abs=1e-3)
