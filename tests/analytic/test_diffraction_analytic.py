"""The knife edge's field against its integral, its symmetry, its limits and the recommendation's own curve."""

from __future__ import annotations

import numpy as np
import pytest
from scipy.integrate import quad

from validation.analytic.diffraction import knife_edge

V = np.concatenate((np.linspace(-6.0, 6.0, 241), [-40.0, 25.0, 40.0]))


def test_half_the_field_on_the_edge_of_the_shadow() -> None:
    assert knife_edge(0.0) == 0.5


@pytest.mark.parametrize("v", [-3.1, -1.2172, -0.4, 0.3, 1.0, 2.4, 9.0])
def test_the_integral_itself(v: float) -> None:
    # The path turned by −45° into the complex plane, t = v + s e^{−jπ/4}: there the integrand falls as exp(−πs²/2).
    turn = np.exp(-0.25j * np.pi)

    def along(s: float) -> complex:
        return complex(0.5 * (1.0 + 1.0j) * turn * np.exp(-0.5j * np.pi * (v + s * turn) ** 2))

    # For v < 0 the turned integrand rises to e^{πv²/4} first: 1e3 at −3.1, so that 1e-11 stays of 1e-14.
    real, imaginary = (
        quad(lambda s, p=part: getattr(along(s), p), 0.0, 20.0, epsabs=1e-12, limit=400)[0] for part in ("real", "imag")
    )
    np.testing.assert_allclose(knife_edge(v), complex(real, imaginary), rtol=0.0, atol=1e-10)


def test_two_half_planes_are_a_whole() -> None:
    # Babinet: what one edge passes and what its complement passes is all there is. Rounding of the two sums.
    np.testing.assert_allclose(knife_edge(V) + knife_edge(-V), 1.0, rtol=0.0, atol=1e-15)


def test_loss_of_the_recommendation() -> None:
    # ITU-R P.526: J(ν) ≈ 6.9 + 20 log(√((ν − 0.1)² + 1) + ν − 0.1) for ν > −0.78. Its error, measured against the
    # integral: −0.10 dB (ν = −0.55) to 0.12 dB (ν = 4.6).
    v = np.linspace(-0.78, 12.0, 600)
    loss = -20.0 * np.log10(np.abs(knife_edge(v)))
    np.testing.assert_allclose(loss, 6.9 + 20.0 * np.log10(np.sqrt((v - 0.1) ** 2 + 1.0) + v - 0.1), rtol=0, atol=0.13)
    np.testing.assert_allclose(-20.0 * np.log10(np.abs(knife_edge([0.0, 1.0, 2.4]))), [6.02, 13.9, 20.5], atol=0.15)


def test_deep_shadow_is_a_ray_from_the_edge() -> None:
    # F → exp(−jπv²/2 − jπ/4)/(π √2 v), the next term 1/(π v²) of it.
    v = np.array([5.0, 10.0, 20.0])
    ray = np.exp(-1j * np.pi * (0.5 * v**2 + 0.25)) / (np.sqrt(2.0) * np.pi * v)
    assert np.all(np.abs(knife_edge(v) / ray - 1.0) < 1.1 / (np.pi * v**2))


def test_greatest_field_of_the_light() -> None:
    # Born & Wolf's figure: the first maximum, 1.37 of the power, lies at v = −1.217; Cornu's spiral is furthest there.
    v = np.linspace(-2.0, 0.0, 20_001)
    power = np.abs(knife_edge(v)) ** 2
    assert power.max() == pytest.approx(1.3704, abs=1e-4)
    assert v[power.argmax()] == pytest.approx(-1.2172, abs=2e-4)
