"""Sea spikes on facets: mean, spread, life and speed against their closed forms."""

from __future__ import annotations

from dataclasses import replace
from functools import cache
from types import SimpleNamespace
from typing import Any, cast

import numpy as np
import pytest
from numpy.typing import NDArray

from seamap_rt.echoes.spike_field import IlluminatedFacets, SpikeField
from seamap_rt.mesh import Facets
from seamap_rt.mesh.grid import polar_grid
from seamap_rt.mesh.surface import surface_mesh
from seamap_rt.radar.installation import Installation
from seamap_rt.scattering.sea_spikes import LONGEST_LIFE, SeaSpikes, sea_spikes
from seamap_rt.scene import load_scene
from seamap_rt.sea import Sea
from seamap_rt.simulation import Simulator, expected, spikes_of
from seamap_rt.tracing import tracer

WIND = 270.0


@cache
def level_sea(turn: int = 0, sector: tuple[float, float] = (0.0, 360.0), height_error_m: float = 0.02) -> Facets:
    """Facets of a sea at rest, to 60 m from the mast."""
    keys = {"radar.sector_deg": list(sector), "tracing.height_error_m": height_error_m}
    scene = load_scene("choppy_sea", {"radar.range_m": [15.0, 60.0], **keys})
    grid = polar_grid(Installation(scene.radar), scene.meshing, turn)
    still = np.zeros((grid.sweep.size, grid.ground_range.size))
    return surface_mesh(grid, still, np.zeros((*still.shape, 3), dtype=np.float32)).facets


@cache
def of_the_wind() -> SeaSpikes:
    found = sea_spikes(8.0, 0.84, 10e9)
    assert found is not None
    return found


def one_class(**changes: Any) -> SeaSpikes:
    """All of the breaking in breakers of 1 m waves, 0.08 of them to a square metre."""
    chosen = {
        "fraction": 0.02,
        "wavelength": np.array([1.0]),
        "share": np.array([1.0]),
        "zone_m2": np.array([0.25]),
        "life_s": np.array([0.25]),
        "speed": np.array([1.25]),
        "angle": of_the_wind().angle[:1],
        "left_speed": 0.0,
        "left_spread": 0.0,
    }
    return SeaSpikes(**(chosen | changes))


def lit(spikes: SeaSpikes, seed: int, facets: Facets | None = None) -> IlluminatedFacets:
    return SpikeField(spikes, seed, WIND).evaluate(facets or level_sea())


def cells(values: NDArray, wide: int, deep: int) -> tuple[NDArray, NDArray]:
    """Means over the area of cells of so many columns and facets, beyond 20 m, and the area of each (range,)."""
    facets = level_sea()
    begin = int(np.searchsorted(facets.distance, 20.0)) // 2 * 2
    columns, count = facets.grid.per_circle // wide * wide, (facets.distance.size - begin) // deep * deep
    area = facets.horizontal_area[begin : begin + count]
    blocks = (values[:columns, begin : begin + count] * area).reshape(-1, wide, count // deep, deep)
    whole = wide * area.reshape(-1, deep).sum(axis=1)
    return blocks.sum(axis=(1, 3)) / whole, whole


@cache
def drawn(seed: int) -> NDArray[np.float32]:
    """Factors of all facets' echoes."""
    return lit(one_class(), seed).factor


def test_the_mean_is_one_at_every_range_and_look() -> None:
    """Over ten draws, within four standard deviations of Campbell's theorem: 3 % of the whole."""
    found = np.mean([cells(drawn(seed), 68, 20)[0] for seed in range(10)], axis=0)
    sigma = np.sqrt(1.0 / one_class().shape(10.0 * cells(np.ones(level_sea().height.shape), 68, 20)[1]))
    assert np.all(np.abs(found - 1.0) < 4.5 * sigma)
    ring = level_sea().horizontal_area * level_sea().grid.per_circle
    assert np.mean(found) == pytest.approx(
        1.0, abs=4.0 / np.sqrt(float(one_class().shape(10.0 * ring[ring > 0].sum())))
    )


def test_the_spread_is_that_of_the_closed_form() -> None:
    """1/variance = ν of cells of 3 m and 18°: 10 % is the scatter of 8 draws of 3000 cells."""
    draws = [cells(drawn(seed), 34, 20)[0] for seed in range(8)]
    area = cells(np.ones(level_sea().height.shape), 34, 20)[1]
    wanted = one_class().shape(area)
    assert np.mean(np.square(np.array(draws) - 1.0) * wanted) == pytest.approx(1.0, abs=0.1)


def test_each_lies_in_its_own_triangle() -> None:
    """Where breakers are is seen on a mesh whose rungs stand closer: to a third of a column. Nearly all light
    the coarse facet in which they are, before the diagonal or beyond it: 93 %, where 7 % would by chance."""
    still = one_class(speed=np.array([1e-6]), life_s=np.array([1e4]), fraction=0.006, wavelength=np.array([0.1]))
    coarse, fine = level_sea(), level_sea(height_error_m=0.003)
    column, facet = np.nonzero(lit(still, 5, fine).factor[: fine.grid.per_circle])
    away = fine.distance[facet]
    angle = fine.grid.column_azimuth[column] + np.degrees(fine.angle[facet])
    rung = (away - coarse.grid.ground_range[0]) / np.diff(coarse.grid.ground_range[:2])
    place = (angle - coarse.grid.azimuth[0]) / coarse.grid.spacing_deg
    near = np.mod(rung, 1.0) - np.mod(place, 1.0)
    inside = [np.abs(np.mod(each + 0.5, 1.0) - 0.5) > 0.2 for each in (rung, place)]
    sure = inside[0] & inside[1] & (np.abs(near) > 0.2) & (away > 20.0) & (away < 60.0)
    assert sure.sum() > 50
    light = lit(still, 5, coarse).factor
    number = np.floor(place[sure]).astype(int) % coarse.grid.per_circle
    lights = light[number, 2 * np.floor(rung[sure]).astype(int) + (near[sure] > 0.0)] > 0.0
    assert np.mean(lights) > 0.85


def later(facets: Facets, seconds: float, sailed: tuple[float, float] = (0.0, 0.0)) -> Facets:
    """The same facets at a later time, about a mast that sailed on by so many metres east and north."""
    pose = facets.grid.column_pose
    moved = replace(pose, time=pose.time + seconds, origin=pose.origin + np.array([*sailed, 0.0]))
    return replace(facets, grid=replace(facets.grid, column_pose=moved))


def remembered(share_of_life: float) -> float:
    """⟨L ∫ g(s) g(s + τ/L) ds⟩/(6/5 ⟨L⟩) of lives L with a cut exponential distribution, by quadrature."""
    life = (np.arange(4000) + 0.5) / 4000 * LONGEST_LIFE
    weight = np.exp(-life) / np.exp(-life).sum()
    mean_life = np.sum(weight * life)
    lag = share_of_life * mean_life
    s = (np.arange(400) + 0.5) / 400

    def g(at: NDArray) -> NDArray:
        return np.where((at > 0.0) & (at < 1.0), 6.0 * at * (1.0 - at), 0.0)

    products = np.mean(g(s) * g(s + lag / life[:, None]), axis=1)
    return float(np.sum(weight * life * products) / (1.2 * mean_life))


@pytest.mark.parametrize("share", [0.1, 0.5, 1.0, 2.0])
def test_they_are_remembered_for_as_long_as_they_live(share: float) -> None:
    """Of breakers that stand still, so that nothing leaves its cell."""
    still = one_class(speed=np.array([1e-6]))
    before, after = (
        np.concatenate([cells(lit(still, seed, at).factor, 34, 20)[0].ravel() - 1.0 for seed in range(5)])
        for at in (level_sea(), later(level_sea(), share * 0.25))
    )
    assert np.mean(before * after) / np.mean(before**2) == pytest.approx(remembered(share), abs=0.06)


def test_who_runs_with_them_sees_them_stand() -> None:
    """A mast that runs down-wind (east) as fast as they do sees the same breakers, of long lives, a little older."""
    spikes = one_class(angle=np.zeros((1, 2)), life_s=np.array([100.0]))
    first = lit(spikes, 3).factor
    along = lit(spikes, 3, later(level_sea(), 0.8, (1.25 * 0.8, 0.0))).factor
    past = lit(spikes, 3, later(level_sea(), 0.8)).factor
    far = level_sea().distance > 20.0
    assert np.corrcoef(first[:, far].ravel(), along[:, far].ravel())[0, 1] > 0.95
    assert np.corrcoef(first[:, far].ravel(), past[:, far].ravel())[0, 1] < 0.3


def test_a_current_carries_them() -> None:
    spikes = one_class(angle=np.zeros((1, 2)), life_s=np.array([100.0]))
    carried = SpikeField(spikes, 3, WIND, current=(0.5, -0.4))
    first = carried.evaluate(level_sea()).factor
    along = carried.evaluate(later(level_sea(), 0.8, (0.8 * 1.75, 0.8 * -0.4))).factor
    far = level_sea().distance > 20.0
    assert np.corrcoef(first[:, far].ravel(), along[:, far].ravel())[0, 1] > 0.95


def test_their_echo_moves_as_the_mean_of_their_waves() -> None:
    """The outward speed, weighted by echo, is −⟨c cos φ⟩ cos(look − wind): 5 % is the scatter of six draws."""
    spikes = one_class(left_speed=0.0)
    cosine = np.cos(np.radians(level_sea().grid.column_azimuth - WIND))
    area = level_sea().horizontal_area
    found = [lit(spikes, seed) for seed in range(6)]
    moment = np.mean([np.sum((each.factor * each.speed * area), axis=1) for each in found], axis=0)
    slope = float(np.sum(moment * cosine) / np.sum(cosine**2) / area.sum())
    assert slope == pytest.approx(-1.25 * float(np.mean(np.cos(spikes.angle))), rel=0.05)


def test_what_is_left_of_them_moves_at_its_own_speed() -> None:
    spikes = replace(of_the_wind(), share=1e-12 * of_the_wind().share)
    found = lit(spikes, 1)
    np.testing.assert_allclose(found.factor, 1.0, rtol=1e-3)
    cosine = np.cos(np.radians(level_sea().grid.column_azimuth - WIND))
    np.testing.assert_allclose(found.speed[:, 5], -spikes.left_speed * cosine, atol=1e-3)


def test_turns_and_sectors_share_their_bits() -> None:
    """A column that two turns hear has the same breakers; a sector has those of the whole circle."""
    first, second = level_sea(0), level_sea(1)
    shared = np.intersect1d(first.grid.column_number, second.grid.column_number)
    assert shared.size > 5
    fields = [lit(of_the_wind(), 2, each) for each in (first, second)]
    for name in ("factor", "speed"):
        one, two = (
            getattr(field, name)[np.isin(facets.grid.column_number, shared)]
            for field, facets in zip(fields, (first, second), strict=True)
        )
        np.testing.assert_array_equal(one, two)
    part = level_sea(0, (0.0, 40.0))
    inside = np.isin(first.grid.column_number, part.grid.column_number)
    np.testing.assert_array_equal(lit(of_the_wind(), 2, part).factor, fields[0].factor[inside])
    assert not np.array_equal(lit(of_the_wind(), 3, part).factor, fields[0].factor[inside])


@pytest.mark.parametrize("sector", [(18.0, 60.0), (252.0, 294.0)])
def test_where_a_sector_begins_it_has_what_the_circle_has(sector: tuple[float, float]) -> None:
    """Breakers that are born beside the first column run into it: of the light of ten columns 2 to 25 % is theirs. The
    last digit of an angle may put a point on the other side of an edge: none of these."""
    part, whole = level_sea(0, sector), level_sea(0)
    begin = int(np.argmin(np.abs(whole.grid.column_azimuth - part.grid.column_azimuth[0])))
    then = whole.grid.column_pose.time[begin] - part.grid.column_pose.time[0]
    for seed in range(2):
        found = lit(one_class(), seed, later(part, then)).factor[:10]
        wanted = lit(one_class(), seed, whole).factor[begin : begin + 10]
        assert np.abs(found - wanted).sum() < 1e-3 * wanted.sum()


def test_the_surface_takes_them_and_the_expectation_does_not() -> None:
    """Breakers' echo times the factor, Bragg waves' as it was; the run's breakers only where they are asked for."""
    scene = load_scene(
        "choppy_sea",
        {
            "tracing.tracer": "horizon",
            "scattering.polarization": "HH",
            "radar.sector_deg": [250.0, 290.0],
            "radar.range_m": [15.0, 80.0],
            "sea.extent_m": 256.0,
            "scattering.sea_spikes": True,
        },
    )
    simulator = Simulator(scene)
    surface, mesh = simulator.surface, simulator.mesh(0)
    assert surface.spikes is not None
    facets = tracer("horizon", scene.radar, scene.scattering)(mesh.levelled)
    terms, field = surface.terms(facets, mesh.strain), surface.spikes.evaluate(facets)
    found, mean = surface(facets, mesh.strain), replace(surface, spikes=None)(facets, mesh.strain)
    bright = terms.breaking * field.factor
    total = terms.bragg + terms.specular + terms.breaking
    change = np.divide(found.rcs, mean.rcs, out=np.ones_like(found.rcs), where=mean.rcs > 0.0)
    wanted = np.divide(
        terms.bragg + terms.specular + bright, total, out=np.ones_like(change), where=(total > 0.0) & (mean.rcs > 0.0)
    )
    np.testing.assert_allclose(change, wanted, rtol=1e-5)
    assert found.motion is not None
    assert found.motion.breaking is not None
    assert found.running is not None
    drift = surface.drift(facets)
    assert drift is not None
    own = found.motion.breaking * found.motion.breaker_speed[:, None] + found.running - drift
    np.testing.assert_allclose(own, found.motion.breaking * field.speed, atol=1e-5)
    calm = scene.model_copy(update={"scattering": scene.scattering.model_copy(update={"sea_spikes": False})})
    np.testing.assert_array_equal(expected(scene)["power"], expected(calm)["power"])
    assert not np.array_equal(expected(scene, spikes=True)["power"], expected(calm)["power"])


def test_without_a_theory_there_are_none() -> None:
    sea = cast(Sea, SimpleNamespace(current=(0.3, 0.0)))
    for changes in ({"scattering.nrcs": "nrl"}, {"scattering.breaking": False}, {"scattering.sea_spikes": False}):
        assert spikes_of(load_scene("choppy_sea", {"scattering.sea_spikes": True, **changes}), sea) is None
    found = spikes_of(load_scene("choppy_sea", {"scattering.sea_spikes": True}), sea)
    assert found is not None
    assert found.current == (0.3, 0.0)
