"""What objects echo: points on the faces that look at the antenna, each with an equal share of the radar cross-section.

The points are drawn evenly over an object's surface and stay on it from turn to turn, as long as they look at the
antenna, so that an object at rest echoes steadily and one that moves fluctuates: each point's phase is that of its own
path. No real surface is smooth to half a wavelength. So each point stands out towards the antenna by a length of its
own within that; the mean power over all that these lengths can be is then the sum of the shares, for any shape and
aspect.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from typing import NamedTuple

import numpy as np
import trimesh
from numpy.typing import ArrayLike, NDArray

from ..conventions import from_db, wrap_degrees
from ..random_streams import Stream, branch
from ..settings import ObjectSettings
from ..tracing.objects import Occluder

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
        """None if the object echoes nothing."""
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
        face, points, rise = _drawn(random, corners, below / below[-1])
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


def _drawn(
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
        itself = occluder.alone(thing.number)
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
