"""Advice: encounter of regular waves, symmetry, chances beside brute force, and what cannot be told."""

from __future__ import annotations

import re
from typing import Any

import numpy as np
import pytest

from seamap_rt.conventions import GRAVITY
from seamap_rt.errors import InputError
from seamap_rt.prediction import Box, Follower, Hull, Spectrum, WaveField, advise, countdown, forecast, turn_windows
from seamap_rt.prediction.advice import advise_on
from seamap_rt.prediction.advice_motions import (
    Envelope,
    Expectation,
    SeaPrediction,
    Transfers,
    Waves,
    _strongest,
    shares_of,
)
from seamap_rt.prediction.quantity import Course
from seamap_rt.prediction.reconstruction import reconstruct
from seamap_rt.settings import PredictionSettings

BOAT = Box(7.0, 2.5, 0.45)
SIGMA, PEAK = 0.35, 2.0 * np.pi / 5.5  # m, rad/s


def known(envelopes: Envelope, lead: np.ndarray, transfers: Transfers) -> Expectation:
    """All is known."""
    del lead, transfers
    return envelopes.sum(axis=0).real, np.zeros(envelopes.shape[1:])


def unknown(envelopes: Envelope, lead: np.ndarray, transfers: Transfers) -> Expectation:
    """No phase is known: what is open is the sea's own power, of groups of one variance."""
    del lead
    power = SIGMA**2 * np.mean(np.abs(transfers.groups) ** 2, axis=-1)
    return np.zeros(envelopes.shape[1:]), np.broadcast_to(power[..., None], envelopes.shape[1:])


def sea_of(waves: Waves, amplitudes: np.ndarray, expect: Any) -> SeaPrediction:
    """Waves that are their own groups and spectrum, all of one variance, SIGMA² together."""
    variance = np.full(waves.kx.size, SIGMA**2 / waves.kx.size)
    return SeaPrediction(waves, amplitudes[None], expect, waves, variance, np.arange(waves.kx.size), waves, variance)


def towards(azimuth_deg: float, omega: np.ndarray, depth_m: float = np.inf) -> Waves:
    """Waves that run towards an azimuth, by Newton's method from k = ω²/g."""
    k = omega**2 / GRAVITY
    for _ in range(50):
        tanh = np.tanh(np.minimum(k * depth_m, 300.0))
        k = 0.5 * (k + omega**2 / (GRAVITY * tanh))
    toward = np.radians(azimuth_deg)
    return Waves(k * np.sin(toward), k * np.cos(toward), omega)


@pytest.mark.parametrize("depth", [np.inf, 4.0])
@pytest.mark.parametrize(("heading", "sign"), [(180.0, 1.0), (0.0, -1.0), (90.0, 0.0)])  # head, following, beam sea
def test_a_regular_wave_is_met_as_often_as_the_boat_runs_into_it(depth: float, heading: float, sign: float) -> None:
    """ωₑ = ω ± kU; a raft's heave is the wave, its slope along the heading its pitch, and its acceleration ωₑ² a. The
    transform is exact to 1e-4 of the amplitude."""
    waves, amplitude, speed = towards(0.0, np.array([PEAK]), depth), 0.4 * np.exp(0.7j), 5.0
    k = float(np.hypot(waves.kx, waves.ky)[0])
    met = PEAK + sign * k * speed
    sea, lead = sea_of(waves, np.array([amplitude]), known), np.arange(0.0, 20.1, 0.25)
    transfers = sea.transfers([Course(heading, speed)], shares_of(Follower(), Hull(), depth))
    heave, _, pitch, acceleration, _ = sea.expected(lead, transfers)[0][0]
    expected = (amplitude * np.exp(-1j * met * lead)).real
    np.testing.assert_allclose(heave, expected, atol=5e-4 * 0.4)
    np.testing.assert_allclose(acceleration, -(met**2) * expected, atol=5e-4 * 0.4 * met**2)
    slope = (-sign * 1j * k * amplitude * np.exp(-1j * met * lead)).real
    np.testing.assert_allclose(pitch, slope, atol=5e-4 * 0.4 * k)


def test_a_place_on_board_moves_with_pitch_and_roll() -> None:
    """A raft's every place follows the tangent plane: forward and starboard by the slopes there."""
    waves, place = towards(35.0, np.array([PEAK])), (3.0, 1.2)
    sea, lead = sea_of(waves, np.array([0.4 + 0j]), known), np.arange(0.0, 10.1, 0.25)
    transfers = sea.transfers([Course(0.0, 0.0)], shares_of(Follower(), Hull(place, bow_m=5.0), np.inf))
    acceleration, bow = sea.expected(lead, transfers)[0][0, 3:]
    plane = 1.0 + 1j * (waves.ky * place[0] + waves.kx * place[1])  # heading north: forward is north, starboard east
    expected = -(PEAK**2) * (0.4 * plane * np.exp(-1j * PEAK * lead)).real
    np.testing.assert_allclose(acceleration, expected, atol=5e-4 * 0.4 * PEAK**2)
    over = 1.0 + 5j * waves.ky - np.exp(5j * waves.ky)  # of the tangent plane over the wave, 5 m forward
    np.testing.assert_allclose(bow, (0.4 * over * np.exp(-1j * PEAK * lead)).real, atol=5e-4 * 0.4)


@pytest.mark.parametrize("share", [0.2, 0.5, 0.99])
def test_the_waves_that_are_kept_are_the_fewest_that_hold_the_share(share: float) -> None:
    power = np.random.default_rng(4).exponential(size=200)
    kept = power[_strongest(power, share)]
    assert kept.sum() >= share * power.sum() > kept.sum() - kept.min()


def test_headings_mirrored_in_the_seas_direction_are_alike() -> None:
    sea = sea_of(towards(90.0, np.linspace(0.8, 1.6, 40)), np.zeros(40, complex), unknown)
    made = advise_on(sea, BOAT, np.inf, [30.0, 150.0, 60.0, 120.0], [0.0, 5.0], 20.0)
    for name in ("heave_rms", "roll_rms", "pitch_rms", "acceleration_rms", "slam_probability"):
        beyond = made[name].sel(part="beyond").values
        np.testing.assert_allclose(beyond[0], beyond[1], rtol=1e-9)
        np.testing.assert_allclose(beyond[2], beyond[3], rtol=1e-9)


def test_chances_are_those_of_brute_force() -> None:
    """Of 2000 seas drawn wave by wave, how often the heave of a raft passes 2.2 σ in 30 s: the draws' share within 3.3
    binomial errors of both, and the spectrum's, by crossings at random, within those and the 0.1 by which crossings
    that come in groups are fewer."""
    omega, count, limit = np.linspace(0.8, 1.6, 60), 2000, 2.2 * SIGMA
    sea = sea_of(towards(90.0, omega), np.zeros(60, complex), unknown)
    stream, lead = np.random.default_rng(8), np.arange(0.0, 30.1, 0.05)
    amplitude = SIGMA / np.sqrt(60) * (stream.standard_normal((count, 60)) + 1j * stream.standard_normal((count, 60)))
    heave = (amplitude @ np.exp(-1j * np.multiply.outer(omega, lead))).real
    share = float(np.mean(np.abs(heave).max(axis=1) > limit))
    task = {"limits": {"heave": limit}}
    made = advise_on(sea, Follower(), np.inf, [0.0], [0.0], 30.0, draws=1000, task=task)
    error = np.sqrt(share * (1.0 - share) * (1.0 / count + 1.0 / 1000))
    assert float(made["exceedance_probability"][0, 0, 0]) == pytest.approx(share, abs=3.3 * error)
    rate = 2.0 * np.sqrt(np.mean(omega**2)) / (2.0 * np.pi) * np.exp(-0.5 * 2.2**2)
    rare = advise_on(sea, Follower(), np.inf, [0.0], [0.0], 30.0, draws=2, task={"limits": {"heave": 4.0 * SIGMA}})
    rarely = rate * np.exp(0.5 * (2.2**2 - 4.0**2))
    assert float(rare["exceedance_probability"][0, 0, 1]) == pytest.approx(1.0 - np.exp(-600.0 * rarely), rel=1e-6)
    assert 1.0 - np.exp(-30.0 * rate) == pytest.approx(share, abs=0.1 + 3.3 * error)
    rms = float(made["heave_rms"][0, 0, 0])
    assert rms == pytest.approx(SIGMA, rel=0.05)  # 1000 draws of some ten independent moments
    assert float(made["heave_rms"][0, 0, 1]) == pytest.approx(SIGMA, rel=1e-6)


@pytest.mark.parametrize("speed", [0.0, 3.0])
def test_a_bow_slams_where_it_re_enters_fast_enough(speed: float) -> None:
    """In a regular wave the bow moves over the water by A cos(ωₑt): it leaves it where A is above the draught d, and
    re-enters at ωₑ √(A² − d²). Moments are 0.25 s apart, so that speeds are told to a tenth."""
    waves, amplitude = towards(180.0, np.array([1.6])), np.array([0.9 + 0j])
    course, hull = Course(0.0, speed), Hull(bow_m=3.5, draught_m=0.2, freeboard_m=0.5, slam_speed_m_s=1.0)
    share = shares_of(BOAT, hull, np.inf)(waves, course)[4, 0]
    size, met = 0.9 * abs(share), 1.6 + 1.6**2 / GRAVITY * speed
    enters = met * np.sqrt(size**2 - (0.5 * size) ** 2)
    for factor, slams in ((0.85, 1.0), (1.15, 0.0)):
        told = Hull(bow_m=3.5, draught_m=0.5 * size, freeboard_m=factor * size, slam_speed_m_s=factor * enters)
        made = advise_on(sea_of(waves, amplitude, known), BOAT, np.inf, [0.0], [speed], 30.0, hull=told, draws=2)
        assert float(made["slam_probability"][0, 0, 0]) == slams
        assert float(made["green_water_probability"][0, 0, 0]) == slams


def test_slams_of_minutes_are_ochis() -> None:
    """Of waves of one frequency, which meet the boat N times in 600 s, the bow leaves the water and re-enters faster
    than v in N exp(−d²/2σ² − v²/2(ωₑσ)²) of them (Ochi 1964), and water comes over a freeboard f in N exp(−f²/2σ²)."""
    waves, speed = towards(180.0, np.array([1.6])), 3.0
    met = 1.6 + 1.6**2 / GRAVITY * speed
    hull = Hull(bow_m=3.5, draught_m=0.2, freeboard_m=0.5, slam_speed_m_s=1.0)
    sigma = SIGMA * abs(shares_of(BOAT, hull, np.inf)(waves, Course(0.0, speed))[4, 0])
    told = Hull(bow_m=3.5, draught_m=2.5 * sigma, freeboard_m=3.2 * sigma, slam_speed_m_s=1.8 * met * sigma)
    sea = sea_of(waves, np.zeros(1, complex), unknown)
    made = advise_on(sea, BOAT, np.inf, [0.0], [speed], 2.0, hull=told, draws=2).sel(part="beyond")
    for name, exponent in (("slam", 0.5 * (2.5**2 + 1.8**2)), ("green_water", 0.5 * 3.2**2)):
        expected = -np.expm1(-600.0 * met / (2.0 * np.pi) * np.exp(-exponent))
        assert float(made[f"{name}_probability"][0, 0]) == pytest.approx(expected, rel=1e-6)


def test_what_cannot_be_told_is_said() -> None:
    """In a sea without phases a boat abeam is as well off on the mirrored heading; one that holds the worst is told."""
    sea = sea_of(towards(90.0, np.linspace(0.8, 1.6, 40)), np.zeros(40, complex), unknown)
    alike = advise_on(sea, BOAT, np.inf, [60.0, 120.0], [3.0], 30.0, task={"hold": (60.0, 3.0)})
    assert alike.attrs["verdict"] == "no difference that can be told"
    assert float(alike["difference"][0, 0]) == 0.0
    assert float(alike["better_probability"][0, 0]) == 0.5
    worse = advise_on(sea, BOAT, np.inf, [90.0, 0.0], [3.0], 60.0, draws=200, task={"hold": (0.0, 3.0)})
    assert worse.attrs["best_heading_deg"] == 90.0  # with the seas, long-crested: no roll
    assert worse.attrs["verdict"].startswith("steer 090° at 3.0 m/s: least roll ")
    assert worse.attrs["verdict"].split(" instead")[0].endswith("°")
    counted = {"mission": "fewest_exceedances", "limits": {"roll": 1.0}, "hold": (0.0, 3.0)}
    fewest = advise_on(sea, BOAT, np.inf, [90.0, 0.0], [3.0], 60.0, draws=200, task=counted).attrs
    assert fewest["score_units"] == "1"
    assert re.fullmatch(r"steer 090° at 3\.0 m/s: fewest exceedances \S+ instead of \S+ \(.*\)", fewest["verdict"])
    assert float(worse["better_probability"][0, 0]) == 1.0


def test_most_way_counts_where_limits_hold() -> None:
    """A sea that is known, and rolls the boat abeam beyond its limit: the most way is made on the nearest heading
    within it; way counts towards where the boat is bound."""
    sea = sea_of(towards(90.0, np.array([PEAK])), np.array([0.6 + 0j]), known)
    task = {"mission": "most_way", "limits": {"roll": 3.0}, "hold": (0.0, 4.0, 0.0)}
    made = advise_on(sea, BOAT, np.inf, np.arange(0.0, 91.0, 15.0), [4.0], 30.0, draws=2, task=task)
    inside = made["roll_p95"].sel(part="seen").values[:, 0] <= 3.0
    assert inside.any()
    assert not inside[0]
    assert made.attrs["best_heading_deg"] == made["heading"].values[inside].min()
    way = made["distance_made_good"].sel(part="seen").values[:, 0]
    np.testing.assert_allclose(way, 4.0 * 30.0 * np.cos(np.radians(made["heading"].values)), atol=1e-9)


def test_way_counts_by_the_chance_that_limits_hold() -> None:
    sea = sea_of(towards(90.0, np.linspace(0.8, 1.6, 40)), np.zeros(40, complex), unknown)
    task = {"mission": "most_way", "limits": {"heave": 2.2 * SIGMA}}
    made = advise_on(sea, Follower(), np.inf, [0.0, 60.0], [4.0], 30.0, draws=200, task=task)
    chance, way = (made[name].values[..., 0] for name in ("exceedance_probability", "distance_made_good"))
    assert ((chance > 0.1) & (chance < 0.9)).all()
    np.testing.assert_allclose(made["score"], -way * (1.0 - chance), rtol=1e-12)


# ------------------------------------------------------------------------------------------------ of a wave field


@pytest.fixture(scope="module")
def field() -> WaveField:
    from test_forecast import KnownSea, seen

    omega = np.linspace(0.3, 4.0, 400)
    shape = np.exp(-(((omega - PEAK) / 0.15) ** 2) / 2.0)
    spectrum = Spectrum.of_frequency(omega, SIGMA**2 * shape / np.trapezoid(shape, omega), 270.0, 30.0)
    settings = PredictionSettings(sharpness=0.0, lead_s=30.0)
    return reconstruct(settings=settings, observations=seen(KnownSea(), 4000), spectrum=spectrum)


@pytest.mark.parametrize("speed", [0.0, 4.0])
def test_a_course_is_as_the_forecast_has_it(field: WaveField, speed: float) -> None:
    """Waves of a thousandth of the power are left out, 0.03 σ rms; what is open is the elevation's share."""
    sea, lead, course = SeaPrediction.of(field), np.arange(0.0, 15.1, 0.25), Course(60.0, speed)
    mean, variance = sea.expected(lead, sea.transfers([course], shares_of(BOAT, Hull.of(BOAT), np.inf)))
    made = forecast(field, lead_s=lead, vessel=BOAT, heading_deg=60.0, speed_m_s=speed, draws=0)
    for number, name in enumerate(("heave", "roll", "pitch")):
        unit = 1.0 if name == "heave" else 180.0 / np.pi
        told, error = (made[each].values[0, :, 0] for each in (name, f"{name}_std"))
        assert np.sqrt(np.mean((unit * mean[0, number] - told) ** 2)) < 0.05 * np.std(told)
        stated = unit * np.sqrt(variance[0, number])
        assert np.sqrt(np.mean((stated - error) ** 2)) < 0.05 * np.std(told)
        # Of what is open itself the elevation's share is heave's to a twentieth, and angles' to a fifth.
        assert np.sqrt(np.mean((stated / error - 1.0) ** 2)) < (0.05 if name == "heave" else 0.2)


def test_advice_keeps_its_schema(field: WaveField) -> None:
    made = advise(field, BOAT, [0.0, 90.0], [2.0, 4.0], 15.0, limits={"roll": 5.0}, hold=(0.0, 4.0), draws=20)
    assert made["roll_rms"].dims == ("heading", "speed", "part")
    assert list(made["part"].values) == ["seen", "beyond"]
    names = ("heave", "roll", "pitch", "acceleration")
    wanted = {f"{name}_{kind}" for name in names for kind in ("rms", "p95")}
    wanted |= {f"{name}_probability" for name in ("exceedance", "slam", "green_water", "better")}
    wanted |= {"distance_made_good", "score", "difference", "difference_low", "difference_high"}
    assert set(made.data_vars) == wanted
    assert np.isnan(made["green_water_probability"]).all()  # a box states no freeboard
    assert np.isfinite(made.drop_vars("green_water_probability").to_array().values.astype(float)).all()
    assert made.attrs["issued"] == field.issued


def test_a_turn_waits_until_it_may_begin(field: WaveField) -> None:
    """Limits that always hold are called at once, limits that never do not at all; a turn through no degree is the
    forecast's own moment."""
    wide = turn_windows(field, BOAT, 0.0, 120.0, 3.0, {"roll": 80.0}, 12.0)
    assert wide.attrs["duration_s"] == 10.0
    assert float(countdown(wide)["lead"][0, 0]) == 0.0
    assert float(wide["lead"][-1]) == 20.0  # the last turn that ends in the half minute ahead
    never = turn_windows(field, BOAT, 0.0, 120.0, 3.0, {"roll": 1e-3}, 12.0)
    assert np.isnan(countdown(never)["lead"][0, 0])
    assert float(countdown(never)["probability"][0, 0]) == 0.0


@pytest.mark.parametrize(
    ("asked", "said"),
    [
        ({"headings": [np.nan]}, "headings: must be finite"),
        ({"speeds": [-1.0]}, "speeds = -1: must be at least 0"),
        ({"horizon_s": 0.0}, "horizon_s = 0: must be finite and at least"),
        ({"limits": {"yaw": 1.0}}, "limits: 'yaw' is not known"),
        ({"limits": {"roll": 0.0}}, "limits: roll = 0: must be finite and above 0"),
        ({"mission": "fastest"}, "mission = 'fastest': must be one of least_roll"),
        ({"mission": "most_way"}, "limits: is empty, and mission = 'most_way'"),
        ({"hold": (0.0, -1.0)}, "must be a heading"),
        ({"draws": 1}, "draws = 1: must be at least 2"),
    ],
)
def test_advice_that_cannot_be_asked_for(field: WaveField, asked: dict[str, Any], said: str) -> None:
    with pytest.raises(InputError, match=said):
        advise(field, BOAT, **asked)


def test_hulls_and_turns_that_cannot_be(field: WaveField) -> None:
    with pytest.raises(InputError, match="vessel = None: must be a vessel"):
        advise(field, None)  # type: ignore[arg-type]
    with pytest.raises(InputError, match=r"hull\.bow_m = 0: must be finite"):
        Hull(bow_m=0.0)
    with pytest.raises(InputError, match="the turn takes 180 s"):
        turn_windows(field, BOAT, 0.0, 180.0, 3.0, {"roll": 5.0}, 1.0)
    with pytest.raises(InputError, match="limits: 'yaw' is not known"):
        turn_windows(field, BOAT, 0.0, 90.0, 3.0, {"yaw": 5.0})
