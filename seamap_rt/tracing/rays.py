"""Light by shadow rays: one per facet and antenna, through a Sionna scene that holds the sea.

Everything is in a frame centred on the antennas, where float32 costs 0.03 mm at 400 m. Points lie off the mesh's radial
edges by construction, so that no ray runs along an edge, and on a processor the tests for hits are watertight: no ray
slips between two facets (Woop, Benthin & Wald 2013).
"""

from __future__ import annotations

import importlib
from collections.abc import Iterator
from functools import lru_cache
from typing import Any

import numpy as np
from numpy.typing import NDArray
from trimesh import Trimesh

from ..compute.backend import prepare
from ..mesh import SurfaceMesh
from ..mesh.surface import as_trimesh, triangulation, widths
from ..scattering.permittivity import PERMITTIVITIES
from ..settings import RadarSettings, ScatteringSettings
from .hiding import hiding_facets
from .illumination import Illumination, mitsuba, mitsuba_mesh, set_triangles
from .shadow_rays import ShadowRays, shadow_rays

VACUUM_PERMITTIVITY = 8.8541878128e-12  # F/m
_MOST_SCENES = 4  # that are kept: a turn has three at most, or parts of two widths


class RayTracer:
    """Traces meshes one after another; the Sionna scenes are kept, and their triangles replaced."""

    def __init__(
        self,
        radar: RadarSettings,
        water: ScatteringSettings,
        scenes: dict[Any, SeaScene] | None = None,
        most_facets: int = 2_000_000,
    ) -> None:
        """scenes: of an earlier tracer, to go on with. most_facets: traced at a time where a turn can be parted: a tree
        of all takes 0.1 kB a facet and more."""
        self.radar, self.most_facets = radar, most_facets
        model = PERMITTIVITIES[water.permittivity]
        self.permittivity = complex(model(radar.frequency_hz, water.temperature_c, water.salinity_psu))
        self.scenes = {} if scenes is None else scenes  # by water, number of antennas and the shape of their sheets
        prepare()  # now, before anything is computed or replaced: without a backend no ray can be traced

    def __call__(self, mesh: SurfaceMesh) -> Illumination:
        """The mesh's facets, lit geometrically."""
        facets = mesh.facets
        lit = np.zeros((mesh.grid.antenna_positions.shape[1], *facets.height.shape), dtype=bool)
        traced = 0
        for rays, scene in self._sheets(mesh):
            lit[:, rays.columns] = rays.lit_facets(scene.hits(rays))
            traced += rays.number.size
        return Illumination.of(facets, lit, traced)

    def _sheets(self, mesh: SurfaceMesh) -> Iterator[tuple[ShadowRays, SeaScene]]:
        """The rays of each sheet, and the scene that holds its surface."""
        for sheet in _split_mesh(mesh, self.most_facets):
            rays = shadow_rays(mesh, mesh.facets, sheet)
            yield rays, self._scene(mesh, sheet, rays)

    def _scene(self, mesh: SurfaceMesh, sheet: tuple[slice, ...], rays: ShadowRays) -> SeaScene:
        """A scene with what of the sheet's surface the rays can meet in it; sheets of one shape share it."""
        antennas = mesh.grid.antenna_positions[sheet[0].start]
        key = self.radar.frequency_hz, self.permittivity, len(antennas), widths(sheet), mesh.grid.ground_range.size
        kept = self.scenes.pop(key, None)
        surface = occluding_surface(mesh, sheet, rays, None if kept is None else kept.surface)
        if kept is None or not kept.update(surface):
            kept = SeaScene(surface, antennas, self.radar.frequency_hz, self.permittivity)
        else:
            kept.antennas = antennas
        self.scenes[key] = kept
        while len(self.scenes) > _MOST_SCENES:  # those that have not been used for longest
            self.scenes.pop(next(iter(self.scenes)))
        return kept


class SeaScene:
    """The sea as a scene of Mitsuba, by whose tree rays are tested; `scene` is the same for Sionna.

    The antennas stand where they are when the beam passes the first column, seen along it, y ahead; rays start from
    where they are when it passes their own.
    """

    def __init__(
        self, surface: Trimesh, antennas: NDArray[np.float64], frequency_hz: float, permittivity: complex
    ) -> None:
        """surface: of a sheet, in the antennas' frame. antennas (antenna, 3) m: along the first column, across it, up.
        permittivity: ε′ − jε″ of sea water, relative to vacuum."""
        backend, mi = prepare(), mitsuba()
        self._shape = mitsuba_mesh("sea", surface)
        self.surface, self._vertices = surface, len(surface.vertices)
        self.antennas, self._frequency_hz, self._permittivity = antennas, frequency_hz, permittivity
        # Watertight tests take a third more time, but the simpler tree that they need is built in half of it.
        watertight = {"embree_use_robust_intersections": True} if backend.kind == "llvm" else {}
        self.mi_scene: Any = mi.load_dict({"type": "scene", **watertight, "sea": self._shape})
        self.parameters: Any = mi.traverse(self.mi_scene)

    @property
    def scene(self) -> Any:
        """A Sionna scene: the sea as a scene object of sea water, the antennas as radio devices, of which the first
        transmits and all receive. Sionna's imports take longer than a turn's rays: rays alone do not load it."""
        rt: Any = importlib.import_module("sionna.rt")
        conductivity = float(-self._permittivity.imag * 2.0 * np.pi * self._frequency_hz * VACUUM_PERMITTIVITY)
        permittivity = self._permittivity.real
        self._shape.set_bsdf(
            rt.RadioMaterial("sea-water", relative_permittivity=permittivity, conductivity=conductivity)
        )
        scene: Any = rt.Scene(self.mi_scene)
        scene.frequency = self._frequency_hz
        count = len(self.antennas)
        names = ("lower", "upper") if count == 2 else [f"antenna-{number}" for number in range(count)]
        # Sionna takes x across the column, y along it.
        positions = [[float(value) for value in (x, y, z)] for y, x, z in self.antennas]
        scene.add(rt.Transmitter(f"{names[0]}-transmitter", position=positions[0]))
        for name, position in zip(names, positions, strict=True):
            scene.add(rt.Receiver(name, position=position))
        return scene

    def update(self, surface: Trimesh) -> bool:
        """Hold another surface; False if it has not as many vertices, and the scene has to be made anew."""
        if self._vertices != len(surface.vertices):
            return False
        self.surface = surface
        set_triangles(self.parameters, "sea.", surface)
        self.parameters.update()
        return True

    def hits(self, rays: ShadowRays) -> NDArray[np.bool_]:
        """(ray,): something lies between its start and its end."""
        return self.stopped(rays.traced) if rays.number.size else np.zeros(0, dtype=bool)

    def stopped(self, rays: Any) -> NDArray[np.bool_]:
        """(ray,): Mitsuba's ray hits something."""
        dr: Any = importlib.import_module("drjit")
        return np.array(dr.detach(self.mi_scene.ray_test(rays, coherent=True), preserve_type=False))


def _split_mesh(mesh: SurfaceMesh, most_facets: int) -> Iterator[tuple[slice, ...]]:
    """The mesh's sheets, large ones in parts: from an antenna on the axis no ray leaves its column."""
    for sheet in mesh.sheets():
        most = max(1, most_facets // mesh.facets.distance.size)
        if not mesh.upright or sum(widths(sheet)) <= most:
            yield sheet
            continue
        for columns in sheet:
            for start in range(columns.start, columns.stop, most):
                yield (slice(start, min(start + most, columns.stop)),)


def occluding_surface(
    mesh: SurfaceMesh, sheet: tuple[slice, ...], rays: ShadowRays, into: Trimesh | None = None
) -> Trimesh:
    """The sheet's surface with no more than the facets that can be the first to stop a ray: for these it is the same.

    Facets are missing, so walls stand along the sheet's border, down to below everything: a ray may pass below it. A
    ray that hits a wall is under water; its facet shows it the upper side, so it would have to come up through one that
    faces away: the same shadow. An antenna that leans out over the first rung may itself be under water, and then
    nothing is left out.

    into: an earlier surface that is to hold this one. One that is thrown away stays in memory until Python looks for
    what refers to itself, as every Trimesh does, and to fill fresh memory takes longer than all the rest.
    """
    grid, vertices = mesh.grid, mesh.vertices(sheet)
    topology = widths(sheet), grid.ground_range.size
    aside = np.hypot(grid.antenna_positions[..., 0], grid.antenna_positions[..., 1]).max()
    some = aside < grid.ground_range[0] * np.cos(0.5 * np.radians(grid.spacing_deg))
    faces = triangulation(*topology, hiding_facets(mesh, sheet, rays) if some else None)
    border, walls = _walls(*topology)
    feet = vertices[border]
    feet[:, 2] = min(vertices[:, 2].min(), grid.antenna_positions[..., 2].min()) - 1.0
    vertices, faces = np.concatenate((vertices, feet)), np.concatenate((faces, walls))
    if into is None:
        return as_trimesh(vertices, faces)
    into.vertices, into.faces = vertices, faces
    return into


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
