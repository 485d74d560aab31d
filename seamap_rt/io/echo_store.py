"""The Zarr store into which a run streams its echoes turn by turn, and out of which whole turns are read.

A process that is killed while the store grows leaves arrays of unequal length, the last turn in part; they are read as
far as all turns are whole.
"""

from __future__ import annotations

import itertools
import shutil
from pathlib import Path
from types import TracebackType
from typing import Self

import numpy as np
import xarray as xr
import zarr

from ..errors import SchemaError

_PULSES_A_CHUNK = 2000
_COORDINATES = "time azimuth transmitter turn"  # beside the dimensions
_EMPTY_CHUNKS = "written"  # also those of zeros alone, as of a lower antenna that alone transmits


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
            with zarr.config.set({"array.write_empty_chunks": True}):
                for name, values in rolling.items():
                    array = self._group[name]
                    array.resize((start + values.shape[0], *array.shape[1:]))  # type: ignore[union-attr]
                    array[start:] = values  # type: ignore[index]
        except BaseException:  # interrupted, or no space left: arrays of unlike length could not be read any more
            _shorten(self._group, start)
            raise
        complete = int(turn.attrs["complete_turns"])
        self._before, self._length = self._length, (complete, start + turn.sizes["pulse"])
        self._say_complete()

    def take_back(self) -> None:
        """Forget the turn that was appended last."""
        if self._group is not None and self._length != self._before:
            self._length = self._before
            self._say_complete()  # first: then what is longer is not read
            _shorten(self._group, self._length[1])

    def _say_complete(self) -> None:
        assert self._group is not None
        turns, pulses = self._length
        self._group.attrs.update({"complete_turns": turns, "complete_pulses": pulses})

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
                compressors=None,  # noise does not compress, and a turn must be written in a fraction of a second
                dimension_names=[str(d) for d in variable.dims],
                attributes={k: (v.tolist() if isinstance(v, np.ndarray) else v) for k, v in variable.attrs.items()},
                config={"write_empty_chunks": True},
            )
            if not rolling:
                array[...] = variable.values
        group.attrs.update(
            {
                **turn.attrs,
                "complete_turns": 0,
                "complete_pulses": 0,
                "coordinates": _COORDINATES,
                "empty_chunks": _EMPTY_CHUNKS,
            }
        )
        return group


def _shorten(group: zarr.Group, pulses: int) -> None:
    """Bring all that grows by pulses to one length."""
    for _, array in group.arrays():
        if array.metadata.dimension_names[0] == "pulse":  # type: ignore[union-attr,index]
            array.resize((pulses, *array.shape[1:]))


def read_echoes(path: str | Path) -> xr.Dataset:
    """The whole turns of a store, read when their values are asked for.

    Raises SchemaError for what is no store, is damaged, or lacks a chunk of them: Zarr would read it as zeros, which
    are echoes of nothing.
    """
    try:
        group = zarr.open_group(path, mode="r", zarr_format=3)
        complete = int(group.attrs["complete_turns"])  # type: ignore[arg-type]
        arrays = dict(group.arrays())
        rolling = {name: array.shape[0] for name, array in arrays.items() if _dimensions(array)[:1] == ("pulse",)}
        pulses = 0
        if "turn" in arrays:
            counted = group.attrs.get("complete_pulses")  # a store that grew by other hands does not count them
            _refuse_lacking(path, "turn", arrays["turn"], counted, group.attrs)  # type: ignore[arg-type]
            pulses = int(np.count_nonzero(np.asarray(arrays["turn"][:counted]) < complete))  # type: ignore[operator,misc]
        for name, array in arrays.items():
            _refuse_lacking(path, name, array, pulses if name in rolling else None, group.attrs)
        parts = []
        for length in sorted(set(rolling.values()) or {0}):
            others = [name for name in rolling if rolling[name] != length]
            parts.append(xr.open_zarr(path, consolidated=False, zarr_format=3, drop_variables=others))
        whole = [part.isel(pulse=slice(0, pulses)) if "pulse" in part.dims else part for part in parts]
        dataset = xr.merge(whole, combine_attrs="override", compat="override", join="override")
    except SchemaError:
        raise
    # Whatever the libraries raise for a file that is missing, cut short or of another kind.
    except (OSError, ValueError, KeyError, TypeError, AttributeError, IndexError, RuntimeError) as error:
        raise SchemaError(f"'{path}': is not an echo store that can be read ({error}); give an echoes.zarr") from None
    return dataset.set_coords([name for name in _COORDINATES.split() if name in dataset])


def _dimensions(array: zarr.Array) -> tuple[str | None, ...]:
    return tuple(array.metadata.dimension_names or ())  # type: ignore[union-attr]


def _refuse_lacking(path: str | Path, name: str, array: zarr.Array, pulses: int | None, attrs: object) -> None:
    """Refuse an array of which a chunk of those pulses, or any, is missing or cut short.

    Stores of others may leave out chunks of zeros; voltages are never zeros alone.
    """
    folder = Path(path) / name
    if not folder.is_dir() or (name != "voltage" and dict(attrs).get("empty_chunks") != _EMPTY_CHUNKS):  # type: ignore[call-overload]
        return
    shape = array.shape if pulses is None else (pulses, *array.shape[1:])
    counts = [-(-length // chunk) for length, chunk in zip(shape, array.chunks, strict=True)]
    plain = not array.compressors
    size = int(np.prod(array.chunks)) * array.dtype.itemsize
    for index in itertools.product(*(range(count) for count in counts)):
        key = array.metadata.encode_chunk_key(index)
        file = folder / key
        if not file.is_file():
            raise SchemaError(f"'{path}': lacks the chunk {name}/{key}; copy the store again")
        if plain and file.stat().st_size != size:
            raise SchemaError(f"'{path}': the chunk {name}/{key} is cut short; copy the store again")
