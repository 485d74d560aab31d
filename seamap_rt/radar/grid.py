"""The grids on which both maps and truth are laid: a fan of looks, and squares on the ground."""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

BYTES_PER_VOLTAGE = 32.0  # of a turn: the voltage itself, its noise and the sums it is made from
MOST_ECHO_BYTES = 8e9
MOST_GROUND_CELLS = 1e7  # of a map, which takes some 100 bytes a cell


def look_sweeps(sector_deg: tuple[float, float], cell_azimuth_deg: float, staring: bool = False) -> NDArray[np.float64]:
    """Centres of the looks as angles from the start of the sector (deg): as many whole cells as the sector holds, and
    the one in its middle for a staring antenna."""
    width = sector_deg[1] - sector_deg[0]
    if staring:
        return np.array([0.5 * width])
    if np.isclose(width, 360.0):
        count = max(1, round(360.0 / cell_azimuth_deg))
        return (np.arange(count) + 0.5) * 360.0 / count
    count = max(1, int(np.floor(width / cell_azimuth_deg + 1e-9)))
    return (np.arange(count, dtype=np.float64) + 0.5) * cell_azimuth_deg


@dataclass(frozen=True)
class GroundGrid:
    """Centres of square cells around the origin; y runs north, x east."""

    x: NDArray[np.float64]
    y: NDArray[np.float64]
    side: float

    def points(self, per_side: int) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
        """(y, x, point) points that sample each cell evenly, per_side² of them."""
        step = self.side * ((np.arange(per_side) + 0.5) / per_side - 0.5)
        dy, dx = np.meshgrid(step, step, indexing="ij")
        shape = (self.y.size, self.x.size, per_side * per_side)
        x = np.broadcast_to(self.x[None, :, None] + dx.ravel(), shape)
        y = np.broadcast_to(self.y[:, None, None] + dy.ravel(), shape)
        return x, y


def ground_cells(far_range: float, side: float) -> float:
    """How many square cells of side [m] a map to far_range [m] has, one more or less a side."""
    return (2.0 * far_range / side) ** 2


def least_ground_side(far_range: float) -> float:
    """Side [m] of cells of which a map to far_range [m] has MOST_GROUND_CELLS."""
    return 2.0 * far_range / math.sqrt(MOST_GROUND_CELLS)


def ground_grid(far_range: float, side: float) -> GroundGrid:
    """Square cells of side [m] that cover the circle of radius far_range [m], one centred on the origin."""
    count = int(np.ceil(far_range / side))
    centres = side * np.arange(-count, count + 1, dtype=np.float64)
    return GroundGrid(centres, centres.copy(), side)


@dataclass(frozen=True)
class LookFan:
    """Where the looks point: `sweep` (look,) deg from the start of the sector, and what closes the circle."""

    sweep: NDArray[np.float64]
    start_deg: float
    closed: bool
    period_s: float
    turn: int
    cell_deg: float  # width of a look that has no neighbour

    @property
    def spacing(self) -> float:
        """deg, between looks."""
        return float(self.sweep[1] - self.sweep[0]) if self.sweep.size > 1 else self.cell_deg

    def sweep_of(self, x: NDArray[np.float64], y: NDArray[np.float64]) -> NDArray[np.float64]:
        """Angle from the start of the sector at which the beam passes a point, 0 … 360 deg."""
        return (np.degrees(np.arctan2(x, y)) - self.start_deg) % 360.0

    def time(self, sweep: NDArray[np.float64]) -> NDArray[np.float64]:
        """When the beam passes a sweep angle [s]."""
        return (self.turn + sweep / 360.0) * self.period_s
