"""Which pulses count to which cell, which pulses are compared, and where a moving boat's cells lie on the ground."""

from __future__ import annotations

import numpy as np
import pytest
from rolling_echoes import Boat, ideal_sea
from scipy.ndimage import minimum_filter
from scipy.spatial import KDTree

from seamap_rt.conventions import unit_from_azimuth
from seamap_rt.dataset import build
from seamap_rt.errors import SchemaError
from seamap_rt.interferometry.description import RadarDescription
from seamap_rt.interferometry.dwells import Dwells, allot, unwrapped_sweep
from seamap_rt.interferometry.ground_map import Ground, ground_map
from seamap_rt.interferometry.products import Products, dwell_means, neighbouring_pulses
from seamap_rt.radar.grid import look_sweeps
from seamap_rt.settings import RetrievalSettings

CIRCLE = look_sweeps((0.0, 360.0), 1.8)


def turn(first: float, last: float, count: int = 3600) -> tuple[np.ndarray, np.ndarray]:
    """Bearings of a turn of one second that swings from `first` to `last`, and its times."""
    return np.linspace(first, last, count, endpoint=False), np.arange(count) / count


def test_a_sweep_goes_on_across_the_ends_of_its_sector() -> None:
    for first, last in ((0.0, 360.0), (2.0, 363.0), (-3.0, 357.0)):
        bearing, time = turn(first, last)
        found = unwrapped_sweep(bearing % 360.0, time, (0.0, 360.0), 1.0)
        np.testing.assert_allclose(found, bearing, atol=1e-9)
    bearing, time = turn(-15.0, 15.0)
    np.testing.assert_allclose(unwrapped_sweep(bearing % 360.0, time, (345.0, 375.0), 12.0), bearing + 15.0, atol=1e-9)
    np.testing.assert_allclose(unwrapped_sweep(bearing % 360.0, time, (-15.0, 15.0), 12.0), bearing + 15.0, atol=1e-9)


def test_a_look_keeps_the_pass_that_gave_it_most() -> None:
    # From 2° to 363°: the last 3° fall on the first looks a turn later. Look 0 (0 to 1.8°) has no others and keeps
    # them; look 1 (1.8 to 3.6°) has 1.6° of its own and drops the 1.2°.
    bearing, _ = turn(2.0, 363.0, 3610)
    dwells = allot(bearing, None, CIRCLE, 1.8, closed=True)
    members = [np.flatnonzero(dwells.look == look) for look in (0, 1, 2)]
    assert bearing[members[0]].min() > 359.9
    assert bearing[members[1]].max() < 3.61
    assert [each.size for each in members] == [18, 16, 18]
    # A sector has no other side: what lies beyond its ends is dropped, and a look with less than half its pulses too.
    bearing, _ = turn(-1.0, 17.0, 180)
    dwells = allot(bearing, None, look_sweeps((0.0, 18.0), 1.8), 1.8, closed=False)
    np.testing.assert_array_equal(dwells.pulses[:, 0], [18] * 9 + [0])  # 0.8° of the last


def test_a_leaning_fan_has_pulses_of_its_own_in_each_gate() -> None:
    bearing, _ = turn(0.0, 18.0, 1800)
    aside = np.tile((0.0, 1.8, -0.9), (1800, 1))
    centres = look_sweeps((0.0, 18.0), 1.8)
    dwells = allot(bearing, aside, centres, 1.8, closed=False)
    assert dwells.leaning
    value = np.repeat(bearing[:, None], 3, axis=1)
    mean = dwells.sums(value) / np.where(dwells.pulses > 0, dwells.pulses, np.nan)
    # Pulses are 0.01° apart, the first of a look on its edge.
    np.testing.assert_allclose(mean[:, 0], centres - 0.005, atol=1e-9)
    np.testing.assert_allclose(mean[1:, 1], centres[1:] - 1.805, atol=1e-9)
    assert np.isnan(mean[0, 1])  # whose pulses were before the first
    np.testing.assert_allclose(mean[:-1, 2], centres[:-1] + 0.895, atol=1e-9)
    np.testing.assert_allclose(dwells.means(bearing[:, None])[0], mean, atol=1e-9)
    complex_sum = dwells.sums(value * (1.0 + 2.0j))
    np.testing.assert_allclose(complex_sum, dwells.sums(value) * (1.0 + 2.0j), rtol=1e-12)


def test_gates_alike_are_as_one_dwell() -> None:
    rng = np.random.default_rng(1)
    voltage = (rng.normal(size=(90, 2, 5)) + 1j * rng.normal(size=(90, 2, 5))).astype(np.complex64)
    voltage[13, 1, 2] = np.nan
    look, rows = np.repeat(np.arange(-1, 8), 10), np.arange(90)
    kinds = [[Products((rows, 0), (rows, 1), rows)]]
    upright, leaning = (dwell_means(voltage, Dwells(each, 8), kinds)[0] for each in (look, np.tile(look[:, None], 5)))
    for name in ("cross", "lower", "upper"):
        np.testing.assert_array_equal(getattr(upright, name), getattr(leaning, name))


# --------------------------------------------------------------------------------------------- alternating pulses


def alternating(count: int) -> tuple[np.ndarray, np.ndarray]:
    sampled = np.arange(count)[:, None] % 2 == np.arange(2)
    return sampled, np.arange(count) * 1e-4


def test_pairs_are_neighbours_one_interval_apart() -> None:
    sampled, time = alternating(8)
    both = neighbouring_pulses(sampled, time, 1e-4, "both")
    (n, m), (later, earlier) = both.pairs
    np.testing.assert_array_equal([n, m], [[0, 2, 4, 6], [1, 3, 5, 7]])
    np.testing.assert_array_equal([later, earlier], [[2, 4, 6], [1, 3, 5]])
    # A pulse that is missing, whether as NaN or not there at all, is in no pair and bridges none.
    sampled[3] = False
    np.testing.assert_array_equal(neighbouring_pulses(sampled, time, 1e-4, "forward").pairs[0][0], [0, 4, 6])
    keep = np.arange(8) != 3
    np.testing.assert_array_equal(
        neighbouring_pulses(sampled[keep], time[keep], 1e-4, "forward").pairs[0][0], [0, 3, 5]
    )
    np.testing.assert_array_equal(neighbouring_pulses(sampled[keep], time[keep], 1e-4, "backward").pairs[0][0], [2, 5])
    keep = (np.arange(8) < 3) | (np.arange(8) > 4)  # a lower pulse, and then an upper one three intervals later
    np.testing.assert_array_equal(neighbouring_pulses(sampled[keep], time[keep], 1e-4, "forward").pairs[0][0], [0, 4])
    with pytest.raises(SchemaError, match="backward"):
        neighbouring_pulses(sampled[:2], time[:2], 1e-4, "both")


@pytest.mark.parametrize(("which", "left"), [("forward", 1.0), ("both", 0.5)])
@pytest.mark.parametrize("signal", [0.0, 0.5, 10.0])
def test_noise_of_alternating_products(which: str, left: float, signal: float) -> None:
    # Variance of the imaginary part of the mean product of N lower pulses, over S²: (2/SNR + left/SNR²)/2N. 8e4 draws
    # know it to 0.5 %; the ends of a dwell, whose pulses are in one pair instead of two, change it by 1/2N.
    rng, lowers, cells = np.random.default_rng(5), 50, 8_000
    sampled, time = alternating(2 * lowers * 10)
    pairs = neighbouring_pulses(sampled, time, 1e-4, which)
    assert pairs.noise_square == left
    dwells = Dwells(np.repeat(np.arange(10), 2 * lowers), 10)
    variance = []
    for _ in range(cells // 1000):
        noise = rng.standard_normal((1000, 2, 2000), dtype=np.float32).view(np.complex64)
        voltage = np.complex64(np.sqrt(signal)) + np.float32(np.sqrt(0.5)) * noise
        voltage[~sampled] = np.nan
        kinds = [[Products((n, 0), (m, 1), n)] for n, m in pairs.pairs]
        means = dwell_means(voltage, dwells, kinds)
        variance.append(np.var(np.mean([mean.cross.imag for mean in means], axis=0)))
    asked = (2.0 * signal + left) / (2.0 * lowers)
    np.testing.assert_allclose(np.mean(variance), asked, rtol=0.02)


# ---------------------------------------------------------------------------------------------------- the ground


@pytest.mark.parametrize("speed", [0.0, 8.0])
def test_a_plane_lies_where_it_is_on_the_ground(speed: float) -> None:
    # Cells anywhere: of a boat that makes 8 m in the turn, on bearings that bend with range as a leaning fan's do.
    # Linear interpolation keeps a plane, but for what the arc between looks bends: 0.06 · 100 (0.0314)²/8 = 0.7 mm.
    boat = Boat(sector=(0.0, 360.0), ranges=np.arange(15.0, 100.0, 1.5))
    radar = RadarDescription.of(boat.echoes(ideal_sea))
    bearing, time = CIRCLE[:, None] + 20.0 / radar.ranges, np.broadcast_to(CIRCLE[:, None] / 360.0, (200, 57))
    east, north = unit_from_azimuth(bearing)
    x, y = radar.ranges * east + speed * time - 4.0, radar.ranges * north + 0.5 * speed * time
    names = ("height_std", "slope_range", "slope_azimuth", "coherence", "phase", "phase_unwrapped", "snr_db")
    names += ("slope_range_std", "slope_azimuth_std", "slope_correlation")
    fields = {name: np.zeros((1, 200, 57)) for name in names}
    fields |= {
        "height": (0.05 * x - 0.03 * y)[None],
        "ground_range": np.broadcast_to(radar.ranges, (1, 200, 57)),
        "quality": np.zeros((1, 200, 57)),
        "time": time[None, :, 0],
    }
    fields["height"][0, 60:63, 10:30] = np.nan
    cells = build("maps/polar", fields, {"turn": [0], "azimuth": CIRCLE, "range": radar.ranges})
    asked = RetrievalSettings()
    ground = ground_map(cells, Ground(x, y, (float(x.mean()), float(y.mean()))), radar, asked, 0)
    gx, gy = np.meshgrid(ground["x"].values, ground["y"].values)
    height, away = ground["height"].values[0], np.hypot(gx - x.mean(), gy - y.mean())
    known = np.isfinite(height)
    # Cells with an edge through them are the mean of their known part.
    within = np.asarray(minimum_filter(known, 3, mode="constant"), dtype=bool) & ~((np.abs(gx) < 10.0) & (gy > 0.0))
    np.testing.assert_allclose(height[within], (0.05 * gx - 0.03 * gy)[within], atol=3e-3)
    np.testing.assert_allclose(height[known], (0.05 * gx - 0.03 * gy)[known], atol=0.06 * 1.5)
    assert within.mean() > 0.4
    ring = (away > 30.0) & (away < 85.0)
    assert known[ring].mean() > 0.95
    # The first and the last look, which do not meet, serve as far as the seam.
    seam = ring & (np.abs(np.arctan2(gx - x.mean(), gy - y.mean())) < 0.03)
    assert known[seam].mean() > 0.8
    # The hole stays one: in the middle of its cells there is no height.
    hole = np.hypot(gx - x[61, 20], gy - y[61, 20])
    assert not known[hole < 2.0].any()
    # Each cell's time is that of its look.
    _, near = KDTree(np.column_stack((x.ravel(), y.ravel()))).query(np.column_stack((gx.ravel(), gy.ravel())))
    late = ground["time"].values[0].ravel() - time.ravel()[near]
    inside = (known & ring).ravel() & (np.abs(gx).ravel() > 10.0)
    assert np.abs(late[inside]).max() < 0.01
