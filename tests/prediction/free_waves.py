"""Seas of free waves, and what looks of a turning radar see of them."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from seamap_rt.prediction import Observations, Spectrum

Field = NDArray[np.float64]


@dataclass(frozen=True)
class FreeWaves:
    """Plane waves, arrays (wave,): wavevectors [rad/m], frequencies [rad/s] and complex amplitudes [m]."""

    kx: Field
    ky: Field
    omega: Field
    amplitude: NDArray[np.complex128]

    def elevation(self, x: Field, y: Field, time: Field) -> Field:
        """m, at places and times (n,)."""
        phase = np.multiply.outer(x, self.kx) + np.multiply.outer(y, self.ky) - np.multiply.outer(time, self.omega)
        return np.real(np.exp(1j * phase) @ self.amplitude)


def observed(sea: FreeWaves, number: int, looks: int, ranges: Field) -> Observations:
    """A turn of one second by so many looks all around, at ranges [m], each height to 5 cm."""
    look, out = np.meshgrid(np.arange(looks), ranges, indexing="ij")
    azimuth, time = np.radians(360.0 / looks * look).ravel(), number + look.ravel() / looks
    x, y = out.ravel() * np.sin(azimuth), out.ravel() * np.cos(azimuth)
    value = sea.elevation(x, y, time) + 0.05 * np.random.default_rng(number).standard_normal(x.size)
    return Observations(x, y, time, value, np.array([0.05]), np.array(["elevation"]))


def gaussian_system(std: float, period: float, wave_from_deg: float, exponent: float) -> Spectrum:
    """Of an eighth of its frequency's width."""
    peak, omega = 2.0 * np.pi / period, np.linspace(0.2, 4.0, 1200)
    shape = np.exp(-0.5 * ((omega / peak - 1.0) / 0.12) ** 2)
    return Spectrum.of_frequency(omega, std**2 * shape / np.trapezoid(shape, omega), wave_from_deg, exponent)
