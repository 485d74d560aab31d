"""Numbers in refusals: a limit that is named must satisfy its check when it is typed in."""

from __future__ import annotations

import math
from collections.abc import Callable


def rounded_up(value: float) -> str:
    """Four digits of a finite number, rounded up: the least that may be typed in where `value` is the least allowed."""
    return _four_digits(value, math.ceil)


def rounded_down(value: float) -> str:
    """Four digits of a finite number, rounded down: the most that may be typed in where `value` is the most allowed."""
    return _four_digits(value, math.floor)


def _four_digits(value: float, towards: Callable[[float], int]) -> str:
    if value == 0.0:
        return "0"
    scale = 10.0 ** (3 - math.floor(math.log10(abs(value))))
    return f"{towards(value * scale) / scale:.6g}"
