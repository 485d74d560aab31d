"""The facets' geometry in one pass over the columns, a block of them to each thread."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from ..compute.compiled import compiled


class Edges(NamedTuple):
    """Of the facets of a column."""

    chord: NDArray[np.float64]  # (rung,) m, across the column
    step: NDArray[np.float64]  # (rung − 1,) m, along it
    half: float  # rad, half the column's width


@compiled
def fill_planes(begin, end, elevation, near_plane, far_plane, edges, height, slope_look, slope_cross):
    """Heights of the facets' points and their planes' slopes (column, facet).

    near_plane, far_plane: `facets.Plane` of the facets' points. A plane's slopes come from its rung edge (purely
    across, of length chord) and its radial edge (half a column askew).
    """
    chord, step, sine, cosine = edges.chord, edges.step, np.sin(edges.half), np.cos(edges.half)
    near_fraction, near_share = near_plane.fraction, near_plane.share
    far_fraction, far_share = far_plane.fraction, far_plane.share
    for column in range(begin, end):
        first, second = elevation[column], elevation[column + 1]
        for rung in range(step.size):
            near, far, out = 2 * rung, 2 * rung + 1, rung + 1
            diagonal = (1.0 - near_share[rung]) * first[rung] + near_share[rung] * second[out]
            height[column, near] = 0.5 * ((1.0 - near_fraction) * first[rung] + near_fraction * second[rung] + diagonal)
            diagonal = (1.0 - far_share[rung]) * first[rung] + far_share[rung] * second[out]
            height[column, far] = 0.5 * (diagonal + (1.0 - far_fraction) * first[out] + far_fraction * second[out])

            cross = (second[rung] - first[rung]) / chord[rung]
            slope_cross[column, near] = cross
            slope_look[column, near] = ((second[out] - second[rung]) / step[rung] - cross * sine) / cosine
            cross = (second[out] - first[out]) / chord[out]
            slope_cross[column, far] = cross
            slope_look[column, far] = ((first[out] - first[rung]) / step[rung] + cross * sine) / cosine


@compiled
def fill_velocities(begin, end, vertex, velocity):
    """The mean of a facet's corners (column, facet), of one component (line, rung)."""
    third = np.float32(1.0 / 3.0)
    for column in range(begin, end):
        first, second = vertex[column], vertex[column + 1]
        for rung in range(first.size - 1):
            shared = first[rung] + second[rung + 1]
            velocity[column, 2 * rung] = (shared + second[rung]) * third
            velocity[column, 2 * rung + 1] = (shared + first[rung + 1]) * third


@compiled
def fill_strain(begin, end, relaxed_shift, look, edges, strain):
    """−∂D/∂l of the relaxed shift D (line, rung, 2) along each column's look l (column, 2).

    All corners along the column's own look: each along its line's would make a uniform shift diverge by D/range.
    """
    chord, step, sine, cosine = edges.chord, edges.step, np.sin(edges.half), np.cos(edges.half)
    for column in range(begin, end):
        east, north = look[column]
        first, second = relaxed_shift[column], relaxed_shift[column + 1]
        near_cross = _component(second[0], first[0], east, north) / chord[0]
        for rung in range(step.size):
            out = rung + 1
            far_cross = _component(second[out], first[out], east, north) / chord[out]
            near_look = _component(second[out], second[rung], east, north) / step[rung]
            far_look = _component(first[out], first[rung], east, north) / step[rung]
            strain[column, 2 * rung] = (near_cross * sine - near_look) / cosine
            strain[column, 2 * rung + 1] = -(far_cross * sine + far_look) / cosine
            near_cross = far_cross


@compiled
def _component(to, start, east, north):
    return (to[0] - start[0]) * east + (to[1] - start[1]) * north
