"""From the polar map to squares: what is linear stays as it is, what is unknown stays unknown."""

from __future__ import annotations

import numpy as np
import pytest
from scipy.interpolate import RegularGridInterpolator

from seamap_rt.conventions import unit_from_azimuth
from seamap_rt.dataset import build
from seamap_rt.interferometry.description import RadarDescription
from seamap_rt.interferometry.ground_map import Ground, ground_map, resample_looks, square_means
from seamap_rt.radar.grid import LookFan, ground_grid
from seamap_rt.radar.waveform import RangeResponse
from seamap_rt.settings import RetrievalSettings


def test_looks_are_linear_between_their_cells() -> None:
    # Against numpy's own; cells that are not in order are sorted, those without a place are left out.
    rng = np.random.default_rng(1)
    place = 20.0 + 1.5 * np.arange(40) + rng.uniform(-1.4, 1.4, (5, 40))
    place[rng.uniform(size=place.shape) < 0.1] = np.nan
    place[4] = np.nan
    fields, at = rng.normal(size=(3, 5, 40)), np.linspace(15.0, 90.0, 301)
    laid = resample_looks(place, fields, at, 100.0)
    for look in range(4):
        known = np.flatnonzero(np.isfinite(place[look]))
        known = known[np.argsort(place[look, known])]
        for field in range(3):
            nan = np.nan
            asked = np.interp(at, place[look, known], fields[field, look, known], left=nan, right=nan)
            np.testing.assert_allclose(laid[look, :, field], asked, rtol=0, atol=1e-12)
    assert np.isnan(laid[4]).all()


def test_gaps_stay_gaps() -> None:
    place = np.array([[20.0, 21.5, 26.0, 27.5], [20.0, np.nan, np.nan, np.nan]])
    at = np.arange(19.0, 29.0, 0.25)
    laid = resample_looks(place, np.ones((1, 2, 4)), at, 4.0)[..., 0]
    np.testing.assert_array_equal(np.isfinite(laid[0]), ((at >= 20.0) & (at <= 21.5)) | ((at > 26.0) & (at <= 27.5)))
    assert np.isnan(laid[1]).all()  # a lone cell reaches nowhere


SECTOR = LookFan(np.asarray(20.0 + 1.8 * np.arange(50), dtype=np.float64), 310.0, False, 1.0, 0, 1.8)
DISTANCE = np.arange(1.5, 80.0, 0.75)


def test_squares_are_means_of_bilinear_values() -> None:
    # Against scipy's own, from a centre of its own; half a look beyond the last its values serve.
    rng = np.random.default_rng(2)
    laid, grid, centre = rng.normal(size=(50, DISTANCE.size, 9)), ground_grid(70.0, 3.0), (4.0, -7.0)
    x, y = (part - at for part, at in zip(grid.points(3), centre, strict=True))
    middle = SECTOR.sweep_of(grid.x - centre[0], (grid.y - centre[1])[:, None])
    found = square_means(SECTOR, laid, DISTANCE, grid, centre, middle)
    angle, away = (np.degrees(np.arctan2(x, y)) - 310.0) % 360.0, np.hypot(x, y)
    for n in range(9):  # of several fields
        asked = RegularGridInterpolator((SECTOR.sweep, DISTANCE), laid[..., n], bounds_error=False)
        within = np.abs(angle - 64.1) <= 45.0
        points = np.stack((np.clip(angle, SECTOR.sweep[0], SECTOR.sweep[-1]), away), axis=-1)
        values = np.where(within, asked(points), np.nan)
        known = np.isfinite(values)
        total = np.where(known, values, 0.0).sum(axis=2) / np.maximum(known.sum(axis=2), 1)
        np.testing.assert_allclose(found[n], np.where(known.sum(axis=2) > 4, total, np.nan), rtol=0, atol=1e-12)
    assert 0.1 < np.isfinite(found).mean() < 0.5


def test_the_ends_of_a_circle_are_not_blended() -> None:
    circle = LookFan(np.asarray(0.9 + 1.8 * np.arange(200), dtype=np.float64), 0.0, True, 1.0, 0, 1.8)
    laid, grid = np.zeros((200, DISTANCE.size, 1)), ground_grid(70.0, 3.0)
    laid[100:] = 1.0
    middle = circle.sweep_of(grid.x, grid.y[:, None])
    found = square_means(circle, laid, DISTANCE, grid, (0.0, 0.0), middle)[0]
    seam = (np.abs(grid.x) < 10.0) & (grid.y[:, None] > 6.0) & (np.hypot(grid.x, grid.y[:, None]) < 75.0)
    # Each square on its own centre's side, also that which is centred on the seam: the turn begins there.
    np.testing.assert_array_equal(found[seam], np.broadcast_to(1.0 * (grid.x < 0.0), seam.shape)[seam])


def test_one_unknown_value_is_no_value() -> None:
    # A bilinear value takes all four corners; a look that it lies on exactly is enough.
    laid, grid = np.ones((50, DISTANCE.size, 1)), ground_grid(70.0, 3.0)
    laid[25, 40:60] = np.nan
    middle = SECTOR.sweep_of(grid.x, grid.y[:, None])
    found = square_means(SECTOR, laid, DISTANCE, grid, (0.0, 0.0), middle)[0]
    number, away = (middle - SECTOR.sweep[0]) / 1.8, np.hypot(grid.x, grid.y[:, None])
    ring = (away > DISTANCE[40]) & (away < DISTANCE[59])
    assert np.isnan(found[ring & (np.abs(number - 25.0) < 0.1)]).all()
    clear = (np.abs(number - 24.5) < 24.0) & (np.abs(number - 25.0) > 4.0) & (away > 30.0) & (away < 75.0)
    assert (found[clear] == 1.0).all()


def cells_of_a_plane(ranges: np.ndarray, looks: np.ndarray):
    east, north = (part[:, None] for part in unit_from_azimuth(looks))
    zero = np.zeros((1, looks.size, ranges.size))
    names = ("height_std", "slope_range", "slope_azimuth", "coherence", "phase", "phase_unwrapped", "snr_db")
    names += ("slope_range_std", "slope_azimuth_std", "slope_correlation")
    fields = {name: zero.copy() for name in names} | {
        "height": (0.05 * ranges * east - 0.03 * ranges * north)[None],
        "ground_range": np.broadcast_to(ranges, zero.shape).copy(),
        "quality": np.zeros(zero.shape),
        "time": (looks / 360.0)[None],
    }
    return build("maps/polar", fields, {"turn": [0], "azimuth": looks, "range": ranges})


def test_errors_of_slopes_turn_with_the_look() -> None:
    # The covariance of slopes towards east and north is that of outward and clockwise ones, turned by the azimuth.
    ranges, looks = np.arange(15.0, 90.0, 1.5), 0.9 + 1.8 * np.arange(200)
    radar = RadarDescription(0.03, 0.0, "single", (0.0, 360.0), 1.0, 5.0, RangeResponse(2e-8, 5e7), ranges)
    cells = cells_of_a_plane(ranges, looks)
    for name, value in (("slope_range_std", 0.03), ("slope_azimuth_std", 0.05), ("slope_correlation", -0.4)):
        cells[name].values[:] = value
    ground = ground_map(cells, Ground(), radar, RetrievalSettings(), 0)
    own = np.array([[0.03**2, -0.4 * 0.03 * 0.05], [-0.4 * 0.03 * 0.05, 0.05**2]])
    for x, y in ((60.0, 0.0), (0.0, -60.0), (-42.0, 42.0), (30.0, 51.0)):
        cell = ground.sel(x=x, y=y, method="nearest").isel(turn=0)
        east, north = np.array([float(cell[name]) for name in "xy"]) / np.hypot(float(cell["x"]), float(cell["y"]))
        turned = np.array([[east, north], [north, -east]])
        asked = np.sqrt(np.diag(turned @ own @ turned.T))
        # A square takes looks up to 3° aside, by which a deviation turns by a twentieth of its excursion.
        assert [float(cell[f"slope_{name}_std"]) for name in "xy"] == pytest.approx(list(asked), abs=1.5e-3)


def test_cells_that_are_left_out_have_no_part() -> None:
    ranges, looks = np.arange(15.0, 90.0, 1.5), 0.9 + 1.8 * np.arange(200)
    radar = RadarDescription(0.03, 0.0, "single", (0.0, 360.0), 1.0, 5.0, RangeResponse(2e-8, 5e7), ranges)
    cells, good = cells_of_a_plane(ranges, looks), np.ones((200, ranges.size), dtype=bool)
    good[50:54, 20] = good[120, 30:40] = False
    cells["height"].values[0][~good] = 50.0
    ground = ground_map(cells, Ground(), radar, RetrievalSettings(), 0, usable=good)
    height = ground["height"].values[0]
    x, y = np.meshgrid(ground["x"].values, ground["y"].values)
    away = np.hypot(x, y)
    known = np.isfinite(height)
    # One gate is bridged, ten in a row are a hole. An arc of 1.8° bends by 0.06 · 90 · (0.0314)²/8 = 0.7 mm; squares
    # with a part in the hole are the mean of the rest; those on the seam are their own 3.0's alone.
    inner = known & (away > 20.0) & (away < 84.0) & ((np.abs(x) > 3.0) | (y < 0.0))
    beside_hole = np.abs((np.degrees(np.arctan2(x, y)) % 360.0) - looks[120]) < 4.0
    np.testing.assert_allclose(height[inner & ~beside_hole], (0.05 * x - 0.03 * y)[inner & ~beside_hole], atol=1e-3)
    np.testing.assert_allclose(height[inner], (0.05 * x - 0.03 * y)[inner], atol=0.06 * 1.5)
    hole = np.hypot(x - 68.0 * np.sin(np.radians(looks[120])), y - 68.0 * np.cos(np.radians(looks[120])))
    assert np.isnan(height[np.unravel_index(np.argmin(hole), hole.shape)])
    kept = ground_map(cells, Ground(), radar, RetrievalSettings(), 0)["height"].values[0]
    assert np.nanmax(kept) > 25.0


@pytest.mark.parametrize("side", [3.0, 7.0])
def test_a_grid_of_any_side(side: float) -> None:
    ranges, looks = np.arange(15.0, 60.0, 1.5), 0.9 + 1.8 * np.arange(200)
    radar = RadarDescription(0.03, 0.0, "single", (0.0, 360.0), 1.0, 5.0, RangeResponse(2e-8, 5e7), ranges)
    ground = ground_map(cells_of_a_plane(ranges, looks), Ground(), radar, RetrievalSettings(ground_m=side), 0)
    x, y = np.meshgrid(ground["x"].values, ground["y"].values)
    away, height = np.hypot(x, y), ground["height"].values[0]
    ring = (away > 15.0 + side) & (away < 58.0 - side) & ((np.abs(x) > side) | (y < 0.0))  # but for the seam
    np.testing.assert_allclose(height[ring], (0.05 * x - 0.03 * y)[ring], atol=1e-3)
