"""Windows of the covariance against the same sums written out, cell by cell."""

from __future__ import annotations

import numpy as np
import pytest
from numpy.typing import NDArray

from seamap_rt.interferometry.windows import Covariance, Level, PhaseSlopes

LOOKS, GATES = 9, 13


def cells(seed: int) -> Covariance:
    rng = np.random.default_rng(seed)
    cross = rng.normal(size=(LOOKS, GATES)) + 1j * rng.normal(size=(LOOKS, GATES))
    lower, upper = rng.uniform(1.0, 5.0, (2, LOOKS, GATES))
    cross[4, 6] = lower[0, 2] = upper[8, 11] = np.nan
    return Covariance(cross, lower, upper)


def written_out(
    given: Covariance,
    range_weights: NDArray[np.float64],
    look_weights: NDArray[np.float64],
    per_gate: NDArray[np.float64],
    per_look: NDArray[np.float64],
    level: Level | None,
) -> list[NDArray]:
    per_gate, per_look = (np.broadcast_to(each, (LOOKS, GATES)) for each in (per_gate, per_look))
    sums = np.full((3, LOOKS, GATES), np.nan, dtype=complex)
    half_range, half_look = range_weights.size // 2, look_weights.size // 2
    for i, j in np.argwhere(given.has_value):
        total, weights = np.zeros(3, dtype=complex), 0.0
        for n in range(-half_look, half_look + 1):
            for m in range(-half_range, half_range + 1):
                pair = [(i + n, j + m), (i - n, j - m)]
                if not all(0 <= a < LOOKS and 0 <= b < GATES and given.has_value[a, b] for a, b in pair):
                    continue
                weight = look_weights[n + half_look] * range_weights[m + half_range]
                phase = -per_gate[i, j] * m - per_look[i, j] * n
                if level is not None:
                    phase += level(m)[i, j] - level(0)[pair[0]]
                there = given.cross[pair[0]], given.lower[pair[0]], given.upper[pair[0]]
                total += weight * np.array([there[0] * np.exp(1j * phase), *there[1:]])
                weights += weight
        sums[:, i, j] = total / weights
    return [sums[0], sums[1].real, sums[2].real]


@pytest.mark.parametrize("sizes", [(1, 1), (3, 1), (1, 3), (5, 3), (3, 7), (15, 11)])
@pytest.mark.parametrize("shapes", [((1,), (1,)), ((GATES,), (LOOKS, 1)), ((LOOKS, GATES), (LOOKS, GATES))])
@pytest.mark.parametrize("levelled", [False, True])
def test_windows_are_what_they_say(sizes: tuple[int, int], shapes: tuple[tuple[int, ...], ...], levelled: bool) -> None:
    rng, given = np.random.default_rng(2), cells(1)
    range_weights, look_weights = (np.linspace(0.3, 1.0, size) for size in sizes)  # sides differ: none is mixed up
    per_gate, per_look = (rng.uniform(-2.0, 2.0, shape) for shape in shapes)
    height = rng.uniform(-9.0, 9.0, (31, LOOKS, GATES))
    level = (lambda gates: height[15 + gates]) if levelled else None
    found = given.windowed_along(range_weights, look_weights, PhaseSlopes(per_gate, per_look, level))
    asked = written_out(given, range_weights, look_weights, per_gate, per_look, level)
    # 165 cells, turned by products of up to 12 turns: some hundred ulp.
    for got, wanted in zip((found.cross, found.lower, found.upper), asked, strict=True):
        np.testing.assert_allclose(got, wanted, rtol=0, atol=2e-13)


def test_a_window_of_what_is_not_known_is_not_known() -> None:
    given = cells(3)
    given.cross[:] = np.nan
    found = given.windowed_along(np.ones(3), np.ones(3), PhaseSlopes(np.zeros(1), np.zeros(1)))
    assert not found.has_value.any()
    assert np.isnan(found.lower).all()


@pytest.mark.parametrize("sizes", [(1, 1), (3, 1), (5, 3), (3, 7), (15, 11)])
def test_a_window_as_it_is_leaves_out_what_is_not_known_one_by_one(sizes: tuple[int, int]) -> None:
    """Means by weight of the known cells within it, whatever lies opposite: sums of 165 numbers, some hundred ulp."""
    given, (along, across) = cells(5), (np.linspace(0.3, 1.0, size) for size in sizes)
    found, half_range, half_look = given.windowed(along, across), along.size // 2, across.size // 2
    fields = given.cross, given.lower, given.upper
    for i, j in np.ndindex(LOOKS, GATES):
        means = [np.nan] * 3
        if given.has_value[i, j]:
            beside = [
                (across[n + half_look] * along[m + half_range], (i + n, j + m))
                for n in range(-half_look, half_look + 1)
                for m in range(-half_range, half_range + 1)
                if 0 <= i + n < LOOKS and 0 <= j + m < GATES and given.has_value[i + n, j + m]
            ]
            total = sum(weight for weight, _ in beside)
            means = [sum(weight * field[place] for weight, place in beside) / total for field in fields]
        for got, wanted in zip((found.cross, found.lower, found.upper), means, strict=True):
            np.testing.assert_allclose(got[i, j], wanted, rtol=0, atol=2e-13)
