"""What the echo chain approximates, in float64: at every pulse each antenna is where it truly is, and each facet where
it has got to by then."""

from __future__ import annotations

from dataclasses import replace
from functools import cache

import numpy as np
from numpy.typing import NDArray
from threadpoolctl import threadpool_limits

from seamap_rt import sea as sea_package
from seamap_rt.conventions import SPEED_OF_LIGHT, unit_from_azimuth
from seamap_rt.echoes.speckle import MovingSpeckle, StillSpeckle, speckle_stream
from seamap_rt.echoes.summation.gaussian import gaussians, key_of
from seamap_rt.mesh import polar_grid, surface_mesh
from seamap_rt.mesh.surface import sea_on_grid
from seamap_rt.radar.array import antenna_array
from seamap_rt.radar.installation import Installation
from seamap_rt.radar.receiver import amplitude_constant
from seamap_rt.radar.scan import Pulses, pulses
from seamap_rt.radar.waveform import RangeResponse, gates
from seamap_rt.settings import FlatWaves, PlatformSettings, RadarSettings, SeaSettings, SinusoidWaves, TracingSettings
from seamap_rt.tracing import Illumination
from seamap_rt.tracing.horizon import trace_horizon

SEED = 4
MODES = [(transmit, pairs) for transmit in ("single", "switched") for pairs in ("single_pulse", "alternating_pulse")]
ROCKING = {
    "motion": "sinusoidal",
    "roll_deg": 10.0,
    "roll_phase_deg": 70.0,
    "pitch_deg": 5.0,
    "pitch_phase_deg": -40.0,
    "yaw_deg": 4.0,
    "yaw_phase_deg": 10.0,
    "heave_m": 0.5,
    "heave_phase_deg": 20.0,
    "speed_m_s": 5.0,
    "heading_deg": 60.0,
    "lever_arm_m": (0.4, -1.0, 4.7),
}


def radar_of(**others) -> RadarSettings:
    return RadarSettings.model_validate({"noise": False, "sector_deg": (20.0, 24.0), "range_m": (20.0, 60.0), **others})


def mast_of(radar: RadarSettings, platform: dict | None) -> Installation:
    return Installation(radar, PlatformSettings.model_validate(platform or {}))


def sea_seen(
    radar: RadarSettings, platform: dict | None = None, turn: int = 0, height_m: float = 1.0
) -> tuple[Illumination, NDArray[np.float32], Pulses]:
    """Facets of a wave 20 m long that comes from 25° (flat: height_m = 0), their rcs, and the pulses of the turn."""
    mast = mast_of(radar, platform)
    wave = FlatWaves(spectrum="flat")
    if height_m:
        wave = SinusoidWaves(
            spectrum="sinusoid", height_m=height_m, wavelength_m=20.0, phase_deg=40.0, wave_from_deg=25.0
        )
    sea, grid = sea_package.realize(SeaSettings(waves=(wave,)), 1), polar_grid(mast, TracingSettings(), turn)
    facets = trace_horizon(surface_mesh(grid, *sea_on_grid(sea, grid)))
    rcs = np.broadcast_to(1e-3 * facets.horizontal_area, facets.height.shape).astype(np.float32)
    return facets, rcs, pulses(mast, turn)


def speckle_weights(seed: int, column_number: int, modes: int, facets: int) -> NDArray[np.complex64]:
    """(mode, facet) unit complex Gaussians of one column; a facet keeps its numbers however the work is cut up."""
    return gaussians(np.uint64(key_of(speckle_stream(seed), column_number)), facets, modes)


def still_speckle(facets: Illumination) -> list[NDArray[np.complex128]]:
    """The one sample that each facet has when its speckle never changes."""
    count = facets.distance.size
    return [speckle_weights(SEED, int(n), 1, count)[0].astype(np.complex128) for n in facets.grid.column_number]


@threadpool_limits.wrap(limits=1, user_api="blas")  # small products: a second thread would mostly wait
def direct_sum(
    facets: Illumination, rcs: NDArray[np.float32], radar: RadarSettings, fired: Pulses, *, walking: bool = False
) -> NDArray[np.complex128]:
    """Σ over facets, pulse by pulse, of speckle that never changes: (pulse, receiver, gate), NaN where the mode does
    not sample. Mesh and light are the chain's.

    Paths and azimuth patterns are those of each pulse. So are gates, spreading and elevation patterns if `walking`;
    else, as in the chain, those of the moment when the beam passes the facet's column.
    """
    array, ranges, k = antenna_array(radar), gates(radar), 2.0 * np.pi * radar.frequency_hz / SPEED_OF_LIGHT
    grid, lit, drawn = facets.grid, facets.lit, still_speckle(facets)
    reach = grid.reach_deg / fired.installation.rate if fired.installation.rate else np.inf
    voltages = np.zeros((fired.number.size, len(array.receivers), ranges.size), dtype=np.complex128)
    sampled = np.zeros(voltages.shape[:2], dtype=bool)
    for slot, each in enumerate(array.cycle):
        sampled[np.ix_(fired.slot == slot, each.receivers)] = True
    for column in range(grid.columns):
        passing = grid.column_pose[slice(column, column + 1)]
        heard = np.flatnonzero(np.abs(fired.time - passing.time) <= reach)
        if heard.size == 0 or not rcs[column].any():
            continue
        pose, seconds = fired.pose[heard], fired.time[heard, None] - passing.time
        look = np.stack(unit_from_azimuth(grid.column_azimuth[column] + np.degrees(facets.angle)), axis=-1)
        start = np.column_stack((passing.origin[0, :2] + facets.distance[:, None] * look, facets.height[column]))
        speed = np.column_stack((facets.velocity_look[column][:, None] * look, facets.velocity_up[column]))
        place = start + speed * seconds[..., None]  # (pulse, facet, 3)
        off = np.stack(unit_from_azimuth(grid.column_azimuth[column])) - look  # the beam is laid on whole columns
        towards = place - pose.origin[:, None] + np.column_stack((facets.distance[:, None] * off, 0.0 * facets.angle))
        across, _, up = _along_axes(towards, pose.axes)
        path = np.linalg.norm(place[:, None] - pose.positions[:, :, None], axis=-1)  # (pulse, antenna, facet)
        _, _, up_then = _along_axes(start - passing.origin[:, None], passing.axes)
        then = np.linalg.norm(start - passing.positions[:, :, None], axis=-1)
        length, rise = (path, up) if walking else (then, up_then)
        away = np.linalg.norm(towards, axis=-1)
        patterns = {}
        for element in array.elements:  # each looks along a line of its own
            pattern, aside = element.antenna, across - element.offset[0] / away
            patterns[element] = pattern.azimuth(aside) * pattern.elevation(rise)
        for slot in range(len(array.cycle)):
            sender = array.cycle[slot].transmitter
            mine = fired.slot[heard] == slot
            for receiver in array.cycle[slot].receivers:
                hearer = array.receivers[receiver]
                ends = [array.elements[antenna] for antenna in (sender, hearer)]
                pattern = patterns[ends[0]] * patterns[ends[1]]
                gain = amplitude_constant(radar, float(np.sqrt(ends[0].antenna.gain * ends[1].antenna.gain)))
                volts = gain * np.sqrt(rcs[column].astype(float)) * drawn[column] * (lit[sender] & lit[hearer])[column]
                volts = volts * pattern / (length[:, sender] * length[:, hearer])
                volts = volts * np.exp(-1j * k * (path[:, sender] + path[:, hearer]))
                width = 1.0 / np.sqrt(1.0 / radar.bandwidth_hz**2 + sum(1.0 / e.bandwidth_hz**2 for e in ends))
                half = 0.5 * (length[:, sender] + length[:, hearer])
                window = _response(replace(RangeResponse.of(radar), bandwidth_hz=width), ranges - half[..., None])
                rows = np.einsum("pf,pfg->pg", volts[mine], window[mine]) if walking else volts[mine] @ window[0]
                voltages[heard[mine], receiver] += rows
    for receiver, antenna in enumerate(array.receivers):
        voltages[:, receiver] *= array.elements[antenna].channel
    voltages[~sampled] = np.nan
    return voltages


_STEP_M, _STEPS = 1e-4, 200_000


@cache
def _table(response: RangeResponse) -> NDArray[np.float64]:
    """The response up to 20 m, and its last value again."""
    table = response(_STEP_M * np.arange(_STEPS + 1))
    return np.append(table, table[-1])


def _response(response: RangeResponse, offset: NDArray[np.float64]) -> NDArray[np.float64]:
    """From a table so fine that the line between two entries errs by less than 1e-8."""
    entry = np.minimum(np.abs(offset) / _STEP_M, _STEPS)
    below, table = entry.astype(np.intp), _table(response)
    return table[below] + (entry - below) * (table[below + 1] - table[below])


def _along_axes(vectors: NDArray[np.float64], axes: NDArray[np.float64]) -> tuple[NDArray[np.float64], ...]:
    """Direction cosines (pulse, facet) of vectors (pulse, facet, 3) along axes (pulse, axis, 3)."""
    cosines = np.einsum("pij,pfj->ipf", axes, vectors) / np.linalg.norm(vectors, axis=-1)
    return cosines[0], cosines[1], cosines[2]


def relative_rms(found: NDArray, exact: NDArray) -> float:
    """Of all that is sampled; receivers that are silent in one must be so in the other."""
    np.testing.assert_array_equal(np.isnan(found), np.isnan(exact))
    return float(np.sqrt(np.nanmean(np.abs(found - exact) ** 2) / np.nanmean(np.abs(exact) ** 2)))


def series_of(
    speckle: StillSpeckle | MovingSpeckle, column: int, column_number: int, facets: int
) -> NDArray[np.complex64]:
    """Speckle (node, facet) of all facets of a column, from its modes, strengths and random numbers."""
    chosen = np.full(facets, column), np.arange(facets)
    series = np.zeros((), dtype=np.complex64)
    every = speckle.modes(slice(column, column + 1), np.zeros(1))
    kinds = zip(every, speckle.streams, speckle.strengths(chosen).T, strict=True)
    for modes, stream, strength in kinds:
        numbers = gaussians(np.uint64(key_of(stream, column_number)), facets, modes.shape[1])
        series = series + modes[0].T @ (strength * numbers)
    return series
