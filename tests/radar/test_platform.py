"""The boat's motion: at rest, on its course, swinging by given amplitudes, and as recorded."""

import numpy as np
import pytest

from seamap_rt.conventions import unit_from_azimuth
from seamap_rt.radar.platform import boat_motion, tilt_std
from seamap_rt.radar.pose import boat_axes
from seamap_rt.sea import ResolvedWaves
from seamap_rt.settings import PlatformSettings, SeaSettings

TIMES = np.linspace(-1.0, 20.0, 2101)


def test_a_boat_left_alone_lies_still_upright_and_bound_north():
    state = boat_motion(PlatformSettings())(TIMES)
    assert state.position.dtype == state.attitude.dtype == np.float64
    np.testing.assert_array_equal(state.position, np.zeros((TIMES.size, 3)))
    np.testing.assert_array_equal(state.attitude, np.zeros((TIMES.size, 3)))


@pytest.mark.parametrize("heading", [0.0, 90.0, 135.0, -60.0])
def test_a_steady_course_leads_where_the_bow_points(heading):
    settings = PlatformSettings(speed_m_s=5.0, heading_deg=heading, list_deg=4.0, trim_deg=-1.5)
    state = boat_motion(settings)(TIMES)
    bow = boat_axes((0.0, 0.0, heading))[1]
    np.testing.assert_allclose(state.position, np.outer(5.0 * TIMES, bow), atol=1e-12)  # rounding, 100 m
    np.testing.assert_array_equal(state.attitude, np.tile((4.0, -1.5, heading), (TIMES.size, 1)))


def test_list_lowers_starboard_and_trim_lifts_the_bow():
    starboard, forward, _ = boat_axes(boat_motion(PlatformSettings(list_deg=4.0, heading_deg=77.0))([0.0]).attitude[0])
    assert starboard[2] == pytest.approx(-np.sin(np.radians(4.0)), abs=1e-15)
    assert forward[2] == pytest.approx(0.0, abs=1e-15)
    starboard, forward, _ = boat_axes(boat_motion(PlatformSettings(trim_deg=4.0, heading_deg=77.0))([0.0]).attitude[0])
    assert forward[2] == pytest.approx(np.sin(np.radians(4.0)), abs=1e-15)
    assert starboard[2] == pytest.approx(0.0, abs=1e-15)


SWINGS = {"roll": (0, 15.0, 4.0, 30.0), "pitch": (1, 5.0, 5.5, -70.0), "yaw": (2, 8.0, 9.0, 200.0)}


def swinging(**changes):
    swings = {
        f"{name}_{key}": value
        for name, (_, *values) in SWINGS.items()
        for key, value in zip(("deg", "period_s", "phase_deg"), values, strict=True)
    }
    heave = {"heave_m": 0.7, "heave_period_s": 6.0, "heave_phase_deg": 10.0}
    return PlatformSettings(motion="sinusoidal", **{**swings, **heave, **changes})


@pytest.mark.parametrize("name", SWINGS)
def test_each_angle_swings_about_rest_with_its_own_amplitude_period_and_phase(name):
    column, amplitude, period, phase = SWINGS[name]
    state = boat_motion(swinging(list_deg=2.0, trim_deg=1.0, heading_deg=-40.0))(TIMES)
    swing = state.attitude[:, column] - (2.0, 1.0, -40.0)[column]
    expected = amplitude * np.sin(2.0 * np.pi * TIMES / period + np.radians(phase))
    np.testing.assert_allclose(swing, expected, atol=1e-13 * 360.0)  # rounding
    fitted = np.linalg.lstsq(
        np.stack((np.sin(2.0 * np.pi * TIMES / period), np.cos(2.0 * np.pi * TIMES / period)), axis=1),
        swing,
        rcond=None,
    )[0]
    assert np.hypot(*fitted) == pytest.approx(amplitude, rel=1e-12)
    assert np.degrees(np.arctan2(fitted[1], fitted[0])) % 360.0 == pytest.approx(phase % 360.0, abs=1e-9)


def test_heave_lifts_and_yaw_does_not_bend_the_course():
    state = boat_motion(swinging(speed_m_s=3.0, heading_deg=30.0))(TIMES)
    np.testing.assert_allclose(
        state.position[:, 2], 0.7 * np.sin(2.0 * np.pi * TIMES / 6.0 + np.radians(10.0)), atol=1e-14
    )
    np.testing.assert_allclose(state.position[:, :2], np.outer(3.0 * TIMES, unit_from_azimuth(30.0)), atol=1e-12)


def test_rates_over_a_millisecond_are_the_swings_own():
    motion = boat_motion(swinging(speed_m_s=3.0, heading_deg=30.0))
    rate = (motion(TIMES + 5e-4).attitude - motion(TIMES - 5e-4).attitude)[:, 0] / 1e-3
    omega = 2.0 * np.pi / 4.0
    # (ω dt)²/24 = 1e-7 of the difference, and rounding, 1e-14 of 40° over 1e-3 s.
    np.testing.assert_allclose(rate, 15.0 * omega * np.cos(omega * TIMES + np.radians(30.0)), atol=3e-6)


def test_a_motion_of_waves_needs_a_sea():
    with pytest.raises(ValueError, match=r"^platform\.motion = 'wave_following': must have a sea.*; give") as caught:
        boat_motion(PlatformSettings(motion="wave_following"))
    assert "\n" not in str(caught.value)


def test_a_recorded_motion_is_that_of_the_file(tmp_path):
    path = tmp_path / "motion.csv"
    path.write_text("time_s,roll_deg,heave_m\n0,1,0.5\n0.5,2,0.25\n1,3,0\n")
    state = boat_motion(PlatformSettings(motion="file", file=str(path), heading_deg=25.0))([0.0, 0.25, 1.0])
    np.testing.assert_allclose(state.attitude, [[1.0, 0.0, 25.0], [1.5, 0.0, 25.0], [3.0, 0.0, 25.0]], atol=1e-14)
    np.testing.assert_allclose(state.position[:, 2], [0.5, 0.375, 0.0], atol=1e-15)


def test_a_rolling_boat_tilts_by_half_its_amplitude_along_the_look():
    rolling = PlatformSettings(motion="sinusoidal", roll_deg=10.0)
    sea = SeaSettings()
    # Rms of a sine is 1/√2, and over all looks another 1/√2 of it lies along them; 100 whole periods.
    tilt = tilt_std(rolling, 100.0 * rolling.roll_period_s, ResolvedWaves.of(sea, 1.0))
    assert tilt == pytest.approx(np.radians(5.0), rel=0.01)
