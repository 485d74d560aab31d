"""The speckle-averaged echo: power of every pair and covariance of the receivers, per look and gate, without noise.

Facets are independent scatterers, so their powers add, and each contributes its own interferometric phase; where its
field comes over an edge, that of the detour as well.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from ..radar.array import Array, antenna_array
from ..radar.grid import look_sweeps
from ..radar.scan import BEAMS_BEYOND
from ..settings import RadarSettings
from ..tracing import Illumination
from .gating import Gating, ProcessedGating, gate_samples
from .paths import Path, facet_paths, wavenumber

_CHUNK, _PROCESSED_CHUNK = 32, 2  # columns
_BEAM_POINTS = 24  # of the dwell over which a look's beam is averaged


@dataclass(frozen=True)
class ExpectedGates:
    """Expectation over speckle; arrays (look, gate) unless said otherwise."""

    sweep: NDArray[np.float64]  # (look,) deg from the start of the sector
    range: NDArray[np.float64]  # (gate,) m
    power: NDArray[np.float64]  # (tx, rx, look, gate) W
    covariance: NDArray[np.complex128]  # W, mean over the interferograms of the mode; no Doppler between pulses
    weight: NDArray[np.float64]  # Σ beam · gate · area: what weights a cell's points, shadow or not
    weighted_height: NDArray[np.float64]  # m, the mean height with that weight


def expected_look_gates(
    facets: Illumination, rcs: NDArray[np.float32], radar: RadarSettings, cell_azimuth_deg: float
) -> ExpectedGates:
    """Expected power and covariance of each look (averaged over its dwell) and gate.

    Power is that of every antenna to every other, whatever their roles.
    """
    array, staring = antenna_array(radar), radar.scan == "staring"
    sweeps = look_sweeps(radar.sector_deg, cell_azimuth_deg, staring)
    number, k = len(array.elements), wavenumber(radar)
    pairs = tuple((i, j) for i in range(number) for j in range(i, number))
    crossed = interferograms(array)
    gating, chunk = Gating(radar, facets, gate_samples(radar, pairs)), _CHUNK
    if radar.waveform == "chirp" or radar.receiver.chain == "digital":
        gating, chunk = ProcessedGating(radar, facets), _PROCESSED_CHUNK
    gates, looks = gating.range.size, sweeps.size
    power = np.zeros((len(pairs), looks, gates))
    covariance = np.zeros((looks, gates), dtype=np.complex128)
    weight, moment = np.zeros((looks, gates)), np.zeros((looks, gates))
    middle = pairs.index((0, min(1, number - 1)))
    for begin in range(0, facets.grid.columns, chunk):
        columns = slice(begin, min(begin + chunk, facets.grid.columns))
        paths = facet_paths(facets, rcs, radar, columns, pairs)
        count = columns.stop - columns.start
        column_power = np.zeros((len(pairs), count, gates))
        column_covariance = np.zeros((len(crossed), count, gates), dtype=np.complex128)
        column_weight, column_moment = np.zeros((count, gates)), np.zeros((count, gates))
        longer = np.stack([paths.difference[i] + paths.difference[j] for i, j in pairs])
        turning = [
            np.exp(1j * np.remainder(k * (longer[pairs.index(q)] - longer[pairs.index(p)]), 2.0 * np.pi))
            for p, q in crossed
        ]
        for block in gating.blocks:
            heard = gating.weights(block, paths.length)
            heard = heard.astype(np.complex128 if np.iscomplexobj(heard) else np.float64)
            volts = [h * a[:, block.facets, None] for h, a in zip(heard, paths.amplitude, strict=True)]
            for pair, voltage in enumerate(volts):
                column_power[pair, :, block.gates] = np.einsum("cfg,cfg->cg", voltage, voltage.conj()).real
            for which, (p, q) in enumerate(crossed):
                product = volts[pairs.index(p)] * volts[pairs.index(q)].conj()
                phase = turning[which][:, block.facets, None]
                column_covariance[which, :, block.gates] = np.sum(product * phase, axis=1)
            area = np.abs(heard[middle]) ** 2 * facets.horizontal_area[block.facets][:, None]
            column_weight[:, block.gates] = area.sum(axis=1)
            column_moment[:, block.gates] = np.einsum("cfg,cf->cg", area, facets.height[columns, block.facets])
        for column in range(count):
            sweep = facets.grid.column_sweep[columns.start + column]
            near, beams = look_beams(array, sweeps, 0.0 if staring else cell_azimuth_deg, sweep, gating.level)
            for pair, path in enumerate(pairs):
                power[pair, near] += beams(path, path) * column_power[pair, column]
            for which, (p, q) in enumerate(crossed):
                covariance[near] += beams(p, q) * column_covariance[which, column] / len(crossed)
            weight[near] += beams(pairs[middle], pairs[middle]) * column_weight[column]
            moment[near] += beams(pairs[middle], pairs[middle]) * column_moment[column]
    with np.errstate(invalid="ignore", divide="ignore"):
        height = moment / weight
    heard = np.array([abs(element.channel) ** 2 for element in array.elements])  # as each antenna's receiver gives it
    first, second = (array.elements[antenna].channel for antenna in array.receivers[:2])
    every = [[pairs.index((min(i, j), max(i, j))) for j in range(number)] for i in range(number)]
    return ExpectedGates(
        sweep=sweeps,
        range=gating.range,
        power=power[every] * heard[:, None, None],
        covariance=covariance * (first * np.conj(second)),
        weight=weight,
        weighted_height=height,
    )


def interferograms(array: Array) -> list[tuple[Path, Path]]:
    """Pairs of paths whose echoes the mode multiplies, that of the first receiver before that of the second."""
    first, second = array.receivers[:2]

    def path(transmitter: int, receiver: int) -> Path:
        return min(transmitter, receiver), max(transmitter, receiver)

    if array.whole:
        return [(path(t, first), path(t, second)) for t in array.transmitters]
    sender = {array.receivers[r]: slot.transmitter for slot in array.cycle for r in slot.receivers}
    return [(path(sender[first], first), path(sender[second], second))]


class _Beams:
    """The dwell's mean product of two paths' voltage patterns, (look, gate)."""

    def __init__(self, array: Array, cosine: NDArray[np.float64], heard: NDArray[np.bool_], span: float) -> None:
        """span: beyond which no cosine lies; the same for all columns, so that looks are alike to the last digits."""
        self._array, self._cosine, self._heard, self._span = array, cosine, heard, span
        self._cuts: dict[object, NDArray[np.float64]] = {}
        self._products: dict[object, NDArray[np.float64]] = {}

    def __call__(self, one: Path, other: Path) -> NDArray[np.float64]:
        cuts = sorted((self._array.elements[n].antenna.azimuth for n in (*one, *other)), key=id)
        key = tuple(cuts)
        if key not in self._products:
            product = np.ones_like(self._cosine)
            for cut in cuts:
                product = product * self._voltage(cut)
            self._products[key] = np.where(self._heard, product, 0.0).mean(axis=1)
        return self._products[key]

    def _voltage(self, cut) -> NDArray[np.float64]:
        if cut not in self._cuts:
            table = np.linspace(-self._span, self._span, 4001)
            self._cuts[cut] = np.interp(self._cosine, table, cut(table))
        return self._cuts[cut]


def look_beams(
    array: Array,
    sweeps: NDArray[np.float64],
    cell_azimuth_deg: float,
    column_sweep: float,
    level: NDArray[np.float64],
) -> tuple[NDArray[np.intp], _Beams]:
    """The looks that hear a column, and the dwell's mean pattern towards it for any two paths, (look, gate).

    A fan that leans is heard where it meets the sea, and looks are made of pulses by where that is: it needs no more.
    """
    reach = BEAMS_BEYOND * array.beam_deg + 1e-9  # rounding must not separate looks that stand alike
    near = np.flatnonzero(np.abs(sweeps - column_sweep) <= reach + 0.5 * cell_azimuth_deg)
    points = _BEAM_POINTS if cell_azimuth_deg > 0.0 else 1
    dwell = cell_azimuth_deg * ((np.arange(points) + 0.5) / points - 0.5)
    offset = sweeps[near, None] + dwell - column_sweep
    cosine = -np.sin(np.radians(offset))[..., None] * level
    span = float(np.sin(np.radians(min(90.0, reach + cell_azimuth_deg))))
    return near, _Beams(array, cosine, np.abs(offset)[..., None] <= reach, span)
