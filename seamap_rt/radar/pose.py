"""How the antennas stand in the world: the boat's attitude, the turntable's angle, the lean of the array.

Boat axes are starboard, forward, up. Roll is positive starboard down, pitch bow up, yaw is the heading, clockwise from
north; they are applied yaw, pitch, roll. The turntable turns the array about the boat's own upright axis, so that a
rolling boat swings the boresight and leans the fan-shaped beam. Antenna axes are across (along the aperture, to the
right of the look), boresight, and up the array; `tilt` leans the two latter, the array's top towards the look.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import ArrayLike, NDArray


def boat_axes(attitude_deg: ArrayLike) -> NDArray[np.float64]:
    """Boat axes in the world, (…, 3 axes, 3 east north up), of attitudes (…, 3) roll, pitch, yaw in degrees."""
    roll, pitch, yaw = np.moveaxis(np.radians(np.asarray(attitude_deg, dtype=np.float64)), -1, 0)
    zero, one = np.zeros_like(yaw), np.ones_like(yaw)
    # Columns of R = yaw · pitch · roll are the boat's axes; yaw is clockwise, so against the right-hand rule.
    heading = _rows((np.cos(yaw), np.sin(yaw), zero), (-np.sin(yaw), np.cos(yaw), zero), (zero, zero, one))
    lifted = _rows((one, zero, zero), (zero, np.cos(pitch), -np.sin(pitch)), (zero, np.sin(pitch), np.cos(pitch)))
    heeled = _rows((np.cos(roll), zero, np.sin(roll)), (zero, one, zero), (-np.sin(roll), zero, np.cos(roll)))
    return np.swapaxes(heading @ lifted @ heeled, -1, -2)


def antenna_axes(attitude_deg: ArrayLike, scan_deg: ArrayLike, tilt_deg: float) -> NDArray[np.float64]:
    """Antenna axes in the world, (…, 3 across boresight up, 3 east north up).

    attitude_deg (…, 3) roll, pitch, yaw; scan_deg (…) how far the turntable stands clockwise of the bow.
    """
    boat = boat_axes(attitude_deg)
    scan, tilt = np.radians(np.asarray(scan_deg, dtype=np.float64))[..., None], np.radians(tilt_deg)
    starboard, forward, up = np.moveaxis(boat, -2, 0)
    across = np.cos(scan) * starboard - np.sin(scan) * forward
    ahead = np.sin(scan) * starboard + np.cos(scan) * forward
    return np.stack(
        np.broadcast_arrays(across, np.cos(tilt) * ahead - np.sin(tilt) * up, np.sin(tilt) * ahead + np.cos(tilt) * up),
        axis=-2,
    )


def bearing(axes: NDArray[np.float64]) -> NDArray[np.float64]:
    """Azimuth [deg, 0 … 360) of the boresight of antenna axes (…, 3, 3)."""
    return np.degrees(np.arctan2(axes[..., 1, 0], axes[..., 1, 1])) % 360.0


def scan_of_bearing(attitude_deg: ArrayLike, bearing_deg: ArrayLike, tilt_deg: float) -> NDArray[np.float64]:
    """How far [deg] the turntable stands clockwise of the bow when the boresight bears `bearing_deg`; they broadcast.

    The boresight's horizontal part must lie along the bearing: with r the horizontal direction to the right of it,
    cos τ (sin s starboard + cos s forward)·r = sin τ up·r. NaN where no angle of the turntable does it (an array that
    leans steeply on a boat that heels steeply).
    """
    starboard, forward, up = np.moveaxis(boat_axes(attitude_deg), -2, 0)
    azimuth, tilt = np.radians(np.asarray(bearing_deg, dtype=np.float64)), np.radians(tilt_deg)
    right = np.stack((np.cos(azimuth), -np.sin(azimuth), np.zeros_like(azimuth)), axis=-1)
    s, f, u = (np.sum(axis * right, axis=-1) for axis in (starboard, forward, up))
    size = np.hypot(s, f)
    with np.errstate(invalid="ignore"):
        # s sin x + f cos x = size · sin(x + atan2(f, s)); of the two roots that which looks along the bearing.
        angle = np.arcsin(np.tan(tilt) * u / size) - np.arctan2(f, s)
    return np.degrees(angle) % 360.0


def _rows(*rows: tuple[NDArray[np.float64], ...]) -> NDArray[np.float64]:
    return np.stack([np.stack(row, axis=-1) for row in rows], axis=-2)
