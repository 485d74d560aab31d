"""What the command line leaves when it is stopped, when the disk is full, and where there is no backend."""

from __future__ import annotations

import json
import signal
import subprocess
import time
from pathlib import Path
from typing import Any

import command_line
import numpy as np
import pytest
import xarray as xr
from command_line import PRODUCTS, Answer, assert_refused, ended, settings, start
from numpy.testing import assert_array_equal

from seamap_rt.interferometry import open_echoes, retrieve

call, elsewhere = command_line.call, command_line.elsewhere  # fixtures
pytestmark = pytest.mark.usefixtures("elsewhere")


# ------------------------------------------------------------------------------------------------ no backend


def test_no_backend_is_one_line_and_exit_3_for_rays_only() -> None:
    nowhere = {"DRJIT_LIBLLVM_PATH": "/nonexistent/libLLVM.so", "CUDA_VISIBLE_DEVICES": ""}
    arguments = ("run", "tiny", *settings(tracing__tracer="facets"), "--out")
    rays = start(*arguments, "rays", **nowhere)
    horizon = start(*arguments, "horizon", "--tracer", "horizon", **nowhere)
    told = start("doctor", **nowhere)
    answer = ended(rays)
    if answer.code == 0:
        pytest.skip("a CUDA device serves, whatever the variable says")
    assert_refused(answer, "no usable", "/nonexistent/libLLVM.so", "DRJIT_LIBLLVM_PATH", code=3)
    assert not list(Path("rays").iterdir())  # refused before anything was made, or an earlier run's results removed
    answer = ended(horizon)
    assert answer.code == 0, answer.err
    assert {path.name for path in Path("horizon").iterdir()} >= set(PRODUCTS)
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
        limit = time.monotonic() + 60.0
        while complete_turns(store) < after:
            assert process.poll() is None, process.communicate()
            assert time.monotonic() < limit
            time.sleep(0.01)
        for _ in range(times):
            process.send_signal(number)
            time.sleep(0.002)
        return ended(process)
    finally:
        process.kill()


@pytest.mark.parametrize("number", [signal.SIGINT, signal.SIGTERM])
def test_interrupted_run_leaves_whole_turns(call: Any, number: signal.Signals) -> None:
    process = start("run", "tiny", *settings(), "--turns", 5000, "--out", "cut")
    answer = stopped(process, Path("cut/echoes.zarr"), number, after=2)
    assert_refused(answer, "interrupted", "turns are complete", "missing", code=130)

    echoes = open_echoes("cut/echoes.zarr")
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
    assert {path.name for path in Path("cut").iterdir()} == {"echoes.zarr", "maps.nc", "scene.toml", "truth.nc"}

    # What is left can be retrieved anew, to the same bits.
    assert call("retrieve", "cut/echoes.zarr", "--out", "anew").code == 0
    with xr.open_datatree("cut/maps.nc") as before, xr.open_datatree("anew/maps.nc") as anew:
        for group in ("polar", "ground"):
            xr.testing.assert_identical(before[group].to_dataset(), anew[group].to_dataset())


def test_interrupted_simulation_leaves_whole_turns() -> None:
    process = start("simulate", "tiny", *settings(turns=5000), "--out", "cut")
    # Whoever ends processes may ask more than once: what closes the files is not cut off.
    answer = stopped(process, Path("cut/echoes.zarr"), signal.SIGTERM, after=1, times=20)
    assert_refused(answer, "interrupted", code=130)
    echoes = open_echoes("cut/echoes.zarr")
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
    assert {path.name for path in Path("cut").iterdir()} <= {"scene.toml", "echoes.zarr"}


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

    monkeypatch.setattr("seamap_rt.io.echo_store.EchoStore.append", full)
    answer = call("simulate", "tiny", *settings(), "--out", "results")
    assert_refused(answer, "results/truth.nc", "No space left on device")
