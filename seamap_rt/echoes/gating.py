"""Facets into gates: which facets a block of gates can hear, and with what weight.

A gate hears facets within the range response's support. Along a column slant range follows ground range, so a block
of a few gates hears one contiguous run of facets, the same for all columns: small dense products, not scattering.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from ..mesh import Facets
from ..radar.antenna import antenna
from ..radar.waveform import RangeResponse, gates
from ..settings import RadarSettings

_BLOCK = 8  # gates
_STEP = 1e-3  # m between the entries of the response's table: 2e-4 of its peak at its steepest


@dataclass(frozen=True)
class GateBlock:
    """Gates `gates` (slice) hear facets `facets` (slice) of every column."""

    gates: slice
    facets: slice


class Gating:
    """The range response of all gates to the facets of a turn."""

    def __init__(self, radar: RadarSettings, facets: Facets) -> None:
        self.range = gates(radar)
        self.response = RangeResponse.of(radar)
        self._support = self.response.support_m
        grid = np.arange(0.5 * _STEP, self._support + 2.0 * _STEP, _STEP)  # middles: an index is cut, not rounded
        self._table = np.append(self.response(grid), 0.0).astype(np.float32)
        self.blocks = list(self._blocks(radar, facets))
        self.level = self._level(radar)

    def _level(self, radar: RadarSettings) -> NDArray[np.float64]:
        """(gate,) cosine of the elevation of the mean sea that a gate hears: at its centre of power, which on the
        flank of the elevation pattern lies metres off its middle (0.2 dB where the sea lies 60 dB below the beam)."""
        slant = self.range[:, None] + self._support * np.linspace(-1.0, 1.0, 201)
        sine = np.clip(radar.height_m / np.maximum(slant, 1e-9), 0.0, 1.0 - 1e-6)
        pattern, cosine = antenna(radar), np.sqrt(1.0 - sine**2)
        cut = pattern.elevation(np.sin(pattern.tilt) * cosine - np.cos(pattern.tilt) * sine)
        power = np.where(slant > radar.height_m, (self.response(slant - self.range[:, None]) * cut**2) ** 2, 0.0)
        power /= np.maximum(slant, radar.height_m) ** 3 * cosine
        total = power.sum(axis=1)
        return np.where(total > 0.0, (power * cosine).sum(axis=1) / np.where(total > 0.0, total, 1.0), 0.0)

    def _blocks(self, radar: RadarSettings, facets: Facets) -> Iterator[GateBlock]:
        margin = self._support + 0.5 * radar.baseline_m
        drop = radar.height_m - facets.height
        highest, lowest = max(float(drop.max()), 0.0), float(np.abs(drop).min())
        crosses = bool((drop.min() <= 0.0) and (drop.max() >= 0.0))
        for first in range(0, self.range.size, _BLOCK):
            block = slice(first, min(first + _BLOCK, self.range.size))
            near = max(self.range[block][0] - margin, 0.0)
            far = self.range[block][-1] + margin
            # A point at ground distance d has slant range between hypot(d, least drop) and hypot(d, greatest drop).
            inner = np.sqrt(max(near**2 - max(highest, float(np.abs(drop).max())) ** 2, 0.0))
            outer = np.sqrt(max(far**2 - (0.0 if crosses else lowest) ** 2, 0.0))
            start = int(np.searchsorted(facets.distance, inner))
            stop = int(np.searchsorted(facets.distance, outer))
            if stop > start:
                yield GateBlock(block, slice(start, stop))

    def weights(self, block: GateBlock, length: NDArray[np.float64]) -> NDArray[np.float32]:
        """h(r_gate − R) (…, facet of the block, gate) for facets of half-path length R (…, all facets)."""
        scaled = (length[..., block.facets] * (1.0 / _STEP)).astype(np.float32)
        offset = np.abs(scaled[..., None] - (self.range[block.gates] * (1.0 / _STEP)).astype(np.float32))
        np.minimum(offset, np.float32(self._table.size - 1), out=offset)
        return self._table.take(offset.astype(np.int32))
