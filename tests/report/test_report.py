"""The report: whole, self-contained, the right way up, and unmoved by hard cases."""

from __future__ import annotations

import html
import re
from html.parser import HTMLParser
from pathlib import Path
from typing import Any

import numpy as np
import pytest
import xarray as xr
from matplotlib.axes import Axes
from matplotlib.collections import QuadMesh
from matplotlib.figure import Figure
from matplotlib.lines import Line2D
from matplotlib.patches import Rectangle
from numpy.testing import assert_allclose

from seamap_rt import dataset
from seamap_rt.conventions import unit_from_azimuth
from seamap_rt.radar.scan import look_sweeps, pulses
from seamap_rt.report import (
    echo_power,
    error_against_range,
    height_maps,
    height_scatter,
    page,
    reduce,
    slope_maps,
    style,
    timing,
    visible_share,
    write_report,
)
from seamap_rt.report import maps as drawn_maps
from seamap_rt.scene import Scene, load_scene

PICTURES = (
    "height_maps",
    "slope_maps",
    "error_against_range",
    "height_scatter",
    "visible_share",
    "echo_power",
    "timing",
)
NOISE_W = 8e-13


class Run:
    """A made-up run: a long-crested wave from the west, noise that grows with range, shadow behind its crests."""

    def __init__(self, scene: Scene, seed: int = 0, waves: float = 1.0, lit: bool = True, noise: float = 1.0) -> None:
        self.scene = scene
        self.random = np.random.default_rng(seed)
        self.amplitude, self.noise, self.lit = 0.5 * waves, 0.08 * noise, lit
        self.turn = np.arange(scene.turns)
        radar = scene.radar
        self.azimuth = (radar.sector_deg[0] + look_sweeps(radar.sector_deg, scene.retrieval.cell_azimuth_deg)) % 360.0
        self.range = np.arange(radar.range_m[0], radar.range_m[1] + 1e-9, radar.range_sampling_m)
        side = scene.retrieval.ground_m
        half = side * np.ceil(scene.far_ground_range / side)
        self.x = self.y = np.arange(-half + 0.5 * side, half, side)
        polar_east, polar_north = (part[:, None] for part in unit_from_azimuth(self.azimuth))
        ground = reduce.ground_range(self.range, radar.height_m)
        self.polar_shape = (scene.turns, self.azimuth.size, self.range.size)
        polar = self._surface(polar_east * ground, polar_north * ground, ground, self.polar_shape)
        x, y = np.meshgrid(self.x, self.y)
        distance = np.hypot(x, y)
        self.ground_shape = (scene.turns, *x.shape)
        flat = self._surface(x, y, distance, self.ground_shape)
        start, stop = radar.sector_deg
        sweep = (np.degrees(np.arctan2(x, y)) - start) % 360.0
        outside = (distance > scene.far_ground_range) | (distance < radar.range_m[0]) | (sweep > stop - start)
        for name in ("height", "slope_x", "seen", "retrieved", "spread"):
            flat[name] = np.where(outside, np.nan, flat[name])
        self.truth = self._truth(polar, flat, polar_east)
        self.maps = self._maps(polar, flat, polar_east)
        self.echoes = self._echoes()
        self.metrics = self._metrics()

    def _surface(self, x: Any, y: Any, distance: Any, shape: tuple[int, ...]) -> dict[str, np.ndarray]:
        phase = np.broadcast_to(2.0 * np.pi * x / 47.0 + 0.0 * y, shape)
        height = self.amplitude * np.cos(phase)
        slope_x = -self.amplitude * 2.0 * np.pi / 47.0 * np.sin(phase)
        reach = np.clip((distance - 70.0) / 150.0, 0.0, 0.9)
        hidden = self.random.random(shape) * np.clip(self.amplitude / 0.5, 0.0, 1.0) * (0.6 - 0.5 * np.cos(phase + 0.8))
        seen = np.where(hidden < 1.0 - reach, 1.0, 0.1) if self.lit else np.zeros(shape)
        spread = np.broadcast_to(self.noise * (0.3 + distance / 120.0), shape)
        error = self.random.normal(size=shape) * spread
        retrieved = np.where(seen > 0.5, height + error, np.nan)
        return {"height": height, "slope_x": slope_x, "seen": seen, "retrieved": retrieved,
                "spread": np.where(seen > 0.5, spread, np.nan)}  # fmt: skip

    def _truth(self, polar: dict[str, Any], flat: dict[str, Any], east: np.ndarray) -> xr.DataTree:
        values = {
            "height": polar["height"],
            "height_weighted": polar["height"],
            "height_visible": np.where(polar["seen"] > 0.0, polar["height"], np.nan),
            "visible_fraction": polar["seen"],
            "slope_range": polar["slope_x"] * east,
            "slope_azimuth": polar["slope_x"] * 0.0,
            "nrcs_db": np.full(self.polar_shape, -40.0),
            "time": np.zeros(self.polar_shape[:2]),
        }
        ground = {
            "height": flat["height"],
            "slope_x": flat["slope_x"],
            "slope_y": flat["slope_x"] * 0.0,
            "time": np.zeros(self.ground_shape),
        }
        return self._tree("truth", values, ground)

    def _maps(self, polar: dict[str, Any], flat: dict[str, Any], east: np.ndarray) -> xr.DataTree:
        like = np.full(self.polar_shape, 1.0)
        values = {
            "height": polar["retrieved"],
            "height_std": polar["spread"],
            "slope_range": polar["slope_x"] * east,
            "slope_azimuth": polar["slope_x"] * 0.0,
            "ground_range": like * reduce.ground_range(self.range, self.scene.radar.height_m),
            "coherence": like,
            "phase": like,
            "phase_unwrapped": like,
            "snr_db": like,
            "time": np.zeros(self.polar_shape[:2]),
            "quality": np.zeros(self.polar_shape, dtype=np.int16),
        }
        noisy = flat["slope_x"] + 0.03 * self.random.normal(size=self.ground_shape)
        ground = {
            "height": flat["retrieved"],
            "height_std": flat["spread"],
            "slope_x": np.where(np.isfinite(flat["retrieved"]), noisy, np.nan),
            "slope_y": np.where(np.isfinite(flat["retrieved"]), noisy - flat["slope_x"], np.nan),
            "time": np.zeros(self.ground_shape),
        }
        return self._tree("maps", values, ground)

    def _tree(self, product: str, polar: dict[str, Any], ground: dict[str, Any]) -> xr.DataTree:
        return xr.DataTree.from_dict(
            {
                "/polar": dataset.build(
                    f"{product}/polar", polar, {"turn": self.turn, "azimuth": self.azimuth, "range": self.range}
                ),
                "/ground": dataset.build(f"{product}/ground", ground, {"turn": self.turn, "y": self.y, "x": self.x}),
            }
        )

    def _echoes(self) -> xr.Dataset:
        scene, fired = self.scene, [pulses(self.scene.radar, turn) for turn in range(self.scene.turns)]
        azimuth = np.concatenate([one.azimuth for one in fired])
        east, _ = unit_from_azimuth(azimuth)
        count = azimuth.size
        power = 1e-9 * (self.range / 30.0) ** -4 * np.exp(0.8 * np.cos(0.13 * self.range * east[:, None])) * self.lit
        voltage = self.random.normal(size=(count, 2, self.range.size, 2)).astype(np.float32)
        voltage = voltage.view(np.complex64)[..., 0] * np.sqrt(0.5 * (power + NOISE_W))[:, None, :].astype(np.float32)
        attrs: dict[str, Any] = dict.fromkeys(dataset.ECHO_ATTRIBUTES, 0.0)
        attrs |= {"noise_power_w": NOISE_W, "complete_turns": scene.turns, "height_m": scene.radar.height_m}
        return dataset.build(
            "echoes",
            {
                "time": np.concatenate([one.time for one in fired]),
                "azimuth": azimuth,
                "transmitter": np.concatenate([one.transmitter for one in fired]),
                "turn": np.repeat(self.turn, [one.azimuth.size for one in fired]),
                "voltage": voltage,
                "position": np.zeros((count, 2, 3)),
                "attitude": np.zeros((count, 3)),
            },
            {"pulse": np.concatenate([one.number for one in fired]), "range": self.range},
            attrs,
        )

    def _metrics(self) -> dict[str, Any]:
        centres = np.arange(25.0, self.scene.radar.range_m[1], 20.0)
        error = self.noise * (0.3 + centres / 120.0)
        return {
            "range_m": centres.tolist(),
            "height_rmse_m": (1.1 * error).tolist(),
            "height_robust_m": error.tolist(),
            "height_bias_m": [None, *(0.1 * error[1:]).tolist()],
            "slope_rmse": (0.3 * error).tolist(),
            "visible_fraction": np.linspace(1.0, 0.7, centres.size).tolist(),
            "overall": {
                "height_rmse_m": 0.1234,
                "height_robust_m": 0.0987,
                "height_bias_m": -0.0123,
                "height_correlation": 0.9511,
                "hs_true_m": 1.414,
                "hs_retrieved_m": 1.466,
            },
            "timing_s": {
                "first": {
                    "sea": 1.2,
                    "mesh": 0.4,
                    "trace": 3.1,
                    "echoes": 2.2,
                    "retrieve": 0.6,
                    "write": 0.2,
                    "total": 7.7,
                },
                "warm": {
                    "sea": 0.1,
                    "mesh": 0.3,
                    "trace": 0.5,
                    "echoes": 1.1,
                    "retrieve": 0.5,
                    "write": 0.2,
                    "total": 2.7,
                },
            },
            "real_time_factor": 0.5,
            "facets": 1_234_567,
            "rays": 2_469_134,
            "peak_memory_bytes": 1.9e9,
            "modelled": [{"what": "Shadowing", "why": "at 1° grazing it decides what is seen"}],
            "left_out": [{"what": "Breaking <waves>", "why": "no model is trusted at X band & low grazing"}],
        }


TINY = {"retrieval.cell_azimuth_deg": 6.0, "radar.prf_hz": 600.0, "radar.range_sampling_m": 2.5, "sea.extent_m": 512.0}


def small(**overrides: Any) -> Scene:
    """choppy_sea with coarse cells out to 200 m: quick, and still a full circle."""
    keys = {key.replace("__", "."): value for key, value in overrides.items()}
    return load_scene("choppy_sea", {**TINY, "radar.range_m": [15.0, 200.0], "retrieval.ground_m": 6.0, **keys})


@pytest.fixture(autouse=True)
def _coarse_pictures(request: pytest.FixtureRequest, monkeypatch: pytest.MonkeyPatch) -> None:
    """Fewer pixels, except where the page's size is tested: nothing else here looks at pixels."""
    if "page_is_whole" not in request.node.name:
        monkeypatch.setattr(style, "DPI", 40)


@pytest.fixture(scope="module")
def run() -> Run:
    return Run(small())


class _Resources(HTMLParser):
    """Everything that a page would load."""

    def __init__(self) -> None:
        super().__init__()
        self.images: list[dict[str, str | None]] = []
        self.loaded: list[str] = []
        self.tags: list[str] = []

    def handle_starttag(self, tag: str, attrs: list[tuple[str, str | None]]) -> None:
        self.tags.append(tag)
        self.loaded += [value or "" for name, value in attrs if name in ("src", "href", "srcset", "data", "action")]
        if tag == "img":
            self.images.append(dict(attrs))


def values(tree: xr.DataTree, path: str) -> np.ndarray:
    """The array of group/name, to be read or written."""
    group, name = path.split("/")
    return tree[group].dataset[name].values


def along(line: Line2D, axis: str) -> np.ndarray:
    return np.asarray(line.get_xdata() if axis == "x" else line.get_ydata())


def shown(axes: Axes) -> np.ma.MaskedArray[Any, Any]:
    """The values of the map that axes show."""
    return np.ma.asarray(axes.images[0].get_array())


def images_of(figure: Figure) -> list[Axes]:
    """Axes of the figure that hold a map, in the order in which they were drawn."""
    return [axes for axes in figure.axes if axes.images and axes.get_aspect() == 1.0]


# ------------------------------------------------------------------------------------------------------ the page


def test_page_is_whole_and_needs_no_other_file(run: Run, tmp_path: Path) -> None:
    path = write_report(tmp_path / "new" / "folder", run.scene, run.maps, run.truth, run.metrics, run.echoes)
    assert path.name == "report.html"
    assert sorted(item.name for item in path.parent.iterdir()) == sorted(
        ["report.html", *(f"{name}.png" for name in PICTURES)]
    )
    text = path.read_text(encoding="utf-8")
    assert len(text) < 6_000_000
    found = _Resources()
    found.feed(text)
    assert len(found.images) == len(PICTURES)
    assert all((image["src"] or "").startswith("data:image/png;base64,") for image in found.images)
    assert all(len(image["alt"] or "") > 20 for image in found.images)
    assert all(address.startswith("data:") for address in found.loaded)
    assert "script" not in found.tags
    without_pictures = re.sub(r"base64,[^\"]*", "", text)
    assert not re.search(r"https?://|url\(|@import|//[a-z]+\.", without_pictures)
    for name in PICTURES:
        assert f'<figure id="{name}">' in text
        assert (path.parent / f"{name}.png").read_bytes().startswith(b"\x89PNG\r\n")


def test_page_says_the_headline_figures_and_the_scene(run: Run, tmp_path: Path) -> None:
    text = write_report(tmp_path, run.scene, run.maps, run.truth, run.metrics, run.echoes).read_text(encoding="utf-8")
    plain = html.unescape(re.sub(r"base64,[^\"]*", "", text))
    for words in ("0.123 m", "0.099 m", "−0.012 m", "0.951", "1.41 m", "1.47 m", "1 234 567", "1.90 GB"):
        assert words in plain, words
    for distance in (100.0, 160.0):
        share = reduce.visible_at(run.truth, run.scene.radar.height_m, distance)
        assert 0.2 < share <= 1.0
        assert f"{100.0 * share:.0f} % " in plain
    assert run.scene.to_toml() in plain
    assert "Breaking <waves>" in plain
    assert "Breaking &lt;waves&gt;" in text
    assert "Shadowing" in plain
    assert "at 1° grazing it decides what is seen" in plain
    assert "Turn by turn" not in plain


def test_a_failed_drawing_leaves_the_old_page_and_no_scraps(run: Run, tmp_path: Path, monkeypatch: Any) -> None:
    path = write_report(tmp_path, run.scene, run.maps, run.truth, run.metrics, run.echoes)
    before = {item.name: item.read_bytes() for item in tmp_path.iterdir()}

    def fail(*_: Any) -> None:
        raise OSError("disk full")

    monkeypatch.setattr(page.os, "replace", fail)
    with pytest.raises(OSError, match="disk full"):
        write_report(tmp_path, run.scene, run.maps, run.truth, run.metrics, run.echoes)
    assert path.exists()
    assert {item.name: item.read_bytes() for item in tmp_path.iterdir()} == before


def test_several_turns_have_a_table_and_the_last_is_shown(tmp_path: Path) -> None:
    run = Run(small(turns=3))
    values(run.maps, "ground/height")[2, 10, 20] = 0.777
    text = write_report(tmp_path, run.scene, run.maps, run.truth, run.metrics, run.echoes).read_text(encoding="utf-8")
    assert "Turn by turn" in text
    assert "The last of 3 turns (turn 2) is shown." in text
    last = shown(images_of(height_maps(run.scene, run.maps, run.truth))[1])
    assert_allclose(last[10, 20], 0.777, rtol=1e-6)


# -------------------------------------------------------------------------------------------------- the right way up


def test_a_hill_in_the_north_east_is_drawn_in_the_upper_right(run: Run) -> None:
    for flip in (False, True):  # whichever way the file stores y
        truth = run.truth.copy(deep=True)
        x, y = np.meshgrid(run.x, run.y)
        values(truth, "ground/height")[0] = np.exp(-((x - 90.0) ** 2 + (y - 60.0) ** 2) / 100.0)
        if flip:
            truth = truth.isel(y=slice(None, None, -1))
        axes = images_of(height_maps(run.scene, run.maps, truth))[0]
        image = axes.images[0]
        heights = shown(axes).filled(-1.0)
        west, east, south, north = image.get_extent()
        row, column = np.unravel_index(np.argmax(heights), heights.shape)
        assert image.origin == "lower"
        assert_allclose(west + (column + 0.5) * (east - west) / heights.shape[1], 90.0, atol=3.01)
        assert_allclose(south + (row + 0.5) * (north - south) / heights.shape[0], 60.0, atol=3.01)
        # and on the page, right and up of the antenna
        antenna, hill = axes.transData.transform([(0.0, 0.0), (90.0, 60.0)])
        assert hill[0] > antenna[0]
        assert hill[1] > antenna[1]
        assert_allclose((hill - antenna)[0] / (hill - antenna)[1], 90.0 / 60.0, rtol=1e-3)  # equal aspect


@pytest.mark.parametrize("sector", [[0.0, 360.0], [30.0, 150.0], [300.0, 420.0]])
def test_the_echo_lies_where_the_antenna_looked(sector: list[float]) -> None:
    run = Run(small(radar__sector_deg=sector))
    target = run.azimuth[
        np.argmin(np.abs((run.azimuth - (90.0 if sector[0] < 200.0 else 6.0) + 180.0) % 360.0 - 180.0))
    ]
    gate = 30
    near = np.abs((run.echoes["azimuth"].values - target + 180.0) % 360.0 - 180.0) < 2.9
    run.echoes["voltage"].values[near, :, gate] = 10.0
    axes = echo_power(run.scene, run.echoes, run.azimuth, 0).axes[0]
    mesh = next(item for item in axes.collections if isinstance(item, QuadMesh))
    corners = np.asarray(mesh.get_coordinates())
    level = np.ma.asarray(mesh.get_array()).filled(np.nan)
    assert np.isfinite(level).all()
    look, column = np.unravel_index(np.argmax(level), level.shape)
    x, y = corners[look : look + 2, column : column + 2].mean(axis=(0, 1))
    ground = float(reduce.ground_range(run.range[gate], run.scene.radar.height_m))
    east, north = unit_from_azimuth(target)
    assert_allclose((x, y), (ground * east, ground * north), atol=0.01 * ground + 0.1)
    if abs(target - 90.0) < 4.0:
        assert x > 0.99 * ground
    assert axes.get_aspect() == 1.0


def test_the_echo_is_in_db_over_noise(run: Run) -> None:
    power, borders = reduce.mean_power(run.echoes, run.azimuth, 0, 6.0)
    assert_allclose(borders[-1] - borders[0], 360.0)
    for index in (0, 7):
        near = (run.echoes["azimuth"].values - borders[index] + 1e-6) % 360.0 < 6.0  # 0.6° from pulse to pulse
        voltage = run.echoes["voltage"].values[near]
        assert_allclose(power[index], np.mean(np.abs(voltage) ** 2, axis=(0, 1)), rtol=1e-5)
    assert_allclose(reduce.power_db(np.array([8e-12, 0.0]), NOISE_W), [10.0, np.nan])
    assert_allclose(reduce.power_db(np.array([1e-3]), 0.0), [-30.0])


def test_a_receiver_that_was_not_sampled_does_not_count(run: Run) -> None:
    echoes = run.echoes.copy(deep=True)
    echoes["voltage"].values[...] = 2.0
    echoes["voltage"].values[::2, 1, :] = np.nan
    power, _ = reduce.mean_power(echoes, run.azimuth, 0, 6.0)
    assert_allclose(power, 4.0)


# -------------------------------------------------------------------------------------------------------- the scales


def test_true_and_retrieved_share_their_colours(run: Run) -> None:
    true, retrieved, error, _ = images_of(height_maps(run.scene, run.maps, run.truth))
    low, high = true.images[0].get_clim()
    assert retrieved.images[0].get_clim() == (low, high)
    assert low == -high
    assert true.images[0].get_cmap() == retrieved.images[0].get_cmap()
    assert error.images[0].get_clim()[0] == -error.images[0].get_clim()[1]
    slopes = images_of(slope_maps(run.scene, run.maps, run.truth))
    assert len(slopes) == 4
    assert len({axes.images[0].get_clim() for axes in slopes}) == 1


def test_error_is_retrieved_minus_true(run: Run) -> None:
    maps, truth = run.maps.copy(deep=True), run.truth.copy(deep=True)
    values(truth, "ground/height")[0] += 0.01 * run.x + 0.02 * run.y[:, None]
    values(maps, "ground/height")[...] = values(truth, "ground/height") + 0.25
    flipped = truth.isel(y=slice(None, None, -1), x=slice(None, None, -1))  # the same sea, stored the other way round
    for same in (truth, flipped):
        error = shown(images_of(height_maps(run.scene, maps, same))[2])
        assert_allclose(error.compressed(), 0.25, atol=1e-5)


def test_shadow_is_blank_and_the_truth_stops_at_the_range_circle(run: Run) -> None:
    retrieved = shown(images_of(height_maps(run.scene, run.maps, run.truth))[1])
    missing = np.isnan(values(run.maps, "ground/height")[0])
    assert np.array_equal(np.ma.getmaskarray(retrieved), missing)
    everywhere = run.truth.copy(deep=True)
    values(everywhere, "ground/height")[...] = 0.3
    true = shown(images_of(height_maps(run.scene, run.maps, everywhere))[0])
    x, y = np.meshgrid(run.x, run.y)
    assert np.array_equal(np.ma.getmaskarray(true), np.hypot(x, y) > run.scene.far_ground_range)


def test_scales_do_not_collapse_and_wild_values_do_not_bleach_the_truth() -> None:
    nothing, flat = np.full((5, 5), np.nan), np.zeros((5, 5))
    assert drawn_maps.height_limit(flat, flat) == 0.05
    assert drawn_maps.height_limit(nothing, nothing) == 0.05
    assert drawn_maps.height_limit(flat, flat + 0.3) == 0.3  # no waves to bleach: the noise fills the scale
    wave = np.linspace(-1.0, 1.0, 1001)
    assert_allclose(drawn_maps.height_limit(wave, wave), 1.0)
    assert_allclose(drawn_maps.height_limit(wave, 50.0 * wave), 2.0)


# --------------------------------------------------------------------------------------------------------- the graphs


def test_visible_share_has_smith_and_wagner(run: Run) -> None:
    metrics = {**run.metrics, "slope_rms_look": 0.12}
    lines = {str(line.get_label()): line for line in visible_share(run.scene, run.truth, metrics).axes[0].lines}
    smith = lines["Smith 1967 (rms slope 0.120)"]
    at = np.argmin(np.abs(along(smith, "x") - 100.0))
    v = 5.0 / along(smith, "x")[at] / (np.sqrt(2.0) * 0.12)
    assert 0.25 < v < 0.35  # Smith's S is ½ at 0.358, Wagner's at 0.284
    assert 0.38 < along(smith, "y")[at] / 100.0 < 0.5
    assert along(lines["Wagner 1967 (rms slope 0.120)"], "y")[at] > along(smith, "y")[at]
    expected = values(run.truth, "polar/visible_fraction").mean(axis=(0, 1))
    assert_allclose(along(lines["all looks"], "y"), 100.0 * expected, rtol=1e-6)
    assert {"looking up-wave ±22.5°", "looking down-wave ±22.5°", "looking across ±22.5°"} <= set(lines)


def test_directions_are_relative_to_where_the_waves_come_from() -> None:
    run = Run(small(radar__sector_deg=[240.0, 300.0]))
    labels = {str(line.get_label()) for line in visible_share(run.scene, run.truth, {}).axes[0].lines}
    assert "looking up-wave ±22.5°" in labels
    assert not any("down-wave" in label or "across" in label for label in labels)
    values(run.truth, "polar/visible_fraction")[...] = 0.25
    values(run.truth, "polar/visible_fraction")[:, reduce.near_azimuth(run.azimuth, 270.0), :] = 0.75
    lines = {str(line.get_label()): line for line in visible_share(run.scene, run.truth, {}).axes[0].lines}
    assert_allclose(along(lines["looking up-wave ±22.5°"], "y"), 75.0)


def test_error_figure_shows_the_metrics_and_the_stated_error(run: Run) -> None:
    figure = error_against_range(run.maps, run.truth, run.metrics)
    lines = {str(line.get_label()): line for line in figure.axes[0].lines}
    assert_allclose(along(lines["rms"], "y"), run.metrics["height_rmse_m"])
    stated = along(lines["standard error stated by the retrieval, median"], "y")
    # a few gates per bin, all of one standard error per gate: the median is that of the middle of the bin
    expected = run.noise * (0.3 + np.asarray(run.metrics["range_m"]) / 120.0)
    assert_allclose(stated, expected, rtol=0.1)
    bias = along(figure.axes[1].lines[-1], "y")
    assert np.isnan(bias[0])
    assert_allclose(bias[1:], run.metrics["height_bias_m"][1:])


def test_error_figures_of_known_heights() -> None:
    true = np.array([0.0, 1.0, 0.0, -1.0, np.nan, 5.0])
    figures = reduce.error_figures(true, np.array([0.1, 1.3, 0.1, -1.1, 1.0, np.nan]))
    assert figures["cells"] == 4
    assert_allclose(figures["bias"], 0.1)
    assert_allclose(figures["rmse"], np.sqrt((0.01 + 0.09 + 0.01 + 0.01) / 4.0))
    assert_allclose(figures["robust"], 1.4826 * np.median([0.0, 0.2, 0.0, 0.2]))
    assert_allclose(figures["hs_true"], 4.0 * np.sqrt(0.5))


@pytest.mark.parametrize(
    ("value", "text"),
    [(None, "—"), (float("nan"), "—"), (-0.01234, "−0.012"), (-1e-9, "0.000"), (0.5, "+0.500"), ("x", "—")],
)
def test_numbers_are_written_plainly(value: Any, text: str) -> None:
    assert page.digits(value, 3, signed=True) == text


# ------------------------------------------------------------------------------------------------------- hard cases


def _empty(run: Run) -> None:
    for tree in (run.maps, run.truth):
        for group in ("polar", "ground"):
            for variable in tree[group].dataset.data_vars.values():
                if variable.dtype.kind == "f":
                    variable.values[...] = np.nan


HARD: dict[str, Any] = {
    "total shadow": lambda: Run(small(), lit=False),
    "flat sea": lambda: Run(
        load_scene("flat", {**TINY, "radar.range_m": [15.0, 150.0], "retrieval.ground_m": 6.0}), waves=0.0, noise=0.0
    ),
    "sector across north": lambda: Run(small(radar__sector_deg=[330.0, 390.0])),
    "one look": lambda: Run(small(radar__sector_deg=[90.0, 96.0])),
    "no noise": lambda: Run(small(radar__noise=False)),
    "far and coarse": lambda: Run(small(radar__range_m=[60.0, 170.0], radar__sector_deg=[0.0, 180.0])),
}


@pytest.mark.parametrize("case", HARD)
def test_hard_cases_are_drawn(case: str, tmp_path: Path) -> None:
    run = HARD[case]()
    if case == "no noise":
        run.echoes.attrs["noise_power_w"] = 0.0
    text = write_report(tmp_path, run.scene, run.maps, run.truth, run.metrics, run.echoes).read_text(encoding="utf-8")
    assert text.count("<figure id=") == len(PICTURES)
    limits = images_of(height_maps(run.scene, run.maps, run.truth))[0].images[0].get_clim()
    assert limits[1] >= 0.05


def test_nothing_but_missing_values_is_drawn_and_said_with_dashes(tmp_path: Path) -> None:
    run = Run(small(radar__sector_deg=[0.0, 90.0]))
    _empty(run)
    run.echoes["voltage"].values[...] = np.nan
    text = write_report(tmp_path, run.scene, run.maps, run.truth, {}, run.echoes).read_text(encoding="utf-8")
    plain = html.unescape(re.sub(r"base64,[^\"]*", "", text))
    assert "off by — rms (— robust, bias —)" in plain
    assert "nan" not in re.sub(r"<style>.*</style>", "", plain, flags=re.DOTALL).lower().replace("finance", "")
    assert "None" not in plain


@pytest.mark.parametrize(
    "metrics",
    [
        {"overall": None, "timing_s": None, "range_m": None, "modelled": None},
        {"timing_s": {"sea": 1.0, "trace": None, "total": 1.0}, "range_m": [50.0], "height_rmse_m": [None]},
        {"range_m": [50.0, 100.0], "height_rmse_m": [0.1], "left_out": ["rain"], "slope_rms_look": [0.1, 0.12]},
    ],
)
def test_missing_metrics_are_survived(run: Run, metrics: dict[str, Any], tmp_path: Path) -> None:
    text = write_report(tmp_path, run.scene, run.maps, run.truth, metrics, run.echoes).read_text(encoding="utf-8")
    assert text.count("<figure id=") == len(PICTURES)
    assert "—" in text


def test_each_figure_stands_alone(run: Run) -> None:
    for figure in (height_scatter(run.maps, run.truth), timing(run.scene, run.metrics)):
        assert figure.get_size_inches()[0] == 7.2
    bars = [bar for bar in timing(run.scene, run.metrics).axes[0].patches if isinstance(bar, Rectangle)]
    assert_allclose([bar.get_width() for bar in bars[:6]], [1.2, 0.4, 3.1, 2.2, 0.6, 0.2])
