"""Whatever opens a file refuses one that waits, never ends, swells or leads elsewhere: in one line, soon, and before it
is read."""

from __future__ import annotations

import json
import subprocess
import sys
from pathlib import Path

import h5py
import hostile_files
import numpy as np
import pytest
from hostile_files import CASES, LONGEST_S, MOST_GROWTH

from seamap_rt.io.opening import open_dataset, open_tree

Told = tuple[str, str, float, float]


@pytest.fixture(scope="module")
def told(tmp_path_factory: pytest.TempPathFactory) -> dict[tuple[str, str], Told]:
    """What came of each case, all of them read by a process of their own."""
    folder = tmp_path_factory.mktemp("hostile")
    results = folder / "results"
    program = [sys.executable, hostile_files.__file__, str(folder / "files"), str(results)]
    subprocess.run(program, check=False)  # each case has its own alarm
    found: list[list] = [json.loads(line) for line in results.read_text().splitlines()]
    return {(reader, kind): tuple(rest) for reader, kind, *rest in found}  # type: ignore[misc]


@pytest.mark.parametrize("case", CASES, ids=" · ".join)
def test_it_is_refused_in_a_line_soon_and_unread(case: tuple[str, str], told: dict[tuple[str, str], Told]) -> None:
    """Two seconds of processor are a refusal's; 300 MB are less than any of the files would take."""
    raised, message, seconds, growth = told[case]
    assert raised == "InputError", message
    assert message.isprintable()
    if case[1].startswith("others'"):
        assert "save one file that holds all of it" in message
    assert seconds < LONGEST_S
    assert growth < MOST_GROWTH


def test_arrays_of_arrays_are_left_out(tmp_path: Path) -> None:
    """xarray refuses the whole file for one of them where cftime is installed, as it is beside netCDF4."""
    path = tmp_path / "images.nc"
    with h5py.File(path, "w") as file:
        for group in (file, file.create_group("camera")):
            group["heights"] = np.arange(3.0)
            images = group.create_dataset("images", (3,), dtype=h5py.vlen_dtype(np.uint8))
            images[:] = [np.zeros(size, np.uint8) for size in (1, 2, 3)]
            group.create_dataset("names", data=["a", "b", "c"], dtype=h5py.string_dtype())
    with open_dataset(path, phony_dims="sort") as found, open_tree(path, phony_dims="sort") as tree:
        for each in (found, tree["camera"]):
            assert set(each.data_vars) == {"heights", "names"}
            np.testing.assert_array_equal(each["heights"], np.arange(3.0))
