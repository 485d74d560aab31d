"""A drawn sea written to a file, frame by frame, as a recorded one."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import xarray as xr

from seamap_rt.sea import Sea, realize
from seamap_rt.settings import JonswapWaves, SeaSettings

SIDE_M, SPACING_M, STEP_S, FRAMES = 128.0, 1.0, 0.1, 60
BEFORE = 10  # frames before the drawn sea's time 0: `first_frame` of a tenth of a second


def drawn_settings(depth_m: float = np.inf) -> SeaSettings:
    waves = JonswapWaves(
        spectrum="jonswap",
        significant_wave_height_m=0.6,
        peak_period_s=4.0,
        wave_from_deg=300.0,
        spreading_exponent=6.0,
    )
    return SeaSettings(extent_m=SIDE_M, resolution_m=2.0, depth_m=depth_m, waves=(waves,))


def drawn(depth_m: float = np.inf) -> Sea:
    return realize(drawn_settings(depth_m), 5)


def dataset_of(sea: Sea, west_m: float = -64.0, side_m: float = SIDE_M, spacing_m: float = SPACING_M) -> xr.Dataset:
    """Frames of a sea on a patch whose south-west corner is at west_m, west_m."""
    axis = west_m + spacing_m * np.arange(round(side_m / spacing_m))
    times = STEP_S * np.arange(FRAMES)
    east, north = np.meshgrid(axis, axis)
    frames = [sea.elevation(east, north, time - STEP_S * BEFORE) for time in times]
    return xr.Dataset(
        {"elevation": (("time", "y", "x"), np.array(frames, dtype=np.float32), {"units": "m"})},
        {
            "time": ("time", times, {"units": "s"}),
            "y": ("y", axis, {"units": "m"}),
            "x": ("x", axis, {"units": "m"}),
        },
        {"periodic": 1},
    )


def write(data: xr.Dataset, path: Path) -> str:
    data.to_netcdf(path, engine="h5netcdf")
    return str(path)
