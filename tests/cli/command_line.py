"""Calls of `seamap-rt` in this process and in one of its own, for the tests of the command line."""

from __future__ import annotations

import json
import os
import signal
import subprocess
import sys
from collections.abc import Iterator
from pathlib import Path
from typing import Any, NamedTuple

import pytest

from seamap_rt.cli import main

SMALL = {
    "radar.sector_deg": "[260,275]",
    "radar.range_m": "[15,60]",
    "sea.extent_m": "180",
    "tracing.tracer": "horizon",
}
PRODUCTS = ("scene.toml", "run.zarr", "maps.nc", "truth.nc", "metrics.json", "report.html")
DROWNED = {"sea.waves.0.height_m": 5.0, "sea.waves.0.wavelength_m": 40.0, "radar.height_m": 2.4}


def settings(**changed: Any) -> list[str]:
    """The options that make `tiny` smaller still."""
    pairs = SMALL | {key.replace("__", "."): value for key, value in changed.items()}
    return [part for key, value in pairs.items() for part in ("--set", f"{key}={value}")]


class Answer(NamedTuple):
    code: int
    out: str
    err: str


@pytest.fixture
def elsewhere(tmp_path: Path, monkeypatch: pytest.MonkeyPatch, drawn_here: None) -> Iterator[None]:
    """Work in an empty folder, draw coarsely, and give SIGTERM back as it was."""
    monkeypatch.chdir(tmp_path)
    monkeypatch.setattr("seamap_rt.report.style.DPI", 40)  # nothing of the command line looks at pixels
    before = signal.getsignal(signal.SIGTERM)
    yield
    signal.signal(signal.SIGTERM, before)


@pytest.fixture
def call(capsys: pytest.CaptureFixture[str]) -> Any:
    """`seamap-rt` in this process."""

    def run(*arguments: Any) -> Answer:
        with pytest.raises(SystemExit) as end:
            main([str(argument) for argument in arguments])
        said = capsys.readouterr()
        code = end.value.code
        assert isinstance(code, int)
        return Answer(code, said.out, said.err)

    return run


def start(*arguments: Any, **environment: str) -> subprocess.Popen[str]:
    """`seamap-rt` in a process of its own, which minds Ctrl-C even where the tests run in the background."""
    program = (
        "import signal; signal.signal(signal.SIGINT, signal.default_int_handler); "
        "from seamap_rt.cli import main; main()"
    )
    return subprocess.Popen(
        [sys.executable, "-W", "error", "-c", program, *map(str, arguments)],
        stdout=subprocess.PIPE,
        stderr=subprocess.PIPE,
        text=True,
        env=os.environ | environment,
    )


def ended(process: subprocess.Popen[str]) -> Answer:
    out, err = process.communicate(timeout=600)
    return Answer(process.returncode, out, err)


def assert_refused(answer: Answer, *words: str, code: int = 2) -> None:
    """One line on stderr that holds the words, nothing on stdout, no traceback."""
    assert answer.code == code, answer.err
    assert answer.out == ""
    assert answer.err.count("\n") == 1, answer.err
    assert answer.err.startswith("seamap-rt: ")
    for word in words:
        assert word in answer.err
    for word in ("Traceback", "None", "\x1b"):
        assert word not in answer.err


def strict_json(path: Path) -> dict[str, Any]:
    def refuse(constant: str) -> None:
        raise ValueError(f"{constant} is not JSON")

    return json.loads(path.read_text(encoding="utf-8"), parse_constant=refuse)
