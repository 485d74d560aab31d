"""An array of a Zarr store that grows by rows, its chunks written straight from memory.

A chunk that is not compressed and as wide as its array holds rows as they lie in memory: one write of the system makes
its file. zarr-python makes the same file through an event loop and a pipeline of codecs, with copies between them, and
takes several times as long.
"""

from __future__ import annotations

import json
import math
import os
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

DESCRIPTION = "zarr.json"
PARTIAL = ".partial"  # ends the names of files that are not whole, here as with zarr-python


class GrowingArray:
    """An array in its folder, as zarr-python has made it: of format 3, not compressed, its fill value 0, its chunks as
    wide as itself."""

    def __init__(self, folder: Path) -> None:
        self._folder = folder
        self._described: dict[str, Any] = json.loads((folder / DESCRIPTION).read_text(encoding="utf-8"))
        self._rows, *self._width = self._described["chunk_grid"]["configuration"]["chunk_shape"]
        self._type = np.dtype(self._described["data_type"]).newbyteorder("<")

    def lengthen(self, rows: int) -> None:
        """Say that it has so many rows. Before they are written: what shortens it removes the chunks that it has."""
        self._described["shape"][0] = rows
        write_file(self._folder / DESCRIPTION, json.dumps(self._described, indent=2).encode())

    def chunks(self, start: int, rows: NDArray[Any]) -> Iterator[tuple[Path, NDArray[Any]]]:
        """Each chunk into which rows reach: its file, and its whole content.

        start: number of the first row; the array has all before it. A chunk is a view of the rows if they fill it. Else
        it begins with what its file holds, and zeros follow. ValueError for rows of another width.
        """
        rows = np.ascontiguousarray(np.broadcast_to(rows, (len(rows), *self._width)), dtype=self._type)
        for number in range(start // self._rows, -(-(start + len(rows)) // self._rows)):
            first = number * self._rows
            file = self._folder.joinpath("c", str(number), *("0" for _ in self._width))
            content = rows[max(0, first - start) : first + self._rows - start]
            whole = len(content) == self._rows
            yield file, content if whole else self._completed(file, max(0, start - first), content)

    def _completed(self, file: Path, before: int, rows: NDArray[Any]) -> NDArray[Any]:
        """A chunk with rows in it. before: how many rows of its file come before them."""
        chunk = np.zeros((self._rows, *self._width), rows.dtype)
        if before:
            held = np.fromfile(file, rows.dtype, count=before * math.prod(self._width))
            chunk[:before] = held.reshape(before, *self._width)
        chunk[before : before + len(rows)] = rows
        return chunk


def write_file(file: Path, content: bytes | NDArray[Any]) -> None:
    """Write a file of a store, which appears whole or not at all."""
    partial = f"{file}{PARTIAL}"
    left = memoryview(content) if isinstance(content, bytes) else content.reshape(-1).view(np.uint8).data
    file.parent.mkdir(parents=True, exist_ok=True)
    try:
        with open(partial, "wb", buffering=0) as opened:
            while len(left):  # the system may take a part at a time
                left = left[opened.write(left) :]
        os.replace(partial, file)
    except BaseException:
        Path(partial).unlink(missing_ok=True)
        raise
