"""What objects hide: straight segments from an antenna to a facet, or to another object, against their triangles.

Rays are traced in float32 by Mitsuba, one object after another. A segment is first cut, in float64, to the part within
the object's bounding sphere and given from the object's own middle, so that rounding costs 1e-7 of the object's size,
wherever it lies. Segments that pass it by, most of them, are dropped before.

World-fixed objects are given in the world's axes, boat-fixed ones in the boat's, and the segments likewise.
"""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
import trimesh
from numpy.typing import ArrayLike, NDArray

from ..conventions import unit_from_azimuth
from ..settings import ObjectSettings
from .illumination import flat, mitsuba, mitsuba_mesh

STOP_SHORT_M = 1e-3  # a pier's wall hides the facet behind it, though it stands in that very facet
_SLACK = 1.0 + 1e-6  # of the bounding sphere: no triangle touches where a segment enters
_HAIR = 2e-6  # of the bounding sphere, by which it is larger: ten times what rounding does
_AT_ONCE = 1 << 16  # segments, whose arrays stay in the cache
_DIRECTIONS = 500
_ENCLOSED = 0.98  # of the directions blocked: a hull has seams and cracks
_MOST_POSITIONS = 100  # at which it is tested whether an object encloses an antenna

Rays = tuple[NDArray[np.float32], NDArray[np.float32], NDArray[np.float32]]  # origin (n, 3), direction (n, 3), length


class Occluder:
    """All objects of one frame (the world's or the boat's). Without any it hides nothing and needs no backend.

    meshes: as `placed` gives them. numbers: those of the objects in the scene, for messages; left out, 0, 1, ….
    `rays` counts those that were traced so far, the others having been culled.
    """

    def __init__(self, meshes: Sequence[trimesh.Trimesh], numbers: Sequence[int] | None = None) -> None:
        self.bodies = [_Body(mesh) for mesh in meshes]
        self.numbers = list(range(len(meshes)) if numbers is None else numbers)
        self.rays = 0

    def single_object(self, number: int) -> Occluder:
        """The occluder of that object only; it shares its triangles."""
        one = Occluder([])
        one.bodies, one.numbers = [self.bodies[self.numbers.index(number)]], [number]
        return one

    def blocked(self, origin: ArrayLike, target: ArrayLike, stop_short_m: float = STOP_SHORT_M) -> NDArray[np.bool_]:
        """(n,) whether the segment from origin (n, 3) or (3,) to target (n, 3), in the frame's axes, meets an object.

        It ends `stop_short_m` short of the target. Segments with a coordinate that is not finite meet nothing.
        """
        ends = np.atleast_2d(np.asarray(target, dtype=np.float64))
        starts = np.broadcast_to(np.asarray(origin, dtype=np.float64), ends.shape)
        blocked = np.zeros(len(ends), dtype=bool)
        for body in self.bodies:
            chosen, rays = body.rays(starts, ends, stop_short_m)
            if chosen.size:
                blocked[chosen] |= body.hit(rays)
                self.rays += chosen.size
        return blocked


class _Body:
    """One mesh and its bounds."""

    def __init__(self, mesh: trimesh.Trimesh) -> None:
        self.bounds = np.asarray(mesh.bounds, dtype=np.float64)
        self.centre = self.bounds.mean(axis=0)
        corners = np.asarray(mesh.vertices, dtype=np.float64)[np.unique(mesh.faces)] - self.centre
        self.radius = _SLACK * float(np.linalg.norm(corners, axis=1).max())
        self.girth = _SLACK * float(np.hypot(corners[:, 0], corners[:, 1]).max())  # radius seen from above

        self._mi = mitsuba()
        about_centre = trimesh.Trimesh(mesh.vertices - self.centre, mesh.faces, process=False, validate=False)
        self._scene = self._mi.load_dict({"type": "scene", "object": mitsuba_mesh("object", about_centre)})

    def rays(
        self, starts: NDArray[np.float64], ends: NDArray[np.float64], stop_short_m: float
    ) -> tuple[NDArray[np.intp], Rays]:
        """Which segments may meet the object, and their parts that may, from its centre."""
        all_chosen, clipped = [], []
        for first in range(0, len(ends), _AT_ONCE):
            start, end = starts[first : first + _AT_ONCE], ends[first : first + _AT_ONCE]
            near = self._near_segments(start, end)
            if near.size:
                inside, part = self._clip_to_sphere(start[near], end[near], stop_short_m)
                all_chosen.append(first + near[inside])
                clipped.append(part)
        if not clipped:
            none = np.zeros((0, 3), dtype=np.float32)
            return np.zeros(0, dtype=np.intp), (none, none, none[:, 0])
        origin, direction, length = (np.concatenate(pieces) for pieces in zip(*clipped, strict=True))
        return np.concatenate(all_chosen), (origin, direction, length)

    def _near_segments(self, start: NDArray[np.float64], end: NDArray[np.float64]) -> NDArray[np.intp]:
        """Which segments, seen from above, meet the circle around the object."""
        x, y = self.centre[0] - start[:, 0], self.centre[1] - start[:, 1]
        with np.errstate(invalid="ignore"):
            east, north = end[:, 0] - start[:, 0], end[:, 1] - start[:, 1]
            square = east * east + north * north
            across, along = x * north - y * east, x * east + y * north  # times the segment's length
        reach = self.girth * np.sqrt(square)
        return np.flatnonzero((np.abs(across) <= reach) & (along >= -reach) & (along <= square + reach))

    def _clip_to_sphere(
        self, start: NDArray[np.float64], end: NDArray[np.float64], stop_short_m: float
    ) -> tuple[NDArray[np.intp], Rays]:
        """Which segments pass through the bounding sphere, and the part of each that lies in it."""
        direction = end - start
        length = np.linalg.norm(direction, axis=1)
        direction /= np.maximum(length, np.finfo(np.float64).tiny)[:, None]
        away = self.centre - start
        along = np.einsum("ij,ij->i", away, direction)
        beside = away - along[:, None] * direction
        half = np.sqrt(np.maximum(self.radius**2 - np.einsum("ij,ij->i", beside, beside), 0.0))
        enters, leaves = np.maximum(along - half, 0.0), np.minimum(along + half, length - stop_short_m)
        inside = np.flatnonzero(leaves > enters)
        origin = enters[inside, None] * direction[inside] - away[inside]
        kept = (origin, direction[inside], leaves[inside] - enters[inside])
        return inside, (kept[0].astype(np.float32), kept[1].astype(np.float32), kept[2].astype(np.float32))

    def hit(self, rays: Rays) -> NDArray[np.bool_]:
        """Whether each ray meets a triangle.

        In float32 a ray may slip through the edge between two triangles, and where a column's rays lie in the plane of
        an upright edge many do. So those that miss are traced again, slightly to either side: one of
        them lies across any edge.
        """
        mi = self._mi
        origin, direction, length = rays
        start = mi.Point3f(*(flat(mi.Float, axis) for axis in origin.T))
        towards = mi.Vector3f(*(flat(mi.Float, axis) for axis in direction.T))
        reach = flat(mi.Float, length)
        hit = mi.Bool(False)
        for aside in (0.0, *mi.coordinate_system(towards)):
            ray = mi.Ray3f(start + self.radius * _HAIR * aside, towards, reach, time=mi.Float(0.0), wavelengths=[])
            hit |= self._scene.ray_test(ray, ~hit)
        return np.array(hit)

    def encloses(self, point: NDArray[np.float64]) -> bool:
        if not ((point >= self.bounds[0]) & (point <= self.bounds[1])).all():
            return False
        ends = point + 3.0 * self.radius * _even_directions()
        chosen, rays = self.rays(np.broadcast_to(point, ends.shape), ends, 0.0)
        return bool(chosen.size and np.count_nonzero(self.hit(rays)) >= _ENCLOSED * _DIRECTIONS)


def placed(mesh: trimesh.Trimesh, settings: ObjectSettings) -> trimesh.Trimesh:
    """A mesh from its own frame (`io.meshfile.load_mesh`) to where it stands, in the world's axes or the boat's."""
    east, north = unit_from_azimuth(settings.heading_deg)
    x, y, z = np.asarray(mesh.vertices, dtype=np.float64).T
    vertices = np.stack((north * x + east * y, north * y - east * x, z), axis=1) + settings.position_m
    return trimesh.Trimesh(vertices=vertices, faces=mesh.faces, process=False, validate=False)


def refuse_if_enclosing(occluder: Occluder, antennas: ArrayLike) -> None:
    """Raise ValueError, in one line, if an object encloses an antenna at one of its positions (…, 3) in the frame."""
    positions = np.asarray(antennas, dtype=np.float64).reshape(-1, 3)
    for number, body in zip(occluder.numbers, occluder.bodies, strict=True):
        near = positions[((positions >= body.bounds[0]) & (positions <= body.bounds[1])).all(axis=1)]
        for x, y, z in near[:: max(1, len(near) // _MOST_POSITIONS)]:
            if body.encloses(np.array([x, y, z])):
                raise ValueError(
                    f"objects.{number}: encloses the antenna at ({x:.3g}, {y:.3g}, {z:.3g}) m, from where nothing "
                    f"would be seen; move it by objects.{number}.position_m"
                )


def to_world(points: ArrayLike, origin: ArrayLike, boat_axes: ArrayLike) -> NDArray[np.float64]:
    """Points (…, 3) in boat axes (starboard, forward, up) → east, north, up.

    origin (…, 3) [m]: the foot of the mast at the waterline; boat_axes (…, 3, 3) as `radar.pose` gives them.
    """
    rotated = np.einsum("...i,...ij->...j", np.asarray(points, dtype=np.float64), np.asarray(boat_axes))
    return rotated + np.asarray(origin, dtype=np.float64)


def to_boat(points: ArrayLike, origin: ArrayLike, boat_axes: ArrayLike) -> NDArray[np.float64]:
    """The inverse of `to_world`: points (…, 3) east, north, up → starboard, forward, up of the foot of the mast."""
    away = np.asarray(points, dtype=np.float64) - np.asarray(origin, dtype=np.float64)
    return np.einsum("...i,...ji->...j", away, np.asarray(boat_axes))


def _even_directions() -> NDArray[np.float64]:
    """(_DIRECTIONS, 3) unit vectors, evenly spread by the golden angle."""
    up = 1.0 - (2.0 * np.arange(_DIRECTIONS) + 1.0) / _DIRECTIONS
    turn = np.pi * (3.0 - np.sqrt(5.0)) * np.arange(_DIRECTIONS)
    level = np.sqrt(1.0 - up * up)
    return np.stack((level * np.cos(turn), level * np.sin(turn), up), axis=1)
