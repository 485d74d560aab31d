"""A directional spectrum given as a table, measured or modelled, as the functions from which a sea is realised."""

from __future__ import annotations

import math
from dataclasses import dataclass
from functools import cached_property

import numpy as np
from numpy.typing import NDArray

from ..physics.dispersion import angular_frequency
from .spectra import wavenumber_spectrum

_OPEN = 2.5  # times the usual spacing: a gap between directions that the table leaves open, not a missing value


@dataclass(frozen=True, eq=False)
class TabulatedSpectrum:
    """E(f, θ), linear in frequency and in direction between the values of a table.

    frequency_hz: (f,) positive and ascending, at any spacing; from_deg: (d,) azimuths that waves come from, in any
    order, none twice; density: (f, d), m²/(Hz·degree), ≥ 0. depth: of the water [m], inf for deep. tail_exponent n > 1:
    above the last frequency fm the last row goes on as (fm/f)^n, n = 5 being Phillips' (1958) and 4 Toba's (1973);
    0 or None: nothing is there. Below the first frequency, and beside directions that fill only a sector, the density
    falls to 0 within one step. Raises ValueError for a table that is none.
    """

    frequency_hz: NDArray[np.float64]
    from_deg: NDArray[np.float64]
    density: NDArray[np.float64]
    depth: float = math.inf
    tail_exponent: float | None = 5.0

    def __post_init__(self) -> None:
        for name in ("frequency_hz", "from_deg", "density"):
            object.__setattr__(self, name, np.asarray(getattr(self, name), dtype=np.float64))
        _check(self)

    def radial(self, k: NDArray[np.float64]) -> NDArray[np.float64]:
        """S(k) = S(ω) dω/dk [m³] of wavenumbers k [rad/m] of any shape; ∫ S dk is the variance."""
        return wavenumber_spectrum(lambda omega: self._energy_at(omega / (2.0 * np.pi)) / (2.0 * np.pi), k, self.depth)

    def spreading(
        self, k: NDArray[np.float64], along: NDArray[np.float64], across: NDArray[np.float64]
    ) -> NDArray[np.float64]:
        """D [1/rad] of wavenumbers k [rad/m] that go to φ: along = cos φ, across = sin φ, φ counted from east to north.

        The arguments broadcast. ∫ D dφ = 1 at each k; it is an even circle where the sea has no wave of that length.
        """
        row, up = _bracket(angular_frequency(k, self.depth) / (2.0 * np.pi), self._frequency)
        column, left = _bracket(np.arctan2(across, along), self._angle)
        table = self._table.ravel()
        corner = row * self._angle.size + column
        lower, upper = (table[at] + left * (table[at + 1] - table[at]) for at in (corner, corner + self._angle.size))
        energy = self._energy[row] + up * (self._energy[row + 1] - self._energy[row])
        density = lower + up * (upper - lower)
        return np.divide(density, energy, out=np.full(density.shape, 0.5 / np.pi), where=energy > 0.0)

    # ------------------------------------------------------------------------------------------------------- facts

    @property
    def hs(self) -> float:
        """Significant wave height 4 √m0 [m], tail included."""
        return 4.0 * math.sqrt(self._variance + self._tail_variance)

    @property
    def peak_frequency_hz(self) -> float:
        """The table's frequency [Hz] at which most energy is, over all directions."""
        return float(self._frequency[np.argmax(self._energy)])

    @cached_property
    def _variance(self) -> float:
        return float(np.trapezoid(self._energy, self._frequency))

    @property
    def _tail_variance(self) -> float:
        n = self.tail_exponent
        return float(self._energy[-1] * self._frequency[-1] / (n - 1.0)) if n else 0.0

    # ------------------------------------------------------------------------------------------------ interpolation

    def _energy_at(self, frequency: NDArray[np.float64]) -> NDArray[np.float64]:
        """E(f) [m²/Hz] over all directions, tail included."""
        last = self._frequency[-1]
        beyond = np.minimum(last / np.maximum(frequency, last), 1.0)
        tail = beyond**self.tail_exponent if self.tail_exponent else np.floor(beyond)
        return np.interp(frequency, self._frequency, self._energy, left=0.0) * tail

    @cached_property
    def _frequency(self) -> NDArray[np.float64]:
        """Nodes (Hz): those of the table after one where the density has fallen to 0."""
        first, second = self.frequency_hz[:2]
        return np.concatenate(([max(0.0, 2.0 * first - second)], self.frequency_hz))

    @cached_property
    def _circle(self) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
        """Angles of travel, ascending from before −π to after π [rad], and densities (f, angle) [m²/(Hz rad)].

        Where directions are left open, a zero stands one step beside each side of the sector.
        """
        angle = np.remainder(np.radians(270.0 - self.from_deg) + np.pi, 2.0 * np.pi) - np.pi
        order = np.argsort(angle)
        angle, density = angle[order], self.density[:, order] * (180.0 / np.pi)
        gap = np.diff(angle, append=angle[0] + 2.0 * np.pi)
        step = np.median(gap)
        after = np.flatnonzero(gap > _OPEN * step)
        edge = np.concatenate((angle[after] + step, angle[after] + gap[after] - step))
        angle = np.concatenate((angle, np.remainder(edge + np.pi, 2.0 * np.pi) - np.pi))
        density = np.concatenate((density, np.zeros((density.shape[0], edge.size))), axis=1)
        order = np.argsort(angle)
        angle, density = angle[order], density[:, order]
        turn = np.concatenate((angle[-1:] - 2.0 * np.pi, angle, angle[:1] + 2.0 * np.pi))
        return turn, np.concatenate((density[:, -1:], density, density[:, :1]), axis=1)

    @property
    def _angle(self) -> NDArray[np.float64]:
        return self._circle[0]

    @cached_property
    def _table(self) -> NDArray[np.float64]:
        """Densities on the nodes (frequency, angle) [m²/(Hz rad)]."""
        density = self._circle[1]
        return np.concatenate((np.zeros((1, density.shape[1])), density))

    @cached_property
    def _energy(self) -> NDArray[np.float64]:
        """E(f) [m²/Hz] on the frequency nodes, from one turn of the circle."""
        return np.asarray(np.trapezoid(self._table[:, :-1], self._angle[:-1], axis=1))


def _bracket(value: NDArray[np.float64], nodes: NDArray[np.float64]) -> tuple[NDArray[np.intp], NDArray[np.float64]]:
    """Index of the node below, and how far towards the next one, 0 to 1; values beyond the ends stay at the ends."""
    position = np.interp(value, nodes, np.arange(nodes.size, dtype=np.float64))
    index = np.minimum(position.astype(np.intp), nodes.size - 2)
    return index, position - index


def _check(table: TabulatedSpectrum) -> None:
    frequency, direction, density = table.frequency_hz, table.from_deg, table.density
    rising = frequency.ndim == 1 and frequency.size >= 2 and np.all(np.diff(frequency, prepend=0.0) > 0.0)
    if not (rising and np.isfinite(frequency[-1])):
        raise ValueError("frequency_hz: must be two or more positive numbers in ascending order; sort the table")
    if not (direction.ndim == 1 and direction.size >= 3 and np.all(np.isfinite(direction))):
        raise ValueError("from_deg: must be three or more angles in degrees; a sea from one direction is long-crested")
    azimuth = np.sort(direction % 360.0)
    if np.min(np.diff(azimuth, append=azimuth[0] + 360.0)) < 1e-6:
        raise ValueError("from_deg: must name each direction once; drop the one that is there twice, such as 360 of 0")
    if density.shape != (frequency.size, direction.size):
        raise ValueError(
            f"density of shape {density.shape}: must be {(frequency.size, direction.size)}, frequencies by directions; "
            "transpose it"
        )
    if not (np.all(density >= 0.0) and np.all(np.isfinite(density))):
        raise ValueError("density: must be finite and not negative; replace missing values by 0")
    if not table.depth > 0.0:
        raise ValueError(f"depth = {table.depth}: must be positive, in metres; inf is deep water")
    if table.tail_exponent and not table.tail_exponent > 1.0:
        raise ValueError(
            f"tail_exponent = {table.tail_exponent}: must be above 1, or the tail holds more than any sea; 5 is usual"
        )
