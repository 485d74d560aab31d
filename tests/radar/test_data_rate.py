"""Bytes per second: counted, and the study's figure against its readings."""

from __future__ import annotations

import numpy as np
import pytest

from seamap_rt.radar.digital import DigitalReceiver
from seamap_rt.radar.receiver import data_rate, sampled_receivers
from seamap_rt.settings import PlacedAntenna, RadarSettings
from validation.claims.data_rate import Reading, claim_data_rate


def radar_of(**others) -> RadarSettings:
    return RadarSettings.model_validate({"receiver": {"chain": "digital"}, **others})


@pytest.mark.parametrize("sampling", [1.3, 1.5])
def test_gates_of_complex64_are_the_bytes_of_the_array(sampling: float) -> None:
    radar = radar_of(range_sampling_m=sampling)
    receiver = DigitalReceiver(radar)
    gates = np.zeros((10_000, 2, receiver.range_m.size), np.complex64)
    assert data_rate(radar).complex_32 == gates.nbytes
    assert data_rate(radar).complex_12 == gates.nbytes * 24 / 64
    # And the raw samples of the gates' window: 12 bits each.
    samples = (receiver.sample_range >= 15.0 - 1e-9) & (receiver.sample_range <= 400.0)
    assert data_rate(radar).raw == 10_000 * 2 * samples.sum() * 1.5


def test_rates_follow_prf_window_bits_and_mode() -> None:
    radar = radar_of()
    assert data_rate(radar_of(prf_hz=5e3)).raw == pytest.approx(0.5 * data_rate(radar).raw)
    assert data_rate(radar_of(interferogram="alternating_pulse")) == tuple(0.5 * each for each in data_rate(radar))
    # One sample in 500 is the most by which a fence has more posts than rails.
    assert data_rate(radar, near_m=0.0).raw == pytest.approx(400.0 / 385.0 * data_rate(radar).raw, rel=2e-3)
    assert data_rate(radar_of(receiver={"chain": "digital", "adc_bits": 6})).raw == 0.5 * data_rate(radar).raw
    coarse = data_rate(radar_of(receiver={"chain": "baseband"}, range_sampling_m=3.0))
    assert coarse.complex_16 == 10_000 * 2 * 129 * 4


def test_every_antenna_that_receives_is_sampled() -> None:
    places = ({"role": "tx"}, {"role": "rx"}, {"role": "both"}, {"role": "rx"})
    antennas = tuple(PlacedAntenna.model_validate({"offset_m": (0.0, 0.0, 0.1), **place}) for place in places)
    assert sampled_receivers(radar_of(antennas=antennas)) == 3
    assert sampled_receivers(radar_of()) == 2
    assert sampled_receivers(radar_of(interferogram="alternating_pulse")) == 1


def test_which_readings_give_the_studys_32_megabytes_a_second() -> None:
    # 2 · 400 m/c = 2.6685 µs: 534 samples at 200 MS/s, 267 at 100, 134 at 50, times 10 kHz.
    rates = {(r.receivers, r.sampling, r.bits): r for r in claim_data_rate()}
    assert rates[1, "real 200 MS/s", 12].bytes_per_second == pytest.approx(8.01e6, rel=1e-3)
    assert rates[2, "real 200 MS/s", 16].bytes_per_second == pytest.approx(21.36e6, rel=1e-3)
    assert rates[2, "complex 50 MS/s", 64].bytes_per_second == pytest.approx(21.44e6, rel=1e-3)
    assert rates[2, "complex 100 MS/s", 48].bytes_per_second == pytest.approx(32.04e6, rel=1e-3)
    # Neither the converter's own samples nor gates at the band's own 50 MS/s do. At 100 MS/s one reading does; the two
    # at 200 MS/s store twice what the converter gives.
    assert {key for key, reading in rates.items() if reading.fits} == {
        (2, "complex 100 MS/s", 48),
        (2, "complex 200 MS/s", 24),
        (1, "complex 200 MS/s", 48),
    }


@pytest.mark.parametrize(("rate", "fits"), [(30.9e6, False), (31.1e6, True), (32.9e6, True), (33.55e6, False)])
def test_a_reading_fits_within_3_percent(rate: float, fits: bool) -> None:
    assert Reading(1, "real", 12, rate).fits is fits  # the last are 32 MiB
