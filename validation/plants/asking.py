"""A process that has the libraries loaded, and of which each judge gets a copy: loading them takes longer than a test.

With the word bare it loads none. The copy imports the package and the tests anew, from the tree in which it runs. Reads
a line of JSON for each judge from standard input, [tree, folder, command…], and answers with its exit code; what it
prints is in the folder's file `said`.
"""

from __future__ import annotations

import importlib
import json
import os
import signal
import sys
from pathlib import Path

_LONGEST_S = 240  # a judge that takes longer is ended by a signal, which is no verdict
_LIBRARIES = "numba", "numpy.testing", "scipy.signal", "scipy.stats", "scipy.optimize", "scipy.interpolate", "xarray"
_MORE = "zarr", "h5py", "h5netcdf", "netCDF4", "pydantic", "matplotlib.figure", "cyclopts", "trimesh"


def _load() -> None:
    for name in (*_LIBRARIES, *_MORE):
        try:
            importlib.import_module(name)
        except ImportError:  # it then is not needed either
            continue


def _judge(tree: str, folder: str, command: list[str]) -> int:
    """Runs in the copy: the judge's exit code."""
    os.chdir(tree)
    said = os.open(Path(folder) / "said", os.O_WRONLY | os.O_CREAT | os.O_TRUNC)
    os.dup2(said, 1)
    os.dup2(said, 2)
    os.dup2(os.open(os.devnull, os.O_RDONLY), 0)
    signal.alarm(_LONGEST_S)
    sys.path[:0] = [tree]
    os.environ["PYTHONPATH"] = tree
    if command[0] == "pytest":
        return int(importlib.import_module("pytest").main(command[1:]))
    return int(importlib.import_module("seamap_rt.cli").main(command) or 0)


def _guarded(tree: str, folder: str, command: list[str]) -> int:
    try:
        return _judge(tree, folder, command)
    except SystemExit as stop:
        return stop.code if isinstance(stop.code, int) else 2
    except BaseException as error:
        print(f"{type(error).__name__}: {error}")
        return 3


def main() -> None:
    del sys.path[0]  # the folder of this file: a judge's modules come from its tree alone
    if sys.argv[1:] != ["bare"]:
        _load()
    for line in sys.stdin:
        tree, folder, *command = json.loads(line)
        child = os.fork()
        if child == 0:
            code = _guarded(tree, folder, command)
            sys.stdout.flush()
            sys.stderr.flush()
            os._exit(code)
        _, status = os.waitpid(child, 0)
        print(os.waitstatus_to_exitcode(status), flush=True)


if __name__ == "__main__":
    main()
