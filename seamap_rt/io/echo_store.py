"""The Zarr store into which a run streams its echoes turn by turn.

Each file of it appears whole, so a kill loses no turn; but it may leave arrays of unlike length. While a store grows,
its attribute `complete_pulses` counts the pulses of the complete turns, and `recover_echoes` cuts off what is beyond.

The store's own description repeats those of its arrays, as long as the complete turns are ("consolidated metadata"),
and is written at once with the number of these: whoever opens the store with `xr.open_zarr` alone sees whole turns,
also while it grows.
"""

from __future__ import annotations

import json
import shutil
from pathlib import Path
from types import TracebackType
from typing import Any, Self

import numpy as np
import xarray as xr
import zarr

from ..compute.machine import pool
from .growing_array import DESCRIPTION, PARTIAL, GrowingArray, write_file
from .opening import read_json
from .quiet import quietly
from .results_folder import write_whole
from .stored_chunks import EVERY_CHUNK

_PULSES_A_CHUNK, _READINGS_A_CHUNK = 2000, 20000  # of voltages, and of what else a pulse has: a file each takes 1 ms
PULSES = "complete_pulses"
_EVERY: Any = {"write_empty_chunks": True}  # zeros too: a chunk that is not there is lost
_COORDINATES = "time azimuth transmitter turn"  # beside the dimensions


class EchoStore:
    """A Zarr group that grows by whole turns; its attribute `complete_turns` counts those that are all there.

    Left as a context without a single one, it leaves nothing behind.
    """

    def __init__(self, path: Path) -> None:
        self.path = path
        self._group: zarr.Group | None = None
        self._arrays: dict[str, GrowingArray] = {}  # those that grow
        self._begun = False
        self._length = self._before = (0, 0)  # turns and pulses that are complete, and were before the last turn

    def append(self, turn: xr.Dataset) -> None:
        """Append one turn's echoes (schema `echoes`), or none of it where the disk has no room: then OSError."""
        if self._group is None:
            self._group = self._create(turn)
        _, start = self._length
        rolling = {str(n): v.values for n, v in turn.variables.items() if v.dims[0] == "pulse"}
        try:
            with pool() as workers:  # the system writes one file beside another; leaving waits for all of them
                list(workers.map(lambda name: self._arrays[name].lengthen(start + turn.sizes["pulse"]), rolling))
                chunks = [each for name, values in rolling.items() for each in self._arrays[name].chunks(start, values)]
                list(workers.map(write_file, *zip(*chunks, strict=True)))
        except BaseException:  # interrupted, or no space left: arrays of unlike length could not be read any more
            _shorten(self._group, start)
            raise
        complete = int(turn.attrs["complete_turns"])
        _describe(self.path, complete, start + turn.sizes["pulse"])
        self._before, self._length = self._length, (complete, start + turn.sizes["pulse"])

    def take_back(self) -> None:
        """Forget the turn that was appended last."""
        if self._group is not None and self._length != self._before:
            self._length = self._before
            _cut(self.path, self._group, *self._length)

    def __enter__(self) -> Self:
        return self

    def __exit__(
        self, kind: type[BaseException] | None, error: BaseException | None, trace: TracebackType | None
    ) -> None:
        turns, _ = self._length
        if self._begun and not turns:
            shutil.rmtree(self.path, ignore_errors=True)
        elif self._group is not None:
            _describe(self.path, *self._length, growing=False)

    def _create(self, turn: xr.Dataset) -> zarr.Group:
        if self.path.exists():
            shutil.rmtree(self.path)
        self._begun = True
        group = zarr.open_group(self.path, mode="w", zarr_format=3)
        for name, variable in turn.variables.items():
            rolling = variable.dims[0] == "pulse"
            shape = (0, *variable.shape[1:]) if rolling else variable.shape
            rows = _PULSES_A_CHUNK if name == "voltage" else _READINGS_A_CHUNK
            chunks = (rows, *variable.shape[1:]) if rolling else variable.shape
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
            if rolling:
                self._arrays[str(name)] = GrowingArray(self.path / str(name))
            else:
                array[...] = variable.values
        attributes = {"complete_turns": 0, "coordinates": _COORDINATES, PULSES: 0, EVERY_CHUNK: 1}
        group.update_attributes({**turn.attrs, **attributes})
        _describe(self.path, 0, 0)
        return group


def _shorten(group: zarr.Group, pulses: int) -> None:
    """Bring all that grows by pulses to one length."""
    with quietly():  # of those whose files somebody has removed
        arrays = [array for _, array in group.arrays()]
    for array in arrays:
        if array.metadata.dimension_names[0] == "pulse":  # type: ignore[union-attr,index]
            array.resize((pulses, *array.shape[1:]))


def _cut(path: Path, group: zarr.Group, turns: int, pulses: int) -> None:
    """Leave so many turns, which have so many pulses. The attributes come first: then what is longer is not read."""
    _describe(path, turns, pulses)
    _shorten(group, pulses)


def _describe(path: Path, turns: int, pulses: int, growing: bool = True) -> None:
    """Say how many turns are complete, and describe all arrays as so many pulses long, in one file that appears whole.

    Zarr's own `consolidate_metadata` would take the arrays as they are, and a second write.
    """
    file = path / DESCRIPTION
    described = json.loads(file.read_text(encoding="utf-8"))
    attributes = described["attributes"]
    attributes.pop(PULSES, None)
    attributes |= {"complete_turns": turns} | ({PULSES: pulses} if growing else {})
    arrays = {}
    for each in sorted(path.glob(f"*/{DESCRIPTION}")):
        array = json.loads(each.read_text(encoding="utf-8"))
        if array["dimension_names"][0] == "pulse":
            array["shape"][0] = pulses
        arrays[each.parent.name] = array
    described["consolidated_metadata"] = {"kind": "inline", "must_understand": False, "metadata": arrays}
    write_whole(file, json.dumps(described))


# ------------------------------------------------------------------------------------------------- after a kill


def is_growing(path: Path) -> bool:
    """Whether a store is being written, or was when its run was killed."""
    attributes = _attributes(path)
    return attributes is None or PULSES in attributes or "complete_turns" not in attributes


def recoverable_turns(path: Path) -> int:
    """How many whole turns are in a store."""
    return int((_attributes(path) or {}).get("complete_turns", 0))


def recover_echoes(path: Path, turns: int) -> None:
    """Leave the first so many turns of a store that a kill has left; none: remove it. May be called again."""
    for left in (*path.rglob(f"*{PARTIAL}"), path / f".{DESCRIPTION}.part"):  # of single files of the store
        left.unlink(missing_ok=True)
    if not turns:
        shutil.rmtree(path, ignore_errors=True)
        return
    group = zarr.open_group(path, mode="r+", zarr_format=3, use_consolidated=False)
    pulses = int(group.attrs[PULSES])  # type: ignore[arg-type]
    if turns < recoverable_turns(path):
        pulses = int(np.searchsorted(np.asarray(group["turn"][:pulses]), turns))  # type: ignore[index]
    _cut(path, group, turns, pulses)
    _describe(path, turns, pulses, growing=False)


def _attributes(path: Path) -> dict[str, Any] | None:
    """What the store says of itself; None where it does not even exist whole."""
    try:
        return dict(read_json(path / DESCRIPTION)["attributes"])
    except (OSError, ValueError, KeyError):
        return None
