"""Light by Sionna's PathSolver: its line-of-sight paths from an antenna to a receiver at each facet's point.

The independent reference: nothing but the scene is handed over, and what comes back is which receivers have a path. The
receivers are the elements of one array, each of them a target of its own; Python objects by the hundred thousand would
take hours. A receiver stands on the ray to its facet's point, _BEFORE of a rung spacing before it, still over or under
the facet itself. So no offset of the receiver moves a shadow: what hides it hides the point, and the only facet that
could hide the point and not it is its own.

PathSolver's order of paths, and with specular chains their choice, depends on which thread comes first, unless it is
built `deterministic`; here it is.
"""

from __future__ import annotations

import importlib
from collections.abc import Iterator
from typing import Any

import numpy as np
from numpy.typing import NDArray

from ..compute.backend import prepare
from ..conventions import unit_from_azimuth
from ..mesh import Facets, PolarGrid, SurfaceMesh
from ..settings import RadarSettings
from .illumination import Illumination, mitsuba_mesh

Array = NDArray[np.float64]
_BEFORE = 0.2  # of the rung spacing: a point lies 1/3 of it inside its facet along the look
_BATCH = 200_000  # receivers at a time
_SAME_POSITION = 6  # decimals of a metre: antennas closer than float32 can tell at 10 m are one
_SECONDS_A_CALL, _SECONDS_A_FACET, _MOST_SECONDS = 0.04, 2e-6, 3600.0


class PathsTracer:
    """Traces meshes by PathSolver. Each position of an antenna is a call: a mast that leans or moves has one a column.

    On two cores some 1.2 s for a million facets and antennas, and 0.04 s a call.
    """

    def __init__(self, radar: RadarSettings) -> None:
        self._frequency_hz = radar.frequency_hz
        prepare()  # now, before anything is computed: without a backend there are no paths

    def __call__(self, mesh: SurfaceMesh) -> Illumination:
        """The mesh's facets, lit geometrically. ValueError where that would take hours."""
        facets, grid = mesh.facets, mesh.grid
        starts = antennas_east_north_up(grid)
        calls = [list(_group_columns(sheet, starts[:, a])) for sheet in mesh.sheets() for a in range(starts.shape[1])]
        _refuse_hours(sum(map(len, calls)), facets.height.size * starts.shape[1])
        facing = np.stack([_faces(facets, grid.antenna_positions[:, antenna]) for antenna in range(starts.shape[1])])
        lit = np.zeros_like(facing)
        points = _points(facets)
        spacing = np.repeat(np.diff(grid.ground_range), 2)
        for sheet in mesh.sheets():
            sight = LineOfSight(mesh, sheet, self._frequency_hz)
            for antenna in range(starts.shape[1]):
                for columns in _group_columns(sheet, starts[:, antenna]):
                    start = starts[columns[0], antenna]
                    lit[antenna, columns] = sight.sees(start, _move_towards(points[columns], start, spacing))
        # From under water PathSolver sees facets from behind.
        return Illumination.of(facets, lit & facing, lit.size)


class LineOfSight:
    """A Sionna scene of the sea alone, and PathSolver's free lines in it."""

    def __init__(self, mesh: SurfaceMesh, sheet: tuple[slice, ...], frequency_hz: float) -> None:
        self._scene = sea_scene(mesh, sheet, frequency_hz)
        self._rt: Any = importlib.import_module("sionna.rt")
        self._mi: Any = importlib.import_module("mitsuba")
        self._solver = self._rt.PathSolver(deterministic=True)
        self._scene.add(self._rt.Transmitter("antenna", position=[0.0, 0.0, 0.0]))
        self._scene.add(self._rt.Receiver("facets", position=[0.0, 0.0, 0.0]))

    def sees(self, start: Array, points: Array) -> NDArray[np.bool_]:
        """(…): nothing stands between start (3,) and the points (…, 3), all east, north, up of the frame's origin."""
        self._scene.get("antenna").position = self._mi.Point3f(*map(float, start))
        wavelength = float(np.array(self._scene.wavelength).item())  # points in wavelengths come back as they were
        normalized = (points.reshape(-1, 3) / wavelength).astype(np.float32)
        free = np.empty(len(normalized), dtype=bool)
        for first in range(0, len(normalized), _BATCH):
            batch = slice(first, first + _BATCH)
            free[batch] = self._free(normalized[batch])
        return free.reshape(points.shape[:-1])

    def _free(self, normalized: NDArray[np.float32]) -> NDArray[np.bool_]:
        element = self._scene.tx_array.antenna_pattern
        array = self._rt.AntennaArray(element, self._mi.Point3f(*map(np.ascontiguousarray, normalized.T)))
        self._scene.rx_array = array
        paths = self._solver(
            self._scene,
            max_depth=0,
            max_num_paths_per_src=len(normalized),
            samples_per_src=1,
            synthetic_array=False,
            specular_reflection=False,
            refraction=False,
        )
        return np.array(paths.valid, dtype=bool).reshape(len(normalized))


def sea_scene(mesh: SurfaceMesh, sheet: tuple[slice, ...], frequency_hz: float, **material: float) -> Any:
    """A Sionna scene of the sheet alone, of a radio material with these properties, isotropic antennas; Hz."""
    shape = mitsuba_mesh("sea", mesh.trimesh(sheet))
    rt: Any = importlib.import_module("sionna.rt")
    scene = rt.Scene()
    scene.frequency = frequency_hz
    scene.edit(add=rt.SceneObject(mi_mesh=shape, name="sea", radio_material=rt.RadioMaterial("sea-body", **material)))
    scene.tx_array = rt.PlanarArray(num_rows=1, num_cols=1, pattern="iso", polarization="V")
    scene.rx_array = scene.tx_array
    return scene


def antennas_east_north_up(grid: PolarGrid) -> Array:
    """(column, antenna, 3) m east, north, up of the frame's origin."""
    east, north = (part[:, None] for part in unit_from_azimuth(grid.column_azimuth))
    along, across, up = np.moveaxis(grid.antenna_positions, -1, 0)
    # Clockwise of the look (east, north) is (north, −east).
    return np.stack([along * east + across * north, along * north - across * east, up], axis=-1)


def _points(facets: Facets) -> Array:
    """(column, facet, 3) m east, north, up of the frame's origin."""
    east, north = unit_from_azimuth(facets.grid.column_azimuth[:, None] + np.degrees(facets.angle))
    return np.stack([east * facets.distance, north * facets.distance, facets.rise], axis=-1)


def _move_towards(points: Array, start: Array, spacing: Array) -> Array:
    """Those points moved _BEFORE × spacing (facet,) of ground towards the start."""
    back = start - points
    level = np.maximum(np.hypot(back[..., 0], back[..., 1]), spacing)
    return points + back * (_BEFORE * spacing / level)[..., None]


def _faces(facets: Facets, positions: Array) -> NDArray[np.bool_]:
    """(column, facet): the facet's plane passes below the antenna at positions (column, 3), and it lies before it."""
    along, above = positions[:, :1], positions[:, 2:]
    slope = facets.slope_look * np.cos(facets.angle) + facets.slope_cross * np.sin(facets.angle)
    reach = facets.distance - along
    return (reach > 0.0) & (slope * reach - (facets.rise - above) > 0.0)


def _group_columns(sheet: tuple[slice, ...], starts: Array) -> Iterator[NDArray[np.int64]]:
    """Numbers of those columns of a sheet that one antenna, starts (column, 3), sees from the same position."""
    columns = np.concatenate([np.arange(each.start, each.stop) for each in sheet])
    _, group = np.unique(np.round(starts[columns], _SAME_POSITION), axis=0, return_inverse=True)
    order = np.argsort(group.ravel(), kind="stable")
    yield from np.split(columns[order], np.flatnonzero(np.diff(group.ravel()[order])) + 1)


def _refuse_hours(calls: int, facets: int) -> None:
    seconds = calls * _SECONDS_A_CALL + facets * _SECONDS_A_FACET
    if seconds > _MOST_SECONDS:
        raise ValueError(
            f"tracer = paths: must end within {_MOST_SECONDS / 3600.0:g} h, and {facets} facets and antennas in "
            f"{calls} calls would take {seconds / 3600.0:.1f}; narrow radar.sector_deg, or trace by facets"
        )
