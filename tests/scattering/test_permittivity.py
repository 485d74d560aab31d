"""Sea water's permittivity and reflection: check values, energy, limits."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from seamap_rt.scattering import fresnel, permittivity_meissner_wentz12
from seamap_rt.scattering.permittivity import PERMITTIVITIES, permittivity_klein_swift77, permittivity_meissner_wentz04

EACH = pytest.mark.parametrize("permittivity", PERMITTIVITIES.values(), ids=PERMITTIVITIES.keys())


@pytest.mark.parametrize(
    ("name", "real", "imaginary"),
    [("klein_swift77", 55.85, -37.71), ("meissner_wentz04", 55.94, -37.00), ("meissner_wentz12", 55.06, -37.51)],
)
def test_sea_water_at_10_ghz_meets_the_check_value(name: str, real: float, imaginary: float) -> None:
    eps = PERMITTIVITIES[name](10e9, 20.0, 35.0)
    np.testing.assert_allclose([eps.real, eps.imag], [real, imaginary], atol=0.005)  # as printed


def test_the_models_agree_on_fresh_water() -> None:
    frequency, temperature = np.geomspace(1e9, 35e9, 60)[:, None], np.linspace(-2.0, 29.0, 32)
    single = permittivity_klein_swift77(frequency, temperature, 0.0)
    first = permittivity_meissner_wentz04(frequency, temperature, 0.0)
    second = permittivity_meissner_wentz12(frequency, temperature, 0.0)
    np.testing.assert_allclose(first, second, rtol=1e-14)  # one law: only the salt was fitted again
    # one relaxation against two: 3.1 % at 35 GHz and −2 °C, where pure water's second relaxation shows
    assert np.max(np.abs(single / second - 1.0)) < 0.035


def test_klein_and_swift_hold_as_far_as_they_are_let() -> None:
    temperature, salinity = np.linspace(-2.0, 34.0, 37)[:, None], np.linspace(0.0, 40.0, 41)
    # 8.2 % and 4.5 % measured, both at −2 °C and 40 psu, the corner: the docstring's 9 and 5 %
    for highest, tolerance in ((35e9, 0.09), (10e9, 0.05)):
        frequency = np.geomspace(1e9, highest, 40)[:, None, None]
        ours = permittivity_klein_swift77(frequency, temperature, salinity)
        newer = permittivity_meissner_wentz12(frequency, temperature, salinity)
        assert np.max(np.abs(ours / newer - 1.0)) < tolerance


@EACH
def test_salt_adds_loss(permittivity: Callable) -> None:
    # up to 20 GHz; beyond it salt's shorter relaxation takes back what its ions add
    loss = -permittivity(np.geomspace(1e9, 20e9, 30)[:, None], 20.0, np.linspace(0.0, 40.0, 81)).imag
    assert np.all(np.diff(loss, axis=1) > 0.0)


@EACH
def test_conductivity_rules_at_low_frequency(permittivity: Callable) -> None:
    # Sea water of 35 psu and 15 °C conducts 4.2914 S/m (PSS-78). Of the loss at 1 GHz the relaxation adds no more
    # than pure water's 4 to 5 of 81, and older fits conduct up to 1 % more or less: within 2 %.
    ions = permittivity(1e9, 15.0, 0.0).imag - permittivity(1e9, 15.0, 35.0).imag
    np.testing.assert_allclose(ions * 2.0 * np.pi * 1e9 * 8.8541878e-12, 4.2914, rtol=0.02)


@EACH
def test_pseudo_brewster_angle(permittivity: Callable) -> None:
    # |r_v|² of a good dielectric is least near tan ψ = |ε|^(−1/2): 7.0° at |ε| = 67; the loss moves it by 0.01°
    eps = complex(permittivity(10e9, 20.0, 35.0))
    psi = np.linspace(1.0, 15.0, 2801)
    _, r_v = fresnel(np.radians(90.0 - psi), eps)
    np.testing.assert_allclose(psi[np.argmin(np.abs(r_v))], np.degrees(np.arctan(abs(eps) ** -0.5)), atol=0.02)
    np.testing.assert_allclose(np.min(np.abs(r_v)), 0.147, atol=0.003)  # 0.145 to 0.149: the models' spread


@pytest.mark.parametrize(("grazing_deg", "h", "v"), [(1.0, 0.9959, 0.7591), (5.7, 0.9769, 0.1798)])
def test_reflection_meets_the_check_values(grazing_deg: float, h: float, v: float) -> None:
    r_h, r_v = fresnel(np.radians(90.0 - grazing_deg), permittivity_meissner_wentz12(10e9, 20.0, 35.0))
    np.testing.assert_allclose([abs(r_h), abs(r_v)], [h, v], atol=5e-5)  # as printed


@pytest.mark.parametrize(
    ("name", "highest", "warmest"),
    [("klein_swift77", 35e9, 34.0), ("meissner_wentz04", 90e9, 29.0), ("meissner_wentz12", 90e9, 34.0)],
)
@given(
    frequency=st.floats(0.0, 1.0),  # of each model's own range
    temperature=st.floats(0.0, 1.0),
    salinity=st.floats(0.0, 40.0),
    incidence=st.floats(0.0, np.pi / 2.0),
)
def test_water_absorbs_and_no_reflection_exceeds_one(
    name: str, highest: float, warmest: float, frequency: float, temperature: float, salinity: float, incidence: float
) -> None:
    eps = PERMITTIVITIES[name](1e9 + frequency * (highest - 1e9), -2.0 + temperature * (warmest + 2.0), salinity)
    assert eps.real > 1.0
    assert eps.imag < 0.0  # e^{+jωt}: a lossy medium lies below the real axis
    for r in fresnel(incidence, eps):
        assert abs(r) <= 1.0 + 1e-12  # rounding


@EACH
def test_reflection_at_the_two_ends(permittivity: Callable) -> None:
    eps = permittivity(10e9, 20.0, 35.0)
    r_h, r_v = fresnel([0.0, np.pi / 2.0], eps)
    np.testing.assert_allclose(r_v[0], -r_h[0], rtol=1e-14)  # so HH = VV straight down
    np.testing.assert_allclose([r_h[1], r_v[1]], -1.0, atol=1e-14)
    np.testing.assert_allclose(fresnel(0.7, 1.0), 0.0, atol=1e-15)  # air on air


def test_brewster_angle_of_a_lossless_medium() -> None:
    _, r_v = fresnel(np.arctan(3.0), 9.0)
    np.testing.assert_allclose(abs(r_v), 0.0, atol=1e-14)


def test_pure_water_static_value_and_continuity_at_30_degrees() -> None:
    # 1 GHz, far below relaxation: within 1 % of the static permittivity of water at 25 °C, 78.4 (CRC Handbook)
    np.testing.assert_allclose(permittivity_meissner_wentz12(1e9, 25.0, 0.0).real, 78.4, rtol=0.01)
    below, above = permittivity_meissner_wentz12(10e9, [30.0, np.nextafter(30.0, 31.0)], 35.0)
    np.testing.assert_allclose(below, above, rtol=1e-3)  # the two branches of b1 meet, as far as they were printed


@pytest.mark.parametrize(
    ("name", "arguments"),
    [
        ("frequency_hz", (0.5e9, 20.0, 35.0)),
        ("frequency_hz", (10.0, 20.0, 35.0)),
        ("temperature_c", (10e9, [20.0, 293.0], 35.0)),
        ("salinity_psu", (10e9, 20.0, np.nan)),
    ],
)
@EACH
def test_refuses_what_was_never_measured(permittivity: Callable, name: str, arguments: tuple) -> None:
    with pytest.raises(ValueError, match=f"^{name} = .*must be .*; give") as error:
        permittivity(*arguments)
    assert "\n" not in str(error.value)


@pytest.mark.parametrize(
    ("name", "inside", "outside"),
    [
        ("klein_swift77", (35e9, 34.0, 40.0), (36e9, 20.0, 35.0)),
        ("meissner_wentz04", (90e9, 29.0, 40.0), (10e9, 30.0, 35.0)),
        ("meissner_wentz04", (1e9, -2.0, 0.0), (10e9, -2.1, 35.0)),  # where sea water freezes
        ("meissner_wentz12", (90e9, 34.0, 40.0), (91e9, 20.0, 35.0)),
    ],
)
def test_each_has_its_own_range(name: str, inside: tuple, outside: tuple) -> None:
    assert np.isfinite(PERMITTIVITIES[name](*inside))
    with pytest.raises(ValueError, match="must be"):
        PERMITTIVITIES[name](*outside)
