"""The directional spectrum that buoys' velocities show (Kuik, van Vledder & Holthuijsen 1988)."""

from __future__ import annotations

import numpy as np
from numpy.typing import ArrayLike, NDArray
from scipy.signal import csd, detrend

from ..errors import InputError
from ..physics.dispersion import DEEP_WATER, Water
from .spectrum import Spectrum

_SEGMENT = 256  # samples of a periodogram
_LEAST, _MOST = 0.05, 0.97  # length of a frequency's mean direction: of an even fan 0, of one direction 1


def spectrum_of_buoys(
    up: ArrayLike,
    east: ArrayLike,
    north: ArrayLike,
    sampling_hz: float,
    band_hz: tuple[float, float] = (0.05, 0.5),
    water: Water = DEEP_WATER,
) -> Spectrum:
    """The expected spectrum of a sea by its buoys, cos^2s about each frequency's own direction.

    up, east, north: velocities [m/s] of buoys that follow the water, (sample,) or (buoy, sample), of at least 256
    samples. band_hz: frequencies that are used, without a mooring's and the sensors' slow ones. The height's density is
    that of `up` over ω², in any depth. For `reconstruct(…, observations=…, spectrum=…)`, and to compare a sea's
    `variance` and `peak_period` with a buoy's. Raises InputError for records of unlike shapes, too short ones, and
    values that are not finite.
    """
    velocities = {
        name: np.atleast_2d(np.asarray(each, float)) for name, each in zip("uen", (up, east, north), strict=True)
    }
    shapes = [each.shape for each in velocities.values()]
    if len(set(shapes)) > 1 or shapes[0][-1] < _SEGMENT or not all(np.isfinite(v).all() for v in velocities.values()):
        raise InputError(
            f"up, east, north: have shapes {', '.join(map(str, shapes))}: must be finite and alike, of {_SEGMENT} "
            "samples or more; cut the records to what all hold"
        )
    slow, fast = band_hz
    if not 0.0 < slow < fast <= 0.5 * sampling_hz:
        raise InputError(
            f"band_hz = {slow:g} to {fast:g}: must rise, from above 0 to {0.5 * sampling_hz:g} at most, half of "
            "sampling_hz; give both in Hz"
        )

    def cross(one: str, other: str) -> tuple[NDArray[np.float64], NDArray[np.complex128]]:
        frequency, power = csd(detrend(velocities[one]), detrend(velocities[other]), sampling_hz, nperseg=_SEGMENT)
        inside = (frequency > slow) & (frequency < fast)
        return frequency[inside], power.mean(axis=0)[inside]

    frequency, up_power = cross("u", "u")
    omega, power = 2.0 * np.pi * frequency, up_power.real
    level = np.sqrt(power * (cross("e", "e")[1].real + cross("n", "n")[1].real)).clip(1e-300)
    # Water goes with the wave where it is highest, a quarter of a turn after it rises.
    toward_x, toward_y = (-cross("u", each)[1].imag / level for each in "en")
    k, toward = Spectrum.even()
    ring = water.wavenumber(omega)
    mean_x, mean_y, line = (np.interp(k, ring, each, 0.0, 0.0) for each in (toward_x, toward_y, power / omega**2))
    length = np.clip(np.hypot(mean_x, mean_y), _LEAST, _MOST)
    s = length / (1.0 - length)
    spread = np.abs(np.cos(0.5 * (toward - np.arctan2(mean_x, mean_y)[:, None]))) ** (2.0 * s[:, None])
    spread /= spread.mean(axis=1, keepdims=True) * 2.0 * np.pi
    return Spectrum(k, toward, (line / (2.0 * np.pi) * water.group_speed(k) / k)[:, None] * spread, water)
