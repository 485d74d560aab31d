"""What evolves is shown evolving: an animation with the turns in it, small enough; each turn judged; gauges drawn."""

from __future__ import annotations

import html
import io
import re
from itertools import pairwise
from pathlib import Path
from typing import Any

import numpy as np
import pytest
import xarray as xr
from made_run import Run, small, values
from matplotlib.axes import Axes
from matplotlib.container import ErrorbarContainer
from numpy.testing import assert_allclose, assert_array_equal
from PIL import Image

from seamap_rt import dataset
from seamap_rt.gauges import GaugeSpectra, judge, spectra
from seamap_rt.metrics import error_figures
from seamap_rt.report import evolution, gauge_figures, style
from seamap_rt.report.page import write_report


@pytest.fixture(autouse=True)
def _coarse_pictures(monkeypatch: pytest.MonkeyPatch) -> None:
    """Fewer pixels: nothing here looks at those of figures."""
    monkeypatch.setattr(style, "DPI", 40)


@pytest.fixture(scope="module")
def run() -> Run:
    """Five turns of a sector, whose heights differ from turn to turn."""
    made = Run(small(turns=5, radar__sector_deg=[240.0, 300.0]))
    for tree in (made.truth, made.maps):
        for turn in range(5):
            values(tree, "ground/height")[turn] *= np.cos(0.8 * turn)
    return made


def frames(data: bytes) -> list[np.ndarray]:
    """Pixels (row, column, 3) of each frame."""
    film, found = Image.open(io.BytesIO(data)), []
    for number in range(getattr(film, "n_frames", 1)):
        film.seek(number)
        found.append(np.asarray(film.convert("RGB")).astype(int))
    return found


# ---------------------------------------------------------------------------------------------------- the animation


def test_it_has_a_frame_for_each_turn(run: Run) -> None:
    film = evolution.animation(run.scene, run.maps, run.truth)
    assert film.shown == 5
    shown = frames(film.data)
    assert len(shown) == 5
    for one, other in pairwise(shown):
        assert np.abs(one - other).max() > 50


def test_truth_is_on_the_left_and_the_map_on_the_right(run: Run) -> None:
    """A map that is changed in one turn changes its own half of that turn's frame, and nothing else."""
    before = frames(evolution.animation(run.scene, run.maps, run.truth).data)
    for side, tree in (("left", run.truth), ("right", run.maps)):
        changed = tree.copy(deep=True)
        height = values(changed, "ground/height")[3]
        height[np.isfinite(height)] *= -1.0
        trees = (run.maps, changed) if side == "left" else (changed, run.truth)
        after = frames(evolution.animation(run.scene, *trees).data)
        for turn, (one, other) in enumerate(zip(before, after, strict=True)):
            rows, columns, _ = np.nonzero(np.abs(one - other) > 40)
            assert bool(rows.size) == (turn == 3)
            if turn == 3:
                half = one.shape[1] // 2
                assert (columns < half).all() if side == "left" else (columns > half).all()


def test_it_shrinks_until_it_fits_and_says_what_it_skips(run: Run, monkeypatch: pytest.MonkeyPatch) -> None:
    whole = evolution.animation(run.scene, run.maps, run.truth)
    smaller = evolution.animation(run.scene, run.maps, run.truth, len(whole.data) // 2)
    assert len(smaller.data) <= len(whole.data) // 2
    assert smaller.shown == 5
    assert frames(smaller.data)[0].shape[1] < frames(whole.data)[0].shape[1]
    least = evolution.animation(run.scene, run.maps, run.truth, 1)  # which nothing fits: as small as it gets
    assert (least.shown, least.faster) == (1, 8.0 * whole.faster)
    fewer = evolution.animation(run.scene, run.maps, run.truth, 3 * len(least.data))
    assert len(fewer.data) <= 3 * len(least.data)
    assert (fewer.shown, fewer.faster) == (3, 2.0 * whole.faster)
    assert frames(fewer.data)[0].shape == frames(least.data)[0].shape  # turns go when frames get no smaller
    monkeypatch.setattr(evolution, "MOST_FRAMES", 3)
    (picture,) = evolution.film(run.scene, run.maps, run.truth)
    assert "3 of 5 turns, the others are skipped" in picture.caption


def test_it_plays_no_slower_than_the_sea(run: Run) -> None:
    for rpm, wait, faster in ((60.0, 400, 2.5), (12.0, 400, 12.5), (120.0, 400, 1.25)):
        scene = run.scene.model_copy(update={"radar": run.scene.radar.model_copy(update={"rotation_rpm": rpm})})
        film = evolution.animation(scene, run.maps, run.truth)
        assert Image.open(io.BytesIO(film.data)).info["duration"] == wait
        assert_allclose(film.faster, faster)


@pytest.fixture(scope="module")
def page(run: Run, tmp_path_factory: pytest.TempPathFactory) -> Path:
    """The page of five turns and two gauges."""
    series = a_record(60, 20)
    metrics: dict[str, Any] = run.metrics | {"gauges": judge(series)}
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(style, "DPI", 40)
        folder = tmp_path_factory.mktemp("page")
        return write_report(folder, run.scene, run.maps, run.truth, metrics, run.echoes, series)


def test_the_page_holds_it_and_needs_no_other_file(page: Path) -> None:
    text = page.read_text("utf-8")
    assert text.count("data:image/gif;base64,") == 1
    assert len(re.findall(r"data:image/gif;base64,([^\"]*)", text)[0]) < 3_000_000
    assert len(frames(page.with_name("evolution.gif").read_bytes())) == 5
    assert "all 5 turns, 2.5 times as fast as the sea" in text


def test_a_single_turn_does_not_evolve(tmp_path: Path) -> None:
    one = Run(small(radar__sector_deg=[240.0, 300.0]))
    text = write_report(tmp_path, one.scene, one.maps, one.truth, one.metrics, one.echoes).read_text("utf-8")
    page = re.sub(r"base64,[^\"]*", "", text)
    for words in ("evolution", "image/gif", "Turn by turn", "turn by turn"):
        assert words not in page
    assert not list(tmp_path.glob("*.gif"))


# -------------------------------------------------------------------------------------------------------- the table


def test_each_turn_is_judged_as_the_metrics_judge_it(run: Run) -> None:
    (table,) = evolution.turn_table(run.maps, run.truth)
    assert len(table.rows) == 5
    columns = {title: [row[number] for row in table.rows] for number, title in enumerate(table.head)}
    for turn in range(5):
        trees = [
            xr.DataTree.from_dict({"/polar": tree["polar"].to_dataset().isel(turn=[turn])})
            for tree in (run.maps, run.truth)
        ]
        overall = error_figures(*trees)["overall"]
        for title, key in (
            ("Height error, rms (m)", "height_rmse_m"),
            ("Robust (m)", "height_robust_m"),
            ("Correlation", "height_correlation"),
        ):
            assert columns[title][turn] == f"{overall[key]:.3f}"
        assert columns["Hs true (m)"][turn] == f"{overall['hs_true_m']:.2f}"
        visible = values(run.truth, "polar/visible_fraction")[turn]
        inside = (run.range >= 50.0) & (run.range <= 200.0)
        known = np.isfinite(values(run.maps, "polar/height")[turn]) & (visible > 0.5)
        share = known[:, inside].sum() / (visible > 0.5)[:, inside].sum()
        assert columns["Answered"][turn] == f"{100.0 * share:.0f} %"
    assert columns["Turn"] == ["1", "2", "3", "4", "5"]


def test_a_turn_without_a_cell_has_dashes(run: Run) -> None:
    dark = run.truth.copy(deep=True)
    values(dark, "polar/visible_fraction")[2] = 0.0
    (table,) = evolution.turn_table(run.maps, dark)
    assert table.rows[2][3:7] == ["—"] * 4
    assert table.rows[2][-1] == "—"
    assert "—" not in table.rows[1]


def test_of_very_many_turns_some_are_listed(run: Run, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(evolution, "MOST_ROWS", 2)
    (table,) = evolution.turn_table(run.maps, run.truth)
    assert [row[0] for row in table.rows] == ["1", "4"]
    assert "Every 3. turn of 5" in table.note


# -------------------------------------------------------------------------------------------------------- the gauges


def a_record(turns: int = 60, holes: int = 0) -> xr.Dataset:
    """Two gauges; the second one's radar reads 0.8 of the wire and flags every tenth height."""
    time, seen = np.arange(4 * turns) / 4.0, np.arange(turns) + 0.3
    wire, true = (np.stack([0.5 * np.sin(t), 0.4 * np.cos(1.1 * t)]) for t in (time, seen))
    quality = np.zeros((2, turns), dtype=np.int16)
    quality[1, ::10] = 8
    height = true * np.array([[1.0], [0.8]])
    height[0, :holes] = np.nan
    series = dataset.build(
        "gauges",
        {
            "east": [-60.0, -80.0], "north": [0.0, 5.0], "true_height": wire, "seen_time": np.stack((seen, seen)),
            "height": height, "height_std": np.full((2, turns), 0.07), "quality": quality, "seen_true_height": true,
            "seen_cell_height": 0.95 * true,
        },
        {"turn": np.arange(turns), "time": time},
    )  # fmt: skip
    return series.assign_coords(gauge=["inner", "outer"])


def bars(axes: Axes) -> dict[str, ErrorbarContainer]:
    return {str(item.get_label()): item for item in axes.containers if isinstance(item, ErrorbarContainer)}


def test_heights_are_drawn_at_their_times_with_their_errors() -> None:
    series = a_record().isel(gauge=1)
    record, *_ = gauge_figures.gauge_figure(series).axes
    drawn = bars(record)
    assert drawn.keys() == {"radar", "radar, flagged"}
    sound = series["quality"].values == 0
    for label, members in (("radar", sound), ("radar, flagged", ~sound)):
        line, _, (sticks,) = drawn[label].lines
        assert line is not None
        assert_array_equal(np.asarray(line.get_xdata()), series["seen_time"].values[members])
        assert_allclose(np.asarray(line.get_ydata()), series["height"].values[members])
        ends = np.array([np.ptp(stick[:, 1]) for stick in sticks.get_segments()])
        assert_allclose(ends, 2.0 * 1.96 * 0.07, rtol=1e-5)
    wire = next(line for line in record.lines if line.get_label() == "wire")
    assert_array_equal(np.asarray(wire.get_ydata()), series["true_height"].values)


def test_the_radars_spectrum_ends_at_half_the_turn_rate() -> None:
    figure = gauge_figures.gauge_figure(a_record().isel(gauge=0))
    _, spectrum, _ = figure.axes
    lines = {str(line.get_label()): np.asarray(line.get_xdata()) for line in spectrum.lines}
    assert lines["radar"].max() < 0.5
    assert lines["wire, once a turn"].max() < 0.5
    assert 0.5 < lines["wire"].max() <= 1.0  # how much folds is there to see
    assert any("half the turn rate" in text.get_text() for text in spectrum.texts)


@pytest.mark.parametrize(("turns", "holes", "words"), [(20, 0, "too short"), (60, 30, "30 of 60 turns have no height")])
def test_a_spectrum_that_is_not_there_is_said(turns: int, holes: int, words: str) -> None:
    series = a_record(turns, holes)
    picture, _ = gauge_figures.gauge_pictures(series)
    assert words in picture.caption
    spectrum = gauge_figures.gauge_figure(series.isel(gauge=0)).axes[1]
    assert "radar" not in [line.get_label() for line in spectrum.lines]
    found = spectra(series.isel(gauge=0))
    assert isinstance(found, GaugeSpectra) == (turns == 60)


def test_the_regression_is_drawn_with_its_slope() -> None:
    pairs = gauge_figures.gauge_figure(a_record().isel(gauge=1)).axes[2]
    line = pairs.lines[-1]
    x, y = np.asarray(line.get_xdata()), np.asarray(line.get_ydata())
    assert_allclose(np.diff(y) / np.diff(x), 0.8, rtol=1e-6)
    assert any("slope 0.80" in text.get_text() for text in pairs.texts)


def test_a_gauge_without_any_height_is_still_drawn() -> None:
    figure = gauge_figures.gauge_figure(a_record(60, 60).isel(gauge=0))
    assert any("no height" in text.get_text() for axes in figure.axes for text in axes.texts)
    style.png(figure)


def test_the_page_has_the_gauges_pictures_and_table(page: Path) -> None:
    text = html.unescape(page.read_text("utf-8"))
    for words in ("Wave gauge: inner", "Wave gauge: outer", "Wave gauges", "half the turn rate", "0.80"):
        assert words in text
    assert "inner: 20 of 60 turns have no height here" in text
    assert page.with_name("gauge_1.png").exists()
    assert gauge_figures.gauge_pictures(None) == gauge_figures.gauge_table({"gauges": []}) == []


def test_many_gauges_are_all_in_the_table_and_the_first_are_drawn(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(gauge_figures, "MOST_DRAWN", 1)
    series = a_record()
    assert len(gauge_figures.gauge_pictures(series)) == 1
    (table,) = gauge_figures.gauge_table({"gauges": judge(series)})
    assert [row[0] for row in table.rows] == ["inner", "outer"]
    assert "Figures show the first 1 gauges" in table.note
