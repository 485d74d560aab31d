"""How well the waves at a place and a moment are known: what was seen along the way of each group of waves.

A group of waves of wavevector k moves with its group velocity, and what was seen of the sea wherever it went is seen of
it. Of a sea of density F(k) [m⁴] that was seen with the information Q (Σ w per square metre, of all turns) along a
group's way, the share 1/(1 + 2π² F Q) of its variance stays open: the diagonal of the fit's own covariance, for waves
that observations meet many times a wavelength. A wave and the one that runs against it look the same at a moment, and
part only as time goes: what is known of their sum alone stays open too. Waves that no lattice carries, and groups that
came from where nothing was seen, stay open altogether. Long waves, which shadows leave gaps of their own length in, are
left to samples of the fit (`ensemble`).
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, fields

import numpy as np
from numpy.typing import NDArray
from scipy.ndimage import gaussian_filter, map_coordinates

from .assimilation import Batch
from .lattice import Field, Lattice
from .observations import damped
from .spectrum import Spectrum

_RINGS, _WAYS = 4, 2  # of the spectrum's rings and directions that make a group
_DROPPED = 1e-3  # of the sea's variance, held by the weakest groups together
_SQUARES = 8.0  # a wavelength of the peak
_GROUP = 0.05  # of that wavelength: by which what was seen is spread out, so that no square is missed
_EXTENT = 0.6  # of its own wavelength, that a group reaches to every side
_AROUND = ((0.0, 0.0), (1.0, 0.0), (-1.0, 0.0), (0.0, 1.0), (0.0, -1.0))


@dataclass(frozen=True)
class Groups:
    """Groups of waves, arrays (group,)."""

    k: Field  # rad/m
    toward: Field  # rad
    omega: Field  # rad/s, over ground
    frequency: Field  # rad/s, intrinsic
    east: Field  # m/s, group velocity over ground
    north: Field
    variance: Field  # m²
    density: Field  # m⁴
    against: Field  # m⁴, of the waves that run the other way

    def __getitem__(self, chosen: NDArray[np.bool_]) -> Groups:
        """Those of a mask."""
        return Groups(*(getattr(self, each.name)[chosen] for each in fields(self)))

    @classmethod
    def of(cls, spectrum: Spectrum) -> Groups:
        """The groups of a spectrum."""
        variance = _blocks(spectrum.variances)
        share = np.maximum(variance, 1e-300)
        area = _blocks(spectrum.areas)
        log_k = _blocks(spectrum.variances * np.log(spectrum.k)[:, None]) / share
        way = _blocks(np.ones_like(spectrum.table) * np.arange(spectrum.toward.size)) / (_RINGS * _WAYS)
        order = np.argsort(variance.ravel())
        kept = np.sort(order[np.cumsum(variance.ravel()[order]) > _DROPPED * variance.sum()])
        k = np.exp(log_k.ravel()[kept])
        toward = way.ravel()[kept] * (spectrum.toward[1] - spectrum.toward[0])
        water = spectrum.water
        speed, (drift_east, drift_north) = water.group_speed(k), water.current
        frequency = water.frequency(k)
        omega = spectrum.omega(k * np.sin(toward), k * np.cos(toward), k)
        return cls(
            k,
            toward,
            omega,
            frequency,
            speed * np.sin(toward) + drift_east,
            speed * np.cos(toward) + drift_north,
            variance.ravel()[kept] * variance.sum() / variance.ravel()[kept].sum(),
            (variance / area).ravel()[kept],
            np.roll(variance / area, variance.shape[1] // 2, axis=1).ravel()[kept],
        )


def _blocks(table: Field) -> Field:
    rings, ways = table.shape
    return table.reshape(rings // _RINGS, _RINGS, ways // _WAYS, _WAYS).sum(axis=(1, 3))


@dataclass(frozen=True)
class Glimpse:
    """Where one batch of observations saw the sea, on squares (east, north) of a grid: information 1/m⁴, and the mean
    variances (3, east, north) [m²] of the blur of what was seen."""

    time: float  # s
    information: NDArray[np.float32]
    blur: NDArray[np.float32]


@dataclass(frozen=True)
class Knowledge:
    """What all batches together tell of each group."""

    groups: Groups
    lattices: tuple[Lattice, ...]
    glimpses: tuple[Glimpse, ...]
    corner: tuple[float, float]  # m, of the grid's first square's middle
    side: float  # m, of a square
    centre: tuple[float, float]  # m

    @classmethod
    def of(
        cls, spectrum: Spectrum, lattices: Sequence[Lattice], batches: Sequence[Batch], centre: tuple[float, float]
    ) -> Knowledge:
        """Of the batches of a fit."""
        water = spectrum.water
        length = 2.0 * np.pi / float(water.wavenumber(2.0 * np.pi / spectrum.peak_period))
        side = length / _SQUARES
        x, y = (np.concatenate([getattr(batch.seen, name) for batch in batches]) for name in ("x", "y"))
        margin = 3.0 * _GROUP * length
        corner = (float(x.min()) - margin, float(y.min()) - margin)
        shape = (int((x.max() + margin - corner[0]) / side) + 2, int((y.max() + margin - corner[1]) / side) + 2)
        glimpses = []
        for batch in batches:
            places = zip((batch.seen.x, batch.seen.y), corner, strict=True)
            i, j = (np.rint((each - first) / side).astype(int) for each, first in places)
            square = i * shape[1] + j
            weighed = batch.weight * np.vstack((np.ones(len(batch.seen)), batch.seen.blur.T))
            spread = np.stack(
                [
                    gaussian_filter(
                        np.bincount(square, each, shape[0] * shape[1]).reshape(shape),
                        _GROUP * _SQUARES,
                        mode="constant",
                    )
                    for each in weighed
                ]
            )
            glimpses.append(
                Glimpse(
                    float(batch.seen.time.mean()),
                    (spread[0] / side**2).astype(np.float32),
                    (spread[1:] / np.maximum(spread[0], 1e-12)).astype(np.float32),
                )
            )
        return cls(Groups.of(spectrum), tuple(lattices), tuple(glimpses), corner, side, centre)

    def open_share(self, x: Field, y: Field, time: Field, chosen: NDArray[np.bool_]) -> Field:
        """Share (point, group) of each chosen group's variance that is not known at points (point,)."""
        groups = self.groups[chosen]
        ends = [float(lattice.k[lattice.scale > 0.0].max(initial=0.0)) for lattice in self.lattices]
        short = groups.k > ends[0]
        carried = groups.k <= ends[-1]
        radius = min(lattice.radius for lattice in self.lattices)
        near = np.hypot(x - self.centre[0], y - self.centre[1]) < radius
        carried = carried & (near[:, None] | ~short)
        share = np.zeros((x.size, groups.k.size))
        if not groups.k.size:
            return share
        for east, north in _AROUND:
            offset = _EXTENT * 2.0 * np.pi / groups.k
            at = x[:, None] + east * offset, y[:, None] + north * offset
            known, both = self._information(groups, *at, time, short)
            mine, other = (2.0 * np.pi**2 * each * known for each in (groups.density, groups.against))
            alike = (both / np.maximum(known, 1e-100)) ** 2
            share += (1.0 + other) / ((1.0 + mine) * (1.0 + other) - mine * other * alike)
        return np.where(carried, share / len(_AROUND), 1.0)

    def _information(
        self, groups: Groups, x: Field, y: Field, time: Field, short: NDArray[np.bool_]
    ) -> tuple[Field, Field]:
        """What was seen along the ways of groups that pass places (point, group) at times (point,), 1/m⁴, and how much
        of it the waves that run against them share."""
        radius = min(lattice.radius for lattice in self.lattices)
        kx, ky = groups.k * np.sin(groups.toward), groups.k * np.cos(groups.toward)
        total, both = np.zeros(x.shape), np.zeros(x.shape, np.complex128)
        for glimpse in self.glimpses:
            lapse = (time - glimpse.time)[:, None]
            at = x - groups.east * lapse, y - groups.north * lapse
            place = [(each - corner) / self.side for each, corner in zip(at, self.corner, strict=True)]
            seen = map_coordinates(glimpse.information, place, order=1, cval=0.0)
            blur = np.stack([map_coordinates(each, place, order=1, cval=0.0) for each in glimpse.blur], axis=-1)
            if np.isfinite(radius):
                seen = np.where(short & (np.hypot(at[0] - self.centre[0], at[1] - self.centre[1]) > radius), 0.0, seen)
            seen = seen * damped(blur, kx, ky) ** 2
            total += seen
            both += seen * np.exp(2j * groups.frequency * (glimpse.time - self.glimpses[0].time))
        return total, np.abs(both)
