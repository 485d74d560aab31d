"""Where an array stands and what its fan-shaped beam meets, in exact float64 geometry, independent of the simulator's.

The fan is the plane through the middle of the two receivers that holds the boresight and the array's upright. A gate's
range is the mean half path of the mode's interferograms: ½ ⟨R_T⟩ over the antennas that send + ¼ (R_lower + R_upper).
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from .seas import Field, Surface

_STEPS = 40  # of Newton at most; six serve a plane
_SETTLED = 1e-13  # of the range: a few hundred ulp
_SOLVED = 1e-11  # of the range: where the fan grazes the water, Newton settles no further


@dataclass(frozen=True)
class Array:
    """How the array stands on n pulses: unit vectors (n, 3) and antennas (n, antenna, 3), east, north, up [m]."""

    across: Field
    boresight: Field
    upright: Field
    antennas: Field

    @classmethod
    def standing(cls, attitude_deg: Field, scan_deg: Field, tilt_deg: float, middle: Field, offsets: Field) -> Array:
        """attitude_deg (n, 3): roll (starboard down), pitch (bow up), heading; scan_deg (n,): of the turntable,
        clockwise of the bow; tilt_deg leans the array's top towards the look; middle (n, 3) of the array in the world;
        offsets (antenna, 3) from it across, along the boresight, up."""
        east, north, up = (np.broadcast_to(axis, middle.shape) for axis in np.eye(3))
        roll, pitch, heading = np.radians(attitude_deg).T
        forward, starboard = _rotated(north, east, heading)
        forward, up = _rotated(forward, up, pitch)
        up, starboard = _rotated(up, starboard, roll)
        look, across = _rotated(forward, starboard, np.radians(scan_deg))
        upright, boresight = _rotated(up, look, np.radians(np.full(scan_deg.shape, tilt_deg)))
        axes = np.stack((across, boresight, upright), axis=1)
        return cls(across, boresight, upright, middle[:, None] + np.einsum("ai,nij->naj", offsets, axes))

    def __getitem__(self, rows: slice) -> Array:
        return Array(self.across[rows], self.boresight[rows], self.upright[rows], self.antennas[rows])

    @property
    def bearing_deg(self) -> Field:
        """(n,) of the boresight, 0 … 360."""
        return np.degrees(np.arctan2(self.boresight[:, 0], self.boresight[:, 1])) % 360.0

    def distances(self, points: Field) -> Field:
        """(n, antenna, m) [m] to points (n, m, 3)."""
        return np.stack(
            [
                np.sqrt(np.sum((points - antenna[:, None]) ** 2, axis=-1))
                for antenna in np.moveaxis(self.antennas, 1, 0)
            ],
            axis=1,
        )

    def fan_meets(self, surface: Surface, ranges: Field, weights: Field, receivers: tuple[int, int] = (0, 1)) -> Field:
        """The point of the surface in the fan at each gate's range, (n, gate, 3); NaN where the gate ends above it.

        ranges (gate,); weights (antenna,): of each antenna's distance in a gate's range, 1 in all. By Newton's method
        from the point at the height of the water below; of several on a steep wave it is one of them.
        """
        middle = self.antennas[:, list(receivers)].mean(axis=1)
        level = _unit(np.cross(self.across, (0.0, 0.0, 1.0)))
        level *= np.sign(np.sum(level * self.boresight, axis=1))[:, None]
        climb = _unit(np.cross(self.across, level))
        climb *= np.sign(climb[:, 2])[:, None]
        clearance = middle[:, 2] - surface.height(middle[:, 0], middle[:, 1])
        down = np.broadcast_to((-clearance / climb[:, 2])[:, None], (middle.shape[0], ranges.size))
        out = np.sqrt(np.maximum(ranges**2 - down**2, (0.05 * ranges) ** 2))  # straight below Newton would be lost
        middle, level, climb = middle[:, None], level[:, None], climb[:, None]
        points, off = np.full((*out.shape, 3), np.nan), np.full(out.shape, np.inf)
        with np.errstate(invalid="ignore", divide="ignore", over="ignore"):
            for _ in range(_STEPS):
                points = middle + out[..., None] * level + down[..., None] * climb
                beyond, toward = self._half_path(points, ranges, weights)
                above, normal = _above(surface, points)
                off = np.maximum(np.abs(beyond), np.abs(above)) / ranges
                if not np.any(off > _SETTLED):
                    break
                a, b = np.sum(toward * level, axis=-1), np.sum(toward * climb, axis=-1)
                c, d = np.sum(normal * level, axis=-1), np.sum(normal * climb, axis=-1)
                determinant = a * d - b * c
                out = out - (beyond * d - above * b) / determinant
                down = down - (above * a - beyond * c) / determinant
            solved = (off < _SOLVED) & (out > 0.0)
        return np.where(solved[..., None], points, np.nan)

    def _half_path(self, points: Field, ranges: Field, weights: Field) -> tuple[Field, Field]:
        """By how much points (n, m, 3) lie beyond their gates, and the gradient of that."""
        beyond, toward = -np.broadcast_to(ranges, points.shape[:2]), np.zeros_like(points)
        for antenna in np.flatnonzero(weights):
            away = points - self.antennas[:, antenna, None]
            length = np.sqrt(np.sum(away**2, axis=-1))
            beyond = beyond + weights[antenna] * length
            toward += weights[antenna] * away / length[..., None]
        return beyond, toward


def _above(surface: Surface, points: Field) -> tuple[Field, Field]:
    """By how much points (n, m, 3) lie above the surface, and the gradient of that."""
    x, y = points[..., 0], points[..., 1]
    east, north = surface.slopes(x, y)
    return points[..., 2] - surface.height(x, y), np.stack((-east, -north, np.ones_like(x)), axis=-1)


def _unit(vectors: NDArray) -> Field:
    return vectors / np.linalg.norm(vectors, axis=-1, keepdims=True)


def phasor(path: Field, wavelength: float) -> NDArray[np.complex128]:
    """exp(−jk path) with whole waves taken off first."""
    return np.exp(-2j * np.pi * np.remainder(path / wavelength, 1.0))


def _rotated(first: Field, second: Field, angle: Field) -> tuple[Field, Field]:
    """Two orthogonal vectors (n, 3), the first turned by an angle (n,) [rad] towards the second."""
    cosine, sine = np.cos(angle)[:, None], np.sin(angle)[:, None]
    return cosine * first + sine * second, cosine * second - sine * first
