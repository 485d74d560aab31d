"""When and where a validation ran: figures can be compared only with their machine and versions."""

from __future__ import annotations

import importlib.metadata
import platform
import subprocess
from dataclasses import dataclass
from datetime import datetime
from pathlib import Path

from seamap_rt.compute.machine import cores

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
class Environment:
    """Time, machine, versions, and the commit of a checkout ("" elsewhere)."""

    when: str
    machine: str
    versions: dict[str, str]
    commit: str

    @classmethod
    def here(cls) -> Environment:
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
    versions = {}
    for name in _PACKAGES:
        try:
            versions[name] = importlib.metadata.version(name)
        except importlib.metadata.PackageNotFoundError:
            versions[name] = "not installed"
    return versions


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
