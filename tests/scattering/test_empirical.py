"""The NRL 2012 clutter model: values by hand, its distance from Nathanson's table, its limits."""

from __future__ import annotations

import numpy as np
import pytest

from seamap_rt.conventions import db
from seamap_rt.scattering import nrcs_gregers_hansen12, sea_state_from_wind


def test_check_values() -> None:
    np.testing.assert_allclose(nrcs_gregers_hansen12(10.0, 2.0, 30e9, "HH"), 2.15550e-4, rtol=1e-5)  # by hand
    # VV, sea state 3, 3°, 10 GHz, worked term by term with 30 digits:
    # −50.796 − 33.2402587 + 29.6279/3.85 + 21.588 · 4^(1/2.354) + 0.01899 = −37.4008840 dB
    np.testing.assert_allclose(nrcs_gregers_hansen12(3.0, 3.0, 10e9, "VV"), 1.81933044e-4, rtol=1e-8)


def test_steepness_at_the_bottom() -> None:
    low = db(nrcs_gregers_hansen12([0.1, 0.2], 3.0, 10e9, "VV"))
    np.testing.assert_allclose(low[1] - low[0], 5.7, atol=0.05)


def test_clutter_grows_with_the_sea_and_with_grazing() -> None:
    grazing = np.geomspace(0.1, 60.0, 200)
    for polarization in ("HH", "VV"):
        sigma = nrcs_gregers_hansen12(grazing[:, None], np.arange(7.0), 10e9, polarization)
        assert sigma.shape == (200, 7)
        assert np.all(np.diff(sigma, axis=1) > 0.0)
        assert np.all(sigma < 1.0)
        assert np.all(np.diff(sigma[:, :6], axis=0) > 0.0)  # at sea state 6 the formula dips in HH, 5° to 12°


def test_sea_state_of_the_wind() -> None:
    np.testing.assert_allclose(sea_state_from_wind([0.0, 3.16, 10.0]), [0.0, 1.0, (10.0 / 3.16) ** 1.25])


@pytest.mark.parametrize(
    ("name", "arguments"),
    [
        ("grazing_deg", (0.09, 3.0, 10e9, "VV")),
        ("grazing_deg", ([5.0, 61.0], 3.0, 10e9, "HH")),
        ("grazing_deg", (np.nan, 3.0, 10e9, "HH")),
        ("sea_state", (5.0, 6.5, 10e9, "VV")),
        ("frequency_hz", (5.0, 3.0, 36e9, "VV")),
        ("frequency_hz", (5.0, 3.0, 10.0, "VV")),
        ("polarization", (5.0, 3.0, 10e9, "HV")),
    ],
)
def test_refuses_what_was_never_fitted(name: str, arguments: tuple) -> None:
    with pytest.raises(ValueError, match=name) as error:
        nrcs_gregers_hansen12(*arguments)
    assert "\n" not in str(error.value)


def test_clipping_and_extrapolating_are_asked_for() -> None:
    edge = nrcs_gregers_hansen12([0.1, 60.0], 3.0, 10e9, "VV")
    np.testing.assert_array_equal(nrcs_gregers_hansen12([-2.0, 88.0], 3.0, 10e9, "VV", clipped=True), edge)
    beyond = nrcs_gregers_hansen12(0.05, 7.0, 40e9, "VV", extrapolate=True)
    assert 0.0 < beyond < 1.0
    with pytest.raises(ValueError, match="grazing_deg"):
        nrcs_gregers_hansen12(0.0, 3.0, 10e9, "VV", extrapolate=True)
    with pytest.raises(ValueError, match="sea_state"):
        nrcs_gregers_hansen12(0.0, 7.0, 10e9, "VV", clipped=True)
