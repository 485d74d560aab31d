"""A file that grows is read by others as its last whole turn left it, whatever its writer is doing."""

from __future__ import annotations

import threading
import time
from pathlib import Path
from typing import Any

import numpy as np
import pytest
import xarray as xr

from seamap_rt.io.appendable import AppendableNetCDF
from seamap_rt.io.reading import read_whole_turns
from seamap_rt.io.results_folder import hidden_store

_SIDE = 40


def _turn(number: int) -> xr.DataTree:
    field = xr.DataArray(np.full((1, _SIDE, _SIDE), float(number)), dims=("turn", "y", "x"))
    return xr.DataTree.from_dict({"/polar": xr.Dataset({"height": field}, {"turn": [number]})})


def _heights(file: Any) -> np.ndarray:
    return np.asarray(file["polar/height"][:])


def test_each_whole_turn_is_there_at_once_and_nothing_before_the_first(tmp_path: Path) -> None:
    path = tmp_path / "maps.nc"
    with AppendableNetCDF(path) as file:
        with pytest.raises(OSError, match=r"maps\.nc"):
            read_whole_turns(path, _heights)
        for number in range(4):
            file.append(_turn(number))
            found = read_whole_turns(path, _heights)
            assert found.shape == (number + 1, _SIDE, _SIDE)
            np.testing.assert_array_equal(found[:, 0, 0], np.arange(number + 1.0))
    np.testing.assert_array_equal(read_whole_turns(path, _heights)[:, 5, 5], np.arange(4.0))


def _series(number: int, turns: int = 1) -> xr.Dataset:
    turn, sample = number + np.arange(turns), 4 * number + np.arange(4 * turns)
    variables = {
        "seen": (("turn", "look"), 1.0 * turn[:, None] + np.arange(3)),
        "true": (("gauge", "sample"), 0.5 * sample[None]),
        "height": (("gauge", "turn"), turn[None]),
        "east": (("gauge",), [7.0]),
    }
    return xr.Dataset(variables, {"turn": turn, "time": ("sample", 0.1 * sample), "gauge": ["west"]}, {"title": "it"})


@pytest.mark.parametrize("first", [1, 3])
def test_what_grows_reads_as_the_file_that_it_becomes(tmp_path: Path, first: int) -> None:
    """Names, attributes, and each array by a turn, by some, from the end, whole; whatever dimension grows."""
    path = tmp_path / "it.nc"

    def read(file: Any) -> list[tuple[str, list[Any]]]:
        told = [sorted(set(file) - {"sample", "look"}), file.attrs["title"], "seen" in file, "none" in file]
        found: list[tuple[str, list[Any]]] = [("", told)]
        for name in told[0]:
            array = file[name]
            keys = [slice(None), slice(2, None), slice(0, 0)] + ([0, 3, -1] if name in ("seen", "turn") else [])
            values = [np.asarray(array[key]) for key in keys]
            values = [each.astype(object).astype("S") if each.dtype.kind in "OT" else each for each in values]
            found.append((name, [array.shape, *(each.tolist() for each in values)]))
        return found

    with AppendableNetCDF(path, ("turn", "sample")) as file:
        file.append(_series(0, first))
        for number in range(first, 5):
            file.append(_series(number))
        growing = read_whole_turns(path, read)
    assert growing == read_whole_turns(path, read)


def test_a_reader_that_comes_as_a_file_is_finished_sees_all_of_it(tmp_path: Path) -> None:
    """It is finished, and its turns have gone, after the reader has opened what grew: Zarr would read what is missing
    as nothing."""
    path = tmp_path / "maps.nc"
    file = AppendableNetCDF(path)
    for number in range(5):
        file.append(_turn(number))

    def read(opened: Any) -> np.ndarray:
        if not path.exists():
            file.close()
        return _heights(opened)

    np.testing.assert_array_equal(read_whole_turns(path, read)[:, 0, 0], np.arange(5.0))


def test_a_reader_beside_a_writer_sees_whole_turns_alone(tmp_path: Path) -> None:
    path, ended = tmp_path / "maps.nc", threading.Event()
    with AppendableNetCDF(path) as file:
        file.append(_turn(0))
        seen: list[int] = []
        wrong: list[str] = []

        def read() -> None:
            while not ended.is_set():
                try:
                    found = read_whole_turns(path, _heights)
                except OSError as error:
                    wrong.append(str(error))
                    return
                seen.append(found.shape[0])
                if not np.array_equal(found[:, 3, 4], np.arange(float(found.shape[0]))):
                    wrong.append("a turn in part")

        reader = threading.Thread(target=read)
        reader.start()
        for number in range(1, 60):
            file.append(_turn(number))
    time.sleep(0.05)  # and beyond its end
    ended.set()
    reader.join()
    assert wrong == []
    assert seen == sorted(seen)
    assert seen[-1] > 1


@pytest.mark.parametrize("name", ["zarr.json", "file/polar/height/c/1/0/0"])
def test_damage_is_an_error_of_the_file(tmp_path: Path, name: str) -> None:
    path = tmp_path / "maps.nc"
    with AppendableNetCDF(path) as file:
        for number in range(2):
            file.append(_turn(number))
        damaged = hidden_store(path) / name
        held = damaged.read_bytes()
        for content in (b"", b"nonsense", held[: len(held) // 2]):
            damaged.write_bytes(content)
            with pytest.raises(OSError, match=r"maps\.nc"):
                read_whole_turns(path, _heights)
        damaged.write_bytes(held)
