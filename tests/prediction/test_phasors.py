"""e^j(k·x − ωt) by series: NumPy's exponential of the same phases."""

from __future__ import annotations

import numpy as np
import pytest

from seamap_rt.prediction.phasors import phasors

EPSILON = float(np.finfo(np.float64).eps)


@pytest.mark.parametrize("reach", [1.0, 100.0, 1e5])  # m; phases of a few radians to some 10⁵
def test_phasors_are_exponentials_of_their_phases(reach: float) -> None:
    stream = np.random.default_rng(5)
    kx, ky, omega = stream.uniform(-3.0, 3.0, (3, 200))
    x, y, time = reach * stream.uniform(-1.0, 1.0, (3, 300))
    terms = np.stack((np.outer(x, kx), np.outer(y, ky), -np.outer(time, omega)))
    # Both sums of three products round each term; the series itself is right to 3e-14.
    rounding = 4.0 * EPSILON * np.abs(terms).sum(axis=0)
    assert np.all(np.abs(phasors(kx, ky, omega, x, y, time) - np.exp(1j * terms.sum(axis=0))) <= 3e-14 + rounding)


def test_phasors_are_right_on_each_quarter_and_between() -> None:
    eighths = np.arange(-16, 17) * (0.25 * np.pi)
    angles = np.asarray([*eighths, *np.nextafter(eighths, -np.inf), *np.nextafter(eighths, np.inf)], np.float64)
    one, none = np.ones(1), np.zeros(1)
    made = phasors(angles, none.repeat(angles.size), none.repeat(angles.size), one, none, none)[0]
    assert np.allclose(made, np.exp(1j * angles), rtol=0.0, atol=3e-14)


def test_phasors_of_single_precision_are_those_rounded() -> None:
    stream = np.random.default_rng(6)
    kx, ky, omega = stream.uniform(-3.0, 3.0, (3, 50))
    x, y, time = stream.uniform(-50.0, 50.0, (3, 40))
    single = phasors(kx, ky, omega, x, y, time, np.complex64)
    assert np.array_equal(single, phasors(kx, ky, omega, x, y, time).astype(np.complex64))
