"""Numbers as they are written: of no quantity that is there does a table say 0."""

from __future__ import annotations

import numpy as np
import pytest

from seamap_rt.app.design_view import number
from seamap_rt.conventions import written
from seamap_rt.report.page_elements import digits, metres, percent

SIZES = [*(10.0**-n * m for n in range(7) for m in (0.95, 1.0, 1.5, 9.96)), 12.345, 1234.5, 1e-9]


@pytest.mark.parametrize("decimals", [0, 1, 2, 3])
@pytest.mark.parametrize("value", SIZES)
def test_a_number_is_written_to_its_decimals_or_to_two_digits(value: float, decimals: int) -> None:
    for each in (value, -value):
        told = float(written(each, decimals))
        assert told != 0.0
        assert abs(told - each) <= max(0.5 * 10.0**-decimals, 0.0) * (1 + 1e-9)
        assert abs(told - each) <= 0.05001 * abs(each) or abs(each) >= 0.95 * 10.0**-decimals


def test_what_is_0_or_unknown_says_so() -> None:
    assert [written(each, 2) for each in (0.0, -0.0, np.nan, np.inf)] == ["0.00", "0.00", "—", "—"]
    assert [written(0.015, 1), written(9.996, 2), written(0.96, 0)] == ["0.015", "10.00", "1"]


def test_reports_tables_and_tiles_write_alike() -> None:
    for value in (0.015, 0.0004, 3.2):
        assert {digits(value, 1), number(value, 1), metres(value, 1).removesuffix(" m")} == {written(value, 1)}
    assert percent(0.003) == "0.30 %"
