"""Which rectangle a nonlinear sea lies on, and which seas have none."""

from __future__ import annotations

import numpy as np
import pytest
from numpy.testing import assert_allclose
from small_seas import jonswap, sea_of, sinusoid

from seamap_rt.sea import direct_sum, realize
from seamap_rt.sea.high_order import Plan
from seamap_rt.settings import SeaSettings


@pytest.mark.parametrize("from_deg", [270.0, 90.0, 180.0, 0.0])
def test_long_crested_waves_are_one_line(from_deg: float) -> None:
    settings = sea_of(
        jonswap(spreading="long_crested", wave_from_deg=from_deg),
        sinusoid(height_m=0.3, wavelength_m=32.0, wave_from_deg=from_deg),
        extent_m=128.0,
    )
    sea = realize(settings, 2)
    plan = Plan(settings, sea, 3, 1.0)
    assert 1 in (plan.band.shape[0], plan.band.most_x + 1)
    state = plan.start.state(plan.band, 7.0)
    side = 512  # a point a metre: a line repeats after four sides
    heights = plan.band.to_points(state.elevation, (side if plan.band.most_y else 1, side if plan.band.most_x else 1))
    x, y = np.array([0, 30, 401]), np.array([0, 77, 500])
    exact = direct_sum(sea.components(), 1.0 * x, 1.0 * y, 7.0).elevation
    assert_allclose(np.broadcast_to(heights, (side, side))[y, x], exact, atol=1e-11)


def test_the_finest_spacing_is_the_steepest_systems() -> None:
    """Eight wavenumbers of its peak; a higher but longer swell changes neither that nor the step, but the beginning."""
    wind = jonswap(significant_wave_height_m=0.6, peak_period_s=4.0)
    swell = jonswap(significant_wave_height_m=1.0, peak_period_s=9.0, wave_from_deg=200.0)
    alone, both = (
        Plan(settings, realize(settings, 1))
        for settings in (sea_of(wind, extent_m=512.0), sea_of(wind, swell, extent_m=512.0))
    )
    peak = (2.0 * np.pi / 4.0) ** 2 / 9.81
    assert_allclose(alone.spacing, np.pi / (8.0 * peak), rtol=0.01)
    assert alone.spacing == both.spacing
    assert_allclose(both.relaxing / alone.relaxing, 9.0 / 4.0, rtol=0.01)
    assert both.longest_step <= alone.longest_step


@pytest.mark.parametrize(
    ("settings", "options", "said"),
    [
        (sea_of(), {}, "has no waves"),
        (sea_of(jonswap(spreading="long_crested", wave_from_deg=230.0)), {}, "wave_from_deg to 270"),
        (sea_of(sinusoid(wavelength_m=21.0, wave_from_deg=270.0)), {}, "whole number of times"),
        (sea_of(jonswap()), {"order": 6}, "--order = 6"),
        (sea_of(jonswap()), {"requested": 40.0}, "--spacing = 40"),
    ],
)
def test_seas_that_cannot_be_are_refused(settings: SeaSettings, options: dict, said: str) -> None:
    with pytest.raises(ValueError, match=said):
        Plan(settings, realize(settings, 1), **options)
