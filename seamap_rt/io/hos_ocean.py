"""The surface that HOS-ocean writes, `Results/3d.dat`: text for Tecplot, a zone a time, read a zone at a time.

By the program's own output routine: comments begin with #; `VARIABLES="x","y","eta","phis"`; each zone is headed by its
time (`SOLUTIONTIME = ` or `T = "`), rounded to a hundredth of a second, and `I=`, `J=`, the points along x and y. Lines
of the first zone have x [m], y [m], η [m] and φs [m²/s], x fastest; those of later ones η and φs. The patch repeats.
"""

from __future__ import annotations

import re
from collections.abc import Iterator
from pathlib import Path
from typing import Any, BinaryIO

import numpy as np
import xarray as xr
from numpy.typing import NDArray
from xarray.backends import BackendArray
from xarray.core import indexing

from ..errors import InputError
from .opening import open_file

_ZONE = re.compile(rb'ZONE\s+(?:SOLUTIONTIME\s*=|T\s*=\s*")\s*([-+.\dEe]+)"?.*?I=\s*(\d+)\s*,\s*J=\s*(\d+)')
_LONGEST = 10_000  # bytes of a line
_ROUNDED_S = 0.006  # half the last digit of a time, and a little


class _Zones(BackendArray):
    """A column of all zones as an array (time, y, x)."""

    def __init__(self, path: Path, starts: list[int], size: tuple[int, int], column: int) -> None:
        self._path, self._starts, self._column = path, starts, column
        self.shape = len(starts), size[1], size[0]
        self.dtype = np.dtype(np.float64)

    def __getitem__(self, key: indexing.ExplicitIndexer) -> Any:
        return indexing.explicit_indexing_adapter(key, self.shape, indexing.IndexingSupport.BASIC, self._values)

    def _values(self, key: tuple[Any, ...]) -> NDArray[np.float64]:
        zones = np.arange(self.shape[0])[key[0]]
        if np.ndim(zones) == 0:
            return self._zone(int(zones))[key[1:]]
        return np.stack([self._zone(int(zone)) for zone in zones])[(slice(None), *key[1:])]

    def _zone(self, number: int) -> NDArray[np.float64]:
        columns = 4 if number == 0 else 2
        with open_file(self._path) as file:
            file.seek(self._starts[number])
            count = self.shape[1] * self.shape[2]
            values = np.loadtxt(_lines(file), max_rows=count, usecols=columns - 2 + self._column, ndmin=1)
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
        for line in _lines(file):
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
        raise InputError(f"sea.file = '{path}': holds no whole zone; give HOS-ocean's 3d.dat")
    x = _corner(path, starts[0], size[0], 0)
    y = _corner(path, starts[0], size[0] * size[1], 1)[:: size[0]]
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


def _corner(path: Path, start: int, rows: int, column: int) -> NDArray[np.float64]:
    """The first rows of a column of the first zone."""
    with open_file(path) as file:
        file.seek(start)
        return np.loadtxt(_lines(file), max_rows=rows, usecols=column, ndmin=1)


def _lines(file: BinaryIO) -> Iterator[bytes]:
    """The lines of a file, which may be moved in between."""
    while line := file.readline(_LONGEST):
        if len(line) == _LONGEST:
            raise ValueError(f"a line is longer than {_LONGEST} bytes")
        yield line
