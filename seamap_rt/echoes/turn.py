"""The voltages of every pulse of one turn, as its receivers give them.

    V(p, rx, g) = Σ_columns E(beam − column) Σ_facets a h(r_g − R) s(t) exp(−jk(R_tx + R_rx)(t))

While the beam passes a column (30 ms) a facet moves by centimetres: its range response stays, its phase turns at the
rate of its radial velocity, its speckle s(t) decorrelates, or turns by itself where its scatterers move relative to the
water. The echo is band-limited in slow time: rotation of the aperture, Doppler and speckle together span some ±500 Hz,
far less than the PRF. So the sum is formed at *knots* a few pulses apart, and the pulses between are interpolated by a
windowed sinc.
"""

from __future__ import annotations

import threading
from concurrent.futures import ThreadPoolExecutor
from dataclasses import dataclass
from itertools import pairwise

import numpy as np
from numpy.typing import NDArray
from threadpoolctl import threadpool_limits

from ..conventions import unit_from_azimuth
from ..mesh import Facets
from ..radar.array import Array, antenna_array
from ..radar.mast import column_frame
from ..radar.scan import Pulses
from ..settings import AntennaSettings, RadarSettings
from .gating import Gating, received_samples
from .motion import Motion, MovingSpeckle, echo_bandwidth
from .paths import FacetPaths, facet_paths, wavenumber
from .receiving import Received, receive
from .speckle import StillSpeckle, speckle_basis

_TAPS = 16
_OVERSAMPLING = 1.3  # knots per Nyquist interval of a band that is a sum of worst cases
_CHUNK = 4  # columns worked on at a time: their phasors stay near the cache
_TURNING = 1e-4  # rad in the beam's time by which antennas may move against each other and count as steady


@dataclass(frozen=True)
class Knots:
    """Slow-time knots of a turn: knot n lies at pulse n·stride (n may be negative or beyond the last pulse)."""

    stride: int
    first: int
    count: int
    spacing_s: float
    time: NDArray[np.float64]  # (knot,) s


def turn_voltages(
    facets: Facets,
    rcs: NDArray[np.float32],
    radar: RadarSettings,
    pulses: Pulses,
    seed: int,
    decorrelation_time_s: float,
    workers: int = 2,
    motion: Motion | None = None,
) -> NDArray[np.complex64]:
    """Voltages (pulse, receiver, gate) [√W] of one turn; see `turn_echoes`."""
    return turn_echoes(facets, rcs, radar, pulses, seed, decorrelation_time_s, workers, motion).voltage


def turn_echoes(
    facets: Facets,
    rcs: NDArray[np.float32],
    radar: RadarSettings,
    pulses: Pulses,
    seed: int,
    decorrelation_time_s: float,
    workers: int = 2,
    motion: Motion | None = None,
    further: NDArray[np.complex64] | None = None,
) -> Received:
    """What the receivers give in one turn, speckle and (if radar.noise) thermal noise included.

    rcs (column, facet) [m²]. motion: of the scatterers relative to the water; without it they go where the water goes.
    further: voltages (pulse, receiver, sample) of other scatterers, to be added before the receiver. Receivers that the
    mode does not sample on a pulse are NaN. The same seed gives the same bits for any number of workers.
    Raises ValueError if motion is not of these facets.
    """
    if motion is not None:
        motion.check(facets)
    samples = received_samples(radar)
    gating = Gating(radar, facets, samples)
    knots = choose_knots(facets, radar, pulses, decorrelation_time_s, motion)
    reach = _reach_s(facets, pulses)
    window = int(np.floor(2.0 * reach / knots.spacing_s)) + 1 if np.isfinite(reach) else knots.count
    if motion is None:
        speckle = StillSpeckle(speckle_basis(window, knots.spacing_s, decorrelation_time_s), seed)
    else:
        k = wavenumber(radar)
        speckle = MovingSpeckle.over(window, knots.spacing_s, k, decorrelation_time_s, motion, seed)
    across = pulses.mast.stance(knots.time).axes[:, 0]
    kernel = ColumnKernel(facets, rcs, radar, gating, knots, window, reach, speckle, two_way_beams(radar), across)

    echo = np.zeros((len(antenna_array(radar).paths), knots.count, gating.range.size), dtype=np.complex64)
    edges = [*range(0, facets.grid.columns, _CHUNK), facets.grid.columns]
    chunks = [slice(a, b) for a, b in pairwise(edges)]
    # BLAS's own threads would fight with ours over small products, and could change the bits.
    with threadpool_limits(1, user_api="blas"), ThreadPoolExecutor(workers) as pool:
        # Chunks are added in their own order, whoever finishes first: the sum keeps its bits.
        for start, part in pool.map(kernel, chunks):
            low, high = max(start, 0), min(start + part.shape[1], knots.count)
            if high > low:
                echo[:, low:high] += part[:, low - start : high - start]
    if samples.compress is not None:
        echo = samples.compress(echo)
    voltages = _pulses_from_knots(echo, knots, radar, pulses)
    return receive(voltages, radar, pulses, seed, workers, further)


def _reach_s(facets: Facets, pulses: Pulses) -> float:
    """Seconds to either side of the time when the boresight passes a column, within which the beam hears of it; all of
    them for a staring antenna."""
    rate, grid = pulses.mast.rate, facets.grid
    if rate == 0.0:
        return np.inf
    slowest = grid.spacing_deg / float(
        np.diff(grid.time).max()
    )  # a boat that yaws against the turntable slows the beam
    return grid.reach_deg / (slowest if slowest < rate * (1.0 - 1e-6) else rate)


def choose_knots(
    facets: Facets, radar: RadarSettings, pulses: Pulses, decorrelation_time_s: float, motion: Motion | None = None
) -> Knots:
    """Knots as far apart as the echo's bandwidth allows: rotation + Doppler of the fastest scatterer + speckle."""
    array = antenna_array(radar)
    wavelength = 2.0 * np.pi / wavenumber(radar)
    per_degree = max(
        _cycles_a_degree(settings, element.antenna.azimuth_beamwidth_deg, wavelength)
        for settings, element in zip(radar.antennas or [radar.antenna] * 2, array.elements, strict=True)
    )
    drift = float(np.max(np.linalg.norm(facets.grid.drift, axis=-1), initial=0.0))
    bandwidth = echo_bandwidth(
        facets, wavenumber(radar), pulses.mast.rate * per_degree, decorrelation_time_s, motion, drift
    )
    stride, cycle = max(1, int(radar.prf_hz / (2.0 * _OVERSAMPLING * bandwidth))), len(array.cycle)
    # A pulse's place in the mode's cycle then depends on its place between knots alone.
    stride = stride - stride % cycle if stride >= cycle else 1
    margin = _TAPS // 2 if stride > 1 else 0
    last = -(-pulses.number.size // stride)
    spacing_s = stride / radar.prf_hz
    first = -margin
    count = last + margin + 1 - first
    return Knots(stride, first, count, spacing_s, pulses.time[0] + spacing_s * np.arange(first, first + count))


def _cycles_a_degree(settings: AntennaSettings, beam_deg: float, wavelength: float) -> float:
    """Bandwidth of an antenna's two-way pattern. It is the transform of the aperture convolved with itself: strictly
    ±width/λ per radian. A Gaussian beam has no edge; 1.35 per beam width holds all but 1e-5 of it. A measured one may
    be either."""
    strict, soft = float(np.radians(settings.width_m / wavelength)), 1.35 / beam_deg
    return {"slotted_waveguide": strict, "file": max(strict, soft)}.get(settings.pattern, soft)


@dataclass(frozen=True)
class ColumnKernel:
    """Sums the facets of a chunk of columns into gates at the knots while the beam passes them."""

    facets: Facets
    rcs: NDArray[np.float32]
    radar: RadarSettings
    gating: Gating
    knots: Knots
    window: int
    reach_s: float
    speckle: StillSpeckle | MovingSpeckle
    beams: list[TwoWayBeam]  # of each path; a single one for all where they are alike
    across: NDArray[np.float64]  # (knot, 3) the aperture's axis in the world

    def __call__(self, columns: slice) -> tuple[int, NDArray[np.complex64]]:
        """First knot's index and the chunk's sum (path, knot, gate)."""
        paths = facet_paths(self.facets, self.rcs, self.radar, columns)
        passing = self.facets.grid.column_stance.time[columns]
        first = np.zeros(passing.size, dtype=int)
        if np.isfinite(self.reach_s):
            first = np.ceil((passing - self.reach_s - self.knots.time[0]) / self.knots.spacing_s).astype(int)
        heard = first[:, None] + np.arange(self.window)  # may lie before the first knot, or after the last
        seconds = self.knots.time[0] + heard * self.knots.spacing_s - passing[:, None]
        gated = self._gated(paths, columns, seconds)
        low = int(first.min())
        span = np.zeros((len(paths.paths), int(first.max()) - low + self.window, self.gating.range.size), np.complex64)
        for column, start in enumerate(first - low):
            inside = np.clip(heard[column], 0, self.knots.count - 1)  # what lies outside is dropped later
            self._beamed(gated[column], columns.start + column, inside)
            span[:, start : start + self.window] += gated[column]
        return low, span

    def _beamed(self, gated: NDArray[np.complex64], column: int, knots: NDArray[np.intp]) -> None:
        """Weigh (path, knot, gate) by the beam towards the mean sea of the column that each gate hears."""
        grid, level = self.facets.grid, self.gating.level
        east, north = unit_from_azimuth(grid.column_azimuth[column])
        across = self.across[knots]
        cosine = (across[:, 0] * east + across[:, 1] * north)[:, None] * level
        if across[:, 2].any():  # the fan leans: what lies deeper below is heard off the bearing
            drop = np.sqrt(1.0 - level**2) * grid.column_height[column] / self.radar.height_m
            cosine = cosine - across[:, 2:] * drop
        drift = grid.drift[column]
        if drift.any():  # a boat that runs past what it looks at sees it for shorter, or longer, than one at rest
            drift = drift.mean(axis=0) @ column_frame(grid.column_azimuth[column : column + 1])[0]
            seconds = self.knots.time[knots] - grid.column_stance.time[column]
            cosine = cosine - (across @ drift * seconds)[:, None] / np.maximum(self.gating.range, self.radar.height_m)
        for path, beam in enumerate(self.beams):
            gated[path if len(self.beams) > 1 else slice(None)] *= beam(cosine, self.gating.range)

    def _gated(self, paths: FacetPaths, columns: slice, seconds: NDArray[np.float64]) -> NDArray[np.complex64]:
        """(column, path, knot, gate): facets summed into gates, without the azimuth pattern."""
        phasors = self._phasors(paths, columns, seconds)
        gated = np.zeros((phasors.shape[1], len(paths.paths), self.window, self.gating.range.size), dtype=np.complex64)
        for block in self.gating.blocks:
            weight = self.gating.weights(block, paths.length) * paths.amplitude[..., block.facets, None]
            heard = np.matmul(phasors[..., block.facets], weight.astype(np.complex64, copy=False))
            gated[..., block.gates] = heard.transpose(1, 0, 2, 3)
        return gated

    def _phasors(self, paths: FacetPaths, columns: slice, seconds: NDArray[np.float64]) -> NDArray[np.complex64]:
        """(path, column, knot, facet): speckle × exp(−jk(R_tx + R_rx)) at the knots.

        Phases are reduced in float64; from knot to knot they turn by a constant factor (a rotation of some 50 steps in
        float32 errs by 1e-5 rad).
        """
        k, (i, j) = wavenumber(self.radar), paths.paths[0]
        begin = seconds[:, :1]
        speed = paths.coming(i) + paths.coming(j)
        phasor = _unit_phasor(k * (paths.range[i] + paths.range[j] + speed * begin))
        step = _unit_phasor(k * self.knots.spacing_s * speed)
        turns = self._between(paths, begin)
        phasors = _scratch((len(paths.paths), *speed.shape[:1], self.window, speed.shape[1]))
        for column, number in enumerate(self.facets.grid.column_number[columns]):
            self.speckle(columns.start + column, int(number), phasors[0, column])
        for knot in range(self.window):
            phasors[0, :, knot] *= phasor
            for path, (apart, turning) in enumerate(turns, 1):
                np.multiply(phasors[path - 1, :, knot], apart, out=phasors[path, :, knot])
                if turning is not None:
                    apart *= turning
            phasor *= step
        return phasors

    def _between(
        self, paths: FacetPaths, begin: NDArray[np.float64]
    ) -> list[tuple[NDArray[np.complex64], NDArray[np.complex64] | None]]:
        """From each path to the next: the phasor between them at the window's begin, and what turns it per knot."""
        k, spacing = wavenumber(self.radar), self.knots.spacing_s
        found: list[tuple[NDArray[np.complex64], NDArray[np.complex64] | None]] = []
        known: dict[tuple[tuple[int, int], ...], int] = {}
        for number, (before, path) in enumerate(pairwise(paths.paths)):
            change = _change(before, path)
            longer = np.sum([sign * paths.difference[antenna] for antenna, sign in change], axis=0)
            if paths.apart_velocity is None:
                if change not in known:
                    known[change] = number
                    found.append((_unit_phasor(k * longer), None))
                else:
                    found.append(found[known[change]])
                continue
            faster = np.sum([sign * paths.apart_velocity[antenna] for antenna, sign in change], axis=0)
            if k * np.abs(faster).max() * self.window * spacing < _TURNING:
                found.append((_unit_phasor(k * longer), None))
            else:
                found.append((_unit_phasor(k * (longer + faster * begin)), _unit_phasor(k * spacing * faster)))
        return found


def _change(before: tuple[int, int], after: tuple[int, int]) -> tuple[tuple[int, int], ...]:
    """(antenna, ±1 or ±2) …: which ranges the path after has more than the path before."""
    count: dict[int, int] = {}
    for antennas, sign in ((after, 1), (before, -1)):
        for antenna in antennas:
            count[antenna] = count.get(antenna, 0) + sign
    return tuple(sorted((antenna, sign) for antenna, sign in count.items() if sign))


_kept = threading.local()


def _scratch(shape: tuple[int, ...]) -> NDArray[np.complex64]:
    """An array that each thread uses again and again: fresh pages would cost more than the arithmetic on them."""
    size = int(np.prod(shape))
    held = getattr(_kept, "array", None)
    if held is None or held.size < size:
        held = _kept.array = np.empty(size, dtype=np.complex64)
    return held[:size].reshape(shape)


def _unit_phasor(phase: NDArray[np.float64]) -> NDArray[np.complex64]:
    """exp(−j phase), the phase reduced in float64 before the float32 sine."""
    reduced = np.remainder(phase, 2.0 * np.pi).astype(np.float32)
    phasor = np.empty(phase.shape, dtype=np.complex64)
    np.cos(reduced, out=phasor.real)
    np.negative(np.sin(reduced), out=phasor.imag)
    return phasor


class BeamTable:
    """Voltage of azimuth cuts, from a table in the direction cosine so fine that the nearest entry does."""

    def __init__(self, array: Array, antennas: tuple[int, ...]) -> None:
        reach = np.sin(np.radians(min(90.0, 3.5 * array.beam_deg)))
        entries = 2**16  # over ±3.5 beams: the nearest entry errs by at most 1e-4 of the peak
        cosine = np.linspace(-reach, reach, entries)
        cuts = [array.elements[antenna].antenna.azimuth(cosine) for antenna in antennas]
        self._table = np.prod(cuts, axis=0).astype(np.float32)
        self._table[[0, -1]] = 0.0  # and beyond
        self._scale = np.float32((entries - 1) / (2.0 * reach))
        self._middle = np.float32(0.5 * entries)  # half an entry on: the cast cuts, and so rounds

    def __call__(self, cosine: NDArray[np.float64]) -> NDArray[np.float32]:
        index = cosine.astype(np.float32) * self._scale + self._middle
        return self._table.take(index.astype(np.int32), mode="clip")


class TwoWayBeam:
    """Two-way voltage of a path. Antennas beside the array's axis look along lines of their own."""

    def __init__(self, radar: RadarSettings, path: tuple[int, int]) -> None:
        array = antenna_array(radar)
        aside = [float(array.offsets[antenna, 0]) for antenna in path]
        if aside[0] == aside[1]:
            self._ways = [(aside[0], BeamTable(array, path))]
        else:
            self._ways = [(offset, BeamTable(array, (antenna,))) for antenna, offset in zip(path, aside, strict=True)]

    def __call__(self, cosine: NDArray[np.float64], ranges: NDArray[np.float64]) -> NDArray[np.float32]:
        """cosine (…, gate) towards the sea that each gate hears, as seen from the array's origin; ranges (gate,) m."""
        voltage = np.ones((), dtype=np.float32)
        for offset, table in self._ways:
            voltage = voltage * table(cosine - offset / np.maximum(ranges, 1.0) if offset else cosine)
        return voltage


def two_way_beams(radar: RadarSettings) -> list[TwoWayBeam]:
    """The beam of each path, or a single one where all antennas have the same cut and stand on one axis."""
    array = antenna_array(radar)
    alike = len({element.antenna.azimuth for element in array.elements}) == 1 and np.ptp(array.offsets[:, 0]) == 0.0
    return [TwoWayBeam(radar, path) for path in (array.paths[:1] if alike else array.paths)]


def _pulses_from_knots(
    echo: NDArray[np.complex64], knots: Knots, radar: RadarSettings, pulses: Pulses
) -> NDArray[np.complex64]:
    """Voltages (pulse, receiver, gate) from the paths' sums (path, knot, gate); NaN where a receiver is not sampled."""
    array = antenna_array(radar)
    echo = np.ascontiguousarray(echo.transpose(1, 0, 2))
    count = pulses.number.size
    voltages = np.zeros((count, len(array.receivers), echo.shape[2]), dtype=np.complex64)
    if not array.whole:
        voltages[...] = np.nan
    if knots.stride == 1:
        for number, slot in enumerate(array.cycle):
            chosen = np.flatnonzero(pulses.slot == number)
            for receiver in slot.receivers:
                voltages[chosen, receiver] = echo[chosen - knots.first, array.path(slot.transmitter, receiver)]
        return voltages
    half = _TAPS // 2
    for place in range(min(knots.stride, count)):
        slot, fraction = array.cycle[int(pulses.slot[place])], place / knots.stride
        for receiver in slot.receivers:
            path = array.path(slot.transmitter, receiver)
            rows = voltages[place :: knots.stride, receiver]
            if place == 0:
                rows[...] = echo[-knots.first :, path][: rows.shape[0]]
                continue
            rows[...] = 0.0
            for tap in range(_TAPS):
                # Knot n + tap − half + 1 lies fraction − (tap − half + 1) knots before the pulse.
                weight = np.float32(_windowed_sinc(fraction - (tap - half + 1)))
                begin = tap - half + 1 - knots.first
                rows += weight * echo[begin : begin + rows.shape[0], path]
    return voltages


def _windowed_sinc(offset: float) -> float:
    """Kaiser-windowed sinc of support ±taps/2; β trades ripple against the transition that oversampling leaves."""
    half = _TAPS // 2
    beta = np.pi * half * (1.0 - 1.0 / _OVERSAMPLING)
    return float(np.sinc(offset) * np.i0(beta * np.sqrt(max(0.0, 1.0 - (offset / half) ** 2))) / np.i0(beta))
