"""Multi-look phase statistics (Lee et al. 1994): check values, the printed formula in 40 digits, simulated speckle."""

from __future__ import annotations

import mpmath
import numpy as np
import pytest

from validation.analytic import cramer_rao_phase_std, phase_pdf_lee94, phase_std_lee94


def as_printed(phase: float, coherence: float, looks: int) -> float:
    with mpmath.workdps(40):
        gamma, half = mpmath.mpf(coherence), mpmath.mpf(1) / 2
        beta = gamma * mpmath.cos(phase)
        odd = mpmath.gamma(looks + half) * (1 - gamma**2) ** looks * beta
        odd /= 2 * mpmath.sqrt(mpmath.pi) * mpmath.gamma(looks) * (1 - beta**2) ** (looks + half)
        even = (1 - gamma**2) ** looks / (2 * mpmath.pi) * mpmath.hyp2f1(looks, 1, half, beta**2)
        return float(odd + even)


@pytest.mark.parametrize(
    ("coherence", "looks", "std"), [(0.99, 1, 0.2634), (0.99, 4, 0.0583), (0.5, 1, 1.3361), (0.5, 10, 0.4731)]
)
def test_standard_deviation_meets_the_check_values(coherence: float, looks: int, std: float) -> None:
    np.testing.assert_allclose(phase_std_lee94(coherence, looks), std, atol=5e-5)  # as printed


@pytest.mark.parametrize("coherence", [0.0, 0.3, 0.9, 0.9999])
@pytest.mark.parametrize("looks", [1, 2, 10, 300])
def test_density_agrees_with_the_printed_formula(coherence: float, looks: int) -> None:
    phase = np.linspace(-3.1, 3.1, 15)
    expected = np.array([as_printed(each, coherence, looks) for each in phase])
    # 1e-12 of the peak: opposite to it the two terms cancel
    np.testing.assert_allclose(
        phase_pdf_lee94(phase, coherence, looks), expected, rtol=1e-9, atol=1e-12 * expected.max()
    )


@pytest.mark.parametrize("coherence", [0.0, 0.5, 0.95])
@pytest.mark.parametrize("looks", [1, 3.5, 40])
def test_density_integrates_to_one_and_follows_its_mean(coherence: float, looks: float) -> None:
    phase = np.linspace(-np.pi, np.pi, 4096, endpoint=False)  # the trapezoid converges exponentially
    density = phase_pdf_lee94(phase, coherence, looks, 0.7)
    np.testing.assert_allclose(density.mean() * 2.0 * np.pi, 1.0, rtol=1e-10)
    moved = phase_pdf_lee94(phase + 0.7, coherence, looks, 0.7)
    np.testing.assert_allclose(moved, phase_pdf_lee94(phase, coherence, looks), rtol=1e-9, atol=1e-12)
    if coherence:
        np.testing.assert_allclose(phase[np.argmax(density)], 0.7, atol=2e-3)  # one step of the grid


def test_one_look_closed_form() -> None:
    # N = 1, γ: the variance is π²/3 − π asin γ + asin² γ − Li2(γ²)/2 (Bamler & Hartl 1998)
    for gamma in (0.1, 0.5, 0.9, 0.999):
        arc = np.arcsin(gamma)
        variance = np.pi**2 / 3.0 - np.pi * arc + arc**2 - float(mpmath.polylog(2, gamma**2)) / 2.0
        np.testing.assert_allclose(phase_std_lee94(gamma, 1) ** 2, variance, rtol=1e-9)


def test_limits() -> None:
    np.testing.assert_allclose(phase_std_lee94(0.0, [1, 5, 100]), np.pi / np.sqrt(3.0), rtol=1e-12)
    np.testing.assert_array_equal(phase_std_lee94(1.0, [1, 5]), 0.0)
    np.testing.assert_array_equal(cramer_rao_phase_std([0.0, 1.0], 3), [np.inf, 0.0])
    std = phase_std_lee94(np.linspace(0.0, 1.0, 30)[:, None], np.array([1, 2, 4, 16, 64]))
    assert std.shape == (30, 5)
    assert np.all(np.diff(std, axis=0) < 0.0)
    assert np.all(np.diff(std[1:-1], axis=1) < 0.0)


def test_the_bound_is_below_and_reached_by_many_looks() -> None:
    gamma, looks = np.array([0.3, 0.7, 0.99])[:, None], np.array([20, 100, 1000])
    std, bound = phase_std_lee94(gamma, looks), cramer_rao_phase_std(gamma, looks)
    assert np.all(std[1:] > bound[1:])
    np.testing.assert_allclose((std / bound)[:, -1], 1.0, atol=0.01)  # the excess is of order 1/(Nγ²)
    np.testing.assert_allclose(phase_std_lee94(0.99, 1) / cramer_rao_phase_std(0.99, 1), 2.6, atol=0.05)  # sheet


def test_simulated_speckle_has_this_deviation() -> None:
    rng = np.random.default_rng(2)
    gamma, looks, draws = 0.8, 4, 40_000
    first, second = rng.normal(size=(2, draws, looks)) + 1j * rng.normal(size=(2, draws, looks))
    partner = gamma * first + np.sqrt(1.0 - gamma**2) * second
    phase = np.angle(np.sum(first * partner.conj(), axis=1))
    np.testing.assert_allclose(np.std(phase), phase_std_lee94(gamma, looks), rtol=0.02)  # 4 sigma of 40,000 draws


@pytest.mark.parametrize(
    ("coherence", "looks", "name"), [(1.1, 1, "coherence"), (np.nan, 1, "coherence"), (0.5, 0, "looks")]
)
def test_refuses_the_impossible(coherence: float, looks: float, name: str) -> None:
    for function in (phase_std_lee94, cramer_rao_phase_std):
        with pytest.raises(ValueError, match=name):
            function(coherence, looks)
    with pytest.raises(ValueError, match="coherence"):
        phase_pdf_lee94(0.0, 1.0, 1)
