"""What befalls a sweep on a cluster: killed workers, Ctrl-C, lost schedulers. Nothing done is lost, no bit changes."""

from __future__ import annotations

import dataclasses
import multiprocessing
import os
import signal
import socket
import ssl
import subprocess
import sys
import tempfile
import threading
import time
from collections.abc import Iterator
from pathlib import Path
from typing import Any, cast
from urllib.parse import urlsplit

import pytest
import xarray as xr
from dask import config
from distributed import Client, Future

from seamap_rt.errors import InputError
from seamap_rt.scene import Scene, load_scene
from seamap_rt.studies.cluster import existing_client, local_client, shares
from seamap_rt.studies.point import Outcome, Task, compute, load_outcome
from seamap_rt.studies.sweep import trade, write_trade
from seamap_rt.studies.trade_table import COST

pytestmark = pytest.mark.slow

VARY: dict[str, list[Any]] = {"radar.height_m": [3.0, 5.0], "radar.baseline_m": [0.2, 30.0]}  # half of it is refused
SEEDS = 2
KEYS = {
    "radar.range_m": [15.0, 60.0],
    "radar.sector_deg": [262.0, 270.0],
    "sea.extent_m": 180.0,
    "tracing.tracer": "horizon",
}


def small() -> Scene:
    return load_scene("tiny", overrides=KEYS)


def results(folder: Path) -> dict[str, Outcome]:
    """What the points' files say, but for the cost."""
    found = {path.name: load_outcome(path) for path in sorted((folder / "points").glob("*.json"))}
    return {name: {key: value for key, value in (each or {}).items() if key != "cost"} for name, each in found.items()}


def same(table: xr.Dataset, other: xr.Dataset) -> bool:
    return table.drop_vars(COST).identical(other.drop_vars(COST))


@pytest.fixture(scope="module")
def here(tmp_path_factory: pytest.TempPathFactory) -> tuple[Path, xr.Dataset]:
    """The sweep without a cluster."""
    folder = tmp_path_factory.mktemp("here")
    return folder, write_trade(small(), folder, VARY, SEEDS, workers=0).table


@pytest.fixture(scope="module")
def client() -> Iterator[Client]:
    with local_client(2) as found:
        yield found


def _die(task: Task) -> Outcome:
    os.kill(os.getpid(), signal.SIGKILL)
    return compute(task)


class Meddling:
    """A client whose workers are given another task, or another thing to do with it."""

    def __init__(self, client: Client, deadly: str = "", folder: str = "") -> None:
        self.client, self.deadly, self.folder, self.loop = client, deadly, folder, client.loop

    def nthreads(self) -> dict[str, int]:
        return cast(dict[str, int], self.client.nthreads())

    def submit(self, work: Any, task: Task, **options: Any) -> Future:
        if self.deadly and self.deadly in task.name:
            work = _die
        if self.folder:
            task = dataclasses.replace(task, folder=self.folder)
        return self.client.submit(work, task, **options)


def test_workers_have_cores_of_their_own() -> None:
    mine = sorted(os.sched_getaffinity(0))
    assert shares(1) == {0: mine}
    each = shares(len(mine))
    assert sorted(core for cores in each.values() for core in cores) == mine
    assert all(len(cores) == 1 for cores in shares(3 * len(mine)).values())


def test_without_its_keys_nobody_talks_to_a_local_cluster(client: Client) -> None:
    """Neither plainly nor by TLS without a certificate: whoever talks to a worker can have it run code."""
    ports = [cast(Any, client.scheduler).address, *cast(Any, client).nthreads()]
    for address in ports:
        where = (urlsplit(address).hostname, urlsplit(address).port or 0)
        plainly = existing_client(address.replace("tls", "tcp"), 1.0)  # it answers in milliseconds, or not at all
        with pytest.raises(InputError, match="no scheduler answers"), plainly:
            raise AssertionError("it answers")
        stranger = ssl.SSLContext(ssl.PROTOCOL_TLS_CLIENT)
        stranger.check_hostname, stranger.verify_mode = False, ssl.CERT_NONE
        with (
            socket.create_connection(where, 10.0) as plain,
            stranger.wrap_socket(plain) as wrapped,
            pytest.raises(ssl.SSLError, match="CERTIFICATE_REQUIRED"),
        ):
            wrapped.recv(1)
    security = cast(Any, client.security)
    assert Path(security.tls_client_key).stat().st_mode & 0o077 == 0
    assert Path(security.tls_client_key).parent.stat().st_mode & 0o077 == 0


def test_a_worker_that_is_killed_while_it_starts_is_a_line(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(tempfile, "tempdir", str(tmp_path))
    before = set(multiprocessing.active_children())

    def kill_the_first() -> None:
        limit = time.monotonic() + 600.0
        while not (begun := set(multiprocessing.active_children()) - before) and time.monotonic() < limit:
            time.sleep(0.01)
        for process in begun:
            process.kill()

    thread = threading.Thread(target=kill_the_first)
    thread.start()
    with pytest.raises(InputError, match="--workers = 1: a worker process ended while it started"), local_client(1):
        raise AssertionError("it has started")
    thread.join()
    assert not list(tmp_path.iterdir())


def test_an_existing_cluster_gives_the_same_bits(client: Client, here: tuple[Path, xr.Dataset], tmp_path: Path) -> None:
    folder, expected = here
    address = cast(Any, client.scheduler).address
    assert address.startswith("tls://")
    security = cast(Any, client.security)
    certificates = {
        "ca-file": security.tls_ca_file,
        "client.cert": security.tls_client_cert,
        "client.key": security.tls_client_key,
    }
    with config.set({f"distributed.comm.tls.{key}": value for key, value in certificates.items()}):
        made = write_trade(small(), tmp_path, VARY, SEEDS, scheduler=address)
    assert same(made.table, expected)
    assert results(tmp_path) == results(folder)
    workers = {
        str(outcome["cost"]["worker"])
        for path in (tmp_path / "points").glob("*.json")
        if (outcome := load_outcome(path)) and "cost" in outcome
    }
    assert len(workers) == 2


def test_a_killed_worker_is_a_row_and_resume_mends_it(
    client: Client, here: tuple[Path, xr.Dataset], tmp_path: Path
) -> None:
    folder, expected = here
    deadly = cast(Client, Meddling(client, deadly="height_m=5_radar.baseline_m=0.2_seed=1"))
    table = trade(small(), VARY, SEEDS, client=deadly, out=tmp_path)
    dead = table["status"].sel({"radar.height_m": 5.0, "radar.baseline_m": 0.2, "seed": 1})
    assert dead.item() == "failed"
    assert "the worker process died" in table["reason"].sel(dead.coords).item()
    assert int((table["status"] == "failed").sum()) == 1
    assert int((table["status"] == "done").sum()) == 3
    before = {path.name: path.stat().st_mtime_ns for path in (tmp_path / "points").glob("*.json")}
    resumed = write_trade(small(), tmp_path, VARY, SEEDS, workers=0, resume=True)
    assert same(resumed.table, expected)
    assert results(tmp_path) == results(folder)
    after = {path.name: path.stat().st_mtime_ns for path in (tmp_path / "points").glob("*.json")}
    assert [name for name in after if after[name] != before[name]] == [
        "00002_radar.height_m=5_radar.baseline_m=0.2_seed=1.json"
    ]


def test_workers_that_do_not_see_the_folder(client: Client, here: tuple[Path, xr.Dataset], tmp_path: Path) -> None:
    elsewhere = cast(Client, Meddling(client, folder=str(tmp_path / "not" / "here")))
    table = trade(small(), VARY, SEEDS, client=elsewhere, out=tmp_path / "out")
    assert same(table, here[1])
    assert results(tmp_path / "out") == results(here[0])
    assert not (tmp_path / "not").exists()


class Lost(Meddling):
    """A client that finds no scheduler any more, once a point is done."""

    asked = 0

    def nthreads(self) -> dict[str, int]:
        self.asked += 1
        if self.asked > 1:
            raise OSError("connection lost")
        return {"one": 1}


def test_a_lost_scheduler_is_one_line_and_what_is_done_stays(client: Client, tmp_path: Path) -> None:
    with pytest.raises(InputError, match="does not answer any more; 5 of 8 points are done and stay, --resume goes on"):
        trade(small(), VARY, SEEDS, client=cast(Client, Lost(client)), out=tmp_path)
    with xr.open_dataset(tmp_path / "trade.nc") as table:
        assert int((table["status"] == "done").sum()) == 1


SCRIPT = """
import signal, sys
signal.signal(signal.SIGINT, signal.default_int_handler)  # minds Ctrl-C even where the tests run in the background
sys.path.insert(0, {tests!r})
from test_sweep_survives import SEEDS, VARY, small
from seamap_rt.studies.sweep import write_trade
if __name__ == "__main__":
    try:
        write_trade(small(), sys.argv[1], VARY, 12, workers=1, progress=lambda line: print(line, flush=True))
    except KeyboardInterrupt as interruption:
        print("interrupted:", interruption, flush=True)
"""


def test_interrupted_what_is_done_stays(tmp_path: Path) -> None:
    script, out = tmp_path / "sweep.py", tmp_path / "out"
    script.write_text(SCRIPT.format(tests=str(Path(__file__).parent)), encoding="utf-8")
    process = subprocess.Popen(
        [sys.executable, str(script), str(out)], stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True,
        start_new_session=True,
    )  # fmt: skip
    try:
        limit = time.monotonic() + 600.0
        # The 24 refused points are there at once; the next is the first that a worker has done.
        while len(list(out.glob("points/*.json"))) < 25 and process.poll() is None and time.monotonic() < limit:
            time.sleep(0.02)
        os.killpg(process.pid, signal.SIGINT)  # as a terminal does: to the workers too
        said, errors = process.communicate(timeout=600.0)
    finally:
        if process.poll() is None:
            os.killpg(process.pid, signal.SIGKILL)
    done = sum(outcome["status"] == "done" for outcome in results(out).values())
    assert 1 <= done < 24
    assert said.splitlines()[-1] == f"interrupted: {24 + done} of 48 points are done and stay; --resume goes on"
    assert errors == ""
    with xr.open_dataset(out / "trade.nc") as table:
        assert int((table["status"] == "missing").sum()) == 24 - done
        assert int((table["status"] == "done").sum()) == done
