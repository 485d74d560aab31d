"""The inner loops of a turn against sums of their own: a few facets in float64."""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass, replace
from functools import cache
from typing import Any

import numpy as np
import pytest
from exact_echoes import ROCKING, mast_of
from numpy.typing import NDArray

from seamap_rt import random_streams
from seamap_rt.conventions import SPEED_OF_LIGHT, unit_from_azimuth
from seamap_rt.echoes import turn_voltages
from seamap_rt.echoes.response import received_samples
from seamap_rt.echoes.slow_time import Nodes, choose_nodes
from seamap_rt.echoes.speckle import Motion, SpeedBounds, fastest_echo
from seamap_rt.echoes.summation.gaussian import gaussians, key_of
from seamap_rt.echoes.turn import ReceiveGeometry
from seamap_rt.mesh import polar_grid, surface_mesh
from seamap_rt.radar.array import antenna_array
from seamap_rt.radar.installation import Installation
from seamap_rt.radar.receiver import amplitude_constant
from seamap_rt.radar.scan import Pulses, pulses
from seamap_rt.random_streams import Stream
from seamap_rt.settings import RadarSettings, TracingSettings
from seamap_rt.tracing import Illumination
from seamap_rt.tracing.horizon import trace_horizon

SEED = 4
TAU = 0.004
FAR = (150.0, 200.0)  # m: out there the mean sea's bearing, at which the chain takes the beam, is the facet's own
ASIDE = [{"offset_m": (0.3, 0.1, -0.2)}, {"offset_m": (-0.2, 0.0, 0.2)}, {"offset_m": (0.0, 0.0, 0.6), "role": "rx"}]
MODES = [(transmit, pairs) for transmit in ("single", "switched") for pairs in ("single_pulse", "alternating_pulse")]


# --------------------------------------------------------------------------------------- few facets, in float64


@dataclass(frozen=True)
class Seen:
    """A level sheet of water that moves as one, of which a few facets echo, and the pulses that look at it."""

    radar: RadarSettings
    facets: Illumination
    rcs: NDArray[np.float32]
    fired: Pulses


def radar_of(**others: Any) -> RadarSettings:
    settings = {"noise": False, "sector_deg": (20.0, 24.0), "range_m": FAR, **others}
    return RadarSettings.model_validate(settings)


def seen_by(
    radar: RadarSettings, platform: dict | None = None, velocity: tuple[float, float, float] = (0.8, -1.1, 0.9)
) -> Seen:
    """Facets all over the window and within the pulse's reach beyond its ends."""
    mast = mast_of(radar, platform)
    grid = polar_grid(mast, TracingSettings(), 0)
    shape = (grid.sweep.size, grid.ground_range.size)
    moving = np.broadcast_to(np.array(velocity, np.float32), (*shape, 3))
    facets = trace_horizon(surface_mesh(grid, np.zeros(shape), moving))
    rng = np.random.default_rng(1)
    rcs = np.zeros(facets.height.shape, np.float32)
    near, far = radar.range_m
    for distance in (*rng.uniform(near, far, 8), near + 0.2, near - 2.0, far - 0.2, far + 2.0):
        rcs[rng.integers(grid.columns), np.searchsorted(facets.distance, distance)] = rng.uniform(0.1, 3.0)
    rcs[grid.columns // 2, np.searchsorted(facets.distance, 0.5 * (near + far))] = 3.0
    return Seen(radar, facets, rcs, pulses(mast, 0))


def motion_of(facets: Illumination) -> Motion:
    """Facets of Bragg waves alone, of breakers alone, and of both, in columns that all move otherwise."""
    rng = np.random.default_rng(2)
    columns = facets.height.shape[0]
    breaking = rng.choice(np.array([0.0, 0.3, 1.0], np.float32), facets.height.shape)
    return Motion(0.24, rng.uniform(size=columns), breaking, rng.normal(0.0, 2.0, columns), 0.3)


def at_nodes(
    seen: Seen, decorrelation_time_s: float, motion: Motion | None = None
) -> tuple[NDArray[np.intp], NDArray[np.complex128]]:
    """The pulses that are nodes (all, where speckle never changes), and their voltages (pulse, receiver, gate) by the
    law: paths, beams and motion of each pulse; spreading, gates and elevation patterns of when the beam passes."""
    radar, facets, fired = seen.radar, seen.facets, seen.fired
    array, samples = antenna_array(radar), received_samples(radar)
    nodes = choose_nodes(facets, radar, fired, decorrelation_time_s, motion)
    chosen = np.arange(0, fired.number.size, 1 if np.isinf(decorrelation_time_s) else nodes.stride)
    speckle_of = _speckle_of(seen, nodes, chosen, decorrelation_time_s, motion)
    sums = np.zeros((chosen.size, len(array.paths), samples.range.size), complex)
    for column, facet in zip(*np.nonzero(seen.rcs), strict=True):
        heard, (path, then, amplitude) = speckle_of(column, facet), _on_paths(seen, chosen, column, facet)
        for number, (one, other) in enumerate(array.paths):
            volts = amplitude[number] * heard * np.exp(-1j * _wavenumber(radar) * (path[:, one] + path[:, other]))
            window_of = samples.responses[number](samples.range - 0.5 * (then[one] + then[other]))
            sums[:, number] += volts[:, None] * window_of
    if samples.compress is not None:
        sums = np.asarray(samples.compress(sums.astype(np.complex64)), dtype=complex)
    voltages = np.full((chosen.size, len(array.receivers), sums.shape[2]), np.nan, complex)
    for row, pulse in enumerate(chosen):
        slot = array.cycle[fired.slot[pulse]]
        for receiver in slot.receivers:
            channel = array.elements[array.receivers[receiver]].channel
            voltages[row, receiver] = channel * sums[row, array.path(slot.transmitter, receiver)]
    return chosen, voltages


def _speckle_of(
    seen: Seen, nodes: Nodes, chosen: NDArray[np.intp], decorrelation_time_s: float, motion: Motion | None
) -> Callable[[int, int], NDArray[np.complex128]]:
    """(column, facet) → its speckle (pulse,) at the chosen ones, 0 where the beam is elsewhere."""
    facets, fired = seen.facets, seen.fired
    reach = np.inf if fired.installation.rate == 0.0 else _reach(facets, fired)
    window = nodes.count if np.isinf(reach) else int(2.0 * reach / nodes.spacing_s) + 1
    # What the modes are is tested by their covariance (test_speckle_basis).
    speckle = ReceiveGeometry.of(facets, Installation(seen.radar), fired, SEED, decorrelation_time_s, motion).speckle

    def speckle_of(column: int, facet: int) -> NDArray[np.complex128]:
        passing = facets.grid.column_pose[slice(column, column + 1)]
        first = 0 if np.isinf(reach) else int(np.ceil((passing.time[0] - reach - nodes.time[0]) / nodes.spacing_s))
        node = chosen // nodes.stride - nodes.first - first
        series = np.zeros(window, complex)
        begin = nodes.time[0] + first * nodes.spacing_s - passing.time
        for number, modes in enumerate(speckle.modes(slice(column, column + 1), begin)):
            share = 1.0
            if motion is not None and motion.breaking is not None:
                share = abs(float(motion.breaking[column, facet]) - (1 - number))
            key = key_of(
                random_streams.key(SEED, Stream.SPECKLE, *[1] * number), int(facets.grid.column_number[column])
            )
            drawn = gaussians(np.uint64(key), facet + 1, modes.shape[1])[:, facet]
            series += np.sqrt(share) * (drawn.astype(complex) @ modes[0])
        return np.where((node >= 0) & (node < window), series[np.clip(node, 0, window - 1)], 0.0)

    return speckle_of


def _on_paths(
    seen: Seen, chosen: NDArray[np.intp], column: int, facet: int
) -> tuple[NDArray[np.float64], NDArray[np.float64], list[NDArray[Any]]]:
    """A facet's distances from the antennas (pulse, antenna) at the chosen pulses and (antenna,) when the beam passes
    it [m], and what it returns on each path (pulse,) but for phase, speckle and range response [√W]."""
    radar, facets, fired = seen.radar, seen.facets, seen.fired
    array, grid, time, pose = antenna_array(radar), facets.grid, fired.time[chosen], fired.pose[chosen]
    passing = grid.column_pose[slice(column, column + 1)]
    look, middle = (
        np.array(unit_from_azimuth(grid.column_azimuth[column] + off)) for off in (np.degrees(facets.angle[facet]), 0.0)
    )
    start = np.append(passing.origin[0, :2] + facets.distance[facet] * look, facets.height[column, facet])
    flow = np.append(facets.velocity_look[column, facet] * look, facets.velocity_up[column, facet])
    point = start + flow * (time - passing.time)[:, None]
    path = np.linalg.norm(point[:, None] - pose.positions, axis=-1)  # (node, antenna)
    then = np.linalg.norm(start - passing.positions[0], axis=-1)
    # The beam is laid on whole columns.
    towards = point - pose.origin + np.append(facets.distance[facet] * (middle - look), 0.0)
    away = np.linalg.norm(towards, axis=-1)
    across = np.einsum("pi,pi->p", towards, pose.axes[:, 0]) / away
    up = (start - passing.origin[0]) @ passing.axes[0, 2] / np.linalg.norm(start - passing.origin[0])
    amplitude = []
    for one, other in array.paths:
        ends = [array.elements[one], array.elements[other]]
        volts = amplitude_constant(radar, math.sqrt(ends[0].antenna.gain * ends[1].antenna.gain))
        volts = volts * math.sqrt(seen.rcs[column, facet]) / (then[one] * then[other])
        for end in ends:
            volts = volts * end.antenna.elevation(up) * end.antenna.azimuth(across - end.offset[0] / away)
        if facets.field is None:
            volts = volts * (facets.lit[one, column, facet] & facets.lit[other, column, facet])
        else:
            volts = volts * complex(facets.field[one, column, facet]) * complex(facets.field[other, column, facet])
        amplitude.append(volts)
    return path, then, amplitude


def _wavenumber(radar: RadarSettings) -> float:
    return 2.0 * np.pi * radar.frequency_hz / SPEED_OF_LIGHT


def _reach(facets: Illumination, fired: Pulses) -> float:
    """Seconds: where a boat that yaws slows the beam, it hears a column for longer."""
    slowest = facets.grid.spacing_deg / float(np.diff(facets.grid.time).max())
    return facets.grid.reach_deg / (
        slowest if slowest < fired.installation.rate * (1.0 - 1e-6) else fired.installation.rate
    )


def error(seen: Seen, decorrelation_time_s: float = TAU, motion: Motion | None = None) -> float:
    """rms over nodes, receivers and gates, of the rms voltage; the silent must be silent."""
    chosen, exact = at_nodes(seen, decorrelation_time_s, motion)
    fired = seen.fired
    found = turn_voltages(
        seen.facets, seen.rcs, Installation(seen.radar), fired, SEED, decorrelation_time_s, motion=motion
    )[chosen]
    np.testing.assert_array_equal(np.isnan(found), np.isnan(exact))
    assert np.nanmean(np.abs(exact) ** 2) > 0.0
    return float(np.sqrt(np.nanmean(np.abs(found - exact) ** 2) / np.nanmean(np.abs(exact) ** 2)))


# Two tables, of range in steps of 1 mm and of the beam in 65,536 entries, err by 1e-4 to 2e-4 of their peaks. Antennas
# that stand beside the array's axis look past the mean sea's bearing by a little else: 4e-3. So does a fan that leans.
PLAIN, LEANING = 5e-4, 8e-3


@pytest.mark.parametrize("mode", MODES, ids="-".join)
@pytest.mark.parametrize("antennas", [None, ASIDE], ids=["stacked", "aside"])
def test_few_facets_in_every_mode(mode: tuple[str, str], antennas: list[dict] | None) -> None:
    placed = {} if antennas is None else {"antennas": antennas}
    seen = seen_by(radar_of(transmit=mode[0], interferogram=mode[1], **placed))
    assert error(seen) < (PLAIN if antennas is None else LEANING)


@pytest.mark.parametrize(
    "others",
    [
        {"waveform": "chirp", "pulse_width_s": 2e-7},
        {"scan": "staring", "stare_s": 0.02},
        {"prf_hz": 300.0, "rotation_rpm": 10.0},  # every pulse is a node
        {"height_m": 20.0},
        {"antenna": {"pattern": "gaussian", "azimuth_beamwidth_deg": 10.0}},
        {"antennas": [{"offset_m": (0.0, 0.0, -0.1), "bandwidth_hz": 3e7}, {"offset_m": (0.0, 0.0, 0.1)}]},
        {"range_m": (170.0, 170.5)},  # one gate
    ],
    ids=["chirp", "staring", "low prf", "high mast", "wide beam", "narrow band", "one gate"],
)
def test_few_facets_of_every_radar(others: dict) -> None:
    assert error(seen_by(radar_of(**others))) < PLAIN


def test_few_facets_from_a_boat_that_rolls() -> None:
    assert error(seen_by(radar_of(), {**ROCKING, "roll_deg": 2.0, "pitch_deg": 1.0})) < LEANING


def test_few_facets_from_a_boat_that_heaves_with_its_antennas_far_above_the_arrays_middle() -> None:
    # (u − d)·(r − a) at d = 6 m/s and a = 5 m: without d·a the phase would turn by 0.6 rad while the beam passes.
    above = [{"offset_m": (0.0, 0.0, 5.0)}, {"offset_m": (0.0, 0.0, 5.2)}]
    seen = seen_by(radar_of(antennas=above), {"motion": "sinusoidal", "heave_m": 5.0})
    assert np.abs(seen.facets.grid.drift[..., 2]).min() > 6.0
    assert error(seen) < PLAIN


def test_few_facets_from_a_boat_that_yaws_against_its_turntable() -> None:
    # The turntable turns at 72°/s and the boat back at 50: the beam hears a column for three times as long.
    yawing = {"motion": "sinusoidal", "yaw_deg": 40.0, "yaw_period_s": 5.0, "yaw_phase_deg": 180.0}
    seen = seen_by(radar_of(rotation_rpm=12.0), yawing, velocity=(0.0, 0.0, 0.0))
    assert _reach(seen.facets, seen.fired) > 3.0 * seen.facets.grid.reach_deg / seen.fired.installation.rate
    assert error(seen, np.inf) < 2e-3  # and all pulses between nodes


@pytest.mark.parametrize("platform", [None, {**ROCKING, "roll_deg": 2.0, "pitch_deg": 1.0}], ids=["still", "rolling"])
def test_few_facets_whose_scatterers_move(platform: dict | None) -> None:
    seen = seen_by(radar_of(), platform)
    assert error(seen, TAU, motion_of(seen.facets)) < (PLAIN if platform is None else LEANING)


def test_nodes_leave_room_for_breakers_that_are_but_a_share_of_a_facet() -> None:
    facets = seen_by(radar_of()).facets
    columns = facets.height.shape[0]
    echoes = []
    for share in (0.01, 1.0):
        breaking = np.zeros(facets.height.shape, np.float32)
        breaking[3, 200] = share
        motion = Motion(0.24, np.full(columns, 0.5), breaking, np.full(columns, 9.0), 0.3)
        echoes.append(fastest_echo(SpeedBounds.of(facets, motion), 209.6, TAU, motion))
    assert echoes[0] == echoes[1]
    assert echoes[0][0] > 209.6 * 8.0 / np.pi  # on water that runs the other way
    assert echoes[0][1] < TAU
    # What runs towards all this adds its own speed.
    for each in (None, replace(motion, breaking=None), motion):
        fastest = SpeedBounds.of(facets, each)
        still, drifting = (fastest_echo(fastest, 209.6, TAU, each, drift)[0] for drift in (0.0, 5.0))
        np.testing.assert_allclose(drifting - still, 209.6 * 5.0 / np.pi, rtol=1e-5)


def test_nodes_leave_room_for_a_boat_that_runs() -> None:
    strides = []
    for speed in (0.0, 20.0):
        seen = seen_by(radar_of(), {"speed_m_s": speed, "heading_deg": 22.0}, velocity=(0.0, 0.0, 0.0))
        strides.append(choose_nodes(seen.facets, seen.radar, seen.fired, np.inf).stride)
    assert strides[1] < 0.25 * strides[0]  # Doppler of 1.3 kHz, on 58 Hz of rotation a side


def test_few_facets_in_bent_light() -> None:
    """Each antenna's field counts once for the way out and once for the way back, phase and all."""
    seen = seen_by(radar_of())
    shape, rng = seen.facets.lit.shape, np.random.default_rng(3)
    field = (rng.normal(size=shape) + 1j * rng.normal(size=shape)).astype(np.complex64)
    dark = np.zeros(shape, bool)
    assert error(replace(seen, facets=replace(seen.facets, field=field, lit=dark))) < PLAIN


def test_a_facet_that_one_antenna_sees_is_heard_on_that_ones_own_path() -> None:
    seen = seen_by(radar_of(transmit="switched"))
    lit = seen.facets.lit.copy()
    lit[1] = False
    half = replace(seen, facets=replace(seen.facets, lit=lit))
    assert error(half) < PLAIN
    found = turn_voltages(half.facets, half.rcs, Installation(half.radar), half.fired, SEED, TAU)
    upper = half.fired.transmitter == 1
    assert np.any(found[~upper, 0])
    assert not found[~upper, 1].any()
    assert not found[upper].any()


def test_water_that_rises_under_far_beams_keeps_its_phase() -> None:
    """Antennas see it rise at speeds that differ by B v/R: 1e-3 rad over the time it is heard is what paths may share,
    half of that to either side of the phase when the beam passes it."""
    for far, speed in ((400.0, 2.0), (2000.0, 1.0)):
        radar = radar_of(range_m=(far - 20.0, far + 20.0), transmit="single")
        seen = seen_by(radar, velocity=(0.0, 0.0, speed))
        alone = np.zeros_like(seen.rcs)
        alone[seen.facets.grid.columns // 2, np.searchsorted(seen.facets.distance, far)] = 1.0
        seen = replace(seen, rcs=alone)
        chosen, exact = at_nodes(seen, np.inf)
        found = turn_voltages(seen.facets, alone, Installation(radar), seen.fired, SEED, np.inf)[chosen].astype(complex)
        pairs, true = (each[:, 0] * each[:, 1].conj() for each in (found, exact))
        heard = np.abs(true) > 0.1 * np.abs(true).max()
        assert np.abs(np.angle(pairs[heard] * true[heard].conj())).max() < 1.05e-3


# ------------------------------------------------------------------------------------------------------- pulses


@pytest.mark.parametrize("mode", [("single", "single_pulse"), ("switched", "alternating_pulse")], ids="-".join)
@pytest.mark.parametrize("beam_deg", [1.8, 4.0])
def test_pulses_between_nodes_of_a_beam_without_an_edge(beam_deg: float, mode: tuple[str, str]) -> None:
    # The first and the last pulses as well, whose nodes lie beyond them. 1.35 cycles a width hold all but 1e-5 of the
    # power, √1e-5 = 3e-3 of the voltage; found: 4e-4 to 8e-4.
    antenna = {"pattern": "gaussian", "azimuth_beamwidth_deg": beam_deg}
    seen = seen_by(radar_of(antenna=antenna, transmit=mode[0], interferogram=mode[1]))
    assert choose_nodes(seen.facets, seen.radar, seen.fired, np.inf).stride >= 4
    assert error(seen, np.inf) < 2e-3


# -------------------------------------------------------------------------------------------------------- noise


@cache
def noise_of(first_deg: float, last_deg: float, turn: int = 0, **others: Any) -> tuple[Pulses, NDArray[np.complex128]]:
    quiet = radar_of(range_m=(20.0, 60.0))
    seen = seen_by(quiet)
    radar = quiet.model_copy(update={"noise": True, "sector_deg": (first_deg, last_deg), **others})
    fired = pulses(Installation(radar), turn)
    return fired, turn_voltages(seen.facets, np.zeros_like(seen.rcs), Installation(radar), fired, SEED, TAU).astype(
        complex
    )


def correlation(one: NDArray[np.complex128], other: NDArray[np.complex128]) -> float:
    """In standard errors: 27 gates 1.5 m apart hold more than 6 independent ones."""
    power = np.vdot(one, one).real * np.vdot(other, other).real
    return float(abs(np.vdot(one, other)) / np.sqrt(power) * np.sqrt(one.size * 6 / 27))


@pytest.mark.parametrize("chirp", [False, True], ids=["pulse", "chirp"])
def test_noise_of_every_pulse_receiver_and_turn_is_its_own(chirp: bool) -> None:
    # Worked on a thousand pulses at a time: neither these nor turns may share their numbers. 3,333 pulses; five errors.
    others = {"waveform": "chirp", "pulse_width_s": 2e-7} if chirp else {}
    _, one = noise_of(20.0, 140.0, 0, **others)
    _, other = noise_of(20.0, 140.0, 1, **others)
    count = min(len(one), len(other))
    assert correlation(one[:count], other[:count]) < 5.0
    for lag in (1, 2, 500, 1000, 2000):
        assert correlation(one[lag:], one[:-lag]) < 5.0
        assert correlation(one[lag:, 0], one[:-lag, 1]) < 5.0
        assert correlation(one[lag:, 1], one[:-lag, 0]) < 5.0
    assert correlation(one[:, 0], one[:, 1]) < 5.0
    assert correlation(one, one.conj()) < 5.0 * np.sqrt(2.0)


def test_a_pulse_keeps_its_noise_whichever_others_are_sent() -> None:
    """Its numbers are those of its own number, counted from time 0."""
    fired, whole = noise_of(0.0, 140.0)
    for first in (36.0, 40.0):
        late = pulses(Installation(radar_of(sector_deg=(0.0, 140.0 - first))), 0)
        part = noise_of(0.0, 140.0 - first)[1]
        np.testing.assert_array_equal(late.number, fired.number[: late.number.size])
        np.testing.assert_array_equal(part, whole[: part.shape[0]])
