"""Facets hold no light, and no illumination is without it."""

from __future__ import annotations

from dataclasses import fields

import numpy as np
import pytest
from numpy.testing import assert_array_equal

from seamap_rt import sea
from seamap_rt.mesh import Facets, SurfaceMesh, mesh_turn
from seamap_rt.scene import load_scene
from seamap_rt.tracing import Illumination
from seamap_rt.tracing.diffraction import diffract
from seamap_rt.tracing.horizon import trace_horizon


@pytest.fixture(scope="module")
def fan() -> SurfaceMesh:
    """A sector of a random sea."""
    keys = {"radar.range_m": [15.0, 40.0], "sea.extent_m": 150.0, "radar.sector_deg": [200.0, 260.0]}
    made = load_scene("tiny", overrides=keys)
    return mesh_turn(sea.realize(made.sea, 7), made.radar, made.tracing, 0)


def test_facets_are_geometry_alone_and_no_illumination_is_without_light(fan: SurfaceMesh) -> None:
    """What has not been traced is of another type, so that nothing can be asked of it that only light tells."""
    geometry = {field.name for field in fields(Facets)}
    light = {field.name for field in fields(Illumination)} - geometry
    assert light == {"lit", "rays", "field", "ray_slope", "in_sight", "facing_in_sight"}
    assert type(fan.facets) is Facets
    assert not any(hasattr(fan.facets, name) for name in (*light, "visible_to_both", "reached", "strain"))
    with pytest.raises(TypeError, match="lit"):
        Illumination(**vars(fan.facets))
    traced = trace_horizon(fan)
    assert type(traced) is Illumination
    for name in geometry:
        assert getattr(traced, name) is getattr(fan.facets, name)


def test_light_is_taken_away_from_where_it_is_dark(fan: SurfaceMesh) -> None:
    """Of one antenna at some columns, geometric and over edges alike; the rest keeps its bits."""
    bent = diffract(trace_horizon(fan), fan, 0.03)
    assert bent.field is not None
    dark = np.zeros(bent.lit.shape, dtype=bool)
    dark[1, 20:40] = True
    less = bent.without(dark)
    assert less.field is not None
    assert bent.lit[dark].any()
    assert not less.lit[dark].any()
    assert not less.reached[dark].any()
    assert_array_equal(less.lit[~dark], bent.lit[~dark])
    assert_array_equal(less.field[~dark], bent.field[~dark])
    assert less.field.dtype == bent.field.dtype
