"""Speckle: unit complex Gaussian per facet, correlated in slow time as exp(−(τ/τc)²) where nothing but time passes.

Over the few milliseconds for which the beam dwells on a column the process has few degrees of freedom: it is drawn in
the basis of its own covariance matrix as the beam hears it, truncated where no more of its power than may be left out
is discarded. Every node keeps its variance: what is lost is how speckle that is hardly heard goes with the rest.

A facet's voltage turns as exp(−2jk × path): what comes nearer at speed c has the Doppler frequency +2c/λ. Bragg waves
run both ways at their own phase speed, whether the water under them moves or not (Valenzuela & Laing 1970); breakers
run ahead of the water with the wave that breaks, at speeds of their own (Lee et al. 1995). The two kinds are
independent. Relative to the water, the covariance of a facet's speckle is

    Bragg, share 1 − b    exp(−(τ/τc)²) [w exp(+2jkcτ) + (1 − w) exp(−2jkcτ)]
    breakers, share b     exp(−(τ/τc)²) exp(−2jk v τ) exp(−½ (2kστ)²)

Mirrors count with the Bragg waves, and speeds along the water as speeds along the ray: at grazing there are no mirrors,
and 20° are 6 %.
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property, lru_cache
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from .. import random_streams
from ..compute.compiled import compiled, compiled_strict
from ..compute.machine import run_blocks
from ..mesh import Facets
from ..random_streams import Stream

LEFT_OUT = 1e-4  # share of the power that modes leave out, where no error asks for less
_MOST_LEFT_OUT = 1e-3  # of the power: covariances of pulses err by no more


def speckle_truncation(share: float) -> float:
    """The share p of a facet's power that may go on in slow time otherwise than by its law, where that share of all
    power may be left out. It is of the same water: no phase turns by √p, but what errs by chance errs by p of itself
    more or less. So p σ is that tenth here, and p at most 1e-3; where nothing may be left out, 1e-4."""
    return min(_MOST_LEFT_OUT, float(np.sqrt(share))) if share > 0.0 else LEFT_OUT


class BeamWindow(NamedTuple):
    """How a column's nodes are heard: all alike where no voltage is said."""

    voltage: tuple[float, ...] | None = None  # (node,) of the beam over its peak's, above 0
    left_out: float = LEFT_OUT  # share of the power that modes may leave out

    def with_beam(self, voltage: NDArray[np.float64]) -> BeamWindow:
        """The window through a beam of voltage (node,); less than the share that may be left out counts as that."""
        return self._replace(voltage=tuple(np.maximum(voltage, np.sqrt(self.left_out)).tolist()))

    def node_voltages(self, nodes: int) -> NDArray[np.float64]:
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
    lag, voltage = _lags(nodes, spacing_s), window.node_voltages(nodes)
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
    lag, voltage = _lags(nodes, spacing_s), window.node_voltages(nodes)
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


_BREAKERS = (1,)  # the draw of a column that is theirs; the Bragg waves have its first


@dataclass(frozen=True)
class Motion:
    """How a facet's scatterers move relative to the water.

    Raises ValueError for shares outside 0 to 1, speeds that are not finite, and columns that do not fit each other.
    """

    bragg_speed: float  # m/s, phase speed of the Bragg waves
    approaching: NDArray[np.float64]  # (column,) share of the Bragg power of waves that run towards the radar
    breaking: NDArray[np.float32] | None  # (column, facet) share of the rcs that comes from breakers
    breaker_speed: NDArray[np.float64]  # (column,) m/s outward
    breaker_spread: float  # m/s rms

    def __post_init__(self) -> None:
        for name in ("bragg_speed", "breaker_spread"):
            if not 0.0 <= getattr(self, name) < np.inf:
                raise ValueError(f"{name} = {getattr(self, name):g}: must be finite and at least 0 m/s")
        for name in ("approaching", "breaking"):
            share = getattr(self, name)
            if share is not None and share.size and not (share.min() >= 0.0 and share.max() <= 1.0):
                raise ValueError(f"{name} = {share.min():g} … {share.max():g}: must lie within 0 to 1; it is a share")
        if not np.isfinite(self.breaker_speed).all():
            raise ValueError("breaker_speed: must be finite; give columns without breakers 0 m/s")
        if self.breaker_speed.shape != self.approaching.shape:
            raise ValueError(
                f"breaker_speed {self.breaker_speed.shape}: must be {self.approaching.shape} as approaching is; "
                "give one value for each column"
            )

    def check(self, facets: Facets) -> None:
        """Raise ValueError unless the shares are those of these facets."""
        columns, count = facets.height.shape
        if self.approaching.shape != (columns,):
            raise ValueError(
                f"motion's columns = {self.approaching.size}: must be the facets' {columns}; "
                "make it from the grid of the same turn"
            )
        if self.breaking is not None and self.breaking.shape != (columns, count):
            raise ValueError(f"breaking {self.breaking.shape}: must be ({columns}, {count}), one share for each facet")

    def breaker_time(self, wavenumber: float, decorrelation_time_s: float) -> float:
        """Decorrelation time of the breakers [s]: their spread of speeds shortens that of the facet."""
        rate = np.hypot(1.0 / decorrelation_time_s, np.sqrt(2.0) * wavenumber * self.breaker_spread)
        return 1.0 / float(rate) if rate > 0.0 else np.inf


class SpeedBounds(NamedTuple):
    """The greatest speeds of a turn's facets, m/s."""

    water: float
    breakers: float | None  # None where none break

    @classmethod
    def of(cls, facets: Facets, motion: Motion | None) -> SpeedBounds:
        """Those of facets and of their scatterers' motion."""
        columns = len(facets.height)
        shares, runs = np.empty((0, 0), np.float32), np.empty(0, np.float32)  # where none break
        if motion is not None and motion.breaking is not None:
            shares, runs = motion.breaking, motion.breaker_speed.astype(np.float32)
        squares, velocity = np.empty((2, columns), np.float32), (facets.velocity_look, facets.velocity_up)
        run_blocks(lambda *block: _fastest(*block, *velocity, shares, runs, squares), columns)
        water, breakers = squares.max(axis=1, initial=-1.0)
        return cls(float(np.sqrt(max(water, 0.0))), float(np.sqrt(breakers)) if breakers >= 0.0 else None)


def fastest_echo(
    fastest: SpeedBounds,
    wavenumber: float,
    decorrelation_time_s: float,
    motion: Motion | None,
    drift: float = 0.0,
) -> tuple[float, float]:
    """Doppler frequency [Hz] beyond which no scatterer echoes, and the shortest decorrelation time [s] of any.

    wavenumber: of the radar [rad/m]; drift: of the antennas [m/s], at most.
    """
    water = drift + fastest.water
    if motion is None:
        return wavenumber * water / np.pi, decorrelation_time_s
    bragg = water + motion.bragg_speed
    if fastest.breakers is None:
        return wavenumber * bragg / np.pi, decorrelation_time_s
    speed = max(bragg, drift + fastest.breakers)
    return wavenumber * speed / np.pi, motion.breaker_time(wavenumber, decorrelation_time_s)


@compiled_strict
def _fastest(begin, end, look, up, breaking, runs, squares):
    """Fill the columns from `begin` to `end` of squares (2, column) m²/s²: of the fastest water, and of the fastest
    breakers, −1 where none are. Velocities and shares (column, facet); runs (column,) outward, of breakers."""
    none = np.float32(-1.0)
    for column in range(begin, end):
        water = fastest = none
        for facet in range(look.shape[1]):
            speed, lift = look[column, facet], up[column, facet]
            water = max(water, speed * speed + lift * lift)
        if breaking.size:
            for facet in range(look.shape[1]):
                speed, lift = look[column, facet] + runs[column], up[column, facet]
                square = speed * speed + lift * lift
                fastest = max(fastest, square if breaking[column, facet] > np.float32(0.0) else none)
        squares[0, column], squares[1, column] = water, fastest


@dataclass(frozen=True)
class MovingSpeckle:
    """Speckle of Bragg waves and breakers, at nodes `spacing_s` apart."""

    motion: Motion
    bragg: NDArray[np.complex128]  # (mode, node)
    contrast: NDArray[np.float64]  # (mode,) of the directions, as two_way_basis gives it
    breakers: NDArray[np.float32]  # (mode, node) as they would be without their mean speed
    spacing_s: float
    wavenumber: float  # rad/m, of the radar
    seed: int
    breaks: bool  # there are breakers

    @classmethod
    def of(
        cls,
        nodes: int,
        spacing_s: float,
        wavenumber: float,
        decorrelation_time_s: float,
        motion: Motion,
        seed: int,
        breaks: bool | None = None,
        window: BeamWindow = EVENLY,
    ) -> MovingSpeckle:
        """For a column of so many nodes, spacing_s [s] apart; wavenumber: of the radar [rad/m]; τc [s]; breaks: whether
        anything does, where the motion does not hold the facets' shares; window: how the beam weighs the nodes."""
        if breaks is None:
            breaks = motion.breaking is not None and bool(motion.breaking.any())
        turning = 2.0 * wavenumber * motion.bragg_speed
        bragg, contrast = two_way_basis(nodes, spacing_s, decorrelation_time_s, turning, window)
        breakers = speckle_basis(nodes, spacing_s, motion.breaker_time(wavenumber, decorrelation_time_s), window)
        return cls(motion, bragg, contrast, breakers, spacing_s, wavenumber, seed, breaks)

    def modes(self, columns: slice, begin: NDArray[np.float64]) -> tuple[NDArray[np.complex64], ...]:
        """(column, mode, node) of Bragg waves and, where there are any, of breakers.

        begin (column,) s: the first node after the beam's passing, from which breakers' phases are reckoned.
        """
        strength = 1.0 + (2.0 * self.motion.approaching[columns, None] - 1.0) * self.contrast
        rows = self.bragg * np.sqrt(strength)[..., None]
        rows /= np.sqrt(np.sum(np.abs(rows) ** 2, axis=1, keepdims=True))  # unit variance at every node, exactly
        bragg = rows.astype(np.complex64)
        if not self.breaks:
            return (bragg,)
        seconds = begin[:, None] + self.spacing_s * np.arange(self.breakers.shape[1])
        rotation = np.exp(-2j * self.wavenumber * self.motion.breaker_speed[columns, None] * seconds)
        return bragg, (self.breakers * rotation[:, None]).astype(np.complex64)

    @cached_property
    def streams(self) -> NDArray[np.uint64]:
        """(kind,) keys of the random source for Bragg waves and breakers."""
        draws = ((), _BREAKERS) if self.breaks else ((),)
        return np.array([speckle_stream(self.seed, draw) for draw in draws], dtype=np.uint64)

    def strengths(self, chosen: tuple[NDArray[np.intp], NDArray[np.intp]]) -> NDArray[np.float32]:
        """(n, kind): voltage of Bragg waves and of breakers on the facets with these columns' and their own numbers."""
        if self.motion.breaking is None or not self.breaks:
            return np.ones((chosen[0].size, 1), dtype=np.float32)
        return _strengths(self.motion.breaking, *chosen)


@compiled
def _strengths(breaking, column, facet):
    """(n, kind): roots of the shares of Bragg waves and of breakers (column, facet)."""
    made = np.empty((column.size, 2), np.float32)
    for n in range(column.size):
        share = breaking[column[n], facet[n]]
        made[n, 0], made[n, 1] = np.sqrt(np.float32(1.0) - share), np.sqrt(share)
    return made
