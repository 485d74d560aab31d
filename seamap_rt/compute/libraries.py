"""Libraries that Dr.Jit may run on: the trial of each, in a process of its own, since the failure to be expected ends
the process; its verdict, remembered in the user's cache; and one built here, the static archives of the wheel
`mlc-llvm-static` linked once into that cache."""

from __future__ import annotations

import contextlib
import hashlib
import importlib.util
import json
import logging
import os
import platform
import re
import shlex
import shutil
import signal
import stat
import subprocess
import sys
import tempfile
import time
from collections.abc import Iterator
from importlib import metadata
from pathlib import Path
from typing import Literal, NamedTuple

from .locks import scratch_folder

Kind = Literal["cuda", "llvm"]
VARIABLE = "DRJIT_LIBLLVM_PATH"  # of the environment: names the LLVM library that Dr.Jit loads
OLDEST_LLVM = 17  # 15 and 16 abort on x86, Dr.Jit itself refuses 14
VARIANTS: dict[Kind, str] = {"cuda": "cuda_ad_mono_polarized", "llvm": "llvm_ad_mono_polarized"}
TRIAL_LIMIT_S = 120.0  # a cold import from a slow disk is allowed, a hang is not
FAILURE_LIFETIME_S = 3600.0  # after which a rejected library is tried again
WHEEL, _LINKING_LIMIT_S = "mlc-llvm-static", 300.0
log = logging.getLogger(__name__)


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


def try_library(candidate: Candidate) -> Verdict:
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


# ------------------------------------------------------------------------------------------------ a library built here


class _BuildError(Exception):
    """Why no library can be linked from the wheel here."""


def own_llvm(notes: list[str]) -> Iterator[Candidate]:
    """The library linked earlier; if there is none, or it failed its test, a new one."""
    wheel = package_version(WHEEL)
    try:
        folder = cache_folder()
        builds = [path for path in folder.glob(build_name(wheel or "*")) if path.is_file()]
        if builds:  # where no wheel is installed any more, the newest that one has left
            yield Candidate(
                "llvm",
                max(builds, key=lambda path: [int(part) for part in re.findall(r"\d+", path.name)]),
                "cached build",
            )
        yield Candidate("llvm", link_wheel(folder, wheel), f"built from {WHEEL}")
    except _BuildError as error:
        notes.append(str(error))
    except OSError as error:
        notes.append(f"no LLVM can be kept in a cache: {error}")


def build_name(wheel: str) -> str:
    return f"libLLVM-{wheel}-{platform.machine()}.so"


def link_wheel(folder: Path, wheel: str | None) -> Path:
    """Link the wheel's archives into one shared library, which appears in the folder whole or not at all."""
    if sys.platform != "linux":
        raise _BuildError(f"{WHEEL} is linked on Linux only")
    archives = archives_of_wheel()
    if wheel is None or not archives:
        raise _BuildError(f"the wheel {WHEEL} is not installed")
    # A C++ compiler driver knows where its own runtime library lies, which a bare ld does not.
    drivers = (shlex.split(name) for name in (os.environ.get("CXX", ""), "c++", "g++", "clang++"))
    linker = next((each for each in drivers if each and shutil.which(each[0])), None)
    if linker is None:
        raise _BuildError(f"no g++ to link {WHEEL} with")
    library = folder / build_name(wheel)
    log.info("linking LLVM from %s into %s (once)", WHEEL, library)
    with scratch_folder(".link-", folder) as scratch:
        whole = scratch / library.name
        _run_linker(linker, archives, whole)
        os.replace(whole, library)
    return library


def archives_of_wheel() -> list[Path]:
    """The wheel's static archives, found without importing it."""
    spec = importlib.util.find_spec("mlc_llvm_static")
    roots = (spec.submodule_search_locations or []) if spec else []
    return [path for root in roots for path in sorted(Path(root, "static", "lib").glob("*.a"))]


def _run_linker(linker: list[str], archives: list[Path], output: Path) -> None:
    exports = output.with_suffix(".map")
    # Only the C interface is shown: another LLVM in the same process then cannot be confused with this one.
    exports.write_text("{ global: LLVM*; local: *; };\n", encoding="ascii")
    command = [
        *linker,
        *("-shared", "-s", "-o", str(output)),
        # Dr.Jit asks for its functions by name at run time, so no object file asks for them: name them here.
        *(f"-Wl,-u,{symbol}" for symbol in c_interface(archives)),
        f"-Wl,--version-script={exports}",
        "-Wl,--gc-sections",
        "-Wl,-z,defs",  # what is missing shall show now, not when the library is loaded
        "-Wl,-z,nodelete",  # Dr.Jit closes its LLVM at exit, while LLVM's own destructors are still to run
        *("-Wl,--start-group", *map(str, archives), "-Wl,--end-group"),
        *("-lpthread", "-ldl", "-lm"),
    ]
    try:
        done = run(command, _LINKING_LIMIT_S)
    except (OSError, subprocess.SubprocessError) as error:
        raise _BuildError(f"{linker[0]} did not link {WHEEL}: {type(error).__name__}") from error
    if done.returncode != 0:
        raise _BuildError(f"{linker[0]} did not link {WHEEL}: {reason(done)}")


def c_interface(archives: list[Path]) -> list[str]:
    """LLVM's whole C interface, of which Dr.Jit resolves about sixty functions, other ones with each release.

    All of it makes the library 4 % larger than the sixty do. Only the initialisers of other machines' targets
    stay out: where the wheel's extra targets are installed each would draw in a whole code generator.
    """
    target = {"x86_64": "X86", "aarch64": "AArch64", "arm64": "AArch64"}.get(platform.machine(), "")
    wanted = re.compile(rf"LLVM(?!Initialize(?!{target}(?:Target|Asm|Disassembler)))[A-Z].*")
    return sorted({name for archive in archives for name in _symbols(archive) if wanted.fullmatch(name)})


def _symbols(archive: Path) -> list[str]:
    """What an archive defines, by the index at its head.

    System V's format: 8 bytes of magic; a member header of 60 bytes with the name in the first 16, "/" for
    the index, and the size as decimal digits in bytes 48 to 58; then a big-endian count, as many 4-byte
    offsets, and as many names, each closed by a zero byte.
    """
    with archive.open("rb") as file:
        head = file.read(68)
        if head[:8] != b"!<arch>\n" or head[8:24].rstrip() != b"/":
            return []
        index = file.read(int(head[56:66]))
    count = int.from_bytes(index[:4])
    return index[4 + 4 * count :].decode("ascii", "replace").split("\0")[:count]
