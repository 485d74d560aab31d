"""What keeps a sea state from being known is named, and what is named as its remedy mends it."""

from __future__ import annotations

import re
from typing import Any

import numpy as np
import pytest
import xarray as xr

import seamap_rt as sr
from seamap_rt.dataset import QUALITY_FLAGS
from seamap_rt.wavefield.map_limits import hindrance
from seamap_rt.wavefield.sea_state import in_words

HEIGHT, POWER, TILT, RANGE = "radar.height_m", "radar.transmit_power_w", "radar.tilt_deg", "radar.range_m"
LIGHT, ECHO, BEAM = "too little of the sea in sight, shadow", "the echo lacks, not the light", "the beam ("
# Keys over `tiny` (5 m, 1 W, 5 to 150 m), and what the words begin with and name.
SCENES: dict[str, tuple[dict[str, Any], str, str]] = {
    "mast too high": ({HEIGHT: 22.0, POWER: 0.1}, ECHO, "radar.tilt_deg = 9"),
    "mast too high for the window": ({HEIGHT: 40.0}, "the map ends at 150 m", "radar.range_m"),
    "too little power": ({POWER: 1e-3}, ECHO, POWER),
    "beam over the sea": ({TILT: -40.0}, BEAM, "passes over"),
    "beam short of the sea": ({TILT: 40.0}, BEAM, "passes short of"),
    "calm sea": ({"scattering.nrcs": "constant", "scattering.nrcs_db": -75.0}, ECHO, POWER),
    "mast too low": ({HEIGHT: 0.6}, LIGHT, HEIGHT),
    "low mast, high waves": ({HEIGHT: 1.0, "sea.waves.0.significant_wave_height_m": 2.5}, LIGHT, HEIGHT),
    "window too short": ({RANGE: [5.0, 25.0]}, "the map ends at 2", "radar.range_m"),
    "echoes unlike": ({"radar.baseline_m": 6.0}, "the antennas' echoes are too little alike", "radar.baseline_m"),
}


def state_of(keys: dict[str, Any]) -> str:
    made = sr.load_scene("tiny", overrides={"tracing.tracer": "horizon", **keys})
    turn = next(iter(sr.iterate(made)))
    assert turn.maps is not None
    return in_words(sr.sea_state(turn.maps))


def remedied(keys: dict[str, Any], said: str) -> dict[str, Any]:
    """The keys as the words ask for them."""
    tilt, power, far, height = (
        re.search(pattern, said)
        for pattern in (r"tilt_deg = (-?\d+)", r"w by (\d+) dB", r"range_m to (\d+) m", r"height_m, as to ([\d.]+) m")
    )
    if tilt:
        return {**keys, TILT: float(tilt[1])}
    if power:
        return {**keys, POWER: keys.get(POWER, 1.0) * 10.0 ** (0.1 * float(power[1]))}
    if far:
        return {**keys, RANGE: [5.0, float(far[1])], "sea.extent_m": 4.0 * float(far[1])}
    if height:
        return {**keys, HEIGHT: float(height[1])}
    assert "shorten radar.baseline_m" in said
    return {**keys, "radar.baseline_m": 0.5 * keys["radar.baseline_m"]}


@pytest.mark.parametrize("name", SCENES)
@pytest.mark.slow
def test_what_hinders_is_named_and_its_remedy_mends_it(name: str) -> None:
    """Four steps: an echo that is not heard at all lacks nobody knows how much."""
    keys, begin, named = SCENES[name]
    said = state_of(keys)
    assert said.startswith("sea state unknown: ")
    assert begin in said
    assert named in said
    for _ in range(4):
        keys = remedied(keys, said)
        said = state_of(keys)
        if not said.startswith("sea state unknown"):
            break
    assert said.startswith("Hs ")


@pytest.mark.parametrize("flag", ["submerged", "saturated", "blind"])
def test_flags_that_lie_on_most_cells_are_the_cause(flag: str) -> None:
    quality = np.full((1, 20, 60), QUALITY_FLAGS[flag], np.int16)
    ranges = 3.0 * np.arange(1, 61)
    polar = xr.Dataset(
        {"quality": (("turn", "azimuth", "range"), quality)}, {"range": ranges}, {"height_m": 5.0}
    ).isel(turn=0)  # fmt: skip
    words = {"submerged": "height_m", "saturated": "full_scale_dbm", "blind": "pulse_width_s"}
    assert words[flag] in hindrance(polar)
