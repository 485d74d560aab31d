"""The sea's expected directional spectrum, from maps alone: what is taken of waves before their phases are known."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from functools import cached_property

import numpy as np
from numpy.typing import ArrayLike, NDArray
from scipy.ndimage import gaussian_filter1d, map_coordinates

from ..physics.amplitude_dispersion import DEEP_ENOUGH, sea_shift
from ..physics.dispersion import DEEP_WATER, Water
from ..wavefield.sea_state import TurnSpectrum
from ..wavefield.wave_systems import WaveSystems

Field = NDArray[np.float64]

_LONGEST_M, _SHORTEST_M = 600.0, 0.5
_RINGS, _DIRECTIONS = 96, 36
_WIDTH_DEG = 12.0  # that directions are smoothed by: what a few turns of some hundred metres tell of them
_WIDTH_RINGS = 1.5
_ALL_ROUND = 0.03  # of each ring's variance, from all sides: waves that a map's own spectrum cannot exclude
_TAIL_FROM = 2.0  # times the peak's wavenumber: shorter waves hold at least what a wind sea's do
_TOLD = 0.6  # of waves' variance, that cells hold: of shorter ones what is put back is noise's as well
_STANDS_OUT, _STRONG = 1.25, 0.15  # over the valley beside it, and of the greatest: the peak of waves of their own


@dataclass(frozen=True)
class Spectrum:
    """Variance density by wavevector on rings of k (ring,) [rad/m], evenly spaced in its logarithm, and directions
    (direction,) [rad] that waves run to, even over the circle: density (ring, direction) [m⁴].

    amplitude_dispersion: the share of what this sea's own amplitudes add to the waves' frequencies that they run by.
    """

    k: Field
    toward: Field
    table: Field
    water: Water = DEEP_WATER
    amplitude_dispersion: float = 0.0

    @classmethod
    def even(cls, water: Water = DEEP_WATER) -> tuple[Field, Field]:
        """The rings [rad/m] and directions [rad] of a table."""
        k = np.geomspace(2.0 * np.pi / _LONGEST_M, 2.0 * np.pi / _SHORTEST_M, _RINGS)
        return k, 2.0 * np.pi * np.arange(_DIRECTIONS) / _DIRECTIONS

    @classmethod
    def of_frequency(
        cls, omega: ArrayLike, variance: ArrayLike, wave_from_deg: float, exponent: float, water: Water = DEEP_WATER
    ) -> Spectrum:
        """From a frequency spectrum variance(omega) [m² s/rad] and spreading cos^2s(θ/2) of one mean direction."""
        k, toward = cls.even()
        sigma = water.frequency(k)
        line = np.interp(sigma, np.asarray(omega, float), np.asarray(variance, float), left=0.0, right=0.0)
        spread = np.abs(np.cos(0.5 * (toward - np.radians(wave_from_deg + 180.0)))) ** (2.0 * exponent)
        spread /= spread.mean() * 2.0 * np.pi
        ring = line * water.group_speed(k) / k
        return cls(k, toward, ring[:, None] * spread, water)

    @property
    def areas(self) -> Field:
        """rad²/m² of wavevectors that each entry of the table stands for, (ring, direction)."""
        step = np.log(self.k[1] / self.k[0])
        return np.ones_like(self.table) * (self.k**2 * step)[:, None] * (2.0 * np.pi / self.toward.size)

    @property
    def variances(self) -> Field:
        """m² of each entry of the table, (ring, direction)."""
        return self.table * self.areas

    @property
    def variance(self) -> float:
        """m², of the whole sea."""
        return float(self.variances.sum())

    @property
    def peak_period(self) -> float:
        """s, of the ring whose waves hold most in their frequency's logarithm."""
        return 2.0 * np.pi / float(self.water.frequency(self.k[np.argmax(self.variances.sum(axis=1))]))

    def wavenumber_above(self, share: float) -> float:
        """rad/m: shorter waves hold this share of the variance."""
        above = np.cumsum(self.variances.sum(axis=1)[::-1])[::-1] / max(self.variance, 1e-300)
        return float(self.k[np.flatnonzero(above > share)[-1]])

    def density(self, kx: Field, ky: Field) -> Field:
        """m⁴ at wavevectors east and north [rad/m]; 0 beyond the rings."""
        return self._at(self.table, kx, ky)

    def amplitude_shift(self, kx: Field, ky: Field) -> Field:
        """rad/s that this sea's amplitudes add to the frequencies of waves of some wavevectors [rad/m] in all; 0 where
        the water is not deep (`physics.amplitude_dispersion`), and beyond the rings."""
        return self._at(self._shift, kx, ky)

    def omega(self, kx: Field, ky: Field, k: Field) -> Field:
        """rad/s over ground of waves of some wavevectors east and north, and their length, above 0 [rad/m]."""
        shift = self.water.doppler_shift(kx, ky)
        if self.amplitude_dispersion:
            shift = shift + self.amplitude_dispersion * self.amplitude_shift(kx, ky)
        return self.water.frequency(k) + shift

    @cached_property
    def _shift(self) -> Field:
        peak = float(self.water.wavenumber(2.0 * np.pi / self.peak_period))
        deep = peak * self.water.depth >= DEEP_ENOUGH
        return sea_shift(self.k, self.variances) if deep else np.zeros_like(self.table)

    def _at(self, table: Field, kx: Field, ky: Field) -> Field:
        k = np.hypot(kx, ky)
        ring = np.log(np.maximum(k, 1e-12) / self.k[0]) / np.log(self.k[1] / self.k[0])
        way = np.arctan2(kx, ky) % (2.0 * np.pi) / (2.0 * np.pi) * self.toward.size
        around = np.concatenate((table, table[:, :1]), axis=1)
        return map_coordinates(around, [ring, way], order=1, cval=0.0)


def spectrum_of_turns(
    turns: Sequence[TurnSpectrum], water: Water, systems: WaveSystems | None = None
) -> Spectrum | None:
    """The mean of what maps of several turns show; None where none shows a sea.

    Rings hold what the turns' mean does, beyond twice the wavenumber of the last peak (a wind sea's, whatever swell
    runs below it) at least a tail that falls with the fourth power of the wavenumber (Phillips 1958), and that tail
    alone where the maps' cells are too wide to tell. Where the way of the waves is not known, half of them run each
    way. systems: those found in the turns, of which waves up to their split are, which no turn's map resolves.
    """
    known = [each for each in turns if each.height > 0.0 and each.spectrum.ring_power.any()]
    if not known:
        return None
    k, toward = Spectrum.even()
    table = np.mean([_polar(each, k, toward) for each in known], axis=0)
    table = gaussian_filter1d(table, _WIDTH_RINGS, axis=0, mode="constant")
    table = np.maximum(
        gaussian_filter1d(table, np.radians(_WIDTH_DEG) / (toward[1] - toward[0]), axis=1, mode="wrap"), 0
    )
    ring = table.mean(axis=1)
    if not ring.any():
        return None
    with np.errstate(divide="ignore", invalid="ignore"):
        shape = np.where(ring[:, None] > 0.0, table / ring[:, None], 0.0)
    edge = min(_TAIL_FROM * k[_last_peak(ring * k**2 * np.sqrt(k))], max(_last_told(each) for each in known))
    core = (k > 0.7 * edge) & (k < edge)
    level = float(np.mean(ring[core] * k[core] ** 4)) if core.any() else 0.0
    tail = k >= edge
    seen = tail & (ring > level * k**-4.0) & (k < 2.0 * edge)
    ring = np.where(tail & ~seen, level * k**-4.0, ring)
    way = np.average(shape[core], axis=0, weights=ring[core] * k[core]) if core.any() else np.ones(toward.size)
    shape = np.where(tail[:, None] | (ring[:, None] <= 0.0), way, shape)
    shape = (1.0 - _ALL_ROUND) * shape + _ALL_ROUND
    made = Spectrum(k, toward, ring[:, None] * shape, water)
    variance = float(np.mean([each.height**2 for each in known])) / 16.0
    table = made.table * variance / made.variance
    if systems is not None:
        long = k < systems.split
        density = systems.table(k, toward)
        density = (1.0 - _ALL_ROUND) * density + _ALL_ROUND * density.mean(axis=1, keepdims=True)
        areas = made.areas
        held = float(np.sum(density[long] * areas[long]))
        rest = float(np.sum(table[~long] * areas[~long]))
        table[long] = density[long]
        table[~long] *= max(variance - held, 0.3 * rest) / max(rest, 1e-300) if rest < variance else 1.0
    return Spectrum(k, toward, table, water)


def _last_peak(power: Field) -> int:
    """The ring of the shortest waves that are a system of their own."""
    from scipy.signal import find_peaks  # takes a third of a second to import: only where waves are fitted

    least = _STRONG * power.max()
    level = np.log(np.maximum(np.concatenate(([0.0], power, [0.0])), 0.5 * least))
    return int(find_peaks(level, height=np.log(least), prominence=np.log(_STANDS_OUT))[0][-1]) - 1


def _last_told(turn: TurnSpectrum) -> float:
    """rad/m: of the shortest waves that a turn's cells tell."""
    return float(np.max(turn.spectrum.ring_wavenumber[turn.transfer > _TOLD], initial=0.0))


def _polar(turn: TurnSpectrum, k: Field, toward: Field) -> Field:
    """One turn's modes on the table's entries, as densities [m⁴] up to a factor."""
    modes, rings, ways = turn.spectrum, k.size, toward.size
    ring = np.rint(np.log(modes.wavenumber / k[0]) / np.log(k[1] / k[0])).astype(int)
    inside = (ring >= 0) & (ring < rings) & (modes.wavenumber < _last_told(turn))
    way = np.rint(modes.toward[inside] / (2.0 * np.pi) * ways).astype(int) % ways
    entry, power = ring[inside] * ways + way, modes.power[inside]
    table = np.bincount(entry, power, rings * ways).reshape(rings, ways)
    if not turn.way_known:
        table = 0.5 * (table + np.roll(table, ways // 2, axis=1))
    return table / (k**2)[:, None]
