"""The page's graphs: the report's colours, and no markup in what is written on them."""

from __future__ import annotations

import numpy as np

from seamap_rt.app import figures
from seamap_rt.report import style


def test_colours_are_those_of_the_report() -> None:
    for name in ("BLUE", "VERMILION", "GREEN", "SKY", "ORANGE", "PURPLE", "GREY"):
        assert getattr(figures, name) == getattr(style, name)


def test_a_band_has_a_piece_for_each_run_of_known_values() -> None:
    low = np.array([0.0, 1.0, np.nan, 3.0, 4.0, 5.0])
    (band,) = figures.band(np.arange(6.0), low, low + 1.0, "x", figures.BLUE)
    assert band["x"] == [0.0, 1.0, 1.0, 0.0, None, 3.0, 4.0, 5.0, 5.0, 4.0, 3.0, None]
    assert band["y"][:5] == [0.0, 1.0, 2.0, 1.0, None]


def test_names_hold_no_markup() -> None:
    assert figures.line([0], [0], "<a href='x'>&", figures.BLUE)["name"] == "&lt;a href='x'&gt;&amp;"
    assert figures.layout(False, "<b>")["title"]["text"] == "&lt;b&gt;"
