"""Temporary folders, which go with their process: those of a killed process go when the next one makes its own."""

from __future__ import annotations

import contextlib
import os
import re
import shutil
import tempfile
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path

from .locks import Held, alive, locked

PREFIX = "seamap-rt-"
_LOCK = ".lock"


@contextmanager
def scratch_folder(prefix: str = PREFIX, within: Path | None = None) -> Iterator[Path]:
    """An empty folder for this process alone, gone afterwards. Those of killed processes are removed first.

    prefix: of its name; the process's number follows. within: the folder to make it in; default the system's own for
    temporary files. Raises OSError where it cannot be made.
    """
    home = within or Path(tempfile.gettempdir())
    clear_dead(prefix, home)
    path = Path(tempfile.mkdtemp(prefix=f"{prefix}{os.getpid()}-", dir=home))
    try:
        with locked(path / _LOCK):
            yield path
            shutil.rmtree(path, ignore_errors=True)
    finally:
        shutil.rmtree(path, ignore_errors=True)


def clear_dead(prefix: str = PREFIX, within: Path | None = None) -> None:
    """Remove this user's folders whose processes have been killed. prefix, within: as of `scratch_folder`."""
    home = within or Path(tempfile.gettempdir())
    named = re.compile(rf"{re.escape(prefix)}(\d+)-\w+")
    for path in home.glob(f"{prefix}*"):
        name = named.fullmatch(path.name)
        with contextlib.suppress(OSError, Held):
            if name is None or path.is_symlink() or not path.is_dir() or path.stat().st_uid != os.getuid():
                continue
            if (path / _LOCK).exists():
                with locked(path / _LOCK):
                    shutil.rmtree(path, ignore_errors=True)
            elif not alive(int(name[1])):  # killed before it could take the lock, or while it removed the folder
                shutil.rmtree(path, ignore_errors=True)
