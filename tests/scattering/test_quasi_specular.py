"""Mirrors: the slopes' density, its energy, and its limits."""

from __future__ import annotations

import numpy as np
import pytest

from seamap_rt.conventions import SPEED_OF_LIGHT
from seamap_rt.scattering.permittivity import fresnel, permittivity_meissner_wentz12
from seamap_rt.scattering.short_waves import ShortWaves
from seamap_rt.scattering.tilted_bragg import Mirror, mirror

F = 10e9
K = 2.0 * np.pi * F / SPEED_OF_LIGHT
EPS = complex(permittivity_meissner_wentz12(F, 20.0, 35.0))


def test_squarely_it_is_the_reflection_over_the_mean_square_slope():
    # Barrick 1968, equal variances: σ = |R|²/mss, and sec⁴θ exp(−tan²θ/mss) of that beside it
    isotropic = Mirror(0.6, 0.01, 0.01)
    theta = np.radians([0.0, 5.0, 15.0])
    found = isotropic.nrcs(np.cos(theta), np.zeros(3))
    np.testing.assert_allclose(found, 0.6 / 0.02 * np.exp(-(np.tan(theta) ** 2) / 0.02) / np.cos(theta) ** 4, rtol=1e-6)


def test_geometric_optics_loses_no_energy():
    # σ cos⁴θ/π is |R|² times the density of slopes: over the plane of slopes it makes |R|²
    uneven = Mirror(0.6, 0.012, 0.007)
    slope = np.linspace(-0.9, 0.9, 601)
    x, y = np.meshgrid(slope, slope)
    cosine = 1.0 / np.sqrt(1.0 + x**2 + y**2)
    double = np.cos(2.0 * np.arctan2(y, x))
    density = uneven.nrcs(cosine, double) * cosine**4 / np.pi
    np.testing.assert_allclose(density.sum() * (slope[1] - slope[0]) ** 2, 0.6, rtol=1e-6)  # 8σ of slope are summed
    np.testing.assert_allclose(np.sum(density * x**2) / density.sum(), 0.012, rtol=1e-6)  # along the wind


def test_constants_are_those_of_the_sea():
    waves = ShortWaves(10.0, 3.9)
    found = mirror(F, EPS, waves)
    along, across = waves.tilt_variances(waves.divide(K))
    np.testing.assert_allclose([found.along, found.across], [along, across], rtol=0.02)  # the lobe of 0.8 m: 1 %
    smooth = abs(fresnel(0.0, EPS)[0]) ** 2
    assert 0.5 * smooth < found.reflection < smooth  # 4 k² h² = 0.27
    np.testing.assert_allclose(
        found.reflection / smooth, np.exp(-4.0 * K**2 * waves.roughness_variance(K / 4.0)), rtol=1e-9
    )


@pytest.mark.parametrize("above", [20.0, 60.0, 200.0])
def test_a_mesh_that_resolves_all_tilts_leaves_its_own_lobe(above):
    found = mirror(F, EPS, ShortWaves(10.0, above))
    wavelength, half = SPEED_OF_LIGHT / F, np.pi / above
    lobe = wavelength**2 / (8.0 * np.pi * half**2)
    assert found.across > lobe
    peak = float(found.nrcs(np.array(1.0), np.array(0.0)))
    # what a flat square of that size mirrors at most, 4π L²/λ² per area
    assert 0.0 < peak < 4.0 * np.pi * half**2 / wavelength**2


def test_half_of_the_tilts_face_a_ray_at_the_facets_grazing():
    facing = Mirror(0.6, 0.01, 0.01).facing(np.array([-0.6, -0.1, 0.0, 0.1, 0.6, 1.0]))
    np.testing.assert_allclose(facing[2], 0.5, rtol=1e-6)
    np.testing.assert_allclose(facing[1] + facing[3], 1.0, rtol=1e-6)
    np.testing.assert_allclose(facing[3], 0.842569, rtol=1e-5)  # Φ(0.1/√0.99/0.1) = Φ(1.005038), from tables
    assert facing[0] < 1e-12
    assert facing[-1] == 1.0
