"""A boat that rolls, pitches, heaves and moves, and the four modes: heights and places as from a boat at rest."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
import xarray as xr
from hypothesis import given, settings
from hypothesis import strategies as st
from rolling_echoes import MODES, Boat, ideal_sea, reflectors

from seamap_rt.dataset import QUALITY_FLAGS
from seamap_rt.errors import SchemaError
from seamap_rt.interferometry import retrieve, retrieve_one
from seamap_rt.interferometry.description import RadarDescription
from seamap_rt.interferometry.dwells import Dwells
from seamap_rt.interferometry.inversion import (
    Fan,
    azimuth_at_sea,
    difference_at_height,
    height_per_phase,
    locate,
)
from seamap_rt.interferometry.poses import LookPoses, PulsePoses
from seamap_rt.interferometry.retrieval import retrieve_turn
from seamap_rt.radar.pose import antenna_axes, bearing
from seamap_rt.settings import RetrievalSettings

COARSE = 40.0  # m, ground cells: the ground map is not looked at here
SINGLE = RetrievalSettings(estimator="single_cell", ground_m=COARSE)
ONE_GATE = RetrievalSettings(estimator="single_cell", cell_range_m=1.5, ground_m=COARSE)
SLIDING = RetrievalSettings(ground_m=COARSE)


def steady(roll: float, pitch: float = 0.0, yaw: float = 0.0):
    return lambda time: np.tile((roll, pitch, yaw), (time.size, 1)).astype(np.float64)


def polar(echoes: xr.Dataset, asked: RetrievalSettings = SINGLE) -> xr.Dataset:
    return retrieve(echoes, asked)["polar"].to_dataset().isel(turn=0)


def radar_of(tilt: float = 0.0) -> RadarDescription:
    boat = Boat(tilt=tilt)
    return RadarDescription.of(boat.echoes(ideal_sea))


RADAR = radar_of()


def pose_of(attitude, scan: float, tilt: float, antennas: np.ndarray, senders: tuple[int, ...]) -> LookPoses:
    """That of a single pulse with antennas (antenna, 3) in the world."""
    axes = antenna_axes(attitude, scan, tilt)
    echoes = xr.Dataset(
        {
            "azimuth": ("pulse", [float(bearing(axes))]),
            "attitude": (("pulse", "rpy"), [attitude]),
            "position": (("pulse", "antenna", "xyz"), antennas[None]),
            "time": ("pulse", [0.0]),
        }
    )
    radar = RadarDescription(**{**RADAR.__dict__, "tilt": tilt})
    pulses = PulsePoses.of(echoes, radar)
    dwells = Dwells(np.zeros(1, dtype=np.intp), 1)
    return LookPoses.of(pulses, dwells, (0, 1), senders, radar.sector[0])


@settings(max_examples=300)
@given(
    attitude=st.tuples(st.floats(-15.0, 15.0), st.floats(-10.0, 10.0), st.floats(-180.0, 180.0)),
    scan=st.floats(0.0, 360.0),
    tilt=st.floats(-20.0, 20.0),
    baseline=st.floats(0.05, 1.8),
    height=st.floats(2.0, 50.0),
    reach=st.floats(0.0, 1.0),
    elevation=st.floats(-60.0, 30.0),
    senders=st.sampled_from([(0,), (1,), (0, 1), (2,), (0, 1, 2)]),
)
def test_the_place_of_an_exact_phase(attitude, scan, tilt, baseline, height, reach, elevation, senders) -> None:
    # Asked: 1 mm in height, a few in place. An ulp of R at 3 km is 5e-13 m, and R/B = 6e4 times it 3e-8 m; along the
    # array's own line the triangle is flat, but 60° off the boresight that is a factor of two alone.
    near = max(15.0, 1.2 * height)
    distance = near * (3000.0 / near) ** reach
    axes = antenna_axes(attitude, scan, tilt)
    # The third stands beside the fan's plane.
    offsets = np.array(((0.0, 0.0, -0.5), (0.0, 0.1, 0.5), (0.3, -0.2, 0.7))) * (baseline / np.hypot(0.1, 1.0))
    antennas = np.array((3.0, -8.0, height)) + offsets @ axes
    eta = np.radians(elevation)
    point = antennas[0] + distance * (np.cos(eta) * axes[1] + np.sin(eta) * axes[2])
    away = point - antennas
    length = np.linalg.norm(away, axis=1)
    base = antennas - antennas[0]
    difference = (np.sum(base**2, axis=1) - 2.0 * base @ away[0]) / (length + length[0])
    gate = length[0] + 0.25 * difference[1] + 0.5 * np.mean(difference[list(senders)])
    poses = pose_of(attitude, scan, tilt, antennas, senders)
    found = locate(gate, difference[1], poses.fan)
    assert np.abs(found.height - point[2]).max() < 1e-6
    for got, asked in zip(poses.world(found), point[:2], strict=True):
        assert np.abs(got - asked).max() < 1e-5
    back = difference_at_height(gate, point[2], poses.fan)
    turned = np.abs(back - difference[1]).max()
    steep = np.abs(np.cos(eta) * axes[2, 2] - np.sin(eta) * axes[1, 2])  # of the height against the angle
    if np.cos(eta) * axes[1, 2] + np.sin(eta) * axes[2, 2] < 0.0 and steep > 0.2:
        # Below the horizon, where the fan has one place a height in front.
        assert turned < 1e-11


@pytest.mark.parametrize("aside", [-0.2, 0.05])
@pytest.mark.parametrize("distance", [15.0, 100.0, 1000.0])
@pytest.mark.parametrize("order", [(0, 1), (1, 0)])
def test_receivers_on_either_side_of_the_fans_plane(aside: float, distance: float, order: tuple[int, int]) -> None:
    """The plane stands in their middle, whichever comes first. A plane through one would be 2 a²/b_z = 0.4 m off."""
    axes = antenna_axes((8.0, -3.0, 40.0), 70.0, 4.0)
    middle = np.array((3.0, -8.0, 5.0))
    antennas = middle + np.array(((-aside, 0.0, -0.1), (aside, 0.0, 0.1)))[list(order)] @ axes
    eta = -np.arcsin(4.0 / distance)
    point = middle + distance * (np.cos(eta) * axes[1] + np.sin(eta) * axes[2])
    length = np.linalg.norm(point - antennas, axis=1)
    poses = pose_of((8.0, -3.0, 40.0), 70.0, 4.0, antennas, (0, 1))
    found = locate(length.mean(), length[1] - length[0], poses.fan)
    # What a range of R loses in a plane a beside it: a²/2R; and a part of the baseline's own length.
    assert np.abs(found.height - point[2]).max() < aside**2 / distance + 1e-7 * distance**2


@pytest.mark.parametrize("roll", [-12.0, 0.0, 7.0])
def test_height_per_phase_is_the_derivative_for_a_leaning_fan(roll: float) -> None:
    axes = antenna_axes((roll, 4.0, 0.0), 60.0, 5.0)
    antennas = np.array((0.0, 0.0, 5.0)) + 0.2 * np.array(((0.0, 0.0, -0.5), (0.0, 0.0, 0.5))) @ axes
    fan, gate, step = pose_of((roll, 4.0, 0.0), 60.0, 5.0, antennas, (0, 1)).fan, np.array([30.0, 100.0, 400.0]), 1e-6
    middle = difference_at_height(gate, 0.0, fan)
    up, down = (locate(gate, middle + s, fan).height for s in (step, -step))
    for paths in (1, 2):
        slope = np.abs(up - down) / (2.0 * step) * 0.03 / (2.0 * np.pi * paths)
        np.testing.assert_allclose(height_per_phase(gate, middle, fan, 0.03, paths), slope, rtol=2.0 * 0.2 / 30.0)


# ---------------------------------------------------------------------------------------------- whole retrievals


@pytest.mark.parametrize("mode", list(MODES))
@pytest.mark.parametrize(("roll", "pitch", "tilt"), [(0.0, 0.0, 0.0), (10.0, 0.0, 0.0), (-15.0, 8.0, -6.0)])
def test_the_sea_is_flat_from_a_heeling_boat(mode: tuple[str, str], roll: float, pitch: float, tilt: float) -> None:
    boat = Boat(mode=mode, attitude=steady(roll, pitch), tilt=tilt, sector=(50.0, 68.0), prf=10e3)
    echoes = boat.echoes(ideal_sea)
    height = polar(echoes, ONE_GATE)["height"].values
    # Asked: 1 cm. A single gate has only the rounding of complex64, 6e-8 rad through 3 m/rad, and, from a heeled boat,
    # what bends while the array turns through a look of ±0.9°: up to R sin(15°) (0.016)²/6.
    assert np.isfinite(height[3:-3]).all()
    assert np.nanmax(np.abs(height)) < (2e-6 if roll == 0.0 else 1e-3)
    # Windows are turned along straight lines; what the phase k B H/R bends within a window of variance s² is H s²/R².
    maps = polar(echoes, SLIDING)
    height, ranges = maps["height"].values, maps["range"].values
    limit = 2.5 * 5.0 / ranges**2 + 5e-4
    assert (np.abs(height) < limit)[np.isfinite(height)].all()
    assert abs(np.nanmean(height[:, ranges > 30.0])) < 3e-3
    slopes = np.stack((maps["slope_range"].values, maps["slope_azimuth"].values))[:, :, 10:]
    assert np.nanmax(np.abs(slopes)) < 1e-3


@pytest.mark.parametrize("mode", list(MODES))
def test_a_dwell_from_a_heeling_boat_keeps_its_coherence(mode: tuple[str, str]) -> None:
    """At 15° of roll the level's phase runs by k B sin(roll) · 1.8° = 0.34 rad (p = 1) through a look ahead: added as
    they come, its pulses would cohere to sin(0.17)/0.17 = 0.995. Freed of each pulse's own level they cohere fully."""
    boat = Boat(mode=mode, attitude=steady(15.0), sector=(-9.0, 9.0), prf=10e3)
    coherence = polar(boat.echoes(ideal_sea), ONE_GATE)["coherence"].values
    # complex64 and float32; the two senders' half paths differ from their mean by 0.1 mm, which the level does not know
    assert np.nanmin(coherence[2:-2]) > 1.0 - 2e-5


def test_a_fan_taken_for_upright_would_be_wrong() -> None:
    # H sin²(roll) = 0.15 m at 10°: the law above can fail.
    boat = Boat(attitude=steady(10.0), sector=(-9.0, 9.0))
    axes, antennas = boat.pose()
    points = boat.where_the_fan_meets_the_sea()
    away = np.linalg.norm(points[90, :, None] - antennas[90], axis=-1)
    difference = away[:, 1] - away[:, 0]
    fan = Fan.upright(0.2 * axes[90, 2, 2], antennas[90, 0, 2])
    wrong = locate(boat.ranges, difference, fan).height
    assert np.abs(wrong).min() > 0.1


def test_heave_and_roll_leave_the_height_alone() -> None:
    # A metre in 0.4 s and 10° in 1 s, in and out of any look: 12 m/s and 60°/s. What bends within a look of 5 ms is
    # 250 m/s² · (5 ms)²/24 = 0.3 mm of heave.
    def place_of(time):
        return np.stack((4.0 * time, 1.0 * time, np.sin(2.0 * np.pi * time / 0.4)), axis=1)

    def attitude_of(time):
        return np.stack(
            (10.0 * np.sin(2.0 * np.pi * time), 3.0 * np.cos(9.0 * time), 5.0 * np.sin(12.0 * time)), axis=1
        )

    boat = Boat(attitude=attitude_of, place=place_of, sector=(0.0, 360.0), height=8.0, prf=5000.0)
    echoes = boat.echoes(ideal_sea)
    for asked, limit in ((ONE_GATE, 5e-3), (SLIDING, 2e-2)):
        maps = polar(echoes, asked)
        height = maps["height"].values[:, maps["range"].values > 35.0]  # nearer, windows of any boat's bend
        assert np.isfinite(height).mean() > 0.9
        assert np.nanmax(np.abs(height)) < limit


@pytest.mark.parametrize("scan", [0.0, 90.0, 180.0, 270.0])
def test_a_roll_that_is_measured_wrong(scan: float) -> None:
    # R δα sin(scan): 0.17 m at 100 m abeam for 0.1°. Asked: 5 %.
    boat = Boat(sector=(scan - 9.0, scan + 9.0), bias=(0.1, 0.0, 0.0))
    maps = polar(boat.echoes(ideal_sea))
    gate = int(np.argmin(np.abs(maps["range"].values - 100.0)))
    far = maps["range"].values[gate]
    asked = -far * np.radians(0.1) * np.sin(np.radians(maps["azimuth"].values))
    np.testing.assert_allclose(maps["height"].values[:, gate], asked, rtol=0, atol=0.05 * far * np.radians(0.1))


@pytest.mark.parametrize("mode", list(MODES))
@pytest.mark.parametrize("which", ["forward", "backward", "both"])
def test_a_sea_that_recedes(mode: tuple[str, str], which: str) -> None:
    # 2 v τ R/(p B), downwards where the upper antenna's pulse comes after the lower one's. Asked: 5 % of it, and no
    # more than 2 % with both; where both receivers hear one pulse there is none.
    boat = Boat(mode=mode, prf=10e3, sector=(0.0, 9.0))
    asked = RetrievalSettings.model_validate({**ONE_GATE.model_dump(), "pulse_pairs": which, "paths": "one_way"})
    maps = polar(boat.echoes(lambda b: ideal_sea(b, speed=1.0)), asked)
    paths = 2 if mode == ("switched", "alternating_pulse") else 1
    ranges = maps["range"].values
    bias = 2.0 * 1.0 * 1e-4 * ranges / (paths * 0.2)
    size = {"forward": -1.0, "backward": 1.0, "both": 0.0}[which] if mode[1] == "alternating_pulse" else 0.0
    found = (maps["height"].values / bias)[:, ranges > 40.0]
    np.testing.assert_allclose(found, size, rtol=0, atol=0.05 if size else 0.02)


@pytest.mark.parametrize("which", ["forward", "backward", "both"])
def test_both_ways_of_switched_pulses_see_half_of_that(which: str) -> None:
    # Transmitters that take turns give both ways between neighbouring pulses: p = 2, though all receivers hear all.
    boat = Boat(mode=("switched", "single_pulse"), prf=10e3, sector=(0.0, 9.0))
    asked = RetrievalSettings.model_validate({**ONE_GATE.model_dump(), "pulse_pairs": which})
    maps = polar(boat.echoes(lambda b: ideal_sea(b, speed=1.0)), asked)
    assert maps.attrs["paths"] == 2
    ranges = maps["range"].values
    found = (maps["height"].values / (1e-4 * ranges / 0.2))[:, ranges > 40.0]
    size = {"forward": -1.0, "backward": 1.0, "both": 0.0}[which]
    np.testing.assert_allclose(found, size, rtol=0, atol=0.05 if size else 0.02)


@pytest.mark.parametrize("roll", [0.0, 12.0])
def test_reflectors_are_laid_where_they_are(roll: float) -> None:
    # Each in the middle of a look and of a gate of its own, from a boat that moves at 5 m/s and rolls. The dwell's
    # 50 pulses put the look's middle up to half a pulse (0.018°, 6 mm at 20 m, 3 cm at 100 m) beside the reflector; in
    # the time of one, 0.1 ms, the boat rolls by 8 mm at 115 m.
    def attitude_of(time):
        return np.stack((roll + 40.0 * (time - 0.05), 2.0 + 0.0 * time, 0.0 * time), axis=1)

    def place_of(time):
        return np.stack((5.0 * time, 0.0 * time, 0.0 * time), axis=1)

    boat = Boat(attitude=attitude_of, place=place_of, prf=10e3)
    gates = np.arange(4, 68, 9)
    cells = np.array([(2 + 2 * n, gate) for n, gate in enumerate(gates)])
    meets = boat.where_the_fan_meets_the_sea()
    _, antennas = boat.pose()
    toward = meets - antennas.mean(axis=1)[:, None]
    azimuth = np.degrees(np.arctan2(toward[..., 0], toward[..., 1]))
    rows = [int(np.argmin(np.abs(azimuth[:, gate] - 1.8 * (look + 0.5)))) for look, gate in cells]
    points = meets[rows, cells[:, 1]]
    echoes = boat.echoes(lambda b: reflectors(b, points))
    asked = RetrievalSettings(
        estimator="single_cell",
        paths="one_way",
        cell_range_m=1.5,
        ground_m=COARSE,
        window_range_m=1.5,
        window_azimuth_deg=1.8,
    )
    maps, ground = retrieve_turn(echoes, RadarDescription.of(echoes), asked, 0)
    looks, numbers = cells.T
    assert ground.x is not None
    assert ground.y is not None
    np.testing.assert_allclose(maps["height"].values[0, looks, numbers], 0.0, atol=1.5e-2)
    np.testing.assert_allclose(ground.x[looks, numbers], points[:, 0], atol=0.05)
    np.testing.assert_allclose(ground.y[looks, numbers], points[:, 1], atol=0.05)


def test_a_third_antenna_may_send_and_receivers_may_be_swapped() -> None:
    boat = Boat(
        mode=("single", "single_pulse"),
        offsets=((0.0, 0.0, -0.1), (0.0, 0.0, 0.1), (0.6, 0.1, 0.9)),
        cycle=((2, (0, 1)),),
        attitude=steady(6.0),
    )
    echoes = boat.echoes(ideal_sea)
    found = {}
    for pair in ((0, 1), (1, 0)):
        asked = ONE_GATE.model_copy(update={"receivers": pair})
        found[pair] = retrieve_one(echoes, asked)["polar"].to_dataset()["height"].values[0]
        assert np.isfinite(found[pair]).mean() > 0.85
        assert np.nanmax(np.abs(found[pair])) < 1e-4
    # Were the lower antenna taken for the sender, near gates would lie a quarter of a metre and more off.
    wrong = retrieve_one(echoes.assign_coords(transmitter=0 * echoes["transmitter"]), ONE_GATE)["polar"]["ground_range"]
    right = retrieve_one(echoes, ONE_GATE)["polar"]["ground_range"]
    assert float(np.abs(wrong - right).max()) > 0.05
    for receivers in ((0, 0), (0, 5)):
        with pytest.raises(SchemaError, match="receivers"):
            retrieve_one(echoes, ONE_GATE.model_copy(update={"receivers": receivers}))


# ------------------------------------------------------------------------------------------------------- flags


def test_saturated_and_blind_gates_are_flagged() -> None:
    boat = Boat()
    echoes = boat.echoes(ideal_sea)
    clipped = np.zeros((boat.time.size, boat.ranges.size), dtype=np.int8)
    clipped[33, 7] = 1  # one of the ten pulses of the fourth look
    echoes = echoes.assign(saturated=(("pulse", "range"), clipped))
    quality = polar(echoes)["quality"].values
    flagged = np.argwhere(quality & QUALITY_FLAGS["saturated"])
    np.testing.assert_array_equal(flagged, [[3, 7]])
    assert not (quality & QUALITY_FLAGS["blind"]).any()
    echoes.attrs |= {"pulse_width_s": 2e-7, "waveform": "chirp", "chirp_bandwidth_hz": 50e6}
    blind = polar(echoes)["quality"].values & QUALITY_FLAGS["blind"]
    np.testing.assert_array_equal(blind > 0, np.broadcast_to(boat.ranges < 29.98, blind.shape))
    # Pulses 119.9 m apart: a chirp from beyond 89.9 m is cut off by the next.
    echoes.attrs["prf_hz"] = 1.25e6
    blind = polar(echoes)["quality"].values & QUALITY_FLAGS["blind"]
    cut = (boat.ranges < 29.98) | (boat.ranges > 89.94)
    np.testing.assert_array_equal(blind > 0, np.broadcast_to(cut, blind.shape))


def test_while_a_plain_pulse_goes_out_nothing_is_heard() -> None:
    boat = Boat()
    echoes = boat.echoes(ideal_sea)
    echoes.attrs["pulse_width_s"] = 2e-7
    maps = polar(echoes, ONE_GATE)
    deaf = boat.ranges < 29.98
    assert np.isnan(maps["height"].values[:, deaf]).all()
    assert np.isfinite(maps["height"].values[3:-3, ~deaf]).all()
    flags = maps["quality"].values[:, deaf]
    assert (flags & QUALITY_FLAGS["no_echo"] > 0).all()
    assert (flags & QUALITY_FLAGS["blind"] > 0).all()


def test_alternating_echoes_must_be_what_they_say() -> None:
    boat = Boat(mode=("switched", "alternating_pulse"))
    echoes = boat.echoes(ideal_sea)
    with pytest.raises(SchemaError, match="transmit"):
        polar(echoes.assign_coords(transmitter=0 * echoes["transmitter"]))
    echoes["voltage"][...] = 1.0
    with pytest.raises(SchemaError, match="same pulse"):
        polar(echoes)


# ------------------------------------------------------------------------------- gates that end above the sea


@settings(max_examples=200)
@given(
    attitude=st.tuples(st.floats(-15.0, 15.0), st.floats(-10.0, 10.0), st.floats(-180.0, 180.0)),
    scan=st.floats(0.0, 360.0),
    tilt=st.floats(-10.0, 10.0),
    height=st.floats(2.0, 30.0),
)
def test_a_fan_meets_the_sea_along_one_line_from_its_foot_on(attitude, scan, tilt, height) -> None:
    """Where the fan's plane cuts mean sea level: beside the foot of the steepest line in it by √(R² − foot²), to
    either side of which nothing jumps; nearer than the foot there is no such place, and no azimuth. 1e-6 rad: an ulp of
    the height at the nearest of these ranges, 1e-6 of it beyond the foot, is 2e-10 of the way out."""
    axes = antenna_axes(attitude, scan, tilt)
    toward = np.radians(bearing(axes))
    out, right = np.array((np.sin(toward), np.cos(toward), 0.0)), np.array((np.cos(toward), -np.sin(toward), 0.0))
    level = np.cross(axes[0], (0.0, 0.0, 1.0))
    level *= np.sign(level @ axes[1]) / np.linalg.norm(level)
    down = np.cross(level, axes[0])
    down *= -np.sign(down[2]) / np.linalg.norm(down)
    foot = -height / down[2]
    beyond = foot * (1.0 + np.geomspace(1e-6, 100.0, 200))
    place = foot * down + np.sqrt(beyond**2 - foot**2)[:, None] * level
    parts = [(np.array(axes[1] @ each), np.array(axes[2] @ each)) for each in ((0.0, 0.0, 1.0), out)]
    lean = np.array(axes[2] @ right)
    found = azimuth_at_sea(beyond, np.array(height), parts[0], parts[1], lean)
    np.testing.assert_allclose(np.sin(found - np.arctan2(place @ right, place @ out)), 0.0, atol=1e-6)
    swing = np.diff(np.unwrap(found))
    assert np.all(swing >= -1e-6) or np.all(swing <= 1e-6)  # one way only
    nearer = foot * (1.0 - np.geomspace(1e-9, 0.99, 30))
    assert np.isnan(azimuth_at_sea(nearer, np.array(height), parts[0], parts[1], lean)).all()


@pytest.mark.parametrize(
    ("roll", "pitch", "tilt"), [(0.0, 0.0, 10.0), (0.0, 3.0, 0.0), (0.05, 0.0, 0.0), (6.0, 2.0, 4.0)]
)
def test_gates_that_end_above_the_sea_change_nothing_beyond(roll: float, pitch: float, tilt: float) -> None:
    """A recording may begin at the antenna. Those gates have no height, and no part in whether the fan leans."""
    whole = Boat(
        attitude=steady(roll, pitch), tilt=tilt, sector=(20.0, 38.0), prf=4000.0, ranges=np.arange(1.5, 60.0, 1.5)
    )
    far = replace(whole, ranges=whole.ranges[whole.ranges > 5.5])
    asked = SINGLE.model_copy(update={"cell_range_m": 1.5})
    both = [polar(boat.echoes(ideal_sea), asked) for boat in (whole, far)]
    for name in ("height", "ground_range", "time"):
        values = both[0][name].values
        beyond = values[..., -far.ranges.size :] if values.ndim > 1 else values
        np.testing.assert_allclose(beyond, both[1][name].values, atol=1e-12)
    if roll:
        inside = both[0].isel(range=slice(0, whole.ranges.size - far.ranges.size))
        assert np.isnan(inside["height"].values).all()
        assert (inside["quality"].values & QUALITY_FLAGS["no_echo"]).all()
