"""The voltages of a turn against a direct sum over facets and pulses, and the laws of its randomness."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from exact_echoes import speckle_weights
from numpy.typing import NDArray

from seamap_rt import sea as sea_package
from seamap_rt.compute import machine
from seamap_rt.conventions import BOLTZMANN, SPEED_OF_LIGHT
from seamap_rt.echoes import turn_voltages
from seamap_rt.echoes.speckle import StillSpeckle, speckle_basis
from seamap_rt.echoes.turn import ReceiveGeometry, choose_nodes
from seamap_rt.mesh import mesh_turn, polar_grid, surface_mesh
from seamap_rt.radar.antenna import antenna
from seamap_rt.radar.installation import Installation
from seamap_rt.radar.receiver import amplitude_constant
from seamap_rt.radar.scan import Pulses, pulses
from seamap_rt.radar.waveform import RangeResponse, gates
from seamap_rt.settings import RadarSettings, SeaSettings, SinusoidWaves, TracingSettings
from seamap_rt.tracing import Illumination
from seamap_rt.tracing.horizon import trace_horizon

SEED = 4
BEAMS = 3.0  # beam widths to either side for which a column is heard


def radar_of(**others) -> RadarSettings:
    return RadarSettings.model_validate({"noise": False, "sector_deg": (20.0, 30.0), "range_m": (15.0, 80.0), **others})


def sinusoid(radar: RadarSettings, turn: int = 0) -> tuple[Illumination, NDArray[np.float32]]:
    """A wave 20 m long and 1 m high that comes from 25°: it runs against the look, and shadows itself further out."""
    wave = SinusoidWaves(spectrum="sinusoid", height_m=1.0, wavelength_m=20.0, phase_deg=40.0, wave_from_deg=25.0)
    sea = sea_package.realize(SeaSettings(waves=(wave,)), 1)
    facets = trace_horizon(mesh_turn(sea, radar, TracingSettings(), turn))
    rcs = np.broadcast_to(1e-3 * facets.horizontal_area, facets.height.shape).astype(np.float32)
    return facets, rcs


def flat_sea_at_speed(radar: RadarSettings, speed: float) -> tuple[Illumination, NDArray[np.float32]]:
    """A flat sea that moves outward in every look."""
    grid = polar_grid(Installation(radar), TracingSettings(), 0)
    shape = (grid.sweep.size, grid.ground_range.size)
    velocity = np.zeros((*shape, 3), np.float32)
    velocity[..., 0] = speed * np.sin(np.radians(grid.azimuth))[:, None]
    velocity[..., 1] = speed * np.cos(np.radians(grid.azimuth))[:, None]
    facets = trace_horizon(surface_mesh(grid, np.zeros(shape), velocity))
    rcs = np.broadcast_to(1e-3 * facets.horizontal_area, facets.height.shape).astype(np.float32)
    return facets, rcs


def direct_sum(
    facets: Illumination, rcs: NDArray[np.float32], radar: RadarSettings, fired: Pulses, speckle: list[NDArray]
) -> NDArray[np.complex128]:
    """Σ over facets, pulse by pulse, in float64. The place of a facet, its light and its column's beam are the
    mesh's; range,
    phase, patterns, response and motion are computed here, from the radar equation. speckle[column] (pulse or 1,
    facet)."""
    k = 2.0 * np.pi * radar.frequency_hz / SPEED_OF_LIGHT
    ranges, response, beam = gates(radar), RangeResponse.of(radar), antenna(radar)
    tilt = np.radians(radar.tilt_deg)
    ends = 0.5 * radar.baseline_m * np.array([[-np.sin(tilt), -np.cos(tilt)], [np.sin(tilt), np.cos(tilt)]])
    half_width = BEAMS * radar.antenna.azimuth_beamwidth_deg
    lit = facets.lit
    voltages = np.zeros((fired.number.size, 2, ranges.size), dtype=np.complex128)
    for column in range(facets.grid.columns):
        offset = fired.sweep - facets.grid.column_sweep[column]
        heard = np.flatnonzero(np.abs(offset) <= half_width)
        if heard.size == 0:
            continue
        seconds = fired.time[heard, None] - facets.grid.column_time[column]
        x = facets.distance + facets.velocity_look[column].astype(float) * seconds  # (pulse, facet)
        z = facets.height[column] - radar.height_m + facets.velocity_up[column].astype(float) * seconds
        path = [np.hypot(x - out, z - up) for out, up in ends]
        still = [np.hypot(facets.distance - out, facets.height[column] - radar.height_m - up) for out, up in ends]
        up = np.arcsin((facets.height[column] - radar.height_m) / (0.5 * (still[0] + still[1])))
        level = np.sqrt(np.maximum(1.0 - (radar.height_m / (0.5 * (still[0] + still[1]))) ** 2, 0.0))
        across = np.sin(np.radians(offset[heard]))[:, None] * level
        pattern = beam.azimuth(across) ** 2 * beam.elevation(np.sin(up + tilt)) ** 2
        amplitude = amplitude_constant(radar) * np.sqrt(rcs[column].astype(float)) * pattern * speckle[column]
        for transmitter in (0, 1):
            chosen = fired.transmitter[heard] == transmitter
            for receiver in (0, 1):
                seen = lit[transmitter, column] & lit[receiver, column]
                both = (path[transmitter] + path[receiver])[chosen]
                spread = still[transmitter] * still[receiver]
                volts = np.where(seen, amplitude[chosen] / spread, 0.0) * np.exp(-1j * k * both)
                window = response(ranges - 0.5 * (still[transmitter] + still[receiver])[:, None])
                voltages[heard[chosen], receiver] += volts @ window
    return voltages


def constant_speckle(facets: Illumination, modes: int = 1) -> list[NDArray]:
    """The one sample that each facet has when its speckle never changes."""
    count = facets.distance.size
    return [speckle_weights(SEED, int(n), modes, count).astype(np.complex128) for n in facets.grid.column_number]


def relative_rms(found: NDArray, exact: NDArray) -> float:
    return float(np.sqrt(np.mean(np.abs(found - exact) ** 2) / np.mean(np.abs(exact) ** 2)))


@pytest.mark.parametrize(
    "others",
    [
        {"transmit": "switched"},
        {"transmit": "single"},
        {"transmit": "switched", "baseline_m": 0.9, "height_m": 4.0, "tilt_deg": 8.0},
        {"transmit": "single", "antenna": {"pattern": "gaussian"}},
    ],
    ids=["switched", "single", "tilted", "gaussian"],
)
def test_nodes_and_interpolation_against_a_direct_sum(others: dict) -> None:
    # Terms of the difference: the windowed sinc over nodes some 0.8 ms apart (1e-4 … 1e-3), the range response's
    # table of 1 mm
    # (2e-4), the nearest entry of the beam's table (1e-4), the azimuth cut taken at the mean sea's elevation and not
    # the
    # facet's (5e-3 in the nearest gates, 2e-4 at 80 m), a facet's straight flight taken as a constant radial velocity
    # (v²t²/2R: 3e-6 m, 1e-3 rad). And one that grows with the baseline: all pairs are given the radial velocity seen
    # from its
    # middle, whereas the antennas' lines of sight differ by B/R: k B v t/R, up to 0.03 rad at 20 m for 0.9 m and ±4
    # ms. (It is the facet's rise by millimetres during the dwell, antisymmetric about its middle.)
    wide = others.get("baseline_m", 0.2) > 0.5
    radar = radar_of(**others)
    facets, rcs = sinusoid(radar)
    assert 0.5 < facets.lit.mean() < 0.99  # there are shadows
    fired = pulses(Installation(radar), 0)
    nodes = choose_nodes(facets, radar, fired, np.inf)
    assert nodes.stride >= 4  # there is something to interpolate
    found = turn_voltages(facets, rcs, Installation(radar), fired, SEED, np.inf)
    exact = direct_sum(facets, rcs, radar, fired, constant_speckle(facets))
    assert relative_rms(found, exact) < (1e-2 if wide else 3e-3)
    # And in the interferogram, where what both receivers share drops out.
    product, true = (v[:, 0] * v[:, 1].conj() for v in (found, exact))
    assert relative_rms(product, true) < (1.5e-2 if wide else 3e-3)
    assert abs(np.angle(np.sum(product * true.conj()))) < (1e-3 if wide else 3e-4)
    # Without motion what is left is that of patterns, tables and interpolation.
    stopped = replace(facets, velocity_look=0.0 * facets.velocity_look, velocity_up=0.0 * facets.velocity_up)
    found = turn_voltages(stopped, rcs, Installation(radar), fired, SEED, np.inf)
    assert relative_rms(found, direct_sum(stopped, rcs, radar, fired, constant_speckle(facets))) < 3e-3


def test_every_pulse_is_a_knot_at_a_low_prf() -> None:
    # With 300 pulses a second nothing is interpolated, and speckle that changes from node to node can be followed
    # exactly.
    radar = radar_of(prf_hz=300.0, rotation_rpm=20.0, transmit="switched")
    time_constant = 0.012
    facets, rcs = sinusoid(radar, turn=0)
    fired = pulses(Installation(radar), 0)
    nodes = choose_nodes(facets, radar, fired, time_constant)
    assert nodes.stride == 1
    half = facets.grid.reach_deg
    np.testing.assert_allclose(half, BEAMS * radar.antenna.azimuth_beamwidth_deg, rtol=1e-12)
    reach = half / fired.installation.rate  # s
    window = int(np.floor(2.0 * reach / nodes.spacing_s)) + 1
    drawn = ReceiveGeometry.of(facets, Installation(radar), fired, SEED, time_constant, None).speckle
    assert isinstance(drawn, StillSpeckle)
    basis = drawn.basis.astype(np.float64)
    speckle = []
    passing = facets.grid.column_pose.time
    for when, sweep, number in zip(passing, facets.grid.column_sweep, facets.grid.column_number, strict=True):
        series = basis.T @ speckle_weights(SEED, int(number), basis.shape[0], facets.distance.size)
        first = int(np.ceil((when - reach - nodes.time[0]) / nodes.spacing_s))
        heard = np.flatnonzero(np.abs(fired.sweep - sweep) <= half)
        speckle.append(series[np.clip(heard - first, 0, window - 1)])
    found = turn_voltages(facets, rcs, Installation(radar), fired, SEED, time_constant)
    exact = direct_sum(facets, rcs, radar, fired, speckle)
    assert relative_rms(found, exact) < 4e-3  # the dwell is three times longer: k B v t/R grows so, v²t²/2R ninefold


def test_a_later_turn_has_its_own_time() -> None:
    # Absolute time enters through the sea alone; within a turn the pulses count from the turn's start.
    radar = radar_of()
    facets, rcs = sinusoid(radar, turn=3)
    fired = pulses(Installation(radar), 3)
    assert fired.number[0] == 30_000
    found = turn_voltages(facets, rcs, Installation(radar), fired, SEED, np.inf)
    exact = direct_sum(facets, rcs, radar, fired, constant_speckle(facets))
    assert relative_rms(found, exact) < 3e-3


@pytest.mark.parametrize("speed", [-6.0, 2.0, 6.0])
def test_motion_turns_the_phase(speed: float) -> None:
    # A pulse pair's mean product turns by −2 k v_r per pulse interval. Its error is that of the decorrelation between
    # pulses,
    # √(1 − ρ²) ≈ 7e-3 rad at 12 rpm, over the square root of twice some 700 independent samples: 2e-4 rad; 1 % is
    # asked for, 8e-4 rad at 2 m/s.
    radar = radar_of(transmit="single", sector_deg=(20.0, 60.0), rotation_rpm=12.0)
    facets, rcs = flat_sea_at_speed(radar, speed)
    voltages = turn_voltages(facets, rcs, Installation(radar), pulses(Installation(radar), 0), SEED, np.inf).astype(
        np.complex128
    )
    ranges = gates(radar)
    radial = speed * np.sqrt(1.0 - (radar.height_m / ranges) ** 2)
    wavenumber = 2.0 * np.pi * radar.frequency_hz / SPEED_OF_LIGHT
    rate = -2.0 * wavenumber * radial  # rad/s
    for lag in (1, 4):
        pairs = np.sum(voltages[lag:] * voltages[:-lag].conj(), axis=(0, 1))
        pairs /= np.sum(np.abs(voltages) ** 2, axis=(0, 1))
        turned = float(np.angle(np.sum(pairs * np.exp(-1j * rate * lag / radar.prf_hz))))
        assert abs(turned) < 0.01 * abs(rate[-1]) * lag / radar.prf_hz


def test_without_motion_the_phase_stays() -> None:
    radar = radar_of(transmit="single", sector_deg=(20.0, 60.0), rotation_rpm=12.0)
    facets, rcs = flat_sea_at_speed(radar, 0.0)
    voltages = turn_voltages(facets, rcs, Installation(radar), pulses(Installation(radar), 0), SEED, np.inf).astype(
        np.complex128
    )
    assert abs(np.angle(np.sum(voltages[1:] * voltages[:-1].conj()))) < 8e-4


RECEIVERS = {
    "pulse": {},
    "chirp": {"waveform": "chirp", "pulse_width_s": 1e-7, "range_m": (60.0, 120.0)},
    "digital": {"receiver": {"chain": "digital"}},
}


@pytest.mark.parametrize("kind", RECEIVERS)
def test_any_number_of_threads_gives_the_same_bits(kind: str, monkeypatch: pytest.MonkeyPatch) -> None:
    # 60° are 1667 pulses: noise is drawn in two lots at least, columns are summed in ten.
    radar = radar_of(noise=True, sector_deg=(20.0, 80.0), **RECEIVERS[kind])
    facets, rcs = sinusoid(radar)
    fired, heard = pulses(Installation(radar), 0), []
    for count in (1, 2, 16, 16):
        monkeypatch.setattr(machine, "threads", lambda count=count: count)
        heard.append(turn_voltages(facets, rcs, Installation(radar), fired, SEED, 0.01))
    for other in heard[1:]:
        np.testing.assert_array_equal(heard[0], other)


def test_all_threads_that_the_process_may_use_are_used(monkeypatch: pytest.MonkeyPatch) -> None:
    """By speeds, sums, interpolation, noise and converter: as many as the machine says, whatever it says."""
    radar = radar_of(noise=True, receiver={"chain": "digital"})
    facets, rcs = sinusoid(radar)
    lent: list[int] = []

    def counted(count: int) -> machine.Workers:
        lent.append(count)
        return machine.Workers(count)

    monkeypatch.setattr(machine, "kept_workers", counted)
    monkeypatch.setattr(machine, "cores", lambda: list(range(5)))
    turn_voltages(facets, rcs, Installation(radar), pulses(Installation(radar), 0), SEED, 0.01)
    assert lent == [5] * 6  # the fastest facet, sums, their transpose, pulses between nodes, noise, converter


def test_another_seed_has_nothing_in_common_but_the_law() -> None:
    radar = radar_of(noise=True)
    facets, rcs = sinusoid(radar)
    fired = pulses(Installation(radar), 0)
    one = turn_voltages(facets, rcs, Installation(radar), fired, SEED, 0.01)
    other = turn_voltages(facets, rcs, Installation(radar), fired, SEED + 1, 0.01)
    # |ρ| of 44 × 10 / 0.9 independent samples is below 0.2.
    common = abs(np.vdot(one, other)) / np.sqrt(np.vdot(one, one).real * np.vdot(other, other).real)
    assert common < 0.2


# ------------------------------------------------------------------------------------------------- speckle


@pytest.mark.parametrize("spacing", [0.3e-3, 1e-3])
@pytest.mark.parametrize("time_constant", [2e-3, 10e-3, 33e-3])
def test_speckle_autocorrelation(spacing: float, time_constant: float) -> None:
    nodes, facets = 30, 60_000
    basis = speckle_basis(nodes, spacing, time_constant)
    series = basis.T @ speckle_weights(7, 0, basis.shape[0], facets)
    np.testing.assert_allclose(np.sum(basis.astype(float) ** 2, axis=0), 1.0, atol=1e-6)  # unit variance at each node
    lag = spacing * np.arange(nodes)
    law = np.exp(-(((lag[:, None] - lag) / time_constant) ** 2))
    # The basis itself: what the truncation leaves out is 1e-6 of the variance, 1e-3 of a covariance at most.
    np.testing.assert_allclose(basis.T.astype(float) @ basis, law, atol=2e-3)
    # The draws: a complex covariance from n samples errs by 1/√n; five of it covers 900 entries.
    drawn = series @ series.conj().T / facets
    np.testing.assert_allclose(drawn, law, atol=5.0 / np.sqrt(facets) + 2e-3)
    # Circular: no covariance without conjugation.
    np.testing.assert_allclose(series @ series.T / facets, 0.0, atol=5.0 * np.sqrt(2.0 / facets))


def test_speckle_of_columns_is_independent_and_keeps_its_numbers() -> None:
    first, again, other = (speckle_weights(7, number, 3, 20_000) for number in (5, 5, 6))
    np.testing.assert_array_equal(first, again)
    assert abs(np.vdot(first, other)) / first.size < 5.0 / np.sqrt(first.size)
    np.testing.assert_allclose(np.mean(np.abs(first) ** 2), 1.0, atol=5.0 / np.sqrt(first.size))


def test_decorrelation_shows_in_the_voltages() -> None:
    # Slow rotation (6 rpm), so that the beam hardly turns within the lags: the gates' autocorrelation is the
    # speckle's times the beam's, and the ratio to the voltages of unchanging speckle is the law itself.
    radar = radar_of(transmit="single", rotation_rpm=6.0, sector_deg=(20.0, 50.0), prf_hz=5e3)
    facets, rcs = flat_sea_at_speed(radar, 0.0)
    fired, time_constant = pulses(Installation(radar), 0), 4e-3

    def correlation(tau: float) -> NDArray[np.float64]:
        v = turn_voltages(facets, rcs, Installation(radar), fired, SEED, tau)[:, 0].astype(np.complex128)
        power = np.sum(np.abs(v) ** 2)
        return np.array([np.sum(v[lag:] * v[: v.shape[0] - lag].conj()).real / power for lag in lags])

    lags = np.array([5, 10, 20, 30])
    law = np.exp(-((lags / radar.prf_hz / time_constant) ** 2))
    np.testing.assert_allclose(correlation(time_constant) / correlation(np.inf), law, atol=0.02)


# --------------------------------------------------------------------------------------------------- noise


@pytest.fixture(scope="module")
def noise() -> tuple[RadarSettings, NDArray[np.complex64]]:
    """A turn of nothing but noise."""
    radar = radar_of(noise=True, range_sampling_m=0.75, sector_deg=(20.0, 200.0))
    facets, rcs = flat_sea_at_speed(radar_of(range_sampling_m=0.75, sector_deg=(20.0, 30.0)), 0.0)
    return radar, turn_voltages(
        facets, np.zeros_like(rcs), Installation(radar), pulses(Installation(radar), 0), SEED, 0.01
    )


def test_noise_power(noise: tuple[RadarSettings, NDArray[np.complex64]]) -> None:
    radar, voltages = noise
    expected = BOLTZMANN * 290.0 * radar.bandwidth_hz * 10.0 ** (radar.noise_figure_db / 10.0)
    assert 10.0 * np.log10(expected * 1e3) == pytest.approx(-93.98, abs=0.02)  # dBm: kTB at 50 MHz and 3 dB
    power = np.abs(voltages) ** 2
    # 5000 pulses × 87 gates, some 40 of them independent: 0.2 %; each receiver by itself, and no gate sticks out.
    np.testing.assert_allclose(power.mean(axis=(0, 2)) / expected, 1.0, atol=5.0 / np.sqrt(5000 * 40))
    np.testing.assert_allclose(power.mean(axis=0) / expected, 1.0, atol=5.0 / np.sqrt(5000))


def test_noise_correlation(noise: tuple[RadarSettings, NDArray[np.complex64]]) -> None:
    radar, voltages = noise
    response = RangeResponse.of(radar)
    power = np.mean(np.abs(voltages) ** 2)
    for lag in range(12):
        shifted = voltages[..., lag:] * voltages[..., : voltages.shape[2] - lag].conj()
        law = response.noise_correlation(lag * radar.range_sampling_m)
        assert abs(np.mean(shifted) / power - law) < 5.0 / np.sqrt(2 * 5000 * 40)
    # Receivers and pulses know nothing of each other; nor is there a preferred phase.
    assert abs(np.mean(voltages[:, 0] * voltages[:, 1].conj())) / power < 5.0 / np.sqrt(5000 * 40)
    assert abs(np.mean(voltages[1:] * voltages[:-1].conj())) / power < 5.0 / np.sqrt(2 * 5000 * 40)
    assert abs(np.mean(voltages**2)) / power < 5.0 * np.sqrt(2.0 / (2 * 5000 * 40))


def test_noise_is_added_to_the_echo() -> None:
    quiet, loud = radar_of(noise=False), radar_of(noise=True)
    facets, rcs = flat_sea_at_speed(quiet, 0.0)
    fired = pulses(Installation(quiet), 0)
    echo, both = (turn_voltages(facets, rcs, Installation(radar), fired, SEED, 0.01) for radar in (quiet, loud))
    alone = turn_voltages(facets, np.zeros_like(rcs), Installation(loud), fired, SEED, 0.01)
    np.testing.assert_allclose(both, echo + alone, rtol=0, atol=1e-6 * np.abs(both).max())
