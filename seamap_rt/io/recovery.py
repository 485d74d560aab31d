"""What a kill has left of a run's files, put under their own names."""

from __future__ import annotations

from pathlib import Path
from typing import NamedTuple

from ..errors import InputError
from .results_folder import (
    FILE,
    FULL,
    OF_RUN,
    RUN,
    forget_unfinished,
    hidden_store,
    lock_folder,
    remove_hidden,
    remove_tree,
)
from .results_folder import unfinished_files as left_in

_OPTION = "DIR"


class Recovery(NamedTuple):
    """What was recovered: the files, how much is whole in each of them, and of what (turns, times).

    complete is None where all files had been finished already.
    """

    files: tuple[str, ...]
    complete: int | None
    unit: str


def recover(folder: str | Path) -> Recovery | None:
    """Put the turns that are whole of a killed run under its files' own names; None if there is nothing.

    May itself be killed and called again.
    Raises InputError for a folder that is not there, into which a process writes, or whose files are damaged or an
    earlier version's, and OSError where the disk is full.
    """
    folder = Path(folder)
    if not folder.is_dir():
        raise InputError(f"{_OPTION} = '{folder}': no such folder; give the folder of a run")
    with lock_folder(folder, _OPTION):
        left = left_in(folder)
        if left is None:
            remove_hidden(folder)
            return None
        _refuse_earlier(folder, left.files)
        try:
            complete = _recover_stores(folder, left.files)
        except Exception as error:  # a damaged store raises exceptions of many types
            if isinstance(error, OSError) and error.errno in FULL:
                raise
            raise InputError(
                f"{_OPTION} = '{folder}': cannot be recovered ({error}); run it again with --overwrite"
            ) from None
        if complete == 0 and RUN in left.files:  # a scene without results would look like another run's
            (folder / "scene.toml").unlink(missing_ok=True)
        remove_hidden(folder)
        forget_unfinished(folder)
        return Recovery(tuple(name for name in left.files if (folder / name).exists()), complete, left.unit)


def _refuse_earlier(folder: Path, files: tuple[str, ...]) -> None:
    earlier = [name for name in files if name == "echoes.zarr" or (folder / f".{name}.part").is_dir()]
    if earlier:
        raise InputError(
            f"{_OPTION} = '{folder}': an earlier version left {earlier[0]} unfinished, and recovers it; or run it "
            "again with --overwrite"
        )


def _recover_stores(folder: Path, files: tuple[str, ...]) -> int | None:
    """How many turns are whole in all files, which hold them then; None if the kill came when all were finished."""
    from .growing_store import GrowingStore  # loads zarr

    stores = {hidden_store(folder / each): {FILE: folder / each} for each in files if not (folder / each).exists()}
    if RUN in files:
        stores = {folder / RUN: {OF_RUN[each]: folder / each for each in files if each in OF_RUN}}
    turns = list[int]()
    for path, made in stores.items():
        store = GrowingStore.reopen(path, made) if path.exists() else GrowingStore(path)
        store.close()
        turns.append(store.complete)
        if path.name != RUN or not store.complete:
            remove_tree(path)
    return min(turns) if turns else None
