"""Facets along the ray, facets a thousand times as long as wide, and a single one that echoes.

Light on the first and on the smallest mesh are cases of `validation.hard_cases.light`, which `tests/validate` runs.
"""

from __future__ import annotations

import numpy as np
import pytest
from hard_surfaces import TRACERS, Height, light, rings, scene, trace
from numpy.testing import assert_allclose, assert_array_equal
from numpy.typing import NDArray

from seamap_rt import sea
from seamap_rt.echoes.turn import turn_voltages
from seamap_rt.mesh.surface import mesh_turn
from seamap_rt.radar.installation import Installation
from seamap_rt.radar.scan import pulses
from seamap_rt.simulation import Simulator

ULP = np.finfo(np.float64).eps
LOWER = 4.9  # m, the lower antenna's height
TOP, START = 2.0, 20.0  # m: the ramp's height and where it begins


def ramp(tip: float) -> Height:
    """A wall, and behind it a slope down to the sea along the lower antenna's own ray, tipped by `tip` of itself."""
    slope = (LOWER - TOP) / START * (1.0 + tip)

    def height(r: NDArray[np.float64]) -> NDArray[np.float64]:
        return np.where(r < START - 1e-9, 0.0, np.maximum(TOP - slope * (r - START), 0.0))

    return height


@pytest.mark.parametrize("tip", [-ULP, 0.0, ULP])
def test_facets_along_the_ray_echo_next_to_nothing(tip: float) -> None:
    """Under a grazing angle that is rounding alone, theory is asked for its limit: finite, and nothing beside the sea
    in front of the wall, which is seen under 14°."""
    made = scene(
        radar__sector_deg=[90.0, 92.0], radar__range_m=[15.0, 60.0], tracing__facet_m=0.5, scattering__sea_spikes=False
    )
    simulator = Simulator(made)
    facets, returns, _ = simulator.light(0, mesh=rings(ramp(tip), made))
    assert np.isfinite(returns.rcs).all()
    assert (returns.rcs >= 0.0).all()
    per_area = returns.rcs / facets.horizontal_area
    ridge = (facets.distance > START + 1.0) & (facets.distance < START + 10.0)
    before = (facets.distance > START - 5.0) & (facets.distance < START - 1.0)
    assert per_area[:, before].mean() > 0.0
    assert per_area[:, ridge].mean() < 0.1 * per_area[:, before].mean()
    volts = turn_voltages(
        facets, returns.rcs, simulator.installation, pulses(simulator.installation, 0), 1, 0.01, motion=None
    )
    assert np.isfinite(volts).all()


@pytest.mark.parametrize("tilt", [0.0, 30.0, -30.0])
def test_slivers_about_the_masts_foot(tilt: float) -> None:
    """64 columns a beam of 0.5°: at 1 m a facet is 0.14 mm wide and 0.5 m long; the antennas lean out over them.

    At 30° and 4 m the upper one stands over the first rung to the bit. Sky is above all that is in front of it.
    """
    made = scene(
        "flat",
        radar__sector_deg=[90.0, 90.5],
        radar__range_m=[5.0, 20.0],
        radar__baseline_m=4.0,
        radar__tilt_deg=tilt,
        radar__antenna__azimuth_beamwidth_deg=0.5,
        radar__antenna__width_m=6.0,
        retrieval__cell_azimuth_deg=0.5,
        retrieval__ground_m=3.0,
        tracing__facet_m=0.5,
        tracing__columns_per_beam=64,
    )
    mesh = mesh_turn(sea.realize(made.sea, 1), made.radar, made.meshing, 0)
    facets = mesh.facets
    narrowest = np.radians(mesh.grid.spacing_deg)
    assert narrowest < 1.4e-4
    # Areas of triangles between rungs, whose sum is that of the polygon: sin α/2 per column.
    ends = mesh.grid.ground_range[[0, -1]] ** 2
    assert_allclose(facets.horizontal_area.sum(), 0.5 * np.sin(narrowest) * (ends[1] - ends[0]), rtol=1e-13)
    for field in (facets.distance, facets.slope_look, facets.slope_cross, facets.height):
        assert np.isfinite(field).all()
    for name in TRACERS:
        lit = light(name, mesh, made)
        for antenna in (0, 1):
            expected = facets.distance > mesh.grid.antenna_positions[0, antenna, 0]
            assert_array_equal(lit[antenna], np.broadcast_to(expected, lit[antenna].shape))


def test_slivers_of_a_rough_sea_are_lit_as_the_horizon_has_them() -> None:
    """Rays through needles 1 : 1000, out to where they are facets again."""
    made = scene(
        "tiny",
        radar__sector_deg=[260.0, 260.5],
        radar__range_m=[5.0, 100.0],
        radar__height_m=3.0,
        radar__baseline_m=3.0,
        radar__tilt_deg=-20.0,
        radar__antenna__azimuth_beamwidth_deg=0.5,
        radar__antenna__width_m=6.0,
        retrieval__cell_azimuth_deg=0.5,
        scattering__extrapolate=True,
        tracing__facet_m=0.25,
        tracing__columns_per_beam=64,
    )
    mesh = mesh_turn(sea.realize(made.sea, 3), made.radar, made.meshing, 0)
    rays, horizon = (light(name, mesh, made) for name in TRACERS)
    assert 0.1 < horizon.mean() < 0.95
    # A leaning antenna does not stand in the facets' planes by fractions of a column: 1.5 m × 1e-4.
    assert np.mean(rays != horizon) < 1e-3


def test_a_single_facet_that_echoes_is_a_point() -> None:
    """All others silent: its echo is that of a scatterer in its place, through the whole chain."""
    made = scene(
        radar__sector_deg=[90.0, 93.6],
        radar__range_m=[15.0, 60.0],
        radar__noise=False,
        tracing__facet_m=1.0,
        scattering__nrcs="constant",
    )
    facets = trace("horizon", rings(np.zeros_like, made), made)
    rcs = np.zeros(facets.height.shape, dtype=np.float32)
    column, facet = facets.grid.columns // 2, int(np.argmin(np.abs(facets.distance - 37.0)))
    rcs[column, facet] = 2.0
    fired = pulses(Installation(made.radar), 0)
    volts = turn_voltages(facets, rcs, Installation(made.radar), fired, 1, np.inf)
    power = np.sum(np.abs(volts[:, 0].astype(np.complex128)) ** 2, axis=0)
    gate = 15.0 + 1.5 * int(power.argmax())
    assert abs(gate - np.hypot(facets.distance[facet], 5.0)) < 0.75 + 0.02  # the nearest gate; antennas are 0.2 m apart
    assert np.isfinite(volts).all()
    assert power[np.abs(15.0 + 1.5 * np.arange(power.size) - gate) > 7.5].max() < 1e-9 * power.max()
