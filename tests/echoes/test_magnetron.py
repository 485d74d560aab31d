"""A magnetron's pulses: what they have in common stays, what they have each of their own is as its laws say."""

from __future__ import annotations

from functools import cache

import numpy as np
import pytest
from exact_echoes import MODES, SEED, radar_of, relative_rms, sea_seen
from numpy.typing import NDArray
from scipy.stats import kstest

import seamap_rt as sr
from seamap_rt.conventions import SPEED_OF_LIGHT
from seamap_rt.echoes import expected_look_gates, turn_voltages
from seamap_rt.echoes.receiving import Magnetron
from seamap_rt.radar.installation import Installation
from seamap_rt.radar.receiver import MOST_STRAY, phase_drift_in_pulse, pulse_coherence
from seamap_rt.radar.scan import pulses
from seamap_rt.radar.waveform import gates
from seamap_rt.scene import Scene
from seamap_rt.settings import RadarSettings

MAGNETRON = {"transmitter": "magnetron"}
MEASURED = {**MAGNETRON, "coherent_on_receive": True}


@cache
def voltages(mode: tuple[str, str], **radar: object) -> NDArray[np.complex128]:
    """(pulse, receiver, gate) of a small sea whose speckle does not change."""
    settings = radar_of(transmit=mode[0], interferogram=mode[1], **radar)
    facets, rcs, at, fired = _lit(settings)
    return turn_voltages(facets, rcs, Installation(at), fired, SEED, np.inf).astype(np.complex128)


def _lit(radar: RadarSettings):
    facets, rcs, fired = sea_seen(radar, height_m=0.0)
    return facets, rcs, radar, fired


# ---------------------------------------------------------------------------------------- phases, pulse by pulse


@pytest.mark.parametrize("mode", MODES)
def test_within_a_pulse_nothing_changes(mode: tuple[str, str]) -> None:
    """Amplitudes, and the products of what two receivers hear of one pulse, to float32's rounding."""
    plain, random = voltages(mode), voltages(mode, **MAGNETRON)
    assert relative_rms(np.abs(random), np.abs(plain)) < 3e-7
    if mode[1] == "single_pulse":
        both = [each[:, 0] * each[:, 1].conj() for each in (random, plain)]
        assert relative_rms(*both) < 3e-7


def test_each_pulse_starts_anywhere_for_all_gates_and_receivers_alike() -> None:
    plain, random = (voltages(MODES[0], prf_hz=40e3, **each) for each in ({}, MAGNETRON))
    turned = random * plain.conj()
    phase = np.angle(turned.sum(axis=(1, 2)))
    np.testing.assert_allclose(np.angle(turned * np.exp(-1j * phase)[:, None, None]), 0.0, atol=1e-5)
    assert phase.size > 400
    assert kstest(phase / (2.0 * np.pi) + 0.5, "uniform").pvalue > 0.001
    follows = np.mean(np.exp(1j * np.diff(phase)))
    assert abs(follows) < 3.5 / np.sqrt(phase.size)  # a Rayleigh deviate is above that once in two hundred thousand


def test_a_pulse_keeps_its_phase_whatever_else_is_sent() -> None:
    """It depends on seed and number alone: not on the sector, nor on what turns came before."""
    whole = radar_of(**MEASURED, sector_deg=(0.0, 360.0), frequency_jitter_hz=1e5)
    part = whole.model_copy(update={"sector_deg": (0.0, 90.0)})
    all_of_it, quarter = (Magnetron.of(radar, pulses(Installation(radar), 1), SEED) for radar in (whole, part))
    other, before = (
        Magnetron.of(part, pulses(Installation(part), 1), SEED + 1),
        Magnetron.of(part, pulses(Installation(part), 0), SEED),
    )
    assert all_of_it is not None
    assert quarter is not None
    count = quarter.phase.size
    for name in ("phase", "carrier", "measured"):
        np.testing.assert_array_equal(getattr(all_of_it, name)[:count], getattr(quarter, name))
        for unlike in (other, before):
            assert not np.isin(getattr(unlike, name), getattr(quarter, name)).any()
    # 10,000 pulses: relative standard errors of 1/√20,000, correlations within four of 1/√10,000.
    assert all_of_it.measured is not None
    error = all_of_it.measured - all_of_it.phase
    np.testing.assert_allclose(np.std(all_of_it.carrier), 1e5, rtol=0.03)
    np.testing.assert_allclose(np.std(error), np.radians(whole.transmit_phase_error_deg), rtol=0.03)
    off = np.asarray(np.corrcoef([np.sin(all_of_it.phase), all_of_it.carrier, error]))[np.triu_indices(3, 1)]
    assert np.abs(off).max() < 0.04


def test_a_coherent_transmitter_draws_nothing() -> None:
    radar = radar_of(frequency_jitter_hz=1e5, coherent_on_receive=True)
    assert Magnetron.of(radar, pulses(Installation(radar), 0), SEED) is None
    np.testing.assert_array_equal(
        voltages(MODES[0], frequency_jitter_hz=1e5, coherent_on_receive=True), voltages(MODES[0])
    )


# --------------------------------------------------------------------------------------------- what is taken off


@pytest.mark.parametrize("degrees", [0.0, 20.0, 60.0])
def test_coherence_between_pulses_after_their_phases_are_taken_off(degrees: float) -> None:
    """exp(−σ²), of pulses that both err by σ: of alternating receivers, and of one receiver's next pulses."""
    law = np.exp(-(np.radians(degrees) ** 2))
    chosen = {**MEASURED, "transmit_phase_error_deg": degrees}
    assert pulse_coherence(radar_of(**chosen)) == pytest.approx(law)
    mode = ("single", "alternating_pulse")
    plain, left = (np.nan_to_num(voltages(mode, prf_hz=40e3, **each)) for each in ({}, chosen))
    turned = np.sum(left * plain.conj(), axis=(1, 2))  # of each pulse, whichever receiver heard it
    turned /= np.abs(turned)
    for step in (1, 2):
        product = turned[step:] * turned[:-step].conj()
        # |product| is 1: each part of it varies by less than 1 − law² in all, and a pulse stands in two of them.
        error = np.sqrt(2.0 * (1.0 - law**2) / product.size)
        assert abs(product.mean() - law) < 4.0 * error + 1e-5


def test_without_measurement_pulses_have_nothing_in_common() -> None:
    random = voltages(MODES[0], prf_hz=40e3, **MAGNETRON)[:, 0]
    cross = np.sum(random[1:] * random[:-1].conj()) / np.sum(np.abs(random[1:]) ** 2)
    assert abs(cross) < 3.5 / np.sqrt(len(random))
    assert pulse_coherence(radar_of(**MAGNETRON)) == 0.0
    assert pulse_coherence(radar_of()) == 1.0


@pytest.mark.parametrize("mode", MODES)
def test_the_expected_covariance_holds_what_the_transmitter_leaves(mode: tuple[str, str]) -> None:
    chosen = {**MEASURED, "transmit_phase_error_deg": 30.0}
    made = []
    for keys in ({}, chosen):
        facets, rcs, radar, _ = _lit(radar_of(transmit=mode[0], interferogram=mode[1], **keys))
        made.append(expected_look_gates(facets, rcs, Installation(radar), 1.8))
    law = np.exp(-(np.radians(30.0) ** 2)) if mode[1] == "alternating_pulse" else 1.0
    np.testing.assert_allclose(made[1].covariance, law * made[0].covariance, rtol=1e-12)
    np.testing.assert_array_equal(made[1].power, made[0].power)


# ------------------------------------------------------------------------------------------------- the carrier

FAR, JITTER = [25.0, 40.0, 80.0], 1e6


def points(jitter: float, mode: tuple[str, str], beyond: float = 0.0) -> tuple[NDArray[np.complex128], Scene]:
    """Voltages (pulse, receiver, point) of reflectors on mean sea level `beyond` the middle of gates [m], as the beam
    passes."""
    keys = {
        "baseline_m": 0.9,
        "range_m": (20.0, 95.0),
        "range_sampling_m": 2.5,
        "sector_deg": (0.0, 4.0),
        "noise": False,
        "transmit": mode[0],
        "interferogram": mode[1],
        "antenna": {"elevation_beamwidth_deg": 60.0, "height_m": 0.03},
        **MAGNETRON,
    }
    scene = Scene.model_validate({"name": "points", "radar": {**keys, "frequency_jitter_hz": jitter}})
    ranges, bearing = np.array(FAR), np.radians(2.0)
    ahead = np.sqrt((ranges + beyond) ** 2 - scene.radar.height_m**2)
    where = np.column_stack((ahead * np.sin(bearing), ahead * np.cos(bearing), np.zeros(3)))
    echoes = sr.echoes.from_scatterers(scene, where, np.full(3, 1.0))
    gate = np.searchsorted(echoes["range"].values, ranges - 1e-6)
    rows = slice(40, 70)  # about 2°
    return echoes["voltage"].values[rows][:, :, gate].astype(np.complex128), scene


@pytest.mark.parametrize("mode", [MODES[0], MODES[2]], ids=str)
def test_receivers_of_a_pulse_see_the_wavenumber_of_its_own_carrier(mode: tuple[str, str]) -> None:
    """δ/f of the phase k ΔR between them, 31 rad at 25 m, and no more: 3e-3 rad rms, found to float32's 3e-7."""
    (steady, scene), (strayed, _) = points(0.0, mode), points(JITTER, mode)
    fired = pulses(Installation(scene.radar), 0)
    sent = Magnetron.of(scene.radar.model_copy(update={"frequency_jitter_hz": JITTER}), fired, scene.seed)
    assert sent is not None
    lower, upper = scene.radar.height_m - 0.45, scene.radar.height_m + 0.45
    ground = np.sqrt(np.array(FAR) ** 2 - scene.radar.height_m**2)
    apart = np.hypot(ground, upper) - np.hypot(ground, lower)
    law = 2.0 * np.pi / SPEED_OF_LIGHT * sent.carrier[40:70, None] * apart
    cross = [each[:, 0] * each[:, 1].conj() for each in (strayed, steady)]
    found = np.angle(cross[0] * cross[1].conj())
    assert np.abs(law).max() > 3e-3
    np.testing.assert_allclose(found, law, rtol=1e-3, atol=2e-6)


def test_a_carrier_that_strays_does_not_turn_phases_with_range() -> None:
    """The receiver's oscillator keeps its frequency: from 25 to 80 m 2πδ 2R/c would be 2.3 rad rms; what is left is
    the way from the array's middle to its antennas, 2πδ 0.45 m/c."""
    (steady, _), (strayed, _) = points(0.0, MODES[0]), points(JITTER, MODES[0])
    turned = np.angle(strayed * steady.conj())
    across = np.angle(np.exp(1j * (turned[..., 2] - turned[..., 0])))
    assert np.abs(across).max() < 4.0 * 2.0 * np.pi * JITTER * 0.45 / SPEED_OF_LIGHT


@pytest.mark.parametrize("beyond", [-0.8, 0.0, 0.8])
def test_against_the_received_signal_itself(beyond: float) -> None:
    """A pulse at f + δ, delayed, mixed with f, through the filter, sampled at the gate's time. What the chain leaves
    out is what turns across the pulse: no more than 2πδ(t − τ), and 0 of points in the gate's middle."""
    (steady, scene), (strayed, _) = points(0.0, MODES[0], beyond), points(JITTER, MODES[0], beyond)
    radar = scene.radar.model_copy(update={"frequency_jitter_hz": JITTER})
    sent = Magnetron.of(radar, pulses(Installation(radar), 0), scene.seed)
    assert sent is not None
    late, delta = 2.0 * beyond / SPEED_OF_LIGHT, sent.carrier[40:70]
    time = np.linspace(-40e-9, 40e-9, 8001)  # since the gate's own
    filtered = np.exp(-2.0 * np.pi * (radar.bandwidth_hz * time) ** 2)  # its spectrum: exp(−½π(ν/B)²)
    inside = np.abs(time - late) < 0.5 * radar.pulse_width_s
    law = np.angle(np.exp(2j * np.pi * delta[:, None] * (time - late)) @ (filtered * inside))
    found = np.angle(strayed * steady.conj())
    to_antennas = 2.0 * np.pi * np.abs(delta) * 0.5 / SPEED_OF_LIGHT  # half a metre at most from the array's middle
    allowed = 2.0 * np.pi * np.abs(delta) * abs(late) + to_antennas
    assert (np.abs(found - law[:, None, None]) <= 1.01 * allowed[:, None, None] + 1e-6).all()


def test_the_stray_within_a_pulse_is_kept_small() -> None:
    """2πδ over the delays that a gate's power has: of 20 ns and 50 MHz about 6 ns."""
    radar = RadarSettings(transmitter="magnetron", frequency_jitter_hz=1e6)
    fine = np.linspace(-30e-9, 30e-9, 6001)
    response = sr.radar.waveform.RangeResponse.of(radar)
    power = response(0.5 * SPEED_OF_LIGHT * fine) ** 2
    law = 2.0 * np.pi * 1e6 * np.sqrt(power @ fine**2 / power.sum())
    assert phase_drift_in_pulse(radar) == pytest.approx(law, rel=1e-3)
    assert phase_drift_in_pulse(RadarSettings(frequency_jitter_hz=1e6)) == 0.0
    most = 1e6 * MOST_STRAY / law
    with pytest.raises(sr.InputError, match=r"^radar.frequency_jitter_hz = .* must be at most 2.63"):
        sr.load_scene("tiny", {"radar.transmitter": "magnetron", "radar.frequency_jitter_hz": 1.05 * most})
    sr.load_scene("tiny", {"radar.transmitter": "magnetron", "radar.frequency_jitter_hz": 0.95 * most})


def test_noise_is_as_strong_and_as_random_as_before() -> None:
    keys = {"range_m": (20.0, 95.0), "sector_deg": (0.0, 4.0), "range_sampling_m": 2.5}
    made = []
    for each in ({}, MAGNETRON, MEASURED):
        scene = Scene.model_validate({"name": "noise", "radar": {**keys, **each}})
        made.append(sr.echoes.from_scatterers(scene, [[0.0, 1e4, 0.0]], [0.0])["voltage"].values)
    assert gates(scene.radar).size == made[0].shape[2]
    np.testing.assert_array_equal(made[0], made[1])  # nothing is sent that could turn it
    np.testing.assert_allclose(np.abs(made[2]), np.abs(made[0]), rtol=1e-6)
    assert abs(np.mean(made[2][1:] * made[2][:-1].conj())) < 0.03 * np.mean(np.abs(made[0]) ** 2)


@pytest.mark.parametrize("watts", [25e3, 1e6])
def test_much_power_is_a_larger_echo_and_nothing_else(watts: float) -> None:
    """√W: linear without a converter. One of fixed full scale clips the near echo, and says so; gain follows it."""
    keys = {"range_m": (20.0, 95.0), "sector_deg": (0.0, 60.0), "noise": False, **MAGNETRON}

    def received(power: float, **more: object):
        scene = Scene.model_validate({"name": "power", "radar": {**keys, "transmit_power_w": power, **more}})
        echoes = sr.echoes.from_scatterers(scene, [[2.0, 30.0, 0.0]], [10.0])
        assert np.isfinite(echoes["voltage"].values).all()
        return echoes, np.abs(echoes["voltage"].values).max()

    (little, _), (much, peak) = received(1.0), received(watts)
    assert relative_rms(much["voltage"].values / np.sqrt(watts), little["voltage"].values) < 3e-7
    fixed, clipped = received(watts, receiver={"chain": "digital"})
    assert fixed["saturated"].values.sum() > 1000
    assert clipped < 0.1 * peak
    following = {"chain": "digital", "gain": "agc", "agc_headroom_db": 20.0}
    few, kept = (received(power, noise=True, receiver=following)[1] for power in (1.0, watts))
    assert kept / few == pytest.approx(np.sqrt(watts), rel=0.01)
