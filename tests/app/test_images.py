"""Figures of the report on the page: each shows its numbers, and is legible on a light page and on a dark one."""

from __future__ import annotations

import base64
import io
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from made_folders import write_run, write_shadowing
from matplotlib.axes import Axes
from matplotlib.colors import to_rgb
from matplotlib.container import BarContainer
from matplotlib.figure import Figure
from matplotlib.text import Text
from PIL import Image as Opened

from seamap_rt.app.forecast_view import read_ahead
from seamap_rt.app.panels import errors_by_range, range_pictures, read_shadowing
from seamap_rt.app.prospects import _graphs, prospects
from seamap_rt.app.source import Results, Source
from seamap_rt.app.verification import verify_folder
from seamap_rt.app.waves_view import read_gauges
from seamap_rt.report import curves, style
from seamap_rt.report.forecast_figures import (
    ahead_picture,
    next_seconds,
    quiet_windows,
    verified_picture,
    window_picture,
    window_pictures,
)
from seamap_rt.report.gauge_figures import gauge_picture
from seamap_rt.report.page_elements import Picture, draw_images
from seamap_rt.report.spectrum_figures import Density, draw_rose, map_spectra_picture, wave_height, wave_height_pictures
from seamap_rt.scene import load_scene
from seamap_rt.settings import QuietSettings
from seamap_rt.studies.shadowing_figures import draw_shadowing
from seamap_rt.window_errors import Windows

_METRICS = {
    "hs_scene_m": 1.4,
    "sea_state": {"significant_wave_height": [1.5, None, 1.3], "significant_wave_height_std": [0.2, None, 0.1]},
}
_KINDS = (
    "errors",
    "shares",
    "compared",
    "wave height",
    "spectra",
    "gauge",
    "ahead",
    "came",
    "past",
    "windows",
    "study",
)


def _density(peak: float) -> Density:
    frequency, direction = np.linspace(0.05, 0.4, 36), np.arange(7.5, 360.0, 15.0)
    shape = np.exp(-(((frequency - 0.2) / 0.03) ** 2))
    spread = np.exp(-(((direction - 270.0) / 30.0) ** 2))
    return Density(frequency, peak * shape, frequency, direction, peak * shape[:, None] * spread / spread.sum() / 15.0)


@pytest.fixture(scope="module")
def pictures(tmp_path_factory: pytest.TempPathFactory) -> dict[str, Picture]:
    """One of each kind that the page shows."""
    folder = tmp_path_factory.mktemp("runs")
    write_run(folder / "run")
    write_shadowing(folder / "study")
    source, came = Source(Results(folder / "run")), verify_folder(folder / "run")
    told, ahead = errors_by_range(source, 11), read_ahead(folder / "run", 11, QuietSettings())
    assert ahead is not None
    errors, shares = range_pictures({"": told}, prospects(load_scene("tiny", {"turns": 1})))
    study = read_shadowing(folder / "study")
    assert came.windows is not None
    (height,), windows = wave_height_pictures(_METRICS), window_picture(came.windows, 0.9)
    gauge = gauge_picture(0, "west", read_gauges(source.results).sel(gauge="west"), 11)
    found = [errors, shares, range_pictures({"a$b$": told, "b": told})[0], height]
    found += [
        map_spectra_picture(_density(1.0), _density(1.2), (np.array([0.1, 0.4]), np.ones(2)), "Of a turn."),
        gauge,
    ]
    found += [ahead_picture(ahead), ahead_picture(ahead, came.verified.truth[11, :, 0], came.quiet_windows(11))]
    found += [verified_picture(came.verified, 10.0, 11), windows]
    alt = "Visible share of the sea against ground range"
    found.append(Picture("study", "Shadowing", alt, "", lambda: draw_shadowing(study, ("all looks",))))
    return dict(zip(_KINDS, found, strict=True))


def _draw(picture: Picture) -> Figure:
    made = picture.draw()
    assert isinstance(made, Figure)
    return made


def _luminance(colour: Any) -> float:
    parts = np.array(to_rgb(colour))
    return float(np.where(parts <= 0.03928, parts / 12.92, ((parts + 0.055) / 1.055) ** 2.4) @ (0.2126, 0.7152, 0.0722))


def _contrast(one: Any, other: Any) -> float:
    low, high = sorted((_luminance(one), _luminance(other)))
    return (high + 0.05) / (low + 0.05)


@pytest.mark.parametrize("dark", [False, True])
@pytest.mark.parametrize("kind", _KINDS)
def test_every_figure_of_the_page_is_legible_and_has_words(pictures: dict[str, Picture], kind: str, dark: bool) -> None:
    """Black, white and grey words by a contrast of 4.5 over what lies behind (WCAG 2.1); colours by 2.2, which is that
    of the palette's lightest on white."""
    figure = _draw(pictures[kind])
    lines = {line: line.get_color() for axes in figure.axes for line in axes.lines}
    style.png(figure, dark)
    assert (_luminance(figure.get_facecolor()) < 0.1) == dark
    for text in figure.findobj(Text):
        assert isinstance(text, Text)
        if text.get_text() and text.get_visible() and text.get_color() != style.ON_COLOURS:
            grey = np.ptp(to_rgb(text.get_color())) == 0.0
            assert _contrast(text.get_color(), figure.get_facecolor()) > (4.5 if grey else 2.2), text
    for line, before in lines.items():
        if np.ptp(to_rgb(before)) > 0.0:
            assert line.get_color() == before  # colours mean the same on any page
        assert _contrast(line.get_color(), figure.get_facecolor()) > 2.2 or line.get_color() == style.GRID
    assert len(pictures[kind].alt) > 20


@pytest.mark.parametrize("dark", [False, True])
def test_an_image_has_the_width_of_the_page_and_its_words(pictures: dict[str, Picture], dark: bool) -> None:
    (image,) = draw_images([pictures["shares"]], dark)
    assert image.alt == pictures["shares"].alt
    assert Opened.open(io.BytesIO(base64.b64decode(image.source.partition(",")[2]))).size[0] == 936


def _lines(axes: Axes) -> dict[str, np.ndarray]:
    return {str(line.get_label()): np.asarray(line.get_ydata(), dtype=float) for line in axes.lines}


def test_errors_and_shares_are_those_that_are_told(tmp_path: Path) -> None:
    write_run(tmp_path / "run", turns=1)
    source = Source(Results(tmp_path / "run"))
    told, law = errors_by_range(source, 0), prospects(load_scene("tiny", {"turns": 1}))
    error, bias = _draw(range_pictures({"": told}, law)[0]).axes
    np.testing.assert_allclose(_lines(error)["rms"], told.rms)
    np.testing.assert_allclose(_lines(error)["noise of one dwell alone"], law.noise_error_m)
    np.testing.assert_allclose(np.asarray(bias.lines[-1].get_ydata()), told.bias)
    (share,) = _draw(range_pictures({"": told}, law)[1]).axes
    np.testing.assert_allclose(_lines(share)["in sight of both antennas"], 100.0 * told.visible)
    np.testing.assert_allclose(_lines(share)["Smith 1967"], 100.0 * law.smith)
    both = curves.draw_errors({"A": told, "B": told}).axes[0]
    assert {"rms, A", "rms, B", "stated, A", "stated, B"} <= set(_lines(both))
    assert {line.get_color() for line in both.lines} == {style.BLUE, style.VERMILION}


def test_a_designs_graphs_are_those_that_are_told_with_the_kept_one_dashed() -> None:
    scene = load_scene("choppy_sea")
    found, kept = prospects(scene), prospects(load_scene("choppy_sea", {"radar.height_m": 8.0}))
    assert found.ahead is not None
    drawn = {name: curves.draw_graph(graph).axes[0] for name, _, graph in _graphs(found, kept, scene)}
    seen = _lines(drawn["visible"])
    np.testing.assert_allclose(seen["in sight"], 100.0 * found.ahead.profile["visible_fraction"])
    np.testing.assert_allclose(seen["Smith 1967"], 100.0 * found.smith)
    np.testing.assert_allclose(_lines(drawn["error"])["noise of one dwell, kept"], kept.noise_error_m)
    np.testing.assert_allclose(_lines(drawn["snr"])["kept"], kept.snr_db)
    np.testing.assert_allclose(_lines(drawn["cycle"])["kept"], kept.ambiguity_m)
    assert {str(text.get_text()).strip() for text in drawn["beam"].texts} == {"20 m", "50 m", "400 m"}
    for axes in drawn.values():
        dashed = {str(each.get_label()) for each in axes.lines if each.get_linestyle() == "--"}
        assert {name for name in _lines(axes) if name.endswith("kept")} == dashed - {"Smith 1967"}


def test_a_designs_spectrum_stands_where_its_waves_come_from() -> None:
    spectrum = prospects(load_scene("choppy_sea")).spectrum
    axes = draw_rose(spectrum.frequency, spectrum.direction, spectrum.density, [(0.2, 90.0, 1.5)], 3.9).axes[0]
    mesh = axes.collections[0]
    values, corners = np.asarray(mesh.get_array()), np.asarray(mesh.get_coordinates())  # type: ignore[attr-defined]
    row, column = np.unravel_index(values.argmax(), values.shape)
    middle = corners[row : row + 2, column : column + 2].mean(axis=(0, 1))
    assert np.degrees(middle[0]) == pytest.approx(270.0, abs=2.6)  # half a bin
    assert middle[1] == pytest.approx(1.0 / 5.5, rel=0.05)
    assert axes.lines[0].get_xydata()[0] == pytest.approx([0.5 * np.pi, 0.2])  # type: ignore[index]


def test_a_wave_height_stands_at_its_turn_beside_the_scenes() -> None:
    (axes,) = wave_height(_METRICS).axes
    lines = _lines(axes)
    np.testing.assert_array_equal(lines["by the maps, ± 1.96 stated errors"], [1.5, np.nan, 1.3])
    np.testing.assert_array_equal(lines["of the scene"], [1.4, 1.4])
    assert wave_height_pictures({}) == wave_height_pictures({"sea_state": {"significant_wave_height": [None]}}) == []


def test_both_spectra_are_on_one_scale_from_where_the_waves_come(pictures: dict[str, Picture]) -> None:
    figure = _draw(pictures["spectra"])
    over, true, _, mapped = figure.axes
    assert set(_lines(over)) == {"of the design", "True sea", "By the maps"}
    assert true.collections[0].get_clim() == mapped.collections[0].get_clim()
    for axes, peak in ((true, 1.2), (mapped, 1.0)):
        mesh = axes.collections[0]
        values = np.asarray(mesh.get_array())
        corners = np.asarray(mesh.get_coordinates())  # type: ignore[attr-defined]
        row, column = np.unravel_index(values.argmax(), values.shape)
        middle = corners[row : row + 2, column : column + 2].mean(axis=(0, 1))
        assert np.degrees(middle[0]) == pytest.approx(270.0, abs=7.6)  # half a bin
        assert middle[1] == pytest.approx(0.2, abs=0.006)
        assert values.max() == pytest.approx(peak * _density(1.0).directional.max())  # type: ignore[union-attr]


def test_bars_of_windows_are_their_chances_filled_where_a_quiet_one_came(tmp_path: Path) -> None:
    write_run(tmp_path / "run")
    ahead, came = read_ahead(tmp_path / "run", 11, QuietSettings(elevation_m=0.3)), verify_folder(tmp_path / "run")
    assert ahead is not None
    quiet = came.quiet_windows(11)
    assert quiet is not None
    height, chance = next_seconds(ahead, came.verified.truth[11, :, 0], quiet).axes
    np.testing.assert_allclose(_lines(height)["forecast"], ahead.elevation_m)
    np.testing.assert_allclose(_lines(height)["the sea that came"], came.verified.truth[11, :, 0])
    assert sum(line.get_linestyle() == ":" for line in height.lines) == 2  # the limit, above and below
    bars = {str(each.get_label()): each for each in chance.containers if isinstance(each, BarContainer)}
    for name, members in (("it was quiet", quiet == 1.0), ("it was not", quiet == 0.0)):
        if members.any():
            shown = [(bar.get_x() + 0.5 * bar.get_width(), bar.get_height()) for bar in bars[name]]
            np.testing.assert_allclose(shown, np.stack([ahead.lead_s, 100.0 * ahead.chance], axis=1)[members])
    before = next_seconds(ahead).axes[1]
    labels = {str(each.get_label()) for each in before.containers}
    assert labels == {"not called"}  # of 50 %, less than the 90 % that is asked for


@pytest.mark.parametrize(("quiet", "words"), [(True, "all windows were quiet"), (False, "no window was quiet")])
def test_windows_of_one_kind_have_no_false_alarms_and_say_so(quiet: bool, words: str) -> None:
    windows = Windows(np.array([0.2, 0.95, 0.5]), np.full(3, quiet), {"persistence": np.zeros(3)})
    hits, classes = quiet_windows([windows], 0.9).axes
    assert [text.get_text() for text in hits.texts] == [words]
    assert [str(each.get_text()) for each in classes.texts] == ["1", "1", "1"]
    assert window_pictures(windows, 0.9) == []  # a report has none
