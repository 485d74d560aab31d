"""Chooses the backend that Dr.Jit will use: call `prepare()` before drjit, mitsuba or sionna is imported.

Dr.Jit loads its LLVM while it is being imported and keeps it, and on x86 an LLVM before 17 does not raise
an error: compiling a maximum ends the whole process. So the choice is made here, in a file that imports none of
them, and each candidate is first tested in a process of its own. The first that passes is used:

    CUDA  →  the library that DRJIT_LIBLLVM_PATH names  →  the system's libLLVM, newest first
          →  one linked once into the user's cache from the static archives of the wheel `mlc-llvm-static`

A library named by the user is binding: where it fails its test the search ends with an error.
Going on would compute with another LLVM than the one that was asked for.
"""

from __future__ import annotations

import contextlib
import ctypes
import os
import platform
import re
import subprocess
import sys
from collections.abc import Iterator
from dataclasses import dataclass
from functools import cache
from pathlib import Path
from typing import NamedTuple

from ..errors import NoBackendError
from . import libraries
from .libraries import OLDEST_LLVM, VARIABLE, VARIANTS, Candidate, Kind, Verdict
from .machine import cores

_PACKAGES = ("sionna-rt", "mitsuba", "drjit", "trimesh", "numpy")
_REMEDY_ATOMIC = "run `apt-get install libatomic1`"
_REMEDY_MACOS = "run `brew install llvm`, or `conda install -c conda-forge llvm`"
_REMEDY_LINUX = (
    "run `apt-get install libllvm19 libatomic1`, or `pip install 'seamap_rt[llvm]'` with g++ installed, "
    "or `conda install -c conda-forge llvm`"
)
_LLVM = re.compile(r"libLLVM(?:-(\d[\d.]*)[^/]*)?\.(?:so|dylib)(?:\.(\d[\d.]*))?")


@dataclass(frozen=True)
class Backend:
    """What Dr.Jit will run on, and how it was found."""

    kind: Kind
    library: Path | None
    llvm_version: str | None
    source: str
    variant: str
    notes: tuple[str, ...] = ()  # candidates passed over on the way, and why


@cache
def prepare() -> Backend:
    """Choose a backend, once per process, and point Dr.Jit at it. Raises NoBackendError where there is none."""
    notes: list[str] = []
    news: list[tuple[Path | None, Verdict]] = []
    for candidate in _candidates(notes):
        kind, library, source = candidate
        file = libraries.verdict_file(candidate)  # named before the trial: the library may be replaced after it
        verdict = libraries.recall(file)
        if verdict is None:
            verdict = libraries.try_library(candidate)
            news.append((file, verdict))
        if verdict.works:
            # Failures are remembered only where something else works, so that mending is noticed at once.
            for item in news:
                libraries.remember(*item)
            if kind == "llvm":
                os.environ[VARIABLE] = str(library)  # where Dr.Jit looks, and processes started from here
            version = verdict.detail if kind == "llvm" else None
            return Backend(kind, library, version, source, VARIANTS[kind], tuple(notes))
        notes.append(f"{source} {library}: {verdict.detail}")
    raise NoBackendError(_explain(notes))


def _candidates(notes: list[str]) -> Iterator[Candidate]:
    """What may serve, best first. Lazy, because the last resort takes seconds and disk space to make."""
    for driver in find(re.compile(r"libcuda\.so\.1")):
        yield Candidate("cuda", driver, "cuda")
    if named := os.environ.get(VARIABLE):
        yield Candidate("llvm", Path(named), VARIABLE)
    elif "drjit" in sys.modules:  # too late to choose: judge what it has loaded
        for library in loaded_llvm():
            yield Candidate("llvm", library, "already loaded")
        notes.append(f"Dr.Jit was imported before an LLVM was chosen for it: set {VARIABLE}, or prepare() first")
    else:
        system = system_llvm()
        for library in system:
            yield Candidate("llvm", library, "system")
        if not system:
            notes.append(f"no libLLVM {OLDEST_LLVM} or newer in the system's library folders")
        yield from libraries.own_llvm(notes)


def _explain(notes: list[str]) -> str:
    """One line: what was tried, why it failed, what to run."""
    reasons = "; ".join(notes)
    remedy = _REMEDY_MACOS if sys.platform == "darwin" else _REMEDY_LINUX
    if os.environ.get(VARIABLE):
        remedy = f"unset {VARIABLE} or name another file; else {remedy}"
    if "libatomic" in reasons:  # nothing works without it, and nothing else is missing as far as can be seen
        remedy = _REMEDY_ATOMIC
    return f"no usable Dr.Jit backend ({reasons}): {remedy}"


# ---------------------------------------------------------------------------------------------------------- the search


def library_folders() -> list[Path]:
    """Where a shared library may lie: the user's own choices, Python's environment, what a site has set for the loader,
    then the system, with each of Debian's, Fedora's, Gentoo's and Homebrew's several LLVMs."""
    folders = os.environ.get("LD_LIBRARY_PATH", "").split(os.pathsep)
    folders += [f"{root}/lib" for root in (os.environ.get("CONDA_PREFIX"), sys.prefix) if root]
    with contextlib.suppress(OSError, subprocess.SubprocessError):
        folders += re.findall(r"=> (/\S*)/", libraries.run(["/sbin/ldconfig", "-p"], 10.0).stdout)
    folders += [f"/usr/lib/{platform.machine()}-linux-gnu", "/usr/lib64", "/usr/lib", "/usr/local/lib"]
    folders += ["/usr/lib/wsl/lib"]
    roots = ("/usr/lib", "/usr/lib64", "/opt/homebrew/opt", "/usr/local/opt")
    several = ("llvm*/lib", "llvm*/lib64", "llvm/*/lib*")
    folders += [str(each) for root in roots for pattern in several for each in Path(root).glob(pattern)]
    return [Path(each) for each in dict.fromkeys(filter(None, folders))]


def find(name: re.Pattern[str]) -> list[Path]:
    """The files in the library folders whose whole name matches, links followed, each once."""
    files: dict[Path, None] = {}
    for folder in library_folders():
        with contextlib.suppress(OSError):
            matching = (folder / each for each in sorted(os.listdir(folder)) if name.fullmatch(each))
            files |= {path.resolve(): None for path in matching if path.is_file()}
    return list(files)


def version_in_name(library: Path) -> tuple[int, ...]:
    """(15,) for libLLVM-15.so.1, (19, 1) for libLLVM.so.19.1, () where the name has no version."""
    match = _LLVM.fullmatch(library.name)
    digits = (match[1] or match[2] or "") if match else ""
    return tuple(int(part) for part in digits.split(".") if part)


def system_llvm() -> list[Path]:
    """Libraries new enough, newest first; last those whose name has no version, for the trial to decide."""
    recent = [path for path in find(_LLVM) if (version_in_name(path) or (OLDEST_LLVM,))[0] >= OLDEST_LLVM]
    return sorted(recent, key=version_in_name, reverse=True)


def loaded_llvm() -> list[Path]:
    """The LLVM libraries already mapped into this process (known on Linux only)."""
    maps = ""
    with contextlib.suppress(OSError):
        maps = Path("/proc/self/maps").read_text()
    return sorted(path for each in set(re.findall(r" (/[^\n]+)", maps)) if _LLVM.fullmatch((path := Path(each)).name))


# ---------------------------------------------------------------------------------------------------------- the doctor


class Check(NamedTuple):
    """A line of `doctor`: what was looked at, what was found (or what mends it), and whether it will do; None where
    that is no question."""

    item: str
    value: str
    ok: bool | None


def checks() -> list[Check]:
    """What a run would use here, and what mends what is missing. Never raises."""
    rows = _check_backend()
    try:
        if sys.platform == "linux":
            ctypes.CDLL("libatomic.so.1")
        rows.append(Check("libatomic.so.1", "found" if sys.platform == "linux" else "not needed here", True))
    except OSError:
        rows.append(Check("libatomic.so.1", f"not found: {_REMEDY_ATOMIC}", False))
    rows.append(Check("python", platform.python_version(), True))
    for name in _PACKAGES:
        version = libraries.package_version(name)
        rows.append(Check(name, version or f"not installed: run `pip install {name}`", version is not None))
    try:
        rows.append(Check("cache", str(libraries.cache_folder()), True))
    except OSError as error:
        remedy = "set XDG_CACHE_HOME to a folder that can be written"
        rows.append(Check("cache", f"{' '.join(str(error).split())}: {remedy}", False))
    return [*rows, Check("cores", str(len(cores())), None)]


def doctor_lines(rows: list[Check]) -> list[str]:
    """The rows as plain lines of text."""
    width = max(len(each.item) for each in rows)
    words = {True: "ok", False: "MISSING", None: "info"}
    return [f"{words[check.ok]:<7}  {check.item:<{width}}  {check.value}" for check in rows]


def _check_backend() -> list[Check]:
    try:
        backend = prepare()
    except Exception as error:  # whatever is wrong here is what is to be reported
        return [Check("backend", " ".join(str(error).split()) or type(error).__name__, False)]
    version = f"LLVM {backend.llvm_version}" if backend.kind == "llvm" else "CUDA"
    return [
        Check("backend", f"{backend.kind} ({backend.variant})", True),
        Check("library", f"{version}, {backend.library}", True),
        Check("found by", backend.source, None),
        *(Check("passed over", note, None) for note in backend.notes),
    ]
