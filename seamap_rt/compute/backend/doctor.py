"""What a run would use here, and what mends what is missing."""

from __future__ import annotations

import ctypes
import platform
import sys
from typing import NamedTuple

from ..machine import cores
from . import choose, memory
from .kinds import PACKAGES, REMEDY_ATOMIC, package_version


class Check(NamedTuple):
    """A line of `doctor`: what was looked at, what was found (or what mends it), and whether it will do; None where
    that is no question."""

    item: str
    value: str
    ok: bool | None


def checks() -> list[Check]:
    """What a run would use here, and what mends what is missing. Never raises."""
    rows = [*_check_backend(), _check_libatomic(), Check("python", platform.python_version(), True)]
    rows += [_check_package(name) for name in PACKAGES]
    return [*rows, _check_cache(), Check("cores", str(len(cores())), None)]


def doctor_lines() -> list[str]:
    """`checks` as plain lines of text."""
    rows = checks()
    width = max(len(each.item) for each in rows)
    words = {True: "ok", False: "MISSING", None: "info"}
    return [f"{words[check.ok]:<7}  {check.item:<{width}}  {check.value}" for check in rows]


def _check_backend() -> list[Check]:
    try:
        backend = choose.prepare()
    except Exception as error:  # whatever is wrong here is what is to be reported
        return [Check("backend", _one_line(error), False)]
    version = f"LLVM {backend.llvm_version}" if backend.kind == "llvm" else "CUDA"
    return [
        Check("backend", f"{backend.kind} ({backend.variant})", True),
        Check("library", f"{version}, {backend.library}", True),
        Check("found by", backend.source, None),
        *(Check("passed over", note, None) for note in backend.notes),
    ]


def _check_libatomic() -> Check:
    try:
        if sys.platform == "linux":
            ctypes.CDLL("libatomic.so.1")
    except OSError:
        return Check("libatomic.so.1", f"not found: {REMEDY_ATOMIC}", False)
    return Check("libatomic.so.1", "found" if sys.platform == "linux" else "not needed here", True)


def _check_package(name: str) -> Check:
    version = package_version(name)
    return Check(name, version or f"not installed: run `pip install {name}`", version is not None)


def _check_cache() -> Check:
    try:
        return Check("cache", str(memory.cache_folder()), True)
    except OSError as error:
        return Check("cache", f"{_one_line(error)}: set XDG_CACHE_HOME to a folder that can be written", False)


def _one_line(error: Exception) -> str:
    return " ".join(str(error).split()) or type(error).__name__
