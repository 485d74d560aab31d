"""gauges.nc: grows by turns and by the wires' samples, and appears whole or, interrupted, with whole turns."""

from __future__ import annotations

import os
from pathlib import Path
from types import TracebackType

import h5netcdf
import h5py
import numpy as np
import xarray as xr

_GROWING: tuple[str, ...] = ("turn", "sample")


class GaugeFile:
    """`gauge_series` of one turn after another. Closing renames the file into place; so does leaving the context by an
    exception, if at least one turn is complete. Nothing appears if nothing was appended."""

    def __init__(self, path: Path) -> None:
        self.path = path
        self._part = path.with_name(f".{path.name}.part")
        self._part.unlink(missing_ok=True)
        self._file: h5netcdf.File | None = None
        self._length = dict.fromkeys(_GROWING, 0)

    def append(self, series: xr.Dataset) -> None:
        """Append what was read in one turn or more."""
        if self._file is None:
            self._file = h5netcdf.File(self._part, "w")
            self._create(self._file, series)
        end = {name: length + series.sizes.get(name, 0) for name, length in self._length.items()}
        for name in _GROWING:
            self._file.resize_dimension(name, end[name])
        for name, variable in series.variables.items():
            grows = next((dim for dim in _GROWING if dim in variable.dims), None)
            if grows is not None:  # always the last dimension
                self._file.variables[str(name)][..., self._length[grows] : end[grows]] = variable.values
        self._length = end
        self._file.flush()

    def _create(self, file: h5netcdf.File, series: xr.Dataset) -> None:
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

    def close(self) -> None:
        """Finish the file; a turn that failed halfway goes."""
        if self._file is not None:
            whole = self._length["turn"] > 0
            for name, length in self._length.items() if whole else ():
                self._file.resize_dimension(name, length)
            self._file.close()
            self._file = None
            if whole:
                os.replace(self._part, self.path)
        self._part.unlink(missing_ok=True)

    def __enter__(self) -> GaugeFile:
        return self

    def __exit__(
        self, kind: type[BaseException] | None, error: BaseException | None, trace: TracebackType | None
    ) -> None:
        self.close()
