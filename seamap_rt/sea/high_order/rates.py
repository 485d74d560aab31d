"""How fast the surface and its potential change beyond linear waves, to an order M in the steepness.

The water under the surface η(x, t) has a potential, φs(x, t) at the surface, and (Zakharov 1968)

    ∂η/∂t  =            − ∇φs·∇η + W (1 + |∇η|²)
    ∂φs/∂t = − r η − ½ |∇φs|² + ½ W² (1 + |∇η|²),        r = g + (T/ρ) k²

with W its vertical velocity there. W is expanded about the mean level (Dommermuth & Yue 1987; West et al. 1987),

    φ = Σ φ^(m),  φ^(1) = φs,  φ^(m) = − Σ η^n/n! ∂ⁿφ^(m−n)/∂zⁿ,  n = 1 … m − 1,
    W = Σ W^(m),               W^(m) = Σ η^n/n! ∂ⁿ⁺¹φ^(m−n)/∂zⁿ⁺¹, n = 0 … m − 1,  all at z = 0.

Products are kept up to order M, each by the order of its factors (West et al. 1987): the rates are then those of an
energy of order M + 1, exactly, and conserve it. Surface tension is in the linear part alone: of waves of 1.6 m it is
1e-4.

Products are taken on so many points that none of order M falls back onto the waves (de-aliased); a field inside a
product is kept as far as what is multiplied with it later can bring it back.

A field is held as `waves` on a `Band`: complex amplitudes c of c exp(i(kx x + ky y)), rows ky in the order of an FFT
(0 … m, −m … −1), columns kx from 0 to m; those of −kx are their conjugates. Products of fields reach farther than the
fields: a wider band holds them. One row, or one column, is a long-crested sea.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass
from functools import cached_property, lru_cache

import numpy as np
import scipy.fft
from numpy.typing import NDArray

from ...compute.machine import threads
from ...conventions import GRAVITY, SURFACE_TENSION, WATER_DENSITY

Waves = NDArray[np.complex128]
Points = NDArray[np.float64]

_WORTH_THREADS = 1 << 15  # points: below, starting threads takes longer than it saves


@dataclass(frozen=True)
class Band:
    """Wave numbers 2π (i/length_x, j/length_y) with |i| ≤ most_x and |j| ≤ most_y, over water of some depth [m]."""

    length_x: float
    length_y: float
    most_x: int
    most_y: int
    depth: float

    @property
    def shape(self) -> tuple[int, int]:
        """Shape of an array of waves."""
        return 2 * self.most_y + 1, self.most_x + 1

    @cached_property
    def east(self) -> NDArray[np.float64]:
        """kx (1, column) rad/m."""
        return 2.0 * np.pi / self.length_x * np.arange(self.most_x + 1.0)[None, :]

    @cached_property
    def north(self) -> NDArray[np.float64]:
        """ky (row, 1) rad/m."""
        rows = np.concatenate((np.arange(self.most_y + 1.0), np.arange(-self.most_y, 0.0)))
        return 2.0 * np.pi / self.length_y * rows[:, None]

    @cached_property
    def square(self) -> NDArray[np.float64]:
        """|k|²: ∂²/∂z² of what obeys Laplace's equation."""
        return self.east**2 + self.north**2

    @cached_property
    def rise(self) -> NDArray[np.float64]:
        """k tanh kh: ∂/∂z at the mean level of a potential of 1 there, no water passing the bed."""
        k = np.sqrt(self.square)
        return k if np.isinf(self.depth) else k * np.tanh(k * self.depth)

    @cached_property
    def restoring(self) -> NDArray[np.float64]:
        """g + (T/ρ) k²: pressure over density that an elevation of 1 m has under it."""
        return GRAVITY + SURFACE_TENSION / WATER_DENSITY * self.square

    @cached_property
    def omega(self) -> NDArray[np.float64]:
        """Angular frequency of the linear waves, rad/s."""
        return np.sqrt(self.restoring * self.rise)

    def mean_product(self, one: Waves, other: Waves) -> float:
        """Mean over the rectangle of the product of two fields."""
        products = np.real(np.conj(one) * other)
        return float(2.0 * products.sum() - products[:, 0].sum())

    def to_points(self, waves: Waves, shape: tuple[int, int]) -> Points:
        """The field on rows × columns even points from the origin on; as many at least as the band has waves."""
        rows, columns = shape
        workers = _workers(rows * columns)
        if self.most_y:
            tall = np.zeros((rows, waves.shape[1]), dtype=np.complex128)
            tall[: self.most_y + 1] = waves[: self.most_y + 1]
            tall[rows - self.most_y :] = waves[self.most_y + 1 :]
            waves = np.asarray(scipy.fft.ifft(tall, axis=0, norm="forward", overwrite_x=True, workers=workers))
        elif rows > 1:
            waves = np.repeat(waves, rows, axis=0)
        return np.asarray(scipy.fft.irfft(waves, n=columns, axis=1, norm="forward", workers=workers))

    def to_waves(self, points: Points) -> Waves:
        """The waves of a field on even points; what is beyond the band goes."""
        workers = _workers(points.size)
        waves = np.asarray(scipy.fft.rfft(points, axis=1, norm="forward", workers=workers))[:, : self.most_x + 1]
        if points.shape[0] > 1:
            waves = np.asarray(scipy.fft.fft(waves, axis=0, norm="forward", workers=workers))
        if not self.most_y:
            return waves[:1].copy()
        return np.concatenate((waves[: self.most_y + 1], waves[-self.most_y :]))


@lru_cache(maxsize=32)
def widened(band: Band, reach: tuple[int, int]) -> Band:
    """The same water with waves up to i, j = reach."""
    return Band(band.length_x, band.length_y, *reach, band.depth)


def fast_size(least: int) -> int:
    """The number of points, at least so many, that an FFT takes fast; 1 stays 1."""
    return int(scipy.fft.next_fast_len(least, real=True)) if least > 1 else 1  # type: ignore[arg-type]


def _workers(points: int) -> int:
    return threads() if points >= _WORTH_THREADS else 1


HIGHEST_ORDER = 5


@dataclass(frozen=True)
class Rates:
    """The nonlinear rates of waves on a band, to the order M = 1 (none) … 5."""

    band: Band
    order: int

    @cached_property
    def points(self) -> tuple[int, int]:
        """Rows and columns on which a product of M fields leaves the band's own waves as they are."""
        return (
            fast_size((self.order + 1) * self.band.most_y + 1),
            fast_size((self.order + 1) * self.band.most_x + 1),
        )

    def __call__(self, elevation: Waves, potential: Waves) -> tuple[Waves, Waves]:
        """What is added to the linear ∂η/∂t [m/s] and ∂φs/∂t [m²/s²], as waves."""
        if self.order == 1:
            return np.zeros_like(elevation), np.zeros_like(potential)
        rise, highest = self._vertical_velocity(elevation, potential)
        slope_flow, steep, flow = self._products(elevation, potential)

        elevation_rate = sum(rise[2:], start=-slope_flow)
        if self.order > 2:
            elevation_rate += steep * sum(rise[2 : self.order - 1], start=rise[1])
        potential_rate = _squares(rise, self.order) - flow
        if self.order > 3:
            potential_rate += steep * _squares(rise, self.order - 2)
        potential_rate *= 0.5
        rates = self.band.to_waves(elevation_rate) + highest, self.band.to_waves(potential_rate)
        for rate in rates:
            rate[0, 0] = 0.0  # water is kept; the mean of a potential moves nothing
        return rates

    def vertical_velocity(self, elevation: Waves, potential: Waves) -> Waves:
        """W = Σ W^(m), m = 1 … M, of the water at the surface, m/s; of M > 1."""
        rise, highest = self._vertical_velocity(elevation, potential)
        return self.band.to_waves(sum(rise[2:], start=rise[1])) + highest

    def _products(self, elevation: Waves, potential: Waves) -> tuple[Points, Points, Points]:
        """∇φs·∇η, |∇η|² and |∇φs|² on the points."""
        slopes, flows = (
            [self.band.to_points(1j * k * waves, self.points) for k in (self.band.east, self.band.north)]
            for waves in (elevation, potential)
        )
        return (
            slopes[0] * flows[0] + slopes[1] * flows[1],
            slopes[0] ** 2 + slopes[1] ** 2,
            flows[0] ** 2 + flows[1] ** 2,
        )

    def _vertical_velocity(self, elevation: Waves, potential: Waves) -> tuple[list[Points], Waves]:
        """W^(m) on the points, m = 1 … M (index 0 is unused), and apart from W^(M) its ∂φ^(M)/∂z, as waves."""
        powers = [np.ones(1), self.band.to_points(elevation, self.points)]
        for n in range(2, self.order):
            powers.append(powers[-1] * powers[1] / n)
        rise, below = [powers[0]], [powers[0], powers[0]]  # of indices that are not used
        band, waves = self.band, potential
        for m in range(1, self.order):
            for n, derivative in enumerate(self._derivatives(band, waves, self.order - m + 1), start=1):
                _add(rise, m + n - 1, powers[n - 1] * derivative if n > 1 else derivative)
                if m + n <= self.order:
                    _add(below, m + n, powers[n] * derivative)
            band = self._band(m + 1)
            waves = -band.to_waves(below[m + 1])
        return rise, band.rise * waves

    def _derivatives(self, band: Band, waves: Waves, count: int) -> Iterator[Points]:
        """∂φ/∂z, ∂²φ/∂z² … at the mean level, on the points."""
        odd, even = band.rise * waves, waves
        for n in range(1, count + 1):
            if n % 2:
                yield band.to_points(odd, self.points)
                odd = odd * band.square
            else:
                even = even * band.square
                yield band.to_points(even, self.points)

    def _band(self, m: int) -> Band:
        """How far φ^(m) is kept: it reaches m times the waves, and M − m factors may bring it back."""
        times = min(m, self.order - m + 1)
        rows, columns = self.points
        reach = min(times * self.band.most_x, (columns - 1) // 2), min(times * self.band.most_y, (rows - 1) // 2)
        return widened(self.band, reach)


def _add(fields: list[Points], number: int, added: Points) -> None:
    """Add to a field of the list, or begin it: large fields that are made anew cost as much as an FFT."""
    if number == len(fields):
        fields.append(added)
    else:
        fields[number] += added


def _squares(rise: list[Points], order: int) -> Points:
    """W² up to an order: Σ W^(m) W^(n), m + n ≤ order."""
    total = rise[1] * sum(rise[2:order], start=rise[1])
    for m in range(2, order):
        total += rise[m] * sum(rise[2 : order - m + 1], start=rise[1])
    return total
