"""The polar mesh is what it says: its facets' own geometry, its time, its seam, its numbers and its files."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest
import trimesh
from numpy.testing import assert_allclose, assert_array_equal
from numpy.typing import NDArray

from seamap_rt import sea
from seamap_rt.conventions import unit_from_azimuth
from seamap_rt.mesh.facets import FAR_FRACTION, NEAR_FRACTION, chord_point
from seamap_rt.mesh.grid import PolarGrid, polar_grid
from seamap_rt.mesh.surface import MovingSurface, SurfaceMesh, mesh_turn, submerged_lines
from seamap_rt.radar.installation import Installation
from seamap_rt.radar.scan import BEAMS_BEYOND, phase_centres, pulses, sector_width, turn_duration
from seamap_rt.scene import Scene, load_scene
from validation.light.profile import profile

SECTORS = ([0.0, 360.0], [0.0, 350.0], [0.0, 354.0], [0.0, 345.0], [-30.0, 330.0], [200.0, 260.0])


def scene(sector: list[float], **more: Any) -> Scene:
    """A random sea in a short range window: every facet differs from every other."""
    keys = {"radar.range_m": [15.0, 40.0], "sea.extent_m": 150.0, "radar.sector_deg": sector}
    return load_scene("tiny", overrides=keys | {key.replace("__", "."): value for key, value in more.items()})


def mesh_of(made: Scene, turn: int = 0) -> SurfaceMesh:
    return mesh_turn(sea.realize(made.sea, 7), made.radar, made.tracing, turn)


@pytest.fixture(scope="module")
def circle() -> SurfaceMesh:
    """A whole turn of a random sea."""
    return mesh_of(scene([0.0, 360.0]))


@pytest.fixture(scope="module")
def fan() -> SurfaceMesh:
    """A sector of a random sea."""
    return mesh_of(scene([200.0, 260.0]))


def turned(a: NDArray[np.float64], b: NDArray[np.float64]) -> NDArray[np.float64]:
    """a × b in the plan: positive where b lies counter-clockwise of a, seen from above; twice a triangle's area."""
    return a[:, 0] * b[:, 1] - a[:, 1] * b[:, 0]


def facet_points(mesh: SurfaceMesh) -> NDArray[np.float64]:
    """(column, facet, 3): where the facets are tested, above mean sea level."""
    facets, grid = mesh.facets, mesh.grid
    east, north = unit_from_azimuth(grid.column_azimuth[:, None] + np.degrees(facets.angle))
    return np.stack((east * facets.distance, north * facets.distance, facets.height), axis=-1)


# ------------------------------------------------------------------------------------------------- one facet


def test_facet_points_lie_on_their_triangles(fan: SurfaceMesh) -> None:
    """Barycentric coordinates in the plan are positive, and give the height: to rounding at 50 m (1e-14 of it)."""
    corners = fan.world_trimesh.triangles
    points = facet_points(fan).reshape(-1, 3)
    first, second = corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0]
    to_point = points - corners[:, 0]
    whole = turned(first, second)
    b1, b2 = turned(to_point, second) / whole, turned(first, to_point) / whole
    weights = np.stack((1.0 - b1 - b2, b1, b2), axis=1)
    assert weights.min() > 0.1  # well inside: the middle of a path through the inner part, so no edge is near
    assert_allclose(np.einsum("fc,fc->f", weights, corners[:, :, 2]), points[:, 2], rtol=0.0, atol=1e-12)


def test_facet_point_is_the_middle_of_its_planes_path_and_near_the_centroid(fan: SurfaceMesh) -> None:
    """The distance from the centroid is of the order of spacing/range of the facet's own length."""
    centroid = fan.world_trimesh.triangles_center.reshape(facet_points(fan).shape)
    gap = np.linalg.norm(facet_points(fan)[..., :2] - centroid[..., :2], axis=-1)
    facets = fan.facets
    step = np.diff(fan.grid.ground_range)[0]
    size = np.hypot(step, facets.distance * np.radians(fan.grid.spacing_deg))
    assert np.all(gap <= size * step / facets.distance)


def test_slopes_are_those_of_the_triangles(fan: SurfaceMesh) -> None:
    """Against trimesh's face normals, in the frame of the column's middle; stored as float32."""
    normal = fan.world_trimesh.face_normals.reshape(*fan.facets.height.shape, 3)
    gradient = -normal[..., :2] / normal[..., 2:]
    look = np.stack(unit_from_azimuth(fan.grid.column_azimuth), axis=-1)[:, None]
    cross = np.stack(unit_from_azimuth(fan.grid.column_azimuth + 90.0), axis=-1)[:, None]
    half_ulp = 2.0**-24
    for expected, found in (
        ((gradient * look).sum(-1), fan.facets.slope_look),
        ((gradient * cross).sum(-1), fan.facets.slope_cross),
    ):
        assert np.abs(expected).max() > 0.1  # the sea has slopes in both directions
        assert_allclose(found, expected, rtol=2.0 * half_ulp, atol=1e-9)


def test_faces_are_counter_clockwise_from_above(circle: SurfaceMesh) -> None:
    for sheet in circle.sheets():
        surface = circle.trimesh(sheet)
        vertices, faces = surface.vertices, surface.faces
        a, b, c = (vertices[faces[:, i]] for i in range(3))
        assert np.all(turned(b - a, c - a) > 0.0)
    assert np.all(circle.world_trimesh.face_normals[:, 2] > 0.0)


def test_faces_come_column_by_column_near_before_far_outward(fan: SurfaceMesh) -> None:
    plan = fan.world_trimesh.triangles_center.reshape(*fan.facets.height.shape, 3)
    distance = np.hypot(plan[..., 0], plan[..., 1])
    assert np.all(np.diff(distance, axis=1) > 0.0)
    bearing = np.degrees(np.arctan2(plan[..., 0], plan[..., 1])) % 360.0
    assert np.all(np.abs(bearing - fan.grid.column_azimuth[:, None]) < 0.5 * fan.grid.spacing_deg)


@pytest.mark.parametrize("sector", [[0.0, 360.0], [200.0, 260.0]])
def test_horizontal_areas_fill_the_polygon(sector: list[float]) -> None:
    """Sum of the facets' areas against the shoelace formula on the mesh's outline, and each against its triangle."""
    mesh = mesh_of(scene(sector))
    facets, grid = mesh.facets, mesh.grid
    east, north = unit_from_azimuth(grid.azimuth)
    far, near = grid.ground_range[-1], grid.ground_range[0]
    x = np.concatenate((near * east, far * east[::-1]))
    y = np.concatenate((near * north, far * north[::-1]))
    outline = 0.5 * abs(np.sum(x * np.roll(y, -1) - np.roll(x, -1) * y))
    total = grid.columns * facets.horizontal_area.sum()
    assert_allclose(total, outline, rtol=1e-12)
    surface = mesh.trimesh((slice(0, grid.columns),))
    vertices, faces = surface.vertices, surface.faces
    a, b, c = (vertices[faces[:, i]] for i in range(3))
    each = 0.5 * turned(b - a, c - a).reshape(facets.height.shape)
    assert_allclose(each, np.broadcast_to(facets.horizontal_area, each.shape), rtol=1e-11)


def test_velocities_are_the_means_of_the_corners() -> None:
    """A rigid wind of water blowing east and up: look and up components at every facet, whatever its column."""

    class Moving:
        def elevation_and_velocity(self, x: NDArray, y: NDArray, t: NDArray) -> tuple[NDArray, NDArray[np.float32]]:
            velocity = np.empty((*x.shape, 3), dtype=np.float32)
            velocity[...] = (2.0, 1.0, 0.25)
            return np.zeros(x.shape), velocity

    made = scene([0.0, 360.0])
    mesh = mesh_turn(Moving(), made.radar, made.tracing, 0)
    # Each corner looks along its own line, half a column off the middle: two of a facet's three on one side.
    half = 0.5 * mesh.grid.spacing_deg
    for side, members in ((1.0, slice(0, None, 2)), (-1.0, slice(1, None, 2))):
        east, north = unit_from_azimuth(mesh.grid.column_azimuth + side * half / 3.0)
        found = mesh.facets.velocity_look[:, members]
        expected = np.broadcast_to((2.0 * east + north)[:, None], found.shape)
        assert_allclose(found, expected, rtol=0.0, atol=np.hypot(2.0, 1.0) * np.radians(half) ** 2)
    assert_allclose(mesh.facets.velocity_up, 0.25, rtol=1e-6)


def test_facets_close_in_on_the_sea_quadratically() -> None:
    """Halving both spacings leaves a quarter of the error (linear interpolation); each point at its own time."""

    def error(facet_m: float, columns_per_beam: int) -> float:
        made = scene([200.0, 230.0], tracing__facet_m=facet_m, tracing__columns_per_beam=columns_per_beam)
        water = sea.realize(made.sea, 7)
        mesh = mesh_turn(water, made.radar, made.tracing, 0)
        point, grid = facet_points(mesh), mesh.grid
        time = grid.column_time[:, None] + np.degrees(mesh.facets.angle) / 360.0 * turn_duration(made.radar)
        true = water.elevation(point[..., 0], point[..., 1], np.broadcast_to(time, point.shape[:2]))
        return float(np.sqrt(np.mean((point[..., 2] - true) ** 2)))

    coarse, fine = error(0.4, 4), error(0.2, 8)
    # The resolved waves are at least 1.6 m long, 4 rungs: the next order, (kΔ)²/20 of the first, makes up to 12 %.
    assert 3.5 < coarse / fine < 4.5
    assert fine < 0.01


# ------------------------------------------------------------------------------------- lines, time and numbers


@pytest.mark.parametrize("sector", SECTORS)
@pytest.mark.parametrize(("beam", "per_beam"), [(1.8, 4), (5.0, 3)])
def test_columns_run_on_three_beams_before_and_after(sector: list[float], beam: float, per_beam: int) -> None:
    made = scene(
        sector,
        radar__antenna__azimuth_beamwidth_deg=beam,
        tracing__columns_per_beam=per_beam,
    )
    grid = polar_grid(Installation(made.radar), made.tracing, 0)
    width, beyond = sector_width(made.radar), BEAMS_BEYOND * beam
    assert BEAMS_BEYOND == 3.0
    assert grid.spacing_deg <= beam / per_beam
    assert -beyond - grid.spacing_deg < grid.sweep[0] <= -beyond + 1e-9
    assert width + beyond - 1e-9 <= grid.sweep[-1] < width + beyond + 2.0 * grid.spacing_deg
    assert_allclose(np.diff(grid.sweep), grid.spacing_deg, rtol=1e-9)
    assert grid.sweep[-grid.first] == 0.0


@pytest.mark.parametrize("turn", [0, 3])
@pytest.mark.parametrize("rpm", [60.0, 24.0])
def test_lines_are_meshed_when_the_beam_passes(rpm: float, turn: int) -> None:
    """A pulse whose boresight points along a line is fired at that line's time (the scan's own clock)."""
    made = scene([200.0, 260.0], radar__rotation_rpm=rpm)
    grid = polar_grid(Installation(made.radar), made.tracing, turn)
    fired = pulses(Installation(made.radar), turn)
    inside = (grid.sweep >= fired.sweep[0]) & (grid.sweep <= fired.sweep[-1])
    assert inside.sum() > 100
    assert_allclose(grid.time[inside], np.interp(grid.sweep[inside], fired.sweep, fired.time), rtol=0.0, atol=1e-12)
    assert_allclose(
        grid.azimuth[inside], 200.0 + np.interp(grid.sweep[inside], fired.sweep, fired.sweep), rtol=0.0, atol=1e-9
    )
    # … and elevations and velocities are the sea's at that time: a regular wave in closed form.
    wave = load_scene("sinusoid", overrides={"radar.range_m": [15.0, 40.0], "radar.rotation_rpm": rpm})
    mesh = mesh_turn(sea.realize(wave.sea, 1), wave.radar, wave.tracing, turn)
    k = 2.0 * np.pi / 40.0
    omega = np.sqrt(9.81 * k + 0.074 / 1025.0 * k**3)
    east, _ = unit_from_azimuth(mesh.grid.azimuth)
    phase = k * east[:, None] * mesh.grid.ground_range - omega * mesh.grid.time[:, None]
    assert_allclose(mesh.elevation, (40.0 / 60.0) * np.cos(phase), rtol=0.0, atol=1e-9)
    assert_allclose(mesh.velocity_up, (40.0 / 60.0) * omega * np.sin(phase), rtol=0.0, atol=1e-6)
    particle = (40.0 / 60.0) * omega * np.cos(phase) * east[:, None]
    assert_allclose(mesh.velocity_look, particle, rtol=0.0, atol=1e-6)


def test_rungs_start_at_the_mast_and_hold_the_last_gate() -> None:
    made = scene([200.0, 260.0], tracing__facet_m=0.7)
    ranges = polar_grid(Installation(made.radar), made.tracing, 0).ground_range
    assert ranges[0] <= 1.0
    assert_allclose(np.diff(ranges), 0.7, rtol=1e-9)
    assert ranges[-1] > made.far_ground_range


# ------------------------------------------------------------------------------------------- sheets and seam


@pytest.mark.parametrize("sector", SECTORS)
def test_sheets_hold_every_column_once_and_do_not_overlap(sector: list[float]) -> None:
    mesh = mesh_of(scene(sector, tracing__facet_m=2.0))
    grid = mesh.grid
    held = np.concatenate([np.arange(s.start, s.stop) for sheet in mesh.sheets() for s in sheet])
    assert_array_equal(np.sort(held), np.arange(grid.columns))
    for sheet in mesh.sheets():
        columns = np.concatenate([np.arange(s.start, s.stop) for s in sheet])
        assert columns.size > 0
        bearing = np.sort(grid.column_azimuth[columns] % 360.0)
        gaps = np.diff(np.append(bearing, bearing[0] + 360.0))
        assert gaps.min() > grid.spacing_deg * (1.0 - 1e-9)  # middles at least a column apart: no two overlap
        surface = mesh.trimesh(sheet)
        vertices, faces = surface.vertices, surface.faces
        assert faces.min() == 0
        assert faces.max() == len(vertices) - 1
    width = sector_width(load_scene("tiny", overrides={"radar.sector_deg": sector}).radar)
    first = mesh.sheets()[0]
    middle = np.concatenate([grid.column_sweep[s] for s in first])
    inside = (grid.column_sweep > 0.0) & (grid.column_sweep < width)
    assert np.isin(grid.column_sweep[inside], middle).all()  # the turn itself is one sheet


@pytest.mark.parametrize("sector", [[0.0, 360.0], [0.0, 354.0], [200.0, 260.0]])
def test_sheets_are_watertight_between_lines_and_open_at_the_seam(sector: list[float]) -> None:
    """Each slice is one piece whose only open edges are its first and last line, its first and last ring."""
    mesh = mesh_of(scene(sector, tracing__facet_m=1.0))
    rungs = mesh.grid.ground_range.size
    for sheet in mesh.sheets():
        body = mesh.trimesh(sheet)
        vertices, faces = body.vertices, body.faces
        edges, count = np.unique(body.edges_sorted, axis=0, return_counts=True)
        assert count.max() == 2
        around = sum(2 * (columns.stop - columns.start) for columns in sheet)
        assert np.sum(count == 1) == around + 2 * (rungs - 1) * len(sheet)
        assert body.body_count == len(sheet)
        assert body.is_winding_consistent
        # every vertex in use, and V − E + F = 1 for each piece: discs without holes, nothing joined to a ring
        assert np.unique(faces).size == len(vertices)
        assert len(vertices) - len(edges) + len(faces) == len(sheet)


def test_seam_is_a_step_in_time(circle: SurfaceMesh) -> None:
    """The first and the last line of the turn lie at one azimuth, a turn apart in time, and share no vertex."""
    (columns,) = circle.sheets()[0]
    first, last = columns.start, columns.stop
    assert_allclose(circle.grid.azimuth[last] - circle.grid.azimuth[first], 360.0, rtol=1e-12)
    assert_allclose(circle.grid.time[last] - circle.grid.time[first], 1.0, rtol=1e-12)
    assert np.abs(circle.elevation[last] - circle.elevation[first]).max() > 0.1
    rungs = circle.grid.ground_range.size
    faces = circle.world_trimesh.faces // rungs
    assert (np.ptp(faces, axis=1) <= 1).all()


# -------------------------------------------------------------------------------------------------- profiles


@pytest.mark.parametrize("fraction", [FAR_FRACTION, NEAR_FRACTION, 0.111])
@pytest.mark.parametrize("column", [0, 57, 101])
def test_profile_is_the_meshs_own_cut(fan: SurfaceMesh, fraction: float, column: int) -> None:
    """trimesh cuts the column's triangles with the vertical plane; rungs and diagonals come out as its corners."""
    grid = fan.grid
    body = fan.trimesh((slice(column, column + 1),))
    _, angle = chord_point(fraction, grid.spacing_deg)
    east, north = unit_from_azimuth(grid.azimuth[column] + np.degrees(angle))
    segments, cut = trimesh.intersections.mesh_plane(
        body, plane_normal=[float(north), -float(east), 0.0], plane_origin=[0.0, 0.0, 0.0], return_faces=True
    )
    distance = np.hypot(segments[..., 0], segments[..., 1])
    order = np.argsort(distance.mean(axis=1))
    assert_array_equal(np.asarray(cut)[order], np.arange(len(body.faces)))  # every facet once, outward
    along, height = np.sort(distance[order], axis=1), segments[..., 2][order]
    swap = distance[order, 0] > distance[order, 1]
    height[swap] = height[swap][:, ::-1]

    made, origin = profile(fan.elevation, grid, fraction), float(grid.column_height[column, 0])
    corners = np.empty(2 * grid.ground_range.size - 1)
    corners[0::2], corners[1::2] = made.rung_distance, made.diagonal_distance
    heights = np.empty_like(corners)
    heights[0::2], heights[1::2] = made.rung_height[column], made.diagonal_height[column]
    # the cut's own rounding: 1e-16 of 50 m over the sine between plane and edge
    assert_allclose(along[:, 0], corners[:-1], rtol=0.0, atol=1e-10)
    assert_allclose(along[:, 1], corners[1:], rtol=0.0, atol=1e-10)
    assert_allclose(height[:, 0] + origin, heights[:-1], rtol=0.0, atol=1e-10)
    assert_allclose(height[:, 1] + origin, heights[1:], rtol=0.0, atol=1e-10)

    members = {NEAR_FRACTION: slice(0, None, 2), FAR_FRACTION: slice(1, None, 2)}.get(fraction)
    if members is not None:  # the facets that are tested on this plane, in the middle of their segments
        assert_allclose(fan.facets.distance[members], along.mean(axis=1)[members], rtol=0.0, atol=1e-10)
        assert_allclose(fan.facets.height[column, members], height.mean(axis=1)[members] + origin, rtol=0.0, atol=1e-10)
        middle = np.degrees(fan.facets.angle[members]) + 0.5 * grid.spacing_deg
        assert_allclose(middle, np.degrees(angle), rtol=0.0, atol=1e-12)


@pytest.mark.parametrize("fraction", [0.0, 1.0])
def test_profile_at_the_edges_of_a_column_is_its_lines(fan: SurfaceMesh, fraction: float) -> None:
    made = profile(fan.elevation, fan.grid, fraction)
    lines = fan.elevation[1:] if fraction else fan.elevation[:-1]
    assert_allclose(made.rung_height, lines, rtol=0.0, atol=1e-14)
    assert_allclose(made.rung_distance, fan.grid.ground_range, rtol=1e-14)
    assert_allclose(made.diagonal_height, lines[:, 1:] if fraction else lines[:, :-1], rtol=0.0, atol=1e-14)


# ------------------------------------------------------------------------------------------- antennas, water


@pytest.mark.parametrize("tilt", [0.0, 20.0, -15.0])
def test_antennas_are_the_scans_phase_centres(tilt: float) -> None:
    made = scene([200.0, 260.0], radar__tilt_deg=tilt, radar__baseline_m=1.0)
    mesh = mesh_of(made)
    for column in (0, 17):
        azimuth = mesh.grid.column_azimuth[column]
        east, north = unit_from_azimuth(azimuth)
        along, across, above = mesh.grid.antenna_positions[column].T
        origin = float(mesh.grid.column_height[column, 0])
        world = np.stack((along * east + across * north, along * north - across * east, above + origin), axis=-1)
        assert_allclose(world, phase_centres(made.radar, azimuth), rtol=0.0, atol=1e-12)
        assert_allclose(across, 0.0, atol=1e-12)
        assert above[0] < above[1]
    assert np.sign(along[1]) == np.sign(tilt)  # the top leans towards the look


def test_submerged_lines_are_those_where_the_wave_stands_above_the_lower_antenna() -> None:
    """A 3 m wave rises past a 1.2 m mast once in its period; against cos in closed form, line by line."""
    keys = {
        "sea.waves.0.height_m": 3.0,
        "sea.waves.0.wavelength_m": 25.0,
        "sea.waves.0.phase_deg": 180.0,
        "radar.height_m": 1.2,
        "radar.rotation_rpm": 12.0,
        "radar.range_m": [15.0, 20.0],
        "tracing.facet_m": 2.0,
    }
    made = load_scene("sinusoid", overrides=keys)
    water = sea.realize(made.sea, 1)
    mesh = mesh_turn(water, made.radar, made.tracing, 0)
    drowned = submerged_lines(mesh, water)
    k = 2.0 * np.pi / 25.0
    omega = np.sqrt(9.81 * k + 0.074 / 1025.0 * k**3)
    level = 1.5 * np.cos(np.pi - omega * mesh.grid.time)
    assert_array_equal(drowned, level >= 1.2 - 0.1)
    assert 0.1 < drowned.mean() < 0.5
    assert not drowned[-mesh.grid.first]


def test_flat_sea_is_flat() -> None:
    made = load_scene("flat", overrides={"radar.range_m": [15.0, 30.0]})
    facets = mesh_of(made).facets
    for field in (facets.height, facets.slope_look, facets.slope_cross, facets.velocity_look, facets.velocity_up):
        assert_array_equal(field, 0.0)


# ----------------------------------------------------------------------------------------------------- files


@pytest.mark.parametrize("ending", ["ply", "glb", "PLY", "GLB"])
def test_written_mesh_reads_back(circle: SurfaceMesh, tmp_path: Any, ending: str) -> None:
    """Both formats hold float32: half an ulp at 50 m is 2 µm."""
    path = circle.write(tmp_path / f"sea.{ending}")
    assert path == tmp_path / f"sea.{ending}"
    loaded = trimesh.load_mesh(path, process=False)
    assert isinstance(loaded, trimesh.Trimesh)
    assert_array_equal(loaded.faces, circle.world_trimesh.faces)
    assert_array_equal(loaded.vertices.astype(np.float32), circle.world_trimesh.vertices.astype(np.float32))


@pytest.mark.parametrize("name", ["sea.stl", "sea", "sea.ply.txt"])
def test_other_endings_are_refused_in_one_line(circle: SurfaceMesh, tmp_path: Any, name: str) -> None:
    with pytest.raises(ValueError, match=r"\.ply or \.glb") as refusal:
        circle.write(tmp_path / name)
    assert "\n" not in str(refusal.value)
    assert name in str(refusal.value)
    assert not (tmp_path / name).exists()


def test_trimesh_is_the_turn_above_sea_level(circle: SurfaceMesh) -> None:
    (columns,) = circle.sheets()[0]
    z = circle.world_trimesh.vertices[:, 2].reshape(-1, circle.grid.ground_range.size)
    assert_allclose(z, circle.elevation[columns.start : columns.stop + 1], rtol=0.0, atol=1e-14)
    assert len(circle.world_trimesh.faces) == circle.grid.per_circle * circle.facets.height.shape[1]


def test_any_sea_can_be_meshed() -> None:
    """The mesher asks for the protocol, not for the package's own sea."""
    made = scene([200.0, 260.0])
    water: MovingSurface = sea.realize(made.sea, 7)
    grid: PolarGrid = polar_grid(Installation(made.radar), made.tracing, 0)
    assert mesh_turn(water, made.radar, made.tracing, 0).elevation.shape == (grid.columns + 1, grid.ground_range.size)
