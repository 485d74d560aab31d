"""The Earth beneath a tangent plane, and the light behind an edge."""

from __future__ import annotations

import math

import pytest

from seamap_rt.conventions import EARTH_RADIUS
from seamap_rt.physics.shadowing import earth_drop_m, edge_blur_m


def test_the_earth_falls_away_as_a_sphere() -> None:
    radius = 4.0 / 3.0 * EARTH_RADIUS
    for distance in (400.0, 20_000.0):
        # The plain difference loses 1e-9 m of 8.5e6 m to rounding.
        assert earth_drop_m(distance) == pytest.approx(math.hypot(radius, distance) - radius, abs=3e-9)
    assert earth_drop_m(800.0) == pytest.approx(4.0 * earth_drop_m(400.0), rel=1e-7)


def test_an_edge_fades_where_its_detour_is_a_quarter_wave() -> None:
    before, beyond, wavelength = 200.0, 25.0, 0.03
    height = edge_blur_m(wavelength, before, beyond)
    detour = math.hypot(before, height) + math.hypot(beyond, height) - before - beyond
    # v²λ/4 at v = 1; the detour's next order is (height/beyond)²/4 of it.
    assert detour == pytest.approx(0.25 * wavelength, rel=2e-4)
    assert edge_blur_m(wavelength, before, 0.0) == 0.0
