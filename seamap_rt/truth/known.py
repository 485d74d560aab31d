"""Truth only where the sea is known: beyond a recorded patch that was continued there is none."""

from __future__ import annotations

import numpy as np
import xarray as xr

from ..conventions import unit_from_azimuth
from ..radar.mast import Mast
from ..sea import Sea
from ..settings import RetrievalSettings


def where_known(polar: xr.Dataset, sea: Sea, mast: Mast, retrieval: RetrievalSettings) -> xr.Dataset:
    """The schema's `truth/polar` of one turn, all but `time` NaN in cells that reach where the sea is not known.

    Cells as they lie on the ground at mean level, by their corners and the middles of their near and far sides.
    """
    if sea.patch is None:
        return polar
    half = 0.5 * retrieval.cell_azimuth_deg * np.array([-1.0, 0.0, 1.0])
    ends = 0.5 * retrieval.cell_range_m * np.array([-1.0, 1.0])
    origin = mast.pose(polar["time"].values[0]).origin
    slant = np.maximum(polar["range"].values[:, None] + ends, 0.0)
    ground = np.sqrt(np.maximum(slant**2 - origin[:, None, None, 2] ** 2, 0.0))[:, None]  # (look, 1, gate, end)
    azimuth = np.asarray(polar["azimuth"].values[:, None] + half)
    toward = np.stack(unit_from_azimuth(azimuth)).reshape(
        2, *azimuth.shape, 1, 1
    )  # (east north, look, place across, 1, 1)
    east, north = origin[:, :2].T[..., None, None, None] + toward * ground
    known = np.all(sea.known(east, north), axis=(1, 3), keepdims=True)[:, 0, :, 0]
    return polar.assign({name: each.where(known[None]) for name, each in polar.data_vars.items() if name != "time"})
