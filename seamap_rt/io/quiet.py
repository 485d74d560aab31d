"""Damaged files, opened by other libraries: what these print beside the exception that they raise is not shown."""

from __future__ import annotations

import logging
import sys
import warnings
from collections.abc import Callable, Iterator
from contextlib import contextmanager


@contextmanager
def without_complaints() -> Iterator[None]:
    """No line of a file that its library cannot even close: h5netcdf's destructor raises then, and Python prints it."""
    hook, sys.unraisablehook = sys.unraisablehook, _pass_over(sys.unraisablehook)
    try:
        yield
    finally:
        sys.unraisablehook = hook


def _pass_over(hook: Callable[[sys.UnraisableHookArgs], object]) -> Callable[[sys.UnraisableHookArgs], None]:
    def heard(lost: sys.UnraisableHookArgs) -> None:
        if issubclass(lost.exc_type, KeyboardInterrupt):  # nor is an interruption lost
            hook(lost)

    return heard


@contextmanager
def without_log(library: str) -> Iterator[None]:
    """Nothing of what a library logs."""
    logger = logging.getLogger(library)
    level = logger.level
    logger.setLevel(logging.CRITICAL + 1)
    try:
        yield
    finally:
        logger.setLevel(level)


@contextmanager
def quietly() -> Iterator[None]:
    """Neither complaints nor warnings."""
    with without_complaints(), warnings.catch_warnings():
        warnings.simplefilter("ignore")
        yield
