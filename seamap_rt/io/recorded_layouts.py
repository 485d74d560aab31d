"""Files of a recorded sea as one dataset, whoever wrote them: a variable over time, y and x, each an axis of its own.

NetCDF and Zarr as they are; the text of HOS-ocean (`hos_ocean`); the grids of stereo cameras, which give the places of
all points: WASS's NetCDF (`Z` over `count`, `X` and `Y`, places in `X_grid` and `Y_grid`, all in mm, `time` in s, by
its gridding program), and the Matlab files of Schwendeman & Thomson (`stereo_bursts`).
"""

from __future__ import annotations

import warnings
from pathlib import Path

import numpy as np
import xarray as xr

from ..errors import InputError
from .declared import plain_attributes
from .hos_ocean import is_hos_ocean, open_hos_ocean
from .opening import check_file, check_store, open_dataset
from .stereo_bursts import is_stereo_burst, open_stereo_bursts

_SLANTED = 1e-3  # of a step, by which the points of a row may leave it


def open_layout(path: Path) -> xr.Dataset:
    """The file's variables, not yet read, with plain attributes. Raises InputError, OSError or ValueError where that
    cannot be."""
    return plain_attributes(_open(path))


def _open(path: Path) -> xr.Dataset:
    wanted, named = "a recorded sea", f"sea.file = '{path}'"
    if not path.is_dir():
        check_file(path, wanted, named=named)
    if is_stereo_burst(path):
        return _with_axes(open_stereo_bursts(path), path)
    if path.is_dir():
        check_store(path, wanted, named=named)
        return xr.open_zarr(path, chunks=None, consolidated=False, decode_timedelta=False)
    if is_hos_ocean(path):
        return open_hos_ocean(path)
    with warnings.catch_warnings():
        warnings.simplefilter("ignore")  # of how seconds will be read one day: they are taken as they are
        opened = open_dataset(path, wanted, named=named, chunks=None, cache=False, decode_timedelta=False)
    return _with_axes(opened, path) if {"X_grid", "Y_grid", "Z"} <= set(opened.variables) else opened


def _with_axes(opened: xr.Dataset, path: Path) -> xr.Dataset:
    """A grid with one axis each instead of the places of all points."""
    frames, rows, columns = opened["Z"].dims
    x, y = (np.asarray(opened[name].values, dtype=np.float64) for name in ("X_grid", "Y_grid"))
    if x.shape != y.shape or x.ndim != 2 or min(x.shape) < 2 or opened["Z"].shape[1:] != x.shape:
        raise InputError(f"sea.file = '{path}': X_grid and Y_grid do not hold the places of Z's points; mend it")
    if np.ptp(x, axis=0).max() > np.ptp(x, axis=1).max():  # along rows, not columns
        x, y, rows, columns = x.T, y.T, columns, rows
    step = max(np.abs(np.diff(x, axis=1)).max(), np.abs(np.diff(y, axis=0)).max())
    if not max(np.ptp(x, axis=0).max(), np.ptp(y, axis=1).max()) <= _SLANTED * step:
        raise InputError(
            f"sea.file = '{path}': the points of X_grid and Y_grid do not lie in rows and columns along x and y; "
            "resample it on such a grid"
        )
    named = {frames: "time", rows: "y", columns: "x", "Z": "elevation"}
    values = opened[["Z"]].drop_vars(["x", "y", "time"], errors="ignore")
    values = values.drop_vars([name for name in map(str, (frames, rows, columns)) if name in values.coords])
    values = values.rename({old: new for old, new in named.items() if old != new})
    units = {name: str(opened[grid].attrs.get("units", "m")) for name, grid in (("x", "X_grid"), ("y", "Y_grid"))}
    if "time" not in opened.variables:
        raise InputError(f"sea.file = '{path}': has no `time` of its frames; add it, in seconds")
    time = opened["time"]
    return values.assign_coords(
        time=("time", time.values.ravel(), {"units": time.attrs.get("units", "s")}),
        x=("x", x[0], {"units": units["x"]}),
        y=("y", y[:, 0], {"units": units["y"]}),
    )
