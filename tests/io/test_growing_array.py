"""The echo store's arrays have the files that zarr-python itself writes, and stay as they were where one fails."""

from __future__ import annotations

import errno
import io
import itertools
import os
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import Any

import numpy as np
import pytest
import xarray as xr
import zarr

from seamap_rt.io import echo_store, growing_array
from seamap_rt.io.echo_store import EchoStore

PULSES_A_CHUNK, READINGS_A_CHUNK = 4, 10


@pytest.fixture(autouse=True)
def small_chunks(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(echo_store, "_PULSES_A_CHUNK", PULSES_A_CHUNK)
    monkeypatch.setattr(echo_store, "_READINGS_A_CHUNK", READINGS_A_CHUNK)


def turn(number: int, pulses: int) -> xr.Dataset:
    """Random echoes with the kinds of numbers, and of dimensions, that the schema has."""
    drawn = np.random.default_rng(number)
    parts = drawn.normal(size=(2, pulses, 2, 3))
    variables = {
        "voltage": (("pulse", "receiver", "range"), (parts[0] + 1j * parts[1]).astype(np.complex64)),
        "attitude": (("pulse", "rpy"), drawn.normal(size=(3, pulses)).T, {"units": "degree"}),  # not as it lies on disk
        "transmitter": ("pulse", drawn.integers(0, 2, pulses, dtype=np.int8)),
        "time": ("pulse", drawn.normal(size=pulses)),
        "turn": ("pulse", np.full(pulses, number, np.int32)),
    }
    return xr.Dataset(variables, {"range": [1.0, 2.0, 3.0]}, {"complete_turns": number + 1})


def files(folder: Path) -> dict[str, bytes]:
    """All files below a folder, by their paths from there."""
    return {path.relative_to(folder).as_posix(): path.read_bytes() for path in folder.rglob("*") if path.is_file()}


def by_zarr(path: Path, turns: list[xr.Dataset]) -> None:
    """The same arrays, grown by zarr-python."""
    group = zarr.open_group(path, mode="w", zarr_format=3)
    for name, variable in turns[0].variables.items():
        grows = variable.dims[0] == "pulse"
        rows = PULSES_A_CHUNK if name == "voltage" else READINGS_A_CHUNK
        array = group.create_array(
            str(name),
            shape=(0, *variable.shape[1:]) if grows else variable.shape,
            dtype=variable.dtype,
            chunks=(rows, *variable.shape[1:]) if grows else variable.shape,
            config={"write_empty_chunks": True},
            compressors=None,
            dimension_names=[str(dim) for dim in variable.dims],
            attributes=dict(variable.attrs),
        )
        if not grows:
            array[...] = variable.values
        for each in turns if grows else ():
            array.append(each.variables[name].values)


@pytest.mark.parametrize("pulses", [(4, 4, 8), (3, 3, 3, 3, 3), (1, 9, 2, 20), (20, 1)])
def test_its_files_are_those_of_zarr_itself(tmp_path: Path, pulses: tuple[int, ...]) -> None:
    """Turns that fill chunks, that share them, and that do both; the store's own description is ours."""
    turns = [turn(number, count) for number, count in enumerate(pulses)]
    with EchoStore(tmp_path / "ours") as store:
        for each in turns:
            store.append(each)
    by_zarr(tmp_path / "zarr", turns)
    ours, asked = files(tmp_path / "ours"), files(tmp_path / "zarr")
    del ours["zarr.json"], asked["zarr.json"]
    assert ours == asked


def test_a_later_turn_has_the_numbers_of_the_first(tmp_path: Path) -> None:
    """As zarr-python does it: of another kind they are converted; of another width they are refused."""
    with EchoStore(tmp_path / "it") as store:
        store.append(turn(0, 4))
        wide = turn(1, 4)
        store.append(wide.assign(turn=wide["turn"].astype(np.int64), voltage=wide["voltage"].astype(np.complex128)))
        with pytest.raises(ValueError, match="broadcast"):
            store.append(turn(2, 4).isel(range=slice(2)))
    with xr.open_zarr(tmp_path / "it") as found:
        xr.testing.assert_equal(
            found.load().reset_coords(), xr.concat([turn(0, 4), wide], "pulse", data_vars="minimal")
        )


class Full(io.FileIO):
    """A file for half of which there is room."""

    def write(self, data: Any, /) -> int:
        super().write(data[: len(data) // 2])
        raise OSError(errno.ENOSPC, os.strerror(errno.ENOSPC))


def test_a_turn_that_the_disk_cannot_take_is_not_there(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """Whichever of its files fails; and the next one follows on what was there."""

    @contextmanager
    def full_after(last: int) -> Iterator[None]:
        count = itertools.count()

        def limited(file: str, *_: object, **__: object) -> io.FileIO:
            return (io.FileIO if next(count) < last else Full)(file, "w")

        with monkeypatch.context() as patch:
            patch.setattr(growing_array, "open", limited, raising=False)
            yield

    turns = [turn(0, 5), turn(1, 11), turn(2, 3)]
    with EchoStore(tmp_path / "asked") as store:
        store.append(turns[0])
        store.append(turns[2].assign_attrs(complete_turns=2))
    asked, failed = files(tmp_path / "asked"), 0
    for last in itertools.count():
        with EchoStore(tmp_path / str(last)) as store:
            store.append(turns[0])
            try:
                with full_after(last):
                    store.append(turns[1])
                break
            except OSError:
                failed += 1
            with xr.open_zarr(tmp_path / str(last)) as found:
                assert found.sizes["pulse"] == 5
            store.append(turns[2].assign_attrs(complete_turns=2))
        with xr.open_zarr(tmp_path / str(last)) as found, xr.open_zarr(tmp_path / "asked") as whole:
            xr.testing.assert_identical(found.load(), whole.load())
        assert files(tmp_path / str(last)).keys() == asked.keys()
    assert failed == 5 + 3 + 4 * 2  # descriptions, chunks of the voltage, and of the others
