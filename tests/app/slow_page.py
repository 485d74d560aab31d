"""The page's own command, whose drawings take as long as a file beside the runs says: `slow_page.py FILE app …`."""

from __future__ import annotations

import sys
import time
from collections.abc import Callable
from pathlib import Path
from typing import Any

from seamap_rt.app import drawing
from seamap_rt.cli import main


def late(file: str, make: Callable[..., Any], *given: Any) -> Any:
    """Computes for so long before it draws, and gives the interpreter to nobody else of its process."""
    until = time.perf_counter() + float(Path(file).read_text())
    while time.perf_counter() < until:
        pass
    return make(*given)


class Late:
    """A lane that is slow."""

    def __init__(self, lane: drawing.DrawingProcess, file: str) -> None:
        self._lane, self._file = lane, file

    async def __call__(self, make: Callable[..., Any], *given: Any) -> Any:
        return await self._lane(late, self._file, make, *given)


if __name__ == "__main__":
    file = sys.argv.pop(1)
    drawing.quick, drawing.slow = Late(drawing.quick, file), Late(drawing.slow, file)  # type: ignore[assignment]
    sys.exit(main())
