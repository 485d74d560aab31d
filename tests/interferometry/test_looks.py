"""Which interferogram of a turn is taken, and that those of one way and of both tell the same heights."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
import xarray as xr
from rolling_echoes import Boat, ideal_sea
from synthetic_seas import heard

from seamap_rt.interferometry import retrieve
from seamap_rt.interferometry.description import RadarDescription
from seamap_rt.interferometry.interferogram import Interferogram
from seamap_rt.interferometry.looks import Looks, interferogram
from seamap_rt.scene import load_scene
from seamap_rt.settings import RadarSettings, RetrievalSettings
from seamap_rt.simulation import Simulator
from validation import analytic

RNG_SEED = 1


def taken(echoes: xr.Dataset, **chosen: object) -> Interferogram:
    settings = RetrievalSettings.model_validate(chosen)
    return interferogram(Looks.of(echoes, RadarDescription.of(echoes), settings))[0]


def changing(echoes: xr.Dataset, every: int, share: float = 1.0) -> xr.Dataset:
    """The same whose speckle is another after `every` pulses, at both receivers alike: that share of its power."""
    rng = np.random.default_rng(RNG_SEED)
    voltage = np.asarray(echoes["voltage"].values)
    shape = (-(-voltage.shape[0] // every), 1, voltage.shape[2])
    draws = np.sqrt(0.5) * (rng.normal(size=shape) + 1j * rng.normal(size=shape))
    factor = np.repeat(np.sqrt(1.0 - share) + np.sqrt(share) * draws, every, axis=0)[: voltage.shape[0]]
    return echoes.assign(voltage=(echoes["voltage"].dims, (voltage * factor).astype(np.complex64)))


def test_both_ways_are_taken_where_echoes_last() -> None:
    echoes = Boat().echoes(ideal_sea)
    assert taken(echoes).model.paths == 2
    assert taken(echoes, paths="one_way").model.paths == 1
    assert taken(Boat(mode=("single", "single_pulse")).echoes(ideal_sea)).model.paths == 1
    assert taken(Boat(mode=("switched", "alternating_pulse")).echoes(ideal_sea)).model.paths == 2


def test_echoes_that_change_from_pulse_to_pulse_are_compared_on_the_same_pulse() -> None:
    echoes = Boat().echoes(ideal_sea)
    assert taken(changing(echoes, 1)).model.paths == 1
    # Of two pulses of one antenna, two intervals apart: a coherence of 1 − share with the next one. 0.9 is asked.
    assert taken(changing(echoes, 1, 0.15)).model.paths == 1
    assert taken(changing(echoes, 1, 0.05)).model.paths == 2
    assert taken(changing(echoes, 50)).model.paths == 2  # that is new in each dwell of ten pulses
    # Heights stay right to what few samples of it leave: all of one place, its phase is exact.
    polar = retrieve(changing(echoes, 1), RetrievalSettings(estimator="single_cell"))["polar"].to_dataset()
    assert polar.attrs["paths"] == 1


def test_noise_is_not_taken_for_change() -> None:
    # As strong as the echo: pulses of one antenna agree to a half of their power, which is all of the echo's.
    boat = Boat(prf=4000.0, ranges=np.arange(15.0, 75.0, 1.5))
    echoes = boat.echoes(ideal_sea)
    rng = np.random.default_rng(2)
    voltage = np.asarray(echoes["voltage"].values)
    noise = np.mean(np.abs(voltage) ** 2)
    draws = np.sqrt(0.5 * noise) * (rng.normal(size=voltage.shape) + 1j * rng.normal(size=voltage.shape))
    loud = echoes.assign(voltage=(echoes["voltage"].dims, (voltage + draws).astype(np.complex64)))
    loud.attrs["noise_power_w"] = float(noise)
    assert taken(loud).model.paths == 2
    loud.attrs["noise_power_w"] = 0.0
    assert taken(loud).model.paths == 1


def test_below_a_high_mast_the_phase_of_both_ways_is_blurred() -> None:
    # The phase of mean sea level turns by 2k B H/R² a metre, more than a radian in the length of a pulse.
    ranges, high = np.arange(60.0, 120.0, 1.5), ((0.0, 0.0, -0.4), (0.0, 0.0, 0.4))
    assert taken(Boat(height=5.0, ranges=ranges).echoes(ideal_sea)).model.paths == 2
    assert taken(Boat(height=55.0, offsets=high, ranges=ranges).echoes(ideal_sea)).model.paths == 1


SEA = analytic.TiltedSea(0.004, -0.002)


@pytest.mark.parametrize("estimator", ["single_cell", "sliding_plane", "adaptive"])
def test_one_way_and_both_tell_the_same(estimator: str) -> None:
    radar = RadarSettings(sector_deg=(0.0, 36.0), range_m=(30.0, 120.0))
    echoes = analytic.echoes(SEA, radar)
    maps = [
        retrieve(echoes, RetrievalSettings.model_validate({"estimator": estimator, "paths": paths, "ground_m": 100.0}))[
            "polar"
        ].to_dataset()
        for paths in ("one_way", "best")
    ]
    assert [each.attrs["paths"] for each in maps] == [1, 2]
    one, two = (each["height"].values[0] for each in maps)
    assert np.isfinite(one).mean() > 0.95
    np.testing.assert_array_equal(np.isfinite(one), np.isfinite(two))
    np.testing.assert_allclose(one, two, rtol=0, atol=5e-3)


def test_the_coarse_map_tells_the_cycles_of_the_fine_one() -> None:
    # Of B = 0.6 m both ways know heights to 0.75 m at 30 m; a plane that lies 0.6 m high is beyond half of that, and so
    # is all of it: neighbours cannot tell, one way can.
    radar = RadarSettings(sector_deg=(0.0, 36.0), range_m=(30.0, 60.0), baseline_m=0.6)
    echoes = analytic.echoes(analytic.TiltedSea(0.0, 0.0, 0.6), radar)
    given = taken(echoes)
    assert given.model.paths == 2
    (told,) = given.others()
    np.testing.assert_allclose(np.nanmedian(told.height), 0.6, atol=0.02)
    assert given.others()[0] is told  # made once
    height = retrieve(echoes)["polar"].to_dataset()["height"].values
    np.testing.assert_allclose(height[np.isfinite(height)], 0.6, rtol=0, atol=0.03)
    alternating = radar.model_copy(update={"interferogram": "alternating_pulse"})
    assert taken(analytic.echoes(SEA, alternating)).others() == ()


def test_the_middle_of_a_turn_of_unknown_places_is_the_origin() -> None:
    poses = heard(lambda x, y: 0.0 * x, 1, coherence=None, looks=4, gates=9).given.model.poses
    east, north = np.array([[1.0], [np.nan], [3.0]]), np.full((3, 1), np.nan)
    assert replace(poses, middle=(east, north)).centre == (2.0, 0.0)


def test_each_pulse_has_a_level_of_its_own_though_a_leaning_antenna_stands_still() -> None:
    """Products of two pulses are freed of both levels, by the pulses' own rows."""
    keys = {"radar.tilt_deg": 20.0, "radar.height_m": 40.0, "radar.range_m": [15.0, 90.0], "tracing.tracer": "horizon"}
    keys["platform.list_deg"] = 3.0
    flat = {"sea.waves": [], "scattering.nrcs": "constant", "radar.noise": False, "radar.sector_deg": [260.0, 275.0]}
    echoes = Simulator(load_scene("tiny", {**keys, **flat})).turn(0).echoes
    looks = Looks.of(echoes, RadarDescription.of(echoes), RetrievalSettings())
    assert looks.dwells.leaning
    assert looks.level_of((0, 1)).shape == (echoes.sizes["pulse"], echoes.sizes["range"])
    maps = retrieve(echoes)["polar"].to_dataset()
    height = maps["height"].values[..., maps["range"].values > 47.0]  # nearer the fan may pass over the sea
    assert np.abs(height).max() < 0.05  # gates' weighting of speckle: 8 mm in the median
