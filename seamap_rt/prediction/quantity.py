"""What can be asked of a wave field: of the water at a place, or of a vessel there; each as a share of every wave."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from ..physics.dispersion import Water
from .knowledge import Groups
from .observations import KINDS
from .spectrum import Field, Lattice, factor
from .vessel import Vessel

Share = NDArray[np.complex128]

WATER = KINDS
MOTIONS = ("heave", "roll", "pitch")  # m, rad, rad


class Course(NamedTuple):
    """A vessel's course over ground: heading [deg clockwise from north] and speed along it [m/s]."""

    heading_deg: float = 0.0
    speed_m_s: float = 0.0


AT_REST = Course()


@dataclass(frozen=True)
class Quantity:
    """One of WATER or MOTIONS: its share of the amplitude of each wave of the lattices, of the samples' lattice, and of
    each group."""

    name: str
    lattices: tuple[Share, ...]
    samples: Share
    groups: Share  # (group,)

    @property
    def is_of_water(self) -> bool:
        """Whether it is a motion of the water that is at a place, wherever that rests."""
        return self.name in WATER


def quantities(
    names: Sequence[str],
    lattices: Sequence[Lattice],
    samples: Lattice,
    groups: Groups,
    water: Water,
    vessel: Vessel | None = None,
    course: Course = AT_REST,
) -> list[Quantity]:
    """Quantities by their names. Raises ValueError for a motion of no vessel and for names that are not known."""
    kx, ky = groups.k * np.sin(groups.toward), groups.k * np.cos(groups.toward)
    sets = [(each.kx, each.ky, each.k, each.frequency, each.omega) for each in (*lattices, samples)]
    sets.append((kx, ky, groups.k, groups.frequency, groups.omega))
    found: dict[str, list[Share]] = {}
    for name in names:
        if name in WATER:
            found[name] = [factor(name, *waves[:4], water) for waves in sets]
        elif name not in MOTIONS:
            raise ValueError(f"'{name}' is not known; it must be of {', '.join((*WATER, *MOTIONS))}")
        elif vessel is None:
            raise ValueError(f"'{name}' is a vessel's: give the vessel")
    if vessel is not None and set(names) & set(MOTIONS):
        moved = [vessel.response(east, north, omega, *course, water.depth) for east, north, *_, omega in sets]
        found |= {name: [getattr(each, name) for each in moved] for name in MOTIONS}
    return [Quantity(name, tuple(found[name][:-2]), found[name][-2], found[name][-1]) for name in names]


def power(quantity: Quantity, groups: Groups) -> Field:
    """Variance (group,) of a quantity on the sea that is expected."""
    return groups.variance * np.abs(quantity.groups) ** 2
