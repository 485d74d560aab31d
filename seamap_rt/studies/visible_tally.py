"""Light on one realisation of a sea from masts of several heights, and what of it is seen, summed by look and range."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from ..conventions import from_db, wrap_degrees
from ..mesh import PolarGrid, SurfaceMesh, polar_grid, surface_mesh
from ..mesh.surface import sea_on_grid, submerged_lines
from ..physics.shadowing import LEVELS_DB
from ..radar.installation import Installation
from ..radar.scan import sector_width
from ..resolved_scene import installation_of
from ..scattering.permittivity import permittivity_of
from ..scene import Scene
from ..sea import Sea
from ..settings import RadarSettings, TracingSettings
from ..tracing import Illumination, tracer
from ..tracing.visibility import water_powers

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
    answering: NDArray[np.float64]  # (polarization, level, group, bin) m² whose two-way power reaches the level
    height: NDArray[np.float64]  # (group, bin) m³, height times area
    lit_height: NDArray[np.float64]  # (group, bin) m³, of what is lit
    slope: NDArray[np.float64]  # (group,) m², squared slope along the look times area, over all bins
    runs: NDArray[np.int64]  # (dark | seen, group, bin, length): how many begin in the bin; the last length: cut short


def tally(light: Light, looks: Looks, edges: NDArray[np.float64]) -> Tally:
    """Sums over horizontal area; edges (bin + 1,) of ground range [m]."""
    facets = light.facets
    lit, bins = facets.visible_to_both, edges.size - 1
    number = np.searchsorted(edges, facets.distance, side="right") - 1
    box = (number[:, None] == np.arange(bins)) * facets.horizontal_area[:, None]  # (facet, bin) m²

    def sums(values: NDArray) -> NDArray[np.float64]:
        return (looks.members @ values) @ box

    seen = lit.astype(np.float64)
    return Tally(
        area=sums(np.ones_like(seen)),  # added up as `lit` is: where all is lit the share is 1 to the last bit
        lit=sums(seen),
        answering=np.array([[sums(1.0 * (each >= from_db(level))) for level in LEVELS_DB] for each in light.two_way]),
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


@dataclass(frozen=True)
class Light:
    """The traced facets of one turn, by what alone sees them: the sea's own shadows, no objects'."""

    facets: Illumination
    two_way: list[NDArray]  # (column, facet) of each of `POLARIZATIONS`: power over that of the same water lit
    lowest_m: float  # the lowest antenna above mean sea level, mean over the turn: what it sees, all see


def common_meshing(scenes: Sequence[Scene]) -> TracingSettings:
    """The finest spacings that any of the scenes asks for."""
    details = [scene.meshing for scene in scenes]
    return details[0].model_copy(
        update={
            "facet_m": min(each.facet_m for each in details if each.facet_m is not None),
            "columns_per_beam": max(each.columns_per_beam for each in details if each.columns_per_beam is not None),
        }
    )


def lights(scenes: Sequence[Scene], meshing: TracingSettings, sea: Sea, tracer_name: str) -> Iterator[Light | str]:
    """Turn 0 of scenes that differ in the mast alone, over one sea on one mesh; or why there is no light.

    A mast that does not move stands over the same points whatever its height, and they are computed once.
    """
    surface: SurfaceMesh | None = None
    for scene in scenes:
        mast = installation_of(scene, sea)
        if reason := _under_water(scene, sea, mast):
            yield reason
            continue
        grid = polar_grid(mast, meshing, 0)
        if surface is not None and _same_points(surface.grid, grid):
            surface = replace(surface, grid=grid)
        else:
            surface = surface_mesh(grid, *sea_on_grid(sea, grid))
        trace = tracer(tracer_name, scene.radar, scene.scattering)
        submerged = submerged_lines(surface, sea)
        drowned = (submerged[1:] | submerged[:-1])[:, None]  # an antenna that the sea covers later sees nothing then
        facets = trace(surface.levelled).with_facets(surface.facets).without(drowned)
        water = permittivity_of(scene.scattering, scene.radar.frequency_hz)
        two_way = [np.where(drowned, 0.0, each) for each in water_powers(surface, water, scene.wavelength_m)]
        yield Light(facets, two_way, float(grid.pose.positions[..., 2].mean(axis=0).min()))


def _under_water(scene: Scene, sea: Sea, mast: Installation) -> str:
    """Why an antenna does not stand above the water at time 0; empty if all do."""
    centre = mast.pose(np.zeros(1)).positions[0]
    level = sea.elevation(centre[:, 0], centre[:, 1], np.zeros(len(centre)))
    worst = int(np.argmax(level - centre[:, 2]))
    if level[worst] < centre[worst, 2]:
        return ""
    return (
        f"an antenna, at {centre[worst, 2]:.2f} m, is under water at time 0 with seed {scene.seed} "
        f"(the sea stands at {level[worst]:.2f} m there)"
    )


def _same_points(one: PolarGrid, other: PolarGrid) -> bool:
    points = ((each.azimuth, each.time, each.ground_range, each.pose.origin[:, :2]) for each in (one, other))
    return all(np.array_equal(a, b) for a, b in zip(*points, strict=True))
