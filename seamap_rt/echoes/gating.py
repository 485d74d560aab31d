"""Facets into gates: which facets a block of gates can hear, and with what weight.

A gate hears facets within the range response's support. Along a column slant range follows ground range, so a block
of a few gates hears one contiguous run of facets, the same for all columns: small dense products, not scattering.

What is called a gate here is a sample of the echo as facets are summed into it. With a plain pulse and an ideal
receiver these are the gates themselves; a converter's samples lie closer, and those of a chirp are not compressed yet.
"""

from __future__ import annotations

from collections.abc import Callable, Hashable, Iterator
from dataclasses import dataclass, replace
from functools import cached_property, lru_cache
from typing import cast

import numpy as np
from numpy.typing import ArrayLike, NDArray

from ..mesh import Facets
from ..radar.antenna import antenna, pattern_stamps
from ..radar.array import antenna_array
from ..radar.chirp import Chirp
from ..radar.digital import DigitalReceiver
from ..radar.waveform import RangeResponse, gates
from ..settings import RadarSettings

_BLOCK = 8  # gates
_STEP = 1e-3  # m between the entries of the response's table: 2e-4 of its peak at its steepest

Response = Callable[[ArrayLike], NDArray[np.float64]]


@dataclass(frozen=True)
class Samples:
    """Where facets are summed: ranges (sample,) [m], and the response of each path's samples to a reflector."""

    range: NDArray[np.float64]
    responses: tuple[Response, ...]  # of each path; the same object where they are alike
    support_m: float
    compress: Chirp | None = None  # from samples to gates, at any pulse or node


def gate_samples(radar: RadarSettings, paths: tuple[tuple[int, int], ...] | None = None) -> Samples:
    """The gates themselves, of a plain pulse, on the mode's paths or on others."""
    return _plain(radar, gates(radar), paths)


def received_samples(radar: RadarSettings) -> Samples:
    """What the radar's receiver is given: samples of its converter, of a chirp before compression, or the gates."""
    if radar.waveform == "chirp":
        chirp = Chirp(radar)
        kernels = (chirp.kernel,) * len(antenna_array(radar).paths)
        return Samples(chirp.raw_range, kernels, chirp.kernel_support_m, chirp)
    if radar.receiver.chain == "digital":
        return _plain(radar, np.asarray(DigitalReceiver(radar).sample_range, dtype=np.float64))
    return gate_samples(radar)


@dataclass(frozen=True)
class Tabulated:
    """Samples, and what each path's give to a reflector at so many steps off their middles."""

    samples: Samples
    response: NDArray[np.float32]  # (path or 1, entry), that at (n + ½) steps; 0 from the last entry on
    left_out: float = 0.0  # share of the power, of the path that loses most
    step: float = _STEP  # m


def tabulated(radar: RadarSettings, neglected: float = 0.0) -> Tabulated:
    """The samples that the radar's receiver is given, and their response, but for that share of the power that comes
    from farthest off their middles; of a chirp's, which are still to be compressed, all."""
    return _tabulated(cast(Hashable, radar), pattern_stamps(radar), neglected)  # frozen, and so hashable


@lru_cache(maxsize=8)
def _tabulated(settings: Hashable, _: Hashable, neglected: float) -> Tabulated:
    samples = received_samples(cast(RadarSettings, settings))
    tables = _tables(samples)
    table = np.array(tables[:1] if all(table is tables[0] for table in tables) else tables)
    if samples.compress is not None or neglected == 0.0:
        return Tabulated(samples, table)
    power = np.square(table.astype(np.float64))
    beyond = 1.0 - np.cumsum(power, axis=1) / power.sum(axis=1, keepdims=True)
    last = int(np.argmax((beyond <= neglected).all(axis=0)))
    cut = np.array(table[:, : last + 2])
    cut[:, -1] = 0.0
    return Tabulated(samples, cut, max(0.0, float(beyond[:, last].max())))


def _plain(
    radar: RadarSettings, ranges: NDArray[np.float64], paths: tuple[tuple[int, int], ...] | None = None
) -> Samples:
    array, made = antenna_array(radar), dict[float, RangeResponse]()
    responses = []
    for i, j in array.paths if paths is None else paths:
        width = _passed(radar.bandwidth_hz, array.elements[i].bandwidth_hz, array.elements[j].bandwidth_hz)
        responses.append(made.setdefault(width, replace(RangeResponse.of(radar), bandwidth_hz=width)))
    return Samples(ranges, tuple(responses), max(response.support_m for response in responses))


def _tables(samples: Samples) -> list[NDArray[np.float32]]:
    """Response of each path's samples at (n + ½) steps off their middles; the same object where paths are alike."""
    offsets = np.arange(0.5 * _STEP, samples.support_m + 2.0 * _STEP, _STEP)  # middles: an index is cut, not rounded
    tables = {response: np.append(response(offsets), 0.0).astype(np.float32) for response in set(samples.responses)}
    return [tables[response] for response in samples.responses]


def _passed(*bandwidths: float) -> float:
    """Bandwidth of Gaussian filters one after another: those of the receiver and of the antennas themselves."""
    if all(np.isinf(width) for width in bandwidths[1:]):
        return bandwidths[0]
    return float(1.0 / np.sqrt(sum(1.0 / width**2 for width in bandwidths)))


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
        self.step = _STEP
        self._support = samples.support_m
        self._facets = facets
        self.tables = _tables(samples)
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
        scaled = (length[..., block.facets] * (1.0 / _STEP)).astype(np.float32)
        offset = np.abs(scaled[..., None] - (self.range[block.gates] * (1.0 / _STEP)).astype(np.float32))
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

    def __init__(self, radar: RadarSettings, facets: Facets) -> None:
        self.range = gates(radar)
        response = RangeResponse.of(radar)
        self.level = _level(radar, self.range, response, response.support_m)
        self._step = 0.02 * response.resolution_m
        offsets = np.arange(0.0, float(self.range[-1] + response.support_m) + 2.0 * self._step, self._step)
        if radar.waveform == "chirp":
            table = Chirp(radar).response(offsets)
        else:
            digital = DigitalReceiver(radar)
            heard = response(digital.sample_range - offsets[:, None])
            table = digital.ideal(heard[:, None].astype(np.complex128))[:, 0]
        self._table = table.astype(np.complex64)
        self._table[-1] = 0.0
        self.blocks = [GateBlock(slice(0, self.range.size), slice(0, facets.distance.size))]

    def weights(self, block: GateBlock, length: NDArray[np.float64]) -> NDArray[np.complex64]:
        """The response (…, facet, gate) to facets of half-path length R (…, facet)."""
        index = np.rint(length[..., block.facets] * (1.0 / self._step))
        return self._table.take(np.minimum(index, len(self._table) - 1).astype(np.int32), axis=0)
