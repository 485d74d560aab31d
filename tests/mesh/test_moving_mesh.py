"""The mesh of a boat that moves: each line where the antenna is when the beam passes it, and turns that join."""

from __future__ import annotations

from itertools import pairwise
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from numpy.testing import assert_allclose, assert_array_equal
from numpy.typing import NDArray

from seamap_rt import sea
from seamap_rt.conventions import unit_from_azimuth, wrap_degrees
from seamap_rt.errors import InputError
from seamap_rt.mesh.grid import PolarGrid, polar_grid
from seamap_rt.mesh.surface import SurfaceMesh, sea_on_grid, submerged_lines, surface_mesh
from seamap_rt.radar.installation import Installation
from seamap_rt.radar.scan import pulses, sector_width
from seamap_rt.resolved_scene import installation_of, run_sea
from seamap_rt.scene import Scene, load_scene

LEVEL, EAST, NORTH = 0.4, 0.03, -0.05  # of the plane z = 0.4 + 0.03 x − 0.05 y
MOVING = {
    "platform.motion": "sinusoidal",
    "platform.roll_deg": 12.0,
    "platform.pitch_deg": 6.0,
    "platform.yaw_deg": 5.0,
    "platform.yaw_phase_deg": 60.0,
    "platform.heave_m": 0.6,
    "platform.speed_m_s": 5.0,
    "platform.heading_deg": 120.0,
    "platform.lever_arm_m": [0.5, -1.0, 4.5],
}
SECTORS = ([0.0, 360.0], [0.0, 354.0], [-30.0, 330.0], [200.0, 260.0])


class Plane:
    """A sea that is a plane and rises nowhere."""

    def elevation_and_velocity(
        self, x: NDArray[np.float64], y: NDArray[np.float64], t: NDArray[np.float64]
    ) -> tuple[NDArray[np.float64], NDArray[np.float32]]:
        return LEVEL + EAST * x + NORTH * y, np.zeros((*x.shape, 3), np.float32)


def plane(points: NDArray[np.float64]) -> NDArray[np.float64]:
    return LEVEL + EAST * points[..., 0] + NORTH * points[..., 1]


def scene(sector: list[float], **more: Any) -> Scene:
    keys = {"radar.range_m": [15.0, 40.0], "sea.extent_m": 150.0, "radar.sector_deg": sector, "tracing.facet_m": 1.0}
    return load_scene("tiny", overrides=keys | MOVING | {key.replace("__", "."): v for key, v in more.items()})


def grid_of(made: Scene, turn: int = 0) -> PolarGrid:
    return polar_grid(Installation(made.radar, made.platform), made.tracing, turn)


def mesh_of(made: Scene, turn: int = 0, water: Any = None) -> SurfaceMesh:
    grid = grid_of(made, turn)
    return surface_mesh(grid, *sea_on_grid(water or Plane(), grid))


# ------------------------------------------------------------------------------------------------ where the lines are


@pytest.mark.parametrize("turn", [0, 3])
def test_each_line_is_where_the_antenna_is_when_the_boresight_passes_it(turn: int) -> None:
    made = scene([0.0, 360.0])
    mast, grid = Installation(made.radar, made.platform), grid_of(made, turn)
    pose = mast.pose(grid.time)
    assert_allclose(wrap_degrees(pose.bearing - grid.azimuth), 0.0, rtol=0.0, atol=1e-9)
    assert_array_equal(grid.pose.origin, pose.origin)
    fired = pulses(mast, turn)
    inside = (grid.sweep >= fired.sweep[0]) & (grid.sweep <= fired.sweep[-1])
    # Between two pulses, 0.1 ms, the boat's swing bends the sweep by at most ½ · 15°/s² · (0.1 ms)²: 1e-10 s.
    assert_allclose(grid.time[inside], np.interp(grid.sweep[inside], fired.sweep, fired.time), rtol=0.0, atol=1e-9)
    # Columns are seen half-way between their lines.
    middle = mast.pose(0.5 * (grid.time[1:] + grid.time[:-1]))
    assert_array_equal(grid.column_pose.positions, middle.positions)


def test_the_sea_is_asked_for_where_the_boat_has_come_to() -> None:
    """A plane sea, so that the place tells the height: vertices are relative to the antenna at each line's time."""
    made = scene([0.0, 360.0])
    mesh = mesh_of(made, 4)
    grid = mesh.grid
    east, north = unit_from_azimuth(grid.azimuth)
    place = np.stack((east[:, None] * grid.ground_range, north[:, None] * grid.ground_range), axis=-1)
    world = grid.pose.origin[:, None, :2] + place
    assert np.abs(grid.pose.origin[:, :2]).max() > 15.0  # the boat has come away from the world's origin
    # Rounding: 1e-15 of 60 m, and of azimuths of 400°.
    assert_allclose(mesh.elevation, plane(world), rtol=0.0, atol=1e-13)
    for sheet in mesh.sheets():
        vertices = mesh.trimesh(sheet).vertices
        lines = np.concatenate([np.arange(s.start, s.stop + 1) for s in sheet])
        in_world = vertices.reshape(lines.size, -1, 3) + grid.pose.origin[lines, None]
        assert_allclose(in_world[..., 2], plane(in_world), rtol=0.0, atol=1e-13)


def test_the_written_mesh_stands_in_the_world() -> None:
    mesh = mesh_of(scene([200.0, 260.0]), 2)
    vertices = np.asarray(mesh.world_trimesh.vertices)
    assert_allclose(vertices[:, 2], plane(vertices), rtol=0.0, atol=1e-13)


def test_facets_rise_from_the_antenna_at_their_columns_time() -> None:
    mesh = mesh_of(scene([0.0, 360.0]), 4)
    facets, grid = mesh.facets, mesh.grid
    origin = grid.column_pose.origin
    assert_array_equal(facets.rise, facets.height - origin[:, 2:])
    azimuth = grid.column_azimuth[:, None] + np.degrees(facets.angle)
    east, north = unit_from_azimuth(azimuth)
    point = np.stack((east * facets.distance, north * facets.distance), axis=-1) + origin[:, None, :2]
    # Facets take their corners from lines whose origins lie apart by what the array moves in 1.2 ms: 12 mm at 10 m/s
    # or less; facets are a sixth to a quarter of the column's width off its middle (their diagonals cross it askew).
    apart = np.hypot(*np.diff(grid.pose.origin[:, :2], axis=0).T).max()
    assert 1e-3 < apart < 12e-3
    assert_allclose(facets.height, plane(point), rtol=0.0, atol=0.25 * apart * np.hypot(EAST, NORTH))
    assert np.ptp(grid.column_height) > 0.3  # the boat heaves


def test_places_and_drift_of_the_antennas_are_along_across_up() -> None:
    """At a steady 5 m/s towards 120°: each column sees the boat come along and across its own look."""
    keys = {"platform.speed_m_s": 5.0, "platform.heading_deg": 120.0, "radar.antennas": [
        {"offset_m": [0.3, 0.1, 0.0]}, {"offset_m": [0.0, 0.0, 0.5]}]}  # fmt: skip
    made = load_scene("tiny", keys | {"radar.tilt_deg": 10.0})
    grid = grid_of(made)
    lean, ahead = np.radians(10.0), np.radians(120.0 - grid.column_azimuth)
    expected = [(0.1 * np.cos(lean), 0.3, -0.1 * np.sin(lean)), (0.5 * np.sin(lean), 0.0, 0.5 * np.cos(lean))]
    # A column's azimuth and its time's bearing agree to 1e-9 deg.
    assert_allclose(
        grid.antenna_positions, np.broadcast_to(expected, grid.antenna_positions.shape), rtol=0.0, atol=1e-10
    )
    up = np.broadcast_to((np.sin(lean), 0.0, np.cos(lean)), grid.array_up.shape)
    assert_allclose(grid.array_up, up, rtol=0.0, atol=1e-10)
    run = 5.0 * np.stack((np.cos(ahead), np.sin(ahead), np.zeros_like(ahead)), axis=-1)
    turning = 2.0 * np.pi  # rad/s, clockwise: what lies ahead goes across, what lies across goes back
    for antenna, (along, across, _) in enumerate(expected):
        # A central difference over 1 ms errs by (ω dt)²/24 = 1.6e-6 of 2 m/s.
        spun = np.array([-turning * across, turning * along, 0.0])
        assert_allclose(grid.drift[:, antenna], run + spun, rtol=0.0, atol=4e-6)


@pytest.mark.parametrize("sector", SECTORS)
def test_the_mesh_reaches_whatever_a_pulse_can_hear(sector: list[float]) -> None:
    """Three beams to either side, and the lean of the heeled fan, beyond every pulse of the swinging boresight."""
    made = scene(sector)
    mast = Installation(made.radar, made.platform)
    for turn in (0, 5):
        grid, fired = grid_of(made, turn), pulses(mast, turn)
        lean = mast.lean_deg(fired.time, float(np.arcsin(5.0 / 15.0)))
        assert lean > 0.5
        beyond = grid.reach_deg - 3.0 * 1.8
        assert beyond == pytest.approx(round(beyond), abs=1e-9)  # in whole degrees, so that turns ask for alike
        assert lean - 0.05 <= beyond < lean + 1.05  # found at fewer times
        assert grid.sweep[0] <= fired.sweep.min() - 3.0 * 1.8 - lean + 0.05
        assert grid.sweep[-1] >= fired.sweep.max() + 3.0 * 1.8 + lean - 0.05
        assert np.all(np.diff(grid.time) > 0.0)


def test_a_staring_mesh_is_the_sea_as_it_is_half_way() -> None:
    made = scene([200.0, 260.0], radar__scan="staring", radar__stare_s=0.05)
    mast, grid = Installation(made.radar, made.platform), grid_of(made, 3)
    assert_allclose(grid.time, 3.5 * 0.05, rtol=1e-15)
    assert_allclose(grid.pose.origin, np.broadcast_to(mast.pose(np.array([0.175])).origin, (grid.columns + 1, 3)))
    heard = pulses(mast, 3).sweep
    assert grid.sweep[0] <= heard.min() - 5.4
    assert grid.sweep[-1] >= heard.max() + 5.4


# ------------------------------------------------------------------------------------------------ sheets and the seam


@pytest.mark.parametrize("sector", SECTORS)
def test_sheets_do_not_overlap(sector: list[float]) -> None:
    mesh = mesh_of(scene(sector), 2)
    grid = mesh.grid
    held = np.concatenate([np.arange(s.start, s.stop) for sheet in mesh.sheets() for s in sheet])
    assert_array_equal(np.sort(held), np.arange(grid.columns))
    for sheet in mesh.sheets():
        bearing = np.sort(np.concatenate([grid.column_azimuth[s] for s in sheet]) % 360.0)
        gaps = np.diff(np.append(bearing, bearing[0] + 360.0))
        assert gaps.min() > grid.spacing_deg * (1.0 - 1e-9)
    inside = (grid.column_sweep > 0.0) & (grid.column_sweep < sector_width(load_scene("tiny", {
        "radar.sector_deg": sector}).radar))  # fmt: skip
    assert np.isin(np.flatnonzero(inside), np.concatenate([np.arange(s.start, s.stop) for s in mesh.sheets()[0]])).all()


def test_sheets_of_a_boat_that_turns_far_do_not_overlap(tmp_path: Path) -> None:
    """Turned by 140°, and a beam of 20°: the mesh runs on for more than half a circle to either side."""
    file = tmp_path / "motion.csv"
    file.write_text("time_s,heading_deg\n-1,-140\n0,0\n1,140\n2,140\n", encoding="utf-8")
    keys = {"platform.motion": "file", "platform.file": str(file), "radar.sector_deg": [0.0, 360.0],
            "radar.antenna.pattern": "gaussian", "radar.antenna.azimuth_beamwidth_deg": 20.0}  # fmt: skip
    made = load_scene("tiny", keys)
    mesh = mesh_of(made)
    assert mesh.grid.columns > 2 * mesh.grid.per_circle
    sheets = mesh.sheets()
    held = np.concatenate([np.arange(s.start, s.stop) for sheet in sheets for s in sheet])
    assert_array_equal(np.sort(held), np.arange(mesh.grid.columns))
    for sheet in sheets:
        assert sum(s.stop - s.start for s in sheet) <= mesh.grid.per_circle


@pytest.mark.parametrize("sector", SECTORS)
def test_column_numbers_go_on_into_the_next_turn(sector: list[float]) -> None:
    """Though a turn begins earlier or later as the boat swings: a number is one place at one time."""
    made = scene(sector)
    grids = [grid_of(made, turn) for turn in range(4)]
    if sector_width(made.radar) == 360.0:
        assert len({grid.first for grid in grids}) > 1  # turns differ in how far they reach
    for one, other in pairwise(grids):
        assert_array_equal(np.diff(one.column_number), 1)
        shared, here, there = np.intersect1d(one.column_number, other.column_number, return_indices=True)
        if sector_width(made.radar) == 360.0:
            assert shared.size > 30
        assert_array_equal(one.column_pose.origin[here], other.column_pose.origin[there])
        around = (one.column_azimuth[here] - other.column_azimuth[there]) / 360.0
        assert_allclose(around, np.rint(around), rtol=0.0, atol=1e-9)
    assert grids[0].column_number[0] >= 0


@pytest.mark.parametrize("motion", ["sinusoidal", "wave_following"])
def test_end_of_a_turn_is_the_start_of_the_next_bit_by_bit(motion: str) -> None:
    """Place, time and water: the same numbers to the last bit, so that light and speckle join without a seam."""
    changes: dict[str, Any] = {"platform__motion": motion}
    if motion == "wave_following":
        changes |= {f"platform__{key}": 0.0 for key in ("roll_deg", "pitch_deg", "yaw_deg", "heave_m")}
    made = scene([0.0, 360.0], **changes)
    water = run_sea(made)
    mast = installation_of(made, water)
    first, second = (polar_grid(mast, made.tracing, turn) for turn in (2, 3))
    numbers = [np.append(grid.column_number, grid.column_number[-1] + 1) for grid in (first, second)]
    shared, here, there = np.intersect1d(numbers[0], numbers[1], return_indices=True)
    assert shared.size > 30
    assert_array_equal(first.time[here], second.time[there])
    assert_array_equal(first.circle_azimuth[here], second.circle_azimuth[there])
    for name in ("origin", "attitude", "axes", "offsets"):
        assert_array_equal(getattr(first.pose, name)[here], getattr(second.pose, name)[there])
    elevation, later = (sea_on_grid(water, grid)[0] for grid in (first, second))
    # The sea sums its waves in another order for other points: 1e-9 of a metre, as for a boat at rest.
    assert_allclose(elevation[here], later[there], rtol=0.0, atol=1e-9)
    flat, next_flat = (sea_on_grid(Plane(), grid)[0] for grid in (first, second))
    assert_array_equal(flat[here], next_flat[there])


# -------------------------------------------------------------------------------------------------- water and refusals


def test_lines_are_submerged_where_the_boat_runs_into_a_rising_sea() -> None:
    """Eastward at 5 m/s into a slope of 1/2 from 2 m below: the lower antenna, 4.9 m up, drowns after 13.8 m."""

    class Slope:
        def elevation_and_velocity(self, x: NDArray, y: NDArray, t: NDArray) -> tuple[NDArray, NDArray[np.float32]]:
            return 0.5 * x - 2.0, np.zeros((*x.shape, 3), np.float32)

    steady = {"platform.motion": "fixed", "platform.speed_m_s": 5.0, "platform.heading_deg": 90.0}
    made = load_scene("tiny", steady | {"radar.sector_deg": [0.0, 360.0], "radar.range_m": [15.0, 40.0]})
    for turn, share in ((0, 0.0), (2, 0.24), (3, 1.0)):
        mesh = mesh_of(made, turn, Slope())
        drowned = submerged_lines(mesh, Slope())
        assert_array_equal(drowned, 0.5 * 5.0 * mesh.grid.time - 2.0 >= 4.9)
        assert drowned.mean() == pytest.approx(share, abs=0.03)  # and the lines before and after the turn


def test_a_boat_that_swings_the_beam_back_is_refused() -> None:
    made = scene([0.0, 360.0], radar__rotation_rpm=1.0, platform__yaw_deg=8.0)
    with pytest.raises(InputError, match=r"raise radar\.rotation_rpm"):
        grid_of(made)


def test_a_mast_at_rest_leaves_the_mesh_as_it_is() -> None:
    made = load_scene("tiny", {"radar.range_m": [15.0, 40.0], "sea.extent_m": 150.0})
    water = sea.realize(made.sea, 7)
    alone = polar_grid(Installation(made.radar), made.tracing, 1)
    carried = polar_grid(Installation(made.radar, made.platform), made.tracing, 1)
    for name in ("time", "azimuth", "sweep", "drift", "antenna_positions", "circle_azimuth"):
        assert_array_equal(getattr(alone, name), getattr(carried, name))
    assert_array_equal(sea_on_grid(water, alone)[0], sea_on_grid(water, carried)[0])
