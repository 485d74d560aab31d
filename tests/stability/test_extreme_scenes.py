"""Scenes at the ends of what may be asked: the right answer, NaN with a flag, or a refusal in one line."""

from __future__ import annotations

from functools import cache
from typing import Any

import numpy as np
import pytest
import xarray as xr
from hard_surfaces import TRACERS, light, rings, scene, trace
from numpy.testing import assert_allclose, assert_array_equal
from numpy.typing import NDArray

from seamap_rt import sea
from seamap_rt.dataset import QUALITY_FLAGS
from seamap_rt.echoes.turn import turn_voltages
from seamap_rt.errors import InputError
from seamap_rt.interferometry import retrieve
from seamap_rt.mesh.sizing import MOST_TRIANGLES
from seamap_rt.mesh.surface import mesh_turn
from seamap_rt.metrics import error_figures
from seamap_rt.radar.installation import Installation
from seamap_rt.radar.scan import pulses
from seamap_rt.scene import Scene
from seamap_rt.session import Simulation, simulate
from seamap_rt.simulation import Simulator

CREST, LENGTH = 1.5, 22.0  # m: a wave as steep as can be, its crest over the origin at time 0
CURVATURE = (2.0 * np.pi / LENGTH) ** 2 * CREST  # 1/m, of the crest


def on_the_crest(above: float, **keys: Any) -> Scene:
    """Antennas so far above the crest, 1 cm apart, that look down its back at what lies before the next crest."""
    return scene(
        "sinusoid",
        **{
            "sea__waves__0__height_m": 2.0 * CREST,
            "sea__waves__0__wavelength_m": LENGTH,
            "radar__height_m": CREST + above + 0.005,
            "radar__baseline_m": 0.01,
            "radar__sector_deg": [88.0, 92.0],
            "radar__range_m": [4.0, 11.5],
            "scattering__nrcs": "constant",
            "tracing__facet_m": 0.25,
            **keys,
        },
    )


def refusal(error: BaseException, *words: str) -> None:
    text = str(error)
    assert "\n" not in text
    for word in words:
        assert word in text, text


# ----------------------------------------------------------------------------------------- at the water's level


@pytest.mark.parametrize("name", TRACERS)
def test_1_cm_above_a_crest_nothing_is_seen_of_its_back(name: str) -> None:
    """Rays touch the crest at √(2 × 0.01 m/curvature) = 0.4 m, before the mesh begins, and pass over all that the gates
    hear, up to 16 m: falling by 5 %, they meet the next crest at 17 m."""
    made = on_the_crest(0.01)
    assert np.sqrt(2.0 * 0.02 / CURVATURE) < 1.0
    mesh = Simulator(made).mesh(0)
    lit = light(name, mesh, made)
    assert not lit[..., mesh.facets.distance < 16.0].any()


@pytest.mark.parametrize("noise", [False, True])
@pytest.mark.parametrize("name", TRACERS)
def test_without_a_facet_lit_there_is_noise_alone(name: str, noise: bool) -> None:
    """Voltages are 0, or the receiver's noise to the fourth decimal of its power; the map says no echo everywhere."""
    keys = {"tracing__diffraction": "none", "retrieval__min_snr_db": 10.0}
    made = on_the_crest(0.01, radar__noise=noise, tracing__tracer=name, **keys)
    simulation = simulate(made)
    volts = simulation.echoes["voltage"].values
    assert np.isfinite(volts).all()
    if noise:
        power = np.mean(np.abs(volts.astype(np.complex128)) ** 2)
        expected = float(simulation.echoes.attrs["noise_power_w"])
        assert abs(power / expected - 1.0) < 5.0 / np.sqrt(volts.size)
    else:
        assert not volts.any()
    maps = retrieve(simulation.echoes, made.retrieval)
    assert_nothing_known(maps["polar"].to_dataset(), "no_echo")
    assert np.isnan(maps["ground"].to_dataset()["height"].values).all()
    assert_array_equal(simulation.truth["polar"].to_dataset()["visible_fraction"].values, 0.0)
    overall = error_figures(maps, simulation.truth)["overall"]
    assert all(value is None or np.isfinite(value) for value in overall.values() if not isinstance(value, dict))


def assert_nothing_known(found: xr.Dataset, flag: str) -> None:
    assert np.isnan(found["height"].values).all()
    assert (found["quality"].values & QUALITY_FLAGS[flag] != 0).all()


def test_1_cm_below_a_crest_is_refused_in_one_line() -> None:
    with pytest.raises(InputError) as caught:
        Simulator(on_the_crest(-0.01))
    refusal(caught.value, "radar.height_m = 1.495", "under water at time 0", "raise radar.height_m")


def test_an_antenna_at_the_water_to_the_millimetre() -> None:
    """A millimetre over it is above, the very level and below it are under."""
    Simulator(on_the_crest(0.001))
    for above in (0.0, -0.001):
        with pytest.raises(InputError):
            Simulator(on_the_crest(above))


def test_a_crest_that_comes_up_under_the_antenna_silences_it() -> None:
    """At time 0 the water stands 1 cm below the lower antenna, on the face of the wave that comes: it rises at
    aω = 2.5 m/s, and the antenna is under it 4 ms later. Pulses are NaN from then on, and their looks say so."""
    made = on_the_crest(
        0.0,
        sea__waves__0__phase_deg=90.0,
        radar__height_m=0.015,
        radar__sector_deg=[88.0, 98.8],
        retrieval__cell_azimuth_deg=1.8,
    )
    simulation = simulate(made)
    silent = np.all(np.isnan(simulation.echoes["voltage"].values), axis=(1, 2))
    time = simulation.echoes["time"].values
    omega = np.sqrt(9.81 * 2.0 * np.pi / LENGTH)
    rises = 0.01 / (CREST * omega)
    assert 3e-3 < rises < 5e-3
    line = 1.8 / made.detail.columns_per_beam / 360.0  # s in which a column passes: the time's grain
    assert not silent[time < rises - line].any()
    assert silent[time > rises + line].all()
    found = retrieve(simulation.echoes, made.retrieval)["polar"].to_dataset()
    last = found.isel(azimuth=slice(2, None))
    assert_nothing_known(last, "submerged")


# -------------------------------------------------------------------------------------------- waves at both ends


def test_hs_15_m_under_a_5_m_mast() -> None:
    """Whole pulses are silent while the antenna is under water, and said to be; all others are finite."""
    made = scene(
        "tiny",
        sea__resolution_m=4.0,
        sea__extent_m=1024.0,
        sea__waves__0__significant_wave_height_m=15.0,
        sea__waves__0__peak_period_s=17.0,
        radar__sector_deg=[262.0, 269.2],
        radar__range_m=[15.0, 100.0],
        tracing__tracer="facets",
        tracing__facet_m=1.0,
        scattering__nrcs="constant",
        turns=6,
        seed=dry_start(),
    )
    simulation = simulate(made)
    volts = simulation.echoes["voltage"].values
    silent = np.all(np.isnan(volts), axis=(1, 2))
    assert 0.05 < silent.mean() < 0.95  # of 6 s of waves of 17 s some lie under water
    assert np.isfinite(volts[~silent]).all()
    assert_array_equal(silent, simulation.echoes["flag"].values == QUALITY_FLAGS["submerged"])
    found = retrieve(simulation.echoes, made.retrieval)["polar"].to_dataset()
    known = np.isfinite(found["height"].values)
    assert np.isfinite(found["height_std"].values[known]).all()
    assert (found["quality"].values[~known] != 0).all()
    for turn in np.unique(simulation.echoes["turn"].values):
        if silent[simulation.echoes["turn"].values == turn].all():
            assert_nothing_known(found.isel(turn=int(turn)), "submerged")


@cache
def dry_start() -> int:
    """A seed at which the antenna starts above water and goes under within 6 s."""
    asked = {
        "sea__resolution_m": 4.0,
        "sea__extent_m": 1024.0,
        "sea__waves__0__significant_wave_height_m": 15.0,
        "sea__waves__0__peak_period_s": 17.0,
    }
    for seed in range(1, 40):
        made = scene("tiny", **asked, seed=seed)
        water = sea.realize(made.sea, np.random.SeedSequence(seed, spawn_key=(1,)))
        level = sea.direct_sum(water.components(), 0.0, 0.0, np.arange(6.0)).elevation
        if level[0] < 4.0 and 1 <= np.count_nonzero(level > 5.5) <= 4:
            return seed
    raise AssertionError("no such seed among 40")


@cache
def smooth(height: float) -> tuple[Scene, Simulation]:
    made = scene(
        "tiny",
        sea__waves__0__significant_wave_height_m=height,
        radar__sector_deg=[260.0, 270.8],
        radar__noise=False,
        tracing__facet_m=0.8,
        scattering__nrcs="constant",
    )
    return made, simulate(made)


def test_a_sea_of_1_micrometre_is_all_lit_and_level() -> None:
    made, simulation = smooth(1e-6)
    truth = simulation.truth["polar"].to_dataset()
    assert_array_equal(truth["visible_fraction"].values, 1.0)
    assert np.abs(truth["height"].values).max() < 2e-6  # crests of a sea of Hs: Hs at most, and the float32 of them
    assert np.abs(truth["slope_range"].values).max() < 1e-5
    assert np.isfinite(simulation.echoes["voltage"].values).all()
    for name in TRACERS:
        mesh = mesh_turn(sea.realize(made.sea, 1), made.radar, made.meshing, 0)
        assert light(name, mesh, made).all()


def test_a_sea_of_1_micrometre_echoes_and_maps_as_one_of_none() -> None:
    """The same speckle: voltages differ by the phase of 1 µm, 2k sin ψ × 1e-6 = 3e-4 rad at 15 m, times their peak over
    their rms; heights by 1 µm."""
    (made, rough), (_, level) = smooth(1e-6), smooth(0.0)
    volts = [each.echoes["voltage"].values for each in (rough, level)]
    scale = np.sqrt(np.mean(np.abs(volts[1]) ** 2))
    assert_allclose(volts[0], volts[1], rtol=0.0, atol=1e-3 * scale)
    maps = [retrieve(each.echoes, made.retrieval)["polar"].to_dataset()["height"].values for each in (rough, level)]
    assert np.isfinite(maps[0]).all()
    assert np.abs(maps[0] - maps[1]).max() < 1e-6


# ---------------------------------------------------------------------------------------------- walls of water


def steep_choppy() -> Scene:
    """Choppy waves about as steep as they are taken: 1.6 % of the water folds, of 2 % that may."""
    return scene(
        "tiny",
        sea__model="choppy",
        sea__waves__0__significant_wave_height_m=2.86,
        sea__waves__0__peak_period_s=3.6,
        sea__resolution_m=0.5,
        sea__extent_m=360.0,
        radar__sector_deg=[262.0, 269.2],
        radar__range_m=[15.0, 100.0],
        tracing__facet_m=0.25,
        scattering__nrcs="constant",
    )


def test_a_choppy_sea_near_folding_is_traced_alike() -> None:
    """Where the surface folds the upper sheet is meshed: a cliff of a facet's length, single-valued all the same."""
    made = steep_choppy()
    simulator = Simulator(made)
    facts = simulator.sea.resolved.choppy
    assert facts is not None
    assert 0.01 < facts.folded_share <= 0.02
    mesh = simulator.mesh(0)
    assert np.abs(mesh.facets.slope_look).max() > 1.0
    rays, horizon = (light(name, mesh, made) for name in TRACERS)
    assert 0.1 < horizon.mean() < 0.9
    assert np.mean(rays != horizon) < 2e-4
    assert np.isfinite(simulator.turn(0).echoes["voltage"].values).all()


@pytest.mark.parametrize("name", TRACERS)
@pytest.mark.parametrize("top", [4.0, 30.0], ids=["below the mast", "above it"])
def test_a_vertical_wall(name: str, top: float) -> None:
    """As upright as a mesh can have it, a step within 2 cm: its face is lit; its shadow ends where the ray lands."""
    made = scene(
        radar__sector_deg=[90.0, 91.8],
        radar__range_m=[15.0, 40.0],
        tracing__facet_m=0.02,
        tracing__columns_per_beam=3,
        scattering__nrcs="constant",
    )

    def wall(r: NDArray[np.float64]) -> NDArray[np.float64]:
        return np.where(np.abs(r - 20.0) < 0.011, top, 0.0)  # one rung, at 20 m

    facets = trace(name, rings(wall, made), made)
    assert np.abs(facets.slope_look).max() > 100.0
    for antenna, height in ((0, 4.9), (1, 5.1)):
        lit, distance = facets.lit[antenna], facets.distance
        lands = 20.0 * height / (height - top) if top < height else np.inf
        assert lit[:, distance < 20.0 - 1e-6].all()
        assert not lit[:, (distance > 20.0 + 1e-6) & (distance < lands - 0.02)].any()
        assert lit[:, distance > lands + 0.04].all()
    rcs = (1e-3 * facets.horizontal_area * np.ones_like(facets.height)).astype(np.float32)
    volts = turn_voltages(facets, rcs, Installation(made.radar), pulses(Installation(made.radar), 0), 1, np.inf)
    assert np.isfinite(volts).all()


# -------------------------------------------------------------------------------------------- ten million facets


def triangles_of(facet: float) -> dict[str, Any]:
    """3 km all around: 3.9e7/facet triangles by the scene's own reckoning with 4 columns a beam."""
    return {
        "radar__range_m": [15.0, 3000.0],
        "radar__prf_hz": 2000.0,
        "radar__sector_deg": [0.0, 360.0],
        "retrieval__ground_m": 10.0,
        "tracing__facet_m": facet,
        "tracing__columns_per_beam": 4,
        "scattering__extrapolate": True,
    }


def test_more_facets_than_memory_holds_are_refused_with_the_memory_they_need() -> None:
    """Just above the limit: one line with the count, the memory, what may be, and a remedy that is taken when typed."""
    columns = 4.0 * (360.0 + 6.0 * 1.8) / 1.8
    facet = 2.0 * columns * 3005.0 / MOST_TRIANGLES
    with pytest.raises(InputError) as caught:
        scene(**triangles_of(0.98 * facet))
    refusal(caught.value, "tracing.facet_m", "2.04e+07 triangles", "12.2 GB", "2e+07", "12 GB", "raise tracing.facet_m")
    told = float(str(caught.value).split("must be at least ")[1].split()[0])
    assert scene(**triangles_of(told)).detail.facet_m == told


def test_a_sector_of_ten_million_facets_is_traced() -> None:
    """One seventieth of 10⁷: as fine and far, in a sector; the whole is in validation.hard_cases.report --full."""
    made = scene(**{**triangles_of(0.5), "radar__sector_deg": [0.0, 1.8]})
    mesh = rings(lambda r: 0.3 * np.cos(r / 5.0), made)
    assert 1e5 < 2 * mesh.grid.columns * (mesh.grid.ground_range.size - 1) < 1e6
    rays, horizon = (light(name, mesh, made) for name in TRACERS)
    assert np.mean(rays != horizon) < 1e-4
    assert 0.05 < horizon.mean() < 0.95
