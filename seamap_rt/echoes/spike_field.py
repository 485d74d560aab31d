"""Sea spikes on the facets of a turn: how much brighter than their mean the breakers of each facet are, and how fast.

Births are counted out in cells of space and time, each cell's from its own key (`random_streams.Stream.SPIKES`): a
breaker is the same in whichever turn, sector or order it is met, and keeps its bits for any number of threads. Each
column looks at its own time. A breaker's echo is laid on the facets under points of its crest, over their own areas:
so the factor has the mean 1 on every facet, however small.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from .. import random_streams
from ..conventions import unit_from_azimuth
from ..mesh import Facets
from ..mesh.grid import INNERMOST_M
from ..random_streams import Stream
from ..scattering.sea_spikes import LONGEST_LIFE, SeaSpikes
from .spike_kernel import Breed, Sweep, fill_spikes
from .summation.gaussian import key_of

_POINT_M = 0.5  # of a crest between the points that stand for it
_MEAN_LIFE = 1.0 - LONGEST_LIFE / np.expm1(LONGEST_LIFE)  # of an exponential cut off, over its scale


class IlluminatedFacets(NamedTuple):
    """Breakers on the facets of a turn; arrays (column, facet)."""

    factor: NDArray[np.float32]  # of the breaking echo, mean 1
    speed: NDArray[np.float32]  # m/s outward, of the breakers' scatterers over the water, weighted by their echo


@dataclass(frozen=True)
class SpikeField:
    """All breakers of a run, everywhere and at all times."""

    spikes: SeaSpikes
    seed: int
    wind_from_deg: float
    current: tuple[float, float] = (0.0, 0.0)  # m/s east, north, with which they drift

    def on(self, facets: Facets) -> IlluminatedFacets:
        """The breakers of one turn, each where it is when the beam passes it."""
        grid, spikes = facets.grid, self.spikes
        left = np.float32(spikes.left)
        factor = np.full(facets.height.shape, left, dtype=np.float32)
        east, north = unit_from_azimuth(grid.column_azimuth)
        wind = np.radians(self.wind_from_deg + 180.0)  # they run with it
        along = np.sin(wind) * east + np.cos(wind) * north
        speed = np.repeat((left * spikes.left_speed * along).astype(np.float32)[:, None], facets.distance.size, axis=1)
        sweep = _sweep(facets)
        for number, density in enumerate(spikes.density):
            scale = spikes.life_s[number] / _MEAN_LIFE
            slot = LONGEST_LIFE * scale
            per_area = density / spikes.life_s[number] * slot  # born in a slot, 1/m²
            breed = Breed(
                cell=float(1.0 / np.sqrt(per_area)),  # in which one is born in a slot
                slot=float(slot),
                scale=float(scale),
                celerity=float(spikes.speed[number]),
                brightness=float(spikes.brightness_m2[number]),
                ways=wind + spikes.angle[number],
                crest=float(spikes.crest_m[number]),
                points=1 + int(spikes.crest_m[number] / _POINT_M),
                drift_east=float(self.current[0]),
                drift_north=float(self.current[1]),
            )
            key = np.uint64(key_of(random_streams.key(self.seed, Stream.SPIKES), number))
            fill_spikes(key, breed, sweep, factor, speed)
        np.divide(speed, factor, out=speed, where=factor > 0.0)
        return IlluminatedFacets(factor, speed)


def _sweep(facets: Facets) -> Sweep:
    """The facets of a turn as the kernel takes them."""
    grid, pose = facets.grid, facets.grid.column_pose
    return Sweep(
        start=float(np.radians(grid.azimuth[0])),
        spacing=float(np.radians(grid.spacing_deg)),
        per_circle=grid.per_circle,
        time=pose.time,
        origin_east=np.ascontiguousarray(pose.origin[:, 0]),
        origin_north=np.ascontiguousarray(pose.origin[:, 1]),
        innermost=INNERMOST_M,
        step=float(grid.ground_range[1] - grid.ground_range[0]),
        area=facets.horizontal_area,
    )
