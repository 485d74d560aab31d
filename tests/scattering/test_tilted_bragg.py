"""Bragg scattering averaged over unresolved tilts, against a plain sum over tilts by vector algebra."""

from __future__ import annotations

import numpy as np
import pytest

from seamap_rt.conventions import SPEED_OF_LIGHT
from seamap_rt.scattering.bragg import bragg_coefficients, nrcs_bragg
from seamap_rt.scattering.composite import nrcs_composite
from seamap_rt.scattering.permittivity import permittivity_meissner_wentz12
from seamap_rt.scattering.short_waves import ShortWaves

F = 10e9
K = 2.0 * np.pi * F / SPEED_OF_LIGHT
EPS = complex(permittivity_meissner_wentz12(F, 20.0, 35.0))
WAVES = ShortWaves(10.0, 3.9)


def bragg(theta, p, q, wind, polarization, waves=WAVES, frequency=F):
    asked = {"frequency_hz": frequency, "permittivity": EPS, "polarization": polarization, "waves": waves}
    return nrcs_composite(theta, p, q, wind, **asked, breaking=False).bragg.astype(np.float64)


def unit(vector):
    return vector / np.linalg.norm(vector, axis=-1, keepdims=True)


def dot(first, second):
    return np.sum(first * second, axis=-1)


def by_sum(theta, p, q, wind, polarization, waves=WAVES, frequency=F, steps=121):
    """The same mean from normals and cross products; x outward, y clockwise, z up, tilts up to 6 sigma."""
    wavenumber = 2.0 * np.pi * frequency / SPEED_OF_LIGHT
    divide = waves.divide(wavenumber)
    along, across = np.sqrt(waves.tilt_variances(divide))
    grid = np.linspace(-6.0, 6.0, steps)
    weight = np.exp(-0.5 * grid**2) / np.exp(-0.5 * grid**2).sum()
    s, c = np.meshgrid(grid * along, grid * across, indexing="ij")

    to_radar = np.array([-np.sin(theta), 0.0, np.cos(theta)])
    normal, down = unit(np.array([-p, -q, 1.0])), unit(np.array([1.0, 0.0, p]))
    clockwise = np.cross(normal, down)
    wind_axis = np.cos(wind) * down - np.sin(wind) * clockwise  # towards where the wind comes from
    cross_axis = np.sin(wind) * down + np.cos(wind) * clockwise
    tilted = unit(normal - s[..., None] * wind_axis - c[..., None] * cross_axis)
    area = 1.0 / dot(tilted, normal)

    bragg_facet = unit(dot(to_radar, normal) * normal - to_radar)  # outward, in the facet
    look = wind + np.arctan2(bragg_facet @ clockwise, bragg_facet @ down)
    cosine = dot(tilted, to_radar)
    lit = cosine > 1e-9
    seen = np.where(lit, cosine, 0.5)
    local = np.arccos(seen)
    vector = seen[..., None] * tilted - to_radar
    range_axis = unit(bragg_facet - (dot(tilted, bragg_facet) / dot(tilted, normal))[..., None] * normal)
    turn = np.arctan2(dot(vector, np.cross(tilted, range_axis)), dot(vector, range_axis))

    h = unit(np.cross([0.0, 0.0, 1.0], to_radar))
    e = h if polarization == "HH" else np.cross(to_radar, h)
    share = dot(unit(np.cross(tilted, to_radar)), e) ** 2
    g_hh, g_vv = bragg_coefficients(local, EPS)
    g = share * g_hh + (1.0 - share) * g_vv
    k_bragg = 2.0 * wavenumber * np.sin(local)
    psi = waves.roughness(k_bragg, divide) / (2.0 * np.pi * k_bragg)
    psi = psi * (1.0 + waves.contrast(k_bragg) * np.cos(2.0 * (look + turn)))
    sigma = np.where(lit, 16.0 * np.pi * wavenumber**4 * seen**4 * np.abs(g) ** 2 * psi, 0.0)
    return float(weight @ (sigma * area) @ weight)


VIEWS = [(0.3, 0.0, 0.0), (3.0, 0.05, 0.1), (3.0, -0.08, -0.15), (10.0, 0.2, 0.1), (35.0, -0.1, -0.2), (80.0, 0.1, 0.1)]


@pytest.mark.parametrize("polarization", ["HH", "VV"])
@pytest.mark.parametrize(("grazing", "p", "q"), VIEWS)
def test_the_table_is_the_sum_over_tilts(grazing, p, q, polarization):
    theta, winds = np.radians(90.0 - grazing), np.arange(4) * np.pi / 4.0 + 0.1
    expected = np.array([by_sum(theta, p, q, wind, polarization) for wind in winds])
    found = bragg(theta, p, q, winds, polarization)
    # 4 % of the mean over winds: the wind's 4φ, left out. In that mean it drops out; 1e-3: the table and float32.
    np.testing.assert_allclose(found, expected, rtol=0.0, atol=0.04 * expected.mean())
    np.testing.assert_allclose(found.mean(), expected.mean(), rtol=1e-3)


@pytest.mark.parametrize(("frequency", "wind_speed"), [(3e9, 20.0), (35e9, 2.0)])
@pytest.mark.parametrize("grazing", [1.0, 5.0, 20.0, 45.0, 70.0])
def test_the_tables_grid_is_fine_enough(grazing, frequency, wind_speed):
    """Of the steepest and the flattest short waves."""
    waves, winds = ShortWaves(wind_speed, 3.9), np.arange(4) * np.pi / 4.0 + 0.1
    view = np.radians(90.0 - grazing), 0.02, -0.03
    expected = [by_sum(*view, wind, "HH", waves, frequency) for wind in winds]
    found = bragg(*view, winds, "HH", waves, frequency)
    # 1.3e-3 seen squarely, where little of the roughness is left; 2e-4 elsewhere
    np.testing.assert_allclose(found.mean(), np.mean(expected), rtol=3e-3)


class Untilted(ShortWaves):
    """Short waves whose roughness stands upright."""

    def tilt_variances(self, divide):
        return 0.0, 0.0


@pytest.mark.parametrize("polarization", ["HH", "VV"])
def test_without_tilts_it_is_first_order_bragg(polarization):
    waves = Untilted(10.0, 3.9)
    theta = np.radians(90.0 - np.geomspace(0.5, 85.0, 60))
    k_bragg = 2.0 * K * np.sin(theta)
    psi = waves.roughness(k_bragg, waves.divide(K)) / (2.0 * np.pi * k_bragg)
    psi = psi * (1.0 + waves.contrast(k_bragg) * np.cos(2.0 * 0.4))
    expected = nrcs_bragg(theta, F, EPS, psi, polarization)
    # 6e-3: the spline between 400 incidences where VV vanishes at grazing; the stand-in tilt of 1e-4 adds to HH there
    np.testing.assert_allclose(bragg(theta, 0.0, 0.0, 0.4, polarization, waves), expected, rtol=6e-3)


def test_mirror_and_wind_reversal_change_nothing():
    rng = np.random.default_rng(1)
    theta, p, q = rng.uniform(0.0, 1.57, 2000), rng.normal(0.0, 0.2, 2000), rng.normal(0.0, 0.2, 2000)
    wind = rng.uniform(-np.pi, np.pi, 2000)
    for polarization in ("HH", "VV"):
        found = bragg(theta, p, q, wind, polarization)
        # float32 and the table: terms that cancel by half at most
        np.testing.assert_allclose(bragg(theta, p, -q, -wind, polarization), found, rtol=1e-4, atol=1e-10)
        np.testing.assert_allclose(bragg(theta, p, q, wind + np.pi, polarization), found, rtol=1e-4, atol=1e-10)


def test_vv_is_never_below_hh_on_facets_that_lean_along_the_look():
    theta, p, wind = np.radians(90.0 - np.geomspace(0.1, 88.0, 100))[:, None, None], np.linspace(-0.3, 0.3, 13), 0.7
    for wind_speed in (2.0, 10.0, 20.0):
        hh, vv = (bragg(theta, p[:, None], 0.0, wind, each, ShortWaves(wind_speed, 3.9)) for each in ("HH", "VV"))
        assert np.all(
            vv >= hh * 0.99
        )  # seen squarely the wind may favour HH's axis, by 1 % (the tilts' |g_vv|² − |g_hh|²)


def test_upwind_and_downwind_are_alike_and_above_crosswind():
    for polarization in ("HH", "VV"):
        up, cross, down = bragg(
            np.radians([87.0, 80.0, 45.0])[:, None], 0.0, 0.0, np.array([0.0, 0.5, 1.0]) * np.pi, polarization
        ).T
        np.testing.assert_allclose(up, down, rtol=1e-4)  # float32
        assert np.all(up > 1.3 * cross)  # Elfouhaily's (1 + Δ)/(1 − Δ) with Δ = 0.37 is 2.2, and tilts blur it
