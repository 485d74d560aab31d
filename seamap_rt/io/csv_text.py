"""Tables as CSV, in which no text is a formula."""

from __future__ import annotations

import csv
import io
import math
from collections.abc import Iterable
from typing import Any

_FORMULA = tuple("=+-@\t＝＋－＠")  # that spreadsheets begin one with, some of them in full width


def csv_text(rows: Iterable[Iterable[Any]], digits: int = 10) -> str:
    """Rows of cells, each on one line: floats with so many digits, empty for NaN, all else as `str` has it.

    A text that a spreadsheet would take for a formula gets an apostrophe before it; a number, also a negative one as
    text, stays as it is.
    """
    text = io.StringIO()
    csv.writer(text, lineterminator="\n").writerows([_cell(cell, digits) for cell in row] for row in rows)
    return text.getvalue()


def _cell(value: Any, digits: int) -> str:
    if isinstance(value, float):
        return "" if math.isnan(value) else f"{value:.{digits}g}"
    text = " ".join(str(value).splitlines())
    if not text.lstrip(" ").startswith(_FORMULA):
        return text
    try:
        float(text)
    except ValueError:
        return f"'{text}"
    return text
