"""Points that echo for an object: where they lie, what they sum to, and which of them are in sight."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path
from typing import Any

import numpy as np
import pytest
import trimesh
from numpy.testing import assert_allclose, assert_array_equal
from numpy.typing import NDArray

from seamap_rt.echoes.scenery import EchoingObject, Scatterers, object_scatterers, objects_in_sight, passing
from seamap_rt.io.meshfile import load_mesh
from seamap_rt.settings import ObjectSettings
from seamap_rt.tracing.objects import Occluder, placed

Array = NDArray[np.float64]
OBJECTS = Path(__file__).parents[2] / "scenes" / "objects"
WAVELENGTH = 0.03
ANTENNA = np.array([0.0, 0.0, 5.0])


def box(extents: tuple[float, float, float], centre: tuple[float, float, float] = (0.0, 0.0, 0.0)) -> trimesh.Trimesh:
    return trimesh.creation.box(extents).apply_translation(centre)


def joined(*meshes: trimesh.Trimesh) -> trimesh.Trimesh:
    mesh = trimesh.util.concatenate(meshes)
    assert isinstance(mesh, trimesh.Trimesh)
    return mesh


def plate(width: float, height: float, distance: float) -> trimesh.Trimesh:
    """An open sheet that stands square to the north, on the water."""
    x, z = 0.5 * width, height
    corners = [[-x, distance, 0.0], [x, distance, 0.0], [x, distance, z], [-x, distance, z]]
    return trimesh.Trimesh(corners, [[0, 1, 2], [0, 2, 3]], process=False)


def vessel(**keys: Any) -> trimesh.Trimesh:
    settings = ObjectSettings(**{"mesh": str(OBJECTS / "vessel.ply"), "position_m": (0.0, 100.0, 0.0), **keys})
    return placed(load_mesh(settings), settings)


def drawn(mesh: trimesh.Trimesh, antenna: Any = ANTENNA, rcs: float = 10.0, count: int = 64, **keys: Any) -> Scatterers:
    return object_scatterers(mesh, antenna, rcs, count, **{"wavelength_m": WAVELENGTH, **keys})


def received(points: Scatterers, antenna: Array = ANTENNA, wavelength: float = WAVELENGTH) -> float:
    """The rcs that an antenna sees: exact paths there and back, all at the same range in power."""
    path = 2.0 * np.linalg.norm(points.points - antenna, axis=1)
    return float(np.abs(np.sum(np.sqrt(points.rcs) * np.exp(-2j * np.pi / wavelength * path))) ** 2)


# --------------------------------------------------------------------------------------------------- where they lie


def test_points_lie_on_the_faces_that_look_at_the_antenna() -> None:
    """Of a box to the north-east, higher than the antenna: its south and west sides, above the water."""
    mesh = box((2.0, 4.0, 16.0), (60.0, 60.0, 2.0))
    points = drawn(mesh, count=5000)
    assert points.points.shape == points.normals.shape == (5000, 3)
    assert_allclose(points.rcs, 10.0 / 5000)
    south, west = (np.all(points.normals == side, axis=1) for side in ([0.0, -1.0, 0.0], [-1.0, 0.0, 0.0]))
    assert_array_equal(south, ~west)
    # By area, 2 to 4: a binomial of 5000 is off by 0.7 % rms.
    assert south.mean() == pytest.approx(1.0 / 3.0, abs=0.03)
    # On the face, but for half a wavelength towards the antenna.
    assert_allclose(points.points[south, 1], 58.0, atol=0.5 * WAVELENGTH)
    assert_allclose(points.points[west, 0], 59.0, atol=0.5 * WAVELENGTH)
    assert points.points[:, 2].min() > 0.0
    # Even along the 10 m above water: the mean of 5000 is off by 10/√12/√5000 = 4 cm rms.
    assert points.points[:, 2].mean() == pytest.approx(5.0, abs=0.2)


def test_a_closed_mesh_that_is_inside_out_looks_outward_too() -> None:
    mesh = box((2.0, 4.0, 16.0), (60.0, 60.0, 2.0))
    turned = trimesh.Trimesh(mesh.vertices, mesh.faces[:, ::-1], process=False)
    assert_allclose(drawn(turned).points, drawn(mesh).points, atol=60.0)  # of the same sides
    assert (drawn(turned).normals @ [1.0, 1.0, 0.0] < 0.0).all()


@pytest.mark.parametrize("y", [0.0, 100.0])
def test_an_open_mesh_looks_to_both_sides(y: float) -> None:
    points = drawn(plate(2.0, 3.0, 50.0), (0.0, y, 5.0))
    assert len(points.points) == 64
    assert_array_equal(points.normals, np.broadcast_to([0.0, np.sign(y - 50.0), 0.0], (64, 3)))


def test_what_the_object_hides_of_itself_gets_no_points() -> None:
    """A low wall before a high one: all of the rcs lies on what the antenna can see."""
    mesh = joined(box((10.0, 1.0, 4.0), (0.0, 50.0, 0.0)), box((10.0, 1.0, 8.0), (0.0, 60.0, 0.0)))
    points = drawn(mesh, count=1000, itself=Occluder([mesh]))
    assert points.rcs.sum() == pytest.approx(10.0)
    behind = points.points[:, 1] > 55.0
    # Over the far top edge of the low wall the ray reaches the high one at 5 − 3·59.5/50.5 = 1.47 m, and a margin of
    # stopping 1e-3 of 17 m short lets some in 17 mm lower by less than 1 mm.
    assert points.points[behind, 2].min() > 5.0 - 3.0 * 59.5 / 50.5 - 0.002
    assert 0.3 < behind.mean() < 0.7
    assert (drawn(mesh, count=1000).points[:, 2] < 1.0).sum() > 100  # without it they are everywhere


def test_all_of_a_convex_face_is_seen_at_grazing() -> None:
    """A deck 1 m high at 300 m, a ray of 0.8°: the object's own rounding does not hide it."""
    mesh = box((4.0, 12.0, 2.0), (0.0, 300.0, 0.0))
    with_itself, without = drawn(mesh, itself=Occluder([mesh])), drawn(mesh)
    assert (without.normals[:, 2] == 1.0).mean() > 0.5
    assert_array_equal(with_itself.points, without.points)


def test_points_stay_on_the_object() -> None:
    """Carried along with antenna and all, nothing changes; seen from a little aside, most are the same."""
    shift = np.array([30.0, -20.0, 0.0])
    here, there = drawn(vessel()), drawn(vessel(position_m=(30.0, 80.0, 0.0)), ANTENNA + shift)
    assert_allclose(there.points - shift, here.points, atol=1e-9)
    aside = drawn(vessel(), (5.0, 0.0, 5.0))
    apart = np.linalg.norm(aside.points[:, None] - here.points, axis=2).min(axis=1)
    assert np.mean(apart < 2e-3) > 0.8  # they lean after the antenna by 3° of up to 15 mm
    assert_array_equal(drawn(vessel(), seed=4).points, drawn(vessel(), seed=np.random.SeedSequence(4)).points)
    assert not np.isclose(drawn(vessel(), seed=5).points, drawn(vessel(), seed=4).points).any()


def test_nothing_in_view_echoes_nothing() -> None:
    points = drawn(box((2.0, 2.0, 2.0), (0.0, 50.0, -5.0)))  # under water
    assert points.points.shape == points.normals.shape == (0, 3)
    assert points.rcs.shape == (0,)
    few = drawn(box((2.0, 2.0, 20.0), (0.0, 50.0, -9.999)), (0.0, 0.0, 0.0005))  # a millimetre of it is above
    assert 0 < len(few.points) < 64
    assert few.rcs.sum() == pytest.approx(10.0)


# --------------------------------------------------------------------------------------------------- what they sum to


@pytest.mark.parametrize(
    "mesh",
    [plate(0.3, 6.0, 100.0), plate(0.003, 0.003, 100.0), box((1.0, 1.0, 3.0), (3.0, 100.0, 0.0)), vessel()],
    ids=["a plate face on", "a speck", "a box", "a vessel"],
)
def test_the_mean_over_draws_is_the_rcs(mesh: trimesh.Trimesh) -> None:
    """Without the points' own lengths a speck would echo 64 times its rcs. Power is nearly exponential: 1/64 less."""
    power = np.array([received(drawn(mesh, seed=seed)) for seed in range(1000)])
    assert power.mean() == pytest.approx(10.0, rel=0.16)  # 5 of 1/√1000
    assert power.std() == pytest.approx(10.0, rel=0.25)  # of an exponential: √(8/1000)/2 = 4.5 % rms


def test_the_mean_over_aspects_is_the_rcs() -> None:
    """One vessel turns before the radar, 0.5° a step, by which 12 m of it turn by several wavelengths."""
    power = np.array([received(drawn(vessel(heading_deg=float(turn)))) for turn in np.arange(-180.0, 180.0, 0.5)])
    assert power.mean() == pytest.approx(10.0, rel=0.19)  # 5 of 1/√720
    assert np.corrcoef(power[1:], power[:-1])[0, 1] == pytest.approx(0.0, abs=0.19)


def test_the_mean_over_frequencies_is_the_rcs() -> None:
    """Fixed points, 8 to 12 GHz: some 12 m of depth turn over in 12.5 MHz."""
    points = drawn(vessel(heading_deg=30.0))
    power = [received(points, wavelength=299_792_458.0 / f) for f in np.linspace(8e9, 12e9, 400)]
    assert np.mean(power) == pytest.approx(10.0, rel=0.35)  # 5 of 1/√(4 GHz/12.5 MHz), and the few points' own


def test_a_moving_boat_sees_it_glint_and_a_fixed_one_does_not() -> None:
    mesh = vessel()
    assert received(drawn(mesh)) == received(drawn(mesh))
    sailed = np.stack((np.arange(200.0), np.zeros(200), np.full(200, 5.0)), axis=1)
    power = np.array([received(drawn(mesh, place), place) for place in sailed])
    assert power.std() > 0.5 * power.mean()


# -------------------------------------------------------------------------------------------------- which are in sight


def clear(origin: Array, target: Array) -> NDArray[np.bool_]:
    return np.ones(len(target), dtype=bool)


def turn(
    pulses: int = 3600, antennas: Sequence[float] = (4.9, 5.1), sailed: float = 0.0
) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
    """Centres (pulse, antenna, 3) and azimuths of one turn of a boat that sails so far east."""
    share = np.arange(pulses) / pulses
    centres = np.zeros((pulses, len(antennas), 3))
    centres[..., 0] = sailed * share[:, None]
    centres[..., 2] = antennas
    return centres, 360.0 * share


def sight(
    meshes: Sequence[trimesh.Trimesh], sees: Any = clear, pulses: Any = None, seed: int = 1
) -> tuple[Array, Array, NDArray[np.bool_]]:
    """Of the first mesh alone, which echoes; the others only hide."""
    things = [EchoingObject(0, meshes[0], 10.0)]
    centres, azimuth = turn() if pulses is None else pulses
    return objects_in_sight(things, Occluder(meshes), sees, centres, azimuth, wavelength_m=WAVELENGTH, seed=seed)


def test_all_of_a_lone_object_is_in_sight() -> None:
    _, areas, seen = sight([vessel(position_m=(40.0, 60.0, 0.0), heading_deg=75.0)])
    assert areas.sum() == pytest.approx(10.0)
    assert seen.shape == (2, 64)
    # What one antenna does not see of what their middle sees lies behind edges, 0.1 m · (depth/range) up.
    assert seen.mean() > 0.95


def test_what_the_sea_hides() -> None:
    """The callable says which: here all below a crest 1 m high."""
    places, _, seen = sight([box((2.0, 2.0, 6.0), (0.0, 80.0, 0.0))], lambda _, target: target[:, 2] > 1.0)
    assert_array_equal(seen, np.stack([places[:, 2] > 1.0] * 2))
    # Of its side above water 2 × 2 m of 2 × 3, and the 2 × 2 m on top: 8 of 10, and 5 σ of 64 points.
    assert seen.mean() == pytest.approx(0.8, abs=0.25)


def test_what_other_objects_hide() -> None:
    """A wall 3 m high halfway: of two antennas the upper one sees further down."""
    wall = box((50.0, 1e-6, 6.0), (0.0, 40.0, 0.0))
    pulses = turn(antennas=(4.0, 6.0))
    places, _, seen = sight([box((2.0, 2.0, 12.0), (0.0, 81.0, 0.0)), wall], pulses=pulses)
    for antenna, height in enumerate((4.0, 6.0)):
        over = height + (3.0 - height) * places[:, 1] / 40.0
        assert_array_equal(seen[antenna], places[:, 2] > over)
    assert 0.0 < seen[0].mean() < seen[1].mean()


def test_sight_is_that_of_the_moment_when_the_beam_passes() -> None:
    """The boat sails 100 m east in a turn. A post hides the thing in the west at the start, and no longer at 270°."""
    thing, post = box((1.0, 1.0, 6.0), (-60.0, 0.0, 0.0)), box((0.5, 0.5, 30.0), (0.0, 30.0, 0.0))
    centres, azimuth = turn(sailed=100.0)
    origins = []

    def remember(origin: Array, target: Array) -> NDArray[np.bool_]:
        origins.append(origin)
        return clear(origin, target)

    _, _, seen = sight([thing, post], remember, (centres, azimuth))
    assert seen.all()
    assert_allclose(np.concatenate(origins)[:, 0], 75.0, atol=0.2)  # three quarters of the turn


def test_the_pulse_that_passes_a_place() -> None:
    centres, azimuth = turn(sailed=10.0)
    places = np.array([[0.0, 100.0, 0.0], [-100.0, 0.0, 3.0], [2.5, -70.0, 0.0]])
    found = passing(places, centres[:, 0], azimuth)
    away = places - centres[found, 0]
    bearing = np.degrees(np.arctan2(away[:, 0], away[:, 1])) % 360.0
    assert_allclose((bearing - azimuth[found] + 180.0) % 360.0, 180.0, atol=0.06)  # half of 0.1° a pulse


def test_objects_have_points_of_their_own() -> None:
    """Equal objects at equal places: the number in the scene makes the draw."""
    mesh = vessel()
    things = [EchoingObject(number, mesh, 10.0) for number in (0, 4)]
    centres, azimuth = turn()
    places, areas, _ = objects_in_sight(
        things, Occluder([mesh, mesh], [0, 4]), clear, centres, azimuth, wavelength_m=WAVELENGTH, seed=1
    )
    assert areas.sum() == pytest.approx(20.0)
    assert not np.isclose(places[:64], places[64:]).all(axis=1).any()
    assert not np.isclose(places[:64], sight([mesh], seed=2)[0]).all(axis=1).any()
    assert_array_equal(places[:64], sight([mesh])[0])


def test_no_objects_and_no_rcs() -> None:
    centres, azimuth = turn()
    places, areas, seen = objects_in_sight([], Occluder([]), clear, centres, azimuth, wavelength_m=WAVELENGTH, seed=1)
    assert (places.shape, areas.shape, seen.shape) == ((0, 3), (0,), (2, 0))
    silent = ObjectSettings(mesh="a.stl", position_m=(0.0, 0.0, 0.0))
    assert EchoingObject.of(silent, 0, vessel()) is None
    loud = EchoingObject.of(silent.model_copy(update={"rcs_dbsm": 20.0}), 2, vessel())
    assert loud is not None
    assert (loud.number, loud.rcs_m2) == (2, pytest.approx(100.0))
