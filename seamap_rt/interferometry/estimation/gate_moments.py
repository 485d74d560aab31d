"""What the voltages of two gates have in common that hear the same scatterers through one pulse."""

from __future__ import annotations

from dataclasses import dataclass
from functools import lru_cache

import numpy as np
from numpy.typing import NDArray

from ...radar.waveform import RangeResponse

Map = NDArray[np.float64]

_POINTS = 401  # of the integrals over the pulse's main lobe


@dataclass(frozen=True)
class GateMoments:
    """Means ⟨…⟩ over scatterers that lie at random, over the mean power of a gate.

    y is a gate's voltage; y' that of the same scatterers, each times its distance s from the gate's middle; the second
    gate lies a lag [m], of any shape, beyond the first. offset [m]: s; heard: the pulse's response p(s).
    """

    response: RangeResponse
    offset: Map
    heard: Map

    @classmethod
    def of(cls, response: RangeResponse) -> GateMoments:
        """Of a pulse, of a chirp its main lobe."""
        offset = np.linspace(-response.support_m, response.support_m, _POINTS)
        return cls(response, offset, response(offset))

    def echo(self, lag: Map) -> Map:
        """A = ⟨y₁ y₂*⟩, 1 at lag 0."""
        return _means(self.response, lag)[0]

    def moved(self, lag: Map) -> Map:
        """X = ⟨y'₁ y₂*⟩ [m], odd in the lag."""
        return _means(self.response, lag)[1]

    def both_moved(self, lag: Map) -> Map:
        """Q = ⟨y'₁ y'₂*⟩ [m²]."""
        return _means(self.response, lag)[2]

    def means(self, lag: Map) -> Map:
        """(3, …): A, X and Q."""
        offset, heard = self._second(lag)
        moved = self.offset * self.heard
        return np.stack([self._sum(heard, self.heard), self._sum(heard, moved), self._sum(offset * heard, moved)])

    def _second(self, lag: Map) -> tuple[Map, Map]:
        """The second gate's offsets, and its response: of the main lobe alone as well, or moments of several gates
        would be those of no echo at all."""
        offset = self.offset - np.asarray(lag)[..., None]
        return offset, np.where(np.abs(offset) <= self.offset[-1], self.response(offset), 0.0)

    def _sum(self, other: Map, own: Map) -> Map:
        return np.asarray(other @ own / (self.heard @ self.heard))


def _means(response: RangeResponse, lag: Map) -> Map:
    """The means of a response at lags, known from turn to turn."""
    lags = np.asarray(lag, dtype=np.float64)
    return _known_means(response, lags.tobytes(), lags.shape)


@lru_cache(maxsize=64)
def _known_means(response: RangeResponse, lags: bytes, shape: tuple[int, ...]) -> Map:
    means = GateMoments.of(response).means(np.frombuffer(lags).reshape(shape))
    means.flags.writeable = False
    return means
