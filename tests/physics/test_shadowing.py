"""Production's shadowing functions and flat-sea power against the judge's own, which were written apart from them."""

from __future__ import annotations

import numpy as np
import pytest
from numpy.testing import assert_allclose

from seamap_rt.physics.shadowing import (
    regular_wave_visible_share,
    second_bounce_share,
    shadowing_smith67,
    shadowing_wagner67,
)
from seamap_rt.radar.link import flat_sea_power
from seamap_rt.radar.precision import cramer_rao_phase_std
from seamap_rt.scene import load_scene
from validation import analytic


def test_smith_and_wagner_are_the_judges() -> None:
    v = np.append(0.0, np.geomspace(1e-6, 50.0, 400))
    assert_allclose(shadowing_smith67(v), analytic.shadowing_smith67(v), rtol=1e-13)
    assert_allclose(shadowing_wagner67(v), analytic.shadowing_wagner67(v), rtol=1e-13)
    assert shadowing_smith67(0.0) == 0.0
    with pytest.raises(ValueError, match="0 or more"):
        shadowing_smith67(-1.0)


def test_the_phase_bound_is_the_judges() -> None:
    coherence = np.linspace(0.0, 1.0, 101)[:, None]
    assert_allclose(
        cramer_rao_phase_std(coherence, [1.0, 7.5, 200.0]),
        analytic.cramer_rao_phase_std(coherence, [1.0, 7.5, 200.0]),
        rtol=1e-13,
    )


@pytest.mark.parametrize("phase", [0.0, 1.3, 3.1, -2.2])
@pytest.mark.parametrize(("height", "length", "mast"), [(0.5, 10.0, 5.0), (1.4, 40.0, 5.0), (0.3, 6.0, 12.0)])
def test_a_regular_wave_by_sampled_crests_is_the_judges_by_roots(
    height: float, length: float, mast: float, phase: float
) -> None:
    # Crossings are interpolated to 1e-5 of a wavelength; each bin of 20 m holds at most two a wave.
    edges = np.arange(20.0, 401.0, 20.0)
    seen, _ = analytic.sinusoid_visible_intervals(height, length, mast, 0.0, 400.0, phase)
    exact = analytic.visible_share(seen**2, edges**2)
    assert_allclose(regular_wave_visible_share(height, length, mast, phase, edges), exact, atol=5e-5)
    assert 0.0 < exact.mean() < 0.9


@pytest.mark.parametrize("change", [{}, {"radar.height_m": 20.0}, {"radar.antenna.pattern": "gaussian"}])
def test_power_of_a_flat_sea_is_the_judges_integral(change: dict[str, object]) -> None:
    radar = load_scene("choppy_sea", change).radar
    gates = np.linspace(25.0, 400.0, 60)
    # The judge's quadrature is good to 1e-9 of each gate; production's converges to it.
    assert_allclose(flat_sea_power(radar, 0.01, gates), analytic.flat_sea_power(radar, 0.01, gates), rtol=1e-8)


@pytest.mark.parametrize("mean_square_slope", [1e-4, 0.02, 0.5])
def test_a_second_bounce_has_what_the_surface_s_area_takes(mean_square_slope: float) -> None:
    part = (np.arange(200_000) + 0.5) / 200_000
    square = -mean_square_slope * np.log(1.0 - part)  # of Gaussian slopes in two directions
    area = float(np.mean(np.sqrt(1.0 + square)))
    # The midpoint rule loses 3e-6 of the mean square slope at the end of the distribution.
    assert second_bounce_share(mean_square_slope) == pytest.approx(1.0 - 1.0 / area, rel=1e-4)
    assert second_bounce_share(0.0) == 0.0
