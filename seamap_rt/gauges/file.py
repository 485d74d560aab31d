"""gauges.nc: grows by turns and by the wires' samples, and appears whole or, interrupted, with whole turns."""

from __future__ import annotations

from pathlib import Path

import h5netcdf
import h5py
import numpy as np
import xarray as xr

from ..io.growing import GrowingFile

_GROWING: tuple[str, ...] = ("turn", "sample")
_CHUNK_BYTES = 16384  # numbers along a dimension that grows are taken from the disk by chunks of some kilobytes


class GaugeFile(GrowingFile):
    """`gauge_series` of one turn after another."""

    def __init__(self, path: Path) -> None:
        super().__init__(path, _GROWING)

    def append(self, series: xr.Dataset) -> None:
        """Append what was read in one turn or more."""
        file = self._opened(series.nbytes + _CHUNK_BYTES * len(series.variables), len(series.variables))
        if not self.complete:
            _create(file, series)
        end = {name: length + series.sizes.get(name, 0) for name, length in self.length.items()}
        for name in _GROWING:
            file.resize_dimension(name, end[name])
        for name, variable in series.variables.items():
            grows = next((dim for dim in _GROWING if dim in variable.dims), None)
            if grows is not None:  # always the last dimension
                file.variables[str(name)][..., self.length[grows] : end[grows]] = variable.values
        self._count(end)

    def _cut(self, file: h5netcdf.File) -> None:
        for name, length in self.length.items():
            file.resize_dimension(name, length)


def _create(file: h5netcdf.File, series: xr.Dataset) -> None:
    file.dimensions = {str(d): int(n) for d, n in series.sizes.items()} | dict.fromkeys(_GROWING)
    file.attrs.update({str(k): v for k, v in series.attrs.items()})
    for key, variable in series.variables.items():
        text = variable.dtype.kind in "UO"
        kind = h5py.string_dtype() if text else variable.dtype
        fill = np.nan if variable.dtype.kind == "f" else None
        made = file.create_variable(str(key), tuple(str(d) for d in variable.dims), kind, fillvalue=fill)
        made.attrs.update({str(k): v for k, v in variable.attrs.items()})
        if not set(_GROWING) & set(variable.dims):
            made[...] = variable.values.astype(object) if text else variable.values
    coordinates = [str(name) for name in series.coords if name not in series.dims]
    if coordinates:
        file.attrs["coordinates"] = " ".join(coordinates)
