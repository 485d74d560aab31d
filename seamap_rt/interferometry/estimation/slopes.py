"""Slopes by weighted local planes: differencing neighbouring cells would amplify their noise."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike, NDArray

from ...compute.machine import in_blocks
from .quality import gate_median
from .slope_kernel import fit_planes

Pair = tuple[NDArray[np.float64], NDArray[np.float64]]

_TOLERATED = 0.015, 0.02  # height error over half a plane's length and width
_HALF_LENGTH = 4.5, 21.0  # m: at least, at most
_HALF_WIDTH = 2.0, 6.0  # looks


@dataclass(frozen=True)
class Slopes:
    """Outward and clockwise slopes (look, gate), NaN where the neighbours span no plane, and their standard errors."""

    outward: NDArray[np.float64]
    clockwise: NDArray[np.float64]
    outward_std: NDArray[np.float64] | None = None
    clockwise_std: NDArray[np.float64] | None = None


def local_planes(
    height: NDArray[np.float64],
    weight: NDArray[np.float64],
    ground: Pair,
    outward: Pair,
    reach: tuple[ArrayLike, ArrayLike],
    height_std: NDArray[np.float64] | None = None,
    correlation: tuple[ArrayLike, ArrayLike] = (1.0, 1.0),
) -> Slopes:
    """Slopes outward and clockwise of the plane fitted to each cell's neighbours, all of it (look, gate).

    height [m] and weight; cells that are not finite or weigh nothing count nothing, and have no slope. `ground`: x and
    y [m] of the cells. `outward`: east and north of each cell's own direction; they broadcast. `reach`: how many gates
    and looks away weights have fallen to zero, by 1 − (distance/reach)² in either, (gate,) or one number each; no more
    than 1 is the cell's own. The first and the last look of a circle are no neighbours: they lie a turn apart in time.

    Standard errors where height_std [m] is given: of what heights err, not of waves shorter than the planes, which
    they smooth. `correlation`: of the errors of heights 0, 1, 2 … gates apart, and looks; left out, each errs for
    itself. It counts as it does in a whole neighbourhood, evenly weighted.
    """
    pieces = np.broadcast_arrays(height, weight, *ground, *outward)
    known = np.all(np.isfinite(pieces), axis=0) & (pieces[1] > 0.0)
    z, w, *rest = (np.where(known, part, 0.0) for part in pieces)
    shape = z.shape
    limits = np.stack([np.broadcast_to(np.asarray(each, dtype=np.float64), shape[1]) for each in reach])
    slopes = np.full((2, *shape), np.nan)
    variance, squares = np.empty((0, 0)), np.empty((0, 0, 0))
    if height_std is not None:
        variance, squares = np.where(known, height_std, 0.0) ** 2, np.full((2, *shape), np.nan)
    points, away = np.stack(rest[:2]), np.stack(rest[2:])
    in_blocks(lambda *looks: fit_planes(*looks, z, w, points, away, limits, variance, slopes, squares), shape[0])
    if height_std is None:
        return Slopes(*slopes)
    for odd in (0, 1):  # the axis along which the slope is taken
        for axis in (0, 1):
            squares[odd] *= _alike(limits[axis], np.atleast_1d(correlation[axis]), axis == odd)
    return Slopes(*slopes, *np.sqrt(squares))


def plane_reach(height_std: NDArray[np.float64], ranges: NDArray[np.float64], spacing: float, width_deg: float) -> Pair:
    """Reach (gate,) in gates and looks of planes that are as small as the heights' errors (look, gate) [m] let them be.

    Small planes follow short waves, and noise: the half-length is 1/0.015 of the gate's median error, the half-width
    1/0.02, of what waves of ordinary steepness bear. ranges [m] (gate,) `spacing` apart, looks width_deg apart.
    """
    error = gate_median(height_std, np.isfinite(height_std))[0]
    along = np.clip(error / _TOLERATED[0], *_HALF_LENGTH) / spacing
    across = np.clip(error / _TOLERATED[1] / (ranges * np.radians(width_deg)), *_HALF_WIDTH)
    return np.maximum(along, 2.0), across


def _alike(reach: NDArray[np.float64], correlation: NDArray[np.float64], odd: bool) -> NDArray[np.float64]:
    """By how much (gate,) the variance of a slope grows where neighbours err alike along one axis.

    Heights pull at the slope by the taper times the distance (odd) along it, and by the taper alone across it.
    """
    most = int(np.ceil(reach.max(initial=1.0)))
    step = np.arange(-most, most + 1) / reach[:, None]
    pull = np.maximum(1.0 - step**2, 0.0) * (step if odd else 1.0)
    own = np.sum(pull**2, axis=1)
    growth = np.ones(reach.size)
    for lag in range(1, min(correlation.size, 2 * most)):
        beside = np.sum(pull[:, lag:] * pull[:, :-lag], axis=1)
        growth += 2.0 * correlation[lag] * np.divide(beside, own, out=np.zeros_like(own), where=own > 0.0)
    return np.maximum(growth, 0.0)
