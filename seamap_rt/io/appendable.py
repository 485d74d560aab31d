"""A NetCDF file that grows turn by turn, and appears under its own name when it is whole."""

from __future__ import annotations

import errno
from collections.abc import Mapping
from pathlib import Path
from typing import Any

import numpy as np
import xarray as xr

from .growing_store import ClosedOnExit, GrowingStore, is_field, name_in_errors
from .opening import open_tree
from .process import hold_interruptions
from .results_folder import FILE, hidden_store, remove_tree


class AppendableNetCDF(ClosedOnExit):
    """A NetCDF file whose turns are kept in a hidden Zarr store beside it (`growing_store`) until it is closed.

    Whole turns stay readable after an exception. Nothing appears if there are none. Where the disk has no room for the
    file its turns stay, and `recovery` makes it of them. `complete` counts the turns that are whole.

    path: the file's own name. growing: names of the dimensions that grow; a variable has one of them at most, and one
    that has none is written with the first turn. constant: groups that do not grow, by name. compressed: fields (a
    growing first dimension and others) are packed by zlib. rounding: by unit, the step to whose multiples fields are
    rounded, and say so in their `comment`. whole: go on after so many turns of what a kill or an interruption has left
    of the file (one dimension grows); OSError, ValueError, KeyError where they are not there. Else it begins anew.
    """

    def __init__(
        self,
        path: Path,
        growing: tuple[str, ...] = ("turn",),
        *,
        constant: Mapping[str, xr.Dataset] | None = None,
        compressed: bool = False,
        rounding: Mapping[str, float] | None = None,
        whole: int = 0,
    ) -> None:
        self.path = path
        self._growing, self._constant, self._rounding = growing, constant or {}, rounding or {}
        self._hidden, self._attributes = hidden_store(path), dict[str, Any]()
        if not whole:
            remove_tree(self._hidden)
        if not whole or path.exists():
            self._store = GrowingStore(self._hidden, growing, {FILE: path}, compressed)
            self._take_back(whole)
        else:
            self._store = GrowingStore.reopen(self._hidden, {FILE: path}, whole)
        if self.complete < whole:
            raise FileNotFoundError(errno.ENOENT, f"no {whole} whole turns", str(path))

    @property
    def complete(self) -> int:
        return self._store.complete

    def append(self, data: xr.Dataset | xr.DataTree) -> None:
        """Append a turn, or the first ones at once: a dataset, or a tree with a group for each of its children.

        Ctrl-C and SIGTERM wait. Raises OSError, and stays as it was, where the disk has no room for it.
        """
        groups = {"": data} if isinstance(data, xr.Dataset) else {str(n.name): n.to_dataset() for n in data.values()}
        groups = {f"/{name}": self._round_fields(dataset) for name, dataset in groups.items()}
        turns = next(each.sizes[self._growing[0]] for each in groups.values() if self._growing[0] in each.sizes)
        groups |= {f"/{name}": dataset for name, dataset in self._constant.items() if not self.complete}
        with name_in_errors(self.path):
            self._store.append({FILE: xr.DataTree.from_dict(groups)}, turns)

    def annotate(self, attributes: Mapping[str, Any]) -> None:
        """Set attributes of the file when it is closed."""
        self._attributes.update(attributes)

    def close(self) -> None:
        """Make the file of its turns. Ctrl-C and SIGTERM wait. OSError where the disk is full: then its turns stay."""
        with hold_interruptions(), name_in_errors(self.path):
            if self.complete:
                self._store.write_files(self._attributes)
            remove_tree(self._hidden)

    def _take_back(self, turns: int) -> None:
        """The first so many turns of the file that an interruption has made of them, one by one."""
        if not turns:
            return
        (dimension,) = self._growing
        with open_tree(self.path, decode_times=False, mask_and_scale=False) as tree:
            for turn in range(turns):
                row = {dimension: slice(turn, turn + 1)}
                groups = {node.path: node.to_dataset().isel(row, missing_dims="ignore") for node in tree.subtree}
                self._store.append({FILE: xr.DataTree.from_dict(groups)})
        self.path.unlink()

    def _round_fields(self, dataset: xr.Dataset) -> xr.Dataset:
        for name, variable in dataset.variables.items() if self._rounding else ():
            step = self._rounding.get(variable.attrs.get("units", ""))
            if step is not None and variable.dtype.kind == "f" and is_field(variable.dims, self._growing):
                before = f"{variable.attrs['comment']}; " if "comment" in variable.attrs else ""
                attributes = variable.attrs | {"comment": f"{before}rounded to multiples of {step:.3g}"}
                values = step * np.round(variable.values / step)
                dataset = dataset.assign({name: (variable.dims, values, attributes)})
        return dataset
