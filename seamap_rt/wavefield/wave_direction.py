"""Where the waves come from, from one map: their axes by the heights, the way along them by the water's velocity.

A height map alone does not separate a wave from the same wave run backwards. But water moves with the wave on its
crests and against it in its troughs: at the surface u = ω coth(kh) η d, of a wave of frequency ω that runs towards d
in water of depth h (Airy 1845; coth kh is 1 in deep water). Seen along looks l it is v = u·l, and the mean of η v l is
½ σ² ω coth(kh) d over looks all around, M σ² ω coth(kh) d with M = mean of l lᵀ over those of a sector. Depth changes
its length alone, not its direction. What is uncorrelated with the height is no wave: the current, and the Bragg waves
and breakers that run on the water with the wind. Swell may run against the wind sea: each length of wave has its own
way.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
import scipy.fft
from numpy.typing import NDArray

from ..conventions import unit_from_azimuth
from ..radar.waveform import next_fast_len

_FEWEST_CELLS = 100  # of a map that gives a direction
_UNSEEN = 1e-3  # of the best seen direction's weight: below it the looks do not see one at all
_BAND = 1.3  # ratio of wavenumbers from one band to the next
_PASSES = 4  # the half planes turn with the directions found; they have converged by then


@dataclass(frozen=True)
class Travel:
    """Which way waves run, by bands of wavenumber [rad/m], ascending: vectors to the east and north, as long as the
    band counts."""

    wavenumber: NDArray[np.float64]
    east: NDArray[np.float64]
    north: NDArray[np.float64]

    @classmethod
    def from_direction(cls, wave_from_deg: float) -> Travel:
        """All waves run from one direction [deg clockwise from north]. Raises ValueError if it is not finite."""
        if not np.isfinite(wave_from_deg):
            raise ValueError(f"wave_from_deg = {wave_from_deg:g}: must be finite; give an azimuth in degrees")
        east, north = unit_from_azimuth([wave_from_deg])
        return cls(np.ones(1), -east, -north)

    @property
    def wave_from_deg(self) -> float:
        """Mean azimuth the waves come from, [0, 360) deg; NaN if there is none."""
        east, north = float(self.east.sum()), float(self.north.sum())
        return float(np.degrees(np.arctan2(-east, -north)) % 360.0) if np.hypot(east, north) > 0.0 else float("nan")

    def travel_sign(self, kx: NDArray[np.float64], ky: NDArray[np.float64]) -> NDArray[np.float64]:
        """1 where waves run along the wavevector (kx east, ky north; rad/m), −1 where against it, 0 where unknown."""
        log_wavenumber = np.log(np.maximum(np.hypot(kx, ky), 1e-12))
        bands = np.log(self.wavenumber)
        return np.sign(
            kx * np.interp(log_wavenumber, bands, self.east) + ky * np.interp(log_wavenumber, bands, self.north)
        )


def travel(
    height: NDArray[np.float64],
    height_std: NDArray[np.float64],
    radial_velocity: NDArray[np.float64],
    azimuth_deg: NDArray[np.float64],
    ground_range: NDArray[np.float64],
    side: float,
) -> Travel:
    """Which way the waves of a polar map run, without the ambiguity of 180°; its vectors are m²/s times a factor.

    Arrays (look, gate): height, height_std [m], radial_velocity [m/s] away from the radar, ground_range [m]; NaN cells
    count nothing. azimuth_deg (look,). side: of the squares that cells are gathered in [m]. Of a sector that sees
    waves from one side alone, what they do along it. All zero for a map that gives none.
    """
    fields = (height, height_std, radial_velocity, ground_range)
    known = np.logical_and.reduce([np.isfinite(field) for field in fields])
    if np.count_nonzero(known) < _FEWEST_CELLS:
        return Travel(np.ones(1), np.zeros(1), np.zeros(1))
    eta, spread, velocity, distance = (field[known] for field in fields)
    looks = np.array([np.broadcast_to(part[:, None], height.shape)[known] for part in unit_from_azimuth(azimuth_deg)])
    weight = 1.0 / (_variance(eta) + spread**2)
    eta = eta - np.average(eta, weights=weight)
    along = looks * (velocity - _drift(looks, eta, velocity, weight) @ looks)

    half = int(np.ceil(distance.max() / side))
    size = 2 * half + 1
    column, row = np.rint(looks * distance / side).astype(np.intp) + half
    square = row * size + column
    count = np.maximum(np.bincount(square, minlength=size * size), 1)
    heights, east, north = (
        np.asarray(scipy.fft.rfft2((np.bincount(square, weight * each, size * size) / count).reshape(size, size)))
        for each in (eta, *along)
    )
    seen = np.linalg.pinv((weight * looks) @ looks.T / weight.sum(), rcond=_UNSEEN, hermitian=True)
    cross = np.array([np.real(heights.conj() * each) for each in (east, north)])
    return _sum_bands(np.tensordot(seen, cross, axes=1), side, size)


def map_travel(height: NDArray[np.float64], height_std: NDArray[np.float64], side: float, direction: Travel) -> Travel:
    """Which way the waves of a ground map run, each counted by its energy: `wave_from_deg` is the mean direction.

    height, height_std [m] are (y, x), rows to the north, on squares of `side` [m], NaN where unknown. Of the two ways
    along its axis a wave runs the one nearer to its band's, whose first guess is `way`. Noise and gaps spread over all
    directions alike, and turn a band no way. Over the few wavelengths that a map spans the sea's own mean strays from
    its spectrum's by some degrees. All zero for a map that gives none.
    """
    known = np.isfinite(height) & np.isfinite(height_std)
    if np.count_nonzero(known) < _FEWEST_CELLS:
        return Travel(np.ones(1), np.zeros(1), np.zeros(1))
    weight = np.zeros(height.shape)
    weight[known] = 1.0 / (_variance(height[known]) + height_std[known] ** 2)
    eta = np.where(known, height, 0.0)
    eta = weight * (eta - np.average(eta, weights=weight))
    size = next_fast_len(max(eta.shape))
    energy = np.abs(np.asarray(scipy.fft.rfft2(eta, s=(size, size)))) ** 2
    kx, ky = wavevectors(side, (size, size))
    k = np.maximum(np.hypot(kx, ky), 1e-12)
    for _ in range(_PASSES):
        forth = direction.travel_sign(kx, ky) * energy / k
        direction = _sum_bands(np.array([forth * kx, forth * ky]), side, size)
    return direction


def _drift(
    looks: NDArray[np.float64], eta: NDArray[np.float64], velocity: NDArray[np.float64], weight: NDArray[np.float64]
) -> NDArray[np.float64]:
    """The vector a (2,) of v = (a + η b)·l, fitted to cells: looks (2, cell), the others (cell,)."""
    terms = np.concatenate((looks, eta * looks))
    scale = np.maximum(np.sqrt((weight * terms**2).sum(axis=1)), 1e-12)
    terms = terms / scale[:, None]
    inverse = np.linalg.pinv((weight * terms) @ terms.T, rcond=_UNSEEN, hermitian=True)
    return ((inverse @ (terms @ (weight * velocity))) / scale)[:2]


def _sum_bands(vectors: NDArray[np.float64], side: float, size: int) -> Travel:
    """Sums over bands of the vectors (2, row, column) of a half spectrum, each band with a half of its neighbours."""
    k = np.hypot(*wavevectors(side, (size, size)))
    first = 2.0 * np.pi / (side * size)
    count = int(np.ceil(np.log(np.pi / side / first) / np.log(_BAND))) + 1
    with np.errstate(divide="ignore"):
        band = np.clip(np.rint(np.log(k / first) / np.log(_BAND)), 0, count - 1).astype(np.intp)
    # The half spectrum holds both ways of the waves in its first column, one way of all others.
    both = np.where(np.arange(k.shape[1]) == 0, 0.5, 1.0)
    both = np.where(k > 0.0, both, 0.0)
    east, north = (np.bincount(band.ravel(), (both * vector).ravel(), count) for vector in vectors)
    smooth = (0.25, 0.5, 0.25)
    wavenumber = first * _BAND ** np.arange(count, dtype=np.float64)
    return Travel(wavenumber, *(np.convolve(each, smooth, "same").astype(np.float64) for each in (east, north)))


def wavevectors(side: float, shape: tuple[int, int]) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
    """kx (1, column) and ky (row, 1) [rad/m] of the half spectrum of a map of that shape on squares of `side` [m]."""
    kx, ky = np.fft.rfftfreq(shape[1], side)[None, :], np.fft.fftfreq(shape[0], side)[:, None]
    return np.asarray(2.0 * np.pi * kx, dtype=np.float64), np.asarray(2.0 * np.pi * ky, dtype=np.float64)


def _variance(height: NDArray[np.float64]) -> float:
    """Variance [m²] of Gaussian heights, by their median, which wild ones do not move."""
    return max(float(np.median(np.abs(height - np.median(height))) / 0.6745) ** 2, 1e-12)


__all__ = ["Travel", "map_travel", "travel", "wavevectors"]
