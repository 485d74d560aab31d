"""Random numbers by counting: SplitMix64 by its published outputs and its laws, Box & Muller's normals by theirs."""

from __future__ import annotations

import math

import numpy as np
import pytest
from numpy.typing import NDArray
from scipy import stats

from seamap_rt.echoes.summation.gaussian import count_bits, draw, gaussians, key_of, normals, unit_phasor
from seamap_rt.random_streams import Stream, key

KEYS = [0, 1, 2, 1234567, 2**63, 2**64 - 1, int(key(3, Stream.SPECKLE)), int(key(3, Stream.SPECKLE, 1))]


def bits_of(of: int, count: int) -> NDArray[np.uint64]:
    bits = np.empty(count, np.uint64)
    count_bits(np.uint64(of), bits)
    return bits


def ones(bits: NDArray[np.uint64]) -> NDArray[np.float64]:
    """(n, 64) each bit as 0 or 1."""
    return ((bits[:, None] >> np.arange(64, dtype=np.uint64)) & np.uint64(1)).astype(float)


def normals_of(bits: NDArray[np.uint64]) -> NDArray[np.complex128]:
    real, imag = np.empty(bits.size, np.float32), np.empty(bits.size, np.float32)
    normals(bits, real, imag)
    return np.asarray(real.astype(float) + 1j * imag, dtype=np.complex128)


# --------------------------------------------------------------------------------------------------- SplitMix64


@pytest.mark.parametrize(
    ("seed", "outputs"),
    [
        (0, [0xE220A8397B1DCDAF, 0x6E789E6AA1B965F4, 0x06C45D188009454F]),
        (
            1234567,
            [
                6457827717110365317,
                3203168211198807973,
                9817491932198370423,
                4593380528125082431,
                16408922859458223821,
            ],
        ),
    ],
)
def test_published_outputs(seed: int, outputs: list[int]) -> None:
    """Of java.util.SplittableRandom's and Vigna's splitmix64, as other implementations are checked by."""
    assert bits_of(seed, len(outputs)).tolist() == outputs
    assert [int(key_of(np.uint64(seed), n)) for n in range(len(outputs))] == outputs


@pytest.mark.parametrize("of", KEYS)
def test_every_bit_is_a_fair_coin_and_independent_of_the_others(of: int) -> None:
    count = 40_000
    coins = 2.0 * ones(bits_of(of, count)) - 1.0
    # A mean of n fair coins of ±1 errs by 1/√n; five of it for 64 bits, and for their 2016 pairs.
    limit = 5.0 / np.sqrt(count)
    assert np.abs(coins.mean(axis=0)).max() < limit
    assert np.abs(coins.T @ coins / count - np.eye(64)).max() < limit
    for lag in (1, 2, 64):  # nor does a number tell of later ones
        assert np.abs(coins[lag:].T @ coins[:-lag] / count).max() < 5.5 / np.sqrt(count)  # 4096 pairs


def test_columns_facets_and_streams_have_nothing_in_common() -> None:
    """Keys are outputs themselves, a facet's of its column's, and that of its stream's: half of all bits differ between
    any two of them, 32 ± 4."""
    count, (stream, other) = 20_000, KEYS[-2:]
    columns = [int(key_of(np.uint64(each), number)) for each in (stream, other) for number in (0, 1, 2)]
    facets = [int(key_of(np.uint64(column), number)) for column in columns[:2] for number in (0, 1)]
    drawn = [bits_of(each, count) for each in (stream, other, *columns, *facets)]
    for n, first in enumerate(drawn):
        for second in drawn[:n]:
            apart = ones(first ^ second).sum(axis=1)
            assert abs(apart.mean() - 32.0) < 5.0 * 4.0 / np.sqrt(count)
            assert abs(apart.std() - 4.0) < 5.0 * 4.0 / np.sqrt(2.0 * count)
    # Nor does any come twice: of 240,000 among 2⁶⁴.
    assert np.unique(np.concatenate(drawn)).size == len(drawn) * count


def test_a_number_depends_on_its_key_and_its_count_alone() -> None:
    stream = key(3, Stream.SPECKLE)
    whole, part = gaussians(stream, 1000, 5), gaussians(stream, 10, 3)
    np.testing.assert_array_equal(part, whole[:3, :10])
    bits, real, imag = np.empty(5, np.uint64), np.empty(5, np.float32), np.empty(5, np.float32)
    for member in (999, 3, 500):  # in any order
        draw(np.uint64(key_of(stream, member)), bits, real, imag)
        np.testing.assert_array_equal(real + 1j * imag, whole[:, member])


def test_every_branch_of_a_seed_has_a_key_of_its_own() -> None:
    members = [(), (1,), (2,), (1, 2), (2, 1)]
    keys = [int(key(seed, stream, *member)) for seed in (0, 1, 2) for stream in Stream for member in members]
    assert len(set(keys)) == len(keys)


# ------------------------------------------------------------------------------------------------------ normals


def box_muller(bits: int) -> complex:
    """Box & Muller (1958), of unit power: the radius by the highest 23 bits, the phase by the lowest 32."""
    radius = math.sqrt(-math.log(((bits >> 41) + 0.5) * 2.0**-23))
    return radius * complex(np.exp(2j * np.pi * (bits & 0xFFFFFFFF) * 2.0**-32))


def test_power_and_phase_follow_their_laws() -> None:
    count = 200_000
    drawn = normals_of(bits_of(KEYS[-1], count))
    # Kolmogorov & Smirnov: the greatest distance from the law is above 2.2/√n once in 10⁴ tries.
    limit = 2.2 / np.sqrt(count)
    assert float(stats.kstest(np.abs(drawn) ** 2, stats.expon.cdf).statistic) < limit
    assert float(stats.kstest(np.angle(drawn), stats.uniform(-np.pi, 2.0 * np.pi).cdf).statistic) < limit
    for component in (drawn.real, drawn.imag):
        assert float(stats.kstest(component, stats.norm(scale=np.sqrt(0.5)).cdf).statistic) < limit
    assert abs(np.mean(drawn**2)) < 5.0 * np.sqrt(2.0 / count)  # no phase preferred
    assert abs(np.mean(drawn[1:] * drawn[:-1].conj())) < 5.0 / np.sqrt(count)


def test_normals_are_those_of_their_bits() -> None:
    # The polynomials err by some 1e-7 of the logarithm, which near a power of nothing is all that there is: 3e-8 of it
    # are 1e-4 of an amplitude of 5e-4. Elsewhere single precision.
    bits = bits_of(KEYS[-2], 3000)
    exact = np.array([box_muller(each) for each in bits.tolist()])
    drawn = normals_of(bits)
    np.testing.assert_allclose(np.abs(drawn) ** 2, np.abs(exact) ** 2, rtol=2e-6, atol=1e-7)
    np.testing.assert_allclose(np.angle(drawn * exact.conj()), 0.0, atol=1e-6)


@pytest.mark.parametrize("high", [0, 1, 2**22 - 1, 2**22, 2**23 - 2, 2**23 - 1])
@pytest.mark.parametrize("low", [0, 2**31 - 1, 2**31, 2**32 - 1, 0x60000000])
def test_no_bits_draw_what_is_no_number(high: int, low: int) -> None:
    # At most ln 2²⁴ = 16.6 times the mean, and at least what (1 − 2⁻²⁴) leaves: no infinity and no NaN.
    bits = (high << 41) | low
    drawn, exact = complex(normals_of(np.array([bits], np.uint64))[0]), box_muller(bits)
    assert abs(drawn) ** 2 <= 24.0 * np.log(2.0) * (1.0 + 1e-6)
    assert abs(abs(drawn) ** 2 - abs(exact) ** 2) < 1e-7 + 2e-6 * abs(exact) ** 2
    if abs(exact) > 0.01:
        assert abs(drawn - exact) < 3e-6 * abs(exact)


def test_cosine_and_sine_of_every_angle() -> None:
    # Polynomials within 6e-8, and single precision's rounding of the angle: up to π/2 times 6e-8.
    cycles = np.linspace(-0.5, 0.5, 20_001).astype(np.float32)
    found = np.array([complex(*unit_phasor(each)) for each in cycles])
    np.testing.assert_allclose(found, np.exp(2j * np.pi * cycles.astype(float)), rtol=0, atol=5e-7)
