"""Which way waves run: a synthetic sea whose water moves as Airy (1845) says, seen along looks."""

from __future__ import annotations

import numpy as np
import pytest
from numpy.typing import NDArray

from seamap_rt.conventions import GRAVITY, unit_from_azimuth, wrap_degrees
from seamap_rt.wavefield.wave_direction import Travel, map_travel, travel

SIDE, REACH = 3.0, 200.0
AZIMUTH = np.arange(0.9, 360.0, 1.8)
RANGE = np.arange(15.0, REACH, 1.5)


class Waves:
    """Long-crested waves of random phase: amplitude [m], period [s], azimuth they come from [deg], each (wave,)."""

    def __init__(self, seed: int, mean_from: float, period: float, height: float, count: int = 40) -> None:
        rng = np.random.default_rng(seed)
        self.omega = 2.0 * np.pi / (period * rng.uniform(0.7, 1.15, count))
        east, north = unit_from_azimuth(mean_from + rng.normal(0.0, 25.0, count))
        self.towards = -np.stack((east, north))
        self.amplitude = np.full(count, height / (2.0 * np.sqrt(2.0 * count)))
        self.phase = rng.uniform(0.0, 2.0 * np.pi, count)

    @property
    def mean_from(self) -> float:
        east, north = self.towards @ self.amplitude**2
        return float(np.degrees(np.arctan2(-east, -north)) % 360.0)

    def at(self, x: NDArray[np.float64], y: NDArray[np.float64]) -> tuple[NDArray, NDArray, NDArray]:
        """Elevation [m] and the water's velocity [m/s] to the east and north."""
        k = self.omega**2 / GRAVITY * self.towards
        each = self.amplitude * np.cos(np.multiply.outer(x, k[0]) + np.multiply.outer(y, k[1]) + self.phase)
        return each.sum(-1), each @ (self.omega * self.towards[0]), each @ (self.omega * self.towards[1])


def polar(seas: list[Waves], azimuth: NDArray[np.float64], drift: tuple[float, float] = (0.0, 0.0), noise: float = 0.0):
    """Height, its error, radial velocity and ground range (look, gate) of what a radar finds."""
    rng = np.random.default_rng(7)
    east, north = (part[:, None] for part in unit_from_azimuth(azimuth))
    height, u, v = np.sum([sea.at(RANGE * east, RANGE * north) for sea in seas], axis=0)
    radial = (u + drift[0]) * east + (v + drift[1]) * north
    spread = np.full(height.shape, 0.05 + noise)
    height = height + spread * rng.normal(size=height.shape)
    height[rng.random(height.shape) < 0.1] = np.nan
    return height, spread, radial + 0.3 * rng.normal(size=height.shape), np.broadcast_to(RANGE, height.shape)


def ground(seas: list[Waves], noise: float = 0.0) -> tuple[NDArray, NDArray]:
    x = np.arange(-REACH, REACH + 0.5 * SIDE, SIDE)
    x, y = np.meshgrid(x, x)
    rng = np.random.default_rng(8)
    height = np.sum([sea.at(x, y)[0] for sea in seas], axis=0) + (0.05 + noise) * rng.normal(size=x.shape)
    height[(np.hypot(x, y) > REACH) | (rng.random(x.shape) < 0.1)] = np.nan
    return height, np.full(height.shape, 0.05 + noise)


def direction_bin(seas: list[Waves], azimuth: NDArray[np.float64] = AZIMUTH, **more) -> Travel:
    height, spread, radial, distance = polar(seas, azimuth, **more)
    return travel(height, spread, radial, azimuth, distance, SIDE)


@pytest.mark.parametrize("noise", [0.0, 0.4])
@pytest.mark.parametrize("mean_from", [0.0, 100.0, 215.0, 330.0])
def test_the_direction_is_found_without_its_ambiguity(mean_from: float, noise: float) -> None:
    sea = Waves(int(mean_from), mean_from, 5.5, 1.4)
    way = direction_bin([sea], noise=noise)
    # Wide of it: waves of one axis beat with those of another over a map of a few wavelengths.
    assert abs(wrap_degrees(way.wave_from_deg - sea.mean_from)) < 25.0
    found = map_travel(*ground([sea], noise), SIDE, way).wave_from_deg
    # 40 waves spread by 25°, in a circle of 8 wavelengths: some 50 cells of their spectrum, 25°/√50.
    assert abs(wrap_degrees(found - sea.mean_from)) < 5.0


def test_drift_with_the_wind_decides_nothing() -> None:
    # Breakers run with the wind, ten times as fast here as the water in the waves' mean; against the waves besides.
    sea = Waves(3, 250.0, 5.5, 1.4)
    found = [direction_bin([sea], drift=drift).wave_from_deg for drift in ((0.0, 0.0), (-3.0, -1.0))]
    assert abs(wrap_degrees(found[1] - found[0])) < 1.0  # what noise and rounding leave


@pytest.mark.parametrize("start", [0.0, 70.0, 200.0, 290.0])
def test_a_sector_sees_what_runs_along_it(start: float) -> None:
    # Looks over 60° only, with the waves along them or against them.
    for run in (0.0, 180.0):
        sea = Waves(5, start + 30.0 + run, 5.5, 1.4)
        found = direction_bin([sea], start + np.arange(0.9, 60.0, 1.8))
        assert abs(wrap_degrees(found.wave_from_deg - sea.mean_from)) < 60.0


def test_swell_may_run_against_the_wind_sea() -> None:
    wind, swell = Waves(1, 270.0, 4.0, 1.0), Waves(2, 70.0, 8.0, 1.0)
    way = direction_bin([wind, swell])
    for each in (way, map_travel(*ground([wind, swell]), SIDE, way)):
        k = wind.omega**2 / GRAVITY * wind.towards
        assert np.mean(each.travel_sign(*k)) > 0.9
        k = swell.omega**2 / GRAVITY * swell.towards
        assert np.mean(each.travel_sign(*k)) > 0.9


def test_the_way_is_odd_in_the_wavevector() -> None:
    # Waves of a real surface: k and −k are the same wave.
    way = Travel.from_direction(30.0)
    kx, ky = np.array([0.1, -0.2, 0.0]), np.array([0.3, 0.1, 0.0])
    np.testing.assert_array_equal(way.travel_sign(kx, ky), -way.travel_sign(-kx, -ky))
    np.testing.assert_array_equal(way.travel_sign(*(-0.1 * part for part in unit_from_azimuth(30.0))), 1.0)
    assert way.wave_from_deg == pytest.approx(30.0)


def test_maps_that_tell_nothing_say_so() -> None:
    nothing = np.full((AZIMUTH.size, RANGE.size), np.nan)
    way = travel(nothing, nothing, nothing, AZIMUTH, nothing, SIDE)
    assert np.isnan(way.wave_from_deg)
    assert np.isnan(map_travel(nothing, nothing, SIDE, way).wave_from_deg)
    assert np.isnan(map_travel(*ground([Waves(1, 0.0, 5.0, 1.0)]), SIDE, way).wave_from_deg)
    level = np.zeros_like(nothing)
    distance = np.broadcast_to(RANGE, nothing.shape)
    assert np.isnan(travel(level, level + 0.1, level, AZIMUTH, distance, SIDE).wave_from_deg)
    with pytest.raises(ValueError, match="wave_from_deg = nan: must be finite"):
        Travel.from_direction(np.nan)
