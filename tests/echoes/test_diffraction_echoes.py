"""Echoes of facets that the field reaches over an edge: both receivers, their speckle mean, and no change without."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from numpy.typing import NDArray

from seamap_rt.conventions import SPEED_OF_LIGHT, radar_wavenumber
from seamap_rt.echoes import expected_look_gates, turn_voltages
from seamap_rt.echoes.paths import facet_paths
from seamap_rt.mesh import SurfaceMesh, polar_grid, surface_mesh
from seamap_rt.radar.installation import Installation
from seamap_rt.radar.scan import pulses
from seamap_rt.settings import RadarSettings, TracingSettings
from seamap_rt.tracing import Illumination
from seamap_rt.tracing.diffraction import diffract
from seamap_rt.tracing.horizon import trace_horizon

RIDGE, HEIGHT = 25.0, 2.0  # m: what lies from 25 to 42 m is dark


def radar_of(**others) -> RadarSettings:
    return RadarSettings.model_validate(
        {"noise": False, "sector_deg": (0.0, 10.0), "range_m": (30.0, 60.0), "transmit": "switched", **others}
    )


def behind_a_ridge(radar: RadarSettings) -> tuple[SurfaceMesh, Illumination, NDArray[np.float32]]:
    """A flat sea with a ridge, its diffracted facets, and the same radar cross-section per area on all of them."""
    grid = polar_grid(Installation(radar), TracingSettings(), 0)
    shape = (grid.sweep.size, grid.ground_range.size)
    elevation = np.broadcast_to(np.where(np.abs(grid.ground_range - RIDGE) < 0.25, HEIGHT, 0.0), shape)
    mesh = surface_mesh(grid, elevation, np.zeros((*shape, 3), np.float32))
    facets = diffract(trace_horizon(mesh), mesh, SPEED_OF_LIGHT / radar.frequency_hz)
    rcs = np.broadcast_to(1e-3 * facets.horizontal_area, facets.height.shape).astype(np.float32)
    return mesh, facets, rcs


@pytest.mark.parametrize("transmit", ["single", "switched"])
def test_field_of_one_everywhere_changes_nothing(transmit: str) -> None:
    radar = radar_of(transmit=transmit)
    _, facets, rcs = behind_a_ridge(radar)
    plain = replace(facets, lit=np.ones_like(facets.lit), field=None)
    bent = replace(facets, field=np.ones(facets.lit.shape, np.complex64))
    straight, over = (facet_paths(f, rcs, Installation(radar), slice(3, 9)) for f in (plain, bent))
    assert straight.amplitude.dtype == np.float32
    assert over.amplitude.dtype == np.complex64
    np.testing.assert_array_equal(over.amplitude, straight.amplitude)
    fired = pulses(Installation(radar), 0)
    voltages, same = (turn_voltages(f, rcs, Installation(radar), fired, 3, 0.01) for f in (plain, bent))
    np.testing.assert_array_equal(same, voltages)
    expected, other = (expected_look_gates(f, rcs, Installation(radar), 1.8) for f in (plain, bent))
    np.testing.assert_allclose(other.power, expected.power, rtol=1e-12)
    np.testing.assert_allclose(other.covariance, expected.covariance, rtol=1e-12)


def test_amplitudes_go_out_and_back() -> None:
    radar = radar_of()
    _, facets, rcs = behind_a_ridge(radar)
    assert facets.field is not None
    columns = slice(2, 5)
    free = facet_paths(
        replace(facets, lit=np.ones_like(facets.lit), field=None), rcs, Installation(radar), columns
    ).amplitude
    found = facet_paths(facets, rcs, Installation(radar), columns).amplitude
    lower, upper = facets.field[:, columns].astype(np.complex128)
    for pair, ways in enumerate((lower * lower, lower * upper, upper * upper)):
        # complex64: some roundings of 6e-8
        np.testing.assert_allclose(found[pair], free[pair] * ways, rtol=1e-6, atol=1e-6 * float(free.max()))
    dark = ~facets.lit[:, columns].any(axis=0)
    assert np.mean(np.abs(found[1])[dark] > 0.0) > 0.9  # not gated by light


@pytest.mark.parametrize("transmit", ["single", "switched"])
def test_speckled_mean_is_the_expectation(transmit: str) -> None:
    """Power and covariance over a whole turn, in the shadow, at its edge and beyond.

    τc = 1 ms; 50 blocks of four looks are nearly independent, so their spread tells the standard error of the mean.
    """
    radar = radar_of(transmit=transmit, sector_deg=(0.0, 360.0), baseline_m=0.2)
    _, facets, rcs = behind_a_ridge(radar)
    got = expected_look_gates(facets, rcs, Installation(radar), 1.8)
    fired = pulses(Installation(radar), 0)
    voltages = turn_voltages(facets, rcs, Installation(radar), fired, seed=5, decorrelation_time_s=1e-3).astype(
        np.complex128
    )
    covariance = got.covariance.mean(axis=0)
    shape = (50, -1, voltages.shape[2])
    ratio = (voltages[:, 0] * voltages[:, 1].conj()).reshape(shape).mean(axis=1) / covariance
    for part, mean in ((ratio.real, 1.0), (ratio.imag, 0.0)):
        error = (part.mean(axis=0) - mean) / (part.std(axis=0, ddof=1) / np.sqrt(50))
        assert np.abs(error).max() < 4.0  # 21 gates of 49 degrees of freedom: one seed in 200 passes it
    used = got.power if transmit == "switched" else got.power[:1]
    for receiver in (0, 1):
        power = np.abs(voltages[:, receiver]).reshape(shape) ** 2
        ratio = power.mean(axis=1) / used.mean(axis=0)[receiver].mean(axis=0)
        error = (ratio.mean(axis=0) - 1.0) / (ratio.std(axis=0, ddof=1) / np.sqrt(50))
        assert np.abs(error).max() < 4.0
    # It would show if the detour's phase had the other sign, or none: in the shadow it is a radian and more.
    assert facets.field is not None
    sizes = replace(facets, field=np.abs(facets.field).astype(np.complex64))
    straight = expected_look_gates(sizes, rcs, Installation(radar), 1.8)
    turned = np.angle(covariance / straight.covariance.mean(axis=0))
    assert np.abs(turned).max() > 1.0


def test_in_deep_shadow_the_phase_is_the_ridges() -> None:
    """A single facet behind the ridge echoes: between the receivers stands the difference of the paths to its top.

    The field is that of the middle of the facet's step of range, a sixth of a metre beside its own point."""
    radar = radar_of(transmit="single")
    mesh, facets, rcs = behind_a_ridge(radar)
    chosen = int(np.argmin(np.abs(facets.distance - 28.0)))
    column = facets.grid.columns // 2
    lone = np.zeros_like(rcs)
    lone[column, chosen] = 1.0
    voltages = turn_voltages(facets, lone, Installation(radar), pulses(Installation(radar), 0), 1, np.inf).astype(
        np.complex128
    )
    place = np.unravel_index(np.abs(voltages[:, 0]).argmax(), voltages[:, 0].shape)
    found = np.angle(voltages[place[0], 0, place[1]] * voltages[place[0], 1, place[1]].conj())
    heights = mesh.grid.pose.positions[0, :, 2]
    rungs = mesh.grid.ground_range
    middle = 0.5 * (rungs[chosen // 2] + rungs[chosen // 2 + 1])
    places = ((RIDGE, HEIGHT), (facets.distance[chosen], 0.0), (middle, 0.0))
    to_top, to_facet, to_middle = (np.diff(np.hypot(x, heights - z))[0] for x, z in places)
    k = radar_wavenumber(radar.frequency_hz)
    # F's next term: 1/(πv²) of each antenna, v = 5 and 5 % apart; RIDGE's chord lies 0.2 mm within it.
    assert abs(np.angle(np.exp(1j * (found - k * (to_top + to_facet - to_middle))))) < 5e-3
    assert abs(k * (to_top - to_facet)) > 1.0
