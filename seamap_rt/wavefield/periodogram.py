"""A turn's periodogram by rings of wavenumber and directions, and the mean of several turns'."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace

import numpy as np

from .wave_spectrum import Field, WaveSpectrum

_RINGS, _WAYS = np.geomspace(0.02, 0.9, 48), 36  # rad/m; and directions
_NEW_WAVES = 0.05  # of the waves of a turn that those of the one before were not


@dataclass(frozen=True)
class Periodogram:
    """Mean power [m²] by ring of wavenumber [rad/m] and direction [rad]; arrays (ring, direction)."""

    wavenumber: Field  # (ring,)
    toward: Field  # (direction,)
    power: Field
    floor: Field
    count: Field  # waves of the sea that each mean is of
    transfer: Field  # (ring,) share of the variance that cells keep
    area: float  # m²
    line_width: float  # rad/m, standard deviation of a single wave's line

    @classmethod
    def of(cls, modes: WaveSpectrum, transfer: Callable[[Field], Field], area: float, line_width: float) -> Periodogram:
        """Of the modes of one turn's map. transfer: share of waves' variance that its cells keep, by wavenumber."""
        step = float(np.log(_RINGS[1] / _RINGS[0]))
        ring = np.rint(np.log(modes.wavenumber / _RINGS[0]) / step).astype(np.intp)
        inside = (ring >= 0) & (ring < _RINGS.size)
        way = np.rint(modes.toward / (2.0 * np.pi) * _WAYS).astype(np.intp) % _WAYS
        entry, ring = (ring * _WAYS + way)[inside], ring[inside]
        shape, size = (_RINGS.size, _WAYS), _RINGS.size * _WAYS
        count = np.bincount(entry, minlength=size).reshape(shape)
        power = np.bincount(entry, (modes.power + modes.floor)[inside], size).reshape(shape)
        members = np.maximum(np.bincount(ring, minlength=_RINGS.size), 1)
        floor = np.bincount(ring, modes.floor[inside], _RINGS.size) / members
        lattice = (2.0 * np.pi / float(np.median(np.diff(modes.ring_wavenumber)))) ** 2 / area
        return cls(
            _RINGS,
            2.0 * np.pi * np.arange(_WAYS) / _WAYS,
            power / np.maximum(count, 1),
            np.broadcast_to(floor[:, None], shape),
            count / lattice,
            transfer(_RINGS),
            area,
            line_width,
        )


def mean_periodogram(each: Sequence[Periodogram]) -> Periodogram:
    """The mean periodogram of some successive turns, whose waves are mostly the same ones."""
    count = np.sum([one.count for one in each], axis=0)
    power = np.sum([one.count * one.power for one in each], axis=0) / np.maximum(count, 1e-12)
    means = {
        name: np.mean([getattr(one, name) for one in each], axis=0)
        for name in ("floor", "transfer", "area", "line_width")
    }
    worth = 1.0 + _NEW_WAVES * (len(each) - 1)
    return replace(each[-1], power=power, count=worth * count / len(each), **means)
