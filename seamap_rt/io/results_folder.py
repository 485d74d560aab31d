"""A folder of results: made or refused, held against others, cleared of earlier results, and filled file by file."""

from __future__ import annotations

import os
import shutil
import socket
from datetime import UTC, datetime
from pathlib import Path
from typing import IO, Self

from ..errors import InputError

try:
    import fcntl
except ImportError:  # no locks of that kind on this system
    fcntl = None

_LOCK = ".seamap-rt.lock"


class FolderLock:
    """Held by the one process that writes into a folder: a context, which ends with the process at the latest.

    Where the file system knows no locks there is none. Raises InputError, saying who writes there.
    """

    def __init__(self, folder: Path) -> None:
        self._path = folder / _LOCK
        self._file: IO[str] | None = None
        while fcntl is not None and self._file is None:
            file = self._path.open("a+")
            try:
                fcntl.flock(file, fcntl.LOCK_EX | fcntl.LOCK_NB)
            except OSError as error:
                writer = _writer(file)
                file.close()
                if isinstance(error, BlockingIOError):
                    raise InputError(
                        f"--out = '{folder}': {writer} writes there; wait for it, or choose another folder"
                    ) from None
                self._path.unlink(missing_ok=True)
                return
            # Whoever released it meanwhile removed the file that was opened: then there is a new one to lock.
            if self._path.exists() and os.path.samestat(os.fstat(file.fileno()), self._path.stat()):
                self._file = file
                now = datetime.now(UTC).isoformat(" ", "seconds")
                file.truncate(0)
                file.write(f"process {os.getpid()} of {socket.gethostname()}, since {now},")
                file.flush()
            else:
                file.close()

    def release(self) -> None:
        if self._file is not None:
            self._path.unlink(missing_ok=True)  # while it is held: nobody else can hold this one any more
            self._file.close()
            self._file = None

    def __enter__(self) -> Self:
        return self

    def __exit__(self, *_: object) -> None:
        self.release()


def _writer(file: IO[str]) -> str:
    file.seek(0)
    return file.read(200).strip() or "another process"


def prepare_folder(folder: Path, overwrite: bool, products: tuple[str, ...]) -> FolderLock:
    """Make the folder, or say in one line why not: unwritable, a file, another process that writes there, or another
    run's results without overwrite. The lock is the context in which the folder is written into."""
    try:
        folder.mkdir(parents=True, exist_ok=True)
    except OSError as error:
        raise InputError(
            f"--out = '{folder}': cannot be made ({error.strerror or error}); choose a folder that you can write to"
        ) from None
    if not os.access(folder, os.W_OK | os.X_OK):
        raise InputError(f"--out = '{folder}': cannot be written to; choose a folder that you can write to")
    try:
        lock = FolderLock(folder)
    except OSError as error:
        raise InputError(
            f"--out = '{folder}': cannot be written to ({error.strerror or error}); choose another folder"
        ) from None
    earlier = [name for name in products if (folder / name).exists()]
    if earlier and not overwrite:
        lock.release()
        raise InputError(
            f"--out = '{folder}': holds another run's {earlier[0]}; choose another folder, or give --overwrite"
        )
    return lock


def clear_folder(folder: Path, products: tuple[str, ...]) -> None:
    """Remove an earlier run's products, figures too, so that an interrupted run never stands beside an older report.

    Call it only when nothing can be refused any more.
    """
    figures = [path.name for path in folder.glob("*.png")] if "report.html" in products else []
    for name in (*products, *figures):
        path = folder / name
        if path.is_dir():
            shutil.rmtree(path)
        else:
            path.unlink(missing_ok=True)


def write_whole(path: Path, content: str | bytes) -> None:
    """Write a file that appears whole or not at all."""
    part = path.with_name(f".{path.name}.part")
    try:
        part.write_bytes(content if isinstance(content, bytes) else content.encode("utf-8"))
        os.replace(part, path)
    finally:
        part.unlink(missing_ok=True)
