"""A library built here: the wheel's static archives, linked once into the user's cache."""

from __future__ import annotations

import importlib.util
import logging
import os
import platform
import re
import shlex
import shutil
import subprocess
import sys
from collections.abc import Iterator
from pathlib import Path

from ..locks import scratch_folder
from . import trial
from .trial import Candidate

WHEEL = "mlc-llvm-static"
_LIMIT_S = 300.0
log = logging.getLogger(__name__)


class _CannotBuild(Exception):
    """Why no library can be linked from the wheel here."""


def own_llvm(notes: list[str]) -> Iterator[Candidate]:
    """The library linked earlier; if there is none, or it failed its test, a new one."""
    wheel = trial.package_version(WHEEL)
    try:
        folder = trial.cache_folder()
        builds = [path for path in folder.glob(build_name(wheel or "*")) if path.is_file()]
        if builds:  # where no wheel is installed any more, the newest that one has left
            yield Candidate("llvm", max(builds, key=_version), "cached build")
        yield Candidate("llvm", link_wheel(folder, wheel), f"built from {WHEEL}")
    except _CannotBuild as error:
        notes.append(str(error))
    except OSError as error:
        notes.append(f"no LLVM can be kept in a cache: {error}")


def build_name(wheel: str) -> str:
    return f"libLLVM-{wheel}-{platform.machine()}.so"


def _version(build: Path) -> list[int]:
    return [int(part) for part in re.findall(r"\d+", build.name)]


def link_wheel(folder: Path, wheel: str | None) -> Path:
    """Link the wheel's archives into one shared library, which appears in the folder whole or not at all."""
    if sys.platform != "linux":
        raise _CannotBuild(f"{WHEEL} is linked on Linux only")
    archives = archives_of_wheel()
    if wheel is None or not archives:
        raise _CannotBuild(f"the wheel {WHEEL} is not installed")
    # A C++ compiler driver knows where its own runtime library lies, which a bare ld does not.
    drivers = (shlex.split(name) for name in (os.environ.get("CXX", ""), "c++", "g++", "clang++"))
    linker = next((each for each in drivers if each and shutil.which(each[0])), None)
    if linker is None:
        raise _CannotBuild(f"no g++ to link {WHEEL} with")
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
        done = trial.run(command, _LIMIT_S)
    except (OSError, subprocess.SubprocessError) as error:
        raise _CannotBuild(f"{linker[0]} did not link {WHEEL}: {type(error).__name__}") from error
    if done.returncode != 0:
        raise _CannotBuild(f"{linker[0]} did not link {WHEEL}: {trial.reason(done)}")


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
