"""What a kill leaves: at each instant of the writing the last whole turn can be had under the file's own name."""

from __future__ import annotations

import errno
import json
import os
import shutil
import subprocess
import sys
import threading
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import h5py
import numpy as np
import pytest
import xarray as xr

from seamap_rt.compute import locks
from seamap_rt.compute.locks import scratch_folder
from seamap_rt.errors import InputError
from seamap_rt.io import growing_store
from seamap_rt.io.appendable import AppendableNetCDF
from seamap_rt.io.growing_store import GrowingStore
from seamap_rt.io.recovery import recover
from seamap_rt.io.results_folder import RUN, clear_folder, hidden_store, note_growing, results_folder


def tree(turn: int) -> xr.DataTree:
    """Two groups, as maps have, with values that name their turn."""
    height = xr.DataArray(np.full((1, 5, 7), float(turn)), dims=("turn", "y", "x"))
    dataset = xr.Dataset({"height": height}, {"turn": [turn], "x": np.arange(7)})
    return xr.DataTree.from_dict({"/polar": dataset, "/ground": dataset})


def echoes(turn: int, pulses: int = 3) -> xr.Dataset:
    """Echoes of a turn, of which only the fields that a store must keep."""
    voltage = np.full((pulses, 2, 4), turn + 1, np.complex64)
    coordinates = {
        "time": ("pulse", turn + np.arange(pulses) / 10.0),
        "turn": ("pulse", np.full(pulses, turn)),
        "range": np.arange(4.0),
    }
    return xr.Dataset({"voltage": (("pulse", "receiver", "range"), voltage)}, coordinates, {"complete_turns": turn + 1})


class Snapshots:
    """Copies of a folder, one for each instant at which a kill would leave something else, and the turns then whole."""

    def __init__(self, folder: Path, home: Path) -> None:
        self.folder, self.home = folder, home
        self.taken: list[tuple[Path, int]] = []
        self.whole = 0

    def take(self) -> None:
        copy = self.home / str(len(self.taken))
        shutil.copytree(self.folder, copy)
        self.taken.append((copy, self.whole))


@pytest.fixture
def snapshots(tmp_path: Path) -> Snapshots:
    folder = tmp_path / "run"
    folder.mkdir()
    return Snapshots(folder, tmp_path)


# ------------------------------------------------------------------------------------------------------ NetCDF


def watch(snapshots: Snapshots, monkeypatch: pytest.MonkeyPatch) -> None:
    """Before each new name, also with half of what then gets it, and before anything goes."""
    renamed, removed, one_at_a_time = os.replace, os.unlink, threading.RLock()

    def replace(old: Path, new: Path) -> None:
        with one_at_a_time:  # a store is written in several threads
            snapshots.take()
            if Path(old).suffix != ".nc":  # which has been whole before
                snapshots.take()
                half = snapshots.taken[-1][0] / Path(old).relative_to(snapshots.folder)
                os.truncate(half, half.stat().st_size // 2)
            renamed(old, new)

    def unlink(path: Path, **given: Any) -> None:
        with one_at_a_time:
            snapshots.take()
            removed(path, **given)

    monkeypatch.setattr(os, "replace", replace)
    monkeypatch.setattr(os, "unlink", unlink)


def test_each_write_leaves_a_file_with_its_whole_turns(snapshots: Snapshots, monkeypatch: pytest.MonkeyPatch) -> None:
    """As many turns as were appended, or the one more that was about to be; their values are those of their turns."""
    folder = snapshots.folder
    with monkeypatch.context() as watched, note_growing(folder, ("maps.nc",)):
        watch(snapshots, watched)
        with AppendableNetCDF(folder / "maps.nc") as file:
            for turn in range(3):
                file.append(tree(turn))
                snapshots.whole = file.complete
            snapshots.take()
    assert len(snapshots.taken) > 20
    assert recovered(snapshots, more=1) == {1, 2, 3}


def recovered(snapshots: Snapshots, more: int) -> set[int]:
    """Numbers of turns that each snapshot's file holds when it is recovered: those that were whole, or so many more;
    nothing else is left, and values are those of their turns."""
    seen = set()
    for copy, whole in snapshots.taken:
        assert recover(copy) is not None
        assert {path.name for path in copy.iterdir()} <= {"maps.nc"}
        if not (copy / "maps.nc").exists():
            assert whole == 0
            continue
        with h5py.File(copy / "maps.nc") as opened:
            for group in ("polar", "ground"):
                turns, heights = (np.asarray(opened[f"{group}/{name}"]) for name in ("turn", "height"))
                assert whole <= len(turns) <= whole + more
                np.testing.assert_array_equal(turns, np.arange(len(turns)))
                np.testing.assert_array_equal(heights, turns[:, None, None] * np.ones((1, 5, 7)))
            seen.add(len(turns))
    return seen


@pytest.mark.parametrize(("stopped", "whole"), [("killed", 2), ("interrupted", 3)])
def test_each_write_of_one_that_goes_on_leaves_what_it_had(
    snapshots: Snapshots, monkeypatch: pytest.MonkeyPatch, stopped: str, whole: int
) -> None:
    """A kill left its three turns beside it, an interruption made the file of them; it goes on after all, or two."""
    path = snapshots.folder / "maps.nc"
    file = AppendableNetCDF(path)
    for turn in range(3):
        file.append(tree(turn))
    if stopped == "interrupted":
        file.close()
    snapshots.whole = whole
    with monkeypatch.context() as watched, note_growing(snapshots.folder, ("maps.nc",)):
        watch(snapshots, watched)
        with AppendableNetCDF(path, whole=whole) as again:
            for turn in range(whole, 5):
                again.append(tree(turn))
                snapshots.whole = again.complete
    assert recovered(snapshots, more=3 - whole + 1) == set(range(whole, 6))
    with xr.open_datatree(path) as found:
        assert found["polar"].to_dataset()["turn"].values.tolist() == list(range(5))
    assert [each.name for each in snapshots.folder.iterdir()] == ["maps.nc"]


@pytest.mark.parametrize("name", ["zarr.json", "file/polar/height/zarr.json", "file/polar/height/c/1/0/0"])
@pytest.mark.parametrize("content", [b"not one", None])
def test_damage_is_one_line(tmp_path: Path, name: str, content: bytes | None) -> None:
    """A chunk that is lost too: Zarr would read it as what is missing."""
    with note_growing(tmp_path, ("maps.nc",)):
        file = AppendableNetCDF(tmp_path / "maps.nc")
        for turn in range(2):
            file.append(xr.DataTree.from_dict({"/polar": tree(turn)["polar"].to_dataset().pad(y=(0, 800))}))
    damaged = hidden_store(tmp_path / "maps.nc") / name
    if content is None:
        damaged.unlink()
    else:
        damaged.write_bytes(content)
    with pytest.raises(InputError, match=r"cannot be recovered \(.*\); run it again with --overwrite"):
        recover(tmp_path)


@pytest.mark.parametrize("name", ["maps.nc", "echoes.zarr"])
def test_what_an_earlier_version_left_is_one_line(tmp_path: Path, name: str) -> None:
    """A folder of its turns beside a file, or a store of echoes."""
    left = tmp_path / ".maps.nc.part" / "1.nc" if name == "maps.nc" else tmp_path / name / "zarr.json"
    left.parent.mkdir()
    left.touch()
    (tmp_path / ".seamap-rt.unfinished").write_text(json.dumps({"files": [name], "unit": "turns"}))
    with pytest.raises(InputError, match=r"an earlier version left .* unfinished, and recovers it; .*--overwrite"):
        recover(tmp_path)
    assert left.exists()


# -------------------------------------------------------------------------------------------------- a run's store


def test_each_write_of_a_run_leaves_its_whole_turns(snapshots: Snapshots, monkeypatch: pytest.MonkeyPatch) -> None:
    """Before each file of it, and in the middle of it; also where turns share a chunk. Echoes, maps and forecasts, of
    which the first turn has none, end with the same turn."""
    folder = snapshots.folder
    files = {"maps": folder / "maps.nc", "forecast": folder / "prediction.nc"}
    with monkeypatch.context() as patch, note_growing(folder, (RUN, "maps.nc", "prediction.nc")):
        watch(snapshots, patch)
        patch.setattr(growing_store, "ROOM", 2)
        with GrowingStore(folder / RUN, ("turn", "pulse", "issue"), files) as store:
            for turn in range(3):
                maps = xr.DataTree.from_dict({"/polar": tree(turn)["polar"].to_dataset()})
                issue = xr.Dataset({"elevation": ("issue", [1.0 * turn])}, {"issue": [turn]}) if turn else None
                store.append({"echoes": echoes(turn), "maps": maps, "forecast": issue})
                snapshots.whole = turn + 1
            snapshots.take()
    assert len(snapshots.taken) > 100
    for copy, whole in snapshots.taken:
        if whole:  # as it was left, before anything is mended
            assert open_plainly(copy) in (whole, whole + 1)
        found = recover(copy)
        assert found is not None
        assert {path.name for path in copy.iterdir()} <= {RUN, "maps.nc", "prediction.nc"}
        assert not list(copy.rglob("*.partial"))
        assert found.complete in (whole, whole + 1)
        if not (copy / RUN).exists():
            assert whole == 0
            continue
        assert open_plainly(copy) == found.complete
        with h5py.File(copy / "maps.nc") as maps:
            turns = np.arange(found.complete or 0)
            np.testing.assert_array_equal(np.asarray(maps["polar/turn"]), turns)
            expected = turns[:, None, None] * np.ones((1, 5, 7))
            np.testing.assert_array_equal(np.asarray(maps["polar/height"]), expected)
        if turns.size > 1:
            with h5py.File(copy / "prediction.nc") as made:
                np.testing.assert_array_equal(np.asarray(made["issue"]), turns[1:])
                np.testing.assert_array_equal(np.asarray(made["elevation"]), turns[1:])


def open_plainly(folder: Path) -> int:
    """The turns of the echoes in a folder, whose values must be those of their turns, as anyone opens them."""
    with xr.open_zarr(folder / RUN, group="echoes", chunks=None) as found:
        turns = int(found.attrs["complete_turns"])
        np.testing.assert_array_equal(found["turn"].values, np.repeat(np.arange(turns), 3))
        expected = np.broadcast_to(1.0 + found["turn"].values[:, None, None], (3 * turns, 2, 4))
        np.testing.assert_array_equal(found["voltage"].values, expected)
        return turns


# ---------------------------------------------------------------------------------------- locks and scratch folders


HOLDS = """
import sys, time
from pathlib import Path
from seamap_rt.compute.locks import locked
from seamap_rt.compute.locks import scratch_folder
with locked(Path(sys.argv[1])), scratch_folder(within=Path(sys.argv[2])) as folder:
    (folder / "large").touch()
    print(folder, flush=True)
    time.sleep(60)
"""


@pytest.fixture
def holder(tmp_path: Path) -> Iterator[subprocess.Popen[str]]:
    """A process that holds the lock of the folder `out`, and a scratch folder in `tmp`; the latter's name is read."""
    for name in ("out", "tmp"):
        (tmp_path / name).mkdir()
    arguments = [str(tmp_path / "out" / ".seamap-rt.lock"), str(tmp_path / "tmp")]
    with subprocess.Popen([sys.executable, "-c", HOLDS, *arguments], stdout=subprocess.PIPE, text=True) as process:
        assert process.stdout is not None
        assert process.stdout.readline()
        yield process
        process.kill()


def test_a_folder_and_scratch_are_held_by_the_living_alone(tmp_path: Path, holder: subprocess.Popen[str]) -> None:
    out, temporary = tmp_path / "out", tmp_path / "tmp"
    with pytest.raises(InputError, match=rf"process {holder.pid} on .*, since 20.* writes there; choose another"):
        results_folder(out, True, ()).__enter__()
    with scratch_folder(within=temporary) as mine:
        assert len(list(temporary.iterdir())) == 2
    assert not mine.exists()
    assert [path.name for path in next(temporary.iterdir()).glob("[!.]*")] == ["large"]
    holder.kill()
    holder.wait()
    with results_folder(out, False, ()), scratch_folder(within=temporary) as mine:
        assert list(temporary.iterdir()) == [mine]
    assert not list(out.iterdir())
    assert not list(temporary.iterdir())


def test_scratch_of_others_stays(tmp_path: Path) -> None:
    """What has another name, or is a link, is not ours; a living process that has not taken its lock yet keeps its."""
    (tmp_path / "seamap-rt-mine").mkdir()
    (tmp_path / "elsewhere").mkdir()
    (tmp_path / "seamap-rt-1-link").symlink_to(tmp_path / "elsewhere")
    (tmp_path / f"seamap-rt-{os.getpid()}-abc").mkdir()
    (tmp_path / "seamap-rt-99999999-abc").mkdir()  # beyond the largest number of a process
    before = {path.name for path in tmp_path.iterdir()}
    with scratch_folder(within=tmp_path):
        pass
    assert before - {path.name for path in tmp_path.iterdir()} == {"seamap-rt-99999999-abc"}


@pytest.mark.parametrize(
    ("host", "pid", "began", "held"),
    [
        ("", os.getpid(), None, True),
        ("", os.getpid(), locks.began(os.getpid()), True),
        ("", os.getpid(), "1", False),
        ("", 99999999, None, False),
        ("", -1, None, False),
        ("", "1", None, False),
        ("another", 99999999, None, True),
        ("another", os.getpid(), "1", True),
    ],
    ids=["living", "the same", "another of its number", "dead", "no number", "words", "another host", "and its number"],
)
def test_without_locks_the_file_says_who_holds_it(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, host: str, pid: int, began: str | None, held: bool
) -> None:
    """A living process of this host, not one that has got its number since, and any of another host."""

    def flock(*_: int) -> None:
        raise OSError(errno.ENOLCK, "no locks here")

    monkeypatch.setattr(locks.fcntl, "flock", flock)
    path = tmp_path / "lock"
    here = locks.Holder.this_process()
    told = {"pid": pid, "host": host or here.host, "since": here.since}
    path.write_text(json.dumps(told if began is None else {**told, "began": began}))
    if held:
        with pytest.raises(locks.LockHeldError, match=str(pid)):
            locks.locked(path).__enter__()
    else:
        with locks.locked(path):
            taken = locks.holder_of(path)
            assert taken is not None
            assert taken.is_this_process
        assert not path.exists()


# ------------------------------------------------------------------------------------------------- what is refused


def test_what_a_kill_left_is_refused_until_recovered_or_cleared(tmp_path: Path) -> None:
    products = ("scene.toml", RUN)
    with note_growing(tmp_path, (RUN,)):
        store = GrowingStore(tmp_path / RUN, ("turn", "pulse"))
        store.append({"echoes": echoes(0)})
        shutil.copytree(tmp_path, tmp_path.with_name("killed"))
    killed = tmp_path.with_name("killed")
    with pytest.raises(InputError, match=r"a killed process left .*seamap-rt recover '.*killed'.*--overwrite removes"):
        results_folder(killed, False, products).__enter__()
    shutil.copytree(killed, tmp_path.with_name("cleared"))
    with results_folder(tmp_path.with_name("cleared"), True, products):
        clear_folder(tmp_path.with_name("cleared"), products)
    assert not list(tmp_path.with_name("cleared").iterdir())
    found = recover(killed)
    assert found is not None
    assert (found.files, found.complete, found.unit) == ((RUN,), 1, "turns")
    assert recover(killed) is None
    with pytest.raises(InputError, match=r"holds another run's run\.zarr"):
        results_folder(killed, False, products).__enter__()
