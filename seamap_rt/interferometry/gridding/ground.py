"""The map on the ground: each look's cells are laid where their own heights put them, then sampled on a square grid.

From a boat at rest a look's cells lie on a straight line. Those of a boat that moves or rolls do not: they are laid by
their azimuth and distance from one centre, first along each look and then across the looks.
"""

from __future__ import annotations

from dataclasses import replace
from functools import lru_cache

import numpy as np
from numpy.typing import NDArray

from ...compute.machine import in_blocks
from ...radar.grid import GroundGrid, LookFan
from .ground_kernel import mean_of_samples, resample_rows

_FINER = 3  # looks for one; coarser ones would blur waves across the looks
_SAMPLES = 3  # per side of a ground cell


def resample_looks(
    ground_range: NDArray[np.float64], fields: NDArray[np.float64], distance: NDArray[np.float64], widest_gap: float
) -> NDArray[np.float64]:
    """Fields (field, look, gate) at equal ground ranges, (look, distance, field): linear between valid cells, NaN
    across gaps.

    Cells are sorted by ground range first: on a steep face a nearer gate can lie further out.
    """
    laid = np.full((ground_range.shape[0], distance.size, fields.shape[0]), np.nan)
    resample_rows(np.ascontiguousarray(ground_range), fields, distance, widest_gap, laid)
    return laid


def centred_looks(
    fan: LookFan,
    azimuth_sweep: NDArray[np.float64],
    ground_range: NDArray[np.float64],
    fields: NDArray[np.float64],
    distance: NDArray[np.float64],
    widest_gap: float,
) -> tuple[LookFan, NDArray[np.float64]]:
    """Fields (field, look, gate) of cells that lie anywhere, on a finer fan from a common centre, (look, distance,
    field).

    azimuth_sweep [deg from the sector's start, not wrapped] and ground_range [m] are the cells' own, from that centre.
    Looks more than one and a half apart have a gap between them.
    """
    laid = resample_looks(ground_range, np.concatenate((azimuth_sweep[None], fields)), distance, widest_gap)
    sweep, half = laid[..., 0], 0.5 * fan.spacing
    # The first and the last look serve as far as half a look beyond.
    sweep = np.concatenate((sweep[:1] - half, sweep, sweep[-1:] + half))
    beside = np.concatenate((laid[:1], laid, laid[-1:]))[..., 1:]
    looks = _FINER * fan.sweep.size
    fine = fan.sweep[0] - half + (np.arange(looks) + 0.5) * fan.spacing / _FINER
    across = resample_looks(sweep.T, np.ascontiguousarray(beside.transpose(2, 1, 0)), fine, 1.5 * fan.spacing)
    return replace(fan, sweep=fine), np.ascontiguousarray(across.transpose(1, 0, 2))


def square_means(
    fan: LookFan,
    laid: NDArray[np.float64],
    distance: NDArray[np.float64],
    grid: GroundGrid,
    centre: tuple[float, float],
    middle: NDArray[np.float64],
) -> NDArray[np.float64]:
    """Means (field, y, x) of the fields of a fan (look, distance, field) around `centre` over each square of the grid:
    of a few samples, bilinear in angle and ground range; NaN unless more than half of them are known. middle (y, x):
    the angle from the sector's start to the squares' own centres, 0 … 360 deg.

    Before the first look and after the last the nearest of them serves, as far as half a look; all the way in a full
    circle, whose ends lie a turn apart in time and are not blended.
    """
    x, y, bearing = _samples(grid.x.size // 2, grid.side, *centre)
    sweep = bearing - fan.start_deg if fan.start_deg else bearing
    polar = fan.sweep[0], fan.spacing, float(fan.closed), distance[0], distance[1] - distance[0]
    means = np.full((laid.shape[2], *middle.shape), np.nan)
    laid = np.ascontiguousarray(laid)
    in_blocks(lambda *rows: mean_of_samples(*rows, laid, polar, middle, x, y, sweep, means), len(middle))
    return means


@lru_cache(maxsize=1)
def _samples(reach: int, side: float, east: float, north: float) -> tuple[NDArray[np.float64], ...]:
    """Of a grid that reaches so many squares to either side, east (x,) and north (y,) of its samples from a centre, and
    their bearing (y, x) deg: of a boat that does not move the same at each turn, and as much work as the means."""
    within = side * ((np.arange(_SAMPLES) + 0.5) / _SAMPLES - 0.5)
    centres = side * np.arange(-reach, reach + 1)
    x, y = (((centres - at)[:, None] + within).ravel() for at in (east, north))
    return x, y, np.degrees(np.arctan2(x, y[:, None]))
