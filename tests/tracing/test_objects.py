"""What objects hide: against closed-form shadows, against every triangle in float64, and in the corners."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np
import pytest
import trimesh
from numpy.testing import assert_allclose, assert_array_equal
from numpy.typing import NDArray

from seamap_rt.io.meshfile import load_mesh
from seamap_rt.radar.pose import boat_axes
from seamap_rt.settings import ObjectSettings
from seamap_rt.tracing.objects import Occluder, placed, refuse_if_enclosing, to_boat, to_world

Array = NDArray[np.float64]
OBJECTS = Path(__file__).parents[2] / "scenes" / "objects"
DISAGREEMENT = 1e-4  # share of rays: those within a hair, 2e-6 of its size, of an object's outline


def encloses(mesh: trimesh.Trimesh, point: tuple[float, float, float]) -> bool:
    return Occluder([mesh]).bodies[0].encloses(np.array(point))


def box(extents: tuple[float, float, float], centre: tuple[float, float, float] = (0.0, 0.0, 0.0)) -> trimesh.Trimesh:
    return trimesh.creation.box(extents).apply_translation(centre)


def stands(**keys: Any) -> ObjectSettings:
    return ObjectSettings(**{"mesh": "none.stl", "position_m": (0.0, 0.0, 0.0), **keys})


def vessel(**keys: Any) -> trimesh.Trimesh:
    settings = stands(mesh=str(OBJECTS / "vessel.ply"), **keys)
    return placed(load_mesh(settings), settings)


def exactly_blocked(mesh: trimesh.Trimesh, origin: Array, target: Array) -> NDArray[np.bool_]:
    """Every segment against every triangle, float64 (Möller & Trumbore 1997)."""
    first, second, third = np.moveaxis(np.asarray(mesh.triangles), 1, 0)
    one, two = second - first, third - first
    way = (target - origin)[:, None]
    across = np.cross(way, two)
    with np.errstate(divide="ignore", invalid="ignore"):
        scale = 1.0 / np.sum(across * one, axis=-1)
        away = origin[:, None] - first
        u = np.sum(away * across, axis=-1) * scale
        turned = np.cross(away, one)
        v = np.sum(way * turned, axis=-1) * scale
        t = np.sum(two * turned, axis=-1) * scale
    return np.any((u >= 0.0) & (v >= 0.0) & (u + v <= 1.0) & (t > 0.0) & (t < 1.0), axis=1)


def through_box(bounds: Any, origin: Array, target: Array) -> NDArray[np.bool_]:
    """Whether segments pass through an upright box: slab by slab."""
    low, high = np.asarray(bounds)
    with np.errstate(divide="ignore"):
        enter, leave = (low - origin) / (target - origin), (high - origin) / (target - origin)
    near, far = np.minimum(enter, leave).max(axis=1), np.maximum(enter, leave).min(axis=1)
    return (near < far) & (far > 0.0) & (near < 1.0)


def random_segments(count: int, size: float, seed: int = 1) -> tuple[Array, Array]:
    """From well outside an object of that size at the origin to anywhere about it."""
    random = np.random.default_rng(seed)
    origin = random.normal(size=(count, 3))
    origin *= 3.0 * size / np.linalg.norm(origin, axis=1)[:, None]
    return origin, random.uniform(-1.5 * size, 1.5 * size, (count, 3))


# ------------------------------------------------------------------------------------------ closed-form shadows


@pytest.mark.parametrize("antenna", [5.0, 12.0])
@pytest.mark.parametrize("height", [0.5, 2.0, 4.9, 5.0, 8.0])
@pytest.mark.parametrize("distance", [20.0, 75.0])
def test_a_plate_shadows_the_flat_sea(antenna: float, height: float, distance: float) -> None:
    """From d to d H/(H − h), and for good where it is as high as the antenna. Facets every 0.25 m, middles off it."""
    plate = box((4.0, 1e-6, 2.0 * height), (0.0, distance, 0.0))  # half of it under water
    along = np.arange(1.125, 600.0, 0.25)
    target = np.stack((np.zeros_like(along), along, np.zeros_like(along)), axis=1)
    blocked = Occluder([plate]).blocked((0.0, 0.0, antenna), target)
    ends = distance * antenna / (antenna - height) if height < antenna else np.inf
    # Where height and antenna are equal rays run along its top: dark but for rounding, 1e-7 of its size per facet.
    assert_array_equal(blocked, (along > distance) & (along < ends))


def test_a_plate_shadows_its_own_width() -> None:
    """Sideways, too: at twice the distance twice as wide."""
    plate = box((4.0, 0.01, 6.0), (0.0, 50.0, 0.0))
    x = np.arange(-9.95, 10.0, 0.1)
    target = np.stack((x, np.full_like(x, 100.0), np.zeros_like(x)), axis=1)
    edge = 2.0 * 100.0 / (50.0 - 0.005)  # its near side casts the shadow's edge
    assert_array_equal(Occluder([plate]).blocked((0.0, 0.0, 5.0), target), np.abs(x) < edge)


def test_a_box_in_the_way() -> None:
    mesh = box((2.0, 6.0, 1.5))
    origin, target = random_segments(200_000, 6.0)
    exact = through_box(mesh.bounds, origin, target)
    assert 0.02 < exact.mean() < 0.98
    assert np.mean(Occluder([mesh]).blocked(origin, target, 0.0) != exact) < DISAGREEMENT


def test_a_sphere_in_the_way() -> None:
    """Whatever passes within the largest sphere inside the mesh is blocked, what stays out of the one around is not."""
    mesh = trimesh.creation.icosphere(5, radius=3.0).apply_translation([40.0, -300.0, 2.0])
    centre = np.array([40.0, -300.0, 2.0])
    inside = np.abs(np.sum((mesh.triangles_center - centre) * mesh.face_normals, axis=1)).min()
    random = np.random.default_rng(2)
    target = centre + random.uniform(-9.0, 9.0, (100_000, 3)) + [1.0, -60.0, 0.0]
    way = target / np.linalg.norm(target, axis=1)[:, None]
    passes = np.linalg.norm(centre - (way @ centre)[:, None] * way, axis=1)
    blocked = Occluder([mesh]).blocked((0.0, 0.0, 0.0), target)
    assert 0.05 < blocked.mean() < 0.5
    assert blocked[passes < inside - 1e-5].all()
    assert not blocked[passes > 3.0 + 1e-5].any()
    assert inside > 2.998


def test_a_vessel_against_each_of_its_triangles() -> None:
    mesh = vessel()
    origin, target = random_segments(40_000, 6.0, 3)
    exact = exactly_blocked(mesh, origin, target)
    assert 0.02 < exact.mean() < 0.98
    assert np.mean(Occluder([mesh]).blocked(origin, target, 0.0) != exact) < DISAGREEMENT


def test_far_away_it_is_as_exact_as_near() -> None:
    """20 km off float32 would err by millimetres: objects are told from their own middle."""
    mesh = box((0.2, 0.3, 0.1))
    origin, target = random_segments(100_000, 0.3, 4)
    shift = np.array([20_000.0, -15_000.0, 3.0])
    exact = through_box(mesh.bounds, origin, target)
    mesh.apply_translation(shift)
    assert np.mean(Occluder([mesh]).blocked(origin + shift, target + shift, 0.0) != exact) < DISAGREEMENT


# -------------------------------------------------------------------------------------- edges, corners, endings


def test_no_ray_slips_through_edges_and_corners() -> None:
    """Rays aimed at the edges (the sides' diagonals among them) and corners of a box, that go on through it."""
    mesh = box((2.0, 4.0, 1.0), (3.0, 100.0, 1.0))
    random = np.random.default_rng(5)
    edge = np.asarray(mesh.edges_unique)[random.integers(len(mesh.edges_unique), size=50_000)]
    share = random.choice([0.0, 0.25, 0.5, 1.0], 50_000)[:, None]
    aim = np.asarray(mesh.vertices)[edge[:, 0]] * share + np.asarray(mesh.vertices)[edge[:, 1]] * (1.0 - share)
    origin = aim + 20.0 * random.normal(size=aim.shape)
    target = aim + 0.9 * (aim - origin)
    # Those that only brush the box, passing outside a millimetre smaller one, may do either.
    low, high = np.asarray(mesh.bounds)
    through = through_box((low + 1e-3, high - 1e-3), origin, target)
    assert through.sum() > 10_000
    assert Occluder([mesh]).blocked(origin, target)[through].all()


def test_no_ray_slips_through_a_sheet() -> None:
    """Nothing stands behind its edges."""
    ball = trimesh.creation.icosphere(3, radius=5.0)
    mesh = trimesh.Trimesh(ball.vertices, ball.faces[ball.triangles_center[:, 1] < 0.0], process=False)
    random = np.random.default_rng(9)
    edge = mesh.face_adjacency_edges[random.integers(len(mesh.face_adjacency_edges), size=50_000)]
    share = random.choice([0.0, 0.25, 0.5, 0.9], 50_000)[:, None]
    aim = mesh.vertices[edge[:, 0]] * share + mesh.vertices[edge[:, 1]] * (1.0 - share)
    way = random.uniform(-20.0, 20.0, aim.shape) * [1.0, 0.0, 1.0] + [0.0, 40.0, 0.0]
    onto = np.sum(way * aim, axis=1) < -0.3 * np.linalg.norm(way, axis=1) * 5.0  # well in from its outline
    onto &= aim[:, 1] < -1.0  # and from its rim
    assert onto.sum() > 20_000
    assert Occluder([mesh]).blocked((aim - way)[onto], (aim + 0.02 * way)[onto]).all()


def test_a_ray_in_the_plane_of_an_upright_edge() -> None:
    """The line of sight of a whole column may lie in the plane of a corner and of the sides' diagonals."""
    mesh = box((2.0, 2.0, 6.0)).apply_transform(trimesh.transformations.rotation_matrix(np.pi / 4, [0, 0, 1]))
    mesh.apply_translation([0.0, 50.0, 0.0])
    along = np.arange(55.0, 200.0, 0.1)
    target = np.stack((np.zeros_like(along), along, np.zeros_like(along)), axis=1)
    blocked = Occluder([mesh]).blocked((0.0, 0.0, 5.0), target)
    ends = (50.0 + np.sqrt(2.0)) * 5.0 / 2.0  # over its far corner
    assert_array_equal(blocked, along < ends)


def test_a_pier_hides_what_is_just_behind_its_face() -> None:
    """The sea a centimetre before its wall is lit; a centimetre behind, in the very same facet, it is dark."""
    pier = box((200.0, 10.0, 6.0), (0.0, 105.0, 0.0))
    y = np.array([99.0, 99.99, 99.998, 100.002, 100.01, 101.0, 109.0])
    target = np.stack((np.full_like(y, 7.3), y, np.zeros_like(y)), axis=1)
    assert_array_equal(Occluder([pier]).blocked((0.0, 0.0, 5.0), target), y > 100.0)


def test_a_ray_ends_short_of_what_it_is_aimed_at() -> None:
    """Points on the near face are seen, those on the far face are not."""
    mesh = box((2.0, 2.0, 2.0), (0.0, 30.0, 1.0))
    x = np.linspace(-0.99, 0.99, 1001)
    near, far = (np.stack((x, np.full_like(x, y), 1.0 + x), axis=1) for y in (29.0, 31.0))
    occluder = Occluder([mesh])
    assert not occluder.blocked((0.0, 0.0, 5.0), near).any()
    assert occluder.blocked((0.0, 0.0, 5.0), far).all()
    # Without it, rounding decides: the ending is there for a reason.
    assert occluder.blocked((0.0, 0.0, 5.0), near, 0.0).any()


def test_an_object_beyond_the_target_or_behind_the_antenna_hides_nothing() -> None:
    occluder = Occluder([box((4.0, 4.0, 4.0), (0.0, 50.0, 5.0))])
    target = [[0.0, 45.0, 5.0], [0.0, -50.0, 5.0], [0.0, 50.0, 5.0], [0.0, 60.0, 5.0]]
    assert_array_equal(occluder.blocked((0.0, 0.0, 5.0), target), [False, False, True, True])


def test_each_ray_has_its_own_origin() -> None:
    """A boat that passes an object sees what it hid."""
    occluder = Occluder([box((2.0, 2.0, 20.0), (0.0, 50.0, 0.0))])
    x = np.arange(-10.0, 11.0)
    origin = np.stack((x, np.zeros_like(x), np.full_like(x, 5.0)), axis=1)
    assert_array_equal(occluder.blocked(origin, np.broadcast_to((0.0, 100.0, 0.0), (21, 3))), np.abs(x) <= 2.0)


def test_what_is_not_finite_and_no_objects_at_all() -> None:
    target = np.array([[0.0, 100.0, 0.0], [np.nan, 100.0, 0.0], [np.inf, 0.0, 0.0], [0.0, 0.0, 5.0]])
    occluder = Occluder([box((2.0, 2.0, 20.0), (0.0, 50.0, 0.0))])
    assert_array_equal(occluder.blocked((0.0, 0.0, 5.0), target), [True, False, False, False])
    assert not Occluder([]).blocked((0.0, 0.0, 5.0), target).any()


def test_shadows_of_several_objects_add() -> None:
    meshes = [box((2.0, 2.0, 4.0), (x, y, 0.0)) for x, y in ((0.0, 50.0), (1.5, 56.0), (-10.0, 40.0))]
    random = np.random.default_rng(6)
    target = random.uniform([-20.0, 30.0, 0.0], [20.0, 100.0, 0.1], (50_000, 3))
    together = Occluder(meshes, [0, 2, 5])
    one_by_one = [Occluder([mesh]).blocked((0.0, 0.0, 5.0), target) for mesh in meshes]
    assert_array_equal(together.blocked((0.0, 0.0, 5.0), target), np.any(one_by_one, axis=0))
    assert_array_equal(together.single_object(2).blocked((0.0, 0.0, 5.0), target), one_by_one[1])


def test_only_what_may_meet_an_object_is_traced() -> None:
    """An object over 2 % of the azimuths, 2.3° to either side: no ray elsewhere or before it, and the same answer of
    more segments than are worked on at once as of few."""
    mesh = trimesh.creation.icosphere(3, radius=4.0).apply_translation([100.0, 0.0, 0.0])
    azimuth, distance = np.radians(np.arange(0.0, 360.0, 0.5))[:, None], np.arange(1.0, 400.0, 1.0)
    x, y = distance * np.sin(azimuth), distance * np.cos(azimuth)
    target = np.stack((x, y, np.zeros_like(x)), axis=-1).reshape(-1, 3)
    occluder = Occluder([mesh])
    whole = occluder.blocked((0.0, 0.0, 5.0), target)
    assert 0 < whole.sum() <= occluder.rays < 0.02 * len(target)
    few = [occluder.blocked((0.0, 0.0, 5.0), part) for part in np.array_split(target, 7)]
    assert_array_equal(np.concatenate(few), whole)


# ---------------------------------------------------------------------------------------------- places and frames


@pytest.mark.parametrize(("heading", "bow"), [(0.0, (0.0, 6.0)), (90.0, (6.0, 0.0)), (-135.0, (-4.2426, -4.2426))])
def test_a_heading_turns_clockwise(heading: float, bow: tuple[float, float]) -> None:
    mesh = vessel(heading_deg=heading, position_m=(10.0, 20.0, 0.5))
    foremost = np.asarray(mesh.vertices)[np.argmax(np.asarray(vessel().vertices)[:, 1])]
    assert_allclose(foremost[:2], (10.0 + bow[0], 20.0 + bow[1]), atol=0.06)  # the stem is 0.1 m wide
    assert mesh.bounds[0, 2] == pytest.approx(-0.3, abs=1e-6)
    assert mesh.volume > 0.0


def test_boat_axes_there_and_back() -> None:
    random = np.random.default_rng(7)
    points, origin = random.normal(size=(40, 5, 3)), random.normal(size=(40, 1, 3))
    axes = boat_axes(random.uniform(-40.0, 40.0, (40, 1, 3)))
    there = to_world(points, origin, axes)
    assert_allclose(to_boat(there, origin, axes), points, atol=1e-14)
    assert_allclose(np.linalg.norm(there - origin, axis=-1), np.linalg.norm(points, axis=-1), rtol=1e-13)
    # Heading east and level: starboard is south.
    assert_allclose(to_world((2.0, 3.0, 1.0), (10.0, 0.0, 0.0), boat_axes((0.0, 0.0, 90.0))), (13.0, -2.0, 1.0))


def test_a_boat_fixed_object_turns_with_the_boat() -> None:
    """Segments told in the boat's axes, against the object carried into the world."""
    mesh = box((1.0, 0.5, 4.0), (0.5, -3.0, 3.0))
    origin, axes = np.array([7.0, -2.0, 0.3]), boat_axes((12.0, -6.0, 200.0))
    moved = trimesh.Trimesh(to_world(mesh.vertices, origin, axes), mesh.faces, process=False)
    antenna = to_world((0.0, 0.0, 5.0), origin, axes)
    random = np.random.default_rng(8)
    target = antenna + random.normal(size=(50_000, 3)) * [100.0, 100.0, 2.0]
    boat = Occluder([mesh]).blocked(to_boat(antenna, origin, axes), to_boat(target, origin, axes))
    world = Occluder([moved]).blocked(antenna, target)
    assert boat.any()
    assert np.mean(boat != world) < DISAGREEMENT


# ------------------------------------------------------------------------------------------------------ enclosed


def test_what_encloses_a_point() -> None:
    closed = box((2.0, 2.0, 2.0))
    open_above = trimesh.Trimesh(closed.vertices, closed.faces[closed.face_normals[:, 2] < 0.5], process=False)
    assert encloses(closed, (0.0, 0.0, 0.0))
    assert encloses(closed, (0.99, -0.99, 0.99))
    assert not encloses(closed, (1.01, 0.0, 0.0))
    assert not encloses(open_above, (0.0, 0.0, 0.0))
    assert not encloses(vessel(), (0.0, 2.5, 5.0))  # within its bounds, over the foredeck
    assert encloses(vessel(), (0.0, -1.0, 2.5))  # in the wheelhouse


def test_a_mesh_with_cracks_encloses_still() -> None:
    """Each triangle drawn in by 0.2 %, so that none meets its neighbour: nothing is watertight, or inside in."""
    sphere = trimesh.creation.icosphere(2, radius=2.0)
    middle = sphere.triangles_center[:, None]
    corners = (middle + 0.998 * (sphere.triangles - middle)).reshape(-1, 3)
    faces = np.arange(len(corners)).reshape(-1, 3)
    faces[::2] = faces[::2, ::-1]
    mesh = trimesh.Trimesh(corners, faces, process=False)
    assert not mesh.is_watertight
    assert encloses(mesh, (0.3, -1.0, 0.2))
    assert not encloses(mesh, (1.9, 1.9, 0.0))


def test_an_enclosed_antenna_is_refused() -> None:
    occluder = Occluder([box((1.0, 1.0, 1.0), (50.0, 0.0, 0.0)), box((4.0, 4.0, 12.0))], [0, 3])
    refuse_if_enclosing(occluder, [[0.0, -3.0, 4.9], [0.0, -3.0, 5.1]])
    path = np.zeros((1000, 2, 3))  # a boat that sails through it
    path[..., 1] = np.linspace(-30.0, 30.0, 1000)[:, None]
    path[..., 2] = 5.0
    with pytest.raises(
        ValueError, match=r"^objects\.3: encloses the antenna at \(0, .*; move it by objects\.3\.pos"
    ) as e:
        refuse_if_enclosing(occluder, path)
    assert "\n" not in str(e.value)
