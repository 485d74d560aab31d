"""The speckle-averaged echo: power of every pair and covariance of the receivers, per look and gate, without noise.

Facets are independent scatterers, so their powers add, and each contributes its own interferometric phase; where its
field comes over an edge, that of the detour as well.

A gate hears facets within the range response's support. Along a column slant range follows ground range, so a block
of a few gates hears one contiguous run of facets, the same for all columns: small dense products, not scattering.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass
from functools import cached_property

import numpy as np
from numpy.typing import NDArray

from ..conventions import radar_wavenumber
from ..mesh import Facets
from ..radar.antenna import antenna
from ..radar.array import Array
from ..radar.chirp import Chirp
from ..radar.digital import DigitalReceiver
from ..radar.grid import look_sweeps
from ..radar.installation import Installation
from ..radar.receiver import pulse_coherence
from ..radar.scan import DwellBeams
from ..radar.waveform import gates
from ..settings import RadarSettings
from ..tracing import Illumination
from .paths import FacetPaths, Path, facet_paths
from .response import RESPONSE_STEP, Response, Samples, gate_samples, response_tables

_CHUNK, _PROCESSED_CHUNK = 32, 2  # columns
_BLOCK = 8  # gates


@dataclass(frozen=True)
class ExpectedGates:
    """Expectation over speckle; arrays (look, gate) unless said otherwise."""

    sweep: NDArray[np.float64]  # (look,) deg from the start of the sector
    range: NDArray[np.float64]  # (gate,) m
    power: NDArray[np.float64]  # (tx, rx, look, gate) W
    covariance: NDArray[np.complex128]  # W, mean over the mode's interferograms; no Doppler between alternating pulses


def expected_look_gates(
    facets: Illumination, rcs: NDArray[np.float32], installation: Installation, cell_azimuth_deg: float
) -> ExpectedGates:
    """Expected power and covariance of each look (averaged over its dwell) and gate.

    rcs (column, facet) [m²]; cell_azimuth_deg: the looks' width. Power is that of every antenna to every other,
    whatever their roles.
    """
    radar, array = installation.radar, installation.array
    staring = radar.scan == "staring"
    sweeps = look_sweeps(radar.sector_deg, cell_azimuth_deg, staring)
    number = len(array.elements)
    pairs = tuple((i, j) for i in range(number) for j in range(i, number))
    sums = _ColumnExpectation(facets, rcs, installation, pairs)
    gates, looks = sums.gating.range.size, sweeps.size
    power = np.zeros((len(pairs), looks, gates))
    covariance = np.zeros((looks, gates), dtype=np.complex128)
    for begin in range(0, facets.grid.columns, sums.chunk):
        columns = slice(begin, min(begin + sums.chunk, facets.grid.columns))
        powers, covariances = sums(columns)
        for column, sweep in enumerate(facets.grid.column_sweep[columns]):
            beams = DwellBeams(array, sweeps, 0.0 if staring else cell_azimuth_deg, sweep, sums.gating.level)
            for pair, path in enumerate(pairs):
                power[pair, beams.looks] += beams(path, path) * powers[pair, column]
            for which, (p, q) in enumerate(sums.crossed):
                covariance[beams.looks] += beams(p, q) * covariances[which, column] / len(sums.crossed)
    gain = np.array([abs(element.channel) ** 2 for element in array.elements])  # as each antenna's receiver gives it
    first, second = (array.elements[antenna].channel for antenna in array.receivers[:2])
    every = [[pairs.index((min(i, j), max(i, j))) for j in range(number)] for i in range(number)]
    return ExpectedGates(
        sweep=sweeps,
        range=sums.gating.range,
        power=power[every] * gain[:, None, None],
        covariance=covariance * (first * np.conj(second) * (1.0 if array.whole else pulse_coherence(radar))),
    )


class _ColumnExpectation:
    """Sums over the facets of some columns, before the beam of a look."""

    def __init__(
        self, facets: Illumination, rcs: NDArray[np.float32], installation: Installation, pairs: tuple[Path, ...]
    ) -> None:
        """pairs: of antennas."""
        self._facets, self._rcs, self._installation, self._pairs = facets, rcs, installation, pairs
        radar = installation.radar
        self.crossed = interferograms(installation.array)
        self.gating, self.chunk = Gating(radar, facets, gate_samples(radar, pairs)), _CHUNK
        if radar.waveform == "chirp" or radar.receiver.chain == "digital":
            self.gating, self.chunk = ProcessedGating(installation, facets), _PROCESSED_CHUNK

    def __call__(self, columns: slice) -> tuple[NDArray[np.float64], NDArray[np.complex128]]:
        """Power (pair of antennas, column, gate) and covariance (interferogram, column, gate) [W] at boresight."""
        pairs = self._pairs
        count, gates = columns.stop - columns.start, self.gating.range.size
        paths = facet_paths(self._facets, self._rcs, self._installation, columns, pairs)
        power = np.zeros((len(pairs), count, gates))
        covariance = np.zeros((len(self.crossed), count, gates), dtype=np.complex128)
        unit_phasors = self._unit_phasors(paths)
        for block in self.gating.blocks:
            weights = self.gating.weights(block, paths.length)
            weights = weights.astype(np.complex128 if np.iscomplexobj(weights) else np.float64)
            volts = [h * a[:, block.facets, None] for h, a in zip(weights, paths.amplitude, strict=True)]
            for pair, voltage in enumerate(volts):
                power[pair, :, block.gates] = np.einsum("cfg,cfg->cg", voltage, voltage.conj()).real
            for which, (p, q) in enumerate(self.crossed):
                product = volts[pairs.index(p)] * volts[pairs.index(q)].conj()
                phase = unit_phasors[which][:, block.facets, None]
                covariance[which, :, block.gates] = np.sum(product * phase, axis=1)
        return power, covariance

    def _unit_phasors(self, paths: FacetPaths) -> list[NDArray[np.complex128]]:
        """Of each interferogram, (column, facet): what the two paths' difference turns the phase by."""
        k = radar_wavenumber(self._installation.radar.frequency_hz)
        longer = np.stack([paths.difference[i] + paths.difference[j] for i, j in self._pairs])
        index = self._pairs.index
        return [
            np.exp(1j * np.remainder(k * (longer[index(q)] - longer[index(p)]), 2.0 * np.pi)) for p, q in self.crossed
        ]


def interferograms(array: Array) -> list[tuple[Path, Path]]:
    """Pairs of paths (transmitter, receiver) whose echoes the mode multiplies, the first receiver's path first."""
    first, second = array.receivers[:2]

    def path(transmitter: int, receiver: int) -> Path:
        return min(transmitter, receiver), max(transmitter, receiver)

    if array.whole:
        return [(path(t, first), path(t, second)) for t in array.transmitters]
    sender = {array.receivers[r]: slot.transmitter for slot in array.cycle for r in slot.receivers}
    return [(path(sender[first], first), path(sender[second], second))]


@dataclass(frozen=True)
class GateBlock:
    """Gates `gates` (slice) hear facets `facets` (slice) of every column."""

    gates: slice
    facets: slice


class Gating:
    """The range response of all gates to the facets of a turn.

    `tables` hold it for each path, at (n + ½) `step` [m] off the gate's middle and 0 from the last entry on; the same
    object where paths are alike.
    """

    def __init__(self, radar: RadarSettings, facets: Facets, samples: Samples | None = None) -> None:
        samples = samples or gate_samples(radar)
        self.range = samples.range
        self.step = RESPONSE_STEP
        self._support = samples.support_m
        self._facets = facets
        self.tables = response_tables(samples)
        self.level = _level(radar, self.range, samples.responses[0], self._support)

    @cached_property
    def blocks(self) -> list[GateBlock]:
        """Which facets each few gates can hear."""
        return list(self._blocks(self._facets))

    def _blocks(self, facets: Facets) -> Iterator[GateBlock]:
        margin = self._support + float(np.linalg.norm(facets.grid.antenna_positions, axis=-1).max())
        drop = -facets.rise
        highest, lowest = max(float(drop.max()), 0.0), float(np.abs(drop).min())
        crosses = bool((drop.min() <= 0.0) and (drop.max() >= 0.0))
        for first in range(0, self.range.size, _BLOCK):
            block = slice(first, min(first + _BLOCK, self.range.size))
            near = max(self.range[block][0] - margin, 0.0)
            far = self.range[block][-1] + margin
            # A point at ground distance d has slant range between hypot(d, least drop) and hypot(d, greatest drop).
            inner = np.sqrt(max(near**2 - max(highest, float(np.abs(drop).max())) ** 2, 0.0))
            outer = np.sqrt(max(far**2 - (0.0 if crosses else lowest) ** 2, 0.0)) if far > 0.0 else 0.0
            start = int(np.searchsorted(facets.distance, inner))
            stop = int(np.searchsorted(facets.distance, outer))
            if stop > start:
                yield GateBlock(block, slice(start, stop))

    def weights(self, block: GateBlock, length: NDArray[np.float64]) -> NDArray[np.float32]:
        """h(r_gate − R) (path, …, facet of the block, gate) for facets of half-path length R (path, …, all facets)."""
        scaled = (length[..., block.facets] * (1.0 / RESPONSE_STEP)).astype(np.float32)
        offset = np.abs(scaled[..., None] - (self.range[block.gates] * (1.0 / RESPONSE_STEP)).astype(np.float32))
        np.minimum(offset, np.float32(self.tables[0].size - 1), out=offset)
        index = offset.astype(np.int32)
        if all(table is self.tables[0] for table in self.tables):
            return self.tables[0].take(index)
        return np.stack([table.take(each) for table, each in zip(self.tables, index, strict=True)])


def _level(
    radar: RadarSettings, ranges: NDArray[np.float64], response: Response, support: float
) -> NDArray[np.float64]:
    """(gate,) cosine of the elevation of the mean sea that a gate hears: at its centre of power, which on the
    flank of the elevation pattern lies metres off its middle (0.2 dB where the sea lies 60 dB below the beam)."""
    slant = ranges[:, None] + support * np.linspace(-1.0, 1.0, 201)
    sine = np.clip(radar.height_m / np.maximum(slant, 1e-9), 0.0, 1.0 - 1e-6)
    pattern, cosine = antenna(radar), np.sqrt(1.0 - sine**2)
    cut = pattern.elevation(np.sin(pattern.tilt) * cosine - np.cos(pattern.tilt) * sine)
    power = np.where(slant > radar.height_m, (response(slant - ranges[:, None]) * cut**2) ** 2, 0.0)
    power /= np.maximum(slant, radar.height_m) ** 3 * cosine
    total = power.sum(axis=1)
    return np.where(total > 0.0, (power * cosine).sum(axis=1) / np.where(total > 0.0, total, 1.0), 0.0)


class ProcessedGating:
    """The same for gates that come out of processing: a chirp's after compression, each of which hears every facet and
    near ones only partly (eclipsed), or those that a digital receiver filters once more."""

    def __init__(self, installation: Installation, facets: Facets) -> None:
        radar, response = installation.radar, installation.response
        self.range = gates(radar)
        self.level = _level(radar, self.range, response, response.support_m)
        self._step = 0.02 * response.resolution_m
        offsets = np.arange(0.0, float(self.range[-1] + response.support_m) + 2.0 * self._step, self._step)
        if radar.waveform == "chirp":
            table = Chirp(radar).response(offsets)
        else:
            digital = DigitalReceiver(radar)
            samples = response(digital.sample_range - offsets[:, None])
            table = digital.ideal(samples[:, None].astype(np.complex128))[:, 0]
        self._table = table.astype(np.complex64)
        self._table[-1] = 0.0
        self.blocks = [GateBlock(slice(0, self.range.size), slice(0, facets.distance.size))]

    def weights(self, block: GateBlock, length: NDArray[np.float64]) -> NDArray[np.complex64]:
        """The response (…, facet, gate) to facets of half-path length R (…, facet)."""
        index = np.rint(length[..., block.facets] * (1.0 / self._step))
        return self._table.take(np.minimum(index, len(self._table) - 1).astype(np.int32), axis=0)
