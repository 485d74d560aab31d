"""The triangulated sea of one turn, as a trimesh, on the polar grid."""

from __future__ import annotations

from dataclasses import dataclass, replace
from functools import cached_property
from pathlib import Path
from typing import Protocol

import numpy as np
from numpy.typing import NDArray
from trimesh import Trimesh

from ..conventions import unit_from_azimuth
from ..radar.installation import Installation
from ..sea import Sea
from ..settings import RadarSettings, TracingSettings
from .facets import Facets, facets_of, strain_of, velocities_of
from .grid import INNERMOST_M, PolarGrid, polar_grid

ACROSS = 1.0 / 36.0  # see SurfaceMesh.levelled


class MovingSurface(Protocol):
    """What the mesher needs of a sea: points x, y [m] and times t [s] (…) → elevation (…) m and velocity (…, 3) m/s."""

    def elevation_and_velocity(
        self, x: NDArray[np.float64], y: NDArray[np.float64], t: NDArray[np.float64]
    ) -> tuple[NDArray[np.float64], NDArray[np.float32]]: ...


@dataclass(frozen=True)
class SurfaceMesh:
    """The triangulated sea of one turn, in a frame centred on the middle of the array at each column's own time."""

    grid: PolarGrid
    elevation: NDArray[np.float64]  # (line, rung) m above mean sea level
    velocity_look: NDArray[np.float32]  # (line, rung) m/s, horizontal, outward
    velocity_up: NDArray[np.float32]  # (line, rung) m/s
    relaxed_shift: NDArray[np.float32] | None = None  # (line, rung, 2) m east north, if the strain is wanted
    facet_velocity: tuple[NDArray[np.float32], NDArray[np.float32]] | None = None  # outward and up, where it is known

    def sheets(self) -> list[tuple[slice, ...]]:
        """Column slices grouped so that those of a group do not overlap in azimuth.

        The first group is the turn itself. Further ones, where the turn overlaps its own beginning, are what runs on
        beyond it: the same ground at other times, which must not be traced together with the first.
        """
        grid = self.grid
        if grid.columns <= grid.per_circle:
            return [(slice(0, grid.columns),)]
        start = -grid.first
        stop = min(start + grid.per_circle, grid.columns)  # a sector just short of the circle runs on for less
        rest = [each for each in (slice(0, start), slice(stop, grid.columns)) if each.stop > each.start]
        if grid.columns - (stop - start) > grid.per_circle:  # a boat that swings far off its heading
            return [(slice(start, stop),), *((each,) for each in rest)]
        return [(slice(start, stop),), tuple(rest)]

    @property
    def upright(self) -> bool:
        """All antennas stand in the mast's axis: a ray from them never leaves its column."""
        return not self.grid.antenna_positions[..., :2].any()

    def part(self, columns: slice) -> SurfaceMesh:
        """Neighbouring columns alone: their facets are those of the whole, bit by bit."""
        if columns == slice(0, self.grid.columns):
            return self
        lines = slice(columns.start, columns.stop + 1)
        look, up = self.velocities
        return SurfaceMesh(
            self.grid.part(columns),
            self.elevation[lines],
            self.velocity_look[lines],
            self.velocity_up[lines],
            None if self.relaxed_shift is None else self.relaxed_shift[lines],
            (look[columns], up[columns]),
        )

    def levelled_part(self, columns: slice) -> SurfaceMesh:
        """`levelled.part(columns)`, for which no more is levelled than those columns and their neighbours."""
        begin, end = max(columns.start - 1, 0), min(columns.stop + 1, self.grid.columns)
        return self.part(slice(begin, end)).levelled.part(slice(columns.start - begin, columns.stop - begin))

    def trimesh(self, sheet: tuple[slice, ...]) -> Trimesh:
        """The surface of a sheet in the antennas' frame, east, north, up [m]; faces counter-clockwise from above.

        Slices are not joined. Faces come column by column and from near to far, near facet before far facet.
        """
        return as_trimesh(self.vertices(sheet), triangulation(widths(sheet), self.grid.ground_range.size))

    def vertices(self, sheet: tuple[slice, ...]) -> NDArray[np.float64]:
        """(n, 3) m, those of `trimesh`: line by line, from near to far."""
        ranges = self.grid.ground_range
        whole = []
        for columns in sheet:
            lines = slice(columns.start, columns.stop + 1)
            east, north = unit_from_azimuth(self.grid.azimuth[lines])
            vertices = np.empty((east.size, ranges.size, 3))
            np.multiply(east[:, None], ranges, out=vertices[..., 0])
            np.multiply(north[:, None], ranges, out=vertices[..., 1])
            np.subtract(self.elevation[lines], self.grid.pose.origin[lines, 2:], out=vertices[..., 2])
            whole.append(vertices.reshape(-1, 3))
        return np.concatenate(whole) if len(whole) > 1 else whole[0]

    @cached_property
    def world_trimesh(self) -> Trimesh:
        """The surface of the turn, east, north and up of mean sea level in the world [m]."""
        (columns,) = self.sheets()[0]
        surface = self.trimesh((columns,))
        origin = self.grid.pose.origin[columns.start : columns.stop + 1]
        vertices = (surface.vertices.reshape(origin.shape[0], -1, 3) + origin[:, None]).reshape(-1, 3)
        return as_trimesh(vertices, surface.faces)

    def write(self, path: str | Path) -> Path:
        """Write the turn, in the world, as PLY or GLB by the file's ending. ValueError for any other ending."""
        path = Path(path)
        if path.suffix.lower() not in (".ply", ".glb"):
            raise ValueError(f"mesh file '{path}': the ending must be .ply or .glb")
        self.world_trimesh.export(path)
        return path

    @property
    def levelled(self) -> SurfaceMesh:
        """The mesh by which light is judged: its chords are, on the average, as high as the water.

        Between points of the water h apart, where it has the curvature z″, the mean of the chord lies z″h²/12 below
        that of the water. So crests would be too low to hide what they hide, and troughs too high to be hidden: a radar
        would see up to 8 % more of a wind sea than it does. The vertices are raised by as much, z″h² being
        the second difference along the look. Across it chords cut crests too, but facets take their slopes from either
        line in turn, which makes up for most of that: what is left is a thirty-sixth of the second difference, found on
        three seas and held to on others (`validation/light/share.py`). The share that is seen is then right to 2 %.

        Heights and slopes of the water are those of `facets`: vertices here do not lie on it. The velocities are the
        same. It is made anew each time, and so held no longer than it is used.
        """
        elevation = self.elevation.copy()
        elevation[1:-1] -= ACROSS * np.diff(self.elevation, 2, axis=0)
        elevation[:, 1:-1] -= np.diff(elevation, 2, axis=1) / 12.0
        return replace(self, elevation=elevation, facet_velocity=self.velocities)

    @cached_property
    def velocities(self) -> tuple[NDArray[np.float32], NDArray[np.float32]]:
        """(column, facet) m/s of the facets' water, outward and up."""
        return self.facet_velocity or velocities_of(self.velocity_look, self.velocity_up)

    @cached_property
    def facets(self) -> Facets:
        """The facets' geometry."""
        return facets_of(self.grid, self.elevation, self.velocities)

    @cached_property
    def strain(self) -> NDArray[np.float32] | None:
        """(column, facet) −∂D/∂l of the relaxed shift D along the look l: > 0 where short waves crowd. None where the
        mesh was made without the shift."""
        return None if self.relaxed_shift is None else strain_of(self.relaxed_shift, self.grid)


def sea_on_grid(
    sea: MovingSurface | Sea, grid: PolarGrid, rate: float | None = None
) -> tuple[NDArray[np.float64], NDArray[np.float32], NDArray[np.float32] | None]:
    """Elevation (line, rung) m and velocity (line, rung, 3) m/s, each line at the time when the beam passes it.

    With the rate [1/s] at which short waves relax also their relaxed shift (line, rung, 2) m, for `SurfaceMesh.strain`.
    """
    east, north = unit_from_azimuth(grid.circle_azimuth)
    x = grid.pose.origin[:, :1] + east[:, None] * grid.ground_range
    y = grid.pose.origin[:, 1:2] + north[:, None] * grid.ground_range
    t = np.broadcast_to(grid.time[:, None], x.shape)
    if rate is None or not isinstance(sea, Sea):
        return *sea.elevation_and_velocity(x, y, t), None
    return sea.elevation_velocity_and_relaxed_shift(x, y, t, rate)


def surface_mesh(
    grid: PolarGrid,
    elevation: NDArray[np.float64],
    velocity: NDArray[np.float32],
    relaxed_shift: NDArray[np.float32] | None = None,
) -> SurfaceMesh:
    """The mesh of a turn from the sea on its grid.

    elevation (line, rung) m, velocity (line, rung, 3) m/s east north up, relaxed_shift (line, rung, 2) m east north; as
    `sea_on_grid` gives them.
    """
    # Kernels are compiled for each layout of memory that they meet. A sea gives the elevation as a row of all that it
    # was asked for, five sixths of which a large mesh should not hold.
    elevation = np.require(elevation, np.float64, ("C", "W", "O") if len(grid.parts) > 1 else ("C", "W"))
    velocity = np.require(velocity, np.float32, ["C", "W"])
    east, north = (axis[:, None].astype(np.float32) for axis in unit_from_azimuth(grid.azimuth))
    look = (velocity[..., 0] * east + velocity[..., 1] * north).astype(np.float32, copy=False)
    up = np.ascontiguousarray(velocity[..., 2])
    return SurfaceMesh(grid, elevation, look, up, relaxed_shift)


def mesh_turn(sea: MovingSurface, radar: RadarSettings, tracing: TracingSettings, turn: int) -> SurfaceMesh:
    """Mesh the sea of one turn, without the strain of short waves."""
    grid = polar_grid(Installation(radar), tracing, turn)
    return surface_mesh(grid, *sea_on_grid(sea, grid))


def submerged_lines(mesh: SurfaceMesh, sea: MovingSurface) -> NDArray[np.bool_]:
    """(line,): the sea covers a phase centre, where it stands, when the beam passes the line."""
    pose = mesh.grid.pose
    centres = pose.positions
    # The first rung lies a metre from the mast: where the sea stays two metres below the antennas there, it does not
    # reach them (that would be a slope of 2), and need not be evaluated.
    away = float(np.abs(pose.offsets[..., :2]).max()) + INNERMOST_M
    if mesh.elevation[:, 0].max() + 2.0 * away < centres[..., 2].min():
        return np.zeros(mesh.grid.sweep.size, dtype=bool)
    time = np.broadcast_to(mesh.grid.time[:, None], centres.shape[:2])
    elevation, _ = sea.elevation_and_velocity(centres[..., 0], centres[..., 1], time)
    return np.any(elevation >= centres[..., 2], axis=1)


def as_trimesh(vertices: NDArray[np.float64], faces: NDArray[np.integer]) -> Trimesh:
    """The surface as trimesh holds it, unchanged: nothing is merged, dropped or copied.

    trimesh keeps faces as int64, into which int32 are cast: 1 ms of a turn of `choppy_sea`. To hold them so from the
    start would cost as much, for twice the bytes are then moved.
    """
    return Trimesh(vertices=vertices, faces=faces, process=False, validate=False)


def widths(sheet: tuple[slice, ...]) -> tuple[int, ...]:
    """How many columns each slice has."""
    return tuple(columns.stop - columns.start for columns in sheet)


def triangulation(widths: tuple[int, ...], rungs: int, chosen: NDArray[np.bool_] | None = None) -> NDArray[np.int32]:
    """Faces (m, 3) of slices so many columns wide: the numbers of their vertices. They are the same for all seas.

    chosen (column, facet): of these facets alone.
    """
    whole, begin, offset = [], 0, 0
    for columns in widths:
        if chosen is None:
            number = np.arange(columns * 2 * (rungs - 1), dtype=np.int32)
        else:
            number = np.flatnonzero(chosen[begin : begin + columns]).astype(np.int32)
        column, facet = np.divmod(number, 2 * (rungs - 1))
        corner, far = offset + column * rungs + facet // 2, facet % 2
        second = corner + rungs + far  # of a near facet along its rung, of a far one over the diagonal
        whole.append(np.stack((corner, second, corner + rungs * (1 - far) + 1), axis=1))
        begin, offset = begin + columns, offset + (columns + 1) * rungs
    return np.concatenate(whole, dtype=np.int32)
