"""Covariance of the heights of a sea over distance, from a map of them: ⟨z(x) z(x + d)⟩.

A gappy map's covariance is the correlation of its heights over that of its known points. At the shortest lags, where
the errors of neighbouring cells are correlated, it is that of a smooth surface that fits the lags beyond; lags too
long to matter are faded out, and no wave may have a negative power, so that the result is the covariance of some sea.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray
from scipy.fft import next_fast_len

Map = NDArray[np.float64]

_SIDE = 1.5  # m, of the squares that heights are sorted into
_REACH = 48.0  # m, longest lag: neighbours that a cell is estimated from lie well within it
_FINE = 0.5  # m, spacing of the table, between whose entries it is linear
_ERRORS_M = 3.0  # up to this lag errors of neighbours are correlated: the pulse and the beam overlap
_FIT_M = 10.0  # from lags up to this the covariance is extrapolated to lag 0
_NEAR_M = 150.0  # beyond the nearest cell: farther ones are blurred by the beam, and noisier
_MOST = 1024  # squares a side
_LEAST = 1e-6  # of its own variance, or 0.1 mm squared: never 0


@dataclass(frozen=True)
class SeaCovariance:
    """table[i, j]: covariance [m²] at lags spacing · (i − n, j − n) east, north, of 2n + 1 entries a side."""

    table: Map
    spacing: float

    @property
    def variance(self) -> float:
        """m², at lag 0."""
        middle = self.table.shape[0] // 2
        return float(self.table[middle, middle])

    @classmethod
    def of(cls, height: Map, variance: Map, x: Map, y: Map) -> SeaCovariance:
        """height [m], its error's variance [m²], place east and north [m] of cells, of one shape; NaN are left out."""
        known = np.isfinite(height) & np.isfinite(variance) & np.isfinite(x) & np.isfinite(y)
        away = np.hypot(x, y)
        known &= away <= away[known].min(initial=np.inf) + _NEAR_M
        if not known.any():
            return cls(np.zeros((3, 3)), _FINE)
        if away[known].max() > 0.5 * _SIDE * _MOST:  # too wide a ring: those about the nearest cell, wherever that is
            nearest = np.argmin(np.where(known, away, np.inf))
            x, y = x - x.flat[nearest], y - y.flat[nearest]
            away = np.hypot(x, y)
            known &= away <= 0.5 * _SIDE * _MOST
        z, error = height[known], variance[known]
        sea = (1.4826 * float(np.median(np.abs(z)))) ** 2 + 1e-8
        raw = _correlated(z, sea / (sea + error), x[known], y[known], float(away[known].max()))
        lag = _SIDE * np.arange(-(raw.shape[0] // 2), raw.shape[0] // 2 + 1)
        east, north = np.meshgrid(lag, lag, indexing="ij")
        distance = np.hypot(east, north)
        raw = np.where(distance < _ERRORS_M, _smooth(raw, east, north, distance), raw)
        fade = np.where(distance < _REACH, np.cos(0.5 * np.pi * distance / _REACH) ** 2, 0.0)
        table = _finer(_possible(raw * fade))
        middle = table.shape[0] // 2
        table[middle, middle] += _LEAST * table[middle, middle] + 1e-8
        return cls(table, _FINE)


def _smooth(covariance: Map, east: Map, north: Map, distance: Map) -> Map:
    """The even surface of fourth order that fits the lags between _ERRORS_M and _FIT_M."""
    powers = [(n, order - n) for order in (0, 2, 4) for n in range(order + 1)]
    terms = np.stack([(east / _FIT_M) ** n * (north / _FIT_M) ** m for n, m in powers], axis=-1)
    fitted = (distance >= _ERRORS_M) & (distance <= _FIT_M) & (covariance != 0.0)
    if np.count_nonzero(fitted) < 2 * len(powers):
        return covariance
    return terms @ np.linalg.lstsq(terms[fitted], covariance[fitted], rcond=None)[0]


def _correlated(z: Map, weight: Map, x: Map, y: Map, reach: float) -> Map:
    """Weighted mean products (lag, lag) up to _REACH; 0 at lags at which no two points lie."""
    lags = round(_REACH / _SIDE)
    side = 2 * int(np.ceil(reach / _SIDE)) + 1
    number = np.round(x / _SIDE).astype(int) + side // 2, np.round(y / _SIDE).astype(int) + side // 2
    cell = np.ravel_multi_index(number, (side, side), mode="clip")
    weights = np.bincount(cell, weight, side * side).astype(np.float64).reshape(side, side)
    heights = np.bincount(cell, weight * z, side * side).astype(np.float64).reshape(side, side)
    size = int(next_fast_len(side + lags, real=True) or side + lags)

    def products(field: Map) -> Map:
        power = np.abs(np.fft.rfft2(field, s=[size, size])) ** 2
        near = np.fft.irfft2(power, s=[size, size])
        return np.take(np.take(near, np.arange(-lags, lags + 1), axis=0), np.arange(-lags, lags + 1), axis=1)

    pairs = products(weights)
    return np.where(pairs > 1e-6 * pairs.max(initial=0.0), products(heights) / np.maximum(pairs, 1e-300), 0.0)


def _possible(covariance: Map) -> Map:
    """The nearest of the same variance with no negative power at any wavenumber: less by one level at all of them."""
    power = np.fft.fft2(np.fft.ifftshift(covariance)).real
    down = np.sort(power, axis=None)[::-1]
    if not down.sum() > 0.0:
        return np.zeros(covariance.shape)
    less = (np.cumsum(down) - down.sum()) / np.arange(1, down.size + 1)
    level = less[np.flatnonzero(down > less)[-1]]
    return np.fft.fftshift(np.fft.ifft2(np.maximum(power - level, 0.0)).real)


def _finer(covariance: Map) -> Map:
    """At lags of _FINE, by the waves that it holds."""
    count, times = covariance.shape[0], round(_SIDE / _FINE)
    half = count // 2
    spectrum = np.fft.fftshift(np.fft.fft2(np.fft.ifftshift(covariance)))
    size = count * times
    wide = np.zeros((size, size), dtype=complex)
    start = size // 2 - half
    wide[start : start + count, start : start + count] = spectrum
    fine = np.fft.fftshift(np.fft.ifft2(np.fft.ifftshift(wide)).real) * times**2
    middle, reach = size // 2, half * times
    return np.ascontiguousarray(fine[middle - reach : middle + reach + 1, middle - reach : middle + reach + 1])
