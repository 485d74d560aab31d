"""What water returns to a radar of its power when lit: flat water, round crests against wave optics, deep shadow."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import numpy as np
import pytest
from numpy.typing import NDArray

from seamap_rt.conventions import POLARIZATIONS
from seamap_rt.mesh import polar_grid, surface_mesh
from seamap_rt.mesh.surface import sea_on_grid
from seamap_rt.radar.installation import Installation
from seamap_rt.resolved_scene import run_sea
from seamap_rt.scene import load_scene
from seamap_rt.tracing import Illumination, tracer
from seamap_rt.tracing.diffraction import field_over_profiles
from seamap_rt.tracing.visibility import profile_powers, water_powers
from validation.light.wave_optics import Profile, surface_field

WAVE = 0.03
WATER = 55.0 - 37.5j


def light(
    height: Callable[[NDArray[Any]], NDArray[Any]] | float, mast_m: float = 5.0
) -> tuple[Illumination, list[NDArray[np.float64]]]:
    """And powers, of water that has the same height (rung,) [m] along each look, on rungs half a metre apart."""
    keys = {"radar.height_m": mast_m, "radar.baseline_m": 1e-3, "tracing.facet_m": 0.5}
    scene = load_scene("choppy_sea", keys | {"radar.range_m": [10.0, 150.0], "radar.sector_deg": [0.0, 2.0]})
    grid = polar_grid(Installation(scene.radar), scene.meshing, 0)
    level = height(grid.ground_range) if callable(height) else np.full(grid.ground_range.size, height)
    elevation = np.broadcast_to(level, (grid.azimuth.size, level.size))
    mesh = surface_mesh(grid, elevation, np.zeros((*elevation.shape, 3), dtype=np.float32))
    bent = tracer("horizon", scene.radar, scene.scattering, diffraction="knife_edge")(mesh)
    return bent, water_powers(mesh, WATER, WAVE)


@pytest.mark.parametrize("polarization", POLARIZATIONS)
def test_level_water_returns_all(polarization: str) -> None:
    """Nothing hides, nothing bends: 1 but for what float32 leaves of level slopes."""
    powers = light(0.0)[1]
    assert np.abs(powers[POLARIZATIONS.index(polarization)] - 1.0).max() < 1e-3


def crest(at: NDArray[Any], radius_m: float) -> list[NDArray[np.float64]]:
    """Height, slope and curvature of a crest at 60 m: a parabola that goes on as planes where its slope is 0.2."""
    away, edge = at - 60.0, 0.2 * radius_m
    beyond = np.abs(away) > edge
    height = np.where(beyond, -0.2 * (np.abs(away) - 0.5 * edge), -0.5 * away**2 / radius_m)
    slope = np.where(beyond, -0.2 * np.sign(away), -away / radius_m)
    return [height, slope, np.where(beyond, 0.0, -1.0 / radius_m)]


def test_a_round_crest_of_no_impedance_returns_the_field_over_its_edges() -> None:
    """Leontovich's, √(ε − 1)/ε, is 0 of ε = 1: in VV a round crest then returns what arrives, as a plane does, whose
    fourth power that is. In HH, of a conductor's current, its horizon returns more than a plane's."""
    x = 5.0 + 0.5 * np.arange(290, dtype=np.float64)
    height = crest(x, 40.0)[0][None, :] - 2.0
    field = np.abs(field_over_profiles(x, height, WAVE)[0])
    powers = dict(zip(POLARIZATIONS, profile_powers(x, height, 1.0 + 0.0j, WAVE), strict=True))
    np.testing.assert_allclose(powers["VV"], field**4, rtol=1e-6)
    assert np.any(powers["HH"] > 2.0 * powers["VV"])


@pytest.mark.parametrize("radius_m", [20.0, 80.0])
def test_the_field_at_the_horizon_of_a_round_crest_is_fock_s(radius_m: float) -> None:
    """HH of a conductor: f(0)/2 = 0.388 (2/ka)^(1/3) of an antenna as high as the crest, to 5 %: Fock's next term is of
    the order (2/ka)^(2/3), 0.6 %, and the horizon is found to a step of 6 mm."""
    x = 5.0 + 0.006 * np.arange(13_000)
    field = surface_field(Profile(x, *crest(x, radius_m)), (0.0, 0.0), WAVE, 0.0)
    expected = 0.388 * np.cbrt(WAVE / (np.pi * radius_m))
    assert abs(abs(field.hh[np.searchsorted(x, 60.0)]) / expected - 1.0) < 0.05


@pytest.mark.parametrize("polarization", POLARIZATIONS)
@pytest.mark.parametrize("radius_m", [40.0, 80.0])
def test_a_round_crest_returns_what_wave_optics_says(radius_m: float, polarization: str) -> None:
    """From planes that face the ray by 0.1 to the last facet before the horizon, to 1.6 dB in HH, 3.5 dB in VV, whose
    impedance the law takes as a plane's; as a tangent plane the last facet would return 25 to 33 dB less."""
    x = 5.0 + 0.006 * np.arange(13_000)
    impedance = complex(np.sqrt(WATER - 1.0) / WATER)
    wave = surface_field(Profile(x, *crest(x, radius_m)), (0.0, 1e-3), WAVE, impedance)
    field = np.abs(wave.vv if polarization == "VV" else wave.hh) ** 4
    seen, powers = light(lambda at: crest(at, radius_m)[0] + 5.0 - 1e-3)
    power = powers[POLARIZATIONS.index(polarization)][seen.grid.columns // 2]
    chosen = np.flatnonzero((seen.distance > 60.0 - 0.1 * radius_m) & (seen.distance < 60.0))[::2]
    column = seen.grid.columns // 2
    assert seen.ray_slope is not None
    sine = np.sin(np.arctan(seen.slope_look[column, chosen]) + np.arctan(seen.ray_slope[column, chosen]))
    plane = sine if polarization == "HH" else np.abs(sine / (sine + impedance))
    for number, at in enumerate(seen.distance[chosen]):
        judged = field[(x > at - 0.25) & (x < at + 0.25)].mean()
        off_db = 10.0 * np.log10(power[chosen[number]] * plane[number] ** 4 / judged)
        assert abs(off_db) < (1.6 if polarization == "HH" else 3.5), at


@pytest.mark.parametrize("polarization", POLARIZATIONS)
def test_water_behind_a_crest_returns_less_the_deeper_it_lies(polarization: str) -> None:
    """A crest 2 m high at 60 m hides what lies behind it up to 100 m: dark to −10 dB there, all of it back at 145 m."""
    seen, powers = light(lambda at: 2.0 * np.exp(-0.5 * ((at - 60.0) / 3.0) ** 2))
    power = powers[POLARIZATIONS.index(polarization)][seen.grid.columns // 2]
    deep = (seen.distance > 72.0) & (seen.distance < 90.0)
    assert power[deep].max() < 0.1
    assert np.all(np.diff(power[(seen.distance > 75.0) & (seen.distance < 98.0)][::2]) > 0.0)  # towards the light
    assert power[seen.distance > 145.0].min() > 0.5


def test_what_a_radar_sees_does_not_hang_on_the_width_of_columns() -> None:
    """Short waves that run across the look lie by turns too high and too low on chords as wide as a column: the share
    on columns four times as wide is the same to 1 %. By the facets' planes half was visible in VV to 255 m, not 277."""
    shares = []
    for columns in (4, 16):
        keys = {"radar.height_m": 10.0, "radar.sector_deg": [165.0, 195.0], "tracing.columns_per_beam": columns}
        made = load_scene("choppy_sea", keys | {"tracing.facet_m": 0.8})
        grid = polar_grid(Installation(made.radar), made.meshing, 0)
        mesh = surface_mesh(grid, *sea_on_grid(run_sea(made), grid))
        seen = water_powers(mesh, WATER, WAVE)[0] >= 10.0**-0.6
        shares.append(float(seen.mean()))
    assert abs(shares[0] - shares[1]) < 0.01


@pytest.mark.parametrize("number", range(len(POLARIZATIONS)), ids=POLARIZATIONS)
def test_a_profile_returns_what_a_mesh_of_the_same_water_does(number: int) -> None:
    """A crest and its shadow, on corners as far apart: what is lit to 0.5 dB, and as much seen to one facet."""
    seen, powers = light(lambda at: crest(at, 40.0)[0] + 4.5)
    column, near = seen.grid.columns // 2, slice(0, None, 2)
    mesh = powers[number][column, near]
    corner = np.arange(10.0, 150.0, 0.25)
    profile = profile_powers(corner, crest(corner, 40.0)[0][None] - 0.5, WATER, WAVE)[number][0]
    middle = 0.5 * (corner[1:] + corner[:-1])
    lit = (seen.distance[near] < 55.0) & (seen.distance[near] > 15.0)
    found = np.interp(seen.distance[near][lit], middle, profile)
    assert np.abs(10.0 * np.log10(found / mesh[lit])).max() < 0.5
    level = 10.0**-0.6
    share = np.mean(mesh >= level), np.mean(np.interp(seen.distance[near], middle, profile) >= level)
    assert abs(share[0] - share[1]) <= 1.5 / mesh.size
