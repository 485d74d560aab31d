"""NetCDF files that grow by turns and appear under their own name, whole, even where the disk fills."""

from __future__ import annotations

import errno
import os
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path
from types import TracebackType
from typing import Self

import h5netcdf
import h5py

_INDEX_BYTES = 16384  # more than HDF5 adds for a variable in a turn: its header at first, then the trees of its chunks


@contextmanager
def all_or_none(*files: GrowingFile) -> Iterator[None]:
    """A turn that one of the files could not take is taken back from the others."""
    before = [file.length for file in files]
    try:
        yield
    except BaseException:
        for file, length in zip(files, before, strict=True):
            file.length = length
        raise


class GrowingFile:
    """A NetCDF file that is written beside its own name, and takes that name when it is closed.

    Leaving the context by an exception closes it too: whole turns stay readable. Nothing appears if there are none.
    `length` counts what is complete of each dimension that grows; what is beyond it goes when the file is closed.
    """

    def __init__(self, path: Path, growing: tuple[str, ...] = ("turn",)) -> None:
        self.path = path
        self.length = dict.fromkeys(growing, 0)
        self._part = path.with_name(f".{path.name}.part")
        self._part.unlink(missing_ok=True)
        self._hdf5: h5py.File | None = None
        self._file: h5netcdf.File | None = None

    @property
    def complete(self) -> int:
        """How many turns are whole: the length of the first dimension that grows."""
        return next(iter(self.length.values()))

    def _opened(self, room: int, variables: int) -> h5netcdf.File:
        """The file, with the disk's word that so many bytes in so many variables can follow. OSError if not.

        HDF5 itself may crash, as late as at the end of the process, if it finds the disk full while it writes. Where
        the system (macOS) or the file system gives no such word, the file is written without it.
        """
        if self._hdf5 is None or self._file is None:
            self._hdf5 = h5py.File(self._part, "w", track_order=True)
            self._file = h5netcdf.File(self._hdf5, "w")
        handle, size = os.open(self._part, os.O_RDWR), self._hdf5.id.get_filesize()
        try:
            if hasattr(os, "posix_fallocate"):
                os.posix_fallocate(handle, size, room + _INDEX_BYTES * (16 + variables))
        except OSError as error:
            if error.errno in (errno.EINVAL, errno.EOPNOTSUPP):
                return self._file
            os.ftruncate(handle, size)  # some file systems keep the part of the room that they had
            raise OSError(error.errno, os.strerror(error.errno or 0), str(self.path)) from None
        finally:
            os.close(handle)
        return self._file

    def _count(self, length: dict[str, int]) -> None:
        """What was written is complete, and room that it did not need is given back."""
        assert self._hdf5 is not None
        assert self._file is not None
        self._file.flush()  # it ties dimensions to variables only now, which takes room too
        self._hdf5.flush()
        os.truncate(self._part, self._hdf5.id.get_filesize())
        self.length = length

    def _cut(self, file: h5netcdf.File) -> None:
        """Bring all that grows to `length`."""
        raise NotImplementedError

    def close(self) -> None:
        """Finish the file; a turn that failed halfway goes."""
        if self._hdf5 is not None and self._file is not None:
            if self.complete:
                self._cut(self._file)
            self._file.close()
            self._hdf5.close()
            self._file = self._hdf5 = None
            if self.complete:
                os.replace(self._part, self.path)
        self._part.unlink(missing_ok=True)

    def __enter__(self) -> Self:
        return self

    def __exit__(
        self, kind: type[BaseException] | None, error: BaseException | None, trace: TracebackType | None
    ) -> None:
        self.close()
