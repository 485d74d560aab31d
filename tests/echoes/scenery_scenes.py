"""Scenes with objects: plates, boxes, what they hide by straight lines."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np
import trimesh
from numpy.typing import NDArray

from seamap_rt.conventions import unit_from_azimuth
from seamap_rt.scene import Scene, load_scene
from seamap_rt.simulation import Simulator
from seamap_rt.tracing import Illumination, tracer

Array = NDArray[np.float64]
Light = NDArray[np.bool_]
SPEED: dict[str, Any] = {"platform__speed_m_s": 5.0, "platform__heading_deg": 90.0}
MODES = [(send, pair) for send in ("single", "switched") for pair in ("single_pulse", "alternating_pulse")]


def saved(mesh: trimesh.Trimesh, folder: Path) -> str:
    path = folder / "thing.ply"
    mesh.export(path)
    return str(path)


def box(extents: tuple[float, float, float], centre: tuple[float, float, float]) -> trimesh.Trimesh:
    return trimesh.creation.box(extents).apply_translation(centre)


def plate(width: float, foot: float, top: float) -> trimesh.Trimesh:
    """An open sheet square to the north, its middle at x = y = 0."""
    x = 0.5 * width
    corners = [[-x, 0.0, foot], [x, 0.0, foot], [x, 0.0, top], [-x, 0.0, top]]
    return trimesh.Trimesh(corners, [[0, 1, 2], [0, 2, 3]], process=False)


def scene(
    mesh: trimesh.Trimesh, folder: Path, name: str = "flat", thing: dict[str, Any] | None = None, **keys: Any
) -> Scene:
    """A sector about north of a flat sea of constant NRCS, with one object."""
    settings: dict[str, Any] = {
        "radar__sector_deg": [350.0, 370.0],
        "radar__range_m": [15.0, 100.0],
        "tracing__facet_m": 0.5,
        "tracing__columns_per_beam": 4,
        "radar__noise": False,
        "scattering__nrcs": "constant",
        "scattering__nrcs_db": -30.0,
        "tracing__tracer": "horizon",
        "objects": [{"mesh": saved(mesh, folder), "position_m": [0.0, 0.0, 0.0], **(thing or {})}],
        **keys,
    }
    return load_scene(name, {key.replace("__", "."): value for key, value in settings.items()})


def traced(made: Scene, turn: int = 0) -> tuple[Illumination, Illumination]:
    """The facets of a turn as the sea alone lights them, and as it does with the objects."""
    simulator = Simulator(made)
    light = tracer(made.tracing.tracer, made.radar, made.scattering, diffraction=made.tracing.diffraction)
    facets = light(simulator.mesh(turn))
    return facets, simulator.scenery.hide(facets)


def lit(facets: Illumination) -> Light:
    return facets.lit


def places(facets: Illumination, origin: Array) -> Array:
    """(column, facet, 3) of the facets in the world, seen from an array's origin (column, 3) each."""
    east, north = unit_from_azimuth(facets.grid.column_azimuth[:, None] + np.degrees(facets.angle))
    x = origin[:, :1] + facets.distance * east
    return np.stack((x, origin[:, 1:2] + facets.distance * north, facets.height), axis=-1)


def through_plate(eye: Array, point: Array, corner: Array, along: Array, up: Array) -> Array:
    """How far (m) within a rectangle, from `corner` along two edges, segments (…, 3) pass; negative beside it."""
    normal, way = np.cross(along, up), point - eye
    with np.errstate(divide="ignore", invalid="ignore"):
        share = ((corner - eye) @ normal) / (way @ normal)
    where = eye + share[..., None] * way - corner
    within = []
    for edge in (along, up):
        length = np.linalg.norm(edge)
        place = where @ (edge / length)
        within += [place, length - place]
    inside = np.min(within, axis=0)
    return np.where((share > 0.0) & (share < 1.0), inside, -np.inf)
