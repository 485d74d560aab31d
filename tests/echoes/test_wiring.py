"""Through the whole chain: each key reaches what it is meant for."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest
import xarray as xr

import seamap_rt as sr
from seamap_rt.conventions import wrap_degrees
from seamap_rt.echoes.speckle import speckle_basis
from seamap_rt.interferometry import retrieve
from seamap_rt.radar.array import squint_deg
from seamap_rt.scene import Scene, load_scene


def scene(**keys: Any) -> Scene:
    fixed = {
        "tracing.tracer": "horizon",
        "sea.extent_m": 420.0,
        "sea.resolution_m": 2.0,
        "radar.range_m": [20.0, 80.0],
        "radar.sector_deg": [250.0, 270.0],
    }
    return load_scene("tiny", fixed | {key.replace("__", "."): value for key, value in keys.items()})


def polar(tree: xr.DataTree) -> xr.Dataset:
    return tree["polar"].to_dataset()


def test_a_channel_belongs_to_its_antenna() -> None:
    """With a transmitter before them, receivers are not numbered as antennas are."""

    def voltages(phase: float) -> np.ndarray:
        antennas: list[dict[str, Any]] = [
            {"offset_m": [0.0, 0.0, 0.0], "role": "tx"},
            {"offset_m": [0.0, 0.0, -0.1], "role": "rx", "channel_phase_deg": phase},
            {"offset_m": [0.0, 0.0, 0.1], "role": "rx"},
        ]
        made = scene(radar__antennas=antennas, radar__transmit="single", radar__noise=False)
        return sr.echoes.from_scatterers(made, [[-50.0, 0.0, 0.0]], 1.0)["voltage"].values

    even, turned = voltages(0.0), voltages(30.0)
    heard = np.abs(even[:, 0]) > 0.0
    angle = np.degrees(np.angle(turned[:, 0][heard] / even[:, 0][heard]))
    np.testing.assert_allclose(angle, 30.0, atol=1e-4)  # complex64
    np.testing.assert_array_equal(turned[:, 1], even[:, 1])


def test_expectation_and_echoes_share_the_channels() -> None:
    keys = {"radar__channel_gain_db": 6.0, "radar__channel_phase_deg": 40.0, "radar__noise": False}
    plain, unlike = (sr.expected(scene(**each)) for each in ({}, keys))
    ratio = (unlike["covariance"] / plain["covariance"]).values
    np.testing.assert_allclose(np.degrees(np.angle(ratio)), -40.0, atol=1e-9)
    np.testing.assert_allclose(np.abs(ratio), 10.0**0.3, rtol=1e-9)
    power = (unlike["power"] / plain["power"]).values
    np.testing.assert_allclose(power[:, 1], 10.0**0.6, rtol=1e-9)
    np.testing.assert_allclose(power[:, 0], 1.0, rtol=1e-9)


def test_a_squint_turns_echoes_and_truth_alike() -> None:
    made = scene(radar__antenna__feed="end", radar__antenna__design_frequency_hz=9.8e9)
    squint = squint_deg(made.radar.antenna, made.radar.frequency_hz)
    assert abs(squint) > 1.0
    simulation, straight = sr.simulate(made), sr.simulate(scene())
    first = [float(each.echoes["azimuth"].values[0]) for each in (simulation, straight)]
    assert wrap_degrees(first[0] - first[1]) == pytest.approx(squint, abs=1e-9)
    looks = [each.truth["polar"].to_dataset()["azimuth"].values for each in (simulation, straight)]
    np.testing.assert_allclose(wrap_degrees(looks[0] - looks[1]), squint, atol=1e-9)
    maps = retrieve(simulation.echoes, made.retrieval)
    np.testing.assert_allclose(maps["polar"].to_dataset()["azimuth"].values, looks[0], atol=1e-9)


def test_ground_truth_is_seen_from_where_the_boat_then_is() -> None:
    made = scene(platform__speed_m_s=10.0, platform__heading_deg=90.0, radar__rotation_rpm=6.0, radar__prf_hz=3000)
    truth = sr.simulate(made).truth["ground"].to_dataset().isel(turn=0)
    time = truth["time"].values
    known = np.isfinite(time)
    assert known.sum() > 20
    x, y = np.meshgrid(truth["x"].values, truth["y"].values)
    seen = np.degrees(np.arctan2(x - 10.0 * time, y))[known]  # the boat runs east
    asked = 250.0 + 36.0 * time[known]
    off = np.abs(wrap_degrees(seen - asked))
    assert off.max() <= 0.9  # half a look: nearer to the boat's path places are left out
    assert np.median(off) < 1e-3
    assert np.ptp(10.0 * time[known]) > 3.0


def test_a_staring_antenna_uses_all_its_pulses() -> None:
    """Two halves of a stare, each heard alone, are not the whole: with one half NaN the map differs."""
    made = scene(radar__scan="staring", radar__stare_s=0.05)
    echoes = sr.simulate(made).echoes
    pulses = echoes.sizes["pulse"]
    whole = polar(retrieve(echoes, made.retrieval))["coherence"].values
    for half in (slice(0, pulses // 2), slice(pulses // 2, None)):
        deaf = echoes.copy(deep=True)
        deaf["voltage"].values[half] = np.nan
        part = polar(retrieve(deaf, made.retrieval))["coherence"].values
        assert np.nanmax(np.abs(part - whole)) > 1e-3


@pytest.mark.parametrize("scan", [{"radar__scan": "staring"}, {"radar__sector_deg": [269.1, 270.9]}])
def test_a_single_look_is_one_look_wide_on_the_ground(scan: dict[str, Any]) -> None:
    made = scene(**scan)
    simulation = sr.simulate(made)
    ground = retrieve(simulation.echoes, made.retrieval)["ground"].to_dataset()
    true = simulation.truth["ground"].to_dataset()
    mapped, asked = (np.isfinite(each["height"].values).sum() for each in (ground, true))
    assert 0 < mapped <= 1.5 * asked + 10


def test_either_receiver_may_come_first() -> None:
    made = scene(radar__range_m=[20.0, 120.0], sea__resolution_m=1.0)
    echoes = sr.simulate(made).echoes
    truth = sr.simulate(made).truth
    rms = []
    for receivers in ((0, 1), (1, 0)):
        settings = made.retrieval.model_copy(update={"receivers": receivers})
        error = polar(retrieve(echoes, settings))["height"].values - polar(truth)["height"].values
        near = polar(truth)["range"].values < 60.0
        rms.append(np.sqrt(np.nanmean(error[..., near] ** 2)))
    assert rms[1] == pytest.approx(rms[0], rel=0.05)


@pytest.mark.parametrize("aside", [0.05, 0.2])
def test_antennas_on_either_side_of_the_axis_see_a_flat_sea_flat(aside: float) -> None:
    """2a²/b_z = 0.4 m at a = 0.2 m is what a plane through one of them would make of it."""
    antennas = [{"offset_m": [-aside, 0.0, -0.1]}, {"offset_m": [aside, 0.0, 0.1]}]
    # Speckle that lasts a millisecond, all around: a mean of 4400 cells scatters by 0.02 m, four draws by 0.01.
    speckle = {"scattering__decorrelation_time_s": 1e-3, "scattering__doppler": "orbital"}
    keys = {"radar__noise": False, "radar__sector_deg": [0.0, 360.0], "sea__waves": [], "scattering__nrcs": "constant"}
    means = []
    for seed in range(1, 5):
        made = scene(radar__antennas=antennas, seed=seed, **keys, **speckle)
        height = polar(retrieve(sr.simulate(made).echoes, made.retrieval))["height"].values
        means.append(np.nanmean(height[..., 15:]))
    assert abs(np.mean(means)) < 0.03


def test_antennas_beside_the_mast_look_along_lines_of_their_own() -> None:
    antennas = [{"offset_m": [2.0, 0.0, z]} for z in (-0.1, 0.1)]
    made = scene(radar__antennas=antennas, radar__noise=False, radar__sector_deg=[255.0, 285.0])
    # Straight ahead of the antennas when the array looks west: they stand 2 m to the right of it, which is north.
    echoes = sr.echoes.from_scatterers(made, [[-40.0, 2.0, 0.0]], 1.0)
    power = np.nansum(np.abs(echoes["voltage"].values) ** 2, axis=(1, 2))
    azimuth = echoes["azimuth"].values
    assert np.sum(power * azimuth) / np.sum(power) == pytest.approx(270.0, abs=0.1)


def test_modes_of_windows_that_differ_a_little_are_alike() -> None:
    short, long = speckle_basis(40, 4e-4, 5e-3), speckle_basis(43, 4e-4, 5e-3)[:, -40:]
    for one, other in zip(short[:4], long[:4], strict=True):
        assert float(one @ other) / float(np.linalg.norm(one) * np.linalg.norm(other)) > 0.8


def test_placed_antennas_are_sampled_as_finely_as_their_own_beam_asks() -> None:
    """Narrow beams pass quickly: nodes must lie closer, whether the aperture is common or each antenna's own."""
    wide = {"width_m": 3.0, "azimuth_beamwidth_deg": 0.6}
    keys = {"radar__noise": False, "scattering__decorrelation_time_s": np.inf, "scattering__doppler": "orbital"}
    placed = [{"offset_m": [0.0, 0.0, z], **wide} for z in (-0.1, 0.1)]
    common = scene(**keys, **{f"radar__antenna__{key}": value for key, value in wide.items()})
    apart = scene(**keys, radar__antennas=placed)
    one, other = (sr.simulate(each).echoes["voltage"].values for each in (common, apart))
    np.testing.assert_array_equal(one, other)
