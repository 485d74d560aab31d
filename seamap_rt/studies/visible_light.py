"""Light on one realisation of a scene's sea from masts of several heights: sea, mesh and tracer, and no echoes."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, replace
from typing import Any

import numpy as np

from ..io import scenefile
from ..io.validation import validate
from ..mesh import SurfaceMesh, polar_grid, surface_mesh
from ..mesh.grid import PolarGrid
from ..mesh.surface import sea_on_grid, submerged_lines
from ..radar.mast import Mast
from ..resolved_scene import masts, run_sea
from ..scene import Scene
from ..sea import Sea
from ..settings import TracingSettings
from ..tracing import Illumination, tracer


@dataclass(frozen=True)
class Light:
    """The traced facets of one turn, by what alone sees them: the sea's own shadows, no objects', no diffraction."""

    facets: Illumination
    lowest_m: float  # the lowest antenna above mean sea level, mean over the turn: what it sees, all see


def with_keys(scene: Scene, keys: Mapping[str, Any]) -> Scene:
    """The scene with keys replaced, validated as if read from its file."""
    return validate(Scene, scenefile.apply_overrides(scene.model_dump(), keys))


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
        mast = masts(scene, sea).true
        if reason := _under_water(scene, sea, mast):
            yield reason
            continue
        grid = polar_grid(mast.radar, meshing, 0, mast)
        if surface is not None and _same_points(surface.grid, grid):
            surface = replace(surface, grid=grid)
        else:
            surface = surface_mesh(grid, *sea_on_grid(sea, grid))
        facets = tracer(tracer_name, scene.radar, scene.scattering)(surface.levelled).on(surface.facets)
        yield Light(_without_drowned(facets, surface, sea), float(grid.pose.positions[..., 2].mean(axis=0).min()))


def realised(scene: Scene, seed: int) -> tuple[Scene, Sea]:
    """The scene with another seed, and its sea: the very one that `simulate` draws for it."""
    scene = with_keys(scene, {"seed": seed})
    return scene, run_sea(scene)


def _under_water(scene: Scene, sea: Sea, mast: Mast) -> str:
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
    pairs = (
        (one.azimuth, other.azimuth),
        (one.time, other.time),
        (one.ground_range, other.ground_range),
        (one.pose.origin[:, :2], other.pose.origin[:, :2]),
    )
    return all(np.array_equal(a, b) for a, b in pairs)


def _without_drowned(facets: Illumination, surface: SurfaceMesh, sea: Sea) -> Illumination:
    """An antenna that the sea covers later in the turn sees nothing then."""
    submerged = submerged_lines(surface, sea)
    return facets.without((submerged[1:] | submerged[:-1])[:, None])
