"""Speckle: unit complex Gaussian per facet, correlated in slow time as exp(−(τ/τc)²) where nothing but time passes.

Over the few milliseconds for which the beam dwells on a column the process has few degrees of freedom: it is drawn in
the basis of its own covariance matrix as the beam hears it, truncated where no more of its power than may be left out
is discarded. Every node keeps its variance: what is lost is how speckle that is hardly heard goes with the rest.
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property, lru_cache
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from .. import random_streams
from ..random_streams import Stream
from .summation.gaussian import gaussians, key_of

LEFT_OUT = 1e-4  # share of the power that modes leave out, where no error asks for less


class BeamWindow(NamedTuple):
    """How a column's nodes are heard: all alike where no voltage is said."""

    voltage: tuple[float, ...] | None = None  # (node,) of the beam over its peak's, above 0
    left_out: float = LEFT_OUT  # share of the power that modes may leave out

    def through(self, voltage: NDArray[np.float64]) -> BeamWindow:
        """Through a beam of voltage (node,). What is heard with less than may be left out counts as that."""
        return self._replace(voltage=tuple(np.maximum(voltage, np.sqrt(self.left_out)).tolist()))

    def at(self, nodes: int) -> NDArray[np.float64]:
        """(node,)"""
        return np.ones(nodes) if self.voltage is None else np.array(self.voltage)


EVENLY = BeamWindow()


@dataclass(frozen=True)
class StillSpeckle:
    """Speckle of scatterers that go where the water goes."""

    basis: NDArray[np.float32]  # (mode, node)
    seed: int

    def modes(self, columns: slice, begin: NDArray[np.float64]) -> tuple[NDArray[np.complex64], ...]:
        """(1, mode, node) of the one kind of scatterers, the same for all columns."""
        return (self.basis.astype(np.complex64)[None],)

    @cached_property
    def streams(self) -> NDArray[np.uint64]:
        """(kind,) keys of the random source; still speckle has one kind of scatterer."""
        return np.array([speckle_stream(self.seed)], dtype=np.uint64)

    def strengths(self, chosen: tuple[NDArray[np.intp], NDArray[np.intp]]) -> NDArray[np.float32]:
        """(n, 1): all facets are of the one kind."""
        return np.ones((chosen[0].size, 1), dtype=np.float32)


@lru_cache(maxsize=8)
def speckle_basis(
    nodes: int, spacing_s: float, decorrelation_time_s: float, window: BeamWindow = EVENLY
) -> NDArray[np.float32]:
    """(mode, node): real rows whose products with unit complex Gaussians have the required covariance."""
    lag, voltage = _lags(nodes, spacing_s), window.at(nodes)
    covariance = voltage[:, None] * np.exp(-((lag / decorrelation_time_s) ** 2)) * voltage
    variance, modes = _strongest_modes(covariance, window.left_out)
    basis = (modes * np.sqrt(np.maximum(variance, 0.0))).T / voltage
    basis /= np.sqrt(np.sum(basis**2, axis=0))  # unit variance at every node, exactly
    return basis.astype(np.float32)


@lru_cache(maxsize=8)
def two_way_basis(
    nodes: int, spacing_s: float, decorrelation_time_s: float, turning: float, window: BeamWindow = EVENLY
) -> tuple[NDArray[np.complex128], NDArray[np.float64]]:
    """Modes of speckle whose phase turns at +turning [rad/s] for a share w of its power, at −turning for the rest.

    Returns rows (mode, node) and their contrasts κ (mode,) in ±1. Row m times √(1 + (2w − 1) κ_m), whatever w is, and
    the sum over m with unit complex Gaussians has the covariance exp(−(τ/τc)²)[w e^{+jωτ} + (1 − w) e^{−jωτ}]: where
    the sum of two covariances is made the identity, their difference can be made diagonal.
    """
    lag, voltage = _lags(nodes, spacing_s), window.at(nodes)
    envelope = voltage[:, None] * np.exp(-((lag / decorrelation_time_s) ** 2)) * voltage
    # Of half and half: that holds all that any w needs.
    variance, modes = _strongest_modes(envelope * np.cos(turning * lag), window.left_out)
    root = np.sqrt(np.maximum(variance, np.finfo(float).tiny))
    whitened = modes / root
    contrast, rotation = np.linalg.eigh(1j * (whitened.T @ (envelope * np.sin(turning * lag)) @ whitened))
    return np.asarray((modes * root) @ rotation, dtype=np.complex128).T / voltage, np.clip(contrast, -1.0, 1.0)


def _lags(nodes: int, spacing_s: float) -> NDArray[np.float64]:
    """(node, node) s: the row's time less the column's."""
    time = spacing_s * np.arange(nodes)
    return time[:, None] - time[None, :]


def _strongest_modes(
    covariance: NDArray[np.float64], left_out: float
) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
    """Variances (mode,) and eigenvectors (node, mode) of a covariance, but for that share of the variance.

    The strongest comes first, and each is positive at the last node: modes of windows that differ a little are alike,
    and a column that is heard at the end of a turn and again at the start of the next keeps its speckle.
    """
    variance, modes = np.linalg.eigh(covariance)
    modes = np.where(modes[-1] < 0.0, -modes, modes)
    # Ascending: drop the smallest until so much of the variance is gone.
    kept = np.cumsum(variance) > left_out * np.trace(covariance)
    kept[-1] = True
    return variance[kept][::-1], modes[:, kept][:, ::-1]


def speckle_stream(seed: int, draw: tuple[int, ...] = ()) -> np.uint64:
    """Key of the speckle's random source; draw: names another, independent draw of the same facets."""
    return random_streams.key(seed, Stream.SPECKLE, *draw)


def speckle_weights(
    seed: int, column_number: int, modes: int, facets: int, draw: tuple[int, ...] = ()
) -> NDArray[np.complex64]:
    """(mode, facet) unit complex Gaussians of one column; a facet keeps its numbers however the work is cut up."""
    return gaussians(np.uint64(key_of(speckle_stream(seed, draw), column_number)), facets, modes)
