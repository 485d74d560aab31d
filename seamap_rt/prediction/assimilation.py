"""The free waves that fit what was seen best: a linear least-squares fit with the sea's spectrum as its prior.

Of amplitudes a, both parts of which have prior variances S, and observations y = H a + e the expected sea is a = √S u,
where u minimises |u|² + Σ w (y − H √S u)² (Wiener; Bretherton, Davis & Fandry 1976): solved by conjugate gradients.
Weights hold the observations' errors and the waves that the lattices do not carry there. Near the antennas the sea is
told a hundred times better than far out, and the fit would spend its steps there: what one batch alone would tell
better than anybody asks counts for less.
"""

from __future__ import annotations

from collections.abc import Sequence
from concurrent.futures import Executor
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from .lattice import Field, Lattice
from .observations import Observations
from .wave_sum import WaveSum
from .zones import Preconditioner

Unknowns = list[NDArray[np.complex64]]

_CLOSE = 4e-2  # of the right side: a fit three times tighter changes what is forecast by a hundredth of the sea
_AT_FIRST = 1e-2  # the same, from nothing: farther off the sea where none was seen is up to seven times too high, and a
# fit that goes on from there takes it along, for what nothing tells comes right last
_FEWEST_STEPS = 4  # with which what a new turn says is taken up
_MOST_STEPS = 200
_PLENTY = 2e-3  # open share of the strongest waves, by one batch, from which on more that is told counts half: shadows
# and the waves on top err heights of a wave all along, so that more of them tell no more
_SQUARES = 8.0  # a wavelength of the strongest waves: over which it is told how much is told


@dataclass(frozen=True)
class Batch:
    """Observations of a short time, with how waves are summed at them. rounding: what is added to values of areas that
    are longer than wide to be those of round ones."""

    seen: Observations
    sum: WaveSum
    weight: Field  # at most 1 over the variance
    variance: Field  # of what the waves do not explain
    rounding: NDArray[np.float32] | float = 0.0


def weights(
    seen: Observations, lattices: Sequence[Lattice], left: float, centre: tuple[float, float]
) -> tuple[Field, Field]:
    """Each observation's weight (n,), and the variance (n,) of what the waves do not explain of it.

    left: m², of waves that no lattice carries. Slopes and velocities count their own errors alone.
    """
    distance = np.hypot(seen.x - centre[0], seen.y - centre[1])
    elevation = seen.kind == "elevation"
    variance = seen.std**2 + np.where(elevation, left, 0.0)
    for lattice in lattices:
        variance = variance + np.where(elevation & (distance >= lattice.radius), lattice.variance, 0.0)
    return 1.0 / (variance + _crowding(seen, 1.0 / variance, lattices[0])), variance


def _crowding(seen: Observations, weight: Field, lattice: Lattice) -> Field:
    """What is added to variances (n,) where many observations tell the same waves."""
    if not len(seen) or not lattice.scale.any():
        return np.zeros(len(seen))
    strongest = np.unravel_index(np.argmax(lattice.scale), lattice.scale.shape)
    density = float(lattice.scale[strongest] / lattice.spacing) ** 2
    side = 2.0 * np.pi / float(lattice.k[strongest]) / _SQUARES
    i, j = (np.floor((each - each.min()) / side).astype(int) for each in (seen.x, seen.y))
    square = i * (int(j.max()) + 1) + j
    told = np.bincount(square, weight)[square] / side**2
    return 2.0 * np.pi**2 * density * _PLENTY * told / weight


def solve(
    batches: Sequence[Batch],
    lattices: Sequence[Lattice],
    pool: Executor,
    start: Unknowns | None = None,
    values: Sequence[NDArray[np.float32]] | None = None,
) -> tuple[Unknowns, int]:
    """u of each lattice and the number of steps taken. start: from where; values: in place of the observations' own."""
    roots = [lattice.scale.astype(np.float32) for lattice in lattices]
    nearly_back = Preconditioner(batches, lattices, pool)

    def scaled(parts: Unknowns) -> Unknowns:
        return [root * part for root, part in zip(roots, parts, strict=True)]

    def gathered(each: Sequence[Unknowns]) -> Unknowns:
        return scaled([np.sum(parts, axis=0) for parts in zip(*each, strict=True)])

    def normal(u: Unknowns) -> Unknowns:
        amplitudes = scaled(u)

        def one(batch: Batch) -> Unknowns:
            values = batch.weight.astype(np.float32) * batch.sum.values(amplitudes)
            return batch.sum.amplitudes(values)

        return [mine + seen for mine, seen in zip(u, gathered(list(pool.map(one, batches))), strict=True)]

    def back(pair: tuple[Batch, NDArray[np.float32]]) -> Unknowns:
        return pair[0].sum.amplitudes((pair[0].weight * pair[1]).astype(np.float32))

    given = [batch.seen.value.astype(np.float32) for batch in batches] if values is None else values
    right = gathered(list(pool.map(back, zip(batches, given, strict=True))))
    u = [np.zeros_like(part) for part in right] if start is None else start
    rest = right if start is None else _plus(right, -1.0, normal(u))
    way = better = nearly_back(rest)
    power = _dot(rest, better)
    # What is left to find is no more than what the observations leave open: one half a part of each wave of the sea.
    power_of = [root.astype(np.float64) ** 2 for root in roots]
    waves = sum(map(np.sum, power_of)) ** 2 / max(float(sum(np.sum(each**2) for each in power_of)), 1e-300)
    enough = min((_AT_FIRST if start is None else _CLOSE) ** 2 * _dot(right, nearly_back(right)), float(waves))
    steps = 0
    while (power > enough or steps < _FEWEST_STEPS) and steps < _MOST_STEPS and power > 0.0:
        turned = normal(way)
        length = power / _dot(way, turned)
        u, rest = _plus(u, length, way), _plus(rest, -length, turned)
        better = nearly_back(rest)
        power, before = _dot(rest, better), power
        way = _plus(better, power / before, way)
        steps += 1
    return u, steps


def _plus(one: Unknowns, factor: float, other: Unknowns) -> Unknowns:
    return [np.asarray(a + np.float32(factor) * b, np.complex64) for a, b in zip(one, other, strict=True)]


def _dot(one: Sequence[NDArray[np.complexfloating]], other: Sequence[NDArray[np.complexfloating]]) -> float:
    return float(sum(np.vdot(a, b).real for a, b in zip(one, other, strict=True)))
