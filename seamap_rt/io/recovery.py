"""What a kill has left of a run's files, put under their own names."""

from __future__ import annotations

from pathlib import Path
from typing import NamedTuple
from zipfile import BadZipFile

from ..errors import InputError
from .results_folder import FULL, finished, held_folder, remove_hidden, unfinished

_OPTION, _FORECASTS = "DIR", "prediction.nc"


class Recovery(NamedTuple):
    """What was recovered: the files, how much is whole in each of them, and of what (turns, times).

    complete is None where all files had been finished already.
    """

    files: tuple[str, ...]
    complete: int | None
    unit: str


def recover(folder: str | Path) -> Recovery | None:
    """Put the turns that are whole in all files of a killed run under the files' own names; None if there is nothing.

    Turns that only some of the files have go. May itself be killed and called again.
    Raises InputError for a folder that is not there, into which a process writes, or whose files are damaged, and
    OSError where the disk is full.
    """
    folder = Path(folder)
    if not folder.is_dir():
        raise InputError(f"{_OPTION} = '{folder}': no such folder; give the folder of a run")
    with held_folder(folder, _OPTION):
        left = unfinished(folder)
        if left is None:
            remove_hidden(folder)
            return None
        try:
            complete = _recovered(folder, left.files)
        except (OSError, ValueError, KeyError, RuntimeError, BadZipFile) as error:
            if isinstance(error, OSError) and error.errno in FULL:
                raise
            raise InputError(
                f"{_OPTION} = '{folder}': cannot be recovered ({error}); run it again with --overwrite"
            ) from None
        if complete == 0 and "echoes.zarr" in left.files:  # a scene without results would look like another run's
            (folder / "scene.toml").unlink(missing_ok=True)
        remove_hidden(folder)
        finished(folder)
        return Recovery(tuple(name for name in left.files if (folder / name).exists()), complete, left.unit)


def _recovered(folder: Path, files: tuple[str, ...]) -> int | None:
    """How many turns are whole in all files, which hold them then; None if the kill came when all were finished."""
    from .appendable import recover_netcdf  # loads xarray
    from .echo_store import recover_echoes  # loads zarr

    growing = {name: turns for name in files if (turns := _whole(folder / name)) is not None}
    if not growing:
        return None
    forecasts = {_FORECASTS} if len(growing) > 1 else set()  # of a run, whose first turns may show no sea to forecast
    turns = min(growing[name] for name in growing.keys() - forecasts)
    for name in growing:
        made = _issued(folder / name, turns) if name in forecasts else turns
        (recover_echoes if name.endswith(".zarr") else recover_netcdf)(folder / name, made)
    return turns


def _issued(path: Path, turns: int) -> int:
    """How many of the whole forecasts of a file are of the first so many turns."""
    if not _whole(path):
        return 0
    from .turn_files import read_whole_turns

    return read_whole_turns(path, lambda file: int((file.array("issue")[:] < turns).sum()))


def _whole(path: Path) -> int | None:
    """How many turns of a file are whole; None where it is finished."""
    from .echo_store import is_growing, recoverable_turns  # loads zarr

    if path.suffix == ".zarr":
        return recoverable_turns(path) if is_growing(path) else None
    from .turn_files import part_of, whole_turns  # loads h5py

    return None if path.exists() else whole_turns(part_of(path))
