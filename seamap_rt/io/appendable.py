"""A NetCDF file that grows turn by turn, and appears under its own name when it is whole."""

from __future__ import annotations

import contextlib
import os
import shutil
from collections.abc import Hashable, Iterator, Mapping
from pathlib import Path
from typing import Any, Self

import numpy as np
import xarray as xr

from .opening import open_tree
from .process import uninterrupted
from .results_folder import write_whole
from .turn_files import join_turns, part_of, turn_files, write_turn

_CHUNK = 1024  # points a side of a packed chunk, and turns or samples of one that is no field
_PACKED = {"zlib": True, "complevel": 4, "shuffle": True}  # higher levels gain a few per cent


class AppendableNetCDF:
    """A NetCDF file whose turns are kept beside it (`turn_files`) until it is closed.

    Leaving the context by an exception closes it too: whole turns stay readable. Nothing appears if there are none.
    Where the disk has no room for the file its turns stay, and `recover_netcdf` makes it of them.
    `complete` counts the turns that are whole.

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
        self.path, self.complete, self._before = path, whole, whole
        self._growing, self._constant = growing, constant or {}
        self._compressed, self._rounding = compressed, rounding or {}
        self._folder, self._attributes = part_of(path), dict[str, Any]()
        self._sizes: dict[str, dict[Hashable, int]] = {}  # of a turn, but for what grows, by group
        if whole:
            self._go_on()
        else:
            shutil.rmtree(self._folder, ignore_errors=True)

    def append(self, data: xr.Dataset | xr.DataTree) -> None:
        """Append a turn, or the first ones at once: a dataset, or a tree with a group for each of its children.

        Ctrl-C and SIGTERM wait. Raises OSError, and stays as it was, where the disk has no room for it.
        """
        groups = {"": data} if isinstance(data, xr.Dataset) else {str(n.name): n.to_dataset() for n in data.values()}
        groups = {name: self._rounded(dataset) for name, dataset in groups.items()}
        turns = next(each.sizes[self._growing[0]] for each in groups.values() if self._growing[0] in each.sizes)
        sizes = {name: {d: n for d, n in each.sizes.items() if d not in self._growing} for name, each in groups.items()}
        if self._sizes not in ({}, sizes) or (turns > 1 and self.complete):
            raise ValueError(f"{self.path}: {turns} turns of {sizes}, after others of {self._sizes}")
        with uninterrupted(), _naming(self.path):
            if not self.complete:
                self._folder.mkdir(exist_ok=True)
                write_whole(self._folder / f"{turns}.nc", self._netcdf(groups | dict(self._constant)))
            else:
                arrays = {
                    f"{group}/{name}".lstrip("/"): variable.values
                    for group, dataset in groups.items()
                    for name, variable in self._growing_in(dataset).items()
                }
                write_turn(self._folder, self.complete, arrays)
            self._before, self.complete, self._sizes = self.complete, self.complete + turns, sizes

    def rollback(self) -> None:
        """Forget what was appended last."""
        if self.complete > self._before:
            turn_files(self._folder)[-1].unlink()
            self.complete = self._before

    def annotate(self, attributes: Mapping[str, Any]) -> None:
        """Set attributes of the file when it is closed."""
        self._attributes.update(attributes)

    def close(self) -> None:
        """Make the file of its turns. Ctrl-C and SIGTERM wait. OSError where the disk is full: then its turns stay."""
        with uninterrupted(), _naming(self.path):
            if self.complete:
                join_turns(self._folder, self.complete, self.path, self._attributes)
            shutil.rmtree(self._folder, ignore_errors=True)

    def __enter__(self) -> Self:
        return self

    def __exit__(self, *raised: Any) -> None:
        try:
            self.close()
        except OSError:
            if raised[1] is None:  # else that one is reported
                raise

    def _go_on(self) -> None:
        """Bring what is there to the turns that are wanted, all of them in the file of the first ones."""
        if self.path.exists():
            with open_tree(self.path, decode_times=False) as tree:
                turns = max(node.sizes.get(self._growing[0], 0) for node in tree.subtree)
            shutil.rmtree(self._folder, ignore_errors=True)
            self._folder.mkdir()
            os.replace(self.path, self._folder / f"{turns}.nc")
        begun = self._folder / f"{self.complete}.nc"
        join_turns(self._folder, self.complete, begun)
        for each in self._folder.iterdir():
            if each != begun:
                each.unlink()

    def _netcdf(self, groups: Mapping[str, xr.Dataset]) -> memoryview:
        """A NetCDF file of the first turns, in memory: HDF5 itself may crash if it cannot write."""
        tree = xr.DataTree.from_dict({f"/{name}": dataset.drop_encoding() for name, dataset in groups.items()})
        return tree.to_netcdf(
            engine="h5netcdf",
            encoding={f"/{name}": self._layout(dataset) for name, dataset in groups.items()},
            unlimited_dims={f"/{name}": [d for d in self._growing if d in each.dims] for name, each in groups.items()},
        )

    def _layout(self, dataset: xr.Dataset) -> dict[Hashable, dict[str, Any]]:
        """Chunks of what grows: one turn of a field, and many of what is short."""
        layout: dict[Hashable, dict[str, Any]] = {}
        for name, variable in self._growing_in(dataset).items():
            packed, ahead = self._compressed and self._is_field(variable), 1 if self._is_field(variable) else _CHUNK
            sizes = zip(variable.dims, variable.shape, strict=True)
            longest = _CHUNK if packed else max(variable.shape)
            chunks = (ahead if dim in self._growing else min(size, longest) for dim, size in sizes)
            layout[name] = {"chunksizes": tuple(chunks)} | (_PACKED if packed else {})
        return layout

    def _growing_in(self, dataset: xr.Dataset) -> dict[Hashable, xr.Variable]:
        return {n: v for n, v in dataset.variables.items() if not set(self._growing).isdisjoint(v.dims)}

    def _is_field(self, variable: xr.Variable) -> bool:
        return variable.ndim > 1 and variable.dims[0] in self._growing

    def _rounded(self, dataset: xr.Dataset) -> xr.Dataset:
        for name, variable in dataset.variables.items() if self._rounding else ():
            step = self._rounding.get(variable.attrs.get("units", ""))
            if step is not None and variable.dtype.kind == "f" and self._is_field(variable):
                before = f"{variable.attrs['comment']}; " if "comment" in variable.attrs else ""
                attributes = variable.attrs | {"comment": f"{before}rounded to multiples of {step:.3g}"}
                values = step * np.round(variable.values / step)
                dataset = dataset.assign({name: (variable.dims, values, attributes)})
        return dataset


def recover_netcdf(path: Path, turns: int) -> None:
    """Make a file of the first so many of the turns that a kill has left; none: remove what is left.

    May itself be killed and called again. Raises OSError, and ValueError for what an earlier version left.
    """
    if turns:
        join_turns(part_of(path), turns, path)
    shutil.rmtree(part_of(path), ignore_errors=True)


@contextlib.contextmanager
def _naming(path: Path) -> Iterator[None]:
    """An error of the disk names the file as the user knows it."""
    try:
        yield
    except OSError as error:
        if error.errno is None:
            raise
        raise OSError(error.errno, os.strerror(error.errno), str(path)) from None
