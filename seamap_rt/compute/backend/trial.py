"""A library's trial: a process of its own works with it, since the failure to be expected ends the process. What comes
of it is remembered in the user's cache."""

from __future__ import annotations

import contextlib
import hashlib
import json
import os
import platform
import re
import signal
import stat
import subprocess
import sys
import tempfile
import time
from importlib import metadata
from pathlib import Path
from typing import Literal, NamedTuple

from ..locks import scratch_folder

Kind = Literal["cuda", "llvm"]
VARIABLE = "DRJIT_LIBLLVM_PATH"  # of the environment: names the LLVM library that Dr.Jit loads
OLDEST_LLVM = 17  # 15 and 16 abort on x86, Dr.Jit itself refuses 14
VARIANTS: dict[Kind, str] = {"cuda": "cuda_ad_mono_polarized", "llvm": "llvm_ad_mono_polarized"}
TRIAL_LIMIT_S = 120.0  # a cold import from a slow disk is allowed, a hang is not
FAILURE_LIFETIME_S = 3600.0  # after which a rejected library is tried again


class Candidate(NamedTuple):
    kind: Kind
    library: Path
    source: str


class Verdict(NamedTuple):
    works: bool
    detail: str  # the library's version if it works, else the reason why not


def package_version(package: str) -> str | None:
    """The version of an installed package, without importing it."""
    try:
        return metadata.version(package)
    except Exception:  # not installed, or its metadata damaged: the same for us
        return None


# LLVM's failure is an abort, so this runs without a core dump. ctypes loads the library first because Dr.Jit would go
# on to another one without a message. A ray is traced because CUDA without OptiX is of no use.
TRIAL = """
import ctypes, sys
try:
    import resource
    resource.setrlimit(resource.RLIMIT_CORE, (0, 0))
except ImportError:
    pass
kind, library, variant = sys.argv[1:]
handle = ctypes.CDLL(library)
if kind == "cuda":
    number = ctypes.c_int()
    handle.cuDriverGetVersion(ctypes.byref(number))
    version = f"{number.value // 1000}.{number.value % 1000 // 10}"
elif hasattr(handle, "LLVMGetVersion"):
    numbers = [ctypes.c_uint() for _ in range(3)]
    handle.LLVMGetVersion(*map(ctypes.byref, numbers))
    version = ".".join(str(number.value) for number in numbers)
else:
    version = "15 or older"
import drjit as dr
import mitsuba as mi
mi.set_variant(variant)
x = dr.arange(mi.Float, 7) - 3
if list(dr.maximum(x, 0)) != [0, 0, 0, 0, 1, 2, 3] or list(dr.clip(x, -1, 1)) != [-1, -1, -1, 0, 1, 1, 1]:
    sys.exit("it computes a maximum wrongly")
plate = mi.load_dict({"type": "scene", "plate": {"type": "rectangle"}})
hit = plate.ray_intersect(mi.Ray3f(mi.Point3f(0, 0, 2), mi.Vector3f(0, 0, -1)))
if not dr.all(abs(hit.t - 2) < 1e-3):
    sys.exit("it traces a ray wrongly")
print("works", version)
"""


def try_out(candidate: Candidate) -> Verdict:
    """Let a process of its own work with the library."""
    with scratch_folder() as scratch:
        environment = os.environ | {"DRJIT_CACHE_DIR": str(scratch)}  # a kernel compiled earlier proves nothing
        if candidate.kind == "llvm":
            environment[VARIABLE] = str(candidate.library)
        arguments = [candidate.kind, str(candidate.library), VARIANTS[candidate.kind]]
        # -P: a file called drjit.py in the working folder is not Dr.Jit.
        command = [sys.executable, "-P", "-W", "ignore", "-c", TRIAL, *arguments]
        try:
            done = run(command, TRIAL_LIMIT_S, environment)
        except subprocess.TimeoutExpired:
            return Verdict(False, f"no answer within {TRIAL_LIMIT_S:.0f} s")
        except OSError as error:
            return Verdict(False, f"cannot start {sys.executable}: {error.strerror}")
    answer = re.search(r"^works (.+)$", done.stdout, re.MULTILINE)
    if done.returncode != 0 or answer is None:
        return Verdict(False, reason(done))
    return Verdict(True, answer[1])


def run(command: list[str], limit_s: float, environment: dict[str, str] | None = None) -> subprocess.CompletedProcess:
    """A command with its output as text. Raises OSError and subprocess.TimeoutExpired."""
    return subprocess.run(
        command, env=environment, stdin=subprocess.DEVNULL, capture_output=True, encoding="utf-8", errors="replace",
        timeout=limit_s,
    )  # fmt: skip


def reason(done: subprocess.CompletedProcess) -> str:
    """Why a command failed, in a few words of one line."""
    if "libatomic" in done.stderr:  # Dr.Jit itself ends in a NameError here, which names no cause
        return "libatomic.so.1 is missing, which Dr.Jit needs"
    if re.search("Cannot select|too old|is inactive because the LLVM", done.stderr):
        return f"too old or incomplete, LLVM {OLDEST_LLVM} or newer is needed"
    lines = [line.strip() for line in done.stderr.splitlines() if line.strip()]
    if done.returncode < 0:
        with contextlib.suppress(ValueError):
            lines.append(f"the process ended with {signal.Signals(-done.returncode).name}")
    return lines[-1][:200] if lines else f"the process ended with code {done.returncode}"


# ------------------------------------------------------------------------------------------------ what is remembered


def cache_folder() -> Path:
    """The user's cache; where that cannot be written, one under the temporary folder; OSError if neither."""
    named = os.environ.get("XDG_CACHE_HOME", "")  # a relative one is to be ignored, says the XDG specification
    try:
        return _writable((Path(named) if os.path.isabs(named) else Path.home() / ".cache") / "seamap_rt")
    except (OSError, RuntimeError):  # RuntimeError: no HOME, and no entry in the password file
        folder = _writable(Path(tempfile.gettempdir(), f"seamap_rt-{os.getuid()}"))
    status = folder.lstat()  # code is loaded from here, and /tmp is shared: another user may have made it
    others = stat.S_IWGRP | stat.S_IWOTH
    if status.st_uid != os.getuid() or not stat.S_ISDIR(status.st_mode) or status.st_mode & others:
        raise PermissionError(f"{folder} belongs to, or can be changed by, someone else")
    return folder


def _writable(folder: Path) -> Path:
    folder.mkdir(mode=0o700, parents=True, exist_ok=True)
    if not os.access(folder, os.W_OK | os.X_OK):
        raise PermissionError(f"{folder} is not writable")
    return folder


def verdict_file(candidate: Candidate) -> Path | None:
    """Where a verdict is kept: its name changes with all that could change the verdict."""
    try:
        status, folder = candidate.library.stat(), cache_folder()
    except OSError:
        return None  # a bare name for the loader to resolve, or nowhere to write: judged anew each time
    cards = os.environ.get("CUDA_VISIBLE_DEVICES") if candidate.kind == "cuda" else None
    machine = platform.node()  # a home folder may be shared by unlike machines
    versions = package_version("drjit"), package_version("mitsuba"), sys.version
    facts = [
        candidate.kind,
        str(candidate.library),
        status.st_mtime_ns,
        status.st_size,
        *versions,
        machine,
        cards,
        TRIAL,
    ]
    return folder / f"verdict-{hashlib.sha256(json.dumps(facts).encode()).hexdigest()[:24]}.json"


def recall(file: Path | None) -> Verdict | None:
    """An earlier verdict on the same library in the same circumstances; a failure only while it is fresh."""
    if file is None:
        return None
    try:
        verdict = Verdict(**json.loads(file.read_text(encoding="utf-8")))
        fresh = time.time() - file.stat().st_mtime < FAILURE_LIFETIME_S
    except (OSError, ValueError, TypeError):  # none, or another process is writing it
        return None
    return verdict if verdict.works or fresh else None


def remember(file: Path | None, verdict: Verdict) -> None:
    """Keep a verdict. Only speed is lost where that fails."""
    if file is not None:
        with contextlib.suppress(OSError):
            file.write_text(json.dumps(verdict._asdict()), encoding="utf-8")
