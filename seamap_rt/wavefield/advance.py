"""Ground maps at one instant: the antenna scans, so each cell has its own time; the waves between them are known.

A map is a sum of waves, and each runs on by linear dispersion, ω = √(g k tanh kh) + k·U (Airy 1845) on water of depth h
and current U. The map as it is seen is what those waves make of each cell at its own time; its adjoint, every cell's
share of each wave brought to the one instant, is nearly its inverse, for the beam passes the waves much faster than
they run. What is left is due to the energy, which moves with the groups: they gather or spread out where the scan runs
with them or against them, carry unknown cells along, and are seen twice or never where the turn closes.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
import scipy.fft
from numpy.typing import NDArray
from scipy.ndimage import gaussian_filter

from ..physics.dispersion import DEEP_WATER, Water
from ..radar.waveform import next_fast_len
from .wave_direction import Travel, wavevectors

_FILL_CELLS = 1.0  # standard deviation of the Gaussian whose mean fills a gap; wider ones flatten the waves
_LEAST_SHARE = 0.5  # of what comes to a cell: is less known, the answer is mostly extrapolated
_RUNS_APART = 0.5  # of the group velocity: what parts of a wave that is cut short differ by
_MARGIN_M, _FASTEST_GROUP = 20.0, 10.0  # the longest waves of note take some 13 s, whose groups run 10 m/s


@dataclass(frozen=True)
class GroundFields:
    """A ground map's fields, arrays (y, x) in float64: height and its standard error [m], slopes, each cell's time [s],
    the slopes' standard errors, if there are any; NaN where nothing is known."""

    height: NDArray[np.float64]
    height_std: NDArray[np.float64]
    slope_x: NDArray[np.float64]
    slope_y: NDArray[np.float64]
    time: NDArray[np.float64]
    slope_x_std: NDArray[np.float64] | None = None
    slope_y_std: NDArray[np.float64] | None = None


def advanced(ground: GroundFields, side: float, to_s: float, travel: Travel, water: Water = DEEP_WATER) -> GroundFields:
    """The same map as the sea stood at the one instant to_s [s].

    side: of a square cell [m]; rows run north, columns east. travel: which way the waves of each length run; none are
    taken to run against it. water: that they run on. The fewer periods lie between to_s and the cells' own
    times, the better; at its own time a cell stays as it is. Small gaps are filled by their neighbours' mean, at the
    cost of a larger height_std; where less than half of what arrives comes from known cells there is NaN.
    Raises ValueError for fields of unlike shapes, a side that is not positive, and an instant that is not finite.
    """
    _check(ground, side, to_s)
    timed = np.isfinite(ground.time)
    lapse = np.where(timed, to_s - ground.time, 0.0)
    if not np.any(lapse):
        return ground
    known = timed & np.isfinite(ground.height)
    height = _filled(ground.height, known)[0]
    scan = _Scan.of(np.where(timed, ground.time, to_s), side, to_s, travel, water)
    groups = [_Groups.of(lapse * east / side, lapse * north / side) for east, north in scan.group_velocities(height)]
    spread, share = _spread(ground.height, ground.height_std, known, groups)
    answered = timed & (_carried(known, groups) >= _LEAST_SHARE)
    sloped = timed & np.isfinite(ground.slope_x) & np.isfinite(ground.slope_y)
    tilted = timed & (_carried(sloped, groups) >= _LEAST_SHARE)
    slopes, errors = [], []
    for field, std in ((ground.slope_x, ground.slope_x_std), (ground.slope_y, ground.slope_y_std)):
        error, slope_share = _spread(field, np.zeros(field.shape) if std is None else std, sloped, groups)
        slopes.append(np.where(tilted, scan.brought(_filled(field, sloped)[0]) / slope_share, np.nan))
        errors.append(None if std is None else np.where(tilted, error, np.nan))
    return GroundFields(
        np.where(answered, scan.brought(height) / share, np.nan),
        np.where(answered, spread, np.nan),
        slopes[0],
        slopes[1],
        np.where(timed, to_s, np.nan),
        errors[0],
        errors[1],
    )


@dataclass(frozen=True)
class _Scan:
    """How the cells' own times and the one instant are tied: the waves' turns are followed exactly from a few moments,
    and between those by the polynomial through them, whose weights (moment, y, x) sum to 1 at each cell."""

    weights: NDArray[np.float64]
    turns: NDArray[np.complex128]  # (moment, row, column) of each wave of the padded map's half spectrum
    group_east: NDArray[np.float64]  # (row, column) m/s, of each wave
    group_north: NDArray[np.float64]
    padded: tuple[int, int]

    @classmethod
    def of(cls, time: NDArray[np.float64], side: float, to_s: float, travel: Travel, water: Water) -> _Scan:
        first, last = float(time.min()), float(time.max())
        middle, half = 0.5 * (first + last), 0.5 * (last - first)
        # What runs off the map must not come in again at its other side.
        fastest = _FASTEST_GROUP + float(np.hypot(*water.current))
        pad = int(np.ceil((_MARGIN_M + fastest * max(abs(to_s - first), abs(to_s - last))) / side))
        rows, columns = (next_fast_len(size + pad) for size in time.shape)
        east, north = wavevectors(side, (rows, columns))
        k = np.hypot(east, north)
        moving = np.maximum(k, 1e-12)
        forth = travel.travel_sign(east, north)
        omega = forth * water.frequency(k) + water.doppler_shift(east, north)
        # Chebyshev's moments: each beyond half the swing of the fastest wave more than halves the error.
        nodes = _chebyshev_nodes(int(np.ceil(half * np.abs(omega).max())) + 4 if half > 0.0 else 1)
        weights = _lagrange(nodes, (time - middle) / (half or 1.0))
        lapses = to_s - middle - half * nodes
        turns = np.exp(-1j * omega * lapses[:, None, None])
        ahead = forth * np.where(k > 0.0, water.group_speed(moving), 0.0) / moving
        group_east, group_north = ahead * east + water.current[0], ahead * north + water.current[1]
        return cls(weights, turns, group_east, group_north, (rows, columns))

    def brought(self, field: NDArray[np.float64]) -> NDArray[np.float64]:
        """A field (y, x) of the cells' own times, 0 where unknown, brought to the instant wave by wave."""
        spectrum = np.zeros(self.turns.shape[1:], dtype=np.complex128)
        for weight, turn in zip(self.weights, self.turns, strict=True):
            spectrum += turn * scipy.fft.rfft2(weight * field, s=self.padded)
        rows, columns = field.shape
        return np.asarray(scipy.fft.irfft2(spectrum, s=self.padded))[:rows, :columns]

    def group_velocities(self, height: NDArray[np.float64]) -> list[NDArray[np.float64]]:
        """Four group velocities (2,) [m/s], east and north, with the mean and the spread of the main waves' own.

        Power squared weighs the peaks, not the noise about them.
        """
        power = np.abs(np.asarray(scipy.fft.rfft2(height, s=self.padded))) ** 4
        power[0, 0] = 0.0
        if not power.any():
            return [np.zeros(2)]
        power /= power.sum()
        own = (self.group_east, self.group_north)
        mean = np.array([(power * part).sum() for part in own])
        spread = np.array([[(power * one * other).sum() for one in own] for other in own]) - np.outer(mean, mean)
        # At the edge of a gap waves are cut short: they run apart as if they had all lengths.
        spread += np.eye(2) * (_RUNS_APART**2 * mean @ mean)
        size, axes = np.linalg.eigh(spread)
        steps = np.sqrt(2.0 * np.maximum(size, 0.0)) * axes
        return [mean + step for step in (*steps.T, *-steps.T)]


@dataclass(frozen=True)
class _Groups:
    """Where each cell's energy goes: the cells (corner, cell) it is shared among, of a map with a frame about it for
    what leaves it, and their shares."""

    cells: NDArray[np.intp]
    shares: NDArray[np.float64]

    @classmethod
    def of(cls, east: NDArray[np.float64], north: NDArray[np.float64]) -> _Groups:
        """east, north: how far each cell's energy goes (y, x), in cells."""
        rows, columns = east.shape
        x = np.clip(np.arange(1, columns + 1) + east, 0.0, columns + 0.999).ravel()
        y = np.clip(np.arange(1, rows + 1)[:, None] + north, 0.0, rows + 0.999).ravel()
        left, low = x.astype(np.intp), y.astype(np.intp)
        right, high = x - left, y - low
        cell, above = low * (columns + 2) + left, columns + 2
        shares = ((1.0 - right) * (1.0 - high), right * (1.0 - high), (1.0 - right) * high, right * high)
        return cls(np.stack((cell, cell + 1, cell + above, cell + above + 1)), np.stack(shares))

    def carried(self, field: NDArray) -> NDArray[np.float64]:
        """Share of a field (y, x) that has come to each cell (y, x)."""
        rows, columns = field.shape
        come = np.bincount(self.cells.ravel(), (self.shares * field.ravel()).ravel(), (rows + 2) * (columns + 2))
        return np.asarray(come, dtype=np.float64).reshape(rows + 2, columns + 2)[1:-1, 1:-1]


def _carried(field: NDArray, groups: list[_Groups]) -> NDArray[np.float64]:
    """Share of a field that has come to each cell, the mean over several groups."""
    return np.mean([each.carried(field) for each in groups], axis=0)


def _spread(
    field: NDArray[np.float64], std: NDArray[np.float64], known: NDArray[np.bool_], groups: list[_Groups]
) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
    """Standard error (y, x) of a field that is brought to the instant, and the share of it that arrives.

    Filled cells lack what their neighbours do not hold; where groups part or meet, what each of them misses or doubles
    is in doubt.
    """
    stated, weight = _filled(np.nan_to_num(std) ** 2, known)
    arrives = np.array([each.carried(weight) for each in groups])
    share = np.maximum(arrives.mean(axis=0), _LEAST_SHARE)
    sea = _sea_variance(field[known], std[known])
    variance = _carried(stated + weight * (1.0 - weight) * sea, groups) / share
    variance += sea * ((1.0 - arrives / share) ** 2).mean(axis=0)
    return np.sqrt(variance), share


def _filled(field: NDArray[np.float64], known: NDArray[np.bool_]) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
    """A field times its weight, and the weight: 1 where known, in gaps the share that the neighbours' mean holds."""
    values = np.where(known, field, 0.0)
    share = gaussian_filter(known.astype(np.float64), _FILL_CELLS, mode="constant", truncate=3.0)
    mean = gaussian_filter(values, _FILL_CELLS, mode="constant", truncate=3.0)
    return np.where(known, values, mean), np.where(known, 1.0, share)


def _sea_variance(height: NDArray[np.float64], height_std: NDArray[np.float64]) -> float:
    """Variance of the sea's heights [m²] or slopes over known cells: what they vary beyond their own error."""
    if not height.size:
        return 0.0
    return max(0.0, float(np.mean(height**2) - np.mean(np.nan_to_num(height_std) ** 2)))


def _chebyshev_nodes(count: int) -> NDArray[np.float64]:
    return np.cos(np.pi * (np.arange(count) + 0.5) / count)


def _lagrange(nodes: NDArray[np.float64], at: NDArray[np.float64]) -> NDArray[np.float64]:
    """Weights (node, …) by which values at the nodes make up the polynomial through them."""
    weights = np.ones((nodes.size, *at.shape))
    for one, node in enumerate(nodes):
        for other in np.delete(nodes, one):
            weights[one] *= (at - other) / (node - other)
    return weights


def _check(ground: GroundFields, side: float, to_s: float) -> None:
    if not 0.0 < side < np.inf:
        raise ValueError(f"side = {side:g}: must be positive and finite; give the side of a ground cell in metres")
    if not np.isfinite(to_s):
        raise ValueError(f"to_s = {to_s:g}: must be finite; give an instant near the map's times in seconds")
    shapes = {np.shape(field) for field in vars(ground).values() if field is not None}
    if len(shapes) != 1 or len(next(iter(shapes))) != 2:
        raise ValueError(f"ground = fields of shapes {sorted(shapes)}: must be one shape (y, x); give them on one grid")


__all__ = ["GroundFields", "advanced"]
