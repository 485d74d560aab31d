"""A recorded sea: its surface over a square patch, frame by frame, from a file of any size.

NetCDF or Zarr by the rules below; the `3d.dat` of HOS-ocean (`hos_ocean`); and the grids of WASS, a stereo camera's:
`Z` over frames, with its places in `X_grid` and `Y_grid`, in mm.

The variable of the elevation has the axes time, y and x in any order, evenly spaced; its name is one of `NAMES`, or its
standard_name one of CF's for the height of the sea surface. Lengths may be in m, cm or km, times in seconds or dates.
`surface_potential` [m² s⁻¹], where it is there, is the velocity potential at the surface. Global attributes: periodic
(1: the patch repeats), depth_m. One frame is read at a time.
"""

from __future__ import annotations

import threading
from dataclasses import dataclass
from functools import lru_cache
from pathlib import Path
from typing import Any

import numpy as np
import xarray as xr
from numpy.typing import NDArray

from ..errors import InputError
from .hos_ocean import is_hos_ocean, open_hos_ocean

NAMES = ("elevation", "eta", "sea_surface_elevation", "surface_elevation", "zeta", "ssh", "height")
POTENTIAL = "surface_potential"
_STANDARD = "sea_surface_height"
_AXES = {"time": ("time", "t"), "y": ("y", "north", "northing"), "x": ("x", "east", "easting")}
_LENGTHS = {
    "mm": 0.001,
    "millimeter": 0.001,
    "m": 1.0,
    "metre": 1.0,
    "meter": 1.0,
    "metres": 1.0,
    "meters": 1.0,
    "cm": 0.01,
    "km": 1000.0,
}
_SECONDS = ("s", "sec", "second", "seconds", "")
_UNEVEN = 1e-3  # of a step, by which the points of an axis may stray
_HIGHEST_M = 30.0
_FEWEST_POINTS, _FEWEST_FRAMES = 16, 14
RIM = 0.05  # of a patch's side that does not repeat, within which it is brought to mean level


@dataclass(frozen=True)
class RecordedSea:
    """What a file of a recorded sea holds; frames are read as they are asked for. Safe in threads.

    spacing_m, points: of the square patch, a side; west_m, south_m: of its first point from the antenna; step_s,
    frames: in time; depth_m: None where the file does not say.
    """

    path: str
    name: str
    frames: int
    step_s: float
    points: int
    spacing_m: float
    west_m: float
    south_m: float
    periodic: bool
    depth_m: float | None
    potential: bool
    _first: tuple[int, int]  # row and column of the patch in the file
    _scale: float  # to metres, of the elevation

    @property
    def side_m(self) -> float:
        """After which the patch repeats, or is made to."""
        return self.points * self.spacing_m

    @property
    def reach_m(self) -> float:
        """How far around the antenna the sea is that of the file: half the side of a patch that repeats."""
        if self.periodic:
            return 0.5 * self.side_m
        rim = RIM * self.side_m
        edges = -self.west_m, self.west_m + self.side_m, -self.south_m, self.south_m + self.side_m
        return min(edges) - rim

    def elevation(self, frame: int) -> NDArray[np.float64]:
        """(row, column) m above its mean, rows to the north. Raises InputError for a frame with gaps."""
        values = self._read(self.name, frame) * self._scale
        if not np.isfinite(values).all():
            share = float(np.mean(~np.isfinite(values)))
            raise InputError(
                f"sea.file = '{self.path}': frame {frame} has gaps ({share:.1%}); fill them, or cut them off"
            )
        if np.abs(values).max() > _HIGHEST_M:
            raise InputError(
                f"sea.file = '{self.path}': frame {frame} holds {np.abs(values).max():.4g} m: must be at most "
                f"{_HIGHEST_M:g} (no sea above 30 m); check the units of {self.name}"
            )
        return values

    def surface_potential(self, frame: int) -> NDArray[np.float64]:
        """(row, column) m²/s."""
        return np.nan_to_num(self._read(POTENTIAL, frame))

    def _read(self, name: str, frame: int) -> NDArray[np.float64]:
        if not 0 <= frame < self.frames:
            raise InputError(f"sea.file = '{self.path}': holds frames 0 to {self.frames - 1}, asked for {frame}")
        row, column = self._first
        with _LOCK:
            opened = _opened(self.path, _version(self.path))
            axes = _axes(opened[name])
            cut = opened[name].isel(
                {
                    axes["time"]: frame,
                    axes["y"]: slice(row, row + self.points),
                    axes["x"]: slice(column, column + self.points),
                }
            )
            values = cut.transpose(axes["y"], axes["x"]).values.astype(np.float64)
        values = values[:: _direction(opened, axes["y"]), :: _direction(opened, axes["x"])]
        return values if self.periodic else _levelled_rim(values)


_LOCK = threading.Lock()


def recorded_sea(path: str) -> RecordedSea:
    """What a file holds. Raises InputError, a line, for one that is not a recorded sea."""
    try:
        return _recorded(path, _version(path))
    except (OSError, ValueError, KeyError) as error:
        if isinstance(error, InputError):
            raise
        what = str(error).split("\n")[0][:160]
        raise InputError(
            f"sea.file = '{path}': cannot be read as NetCDF or Zarr ({what}); give a file with the elevation over "
            "time, y and x"
        ) from None


@lru_cache(maxsize=8)
def _recorded(path: str, version: tuple[int, int]) -> RecordedSea:
    with _LOCK:
        opened = _opened(path, version)
    wrong = f"sea.file = '{path}': "
    name = _elevation_of(opened)
    if name is None:
        there = ", ".join(map(str, opened.data_vars)) or "nothing"
        raise InputError(
            f"{wrong}holds no elevation over time, y and x (it has {there}); "
            f"name the variable one of {', '.join(NAMES)}"
        )
    axes = _axes(opened[name])
    scale = _length(opened[name].attrs.get("units", "m"), f"{wrong}{name}")
    x, y = (
        _length(opened[axes[each]].attrs.get("units", "m"), f"{wrong}{axes[each]}")
        * np.asarray(opened[axes[each]].values, dtype=np.float64)
        for each in ("x", "y")
    )
    spacing = [_even(values, _FEWEST_POINTS, f"{wrong}{axes[each]}") for each, values in (("x", x), ("y", y))]
    if abs(spacing[0] - spacing[1]) > _UNEVEN * spacing[0]:
        raise InputError(
            f"{wrong}x and y are {spacing[0]:.4g} and {spacing[1]:.4g} m apart: must be alike; resample it"
        )
    times = _seconds(opened[axes["time"]], wrong)
    step = _even(times, _FEWEST_FRAMES, f"{wrong}{axes['time']}")
    if times[1] < times[0]:
        raise InputError(f"{wrong}{axes['time']} runs backwards; turn it round")
    periodic = bool(int(opened.attrs.get("periodic", 0)))
    if periodic and x.size != y.size:
        raise InputError(f"{wrong}is {x.size} × {y.size} points: a patch that repeats must be square; resample it")
    points = min(x.size, y.size)
    first, corner = _square(np.sort(x), np.sort(y), points)
    depth = opened.attrs.get("depth_m")
    return RecordedSea(
        path=path,
        name=name,
        frames=times.size,
        step_s=step,
        points=points,
        spacing_m=spacing[0],
        west_m=corner[1],
        south_m=corner[0],
        periodic=periodic,
        depth_m=None if depth is None else float(depth),
        potential=POTENTIAL in opened and set(opened[POTENTIAL].dims) == set(opened[name].dims),
        _first=(
            first[0] if _direction(opened, axes["y"]) > 0 else y.size - points - first[0],
            first[1] if _direction(opened, axes["x"]) > 0 else x.size - points - first[1],
        ),
        _scale=scale,
    )


def _square(x: NDArray, y: NDArray, points: int) -> tuple[tuple[int, int], tuple[float, float]]:
    """Where a square of the patch begins, row and column, and its south-west point from the antenna, which stands at
    0, 0, or where that is not in the patch in its middle."""
    starts, corner = [], []
    inside = x[0] <= 0.0 <= x[-1] and y[0] <= 0.0 <= y[-1]
    for axis in (y, x):
        antenna = 0.0 if inside else 0.5 * (axis[0] + axis[-1])
        middle = int(np.argmin(np.abs(axis - antenna)))
        start = int(np.clip(middle - points // 2, 0, axis.size - points))
        starts.append(start)
        corner.append(float(axis[start] - antenna))
    return (starts[0], starts[1]), (corner[0], corner[1])


def _levelled_rim(values: NDArray[np.float64]) -> NDArray[np.float64]:
    """A patch that does not repeat, brought to its mean level at the rim, so that it can be made to."""
    mean = float(np.nanmean(values))
    weight = np.ones(values.shape[0])
    rim = max(2, round(RIM * weight.size))
    weight[:rim] = 0.5 - 0.5 * np.cos(np.pi * (np.arange(rim) + 0.5) / rim)
    weight[-rim:] = weight[:rim][::-1]
    return (values - mean) * weight[:, None] * weight


# ------------------------------------------------------------------------------------------------------ the file


def _version(path: str) -> tuple[int, int]:
    told = Path(path).stat()
    return told.st_mtime_ns, told.st_size


@lru_cache(maxsize=4)
def _opened(path: str, _: tuple[int, int]) -> xr.Dataset:
    if Path(path).is_dir():
        return xr.open_zarr(path, chunks=None, consolidated=False)
    if is_hos_ocean(Path(path)):
        return open_hos_ocean(Path(path))
    opened = xr.open_dataset(path, chunks=None, cache=False)
    return _with_axes(opened) if {"X_grid", "Y_grid", "Z"} <= set(opened.variables) else opened


def _with_axes(opened: xr.Dataset) -> xr.Dataset:
    """WASS's grid with one axis each instead of the places of all points."""
    frames, rows, columns = opened["Z"].dims
    x, y = (np.asarray(opened[name].values, dtype=np.float64) for name in ("X_grid", "Y_grid"))
    if np.ptp(x, axis=0).max() > np.ptp(x, axis=1).max():  # along rows, not columns
        x, y, rows, columns = x.T, y.T, columns, rows
    named = {frames: "time", rows: "y", columns: "x", "Z": "elevation"}
    values = opened[["Z"]].rename({old: new for old, new in named.items() if old != new})
    times = {"time": ("time", np.asarray(opened["time"].values, dtype=np.float64).ravel(), {"units": "s"})}
    return values.drop_vars(["x", "y", "time"], errors="ignore").assign_coords(
        {**times, "x": ("x", x[0], {"units": "mm"}), "y": ("y", y[:, 0], {"units": "mm"})}
    )


def _elevation_of(opened: xr.Dataset) -> str | None:
    there = [str(name) for name in opened.data_vars if len(_axes(opened[name])) == 3 and opened[name].ndim == 3]
    named = [name for wanted in NAMES for name in there if name.lower() == wanted]
    standard = [name for name in there if str(opened[name].attrs.get("standard_name", "")).startswith(_STANDARD)]
    return next(iter([*named, *standard]), None)


def _axes(values: xr.DataArray) -> dict[str, str]:
    """Which dimension is which."""
    found = {}
    for axis, names in _AXES.items():
        for dimension in values.dims:
            if str(dimension).lower() in names and dimension in values.coords:
                found[axis] = str(dimension)
    return found


def _direction(opened: xr.Dataset, axis: str) -> int:
    values = opened[axis].values
    return 1 if values[-1] >= values[0] else -1


def _length(unit: Any, what: str) -> float:
    """Metres a unit."""
    word = str(unit).strip().lower()
    if word not in _LENGTHS:
        raise InputError(f"{what}: is in '{unit}': must be in m, cm or km; convert it (degrees to local metres)")
    return _LENGTHS[word]


def _seconds(times: xr.DataArray, wrong: str) -> NDArray[np.float64]:
    values = times.values
    if np.issubdtype(values.dtype, np.datetime64) or np.issubdtype(values.dtype, np.timedelta64):
        return (values - values[0]) / np.timedelta64(1, "ns") * 1e-9
    unit = str(times.attrs.get("units", "s")).strip().lower()
    if unit not in _SECONDS:
        raise InputError(f"{wrong}{times.name}: is in '{unit}': must be in seconds, or dates; convert it")
    return np.asarray(values, dtype=np.float64)


def _even(values: NDArray[np.float64], fewest: int, what: str) -> float:
    """The spacing of an axis. Raises InputError where it is not even, or too short."""
    if values.size < fewest:
        raise InputError(f"{what}: has {values.size} points: must have at least {fewest}; give more of it")
    steps = np.diff(values)
    step = float(np.median(steps))
    if not np.isfinite(steps).all() or step == 0.0 or np.abs(steps - step).max() > max(_UNEVEN, 1e-6) * abs(step):
        raise InputError(f"{what}: is not evenly spaced (median {step:.4g}, {steps.min():.4g} to {steps.max():.4g}); "
                         "resample it")  # fmt: skip
    return abs(float(values[-1] - values[0])) / (values.size - 1)
