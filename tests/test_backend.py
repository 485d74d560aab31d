"""The choice of Dr.Jit's backend: what works is found, what would abort is kept out, what lacks is named."""

from __future__ import annotations

import json
import os
import platform
import subprocess
import sys
import tempfile
import time
from collections.abc import Callable
from importlib import metadata
from pathlib import Path
from typing import Any

import pytest

from seamap_rt.compute import backend, libraries
from seamap_rt.compute.backend import Backend, Check
from seamap_rt.compute.libraries import OLDEST_LLVM, VARIABLE, Candidate, Verdict
from seamap_rt.errors import NoBackendError

ROOT = Path(__file__).parents[1]
prepare = backend.prepare.__wrapped__  # without the memory of this process

START = """
import dataclasses, json, os, sys
from pathlib import Path
from seamap_rt.compute import backend, libraries


def forbidden(*_):
    raise AssertionError("a warm start neither probes nor links")

if "warm" in sys.argv:
    libraries.try_library = libraries.link_wheel = forbidden
cache = Path(os.environ["XDG_CACHE_HOME"])
untouched = "warm" in sys.argv or not any(cache.iterdir())
chosen = backend.prepare()
again = backend.prepare() is chosen
early = [name for name in ("drjit", "mitsuba", "sionna") if name in sys.modules]
import drjit as dr
import mitsuba as mi
mi.set_variant(chosen.variant)
result = list(dr.maximum(dr.arange(mi.Float, 4) - 2, 0) + dr.clip(dr.arange(mi.Float, 4), 1, 2))
print(json.dumps(dataclasses.asdict(chosen) | dict(
    untouched=untouched, again=again, early=early, result=result, told=os.environ.get(backend.VARIABLE)
), default=str))
"""


def start(cache: Path, *arguments: str) -> dict[str, Any]:
    """A fresh process that chooses a backend and computes with it."""
    environment = {key: value for key, value in os.environ.items() if key != VARIABLE}
    environment |= {"XDG_CACHE_HOME": str(cache), "DRJIT_CACHE_DIR": str(cache / "kernels")}
    done = subprocess.run(
        [sys.executable, "-c", START, *arguments],
        cwd=ROOT,
        env=environment,
        capture_output=True,
        text=True,
    )
    assert done.returncode == 0, done.stderr
    return json.loads(done.stdout.splitlines()[-1])


@pytest.fixture(scope="module")
def cache(tmp_path_factory: pytest.TempPathFactory) -> Path:
    return tmp_path_factory.mktemp("cache")


@pytest.fixture(scope="module")
def cold(cache: Path) -> dict[str, Any]:
    return start(cache)


@pytest.fixture
def alone(monkeypatch: pytest.MonkeyPatch, tmp_path: Path) -> Path:
    """A process that has imported no Dr.Jit, on a machine without CUDA or LLVM, with an empty cache."""
    monkeypatch.setenv("XDG_CACHE_HOME", str(tmp_path / "cache"))
    monkeypatch.setenv(VARIABLE, "")  # not delenv: prepare() sets it, and monkeypatch shall take that back
    monkeypatch.delitem(sys.modules, "drjit", raising=False)
    monkeypatch.setattr(backend, "find", lambda name: [])
    return tmp_path


def stand_in(works: Callable[[Path], bool]) -> tuple[list[Path], Callable[[Candidate], Verdict]]:
    """A stand-in for the probe, and the list of what it was asked to try."""
    tried: list[Path] = []

    def try_library(candidate: Candidate) -> Verdict:
        tried.append(candidate.library)
        return Verdict(True, "19.1.7") if works(candidate.library) else Verdict(False, "no good")

    return tried, try_library


def library(path: Path, content: str = "good") -> Path:
    path.parent.mkdir(parents=True, exist_ok=True)
    path.write_text(content)
    return path


def wheel(folder: Path, *archives: str) -> Path:
    """Where Python finds a wheel mlc-llvm-static with these archives before any that is installed."""
    library(folder / "wheel" / "mlc_llvm_static" / "__init__.py", "")
    for name in archives:
        library(folder / "wheel" / "mlc_llvm_static" / "static" / "lib" / name)
    return folder / "wheel"


# ---------------------------------------------------------------------------------------- on the real machine


def test_a_first_start_finds_or_builds_a_backend_that_computes(cold: dict[str, Any]) -> None:
    assert cold["result"] == [1, 1, 2, 3]
    assert cold["variant"] == f"{cold['kind']}_ad_mono_polarized"
    assert cold["early"] == []  # choosing imports nothing of Dr.Jit
    assert cold["untouched"]  # and importing the module does nothing at all
    assert cold["again"]
    if cold["kind"] == "llvm":
        assert cold["told"] == cold["library"]
        assert int(cold["llvm_version"].split(".")[0]) >= OLDEST_LLVM


def test_a_second_start_neither_probes_nor_links(cache: Path, cold: dict[str, Any]) -> None:
    warm = start(cache, "warm")
    assert warm["result"] == cold["result"]
    assert warm["library"] == cold["library"]
    assert warm["llvm_version"] == cold["llvm_version"]
    if cold["source"].startswith("built"):
        assert warm["source"] == "cached build"


def test_a_named_library_that_would_abort_is_refused(alone: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    old = Path("/usr/lib", f"{platform.machine()}-linux-gnu", "libLLVM-15.so.1")
    named = old if old.exists() else library(alone / "libLLVM-15.so.1", "not a library")
    monkeypatch.setenv(VARIABLE, str(named))
    with pytest.raises(NoBackendError) as refusal:
        prepare()
    message = str(refusal.value)
    assert "\n" not in message
    assert f"{VARIABLE} {named}" in message
    assert f"unset {VARIABLE}" in message
    if named is old:
        assert "too old" in message
    assert os.environ[VARIABLE] == str(named)  # the user's words stay as they were


def test_the_wheel_offers_what_dr_jit_asks_for() -> None:
    archives = libraries.archives_of_wheel()
    if not archives:
        pytest.skip("the wheel mlc-llvm-static is not installed")
    symbols = set(libraries.c_interface(archives))
    target = "AArch64" if platform.machine() in ("aarch64", "arm64") else "X86"
    needed = {"Target", "TargetInfo", "TargetMC", "AsmPrinter", "Disassembler"}
    assert {f"LLVMInitialize{target}{part}" for part in needed} <= symbols
    assert {"LLVMGetVersion", "LLVMLinkInMCJIT", "LLVMOrcCreateLLJIT", "LLVMRunPasses"} <= symbols


# ----------------------------------------------------------------------------------------- nothing that works


@pytest.mark.parametrize("missing", ["wheel", "linker"])
def test_nothing_usable_is_one_line_with_the_remedies(
    alone: Path, monkeypatch: pytest.MonkeyPatch, missing: str
) -> None:
    if missing == "wheel":
        monkeypatch.syspath_prepend(wheel(alone))
    else:
        monkeypatch.setattr(libraries, "package_version", lambda package: "23.1.1")
        monkeypatch.syspath_prepend(wheel(alone, "libLLVMCore.a"))
        monkeypatch.delenv("CXX", raising=False)
        monkeypatch.setenv("PATH", str(alone))
    with pytest.raises(NoBackendError) as refusal:
        prepare()
    message = str(refusal.value)
    assert "\n" not in message
    assert ("mlc-llvm-static is not installed" if missing == "wheel" else "no g++") in message
    for remedy in (
        "apt-get install libllvm19 libatomic1",
        "pip install 'seamap_rt[llvm]'",
        "conda-forge llvm",
    ):
        assert remedy in message


def test_a_linker_that_fails_leaves_nothing_behind(alone: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(libraries, "package_version", lambda package: "23.1.1")
    monkeypatch.syspath_prepend(wheel(alone, "libLLVMCore.a"))
    complaint = library(alone / "linker.py", "raise SystemExit('disk full')")
    monkeypatch.setenv("CXX", f"{sys.executable} {complaint}")
    with pytest.raises(NoBackendError, match="did not link mlc-llvm-static: disk full"):
        prepare()
    assert list(libraries.cache_folder().iterdir()) == []


def test_too_late_after_an_import_of_dr_jit(alone: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setitem(sys.modules, "drjit", sys)
    monkeypatch.setattr(backend, "loaded_llvm", list)
    with pytest.raises(NoBackendError, match="imported before an LLVM was chosen"):
        prepare()


def test_a_missing_libatomic_is_named() -> None:
    stderr = (
        "ImportError: libatomic.so.1: cannot open shared object file: No such file or directory\n\n"
        "During handling of the above exception, another exception occurred:\n\n"
        "NameError: name '_drjit_ext' is not defined\n"
    )
    reason = libraries.reason(subprocess.CompletedProcess([], 1, "", stderr))
    assert "libatomic.so.1 is missing" in reason
    assert backend._explain([reason]).endswith("run `apt-get install libatomic1`")


# ----------------------------------------------------------------------------------------- what is remembered


def test_a_verdict_is_bound_to_the_file(alone: Path) -> None:
    candidate = Candidate("llvm", library(alone / "libLLVM.so"), "system")
    first = libraries.verdict_file(candidate)
    assert first == libraries.verdict_file(candidate)
    library(candidate.library, "another")
    second = libraries.verdict_file(candidate)
    os.utime(candidate.library, ns=(0, 0))
    third = libraries.verdict_file(candidate)
    assert len({first, second, third}) == 3
    assert libraries.verdict_file(Candidate("llvm", Path("libLLVM.so"), VARIABLE)) is None


def test_a_failure_is_remembered_for_a_while(alone: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    bad, good = library(alone / "libLLVM-20.so", "bad"), library(alone / "libLLVM-19.so")
    tried, try_library = stand_in(lambda path: path == good)
    monkeypatch.setattr(libraries, "try_library", try_library)
    monkeypatch.setattr(backend, "system_llvm", lambda: [bad, good])
    for _ in range(2):
        chosen = prepare()
        assert chosen == Backend(
            "llvm",
            good,
            "19.1.7",
            "system",
            "llvm_ad_mono_polarized",
            (f"system {bad}: no good",),
        )
        assert os.environ[VARIABLE] == str(good)
        monkeypatch.setenv(VARIABLE, "")
    assert tried == [bad, good]
    long_ago = time.time() - 2 * libraries.FAILURE_LIFETIME_S
    for file in libraries.cache_folder().glob("verdict-*.json"):
        os.utime(file, (long_ago, long_ago))
    prepare()
    assert tried == [bad, good, bad]


def test_a_failure_is_not_remembered_where_nothing_works(alone: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    tried, try_library = stand_in(lambda path: False)
    bad = library(alone / "libLLVM-20.so")
    monkeypatch.setattr(libraries, "try_library", try_library)
    monkeypatch.setattr(backend, "system_llvm", lambda: [bad])
    monkeypatch.syspath_prepend(wheel(alone))
    for _ in range(2):
        with pytest.raises(NoBackendError, match="no good"):
            prepare()
    assert tried == [bad, bad]


def test_a_damaged_build_is_linked_anew(alone: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(libraries, "package_version", lambda package: "23.1.1")
    built = library(libraries.cache_folder() / libraries.build_name("23.1.1"), "torn")
    tried, try_library = stand_in(lambda path: path.read_text() == "good")
    monkeypatch.setattr(libraries, "try_library", try_library)
    monkeypatch.setattr(libraries, "link_wheel", lambda folder, wheel: library(built))
    assert prepare().source == "built from mlc-llvm-static"
    monkeypatch.setenv(VARIABLE, "")
    assert prepare().source == "cached build"
    assert tried == [built, built]


def test_an_unwritable_cache_gives_way_to_a_private_temporary_one(alone: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setenv("XDG_CACHE_HOME", str(library(alone / "file")))
    monkeypatch.setattr(tempfile, "tempdir", str(alone))
    folder = libraries.cache_folder()
    assert folder.parent == alone
    assert folder.stat().st_mode & 0o777 == 0o700
    folder.chmod(0o777)
    with pytest.raises(PermissionError, match="someone else"):
        libraries.cache_folder()


# ------------------------------------------------------------------------------------------------- the search


@pytest.mark.parametrize(
    ("name", "version"),
    [
        ("libLLVM-15.so.1", (15,)),
        ("libLLVM-14.0.6.so.1", (14, 0, 6)),
        ("libLLVM.so.19.1", (19, 1)),
        ("libLLVM-23.1.1.post0-x86_64.so", (23, 1, 1)),
        ("libLLVM.so", ()),
    ],
)
def test_versions_are_read_from_names(name: str, version: tuple[int, ...]) -> None:
    assert backend.version_in_name(Path(name)) == version


def test_system_libraries_come_newest_first_and_old_ones_not_at_all(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    names = ["libLLVM-15.so.1", "libLLVM-18.so.1", "libLLVM.so.9.0", "libLLVM.so.20.1", "libLLVMCore.so.20"]
    for name in names:
        library(tmp_path / name)
    (tmp_path / "libLLVM-18.so").symlink_to("libLLVM-18.so.1")
    unknown = library(tmp_path / "other" / "libLLVM.so")
    folders = [unknown.parent, tmp_path, tmp_path / "absent"]
    monkeypatch.setattr(backend, "library_folders", lambda: folders)
    found = backend.system_llvm()
    assert found == [tmp_path / "libLLVM.so.20.1", tmp_path / "libLLVM-18.so.1", unknown]


# ------------------------------------------------------------------------------------------------- the doctor


def test_the_doctor_reports_what_it_finds(alone: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    found = Backend("llvm", Path("/lib/libLLVM.so.19.1"), "19.1.7", "system", "llvm_ad_mono_polarized", ("x: y",))
    monkeypatch.setattr(backend, "prepare", lambda: found)
    checks = {check.item: check for check in backend.checks()}
    assert checks["library"] == Check("library", "LLVM 19.1.7, /lib/libLLVM.so.19.1", True)
    assert checks["passed over"].value == "x: y"
    assert checks["drjit"].ok
    assert int(checks["cores"].value) >= 1
    lines = backend.doctor_lines(backend.checks())
    assert len(lines) == len(checks)
    assert next(line for line in lines if "x: y" in line).startswith("info  ")  # what is no fault is no "ok" either
    assert {line.split()[0] for line in lines} == {"ok", "info"}


def test_the_doctor_never_raises(alone: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    def fail(*_: object) -> None:
        raise OSError("two\nlines")

    monkeypatch.setattr(backend, "prepare", fail)
    monkeypatch.setattr(libraries, "cache_folder", fail)
    monkeypatch.setattr(metadata, "version", fail)
    lines = backend.doctor_lines(backend.checks())
    assert not any("\n" in line for line in lines)
    assert lines[0] == f"MISSING  {'backend':<14}  two lines"
    assert any("pip install sionna-rt" in line for line in lines)
