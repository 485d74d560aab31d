"""Tables as CSV: no cell of text is a formula to a spreadsheet, numbers stay numbers, and one place writes them."""

from __future__ import annotations

import csv
import io
import re
from pathlib import Path

import numpy as np
import pytest
import xarray as xr
from hypothesis import example, given
from hypothesis import strategies as st

from seamap_rt.io.text import csv_text
from seamap_rt.studies import trade_table

_FORMULA = re.compile(r"\s*[=+\-@\t\r\n＝＋－＠]")
_NUMBER = re.compile(r"[+-]?(\d+\.?\d*|\.\d+)(e[+-]?\d+)?|[+-]?(inf|nan)", re.IGNORECASE)
HOSTILE = (
    "=cmd|' /C calc'!A0",
    "+1+1",
    "-2+3",
    "@SUM(A1)",
    "\t=1",
    "\r=1",
    "\n=1",
    "x\r=1",
    "x\n=1",
    " =1+1",
    "\x1f=1",
    "\u2003=1",
    '=HYPERLINK("http://x","y")',
    "-",
    "＝1",
    '"=1',
    "=1,=2",
)


def _read(text: str) -> list[list[str]]:
    return list(csv.reader(io.StringIO(text, newline="")))


@given(st.lists(st.lists(st.text(max_size=12) | st.sampled_from(HOSTILE), min_size=1, max_size=4), max_size=4))
@example([list(HOSTILE)])
def test_what_is_read_back_is_no_formula_and_else_what_was_written(table: list[list[str]]) -> None:
    found = _read(csv_text(table))
    assert [len(row) for row in found] == [len(row) for row in table]
    for cells, read in zip(table, found, strict=True):
        for cell, back in zip(cells, read, strict=True):
            assert not _FORMULA.match(back) or _is_number(back)
            line = " ".join(cell.splitlines())  # a break would begin a row, and the row with a formula
            assert back == line or (back == f"'{line}" and _FORMULA.match(line))


def _is_number(text: str) -> bool:
    try:
        float(text)
    except ValueError:
        return False
    return True


@given(st.floats() | st.integers())
def test_numbers_stay_as_they_are(value: float) -> None:
    for written in (f"{value}", f"{value:.6g}", f"{value:+g}"):
        assert csv_text([[written]]) == f"{written}\n"
    told = f"{value:.10g}" if isinstance(value, float) else f"{value}"
    assert csv_text([[value, 1]]) == f"{'' if value != value else told},1\n"


@pytest.mark.parametrize("text", HOSTILE)
def test_a_trade_over_a_hostile_value_that_is_refused_with_it_has_no_formula(text: str) -> None:
    table = xr.Dataset(coords={"sea.waves.0.file": [text, "-4"]})
    for name, value in (("status", "refused"), ("reason", f"{text}: cannot be read")):
        table[name] = ("sea.waves.0.file", [value, text])
    for name in (*trade_table._COLUMNS, *trade_table.COST):
        table[name] = ("sea.waves.0.file", [-1.5, np.nan])
    read = _read(trade_table.rows(table))
    cells = [cell for row in read for cell in row]
    assert not [cell for cell in cells if _FORMULA.match(cell) and not _NUMBER.fullmatch(cell)]
    assert "-1.5" in cells
    assert "-4" in cells


def test_tables_are_written_in_one_place() -> None:
    """Whoever writes CSV does so by `csv_text`; `exports` has an array of numbers alone, under a constant heading."""
    package = Path(__file__).parents[2] / "seamap_rt"
    words = ("csv.writer", "DictWriter", ".to_csv(", "savetxt(")
    found = {(str(path.relative_to(package)), word) for path in package.rglob("*.py") for word in words
             if word in path.read_text()}  # fmt: skip
    assert found == {("io/text.py", "csv.writer"), ("io/exports.py", "savetxt(")}
