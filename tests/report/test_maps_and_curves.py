"""Maps the right way up, scales that show what there is, and graphs of what was measured."""

from __future__ import annotations

from typing import Any

import made_run
import numpy as np
import pytest
from made_run import NOISE_W, Run, along, images_of, shown, small, values
from matplotlib.collections import QuadMesh
from numpy.testing import assert_allclose

from seamap_rt.conventions import ground_range, unit_from_azimuth
from seamap_rt.report import maps as drawn_maps
from seamap_rt.report import page_elements, reduce
from seamap_rt.report.curves import error_against_range, visible_share
from seamap_rt.report.maps import echo_power, height_maps, slope_maps

run, coarse_pictures = made_run.run, made_run.coarse_pictures  # fixtures


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
    ground = float(ground_range(run.range[gate], run.scene.radar.height_m))
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
    assert len({axes.images[0].get_clim() for axes in slopes}) == 1
    true, retrieved, error = (
        [np.ma.asarray(axes.images[0].get_array()) for axes in slopes[first : first + 2]] for first in (0, 2, 4)
    )
    for which in range(2):
        assert_allclose(error[which], retrieved[which] - true[which], atol=1e-6)


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


@pytest.mark.parametrize(
    ("value", "text"),
    [(None, "—"), (float("nan"), "—"), (-0.01234, "−0.012"), (-1e-9, "−1.0e−09"), (0.5, "+0.500"), ("x", "—")],
)
def test_numbers_are_written_plainly(value: Any, text: str) -> None:
    assert page_elements.digits(value, 3, signed=True) == text
