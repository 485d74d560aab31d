"""Numba's compiler, as the inner loops of echoes and retrieval use it."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

from numba import njit

# Sums may be split among a processor's lanes, for the same bits at every call; NaN and infinities are what they are.
_OPTIONS: dict[str, Any] = {"nogil": True, "error_model": "numpy", "fastmath": {"contract", "reassoc", "nsz"}}


def compiled(function: Callable[..., Any]) -> Callable[..., Any]:
    """The function compiled at its first call, for threads: it lets go of Python's lock."""
    try:
        return njit(cache=True, **_OPTIONS)(function)
    except RuntimeError:  # no folder to keep the compiled code in: each process compiles it again
        return njit(**_OPTIONS)(function)
