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
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass
from functools import cached_property

import numpy as np

from .basin import Band, Points, Waves, fast_size, widened

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

    @property
    def transforms(self) -> int:
        """FFTs over `points` that one call takes."""
        order = self.order
        return 0 if order == 1 else 5 + order * (order + 1) // 2 - 1 + (order - 1) + 2

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
