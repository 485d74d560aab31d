"""Moments of the sea in a NetCDF file that grows by times."""

from __future__ import annotations

from collections.abc import Mapping
from pathlib import Path
from typing import Any

import h5netcdf
import numpy as np
import xarray as xr

from .growing import GrowingFile

_LONGEST_CHUNK = 1024  # points a side
_COMPRESSION = 4  # of zlib's levels; higher ones gain a few per cent
_INCOMPRESSIBLE = 1.01  # zlib lets what it cannot compress grow by less than this

# Rounding by units, powers of two: below what the sea itself is exact to, and the digits beyond it do not compress.
ROUNDING = {"m": 2.0**-13, "1": 2.0**-14, "m s-1": 2.0**-11, "dB": 2.0**-6}


class SeaFile(GrowingFile):
    """The fields of a sea with a leading `time` dimension at the root, appended one time at a time.

    `groups` hold what does not change in time.
    """

    def __init__(self, path: Path, groups: Mapping[str, xr.Dataset]) -> None:
        super().__init__(path, ("time",))
        self._groups = groups

    def append(self, moment: xr.Dataset) -> None:
        """Append one moment, a dataset with `time` of length 1."""
        new = (moment, *(() if self.complete else self._groups.values()))
        room = int(_INCOMPRESSIBLE * sum(each.nbytes for each in new))
        file = self._opened(room, sum(len(each.variables) for each in new))
        if not self.complete:
            _create(file, moment)
            for name, dataset in self._groups.items():
                _create(file.create_group(name), dataset)
        file.resize_dimension("time", self.complete + 1)
        for name, variable in moment.variables.items():
            if "time" in variable.dims:
                values, step = variable.values[0], _step(variable)
                file.variables[str(name)][self.complete] = values if step is None else step * np.round(values / step)
        self._count({"time": self.complete + 1})

    def _cut(self, file: h5netcdf.File) -> None:
        file.resize_dimension("time", self.complete)


def _create(group: h5netcdf.Group, dataset: xr.Dataset) -> None:
    """Dimensions, attributes and variables of a group; the values of what does not grow."""
    group.dimensions = {str(d): (None if d == "time" else int(n)) for d, n in dataset.sizes.items()}
    group.attrs.update({str(k): v for k, v in dataset.attrs.items()})
    for key, variable in dataset.variables.items():
        dims, attributes = tuple(str(d) for d in variable.dims), {str(k): v for k, v in variable.attrs.items()}
        packing: dict[str, Any] = {}
        if "time" in dims and len(dims) > 1:
            chunks = (1, *(min(size, _LONGEST_CHUNK) for size in variable.shape[1:]))
            packing = {"chunks": chunks, "compression": "gzip", "compression_opts": _COMPRESSION, "shuffle": True}
            packing["fillvalue"] = np.nan if variable.dtype.kind == "f" else None
        step = _step(variable)
        if step is not None:
            said = f"{attributes['comment']}; " if "comment" in attributes else ""
            attributes["comment"] = f"{said}rounded to multiples of {step:.3g}"
        made = group.create_variable(str(key), dims, variable.dtype, **packing)
        made.attrs.update(attributes)
        if "time" not in variable.dims:
            made[...] = variable.values


def _step(variable: xr.Variable) -> float | None:
    """To whose multiples a field is rounded; None where it is kept as it is."""
    field = "time" in variable.dims and variable.ndim > 1 and variable.dtype.kind == "f"
    return ROUNDING.get(variable.attrs["units"]) if field else None
