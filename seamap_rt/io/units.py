"""Numbers in the unit that the program counts in, from the one that a file declares."""

from __future__ import annotations

import math
import re

import numpy as np
from numpy.typing import ArrayLike, NDArray

from ..errors import InputError

_LENGTHS = {"m": 1.0, "meter": 1.0, "metre": 1.0, "mm": 1e-3, "cm": 1e-2, "km": 1e3, "ft": 0.3048, "foot": 0.3048,
            "millimeter": 1e-3, "millimetre": 1e-3, "centimeter": 1e-2, "kilometer": 1e3}  # fmt: skip
_TIMES = {"s": 1.0, "sec": 1.0, "second": 1.0, "ms": 1e-3, "millisecond": 1e-3, "us": 1e-6, "µs": 1e-6, "μs": 1e-6,
          "microsecond": 1e-6, "ns": 1e-9, "nanosecond": 1e-9, "min": 60.0, "minute": 60.0,
          "h": 3600.0, "hour": 3600.0}  # fmt: skip
_ANGLES = {"degree": 1.0, "deg": 1.0, "°": 1.0, "rad": 180.0 / math.pi, "radian": 180.0 / math.pi}
_SPEEDS = {"m/s": 1.0, "ms-1": 1.0, "m.s-1": 1.0, "meter/second": 1.0, "metre/second": 1.0, "cm/s": 1e-2}
_RATES = {"rad/s": 1.0, "rads-1": 1.0, "1/s": 1.0, "s-1": 1.0, "hz": 2.0 * math.pi}
_KINDS = (_LENGTHS, _TIMES, _ANGLES, _SPEEDS, _RATES, {"m²/s": 1.0, "m2s-1": 1.0, "m2/s": 1.0})


def to_unit(values: ArrayLike, declared: str | None, unit: str, what: str) -> NDArray[np.float64]:
    """Values in `unit`, converted from the unit that is declared of `what`; as they are where none is."""
    given: NDArray[np.float64] = np.asarray(values)
    if declared is None or not str(declared).strip():
        return given
    word = re.sub(r"[\s^]", "", str(declared).lower())
    for kind in _KINDS:
        base, own = kind.get(unit), kind.get(word, kind.get(word.removesuffix("s")))
        if base is not None and own is not None:
            return given if own == base else given * (own / base)
    raise InputError(f"{what}: is in '{declared}': must be in {unit}, or a unit of its kind; convert it")
