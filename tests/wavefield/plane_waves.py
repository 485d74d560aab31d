"""Plane waves as a turn's map sees them."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
import xarray as xr
from numpy.typing import NDArray

from seamap_rt.conventions import GRAVITY, unit_from_azimuth
from seamap_rt.dataset import QUALITY_FLAGS

MAST = 5.0
GROUND = np.arange(12.0, 150.0, 1.5)
AZIMUTH = 0.9 + 1.8 * np.arange(200)
TIMES: NDArray[np.float64] = (AZIMUTH / 360.0).astype(np.float64)


@dataclass(frozen=True)
class Waves:
    """Plane waves in deep water, arrays (wave,)."""

    k: NDArray[np.float64]  # rad/m
    toward: NDArray[np.float64]  # rad
    amplitude: NDArray[np.complex128]  # m

    def heights(self) -> NDArray[np.float64]:
        """(look, gate), each look at its time."""
        return self._sum(np.ones((AZIMUTH.size, self.k.size)))

    def turns(self, count: int) -> xr.DataTree:
        """Maps of turns a second apart, without noise, with the water's velocity."""
        made = []
        for turn in range(count):
            amplitude = self.amplitude * np.exp(-1j * np.sqrt(GRAVITY * self.k) * turn)
            later = Waves(self.k, self.toward, amplitude)
            polar = maps(later.heights(), later.velocity(), 0.0, "single_cell")["polar"].to_dataset()
            made.append(polar.assign(time=polar["time"] + turn).assign_coords(turn=[turn]))
        return xr.DataTree.from_dict({"/polar": xr.concat(made, "turn", data_vars="all")})

    def velocity(self) -> NDArray[np.float64]:
        """Of the water, outward [m/s]: ω η along the wave's way."""
        return self._sum(np.sqrt(GRAVITY * self.k) * self._along())

    def _along(self) -> NDArray[np.float64]:
        """Cosine between each look and each wave's way."""
        east, north = unit_from_azimuth(AZIMUTH)
        return east[:, None] * np.sin(self.toward) + north[:, None] * np.cos(self.toward)

    def _sum(self, factor: NDArray[np.float64]) -> NDArray[np.float64]:
        """From each gate to the next, all as far apart, a wave's phase turns by as much."""
        along, omega = self.k * self._along(), np.sqrt(GRAVITY * self.k)
        waves = factor * self.amplitude * np.exp(1j * (along * GROUND[0] - omega * TIMES[:, None]))
        turned = np.exp(1j * along * (GROUND[1] - GROUND[0]))
        total = np.empty((AZIMUTH.size, GROUND.size))
        for gate in range(GROUND.size):
            total[:, gate] = waves.real.sum(axis=1)
            waves *= turned
        return total

    def __add__(self, other: Waves) -> Waves:
        k, toward = (np.concatenate(pair) for pair in ((self.k, other.k), (self.toward, other.toward)))
        return Waves(k, toward, np.concatenate((self.amplitude, other.amplitude)))


def random_sea(seed: int, height: float, period: float, comes_from: float, exponent: float = 10.0) -> Waves:
    """JONSWAP × cos^2s, 600 waves, each of random frequency, direction and normal amplitude."""
    rng = np.random.default_rng(seed)
    frequency = np.linspace(0.6, 2.2, 4000) / period
    density = frequency**-5 * np.exp(-1.25 * (frequency * period) ** -4)
    density *= 3.3 ** np.exp(-0.5 * ((frequency * period - 1.0) / 0.08) ** 2)
    chosen = rng.choice(frequency, 600, p=density / density.sum())
    angle = np.linspace(-np.pi, np.pi, 4001)
    spread = np.cos(0.5 * angle) ** (2.0 * exponent)
    toward = np.radians(comes_from + 180.0) + rng.choice(angle, 600, p=spread / spread.sum())
    scale = height / 4.0 / np.sqrt(600.0)
    amplitude = scale * (rng.normal(size=600) + 1j * rng.normal(size=600))
    return Waves((2.0 * np.pi * chosen) ** 2 / GRAVITY, toward, amplitude)


def maps(height: NDArray[np.float64], velocity: NDArray[np.float64], noise: float, estimator: str) -> xr.DataTree:
    """Maps of points, not of means: nothing is averaged away."""
    shape = ("turn", "azimuth", "range")
    polar = xr.Dataset(
        {
            "height": (shape, height[None]),
            "height_std": (shape, np.full_like(height, noise)[None]),
            "radial_velocity": (shape, velocity[None]),
            "ground_range": (shape, np.broadcast_to(GROUND, (1, *height.shape))),
            "quality": (shape, np.where(np.isfinite(height), 0, QUALITY_FLAGS["no_echo"])[None]),
            "time": (shape[:2], TIMES[None]),
        },
        {"turn": [0], "azimuth": AZIMUTH, "range": np.hypot(GROUND, MAST)},
        {"estimator": estimator, "cell_range_m": 1e-3, "cell_azimuth_deg": 1e-3}
        | {"pulse_m": 1e-3, "azimuth_beamwidth_deg": 1e-3},
    )
    return xr.DataTree.from_dict({"/polar": polar})
