"""The objects of a scene: the sea that they hide, and what they echo themselves.

Those fixed to the world stand still in it; those fixed to the boat turn and heave with it, and stand still in its axes:
starboard, forward, up, from the foot of the mast at the waterline.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from ..conventions import SPEED_OF_LIGHT, unit_from_azimuth, wrap_degrees
from ..errors import InputError
from ..io.meshfile import load_mesh
from ..mesh import Facets, SurfaceMesh
from ..radar.installation import ArrayPose, Installation
from ..radar.pose import boat_axes
from ..radar.scan import Pulses
from ..scene import Scene
from ..tracing import Illumination
from ..tracing.horizon import Skyline
from ..tracing.objects import Occluder, placed, refuse_if_enclosing, to_boat, to_world
from .objects import EchoingObject, objects_in_sight, passing
from .scatterers import scatterer_voltages

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
        if self.there:
            self._refuse_if_enclosing()

    @property
    def there(self) -> bool:
        """Whether the scene has any objects."""
        return bool(self._world.occluder.bodies or self._boat.occluder.bodies)

    def _refuse_if_enclosing(self) -> None:
        moments = min(_MOMENTS * self._scene.turns, _MOST_MOMENTS) + 1
        track = self._installation.pose(np.linspace(0.0, self._scene.turns * self._installation.period, moments))
        try:
            refuse_if_enclosing(self._world.occluder, track.positions)
            refuse_if_enclosing(self._boat.occluder, self._aboard(track, track.positions))
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

    def _aboard(self, pose: ArrayPose, points: NDArray[np.float64]) -> NDArray[np.float64]:
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
        if not self.there:
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
            """Over the sea, and past the boat's own structure."""
            seen = skyline.sees(eyes, ends)
            if self._boat.occluder.bodies:
                at = passing(ends, pose.origin, pulses.azimuth)
                here = self._aboard(pose[at], np.stack((eyes, ends), axis=1))
                seen &= ~self._boat.occluder.blocked(here[:, 0], here[:, 1])
            return seen

        if aboard:
            centres = self._aboard(pose, centres)
            azimuth = azimuth - pose.attitude[:, 2]
        points, areas, sight = objects_in_sight(
            frame.echoing,
            frame.occluder,
            (lambda eyes, ends: np.ones(len(ends), dtype=bool)) if aboard else sees,
            centres,
            azimuth,
            wavelength_m=SPEED_OF_LIGHT / installation.radar.frequency_hz,
            seed=self._scene.seed,
        )
        if not aboard:
            return scatterer_voltages(installation, pulses, points, areas, np.zeros_like(points), sight=sight)
        # A point of the boat goes with it: where it is when the beam passes it, and as fast.
        time = np.interp(_bearing(points), *_by_bearing(azimuth, pulses.time))
        before, now, after = (
            to_world(points, *self._foot(self._installation.pose(time + late)))
            for late in (-0.5 * _STEP, 0.0, 0.5 * _STEP)
        )
        speeds = (after - before) / _STEP
        return scatterer_voltages(installation, pulses, now - speeds * time[:, None], areas, speeds, sight=sight)


def _bearing(points: NDArray[np.float64]) -> NDArray[np.float64]:
    return np.degrees(np.arctan2(points[:, 0], points[:, 1])) % 360.0


def _by_bearing(
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
