"""What the page is put together from: pictures, tables, and numbers written out."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
from matplotlib.figure import Figure

from ..conventions import written
from . import reduce

NOTHING = "—"


@dataclass(frozen=True)
class Picture:
    """A figure of the page."""

    name: str  # the PNG is name.png, an animation name.gif
    title: str
    alt: str
    caption: str
    draw: Callable[[], Figure | bytes]  # bytes are a GIF already


@dataclass(frozen=True)
class Table:
    """A table of the page, its cells already written out."""

    title: str
    head: Sequence[str]
    rows: Sequence[Sequence[str]]
    note: str = ""


def digits(value: Any, decimals: int, signed: bool = False) -> str:
    """A number as `written`, with a true minus sign; a dash for what is missing."""
    plain = reduce.number(value)
    return ("+" if signed and plain > 0.0 else "") + written(plain, decimals).replace("-", "−")


def metres(value: Any, decimals: int = 3, signed: bool = False) -> str:
    text = digits(value, decimals, signed)
    return text if text == NOTHING else f"{text} m"


def percent(share: Any) -> str:
    value = reduce.number(share)
    return f"{written(100.0 * value, 0)} %" if np.isfinite(value) else NOTHING


def count(value: Any) -> str:
    number = reduce.number(value)
    return f"{number:,.0f}".replace(",", " ") if np.isfinite(number) else NOTHING
