"""The square maps on the ground, from the polar map and the points of its cells."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
import xarray as xr
from numpy.typing import NDArray

from ...conventions import unit_from_azimuth, wrap_degrees
from ...dataset import WATER_ATTRIBUTES, build
from ...radar.grid import LookFan, ground_grid, look_sweeps
from ...settings import RetrievalSettings
from ..geometry.heights import Heights
from ..geometry.poses import LookPoses
from ..input.description import RadarDescription
from .ground import centred_looks, resample_looks, square_means


@dataclass(frozen=True)
class Ground:
    """Where a moving or rolling boat's cells lie: arrays (look, gate) [m], None for one at rest and upright; `centre`
    is the mean place of its antennas over the turn."""

    x: NDArray[np.float64] | None = None
    y: NDArray[np.float64] | None = None
    centre: tuple[float, float] = (0.0, 0.0)

    @classmethod
    def of(cls, poses: LookPoses, heights: Heights, sweeps: NDArray[np.float64]) -> Ground:
        """Where cells lie; sweeps: centres of the looks [deg], (look,)."""
        if poses.at_rest:
            return cls()
        if sweeps.size < 2:  # a single look has no neighbours to lie askew of
            return cls(centre=poses.centre)
        x, y = poses.world(heights.points)
        return cls(x, y, poses.centre)


def ground_map(
    cells: xr.Dataset,
    points: Ground,
    radar: RadarDescription,
    settings: RetrievalSettings,
    turn: int,
    usable: NDArray[np.bool_] | None = None,
) -> xr.Dataset:
    """The ground maps of one turn: each square cell the mean of a few samples of the polar map at its points.

    usable (look, gate): cells that have a part in it; the others are bridged like those without an echo.
    """
    grid = ground_grid(float(radar.ranges[-1]), settings.ground_m)
    sweeps = look_sweeps(radar.sector, settings.cell_azimuth_deg, radar.staring)
    fan = LookFan(sweeps, radar.sector[0], radar.closed, radar.period, turn, settings.cell_azimuth_deg)
    distance = np.arange(0.5 * settings.ground_m, radar.ranges[-1] + settings.ground_m, 0.25 * settings.ground_m)
    fields = _fields(cells, points)
    widest_gap = 1.5 * settings.cell_range_m + radar.spacing
    laid_on, laid = _laid(cells, fields, points, usable, fan, distance, widest_gap)
    x, y = np.meshgrid(grid.x - points.centre[0], grid.y - points.centre[1])
    sweep = fan.sweep_of(x, y)
    values = dict(zip(fields, square_means(laid_on, laid, distance, grid, points.centre, sweep), strict=True))
    inside = np.hypot(x, y) <= radar.ranges[-1]
    if radar.staring:
        inside &= np.abs(sweep - sweeps[0]) <= 0.5 * settings.cell_azimuth_deg
    elif not radar.closed:
        inside &= sweep <= radar.sector[1] - radar.sector[0]
    time = np.where(inside, cells["time"].values[0][0] if radar.staring else fan.time(sweep), np.nan)
    if points.x is not None:
        # Of cells without an echo, when the beam passes their azimuth.
        passes = np.interp(sweep, fan.sweep, cells["time"].values[0])
        time = np.where(inside, np.where(np.isfinite(values["time"]), values["time"], passes), np.nan)
    values["time"] = time
    return build(
        "maps/ground",
        {name: value[None] for name, value in values.items()},
        {"turn": [turn], "y": grid.y, "x": grid.x},
        {"cell_m": settings.ground_m} | {name: cells.attrs[name] for name in WATER_ATTRIBUTES if name in cells.attrs},
    )


def _fields(cells: xr.Dataset, points: Ground) -> dict[str, NDArray[np.float64]]:
    """What the ground map holds of each cell (look, gate)."""
    names = ("range", "azimuth", "range_std", "azimuth_std", "correlation")
    outward, clockwise, along, across, correlation = (cells[f"slope_{name}"].values[0] for name in names)
    east, north = (part[:, None] for part in unit_from_azimuth(cells["azimuth"].values))
    both = 2.0 * correlation * along * across * east * north
    fields = {
        "height": cells["height"].values[0],
        "height_std": cells["height_std"].values[0],
        # Outward is (east, north); clockwise of it is (north, −east).
        "slope_x": outward * east + clockwise * north,
        "slope_y": outward * north - clockwise * east,
        "slope_x_std": np.sqrt((along * east) ** 2 + (across * north) ** 2 + both),
        "slope_y_std": np.sqrt((along * north) ** 2 + (across * east) ** 2 - both),
    }
    if points.x is not None:
        fields["time"] = np.broadcast_to(cells["time"].values[0][:, None], outward.shape)
    return fields


def _laid(
    cells: xr.Dataset,
    fields: dict[str, NDArray[np.float64]],
    points: Ground,
    usable: NDArray[np.bool_] | None,
    fan: LookFan,
    distance: NDArray[np.float64],
    widest_gap: float,
) -> tuple[LookFan, NDArray[np.float64]]:
    """The fields at equal ground ranges (look, distance, field), and the fan of those looks."""
    values = np.array(list(fields.values()), dtype=np.float64)
    ground_range = cells["ground_range"].values[0].astype(np.float64)
    if usable is not None:
        ground_range = np.where(usable, ground_range, np.nan)
    if points.x is None or points.y is None:
        return fan, resample_looks(ground_range, values, distance, widest_gap)
    x, y = points.x - points.centre[0], points.y - points.centre[1]
    away = np.where(np.isfinite(ground_range), np.hypot(x, y), np.nan)
    sweep = fan.sweep[:, None] + wrap_degrees(fan.sweep_of(x, y) - fan.sweep[:, None])
    return centred_looks(fan, sweep, away, values, distance, widest_gap)
