"""Regular waves in deep water written to a file as a recorded sea, and their closed forms."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path

import numpy as np
import xarray as xr
from numpy.typing import NDArray

from seamap_rt.conventions import GRAVITY

Array = NDArray
POINTS, SPACING_M, STEP_S, FRAMES, WEST_M = 120, 1.0, 0.1, 50, -60.0


@dataclass(frozen=True)
class KnownWave:
    """a cos(k·x − ωt + φ), t from the file's first frame."""

    amplitude: float
    east: float
    north: float
    phase: float = 0.0

    @property
    def k(self) -> float:
        return float(np.hypot(self.east, self.north))

    @property
    def omega(self) -> float:
        return float(np.sqrt(GRAVITY * self.k))

    def turn(self, x: Array, y: Array, t: Array) -> Array:
        return self.east * x + self.north * y - self.omega * t + self.phase

    def elevation(self, x: Array, y: Array, t: Array) -> Array:
        return self.amplitude * np.cos(self.turn(x, y, t))

    def slopes(self, x: Array, y: Array, t: Array) -> Array:
        return -self.amplitude * np.sin(self.turn(x, y, t))[..., None] * np.array([self.east, self.north])

    def velocity(self, x: Array, y: Array, t: Array) -> Array:
        """Airy's, at the surface."""
        turn, speed = self.turn(x, y, t), self.amplitude * self.omega
        along = speed * np.cos(turn) / self.k
        return np.stack((along * self.east, along * self.north, speed * np.sin(turn)), axis=-1)


WAVE = KnownWave(0.3, 0.21, 0.12, 0.4)


def frames_of(wave: KnownWave, x: Array, y: Array, t: Array) -> Array:
    """(time, y, x) m."""
    return wave.elevation(x, y[:, None], t[:, None, None])


def dataset_of(wave: KnownWave = WAVE, points: int = POINTS, west_m: float = WEST_M) -> xr.Dataset:
    """Frames of the wave on a square patch that ends."""
    axis, times = west_m + SPACING_M * np.arange(points), STEP_S * np.arange(FRAMES)
    return xr.Dataset(
        {"elevation": (("time", "y", "x"), frames_of(wave, axis, axis, times).astype(np.float32), {"units": "m"})},
        {
            "time": ("time", times, {"units": "s"}),
            "y": ("y", axis, {"units": "m"}),
            "x": ("x", axis, {"units": "m"}),
        },
    )


def write(data: xr.Dataset, path: Path) -> str:
    data.to_netcdf(path, engine="h5netcdf")
    return str(path)


def rms(values: Array) -> float:
    return float(np.sqrt(np.mean(np.square(values))))
