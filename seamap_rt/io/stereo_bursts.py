"""The stereo videos of Schwendeman & Thomson (hdl 1773/38314), `XYZResults`: Matlab files of a minute each.

By the data's own description: `XYGrid_01.mat` holds `xgrid` and `ygrid`, the places of all points in m (161 × 161, −20
to 20 m, 0.25 m apart, x downwind), and `ZGrid_01.mat` holds `zgrid`, their heights in m over frames, 300 at 5 Hz or 450
at 7.5 Hz: a minute. Those that follow, `_02` and so on, go on where it ends. Matlab writes either its own format (to
version 7) or HDF5 (7.3), whose axes are the other way round; a minute is read at a time, and the last two are kept.
"""

from __future__ import annotations

import re
from functools import lru_cache
from pathlib import Path
from typing import Any

import numpy as np
import xarray as xr
from numpy.typing import NDArray
from scipy.io import whosmat
from xarray.backends import BackendArray
from xarray.core import indexing

from ..errors import InputError
from .matlab import read_matlab
from .opening import open_file, open_hdf5

_HEIGHTS = re.compile(r"ZGrid_(\d+)\.mat$")
_MINUTE_S = 60.0


class _Minutes(BackendArray):
    """The heights of all minutes as an array (time, row, column)."""

    def __init__(self, paths: list[Path], frames: list[int], size: tuple[int, int]) -> None:
        self._paths, self._ends = paths, np.cumsum(frames)
        self.shape = int(self._ends[-1]), *size
        self.dtype = np.dtype(np.float64)

    def __getitem__(self, key: indexing.ExplicitIndexer) -> Any:
        return indexing.explicit_indexing_adapter(key, self.shape, indexing.IndexingSupport.BASIC, self._values)

    def _values(self, key: tuple[Any, ...]) -> NDArray[np.float64]:
        frames = np.arange(self.shape[0])[key[0]]
        if np.ndim(frames) == 0:
            return self._frame(int(frames))[key[1:]]
        return np.stack([self._frame(int(frame)) for frame in frames])[(slice(None), *key[1:])]

    def _frame(self, number: int) -> NDArray[np.float64]:
        minute = int(np.searchsorted(self._ends, number, side="right"))
        before = int(self._ends[minute - 1]) if minute else 0
        path = self._paths[minute]
        return _minute(path, path.stat().st_mtime_ns)[:, :, number - before].astype(np.float64)


def is_stereo_burst(path: Path) -> bool:
    """Whether a file is a minute of such a video, or a folder holds them."""
    return bool(_minutes_of(path))


def open_stereo_bursts(path: Path) -> xr.Dataset:
    """elevation (time, row, column), not yet read, and the places of its points X_grid and Y_grid in m, from a folder
    or from its first file on. Raises InputError where minutes or their places are missing."""
    wrong, paths = f"sea.file = '{path}': ", _minutes_of(path)
    numbers = [int(_number(each)) for each in paths]
    if numbers != list(range(numbers[0], numbers[0] + len(numbers))):
        raise InputError(f"{wrong}minutes {numbers} do not follow each other; name the first of those that do")
    beside = paths[0].with_name(f"XYGrid_{_number(paths[0])}.mat")
    if not beside.is_file():
        raise InputError(f"{wrong}{beside.name} is not beside {paths[0].name}; put the places of the points there")
    places = [_read(beside, name) for name in ("xgrid", "ygrid")]
    frames = [_shape(each, "zgrid")[2] for each in paths]
    if any(_shape(each, "zgrid")[:2] != places[0].shape for each in paths):
        raise InputError(f"{wrong}zgrid has other points than xgrid of {beside.name}; give files that belong together")
    if any(each != frames[0] for each in frames[:-1]):
        raise InputError(f"{wrong}its minutes have {frames} frames, and would be of uneven time; give those alike")
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


def _minutes_of(path: Path) -> list[Path]:
    """The minutes of a folder, or from a file on, in their order."""
    folder, first = (path, -1) if path.is_dir() else (path.parent, int(_number(path) or -1))
    if not path.is_dir() and first < 0:
        return []
    found = [each for each in folder.iterdir() if _HEIGHTS.search(each.name) and int(_number(each)) >= first]
    return sorted(found, key=lambda each: int(_number(each)))


def _number(path: Path) -> str:
    found = _HEIGHTS.search(path.name)
    return found[1] if found else ""


@lru_cache(maxsize=2)
def _minute(path: Path, _: int) -> NDArray[np.floating]:
    return _read(path, "zgrid")


def _read(path: Path, name: str) -> NDArray[np.floating]:
    """An array as Matlab has it, single precision where the file has that."""
    return np.asarray(_there(read_matlab(path, [name], lambda array, _: array[()])[1], name, path))


def _shape(path: Path, name: str) -> tuple[int, ...]:
    with open_file(path) as opened:
        packed = b"MATLAB 7.3" not in opened.read(128)
        shapes = {each: shape for each, shape, _ in whosmat(opened)} if packed else {}
    if packed:
        found = tuple(_there(shapes, name, path))
    else:
        with open_hdf5(path) as file:
            found = tuple(reversed(_there(file, name, path).shape))
    if len(found) != 3:
        raise InputError(f"sea.file = '{path}': {name} has axes {found}; must be points by points by frames")
    return found


def _there(held: Any, name: str, path: Path) -> Any:
    if name not in held:
        raise InputError(f"sea.file = '{path}': holds no {name}; give the data's own file")
    return held[name]
