"""The free waves that fit what was seen best: a linear least-squares fit with the sea's spectrum as its prior.

Of amplitudes a, both parts of which have prior variances S, and observations y = H a + e the expected sea is a = √S u,
where u minimises |u|² + Σ w (y − H √S u)² (Wiener; Bretherton, Davis & Fandry 1976): solved by conjugate gradients.
Weights hold the observations' errors and the waves that the lattices do not carry there. Near the antennas the sea is
known a hundred times better than far out, and the fit would spend its steps there: what one batch alone would tell
better than anybody asks counts for less.

Preconditioners. For every wave both lie in one sum: no diagonal serves. But a packet of waves has a place too. In zones
in which the sea is about equally known, w, the operator is about 1 + S w for waves of prior variance S; packets are
taken apart into zones by windows whose squares sum to 1, each zone is solved by itself, and the zones are put together
again (a windowed symbol's inverse). What was observed at another time of packets counts where they are in the middle of
the time, by the mean velocity of groups. Of the strongest of the long waves, few in a circle, the part of the normal
matrix is inverted: observations determine a swell a million times better than its prior where it was seen, and not at
all a wavelength farther out; conjugate gradients that stop early leave waves out there that are far too high, and these
arrive as time goes. So the normal matrix of such waves is written out, square by square, and factorised (Cholesky).
"""

from __future__ import annotations

from collections.abc import Sequence
from concurrent.futures import Executor
from dataclasses import dataclass
from itertools import repeat

import numpy as np
from numpy.typing import NDArray
from scipy import fft
from scipy.linalg import cho_factor, cho_solve

from .observations import Observations, damped
from .phasors import phasors
from .spectrum import Field, Lattice
from .wave_sum import WaveSum

Unknowns = list[NDArray[np.complex64]]

_TOLERANCE = 4e-2  # of the right side: a fit three times tighter changes what is forecast by a hundredth of the sea
_FIRST_TOLERANCE = (
    1e-2  # the same, from nothing: farther off the sea where none was seen is up to seven times too high, and a
)
# fit that goes on from there takes it along, for what nothing tells comes right last
_FEWEST_STEPS = 4  # with which what a new turn says is taken up
_MOST_STEPS = 200
_SATURATION = (
    2e-3  # open share of the strongest waves, by one batch, from which on more information counts half: shadows
)
# and the waves on top err heights of a wave all along, so that more of them tell no more
_SQUARES = 8.0  # a wavelength of the strongest waves: over which information is summed


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
    return 1.0 / (variance + _redundancy(seen, 1.0 / variance, lattices[0])), variance


def _redundancy(seen: Observations, weight: Field, lattice: Lattice) -> Field:
    """What is added to variances (n,) where many observations tell the same waves."""
    if not len(seen) or not lattice.scale.any():
        return np.zeros(len(seen))
    strongest = np.unravel_index(np.argmax(lattice.scale), lattice.scale.shape)
    density = float(lattice.scale[strongest] / lattice.spacing) ** 2
    side = 2.0 * np.pi / float(lattice.k[strongest]) / _SQUARES
    i, j = (np.floor((each - each.min()) / side).astype(int) for each in (seen.x, seen.y))
    square = i * (int(j.max()) + 1) + j
    total = np.bincount(square, weight)[square] / side**2
    return 2.0 * np.pi**2 * density * _SATURATION * total / weight


def solve(
    batches: Sequence[Batch],
    lattices: Sequence[Lattice],
    pool: Executor,
    start: Unknowns | None = None,
    values: Sequence[NDArray[np.float32]] | None = None,
) -> tuple[Unknowns, int]:
    """u of each lattice and the number of steps taken. start: from where; values: in place of the observations' own."""
    roots = [lattice.scale.astype(np.float32) for lattice in lattices]
    precondition = Preconditioner(batches, lattices, pool)

    def scaled(parts: Unknowns) -> Unknowns:
        return [root * part for root, part in zip(roots, parts, strict=True)]

    def gathered(each: Sequence[Unknowns]) -> Unknowns:
        return scaled([np.sum(parts, axis=0) for parts in zip(*each, strict=True)])

    def normal(u: Unknowns) -> Unknowns:
        amplitudes = scaled(u)

        def apply_batch(batch: Batch) -> Unknowns:
            values = batch.weight.astype(np.float32) * batch.sum.values(amplitudes)
            return batch.sum.amplitudes(values)

        return [mine + seen for mine, seen in zip(u, gathered(list(pool.map(apply_batch, batches))), strict=True)]

    def back_project(pair: tuple[Batch, NDArray[np.float32]]) -> Unknowns:
        return pair[0].sum.amplitudes((pair[0].weight * pair[1]).astype(np.float32))

    given = [batch.seen.value.astype(np.float32) for batch in batches] if values is None else values
    right = gathered(list(pool.map(back_project, zip(batches, given, strict=True))))
    u = [np.zeros_like(part) for part in right] if start is None else start
    rest = right if start is None else _plus(right, -1.0, normal(u))
    way = better = precondition(rest)
    power = _dot(rest, better)
    # What is left to find is no more than what the observations leave open: one half a part of each wave of the sea.
    power_of = [root.astype(np.float64) ** 2 for root in roots]
    waves = sum(map(np.sum, power_of)) ** 2 / max(float(sum(np.sum(each**2) for each in power_of)), 1e-300)
    enough = min(
        (_FIRST_TOLERANCE if start is None else _TOLERANCE) ** 2 * _dot(right, precondition(right)), float(waves)
    )
    steps = 0
    while (power > enough or steps < _FEWEST_STEPS) and steps < _MOST_STEPS and power > 0.0:
        turned = normal(way)
        length = power / _dot(way, turned)
        u, rest = _plus(u, length, way), _plus(rest, -length, turned)
        better = precondition(rest)
        power, before = _dot(rest, better), power
        way = _plus(better, power / before, way)
        steps += 1
    return u, steps


def _plus(one: Unknowns, factor: float, other: Unknowns) -> Unknowns:
    return [np.asarray(a + np.float32(factor) * b, np.complex64) for a, b in zip(one, other, strict=True)]


def _dot(one: Sequence[NDArray[np.complexfloating]], other: Sequence[NDArray[np.complexfloating]]) -> float:
    return float(sum(np.vdot(a, b).real for a, b in zip(one, other, strict=True)))


_MOST = 240  # waves
_LEAST = 1e-2  # of the strongest one's prior variance
_LONG = 0.15  # of how wide what was seen is: zones resolve shorter waves well enough
_ZONE_SQUARES = 5.0  # a wavelength of the shortest of them


class StrongestWaves:
    """The strongest waves of one lattice, by what batches tell of them."""

    def __init__(self, lattice: Lattice, batches: Sequence[Batch]) -> None:
        power = lattice.scale**2
        seen = [np.ptp((each.seen.x, each.seen.y), axis=1).max() for each in batches if len(each.seen)]
        longest = 2.0 * np.pi / (_LONG * max(seen, default=0.0) + 1e-9)
        wanted = (power > _LEAST * power.max()) & (power > 0.0) & (lattice.k < longest)
        order = np.flatnonzero(wanted)
        self.chosen = order[np.argsort(power.ravel()[order])[::-1][:_MOST]]
        self._inverse = None if not self.chosen.size else cho_factor(self._operator(lattice, batches), lower=True)

    def _operator(self, lattice: Lattice, batches: Sequence[Batch]) -> NDArray[np.float64]:
        kx, ky, k, omega, root = (
            each.ravel()[self.chosen] for each in (lattice.kx, lattice.ky, lattice.k, lattice.omega, lattice.scale)
        )
        side, made = 2.0 * np.pi / (_ZONE_SQUARES * k.max()), np.eye(2 * k.size)
        for batch in batches:
            seen, factor = batch.seen, lattice.factor(str(batch.seen.kind[0]), batch.sum.water).ravel()[self.chosen]
            i, j = (np.floor((each - each.min()) / side).astype(np.intp) for each in (seen.x, seen.y))
            _, square = np.unique(i * (int(j.max()) + 1) + j, return_inverse=True)
            information = np.bincount(square, batch.weight)
            x, y, time = (
                np.bincount(square, batch.weight * each) / information for each in (seen.x, seen.y, seen.time)
            )
            size = root * factor * damped(batch.sum.blur.mean(axis=0), kx, ky)
            waves = np.sqrt(information)[:, None] * phasors(kx, ky, omega, x, y, time) * size
            rows = np.hstack((waves.real, -waves.imag)).astype(np.float32)
            made += rows.T @ rows
        return made

    def apply_inverse(self, unknowns: NDArray[np.complex64]) -> NDArray[np.complex64]:
        """Apply the inverse to the chosen waves (wave,)."""
        parts = np.concatenate((unknowns.real, unknowns.imag))
        real, imaginary = np.split(np.asarray(cho_solve(self._inverse, parts)), 2)
        return (real + 1j * imaginary).astype(np.complex64)


_RATIO = 20.0  # of information, from zone to zone
_FAINT = 0.3  # of the strongest wave's prior: less information than this is none
_SMOOTH = 2.0  # over the strongest waves' wavenumber: packets are no narrower


@dataclass(frozen=True)
class _Zones:
    """One lattice's: windows (zone, n, n) over places, inverses (zone, n, n) and phases (n, n) of waves."""

    windows: NDArray[np.float32]
    inverses: NDArray[np.float32]
    phase: NDArray[np.complex64]

    def apply_inverse(self, unknowns: NDArray[np.complex64]) -> NDArray[np.complex64]:
        packets = _inverse(fft.ifftshift(unknowns) * self.phase)
        waves = self.inverses * _forward(self.windows * packets)
        packets = np.sum(self.windows * _inverse(waves), axis=0)
        return fft.fftshift(_forward(packets) * np.conj(self.phase))


def _forward(packets: NDArray[np.complex64]) -> NDArray[np.complex64]:
    return np.asarray(fft.fft2(packets, overwrite_x=True))


def _inverse(waves: NDArray[np.complex64]) -> NDArray[np.complex64]:
    return np.asarray(fft.ifft2(waves, overwrite_x=True))


class Preconditioner:
    """A preconditioner for batches and the lattices that they are fitted by; positive definite, and its own adjoint."""

    def __init__(self, batches: Sequence[Batch], lattices: Sequence[Lattice], workers: Executor) -> None:
        self._workers = workers
        time = np.concatenate([batch.seen.time for batch in batches])
        self._middle = float(time.mean()) if time.size else 0.0
        self._strongest = StrongestWaves(lattices[0], batches)
        self._zones = list(workers.map(self._lattice_zones, range(len(lattices)), lattices, repeat(batches)))

    def __call__(self, unknowns: Sequence[NDArray[np.complex64]]) -> list[NDArray[np.complex64]]:
        chosen = self._strongest.chosen
        if not chosen.size:
            return list(self._workers.map(_Zones.apply_inverse, self._zones, unknowns))
        others = unknowns[0].copy()
        others.ravel()[chosen] = 0.0
        made = list(self._workers.map(_Zones.apply_inverse, self._zones, [others, *unknowns[1:]]))
        made[0].ravel()[chosen] = self._strongest.apply_inverse(unknowns[0].ravel()[chosen])
        return made

    def _lattice_zones(self, number: int, lattice: Lattice, batches: Sequence[Batch]) -> _Zones:
        prior = lattice.scale**2
        strongest = np.unravel_index(np.argmax(prior), prior.shape)
        most, k = float(prior[strongest]), max(float(lattice.k[strongest]), lattice.spacing)
        information = _smooth(self._information(number, lattice, batches), _SMOOTH / k, lattice.spacing)
        least = max(_FAINT / most if most > 0.0 else np.inf, 1e-6 * float(information.max()))
        span = np.log(max(float(information.max()) / least, 1.0))
        steps = max(int(np.ceil(span / np.log(_RATIO))), 1)
        height = np.log(np.maximum(information / least, 1.0)) * steps / max(span, 1e-9)
        zone = np.arange(steps + 1.0)[:, None, None]
        windows = np.sqrt(np.clip(1.0 - np.abs(height - zone), 0.0, 1.0))
        levels = np.where(np.isfinite(least), least, 0.0) * np.exp(zone * span / steps)
        inverses = fft.ifftshift(1.0 / (1.0 + levels * prior), axes=(1, 2))
        phase = fft.ifftshift(np.exp(-1j * lattice.omega * self._middle))
        return _Zones(windows.astype(np.float32), inverses.astype(np.float32), phase.astype(np.complex64))

    def _information(self, number: int, lattice: Lattice, batches: Sequence[Batch]) -> Field:
        """Weights over places (n, n) of packets in the middle of the time, as if they were as dense everywhere."""
        side = lattice.k.shape[0]
        power = lattice.scale**2
        speed = [
            float(np.sum(power * np.gradient(lattice.omega, lattice.spacing, axis=axis)) / max(power.sum(), 1e-30))
            for axis in (0, 1)
        ]
        information = np.zeros(side * side)
        for batch in batches:
            seen, places = batch.seen, batch.sum.places(number)
            past = seen.time[places] - self._middle
            at = [
                np.round((each[places] - v * past) * (lattice.spacing / (2.0 * np.pi)) * side).astype(int) % side
                for each, v in zip((seen.x, seen.y), speed, strict=True)
            ]
            information += np.bincount(at[0] * side + at[1], batch.weight[places], side * side)
        return 0.5 * side**2 * information.reshape(side, side)


def _smooth(field: Field, width: float, spacing: float) -> Field:
    """A field smoothed over a Gaussian of so many metres."""
    side = field.shape[0]
    k = fft.fftfreq(side, 1.0 / side) * spacing
    softly = np.exp(-0.5 * width**2 * k**2)
    smooth = np.asarray(fft.ifft2(np.asarray(fft.fft2(field)) * softly[:, None] * softly))
    return np.maximum(np.real(smooth), 0.0)
