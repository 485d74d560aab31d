"""Files of a recorded sea as one dataset, whoever wrote them: a variable over time, y and x, each an axis of its own.

NetCDF and Zarr are taken as they are.

HOS-ocean's `Results/3d.dat` is text for Tecplot, a zone a time, read a zone at a time. By the program's own output
routine comments begin with #; `VARIABLES="x","y","eta","phis"`; each zone is headed by its time (`SOLUTIONTIME = ` or
`T = "`), rounded to a hundredth of a second, and `I=`, `J=`, the points along x and y. Lines of the first zone have
x [m], y [m], η [m] and φs [m²/s], x fastest; those of later ones η and φs. The patch repeats.

Grids of stereo cameras give the places of all points: WASS's NetCDF (`Z` over `count`, `X` and `Y`, places in `X_grid`
and `Y_grid`, all in mm, `time` in s, by its gridding program), and the Matlab files of Schwendeman & Thomson (hdl
1773/38314), `XYZResults`, of a minute each. By the data's own description `XYGrid_01.mat` holds `xgrid` and `ygrid`,
the places of all points in m (161 × 161, −20 to 20 m, 0.25 m apart, x downwind), and `ZGrid_01.mat` holds `zgrid`,
their heights in m over frames, 300 at 5 Hz or 450 at 7.5 Hz: a minute. Those that follow, `_02` and so on, go on where
it ends. Matlab writes either its own format (to version 7) or HDF5 (7.3), whose axes are the other way round; a minute
is read at a time, and the last two are kept.
"""

from __future__ import annotations

import re
import warnings
from collections.abc import Iterator
from functools import lru_cache
from pathlib import Path
from typing import Any, BinaryIO

import numpy as np
import xarray as xr
from numpy.typing import NDArray
from scipy.io import whosmat
from xarray.backends import BackendArray
from xarray.core import indexing

from ..errors import InputError, Refusal
from .declared import plain_attributes
from .matlab_elements import check_version_5
from .opening import check_file, check_store, open_dataset, open_file, open_hdf5
from .recorded import read_matlab

_ZONE = re.compile(rb'ZONE\s+(?:SOLUTIONTIME\s*=|T\s*=\s*")\s*([-+.\dEe]+)"?.*?I=\s*(\d+)\s*,\s*J=\s*(\d+)')
_LONGEST = 10_000  # bytes of a line
_ROUNDED_S = 0.006  # half the last digit of a time, and a little


class _Frames(BackendArray):
    """An array (time, y, x) of which a frame is read at a time."""

    shape: tuple[int, int, int]
    dtype = np.dtype(np.float64)

    def __getitem__(self, key: indexing.ExplicitIndexer) -> Any:
        return indexing.explicit_indexing_adapter(key, self.shape, indexing.IndexingSupport.BASIC, self._values)

    def _values(self, key: tuple[Any, ...]) -> NDArray[np.float64]:
        frames = np.arange(self.shape[0])[key[0]]
        if np.ndim(frames) == 0:
            return self._frame(int(frames))[key[1:]]
        return np.stack([self._frame(int(frame)) for frame in frames])[(slice(None), *key[1:])]

    def _frame(self, number: int) -> NDArray[np.float64]:
        raise NotImplementedError


class _Zones(_Frames):
    """A column of all zones."""

    def __init__(self, path: Path, starts: list[int], size: tuple[int, int], column: int) -> None:
        self._path, self._starts, self._column = path, starts, column
        self.shape = len(starts), size[1], size[0]

    def _frame(self, number: int) -> NDArray[np.float64]:
        columns = 4 if number == 0 else 2
        with open_file(self._path) as file:
            file.seek(self._starts[number])
            count = self.shape[1] * self.shape[2]
            values = np.loadtxt(_read_lines(file), max_rows=count, usecols=columns - 2 + self._column, ndmin=1)
        if values.size != count:
            raise ValueError(f"zone {number} ends after {values.size} of {count} points")
        return values.reshape(self.shape[1:])


def is_hos_ocean(path: Path) -> bool:
    """Whether a file begins as one of HOS-ocean's."""
    with open_file(path) as file:
        head = file.read(20_000)
    return b'"eta"' in head and b"VARIABLES" in head and b"ZONE" in head


def open_hos_ocean(path: Path) -> xr.Dataset:
    """elevation and surface_potential (time, y, x), not yet read. Raises InputError for a file that is cut off."""
    starts: list[int] = []
    times: list[float] = []
    size, end = (0, 0), 0
    with open_file(path) as file:
        for line in _read_lines(file):
            found = _ZONE.search(line) if line.lstrip().startswith(b"ZONE") else None
            if found is None:
                continue
            size = int(found[2]), int(found[3])
            times.append(float(found[1]))
            starts.append(file.tell())
            width = len(file.readline(_LONGEST))  # all lines of a zone are as long as its first
            end = starts[-1] + width * size[0] * size[1]
            file.seek(end)
        whole = file.seek(0, 2) >= end
    if not whole and starts:  # a run that was stopped: its last zone is not whole
        starts.pop()
        times.pop()
    if not starts:
        raise Refusal("holds no whole zone; give HOS-ocean's 3d.dat")
    x = _first_rows(path, starts[0], size[0], 0)
    y = _first_rows(path, starts[0], size[0] * size[1], 1)[:: size[0]]
    even = np.linspace(times[0], times[-1], len(times))
    seconds = even if np.abs(even - times).max() < _ROUNDED_S else np.array(times)
    columns = {
        name: (
            ("time", "y", "x"),
            indexing.LazilyIndexedArray(_Zones(path, starts, size, column)),
            {"units": units},
        )
        for column, (name, units) in enumerate((("elevation", "m"), ("surface_potential", "m2 s-1")))
    }
    axes = {
        name: (name, values, {"units": unit})
        for name, values, unit in (("time", seconds, "s"), ("y", y, "m"), ("x", x, "m"))
    }
    return xr.Dataset(columns, axes, {"periodic": 1})


def _first_rows(path: Path, start: int, rows: int, column: int) -> NDArray[np.float64]:
    """The first rows of a column of the first zone."""
    with open_file(path) as file:
        file.seek(start)
        return np.loadtxt(_read_lines(file), max_rows=rows, usecols=column, ndmin=1)


def _read_lines(file: BinaryIO) -> Iterator[bytes]:
    """The lines of a file, which may be moved in between."""
    while line := file.readline(_LONGEST):
        if len(line) == _LONGEST:
            raise ValueError(f"a line is longer than {_LONGEST} bytes")
        yield line


_HEIGHTS = re.compile(r"ZGrid_(\d+)\.mat$")
_MINUTE_S = 60.0


class _Minutes(_Frames):
    """The heights of all minutes."""

    def __init__(self, paths: list[Path], frames: list[int], size: tuple[int, int]) -> None:
        self._paths, self._ends = paths, np.cumsum(frames)
        self.shape = int(self._ends[-1]), *size

    def _frame(self, number: int) -> NDArray[np.float64]:
        minute = int(np.searchsorted(self._ends, number, side="right"))
        before = int(self._ends[minute - 1]) if minute else 0
        path = self._paths[minute]
        return _read_minute(path, path.stat().st_mtime_ns)[:, :, number - before].astype(np.float64)


def open_stereo_bursts(path: Path) -> xr.Dataset:
    """elevation (time, row, column), not yet read, and the places of its points X_grid and Y_grid in m, from a folder
    or from its first file on. Raises InputError where minutes or their places are missing."""
    paths = _minute_files(path)
    numbers = [int(_minute_number(each)) for each in paths]
    if numbers != list(range(numbers[0], numbers[0] + len(numbers))):
        raise Refusal(f"minutes {numbers} do not follow each other; name the first of those that do")
    beside = paths[0].with_name(f"XYGrid_{_minute_number(paths[0])}.mat")
    if not beside.is_file():
        raise Refusal(f"{beside.name} is not beside {paths[0].name}; put the places of the points there")
    places = [_read(beside, name) for name in ("xgrid", "ygrid")]
    frames = [_array_shape(each, "zgrid")[2] for each in paths]
    if any(_array_shape(each, "zgrid")[:2] != places[0].shape for each in paths):
        raise Refusal(f"zgrid has other points than xgrid of {beside.name}; give files that belong together")
    if any(each != frames[0] for each in frames[:-1]):
        raise Refusal(f"its minutes have {frames} frames, and would be of uneven time; give those alike")
    heights = indexing.LazilyIndexedArray(_Minutes(paths, frames, places[0].shape))
    seconds = _MINUTE_S / frames[0] * np.arange(sum(frames))
    return xr.Dataset(
        {
            "Z": (("time", "row", "column"), heights, {"units": "m"}),
            "X_grid": (("row", "column"), places[0], {"units": "m"}),
            "Y_grid": (("row", "column"), places[1], {"units": "m"}),
        },
        {"time": ("time", seconds, {"units": "s"})},
    )


def _minute_files(path: Path) -> list[Path]:
    """The minutes of a video in a folder, or from a file on, in their order; none of another file or folder."""
    folder, first = (path, -1) if path.is_dir() else (path.parent, int(_minute_number(path) or -1))
    if not path.is_dir() and first < 0:
        return []
    found = [each for each in folder.iterdir() if _HEIGHTS.search(each.name) and int(_minute_number(each)) >= first]
    return sorted(found, key=lambda each: int(_minute_number(each)))


def _minute_number(path: Path) -> str:
    found = _HEIGHTS.search(path.name)
    return found[1] if found else ""


@lru_cache(maxsize=2)
def _read_minute(path: Path, _: int) -> NDArray[np.floating]:
    return _read(path, "zgrid")


def _read(path: Path, name: str) -> NDArray[np.floating]:
    """An array as Matlab has it, single precision where the file has that."""
    return np.asarray(_find_array(read_matlab(path, [name], lambda array, _: array[()])[1], name, path))


def _array_shape(path: Path, name: str) -> tuple[int, ...]:
    with open_file(path) as opened:
        if packed := b"MATLAB 7.3" not in opened.read(128):
            opened.seek(0)
            check_version_5(opened, path)
        shapes = {each: shape for each, shape, _ in whosmat(opened)} if packed else {}
    if packed:
        found = tuple(_find_array(shapes, name, path))
    else:
        with open_hdf5(path) as file:
            found = tuple(reversed(_find_array(file, name, path).shape))
    if len(found) != 3:
        raise InputError(f"sea.file = '{path}': {name} has axes {found}; must be points by points by frames")
    return found


def _find_array(held: Any, name: str, path: Path) -> Any:
    if name not in held:
        raise InputError(f"sea.file = '{path}': holds no {name}; give the data's own file")
    return held[name]


_SLANTED = 1e-3  # of a step, by which the points of a row may leave it


def open_layout(path: Path) -> xr.Dataset:
    """The file's variables, not yet read, with plain attributes. Raises InputError, OSError or ValueError where that
    cannot be."""
    return plain_attributes(_open(path))


def _open(path: Path) -> xr.Dataset:
    wanted, named = "a recorded sea", f"sea.file = '{path}'"
    if not path.is_dir():
        check_file(path, wanted, named=named)
    if _minute_files(path):  # a file of a minute of such a video, or a folder of them
        return _grid_with_axes(open_stereo_bursts(path))
    if path.is_dir():
        check_store(path, wanted, named=named)
        return xr.open_zarr(path, chunks=None, consolidated=False, decode_timedelta=False)
    if is_hos_ocean(path):
        return open_hos_ocean(path)
    with warnings.catch_warnings():
        warnings.simplefilter("ignore")  # of how seconds will be read one day: they are taken as they are
        opened = open_dataset(path, wanted, named=named, chunks=None, cache=False, decode_timedelta=False)
    return _grid_with_axes(opened) if {"X_grid", "Y_grid", "Z"} <= set(opened.variables) else opened


def _grid_with_axes(opened: xr.Dataset) -> xr.Dataset:
    """A grid with one axis each instead of the places of all points."""
    frames, rows, columns = opened["Z"].dims
    x, y = (np.asarray(opened[name].values, dtype=np.float64) for name in ("X_grid", "Y_grid"))
    if x.shape != y.shape or x.ndim != 2 or min(x.shape) < 2 or opened["Z"].shape[1:] != x.shape:
        raise Refusal("X_grid and Y_grid do not hold the places of Z's points; mend it")
    if np.ptp(x, axis=0).max() > np.ptp(x, axis=1).max():  # along rows, not columns
        x, y, rows, columns = x.T, y.T, columns, rows
    step = max(np.abs(np.diff(x, axis=1)).max(), np.abs(np.diff(y, axis=0)).max())
    if not max(np.ptp(x, axis=0).max(), np.ptp(y, axis=1).max()) <= _SLANTED * step:
        raise Refusal(
            "the points of X_grid and Y_grid do not lie in rows and columns along x and y; resample it on such a grid"
        )
    named = {frames: "time", rows: "y", columns: "x", "Z": "elevation"}
    values = opened[["Z"]].drop_vars(["x", "y", "time"], errors="ignore")
    values = values.drop_vars([name for name in map(str, (frames, rows, columns)) if name in values.coords])
    values = values.rename({old: new for old, new in named.items() if old != new})
    units = {name: str(opened[grid].attrs.get("units", "m")) for name, grid in (("x", "X_grid"), ("y", "Y_grid"))}
    if "time" not in opened.variables:
        raise Refusal("has no `time` of its frames; add it, in seconds")
    time = opened["time"]
    return values.assign_coords(
        time=("time", time.values.ravel(), {"units": time.attrs.get("units", "s")}),
        x=("x", x[0], {"units": units["x"]}),
        y=("y", y[:, 0], {"units": units["y"]}),
    )
