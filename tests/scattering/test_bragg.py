"""First-order and two-scale Bragg scattering against check values, vector algebra and the laws of symmetry."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from seamap_rt.conventions import SPEED_OF_LIGHT, db
from seamap_rt.scattering import bragg_coefficients, fresnel, nrcs_bragg, nrcs_two_scale, permittivity_meissner_wentz12
from seamap_rt.scattering.bragg import bragg_speed
from seamap_rt.sea.spectra import elfouhaily97, elfouhaily97_spreading

F = 10e9
K = 2.0 * np.pi * F / SPEED_OF_LIGHT
EPS = complex(permittivity_meissner_wentz12(F, 20.0, 35.0))
UPRIGHT = st.floats(0.2, 1.55)
SLOPE = st.floats(-0.5, 0.5)
ANGLE = st.floats(-10.0, 10.0)


def two_scale(incidence, slope_range, slope_cross, wind_angle, polarization="VV", wind_speed=10.0):
    return nrcs_two_scale(
        incidence,
        slope_range,
        slope_cross,
        wind_angle,
        frequency_hz=F,
        wind_speed=wind_speed,
        permittivity=EPS,
        polarization=polarization,
    )


def plane_spectrum(k, angle_to_wind, wind_speed: float):
    """Ψ(k, φ) = S(k)/k · (1 + Δ(k) cos 2φ)/2π [m⁴]."""
    spread = 1.0 + elfouhaily97_spreading(k, wind_speed) * np.cos(2.0 * np.asarray(angle_to_wind))
    return elfouhaily97(k, wind_speed) / (2.0 * np.pi * k) * spread


def mean_square_slope(wind_speed: float) -> float:
    """∫ k² S dk of the whole wind sea."""
    k = np.geomspace(1e-4, 1e5, 50_001)
    return float(np.trapezoid(k**3 * elfouhaily97(k, wind_speed), np.log(k)))


def by_vectors(theta: float, p: float, q: float, wind_angle: float, polarization: str, wind_speed: float) -> float:
    """The same law from vectors alone: x outward, y clockwise, z up; polarizations from cross products."""
    to_radar = np.array([-np.sin(theta), 0.0, np.cos(theta)])
    normal = np.array([-p, -q, 1.0]) / np.sqrt(1.0 + p * p + q * q)
    cos_local = float(normal @ to_radar)
    if cos_local <= 0.0:
        return 0.0
    local = np.arccos(cos_local)
    g_hh, g_vv = bragg_coefficients(local, EPS)
    h = np.cross([0.0, 0.0, 1.0], to_radar)
    v = np.cross(to_radar, h)
    h_local = np.cross(normal, to_radar)
    e = (h if polarization == "HH" else v) / np.linalg.norm(h if polarization == "HH" else v)
    share_h = float(e @ h_local) ** 2 / float(h_local @ h_local)
    g = share_h * g_hh + (1.0 - share_h) * g_vv
    bragg = -(to_radar - cos_local * normal)  # outward, in the facet
    down_range = np.array([1.0, 0.0, p]) / np.sqrt(1.0 + p * p)
    clockwise = np.cross(normal, down_range)
    azimuth = wind_angle + np.arctan2(bragg @ clockwise, bragg @ down_range)
    psi = plane_spectrum(2.0 * K * np.sin(local), azimuth, wind_speed)
    first_order = 16.0 * np.pi * K**4 * cos_local**4 * abs(g) ** 2 * psi
    ceiling = abs(fresnel(0.0, EPS)[0]) ** 2 / mean_square_slope(wind_speed)
    return float(first_order / (1.0 + first_order / ceiling))


@pytest.mark.parametrize(("grazing_deg", "hh", "vv"), [(1.0, 0.99590, 102.255), (45.0, 0.84684, 2.16935)])
def test_coefficients_meet_the_check_values(grazing_deg: float, hh: float, vv: float) -> None:
    g_hh, g_vv = bragg_coefficients(np.radians(90.0 - grazing_deg), EPS)
    np.testing.assert_allclose([abs(g_hh), abs(g_vv)], [hh, vv], rtol=6e-6)  # as printed


@given(incidence=st.floats(0.0, np.pi / 2.0))
def test_vv_is_never_below_hh_and_they_meet_at_the_vertical(incidence: float) -> None:
    g_hh, g_vv = bragg_coefficients(incidence, EPS)
    assert abs(g_vv) >= abs(g_hh) * (1.0 - 1e-12)
    np.testing.assert_allclose(*bragg_coefficients(0.0, EPS), rtol=1e-13)


def test_perfect_conductor_limit() -> None:
    # ε → −j∞: g_hh → 1 and g_vv → (1 + sin²θ)/cos²θ, Rice's coefficients, with an error of order 1/√|ε|
    theta = np.radians([10.0, 30.0, 50.0])
    g_hh, g_vv = bragg_coefficients(theta, -1e12j)
    np.testing.assert_allclose(np.abs(g_hh), 1.0, rtol=1e-5)
    np.testing.assert_allclose(np.abs(g_vv), (1.0 + np.sin(theta) ** 2) / np.cos(theta) ** 2, rtol=1e-5)


def test_first_order_formula_by_hand() -> None:
    # at 45°: 16π k⁴/4 · |g|² · Ψ, Ψ = 1e-14 m⁴
    expected = 4.0 * np.pi * K**4 * np.array([0.84684, 2.16935]) ** 2 * 1e-14
    found = [nrcs_bragg(np.pi / 4.0, F, EPS, 1e-14, polarization) for polarization in ("HH", "VV")]
    np.testing.assert_allclose(found, expected, rtol=2e-5)  # the check values' last digit


@pytest.mark.parametrize("polarization", ["HH", "VV"])
def test_flat_facet_is_first_order_bragg(polarization: str) -> None:
    theta = np.radians(np.linspace(40.0, 89.5, 60))  # σ_B is there 17 dB below the ceiling at least
    psi = plane_spectrum(2.0 * K * np.sin(theta), 0.6, 10.0)
    expected = nrcs_bragg(theta, F, EPS, psi, polarization)
    found = two_scale(theta, 0.0, 0.0, 0.6, polarization)
    assert np.all(found <= expected * (1.0 + 1e-4))  # 1e-4: the table's stated error
    np.testing.assert_allclose(found, expected, rtol=2e-2)  # the ceiling takes 2 % at 40°
    np.testing.assert_allclose(found[theta > 1.2], expected[theta > 1.2], rtol=4e-3)


@given(theta=UPRIGHT, p=SLOPE, q=SLOPE, wind=ANGLE, polarization=st.sampled_from(["HH", "VV"]))
def test_tilted_facet_agrees_with_vector_algebra(
    theta: float, p: float, q: float, wind: float, polarization: str
) -> None:
    expected = by_vectors(theta, p, q, wind, polarization, 8.0)
    found = float(two_scale(theta, p, q, wind, polarization, 8.0))
    # 3e-3: the table near the normal; the floor: float32 at a local incidence within 1e-3 of 90°
    np.testing.assert_allclose(found, expected, rtol=3e-3, atol=1e-9)


def test_tilted_facets_agree_closely_with_vector_algebra_at_grazing() -> None:
    rng = np.random.default_rng(7)
    theta, p, q = rng.uniform(1.2, 1.56, 300), rng.normal(0.0, 0.15, 300), rng.normal(0.0, 0.15, 300)
    wind = rng.uniform(-np.pi, np.pi, 300)
    lit = np.cos(theta) + p * np.sin(theta) > 0.02
    for polarization in ("HH", "VV"):
        expected = [by_vectors(*each, polarization, 10.0) for each in zip(theta, p, q, wind, strict=True)]
        found = two_scale(theta, p, q, wind, polarization)
        np.testing.assert_allclose(found[lit], np.array(expected)[lit], rtol=2e-4)  # the table's 1e-4, and float32


@given(theta=UPRIGHT, p=SLOPE, q=SLOPE, wind=ANGLE)
def test_mirror_and_wind_reversal_change_nothing(theta: float, p: float, q: float, wind: float) -> None:
    for polarization in ("HH", "VV"):
        found = two_scale(theta, p, q, wind, polarization)
        np.testing.assert_allclose(two_scale(theta, p, -q, -wind, polarization), found, rtol=1e-4, atol=1e-12)
        np.testing.assert_allclose(two_scale(theta, p, q, wind + np.pi, polarization), found, rtol=1e-4, atol=1e-12)


def test_facets_seen_from_behind_are_dark_and_leaning_in_brightens() -> None:
    theta = np.radians(87.0)
    edge = -1.0 / np.tan(theta)  # the slope whose local incidence is 90°
    assert np.all(two_scale(theta, np.array([edge * 1.01, -0.2, -3.0]), 0.0, 0.0) == 0.0)
    for polarization in ("HH", "VV"):
        leaning = two_scale(theta, np.linspace(edge * 0.99, 0.6, 200), 0.0, 0.3, polarization)
        assert np.all(np.diff(leaning) > 0.0)
        assert leaning[0] < 1e-7  # continuous: it starts from 0


@pytest.mark.parametrize("wind_speed", [0.5, 3.0, 10.0, 40.0])
def test_ceiling_at_the_normal_is_smooth_and_the_same_for_both_polarizations(wind_speed: float) -> None:
    theta = np.linspace(0.0, 0.6, 2001)
    ceiling = abs(fresnel(0.0, EPS)[0]) ** 2 / mean_square_slope(wind_speed)
    hh, vv = (two_scale(theta, 0.0, 0.0, 0.0, polarization, wind_speed) for polarization in ("HH", "VV"))
    np.testing.assert_allclose(hh[0], vv[0], rtol=1e-5)
    for sigma in (hh, vv):
        assert np.all((sigma > 0.0) & (sigma <= ceiling * (1.0 + 1e-6)))
        assert np.max(np.abs(np.diff(db(sigma)))) < 0.15  # dB per 0.3 mrad: no step
        assert np.all(np.diff(sigma) <= 1e-3 * sigma[:-1])  # falls away from the normal


def test_grazing_level_of_a_tilted_sea() -> None:
    # Two-scale theory at U10 = 10 and 3° gives −48 dB HH and −27 dB VV unshadowed. It needs tilts: up-wind slope
    # variance 0.02 (the waves longer than a few Bragg lengths); the flat facet itself is 24 and 8.5 dB lower. 1 dB:
    # these are round figures.
    rng = np.random.default_rng(3)
    p, q = rng.normal(0.0, np.sqrt(0.02), 400_000), rng.normal(0.0, np.sqrt(0.015), 400_000)
    area = np.sqrt(1.0 + p * p + q * q)
    for polarization, level, flat in (("HH", -48.0, -72.03), ("VV", -27.0, -35.55)):
        mean = np.mean(two_scale(np.radians(87.0), p, q, 0.0, polarization) * area)
        np.testing.assert_allclose(db(mean), level, atol=1.0)
        np.testing.assert_allclose(db(two_scale(np.radians(87.0), 0.0, 0.0, 0.0, polarization)), flat, atol=0.01)


def test_vv_exceeds_hh_in_the_mean_and_wind_raises_both() -> None:
    theta, wind = np.radians(np.linspace(30.0, 89.0, 50)), 0.4
    assert np.all(two_scale(theta, 0.0, 0.0, wind, "VV") >= two_scale(theta, 0.0, 0.0, wind, "HH"))
    levels = [two_scale(1.4, 0.05, 0.02, wind, "VV", speed) for speed in (2.0, 5.0, 10.0, 20.0)]
    assert np.all(np.diff(levels) > 0.0)


def test_shapes_broadcast_and_float32_is_enough() -> None:
    theta = np.linspace(1.0, 1.5, 40)
    single = two_scale(theta.astype(np.float32)[:, None], np.float32(0.1), np.zeros(3, np.float32), 0.2)
    assert single.shape == (40, 3)
    assert single.dtype == np.float32
    np.testing.assert_allclose(single[:, 0], two_scale(theta, 0.1, 0.0, 0.2), rtol=1e-5)
    assert two_scale(1.0, 0.0, 0.0, 0.0).shape == ()
    assert two_scale(np.zeros(0), 0.0, 0.0, 0.0).shape == (0,)
    many = two_scale(np.full(70_001, 1.3), 0.1, 0.1, 0.0)  # several blocks
    np.testing.assert_array_equal(many, many[0])


def test_unknown_polarization_is_refused() -> None:
    with pytest.raises(ValueError, match="polarization"):
        two_scale(1.0, 0.0, 0.0, 0.0, "HV")
    with pytest.raises(ValueError, match="polarization"):
        nrcs_bragg(1.0, F, EPS, 1e-14, "vv")


def test_bragg_waves_of_x_band_run_at_23_cm_a_second() -> None:
    assert bragg_speed(10e9) == pytest.approx(0.231, abs=0.001)  # 15 mm long, near the slowest of all
