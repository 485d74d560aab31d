"""The facets of a polar mesh: their points, slopes and velocities, and the surface's profiles through those points.

Between two neighbouring lines lies a *column*. Each of its quadrilaterals is cut from the near corner of its first line
to the far corner of its second, which gives two facets per rung spacing:

    line i ──── A ────    "near" facet: rung j and the diagonal   (two corners on line i+1)
           ╲    far       "far"  facet: the diagonal and rung j+1 (two corners on line i)
     near    ╲
    line i+1 ────────

A vertical plane through the antenna's axis cuts every rung's chord of a column at the same fraction. The far facets are
tested and placed on the plane of fraction 1/3, the near ones on that of 2/3: within a facet each such point is the
middle of the plane's path, the centroid to order (spacing/range). So a whole column has just two profiles, each exact.
"""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import NamedTuple, Self

import numpy as np
from numpy.typing import NDArray

from ..compute.compiled import compiled
from ..compute.machine import run_blocks
from ..conventions import unit_from_azimuth
from .grid import PolarGrid


class Edges(NamedTuple):
    """Edges of the facets of a column."""

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


FAR_FRACTION, NEAR_FRACTION = 1.0 / 3.0, 2.0 / 3.0


@dataclass(frozen=True)
class Facets:
    """Where facets lie, how they lean, how their water moves: plain arrays, (facet,) along a column or (column, facet).

    A column's facets alternate near, far, near, far … outward. The point of a facet is where it is tested for light and
    from where its range is reckoned. Slopes are in the frame of the column's middle azimuth.
    """

    grid: PolarGrid
    distance: NDArray[np.float64]  # (facet,) m, horizontal, from the frame's origin
    horizontal_area: NDArray[np.float64]  # (facet,) m²
    angle: NDArray[np.float64]  # (facet,) rad, of the point from the column's middle azimuth, clockwise
    height: NDArray[np.float64]  # (column, facet) m above mean sea level
    slope_look: NDArray[np.float32]  # (column, facet)
    slope_cross: NDArray[np.float32]  # (column, facet)
    velocity_look: NDArray[np.float32]  # (column, facet) m/s
    velocity_up: NDArray[np.float32]  # (column, facet) m/s

    @property
    def rise(self) -> NDArray[np.float64]:
        """(column, facet) m above the frame's origin: below it, so mostly negative."""
        return self.height - self.grid.column_height

    def part(self, columns: slice) -> Self:
        """Neighbouring columns alone."""
        by_column = ("height", "slope_look", "slope_cross", "velocity_look", "velocity_up")
        return replace(self, grid=self.grid.part(columns), **{name: getattr(self, name)[columns] for name in by_column})


# ------------------------------------------------------------------------------------------------- profiles


def chord_point(fraction: float, spacing_deg: float) -> tuple[float, float]:
    """Distance (of a rung at 1 m) and angle (rad from the first line) at which a plane cuts a rung's chord."""
    angle = np.radians(spacing_deg)
    across, along = fraction * np.sin(angle), 1.0 - fraction + fraction * np.cos(angle)
    return float(np.hypot(across, along)), float(np.arctan2(across, along))


class Plane(NamedTuple):
    """Where a plane that cuts every chord of a column at one fraction meets its rungs and diagonals."""

    fraction: float
    rung_distance: NDArray[np.float64]  # (rung,) m
    diagonal_distance: NDArray[np.float64]  # (rung − 1,) m
    share: NDArray[np.float64]  # (rung − 1,) of the diagonal, from its near corner on the column's first line

    @classmethod
    def of(cls, grid: PolarGrid, fraction: float) -> Plane:
        ranges = grid.ground_range
        stretch, _ = chord_point(fraction, grid.spacing_deg)
        near, far = ranges[:-1], ranges[1:]
        # On the diagonal (1 − s) near·e₀ + s far·e₁ the plane asks for s far / ((1 − s) near + s far) = fraction.
        share = fraction * near / ((1.0 - fraction) * far + fraction * near)
        return cls(fraction, stretch * ranges, stretch * ((1.0 - share) * near + share * far), share)


# ------------------------------------------------------------------------------------------- from the surface


def _interleave(near: NDArray, far: NDArray) -> NDArray:
    """near, far, near, far … along the last axis."""
    return np.stack((near, far), axis=-1).reshape(*near.shape[:-1], -1)


def facets_of(
    grid: PolarGrid, elevation: NDArray[np.float64], velocity: tuple[NDArray[np.float32], NDArray[np.float32]]
) -> Facets:
    """The facets of a surface (line, rung) of that elevation [m].

    velocity: outward and up [m/s], of the facets (column, facet): `velocities_of` gives them.
    """
    ranges = grid.ground_range
    step = np.diff(ranges)
    half = 0.5 * np.radians(grid.spacing_deg)
    chord = 2.0 * ranges * np.sin(half)
    near, far = (Plane.of(grid, fraction) for fraction in (NEAR_FRACTION, FAR_FRACTION))
    double_area = np.sin(2.0 * half) * step  # twice the area of a triangle per metre of its rung edge
    shape = grid.columns, 2 * step.size
    height = np.empty(shape)
    slope_look, slope_cross = (np.empty(shape, dtype=np.float32) for _ in range(2))
    edges = Edges(chord, step, half)
    run_blocks(
        lambda *block: fill_planes(*block, elevation, near, far, edges, height, slope_look, slope_cross), grid.columns
    )
    velocity_look, velocity_up = velocity
    return Facets(
        grid=grid,
        distance=_interleave(
            0.5 * (near.rung_distance[:-1] + near.diagonal_distance),
            0.5 * (far.diagonal_distance + far.rung_distance[1:]),
        ),
        horizontal_area=_interleave(0.5 * double_area * ranges[:-1], 0.5 * double_area * ranges[1:]),
        angle=np.tile([chord_point(f, grid.spacing_deg)[1] - half for f in (NEAR_FRACTION, FAR_FRACTION)], step.size),
        height=height,
        slope_look=slope_look,
        slope_cross=slope_cross,
        velocity_look=velocity_look,
        velocity_up=velocity_up,
    )


def velocities_of(
    velocity_look: NDArray[np.float32], velocity_up: NDArray[np.float32]
) -> tuple[NDArray[np.float32], NDArray[np.float32]]:
    """Velocities of the facets (column, facet), from those of the lines (line, rung): outward and up, m/s."""
    columns, rungs = velocity_look.shape[0] - 1, velocity_look.shape[1]
    look, up = (np.empty((columns, 2 * (rungs - 1)), dtype=np.float32) for _ in range(2))

    def work(begin: int, end: int) -> None:
        fill_velocities(begin, end, velocity_look, look)
        fill_velocities(begin, end, velocity_up, up)

    run_blocks(work, columns)
    return look, up


def strain_of(relaxed_shift: NDArray[np.float32], grid: PolarGrid) -> NDArray[np.float32]:
    """−∂D/∂l (column, facet) of the relaxed shift D along each column's look l."""
    step, half = np.diff(grid.ground_range), 0.5 * np.radians(grid.spacing_deg)
    look, chord = np.stack(unit_from_azimuth(grid.column_azimuth), axis=1), 2.0 * grid.ground_range * np.sin(half)
    strain = np.empty((grid.columns, 2 * step.size), dtype=np.float32)
    run_blocks(lambda *block: fill_strain(*block, relaxed_shift, look, Edges(chord, step, half), strain), grid.columns)
    return strain
