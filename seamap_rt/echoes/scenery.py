"""The objects of a scene: the sea that they hide, and what they echo themselves.

Those fixed to the world stand still in it; those fixed to the boat turn and heave with it, and stand still in its axes:
starboard, forward, up, from the foot of the mast at the waterline.

They echo from points on the faces that look at the antenna, each with an equal share of the radar cross-section. The
points are drawn evenly over an object's surface and stay on it from turn to turn, as long as they look at the antenna,
so that an object at rest echoes steadily and one that moves fluctuates: each point's phase is that of its own path. No
real surface is smooth to half a wavelength. So each point stands out towards the antenna by a length of its own within
that; the mean power over all that these lengths can be is then the sum of the shares, for any shape and aspect.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from typing import NamedTuple

import numpy as np
import trimesh
from numpy.typing import ArrayLike, NDArray

from ..conventions import from_db, radar_wavelength, unit_from_azimuth, wrap_degrees
from ..errors import InputError
from ..io.meshfile import load_mesh
from ..mesh import Facets, SurfaceMesh
from ..radar.installation import ArrayPose, Installation
from ..radar.pose import boat_axes
from ..radar.scan import Pulses
from ..random_streams import Stream, branch
from ..scene import Scene
from ..settings import ObjectSettings
from ..tracing import Illumination
from ..tracing.horizon import Skyline
from ..tracing.objects import Occluder, placed, refuse_if_enclosing, to_boat, to_world
from .scatterers import scatterer_voltages

COUNT = 64  # points of an object: its power is exponentially distributed to 1/64
_DRAWN_AT_ONCE, _MOST_DRAWN = 1024, 131_072  # points, until enough of them are in view
_SHORT = 1e-3  # of an object's size, by which a ray to it ends short of its own surface

Sees = Callable[[NDArray[np.float64], NDArray[np.float64]], NDArray[np.bool_]]
"""(origin (n, 3), target (n, 3)) → (n,) whether nothing but objects (the sea) lies between."""


class Scatterers(NamedTuple):
    """Points that echo."""

    points: NDArray[np.float64]  # (n, 3) m
    rcs: NDArray[np.float64]  # (n,) m²
    normals: NDArray[np.float64]  # (n, 3) unit vectors, out of the surface on the antenna's side


@dataclass(frozen=True)
class EchoingObject:
    """An object with an echo: its number in the scene, its mesh as `tracing.objects.placed` gives it, its rcs [m²]."""

    number: int
    mesh: trimesh.Trimesh
    rcs_m2: float

    @classmethod
    def of(cls, settings: ObjectSettings, number: int, mesh: trimesh.Trimesh) -> EchoingObject | None:
        """The object with its echo; None if it echoes nothing."""
        return None if settings.rcs_dbsm is None else cls(number, mesh, float(from_db(settings.rcs_dbsm)))

    @property
    def short_m(self) -> float:
        """Distance [m] before a point on the object at which a ray ends, so as not to meet that point's surface."""
        return _SHORT * float(self.mesh.scale)


def object_scatterers(
    mesh: trimesh.Trimesh,
    antenna: ArrayLike,
    rcs_m2: float,
    count: int = COUNT,
    seed: int | np.random.SeedSequence = 0,
    *,
    wavelength_m: float,
    itself: Occluder | None = None,
) -> Scatterers:
    """The first `count` of a sequence of points, even over the surface above z = 0, that look at the antenna (3,).

    A closed mesh looks outward, another to both sides. With the occluder that holds just this mesh, points that it
    hides from the antenna itself are passed over. The same seed gives the same sequence, wherever antenna and mesh are.
    Each of the n points has the rcs rcs_m2/n; n is less than `count`, even 0, only if hardly anything is in view.
    """
    eye = np.asarray(antenna, dtype=np.float64)
    corners = np.asarray(mesh.triangles, dtype=np.float64)
    normals = np.array(mesh.face_normals, dtype=np.float64)
    closed = bool(mesh.is_watertight and mesh.is_winding_consistent)
    if closed and mesh.volume < 0.0:
        normals = -normals
    below = np.cumsum(mesh.area_faces)
    random = np.random.default_rng(seed)
    kept: list[NDArray[np.float64]] = []
    for _ in range(_MOST_DRAWN // _DRAWN_AT_ONCE):
        face, points, rise = _draw_points(random, corners, below / below[-1])
        towards = eye - points
        towards /= np.linalg.norm(towards, axis=1)[:, None]
        facing = np.einsum("ij,ij->i", normals[face], towards)
        looks = (points[:, 2] > 0.0) & (facing > 0.0 if closed else facing != 0.0)
        if itself is not None:
            looks[looks] = ~itself.blocked(eye, points[looks], _SHORT * float(mesh.scale))
        outward = normals[face] * np.sign(facing)[:, None]
        points = points + (0.5 * wavelength_m) * rise[:, None] * towards
        kept.append(np.concatenate((points[looks], outward[looks]), axis=1))
        if sum(map(len, kept)) >= count:
            break
    chosen = np.concatenate(kept)[:count]
    return Scatterers(chosen[:, :3], np.full(len(chosen), rcs_m2 / max(len(chosen), 1)), chosen[:, 3:])


def _draw_points(
    random: np.random.Generator, corners: NDArray[np.float64], below: NDArray[np.float64]
) -> tuple[NDArray[np.intp], NDArray[np.float64], NDArray[np.float64]]:
    """Faces (n,) by area, points (n, 3) even over each, and one more uniform number (n,) for each."""
    which, u, v, rise = random.random((_DRAWN_AT_ONCE, 4)).T
    face = np.minimum(np.searchsorted(below, which, side="right"), below.size - 1)
    over = u + v > 1.0  # the parallelogram's other half, folded back
    u, v = np.where(over, 1.0 - u, u)[:, None], np.where(over, 1.0 - v, v)[:, None]
    first, second, third = np.moveaxis(corners[face], 1, 0)
    return face, first + u * (second - first) + v * (third - first), rise


def passing(
    points: NDArray[np.float64], centres: NDArray[np.float64], azimuth: NDArray[np.float64]
) -> NDArray[np.intp]:
    """(n,) the pulse whose boresight comes nearest to the bearing of each point (n, 3).

    centres (pulse, 3): where the antenna is; azimuth (pulse,) deg: where it looks, in the same axes.
    """
    away = points[:, None, :2] - centres[:, :2]
    bearing = np.degrees(np.arctan2(away[..., 0], away[..., 1]))
    return np.abs(wrap_degrees(bearing - azimuth)).argmin(axis=1)


def objects_in_sight(
    things: Sequence[EchoingObject],
    occluder: Occluder,
    sees: Sees,
    centres: NDArray[np.float64],
    azimuth: NDArray[np.float64],
    *,
    wavelength_m: float,
    seed: int,
    count: int = COUNT,
) -> tuple[NDArray[np.float64], NDArray[np.float64], NDArray[np.bool_]]:
    """Points (n, 3) [m], rcs (n,) [m²] and sight (antenna, n) of all points of all objects of one frame over one turn.

    A point is seen, or not, as it is when the beam passes it. occluder: all objects of the frame, by their numbers;
    sees: whatever else may lie between, the sea above all. centres (pulse, antenna, 3) and azimuth (pulse,) deg are
    the antennas' positions and where they look, in the frame's axes.
    """
    middle = centres.mean(axis=1)
    points, areas, sight = [np.zeros((0, 3))], [np.zeros(0)], [np.zeros((centres.shape[1], 0), dtype=bool)]
    for thing in things:
        source = branch(seed, Stream.OBJECTS, thing.number)
        at = passing(np.asarray(thing.mesh.bounds).mean(axis=0)[None], middle, azimuth)[0]
        itself = occluder.single_object(thing.number)
        drawn = object_scatterers(
            thing.mesh, middle[at], thing.rcs_m2, count, source, wavelength_m=wavelength_m, itself=itself
        )
        if len(drawn.points) == 0:
            continue
        eyes = centres[passing(drawn.points, middle, azimuth)]  # (n, antenna, 3)
        seen = [
            sees(eye, drawn.points) & ~occluder.blocked(eye, drawn.points, thing.short_m)
            for eye in np.moveaxis(eyes, 1, 0)
        ]
        points.append(drawn.points)
        areas.append(drawn.rcs)
        sight.append(np.stack(seen))
    return np.concatenate(points), np.concatenate(areas), np.concatenate(sight, axis=1)


_MARGIN_DEG = 0.5  # to either side of an object, within which columns are tested for being hidden
_COLUMNS = 64  # at once, whose rays stay in the cache
_MOMENTS, _MOST_MOMENTS = 100, 10_000  # of a turn, and of a run, at which antennas are tested for being enclosed
_STEP = 1e-3  # s, over which the positions of a boat's own things are differenced


@dataclass(frozen=True)
class _Frame:
    """The objects that stand still in one frame."""

    occluder: Occluder
    echoing: list[EchoingObject]


class Scenery:
    """All objects of a scene. Raises InputError for a mesh that cannot be read, or that encloses an antenna."""

    def __init__(self, scene: Scene, installation: Installation) -> None:
        self._scene, self._installation = scene, installation
        self._world, self._boat = (self._frame(name) for name in ("world", "boat"))
        if self.has_objects:
            self._refuse_if_enclosing()

    @property
    def has_objects(self) -> bool:
        """Whether the scene has any objects."""
        return bool(self._world.occluder.bodies or self._boat.occluder.bodies)

    def _refuse_if_enclosing(self) -> None:
        moments = min(_MOMENTS * self._scene.turns, _MOST_MOMENTS) + 1
        track = self._installation.pose(np.linspace(0.0, self._scene.turns * self._installation.period, moments))
        try:
            refuse_if_enclosing(self._world.occluder, track.positions)
            refuse_if_enclosing(self._boat.occluder, self._to_boat_axes(track, track.positions))
        except ValueError as error:
            raise InputError(str(error)) from None

    def _frame(self, name: str) -> _Frame:
        meshes, numbers, echoing = [], [], list[EchoingObject]()
        for number, settings in enumerate(self._scene.objects):
            if settings.fixed_to != name:
                continue
            try:
                mesh = placed(load_mesh(settings, number), settings)
            except ValueError as error:
                raise InputError(str(error)) from None
            meshes.append(mesh)
            numbers.append(number)
            echo = EchoingObject.of(settings, number, mesh)
            echoing += [] if echo is None else [echo]
        return _Frame(Occluder(meshes, numbers), echoing)

    def _to_boat_axes(self, pose: ArrayPose, points: NDArray[np.float64]) -> NDArray[np.float64]:
        """Points (n, …, 3) of the world in the boat's axes at n moments."""
        foot, axes = self._foot(pose)
        return to_boat(points, foot[:, None], axes[:, None])

    def _foot(self, pose: ArrayPose) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
        """The foot of the mast (n, 3) at the waterline, and the boat's axes (n, 3, 3) there."""
        axes = boat_axes(pose.attitude)
        return pose.origin - self._installation.radar.height_m * axes[:, 2], axes

    # ------------------------------------------------------------------------------------------ what they hide

    def hide(self, facets: Illumination) -> Illumination:
        """The facets without the light that objects keep from them, at the time when the beam passes each."""
        if not self.has_objects:
            return facets
        reached, dark = facets.reached, np.zeros_like(facets.lit)
        all_columns = self._columns(facets)
        for first in range(0, all_columns.size, _COLUMNS):
            columns = all_columns[first : first + _COLUMNS]
            pose = facets.grid.column_pose[columns]
            for antenna in range(len(dark)):
                # What light bends to over a crest is hidden likewise, and none comes round an object.
                row, facet = np.nonzero(reached[antenna, columns])
                hidden = self._hidden(pose, antenna, row, _points(facets, columns[row], facet))
                dark[antenna, columns[row[hidden]], facet[hidden]] = True
        return facets.without(dark)

    def _hidden(
        self, pose: ArrayPose, antenna: int, row: NDArray[np.intp], ends: NDArray[np.float64]
    ) -> NDArray[np.bool_]:
        """(n,) whether objects hide points (n, 3) of the world from an antenna, as it stands at `row` of `pose`."""
        starts = pose.positions[row, antenna]
        hidden = self._world.occluder.blocked(starts, ends)
        if self._boat.occluder.bodies:
            foot, axes = self._foot(pose)
            here = to_boat(np.stack((starts, ends)), foot[row], axes[row])
            hidden |= self._boat.occluder.blocked(*here)
        return hidden

    def _columns(self, facets: Facets) -> NDArray[np.intp]:
        """Columns in which something may be hidden."""
        grid = facets.grid
        if self._boat.occluder.bodies:
            return np.arange(grid.columns)
        near = np.zeros(grid.columns, dtype=bool)
        pose = grid.column_pose
        origin, beside = pose.origin, float(np.hypot(*np.moveaxis(pose.offsets[..., :2], -1, 0)).max())
        for body in self._world.occluder.bodies:
            east, north = (body.centre[axis] - origin[:, axis] for axis in (0, 1))
            away, girth = np.maximum(np.hypot(east, north), 1e-9), body.girth + beside
            half = np.degrees(np.arcsin(np.minimum(1.0, girth / away))) + _MARGIN_DEG
            off = np.abs(wrap_degrees(np.degrees(np.arctan2(east, north)) - grid.column_azimuth))
            near |= (off <= half) | (away <= girth)
        return np.flatnonzero(near)

    # ------------------------------------------------------------------------------------------ what they echo

    def voltages(self, mesh: SurfaceMesh, pulses: Pulses) -> NDArray[np.complex64] | None:
        """Voltages (pulse, receiver, sample) of the objects' own echoes over a turn; None if there are none."""
        total = None
        for frame, aboard in ((self._world, False), (self._boat, True)):
            if not frame.echoing:
                continue
            own = self._echoes(frame, aboard, Skyline(mesh), pulses)
            total = own if total is None else total + own
        return total

    def _echoes(self, frame: _Frame, aboard: bool, skyline: Skyline, pulses: Pulses) -> NDArray[np.complex64]:
        installation, pose = self._installation, pulses.pose
        centres, azimuth = pose.positions, pulses.azimuth

        def sees(eyes: NDArray[np.float64], ends: NDArray[np.float64]) -> NDArray[np.bool_]:
            """Whether there is sight over the sea and past the boat's own structure."""
            seen = skyline.sees(eyes, ends)
            if self._boat.occluder.bodies:
                at = passing(ends, pose.origin, pulses.azimuth)
                here = self._to_boat_axes(pose[at], np.stack((eyes, ends), axis=1))
                seen &= ~self._boat.occluder.blocked(here[:, 0], here[:, 1])
            return seen

        if aboard:
            centres = self._to_boat_axes(pose, centres)
            azimuth = azimuth - pose.attitude[:, 2]
        points, areas, sight = objects_in_sight(
            frame.echoing,
            frame.occluder,
            (lambda eyes, ends: np.ones(len(ends), dtype=bool)) if aboard else sees,
            centres,
            azimuth,
            wavelength_m=radar_wavelength(installation.radar.frequency_hz),
            seed=self._scene.seed,
        )
        if not aboard:
            return scatterer_voltages(installation, pulses, points, areas, np.zeros_like(points), sight=sight)
        # A point of the boat goes with it: where it is when the beam passes it, and as fast.
        time = np.interp(_bearing(points), *_sort_by_bearing(azimuth, pulses.time))
        before, now, after = (
            to_world(points, *self._foot(self._installation.pose(time + late)))
            for late in (-0.5 * _STEP, 0.0, 0.5 * _STEP)
        )
        speeds = (after - before) / _STEP
        return scatterer_voltages(installation, pulses, now - speeds * time[:, None], areas, speeds, sight=sight)


def _bearing(points: NDArray[np.float64]) -> NDArray[np.float64]:
    return np.degrees(np.arctan2(points[:, 0], points[:, 1])) % 360.0


def _sort_by_bearing(
    azimuth: NDArray[np.float64], time: NDArray[np.float64]
) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
    """Azimuths 0 … 360 deg in ascending order, and the times of the pulses that look there."""
    order = np.argsort(azimuth % 360.0)
    return (azimuth % 360.0)[order], time[order]


def _points(facets: Facets, column: NDArray[np.intp], facet: NDArray[np.intp]) -> NDArray[np.float64]:
    """World positions (n, 3) of facets, each by its column and its number along it."""
    grid = facets.grid
    east, north = unit_from_azimuth(grid.column_azimuth[column] + np.degrees(facets.angle[facet]))
    origin, distance = grid.column_pose.origin[column], facets.distance[facet]
    height = facets.height[column, facet]
    return np.stack((origin[:, 0] + distance * east, origin[:, 1] + distance * north, height), axis=1)
