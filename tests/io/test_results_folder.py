"""One folder, one writer: a second process is told who writes there, and a killed one leaves nothing locked."""

from __future__ import annotations

import os
import signal
import subprocess
import sys
from pathlib import Path

import pytest

from seamap_rt.errors import InputError
from seamap_rt.io.results_folder import FolderLock, prepare_folder

HOLD = """
import sys, time
from pathlib import Path
from seamap_rt.io.results_folder import prepare_folder
held = prepare_folder(Path(sys.argv[1]), True, ())
print("held", flush=True)
time.sleep(60)
"""


def test_a_second_writer_is_told_of_the_first(tmp_path: Path) -> None:
    first = subprocess.Popen([sys.executable, "-c", HOLD, tmp_path], stdout=subprocess.PIPE, text=True)
    try:
        assert first.stdout is not None
        assert first.stdout.readline() == "held\n"
        with pytest.raises(InputError, match=rf"process {first.pid} of .+, since .+ writes there; wait") as caught:
            prepare_folder(tmp_path, True, ("maps.nc",))
        assert str(tmp_path) in str(caught.value)
    finally:
        os.kill(first.pid, signal.SIGKILL)
        first.communicate()
    prepare_folder(tmp_path, True, ()).release()
    assert not list(tmp_path.iterdir())


def test_a_lock_lasts_as_long_as_it_is_kept(tmp_path: Path) -> None:
    held = prepare_folder(tmp_path, False, ())
    with pytest.raises(InputError, match=f"process {os.getpid()} of"):
        FolderLock(tmp_path)
    held.release()
    held.release()
    with FolderLock(tmp_path):
        assert len(list(tmp_path.iterdir())) == 1
    assert not list(tmp_path.iterdir())


def test_a_folder_that_is_refused_is_not_held(tmp_path: Path) -> None:
    (tmp_path / "maps.nc").touch()
    with pytest.raises(InputError, match=r"holds another run's maps\.nc"):
        prepare_folder(tmp_path, False, ("maps.nc",))
    assert [path.name for path in tmp_path.iterdir()] == ["maps.nc"]
