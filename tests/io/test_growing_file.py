"""A file that grows is read by others as its last whole turn left it, whatever its writer is doing."""

from __future__ import annotations

import threading
from pathlib import Path

import h5py
import numpy as np
import pytest
import xarray as xr

from seamap_rt.io.appendable import AppendableNetCDF
from seamap_rt.io.committed_file import journal_of, part_of
from seamap_rt.io.growing_file import read_whole_turns

_SIDE = 40


def _turn(number: int) -> xr.DataTree:
    field = xr.DataArray(np.full((1, _SIDE, _SIDE), float(number)), dims=("turn", "y", "x"))
    return xr.DataTree.from_dict({"/polar": xr.Dataset({"height": field}, {"turn": [number]})})


def _heights(file: h5py.File) -> np.ndarray:
    return np.asarray(file["polar/height"])  # type: ignore[arg-type]


def test_each_whole_turn_is_there_at_once_and_nothing_before_the_first(tmp_path: Path) -> None:
    path = tmp_path / "maps.nc"
    with AppendableNetCDF(path) as file:
        with pytest.raises(OSError, match="no whole turn"):
            read_whole_turns(path, _heights)
        for number in range(4):
            file.append(_turn(number))
            found = read_whole_turns(path, _heights)
            assert found.shape == (number + 1, _SIDE, _SIDE)
            np.testing.assert_array_equal(found[:, 0, 0], np.arange(number + 1.0))
    np.testing.assert_array_equal(read_whole_turns(path, _heights)[:, 5, 5], np.arange(4.0))


def test_pages_of_a_commit_that_are_not_in_the_file_yet_are_read_from_its_journal(tmp_path: Path) -> None:
    """A kill between the journal and the file leaves the file old: overlaid it is whole, and it is not touched."""
    path = tmp_path / "maps.nc"
    with AppendableNetCDF(path) as file:
        for number in range(2):
            file.append(_turn(number))
        old = part_of(path).read_bytes()
        file.append(_turn(2))
        new, journal = part_of(path).read_bytes(), journal_of(part_of(path)).read_bytes()
    torn = old + new[len(old) :]  # the tables are those of two turns, the third one's values are there
    assert torn != new
    part_of(path).write_bytes(torn)
    journal_of(part_of(path)).write_bytes(journal)
    path.unlink()
    assert read_whole_turns(path, _heights).shape[0] == 3
    assert part_of(path).read_bytes() == torn


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
        ended.set()
        reader.join()
    assert wrong == []
    assert seen == sorted(seen)
    assert seen[-1] > 1


def test_what_is_no_journal_is_no_file(tmp_path: Path) -> None:
    path = tmp_path / "maps.nc"
    part_of(path).write_bytes(b"x" * 100)
    journal_of(part_of(path)).write_bytes(b"nonsense")
    with pytest.raises(OSError, match=r"maps\.nc"):
        read_whole_turns(path, _heights)
