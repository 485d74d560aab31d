"""A file into which HDF5 writes, and which a kill at any instant leaves as it was at the last commit.

HDF5 changes its tables in place, so a file that is cut off between two of its writes cannot be opened any more. Here
what it writes beyond the end of the last commit goes into the file at once, and what it changes before that end stays
in memory. `commit` puts these pages into a journal beside the file, which takes its name whole, and then into the file.
After a kill `mend` writes the pages of the journal once more and cuts off what is beyond the commit's end.

This holds for processes that end, not for machines that lose their power: nothing waits for the disk.
"""

from __future__ import annotations

import contextlib
import json
import os
import struct
from collections.abc import Mapping
from pathlib import Path
from typing import Any

from .opening import LONG, read_bytes

_PAGE = 4096
_HEAD = struct.Struct("<8sQQQ")  # mark, size of the file, number of pages, bytes of the note
_MARK = b"SEAMAP-1"


def part_of(path: Path) -> Path:
    """What a file is called until it is whole."""
    return path.with_name(f".{path.name}.part")


def journal_of(path: Path) -> Path:
    """The journal of a file."""
    return path.with_name(f"{path.name}.journal")


class CommittedFile:
    """The file object that h5py is given (its driver `fileobj`), and the file behind it.

    path: made new, or, with `existing`, one that was mended. Whatever goes wrong with the disk is raised by `commit`
    and `reserve` alone: HDF5 itself may crash, as late as at the end of the process, if a write fails.
    """

    def __init__(self, path: Path, *, existing: bool = False) -> None:
        self.path = path
        self._handle = os.open(path, os.O_RDWR | os.O_CREAT | (0 if existing else os.O_TRUNC), 0o666)
        if not existing:
            journal_of(path).unlink(missing_ok=True)
        self._end = self._committed = os.fstat(self._handle).st_size
        self._place = 0
        self._pages: dict[int, bytearray] = {}  # changed and not committed, by number
        self._failed: OSError | None = None

    # --------------------------------------------------------------------------------------- what HDF5 asks for

    def seek(self, offset: int, whence: int = os.SEEK_SET) -> int:
        start = {os.SEEK_SET: 0, os.SEEK_CUR: self._place, os.SEEK_END: self._end}[whence]
        self._place = start + offset
        return self._place

    def tell(self) -> int:
        return self._place

    def readinto(self, buffer: Any) -> int:
        """Fill the buffer from the place on; beyond the end with zeros."""
        view, start = memoryview(buffer).cast("B"), self._place
        found = os.pread(self._handle, len(view), start)
        view[: len(found)] = found
        view[len(found) :] = bytes(len(view) - len(found))
        for number in self._numbers(start, len(view)) if self._pages else ():
            page = self._pages.get(number)
            if page is not None:
                low, high = max(start, number * _PAGE), min(start + len(view), (number + 1) * _PAGE)
                view[low - start : high - start] = page[low - number * _PAGE : high - number * _PAGE]
        self._place += len(view)
        return len(view)

    def read(self, size: int = -1) -> bytes:
        buffer = bytearray(size if size >= 0 else max(0, self._end - self._place))
        self.readinto(buffer)
        return bytes(buffer)

    def write(self, data: Any) -> int:
        """Keep what lies before the committed end in memory, write what lies beyond."""
        view, start = memoryview(data).cast("B"), self._place
        beyond = max(0, min(len(view), self._limit - start))  # where in `view` the committed pages end
        if beyond < len(view):
            try:
                _write_at(self._handle, view[beyond:], start + beyond)
            except OSError as error:
                self._failed, beyond = error, len(view)
        self._keep(view[:beyond], start)
        self._place += len(view)
        self._end = max(self._end, self._place)
        return len(view)

    def truncate(self, size: int | None = None) -> int:
        self._end = self._place if size is None else size
        return self._end

    def flush(self) -> None:
        """Nothing: what HDF5 has flushed is whole only with `commit`."""

    # ------------------------------------------------------------------------------------------------- ours

    def reserve(self, room: int) -> None:
        """Have the file system set so many bytes aside beyond the end, where it can. OSError if it has not got them."""
        if hasattr(os, "posix_fallocate"):
            try:
                os.posix_fallocate(self._handle, self._end, room)
            except BaseException:
                os.ftruncate(self._handle, self._end)  # some file systems keep the part of the room that they had
                raise

    def commit(self, note: Mapping[str, Any], *, journal: bool = True) -> None:
        """What was written is whole: from now on a kill leaves this. `note` is kept with it, see `mend`.

        journal: False changes the file without, for a disk that has no room for one.
        Raises OSError, and the file stays as it was committed last, where the disk is full.
        """
        if self._failed is not None:
            failed, self._failed = self._failed, None
            raise failed
        if journal:
            self._write_journal(json.dumps(dict(note)).encode())
        for number, page in self._pages.items():
            _write_at(self._handle, memoryview(page), number * _PAGE)
        os.ftruncate(self._handle, self._end)
        self._pages.clear()
        self._committed = self._end

    def discard(self) -> None:
        """Forget all since the last commit."""
        self._pages.clear()
        self._end = self._committed
        os.ftruncate(self._handle, self._end)

    def close(self) -> None:
        """Close the file; what was not committed is not in it."""
        if self._handle >= 0:
            os.close(self._handle)
            self._handle = -1

    @property
    def _limit(self) -> int:
        """The end of the committed pages."""
        return -(-self._committed // _PAGE) * _PAGE

    def _numbers(self, start: int, size: int) -> range:
        return range(start // _PAGE, -(-(start + size) // _PAGE))

    def _keep(self, view: memoryview, start: int) -> None:
        for number in self._numbers(start, len(view)) if len(view) else ():
            first = number * _PAGE
            page = self._pages.get(number)
            if page is None:
                page = self._pages[number] = bytearray(os.pread(self._handle, _PAGE, first).ljust(_PAGE, b"\0"))
            low, high = max(start, first), min(start + len(view), first + _PAGE)
            page[low - first : high - first] = view[low - start : high - start]

    def _write_journal(self, note: bytes) -> None:
        journal = journal_of(self.path)
        part = journal.with_name(f"{journal.name}.part")
        numbers = struct.pack(f"<{len(self._pages)}Q", *self._pages)
        head = _HEAD.pack(_MARK, self._end, len(self._pages), len(note))
        try:
            part.write_bytes(b"".join((head, note, numbers, *self._pages.values())))
            os.replace(part, journal)
        except OSError:
            with contextlib.suppress(OSError):
                part.unlink()
            raise


def mend(path: Path) -> dict[str, Any] | None:
    """Bring a file that a kill has left back to its last commit, and return that one's note; None if it had none.

    May itself be killed and called again. Raises OSError, ValueError for a journal that is not one.
    """
    try:
        content = read_bytes(journal_of(path), most=LONG) if journal_of(path).exists() else None
        if content is None:
            return None
        note, size, pages = _read_journal(content)
    except ValueError:
        raise ValueError(f"{journal_of(path)} is not a journal") from None
    handle = os.open(path, os.O_RDWR)
    try:
        for number, page in pages.items():
            _write_at(handle, page, number * _PAGE)
        os.ftruncate(handle, size)
    finally:
        os.close(handle)
    return note


def pages_of_journal(content: bytes) -> tuple[int, dict[int, memoryview], int]:
    """Of a journal: the size of its file, the pages by number that are to be laid over it, and the bytes of a page.

    ValueError for what is not a journal.
    """
    _, size, pages = _read_journal(content)
    return size, pages, _PAGE


def _read_journal(content: bytes) -> tuple[dict[str, Any], int, dict[int, memoryview]]:
    try:
        mark, size, count, length = _HEAD.unpack_from(content)
    except struct.error:
        raise ValueError("not a journal") from None
    start = _HEAD.size + length
    data = start + 8 * count
    if mark != _MARK or len(content) != data + _PAGE * count:
        raise ValueError("not a journal")
    numbers = struct.unpack_from(f"<{count}Q", content, start)
    view = memoryview(content)
    pages = {number: view[data + place * _PAGE : data + (place + 1) * _PAGE] for place, number in enumerate(numbers)}
    return json.loads(content[_HEAD.size : start]), size, pages


def _write_at(handle: int, view: memoryview, offset: int) -> None:
    """Write all of it: the system may take a part at a time."""
    while len(view):
        written = os.pwrite(handle, view, offset)
        view, offset = view[written:], offset + written
