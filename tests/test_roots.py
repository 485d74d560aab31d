"""Roots of functions of one number, beside SciPy's."""

from __future__ import annotations

import math
from collections.abc import Callable

import numpy as np
import pytest
from scipy.optimize import brentq

from seamap_rt.radar.antenna import bracketed_root


def _taper(length: float, beam_deg: float) -> Callable[[float], float]:
    """A line source's excess over −3 dB at the edge of its beam, as `radar.antenna` asks for it."""
    half = length * math.sin(0.5 * math.radians(beam_deg))

    def excess(taper: float) -> float:
        inside = taper**2 - half**2
        root = max(math.pi * math.sqrt(abs(inside)), 1e-8)
        whole = max(math.pi * taper, 1e-8)
        wave = math.sinh(root) if inside > 0.0 else math.sin(root)
        return wave / root * whole / math.sinh(whole) - math.sqrt(0.5)

    return excess


def test_tapers_have_scipys_bits() -> None:
    """So that voltages are what they were when SciPy looked for them."""
    random = np.random.default_rng(1)
    looked_at = 0
    for _ in range(500):
        length = 10.0 ** random.uniform(0.3, 3.0)
        narrowest = 2.0 * math.degrees(math.asin(min(1.0, 0.443 / length)))
        function = _taper(length, min(120.0, narrowest * 10.0 ** random.uniform(0.01, 0.8)))
        if function(0.0) > 0.0:
            continue
        top = 1.0
        while function(top) < 0.0:
            top *= 2.0
        assert bracketed_root(function, 0.0, top) == brentq(function, 0.0, top, xtol=1e-12)
        looked_at += 1
    assert looked_at > 300


@pytest.mark.parametrize(
    ("function", "low", "high"),
    [
        (lambda x: x**3 - 2.0 * x - 5.0, 2.0, 3.0),
        (lambda x: math.cos(x) - x, 0.0, 1.0),
        (lambda x: math.exp(-x) - 1e-3, 0.0, 50.0),
        (lambda x: math.copysign(1.0, x - 0.3), -1.0, 2.0),
        (lambda x: x, 0.0, 1.0),
        (lambda x: x - 1.0, 0.0, 1.0),
    ],
)
def test_other_roots_have_scipys_bits(function: Callable[[float], float], low: float, high: float) -> None:
    assert bracketed_root(function, low, high) == brentq(function, low, high, xtol=1e-12)


def test_a_root_that_is_not_reached_is_no_root() -> None:
    with pytest.raises(ValueError, match="not reached"):
        bracketed_root(lambda x: (x - 1.0) ** 9, 0.0, 2.5)


def test_without_a_change_of_sign_there_is_none() -> None:
    with pytest.raises(ValueError, match="change its sign between 0 and 1"):
        bracketed_root(lambda x: x + 1.0, 0.0, 1.0)
