"""Radial velocity and Doppler width: their sign, their fold, their errors, and the boat's own part."""

from __future__ import annotations

import numpy as np
import pytest
import xarray as xr
from numpy.typing import NDArray

import seamap_rt as sr
from seamap_rt.conventions import unit_from_azimuth
from seamap_rt.interferometry.description import RadarDescription
from seamap_rt.interferometry.dwells import Dwells
from seamap_rt.interferometry.products import dwell_means, sampled
from seamap_rt.interferometry.velocity import (
    Doppler,
    Lag,
    beam_passage,
    doppler,
    ground_velocity,
    own_velocity,
    pulse_pair_lags,
)
from seamap_rt.interferometry.windows import independent_looks

WAVELENGTH, INTERVAL = 0.03, 1e-4
CELL = (np.ones(1), np.ones(1))


def lags_of(voltage: NDArray[np.complex64], dwell: int, cycle: tuple[int, ...] = (0, 1)) -> tuple[Lag, ...]:
    """Lags of voltage (pulse, receiver, gate) in dwells of so many pulses, of transmitters that take turns."""
    pulses = len(voltage)
    transmitter, time = np.resize(cycle, pulses), np.asarray(5.0 + INTERVAL * np.arange(pulses), dtype=np.float64)
    heard = sampled(voltage)
    found = pulse_pair_lags(transmitter, heard, time, INTERVAL, dwell, (0, 1))
    dwells = Dwells(np.arange(pulses) // dwell, pulses // dwell)
    return found.lags(dwell_means(voltage, dwells, found.kinds))


def receding(velocity: NDArray[np.float64], pulses: int) -> NDArray[np.complex64]:
    """Voltages (pulse, 2, gate) of reflectors that recede at velocity (gate,) [m/s]: two ways, exp(−jk 2R)."""
    away = velocity * INTERVAL * np.arange(pulses)[:, None]
    voltage = np.exp(-4j * np.pi / WAVELENGTH * (100.0 + away))
    return np.repeat(voltage[:, None], 2, axis=1).astype(np.complex64)


def noise(rng: np.random.Generator, *shape: int) -> NDArray[np.complex128]:
    return np.sqrt(0.5) * (rng.normal(size=shape) + 1j * rng.normal(size=shape))


def speckle(rng: np.random.Generator, pulses: int, cells: int, time_constant: float) -> NDArray[np.complex128]:
    """(pulse, 1, cell) Gaussian, covariance exp(−(lag/time_constant)²), lag and constant in s."""
    lag = INTERVAL * (np.arange(pulses)[:, None] - np.arange(pulses))
    root = np.linalg.cholesky(np.exp(-((lag / time_constant) ** 2)) + 1e-6 * np.eye(pulses))
    return (root @ noise(rng, pulses, cells))[:, None]


def test_what_recedes_has_a_positive_velocity() -> None:
    velocity = np.array([-6.0, -0.3, 0.0, 0.3, 6.0])
    voltage = receding(velocity, 200)
    for cycle in ((0, 1), (0,)):
        found = doppler(lags_of(voltage, 50, cycle), WAVELENGTH, 0.0, CELL, 50, 1.0)
        # float32 holds a phase to 1e-7; over the longest lag, 1.6 ms, that is 1.5e-7 m/s.
        np.testing.assert_allclose(found.velocity, np.broadcast_to(velocity, (4, 5)), rtol=0.0, atol=1e-6)
    voltage[0::2, 1] = voltage[1::2, 0] = np.nan  # receivers that alternate
    found = doppler(lags_of(voltage, 50), WAVELENGTH, 0.0, CELL, 50, 1.0)
    np.testing.assert_allclose(found.velocity, np.broadcast_to(velocity, (4, 5)), rtol=0.0, atol=1e-6)


@pytest.mark.parametrize("cycle", [(0, 1), (0,)])
def test_velocities_fold_where_the_shortest_lag_does(cycle: tuple[int, ...]) -> None:
    # Half a turn in a transmitter's cycle is λ/(4τ): 37.5 m/s of switched transmitters, 75 m/s of a single one.
    fold = WAVELENGTH / (4.0 * len(cycle) * INTERVAL)
    found = doppler(
        lags_of(receding(np.array([fold - 0.5, fold + 0.5]), 100), 50, cycle), WAVELENGTH, 0.0, CELL, 50, 1.0
    )
    np.testing.assert_allclose(found.velocity[0], [fold - 0.5, -fold + 0.5], rtol=0.0, atol=1e-5)


@pytest.mark.parametrize("time_constant", [3e-3, 6e-3])
@pytest.mark.parametrize("snr", [np.inf, 10.0])
def test_the_width_is_what_the_speckle_forgets(time_constant: float, snr: float) -> None:
    # exp(−(τ/τc)²) is exp(−½ (4π σ τ/λ)²) of σ = √2 λ/(4π τc). A dwell of 20 ms holds some three to six samples, whose
    # own means are taken off: over a window of 21 cells the width is found to 5 % rms, and 200 such windows have a
    # median good to 0.5 %. Few samples look a little more alike than they are: some per cent remain, 6 % here.
    rng, pulses, gates = np.random.default_rng(1), 200, 4200
    voltage = speckle(rng, pulses, gates, time_constant) * np.ones((1, 2, 1))
    voltage += noise(rng, pulses, 2, gates) / np.sqrt(snr)
    asked = np.sqrt(2.0) * WAVELENGTH / (4.0 * np.pi * time_constant)
    lags = lags_of(voltage.astype(np.complex64), 50)
    found = doppler(lags, WAVELENGTH, 1.0 / snr, (np.ones(21), np.ones(3)), 50, 3.0)
    assert np.median(found.width) == pytest.approx(asked, rel=0.06)
    # What the turning of the antenna does to it is known, and taken off: here it is all.
    found = doppler(lags, WAVELENGTH, 1.0 / snr, (np.ones(21), np.ones(3)), 50, 3.0, passage_s=time_constant)
    assert np.median(found.width) < 0.35 * asked


def test_a_beam_that_turns_forgets_what_it_left() -> None:
    # Two-way amplitudes of a Gaussian beam, moved by a lag's turn: their normalised overlap, summed out.
    beam, period, lag = 1.8, 1.0, 3e-3
    angle = np.linspace(-10.0, 10.0, 20001)

    def two_way(centre: float) -> NDArray[np.float64]:
        return np.exp(-4.0 * np.log(2.0) * ((angle - centre) / beam) ** 2)

    kept = two_way(0.0) @ two_way(360.0 * lag / period) / (two_way(0.0) @ two_way(0.0))
    assert np.exp(-((lag / beam_passage(beam, period)) ** 2)) == pytest.approx(kept, rel=1e-9)


def in_errors(found: Doppler) -> float:
    """Robust spread of velocities about 0, as many times their own standard error as it is."""
    with np.errstate(invalid="ignore"):
        return 1.4826 * float(np.nanmedian(np.abs(found.velocity) / found.velocity_std))


@pytest.mark.parametrize("snr", [0.5, 3.0, 100.0])
def test_the_standard_error_is_the_scatter(snr: float) -> None:
    # Zrnić's formula is of first order, with SNR and ρ as each cell itself has them; 1200 cells and more know a robust
    # spread to 3 %. Weak echoes, and the few samples of speckle in 50 ms, leave 12 %.
    rng, pulses, gates, time_constant = np.random.default_rng(2), 100, 3000, 10e-3
    echo = np.ones((pulses, 1, 1))
    steady = np.sqrt(snr) * echo + noise(rng, pulses, 2, gates)
    found = doppler(lags_of(steady.astype(np.complex64), pulses), WAVELENGTH, 1.0, CELL, 2 * pulses, 1e9)
    assert in_errors(found) == pytest.approx(1.0, rel=0.2)
    fading = np.sqrt(snr) * speckle(rng, 20 * pulses, 300, time_constant) + noise(rng, 20 * pulses, 2, 300)
    dwell = 5 * pulses
    lags = lags_of(fading.astype(np.complex64), dwell)
    correlation = np.exp(-((np.arange(dwell) * INTERVAL / time_constant) ** 2))
    looks = independent_looks(np.ones(dwell), correlation)
    found = doppler(lags[:2], WAVELENGTH, 1.0, CELL, 2 * dwell, looks)
    assert in_errors(found) == pytest.approx(1.0, rel=0.2)


def test_nothing_is_said_of_what_is_not_heard() -> None:
    quiet = noise(np.random.default_rng(3), 100, 2, 400).astype(np.complex64)
    found = doppler(lags_of(quiet, 50), WAVELENGTH, 1.0, CELL, 100, 1.0)
    assert np.isnan(found.width).mean() > 0.95
    dead = np.full((100, 2, 4), np.nan, dtype=np.complex64)
    dead[:, 0] = receding(np.ones(4), 100)[:, 0]
    found = doppler(lags_of(dead, 50), WAVELENGTH, 0.0, CELL, 50, 1.0)
    np.testing.assert_allclose(found.velocity, 1.0, atol=1e-6)  # a dead receiver leaves the other one's
    with pytest.raises(ValueError, match="at least one lag"):
        doppler((), WAVELENGTH, 0.0, CELL, 50, 1.0)


def reflector(scene: sr.Scene, place: tuple[float, float, float], velocity: tuple[float, float, float]) -> xr.Dataset:
    return sr.echoes.from_scatterers(scene, [place], [100.0], [velocity])


@pytest.mark.parametrize("speed", [0.0, 8.0])
def test_a_boat_that_runs_sees_the_water_as_if_at_rest(speed: float) -> None:
    # One reflector that itself moves north; the boat runs along 70° at `speed`, and heaves. The simulator's
    # ranges are exact; the look's direction, that of its middle (the reflector stands up to half a look, 0.9°, beside
    # it: sin 0.9° of 8 m/s, 0.13 m/s across at 45° at the very most), is made exact here by the place itself.
    scene = sr.load_scene(
        "tiny",
        {
            "radar.noise": False,
            "platform.motion": "sinusoidal",
            "platform.speed_m_s": speed,
            "platform.heading_deg": 70.0,
            "platform.heave_m": 0.5,
            "platform.heave_period_s": 4.0,
        },
    )
    near, far = scene.radar.range_m
    distance, azimuth = 0.5 * (near + far), np.mean(scene.radar.sector_deg)
    east, north = unit_from_azimuth(azimuth)
    echoes = reflector(scene, (distance * float(east), distance * float(north), 0.0), (0.0, 3.0, 0.0))
    radar = RadarDescription.of(echoes)
    voltage, time = echoes["voltage"].values, echoes["time"].values
    heard = sampled(voltage)
    found = pulse_pair_lags(echoes["transmitter"].values, heard, time, radar.interval, 50, (0, 1))
    power = np.abs(voltage[:, 0]) ** 2
    row, gate = np.unravel_index(int(np.nanargmax(power)), power.shape)
    look = np.full(time.size, -1)
    look[max(0, row - 25) : row + 25] = 0
    dwells = Dwells(look, 1)
    lags = found.lags(dwell_means(voltage, dwells, found.kinds))
    seen = doppler(lags, radar.wavelength, 0.0, CELL, 50, 1.0).velocity[:, [gate]]
    own = own_velocity(echoes["position"].values, time, dwells)
    middle = echoes["position"].values[row].mean(axis=0)
    place = np.array([distance * east, distance * north + 3.0 * time[row], 0.0]) - middle
    bearing = np.degrees(np.arctan2(place[0], place[1]))
    water = ground_velocity(seen, own, np.array([bearing]), np.array([[np.hypot(*place[:2])]]), -place[2])
    outward = 3.0 * place[1] / np.linalg.norm(place)
    # A tenth of a second's line is off by the third derivative of the heave times T²/40: 0.5 mm/s times sin ψ, at an
    # end of the turn 30 mm/s times sin ψ; the phase's turn within a dwell, as the beam passes, is even about the peak.
    np.testing.assert_allclose(water, outward, rtol=0.0, atol=5e-3)
    if speed:
        assert abs(seen[0, 0] - outward) > 1.0


def test_a_boats_velocity_is_not_its_sensors_noise() -> None:
    rng, time = np.random.default_rng(4), np.linspace(100.0, 101.0, 10_000)
    velocity = np.array([5.0, -2.0, 0.3])
    place = velocity * time[:, None] + 0.01 * rng.normal(size=(time.size, 3))
    found = own_velocity(np.repeat(place[:, None], 2, axis=1), time, Dwells(np.arange(time.size) // 50, 200))
    assert found.shape == (200, 1, 3)
    # 0.01 m, N = 1000 readings over T = 0.1 s: σ √12/(T √N) = 11 mm/s; at the ends of the turn, where half of it is
    # left, √8 as much, 31 mm/s. 4 σ of each.
    assert np.abs(found[12:-12] - velocity).max() < 0.045
    assert np.abs(found - velocity).max() < 0.125
