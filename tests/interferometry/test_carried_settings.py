"""Echoes carry their scene's retrieval settings, from memory and from files, and `retrieve` goes by them."""

from __future__ import annotations

import math
from pathlib import Path
from typing import Any

import numpy as np
import pytest
import xarray as xr

import seamap_rt as sr
from seamap_rt.interferometry import open_echoes
from seamap_rt.interferometry.checks import settings_of
from seamap_rt.io.growing_store import GrowingStore
from seamap_rt.settings import RetrievalSettings

OTHERS: dict[str, dict[str, Any]] = {
    "cell_range_m": {"cell_range_m": 6.0},
    "cell_azimuth_deg": {"cell_azimuth_deg": 3.6},
    "estimator": {"estimator": "single_cell"},
    "window_range_m": {"window_range_m": 9.0},
    "window_azimuth_deg": {"window_azimuth_deg": 5.4},
    "paths": {"paths": "one_way"},
    "ambiguity": {"ambiguity": "fold"},
    "crest_bias": {"crest_bias": "remove"},
    "diffraction_mrad": {"diffraction_mrad": 1.0},
    "coherent_s": {"coherent_s": 0.002},
    "channels": {"channels": "from_cross_paths"},
    "channel_gain_db": {"channel_gain_db": 0.5},
    "channel_phase_deg": {"channel_phase_deg": 10.0},
    "map_time_s": {"map_time_s": 0.5},
    "depth_m": {"depth_m": math.inf},
    "current_m_s": {"current_m_s": 1.0, "current_toward_deg": 90.0},
    "current_toward_deg": {"current_m_s": 0.5, "current_toward_deg": 10.0},
    "pulse_pairs": {"pulse_pairs": "forward"},
    "receivers": {"receivers": (1, 0)},
    "min_snr_db": {"min_snr_db": 3.0},
    "ground_m": {"ground_m": 6.0},
}


def scatterers(**keys: Any) -> tuple[sr.Scene, xr.Dataset]:
    """A scene with keys of its retrieval replaced, and echoes of points on a ramp of 1 in 100 across its range."""
    changed = {f"retrieval.{key}": list(value) if isinstance(value, tuple) else value for key, value in keys.items()}
    scene = sr.load_scene("tiny", changed | {"radar.range_m": [30.0, 90.0], "radar.sector_deg": [0.0, 6.0]})
    distance, azimuth = np.meshgrid(np.arange(25.0, 95.0, 2.0), np.radians(np.arange(-2.0, 9.0, 1.0)))
    x, y = distance * np.sin(azimuth), distance * np.cos(azimuth)
    points = np.stack((x.ravel(), y.ravel(), 0.01 * distance.ravel()), axis=-1)
    return scene, sr.echoes.from_scatterers(scene, points, np.full(len(points), 10.0))


def stored(echoes: xr.Dataset, folder: Path) -> xr.Dataset:
    with GrowingStore(folder / "run.zarr", ("turn", "pulse")) as store:
        store.append({"echoes": echoes})
    return open_echoes(folder)


@pytest.mark.parametrize("key", RetrievalSettings.model_fields)
def test_every_key_is_carried_in_memory_and_on_file(key: str, tmp_path: Path) -> None:
    scene, echoes = scatterers(**OTHERS[key])
    assert getattr(scene.retrieval, key) != RetrievalSettings.model_fields[key].default
    for source in (echoes, stored(echoes, tmp_path)):
        assert settings_of(source) == scene.resolved_retrieval


def test_what_a_chart_says_is_carried_too() -> None:
    scene = sr.load_scene("tiny", {"sea.depth_m": 20.0, "sea.current_m_s": 0.5, "sea.current_toward_deg": 30.0})
    settings = settings_of(sr.echoes.from_scatterers(scene, [[0.0, 60.0, 0.0]], [10.0]))
    assert (settings.depth_m, settings.current_m_s, settings.current_toward_deg) == (20.0, 0.5, 30.0)


def test_a_retrieval_goes_by_what_is_given_else_by_what_is_carried_else_by_the_defaults() -> None:
    scene, echoes = scatterers(estimator="single_cell", cell_range_m=6.0, diffraction_mrad=0.5)
    carried = sr.retrieve(echoes)
    xr.testing.assert_identical(carried, sr.retrieve(echoes, scene.resolved_retrieval))
    assert (
        carried["polar"].attrs["retrieval"]
        == '{"cell_range_m": 6.0, "estimator": "single_cell", "diffraction_mrad": 0.5}'
    )
    finer = sr.retrieve(echoes, {"cell_range_m": 3.0})["polar"]
    assert finer.attrs["retrieval"] == '{"estimator": "single_cell", "diffraction_mrad": 0.5}'
    assert not finer.to_dataset()["height"].equals(carried["polar"].to_dataset()["height"])
    bare = echoes.drop_attrs().assign_attrs({name: v for name, v in echoes.attrs.items() if name != "retrieval"})
    for all_default in (sr.retrieve(bare), sr.retrieve(echoes, RetrievalSettings())):
        assert all_default["polar"].attrs["retrieval"] == "{}"


@pytest.mark.parametrize("wrong", ["[", "3", '"x"', '{"cell_range_m": -1.0}', '{"of_another_version": 1}', 5, None])
def test_settings_that_cannot_be_read_are_refused_in_a_line(wrong: Any) -> None:
    echoes = xr.Dataset(attrs={"retrieval": wrong})
    with pytest.raises(sr.SchemaError, match=r"^echoes: attribute 'retrieval': [^\n]+; give all settings, or remove"):
        settings_of(echoes)
    assert settings_of(echoes, RetrievalSettings()) == RetrievalSettings()


def test_keys_that_are_given_and_wrong_are_refused() -> None:
    with pytest.raises(sr.InputError, match="cell_rnge_m"):
        settings_of(xr.Dataset(), {"cell_rnge_m": 3.0})
    with pytest.raises(sr.InputError, match=r"settings: is a str, must be RetrievalSettings, as scene.retrieval, or"):
        settings_of(xr.Dataset(), "single_cell")  # type: ignore[arg-type]
