"""Power images of a turning radar, real or simulated, measured by the same code: shadow, texture, dispersion.

The level is logarithmic and in any unit, so that all that is compared is free of its scale: shares of cells near the
noise, ratios, correlation lengths, and the energy that keeps the dispersion of waves from turn to turn.
"""

from __future__ import annotations

from dataclasses import dataclass
from itertools import pairwise
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray
from scipy.ndimage import map_coordinates
from scipy.stats import skew

from seamap_rt.conventions import GRAVITY

Array = NDArray[np.float64]

SIDE, CELL = 600.0, 7.5  # m, of the boxes whose waves are followed
SMOOTHED = (7, 5)  # radials × gates
_LONGEST, _SHORTEST = 200.0, 40.0  # m, of the waves that count there


@dataclass(frozen=True)
class Images:
    """level (pulse, gate): logarithm of power. azimuth deg from north; time s; turn; ranges m; drift (east, north) m/s
    of the radar; noise: levels of gates that hold noise alone."""

    level: Array
    azimuth: Array
    time: Array
    turn: NDArray[np.int64]
    ranges: Array
    drift: tuple[float, float]
    noise: Array

    def within(self, sector: tuple[float, float], ranges: tuple[float, float]) -> Images:
        rows = (self.azimuth - sector[0]) % 360.0 <= sector[1] - sector[0]
        gates = (self.ranges >= ranges[0]) & (self.ranges <= ranges[1])
        parts = (self.azimuth[rows], self.time[rows], self.turn[rows], self.ranges[gates])
        return Images(self.level[rows][:, gates], *parts, self.drift, self.noise)


class Ring(NamedTuple):
    """What cells of one ring of range say."""

    distance: float
    mean: float  # over the noise's mean
    spread: float  # standard deviation
    skewness: float
    near_noise: float  # share of cells
    range_length: float  # m, where the autocorrelation falls to a half
    azimuth_length: float
    smoothed_skewness: float  # of levels averaged over SMOOTHED
    smoothed_share: float  # of the variance that this leaves
    range_correlation: tuple[float, ...]  # at lags of 1 to 4 gates


def rings(images: Images, edges: Array) -> list[Ring]:
    """Of the rings between edges [m]. Near noise: cells below the level that 95 % of noise keep below, over 0.95."""
    limit, floor = float(np.quantile(images.noise, 0.95)), float(images.noise.mean())
    found = []
    for least, most in pairwise(edges):
        part = images.level[:, (images.ranges >= least) & (images.ranges < most)]
        middle = 0.5 * (least + most)
        gate = float(images.ranges[1] - images.ranges[0])
        beside = np.diff(images.azimuth)
        step = float(np.radians(np.median(beside[beside > 0.0]))) * middle
        rest = part - part.mean(axis=0)
        smooth = _smoothed(rest, images.turn)
        found.append(
            Ring(
                middle,
                float(part.mean()) - floor,
                float(rest.std()),
                float(skew(rest.ravel())),
                min(1.0, float(np.mean(part < limit)) / 0.95),
                gate * _half(rest),
                step * _half(rest.T),
                float(skew(smooth.ravel())),
                float(smooth.var() / rest.var()),
                tuple(float(np.mean(rest[:, lag:] * rest[:, :-lag]) / rest.var()) for lag in range(1, 5)),
            )
        )
    return found


def _smoothed(field: Array, turn: NDArray[np.int64]) -> Array:
    """Means over SMOOTHED radials × gates of one turn, where all of them are within the field."""
    parts = [np.lib.stride_tricks.sliding_window_view(field[turn == each], SMOOTHED) for each in np.unique(turn)]
    return np.concatenate([each.mean(axis=(-2, -1)) for each in parts])


def _half(field: Array) -> float:
    """Lag along the last axis at which the autocorrelation falls to a half."""
    lags = np.arange(1, field.shape[1] // 2)
    by_lag = np.array([1.0, *(np.mean(field[:, lag:] * field[:, :-lag]) / field.var() for lag in lags)])
    below = int(np.argmax(by_lag < 0.5))
    if not below:
        return float("nan")
    return below - 1.0 + (by_lag[below - 1] - 0.5) / (by_lag[below - 1] - by_lag[below])


class Waves(NamedTuple):
    """Spectra of one box, turn by turn: (turn, ky, kx), when each was taken, and the wavenumbers."""

    spectra: NDArray[np.complex128]
    time: Array
    kx: Array
    ky: Array

    @property
    def counts(self) -> NDArray[np.bool_]:
        k = np.hypot(self.kx, self.ky)
        return (k > 2.0 * np.pi / _LONGEST) & (k < 2.0 * np.pi / _SHORTEST)

    def on_shell(self, current: tuple[float, float] = (0.0, 0.0), faster: float = 1.0) -> Array:
        """(ky, kx) energy of what runs towards k by ω = faster √(g k) + k·U: |Σ F e^{iωt}|² over the turns' number.

        Of nothing that keeps to it 1 of `turns` parts of the whole; of deep waves alone, which run one way, half of it,
        for k and −k hold the same."""
        omega = faster * np.sqrt(GRAVITY * np.hypot(self.kx, self.ky)) + self.kx * current[0] + self.ky * current[1]
        kept = (self.spectra * np.exp(1j * omega * self.time[:, None, None])).sum(axis=0)
        return np.asarray(np.abs(kept) ** 2 / self.time.size, dtype=np.float64)

    @property
    def moving(self) -> Waves:
        """Without what stands still over the turns, as ships, streaks of the wind and the ship's own shadow do."""
        return self._replace(spectra=self.spectra - self.spectra.mean(axis=0))

    @property
    def energy(self) -> Array:
        return np.asarray((np.abs(self.spectra) ** 2).sum(axis=0), dtype=np.float64)


def box(images: Images, azimuth: float, distance: float, side: float = SIDE) -> Waves:
    """Waves in a square of that side [m] about a place, fixed to the ground while the radar drifts. Each gate counts by
    its departure from its mean over all turns, in its standard deviations: the fall with range is no wave."""
    level = (images.level - images.level.mean(axis=0)) / images.level.std(axis=0)
    x0, y0 = distance * np.sin(np.radians(azimuth)), distance * np.cos(np.radians(azimuth))
    axis = np.arange(-0.5 * side, 0.5 * side, CELL)
    x, y = np.meshgrid(x0 + axis, y0 + axis)
    window = np.outer(*2 * (np.hanning(axis.size),))
    spectra, times = [], []
    for number in np.unique(images.turn):
        rows = images.turn == number
        look = np.unwrap(np.radians(images.azimuth[rows]))
        east, north = (drift * images.time[rows].mean() for drift in images.drift)
        angle = np.arctan2(x - east, y - north)
        angle = look[0] + (angle - look[0]) % (2.0 * np.pi)
        row = np.interp(angle, look, np.arange(look.size))
        gate = (np.hypot(x - east, y - north) - images.ranges[0]) / (images.ranges[1] - images.ranges[0])
        seen = map_coordinates(level[rows], [row, gate], order=1, mode="nearest")
        spectra.append(np.fft.fft2((seen - seen.mean()) * window))
        middle = axis.size // 2
        times.append(float(np.interp(angle[middle, middle], look, images.time[rows])))
    k = 2.0 * np.pi * np.fft.fftfreq(axis.size, CELL)
    kx, ky = np.meshgrid(k, k)
    return Waves(np.array(spectra), np.array(times), np.asarray(kx, np.float64), np.asarray(ky, np.float64))


def share(boxes: list[Waves], current: tuple[float, float] = (0.0, 0.0), faster: float = 1.0) -> float:
    """Share of the energy of all boxes that keeps to the shell."""
    kept = sum(float(each.on_shell(current, faster)[each.counts].sum()) for each in boxes)
    return kept / sum(float(each.energy[each.counts].sum()) for each in boxes)


def fastest(boxes: list[Waves], current: tuple[float, float]) -> float:
    """The factor on √(g k) that keeps most energy: 1 for waves of deep water."""
    factors = np.arange(0.3, 1.81, 0.02)
    return float(factors[np.argmax([share(boxes, current, factor) for factor in factors])])


def standing(boxes: list[Waves]) -> float:
    """Share of the energy that stands still."""
    return share(boxes, faster=0.0)


def fitted_current(boxes: list[Waves], most: float = 2.0, step: float = 0.1) -> tuple[float, float]:
    """East and north [m/s], by the largest share on the shell."""
    speeds = np.arange(-most, most + 0.5 * step, step)
    return max(((float(u), float(v)) for u in speeds for v in speeds), key=lambda current: share(boxes, current))


def peaks(boxes: list[Waves], current: tuple[float, float], number: int = 2) -> list[tuple[float, float]]:
    """Wavelength [m] and direction [deg] from which they come, of the strongest waves on the shell, 40° apart."""
    excess = np.sum([each.on_shell(current) - each.energy / each.time.size for each in boxes], axis=0)
    one = boxes[0]
    excess = np.where(one.counts, excess, 0.0)
    comes_from = np.degrees(np.arctan2(-one.kx, -one.ky)) % 360.0
    found: list[tuple[float, float]] = []
    for _ in range(number):
        place = np.unravel_index(np.argmax(excess), excess.shape)
        direction = float(comes_from[place])
        found.append((float(2.0 * np.pi / np.hypot(one.kx[place], one.ky[place])), direction))
        apart = np.abs((comes_from - direction + 180.0) % 360.0 - 180.0)
        excess = np.where(apart < 40.0, 0.0, excess)
    return found
