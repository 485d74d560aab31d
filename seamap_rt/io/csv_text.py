"""Tables as CSV, in which no text is a formula."""

from __future__ import annotations

import csv
import io
from collections.abc import Iterable
from typing import Any

_FORMULA = tuple("=+-@\t＝＋－＠")  # that spreadsheets begin one with, some of them in full width


def csv_text(rows: Iterable[Iterable[Any]]) -> str:
    """Rows of cells, each as `str` has it, on one line.

    A text that a spreadsheet would take for a formula gets an apostrophe before it; a number, also a negative one as
    text, stays as it is.
    """
    text = io.StringIO()
    csv.writer(text, lineterminator="\n").writerows([_cell(str(cell)) for cell in row] for row in rows)
    return text.getvalue()


def _cell(text: str) -> str:
    text = " ".join(text.splitlines())
    if not text.lstrip(" ").startswith(_FORMULA):
        return text
    try:
        float(text)
    except ValueError:
        return f"'{text}"
    return text
