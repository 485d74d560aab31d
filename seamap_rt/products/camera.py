"""Moments of the sea: its fields at points, and what the radar on its mast would see of them.

What the radar sees is of a snapshot: the mesh has one time everywhere, where a run's follows the beam.
"""

from __future__ import annotations

from dataclasses import replace
from importlib.metadata import version
from typing import Any

import numpy as np
import xarray as xr
from numpy.typing import NDArray

from ..conventions import db
from ..dataset import build
from ..echoes.radar_cross_section import SeaSurface, two_way_power
from ..mesh import PolarGrid, polar_grid, surface_mesh
from ..mesh.surface import sea_on_grid, submerged_lines
from ..radar.installation import Installation
from ..radar.scan import sector_width
from ..scene import Scene
from ..sea import Sea
from ..settings import RadarSettings
from ..tracing import Tracer
from .statistics import requested_height

OUTSIDE, DARK = -1, 0  # of `visible`, beside the number of antennas that see a point
FAINTEST_DB = -120.0  # of what is lit: a facet seen edge-on returns nothing
_BLOCK = 262_144  # points asked of the sea at a time


class Camera:
    """Takes moments of the sea at points of a square, and of what the radar would see of them in a snapshot."""

    def __init__(
        self, scene: Scene, sea: Sea, trace: Tracer, points: NDArray[np.float64], scatterer: SeaSurface
    ) -> None:
        """scatterer: how the run's sea scatters, its mean calibrated."""
        self.scene, self.sea, self.points = scene, sea, points
        self._trace, self._scatterer = trace, scatterer
        self._grid = polar_grid(Installation(scene.radar), scene.meshing, 0)
        x, y = np.meshgrid(points, points)
        self._inside, self._column, self._facet = locate_facets(self._grid, scene.radar, x, y)

    def moment(self, t: float) -> xr.Dataset:
        """The schema's `sea` at one time [s]."""
        names = ("sea_surface_height", "slope_x", "slope_y", "velocity_x", "velocity_y", "velocity_z")
        nrcs, visible = self._nrcs_and_visibility(t)
        values = dict(zip(names, self._surface(t), strict=True)) | {"nrcs_db": nrcs, "visible": visible}
        at = {"time": [t], "y": self.points, "x": self.points}
        fields = {name: value[None] for name, value in values.items()}
        dataset = build("sea", fields, at, _provenance(self.scene, self.sea))
        for name, attributes in _FURTHER_ATTRIBUTES.items():
            dataset[name].attrs.update(attributes)
        return dataset

    def _surface(self, t: float) -> NDArray[np.float32]:
        """Height, slopes and velocity (6, y, x)."""
        count = self.points.size
        fields = np.empty((6, count, count), dtype=np.float32)
        rows = max(1, _BLOCK // count)
        for start in range(0, count, rows):
            part = slice(start, start + rows)
            elevation, slopes, velocity = self.sea.elevation_slopes_and_velocity(
                self.points, self.points[part, None], t
            )
            fields[0, part] = elevation
            fields[1:3, part] = np.moveaxis(slopes, -1, 0)
            fields[3:6, part] = np.moveaxis(velocity, -1, 0)
        return fields

    def _nrcs_and_visibility(self, t: float) -> tuple[NDArray[np.float32], NDArray[np.int8]]:
        """NRCS [dB] of the facets over the points, NaN where none is lit, and how many antennas light them."""
        grid = replace(self._grid, time=np.full_like(self._grid.time, t))
        mesh = surface_mesh(grid, *sea_on_grid(self.sea, grid, self._scatterer.memory_rate))
        facets = self._trace(mesh.levelled)
        submerged = submerged_lines(mesh, self.sea)
        seen = facets.without((submerged[1:] | submerged[:-1])[:, None])
        arriving = 1.0 if seen.field is None else two_way_power(seen)
        sigma = self._scatterer(seen, mesh.strain).rcs * arriving / facets.horizontal_area
        antennas = seen.lit.sum(axis=0, dtype=np.int8)
        visible = np.full(self._inside.shape, OUTSIDE, dtype=np.int8)
        visible[self._inside] = antennas[self._column, self._facet]
        nrcs = np.full(self._inside.shape, np.nan, dtype=np.float32)
        nrcs[self._inside] = np.maximum(db(sigma[self._column, self._facet]), FAINTEST_DB)
        return np.where(visible > DARK, nrcs, np.float32(np.nan)), visible


def locate_facets(
    grid: PolarGrid, radar: RadarSettings, x: NDArray[np.float64], y: NDArray[np.float64]
) -> tuple[NDArray[np.bool_], NDArray[np.intp], NDArray[np.intp]]:
    """Which points (…) lie in the sector and the range window, and column and facet over each of those, (n,). Exact."""
    ground = np.hypot(x, y)
    sweep = (np.degrees(np.arctan2(x, y)) - radar.sector_deg[0]) % 360.0
    number = np.floor(sweep / grid.spacing_deg)
    half = 0.5 * np.radians(grid.spacing_deg)
    angle = np.radians(sweep - number * grid.spacing_deg) - half  # from the column's middle
    # A rung is a chord: `rung` is the ground range, on the lines, of the one through the point.
    rung = ground * np.cos(angle) / np.cos(half)
    ranges = grid.ground_range
    step = ranges[1] - ranges[0]
    index = np.floor((rung - ranges[0]) / step)
    slant = np.hypot(ground, radar.height_m)
    inside = (slant >= radar.range_m[0]) & (slant <= radar.range_m[1]) & (sweep <= sector_width(radar))
    inside &= (index >= 0.0) & (index < ranges.size - 1)
    inside &= (number - grid.first >= 0.0) & (number - grid.first < grid.columns)
    rung, index, angle = rung[inside], index[inside].astype(np.intp), angle[inside]
    near, far = ranges[index], ranges[index] + step
    # The diagonal of a quadrilateral parts its near from its far facet.
    across = 0.5 * (1.0 + np.tan(angle) / np.tan(half))
    diagonal = across * near / ((1.0 - across) * far + across * near)
    beyond = rung - near >= diagonal * step
    return inside, (number[inside] - grid.first).astype(np.intp), 2 * index + beyond


_FURTHER_ATTRIBUTES: dict[str, dict[str, Any]] = {
    "time": {"axis": "T", "calendar": "standard", "comment": "the date is nominal: the scene starts at its midnight"},
    "y": {"axis": "Y"},
    "x": {"axis": "X"},
    "velocity_x": {"comment": "the current included"},
    "velocity_y": {"comment": "the current included"},
    "nrcs_db": {
        "comment": "of the mesh's facet at the point, per horizontal area; at least -120; no speckle, no noise"
    },
    "visible": {
        "flag_values": np.array([OUTSIDE, DARK, 1, 2], dtype=np.int8),
        "flag_meanings": "outside_sector_or_range dark seen_by_one_antenna seen_by_both_antennas",
    },
}


def _provenance(scene: Scene, sea: Sea) -> dict[str, Any]:
    """Attributes of the file: the scene, and the resolved part of the sea."""
    return {
        "title": f"Simulated sea of the scene {scene.name}, seed {scene.seed}",
        "source": f"seamap_rt {version('seamap_rt')}",
        "comment": "points, not cell means; x east, y north from the foot of the radar's mast; slopes are dz/dx, dz/dy",
        "scene": scene.to_toml(),
        "seed": scene.seed,
        "sea_significant_wave_height": requested_height(sea),
        **{f"sea_{name}": value for name, value in sea.spectrum.attrs.items()},
    }
