"""Files of results, read as far as their turns are whole: finished ones, growing ones, and what a kill has left."""

from __future__ import annotations

import threading
from collections.abc import Callable
from contextlib import closing
from pathlib import Path
from typing import Any, TypeVar

from .opening import check_store, open_hdf5
from .results_folder import DESCRIPTION, FILE, OF_RUN, RUN, hidden_store

Result = TypeVar("Result")
_TRIES = 3


def growing_store_of(path: Path) -> tuple[Path, str] | None:
    """The store, and its group, in which a file of results grows, or grew: None where there is none.

    path: the file's own name.
    """
    hidden, group = hidden_store(path), OF_RUN.get(path.name, "")
    if hidden.exists():
        return hidden, FILE
    return (path.with_name(RUN), group) if group and (path.with_name(RUN) / group).exists() else None


def results_exist(path: Path) -> bool:
    """Whether there is a file of results, or one grows."""
    return path.exists() or growing_store_of(path) is not None


class ResultsFile:
    """What is whole of a file of results, to be read by several threads, and closed. It stays open between readings.

    path: the file's own name.
    """

    def __init__(self, path: Path) -> None:
        self.path = path
        self._lock = threading.Lock()
        self._file: Any = None
        self._of: tuple[Path, int] | None = None  # the file, or the description of the store as it was written then

    def read(self, read: Callable[[Any], Result]) -> Result:
        """What `read` makes of a file that is finished, or of the whole turns of one that grows or was left by a kill.

        read: is given a group of HDF5 or of Zarr: either has arrays by their paths, of which `[number]` is a turn of
        one of turns, and attributes of groups as `["polar"].attrs`. It may be called several times: while it reads, a
        file that grew may be finished. Raises OSError where there is none, or a damaged one.
        """
        message = ""
        for _ in range(_TRIES):
            try:
                with self._lock:
                    file, of = self._open_current()
                found = read(file)
                if of.exists():  # else what has gone was read as what is missing
                    return found
                message = "was removed meanwhile"
            except Exception as error:  # a damaged file raises exceptions of many types
                message = str(error)
        raise OSError(f"{self.path}: {message}")

    def _open_current(self) -> tuple[Any, Path]:
        """What is to be read, and the file without which it is not there."""
        grows = None if self.path.exists() else growing_store_of(self.path)
        described = self.path if grows is None else grows[0] / DESCRIPTION
        of = described, 0 if grows is None else described.stat().st_mtime_ns
        if self._of != of:
            self._file, self._of = open_hdf5(self.path, rows=True) if grows is None else _open_group(*grows), of
        return self._file, described

    def close(self) -> None:
        if self._of is not None and self._of[0] == self.path:
            self._file.close()
        self._of = None


def _open_group(store: Path, name: str) -> Any:
    import zarr

    check_store(store, "a run's store", group=name)
    return zarr.open_group(store, mode="r", zarr_format=3, use_consolidated=True)[name]


def read_whole_turns(path: Path, read: Callable[[Any], Result]) -> Result:
    """What `read` makes of a file of results, as `ResultsFile.read`."""
    with closing(ResultsFile(path)) as file:
        return file.read(read)
