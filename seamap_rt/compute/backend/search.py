"""Where the CUDA driver and LLVM libraries may lie on this machine."""

from __future__ import annotations

import contextlib
import os
import platform
import re
import shutil
import subprocess
import sys
from pathlib import Path

from .kinds import OLDEST_LLVM


def find(name: str) -> list[Path]:
    """The files in the library folders whose whole name matches, links followed, each once."""
    wanted = re.compile(name)
    files: dict[Path, None] = {}
    for folder in library_folders():
        with contextlib.suppress(OSError):
            for entry in sorted(os.listdir(folder)):
                path = folder / entry
                if wanted.fullmatch(entry) and path.is_file():
                    files[path.resolve()] = None
    return list(files)


def library_folders() -> list[Path]:
    """Where a shared library may lie: the user's own choices, Python's environment, then the system."""
    folders = [Path(entry) for entry in os.environ.get("LD_LIBRARY_PATH", "").split(os.pathsep) if entry]
    if conda := os.environ.get("CONDA_PREFIX"):
        folders.append(Path(conda, "lib"))
    folders += [Path(sys.prefix, "lib"), *_loader_folders()]
    folders += [
        Path(name)
        for name in (
            f"/usr/lib/{platform.machine()}-linux-gnu",
            *("/usr/lib64", "/usr/lib", "/usr/local/lib", "/usr/lib/wsl/lib", "/opt/homebrew/opt/llvm/lib"),
        )
    ]
    for root in (
        Path("/usr/lib"),
        Path("/usr/lib64"),
    ):  # each of Debian's, Fedora's and Gentoo's several LLVMs
        folders += [*root.glob("llvm*/lib"), *root.glob("llvm*/lib64"), *root.glob("llvm/*/lib*")]
    return list(dict.fromkeys(folders))


def _loader_folders() -> list[Path]:
    """The folders that the dynamic loader knows: a site may have added its own."""
    ldconfig = shutil.which("ldconfig", path=os.environ.get("PATH", "") + ":/usr/sbin:/sbin")
    if ldconfig is None:
        return []
    try:
        listing = subprocess.run([ldconfig, "-p"], capture_output=True, text=True, timeout=10).stdout
    except (OSError, subprocess.SubprocessError):
        return []
    return list(dict.fromkeys(Path(path).parent for path in re.findall(r"=> (/\S+)", listing)))


_LLVM_NAME = r"libLLVM(?:-(\d[\d.]*)[^/]*)?\.(?:so|dylib)(?:\.(\d[\d.]*))?"


def version_in_name(library: Path) -> tuple[int, ...]:
    """(15,) for libLLVM-15.so.1, (19, 1) for libLLVM.so.19.1, () where the name has no version."""
    match = re.fullmatch(_LLVM_NAME, library.name)
    digits = (match[1] or match[2] or "") if match else ""
    return tuple(int(part) for part in digits.split(".") if part)


def system_llvm() -> list[Path]:
    """Libraries new enough, newest first; last those whose name has no version, for the probe to decide."""
    libraries = find(_LLVM_NAME)
    recent = [path for path in libraries if (version_in_name(path) or (OLDEST_LLVM,))[0] >= OLDEST_LLVM]
    return sorted(recent, key=version_in_name, reverse=True)


def loaded_llvm() -> list[Path]:
    """The LLVM libraries already mapped into this process (known on Linux only)."""
    try:
        maps = Path("/proc/self/maps").read_text()
    except OSError:
        return []
    paths = {Path(path) for path in re.findall(r" (/[^\n]+)", maps)}
    return sorted(path for path in paths if re.fullmatch(_LLVM_NAME, path.name))
