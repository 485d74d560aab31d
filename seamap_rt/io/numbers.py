"""Numbers that a caller gives, and numbers in refusals: a limit that is named must satisfy its check when typed in."""

from __future__ import annotations

import math
from collections.abc import Callable

import numpy as np
from numpy.typing import ArrayLike, NDArray

from ..errors import InputError


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


def numbers(name: str, values: ArrayLike) -> NDArray[np.float64]:
    """An array of what a caller gives; InputError for what is none of numbers."""
    try:
        return np.asarray(values, dtype=np.float64)
    except (TypeError, ValueError):
        raise InputError(f"{name}: is a {type(values).__name__}, must be numbers; give a list or an array") from None
