"""A scene's keys are overridden as those of its file are."""

from __future__ import annotations

from typing import Any

import pytest

from seamap_rt.errors import InputError
from seamap_rt.scene import load_scene, with_keys

FILES = ["choppy_sea", "harbour", "pier", "magnetron_pair", "rough_ride"]


@pytest.mark.parametrize("name", FILES)
@pytest.mark.parametrize(
    "keys",
    [
        {},
        {"radar.height_m": 8.0, "seed": 3},
        {"sea.energy_fraction": 0.98},  # takes the place of a resolution, and the other way round
        {"sea.resolution_m": 1.5},
        {"sea.depth_m": "inf"},
    ],
)
def test_a_scene_and_its_file_are_overridden_alike(name: str, keys: dict[str, Any]) -> None:
    assert with_keys(load_scene(name), keys) == load_scene(name, keys)


def test_a_resolution_takes_the_place_of_an_energy_fraction() -> None:
    by_energy = load_scene("choppy_sea", {"sea.energy_fraction": 0.98})
    assert with_keys(by_energy, {"sea.resolution_m": 1.5}) == load_scene("choppy_sea", {"sea.resolution_m": 1.5})


@pytest.mark.parametrize(("key", "value"), [("radar.height_m", -1.0), ("radar.heigth_m", 3.0), ("sea.model", "x")])
def test_wrong_keys_are_refused_alike(key: str, value: Any) -> None:
    with pytest.raises(InputError) as of_file:
        load_scene("choppy_sea", {key: value})
    with pytest.raises(InputError) as of_scene:
        with_keys(load_scene("choppy_sea"), {key: value})
    assert str(of_scene.value) == str(of_file.value)
