"""A polar mesh of one turn: radial lines meshed at the moment when the beam passes them, rungs at equal ground ranges.

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

from dataclasses import dataclass
from functools import cached_property
from pathlib import Path
from typing import Protocol, overload

import numpy as np
from numpy.typing import NDArray
from trimesh import Trimesh

from ..conventions import unit_from_azimuth
from ..radar.array import antenna_array
from ..radar.mast import ArrayPose, Mast, column_frame
from ..radar.scan import BEAMS_BEYOND, sector_width
from ..radar.waveform import RangeResponse
from ..settings import RadarSettings, TracingSettings
from .facet_kernel import fill_facets, fill_strain, in_blocks
from .sizing import radar_detail

FAR_FRACTION, NEAR_FRACTION = 1.0 / 3.0, 2.0 / 3.0
_INNERMOST = 1.0  # m, ground range of the first rung


class MovingSurface(Protocol):
    """What the mesher asks of a sea."""

    def elevation_and_velocity(
        self, x: NDArray[np.float64], y: NDArray[np.float64], t: NDArray[np.float64]
    ) -> tuple[NDArray[np.float64], NDArray[np.float32]]: ...


class StrainingSurface(MovingSurface, Protocol):
    """… of one whose long waves strain the short ones."""

    def elevation_velocity_and_relaxed_shift(
        self, x: NDArray[np.float64], y: NDArray[np.float64], t: NDArray[np.float64], rate: float
    ) -> tuple[NDArray[np.float64], NDArray[np.float32], NDArray[np.float32]]: ...


@dataclass(frozen=True)
class PolarGrid:
    """Lines and rungs of one turn. Lines are numbered from `first`; line 0 starts the sector."""

    turn: int
    spacing_deg: float  # between neighbouring lines
    first: int  # number of the first line (negative: it lies before the sector)
    per_circle: int  # columns of a full circle: makes column numbers unique over turns
    sweep: NDArray[np.float64]  # (line,) deg from the start of the sector
    azimuth: NDArray[np.float64]  # (line,) deg, not wrapped
    time: NDArray[np.float64]  # (line,) s, when the boresight passes the line
    ground_range: NDArray[np.float64]  # (rung,) m
    pose: ArrayPose  # (line,) of the antennas at those times
    column_pose: ArrayPose  # (column,)
    drift: NDArray[np.float64]  # (column, antenna, 3) m/s of the antennas along the column, across it, up
    reach_deg: float  # to either side of the boresight, within which the beam hears something

    @property
    def columns(self) -> int:
        return self.sweep.size - 1

    @cached_property
    def column_sweep(self) -> NDArray[np.float64]:
        """Sweep of the columns' middles (deg)."""
        return 0.5 * (self.sweep[1:] + self.sweep[:-1])

    @cached_property
    def column_time(self) -> NDArray[np.float64]:
        return 0.5 * (self.time[1:] + self.time[:-1])

    @cached_property
    def column_azimuth(self) -> NDArray[np.float64]:
        return 0.5 * (self.azimuth[1:] + self.azimuth[:-1])

    @cached_property
    def column_height(self) -> NDArray[np.float64]:
        """(column, 1) m, of the frame's origin above mean sea level."""
        return self.column_pose.origin[:, 2:]

    @cached_property
    def places(self) -> NDArray[np.float64]:
        """(column, antenna, 3) m, the antennas from the frame's origin: along the column, across it, up."""
        return self._in_columns(self.column_pose.places)

    @cached_property
    def array_up(self) -> NDArray[np.float64]:
        """(column, 3) unit vector up the array: along the column, across it, up."""
        return self._in_columns(self.column_pose.axes[:, 2:])[:, 0]

    def _in_columns(self, vectors: NDArray[np.float64]) -> NDArray[np.float64]:
        """Vectors (column, n, 3) east north up as along, across, up."""
        return np.einsum("cij,cnj->cni", column_frame(self.column_azimuth), vectors)

    @cached_property
    def place_azimuth(self) -> NDArray[np.float64]:
        """(line,) deg, the azimuth within one circle: lines over the same place have the same bits in every turn."""
        line = np.rint(self.sweep / self.spacing_deg).astype(np.int64)
        return (self.azimuth[0] - self.sweep[0]) + self.spacing_deg * (line % self.per_circle)

    @property
    def column_number(self) -> NDArray[np.int64]:
        """A number for each column that stays the same where the end of a turn is the start of the next."""
        return (self.turn + 1) * self.per_circle + self.first + np.arange(self.columns, dtype=np.int64)


def polar_grid(radar: RadarSettings, tracing: TracingSettings, turn: int, mast: Mast | None = None) -> PolarGrid:
    """The grid of a turn: columns a fraction of the beam wide, rungs equally far apart over the range window.

    mast: where the antennas are; left out, on a boat at rest.
    """
    mast, array, detail = mast or Mast(radar), antenna_array(radar), radar_detail(radar, tracing)
    per_circle = int(np.ceil(360.0 / (array.narrowest_beam_deg / detail.columns_per_beam)))
    spacing = 360.0 / per_circle
    sector = np.linspace(0.0, sector_width(radar) / 360.0, 721)
    scanned = (turn + sector) * mast.period
    mast.check_that_it_sweeps(scanned)
    # The fan of a heeled mast hears the near range well off its bearing.
    lean = mast.lean_deg(scanned, float(np.arcsin(min(1.0, radar.height_m / radar.range_m[0]))))
    # In whole degrees: a column that two turns hear keeps its speckle while both ask for it equally long.
    reach = BEAMS_BEYOND * array.beam_deg + np.ceil(lean - 1e-9)
    # Rounding of a long run's angles is no swing.
    beyond = int(np.ceil((reach + np.abs(mast.swing(scanned)).max()) / spacing - 1e-6))
    # From the foot of the mast on, though the gates may start further out: what is near can shadow what is far.
    far = radar.range_m[1] + RangeResponse.of(radar).support_m
    rungs = int(np.ceil((far - _INNERMOST) / detail.facet_m)) + 1
    if radar.scan == "staring":
        middle = round(0.5 * sector_width(radar) / spacing)
        line = np.arange(middle - beyond, middle + beyond + 1)
        time = column_time = (turn + 0.5) * mast.period  # the sea as it is half-way
        time, column_time = np.full(line.size, time), np.full(line.size - 1, column_time)
    else:
        inside = int(np.ceil(sector_width(radar) / spacing - 1e-9))
        line = np.arange(-beyond, inside + beyond + 1)
        nominal = (turn * per_circle + line) / per_circle * mast.period  # the same bits where a turn meets the next
        time = mast.passing(spacing * line.astype(np.float64), nominal)
        column_time = 0.5 * (time[1:] + time[:-1])
    sweep = spacing * line.astype(np.float64)
    middles = mast.pose(column_time)
    azimuth = radar.sector_deg[0] + sweep
    frame = column_frame(0.5 * (azimuth[1:] + azimuth[:-1]))
    return PolarGrid(
        turn=turn,
        spacing_deg=spacing,
        first=int(line[0]),
        per_circle=per_circle,
        sweep=sweep,
        azimuth=azimuth,
        time=time,
        ground_range=_INNERMOST + detail.facet_m * np.arange(rungs, dtype=np.float64),
        pose=mast.pose(time),
        column_pose=middles,
        drift=np.einsum("cij,caj->cai", frame, mast.velocity(column_time)),
        reach_deg=reach,
    )


@dataclass(frozen=True)
class SurfaceMesh:
    """The triangulated sea of one turn, in a frame centred on the middle of the array at each column's own time."""

    grid: PolarGrid
    elevation: NDArray[np.float64]  # (line, rung) m above mean sea level
    velocity_look: NDArray[np.float32]  # (line, rung) m/s, horizontal, outward
    velocity_up: NDArray[np.float32]  # (line, rung) m/s
    relaxed_shift: NDArray[np.float32] | None = None  # (line, rung, 2) m east north, if the strain is wanted

    def sheets(self) -> list[tuple[slice, ...]]:
        """Column slices grouped so that those of a group do not overlap in azimuth.

        The first group is the turn itself. Further ones, where the turn overlaps its own beginning, are what runs on
        beyond it: the same places at other times, which must not be traced together with the first.
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
        """Write the turn as PLY or GLB, by the file's ending."""
        path = Path(path)
        if path.suffix.lower() not in (".ply", ".glb"):
            raise ValueError(f"mesh file '{path}': the ending must be .ply or .glb")
        self.world_trimesh.export(path)
        return path

    @cached_property
    def facets(self) -> Facets:
        """The facets' geometry."""
        return _facets(self)

    @cached_property
    def strain(self) -> NDArray[np.float32] | None:
        """(column, facet) −∂D/∂l of the relaxed shift D along the look l: > 0 where short waves crowd. None where the
        mesh was made without the shift."""
        return None if self.relaxed_shift is None else _strain(self.relaxed_shift, self.grid)


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


@overload
def sea_on_grid(
    sea: MovingSurface, grid: PolarGrid, rate: None = None
) -> tuple[NDArray[np.float64], NDArray[np.float32]]: ...
@overload
def sea_on_grid(
    sea: StrainingSurface, grid: PolarGrid, rate: float
) -> tuple[NDArray[np.float64], NDArray[np.float32], NDArray[np.float32]]: ...
def sea_on_grid(sea, grid: PolarGrid, rate: float | None = None):
    """Elevation (line, rung) m and velocity (line, rung, 3) m/s, each line at the time when the beam passes it.

    With the rate [1/s] at which short waves relax also their relaxed shift (line, rung, 2) m, for `SurfaceMesh.strain`.
    """
    east, north = unit_from_azimuth(grid.place_azimuth)
    x = grid.pose.origin[:, :1] + east[:, None] * grid.ground_range
    y = grid.pose.origin[:, 1:2] + north[:, None] * grid.ground_range
    t = np.broadcast_to(grid.time[:, None], x.shape)
    if rate is None:
        return sea.elevation_and_velocity(x, y, t)
    return sea.elevation_velocity_and_relaxed_shift(x, y, t, rate)


def surface_mesh(
    grid: PolarGrid,
    elevation: NDArray[np.float64],
    velocity: NDArray[np.float32],
    relaxed_shift: NDArray[np.float32] | None = None,
) -> SurfaceMesh:
    """The mesh of a turn from the sea on its grid."""
    east, north = (axis[:, None].astype(np.float32) for axis in unit_from_azimuth(grid.azimuth))
    look = (velocity[..., 0] * east + velocity[..., 1] * north).astype(np.float32, copy=False)
    up = np.ascontiguousarray(velocity[..., 2])
    return SurfaceMesh(grid, elevation, look, up, relaxed_shift)


def mesh_turn(sea: MovingSurface, radar: RadarSettings, tracing: TracingSettings, turn: int) -> SurfaceMesh:
    """Mesh the sea of one turn, without the strain of short waves."""
    grid = polar_grid(radar, tracing, turn)
    return surface_mesh(grid, *sea_on_grid(sea, grid))


def submerged_lines(mesh: SurfaceMesh, sea: MovingSurface) -> NDArray[np.bool_]:
    """(line,): the sea covers a phase centre, at its own place, when the beam passes the line."""
    pose = mesh.grid.pose
    centres = pose.positions
    # The first rung lies a metre from the mast: where the sea stays two metres below the antennas there, it does not
    # reach them (that would be a slope of 2), and need not be asked for.
    away = float(np.abs(pose.places[..., :2]).max()) + _INNERMOST
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


def triangulation(widths: tuple[int, ...], rungs: int) -> NDArray[np.int32]:
    """Faces (m, 3) of slices so many columns wide: the numbers of their vertices. They are the same for all seas."""
    whole, offset = [], 0
    for columns in widths:
        corner = np.arange(columns)[:, None] * rungs + np.arange(rungs - 1) + offset
        near, far = (0, rungs, rungs + 1), (0, rungs + 1, 1)
        whole.append((corner[..., None] + np.array((*near, *far))).astype(np.int32).reshape(-1, 3))
        offset += (columns + 1) * rungs
    return np.concatenate(whole)


# ------------------------------------------------------------------------------------------------- profiles


def chord_point(fraction: float, spacing_deg: float) -> tuple[float, float]:
    """Distance (of a rung at 1 m) and angle (rad from the first line) at which a plane cuts a rung's chord."""
    angle = np.radians(spacing_deg)
    across, along = fraction * np.sin(angle), 1.0 - fraction + fraction * np.cos(angle)
    return float(np.hypot(across, along)), float(np.arctan2(across, along))


@dataclass(frozen=True)
class Plane:
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


@dataclass(frozen=True)
class Profile:
    """The triangulated surface along one plane of every column: rungs and diagonals, alternating outward."""

    rung_distance: NDArray[np.float64]  # (rung,)
    diagonal_distance: NDArray[np.float64]  # (rung − 1,)
    rung_height: NDArray[np.float64]  # (column, rung)
    diagonal_height: NDArray[np.float64]  # (column, rung − 1)


def profile(elevation: NDArray[np.float64], grid: PolarGrid, fraction: float) -> Profile:
    """The profile at `fraction` of each column's width, from the lines' elevations (line, rung). Exact."""
    plane = Plane.of(grid, fraction)
    first, second = elevation[:-1], elevation[1:]
    return Profile(
        rung_distance=plane.rung_distance,
        diagonal_distance=plane.diagonal_distance,
        rung_height=(1.0 - fraction) * first + fraction * second,
        diagonal_height=(1.0 - plane.share) * first[:, :-1] + plane.share * second[:, 1:],
    )


def _interleave(near: NDArray, far: NDArray) -> NDArray:
    """near, far, near, far … along the last axis."""
    return np.stack((near, far), axis=-1).reshape(*near.shape[:-1], -1)


def _facets(mesh: SurfaceMesh) -> Facets:
    grid, z = mesh.grid, mesh.elevation
    ranges = grid.ground_range
    step = np.diff(ranges)
    half = 0.5 * np.radians(grid.spacing_deg)
    near, far = (Plane.of(grid, fraction) for fraction in (NEAR_FRACTION, FAR_FRACTION))
    double_area = np.sin(2.0 * half) * step  # twice the area of a triangle per metre of its rung edge
    shape = grid.columns, 2 * step.size
    height = np.empty(shape)
    slope_look, slope_cross, velocity_look, velocity_up = (np.empty(shape, dtype=np.float32) for _ in range(4))
    in_blocks(
        lambda *block: fill_facets(
            *block, z, near.fraction, near.share, far.fraction, far.share, 2.0 * ranges * np.sin(half), step, half,
            height, slope_look, slope_cross,
            mesh.velocity_look, mesh.velocity_up, velocity_look, velocity_up,
        ),
        grid.columns,
    )  # fmt: skip
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


def _strain(relaxed_shift: NDArray[np.float32], grid: PolarGrid) -> NDArray[np.float32]:
    """−∂D/∂l (column, facet) of the relaxed shift D along each column's look l."""
    step, half = np.diff(grid.ground_range), 0.5 * np.radians(grid.spacing_deg)
    look, chord = np.stack(unit_from_azimuth(grid.column_azimuth), axis=1), 2.0 * grid.ground_range * np.sin(half)
    strain = np.empty((grid.columns, 2 * step.size), dtype=np.float32)
    in_blocks(lambda *block: fill_strain(*block, relaxed_shift, look, chord, step, half, strain), grid.columns)
    return strain
