"""The file to which a command appends a line, with its time, for each step that begins: so others can watch it."""

from __future__ import annotations

import contextlib
import os
import time
from collections.abc import Callable
from pathlib import Path

from ..errors import one_line

VARIABLE = "SEAMAP_RT_PROGRESS"  # of the environment: names the file


def progress_file() -> Callable[[str], None] | None:
    """What appends a line to the file that the environment names; None where it names none."""
    named = os.environ.get(VARIABLE)
    if not named:
        return None
    path = Path(named)

    def note(line: str) -> None:
        with contextlib.suppress(OSError), path.open("a", encoding="utf-8") as file:  # telling must not end a run
            file.write(f"{time.time():.3f} {one_line(line)}\n")

    return note
