"""Facets into gates: which facets a block of gates can hear, and with what weight.

A gate hears facets within the range response's support. Along a column slant range follows ground range, so a block of a
few gates hears one contiguous run of facets, the same for all columns: small dense products instead of scattering.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from ..mesh import Facets
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
