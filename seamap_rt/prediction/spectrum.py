"""The sea's expected directional spectrum, from maps alone, and lattices of free waves that have it.

The spectrum is what is taken of waves before their phases are known. Each wave of a lattice obeys the dispersion
relation.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from functools import cached_property

import numpy as np
from numpy.typing import ArrayLike, NDArray
from scipy.ndimage import gaussian_filter1d, map_coordinates

from ..physics.dispersion import DEEP_ENOUGH, DEEP_WATER, Water, sea_shift
from ..wavefield.sea_state import TurnSpectrum
from ..wavefield.wave_systems import WaveSystems

Field = NDArray[np.float64]

_LONGEST_M, _SHORTEST_M = 600.0, 0.5
_RINGS, _DIRECTIONS = 96, 36
_WIDTH_DEG = 12.0  # that directions are smoothed by: what a few turns of some hundred metres tell of them
_WIDTH_RINGS = 1.5
_ALL_ROUND = 0.03  # of each ring's variance, from all sides: waves that a map's own spectrum cannot exclude
_TAIL_FROM = 2.0  # times the peak's wavenumber: shorter waves hold at least what a wind sea's do
_RESOLVED = 0.6  # of waves' variance, that cells hold: of shorter ones what is put back is noise's as well
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
        return self._interpolate(self.table, kx, ky)

    def amplitude_shift(self, kx: Field, ky: Field) -> Field:
        """rad/s that this sea's amplitudes add to the frequencies of waves of some wavevectors [rad/m] in all; 0 where
        the water is not deep (`physics.amplitude_dispersion`), and beyond the rings."""
        return self._interpolate(self._shift, kx, ky)

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

    def _interpolate(self, table: Field, kx: Field, ky: Field) -> Field:
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
    edge = min(_TAIL_FROM * k[_last_peak(ring * k**2 * np.sqrt(k))], max(_last_resolved(each) for each in known))
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


def _last_resolved(turn: TurnSpectrum) -> float:
    """rad/m: of the shortest waves that a turn's cells tell."""
    return float(np.max(turn.spectrum.ring_wavenumber[turn.transfer > _RESOLVED], initial=0.0))


def _polar(turn: TurnSpectrum, k: Field, toward: Field) -> Field:
    """One turn's modes on the table's entries, as densities [m⁴] up to a factor."""
    modes, rings, ways = turn.spectrum, k.size, toward.size
    ring = np.rint(np.log(modes.wavenumber / k[0]) / np.log(k[1] / k[0])).astype(int)
    inside = (ring >= 0) & (ring < rings) & (modes.wavenumber < _last_resolved(turn))
    way = np.rint(modes.toward[inside] / (2.0 * np.pi) * ways).astype(int) % ways
    entry, power = ring[inside] * ways + way, modes.power[inside]
    table = np.bincount(entry, power, rings * ways).reshape(rings, ways)
    if not turn.direction_known:
        table = 0.5 * (table + np.roll(table, ways // 2, axis=1))
    return table / (k**2)[:, None]


_LONG_SIDE, _SHORT_SIDE = 153, 101  # modes a side: as fine as a turn's time lets; both near what FFTs like
_NEAR = 0.3  # of the reach: short waves are slow, and matter where they are soon met
_LEAST_LEFT = 0.004  # of the sea's variance: waves shorter than hold that are left out
_RESOLVED_M = 4.0  # of waves that radars of some metres' resolution tell apart
_FAST = 1.25  # times the peak's period: of longer waves there is next to nothing
_APART = 4.0  # of the peak's wavelengths: so far apart, waves of narrow spectra hardly know of each other


@dataclass(frozen=True)
class Lattice:
    """Wavevectors (n, n), n odd and the middle 0, of a square of 2π/spacing a side, that waves within `radius` m of the
    centre use."""

    spacing: float  # rad/m
    kx: Field  # rad/m, east
    ky: Field
    k: Field
    frequency: Field  # rad/s, intrinsic
    omega: Field  # rad/s, over ground
    scale: Field  # m, standard deviation of each part of the complex amplitude; 0 of waves that are not carried
    band: tuple[float, float]  # rad/m, of the waves that it carries
    radius: float

    @classmethod
    def of(cls, spectrum: Spectrum, side: int, spacing: float, band: tuple[float, float], radius: float) -> Lattice:
        """Waves of wavenumbers in a band [rad/m] with the variances of a spectrum."""
        step = spacing * (np.arange(side, dtype=np.float64) - side // 2)
        kx, ky = np.meshgrid(step, step, indexing="ij")
        k = np.hypot(kx, ky)
        moving = np.where(k > 0.0, k, spacing)
        frequency = np.where(k > 0.0, spectrum.water.frequency(moving), 0.0)
        omega = np.where(k > 0.0, spectrum.omega(kx, ky, moving), 0.0)
        return cls(spacing, kx, ky, k, frequency, omega, np.zeros(k.shape), band, radius).rescaled(spectrum)

    def rescaled(self, spectrum: Spectrum) -> Lattice:
        """The same waves with the variances of another spectrum."""
        carried = (self.k > max(self.band[0], 0.5 * self.spacing)) & (self.k <= self.band[1])
        density = np.where(carried, spectrum.density(self.kx, self.ky), 0.0)
        # η = Re Σ a e^j(k·x − ωt): a wave's variance is |a|²/2, that of either part of a.
        return replace(self, scale=np.sqrt(density) * self.spacing)

    @property
    def variance(self) -> float:
        """m², of the sea that it carries."""
        return float(np.sum(self.scale**2))

    def sinking(self, water: Water) -> float:
        """m, how far the mean level would sink if water that is at home on a level moved with these waves: ⟨D·∇η⟩ of
        first-order Lagrangian waves."""
        k = np.where(self.k > 0.0, self.k, 1.0)
        return float(np.sum(self.scale**2 * self.k / np.tanh(np.minimum(k * water.depth, 300.0))))

    def factor(self, kind: str, water: Water) -> NDArray[np.complex128]:
        """What a kind of observation, or a displacement of the water, is of a wave's amplitude."""
        return factor(kind, self.kx, self.ky, self.k, self.frequency, water)


def factor(kind: str, kx: Field, ky: Field, k: Field, frequency: Field, water: Water) -> NDArray[np.complex128]:
    """What a kind of observation, or a displacement of the water, is of the amplitude of waves of some wavevectors
    [rad/m] and intrinsic frequencies [rad/s]; all of one shape."""
    moving = np.where(k > 0.0, k, 1.0)
    name, _, axis = kind.partition("_")
    if name == "elevation":
        return np.ones(k.shape, np.complex128)
    along = ky if axis == "y" else kx
    if name == "slope":
        return np.asarray(1j * along, np.complex128)
    if kind == "velocity_z":
        return np.asarray(-1j * frequency, np.complex128)
    orbit = along / moving / np.tanh(np.minimum(moving * water.depth, 300.0))
    return np.asarray(1j * orbit if name == "displacement" else frequency * orbit, np.complex128)


def fastest(spectrum: Spectrum) -> float:
    """m/s over ground, of the longest groups of waves."""
    water = spectrum.water
    speed = water.group_speed(water.wavenumber(2.0 * np.pi / (_FAST * spectrum.peak_period)))
    return float(speed) + float(np.hypot(*water.current))


def lattices(spectrum: Spectrum, reach: float, seconds: float) -> list[Lattice]:
    """Long waves over all the water that is seen, and short ones near by.

    reach: m, of what is seen; seconds: from the first observation to the last forecast. The sea is periodic: the square
    is so wide that nothing that is seen on one side comes in at the other within that time, nor is so near to what does
    that the fit takes the one from the other.
    """
    water = spectrum.water
    end = min(spectrum.wavenumber_above(_LEAST_LEFT), 2.0 * np.pi / _RESOLVED_M)
    length = 2.0 * np.pi / float(water.wavenumber(2.0 * np.pi / spectrum.peak_period))
    spacing = 2.0 * np.pi / (2.0 * reach + fastest(spectrum) * seconds + _APART * length)
    edge = min(end, spacing * (_LONG_SIDE // 2))
    side = 2 * int(np.ceil(edge / spacing)) + 1
    long = Lattice.of(spectrum, side, spacing, (0.0, edge), np.inf)
    if edge >= end:
        return [long]
    near = max(_NEAR * reach, 60.0)
    slow = float(water.group_speed(edge)) + float(np.hypot(*water.current))
    spacing = 2.0 * np.pi / (2.0 * near + slow * seconds)
    end = min(end, spacing * (_SHORT_SIDE // 2))
    if edge >= end:
        return [long]
    side = 2 * int(np.ceil(end / spacing)) + 1
    return [long, Lattice.of(spectrum, side, spacing, (edge, end), near)]
