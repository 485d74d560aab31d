"""The sea as a list of waves, and their exact sum: slow, and the reference of all that is fast."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike, NDArray


@dataclass(frozen=True)
class Components:
    """Waves η = Re Σ a exp(i(k·x − ωt)), each array (wave,)."""

    east: NDArray[np.float64]  # kx, rad/m
    north: NDArray[np.float64]  # ky, rad/m
    omega: NDArray[np.float64]  # rad/s
    orbital: NDArray[np.float64]  # horizontal over vertical amplitude of the water's orbit, coth kh
    amplitude: NDArray[np.complex128]  # m

    @staticmethod
    def joined(pieces: list[Components]) -> Components:
        """All waves of several lists."""

        def join(name: str) -> NDArray:
            return np.concatenate([getattr(part, name) for part in pieces] or [np.zeros(0)])

        return Components(join("east"), join("north"), join("omega"), join("orbital"), join("amplitude"))


@dataclass(frozen=True)
class SurfaceState:
    """Elevation (…) m, its rate (…) m/s, slopes (…, 2) east north, the water's velocity (…, 3) m/s east north up."""

    elevation: NDArray[np.float64]
    elevation_rate: NDArray[np.float64]
    slopes: NDArray[np.float64]
    velocity: NDArray[np.float64]


def direct_sum(waves: Components, x: ArrayLike, y: ArrayLike, t: ArrayLike) -> SurfaceState:
    """Linear (Airy 1845) surface and surface velocity, wave by wave in float64. Time grows as points × waves."""
    x, y, t = np.broadcast_arrays(*(np.asarray(v, dtype=np.float64) for v in (x, y, t)))
    k = np.hypot(waves.east, waves.north)
    horizontal = waves.omega * waves.orbital / np.where(k > 0.0, k, 1.0)
    in_phase = np.stack((np.ones_like(k), horizontal * waves.east, horizontal * waves.north))
    in_quadrature = np.stack((waves.omega, -waves.east, -waves.north))
    # A lattice has few distinct kx and ky: one exponential for each, not for every wave.
    east, east_index = np.unique(waves.east, return_inverse=True)
    north, north_index = np.unique(waves.north, return_inverse=True)

    result = np.empty((x.size, 6))
    for time in np.unique(t):
        moved = waves.amplitude * np.exp(-1j * np.remainder(waves.omega * time, 2.0 * np.pi))
        for point in np.flatnonzero(t.ravel() == time):
            across = np.exp(1j * east * x.flat[point])[east_index]
            along = np.exp(1j * north * y.flat[point])[north_index]
            wave = moved * across * along
            result[point, :3] = in_phase @ wave.real
            result[point, 3:] = in_quadrature @ wave.imag
    elevation, flow_east, flow_north, rate, slope_east, slope_north = (column.reshape(x.shape) for column in result.T)
    return SurfaceState(
        elevation,
        rate,
        np.stack((slope_east, slope_north), axis=-1),
        np.stack((flow_east, flow_north, rate), axis=-1),
    )
