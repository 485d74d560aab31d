"""Patches of breakers: the law's variance at any wind and grazing, mean 1, and patches that live and run as stated."""

from __future__ import annotations

from types import SimpleNamespace
from typing import Any, cast

import numpy as np
import pytest
from numpy.typing import NDArray

from seamap_rt.conventions import GRAVITY
from seamap_rt.echoes.texture_field import TextureField
from seamap_rt.mesh import Facets
from seamap_rt.scattering import clutter_shape_watts_wicks90
from seamap_rt.scattering.texture import Texture
from seamap_rt.scene import load_scene
from seamap_rt.simulation import Simulator, expected, texture_of
from seamap_rt.tracing import tracer

WINDS = (4.0, 8.0, 14.0)


def square(time_s: float = 0.0, east_m: float = 0.0, side_m: float = 4000.0, step_m: float = 4.0) -> Facets:
    """Looks to the north, side by side: a square of sea at one time."""
    at = step_m * np.arange(round(side_m / step_m))
    pose = SimpleNamespace(origin=np.stack((at + east_m, 0.0 * at, 0.0 * at), axis=1), time=np.full(at.size, time_s))
    grid = SimpleNamespace(column_azimuth=np.zeros(at.size), column_pose=pose)
    return cast(Facets, SimpleNamespace(height=np.zeros((at.size, at.size)), distance=at, grid=grid))


def field(wind: float = 8.0, seed: int = 1, **keys: Any) -> TextureField:
    """Before a wind from the west."""
    return TextureField(Texture.of(wind), seed, 270.0, **keys)


def logarithm(found: TextureField, facets: Facets, grazing: float = 0.05) -> NDArray[np.float64]:
    return np.log(found.evaluate(facets, np.full(facets.distance.size, grazing)).astype(np.float64))


@pytest.mark.parametrize("wind", WINDS)
@pytest.mark.parametrize("grazing_deg", [0.5, 2.0, 8.0])
def test_a_cell_as_large_as_the_longest_breaker_has_the_laws_shape(wind: float, grazing_deg: float) -> None:
    texture = Texture.of(wind)
    shape = clutter_shape_watts_wicks90(grazing_deg, float(texture.size_m[0]) ** 2, "HH")
    assert np.expm1(texture.variance(np.radians(grazing_deg))) == pytest.approx(1.0 / shape)
    assert texture.share.sum() == pytest.approx(1.0)
    # The law's fall with the area: A^(5/8) is ℓ^(5/4), twofold in 2^(5/4).
    np.testing.assert_allclose(texture.share[:-1] / texture.share[1:], 2.0**1.25)


@pytest.mark.parametrize("wind", WINDS)
def test_a_patch_lives_a_period_and_runs_half_its_length_meanwhile(wind: float) -> None:
    """As groups of waves of its length do: √(2πℓ/g), on deep water; surface tension shortens it at 3 m by 4e-6."""
    texture = Texture.of(wind)
    np.testing.assert_allclose(texture.life_s, np.sqrt(2.0 * np.pi * texture.size_m / GRAVITY), rtol=1e-4)
    np.testing.assert_allclose(texture.speed_m_s * texture.life_s, 0.5 * texture.size_m, rtol=1e-4)


@pytest.mark.parametrize("wind", WINDS)
def test_its_mean_is_one_and_its_logarithm_has_the_variance(wind: float) -> None:
    grazing, side = 0.05, 100.0 * float(Texture.of(wind).size_m[0])
    looks = square(side_m=side, step_m=side / 500.0)
    drawn = np.array([logarithm(field(wind, seed), looks, grazing) for seed in range(8)])
    variance = float(Texture.of(wind).variance(grazing))
    # A square holds 36 patches of the largest octave, 1/50 of the variance, 10⁴ of the smallest: eight squares know the
    # variance to 2 %, and the mean to 0.02 of its deviation.
    assert drawn.var() == pytest.approx(variance, rel=0.06)
    assert drawn.mean() == pytest.approx(-0.5 * variance, abs=0.06 * np.sqrt(variance))
    assert np.exp(drawn).mean() == pytest.approx(1.0, abs=0.1)
    by_place = drawn.reshape(8, 50, 10, 50, 10).transpose(2, 4, 0, 1, 3).reshape(100, -1)
    assert by_place.var(axis=1) == pytest.approx(variance, rel=0.15)  # at nodes and between them alike


@pytest.mark.parametrize("current", [(0.0, 0.0), (0.0, 1.5)])
def test_patches_run_before_the_wind_and_live(current: tuple[float, float]) -> None:
    """One octave alone: where it correlates best a while later, and how much of it is left."""
    whole = Texture.of(8.0)
    one = Texture(*(each[1:2] for each in whole))._replace(share=np.ones(1))
    made = TextureField(one, 1, 270.0, current)
    later = 0.25 * float(one.life_s[0])
    first, then = (logarithm(made, square(time)) for time in (0.0, later))
    first, then = first - first.mean(), then - then.mean()
    found = np.fft.ifft2(np.fft.fft2(then) * np.fft.fft2(first).conj()).real / first.size / first.var()
    east, north = (int(each) for each in np.unravel_index(np.argmax(found), found.shape))
    moved = 4.0 * np.array([(each + 500) % 1000 - 500 for each in (east, north)])
    wanted = later * np.array([one.speed_m_s[0] + current[0], current[1]])
    np.testing.assert_allclose(moved, wanted, atol=4.0)  # a step of the grid
    # A number goes over into the next as cos a, sin a: over δ = 22.5° cos δ is left, and of the quarter that meanwhile
    # changed over ½(cos δ + sin δ/δ).
    step = np.pi / 8
    left = 0.75 * np.cos(step) + 0.125 * (np.cos(step) + np.sin(step) / step)
    assert found.max() == pytest.approx(left, abs=0.02)


def test_a_patch_is_the_same_in_whichever_part_of_a_turn_it_is_met() -> None:
    whole = field().evaluate(square(3.0), np.full(1000, 0.05))
    part = field().evaluate(square(3.0, east_m=400.0), np.full(1000, 0.05))
    np.testing.assert_allclose(part[:800], whole[100:900], rtol=1e-5)
    assert not np.allclose(field(seed=2).evaluate(square(3.0), np.full(1000, 0.05)), whole)


@pytest.mark.parametrize(("azimuth", "start"), [(90.0, 0.0), (270.0, 796.0)])
def test_a_place_has_one_texture_from_wherever_it_is_met(azimuth: float, start: float) -> None:
    """A row of places from the west or from the east, and from the south as the square is."""
    at = 4.0 * np.arange(200)
    pose = SimpleNamespace(origin=np.array([[start, 0.0, 0.0]]), time=np.array([3.0]))
    grid = SimpleNamespace(column_azimuth=np.array([azimuth]), column_pose=pose)
    row = cast(Facets, SimpleNamespace(height=np.zeros((1, 200)), distance=at, grid=grid))
    (met,) = field().evaluate(row, np.full(200, 0.05))
    wanted = field().evaluate(square(3.0, side_m=800.0), np.full(200, 0.05))[:, 0]
    np.testing.assert_allclose(met if azimuth == 90.0 else met[::-1], wanted, rtol=1e-4)


def test_the_surface_takes_it_on_breakers_alone_and_the_expectation_does_not() -> None:
    keys = {
        "tracing.tracer": "horizon", "scattering.texture": True, "scattering.sea_spikes": False,
        "radar.range_m": [15.0, 90.0],
        "radar.sector_deg": [250.0, 280.0], "sea.extent_m": 260.0, "sea.resolution_m": 2.0,
    }  # fmt: skip
    scene = load_scene("choppy_sea", keys)
    simulator = Simulator(scene)
    surface, mesh = simulator.surface, simulator.mesh(0)
    facets = tracer("horizon", scene.radar, scene.scattering)(mesh.levelled)
    assert surface.texture is not None
    assert surface.scale is not None
    terms = surface.terms(facets, mesh.strain)
    bright = terms.breaking * surface.texture.evaluate(facets, surface.grazing(facets))
    scale = surface.scale(surface.grazing(facets), surface.wind(facets))
    wanted = (terms.bragg + terms.specular + bright) * scale
    np.testing.assert_allclose(surface(facets, mesh.strain).rcs, wanted, rtol=1e-4, atol=1e-12)
    calm = scene.model_copy(update={"scattering": scene.scattering.model_copy(update={"texture": False})})
    np.testing.assert_array_equal(expected(scene)["power"], expected(calm)["power"])
    for changes in ({"scattering.nrcs": "nrl"}, {"scattering.breaking": False}, {"scattering.texture": False}):
        assert texture_of(load_scene("choppy_sea", keys | changes), simulator.sea) is None
