"""A turn's ground map, brought to one instant by the waves' own speed."""

from __future__ import annotations

from dataclasses import fields

import numpy as np
import xarray as xr

from ...physics.dispersion import Water
from ...wavefield.advance import GroundFields, advanced
from ...wavefield.wave_direction import by_energy, travel


def at_one_instant(ground: xr.Dataset, cells: xr.Dataset, to_s: float, water: Water) -> xr.Dataset:
    """The ground map of one turn as the sea stood at to_s [s]; water: that its waves run on.

    The direction in which waves run follows from the radial velocities of the polar map `cells`: water moves with
    the wave at its crests. Where they give none the map stays as it was scanned, each cell at its own time.
    """
    if "radial_velocity" not in cells:
        return ground
    side = float(ground.attrs["cell_m"])
    names = ("height", "height_std", "radial_velocity", "ground_range")
    height, spread, velocity, distance = (np.asarray(cells[name].values[0], dtype=np.float64) for name in names)
    direction = travel(height, spread, velocity, cells["azimuth"].values, distance, side)
    seen = GroundFields(*(np.asarray(ground[each.name].values[0], dtype=np.float64) for each in fields(GroundFields)))
    direction = by_energy(seen.height, seen.height_std, side, direction)
    if not np.isfinite(direction.wave_from_deg):
        return ground
    made = advanced(seen, side, to_s, direction, water)
    at_once = {}
    for each in fields(GroundFields):
        old = ground[each.name]
        at_once[each.name] = (old.dims, getattr(made, each.name)[None].astype(old.dtype), old.attrs)
    return ground.assign(at_once)
