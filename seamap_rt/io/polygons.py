"""Triangles of plane polygons: convex ones as fans, others by clipping their ears (Meisters 1975)."""

from __future__ import annotations

from typing import Any

import numpy as np
from numpy.typing import NDArray

_MOST_WORK = 1_000_000  # squares of the corners, of polygons that are not convex: some seconds


def triangles_of(vertices: NDArray[np.float64], polygons: Any) -> NDArray[np.int64]:
    """Corners (m, 3) of the triangles that polygons have, in their order. vertices: (n, 3).

    polygons: rows of places in `vertices`, three or more each. A polygon may lie anyhow in space and turn either way;
    its triangles turn the same way. Raises ValueError for a corner that is not there, and for too many
    polygons that are not convex.
    """
    lengths = np.array([len(each) for each in polygons], dtype=np.int64)
    ends = np.cumsum(np.maximum(lengths - 2, 0))
    found = np.empty((int(ends[-1]) if ends.size else 0, 3), dtype=np.int64)
    work = 0
    for count in np.unique(lengths[lengths > 2]):
        which = np.flatnonzero(lengths == count)
        corners = np.array([polygons[each] for each in which], dtype=np.int64)
        if corners.min() < 0 or corners.max() >= len(vertices):
            raise ValueError("a face has a corner that is not there")
        fan = np.stack([np.zeros(count - 2, dtype=np.int64), np.arange(1, count - 1), np.arange(2, count)], axis=-1)
        made = corners[:, fan]
        if count > 3:
            plane, convex = _in_their_planes(vertices[corners])
            work += count**2 * np.count_nonzero(~convex)
            if work > _MOST_WORK:
                raise ValueError("too many corners of faces that are not convex; triangulate them")
            for each in np.flatnonzero(~convex):
                made[each] = corners[each][_clip_ears(plane[each])]
        found[(ends[which] - (count - 2))[:, None] + np.arange(count - 2)] = made
    return found


def _in_their_planes(corners: NDArray[np.float64]) -> tuple[NDArray[np.float64], NDArray[np.bool_]]:
    """Polygons (n, k, 3) seen from where they turn anticlockwise, (n, k, 2), and which are convex."""
    with np.errstate(over="ignore", invalid="ignore"):
        about = corners - corners.mean(axis=1, keepdims=True)
        normal = np.cross(about, np.roll(about, -1, axis=1)).sum(axis=1)  # twice the area (Newell)
        flat = np.argmax(np.abs(normal), axis=1)
        axes = np.stack(((flat + 1) % 3, (flat + 2) % 3), axis=-1)
        plane = np.take_along_axis(about, axes[:, None, :], axis=2)
        mirrored = np.take_along_axis(normal, flat[:, None], axis=1)[:, 0] < 0.0
        plane[mirrored] = plane[mirrored][..., ::-1]
        sides = np.roll(plane, -1, axis=1) - plane
        after = np.roll(sides, -1, axis=1)
        turn = sides[..., 0] * after[..., 1] - sides[..., 1] * after[..., 0]
        return plane, ~(turn < -1e-9 * np.abs(turn).max(axis=1, keepdims=True)).any(axis=1)


def _clip_ears(place: NDArray[np.float64]) -> NDArray[np.int64]:
    """Triangles (k − 2, 3) of a polygon (k, 2) that turns anticlockwise. One that crosses itself has as many."""
    left, found, at, tried = list(range(len(place))), [], 0, 0
    least = 1e-12 * float(np.ptp(place, axis=0).max()) ** 2  # corners on one line, but for rounding, are no ear
    while len(left) > 2:
        a, b, c = (left[(at + step) % len(left)] for step in range(3))
        one, two = place[b] - place[a], place[c] - place[b]
        ear = _cross(one, two) > least and not np.any(
            (_cross(one, (others := place[left]) - place[a]) > 0.0)
            & (_cross(two, others - place[b]) > 0.0)
            & (_cross(one + two, others - place[a]) < 0.0)
        )
        if ear or tried >= len(left):  # none is left: of a line, or of a polygon that crosses itself
            found.append((a, b, c))
            del left[(at + 1) % len(left)]
            tried = 0
        else:
            at, tried = at + 1, tried + 1
    return np.array(found, dtype=np.int64)


def _cross(one: Any, two: Any) -> Any:
    """Of vectors (…, 2). Of one with itself it is exactly 0: a corner does not lie in a triangle of it."""
    return one[..., 0] * two[..., 1] - one[..., 1] * two[..., 0]
