"""What the command line leaves when it is stopped, when the disk is full, and where there is no backend."""

from __future__ import annotations

import json
import os
import shutil
import signal
import subprocess
import sys
import time
from pathlib import Path
from typing import Any

import command_line
import numpy as np
import pytest
import xarray as xr
from command_line import Answer, assert_refused, ended, settings, start
from numpy.testing import assert_array_equal

from seamap_rt.cli.stops import Stops
from seamap_rt.interferometry import open_echoes, retrieve
from seamap_rt.io.results_folder import lock_folder, note_growing
from seamap_rt.simulation import Simulator

call, elsewhere = command_line.call, command_line.elsewhere  # fixtures
pytestmark = pytest.mark.usefixtures("elsewhere")


# ------------------------------------------------------------------------------------------------ no backend


def test_no_backend_is_one_line_and_exit_3_for_rays_only() -> None:
    nowhere = {"DRJIT_LIBLLVM_PATH": "/nonexistent/libLLVM.so", "CUDA_VISIBLE_DEVICES": ""}
    rays = start("run", "tiny", *settings(tracing__tracer="facets"), "--out", "rays", **nowhere)
    horizon = start("simulate", "tiny", *settings(), "--out", "horizon", **nowhere)
    told = start("doctor", **nowhere)
    answer = ended(rays)
    if answer.code == 0:
        pytest.skip("a CUDA device serves, whatever the variable says")
    assert_refused(answer, "no usable", "/nonexistent/libLLVM.so", "DRJIT_LIBLLVM_PATH", code=3)
    assert not list(Path("rays").iterdir())  # refused before anything was made, or an earlier run's results removed
    answer = ended(horizon)
    assert answer.code == 0, answer.err
    assert sorted(path.name for path in Path("horizon").iterdir()) == ["run.zarr", "truth.nc"]
    answer = ended(told)
    assert answer.code == 3
    assert "MISSING" in answer.out
    assert "Traceback" not in answer.err


# ----------------------------------------------------------------------------------------------- interrupted


def complete_turns(store: Path) -> int:
    try:
        return int(json.loads((store / "zarr.json").read_text())["attributes"]["complete_turns"])
    except (OSError, ValueError, KeyError):
        return 0


def stopped(process: subprocess.Popen[str], store: Path, number: signal.Signals, after: int, times: int = 1) -> Answer:
    """Send a signal, so many times, once so many turns are complete, and wait for the end."""
    try:
        limit = time.monotonic() + 600.0
        while complete_turns(store) < after:
            assert process.poll() is None, process.communicate()
            assert time.monotonic() < limit
            time.sleep(0.01)
        for again in range(times):
            process.send_signal((number, signal.SIGINT)[again % 2])
            time.sleep(0.002)
        return ended(process)
    finally:
        process.kill()


def test_interrupted_run_leaves_whole_turns(call: Any) -> None:
    """By Ctrl-C; by SIGTERM, and both in turn, a simulation below."""
    process = start("run", "tiny", *settings(), "--turns", 5000, "--out", "cut")
    answer = stopped(process, Path("cut/run.zarr"), signal.SIGINT, after=2)
    assert_refused(answer, "interrupted", "turns are complete", "missing", code=130)

    echoes = open_echoes("cut")
    turns = echoes.attrs["complete_turns"]
    assert 2 <= turns < 5000
    assert_array_equal(np.unique(echoes["turn"].values), np.arange(turns))
    voltage = echoes["voltage"].values
    assert np.isfinite(voltage).all()
    assert (np.abs(voltage).max(axis=(1, 2)) > 0.0).all()  # noise on every pulse: none is a fill value
    counts = np.bincount(echoes["turn"].values)
    assert np.ptp(counts) <= 1  # 15° hold 416⅔ pulses
    for product in ("maps", "truth"):
        with xr.open_datatree(f"cut/{product}.nc") as tree:
            for group in ("polar", "ground"):
                assert_array_equal(tree[group]["turn"].values, np.arange(turns))
    assert not Path("cut/metrics.json").exists()
    assert not Path("cut/report.html").exists()
    assert {path.name for path in Path("cut").iterdir()} == {"run.zarr", "maps.nc", "scene.toml", "truth.nc"}

    # What is left can be retrieved anew, to the same bits.
    assert call("retrieve", "cut", "--out", "anew").code == 0
    with xr.open_datatree("cut/maps.nc") as before, xr.open_datatree("anew/maps.nc") as anew:
        for group in ("polar", "ground"):
            xr.testing.assert_identical(before[group].to_dataset(), anew[group].to_dataset())


def test_interrupted_simulation_leaves_whole_turns() -> None:
    process = start("simulate", "tiny", *settings(turns=5000), "--out", "cut")
    # Whoever ends processes may ask more than once, and so may Ctrl-C: what closes the files is not cut off.
    answer = stopped(process, Path("cut/run.zarr"), signal.SIGTERM, after=1, times=20)
    assert_refused(answer, "interrupted", code=130)
    echoes = open_echoes("cut")
    turns = echoes.attrs["complete_turns"]
    with xr.open_datatree("cut/truth.nc") as truth:
        assert truth["polar"].sizes["turn"] == turns
    maps = retrieve(echoes)
    assert maps["polar"].sizes["turn"] == turns


def test_run_that_is_stopped_before_its_first_turn_leaves_no_half_file(call: Any, monkeypatch: Any) -> None:
    """Ctrl-C while the first turn is simulated: a line, exit 130, and a store that says that it holds nothing."""

    def stop(*_: Any) -> None:
        raise KeyboardInterrupt

    monkeypatch.setattr("seamap_rt.simulation.Simulator.turn", stop)
    assert_refused(call("run", "tiny", *settings(), "--out", "cut"), "interrupted", code=130)
    assert {path.name for path in Path("cut").iterdir()} <= {"scene.toml"}


def test_an_interruption_that_compiled_code_hides_is_one_all_the_same(call: Any, monkeypatch: Any) -> None:
    """Ctrl-C inside a compiled function comes out as Python's SystemError: the line says what is left nevertheless."""
    turn = Simulator.turn

    def stop(simulator: Simulator, number: int, *more: Any) -> Any:
        if number == 0:
            return turn(simulator, number, *more)
        try:
            raise KeyboardInterrupt
        except KeyboardInterrupt as hidden:
            raise SystemError("returned a result with an exception set") from hidden

    monkeypatch.setattr("seamap_rt.simulation.Simulator.turn", stop)
    answer = call("run", "tiny", *settings(), "--turns", "3", "--out", "hidden")
    assert_refused(answer, "interrupted: 1 of 3 turns are complete, and stay readable", code=130)


STARTING = """
import signal, sys
signal.signal(signal.SIGINT, signal.default_int_handler)
import time
from seamap_rt.cli import main

class Loading:  # the first module that the command loads takes a minute
    def find_spec(self, name, *_):
        if name == "seamap_rt.cli.application":
            print("begins", flush=True)
            time.sleep(60.0)

sys.meta_path.insert(0, Loading())
main()
"""


@pytest.mark.parametrize("number", [signal.SIGINT, signal.SIGTERM])
def test_a_signal_while_modules_are_loaded_is_a_line(number: signal.Signals) -> None:
    with subprocess.Popen(
        [sys.executable, "-c", STARTING, "doctor"], stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True
    ) as process:
        assert process.stdout is not None
        assert process.stdout.readline() == "begins\n"
        process.send_signal(number)
        assert_refused(ended(process), "interrupted: nothing was begun", code=130)


MEETS_A_THREAD = """
import os, signal, threading, time
signal.signal(signal.SIGINT, signal.default_int_handler)
start, met = threading.Thread.start, []

def interrupted(thread):
    start(thread)
    if thread.name.startswith("rows") and not met:
        met.append(thread)
        os.kill(os.getpid(), signal.SIGINT)
        time.sleep(1.0)

threading.Thread.start = interrupted
from seamap_rt.cli import main
main()
"""


def test_an_interruption_that_meets_a_thread_as_it_starts_ends_the_process() -> None:
    """Its executor does not know it then: Python would wait for ever for a thread that nobody tells to end."""
    words = [*map(str, settings()), "--out", "met"]
    with subprocess.Popen(
        [sys.executable, "-c", MEETS_A_THREAD, "simulate", "tiny", *words],
        stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True,
    ) as process:  # fmt: skip
        try:
            out, err = process.communicate(timeout=60.0)
        finally:
            process.kill()
    assert_refused(Answer(process.returncode, out, err), "interrupted: ", code=130)


def test_the_first_signal_interrupts_and_others_wait_for_the_end() -> None:
    before = {number: signal.getsignal(number) for number in (signal.SIGINT, signal.SIGTERM)}
    stops = Stops()
    stops.begin()
    try:
        stops.run()
        assert not stops.requested
        with pytest.raises(KeyboardInterrupt):
            signal.raise_signal(signal.SIGTERM)
        for number in before:
            signal.raise_signal(number)
        assert stops.requested
    finally:
        stops.end(process=False)
    assert {number: signal.getsignal(number) for number in before} == before


def test_two_signals_at_one_moment_are_one_interruption(capsys: Any) -> None:
    """Both are pending when Python looks: the handler of the first must not make the second a complaint."""
    both = {signal.SIGINT, signal.SIGTERM}
    stops = Stops()
    stops.begin()
    try:
        stops.run()
        with pytest.raises(KeyboardInterrupt):
            _both_at_once(both)
        time.sleep(0.01)
    finally:
        stops.end(process=False)
    assert capsys.readouterr().err == ""


def _both_at_once(both: set[signal.Signals]) -> None:
    signal.pthread_sigmask(signal.SIG_BLOCK, both)
    for number in both:
        signal.raise_signal(number)
    signal.pthread_sigmask(signal.SIG_UNBLOCK, both)
    time.sleep(0.01)


def test_an_interruption_that_meets_a_destructor_comes_again() -> None:
    class Destroyed:
        def __del__(self) -> None:
            signal.raise_signal(signal.SIGTERM)

    stops = Stops()
    stops.begin()
    try:
        stops.run()
        with pytest.raises(KeyboardInterrupt):
            _lose(Destroyed)
    finally:
        stops.end(process=False)


@pytest.mark.parametrize("interrupted", [False, True])
def test_of_an_interrupted_process_that_ends_libraries_tell_nothing(
    interrupted: bool, monkeypatch: pytest.MonkeyPatch
) -> None:
    class Destroyed:
        def __del__(self) -> None:
            raise RuntimeError("Event loop is closed")

    told: list[object] = []
    monkeypatch.setattr(sys, "unraisablehook", told.append)
    before = {number: signal.getsignal(number) for number in (signal.SIGINT, signal.SIGTERM)}
    stops = Stops()
    stops.begin()
    try:
        stops.run()
        if interrupted:
            with pytest.raises(KeyboardInterrupt):
                signal.raise_signal(signal.SIGTERM)
        stops.end(process=True)
        Destroyed()
    finally:
        for number, handler in before.items():
            signal.signal(number, handler)
    assert bool(told) != interrupted


def _lose(destroyed: type) -> None:
    """Python cannot raise what a destructor raises."""
    destroyed()
    time.sleep(2.0)


OTHERS = [
    ("run", "tiny"),
    ("simulate", "tiny"),
    ("sea", "tiny"),
    ("link", "tiny"),
    ("shadowing", "tiny"),
    ("trade", "tiny", "--vary", "radar.height_m=5,6", "--workers", "0"),
    ("retrieve", "some.zarr"),
]


@pytest.mark.parametrize("command", OTHERS, ids=[command[0] for command in OTHERS])
def test_a_folder_into_which_another_process_writes_is_refused(call: Any, command: tuple[str, ...]) -> None:
    Path("some.zarr").mkdir()
    Path("busy").mkdir()
    options = () if command[0] == "retrieve" else settings()
    with lock_folder(Path("busy"), "--out"):
        answer = call(*command, *options, "--out", "busy", "--overwrite")
        assert_refused(
            answer, "--out = '", f"process {os.getpid()} on ", "writes there; choose another folder, or wait"
        )
        assert_refused(call("recover", "busy"), "DIR = 'busy'", f"process {os.getpid()} on ")
    assert not list(Path("busy").iterdir())


def test_recover_says_what_it_found(call: Any) -> None:
    assert_refused(call("recover", "nowhere"), "DIR = 'nowhere'", "no such folder")
    Path("empty").mkdir()
    answer = call("recover", "empty")
    assert (answer.code, answer.err) == (0, "")
    assert "nothing to recover" in answer.out
    with note_growing(Path("empty"), ("truth.nc", "maps.nc", "run.zarr")):
        shutil.copytree("empty", "killed")
    Path("killed/scene.toml").touch()
    Path("killed/run.zarr").mkdir()
    assert_refused(call("retrieve", "killed/run.zarr", "--out", "maps"), "ECHOES = ", "seamap-rt recover 'killed'")
    answer = call("recover", "killed")
    assert (answer.code, answer.err) == (0, "")
    assert "no whole one of the turns was left" in answer.out
    assert not list(Path("killed").iterdir())


@pytest.mark.parametrize(
    "error",
    [
        OSError(28, "No space left on device", "results/truth.nc"),
        OSError("results/truth.nc: write failed\n(No space left on device)"),  # as HDF5 raises it
    ],
)
def test_full_disk_is_one_line(call: Any, monkeypatch: Any, error: OSError) -> None:
    def full(*_: Any) -> None:
        raise error

    monkeypatch.setattr("seamap_rt.io.growing_store.GrowingStore.append", full)
    answer = call("simulate", "tiny", *settings(), "--out", "results")
    assert_refused(answer, "results/truth.nc", "No space left on device", code=4)


def test_an_interruption_that_a_library_swallows_is_raised_again_and_what_closes_files_is_not_cut_off() -> None:
    program = """
import os, signal, time
from seamap_rt.cli.stops import Stops
stops = Stops()
stops.begin()
stops.run()
try:
    os.kill(os.getpid(), signal.SIGTERM)
    time.sleep(0.1)
except BaseException:
    pass
try:
    time.sleep(10.0)
    print("lost")
except KeyboardInterrupt:
    time.sleep(2.5)
    print("closed")
stops.end(process=True)
"""
    result = subprocess.run([sys.executable, "-c", program], capture_output=True, text=True, timeout=60, check=False)
    assert (result.returncode, result.stdout, result.stderr) == (0, "closed\n", "")
