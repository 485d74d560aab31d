"""A boat that has run 10 km, and a radar that has turned for 12 h: what they see is what they saw at the start."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest
from hard_surfaces import TRACERS, light, scene
from numpy.testing import assert_allclose, assert_array_equal
from numpy.typing import ArrayLike

from seamap_rt import sea
from seamap_rt.echoes.scatterers import scatterer_voltages
from seamap_rt.interferometry import retrieve
from seamap_rt.mesh import polar_grid, surface_mesh
from seamap_rt.mesh.surface import sea_on_grid
from seamap_rt.radar.installation import Installation
from seamap_rt.radar.platform import BoatState
from seamap_rt.radar.scan import pulses
from seamap_rt.simulation import Simulator

EXTENT, PATCHES = 512.0, 20  # m; the sea repeats itself after each patch
AWAY = PATCHES * EXTENT  # 10.24 km
TURN = 2000  # so many seconds at 5.12 m/s
HALF_DAY = 43_200  # turns of a second
WINDOW: dict[str, Any] = {"radar__sector_deg": [260.0, 268.0], "radar__range_m": [15.0, 100.0]}


def moored(simulator: Simulator) -> None:
    """Take the boat back by what it has run: to the same water, 20 patches nearer to the origin."""
    motion = simulator.installation.motion

    def nearer(times: ArrayLike) -> BoatState:
        state = motion(times)
        return BoatState(state.position - np.array((AWAY, 0.0, 0.0)), state.attitude)

    made = simulator.scene
    simulator.installation = Installation(made.radar, made.platform, nearer)


@pytest.mark.parametrize("name", TRACERS)
@pytest.mark.parametrize("lean", [0.0, 8.0])
def test_10_km_from_the_origin_the_boat_sees_the_same(name: str, lean: float) -> None:
    """The mesh's frame goes with the antenna, so that nothing of the 10 km is left in float32.

    Of the sea: places round to 2e-12 m and heights to a float32 of 1 m, 6e-8 m. Of the echoes: 2k times that, 5e-5 rad.
    """
    made = scene(
        "tiny",
        **WINDOW,
        sea__extent_m=EXTENT,
        platform__speed_m_s=5.12,
        platform__heading_deg=90.0,
        platform__list_deg=lean,
        tracing__tracer=name,
        tracing__facet_m=0.8,
        scattering__sea_spikes=False,  # which are others there
    )
    far, near = Simulator(made), Simulator(made)
    moored(near)
    meshes = [each.mesh(TURN) for each in (far, near)]
    assert meshes[0].grid.pose.origin[:, 0].min() > AWAY - 1.0
    assert np.abs(meshes[1].grid.pose.origin[:, 0]).max() < 10.0
    assert_allclose(meshes[0].elevation, meshes[1].elevation, rtol=0.0, atol=3e-7)
    lit = [light(name, mesh, made) for mesh in meshes]
    assert np.mean(lit[0] != lit[1]) < 1e-4  # an edge that is passed within 1e-7 m
    turns = [each.turn(TURN) for each in (far, near)]
    volts = [turn.echoes["voltage"].values for turn in turns]
    scale = np.sqrt(np.mean(np.abs(volts[1]) ** 2))
    assert_allclose(volts[0], volts[1], rtol=0.0, atol=1e-4 * scale)  # 5e-5 rad, of a peak over the rms
    away = turns[0].echoes["position"].values - turns[1].echoes["position"].values
    assert_allclose(away, np.broadcast_to((AWAY, 0.0, 0.0), away.shape), rtol=0.0, atol=1e-11)
    truth = [turn.truth["polar"].to_dataset()["height"].values for turn in turns]
    assert_allclose(truth[0], truth[1], rtol=0.0, atol=1e-6)  # float32 in the file
    maps = [retrieve(turn.echoes, made.retrieval)["polar"].to_dataset() for turn in turns]
    known = [np.isfinite(each["height"].values) for each in maps]
    assert_array_equal(known[0], known[1])
    assert known[0].mean() > 0.3
    error = np.abs(maps[0]["height"].values - maps[1]["height"].values)[known[0]]
    assert np.quantile(error, 0.99) < 1e-5
    assert_array_equal(maps[0]["quality"].values, maps[1]["quality"].values)


def test_scatterers_10_km_away_with_the_boat_keep_their_phase() -> None:
    """k = 419 rad/m times an ulp of 10 km, 2e-12 m, from each of two subtractions: 2e-9 rad; complex64 is coarser."""
    made = scene(**WINDOW, radar__noise=False, platform__speed_m_s=5.12, platform__heading_deg=90.0)
    radar, motion = made.radar, Installation(made.radar, made.platform).motion
    place = np.array([[-45.0, -3.0, 0.4], [-80.0, -9.0, -0.2]])
    volts = []
    for shift in (0.0, AWAY):

        def moved(times: ArrayLike, shift: float = shift) -> BoatState:
            state = motion(times)
            return BoatState(state.position + np.array((shift - AWAY, 0.0, 0.0)), state.attitude)

        fired = pulses(Installation(radar, made.platform, moved), TURN)
        volts.append(
            scatterer_voltages(
                Installation(radar), fired, place + np.array((shift, 0.0, 0.0)), np.ones(2), np.zeros((2, 3))
            )
        )
    assert np.abs(volts[0]).max() > 0.0
    assert_allclose(volts[1], volts[0], rtol=0.0, atol=1e-6 * np.abs(volts[0]).max())


def test_after_12_hours_pulses_are_fired_where_they_were() -> None:
    made = scene(**WINDOW)
    first, late = pulses(Installation(made.radar), 0), pulses(Installation(made.radar), HALF_DAY)
    ulp = np.spacing(43_200.0)
    assert_allclose(late.time - 43_200.0, first.time, rtol=0.0, atol=2.0 * ulp)
    assert_allclose(late.sweep, first.sweep, rtol=0.0, atol=2.0 * 360.0 * ulp)
    assert_array_equal(late.transmitter, first.transmitter)


def test_after_12_hours_the_mesh_has_the_same_lines() -> None:
    made = scene(**WINDOW, tracing__columns_per_beam=4)
    grids = [polar_grid(Installation(made.radar), made.meshing, turn) for turn in (0, HALF_DAY)]
    assert grids[0].sweep.size == grids[1].sweep.size
    assert_allclose(grids[1].time - 43_200.0, grids[0].time, rtol=0.0, atol=2.0 * np.spacing(43_200.0))
    assert_array_equal(grids[1].circle_azimuth, grids[0].circle_azimuth)


def test_after_12_hours_a_scatterer_at_rest_echoes_to_the_bit_of_its_phase() -> None:
    """The boat stands still, so that turn 43200 is turn 0: times differ by rounding alone, 7e-12 s of 360°/s."""
    made = scene(**WINDOW, radar__noise=False)
    place, area, still = np.array([[-60.0, -6.0, 0.3]]), np.ones(1), np.zeros((1, 3))
    first, late = (
        scatterer_voltages(Installation(made.radar), pulses(Installation(made.radar), t), place, area, still)
        for t in (0, HALF_DAY)
    )
    assert np.abs(first).max() > 0.0
    assert_allclose(late, first, rtol=0.0, atol=1e-6 * np.abs(first).max())


def test_after_12_hours_a_flat_sea_echoes_with_the_same_power() -> None:
    """Other speckle, the same mean: over 80 dwells' worth of independent gates, within four standard errors."""
    made = scene(**WINDOW, radar__noise=False, tracing__facet_m=1.0, scattering__nrcs="constant")
    simulator = Simulator(made)
    power = [np.abs(simulator.turn(turn).echoes["voltage"].values[:, 0]) ** 2 for turn in (0, HALF_DAY)]
    # Scaled by R⁻³ and the pattern they are alike; of some 4 beams × 56 gates the mean scatters by 1/√200.
    level = np.array([each.mean(axis=0) for each in power])
    ratio = np.log(level[1] / level[0])
    assert abs(ratio.mean()) < 4.0 * ratio.std() / np.sqrt(ratio.size / 2.7)


def test_the_mesh_of_a_boat_far_away_is_as_wide_as_at_home() -> None:
    made = scene("tiny", **WINDOW, platform__speed_m_s=30.0)
    mast = Installation(made.radar, made.platform)
    water = sea.realize(made.sea, 5)
    home, away = (polar_grid(mast, made.meshing, turn) for turn in (0, 340))
    assert away.pose.origin[:, 1].min() > 1e4
    assert_array_equal(home.ground_range, away.ground_range)
    assert_allclose(home.azimuth, away.azimuth, rtol=0.0, atol=1e-9)
    mesh = surface_mesh(away, *sea_on_grid(water, away))
    rays, horizon = (light(name, mesh, made) for name in TRACERS)
    assert np.mean(rays != horizon) < 1e-4
