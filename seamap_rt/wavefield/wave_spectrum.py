"""The waves' directional spectrum from one turn's map, gaps and all, each cell at its own time."""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np
import scipy.fft
from numpy.typing import NDArray

from ..physics.dispersion import DEEP_WATER, Water
from ..radar.waveform import next_fast_len
from .wave_direction import Travel

_SECTORS = 12  # within one of them, 30° of a turn, the sea all but stands still
_BIN_M = 2.5  # of the grid that cells are gathered on
_LARGEST = 0.9  # rad/m: shorter waves than 7 m are lost in a map's cells
_QUIET_DEG = 60.0  # off a ring's own axis there are hardly any waves
_PEAK_POWER = 4  # the peak is the centre of the spectrum to this power (Young 1995)
_ABOUT_PEAK = 1.4  # of its frequency, to either side
_LINE_WIDTH = 1.37  # of a disc's window [2 J₁(kR)/kR]², of half its power at kR = ±1.616: that over √(2 ln 2)

Field = NDArray[np.float64]


@dataclass(frozen=True)
class Cells:
    """What a map knows of one turn; arrays (cell,)."""

    x: Field  # m east
    y: Field  # m north
    time: Field  # s
    look: NDArray[np.intp]
    height: Field  # m
    weight: Field  # m², the sea that a cell stands for

    @property
    def reach(self) -> float:
        """Distance of the farthest cell, m."""
        return float(np.hypot(self.x, self.y).max())


@dataclass(frozen=True)
class WaveSpectrum:
    """Variance per mode of a square lattice of wavenumbers, arrays (mode,); rings (ring,) are one lattice step wide."""

    wavenumber: Field  # rad/m
    toward: Field  # rad, azimuth that the wave runs to
    power: Field  # m², the floor taken off, so that some are negative
    floor: Field  # m², what noise and gaps leave at each mode
    ring: NDArray[np.intp]
    ring_wavenumber: Field  # rad/m
    ring_power: Field  # m², 0 where the floor leaves nothing
    independent: float  # how many modes of the sea the spectrum's energy is spread over
    line_width: float  # rad/m, standard deviation of a single wave's line in a map of this reach
    water: Water

    def corrected(self, transfer: Field, least: float) -> WaveSpectrum:
        """The same with the power of each ring divided by a transfer (ring,); 0 where it is below `least`."""
        factor = np.where(transfer > least, 1.0 / np.maximum(transfer, least), 0.0)
        return replace(
            self,
            power=self.power * factor[self.ring],
            floor=self.floor * factor[self.ring],
            ring_power=self.ring_power * factor,
        )

    @property
    def ring_frequency(self) -> Field:
        """Hz, intrinsic: as one meets the waves who drifts with the current."""
        return self.water.frequency(self.ring_wavenumber) / (2.0 * np.pi)

    @property
    def _wavenumber_per_frequency(self) -> Field:
        """dk/df = 2π/c_g of each ring, up to a constant factor."""
        # √k is that of deep water; the ratio beside it is 1 there, to the last digit.
        ratio = DEEP_WATER.group_speed(self.ring_wavenumber) / self.water.group_speed(self.ring_wavenumber)
        return np.sqrt(self.ring_wavenumber) * ratio

    @property
    def strong(self) -> NDArray[np.bool_]:
        """(ring,) of rings that hold more sea than floor."""
        return self.ring_power > np.bincount(self.ring, self.floor, self.ring_power.size)

    @property
    def peak_line_width(self) -> float:
        """Hz: a single wave's line at the peak. NaN without waves."""
        peak = 2.0 * np.pi * self.peak_frequency
        if not np.isfinite(peak):
            return np.nan
        return self.line_width * float(self.water.group_speed(self.water.wavenumber(peak))) / (2.0 * np.pi)

    @property
    def peak_frequency(self) -> float:
        """Hz: the centre of S⁴ about the highest ring. NaN without waves."""
        frequency, steps = self.ring_frequency, self._wavenumber_per_frequency
        density = np.where(self.strong, self.ring_power * steps, 0.0)
        if not density.any():
            return np.nan
        top = frequency[np.argmax(density)]
        about = (frequency > top / _ABOUT_PEAK) & (frequency < top * _ABOUT_PEAK)
        weight = np.where(about, density, 0.0) ** _PEAK_POWER / steps  # 1/steps: df of a ring
        return float(np.sum(weight * frequency) / np.sum(weight))

    def direction(self, harmonic: int = 1) -> complex:
        """Σ P e^(jnθ)/Σ P over the rings that hold more sea than floor; its angle [rad] is n times the azimuth that the
        waves run to (2: of waves whose way is not known). NaN without waves."""
        power = np.where(self.strong[self.ring], self.power, 0.0)
        total = power.sum()
        return complex(np.sum(power * np.exp(1j * harmonic * self.toward)) / total) if total > 0.0 else complex(np.nan)


@dataclass(frozen=True)
class Transforms:
    """Σ w η e^(−jk·x) over the cells of each sector of a turn."""

    values: NDArray[np.complex64]  # (sector, kx, ky), kx ≥ 0
    time: Field  # s, (sector,), about the turn's middle
    kx: Field  # rad/m, (kx, ky)
    ky: Field
    spacing: float  # rad/m
    reach: float  # m
    area: float  # m²

    @classmethod
    def of(cls, cells: Cells) -> Transforms:
        """Transforms of some cells."""
        reach = cells.reach
        sector = cells.look * _SECTORS // (int(cells.look.max()) + 1)
        side = int(2.0 * reach / _BIN_M) + 1
        column, row = (((axis + reach) / _BIN_M).astype(np.intp) for axis in (cells.x, cells.y))
        pixel = (sector * side + column) * side + row
        image = np.bincount(pixel, cells.weight * cells.height, _SECTORS * side * side)
        image = image.reshape(_SECTORS, side, side).astype(np.float32)
        size = next_fast_len(2 * side)  # twice as fine as the waves that the circle tells apart
        step = 2.0 * np.pi / (size * _BIN_M)
        kx = step * np.arange(int(_LARGEST / step) + 1, dtype=np.float64)
        ky = step * np.fft.ifftshift(np.arange(size, dtype=np.float64) - size // 2)
        held = np.bincount(sector, minlength=_SECTORS)
        time = np.bincount(sector, cells.time, _SECTORS) / np.maximum(held, 1)
        return cls(
            np.asarray(scipy.fft.rfft2(image, (size, size), axes=(2, 1)))[:, : kx.size],
            time - cells.time.mean(),
            *np.meshgrid(kx, ky, indexing="ij"),
            spacing=step,
            reach=reach,
            area=float(cells.weight.sum()),
        )


def wave_spectrum(seen: Transforms, direction: Travel, water: Water = DEEP_WATER) -> WaveSpectrum:
    """Directional spectrum of the waves on water of known depth and current.

    way: that the waves run, so that each is taken back to one time by its own frequency over ground, σ + k·U. Those of
    unknown way are taken as if they only drifted with the current, and given as running eastward.
    """
    wavenumber, azimuth = np.hypot(seen.kx, seen.ky), np.arctan2(seen.kx, seen.ky)
    forth = direction.travel_sign(seen.kx, seen.ky)
    turning = (water.frequency(wavenumber) * forth + water.doppler_shift(seen.kx, seen.ky)).astype(np.float32)
    amplitude = np.zeros_like(seen.values[0])
    for time, part in zip(seen.time.astype(np.float32), seen.values, strict=True):
        amplitude += np.exp(1j * turning * time) * part
    azimuth = np.where(forth < 0.0, azimuth + np.pi, azimuth)
    # Longer waves than the seen circle's radius and a half look like a level; kx = 0 holds each wave twice.
    used = (wavenumber < _LARGEST) & (wavenumber > 4.0 / seen.reach) & ((seen.kx > 0.0) | (seen.ky > 0.0))
    power = 2.0 * np.abs(amplitude[used].astype(np.complex128) / seen.area) ** 2
    return _above_floor(wavenumber[used], azimuth[used], power, seen, water)


def _above_floor(wavenumber: Field, toward: Field, power: Field, seen: Transforms, water: Water) -> WaveSpectrum:
    """Power over its floor: what every mode holds of noise and of what gaps scatter, which is what a ring holds in the
    directions across its own waves."""
    ring = np.rint(wavenumber / seen.spacing).astype(np.intp)
    ring -= ring.min()
    members = np.bincount(ring)
    axis = np.angle(
        np.bincount(ring, power * np.cos(2.0 * toward)) + 1j * np.bincount(ring, power * np.sin(2.0 * toward))
    )
    quiet = np.cos(2.0 * toward - axis[ring]) < np.cos(np.radians(2.0 * _QUIET_DEG))
    level = np.bincount(ring, power * quiet) / np.maximum(np.bincount(ring, quiet), 1)
    above = np.maximum(power - level[ring], 0.0)
    # A periodogram is exponentially distributed: the mean of its square is twice the square of its mean. And a sea of
    # area A tells only wavenumbers apart that lie (2π)²/A from each other.
    lattice = (2.0 * np.pi / seen.spacing) ** 2 / seen.area
    independent = 2.0 * above.sum() ** 2 / np.sum(above**2) / lattice if above.any() else 1.0
    return WaveSpectrum(
        wavenumber=wavenumber,
        toward=toward,
        power=power - level[ring],
        floor=level[ring],
        ring=ring,
        ring_wavenumber=np.bincount(ring, wavenumber) / members,
        ring_power=np.maximum(np.bincount(ring, power) - members * level, 0.0),
        independent=max(1.0, independent),
        line_width=_LINE_WIDTH / seen.reach,
        water=water,
    )
