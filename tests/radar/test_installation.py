"""Where the antennas of a boat are at any time: at rest, leaning, swinging, on its way, and with the turntable."""

from __future__ import annotations

import ast
import sys
from dataclasses import replace
from pathlib import Path
from typing import Any

import mpmath
import numpy as np
import pytest
from numpy.testing import assert_allclose, assert_array_equal
from numpy.typing import NDArray

import seamap_rt
from seamap_rt.conventions import unit_from_azimuth, wrap_degrees
from seamap_rt.errors import InputError
from seamap_rt.radar.array import Array, antenna_array
from seamap_rt.radar.installation import Installation, column_frame, turn_duration
from seamap_rt.radar.platform import BoatState, boat_motion
from seamap_rt.radar.pose import boat_axes
from seamap_rt.radar.scan import phase_centres
from seamap_rt.scene import load_scene
from seamap_rt.settings import PlatformSettings, RadarSettings
from seamap_rt.simulation import Simulator

TIMES = np.linspace(-0.1, 7.3, 1483)
SWINGING = {
    "motion": "sinusoidal",
    "roll_deg": 15.0,
    "pitch_deg": 7.0,
    "pitch_phase_deg": 50.0,
    "yaw_deg": 8.0,
    "yaw_phase_deg": -120.0,
    "heave_m": 0.6,
    "speed_m_s": 5.0,
    "heading_deg": 35.0,
}
ASIDE = {"antennas": [{"offset_m": [0.3, -0.1, 0.0]}, {"offset_m": [-0.2, 0.05, 0.25]}]}


def mast_of(platform: dict[str, Any] | None = None, **radar: Any) -> Installation:
    return Installation(RadarSettings.model_validate(radar), PlatformSettings.model_validate(platform or {}))


# ---------------------------------------------------------------------------------------------------------- at rest


@pytest.mark.parametrize("tilt", [0.0, 20.0, -33.0])
@pytest.mark.parametrize("heading", [0.0, 77.0, -200.0])
def test_a_boat_at_rest_carries_the_antennas_round_their_foot(tilt: float, heading: float) -> None:
    """Against the geometry by hand; the sector counts from north, whatever the boat's heading."""
    mast = mast_of({"heading_deg": heading}, tilt_deg=tilt, baseline_m=0.8, height_m=6.0, sector_deg=[20.0, 320.0])
    azimuth = 20.0 + 360.0 * TIMES
    pose, lean = mast.pose(TIMES), np.radians(tilt)
    east, north = unit_from_azimuth(azimuth)
    for antenna, side in enumerate((-0.4, 0.4)):
        by_hand = np.stack(
            (side * np.sin(lean) * east, side * np.sin(lean) * north, np.full_like(east, 6.0 + side * np.cos(lean))), -1
        )
        # Rounding of angles of some 2600°: 1e-13 of a turn, times 0.4 m.
        assert_allclose(pose.positions[:, antenna], by_hand, rtol=0.0, atol=1e-12)
    assert_allclose(phase_centres(mast.radar, azimuth), pose.positions, rtol=0.0, atol=1e-12)
    assert_allclose(pose.origin, np.tile((0.0, 0.0, 6.0), (TIMES.size, 1)), rtol=0.0, atol=1e-14)


@pytest.mark.parametrize("platform", [{}, {"heading_deg": 123.4}, {"speed_m_s": 5.0, "heading_deg": -77.7}])
@pytest.mark.parametrize("tilt", [0.0, 20.0])
def test_a_level_boats_boresight_is_on_schedule_bit_by_bit(platform: dict[str, Any], tilt: float) -> None:
    mast = mast_of(platform, tilt_deg=tilt, sector_deg=[-17.3, 201.9], rotation_rpm=44.0)
    assert_array_equal(mast.swing(TIMES), 0.0)
    sweep = np.linspace(-10.0, 230.0, 777)
    nominal = (3.0 + sweep / 360.0) * mast.period
    assert_array_equal(mast.passing(sweep + 3.0 * 360.0, nominal), nominal)


def test_the_schedule_starts_each_turn_at_the_sectors_start() -> None:
    mast = mast_of(sector_deg=[30.0, 90.0], rotation_rpm=24.0)
    assert mast.period == turn_duration(mast.radar) == 2.5
    assert mast.rate == pytest.approx(144.0, rel=1e-15)
    assert_allclose(mast.schedule(np.array([0.0, 2.5, 5.0])), (30.0, 390.0, 750.0), rtol=1e-15)


def test_a_staring_antenna_points_to_the_sectors_middle() -> None:
    mast = mast_of({"list_deg": 10.0}, scan="staring", stare_s=0.04, sector_deg=[30.0, 90.0])
    assert mast.period == 0.04
    assert mast.rate == 0.0
    assert_array_equal(mast.schedule(TIMES), 60.0)
    assert_array_equal(mast.passing(TIMES, TIMES), TIMES)
    assert_allclose(mast_of(scan="staring", sector_deg=[30.0, 90.0]).pose(TIMES).bearing, 60.0, rtol=1e-14)
    # List swings it: with starboard east and down, the boresight (sin 60°, cos 60°, 0) leans to sin 60° cos ρ east.
    sine, cosine = np.sin(np.radians(60.0)), np.cos(np.radians(60.0))
    expected = np.degrees(np.arctan2(sine * np.cos(np.radians(10.0)), cosine)) - 60.0
    assert_allclose(mast.swing(TIMES), expected, rtol=1e-10)


# ----------------------------------------------------------------------------------------------------------- leaning


@pytest.mark.parametrize("roll", [10.0, -30.0])
def test_a_roll_shifts_mast_and_baseline_to_starboard(roll: float) -> None:
    """Hand formulas for roll alone: the origin by height · sin ρ, the antennas by ± B/2 sin ρ about it."""
    pose = mast_of({"list_deg": roll}, baseline_m=0.8, height_m=5.0).pose(TIMES)
    sine, cosine = np.sin(np.radians(roll)), np.cos(np.radians(roll))
    for antenna, length in enumerate((4.6, 5.4)):
        expected = np.tile((length * sine, 0.0, length * cosine), (TIMES.size, 1))
        assert_allclose(pose.positions[:, antenna], expected, rtol=0.0, atol=1e-14)


def test_a_pitch_shifts_the_mast_aft() -> None:
    pose = mast_of({"trim_deg": 10.0, "heading_deg": 90.0}, height_m=5.0).pose(TIMES)
    sine, cosine = np.sin(np.radians(10.0)), np.cos(np.radians(10.0))
    assert_allclose(pose.origin, np.tile((-5.0 * sine, 0.0, 5.0 * cosine), (TIMES.size, 1)), rtol=0.0, atol=1e-14)


def exact_position(mast: Installation, platform: PlatformSettings, lever: Any, antenna: int, time: float) -> NDArray:
    """The position of a phase centre in 40 digits: rotations of the words in `pose`, one after the other."""
    with mpmath.workdps(40):
        t, radians = mpmath.mpf(time), mpmath.pi / 180

        def swung(name: str, unit: str = "deg") -> Any:
            amplitude, period, phase = (getattr(platform, f"{name}_{key}") for key in (unit, "period_s", "phase_deg"))
            return amplitude * mpmath.sin(2 * mpmath.pi * t / mpmath.mpf(period) + mpmath.mpf(phase) * radians)

        def spun(vector: list[Any], first: int, second: int, angle: Any) -> list[Any]:
            """Turned so that axis `first` goes towards axis `second`."""
            out, c, s = list(vector), mpmath.cos(angle), mpmath.sin(angle)
            out[first], out[second] = c * vector[first] - s * vector[second], s * vector[first] + c * vector[second]
            return out

        east, north, up = 0, 1, 2
        roll = (platform.list_deg + swung("roll")) * radians
        pitch = (platform.trim_deg + swung("pitch")) * radians
        heading = platform.heading_deg * radians
        yaw = heading + swung("yaw") * radians

        def in_world(vector: list[Any]) -> list[Any]:
            rolled = spun(vector, up, east, roll)  # the masthead to starboard
            pitched = spun(rolled, north, up, pitch)  # the bow up
            return spun(pitched, north, east, yaw)  # the bow clockwise

        start = mpmath.mpf(mast.radar.sector_deg[0])
        scan = (start + 360 * t / mpmath.mpf(mast.period)) * radians - heading
        place = [mpmath.mpf(part) for part in mast.radar.antennas[antenna].offset_m]
        leaning = spun(place, up, north, mpmath.mpf(mast.radar.tilt_deg) * radians)  # the top towards the look
        placed = spun(leaning, north, east, scan)
        arm = [mpmath.mpf(part) for part in lever]
        moved = in_world([a + b for a, b in zip(placed, arm, strict=True)])
        rest = spun(arm, north, east, heading)  # upright at time 0 the array is above the world's origin
        run = mpmath.mpf(platform.speed_m_s) * t
        course = [run * mpmath.sin(heading), run * mpmath.cos(heading), swung("heave", "m")]
        foot = [rest[0], rest[1], rest[2] - mpmath.mpf(mast.radar.height_m)]
        return np.array([float(a + b - c) for a, b, c in zip(moved, course, foot, strict=True)])


@pytest.mark.parametrize("lever", [None, (1.5, -2.0, 4.0)])
@pytest.mark.parametrize("tilt", [0.0, 12.0])
def test_positions_are_exact(lever: tuple[float, float, float] | None, tilt: float) -> None:
    """Anything at once: rolling, pitching, yawing, heaving, on its way, antennas aside, off the middle, leant."""
    platform = SWINGING | {"list_deg": 2.0, "trim_deg": -1.0} | ({"lever_arm_m": list(lever)} if lever else {})
    mast = mast_of(platform, tilt_deg=tilt, sector_deg=[-40.0, 200.0], **ASIDE)
    assert mast.platform.lever_arm_m == lever
    times = np.array([-0.08, 0.0, 0.61, 3.27, 19.9])
    found = mast.pose(times).positions
    for number, time in enumerate(times):
        for antenna in (0, 1):
            arm = lever or (0.0, 0.0, mast.radar.height_m)
            exact = exact_position(mast, mast.platform, arm, antenna, time)
            # float64: 1e-16 of the 7000° by which the turntable has turned, on half a metre; and of 100 m run.
            assert_allclose(found[number, antenna], exact, rtol=0.0, atol=2e-13)


def test_the_origin_is_below_the_array_of_the_upright_boat_at_time_0() -> None:
    for lever in (None, [1.5, -2.0, 4.0], [0.0, 0.0, 0.0]):
        arm = {} if lever is None else {"lever_arm_m": lever}
        mast = mast_of({"heading_deg": 50.0, "speed_m_s": 3.0, **arm}, height_m=5.5)
        assert_allclose(mast.pose(np.zeros(1)).origin[0], (0.0, 0.0, 5.5), rtol=0.0, atol=1e-14)


def test_a_lever_of_no_length_keeps_a_rolling_array_in_its_place() -> None:
    pose = mast_of({"list_deg": 25.0, "lever_arm_m": [0.0, 0.0, 0.0]}).pose(TIMES)
    assert_allclose(pose.origin, np.tile((0.0, 0.0, 5.0), (TIMES.size, 1)), rtol=0.0, atol=1e-15)


def test_speed_and_heading_carry_the_origin_along() -> None:
    pose = mast_of({"speed_m_s": 5.0, "heading_deg": 120.0}).pose(TIMES)
    expected = np.outer(5.0 * TIMES, np.append(unit_from_azimuth(120.0), 0.0))
    assert_allclose(pose.origin - np.array([0.0, 0.0, 5.0]), expected, rtol=0.0, atol=1e-13)


def test_a_pose_is_what_its_parts_say() -> None:
    mast = mast_of(SWINGING, tilt_deg=10.0, **ASIDE)
    pose = mast.pose(TIMES)
    assert_allclose(pose.positions, pose.origin[:, None] + mast.offsets @ pose.axes, rtol=0.0, atol=1e-14)
    assert_allclose(pose.bearing, np.degrees(np.arctan2(pose.axes[:, 1, 0], pose.axes[:, 1, 1])) % 360.0)
    some = pose[5:17]
    for name in ("time", "origin", "attitude", "axes", "offsets", "positions", "bearing"):
        assert_array_equal(getattr(some, name), getattr(pose, name)[5:17])


def test_a_mast_with_errors_is_known_without_them() -> None:
    radar = RadarSettings(baseline_error_m=0.02, baseline_m=0.5)
    true = Installation(radar)
    sensed = replace(true, sensors=true.motion).sensed
    between = [np.diff(mast.pose(TIMES).positions, axis=1)[..., 2] for mast in (true, sensed)]
    assert_allclose(between[0], 0.52, rtol=1e-14)
    assert_allclose(between[1], 0.5, rtol=1e-14)


@pytest.mark.parametrize("recorded", [False, True])
def test_a_sensed_heading_that_is_wrong_does_not_turn_the_turntable(recorded: bool, tmp_path: Any) -> None:
    """Its angle against the boat is known: a compass that errs by 2° errs the bearing by 2°, and the place of none."""
    platform: dict[str, Any] = {"heading_deg": 40.0, "lever_arm_m": [0.0, 0.0, 5.0]}
    if recorded:
        file = tmp_path / "motion.csv"
        file.write_text("time_s,heading_deg\n-1,40\n3,40\n7,40\n", encoding="utf-8")
        platform |= {"heading_deg": 0.0, "motion": "file", "file": str(file)}
    true = mast_of(platform)

    def compass(times: Any) -> BoatState:
        state = true.motion(times)
        return BoatState(state.position, state.attitude + np.array([0.0, 0.0, 2.0]))

    sensed = replace(true, sensors=compass).sensed
    apart = wrap_degrees(sensed.pose(TIMES).bearing - true.pose(TIMES).bearing)
    assert_allclose(apart, 2.0, rtol=0.0, atol=1e-11)
    assert_allclose(sensed.pose(TIMES).origin, true.pose(TIMES).origin, rtol=0.0, atol=1e-14)


# ----------------------------------------------------------------------------------------------------------- moving


def test_velocity_of_an_antenna_beside_the_axis_is_that_of_the_turntable() -> None:
    """ω × r, clockwise at 60 rpm; a central difference over 1 ms errs by (ω dt)²/24 = 1.6e-6 of 2 m/s."""
    mast = mast_of(antennas=[{"offset_m": [0.3, -0.1, 0.0]}, {"offset_m": [0.0, 0.0, 0.4]}])
    east, north = unit_from_azimuth(360.0 * TIMES)
    x, y = 0.3 * north - 0.1 * east, -0.3 * east - 0.1 * north  # across is to the right of the boresight
    spin = -2.0 * np.pi  # rad/s about the vertical: clockwise is against the right-hand rule
    expected = np.stack((-spin * y, spin * x, np.zeros_like(x)), axis=-1)
    assert np.hypot(*expected[0, :2]) == pytest.approx(2.0 * np.pi * np.hypot(0.3, 0.1), rel=1e-12)
    assert_allclose(mast.velocity(TIMES)[:, 0], expected, rtol=0.0, atol=4e-6)
    assert_allclose(mast.velocity(TIMES)[:, 1], 0.0, atol=1e-10)  # on the axis: rounding of 1e-15 m over 1 ms


def test_velocity_of_a_rolling_mast_is_omega_cross_r() -> None:
    """ρ = A sin(Ω t + φ) about the keel: the array on its 5 m mast moves at 5 ρ̇, up the mast or down by nothing."""
    platform = {"motion": "sinusoidal", "roll_deg": 15.0, "roll_period_s": 4.0, "roll_phase_deg": 30.0}
    mast = mast_of(platform, baseline_m=0.4)
    swing, omega = np.radians(15.0), 2.0 * np.pi / 4.0
    roll = swing * np.sin(omega * TIMES + np.radians(30.0))
    rate = swing * omega * np.cos(omega * TIMES + np.radians(30.0))
    for antenna, length in enumerate((4.8, 5.2)):
        expected = length * rate[:, None] * np.stack((np.cos(roll), np.zeros_like(roll), -np.sin(roll)), axis=-1)
        # (Ω dt)²/24 = 1e-7 of 2 m/s, and 1e-15 · 5 m over 1 ms
        assert_allclose(mast.velocity(TIMES)[:, antenna], expected, rtol=0.0, atol=5e-7)


def test_velocity_of_a_boat_on_its_way_and_heaving() -> None:
    platform = {"motion": "sinusoidal", "speed_m_s": 5.0, "heading_deg": 120.0, "heave_m": 0.5, "heave_period_s": 5.0}
    omega = 2.0 * np.pi / 5.0
    expected = np.tile((*(5.0 * np.array(unit_from_azimuth(120.0))), 0.0), (TIMES.size, 1))
    expected[:, 2] = 0.5 * omega * np.cos(omega * TIMES)
    found = mast_of(platform).velocity(TIMES)
    # (ω dt)²/24 = 7e-8, and the rounding of 40 m over 1 ms
    assert_allclose(found, np.stack((expected, expected), axis=1), rtol=0.0, atol=2e-7)


@pytest.mark.parametrize("tilt", [0.0, 15.0])
@pytest.mark.parametrize(
    ("rpm", "more"), [(60.0, {}), (20.0, {}), (60.0, {"yaw_deg": 30.0, "yaw_period_s": 2.0}), (6.0, {"roll_deg": 30.0})]
)
def test_the_boresight_passes_each_place_when_it_is_said_to(rpm: float, more: dict[str, Any], tilt: float) -> None:
    """The last two swing it at 0.3 to 0.5 of the turntable's own rate. 1e-9 deg: 0.2 µm at 10 km."""
    mast = mast_of(SWINGING | more, rotation_rpm=rpm, tilt_deg=tilt, sector_deg=[-30.0, 250.0])
    for turn in (0, 7):
        sweep = np.linspace(-15.0, 295.0, 1000)
        time = mast.passing(sweep, (turn + sweep / 360.0) * mast.period)
        assert_allclose(wrap_degrees(mast.pose(time).bearing - (-30.0 + sweep)), 0.0, rtol=0.0, atol=1e-9)
        assert np.all(np.diff(time) > 0.0)
        assert np.abs(time - (turn + sweep / 360.0) * mast.period).max() < 0.2 * mast.period  # of this turn


def test_when_a_place_is_passed_does_not_depend_on_what_else_is_asked() -> None:
    mast = mast_of(SWINGING)
    sweep = np.linspace(0.0, 360.0, 101)
    whole = mast.passing(sweep, sweep / 360.0)
    assert_array_equal(whole[40:53], mast.passing(sweep[40:53], sweep[40:53] / 360.0))


def test_a_boat_that_swings_as_fast_as_the_turntable_turns_is_refused() -> None:
    """A yaw of 8° in 8 s swings at 6.3°/s: at 3 rpm (18°/s) the turntable outruns it, at 1.2 rpm (7.2°/s) it hardly
    does."""
    yawing = {"motion": "sinusoidal", "yaw_deg": 8.0, "yaw_period_s": 8.0}
    time = np.linspace(0.0, 60.0, 3000)
    mast_of(yawing, rotation_rpm=3.0).check_that_it_sweeps(time)
    with pytest.raises(InputError, match=r"^platform: .* 6\.28°/s.* 7\.2°/s.* raise radar\.rotation_rpm") as refusal:
        mast_of(yawing, rotation_rpm=1.2).check_that_it_sweeps(time)
    assert "\n" not in str(refusal.value)
    mast_of(yawing, scan="staring").check_that_it_sweeps(time)


def test_a_boat_that_turns_round_is_refused(tmp_path: Any) -> None:
    """20°/s for 7 s is 140°, for 8 s 160°: nearly the way that could be either."""
    file = tmp_path / "motion.csv"
    file.write_text("time_s,heading_deg\n-1,330\n4,70\n9,170\n", encoding="utf-8")
    mast = mast_of({"motion": "file", "file": str(file)})
    mast.check_that_it_sweeps(np.linspace(0.0, 7.0, 200))
    with pytest.raises(
        InputError, match=r"^platform: the boat turns 160° off .* at most 150°; keep its course"
    ) as refusal:
        mast.check_that_it_sweeps(np.linspace(0.0, 8.0, 200))
    assert "\n" not in str(refusal.value)


def test_the_heeled_fan_stands_off_its_bearing_as_the_closed_form_says() -> None:
    """Abeam nothing leans; ahead, by the whole roll ρ: sin δ = tan ε tan ρ at the depression ε."""
    for roll, depression in ((10.0, np.radians(19.5)), (-25.0, 0.2)):
        ahead = mast_of({"list_deg": roll}, scan="staring", sector_deg=[-10.0, 10.0])
        expected = np.degrees(np.arcsin(np.tan(depression) * np.tan(np.radians(abs(roll)))))
        assert ahead.lean_deg(np.zeros(1), depression) == pytest.approx(expected, rel=1e-9)
        abeam = mast_of({"list_deg": roll}, scan="staring", sector_deg=[80.0, 100.0])
        assert abeam.lean_deg(np.zeros(1), depression) == pytest.approx(0.0, abs=1e-9)
        turning = mast_of({"list_deg": roll})
        assert turning.lean_deg(np.linspace(0.0, 1.0, 721), depression) == pytest.approx(expected, rel=1e-9)
    assert mast_of().lean_deg(TIMES, 0.4) == pytest.approx(0.0, abs=1e-9)


def test_the_heeled_fan_is_where_the_closed_form_has_it() -> None:
    """The direction that stands δ off the bearing, ε down, has no component along the aperture."""
    roll, depression = 17.0, 0.35
    across = mast_of({"list_deg": roll}, scan="staring", sector_deg=[-10.0, 10.0]).pose(np.zeros(1)).axes[0, 0]
    delta = -np.arcsin(np.tan(depression) * np.tan(np.radians(roll)))  # starboard down: it swings to port
    towards = (np.cos(depression) * np.sin(delta), np.cos(depression) * np.cos(delta), -np.sin(depression))
    assert across @ towards == pytest.approx(0.0, abs=1e-15)


def test_a_recorded_motion_sets_the_turntable_by_its_first_heading(tmp_path: Any) -> None:
    """The sector lies where the scene says while the boat keeps the heading that it has at time 0."""
    file = tmp_path / "motion.csv"
    rows = [f"{t:.2f},{70.0 + 4.0 * t:.3f}" for t in np.arange(-1.0, 10.0, 0.25)]
    file.write_text("time_s,heading_deg\n" + "\n".join(rows), encoding="utf-8")
    mast = mast_of({"motion": "file", "file": str(file)}, sector_deg=[10.0, 60.0])
    assert mast.heading == pytest.approx(70.0, abs=1e-9)
    time = np.linspace(0.0, 9.0, 91)
    assert_allclose(mast.swing(time), 4.0 * time, rtol=0.0, atol=1e-9)  # a line: the spline is exact
    assert_allclose(mast.pose(time).attitude[:, 2], 70.0 + 4.0 * time, rtol=1e-12)


def test_column_frames_are_along_clockwise_up() -> None:
    frame = column_frame(np.array([0.0, 90.0, 210.0]))
    assert_allclose(frame[0], [[0.0, 1.0, 0.0], [1.0, 0.0, 0.0], [0.0, 0.0, 1.0]], atol=1e-15)
    assert_allclose(frame[1], [[1.0, 0.0, 0.0], [0.0, -1.0, 0.0], [0.0, 0.0, 1.0]], atol=1e-15)
    for number, azimuth in enumerate((0.0, 90.0, 210.0)):
        assert_allclose(frame[number, 0], boat_axes((0.0, 0.0, azimuth))[1], atol=1e-15)
        assert_allclose(frame[number, 1], boat_axes((0.0, 0.0, azimuth))[0], atol=1e-15)


@pytest.mark.parametrize(
    "keys",
    [
        {},
        {"radar.receiver.chain": "digital"},
        {"radar.transmitter": "magnetron"},
        {"radar.scan": "staring"},
        {"platform.motion": "sinusoidal", "platform.sensors.attitude_noise_deg": 0.2},
    ],
    ids=str,
)
def test_a_turn_is_handed_a_radar_that_is_resolved(keys: dict[str, Any], monkeypatch: pytest.MonkeyPatch) -> None:
    """The array is made with the simulator; a turn makes none but that of a boat at rest, for a magnetron's phases."""
    few = {"radar.sector_deg": [262.0, 270.0], "radar.range_m": [15.0, 60.0], "sea.extent_m": 180.0, "turns": 2}
    simulator = Simulator(load_scene("tiny", overrides={"tracing.tracer": "horizon"} | few | keys))
    simulator.turn(0)
    made: list[RadarSettings] = []

    def noted(radar: RadarSettings) -> Array:
        made.append(radar)
        return antenna_array(radar)

    for name, module in list(sys.modules.items()):
        if name.startswith("seamap_rt.") and getattr(module, "antenna_array", None) is antenna_array:
            monkeypatch.setattr(module, "antenna_array", noted)
    simulator.turn(1)
    assert len(made) <= ("radar.transmitter" in keys)


@pytest.mark.parametrize("room", ["echoes", "truth", "mesh", "session"])
def test_rooms_are_handed_the_installation(room: str) -> None:
    """They take radar and platform from no scene: those of a second installation reach them by the same way."""
    for path in (Path(seamap_rt.__file__).parent / room).rglob("*.py"):
        for node in ast.walk(ast.parse(path.read_text("utf-8"))):
            if isinstance(node, ast.Attribute) and node.attr in ("radar", "platform"):
                assert not ast.unparse(node.value).endswith("scene"), f"{path.name}: {ast.unparse(node)}"


def test_a_boat_steers_as_it_goes() -> None:
    """A motion that is asked for turn by turn moves the antennas as it says; the platform's own changes no bit."""
    keys = {"radar.sector_deg": [262.0, 270.0], "radar.range_m": [15.0, 60.0], "sea.extent_m": 180.0}
    made = load_scene("tiny", overrides=keys | {"tracing.tracer": "horizon", "platform.speed_m_s": 2.0})

    def steered(times: Any) -> BoatState:
        """On a circle of 40 m, and her heading with it."""
        angle = 0.05 * np.asarray(times, dtype=np.float64)
        east, north = 40.0 * (1.0 - np.cos(angle)), 40.0 * np.sin(angle)
        position = np.stack((east, north, 0.0 * angle), axis=-1)
        return BoatState(position, np.stack((0.0 * angle, 0.0 * angle, np.degrees(angle)), axis=-1))

    own, plain = Simulator(made, motion=boat_motion(made.platform)).turn(1), Simulator(made).turn(1)
    assert_array_equal(own.echoes["voltage"], plain.echoes["voltage"])
    echoes = Simulator(made, motion=steered).turn(1).echoes
    there = steered(echoes["time"].values)
    assert_allclose(echoes["attitude"], there.attitude, atol=1e-12)
    assert_allclose(echoes["position"].values.mean(axis=1)[:, :2], there.position[:, :2], atol=1e-12)
