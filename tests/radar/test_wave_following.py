"""A boat on waves: long waves carry it as they are, short ones pass under it, and between lies the plane that fits."""

from typing import Any

import numpy as np
import pytest

from seamap_rt.conventions import unit_from_azimuth
from seamap_rt.physics.dispersion import angular_frequency
from seamap_rt.radar import wave_following
from seamap_rt.radar.platform import boat_motion
from seamap_rt.radar.pose import boat_axes
from seamap_rt.radar.wave_following import WaveFollowing, wave_tilt_std
from seamap_rt.scene import load_scene
from seamap_rt.sea import ResolvedWaves, Sea, realize
from seamap_rt.settings import JonswapWaves, PlatformSettings, SeaSettings, SinusoidWaves

TIMES = np.linspace(-5.0, 55.0, 601)


def sinusoid(**changes):
    return SinusoidWaves(**{"spectrum": "sinusoid", "height_m": 1.0, "wavelength_m": 400.0, **changes})


def jonswap(**changes):
    return JonswapWaves(**{"spectrum": "jonswap", "significant_wave_height_m": 1.4, "peak_period_s": 5.5, **changes})


def sea_of(*waves: Any, seed: int = 1, **changes: Any) -> Sea:
    return realize(SeaSettings(**{"resolution_m": 1.0, "extent_m": 256.0, "waves": waves, **changes}), seed=seed)


def boat(**changes):
    return PlatformSettings(motion="wave_following", **changes)


def riding(sea, **changes):
    return WaveFollowing(sea.components(), **{"length_m": 7.0, "beam_m": 2.5, "heading_deg": 0.0, **changes})


def fitted_plane(sea, centre, heading_deg, length_m, beam_m, t):
    """Height and slopes ahead and to starboard of the plane through the sea at 56 × 20 places of a waterline."""
    u, v = np.meshgrid((np.arange(56) + 0.5) / 56.0 - 0.5, (np.arange(20) + 0.5) / 20.0 - 0.5, indexing="ij")
    ahead, starboard = length_m * u.ravel(), beam_m * v.ravel()
    east, north = unit_from_azimuth(heading_deg)
    x, y = centre[0] + ahead * east + starboard * north, centre[1] + ahead * north - starboard * east
    basis = np.stack((np.ones_like(ahead), ahead, starboard), axis=-1)
    return np.linalg.lstsq(basis, sea.elevation(x, y, t), rcond=None)[0]


@pytest.fixture(scope="module")
def wind_sea():
    return sea_of(jonswap())


# --------------------------------------------------------------------------------------------- long and short waves


@pytest.mark.parametrize("heading", [0.0, 90.0, 130.0, 270.0])
def test_waves_much_longer_than_the_boat_carry_it_as_they_are(heading):
    sea = sea_of(sinusoid(wave_from_deg=250.0, phase_deg=40.0))
    state = boat_motion(boat(heading_deg=heading), sea)(TIMES)
    slopes = sea.slopes(0.0, 0.0, TIMES)
    east, north = unit_from_azimuth(heading)
    ahead, starboard = slopes @ (east, north), slopes @ (north, -east)
    # The boat's means fall short by (kl)²/6 and (kl)²/10, l = 3.5 m: 5e-4 and 3e-4 at kl = 0.055.
    np.testing.assert_allclose(state.position[:, 2], sea.elevation(0.0, 0.0, TIMES), atol=6e-4 * 0.5)
    amplitude = 0.5 * 2.0 * np.pi / 400.0
    np.testing.assert_allclose(np.tan(np.radians(state.attitude[:, 1])), ahead, atol=6e-4 * amplitude)
    # Roll turns about a keel that is pitched already: second order in the slope, (8e-3)²/2 of it.
    np.testing.assert_allclose(np.tan(np.radians(state.attitude[:, 0])), -starboard, atol=7e-4 * amplitude)
    np.testing.assert_array_equal(state.attitude[:, 2], heading)
    np.testing.assert_array_equal(state.position[:, :2], 0.0)


def test_water_that_is_higher_to_port_rolls_to_starboard_and_higher_ahead_lifts_the_bow():
    # A wave from the east, η = cos(−kx − ωt − 90°) = −sin(kx + ωt).
    sea = sea_of(sinusoid(wave_from_deg=90.0, phase_deg=-90.0))
    assert sea.elevation(10.0, 0.0, 0.0) < 0.0 < sea.elevation(-10.0, 0.0, 0.0)  # higher in the west
    roll, pitch, _ = boat_motion(boat(heading_deg=0.0), sea)([0.0]).attitude[0]
    assert roll > 0.3  # port is west: starboard down; the wave's steepest slope is 0.45°
    assert abs(pitch) < 1e-9
    roll, pitch, _ = boat_motion(boat(heading_deg=270.0), sea)([0.0]).attitude[0]
    assert pitch > 0.3
    assert abs(roll) < 1e-9


def test_waves_much_shorter_than_the_boat_leave_it_alone():
    wave = {"height_m": 0.02, "wavelength_m": 0.53}
    sea = sea_of(sinusoid(wave_from_deg=215.0, **wave))
    heave, ahead, starboard = np.abs(riding(sea, length_m=20.0, beam_m=6.0)(TIMES)).max(axis=0)
    # |j₀(p)| ≤ 1/p and |B(p)| ≤ 3 (p + 1)/p³, p = 97 and 20 along and across: 5e-4, and 2e-5 and 8e-5 of the slope.
    p, q = (
        np.pi * size * abs(c) / 0.53 for size, c in zip((20.0, 6.0), np.cos(np.radians((215.0, 125.0))), strict=True)
    )
    assert heave <= 0.01 / (p * q)
    slope = 0.01 * 2.0 * np.pi / 0.53
    assert ahead <= slope * 3.0 * (p + 1.0) / p**3 / q
    assert starboard <= slope * 3.0 * (q + 1.0) / q**3 / p


def test_a_boat_heaves_less_than_the_sea_and_a_longer_one_less_still(wind_sea):
    waves = wind_sea.components()
    sea = 0.5 * np.sum(np.abs(waves.amplitude) ** 2)
    found = []
    for length in (1e-3, 7.0, 20.0, 60.0):
        response = WaveFollowing(waves, length_m=length, beam_m=0.3 * length, heading_deg=270.0).response
        found.append(0.5 * np.sum(np.abs(response[:, 0]) ** 2) / sea)
    assert found[0] == pytest.approx(1.0, abs=2e-4)  # a cork; 1e-4 of the variance is left out
    assert found[1] < 0.95
    assert np.all(np.diff(found) < 0.0)
    assert found[3] < 0.05  # longer than the waves, 47 m at the peak


# --------------------------------------------------------------------------------------------- course and encounter


def test_a_boat_turned_round_pitches_and_rolls_the_other_way(wind_sea):
    ahead = riding(wind_sea, heading_deg=33.0)(TIMES)
    back = riding(wind_sea, heading_deg=213.0)(TIMES)
    np.testing.assert_allclose(back, ahead * (1.0, -1.0, -1.0), atol=1e-12)  # rounding


@pytest.mark.parametrize("speed", [0.0, 3.0, 12.0])
@pytest.mark.parametrize(("course", "sign"), [("against", 1.0), ("with", -1.0), ("along the crests", 0.0)])
def test_the_frequency_of_encounter(speed, course, sign):
    wave = sinusoid(wavelength_m=40.0, wave_from_deg=60.0)
    heading = {"against": 60.0, "with": 240.0, "along the crests": 150.0}[course]
    sea = sea_of(wave)
    k = 2.0 * np.pi / 40.0
    omega = float(angular_frequency(k)) + sign * k * speed  # 12 m/s overtakes the wave, which runs at 7.9 m/s
    heave = boat_motion(boat(heading_deg=heading, speed_m_s=speed), sea)(TIMES).position[:, 2]
    expected = np.cos(omega * TIMES)
    # Twice the spline's error, (0.15/0.85)⁸ = 1e-6 of the amplitude, and half as much again.
    np.testing.assert_allclose(heave, heave[50] * expected, atol=3e-6 * 0.5)
    assert TIMES[50] == pytest.approx(0.0, abs=1e-12)


def test_the_current_carries_the_waves_past_the_boat():
    wave, k = sinusoid(wavelength_m=40.0, wave_from_deg=60.0), 2.0 * np.pi / 40.0
    stream: dict[str, Any] = {"current_m_s": 2.0, "current_toward_deg": 240.0}  # as the waves
    sea = sea_of(wave, **stream)
    resting = boat_motion(boat(heading_deg=60.0), sea)(TIMES).position[:, 2]
    still = float(angular_frequency(k))
    np.testing.assert_allclose(resting, resting[50] * np.cos((still + 2.0 * k) * TIMES), atol=3e-6 * 0.5)
    # One that drifts with the current meets the waves at their own frequency.
    drifting = boat_motion(boat(heading_deg=240.0, speed_m_s=2.0), sea)(TIMES).position[:, 2]
    np.testing.assert_allclose(drifting, drifting[50] * np.cos(still * TIMES), atol=3e-6 * 0.5)


def test_list_and_trim_are_added_and_the_course_is_kept(wind_sea):
    upright = boat_motion(boat(heading_deg=300.0, speed_m_s=4.0), wind_sea)(TIMES)
    leaning = boat_motion(boat(heading_deg=300.0, speed_m_s=4.0, list_deg=3.0, trim_deg=-2.0), wind_sea)(TIMES)
    np.testing.assert_allclose(leaning.attitude - upright.attitude, np.tile((3.0, -2.0, 0.0), (601, 1)), atol=1e-12)
    np.testing.assert_array_equal(leaning.position, upright.position)
    along = np.outer(4.0 * TIMES, unit_from_azimuth(300.0))
    np.testing.assert_allclose(upright.position[:, :2], along, atol=1e-12)


def test_with_a_lever_arm_the_waterline_lies_where_the_boat_is_not_where_its_mast_is(wind_sea):
    # The mast 3 m ahead of the middle and 1 m to port; bound for the east the boat lies 3 m west and 1 m south of it.
    moved = boat_motion(boat(heading_deg=90.0, lever_arm_m=(-1.0, 3.0, 5.0)), wind_sea)(TIMES)
    there = riding(wind_sea, heading_deg=90.0, start=(-3.0, -1.0))(TIMES)
    np.testing.assert_allclose(moved.position[:, 2], there[:, 0], atol=1e-12)
    np.testing.assert_array_equal(moved.position[:, :2], 0.0)


# --------------------------------------------------------------------------------------------- the plane that fits


@pytest.mark.parametrize("heading", [20.0, 270.0])
@pytest.mark.parametrize(("left_out", "tolerance"), [(0.0, 2e-3), (None, 2e-2)])
def test_it_is_the_least_squares_plane_over_the_waterline(wind_sea, monkeypatch, heading, left_out, tolerance):
    if left_out is not None:
        monkeypatch.setattr(wave_following, "NEGLIGIBLE", left_out)
    east, north = unit_from_azimuth(heading)
    times = np.linspace(-3.0, 17.0, 41)
    boat = riding(wind_sea, heading_deg=heading, velocity=(4.0 * float(east), 4.0 * float(north)), start=(5.0, -2.0))
    exact = np.array(
        [fitted_plane(wind_sea, (5.0 + 4.0 * t * east, -2.0 + 4.0 * t * north), heading, 7.0, 2.5, t) for t in times]
    )
    error = np.sqrt(np.mean((boat(times) - exact) ** 2, axis=0) / np.mean(exact**2, axis=0))
    # All waves: the sea's own interpolation, 3e-4 m of 0.35 m, and the plane of points for that of the area, (1/20)²/2
    # of the slope across. Without the least: 1e-4 of the variance, so 1e-2 of the rms.
    assert np.all(error < tolerance)


def test_the_deck_lies_in_the_plane(wind_sea):
    motion = boat_motion(boat(heading_deg=20.0), wind_sea)(TIMES)
    _, ahead, starboard = riding(wind_sea, heading_deg=20.0)(TIMES).T
    east, north = unit_from_azimuth(20.0)
    up = np.stack((-ahead * east - starboard * north, -ahead * north + starboard * east, np.ones_like(ahead)), axis=-1)
    up /= np.linalg.norm(up, axis=1, keepdims=True)
    np.testing.assert_allclose(boat_axes(motion.attitude)[:, 2], up, atol=1e-12)


def test_on_choppy_waves_it_is_right_to_first_order():
    found = []
    for height in (0.35, 1.4):
        sea = sea_of(jonswap(significant_wave_height_m=height), model="choppy", resolution_m=2.0)
        times = np.linspace(0.0, 20.0, 41)
        exact = np.array([fitted_plane(sea, (0.0, 0.0), 20.0, 7.0, 2.5, t) for t in times])
        error = np.sqrt(np.mean((riding(sea, heading_deg=20.0)(times) - exact) ** 2, axis=0))
        found.append(error / np.sqrt(np.mean(exact**2, axis=0)))
    low, high = np.array(found)
    # The error's share grows as the height, or less where the 1e-2 of the waves left out is the larger part of it.
    assert np.all(high < 0.25)
    assert np.all(low < 0.5 * high)


# --------------------------------------------------------------------------------------------- the spline in time


@pytest.mark.parametrize("velocity", [(0.0, 0.0), (-8.0, 3.0)])
def test_the_spline_is_the_sum_of_waves(wind_sea, velocity):
    boat = riding(wind_sea, heading_deg=110.0, velocity=velocity)
    times = np.random.default_rng(3).uniform(-5.0, 600.0, 100)
    exact = (np.exp(-1j * np.outer(times, boat.omega)) @ boat.response).real
    error = np.max(np.abs(boat(times) - exact), axis=0) / np.sqrt(0.5 * np.sum(np.abs(boat.response) ** 2, axis=0))
    assert np.all(error < 3e-7)  # 1e-6 of the fastest encounters, which hold the least of the motion


def test_rates_over_a_millisecond_are_those_of_the_waves(wind_sea):
    boat = riding(wind_sea, heading_deg=110.0, velocity=(-8.0, 3.0))
    times = np.random.default_rng(4).uniform(-5.0, 60.0, 100)
    rate = (boat(times + 5e-4) - boat(times - 5e-4)) / 1e-3
    waves = -1j * boat.omega[:, None] * boat.response
    exact = (np.exp(-1j * np.outer(times, boat.omega)) @ waves).real
    error = np.max(np.abs(rate - exact), axis=0) / np.sqrt(0.5 * np.sum(np.abs(waves) ** 2, axis=0))
    # A difference errs by (Ω dt)²/24 of the fastest encounter, 32 rad/s: 4e-5, and they hold the least of the motion.
    assert np.all(error < 3e-5)


def test_what_was_asked_before_changes_nothing(wind_sea):
    first, second = riding(wind_sea), riding(wind_sea)
    whole = first(TIMES)
    shuffled = np.random.default_rng(5).permutation(TIMES.size)
    pieces = np.concatenate([second(TIMES[part]) for part in np.array_split(shuffled, 7)])
    np.testing.assert_array_equal(pieces, whole[shuffled])
    np.testing.assert_array_equal(second([1e4]), riding(wind_sea)([1e4]))


def test_no_waves_no_motion():
    state = boat_motion(boat(heading_deg=10.0), sea_of())(TIMES)
    np.testing.assert_array_equal(state.position, 0.0)
    np.testing.assert_array_equal(state.attitude, np.tile((0.0, 0.0, 10.0), (601, 1)))


@pytest.mark.parametrize("phase", [0.0, 1e-6, 0.049999, 0.050001, 1.0, 30.0, -2.0])
def test_the_weights_are_their_integrals(phase):
    u, weight = np.polynomial.legendre.leggauss(64)
    wave = np.exp(1j * phase * u)
    assert wave_following._mean(np.array([phase]))[0] == pytest.approx(np.sum(weight * wave).real / 2.0, abs=1e-13)
    if phase:
        slope = np.sum(weight * u * wave) / np.sum(weight * u**2) / (1j * phase)
        # At 1e-6 the integral itself loses ten digits; beside 0.05 the series' next term is (0.05)⁶/15120 = 1e-12.
        assert wave_following._lean(np.array([phase]))[0] == pytest.approx(
            slope.real, abs=1e-9 if phase < 1e-3 else 2e-12
        )


def test_a_small_boat_has_the_waves_slope_and_a_long_one_none():
    scene = load_scene("tiny", {"sea.extent_m": 420.0, "sea.resolution_m": 2.0, "radar.range_m": [30.0, 150.0]})
    waves = ResolvedWaves.of(scene.sea, 0.5 * np.pi)
    slope = np.sqrt(0.5 * np.sum(waves.variance * waves.wavenumber**2))
    # 1 − p²/10 of the slope and 1 − q²/6 of the level, p and q below 0.08.
    assert wave_tilt_std(waves, 0.1, 0.1) == pytest.approx(slope, rel=2e-3)
    tilts = [wave_tilt_std(waves, length, 2.5) for length in (3.0, 7.0, 20.0, 100.0)]
    assert tilts == sorted(tilts, reverse=True)
    # Waves that run along a great raft have nothing left; those a metre long would not either.
    assert wave_tilt_std(waves, 3000.0, 3000.0) < 1e-3 * slope
