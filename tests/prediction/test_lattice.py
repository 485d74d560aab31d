"""The square that waves are fitted on: what comes from outside of what was seen is not told by where it repeats."""

from __future__ import annotations

import numpy as np
import pytest
from free_waves import gaussian_system
from numpy.typing import NDArray

from seamap_rt.prediction import Spectrum
from seamap_rt.prediction.spectrum import Lattice, lattices

Field = NDArray[np.float64]

LEAD, SEEN_S, NOISE, COUNT = 25.0, 10.0, 0.1, 400  # s, s, m, observations
FINE_M = 2400.0  # of a square that no group crosses in that time


def waves(lattice: Lattice, x: Field, y: Field, time: Field) -> Field:
    """Standard deviations (place, 2 wave) at places of the parts of the waves that hold nearly all of the sea."""
    held = lattice.scale > 1e-2 * lattice.scale.max()
    kx, ky, omega, scale = (each[held] for each in (lattice.kx, lattice.ky, lattice.omega, lattice.scale))
    turned = scale * np.exp(1j * (np.outer(x, kx) + np.outer(y, ky) - np.outer(time, omega)))
    return np.hstack((turned.real, -turned.imag))


@pytest.mark.parametrize("reach", [120.0, 180.0])
@pytest.mark.parametrize("period", [9.0, 12.0, 14.0])
@pytest.mark.parametrize("exponent", [30.0, 70.0])
def test_what_a_swell_longer_than_the_circle_leaves_open_is_what_forecasts_err_by(
    reach: float, period: float, exponent: float
) -> None:
    # Exact, over all seas at once: the best forecast by the lattice's waves, for a sea of waves as close as can be.
    swell, across = gaussian_system(0.4, period, 225.0, exponent), gaussian_system(0.1, 5.0, 120.0, 10.0)
    spectrum = Spectrum(swell.k, swell.toward, swell.table + across.table)
    stream = np.random.default_rng(0)
    out, azimuth = reach * np.sqrt(stream.uniform(0.02, 1.0, COUNT)), stream.uniform(0.0, 2.0 * np.pi, COUNT)
    seen = out * np.sin(azimuth), out * np.cos(azimuth), stream.uniform(-SEEN_S, 0.0, COUNT)
    ahead = np.zeros(3), np.zeros(3), np.array([0.6, 1.0, 1.2]) * LEAD
    side = 2 * int(0.25 * FINE_M / (2.0 * np.pi)) + 1
    sea = Lattice.of(spectrum, side, 2.0 * np.pi / FINE_M, (0.0, 0.25), np.inf)
    fitted = lattices(spectrum, reach, SEEN_S + 30.0)[0]
    told, comes = waves(fitted, *seen), waves(fitted, *ahead)
    gain = np.linalg.solve(told @ told.T + NOISE**2 * np.eye(COUNT), told @ comes.T).T
    stated = np.sum(comes**2, axis=1) - np.sum(gain * (comes @ told.T), axis=1)
    missed = waves(sea, *ahead) - gain @ waves(sea, *seen)
    true = np.sum(missed**2, axis=1) + NOISE**2 * np.sum(gain**2, axis=1)
    # The rms error of forecasts is asked for to a tenth; and they are never worth less than none.
    np.testing.assert_allclose(np.sqrt(stated / true), 1.0, atol=0.1)
    assert np.all(true < spectrum.variance)


@pytest.mark.parametrize(("period", "reach"), [(3.0, 100.0), (3.0, 400.0), (4.0, 800.0), (5.5, 800.0)])
def test_squares_for_long_and_short_waves_hold_the_sea(period: float, reach: float) -> None:
    """All but 0.4 % of it, which is left out, and what the corners of a square cut off; each wave in one of them."""
    spectrum = gaussian_system(0.5, period, 225.0, 10.0)
    held = sum(each.variance for each in lattices(spectrum, reach, SEEN_S + 30.0)) / spectrum.variance
    assert 0.99 < held < 1.0
