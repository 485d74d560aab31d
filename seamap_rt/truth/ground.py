"""The true sea in the cells of the ground maps: means of squares, each at the time when the beam passes it.

Truth is only where the sea is known: beyond a recorded patch that was continued there is none.
"""

from __future__ import annotations

import numpy as np
import xarray as xr
from numpy.typing import NDArray

from ..conventions import unit_from_azimuth, wrap_degrees
from ..dataset import build
from ..radar.grid import ground_grid
from ..radar.installation import Installation
from ..radar.scan import sector_width
from ..radar.waveform import gates
from ..sea import Sea
from ..settings import RetrievalSettings


def mask_unknown(polar: xr.Dataset, sea: Sea, installation: Installation, retrieval: RetrievalSettings) -> xr.Dataset:
    """The schema's `truth/polar` of one turn, all but `time` NaN in cells that reach where the sea is not known.

    Cells as they lie on the ground at mean level, by their corners and the middles of their near and far sides.
    """
    if sea.patch is None:
        return polar
    half = 0.5 * retrieval.cell_azimuth_deg * np.array([-1.0, 0.0, 1.0])
    ends = 0.5 * retrieval.cell_range_m * np.array([-1.0, 1.0])
    origin = installation.pose(polar["time"].values[0]).origin
    slant = np.maximum(polar["range"].values[:, None] + ends, 0.0)
    ground = np.sqrt(np.maximum(slant**2 - origin[:, None, None, 2] ** 2, 0.0))[:, None]  # (look, 1, gate, end)
    azimuth = np.asarray(polar["azimuth"].values[:, None] + half)
    toward = np.stack(unit_from_azimuth(azimuth)).reshape(
        2, *azimuth.shape, 1, 1
    )  # (east north, look, place across, 1, 1)
    east, north = origin[:, :2].T[..., None, None, None] + toward * ground
    known = np.all(sea.is_known(east, north), axis=(1, 3), keepdims=True)[:, 0, :, 0]
    return polar.assign({name: each.where(known[None]) for name, each in polar.data_vars.items() if name != "time"})


_GAUSS = 0.5 / np.sqrt(3.0)  # of a cell's side: two-point Gauss quadrature, exact for cubics


def ground_truth(sea: Sea, installation: Installation, retrieval: RetrievalSettings, turn: int) -> xr.Dataset:
    """The schema's `truth/ground` (turn, y, x) of one turn: means of square cells, NaN where the beam does not pass,
    and where the sea is not known.

    Each cell is taken at the time when the beam passes its centre, or all at retrieval.map_time_s.
    """
    far = float(gates(installation.radar)[-1])  # of the maps: the last gate, not the end of the window
    grid = ground_grid(far, retrieval.ground_m)
    x, y = np.meshgrid(grid.x, grid.y)
    inside, time = _passing(installation, x, y, far, turn, retrieval.cell_azimuth_deg)
    if retrieval.map_time_s is not None:
        time = np.where(inside, turn * installation.period + retrieval.map_time_s, np.nan)
    step = _GAUSS * retrieval.ground_m
    signs = np.array([[-1.0, -1.0], [1.0, -1.0], [-1.0, 1.0], [1.0, 1.0]])  # west–east, south–north
    if sea.patch is not None:
        half = 0.5 * retrieval.ground_m * signs
        inside &= sea.is_known(x[..., None] + half[:, 0], y[..., None] + half[:, 1]).all(axis=-1)
    corners = (x[inside][:, None] + step * signs[:, 0], y[inside][:, None] + step * signs[:, 1], time[inside][:, None])
    height, slopes = (values.mean(axis=1) for values in sea.elevation_and_slopes(*corners))

    def field(values: NDArray[np.float64]) -> NDArray[np.float64]:
        out = np.full(inside.shape, np.nan)
        out[inside] = values
        return out[None]

    return build(
        "truth/ground",
        {
            "height": field(height),
            "slope_x": field(slopes[:, 0]),
            "slope_y": field(slopes[:, 1]),
            "time": time[None],
        },
        {"turn": [turn], "y": grid.y, "x": grid.x},
    )


def _passing(
    installation: Installation, x: NDArray[np.float64], y: NDArray[np.float64], far: float, turn: int, cell_deg: float
) -> tuple[NDArray[np.bool_], NDArray[np.float64]]:
    """Which points (x, y) [m] the boresight passes in a turn, and when [s], NaN for the others."""
    radar = installation.radar
    width = sector_width(radar)
    times = (turn + np.linspace(0.0, 1.0, 721)) * installation.period
    pose = installation.pose(times)
    swept = (times - times[0]) * installation.rate + installation.swing(times)
    resting = np.ptp(pose.origin, axis=0).max() == 0.0
    time = np.full(x.shape, times[0])
    inside, east, north = np.zeros(x.shape, dtype=bool), np.zeros(x.shape), np.zeros(x.shape)
    for _ in range(1 if resting else 12):  # a moving mast: its position at the time of passing, by iteration
        east, north = (np.interp(time, times, pose.origin[:, axis]) for axis in (0, 1))
        sweep = (np.degrees(np.arctan2(x - east, y - north)) - radar.sector_deg[0]) % 360.0
        if radar.scan == "staring":
            inside, time = np.abs(sweep - 0.5 * width) <= 0.5 * cell_deg, np.full(x.shape, times[360])
            continue
        inside = np.isclose(width, 360.0) | (sweep <= width)
        if resting and not installation.swing(times).any():
            time = (turn + sweep / 360.0) * installation.period  # the same bits as the map's
        else:
            sweep = np.where((sweep < swept[0]) & (sweep + 360.0 <= swept[-1]), sweep + 360.0, sweep)
            time = np.interp(sweep, swept, times)
    inside &= np.hypot(x - east, y - north) <= far
    if not resting and radar.scan != "staring":  # points close to the boat's own path may not be passed at all
        east, north = (np.interp(time, times, pose.origin[:, axis]) for axis in (0, 1))
        bearing = np.degrees(np.arctan2(x - east, y - north)) - radar.sector_deg[0]
        inside &= np.abs(wrap_degrees(bearing - np.interp(time, times, swept))) <= 0.5 * cell_deg
    return inside, np.where(inside, time, np.nan)
