"""Whole turns of a NetCDF file while another process writes it, or after that was killed: read without touching it.

A `CommittedFile` is at any instant its own bytes with the pages of its journal laid over them. A journal appears whole;
where it is another one after reading than before, what was read may be of two commits, and is read again.
"""

from __future__ import annotations

import io
import os
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import TypeVar

import h5py

from ..errors import InputError
from .committed_file import journal_of, pages_of_journal, part_of
from .opening import LONG, check_hdf5, open_file, open_hdf5

Result = TypeVar("Result")
_TRIES = 20


class _Overlaid(io.RawIOBase):
    """A file with the pages of a journal laid over it, cut off at the journal's size. Read only."""

    def __init__(self, path: Path, content: bytes) -> None:
        self._size, self._pages, self._page = pages_of_journal(content)
        self._file = open_file(path)
        self._handle = self._file.fileno()
        self._place = 0

    def readable(self) -> bool:
        return True

    def seekable(self) -> bool:
        return True

    def seek(self, offset: int, whence: int = os.SEEK_SET) -> int:
        start = {os.SEEK_SET: 0, os.SEEK_CUR: self._place, os.SEEK_END: self._size}[whence]
        self._place = start + offset
        return self._place

    def tell(self) -> int:
        return self._place

    def readinto(self, buffer) -> int:
        view, start = memoryview(buffer).cast("B"), self._place
        wanted = max(0, min(len(view), self._size - start))
        found = os.pread(self._handle, wanted, start)
        view[: len(found)] = found
        view[len(found) : wanted] = bytes(wanted - len(found))
        for number in range(start // self._page, -(-(start + wanted) // self._page)) if wanted else ():
            page = self._pages.get(number)
            if page is not None:
                low, high = max(start, number * self._page), min(start + wanted, (number + 1) * self._page)
                view[low - start : high - start] = page[low - number * self._page : high - number * self._page]
        self._place += wanted
        return wanted

    def close(self) -> None:
        if not self.closed:
            self._file.close()
        super().close()


def read_whole_turns(path: Path, read: Callable[[h5py.File], Result]) -> Result:
    """What `read` makes of a file that is finished, or of the whole turns of one that grows or was left by a kill.

    path: the file's own name. read: is given the open file, and may be called several times.
    Raises OSError where there is neither.
    """
    for _ in range(_TRIES):
        try:
            if path.exists():
                with open_hdf5(path, rows=True) as file:
                    return read(file)
            with _growing(path) as (file, unchanged):
                found = read(file)
                if unchanged():
                    return found
        except (OSError, KeyError, RuntimeError, ValueError) as error:
            if isinstance(error, InputError):
                raise OSError(str(error)) from None
            if not path.exists() and not journal_of(part_of(path)).exists():
                raise OSError(f"{path}: holds no whole turn yet") from None
    raise OSError(f"{path}: changes faster than it can be read; try again")


@contextmanager
def _growing(path: Path) -> Iterator[tuple[h5py.File, Callable[[], bool]]]:
    journal = journal_of(part_of(path))
    if not journal.exists():
        raise FileNotFoundError(journal)
    with open_file(journal, most=LONG) as opened:
        before = os.fstat(opened.fileno())
        content = opened.read()
    overlaid = _Overlaid(part_of(path), content)
    try:
        with h5py.File(overlaid, "r") as file:
            check_hdf5(file, str(path), rows=True)

            def unchanged() -> bool:
                try:
                    now = os.stat(journal)
                except OSError:
                    return False
                return (now.st_ino, now.st_mtime_ns) == (before.st_ino, before.st_mtime_ns)

            yield file, unchanged
    finally:
        overlaid.close()
