"""Tables and figures of a notebook: one line each, the same as a report's."""

from __future__ import annotations

from collections.abc import Callable
from html import unescape
from typing import Any, cast

import numpy as np
import pytest
from matplotlib.figure import Figure

import seamap_rt as sr
from seamap_rt.report import style


@pytest.fixture(scope="module")
def made() -> dict[str, Any]:
    """A short run of a small scene, its maps, and the field and the forecast that come of them."""
    scene = sr.load_scene("tiny", {"tracing.tracer": "horizon", "turns": 2, "radar.range_m": [15.0, 90.0]})
    simulation = sr.simulate(scene)
    maps = sr.retrieve(simulation.echoes)
    field = sr.reconstruct(maps)
    return {"scene": scene, "simulation": simulation, "maps": maps, "field": field, "coming": sr.forecast(field)}


FIGURES: dict[str, tuple[Callable[[dict[str, Any]], Figure], list[str]]] = {
    "height_map": (lambda made: sr.figures.height_map(made["maps"]), ["Height (m)", "Standard error (m)"]),
    "error_by_range": (
        lambda made: sr.figures.error_by_range(made["maps"], made["simulation"].truth),
        ["Height error (m)", "Range (m)"],
    ),
    "wave_field": (lambda made: sr.figures.wave_field(made["field"]), ["Height (m)", "Standard error (m)"]),
    "forecast": (lambda made: sr.figures.forecast(made["coming"]), ["Time from now (s)", "Height at the boat (m)"]),
    "advice": (lambda made: sr.figures.advice(advised(made, [0.0, 3.0])), ["Roll, rms (°)"]),
}


def advised(made: dict[str, Any], speeds: list[float]) -> Any:
    return sr.advise(made["field"], sr.prediction.Follower(), range(0, 360, 90), speeds, 10.0, draws=20)


@pytest.mark.parametrize("name", FIGURES)
def test_a_figure_draws_with_units_on_its_axes(name: str, made: dict[str, Any]) -> None:
    draw, labels = FIGURES[name]
    figure = draw(made)
    axes = [text for each in figure.axes for text in (each.get_xlabel(), each.get_ylabel())]
    assert set(labels) <= set(axes)
    assert len(style.png(figure)) > 10_000


def test_a_wave_field_is_drawn_as_it_says_of_itself(made: dict[str, Any]) -> None:
    """A point of the picture is the field's own elevation there and then."""
    field = made["field"]
    image = sr.figures.wave_field(field, time=1.0, spacing_m=5.0).axes[0].images[0]
    picture: Any = image.get_array()
    shown = np.ma.getdata(picture)
    row, column = np.argwhere(~np.ma.getmaskarray(picture))[100]
    west, _, south, _ = image.get_extent()
    x, y = west + 5.0 * (column + 0.5), south + 5.0 * (row + 0.5)
    told = float(field.elevation(x, y, 1.0)[0])  # another number of points is summed to another rounding
    assert float(shown[row, column]) == pytest.approx(told, abs=1e-3 * field.sea_std)


@pytest.mark.parametrize(
    ("draw", "line"),
    [
        (lambda made: sr.figures.height_map(made["maps"], 2), r"turn = 2: must be from -2 to 1"),
        (lambda made: sr.figures.height_map(cast(Any, 3)), r"maps: is a int, must be a DataTree"),
        (lambda made: sr.figures.wave_field(made["maps"]), r"field: is a DataTree, must be a WaveField"),
        (lambda made: sr.figures.wave_field(made["field"], spacing_m=0.0), r"spacing_m = 0: must be"),
        (lambda made: sr.figures.forecast(made["coming"], place=1), r"place = 1: must be"),
        (lambda made: sr.figures.forecast(cast(Any, None)), r"coming: is None, must be a Dataset"),
        (lambda made: sr.figures.advice(advised(made, [3.0])), r"advised: must be of headings .* two rising speeds"),
    ],
)
def test_what_cannot_be_drawn_is_refused(draw: Callable[[dict[str, Any]], Figure], line: str, made: Any) -> None:
    with pytest.raises(sr.InputError, match=line):
        draw(made)


@pytest.mark.parametrize("name", ["scene", "simulation", "field"])
def test_what_one_looks_at_is_a_short_table(name: str, made: dict[str, Any]) -> None:
    """At most twelve lines of a terminal's width, and the same words in a notebook."""
    lines = repr(made[name]).splitlines()
    assert 4 <= len(lines) <= 12
    assert max(map(len, lines)) <= 120
    table = made[name]._repr_html_()
    assert table.startswith("<table>")
    for label, words in made[name].rows():
        assert f"<th>{label}</th>" in table
        assert words in unescape(table)
    assert any(f" {unit}" in repr(made[name]) for unit in ("m", "s", "Hz"))


def test_a_table_in_a_notebook_runs_no_markup_of_a_scene() -> None:
    scene = sr.load_scene("tiny", {"title": "<script>alert(1)</script>"})
    assert "<script" not in scene._repr_html_()
