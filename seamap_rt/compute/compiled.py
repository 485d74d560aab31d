"""Numba's compiler, as all inner loops use it: without Python's lock, kept on disk, and with stated arithmetic."""

from __future__ import annotations

from collections.abc import Callable
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
        return njit(cache=True, **options)(function)
    except RuntimeError:  # no folder to keep the compiled code in: each process compiles it again
        return njit(**options)(function)


def compiled_fused(function: Callable[..., Any]) -> Callable[..., Any]:
    """`compiled`, its sums in the order in which they are written."""
    return compiled(function, "fused")


def compiled_strict(function: Callable[..., Any]) -> Callable[..., Any]:
    """`compiled`, its arithmetic as it is written."""
    return compiled(function, "strict")


def compiled_step(function: Callable[..., Any]) -> Callable[..., Any]:
    """`compiled`, as a part of the loop that calls it: a loop in steps is as fast as one in one piece."""
    return compiled(function, inside=True)


def compiled_step_fused(function: Callable[..., Any]) -> Callable[..., Any]:
    """`compiled_step`, its sums in the order in which they are written."""
    return compiled(function, "fused", inside=True)
