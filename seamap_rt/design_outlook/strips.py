"""Strips of random sea, each long along a look and a few beams wide, with the statistics of the scene's waves.

A strip's surface is a sum over wavenumbers along and across its look. Of each wave system the variance between two
wavenumbers and two directions goes to the strip's nearest wavenumbers, so that lines along the look have the spectrum
that the sea has along it: what hides behind crests depends on nothing else. The draws are the same for every scene,
so that designs are compared on the same seas.
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import lru_cache
from typing import NamedTuple

import numpy as np
import scipy.fft
from numpy.typing import NDArray

from ..conventions import unit_from_azimuth
from ..sea.systems import spectral_system, travel_direction
from ..settings import RandomWaves, SeaSettings, SinusoidWaves

Array = NDArray[np.float64]

LOOKS = 16
ROWS, ROW_M = 16, 0.75  # of a strip, across the look: 12 m, which repeat
_DIRECTIONS = 80  # of waves: a multiple of LOOKS, so that strips share their wavenumbers
_WAVENUMBERS = 240
_LONGEST = 1e-3  # rad/m
_SHORTEST_STEPS = 3.0  # of the strip in the shortest wave
_MOST_STEPS = 8192
_WAVES = 6.0  # of the mean length, that a strip is long at least: its wavenumbers are multiples of 2π over it
_STREAM = 20041124


class Waves(NamedTuple):
    """The sea's variance [m²] by wavenumber [rad/m] (k,) and azimuth of travel (direction,), (k, direction)."""

    wavenumber: Array
    variance: Array

    @property
    def elevation_variance(self) -> float:
        """m²."""
        return float(self.variance.sum())

    @property
    def mean_length(self) -> float:
        """Wavelength [m] at the mean wavenumber by variance; 0 without waves."""
        moment = float(np.sum(self.variance.sum(axis=1) * self.wavenumber))
        return 2.0 * np.pi * self.elevation_variance / moment if moment > 0.0 else 0.0

    @property
    def slope_variance(self) -> float:
        """In one direction, the mean over all."""
        return 0.5 * float(np.sum(self.variance.sum(axis=1) * self.wavenumber**2))


@dataclass(frozen=True)
class Strips:
    """height (look, row, step) [m] at distances (step,) [m] from the mast; azimuth (look,) [deg]."""

    height: NDArray[np.float32]
    distance: Array
    azimuth: Array

    @property
    def step(self) -> float:
        return float(self.distance[1] - self.distance[0])


def azimuths() -> Array:
    """Of the looks, deg."""
    return (np.arange(LOOKS) + 0.5) * 360.0 / LOOKS


def directions() -> Array:
    """Azimuths [deg] that waves run to, (direction,)."""
    return (np.arange(_DIRECTIONS) + 0.5) * 360.0 / _DIRECTIONS


def waves_of(sea: SeaSettings, limit: float) -> Waves:
    """Of all systems, of waves below `limit` rad/m; regular waves of any length count as one direction and one k."""
    edges = np.geomspace(_LONGEST, limit, _WAVENUMBERS + 1)
    k, width = np.sqrt(edges[1:] * edges[:-1]), np.diff(edges)
    toward = directions()
    variance = np.zeros((k.size, toward.size))
    east, north = unit_from_azimuth(toward)
    for waves in sea.waves:
        if isinstance(waves, SinusoidWaves):
            way = travel_direction(waves)
            nearest = int(np.argmax(east * way[0] + north * way[1]))
            variance[np.abs(k - 2.0 * np.pi / waves.wavelength_m).argmin(), nearest] += 0.125 * waves.height_m**2
        elif isinstance(waves, RandomWaves):
            system = spectral_system(waves, sea.depth_m)
            radial = np.where(k < system.shortest, system.radial(k), 0.0) * width
            along = system.toward[0] * east + system.toward[1] * north
            if system.spreading is None:
                share = np.zeros((1, toward.size))
                share[0, int(np.argmax(along))] = 1.0
            else:
                across = system.toward[0] * north - system.toward[1] * east
                share = np.broadcast_to(system.spreading(k[:, None], along, across), variance.shape)
                share = share / np.maximum(share.sum(axis=1, keepdims=True), 1e-300)
            variance += radial[:, None] * share
    return Waves(k, variance)


@lru_cache(maxsize=4)
def _draws(half: int) -> NDArray[np.complex64]:
    """Waves of random phase and variance 2 (look, row, wave): all of the size expected, so that a few strips hold the
    sea's whole variance."""
    phase = np.random.default_rng(_STREAM).random((LOOKS, half, ROWS), dtype=np.float32)  # longer strips begin alike
    return np.ascontiguousarray((np.sqrt(2.0) * np.exp(2j * np.pi * phase)).transpose(0, 2, 1).astype(np.complex64))


def strips(waves: Waves, length: float, shortest: float) -> Strips:
    """Strips of that length [m] and of some wavelengths at least; the shortest wave [m] has three steps or more."""
    length = max(length, _WAVES * waves.mean_length)
    step = max(shortest / _SHORTEST_STEPS, length / _MOST_STEPS)
    wanted = int(np.ceil(length / step))
    count = int(scipy.fft.next_fast_len(wanted, real=True) or wanted)
    half = count // 2 + 1
    along, across = 2.0 * np.pi / (count * step), 2.0 * np.pi / (ROWS * ROW_M)
    look, toward = azimuths(), directions()
    turned = np.radians(toward - look[0])
    k = waves.wavenumber[:, None]
    forward, aside = k * np.cos(turned) / along, k * np.sin(turned) / across
    # A wave that runs towards the mast has the same surface as its mirror image's that runs away.
    back = forward < 0.0
    column = np.minimum(np.rint(np.abs(forward)).astype(np.int64), half - 1)
    row = np.rint(np.where(back, -aside, aside)).astype(np.int64) % ROWS
    place = (row * half + column).ravel()
    turn = _DIRECTIONS // LOOKS
    power = np.stack(
        [np.bincount(place, np.roll(waves.variance, -turn * n, axis=1).ravel(), ROWS * half) for n in range(LOOKS)]
    ).reshape(LOOKS, ROWS, half)
    power[..., 1:] *= 0.25 if half > 1 else 1.0  # a pair of opposite waves; in column 0 both are in the sum already
    wave = np.sqrt(power).astype(np.float32) * _draws(half)
    height: NDArray[np.float32] = np.asarray(
        scipy.fft.irfft2(wave, s=(ROWS, count), axes=(1, 2), norm="forward", workers=-1, overwrite_x=True), np.float32
    )
    return Strips(height, step * (np.arange(count, dtype=np.float64) + 0.5), look)
