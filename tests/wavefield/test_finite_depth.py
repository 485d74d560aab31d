"""Sea state on water of finite depth and on a current: JONSWAP seas of known waves, and one simulated turn."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest
from numpy.typing import NDArray

from seamap_rt.conventions import unit_from_azimuth, wrap_degrees
from seamap_rt.interferometry import retrieve
from seamap_rt.physics.dispersion import Water
from seamap_rt.scene import load_scene
from seamap_rt.session import iterate, run
from seamap_rt.settings import RetrievalSettings
from seamap_rt.simulation import Simulator
from seamap_rt.wavefield.advance import GroundFields, advanced
from seamap_rt.wavefield.sea_state import in_words, sea_state
from seamap_rt.wavefield.wave_direction import Travel
from seamap_rt.wavefield.wave_spectrum import Cells, Transforms, wave_spectrum
from validation.sea.finite_depth import AZIMUTH, FROM_DEG, GROUND, TIME, one_wave, random_sea, wavenumber


@pytest.mark.parametrize(("depth", "along_m_s"), [(5.0, 0.0), (5.0, -1.0), (10.0, 1.0), (30.0, 0.0)])
def test_one_wave_is_found_as_it_is(depth: float, along_m_s: float) -> None:
    found = sea_state(one_wave(8.0, depth, along_m_s).maps())
    # As in deep water: the centre of a line as wide as 1/R is known to 2 %. Deep water's relation says 5.8 s in 5 m,
    # and 7.75 s in 30 m.
    assert float(found["peak_period"][0]) == pytest.approx(8.0, rel=0.02)
    assert float(found["significant_wave_height"][0]) == pytest.approx(4.0 * np.sqrt(0.5 * 0.13), rel=0.02)
    assert abs(wrap_degrees(float(found["mean_direction"][0]) - FROM_DEG)) < 0.5
    assert found.attrs["depth_m"] == depth
    assert found.attrs["depth_given"] == 1


@pytest.mark.parametrize(("depth", "along_m_s"), [(5.0, 0.0), (5.0, 1.0), (30.0, 0.0)])
@pytest.mark.slow
def test_the_peak_period_of_a_random_sea_is_within_its_stated_error(depth: float, along_m_s: float) -> None:
    states = [sea_state(random_sea(seed, 8.0, depth, along_m_s).maps()) for seed in range(5)]
    found, stated = (np.array([float(each[name][0]) for each in states]) for name in ("peak_period", "peak_period_std"))
    # Within the stated error the mean must lie, and of 5 draws the rms of errors over stated ones, known to 1/√10 of
    # itself, below 1 + 1.6/√10.
    assert np.sqrt(np.mean(((found - 8.0) / stated) ** 2)) < 1.5
    assert abs(found.mean() - 8.0) < stated.mean()
    assert stated.max() < 0.8


def test_a_known_current_brings_the_sectors_together() -> None:
    # 2.5 s, 10 m long: in a turn of 2 s a current of 3 m/s carries it on by 0.6 of its length.
    wave = one_wave(2.5, 5.0, along_m_s=3.0)
    height, _ = wave.seen()
    look, gate = np.nonzero(np.isfinite(height))
    east, north = unit_from_azimuth(AZIMUTH[look])
    out = GROUND[gate]
    cells = Cells(out * east, out * north, TIME[look], look, height[look, gate], out)
    transforms, way = Transforms.of(cells), Travel.from_direction(FROM_DEG)
    known, unknown = (wave_spectrum(transforms, way, Water(5.0, flow)) for flow in (wave.current, (0.0, 0.0)))
    # Phases that drift by 0.6 cycles: the mean over equal sectors is sin(x)/x, x = 0.6 π, whose square is 0.25. That
    # the drift goes round with the azimuth is taken in part for another wavenumber, which leaves 0.57.
    assert known.power.max() > 1.5 * unknown.power.max()


def test_a_ground_map_at_one_instant_runs_on_with_the_current() -> None:
    x, y = np.meshgrid(*2 * [np.arange(-240.0, 241.0, 3.0)])
    k, flow = float(wavenumber(np.array([2.0 * np.pi / 4.0]), 6.0)[0]), (1.0, 0.0)

    def surface(time: NDArray[np.float64] | float) -> NDArray[np.float64]:
        return np.cos(k * x - (2.0 * np.pi / 4.0 + k * flow[0]) * time)  # eastward, with the current

    time = 2.0 * (np.degrees(np.arctan2(x, y)) % 360.0) / 360.0
    none = np.full(x.shape, np.nan)
    seen = GroundFields(surface(time), np.full(x.shape, 0.05), none, none, time)
    inside = (np.hypot(x, y) > 30.0) & (np.maximum(np.abs(x), np.abs(y)) < 190.0) & (np.abs(x) > 20.0)

    def error(water: Water) -> float:
        made = advanced(seen, 3.0, 1.0, Travel.from_direction(270.0), water).height
        return float(np.sqrt(np.mean((made - surface(1.0))[inside] ** 2)))

    # The bound of a scan of 2 s in `test_advance`, and there twice what is wrong is seen by far.
    assert error(Water(6.0, flow)) < 0.06 * np.sqrt(0.5)
    assert error(Water(6.0)) > 2.0 * error(Water(6.0, flow))


def test_a_depth_that_is_not_given_is_said() -> None:
    sea = one_wave(6.0, np.inf)
    given, left_out = (sea_state(sea.maps(each)) for each in (True, False))
    for name in given.data_vars:
        np.testing.assert_array_equal(given[name], left_out[name])
    assert left_out.attrs["depth_given"] == 0
    assert left_out.attrs["depth_m"] == np.inf
    assert "depth" not in in_words(given)
    # Half of 56 m, the wavelength of 6 s in deep water.
    assert "deep water assumed; longer in less than 28 m of water, set retrieval.depth_m" in in_words(left_out)


def test_a_run_knows_the_depth_of_its_scene_and_a_retrieval_what_it_is_told() -> None:
    scene = load_scene("choppy_sea", {"sea.depth_m": 5.0, "sea.current_m_s": 1.0, "sea.current_toward_deg": 90.0})
    assert scene.retrieval.depth_m is None
    deep = load_scene("choppy_sea", {"tracing.diffraction": "none"})
    assert deep.resolved_retrieval is deep.retrieval  # a run assumes no more than a retrieval of its echoes
    told = scene.resolved_retrieval
    assert (told.depth_m, told.current_m_s, told.current_toward_deg) == (5.0, 1.0, 90.0)
    chart = load_scene("choppy_sea", {"sea.depth_m": 5.0, "retrieval.depth_m": 7.0}).resolved_retrieval
    assert (chart.depth_m, chart.current_m_s) == (7.0, 0.0)
    with pytest.raises(ValueError, match="give current_m_s and current_toward_deg together"):
        RetrievalSettings(current_m_s=1.0)


@pytest.mark.slow
def test_simulated_turns_in_5_m_of_water() -> None:
    keys = {"radar.sector_deg": [200.0, 340.0], "radar.range_m": [15.0, 150.0], "tracing.tracer": "horizon"}
    swell = {"spectrum": "jonswap", "significant_wave_height_m": 0.8, "peak_period_s": 8.0, "wave_from_deg": 270.0}
    ratios = []
    for seed in range(1, 5):
        sea = {"seed": seed, "sea.depth_m": 5.0, "sea.waves": [swell], "sea.extent_m": 1024.0}
        scene = load_scene("choppy_sea", {**keys, **sea})
        maps = retrieve(Simulator(scene).turn(0).echoes, scene.resolved_retrieval)
        assert [maps[group].attrs["depth_m"] for group in ("polar", "ground")] == [5.0, 5.0]
        state = sea_state(maps)
        assert float(state["peak_period_std"][0]) < 0.8
        assert "depth" not in in_words(state)
        ratios.append((float(state["peak_period"][0]) - 8.0) / float(state["peak_period_std"][0]))
    # The rms of four errors over stated ones is known to 1/√8 of itself.
    assert np.sqrt(np.mean(np.square(ratios))) < 1.5


@pytest.mark.usefixtures("no_pictures")
def test_a_run_takes_its_scenes_depth_for_known(tmp_path: Path) -> None:
    """5 m go into the maps that it makes; of deep water, a scene gives it as inf, nothing is missing."""
    keys = {"radar.sector_deg": [200.0, 340.0], "radar.range_m": [15.0, 150.0], "tracing.tracer": "horizon"}
    narrow = {**keys, "radar.sector_deg": [260.0, 270.0], "sea.depth_m": 5.0}
    turn = next(iterate(load_scene("choppy_sea", narrow)))
    assert turn.maps is not None
    assert turn.maps["polar"].attrs["depth_m"] == 5.0
    words = run(load_scene("choppy_sea", keys), tmp_path / "deep").metrics["sea_state_in_words"]
    assert "Tp" in words
    assert "depth" not in words
