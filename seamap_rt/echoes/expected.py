"""The speckle-averaged echo: power of every pair and covariance of the receivers, per look and gate, without noise.

Facets are independent scatterers, so their powers add, and each contributes its own interferometric phase; where its
field comes over an edge, that of the detour as well.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from ..radar.array import Array, antenna_array
from ..radar.dwell import DwellBeams
from ..radar.grid import look_sweeps
from ..radar.transmitter import pulse_coherence
from ..settings import RadarSettings
from ..tracing import Illumination
from .gating import Gating, ProcessedGating, gate_samples
from .paths import FacetPaths, Path, facet_paths, wavenumber

_CHUNK, _PROCESSED_CHUNK = 32, 2  # columns


@dataclass(frozen=True)
class ExpectedGates:
    """Expectation over speckle; arrays (look, gate) unless said otherwise."""

    sweep: NDArray[np.float64]  # (look,) deg from the start of the sector
    range: NDArray[np.float64]  # (gate,) m
    power: NDArray[np.float64]  # (tx, rx, look, gate) W
    covariance: NDArray[np.complex128]  # W, mean over the mode's interferograms; no Doppler between alternating pulses
    weight: NDArray[np.float64]  # Σ beam · gate · area: what weights a cell's points, shadow or not
    weighted_height: NDArray[np.float64]  # m, the mean height with that weight


def expected_look_gates(
    facets: Illumination, rcs: NDArray[np.float32], radar: RadarSettings, cell_azimuth_deg: float
) -> ExpectedGates:
    """Expected power and covariance of each look (averaged over its dwell) and gate.

    rcs (column, facet) [m²]; cell_azimuth_deg: the looks' width. Power is that of every antenna to every other,
    whatever their roles.
    """
    array, staring = antenna_array(radar), radar.scan == "staring"
    sweeps = look_sweeps(radar.sector_deg, cell_azimuth_deg, staring)
    number = len(array.elements)
    pairs = tuple((i, j) for i in range(number) for j in range(i, number))
    sums = _ColumnExpectation(facets, rcs, radar, pairs, pairs.index((0, min(1, number - 1))))
    gates, looks = sums.gating.range.size, sweeps.size
    power = np.zeros((len(pairs), looks, gates))
    covariance = np.zeros((looks, gates), dtype=np.complex128)
    weight, moment = np.zeros((looks, gates)), np.zeros((looks, gates))
    middle = pairs[sums.middle]
    for begin in range(0, facets.grid.columns, sums.chunk):
        columns = slice(begin, min(begin + sums.chunk, facets.grid.columns))
        each = sums(columns)
        for column, sweep in enumerate(facets.grid.column_sweep[columns]):
            beams = DwellBeams(array, sweeps, 0.0 if staring else cell_azimuth_deg, sweep, sums.gating.level)
            for pair, path in enumerate(pairs):
                power[pair, beams.looks] += beams(path, path) * each.power[pair, column]
            for which, (p, q) in enumerate(sums.crossed):
                covariance[beams.looks] += beams(p, q) * each.covariance[which, column] / len(sums.crossed)
            weight[beams.looks] += beams(middle, middle) * each.weight[column]
            moment[beams.looks] += beams(middle, middle) * each.moment[column]
    with np.errstate(invalid="ignore", divide="ignore"):
        height = moment / weight
    gain = np.array([abs(element.channel) ** 2 for element in array.elements])  # as each antenna's receiver gives it
    first, second = (array.elements[antenna].channel for antenna in array.receivers[:2])
    every = [[pairs.index((min(i, j), max(i, j))) for j in range(number)] for i in range(number)]
    return ExpectedGates(
        sweep=sweeps,
        range=sums.gating.range,
        power=power[every] * gain[:, None, None],
        covariance=covariance * (first * np.conj(second) * (1.0 if array.whole else pulse_coherence(radar))),
        weight=weight,
        weighted_height=height,
    )


class _Sums(NamedTuple):
    """What the facets of some columns return at boresight; arrays (column, gate) unless said otherwise."""

    power: NDArray[np.float64]  # (pair of antennas, column, gate) W
    covariance: NDArray[np.complex128]  # (interferogram, column, gate) W
    weight: NDArray[np.float64]  # m², gate · area
    moment: NDArray[np.float64]  # m³, gate · area · height


class _ColumnExpectation:
    """Sums over the facets of some columns, before the beam of a look."""

    def __init__(
        self, facets: Illumination, rcs: NDArray[np.float32], radar: RadarSettings, pairs: tuple[Path, ...], middle: int
    ) -> None:
        """pairs: of antennas; middle: the one whose gates weigh heights."""
        self._facets, self._rcs, self._radar, self._pairs, self.middle = facets, rcs, radar, pairs, middle
        self.crossed = interferograms(antenna_array(radar))
        self.gating, self.chunk = Gating(radar, facets, gate_samples(radar, pairs)), _CHUNK
        if radar.waveform == "chirp" or radar.receiver.chain == "digital":
            self.gating, self.chunk = ProcessedGating(radar, facets), _PROCESSED_CHUNK

    def __call__(self, columns: slice) -> _Sums:
        facets, pairs = self._facets, self._pairs
        count, gates = columns.stop - columns.start, self.gating.range.size
        paths = facet_paths(facets, self._rcs, self._radar, columns, pairs)
        power = np.zeros((len(pairs), count, gates))
        covariance = np.zeros((len(self.crossed), count, gates), dtype=np.complex128)
        weight, moment = np.zeros((count, gates)), np.zeros((count, gates))
        unit_phasors = self._unit_phasors(paths)
        for block in self.gating.blocks:
            heard = self.gating.weights(block, paths.length)
            heard = heard.astype(np.complex128 if np.iscomplexobj(heard) else np.float64)
            volts = [h * a[:, block.facets, None] for h, a in zip(heard, paths.amplitude, strict=True)]
            for pair, voltage in enumerate(volts):
                power[pair, :, block.gates] = np.einsum("cfg,cfg->cg", voltage, voltage.conj()).real
            for which, (p, q) in enumerate(self.crossed):
                product = volts[pairs.index(p)] * volts[pairs.index(q)].conj()
                phase = unit_phasors[which][:, block.facets, None]
                covariance[which, :, block.gates] = np.sum(product * phase, axis=1)
            area = np.abs(heard[self.middle]) ** 2 * facets.horizontal_area[block.facets][:, None]
            weight[:, block.gates] = area.sum(axis=1)
            moment[:, block.gates] = np.einsum("cfg,cf->cg", area, facets.height[columns, block.facets])
        return _Sums(power, covariance, weight, moment)

    def _unit_phasors(self, paths: FacetPaths) -> list[NDArray[np.complex128]]:
        """Of each interferogram, (column, facet): what the two paths' difference turns the phase by."""
        k = wavenumber(self._radar)
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
