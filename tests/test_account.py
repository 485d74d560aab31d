"""What a run says of itself: the account follows the scene's own keys, and its figures follow their laws."""

from __future__ import annotations

import math
from typing import Any

import numpy as np
import pytest
from scipy.special import erfc

from seamap_rt.account import account_lines, costed, left_out, modelled
from seamap_rt.account import light_errors as light
from seamap_rt.account import radar_errors as radar_of
from seamap_rt.account import sea_errors as sea_of
from seamap_rt.conventions import EARTH_RADIUS, GRAVITY, db
from seamap_rt.radar.digital import DigitalReceiver
from seamap_rt.radar.receiver import noise_power
from seamap_rt.scene import Scene, load_scene
from seamap_rt.sea import Resolved, realize

SMALL = {"sea.extent_m": 420.0, "sea.resolution_m": 2.0, "radar.range_m": [30.0, 150.0]}
ONE_WAVE = {"sea.waves": [{"spectrum": "sinusoid", "height_m": 1.0, "wavelength_m": 40.0, "wave_from_deg": 270.0}]}
NO_WAVES = {"sea.waves": [{"spectrum": "flat"}]}


def small(**keys: Any) -> tuple[Scene, Resolved]:
    """A small scene with other keys, and its sea."""
    scene = load_scene("tiny", SMALL | {key.replace("__", "."): value for key, value in keys.items()})
    return scene, realize(scene.sea, 1).resolved


def resolved_waves(**keys: Any) -> sea_of.ResolvedWaves:
    scene, resolved = small(**keys)
    return sea_of.resolved_waves(scene.sea, resolved.wavenumber_limit)


def account(**keys: Any) -> tuple[str, str]:
    """All that is said to be modelled, and to be left out, of a small scene with other keys."""
    said = (modelled(*small(**keys)), left_out(*small(**keys)))
    return tuple("; ".join(f"{row['what']}: {row['why']}" for row in rows) for rows in said)  # type: ignore[return-value]


def row(rows: list[dict[str, Any]], what: str) -> dict[str, Any]:
    return next(each for each in rows if each["what"] == what)


# ------------------------------------------------------------------------------------------------ the words


@pytest.mark.parametrize(
    ("keys", "done", "missing"),
    [
        ({}, "breakers, most of them where the resolved waves converge", "a breaker's life"),
        ({"scattering__breaking": False}, "strain of the resolved waves", "scattering.breaking = false"),
        ({"scattering__hydrodynamic_modulation": False}, "breakers", "tilt alone modulates"),
        ({"scattering__doppler": "orbital"}, "follows its water particle", "the scatterers' own velocity"),
        ({"scattering__calibrated_to": "none"}, "theory's own mean", "a breaker's life"),
        ({"scattering__calibrated_to": "tsc"}, "Technology Service Corporation 1990", "outside 0.1–90° grazing"),
        ({"scattering__nrcs": "hybrid"}, "the mean of Reilly & Dockery 1990", "tilt, strain and breakers"),
        ({"scattering__nrcs": "constant"}, "-40 dB per horizontal area", "tilt, strain and breakers"),
        ({}, "shadow ray", "tracing.diffraction = 'knife_edge'"),
        ({"tracing__diffraction": "knife_edge"}, "two knife edges", "what diffraction does to heights"),
        (
            {"scattering__extrapolate": True, "scattering__wind_speed_m_s": 20.0},
            "Gregers-Hansen",
            "this scene is sea state 10 at",
        ),
        ({}, "azimuth is time", "83 % of the circle is neither meshed nor traced"),
        ({"radar__scan": "staring"}, "staring for 50 ms", "it stands still for the 50 ms of a map"),
    ],
)
def test_the_account_follows_the_keys(keys: dict[str, Any], done: str, missing: str) -> None:
    was, was_not = account(**keys)
    assert done in was
    assert missing in was_not


def test_what_is_modelled_is_not_called_missing() -> None:
    _, default = account()
    for word in ("scattering.breaking = false", "own velocity", "tilt alone", "own range", "diffraction does"):
        assert word not in default
    _, diffracted = account(tracing__diffraction="knife_edge")
    assert "diffraction at shadow edges" not in diffracted
    _, whole = account(radar__sector_deg=[0.0, 360.0])
    assert "the rest of the circle" not in whole


RIDING = {"platform__motion": "wave_following", "platform__speed_m_s": 30.0, "turns": 4}
ROLLING = {"platform__motion": "sinusoidal", "platform__roll_deg": 10.0}


@pytest.mark.parametrize(
    "keys",
    [
        {},
        NO_WAVES,
        ONE_WAVE,
        RIDING,
        ROLLING,
        {"radar.baseline_m": 0.0},
        {"radar.scan": "staring", "radar.noise": False},
        {"radar.receiver.chain": "digital", "radar.receiver.gain": "agc"},
        {"radar.receiver.adc_rate_hz": 60e6},
        {"scattering.nrcs": "constant", "sea.model": "choppy"},
        {"scattering.breaking": False, "scattering.hydrodynamic_modulation": False, "scattering.doppler": "orbital"},
        {"sea.depth_m": 1.0, "scattering.extrapolate": True},
    ],
)
def test_every_row_has_its_error(keys: dict[str, Any]) -> None:
    scene_and_sea = small(**keys)
    for each in modelled(*scene_and_sea) + left_out(*scene_and_sea):
        assert each.keys() == {"what", "why", "error", "source"}
        assert each["error"]
        # A number has a formula or a measurement behind it.
        assert each["source"] or not any(letter.isdigit() for letter in each["error"])
        assert "nan" not in each["error"]


def test_without_waves_nothing_is_lost_by_leaving_the_sea_out() -> None:
    done, missing = modelled(*small(**NO_WAVES)), left_out(*small(**NO_WAVES))
    for rows, what in ((done, "sea"), (done, "scan"), (done, "mode"), (done, "waveform"), (missing, "sharper crests")):
        assert row(rows, what)["error"] == "nothing"
    assert row(done, "shadowing")["error"].startswith("0 %")


def test_the_pace_of_a_turn_decides_what_a_still_sea_costs() -> None:
    def cost(**keys: Any) -> float:
        return float(row(modelled(*small(**keys)), "scan")["error"].split()[0])

    assert cost(radar__rotation_rpm=120.0) < cost() < cost(radar__sector_deg=[0.0, 360.0])


# -------------------------------------------------------------------------------------------------- the sea


def test_waves_have_the_sea_s_variance_and_slope() -> None:
    scene, resolved = small()
    waves = sea_of.resolved_waves(scene.sea, resolved.wavenumber_limit)
    # The trapezoid rule over 4001 steps of ln k, and for slopes the lattice's own samples (1 % for so small a patch).
    assert waves.variance.sum() == pytest.approx(resolved.variance, rel=1e-4)
    assert np.sum(waves.variance * waves.wavenumber**2) == pytest.approx(resolved.mean_square_slope, rel=0.01)


def test_a_still_sea_errs_by_nothing_at_once_and_by_root_two_in_the_end() -> None:
    waves = resolved_waves()
    assert sea_of.still_sea_error(waves, 0.0) == 0.0
    # 1 − sinc is 1 to 2/(ωT), of waves with ω > 0.8 rad/s.
    limit = math.sqrt(2.0) * waves.elevation_std
    assert sea_of.still_sea_error(waves, 4000.0) == pytest.approx(limit, rel=1e-3)
    # To the first order it moves on by its vertical speed, the rms time from half-way being T/√12.
    speed = math.sqrt(float(np.sum(waves.variance * waves.frequency**2)))
    assert sea_of.still_sea_error(waves, 0.01) == pytest.approx(speed * 0.01 / math.sqrt(12.0), rel=1e-3)


def test_a_still_sea_errs_as_a_regular_wave_does() -> None:
    waves = resolved_waves(**ONE_WAVE)
    duration, omega = 3.0, math.sqrt(GRAVITY * 2.0 * math.pi / 40.0)
    time = (np.arange(2000) + 0.5) / 2000 * duration - 0.5 * duration
    phase = 2.0 * np.pi * np.arange(64)[:, None] / 64
    moved = 0.5 * (np.cos(phase - omega * time) - np.cos(phase))
    # Surface tension is not in ω here: 2e-6 of it.
    assert sea_of.still_sea_error(waves, duration) == pytest.approx(float(np.sqrt(np.mean(moved**2))), rel=1e-4)


def test_waves_on_a_current_as_fast_against_them_stand_still() -> None:
    speed = math.sqrt(GRAVITY * 40.0 / (2.0 * math.pi))  # 7.9 m/s towards the east, where the waves go
    waves = resolved_waves(**ONE_WAVE, sea__current_m_s=speed, sea__current_toward_deg=270.0)
    # What surface tension adds to the phase speed: 2e-6 of ω, 5e-5 rad over the time.
    assert sea_of.still_sea_error(waves, 20.0) < 1e-4 * waves.elevation_std


def test_half_the_water_s_speed_lies_along_the_look() -> None:
    waves = resolved_waves(**ONE_WAVE)
    omega = math.sqrt(GRAVITY * 2.0 * math.pi / 40.0)
    # aω/√2 along the waves, nothing across them; surface tension as above.
    assert sea_of.orbital_speed(waves) == pytest.approx(0.5 * omega / 2.0, rel=1e-5)


@pytest.mark.parametrize("phase", [0.01, 0.0999, 0.1001, 0.5, 2.0, math.pi])
def test_straight_lines_miss_what_interpolation_misses(phase: float) -> None:
    start = 2.0 * np.pi * np.arange(400)[:, None] / 400
    part = (np.arange(2000) + 0.5) / 2000
    line = (1.0 - part) * np.cos(start) + part * np.cos(start + phase)
    missed = 2.0 * np.mean((line - np.cos(start + part * phase)) ** 2)
    # The midpoint rule over 2000 parts; the series ends at 1e-7 of itself.
    assert sea_of.straight_line_error(np.array([phase]))[0] == pytest.approx(missed, rel=1e-5)


def test_a_mesh_errs_by_the_square_of_its_spacing() -> None:
    waves = resolved_waves(**ONE_WAVE)
    error = [sea_of.mesh_error(waves, step, step) for step in (0.5, 1.0, 2.0)]
    # The next term of the series is 0.2 % at 2 m.
    assert error[1] / error[0] == pytest.approx(4.0, rel=2e-3)
    assert error[2] / error[1] == pytest.approx(4.0, rel=5e-3)
    # cos⁴ and sin⁴ are 3/8 in the mean: σ (kd)² √(2 · 3/8/120).
    k = 2.0 * math.pi / 40.0
    assert error[0] == pytest.approx(waves.elevation_std * (0.5 * k) ** 2 * math.sqrt(0.75 / 120.0), rel=1e-3)


def test_slopes_are_lost_below_the_spacing_only() -> None:
    scene, resolved = small()
    waves = sea_of.resolved_waves(scene.sea, resolved.wavenumber_limit)
    assert sea_of.slopes_lost(waves, scene.sea.resolution_m or 0.0) == 0.0
    # All of them in the end, to the lattice's own samples.
    assert sea_of.slopes_lost(waves, 1e4) == pytest.approx(math.sqrt(0.5 * resolved.mean_square_slope), rel=0.01)


def test_second_order_waves_have_the_height_that_is_said() -> None:
    rng = np.random.default_rng(1)
    std, k = 0.3, 0.13
    elevation, transform = std * rng.standard_normal((2, 400_000))
    bound = 0.5 * k * (elevation**2 - transform**2)
    # Of so many draws the standard deviation is good to 0.3 %.
    assert sea_of.second_order_error(std, 4.0 * std * k / (2.0 * np.pi)) == pytest.approx(
        float(np.std(bound)), rel=0.01
    )


def test_a_small_boat_has_the_waves_slope_and_a_long_one_none() -> None:
    waves = resolved_waves()
    slope = math.sqrt(0.5 * float(np.sum(waves.variance * waves.wavenumber**2)))
    # 1 − p²/10 of the slope and 1 − q²/6 of the level, p and q below 0.08.
    assert sea_of.boat_tilt(waves, 0.1, 0.1) == pytest.approx(slope, rel=2e-3)
    tilts = [sea_of.boat_tilt(waves, length, 2.5) for length in (3.0, 7.0, 20.0, 100.0)]
    assert tilts == sorted(tilts, reverse=True)
    # Waves that run along a great raft have nothing left; those a metre long would not either.
    assert sea_of.boat_tilt(waves, 3000.0, 3000.0) < 1e-3 * slope


# ------------------------------------------------------------------------------------------- light and scattering


def test_shadows_grow_with_slope_and_fall_with_the_mast() -> None:
    low, high = (small(radar__height_m=height)[0].radar for height in (3.0, 10.0))
    assert light.shadowed_share(low, 0.0) == 0.0
    shares = [light.shadowed_share(low, variance) for variance in (1e-5, 1e-4, 1e-3, 1e-2)]
    assert shares == sorted(shares)
    assert shares[0] < 1e-3
    assert light.shadowed_share(high, 1e-2) < shares[-1] < 1.0
    assert light.shadows_of_short_waves(*small()) > 0.0


def test_waves_modulate_facets_and_breakers_raise_hh() -> None:
    rough = light.facing(*small())
    still = light.facing(*small(**NO_WAVES))
    assert rough.modulation_db > 2.0 * still.modulation_db > 0.0  # on a flat sea the wind's direction alone
    assert rough.weight.sum() == pytest.approx(1.0)
    horizontal = light.facing(*small(scattering__polarization="HH"))
    assert horizontal.breaking_db > rough.breaking_db > 0.0


def test_strain_modulates_by_its_power() -> None:
    # A change of N by exp(4.5 strain): e in 10/ln 10 dB.
    assert light.hydrodynamic_db(1.0 / 4.5) == pytest.approx(float(db(math.e)))
    waves = resolved_waves(**ONE_WAVE)
    # Without relaxation the strain is ak cos²: rms √(3/8) ak/√2.
    assert sea_of.strain_std(waves, 0.0) == pytest.approx(
        math.sqrt(0.375) * 0.5 * 2.0 * math.pi / 40.0 / math.sqrt(2.0)
    )
    assert sea_of.strain_std(waves, 100.0) < 0.02 * sea_of.strain_std(waves, 0.0)


def test_bragg_waves_of_x_band_run_at_23_cm_a_second() -> None:
    assert light.bragg_speed(10e9) == pytest.approx(0.231, abs=0.001)  # 15 mm long, near the slowest of all


def test_models_differ_and_see_the_wind() -> None:
    scene, _ = small()
    assert 0.5 < light.models_spread_db(scene) < 10.0
    assert light.wind_contrast_db(scene) > 0.0


def test_the_window_outside_a_model_is_counted_by_length() -> None:
    radar = small(radar__range_m=[20.0, 120.0], radar__height_m=10.0)[0].radar
    # 30° at 20 m, 14.478° at 40 m, 4.780° at 120 m: a fifth of the window is steeper, to one of 400 ranges.
    assert light.outside_share(radar, 0.1, math.degrees(math.asin(0.25))) == pytest.approx(0.2, abs=1.0 / 400.0)
    assert light.outside_share(radar, 0.1, 60.0) == 0.0


# ------------------------------------------------------------------------------------- radar, boat and Earth


def test_the_earth_falls_away_as_a_sphere() -> None:
    radius = 4.0 / 3.0 * EARTH_RADIUS
    for distance in (400.0, 20_000.0):
        # The plain difference loses 1e-9 m of 8.5e6 m to rounding.
        assert radar_of.drop_m(distance) == pytest.approx(math.hypot(radius, distance) - radius, abs=3e-9)
    assert radar_of.drop_m(800.0) == pytest.approx(4.0 * radar_of.drop_m(400.0), rel=1e-7)


def test_each_bit_takes_six_decibels_off_the_converter_s_noise() -> None:
    levels = [radar_of.quantisation_db(small(radar__receiver__adc_bits=bits)[0].radar, 1e-6) for bits in (8, 9, 12)]
    assert levels[0] - levels[1] == pytest.approx(20.0 * math.log10(2.0))
    assert levels[0] - levels[2] == pytest.approx(80.0 * math.log10(2.0))


@pytest.mark.parametrize("keys", [{}, {"radar.receiver.adc_bits": 8, "radar.bandwidth_hz": 30e6}])
def test_the_converter_s_noise_is_the_digital_receiver_s(keys: dict[str, Any]) -> None:
    radar = small(**keys, **{"radar.receiver.chain": "digital"})[0].radar
    full_scale = radar_of.full_scale_w(radar, 0.0)
    there = DigitalReceiver(radar).quantisation_noise_power(full_scale).mean() / noise_power(radar)
    # The receiver's weights are float32.
    assert radar_of.quantisation_db(radar, full_scale) == pytest.approx(float(db(there)), abs=1e-3)


def test_looks_reach_from_one_to_the_pulses() -> None:
    radar = small()[0].radar
    pulses = radar_of.link.dwell(radar).pulses
    assert radar_of.looks(radar, math.inf) == pytest.approx(1.0)
    assert radar_of.looks(radar, 1e-9) == pytest.approx(pulses)
    slow = small(radar__rotation_rpm=1.0)[0].radar
    # Over a dwell of 0.3 s speckle is new every ∫ ρ² dτ = τc √(π/2); the dwell's ends give another 0.3 %.
    expected = radar_of.link.dwell(slow).duration_s / (1e-3 * math.sqrt(0.5 * math.pi))
    assert radar_of.looks(slow, 1e-3) == pytest.approx(expected, rel=0.01)
    assert radar_of.speckle_db(1.0) == pytest.approx(float(db(2.0)))
    assert radar_of.speckle_db(1e6) < 0.005


def test_noise_costs_heights_by_the_bound() -> None:
    single = small(radar__transmit="single")[0].radar
    both = small(radar__interferogram="alternating_pulse", radar__prf_hz=20e3)[0].radar
    # As many pulses of each receiver, and twice the phase.
    ratio = radar_of.noise_height_error(single, 10.0, 100.0) / radar_of.noise_height_error(both, 10.0, 100.0)
    assert ratio == pytest.approx(2.0)
    # √2-fold noise for half the signal, where that is strong.
    weak, strong = (radar_of.noise_height_error(single, snr, 100.0) for snr in (1e4, 2e4))
    assert weak / strong == pytest.approx(math.sqrt(2.0), rel=1e-4)


def test_a_pattern_s_power_lies_where_its_integral_says() -> None:
    gaussian = radar_of.first_antenna(small(radar__antenna__pattern="gaussian")[0].radar)
    beam = gaussian.azimuth_beamwidth_deg
    # Of exp(−8 ln 2 (θ/b)²); a sum in steps of 1/200 of the beam.
    assert radar_of.share_beyond(gaussian, beam, 0.5) == pytest.approx(erfc(math.sqrt(2.0 * math.log(2.0))), rel=0.02)
    waveguide = radar_of.first_antenna(small()[0].radar)
    shares = [radar_of.share_beyond(waveguide, beam, beams) for beams in (0.0, 1.0, 3.0)]
    assert shares[0] > 0.99 > shares[1] > shares[2] > 0.0


def test_a_rolling_boat_tilts_by_half_its_amplitude_along_the_look() -> None:
    scene, _ = small(**ROLLING, turns=400)
    # Rms of a sine is 1/√2, and over all looks another 1/√2 of it lies along them; 100 whole periods.
    assert radar_of.boat_tilt_at_rest(scene) == pytest.approx(math.radians(5.0), rel=0.01)


def test_an_object_is_told_from_the_sea_of_its_cell() -> None:
    radar = small()[0].radar
    over = [radar_of.object_over_sea_db(radar, 20.0, level, 100.0) for level in (1e-4, 1e-3)]
    assert over[0] - over[1] == pytest.approx(10.0)
    # 100 m × 1.8° × 3 m is 9.4 m².
    assert over[0] == pytest.approx(20.0 + 40.0 - 10.0 * math.log10(100.0 * math.radians(1.8) * 2.998), abs=0.02)


# ---------------------------------------------------------------------------------------- costs, and the lines

TIMING = {"sea": 0.3, "mesh": 0.1, "trace": 0.2, "objects": 0.0, "echoes": 0.4, "total": 2.0, "retrieve": 0.5}


def test_costs_are_the_run_s_own_shares_of_a_turn() -> None:
    rows = costed(modelled(*small()), {"first": {"calibrate": 0.25, **TIMING}, "warm": TIMING})
    assert row(rows, "sea")["cost_s"] == pytest.approx(0.4)
    assert row(rows, "sea")["cost_share"] == pytest.approx(0.4)
    assert row(rows, "sea")["cost"] == "0.4 s, 40% of a turn"
    assert row(rows, "shadowing")["cost"] == "0.2 s, 20% of a turn"
    assert row(rows, "speckle")["cost"] == "within echoes, 0.4 s"
    assert row(rows, "boat")["cost"] == "within sea, 0.3 s"
    assert row(rows, "speckle")["cost_s"] is None


def test_a_finer_stopwatch_tells_more_apart() -> None:
    finer = TIMING | {"scattering": 0.1, "receive": 0.05}
    rows = costed(modelled(*small()), {"first": {"calibrate": 0.25, **finer}, "warm": finer})
    # Parts of the echoes' time, which count once in the whole.
    assert row(rows, "scattering")["cost"] == "0.1 s, 10% of a turn; 0.25 s once a run"
    assert row(rows, "receiver")["cost_share"] == pytest.approx(0.05)


def test_a_single_turn_is_called_the_first() -> None:
    rows = costed(modelled(*small()), {"first": TIMING, "warm": None})
    assert row(rows, "sea")["cost"] == "0.4 s, 40% of a turn, first turn"
    assert {each["cost"] for each in costed(rows, {"first": {}, "warm": None})} == {"not timed"}


def test_lines_name_every_part_within_their_limit() -> None:
    done, missing = costed(modelled(*small()), {"first": TIMING, "warm": None}), left_out(*small())
    for most in (5, 20, 100):
        lines = account_lines(done, missing, most)
        assert len(lines) == min(most, len(done) + len(missing))
        for each in done + missing:
            assert sum(each["what"] in line for line in lines) >= 1
        assert all(line.startswith(("modelled: ", "left out: ")) for line in lines)
    assert "modelled: sea (0.4 s, 40% of a turn, first turn; without it 0.3" in lines[0]
