"""Attitudes: each sign against the words of `pose`, the order of the angles, and the turntable's angle back again."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import assume, given
from hypothesis import strategies as st
from numpy.testing import assert_allclose

from seamap_rt.conventions import unit_from_azimuth, wrap_degrees
from seamap_rt.radar.pose import antenna_axes, bearing, boat_axes, scan_of_bearing

ROUNDING = 1e-15  # of unit vectors, a few products each

angles = st.floats(-360.0, 360.0)
leans = st.floats(-45.0, 45.0)


def turned(roll: float, pitch: float, yaw: float) -> np.ndarray:
    """The boat's axes by hand: rows starboard, forward, up; the product yaw · pitch · roll multiplied out."""
    (sr, sp, sy), (cr, cp, cy) = np.sin(np.radians((roll, pitch, yaw))), np.cos(np.radians((roll, pitch, yaw)))
    return np.array(
        [
            [cy * cr + sy * sp * sr, -sy * cr + cy * sp * sr, -cp * sr],
            [sy * cp, cy * cp, sp],
            [cy * sr - sy * sp * cr, -sy * sr - cy * sp * cr, cp * cr],
        ]
    )


# ------------------------------------------------------------------------------------------------- signs and order


def test_an_upright_boat_bound_north_has_the_worlds_axes() -> None:
    assert_allclose(boat_axes((0.0, 0.0, 0.0)), np.eye(3), atol=0.0)


def test_roll_is_starboard_down() -> None:
    starboard, forward, up = boat_axes((10.0, 0.0, 0.0))
    sine, cosine = np.sin(np.radians(10.0)), np.cos(np.radians(10.0))
    assert_allclose(starboard, (cosine, 0.0, -sine), atol=ROUNDING)
    assert_allclose(forward, (0.0, 1.0, 0.0), atol=ROUNDING)
    assert_allclose(up, (sine, 0.0, cosine), atol=ROUNDING)  # the masthead goes to starboard


def test_pitch_is_bow_up() -> None:
    starboard, forward, up = boat_axes((0.0, 10.0, 0.0))
    sine, cosine = np.sin(np.radians(10.0)), np.cos(np.radians(10.0))
    assert_allclose(starboard, (1.0, 0.0, 0.0), atol=ROUNDING)
    assert_allclose(forward, (0.0, cosine, sine), atol=ROUNDING)
    assert_allclose(up, (0.0, -sine, cosine), atol=ROUNDING)  # the masthead goes aft


@pytest.mark.parametrize("heading", [0.0, 30.0, 90.0, 200.0, -75.0])
def test_yaw_is_the_heading_clockwise_from_north(heading: float) -> None:
    starboard, forward, up = boat_axes((0.0, 0.0, heading))
    assert_allclose(forward, np.append(unit_from_azimuth(heading), 0.0), atol=ROUNDING)
    assert_allclose(starboard, np.append(unit_from_azimuth(heading + 90.0), 0.0), atol=ROUNDING)
    assert_allclose(up, (0.0, 0.0, 1.0), atol=ROUNDING)


@given(leans, leans, angles)
def test_the_order_is_yaw_pitch_roll(roll: float, pitch: float, yaw: float) -> None:
    assert_allclose(boat_axes((roll, pitch, yaw)), turned(roll, pitch, yaw), atol=2.0 * ROUNDING)


def test_the_order_matters() -> None:
    # Rolled about a keel that is pitched already: the bow stays where pitch and heading put it.
    bow = (np.cos(np.radians(15.0)), 0.0, np.sin(np.radians(15.0)))
    for roll in (0.0, 20.0, -40.0):
        assert_allclose(boat_axes((roll, 15.0, 90.0))[1], bow, atol=ROUNDING)
    assert np.abs(boat_axes((20.0, 15.0, 0.0))[0] - boat_axes((20.0, 0.0, 0.0))[0]).max() > 0.05


@given(leans, leans, angles, angles, st.floats(-60.0, 60.0))
def test_axes_are_orthonormal_and_right_handed(roll: float, pitch: float, yaw: float, scan: float, tilt: float) -> None:
    """Starboard × forward = up, as east × north = up; across × boresight = up the array."""
    for axes in (boat_axes((roll, pitch, yaw)), antenna_axes((roll, pitch, yaw), scan, tilt)):
        assert_allclose(axes @ axes.T, np.eye(3), atol=4.0 * ROUNDING)
        assert_allclose(np.cross(axes[0], axes[1]), axes[2], atol=4.0 * ROUNDING)


# ---------------------------------------------------------------------------------------------------- the turntable


@pytest.mark.parametrize("scan", [0.0, 40.0, 123.0, 300.0])
def test_the_turntable_turns_clockwise_about_the_boats_own_upright_axis(scan: float) -> None:
    across, ahead, up = antenna_axes((0.0, 0.0, 25.0), scan, 0.0)
    assert_allclose(ahead, np.append(unit_from_azimuth(25.0 + scan), 0.0), atol=2.0 * ROUNDING)
    assert_allclose(
        across, np.append(unit_from_azimuth(25.0 + scan + 90.0), 0.0), atol=2.0 * ROUNDING
    )  # right of the look
    attitude = (12.0, -7.0, 25.0)
    boat = boat_axes(attitude)
    across, ahead, up = antenna_axes(attitude, scan, 0.0)
    assert_allclose(up, boat[2], atol=ROUNDING)
    east, north = unit_from_azimuth(scan)
    assert_allclose(ahead, east * boat[0] + north * boat[1], atol=2.0 * ROUNDING)


@pytest.mark.parametrize("tilt", [20.0, -35.0])
@pytest.mark.parametrize("scan", [0.0, 77.0])
def test_tilt_leans_the_top_towards_the_look(tilt: float, scan: float) -> None:
    upright, leaning = (antenna_axes((0.0, 0.0, 0.0), scan, lean) for lean in (0.0, tilt))
    assert_allclose(leaning[0], upright[0], atol=ROUNDING)
    assert leaning[1, 2] == pytest.approx(-np.sin(np.radians(tilt)), abs=ROUNDING)  # the boresight points down by it
    assert leaning[2] @ upright[1] == pytest.approx(np.sin(np.radians(tilt)), abs=ROUNDING)  # the top goes ahead


def test_axes_come_for_many_times_at_once() -> None:
    attitude = np.array([[3.0, -2.0, 10.0], [-8.0, 4.0, 350.0]])
    scan = np.array([15.0, 200.0])
    both = antenna_axes(attitude, scan, 5.0)
    assert both.shape == (2, 3, 3)
    for number in range(2):
        assert_allclose(both[number], antenna_axes(attitude[number], scan[number], 5.0), atol=0.0)


@pytest.mark.parametrize("azimuth", [0.0, 10.0, 90.0, 181.0, 359.5])
def test_bearing_is_the_boresights_azimuth(azimuth: float) -> None:
    for tilt in (0.0, 30.0):
        found = bearing(antenna_axes((0.0, 0.0, 0.0), azimuth, tilt))
        assert wrap_degrees(found - azimuth) == pytest.approx(0.0, abs=1e-12)
        assert 0.0 <= found < 360.0


@given(leans, leans, angles, angles, st.floats(-60.0, 60.0))
def test_scan_of_bearing_is_the_inverse_of_bearing(
    roll: float, pitch: float, yaw: float, azimuth: float, tilt: float
) -> None:
    """Both ways round, wherever the array leans by less than leaves the vertical within the boresight's cone."""
    attitude = (roll, pitch, yaw)
    lean = np.degrees(np.arccos(np.clip(boat_axes(attitude)[2, 2], -1.0, 1.0)))
    assume(lean + abs(tilt) < 89.0)  # beyond it bearings turn back, or are not met at all
    scan = scan_of_bearing(attitude, azimuth, tilt)
    # At 1° from the cone's edge rounding grows by 1/sin²(1°) at most, to 1e-10 deg.
    found = bearing(antenna_axes(attitude, scan, tilt))
    assert abs(wrap_degrees(found - azimuth)) < 1e-9
    back = scan_of_bearing(attitude, bearing(antenna_axes(attitude, azimuth, tilt)), tilt)
    assert abs(wrap_degrees(back - azimuth)) < 1e-9


def test_a_bearing_that_is_never_met_is_nan() -> None:
    # Rolled 45° to starboard and leant 60°: abeam to port the boresight rises no further than its cone's edge.
    assert np.isnan(scan_of_bearing((45.0, 0.0, 0.0), 0.0, 60.0))
    assert np.isfinite(scan_of_bearing((45.0, 0.0, 0.0), 90.0, 60.0))
