"""Covariance of the heights of a sea over distance, from a map of them: ⟨z(x) z(x + d)⟩.

A gappy map's covariance is the correlation of its heights over that of its known points. At the shortest lags the
errors of neighbouring cells are correlated, and waves shorter than the radar's footprint are hardly in the map at all.
Both are found from what is known of every wind sea: beyond its peak the spectrum falls as k⁻⁴ (Phillips 1958, 1985),
from the level that the map's own waves have. Lags too long to matter are faded out, and no wave may have a negative
power, so that the result is the covariance of some sea.
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import lru_cache

import numpy as np
import scipy.fft
from numpy.typing import NDArray
from scipy.fft import next_fast_len
from scipy.ndimage import gaussian_filter

from ..compute.compiled import compiled

Map = NDArray[np.float64]

_SIDE = 1.5  # m, of the squares that heights are sorted into
_REACH = 84.0  # m, longest lag: a Gaussian fade of a quarter of that keeps a swell's power apart from waves of 30 m
_TABLE = 60.0  # m, longest lag of the table: neighbours that a cell is estimated from lie well within it
_MARGIN = 5  # waves that long ones are blurred by
_SHARPENINGS = 12  # iterations: what is left of the fade then is less than what a turn knows of its sea
_FINE = 0.5  # m, spacing of the table, between whose entries it is linear
_FINEST = 0.3  # m, shortest waves whose slopes count
_ERRORS_M = 3.0  # up to this lag errors of neighbours are correlated: the pulse and the beam overlap
# Waves shorter than seven of the footprint's standard deviations, or than a few of the errors' lags, 10 m, are taken to
# follow Phillips's law.
_SHORT, _SHORTEST = 0.9, 0.6  # rad, rad/m
# From where on waves show it, of that: the lowest is known best, but of a young sea the peak lies above.
_SATURATED = 0.4, 0.53, 0.7
_SILENT = 2.0  # of that: beyond, the footprint leaves nothing but what the map's covariance is uncertain by
_NEAR_M = 150.0  # beyond the nearest cell: farther ones are blurred by the beam, and noisier
_MOST = 1024  # squares a side
_CUT = 3.0  # standard deviations, at which a Gaussian blur ends
_LEAST = 1e-6  # of its own variance, or 0.1 mm squared: never 0
_ERROR_DOUBT, _SEA_DOUBT = 0.05, 0.3  # of the variances of the errors, and of the sea that one turn shows
_PASSES = 12


@dataclass(frozen=True)
class SeaCovariance:
    """table[i, j]: covariance [m²] at lags spacing · (i − n, j − n) east, north, of 2n + 1 entries a side.

    slope_variance: of the surface's slope in one direction, the mean of all directions, with waves down to decimetres.
    unresolved: m², of waves of about `shortest` [rad/m], as short as the footprint, by which heights vary more than the
    table and their errors say.
    """

    table: Map
    spacing: float
    slope_variance: float = 0.0
    unresolved: float = 0.0
    shortest: float = 0.0

    @property
    def variance(self) -> float:
        """m², at lag 0."""
        middle = self.table.shape[0] // 2
        return float(self.table[middle, middle])

    def blurred(self, variance: float) -> Map:
        """The table between two means of heights over areas, whose variances a side [m²] add up to `variance`."""
        spread = np.sqrt(variance) / self.spacing
        away = np.arange(1 + round(_CUT * spread))
        weights = np.exp(-0.5 * (away / max(spread, 1e-9)) ** 2)
        weights /= 2.0 * weights.sum() - 1.0
        field = self.table
        for _ in range(2):
            blurred = np.empty(field.shape)
            blur_rows(np.ascontiguousarray(field), weights, blurred)
            field = blurred.T
        return field

    def unresolved_mean(self, along: float, across: Map) -> Map:
        """What is unresolved of the mean over an area [m²] of these sides [m]."""
        return self.unresolved * np.exp(-(self.shortest**2) * (along**2 + across**2) / 24.0)

    @classmethod
    def of(
        cls, height: Map, variance: Map, x: Map, y: Map, footprint: tuple[float, float] = (0.0, 0.0)
    ) -> SeaCovariance:
        """height [m], its error's variance [m²], place east and north [m] of cells, of one shape; NaN are left out.

        footprint: standard deviations of the area that a height is the mean of, along the look [m] and across it [rad].
        """
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
        weight = sea / (sea + error)
        raw, least = _correlated(z, error, weight, x[known], y[known], float(away[known].max()))
        lag = _SIDE * np.arange(-(raw.shape[0] // 2), raw.shape[0] // 2 + 1)
        distance = np.hypot(*np.meshgrid(lag, lag, indexing="ij"))
        fade = np.exp(-8.0 * (distance / _REACH) ** 2) * (distance < _REACH)
        across = footprint[1] ** 2 * float(weight @ away[known] ** 2 / weight.sum())
        blur = 0.5 * (footprint[0] ** 2 + across) + _SIDE**2 / 12.0
        shortest = min(_SHORTEST, _SHORT / np.sqrt(blur))
        table, steepness = _completed(np.where(distance < _ERRORS_M, 0.0, raw * fade), blur, fade, shortest)
        middle = table.shape[0] // 2
        # Of a map a few waves wide the lags say little, but its heights how high the sea is.
        table *= max(1.0, least / max(float(table[middle, middle]), 1e-12))
        table[middle, middle] += _LEAST * table[middle, middle] + 1e-8
        unresolved = _unresolved(z, error, float(table[middle, middle])) * float(np.exp(shortest**2 * blur))
        return cls(table, _FINE, steepness, unresolved, float(shortest))


def _unresolved(z: Map, error: Map, sea: float) -> float:
    """Variance [m²] of heights z (n,) beyond that of their errors and of a sea, as far as neither may be wrong by it:
    the likeliest, by which the surest heights count most."""
    error = (1.0 + _ERROR_DOUBT) * error
    found = max(sea, 1e-6)
    for _ in range(_PASSES):
        weight = (found + error) ** -2.0
        found = max(float(weight @ (z**2 - error) / weight.sum()), 1e-6)
    return max(0.0, found - (1.0 + _SEA_DOUBT) * sea)


def _correlated(z: Map, error: Map, weight: Map, x: Map, y: Map, reach: float) -> tuple[Map, float]:
    """Weighted mean products (lag, lag) up to _REACH; 0 at lags at which no two points lie.

    Of one variance: that of the sea where the pairs of a lag lie, which differs by their long waves, is taken off.
    Its mean is the second result.
    """
    lags = round(_REACH / _SIDE)
    side = 2 * int(np.ceil(reach / _SIDE)) + 1
    number = np.round(x / _SIDE).astype(int) + side // 2, np.round(y / _SIDE).astype(int) + side // 2
    cell = np.ravel_multi_index(number, (side, side), mode="clip")
    weights = np.bincount(cell, weight, side * side).astype(np.float64).reshape(side, side)
    heights = np.bincount(cell, weight * z, side * side).astype(np.float64).reshape(side, side)
    size = int(next_fast_len(side + lags, real=True) or side + lags)

    squares = np.bincount(cell, weight * (z**2 - error), side * side).astype(np.float64).reshape(side, side)
    waves = [np.fft.rfft2(field, s=[size, size]) for field in (weights, heights, squares)]

    def products(one: int, other: int) -> Map:
        near = np.fft.irfft2((waves[one] * waves[other].conj()).real, s=[size, size])
        return np.take(np.take(near, np.arange(-lags, lags + 1), axis=0), np.arange(-lags, lags + 1), axis=1)

    pairs = products(0, 0)
    seen = pairs > 1e-6 * pairs.max(initial=0.0)
    number = np.maximum(pairs, 1e-300)
    variance = products(0, 2) / number
    usual = float(np.sum(variance * pairs * seen) / np.sum(pairs * seen))
    return np.where(seen, products(1, 1) / number - (variance - usual), 0.0), usual


@dataclass(frozen=True)
class _Tail:
    """Phillips's law (level + Σ turned cos 2θ, sin 2θ) k⁻⁴ of short waves, and the power of all waves with it."""

    level: Map  # (3,): the mean, and the parts that go with cos 2θ and sin 2θ
    power: Map  # of the heights as measured: as the footprint leaves it
    surely: float  # the mean, less its standard error


def _completed(covariance: Map, blur: float, fade: Map, limit: float) -> tuple[Map, float]:
    """The covariance at lags of _FINE up to _TABLE, and the variance of slopes.

    covariance: at lags of _SIDE, 0 up to _ERRORS_M, of heights that are means over areas of variance blur [m²] a side;
    fade: what it was multiplied by; limit [rad/m]: beyond which waves follow Phillips's law.
    """
    count = covariance.shape[0]
    k, twice = _waves(count, _SIDE)
    power = _transformed(np.fft.ifftshift(covariance))
    short_lags = _power_of_short_lags(count)
    damped = np.exp(-(k**2) * blur)
    tails = [_tail(power, short_lags, k, twice, damped, (share * limit, limit), fade) for share in _SATURATED]
    tail = max(tails, key=lambda each: each.surely)
    times = round(_SIDE / _FINE)
    fine, twice = _waves(count * times, _FINE)
    law = sum(level * each for level, each in zip(tail.level, (1.0, *twice), strict=True))
    whole = np.fft.fftshift(np.where(fine < limit, 0.0, np.maximum(law, 0.0) / np.maximum(fine, limit) ** 4))
    first = (count * times - count) // 2
    inner, long = whole[first : first + count, first : first + count], np.fft.fftshift(k < limit)
    inner[long] = _possible(np.fft.fftshift(tail.power / np.maximum(damped, 1e-3))[long])
    about = slice(*(np.flatnonzero(long.any(axis=0))[[0, -1]] + np.array([-_MARGIN, _MARGIN + 1])).clip(0, count))
    inner[about, about][long[about, about]] = _sharpened(inner[about, about], count)[long[about, about]]
    table = np.fft.fftshift(_transformed(np.fft.ifftshift(whole), back=True)) * times**2
    middle, reach = whole.shape[0] // 2, min(round(_TABLE / _FINE), whole.shape[0] // 2)
    near = np.ascontiguousarray(table[middle - reach : middle + reach + 1, middle - reach : middle + reach + 1])
    # The table's waves, and those of the law that are shorter: ∫ k⁻⁴ ½ k² d²k.
    carried = np.fft.fftshift(np.where(fine < np.pi / _FINE, 0.5 * fine**2, 0.0))
    slopes = float(np.sum(whole * carried))
    slopes += np.pi * (count * _SIDE / (2.0 * np.pi)) ** 2 * max(0.0, tail.level[0]) * np.log(2.0 * _FINE / _FINEST)
    return near, float(slopes) / count**2


def _transformed(values: Map, back: bool = False) -> Map:
    """Of what is real and even, and so is its transform: half of it tells the rest, and both ways are alike."""
    half = values[:, : values.shape[1] // 2 + 1]
    return np.asarray(scipy.fft.irfft2(half, s=values.shape, norm="backward" if back else "forward"))


def _tail(
    power: Map,
    short_lags: Map,
    k: Map,
    twice: tuple[Map, Map],
    damped: Map,
    between: tuple[float, float],
    fade: Map,
) -> _Tail:
    """The law that waves between two wavenumbers have, with those covariances at short lags that continue it.

    power: without the short lags, of which each adds its covariance times a row of `short_lags`; damped: the share of
    each wave's power that the footprint leaves. All (wave, wave), short_lags (lag, wave, wave).
    """
    band, short = (k >= between[0]) & (k < between[1]), k >= between[1]
    lawful = np.sum(damped[band] / k[band] ** 4)
    moments = np.stack((np.ones(k.shape), 2.0 * twice[0], 2.0 * twice[1]))[:, band] / lawful
    law = np.stack((np.ones(k.shape), *twice), axis=-1)[short] * (damped[short] / k[short] ** 4)[:, None]
    # Linear in the lags, by least squares: what they leave of short waves is the law of what they leave in the band.
    off = short_lags[:, short].T - law @ (moments @ short_lags[:, band].T)
    lags = np.linalg.lstsq(off, law @ (moments @ power[band]) - power[short], rcond=None)[0]
    power = power + np.tensordot(lags, short_lags, 1)
    level = moments @ power[band]
    # Faded lags leave fewer independent waves than there are.
    alike = fade.size / np.sum(fade**2)
    silent = k > min(_SILENT * between[1], 0.9 * float(k.max()))
    noise = np.sqrt(np.mean(power[silent] ** 2) * np.count_nonzero(band) * alike) / lawful
    return _Tail(level, power, float(level[0] - noise))


@lru_cache(maxsize=1)
def _power_of_short_lags(count: int) -> Map:
    """Power (lag, wave, wave) that a covariance of 1 at each lag shorter than _ERRORS_M adds, and at its opposite."""
    most = int(_ERRORS_M / _SIDE)
    near = [(i, j) for i in range(most + 1) for j in range(-most, most + 1) if (i, j) >= (0, 0)]
    near = [(i, j) for i, j in near if np.hypot(i, j) * _SIDE < _ERRORS_M]
    angle = 2.0 * np.pi * np.fft.fftfreq(count)
    return np.stack([(2.0 if i or j else 1.0) * np.cos(angle[:, None] * i + angle * j) for i, j in near])


def _sharpened(power: Map, count: int) -> Map:
    """The power spectrum (wave, wave) as it was before the fade of long lags blurred it.

    Blurred, a peak of long waves has power at shorter ones, and the sea is too steep. By the iteration of Richardson
    (1972) and Lucy (1974), which makes no power negative. count: waves a side of the whole spectrum.
    """
    blur = count * _SIDE * 4.0 / (2.0 * np.pi * _REACH)  # of exp(−8 d²/_REACH²), in waves
    found = power
    for _ in range(_SHARPENINGS):
        ratio = power / np.maximum(gaussian_filter(found, blur), np.finfo(np.float64).tiny)
        found = found * gaussian_filter(ratio, blur)
    return found


@lru_cache(maxsize=4)
def _waves(count: int, spacing: float) -> tuple[Map, tuple[Map, Map]]:
    """Wavenumbers [rad/m] (wave, wave) of a discrete Fourier transform, cos 2θ and sin 2θ of their directions."""
    k = 2.0 * np.pi * np.fft.fftfreq(count, spacing)
    east, north = k[:, None], k[None, :]
    square = np.maximum(east**2 + north**2, 1e-12)
    return np.sqrt(square), ((east**2 - north**2) / square, 2.0 * east * north / square)


def _possible(power: Map) -> Map:
    """The nearest of the same sum with no negative one: less by one level at all of them."""
    down = np.sort(power, axis=None)[::-1]
    if not down.sum() > 0.0:
        return np.zeros(power.shape)
    less = (np.cumsum(down) - down.sum()) / np.arange(1, down.size + 1)
    level = less[np.flatnonzero(down > less)[-1]]
    return np.maximum(power - level, 0.0)


@compiled
def blur_rows(field, weights, blurred):
    """Write into blurred (row, column) the means of each row and its neighbours; beyond the edges those at them stand.

    weights (neighbour,): of the row itself, and of either row 1, 2 … away.
    """
    rows, columns = field.shape
    for i in range(rows):
        own, middle = blurred[i], field[i]
        for j in range(np.uint64(columns)):
            own[j] = weights[0] * middle[j]
        for n in range(1, weights.size):
            before, behind, weight = field[max(0, i - n)], field[min(rows - 1, i + n)], weights[n]
            for j in range(np.uint64(columns)):
                own[j] += weight * (before[j] + behind[j])
