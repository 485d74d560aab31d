"""Share of the waves' energy ↔ resolution: asked and told are inverse to each other, in settings, scenes and runs."""

from __future__ import annotations

import json
from pathlib import Path

import numpy as np
import pytest

from seamap_rt.cli import main
from seamap_rt.errors import InputError
from seamap_rt.scattering import ShortWaves
from seamap_rt.scene import load_scene
from seamap_rt.sea import realize, resolution, spectral_system
from seamap_rt.settings import (
    ElfouhailyWaves,
    FileWaves,
    FlatWaves,
    JonswapWaves,
    PiersonMoskowitzWaves,
    SeaSettings,
    SinusoidWaves,
    TmaWaves,
)

SPECTRA = Path(__file__).parents[1] / "io" / "spectra"
SWAN = FileWaves(spectrum="file", file=str(SPECTRA / "swan.spc"))
JONSWAP = JonswapWaves(spectrum="jonswap", significant_wave_height_m=1.4, peak_period_s=5.5)
ELFOUHAILY = ElfouhailyWaves(spectrum="elfouhaily", wind_speed_m_s=7.0)
CRESTED = JONSWAP.model_copy(update={"spreading": "long_crested", "peak_period_s": 4.0, "wave_from_deg": 20.0})
SEAS = {
    "pierson_moskowitz": (PiersonMoskowitzWaves(spectrum="pierson_moskowitz", wind_speed_m_s=7.0),),
    "jonswap": (JONSWAP,),
    "jonswap by fetch": (JonswapWaves(spectrum="jonswap", wind_speed_m_s=8.0, fetch_m=3e4),),
    "tma": (TmaWaves(spectrum="tma", significant_wave_height_m=1.0, peak_period_s=5.0),),
    "elfouhaily": (ELFOUHAILY,),
    "file": (SWAN,),
    "crested": (CRESTED,),
    "sum": (JONSWAP, FlatWaves(spectrum="flat"), ELFOUHAILY, SWAN, CRESTED),
}
SHARES = (0.6, 0.95, 0.99)


def asked(name, share, **changes):
    plain = {"energy_fraction": share, "extent_m": 250.0, "depth_m": 12.0, "waves": SEAS[name]}
    return SeaSettings.model_validate({**plain, **changes})


@pytest.mark.parametrize("name", SEAS)
def test_the_share_that_is_asked_for_is_the_share_that_is_told(name):
    spacings, shared = [], {"extent_m": 250.0, "depth_m": 12.0, "waves": SEAS[name]}
    for share in SHARES:
        by_share = realize(asked(name, share), 1).resolved
        spacing = by_share.resolution_m
        by_spacing = realize(SeaSettings.model_validate({**shared, "resolution_m": spacing}), 1).resolved
        # The root is found to 1e-6 of ln k; integrals are good to 1e-7 each.
        np.testing.assert_allclose(by_share.variance_share, share, rtol=3e-6)
        assert by_share == by_spacing
        np.testing.assert_allclose(by_share.wavenumber_limit, np.pi / spacing, rtol=1e-12)
        # The same integral again, in frequency's place a finer one in k.
        k = np.linspace(1e-4, np.pi / spacing, 100_001)
        systems = [spectral_system(waves, 12.0) for waves in SEAS[name] if waves.spectrum != "flat"]
        below = sum(np.trapezoid(system.radial(k), k) for system in systems)
        whole = sum(system.variance for system in systems)
        np.testing.assert_allclose(below / whole, share, rtol=1e-5)
        spacings.append(spacing)
    assert np.all(np.diff(spacings) < 0.0)


def test_a_share_does_not_depend_on_the_patch_or_on_heights():
    reference = resolution(asked("jonswap", 0.95))
    assert resolution(asked("jonswap", 0.95, extent_m=1000.0)) == reference
    higher = JONSWAP.model_copy(update={"significant_wave_height_m": 2.8})
    np.testing.assert_allclose(resolution(asked("jonswap", 0.95, waves=(higher,))), reference, rtol=1e-6)
    # In deep water lengths scale as periods squared, with ripples (3e-6 of ω²) left aside.
    slower = JONSWAP.model_copy(update={"peak_period_s": 11.0})
    deep = [resolution(asked("jonswap", 0.95, waves=(each,), depth_m=np.inf)) for each in (JONSWAP, slower)]
    np.testing.assert_allclose(deep[1] / deep[0], 4.0, rtol=1e-4)


def test_a_sea_without_random_waves_is_resolved_whatever_is_asked():
    regular = SinusoidWaves(spectrum="sinusoid", height_m=0.3, wavelength_m=3.0)
    for waves in ((), (FlatWaves(spectrum="flat"),), (regular,)):
        told = realize(SeaSettings(energy_fraction=0.9, extent_m=200.0, waves=waves), 1).resolved
        assert told.variance_share == 1.0


def test_a_regular_wave_counts_to_the_share_of_all_waves():
    """What is told is of all waves, and what is asked as well, as the settings say."""
    regular = SinusoidWaves(spectrum="sinusoid", height_m=1.0, wavelength_m=30.0)
    told = realize(asked("jonswap", 0.9, waves=(JONSWAP, regular)), 1).resolved
    np.testing.assert_allclose(told.variance_share, 0.9, rtol=1e-5)


@pytest.mark.parametrize("model", ["linear", "choppy"])
def test_both_models_resolve_the_same(model):
    told = realize(asked("jonswap", 0.95, model=model, depth_m=np.inf), 1).resolved
    np.testing.assert_allclose(told.variance_share, 0.95, rtol=3e-6)
    np.testing.assert_allclose(told.resolution_m, resolution(asked("jonswap", 0.95, depth_m=np.inf)), rtol=1e-12)


# ----------------------------------------------------------------------------------------------- scenes and runs


SCENE = """
name = "mine"
[sea]
extent_m = 512.0
{how}
[[sea.waves]]
spectrum = "jonswap"
significant_wave_height_m = 1.4
peak_period_s = 5.5
[radar]
sector_deg = [260.0, 275.0]
range_m = [15.0, 60.0]
"""


@pytest.fixture
def scene_with(tmp_path):
    def write(how):
        path = tmp_path / "mine.toml"
        path.write_text(SCENE.format(how=how), encoding="utf-8")
        return path

    return write


def test_an_override_takes_the_place_of_what_the_file_says(scene_with):
    by_spacing = scene_with("resolution_m = 1.5")
    assert load_scene(by_spacing).sea.resolution_m == 1.5
    sea = load_scene(by_spacing, {"sea.energy_fraction": 0.99}).sea
    assert (sea.resolution_m, sea.energy_fraction) == (None, 0.99)
    sea = load_scene(by_spacing, {"sea.energy_fraction": "0.97"}).sea  # as the command line hands it on
    assert (sea.resolution_m, sea.energy_fraction) == (None, 0.97)

    by_share = scene_with("energy_fraction = 0.98")
    assert load_scene(by_share).sea.resolution_m is None
    sea = load_scene(by_share, {"sea.resolution_m": 1.2}).sea
    assert (sea.resolution_m, sea.energy_fraction) == (1.2, None)

    neither = scene_with("")
    assert load_scene(neither).sea.resolution_m == 0.8
    assert load_scene(neither, {"sea.energy_fraction": 0.9}).sea.resolution_m is None


def test_an_override_reaches_a_shipped_scene_that_says_its_resolution():
    assert load_scene("choppy_sea").sea.resolution_m == 0.8
    sea = load_scene("choppy_sea", {"sea.energy_fraction": 0.99}).sea
    assert (sea.resolution_m, sea.energy_fraction) == (None, 0.99)


def test_taking_the_share_out_leaves_the_files_resolution(scene_with):
    """None takes a key out, also one that the file has not."""
    assert load_scene(scene_with("resolution_m = 1.5"), {"sea.energy_fraction": None}).sea.resolution_m == 1.5


def test_both_at_once_are_refused_in_one_line(scene_with):
    both = scene_with("resolution_m = 1.5\nenergy_fraction = 0.98")
    for path, overrides in (
        (both, {}),
        (scene_with("resolution_m = 1.5\nenergy_fraction = 0.98"), {"radar.height_m": 6.0}),
        ("tiny", {"sea.resolution_m": 1.0, "sea.energy_fraction": 0.9}),
    ):
        with pytest.raises(InputError, match="not both") as caught:
            load_scene(path, overrides)
        assert "\n" not in str(caught.value)


@pytest.mark.parametrize("share", [0.0, 1.0, -0.5, 99.0, float("nan")])
def test_what_is_no_share_is_refused_in_one_line(share):
    with pytest.raises(InputError, match=r"sea\.energy_fraction") as caught:
        load_scene("tiny", {"sea.energy_fraction": share})
    assert "\n" not in str(caught.value)


def test_a_scene_written_out_reads_back_with_its_share(scene_with, tmp_path):
    scene = load_scene(scene_with("energy_fraction = 0.98"))
    again = tmp_path / "again.toml"
    again.write_text(scene.to_toml(), encoding="utf-8")
    assert load_scene(again) == scene


@pytest.mark.usefixtures("no_pictures")
@pytest.mark.slow
def test_a_run_tells_the_share_that_was_asked_for(tmp_path, monkeypatch, capsys):
    monkeypatch.chdir(tmp_path)
    chosen = {
        "sea.energy_fraction": "0.99",
        "sea.extent_m": "180",
        "radar.sector_deg": "[260,275]",
        "radar.range_m": "[15,60]",
        "tracing.tracer": "horizon",
    }
    pairs = [part for key, value in chosen.items() for part in ("--set", f"{key}={value}")]
    with pytest.raises(SystemExit) as end:
        main(["run", "tiny", "--out", "results", *pairs])
    assert end.value.code == 0, capsys.readouterr().err
    metrics = json.loads(Path("results/metrics.json").read_text(encoding="utf-8"))
    sea, short = metrics["sea"], metrics["short_waves"]
    np.testing.assert_allclose(sea["variance_share"], 0.99, rtol=3e-6)
    scene = load_scene("results/scene.toml")
    assert scene.sea.energy_fraction == 0.99
    np.testing.assert_allclose(sea["resolution_m"], resolution(scene.sea), rtol=1e-9)
    # The short waves begin where the mesh's end, and hold what is left of the wind's slopes.
    expected = ShortWaves(scene.scattering.wind_speed_m_s, np.pi / sea["resolution_m"])
    np.testing.assert_allclose(short["wavenumber_from"], sea["wavenumber_limit"], rtol=1e-12)
    np.testing.assert_allclose(short["wavenumber_from"], expected.above, rtol=1e-12)
    np.testing.assert_allclose(short["variance"], expected.variance, rtol=1e-12)
    np.testing.assert_allclose(short["mean_square_slope"], expected.mean_square_slope, rtol=1e-12)
