"""What a run says of itself: its rows follow the scene's own keys, and their numbers follow their laws."""

from __future__ import annotations

import math
import subprocess
import sys
from typing import Any

import numpy as np
import pytest
from scipy.special import erfc

from seamap_rt.conventions import EARTH_RADIUS, GRAVITY, db
from seamap_rt.radar import link
from seamap_rt.radar.digital import DigitalReceiver
from seamap_rt.radar.receiver import noise_power
from seamap_rt.report import limit_formulas as formulas
from seamap_rt.report.limits import account_lines, costed, left_out, modelled
from seamap_rt.scene import Scene, load_scene
from seamap_rt.sea import Resolved, realize

SMALL = {"sea.extent_m": 420.0, "sea.resolution_m": 2.0, "radar.range_m": [30.0, 150.0]}
ONE_WAVE = {"sea.waves": [{"spectrum": "sinusoid", "height_m": 1.0, "wavelength_m": 40.0, "wave_from_deg": 270.0}]}
NO_WAVES = {"sea.waves": [{"spectrum": "flat"}]}


def small(**keys: Any) -> tuple[Scene, Resolved]:
    """A small scene with other keys, and its sea."""
    scene = load_scene("tiny", SMALL | {key.replace("__", "."): value for key, value in keys.items()})
    return scene, realize(scene.sea, 1).resolved


def resolved_waves(**keys: Any) -> formulas.ResolvedWaves:
    scene, resolved = small(**keys)
    return formulas.resolved_waves(scene.sea, resolved.wavenumber_limit)


def account(**keys: Any) -> tuple[str, str]:
    """All that is said to be modelled, and to be left out, of a small scene with other keys."""
    tables = (modelled(*small(**keys)), left_out(*small(**keys)))
    return tuple("; ".join(f"{row['what']}: {row['why']}" for row in rows) for rows in tables)  # type: ignore[return-value]


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
        assert each.keys() == {"what", "why", "error", "value", "unit", "source"}
        assert each["error"]
        assert each["unit"]
        assert math.isfinite(each["value"])
        # A number has a formula or a measurement behind it.
        assert each["source"] or not any(letter.isdigit() for letter in each["error"])
        assert "nan" not in each["error"]


TURNED_OFF = {
    "scattering.breaking": False,
    "scattering.hydrodynamic_modulation": False,
    "scattering.doppler": "orbital",
    "tracing.diffraction": "knife_edge",
}
OTHER_SEA = {
    "sea.waves": [
        {
            "spectrum": "jonswap",
            "significant_wave_height_m": 0.5,
            "peak_period_s": 3.0,
            "wave_from_deg": 200.0,
            "spreading": "cos2s",
            "spreading_exponent": 4.0,
        }
    ],
    "sea.extent_m": 512.0,
    "sea.resolution_m": 1.0,
    "scattering.wind_speed_m_s": 5.0,
    "scattering.decorrelation_time_s": 0.004,
    "scattering.inverse_wave_age": 2.0,
}
OTHER_RADAR = {
    "radar.frequency_hz": 9.4e9,
    "radar.height_m": 10.0,
    "radar.baseline_m": 0.3,
    "radar.range_m": [18.0, 220.0],
    "radar.sector_deg": [0.0, 120.0],
    "radar.rotation_rpm": 24.0,
    "radar.stare_s": 0.03,
    "radar.pulse_width_s": 50e-9,
    "radar.bandwidth_hz": 20e6,
    "radar.prf_hz": 3e3,
    "radar.antenna.azimuth_beamwidth_deg": 1.2,
    "radar.antenna.width_m": 1.8,
    "radar.receiver.adc_bits": 10,
    "platform.length_m": 12.0,
}


@pytest.mark.parametrize(
    ("base", "keys"),
    [
        ("tiny", {}),
        ("harbour", {}),
        ("tiny", TURNED_OFF),
        ("tiny", {"radar.receiver.chain": "digital", "scattering.nrcs": "git", "scattering.extrapolate": True}),
        ("tiny", {"scattering.nrcs": "tsc", "sea.model": "choppy"}),
        ("tiny", {"radar.scan": "staring"}),
        ("tiny", {"platform.motion": "wave_following", "platform.speed_m_s": 3.0}),
    ],
)
def test_no_number_of_one_scene_is_printed_for_another(base: str, keys: dict[str, Any]) -> None:
    tables = []
    for others in ({"sea.extent_m": 512.0}, OTHER_SEA | OTHER_RADAR):
        scene = load_scene(base, others | keys)
        resolved = realize(scene.sea, 1).resolved
        tables.append({each["what"]: each for each in modelled(scene, resolved) + left_out(scene, resolved)})
    shared = tables[0].keys() & tables[1].keys()
    assert len(shared) >= 18
    for what in shared - {"echoes between objects and the sea"}:  # a bound that no scene changes
        first, second = (table[what] for table in tables)
        nothing = first["value"] == second["value"] == 0.0
        # Two digits are printed.
        assert nothing or first["value"] != pytest.approx(second["value"], rel=0.01, abs=0.0), (what, first["error"])


def test_a_row_that_cannot_be_worked_out_is_not_there() -> None:
    # Watts & Wicks measured below 10° grazing; here the middle of the window is seen under 19°.
    steep = small(radar__height_m=30.0)
    assert not any(each["what"] == "a breaker's life" for each in left_out(*steep))
    # 60 MS/s cannot hold the receiver's intermediate frequency and its band.
    slow = small(radar__receiver__adc_rate_hz=60e6)
    assert not any(each["what"] == "analogue-to-digital conversion" for each in left_out(*slow))
    level = small(radar__baseline_m=0.0)
    assert row(modelled(*level), "receiver")["unit"] == "rad"


def test_rows_are_made_without_matplotlib() -> None:
    code = "import sys, seamap_rt.report.limits; sys.exit('matplotlib' in sys.modules)"
    assert subprocess.run([sys.executable, "-c", code], check=False).returncode == 0


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
    waves = formulas.resolved_waves(scene.sea, resolved.wavenumber_limit)
    # The trapezoid rule over 4001 steps of ln k, and for slopes the lattice's own samples (1 % for so small a patch).
    assert waves.variance.sum() == pytest.approx(resolved.variance, rel=1e-4)
    assert np.sum(waves.variance * waves.wavenumber**2) == pytest.approx(resolved.mean_square_slope, rel=0.01)


def test_a_still_sea_errs_by_nothing_at_once_and_by_root_two_in_the_end() -> None:
    waves = resolved_waves()
    assert formulas.still_sea_error(waves, 0.0) == 0.0
    # 1 − sinc is 1 to 2/(ωT), of waves with ω > 0.8 rad/s.
    limit = math.sqrt(2.0) * waves.elevation_std
    assert formulas.still_sea_error(waves, 4000.0) == pytest.approx(limit, rel=1e-3)
    # To the first order it moves on by its vertical speed, the rms time from half-way being T/√12.
    speed = math.sqrt(float(np.sum(waves.variance * waves.frequency**2)))
    assert formulas.still_sea_error(waves, 0.01) == pytest.approx(speed * 0.01 / math.sqrt(12.0), rel=1e-3)


def test_a_still_sea_errs_as_a_regular_wave_does() -> None:
    waves = resolved_waves(**ONE_WAVE)
    duration, omega = 3.0, math.sqrt(GRAVITY * 2.0 * math.pi / 40.0)
    time = (np.arange(2000) + 0.5) / 2000 * duration - 0.5 * duration
    phase = 2.0 * np.pi * np.arange(64)[:, None] / 64
    moved = 0.5 * (np.cos(phase - omega * time) - np.cos(phase))
    # Surface tension is not in ω here: 2e-6 of it.
    assert formulas.still_sea_error(waves, duration) == pytest.approx(float(np.sqrt(np.mean(moved**2))), rel=1e-4)


def test_waves_on_a_current_as_fast_against_them_stand_still() -> None:
    speed = math.sqrt(GRAVITY * 40.0 / (2.0 * math.pi))  # 7.9 m/s towards the east, where the waves go
    waves = resolved_waves(**ONE_WAVE, sea__current_m_s=speed, sea__current_toward_deg=270.0)
    # What surface tension adds to the phase speed: 2e-6 of ω, 5e-5 rad over the time.
    assert formulas.still_sea_error(waves, 20.0) < 1e-4 * waves.elevation_std


def test_half_the_water_s_speed_lies_along_the_look() -> None:
    waves = resolved_waves(**ONE_WAVE)
    omega = math.sqrt(GRAVITY * 2.0 * math.pi / 40.0)
    # aω/√2 along the waves, nothing across them; surface tension as above.
    assert formulas.orbital_speed(waves) == pytest.approx(0.5 * omega / 2.0, rel=1e-5)


def test_slopes_are_lost_below_the_spacing_only() -> None:
    scene, resolved = small()
    waves = formulas.resolved_waves(scene.sea, resolved.wavenumber_limit)
    assert formulas.slopes_lost(waves, scene.sea.resolution_m or 0.0) == 0.0
    # All of them in the end, to the lattice's own samples.
    assert formulas.slopes_lost(waves, 1e4) == pytest.approx(math.sqrt(0.5 * resolved.mean_square_slope), rel=0.01)


def test_second_order_waves_have_the_height_that_is_said() -> None:
    rng = np.random.default_rng(1)
    std, k = 0.3, 0.13
    elevation, transform = std * rng.standard_normal((2, 400_000))
    bound = 0.5 * k * (elevation**2 - transform**2)
    # Of so many draws the standard deviation is good to 0.3 %.
    assert formulas.second_order_error(std, 4.0 * std * k / (2.0 * np.pi)) == pytest.approx(
        float(np.std(bound)), rel=0.01
    )


def test_a_small_boat_has_the_waves_slope_and_a_long_one_none() -> None:
    waves = resolved_waves()
    slope = math.sqrt(0.5 * float(np.sum(waves.variance * waves.wavenumber**2)))
    # 1 − p²/10 of the slope and 1 − q²/6 of the level, p and q below 0.08.
    assert formulas.boat_tilt(waves, 0.1, 0.1) == pytest.approx(slope, rel=2e-3)
    tilts = [formulas.boat_tilt(waves, length, 2.5) for length in (3.0, 7.0, 20.0, 100.0)]
    assert tilts == sorted(tilts, reverse=True)
    # Waves that run along a great raft have nothing left; those a metre long would not either.
    assert formulas.boat_tilt(waves, 3000.0, 3000.0) < 1e-3 * slope


# ------------------------------------------------------------------------------------------- light and scattering


def test_shadows_grow_with_slope_and_fall_with_the_mast() -> None:
    low, high = (small(radar__height_m=height)[0].radar for height in (3.0, 10.0))
    assert formulas.shadowed_share(low, 0.0) == 0.0
    shares = [formulas.shadowed_share(low, variance) for variance in (1e-5, 1e-4, 1e-3, 1e-2)]
    assert shares == sorted(shares)
    assert shares[0] < 1e-3
    assert formulas.shadowed_share(high, 1e-2) < shares[-1] < 1.0
    assert formulas.shadows_of_short_waves(*small()) > 0.0


def test_waves_modulate_facets_and_breakers_raise_hh() -> None:
    rough = formulas.facing(*small())
    still = formulas.facing(*small(**NO_WAVES))
    assert rough.modulation_db > 2.0 * still.modulation_db > 0.0  # on a flat sea the wind's direction alone
    assert rough.weight.sum() == pytest.approx(1.0)
    horizontal = formulas.facing(*small(scattering__polarization="HH"))
    assert horizontal.breaking_db > rough.breaking_db > 0.0


def test_strain_modulates_by_its_power() -> None:
    # A change of N by exp(4.5 strain): e in 10/ln 10 dB.
    assert formulas.hydrodynamic_db(1.0 / 4.5) == pytest.approx(float(db(math.e)))
    waves = resolved_waves(**ONE_WAVE)
    # Without relaxation the strain is ak cos²: rms √(3/8) ak/√2.
    assert formulas.strain_std(waves, 0.0) == pytest.approx(
        math.sqrt(0.375) * 0.5 * 2.0 * math.pi / 40.0 / math.sqrt(2.0)
    )
    assert formulas.strain_std(waves, 100.0) < 0.02 * formulas.strain_std(waves, 0.0)


def test_bragg_waves_of_x_band_run_at_23_cm_a_second() -> None:
    assert formulas.bragg_speed(10e9) == pytest.approx(0.231, abs=0.001)  # 15 mm long, near the slowest of all


def test_models_differ_and_see_the_wind() -> None:
    scene, _ = small()
    assert 0.5 < formulas.models_spread_db(scene) < 10.0
    assert formulas.wind_contrast_db(scene) > 0.0


def test_the_window_outside_a_model_is_counted_by_length() -> None:
    radar = small(radar__range_m=[20.0, 120.0], radar__height_m=10.0)[0].radar
    # 30° at 20 m, 14.478° at 40 m, 4.780° at 120 m: a fifth of the window is steeper, to one of 400 ranges.
    assert formulas.outside_share(radar, 0.1, math.degrees(math.asin(0.25))) == pytest.approx(0.2, abs=1.0 / 400.0)
    assert formulas.outside_share(radar, 0.1, 60.0) == 0.0


# ------------------------------------------------------------------------------------- radar, boat and Earth


def test_the_earth_falls_away_as_a_sphere() -> None:
    radius = 4.0 / 3.0 * EARTH_RADIUS
    for distance in (400.0, 20_000.0):
        # The plain difference loses 1e-9 m of 8.5e6 m to rounding.
        assert formulas.drop_m(distance) == pytest.approx(math.hypot(radius, distance) - radius, abs=3e-9)
    assert formulas.drop_m(800.0) == pytest.approx(4.0 * formulas.drop_m(400.0), rel=1e-7)


def test_each_bit_takes_six_decibels_off_the_converter_s_noise() -> None:
    levels = [formulas.quantisation_db(small(radar__receiver__adc_bits=bits)[0].radar, 1e-6) for bits in (8, 9, 12)]
    assert levels[0] - levels[1] == pytest.approx(20.0 * math.log10(2.0))
    assert levels[0] - levels[2] == pytest.approx(80.0 * math.log10(2.0))


@pytest.mark.parametrize("keys", [{}, {"radar.receiver.adc_bits": 8, "radar.bandwidth_hz": 30e6}])
def test_the_converter_s_noise_is_the_digital_receiver_s(keys: dict[str, Any]) -> None:
    radar = small(**keys, **{"radar.receiver.chain": "digital"})[0].radar
    full_scale = formulas.full_scale_w(radar, 0.0)
    there = DigitalReceiver(radar).quantisation_noise_power(full_scale).mean() / noise_power(radar)
    # The receiver's weights are float32.
    assert formulas.quantisation_db(radar, full_scale) == pytest.approx(float(db(there)), abs=1e-3)


def test_looks_reach_from_one_to_the_pulses() -> None:
    radar = small()[0].radar
    pulses = link.dwell(radar).pulses
    assert formulas.looks(radar, math.inf) == pytest.approx(1.0)
    assert formulas.looks(radar, 1e-9) == pytest.approx(pulses)
    slow = small(radar__rotation_rpm=1.0)[0].radar
    # Over a dwell of 0.3 s speckle is new every ∫ ρ² dτ = τc √(π/2); the dwell's ends give another 0.3 %.
    expected = link.dwell(slow).duration_s / (1e-3 * math.sqrt(0.5 * math.pi))
    assert formulas.looks(slow, 1e-3) == pytest.approx(expected, rel=0.01)
    assert formulas.speckle_db(1.0) == pytest.approx(float(db(2.0)))
    assert formulas.speckle_db(1e6) < 0.005


def test_noise_costs_heights_by_the_bound() -> None:
    single = small(radar__transmit="single")[0].radar
    both = small(radar__interferogram="alternating_pulse", radar__prf_hz=20e3)[0].radar
    # As many pulses of each receiver, and twice the phase.
    ratio = formulas.noise_height_error(single, 10.0, 100.0) / formulas.noise_height_error(both, 10.0, 100.0)
    assert ratio == pytest.approx(2.0)
    # √2-fold noise for half the signal, where that is strong.
    weak, strong = (formulas.noise_height_error(single, snr, 100.0) for snr in (1e4, 2e4))
    assert weak / strong == pytest.approx(math.sqrt(2.0), rel=1e-4)


def test_a_pattern_s_power_lies_where_its_integral_says() -> None:
    gaussian = formulas.first_antenna(small(radar__antenna__pattern="gaussian")[0].radar)
    beam = gaussian.azimuth_beamwidth_deg
    # Of exp(−8 ln 2 (θ/b)²); a sum in steps of 1/200 of the beam.
    assert formulas.share_beyond(gaussian, beam, 0.5) == pytest.approx(erfc(math.sqrt(2.0 * math.log(2.0))), rel=0.02)
    waveguide = formulas.first_antenna(small()[0].radar)
    shares = [formulas.share_beyond(waveguide, beam, beams) for beams in (0.0, 1.0, 3.0)]
    assert shares[0] > 0.99 > shares[1] > shares[2] > 0.0


def test_a_rolling_boat_tilts_by_half_its_amplitude_along_the_look() -> None:
    scene, _ = small(**ROLLING, turns=400)
    # Rms of a sine is 1/√2, and over all looks another 1/√2 of it lies along them; 100 whole periods.
    assert formulas.boat_tilt_at_rest(scene) == pytest.approx(math.radians(5.0), rel=0.01)


def test_an_edge_fades_where_its_detour_is_a_quarter_wave() -> None:
    before, beyond, wavelength = 200.0, 25.0, 0.03
    height = formulas.edge_blur_m(wavelength, before, beyond)
    detour = math.hypot(before, height) + math.hypot(beyond, height) - before - beyond
    # v²λ/4 at v = 1; the detour's next order is (height/beyond)²/4 of it.
    assert detour == pytest.approx(0.25 * wavelength, rel=2e-4)
    assert formulas.edge_blur_m(wavelength, before, 0.0) == 0.0


@pytest.mark.parametrize("mean_square_slope", [1e-4, 0.02, 0.5])
def test_a_second_bounce_has_what_the_surface_s_area_takes(mean_square_slope: float) -> None:
    part = (np.arange(200_000) + 0.5) / 200_000
    square = -mean_square_slope * np.log(1.0 - part)  # of Gaussian slopes in two directions
    area = float(np.mean(np.sqrt(1.0 + square)))
    # The midpoint rule loses 3e-6 of the mean square slope at the end of the distribution.
    assert formulas.second_bounce_share(mean_square_slope) == pytest.approx(1.0 - 1.0 / area, rel=1e-4)
    assert formulas.second_bounce_share(0.0) == 0.0


def test_clutter_is_spikier_in_hh_and_in_small_cells() -> None:
    radar, wide = small()[0].radar, small(radar__antenna__azimuth_beamwidth_deg=3.6)[0].radar
    shape = formulas.clutter_shape(radar, "VV", 100.0)
    assert shape / formulas.clutter_shape(radar, "HH", 100.0) == pytest.approx(10.0**0.7)
    # By 5/8 of the power of the area, of beams as wide as their patterns come out.
    area = float(link.cell_area(wide, 100.0) / link.cell_area(radar, 100.0))
    assert formulas.clutter_shape(wide, "VV", 100.0) / shape == pytest.approx(area**0.625)
    # ψ = 2.866°, 9.42 m²: 2/3 log 2.866 + 5/8 log 9.42 − 1 = −0.0862.
    assert shape == pytest.approx(10.0**-0.0862, rel=2e-3)
    assert math.isnan(formulas.clutter_shape(radar, "VV", 20.0))


def test_an_object_is_told_from_the_sea_of_its_cell() -> None:
    radar = small()[0].radar
    over = [formulas.object_over_sea_db(radar, 20.0, level, 100.0) for level in (1e-4, 1e-3)]
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
