"""A periodic rectangle of water, its wave numbers, and the way between waves and points.

A field is held as `waves`: complex amplitudes c of c exp(i(kx x + ky y)), rows ky in the order of an FFT (0 … m,
−m … −1), columns kx from 0 to m; those of −kx are their conjugates. Products of fields reach farther than the fields:
a `Band` of that reach holds them. One row, or one column, is a long-crested sea.
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property, lru_cache

import numpy as np
import scipy.fft
from numpy.typing import NDArray

from ...compute.machine import threads
from ...conventions import GRAVITY, SURFACE_TENSION, WATER_DENSITY

Waves = NDArray[np.complex128]
Points = NDArray[np.float64]

_WORTH_THREADS = 1 << 15  # points: below, starting threads takes longer than it saves


@dataclass(frozen=True)
class Band:
    """Wave numbers 2π (i/length_x, j/length_y) with |i| ≤ most_x and |j| ≤ most_y, over water of some depth [m]."""

    length_x: float
    length_y: float
    most_x: int
    most_y: int
    depth: float

    @property
    def shape(self) -> tuple[int, int]:
        """Of an array of waves."""
        return 2 * self.most_y + 1, self.most_x + 1

    @cached_property
    def east(self) -> NDArray[np.float64]:
        """kx (1, column) rad/m."""
        return 2.0 * np.pi / self.length_x * np.arange(self.most_x + 1.0)[None, :]

    @cached_property
    def north(self) -> NDArray[np.float64]:
        """ky (row, 1) rad/m."""
        rows = np.concatenate((np.arange(self.most_y + 1.0), np.arange(-self.most_y, 0.0)))
        return 2.0 * np.pi / self.length_y * rows[:, None]

    @cached_property
    def square(self) -> NDArray[np.float64]:
        """|k|²: ∂²/∂z² of what obeys Laplace's equation."""
        return self.east**2 + self.north**2

    @cached_property
    def rise(self) -> NDArray[np.float64]:
        """k tanh kh: ∂/∂z at the mean level of a potential of 1 there, no water passing the bed."""
        k = np.sqrt(self.square)
        return k if np.isinf(self.depth) else k * np.tanh(k * self.depth)

    @cached_property
    def restoring(self) -> NDArray[np.float64]:
        """g + (T/ρ) k²: pressure over density that an elevation of 1 m has under it."""
        return GRAVITY + SURFACE_TENSION / WATER_DENSITY * self.square

    @cached_property
    def omega(self) -> NDArray[np.float64]:
        """Angular frequency of the linear waves, rad/s."""
        return np.sqrt(self.restoring * self.rise)

    def mean_product(self, one: Waves, other: Waves) -> float:
        """Mean over the rectangle of the product of two fields."""
        products = np.real(np.conj(one) * other)
        return float(2.0 * products.sum() - products[:, 0].sum())

    def to_points(self, waves: Waves, shape: tuple[int, int]) -> Points:
        """The field on rows × columns even points from the origin on; as many at least as the band has waves."""
        rows, columns = shape
        workers = _workers(rows * columns)
        if self.most_y:
            tall = np.zeros((rows, waves.shape[1]), dtype=np.complex128)
            tall[: self.most_y + 1] = waves[: self.most_y + 1]
            tall[rows - self.most_y :] = waves[self.most_y + 1 :]
            waves = np.asarray(scipy.fft.ifft(tall, axis=0, norm="forward", overwrite_x=True, workers=workers))
        elif rows > 1:
            waves = np.repeat(waves, rows, axis=0)
        return np.asarray(scipy.fft.irfft(waves, n=columns, axis=1, norm="forward", workers=workers))

    def to_waves(self, points: Points) -> Waves:
        """The waves of a field on even points; what is beyond the band goes."""
        workers = _workers(points.size)
        waves = np.asarray(scipy.fft.rfft(points, axis=1, norm="forward", workers=workers))[:, : self.most_x + 1]
        if points.shape[0] > 1:
            waves = np.asarray(scipy.fft.fft(waves, axis=0, norm="forward", workers=workers))
        if not self.most_y:
            return waves[:1].copy()
        return np.concatenate((waves[: self.most_y + 1], waves[-self.most_y :]))


def widened(band: Band, reach: tuple[int, int]) -> Band:
    """The same water with waves up to i, j = reach."""
    return _widened(band, reach)


@lru_cache(maxsize=32)
def _widened(band: Band, reach: tuple[int, int]) -> Band:
    return Band(band.length_x, band.length_y, *reach, band.depth)


def fast_size(least: int) -> int:
    """The number of points, at least so many, that an FFT takes fast; 1 stays 1."""
    return int(scipy.fft.next_fast_len(least, real=True)) if least > 1 else 1  # type: ignore[arg-type]


def _workers(points: int) -> int:
    return threads() if points >= _WORTH_THREADS else 1
