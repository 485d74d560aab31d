"""A folder of results: made or refused, cleared of earlier ones, and written into file by file, each of them whole."""

from __future__ import annotations

import os
import shutil
from pathlib import Path

from ..errors import InputError


def prepare_folder(folder: Path, overwrite: bool, products: tuple[str, ...]) -> None:
    """Make the folder, or say in one line why not: unwritable, a file, or another run's results without overwrite."""
    try:
        folder.mkdir(parents=True, exist_ok=True)
    except OSError as error:
        raise InputError(
            f"--out = '{folder}': cannot be made ({error.strerror or error}); choose a folder that you can write to"
        ) from None
    if not os.access(folder, os.W_OK | os.X_OK):
        raise InputError(f"--out = '{folder}': cannot be written to; choose a folder that you can write to")
    earlier = [name for name in products if (folder / name).exists()]
    if earlier and not overwrite:
        raise InputError(
            f"--out = '{folder}': holds another run's {earlier[0]}; choose another folder, or give --overwrite"
        )


def clear_folder(folder: Path, products: tuple[str, ...]) -> None:
    """Remove an earlier run's products, figures too, so that an interrupted run never stands beside an older report.

    Call it only when nothing can be refused any more.
    """
    figures = [path.name for path in folder.glob("*.png")] if "report.html" in products else []
    for name in (*products, *figures):
        path = folder / name
        if path.is_dir():
            shutil.rmtree(path)
        else:
            path.unlink(missing_ok=True)


def write_whole(path: Path, content: str | bytes) -> None:
    """Write a file that appears whole or not at all."""
    part = path.with_name(f".{path.name}.part")
    try:
        part.write_bytes(content if isinstance(content, bytes) else content.encode("utf-8"))
        os.replace(part, path)
    finally:
        part.unlink(missing_ok=True)
