"""The ray stage: what is left out of the tree, where rays start and end, edges that leak nothing, and the horizon."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace
from typing import Any

import numpy as np
import pytest
from numpy.testing import assert_allclose, assert_array_equal
from numpy.typing import NDArray

from seamap_rt import sea
from seamap_rt.conventions import unit_from_azimuth
from seamap_rt.mesh import SurfaceMesh, surface_mesh
from seamap_rt.mesh.facets import FAR_FRACTION, NEAR_FRACTION
from seamap_rt.mesh.grid import PolarGrid
from seamap_rt.scene import Scene, load_scene
from seamap_rt.simulation import Simulator
from seamap_rt.tracing.hiding import hiding_facets
from seamap_rt.tracing.horizon import trace_horizon
from seamap_rt.tracing.illumination import mitsuba
from seamap_rt.tracing.rays import RayTracer, SeaScene, occluding_surface
from seamap_rt.tracing.shadow_rays import shadow_rays
from validation.light.profile import profile

WATER = 55.0 - 37.5j


def scene(name: str, **keys: Any) -> Scene:
    return load_scene(name, overrides={key.replace("__", "."): value for key, value in keys.items()})


_MESHES: dict[str, SurfaceMesh] = {}


def mesh_of(made: Scene) -> SurfaceMesh:
    """The first turn's, made once."""
    key = made.model_dump_json()
    if key not in _MESHES:
        _MESHES[key] = Simulator(made).mesh(0)
    return _MESHES[key]


def rings(made: Scene, height: Callable[[NDArray[np.float64]], NDArray[np.float64]]) -> SurfaceMesh:
    """The mesh of a surface at rest whose height depends on the ground range alone."""
    grid = mesh_of(made).grid
    elevation = np.tile(height(grid.ground_range), (grid.sweep.size, 1))
    return surface_mesh(grid, elevation, np.zeros((*elevation.shape, 3), dtype=np.float32))


def with_and_without(mesh: SurfaceMesh) -> tuple[list[NDArray[np.bool_]], list[NDArray[np.bool_]], float]:
    """Light of each sheet by all its triangles, by those that can be hit; and the share of facets left out."""
    whole, part, out = [], [], []
    for sheet in mesh.sheets():
        rays = shadow_rays(mesh, mesh.facets, sheet)
        antennas = mesh.grid.antenna_positions[sheet[0].start]
        whole.append(rays.lit_facets(SeaScene(mesh.trimesh(sheet), antennas, 10e9, WATER).hits(rays)))
        surface = occluding_surface(mesh, sheet, rays)
        part.append(rays.lit_facets(SeaScene(surface, antennas, 10e9, WATER).hits(rays)))
        walls = sum(2 * (2 * mesh.grid.ground_range.size + each.stop - each.start - 2) for each in sheet)
        out.append(1.0 - (len(surface.faces) - walls) / rays.facing_away.size)
    return whole, part, float(np.mean(out))


# ------------------------------------------------------------------------------------- what can be left out


@pytest.mark.parametrize(
    ("name", "keys", "least"),
    [
        ("choppy_sea", {"radar__sector_deg": [250.0, 260.0], "radar__height_m": 2.0}, 0.7),  # below the crests
        ("choppy_sea", {"radar__sector_deg": [90.0, 100.0], "sea__model": "choppy"}, 0.7),
        ("choppy_sea", {"radar__sector_deg": [0.0, 10.0], "radar__tilt_deg": 40.0, "radar__baseline_m": 1.0}, 0.2),
        ("rough_ride", {"radar__sector_deg": [250.0, 265.0]}, 0.6),  # heels and heaves: antennas beside the look
        ("tiny", {"radar__range_m": [15.0, 80.0]}, 0.8),  # a full turn: two sheets, and a seam in the first
    ],
)
def test_facets_that_stop_no_ray_first_change_no_light(name: str, keys: dict[str, Any], least: float) -> None:
    """Not of one facet, of either antenna; least: the share left out at least, or the law would be kept by none."""
    whole, part, out = with_and_without(mesh_of(scene(name, **keys)))
    assert out > least
    for one, other in zip(whole, part, strict=True):
        assert 0.05 < one.mean() < 0.95
        assert_array_equal(one, other)


def met_and_kept(mesh: SurfaceMesh) -> tuple[NDArray[np.int64], NDArray[np.bool_], float]:
    """The facets that rays meet first in the whole sheet, once for each ray that does not come through its sides, as
    Mitsuba finds them; which (facet,) are kept; and the rays' number."""
    (sheet,) = mesh.sheets()
    rays = shadow_rays(mesh, mesh.facets, sheet)
    held = SeaScene(mesh.trimesh(sheet), mesh.grid.antenna_positions[0], 10e9, WATER)
    found = held.mi_scene.ray_intersect_preliminary(rays.traced)
    column = rays.number // rays.front.shape[2] % rays.columns.size
    inside = np.abs(column - 0.5 * (rays.columns.size - 1)) < 0.5 * rays.columns.size - 9.0
    met = np.array(found.prim_index)[np.isfinite(np.array(found.t)) & inside].astype(np.int64)
    kept = hiding_facets(mesh, sheet, rays)
    assert kept.mean() < 0.9 * (1.0 - rays.facing_away.mean())
    return met, kept.ravel(), rays.number.size


def beside(grid: PolarGrid, aside: float) -> PolarGrid:
    """With antennas so far beside the axis: ahead, and to the left."""
    leaning = grid.column_pose.offsets + aside * np.array([0.6, 0.8, 0.0])
    return replace(grid, column_pose=replace(grid.column_pose, offsets=leaning))


@pytest.mark.parametrize("aside", [0.0, 0.3, 0.9])
def test_each_facet_that_a_ray_meets_first_is_kept(aside: float) -> None:
    """Found by Mitsuba in the whole sheet, also for antennas beside the axis, over a plain of lone spikes.

    Sharper than the law above: a facet left out by mistake may still have another behind it that stops the ray.
    """
    made = scene("flat", radar__sector_deg=[90.0, 130.0], radar__range_m=[15.0, 70.0], radar__height_m=6.0)
    grid = beside(mesh_of(made).grid, aside)
    spikes = np.random.default_rng(7).random((grid.azimuth.size, grid.ground_range.size)) < 0.15
    rough = np.where(spikes, 1.0, 0.0)
    met, kept, rays = met_and_kept(surface_mesh(grid, rough, np.zeros((*rough.shape, 3), dtype=np.float32)))
    assert met.size > 0.15 * rays
    assert np.all(kept[met])


@pytest.mark.parametrize("rung", [6, 10])
@pytest.mark.parametrize("over", [1.0, 1.05])
def test_a_crest_that_only_just_hides_what_lies_behind_it_is_kept(rung: int, over: float) -> None:
    """A ring on a plain, 6 m below antennas 0.9 m beside the axis of columns 6° wide: as high as hides the plain up to
    1.3 m behind it from the axis, or a little higher, so that some antennas see that and others do not."""
    keys = {"radar__antenna__azimuth_beamwidth_deg": 18.0, "radar__height_m": 6.0}
    made = scene("flat", radar__sector_deg=[60.0, 180.0], radar__range_m=[15.0, 30.0], **keys)
    grid = beside(mesh_of(made).grid, 0.9)
    away = grid.ground_range[rung]
    ring = np.where(np.arange(grid.ground_range.size) == rung, over * 6.0 * 1.3 / (away + 1.3), 0.0)
    rough = np.tile(ring, (grid.azimuth.size, 1))
    met, kept, _ = met_and_kept(surface_mesh(grid, rough, np.zeros((*rough.shape, 3), dtype=np.float32)))
    assert met.size > 10
    assert np.all(kept[met])


def test_rays_that_pass_below_the_first_rung_stay_dark() -> None:
    """A crater's rim at the first rung, above the antenna, that falls outward: all of it is turned away.

    The whole sheet stops the rays where they would come up again; without it the wall under the rim has to, and nothing
    else is left: all lies below the line of sight over the rim.
    """
    made = scene("flat", radar__sector_deg=[90.0, 92.0], radar__range_m=[15.0, 60.0])
    mesh = rings(made, lambda r: np.maximum(6.0 - 2.0 * (r - 1.0), 0.0))
    whole, part, out = with_and_without(mesh)
    assert out == 1.0
    assert whole[0].size > 0
    for lit in (whole[0], part[0], trace_horizon(mesh).lit):
        assert not lit.any()


def test_a_large_turn_is_traced_in_parts() -> None:
    """By one scene and that of the last, narrower part; the light is that of the whole. A leaning turn stays in one."""
    made = scene("choppy_sea", radar__sector_deg=[250.0, 270.0])
    upright, leaning = mesh_of(made), mesh_of(scene("rough_ride", radar__sector_deg=[250.0, 265.0]))
    whole = [RayTracer(made.radar, made.scattering)(mesh) for mesh in (upright, leaning)]
    columns = upright.grid.columns // 3 - 1
    parted = RayTracer(made.radar, made.scattering, most_facets=columns * upright.facets.distance.size)
    light = parted(upright)
    assert [key[3] for key in parted.scenes] == [(columns,), (upright.grid.columns - 3 * columns,)]
    assert_array_equal(light.lit, whole[0].lit)
    assert light.rays == whole[0].rays
    assert_array_equal(parted(leaning).lit, whole[1].lit)
    assert len(parted.scenes) == 3


def test_nothing_is_left_out_under_an_antenna_that_leans_over_the_sea() -> None:
    """It may be under water, from where facets are met from below."""
    made = scene("tiny", radar__tilt_deg=60.0, radar__baseline_m=4.0, radar__sector_deg=[260.0, 270.0])
    whole, part, out = with_and_without(mesh_of(made))
    assert out == pytest.approx(0.0, abs=1e-12)
    assert_array_equal(whole[0], part[0])


def test_facets_facing_away_are_seen_from_the_front_by_no_antenna_of_the_turn() -> None:
    """By the corners in float64, from every column's antennas."""
    mesh = mesh_of(scene("rough_ride", radar__sector_deg=[250.0, 265.0]))
    (sheet,) = mesh.sheets()
    rays = shadow_rays(mesh, mesh.facets, sheet)
    surface = mesh.trimesh(sheet)
    vertices, faces = surface.vertices, surface.faces
    corners = vertices[faces[rays.facing_away.ravel()]]
    normal = np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0])
    antennas = rays.starts.astype(np.float64)
    above = np.max([np.sum(normal * (place - corners[:, 0]), axis=1) / normal[:, 2] for place in antennas], axis=0)
    assert 0.1 < rays.facing_away.mean() < 0.9
    assert above.max() < 0.0
    assert not np.any(rays.front & rays.facing_away)


# ----------------------------------------------------------------------------------- where rays start and end


def unequal(mesh: SurfaceMesh) -> SurfaceMesh:
    """The mesh with rungs whose spacing grows outward, 0.5 to 2 m, over a sinusoid of 17 m."""
    count = mesh.grid.ground_range.size
    grid = replace(mesh.grid, ground_range=1.0 + np.cumsum(np.linspace(0.5, 2.0, count)))
    elevation = np.tile(0.6 * np.sin(2.0 * np.pi * grid.ground_range / 17.0), (grid.sweep.size, 1))
    return surface_mesh(grid, elevation, np.zeros((*elevation.shape, 3), dtype=np.float32))


@pytest.mark.parametrize("spaced", ["equal", "unequal"])
def test_rays_end_inside_their_own_facet(spaced: str) -> None:
    """Seen from above, every end lies in its facet: before the point, and far out 0.3 of the local rung spacing."""
    mesh = mesh_of(scene("choppy_sea", radar__sector_deg=[250.0, 260.0]))
    mesh = unequal(mesh) if spaced == "unequal" else mesh
    (sheet,) = mesh.sheets()
    rays = shadow_rays(mesh, mesh.facets, sheet)
    ends = rays.starts[rays.start].astype(np.float64) + rays.direction.T * rays.length[:, None].astype(np.float64)
    surface = mesh.trimesh(sheet)
    vertices, faces = surface.vertices, surface.faces
    _, column, facet = np.unravel_index(rays.number, rays.front.shape)
    corners = vertices[faces.reshape(*rays.front.shape[1:], 3)[column, facet]]
    edges = np.roll(corners, -1, axis=1) - corners
    to_end = ends[:, None] - corners
    inside = edges[..., 0] * to_end[..., 1] - edges[..., 1] * to_end[..., 0]
    assert np.all(inside > 0.0)
    bearing = np.radians(mesh.grid.column_azimuth[rays.columns][column]) + mesh.facets.angle[facet]
    point = np.stack((np.sin(bearing), np.cos(bearing)), axis=1) * mesh.facets.distance[facet, None]
    assert np.all(np.hypot(ends[:, 0], ends[:, 1]) < mesh.facets.distance[facet])
    short = np.hypot(*(point - ends[:, :2]).T)
    spacing = np.repeat(np.diff(mesh.grid.ground_range), 2)[facet]
    assert np.all(short > 0.2 * spacing)
    # Beyond a hundred spacings a facet's two planes are a third and two thirds of a rectangle: 1 % of 0.3.
    distant = mesh.facets.distance[facet] > 100.0 * spacing
    assert_allclose(short[distant] / spacing[distant], 0.3, rtol=0.0, atol=0.004)


def two_sheets() -> tuple[SurfaceMesh, tuple[slice, ...]]:
    """A turn that runs on beyond the circle, on a boat that heels, and its second sheet: two slices of columns."""
    mesh = mesh_of(scene("rough_ride", radar__sector_deg=[0.0, 360.0], radar__range_m=[15.0, 80.0]))
    _, sheet = mesh.sheets()
    assert len(sheet) == 2
    return mesh, sheet


def test_rays_run_from_their_antenna_to_their_facets_point() -> None:
    """Reckoned once more in float64, of columns that are not all neighbours.

    float32 knows a place 80 m away to within 4e-6 m: four roundings on the way to it are 2e-5 m.
    """
    mesh, sheet = two_sheets()
    grid, facets, rays = mesh.grid, mesh.facets, shadow_rays(mesh, mesh.facets, sheet)
    antenna, column, facet = np.unravel_index(rays.number, rays.front.shape)
    column = rays.columns[column]
    places = grid.column_pose.offsets[column, antenna]
    assert_allclose(rays.starts[rays.start], places, rtol=0.0, atol=1e-6)
    bearing = np.radians(grid.column_azimuth[column]) + facets.angle[facet]
    point = facets.distance[facet] * np.stack((np.sin(bearing), np.cos(bearing)))
    away = np.stack((*point, facets.rise[column, facet])) - places.T
    slant = np.linalg.norm(away, axis=0)
    assert_allclose(np.linalg.norm(rays.direction, axis=0), 1.0, rtol=0.0, atol=3e-7)
    assert_allclose(rays.direction * slant, away, rtol=0.0, atol=2e-5)


def test_rays_go_column_by_column_outward_the_antennas_side_by_side() -> None:
    """One for each facet that shows an antenna its upper side; neighbours in a packet of rays meet the same waves."""
    mesh, sheet = two_sheets()
    rays = shadow_rays(mesh, mesh.facets, sheet)
    column, facet, antenna = np.nonzero(np.moveaxis(rays.front, 0, -1))
    assert_array_equal(rays.number, np.ravel_multi_index((antenna, column, facet), rays.front.shape))
    assert_array_equal(rays.first, np.searchsorted(column, np.arange(rays.columns.size + 1)))


def test_lit_are_the_facets_whose_rays_hit_nothing_and_no_others() -> None:
    """Light is the bits of the answers, on the facets that have a ray."""
    mesh, sheet = two_sheets()
    rays = shadow_rays(mesh, mesh.facets, sheet)
    hit = np.random.default_rng(1).random(rays.number.size) < 0.4
    expected = np.zeros(rays.front.shape, dtype=bool)
    expected[np.unravel_index(rays.number[~hit], rays.front.shape)] = True
    assert_array_equal(rays.lit_facets(hit), expected)


def test_unequal_rungs_are_lit_as_the_horizon_has_it() -> None:
    made = scene("choppy_sea", radar__sector_deg=[250.0, 260.0])
    mesh = unequal(mesh_of(made))
    rays, horizon = RayTracer(made.radar, made.scattering)(mesh).lit, trace_horizon(mesh).lit
    assert 0.1 < horizon.mean() < 0.9
    assert np.mean(rays != horizon) < 2e-4


# --------------------------------------------------------------------------------------- edges leak nothing


def aimed(place: NDArray[np.float64], targets: NDArray[np.float64]) -> tuple[Any, NDArray[np.float64]]:
    """Mitsuba's rays from a place to points (n, 3) and 1 % beyond, and where they end (n, 3)."""
    mi, away = mitsuba(), targets - place
    length = np.linalg.norm(away, axis=1)
    direction, length = (away / length[:, None]).astype(np.float32), (1.01 * length).astype(np.float32)
    axes = [mi.Float(np.ascontiguousarray(axis)) for axis in direction.T]
    start = mi.Point3f(*(mi.Float(float(part)) for part in place))
    ray = mi.Ray3f(o=start, d=mi.Vector3f(*axes), maxt=mi.Float(length), time=mi.Float(0.0), wavelengths=[])
    return ray, place + direction * length[:, None]


@pytest.mark.parametrize("edge", ["radial", "diagonal", "rung"])
def test_no_ray_slips_between_two_facets(edge: str) -> None:
    """Through nine points of each inner edge of one kind: where a ray ends under the sheet it has crossed it, so the
    number of those that hit nothing is exactly nil. Of tests that are not watertight 1 in 10 would slip through the
    radial edges, along which the rays run.
    """
    mesh = mesh_of(scene("choppy_sea", radar__sector_deg=[250.0, 260.0], radar__height_m=12.0, tracing__facet_m=0.5))
    (sheet,) = mesh.sheets()
    start = mesh.grid.column_pose.offsets[0, 0]
    held = SeaScene(mesh.trimesh(sheet), mesh.grid.antenna_positions[sheet[0].start], 10e9, WATER)
    corners = mesh.vertices(sheet).reshape(-1, mesh.grid.ground_range.size, 3)
    one, other = {
        "radial": (corners[3:-3, 3:-12], corners[3:-3, 4:-11]),
        "diagonal": (corners[3:-3, 3:-12], corners[4:-2, 4:-11]),
        "rung": (corners[3:-3, 3:-12], corners[4:-2, 3:-12]),
    }[edge]
    sure = 0
    for part in np.linspace(0.1, 0.9, 9):
        shot, ends = aimed(start, (one + part * (other - one)).reshape(-1, 3))
        under = below(mesh, ends)
        assert held.stopped(shot)[under].all()
        sure += int(under.sum())
    assert sure > 100_000


def below(mesh: SurfaceMesh, points: NDArray[np.float64]) -> NDArray[np.bool_]:
    """Which points lie well under the water: 5 cm below all corners of their quadrilateral."""
    grid = mesh.grid
    azimuth = np.degrees(np.arctan2(points[:, 0], points[:, 1]))
    line = ((azimuth - grid.azimuth[0]) % 360.0 / grid.spacing_deg).astype(np.intp)
    rung = np.searchsorted(grid.ground_range, np.hypot(points[:, 0], points[:, 1])) - 1
    lowest = np.min([mesh.elevation[line + i, rung + j] for i in (0, 1) for j in (0, 1)], axis=0)
    return np.asarray(points[:, 2] < lowest - mesh.grid.column_height[0] - 0.05)


# ------------------------------------------------------------------------------------------------ the horizon


def sights(mesh: SurfaceMesh, antenna: int, first: int) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
    """Tangents (column, facet) of the elevation angles of one plane's facets, and the highest of the corners before."""
    grid = mesh.grid
    along = grid.antenna_positions[:, antenna, 0, None]
    above = grid.column_height + grid.antenna_positions[:, antenna, 2, None]
    chain = profile(mesh.elevation, grid, (NEAR_FRACTION, FAR_FRACTION)[first])
    tangent = np.empty((grid.columns, 2 * chain.rung_distance.size - 1))
    tangent[:, 0::2] = (chain.rung_height - above) / (chain.rung_distance - along)
    tangent[:, 1::2] = (chain.diagonal_height - above) / (chain.diagonal_distance - along)
    assert np.all(chain.rung_distance > along)
    seen = (mesh.facets.height[:, first::2] - above) / (mesh.facets.distance[first::2] - along)
    return seen, np.maximum.accumulate(tangent, axis=1)[:, first::2][:, : seen.shape[1]]


@pytest.mark.parametrize("facet_m", [0.5, 0.8])
def test_rays_and_horizon_part_only_where_a_ray_grazes_a_crest(facet_m: float) -> None:
    """Less than 0.02 % of the facets, by less than float32 can tell: heights of some metres are rounded by 0.3 µm, and
    0.03 mm at 400 m by some 1 µm along rays that fall by a few per cent."""
    made = scene("choppy_sea", radar__sector_deg=[240.0, 300.0], tracing__facet_m=facet_m)
    mesh = mesh_of(made)
    rays, horizon = RayTracer(made.radar, made.scattering)(mesh).lit, trace_horizon(mesh).lit
    differ = rays != horizon
    assert 0.2 < horizon.mean() < 0.9
    assert differ.mean() < 2e-4
    for antenna in (0, 1):
        for first in (0, 1):
            seen, highest = sights(mesh, antenna, first)
            clearance = np.abs(seen - highest) * mesh.facets.distance[first::2]
            assert np.all(clearance[differ[antenna, :, first::2]] < 3e-6)
            assert np.mean(clearance < 3e-6) < 1e-4  # few facets are as near by chance


@pytest.mark.parametrize("name", ["choppy_sea", "rough_ride"])
def test_horizon_is_the_running_maximum_of_the_profiles_to_the_bit(name: str) -> None:
    """Written once more, over whole arrays."""
    mesh = mesh_of(scene(name, radar__sector_deg=[250.0, 265.0], radar__tilt_deg=5.0))
    facets = trace_horizon(mesh)
    for antenna in (0, 1):
        for first in (0, 1):
            seen, highest = sights(mesh, antenna, first)
            assert_array_equal(facets.lit[antenna, :, first::2], seen > highest)


# ------------------------------------------------------------------------------------------------ front sides


def test_front_is_where_the_antenna_stands_above_the_facets_plane() -> None:
    """By corners and cross products in float64.

    Slopes are float32, so where the antenna stands within 3e-8 × 800 m of the plane it may fall either way: 1e-4 m is
    four times that.
    """
    mesh = mesh_of(scene("rough_ride", radar__sector_deg=[250.0, 265.0]))
    (sheet,) = mesh.sheets()
    rays = shadow_rays(mesh, mesh.facets, sheet)
    grid = mesh.grid
    look = np.radians(grid.column_azimuth)
    corners = np.empty((grid.columns, mesh.facets.distance.size, 3, 3))
    # In the column's own frame: lines half a column askew, heights above mean sea level.
    surface = mesh.trimesh(sheet)
    vertices, faces = surface.vertices, surface.faces
    vertices = vertices.reshape(grid.sweep.size, -1, 3) + grid.pose.origin[:, None] * (0.0, 0.0, 1.0)
    corners = vertices.reshape(-1, 3)[faces].reshape(corners.shape)
    normal = np.cross(corners[:, :, 1] - corners[:, :, 0], corners[:, :, 2] - corners[:, :, 0])
    for antenna in (0, 1):
        along = grid.antenna_positions[:, antenna, 0]
        east, north = unit_from_azimuth(np.degrees(look))
        # The front test knows the antenna in the vertical plane of the look.
        place = np.stack(
            (along * east, along * north, grid.antenna_positions[:, antenna, 2] + grid.column_height[:, 0]), axis=1
        )
        above = np.einsum("cfi,cfi->cf", normal, place[:, None] - corners[:, :, 0]) / normal[..., 2]
        sure = np.abs(above) > 1e-4
        assert sure.mean() > 0.99
        assert_array_equal(rays.front[antenna][sure], above[sure] > 0.0)


def test_light_of_a_sector_is_that_of_the_whole_turn() -> None:
    """Rays ask nothing of columns that lie beside their own: what a sector is lit by does not depend on its width."""
    made = [scene("tiny", radar__sector_deg=each, radar__range_m=[15.0, 80.0]) for each in ([0.0, 60.0], [0.0, 90.0])]
    light = []
    for each in made:
        water = sea.realize(each.sea, 3)
        grid = mesh_of(each).grid
        east, north = unit_from_azimuth(grid.azimuth)
        x, y = east[:, None] * grid.ground_range, north[:, None] * grid.ground_range
        elevation, velocity = water.elevation_and_velocity(x, y, np.zeros_like(x))
        lit = RayTracer(each.radar, each.scattering)(surface_mesh(grid, elevation, velocity)).lit
        light.append(lit[:, -grid.first : -grid.first + 100])
    assert_array_equal(*light)
