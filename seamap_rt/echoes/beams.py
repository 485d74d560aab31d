"""The azimuth patterns of paths, as tables in the direction cosine so fine that the nearest entry does."""

from __future__ import annotations

from collections.abc import Hashable
from dataclasses import dataclass
from functools import lru_cache
from typing import cast

import numpy as np
from numpy.typing import ArrayLike, NDArray

from ..radar.antenna import pattern_stamps
from ..radar.array import Array, antenna_array
from ..settings import RadarSettings

_REACH = 3.5  # beams to either side
_ENTRIES = 2**16  # over ±3.5 beams: the nearest entry errs by at most 1e-4 of the peak


@dataclass(frozen=True)
class TwoWayBeams:
    """Two-way voltages of the paths, or of a single one where all antennas are alike and stand on one axis.

    Antennas beside the array's axis look along lines of their own: the legs out and back then have a table each.
    """

    tables: NDArray[np.float32]  # (path or 1, leg, entry) voltage; 0 at both ends, and beyond
    aside: NDArray[np.float64]  # (path or 1, leg) m that the leg's antenna stands off the array's axis
    scale: float  # entries per unit of direction cosine; 0 lies half an entry beyond the middle

    def at_most(self, cosine: NDArray[np.float64]) -> NDArray[np.float64]:
        """Voltage over the peak's, of the path that has most, at such direction cosines or further to either side."""
        voltage = np.abs(self.tables.astype(np.float64).prod(axis=1)).max(axis=0)
        half = voltage.size // 2
        aside = np.maximum(voltage[half:], voltage[:half][::-1])
        beyond = np.maximum.accumulate(aside[::-1])[::-1]
        return np.asarray(beyond[np.minimum(np.abs(cosine) * self.scale, half - 1).astype(int)] / beyond[0])

    def share_beyond(self, cosine: ArrayLike) -> NDArray[np.float64]:
        """Share of the two-way power from beyond such direction cosines to either side, of the path with the most."""
        power = np.square(self.tables.astype(np.float64).prod(axis=1))
        aside = np.abs(np.arange(power.shape[1]) - 0.5 * (power.shape[1] - 1)) / self.scale
        order = np.argsort(aside)
        summed = np.cumsum(power[:, order], axis=1)
        within = summed[:, np.clip(np.searchsorted(aside[order], cosine) - 1, 0, None)]
        return np.max(1.0 - within / summed[:, -1:], axis=0)


def two_way_beams(radar: RadarSettings) -> TwoWayBeams:
    """Those of the radar's mode."""
    return _two_way_beams(cast(Hashable, radar), pattern_stamps(radar))  # frozen, and so hashable


@lru_cache(maxsize=8)
def _two_way_beams(settings: Hashable, _: Hashable) -> TwoWayBeams:
    array = antenna_array(cast(RadarSettings, settings))
    reach = float(np.sin(np.radians(min(90.0, _REACH * array.beam_deg))))
    alike = len({element.antenna.azimuth for element in array.elements}) == 1
    on_axis = np.ptp(array.offsets[:, 0]) == 0.0 and array.offsets[0, 0] == 0.0
    paths = array.paths[:1] if alike and on_axis else array.paths
    legs = [((i, j),) if on_axis else ((i,), (j,)) for i, j in paths]
    return TwoWayBeams(
        tables=np.array([[_table(array, leg, reach) for leg in each] for each in legs]),
        aside=np.array([[float(array.offsets[leg[0], 0]) for leg in each] for each in legs]),
        scale=(_ENTRIES - 1) / (2.0 * reach),
    )


def _table(array: Array, antennas: tuple[int, ...], reach: float) -> NDArray[np.float32]:
    """Product of the antennas' azimuth cuts."""
    cosine = np.linspace(-reach, reach, _ENTRIES)
    table = np.prod([array.elements[antenna].antenna.azimuth(cosine) for antenna in antennas], axis=0)
    table[[0, -1]] = 0.0
    return table.astype(np.float32)
