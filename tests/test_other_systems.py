"""What is done otherwise on macOS, and refused on Windows: the system is a stand-in."""

from __future__ import annotations

import os
import signal
import sys
from collections.abc import Iterator
from pathlib import Path
from typing import Any, cast

import pytest

from seamap_rt.cli import main
from seamap_rt.compute import backend
from seamap_rt.studies import cluster


def test_windows_is_refused_in_one_line(monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]) -> None:
    monkeypatch.setattr(sys, "platform", "win32")
    with pytest.raises(SystemExit) as ended:
        main(["--help"])
    monkeypatch.undo()
    said = capsys.readouterr()
    assert ended.value.code == 3
    assert said.out == ""
    assert said.err.count("\n") == 1
    assert "WSL" in said.err


def test_worker_without_affinity_runs_on_any_core(monkeypatch: pytest.MonkeyPatch) -> None:
    """macOS has no such call; the worker ignores Ctrl-C all the same."""
    ignored: list[Any] = []
    monkeypatch.delattr(os, "sched_setaffinity", raising=False)
    monkeypatch.setattr(signal, "signal", lambda *given: ignored.append(given))
    cluster.CoreAffinity({0: [0]}).setup(cast(Any, type("Worker", (), {"name": "0"})()))
    assert ignored == [(signal.SIGINT, signal.SIG_IGN)]


@pytest.mark.parametrize("keg", ["/opt/homebrew/opt/llvm@19/lib", "/usr/local/opt/llvm/lib"])
def test_homebrews_llvm_is_found_on_either_processor(keg: str, monkeypatch: pytest.MonkeyPatch) -> None:
    """Homebrew links no LLVM into a folder of the loader; its own differs between Apple's and Intel's processors."""

    def glob(root: Path, pattern: str) -> Iterator[Path]:
        return iter([Path(keg)] if Path(keg).is_relative_to(root) and Path(keg).match(pattern) else [])

    monkeypatch.setattr(Path, "glob", glob)
    assert Path(keg) in backend.library_folders()


@pytest.mark.parametrize(("system", "tool"), [("darwin", "brew install llvm"), ("linux", "apt-get install libllvm19")])
def test_remedy_is_the_systems_own(system: str, tool: str, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(sys, "platform", system)
    monkeypatch.delenv(backend.VARIABLE, raising=False)
    said = backend._explain(["no libLLVM"])
    monkeypatch.undo()
    assert tool in said
