"""A lock on a file that ends with the process that holds it, however that process ends.

It is the system's own `flock`. Where a file system has none (some network ones), what the file says decides: a process
that is alive on this host holds it, unless it began at another time than the file says and so only has got the number
of one that ended; and any process of another host does, since nothing tells whether that one lives.

Temporary folders go with their process: those of a killed process go when the next one makes its own.
"""

from __future__ import annotations

import contextlib
import errno
import fcntl
import json
import os
import re
import shutil
import socket
import tempfile
from collections.abc import Iterator
from contextlib import contextmanager
from dataclasses import asdict, dataclass
from datetime import datetime
from pathlib import Path

_NOT_HERE = (errno.ENOLCK, errno.ENOSYS, errno.EOPNOTSUPP, errno.EINVAL)  # a file system without locks
_MOST = 4096  # bytes of the holder's words


@dataclass(frozen=True)
class Holder:
    """The process that holds a lock. since: date and time of its host. began: as of `began`."""

    pid: int
    host: str
    since: str
    began: str = ""

    @classmethod
    def this_process(cls) -> Holder:
        now = datetime.now().astimezone().isoformat(" ", "seconds")
        return cls(os.getpid(), socket.gethostname(), now, began(os.getpid()))

    def __str__(self) -> str:
        return f"process {self.pid} on {self.host}, since {self.since}"

    @property
    def may_live(self) -> bool:
        """False where it is known to have ended."""
        return self.host != socket.gethostname() or (alive(self.pid) and self.began in ("", began(self.pid)))

    @property
    def is_this_process(self) -> bool:
        return self.pid == os.getpid() and self.host == socket.gethostname() and self.may_live


class LockHeldError(Exception):
    """Another process holds the lock; the message says which, since when."""


def alive(pid: int) -> bool:
    """Whether there is a process of this number on this machine."""
    try:
        os.kill(pid, 0)
    except ProcessLookupError:
        return False
    except OSError:  # someone else's
        return True
    return True


def began(pid: int) -> str:
    """When a process began, in the system's ticks since its own start; empty where it does not tell."""
    try:
        return Path(f"/proc/{pid}/stat").read_bytes().rpartition(b")")[2].split()[19].decode()
    except (OSError, IndexError):
        return ""


@contextmanager
def locked(path: Path) -> Iterator[None]:
    """Hold a lock on a file, which is made for it and removed at the end.

    A killed process leaves the file, but not the lock. Raises LockHeldError, OSError where the file cannot be made.
    """
    handle = _take(path)
    try:
        yield
    finally:
        with contextlib.suppress(OSError):  # a folder that someone has removed meanwhile
            path.unlink()
        os.close(handle)


def _take(path: Path) -> int:
    while True:
        handle = os.open(path, os.O_RDWR | os.O_CREAT | os.O_NOFOLLOW, 0o644)
        try:
            _lock(handle, path)
            with contextlib.suppress(FileNotFoundError):
                if os.path.samestat(os.stat(path), os.fstat(handle)):
                    words = json.dumps(asdict(Holder.this_process())).encode()
                    os.ftruncate(handle, 0)
                    os.pwrite(handle, words, 0)
                    return handle
        except BaseException:
            os.close(handle)
            raise
        os.close(handle)  # the holder before has just removed it: what was locked has no name any more


def _lock(handle: int, path: Path) -> None:
    try:
        fcntl.flock(handle, fcntl.LOCK_EX | fcntl.LOCK_NB)
    except BlockingIOError:
        raise LockHeldError(str(holder_of(path) or "another process")) from None
    except OSError as error:
        if error.errno not in _NOT_HERE:
            raise
        holder = holder_of(path)
        if holder is not None and holder.may_live:
            raise LockHeldError(str(holder)) from None


def holder_of(path: Path) -> Holder | None:
    """What a lock's file says of the process that holds it, or has been killed while it did; None without a word."""
    try:
        handle = os.open(path, os.O_RDONLY | os.O_NONBLOCK | os.O_CLOEXEC)
        with open(handle, "rb") as file:
            holder = Holder(**json.loads(file.read(_MOST)))
        return holder if 0 < holder.pid < 2**31 else None
    except (OSError, ValueError, TypeError):
        return None


PREFIX = "seamap-rt-"
_LOCK = ".lock"


@contextmanager
def scratch_folder(prefix: str = PREFIX, within: Path | None = None) -> Iterator[Path]:
    """An empty folder for this process alone, gone afterwards. Those of killed processes are removed first.

    prefix: of its name; the process's number follows. within: the folder to make it in; default the system's own for
    temporary files. Raises OSError where it cannot be made.
    """
    home = within or Path(tempfile.gettempdir())
    remove_abandoned(prefix, home)
    path = Path(tempfile.mkdtemp(prefix=f"{prefix}{os.getpid()}-", dir=home))
    try:
        with locked(path / _LOCK):
            yield path
            shutil.rmtree(path, ignore_errors=True)
    finally:
        shutil.rmtree(path, ignore_errors=True)


def remove_abandoned(prefix: str = PREFIX, within: Path | None = None) -> None:
    """Remove this user's folders whose processes have been killed. prefix, within: as of `scratch_folder`."""
    home = within or Path(tempfile.gettempdir())
    named = re.compile(rf"{re.escape(prefix)}(\d+)-\w+")
    for path in home.glob(f"{prefix}*"):
        name = named.fullmatch(path.name)
        with contextlib.suppress(OSError, LockHeldError):
            if name is None or path.is_symlink() or not path.is_dir() or path.stat().st_uid != os.getuid():
                continue
            if (path / _LOCK).exists():
                with locked(path / _LOCK):
                    shutil.rmtree(path, ignore_errors=True)
            elif not alive(int(name[1])):  # killed before it could take the lock, or while it removed the folder
                shutil.rmtree(path, ignore_errors=True)
