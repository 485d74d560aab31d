"""Unlike antennas and receivers: patterns, gains, places, channels, bandwidths, and a staring scan."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest
from exact_echoes import SEED, direct_sum, radar_of, relative_rms, sea_seen
from numpy.typing import NDArray

from seamap_rt.conventions import SPEED_OF_LIGHT, from_db
from seamap_rt.echoes import from_scatterers, turn_voltages
from seamap_rt.echoes.turn import choose_nodes
from seamap_rt.mesh import polar_grid, surface_mesh
from seamap_rt.radar.array import antenna_array
from seamap_rt.radar.installation import Installation
from seamap_rt.radar.scan import pulses
from seamap_rt.radar.waveform import gates
from seamap_rt.scene import Scene
from seamap_rt.settings import RadarSettings, TracingSettings
from seamap_rt.tracing import Illumination
from seamap_rt.tracing.horizon import trace_horizon

GAUSSIAN = {"pattern": "gaussian", "azimuth_beamwidth_deg": 1.8}
UNLIKE = [
    {**GAUSSIAN, "offset_m": (0.0, 0.0, -0.1), "channel_gain_db": -1.0},
    {
        **GAUSSIAN,
        "offset_m": (0.0, 0.0, 0.1),
        "azimuth_beamwidth_deg": 2.5,
        "elevation_beamwidth_deg": 24.0,
        "gain_dbi": 27.0,
        "bandwidth_hz": 60e6,
        "channel_phase_deg": 40.0,
    },
]
SIDEWAYS = [{"offset_m": (-0.3, 0.0, -0.1)}, {"offset_m": (0.3, 0.0, 0.1)}]


def scene_of(**radar) -> Scene:
    default = {"noise": False, "sector_deg": (0.0, 4.0), "range_m": (15.0, 60.0)}
    return Scene.model_validate({"name": "received", "radar": {**default, **radar}})


# --------------------------------------------------------------------------------------------------- unlike antennas


@pytest.mark.parametrize("transmit", ["single", "switched"])
@pytest.mark.parametrize("antennas", [UNLIKE, SIDEWAYS], ids=["unlike", "sideways"])
def test_antennas_against_a_direct_sum(antennas: list[dict], transmit: str) -> None:
    # As two alike one above the other (test_moving_boat). Those 0.3 m aside move at 1.9 m/s along the look, against
    # each other; what that leaves of a constant velocity, ω³ r t³/6 in the beam's ±2.5 ms, is 0.2 µm.
    radar = radar_of(antennas=antennas, transmit=transmit)
    facets, rcs, fired = sea_seen(radar)
    found = turn_voltages(facets, rcs, Installation(radar), fired, SEED, np.inf)
    exact = direct_sum(facets, rcs, radar, fired)
    # The line from an antenna x aside is laid on the middle of each gate: facets off that by s lie x s/R² beside it,
    # for the pulse's s = 1 m and R = 25 m 5e-4 rad, a sixtieth of the beam, where its flank falls by two of that.
    near, far = (4e-3, 2.5e-3) if antennas is UNLIKE else (3e-2, 1e-2)
    assert relative_rms(found, exact) < near
    assert relative_rms(found[..., 10:], exact[..., 10:]) < far


def test_sideways_antennas_need_closer_nodes() -> None:
    strides = []
    for antennas in ((), SIDEWAYS):
        radar = radar_of(antennas=list(antennas))
        facets, _, fired = sea_seen(radar)
        strides.append(choose_nodes(facets, radar, fired, np.inf).stride)
    assert strides[0] > strides[1] >= 2


def _lopsided(folder: Path) -> str:
    """A Gaussian beam 1.8° wide with a sidelobe 10 dB down, 4° clockwise of it."""
    lines = ["cut,angle_deg,gain_db"]
    for angle in np.arange(-90.0, 90.05, 0.1):
        voltage = np.exp(-2.0 * np.log(2.0) * (angle / 1.8) ** 2)
        voltage += np.sqrt(0.1) * np.exp(-2.0 * np.log(2.0) * ((angle - 4.0) / 1.0) ** 2)
        lines.append(f"azimuth,{angle:.1f},{max(-80.0, 20.0 * np.log10(voltage + 1e-30)):.4f}")
    for angle in np.arange(-90.0, 91.0, 1.0):
        lines.append(f"elevation,{angle:.0f},{max(-60.0, -12.0 * (angle / 18.0) ** 2):.4f}")
    path = folder / "lopsided.csv"
    path.write_text("\n".join(lines) + "\n")
    return str(path)


def test_a_sidelobe_clockwise_of_the_beam_hears_what_lies_there(tmp_path: Path) -> None:
    radar = radar_of(antenna={"pattern": "file", "file": _lopsided(tmp_path)}, sector_deg=(20.0, 32.0))
    facets, rcs, fired = sea_seen(radar, height_m=0.0)
    column = int(np.argmin(np.abs(facets.grid.column_sweep - 6.0)))
    alone = np.zeros_like(rcs)
    alone[column, 160] = 1.0  # at 41 m
    found = np.abs(turn_voltages(facets, alone, Installation(radar), fired, SEED, np.inf)[:, 0]).max(axis=1)
    off = facets.grid.column_sweep[column] - fired.sweep  # > 0: the facet lies clockwise of the boresight
    level = {at: float(20.0 * np.log10(np.interp(at, off[::-1], found[::-1]) / found.max() + 1e-9)) for at in (4, -4)}
    # Two-way −20 dB; in direction cosines 4° and the facet's 7° below the horizon are 0.03° nearer: 0.02 dB. The
    # Gaussian beam itself is 119 dB down at 4°.
    assert abs(level[4] + 20.0) < 0.1
    assert level[-4] < -60.0
    # Point scatterers hear by the same sign.
    scene = scene_of(antenna={"pattern": "file", "file": radar.antenna.file}, sector_deg=(0.0, 9.0))
    volts = np.abs(from_scatterers(scene, [[30.0 * np.sin(np.radians(5.0)), 30.0 * np.cos(np.radians(5.0)), 0.0]], 1.0))
    heard = volts["voltage"].values[:, 0].max(axis=1)
    number = np.round(np.array([1.0, 9.0]) / 360.0 * 10_000).astype(int) - 1
    assert heard[number[0]] > 100.0 * heard[number[1]]


def test_lopsided_antennas_against_a_direct_sum(tmp_path: Path) -> None:
    radar = radar_of(antenna={"pattern": "file", "file": _lopsided(tmp_path)})
    facets, rcs, fired = sea_seen(radar)
    found = turn_voltages(facets, rcs, Installation(radar), fired, SEED, np.inf)
    assert relative_rms(found, direct_sum(facets, rcs, radar, fired)) < 4e-3


# ------------------------------------------------------------------------------------------------ receivers' channels


@pytest.mark.parametrize("chain", ["turn", "scatterers"])
def test_channel_imbalance_is_the_upper_receivers_alone(chain: str) -> None:
    unequal = {"channel_gain_db": 2.0, "channel_phase_deg": 30.0}
    if chain == "turn":
        plain, other = radar_of(), radar_of(**unequal)
        facets, rcs, fired = sea_seen(plain)
        one, two = (turn_voltages(facets, rcs, Installation(radar), fired, SEED, 0.01) for radar in (plain, other))
    else:
        place = [[1.0, 30.0, 0.0]]
        one, two = (from_scatterers(scene_of(**keys), place, 1.0)["voltage"].values for keys in ({}, unequal))
    np.testing.assert_array_equal(two[:, 0], one[:, 0])
    factor = np.sqrt(from_db(2.0)) * np.exp(1j * np.radians(30.0))
    # Two complex64 roundings, of the factor and of the product.
    np.testing.assert_allclose(two[:, 1], one[:, 1] * factor, rtol=3e-7, atol=1e-30)


def test_a_channels_gain_is_its_own_noises_too() -> None:
    quiet, loud = (
        from_scatterers(scene_of(noise=True, channel_gain_db=gain), [[0.0, 1e4, 0.0]], 0.0)["voltage"].values
        for gain in (0.0, 10.0)
    )
    np.testing.assert_array_equal(quiet[:, 0], loud[:, 0])
    np.testing.assert_allclose(loud[:, 1], np.sqrt(10.0) * quiet[:, 1], rtol=2e-7)  # complex64


def test_a_baselines_error_moves_phases_and_not_what_is_told() -> None:
    place = [[1.0, 30.0, 0.3]]
    right, wrong = (from_scatterers(scene_of(baseline_error_m=error), place, 1.0) for error in (0.0, 0.004))
    np.testing.assert_array_equal(right["position"], wrong["position"])
    assert right.attrs["baseline_m"] == wrong.attrs["baseline_m"]
    gate = int(np.abs(right["voltage"].values[50, 0]).argmax())
    k = 2.0 * np.pi * 1e10 / SPEED_OF_LIGHT
    turned = []
    for echoes, baseline in ((right, 0.2), (wrong, 0.204)):
        lower, upper = echoes["voltage"].values[50, :, gate].astype(complex)
        ranges = [np.sqrt(1.0 + 900.0 + (5.0 - 0.3 + side * baseline / 2) ** 2) for side in (-1.0, 1.0)]
        turned.append(np.angle(lower * np.conj(upper) * np.exp(-1j * k * (ranges[1] - ranges[0]))))
    np.testing.assert_allclose(turned, 0.0, atol=1e-6)


def _through_filters(radar: RadarSettings, widths: list[float], place: float) -> NDArray[np.float64]:
    """Gates of a unit reflector: a rectangular pulse through Gaussian filters one after another, by a transform."""
    rate, count = 4e9, 1 << 14
    frequency = np.fft.fftfreq(count, 1.0 / rate)
    spectrum = radar.pulse_width_s * np.sinc(frequency * radar.pulse_width_s)
    for width in widths:
        spectrum = spectrum * np.exp(-0.5 * np.pi * (frequency / width) ** 2)
    time = 2.0 * (gates(radar) - place) / SPEED_OF_LIGHT
    turn = np.exp(2j * np.pi * frequency * time[:, None])
    return (spectrum @ turn.T).real * rate / count


def test_an_antennas_bandwidth_widens_the_response() -> None:
    # The receiver's filter, and that of each antenna on the way: none, one, or the same one twice.
    antennas = [{"offset_m": (0.0, 0.0, -0.1)}, {"offset_m": (0.0, 0.0, 0.1), "bandwidth_hz": 35e6}]
    scene = scene_of(antennas=antennas, antenna={**GAUSSIAN, "azimuth_beamwidth_deg": 20.0}, transmit="switched")
    radar = scene.radar
    echoes = from_scatterers(scene, [[1.0, 30.0, 0.0]], 1.0)
    paths = [np.sqrt(901.0 + (5.0 + offset) ** 2) for offset in (-0.1, 0.1)]
    for pulse in (0, 1):
        for receiver in (0, 1):
            widths = [radar.bandwidth_hz, *([35e6] * (pulse + receiver))]
            law = _through_filters(radar, widths, 0.5 * (paths[pulse] + paths[receiver]))
            found = np.abs(echoes["voltage"].values[pulse, receiver])
            near = law > 1e-4 * law.max()  # the chain's response ends at 1e-5
            # The amplitude is that of spreading and patterns, tested elsewhere: one factor for all gates.
            factor = found[near] @ law[near] / (law[near] @ law[near])
            np.testing.assert_allclose(found, factor * law, atol=5e-5 * found.max())
    # The strength too: lower on itself, and upper on itself through two filters.
    for pulse, widths in ((0, [50e6]), (1, [50e6, 35e6, 35e6])):
        law = _through_filters(radar, widths, paths[pulse]).max()
        gain = antenna_array(radar).elements[0].antenna.gain
        wavelength = SPEED_OF_LIGHT / radar.frequency_hz
        watts = from_db(-2.0) * gain**2 * wavelength**2 / ((4.0 * np.pi) ** 3 * paths[pulse] ** 4)
        peak = np.abs(echoes["voltage"].values[pulse, pulse]).max() / np.sqrt(watts)
        level = from_scatterers(scene, [[1.0, 30.0, 5.0]], 1.0)["voltage"].values[pulse, pulse]
        assert peak < law  # below the beam's middle
        np.testing.assert_allclose(np.abs(level).max() / np.sqrt(watts) / law, 1.0, atol=0.06)


# ------------------------------------------------------------------------------------------------------- staring


def staring(**others) -> RadarSettings:
    return radar_of(scan="staring", transmit="single", sector_deg=(20.0, 40.0), **others)


def flat(radar: RadarSettings, speed: float, turn: int = 0) -> tuple[Illumination, NDArray[np.float32]]:
    """A flat sea that moves outward."""
    grid = polar_grid(Installation(radar), TracingSettings(), turn)
    shape = (grid.sweep.size, grid.ground_range.size)
    velocity = np.zeros((*shape, 3), np.float32)
    velocity[..., 0] = speed * np.sin(np.radians(grid.azimuth))[:, None]
    velocity[..., 1] = speed * np.cos(np.radians(grid.azimuth))[:, None]
    facets = trace_horizon(surface_mesh(grid, np.zeros(shape), velocity))
    return facets, np.broadcast_to(1e-3 * facets.horizontal_area, facets.height.shape).astype(np.float32)


@pytest.mark.parametrize("speed", [-3.0, 0.5, 3.0])
def test_a_staring_antenna_sees_the_phase_of_a_moving_facet_turn(speed: float) -> None:
    # −2kvt with v along the line of sight, over all 50 ms: 60 rad at 3 m/s. Phasors that turn by a constant factor in
    # float32 from node to node err by some 1e-5 rad in each of 50 and more steps at most, the windowed sinc by 1e-3.
    radar = staring(stare_s=0.05)
    facets, rcs = flat(radar, speed)
    fired = pulses(Installation(radar), 0)
    assert fired.number.size == 500
    np.testing.assert_array_equal(fired.azimuth, 30.0)
    column, facet = facets.grid.columns // 2, 70
    alone = np.zeros_like(rcs)
    alone[column, facet] = 1.0
    voltages = turn_voltages(facets, alone, Installation(radar), fired, SEED, np.inf)[:, 0].astype(complex)
    gate = int(np.abs(voltages).max(axis=0).argmax())
    lower = radar.height_m - 0.5 * radar.baseline_m  # it alone sends, and is heard here
    slope = facets.distance[facet] / np.hypot(facets.distance[facet], lower)
    k = 2.0 * np.pi * radar.frequency_hz / SPEED_OF_LIGHT
    found = np.unwrap(np.angle(voltages[:, gate] * np.exp(2j * k * speed * slope * fired.time)))
    np.testing.assert_allclose(found - found[0], 0.0, atol=3e-3)
    np.testing.assert_allclose(np.abs(voltages[:, gate]) / np.abs(voltages[0, gate]), 1.0, atol=3e-3)


def test_speckle_of_a_staring_antenna_lasts_as_long_as_asked() -> None:
    # exp(−(τ/τc)²) itself: no beam turns. 20 maps of some 8 correlation times and 13 independent gates each, 1/√2000.
    radar, time_constant = staring(stare_s=0.1), 0.01
    lags = np.array([20, 50, 80, 120, 200])
    products, power = np.zeros(lags.size, complex), 0.0
    for turn in range(20):
        facets, rcs = flat(radar, 0.0, turn)
        v = turn_voltages(facets, rcs, Installation(radar), pulses(Installation(radar), turn), SEED, time_constant)[
            :, 0
        ].astype(complex)
        products += [np.mean(np.sum(v[lag:] * v[:-lag].conj(), axis=1)) for lag in lags]
        power += np.mean(np.sum(np.abs(v) ** 2, axis=1))
    law = np.exp(-((lags / radar.prf_hz / time_constant) ** 2))
    np.testing.assert_allclose(products / power, law, atol=4.0 / np.sqrt(2000.0))
