"""Sea water's permittivity and reflection: check values, energy, limits."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from seamap_rt.scattering import fresnel, permittivity_meissner_wentz12


def test_sea_water_at_10_ghz_meets_the_check_value() -> None:
    eps = permittivity_meissner_wentz12(10e9, 20.0, 35.0)
    np.testing.assert_allclose([eps.real, eps.imag], [55.06, -37.51], atol=0.005)  # as printed


@pytest.mark.parametrize(("grazing_deg", "h", "v"), [(1.0, 0.9959, 0.7591), (5.7, 0.9769, 0.1798)])
def test_reflection_meets_the_check_values(grazing_deg: float, h: float, v: float) -> None:
    r_h, r_v = fresnel(np.radians(90.0 - grazing_deg), permittivity_meissner_wentz12(10e9, 20.0, 35.0))
    np.testing.assert_allclose([abs(r_h), abs(r_v)], [h, v], atol=5e-5)  # as printed


@given(
    frequency=st.floats(1e9, 90e9),
    temperature=st.floats(-2.0, 34.0),
    salinity=st.floats(0.0, 40.0),
    incidence=st.floats(0.0, np.pi / 2.0),
)
def test_water_absorbs_and_no_reflection_exceeds_one(
    frequency: float, temperature: float, salinity: float, incidence: float
) -> None:
    eps = permittivity_meissner_wentz12(frequency, temperature, salinity)
    assert eps.real > 1.0
    assert eps.imag < 0.0  # e^{+jωt}: a lossy medium lies below the real axis
    for r in fresnel(incidence, eps):
        assert abs(r) <= 1.0 + 1e-12  # rounding


def test_reflection_at_the_two_ends() -> None:
    eps = permittivity_meissner_wentz12(10e9, 20.0, 35.0)
    r_h, r_v = fresnel([0.0, np.pi / 2.0], eps)
    np.testing.assert_allclose(r_v[0], -r_h[0], rtol=1e-14)
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
def test_refuses_what_was_never_measured(name: str, arguments: tuple) -> None:
    with pytest.raises(ValueError, match=name) as error:
        permittivity_meissner_wentz12(*arguments)
    assert "\n" not in str(error.value)
