"""Sums of free waves at many places and times, and the adjoint: observations back to amplitudes.

The value of a kind at (x, t) is Re Σ f a e^j(k·x − ωt). A batch of observations spans a second or two, in which its
time is followed by Chebyshev's polynomials T_m of τ ∈ [−1, 1]: e^(−jωt) = e^(−jωt₀) Σ (2 − δ_m0) (−j)^m J_m(ωΔ) T_m(τ)
(Jacobi and Anger). Each term is a transform from a lattice to places off it: an FFT to a finer grid, as wide as the
places lie, and a Kaiser–Bessel kernel between its points (Jackson et al. 1991; Beatty, Nishimura & Pauly 2005). Each is
real, so that two of them go in one (`Terms`).

Term m is c β_m (−j)^m with a carrier c of each wave and real β_m, and its field is real. Of the fields of an even term
and the odd one after it, one as the real and one as the imaginary part, the wave's amplitudes are f c a + g (c a)*
with real f and g; * is the conjugate of the wave that runs the other way.
"""

from __future__ import annotations

from collections.abc import Sequence
from copy import copy
from dataclasses import dataclass, replace
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray
from scipy import fft
from scipy.special import i0, jv

from ..compute.compiled import compiled
from ..physics.dispersion import Water
from .observations import Observations, damped
from .phasors import phasors
from .spectrum import Field, Lattice

Waves = NDArray[np.complex64]


@dataclass(frozen=True)
class Terms:
    """carrier (n, n); mine and against (pair, n, n): f and g."""

    carrier: Waves
    mine: NDArray[np.float32]
    against: NDArray[np.float32]

    @classmethod
    def of(cls, carrier: NDArray[np.complexfloating], shares: Sequence[NDArray[np.floating]]) -> Terms:
        """shares: β (n, n) of an even number of terms."""
        signs = (1.0, 1.0, -1.0, -1.0)  # of j^m (−j)^m along the pairs: the odd term's j stands beside its (−j)^m
        signed = [signs[m % 4] * share for m, share in enumerate(shares)]
        even, odd = (np.stack(signed[first::2]) for first in (0, 1))
        mine, against = 0.5 * (even + odd), 0.5 * (even - odd)[:, ::-1, ::-1]
        return cls(
            carrier.astype(np.complex64), mine.astype(np.float32), np.ascontiguousarray(against, dtype=np.float32)
        )

    @property
    def count(self) -> int:
        """Number of pairs."""
        return self.mine.shape[0]

    def pairs(self, amplitudes: Waves) -> Waves:
        """(pair, n, n) of amplitudes (n, n)."""
        made = np.empty(self.mine.shape, np.complex64)
        _pairs(self.carrier, self.mine, self.against, amplitudes, made)
        return made

    def amplitudes(self, pairs: Waves) -> Waves:
        """The adjoint of that, of as many columns as there are waves."""
        made = np.empty(self.carrier.shape, np.complex64)
        _amplitudes(self.carrier, self.mine, self.against, pairs, made)
        return made


@compiled
def _pairs(
    carrier: Waves, mine: NDArray[np.float32], against: NDArray[np.float32], amplitudes: Waves, made: Waves
) -> None:
    count, rows, columns = mine.shape
    carried = carrier * amplitudes
    for i in range(rows):
        forth, back = carried[i], carried[rows - 1 - i]
        for pair in range(count):
            f, g, line = mine[pair, i], against[pair, i], made[pair, i]
            for j in range(columns):
                b = columns - 1 - j
                line[j] = complex(
                    f[j] * forth[j].real + g[j] * back[b].real, f[j] * forth[j].imag - g[j] * back[b].imag
                )


@compiled
def _amplitudes(
    carrier: Waves, mine: NDArray[np.float32], against: NDArray[np.float32], pairs: Waves, made: Waves
) -> None:
    count, rows, columns = mine.shape
    real, imaginary = np.empty(columns, np.float32), np.empty(columns, np.float32)
    for i in range(rows):
        real[:] = 0.0
        imaginary[:] = 0.0
        for pair in range(count):
            f, g, forth, back = mine[pair, i], against[pair, rows - 1 - i], pairs[pair, i], pairs[pair, rows - 1 - i]
            for j in range(columns):
                b = columns - 1 - j
                real[j] += f[j] * forth[j].real + g[b] * back[b].real
                imaginary[j] += f[j] * forth[j].imag - g[b] * back[b].imag
        for j in range(columns):
            c = carrier[i, j]
            made[i, j] = complex(c.real * real[j] + c.imag * imaginary[j], c.real * imaginary[j] - c.imag * real[j])


Amplitudes = Sequence[NDArray[np.complex64]]

_WIDTH, _FINER = 5, 1.35  # grid points under a kernel, and of the grid for each wave: values are right to 3e-4
_LEFT = 1e-2  # of the sea's standard deviation, by the first term in time that is left out
_MOST_TERMS = 40
_TABLE = 4096  # steps to the greatest argument of Bessel's functions: between them lines are right to 1e-5 and better
_FEW = 100  # places, up to which sums are faster written out


class _Kernel(NamedTuple):
    """row, column (member,): of the first grid point under a place's kernel; across, along (member, _WIDTH): of it."""

    row: NDArray[np.int32]
    column: NDArray[np.int32]
    across: NDArray[np.float32]
    along: NDArray[np.float32]


@dataclass(frozen=True)
class _Grid:
    """From a lattice's waves to places (member,) off it, and back: see the module. phase (column,): of the middle."""

    size: int  # grid points to the lattice's period
    shape: tuple[int, int]  # rows and columns of them about the places
    phase: Waves
    kernel: _Kernel

    @classmethod
    def of(cls, lattice: Lattice, x: Field, y: Field) -> tuple[_Grid, NDArray[np.complex128]]:
        """The grid, and what the waves' carriers (n, n) are multiplied by. Places lie within the waves' period."""
        side = lattice.k.shape[0]
        mode = np.arange(side) - side // 2
        turns = np.stack((x, y)) * (lattice.spacing / (2.0 * np.pi))
        spare = 1.0 - float(np.ptp(turns, axis=1).max())
        if not spare > 0.0:
            raise ValueError("observations lie farther apart than the waves' period")
        least = int(np.ceil(max(_FINER * side, (_WIDTH + 1) / spare)))
        size = int(fft.next_fast_len(least) or least)
        sharp = np.pi * np.sqrt((_WIDTH * (1.0 - 0.5 * side / size)) ** 2 - 0.8)
        root = np.sqrt(sharp**2 - (np.pi * _WIDTH / size * mode) ** 2)
        corner = np.floor(turns.min(axis=1) * size) - 0.5 * _WIDTH
        at = turns * size - corner[:, None]
        first = np.ceil(at - 0.5 * _WIDTH)
        off = first[..., None] + np.arange(_WIDTH) - at[..., None]
        kernel = i0(sharp * np.sqrt(np.maximum(1.0 - (2.0 / _WIDTH * off) ** 2, 0.0))).astype(np.float32)
        rows, columns = (int(each) + _WIDTH for each in first.max(axis=1))
        phase = np.exp(-2j * np.pi / size * (side // 2) * np.arange(columns)).astype(np.complex64)
        east, north = root / (_WIDTH * np.sinh(root)) * np.exp(2j * np.pi / size * np.outer(corner, mode))
        return cls(size, (rows, columns), phase, _Kernel(*first.astype(np.int32), *kernel)), np.outer(east, north)

    def values(self, pairs: Waves, times: Waves) -> NDArray[np.float32]:
        """Sums (member,) of the fields of pairs (pair, n, n), by times (pair, member)."""
        middle, columns = pairs.shape[1] // 2, self.shape[1]
        lines = np.asarray(fft.ifft(pairs, self.size, axis=2, norm="forward"))[:, :, :columns]
        grid = np.zeros((pairs.shape[0], self.size, columns), np.complex64)
        np.multiply(lines[:, middle:], self.phase, out=grid[:, : middle + 1])
        np.multiply(lines[:, :middle], self.phase, out=grid[:, self.size - middle :])
        grid = np.asarray(fft.ifft(grid, axis=1, norm="forward", overwrite_x=True))
        made = np.empty(times.shape[1], np.float32)
        _gather(_parts(grid), self.kernel, _parts(times), made)
        return made

    def pairs(self, values: NDArray[np.float32], times: Waves, side: int) -> Waves:
        """The adjoint: pairs (pair, n, n and more columns)."""
        middle = side // 2
        grid = np.zeros((times.shape[0], *self.shape), np.complex64)
        _scatter(_parts(grid), self.kernel, _parts(times), values)
        lines = np.asarray(fft.fft(grid, self.size, axis=1))
        turned = np.empty((times.shape[0], side, self.shape[1]), np.complex64)
        np.multiply(lines[:, : middle + 1], self.phase.conj(), out=turned[:, middle:])
        np.multiply(lines[:, self.size - middle :], self.phase.conj(), out=turned[:, :middle])
        return np.asarray(fft.fft(turned, self.size, axis=2))


def _parts(waves: Waves) -> NDArray[np.float32]:
    """Real and imaginary parts (…, 2 n) beside each other."""
    return waves.view(np.float32)


@compiled
def _gather(grid: NDArray[np.float32], kernel: _Kernel, times: NDArray[np.float32], made: NDArray[np.float32]) -> None:
    row, column, across, along = kernel
    part = np.empty(2 * _WIDTH, np.float32)
    for place in range(row.size):
        first, total = 2 * column[place], np.float32(0.0)
        for pair in range(grid.shape[0]):
            for b in range(_WIDTH):
                part[2 * b] = along[place, b] * times[pair, 2 * place]
                part[2 * b + 1] = along[place, b] * times[pair, 2 * place + 1]
            for a in range(_WIDTH):
                line = grid[pair, row[place] + a, first : first + 2 * _WIDTH]
                share = np.float32(0.0)
                for c in range(2 * _WIDTH):
                    share += part[c] * line[c]
                total += across[place, a] * share
        made[place] = total


@compiled
def _scatter(
    grid: NDArray[np.float32], kernel: _Kernel, times: NDArray[np.float32], values: NDArray[np.float32]
) -> None:
    row, column, across, along = kernel
    for place in range(row.size):
        first = 2 * column[place]
        for pair in range(grid.shape[0]):
            even, odd = values[place] * times[pair, 2 * place], values[place] * times[pair, 2 * place + 1]
            for a in range(_WIDTH):
                line = grid[pair, row[place] + a, first : first + 2 * _WIDTH]
                for b in range(_WIDTH):
                    weight = across[place, a] * along[place, b]
                    line[2 * b] += weight * even
                    line[2 * b + 1] += weight * odd


@dataclass(frozen=True)
class _Part:
    """One lattice's waves at some of the batch's places."""

    lattice: int
    members: NDArray[np.intp]
    terms: Terms
    times: NDArray[np.complex64]  # (pair, member): T_m(τ) of the even term, and of the odd one as imaginary part
    grid: _Grid
    placed: Terms  # with carriers of waves on the grid

    def values(self, amplitudes: NDArray[np.complex64]) -> NDArray[np.float32]:
        return self.grid.values(self.placed.pairs(amplitudes), self.times)

    def amplitudes(self, values: NDArray[np.float32]) -> NDArray[np.complex64]:
        return self.placed.amplitudes(self.grid.pairs(values, self.times, self.terms.carrier.shape[0]))


@dataclass(frozen=True)
class _PlaceSum:
    """One lattice's waves at a few places: each wave's share written out."""

    lattice: int
    members: NDArray[np.intp]
    carried: NDArray[np.bool_]
    shares: NDArray[np.complex64]  # (member, carried wave)

    def values(self, amplitudes: NDArray[np.complex64]) -> NDArray[np.float32]:
        return (self.shares @ amplitudes[self.carried]).real

    def amplitudes(self, values: NDArray[np.float32]) -> NDArray[np.complex64]:
        total = np.zeros(self.carried.shape, np.complex64)
        total[self.carried] = (values @ self.shares).conj()
        return total


class WaveSum:
    """Values (n,) of observations by amplitudes of the lattices' waves, and the adjoint of that.

    weight (n,): of each observation. blur (n, 3): m², of the areas that values are the mean over, as they count in the
    sums: near the centre [m], and far from it, the mean of those there, and each its own where places are few.
    """

    def __init__(
        self,
        seen: Observations,
        lattices: Sequence[Lattice],
        water: Water,
        weight: Field,
        centre: tuple[float, float],
    ) -> None:
        self.size = len(seen)
        self._seen, self._lattices, self.water = seen, lattices, water
        first, last = (float(seen.time.min()), float(seen.time.max())) if self.size else (0.0, 0.0)
        self._time, self._half = 0.5 * (first + last), max(0.5 * (last - first), 1e-3)
        self.blur = seen.blur
        self._parts: list[_Part | _PlaceSum] = []
        near = min(lattice.radius for lattice in lattices)
        close = np.hypot(seen.x - centre[0], seen.y - centre[1]) < near
        for kind in np.unique(seen.kind):
            for ring in (True, False):
                members = np.flatnonzero((seen.kind == kind) & (close == ring))
                if not members.size:
                    continue
                blur = np.average(self.blur[members], axis=0, weights=weight[members])
                if members.size > _FEW:
                    self.blur[members] = blur
                for number, lattice in enumerate(lattices):
                    if not (ring or not np.isfinite(near) or lattice.radius > near):
                        continue
                    if members.size <= _FEW:
                        self._parts.append(self._place_sum(number, members, seen.x, seen.y))
                    else:
                        terms = self._terms(lattice, lattice.factor(str(kind), water), blur)
                        self._parts.append(self._part(number, members, terms, seen.x, seen.y))

    def moved(self, x: Field, y: Field) -> WaveSum:
        """The same observations of waves that are at other places, m: where the water is at home."""
        made = copy(self)
        made._parts = [
            self._place_sum(part.lattice, part.members, x, y)
            if isinstance(part, _PlaceSum)
            else self._part(part.lattice, part.members, part.terms, x, y)
            for part in self._parts
        ]
        return made

    def _place_sum(self, number: int, members: NDArray[np.intp], x: Field, y: Field) -> _PlaceSum:
        lattice, seen = self._lattices[number], self._seen[members]
        factor = lattice.factor(str(seen.kind[0]), self.water)
        shares = self._shares(lattice, factor, seen, x[members], y[members])
        return _PlaceSum(number, members, lattice.scale > 0.0, shares)

    def _shares(
        self, lattice: Lattice, factor: NDArray[np.complex128], seen: Observations, x: Field, y: Field
    ) -> NDArray[np.complex64]:
        kx, ky, omega = (each[lattice.scale > 0.0] for each in (lattice.kx, lattice.ky, lattice.omega))
        waves = phasors(kx, ky, omega, x, y, seen.time)
        return (factor[lattice.scale > 0.0] * waves * damped(seen.blur[:, None], kx, ky)).astype(np.complex64)

    def _terms(self, lattice: Lattice, factor: NDArray[np.complex128], blur: Field) -> Terms:
        swing = lattice.omega * self._half
        carrier = factor * np.exp(-1j * lattice.omega * self._time) * damped(blur, lattice.kx, lattice.ky)
        power = lattice.scale**2
        shares = [_bessel(0, swing)]
        following = 2.0 * _bessel(1, swing)
        while len(shares) % 2 or np.sum(power * following**2) > _LEFT**2 * power.sum():
            shares.append(following)
            if len(shares) >= _MOST_TERMS:
                raise ValueError(f"observations over {2.0 * self._half:g} s in one batch: split them in time")
            following = 2.0 * _bessel(len(shares), swing)
        return Terms.of(carrier, shares)

    def _part(
        self,
        number: int,
        members: NDArray[np.intp],
        terms: Terms,
        x: Field,
        y: Field,
    ) -> _Part:
        lattice = self._lattices[number]
        tau = np.clip((self._seen.time[members] - self._time) / self._half, -1.0, 1.0)
        chebyshev = np.cos(np.arange(2 * terms.count)[:, None] * np.arccos(tau))
        times = (chebyshev[0::2] + 1j * chebyshev[1::2]).astype(np.complex64)
        grid, carrier = _Grid.of(lattice, x[members], y[members])
        placed = replace(terms, carrier=(terms.carrier * carrier).astype(np.complex64))
        return _Part(number, members, terms, times, grid, placed)

    def places(self, lattice: int) -> NDArray[np.intp]:
        """Places of the observations that a lattice's waves are summed at."""
        return np.concatenate([np.empty(0, np.intp)] + [p.members for p in self._parts if p.lattice == lattice])

    def values(self, amplitudes: Amplitudes) -> NDArray[np.float32]:
        """Values of each observation (n,), by amplitudes [m] of each lattice (n, n)."""
        total = np.zeros(self.size, np.float32)
        for part in self._parts:
            total[part.members] += part.values(amplitudes[part.lattice])
        return total

    def amplitudes(self, values: NDArray[np.float32]) -> list[NDArray[np.complex64]]:
        """The adjoint: of values (n,) to amplitudes of each lattice."""
        total = [np.zeros(lattice.k.shape, np.complex64) for lattice in self._lattices]
        for part in self._parts:
            total[part.lattice] += part.amplitudes(values[part.members])
        return total


def _bessel(order: int, argument: Field) -> Field:
    """J of many arguments, by a table."""
    table = np.linspace(float(argument.min()), float(argument.max()), _TABLE)
    return np.interp(argument.ravel(), table, jv(order, table)).reshape(argument.shape)
