"""Spreadings are densities on the circle, with the exponents and jumps that their papers print."""

from __future__ import annotations

from collections.abc import Callable

import mpmath
import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from numpy.typing import NDArray

from seamap_rt.sea.spreading import (
    cos2s,
    cos2s_of_cosine,
    cos2s_peak,
    donelan_banner,
    donelan_banner_beta,
    half_plane_elfouhaily,
    hasselmann_exponent,
    mitsuyasu_exponent,
)

CIRCLE = 2.0 * np.pi * np.arange(4096) / 4096.0 - np.pi  # its sum is exact for 4095 harmonics, and holds 0 and ±π/2
BEYOND_THE_EDGE = 1.0 + 1e-12

angles = st.floats(-20.0, 20.0)
exponents = st.floats(0.0, 1e6)
betas = st.floats(0.0, 1e3)
contrasts = st.floats(0.0, 1.0)
ratios = st.floats(0.0, 1e9)
ages = st.floats(1e-3, 100.0)


def half_plane(angle, contrast):
    """From the angle; cos(π/2) = 6e-17 is across."""
    cosine = np.cos(angle)
    return half_plane_elfouhaily(np.where(np.abs(cosine) < 1e-15, 0.0, cosine), contrast)


def over_the_circle(density: Callable[[NDArray[np.float64]], NDArray[np.float64]]) -> float:
    """2 ∫ from 0 to π of an even density, by Gauss–Legendre panels that halve towards 0 and towards π."""
    nodes, weights = np.polynomial.legendre.leggauss(40)
    near = np.pi * 0.5 ** np.arange(40.0, 0.0, -1.0)
    edges = np.concatenate(([0.0], near, np.pi - near[-2::-1], [np.pi]))
    half = 0.5 * np.diff(edges)[:, None]
    angle = edges[:-1, None] + half * (1.0 + nodes)
    return float(2.0 * np.sum(half * weights * density(angle)))


# ------------------------------------------------------------------------------------------------------- the circle


@given(exponents)
def test_cos2s_integrates_to_one(exponent: float) -> None:
    # Within 1.5e-8 of π, 1 + cos θ is all rounding, and to a small power of order 1: there D is wrong by 1/2π at most.
    # Elsewhere it is rounded to s · 1e-16.
    total = over_the_circle(lambda angle: cos2s(angle, exponent))
    np.testing.assert_allclose(total, 1.0, rtol=0.0, atol=5e-9 + 1e-15 * exponent)


@given(betas)
def test_sech_squared_integrates_to_one(beta: float) -> None:
    # The poles of sech² lie π/2β off the axis: on panels no longer than that 40 nodes are exact to rounding.
    np.testing.assert_allclose(over_the_circle(lambda angle: donelan_banner(angle, beta)), 1.0, rtol=1e-12)


@given(contrasts)
def test_half_plane_integrates_to_one(contrast: float) -> None:
    density = half_plane(CIRCLE, contrast)
    # A sum over equal steps that gives each end of the half plane its half: exact for two harmonics.
    np.testing.assert_allclose(density.sum() * 2.0 * np.pi / CIRCLE.size, 1.0, rtol=1e-12)
    both = density + half_plane(CIRCLE + np.pi, contrast)
    # To and fro together are the paper's even spectrum, doubled.
    np.testing.assert_allclose(both, (1.0 + contrast * np.cos(2.0 * CIRCLE)) / np.pi, rtol=1e-9, atol=1e-12)


@given(angles, exponents, betas, contrasts)
def test_densities_are_even_periodic_and_never_negative(
    angle: float, exponent: float, beta: float, contrast: float
) -> None:
    peak = donelan_banner(0.0, beta)
    # A turn more or less costs an angle of 20 rad some 1e-14, which sech² multiplies by 2β at most.
    slack = float(peak) * (1e-15 + 1e-13 * beta)
    value = donelan_banner(angle, beta)
    assert 0.0 <= value <= peak * (1.0 + 1e-15) + slack  # rounding, where the density is even
    for same in (-angle, angle + 2.0 * np.pi):
        np.testing.assert_allclose(donelan_banner(same, beta), value, rtol=0.0, atol=slack)
    assert 0.0 <= cos2s(angle, exponent) <= cos2s(0.0, exponent) * (1.0 + 1e-14)
    assert cos2s(-angle, exponent) == cos2s(angle, exponent)
    assert half_plane(-angle, contrast) == half_plane(angle, contrast) >= 0.0


@pytest.mark.parametrize("width", [0.5, 2.0, 30.0])
def test_mean_direction_is_where_the_angle_counts_from(width: float) -> None:
    for density in (cos2s(CIRCLE - 0.7, width), donelan_banner(CIRCLE - 0.7, width)):
        # The kink of sech² at ±π is what the sum of 4096 points misses: n⁻².
        np.testing.assert_allclose(np.angle(np.sum(density * np.exp(1j * CIRCLE))), 0.7, atol=1e-6)


def test_an_even_circle_and_a_long_crested_sea_are_the_limits() -> None:
    for even in (cos2s(CIRCLE, 0.0), cos2s(CIRCLE[1:], 1e-300), donelan_banner(CIRCLE, 0.0)):
        np.testing.assert_allclose(even, 0.5 / np.pi, rtol=1e-12)
    for sharp in (
        cos2s([0.0, 1e-3, np.pi], 1e300),
        cos2s([0.0, 1e-3, np.pi], np.inf),
        donelan_banner([0.0, 1e-3, np.pi], np.inf),
    ):
        assert np.isfinite(sharp[0])
        assert sharp[0] > 1e6
        np.testing.assert_array_equal(sharp[1:], 0.0)


@pytest.mark.parametrize("exponent", [0.0, 1e-9, 0.5, 10.0, 85.5, 999.9, 1000.0, 1e4, 1e8, 1e15])
def test_cos2s_peak_keeps_its_digits(exponent: float) -> None:
    s = mpmath.mpf(exponent)
    exact = mpmath.gamma(s + 1) / mpmath.gamma(s + mpmath.mpf("0.5")) / (2 * mpmath.sqrt(mpmath.pi))
    # ln Γ(1000) = 5905 in float64: its rounding is 1e-12 of Γ.
    np.testing.assert_allclose(cos2s_peak(exponent), float(exact), rtol=2e-12)


def test_exponents_may_be_arrays() -> None:
    exponent = np.array([[0.0], [3.0], [2000.0]])
    table = cos2s_of_cosine(np.cos(CIRCLE), exponent)
    for row, s in zip(table, exponent[:, 0], strict=True):
        np.testing.assert_array_equal(row, cos2s(CIRCLE, s))
    assert donelan_banner(CIRCLE, np.array([[1.0], [2.0]])).shape == (2, CIRCLE.size)


# ---------------------------------------------------------------------------------------------------- their papers


def test_mitsuyasu_at_its_printed_values() -> None:
    np.testing.assert_allclose(mitsuyasu_exponent(1.0, 1.0), 11.5, rtol=1e-15)
    # By hand: U/cp = 2: 11.5/2^2.5 = 2.0329; below at ½: 2^−5; above at 4: 4^−2.5 = 1/32 as well.
    np.testing.assert_allclose(mitsuyasu_exponent([0.5, 1.0, 4.0], 2.0), 2.03293 * np.array([1 / 32, 1, 1 / 32]), 1e-5)
    np.testing.assert_allclose(mitsuyasu_exponent([1.0 / BEYOND_THE_EDGE, BEYOND_THE_EDGE], 0.84), 17.783, rtol=1e-4)


def test_hasselmann_at_its_printed_values() -> None:
    # By hand at U/cp = 1.17, where the exponent above is −2.33: 2^−2.33 = 0.19888.
    np.testing.assert_allclose(hasselmann_exponent([1.0, 0.5, 2.0], 1.17), [6.97, 0.417879, 1.943098], rtol=2e-5)
    edge = hasselmann_exponent([1.05 / BEYOND_THE_EDGE, 1.05], 1.17)
    # 6.97 · 1.05^4.06 = 8.4969 and 9.77 · 1.05^−2.33 = 8.7200: the two fits miss each other by 2.6 %.
    np.testing.assert_allclose(edge, [8.49686, 8.71997], rtol=2e-5)
    # A younger sea is broader above the peak, and only there.
    young, old = hasselmann_exponent([0.8, 2.0], 1.7), hasselmann_exponent([0.8, 2.0], 1.0)
    assert young[0] == old[0]
    assert young[1] < old[1]


def test_donelan_and_banner_at_their_printed_values() -> None:
    ratio = np.array([0.0, 0.3, 0.56, 0.8, 1.0, 1.3, 2.0, 1e9])
    # By hand; at 2: 10^(−0.4 + 0.8393 · 2^−1.134) = 10^(−0.4 + 0.8393 · 0.455653); the limit is 10^−0.4.
    printed = [1.228268, 1.228268, 1.228268, 1.952822, 2.28, 1.621076, 0.960342, 0.398107]
    np.testing.assert_allclose(donelan_banner_beta(ratio), printed, rtol=2e-5)
    jump = donelan_banner_beta([0.95 / BEYOND_THE_EDGE, 0.95])
    np.testing.assert_allclose(
        jump[1] / jump[0], 2.28 / 2.61 * 0.95**-2.6, rtol=1e-10
    )  # 0.998: the fits differ by 0.2 %
    joint = donelan_banner_beta([1.6 / BEYOND_THE_EDGE, 1.6])
    np.testing.assert_allclose(joint[1] / joint[0], 1.0, atol=2e-4)  # Banner's tail was fitted to meet
    # Half of the peak's density where sech² = ½: βθ = acosh √2.
    half = np.arccosh(np.sqrt(2.0)) / 2.28
    np.testing.assert_allclose(donelan_banner(half, 2.28) / donelan_banner(0.0, 2.28), 0.5, rtol=1e-12)
    np.testing.assert_allclose(donelan_banner(0.0, 2.28), 0.5 * 2.28, rtol=2e-6)  # tanh(2.28 π) = 1 − 1.2e-6


def test_half_plane_across_the_wind() -> None:
    np.testing.assert_allclose(half_plane(0.0, 0.5), 1.5 / np.pi, rtol=1e-15)
    np.testing.assert_allclose(half_plane([np.pi / 2, -np.pi / 2, 1.5 * np.pi], 0.5), 0.25 / np.pi, rtol=1e-12)
    np.testing.assert_array_equal(half_plane([1.6, np.pi, -2.0], 0.5), 0.0)
    np.testing.assert_array_equal(half_plane_elfouhaily([0.0, -0.0], 1.0), 0.0)
    assert half_plane_elfouhaily(0.0, 0.5) == 0.25 / np.pi


@given(ratios, ages)
def test_exponents_are_finite_and_fall_from_the_peak(ratio: float, age: float) -> None:
    for function, edge in (
        (lambda x: mitsuyasu_exponent(x, age), 1.0),
        (lambda x: hasselmann_exponent(x, age), 1.05),
        (donelan_banner_beta, 0.95),
    ):
        value, further = function(ratio), function(ratio * (1.1 if ratio >= edge else 0.9))
        assert 0.0 <= further <= value < np.inf
    density: NDArray[np.float64] = cos2s(CIRCLE, mitsuyasu_exponent(ratio, age))
    assert np.all(np.isfinite(density))


def test_what_is_no_spreading_raises() -> None:
    for wrong in (-1.0, np.nan):
        with pytest.raises(ValueError, match="exponent"):
            cos2s(0.0, [1.0, wrong])
        with pytest.raises(ValueError, match="beta"):
            donelan_banner(0.0, wrong)
        with pytest.raises(ValueError, match="contrast"):
            half_plane(0.0, wrong)
        for function in (mitsuyasu_exponent, hasselmann_exponent):
            with pytest.raises(ValueError, match="frequency_ratio"):
                function(wrong, 1.0)
            with pytest.raises(ValueError, match="inverse_wave_age"):
                function(1.0, wrong)
        with pytest.raises(ValueError, match="frequency_ratio"):
            donelan_banner_beta(wrong)
    with pytest.raises(ValueError, match=r"contrast = 1.5"):
        half_plane(0.0, [0.5, 1.5])
