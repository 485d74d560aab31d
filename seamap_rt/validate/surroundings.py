"""When and on what a validation ran: a figure without its machine and its versions cannot be held against another."""

from __future__ import annotations

import importlib.metadata
import platform
import subprocess
from dataclasses import dataclass
from datetime import datetime
from pathlib import Path

from ..compute.machine import cores

_PACKAGES = (
    "seamap_rt",
    "numpy",
    "scipy",
    "numba",
    "xarray",
    "sionna-rt",
    "mitsuba",
    "drjit",
    "matplotlib",
    "wavespectra",
)


@dataclass(frozen=True)
class Surroundings:
    """Time, machine, versions, and the commit of a checkout ("" elsewhere)."""

    when: str
    machine: str
    versions: dict[str, str]
    commit: str

    @classmethod
    def here(cls) -> Surroundings:
        return cls(datetime.now().astimezone().isoformat(" ", "seconds"), _machine(), _versions(), _commit())


def _machine() -> str:
    system = f"{platform.system()} {platform.release()}; Python {platform.python_version()}"
    return f"{_processor()}, {len(cores())} cores; {system}"


def _processor() -> str:
    try:
        lines = Path("/proc/cpuinfo").read_text(encoding="utf-8", errors="replace").splitlines()
        return next(line.split(":", 1)[1].strip() for line in lines if line.startswith("model name"))
    except (OSError, StopIteration):
        return platform.processor() or platform.machine()


def _versions() -> dict[str, str]:
    found = {}
    for name in _PACKAGES:
        try:
            found[name] = importlib.metadata.version(name)
        except importlib.metadata.PackageNotFoundError:
            found[name] = "not installed"
    return found


def _commit() -> str:
    """Of the checkout that the package lies in, and whether files in it were changed since."""
    root = Path(__file__).resolve().parents[2]
    if not (root / ".git").exists():
        return ""
    commit = _git(root, "rev-parse", "HEAD")
    changed = _git(root, "status", "--porcelain", "--untracked-files=no")
    return f"{commit[:12]}{' with changes' if changed else ''}"


def _git(root: Path, *words: str) -> str:
    command = ["git", "--no-optional-locks", "-C", str(root), *words]
    try:
        return subprocess.run(command, capture_output=True, text=True, timeout=20, check=True).stdout.strip()
    except (OSError, subprocess.SubprocessError):
        return ""
