"""A directional spectrum on the wavenumbers of a periodic plane (or line), and random amplitudes drawn from it.

The plane of side L carries the wave vectors (2π/L)(i, j) shorter than a limit, the same in all directions. The variance
of a system's waves below that limit is put on them exactly, so neither the side nor the number of points changes it.
Arrays are (row j, column i), from −m to m on each axis. A line is a lattice of one row.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from functools import cached_property

import numpy as np
from numpy.typing import NDArray

from ..compute.quadrature import gauss_legendre
from ..physics.dispersion import angular_frequency

Radial = Callable[[NDArray[np.float64]], NDArray[np.float64]]
"""S(k) [m³], with ∫ S dk the variance."""
Spreading = Callable[[NDArray[np.float64], NDArray[np.float64], NDArray[np.float64]], NDArray[np.float64]]
"""Density over angle [1/rad] of k [rad/m], cos θ and sin θ, θ anticlockwise from the mean direction of travel."""

LINE_REPEATS = 4.0  # repeat length of a long-crested system, in sides of the plane
_FINE_RADIUS = 64  # wavenumber steps within which cells are integrated, not sampled: swell can be that narrow
_FINE_NODES = 6  # Gauss–Legendre nodes per side of such a cell


@dataclass(frozen=True)
class Lattice:
    """The wave vectors of a periodic plane of side `length` [m] with |k| < `limit` [rad/m]; `line` keeps one row."""

    length: float
    limit: float
    depth: float
    line: bool = False

    @property
    def step(self) -> float:
        """Spacing of the wavenumbers (rad/m)."""
        return 2.0 * np.pi / self.length

    @property
    def reach(self) -> tuple[int, int]:
        """The largest index m of rows and of columns."""
        most = int(np.ceil(self.limit / self.step - 1e-9)) - 1
        return (0 if self.line else most), most

    @cached_property
    def north(self) -> NDArray[np.float64]:
        """ky of the rows (rad/m)."""
        return self.step * np.arange(-self.reach[0], self.reach[0] + 1.0)

    @cached_property
    def east(self) -> NDArray[np.float64]:
        """kx of the columns (rad/m)."""
        return self.step * np.arange(-self.reach[1], self.reach[1] + 1.0)

    def quadrant(self, function: Callable[[NDArray[np.float64]], NDArray[np.float64]]) -> NDArray[np.float64]:
        """A function of |k| on the quadrant of indices ≥ 0, (m + 1, m + 1): all that an isotropic function needs."""
        rows, columns = self.reach
        return function(np.hypot(self.north[rows:, None], self.east[None, columns:]))

    @cached_property
    def omega(self) -> NDArray[np.float64]:
        """Angular frequency on the quadrant (rad/s)."""
        return self.quadrant(lambda k: angular_frequency(k, self.depth))

    def unfold(self, quadrant: NDArray) -> NDArray:
        """Unfold values from the quadrant to the whole lattice."""
        rows, columns = (np.abs(np.arange(-most, most + 1)) for most in self.reach)
        return quadrant[np.ix_(rows, columns)]

    def fold(self, whole: NDArray) -> NDArray:
        """Sums over the waves of like |i| and |j|, onto the quadrant."""
        rows, columns = self.reach
        half = whole[rows:].copy()
        half[1:] += whole[:rows][::-1]
        quadrant = half[:, columns:].copy()
        quadrant[:, 1:] += half[:, :columns][:, ::-1]
        return quadrant

    @cached_property
    def is_inside(self) -> NDArray[np.bool_]:
        """Where a wave may be: 0 < |k| < limit."""
        k = self.quadrant(lambda k: k)
        return self.unfold((k > 0.0) & (k < self.limit))


def plane_variance(
    lattice: Lattice, radial: Radial, spreading: Spreading, toward: tuple[float, float], total: float
) -> tuple[NDArray[np.float64], float]:
    """Expected variance of each wave of a plane [m²], adding up to `total`; and the share of it that was found there
    before it was scaled, 1 but for waves nearly as long as the plane.

    toward: unit vector east, north. Raises ValueError where the plane is too small to carry the waves at all.
    """
    k = lattice.quadrant(lambda k: k)
    safe = np.where(k > 0.0, k, 1.0)
    density = lattice.unfold(np.where(k > 0.0, radial(safe) / safe, 0.0))
    whole = lattice.unfold(safe)
    along, across = _angle(lattice.east, lattice.north[:, None], whole, toward)
    variance = density * spreading(whole, along, across) * lattice.step**2
    variance[_central_cells(lattice)] = _integrated(lattice, radial, spreading, toward)
    return _scaled(np.where(lattice.is_inside, variance, 0.0), total, lattice)


def line_variance(lattice: Lattice, radial: Radial, total: float) -> tuple[NDArray[np.float64], float]:
    """Expected variance of each wave of a line [m²], (1, column), all forward. As `plane_variance` otherwise."""
    nodes, weights = gauss_legendre(16)
    # Each wave stands for its cell; the last one's ends at the limit, where the variance that is put on them ends too.
    edges = np.clip(lattice.east[:, None] + 0.5 * lattice.step * np.array([-1.0, 1.0]), 0.0, lattice.limit)
    edges[-1, 1] = lattice.limit
    half = 0.5 * np.diff(edges, axis=1)
    variance = (radial(edges[:, :1] + half * (1.0 + nodes)) * half) @ weights
    return _scaled(np.where(lattice.east > 0.0, variance, 0.0)[None, :], total, lattice)


def draw_amplitudes(
    lattice: Lattice, variance: NDArray[np.float64], seed: np.random.SeedSequence
) -> NDArray[np.complex128]:
    """Complex Gaussian amplitudes a with ⟨|a|²⟩ = 2 × variance, for η = Re Σ a exp(i(k·x − ωt)).

    Drawn shell by shell outward, so that a finer resolution adds waves and keeps the random numbers of those it had.
    """
    order = _shell_order(lattice)
    drawn = np.random.default_rng(seed).standard_normal(2 * order.size).view(np.complex128)
    return np.sqrt(variance) * drawn[order]


def _central_cells(lattice: Lattice) -> tuple[slice, slice]:
    """The cells around k = 0 whose variance is integrated."""
    rows, columns = lattice.reach
    fine_rows, fine_columns = min(rows, _FINE_RADIUS), min(columns, _FINE_RADIUS)
    return slice(rows - fine_rows, rows + fine_rows + 1), slice(columns - fine_columns, columns + fine_columns + 1)


def _integrated(
    lattice: Lattice, radial: Radial, spreading: Spreading, toward: tuple[float, float]
) -> NDArray[np.float64]:
    """Integrals of the spectrum over the cells of `_central_cells`, by Gauss–Legendre nodes in each."""
    rows, columns = _central_cells(lattice)
    nodes, weights = gauss_legendre(_FINE_NODES)
    half = 0.5 * lattice.step
    total = np.zeros((rows.stop - rows.start, columns.stop - columns.start))
    for node_north, weight_north in zip(nodes, weights, strict=True):
        for node_east, weight_east in zip(nodes, weights, strict=True):
            north = lattice.north[rows, None] + half * node_north
            east = lattice.east[None, columns] + half * node_east
            k = np.hypot(north, east)
            spread = radial(k) / k * spreading(k, *_angle(east, north, k, toward))
            total += half**2 * weight_north * weight_east * spread
    return total


def _angle(
    east: NDArray[np.float64], north: NDArray[np.float64], k: NDArray[np.float64], toward: tuple[float, float]
) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
    """Cosine and sine of the angle, anticlockwise, from `toward` to the wave vectors."""
    return (toward[0] * east + toward[1] * north) / k, (toward[0] * north - toward[1] * east) / k


def _scaled(variance: NDArray[np.float64], total: float, lattice: Lattice) -> tuple[NDArray[np.float64], float]:
    """Scale the sum to the integral. The rule of sums is off by a little where a spectrum is narrow."""
    carried = float(variance.sum())
    if total <= 0.0:
        return np.zeros_like(variance), 1.0
    if carried < 0.5 * total:
        extent = lattice.length / (LINE_REPEATS if lattice.line else 1.0)
        raise ValueError(
            f"extent_m = {extent:.10g}: carries {carried / total:.0%} of this wave system's variance, must carry at "
            "least 50%; raise extent_m or shorten the waves"
        )
    return variance * (total / carried), carried / total


def _shell_order(lattice: Lattice) -> NDArray[np.int64]:
    """Place of each wave in the drawing order: square shells max(|i|, |j|) = s outward from 0, one after the other."""
    rows, columns = lattice.reach
    if lattice.line:  # forward waves by length, then the backward ones that a line never uses
        i = np.arange(-columns, columns + 1)
        return np.where(i >= 0, i, columns - i)[None, :]
    j = np.arange(-rows, rows + 1)[:, None]
    i = np.arange(-columns, columns + 1)[None, :]
    shell = np.maximum(np.abs(i), np.abs(j))
    on_rows = (j > 0) * (2 * shell + 1) + i + shell
    on_columns = 2 * (2 * shell + 1) + (i > 0) * (2 * shell - 1) + j + shell - 1
    rank = (2 * shell - 1) ** 2 + np.where(np.abs(j) == shell, on_rows, on_columns)
    return np.where(shell == 0, 0, rank)
