"""The page's graphs: no markup in what is written on them, and maps that fit the window."""

from __future__ import annotations

import numpy as np
import pytest

from seamap_rt.app import drawing
from seamap_rt.app.drawing import MapPanels, Panel, Scale, ground_raster
from seamap_rt.app.maps_panel import maps_graph
from seamap_rt.report import style


def test_a_band_has_a_piece_for_each_run_of_known_values() -> None:
    low = np.array([0.0, 1.0, np.nan, 3.0, 4.0, 5.0])
    band = drawing.band(np.arange(6.0), low, low + 1.0, "x", style.BLUE)
    assert band["x"] == [0.0, 1.0, 1.0, 0.0, None, 3.0, 4.0, 5.0, 5.0, 4.0, 3.0, None]
    assert band["y"][:5] == [0.0, 1.0, 2.0, 1.0, None]


def test_names_hold_no_markup() -> None:
    assert drawing.line([0], [0], "<a href='x'>&", style.BLUE)["name"] == "&lt;a href='x'&gt;&amp;"
    assert drawing.layout(False, "<b>")["title"]["text"] == "&lt;b&gt;"


@pytest.mark.parametrize("window", [(1400, 900), (1900, 1000), (1280, 720), (390, 844)])
@pytest.mark.parametrize("count", [1, 2, 3, 4, 6])
def test_maps_stand_on_one_screen_on_what_is_seen(window: tuple[int, int], count: int) -> None:
    """All of them, as high as the window leaves them room; on a phone one below the other. What is shown first is the
    part in which all panels have values, here 100 m about the antenna."""
    side = np.linspace(-400.0, 400.0, 101)
    distance = np.hypot(*np.meshgrid(side, side))
    fields = [np.where(distance < (400.0 if i == 0 else 100.0), 1.0, np.nan) for i in range(count)]
    raster = ground_raster(side, side, distance < 400.0)
    shown = MapPanels.of(
        [Panel(f"map {i}", Scale(-1.0, 1.0, "RdBu", "Height (m)")) for i in range(count)], raster, fields
    )
    look = maps_graph(shown, *window, dark=False)["layout"]
    reach = 400.0 if count == 1 else 110.0
    assert look["xaxis"]["range"] == pytest.approx([-reach, reach], abs=0.1 * reach)
    lefts = {look[name]["domain"][0] for name in look if name.startswith("xaxis")}
    if window[0] < 640:
        assert len(lefts) == 1
    else:
        assert look["height"] <= window[1] - 230  # what stands above: the place's head, the turns, the tabs
        assert len(lefts) > 1 or count == 1
