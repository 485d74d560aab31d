"""A sea that remembers gives the values that it gives anyway, and works them out once."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest
from numpy.testing import assert_array_equal
from small_seas import jonswap, sea_of

from seamap_rt.sea import Sea, realize

X, Y = np.meshgrid(np.linspace(-40.0, 40.0, 30), np.linspace(0.0, 60.0, 20))


def small(**changes: Any) -> Sea:
    return realize(sea_of(jonswap(), **changes), 1)


@pytest.fixture
def evaluated(monkeypatch: pytest.MonkeyPatch) -> list[int]:
    """How many points each evaluation of linear waves was of."""
    from seamap_rt.sea.wave_trains import LinearSurface

    sizes: list[int] = []
    sample = LinearSurface.sample

    def noted(self: LinearSurface, x: Any, *others: Any) -> Any:
        sizes.append(x.size)
        return sample(self, x, *others)

    monkeypatch.setattr(LinearSurface, "sample", noted)
    return sizes


@pytest.mark.parametrize("changes", [{}, {"model": "choppy"}, {"current_m_s": 1.0}])
def test_it_says_what_it_says_anyway(changes: dict[str, Any]) -> None:
    plain, remembering = small(**changes), small(**changes)
    remembering.remember(1e8)
    for _ in range(2):
        for x, time, rate in ((X, 1.0, 0.5), (X, 1.0, 2.0), (X, 2.0, 0.5), (X + 3.0, 1.0, 0.5)):
            for mine, its in zip(
                remembering.elevation_velocity_and_relaxed_shift(x, Y, time, rate),
                plain.elevation_velocity_and_relaxed_shift(x, Y, time, rate),
                strict=True,
            ):
                assert_array_equal(mine, its)
            assert_array_equal(remembering.slopes(x, Y, time), plain.slopes(x, Y, time))


def test_it_works_them_out_once_and_what_it_gives_is_the_callers(evaluated: list[int]) -> None:
    sea = small()
    sea.remember(1e8)
    first = sea.elevation(X, Y, 1.0)
    kept = first.copy()
    first[:] = 7.0
    assert_array_equal(sea.elevation(X, Y, 1.0), kept)
    assert evaluated == [X.size]
    sea.elevation(X.T, Y.T, 1.0)  # as many points, the same ones, in another order
    assert len(evaluated) == 2


def test_it_keeps_the_last_of_it(evaluated: list[int]) -> None:
    sea = small()
    sea.remember(2.5 * X.size * 8)  # room for two fields
    for time in (1.0, 2.0, 1.0, 3.0, 1.0, 2.0):  # the third is of 1.0, which is then younger than 2.0
        sea.elevation(X, Y, time)
    assert len(evaluated) == 4
