"""The voltages of every pulse of one turn, both receivers.

    V(p, rx, g) = Σ_columns E²(beam − column) Σ_facets a h(r_g − R) s(t) exp(−jk(R_tx + R_rx)(t))

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

from ..mesh import Facets
from ..radar.antenna import antenna
from ..radar.receiver import thermal_noise
from ..radar.scan import BEAMS_BEYOND, Pulses
from ..settings import RadarSettings
from .gating import Gating
from .motion import Motion, MovingSpeckle, echo_bandwidth
from .paths import FacetPaths, facet_paths, pair_count, wavenumber
from .speckle import StillSpeckle, speckle_basis

_TAPS = 16
_OVERSAMPLING = 1.3  # knots per Nyquist interval of a band that is a sum of worst cases
_CHUNK = 4  # columns worked on at a time: their phasors stay near the cache
_NOISE_STAGE, _NOISE_CHUNK = 3, 1000


@dataclass(frozen=True)
class Knots:
    """Slow-time knots of a turn: knot n lies at pulse n·stride (n may be negative or beyond the last pulse)."""

    stride: int
    first: int
    count: int
    spacing_s: float
    spacing_deg: float  # sweep between knots
    sweep: NDArray[np.float64]  # (knot,) deg


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
    """Voltages (pulse, receiver, gate) [√W] of one turn, speckle and (if radar.noise) thermal noise included.

    rcs (column, facet) [m²]. motion: of the scatterers relative to the water; without it they go where the water goes.
    The same seed gives the same bits for any number of workers. Raises ValueError if motion is not of these facets.
    """
    if motion is not None:
        motion.check(facets)
    gating = Gating(radar, facets)
    knots = choose_knots(facets, radar, pulses, decorrelation_time_s, motion)
    window = int(np.floor(2.0 * BEAMS_BEYOND * radar.antenna.azimuth_beamwidth_deg / knots.spacing_deg)) + 1
    if motion is None:
        speckle = StillSpeckle(speckle_basis(window, knots.spacing_s, decorrelation_time_s), seed)
    else:
        k = wavenumber(radar)
        speckle = MovingSpeckle.over(window, knots.spacing_s, k, decorrelation_time_s, motion, seed)
    kernel = ColumnKernel(facets, rcs, radar, gating, knots, window, speckle, TwoWayBeam(radar), gating.level)

    echo = np.zeros((pair_count(radar), knots.count, gating.range.size), dtype=np.complex64)
    edges = [*range(0, facets.grid.columns, _CHUNK), facets.grid.columns]
    chunks = [slice(a, b) for a, b in pairwise(edges)]
    # BLAS's own threads would fight with ours over small products, and could change the bits.
    with threadpool_limits(1, user_api="blas"), ThreadPoolExecutor(workers) as pool:
        # Chunks are added in their own order, whoever finishes first: the sum keeps its bits.
        for start, part in pool.map(kernel, chunks):
            low, high = max(start, 0), min(start + part.shape[1], knots.count)
            if high > low:
                echo[:, low:high] += part[:, low - start : high - start]
    voltages = _pulses_from_knots(echo, knots, pulses)
    if radar.noise:
        add_noise(voltages, radar, pulses, seed, workers)
    return voltages


def choose_knots(
    facets: Facets, radar: RadarSettings, pulses: Pulses, decorrelation_time_s: float, motion: Motion | None = None
) -> Knots:
    """Knots as far apart as the echo's bandwidth allows: rotation + Doppler of the fastest scatterer + speckle."""
    rate = 6.0 * radar.rotation_rpm  # deg/s
    wavelength = 2.0 * np.pi / wavenumber(radar)
    # The two-way pattern is the transform of the aperture convolved with itself: strictly ±width/λ per radian. A
    # Gaussian beam has no edge; 1.35 per beam width holds all but 1e-5 of it.
    strict = np.radians(radar.antenna.width_m / wavelength)
    soft = 1.35 / radar.antenna.azimuth_beamwidth_deg
    rotation = rate * (strict if radar.antenna.pattern == "slotted_waveguide" else soft)
    bandwidth = echo_bandwidth(facets, wavenumber(radar), rotation, decorrelation_time_s, motion)
    stride = max(1, int(radar.prf_hz / (2.0 * _OVERSAMPLING * bandwidth)))
    if radar.transmit == "switched" and stride > 1:
        stride -= stride % 2  # then a pulse's transmitter depends on its place between knots alone
    margin = _TAPS // 2 if stride > 1 else 0
    last = -(-pulses.number.size // stride)
    spacing_s = stride / radar.prf_hz
    first = -margin
    count = last + margin + 1 - first
    sweep = pulses.sweep[0] + spacing_s * rate * np.arange(first, first + count)
    return Knots(stride, first, count, spacing_s, spacing_s * rate, sweep)


@dataclass(frozen=True)
class ColumnKernel:
    """Sums the facets of a chunk of columns into gates at the knots while the beam passes them."""

    facets: Facets
    rcs: NDArray[np.float32]
    radar: RadarSettings
    gating: Gating
    knots: Knots
    window: int
    speckle: StillSpeckle | MovingSpeckle
    beam: TwoWayBeam
    level: NDArray[np.float64]  # (gate,) cosine of the elevation at which each gate hears the mean sea

    def __call__(self, columns: slice) -> tuple[int, NDArray[np.complex64]]:
        """First knot's index and the chunk's sum (pair, knot, gate)."""
        pairs = pair_count(self.radar)
        paths = facet_paths(self.facets, self.rcs, self.radar, columns, pairs)
        sweep = self.facets.grid.column_sweep[columns]
        half = BEAMS_BEYOND * self.radar.antenna.azimuth_beamwidth_deg
        first = np.ceil((sweep - half - self.knots.sweep[0]) / self.knots.spacing_deg).astype(int)
        offset = (
            self.knots.sweep[0] + (first[:, None] + np.arange(self.window)) * self.knots.spacing_deg - sweep[:, None]
        )
        gated = self._gated(paths, columns, offset)
        span = np.zeros((pairs, int(first[-1] - first[0]) + self.window, self.gating.range.size), dtype=np.complex64)
        for column, start in enumerate(first - first[0]):
            gated[column] *= self.beam(np.sin(np.radians(offset[column]))[:, None] * self.level)
            span[:, start : start + self.window] += gated[column]
        return int(first[0]), span

    def _gated(self, paths: FacetPaths, columns: slice, offset: NDArray[np.float64]) -> NDArray[np.complex64]:
        """(column, pair, knot, gate): facets summed into gates, without the azimuth pattern."""
        pairs = paths.length.shape[0]
        phasors = self._phasors(paths, columns, offset)
        gated = np.zeros((phasors.shape[1], pairs, self.window, self.gating.range.size), dtype=np.complex64)
        for block in self.gating.blocks:
            weight = self.gating.weights(block, paths.length) * paths.amplitude[..., block.facets, None]
            heard = np.matmul(phasors[..., block.facets], weight.astype(np.complex64, copy=False))
            gated[..., block.gates] = heard.transpose(1, 0, 2, 3)
        return gated

    def _phasors(self, paths: FacetPaths, columns: slice, offset: NDArray[np.float64]) -> NDArray[np.complex64]:
        """(pair, column, knot, facet): speckle × exp(−jk(R_tx + R_rx)) at the knots.

        Phases are reduced in float64; from knot to knot they turn by a constant factor (a rotation of some 50 steps in
        float32 errs by 1e-5 rad).
        """
        count, facets = paths.lower.shape
        k = wavenumber(self.radar)
        seconds = offset[:, 0] / (6.0 * self.radar.rotation_rpm)
        phasor = _unit_phasor(2.0 * k * (paths.lower + paths.radial_velocity * seconds[:, None]))
        step = _unit_phasor(2.0 * k * self.knots.spacing_s * paths.radial_velocity)
        apart = _unit_phasor(k * paths.difference)
        phasors = _scratch((paths.length.shape[0], count, self.window, facets))
        for column, number in enumerate(self.facets.grid.column_number[columns]):
            self.speckle(columns.start + column, int(number), phasors[0, column])
        for knot in range(self.window):
            phasors[0, :, knot] *= phasor
            for pair in range(1, len(phasors)):
                np.multiply(phasors[pair - 1, :, knot], apart, out=phasors[pair, :, knot])
            phasor *= step
        return phasors


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


class TwoWayBeam:
    """Two-way voltage of the azimuth cut, from a table in the direction cosine so fine that the nearest entry does."""

    def __init__(self, radar: RadarSettings) -> None:
        reach = np.sin(np.radians(min(90.0, (BEAMS_BEYOND + 0.5) * radar.antenna.azimuth_beamwidth_deg)))
        entries = 2**16  # over ±3.5 beams: the nearest entry errs by at most 1e-4 of the peak
        cosine = np.linspace(-reach, reach, entries)
        self._table = (antenna(radar).azimuth(cosine) ** 2).astype(np.float32)
        self._scale = np.float32((entries - 1) / (2.0 * reach))
        self._middle = np.float32(0.5 * entries)  # half an entry on: the cast cuts, and so rounds

    def __call__(self, cosine: NDArray[np.float64]) -> NDArray[np.float32]:
        index = cosine.astype(np.float32) * self._scale + self._middle
        return self._table.take(index.astype(np.int32), mode="clip")


def _pulses_from_knots(echo: NDArray[np.complex64], knots: Knots, pulses: Pulses) -> NDArray[np.complex64]:
    """Voltages (pulse, receiver, gate) from the pairs' sums (pair, knot, gate)."""
    echo = np.ascontiguousarray(echo.transpose(1, 0, 2))
    count = pulses.number.size
    voltages = np.zeros((count, 2, echo.shape[2]), dtype=np.complex64)
    if knots.stride == 1:
        for transmitter in (0, 1):
            chosen = np.flatnonzero(pulses.transmitter == transmitter)
            voltages[chosen] = echo[chosen - knots.first, transmitter : transmitter + 2]
        return voltages
    half = _TAPS // 2
    for place in range(knots.stride):
        rows = voltages[place :: knots.stride]
        if rows.shape[0] == 0:
            continue
        transmitter = int(pulses.transmitter[place])
        fraction = place / knots.stride
        if place == 0:
            rows[...] = echo[-knots.first :][: rows.shape[0], transmitter : transmitter + 2]
            continue
        for tap in range(_TAPS):
            # Knot n + tap − half + 1 lies fraction − (tap − half + 1) knots before the pulse.
            weight = np.float32(_windowed_sinc(fraction - (tap - half + 1)))
            begin = tap - half + 1 - knots.first
            rows += weight * echo[begin : begin + rows.shape[0], transmitter : transmitter + 2]
    return voltages


def _windowed_sinc(offset: float) -> float:
    """Kaiser-windowed sinc of support ±taps/2; β trades ripple against the transition that oversampling leaves."""
    half = _TAPS // 2
    beta = np.pi * half * (1.0 - 1.0 / _OVERSAMPLING)
    return float(np.sinc(offset) * np.i0(beta * np.sqrt(max(0.0, 1.0 - (offset / half) ** 2))) / np.i0(beta))


def add_noise(voltages: NDArray[np.complex64], radar: RadarSettings, pulses: Pulses, seed: int, workers: int) -> None:
    """Add thermal noise in place; chunks have random numbers of their own, so that threads do not matter."""
    first = int(pulses.number[0])

    def add(start: int) -> None:
        part = voltages[start : start + _NOISE_CHUNK]
        random = np.random.default_rng(np.random.SeedSequence(seed, spawn_key=(_NOISE_STAGE, first + start)))
        part += thermal_noise(radar, part.shape[0], part.shape[2], random)

    with ThreadPoolExecutor(workers) as pool:
        list(pool.map(add, range(0, voltages.shape[0], _NOISE_CHUNK)))
