"""What of a traced turn is seen, summed by look and range: areas, heights, slopes, and runs of shadow and of light."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from ..conventions import wrap_degrees
from ..mesh import PolarGrid
from ..radar.scan import sector_width
from ..settings import RadarSettings
from ..tracing import Illumination

SECTORS = 24  # of a circle, the first centred on where the waves come from
LOOKS = {"along": (0.0, 180.0), "at 45°": (45.0, 135.0, -135.0, -45.0), "across": (90.0, -90.0)}  # from the waves
ALL_LOOKS = "all looks"


@dataclass(frozen=True)
class Looks:
    """Groups of columns: sectors within the radar's own, then the three `LOOKS` and all looks, each some sectors."""

    azimuth: NDArray[np.float64]  # (sector,) deg, the middle
    from_waves: NDArray[np.float64]  # (sector,) deg, the middle's angle from where the waves come from
    members: NDArray[np.float64]  # (sector + look, column) 1 or 0
    names = (*LOOKS, ALL_LOOKS)

    @property
    def sectors(self) -> int:
        """How many sectors there are."""
        return self.azimuth.size

    @property
    def weight(self) -> NDArray[np.float64]:
        """(sector + look, sector): share that each sector has in each group; NaN for a group of no columns."""
        return self.members @ self.members[: self.sectors].T / self.members.sum(axis=1, keepdims=True)

    @classmethod
    def of(cls, grid: PolarGrid, radar: RadarSettings, waves_from_deg: float) -> Looks:
        """Sectors that the radar's holds at least half of; where it holds none, the whole of it is one."""
        width, scanned = 360.0 / SECTORS, sector_width(radar)
        sweep, rotated = grid.column_sweep, wrap_degrees(grid.column_azimuth - waves_from_deg)
        inside = (sweep > 0.0) & (sweep < scanned)
        if radar.scan == "staring":
            inside = np.abs(sweep - 0.5 * scanned) < 0.5 * width
        number = np.floor((rotated + 0.5 * width) / width).astype(int) % SECTORS
        members = np.array([inside & (number == each) for each in range(SECTORS)])
        enough = members.sum(axis=1) * grid.spacing_deg >= 0.5 * width - grid.spacing_deg
        middle = wrap_degrees(width * np.arange(SECTORS))
        if enough.any():
            members, middle = members[enough], middle[enough]
        else:
            members, middle = inside[None], wrap_degrees([radar.sector_deg[0] + 0.5 * scanned - waves_from_deg])
        order = np.argsort(middle)
        members, middle = members[order], middle[order]
        pooled = [members[np.isin(middle, angles)].any(axis=0) for angles in LOOKS.values()]
        pooled.append(members.any(axis=0))
        return cls((waves_from_deg + middle) % 360.0, middle, np.vstack((members, pooled)).astype(np.float64))


@dataclass(frozen=True)
class Tally:
    """Sums over the facets of each group of columns (group), range bin and, of runs, length in rungs."""

    area: NDArray[np.float64]  # (group, bin) m²
    lit: NDArray[np.float64]  # (group, bin) m² that all antennas see
    height: NDArray[np.float64]  # (group, bin) m³, height times area
    lit_height: NDArray[np.float64]  # (group, bin) m³, of what is lit
    slope: NDArray[np.float64]  # (group,) m², squared slope along the look times area, over all bins
    runs: NDArray[np.int64]  # (dark | seen, group, bin, length): how many begin in the bin; the last length: cut short


def tally(facets: Illumination, looks: Looks, edges: NDArray[np.float64]) -> Tally:
    """Sums over horizontal area; edges (bin + 1,) of ground range [m]."""
    lit, bins = facets.visible_to_both, edges.size - 1
    number = np.searchsorted(edges, facets.distance, side="right") - 1
    box = (number[:, None] == np.arange(bins)) * facets.horizontal_area[:, None]  # (facet, bin) m²

    def sums(values: NDArray) -> NDArray[np.float64]:
        return (looks.members @ values) @ box

    seen = lit.astype(np.float64)
    return Tally(
        area=sums(np.ones_like(seen)),  # added up as `lit` is: where all is lit the share is 1 to the last bit
        lit=sums(seen),
        height=sums(facets.height),
        lit_height=sums(seen * facets.height),
        slope=sums(np.square(facets.slope_look, dtype=np.float64)).sum(axis=1),
        # Near and far facets lie on two planes of each column: each is a chain of its own.
        runs=np.sum([_runs(lit[:, kind::2], number[kind::2], looks, bins) for kind in (0, 1)], axis=0),
    )


def run_lengths(
    lit: NDArray[np.bool_],
) -> tuple[NDArray[np.intp], NDArray[np.intp], NDArray[np.intp], NDArray[np.bool_]]:
    """Runs of equal values along each row of lit (row, point): row, first point, length, and whether they are seen."""
    points = lit.shape[1]
    border = np.ones((lit.shape[0], points + 1), dtype=bool)
    border[:, 1:-1] = lit[:, 1:] != lit[:, :-1]
    row, at = np.nonzero(border)
    begins = at < points
    length = np.diff(at, append=0)[begins]
    row, at = row[begins], at[begins]
    return row, at, length, lit[row, at]


def _runs(lit: NDArray[np.bool_], number: NDArray[np.intp], looks: Looks, bins: int) -> NDArray[np.int64]:
    """(dark | seen, group, bin, length) of a chain's runs by where they begin. Those that run out of the mesh are
    counted under its whole length, which no other can have."""
    row, first, length, seen = run_lengths(lit)
    points = lit.shape[1]
    length = np.where(first + length == points, points, length)
    bin_ = number[first]
    counts = np.zeros((2, len(looks.members), bins, points + 1), dtype=np.int64)
    for group, member in enumerate(looks.members):
        chosen = (member[row] > 0.0) & (bin_ >= 0) & (bin_ < bins)
        index = np.ravel_multi_index((seen[chosen].astype(int), bin_[chosen], length[chosen]), (2, bins, points + 1))
        counts[:, group] = np.bincount(index, minlength=2 * bins * (points + 1)).reshape(2, bins, points + 1)
    return counts
