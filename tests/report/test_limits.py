"""What a run says of itself: its rows follow the scene's own keys, and their numbers follow their laws."""

from __future__ import annotations

import inspect
import math
import re
import subprocess
import sys
from typing import Any, NamedTuple

import numpy as np
import pytest

from seamap_rt.conventions import radar_wavelength, radar_wavenumber
from seamap_rt.radar import link
from seamap_rt.radar.waveform import RangeResponse
from seamap_rt.report import limits
from seamap_rt.report import modelled as modelled_rows
from seamap_rt.report.limits import account_lines, costed, modelled, not_modelled
from seamap_rt.report.modelled import Case
from seamap_rt.scattering.short_waves import ShortWaves
from seamap_rt.scene import Scene, load_scene
from seamap_rt.sea import ResolvedSea, realize
from validation import ROOT
from validation.analytic.diffraction import knife_edge


class Limit(NamedTuple):
    """A row of the table of limits. Some have no words in README; some no rows in a run's account, for no single run
    tells their errors."""

    name: str
    left_out: str
    error: str
    where: str
    readme: str
    account: str


_ROWS = re.findall(r"^\|(.*)\|$", (ROOT / "validation/models/limits.md").read_text("utf-8"), flags=re.MULTILINE)[2:]
LIMITS = [Limit(*map(str.strip, line.split("|"))) for line in _ROWS]
BEGINNINGS = {each.name: tuple(each.account.split("; ")) for each in LIMITS if each.account}

SMALL = {"sea.extent_m": 420.0, "sea.resolution_m": 2.0, "radar.range_m": [30.0, 150.0]}
ONE_WAVE = {"sea.waves": [{"spectrum": "sinusoid", "height_m": 1.0, "wavelength_m": 40.0, "wave_from_deg": 270.0}]}
NO_WAVES = {"sea.waves": [{"spectrum": "flat"}]}


def small(**keys: Any) -> tuple[Scene, ResolvedSea]:
    """A small scene with other keys, and its sea."""
    scene = load_scene("tiny", SMALL | {key.replace("__", "."): value for key, value in keys.items()})
    return scene, realize(scene.sea, 1).resolved


def account(**keys: Any) -> tuple[str, str]:
    """All that is said to be modelled, and to be left out, of a small scene with other keys."""
    said, not_said = (
        "; ".join(f"{row['what']}: {row['why']}" for row in rows(*small(**keys))) for rows in (modelled, not_modelled)
    )
    return said, not_said


def row(rows: list[dict[str, Any]], what: str) -> dict[str, Any]:
    return next(each for each in rows if each["what"] == what)


# ------------------------------------------------------------------------------------------------ the words


@pytest.mark.parametrize(
    ("keys", "done", "missing"),
    [
        ({}, "breakers, most of them where the resolved waves converge", "a breaker's life"),
        ({"scattering__sea_spikes": True}, "a Poisson process of breakers", "shadows of waves that are not resolved"),
        ({"scattering__polarization": "HH"}, "a Poisson process of breakers", "shadows of waves that are not resolved"),
        ({"scattering__texture": True}, "lognormal patches", "shadows of waves that are not resolved"),
        ({}, "breakers", "scattering.texture = true has patches"),
        ({"scattering__breaking": False}, "strain of the resolved waves", "scattering.breaking = false"),
        ({"scattering__hydrodynamic_modulation": False}, "breakers", "tilt alone modulates"),
        ({"scattering__doppler": "orbital"}, "follows its water particle", "the scatterers' own velocity"),
        ({"scattering__calibrated_to": "none"}, "theory's own mean", "Earth curvature"),
        ({"scattering__calibrated_to": "tsc"}, "Technology Service Corporation 1990", "outside 0.1–90° grazing"),
        ({"scattering__nrcs": "hybrid"}, "the mean of Reilly & Dockery 1990", "tilt, strain and breakers"),
        ({"scattering__nrcs": "constant"}, "-40 dB per horizontal area", "tilt, strain and breakers"),
        ({"tracing__diffraction": "none"}, "shadow ray", "tracing.diffraction = 'knife_edge'"),
        (
            {"radar__transmitter": "magnetron", "radar__frequency_jitter_hz": 1e5},
            "heights come from single pulses, and there are no velocities",
            "a magnetron's jitter within a pulse",
        ),
        (
            {"radar__transmitter": "magnetron", "radar__coherent_on_receive": True, "radar__transmit": "single"},
            "taken off to 3° rms; its carrier strays by 0 kHz rms; heights do not use it",
            "Earth curvature",
        ),
        ({}, "two knife edges", "what diffraction does to heights"),
        (
            {"scattering__extrapolate": True, "scattering__wind_speed_m_s": 20.0},
            "Gregers-Hansen",
            "this scene is sea state 10 at",
        ),
        (
            {"scattering__wind_speed_m_s": 18.0},
            "Gregers-Hansen",
            "the clutter model beyond 13.2 m/s, where theory goes on",
        ),
        ({}, "mean over azimuth calibrated to Gregers-Hansen", "Earth curvature"),
        ({"scattering__nrcs": "nrl"}, "the mean of Gregers-Hansen", "wind-direction contrast of the mean echo"),
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
    for word in ("scattering.breaking = false", "own velocity", "tilt alone", "own range", "diffraction beside"):
        assert word not in default
    for word in ("contrast of the mean", "theory goes on"):
        assert word not in default
    spiky, without = account(scattering__polarization="HH")
    assert "sea spikes" in spiky
    assert "a breaker's life" not in without
    assert "sea spikes" not in account(scattering__polarization="HH", scattering__breaking=False)[0]
    assert "diffraction at shadow edges" not in default
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
    for each in not_modelled(*scene_and_sea):
        assert len([name for name, words in BEGINNINGS.items() if each["what"].startswith(words)]) == 1
    for each in modelled(*scene_and_sea) + not_modelled(*scene_and_sea):
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
        tables.append({each["what"]: each for each in modelled(scene, resolved) + not_modelled(scene, resolved)})
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
    assert not any(each["what"] == "a breaker's life" for each in not_modelled(*steep))
    # 60 MS/s cannot hold the receiver's intermediate frequency and its band.
    slow = small(radar__receiver__adc_rate_hz=60e6)
    assert not any(each["what"] == "analogue-to-digital conversion" for each in not_modelled(*slow))
    level = small(radar__baseline_m=0.0)
    assert row(modelled(*level), "receiver")["unit"] == "rad"


def test_rows_are_made_without_matplotlib() -> None:
    code = "import sys, seamap_rt.report.limits; sys.exit('matplotlib' in sys.modules)"
    assert subprocess.run([sys.executable, "-c", code], check=False).returncode == 0


def test_without_waves_nothing_is_lost_by_leaving_the_sea_out() -> None:
    done, missing = modelled(*small(**NO_WAVES)), not_modelled(*small(**NO_WAVES))
    for rows, what in ((done, "sea"), (done, "scan"), (done, "mode"), (done, "waveform"), (missing, "sharper crests")):
        assert row(rows, what)["error"] == "nothing"
    assert row(done, "shadowing")["error"].startswith("0 %")


def test_short_waves_hide_more_of_the_window() -> None:
    assert row(not_modelled(*small()), "shadows of waves that are not resolved")["value"] > 0.0


def test_unresolved_waves_hide_by_half_of_their_tilts_along_the_look() -> None:
    """Light's measure; what is left out is less by what bends into the shadows, by the judge's own knife edge."""
    for polarization, power in (("VV", 1), ("HH", 2)):
        scene, resolved = small(scattering__polarization=polarization)
        short = ShortWaves.of(scene.scattering, resolved.wavenumber_limit)
        divide = short.divide(radar_wavenumber(scene.radar.frequency_hz))
        along_wind, across_wind = short.tilt_variances(divide)
        looks = np.arange(16) * (2.0 * np.pi / 16)
        tilts = float(np.mean(along_wind * np.cos(looks) ** 2 + across_wind * np.sin(looks) ** 2))
        slopes = resolved.look_slope_variance
        more = link.shadowed_share(scene.radar, slopes + tilts) - link.shadowed_share(scene.radar, slopes)
        height = math.sqrt(short.variance - short.roughness_variance(divide))
        v = math.sqrt(2.0 * height * math.sqrt(tilts) / scene.wavelength_m)
        kept = (2.0 * abs(knife_edge(v))) ** (4 * power)
        found = row(not_modelled(scene, resolved), "shadows of waves that are not resolved")["value"]
        assert found == pytest.approx(100.0 * more * (1.0 - kept), rel=1e-9)
        assert 0.02 < kept < 0.6


def test_shadows_of_unresolved_waves_are_told_with_their_time_where_they_are_cast() -> None:
    """Leaving waves' shadows out costs the same whether they are cast or not; light's hide more, and what they hide
    too much is then what is left out."""
    plain, waves, light = small(), *(small(tracing__unresolved_shadowing=each) for each in ("fresnel", "smith"))
    name = "shadowing by waves that are not resolved"
    done = costed(modelled(*waves), {"first": {**TIMING, "shade": 0.01}, "warm": None})
    missing = row(not_modelled(*plain), "shadows of waves that are not resolved")
    assert row(done, name)["value"] == missing["value"]
    assert row(done, name)["cost_s"] == 0.01
    assert not [each for each in modelled(*plain) if each["what"] == name]
    for cast in (waves, light):
        assert not [each for each in not_modelled(*cast) if each["what"] == missing["what"]]
    too_much = row(not_modelled(*light), "diffraction at shadows of waves that are not resolved")["value"]
    assert row(modelled(*light), name)["value"] == pytest.approx(missing["value"] + too_much)


def test_waves_run_faster_by_half_of_their_steepness_squared() -> None:
    """Stokes: one wave of amplitude a by ½ (ka)²."""
    steep = row(not_modelled(*small(**ONE_WAVE)), "waves that run faster where they are steep")["value"]
    assert steep == pytest.approx(100.0 * 0.5 * (2.0 * np.pi / 40.0 * 0.5) ** 2, rel=0.01)


@pytest.mark.parametrize("allowed", [0.005, 0.01])
def test_what_is_missed_between_nodes_costs_a_tenth_of_the_height_error(allowed: float) -> None:
    scene, resolved = small(**{"tracing.height_error_m": allowed})
    share = (0.1 * allowed / resolved.elevation_std) ** 2
    assert 1e-6 < share < 1e-4  # neither of the limits
    found = row(not_modelled(scene, resolved), "pulses between slow-time nodes")
    assert found["value"] == pytest.approx(0.1 * allowed)
    assert f"{10.0 * np.log10(share):.2g} dB" in found["why"]
    going_on = row(not_modelled(scene, resolved), "how speckle goes on in its weakest modes")
    assert going_on["value"] == pytest.approx(min(0.1 * allowed, 1e-3 * resolved.elevation_std))


def test_sea_spikes_cost_is_of_the_scattering() -> None:
    rows = costed(
        modelled(*small(scattering__sea_spikes=True)), {"first": {**TIMING, "scattering": 0.25}, "warm": None}
    )
    assert row(rows, "sea spikes")["cost"] == "within scattering, 0.25 s, first turn"


def test_shadows_of_higher_waves_are_darker() -> None:
    """Beyond 1.6 m a third and more of the power bends into them, beyond 8 m next to nothing."""
    share = [Case(*small(sea__resolution_m=spacing)).shadow_power for spacing in (0.4, 0.8, 4.0)]
    assert 0.6 > share[0] > share[1] > 0.3
    assert share[2] < 0.1


def test_a_phase_read_with_the_other_mode_s_paths_is_off_by_the_height_or_half_of_it() -> None:
    # z ∝ φ/p: phases of p = 1 read with 2 give half the height, those of p = 2 read with 1 twice the height.
    for keys, share in (({}, 0.5), ({"radar__interferogram": "alternating_pulse", "radar__transmit": "switched"}, 1.0)):
        scene, resolved = small(**keys)
        assert row(modelled(scene, resolved), "mode")["value"] == pytest.approx(share * resolved.elevation_std)


def test_all_heights_within_a_gate_are_those_of_a_plane() -> None:
    # Even places over a length L have the variance L²/12; half of the slopes' square lies along the look.
    scene, resolved = small()
    cell = RangeResponse.of(scene.radar).resolution_m
    expected = math.sqrt(resolved.look_slope_variance * cell**2 / 12.0)
    assert row(modelled(scene, resolved), "waveform")["value"] == pytest.approx(expected, rel=1e-9)


def test_the_pace_of_a_turn_decides_what_a_still_sea_costs() -> None:
    def cost(**keys: Any) -> float:
        return float(row(modelled(*small(**keys)), "scan")["error"].split()[0])

    assert cost(radar__rotation_rpm=120.0) < cost() < cost(radar__sector_deg=[0.0, 360.0])


def test_the_short_list_of_limits_tells_of_those_of_the_table_and_of_no_other() -> None:
    text = (ROOT / "README.md").read_text("utf-8").split("\n## What it does not do\n")[1].split("\n## ")[0]
    entries, words = re.split(r"\n\d+\. ", text)[1:], [each.readme for each in LIMITS if each.readme]
    assert [each for each in words if not any(each in entry for entry in entries)] == []
    assert [entry for entry in entries if not any(each in entry for each in words)] == []


def test_a_limit_has_its_error_and_names_no_row_that_is_gone() -> None:
    text = inspect.getsource(limits) + inspect.getsource(modelled_rows)
    assert [name for words in BEGINNINGS.values() for name in words if f'"{name}' not in text] == []
    assert all(each.left_out and each.error for each in LIMITS)
    assert all(each.account for each in LIMITS if each.error == "by the account")


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
    done, missing = costed(modelled(*small()), {"first": TIMING, "warm": None}), not_modelled(*small())
    for most in (5, 20, 100):
        lines = account_lines(done, missing, most)
        assert len(lines) == min(most, len(done) + len(missing))
        for each in done + missing:
            assert sum(each["what"] in line for line in lines) >= 1
        assert all(line.startswith(("modelled: ", "left out: ")) for line in lines)
    assert "modelled: sea (0.4 s, 40% of a turn, first turn; without it 0.3" in lines[0]


def test_what_a_magnetron_costs_is_said() -> None:
    """Its carrier h δ/f over the pulses of a dwell; its measured phases √(2/N) of their error, in heights."""
    magnetron = {"radar__transmitter": "magnetron", "radar__frequency_jitter_hz": 1e5}
    scene, resolved = small(**magnetron)
    pulses = link.dwell(scene.radar).pulses
    found = row(modelled(scene, resolved), "magnetron")["value"]
    assert found == pytest.approx(scene.radar.height_m * 1e-5 / math.sqrt(pulses))
    assert "p = 2 from neighbouring" not in row(modelled(scene, resolved), "mode")["why"]
    spread_s = 2.0 * RangeResponse.of(scene.radar).spread_m / 299_792_458.0
    lost = row(not_modelled(scene, resolved), "a magnetron's jitter within a pulse")["value"]
    assert lost == pytest.approx((2.0 * math.pi * 1e5 * spread_s) ** 2)
    measured = {**magnetron, "radar__coherent_on_receive": True, "radar__transmit_phase_error_deg": 6.0}
    for mode, share in (("single_pulse", 0.5), ("alternating_pulse", 0.5)):  # of pulses, and of a radian's height
        scene, resolved = small(**measured, radar__interferogram=mode)
        assert "p = 2" in row(modelled(scene, resolved), "mode")["why"]
        middle = link.middle_m(scene.radar)
        radian = radar_wavelength(scene.radar.frequency_hz) * middle / (2.0 * math.pi * 2.0 * scene.radar.baseline_m)
        law = math.radians(6.0) * math.sqrt(2.0 / (share * pulses)) * radian
        assert row(modelled(scene, resolved), "magnetron")["value"] == pytest.approx(law, rel=0.02)
    scene, resolved = small(**measured, radar__transmit="single")
    kept = row(modelled(scene, resolved), "magnetron")
    assert (kept["value"], kept["unit"]) == (pytest.approx(1.0 - math.exp(-(math.radians(6.0) ** 2))), "1")
    assert not [each for each in modelled(*small()) if each["what"] == "magnetron"]
