"""An echo that bends over a crest has the range of the hidden water and the phase of the crest."""

from __future__ import annotations

import numpy as np
import pytest

from validation.light.hidden_heights import heights


@pytest.mark.parametrize("crest_m", [60.0, 150.0])
def test_in_deep_shadow_the_height_is_that_of_the_ray_over_the_crest(crest_m: float) -> None:
    """So the bias is the depth: F is a ray from the edge to the order 1/(πv²), 4 % at v = 3, where depth is 2 m. As one
    antenna looks over the crest and the other under it, depth is known to beyond/crest of the baseline: 2 cm of 2 m."""
    depth = np.array([2.0, 3.0])
    found = heights(depth, crest_m, 20.0, 5.0, 0.2)
    assert np.abs(found.bias_m / depth - 1.0).max() < 0.05


def test_well_clear_of_the_crest_water_has_its_own_height() -> None:
    """Fresnel's oscillations fall as 1/v: at 10 m over the ray v is 15, and height is off by less than 0.1 m."""
    found = heights(np.array([-10.0]), 60.0, 20.0, 15.0, 0.2)
    assert abs(found.bias_m[0]) < 0.1
    assert abs(found.power_db[0]) < 0.7


def test_at_the_shadow_s_edge_a_quarter_of_the_field_s_power_is_left_each_way() -> None:
    """|F(0)|⁴ = 1/16, 12.0 dB there and back: below what a radar is taken to see, and too high by Fresnel's blur."""
    found = heights(np.array([0.0]), 60.0, 20.0, 5.0, 0.2)
    assert found.power_db[0] == pytest.approx(-12.04, abs=0.05)
    assert 0.1 < found.bias_m[0] < 0.3
