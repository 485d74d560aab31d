"""Chirps and digital receivers from one end of the echo chain to the other."""

from __future__ import annotations

from functools import cache

import numpy as np
import pytest
from exact_echoes import SEED, radar_of, relative_rms, sea_seen
from numpy.typing import NDArray

from seamap_rt.conventions import BOLTZMANN, SPEED_OF_LIGHT, db, from_db
from seamap_rt.echoes import expected_look_gates, from_scatterers, turn_voltages
from seamap_rt.echoes.turn import turn_echoes
from seamap_rt.mesh import polar_grid, surface_mesh
from seamap_rt.radar.digital import DigitalReceiver
from seamap_rt.radar.installation import Installation
from seamap_rt.radar.scan import pulses
from seamap_rt.radar.waveform import RangeResponse, blind_range_m, gates
from seamap_rt.scene import Scene
from seamap_rt.settings import RadarSettings, TracingSettings
from seamap_rt.tracing import Illumination
from seamap_rt.tracing.horizon import trace_horizon

CHIRP = {"waveform": "chirp", "pulse_width_s": 0.3e-6, "chirp_bandwidth_hz": 40e6}  # T B = 12; blind to 45 m
DIGITAL = {"receiver": {"chain": "digital", "adc_bits": 16, "full_scale_dbm": -45.0}}
WIDE = {"pattern": "gaussian", "azimuth_beamwidth_deg": 20.0, "elevation_beamwidth_deg": 60.0}
THERMAL = BOLTZMANN * 290.0 * 50e6 * float(from_db(3.0))


def scene_of(**radar) -> Scene:
    default = {"sector_deg": (0.0, 36.0), "range_m": (15.0, 120.0)}
    return Scene.model_validate({"name": "waveform", "radar": {**default, **radar}})


def flat_facets(radar: RadarSettings) -> tuple[Illumination, NDArray[np.float32]]:
    grid = polar_grid(Installation(radar), TracingSettings(), 0)
    level = np.zeros((grid.sweep.size, grid.ground_range.size))
    facets = trace_horizon(surface_mesh(grid, level, np.zeros((*level.shape, 3), np.float32)))
    return facets, np.broadcast_to(1e-4 * facets.horizontal_area, facets.height.shape).astype(np.float32)


# ------------------------------------------------------------------------------------------ power against expectation


@pytest.mark.parametrize("keys", [{}, CHIRP, DIGITAL], ids=["pulse", "chirp", "digital"])
def test_speckled_mean_is_the_expectation(keys: dict) -> None:
    # Half a turn. τc = 1 ms gives a look several samples; beams 1.3° wide two-way leave looks 1.8° apart nearly
    # independent, and blocks of four looks surely so: the standard error comes from the spread of 25 block means. Gates
    # that are eclipsed, down to 35 m, are held to it too.
    radar = radar_of(**keys, sector_deg=(0.0, 180.0), range_m=(35.0, 95.0), transmit="single")
    facets, rcs = flat_facets(radar)
    voltages = turn_voltages(facets, rcs, Installation(radar), pulses(Installation(radar), 0), 11, 1e-3)
    got = expected_look_gates(facets, rcs, Installation(radar), 1.8)
    for receiver in (0, 1):
        power = np.abs(voltages[:, receiver].astype(np.complex128)) ** 2
        blocks = power.reshape(25, -1, power.shape[1]).mean(axis=1) / got.power[0, receiver].mean(axis=0)
        error = (blocks.mean(axis=0) - 1.0) / (blocks.std(axis=0, ddof=1) / 5.0)
        assert np.abs(error).max() < 4.5  # of 41 gates: a Student variable of 24 degrees passes it once in 7000
        whole = blocks.mean(axis=1)
        assert abs(whole.mean() - 1.0) < 3.0 * whole.std(ddof=1) / 5.0
        assert whole.std(ddof=1) / 5.0 < 0.025


@cache
def _expected_mean(**keys) -> tuple[RadarSettings, NDArray[np.float64]]:
    wide = {"pattern": "gaussian", "elevation_beamwidth_deg": 90.0}
    radar = radar_of(**keys, antenna=wide, sector_deg=(0.0, 1.8), range_m=(20.0, 105.0), transmit="single")
    facets, rcs = flat_facets(radar)
    return radar, expected_look_gates(facets, rcs, Installation(radar), 1.8).power[0, 0, 0]


@pytest.mark.parametrize("window", ["none", "hamming"])
def test_a_chirps_gain_over_a_pulse_on_the_sea(window: str) -> None:
    # Beyond the eclipsed range: that of the responses' energies, noise being kTBF with either. Power falls as R⁻³ and
    # more across a response, which ±45 m of a chirp's sidelobes feel: 0.1 dB.
    radar, chirped = _expected_mean(**CHIRP, compression_window=window)
    plain_radar, plain = _expected_mean()
    offset = np.linspace(-60.0, 60.0, 24_001)
    energies = [np.trapezoid(RangeResponse.of(each)(offset) ** 2, offset) for each in (radar, plain_radar)]
    gain = float(db(energies[0] / energies[1]))
    # T for τ, and B for Bc (noise counts as kTBF whatever the sweep leaves of it); and a pulse of 20 ns loses 1.66 dB
    # of its energy in a filter of 50 MHz, which a sweep of 40 MHz hardly feels. Its sharp ends and the window: 0.3
    # dB.
    assert abs(gain - float(db(0.3e-6 / 20e-9 * 50.0 / 40.0)) - 1.66) < 0.3
    share = gates(radar) / blind_range_m(radar)
    np.testing.assert_allclose(db(chirped / plain)[share > 1.5], gain, atol=0.2)
    assert db(chirped / plain)[share < 0.5].max() < gain - 1.5  # eclipsed


@pytest.mark.parametrize(("range_m", "left"), [(90.0, 1.0), (27.0, 0.6)], ids=["clear", "eclipsed"])
def test_a_chirps_gain_over_a_pulse_on_a_reflector(range_m: float, left: float) -> None:
    # On a gate, so the peak itself: h(0)², the compression's gain. Of a pulse that begins while the transmitter is on
    # the share `left` comes in, and at its peak that share of the voltage. 1e-3 is what 2 samples per 1/Bc leave of
    # the skirts. The receiver's filter weighs the sweep's middle more than its ends: 0.6 becomes 0.608; Fresnel's
    # ripple does the rest.
    peaks, gain = [], []
    for keys in ({**CHIRP, "compression_window": "none"}, {}):
        scene = scene_of(**keys, noise=False, antenna=WIDE, sector_deg=(0.0, 4.0))
        gate = int(np.argmin(np.abs(gates(scene.radar) - range_m)))
        assert gates(scene.radar)[gate] == range_m
        reflector = [[0.0, np.sqrt(range_m**2 - 0.1**2), 5.0]]
        volts = np.abs(from_scatterers(scene, reflector, 1.0)["voltage"].values[0, 0])
        assert volts.argmax() == gate
        peaks.append(volts[gate])
        gain.append(RangeResponse.of(scene.radar).gain)
    assert abs(left - min(1.0, range_m / blind_range_m(scene_of(**CHIRP).radar))) < 1e-3
    found = peaks[0] / peaks[1] / np.sqrt(gain[0] / gain[1])
    np.testing.assert_allclose(found, left, rtol=2e-3 if left == 1.0 else 0.06)


def test_a_chirps_phases_are_the_paths() -> None:
    scene = scene_of(**CHIRP, noise=False, antenna=WIDE, sector_deg=(0.0, 4.0), baseline_m=0.9)
    echoes = from_scatterers(scene, [[3.0, 80.0, 0.5]], 1.0)
    k = 2.0 * np.pi * 1e10 / SPEED_OF_LIGHT
    paths = [np.sqrt(9.0 + 6400.0 + (4.5 + side * 0.45) ** 2) for side in (-1.0, 1.0)]
    for pulse in (0, 1, 100):
        volts = echoes["voltage"].values[pulse]
        gate = int(np.abs(volts[0]).argmax())
        for receiver in (0, 1):
            phase = -k * (paths[pulse % 2] + paths[receiver])
            # 1.2 m of gates about a peak 3.7 m wide: "exact to 1e-5 rad at the peak", and complex64's 1e-6 of it
            assert abs(np.angle(volts[receiver, gate].astype(complex) * np.exp(-1j * phase))) < 1e-3


# ----------------------------------------------------------------------------------------------------------- noise


def test_a_chirps_noise_beyond_the_eclipsed_gates_and_within() -> None:
    echoes = from_scatterers(scene_of(**CHIRP, range_m=(15.0, 135.0)), [[0.0, 1e4, 0.0]], 0.0)
    radar = scene_of(**CHIRP).radar
    power = np.mean(np.abs(echoes["voltage"].values.astype(complex)) ** 2, axis=(0, 1)) / THERMAL
    assert echoes.attrs["noise_power_w"] == pytest.approx(THERMAL, rel=1e-12)
    # A gate at r is made of raw samples from r to r + 45 m (its pulse's length), of which the receiver is on from 45 m.
    # 1000 pulses × 2: 2.2 % each.
    clear = gates(scene_of(**CHIRP, range_m=(15.0, 135.0)).radar) > blind_range_m(radar) + 8.0
    np.testing.assert_allclose(power[clear], 1.0, atol=0.10)
    np.testing.assert_allclose(power[clear].mean(), 1.0, atol=0.01)
    near = echoes["range"].values < 0.8 * blind_range_m(radar)
    assert (power[near] < 0.95).all()
    assert (np.diff(power[near]) > -0.08).all()  # more and more of the pulse's length


@pytest.mark.parametrize(("bits", "if_hz"), [(8, 160e6), (12, 160e6), (12, 126e6)])
def test_a_digital_receivers_noise_is_what_it_says(bits: int, if_hz: float) -> None:
    # Thermal noise and that of the converter, 1000 pulses × 2 × 71 gates: 0.3 %. With 8 bits a step is 1.4 times
    # the noise's rms in the samples, and adds a seventh of its power. 26 MHz off
    # the zone's edge the image of the filter's skirts adds some per cent.
    full_scale = -52.0 if bits == 8 else -30.0
    receiver = {"chain": "digital", "adc_bits": bits, "full_scale_dbm": full_scale, "if_hz": if_hz}
    echoes = from_scatterers(scene_of(receiver=receiver), [[0.0, 1e4, 0.0]], 0.0)
    power = np.mean(np.abs(echoes["voltage"].values.astype(complex)) ** 2)
    np.testing.assert_allclose(power, echoes.attrs["noise_power_w"], rtol=0.01)
    assert not echoes["saturated"].values.any()


# --------------------------------------------------------------------------------------------------- digital receivers


def test_a_digital_turn_is_the_converters_low_pass_on_the_same_voltages() -> None:
    # The echo summed at the converter's instants, up to the intermediate frequency and down again, is what the chain
    # gives, but for quantisation (16 bits: 1.5e-4 here). `ideal` is that without the image, 40 dB below an echo:
    # 0.01.
    radar = radar_of(**DIGITAL)
    facets, rcs, fired = sea_seen(radar)
    found = turn_voltages(facets, rcs, Installation(radar), fired, SEED, np.inf)
    spacing = SPEED_OF_LIGHT / (2.0 * radar.receiver.adc_rate_hz)
    digital = DigitalReceiver(radar)
    start = digital.sample_range[digital.sample_range > 1.0][0]
    fine = radar_of(range_sampling_m=spacing, range_m=(start, digital.sample_range[-1] + 0.1))
    samples = turn_voltages(facets, rcs, Installation(fine), fired, SEED, np.inf)
    baseband = np.zeros((fired.number.size, 2, digital.sample_range.size), np.complex64)
    baseband[..., -samples.shape[2] :] = samples
    assert abs(gates(fine)[-1] - digital.sample_range[-1]) < 1e-6
    assert relative_rms(found, digital.down(digital.up(baseband))) < 1e-3
    assert relative_rms(found, digital.ideal(baseband)) < 0.015


def test_a_digital_receivers_phases_are_those_of_baseband() -> None:
    # Reflectors 30 m apart and so each alone in its gates. 12 bits: what the converter adds turns a phase by √(1/2
    # SNR_q) in each receiver; the image, 40 dB below each echo, by 0.01 rad.
    ways = np.array([20.0, 50.0, 80.0, 110.0])
    xyz = np.stack((0.0 * ways, ways, np.zeros(4)), axis=-1)
    keys = {"noise": False, "antenna": WIDE, "sector_deg": (0.0, 8.0)}
    receiver = {"chain": "digital", "full_scale_dbm": -40.0}
    scene = scene_of(**keys, receiver=receiver)
    spacing = float(np.diff(gates(scene.radar))[0])
    plain = from_scatterers(scene_of(**keys, range_sampling_m=spacing), xyz, ways**4 * 1e-4)
    digital = from_scatterers(scene, xyz, ways**4 * 1e-4)
    assert not digital["saturated"].values.any()
    quantisation = DigitalReceiver(scene.radar).quantisation_noise_power(1e-3 * float(from_db(-40.0)))
    np.testing.assert_allclose(plain["range"], digital["range"], atol=1e-9)
    for way in ways:
        gate = int(np.argmin(np.abs(plain["range"].values - np.hypot(way, 5.0))))
        one, two = (each["voltage"].values[:, :, gate].astype(complex) for each in (plain, digital))
        turned = np.angle(one[:, 0] * one[:, 1].conj() * (two[:, 0] * two[:, 1].conj()).conj())
        rms = float(np.sqrt(quantisation[gate] / np.mean(np.abs(two) ** 2)))
        assert np.abs(turned).max() < 0.02 + 5.0 * rms
        assert rms < 2e-3


def test_a_near_echo_saturates_and_far_ones_are_unharmed() -> None:
    keys = {"noise": False, "antenna": WIDE, "sector_deg": (0.0, 4.0)}
    xyz, rcs = [[0.0, 20.0, 0.0], [0.0, 90.0, 0.0]], [10.0, 10.0]
    strong = float(db(1e3 * np.abs(from_scatterers(scene_of(**keys), xyz, rcs)["voltage"].values[0, 0]).max() ** 2))
    heard = {}
    for name, full_scale in (("clips", strong - 12.0), ("holds", strong + 6.0)):
        receiver = {"chain": "digital", "adc_bits": 16, "full_scale_dbm": full_scale}
        heard[name] = from_scatterers(scene_of(**keys, receiver=receiver), xyz, rcs)
    flags = heard["clips"]["saturated"].values.astype(bool)
    ranges = heard["clips"]["range"].values
    near, far = (int(np.argmin(np.abs(ranges - np.hypot(way, 5.0)))) for way in (20.0, 90.0))
    assert heard["clips"]["saturated"].dims == ("pulse", "range")
    assert flags[:, near].all()
    assert not flags[:, np.abs(ranges - ranges[near]) > 15.0].any()
    assert not heard["holds"]["saturated"].values.any()
    clipped, whole = (heard[name]["voltage"].values for name in ("clips", "holds"))
    assert np.abs(clipped[..., near]).mean() < 0.6 * np.abs(whole[..., near]).mean()
    # 16 bits of a full scale some 25 dB over the far echo
    np.testing.assert_allclose(clipped[..., far], whole[..., far], atol=3e-3 * np.abs(whole[..., far]).max())


def test_silent_receivers_stay_silent_behind_a_converter() -> None:
    keys = {"interferogram": "alternating_pulse", "receiver": {"chain": "digital"}, "sector_deg": (0.0, 4.0)}
    echoes = from_scatterers(scene_of(**keys), [[0.0, 30.0, 0.0]], 1.0)
    silent = np.isnan(echoes["voltage"].values)
    assert silent[::2, 1].all()
    assert silent[1::2, 0].all()
    assert not silent[::2, 0].any()
    assert not silent[1::2, 1].any()


def test_what_saturates_a_turn_is_told() -> None:
    radar = radar_of(receiver={"chain": "digital", "full_scale_dbm": -58.0})
    facets, rcs, fired = sea_seen(radar)
    received = turn_echoes(facets, 10.0 * rcs, Installation(radar), fired, SEED, np.inf)
    assert received.saturated is not None
    assert received.saturated.shape == (fired.number.size, gates(radar).size)
    share = received.saturated.mean(axis=0)
    assert share[:5].mean() > share[-5:].mean()
    assert turn_echoes(facets, rcs, Installation(radar_of()), fired, SEED, np.inf).saturated is None
