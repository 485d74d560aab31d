"""A sea for the tests of files of spectra: its table, and the assertion that a file was read as this sea."""

from __future__ import annotations

import numpy as np
import pytest
from numpy.typing import NDArray

from seamap_rt.io.spectrumfile import DirectionalTable

HS, FROM_DEG, PEAK_HZ = 1.7, 305.0, 0.11
FREQUENCY = np.linspace(0.04, 0.5, 47)
DIRECTION = np.arange(0.0, 360.0, 5.0)


def true_density() -> NDArray[np.float64]:
    """m²/(Hz·degree) (freq, dir) of the height and direction above."""
    shape = FREQUENCY**-5.0 * np.exp(-1.25 * (PEAK_HZ / FREQUENCY) ** 4)
    spread = np.cos(np.radians(DIRECTION - FROM_DEG) / 2.0) ** 20
    table = shape[:, None] * spread
    return table * (HS / 4.0) ** 2 / np.trapezoid(table.sum(axis=1) * 5.0, FREQUENCY)


def assert_the_sea(table: DirectionalTable, height: float = 1e-6) -> None:
    """height: by what share of it the file may round; to rounding where it holds float64."""
    energy = table.density.sum(axis=1) * 360.0 / table.from_deg.size
    wave = (table.density.sum(axis=0) * np.exp(1j * np.radians(table.from_deg))).sum()
    assert 4.0 * np.sqrt(np.trapezoid(energy, table.frequency_hz)) == pytest.approx(HS, rel=height)
    assert table.frequency_hz[np.argmax(energy)] == pytest.approx(PEAK_HZ, abs=0.006)
    assert np.degrees(np.angle(wave)) % 360.0 == pytest.approx(FROM_DEG, abs=0.01)
