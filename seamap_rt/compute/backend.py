"""Chooses the backend that Dr.Jit will use: call `prepare()` before drjit, mitsuba or sionna is imported.

Dr.Jit loads its LLVM while it is being imported and keeps it, and on x86 an LLVM before 17 does not fail
politely: compiling a maximum ends the whole process. So the choice falls here, in a file that imports none of
them, and each candidate first has to prove itself in a process of its own. The first that does so wins:

    CUDA  →  the library that DRJIT_LIBLLVM_PATH names  →  the system's libLLVM, newest first
          →  one linked once into the user's cache from the static archives of the wheel `mlc-llvm-static`

A library named by the user is an order, not a hint: where it fails its proof the search ends and says so.
Going on would compute with another LLVM than the one that was asked for.
"""

from __future__ import annotations

import contextlib
import ctypes
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
import struct
import subprocess
import sys
import tempfile
import time
from collections.abc import Iterator
from dataclasses import asdict, dataclass
from functools import cache
from importlib import metadata
from pathlib import Path
from typing import Literal, NamedTuple

from ..errors import NoBackend
from .machine import cores

Kind = Literal["cuda", "llvm"]

VARIABLE = "DRJIT_LIBLLVM_PATH"
OLDEST_LLVM = 17  # 15 and 16 abort on x86, Dr.Jit itself refuses 14
VARIANTS: dict[Kind, str] = {"cuda": "cuda_ad_mono_polarized", "llvm": "llvm_ad_mono_polarized"}
WHEEL = "mlc-llvm-static"
PACKAGES = ("sionna-rt", "mitsuba", "drjit", "trimesh", "numpy")

PROBE_LIMIT_S = 120.0  # a cold import from a slow disk is allowed, a hang is not
LINK_LIMIT_S = 300.0
FAILURE_LIFETIME_S = 3600.0  # after which a rejected library is given another chance

REMEDY_ATOMIC = "run `apt-get install libatomic1`"
REMEDY = (
    "run `apt-get install libllvm19 libatomic1`, or `pip install 'seamap_rt[llvm]'` with g++ installed, "
    "or `conda install -c conda-forge llvm`"
)

log = logging.getLogger(__name__)


@dataclass(frozen=True)
class Backend:
    """What Dr.Jit will run on, and how it was found."""

    kind: Kind
    library: Path | None
    llvm_version: str | None
    source: str
    variant: str
    notes: tuple[str, ...] = ()  # candidates passed over on the way, and why


class Check(NamedTuple):
    """A line of `doctor`: what was looked at, what was found (or what mends it), and whether it will do."""

    item: str
    value: str
    ok: bool


@dataclass(frozen=True)
class _Candidate:
    kind: Kind
    library: Path
    source: str


@dataclass(frozen=True)
class _Verdict:
    works: bool
    detail: str  # the library's version if it works, else the reason why not


class _CannotBuild(Exception):
    """Why no library can be linked from the wheel here."""


# ------------------------------------------------------------------------------------------------- the choice


@cache
def prepare() -> Backend:
    """Settle on a backend, once per process, and point Dr.Jit at it. Raises NoBackend where there is none."""
    notes: list[str] = []
    news: list[tuple[Path | None, _Verdict]] = []
    for candidate in _candidates(notes):
        file = _verdict_file(candidate)  # named before the trial: the library may be replaced after it
        verdict = _recall(file)
        if verdict is None:
            verdict = _try_out(candidate)
            news.append((file, verdict))
        if verdict.works:
            # Failures are remembered only where something else works, so that mending is noticed at once.
            for item in news:
                _remember(*item)
            return _adopt(candidate, verdict, notes)
        notes.append(f"{candidate.source} {candidate.library}: {verdict.detail}")
    raise NoBackend(_explain(notes))


def _candidates(notes: list[str]) -> Iterator[_Candidate]:
    """What may serve, best first. Lazy, because the last resort takes seconds and disk space to make."""
    for driver in _find(r"libcuda\.so\.1"):
        yield _Candidate("cuda", driver, "cuda")
    if named := os.environ.get(VARIABLE):
        yield _Candidate("llvm", Path(named), VARIABLE)
    elif "drjit" in sys.modules:  # too late to choose: judge what it has loaded
        for library in _loaded_llvm():
            yield _Candidate("llvm", library, "already loaded")
        notes.append(f"Dr.Jit was imported before an LLVM was chosen for it: set {VARIABLE}, or prepare() first")
    else:
        system = _system_llvm()
        for library in system:
            yield _Candidate("llvm", library, "system")
        if not system:
            notes.append(f"no libLLVM {OLDEST_LLVM} or newer in the system's library folders")
        yield from _own_llvm(notes)


def _adopt(candidate: _Candidate, verdict: _Verdict, notes: list[str]) -> Backend:
    """Tell Dr.Jit, and the processes started from here, where to look."""
    version = None
    if candidate.kind == "llvm":
        os.environ[VARIABLE] = str(candidate.library)
        version = verdict.detail
    return Backend(candidate.kind, candidate.library, version, candidate.source, VARIANTS[candidate.kind], tuple(notes))


def _explain(notes: list[str]) -> str:
    """One line: what was tried, why it failed, what to run."""
    reasons = "; ".join(notes)
    if "libatomic" in reasons:  # nothing works without it, and nothing else is missing as far as can be seen
        return f"no usable Dr.Jit backend ({reasons}): {REMEDY_ATOMIC}"
    if os.environ.get(VARIABLE):
        return f"no usable Dr.Jit backend ({reasons}): unset {VARIABLE} or name another file; else {REMEDY}"
    return f"no usable Dr.Jit backend ({reasons}): {REMEDY}"


# ------------------------------------------------------------------------------------------------- the search


def _find(name: str) -> list[Path]:
    """The files in the library folders whose whole name matches, links followed, each once."""
    wanted = re.compile(name)
    found: dict[Path, None] = {}
    for folder in _library_folders():
        with contextlib.suppress(OSError):
            for entry in sorted(os.listdir(folder)):
                path = folder / entry
                if wanted.fullmatch(entry) and path.is_file():
                    found[path.resolve()] = None
    return list(found)


def _library_folders() -> list[Path]:
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


def _version_in_name(library: Path) -> tuple[int, ...]:
    """(15,) for libLLVM-15.so.1, (19, 1) for libLLVM.so.19.1, () where the name does not tell."""
    match = re.fullmatch(_LLVM_NAME, library.name)
    digits = (match[1] or match[2] or "") if match else ""
    return tuple(int(part) for part in digits.split(".") if part)


def _system_llvm() -> list[Path]:
    """Libraries new enough, newest first; last those whose name does not tell, for the probe to decide."""
    libraries = _find(_LLVM_NAME)
    recent = [path for path in libraries if (_version_in_name(path) or (OLDEST_LLVM,))[0] >= OLDEST_LLVM]
    return sorted(recent, key=_version_in_name, reverse=True)


def _loaded_llvm() -> list[Path]:
    """The LLVM libraries already mapped into this process (Linux tells, elsewhere none is seen)."""
    try:
        maps = Path("/proc/self/maps").read_text()
    except OSError:
        return []
    paths = {Path(path) for path in re.findall(r" (/[^\n]+)", maps)}
    return sorted(path for path in paths if re.fullmatch(_LLVM_NAME, path.name))


# -------------------------------------------------------------------------------------------------- the proof

# LLVM's failure is an abort, so this runs in a process of its own, without a core dump. ctypes loads the
# library first because Dr.Jit would go on to another one without a word. A ray is traced because CUDA without
# OptiX is of no use.
_PROBE = """
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


def _try_out(candidate: _Candidate) -> _Verdict:
    """Let a process of its own work with the library."""
    with tempfile.TemporaryDirectory(prefix="seamap_rt-probe-") as scratch:
        environment = os.environ | {"DRJIT_CACHE_DIR": scratch}  # a kernel compiled earlier proves nothing
        if candidate.kind == "llvm":
            environment[VARIABLE] = str(candidate.library)
        arguments = [candidate.kind, str(candidate.library), VARIANTS[candidate.kind]]
        # -P: a file called drjit.py in the working folder is not Dr.Jit.
        command = [sys.executable, "-P", "-W", "ignore", "-c", _PROBE, *arguments]
        try:
            done = subprocess.run(
                command,
                env=environment,
                stdin=subprocess.DEVNULL,
                capture_output=True,
                text=True,
                errors="replace",
                timeout=PROBE_LIMIT_S,
            )
        except subprocess.TimeoutExpired:
            return _Verdict(False, f"no answer within {PROBE_LIMIT_S:.0f} s")
        except OSError as error:
            return _Verdict(False, f"cannot start {sys.executable}: {error.strerror}")
    answer = re.search(r"^works (.+)$", done.stdout, re.MULTILINE)
    if done.returncode != 0 or answer is None:
        return _Verdict(False, _reason(done.returncode, done.stderr))
    return _Verdict(True, answer[1])


def _reason(returncode: int, stderr: str) -> str:
    """Why a probe failed, in a few words of one line."""
    if "libatomic" in stderr:  # Dr.Jit itself ends in a NameError here, which tells nobody anything
        return "libatomic.so.1 is missing, which Dr.Jit needs"
    if "Cannot select" in stderr or "too old" in stderr or "is inactive because the LLVM" in stderr:
        return f"too old or incomplete, LLVM {OLDEST_LLVM} or newer is needed"
    lines = [line.strip() for line in stderr.splitlines() if line.strip()]
    if returncode < 0:
        with contextlib.suppress(ValueError):
            lines.append(f"the process ended with {signal.Signals(-returncode).name}")
    return lines[-1][:200] if lines else f"the process ended with code {returncode}"


# ----------------------------------------------------------------------------------------- what is remembered


def cache_folder() -> Path:
    """The user's cache; where that cannot be written, one under the temporary folder; OSError if neither."""
    error: OSError | None = None
    for folder, shared_parent in ((_user_cache(), False), (_temporary_cache(), True)):
        if folder is None:
            continue
        try:
            folder.mkdir(mode=0o700, parents=True, exist_ok=True)
            if shared_parent:
                _refuse_what_others_can_change(folder)
            if os.access(folder, os.W_OK | os.X_OK):
                return folder
            raise PermissionError(f"{folder} is not writable")
        except OSError as problem:
            error = problem
    raise error or OSError("no folder for a cache")


def _user_cache() -> Path | None:
    named = os.environ.get("XDG_CACHE_HOME", "")
    if os.path.isabs(named):  # a relative one is to be ignored, says the XDG specification
        return Path(named, "seamap_rt")
    try:
        return Path.home() / ".cache" / "seamap_rt"
    except RuntimeError:  # no HOME, and no entry in the password file
        return None


def _temporary_cache() -> Path:
    owner = os.getuid() if hasattr(os, "getuid") else "cache"
    return Path(tempfile.gettempdir(), f"seamap_rt-{owner}")


def _refuse_what_others_can_change(folder: Path) -> None:
    """Code is loaded from here, and /tmp is everybody's: a folder laid ready by someone else is not used."""
    status = folder.lstat()
    mine = not hasattr(os, "getuid") or status.st_uid == os.getuid()
    if not (mine and stat.S_ISDIR(status.st_mode) and not status.st_mode & (stat.S_IWGRP | stat.S_IWOTH)):
        raise PermissionError(f"{folder} belongs to, or can be changed by, someone else")


def _verdict_file(candidate: _Candidate) -> Path | None:
    """Where a verdict is kept: its name changes with all that could change the verdict."""
    try:
        status = candidate.library.stat()
        folder = cache_folder()
    except OSError:
        return None  # a bare name for the loader to resolve, or nowhere to write: judged anew each time
    circumstances = [
        candidate.kind,
        str(candidate.library),
        status.st_mtime_ns,
        status.st_size,
        _version("drjit"),
        _version("mitsuba"),
        sys.version,
        platform.node(),  # a home folder may be shared by unlike machines
        os.environ.get("CUDA_VISIBLE_DEVICES") if candidate.kind == "cuda" else None,
        _PROBE,
    ]
    name = hashlib.sha256(json.dumps(circumstances).encode()).hexdigest()[:24]
    return folder / f"verdict-{name}.json"


def _recall(file: Path | None) -> _Verdict | None:
    """An earlier verdict on the same library in the same circumstances; a failure only while it is fresh."""
    if file is None:
        return None
    try:
        verdict = _Verdict(**json.loads(file.read_text(encoding="utf-8")))
        fresh = time.time() - file.stat().st_mtime < FAILURE_LIFETIME_S
    except (OSError, ValueError, TypeError):
        return None
    return verdict if verdict.works or fresh else None


def _remember(file: Path | None, verdict: _Verdict) -> None:
    """Keep a verdict. Only speed is lost where that fails."""
    if file is None:
        return
    with (
        contextlib.suppress(OSError),
        tempfile.TemporaryDirectory(dir=file.parent, prefix=".new-") as scratch,
    ):
        whole = Path(scratch, file.name)
        whole.write_text(json.dumps(asdict(verdict)), encoding="utf-8")
        os.replace(whole, file)  # two processes may be here at once: each sees a whole file or none


# --------------------------------------------------------------------------------------- a library of our own


def _own_llvm(notes: list[str]) -> Iterator[_Candidate]:
    """The library linked on an earlier day; if there is none, or it failed its proof, a new one."""
    wheel = _version(WHEEL)
    try:
        folder = cache_folder()
        for library in _cached_builds(folder, wheel):
            yield _Candidate("llvm", library, "cached build")
        yield _Candidate("llvm", _link(folder, wheel), f"built from {WHEEL}")
    except _CannotBuild as error:
        notes.append(str(error))
    except OSError as error:
        notes.append(f"no LLVM can be kept in a cache: {error}")


def _build_name(wheel: str) -> str:
    return f"libLLVM-{wheel}-{platform.machine()}.so"


def _cached_builds(folder: Path, wheel: str | None) -> list[Path]:
    """The installed wheel's build; where no wheel is installed any more, the newest that one has left."""
    builds = [path for path in folder.glob(_build_name(wheel or "*")) if path.is_file()]
    return sorted(builds, key=_version_in_name, reverse=True)[:1]


def _link(folder: Path, wheel: str | None) -> Path:
    """Link the wheel's archives into one shared library, which appears in the folder whole or not at all."""
    if sys.platform != "linux":
        raise _CannotBuild(f"{WHEEL} is linked on Linux only")
    archives = _archives()
    if wheel is None or not archives:
        raise _CannotBuild(f"the wheel {WHEEL} is not installed")
    linker = _linker()
    if linker is None:
        raise _CannotBuild(f"no g++ to link {WHEEL} with")
    library = folder / _build_name(wheel)
    log.info("linking LLVM from %s into %s (once)", WHEEL, library)
    with tempfile.TemporaryDirectory(dir=folder, prefix=".link-") as scratch:
        whole = Path(scratch, library.name)
        _run_linker(linker, archives, whole)
        os.replace(whole, library)
    return library


def _archives() -> list[Path]:
    """The wheel's static archives, found without importing it."""
    spec = importlib.util.find_spec("mlc_llvm_static")
    roots = (spec.submodule_search_locations or []) if spec else []
    return [path for root in roots for path in sorted(Path(root, "static", "lib").glob("*.a"))]


def _linker() -> list[str] | None:
    """A C++ compiler driver: it knows where its own runtime library lies, which a bare ld does not."""
    for name in (os.environ.get("CXX", ""), "c++", "g++", "clang++"):
        command = shlex.split(name)
        if command and shutil.which(command[0]):
            return command
    return None


def _run_linker(linker: list[str], archives: list[Path], output: Path) -> None:
    exports = output.with_suffix(".map")
    # Only the C interface is shown: another LLVM in the same process then cannot be confused with this one.
    exports.write_text("{ global: LLVM*; local: *; };\n", encoding="ascii")
    command = [
        *linker,
        *("-shared", "-s", "-o", str(output)),
        # Dr.Jit asks for its functions by name at run time, so no object file asks for them: name them here.
        *(f"-Wl,-u,{symbol}" for symbol in _c_interface(archives)),
        f"-Wl,--version-script={exports}",
        "-Wl,--gc-sections",
        "-Wl,-z,defs",  # what is missing shall show now, not when the library is loaded
        "-Wl,-z,nodelete",  # Dr.Jit closes its LLVM at exit, while LLVM's own destructors are still to run
        *("-Wl,--start-group", *map(str, archives), "-Wl,--end-group"),
        *("-lpthread", "-ldl", "-lm"),
    ]
    try:
        done = subprocess.run(command, capture_output=True, text=True, errors="replace", timeout=LINK_LIMIT_S)
    except (OSError, subprocess.SubprocessError) as error:
        raise _CannotBuild(f"{linker[0]} did not link {WHEEL}: {type(error).__name__}") from error
    if done.returncode != 0:
        raise _CannotBuild(f"{linker[0]} did not link {WHEEL}: {_reason(done.returncode, done.stderr)}")


def _c_interface(archives: list[Path]) -> list[str]:
    """LLVM's whole C interface, of which Dr.Jit resolves about sixty functions, other ones with each release.

    All of it makes the library 4 % larger than the sixty do. Only the initialisers of other machines' targets
    stay out: where the wheel's extra targets are installed each would draw in a whole code generator.
    """
    target = {"x86_64": "X86", "aarch64": "AArch64", "arm64": "AArch64"}.get(platform.machine(), "")
    foreign = re.compile(rf"LLVMInitialize(?!{target}(?:Target|Asm|Disassembler))")
    symbols = {name for archive in archives for name in _symbols(archive)}
    return sorted(name for name in symbols if re.match("LLVM[A-Z]", name) and not foreign.match(name))


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
    (count,) = struct.unpack_from(">I", index)
    return [name.decode("ascii", "replace") for name in index[4 + 4 * count :].split(b"\0")[:count]]


# ------------------------------------------------------------------------------------------------- the doctor


def doctor() -> list[Check]:
    """What a run would use here, and what mends what is missing. Never raises."""
    checks = [*_check_backend(), _check_libatomic(), Check("python", platform.python_version(), True)]
    checks += [_check_package(name) for name in PACKAGES]
    return [*checks, _check_cache(), Check("cores", str(len(cores())), True)]


def doctor_lines() -> list[str]:
    """`doctor` as plain lines of text."""
    checks = doctor()
    width = max(len(check.item) for check in checks)
    return [f"{'ok' if check.ok else 'MISSING':<7}  {check.item:<{width}}  {check.value}" for check in checks]


def _check_backend() -> list[Check]:
    try:
        backend = prepare()
    except Exception as error:  # a doctor who falls ill helps nobody
        return [Check("backend", _one_line(error), False)]
    version = f"LLVM {backend.llvm_version}" if backend.kind == "llvm" else "CUDA"
    return [
        Check("backend", f"{backend.kind} ({backend.variant})", True),
        Check("library", f"{version}, {backend.library}", True),
        Check("found by", backend.source, True),
        *(Check("passed over", note, True) for note in backend.notes),
    ]


def _check_libatomic() -> Check:
    try:
        if sys.platform == "linux":
            ctypes.CDLL("libatomic.so.1")
    except OSError:
        return Check("libatomic.so.1", f"not found: {REMEDY_ATOMIC}", False)
    return Check("libatomic.so.1", "found" if sys.platform == "linux" else "not needed here", True)


def _check_package(name: str) -> Check:
    version = _version(name)
    return Check(name, version or f"not installed: run `pip install {name}`", version is not None)


def _check_cache() -> Check:
    try:
        return Check("cache", str(cache_folder()), True)
    except OSError as error:
        return Check("cache", f"{_one_line(error)}: set XDG_CACHE_HOME to a folder that can be written", False)


def _one_line(error: Exception) -> str:
    return " ".join(str(error).split()) or type(error).__name__


def _version(package: str) -> str | None:
    """The version of an installed package, without importing it."""
    try:
        return metadata.version(package)
    except Exception:  # not installed, or its metadata damaged: the same for us
        return None
