"""The visible share that a retrieval states follows the power that returns, not what light sees."""

from __future__ import annotations

import seamap_rt as sr
from validation.retrieval.partly_shadowed import held


def test_where_the_field_bends_over_edges_the_stated_share_follows_it() -> None:
    """Of echoes by the field, what is stated goes with what the radar sees more than with what light sees, and is
    nearer to it in the mean: a sector of choppy_sea up the waves."""
    keys = {"tracing.tracer": "horizon", "tracing.diffraction": "knife_edge"}
    keys |= {"radar.sector_deg": [225.0, 315.0], "radar.range_m": [15.0, 210.0]}
    found = held(sr.load_scene("choppy_sea", keys))
    light, radar = found["light"], found["VV"]
    assert radar.correlation > light.correlation
    assert abs(radar.stated - radar.true) < abs(light.stated - light.true)
    assert radar.of_hidden > 3.0 * radar.of_visible
