"""Light by shadow rays: one per facet and antenna, through a Sionna scene that holds the sea.

Everything is in a frame centred on the antennas, where float32 costs 0.03 mm at 400 m. Points lie off the mesh's radial
edges by construction, so that no ray runs along an edge, and on a processor the tests for hits are watertight: no ray
slips between two facets (Woop, Benthin & Wald 2013).
"""

from __future__ import annotations

import importlib
from dataclasses import replace
from functools import lru_cache
from typing import Any

import numpy as np
from numpy.typing import NDArray

from ..compute.backend import prepare
from ..mesh import Facets, SurfaceMesh
from ..mesh.polar import triangulation, widths
from ..scattering.permittivity import PERMITTIVITIES
from ..settings import RadarSettings, ScatteringSettings
from .shadow_rays import ShadowRays, mitsuba, shadow_rays

VACUUM_PERMITTIVITY = 8.8541878128e-12  # F/m

Triangles = tuple[NDArray[np.float64], NDArray[np.int32]]  # vertices (n, 3) m and faces (m, 3)


class RayTracer:
    """Traces meshes one after another; the Sionna scenes are kept, and their triangles replaced."""

    def __init__(self, radar: RadarSettings, water: ScatteringSettings) -> None:
        self.radar = radar
        model = PERMITTIVITIES[water.permittivity]
        self.permittivity = complex(model(radar.frequency_hz, water.temperature_c, water.salinity_psu))
        self._scenes: dict[tuple[tuple[int, int], ...], SeaScene] = {}
        prepare()  # now, before anything is computed or replaced: without a backend no ray can be traced

    def __call__(self, mesh: SurfaceMesh) -> Facets:
        """The mesh's facets with `lit` (antenna, column, facet)."""
        facets = mesh.facets
        lit = np.zeros((mesh.grid.places.shape[1], *facets.height.shape), dtype=bool)
        traced = 0
        for sheet in mesh.sheets():
            rays = shadow_rays(mesh, facets, sheet)
            seen = what_can_be_hit(mesh, sheet, rays.turned_away)
            lit[:, rays.columns] = rays.lit(self._scene(mesh, sheet, seen).hits(rays))
            traced += rays.number.size
        return replace(facets, lit=lit, rays=traced)

    def _scene(self, mesh: SurfaceMesh, sheet: tuple[slice, ...], triangles: Triangles) -> SeaScene:
        key = tuple((columns.start, columns.stop) for columns in sheet)
        known = self._scenes.get(key)
        if known is None or not known.update(triangles):
            known = SeaScene(mesh, sheet, self.radar.frequency_hz, self.permittivity, triangles)
            self._scenes[key] = known
        return known


class SeaScene:
    """A Sionna scene: the sea as a scene object of sea water, and the two antennas as radio devices.

    The first antenna is the transmitter and all are receivers. They stand where they are when the beam passes the first
    column, seen along it, y ahead; rays start from where they are when it passes their own.
    """

    def __init__(
        self,
        mesh: SurfaceMesh,
        sheet: tuple[slice, ...],
        frequency_hz: float,
        permittivity: complex,
        triangles: Triangles | None = None,
    ) -> None:
        """triangles: what stands for the sheet, if not all of it."""
        self.backend, mi = prepare(), mitsuba()
        rt: Any = importlib.import_module("sionna.rt")

        self._mi = mi
        vertices, faces = triangles or mesh.triangles(sheet)
        shape = mi.Mesh("sea", len(vertices), len(faces), has_vertex_normals=False, has_vertex_texcoords=False)
        parameters = mi.traverse(shape)
        parameters["vertex_positions"] = _flat(mi.Float, vertices, np.float32)
        parameters["faces"] = _flat(mi.UInt32, faces, np.uint32)
        parameters.update()
        self._vertices = len(vertices)

        conductivity = -permittivity.imag * 2.0 * np.pi * frequency_hz * VACUUM_PERMITTIVITY
        water = rt.RadioMaterial("sea-water", relative_permittivity=permittivity.real, conductivity=float(conductivity))
        shape.set_bsdf(water)
        # Watertight tests take a third more time, but the simpler tree that they need is built in half of it.
        watertight = {"embree_use_robust_intersections": True} if self.backend.kind == "llvm" else {}
        self.scene: Any = rt.Scene(mi.load_dict({"type": "scene", **watertight, "sea": shape}))
        self.scene.frequency = frequency_hz
        places = [[float(part) for part in (x, y, z)] for y, x, z in mesh.grid.places[sheet[0].start]]
        names = ("lower", "upper") if len(places) == 2 else [f"antenna-{number}" for number in range(len(places))]
        self.scene.add(rt.Transmitter(f"{names[0]}-transmitter", position=places[0]))
        for name, place in zip(names, places, strict=True):
            self.scene.add(rt.Receiver(name, position=place))

    def update(self, triangles: Triangles) -> bool:
        """Hold other triangles; False if they have not as many vertices, and the scene has to be made anew."""
        vertices, faces = triangles
        if self._vertices != len(vertices):
            return False
        parameters = self.scene.mi_scene_params
        parameters["sea.vertex_positions"] = _flat(self._mi.Float, vertices, np.float32)
        parameters["sea.faces"] = _flat(self._mi.UInt32, faces, np.uint32)
        parameters.update()
        return True

    def hits(self, rays: ShadowRays) -> NDArray[np.bool_]:
        """(ray,): something lies between its start and its end."""
        return self.stopped(rays.on_device()) if rays.number.size else np.zeros(0, dtype=bool)

    def stopped(self, rays: Any) -> NDArray[np.bool_]:
        """(ray,): Mitsuba's ray hits something."""
        return np.array(self.scene.mi_scene.ray_test(rays, coherent=True))


def what_can_be_hit(mesh: SurfaceMesh, sheet: tuple[slice, ...], turned_away: NDArray[np.bool_]) -> Triangles:
    """The triangles of a sheet without those that are turned away from every antenna: for shadow rays it is the same.

    A ray that starts above the water goes under it only through a facet that shows it its upper side. So if it hits
    anything, it hits such a facet first, and those turned away can be left out, were it not for the sheet's border: a
    ray may pass below it. Walls stand there, from the border down to below everything. A ray that hits a wall is under
    water; its facet shows it the upper side, so it would have to come up through one that is turned away: the same
    shadow. An antenna that leans out over the first rung may itself be under water, and then nothing is left out.
    """
    grid, vertices = mesh.grid, mesh.vertices(sheet)
    topology = widths(sheet), grid.ground_range.size
    faces = _known_triangulation(*topology)
    aside = np.hypot(grid.places[..., 0], grid.places[..., 1]).max()
    if aside < grid.ground_range[0] * np.cos(0.5 * np.radians(grid.spacing_deg)):
        faces = np.compress(~turned_away.ravel(), faces, axis=0)
    border, walls = _walls(*topology)
    feet = vertices[border]
    feet[:, 2] = min(vertices[:, 2].min(), grid.places[..., 2].min()) - 1.0
    return np.concatenate((vertices, feet)), np.concatenate((faces, walls))


_known_triangulation = lru_cache(maxsize=4)(triangulation)


@lru_cache(maxsize=4)
def _walls(widths: tuple[int, ...], rungs: int) -> tuple[NDArray[np.intp], NDArray[np.int32]]:
    """The vertices along a sheet's near and side borders, and the faces (n, 3) between them and their feet.

    The feet follow the sheet's own vertices, in the border's order.
    """
    lines = [columns + 1 for columns in widths]
    offsets, total = np.cumsum([0, *lines]) * rungs, sum(lines) * rungs
    borders, walls = [], []
    for count, offset in zip(lines, offsets[:-1], strict=True):
        corner = offset + np.arange(count * rungs).reshape(count, rungs)
        border = np.concatenate((corner[0, ::-1], corner[1:-1, 0], corner[-1]))  # in along a line, round, and out again
        foot = total + sum(map(len, borders)) + np.arange(border.size)
        walls += [np.stack((border[:-1], border[1:], foot[1:]), axis=1)]
        walls += [np.stack((border[:-1], foot[1:], foot[:-1]), axis=1)]
        borders.append(border)
    return np.concatenate(borders), np.concatenate(walls).astype(np.int32)


def _flat(kind: Any, values: NDArray[Any], dtype: Any) -> Any:
    return kind(np.ascontiguousarray(values, dtype=dtype).ravel())
