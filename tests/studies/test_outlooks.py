"""Outlooks of a grid: a value a design, what it would choose, and a dotted line beside a trade's curves."""

from __future__ import annotations

import re
from pathlib import Path
from typing import Any

import numpy as np
import pytest

import seamap_rt as sr
from seamap_rt.cli import main
from seamap_rt.studies.choices import QUALITY, RADIUS, outlook_lines, outlook_table, outlooks
from seamap_rt.studies.sweep import write_trade
from seamap_rt.studies.trade_figures import draw_quality, draw_trade


def test_a_grid_holds_the_outlook_of_each_design() -> None:
    found = outlooks("tiny", {"radar.height_m": [4, 9], "radar.baseline_m": [0.2, 0.0]})
    assert found[RADIUS].dims == ("radar.height_m", "radar.baseline_m")
    alone = sr.outlook(sr.load_scene("tiny", overrides={"radar.height_m": 9.0}))
    assert found[RADIUS].sel({"radar.height_m": 9, "radar.baseline_m": 0.2}) == alone.attrs["fully_measured_radius_m"]
    assert np.isnan(found[RADIUS].sel({"radar.baseline_m": 0.0})).all()  # a refused design is a gap
    inside = alone["quality"].sel(range=slice(75.0, 99.9)).mean()
    at = {"radar.height_m": 9, "radar.baseline_m": 0.2, "range": 87.5}
    assert float(found[QUALITY].sel(at)) == pytest.approx(float(inside))


def test_it_names_the_lowest_mast_near_the_best_and_the_seeds_that_a_trade_needs() -> None:
    found = outlooks("tiny", {"radar.height_m": [3, 6, 12]})
    line = next(outlook_lines(found))
    best = float(found[RADIUS].max())
    lowest = min(
        float(height)
        for height in found["radar.height_m"]
        if found[RADIUS].sel({"radar.height_m": height}) >= 0.95 * best
    )
    assert f"lowest antenna height within 5% of the best: {lowest:g} m" in line
    assert re.search(r"a trade needs (more than )?\d+ seeds to tell it from its neighbours", line)
    assert len(list(outlook_table(found))) == 4


def test_a_trade_keeps_the_outlook_beside_what_was_simulated(tmp_path: Path) -> None:
    keys = {"tracing.tracer": "horizon", "radar.range_m": [15.0, 60.0], "sea.extent_m": 180.0}
    made = write_trade(sr.load_scene("tiny", overrides=keys), tmp_path / "t", {"radar.height_m": [4.0, 6.0]}, workers=0)
    assert made.table[RADIUS].shape == (2,)
    assert np.isfinite(made.table[RADIUS]).all()
    assert np.isfinite(made.table[QUALITY]).any()
    for draw in (draw_trade, draw_quality):
        dotted = [line for axes in draw(made.table).axes for line in axes.get_lines() if line.get_linestyle() == ":"]
        assert dotted
    assert "simulates nothing" in (tmp_path / "t" / "trade.html").read_text(encoding="utf-8")


@pytest.mark.parametrize(
    ("arguments", "said"),
    [
        (("choppy_sea",), "fully measured radius about"),
        (("harbour",), "it does not know: objects"),
        (("flat",), "no waves: nothing is there to measure"),
        (("tiny", "--vary", "radar.height_m=4,8"), "lowest antenna height within 5% of the best"),
    ],
)
def test_the_command_answers(arguments: tuple[str, ...], said: str, capsys: pytest.CaptureFixture[str]) -> None:
    with pytest.raises(SystemExit) as end:
        main(["outlook", *arguments])
    assert end.value.code == 0
    assert said in capsys.readouterr().out


@pytest.mark.parametrize(
    ("arguments", "said"),
    [(("tiny", "--vary", "radar.height_m=4,abc"), "abc"), (("tiny", "--set", "radar.baseline_m=0"), "baseline_m = 0")],
)
def test_the_command_refuses_in_one_line(arguments: Any, said: str, capsys: pytest.CaptureFixture[str]) -> None:
    with pytest.raises(SystemExit) as end:
        main(["outlook", *arguments])
    error = capsys.readouterr().err
    assert (end.value.code, said in error, error.count("\n")) == (2, True, 1)
