"""Seas at the ends of what may be asked: finite numbers, or one line that names value, limit and remedy."""

from __future__ import annotations

import re
from pathlib import Path
from typing import Any

import numpy as np
import pytest
import xarray as xr

from seamap_rt.cli import main
from seamap_rt.errors import InputError
from seamap_rt.io.validation import validate
from seamap_rt.sea import realize, spectral_system, wave_facts
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
HALF_DAY = 12.0 * 3600.0


def jonswap(**changes):
    return JonswapWaves(**{"spectrum": "jonswap", "significant_wave_height_m": 1.4, "peak_period_s": 5.5, **changes})


def tma(**changes):
    return TmaWaves(**{"spectrum": "tma", "significant_wave_height_m": 1.0, "peak_period_s": 5.5, **changes})


def elfouhaily(wind, **changes):
    return ElfouhailyWaves(**{"spectrum": "elfouhaily", "wind_speed_m_s": wind, **changes})


def pierson_moskowitz(wind):
    return PiersonMoskowitzWaves(spectrum="pierson_moskowitz", wind_speed_m_s=wind)


def sea_of(*waves, **changes):
    return SeaSettings(**{"resolution_m": 2.0, "extent_m": 256.0, "waves": waves, **changes})


def one_line(error: BaseException, *words: str) -> str:
    """The message, which is one line, of an exception that is ours, and holds the words."""
    text = str(error)
    assert isinstance(error, ValueError)
    assert "\n" not in text.strip()
    assert len(text) < 400
    for word in words:
        assert word in text, text
    return text


# ------------------------------------------------------------------------------------------------ what must be finite


FINITE = {
    "0.5 m of water": sea_of(jonswap(significant_wave_height_m=0.1), depth_m=0.5),
    "0.5 m of water, tma": sea_of(tma(significant_wave_height_m=0.1), depth_m=0.5),
    "the shallowest": sea_of(tma(significant_wave_height_m=0.01, peak_period_s=20.0), depth_m=0.05),
    "10 km of water": sea_of(jonswap(), depth_m=1e4),
    "a period of 1 s": sea_of(
        jonswap(significant_wave_height_m=0.05, peak_period_s=1.0), resolution_m=0.25, extent_m=40.0
    ),
    "a period of 25 s": sea_of(jonswap(peak_period_s=25.0), resolution_m=20.0, extent_m=5000.0),
    "no height": sea_of(jonswap(significant_wave_height_m=0.0)),
    "no height, tma": sea_of(tma(significant_wave_height_m=0.0), depth_m=3.0),
    "15 m high": sea_of(jonswap(significant_wave_height_m=15.0, peak_period_s=17.0), resolution_m=8.0, extent_m=2000.0),
    "300 by 0.7": sea_of(jonswap(), resolution_m=0.7, extent_m=300.0),
    "257 by 1.3": sea_of(jonswap(), resolution_m=1.3, extent_m=257.0),
    "eight points a side": sea_of(jonswap(peak_period_s=8.0), resolution_m=32.0),
    "two alike": sea_of(jonswap(), jonswap()),
    "no enhancement": sea_of(jonswap(peak_enhancement=1.0)),
    "the most enhancement": sea_of(jonswap(peak_enhancement=20.0)),
    "an inverse age of 1": sea_of(elfouhaily(7.0, inverse_wave_age=1.0)),
    "the oldest sea": sea_of(elfouhaily(7.0, inverse_wave_age=0.8)),
    "the youngest sea": sea_of(elfouhaily(10.0, inverse_wave_age=5.0), resolution_m=0.5),
    "no wind to speak of": sea_of(elfouhaily(0.5), resolution_m=0.04, extent_m=10.0),
    "a storm": sea_of(elfouhaily(40.0), resolution_m=20.0, extent_m=5000.0),
    "pierson_moskowitz, 0.5 m/s": sea_of(pierson_moskowitz(0.5), resolution_m=0.04, extent_m=10.0),
    "pierson_moskowitz, 40 m/s": sea_of(pierson_moskowitz(40.0), resolution_m=20.0, extent_m=5000.0),
    "file in shallow water": sea_of(FileWaves(spectrum="file", file=str(SPECTRA / "swan.spc")), depth_m=1.0),
    "half of the energy": SeaSettings(energy_fraction=0.5, extent_m=256.0, waves=(jonswap(),)),
    "flat, choppy, current": sea_of(FlatWaves(spectrum="flat"), model="choppy", current_m_s=2.0),
    "choppy, current, shallow": sea_of(
        jonswap(significant_wave_height_m=0.6), model="choppy", depth_m=6.0, current_m_s=10.0, current_toward_deg=-90.0
    ),
    "sharp": sea_of(jonswap(spreading_exponent=500.0)),
    "even": sea_of(jonswap(spreading_exponent=1e-6)),
    "crested, off the axes": sea_of(jonswap(spreading="long_crested", wave_from_deg=-360.0)),
}


@pytest.mark.parametrize("name", FINITE)
def test_all_that_may_be_asked_gives_finite_numbers(name):
    asked = FINITE[name]
    sea = realize(asked, 1)
    x, y = np.random.default_rng(1).uniform(-2e3, 2e3, (2, 40))
    for t in (0.0, -3600.0, HALF_DAY):
        elevation, slopes, velocity = sea.elevation_slopes_and_velocity(x, y, t)
        for values in (elevation, slopes, velocity, sea.elevation_rate(x, y, t)):
            assert np.all(np.isfinite(values))
        # A surface within six standard deviations of what is told, with a factor for one seed's own variance.
        assert np.abs(elevation).max() <= 8.0 * sea.resolved.elevation_std
        assert sea.folded(x, y, t).dtype == bool
    assert np.all(np.isfinite(sea.spectrum.variance_density))
    facts = {key: value for key, value in sea.spectrum.attrs.items() if key != "time_step"}
    assert np.all(np.isfinite(list(facts.values())))
    assert 0.0 < sea.resolved.variance_share <= 1.0 + 1e-6
    for waves in asked.waves:
        told = wave_facts(waves, asked.depth_m)
        if told is not None:
            assert np.all(np.isfinite([told.height, told.peak_period, told.from_deg]))
            assert told.peak_period > 0.0


def test_no_enhancement_is_pierson_moskowitz_and_an_age_of_1_meets_its_neighbour():
    k = np.geomspace(1e-2, 1e2, 200)
    scaled = PiersonMoskowitzWaves(spectrum="pierson_moskowitz", significant_wave_height_m=1.4, peak_period_s=5.5)
    plain, enhanced = (spectral_system(waves, np.inf).radial(k) for waves in (scaled, jonswap(peak_enhancement=1.0)))
    np.testing.assert_allclose(plain, enhanced, rtol=1e-12)
    at, below = (spectral_system(elfouhaily(8.0, inverse_wave_age=age), np.inf).radial(k) for age in (1.0, 1.0 - 1e-9))
    # γ = 1.7 up to an age of 1, and 1.7 + 6 log of it from there: nothing jumps. Far below the peak
    # the cut-off magnifies the 2e-9 in kp.
    np.testing.assert_allclose(at, below, rtol=1e-5)


def test_two_alike_hold_twice_the_variance_and_are_not_the_same_waves():
    one, two = realize(sea_of(jonswap()), 1), realize(sea_of(jonswap(), jonswap()), 1)
    np.testing.assert_allclose(two.resolved.variance, 2.0 * one.resolved.variance, rtol=1e-12)
    np.testing.assert_allclose(two.spectrum.variance_density, 2.0 * one.spectrum.variance_density, rtol=1e-12)
    # √2 of one realisation has its phases; independent draws correlate by 1/√2 with the sum.
    a, b = one.components().amplitude, two.components().amplitude
    correlation = np.abs(np.vdot(a, b)) / np.sqrt(np.sum(np.abs(a) ** 2) * np.sum(np.abs(b) ** 2))
    assert abs(correlation - np.sqrt(0.5)) < 0.2  # of some 50 waves that carry the energy


def test_height_and_period_do_not_change_with_what_else_is_asked():
    for hs, tp in ((0.05, 1.0), (15.0, 25.0)):
        facts = wave_facts(jonswap(significant_wave_height_m=hs, peak_period_s=tp), np.inf)
        assert facts is not None
        np.testing.assert_allclose([facts.height, facts.peak_period], [hs, tp], rtol=1e-3)


@pytest.mark.parametrize("depth", [2.0, 5.0, 20.0])
def test_peak_period_is_that_of_the_frequency_spectrum_in_any_depth(depth):
    waves = PiersonMoskowitzWaves(spectrum="pierson_moskowitz", significant_wave_height_m=0.3, peak_period_s=5.5)
    facts = wave_facts(waves, depth)
    assert facts is not None
    np.testing.assert_allclose(facts.peak_period, 5.5, rtol=2e-3)  # a grid of 1e-3 in k


# --------------------------------------------------------------------------------------------------- what is refused


@pytest.mark.parametrize(
    ("changes", "words"),
    [
        ({"resolution_m": 0.002, "extent_m": 1024.0}, ("512000", "4096", "GB", "raise resolution_m")),
        ({"resolution_m": 50.0}, ("5.1", "at least 8", "lower resolution_m")),
        ({"resolution_m": 1.0, "energy_fraction": 0.9}, ("resolution_m or energy_fraction, not both",)),
        ({"depth_m": 0.0}, ("at least 0.05",)),
        ({"extent_m": 5.0}, ("at least 10",)),
        ({"current_m_s": 11.0}, ("at most 10",)),
        ({"model": "nonlinear"}, ("linear",)),
    ],
)
def test_settings_that_are_refused_say_why_in_one_line(changes, words):
    with pytest.raises(InputError) as caught:
        validate(SeaSettings, {"extent_m": 256.0, **changes})
    one_line(caught.value, *words)


@pytest.mark.parametrize(
    ("settings", "words"),
    [
        (SeaSettings(energy_fraction=0.999999, extent_m=1024.0, waves=(jonswap(),)), ("0.999999", "4096", "GB")),
        (SeaSettings(energy_fraction=0.001, extent_m=64.0, waves=(jonswap(),)), ("energy_fraction = 0.001", "raise")),
        (sea_of(jonswap(peak_period_s=25.0)), ("extent_m = 256", "at least 50%", "raise extent_m")),
        (sea_of(elfouhaily(40.0)), ("extent_m = 256", "raise extent_m")),
        (sea_of(elfouhaily(20.0, fetch_m=500.0)), ("fetch_m = 500", "at most 5", "raise fetch_m")),
        (
            sea_of(jonswap(significant_wave_height_m=4.0, peak_period_s=4.0), model="choppy", resolution_m=0.5),
            ("choppy", "fold over", "lower the waves", "linear"),
        ),
        (sea_of(jonswap(significant_wave_height_m=15.0, peak_period_s=5.0), model="choppy"), ("choppy", "linear")),
        (
            sea_of(SinusoidWaves(spectrum="sinusoid", height_m=1.0, wavelength_m=20.0), model="choppy", depth_m=0.5),
            ("choppy", "fold over"),
        ),
        (sea_of(FileWaves(spectrum="file", file="none.spc")), ("none.spc", "no such file")),
        (sea_of(FileWaves(spectrum="file", file=__file__)), (Path(__file__).name, "kinds are")),
        (sea_of(FileWaves(spectrum="file", file=str(SPECTRA))), ("is a folder",)),
        (sea_of(FileWaves(spectrum="file", file=str(SPECTRA / "swan_1d.spc"))), ("has no directions",)),
        (sea_of(FileWaves(spectrum="file", file=str(SPECTRA / "swan.spc"), site=99)), ("site = 99",)),
    ],
)
def test_seas_that_cannot_be_drawn_say_why_in_one_line(settings, words):
    with pytest.raises(ValueError, match=re.escape(words[0])) as caught:
        realize(settings, 1)
    one_line(caught.value, *words)


@pytest.mark.parametrize("height", [29.9, 30.1, 4e18])
def test_a_file_brings_no_sea_that_no_scene_may_have(tmp_path, height):
    """What stands for a missing value, or a wrong unit, is not taken for waves."""
    usual = 4.0 * np.sqrt(spectral_system(FileWaves(spectrum="file", file=str(SPECTRA / "ww3.nc")), np.inf).variance)
    with xr.open_dataset(SPECTRA / "ww3.nc", engine="scipy", decode_times=False) as opened:
        spectra = opened.load()
    spectra["efth"] = spectra["efth"] * np.float32((height / usual) ** 2)
    spectra.to_netcdf(tmp_path / "large.nc", engine="scipy")
    waves = FileWaves(spectrum="file", file=str(tmp_path / "large.nc"), kind="ww3")
    if height < 30.0:
        np.testing.assert_allclose(4.0 * np.sqrt(spectral_system(waves, np.inf).variance), height, rtol=1e-3)
        return
    with pytest.raises(ValueError, match="significant wave height is") as caught:
        spectral_system(waves, np.inf)
    one_line(caught.value, "must be at most 30", "check")


ENDED = FileWaves(spectrum="file", file=str(SPECTRA / "swan.spc"), tail_exponent=0.0)


@pytest.mark.parametrize(
    ("waves", "fraction"),
    [
        (jonswap(), 1.0 - 1e-9),
        (jonswap(), 1.0 - 1e-12),
        (ENDED, 1.0 - 1e-9),
    ],
)
def test_nearly_all_of_the_energy_is_refused_for_memory_or_given(waves, fraction):
    """The words of a root finder are no answer."""
    try:
        sea = realize(SeaSettings(energy_fraction=fraction, extent_m=256.0, waves=(waves,)), 1)
    except ValueError as error:
        one_line(error, "energy_fraction", "GB")
    else:
        # The file ends with a jump, which two integrals on grids of 1e-3 in k place half a step apart.
        np.testing.assert_allclose(sea.resolved.variance_share, fraction, atol=5e-5)


@pytest.mark.parametrize(("tp", "resolution"), [(2.0, 25.0), (1.0, 8.0), (0.7, 8.0), (0.5, 4.0)])
@pytest.mark.parametrize("spreading", ["cos2s", "long_crested"])
def test_waves_that_are_all_too_short_to_be_resolved_are_no_matter(tp, resolution, spreading):
    """Chop of 10 cm, of which 1e-30 is longer than the limit, beside a swell: no reason to refuse the sea."""
    chop = jonswap(significant_wave_height_m=0.1, peak_period_s=tp, spreading=spreading)
    together = realize(sea_of(jonswap(peak_period_s=10.0), chop, extent_m=512.0, resolution_m=resolution), 1)
    alone = realize(sea_of(jonswap(peak_period_s=10.0), extent_m=512.0, resolution_m=resolution), 1)
    np.testing.assert_allclose(together.resolved.elevation_std, alone.resolved.elevation_std, rtol=1e-3)


def test_a_file_that_was_written_anew_is_read_anew(tmp_path):
    path = tmp_path / "sea.spc"
    path.write_bytes((SPECTRA / "swan.spc").read_bytes())
    waves = FileWaves(spectrum="file", file=str(path))
    assert realize(sea_of(waves), 1).resolved.variance > 0.0
    path.write_text("no spectrum any more", encoding="utf-8")
    with pytest.raises(InputError, match="kinds are"):
        realize(sea_of(waves), 1)


@pytest.mark.parametrize("kept", [0.1, 0.5, 0.9])
@pytest.mark.parametrize("name", ["swan.spc", "ndbc.nc", "ww3.nc"])
def test_a_file_cut_short_is_refused_in_one_line(tmp_path, name, kept):
    whole = (SPECTRA / name).read_bytes()
    path = tmp_path / name
    path.write_bytes(whole[: int(kept * len(whole))])
    with pytest.raises(InputError) as caught:
        realize(sea_of(FileWaves(spectrum="file", file=str(path))), 1)
    one_line(caught.value, name)


def test_no_height_is_no_waves():
    assert wave_facts(jonswap(significant_wave_height_m=0.0), np.inf) is None


# ------------------------------------------------------------------------------------------------ on the command line


@pytest.fixture
def refused(capsys: pytest.CaptureFixture[str], tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Any:
    """What `seamap-rt simulate tiny` answers to settings that it must refuse."""
    monkeypatch.chdir(tmp_path)

    def run(*pairs: str) -> str:
        chosen = [part for pair in ("tracing.tracer=horizon", *pairs) for part in ("--set", pair)]
        with pytest.raises(SystemExit) as end:
            main(["simulate", "tiny", "--out", "results", *chosen])
        said = capsys.readouterr()
        assert end.value.code == 2
        assert said.out == ""
        assert said.err.count("\n") == 1, said.err
        assert said.err.startswith("seamap-rt: ")
        for word in ("Traceback", "Warning", "None"):
            assert word not in said.err
        assert not any(Path("results").glob("*"))
        return said.err

    return run


WAVES = "sea.waves.0."
BY_FILE = 'sea.waves=[{spectrum="file", file="%s"}]'


@pytest.mark.parametrize(
    ("pairs", "words"),
    [
        (("sea.resolution_m=0.002",), ("sea", "256000", "4096", "GB", "raise resolution_m")),
        (("sea.energy_fraction=1",), ("sea.energy_fraction = 1", "less than 1")),
        (("sea.model=choppy", "sea.resolution_m=0.25", WAVES + "significant_wave_height_m=6.5"), ("choppy", "linear")),
        ((WAVES + "peak_period_s=40",), ("sea", "extent_m", "raise")),
        (("sea.extent_m=100",), ("sea.extent_m = 100", "at least 360")),
        ((BY_FILE % "none.spc",), ("none.spc", "no such file")),
        (('sea.waves=[{spectrum="elfouhaily", wind_speed_m_s=0}]',), ("wind_speed_m_s = 0", "at least 0.01")),
        (('sea.waves=[{spectrum="jonswap", wind_speed_m_s=8}]',), ("fetch_m",)),
        ((WAVES + "spreading=fan",), ("spreading", "cos2s")),
    ],
)
def test_the_command_line_refuses_in_one_line(refused, pairs, words):
    said = refused(*pairs)
    for word in words:
        assert word in said, said
