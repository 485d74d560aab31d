"""Echoes from a Zarr store: whole turns, or refused in one line.

A process that is killed while the store grows leaves arrays of unequal length, the last turn in part: they are read as
far as all turns are whole.
"""

from __future__ import annotations

import warnings
from pathlib import Path

import numpy as np
import xarray as xr
import zarr

from ...compute.asyncio_log import filter_asyncio_log
from ...dataset import check
from ...errors import InputError, SchemaError
from ...io.echo_store import EVERY_CHUNK, PULSES, check_chunks, names_of
from ...io.opening import bytes_held, check_store, weigh
from .checks import check_attributes

_BULK = ("voltage", "saturated")  # read turn by turn, all else at once
_MAY_LACK = ("transmitter", "turn", "attitude", "flag", "saturated")  # where zeros, and nothing else, are usual
_INDEXES = ("pulse", "range", "receiver", "antenna", "xyz")
_MOST_PULSES = 1e9  # a day at 10 kHz


def open_echoes(path: str | Path) -> xr.Dataset:
    """Echoes from a Zarr store, complete turns only, also while it grows.

    Raises SchemaError for a store that does not keep the schema, InputError for what is no store, or lacks a chunk.
    """
    try:
        with warnings.catch_warnings():
            warnings.simplefilter("ignore")  # of what else lies in the folder: what matters is checked after
            check_store(path, "an echoes.zarr", named=f"ECHOES = '{path}'")
            dataset = _opened(path)
            dataset = dataset.set_coords([n for n in ("time", "azimuth", "transmitter", "turn") if n in dataset])
            return _whole_turns(dataset, Path(path))
    except (InputError, SchemaError):
        raise
    except Exception as error:  # a damaged store raises exceptions of many types
        what = f"{type(error).__name__}: {error}"
        filter_asyncio_log()
    raise InputError(f"ECHOES = '{path}': is not an echo store, or damaged ({what}); give a whole echoes.zarr")


def _opened(path: str | Path) -> xr.Dataset:
    """A store whose arrays may be of unequal length: so many pulses as all have."""
    group = zarr.open_group(path, mode="r", zarr_format=3, use_consolidated=False)
    arrays = dict(group.arrays())
    lengths = {name: array.shape[0] for name, array in arrays.items() if names_of(array)[:1] == ("pulse",)}
    least = min(lengths.values(), default=0)
    if Path(path).is_dir():  # what xarray reads at once
        counted = group.attrs.get(PULSES, least)
        check_chunks(Path(path), {"pulse": min(int(str(counted)), least)}, _MAY_LACK, [*_INDEXES, "turn"])
    parts = []
    for length in sorted(set(lengths.values()) or {0}):
        others = [name for name in lengths if lengths[name] != length]
        part = xr.open_zarr(path, consolidated=False, zarr_format=3, drop_variables=others)
        parts.append(part.isel(pulse=slice(0, least)) if "pulse" in part.dims else part)
    whole, *others = parts
    for part in others:
        whole = whole.assign({name: part[name] for name in part.variables if name not in whole.variables})
    return whole


def read_turn(echoes: xr.Dataset) -> xr.Dataset:
    """Echoes with their voltages in memory. Raises SchemaError where the file that holds them is damaged."""
    weigh("echoes", echoes.nbytes)
    try:
        return echoes.load()
    except Exception as error:
        what = f"{type(error).__name__}: {error}"
        filter_asyncio_log()
    raise SchemaError(f"echoes: cannot be read ({what}); give whole files")


def _whole_turns(dataset: xr.Dataset, path: Path) -> xr.Dataset:
    check("echoes", dataset)
    check_attributes(dataset.attrs)
    if dataset.sizes["pulse"] > _MOST_PULSES:
        raise SchemaError(
            f"echoes: hold {dataset.sizes['pulse']:.3g} pulses: must be at most {_MOST_PULSES:.3g}; split the record"
        )
    counted = dataset.attrs.pop(PULSES, dataset.sizes["pulse"])  # while it grows: beyond, all looks like turn 0
    numbers = dataset["turn"].values[: int(counted)]
    whole = int(np.count_nonzero(numbers < float(dataset.attrs["complete_turns"])))
    if path.is_dir():
        check_chunks(path, {"pulse": whole}, _MAY_LACK)
    dataset = dataset.isel(pulse=slice(0, whole))
    once = [name for name in dataset.variables if name not in _BULK]
    weigh(f"ECHOES = '{path}'", sum(dataset[name].nbytes for name in once), bytes_held(path))
    for name in once:
        dataset[name].load()
    dataset.attrs.pop(EVERY_CHUNK, None)  # of the store: who writes these echoes elsewhere may leave some out
    return dataset
