"""A NetCDF file that grows by turns, and appears under its own name only when it is closed."""

from __future__ import annotations

import os
import signal
import threading
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path
from types import TracebackType

import h5netcdf
import numpy as np
import xarray as xr


@contextmanager
def uninterrupted() -> Iterator[None]:
    """Hold Ctrl-C and SIGTERM back while a turn is written, so that every file ends with the same turn."""
    held: list[int] = []
    before = {}
    if threading.current_thread() is threading.main_thread():  # only there do signals interrupt
        before = {number: signal.getsignal(number) for number in (signal.SIGINT, signal.SIGTERM)}
    for number in before:
        signal.signal(number, lambda number, _: held.append(number))
    try:
        yield
    finally:
        for number, handler in before.items():
            signal.signal(number, signal.SIG_DFL if handler is None else handler)
        for number in held[:1]:
            signal.raise_signal(number)


class TurnFile:
    """Groups of datasets with a leading `turn` dimension, appended one turn at a time.

    Closing renames the file into place; so does leaving the context by an exception, if at least one turn is complete:
    what is complete stays readable.
    """

    def __init__(self, path: Path) -> None:
        self.path = path
        self._part = path.with_name(f".{path.name}.part")
        self._part.unlink(missing_ok=True)
        self._file: h5netcdf.File | None = None
        self.turns = 0

    def append(self, tree: xr.DataTree) -> None:
        """Append one turn: every group of the tree, each with `turn` of length 1."""
        if self._file is None:
            self._file = h5netcdf.File(self._part, "w")
        for node in tree.children.values():
            dataset = node.to_dataset()
            if self.turns == 0:
                self._create(str(node.name), dataset)
            group = self._file[str(node.name)]
            group.resize_dimension("turn", self.turns + 1)
            for name, variable in dataset.variables.items():
                if "turn" in variable.dims:
                    group.variables[str(name)][self.turns] = variable.values[0]
        self.turns += 1
        self._file.flush()

    def _create(self, name: str, dataset: xr.Dataset) -> None:
        assert self._file is not None
        group = self._file.create_group(name)
        group.dimensions = {str(d): (None if d == "turn" else int(n)) for d, n in dataset.sizes.items()}
        group.attrs.update({str(k): v for k, v in dataset.attrs.items()})
        for key, variable in dataset.variables.items():
            fill = np.nan if variable.dtype.kind == "f" else None
            made = group.create_variable(str(key), tuple(str(d) for d in variable.dims), variable.dtype, fillvalue=fill)
            made.attrs.update({str(k): v for k, v in variable.attrs.items()})
            if "turn" not in variable.dims:
                made[...] = variable.values
        coordinates = [str(c) for c in dataset.coords if c not in dataset.dims]
        if coordinates:
            group.attrs["coordinates"] = " ".join(coordinates)

    def close(self) -> None:
        """Finish the file; nothing appears if no turn was appended."""
        if self._file is not None:
            for group in self._file.groups.values() if self.turns else ():
                group.resize_dimension("turn", self.turns)  # a turn that failed halfway goes
            self._file.close()
            self._file = None
            if self.turns:
                os.replace(self._part, self.path)
        self._part.unlink(missing_ok=True)

    def __enter__(self) -> TurnFile:
        return self

    def __exit__(
        self, kind: type[BaseException] | None, error: BaseException | None, trace: TracebackType | None
    ) -> None:
        self.close()
