"""The Zarr store into which a run streams its echoes turn by turn."""

from __future__ import annotations

import shutil
from pathlib import Path
from types import TracebackType
from typing import Any, Self

import numpy as np
import xarray as xr
import zarr

from .stored_chunks import EVERY_CHUNK

_PULSES_A_CHUNK = 2000
_EVERY: Any = {"write_empty_chunks": True}  # zeros too: a chunk that is not there is lost
_COORDINATES = "time azimuth transmitter turn"  # beside the dimensions


class EchoStore:
    """A Zarr group that grows by whole turns; its attribute `complete_turns` counts those that are all there.

    Left as a context without a single one, it leaves nothing behind.
    """

    def __init__(self, path: Path) -> None:
        self.path = path
        self._group: zarr.Group | None = None
        self._begun = False
        self._length = self._before = (0, 0)  # turns and pulses that are complete, and were before the last turn

    def append(self, turn: xr.Dataset) -> None:
        """Append one turn's echoes (schema `echoes`), or none of it where the disk has no room: then OSError."""
        if self._group is None:
            self._group = self._create(turn)
        _, start = self._length
        rolling = {str(n): v.values for n, v in turn.variables.items() if v.dims[0] == "pulse"}
        try:
            for name, values in rolling.items():
                array = self._group[name].with_config(_EVERY)  # type: ignore[union-attr]
                array.resize((start + values.shape[0], *array.shape[1:]))
                array[start:] = values
        except BaseException:  # interrupted, or no space left: arrays of unlike length could not be read any more
            _shorten(self._group, start)
            raise
        complete = int(turn.attrs["complete_turns"])
        self._group.attrs["complete_turns"] = complete
        self._before, self._length = self._length, (complete, start + turn.sizes["pulse"])

    def take_back(self) -> None:
        """Forget the turn that was appended last."""
        if self._group is not None and self._length != self._before:
            self._length = self._before
            self._group.attrs["complete_turns"], pulses = self._length  # first: then what is longer is not read
            _shorten(self._group, pulses)

    def __enter__(self) -> Self:
        return self

    def __exit__(
        self, kind: type[BaseException] | None, error: BaseException | None, trace: TracebackType | None
    ) -> None:
        turns, _ = self._length
        if self._begun and not turns:
            shutil.rmtree(self.path, ignore_errors=True)

    def _create(self, turn: xr.Dataset) -> zarr.Group:
        if self.path.exists():
            shutil.rmtree(self.path)
        self._begun = True
        group = zarr.open_group(self.path, mode="w", zarr_format=3)
        for name, variable in turn.variables.items():
            rolling = variable.dims[0] == "pulse"
            shape = (0, *variable.shape[1:]) if rolling else variable.shape
            chunks = (_PULSES_A_CHUNK, *variable.shape[1:]) if rolling else variable.shape
            array = group.create_array(
                str(name),
                shape=shape,
                dtype=variable.dtype,
                chunks=chunks,
                config=_EVERY,
                compressors=None,  # noise does not compress, and a turn must be written in a fraction of a second
                dimension_names=[str(d) for d in variable.dims],
                attributes={k: (v.tolist() if isinstance(v, np.ndarray) else v) for k, v in variable.attrs.items()},
            )
            if not rolling:
                array[...] = variable.values
        group.attrs.update({**turn.attrs, "complete_turns": 0, "coordinates": _COORDINATES, EVERY_CHUNK: 1})
        return group


def _shorten(group: zarr.Group, pulses: int) -> None:
    """Bring all that grows by pulses to one length."""
    for _, array in group.arrays():
        if array.metadata.dimension_names[0] == "pulse":  # type: ignore[union-attr,index]
            array.resize((pulses, *array.shape[1:]))
