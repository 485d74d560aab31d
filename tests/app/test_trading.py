"""What the page's Trade asks for, and the advice that it repeats from a trade that has ended."""

from __future__ import annotations

from pathlib import Path

import pytest

from seamap_rt.app.trade_view import advice, command_words
from seamap_rt.errors import InputError
from seamap_rt.studies.choices import recommendations
from tests.studies.test_trade_page import made_up


def test_a_limit_goes_to_the_command_and_one_that_leaves_nothing_is_refused() -> None:
    vary = ["radar.height_m=4:10:2"]
    assert command_words(vary, 3, 8.0)[-2:] == ["--at-most", "8"]
    assert "--at-most" not in command_words(vary, 3)
    with pytest.raises(InputError, match="--at-most 3: must be at least 4"):
        command_words(vary, 3, 3.0)


def test_the_advice_of_the_page_is_that_of_the_trade(tmp_path: Path) -> None:
    assert advice(tmp_path) == ""
    table = made_up(3).assign_attrs(at_most=9.0)
    (tmp_path / "trade.nc").write_bytes(bytes(table.to_netcdf(engine="h5netcdf")))
    said = advice(tmp_path)
    for line in recommendations(table):
        assert line[1:] in said
    assert "of at most 9 m: 8 m (confidence" in said
