"""Scenes: the shipped ones load, and every check refuses in one line with a remedy that works."""

from __future__ import annotations

import math
import re
import tomllib
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from pydantic import BaseModel, ValidationError

from seamap_rt.conventions import SPEED_OF_LIGHT
from seamap_rt.errors import InputError
from seamap_rt.io.scenefile import list_shipped, read_toml
from seamap_rt.radar.antenna import antenna
from seamap_rt.scattering import MEAN_MODELS
from seamap_rt.scene import Scene, load_scene
from seamap_rt.settings import JonswapWaves, RadarSettings, SeaSettings, SensorSettings

SHIPPED = [
    "calm",
    "choppy_sea",
    "flat",
    "harbour",
    "long_crested_swell",
    "magnetron_pair",
    "pier",
    "rough_ride",
    "sinusoid",
    "solid_state_chirp",
    "tiny",
    "wide_baseline",
    "wind_and_swell",
]

_REFUSALS = Path(__file__).with_name("refusals.txt").read_text(encoding="utf-8").splitlines()
ROWS = [line for line in _REFUSALS if line and not line.startswith("#")]


def floats(value: object) -> list[str]:
    """Every float of a scene with all its bits, in order."""
    if isinstance(value, BaseModel):
        return [text for name in type(value).model_fields for text in floats(getattr(value, name))]
    if isinstance(value, tuple):
        return [text for entry in value for text in floats(entry)]
    return [value.hex()] if isinstance(value, float) else []


def refusal(overrides: dict[str, Any], name: str = "choppy_sea") -> str:
    with pytest.raises(InputError) as caught:
        load_scene(name, overrides)
    lines = caught.value.problems
    assert str(caught.value).splitlines() == list(lines)
    assert all(line.isprintable() for line in lines), lines
    assert not re.search("pydantic|Input should", lines[0])
    return lines[0]


# -------------------------------------------------------------------------------------------- shipped scenes


def test_the_shipped_scenes_are_those_of_the_manual() -> None:
    assert sorted(list_shipped()) == SHIPPED


@pytest.mark.parametrize("name", SHIPPED)
def test_a_shipped_scene_reads_back_to_the_same_bits(name: str, tmp_path: Path) -> None:
    scene = load_scene(name)
    assert scene.name == name
    assert scene.title
    file = tmp_path / "scene.toml"
    file.write_text(scene.to_toml(), encoding="utf-8")
    again = load_scene(file)
    assert again == scene
    assert floats(again) == floats(scene)
    assert len(floats(scene)) > 30
    assert again.to_toml() == scene.to_toml()


@pytest.mark.parametrize("name", SHIPPED)
def test_a_shipped_scene_has_one_key_per_line_and_says_what_it_shows(name: str) -> None:
    lines = list_shipped()[name].read_text(encoding="utf-8").splitlines()
    assert lines[0].startswith("# ")
    for line in lines:
        code = line.split("#")[0].strip()
        assert code == "" or re.fullmatch(r"\[\[?[a-z_.]+\]\]?|[a-z_0-9]+ = [^=]+", code), line


def test_choppy_sea_is_the_default_scene_and_leaves_little_out() -> None:
    scene = load_scene("choppy_sea")
    waves = JonswapWaves(
        spectrum="jonswap",
        significant_wave_height_m=1.4,
        peak_period_s=5.5,
        spreading="cos2s",
        spreading_exponent=10.0,
        wave_from_deg=270.0,
    )
    assert scene == Scene(name="choppy_sea", title=scene.title, sea=SeaSettings(waves=(waves,)))
    written = set(flat_keys(read_toml(list_shipped()["choppy_sea"])))
    left_out = set(flat_keys(tomllib.loads(scene.to_toml()))) - written
    swings = {f"platform.{name}" for motion in ("roll", "pitch", "yaw") for name in (f"{motion}_deg", *swing(motion))}
    assert left_out == {
        "sea.file",
        "sea.beyond",
        "scattering.nrcs_db",
        "retrieval.min_snr_db",
        "retrieval.ground_m",
        "retrieval.receivers",
        "radar.chirp_bandwidth_hz",
        "radar.compression_window",
        "radar.stare_s",
        "radar.antennas",
        "radar.antenna.guide_width_m",
        "radar.receiver.agc_headroom_db",
        "radar.receiver.stc_range_m",
        "objects",
        "gauges",
        *swings,
        "platform.heave_m",
        *(f"platform.{name}" for name in swing("heave")),
        *(f"platform.sensors.{name}" for name in SensorSettings.model_fields),
    }


def swing(motion: str) -> tuple[str, str]:
    return f"{motion}_period_s", f"{motion}_phase_deg"


def flat_keys(tree: dict[str, Any], prefix: str = "") -> list[str]:
    keys: list[str] = []
    for key, value in tree.items():
        if isinstance(value, dict):
            keys += flat_keys(value, f"{prefix}{key}.")
        else:
            keys.append(prefix + key)
    return keys


def test_wide_baseline_is_choppy_sea_but_for_its_baseline() -> None:
    choppy, wide = load_scene("choppy_sea"), load_scene("wide_baseline")
    assert wide.sea == choppy.sea
    assert wide.radar == choppy.radar.model_copy(update={"baseline_m": 0.9})


def test_the_sinusoid_is_a_thirtieth_of_its_length_high() -> None:
    (waves,) = load_scene("sinusoid").sea.waves
    assert waves.spectrum == "sinusoid"
    np.testing.assert_allclose(waves.height_m, waves.wavelength_m / 30.0, rtol=1e-15)


def test_a_scene_derives_its_plain_quantities() -> None:
    scene = load_scene("choppy_sea", {"radar.rotation_rpm": 48})
    np.testing.assert_allclose(scene.wavelength_m, 0.0299792458, rtol=1e-15)
    np.testing.assert_allclose(scene.turn_duration_s, 1.25, rtol=1e-15)
    np.testing.assert_allclose(math.hypot(scene.far_ground_range, 5.0), 400.0, rtol=1e-15)


def test_a_scene_is_frozen_and_hashable() -> None:
    scene = load_scene("tiny")
    with pytest.raises(InputError, match="seed: settings are not changed in place"):
        scene.seed = 2  # type: ignore[misc]
    assert hash(scene) == hash(load_scene("tiny"))


def test_overrides_are_part_of_the_resolved_scene(tmp_path: Path) -> None:
    scene = load_scene("tiny", {"radar.height_m": "10", "seed": np.int64(7), "sea.waves.0.peak_period_s": "6"})
    assert (scene.radar.height_m, scene.seed) == (10.0, 7)
    file = tmp_path / "again.toml"
    file.write_text(scene.to_toml(), encoding="utf-8")
    assert load_scene(file) == scene
    assert load_scene("tiny") != scene


# ---------------------------------------------------------------------------------------------------- limits


@pytest.mark.parametrize("row", ROWS)
def test_a_refusal_names_key_value_limit_and_remedy(row: str) -> None:
    given, _, words = row.partition(" → ")
    first, *others = words.split(" … ")
    line = refusal(dict(pair.split("=", 1) for pair in given.split("; ")))
    assert line.startswith(first), line
    assert all(each in line for each in others), line


@pytest.mark.parametrize(
    ("key", "value", "words"),
    [
        ("name", None, ["name: is missing", "text in quotes"]),
        ("radar.an\nother", "x\ny", ['radar."an\\u000aother" = "x\\u000ay": unknown key', "the keys here are"]),
        ("radar.height_m", 10**400, ["radar.height_m: an integer of 1329 bits", "64 bits"]),
        ("radar.transmit", "\udcff", ['radar.transmit = "\\udcff": is not valid Unicode', "UTF-8"]),
    ],
)
def test_what_python_alone_can_give_is_refused_as_well(key: str, value: Any, words: list[str]) -> None:
    line = refusal({key: value})
    assert line.startswith(words[0]), line
    assert words[1] in line


@pytest.mark.parametrize(
    ("refused", "remedy"),
    [
        ({"radar.range_m": [15.0, 900.0]}, {"sea.extent_m": 1860}),
        ({"radar.range_m": [15.0, 482.0], "sea.extent_m": 1000.0}, {"radar.range_m": [15.0, 470.0]}),
        ({"radar.antenna.azimuth_beamwidth_deg": 1.2}, {"radar.antenna.azimuth_beamwidth_deg": 1.522}),
        ({"radar.antenna.azimuth_beamwidth_deg": 1.2}, {"radar.antenna.width_m": 1.269}),
        ({"radar.range_sampling_m": 3.0}, {"radar.range_sampling_m": 2.997}),
        ({"retrieval.cell_azimuth_deg": 0.01}, {"retrieval.cell_azimuth_deg": 0.072}),
        ({"retrieval.cell_azimuth_deg": 0.01}, {"radar.prf_hz": 72000}),
        ({"retrieval.cell_azimuth_deg": 0.01}, {"radar.rotation_rpm": 8.333}),
        ({"tracing.facet_m": 0.02, "tracing.columns_per_beam": 4}, {"tracing.facet_m": 0.03339}),
        ({"tracing.facet_m": 0.02}, {"tracing.facet_m": 0.02504}),
        ({"scattering.nrcs": "nrl", "scattering.wind_speed_m_s": 20.0}, {"scattering.wind_speed_m_s": 13.24}),
        ({"scattering.nrcs": "git"}, {"radar.range_m": [28.8, 400.0]}),
    ],
)
def test_the_remedy_that_a_refusal_names_works(refused: dict[str, Any], remedy: dict[str, Any]) -> None:
    line = refusal(refused)
    last = next(iter(remedy.values()))
    assert re.search(rf"[ ,]{last[1] if isinstance(last, list) else last:g}", line)
    load_scene("choppy_sea", {**refused, **remedy})


@pytest.mark.parametrize(
    "beyond",
    [
        {"scattering.nrcs": "nrl", "scattering.wind_speed_m_s": 25.0},
        {"scattering.nrcs": "git"},
        {"scattering.nrcs": "git", "radar.range_m": [30.0, 400.0], "scattering.wind_speed_m_s": 20.0},
        {"radar.range_m": [15.0, 400.0], "radar.height_m": 0.6, "scattering.nrcs": "tsc"},
    ],
)
def test_extrapolation_is_there_for_the_asking(beyond: dict[str, Any]) -> None:
    assert refusal(beyond)
    assert load_scene("choppy_sea", beyond | {"scattering.extrapolate": True}).scattering.extrapolate


@pytest.mark.parametrize(("hs", "tp"), [(1.4, 5.5), (5.0, 10.0), (6.0, 11.0), (8.0, 12.0), (8.0, 14.0)])
@pytest.mark.parametrize("frequency", [9.3e9, 9.5e9, 35e9])
@pytest.mark.parametrize(("height", "wind"), [(5.0, 2.0), (15.0, 18.0), (30.0, 30.0)])  # up to 90° under a high mast
def test_no_model_s_limit_refuses_an_ordinary_sea_by_default(
    hs: float, tp: float, frequency: float, height: float, wind: float
) -> None:
    waves = {"sea.waves.0.significant_wave_height_m": hs, "sea.waves.0.peak_period_s": tp}
    radar = {"radar.frequency_hz": frequency, "radar.height_m": height, "scattering.wind_speed_m_s": wind}
    assert load_scene("choppy_sea", waves | radar).scattering.mean_model == "nrl"


@pytest.mark.parametrize("model", [*MEAN_MODELS, "none"])
@pytest.mark.parametrize("wind", [0.5, 8.0, 14.0, 18.0, 40.0])
def test_theory_takes_every_wind_whatever_model_sets_its_mean(model: str, wind: float) -> None:
    keys = {"scattering.calibrated_to": model, "scattering.wind_speed_m_s": wind, "radar.range_m": [30.0, 400.0]}
    assert load_scene("choppy_sea", keys).scattering.wind_speed_m_s == wind


def test_a_high_mast_or_a_far_gate_does_not_refuse_the_default_model() -> None:
    # Its edges lie where little is heard: steeper than 60° about the mast's foot, and below 0.1° beyond 2.9 km.
    for height, window in ((20.0, [15.0, 400.0]), (0.5, [15.0, 390.0])):
        scene = load_scene("choppy_sea", {"radar.height_m": height, "radar.range_m": window})
        assert scene.scattering.mean_model == "nrl"
        least, most = MEAN_MODELS["nrl"].grazing_deg
        steepest = math.degrees(math.asin(min(1.0, height / window[0])))
        assert steepest > most or math.degrees(math.asin(height / window[1])) < least  # it does lie beyond


@given(st.floats(0.1, 10.0), st.floats(0.1, 25.0), st.sampled_from([3e9, 10e9, 35e9]))
@settings(max_examples=25)
def test_the_width_that_a_narrow_beam_needs_satisfies_the_antenna_too(
    width: float, beam: float, frequency: float
) -> None:
    changes = {
        "radar.frequency_hz": frequency,
        "radar.antenna.width_m": width,
        "radar.antenna.azimuth_beamwidth_deg": beam,
        "radar.antenna.height_m": 0.1 * 10e9 / frequency,
        "tracing.facet_m": 20.0,
    }
    line = refusal_or_none(changes)
    if line is None:
        return
    remedy = re.match(r"radar.antenna.azimuth_beamwidth_deg = .*raise radar.antenna.width_m to (\S+)$", line)
    assert remedy, line
    needed = float(remedy[1])
    assert needed > width
    # The rule of thumb, 0.886 λ/width, takes the sine of half the beam for the angle: 2 % at 40°.
    np.testing.assert_allclose(needed, 0.886 * SPEED_OF_LIGHT / frequency / math.radians(beam), rtol=0.03)
    if needed <= 20.0:  # the widest that the settings allow
        radar = load_scene("flat", {**changes, "radar.antenna.width_m": needed}).radar
        antenna(radar)  # type: ignore[arg-type]  # raises if the beam is too narrow


def refusal_or_none(overrides: dict[str, Any]) -> str | None:
    try:
        load_scene("flat", overrides)
    except InputError as error:
        return str(error)
    return None


@pytest.mark.parametrize("pattern", ["gaussian", "isotropic"])
def test_only_a_slotted_waveguide_ties_the_beam_to_the_aperture(pattern: str) -> None:
    changes = {"radar.antenna.pattern": pattern, "radar.antenna.azimuth_beamwidth_deg": 1.2}
    assert load_scene("choppy_sea", changes).radar.antenna.pattern == pattern


@pytest.mark.parametrize("name", ["flat", "sinusoid", "long_crested_swell"])
def test_seas_that_do_not_repeat_need_no_patch_as_wide_as_the_range_circle(name: str) -> None:
    assert load_scene(name, {"sea.extent_m": 512.0}).sea.extent_m == 512.0


@pytest.mark.parametrize("name", ["choppy_sea", "calm"])
def test_the_range_circle_just_fits(name: str) -> None:
    assert load_scene(name, {"sea.extent_m": 860.0}).sea.extent_m == 860.0
    assert "at least 860" in refusal({"sea.extent_m": 859.99}, name)


def test_a_tilted_baseline_reaches_less_far_down() -> None:
    low = {"radar.height_m": 0.4, "radar.baseline_m": 0.9}
    assert "greater than 0.45" in refusal(low)
    assert load_scene("choppy_sea", {**low, "radar.tilt_deg": 60.0}).radar.tilt_deg == 60.0


def test_checks_hold_for_scenes_made_in_python_too() -> None:
    with pytest.raises(ValidationError, match=r"shorten radar\.baseline_m"):
        Scene(name="made", radar=RadarSettings(baseline_m=11.0))


# ----------------------------------------------------------------------------------------------- all in one go


def problems(*, name: str = "tiny", **overrides: Any) -> list[str]:
    """The keys that a refusal tells of, in its order."""
    with pytest.raises(InputError) as caught:
        load_scene(name, {key.replace("__", "."): value for key, value in overrides.items()})
    assert str(caught.value).splitlines() == list(caught.value.problems)
    return [re.split(r" = |: ", line)[0] for line in caught.value.problems]


def test_all_that_sections_disagree_in_is_told() -> None:
    told = problems(
        sea__waves__0__significant_wave_height_m=30.0,
        sea__extent_m=100.0,
        radar__range_sampling_m=4.0,
        radar__prf_hz=20.0,
    )
    assert told == [
        "sea.waves.0.significant_wave_height_m",
        "sea.extent_m",
        "radar.range_sampling_m",
        "retrieval.cell_azimuth_deg",
    ]


def test_wrong_keys_and_what_the_rest_disagrees_in_are_told_together() -> None:
    told = problems(radar__losses_db=-1.0, platform__speed=3.0, sea__extent_m=100.0)
    assert told == ["platform.speed", "radar.losses_db", "sea.extent_m"]


def test_a_check_that_needs_a_wrong_key_says_nothing_of_its_default() -> None:
    """The far end of the range is not known, so it is not said that the patch of sea is too small for it; nor is it
    where the key is misspelt."""
    assert problems(radar__range_m=[15.0, -400.0], sea__extent_m=100.0) == ["radar.range_m"]
    assert problems(radar__ranges_m=[15.0, 20.0], sea__extent_m=100.0) == ["radar.ranges_m"]


def test_what_follows_from_another_problem_is_not_told_again() -> None:
    (told,) = problems(radar__antenna__pattern="file", radar__antenna__file="none.csv")
    assert told == "radar.antenna.file"
    (told,) = problems(radar__antenna__azimuth_beamwidth_deg=0.2)
    assert told == "radar.antenna.azimuth_beamwidth_deg"


def test_single_problems_mended_one_by_one_are_those_told_at_once() -> None:
    """What is told together is what one meets one after the other, and nothing else: each mended, the rest stays."""
    wrong: dict[str, Any] = {
        "sea.waves.0.significant_wave_height_m": 30.0,
        "sea.extent_m": 100.0,
        "retrieval.receivers": [0, 5],
        "radar.prf_hz": 20.0,
        "retrieval.ground_m": -1.0,
    }
    at_once = problems(**{key.replace(".", "__"): value for key, value in wrong.items()})
    alone = [problems(**{key.replace(".", "__"): value}) for key, value in wrong.items()]
    assert sorted(at_once) == sorted(key for each in alone for key in each)


def test_each_entry_of_a_list_is_told_of() -> None:
    steep = {"spectrum": "jonswap", "significant_wave_height_m": 30.0, "peak_period_s": 5.5}
    told = problems(sea__waves=[steep, {**steep, "significant_wave_height_m": 1.0}, steep])
    assert told == [f"sea.waves.{number}.significant_wave_height_m" for number in (0, 2)]
