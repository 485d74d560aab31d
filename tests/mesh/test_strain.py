"""The strain of short waves on the mesh: the gradient of the relaxed shift along each column's own look."""

from __future__ import annotations

from dataclasses import fields
from typing import Any

import numpy as np
import pytest
from numpy.testing import assert_allclose, assert_array_equal
from numpy.typing import NDArray

from seamap_rt import sea
from seamap_rt.conventions import unit_from_azimuth
from seamap_rt.mesh.grid import PolarGrid, polar_grid
from seamap_rt.mesh.surface import mesh_turn, sea_on_grid, surface_mesh
from seamap_rt.radar.installation import Installation
from seamap_rt.radar.scan import turn_duration
from seamap_rt.scene import Scene, load_scene


def scene(name: str = "tiny", **more: Any) -> Scene:
    keys = {"radar.range_m": [15.0, 40.0], "radar.sector_deg": [0.0, 360.0]}
    return load_scene(name, overrides=keys | {key.replace("__", "."): value for key, value in more.items()})


def grid_of(made: Scene) -> PolarGrid:
    return polar_grid(Installation(made.radar), made.tracing, 0)


def strain_of(made: Scene, east: NDArray[np.float64], north: NDArray[np.float64]) -> NDArray[np.float32]:
    """(column, facet) of a given relaxed shift (line, rung) on a flat sea."""
    grid = grid_of(made)
    shape = (grid.sweep.size, grid.ground_range.size)
    relaxed = np.stack(np.broadcast_arrays(east, north, np.zeros(shape))[:2], axis=-1).astype(np.float32)
    mesh = surface_mesh(grid, np.zeros(shape), np.zeros((*shape, 3), np.float32), relaxed)
    assert mesh.strain is not None
    return mesh.strain


def test_a_uniform_shift_strains_nothing() -> None:
    """To the bit: all corners of a facet look the same way. Each along its own line would give D/range."""
    made = scene()
    assert_array_equal(strain_of(made, np.array(0.7), np.array(-1.1)), 0.0)


def test_a_shift_linear_in_the_place_strains_by_its_gradient() -> None:
    """D = G x: −l·G l at every facet, G neither symmetric nor free of divergence."""
    made = scene()
    grid = grid_of(made)
    east, north = (axis[:, None] for axis in unit_from_azimuth(grid.azimuth))
    x, y = east * grid.ground_range, north * grid.ground_range
    found = strain_of(made, 0.10 * x + 0.04 * y, -0.07 * x + 0.03 * y)
    look_east, look_north = unit_from_azimuth(grid.column_azimuth)
    expected = -(0.10 * look_east**2 + (0.04 - 0.07) * look_east * look_north + 0.03 * look_north**2)
    # Two shifts of up to 5 m, each rounded to 2.4e-7 m three times before they are subtracted, over a rung.
    step = float(np.diff(grid.ground_range)[0])
    assert_allclose(found, np.broadcast_to(expected[:, None], found.shape), rtol=0.0, atol=1.5e-6 / step)
    assert np.ptp(expected) > 0.05


@pytest.mark.parametrize("rate", [0.0, 1.0, 6.0])
def test_a_regular_wave_strains_by_its_closed_form(rate: float) -> None:
    """−∂D/∂l = cos²φ k a ω (ω cos θ + μ sin θ)/(ω² + μ²) at the facets' points and times; across the look nothing."""
    made = scene("sinusoid", tracing__facet_m=0.25, tracing__columns_per_beam=4)
    grid = grid_of(made)
    elevation, velocity, relaxed = sea_on_grid(sea.realize(made.sea, 1), grid, rate)
    mesh = surface_mesh(grid, elevation, velocity, relaxed)
    facets, strain = mesh.facets, mesh.strain
    assert strain is not None
    east, _ = unit_from_azimuth(grid.column_azimuth[:, None] + np.degrees(facets.angle))
    time = grid.column_time[:, None] + facets.angle / (2.0 * np.pi) * turn_duration(made.radar)
    k, amplitude = 2.0 * np.pi / 40.0, 40.0 / 60.0
    omega = np.sqrt(9.81 * k + 0.074 / 1025.0 * k**3)
    theta = k * east * facets.distance - omega * time
    toward, _ = unit_from_azimuth(grid.column_azimuth)
    wave = k * amplitude * omega / (omega**2 + rate**2) * (omega * np.cos(theta) + rate * np.sin(theta))
    expected = toward[:, None] ** 2 * wave
    # A plane's slope along the look is the surface's at the middle of its radial edge, at most half a rung (0.13 m)
    # from the facet's point: k times that, 2 %, of the largest strain.
    most = k * amplitude * omega / np.hypot(omega, rate)
    assert_allclose(strain, expected, rtol=0.0, atol=0.02 * most)
    across = np.abs(toward) < 0.01
    assert across.sum() > 2
    assert np.abs(strain[across]).max() < 1e-4 * most  # cos² of half a column
    along = np.abs(toward) > 0.9
    assert np.abs(strain[along]).max() > 0.8 * most


def test_strain_closes_in_quadratically_on_the_seas_own() -> None:
    """Against central differences of D over the ground on a random sea, at the middle of each two facets.

    Of wave-number k the planes miss (k rung)²/24 and (k column)²/8: halving both leaves a quarter.
    """

    def error(facet_m: float, columns_per_beam: int) -> float:
        made = scene(sea__extent_m=150.0, tracing__facet_m=facet_m, tracing__columns_per_beam=columns_per_beam)
        water, grid = sea.realize(made.sea, 7), grid_of(made)
        elevation, velocity, relaxed = sea_on_grid(water, grid, 1.0)
        mesh = surface_mesh(grid, elevation, velocity, relaxed)
        strain = mesh.strain
        assert strain is not None
        near, far = strain[:, 0::2], strain[:, 1::2]
        found = 0.5 * (near + far)[:, -40:]
        middle = 0.5 * (grid.ground_range[1:] + grid.ground_range[:-1])[-40:]
        east, north = (axis[:, None] for axis in unit_from_azimuth(grid.column_azimuth))
        time = np.broadcast_to(grid.column_time[:, None], found.shape)

        def along(distance: NDArray[np.float64]) -> NDArray[np.float64]:
            *_, shift = water.elevation_velocity_and_relaxed_shift(east * distance, north * distance, time, 1.0)
            return shift[..., 0] * east + shift[..., 1] * north

        true = -(along(middle + 0.02) - along(middle - 0.02)) / 0.04
        return float(np.sqrt(np.mean((found - true) ** 2)) / true.std())

    coarse, fine = error(0.4, 4), error(0.2, 8)
    # The next order, (k rung)²/20 of the first at waves of 1.6 m, 4 rungs, makes up to 12 %.
    assert 3.5 < coarse / fine < 4.5
    assert fine < 0.02


def test_without_a_rate_there_is_no_strain_and_the_rest_keeps_its_bits() -> None:
    made = scene(sea__extent_m=150.0)
    water, grid = sea.realize(made.sea, 7), grid_of(made)
    plain = mesh_turn(water, made.radar, made.tracing, 0)
    elevation, velocity, relaxed = sea_on_grid(water, grid, 1.0)
    strained = surface_mesh(grid, elevation, velocity, relaxed)
    assert plain.strain is None
    assert strained.strain is not None
    assert strained.strain.dtype == np.float32
    assert strained.strain.shape == strained.facets.slope_look.shape
    for field in fields(plain.facets):
        value = getattr(plain.facets, field.name)
        if isinstance(value, np.ndarray):
            assert_array_equal(getattr(strained.facets, field.name), value)
