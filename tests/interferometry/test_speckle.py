"""Phase errors given the echo's power, against drawn speckle and noise."""

from __future__ import annotations

import numpy as np
import pytest
from numpy.typing import NDArray
from scipy.integrate import quad
from scipy.special import i0e
from scipy.stats import t as student

from seamap_rt.interferometry.speckle import (
    estimation_doubt,
    incoherent_power,
    phase_variances,
    pulse_coherence_kept,
    wrapped_variance,
)
from seamap_rt.interferometry.windows import Covariance
from validation.analytic import phase_std_lee94

Array = NDArray[np.float64]
COHERENCES = (0.9, 0.97, 0.999)


def normal(rng: np.random.Generator, *shape: int) -> NDArray[np.complex128]:
    return np.sqrt(0.5) * (rng.normal(size=shape) + 1j * rng.normal(size=shape))


def speckle(rng: np.random.Generator, coherence: float, *shape: int) -> tuple[NDArray[np.complex128], ...]:
    """Voltages of both receivers, of mean power 1."""
    common, own = normal(rng, *shape), normal(rng, *shape)
    return common, coherence * common + np.sqrt(1.0 - coherence**2) * own


def summed(lower: NDArray[np.complex128], upper: NDArray[np.complex128]) -> Covariance:
    """Means over the first axis."""
    power, other = ((np.abs(each) ** 2).mean(axis=0) for each in (lower, upper))
    return Covariance((lower * upper.conj()).mean(axis=0), power, other)


@pytest.mark.parametrize("coherence", COHERENCES)
@pytest.mark.parametrize("looks", [1, 2, 4])
def test_strong_echoes_have_good_phases(looks: int, coherence: float) -> None:
    # Ten classes of equal number by their own power, the weakest of which are many times worse than the strongest when
    # there are few looks. A mean square of 20,000 is good to √(2/20,000) = 1 %; 4 σ. The law is one of 1 − γ to first
    # order: it takes that for (1 − γ²)/2γ, and ½(P₁ + P₂) for |V₁V₂|, which is less by about (1 − γ)/P of it. Echoes
    # fainter than ten times what is not shared are off by more, and it says so little of them.
    rng = np.random.default_rng(1)
    cells = summed(*speckle(rng, coherence, looks, 1, 200_000))
    variance = np.sum(phase_variances(cells, np.full((1, 1), 1.0 - coherence), 0.0, looks, looks), axis=0)[0]
    error = np.angle(cells.cross)[0] ** 2
    for part in np.array_split(np.argsort(variance), 10):
        ratio, beside = error[part].mean() / wrapped_variance(variance[part]).mean(), looks * variance[part].max()
        if beside < 0.1:
            assert 0.96 < ratio < 1.04 + beside + (1.0 - coherence)
        else:
            assert 0.96 < ratio < 2.2
    assert np.quantile(variance, 0.95) > (25.0 if looks == 1 else 4.0) * np.quantile(variance, 0.05)


@pytest.mark.parametrize("coherence", [0.5, 0.9, 0.99])
def test_lees_law_is_the_mean_over_all_amplitudes(coherence: float) -> None:
    # The exact concentration of one look. Lee's variance has heavy tails: 400,000 amplitudes know their mean to 0.5 %.
    lower, upper = speckle(np.random.default_rng(2), coherence, 400_000)
    concentration = 2.0 * coherence * np.abs(lower * upper) / (1.0 - coherence**2)
    variance = wrapped_variance(1.0 / concentration)
    spread = variance.std() / np.sqrt(variance.size)
    # 0.1 %: the table's straight lines.
    asked = float(phase_std_lee94(coherence, 1)) ** 2
    assert abs(variance.mean() - asked) < 4.0 * spread + 1e-3 * asked


def test_a_phase_cannot_leave_the_circle() -> None:
    # Between the table's 257 entries: straight lines, off by 1/8 of the bend of v(1 + …)/… over 1/256: 2e-4 in all.
    inverse = np.geomspace(1e-3, 1e3, 25)

    def asked(concentration: float) -> float:
        def density(angle: float) -> float:
            return float(np.exp(concentration * (np.cos(angle) - 1.0)) / (2.0 * np.pi * i0e(concentration)))

        edge = min(np.pi, 14.0 / np.sqrt(concentration))
        return 2.0 * quad(lambda angle: angle**2 * density(angle), 0.0, edge, epsabs=1e-12)[0]

    found = wrapped_variance(inverse)
    np.testing.assert_allclose(found, [asked(1.0 / each) for each in inverse], rtol=2e-3, atol=2e-4)
    assert (np.diff(found) > 0.0).all()
    limits = wrapped_variance(np.array([0.0, 1e-9, 1e-5, 1e12, np.inf]))
    np.testing.assert_allclose(limits[:3], [0.0, 1e-9, 1e-5], rtol=0.01)  # its first line leads through v = 1/255
    np.testing.assert_allclose(limits[3:], np.pi**2 / 3.0, rtol=1e-9)
    assert np.isnan(wrapped_variance(np.array([np.nan]))).all()


@pytest.mark.parametrize("beat", [1.0, 0.5, 0.2])
@pytest.mark.parametrize("ratio", [1.0, 4.0, 30.0])
def test_noise_turns_the_phase(ratio: float, beat: float) -> None:
    # A steady echo heard on N pulses; M = 1/beat partners of each, as in pulses that are compared with M others: the
    # echo's beat with the noise is as it was, the noise's with itself is M times as often new. 40,000 cells know a
    # variance to 0.7 %; the cell's own power, in place of the true one, raises the mean by (2/SNR + 1/SNR²)/N.
    rng, pulses, cells, partners = np.random.default_rng(3), 100, 40_000, round(1.0 / beat)
    noise = 1.0 / ratio
    cross, powers = np.zeros(cells, dtype=complex), np.zeros((2, cells))
    for _ in range(cells // 2000):
        part = np.s_[_ * 2000 : (_ + 1) * 2000]
        lower, upper = (1.0 + np.sqrt(noise) * normal(rng, pulses, 2000) for _ in range(2))
        for lag in range(partners):
            cross[part] += (lower * np.roll(upper, lag, axis=0).conj()).mean(axis=0) / partners
        powers[:, part] = [(np.abs(each) ** 2).mean(axis=0) for each in (lower, upper)]
    speckle, found = phase_variances(
        Covariance(cross[None], powers[:1], powers[1:]), np.zeros((1, 1)), noise, 7.0, pulses, beat
    )
    assert not speckle[np.isfinite(found)].any()
    seen = np.mean(np.angle(cross) ** 2)
    asked = (2.0 / ratio + beat / ratio**2) / (2.0 * pulses)
    assert seen == pytest.approx(asked, rel=0.03 + 2.0 / (pulses * ratio))
    assert found.mean() == pytest.approx(asked, rel=0.03 + (2.0 / ratio + 1.0 / ratio**2) * 3.0 / pulses)


def test_what_is_not_heard_has_no_phase() -> None:
    power = np.array([[0.9, 1.0, 1.0 + 1e-9, 1.02, 5.0, np.nan]])
    parts = phase_variances(Covariance(power + 0j, power, power), np.full((1, 6), 0.2), 1.0, 4.0, 10.0, 0.5, 1.5)
    found = np.sum(parts, axis=0)[0]
    assert np.isinf(found[[0, 1, 5]]).all()
    assert found[2] == pytest.approx(found[3])  # fainter than a fiftieth of the noise is not told from that
    # doubt · incoherent/(P L) + (2 n + c n²)/2N with n = 1/4
    assert found[4] == pytest.approx(1.5 * 0.2 / 4.0 / 4.0 + (0.5 + 0.5 / 16.0) / 20.0, rel=1e-12)


# ------------------------------------------------------------------------------------- what receivers do not share


@pytest.mark.parametrize("coherence", COHERENCES)
@pytest.mark.parametrize("samples", [5, 15])
def test_the_incoherent_power_of_a_window(samples: int, coherence: float) -> None:
    # The window's own phase takes one of its 2N degrees of freedom: 1 − 1/2N. To first order in 1 − γ.
    cells = summed(*speckle(np.random.default_rng(4), coherence, samples, 200, 60))
    found = incoherent_power(cells, 0.0, samples)
    np.testing.assert_array_equal(found, np.maximum(0.5 * (cells.lower + cells.upper) - np.abs(cells.cross), 0.0))
    # Each scatters by 1/√N of itself: 12,000 of them by 0.4 %.
    asked = (1.0 - coherence) * (1.0 - 0.5 / samples)
    assert found.mean() == pytest.approx(asked, rel=0.016 + 0.5 * (1.0 - coherence))


def test_where_noise_hides_it_the_trend_stands_in() -> None:
    # An echo of coherence 0.95, 6 dB below the noise, whose power of 2000 samples scatters by twice what is looked for:
    # (4/√2000 = 0.09)² against (0.7 · 0.05)², so that 13 % of it is the window's own.
    rng, noise, samples, shape = np.random.default_rng(5), 4.0, 2000, (80, 21)
    lower, upper = speckle(rng, 0.95, samples, *shape)
    cells = summed(*(each + np.sqrt(noise) * normal(rng, samples, *shape) for each in (lower, upper)))
    found = incoherent_power(cells, noise, samples)
    own = 0.5 * (cells.lower + cells.upper) - noise - np.abs(cells.cross)
    # The mean of 1680 windows knows it to 0.09/√1680 = 4 %; the noise lengthens |C| by (2 + 4) 4/4N = 0.003 of 0.05,
    # and what is left of a window's own, never below zero, adds as much.
    assert found.mean() == pytest.approx(0.05, rel=0.16)
    assert found.std() < 0.25 * own.std()
    assert found.min() >= 0.0
    # With the noise 40 dB below the echo it is each window's own.
    quiet = summed(*(each + 0.01 * normal(rng, samples, *shape) for each in (lower, upper)))
    own = 0.5 * (quiet.lower + quiet.upper) - np.abs(quiet.cross) - 1e-4
    np.testing.assert_allclose(incoherent_power(quiet, 1e-4, samples), own, rtol=0.01)


def test_odd_windows_have_an_incoherent_power() -> None:
    dead = Covariance(np.full((3, 4), np.nan + 0j), np.full((3, 4), np.nan), np.zeros((3, 4)))
    for noise in (0.0, 1.0):
        np.testing.assert_array_equal(incoherent_power(dead, noise, 10.0), 0.0)


def test_its_own_and_the_usual_share_are_weighed_by_their_scatter() -> None:
    # Two looks of one gate, of 4 W and 2 W beside noise of 1 W, which miss 0.6 W and less than nothing: 0.5 W of 6 are
    # usual, a twelfth. 0.7 of that is its scatter, of 25 samples of noise 0.2 W the other.
    power, missing = np.array([[4.0], [2.0]]), np.array([[0.6], [-0.1]])
    cells = Covariance(power - missing + 0j, power + 1.0, power + 1.0)
    usual = power / 12.0
    trust = (0.7 * usual) ** 2 / ((0.7 * usual) ** 2 + 0.2**2)
    asked = trust * np.maximum(missing, 0.0) + (1.0 - trust) * usual
    np.testing.assert_allclose(incoherent_power(cells, 1.0, 25.0), asked, rtol=1e-12)
    # Without noise, and where no look is known to miss anything: its own, however little.
    np.testing.assert_allclose(
        incoherent_power(Covariance(power - missing + 0j, power, power), 0.0, 25.0),
        np.maximum(missing, 0.0),
        rtol=0,
        atol=1e-15,
    )


def test_a_variance_that_was_found_from_few_samples() -> None:
    for samples in (2.0, 5.0, 37.5):
        assert estimation_doubt(samples) == pytest.approx(min(2.0, float(student(samples).var())), rel=1e-9)
    assert estimation_doubt(1.0) == estimation_doubt(0.5) == 2.0
    # Drawn: errors of variance v, judged by v found from 12 complex samples that count by their fading power, are
    # larger than they should be; that such weights leave half of them is so on the mean.
    rng = np.random.default_rng(6)
    weight = rng.exponential(size=(12, 200_000))
    found = np.sum(weight * np.abs(normal(rng, 12, 200_000)) ** 2, axis=0) / weight.sum(axis=0)
    error = rng.normal(size=200_000)
    assert np.mean(error**2 / found) == pytest.approx(estimation_doubt(12.0), rel=0.05)


@pytest.mark.parametrize("width", [0.0, 150.0])
@pytest.mark.parametrize("rate", [0.0, 300.0, 1500.0])
def test_what_moves_between_pulses_is_not_incoherent(rate: float, width: float) -> None:
    # Echoes whose phase turns at `rate` rad/s and scatters by `width`, heard by the receivers in turn, 0.4 ms apart, of
    # coherence 0.99 on the same pulse. Lags of two pulses say what one loses: 40,000 echoes know it to
    # (rate · 0.4 ms)²/√40,000, 0.002 of the fastest; a spread's third order, (width · 0.4 ms)⁴/6, is less than that.
    rng, interval, shape = np.random.default_rng(7), 4e-4, (200, 200)
    own = rate + width * rng.normal(size=(40, *shape))
    part = normal(rng, 40, *shape) / np.sqrt(40.0)
    volts = [np.sum(part * np.exp(1j * own * interval * n), axis=0) for n in range(-1, 2)]
    upper = [0.99 * each + np.sqrt(1.0 - 0.99**2) * normal(rng, *shape) for each in volts[::2]]
    power = np.full((1, 1), np.mean(np.abs(volts[1]) ** 2))
    cross = np.mean(0.5 * volts[1] * (upper[0] + upper[1]).conj(), keepdims=True)
    lag = Covariance(np.mean(volts[2] * volts[0].conj(), keepdims=True), power, power)
    kept = pulse_coherence_kept(lag, 0.0, 0.5)
    lost = (rate**2 + width**2) * interval**2
    found = incoherent_power(Covariance(cross, power, power), 0.0, 1e6, kept) / power
    assert found == pytest.approx(0.01, abs=0.002 + 0.03 * lost)
    if lost > 0.01:
        assert incoherent_power(Covariance(cross, power, power), 0.0, 1e6) / power > 0.01 + 0.4 * lost
