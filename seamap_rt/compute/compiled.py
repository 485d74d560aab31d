"""Numba's compiler, as all inner loops use it: without Python's lock, kept on disk, and with stated arithmetic."""

from __future__ import annotations

from collections.abc import Callable
from contextlib import suppress
from functools import cache, partial
from pathlib import Path
from typing import Any, Literal

from numba import njit

Arithmetic = Literal["reordered", "fused", "strict"]

# What the compiler may do to floating-point sums. Each gives the same bits at every call on one machine.
_FASTMATH: dict[Arithmetic, Any] = {
    "reordered": {"contract", "reassoc", "nsz"},  # sums split among a processor's lanes; NaN and infinities are kept
    "fused": {"contract"},  # sums keep their order; a product and its sum may be rounded once
    "strict": False,  # as written: the same on every processor
}


def compiled(
    function: Callable[..., Any], arithmetic: Arithmetic = "reordered", inside: bool = False
) -> Callable[..., Any]:
    """The function compiled at its first call, for threads: it releases Python's lock. inside: of what calls it."""
    options = {"nogil": True, "error_model": "numpy", "fastmath": _FASTMATH[arithmetic], "forceinline": inside}
    try:
        made = njit(cache=True, **options)(function)
        _remove_stale(made.stats.cache_path, function.__code__.co_filename)
        return made
    except RuntimeError:  # no folder to keep the compiled code in: each process compiles it again
        return njit(**options)(function)


compiled_fused = partial(compiled, arithmetic="fused")
compiled_strict = partial(compiled, arithmetic="strict")
compiled_step = partial(compiled, inside=True)  # a part of what calls it: a loop in steps is as fast as in one piece
compiled_step_fused = partial(compiled, arithmetic="fused", inside=True)


@cache
def _remove_stale(folder: str, source: str) -> None:
    """Remove the indices of compiled code that are older than its source: Numba reads the whole of one before it looks
    at its date, and fails where it names a class that is no more."""
    with suppress(OSError):  # another process was first, or the folder is another user's
        changed = Path(source).stat().st_mtime
        for index in Path(folder).glob(f"{Path(source).stem}.*.nbi"):
            if index.stat().st_mtime < changed:
                index.unlink(missing_ok=True)
