"""Maps and truth in a NetCDF file that grows by turns."""

from __future__ import annotations

import h5netcdf
import numpy as np
import xarray as xr

from .growing import GrowingFile


class TurnFile(GrowingFile):
    """Groups of datasets with a leading `turn` dimension, appended one turn at a time."""

    def append(self, tree: xr.DataTree) -> None:
        """Append one turn: every group of the tree, each with `turn` of length 1."""
        datasets = {str(node.name): node.to_dataset() for node in tree.children.values()}
        file = self._opened(
            sum(dataset.nbytes for dataset in datasets.values()),
            sum(len(dataset.variables) for dataset in datasets.values()),
        )
        for name, dataset in datasets.items():
            if self.complete == 0:
                _create(file, name, dataset)
            group = file[name]
            group.resize_dimension("turn", self.complete + 1)
            for key, variable in dataset.variables.items():
                if "turn" in variable.dims:
                    group.variables[str(key)][self.complete] = variable.values[0]
        self._count({"turn": self.complete + 1})

    def _cut(self, file: h5netcdf.File) -> None:
        for group in file.groups.values():
            group.resize_dimension("turn", self.complete)


def _create(file: h5netcdf.File, name: str, dataset: xr.Dataset) -> None:
    group = file.create_group(name)
    group.dimensions = {str(d): (None if d == "turn" else int(n)) for d, n in dataset.sizes.items()}
    group.attrs.update({str(k): v for k, v in dataset.attrs.items()})
    for key, variable in dataset.variables.items():
        dims = tuple(str(d) for d in variable.dims)
        # A chunk is one turn of a field, so that a turn takes as much of the disk as it holds. Numbers come in fours.
        chunks = (1, *variable.shape[1:]) if len(dims) > 1 and "turn" in dims else None
        fill = np.nan if variable.dtype.kind == "f" else None
        made = group.create_variable(str(key), dims, variable.dtype, fillvalue=fill, chunks=chunks)
        made.attrs.update({str(k): v for k, v in variable.attrs.items()})
        if "turn" not in dims:
            made[...] = variable.values
    coordinates = [str(c) for c in dataset.coords if c not in dataset.dims]
    if coordinates:
        group.attrs["coordinates"] = " ".join(coordinates)
