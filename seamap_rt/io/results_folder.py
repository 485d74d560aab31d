"""A folder of results: made or refused, held by one process, cleared of earlier ones, written into file by file."""

from __future__ import annotations

import errno
import json
import os
import re
import shutil
from collections.abc import Container, Iterator
from contextlib import ExitStack, contextmanager
from pathlib import Path
from typing import NamedTuple

from ..compute.locks import LockHeldError, holder_of, locked, remove_abandoned
from ..errors import InputError
from .opening import LONG, read_json

# What a folder of each kind of results is known by. Retrievals and forecasts may stand in a run's.
_KINDS = {
    "a run's": "run.zarr echoes.zarr maps.nc truth.nc gauges.nc prediction.nc report.html evolution.gif polar_images",
    "a trade's": "trade.html trade.json trade.csv trade.nc trade.png",
    "a shadowing study's": "shadowing.nc shadowing.csv shadowing.png shadowing_seen.png shadowing.html",
    "a sea's": "sea.nc recorded_sea.nc statistics.txt directional_spectrum.png sea_surface.png sea.gif from_mast.png",
    "a link budget's": "link.csv link.png",
    "a validation's": "validation.html",
}
KINDS = {kind: names.split() for kind, names in _KINDS.items()}
FULL = (errno.ENOSPC, errno.EDQUOT, errno.EFBIG)  # of a disk, or what it takes of a file
_LOCK, _MARKER = ".seamap-rt.lock", ".seamap-rt.unfinished"
# What products are called until they are whole, and after they were removed.
_ENDINGS = "nc|zarr|json|toml|html|png|gif|csv|tif|txt|unfinished"
_HIDDEN = re.compile(rf"\.(.+?\.({_ENDINGS}))\.(part|part\.journal|part\.journal\.part|zarr|zarr\.removed|removed)")
RUN = "run.zarr"  # of a run's folder, the store of what grows
OF_RUN = {"maps.nc": "maps", "truth.nc": "truth", "gauges.nc": "gauges", "prediction.nc": "forecast"}
"""The groups of that store, beside `echoes`, by the files that are made of them."""
FILE = "file"  # the group of a hidden store of which its file is made
DESCRIPTION, FINISHED = "zarr.json", "finished"  # of a store, the file that describes it, and an attribute


class UnfinishedFiles(NamedTuple):
    """What was growing in a folder when its process was killed: the files, and what they grow by."""

    files: tuple[str, ...]
    unit: str  # turns, times


@contextmanager
def results_folder(folder: Path, overwrite: bool, products: tuple[str, ...], option: str = "--out") -> Iterator[None]:
    """A folder that nobody else writes results into meanwhile; it is made if it is not there.

    Raises InputError, in one line, for a folder that cannot be made or written to, into which another process writes,
    which holds results of another kind (a run's, a trade's …), or which holds another run's results, or what a kill has
    left of them, without `overwrite`.
    """
    try:
        folder.mkdir(parents=True, exist_ok=True)
    except OSError as error:
        raise InputError(
            f"{option} = '{folder}': cannot be made ({error.strerror or error}); choose a folder that you can write to"
        ) from None
    if not os.access(folder, os.W_OK | os.X_OK):
        raise InputError(f"{option} = '{folder}': cannot be written to; choose a folder that you can write to")
    remove_abandoned()
    with lock_folder(folder, option):
        for kind, names in KINDS.items():  # also with overwrite: others would stay in part, among the new ones
            foreign = sorted(name for name in names if (folder / name).exists())
            if foreign and set(names).isdisjoint(products):
                raise InputError(f"{option} = '{folder}': holds {kind} {foreign[0]}; choose another folder")
        if not overwrite:
            refuse_unfinished(folder, option, ", --overwrite removes it")
            if earlier := [name for name in products if (folder / name).exists()]:
                raise InputError(
                    f"{option} = '{folder}': holds another run's {earlier[0]}; choose another folder, or give "
                    "--overwrite"
                )
        yield


@contextmanager
def lock_folder(folder: Path, option: str) -> Iterator[None]:
    """Keep others from writing results into the folder. InputError, which names the process, where one does."""
    with ExitStack() as stack:
        try:
            stack.enter_context(locked(folder / _LOCK))
        except LockHeldError as held:
            raise InputError(
                f"{option} = '{folder}': {held} writes there; choose another folder, or wait until it has ended"
            ) from None
        yield


@contextmanager
def note_growing(folder: Path, files: tuple[str, ...], unit: str = "turns") -> Iterator[None]:
    """Note which files grow in a folder. The note stays if a kill leaves them unfinished: `unfinished_files` reads it.

    It stays too where the disk had no room for the whole files; the OSError then says what to do.
    """
    marker = folder / _MARKER
    write_whole(marker, json.dumps({"files": files, "unit": unit}))

    def left() -> bool:
        return any(is_unfinished(folder / name if name == RUN else hidden_store(folder / name)) for name in files)

    try:
        yield
    except OSError as error:
        if not (error.errno in FULL and left()):
            raise
        message = f"{error.strerror}; seamap-rt recover '{folder}' makes files of the whole {unit} once there is room"
        raise OSError(error.errno, message, error.filename) from None
    finally:
        if not left():
            marker.unlink(missing_ok=True)


def hidden_store(path: Path) -> Path:
    """Where the turns of a file are that is not a run's, until it is whole."""
    return path.with_name(f".{path.name}.zarr")


def is_unfinished(store: Path) -> bool:
    """Whether a store grows, or did when its process was stopped."""
    try:
        return not read_json(store / DESCRIPTION, most=LONG)["attributes"][FINISHED]
    except (OSError, ValueError, KeyError, TypeError):
        return False


def unfinished_files(folder: Path) -> UnfinishedFiles | None:
    """What a kill has left unfinished in a folder, or what is growing in it now; None if all is finished."""
    try:
        note = read_json(folder / _MARKER)
        return UnfinishedFiles(tuple(note["files"]), str(note["unit"]))
    except (OSError, ValueError, KeyError, TypeError):
        return None


def refuse_unfinished(folder: Path, option: str, otherwise: str = "") -> None:
    """InputError for a folder that a killed process has left, unless a process that may live holds it."""
    holder = holder_of(folder / _LOCK)
    if unfinished_files(folder) is not None and (holder is None or holder.is_this_process or not holder.may_live):
        raise InputError(
            f"{option} = '{folder}': a killed process left its results unfinished; seamap-rt recover '{folder}' puts "
            f"what is whole under its own name{otherwise}"
        )


def forget_unfinished(folder: Path) -> None:
    """Forget that something was left unfinished in a folder."""
    (folder / _MARKER).unlink(missing_ok=True)


def clear_folder(folder: Path, products: tuple[str, ...]) -> None:
    """Remove an earlier run's products, figures too, so that an interrupted run never stands beside an older report.

    Call it only when nothing can be refused any more.
    """
    figures = [path.name for path in folder.glob("*.png")] if "report.html" in products else []
    names = {*products, *figures}
    for path in (folder / name for name in names):
        remove_tree(path) if path.is_dir() else path.unlink(missing_ok=True)
    remove_hidden(folder, names)
    left = unfinished_files(folder)
    if left is not None and not names.isdisjoint(left.files):
        forget_unfinished(folder)


def remove_tree(path: Path) -> None:
    """Remove a folder, if it is there: first out of its name, as half of a store is none."""
    removed = path.with_name(f".{path.name.lstrip('.')}.removed")
    shutil.rmtree(removed, ignore_errors=True)
    if path.exists():
        shutil.rmtree(path.rename(removed))


def remove_hidden(folder: Path, names: Container[str] | None = None) -> None:
    """Remove what a killed process has left of files that are not whole. Call it only while the folder is held.

    names: of the files; default all that the program could have written.
    """
    for path in folder.glob(".*"):
        hidden = _HIDDEN.fullmatch(path.name)
        if hidden and (names is None or hidden[1] in names or (hidden[2] == "png" and "report.html" in names)):
            shutil.rmtree(path) if path.is_dir() else path.unlink()


@contextmanager
def whole_file(path: Path) -> Iterator[Path]:
    """Another name to write a file under, which then appears whole or not at all."""
    part = path.with_name(f".{path.name}.part")
    try:
        yield part
        os.replace(part, path)
    finally:
        part.unlink(missing_ok=True)


def write_whole(path: Path, content: str | bytes | memoryview) -> None:
    """Write a file that appears whole or not at all."""
    with whole_file(path) as part:
        part.write_bytes(content.encode("utf-8") if isinstance(content, str) else content)
