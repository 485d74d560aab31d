"""Files that grow by turns: on a disk that is full they end with the last whole turn, and the process lives on."""

from __future__ import annotations

import json
import select
import subprocess
import sys
import textwrap
import time
from collections.abc import Callable, Iterator
from pathlib import Path

import numpy as np
import pytest
import xarray as xr

from seamap_rt.io.appendable import AppendableNetCDF

_BEFORE = """
import resource, sys
from pathlib import Path
import numpy as np
import xarray as xr
from seamap_rt.io.appendable import AppendableNetCDF
from seamap_rt.io.recovery import recover
from seamap_rt.io.results_folder import note_growing

def limit(size=resource.RLIM_INFINITY):
    '''No file of this process may grow beyond so many bytes: EFBIG, which HDF5 meets as it meets a full disk.'''
    resource.setrlimit(resource.RLIMIT_FSIZE, (size, resource.RLIM_INFINITY))

def tree(turn, side):
    field = xr.DataArray(np.full((1, side, side), float(turn)), dims=("turn", "y", "x"))
    dataset = xr.Dataset({"height": field}, {"turn": [turn], "x": np.arange(side)})
    return xr.DataTree.from_dict({"/polar": dataset, "/ground": dataset})

def moment(turn, side):
    values = np.random.default_rng(turn).normal(size=(1, side, side))
    return xr.Dataset({"height": xr.Variable(("time", "y", "x"), values, {"units": "?"})}, {"time": [float(turn)]})

def spectrum():
    return xr.Dataset({"density": ("k", np.ones(3))}, {"k": np.arange(3.0)})

def series(turn, samples):
    heights = np.full((1, samples), float(turn))
    named = {"gauge": ["east"], "turn": [turn], "time": ("sample", np.arange(samples) + float(turn * samples))}
    return xr.Dataset({"true_height": (("gauge", "sample"), heights), "height": (("gauge", "turn"), [[1.0]])}, named)
"""


# Each script in a process of its own, forked from one that has imported all this already: imports take seconds. The
# fork leaves the loop and ends as any process does.
_FORKS = """
import json, os
while request := sys.stdin.readline():
    script, folder = json.loads(request)
    if os.fork() == 0:
        os.chdir(folder)
        for stream, name in ((1, "stdout"), (2, "stderr")):
            os.dup2(os.open(f"{folder}.{name}", os.O_WRONLY | os.O_CREAT | os.O_TRUNC), stream)
        exec(script)
        break
    print(os.waitstatus_to_exitcode(os.wait()[1]), flush=True)
"""


Alone = Callable[[str], str]


@pytest.fixture(scope="module")
def forks() -> Iterator[subprocess.Popen[str]]:
    with subprocess.Popen(
        [sys.executable, "-c", _BEFORE + _FORKS], stdin=subprocess.PIPE, stdout=subprocess.PIPE, text=True
    ) as parent:
        yield parent


@pytest.fixture
def alone(forks: subprocess.Popen[str], tmp_path: Path) -> Alone:
    """What a process of its own, in an empty folder, prints; it must end well, and HDF5 must not complain."""

    def ended(script: str) -> str:
        assert forks.stdin is not None
        assert forks.stdout is not None
        print(json.dumps([textwrap.dedent(script), str(tmp_path)]), file=forks.stdin, flush=True)
        assert select.select([forks.stdout], [], [], 120.0)[0], "no end within 120 s"
        code = forks.stdout.readline().strip()
        printed, complained = (Path(f"{tmp_path}.{name}").read_text(encoding="utf-8") for name in ("stdout", "stderr"))
        assert (code, complained) == ("0", "")
        return printed

    return ended


SEA = "AppendableNetCDF(Path('it.nc'), ('time',), constant={'spectrum': spectrum()}, compressed=True)"
KINDS = [
    ("AppendableNetCDF(Path('it.nc'))", "tree(turn, 128)", "polar"),
    (SEA, "moment(turn, 256)", "/"),
    ("AppendableNetCDF(Path('it.nc'), ('turn', 'sample'))", "series(turn, 20_000)", "/"),
]


@pytest.mark.parametrize(("file", "made", "group"), KINDS)
@pytest.mark.parametrize("full", ["at a turn", "at the end"])
@pytest.mark.slow
def test_a_full_disk_keeps_the_whole_turns(
    alone: Alone, tmp_path: Path, full: str, file: str, made: str, group: str
) -> None:
    """There is no room for the file itself then: the turns stay beside it, and `recover` makes it of them."""
    said = alone(
        f"""
        try:
            with note_growing(Path(), ("it.nc",)), {file} as file:
                for turn in range(12):
                    if turn == 9 and "{full}" == "at a turn":
                        limit(100_000)
                    file.append({made})
                limit(1_200_000)
        except OSError as error:
            print(file.complete, error.filename, "seamap-rt recover" in error.strerror, Path("it.nc").exists())
        limit()
        print(recover(Path()).complete)
        """
    )
    turns = "9" if full == "at a turn" else "12"
    assert said.split() == [turns, "it.nc", "True", "False", turns]
    assert [path.name for path in tmp_path.iterdir()] == ["it.nc"]
    with xr.open_datatree(tmp_path / "it.nc") as found:
        dataset = found[group].to_dataset()
        assert dataset.sizes["time" if "time" in dataset.sizes else "turn"] == int(turns)
        assert dataset["height"].notnull().all()


def test_a_file_does_not_hold_when_it_was_written(tmp_path: Path) -> None:
    """The same run has the same bytes at any time: h5py before 3.15 writes the second of it into each object."""

    def written(path: Path) -> bytes:
        with AppendableNetCDF(path) as file:
            for turn in range(3):
                file.append(xr.Dataset({"height": (("turn", "x"), np.ones((1, 4), np.float32))}, {"turn": [turn]}))
        return path.read_bytes()

    before = written(tmp_path / "before.nc")
    time.sleep(1.1)
    assert written(tmp_path / "after.nc") == before


def test_room_that_a_turn_does_not_need_is_given_back(alone: Alone, tmp_path: Path) -> None:
    """Files of a few small turns are small: a megabyte more was asked for."""
    alone(
        """
        for turns in (1, 20):
            with AppendableNetCDF(Path(f"{turns}.nc")) as file:
                for turn in range(turns):
                    file.append(tree(turn, 4))
        """
    )
    one, twenty = ((tmp_path / f"{turns}.nc").stat().st_size for turns in (1, 20))
    assert one < 50_000
    assert twenty - one < 50_000  # 19 turns of 256 bytes and the trees that find them


def test_a_turn_that_one_group_cannot_take_is_in_none(alone: Alone, tmp_path: Path) -> None:
    """Of a run's store the disk has no room for the larger group: files of both end with the turn before."""
    said = alone(
        """
        from seamap_rt.io.growing_store import GrowingStore

        files = {name: Path(name + ".nc") for name in ("small", "large")}
        try:
            with GrowingStore(Path("run.zarr"), files=files) as store:
                for turn in range(100):
                    if turn == 3:
                        limit(1_000_000)
                    store.append({"small": tree(turn, 16), "large": tree(turn, 512)})
        except OSError as error:
            print(error.filename)
        limit()
        GrowingStore.reopen(Path("run.zarr"), files).close()
        """
    )
    assert said.strip() == "run.zarr"
    for name in ("small.nc", "large.nc"):
        with xr.open_datatree(tmp_path / name) as found:
            assert found["ground"].to_dataset()["turn"].values.tolist() == [0, 1, 2]


def test_no_turn_leaves_no_file(alone: Alone, tmp_path: Path) -> None:
    said = alone(
        """
        limit(100_000)
        try:
            with AppendableNetCDF(Path("none.nc")) as file:
                file.append(tree(0, 128))
        except OSError as error:
            print(error.filename, error.strerror)
        """
    )
    assert said.startswith("none.nc ")
    assert not list(tmp_path.iterdir())


def test_file_systems_that_give_no_word_are_written_to(alone: Alone, tmp_path: Path) -> None:
    """macOS knows no such call (None), and some file systems refuse it for all sizes."""
    alone(
        """
        import errno, os
        def write(name):
            with AppendableNetCDF(Path(name)) as file:
                for turn in range(3):
                    file.append(tree(turn, 16))
        for name in ("EINVAL", "EOPNOTSUPP"):
            def refuse(*_):
                raise OSError(getattr(errno, name), "not here")
            os.posix_fallocate = refuse
            write(name + ".nc")
        del os.posix_fallocate
        write("None.nc")
        """
    )
    for name in ("EINVAL", "EOPNOTSUPP", "None"):
        with xr.open_datatree(tmp_path / f"{name}.nc") as found:
            assert found["polar"].to_dataset()["turn"].values.tolist() == [0, 1, 2]
